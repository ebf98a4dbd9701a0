"""An environment of PettingZoo's parallel API: all robots of a scenario that have no brain, each at the end of its own cable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, SupportsFloat

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from . import _given, _native, _task
from ._errors import Invalid
from .gym.env import TALLY, Randomize, Reward, Step, changes, closed_or_new, drawn, pixels, rewards
from .gym.spaces import Shape, signals
from .local import Picture, checked_seed


class Parallel(ParallelEnv[str, Any, NDArray[np.float32]]):
    """The robots of a scenario as agents, by their names.

    Options are those of `baudbot.gym.Env`; `agents` names the robots that are driven (by default all without a brain). A step goes on until
    each of them has sent a message again. The run is over for all at once.
    """

    metadata: dict[str, Any] = {"name": "baudbot", "render_modes": ["rgb_array", "svg"], "is_parallelizable": True}

    def __init__(
        self,
        scenario: _task.Scenario,
        *,
        overrides: Mapping[str, object] | None = None,
        brains: str | Mapping[str, str] | None = None,
        agents: Sequence[str] | None = None,
        reward: Reward | None = None,
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
        self._draw: Callable[[np.random.Generator], Mapping[str, object]] | None
        self._draw, table = drawn(randomize)
        self._task = _task.task(scenario, _task.fields(overrides, fields), brains, agents, table)
        self.possible_agents: list[str] = self._task.agents
        if not self.possible_agents:
            raise Invalid("agents: the scenario has no robot that this program could drive", "agents")
        self.agents: list[str] = []
        self.shapes = {
            name: Shape(self._task, place, max_age_s, flat, ages) for place, name in enumerate(self.possible_agents)
        }
        self.observation_spaces = {name: shape.observation for name, shape in self.shapes.items()}
        self.action_spaces = {name: shape.action for name, shape in self.shapes.items()}
        self._weights, self._reward = rewards(reward)
        self._task.check_reward(self._weights)
        self._max_age_s, self.render_mode, self._size = float(max_age_s), render_mode, pixels(render_size)
        self._env: _native.Env | None = None
        self._is_closed = False
        self._random, _ = seeding.np_random()

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        return self.observation_spaces[self._agent(agent, "agent")]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        return self.action_spaces[self._agent(agent, "agent")]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        if self._is_closed:
            raise closed_or_new(self._is_closed)
        # PettingZoo's own test gives options that mean nothing.
        once = {} if options is None else _given.mapping(options, "options").get("overrides", {})
        if seed is not None:
            self._random, _ = seeding.np_random(checked_seed(seed))
        run = checked_seed(seed) if seed is not None else int(self._random.integers(1 << 31))
        more = changes(self._draw, self._random, once)
        if self._env is None:
            self._env = _native.Env(self._task, run, more, self._weights, self._max_age_s)
        else:
            self._env.reset(run, more)
        self.agents = list(self.possible_agents)
        return self._observations(self._env), {name: {} for name in self.agents}

    def step(
        self, actions: dict[str, NDArray[np.float32]]
    ) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        env = self._open
        for name, action in _given.mapping(actions, "actions", "mapping from agents to actions").items():
            self._agent(name, "actions")
            array = signals(action, self.action_spaces[name].shape or (), f"actions[{name!r}]")
            env.act(self.possible_agents.index(name), array.tolist())
        terminated, truncated = env.step()
        names, observations = self.agents, self._observations(env)
        worth = {name: self._worth(env, name, observations[name], actions.get(name)) for name in names}
        infos: dict[str, dict[str, Any]] = {name: {"ending": env.ending} if env.ending else {} for name in names}
        if terminated or truncated:
            self.agents = []
        return observations, worth, dict.fromkeys(names, terminated), dict.fromkeys(names, truncated), infos

    def render(self) -> Any:
        if self.render_mode is None:
            return None
        svg = self._open.svg()
        return Picture(svg) if self.render_mode == "svg" else _native.pixels(svg, self._size)

    @property
    def hash(self) -> str:
        """Fingerprint of the world's state, as `baudbot run` prints it."""
        return self._open.hash

    def close(self) -> None:
        if self._env is not None:
            self._env.check_free()
        self._env, self._is_closed = None, True

    def _agent(self, name: object, argument: str) -> str:
        if _given.text(name, argument, "name") not in self.shapes:
            there = ", ".join(self.possible_agents)
            raise Invalid(f"{argument}: there is no agent `{name}`; there are: {there}", argument)
        return str(name)

    def _worth(self, env: _native.Env, name: str, observation: Any, action: Any) -> float:
        place = self.possible_agents.index(name)
        if self._reward is None:
            return env.reward(place)
        worth: SupportsFloat = self._reward(Step(observation, action, dict(zip(TALLY, env.tally(place), strict=True))))
        return float(worth)

    def _observations(self, env: _native.Env) -> dict[str, Any]:
        return {
            name: self.shapes[name].observed(*env.observation(self.possible_agents.index(name))) for name in self.agents
        }

    @property
    def _open(self) -> _native.Env:
        if self._env is None:
            raise closed_or_new(self._is_closed)
        return self._env


def parallel_env(scenario: _task.Scenario, **options: Any) -> Parallel:
    """An environment of PettingZoo's parallel API; see `Parallel`."""
    return Parallel(scenario, **options)
