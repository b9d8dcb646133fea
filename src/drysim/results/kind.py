"""What a kind of result is: its files, pictures, fields of drysim.json, and summary."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.scenario.text import describe_point
from drysim.study.summary import Judgement
from drysim.yaml_document import dump

if TYPE_CHECKING:
    from drysim.metrics.checks import Verdict
    from drysim.results.fields import Fields, Provenance
    from drysim.results.tables import Column
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.statistics import Batch
    from drysim.study.summary import Summary

SCENARIO_FILE = "scenario.yaml"
"""The scenario of a result with all defaults explicit: the one file of it that users edit."""

PNG, SVG, PDF = "png", "svg", "pdf"
"""Formats of pictures; also their suffixes."""


class File(NamedTuple):
    """A file of a result."""

    name: str
    """With `*` it stands for several files."""
    write: Callable[[Any, Path], None]
    """Writes the file of a result, if there is anything to write; of several files, into the
    folder of the result."""
    form: str = ""
    """The format of tables that must be asked for, empty for a file of every result."""
    numbers: Sequence[str] = ()
    """Columns of numbers whose unit differs from row to row; others without a unit are text."""
    cases: Callable[[Any], tuple[Sequence[Column], Iterable[Batch]]] | None = None
    """Returns the columns and the batches of a large table of cases, for a data frame."""


class Picture(NamedTuple):
    """A picture of a result."""

    name: str
    draw: str
    """Module and function of `drysim.plots`. It returns no figure if there is nothing to
    draw."""
    caption: str
    shown: Callable[[Any], Any] = lambda result: result
    """Returns what is drawn of the result."""
    fits_axes: bool = False
    """Whether it may have a single panel; its function then takes axes to draw it into."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of result.

    Attributes
    ----------
    name : str
        As in drysim.json.
    what : str
        The same in a sentence.
    files : tuple of File
        Besides scenario.yaml, pictures, report and drysim.json.
    pictures : tuple of Picture
        The main one first.
    fields : callable
        Returns the content of drysim.json, without the summary.
    summary : callable
        Returns the summary.
    scenario : callable
        Returns the scenario that was solved, None for several.
    legend : str
        Kind of the words of a summary that a report explains.
    is_sheet : bool
        Whether its report prints on one page, to be signed: without explanations and tables.
    """

    name: str
    what: str
    files: tuple[File, ...]
    fields: Callable[[Any, Provenance], Fields]
    summary: Callable[[Any], Summary]
    pictures: tuple[Picture, ...] = ()
    scenario: Callable[[Any], Scenario | None] = lambda result: result.scenario
    legend: str = ""
    is_sheet: bool = False

    def writes(self, name: str) -> bool:
        """Whether a file of this name, relative to its folder, may belong to a result."""
        pictures = (f"{each.name}.{form}" for each in self.pictures for form in (PNG, SVG, PDF))
        path = PurePosixPath(name)
        return any(
            path.match(pattern) and len(path.parts) == len(PurePosixPath(pattern).parts)
            for pattern in (SCENARIO_FILE, *(file.name for file in self.files), *pictures)
        )


def write_scenario(scenario: Scenario | None, file: Path) -> None:
    """Write a scenario: all defaults explicit, can be run again as it is."""
    if scenario is not None:
        text = dump(scenario.resolved(relative_to=file.parent))
        file.write_text(text, encoding="utf-8", newline="\n")


def judgements(
    verdicts: Iterable[Verdict], axes: Sequence[Axis] = (), by: str = ""
) -> tuple[Judgement, ...]:
    """Return the checks of a summary, over many cases each with the deciding one.

    `by` is the approach or law of a comparison that decides.
    """
    units = {axis.key: axis.unit for axis in axes}
    return tuple(
        Judgement(verdict.passed, describe_verdict(verdict, units, by)) for verdict in verdicts
    )


def describe_verdict(verdict: Verdict, units: Mapping[str, str], by: str = "") -> str:
    """Describe a verdict: check, value, deciding approach or law (`by`), and place.

    `units` maps swept keys to their units.
    """
    where = describe_point(verdict.named_point, units)
    parted, place = ";" if verdict.reason else ",", f" at {where}" if where else ""
    worst = "" if verdict.reason or not verdict.share else "worst "
    sentence = f"{verdict.check}{verdict.share}{parted} {worst}{verdict.described_value}"
    return f"{sentence}{f' by {by}' if by else ''}{place}"


def clean_up_lines(sentences: Sequence[str]) -> Iterable[tuple[str, str]]:
    """Yield label and sentence of every cleaning step of a record."""
    for place, sentence in enumerate(sentences):
        yield "" if place else "cleaned", sentence


def describe_incomplete(done: int, every: int, thing: str) -> str:
    """Describe interrupted work, e.g. `incomplete: 3 of 20 seeds`."""
    return f"incomplete: {done} of {wording.format_count(every, thing)}"
