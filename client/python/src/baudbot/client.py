"""A server, for operators and observers."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

import grpc

from . import scenarios
from .attach import PATIENCE_S
from .channel import open_channel
from .handshake import failed
from .names import matching, natural
from .paces import pace as pace_of
from .settings import DEFAULT_CONNECT
from .v1 import control_pb2, observe_pb2
from .v1.control_pb2_grpc import ControlServiceStub
from .v1.observe_pb2_grpc import ObserveServiceStub
from .world import ServedWorld

Q = TypeVar("Q")
R = TypeVar("R")


class Client:
    """A server, by its address: `HOST:PORT` or `unix:/PATH`; by default that of `BAUDBOT_CONNECT`, or `127.0.0.1:7400`. ::

        with baudbot.Client() as client:
            world = client.create_world("wander", baud=2400)
            world.start()
    """

    def __init__(self, connect: str | None = None) -> None:
        self.address = connect or os.environ.get("BAUDBOT_CONNECT") or DEFAULT_CONNECT
        self._channel = open_channel(self.address)
        #: The services of the contract, for what has no method here: `client.call(client.control.SaveWorld, request)`.
        self.control, self.observe = ControlServiceStub(self._channel), ObserveServiceStub(self._channel)

    def close(self) -> None:
        """Closes the connection. Worlds go on."""
        self._channel.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def call(
        self, method: grpc.UnaryUnaryMultiCallable[Q, R], request: Q, timeout_s: float | None = PATIENCE_S
    ) -> R:
        """Calls a method of a service of the contract; its errors are raised as an `Error`."""
        try:
            return method(request, timeout=timeout_s)
        except grpc.RpcError as error:
            raise failed(error, self.address) from None

    def watch(self, request: observe_pb2.WatchRequest) -> Iterator[observe_pb2.WatchResponse]:
        """The frames of a world."""
        frames = self.observe.Watch(request)
        try:
            yield from frames
        except grpc.RpcError as error:
            raise failed(error, self.address) from None
        finally:
            frames.cancel()

    def worlds(self) -> list[ServedWorld]:
        """The worlds of the server, in the natural order of their names."""
        statuses = self.call(self.control.ListWorlds, control_pb2.ListWorldsRequest()).worlds
        return [ServedWorld(self, name) for name in sorted((status.world for status in statuses), key=natural)]

    def world(self, name: str | None = None) -> ServedWorld:
        """The world of this name, or the only one that the server has."""
        there = [world.name for world in self.worlds()]
        if name is None and len(there) == 1:
            return ServedWorld(self, there[0])
        if name is None:
            raise LookupError(f"the server has {len(there)} worlds; name one: {', '.join(there)}")
        return ServedWorld(self, matching([name], there, "world")[0])

    def create_world(
        self,
        scenario: str | Path,
        name: str = "",
        *,
        pace: str = "lockstep",
        paused: bool = False,
        set: Mapping[str, Any] | None = None,
        **fields: Any,
    ) -> ServedWorld:
        """Makes a world from a scenario: a built-in one (`wander`), a file, or TOML text.

        `fields` are changes of the scenario, such as `seed=7` or `baud=2400` (of every robot); `set` has any others by their
        path, such as `{"robots.robot.start.x_m": 0.5}`. In lockstep it waits for a brain of each of its robots.
        """
        text = scenarios.read(scenario)
        request = control_pb2.CreateWorldRequest(
            world=name,
            scenario_toml=text,
            overrides=scenarios.overrides(text, set or {}, fields),
            pace=pace_of(pace),
            paused=paused,
        )
        return ServedWorld(self, self.call(self.control.CreateWorld, request).status.world)
