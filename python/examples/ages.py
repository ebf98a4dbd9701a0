#!/usr/bin/env python3
"""What is it worth to know how old one's readings are?

    python ages.py --out ages

Policies learn to wander (`learn_wander.py`) over a cable of 1200 baud, with the ages of their readings as inputs and without, from ten
seeds each, and one at 9600 baud. Each then drives for a minute from twenty places from which none of them has learnt, as a brain of
the program; the one for the fast cable does so over gRPC, too. Policies that are already in the folder are not learnt again.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context
from pathlib import Path

import baudbot
import learn_wander
import numpy as np
import pandas as pd
from baudbot.gym import save_policy

#: Generations in which a policy learns, in some minutes of processor time.
GENERATIONS = {9600: 1200, 1200: 600}
PLACES, SECONDS = 20, 60.0
#: Student's t by the number of seeds: two-sided, 95 %.
STUDENT = {2: 12.706, 3: 4.303, 4: 3.182, 5: 2.776, 6: 2.571, 7: 2.447, 8: 2.365, 9: 2.306, 10: 2.262}


@dataclass(frozen=True)
class Training:
    """What is learnt: at the end of which cable, with ages or without, and from which seed."""

    baud: int
    ages: bool
    seed: int

    @property
    def name(self) -> str:
        return f"{self.baud}-{'ages' if self.ages else 'no-ages'}-{self.seed}"

    def learn(self, folder: Path) -> float:
        """Learns a policy, and writes it into the folder. Returns the minutes of processor time."""
        begun = time.process_time()
        envs = learn_wander.worlds(self.baud, self.ages)
        *_, policy = islice(learn_wander.learn(envs, self.seed), GENERATIONS[self.baud])
        save_policy(folder / f"{self.name}.toml.part", envs, policy, description=f"wanders at {self.baud} baud, as it has learnt")
        (folder / f"{self.name}.toml.part").rename(folder / f"{self.name}.toml")
        return (time.process_time() - begun) / 60


def places() -> list[tuple[float, float, float]]:
    """Where the robot starts: places drawn as in training, from a seed of their own."""
    chance = np.random.default_rng(2016)
    low, high = zip(*(drawn["uniform"] for drawn in learn_wander.STARTS.values()), strict=True)
    return [tuple(chance.uniform(low, high).tolist()) for _ in range(PLACES)]


def experiment(folder: Path, trainings: list[Training]) -> Iterator[str]:
    """Each policy, and `avoid` for comparison, from each place: the lines of an experiment's file."""
    yield 'scenario = "wander"'
    yield f"seconds = {SECONDS}"
    yield "seeds = [1]"
    yield "[[fields]]"
    yield 'label = "policy"'
    yield "levels = ["
    for training in trainings:
        yield level(training.name, training.baud, str((folder / f"{training.name}.toml").resolve()))
    for baud in GENERATIONS:
        yield level(f"{baud}-avoid-0", baud, "avoid")
    yield "]"
    yield "[[fields]]"
    yield 'label = "place"'
    yield "levels = ["
    for number, place in enumerate(places(), 1):
        yield f'  {{ name = "{number}", set = {json.dumps(start(place))} }},'
    yield "]"


def level(name: str, baud: int, brain: str) -> str:
    changes = [f"robots.robot.link.baud={baud}", f"brain={brain}", "metrics.cell_m=0.1"]
    return f'  {{ name = "{name}", set = {json.dumps(changes)} }},'


def start(place: tuple[float, float, float]) -> list[str]:
    """The changes of fields that put the robot there."""
    return [f"robots.robot.start.{name}={value!r}" for name, value in zip(("x_m", "y_m", "heading_rad"), place, strict=True)]


def mean(values: pd.Series[float]) -> str:
    """The mean of a figure over the seeds, with half of its 95 % interval."""
    if len(values) == 1:
        return f"{values.mean():.2f}"
    return f"{values.mean():.2f} ± {STUDENT[len(values)] * values.std() / math.sqrt(len(values)):.2f}"


def table(runs: pd.DataFrame) -> Iterator[str]:
    """The results, for each cable and each kind of policy, in Markdown."""
    runs = runs.assign(kind=runs["policy"].str.rsplit("-", n=1).str[0], collided=runs["collisions"].clip(upper=1))
    figures = ["distance_m", "covered", "collided"]
    of_policies = runs.groupby(["kind", "policy"])[figures].mean()
    yield "| cable, brain | policies | distance (m) | floor covered | runs with a collision |"
    yield "|---|---|---|---|---|"
    for kind, policies in of_policies.groupby(level="kind"):
        cells = " | ".join(mean(policies[figure]) for figure in figures)
        yield f"| {kind} | {len(policies)} | {cells} |"


def check_by_program(program: str, folder: Path, runs: pd.DataFrame, training: Training) -> None:
    """Drives with `baudbot run`, over gRPC, and compares the results with the table."""
    rows = runs[runs["policy"] == training.name].set_index("place")
    for number, place in enumerate(places(), 1):
        changes = [f"robots.robot.link.baud={training.baud}", "metrics.cell_m=0.1", f"end.after_s={SECONDS}", *start(place)]
        command = [program, "run", "wander", "--brain", str(folder / f"{training.name}.toml"), "--over", "grpc", "--json"]
        for change in changes:
            command += ["--set", change]
        done = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        row = rows.loc[number]
        assert done["state_hash"] == row["state_hash"], (number, done["state_hash"], row["state_hash"])
        assert done["robots"][0]["distance_m"] == row["distance_m"], number
    print(f"{training.name}: {len(rows)} runs over gRPC end with the same states")


def main() -> None:
    parser = argparse.ArgumentParser(description="What is it worth to know how old one's readings are?")
    parser.add_argument("--out", type=Path, default=Path("ages"), help="the folder of the policies and of their runs")
    parser.add_argument("--seeds", type=int, default=10, choices=sorted(STUDENT))
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--program", default="baudbot", help="the program that drives with the policy for the fast cable, too")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    fast = Training(9600, False, 1)
    slow = [Training(1200, ages, seed) for seed in range(1, given.seeds + 1) for ages in (True, False)]
    missing = [training for training in [fast, *slow] if not (given.out / f"{training.name}.toml").exists()]
    # Threads of the worlds do not survive a fork.
    with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
        learnt = {pool.submit(training.learn, given.out): training for training in missing}
        for count, future in enumerate(as_completed(learnt), 1):
            print(f"{count} of {len(missing)}: {learnt[future].name} has learnt in {future.result():.1f} min of processor time", flush=True)
    file = given.out / "policies.toml"
    file.write_text("\n".join(experiment(given.out, [fast, *slow])), encoding="utf-8")
    runs = baudbot.sweep(file, out=given.out / "policies.sweep")
    wrong = runs["error"].dropna()
    assert wrong.empty, wrong.iloc[0]
    print("\n".join(table(runs)))
    check_by_program(given.program, given.out, runs, fast)
    collided = runs[(runs["policy"] == fast.name) & (runs["collisions"] > 0)]
    assert collided.empty, f"at {fast.baud} baud it ran into something, starting from the places {collided['place'].tolist()}"


if __name__ == "__main__":
    main()
