"""Debugs a program on a simulated robot's microcontroller with the real avr-gdb: `python tests/firmware/gdb.py BAUDBOT`.

Needs gdb-avr, gcc-avr and avr-libc from apt. Without them it says NOT CHECKED and exits with 0.
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKETCH = ROOT / "tests/firmware/sketch.c"

class World:
    """A robot whose chip waits for a debugger."""

    def __init__(self, baudbot: str, elf: str, seconds: str = "1.0", options: tuple[str, ...] = ()):
        scenario = str(ROOT / "catalogue/scenarios/firmware.toml")
        command = [baudbot, "run", scenario, "--firmware", f"robot={elf}", "--seconds", seconds, "--gdb", "robot=0", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        said = ""
        while not (found := re.search(r"target remote (127\.0\.0\.1:\d+)", said)):
            line = self.process.stderr.readline()
            assert line, f"the program has ended: {said}"
            said += line
        self.address = found[1]

    def end(self) -> tuple[int, str]:
        out, _ = self.process.communicate(timeout=120)
        return self.process.returncode, out


def gdb(world: World, elf: str, *commands: str) -> subprocess.Popen:
    words = ["avr-gdb", "-nx", "-q", "-batch", elf, "-ex", "set pagination off", "-ex", f"target remote {world.address}"]
    for command in commands:
        words += ["-ex", command]
    return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def found(pattern: str, text: str) -> re.Match:
    match = re.search(pattern, text, re.MULTILINE)
    assert match, f"{pattern!r} is not in what avr-gdb has said:\n{text}"
    return match


def breakpoints_and_steps(baudbot: str, elf: str, *options: str) -> None:
    """Breaks in a function, steps, looks at variables and the stack, finishes, and lets the run end."""
    world = World(baudbot, elf, options=options)
    said, _ = gdb(
        world, elf,
        "print/x $pc",
        "break add", "continue", "backtrace", "info args", "monitor time",
        "finish",
        "continue", "print number", "print sum",
        "delete", "tbreak sketch.c:23", "continue", "next", "print total",
        "x/2i $pc", "info registers sp", "info registers SREG",
        "continue",
    ).communicate(timeout=120)
    found(r"^\$1 = 0x0$", said)
    found(r"^Breakpoint 1, add \(sum=0, number=1 '\\001'\)", said)
    found(r"^#1  0x[0-9a-f]+ in main \(\) at .*sketch\.c:22$", said)
    found(r"^Value returned is .* = 1$", said)
    found(r"^Breakpoint 1, add \(sum=1, number=2 '\\002'\)", said)
    found(r"^Temporary breakpoint 2, main \(\) at .*sketch\.c:23$", said)
    found(r"^\[Inferior 1 \(.*\) exited normally\]$", said)
    seconds = float(found(r"^([0-9.]+) s after the chip's supply came on, \d+ cycles", said)[1])
    assert seconds < 0.1, f"the first call of add comes at {seconds} s"
    code, summary = world.end()
    assert code == 0, summary
    found(r"\b1(\.0+)? s\b", summary)


def watchpoints(baudbot: str, elf: str, *options: str) -> None:
    """Watches a variable, and writes it."""
    world = World(baudbot, elf, options=options)
    said, _ = gdb(
        world, elf,
        "watch total", "continue", "continue", "continue",
        "set variable total = 1000", "continue", "print total", "kill",
    ).communicate(timeout=120)
    found(r"^Hardware watchpoint 1: total$", said)
    values = [tuple(map(int, pair)) for pair in re.findall(r"^Old value = (\d+)\nNew value = (\d+)$", said, re.MULTILINE)]
    # A variable of two bytes is written a byte after the other: what stands between is seen only if it differs.
    assert values[:3] == [(0, 1), (1, 3), (3, 6)], said
    found(r"^\$1 = 10\d\d$", said)
    code, summary = world.end()
    assert code == 0, summary


def an_interrupt_and_a_detachment(baudbot: str, elf: str, *options: str) -> None:
    """What Ctrl-C does stops a program that runs; then the world stands, and goes on when the debugger is gone."""
    world = World(baudbot, elf, "100000", options)
    words = ["avr-gdb", "-nx", "-q", "--interpreter=mi2", elf]
    debugger = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(command: str, until: str) -> str:
        debugger.stdin.write(command + "\n")
        debugger.stdin.flush()
        said = ""
        while not re.search(until, said, re.MULTILINE):
            line = debugger.stdout.readline()
            assert line, f"avr-gdb has ended behind {command}: {said}"
            said += line
        return said

    ask("-gdb-set mi-async on", r"^\^done")
    ask(f"-target-select remote {world.address}", r"^\*stopped")
    ask("-exec-continue", r"^\*running")
    time.sleep(1.0)
    ask("-exec-interrupt", r'^\*stopped.*signal-name="SIGINT"')
    time_s = r"([0-9.]+) s after the chip's supply came on"
    first = found(time_s, ask("monitor time", r"^\^done"))[1]
    time.sleep(0.5)
    assert found(time_s, ask("monitor time", r"^\^done"))[1] == first
    # The tick of a millisecond goes on: it is set to 0 at 5.
    found(r'value="1"', ask('-data-evaluate-expression "ticks_ms < 6"', r"^\^done"))
    ask("-target-detach", r"^\^done")
    debugger.stdin.write("-gdb-exit\n")
    debugger.communicate(timeout=60)
    world.process.send_signal(signal.SIGINT)
    assert world.end()[0] == 130


def a_signal_ends_a_world_that_waits(baudbot: str, elf: str, *options: str) -> None:
    """The world goes on without a debugger then, and is ended before it comes to the end of its run."""
    for _ in range(3):
        world = World(baudbot, elf, options=options)
        world.process.send_signal(signal.SIGINT)
        assert world.end()[0] == 130


def refusals(baudbot: str, elf: str) -> None:
    """What cannot be is told in a line, with exit code 2."""
    scenario = str(ROOT / "catalogue/scenarios/firmware.toml")
    waiting = World(baudbot, elf)
    taken = waiting.address.rsplit(":", 1)[1]
    for words, text in [
        ([scenario, "--gdb", "nobody=0"], "there is no robot `nobody`; there are: robot"),
        ([scenario, "--gdb", "robot=0", "--gdb", "robot=0"], "has a debugger already"),
        ([scenario, "--gdb", "robot=0", "--record", "never.mcap"], "--gdb and --record exclude each other"),
        ([scenario, "--gdb", f"robot={taken}"], "the port is in use"),
        ([scenario, "--gdb", "robot"], "write ROBOT=PORT"),
        (["wander", "--gdb", "robot=0"], "has no program on its microcontroller"),
    ]:
        done = subprocess.run([baudbot, "run", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2 and text in done.stderr, f"{words}: {done.returncode} {done.stderr}"
    waiting.process.send_signal(signal.SIGINT)
    waiting.end()


def main() -> None:
    missing = [name for name in ("avr-gdb", "avr-gcc") if not shutil.which(name)]
    if missing:
        print(f"debugging: NOT CHECKED ({', '.join(missing)} missing: apt-get install gdb-avr gcc-avr avr-libc)")
        return
    baudbot = os.path.realpath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        elf = str(pathlib.Path(folder, "sketch.elf"))
        subprocess.run(["avr-gcc", "-mmcu=atmega328p", "-Os", "-g", "-Wall", str(SKETCH), "-o", elf], check=True)
        for check in (
            breakpoints_and_steps, watchpoints, an_interrupt_and_a_detachment, a_signal_ends_a_world_that_waits,
        ):
            for options in ((), ("--over", "grpc"), ("--pace", "real-time")):
                check(baudbot, elf, *options)
                print(f"debugging: {' '.join((check.__name__.replace('_', ' '), *options))}: ok", flush=True)
        refusals(baudbot, elf)
        print("debugging: refusals: ok", flush=True)



if __name__ == "__main__":
    main()
