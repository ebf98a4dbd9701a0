#!/usr/bin/env python3
"""What is in deploy/ for a server that is left running: `deployment.py BAUDBOT`.

The unit is held against `systemd-analyze`, the manifest against Kubernetes' schemas. Then the server is started with the very arguments of
each, with folders of this machine in the place of theirs, asked as the manifest's probes ask, and ended as both end it.
"""

from __future__ import annotations

import pathlib
import re
import shlex
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

import kubernetes_validate
import yaml

ROOT = pathlib.Path(__file__).parents[2]
UNIT = ROOT / "deploy/systemd/baudbot.service"
MANIFEST = ROOT / "deploy/kubernetes/server.yaml"
#: The first version that the manifest is for, and the last whose schema is known.
VERSIONS = ["1.33", "1.37"]
#: The most that `systemd-analyze security` may say, in tenths.
EXPOSURE = 15


def main(program: pathlib.Path) -> None:
    with tempfile.TemporaryDirectory() as place:
        unit(program, pathlib.Path(place))
    resources = list(yaml.safe_load_all(MANIFEST.read_text()))
    for resource in resources:
        for version in VERSIONS:
            kubernetes_validate.validate(resource, version, strict=True)
    print(f"{len(resources)} resources are valid in Kubernetes {' and '.join(VERSIONS)}")
    (deployment,) = [resource for resource in resources if resource["kind"] == "Deployment"]
    pod = deployment["spec"]["template"]["spec"]
    (container,) = pod["containers"]
    probe = container["readinessProbe"]["httpGet"]
    lasts = pod["terminationGracePeriodSeconds"]
    started(program, container["args"], {"/secret": "secret", "/state": "state"}, probe, lasts)
    print("the manifest's server starts, answers its probe, and ends when it is told to")
    folders = {"%d": "secret", "/etc/baudbot": "secret", "/var/lib/baudbot": "state", "/var/log/baudbot": "log"}
    started(program, command(), folders, probe, int(setting("TimeoutStopSec")))
    print("so does the unit's")


def unit(program: pathlib.Path, place: pathlib.Path) -> None:
    """The unit, with this program in the place of an installed one."""
    file = place / UNIT.name
    file.write_text(UNIT.read_text().replace("/usr/local/bin/baudbot", str(program.resolve())))
    subprocess.run(["systemd-analyze", "verify", file], check=True)
    security = ["systemd-analyze", "security", "--offline=true", f"--threshold={EXPOSURE}", file]
    done = subprocess.run(security, check=False, text=True, stdout=subprocess.PIPE)
    assert done.returncode == 0, done.stdout
    print(done.stdout.strip().splitlines()[-1])


def setting(name: str) -> str:
    """A setting of the unit."""
    text = UNIT.read_text().replace("\\\n", " ")
    (value,) = re.findall(rf"^{name}=(.*)$", text, re.MULTILINE)
    return value


def command() -> list[str]:
    """The arguments of the unit's program."""
    return shlex.split(setting("ExecStart"))[1:]


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def started(program: pathlib.Path, arguments: list[str], folders: dict[str, str], probe: dict, lasts: int) -> None:
    """Starts the server, asks it, and ends it."""
    with tempfile.TemporaryDirectory() as name:
        place = pathlib.Path(name)
        for folder in {"secret", "state", "run"} | set(folders.values()):
            (place / folder).mkdir(mode=0o700)
        secrets(program, place / "secret")
        page = free_port()
        here = []
        for argument in arguments:
            for theirs, ours in folders.items():
                argument = argument.replace(theirs, str(place / ours))
            here.append(argument.replace("0.0.0.0:7400", "127.0.0.1:0").replace("0.0.0.0:7401", f"127.0.0.1:{page}"))
        environment = {"XDG_RUNTIME_DIR": str(place / "run"), "HOME": str(place)}
        streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        with subprocess.Popen([program, *here], env=environment, cwd=place, text=True, **streams) as server:
            try:
                ask(server, f"https://127.0.0.1:{page}{probe['path']}", probe)
            finally:
                told = time.monotonic()
                server.send_signal(signal.SIGTERM)
                _, said = server.communicate(timeout=lasts)
            assert server.returncode == 0, (server.returncode, said)
            assert time.monotonic() - told < lasts
        (audit,) = place.glob("*/audit.jsonl")
        assert audit.read_text().splitlines()[-1].count('"stop"') == 1


def secrets(program: pathlib.Path, folder: pathlib.Path) -> None:
    """A certificate of OpenSSL's, and a token."""
    key, certificate = folder / "server-key.pem", folder / "server.pem"
    request = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes"]
    named = ["-subj", "/CN=robots.example", "-addext", "subjectAltName=DNS:robots.example"]
    subprocess.run([*request, *named, "-keyout", key, "-out", certificate], check=True, capture_output=True)
    key.chmod(0o600)
    token = [program, "token", "new", "--file", folder / "tokens.toml", "--name", "teacher", "--operate"]
    subprocess.run(token, check=True, capture_output=True)


def ask(server: subprocess.Popen[str], url: str, probe: dict) -> None:
    """Asks as the kubelet does: by the pod's address, without a look at the certificate."""
    headers = {header["name"]: header["value"] for header in probe["httpHeaders"]}
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    for _ in range(600):
        assert server.poll() is None, server.communicate()
        try:
            with urllib.request.urlopen(urllib.request.Request(url, headers=headers), context=context) as answer:
                assert answer.status == 200, answer.status
                return
        except urllib.error.URLError:
            time.sleep(0.1)
    raise AssertionError(f"{url} does not answer")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]).resolve())
