"""What can be wrong with worlds in this process."""

from __future__ import annotations

from .errors import Error


class Invalid(Error, ValueError):
    """A scenario, an option or an action makes no sense. `path` is the field that is wrong, if it is one."""

    def __init__(self, text: str, path: str | None = None) -> None:
        super().__init__(text)
        self.path = path

    def __reduce__(self) -> tuple[type[Invalid], tuple[str, str | None]]:
        return type(self), (str(self), self.path)


class Mistyped(Invalid, TypeError):
    """An argument is of a type that it cannot have. It is Python's `TypeError`, too."""


class Closed(Error, RuntimeError):
    """The world or the environment has been closed."""


class Busy(Error, RuntimeError):
    """Another thread is stepping this world. A world is for one thread at a time; make one for each."""
