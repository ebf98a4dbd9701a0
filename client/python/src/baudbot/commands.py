"""What a brain can answer to a turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Union


class Command(NamedTuple):
    """Signals for the motors; 1 is full voltage, or full speed, forwards."""

    left: float
    right: float
    #: For the other actuators, in the order of `Body.actuators`; empty: those that were sent last.
    others: tuple[float, ...] = ()
    #: How long the brain says that it has thought, in simulated seconds; None: what the scenario says.
    thinking_s: float | None = None
    #: For a robot whose brain is on board: how many operations the program executed.
    operations: int | None = None


@dataclass(frozen=True, slots=True)
class Poll:
    """Asks a polled firmware for readings."""


#: The answer of a step: nothing, a command, a poll, or bytes for the port of a `RawBrain`.
Output = Union[Command, Poll, bytes, None]


def drive(
    left: float, right: float, *others: float, thinking_s: float | None = None, operations: int | None = None
) -> Command:
    """Signals for the left and the right motor, and for the other actuators in their order."""
    return Command(left, right, others, thinking_s, operations)


def stop() -> Command:
    """Both motors off."""
    return Command(0.0, 0.0)


def poll() -> Poll:
    """Asks a polled firmware for readings."""
    return Poll()
