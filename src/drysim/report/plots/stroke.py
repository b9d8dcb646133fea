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
from drysim.study.sweeps.table import LIMIT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.shown import Shown
    from drysim.report.plots.views import Panel, View
    from drysim.study.sweeps.table import Table

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
        _limit(axes, table, drawn, panel, told.scale, FAR * top)
        _violations(axes, drawn, panel, told)

    return over_sweep(table, drawn, [told, *hits], bound)


def _limit(
    axes: Axes, table: Table, drawn: View, panel: Panel, scale: float, far: float
) -> None:
    """Draw the stroke limit, up to so far away; where it is swept that of each case."""
    stroke = table.scenario.stroke
    if stroke is None:
        return
    if drawn.key == LIMIT:
        every = {drawn.x(row) for line in panel.lines for row in line.rows}
        x = sorted(value for value in every if value * scale <= far)
        axes.plot(x, [scale * value for value in x], **panels.LIMIT, label="stroke limit")
    elif drawn.line is not None and drawn.line.key == LIMIT:
        near = [at for at, line in enumerate(panel.lines) if line.value * scale <= far]
        for at in near if len(panel.lines) <= ink.FEW_LINES else ():
            own = {**panels.LIMIT, "color": ink.styles(drawn)[at]["color"]}
            words = "stroke limit of each" if at == near[0] else "_"
            axes.axhline(panel.lines[at].value * scale, **own, label=words)
    elif (limit := panel.point.get(LIMIT, stroke.limit)) * scale <= far:
        label = f"stroke limit {wording.length(limit)}"
        axes.axhline(limit * scale, **panels.LIMIT, label=label)


def _violations(axes: Axes, drawn: View, panel: Panel, told: Shown) -> None:
    """Mark where the stroke limit is met."""
    rows = [row for line in panel.lines for row in line.rows if row.metrics.get("violations")]
    if rows:
        x, y = [drawn.x(row) for row in rows], [told.of(row) or nan for row in rows]
        style: Any = {**panels.BEYOND, "markersize": 6, "linestyle": "none", "clip_on": False}
        axes.plot(x, y, **style, label="limit met")
