#!/usr/bin/env python3
"""Clients that are not ours, and another user of the machine, before a server with tokens and TLS: `strangers.py BAUDBOT`.

Certificates are by `openssl req`. `openssl s_client`, `buf curl`, `curl` and grpcio must get in with the right authority and token, and words
without. As root it also does what another user of the machine can try.
"""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import grpc

ROOT = pathlib.Path(__file__).parents[2]
BUF = ROOT / "xtask/tools/node_modules/.bin/buf"
LIST = "baudbot.v1.ControlService/ListWorlds"
NEEDED, UNKNOWN = "a token is needed here", "the token is not valid on this server"
#: The user `nobody` of Debian.
NOBODY = 65534


def said(*command: str, code: int | None = 0, **more: object) -> str:
    """What a command says on either stream. It does not hang, and ends with this code, or with another one than 0."""
    streams = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT} | more
    done = subprocess.run(command, text=True, timeout=60, **streams)
    fits = done.returncode == code if code is not None else done.returncode != 0
    assert fits, (command, done.returncode, done.stdout)
    return done.stdout


def certificates(folder: pathlib.Path, name: str) -> tuple[pathlib.Path, pathlib.Path, pathlib.Path]:
    """A certificate for localhost, its key, and the authority's certificate, by OpenSSL."""
    ca, ca_key, cert, key, request = (folder / f"{name}{end}" for end in ("-ca.pem", "-ca-key.pem", ".pem", "-key.pem", ".csr"))
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    said("openssl", "req", "-x509", *curve, "-subj", f"/CN={name} authority", "-days", "2", "-keyout", str(ca_key), "-out", str(ca))
    said("openssl", "req", *curve, "-subj", "/CN=localhost", "-keyout", str(key), "-out", str(request))
    (folder / "names").write_text("subjectAltName = DNS:localhost, IP:127.0.0.1\n")
    signed = ["-CA", str(ca), "-CAkey", str(ca_key), "-CAcreateserial", "-days", "1", "-extfile", str(folder / "names")]
    said("openssl", "x509", "-req", "-in", str(request), *signed, "-out", str(cert))
    return cert, key, ca


@contextmanager
def served(baudbot: str, *options: str, home: pathlib.Path) -> Iterator[list[str]]:
    """A server, and the lines that it says at its start."""
    listen = ["serve", "wander", "--listen", "127.0.0.1:0", "--viewer", "127.0.0.1:0"]
    environment = os.environ | {"XDG_RUNTIME_DIR": str(home)}
    server = subprocess.Popen([baudbot, *listen, *options], stdout=subprocess.PIPE, text=True, env=environment)
    lines = []
    try:
        for line in server.stdout:
            lines.append(line.strip())
            ports = sum(line.startswith("serial port") for line in lines)
            if any(line.startswith("Ctrl-C") for line in lines) and ports == options.count("--port"):
                break
        yield lines
    finally:
        server.terminate()
        assert server.wait(timeout=30) == 0


def place(lines: Sequence[str], pattern: str) -> str:
    return next(found[1] for line in lines if (found := re.match(pattern, line)))


def over_tls(baudbot: str, folder: pathlib.Path) -> None:
    cert, key, ca = certificates(folder, "lab")
    _, _, other_ca = certificates(folder, "elsewhere")
    tokens = str(folder / "tokens.toml")
    token = said(baudbot, "token", "new", "--name", "ann", "--observe", "--file", tokens, stderr=subprocess.DEVNULL).strip()
    wrong = said(baudbot, "token", "new", "--name", "eve", "--observe", "--file", str(folder / "others.toml"), stderr=subprocess.DEVNULL).strip()
    with served(baudbot, "--tokens", tokens, "--tls", f"{cert},{key}", home=folder) as lines:
        address, page = place(lines, r"listening on (\S+)"), place(lines, r"open in a browser: (https://[^/]+)/")
        with_openssl(address, ca, other_ca)
        with_buf(address, ca, other_ca, token, wrong)
        with_grpcio(address, ca, other_ca, token, wrong)
        with_curl(page, ca, other_ca, token)


def with_openssl(address: str, ca: pathlib.Path, other_ca: pathlib.Path) -> None:
    look = ["openssl", "s_client", "-connect", address, "-alpn", "h2", "-verify_return_error", "-CAfile"]
    text = said(*look, str(ca))
    assert "Verify return code: 0 (ok)" in text and "ALPN protocol: h2" in text and "TLSv1.3" in text, text
    assert "verify error" in said(*look, str(other_ca), code=None)
    assert "TLSv1.2" in said(*look, str(ca), "-tls1_2")
    print("openssl s_client: the right authority verifies it, another one does not; TLS 1.3 and 1.2")


def with_buf(address: str, ca: pathlib.Path, other_ca: pathlib.Path, token: str, wrong: str) -> None:
    def curl(ca: pathlib.Path, *headers: str, code: int | None = 0) -> str:
        call = ["curl", "--schema", str(ROOT / "proto"), "--protocol", "grpc", "--cacert", str(ca), "-d", "{}"]
        shown = [part for header in headers for part in ("-H", header)]
        return said(str(BUF), *call, *shown, f"https://{address}/{LIST}", code=code)

    assert '"wander"' in curl(ca, f"authorization: Bearer {token}")
    assert NEEDED in curl(ca, code=None)
    assert UNKNOWN in curl(ca, f"authorization: Bearer {wrong}", code=None)
    assert "certificate" in curl(other_ca, f"authorization: Bearer {token}", code=None)
    print("buf curl: right and wrong tokens and authorities")


