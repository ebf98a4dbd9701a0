"""Recorded runs: simulated again, and compared with each other."""

from __future__ import annotations

import os
from dataclasses import dataclass

from . import _native


@dataclass(frozen=True)
class Replayed:
    """How a recorded run went when it was simulated again."""

    #: Its last tick.
    last_tick: int
    #: Fingerprint of the world there.
    hash: str
    #: In words, where it began to differ from the recording; None if it is the same to the bit.
    difference: str | None


def replay(recording: str | os.PathLike[str]) -> Replayed:
    """Simulates a recorded run again, and compares it with the recording tick by tick, as `baudbot replay` does."""
    return Replayed(*_native.replay(os.fspath(recording)))


def compare(one: str | os.PathLike[str], other: str | os.PathLike[str]) -> int | None:
    """The first tick after which two recorded runs are not the same to the bit; None if they are the same as long as both last."""
    return _native.compare(os.fspath(one), os.fspath(other))
