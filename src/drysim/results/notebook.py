"""Summary of a result as HTML, as notebooks show it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING

from drysim.console.summary import check_mark
from drysim.results import kind_of

if TYPE_CHECKING:
    from drysim.study.outcome import AnyResult
    from drysim.study.summary import Summary


def to_html(result: AnyResult) -> str:
    """Return a result as HTML: its line, numbers, notes, checks and verdict."""
    summary = kind_of(result).summary(result)
    parts = [part for each in (summary, *summary.parts) for part in summary_html(each)]
    return f"<div><p>{escape(repr(result))}</p>{''.join(parts)}</div>"


def summary_html(summary: Summary) -> Iterator[str]:
    """Yield the tables and the list of sentences of a summary."""
    if summary.table:
        header, *rows = zip(*summary.table.columns, strict=True)
        yield table_html(rows, header)
    if rows := [
        (row.label, row.value, row.remark) for group in summary.groups for row in group
    ]:
        yield table_html(rows)
    sentences = [
        *(f"{note.label}: {note.sentence}" for note in (*summary.faults, *summary.notes)),
        *(f"{check_mark(passed)[0]}: {sentence}" for passed, sentence in summary.checks),
        *(f"{note.label}: {note.sentence}" for note in summary.conclusion),
        *summary.verdict,
    ]
    if sentences:
        yield f"<ul>{''.join(f'<li>{escape(sentence)}</li>' for sentence in sentences)}</ul>"


def table_html(rows: Iterable[Sequence[str]], header: Sequence[str] = ()) -> str:
    """Return a table of text as HTML."""
    lines = [("td", row) for row in rows]
    if header:
        lines.insert(0, ("th", header))
    body = "".join(
        f"<tr>{''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells)}</tr>"
        for tag, cells in lines
    )
    return f"<table>{body}</table>"
