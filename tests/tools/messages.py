"""List every text that users may read: `python tests/tools/messages.py [FOLDER ...]`.

Printed are the strings of `src/drysim` that hold words, docstrings excluded, each with its file
and line; the replaced parts of an f-string become `{}`. To be read in one go.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "drysim"
WORDS = re.compile(r"[A-Za-z]{2,}[^A-Za-z]+[A-Za-z]{2,}")


def messages(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Return the line and text of every string with words, in order."""
    inner, ignored = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            ignored.add(node.value)
        if isinstance(node, ast.JoinedStr):
            inner |= set(node.values)
    for node in ast.walk(tree):
        text = ""
        if isinstance(node, ast.JoinedStr):
            parts = (getattr(part, "value", "{}") for part in node.values)
            text = "".join(part if isinstance(part, str) else "{}" for part in parts)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = "" if node in inner | ignored else node.value
        if WORDS.search(text) and " " in text.strip():
            yield node.lineno, " ".join(text.split())


if __name__ == "__main__":
    chosen = [SOURCE / name for name in sys.argv[1:]] or [SOURCE]
    files = [
        file for root in chosen for file in ([root] if root.is_file() else root.rglob("*.py"))
    ]
    for file in sorted(files):
        for line, text in sorted(messages(ast.parse(file.read_text(encoding="utf-8")))):
            print(f"{file.relative_to(SOURCE)}:{line}: {text}")
