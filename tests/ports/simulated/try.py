"""Programs of others drive robots in simulated time, without a changed line: `python tests/ports/simulated/try.py BAUDBOT SKETCHES`,
where the folder has what `tests/firmware/build.py` builds. `--runs 20` does each run so often, `--load` keeps all processors busy.

Each run has the same hash and the same output each time, and what it prints is held against the arithmetic of its wire.
"""

import argparse
import csv
import io
import json
import math
import multiprocessing
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
PORTS = HERE.parent
PORT = "/dev/ttyUSB0"
# Of a character with two stop bits at 9600 baud, and of 8N1.
KHEPERA_NS, CHARACTER_NS = 11e9 / 9600, 10e9 / 9600


class Robot:
    """A scenario, and how its runs are repeated."""

    def __init__(self, baudbot, runs):
        self.baudbot, self.runs = baudbot, runs

    def command(self, scenario, words, *options):
        """A run of a program."""
        return [self.baudbot, "program", str(scenario), *options, "--", *words]

    def drive(self, name, scenario, words, *options):
        """What the program printed, and the summary of its run, which are the same each time."""
        seen, fastest = set(), math.inf
        for _ in range(self.runs):
            begun = time.monotonic()
            done = subprocess.run(
                self.command(scenario, words, "--json", "--show-output", *options), capture_output=True, text=True, timeout=300
            )
            took_s = time.monotonic() - begun
            if done.returncode != 0:
                sys.exit(f"{name}: ended with {done.returncode}:\n{done.stdout}{done.stderr}")
            summary = json.loads(done.stdout)
            fastest = min(fastest, took_s)
            seen.add((summary["state_hash"], done.stderr))
        if len(seen) != 1:
            sys.exit(f"{name}: {self.runs} runs have {len(seen)} results:\n" + "\n".join(map(str, seen)))
        state_hash, printed = seen.pop()
        factor = summary["simulated_s"] / fastest
        print(f"{name}: {self.runs} runs, one hash ({state_hash}), {summary['simulated_s']:.2f} s, {factor:.1f} x real time", flush=True)
        return printed, summary

    def refuses(self, name, scenario, words, *expected):
        """The run ends with an error that says all of this, soon."""
        begun = time.monotonic()
        done = subprocess.run(self.command(scenario, words, "--quiet"), capture_output=True, text=True, timeout=60)
        took_s, said = time.monotonic() - begun, done.stdout + done.stderr
        missing = [word for word in expected if word not in said]
        if done.returncode != 1 or missing or took_s > 20:
            sys.exit(f"{name}: ended with {done.returncode} after {took_s:.1f} s, without {missing}:\n{said}")
        print(f"{name}: {said.splitlines()[0]}", flush=True)


def asks(robot, name, words):
    """Five questions to a Khepera and their answers. All of these programs see the same instants."""
    printed, _ = robot.drive(name, PORTS / "khepera.toml", [*words, PORT], "--seconds", "2")
    answers = [tuple(map(int, line.split())) for line in printed.splitlines()]
    if len(answers) != 5:
        sys.exit(f"{name}: five answers should have come:\n{printed}")
    for characters, took_ns in answers:
        # Two characters there, the answer's, and the time in which the firmware looks for a question and answers it.
        on_wire_ns = (2 + characters) * KHEPERA_NS
        if not on_wire_ns <= took_ns < on_wire_ns + 6e6:
            sys.exit(f"{name}: {characters} characters took {took_ns} ns, on the wire alone {on_wire_ns:.0f} ns")
    return answers


def square(robot, python):
    """pycreate2 and a square of half a metre, with its corners where they should be."""
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "path.csv"
        words = [python, str(HERE / "square.py"), "500", PORT]
        _, summary = robot.drive("pycreate2", PORTS / "create.toml", words, "--seconds", "60", "--csv", str(table))
        path = [row for row in csv.DictReader(io.StringIO(table.read_text())) if row]
    for axis in ("x_m", "y_m"):
        along = [float(row[axis]) for row in path]
        extent = max(along) - min(along)
        if abs(extent - 0.5) > 0.01 + 0.5 * 0.02:
            sys.exit(f"pycreate2: the square is {extent:.3f} m wide, not 0.5")
    if summary["ending"] != "its program has ended":
        sys.exit(f"pycreate2: the run ended because {summary['ending']}")


def recorded(robot, python):
    """A run is replayed to the same bits, without its program."""
    with tempfile.TemporaryDirectory() as folder:
        file = str(pathlib.Path(folder) / "run.mcap")
        words = [python, str(HERE / "square.py"), "100", PORT]
        _, summary = Robot(robot.baudbot, 1).drive("recorded", PORTS / "create.toml", words, "--seconds", "60", "--record", file)
        replayed = subprocess.run([robot.baudbot, "replay", file, "--json"], capture_output=True, text=True)
        if replayed.returncode != 0 or summary["state_hash"] not in replayed.stdout:
            sys.exit(f"the recording is not replayed to {summary['state_hash']}:\n{replayed.stdout}{replayed.stderr}")


