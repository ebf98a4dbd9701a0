#!/usr/bin/env python3
"""Learns to wander without running into anything, at the end of a cable, by an evolution strategy.

The policy is a brain of the program then:

    python learn_wander.py --baud 9600 --minutes 4 --out wanderer.toml
    baudbot run wander --brain wanderer.toml

Each generation tries pairs of networks, on either side of the present one, in the same worlds; the present one moves towards those
that came out better, by their ranks (Salimans et al. 2017, "Evolution Strategies as a Scalable Alternative to Reinforcement
Learning").
"""

import argparse
import time

import numpy as np
from baudbot.gym import Network, VectorEnv, save_policy
from numpy.typing import NDArray

PAIRS, WORLDS, HIDDEN = 16, 2, 8
SIGMA, RATE = 0.15, 0.08
#: Metres that a collision costs. It ends the run, too.
COLLISION_M = 3.0


def network(numbers: NDArray[np.float64], shape: tuple[int, int], scale: NDArray[np.float64]) -> Network:
    """Networks with a hidden layer of these numbers: one, or one for each row."""
    inputs, outputs = shape
    layers, begin = [], 0
    for before, after in ((inputs, HIDDEN), (HIDDEN, outputs)):
        end = begin + (before + 1) * after
        layer = numbers[..., begin:end].reshape(*numbers.shape[:-1], after, before + 1)
        layers.append((layer[..., :-1], layer[..., -1]))
        begin = end
    return Network(layers, scale=scale)


def scores(envs: VectorEnv, policies: Network, seed: int) -> NDArray[np.float64]:
    """What each of the networks earns in its run, all in worlds of the same `WORLDS` seeds."""
    observation, _ = envs.reset(options={"seed": seed})
    total, running = np.zeros(envs.num_envs), np.ones(envs.num_envs, np.bool_)
    while running.any():
        observation, reward, terminated, truncated, _ = envs.step(policies(observation))
        total += np.where(running, reward, 0.0)
        running &= ~(terminated | truncated)
    return total
