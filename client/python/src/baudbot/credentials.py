"""What a client shows a server, and how it recognizes the server: from the environment, else the token of the user's own server."""

from __future__ import annotations

import hashlib
import ipaddress
import os
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass

import grpc

from .errors import Refused

#: Bytes of the longest file that is read: one with a token, which has 51, and one with certificates or a key.
_MOST_BYTES_OF_TOKEN, _MOST_BYTES_OF_PEM = 4096, 1 << 20


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
    #: The files of these.
    ca_file: str | None = None
    certificate_file: str | None = None
    key_file: str | None = None

    @classmethod
    def find(cls, address: str, environment: Mapping[str, str] = os.environ) -> Credentials:
        """Those of `BAUDBOT_TOKEN`, or in files `BAUDBOT_TOKEN_FILE`, `BAUDBOT_CA`, `BAUDBOT_CERTIFICATE` and `BAUDBOT_KEY`; what is
        empty is not set. Without a token it is that of the user's own server at this address of this machine, if there is one.

        Raises `Refused` if a file cannot be used, or the token would go to another machine without TLS.
        """
        token = environment.get("BAUDBOT_TOKEN") or _token(environment) or own_token(address)
        if token and not (address.startswith("https://") or _is_of_this_machine(address)):
            place = address.removeprefix("http://").rstrip("/")
            raise Refused(
                f"no token is sent to {place} without TLS, as that is another machine: write https://{place}, or, if the server is "
                "behind a proxy, the proxy's https:// address"
            )
        own = environment.get("BAUDBOT_CERTIFICATE") or None, environment.get("BAUDBOT_KEY") or None
        if own[0] and not own[1]:
            raise Refused("BAUDBOT_CERTIFICATE: needs its key, in BAUDBOT_KEY")
        if own[1] and not own[0]:
            raise Refused("BAUDBOT_KEY: needs its certificate, in BAUDBOT_CERTIFICATE")
        return cls(
            token=token.strip() if token else None,
            ca=_read(environment, "BAUDBOT_CA", _MOST_BYTES_OF_PEM),
            certificate=_read(environment, "BAUDBOT_CERTIFICATE", _MOST_BYTES_OF_PEM),
            key=_read(environment, "BAUDBOT_KEY", _MOST_BYTES_OF_PEM),
            ca_file=environment.get("BAUDBOT_CA") or None,
            certificate_file=own[0],
            key_file=own[1],
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
    if not _is_of_this_machine(address):
        return None
    if address.startswith("unix:"):
        path = os.path.realpath(address.removeprefix("unix:"))
        name = "unix-" + hashlib.sha256(os.fsencode(path)).hexdigest()
    else:
        name = address.partition("://")[2] or address
        name = name.rstrip("/").replace("localhost:", "127.0.0.1:")
    if "/" in name:
        return None
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    for folder in [f"{runtime}/baudbot"] * bool(runtime) + [f"/tmp/baudbot-{os.getuid()}", os.path.expanduser("~/.baudbot")]:
        try:
            there = os.lstat(folder)
            # Nobody else may put a token there.
            if stat.S_ISDIR(there.st_mode) and there.st_uid == os.getuid() and not there.st_mode & 0o077:
                with open(f"{folder}/{name}.token", encoding="ascii") as file:
                    return file.read(_MOST_BYTES_OF_TOKEN)
        except FileNotFoundError:
            pass
    return None


def _is_of_this_machine(address: str) -> bool:
    """Whether what is sent to this address does not leave the machine."""
    if address.startswith("unix:"):
        return True
    place = address.partition("://")[2] or address
    host = place.rstrip("/").rpartition(":")[0]
    # Names within `localhost` are never looked up elsewhere (RFC 6761).
    if re.fullmatch(r"([\w-]+\.)*localhost\.?", host, re.IGNORECASE):
        return True
    try:
        ip = ipaddress.ip_address(host.removeprefix("[").removesuffix("]"))
    except ValueError:
        return False
    # A connection to the unspecified address goes to this machine.
    ip = getattr(ip, "ipv4_mapped", None) or ip
    return ip.is_loopback or ip.is_unspecified


def _token(environment: Mapping[str, str]) -> str | None:
    read = _read(environment, "BAUDBOT_TOKEN_FILE", _MOST_BYTES_OF_TOKEN)
    try:
        return read.decode() if read is not None else None
    except UnicodeError:
        path = environment["BAUDBOT_TOKEN_FILE"]
        raise Refused(f"BAUDBOT_TOKEN_FILE={path}: is not a text in UTF-8; is it the right file?") from None


def _read(environment: Mapping[str, str], name: str, most_bytes: int) -> bytes | None:
    """What is in the file that a variable names, if it is set."""
    path = environment.get(name)
    if not path:
        return None
    try:
        with open(path, "rb") as file:
            read = file.read(most_bytes + 1)
    except (OSError, ValueError) as error:
        # A path with a zero byte is a ValueError, whose text says it.
        raise Refused(f"{name}={path}: {getattr(error, 'strerror', None) or error}") from None
    if len(read) > most_bytes:
        raise Refused(f"{name}={path}: has more than {most_bytes} bytes; is it the right file?")
    return read
