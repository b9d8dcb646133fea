"""The panels of a sweep: metrics over what is swept, a row for each panel of its view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi, sqrt
from typing import TYPE_CHECKING

from drysim.report.plots import bands, canvas, heading, ink, layout, scales
from drysim.report.plots.labels import key_label
from drysim.report.plots.shown import STROKE, T_A
from drysim.study.sweeps.survey import FREQUENCY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.report.plots.shown import Shown
    from drysim.report.plots.views import Panel, View
    from drysim.study.sweeps.table import Table

STEEP = 100.0
"""Greatest over least value from which on T_a is drawn logarithmically."""

TUNING = {"oscillator.mass", "oscillator.stiffness"}
"""Keys that move the natural frequency."""

RIGHT = 0.965
"""Where panels end, so that half of the last number below them has room."""

BAR, ASIDE, LABEL, LETTER = 0.16, 0.2, 0.36, 0.09
"""Width of a bar of colours, room beside it, room of its label with its gaps, and of a letter
of its numbers [inch]."""


def over_sweep(
    table: Table,
    drawn: View,
    quantities: Sequence[Shown],
    extra: Callable[[Axes, Panel, Shown], None],
) -> Figure:
    """Give a picture with a row for each panel of the view, a column for each quantity."""
    count = len(drawn.panels)
    coloured = drawn.line is not None and len(drawn.panels[0].lines) > ink.FEW_LINES
    figure, grid = layout.sheet(count, len(quantities), right=RIGHT)
    for place, quantity in enumerate(quantities):
        first = None
        for at, panel in enumerate(drawn.panels):
            # One scale for all rows: they are there to be compared.
            axes = first = figure.add_subplot(grid[at, place], sharey=first)
            words = f"{panel.title}: {quantity.symbol}" if panel.title else quantity.words
            ink.name(axes, words, pad=15)
            scales.along(axes, drawn, named=at == count - 1)
            ink.curves(axes, drawn, panel, quantity.of)
            bands.along(axes, drawn, panel, quantity.of, quantity.width)
            extra(axes, panel, quantity)
            ink.gaps(axes, drawn, panel)
            _marks(axes, table, drawn)
        assert first is not None, "a view has a panel"
        values = list(ink.known(drawn, quantity.of))
        if not values:
            first.text(0.5, 0.5, "not known", transform=first.transAxes, ha="center")
        _upright(first, values, steeply=quantity is T_A)
    unnamed = {line.label for line in drawn.panels[0].lines}
    of_stroke = any(quantity.metric == STROKE for quantity in quantities)
    head = heading.of_table(table, drawn.left_out, of_stroke=of_stroke)
    if not coloured:
        layout.complete(figure, grid, head)
        return figure
    bar, left = _colours(figure, drawn)
    grid.update(right=left - ASIDE / canvas.WIDTH)
    bottom, top = layout.complete(figure, grid, head, unnamed)
    bar.set_position((left, bottom, BAR / canvas.WIDTH, top - bottom))
    return figure


def _upright(axes: Axes, values: Sequence[float], steeply: bool) -> None:
    """Let panels of one scale begin at 0; some are logarithmic where their values are steep."""
    if steeply and values and 0 < STEEP * min(values) <= max(values):
        axes.set_yscale("log")
        scales.decades(axes.yaxis, *axes.get_ylim())
    else:
        panels = axes.get_shared_y_axes().get_siblings(axes)
        flat = not any(panel.dataLim.y1 > 0.0 for panel in panels)
        axes.set_ylim(0.0, 1.0 if flat else None)


def _marks(axes: Axes, table: Table, drawn: View) -> None:
    """Mark the frequencies of the oscillator, where all cases share one."""
    varied = {axis.key for axis in table.axes if len(axis.values) > 1}
    plant = table.scenario.oscillator.plant()
    if drawn.key == FREQUENCY and not varied & TUNING and plant.k_x > 0:
        scales.frequencies(axes, sqrt(plant.k_x / plant.m) / (2 * pi))


def _colours(figure: Figure, drawn: View) -> tuple[Axes, float]:
    """Draw the scale by which many lines are coloured.

    Returns its panel, and how far left it must begin for its numbers and its label.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.ticker import MaxNLocator

    assert drawn.line is not None
    axes = figure.add_axes((0.9, 0.1, 0.02, 0.8))
    norm, colours = ink.scale(drawn.line)
    bar = figure.colorbar(ScalarMappable(norm, colours), cax=axes)
    bar.set_label(key_label(drawn.line))
    if scales.wide(drawn.line.values):
        scales.decades(axes.yaxis, norm.vmin, norm.vmax)
    else:
        axes.yaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
        scales.plain(axes.yaxis)
    ticks = [x for x in axes.yaxis.get_majorticklocs() if norm.vmin <= x <= norm.vmax]
    letters = max((len(scales.numeral(x)) for x in ticks), default=0)
    return axes, 1.0 - (BAR + LABEL + LETTER * letters) / canvas.WIDTH
