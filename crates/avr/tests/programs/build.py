#!/usr/bin/env python3
"""Builds the programs beside it for an ATmega328P, or checks that what is committed is what the compiler gives.

    apt-get install gcc-avr avr-libc binutils-avr
    python3 crates/avr/tests/programs/build.py            builds each .hex anew
    python3 crates/avr/tests/programs/build.py --check    says which would differ, and exits with 1 if any does

The committed files are from Debian 12: gcc-avr 5.4.0+Atmel3.6.2-3, avr-libc 2.0.0+Atmel3.6.2-3.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
# Name of the file: the source, further options.
PROGRAMS = {
    "blink": ("blink.c", []),
    "adc": ("adc.c", []),
    "echo_9600": ("echo.c", ["-DBAUD_UBRR=103", "-DBAUD_U2X=0"]),
    "echo_115200": ("echo.c", ["-DBAUD_UBRR=16", "-DBAUD_U2X=1"]),
    "pwm": ("pwm.c", []),
    "capture": ("capture.c", []),
    "watchdog": ("watchdog.c", []),
    "eeprom": ("eeprom.c", []),
    "sleep": ("sleep.c", []),
    "bootloader": ("bootloader.c", ["-Wl,--section-start=.text=0x7000"]),
    "compute": ("compute.c", []),
    "peripherals": ("peripherals.c", []),
    "conversions": ("conversions.c", []),
    **{
        f"rounds_{program.lower()}": ("rounds.c", [f"-DPROGRAM={program}"])
        for program in ("NESTED", "ASLEEP", "ARGUMENTS", "FAR", "FOREVER", "WATCHDOG")
    },
    **{
        f"timer{timer}_{program.lower()}": ("timer.c", [f"-DNUMBER={timer}", f"-DPROGRAM={program}"])
        for timer in (0, 1, 2)
        for program in ("COUNTERS", "OUTPUTS", "INTERRUPTS")
    },
}
# Where the EEPROM or the end of the variables matters, the linked file is kept, without what only debuggers need.
LINKED = ["eeprom"]


def main():
    if not shutil.which("avr-gcc"):
        sys.exit("avr-gcc is missing: apt-get install gcc-avr avr-libc binutils-avr")
    check = sys.argv[1:] == ["--check"]
    differ = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (source, options) in PROGRAMS.items():
            for built in build(Path(folder), name, source, options):
                kept = HERE / built.name
                if not check:
                    shutil.copyfile(built, kept)
                elif not kept.exists() or kept.read_bytes() != built.read_bytes():
                    differ.append(built.name)
    if differ:
        sys.exit("not what the compiler gives: " + " ".join(differ))


def build(folder, name, source, options):
    elf, hex_file = folder / f"{name}.elf", folder / f"{name}.hex"
    command = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-Wall", "-Werror", *options, source]
    subprocess.run([*command, "-o", elf], cwd=HERE, check=True)
    if name in LINKED:
        subprocess.run(["avr-strip", elf], check=True)
        yield elf
    else:
        subprocess.run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, hex_file], check=True)
        yield hex_file


if __name__ == "__main__":
    main()
