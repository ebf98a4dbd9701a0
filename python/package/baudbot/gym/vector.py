"""Many environments, stepped by threads of their own."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv as GymnasiumVectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .. import _given, _native, _task
from .._errors import Busy, Invalid, Mistyped
from ..local import checked_seed
from .env import TALLY, Randomize, Reward, Step, asked, closed_or_new, drawn, one_robot, rewards, without
from .spaces import Shape, signals

_AUTORESET = {
    AutoresetMode.NEXT_STEP: "next-step",
    AutoresetMode.SAME_STEP: "same-step",
    AutoresetMode.DISABLED: "never",
}


class VectorEnv(GymnasiumVectorEnv[Any, NDArray[np.float32], NDArray[Any]]):
    """`num_envs` robots of a scenario, each in a world of its own, on `threads` threads (as many as there are processors).

    Options are those of `baudbot.gym.Env` except `end`, `render_mode` and a function as `randomize`; a function as `reward` gets a `Step` whose numbers are arrays with an element for each
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
        self.num_envs = num_envs = _given.whole(num_envs, "num_envs", 1, MOST, "number of environments")
        if threads is not None:
            threads = _given.whole(threads, "threads", 1, MOST_THREADS, "number of threads")
        copy = _given.flag(copy, "copy")
        draw, table = drawn(randomize)
        if draw is not None:
            raise Invalid("randomize: a function draws for one environment only; write a table of fields", "randomize")
        mode = _mode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": mode}
        chosen = [_given.text(robot, "robot", "name")] if robot is not None else None
        self._task = _task.task(scenario, _task.fields(overrides, fields), brains, chosen, table)
        one_robot(self._task)
        self.shape = Shape(self._task, 0, max_age_s, flat, ages)
        weights, self._reward = rewards(reward)
        self._task.check_reward(weights)
        threads = threads or len(os.sched_getaffinity(0))
        # It refuses more than there is memory for, arrays and spaces too.
        self._fleet: _native.Fleet | None = _native.Fleet(
            self._task, num_envs, threads, self._task.seed, _AUTORESET[mode], weights, self.shape.max_age_s
        )
        self.single_observation_space, self.single_action_space = self.shape.observation, self.shape.action
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._mode, self._copy, self._is_new = mode, copy, True
        self._observed, self._finals = self._arrays(), self._arrays()
        self._rewards = np.zeros(num_envs)
        self._over = (np.zeros(num_envs, np.bool_), np.zeros(num_envs, np.bool_))
        # Those whose runs ended in the last step.
        self._ended = np.zeros(num_envs, np.bool_)
        self._had_ended = False
        self._tallies = np.zeros((num_envs, len(TALLY)))

    def __reduce_ex__(self, protocol: object) -> str:
        raise TypeError("cannot pickle or copy a VectorEnv: make another with the same arguments, and reset it with the same seed")

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        seeds = None if seed is None else self._seeds(seed)
        which = asked(options, "reset_mask").get("reset_mask")
        begun = np.ones(self.num_envs, np.bool_) if which is None else np.asarray(which).ravel().astype(np.bool_)
        fleet = self._open
        super().reset(seed=next((one for one in seeds or [] if one is not None), None))
        if seeds is None and self._is_new:
            # Who gives no seed gets another run each time; later ones follow from these.
            seeds = self._from(int(self.np_random.integers(1 << 31)))
        fleet.reset(seeds, begun.tolist(), *self._observed)
        self._is_new, self._ended = False, self._ended & ~begun
        return self._observation(self._observed), self._infos(begun)

    def _from(self, first: int) -> list[int | None]:
        """A seed for each environment, each the next of the one before."""
        return [first + place for place in range(self.num_envs)]

    def _seeds(self, seed: int | Sequence[int | None]) -> list[int | None]:
        """As they are given: the first, or one for each environment, of which None follows from the one before."""
        if not isinstance(seed, (list, tuple, np.ndarray)):
            return self._from(checked_seed(seed, self.num_envs))
        if len(seed) != self.num_envs:
            raise Invalid(f"seed: has {len(seed)} seeds for {self.num_envs} environments", "seed")
        return [None if one is None else checked_seed(one) for one in seed]

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        fleet = self._open
        if self._is_new:
            raise closed_or_new(False)
        array = signals(actions, self.action_space.shape or (), "actions")
        try:
            has_ended = fleet.step(
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
                raise Invalid(f"reward: has shape {rewards.shape}, but ({self.num_envs},) is needed", "reward")
        terminated, truncated = self._over
        # Of most steps there is nothing to tell.
        info = self._step_infos(terminated | truncated) if has_ended or self._had_ended else {}
        self._had_ended = has_ended
        if self._copy:
            rewards, terminated, truncated = rewards.copy(), terminated.copy(), truncated.copy()
        return observation, rewards, terminated, truncated, info

    @property
    def hash(self) -> str:
        """The fingerprints of all worlds in one."""
        return self._open.hash

    def close_extras(self, **_: Any) -> None:
        if self._fleet is not None:
            self._fleet.check_free()
        self._fleet = None

    @property
    def _open(self) -> _native.Fleet:
        if self._fleet is None:
            raise closed_or_new(True)
        return self._fleet

    def _arrays(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int8]]:
        count, sensors = self.num_envs, len(self.shape.sensors)
        values = np.zeros((count, len(self.shape.columns)), np.float32)
        return values, np.zeros((count, sensors), np.float32), np.zeros((count, sensors), np.int8)

    def _observation(self, arrays: tuple[NDArray[Any], ...]) -> Any:
        given = [array.copy() for array in arrays] if self._copy else list(arrays)
        return self.shape.observed(*given)

    def _step_infos(self, over: NDArray[np.bool_]) -> dict[str, Any]:
        """What Gymnasium's own vector environments tell: of runs that ended in this step, and of those that began in it."""
        told = over | self._ended if self._mode == AutoresetMode.NEXT_STEP else over
        self._ended = over
        if not told.any():
            return {}
        infos = self._infos(told)
        if self._mode == AutoresetMode.SAME_STEP:
            last = np.full(self.num_envs, None, dtype=object)
            for place in np.flatnonzero(over):
                last[place] = self.shape.observed(*(array[place].copy() for array in self._finals))
            infos |= {"final_obs": last, "_final_obs": over.copy()}
            infos |= {"final_info": self._infos(over, of_last=True), "_final_info": over.copy()}
        return infos

    def _infos(self, which: NDArray[np.bool_], of_last: bool = False) -> dict[str, Any]:
        """The infos of the runs of these environments, or of those before them, as an `Env` has them, in arrays and with masks."""
        infos: dict[str, Any] = {}
        for name, kind, values in zip(_INFO, _INFO.values(), self._open.infos(which.tolist(), of_last), strict=True):
            infos[name] = np.full(self.num_envs, None if kind is object else 0, dtype=kind)
            infos[name][which], infos[f"_{name}"] = values, which.copy()
        return infos


def _mode(mode: object) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        kinds = ", ".join(str(kind) for kind in AutoresetMode)
        raise Mistyped(f"autoreset_mode: there is no {mode!r}; there are: {kinds}", "autoreset_mode") from None


#: What is in an info.
_INFO: dict[str, type] = {"time_s": float, "seed": int, "ending": object}

#: Most environments of one vector environment.
MOST = 1 << 20

#: Most threads of one.
MOST_THREADS = 1024

__all__ = ["VectorEnv"]
