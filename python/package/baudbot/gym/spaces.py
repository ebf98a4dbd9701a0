"""The spaces of an agent: what it observes and what it does, as arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .. import _given
from .._errors import Invalid, Mistyped
from .._native import Task

Observation = dict[str, NDArray[Any]]


class Shape:
    """The spaces of a robot that an environment drives.

    `observation` is a `Dict`: `readings` are all values of all sensors in SI units, 0 where none has arrived yet; `ages_s` how old
    each sensor's are, in seconds, at most `max_age_s`, which is also the age of what has never arrived; `readable` is 1 for each sensor
    that had something new in the step. `action` has the signals of the left and the right wheel, then those of the robot's
    other actuators.
    """

    def __init__(self, task: Task, agent: int, max_age_s: float, flat: bool, with_ages: bool) -> None:
        flat, with_ages = _given.flag(flat, "flat"), _given.flag(with_ages, "ages")
        max_age_s = _given.number(max_age_s, "max_age_s")
        if not 0 < max_age_s < 1e9:
            raise Invalid(f"max_age_s: {max_age_s!r} is not a time; write one from 0 to 1e9 seconds", "max_age_s")
        bounds = np.asarray(task.bounds(agent), dtype=np.float32).reshape(-1, 2)
        sensors = task.sensors(agent)
        # A robot without sensors has neither ages nor news.
        with_ages = with_ages and len(sensors) > 0
        self.flat, self.with_ages, self.max_age_s = flat, with_ages, max_age_s
        #: What each of the readings is, such as `ir_front` or `odometer.x_m`.
        self.columns = tuple(task.columns(agent))
        #: The sensors by their names, with how many values each has.
        self.sizes = {name: end - begin for name, _, begin, end in sensors}
        #: The names of the sensors.
        self.sensors = tuple(self.sizes)
        #: What each signal of an action is for.
        self.signals = tuple(task.actions(agent))
        # 0 stands for what has not arrived yet.
        low, high = np.minimum(bounds[:, 0], 0), np.maximum(bounds[:, 1], 0)
        count = len(sensors)
        parts: dict[str, spaces.Space[Any]] = {"readings": spaces.Box(low, high, dtype=np.float32)}
        if with_ages:
            parts["ages_s"] = spaces.Box(0.0, max_age_s, (count,), np.float32)
            parts["readable"] = spaces.MultiBinary(count)
        whole = spaces.Dict(parts)
        self.observation: spaces.Space[Any] = spaces.flatten_space(whole) if flat else whole
        if flat:
            more = [np.zeros(count), np.zeros(count)] if with_ages else []
            top = [np.full(count, max_age_s), np.ones(count)] if with_ages else []
            lows, highs = (np.concatenate([*ends]).astype(np.float32) for ends in ([low, *more], [high, *top]))
            self.observation = spaces.Box(lows, highs, dtype=np.float32)
        self.action = spaces.Box(-1.0, 1.0, (len(self.signals),), np.float32)

    def observed(self, readings: NDArray[Any], ages_s: NDArray[Any], readable: NDArray[Any]) -> Any:
        """An observation of arrays; of a row for each environment if these have rows."""
        if self.flat:
            if not self.with_ages:
                return readings
            return np.concatenate([readings, ages_s, readable], axis=-1, dtype=np.float32)
        if not self.with_ages:
            return {"readings": readings}
        return {"readings": readings, "ages_s": ages_s, "readable": readable}


def signals(action: object, shape: tuple[int, ...], what: str) -> NDArray[np.float32]:
    """An action as an array of this shape."""
    try:
        array = np.asarray(action, dtype=np.float32)
    except (TypeError, ValueError, OverflowError):
        raise Mistyped(f"{what}: {action!r} is not an array of numbers", what) from None
    if array.shape != shape:
        raise Invalid(f"{what}: has shape {array.shape}, but {shape} is needed", what)
    return array
