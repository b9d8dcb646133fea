"""The confidence intervals of means over many seeds, as bands along their curves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.report.plots import ink

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from drysim.report.plots.ink import Style, Value
    from drysim.report.plots.views import Panel, View

LABEL = "95 % confidence interval of a mean over seeds"

FAINT: dict[str, Any] = {"alpha": 0.3, "linewidth": 0.0, "zorder": 1.5}


def along(axes: Axes, view: View, panel: Panel, value: Value, width: Value) -> None:
    """Draw the bands of a panel, where its lines are few and their values are means."""
    if len(panel.lines) > ink.FEW_LINES:
        return
    for line, style in zip(panel.lines, ink.styles(view), strict=True):
        x, y = ink.series(view, line, value)
        band(axes, x, y, ink.series(view, line, width)[1], style)


def band(
    axes: Axes, x: Sequence[float], y: Sequence[float], width: Sequence[float], style: Style
) -> None:
    """Draw a band of half-widths about a curve, if it has any."""
    middle, half = np.array(y), np.array(width)
    if np.isfinite(half).any():
        edges = middle - half, middle + half
        axes.fill_between(x, *edges, color=style["color"], label=LABEL, **FAINT)
