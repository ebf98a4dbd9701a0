"""What an adapter of a scenario does to a program with pyserial as it is: `python tests/ports/adapter.py BAUDBOT`.

Not a part of `./test`: whether a time-out expires depends on how busy the machine is.
"""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

import serial

BAUDBOT = os.path.realpath(sys.argv[1])
TIMEOUT_S = 0.02
EXCHANGES = 20
SCENARIO = """
step_ms = 1.0
noise = false

[[robots]]
name = "k"
preset = "khepera-2"
firmware = {{ protocol = "khepera" }}
link = {{ baud = 115200, bits_per_character = 11, adapter = {{ kind = "ftdi", latency_ms = {latency_ms} }}, serial_port = {ports} }}
"""


def answers(latency_ms: float, ports: str, check) -> None:
    """Serves a Khepera behind an adapter with this latency timer, and runs a check with the places of its ports."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = pathlib.Path(folder, "k.toml")
        scenario.write_text(SCENARIO.format(latency_ms=latency_ms, ports=ports))
        command = [BAUDBOT, "serve", str(scenario), "--viewer", "off", "--listen", "127.0.0.1:0"]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=folder)
        try:
            places = []
            while len(places) < ports.count(":"):
                found = re.fullmatch(r"serial port of \S+: (\S+).*\n", server.stdout.readline())
                if found:
                    places.append(found[1])
            os.chdir(folder)
            check(places)
        finally:
            server.send_signal(signal.SIGINT)
            server.communicate(timeout=60)


def opened(place: str, **settings) -> serial.SerialBase:
    return serial.serial_for_url(place, baudrate=115200, stopbits=2, **settings)


def asked(robot: serial.SerialBase) -> bytes:
    robot.write(b"N\r")
    return robot.read_until(b"\n")


def packets(places: list[str]) -> None:
    """A whole answer is one packet, and the next one comes when the timer has run once more."""
    robot = opened(places[0], timeout=10)
    asked(robot)
    begin = time.monotonic()
    for _ in range(EXCHANGES):
        robot.write(b"N\r")
        first = robot.read(1)
        time.sleep(0.005)
        rest = robot.read(robot.in_waiting)
        assert re.fullmatch(rb"n(,\d+)+\r\n", first + rest), first + rest
    took_s = time.monotonic() - begin
    assert took_s >= 0.04 * (EXCHANGES - 1), took_s
    print(f"adapter.py: {EXCHANGES} answers of one packet each, {took_s / EXCHANGES * 1e3:.1f} ms apart")


def in_time(place: str) -> int:
    robot = opened(place, timeout=10)
    asked(robot)
    robot.timeout = TIMEOUT_S
    count = 0
    for _ in range(EXCHANGES):
        if asked(robot).endswith(b"\n"):
            count += 1
        else:
            # The answer comes; it is only late.
            robot.timeout = 10
            robot.read_until(b"\n")
            robot.timeout = TIMEOUT_S
    print(f"adapter.py: {count} of {EXCHANGES} answers within {TIMEOUT_S * 1e3:.0f} ms")
    return count


def late(places: list[str]) -> None:
    # A program that is late itself asks nearer to the timer's next end.
    assert in_time(places[0]) < EXCHANGES / 2


def early(places: list[str]) -> None:
    assert in_time(places[0]) > EXCHANGES / 2


def flow(places: list[str]) -> None:
    """Flow control is set without an error, and does nothing."""
    for place in (places[0], "rfc2217://" + places[1].removeprefix("rfc2217:")):
        for setting in ({"xonxoff": True}, {"rtscts": True}):
            with opened(place, timeout=10, **setting) as robot:
                assert asked(robot).endswith(b"\n"), setting
    print("adapter.py: flow control is set, and does nothing")


def modem(places: list[str]) -> None:
    """Behind kilobytes that the cable has not taken DTR is switched at once, and purging throws them away."""
    with opened("rfc2217://" + places[1].removeprefix("rfc2217:"), timeout=10) as robot:
        assert robot.cts and robot.dsr and robot.cd and not robot.ri
        robot.baudrate = 1200
        robot.write(b"D,0,0\r" * 2000)
        begin = time.monotonic()
        robot.dtr = False
        robot.dtr = True
        robot.reset_output_buffer()
        robot.baudrate = 115200
        took_s = time.monotonic() - begin
        assert took_s < 2.5, took_s
        time.sleep(0.5)
        robot.reset_input_buffer()
        robot.write(b"\r")
        robot.read_until(b"\n")
        assert asked(robot).endswith(b"\n")
    print(f"adapter.py: DTR, purge and rate behind 12 kB in {took_s * 1e3:.0f} ms")


answers(40, '"pty:k.tty"', packets)
answers(40, '"pty:k.tty"', late)
answers(1, '"pty:k.tty"', early)
answers(1, '["pty:k.tty", "rfc2217:0"]', flow)
answers(1, '["pty:k.tty", "rfc2217:0"]', modem)
