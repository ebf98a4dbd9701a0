"""Connections to a server."""

from __future__ import annotations

from typing import Any, NamedTuple

import grpc

from .credentials import Credentials

#: Worlds are described in messages that are about as long as their scenarios, which may have 16 MiB.
_MAX_MESSAGE_BYTES = 64 << 20

_OPTIONS: list[tuple[str, Any]] = [
    # Notices a server that has gone without a word: a brain that waits for its turn hears nothing for a long time.
    ("grpc.keepalive_time_ms", 20_000),
    ("grpc.keepalive_timeout_ms", 20_000),
    ("grpc.http2.max_pings_without_data", 0),
    ("grpc.max_receive_message_length", _MAX_MESSAGE_BYTES),
    # The machine's proxy has no business between a robot and its brain.
    ("grpc.enable_http_proxy", 0),
]


def target(address: str) -> str:
    """`HOST:PORT`, `http://HOST:PORT`, `https://HOST:PORT` or `unix:/PATH` as gRPC has it."""
    for scheme in ("http://", "https://"):
        if address.startswith(scheme):
            return address.removeprefix(scheme).rstrip("/")
    return address


def options(address: str) -> list[tuple[str, Any]]:
    """The options of a channel to this address."""
    # Without this, gRPC calls the host of a Unix socket by its path, which servers refuse.
    authority = [("grpc.default_authority", "localhost")] if address.startswith("unix:") else []
    return _OPTIONS + authority


def open_channel(address: str) -> grpc.Channel:
    """A channel to this address, whose calls show a token; nothing is sent yet."""
    credentials = Credentials.find(address)
    if address.startswith("https://"):
        channel = grpc.secure_channel(target(address), credentials.tls(), options(address))
    else:
        channel = grpc.insecure_channel(target(address), options(address))
    return channel if credentials.token is None else grpc.intercept_channel(channel, _Shows(credentials))


def open_aio_channel(address: str, credentials: Credentials) -> grpc.aio.Channel:
    """The same for asyncio. Calls have to show the token themselves, as their `metadata`."""
    if address.startswith("https://"):
        return grpc.aio.secure_channel(target(address), credentials.tls(), options(address))
    return grpc.aio.insecure_channel(target(address), options(address))


class _Shows(
    grpc.UnaryUnaryClientInterceptor,
    grpc.UnaryStreamClientInterceptor,
    grpc.StreamUnaryClientInterceptor,
    grpc.StreamStreamClientInterceptor,
):
    """Shows the token with each call."""

    def __init__(self, credentials: Credentials) -> None:
        self._metadata = credentials.metadata

    def _goes_on(self, go_on: Any, details: Any, request: Any) -> Any:
        shown = _Details(
            details.method,
            details.timeout,
            (*(details.metadata or ()), *self._metadata),
            details.credentials,
            details.wait_for_ready,
            details.compression,
        )
        return go_on(shown, request)

    # All four are the same, which their types do not say.
    intercept_unary_unary: Any = _goes_on
    intercept_unary_stream: Any = _goes_on
    intercept_stream_unary: Any = _goes_on
    intercept_stream_stream: Any = _goes_on


class _Details(NamedTuple):
    """What a call is, as interceptors have it."""

    method: str
    timeout: float | None
    metadata: tuple[tuple[str, str], ...]
    credentials: Any
    wait_for_ready: bool | None
    compression: Any
