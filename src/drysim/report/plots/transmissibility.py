"""The pictures of a sweep: transmissibilities and stroke over what is swept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import nan, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim import wording
from drysim.core.plant import Stopped
from drysim.report.plots import (
    bands,
    canvas,
    heading,
    ink,
    layout,
    many,
    panels,
    scales,
)
from drysim.report.plots.labels import axis_label
from drysim.report.plots.views import view
from drysim.study.sweeps.survey import FREQUENCY
from drysim.study.sweeps.table import LIMIT, OK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.views import Panel, View
    from drysim.study.sweeps.table import Row, Table

STEEP = 100.0
"""Greatest over least value from which on T_a is drawn logarithmically."""

TUNING = {"oscillator.mass", "oscillator.stiffness"}
"""Keys that move the natural frequency."""

FAR = 3.0
"""How many times the peak a stroke limit may be away to be drawn."""


RIGHT = 0.965
"""Where panels end, so that half of the last number below them has room."""


class Quantity(NamedTuple):
    """What a panel shows: its words and symbol, its metric, in which scale."""

    title: str
    symbol: str
    metric: str
    scale: float = 1.0

    def of(self, row: Row) -> float | None:
        """Give the value of a row; None where it is not known."""
        found = row.metrics.get(self.metric) if row.status == OK else None
        return None if found is None else found * self.scale

    def width(self, row: Row) -> float | None:
        """Give half the interval of a mean over many seeds; None where there is none."""
        found = row.half_widths.get(self.metric)
        return None if found is None else found * self.scale


T_X = Quantity("relative displacement transmissibility", "$T_x$ [–]", "T_x")
T_A = Quantity("acceleration transmissibility", "$T_a$ [–]", "T_a")
PEAK = Quantity("stroke:", "peak |$x_r$| [mm]", "x_r_peak", 1e3)
HIT = Quantity("end stops:", "impact speed [m/s]", "impact_speed")
FORCE = Quantity("end stops:", "peak force [N]", "stop_force_peak")


def transmissibility(table: Table, folder: Path) -> None:
    """Write transmissibility.png: T_x on the left, T_a on the right, as in the paper.

    Parameters
    ----------
    table : Table
    folder : Path
        Where to write.
    """
    canvas.paint(lambda: draw(table), folder / "transmissibility.png")


def stroke(table: Table, folder: Path) -> None:
    """Write stroke.png: the peak of |x_r|, its limit, and where that is met."""
    canvas.paint(lambda: draw_stroke(table), folder / "stroke.png")


def draw(table: Table) -> Figure:
    """Give the picture of the transmissibilities, not yet rendered."""
    if many.scattered(table):
        both = [(one.metric, f"{one.title} {one.symbol}", 1.0) for one in (T_X, T_A)]
        return many.draw(table, both, limit=False)
    drawn = view(table)
    known = [one for one in (T_X, T_A) if any(True for _ in ink.known(drawn, one.of))] or [T_A]

    def unity(axes: Axes, panel: Panel, quantity: Quantity) -> None:
        axes.axhline(1.0, **ink.UNITY)

    return _drawn(table, drawn, known, unity)


def draw_stroke(table: Table) -> Figure:
    """Give the picture of the stroke, not yet rendered."""
    if many.scattered(table):
        return many.draw(table, [("x_r_peak", f"{PEAK.title} {PEAK.symbol}", 1e3)], limit=True)
    # Where there are stops, |x_r| hardly tells one case from another.
    law = table.scenario.law()
    hits = [HIT if law.rigid else FORCE] if isinstance(law, Stopped) else []
    drawn = view(table)
    top = max(ink.known(drawn, PEAK.of), default=0.0)

    def bound(axes: Axes, panel: Panel, quantity: Quantity) -> None:
        if quantity is not PEAK:
            return
        _limit(axes, table, drawn, panel, FAR * top)
        _violations(axes, drawn, panel)

    return _drawn(table, drawn, [PEAK, *hits], bound)


def _drawn(
    table: Table,
    drawn: View,
    quantities: Sequence[Quantity],
    extra: Callable[[Axes, Panel, Quantity], None],
) -> Figure:
    """Give a picture with a row for each panel of the view, a column for each quantity."""
    count = len(drawn.panels)
    coloured = drawn.line is not None and len(drawn.panels[0].lines) > ink.FEW_LINES
    figure, grid = layout.sheet(count, len(quantities), right=0.89 if coloured else RIGHT)
    for place, quantity in enumerate(quantities):
        first = None
        for at, panel in enumerate(drawn.panels):
            # One scale for all rows: they are there to be compared.
            axes = first = figure.add_subplot(grid[at, place], sharey=first)
            words = f"{panel.title}:" if panel.title else quantity.title
            ink.name(axes, f"{words} {quantity.symbol}", pad=15)
            scales.along(axes, drawn, named=at == count - 1)
            ink.curves(axes, drawn, panel, quantity.of)
            bands.along(axes, drawn, panel, quantity.of, quantity.width)
            extra(axes, panel, quantity)
            _upright(axes, list(ink.known(drawn, quantity.of)) if quantity is T_A else ())
            ink.gaps(axes, drawn, panel)
            _marks(axes, table, drawn)
    unnamed = {line.label for line in drawn.panels[0].lines} if coloured else ()
    head = heading.of_table(table, drawn.left_out)
    bottom, top = layout.complete(figure, grid, head, unnamed)
    if coloured:
        _colours(figure, drawn, bottom, top)
    return figure


def _upright(axes: Axes, values: Sequence[float]) -> None:
    """Let a panel begin at 0, or draw it logarithmically where the values are steep."""
    if values and 0 < STEEP * min(values) <= max(values):
        axes.set_yscale("log")
        scales.decades(axes.yaxis, *axes.get_ylim())
    else:
        axes.set_ylim(bottom=0.0)


def _limit(axes: Axes, table: Table, drawn: View, panel: Panel, far: float) -> None:
    """Draw the stroke limit, up to so far away [mm]; where it is swept that of each case."""
    stroke = table.scenario.stroke
    if stroke is None:
        return
    if drawn.key == LIMIT:
        every = {drawn.x(row) for line in panel.lines for row in line.rows}
        x = sorted(value for value in every if value * 1e3 <= far)
        axes.plot(x, [1e3 * value for value in x], **panels.LIMIT, label="stroke limit")
    elif drawn.line is not None and drawn.line.key == LIMIT:
        near = [at for at, line in enumerate(panel.lines) if line.value * 1e3 <= far]
        for at in near if len(panel.lines) <= ink.FEW_LINES else ():
            own = {**panels.LIMIT, "color": ink.styles(drawn)[at]["color"]}
            words = "stroke limit of each" if at == near[0] else "_"
            axes.axhline(panel.lines[at].value * 1e3, **own, label=words)
    elif (limit := panel.point.get(LIMIT, stroke.limit)) * 1e3 <= far:
        label = f"stroke limit {wording.length(limit)}"
        axes.axhline(limit * 1e3, **panels.LIMIT, label=label)


def _violations(axes: Axes, drawn: View, panel: Panel) -> None:
    """Mark where the stroke limit is met."""
    rows = [row for line in panel.lines for row in line.rows if row.metrics.get("violations")]
    if rows:
        x, y = [drawn.x(row) for row in rows], [PEAK.of(row) or nan for row in rows]
        style: Any = {**panels.BEYOND, "markersize": 6, "linestyle": "none", "clip_on": False}
        axes.plot(x, y, **style, label="limit met")


def _marks(axes: Axes, table: Table, drawn: View) -> None:
    """Mark the frequencies of the oscillator, where all cases share one."""
    varied = {axis.key for axis in table.axes if len(axis.values) > 1}
    plant = table.scenario.oscillator.plant()
    if drawn.key == FREQUENCY and not varied & TUNING and plant.k_x > 0:
        scales.frequencies(axes, sqrt(plant.k_x / plant.m) / (2 * pi))


def _colours(figure: Figure, drawn: View, bottom: float, top: float) -> None:
    """Draw the scale by which many lines are coloured."""
    from matplotlib.cm import ScalarMappable

    assert drawn.line is not None
    axes = figure.add_axes((0.915, bottom, 0.018, top - bottom))
    bar = figure.colorbar(ScalarMappable(*ink.scale(drawn.line)), cax=axes)
    bar.set_label(axis_label(drawn.line))
