#!/usr/bin/env python3
"""Runs the commands of the tutorials and how-tos as a reader does: `xtask/tools/doc_commands.py [PAGE…]`.

Each page has a folder of its own, and its `sh` blocks are run there one after the other. A `text` block behind one is what the
reader should see: its lines must be in the output, in this order; `…` stands for anything. A comment before a block says what is
special about it:

    <!-- doc: file NAME -->    the block is that file
    <!-- doc: serve -->        it runs to the page's end, or until the next block of this kind
    <!-- doc: for N s -->      it runs for so long, and is then interrupted
    <!-- doc: fails -->        it ends with an error
    <!-- doc: needs NAME -->   it is run if there is such a program, or a module `python:NAME`; else it is reported
    <!-- doc: keep FOLDER -->  what it builds in this folder is kept for the next time, in `target/pages`
    <!-- doc: skip REASON -->  it is not run

A sentence about files that commands have written has this before it, with the files, in which `*` stands for anything:

    <!-- doc: has FILE… -->    there are such files now

`<!-- doc: in a clone -->` anywhere on a page gives its folder what a clone of the repository has. The program is `BAUDBOT`, or that of
the release build.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILT = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "release" / "baudbot"
BAUDBOT = Path(os.environ.get("BAUDBOT") or BUILT).resolve()
OF_A_CLONE = ["catalogue", "client", "examples", "deploy", "python", "docs"]
WAIT_S = 600
KINDS = {"file", "serve", "for", "fails", "needs", "keep", "skip"}


@dataclass
class Block:
    """A fenced block with what the comment before it says."""

    line: int
    kind: str
    text: str
    how: str = ""
    follows: bool = False
    said: str = ""


@dataclass
class Tally:
    """What was run, and what was not."""

    run: int = 0
    shown: int = 0
    skipped: int = 0
    files: int = 0
    missing: list = field(default_factory=list)


class Failure(Exception):
    """A block that does not do what its page says."""


def blocks(text):
    """The blocks of a page, and whether it wants a clone."""
    found, how, follows, lines = [], "", False, iter(enumerate(text.splitlines(), 1))
    for number, line in lines:
        if files := re.fullmatch(r"\s*<!-- doc: has (.*) -->", line):
            found.append(Block(number, "has", files[1]))
            how, follows = "", False
        elif comment := re.fullmatch(r"\s*<!-- doc: (.*) -->", line):
            how = comment[1] if comment[1] != "in a clone" else how
        elif fence := re.match(r"( *)```(\w+)", line):
            body = []
            for _, inner in lines:
                if inner.strip() == "```":
                    break
                body.append(inner.removeprefix(fence[1]))
            found.append(Block(number, fence[2], "\n".join(body) + "\n", how, follows))
            how, follows = "", True
        elif line.strip():
            how, follows = "", False
    for block, after in zip(found, found[1:]):
        if block.kind == "sh" and after.kind == "text" and after.follows:
            block.said = after.text
    for block in found:
        if block.how and block.how.split()[0] not in KINDS:
            raise Failure(f"line {block.line}: nobody knows what `doc: {block.how}` means")
    return found, "<!-- doc: in a clone -->" in text


def check_said(block, output):
    """Each line that the page shows is in the output, in order; how many spaces stand between words does not matter."""
    at, lines = 0, [" ".join(line.split()) for line in output.splitlines()]
    for shown in filter(str.strip, block.said.splitlines()):
        pattern = re.compile(".*".join(re.escape(part) for part in " ".join(shown.split()).split("…")))
        while at < len(lines) and not pattern.fullmatch(lines[at]):
            at += 1
        if at == len(lines):
            raise Failure(f"line {block.line}: the output lacks {shown!r}; it is\n{output}")
        at += 1


class Page:
    """A page whose blocks are run in a folder."""

    def __init__(self, path, folder):
        self.path, self.folder, self.server = path, folder, None
        self.state = folder / "state"
        self.state.mkdir()
        self.work = folder / "work"
        self.work.mkdir()
        (self.state / "cwd").write_text(str(self.work))
        programs = folder / "bin"
        programs.mkdir()
        (programs / "baudbot").symlink_to(BAUDBOT)
        home = Path.home()
        first = [str(programs), str(Path(sys.executable).parent)]
        packages = ROOT / "target" / "python" / "bin"
        if packages.is_dir():
            first.insert(1, str(packages))
        self.environment = {
            "CARGO_HOME": str(home / ".cargo"),
            "RUSTUP_HOME": str(home / ".rustup"),
            # The reader has the program on the path, and no variable with where it is.
            **{name: value for name, value in os.environ.items() if name != "BAUDBOT"},
            "HOME": str(folder),
            "XDG_CONFIG_HOME": str(folder / "config"),
            "XDG_RUNTIME_DIR": str(self.state),
            "PATH": os.pathsep.join([*first, os.environ["PATH"]]),
            "PIP_CACHE_DIR": str(home / ".cache" / "pip"),
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        }

    def cwd(self):
        """Where the last block left the reader."""
        return (self.state / "cwd").read_text().strip()

    def start(self, text, output):
        """A shell in which the text runs, as if typed behind what was typed before."""
        state = self.state
        script = f"""
            [ ! -f {state}/variables ] || . {state}/variables 2>/dev/null
            cd "$(cat {state}/cwd)"
            trap 'export -p | grep -v " BASH\\| PWD=\\| OLDPWD=\\| SHLVL=" >{state}/variables; pwd >{state}/cwd' EXIT
            set -eo pipefail\n{text}"""
        return subprocess.Popen(
            ["bash", "-c", script], env=self.environment, stdin=subprocess.DEVNULL,
            stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    def run(self, block):
        """Runs a block, and returns its output."""
        limit = re.fullmatch(r"for (\d+) s", block.how)
        with open(self.state / "output", "wb") as output:
            shell = self.start(block.text, output)
            try:
                shell.wait(timeout=int(limit[1]) if limit else WAIT_S)
            except subprocess.TimeoutExpired:
                end(shell)
                if not limit:
                    raise Failure(f"line {block.line}: it did not end within {WAIT_S} s") from None
        said = (self.state / "output").read_text(errors="replace")
        wanted = block.how == "fails"
        if not limit and (shell.returncode != 0) != wanted:
            raise Failure(f"line {block.line}: it ended with {shell.returncode}:\n{block.text}\n{said}")
        return said

    def serve(self, block):
        """Starts a server, and returns what it says first."""
        self.stop()
        path = self.state / f"server-{block.line}"
        with open(path, "wb") as output:
            self.server = self.start(block.text, output)
        for _ in range(300):
            said = path.read_text(errors="replace")
            if "Ctrl-C stops" in said:
                return said
            if self.server.poll() is not None:
                break
            time.sleep(0.1)
        raise Failure(f"line {block.line}: the server does not start:\n{path.read_text(errors='replace')}")

    def stop(self):
        """Ends the server."""
        if self.server is not None:
            end(self.server)
            self.server = None

    def keep(self, name):
        """Puts a folder where the next run of the page finds it."""
        kept = ROOT / "target" / "pages" / self.path.stem / Path(name).name
        kept.mkdir(parents=True, exist_ok=True)
        (Path(self.cwd()) / name).symlink_to(kept)

    def has(self, name):
        """Whether there is such a program, or a module of Python."""
        if name.startswith("python:"):
            test = ["python3", "-c", f"import {name.removeprefix('python:')}"]
            return subprocess.run(test, env=self.environment, capture_output=True, cwd="/", check=False).returncode == 0
        return shutil.which(name, path=self.environment["PATH"]) is not None


def end(shell):
    """Interrupts a shell with all that it started, as Ctrl-C does."""
    for number in (signal.SIGINT, signal.SIGKILL):
        try:
            os.killpg(shell.pid, number)
            shell.wait(timeout=10)
            return
        except subprocess.TimeoutExpired:
            continue
        except ProcessLookupError:
            shell.wait()
            return


def do(page, block, tally):
    """What a reader does with a block."""
    word, _, rest = block.how.partition(" ")
    if block.kind == "has":
        for pattern in block.text.split():
            if not any(Path(page.cwd()).glob(pattern)):
                there = sorted(str(path.relative_to(page.cwd())) for path in Path(page.cwd()).rglob("*") if path.is_file())
                raise Failure(f"line {block.line}: there is no {pattern}; there are {', '.join(there)}")
        tally.files += 1
    elif word == "file":
        path = Path(page.cwd()) / rest
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text)
    elif block.kind != "sh":
        return
    elif word == "skip":
        if not rest:
            raise Failure(f"line {block.line}: say why it is skipped")
        tally.skipped += 1
    elif word == "needs" and not all(page.has(name) for name in rest.split()):
        tally.missing.append(f"{page.path}:{block.line}: needs {rest}")
    else:
        if word == "keep":
            page.keep(rest)
        said = page.serve(block) if word == "serve" else page.run(block)
        check_said(block, said)
        tally.run += 1
        tally.shown += bool(block.said)


def try_page(path, tally):
    """Runs the blocks of a page. The word of its failure, or none."""
    with tempfile.TemporaryDirectory(prefix="doc-") as folder:
        page = Page(path.relative_to(ROOT), Path(folder))
        try:
            found, in_a_clone = blocks(path.read_text())
            for name in OF_A_CLONE if in_a_clone else []:
                (page.work / name).symlink_to(ROOT / name)
            for block in found:
                do(page, block, tally)
        except Failure as failure:
            return f"{page.path}: {failure}"
        finally:
            page.stop()
    return None


def main():
    if not BAUDBOT.is_file():
        sys.exit(f"{BAUDBOT} is not there: cargo build --release")
    asked = [Path(name).resolve() for name in sys.argv[1:]]
    pages = asked or sorted([ROOT / "README.md", *ROOT.glob("docs/tutorials/*.md"), *ROOT.glob("docs/how-to/*.md")])
    tally, failures = Tally(), []
    for path in pages:
        started = time.monotonic()
        failure = try_page(path, tally)
        print(f"{time.monotonic() - started:6.1f} s  {path.relative_to(ROOT)}{'  FAILED' if failure else ''}", flush=True)
        failures += [failure] if failure else []
    print(f"{tally.run} blocks run, {tally.shown} with their output; {tally.skipped} skipped, as their pages say why; {tally.files} sentences about files")
    print("\n".join(f"!!! NOT CHECKED: {missing}" for missing in tally.missing))
    if failures:
        sys.exit("\n\n".join(failures))
    if not asked and tally.run < 40:
        sys.exit(f"only {tally.run} blocks were run")


if __name__ == "__main__":
    main()
