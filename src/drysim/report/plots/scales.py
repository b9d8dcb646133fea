"""How axes are scaled: logarithmic over a decade, and the frequencies that matter marked."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, isnan, sqrt
from typing import TYPE_CHECKING, Any

from drysim.wording import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from drysim.report.plots.views import View

DECADE = 10.0
"""Span from which on an axis is logarithmic."""

LETTERS, MOST = 44, 99
"""Letters that fit below a panel, two between its numbers; and more numbers than fit."""

FREQUENCIES: dict[str, Any] = {
    "color": "#909090", "linewidth": 0.8, "linestyle": (0, (1, 2)), "zorder": 1
}  # fmt: skip


def wide(values: Iterable[float]) -> bool:
    """Whether values span a decade, all above zero."""
    low, high = inf, -inf
    for value in values:
        low, high = min(low, value), max(high, value)
    return low > 0 and high >= DECADE * low


def along(axes: Axes, view: View, named: bool) -> None:
    """Make the axis of the swept key: logarithmic where it spans a decade."""
    rows = [row for panel in view.panels for line in panel.lines for row in line.rows]
    x = [value for row in rows if not isnan(value := view.x(row))]
    if wide(x):
        axes.set_xscale("log")
        decades(axes.xaxis, min(x), max(x))
    else:
        plain(axes.xaxis)
    if x and min(x) < max(x):
        axes.set_xlim(min(x), max(x))
    axes.tick_params(labelbottom=named)
    if named:
        axes.set_xlabel(view.label)


def decades(axis: Any, low: float, high: float) -> None:
    """Name 1, 2 and 5 of every decade of a logarithmic axis; 1 alone where more is too much."""
    from matplotlib.ticker import LogLocator

    def some(*steps: float) -> LogLocator:
        return LogLocator(subs=steps, numticks=MOST)

    named = [x for x in some(1.0, 2.0, 5.0).tick_values(low, high) if low <= x <= high]
    letters = sum(len(number(x)) + 2 for x in named)
    axis.set_major_locator(some(1.0, 2.0, 5.0) if letters <= LETTERS else some(1.0))
    axis.set_major_formatter(lambda x, _: number(x))
    axis.minorticks_off()


def plain(axis: Any) -> None:
    """Number the axis of a key in full: no power of ten apart, which a title could hide."""
    axis.set_major_formatter(lambda x, _: numeral(x))


def numeral(x: float) -> str:
    """Give a number as it stands at an axis, with a minus as long as its digits are wide."""
    return number(x, digits=8).replace("-", "\N{MINUS SIGN}")


def frequencies(axes: Axes, f_0: float) -> None:
    """Mark the natural frequency, and where a viscous isolator begins to isolate."""
    low, high = axes.get_xlim()
    for words, f, side in (("$f_0$", f_0, "right"), ("$\\sqrt{2}f_0$", sqrt(2) * f_0, "left")):
        if low < f < high:
            axes.axvline(f, **FREQUENCIES)
            foot = axes.get_xaxis_transform()
            axes.text(f, 1.01, words, transform=foot, size=8, ha=side)
