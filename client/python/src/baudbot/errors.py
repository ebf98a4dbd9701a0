"""What can go wrong between a program and its server, each a line that says what to do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import grpc


class Error(Exception):
    """A program of a robot cannot do what it was asked to. Its text is one line for people."""

    #: Whether the same may succeed a while later.
    may_pass = False


class NoServer(Error):
    """No server answers there, or the connection to it is lost."""

    may_pass = True


class Untrusted(Error):
    """The server or this program does not trust the other's certificate."""


class Taken(Error):
    """Another brain holds the robot, or this program's own lost connection does, which the server has not given up yet."""

    may_pass = True


class NotFound(Error):
    """There is no such world, robot or file."""


class Refused(Error):
    """The server refuses the request; its message names the field."""


class Restart(Error):
    """The operator asked the brain to restart. `attach` makes it afresh."""


class Detached(Error):
    """The operator or the watchdog took the robot away, or the world is gone."""


class NotARecording(Error):
    """The file is not a recording, or too little of one is left in it."""


class NoReading(Error):
    """Nothing has arrived from this sensor yet, or the robot has no such sensor."""


_KINDS: dict[grpc.StatusCode, type[Error]] = {
    grpc.StatusCode.UNAVAILABLE: NoServer,
    grpc.StatusCode.ALREADY_EXISTS: Taken,
    grpc.StatusCode.NOT_FOUND: NotFound,
    grpc.StatusCode.ABORTED: Detached,
    grpc.StatusCode.DEADLINE_EXCEEDED: Detached,
}


def printable(text: str) -> str:
    """A text from elsewhere, without anything that a terminal would obey."""
    return "".join(c if c.isprintable() else f"\\u{{{ord(c):x}}}" for c in text)


def is_unreached(error: grpc.RpcError) -> bool:
    """Whether a call has not reached its server: a status that the transport makes up has no trailers."""
    return error.code() == grpc.StatusCode.UNAVAILABLE and not _trailers(error)


def from_rpc(error: grpc.RpcError, address: str, hint: str = "") -> Error:
    """The error of a call to the server at this address; the hint says more about one that is not reached."""
    code, details = error.code(), printable(error.details() or "")
    if is_unreached(error):
        return NoServer(f"no server answers at {address} ({details}{hint}); is `baudbot serve` running there?")
    if any(item.key == "baudbot-reason" and item.value == "restart" for item in _trailers(error)):
        return Restart("the operator asked this brain to restart")
    if code == grpc.StatusCode.UNIMPLEMENTED and not details:
        return Refused(
            f"the server at {address} does not serve that there: trainers connect to the address of `baudbot serve --trainer`, "
            "brains and observers to that of `--listen`"
        )
    return _KINDS.get(code, Refused)(f"the server says: {details} ({code.name})")


def from_status(code: int, details: str) -> Error:
    """The error of a status within a message: a code of gRPC's, and what the server says."""
    known = next((status for status in grpc.StatusCode if status.value[0] == code), grpc.StatusCode.UNKNOWN)
    return _KINDS.get(known, Refused)(f"the server says: {printable(details)} ({known.name})")


def _trailers(error: grpc.RpcError) -> Sequence[Any]:
    return tuple(error.trailing_metadata() or ())
