#!/usr/bin/env python3
"""Makes the pictures of docs/gallery.md anew: `cargo build --release && xtask/tools/gallery.py [--check] [NAME…]`.

A picture is made by the commands in backticks of the paragraph before it, as that page says: a run that is not exported
is exported with `--svg`. Names are those of pictures, such as gallery-tour; without any all are made. Runs are the same to
the last bit on every machine, so a picture that has changed is a brain, a world or a drawing that has. With `--check`
nothing is written, and it fails if one has.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "pictures"
BUILT = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "release" / "baudbot"
BAUDBOT = Path(os.environ.get("BAUDBOT") or BUILT).resolve()
PICTURE = re.compile(r"!\[[^]]*\]\(pictures/([a-z0-9-]+)\.svg\)")


def recipes():
    """Of each picture the commands that make it."""
    paragraphs = re.split(r"\n\n+", (ROOT / "docs" / "gallery.md").read_text())
    for before, paragraph in zip(paragraphs, paragraphs[1:]):
        if picture := PICTURE.fullmatch(paragraph.strip()):
            commands = re.findall(r"`((?:run|export|plan|locate|check|diagram) [^`]*)`", before)
            if not commands:
                sys.exit(f"docs/gallery.md: the paragraph before {picture[1]}.svg has no command")
            yield picture[1], [shlex.split(command) for command in commands]


def make(name, commands, folder):
    """The picture that the commands make, in a folder of its own."""
    if commands[-1][0] == "run":
        commands = [[*commands[-1], "--record", "run.mcap"], ["export", "run.mcap", "--svg", "way.svg"]]
    for command in commands:
        called = [BAUDBOT, *command]
        done = subprocess.run(called, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{name}: baudbot {shlex.join(command)}\n{done.stderr}")
    made = list(Path(folder).glob("*.svg"))
    if len(made) != 1:
        sys.exit(f"{name}: its commands write {len(made)} pictures instead of one")
    return made[0].read_text()


def main():
    parser = argparse.ArgumentParser(description="Makes the pictures of docs/gallery.md anew.")
    parser.add_argument("--check", action="store_true", help="write nothing, and fail if a picture has changed")
    parser.add_argument("names", nargs="*", metavar="NAME", help="a picture, such as gallery-tour [default: all]")
    asked, known, changed = parser.parse_args(), dict(recipes()), []
    if not BAUDBOT.is_file():
        sys.exit(f"{BAUDBOT} is not there: cargo build --release")
    for name in asked.names or known:
        if name not in known:
            sys.exit(f"no picture of docs/gallery.md is called {name}; there are: {', '.join(known)}")
        with tempfile.TemporaryDirectory() as folder:
            os.symlink(ROOT / "catalogue", Path(folder) / "catalogue")
            new = make(name, known[name], folder)
        picture = PICTURES / f"{name}.svg"
        is_same = picture.exists() and picture.read_text() == new
        changed += [] if is_same else [name]
        if not asked.check:
            picture.write_text(new)
        print(f"{name}: {'the same' if is_same else 'CHANGED'}", flush=True)
    if asked.check and changed:
        sys.exit(f"no longer what the program makes: {', '.join(changed)}; xtask/tools/gallery.py makes them anew")


if __name__ == "__main__":
    main()
