#!/usr/bin/env python3
"""Many worlds, stepped from Python: control cycles a second of processor time.

    python crates/bench/python/vector.py [--worlds 64] [--threads 1] [--seconds 2] [--what ours]

It needs the package baudbot (`pip install './python[gym]'`). It is measured by turns with the same loop in Rust:

    target/release/baudbot-bench beside 'python crates/bench/python/vector.py --worlds 64' V/64 --pattern '([0-9.]+) cycles/s'

`ours` is `baudbot.gym.VectorEnv` of `wander` with the policy of workload V, in NumPy. `single` is one `baudbot.gym.Env`, `native` the same
without what Gymnasium asks for. `cartpole` is Gymnasium's own `SyncVectorEnv` of CartPole, which has no sensors; `envpool` is EnvPool's
(`pip install envpool`). With several threads the wall clock counts.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

TOO_NEAR = 0.28


def steer(readings: Any) -> Any:
    """On, more slowly the nearer something is, and to the left, on the spot, before what is too near."""
    nearest = np.maximum.reduce(readings, axis=1, keepdims=True)
    return np.where(nearest < NEAR, FAST - SLOWER * nearest, TURN)


TURN = np.array([[-0.5, 0.5]], np.float32)
NEAR, FAST, SLOWER = np.float32(TOO_NEAR), np.float32(0.15 + 0.35), np.float32(0.35 / TOO_NEAR)


def ours(worlds: int, threads: int) -> Callable[[], None]:
    import gymnasium
    from baudbot.gym import VectorEnv

    mode = gymnasium.vector.AutoresetMode.SAME_STEP
    envs = VectorEnv(worlds, "wander", threads=threads, copy=False, autoreset_mode=mode)
    observation, _ = envs.reset(seed=0)
    readings = observation["readings"]
    return lambda: envs.step(steer(readings)) and None


def single(worlds: int, threads: int) -> Callable[[], None]:
    from baudbot.gym import Env

    env = Env("wander")
    state = env.reset(seed=0)[0]["readings"]

    def step() -> None:
        nonlocal state
        observation, _, terminated, truncated, _ = env.step(steer(state[None])[0])
        state = env.reset()[0]["readings"] if terminated or truncated else observation["readings"]

    return step


def cartpole(worlds: int, threads: int) -> Callable[[], None]:
    import gymnasium

    envs = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make("CartPole-v1")] * worlds)
    envs.reset(seed=0)
    actions = np.arange(worlds) % 2
    return lambda: envs.step(actions) and None


def envpool(worlds: int, threads: int) -> Callable[[], None]:
    import envpool  # type: ignore[import-not-found]

    envs = envpool.make("CartPole-v1", env_type="gymnasium", num_envs=worlds, num_threads=threads)
    envs.reset()
    actions = (np.arange(worlds) % 2).astype(np.int32)
    return lambda: envs.step(actions) and None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--worlds", type=int, default=64)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=2.0)
    parser.add_argument("--what", choices=["ours", "single", "cartpole", "envpool"], default="ours")
    given = parser.parse_args()
    step = globals()[given.what](given.worlds, given.threads)
    worlds = 1 if given.what == "single" else given.worlds
    clock = time.process_time if given.threads == 1 else time.perf_counter
    for _ in range(20):
        step()
    steps, start = 0, clock()
    while clock() - start < given.seconds:
        step()
        steps += 1
    print(f"{steps * worlds / (clock() - start):.0f} cycles/s")


if __name__ == "__main__":
    main()
