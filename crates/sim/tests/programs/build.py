#!/usr/bin/env python3
"""Builds the programs of tests, scenarios and benchmarks for an ATmega328P, or checks that what is committed is what the compiler gives.

    apt-get install gcc-avr avr-libc binutils-avr
    python3 crates/sim/tests/programs/build.py            builds each .hex anew
    python3 crates/sim/tests/programs/build.py --check    says which would differ, and exits with 1 if any does

The committed files are from Debian 12: gcc-avr 5.4.0+Atmel3.6.2-3, avr-libc 2.0.0+Atmel3.6.2-3.
"""

import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).parents[4]
HERE = ROOT / "crates/sim/tests/programs"
# The file, its source, and options besides.
PROGRAMS = [
    (HERE / "tester.hex", HERE / "tester.c", []),
    (HERE / "tester_115200.hex", HERE / "tester.c", ["-DBAUD_UBRR=8"]),
    (ROOT / "crates/bench/programs/spinning.hex", ROOT / "crates/bench/programs/spinning.c", []),
    (ROOT / "crates/bench/programs/sleeping.hex", ROOT / "crates/bench/programs/sleeping.c", []),
    (ROOT / "catalogue/scenarios/firmware/wander.hex", ROOT / "catalogue/scenarios/firmware/wander.c", []),
    (ROOT / "catalogue/scenarios/firmware/modules.hex", ROOT / "catalogue/scenarios/firmware/modules.c", []),
    (ROOT / "catalogue/scenarios/firmware/motor_shield.hex", ROOT / "catalogue/scenarios/firmware/motor_shield.c", []),
]


def build(source: pathlib.Path, options: list[str], folder: str) -> bytes:
    elf, made = f"{folder}/program.elf", f"{folder}/program.hex"
    gcc = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-Wall", "-Werror"]
    subprocess.run([*gcc, *options, source.name, "-o", elf], check=True, cwd=source.parent)
    subprocess.run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, made], check=True)
    return pathlib.Path(made).read_bytes()


def main() -> None:
    others = []
    for file, source, options in PROGRAMS:
        with tempfile.TemporaryDirectory() as folder:
            made = build(source, options, folder)
        if sys.argv[1:] != ["--check"]:
            file.write_bytes(made)
        elif not file.exists() or file.read_bytes() != made:
            others.append(str(file.relative_to(ROOT)))
    if others:
        sys.exit(f"not what the compiler gives: {', '.join(others)}")


main()
