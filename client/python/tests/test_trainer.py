"""Trainers against a real server: many worlds, the truth, resets, and what is refused."""

import math
import sys
import unittest
from pathlib import Path

import baudbot
from server import ROOT, WithServer
from server import baudbot as baudbot_program

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))
import evolve  # noqa: E402


def drives(turn):
    """A policy without a state."""
    near = turn.value("ir_front", 0.0)
    return baudbot.drive(0.4, 0.4 - 0.5 * near)


class Drives(baudbot.Brain):
    """A brain that does the same."""

    def step(self, turn):
        return drives(turn)


class WithTrainer(WithServer):
    def train(self, **options):
        folder = self.folder()
        self.address = f"unix:{folder}/trainer.sock"
        self.server = self.serve("wander", "--paused", "--trainer", self.address, folder=folder)
        trainer = baudbot.Trainer(self.address, **options)
        self.addCleanup(trainer.close)
        return trainer


def run(trainer, results):
    """Drives all worlds to the end of their runs."""
    while not all(result.ended for result in results):
        results = trainer.step([None if result.ended else drives(result.turn) for result in results])
    return results


class Trains(WithTrainer):
    def test_worlds_are_made_driven_together_and_deleted(self):
        trainer = self.train()
        worlds = trainer.create("wander", count=64, seeds=range(64), baud=4800, set={"end.after_s": 1.0})
        self.assertEqual([world.name for world in worlds[::63]], ["trained-1", "trained-64"])
        results = run(trainer, trainer.results)
        self.assertEqual({(result.tick, result.time_s, result.ended) for result in results}, {(100, 1.0, "time-is-over")})
        self.assertEqual([result.world for result in results], [world.name for world in worlds])
        self.assertTrue(all(result.truth.distance_m > 0.1 for result in results))
        trainer.close()
        with baudbot.Client(self.server.tcp) as client:
            self.assertEqual([world.name for world in client.worlds()], ["wander"])

    def test_a_trainer_and_a_brain_make_the_same_run(self):
        trainer = self.train()
        with baudbot.Client(self.server.tcp) as client:
            other = client.create_world("wander", "other", seed=3, set={"end.after_s": 5.0, "robots.robot.start.x_m": 0.25})
            baudbot.attach(Drives, connect=self.server.tcp, world="other")
            (world,) = trainer.create("wander", seed=9, set={"end.after_s": 5.0})
            run(trainer, trainer.reset(seed=3, set={"robots.robot.start.x_m": 0.25}))
            self.assertEqual(world.hash, other.hash)
            other.reset(seed=9, poses={"robot": (-0.2, 0.0, 0.0)})
            trainer.reset()
            self.assertEqual(other.status.tick, 0)

    def test_the_truth_is_told_at_each_turn(self):
        trainer = self.train(every_tick=True)
        trainer.create("wander", count=2, set={"end.after_s": 3.0, "collision": "stop-robot"})
        poses = [{"robot": (0.1, 0.2, math.pi / 2)}, {"robot": (0.3, 0.0, 0.0)}]
        results = trainer.reset(seed=[1, 2], poses=poses)
        self.assertEqual([(r.tick, r.truth.x_m, r.truth.y_m) for r in results], [(0, 0.1, 0.2), (0, 0.3, 0.0)])
        ticks, hits = [], 0
        while not results[1].ended:
            ticks.append(results[1].turn.tick)
            results = trainer.step({"trained-2": baudbot.drive(0.6, 0.6), "trained-1": None})[::-1]
            hits += results[1].truth.collided
        self.assertEqual(ticks, list(range(300)))
        self.assertGreater(results[1].truth.x_m, 0.3)
        self.assertTrue(0 < hits <= results[1].truth.collisions, (hits, results[1].truth.collisions))
        self.assertEqual(results[0].truth.collisions, 0)

    def test_other_worlds_are_opened_by_patterns_and_go_on_when_it_leaves(self):
        trainer = self.train()
        with baudbot.Client(self.server.tcp) as client:
            for name in ("a-1", "a-2"):
                client.create_world("wander", name, set={"end.after_s": 0.2})
            self.assertEqual([world.name for world in trainer.open(["a-*"])], ["a-1", "a-2"])
            with self.assertRaises(baudbot.Taken):
                baudbot.attach(Drives, connect=self.server.tcp, world="a-1")
            run(trainer, trainer.results)
            trainer.close()
            self.assertEqual(client.world("a-1").status.tick, 20)

    def test_refusals_say_what_to_do_and_leave_the_worlds_as_they_are(self):
        trainer = self.train()
        trainer.create("wander", count=2)
        before = trainer.results
        for reset, text in [
            (lambda: trainer.reset(poses={"robot": (1.8, 0.0, 0.0)}), "world `trained-1`: starts: robots[0].start: at (1.8, 0)"),
            (lambda: trainer.reset(poses={"bob": (0.0, 0.0, 0.0)}), "starts[0].robot: there is no robot `bob`"),
            (lambda: trainer.reset(set={"robots.robot.body.radius_m": 0.15}), "brains get this only when they attach"),
            (lambda: trainer.reset(["trained-3"]), "there is no world of this trainer `trained-3`; did you mean"),
            (lambda: trainer.reset(seed=[1, 2, 3]), "seed: there are 3, but one for each of 2 worlds is needed"),
            (lambda: trainer.step([None]), "commands: there are 1, but one for each of 2 worlds is needed"),
            (lambda: trainer.step([{"bob": None}, None]), "there is no robot of world `trained-1` `bob`"),
            (lambda: trainer.create("wander"), "this trainer drives 2 worlds already"),
        ]:
            with self.assertRaises(baudbot.Error, msg=text) as caught:
                reset()
            self.assertIn(text, str(caught.exception))
            self.assertEqual(str(caught.exception).count("\n"), 0)
        self.assertEqual([(r.tick, r.truth.x_m) for r in trainer.results], [(r.tick, r.truth.x_m) for r in before])
        self.assertEqual({r.tick for r in trainer.step([None, None])}, {2}, "the first message comes then")
        # A world that is gone says so where somebody looks at it, and the other goes on.
        trainer.client.world("trained-1").delete()
        results = trainer.step([None, None])
        self.assertIsInstance(results[0].error, baudbot.Detached)
        with self.assertRaisesRegex(baudbot.Detached, "world `trained-1` was deleted"):
            results[0].turn  # noqa: B018
        self.assertIsNone(results[1].error)
        self.assertEqual(results[1].turn.body.robot, "robot")

    def test_what_was_refused_can_be_said_again(self):
        trainer = self.train()
        names = lambda: [world.name for world in trainer.client.worlds()]  # noqa: E731
        for refused in [
            lambda: trainer.create("wander", seeds=[1, -1]),
            lambda: trainer.create("wander", count=0),
            lambda: trainer.create("wander", count=2, pace="free"),
            lambda: trainer.open("wander"),
        ]:
            with self.assertRaises(baudbot.Refused):
                refused()
            self.assertEqual(names(), ["wander"], "nothing is left over")
        worlds = trainer.create("wander", count=2, set={"end.after_s": 1.0})
        self.assertEqual([world.name for world in worlds], ["trained-1", "trained-2"])
        # What the first robot was to do is forgotten with what was refused.
        with self.assertRaises(baudbot.NotFound):
            trainer.step([baudbot.drive(1.0, 1.0), {"bob": None}])
        results = trainer.step([None, None])
        while not all(result.ended for result in results):
            results = trainer.step([None, None])
        self.assertEqual([result.truth.distance_m for result in results], [0.0, 0.0])
        # A world's own name, a single world, and any iterable of seeds.
        self.assertEqual([result.world for result in trainer.reset("trained-2", seed=iter([7]))], ["trained-2"])
        self.assertEqual([bool(result.ended) for result in trainer.results], [True, False])

    def test_a_command_that_makes_no_sense_names_its_world(self):
        trainer = self.train()
        trainer.create("wander", count=3)
        with self.assertRaises(baudbot.Refused) as caught:
            trainer.step({"trained-1": None, "trained-3": baudbot.drive(math.nan, 0.0)})
        text = "world `trained-3`: the server says: worlds[1].step.robots[0].command.left_signal: must be a finite number"
        self.assertTrue(str(caught.exception).startswith(text), caught.exception)

    def test_all_worlds_are_deleted_though_somebody_has_deleted_one(self):
        trainer = self.train()
        trainer.create("wander", count=3)
        trainer.client.world("trained-2").delete()
        trainer.close()
        with baudbot.Client(self.server.tcp) as client:
            self.assertEqual([world.name for world in client.worlds()], ["wander"])

    def test_several_robots_of_a_world_go_by_their_names(self):
        trainer = self.train(patience_s=None)
        text = (ROOT / "catalogue/scenarios/wander.toml").read_text()
        other = text[text.index("[[robots]]"):].replace('name = "robot"', 'name = "slow"').replace("x_m = -0.2", "x_m = 0.3")
        slow = "robots.slow.firmware.period_ms"
        trainer.create(f"{text}\n{other}", set={"end.after_s": 1.0, slow: 50.0})
        (result,) = trainer.results
        alone = 0
        while not result.ended:
            self.assertEqual(len(result.truths), 2)
            alone += len(result.turns) == 1
            for member in ("turn", "truth"):
                with self.assertRaisesRegex(baudbot.Error, f"has 2 robots; choose by a robot's name: result.{member}s"):
                    getattr(result, member)
            (result,) = trainer.step([{name: drives(turn) for name, turn in result.turns.items()}])
        self.assertGreater(alone, 0, "a single robot had a turn, and was not taken for the only one")

    def test_only_this_machine_trains(self):
        done = baudbot_program("serve", "--trainer", "0.0.0.0:0", "--listen", "127.0.0.1:0")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("0.0.0.0:0: a trainer's address must be on this machine", done.stderr)
        server = self.serve("wander")
        with self.assertRaisesRegex(baudbot.Refused, "address of `baudbot serve --trainer`"), baudbot.Trainer(server.tcp) as trainer:
            trainer.create("wander")
        with baudbot.Client(server.tcp) as client:
            self.assertEqual([world.name for world in client.worlds()], ["wander"])
        self.train()
        with self.assertRaisesRegex(baudbot.Refused, "brains and observers to that of `--listen`"):
            baudbot.attach(Drives, connect=self.address, world="wander")


class Evolves(WithTrainer):
    def test_a_few_generations_become_better(self):
        trainer = self.train()
        trainer.create("wander", count=evolve.WORLDS, set={"end.after_s": 3.0})
        best = evolve.evolve(trainer, generations=4)
        self.assertEqual(len(best), 4)
        self.assertEqual(best, sorted(best))
        self.assertGreater(best[-1], best[0])


if __name__ == "__main__":
    unittest.main()
