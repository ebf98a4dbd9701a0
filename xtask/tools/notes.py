#!/usr/bin/env python3
"""Makes docs/explanation/equations.md of the list of the notes and of the marks in the code: `xtask/tools/notes.py [--check]`.

The list is docs/explanation/notes.toml, whose head says what an item has. A mark is in a comment on lines of its own:

    (3.13), (1.8)–(1.10), (6.4) to (6.7), Eq. 3.13  equations; nothing else that is a number of this form is alone in parentheses
    Fig. 6.12, Figs. 6.8 and 6.10                   figures
    listing 5.1, listings 5.1 and 5.2               listings
    §7.2.1, Section 7.2.1, Sections 5.2 and 8.1     sections; one with topics counts for those whose word is in the same paragraph

Each mark must be in the list. Where it stands decides what else it says:

- In tests: the test whose comment or body it is in shows the item; at a head or a helper, the file does.
- In scenarios, exercises (also as their `section`), presets and described brains: they show it.
- Elsewhere: the item is computed in the function or type whose comment it is in, or else in the file whose head has it in the
  first paragraph or behind an equation. Tables, fields and bodies only mention it.
"""

import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = "docs/explanation/notes.toml"
PAGE = "docs/explanation/equations.md"
# The last numbers in the notes: of each chapter's equations, figures and listings, and of the sections below each. No exercise there has a number.
LAST = {
    "(": {"1": 10, "2": 34, "3": 22, "4": 1, "5": 1, "6": 8, "7": 15, "8": 6},
    "Fig. ": {"1": 19, "2": 3, "3": 6, "4": 3, "5": 1, "6": 18, "7": 4, "8": 3},
    "Listing ": {"5": 4},
    "§": {"1": 2, "1.2": 4, "2": 2, "2.1": 1, "3": 3, "3.2": 7, "4": 4, "4.4": 4, "5": 4, "5.3": 2, "6": 3, "6.2": 2, "6.3": 1, "7": 2, "7.2": 2, "8": 2, "8.1": 1, "8.2": 3},
}
SOURCES = ["*.rs", "*.py", "catalogue/*.toml", "brains/repertoires/*.toml", "crates/scenario/presets/*.toml"]
FIELDS = {"what", "deviation", "reason", "planned"}

EQUATION = re.compile(r"(?<![\w\])])\(([1-8]\.[1-9]\d?)\)(?:(?: ?– ?| to )\(([1-8]\.[1-9]\d?)\))?")
ONE = r"[1-8]\.[1-9]\d?(?:\.[1-9])?(?![\d.]*\d)"
JOINT = r"(?:, and |, | and | or | ?– ?| to )"
WORD = r"\b([Ee]q|[Ff]ig|[Ll]ist|[Ss]ect)"
WORDED = re.compile(rf"{WORD}(?:\.|uation|ure|ing|ion) ?({ONE})|{WORD}(?:s\.|uations|ures|ings|ions) ({ONE}(?:{JOINT}{ONE})*)|(§) ?({ONE})")
KINDS = {"eq": "({})", "fig": "Fig. {}", "list": "Listing {}", "sect": "§{}", "§": "§{}"}

COMMENT = re.compile(r"^\s*(//[/!]?|#(?!\[|!\[))(.*)")
IS_TEST = re.compile(r"(^|/)tests/|(^|_|/)tests?\.rs$|(^|/)test_\w+\.py$")
ITEM = re.compile(r"^\s*(?:pub(?:\([^)]*\))? )?(?:const |async )*(?:fn|struct|enum|trait|type|const|static) (\w+)")
OWNER = re.compile(r"^(?:impl(?:<.*?>)? (?:.* for )?(?:\w+::)*(\w+)|(?:pub(?:\([^)]*\))? )?trait (\w+))")


