"""The parts of every summary: title, words, numbers, verdicts, warnings, the folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from drysim import wording
from drysim.console.paper import folded, line, paragraph, stderr
from drysim.errors import Caution
from drysim.quantity import factor
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.console.paper import Paper
    from drysim.scenario import Axis, Scenario

HEAD = 14
"""Columns of the names on the left."""

FINE = 6
"""Digits of a value that stands beside the bound of its check."""


class Row(NamedTuple):
    """A line of a summary: what, how much, and what that means."""

    name: str
    value: str
    remark: str = ""
    style: str = "bold"


def show_title(paper: Paper, scenario: Scenario) -> None:
    """Show the name of a scenario and what it is about."""
    line(paper, (wording.clean(scenario.name), "bold"))
    if scenario.about:
        paragraph(paper, "", scenario.about)


def show_scene(paper: Paper, words: Iterable[tuple[str, str]]) -> None:
    """Show in words what was solved, and how."""
    line(paper)
    for name, sentence in words:
        headed(paper, name, sentence)


def headed(paper: Paper, head: str, sentence: str, style: str = "dim") -> None:
    """Show a sentence beside its head in the column of the names."""
    paragraph(paper, f"  {head}".ljust(HEAD), sentence, style)


def judged(passed: bool) -> tuple[str, str]:
    """Give the mark of a check and its style."""
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


def steps(sentences: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Give what was done to a record, as words of the scene."""
    for at, sentence in enumerate(sentences):
        yield "" if at else "cleaned", sentence


def show_rows(paper: Paper, rows: Iterable[Row], width: int) -> None:
    """Show numbers, each with its remark behind so many columns, or more for a long number.

    Long remarks are set below.
    """
    rows = list(rows)
    width = max([width, *(len(row.value) + 1 for row in rows if row.remark)])
    line(paper)
    for row in rows:
        name, value = f"  {row.name}".ljust(HEAD), row.value.ljust(width)
        first, *further = folded(paper, row.remark, HEAD + width) or [""]
        line(paper, (name, "dim"), (value if first else row.value, row.style), first)
        for words in further:
            line(paper, " " * (HEAD + width), words)


def show_verdicts(paper: Paper, verdicts: Sequence[Verdict], axes: Sequence[Axis] = ()) -> None:
    """Show what became of the checks, over many cases with the one that decided."""
    if verdicts:
        line(paper)
    for verdict in verdicts:
        mark, style = judged(verdict.passed)
        if verdict.passed and not verdict.applies:
            mark, style = "· passed", "dim"
        headed(paper, mark, _words(verdict, axes), style)


def _words(verdict: Verdict, axes: Sequence[Axis]) -> str:
    """Give a check and what its metric turned out to be, in the unit that the check has."""
    check, value, unit = verdict.check, verdict.value, wording.pretty(verdict.unit)
    where = wording.place(verdict.where or {}, axes)
    place = f" at {where}" if where else ""
    if not verdict.applies:
        none = "this case lies elsewhere" if verdict.passed else "no case lies there"
        return f"{check}; {none}"
    if value is None:
        return f"{check}; {check.metric} is not known {place.lstrip() or 'here'}"
    scale = 1.0
    if check.unit:
        scale = 1.0 / factor(check.unit, verdict.unit)
        unit = wording.pretty(check.unit)
    mean = f", mean of {verdict.seeds} seeds" if verdict.seeds > 1 else ""
    if verdict.half_width:
        found = wording.around(value * scale, verdict.half_width * scale, unit)
        return f"{check}, with {found}{mean}{place}"
    return f"{check}, with {number(value * scale, unit, FINE)}{mean}{place}"


def show_folder(paper: Paper, folder: Path | None) -> None:
    """Show where the files were written."""
    if folder is not None:
        line(paper)
        line(paper, ("  written".ljust(HEAD), "dim"), str(folder))


def show_warnings(warnings: Sequence[Caution]) -> None:
    """Show warnings on stderr, one sentence each."""
    paper = stderr()
    for caution in warnings:
        if paper.is_terminal:
            paragraph(paper, "warning: ", caution.sentence, "yellow")
        else:
            line(paper, "warning: ", caution.sentence)
