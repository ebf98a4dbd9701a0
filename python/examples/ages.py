#!/usr/bin/env python3
"""What is it worth to know how old one's readings are?

    python ages.py --out ages

Policies learn to wander (`learn_wander.py`) at the end of 1200 baud, with the ages of their readings as inputs and without, from ten
seeds each, and one at 9600 baud. Each then drives for a minute from twenty places from which none of them has learnt, as a brain of
the program. What is in the folder already is not done again.
"""

from __future__ import annotations

import argparse
import math
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

#: Generations in which a policy learns. At 9600 baud a generation takes six times as long: there are as many more messages.
GENERATIONS = {9600: 300, 1200: 600}
PLACES, SECONDS = 20, 60.0
#: Student's t for ten seeds, and for as many as are likely: two-sided, 95 %.
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
        """Learns a policy, and writes it into the folder. Gives the minutes of processor time."""
        begun = time.process_time()
        envs = learn_wander.worlds(self.baud, self.ages)
        *_, policy = islice(learn_wander.learn(envs, self.seed), GENERATIONS[self.baud])
        save_policy(folder / f"{self.name}.toml.part", envs, policy, description=f"wanders at {self.baud} baud, as it has learnt")
        (folder / f"{self.name}.toml.part").rename(folder / f"{self.name}.toml")
        return (time.process_time() - begun) / 60

    def drive(self, folder: Path) -> pd.DataFrame:
        """A row for each place from which the policy drives."""
        file = folder / f"{self.name}.sweep.toml"
        file.write_text("\n".join(self._experiment()), encoding="utf-8")
        return baudbot.sweep(file, out=folder / f"{self.name}.sweep")

    def _experiment(self) -> Iterator[str]:
        yield 'scenario = "wander"'
        yield f'brain = "{self.name}.toml"'
        yield f"seconds = {SECONDS}"
        yield "seeds = [1]"
        yield f'set = ["robots.robot.link.baud={self.baud}", "metrics.cell_m=0.1"]'
        yield "[[fields]]"
        yield 'label = "place"'
        yield "levels = ["
        for number, (x_m, y_m, heading_rad) in enumerate(places(), 1):
            start = f"robots.robot.start = {{ x_m = {x_m!r}, y_m = {y_m!r}, heading_rad = {heading_rad!r} }}"
            yield f'  {{ name = "{number}", set = ["{start}"] }},'
        yield "]"


def places() -> list[tuple[float, float, float]]:
    """Where the robot begins: drawn as in training, from a seed of their own."""
    chance = np.random.default_rng(2016)
    low, high = zip(*(drawn["uniform"] for drawn in learn_wander.STARTS.values()), strict=True)
    return [tuple(chance.uniform(low, high).tolist()) for _ in range(PLACES)]


def mean(values: pd.Series[float]) -> str:
    """The mean of a figure over the seeds, with half of its 95 % interval."""
    if len(values) not in STUDENT:
        return f"{values.mean():.2f}"
    return f"{values.mean():.2f} ± {STUDENT[len(values)] * values.std() / math.sqrt(len(values)):.2f}"


def main() -> None:
    parser = argparse.ArgumentParser(description="What is it worth to know how old one's readings are?")
    parser.add_argument("--out", type=Path, default=Path("ages"), help="the folder of the policies and of their runs")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    trainings = [Training(9600, False, 1)]
    trainings += [Training(1200, ages, seed) for seed in range(1, given.seeds + 1) for ages in (True, False)]
    missing = [training for training in trainings if not (given.out / f"{training.name}.toml").exists()]
    # Threads of the worlds do not survive a fork.
    with ProcessPoolExecutor(given.processes, mp_context=get_context("spawn")) as pool:
        learnt = {pool.submit(training.learn, given.out): training for training in missing}
        for number, future in enumerate(as_completed(learnt), 1):
            minutes = future.result()
            print(f"{number} of {len(missing)}: {learnt[future].name} has learnt in {minutes:.1f} min of a processor", flush=True)
    rows = [frame.assign(name=training.name) for training in trainings for frame in [training.drive(given.out)]]
    table = pd.concat(rows)
    table.to_csv(given.out / "runs.csv", index=False)
    print(table.groupby("name")[["distance_m", "covered", "collisions"]].mean())


if __name__ == "__main__":
    main()
