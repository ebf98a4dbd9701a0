"""Programs of others drive simulated robots over serial ports, without a changed line: `python tests/ports/try.py BAUDBOT`.

Each robot is served with ports, recorded meanwhile, and the recording replayed to the same bits. What is checked holds
however late a program is.
"""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

from ports import Served, number

HERE = pathlib.Path(__file__).parent
BAUDBOT = os.path.realpath(sys.argv[1])
# Of the Create 2 (its preset), and a byte of 8N1 at 115,200 baud.
HALF_TRACK_M = 0.1175
BYTE_NS = 10 / 115_200 * 1e9


def khepera(folder: str) -> None:
    """pyserial and every command of a Khepera, over each kind of port."""
    program = str(HERE / "khepera.py")
    with Served(BAUDBOT, HERE / "khepera.toml", ["pty:khepera.tty", "rfc2217:0", "tcp:0"], folder) as served:
        pty, rfc2217, tcp = served.places
        for place in (pty, f"rfc2217://127.0.0.1:{number(rfc2217)}", f"socket://127.0.0.1:{number(tcp)}"):
            print(served.run([program, place, "9600", "2"]), end="")
    print(served.report, end="")


def e_puck(folder: str) -> None:
    """pyserial and the letters of an e-puck, in text and in bytes."""
    program = str(HERE / "e_puck.py")
    with Served(BAUDBOT, HERE / "e-puck.toml", ["pty:e-puck.tty", "rfc2217:0"], folder) as served:
        pty, rfc2217 = served.places
        for place in (pty, f"rfc2217://127.0.0.1:{number(rfc2217)}"):
            print(served.run([program, place]), end="")
    print(served.report, end="")


def create(folder: str) -> None:
    """pycreate2 and the path that follows from when its commands came, and answers as late as the budget says."""
    program = str(HERE / "create.py")
    with Served(BAUDBOT, HERE / "create.toml", ["pty:create.tty", "rfc2217:0"], folder) as served:
        told = json.loads(served.run([program, served.places[0]]).splitlines()[-2])
    print(served.report, end="")
    follows_its_commands(served, told)
    answers_as_budgeted(served)
    with Served(BAUDBOT, HERE / "create.toml", ["rfc2217:0"], folder) as served:
        served.run([program, "wake", f"rfc2217://127.0.0.1:{number(served.places[0])}"])
    print(served.report, end="")


def follows_its_commands(served: Served, told: list[list[int]]) -> None:
    """Whatever the lag of the motors, from rest to rest a wheel rolls as far as the speeds that it was told, for as long as
    each was in force: from when its last byte came."""
    events = served.export("events")
    # Before its first answer of 80 bytes pycreate2 clears four songs, by 5 bytes each that come as one or apart.
    first = next(place for place, event in enumerate(events) if event["kind"] == "up" and event["bytes"] == "80")
    downs = [event for event in events[first:] if event["kind"] == "down" and event["bytes"] == "5"]
    arrivals_s = [float(event["end_ns"]) * 1e-9 for event in downs]
    # At its end pycreate2 stops the robot once more.
    assert len(arrivals_s) >= len(told) and told[-1] == [0, 0], (len(arrivals_s), told)
    spans_s = [later - earlier for earlier, later in zip(arrivals_s, arrivals_s[1:])]
    left_m, right_m = (
        sum(speeds[side] * 1e-3 * span for speeds, span in zip(told, spans_s)) for side in (0, 1)
    )
    path = served.export("csv")
    last = path[-1]
    turn = float(last["heading_rad"])
    expected = (right_m - left_m) / (2 * HALF_TRACK_M)
    apart = math.remainder(turn - expected, math.tau)
    # The body's inertia shares one wheel's lag with the other, so a turn has a margin of its own.
    assert abs(apart) < 0.02, (turn, expected)
    steps = zip(path, path[1:])
    way_m = sum(
        (float(b["x_m"]) - float(a["x_m"])) * math.cos(float(a["heading_rad"]))
        + (float(b["y_m"]) - float(a["y_m"])) * math.sin(float(a["heading_rad"]))
        for a, b in steps
    )
    expected = (left_m + right_m) / 2
    assert abs(way_m / expected - 1) < 0.01, (way_m, expected)
    print(f"create.py: {way_m:.3f} m and {turn:.2f} rad follow from when its {len(told)} commands came")


def answers_as_budgeted(served: Served) -> None:
    """From the first byte of a question for group 100 to the last of its answer."""
    budget = subprocess.run(
        [BAUDBOT, "budget", str(HERE / "create.toml"), "--json"], check=True, stdout=subprocess.PIPE
    ).stdout
    rates = json.loads(budget)["robots"][0]["rates"]
    (most_per_s,) = (rate["most_per_s"] for rate in rates if rate["what"].startswith("queries of group 100"))
    asked_ns, apart = None, []
    for event in served.export("events"):
        if event["kind"] == "down" and event["bytes"] == "2":
            asked_ns = int(event["start_ns"])
        elif event["kind"] == "up" and event["bytes"] == "80":
            apart.append((int(event["end_ns"]) - asked_ns) * 1e-9 * most_per_s - 1)
    assert len(apart) > 20 and max(map(abs, apart)) < 0.01, apart
    print(f"create.py: {len(apart)} answers, the worst {max(map(abs, apart)) * 100:.2f} % beside the budget")


def laser(folder: str) -> None:
    """hokuyolx and 100 scans."""
    with Served(BAUDBOT, HERE / "urg.toml", ["robot/laser=tcp:0"], folder) as served:
        print(served.run([str(HERE / "urg.py"), number(served.places[0])]), end="")
    print(served.report, end="")


def receiver(folder: str) -> None:
    """gpsd finds the receiver's baud rate by itself, and reports a fix in three dimensions."""
    with Served(BAUDBOT, HERE / "gps.toml", ["robot/gps=pty:gps.tty"], folder) as served:
        print(served.run([str(HERE / "gps.py"), os.path.join(folder, served.places[0])]), end="")
    print(served.report, end="")


def never_early(folder: str) -> None:
    """No answer of a Khepera is early by the wall clock. That none is late needs an idle machine: idle.py."""
    with Served(BAUDBOT, HERE / "khepera.toml", ["pty:khepera.tty"], folder) as served:
        least_ms, median_ms = json.loads(served.run([str(HERE / "times.py"), served.places[0], "9600", "50"]))
    assert least_ms > 0, f"an answer was {-least_ms} ms early"
    print(f"khepera: answers {least_ms:.2f} ms late at least, {median_ms:.2f} ms in the median")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        for what in (khepera, e_puck, create, laser, receiver, never_early):
            what(folder)


main()
