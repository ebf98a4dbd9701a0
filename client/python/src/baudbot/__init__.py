"""Brains for robots that baudbot simulates, in Python.

A brain is a class with a `step`; `attach` lets it drive a robot until the run is over::

    import baudbot

    class Follow(baudbot.Brain):
        def step(self, turn):
            near = turn.value("ir_front", 0.0)
            return baudbot.drive(0.5 - near, 0.4)

    baudbot.attach(Follow)

`open` is for recordings of runs, `Client` for operators and observers, `Trainer` for programs that learn, `baudbot.aio` for
programs with asyncio, `baudbot.v1` the bare contract.
"""

from . import aio
from .attach import Summary, attach
from .beliefs import Belief, GridMap
from .body import Body, Component, Sensor
from .brain import Brain, RawBrain
from .client import Client
from .commands import Command, Poll, drive, poll, stop
from .errors import Detached, Error, NoReading, NoServer, NotARecording, NotFound, Refused, Restart, Taken
from .program import main
from .recordings import Recording, open
from .trainer import Result, Trainer
from .turn import Reading, Turn
from .world import World

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
    "Summary",
    "Taken",
    "Trainer",
    "Turn",
    "World",
    "aio",
    "attach",
    "drive",
    "main",
    "open",
    "poll",
    "stop",
]
