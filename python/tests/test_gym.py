"""Environments of Gymnasium and PettingZoo: their own checkers, the same bits on any number of threads, and bad input."""

from __future__ import annotations

import copy
import pickle
import tempfile
import unittest
import warnings
from typing import Any

import baudbot
import gymnasium
import numpy as np
from baudbot.gym import Env, Step, VectorEnv
from baudbot.pettingzoo import parallel_env
from common import nearest_steer, scenario
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from pettingzoo.test import parallel_api_test, parallel_seed_test

#: Five kinds: IR over a serial cable; Khepera's protocol, which is asked; a laser of its own cable; a crowd; a brain on board.
KINDS: dict[str, dict[str, Any]] = {
    "wander": {"scenario": "wander", "end__after_s": 3.0},
    "khepera": {"scenario": "khepera", "end__after_s": 3.0},
    "laser": {"scenario": scenario("hall"), "end__after_s": 3.0},
    "crowd": {"scenario": scenario("ecoli"), "end__after_s": 8.0},
    "on board": {"scenario": "wander", "end__after_s": 3.0, "overrides": {"robots.robot.link": {"kind": "onboard"}}},
}


def one(name: str) -> dict[str, Any]:
    """The same with one robot that is driven."""
    return {**KINDS[name], "brains": "ecoli", "robot": "cell-1"} if name == "crowd" else KINDS[name]


def steered(observation: Any) -> np.ndarray:
    rows = np.atleast_2d(observation["readings"]).max(axis=1)
    return np.asarray([nearest_steer(float(nearest)) for nearest in rows], np.float32)


class Refusing(unittest.TestCase):
    def refused(self, words: str, call: Any) -> None:
        with self.assertRaisesRegex(baudbot.Error, words):
            call()


class Checkers(unittest.TestCase):
    def test_gymnasium(self) -> None:
        for name in KINDS:
            with self.subTest(name), warnings.catch_warnings():
                warnings.simplefilter("error")
                # Counts and distances have no bounds; the names have an environment of their own below.
                warnings.filterwarnings("ignore", message=".*(infinity|not having a spec).*")
                options = {key: value for key, value in one(name).items()}
                if name == "crowd":
                    # A brain for all would leave none to drive.
                    world = baudbot.World(KINDS[name]["scenario"])
                    options["brains"] = {robot: "ecoli" for robot in world.robots if robot != "cell-1"}
                check_env(Env(**options, render_mode="rgb_array"), skip_close_check=False)

    def test_pettingzoo(self) -> None:
        for name, options in KINDS.items():
            with self.subTest(name):
                parallel_api_test(parallel_env(**options), num_cycles=100)
                parallel_seed_test(lambda options=options: parallel_env(**options), num_cycles=50)

    def test_names_are_known_wherever_gymnasium_is_imported(self) -> None:
        env = gymnasium.make("baudbot/Wander-v0", end__after_s=1.0)
        env.reset(seed=1)
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step(env.action_space.sample() * 0)
            over = terminated or truncated
        self.assertEqual((terminated, truncated, info["ending"]), (False, True, "the scenario's time is over"))
        envs = gymnasium.make_vec("baudbot/Wander-v0", num_envs=3)
        self.assertIsInstance(envs.unwrapped, VectorEnv)

    def test_a_vector_is_what_its_environments_are(self) -> None:
        """Beside Gymnasium's own vector environment, with runs that end and begin again."""
        options = {"scenario": "wander", "end__after_s": 0.6}
        ours = VectorEnv(4, **options)
        theirs = SyncVectorEnv([lambda: Env(**options) for _ in range(4)], autoreset_mode=AutoresetMode.NEXT_STEP)
        self.assertEqual(ours.single_observation_space, theirs.single_observation_space)
        self.assertEqual(ours.observation_space, theirs.observation_space)
        self.assertEqual(ours.action_space, theirs.action_space)
        observed = [envs.reset(seed=7)[0] for envs in (ours, theirs)]
        ended = 0
        for _ in range(29):
            np.testing.assert_equal(*[{key: np.asarray(value) for key, value in one.items()} for one in observed])
            actions = steered(observed[0])
            steps = [envs.step(actions) for envs in (ours, theirs)]
            for ours_part, their_part in zip(steps[0][1:4], steps[1][1:4], strict=True):
                np.testing.assert_array_equal(ours_part, their_part)
            observed = [step[0] for step in steps]
            ended += int(steps[0][3].sum())
        self.assertEqual(ended, 4)


    def test_infos_are_those_that_gymnasiums_own_vector_gives(self) -> None:
        options = {"scenario": "wander", "end__after_s": 0.6}
        for mode in (AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP):
            with self.subTest(mode):
                ours = VectorEnv(3, **options, autoreset_mode=mode)
                theirs = SyncVectorEnv([lambda: Env(**options) for _ in range(3)], autoreset_mode=mode)
                told = [envs.reset(seed=7)[1] for envs in (ours, theirs)]
                self.alike(*told)
                ended = 0
                for _ in range(65):
                    actions = np.full((3, 2), 0.3, np.float32)
                    told = [envs.step(actions)[4] for envs in (ours, theirs)]
                    self.alike(*told)
                    of_last = told[0].get("final_info", told[0])
                    ended += sum(ending is not None for ending in of_last.get("ending", []))
                self.assertGreaterEqual(ended, 6)

    def alike(self, ours: dict[str, Any], theirs: dict[str, Any]) -> None:
        """The same names, types and masks, and the same endings. Seeds of later runs are of our own making."""
        self.assertEqual(ours.keys(), theirs.keys())
        for name, value in ours.items():
            if isinstance(value, dict):
                self.alike(value, theirs[name])
                continue
            self.assertEqual((value.dtype, value.shape), (theirs[name].dtype, theirs[name].shape), name)
            if name.startswith("_") or name in ("ending", "time_s"):
                np.testing.assert_array_equal(value, theirs[name], name)


