"""Summary of a result as data: the one text that console, drysim.json and report show.

Each kind of result makes it (`drysim.results`); console, JSON and HTML know only how to print
it. drysim.json stores it, so that a result on the disk is shown without its scenario being
solved again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

GOOD, BAD, PLAIN = "good", "bad", "plain"
"""Tones of a row or a note: an achievement, a violation, a value that does not stand out."""


MAX_WIDTH = 200
"""Largest least width of the values [columns]."""


class Row(NamedTuple):
    """A line of a summary: label, value and explanation."""

    label: str
    value: str
    remark: str = ""
    tone: str = ""
    """A tone, or empty: the value stands out."""


class Note(NamedTuple):
    """A labelled sentence."""

    label: str
    sentence: str
    tone: str = ""


class Judgement(NamedTuple):
    """A check, and whether it passed; None if it was not judged."""

    passed: bool | None
    sentence: str


class Grid(NamedTuple):
    """A table of text by columns, header first."""

    columns: Sequence[Sequence[str]]
    texts: Sequence[str] = ()
    """Columns of text; the others hold numbers."""
    optional: Sequence[str] = ()
    """Columns that a narrow terminal omits, in this order."""
    title: str = ""


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What a result says.

    Attributes
    ----------
    name, about : str
        Name and description of the scenario.
    scene : sequence of (str, str)
        Label and sentence: what was computed, and how.
    faults : sequence of Note
        Why the result is not what was asked for.
    table : Grid, optional
        Approaches or cases side by side.
    groups : sequence of sequence of Row
        The numbers, those that belong together in one group.
    width : int
        Least width of the values in text [columns].
    notes : sequence of Note
        Sentences below the table or the groups.
    checks : sequence of Judgement
    conclusion : sequence of Note
        What follows although a check fails.
    verdict : sequence of str
        The conclusion in sentences, the first one the most important.
    answer : sequence of str
        The main numbers in sentences, for a page that begins with them.
    details : sequence of Grid
        Further tables, for a page.
    parts : sequence of Summary
        Of a result of several scenarios: the summary of each.
    """

    name: str
    about: str = ""
    scene: Sequence[tuple[str, str]] = ()
    faults: Sequence[Note] = ()
    table: Grid | None = None
    groups: Sequence[Sequence[Row]] = ()
    width: int = 0
    notes: Sequence[Note] = ()
    checks: Sequence[Judgement] = ()
    conclusion: Sequence[Note] = ()
    verdict: Sequence[str] = ()
    answer: Sequence[str] = ()
    details: Sequence[Grid] = ()
    parts: Sequence[Summary] = ()


def as_fields(value: Any) -> Any:
    """Return a summary, or a part of it, as dictionaries, lists and text."""
    if isinstance(value, Summary):
        return {field.name: as_fields(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {name: as_fields(part) for name, part in value._asdict().items()}
    if isinstance(value, list | tuple):
        return [as_fields(part) for part in value]
    return value


def from_fields(stored: Any) -> Summary:
    """Return the summary of `as_fields`.

    Raises
    ------
    pydantic.ValidationError
        When it is none.
    ValueError
        When it cannot be printed.
    """
    from pydantic import TypeAdapter

    summary = TypeAdapter(Summary).validate_python(stored)
    if not 0 <= summary.width <= MAX_WIDTH:
        raise ValueError(f"width {summary.width}")
    return summary
