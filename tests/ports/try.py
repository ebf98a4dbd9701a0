"""Programs of others drive simulated robots over serial ports, without a changed line: `python tests/ports/try.py BAUDBOT`.

Each robot is served with ports, recorded meanwhile, and the recording replayed to the same bits.
"""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
BAUDBOT = os.path.realpath(sys.argv[1])


def served(scenario: str, ports: list[str], programs, folder: str) -> None:
    """Serves a scenario with ports, and runs programs with the places of the ports."""
    recording = os.path.join(folder, scenario + ".mcap")
    command = [BAUDBOT, "serve", str(HERE / f"{scenario}.toml"), "--viewer", "off", "--listen", "127.0.0.1:0"]
    command += ["--record", recording]
    command += [part for port in ports for part in ("--port", port)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=folder)
    try:
        places = []
        while len(places) < len(ports):
            line = server.stdout.readline()
            if not line:
                sys.exit(f"{scenario}: the server has ended")
            found = re.fullmatch(r"serial port of \S+: (\S+).*\n", line)
            if found:
                places.append(found[1])
        for program in programs(places):
            subprocess.run([sys.executable, "-B", *program], check=True, cwd=folder, timeout=120)
    finally:
        server.send_signal(signal.SIGINT)
        rest, _ = server.communicate(timeout=60)
    print("".join(line + "\n" for line in rest.splitlines() if line.startswith("port ")), end="")
    subprocess.run([BAUDBOT, "replay", recording], check=True, stdout=subprocess.DEVNULL)


def number(place: str) -> str:
    return place.rsplit(":", 1)[1]


def fix(port: str) -> list[str]:
    """gpsd finds the receiver's baud rate by itself, and reports a fix in three dimensions."""
    program = """
import json, socket, subprocess, sys
free = socket.create_server(("127.0.0.1", 0))
number = free.getsockname()[1]
free.close()
gpsd = subprocess.Popen(["gpsd", "-N", "-n", "-b", "-S", str(number), sys.argv[1]], stderr=subprocess.DEVNULL)
try:
    while gpsd.poll() is None:
        try:
            stream = socket.create_connection(("127.0.0.1", number), timeout=60)
            break
        except ConnectionRefusedError:
            continue
    stream.sendall(b'?WATCH={"enable":true,"json":true};\\n')
    bauds = set()
    for line in stream.makefile():
        report = json.loads(line)
        if report["class"] == "DEVICE":
            bauds.add(report.get("bps"))
        if report["class"] == "TPV" and report.get("mode") == 3:
            break
    assert 4800 in bauds, bauds
    assert abs(report["lat"]) < 1e-3 and abs(report["lon"]) < 1e-3, report
finally:
    gpsd.kill()
print("gpsd: 4800 baud found, a fix in three dimensions")
"""
    return ["-c", program, port]


def main() -> None:
    khepera, create, urg = (str(HERE / f"{name}.py") for name in ("khepera", "create", "urg"))
    with tempfile.TemporaryDirectory() as folder:
        served(
            "khepera",
            ["pty:khepera.tty", "rfc2217:0", "tcp:0"],
            lambda places: [
                [khepera, places[0], "9600", "2"],
                [khepera, "rfc2217://127.0.0.1:" + number(places[1]), "9600", "2"],
                [khepera, "socket://127.0.0.1:" + number(places[2]), "9600", "2"],
            ],
            folder,
        )
        served(
            "create",
            ["pty:create.tty", "rfc2217:0"],
            lambda places: [
                [create, places[0]],
                [create, "wake", "rfc2217://127.0.0.1:" + number(places[1])],
            ],
            folder,
        )
        served("urg", ["robot/laser=tcp:0"], lambda places: [[urg, number(places[0])]], folder)
        served("gps", ["robot/gps=pty:gps.tty"], lambda places: [fix(os.path.join(folder, places[0]))], folder)


main()
