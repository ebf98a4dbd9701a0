"""An environment with one robot."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
from numpy.typing import NDArray

from .. import _given, _native, _task
from .._errors import Closed, Invalid, Mistyped
from ..local import Picture, checked_seed
from .spaces import Shape, signals

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: Names of the numbers of a step; see `docs/reference/python.md`.
TALLY: tuple[str, ...] = tuple(_native.check_reward([]))

#: Weights of what happened in a step, or a function of the step.
Reward = Mapping[str, float] | Callable[["Step"], SupportsFloat]

#: How fields are drawn, by their paths; a TOML file with such a table; or a function that gives fields for a run.
Randomize = Mapping[str, object] | str | os.PathLike[str] | Callable[[np.random.Generator], Mapping[str, object]]

#: The reward of a robot's run if no other is given.
DRIVE: Mapping[str, float] = {"distance_m": 1.0, "collisions": -5.0}


@dataclass(frozen=True)
class Step:
    """What a reward may know of a step. `happened` is the truth, which the robot's brain does not see."""

    #: What the agent observes after it.
    observation: Any
    #: What it did.
    action: NDArray[np.float32]
    #: By the names of `TALLY`: `seconds`, `distance_m`, `collisions`, `progress_m`, `covered`, `sensed`, `zones`, `success`.
    happened: Mapping[str, Any]


class Env(gymnasium.Env[Any, NDArray[np.float32]]):
    """A robot of any scenario, at the laptop's end of its cable.

    - `scenario`, `overrides`, `brains` and further fields are those of `baudbot.World`. `robot` is the one that is driven, if there
      are several without a brain.
    - `reward` has weights of what happens in a step (`{"distance_m": 1, "collisions": -5}`), or is a function of a `Step`.
    - `end` is a function of a `Step` that says whether the run is to be terminated.
    - `randomize` says how fields are drawn for each run: `{"robots.robot.link.baud": [1200, 9600], "robots.robot.start.x_m": {"uniform":
      [-0.5, 0.5]}}`, a TOML file with a table of that, or a function of a random generator.
    - `flat` makes the observation one array, `ages=False` leaves ages and readability out.

    The scenario decides when a run ends: its time (`end.after_s`) truncates it, everything else terminates it. `reset` takes a seed, and as
    `options` `{"overrides": {…}}` for one run.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "svg"], "render_fps": 10}

    def __init__(
        self,
        scenario: _task.Scenario = "wander",
        *,
        overrides: Mapping[str, object] | None = None,
        brains: str | Mapping[str, str] | None = None,
        robot: str | None = None,
        reward: Reward | None = None,
        end: Callable[[Step], bool] | None = None,
        randomize: Randomize | None = None,
        max_age_s: float = 1.0,
        flat: bool = False,
        ages: bool = True,
        render_mode: str | None = None,
        render_size: int = 480,
        **fields: object,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise Invalid(f"render_mode: there is no {render_mode!r}; there are: rgb_array, svg", "render_mode")
        without(fields, "Env", ("agents", "num_envs", "threads"))
        self._draw, table = drawn(randomize)
        chosen = [_given.text(robot, "robot", "name")] if robot is not None else None
        self._task = _task.task(scenario, _task.fields(overrides, fields), brains, chosen, table)
        one_robot(self._task)
        self.shape = Shape(self._task, 0, max_age_s, flat, ages)
        self.observation_space, self.action_space = self.shape.observation, self.shape.action
        self._weights, self._reward = rewards(reward)
        self._task.check_reward(self._weights)
        self._end = None if end is None else _given.function(end, "end")
        self._max_age_s = self.shape.max_age_s
        self._is_plain = self._reward is None and end is None and not flat
        self.render_mode, self._size = render_mode, pixels(render_size)
        self._env: _native.Env | None = None
        self._is_closed = False

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        run = None if seed is None else checked_seed(seed)
        once = asked(options, "overrides").get("overrides", {})
        super().reset(seed=run)
        if self._is_closed:
            raise closed_or_new(self._is_closed)
        # Without a seed, the next one is drawn from the ones before.
        run = int(self.np_random.integers(1 << 31)) if run is None else run
        more = changes(self._draw, self.np_random, once)
        if self._env is None:
            self._env = _native.Env(self._task, run, more, self._weights, self._max_age_s)
        else:
            self._env.reset(run, more)
        return self.shape.observed(*self._env.observation(0)), self._info(self._env)

    def step(self, action: NDArray[np.float32]) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        env = self._env
        if env is None or not self._is_plain:
            return self._step(self._open, action)
        try:
            stepped = env.gymnasium_step(action, self.shape.with_ages)
        except TypeError:
            stepped = env.gymnasium_step(self._signals(action), self.shape.with_ages)
        if stepped[2] or stepped[3]:
            stepped[4].update(self._info(env))
        return stepped

    def _step(self, env: _native.Env, action: object) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """A step with the user's own observation, reward or end."""
        array = self._signals(action)
        readings, ages_s, readable, weighed, terminated, truncated = env.cycle(array)
        observation, reward = self.shape.observed(readings, ages_s, readable), weighed
        if self._reward is not None or self._end is not None:
            step = Step(observation, array, dict(zip(TALLY, env.tally(0), strict=True)))
            reward = float(self._reward(step)) if self._reward is not None else weighed
            terminated = terminated or (self._end is not None and bool(self._end(step)))
        info = self._info(env) if terminated or truncated else {}
        return observation, reward, terminated, truncated, info

    def _signals(self, action: object) -> NDArray[np.float32]:
        return signals(action, self.action_space.shape or (), "action")

    def render(self) -> Any:
        if self.render_mode is None:
            return None
        svg = self._open.svg()
        return Picture(svg) if self.render_mode == "svg" else _native.pixels(svg, self._size)

    @property
    def time_s(self) -> float:
        """Simulated time since the start of the run, in seconds."""
        return self._open.time_ns / 1e9

    @property
    def hash(self) -> str:
        """Fingerprint of the world's state, as `baudbot run` prints it."""
        return self._open.hash

    def close(self) -> None:
        if self._env is not None:
            self._env.check_free()
        self._env, self._is_closed = None, True

    @property
    def _open(self) -> _native.Env:
        if self._env is None:
            raise closed_or_new(self._is_closed)
        return self._env

    @staticmethod
    def _info(env: _native.Env) -> dict[str, Any]:
        return {"time_s": env.time_ns / 1e9, "seed": env.seed, "ending": env.ending}


