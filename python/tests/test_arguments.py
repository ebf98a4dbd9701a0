"""Each argument of each public function, given what makes no sense: either it does something, or the error names the argument."""

from __future__ import annotations

import inspect
import os
import tempfile
import unittest
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import baudbot
import baudbot.gym
import baudbot.pettingzoo
import numpy as np
from baudbot.gym import Env, Network, VectorEnv, save_policy
from baudbot.pettingzoo import Parallel
from common import program
from test_runs import EXPERIMENT, TUNE

#: An error may name this, too: a file, a field, a robot.
NO = "no-such-thing"

NONSENSE: tuple[Any, ...] = (None, -1, 1 << 70, NO, NO.encode(), [], {}, {NO: object()}, float("nan"), object())

#: What other functions give, and nobody makes.
RESULTS = {
    "baudbot.Busy", "baudbot.Closed", "baudbot.Invalid", "baudbot.Compared", "baudbot.Picture", "baudbot.Readings",
    "baudbot.Replayed", "baudbot.Runs", "baudbot.Snapshot", "baudbot.gym.Shape", "baudbot.gym.Step", "baudbot.gym.register",
}  # fmt: skip

WORLD: dict[str, Any] = {"scenario": "wander", "end__after_s": 0.5}
LAYER = (np.zeros((2, 15)), np.zeros(2))