@dataclass(frozen=True)
class Mark:
    """A mark: its item, its paragraph, and what it says of which place."""

    item: str
    words: str
    path: str
    # `code`, `test`, `shown`, or `mention`.
    says: str
    # Of a function or type; empty of the file.
    name: str = ""


def ids(text):
    """The items that a text names, with ranges filled in."""
    for first, last in EQUATION.findall(text):
        yield from (f"({number})" for number in between(first, last or first))
    for match in WORDED.finditer(text):
        word, numbers = (part for part in match.groups() if part)
        pieces = re.split(rf"({JOINT})", numbers)
        yield KINDS[word.lower()].format(pieces[0])
        for before, joint, number in zip(pieces[::2], pieces[1::2], pieces[2::2]):
            series = between(before, number)[1:] if joint.strip() in ("–", "to") else [number]
            yield from (KINDS[word.lower()].format(number) for number in series)


def between(first, last):
    """The numbers of a range, which is within a chapter."""
    (chapter, begin), (other, end) = first.rsplit(".", 1), last.rsplit(".", 1)
    if chapter != other or int(begin) > int(end):
        sys.exit(f"{first} to {last}: no range of the notes")
    return [f"{chapter}.{number}" for number in range(int(begin), int(end) + 1)]


def marks(path, text):
    """The marks of a file."""
    if path.endswith(".toml"):
        text = re.sub(r'^section = "([\d.]+)"$', r"§\1", text, flags=re.M)
        pieces = (re.sub(r"\n#? ?", " ", piece) for piece in re.split(r"\n#?\n", text))
        return [Mark(item, piece, path, "shown") for piece in pieces for item in ids(piece)]
    return rust(path, text) if path.endswith(".rs") else python(path, text)


def python(path, text):
    """The marks in comments and docstrings; they are of the file."""
    says = "shown" if path.startswith("catalogue/") else "test" if IS_TEST.search(path) else "code"
    pieces = re.findall(r'"""(.*?)"""|^\s*(#.*)$', text, re.M | re.S)
    return [Mark(item, "".join(piece), path, says) for piece in pieces for item in ids(" ".join("".join(piece).split()))]


def rust(path, text):
    """The marks in comments on lines of their own."""
    lines, found = text.split("\n"), []
    is_test, owner, test, at = bool(IS_TEST.search(path)), "", "", 0
    while at < len(lines):
        begin = at
        while at < len(lines) and (comment := COMMENT.match(lines[at])) and comment[1] == COMMENT.match(lines[begin])[1]:
            at += 1
        block = [COMMENT.match(line) for line in lines[begin:at]]
        item, attributes = below(lines, at)
        if block:
            for paragraph, is_place in paragraphs(block, item):
                says, name = "mention", ""
                if is_test:
                    says, name = "test", (item if "#[test]" in attributes else test)
                elif is_place:
                    says, name = "code", (f"{owner}::{item}" if owner and item and lines[begin][0] == " " else item)
                found += [Mark(i, paragraph, path, says, name) for i in ids(paragraph)]
            continue
        is_test |= lines[at] == "#[cfg(test)]" and at + 1 < len(lines) and lines[at + 1].endswith("{")
        if lines[at].startswith("}"):
            owner = ""
        elif opened := OWNER.match(lines[at]):
            owner = opened[1] or opened[2]
        if (name := ITEM.match(lines[at])) and " fn " in f" {lines[at]}":
            test = name[1] if any("#[test]" in line for line in lines[max(0, at - 4) : at]) else ""
        at += 1
    return found


def below(lines, at):
    """The item that begins at a line, behind its attributes; and these."""
    begin = at
    while at < len(lines) and (lines[at].lstrip().startswith("#[") or (at > begin and not lines[at - 1].rstrip().endswith("]"))):
        at += 1
    item = ITEM.match(lines[at]) if at < len(lines) else None
    return (item[1] if item else ""), "\n".join(lines[begin:at])


