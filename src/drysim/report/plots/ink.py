"""How curves over a swept key are drawn: lines told apart in grey as well, and gaps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from math import inf, isclose, isfinite, isnan, nan
from typing import TYPE_CHECKING, Any

from drysim.report.plots import scales
from drysim.report.plots.views import View
from drysim.study.sweeps.table import FAILED, NOT_SETTLED, NOT_UNIQUE, OK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from drysim.report.plots.views import Line, Panel
    from drysim.scenario import Axis
    from drysim.study.sweeps.table import Row

Value = Callable[["Row"], float | None]
Style = dict[str, Any]

FEW_LINES = 8
"""Lines up to which each has a style of its own; more are coloured by their value."""

FEW_POINTS, MARKS = 20, 0.12
"""Points up to which each is marked; beyond, how far marks are apart [diagonals of a panel]."""

LIGHTEST = 0.82
"""Part of the colour map that is dark enough on white."""

MARKERS = "os^DvPX*"
REFERENCE: Style = {"color": "black", "linewidth": 1.3, "linestyle": (0, (4, 2))}
FAINT: Style = {"color": "#6b6b6b", "linewidth": 0.9, "linestyle": (0, (4, 2))}
UNITY: Style = {"color": "#404040", "linewidth": 0.8, "zorder": 1}
GAPS: dict[str, Style] = {
    NOT_SETTLED: {"marker": "x", "color": "black"},
    NOT_UNIQUE: {"marker": "o", "color": "black", "fillstyle": "none"},
    FAILED: {"marker": "P", "color": "#b3261e"},
}
OTHER_GAP: Style = {"marker": "1", "color": "black"}


def styles(view: View) -> list[Style]:
    """Give a style to every line of a panel: by lightness, and by marks where lines are few."""
    import matplotlib

    colours = matplotlib.colormaps["viridis"]
    lines = view.panels[0].lines
    if view.line is None:
        return [{"color": "#0b3c6f", "linewidth": 1.6, "marker": "o", "markersize": 3.5}]
    if len(lines) > FEW_LINES:
        norm, many = scale(view.line)
        return [{"color": many(norm(line.value)), "linewidth": 1.0} for line in lines]
    steps = max(len(lines) - 1, 1)
    return [
        {"color": colours(LIGHTEST * at / steps), "linewidth": 1.5,
         "marker": MARKERS[at], "markersize": 4}
        for at in range(len(lines))
    ]  # fmt: skip


def scale(axis: Axis) -> tuple[Any, Any]:
    """Give the scale on which values become colours, and the colours."""
    import matplotlib
    from matplotlib.colors import ListedColormap, LogNorm, Normalize

    low, high = min(axis.values), max(axis.values)
    dark = matplotlib.colormaps["viridis"]([LIGHTEST * at / 255 for at in range(256)])
    return (LogNorm if scales.wide(axis.values) else Normalize)(low, high), ListedColormap(dark)


def curves(axes: Axes, view: View, panel: Panel, value: Value) -> None:
    """Draw the lines of a panel, a gap and a mark wherever the value is not known."""
    looks = styles(view)
    for at, (line, style) in enumerate(zip(panel.lines, looks, strict=True)):
        x, y = series(view, line, value)
        curve(axes, x, y, style, line.label, at)
    references(axes, view, panel, value, looks)


def curve(
    axes: Axes, x: Sequence[float], y: Sequence[float], style: Style, label: str, at: int = 0
) -> None:
    """Draw one line, its marks apart from those of its neighbours; level where x is nan."""
    if x and isnan(x[0]):
        axes.axhline(y[0], **{**style, "marker": ""}, label=label)
        return
    few = sum(map(isfinite, y)) <= FEW_POINTS or style.get("linestyle") == "none"
    every = 1 if few else (0.03 * at, MARKS)
    axes.plot(x, y, **style, markevery=every, label=label, clip_on=False)
    if alone := [i for i in range(len(y)) if _alone(y, i)]:
        points = [x[i] for i in alone], [y[i] for i in alone]
        axes.plot(*points, "o", markersize=3, color=style["color"], clip_on=False)


def references(
    axes: Axes, view: View, panel: Panel, value: Value, looks: Sequence[Style]
) -> None:
    """Draw the reference dashed: once where it is the same for all lines."""
    drawn = [(line, *series(view, line, value)) for line in panel.references]
    one = all(_same(y, drawn[0][2]) for _, _, y in drawn)
    if not drawn or (not one and len(panel.lines) > FEW_LINES):
        return
    words = f"{panel.references[0].label}, no dry friction"
    if one:
        curve(axes, *drawn[0][1:], REFERENCE, words)
        return
    # In the legend grey stands for the dashes of every colour.
    axes.plot([], [], **FAINT, label=words)
    for at, (_, x, y) in enumerate(drawn):
        curve(axes, x, y, {**FAINT, "color": looks[at % len(looks)]["color"]}, "_")


def _same(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two curves are one to the eye."""
    return len(one) == len(other) and all(
        isclose(a, b, rel_tol=1e-6) or a != a or b != b for a, b in zip(one, other, strict=True)
    )


def _alone(y: Sequence[float], at: int) -> bool:
    """Whether a point stands between two gaps, where no line shows it."""
    beside = [y[i] for i in (at - 1, at + 1) if 0 <= i < len(y)]
    return isfinite(y[at]) and not any(map(isfinite, beside))


def series(view: View, line: Line, value: Value) -> tuple[list[float], list[float]]:
    """Give a line along the axis, in its order; nan is a gap."""
    found = [(view.x(row), _number(value(row))) for row in line.rows]
    found.sort(key=lambda pair: -inf if isnan(pair[0]) else pair[0])
    return [x for x, _ in found], [y for _, y in found]


def _number(value: float | None) -> float:
    return nan if value is None or not isfinite(value) else float(value)


def gaps(axes: Axes, view: View, panel: Panel) -> None:
    """Mark at the foot of a panel where there is no number, and why."""
    lost = [row for line in panel.lines for row in line.rows if row.status != OK]
    for status, count in Counter(row.status for row in lost).items():
        x = [view.x(row) for row in lost if row.status == status]
        axes.plot(
            x, [0.025] * count, transform=axes.get_xaxis_transform(), linestyle="none",
            markersize=5, clip_on=False, label=status, **GAPS.get(status, OTHER_GAP),
        )  # fmt: skip


def name(axes: Axes, words: str, pad: float = 6.0) -> None:
    """Say above a panel what it shows; that its place is given spares looking for one."""
    axes.set_title(words, loc="left", pad=pad, y=1.0)
    axes.yaxis.set_offset_position("right")


def known(view: View, value: Value) -> Iterator[float]:
    """Give every value of the lines of a view that is known."""
    for panel in view.panels:
        for line in panel.lines:
            for row in line.rows:
                if (found := value(row)) is not None and isfinite(found):
                    yield found
