"""A world in this process."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _given, _task
from ._errors import Closed, Invalid, Mistyped
from ._native import Env, Task
from .names import unknown

Scalar = TypeVar("Scalar", bound=np.generic)


class Readings(Mapping[str, NDArray[np.float64]]):
    """What a robot's brain has of its sensors: by name, an array of a sensor's values in SI units.

    The arrays are views of the same memory in each step: copy what is to be kept. They cannot be written to.
    """

    def __init__(self, task: Task, agent: int) -> None:
        sensors = task.sensors(agent)
        size = max((end for _, _, _, end in sensors), default=0)
        self._values, self._ages_s = np.zeros(size), np.full(len(sensors), np.inf)
        self._readable = np.zeros(len(sensors), dtype=np.bool_)
        #: The names of the sensors, in order.
        self.names: tuple[str, ...] = tuple(name for name, *_ in sensors)
        #: What each of all values is, such as `ir_front` or `odometer.x_m`.
        self.columns: tuple[str, ...] = tuple(task.columns(agent))
        self._views = {name: _read_only(self._values[start:end]) for name, _, start, end in sensors}

    def __getitem__(self, sensor: str) -> NDArray[np.float64]:
        view = self._views.get(sensor)
        if view is None:
            raise KeyError(unknown("sensor", sensor, self.names))
        return view

    def __iter__(self) -> Any:
        return iter(self._views)

    def __len__(self) -> int:
        return len(self._views)

    @property
    def values(self) -> NDArray[np.float64]:  # type: ignore[override]
        """All values, sensor by sensor."""
        return _read_only(self._values)

    @property
    def ages_s(self) -> NDArray[np.float64]:
        """How old each sensor's reading is, in seconds, as a brain can know it; infinite if none has arrived."""
        return _read_only(self._ages_s)

    @property
    def readable(self) -> NDArray[np.bool_]:
        """Whether each sensor had something new in the last step."""
        return _read_only(self._readable)

    def __repr__(self) -> str:
        told = (f"{name} {np.array2string(self[name], precision=4, threshold=8)}" for name in self.names)
        return f"<readings: {', '.join(told)}>"

    def _take(self, env: Env, agent: int) -> None:
        env.observe(agent, self._values, self._ages_s, self._readable)


class Snapshot:
    """A world as it was at an instant. `World.restore` takes a world back to it, as often as one likes."""

    def __init__(self, env: Env) -> None:
        self._env = env

    def __copy__(self) -> Snapshot:
        return self

    def __deepcopy__(self, _memo: object) -> Snapshot:
        return self

    def __reduce__(self) -> str:
        raise TypeError("a snapshot is of a world in this process, and cannot be pickled; pickle the world itself")

    def __repr__(self) -> str:
        return f"<snapshot at {self._env.time_ns / 1e9:g} s>"


