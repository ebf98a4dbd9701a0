"""Connections to a server."""

from __future__ import annotations

from typing import Any

import grpc

#: Worlds are described in messages that are about as long as their scenarios, which may have 16 MiB.
_MAX_MESSAGE_BYTES = 64 << 20

_OPTIONS: list[tuple[str, Any]] = [
    # A server that is gone without a word is noticed: a brain that waits for its turn hears nothing for long.
    ("grpc.keepalive_time_ms", 20_000),
    ("grpc.keepalive_timeout_ms", 20_000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.max_receive_message_length", _MAX_MESSAGE_BYTES),
    # A proxy of the machine's has no business between a robot and its brain.
    ("grpc.enable_http_proxy", 0),
]


def target(address: str) -> str:
    """`HOST:PORT`, `http://HOST:PORT` or `unix:/PATH` as gRPC has it."""
    return address.removeprefix("http://").rstrip("/") if address.startswith("http://") else address


def options(address: str) -> list[tuple[str, Any]]:
    """The options of a channel to this address."""
    # Without this, gRPC calls the host of a Unix socket by its path, which servers refuse.
    authority = [("grpc.default_authority", "localhost")] if address.startswith("unix:") else []
    return _OPTIONS + authority


def open_channel(address: str) -> grpc.Channel:
    """A channel to this address; nothing is sent yet."""
    return grpc.insecure_channel(target(address), options(address))
