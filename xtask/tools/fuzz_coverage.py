"""Which lines the fuzzer reaches: `xtask/tools/fuzz --coverage [SECONDS [TARGET…]]`.

Builds it with counters into a folder of its own, runs each target for some seconds, and tells of each how many lines it has run
of the crates that it tries, and of each of these crates how many lines all targets together have run. Needs rustup's component
llvm-tools.
"""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILT = ROOT / "target" / "coverage"

# What each target tries, by its folders; the first that fits.
TRIES = {
    "headers": ["crates/access"],
    "tokens": ["crates/access", "crates/fields"],
    "scenarios": ["crates/scenario", "crates/fields"],
    "logs": ["crates/fit/src/log"],
    "maps": ["crates/import"],
    "pictures": ["crates/import"],
    "plans": ["crates/import"],
    "measured": ["crates/import"],
    "hex": ["crates/avr/src/program"],
    "elf": ["crates/avr/src/program"],
    "recordings": ["crates/recording"],
    "states": ["crates/sim"],
    "dialogues": ["crates/wire", "crates/sim"],
}
# All others are protocols.
PROTOCOL = ["crates/wire"]


def run(*command: str, **environment: str) -> str:
    done = subprocess.run(command, cwd=ROOT, env=os.environ | environment, stdout=subprocess.PIPE, text=True, check=True)
    return done.stdout


def llvm(tool: str) -> str:
    libraries = pathlib.Path(run("rustc", "--print", "sysroot").strip()) / "lib" / "rustlib"
    found = list(libraries.glob(f"*/bin/{tool}"))
    if not found:
        sys.exit(f"there is no {tool}: rustup component add llvm-tools")
    return str(found[0])


def lines_of(program: str, raw: list[pathlib.Path]) -> dict[str, tuple[set[int], set[int]]]:
    """Of each file the lines that were run, and all that could be."""
    merged = BUILT / "merged.profdata"
    run(llvm("llvm-profdata"), "merge", "-sparse", "-o", str(merged), *map(str, raw))
    exported = run(llvm("llvm-cov"), "export", "-format=lcov", f"-instr-profile={merged}", program)
    files: dict[str, tuple[set[int], set[int]]] = {}
    name = ""
    for line in exported.splitlines():
        kind, _, rest = line.partition(":")
        if kind == "SF":
            name = os.path.relpath(ROOT / rest, ROOT)
        elif kind == "DA":
            number, count = map(int, rest.split(",")[:2])
            hit, there = files.setdefault(name, (set(), set()))
            there.add(number)
            if count:
                hit.add(number)
    return files


def share(files: dict[str, tuple[set[int], set[int]]], folder: str) -> tuple[int, int]:
    of = [counts for name, counts in files.items() if name.startswith(folder) and "/tests/" not in name]
    return sum(len(hit) for hit, _ in of), sum(len(there) for _, there in of)


def main() -> None:
    seconds = sys.argv[1] if len(sys.argv) > 1 else "10"
    instrumented = {"RUSTFLAGS": "-C instrument-coverage", "CARGO_TARGET_DIR": str(BUILT)}
    # What runs while it is built counts nothing that anybody wants.
    building = instrumented | {"LLVM_PROFILE_FILE": "/dev/null"}
    run("cargo", "build", "--locked", "-p", "baudbot-tests", "--example", "fuzz", **building)
    program = str(BUILT / "debug" / "examples" / "fuzz")
    quiet = {"LLVM_PROFILE_FILE": "/dev/null"}
    known = [line.split()[0] for line in run(program, "--list", **quiet).splitlines()]
    targets = sys.argv[2:] or known
    if unknown := [target for target in targets if target not in known]:
        sys.exit(f"{unknown[0]}: there is no such target; they are: {', '.join(known)}")
    raw = []
    print(f"{'target':12} {'tries':18} {'lines run':>10} {'of':>7}")
    for target in targets:
        profile = BUILT / f"{target}.profraw"
        run(program, target, "--seconds", seconds, LLVM_PROFILE_FILE=str(profile))
        raw.append(profile)
        files = lines_of(program, [profile])
        for folder in TRIES.get(target, PROTOCOL):
            hit, there = share(files, folder)
            print(f"{target:12} {folder:18} {hit:10} {there:7} {100 * hit / max(there, 1):5.0f} %", flush=True)
    files = lines_of(program, raw)
    print("\nall of them together")
    for folder in sorted({folder.split("/")[0] for target in targets for folder in TRIES.get(target, PROTOCOL)}):
        hit, there = share(files, f"{folder}/src")
        print(f"{folder:31} {hit:10} {there:7} {100 * hit / max(there, 1):5.0f} %")


if __name__ == "__main__":
    main()
