#!/usr/bin/env python3
"""Runs the brains of `solutions/brains.toml`: each solution passes its exercise, and each mistake gets its advice.

    python catalogue/exercises/check.py BAUDBOT [EXERCISE…]
"""

import json
import os
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent


def main():
    program = str(Path(sys.argv[1]).resolve())
    brains = tomllib.loads((HERE / "solutions" / "brains.toml").read_text(encoding="utf-8"))
    names = {path.stem for path in HERE.glob("*.toml")}
    if names != set(brains):
        sys.exit(f"exercises without brains, or brains without an exercise: {sorted(names ^ set(brains))}")
    cases = []
    for name in sys.argv[2:] or sorted(brains):
        cases.append((name, brains[name]["solution"], None))
        cases += [(name, mistake["brain"], mistake["says"]) for mistake in brains[name]["mistakes"]]
    # A grading of a few runs does not keep all processors busy.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda case: checked(program, *case), cases)
        wrong = [line for lines in results for line in lines]
    if wrong:
        sys.exit("\n".join(wrong))


def checked(program, name, brain, says):
    """What is not as it should be."""
    # This interpreter has the package that the brains need.
    brain = brain.replace("exec:python ", f"exec:{sys.executable} ", 1)
    command = [program, "grade", name, "--brain", brain, "--json", "--quiet"]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True, timeout=1200, check=False)
    if done.returncode not in (0, 3):
        return [f"{name}: {brain}: exit code {done.returncode}: {done.stdout}{done.stderr}"]
    graded = json.loads(done.stdout)
    print(f"{name}: {brain}: {graded['verdict']}, {graded['points']:g} of {graded['points_of']:g} points", flush=True)
    wanted = "passed" if says is None else "failed"
    if graded["verdict"] != wanted or done.returncode != (0 if says is None else 3):
        return [f"{name}: {brain}: {graded['verdict']}, not {wanted}: {json.dumps(graded['findings'], indent=1)}"]
    if says is not None and not any(says in finding for finding in graded["findings"]):
        return [f"{name}: {brain}: nothing says `{says}`: {json.dumps(graded['findings'], indent=1)}"]
    return []


if __name__ == "__main__":
    main()
