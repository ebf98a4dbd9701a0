"""Recorded runs: simulated again, and compared with each other."""

from __future__ import annotations

import os
from dataclasses import dataclass

from . import _given, _native


@dataclass(frozen=True)
class Replayed:
    """How a recorded run went when it was simulated again."""

    #: The last tick that was compared.
    last_tick: int
    #: Fingerprint of the world there.
    hash: str
    #: In words, where it began to differ from the recording; None if it is the same to the bit as far as there is one.
    difference: str | None
    #: In words, what is missing from the recording, and how much was compared; None if it is whole.
    incomplete: str | None


@dataclass(frozen=True)
class Compared:
    """How alike two recorded runs are."""

    #: The first tick after which their states are not the same to the bit; None if they are, as long as both last.
    difference: int | None
    #: The last tick at which they were compared.
    last_tick: int
    #: In words, what is missing from the files; None if they are whole.
    incomplete: str | None


def replay(recording: str | os.PathLike[str]) -> Replayed:
    """Simulates a recorded run again, and compares it with the recording tick by tick, as `baudbot replay` does."""
    return Replayed(*_native.replay(_given.path(recording, "recording")))


def compare(one: str | os.PathLike[str], other: str | os.PathLike[str]) -> Compared:
    """Compares the states of two recorded runs, tick by tick, as long as both last."""
    paths = _given.path(one, "one"), _given.path(other, "other")
    difference, last_tick, missing = _native.compare(*paths)
    told = [f"{path}: {words}" for path, words in zip(paths, missing, strict=True) if words is not None]
    return Compared(difference, last_tick, "; ".join(told) or None)
