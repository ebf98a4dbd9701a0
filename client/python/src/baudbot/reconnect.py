"""Reconnecting to a server that was lost."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from .errors import Error, Taken

#: Tells people a line.
Tell = Callable[[str], object]

_FIRST_WAIT_S = 0.25
_LONGEST_WAIT_S = 5.0

#: A server pings a silent connection after 20 s, and gives up one that has not answered for 20 s. A robot that is held for longer
#: is held by another brain.
_NOTICED_WITHIN_S = 45.0


def tell_on_stderr(line: str) -> None:
    """Prints a line where it does not mix with a program's output."""
    print(line, file=sys.stderr, flush=True)


class Backoff:
    """How long to wait before each attempt to reconnect: longer each time, until the limit is reached."""

    _end_s: float | None
    _held_since_s: float | None

    def __init__(self, limit_s: float, tell: Tell, clock: Callable[[], float] = time.monotonic) -> None:
        self._limit_s, self._tell, self._clock = limit_s, tell, clock
        self._wait_s, self._end_s = _FIRST_WAIT_S, None
        self._held_since_s = None
        self._was_connected = False

    def connected(self) -> None:
        """The next loss is a new one."""
        self._wait_s, self._end_s = _FIRST_WAIT_S, None
        self._held_since_s = None
        self._was_connected = True

    def wait_s(self, error: Error) -> float:
        """The time until the next attempt; raises the error if there is to be none, as where there never was a connection."""
        now_s = self._clock()
        if not self._was_connected or not error.may_pass or self._limit_s <= 0.0:
            raise error
        if self._end_s is None:
            self._end_s = now_s + self._limit_s
            self._tell(f"{error}; trying to reconnect for {self._limit_s:g} s")
        elif now_s >= self._end_s or self._is_held_by_another(error, now_s):
            raise error
        wait_s = min(self._wait_s, max(self._end_s - now_s, 0.0))
        self._wait_s = min(2.0 * self._wait_s, _LONGEST_WAIT_S)
        return wait_s

    def _is_held_by_another(self, error: Error, now_s: float) -> bool:
        """Whether the robot has been held for longer than the server can take to notice that this program's connection is lost."""
        if not isinstance(error, Taken):
            self._held_since_s = None
            return False
        if self._held_since_s is None:
            self._held_since_s = now_s
        return now_s - self._held_since_s >= _NOTICED_WITHIN_S

    def is_lost(self) -> bool:
        """Whether the connection has been lost and is not back."""
        return self._end_s is not None