def dynamixel(robot, python, sketches):
    """dynamixel-sdk gives up an answer that an adapter holds for longer than it waits, however busy the machine is."""
    words = [python, str(HERE / "dynamixel.py"), PORT]
    for latency_ms, expected in ((16, "[TxRxResult]"), (40, "[TxRxResult]")):
        options = ["--firmware", f"uno={sketches / 'servo.hex'}", "--seconds", "5"]
        options += ["--set", f"robots.uno.link.adapter={{ kind = \"ftdi\", latency_ms = {latency_ms} }}"]
        printed, _ = robot.drive(f"dynamixel-sdk, {latency_ms} ms", PORTS / "uno.toml", words, *options)
        came = "There is no status packet" not in printed
        if came != (latency_ms == 16):
            sys.exit(f"dynamixel-sdk: at {latency_ms} ms it printed {printed!r}")
        print(printed, end="")


def firmata(robot, python, sketches):
    """pyfirmata2 and StandardFirmata: both ends are somebody else's."""
    program = sketches / "firmata_2_4.hex"
    if not program.exists():
        print("NOT CHECKED: firmata_2_4.hex, which could not be fetched")
        return
    words = [python, str(PORTS / "firmata.py"), PORT]
    printed, _ = robot.drive(
        "pyfirmata2", PORTS / "uno.toml", words, "--firmware", f"uno={program}", "--seconds", "60", "--no-noise"
    )
    seen = json.loads(printed.splitlines()[-1])
    if len(seen["readings"]) < 50 or not seen["firmware"].startswith("StandardFirmata"):
        sys.exit(f"pyfirmata2: {printed}")


def socat(robot):
    """socat between a file, pipes and the port. The last character of an answer comes when the wire has carried it."""
    for baud in (1200, 9600, 115_200):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as question:
            question.write("N\r")
            question.flush()
            command = f"socat -t 2 OPEN:{question.name}!!- {PORT},b{baud},raw,echo=0,cstopb=1"
            script = "date +%s.%N; " + command + " | { read -r line; echo ${#line}; date +%s.%N; cat; }"
            options = ["--seconds", "20", "--set", f"robots.khepera.link.baud={baud}"]
            printed, _ = robot.drive(f"socat, {baud} baud", PORTS / "khepera.toml", ["sh", "-c", script], *options)
        begun, characters, answered = printed.split()
        # The line ends with CR, which the shell counts, and LF.
        on_wire_s = (2 + int(characters) + 1) * 11 / baud
        took_s = float(answered.split(".")[1]) / 1e9 - float(begun.split(".")[1]) / 1e9
        if not on_wire_s - 1e-6 <= took_s < on_wire_s + 6e-3:
            sys.exit(f"socat: {characters} characters took {took_s} s at {baud} baud, on the wire alone {on_wire_s} s")


def miniterm(robot, python):
    """pyserial's terminal needs one itself: another port of the robot's is one, whose receiver types."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = pathlib.Path(folder) / "typing.toml"
        scenario.write_text((PORTS / "khepera.toml").read_text() + 'sensors.gps.preset = "gps-garmin-15"\n')
        command = f"timeout 5 {shlex.join([python, '-m', 'serial.tools.miniterm', '--raw', PORT, '9600'])} < /dev/ttyUSB1"
        script = f"stty -F /dev/ttyUSB1 4800; {command}; test $? = 124"
        printed, _ = robot.drive("miniterm", scenario, ["sh", "-c", script], "--seconds", "10")
    if "Miniterm on /dev/ttyUSB0" not in printed:
        sys.exit(f"miniterm: {printed}")


def ordinary_user(robot, python):
    """Debian's Python as a user without capabilities has the hash that it has as root."""
    if os.geteuid() != 0 or not pathlib.Path("/usr/bin/python3").exists():
        print("NOT CHECKED: a user without capabilities, which takes root and /usr/bin/python3")
        return
    # The ladder's own temporary folder is for its user alone.
    with tempfile.TemporaryDirectory(dir="/var/tmp") as folder:
        place = pathlib.Path(folder)
        packages = subprocess.run([python, "-c", "import serial; print(serial.__path__[0])"], check=True, capture_output=True, text=True)
        shutil.copytree(packages.stdout.strip(), place / "serial")
        shutil.copy(robot.baudbot, place / "baudbot")
        shutil.copy(HERE / "asks.py", place)
        shutil.copy(PORTS / "khepera.toml", place)
        subprocess.run(["chmod", "-R", "a+rX", folder], check=True)
        nobody = "setpriv --reuid nobody --regid nogroup --clear-groups --inh-caps=-all --bounding-set=-all --no-new-privs".split()
        hashes = set()
        for who in ([], nobody):
            words = ["./baudbot", "program", "khepera.toml", "--seconds", "2", "--json", "--quiet", "--", "/usr/bin/python3", "asks.py", PORT]
            done = subprocess.run([*who, *words], cwd=place, capture_output=True, text=True, timeout=60, env={"PATH": os.environ["PATH"]})
            if done.returncode != 0:
                sys.exit(f"{who}: ended with {done.returncode}:\n{done.stdout}{done.stderr}")
            hashes.add(json.loads(done.stdout)["state_hash"])
    if len(hashes) != 1:
        sys.exit(f"root and nobody have {len(hashes)} hashes: {hashes}")
    print(f"Debian's Python as nobody: the hash of root ({hashes.pop()})", flush=True)


