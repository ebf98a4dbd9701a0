"""Scenarios: files, texts, and those that come with baudbot."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..errors import NotFound, Refused
from ..names import unknown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: What `create_world` takes as a keyword for all robots: the field of each.
_OF_EACH_ROBOT = {"baud": "link.baud"}


def built_in() -> list[str]:
    """The names of the scenarios that come with baudbot."""
    return sorted(file.name.removesuffix(".toml") for file in files(__package__).iterdir() if file.name.endswith(".toml"))


def read(scenario: str | Path) -> str:
    """The text of a scenario: of a built-in one by its name, of a file by its path, or the text itself."""
    if isinstance(scenario, str):
        if scenario in built_in():
            return (files(__package__) / f"{scenario}.toml").read_text(encoding="utf-8")
        if "\n" in scenario or "=" in scenario:
            return scenario
    try:
        return Path(scenario).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise NotFound(unknown("file or built-in scenario", str(scenario), built_in())) from None
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f"{scenario}: {error}") from None


def overrides(text: str, fields: Mapping[str, Any], keywords: Mapping[str, Any]) -> list[str]:
    """Changes of single fields, as `--set` has them: by path, and by keyword (`baud` of all robots; else a field of the
    scenario itself, such as `seed`)."""
    changes = [f"{path}={toml(value)}" for path, value in fields.items()]
    for name, value in keywords.items():
        field = _OF_EACH_ROBOT.get(name)
        if field is None:
            changes.append(f"{name}={toml(value)}")
        else:
            changes.extend(f"robots.{i}.{field}={toml(value)}" for i in range(_robots(text)))
    return changes


def _robots(text: str) -> int:
    try:
        return len(tomllib.loads(text).get("robots", []))
    except tomllib.TOMLDecodeError as error:
        raise Refused(f"the scenario is not TOML: {error}") from None


def toml(value: Any) -> str:
    """A value as TOML has it.

    Raises `TypeError` if TOML has none of its kind.
    """
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{quoted(str(key))} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml, value)) + "]"
    # NumPy's numbers and arrays convert to Python's own.
    if hasattr(value, "tolist"):
        return toml(value.tolist())
    if isinstance(value, str):
        return quoted(value)
    # JSON writes infinities differently.
    return repr(value) if isinstance(value, float) else json.dumps(value)


def quoted(text: str) -> str:
    """A text in TOML, which unlike JSON has no bare DEL, and no halves of characters."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
