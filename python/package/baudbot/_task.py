"""From what a user writes to a task: scenarios, changes of fields, brains, what is drawn for each run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

from . import _given, scenarios
from ._errors import Invalid, Mistyped
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
    text = _given.path(scenario, "scenario")
    return Task(
        text,
        label="scenario" if "\n" in text else None,
        overrides=lines(overrides),
        brains=_brains(brains),
        agents=[] if agents is None else _given.names(agents, "agents"),
        randomize=[_drawn(path, how) for path, how in (randomize or {}).items()],
    )


def fields(overrides: Mapping[str, object] | None, named: Mapping[str, object]) -> dict[str, object]:
    """Fields by their paths. In the name of an argument `__` stands for a dot: `end__after_s=60`."""
    given = {} if overrides is None else _given.mapping(overrides, "overrides", "mapping from fields to values")
    return {**given, **{name.replace("__", "."): value for name, value in named.items()}}


def lines(overrides: Mapping[str, object] | None) -> list[str]:
    """Each as `--set` has it."""
    return [f"{path}={toml(value, path)}" for path, value in (overrides or {}).items()]


def toml(value: object, path: str) -> str:
    """A value in TOML."""
    try:
        return scenarios.toml(value)
    except TypeError:
        raise Mistyped(f"{path}: a scenario has no value of the kind {type(value).__name__}", path) from None


def says_how(table: Mapping[str, object]) -> bool:
    """Whether a table says how a field is drawn."""
    return len(table) == 1 and next(iter(table)) in (*_RANGES, "choice")


def weights(reward: Mapping[str, float]) -> list[tuple[str, float]]:
    """A reward as weights of what happened in a step."""
    return [(name, _given.number(weight, f"reward.{name}")) for name, weight in reward.items()]


def _brains(brains: str | Mapping[str, str] | None) -> list[str]:
    if brains is None:
        return []
    if isinstance(brains, str):
        return [brains]
    given = _given.mapping(brains, "brains", "brain, such as \"avoid\", or mapping from robots to brains")
    return [f"{robot}={_given.text(brain, f'brains.{robot}', 'brain')}" for robot, brain in given.items()]


_RANGES = ("uniform", "log-uniform", "integer")


def _drawn(path: str, how: object) -> tuple[str, str, float, float, list[str]]:
    """A list is a choice; `{"uniform": [low, high]}`, `{"log-uniform": …}`, `{"integer": …}` and `{"choice": […]}` say how."""
    name = f"randomize.{path}"
    if isinstance(how, (list, tuple)):
        how = {"choice": how}
    if not isinstance(how, Mapping) or len(how) != 1:
        kinds = ", ".join((*_RANGES, "choice"))
        raise Invalid(f"{name}: write a list, or one of {kinds} with its values", name)
    ((kind, values),) = how.items()
    if kind in _RANGES:
        try:
            low, high = (_given.number(value, f"{name}.{kind}") for value in values)
        except (TypeError, ValueError):
            raise Invalid(f"{name}.{kind}: write two numbers, [low, high]", name) from None
        return path, str(kind), low, high, []
    if not isinstance(values, (list, tuple)):
        raise Invalid(f"{name}.{kind}: write a list of values", name)
    return path, str(kind), 0.0, 0.0, [toml(value, name) for value in values]