def one_robot(task: _native.Task) -> None:
    """Refuses a task with several robots that this program would drive, or none."""
    if not task.agents:
        raise Invalid("robot: the scenario has none that this program could drive", "robot")
    if len(task.agents) > 1:
        names = ", ".join(task.agents)
        raise Invalid(f"robot: the scenario has {len(task.agents)} without a brain; name one of {names}, or give them `brains`", "robot")


def rewards(reward: Reward | None) -> tuple[list[tuple[str, float]], Callable[[Step], SupportsFloat] | None]:
    """Weights, or a function."""
    if callable(reward):
        return [], reward
    weights = _task.weights(DRIVE if reward is None else _given.mapping(reward, "reward", "mapping of weights or function"))
    _native.check_reward(weights)
    return weights, None


def drawn(
    randomize: Randomize | None,
) -> tuple[Callable[[np.random.Generator], Mapping[str, object]] | None, Mapping[str, object] | None]:
    """A function that draws fields, or a table of how they are drawn."""
    if randomize is None:
        return None, None
    if isinstance(randomize, Mapping):
        return None, _given.mapping(randomize, "randomize")
    if callable(randomize):
        return randomize, None
    if not isinstance(randomize, (str, os.PathLike)):
        raise Mistyped(f"randomize: {randomize!r} is not a mapping, a file or a function", "randomize")
    path = os.fspath(randomize)
    try:
        with open(path, "rb") as file:
            table = tomllib.load(file).get("randomize")
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Invalid(f"randomize: {path}: {error}", "randomize") from None
    if not isinstance(table, Mapping):
        raise Invalid(f"randomize: {path}: has no table [randomize]", "randomize")
    return None, dict(_paths(table, ""))


def _paths(table: Mapping[str, object], before: str) -> Iterator[tuple[str, object]]:
    """The fields of a table by their paths; tables in it are parts of these, unless they say how a field is drawn."""
    for name, how in table.items():
        if isinstance(how, Mapping) and not _task.says_how(how):
            yield from _paths(how, f"{before}{name}.")
        else:
            yield f"{before}{name}", how


def changes(
    draw: Callable[[np.random.Generator], Mapping[str, object]] | None, random: np.random.Generator, once: object
) -> list[str]:
    """The fields of a run that are not those of the task: what a function draws, and what is asked for once."""
    drawn = _given.mapping(draw(random), "randomize", "mapping from fields to values") if draw else {}
    return _task.lines({**drawn, **_given.mapping(once, "options.overrides", "mapping from fields to values")})


class New(Closed, gymnasium.error.ResetNeeded):
    """There is no run yet."""


def closed_or_new(is_closed: bool) -> Exception:
    """Why there is no world."""
    if is_closed:
        return Closed("the environment is closed; make another one")
    return New("the environment is new; reset it first")


def pixels(size: object) -> int:
    """The longer side of an image."""
    return _given.whole(size, "render_size", 1, 8192, "number of pixels")


def asked(options: Mapping[str, Any] | None, *known: str) -> Mapping[str, Any]:
    """The options of a reset, of which others are refused."""
    if options is None:
        return {}
    for name in _given.mapping(options, "options"):
        if name not in known:
            raise Invalid(f"options: there is no `{name}` here; there are: {', '.join(known)}", "options")
    return options


def without(fields: Mapping[str, object], what: str, names: tuple[str, ...]) -> None:
    """Refuses options of other environments, which would be taken for fields of the scenario."""
    for name in names:
        if name in fields:
            raise Invalid(f"{name}: {what} has no such option", name)


__all__ = ["Env", "Randomize", "Reward", "Step"]
