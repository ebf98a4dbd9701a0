#!/usr/bin/env python3
"""Makes the pictures of docs/gallery.md anew: `cargo build --release && tools/gallery.py [NAME…]`.

A picture is made by the commands in backticks of the paragraph before it, as that page says: a run that is not exported
is exported with `--svg`. Names are those of pictures, without `gallery-`; without any all are made. Runs are the same to
the last bit on every machine, so `git diff --stat docs/pictures` shows what has become another since.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
PICTURE = re.compile(r"!\[[^]]*\]\(pictures/gallery-([a-z0-9-]+)\.svg\)")


def recipes():
    """Of each picture the commands that make it."""
    paragraphs = re.split(r"\n\n+", (ROOT / "docs" / "gallery.md").read_text())
    for before, paragraph in zip(paragraphs, paragraphs[1:]):
        if picture := PICTURE.fullmatch(paragraph.strip()):
            commands = re.findall(r"`((?:run|export|plan|locate|check) [^`]*)`", before)
            if not commands:
                sys.exit(f"docs/gallery.md: the paragraph before gallery-{picture[1]}.svg has no command")
            yield picture[1], [shlex.split(command) for command in commands]


def make(name, commands, folder):
    """Runs the commands in a folder of its own, and keeps the picture."""
    if commands[-1][0] == "run":
        commands = [[*commands[-1], "--record", "run.mcap"], ["export", "run.mcap", "--svg", "way.svg"]]
    for command in commands:
        called = [str(ROOT / "target/release/baudbot"), *command]
        done = subprocess.run(called, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{name}: baudbot {shlex.join(command)}\n{done.stderr}")
    made = list(Path(folder).glob("*.svg"))
    if len(made) != 1:
        sys.exit(f"{name}: its commands write {len(made)} pictures instead of one")
    target = PICTURES / f"gallery-{name}.svg"
    old = target.read_text() if target.exists() else None
    new = made[0].read_text()
    target.write_text(new)
    print(f"{name}: {'new' if old is None else 'the same' if old == new else 'CHANGED'}", flush=True)


def main(names):
    known = dict(recipes())
    for name in names or known:
        if name not in known:
            sys.exit(f"no picture of docs/gallery.md is called {name}; there are: {', '.join(known)}")
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(ROOT / "scenarios", Path(folder) / "scenarios")
            make(name, known[name], folder)


if __name__ == "__main__":
    main(sys.argv[1:])