class Arguments(unittest.TestCase):
    def setUp(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(place.name)
        short = EXPERIMENT.replace("seconds = 5.0", "seconds = 0.1").replace("seeds = 6", "seeds = 1")
        Path("short.toml").write_text(short)
        ranges = short.replace("values = [2400, 9600]", "from = 1200.0\nto = 9600.0\nwhole = true")
        Path("tune.toml").write_text(ranges + TUNE)
        program("run", "wander", "--seconds", "0.1", "--record", "run.mcap")

    def world(self, **more: Any) -> baudbot.World:
        return baudbot.World(**WORLD, **more)

    def doors(self) -> dict[str, tuple[Callable[[], Callable[..., Any]], dict[str, Any]]]:
        """By name: what makes a function, and arguments with which it does something."""
        runs = {"experiment": "short.toml", "out": "out", "seeds": 1, "jobs": 1, "fresh": True, "progress": max}
        seeded = {"seed": 1, "options": {}}
        options = {**WORLD, "overrides": {}, "brains": {}, "reward": {}, "randomize": {}, "max_age_s": 1.0, "flat": True, "ages": True}
        drawn = {"render_mode": "svg", "render_size": 100}
        env = {**options, **drawn, "robot": None, "end": lambda step: False}
        vector = {**options, "robot": None, "num_envs": 2, "threads": 1, "copy": True, "autoreset_mode": "NextStep"}
        action, actions = np.zeros(2, np.float32), np.zeros((2, 2), np.float32)
        return {
            "baudbot.World": (lambda: baudbot.World, {**WORLD, "seed": 1, "overrides": {}, "brains": {}, "agents": None}),
            "baudbot.World.step": (lambda: self.world().step, {"action": [0.1, 0.1]}),
            "baudbot.World.run": (lambda: self.world().run, {"seconds": 0.1}),
            "baudbot.World.readings_of": (lambda: self.world().readings_of, {"robot": "robot"}),
            "baudbot.World.truth": (lambda: self.world().truth, {"robot": "robot"}),
            "baudbot.World.snapshot": (lambda: self.world().snapshot, {}),
            "baudbot.World.restore": (lambda: (world := self.world()).restore, {"snapshot": None}),
            "baudbot.World.reset": (lambda: self.world().reset, {"seed": 1, "end__after_s": 1.0}),
            "baudbot.World.budget": (lambda: self.world().budget, {}),
            "baudbot.World.keep_events": (lambda: self.world().keep_events, {"events": 10}),
            "baudbot.World.diagram": (lambda: self.kept().diagram, {"robot": "robot", "seconds": 0.1}),
            "baudbot.World.svg": (lambda: self.world().svg, {}),
            "baudbot.World.close": (lambda: self.world().close, {}),
            "baudbot.Picture.save": (lambda: self.world().svg().save, {"path": "picture.svg"}),
            "baudbot.sweep": (lambda: baudbot.sweep, runs),
            "baudbot.runs": (lambda: baudbot.runs, runs),
            "baudbot.tune": (lambda: baudbot.tune, {**runs, "experiment": "tune.toml"}),
            "baudbot.worst": (lambda: baudbot.worst, {**runs, "runs": 2, "within_s": 60.0, "first": True}),
            "baudbot.cost": (lambda: baudbot.cost, {"experiment": "short.toml", "values": {"baud": 2400}, "seed": 1}),
            "baudbot.replay": (lambda: baudbot.replay, {"recording": "run.mcap"}),
            "baudbot.compare": (lambda: baudbot.compare, {"one": "run.mcap", "other": "run.mcap"}),
            "baudbot.open": (lambda: baudbot.open, {"path": "run.mcap"}),
            "baudbot.gym.Env": (lambda: Env, env),
            "baudbot.gym.Env.reset": (lambda: Env(**WORLD).reset, seeded),
            "baudbot.gym.Env.step": (lambda: self.begun(Env(**WORLD)).step, {"action": action}),
            "baudbot.gym.Env.render": (lambda: self.begun(Env(**WORLD)).render, {}),
            "baudbot.gym.Env.close": (lambda: Env(**WORLD).close, {}),
            "baudbot.gym.VectorEnv": (lambda: VectorEnv, vector),
            "baudbot.gym.VectorEnv.reset": (lambda: VectorEnv(2, **WORLD).reset, seeded),
            "baudbot.gym.VectorEnv.step": (lambda: self.begun(VectorEnv(2, **WORLD)).step, {"actions": actions}),
            "baudbot.gym.VectorEnv.close_extras": (lambda: VectorEnv(2, **WORLD).close_extras, {}),
            "baudbot.gym.Network": (lambda: Network, {"layers": [LAYER], "offset": 0.0, "scale": 1.0}),
            "baudbot.gym.Network.__call__": (lambda: Network([LAYER]), {"observation": np.zeros(15)}),
            "baudbot.gym.save_policy": (
                lambda: save_policy,
                {"path": "policy.toml", "env": Env(**WORLD), "layers": [LAYER], "offset": 0.0, "scale": 1.0, "description": "one"},
            ),
            "baudbot.pettingzoo.Parallel": (lambda: Parallel, {**options, **drawn, "agents": None}),
            "baudbot.pettingzoo.parallel_env": (lambda: baudbot.pettingzoo.parallel_env, {**options, **drawn, "agents": None}),
            "baudbot.pettingzoo.Parallel.observation_space": (lambda: Parallel(**WORLD).observation_space, {"agent": "robot"}),
            "baudbot.pettingzoo.Parallel.action_space": (lambda: Parallel(**WORLD).action_space, {"agent": "robot"}),
            "baudbot.pettingzoo.Parallel.reset": (lambda: Parallel(**WORLD).reset, seeded),
            "baudbot.pettingzoo.Parallel.step": (lambda: self.begun(Parallel(**WORLD)).step, {"actions": {"robot": action}}),
            "baudbot.pettingzoo.Parallel.render": (lambda: self.begun(Parallel(**WORLD)).render, {}),
            "baudbot.pettingzoo.Parallel.close": (lambda: Parallel(**WORLD).close, {}),
        }

    def begun(self, env: Any) -> Any:
        env.reset(seed=1)
        return env

    def kept(self) -> baudbot.World:
        world = self.world()
        world.keep_events(1000)
        world.step([0.1, 0.1])
        return world

    def test_each_public_function_is_tried(self) -> None:
        self.assertEqual(set(public()) - RESULTS, set(self.doors()) - {"baudbot.open", "baudbot.Picture.save"})

    def test_each_argument_is_named(self) -> None:
        tried = 0
        for name, (make, good) in self.doors().items():
            asked = {parameter for parameter, how in inspect.signature(make()).parameters.items() if how.kind is not how.VAR_KEYWORD}
            # `World` has fields besides, and `parallel_env` hands all on.
            self.assertLessEqual(asked - {"args"}, set(good), name)
            for argument in good:
                for value in NONSENSE:
                    with self.subTest(name, argument=argument, value=value):
                        self.attempt(make(), {**good, argument: value}, argument.partition("__")[0])
                        tried += 1
        self.assertGreater(tried, 800)

    def attempt(self, function: Callable[..., Any], arguments: dict[str, Any], name: str) -> None:
        try:
            function(**arguments)
        except (baudbot.Error, TypeError, ValueError) as error:
            self.assertTrue(name in str(error) or NO in str(error), repr(error))
            self.assertNotIn("unexpected keyword argument", str(error))

    def test_a_wrong_type_is_a_type_error_of_python_and_of_ours(self) -> None:
        for call in (
            lambda: self.world().keep_events("many"),  # type: ignore[arg-type]
            lambda: self.world().restore(None),  # type: ignore[arg-type]
            lambda: baudbot.World("wander", brains=["avoid"]),  # type: ignore[arg-type]
            lambda: self.world().run("1 s"),  # type: ignore[arg-type]
        ):
            with self.assertRaises(TypeError) as caught:
                call()
            self.assertIsInstance(caught.exception, baudbot.Invalid)


def public() -> Iterator[str]:
    """What the package adds: functions, classes and their own methods."""
    modules = {"baudbot": baudbot._ADDED, "baudbot.gym": baudbot.gym.__all__, "baudbot.pettingzoo": ["Parallel", "parallel_env"]}
    for module, names in modules.items():
        for name in names:
            found = getattr(__import__(module, fromlist=[name]), name)
            yield f"{module}.{name}"
            if not inspect.isclass(found) or f"{module}.{name}" in RESULTS:
                continue
            for method, what in vars(found).items():
                if inspect.isfunction(what) and (not method.startswith("_") or method == "__call__"):
                    yield f"{module}.{name}.{method}"


if __name__ == "__main__":
    unittest.main()
