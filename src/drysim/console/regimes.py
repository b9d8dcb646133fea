"""Summary of a regime map: the regimes, the scenario itself, and its nearest boundaries."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.summaries import SummaryRow, show_summary
from drysim.study.regimes import (
    ISOLATION,
    SEVERAL,
    STROKE,
    RegimeMap,
    describe_fixed,
    describe_regime,
    is_random,
    require_map,
)
from drysim.study.statistics import seed_range
from drysim.wording import format_number, format_percent, format_unit, short_key

if TYPE_CHECKING:
    from drysim.study.case import Case

VALUE_WIDTH = 10
"""Width of the values."""

SHARE_ROWS = {
    ISOLATION: ("T_a below 1", "the mass is isolated"),
    STROKE: ("stroke limit", "|x_r| reaches it"),
    SEVERAL: ("several", "other starts lead to another stable motion"),
}
"""Names and explanations of the shares of the map in which a label is 1."""


def show_map(result: RegimeMap, folder: Path | None = None) -> None:
    """Show the summary of a regime map."""
    groups = share_rows(result), place_rows(result)
    show_summary(result, result_scene(result), groups, VALUE_WIDTH, folder)


def map_scene(case: Case) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: the axes, and what all points of the map share."""
    scenario = case.scenario
    axes, grid = require_map(scenario)
    keys = [axis.key for axis in axes]
    for name, axis in zip(("over", "and"), axes, strict=True):
        yield name, f"{axis.key} {axis.description}"
    size = f"{grid.columns} × {grid.rows}"
    if is_random(scenario):
        begin, end = case.window
        seeds = wording.format_count(len(seed_range(scenario)), "seed")
        yield "grid", f"{size} motions of {format_number(end - begin, 's')}, {seeds}"
    else:
        yield "grid", f"{size} periodic orbits; a regime smaller than a cell may be missed"
    yield from describe_fixed(case, keys)
    yield "base", scenario.excitation.describe_cases(case.motion, keys)


def result_scene(result: RegimeMap) -> Iterator[tuple[str, str]]:
    """Yield label and sentence: what was mapped, and how well the boundaries are known."""
    yield from map_scene(result.case)
    width = max((line.width for line in result.boundaries), default=0.0)
    known = "to rounding"
    if width > 0.0:
        share = format_number(100.0 * width, "%", 1)
        known += f", and to {share} of an axis where the motion settles slowly"
    count = wording.format_count(len(result.boundaries), "line")
    if is_random(result.scenario):
        yield "lines", f"{count} of equal rate, interpolated between {result.cases} points"
    else:
        yield "boundaries", f"{count} by {result.cases} orbits, {known}"


def share_rows(result: RegimeMap) -> Iterator[SummaryRow]:
    """Yield the share of the map in each regime."""
    for label, share in result.shares.items():
        yield SummaryRow(describe_regime(label), format_percent(share), "of the map")
    for field, (name, words) in SHARE_ROWS.items():
        if field in result.labels and (share := result.share(field)):
            yield SummaryRow(name, format_percent(share), words)


def place_rows(result: RegimeMap) -> Iterator[SummaryRow]:
    """Yield what the scenario itself does, and the nearest boundaries along the axes."""
    place, keys = result.place, [axis.key for axis in result.axes]
    if not place.values:
        yield SummaryRow("here", "–", "the file does not state both keys")
        return
    values = ", ".join(
        f"{short_key(axis.key, keys)} "
        f"{format_number(place.values[axis.key], format_unit(axis.unit))}"
        for axis in result.axes
    )
    yield SummaryRow("here", values, "; ".join(result.describe_place()))
    if not place.is_inside:
        yield SummaryRow("", "", "outside the map")
    for one in place.changes:
        yield SummaryRow(short_key(one.key, keys), one.step, one.sentence)
