"""What needs an idle machine: `./test ports-idle`, which runs `python tests/ports/idle.py BAUDBOT`.

A Khepera is asked `N` and told `D` a thousand times each at 9600 and at 38,400 baud: no answer may come before the cable can
have carried it, and half of them within 1 ms of that. pycreate2 drives a Create 2 along a square of 0.5 m.
"""

import json
import math
import os
import pathlib
import sys
import tempfile

from ports import Served

HERE = pathlib.Path(__file__).parent
BAUDBOT = os.path.realpath(sys.argv[1])
TIMES = 1000
MOST_MS = 1.0
SIDE_M = 0.5


def exchanges(folder: str, baud: int) -> bool:
    """Whether answers were in time."""
    changes = [f"robots.khepera.link.baud={baud}", "step_ms=0.5"]
    in_time = True
    with Served(BAUDBOT, HERE / "khepera.toml", ["pty:khepera.tty"], folder, changes) as served:
        for question in ("N", "D,0,0"):
            program = [str(HERE / "times.py"), served.places[0], str(baud), str(TIMES), question]
            least_ms, median_ms = json.loads(served.run(program))
            print(
                f"{question} at {baud} baud, {TIMES} times, beyond its arithmetic: "
                f"{least_ms:.3f} ms at least, {median_ms:.3f} ms in the median"
            )
            in_time = in_time and least_ms >= 0 and median_ms <= MOST_MS
    print(served.report, end="")
    return in_time


def square(folder: str) -> bool:
    """Whether a program that drives by its own clock comes round a square."""
    with Served(BAUDBOT, HERE / "create.toml", ["pty:create.tty"], folder) as served:
        served.run([str(HERE / "square.py"), served.places[0]])
    print(served.report, end="")
    corners = [(float(row["x_m"]), float(row["y_m"])) for row in standing(served.export("csv"))]
    sides = [math.dist(a, b) for a, b in zip(corners, corners[1:])]
    sides = [side for side in sides if side > SIDE_M / 2]
    print("sides of the square: " + ", ".join(f"{side:.4f} m" for side in sides))
    return len(sides) == 4 and all(abs(side / SIDE_M - 1) <= 0.02 for side in sides)


def standing(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """The last row of each time in which the robot stands."""
    stands = [abs(float(row["speed_m_s"])) < 1e-3 for row in rows]
    return [row for row, now, then in zip(rows, stands, [*stands[1:], False]) if now and not then]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        good = [*(exchanges(folder, baud) for baud in (9600, 38_400)), square(folder)]
    if not all(good):
        sys.exit("not in time, or no square: is the machine idle?")


main()