class Copies(unittest.TestCase):
    def test_an_environment_is_pickled_and_copied_with_its_state(self) -> None:
        named = gymnasium.make("baudbot/Wander-v0", end__after_s=5.0)
        flat = Env("wander", flat=True, randomize={"robots.robot.start.x_m": {"uniform": [-0.2, 0.2]}}, reward={"seconds": 2.0})
        action = np.full(2, 0.4, np.float32)
        for env in (named, flat):
            pickle.loads(pickle.dumps(env))
            env.reset(seed=3)
            for _ in range(10):
                env.step(action)
            others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
            for _ in range(10):
                ours = env.step(action)
                for other in others:
                    theirs = other.step(action)
                    np.testing.assert_equal(theirs[0], ours[0])
                    self.assertEqual(theirs[1:], ours[1:])
            # The seed of the next run is drawn from the same generator.
            env.reset(), [other.reset() for other in others]
            self.assertEqual({env.unwrapped.hash}, {other.unwrapped.hash for other in others})

    def test_a_vector_says_what_to_do(self) -> None:
        envs = VectorEnv(2, "wander")
        for make in (copy.deepcopy, copy.copy, pickle.dumps):
            with self.assertRaisesRegex(TypeError, "make another"):
                make(envs)


class Bits(Refusing):
    def test_64_worlds_on_two_threads_are_64_on_one(self) -> None:
        hashes = set()
        for threads in (1, 2, 3):
            envs = VectorEnv(64, "wander", threads=threads, end__after_s=2.0, autoreset_mode=AutoresetMode.SAME_STEP)
            observation, _ = envs.reset(seed=1)
            for _ in range(150):
                observation, *_ = envs.step(steered(observation))
            hashes.add(envs.hash)
        self.assertEqual(len(hashes), 1)

    def test_an_environment_is_a_world(self) -> None:
        env = Env("wander")
        observation, _ = env.reset(seed=9)
        world = baudbot.World("wander", seed=9)
        for _ in range(100):
            action = steered(observation)[0]
            observation, *_ = env.step(action)
            world.step(action)
        self.assertEqual(env.hash, world.hash)
        np.testing.assert_array_equal(observation["readings"], world.readings.values.astype(np.float32))

    def test_each_environment_may_have_a_seed_of_its_own(self) -> None:
        envs = VectorEnv(3, "wander")
        together = envs.reset(seed=5)[1]["seed"].tolist()
        self.assertEqual(envs.reset(seed=[5, 6, 7])[1]["seed"].tolist(), together)
        first, _, last = envs.reset(seed=[7, None, 5])[1]["seed"].tolist()
        self.assertEqual([first, last], [together[2], together[0]])
        self.refused("3 environments", lambda: envs.reset(seed=[1, 2]))
        self.refused("seed", lambda: envs.reset(seed=[1, 2, -3]))

    def test_environments_without_a_seed_do_not_start_alike(self) -> None:
        starts = [VectorEnv(2, "wander").reset()[1]["seed"].tolist() for _ in range(3)]
        self.assertNotEqual(starts[0], starts[1])
        self.assertNotEqual(starts[1], starts[2])
        seeded = [VectorEnv(2, "wander") for _ in range(2)]
        for envs in seeded:
            envs.reset(seed=3)
        self.assertEqual(*(envs.reset()[1]["seed"].tolist() for envs in seeded))

    def test_infinity_is_no_action(self) -> None:
        envs, env = VectorEnv(2, "wander"), Env("wander")
        envs.reset(seed=1), env.reset(seed=1)
        self.refused(r"actions\[1, 0\]: is inf", lambda: envs.step(np.array([[0, 0], [np.inf, 0]], np.float32)))
        self.refused("the signal for `right` is -inf", lambda: env.step(np.array([0, -np.inf], np.float32)))

    def test_a_run_that_is_over_as_soon_as_it_begins_says_so_each_time(self) -> None:
        options: dict[str, Any] = {"randomize": {"robots.robot.start.x_m": [2.0]}, "reward": {"success": 1}}
        ours = VectorEnv(2, scenario("wedge"), **options)
        theirs = SyncVectorEnv([lambda: Env(scenario("wedge"), **options)] * 2)
        told = []
        for envs in (ours, theirs):
            envs.reset(seed=1)
            told.append([envs.step(np.zeros((2, 2), np.float32))[2].tolist() for _ in range(6)])
        self.assertEqual(*told)
        self.assertIn([True, True], told[0])

    def test_a_robot_without_sensors_has_an_environment(self) -> None:
        env = Env(scenario("grid-wall"))
        observation, _ = env.reset(seed=1)
        self.assertTrue(env.observation_space.contains(observation))
        env.step(np.zeros(2, np.float32))
        envs = VectorEnv(2, scenario("grid-wall"))
        self.assertTrue(envs.observation_space.contains(envs.reset(seed=1)[0]))
        envs.step(np.zeros((2, 2), np.float32))

    def test_last_observations_of_runs_that_end_in_the_same_step(self) -> None:
        envs = VectorEnv(3, "wander", end__after_s=0.5, autoreset_mode=AutoresetMode.SAME_STEP)
        envs.reset(seed=1)
        seen = 0
        for _ in range(60):
            *_, truncated, info = envs.step(np.zeros((3, 2), np.float32))
            seen += int(truncated.sum())
            self.assertEqual("final_obs" in info, bool(truncated.any()))
        self.assertGreaterEqual(seen, 6)


