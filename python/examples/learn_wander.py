#!/usr/bin/env python3
"""Learns to wander without running into anything, at the end of a cable, by an evolution strategy.

The policy is then a brain of the program:

    python learn_wander.py --baud 9600 --minutes 4 --out wanderer.toml
    baudbot run wander --brain wanderer.toml

Each generation tries pairs of networks, on either side of the current one, both of a pair in the same world. The current one moves
towards those that did better, by their ranks (Salimans et al. 2017, "Evolution Strategies as a Scalable Alternative to
Reinforcement Learning").
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import numpy as np
from baudbot.gym import Network, VectorEnv, save_policy
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

PAIRS, SECONDS, HIDDEN = 20, 30.0, 8
SIGMA, RATE, MOMENTUM = 0.2, 0.2, 0.8
#: What counts is the floor that is covered: for the distance alone a robot would drive in a small circle. A collision ends a run.
REWARD = {"covered": 20.0, "collisions": -1.0}
#: Robots start anywhere near the middle, so that they learn more than one path.
STARTS = {f"robots.robot.start.{name}": {"uniform": [-most, most]} for name, most in (("x_m", 0.5), ("y_m", 0.5), ("heading_rad", 3.14))}


def network(numbers: NDArray[np.float64], envs: VectorEnv) -> Network:
    """A network with a hidden layer of these numbers, or one for each row of them."""
    readings, sensors, outputs = len(envs.shape.columns), len(envs.shape.sensors), len(envs.shape.signals)
    # Readings of what is near are some tenths; ages are some hundredths of a second, and more on slow cables.
    scale = np.repeat([3.0, 3.0, 1.0] if envs.shape.with_ages else [3.0], sensors)
    layers, begin = [], 0
    for before, after in ((len(scale) - sensors + readings, HIDDEN), (HIDDEN, outputs)):
        layer = numbers[..., begin : begin + (before + 1) * after]
        layer = layer.reshape(*numbers.shape[:-1], after, before + 1)
        layers.append((layer[..., :-1], layer[..., -1]))
        begin += (before + 1) * after
    return Network(layers, scale=scale)


def scores(envs: VectorEnv, policies: Network, seed: int) -> NDArray[np.float64]:
    """What each network earns in its run: that of environment `i` has the seed `seed + i`."""
    observation, _ = envs.reset(seed=seed)
    total, running = np.zeros(envs.num_envs), np.ones(envs.num_envs, np.bool_)
    while running.any():
        observation, reward, terminated, truncated, _ = envs.step(policies(observation))
        total += np.where(running, reward, 0.0)
        running &= ~(terminated | truncated)
    return total


def learn(envs: VectorEnv, seed: int) -> Iterator[Network]:
    """The network after each generation, for ever."""
    shape = envs.shape
    inputs = len(shape.columns) + (2 * len(shape.sensors) if shape.with_ages else 0)
    size = (inputs + 1) * HIDDEN + (HIDDEN + 1) * len(shape.signals)
    chance = np.random.default_rng(seed)
    centre, speed = chance.normal(0.0, 0.1, size), np.zeros(size)
    while True:
        aside = chance.normal(size=(PAIRS, size))
        worlds = int(chance.integers(1 << 31))
        earned = np.array([scores(envs, network(centre + side * SIGMA * aside, envs), worlds) for side in (1, -1)])
        ranks = (earned.ravel().argsort().argsort() / (earned.size - 1) - 0.5).reshape(earned.shape)
        speed = MOMENTUM * speed + (1 - MOMENTUM) * (ranks[0] - ranks[1]) @ aside / (PAIRS * SIGMA)
        centre = centre + RATE * speed
        yield network(centre, envs)


def worlds(baud: int, ages: bool, seconds: float = SECONDS) -> VectorEnv:
    """Worlds in which a run is this long, at the end of a cable of this rate."""
    return VectorEnv(
        PAIRS,
        "wander",
        threads=1,
        overrides={"robots.robot.link.baud": baud, "end.after_s": seconds, "metrics.cell_m": 0.1},
        randomize=STARTS,
        reward=REWARD,
        ages=ages,
        copy=False,
        autoreset_mode=AutoresetMode.DISABLED,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Learns to wander at the end of a cable.")
    parser.add_argument("--baud", type=int, default=9600)
    parser.add_argument("--no-ages", action="store_true", help="the policy does not know how old its readings are")
    parser.add_argument("--minutes", type=float, default=4.0, help="of one processor")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="wanderer.toml")
    given = parser.parse_args()
    envs = worlds(given.baud, not given.no_ages)
    told = 0
    for generation, policy in enumerate(learn(envs, given.seed), 1):
        minutes = time.process_time() / 60
        if minutes < (told + 1) * given.minutes / 20:
            continue
        told = int(20 * minutes / given.minutes)
        mean = scores(envs, policy, given.seed).mean()
        print(f"{minutes:5.1f} min, generation {generation:4}: earns {mean:6.2f}", flush=True)
        description = f"wanders at {given.baud} baud, as it has learnt"
        save_policy(given.out, envs, policy, description=description)
        if told >= 20:
            break
    print(f"try it: baudbot run wander --set robots.robot.link.baud={given.baud} --brain {given.out}")


if __name__ == "__main__":
    main()
