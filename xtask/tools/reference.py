#!/usr/bin/env python3
"""Makes the pages of the reference that are generated: `xtask/tools/reference.py [--check]`.

docs/reference/cli.md is the help of the program that `BAUDBOT` names, docs/reference/preset-list.md its presets, docs/reference/contract.md
the services of the contract. The tables of fields in the pages about scenarios are those of the program's schema (reference_tables.py).
docs/explanation/equations.md is of marks in the code (notes.py, which needs no program).
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import notes
import reference_tables

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs" / "reference"
BUILT = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target") / "release" / "baudbot"
BAUDBOT = Path(os.environ.get("BAUDBOT") or BUILT).resolve()
COMMANDS = """# Commands

The program's own help, as `baudbot help COMMAND` prints it. `xtask/tools/reference.py` makes this page, and `./test manual-commands` compares it. `baudbot man
FOLDER` writes the same as pages for `man`.

"""
CONTRACT = """# The contract

Brains, operators, observers and trainers speak gRPC with a server: the package `baudbot.v1`. `xtask/tools/reference.py` makes this page of the
comments in `proto/baudbot/v1`; the messages and their fields are described there. The contract only grows within a major version.

A brain opens one stream, `Attach`. It sends a `Hello` that names its world and its robots, and gets a `Welcome` with their data sheets. Then
each `Turn` of the server takes a `Step` of the brain ([timing](../explanation/timing.md#turn-and-step)). [A brain in any
language](../how-to/any-language.md) has a whole exchange, and an example in each of eight languages. Which token a call needs is in
[trust](trust.md#what-a-right-allows).

"""
PRESETS = """# All presets

[Presets](presets.md) says how they are used. `xtask/tools/reference.py` makes this page of `baudbot preset`, which shows each with the sources of its
numbers.

"""
# By the kinds that the program tells: a title, and where such a preset may be used.
KINDS = {
    "robot": ("Robots", "For `[[robots]]`."),
    "sensor": ("Sensors", "For `[robots.sensors.NAME]`."),
    "motors": ("Motors", "For `[robots.motors]`."),
    "actuator": ("Actuators", "For `[robots.actuators.NAME]`."),
    "microcontroller": ("Microcontrollers", "For `[robots.microcontroller]`."),
    "link": ("Links", "For `[robots.link]`, and the `port.link` of a sensor."),
    "adapter": ("Adapters", "For `[robots.link.adapter]`, and the `port.link.adapter` of a sensor; only in a link of kind `uart`."),
    "battery": ("Batteries", "For `[robots.battery]`."),
}
# The most words in a cell of the table of calls.
LONGEST_CELL = 60
# Their tables are generated, and what is around them is written.
SCENARIOS = ("scenario.md", "actuators.md", "sensors.md")
# What all commands have, once.
COMMON = re.compile(r"^Log:\n.*?(?=^\S|\Z)", re.M | re.S)


def said(*arguments):
    """What the program says, as it does on every machine. The one that the tests were built with wraps its help for the terminal."""
    done = subprocess.run([BAUDBOT, *arguments], env={"PATH": "", "COLUMNS": "100000"}, capture_output=True, text=True, check=True)
    return done.stdout.rstrip()


def help_of(*command):
    """What the program says of itself or of a command."""
    return said("help", *command)


def commands(text):
    """The commands and what they do, from the list in the help, which may be in groups and has lines that go on below."""
    listed = text.split("Usage:", 1)[1].split("\n\n", 1)[1].split("\nOptions:\n", 1)[0]
    known = []
    for line in listed.splitlines():
        if command := re.match(r"  (\w+) +(.*)", line):
            known.append(command.groups())
        elif known and line.startswith(" " * 8):
            known[-1] = (known[-1][0], f"{known[-1][1]} {line.strip()}")
    return known


def section(name):
    """A command, with those below it."""
    text = help_of(*name)
    yield f"## `baudbot {' '.join(name)}`\n\n```text\n{re.sub(r' +$', '', COMMON.sub('', text), flags=re.M)}\n```\n"
    if "\nCommands:\n" in text:
        for below, _ in commands(text):
            if below != "help":
                yield from section((*name, below))


def cli():
    """The page of commands."""
    whole = help_of()
    known = [(name, what) for name, what in commands(whole) if name != "help"]
    rows = [f"| [`{name}`](#baudbot-{name}) | {what} |\n" for name, what in known]
    options = "## Options of all commands\n\n```text\n" + re.sub(r" +$", "", whole.split("Options:\n")[1], flags=re.M) + "\n```\n"
    sections = [part for name, _ in known for part in section((name,))]
    return COMMANDS + "| command | what it does |\n|---|---|\n" + "".join(rows) + "\n" + "\n".join([*sections, options])


def presets():
    """The page of presets."""
    text, known = PRESETS, json.loads(said("preset", "--json"))
    for kind, (title, place) in KINDS.items():
        text += f"## {title}\n\n{place}\n\n| preset | what it is | how well it is known |\n|---|---|---|\n"
        for preset in (preset for preset in known if preset["kind"] == kind):
            first = said("preset", preset["name"]).split("\n", 1)[0]
            text += f"| `{preset['name']}` | {preset['description']} | {first.removeprefix('# Known: ').removesuffix('.')} |\n"
        text += "\n"
    return text.rstrip() + "\n"


def contract():
    """The page of services."""
    text = CONTRACT
    for file in sorted((ROOT / "proto/baudbot/v1").glob("*.proto")):
        for service in re.finditer(r"((?:^//[^\n]*\n)*)^service (\w+) \{\n(.*?)^\}", file.read_text(), re.M | re.S):
            about = "\n\n".join(paragraphs(service[1]))
            text += f"## {service[2]}\n\n{about} File: [{file.name}](../../proto/baudbot/v1/{file.name}).\n\n"
            text += "| call | what it does | errors |\n|---|---|---|\n"
            more = ""
            for call in re.finditer(r"((?:^ +//.*\n)*)^ +rpc (\w+)\((stream )?\w+\) returns \((stream )?", service[3], re.M):
                streams = " (a stream)" if call[3] or call[4] else ""
                first, *others = paragraphs(call[1])
                what, errors = re.match(r"(.*?)((?: [A-Z_]{5,}: .*)?)$", first).groups()
                for cell in (what, errors):
                    if len(cell.split()) > LONGEST_CELL:
                        sys.exit(f"{file.name}: the first paragraph of {call[2]} is too long for a table: begin another one")
                listed_below = f"[below](#{call[2].lower()})" if any(other.startswith("Errors: ") for other in others) else ""
                text += f"| `{call[2]}`{streams} | {what} | {errors.strip() or listed_below} |\n"
                if others:
                    more += f"### {call[2]}\n\n" + "\n\n".join(map(listed, others)) + "\n\n"
            text += "\n" + more
    return text.rstrip() + "\n"


def listed(paragraph):
    """A paragraph; errors in a list, with the occasions of each in brackets."""
    if not paragraph.startswith("Errors: "):
        return paragraph
    errors = re.findall(r"([A-Z_]{5,}) \((.*?)\)(?=, [A-Z_]{5,} \(|\.$)", paragraph)
    if len(errors) != len(re.findall(r"[A-Z_]{5,} \(", paragraph)):
        sys.exit(f"errors are written as CODE (occasion), CODE (occasion).: {paragraph}")
    return "Errors:\n\n" + "\n".join(f"- {code}: {occasion}" for code, occasion in errors)


def scenarios():
    """The pages about scenarios, with their tables."""
    schema, known = json.loads(said("schema")), []
    pages = [(name, reference_tables.filled((PAGES / name).read_text(), schema, known)) for name in SCENARIOS]
    if missing := reference_tables.missing(schema, known):
        sys.exit(f"these tables of fields must be in one page each: {', '.join(missing)}")
    return pages


def paragraphs(comment):
    """The paragraphs of a comment, each on one line."""
    lines = [line.strip().removeprefix("//").strip() for line in comment.splitlines()]
    parts = re.split(r"\n\n+", "\n".join(lines))
    return [" ".join(part.split()).replace("|", "\\|") for part in parts if part.strip()]


def main():
    if not BAUDBOT.is_file():
        sys.exit(f"{BAUDBOT} is not there: cargo build --release")
    for name, text in [("cli.md", cli()), ("preset-list.md", presets()), ("contract.md", contract()), *scenarios()]:
        page = PAGES / name
        if sys.argv[1:] != ["--check"]:
            page.write_text(text)
        elif not page.is_file() or page.read_text() != text:
            sys.exit(f"docs/reference/{name} is not up to date: xtask/tools/reference.py makes it")
        else:
            print(f"docs/reference/{name}: up to date, {len(text)} characters")
    notes.main()


if __name__ == "__main__":
    main()
