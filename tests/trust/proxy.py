#!/usr/bin/env python3
"""A server behind nginx, as `deploy/proxy/nginx.conf` has it: `proxy.py BAUDBOT`.

The file is used as it stands, with the names, places and ports of this test. Brains, grpcio, curl and a WebSocket go through it, with and without
the right token; a connection makes more calls than nginx grants one by default.
"""

from __future__ import annotations

import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

import grpc
from deployment import free_port
from strangers import LIST, NEEDED, certificates, place, said, served

SITE = pathlib.Path(__file__).parents[2] / "deploy/proxy/nginx.conf"
#: More than the thousand after which nginx ends a connection unless it is told otherwise.
CALLS = 1200


def site(folder: pathlib.Path, port: int, grpc_address: str, page_address: str) -> str:
    """The file, adapted as its reader adapts it."""
    cert, key, _ = certificates(folder, "lab")
    text = SITE.read_text()
    for theirs, ours in {
        "listen 443": f"listen 127.0.0.1:{port}",
        "robots.example": "localhost",
        "/etc/baudbot/server.pem": str(cert),
        "/etc/baudbot/server-key.pem": str(key),
        "127.0.0.1:7400": grpc_address,
        "127.0.0.1:7401": page_address,
    }.items():
        assert text.count(theirs) == 1, theirs
        text = text.replace(theirs, ours)
    return text


@contextmanager
def nginx(folder: pathlib.Path, text: str, port: int) -> Iterator[None]:
    (folder / "site.conf").write_text(text)
    user = "user root;" if os.geteuid() == 0 else ""
    places = " ".join(f"{kind}_temp_path {folder}/{kind};" for kind in ("client_body", "proxy", "fastcgi", "scgi", "uwsgi"))
    main = f"""daemon off; pid {folder}/pid; {user} events {{ worker_connections 512; }}
        http {{ access_log off; {places} include {folder}/site.conf; }}"""
    (folder / "nginx.conf").write_text(main)
    command = ["nginx", "-c", str(folder / "nginx.conf"), "-e", str(folder / "error.log")]
    said(*command, "-t")
    with subprocess.Popen(command) as program:
        try:
            listens(port)
            yield
        finally:
            program.send_signal(signal.SIGQUIT)
            assert program.wait(timeout=30) == 0
    lines = (folder / "error.log").read_text().splitlines()
    errors = [line for line in lines if "[error]" in line or "[alert]" in line]
    assert len(errors) == 1 and "client intended to send too large body" in errors[0], errors


def listens(port: int) -> None:
    """Waits until somebody does at this port."""
    for _ in range(300):
        try:
            socket.create_connection(("127.0.0.1", port), timeout=10).close()
            return
        except ConnectionRefusedError:
            time.sleep(0.1)
    raise AssertionError(f"nobody listens at port {port}")


def with_our_programs(baudbot: str, where: list[str], operator: str, driver: str) -> None:
    def stands() -> str:
        return said(baudbot, "watch", "--once", *where, "--token-file", operator).split("robot  ")[-1]

    before = stands()
    command = [baudbot, "brain", "avoid", *where, "--token-file", driver, "--world", "wander", "--robot", "robot"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as brain:
        assert "driving robot of world wander" in brain.stderr.readline()
        for _ in range(300):
            if stands() != before:
                break
            time.sleep(0.1)
        else:
            raise AssertionError("the robot stands")
        brain.send_signal(signal.SIGINT)
        brain.communicate(timeout=30)
    assert NEEDED in said(baudbot, "watch", "--once", *where, code=None)
    print("proxy: a brain drives through it")


def with_grpcio(address: str, ca: pathlib.Path, token: str, driver: str) -> None:
    with grpc.secure_channel(address, grpc.ssl_channel_credentials(ca.read_bytes())) as channel:
        call = channel.unary_unary(f"/{LIST}")
        for _ in range(CALLS):
            assert b"wander" in call(b"", metadata=[("authorization", f"Bearer {token}")], timeout=10)
        for shown, code in ((token[:-1], grpc.StatusCode.UNAUTHENTICATED), (driver, grpc.StatusCode.PERMISSION_DENIED)):
            try:
                call(b"", metadata=[("authorization", f"Bearer {shown}")], timeout=10)
                raise AssertionError(code)
            except grpc.RpcError as error:
                assert error.code() is code, error
    print(f"proxy: grpcio makes {CALLS} calls, and is refused what it may not do")


def with_curl(address: str, ca: pathlib.Path, token: str, folder: pathlib.Path) -> None:
    page = f"https://{address}"
    look = ["curl", "--silent", "--show-error", "--max-time", "20", "--cacert", str(ca)]
    cookies = str(folder / "cookies")
    assert "<!doctype html>" in said(*look, page)
    assert NEEDED in said(*look, f"{page}/metrics")
    session = said(*look, "--include", "--cookie-jar", cookies, "--request", "POST", "-H", f"Authorization: Bearer {token}", f"{page}/session")
    cookie = next(line for line in session.splitlines() if line.lower().startswith("set-cookie"))
    assert {"HttpOnly", "Secure", "SameSite=Strict"} <= {part.strip() for part in cookie.split(";")}, cookie

    def upgraded(*more: str) -> str:
        """The status of an attempt to open the page's socket, which is not waited for."""
        upgrade = ["--http1.1", "--include", "--max-time", "2", "-H", "Connection: Upgrade", "-H", "Upgrade: websocket", "-H", "Sec-WebSocket-Version: 13"]
        done = subprocess.run([*look, *upgrade, "-H", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", *more, f"{page}/page"], capture_output=True, timeout=60)
        return re.match(rb"HTTP/1.1 (\d+)", done.stdout)[1].decode()

    assert upgraded("--cookie", cookies, "-H", f"Origin: {page}") == "101"
    assert upgraded("--cookie", cookies, "-H", "Origin: https://elsewhere.example") == "403"
    assert upgraded("-H", f"Origin: {page}") == "401"
    long = folder / "long"
    long.write_bytes(bytes(2 << 20))
    assert "413" in said(*look, "--data-binary", f"@{long}", f"{page}/session"), "nginx keeps no long request for strangers"
    print("proxy: the page, its session and its socket")


def main() -> None:
    baudbot = os.path.realpath(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tokens = str(folder / "tokens.toml")
        operator, driver = folder / "operator.token", folder / "driver.token"
        for file, rights in ((operator, ["--operate"]), (driver, ["--drive", "wander/robot"])):
            made = said(baudbot, "token", "new", "--name", file.stem, *rights, "--file", tokens, stderr=subprocess.DEVNULL)
            file.touch(mode=0o600)
            file.write_text(made)
        with served(baudbot, "--tokens", tokens, "--behind-proxy", "--host", "localhost", home=folder) as lines:
            own, page = place(lines, r"listening on (\S+)"), place(lines, r"open in a browser: http://([^/]+)/")
            port = free_port()
            with nginx(folder, site(folder, port, own, page), port):
                address, ca = f"localhost:{port}", folder / "lab-ca.pem"
                with_our_programs(baudbot, ["--connect", f"https://{address}", "--ca", str(ca)], str(operator), str(driver))
                with_grpcio(address, ca, operator.read_text().strip(), driver.read_text().strip())
                with_curl(address, ca, operator.read_text().strip(), folder)


if __name__ == "__main__":
    main()
