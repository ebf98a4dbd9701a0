"""Policies: a network drives here as it does as a brain of the program; what does not fit is refused."""

from __future__ import annotations

import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from baudbot import Invalid
from baudbot.gym import Env, Network, VectorEnv, save_policy
from common import PROGRAM, program, scenario

SECONDS = 20.0

#: A collision does not end the run, so that a random policy drives all of its time.
OPTIONS: dict[str, Any] = {"scenario": "wander", "collision": "stop-robot", "end__after_s": SECONDS}


def network(inputs: int, seed: int, hidden: int = 6, outputs: int = 2) -> Network:
    chance = np.random.default_rng(seed)
    sizes = [inputs, hidden, hidden, outputs]
    layers = [
        (chance.normal(size=(after, before)), chance.normal(size=after)) for before, after in zip(sizes, sizes[1:])
    ]
    return Network(layers, offset=chance.normal(size=inputs) * 0.1, scale=chance.uniform(0.5, 3.0, inputs))


def drive(env: Env, policy: Network, seed: int) -> tuple[str, set[tuple[float, ...]]]:
    """The state at the end, and all actions."""
    observation, _ = env.reset(seed=seed)
    actions, over = set(), False
    while not over:
        action = policy(observation)
        actions.add(tuple(action.tolist()))
        observation, _, terminated, truncated, _ = env.step(action)
        over = terminated or truncated
    return env.hash, actions


class Policies(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = str(Path(folder.name) / "policy.toml")

    def same(self, policy: Network, seed: int, fields: dict[str, Any] | None = None, **options: Any) -> str:
        """The program's run with the file is the environment's with the network, to the last bit."""
        options = {**OPTIONS, **options}
        env = Env(**options, overrides=fields)
        state, actions = drive(env, policy, seed)
        self.assertGreater(len(actions), 8, "the policy answers differently to different readings")
        save_policy(self.file, env, policy)
        given = {"seed": seed, "collision": "stop-robot", "end.after_s": SECONDS, **(fields or {})}
        sets = [part for path, value in given.items() for part in ("--set", f"{path}={value}")]
        for over in ("direct", "grpc"):
            run = program("run", options["scenario"], "--brain", self.file, "--over", over, *sets)
            self.assertEqual(run["state_hash"], state, over)
        return state

    def test_a_file_drives_as_the_network_did(self) -> None:
        states = {self.same(network(15, seed), seed) for seed in (1, 2)}
        self.assertEqual(len(states), 2)

    def test_without_ages_and_flat(self) -> None:
        self.same(network(5, 3), 3, ages=False)
        self.same(network(15, 4), 4, flat=True, max_age_s=0.03)

    def test_over_a_slow_cable_that_loses_messages(self) -> None:
        self.same(network(15, 5), 5, {"robots.robot.link.baud": 1200, "robots.robot.link.byte_error_rate": 0.02})

    def test_a_robot_that_is_asked_and_a_laser_of_its_own_cable(self) -> None:
        for name in ("khepera", scenario("hall")):
            shape = Env(name).shape
            inputs = len(shape.columns) + 2 * len(shape.sensors)
            policy = network(inputs, 6, outputs=len(shape.signals))
            self.same(Network(policy.layers, scale=0.1), 6, scenario=name)

    def test_many_at_once_and_a_network_for_each(self) -> None:
        """A network is the same in a row, alone and among others."""
        envs = VectorEnv(3, **OPTIONS)
        observation, _ = envs.reset(seed=1)
        singles = [network(15, seed) for seed in range(3)]
        layers = [
            tuple(np.stack([single.layers[place][part] for single in singles]) for part in (0, 1)) for place in range(3)
        ]
        scale = singles[0].scale
        together = Network(layers, scale=scale)
        for place, single in enumerate(singles):
            one = Network(single.layers, scale=scale)
            row = {name: values[place] for name, values in observation.items()}
            np.testing.assert_allclose(together(observation)[place], one(row), rtol=1e-6)
            np.testing.assert_allclose(one(observation)[place], one(row), rtol=1e-6)
        with self.assertRaisesRegex(Invalid, "are networks for many environments"):
            save_policy(self.file, envs, together)

    def test_an_environment_may_be_wrapped(self) -> None:
        wrapped = gymnasium.make("baudbot/Wander-v0")
        save_policy(self.file, wrapped, network(15, 1))
        self.assertIn("age of ir_left", Path(self.file).read_text())

    def test_what_does_not_fit_is_refused(self) -> None:
        env = Env(**OPTIONS, ages=False)
        zeros = (np.zeros((2, 5)), np.zeros(2))
        cases: list[tuple[Any, str]] = [
            ([], "layers: there is none"),
            ([np.zeros((2, 5, 1, 1))], r"layers\[0\]: must be two arrays"),
            ([(np.zeros((2, 5)), np.zeros(3))], r"layers\[0\]: has the shapes \(2, 5\) and \(3,\)"),
            ([zeros, zeros], r"layers\[1\]: has 5 inputs, but the layer before it has 2 neurons"),
            ([(np.full((2, 5), np.nan), np.zeros(2))], r"layers\[0\]: has numbers that are not finite"),
            ([([["a"] * 5] * 2, np.zeros(2))], r"layers\[0\]: is not an array of numbers"),
            ([(np.zeros((2, 4)), np.zeros(2))], r"layers\[0\]: has 4 inputs, but the environment observes 5: ir_left, "),
            ([(np.zeros((3, 5)), np.zeros(3))], r"layers\[0\]: has 3 neurons, but an action has 2 signals: left, right"),
        ]
        for layers, problem in cases:
            with self.subTest(problem), self.assertRaisesRegex(Invalid, problem):
                save_policy(self.file, env, layers)
        with self.assertRaisesRegex(Invalid, r"scale: has shape \(4,\), but \(5,\) is needed"):
            save_policy(self.file, env, [zeros], scale=np.ones(4))
        with self.assertRaisesRegex(Invalid, "the network has its own"):
            save_policy(self.file, env, Network([zeros]), scale=np.ones(5))
        self.assertFalse(Path(self.file).exists())


    def test_a_robot_with_other_sensors_is_refused_by_their_names(self) -> None:
        env = Env("wander", ages=False)
        save_policy(self.file, env, [(np.zeros((2, 5)), np.zeros(2))])
        for run, problem in (
            (["khepera"], "policy.sensors[0]: robot `khepera` has no `ir_left`, with which the policy was learnt; it has: "),
            (
                ["wander", "--set", "robots.robot.sensors.extra={ kind = 'odometer' }"],
                "policy.sensors: robot `robot` has a `extra`, without which the policy was learnt",
            ),
        ):
            run = [PROGRAM, "run", *run, "--brain", self.file, "--seconds", "1"]
            told = subprocess.run(run, capture_output=True, text=True)
            self.assertNotEqual(told.returncode, 0)
            self.assertIn(problem, told.stderr)


if __name__ == "__main__":
    unittest.main()
