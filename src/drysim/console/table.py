"""The summary of a sweep: what was swept, extremes with where, isolation, what is missing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console import many
from drysim.console.many import at
from drysim.console.paper import line, stderr, stdout
from drysim.console.parts import (
    Row,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
    steps,
    unfinished,
)
from drysim.scenario.rules import STATIC
from drysim.study.sweeps import cases, survey
from drysim.study.sweeps.rows import HELD
from drysim.study.sweeps.sweep import approaches_of
from drysim.study.sweeps.tally import Tally
from drysim.wording import number, percent, several

if TYPE_CHECKING:
    from drysim.study.sweeps import table as study
    from drysim.study.sweeps.survey import Isolation

VALUE = 20
"""Columns of the values beside the names."""

DIGITS = 3
"""Digits of the ends of a range."""

NAMED = 4
"""Curves whose isolation is told one by one."""


def show_table(table: study.Table, folder: Path | None = None) -> None:
    """Show what a sweep came to.

    Parameters
    ----------
    table : Table
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    show_title(paper, table.scenario)
    show_scene(paper, scene(table))
    show_rows(paper, _rows(table), VALUE)
    show_verdicts(paper, table.checks, table.axes)
    if table.complete:
        show_folder(paper, folder)
    show_warnings(table.warnings)


def show_interrupted(kept: int, what: str, folder: Path) -> None:
    """Say on stderr what was kept of interrupted work, cases or seeds, and how it goes on."""
    paper = stderr()
    if not kept:
        line(paper, f"interrupted before any {what} was finished")
        return
    cases = f"{several(kept, f'finished {what}')} {'is' if kept == 1 else 'are'}"
    line(
        paper,
        f"interrupted: {cases} kept in {folder}.partial; the same command with --resume "
        "computes only the rest",
    )


def scene(table: study.Table) -> Iterator[tuple[str, str]]:
    """Give in words what was swept, and what was not."""
    scenario, axes = table.scenario, table.axes
    varied = [axis.key for axis in axes]
    limits = {f"friction.{key}" for key in STATIC}
    defaulted = not limits & {*varied} and not scenario.static_given
    plant, law, shared = scenario.oscillator.plant(), scenario.law(), _own(table).shared
    ratios, base = scenario.ratios, scenario.excitation
    peak = _own(table).greatest("x_r_peak")
    yield from wording.scene(
        plant, law, defaulted, scenario.terms, varied, shared, ratios, peak
    )
    fixed = table.motion and not any(key.startswith("excitation.") for key in varied)
    if table.motion and fixed:
        yield "base", wording.excitation(base, table.motion)
    else:
        yield "base", wording.excitations(base, varied)
    yield from steps(wording.clean_up(table.motion) if fixed else ())
    if words := many.seeds(scenario, _own(table).seeds):
        yield "seeds", words
    for i, axis in enumerate(axes):
        yield "" if i else "swept", wording.swept(axis)
    counts = (f"{tally.cases} by {name}" for name, tally in table.tallies.items())
    yield "cases", ", ".join(counts)
    if not table.complete:
        yield "state", unfinished(len(table.rows), cases.count(approaches_of(scenario)), "case")


def _own(table: study.Table) -> Tally:
    """Give what the cases of the approach come to that was asked for."""
    return next(iter(table.tallies.values()), Tally(table.scenario.solver.approach))


def _rows(table: study.Table) -> Iterator[Row]:
    """Give the numbers that matter most, in the units of an engineer."""
    own = _own(table)
    for metric in ("T_a", "SEAT", "T_x"):
        if ends := own.extremes.get(metric):
            values = span(*(number(end.value, digits=DIGITS) for end in ends))
            yield Row(metric, values, many.extent(table, own, metric))
            yield from many.known(table.axes, own.seeds, metric)
    # Where the frequency is drawn together with other keys, a curve is a single case.
    over_frequency = any(
        axis.key == survey.FREQUENCY and len(axis.values) > 1 and not axis.walk
        for axis in table.axes
    )
    if over_frequency and "T_a" in own.extremes and own.cases <= HELD:
        yield _isolation(table, survey.isolation(table.own))
    yield from many.stroke(table, own)
    if ends := own.extremes.get("stuck_share"):
        remark = f"most {at(table, ends[1])}" if ends[1].value else ""
        if remark and many.alike(own, "stuck_share"):
            remark = many.extent(table, own, "stuck_share")
        yield Row("stuck", span(*(percent(end.value) for end in ends)), remark)
    if ends := own.extremes.get("energy_residual"):
        residual = number(ends[1].value, digits=2)
        yield Row("energy", residual, "is the most that an energy balance leaves, relative")
    yield from _missing(table)


def _isolation(table: study.Table, found: Sequence[Isolation]) -> Row:
    """Give from which frequency on the seat isolates, on every curve that ever does."""
    begins = [one.above for one in found if one.above is not None]
    if not begins:
        return Row("isolation", "nowhere", "T_a does not stay below 1 up to the end of a curve")
    first, last, remark = min(begins), max(begins), "T_a stays below 1"
    alike = first == last and len(begins) == len(found)
    if not alike and len(found) <= NAMED:
        remark += ": " + "; ".join(
            f"{wording.place(one.point, table.axes)} "
            + ("nowhere" if one.above is None else f"from {number(one.above, 'Hz')}")
            for one in found
        )
    elif not alike:
        lost = len(begins) < len(found)
        curves = f"{len(begins)} of {len(found)}" if lost else f"all {len(found)}"
        remark += f" on {curves} curves" + ", nowhere on the others" * lost
        if first < last:
            remark += f"; on {begins.count(first)} of them from {number(first, 'Hz')}"
    return Row("isolation", f"from {number(last, 'Hz')}", remark)


def _missing(table: study.Table) -> Iterator[Row]:
    """Count and name the cases that have no numbers."""
    counts: Counter[str] = Counter()
    firsts: dict[str, study.Row] = {}
    for tally in table.tallies.values():
        for status, (count, first) in tally.lost.items():
            counts[status] += count
            firsts.setdefault(status, first)
    for status, first in firsts.items():
        where = wording.place(first.point, table.axes)
        note = f": {first.note}" if first.note else ""
        cases = several(counts[status], "case")
        yield Row(status, cases, f"the first at {where}{note}", "bold red")


def span(low: str, high: str) -> str:
    """Give a range in words; one value where both ends read alike."""
    return low if low == high else f"{low} to {high}"
