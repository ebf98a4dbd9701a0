"""Arguments as they are given: of a type and of a size that they can have, or an error that names them."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from reprlib import repr as short
from typing import Any, SupportsIndex, TypeVar

import numpy as np

from ._errors import Invalid, Mistyped

F = TypeVar("F", bound=Callable[..., Any])


def whole(value: object, name: str, least: int, most: int, what: str = "whole number") -> int:
    """A whole number, Python's or NumPy's."""
    wrong = Mistyped(f"{name}: {short(value)} is not a {what}; write one from {_bound(least)} to {_bound(most)}", name)
    # A truth value is a number to Python, and an array may be one.
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, SupportsIndex):
        raise wrong
    try:
        number = operator.index(value)
    except TypeError:
        raise wrong from None
    if not least <= number <= most:
        raise Invalid(f"{name}: {short(number)} is not a {what} from {_bound(least)} to {_bound(most)}", name)
    return number


def number(value: object, name: str) -> float:
    """A number, Python's or NumPy's."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, Real):
        raise Mistyped(f"{name}: {short(value)} is not a number", name)
    try:
        return float(value)
    except OverflowError:
        raise Invalid(f"{name}: {short(value)} is too large", name) from None


def seconds(value: object, name: str) -> float:
    """A time from now on."""
    time_s = number(value, name)
    if not 0 <= time_s < 1e9:
        raise Invalid(f"{name}: {value!r} is not a time; write one from 0 to 1e9 seconds", name)
    return time_s


def text(value: object, name: str, what: str = "text") -> str:
    if not isinstance(value, str):
        raise Mistyped(f"{name}: {short(value)} is not a {what}", name)
    return value


def path(value: object, name: str) -> str:
    """A path as text."""
    if not isinstance(value, (str, os.PathLike)):
        raise Mistyped(f"{name}: {short(value)} is not a path", name)
    return os.fsdecode(value)


def flag(value: object, name: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise Mistyped(f"{name}: {short(value)} is neither True nor False", name)
    return bool(value)


def function(value: F, name: str) -> F:
    if not callable(value):
        raise Mistyped(f"{name}: {short(value)} is not a function", name)
    return value


def mapping(value: object, name: str, what: str = "mapping") -> Mapping[str, Any]:
    """A mapping whose keys are strings."""
    if not isinstance(value, Mapping):
        raise Mistyped(f"{name}: {short(value)} is not a {what}", name)
    for key in value:
        text(key, name, "name")
    return value


def names(value: object, name: str) -> list[str]:
    """Names; a single text is not a list of them."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise Mistyped(f"{name}: {short(value)} is not a list of names", name)
    return [text(one, name, "name") for one in value]


def _bound(number: int) -> str:
    return {(1 << 63) - 1: "2**63 - 1"}.get(number, str(number))
