"""Many environments, stepped by threads of their own."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv as GymnasiumVectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .. import _native, _task
from .._errors import Busy, Closed, Invalid
from ..local import checked_seed
from .env import TALLY, Randomize, Reward, Step, asked, drawn, one_robot, rewards, without
from .spaces import Shape, signals

_AUTORESET = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "never",
}


class VectorEnv(GymnasiumVectorEnv[Any, NDArray[np.float32], NDArray[Any]]):
    """So many robots of a scenario, each in a world of its own, on `threads` threads (as many as there are processors).

    Options are those of `baudbot.gym.Env` but `end`, `render_mode` and a function as `randomize`; a function as `reward` gets a `Step` whose numbers are arrays with an element for each
    environment. World `i` has the seed `seed + i`, and what it does depends neither on the threads nor on the other worlds. With
    `copy=False` each step writes to the same arrays.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        scenario: _task.Scenario = "wander",
        *,
        threads: int | None = None,
        overrides: Mapping[str, object] | None = None,
        brains: str | Mapping[str, str] | None = None,
        robot: str | None = None,
        reward: Reward | None = None,
        randomize: Randomize | None = None,
        max_age_s: float = 1.0,
        flat: bool = False,
        ages: bool = True,
        copy: bool = True,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        **fields: object,
    ) -> None:
        without(fields, "VectorEnv", ("agents", "end", "max_episode_steps", "render_mode", "render_size"))
        if threads is not None and (not isinstance(threads, int) or threads < 1):
            raise Invalid(f"threads: {threads!r} is not a number of threads; write 1 or more", "threads")
        if isinstance(num_envs, bool) or not isinstance(num_envs, (int, np.integer)) or not 1 <= num_envs <= MOST:
            raise Invalid(f"num_envs: {num_envs!r} is not a number of environments; write one of 1 to {MOST}", "num_envs")
        draw, table = drawn(randomize)
        if draw is not None:
            raise Invalid("randomize: a function draws for one environment only; write a table of fields", "randomize")
        mode = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": mode}
        self.num_envs = num_envs = int(num_envs)
        chosen = [robot] if robot is not None else None
        self._task = _task.task(scenario, _task.fields(overrides, fields), brains, chosen, table)
        one_robot(self._task)
        self.shape = Shape(self._task, 0, max_age_s, flat, ages)
        self.single_observation_space, self.single_action_space = self.shape.observation, self.shape.action
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        weights, self._reward = rewards(reward)
        self._task.check_reward(weights)
        threads = threads or len(os.sched_getaffinity(0))
        self._fleet: _native.Fleet | None = _native.Fleet(
            self._task, num_envs, threads, self._task.seed, _AUTORESET[mode], weights, max_age_s
        )
        self._mode, self._copy = mode, copy
        self._observed, self._finals = self._arrays(), self._arrays()
        self._rewards = np.zeros(num_envs)
        self._over = (np.zeros(num_envs, np.bool_), np.zeros(num_envs, np.bool_))
        self._tallies = np.zeros((num_envs, len(TALLY)))

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        if seed is not None and not isinstance(seed, (int, np.integer)):
            raise Invalid("seed: write one number; world i gets the seed that is i larger", "seed")
        super().reset(seed=None if seed is None else int(seed))
        which = asked(options, "reset_mask").get("reset_mask")
        mask = None if which is None else [bool(one) for one in np.asarray(which).ravel()]
        self._open.reset(None if seed is None else checked_seed(seed), mask, *self._observed)
        return self._observation(self._observed), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        array = signals(actions, self.action_space.shape or (), "actions")
        try:
            self._open.step(
                np.ascontiguousarray(array), self._observed, self._rewards, self._over, self._tallies, self._finals
            )
        except TypeError as error:
            if "borrowed" not in str(error):
                raise
            raise Busy("another thread is stepping these environments; make others for it") from None
        observation = self._observation(self._observed)
        rewards: Any = self._rewards
        if self._reward is not None:
            happened = dict(zip(TALLY, self._tallies.T, strict=True))
            rewards = np.asarray(self._reward(Step(observation, array, happened)), dtype=np.float64)
            if rewards.shape != (self.num_envs,):
                raise Invalid(f"reward: has shape {rewards.shape}, ({self.num_envs},) is needed", "reward")
        terminated, truncated = self._over
        info = self._info(terminated | truncated)
        if self._copy:
            rewards, terminated, truncated = rewards.copy(), terminated.copy(), truncated.copy()
        return observation, rewards, terminated, truncated, info

    @property
    def hash(self) -> str:
        """The fingerprints of all worlds in one."""
        return self._open.hash

    def close_extras(self, **_: Any) -> None:
        self._fleet = None

    @property
    def _open(self) -> _native.Fleet:
        if self._fleet is None:
            raise Closed("the environments are closed; make others")
        return self._fleet

    def _arrays(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int8]]:
        count, sensors = self.num_envs, len(self.shape.sensors)
        values = np.zeros((count, len(self.shape.columns)), np.float32)
        return values, np.zeros((count, sensors), np.float32), np.zeros((count, sensors), np.int8)

    def _observation(self, arrays: tuple[NDArray[Any], ...]) -> Any:
        given = [array.copy() for array in arrays] if self._copy else list(arrays)
        return self.shape.observed(*given)

    def _info(self, over: NDArray[np.bool_]) -> dict[str, Any]:
        """What Gymnasium's own vector environments tell of runs that ended in the same step."""
        if self._mode != AutoresetMode.SAME_STEP or not over.any():
            return {}
        last = np.full(self.num_envs, None, dtype=object)
        for place in np.flatnonzero(over):
            last[place] = self.shape.observed(*(array[place].copy() for array in self._finals))
        return {"final_obs": last, "_final_obs": over.copy()}


#: Most environments of one vector environment.
MOST = 1 << 20

__all__ = ["VectorEnv"]
