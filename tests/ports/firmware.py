"""Programs of others at both ends of a cable: `python tests/ports/firmware.py BAUDBOT FOLDER`, where the folder has what
`tests/firmware/build.py` builds. Each run is recorded meanwhile, and replayed to the same bits."""

import json
import math
import os
import pathlib
import sys
import tempfile

from ports import Served

HERE = pathlib.Path(__file__).parent
BAUDBOT, BUILT = os.path.realpath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()


def served(folder: str, program: pathlib.Path, baud: int) -> Served:
    """The robot of `uno.toml` with a program, at a pty."""
    changes = [f"robots.uno.link.baud={baud}"]
    return Served(BAUDBOT, HERE / "uno.toml", ["pty:uno.tty"], folder, changes, ["--firmware", f"uno={program}"])


def way(run: Served) -> tuple[float, float]:
    """How far the robot has driven, in metres, and how far it has turned, in radians."""
    path = run.export("csv")
    steps = list(zip(path, path[1:]))
    way_m = sum(math.hypot(*(float(b[of]) - float(a[of]) for of in ("x_m", "y_m"))) for a, b in steps)
    turn = sum(math.remainder(float(b["heading_rad"]) - float(a["heading_rad"]), math.tau) for a, b in steps)
    return way_m, turn


def laptop(folder: str) -> None:
    """A sketch of Arduino's, and pyserial."""
    with served(folder, BUILT / "driven.hex", 9600) as run:
        seen = json.loads(run.run([str(HERE / "laptop.py"), run.places[0]]).splitlines()[-1])
    way_m, turn = way(run)
    # A GP2D12 gives 0.3 V with nothing in front, 3.2 V at most, and some tenths of a volt of its specimen's own.
    assert len(seen) == 31 and all(20 <= reading <= 700 for reading in seen), seen
    assert way_m > 0.3 and turn > 0.3, (way_m, turn)
    print(f"laptop.py: 31 commands answered, {way_m:.2f} m, {turn:.2f} rad")


def firmata(folder: str) -> None:
    """StandardFirmata and pyfirmata2."""
    for program in ("firmata_2_3.hex", "firmata_2_4.hex"):
        if not (BUILT / program).exists():
            print(f"NOT CHECKED: {program}, which could not be fetched")
            continue
        with served(folder, BUILT / program, 57_600) as run:
            seen = json.loads(run.run([str(HERE / "firmata.py"), run.places[0]]).splitlines()[-1])
        way_m, _ = way(run)
        assert all(0.02 <= reading <= 0.7 for reading in seen["readings"]), seen
        # One wheel drives.
        assert way_m > 0.05, way_m
        print(f"firmata.py: {seen['firmware']} {seen['version']}, {len(seen['readings'])} readings, {way_m:.2f} m")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        laptop(folder)
        firmata(folder)


main()
