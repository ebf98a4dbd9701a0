#!/usr/bin/env python3
"""Scenarios as editors see them: `xtask/tools/check_schema.py BAUDBOT`.

taplo, by which editors check TOML, gets the schema of `baudbot schema`. It must find nothing in the scenarios of this project, and in each of some
that are wrong what is wrong there.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TAPLO = ROOT / "xtask/tools/node_modules/.bin/taplo"
RIGHT = """#:schema ./scenario.schema.json
step_ms = 10.0

[[robots]]
name = "alice"
body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }
link = { kind = "uart", baud = 9600 }

[robots.sensors.front]
kind = "ir"
bearing_rad = 0.0
opening_rad = 0.5
rays = 5
range_m = 1.0
c1_m2 = 0.03
c2 = 0.1

[[robots]]
name = "bob"
preset = "e-puck"
start = { x_m = 1.0 }
sensors.ir_0 = { bits = 8 }
"""
# What stands there, what is put in its place, and what taplo must say.
WRONG = [
    ("step_ms = 10.0", "stpe_ms = 10.0", "Additional properties are not allowed ('stpe_ms' was unexpected)"),
    ("step_ms = 10.0", 'step_ms = "ten"', '"ten" is not of type "number"'),
    ("step_ms = 10.0", "step_ms = 2000.0", "2000.0 is greater than the maximum of 1000"),
    ("mass_kg = 3.0, ", "", '"mass_kg" is a required property'),
    ("mass_kg = 3.0", "mass_kg = 0.0", "0.0 is less than or equal to the minimum of 0"),
    ("radius_m = 0.2, ", "", '"radius_m" is a required property'),
    (", baud = 9600", "", '"baud" is a required property'),
    ('"uart", baud = 9600', '"usb", baud = 9600', "False schema does not allow 9600"),
    ('kind = "ir"\n', 'kind = "irr"\n', '"irr" is not one of ["ir","ir-voltage",'),
    ('kind = "ir"\n', "", '"kind" is a required property'),
    ("rays = 5\n", "", '"rays" is a required property'),
    ("rays = 5\n", "rays = 5\nsweep_ms = 1.0\n", "Additional properties are not allowed ('sweep_ms' was unexpected)"),
    ("bearing_rad = 0.0\n", "", '"bearing_rad" is a required property'),
    ("bits = 8", "bits = 40", "40 is greater than the maximum of 32"),
    ('"e-puck"', '"e-pukc"', '"e-pukc" is not one of ["khepera-1",'),
    ('preset = "e-puck"\n', "", '"body" is a required property'),
]


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        schema = subprocess.run([sys.argv[1], "schema"], capture_output=True, check=True).stdout
        (folder / "scenario.schema.json").write_bytes(schema)
        ours = scenarios()
        if said := problems(["--schema", (folder / "scenario.schema.json").as_uri(), *ours], folder):
            sys.exit(f"taplo says of scenarios of the project:\n{said}")
        (folder / "right.toml").write_text(RIGHT)
        for i, (there, instead, _) in enumerate(WRONG):
            assert RIGHT.count(there) == 1, there
            (folder / f"wrong-{i}.toml").write_text(RIGHT.replace(there, instead))
        # Each error is followed by its place.
        found = re.findall(r"^error: (.*)\n.*?/([\w-]+)\.toml:\d", problems(sorted(folder.glob("*.toml")), folder), re.M)
        if said := [words for words, file in found if file == "right"]:
            sys.exit(f"taplo says of what is right: {said}")
        for i, (there, instead, expected) in enumerate(WRONG):
            said = {words for words, file in found if file == f"wrong-{i}"}
            if not any(expected in words for words in said):
                sys.exit(f"with {instead!r} in place of {there!r} taplo does not say {expected!r}, but: {said}")
        print(f"taplo: nothing to say of {len(ours)} scenarios; {len(WRONG)} mistakes found, each with its words")


def scenarios():
    """The files of the project that are scenarios."""
    listed = subprocess.run(["git", "ls-files", "*.toml"], cwd=ROOT, capture_output=True, text=True, check=True)
    files = [ROOT / name for name in listed.stdout.split()]
    return [file for file in files if re.search(r"^\[\[robots\]\]|^\[arena|^\[\[arena", file.read_text(), re.M)]


def problems(arguments, folder):
    """What taplo says of files; empty if nothing."""
    done = subprocess.run([TAPLO, "lint", *arguments], cwd=folder, capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode else ""


if __name__ == "__main__":
    main()
