"""A table of words in columns: ruled at a terminal, aligned in pipes and files."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Literal

from drysim.console.paper import line
from drysim.console.plain import Plain

if TYPE_CHECKING:
    from rich.console import Console

    from drysim.console.paper import Paper

NONE = "–"
"""What stands where there is nothing to say."""

BETWEEN = 3
"""Columns between two columns of a ruled table."""

Columns = Sequence[Sequence[str]]
"""Column by column, headings first."""


def show_columns(
    paper: Paper, given: Columns, left: Collection[str], spared: Sequence[str] = ()
) -> None:
    """Show a table.

    Parameters
    ----------
    paper : Paper
    given : sequence of sequence of str
        Column by column, headings first.
    left : collection of str
        Headings of the columns that are set to the left.
    spared : sequence of str, optional
        How the headings begin of what a narrow terminal does without, in this order.
    """
    if isinstance(paper, Plain):
        _plain(paper, given)
    else:
        _ruled(paper, _fitting(given, paper.width, spared), left)


def _ruled(paper: Console, given: Columns, left: Collection[str]) -> None:
    """Show a table at a terminal."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(box=SIMPLE_HEAD, pad_edge=False, header_style="bold")
    for heading, *_ in given:
        side: Literal["left", "right"] = "left" if heading in left else "right"
        table.add_column(Text(heading), justify=side, no_wrap=True)
    for row in list(zip(*given, strict=True))[1:]:
        table.add_row(*map(Text, row))
    paper.print(table, soft_wrap=False)


def _fitting(given: Columns, width: int, spared: Sequence[str]) -> Columns:
    """Give the columns that a terminal has room for; the files hold them all."""
    for heading in spared:
        if sum(max(map(len, column)) + BETWEEN for column in given) <= width:
            break
        given = [column for column in given if not column[0].startswith(heading)]
    return given


def _plain(paper: Plain, given: Columns) -> None:
    """Show a table in aligned columns, for pipes and files."""
    line(paper)
    widths = [max(map(len, column)) for column in given]
    for row in zip(*given, strict=True):
        words = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        line(paper, "  ".join(words).rstrip())
