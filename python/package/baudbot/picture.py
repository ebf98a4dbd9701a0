"""Pictures as pixels."""

from __future__ import annotations

from typing import Any

from .errors import Error


def pixels(svg: str, size: int) -> Any:
    """A picture as an array of shape (height, width, 3), whose longer side has so many pixels."""
    from . import _native

    return _native.pixels(svg, size)
