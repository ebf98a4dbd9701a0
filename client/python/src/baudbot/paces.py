"""Paces by their names: when a tick ends."""

from __future__ import annotations

from .errors import Refused
from .v1 import world_pb2 as pb


def pace(name: str) -> pb.Pace:
    """`lockstep`, `stepped`, `real-time`, `scaled:X` or `free`, as for the program's `--pace`."""
    kind, _, factor = name.partition(":")
    message = pb.Pace()
    if name in ("lockstep", "stepped", "real-time", "free"):
        getattr(message, name.replace("-", "_")).SetInParent()
        return message
    try:
        if kind == "scaled":
            message.scaled.factor = float(factor)
            return message
    except ValueError:
        pass
    raise Refused(f"a pace is lockstep, stepped, real-time, scaled:X (such as scaled:2) or free, not `{name}`")