def paragraphs(block, item):
    """The paragraphs of a comment, each on one line, and whether a mark in it is the place of what it names."""
    is_head = block[0][1] == "//!"
    texts, texts_of_equations = [[]], []
    for line in (comment[2].strip() for comment in block):
        if not line:
            texts.append([])
        elif line.startswith("|"):
            yield line, False
        elif is_head and re.search(r"\S {2,}\([1-8]\.[\d.(), –]*\)$", line):
            texts_of_equations.append(line)
        else:
            texts[-1].append(line)
    yield from ((" ".join(text), (is_head and text is texts[0]) or (not is_head and bool(item))) for text in texts)
    yield from ((line, True) for line in texts_of_equations)


class Notes:
    """The list, with the marks of each item."""

    def __init__(self, text, found):
        self.chapters = tomllib.loads(text)
        self.entries = {key: entry for chapter in self.chapters.values() for key, entry in chapter["items"].items()}
        self.marks = {key: [] for key in self.entries}
        of, topics = {}, {}
        for key in self.entries:
            number, _, topic = key.partition(" ") if key.startswith("§") else (key, "", "")
            if topic:
                topics.setdefault(number, {})[topic.lower()] = key
            of |= {} if topic else {item: key for item in ids(key)}
        self.amiss = list(self.misnumbered())
        for mark in found:
            if mark.item not in of:
                self.amiss.append(f"{mark.path}: {mark.item} is not in {LIST}; a number that is none of the notes is not alone in parentheses")
                continue
            named = [key for topic, key in topics.get(mark.item, {}).items() if topic in mark.words.lower()]
            for key in named or [of[mark.item]]:
                self.marks[key].append(mark)
        for key, entry in self.entries.items():
            self.amiss += [f"{LIST}: {key}: {error}" for error in self.errors(key, entry)]

    def misnumbered(self):
        """The gaps of the list, and what it has twice or too much."""
        listed = [item for key in self.entries if not (key.startswith("§") and " " in key) for item in ids(key)]
        wanted = {
            f"{kind}{chapter}.{number}{')' * (kind == '(')}"
            for kind, chapters in LAST.items()
            for chapter, last in chapters.items()
            for number in range(1, last + 1)
        }
        yield from (f"{LIST}: {item} of the notes is missing" for item in sorted(wanted - set(listed)))
        yield from (f"{LIST}: {item} is not in the notes" for item in sorted(set(listed) - wanted))
        yield from (f"{LIST}: {item} is there twice" for item in sorted(set(listed)) if listed.count(item) > 1)

    def errors(self, key, entry):
        """What is wrong with an item."""
        of = {item: {mark.says for mark in self.marks[key] if mark.item == item} - {"mention"} for item in ids(key)}
        says = set.union(*of.values())
        if unknown := set(entry) - FIELDS or not entry.get("what"):
            yield f"needs `what`, and may have {', '.join(sorted(FIELDS - {'what'}))}" + (f", but not {unknown}" if unknown is not True else "")
        if entry.get("planned") and "code" in says:
            yield f"is in {self.places(key, 'code')[0][1]}: take `planned` away"
        elif not entry.get("reason") and not entry.get("planned"):
            lacking = [item for item, said in of.items() if not said or (item[0] == "(" and "code" not in said)]
            yield from (f"{item} has no mark in code and no `reason`" for item in lacking)
            yield from (f"{item} has marks in code and in no test" for item, said in of.items() if "code" in said and "test" not in said)

    def places(self, key, says):
        """The places of an item's marks: names and paths. A file is left out where functions in it are named."""
        there = {(mark.name, mark.path): None for mark in self.marks[key] if mark.says == says}
        precise = {path for name, path in there if name}
        return sorted((place for place in there if place[0] or place[1] not in precise), key=lambda place: place[1])

    def page(self):
        """The page."""
        planned = sum(bool(entry.get("planned")) for entry in self.entries.values())
        text = HEAD.format(count=len(self.entries), planned=planned)
        for number, chapter in self.chapters.items():
            there = [key for key in chapter["items"] if any(mark.says != "mention" for mark in self.marks[key])]
            text += f"\n## {number}. {chapter['title']}\n\n| in the notes | computed in | tested by | shown by | as there? |\n|---|---|---|---|---|\n"
            text += "".join(self.row(key) for key in there)
            rest = [(key, entry) for key, entry in chapter["items"].items() if key not in there]
            absent = [f"{name(key)} {entry['what']}. {entry.get('deviation', '')}".strip() for key, entry in rest if entry.get("planned")]
            text += listed("Not here yet", absent)
            text += listed("Nothing to compute", [f"{name(key)} {entry['what']}. {entry['reason']}" for key, entry in rest if not entry.get("planned")])
            text += listed("Not in the notes", chapter.get("ours", []))
        return text

    def row(self, key):
        """An item as a row of its chapter's table."""
        entry = self.entries[key]
        cells = [", ".join(f"[{label(name, path)}](../../{path})" for name, path in self.places(key, says)) for says in ("code", "test", "shown")]
        told = [entry.get("planned") and "**Not here yet.**", entry.get("deviation"), entry.get("reason")]
        return f"| {name(key)} {entry['what']} | {' | '.join([*cells, ' '.join(filter(None, told)) or 'As there.'])} |\n"


