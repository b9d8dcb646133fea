"""The manual: Markdown pages in four sections, shipped with the package.

`drysim manual` shows them in a terminal, `make docs` builds a site from the same files. What a
single word means (a key, a metric, a column, a warning) is in `manual.words`.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

SECTIONS = {
    "start": ("symbols", "first-run"),
    "tasks": (
        "own-record", "assess", "fit", "sweep", "map", "design", "branches", "compare", "seat",
        "seeds", "shock", "force", "stages", "report", "ci", "python",
    ),
    "reference": (
        "scenario", "keys", "approaches", "friction", "end-stops", "metrics", "files",
        "columns", "exit-codes", "commands", "warnings", "gallery",
    ),
    "background": (
        "physics", "exact", "claims", "speed", "paper", "choices", "robustness", "cluster",
        "architecture", "development", "changes",
    ),
}  # fmt: skip
"""Names of the pages by section, in reading order."""

FIRST = "symbols"
"""The page that is shown where none is named."""

PICTURE = re.compile(r"!\[([^\]]*)\]\([^)]*\)")
MARKER = re.compile(r"<!--.*?-->\n?", re.S)


class Page(NamedTuple):
    """A page of the manual."""

    name: str
    section: str
    file: Path

    @property
    def text(self) -> str:
        """Markdown of the page."""
        return self.file.read_text(encoding="utf-8")

    @property
    def title(self) -> str:
        """First heading of the page."""
        return self.text.partition("\n")[0].lstrip("# ")


@cache
def pages() -> dict[str, Page]:
    """Return all pages by name, in reading order."""
    home = Path(__file__).parent
    return {
        name: Page(name, section, home / section / f"{name}.md")
        for section, names in SECTIONS.items()
        for name in names
    }


def for_terminal(page: Page) -> str:
    """Return a page without what a terminal cannot show: pictures become their description."""
    text = MARKER.sub("", page.text)
    text = PICTURE.sub(r"*Picture: \1.*", text)
    return re.sub(r"\]\((?!https?:)[^)]*?([\w-]+)\.md(?:#[\w-]*)?\)", r"](\1)", text)
