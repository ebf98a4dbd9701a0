"""A world in this process: the same bits as everywhere, readings as arrays, and errors that name what is wrong."""

from __future__ import annotations

import _thread
import copy
import os
import pickle
import signal
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import baudbot
import numpy as np
from common import ROOT, nearest_steer, program, scenario


class TheSameBits(unittest.TestCase):
    def test_as_the_program_and_its_server(self) -> None:
        for name, brain in [("wander", "avoid"), ("khepera", "avoid"), (scenario("ecoli"), "ecoli")]:
            with self.subTest(name):
                world = baudbot.World(name, seed=5, brains=brain, end__after_s=8.0)
                world.run()
                arguments = ["run", name, "--seed", "5", "--brain", brain, "--seconds", "8"]
                told = [program(*arguments), program(*arguments, "--over", "grpc")]
                self.assertEqual([world.hash] * 2, [one["state_hash"] for one in told])

    def test_driven_from_here_as_by_a_program_over_a_socket(self) -> None:
        world = baudbot.World("wander", seed=2, overrides={"end.after_s": 10.0, "robots.robot.link.baud": 4800})
        while world.step(nearest_steer(world.readings.values.max())):
            pass
        brain = f"exec:{sys.executable} {Path(__file__).parent / 'steer.py'}"
        settings = ["--set", "robots.robot.link.baud=4800", "--seconds", "10"]
        told = program("run", "wander", "--seed", "2", "--brain", brain, *settings)
        self.assertGreater(told["robots"][0]["distance_m"], 1.0)
        self.assertEqual(world.hash, told["state_hash"])

    def test_a_snapshot_goes_on_as_the_run_did(self) -> None:
        world = baudbot.World("wander", seed=1)
        for _ in range(30):
            world.step([0.5, 0.4])
        kept, values = world.snapshot(), world.readings.values.copy()
        hashes = []
        for _ in range(2):
            for _ in range(30):
                world.step([0.4, 0.5])
            hashes.append(world.hash)
            world.restore(kept)
            np.testing.assert_array_equal(world.readings.values, values)
        self.assertEqual(hashes[0], hashes[1])

    def test_a_reset_is_a_new_world(self) -> None:
        world = baudbot.World("wander", seed=3)
        world.step([0.5, 0.5])
        world.reset(seed=4, robots__robot__start__x_m=0.1)
        self.assertEqual(world.hash, baudbot.World("wander", seed=4, robots__robot__start__x_m=0.1).hash)