class WhatIsLearnt(unittest.TestCase):
    def test_rewards_by_weights_and_by_functions(self) -> None:
        def worth(step: Step) -> Any:
            return step.happened["distance_m"] - 5.0 * step.happened["collisions"]

        weighed, called = Env("wander"), Env("wander", reward=worth)
        many = VectorEnv(2, "wander", reward=worth)
        weighed.reset(seed=1), called.reset(seed=1), many.reset(seed=1)
        action = np.full(2, 0.4, np.float32)
        for _ in range(20):
            first, second = weighed.step(action)[1], called.step(action)[1]
            self.assertAlmostEqual(float(first), float(second), places=12)
            self.assertAlmostEqual(float(first), many.step(np.stack([action] * 2))[1][0], places=12)
        self.assertGreater(float(first), 0.0)

    def test_an_end_of_ones_own(self) -> None:
        env = Env("wander", end=lambda step: step.observation["readings"].max() > 0.05)
        env.reset(seed=1)
        for _ in range(500):
            _, _, terminated, _, _ = env.step(np.full(2, 0.5, np.float32))
            if terminated:
                return
        self.fail("it came near no wall")

    def test_fields_are_drawn_for_each_run(self) -> None:
        table = {"robots.robot.link.baud": [1200, 9600], "robots.robot.start.x_m": {"uniform": [-0.4, 0.4]}}
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write('[randomize]\n"robots.robot.link.baud" = [1200, 9600]\n"robots.robot.start.x_m" = { uniform = [-0.4, 0.4] }\n')
            file.flush()
            by_file = self.starts(Env("wander", randomize=file.name))
        by_table = self.starts(Env("wander", randomize=table))
        self.assertEqual(by_table, by_file)
        self.assertGreater(len(set(by_table)), 15)
        by_function = self.starts(Env("wander", randomize=lambda random: {"robots.robot.start.x_m": random.uniform(-0.1, 0.1)}))
        self.assertTrue(all(abs(float(start)) < 0.1 for start in by_function))

    def starts(self, env: Env) -> list[float]:
        starts = []
        for seed in range(20):
            env.reset(seed=seed)
            starts.append(env._open.truth(0)[0])
        return starts

    def test_ages_tell_cables_apart(self) -> None:
        ages = []
        for baud in (1200, 9600):
            env = Env("wander", robots__robot__link__baud=baud)
            env.reset(seed=1)
            ages.append(float(env.step(np.zeros(2, np.float32))[0]["ages_s"].min()))
        self.assertGreater(ages[0], 0.15)
        self.assertLess(ages[1], 0.03)

    def test_flat_observations(self) -> None:
        for ages, size in ((True, 15), (False, 5)):
            env = Env("wander", flat=True, ages=ages)
            observation, _ = env.reset(seed=1)
            self.assertEqual(observation.shape, (size,))
            self.assertTrue(env.observation_space.contains(observation))
            envs = VectorEnv(2, "wander", flat=True, ages=ages)
            self.assertTrue(envs.observation_space.contains(envs.reset(seed=1)[0]))