def sweep(baudbot, python):
    """The same table twice, over eight rates and twenty seeds; the robot's cable has the rate that the program is told."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        program = shlex.join([python, str(HERE / "square.py"), "100", PORT, "{baud}"])
        text = f"""scenario = {json.dumps(str(PORTS / "create.toml"))}
brain = {json.dumps("program:" + program)}
seeds = 20
seconds = 30
[[fields]]
field = "robots.create.link.baud"
values = [1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200]
"""
        (folder / "rates.toml").write_text(text)
        tables = []
        for turn in range(2):
            begun = time.monotonic()
            out = folder / str(turn)
            done = subprocess.run(
                [baudbot, "sweep", str(folder / "rates.toml"), "--out", str(out), "--quiet"], capture_output=True, text=True
            )
            if done.returncode != 0:
                sys.exit(f"the sweep ended with {done.returncode}:\n{done.stdout}{done.stderr}")
            print(f"a sweep of 160 runs: {time.monotonic() - begun:.1f} s", flush=True)
            tables.append({path.name: path.read_bytes() for path in out.glob("*.csv")})
        if not tables[0] or tables[0] != tables[1]:
            sys.exit("two sweeps have two tables")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("baudbot", type=lambda path: os.path.realpath(path))
    parser.add_argument("sketches", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--load", action="store_true")
    parser.add_argument("--sweep", action="store_true", help="also a sweep over eight rates and twenty seeds")
    arguments = parser.parse_args()
    load = [multiprocessing.Process(target=spin, daemon=True) for _ in range(os.cpu_count() or 1)] if arguments.load else []
    for process in load:
        process.start()
    robot, python = Robot(arguments.baudbot, arguments.runs), sys.executable
    with tempfile.TemporaryDirectory() as folder:
        programs = compiled(pathlib.Path(folder)) | {
            "pyserial": [python, str(HERE / "asks.py")],
            "threads": [python, str(HERE / "threads.py")],
            "asyncio": [python, str(HERE / "asyncio_lines.py")],
        }
        answers = {name: asks(robot, name, words) for name, words in programs.items()}
    first = answers["C"]
    for name, seen in answers.items():
        # Go's monitor sleeps 20 us before its first read.
        if [characters for characters, _ in seen] != [characters for characters, _ in first]:
            sys.exit(f"{name} got {seen}, and C {first}")
    square(robot, python)
    recorded(robot, python)
    socat(robot)
    miniterm(robot, python)
    ordinary_user(robot, python)
    dynamixel(robot, python, arguments.sketches)
    firmata(robot, python, arguments.sketches)
    robot.refuses("a socket", PORTS / "khepera.toml", [python, "-c", "import socket; socket.create_connection(('127.0.0.1', 1))"], "socket", "python")
    robot.refuses("a spinner", PORTS / "khepera.toml", [python, "-c", "while True: pass"], "computed", "no system call")
    robot.refuses("gpsd", PORTS / "khepera.toml", ["gpsd", "-N", "-n", PORT], "gpsd", "socket")
    robot.refuses("no program", PORTS / "khepera.toml", ["./there-is-none"], "there-is-none")
    if arguments.sweep:
        sweep(arguments.baudbot, python)
    for process in load:
        process.kill()


def spin():
    while True:
        pass


def compiled(folder):
    """The programs that are built from sources beside this."""
    builds = {
        "C": ["cc", "-O1", "-o", "c", HERE / "asks.c"],
        "static C": ["cc", "-O1", "-static", "-o", "static", HERE / "asks.c"],
        "Rust": ["rustc", "-O", "-o", "rust", HERE / "asks.rs"],
        "Go": ["go", "build", "-o", "go", HERE / "asks.go"],
    }
    environment = {**os.environ, "CGO_ENABLED": "0", "GO111MODULE": "off", "GOCACHE": str(folder / "cache")}
    for command in builds.values():
        subprocess.run([*map(str, command)], cwd=folder, check=True, env=environment)
    return {name: [str(folder / command[command.index("-o") + 1])] for name, command in builds.items()}


if __name__ == "__main__":
    main()
