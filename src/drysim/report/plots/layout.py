"""Where things stand in a picture of rows of panels: heading above, legend below."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from math import ceil
from typing import TYPE_CHECKING, Any

from drysim.report.plots import canvas, heading

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec

    from drysim.report.plots.heading import Lines

ALONE, STACKED = 3.3, 2.3
"""Height of a row of panels [inch]: the only one, and one of several."""

GAP, FOOT, LINE = 0.62, 0.52, 0.21
"""Room above a row of panels, below the lowest one, and of a line of the legend [inch]."""

ASIDE = 0.17
"""Room between two panels, in widths of one [-]."""

HANDLE, LETTER, ROOM = 0.62, 0.077, 8.8
"""Widths in a legend [inch]: a line with its gaps, a letter, and all there is."""


def sheet(
    rows: int,
    columns: int,
    left: float = 0.075,
    right: float = 0.98,
    gap: float = GAP,
    aside: float = ASIDE,
) -> tuple[Figure, GridSpec]:
    """Give an empty picture, and room for its panels.

    `gap` [inch] is between their rows, `aside` [panels] between their columns.
    """
    figure = canvas.blank(rows * _row(rows))
    grid = figure.add_gridspec(
        rows, columns, left=left, right=right, wspace=aside, hspace=gap / _row(rows)
    )
    return figure, grid


def complete(
    figure: Figure, grid: GridSpec, words: Lines, unnamed: Collection[str] = ()
) -> tuple[float, float]:
    """Give a picture its height, heading and legend; tells where its panels begin and end.

    Parameters
    ----------
    figure, grid
        As `sheet` gave them, the panels drawn.
    words : Lines
        The heading.
    unnamed : collection of str
        Labels that the legend leaves out.
    """
    known = entries(figure.axes, unnamed)
    lines = ceil(sum(map(_width, known)) / ROOM)
    foot = FOOT + LINE * lines + 0.06
    row = _row(grid.nrows)
    between = (grid.nrows - 1) * (grid.hspace or 0.0) * row
    body = foot + grid.nrows * row + between + GAP
    tall = body + heading.height(words) - 0.2
    figure.set_figheight(tall)
    bottom, top = foot / tall, (body - GAP) / tall
    grid.update(bottom=bottom, top=top)
    for axes in figure.axes:
        if (spot := axes.get_subplotspec()) is not None:
            axes.set_position(spot.get_position(figure))
    heading.write(figure, words)
    if known:
        legend(figure, known, columns=ceil(len(known) / lines), length=2.4)
    return bottom, top


def legend(figure: Figure, known: Mapping[str, Any], columns: int, length: float) -> None:
    """Name lines below all panels, each behind a piece of so many letters."""
    figure.legend(
        list(known.values()), list(known), loc="lower center", ncols=columns, frameon=False,
        fontsize=9, borderaxespad=0.3, columnspacing=1.2, handletextpad=0.5,
        handlelength=length,
    )  # fmt: skip


def _row(rows: int) -> float:
    return ALONE if rows == 1 else STACKED


def entries(panels: Iterable[Axes], unnamed: Collection[str] = ()) -> dict[str, Any]:
    """Give the labelled lines of panels, each once."""
    known: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            if label not in unnamed:
                known.setdefault(label, handle)
    return known


def _width(label: str) -> float:
    """Give about how wide an entry of the legend is [inch]."""
    return HANDLE + LETTER * len(re.sub(r"[$\\_{}]", "", label))
