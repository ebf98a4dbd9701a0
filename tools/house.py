#!/usr/bin/env python3
"""Measures the structure of the Rust code: its size, its longest functions, and modules that reach each other in a circle.

    python3 tools/house.py [--rev COMMIT] [--json | --check]

With --check it names what the house rules of CONTRIBUTING.md forbid, and exits with 1 if there is anything of the kind.
`house.toml` beside it has the exceptions, with the reason for each.

A module is a file or folder right below a crate's `src`; it reaches another if its path stands in its code, tests left out.
Lines of code are those that have more than a comment; the length of a file counts all lines but those of tests. What only tests use (`#[cfg(test)]`, `tests.rs`, `tests/`) is counted apart;
generated code is not counted.
"""

import argparse
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import tomllib
from collections import defaultdict
from pathlib import Path, PurePosixPath

LONGEST_FUNCTION = 40
LONGEST_FILE = 400
EXCEPTIONS = Path(__file__).with_name("house.toml")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rev", help="a commit; otherwise what lies in the working tree")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="for programs")
    form.add_argument("--check", action="store_true", help="say only what is amiss; exit with 1 if anything is")
    args = parser.parse_args()
    crates = measured(sources(args.rev))
    if args.check:
        found = amiss(crates, tomllib.loads(EXCEPTIONS.read_text(encoding="utf-8")))
        print("\n".join(found) or "no circle of modules, nothing too long, no error that is a text, none whose text is read; exceptions: tools/house.toml")
        sys.exit(1 if found else 0)
    if args.json:
        json.dump(crates, sys.stdout, indent=1)
        print()
    else:
        show(crates)


def amiss(crates, exceptions):
    """What the house rules forbid and no exception lets pass, and exceptions that nothing needs any more."""
    wrong, needed = [], []
    for crate, found in crates.items():
        for knot in found.get("knots", []):
            passes = [one for one in exceptions.get("knots", []) if one["crate"] == crate and set(knot) <= set(one["modules"])]
            needed += passes
            if not passes:
                wrong.append(f"{crate}: these modules reach each other in a circle: {' '.join(knot)}; move what they share into one below them")
        for key, rule in RULES.items():
            for place in found.get(key, []):
                passes = [one for one in exceptions.get(key, []) if one["place"] == f"{crate}/src/{place}"]
                needed += passes
                if not passes:
                    wrong.append(f"{crate}/src/{place}: {rule(found[key][place])}")
    for key, all_of_them in exceptions.items():
        for one in all_of_them:
            if one not in needed:
                wrong.append(f"tools/house.toml: [[{key}]] {one.get('place') or one['crate']}: nothing needs this exception any more; remove it")
    return wrong


RULES = {
    "long_functions": lambda lines: f"the function has {lines} lines, more than {LONGEST_FUNCTION}; split it by what its parts mean",
    "long_files": lambda lines: f"the file has {lines} lines without its tests, more than {LONGEST_FILE}; move its second idea into another",
    "string_errors": lambda _: "a public function's error is a String; give it an error type",
    "read_errors": lambda _: "the words of an error are for people; give the error a kind, and match on that",
}


