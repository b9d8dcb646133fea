"""The pictures of many cases: quantile bands along a swept key, and a map of the mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim import wording
from drysim.report.plots import heading, ink, layout, panels, scales
from drysim.report.plots.labels import key_label
from drysim.report.plots.scatter import Bins, Scatter, gathered
from drysim.report.plots.shown import STROKE
from drysim.report.plots.views import along_axis
from drysim.scenario.sweep.drawn import Drawn
from drysim.study.sweeps.rows import HELD, batches_of
from drysim.study.sweeps.table import LIMIT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.shown import Shown
    from drysim.study.sweeps.table import Table

BANDS = ((0.05, 0.95, "#c9d8e8", "90 % of the cases"), (0.25, 0.75, "#8fb0d0", "half of them"))
MEDIAN: dict[str, Any] = {"color": "#0b3c6f", "linewidth": 1.6, "label": "median"}

LEFT, LEFT_OF_MAPS, RIGHT = 0.075, 0.1, 0.92
"""Where panels begin and end, so that numbers and words beside a map have room."""

BETWEEN_MAPS = 0.4
"""Room between two maps, in widths of one [-]: the bar of the left, the key of the right."""


def scattered(table: Table) -> bool:
    """Tell whether a table is drawn as bands: too many cases for lines, or none that are."""
    return len(table.rows) > HELD or any(isinstance(axis.values, Drawn) for axis in table.axes)


def draw(table: Table, quantities: Sequence[Shown]) -> Figure:
    """Give the picture of some metrics.

    Parameters
    ----------
    table : Table
    quantities : sequence of Shown
        What is drawn, a column each.
    """
    along = along_axis(table.axes)
    assert along is not None, "a sweep has a key"
    others = [axis for axis in table.axes if axis is not along and len(axis.values) > 1]
    other = max(others, key=lambda axis: len(axis.values), default=None)
    bins, across = Bins.of(along), None if other is None else Bins.of(other)
    approach, *references = table.approaches
    found = [Scatter(one.metric, bins, across) for one in quantities]
    gathered(batches_of(table.rows), approach, found)
    beside = [Scatter(one.metric, bins, None) for one in quantities]
    if references:
        gathered(batches_of(table.rows), references[0], beside)
    shown = [i for i, one in enumerate(found) if one.counts.any()] or [len(found) - 1]
    if across is None:
        figure, grid = layout.sheet(1, len(shown), LEFT, RIGHT)
    else:
        figure, grid = layout.sheet(2, len(shown), LEFT_OF_MAPS, RIGHT, aside=BETWEEN_MAPS)
    for place, i in enumerate(shown):
        quantity = quantities[i]
        axes = figure.add_subplot(grid[0, place])
        ink.name(axes, quantity.words)
        bands(axes, found[i], beside[i] if references else None, quantity.scale)
        bound(axes, table, quantity)
        along_bins(axes, bins, named=across is None)
        if across is not None:
            below = figure.add_subplot(grid[1, place])
            ink.name(below, f"mean of {quantity.words}")
            mapped(figure, below, found[i], quantity.scale)
    of_stroke = any(quantity.metric == STROKE for quantity in quantities)
    layout.complete(figure, grid, heading.of_table(table, of_stroke=of_stroke))
    return figure


def bands(axes: Axes, found: Scatter, reference: Scatter | None, factor: float) -> None:
    """Draw how a metric scatters in every bin."""
    x = found.along.x
    for low, high, colour, words in BANDS:
        ends = found.curve(low) * factor, found.curve(high) * factor
        axes.fill_between(x, *ends, color=colour, linewidth=0, label=words)
    axes.plot(x, found.curve(0.5) * factor, **MEDIAN)
    if reference is not None and reference.counts.any():
        words = "median without dry friction"
        axes.plot(x, reference.curve(0.5) * factor, **ink.REFERENCE, label=words)


def bound(axes: Axes, table: Table, quantity: Shown) -> None:
    """Draw the stroke limit all cases share, or the line at which nothing is gained."""
    stroke = table.scenario.stroke
    axes.set_ylim(bottom=0.0)
    if quantity.metric != STROKE:
        axes.axhline(1.0, **ink.UNITY)
    elif any(axis.key == LIMIT for axis in table.axes):
        return
    elif stroke is not None and stroke.limit * quantity.scale <= 2.0 * axes.get_ylim()[1]:
        limit = stroke.limit * quantity.scale
        words = f"stroke limit {wording.number(limit, quantity.unit)}"
        axes.axhline(limit, **panels.LIMIT, label=words)
        axes.set_ylim(top=max(axes.get_ylim()[1], 1.05 * limit))


def along_bins(axes: Axes, bins: Bins, named: bool) -> None:
    """Make the axis of the swept key."""
    axes.set_xlim(bins.fences[0], bins.fences[-1])
    _scale(axes.set_xscale, axes.xaxis, bins)
    axes.tick_params(labelbottom=named)
    if named:
        axes.set_xlabel(key_label(bins.axis))


def _scale(set_scale: Callable[[str], None], axis: Any, bins: Bins) -> None:
    """Spread and number the axis of a swept key as its bins are."""
    if bins.even_in_ratio:
        set_scale("log")
        scales.decades(axis, bins.fences[0], bins.fences[-1])
    else:
        scales.plain(axis)


def mapped(figure: Figure, axes: Axes, found: Scatter, factor: float) -> None:
    """Draw the mean over two swept keys, the key across named: a bar of colours is near it."""
    from matplotlib.ticker import MaxNLocator

    assert found.across is not None, "a map has two axes"
    x, y = found.along.fences, found.across.fences
    values = np.ma.masked_invalid(found.map * factor)
    mesh = axes.pcolormesh(x, y, values, cmap="viridis", rasterized=True)
    along_bins(axes, found.along, named=True)
    axes.set_ylim(y[0], y[-1])
    _scale(axes.set_yscale, axes.yaxis, found.across)
    axes.set_ylabel(key_label(found.across.axis))
    axes.grid(visible=False)
    bar = figure.colorbar(mesh, cax=axes.inset_axes((1.015, 0.0, 0.025, 1.0)))
    # The numbers stand in a narrow margin.
    bar.ax.yaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
