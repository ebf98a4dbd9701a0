"""Where a brain attaches: by arguments, else by the environment, else by default."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from .brain import Value
from .errors import NotFound, Refused
from .names import matching, natural
from .v1 import world_pb2

#: Where `baudbot serve` listens by default.
DEFAULT_CONNECT = "127.0.0.1:7400"


@dataclass(frozen=True, slots=True)
class Settings:
    """What a brain program is started with."""

    #: `HOST:PORT` or `unix:/PATH`.
    connect: str = DEFAULT_CONNECT
    #: Name of the world; None: the only one that the server has.
    world: str | None = None
    #: Names of robots or patterns of names (`cell-*`); none: the world's only robot.
    robots: tuple[str, ...] = ()
    #: Seed of the brain's own random numbers.
    seed: int = 1
    parameters: Mapping[str, Value] = field(default_factory=dict)
    #: For how long a brain tries to reconnect to a server that it has lost; 0: not at all.
    reconnect_s: float = 600.0

    @classmethod
    def find(
        cls,
        connect: str | None = None,
        world: str | None = None,
        robots: str | Iterable[str] | None = None,
        seed: int | None = None,
        parameters: Mapping[str, Value] | None = None,
        reconnect_s: float | None = None,
        environment: Mapping[str, str] = os.environ,
    ) -> Settings:
        """What is given; for the rest `BAUDBOT_CONNECT`, `_WORLD`, `_ROBOT` (separated by commas), `_SEED`, `_PARAMETERS`
        (JSON) and `_RECONNECT_S`, which `baudbot run` sets for the programs that it starts; for what is left, the defaults. Parameters that
        are given are added to those of the environment.
        """
        if robots is None:
            robots = [name for name in environment.get("BAUDBOT_ROBOT", "").split(",") if name]
        elif isinstance(robots, str):
            robots = [robots]
        return cls(
            connect=connect or environment.get("BAUDBOT_CONNECT") or DEFAULT_CONNECT,
            world=world or environment.get("BAUDBOT_WORLD") or None,
            robots=tuple(robots),
            seed=int(_number("BAUDBOT_SEED", "1", environment)) if seed is None else seed,
            parameters=environment_parameters(environment) | dict(parameters or {}),
            reconnect_s=_number("BAUDBOT_RECONNECT_S", "600", environment) if reconnect_s is None else reconnect_s,
        )

    def needs_look(self) -> bool:
        """Whether the server must be asked which worlds and robots there are."""
        return self.world is None or not self.robots or any(c in name for name in self.robots for c in "*?[")

    def choose(self, worlds: Iterable[world_pb2.WorldStatus]) -> tuple[str, list[str]]:
        """The world and its robots, among those that the server has."""
        by_name = {status.world: status for status in worlds}
        names = sorted(by_name, key=natural)
        if self.world is None and len(names) != 1:
            several = f"the server has several worlds; choose one: {', '.join(names)}"
            raise NotFound(several if names else "the server has no worlds")
        (world,) = matching([self.world or names[0]], names, "world")
        there = [robot.robot for robot in by_name[world].robots]
        if not self.robots and len(there) != 1:
            several = f"world `{world}` has several robots; choose some: {', '.join(sorted(there, key=natural))}"
            raise NotFound(several if there else f"world `{world}` has no robots")
        return world, matching(self.robots or there, there, "robot", f" in world `{world}`")


def runs(environment: Mapping[str, str] = os.environ, lines: Iterable[str] | None = None) -> Iterator[Mapping[str, str]]:
    """The environment of each run that a program is to do: its own, and, if that has `BAUDBOT_REUSE=1`, one for each line of
    the standard input, which has the variables that change as a JSON object.
    """
    yield environment
    if environment.get("BAUDBOT_REUSE") != "1":
        return
    for line in sys.stdin if lines is None else lines:
        try:
            changes = json.loads(line)
        except ValueError as error:
            raise Refused(f"a run on the standard input is not JSON ({error}): {line.strip()}") from None
        if not isinstance(changes, dict) or not all(isinstance(value, str) for value in changes.values()):
            raise Refused(f"a run on the standard input must be an object of texts, is {line.strip()}")
        yield {**environment, **changes}


def _number(name: str, default: str, environment: Mapping[str, str]) -> float:
    """A number of the environment; whole ones are exact."""
    text = environment.get(name) or default
    try:
        return int(text) if text.isdecimal() else float(text)
    except ValueError:
        raise Refused(f"{name} must be a number, is {text!r}") from None


def environment_parameters(environment: Mapping[str, str]) -> dict[str, Value]:
    """The parameters in `BAUDBOT_PARAMETERS`."""
    text = environment.get("BAUDBOT_PARAMETERS") or "{}"
    try:
        parameters = json.loads(text)
    except ValueError as error:
        raise Refused(f"BAUDBOT_PARAMETERS is not JSON ({error}): {text}") from None
    if not isinstance(parameters, dict):
        raise Refused(f"BAUDBOT_PARAMETERS must be an object, such as {{\"speed\": 0.4}}; is {text}")
    return parameters
