"""The summary of many seeds: what was drawn, means with their intervals, verdicts, warnings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.console.paper import stdout
from drysim.console.parts import (
    Row,
    show_folder,
    show_rows,
    show_scene,
    show_title,
    show_verdicts,
    show_warnings,
    unfinished,
)
from drysim.console.summary import scene
from drysim.study.ensembles.seeds import most, until_of
from drysim.study.sweeps.table import OK
from drysim.wording import around, number, percent, seeds, several, told_in

if TYPE_CHECKING:
    from drysim.study.ensembles.ensemble import Ensemble
    from drysim.study.ensembles.statistics import Statistic

VALUE = 22
"""Columns of the values beside the names."""

MAIN = (
    ("T_a", "T_a", ""),
    ("SEAT", "SEAT", ""),
    ("a_w", "a_w", "m/s²"),
    ("T_x", "T_x", ""),
    ("peak |x_r|", "x_r_peak", "m"),
    ("in an hour", "stroke_once_an_hour", "m"),
    ("stuck", "stuck_share", "%"),
)
"""Name, metric and unit of the rows."""


HITS = (
    ("impact_speed", "m/s", "at up to"),
    ("stop_force_peak", "N", "pushing with up to"),
    ("impulse_peak", "N·s", "with an impulse of up to"),
)
"""Metric, unit and words of how hard end stops are met."""

FEWEST = 13
"""Seeds from which on the quantiles of 5 and 95 % are others than the least and greatest."""


def show_ensemble(ensemble: Ensemble, folder: Path | None = None) -> None:
    """Show what came out of many seeds.

    Parameters
    ----------
    ensemble : Ensemble
    folder : Path, optional
        Where the files were written.
    """
    paper = stdout()
    show_title(paper, ensemble.scenario)
    show_scene(paper, _scene(ensemble))
    show_rows(paper, _rows(ensemble), VALUE)
    show_verdicts(paper, ensemble.checks)
    if ensemble.complete:
        show_folder(paper, folder)
    show_warnings(ensemble.warnings)


def _scene(ensemble: Ensemble) -> Iterator[tuple[str, str]]:
    """Give in words what was solved, and with which seeds."""
    for name, words in scene(ensemble.shown):
        yield name, words
        if name == "base":
            until = until_of(ensemble.scenario)
            yield "seeds", seeds(ensemble.seeds, until)
            if not ensemble.complete:
                yield "state", unfinished(len(ensemble.rows), most(ensemble.scenario), "seed")


def _rows(ensemble: Ensemble) -> Iterator[Row]:
    """Give the metrics that matter most, and the one that decided when to stop."""
    until = until_of(ensemble.scenario)
    rows, good = list(MAIN), sum(row.status == OK for row in ensemble.rows)
    peak = ensemble.statistics["x_r_peak"]
    beside = peak.greatest[0] if peak else 0.0
    if until and until.metric not in {metric for _, metric, _ in MAIN}:
        rows.append((until.metric, until.metric, ""))
    for name, metric, given in rows:
        found = ensemble.statistics[metric]
        wished = until is not None and metric == until.metric
        # What only some seeds know is a mean over chosen ones; drysim.json has it.
        if found is not None and (wished or found.seeds == good):
            scale, unit = told_in(given, found.greatest[0], beside)
            width = None if found.half_width is None else found.half_width * scale
            words = around(found.mean * scale, width, unit)
            yield Row(name, words, "; ".join(_remarks(ensemble, metric, found, scale, unit)))
    yield from _limit(ensemble)
    residual = ensemble.statistics["energy_residual"]
    if residual:
        words = number(residual.greatest[0], digits=2)
        yield Row("energy", words, "is the most that an energy balance leaves, relative")
    if lost := sum(row.status != OK for row in ensemble.rows):
        yield Row("failed", several(lost, "seed"), style="bold red")


def _remarks(
    ensemble: Ensemble, metric: str, found: Statistic, scale: float, unit: str
) -> Iterator[str]:
    """Give how a metric scatters from seed to seed."""
    low, high = (found.quantiles[at] * scale for at in (0, -1))
    if number(low) != number(high):
        which = "9 of 10" if found.seeds >= FEWEST else f"all {found.seeds}"
        yield f"{which} seeds from {number(low)} to {number(high, unit)}"
    if found.seeds < len(ensemble.rows):
        yield f"known with {found.seeds} of {len(ensemble.rows)} seeds"
    if metric == "x_r_peak" and (stroke := ensemble.scenario.stroke):
        value, seed = found.greatest
        used = percent(value / stroke.limit)
        yield f"most with seed {seed}, {used} of the stroke limit"


def _limit(ensemble: Ensemble) -> Iterator[Row]:
    """Give how many seeds meet the stroke limit, and how hard where there are end stops."""
    beyond = sum(bool(row.metrics.get("violations")) for row in ensemble.rows)
    if beyond:
        name, how = "limit met", [f"of {len(ensemble.rows)}"]
        for metric, unit, words in HITS:
            if (found := ensemble.statistics.get(metric)) and found.greatest[0] > 0:
                value, seed = found.greatest
                name = "stops met"
                how.append(f"{words} {number(value, unit)} with seed {seed}")
        yield Row(name, several(beyond, "seed"), ", ".join(how), "bold red")