class Copies(unittest.TestCase):
    def driven(self) -> baudbot.World:
        world = baudbot.World("wander", seed=1, robots__robot__link__baud=4800)
        world.reset(seed=7, robots__robot__start__x_m=0.1)
        for _ in range(20):
            world.step([0.5, 0.4])
        return world

    def test_a_copy_is_the_same_and_goes_its_own_way(self) -> None:
        for what, make in {"deepcopy": copy.deepcopy, "copy": copy.copy, "pickle": lambda one: pickle.loads(pickle.dumps(one))}.items():
            with self.subTest(what):
                world = self.driven()
                other = make(world)
                self.assertEqual((other.hash, other.time_s, other.seed), (world.hash, world.time_s, 7))
                np.testing.assert_array_equal(other.readings.values, world.readings.values)
                before = world.hash
                for _ in range(20):
                    other.step([0.3, 0.5])
                self.assertEqual(world.hash, before)
                for _ in range(20):
                    world.step([0.3, 0.5])
                self.assertEqual(other.hash, world.hash)
                np.testing.assert_array_equal(other.readings["ir_front"], world.readings["ir_front"])

    def test_snapshots_are_of_a_world_and_its_copies(self) -> None:
        world = self.driven()
        kept, other = world.snapshot(), copy.deepcopy(world)
        before = world.hash
        other.step([1.0, 1.0])
        other.restore(kept)
        self.assertEqual(other.hash, before)
        with self.assertRaisesRegex(TypeError, "pickle the world itself"):
            pickle.dumps(kept)

    def test_a_pickle_needs_no_file(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "own.toml"
            file.write_text(Path(scenario("wander")).read_text())
            world = baudbot.World(file, seed=2)
            world.step([0.5, 0.5])
            pickled, before = pickle.dumps(world), world.hash
        self.assertEqual(pickle.loads(pickled).hash, before)

    def test_what_brains_think_is_not_copied_and_says_so(self) -> None:
        world = baudbot.World("wander", brains="avoid")
        for make in (copy.deepcopy, pickle.dumps):
            with self.assertRaisesRegex(baudbot.Invalid, "thoughts cannot be copied"):
                make(world)
        world.close()
        self.assertIn("closed", repr(copy.deepcopy(world)))


class WhatABrainHas(unittest.TestCase):
    def test_readings_are_views_that_are_renewed(self) -> None:
        world = baudbot.World("wander", seed=1)
        view, before = world.readings["ir_front"], world.readings["ir_front"].copy()
        while world.step([0.5, 0.5]) and (view == before).all():
            pass
        self.assertTrue((view != before).any())
        self.assertEqual((view.shape, view.dtype), ((1,), np.float64))
        self.assertEqual(world.readings.columns[0], "ir_left")
        with self.assertRaises(ValueError):
            view[0] = 1.0
        with self.assertRaisesRegex(KeyError, "ir_frnt"):
            world.readings["ir_frnt"]

    def test_a_robot_that_answers_only_when_asked_is_asked_in_each_step(self) -> None:
        world = baudbot.World("khepera", seed=1)
        for _ in range(5):
            before = world.time_s
            world.step()
            self.assertLess(world.time_s - before, 0.5)
            self.assertTrue(world.readings.readable.any())

    def test_ages_are_those_of_the_cable(self) -> None:
        ages = {}
        for baud in (1200, 9600):
            world = baudbot.World("wander", seed=1, robots__robot__link__baud=baud)
            for _ in range(10):
                world.step([0.2, 0.2])
            ages[baud] = world.readings.ages_s.min()
        # 19 bytes of ten bits.
        self.assertGreater(ages[1200], 190 / 1200)
        self.assertTrue(190 / 9600 < ages[9600] < 0.03)

    def test_several_robots_are_driven_by_name(self) -> None:
        world = baudbot.World(scenario("ecoli"), brains={"cell-1": "ecoli"})
        self.assertEqual(len(world.driven), len(world.robots) - 1)
        robot = world.driven[0]
        self.assertTrue(world.step({robot: [0.5, 0.5]}))
        self.assertEqual(len(world.readings_of(robot).values), 3)
        with self.assertRaisesRegex(baudbot.Invalid, "name one of"):
            world.readings
        with self.assertRaisesRegex(baudbot.Invalid, "cell-1"):
            world.step({"cell-1": [0.5, 0.5]})


class Pictures(unittest.TestCase):
    def test_a_notebook_shows_the_world_and_its_timing(self) -> None:
        world = baudbot.World("wander", seed=1)
        self.assertIn("<svg", world._repr_html_())
        with self.assertRaisesRegex(baudbot.Error, "nothing has happened"):
            world.diagram()
        world.keep_events()
        for _ in range(5):
            world.step([0.5, 0.5])
        picture = world.diagram()
        self.assertIn("cable up", picture)
        with tempfile.TemporaryDirectory() as folder:
            picture.save(os.path.join(folder, "a.svg"))
            self.assertGreater(os.path.getsize(os.path.join(folder, "a.svg")), 1000)

    def test_the_budget_is_that_of_the_program(self) -> None:
        # A program drives the world, whatever brain a run would take by itself; what it writes is not known but by its word.
        self.assertEqual(baudbot.World("wander").budget(), program("budget", "wander", "--writes", "on-message"))


class BadInput(unittest.TestCase):
    def invalid(self, path: str | None, words: str, **options: object) -> None:
        with self.assertRaisesRegex(baudbot.Invalid, words) as caught:
            baudbot.World(**options)  # type: ignore[arg-type]
        self.assertEqual(caught.exception.path, path)

    def test_fields_are_named(self) -> None:
        self.invalid("robots[0].link.baud", "must be between", scenario="wander", robots__robot__link__baud=0)
        self.invalid(None, "no scenario of this name is built in", scenario="no-such-scenario")
        self.invalid("seed", "whole number", scenario="wander", seed=-1)
        self.invalid("seed", "whole number", scenario="wander", seed=1.5)
        self.invalid(None, "avoyd", scenario="wander", brains="avoyd")
        self.invalid("name", "no value of the kind object", scenario="wander", name=object())
        self.invalid("agents", "program of its own", scenario=scenario("firmware"), agents=["robot"])
        self.invalid(None, "robot", scenario="wander", agents=["robt"])
        self.invalid(None, "expected", scenario="[[robots]\n")

    def test_a_budget_leaves_no_robot_out(self) -> None:
        with self.assertRaisesRegex(baudbot.Invalid, "robot.*baudbot budget"):
            baudbot.World(scenario("firmware")).budget()

    def test_actions_are_checked_and_change_nothing(self) -> None:
        world = baudbot.World("wander", seed=1)
        before = world.hash
        for action, words in [
            ([0.1], "takes 2: left, right"),
            ([0.1, 0.2, 0.3], "takes 2"),
            ([0.1, float("nan")], "right. is NaN"),
        ]:
            with self.assertRaisesRegex(baudbot.Invalid, words):
                world.step(action)
        for action in (["left", "right"], 0.5, [[0.1, 0.2]]):
            with self.assertRaisesRegex(baudbot.Invalid, "is not a list of numbers"):
                world.step(action)
        self.assertEqual(world.hash, before)
        world.step([7.0, -7.0])

    def test_a_closed_world_says_so(self) -> None:
        with baudbot.World("wander") as world:
            world.step([0.1, 0.1])
        for use in (lambda: world.step([0.1, 0.1]), lambda: world.hash, lambda: world.snapshot(), lambda: world.svg()):
            with self.assertRaisesRegex(baudbot.Closed, "closed"):
                use()
        self.assertIn("closed", repr(world))

    def test_a_world_is_for_one_thread_at_a_time(self) -> None:
        world = baudbot.World(scenario("ecoli"), brains="ecoli")
        busy: list[BaseException] = []

        def run() -> None:
            try:
                world.run(20.0)
            except baudbot.Busy as error:
                busy.append(error)

        threads = [threading.Thread(target=run) for _ in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertLessEqual(len(busy), 3)
        self.assertGreaterEqual(world.time_s, 20.0)

    def test_a_world_that_another_thread_runs_is_not_closed(self) -> None:
        world = baudbot.World(scenario("ecoli"), brains="ecoli", end__after_s=1e6)
        thread = threading.Thread(target=lambda: world.run(300.0))
        thread.start()
        with self.assertRaises(baudbot.Busy):
            while thread.is_alive():
                world.time_s
        with self.assertRaisesRegex(baudbot.Busy, "another thread"):
            while thread.is_alive():
                world.close()
        thread.join()
        self.assertGreaterEqual(world.time_s, 300.0)
        world.close()

    def test_a_forked_process_goes_on(self) -> None:
        from baudbot.gym import VectorEnv

        envs = VectorEnv(8, "wander", threads=2)
        envs.reset(seed=1)
        actions = np.full((8, 2), 0.3, np.float32)
        envs.step(actions)
        child = os.fork()
        if child == 0:
            signal.alarm(20)
            envs.step(actions)
            os._exit(0)
        envs.step(actions)
        self.assertEqual(os.waitpid(child, 0)[1], 0)

    def test_ctrl_c_ends_a_long_run_between_two_ticks(self) -> None:
        world = baudbot.World(scenario("ecoli"), brains="ecoli", end__after_s=1e6)
        threading.Timer(0.3, _thread.interrupt_main).start()
        with self.assertRaises(KeyboardInterrupt):
            world.run()
        self.assertLess(world.time_s, 1e6)
        world.run(1.0)


class Recordings(unittest.TestCase):
    def test_replays_and_comparisons(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            files = [os.path.join(folder, name) for name in ("a.mcap", "b.mcap", "c.mcap")]
            for file, baud in zip(files, (9600, 9600, 4800), strict=True):
                settings = ["--set", f"robots.robot.link.baud={baud}", "--seconds", "3", "--record", file]
                told = program("run", "wander", *settings)
            replayed = baudbot.replay(files[2])
            self.assertEqual((replayed.hash, replayed.difference), (told["state_hash"], None))
            self.assertIsNone(replayed.incomplete)
            same = baudbot.compare(files[0], files[1])
            self.assertEqual((same.difference, same.last_tick, same.incomplete), (None, replayed.last_tick, None))
            self.assertIsNotNone(baudbot.compare(files[0], files[2]).difference)
            self.assertGreater(len(list(baudbot.open(files[0]).rows())), 10)
        with self.assertRaisesRegex(baudbot.Error, "nothing.mcap"):
            baudbot.replay("nothing.mcap")
        with self.assertRaisesRegex(baudbot.Error, "README"):
            baudbot.replay(str(ROOT / "README.md"))


    def test_a_file_that_is_cut_says_how_much_was_compared(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            whole, cut = (os.path.join(folder, name) for name in ("whole.mcap", "cut.mcap"))
            program("run", "wander", "--seconds", "60", "--record", whole)
            data = Path(whole).read_bytes()
            Path(cut).write_bytes(data[: len(data) * 2 // 3])
            replayed, compared = baudbot.replay(cut), baudbot.compare(whole, cut)
            self.assertIsNone(replayed.difference)
            self.assertLess(replayed.last_tick, 6000)
            self.assertRegex(replayed.incomplete or "", rf"^the file is cut off.*; compared in the {replayed.last_tick} ticks")
            self.assertEqual((compared.difference, compared.last_tick), (None, replayed.last_tick))
            self.assertEqual(compared.incomplete, f"{cut}: {replayed.incomplete}")


if __name__ == "__main__":
    unittest.main()
