"""Draw a metric over two keys as a map, with the region in which a limit is exceeded.

Designs, sweeps of two keys and quantiles share it. `draw_levels` interpolates between values
that are close to each other and known everywhere. `draw_cells` does not: each value has a cell
of its own, and the limit is known no better than by the edges of cells. Both return what a
colour bar shows; scales and labels of the axes are the caller's.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.metrics.checks import LEAST_EXCESS
from drysim.plots.style import Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEIGHT = 5.125
"""Height of a map [inch]."""

LEVELS, SHOWN_SHARE = 20, 0.98
"""Levels of a map, and the share of the admissible values between them."""

MISSING_COLOR, LINE_COLOR = "#d9d9d9", "#707070"
"""Colours of cells without a value, and of contour lines beyond a limit."""

EXCLUDED_STYLE: Style = {"facecolor": "#d9d9d9", "edgecolor": "#b3b3b3", "hatch": "///"}
LIMIT_STYLE: Style = {"colors": "black", "linewidths": 1.4}


def draw_levels(axes: Axes, x: Floats, y: Floats, values: Floats, excess: Floats) -> Any:
    """Draw filled levels between contour lines, and the limit where the excess is 0.

    Parameters
    ----------
    axes : Axes
    x, y : ndarray, shape (nx,) and (ny,)
        Values of the keys.
    values, excess : ndarray, shape (ny, nx)
        Displayed metric, and by how much limits are exceeded; 0 or less where all are kept.
    """
    from matplotlib.ticker import MaxNLocator

    excluded = excess > 0.0
    shown = values if excluded.all() else values[~excluded]
    levels = MaxNLocator(LEVELS).tick_values(shown.min(), np.quantile(shown, SHOWN_SHARE))
    filled = axes.contourf(x, y, values, levels=levels, extend="both", cmap="viridis")
    # White lines reach beyond the limit, where the region hides them.
    for inside, color, order in (
        (with_neighbours(~excluded), "white", 1.1), (excluded, LINE_COLOR, 1.3)
    ):  # fmt: skip
        if inside.any():
            part = np.ma.masked_where(~inside, values)
            style: Style = {"colors": color, "linewidths": 0.6, "zorder": order}
            for label in axes.clabel(
                axes.contour(x, y, part, levels[::2], **style), fontsize=8
            ):
                right, top = label.get_position()
                column, row = np.searchsorted(x[1:-1], right), np.searchsorted(y[1:-1], top)
                if excluded[row, column] != (color == LINE_COLOR):
                    label.remove()
    if excluded.any():
        fill = "none" if excluded.all() else [EXCLUDED_STYLE["facecolor"]]
        hatches = [EXCLUDED_STYLE["hatch"]]
        edge = 0.5 * LEAST_EXCESS  # at 0 the limit is kept; contourf takes in a minimum of 0
        levels = [edge, 1.0 + excess.max()]  # the upper one is out of reach
        region: Any = axes.contourf(
            x, y, excess, levels=levels, colors=fill, hatches=hatches, zorder=1.2
        )
        region.set(edgecolor=EXCLUDED_STYLE["edgecolor"], linewidth=0.0)
        axes.contour(x, y, excess, levels=[edge], zorder=1.4, **LIMIT_STYLE)
    label_limit(axes, excluded)
    axes.grid(visible=False)
    return filled


def with_neighbours(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask with the points beside, above and below its own."""
    grown = mask.copy()
    grown[1:] |= mask[:-1]
    grown[:-1] |= mask[1:]
    grown[:, 1:] |= mask[:, :-1]
    grown[:, :-1] |= mask[:, 1:]
    return grown


def draw_cells(
    axes: Axes, x: Floats, y: Floats, values: Floats, excluded: NDArray[np.bool_]
) -> Any:
    """Draw a cell for each value, and the limit along the edges of cells.

    Parameters
    ----------
    axes : Axes
    x, y : ndarray, shape (nx + 1,) and (ny + 1,)
        Edges of the cells.
    values : ndarray, shape (ny, nx)
        Displayed metric; NaN where it is not known.
    excluded : ndarray of bool, shape (ny, nx)
        Where a limit is exceeded.
    """
    from matplotlib.collections import LineCollection, PolyCollection

    has_value = np.isfinite(values)
    mesh = axes.pcolormesh(x, y, np.ma.masked_invalid(values), cmap="viridis", rasterized=True)
    if not has_value.all():
        axes.set_facecolor(MISSING_COLOR)
        axes.plot([], [], "s", color=MISSING_COLOR, markersize=9, label="no case with a value")
    excluded = excluded & has_value
    if excluded.any():
        corners = [
            [(x[i + a], y[j + b]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            for j, i in np.argwhere(excluded).tolist()
        ]
        axes.add_collection(
            PolyCollection(corners, **EXCLUDED_STYLE, linewidth=0.0, alpha=0.5), autolim=False
        )
        edges = LineCollection(limit_edges(x, y, has_value, excluded), **LIMIT_STYLE)
        axes.add_collection(edges, autolim=False)
    label_limit(axes, excluded)
    axes.grid(visible=False)
    return mesh


def limit_edges(
    x: Floats, y: Floats, has_value: NDArray[np.bool_], excluded: NDArray[np.bool_]
) -> list[list[tuple[float, float]]]:
    """Return the edges between neighbouring known cells of which only one is excluded."""
    side = np.where(excluded, 1, -1) * has_value
    upright = np.argwhere(side[:, 1:] * side[:, :-1] < 0).tolist()
    level = np.argwhere(side[1:] * side[:-1] < 0).tolist()
    return [
        *([(x[i + 1], y[j]), (x[i + 1], y[j + 1])] for j, i in upright),
        *([(x[i], y[j + 1]), (x[i + 1], y[j + 1])] for j, i in level),
    ]


def add_bar(axes: Axes, drawn: Any, label: str) -> None:
    """Add a colour bar beside a map."""
    levels = getattr(drawn, "levels", None)
    ticks = None if levels is None else levels[::2]
    bar = axes.figure.colorbar(drawn, ax=axes, aspect=25, pad=0.02, ticks=ticks)
    bar.set_label(label)


def label_limit(axes: Axes, excluded: NDArray[np.bool_]) -> None:
    """Add legend entries of the excluded region and of the line around it."""
    if excluded.any():
        axes.fill_between([], [], [], **EXCLUDED_STYLE, linewidth=0.0, label="exceeds a limit")
    if excluded.any() and not excluded.all():
        line = {"color": LIMIT_STYLE["colors"], "linewidth": LIMIT_STYLE["linewidths"]}
        axes.plot([], [], **line, label="limit")
