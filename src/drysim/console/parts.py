"""The parts of every summary: title, words, numbers, verdicts, warnings, the folder."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from drysim import wording
from drysim.console.paper import folded, line, paragraph, stderr
from drysim.errors import Caution
from drysim.wording import several

if TYPE_CHECKING:
    from drysim.checks import Verdict
    from drysim.console.paper import Paper
    from drysim.scenario import Axis, Scenario

HEAD = 14
"""Columns of the names on the left."""


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


def judged(passed: bool | None) -> tuple[str, str]:
    """Give the mark of a check and its style."""
    if passed is None:
        return "· unjudged", "dim"
    return ("✓ holds", "green") if passed else ("✗ fails", "bold red")


def unfinished(done: int, every: int, thing: str) -> str:
    """Give the state of what was interrupted, e.g. `incomplete: 3 of 20 seeds`."""
    return f"incomplete: {done} of {several(every, thing)}"


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


def show_verdicts(
    paper: Paper, verdicts: Sequence[Verdict], axes: Sequence[Axis] = (), by: str = ""
) -> None:
    """Show what became of the checks, over many cases with the one that decided.

    `by` is the word of a comparison that they are judged by.
    """
    if verdicts:
        line(paper)
    units = {axis.key: axis.unit for axis in axes}
    for verdict in verdicts:
        mark, style = judged(verdict.passed)
        headed(paper, mark, finding(verdict, units, by), style)


def finding(verdict: Verdict, units: Mapping[str, str], by: str = "") -> str:
    """Give a check with what came out, by which word of a comparison, and where.

    `units` has the unit of every swept key.
    """
    where = wording.located(verdict.where or {}, units)
    parted, place = ";" if verdict.reason else ",", f" at {where}" if where else ""
    return f"{verdict.check}{parted} {verdict.found}{f' by {by}' if by else ''}{place}"


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
