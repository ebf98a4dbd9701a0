"""Brains: what a robot's program is made of."""

from __future__ import annotations

import random
from collections.abc import Awaitable, Mapping
from typing import Any, ClassVar, Union

from .beliefs import Belief
from .body import Body
from .commands import Output
from .errors import Refused
from .names import unknown
from .turn import Turn

#: A parameter's value.
Value = Union[bool, int, float, str]


class Brain:
    """The brain of one robot: derive from it, and write `step`.

    Class attributes that are numbers, booleans or strings are the brain's parameters: whoever starts the brain can set
    them by name (`--set speed=0.4`, an experiment's `brain.speed`). ::

        class Follow(baudbot.Brain):
            speed = 0.5

            def step(self, turn):
                near = turn.value("ir_front", 0.0)
                return baudbot.drive(self.speed - near, self.speed)
    """

    #: Whether `step` is also called in ticks in which nothing has arrived.
    every_tick: ClassVar[bool] = False
    #: If nothing arrives, `step` is called after this much simulated time, since the cable may have lost the last command;
    #: None: never.
    patience_s: ClassVar[float | None] = 0.1
    #: Whether commands say how long the brain has thought (`drive(..., thinking_s=...)`). The world then cannot run ahead.
    tells_thinking: ClassVar[bool] = False
    #: Whether the server stops the wheels when the program is gone. A real robot keeps its last command.
    stop_when_gone: ClassVar[bool] = False
    #: Memory that the program's variables need, for a robot whose brain is on board; None: not stated.
    memory_bytes: ClassVar[int | None] = None
    #: Whether the brain reads and writes bytes (`RawBrain`).
    raw: ClassVar[bool] = False

    def __init__(self, body: Body, seed: int = 1, parameters: Mapping[str, Value] | None = None) -> None:
        #: The robot's data sheet.
        self.body = body
        #: Seed of the brain's own random numbers.
        self.seed = seed
        #: Random numbers that depend on the seed alone.
        self.random = random.Random(seed)
        for name, value in (parameters or {}).items():
            setattr(self, name, self.parameter(name, value))

    def start(self) -> None:
        """Called before the first step, when `body` and the parameters are set. A reset of the world begins with a new brain."""

    def step(self, turn: Turn) -> Output | Awaitable[Output]:
        """Decides what the robot does next: `drive(left, right)`, `poll()`, or None for no new command.

        With `baudbot.aio` it may be a coroutine.
        """
        raise NotImplementedError(f"{type(self).__name__} has no `step`")

    def belief(self) -> Belief | None:
        """What the brain believes, for people who watch; asked for about twenty times per simulated second."""
        return None

    @classmethod
    def parameters(cls) -> dict[str, Value]:
        """The parameters by name, with their defaults."""
        own = [vars(base) for base in reversed(cls.__mro__) if base not in RawBrain.__mro__]
        return {
            name: value
            for attributes in own
            for name, value in attributes.items()
            if not name.startswith("_") and name not in vars(Brain) and isinstance(value, (bool, int, float, str))
        }

    @classmethod
    def parameter(cls, name: str, value: Any) -> Value:
        """A parameter's value, or its text, converted to the type of its default."""
        defaults = cls.parameters()
        if name not in defaults:
            raise Refused(unknown("parameter", name, list(defaults), f" of {cls.__name__}"))
        default = defaults[name]
        if isinstance(default, str):
            return str(value)
        if isinstance(default, bool):
            words = {"true": True, "false": False}
            if isinstance(value, bool) or str(value).lower() in words:
                return words[str(value).lower()]
        else:
            try:
                if not isinstance(value, bool):
                    return _number(value, type(default))
            except ValueError:
                pass
        kind = {bool: "true or false", int: "a whole number", float: "a number"}[type(default)]
        raise Refused(f"parameter `{name}` of {cls.__name__} must be {kind}, is {value!r}")


def _number(value: Any, kind: type[int] | type[float]) -> int | float:
    number = float(value)
    if kind is int:
        if not number.is_integer():
            raise ValueError
        return int(number)
    return number


class RawBrain(Brain):
    """A brain that reads and writes the bytes of its robot's cable itself: `step` gets `turn.raw` and answers with bytes."""

    raw: ClassVar[bool] = True
