"""What several tests need."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]

#: The program of the same build: that of the package, unless another is named.
PROGRAM = os.environ.get("BAUDBOT", "baudbot")


def scenario(name: str) -> str:
    """The file of a scenario of the project."""
    return str(ROOT / "catalogue/scenarios" / f"{name}.toml")


def program(*arguments: str) -> Any:
    """What the program says as JSON."""
    done = subprocess.run([PROGRAM, *arguments, "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def nearest_steer(nearest: float) -> tuple[float, float]:
    """On, more slowly the nearer something is, and to the left before what is too near."""
    way = 1.0 - nearest / 0.28
    return (0.15 + 0.35 * way, 0.15 + 0.35 * way) if way > 0 else (-0.5, 0.5)