def with_grpcio(address: str, ca: pathlib.Path, other_ca: pathlib.Path, token: str, wrong: str) -> None:
    def call(ca: pathlib.Path, metadata: Sequence[tuple[str, str]] = ()) -> grpc.StatusCode | bytes:
        with grpc.secure_channel(address, grpc.ssl_channel_credentials(ca.read_bytes())) as channel:
            try:
                return channel.unary_unary(f"/{LIST}")(b"", metadata=metadata, timeout=10)
            except grpc.RpcError as error:
                return error.code()

    answer = call(ca, [("authorization", f"Bearer {token}")])
    assert isinstance(answer, bytes) and b"wander" in answer, answer
    for shown in ([], [("authorization", f"Bearer {wrong}")], [("authorization", token)], [("authorization", "Bearer ")]):
        assert call(ca, shown) is grpc.StatusCode.UNAUTHENTICATED, shown
    assert call(other_ca, [("authorization", f"Bearer {token}")]) is grpc.StatusCode.UNAVAILABLE
    print("grpcio: right and wrong tokens and authorities")


def with_curl(page: str, ca: pathlib.Path, other_ca: pathlib.Path, token: str) -> None:
    look = ["curl", "--silent", "--show-error", "--max-time", "20"]
    assert "<!doctype html>" in said(*look, "--cacert", str(ca), page)
    assert NEEDED in said(*look, "--cacert", str(ca), f"{page}/metrics")
    assert "baudbot_world" in said(*look, "--cacert", str(ca), "-H", f"Authorization: Bearer {token}", f"{page}/metrics")
    assert "certificate" in said(*look, "--cacert", str(other_ca), page, code=60)
    plain = said(*look, page.replace("https", "http"))
    assert "this server speaks TLS: use https://" in plain, plain
    print("curl: the page and its metrics, and what who speaks without TLS is told")


def by_another_user(baudbot: str, folder: pathlib.Path) -> None:
    """What another user of the machine can try, without a token."""
    if os.geteuid() != 0:
        print("another user: NOT CHECKED (only root can be somebody else)")
        return
    # Where the other one may read the program, and write something of its own.
    theirs = pathlib.Path(tempfile.mkdtemp())
    os.chown(theirs, NOBODY, NOBODY)
    program = str(shutil.copy(baudbot, theirs / "baudbot"))
    folder.chmod(0o755)

    def tries(*command: str) -> str:
        return said("setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *command, code=None, cwd=theirs)

    socket, pty = folder / "socket", folder / "robot.tty"
    ports = ["--port", f"robot=pty:{pty}", "--port", "robot=tcp:0", "--port", f"robot=unix:{folder / 'robot.sock'}"]
    with served(baudbot, "--listen", f"unix:{socket}", *ports, home=folder) as lines:
        address, link = place(lines, r"listening on (127\S+)"), place(lines, r"open in a browser: (http://[^/]+)/")
        port = place(lines, r"serial port of \S+: tcp:(\S+)")
        assert NEEDED in tries(program, "watch", "--once", "--connect", address)
        assert NEEDED in tries(program, "brain", "avoid", "--connect", address, "--world", "wander", "--robot", "robot")
        assert "there is no token of yours" in tries(program, "token", "local", "--connect", address)
        for file in [*(folder / "baudbot").iterdir(), pty, folder / "robot.sock"]:
            assert "ermission denied" in tries("cat", str(file)) or "No such device" in tries("cat", str(file)), file
        assert "ermission denied" in tries(program, "watch", "--once", "--connect", f"unix:{socket}")
        assert NEEDED in said("setpriv", f"--reuid={NOBODY}", "curl", "--silent", f"{link}/metrics")
        come = "import socket, sys; s = socket.create_connection(sys.argv[1].rsplit(':', 1)); s.settimeout(10); sys.exit(len(s.recv(9)) or 7)"
        done = subprocess.run(["setpriv", f"--reuid={NOBODY}", "/usr/bin/python3", "-c", come, port], timeout=60)
        assert done.returncode in (1, 7), "a port over TCP sends others away"
    ask_chip = come.replace("s.settimeout", "s.sendall(b'$?#3f'); s.settimeout")
    run = [baudbot, "run", "firmware", "--gdb", "robot=0", "--pace", "real-time", "--seconds", "60"]
    with subprocess.Popen(run, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as debugged:
        try:
            chip = place([debugged.stderr.readline()], r".*'target remote ([\d.:]+)'")
            done = subprocess.run(["setpriv", f"--reuid={NOBODY}", "/usr/bin/python3", "-c", ask_chip, chip], timeout=60)
            assert done.returncode in (1, 7), "a debugger's port sends others away"
        finally:
            debugged.kill()
    shutil.rmtree(theirs)
    print("another user of the machine: gRPC, the page, metrics, files, sockets, ports and the debugger's are closed")


def main() -> None:
    baudbot = os.path.realpath(sys.argv[1])
    for check in (over_tls, by_another_user):
        with tempfile.TemporaryDirectory() as folder:
            check(baudbot, pathlib.Path(folder))


if __name__ == "__main__":
    main()
