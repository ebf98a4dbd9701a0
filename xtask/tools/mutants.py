#!/usr/bin/env python3
"""Changes the pure crates at random places, one at a time, and says which changes their own tests do not notice.

    cargo install --locked cargo-mutants
    python3 xtask/tools/mutants.py [--count 200] [--seed 1] [--minutes 60] [--shard I/N] [--only CRATE] [--results FILE]

Of all changes that cargo-mutants knows for these crates (`CRATES`) it draws `--count` by `--seed`. Those that have no line
in the results file yet are tried, a few at a time, until `--minutes` are over; each outcome is appended at once, so the next
call goes on where this one stopped. A change is known by its place and text: after the code has moved begin a new file.
"""

import argparse
import functools
import os
import random
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

CRATES = ["geometry", "wire", "avr", "brain", "sim", "scenario", "budget"]
OUTCOMES = ["caught", "missed", "timeout", "unviable"]
BATCH = 5
# Those within a crate, and all; as cargo takes them.
UNIT_TESTS = ["--lib"]
ALL_TESTS = ["--lib", "--tests"]
BUILD = Path("target/mutants")
TREE = BUILD / "tree"


def main():
    args = arguments()
    results = Path(args.results)
    copy_tree()
    drawn = shard(draw(args.count, args.seed), args.shard)
    begun = time.monotonic()
    while time.monotonic() - begun < args.minutes * 60:
        done = known(results)
        left = [name for name in drawn if name not in done and args.only in (None, crate_of(name))]
        if not left:
            break
        # One crate a batch: its tests are built once.
        crate = crate_of(left[0])
        found = try_out(crate, [name for name in left if crate_of(name) == crate][:BATCH], UNIT_TESTS)
        # What the tests within the crate notice is noticed by all; only the others need those that take long.
        if survivors := [name for name, outcome in found.items() if outcome == "missed"]:
            found |= try_out(crate, survivors, ALL_TESTS)
        results.parent.mkdir(parents=True, exist_ok=True)
        is_cut = results.exists() and not results.read_text().endswith("\n")
        with results.open("a") as file:
            file.write("\n" if is_cut else "")
            file.writelines(f"{outcome}\t{name}\n" for name, outcome in found.items())
    table(drawn, known(results))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--shard", default="0/1", help="I/N: every Nth of those drawn, from the Ith on")
    parser.add_argument("--only", choices=CRATES, help="try none of another crate now")
    parser.add_argument("--results", default="target/mutants.tsv")
    return parser.parse_args()


def draw(count, seed):
    """Mutants by their names, in an order that the seed chooses."""
    packages = [word for crate in CRATES for word in ("-p", f"baudbot-{crate}")]
    listed = subprocess.run(["cargo", "mutants", "--list", *packages], check=True, capture_output=True, text=True)
    names = sorted(listed.stdout.splitlines())
    if len(names) < count:
        sys.exit(f"cargo mutants knows {len(names)} changes, fewer than --count {count}")
    return random.Random(seed).sample(names, count)


def shard(names, text):
    index, shards = (int(word) for word in text.split("/"))
    return names[index::shards]


def crate_of(name):
    return name.removeprefix("crates/").split("/", 1)[0]


def known(results):
    """Outcomes by name; a line that a kill cut off does not count."""
    if not results.exists():
        return {}
    lines = results.read_text().splitlines(keepends=True)
    pairs = (line.rstrip("\n").split("\t", 1) for line in lines if line.endswith("\n") and "\t" in line)
    return {name: outcome for outcome, name in pairs if outcome in OUTCOMES}


def try_out(crate, names, tests):
    """Tries some mutants of a crate in a copy of what is committed."""
    check_baseline(crate, tuple(tests))
    chosen = [word for name in names for word in ("--re", f"^{re.escape(name)}$")]
    # cargo-mutants 27 tries fields that it deletes in all files, whatever --re says.
    files = [word for file in sorted({name.split(":", 1)[0] for name in names}) for word in ("--file", file)]
    with tempfile.TemporaryDirectory() as folder:
        command = ["cargo", "mutants", "-p", f"baudbot-{crate}", "--in-place", "--baseline", "skip", "--timeout", "600", "-o", folder]
        command += [f"--cargo-arg={test}" for test in tests]
        code = subprocess.run([*command, *chosen, *files], env=environment(), cwd=TREE).returncode
        found = {}
        for outcome in OUTCOMES:
            listed = Path(folder, "mutants.out", f"{outcome}.txt")
            for name in listed.read_text().splitlines() if listed.exists() else []:
                found[name] = outcome
    if not found:
        sys.exit(f"cargo mutants tried none of {names} and ended with {code}")
    return found


@functools.cache
def check_baseline(crate, tests):
    """Tests that fail without any change would notice every one."""
    command = ["cargo", "test", "--quiet", "-p", f"baudbot-{crate}", *tests]
    if subprocess.run(command, env=environment(), cwd=TREE).returncode != 0:
        sys.exit(f"{' '.join(command)} fails in {TREE} without any change")


def environment():
    return {**os.environ, "CARGO_TARGET_DIR": str(BUILD.resolve())}


def copy_tree():
    """What is committed, always in the same place, so that little is rebuilt."""
    TREE.mkdir(parents=True, exist_ok=True)
    archive = subprocess.run(["git", "archive", "HEAD"], check=True, capture_output=True).stdout
    subprocess.run(["tar", "--extract", "--directory", TREE], input=archive, check=True)


def table(drawn, done):
    print(f"\n{'crate':10}" + "".join(f"{outcome:>10}" for outcome in OUTCOMES) + f"{'to do':>10}")
    for crate in CRATES:
        of_crate = Counter(done.get(name, "to do") for name in drawn if crate_of(name) == crate)
        print(f"{crate:10}" + "".join(f"{of_crate[outcome]:10}" for outcome in [*OUTCOMES, "to do"]))
    for name in drawn:
        if done.get(name) in ("missed", "timeout"):
            print(f"{done[name]}: {name}")


if __name__ == "__main__":
    main()
