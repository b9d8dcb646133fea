"""The picture of the stroke in a sweep: peak |x_r|, its limit, and what end stops take."""

from __future__ import annotations

from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.core.plant import Stopped
from drysim.report.plots import canvas, ink, many, panels
from drysim.report.plots.over_sweep import over_sweep
from drysim.report.plots.shown import FORCE, HIT, STROKE, peak
from drysim.report.plots.views import view
from drysim.study.sweeps.table import stroke_limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.shown import Shown
    from drysim.report.plots.views import Panel, View
    from drysim.study.sweeps.table import Row, Table

FAR = 3.0
"""How many times the peak a stroke limit may be away to be drawn."""


def stroke(table: Table, folder: Path) -> None:
    """Write stroke.png: the peak of |x_r|, its limit, and where that is met."""
    canvas.paint(lambda: draw(table), folder / "stroke.png")


def draw(table: Table) -> Figure:
    """Give the picture of the stroke, not yet rendered."""
    ends = table.tallies[table.approaches[0]].ends if table.rows else {}
    told = peak(ends.get(STROKE, (0.0, 0.0))[1])
    if many.scattered(table):
        return many.draw(table, [told])
    # Where there are stops, |x_r| hardly tells one case from another.
    law = table.scenario.law()
    hits = [HIT if law.rigid else FORCE] if isinstance(law, Stopped) else []
    drawn = view(table)
    top = max(ink.known(drawn, told.of), default=0.0)

    def bound(axes: Axes, panel: Panel, quantity: Shown) -> None:
        if quantity is not told:
            return
        _limit(axes, table, drawn, panel, told, FAR * top)
        _violations(axes, drawn, panel, told)

    return over_sweep(table, drawn, [told, *hits], bound)


def _limit(
    axes: Axes, table: Table, drawn: View, panel: Panel, told: Shown, far: float
) -> None:
    """Draw the stroke limit, up to so far away; where it is swept that of each case."""
    if table.scenario.stroke is None:
        return

    def limit(row: Row) -> float:
        return told.scale * (stroke_limit(table.scenario, row) or 0.0)

    curves = [ink.series(drawn, line, limit) for line in panel.lines]
    levels = [{*y} for _, y in curves]
    every = set().union(*levels)
    if len(every) == 1:
        (level,) = every
        words = f"stroke limit {wording.number(level, told.unit)}"
        _level(axes, level, far, panels.LIMIT, words)
    elif any(len(own) > 1 for own in levels):
        near = [(x, y) for x, y in zip(*curves[0], strict=True) if y <= far]
        axes.plot(*zip(*near, strict=True), **panels.LIMIT, label="stroke limit")
    elif len(levels) <= ink.FEW_LINES:
        for looks, own in zip(ink.styles(drawn), levels, strict=True):
            style = {**panels.LIMIT, "color": looks["color"]}
            for level in own:
                _level(axes, level, far, style, "stroke limit of each")


def _level(axes: Axes, level: float, far: float, style: ink.Style, words: str) -> None:
    """Draw a stroke limit that is the same all along the axis, if it is not too far away."""
    if level <= far:
        axes.axhline(level, **style, label=words)


def _violations(axes: Axes, drawn: View, panel: Panel, told: Shown) -> None:
    """Mark where the stroke limit is met."""
    rows = [row for line in panel.lines for row in line.rows if row.metrics.get("violations")]
    if rows:
        x, y = [drawn.x(row) for row in rows], [told.of(row) or nan for row in rows]
        style: Any = {**panels.BEYOND, "markersize": 6, "linestyle": "none", "clip_on": False}
        axes.plot(x, y, **style, label="limit met")