class Pictures(unittest.TestCase):
    def test_an_image_and_a_drawing(self) -> None:
        env = Env("wander", render_mode="rgb_array", render_size=300)
        env.reset(seed=1)
        image = env.render()
        self.assertEqual((image.dtype, image.ndim, max(image.shape)), (np.uint8, 3, 300))
        self.assertGreater(len(np.unique(image.reshape(-1, 3), axis=0)), 5)
        env.step(np.full(2, 1.0, np.float32))
        [env.step(np.full(2, 1.0, np.float32)) for _ in range(20)]
        self.assertTrue((env.render() != image).any())


class BadInput(Refusing):
    def test_options(self) -> None:
        self.refused("there is no part|no such part", lambda: Env("wander", reward={"distance": 1.0}))
        self.refused("name one of", lambda: Env(scenario("ecoli")))
        self.refused("render_mode", lambda: Env("wander", render_mode="human"))
        self.refused("num_envs", lambda: VectorEnv(0, "wander"))
        self.refused("num_envs", lambda: VectorEnv(1 << 40, "wander"))
        self.refused("one environment only", lambda: VectorEnv(2, "wander", randomize=lambda random: {}))
        self.refused("two numbers", lambda: Env("wander", randomize={"seed": {"uniform": 3}}))
        self.refused("not a range", lambda: Env("wander", randomize={"seed": {"uniform": [3, 1]}}))
        self.refused("max_age_s", lambda: Env("wander", max_age_s=0.0))
        self.refused("nothing.toml", lambda: Env("wander", randomize="nothing.toml"))
        self.refused("is not a mapping", lambda: Env("wander", randomize=3))
        self.refused("end.goal", lambda: Env("wander", reward={"progress_m": 1.0}))
        self.refused("metrics.cell_m", lambda: VectorEnv(2, "wander", reward={"covered": 1.0}))
        self.refused("no zones", lambda: parallel_env("wander", reward={"zones": 1.0}))
        self.refused("VectorEnv has no such option", lambda: VectorEnv(2, "wander", end=lambda step: True))
        self.refused("threads", lambda: VectorEnv(2, "wander", threads=-1))
        self.refused("threads", lambda: VectorEnv(2, "wander", threads=1 << 20))
        self.refused("seed", lambda: VectorEnv(2, "wander").reset(seed=(1 << 63) - 1))
        self.refused("there is no `overrides`", lambda: VectorEnv(2, "wander").reset(options={"overrides": {}}))
        self.refused("there is no `nix`", lambda: Env("wander").reset(options={"nix": 1}))
        single = VectorEnv(2, "wander", reward=lambda step: 1.0)
        single.reset(seed=1)
        self.refused("has shape", lambda: single.step(np.zeros((2, 2))))
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[randomise]\n")
            file.flush()
            self.refused("no table", lambda: Env("wander", randomize=file.name))

    def test_a_table_of_fields_may_be_nested(self) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write("[randomize.robots.robot]\nlink.baud = [1200, 2400]\nstart.x_m = { uniform = [-0.1, 0.1] }\n")
            file.flush()
            env = Env("wander", randomize=file.name)
        starts = [(env.reset(seed=seed), env._open.truth(0)[0])[1] for seed in range(5)]
        self.assertTrue(len(set(starts)) == 5 and max(map(abs, starts)) <= 0.1, starts)

    def test_actions(self) -> None:
        env = Env("wander")
        self.refused("reset it first", lambda: env.step(np.zeros(2, np.float32)))
        env.reset(seed=1)
        before = env.hash
        self.refused("takes 2", lambda: env.step(np.zeros(3, np.float32)))
        self.refused("NaN", lambda: env.step(np.full(2, np.nan, np.float32)))
        self.refused("is not an array", lambda: env.step("forward"))
        self.assertEqual(env.hash, before)
        envs = VectorEnv(4, "wander")
        envs.reset(seed=1)
        before = envs.hash
        actions = np.zeros((4, 2), np.float32)
        actions[2, 1] = np.nan
        self.refused(r"actions\[2, 1\]", lambda: envs.step(actions))
        self.refused("shape", lambda: envs.step(np.zeros((3, 2), np.float32)))
        self.assertEqual(envs.hash, before)
        envs.step(np.zeros((4, 4), np.float32)[:, ::2])
        envs.step(np.zeros((4, 2), np.float64))

    def test_more_than_there_is_memory_for(self) -> None:
        cells = {"robot": "cell-1", "brains": {}}
        with self.assertRaisesRegex(baudbot.Invalid, r"num_envs: 1048576 worlds, of about \d+ kB each, need .* GiB more, and .* free"):
            VectorEnv(1 << 20, scenario("ecoli"), **cells)

    def test_steps_before_the_first_reset(self) -> None:
        action = np.zeros(2, np.float32)
        steps = {
            "environment": lambda: Env("wander").step(action),
            "vector": lambda: VectorEnv(1, "wander").step(action[None]),
            "agents": lambda: parallel_env("wander").step({"robot": action}),
        }
        for name, step in steps.items():
            with self.subTest(name), self.assertRaisesRegex(gymnasium.error.ResetNeeded, "reset"):
                step()

    def test_closed(self) -> None:
        env, envs = Env("wander"), VectorEnv(2, "wander")
        env.reset(seed=1), envs.reset(seed=1)
        env.close(), envs.close()
        self.refused("closed", lambda: env.step(np.zeros(2, np.float32)))
        self.refused("closed", env.reset)
        self.refused("closed", lambda: envs.step(np.zeros((2, 2), np.float32)))

    def test_a_run_with_other_observations(self) -> None:
        env = Env("wander")
        sensors = {"robots.robot.sensors.compass": {"kind": "compass"}}
        self.refused("changes which robots|compass", lambda: env.reset(seed=1, options={"overrides": sensors}))
        env.reset(seed=1)

    def test_readings_that_never_come(self) -> None:
        env = Env("wander", robots__robot__link__byte_error_rate=1.0)
        observation, _ = env.reset(seed=1)
        self.assertTrue(env.observation_space.contains(observation))
        observation, *_ = env.step(np.zeros(2, np.float32))
        self.assertEqual((observation["readable"].sum(), observation["ages_s"].min()), (0, 1.0))


if __name__ == "__main__":
    unittest.main()
