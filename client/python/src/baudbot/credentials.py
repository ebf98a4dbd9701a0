"""What a client shows a server, and how it recognizes the server: from the environment, else the token of the user's own server."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import grpc

from .errors import Refused

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Credentials:
    """A token, and files in PEM."""

    #: What is shown with each call.
    token: str | None = None
    #: Authorities whose servers are trusted, in place of those of the system.
    ca: bytes | None = None
    #: A certificate of one's own, and its key.
    certificate: bytes | None = None
    key: bytes | None = None

    @classmethod
    def find(cls, address: str, environment: Mapping[str, str] = os.environ) -> Credentials:
        """Those of `BAUDBOT_TOKEN`, or in files `BAUDBOT_TOKEN_FILE`, `BAUDBOT_CA`, `BAUDBOT_CERTIFICATE` and `BAUDBOT_KEY`. Without a
        token it is that of the user's own server at this address of this machine, if there is one.
        """
        token = environment.get("BAUDBOT_TOKEN")
        if token is None:
            token = _read(environment, "BAUDBOT_TOKEN_FILE", _text) or own_token(address)
        return cls(
            token=token.strip() if token else None,
            ca=_read(environment, "BAUDBOT_CA", Path.read_bytes),
            certificate=_read(environment, "BAUDBOT_CERTIFICATE", Path.read_bytes),
            key=_read(environment, "BAUDBOT_KEY", Path.read_bytes),
        )

    @property
    def metadata(self) -> tuple[tuple[str, str], ...]:
        """The token, as calls have it."""
        return () if self.token is None else (("authorization", f"Bearer {self.token}"),)

    def tls(self) -> grpc.ChannelCredentials:
        """What a connection over TLS needs."""
        return grpc.ssl_channel_credentials(self.ca, self.key, self.certificate)


def own_token(address: str) -> str | None:
    """The token of this user's own server at `127.0.0.1:7400` or `unix:/PATH`; None if there is none."""
    if address.startswith("unix:"):
        path = os.path.realpath(address.removeprefix("unix:"))
        name = "unix-" + hashlib.sha256(os.fsencode(path)).hexdigest()
    else:
        name = address.partition("://")[2] or address
        name = name.rstrip("/").replace("localhost:", "127.0.0.1:")
    if "/" in name:
        return None
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    for folder in [f"{runtime}/baudbot"] * bool(runtime) + [f"/tmp/baudbot-{os.getuid()}"]:
        try:
            there = os.lstat(folder)
            # Nobody else may put a token there.
            if stat.S_ISDIR(there.st_mode) and there.st_uid == os.getuid() and not there.st_mode & 0o077:
                return Path(folder, f"{name}.token").read_text(encoding="ascii")
        except FileNotFoundError:
            pass
    return None


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _read(environment: Mapping[str, str], name: str, read: Callable[[Path], T]) -> T | None:
    """What is in the file that a variable names, if it is set."""
    path = environment.get(name)
    if not path:
        return None
    try:
        return read(Path(path))
    except (OSError, UnicodeError) as error:
        raise Refused(f"{name}: {path}: {error}") from None
