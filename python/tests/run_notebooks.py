#!/usr/bin/env python3
"""Runs the notebooks, each from its first cell to its last: `python run_notebooks.py [NAME…]`."""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"


def main() -> None:
    names = sys.argv[1:] or sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb"))
    for name in names:
        started = time.monotonic()
        notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
        nbformat.validate(notebook)
        stale = [cell.id for cell in notebook.cells if cell.cell_type == "code" and cell.outputs]
        if stale:
            sys.exit(f"{name}: cells {', '.join(stale)} have outputs; notebooks are kept without")
        with tempfile.TemporaryDirectory() as folder:
            NotebookClient(notebook, timeout=600, resources={"metadata": {"path": folder}}).execute()
        pictures = sum("image/svg+xml" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", []))
        print(f"{name}: {len(notebook.cells)} cells, {pictures} pictures, {time.monotonic() - started:.1f} s")
        if pictures == 0:
            sys.exit(f"{name}: shows no picture")


if __name__ == "__main__":
    main()