def sources(rev):
    """Rust files by path, as git has them."""
    if rev is None:
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "*.rs"], check=True, capture_output=True, text=True)
        there = filter(os.path.exists, listed.stdout.split())  # without those that were just deleted
        return {path: open(path, encoding="utf-8").read() for path in there}
    archive = subprocess.run(["git", "archive", rev], check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
        return {file.name: tar.extractfile(file).read().decode() for file in tar if file.name.endswith(".rs")}


def measured(files):
    """What there is to tell of each crate."""
    by_crate = defaultdict(dict)
    files = {path: text for path, text in files.items() if "/generated/" not in path}
    for path, text in files.items():
        if "/src/" in path:
            crate, inside = path.split("/src/", 1)
            by_crate[crate][inside] = text
    tests = {path: text for path, text in files.items() if "/src/" not in path}
    crates = {crate: of_crate(inside) for crate, inside in sorted(by_crate.items())}
    of_tests = [code_lines(bare(text)) for text in tests.values()]
    crates["tests and benches beside the crates"] = {"files": len(of_tests), "code": 0, "tests": sum(of_tests)}
    return crates


def of_crate(files):
    found = {"files": len(files), "code": 0, "tests": 0, "wildcards": 0, "string_errors": {}, "read_errors": {}, "long_functions": {}, "long_files": {}}
    reached = defaultdict(set)
    for path, text in sorted(files.items()):
        code = bare(text)
        if is_test(path):
            found["tests"] += code_lines(code)
            continue
        kept, tests = apart(code)
        lines = code_lines(kept)
        found["code"] += lines
        found["tests"] += code_lines(tests)
        found["wildcards"] += len(re.findall(r"(?<![\w.])_ (?:if [^=]*)?=>", kept))
        found["string_errors"] |= {f"{path}: {name}": None for name in string_errors(kept)}
        found["read_errors"] |= {f"{path}: {name}": None for name in read_errors(kept)}
        found["long_functions"] |= {f"{path}: {name}": n for name, n in functions(kept) if n > LONGEST_FUNCTION}
        if kept.count("\n") > LONGEST_FILE:
            found["long_files"][path] = kept.count("\n")
        module = module_of(path)
        for other in paths(path, kept):
            if other != module:
                reached[module].add(other)
    modules = {module_of(path) for path in files if not is_test(path)}
    graph = {module: {other for other in reached[module] if other in modules} for module in modules - {"lib", "main"}}
    found["modules"] = len(graph)
    found["knots"] = knots(graph)
    return found


def is_test(path):
    parts = PurePosixPath(path).parts
    return "tests" in parts or parts[-1] == "tests.rs"


def module_of(path):
    return PurePosixPath(path).parts[0].removesuffix(".rs")


def bare(text):
    """The code with its comments gone and its strings empty; lines stay where they are."""
    pattern = re.compile(
        r"""//[^\n]*|/\*.*?\*/|b?r(\#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?'(?:\\(?:u\{[0-9a-fA-F]+\}|x[0-9a-fA-F]{2}|.)|[^'\\\n])'""",
        re.S,
    )

    def empty(match):
        found = match.group()
        kept = "" if found.startswith("/") else "''" if found.rstrip("'") != found else '""'
        return kept + "\n" * found.count("\n")

    return pattern.sub(empty, text)


def code_lines(code):
    return sum(1 for line in code.splitlines() if line.strip())


def apart(code):
    """The code without what only tests use, and that."""
    kept, tests, at = [], [], 0
    for match in re.finditer(r"#\[cfg\((?:all\()?test[^\]]*\]\s*(?:#\[[^\]]*\]\s*)*", code):
        if match.start() < at:
            continue
        end = item_end(code, match.end())
        kept.append(code[at : match.start()])
        tests.append(code[match.start() : end])
        at = end
    return "".join([*kept, code[at:]]), "\n".join(tests)


def item_end(code, at):
    """Where the item ends that begins here."""
    stop = re.compile(r"[;{]").search(code, at)
    if stop is None or stop.group() == ";":
        return len(code) if stop is None else stop.end()
    return pair_end(code, stop.start(), "{}")


def pair_end(code, at, pair):
    """Behind the first group from here on that a pair such as `{}` encloses."""
    depth = 0
    for match in re.compile(f"[{re.escape(pair)}]").finditer(code, at):
        depth += 1 if match.group() == pair[0] else -1
        if depth == 0:
            return match.end()
    return len(code)


def functions(code):
    """Names and lengths in lines."""
    for match in re.finditer(r"\bfn\s+(\w+)", code):
        body = re.compile(r"[;{]").search(code, pair_end(code, match.end(), "()"))
        if body and body.group() == "{":
            yield match.group(1), code.count("\n", body.start(), pair_end(code, body.start(), "{}")) + 1


def string_errors(code):
    """Public functions whose error is a text."""
    for match in re.finditer(r"\bpub fn\s+(\w+)", code):
        end = pair_end(code, match.end(), "()")
        result = re.match(r"\s*->\s*([^{;]*)", code[end:])
        if result and re.search(r"Result<.*,\s*String>", result.group(1), re.S):
            yield match.group(1)


def read_errors(code):
    """Functions that look for something in the words of an error."""
    searches = r"\b(?:error|problem|message|words)(?:\.to_string\(\)|\(\))?\s*\.(?:contains|starts_with|ends_with|split_once|strip_prefix)\("
    for match in re.finditer(searches, code):
        names = re.findall(r"\bfn\s+(\w+)", code[: match.start()])
        yield names[-1] if names else "?"


def paths(path, code):
    """The modules of its crate that a file names."""
    yield from re.findall(r"\bcrate::(\w+)", code)
    for group in re.findall(r"\bcrate::\{([^}]*)\}", code):
        yield from re.findall(r"(?:^|,)\s*(\w+)", group)
    # `super` of a module right below the crate is the crate itself.
    parts = PurePosixPath(path).parts
    depth = len(parts) - (parts[-1] == "mod.rs")
    ups = r"(?:super::)" + "{" + str(depth) + "}"
    yield from re.findall(rf"(?<!super::)\b{ups}(\w+)", code)


def knots(graph):
    """Groups of modules that all reach each other, the largest first (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(module):
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(graph[module]):
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            at = stack.index(module)
            group, stack[at:] = stack[at:], []
            if len(group) > 1:
                found.append(sorted(group))

    for module in sorted(graph):
        if module not in index:
            visit(module)
    return sorted(found, key=len, reverse=True)


def show(crates):
    print(f"{'crate':38}{'files':>6}{'code':>8}{'tests':>8}{'modules':>9}{'in knots':>9}{'_ =>':>6}{'String errors':>15}{'long fns':>9}")
    total = defaultdict(int)
    for crate, found in crates.items():
        row = [
            found["files"],
            found["code"],
            found["tests"],
            found.get("modules", 0),
            sum(map(len, found.get("knots", []))),
            found.get("wildcards", 0),
            len(found.get("string_errors", [])),
            len(found.get("long_functions", [])),
        ]
        for i, number in enumerate(row):
            total[i] += number
        print_row(crate, row)
    print_row("all", [total[i] for i in range(8)])
    print("\nknots:")
    for crate, found in crates.items():
        for knot in found.get("knots", []):
            print(f"  {crate}: {' '.join(knot)}")
    for title, key in [("functions over 40 lines", "long_functions"), ("files over 400 lines", "long_files"), ("public functions whose error is a String", "string_errors")]:
        print(f"\n{title}:")
        for crate, found in crates.items():
            for place, lines in found.get(key, {}).items():
                print(f"  {crate}: {place} {lines or ''}".rstrip())


def print_row(name, row):
    widths = [6, 8, 8, 9, 9, 6, 15, 9]
    print(f"{name:38}" + "".join(f"{number:{width}}" for number, width in zip(row, widths)))


if __name__ == "__main__":
    main()
