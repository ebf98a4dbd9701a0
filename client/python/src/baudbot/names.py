"""Names of robots: their natural order, and patterns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from fnmatch import fnmatchcase

from .errors import NotFound


def natural(name: str) -> list[tuple[int, str]]:
    """The key by which `cell-2` comes before `cell-10`."""
    return [(int(part), part) if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name) if part]


def matching(patterns: Iterable[str], names: Sequence[str], kind: str, where: str = "") -> list[str]:
    """The names that any of the patterns (`cell-*`) matches, each once, in their natural order within a pattern."""
    found: dict[str, None] = {}
    for pattern in patterns:
        # A name is itself, whatever is in it.
        hits = [pattern] if pattern in names else [name for name in names if fnmatchcase(name, pattern)]
        if not hits:
            raise NotFound(unknown(kind, pattern, names, where))
        found.update(dict.fromkeys(sorted(hits, key=natural)))
    return list(found)


def unknown(kind: str, name: str, known: Sequence[str], where: str = "") -> str:
    """That there is no such name (` in world …`), with the one that may be meant."""
    close = get_close_matches(name, known, 1)
    meant = f"; did you mean `{close[0]}`?" if close else f"; there are: {', '.join(sorted(known, key=natural))}"
    return f"there is no {kind} `{name}`{where}{meant if known else ''}"
