"""What mkdocs lacks: files of the repository that pages link to are part of the site, below `source/`."""

import re
from pathlib import Path
from posixpath import dirname, join, normpath, relpath

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[3]
LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(?=\))")
# Pages of the repository whose links are checked, too.
BESIDE = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "client/python/README.md", "python/README.md", "crates/bench/README.md", "crates/sim/tests/devices/README.md"]
FENCE = re.compile(r"(^```.*?^```)", re.M | re.S)


def in_repository(page):
    """The path from the root of the file that a page is made of."""
    return page.removeprefix("source/") if page.startswith("source/") else join("docs", page)


def in_site(path):
    """The path in the site of a file in the repository."""
    return path.removeprefix("docs/") if path.startswith("docs/") else join("source", path)


def targets(page, text):
    """The files in the repository to which a page links."""
    for part in FENCE.split(text)[::2]:
        for link in LINK.finditer(part):
            if "://" not in link[2] and not link[2].startswith("mailto:"):
                yield normpath(join(dirname(in_repository(page)), link[2]))


def on_files(files, config):
    """Adds what pages link to outside of `docs`."""
    for path in BESIDE:
        files.append(File.generated(config, in_site(path), abs_src_path=str(ROOT / path)))
    for page in [file for file in files if file.is_documentation_page()]:
        for path in targets(page.src_uri, Path(page.abs_src_path).read_text()):
            is_outside = not path.startswith("docs/") and (ROOT / path).is_file()
            if is_outside and files.get_file_from_path(in_site(path)) is None:
                files.append(File.generated(config, in_site(path), abs_src_path=str(ROOT / path)))
    return files


def on_page_markdown(markdown, page, config, files):
    """Turns links within the repository into links within the site; what the site does not have is text."""
    here = page.file.src_uri

    def rewritten(link):
        if "://" in link[3] or link[3].startswith("mailto:"):
            return link[0]
        path = normpath(join(dirname(in_repository(here)), link[3]))
        target = in_site(path)
        if files.get_file_from_path(target) is None:
            # A folder, or what a file outside of the manual links to. Any other link is broken, which mkdocs reports.
            return link[2] if (ROOT / path).exists() else link[0]
        return f"{link[1]}[{link[2]}]({relpath(target, dirname(here) or '.')}{link[4] or ''})"

    whole = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
    parts = FENCE.split(markdown)
    parts[::2] = [whole.sub(rewritten, part) for part in parts[::2]]
    return re.sub(r"^```([a-z]+)[ ,].*$", r"```\1", "".join(parts), flags=re.M)
