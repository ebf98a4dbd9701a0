"""Builds the wheel in a clone, as `pip install ./python` does: maturin's backend, with the program in it, and the clone's baudbot-client.

The program `baudbot` is built first and becomes a script of the wheel. `python/build-wheel` builds the wheel of a release without this.

With BAUDBOT_BUILT, a folder in which Cargo has built program and library already, nothing is built: the tests put what they were
built with into a wheel.
"""

from __future__ import annotations

import base64
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import maturin
from maturin import get_requires_for_build_sdist, get_requires_for_build_wheel

__all__ = ["build_wheel", "get_requires_for_build_sdist", "get_requires_for_build_wheel", "prepare_metadata_for_build_wheel"]

_HERE = Path(__file__).resolve().parent.parent
_ROOT = _HERE.parent
_CLIENT = _ROOT / "client" / "python"
#: What maturin puts into the wheel as scripts.
_SCRIPTS = _HERE / "baudbot.data" / "scripts"


def build_wheel(directory: str, settings: Any = None, metadata: str | None = None) -> str:
    """A wheel with the program in it."""
    if built := os.environ.get("BAUDBOT_BUILT"):
        return _packed(Path(directory), Path(built))
    _program()
    name: str = maturin.build_wheel(directory, settings, None)
    _rewrite(Path(directory) / name)
    return name


def prepare_metadata_for_build_wheel(directory: str, settings: Any = None) -> str:
    """The wheel's metadata, with the dependency as `build_wheel` has it."""
    _SCRIPTS.mkdir(parents=True, exist_ok=True)
    name: str = maturin.prepare_metadata_for_build_wheel(directory, settings)
    path = Path(directory) / name / "METADATA"
    path.write_text(_in_a_clone(path.read_text(encoding="utf-8")), encoding="utf-8")
    return name


def _packed(directory: Path, built: Path) -> str:
    """A wheel of what is there."""
    with tempfile.TemporaryDirectory() as place:
        content = Path(place)
        info = content / prepare_metadata_for_build_wheel(place)
        shutil.copytree(_HERE / "package" / "baudbot", content / "baudbot", ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy2(built / "libbaudbot_python.so", content / "baudbot" / "_native.abi3.so")
        scripts = content / info.name.replace(".dist-info", ".data") / "scripts"
        scripts.mkdir(parents=True)
        shutil.copy2(built / "baudbot", scripts / "baudbot")
        subprocess.run([sys.executable, "-m", "wheel", "pack", place, "-d", directory], check=True)
    return max(directory.glob("baudbot-*.whl"), key=os.path.getmtime).name


def _program() -> None:
    command = ["cargo", "build", "--release", "--locked", "-p", "baudbot", "--features", "maps,parquet,tune"]
    subprocess.run(command, cwd=_ROOT, check=True)
    folder = Path(os.environ.get("CARGO_TARGET_DIR", _ROOT / "target"))
    _SCRIPTS.mkdir(parents=True, exist_ok=True)
    shutil.copy2(folder / "release" / "baudbot", _SCRIPTS / "baudbot")


def _in_a_clone(metadata: str) -> str:
    lines = metadata.split("\n")
    place = f"Requires-Dist: baudbot-client @ {_CLIENT.as_uri()}"
    return "\n".join(place if line.startswith("Requires-Dist: baudbot-client") else line for line in lines)


def _rewrite(wheel: Path) -> None:
    """The same wheel with its dependency as it should be. Its list of files has the hash of each."""
    fresh = wheel.with_suffix(".new")
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(fresh, "w", zipfile.ZIP_DEFLATED) as new:
        changed: dict[str, bytes] = {}
        for item in old.infolist():
            data = old.read(item)
            if item.filename.endswith(".dist-info/METADATA"):
                data = changed[item.filename] = _in_a_clone(data.decode()).encode()
            if item.filename.endswith(".dist-info/RECORD"):
                data = "\n".join(_recorded(line, changed) for line in data.decode().split("\n")).encode()
            new.writestr(item, data)
    fresh.replace(wheel)


def _recorded(line: str, changed: dict[str, bytes]) -> str:
    name = line.split(",")[0]
    if name not in changed:
        return line
    digest = base64.urlsafe_b64encode(hashlib.sha256(changed[name]).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(changed[name])}"
