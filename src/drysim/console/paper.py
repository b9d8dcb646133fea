"""The two streams as paper: lines with a little colour where the terminal takes it."""

from __future__ import annotations

import re
import sys
import textwrap
from typing import TYPE_CHECKING

from drysim.console.plain import Plain, is_plain
from drysim.wording import clean

if TYPE_CHECKING:
    from rich.console import Console

    Paper = Console | Plain

COMMAND = re.compile(r"\s*::")
"""The beginning of a line that the runner of a workflow on GitHub would obey."""

COMMAND_WITHIN = re.compile(r"##(\[|vso\[)")
"""What others obey anywhere in a line: GitHub of old, and Azure."""

NARROW, WIDE = 50, 100
"""Fewest and most columns that words are set in; a narrower terminal breaks lines itself."""

Piece = str | tuple[str, str]
"""Words, or words and their style."""


def stdout() -> Paper:
    """Give stdout."""
    return _paper(to_stderr=False)


def stderr() -> Paper:
    """Give stderr."""
    return _paper(to_stderr=True)


def _paper(to_stderr: bool) -> Paper:
    """Give a stream; a sign that it cannot encode becomes a question mark, not a crash."""
    stream = sys.stderr if to_stderr else sys.stdout
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")
    if is_plain(stream):
        return Plain(stream)
    from rich.console import Console

    return Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True)


def line(paper: Paper, *pieces: Piece) -> None:
    """Set one line of pieces, however long it is.

    Parameters
    ----------
    paper : Paper
    *pieces : str or (str, str)
        Words with or without a style; control characters are spelled out, brackets stay.
    """
    parts = (piece if isinstance(piece, tuple) else (piece, "") for piece in pieces)
    shown = [(_shown(words), style) for words, style in parts]
    if COMMAND.match("".join(words for words, _ in shown)):
        shown.insert(0, ("\\", ""))
    _print(paper, [(COMMAND_WITHIN.sub(r"# #\1", words), style) for words, style in shown])


def workflow_command(paper: Paper, words: str) -> None:
    """Set one line that is meant to be a command to who runs a workflow."""
    _print(paper, [(_shown(words), "")])


def say(text: str) -> None:
    """Say on stdout, line by line, what has no style."""
    for words in text.split("\n"):
        line(stdout(), words)


def remark(text: str) -> None:
    """Say it on stderr."""
    for words in text.split("\n"):
        line(stderr(), words)


def _print(paper: Paper, parts: list[tuple[str, str]]) -> None:
    """Print a line; where stderr cannot be written, there is nobody left to tell."""
    try:
        if isinstance(paper, Plain):
            paper.print("".join(words for words, _ in parts))
        else:
            from rich.text import Text

            paper.print(Text.assemble(*parts))
    except OSError:
        if paper.file is not sys.stderr:
            raise


def paragraph(paper: Paper, head: str, words: str, style: str = "") -> None:
    """Set a sentence behind its head, its further lines below its first word."""
    lines = folded(paper, words, len(head))
    line(paper, (head, style), *lines[:1])
    for further in lines[1:]:
        line(paper, " " * len(head), further)


def folded(paper: Paper, words: str, head: int) -> list[str]:
    """Give a sentence in lines that fit behind a head of so many columns."""
    width = max(min(max(paper.width, NARROW), WIDE) - head, 20)
    return textwrap.wrap(clean(words), width, break_long_words=False, break_on_hyphens=False)


def _shown(words: str) -> str:
    """Give words on one line; runs of spaces stay, for they align."""
    return "".join(sign if sign.isprintable() else clean(sign) or " " for sign in words)