class World:
    """A world in this process, with its robots and their cables, but without a server.

    `scenario` is a file, the name of a built-in scenario (`wander`, `khepera`, `arsim`) or TOML. Fields of it are changed by
    `overrides`, by their paths, or by arguments in whose names `__` stands for a dot::

        world = baudbot.World("wander", seed=1, end__after_s=60, overrides={"robots.robot.link.baud": 1200})

    Robots with a brain in `brains` are driven by it (`brains="avoid"` is for all robots). The others are driven by this program, in
    `step`, as a program at the laptop's end of the cable would: it has `readings`, and what it does travels back.

    A world is for one thread at a time. `copy.deepcopy` and `pickle` make others in the same state.
    """

    def __init__(
        self,
        scenario: _task.Scenario = "wander",
        seed: int | None = None,
        *,
        overrides: Mapping[str, object] | None = None,
        brains: str | Mapping[str, str] | None = None,
        agents: Sequence[str] | None = None,
        **fields: object,
    ) -> None:
        self._task = _task.task(scenario, _task.fields(overrides, fields), brains, agents)
        seed = self._task.seed if seed is None else checked_seed(seed)
        self._env: Env | None = Env(self._task, seed, [], [], np.inf)
        self._listen()

    def __copy__(self) -> World:
        return copy.deepcopy(self)

    def __getstate__(self) -> dict[str, Any]:
        # Those of a copy are views of its own arrays.
        return {name: value for name, value in vars(self).items() if name != "_readings"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._listen()

    # What it is.

    @property
    def name(self) -> str:
        """The scenario's name."""
        return self._task.name

    @property
    def robots(self) -> list[str]:
        """The names of all robots."""
        return self._task.robots

    @property
    def driven(self) -> list[str]:
        """The names of those that this program drives."""
        return self._task.agents

    @property
    def time_s(self) -> float:
        """Simulated time since the start of the run, in seconds."""
        return self._open.time_ns / 1e9

    @property
    def tick(self) -> int:
        """Ticks since the start of the run."""
        return self._open.tick

    @property
    def step_s(self) -> float:
        """Length of a tick, in seconds."""
        return self._task.step_ns / 1e9

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self._open.seed

    @property
    def ending(self) -> str | None:
        """Why the run ended, in words; None while it goes on."""
        return self._open.ending

    @property
    def hash(self) -> str:
        """Fingerprint of the whole state, as `baudbot run` prints it: equal for equal bits, on every machine."""
        return self._open.hash

    # What is done in it.

    def step(self, action: ArrayLike | Mapping[str, ArrayLike] | None = None) -> bool:
        """A control cycle: what the driven robots are to do travels to them, and the world goes on until each of them has sent a
        message again, or for a second if none comes. Without a driven robot it goes on by a tick.

        `action` has the signals of the left and the right wheel and those of the robot's other actuators, each in [-1, 1]; if
        several robots are driven, it is a mapping from their names. A robot that is told nothing goes on as before.

        Returns whether the run goes on.
        """
        env = self._open
        if action is not None:
            actions = action.items() if isinstance(action, Mapping) else ((None, action),)
            for robot, signals in actions:
                place = self._place(robot)
                try:
                    env.act(place, signals)
                except (TypeError, OverflowError):
                    raise Mistyped(f"action: {signals!r} is not a list of numbers", "action") from None
        env.step()
        self._observe()
        return env.ending is None

    def run(self, seconds: float | None = None) -> bool:
        """Runs for this much simulated time, or to the end of the run. Driven robots go on as before. Returns whether the run goes on."""
        env = self._open
        if seconds is None:
            until_ns = (1 << 63) - 1
        else:
            until_ns = env.time_ns + round(_given.seconds(seconds, "seconds") * 1e9)
        try:
            env.run_until(until_ns)
        finally:
            self._observe()
        return env.ending is None

    @property
    def readings(self) -> Readings:
        """What the brain of the only driven robot has."""
        return self.readings_of(None)

    def readings_of(self, robot: str | None) -> Readings:
        """What the brain of a driven robot has."""
        return self._readings[self._place(robot)]

    def truth(self, robot: str | None = None) -> dict[str, float]:
        """The truth about a robot, which its brain does not see: where it is, how fast, how far it has driven."""
        names = self._task.robots
        if robot is None and len(names) != 1:
            raise Invalid(f"robot: there are {len(names)}; name one of {', '.join(names)}", "robot")
        numbers = self._open.truth(0 if robot is None else _place(robot, names))
        return dict(zip(_TRUTH, numbers, strict=True))

    # What is kept of it, and shown.

    def snapshot(self) -> Snapshot:
        """A snapshot of the world as it is now. A world with brains in it has none, since what they think cannot be copied."""
        return Snapshot(self._open.snapshot())

    def restore(self, snapshot: Snapshot) -> None:
        """Takes the world back to a snapshot of it, or of the world that it is a copy of."""
        if not isinstance(snapshot, Snapshot):
            raise Mistyped(f"snapshot: {snapshot!r} is not a snapshot of a world", "snapshot")
        self._open.restore(snapshot._env)
        self._observe()

    def reset(self, seed: int | None = None, **fields: object) -> None:
        """Begins another run, with this seed, and with these fields changed as well."""
        seed = self._open.seed if seed is None else checked_seed(seed)
        self._open.reset(seed, _task.lines(_task.fields(None, fields)))
        self._observe()

    def budget(self) -> dict[str, Any]:
        """What a control cycle of each robot costs, before it is run: the numbers of `baudbot budget --json`."""
        told: dict[str, Any] = json.loads(self._task.budget())
        return told

    def keep_events(self, events: int = 10_000) -> None:
        """From now on keeps this many events of each robot, for `diagram`."""
        self._open.keep_events(_given.whole(events, "events", 0, MOST_EVENTS))

    def diagram(self, robot: str | None = None, seconds: float | None = None) -> Picture:
        """What happened when, up to now: a timing diagram, of the last three ticks or this many seconds. It shows what
        has happened since `keep_events`."""
        span_ns = 3 * self._task.step_ns if seconds is None else round(_given.seconds(seconds, "seconds") * 1e9)
        place = 0 if robot is None else _place(robot, self._task.robots)
        return Picture(self._open.diagram(place, span_ns))

    def svg(self) -> Picture:
        """The world from above as it is now."""
        return Picture(self._open.svg())

    def _repr_svg_(self) -> str | None:
        return None if self._env is None else self._env.svg()

    def _repr_html_(self) -> str:
        return f"<p>{_escaped(repr(self))}</p>{self._repr_svg_() or ''}"

    def __repr__(self) -> str:
        if self._env is None:
            return f"<world {self.name}, closed>"
        ended = f", {self.ending}" if self.ending else ""
        return f"<world {self.name}, seed {self.seed}, at {self.time_s:g} s{ended}>"

    def close(self) -> None:
        """Frees the memory. The world cannot be used after that. Raises `Busy` while another thread uses it."""
        if self._env is not None:
            self._env.check_free()
        self._env = None

    def __enter__(self) -> World:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def _open(self) -> Env:
        if self._env is None:
            raise Closed(f"the world {self._task.name} is closed; make another one")
        return self._env

    def _listen(self) -> None:
        """Makes the arrays of readings."""
        self._readings = [Readings(self._task, place) for place in range(len(self._task.agents))]
        if self._env is not None:
            self._observe()

    def _observe(self) -> None:
        for place, readings in enumerate(self._readings):
            readings._take(self._open, place)

    def _place(self, robot: str | None) -> int:
        names = self._task.agents
        if not names:
            raise Invalid("robot: this program drives none; brains drive them all", "robot")
        if robot is None and len(names) == 1:
            return 0
        if robot is None:
            raise Invalid(f"robot: this program drives {len(names)}; name one of {', '.join(names)}", "robot")
        return _place(robot, names, "driven robot")


class Picture(str):
    """A picture as SVG, which notebooks show."""

    def _repr_svg_(self) -> str:
        return str(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it to a file."""
        with open(_given.path(path, "path"), "w", encoding="utf-8") as file:
            file.write(self)


def checked_seed(seed: object, worlds: int = 1) -> int:
    """A seed, which is a whole number from 0 to 2**63 - 1; that of the first of this many worlds."""
    return _given.whole(seed, "seed", 0, (1 << 63) - worlds)


def _place(robot: object, names: Sequence[str], what: str = "robot") -> int:
    name = _given.text(robot, "robot", "name")
    if name not in names:
        raise Invalid(unknown(what, name, names), "robot")
    return names.index(name)


def _read_only(array: NDArray[Scalar]) -> NDArray[Scalar]:
    view = array.view()
    view.flags.writeable = False
    return view


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


_TRUTH = ("x_m", "y_m", "heading_rad", "speed_m_s", "turn_rate_rad_s", "distance_m", "collisions")

#: Most events that are kept of a robot.
MOST_EVENTS = 10_000_000
