"""From what a user writes to a task: scenarios, changes of fields, brains, what is drawn for each run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from . import scenarios
from ._errors import Invalid
from ._native import Task

#: A scenario: a file, or the name of a built-in one, or TOML, which has more than one line.
Scenario = str | os.PathLike[str]


def task(
    scenario: Scenario,
    overrides: Mapping[str, object] | None = None,
    brains: str | Mapping[str, str] | None = None,
    agents: Sequence[str] | None = None,
    randomize: Mapping[str, object] | None = None,
) -> Task:
    """A task. `overrides` are fields by their paths, `brains` a brain for all robots or for some by name."""
    text = os.fspath(scenario)
    return Task(
        text,
        is_text="\n" in text,
        overrides=lines(overrides),
        brains=_brains(brains),
        agents=list(agents or ()),
        randomize=[_drawn(path, how) for path, how in (randomize or {}).items()],
    )


def fields(overrides: Mapping[str, object] | None, named: Mapping[str, object]) -> dict[str, object]:
    """Fields by their paths. In the name of an argument `__` stands for a dot: `end__after_s=60`."""
    return {**(overrides or {}), **{name.replace("__", "."): value for name, value in named.items()}}


def lines(overrides: Mapping[str, object] | None) -> list[str]:
    """Each as `--set` has it."""
    return [f"{path}={toml(value, path)}" for path, value in (overrides or {}).items()]


def toml(value: object, path: str) -> str:
    """A value in TOML."""
    try:
        return scenarios.toml(value)
    except TypeError:
        raise Invalid(f"{path}: a scenario has no value of the kind {type(value).__name__}", path) from None


def says_how(table: Mapping[str, object]) -> bool:
    """Whether a table says how a field is drawn."""
    return len(table) == 1 and next(iter(table)) in (*_RANGES, "choice")


def weights(reward: Mapping[str, float] | None) -> list[tuple[str, float]]:
    """A reward as weights of what happened in a step."""
    return [(name, float(weight)) for name, weight in (reward or {}).items()]


def _brains(brains: str | Mapping[str, str] | None) -> list[str]:
    if brains is None:
        return []
    if isinstance(brains, str):
        return [brains]
    return [f"{robot}={brain}" for robot, brain in brains.items()]


_RANGES = ("uniform", "log-uniform", "integer")


def _drawn(path: str, how: object) -> tuple[str, str, float, float, list[str]]:
    """A list is a choice; `{"uniform": [low, high]}`, `{"log-uniform": …}`, `{"integer": …}` and `{"choice": […]}` say how."""
    if isinstance(how, (list, tuple)):
        how = {"choice": how}
    if not isinstance(how, Mapping) or len(how) != 1:
        kinds = ", ".join((*_RANGES, "choice"))
        raise Invalid(f"randomize.{path}: write a list, or one of {kinds} with its values", f"randomize.{path}")
    ((kind, values),) = how.items()
    if kind in _RANGES:
        try:
            low, high = (float(value) for value in values)
        except (TypeError, ValueError):
            raise Invalid(f"randomize.{path}.{kind}: write two numbers, [low, high]", f"randomize.{path}") from None
        return path, str(kind), low, high, []
    if not isinstance(values, (list, tuple)):
        raise Invalid(f"randomize.{path}.{kind}: write a list of values", f"randomize.{path}")
    return path, str(kind), 0.0, 0.0, [toml(value, f"randomize.{path}") for value in values]