def name(key):
    """The number of an item; a topic has that of its section."""
    return f"**{key.partition(' ')[0] if key.startswith('§') else key}**"


def listed(title, entries):
    """A list with a title, if there is something in it."""
    return f"\n{title}:\n\n" + "".join(f"- {entry}\n" for entry in entries) if entries else ""


def label(name, path):
    """The words of a link to a place."""
    if name:
        return f"`{name}`"
    if path.endswith(".rs"):
        return re.sub(r"^crates/|src/|/mod(?=\.rs)|\.rs$", "", path)
    kinds = {"catalogue/scenarios/": "", "catalogue/exercises/": "exercise ", "catalogue/experiments/": "experiment ", "brains/repertoires/": "brain ", "crates/scenario/presets/": "preset "}
    return next((f"{kind}`{Path(path.removeprefix(folder)).with_suffix('')}`" for folder, kind in kinds.items() if path.startswith(folder)), path)


HEAD = """# Equations

What M. Wahde's lecture notes *Introduction to Autonomous Robots* (2016) describe, in their order: every equation, figure, listing and section; where it is computed,
which tests hold it, which scenarios and exercises show it, and where we deviate. `xtask/tools/notes.py` makes this page of marks in the code and of
[the list of the notes](notes.toml). Of its {count} entries {planned} are *not here yet*.

`in_process_to_1e_12` is four trajectories of the original [ARSim](arsim.md), to 10⁻¹²; `through_grpc_in_lockstep_to_1e_9` beside it is the same through a server.
"""


def read():
    """The notes with the marks of the files that Git knows."""
    tracked = subprocess.run(["git", "ls-files", "-z", *SOURCES], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    paths = [path for path in tracked.split("\0") if path and (ROOT / path).is_file() and not path.startswith(("xtask/", "proto/src/generated/"))]
    found = [mark for path in paths for mark in marks(path, (ROOT / path).read_text())]
    return Notes((ROOT / LIST).read_text(), found)


def made():
    """The page, if nothing is amiss."""
    notes = read()
    if notes.amiss:
        sys.exit("\n".join(notes.amiss))
    return notes.page()


def main():
    page, text = ROOT / PAGE, made()
    if sys.argv[1:] != ["--check"]:
        page.write_text(text)
    elif not page.is_file() or page.read_text() != text:
        sys.exit(f"{PAGE} is not up to date: xtask/tools/notes.py makes it")
    print(f"{PAGE}: {re.search(r'Of its .*', text)[0]}")


if __name__ == "__main__":
    main()
