"""Brains for robots that baudbot simulates, in Python.

A brain is a class with a `step`; `attach` lets it drive a robot until the run is over::

    import baudbot

    class Follow(baudbot.Brain):
        def step(self, turn):
            near = turn.value("ir_front", 0.0)
            return baudbot.drive(0.5 - near, 0.4)

    baudbot.attach(Follow)

`open` is for recordings of runs, `Client` for operators and observers, `Trainer` for programs that learn, `baudbot.aio` for
programs with asyncio, `baudbot.v1` for the bare contract.

With the package `baudbot`, which contains the world itself, there are also `World`, a world in this process, `sweep` and `tune`, runs
of an experiment, `replay` and `compare`, `baudbot.gym` and `baudbot.pettingzoo`.
"""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from . import aio
from .attach import Summary, attach
from .beliefs import Belief, GridMap, Tendency, Variable
from .body import Body, Component, Sensor
from .brain import Brain, RawBrain
from .client import Client
from .commands import Command, Poll, drive, poll, stop
from .errors import Detached, Error, NoReading, NoServer, NotARecording, NotFound, Refused, Restart, Taken, Untrusted
from .program import main
from .recordings import Recording, open
from .trainer import Result, Trainer
from .turn import Reading, Turn
from .world import ServedWorld

if TYPE_CHECKING:
    from ._errors import Busy, Closed, Invalid
    from .local import Picture, Readings, Snapshot, World
    from .recorded import Compared, Replayed, compare, replay
    from ._runs import Runs, cost, runs, sweep, tune, worst

#: What the package `baudbot` adds, and where.
_ADDED = {
    **dict.fromkeys(("Busy", "Closed", "Invalid"), "_errors"),
    **dict.fromkeys(("Picture", "Readings", "Snapshot", "World"), "local"),
    **dict.fromkeys(("Compared", "Replayed", "compare", "replay"), "recorded"),
    **dict.fromkeys(("Runs", "cost", "runs", "sweep", "tune", "worst"), "_runs"),
}


if importlib.util.find_spec(f"{__name__}._when_imported"):
    importlib.import_module("._when_imported", __name__).register_environments()


def __getattr__(name: str) -> object:
    module = _ADDED.get(name)
    if module is None:
        raise AttributeError(f"module 'baudbot' has no attribute {name!r}")
    try:
        found: object = getattr(importlib.import_module(f".{module}", __name__), name)
    except ModuleNotFoundError as error:
        if error.name != f"{__name__}.{module}":
            raise
        raise AttributeError(
            f"baudbot.{name} is in the package `baudbot`, and only `baudbot-client` is installed: pip install baudbot"
        ) from None
    return found


__all__ = [
    "Belief",
    "Body",
    "Brain",
    "Client",
    "Command",
    "Component",
    "Detached",
    "Error",
    "GridMap",
    "NoReading",
    "NoServer",
    "NotARecording",
    "NotFound",
    "Poll",
    "RawBrain",
    "Reading",
    "Recording",
    "Refused",
    "Restart",
    "Result",
    "Sensor",
    "ServedWorld",
    "Summary",
    "Taken",
    "Tendency",
    "Trainer",
    "Turn",
    "Untrusted",
    "Variable",
    "aio",
    "attach",
    "drive",
    "main",
    "open",
    "poll",
    "stop",
]
