"""The two streams as paper: lines with a little colour where the terminal takes it."""

from __future__ import annotations

import sys
import textwrap
from typing import TYPE_CHECKING

from drysim.wording import clean

if TYPE_CHECKING:
    from rich.console import Console

NARROW, WIDE = 50, 100
"""Fewest and most columns that words are set in; a narrower terminal breaks lines itself."""

Piece = str | tuple[str, str]
"""Words, or words and their style."""


def result() -> Console:
    """Give stdout."""
    return _paper(to_stderr=False)


def talk() -> Console:
    """Give stderr."""
    return _paper(to_stderr=True)


def _paper(to_stderr: bool) -> Console:
    """Give a stream; a sign that it cannot encode becomes a question mark, not a crash."""
    from rich.console import Console

    stream = sys.stderr if to_stderr else sys.stdout
    reconfigure = getattr(stream, "reconfigure", None)
    if reconfigure is not None:
        reconfigure(errors="replace")
    return Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True)


def line(paper: Console, *pieces: Piece) -> None:
    """Set one line of pieces, however long it is.

    Parameters
    ----------
    paper : Console
    *pieces : str or (str, str)
        Words with or without a style; control characters are spelled out, brackets stay.
    """
    from rich.text import Text

    parts = (piece if isinstance(piece, tuple) else (piece, "") for piece in pieces)
    paper.print(Text.assemble(*((_shown(words), style) for words, style in parts)))


def paragraph(paper: Console, head: str, words: str, style: str = "") -> None:
    """Set a sentence behind its head, its further lines below its first word."""
    lines = folded(paper, words, len(head))
    line(paper, (head, style), *lines[:1])
    for further in lines[1:]:
        line(paper, " " * len(head), further)


def folded(paper: Console, words: str, head: int) -> list[str]:
    """Give a sentence in lines that fit behind a head of so many columns."""
    width = max(min(max(paper.width, NARROW), WIDE) - head, 20)
    return textwrap.wrap(clean(words), width, break_long_words=False, break_on_hyphens=False)


def _shown(words: str) -> str:
    """Give words on one line; runs of spaces stay, for they align."""
    return "".join(sign if sign.isprintable() else clean(sign) or " " for sign in words)
