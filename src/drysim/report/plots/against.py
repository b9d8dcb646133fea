"""T_a of several approaches, and how far each is off its yardstick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan
from typing import TYPE_CHECKING, Any

from drysim import wording
from drysim.report.plots import bands, ink, scales
from drysim.study.sweeps import survey
from drysim.study.sweeps.table import OK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    from drysim.report.plots.ink import Style
    from drysim.report.plots.views import Panel, View
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.sweeps.table import Row

AGREE = 100.0 * survey.AGREE
"""Deviation of T_a up to which two approaches agree [%]."""

FAR = 20.0
"""Deviation [%] from which on the scale is logarithmic beyond the band of agreement."""

TICKS = (5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000)
NUMBERS = 0.3
"""Room for the number of a bar, over the length of the bars."""

POINTS: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 4}
"""The cases of a sample, between which there is nothing."""

PAPER: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 1}
BAND: dict[str, Any] = {"facecolor": "#e8efe6", "edgecolor": "none", "zorder": 0}


def over_axis(
    figure: Figure, grid: GridSpec, made: Comparison, view: View, looks: Mapping[str, Style]
) -> None:
    """Draw T_a and its deviation over what is swept, one scale for all rows."""
    left, right = None, None
    values: list[float] = []
    for at, panel in enumerate(view.panels, 1):
        left = figure.add_subplot(grid[at, 0], sharey=left)
        right = figure.add_subplot(grid[at, 1], sharey=right)
        _titles(left, right, made, panel.title)
        for line in panel.lines:
            style = {**looks[line.label], **(POINTS if view.sampled else {"markersize": 4})}
            x, y = ink.series(view, line, T_a)
            ink.curve(left, x, y, style, line.label)
            bands.band(left, x, y, ink.series(view, line, _width)[1], style)
            if line.label != made.yardstick:
                x, y, width = _deviations(made, view, panel, line.label)
                ink.curve(right, x, y, style, line.label)
                bands.band(right, x, y, width, style)
                values += y
        left.axhline(1.0, **ink.UNITY)
        right.axhspan(-AGREE, AGREE, **BAND, label=f"within ±{AGREE:g} %")
        right.axhline(0.0, **ink.UNITY)
        ink.gaps(left, view, panel)
        for axes in (left, right):
            scales.along(axes, view, named=at == len(view.panels))
    if left and right:
        left.set_ylim(bottom=0.0)
        _scale(right, values)


def _titles(left: Axes, right: Axes, made: Comparison, title: str = "") -> None:
    """Name what two panels show."""
    words, beside = (f"{title}: ", "") if title else ("", f" from {made.yardstick}")
    ink.name(left, f"{words}$T_a$ [–]")
    ink.name(right, f"{words}deviation of $T_a${beside} [%]")


def T_a(row: Row) -> float | None:
    """Give T_a of a row; None where it is not known."""
    return row.metrics.get("T_a") if row.status == OK else None


def _width(row: Row) -> float | None:
    """Give half the interval of T_a, where it is a mean over many seeds."""
    return row.half_widths.get("T_a")


def _deviations(
    made: Comparison, view: View, panel: Panel, name: str
) -> tuple[list[float], list[float], list[float]]:
    """Give the deviation of an approach [%] along the axis, and half of its intervals."""
    found = [
        (view.x(one.row), 100.0 * one.value, 100.0 * (one.half_width or nan))
        for one in survey.deviations(made, name)
        if all(one.row.point.get(key, value) == value for key, value in panel.point.items())
    ]
    found.sort()
    return [x for x, _, _ in found], [y for _, y, _ in found], [w for _, _, w in found]


def _scale(axes: Axes, values: Sequence[float]) -> None:
    """Make a scale on which both small and large deviations can be read."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    if max(high, -low) <= FAR:
        return
    axes.set_yscale("symlog", linthresh=AGREE, linscale=0.7)
    above = [tick for tick in TICKS if tick <= max(high, AGREE)]
    ticks = [*(-tick for tick in TICKS if -tick >= min(low, -AGREE)), 0, *above]
    axes.set_yticks(ticks, labels=[scales.numeral(tick) for tick in ticks])
    axes.minorticks_off()


def as_bars(
    figure: Figure, grid: GridSpec, made: Comparison, looks: Mapping[str, Style]
) -> None:
    """Draw T_a and its deviation of one case as bars, with their numbers."""
    left, right = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    _titles(left, right, made)
    rows = {row.approach: row for row in made.table.rows}
    places = {name: -at for at, name in enumerate(rows)}
    for name, row in rows.items():
        value, color = T_a(row), looks[name]["color"]
        left.barh(places[name], value or 0.0, color=color, height=0.6)
        _note(left, value or 0.0, places[name], wording.number(value))
        off = made.deviation(row)
        if name != made.yardstick and off is not None:
            right.barh(places[name], 100.0 * off, color=color, height=0.6)
            _note(right, 100.0 * off, places[name], f"{100.0 * off:+.3g} %")
    left.axvline(1.0, **ink.UNITY)
    right.axvspan(-AGREE, AGREE, **BAND, label=f"within ±{AGREE:g} %")
    right.axvline(0.0, **ink.UNITY)
    for axes in (left, right):
        axes.set_yticks(list(places.values()), labels=list(places) if axes is left else [])
        axes.set_ylim(-len(rows) + 0.4, 0.6)
        _room(axes)
        axes.grid(visible=False, axis="y")


def _room(axes: Axes) -> None:
    """Make room for the numbers beyond the bars, on the side of zero where there are any."""
    low, high = axes.dataLim.intervalx
    beyond = NUMBERS * (max(high, 0.0) - min(low, 0.0))
    axes.set_xlim(low - beyond * (low < 0.0), high + beyond)


def _note(axes: Axes, value: float, place: float, words: str) -> None:
    """Write the number of a bar beyond its end."""
    beyond, side = (4, "left") if value >= 0 else (-4, "right")
    axes.annotate(
        words, (value, place), xytext=(beyond, 0), textcoords="offset points",
        ha=side, va="center", size=9, bbox=PAPER,
    )  # fmt: skip
