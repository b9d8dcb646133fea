"""The pictures of a sweep, transmissibility.png and stroke.png: metrics over swept keys.

Along the axis goes the frequency, else the key that varies fastest; of the others the one with
most values tells lines apart and the rest panels (`View`), in the symbols of the paper where it
has some. Few lines are told apart in grey as well, many are coloured by their value. An axis is
logarithmic over a decade, and the frequencies that matter are marked. Where a value is not
known the line has a gap, and a mark at the foot of the panel says why; means over many seeds
have their confidence interval as a band.

Too many cases for lines, and samples, are drawn as quantile bands along a key, above a map of
the mean over two: the cases are counted block by block as they are read and never held together
(`Scatter`). Views, curves and axes serve the other pictures, too.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, inf, isclose, isfinite, isnan, isqrt, log, nan, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.approach.solution import Floats
from drysim.core.model import Stopped
from drysim.plots import response, style
from drysim.plots.style import FORCE, HIT, STROKE, T_A, T_X, Shown, Style, peak
from drysim.scenario.axes import Axis, Spread, walks
from drysim.scenario.axes import points as every_point
from drysim.scenario.sampling import Distribution, Drawn, LogNormal, Normal
from drysim.study.compare import FREQUENCY, Comparison
from drysim.study.statistics import (
    FAILED,
    HELD,
    LIMIT,
    NOT_SETTLED,
    NOT_UNIQUE,
    OK,
    Batch,
    Row,
    batches_of,
)
from drysim.study.table import Table, stroke_limit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def transmissibility(table: Table, folder: Path) -> None:
    """Write transmissibility.png: T_x on the left, T_a on the right, as in the paper.

    Parameters
    ----------
    table : Table
    folder : Path
        Where to write.
    """
    style.paint(lambda: draw_transmissibility(table), folder / "transmissibility.png")


def draw_transmissibility(table: Table) -> Figure:
    """Give the picture of the transmissibilities, not yet rendered."""
    if scattered(table):
        return draw_many(table, [T_X, T_A])
    drawn = view(table)
    known = [one for one in (T_X, T_A) if any(True for _ in known_values(drawn, one.of))]

    def unity(axes: Axes, panel: Panel, quantity: Shown) -> None:
        axes.axhline(1.0, **UNITY)

    return over_sweep(table, drawn, known or [T_A], unity)


def stroke(table: Table, folder: Path) -> None:
    """Write stroke.png: the peak of |x_r|, its limit, and where that is met."""
    style.paint(lambda: draw_stroke(table), folder / "stroke.png")


def draw_stroke(table: Table) -> Figure:
    """Give the picture of the stroke, not yet rendered."""
    ends = table.tallies[table.approaches[0]].ends if table.rows else {}
    told = peak(ends.get(STROKE, (0.0, 0.0))[1])
    if scattered(table):
        return draw_many(table, [told])
    # Where there are stops, |x_r| hardly tells one case from another.
    law = table.scenario.law()
    hits = [HIT if law.rigid else FORCE] if isinstance(law, Stopped) else []
    drawn = view(table)
    top = max(known_values(drawn, told.of), default=0.0)

    def bound(axes: Axes, panel: Panel, quantity: Shown) -> None:
        if quantity is not told:
            return
        _limit(axes, table, drawn, panel, told, response.FAR * top)
        _violations(axes, drawn, panel, told)

    return over_sweep(table, drawn, [told, *hits], bound)


def _limit(
    axes: Axes, table: Table, drawn: View, panel: Panel, told: Shown, far: float
) -> None:
    """Draw the stroke limit, up to so far away; where it is swept that of each case."""
    if table.scenario.stroke is None:
        return

    def limit(row: Row) -> float:
        return told.scale * (stroke_limit(table.scenario, row) or 0.0)

    curves = [series(drawn, line, limit) for line in panel.lines]
    levels = [{*y} for _, y in curves]
    every = set().union(*levels)
    if len(every) == 1:
        (level,) = every
        words = f"stroke limit {wording.number(level, told.unit)}"
        _level(axes, level, far, response.LIMIT, words)
    elif any(len(own) > 1 for own in levels):
        near = [(x, y) for x, y in zip(*curves[0], strict=True) if y <= far]
        axes.plot(*zip(*near, strict=True), **response.LIMIT, label="stroke limit")
    elif len(levels) <= FEW_LINES:
        for looks, own in zip(styles(drawn), levels, strict=True):
            style = {**response.LIMIT, "color": looks["color"]}
            for level in own:
                _level(axes, level, far, style, "stroke limit of each")


def _level(axes: Axes, level: float, far: float, style: Style, words: str) -> None:
    """Draw a stroke limit that is the same all along the axis, if it is not too far away."""
    if level <= far:
        axes.axhline(level, **style, label=words)


def _violations(axes: Axes, drawn: View, panel: Panel, told: Shown) -> None:
    """Mark where the stroke limit is met."""
    rows = [row for line in panel.lines for row in line.rows if row.metrics.get("violations")]
    if rows:
        x, y = [drawn.x(row) for row in rows], [told.of(row) or nan for row in rows]
        axes.plot(x, y, **response.BEYOND, linestyle="none", clip_on=False, label="limit met")


# A table as curves: what goes along the axis, what tells lines and panels apart.


DENSE = 5
"""Frequencies from which on a sweep is drawn over them, whatever varies fastest."""

MOST_PANELS, MOST_LINES = 4, 60
"""Panels and lines of one picture; of more some evenly spread ones are drawn."""

MOST_COMPARED = 3
"""Panels of a comparison, which have the motion above them."""

Point = Mapping[str, float]
Choice = TypeVar("Choice")


class Line(NamedTuple):
    """A curve: its words, its value on the axis of the lines, and its rows along the axis."""

    label: str
    value: float
    rows: Sequence[Row]


class Panel(NamedTuple):
    """The curves of one picture panel, and its words where there are several."""

    point: Point
    title: str
    lines: Sequence[Line]
    references: Sequence[Line]


class View(NamedTuple):
    """How a table is drawn.

    Attributes
    ----------
    key : str
        What goes along the axis; empty where nothing is swept.
    label : str
        The words below the axis.
    line : Axis or None
        What tells the lines of a panel apart; the first of several keys that walk together.
    panels : sequence of Panel
    left_out : int
        Curves that are not drawn.
    sampled : bool
        Whether the cases are drawn at random, so that no line leads from one to the next.
    """

    key: str
    label: str
    line: Axis | None
    panels: Sequence[Panel]
    left_out: int
    sampled: bool = False

    def x(self, row: Row) -> float:
        """Give where a row is along the axis; nan for a reference that is all along it."""
        if self.key not in row.point:
            return nan
        return row.F_fk if self.key in FORCES else row.point[self.key]


def view(table: Table) -> View:
    """Give how to draw a sweep: its approach as lines, its reference dashed."""
    along, label, beside, others = _along(table.axes)
    told = max(others, key=lambda group: len(group[0].values), default=())
    told = told if told and len(told[0].values) > 1 else ()
    points = _points([group for group in others if group is not told])
    shown = spread(points, MOST_PANELS)
    places = _points([told] if told else [])
    drawn = spread(places, MOST_LINES)
    own = Curves(table.own, beside)
    references = [Curves(table.of(name), beside) for name in table.approaches[1:]]
    panels = [_panel(point, drawn, own, references, table.axes) for point in shown]
    left_out = len(points) * len(places) - len(shown) * len(drawn)
    return View(along, label, told[0] if told else None, panels, left_out)


def compared(made: Comparison) -> View:
    """Give how to draw a comparison: lines are approaches, one panel is the case shown."""
    table = made.table
    along, label, beside, others = _along(table.axes)
    curves = [Curves(table.of(name), beside) for name in table.approaches]
    points = _points(others)
    case = [at for at in points if all(made.shown.get(k, v) == v for k, v in at.items())]
    shown = spread(points, MOST_COMPARED)
    if case and case[0] not in shown:
        shown = [case[0], *shown[1:]]
    panels = [
        Panel(
            at, title(at, table.axes), [Line(one.name, nan, one.at(at)) for one in curves], ()
        )
        for at in shown
    ]
    sampled = any(isinstance(axis.values, Drawn) for axis in table.axes)
    return View(along, label, None, panels, len(points) - len(shown), sampled)


def _along(axes: Sequence[Axis]) -> tuple[str, str, Collection[str], list[tuple[Axis, ...]]]:
    """Give the key of the axis, its words, what walks with it, and the other groups of keys."""
    along, groups = along_axis(axes), walks(axes)
    if along is None:
        return "", "", (), groups
    beside = {axis.key for group in groups if along in group for axis in group}
    others = [group for group in groups if along not in group]
    return along.key, LABELS.get(along.key) or key_label(along), beside, others


def along_axis(axes: Sequence[Axis]) -> Axis | None:
    """Give the swept key that a sweep is drawn over: the frequency, or what varies fastest."""
    several = [axis for axis in axes if len(axis.values) > 1] or list(axes)
    frequency = [a for a in several if a.key == FREQUENCY and len(a.values) >= DENSE]
    return next(iter(frequency + several), None)


def _points(groups: Iterable[Sequence[Axis]]) -> list[dict[str, float]]:
    """Give every combination of the values of some keys, those of a group side by side."""
    return [*every_point([axis for group in groups for axis in group])]


def spread(choices: Sequence[Choice], most: int) -> list[Choice]:
    """Give at most so many of the choices, evenly spread, the first and the last among them."""
    if len(choices) <= most:
        return list(choices)
    return [choices[round(at * (len(choices) - 1) / (most - 1))] for at in range(most)]


class Curves:
    """Rows by everything but where they are along the axis, and what walks with it."""

    def __init__(self, rows: Iterable[Row], along: Collection[str]) -> None:
        self.found: defaultdict[frozenset[tuple[str, float]], list[Row]] = defaultdict(list)
        self.keys: set[str] = set()
        self.name = ""
        for row in rows:
            rest = {key: value for key, value in row.point.items() if key not in along}
            self.keys |= rest.keys()
            self.name = row.approach
            self.found[frozenset(rest.items())].append(row)

    def at(self, point: Point) -> list[Row]:
        """Give the rows at a point; keys that these rows do not know take no part."""
        known = {key: value for key, value in point.items() if key in self.keys}
        return self.found.get(frozenset(known.items()), [])


def _panel(
    point: Point,
    places: Sequence[Point],
    own: Curves,
    references: Sequence[Curves],
    axes: Sequence[Axis],
) -> Panel:
    """Give the curves of one panel, one at each place."""
    values = [next(iter(place.values()), nan) for place in places]
    lines = [
        Line(spoken(place, axes) or own.name, value, own.at({**point, **place}))
        for value, place in zip(values, places, strict=True)
    ]
    drawn = [
        Line(curves.name, value, curves.at({**point, **place}))
        for curves in references
        for value, place in zip(values, places, strict=True)
    ]
    return Panel(point, title(point, axes), lines, drawn)


# The words for swept keys: the symbols of the paper, where it has some.


FORCES = ("friction.kinetic", "friction.mu_kinetic", "friction.normal")
"""Keys that are drawn as what they come to: the kinetic friction force."""

LABELS = {
    FREQUENCY: "frequency $f$ [Hz]",
    "excitation.rms": "base acceleration $a_u$ RMS [m/s²]",
    **dict.fromkeys(FORCES, "kinetic friction force $F_{fk}$ [N]"),
}

SYMBOLS = {
    FREQUENCY: "$f$",
    "excitation.rms": "$a_u$",
    "oscillator.mass": "$m$",
    "oscillator.stiffness": "$k_x$",
    "oscillator.damping": "$b$",
    "oscillator.damping_ratio": "$\\xi$",
    "friction.kinetic": "$F_{fk}$",
    "friction.static": "$F_{fs}$",
    "friction.static_ratio": "$F_{fs}/F_{fk}$",
    "friction.normal": "$F_N$",
    "friction.mu_kinetic": "$\\mu_k$",
}
"""Keys that a legend calls by the symbols of the paper."""


def key_label(axis: Axis) -> str:
    """Give the words for a swept key with its own unit, also where `LABELS` has a force's."""
    if axis.key in LABELS and axis.key not in FORCES[1:]:
        return LABELS[axis.key]
    symbol = SYMBOLS.get(axis.key)
    name = axis.key.rpartition(".")[2].replace("_", " ")
    words = f"{name} {symbol}" if symbol else axis.key
    return f"{words} [{wording.pretty(axis.unit) or '–'}]"


def spoken(point: Mapping[str, float], axes: Sequence[Axis]) -> str:
    """Give where a curve is, in symbols where the paper has some."""
    units = {axis.key: wording.pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{SYMBOLS.get(key, wording.short(key, units))} {wording.number(value, units[key])}"
        for key, value in point.items()
    )


def title(point: Mapping[str, float], axes: Sequence[Axis]) -> str:
    """Give the words for a panel: what tells it from the others."""
    several = {axis.key for axis in axes if len(axis.values) > 1}
    return spoken({key: value for key, value in point.items() if key in several}, axes)


# The panels of a sweep: a row for each panel of its view, a column for each metric.


Value = Callable[[Row], float | None]

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
INTERVAL: Style = {
    "alpha": 0.3, "linewidth": 0.0, "zorder": 1.5,
    "label": "95 % confidence interval of a mean over seeds",
}  # fmt: skip

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
    coloured = drawn.line is not None and len(drawn.panels[0].lines) > FEW_LINES
    figure, grid = style.sheet(count, len(quantities), right=RIGHT)
    for place, quantity in enumerate(quantities):
        first = None
        for at, panel in enumerate(drawn.panels):
            # One scale for all rows: they are there to be compared.
            axes = first = figure.add_subplot(grid[at, place], sharey=first)
            words = f"{panel.title}: {quantity.symbol}" if panel.title else quantity.words
            name(axes, words, pad=15)
            scale_axis(axes, drawn, named=at == count - 1)
            curves(axes, drawn, panel, quantity)
            extra(axes, panel, quantity)
            gaps(axes, drawn, panel)
            _frequencies(axes, table, drawn)
        assert first is not None, "a view has a panel"
        values = list(known_values(drawn, quantity.of))
        if not values:
            first.text(0.5, 0.5, "not known", transform=first.transAxes, ha="center")
        _upright(first, values, steeply=quantity is T_A)
    unnamed = {line.label for line in drawn.panels[0].lines}
    head = style.of_table(table, drawn.left_out, of_stroke=_of_stroke(quantities))
    if not coloured:
        style.complete(figure, grid, head)
        return figure
    bar, left = _colours(figure, drawn)
    grid.update(right=left - ASIDE / style.WIDTH)
    bottom, top = style.complete(figure, grid, head, unnamed)
    bar.set_position((left, bottom, BAR / style.WIDTH, top - bottom))
    return figure


def _of_stroke(quantities: Sequence[Shown]) -> bool:
    return any(quantity.metric == STROKE for quantity in quantities)


def _upright(axes: Axes, values: Sequence[float], steeply: bool) -> None:
    """Let panels of one scale begin at 0; some are logarithmic where their values are steep."""
    if steeply and values and 0 < STEEP * min(values) <= max(values):
        axes.set_yscale("log")
        decades(axes.yaxis, *axes.get_ylim())
    else:
        panels = axes.get_shared_y_axes().get_siblings(axes)
        flat = not any(panel.dataLim.y1 > 0.0 for panel in panels)
        axes.set_ylim(0.0, 1.0 if flat else None)


def _frequencies(axes: Axes, table: Table, drawn: View) -> None:
    """Mark the natural frequency, and where a viscous isolator begins to isolate.

    Only where all cases share one.
    """
    varied = {axis.key for axis in table.axes if len(axis.values) > 1}
    plant = table.scenario.oscillator.plant()
    if drawn.key != FREQUENCY or varied & TUNING or plant.k_x <= 0:
        return
    f_0 = sqrt(plant.k_x / plant.m) / (2 * pi)
    low, high = axes.get_xlim()
    for words, f, side in (("$f_0$", f_0, "right"), ("$\\sqrt{2}f_0$", sqrt(2) * f_0, "left")):
        if low < f < high:
            axes.axvline(f, **FREQUENCIES)
            foot = axes.get_xaxis_transform()
            axes.text(f, 1.01, words, transform=foot, size=8, ha=side)


def _colours(figure: Figure, drawn: View) -> tuple[Axes, float]:
    """Draw the scale by which many lines are coloured.

    Returns its panel, and how far left it must begin for its numbers and its label.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.ticker import MaxNLocator

    assert drawn.line is not None
    axes = figure.add_axes((0.9, 0.1, 0.02, 0.8))
    norm, colours = scale(drawn.line)
    bar = figure.colorbar(ScalarMappable(norm, colours), cax=axes)
    bar.set_label(key_label(drawn.line))
    if wide(drawn.line.values):
        decades(axes.yaxis, norm.vmin, norm.vmax)
    else:
        axes.yaxis.set_major_locator(MaxNLocator(8, steps=[1, 2, 5, 10]))
        plain(axes.yaxis)
    ticks = [x for x in axes.yaxis.get_majorticklocs() if norm.vmin <= x <= norm.vmax]
    letters = max((len(numeral(x)) for x in ticks), default=0)
    return axes, 1.0 - (BAR + LABEL + LETTER * letters) / style.WIDTH


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
    return (LogNorm if wide(axis.values) else Normalize)(low, high), ListedColormap(dark)


def curves(axes: Axes, view: View, panel: Panel, quantity: Shown) -> None:
    """Draw the lines of a panel, a gap and a mark wherever the value is not known.

    Where they are few and their values are means, each has the band of its interval.
    """
    looks = styles(view)
    known = [series(view, line, quantity.of) for line in panel.lines]
    for at, (line, look, (x, y)) in enumerate(zip(panel.lines, looks, known, strict=True)):
        curve(axes, x, y, look, line.label, at)
    references(axes, view, panel, quantity.of, looks)
    if len(panel.lines) <= FEW_LINES:
        for line, look, (x, y) in zip(panel.lines, looks, known, strict=True):
            band(axes, x, y, series(view, line, quantity.width)[1], look)


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


def _alone(y: Sequence[float], at: int) -> bool:
    """Whether a point stands between two gaps, where no line shows it."""
    beside = [y[i] for i in (at - 1, at + 1) if 0 <= i < len(y)]
    return isfinite(y[at]) and not any(map(isfinite, beside))


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


def band(
    axes: Axes, x: Sequence[float], y: Sequence[float], width: Sequence[float], style: Style
) -> None:
    """Draw the confidence intervals of means about their curve, if it has any."""
    middle, half = np.array(y), np.array(width)
    if np.isfinite(half).any():
        edges = middle - half, middle + half
        axes.fill_between(x, *edges, color=style["color"], **INTERVAL)


def series(view: View, line: Line, value: Value) -> tuple[list[float], list[float]]:
    """Give a line along the axis, in its order; nan is a gap."""
    found = [(view.x(row), value(row)) for row in line.rows]
    found.sort(key=lambda pair: -inf if isnan(pair[0]) else pair[0])
    known = [y for _, y in found]
    return [x for x, _ in found], [
        nan if y is None or not isfinite(y) else float(y) for y in known
    ]


def known_values(view: View, value: Value) -> Iterator[float]:
    """Give every value of the lines of a view that is known."""
    for panel in view.panels:
        for line in panel.lines:
            for row in line.rows:
                if (found := value(row)) is not None and isfinite(found):
                    yield found


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


# Axes: logarithmic over a decade, numbered in full.


LETTERS, MOST = 44, 99
"""Letters that fit below a panel, two between its numbers; and more numbers than fit."""

FREQUENCIES: Style = {
    "color": "#909090", "linewidth": 0.8, "linestyle": (0, (1, 2)), "zorder": 1
}  # fmt: skip


def scale_axis(axes: Axes, view: View, named: bool) -> None:
    """Make the axis of the swept key."""
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


def wide(values: Iterable[float]) -> bool:
    """Whether values span a decade, all above zero: their axis is logarithmic then."""
    low, high = inf, -inf
    for value in values:
        low, high = min(low, value), max(high, value)
    return low > 0 and high >= 10.0 * low


def decades(axis: Any, low: float, high: float) -> None:
    """Name 1, 2 and 5 of every decade of a logarithmic axis; 1 alone where more is too much."""
    from matplotlib.ticker import LogLocator

    def some(*steps: float) -> LogLocator:
        return LogLocator(subs=steps, numticks=MOST)

    named = [x for x in some(1.0, 2.0, 5.0).tick_values(low, high) if low <= x <= high]
    letters = sum(len(wording.number(x)) + 2 for x in named)
    axis.set_major_locator(some(1.0, 2.0, 5.0) if letters <= LETTERS else some(1.0))
    axis.set_major_formatter(lambda x, _: wording.number(x))
    axis.minorticks_off()


def plain(axis: Any) -> None:
    """Number the axis of a key in full: no power of ten apart, which a title could hide."""
    axis.set_major_formatter(lambda x, _: numeral(x))


def numeral(x: float) -> str:
    """Give a number as it stands at an axis, with a minus as long as its digits are wide."""
    return wording.number(x, digits=8).replace("-", "\N{MINUS SIGN}")


# Many cases: quantile bands along a swept key, and a map of the mean.


BANDS = ((0.05, 0.95, "#c9d8e8", "90 % of the cases"), (0.25, 0.75, "#8fb0d0", "half of them"))
MEDIAN: Style = {"color": "#0b3c6f", "linewidth": 1.6, "label": "median"}

LEFT_OF_MAPS, MANY_RIGHT = 0.1, 0.92
"""Where panels begin and end, so that numbers and words beside a map have room."""

BETWEEN_MAPS = 0.4
"""Room between two maps, in widths of one [-]: the bar of the left, the key of the right."""


def scattered(table: Table) -> bool:
    """Tell whether a table is drawn as bands: too many cases for lines, or none that are."""
    return len(table.rows) > HELD or any(isinstance(axis.values, Drawn) for axis in table.axes)


def draw_many(table: Table, quantities: Sequence[Shown]) -> Figure:
    """Give the picture of some metrics, a column each."""
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
        figure, grid = style.sheet(1, len(shown), right=MANY_RIGHT)
    else:
        figure, grid = style.sheet(2, len(shown), LEFT_OF_MAPS, MANY_RIGHT, aside=BETWEEN_MAPS)
    for place, i in enumerate(shown):
        quantity = quantities[i]
        axes = figure.add_subplot(grid[0, place])
        name(axes, quantity.words)
        bands(axes, found[i], beside[i] if references else None, quantity.scale)
        bound(axes, table, quantity)
        along_bins(axes, bins, named=across is None)
        if across is not None:
            below = figure.add_subplot(grid[1, place])
            name(below, f"mean of {quantity.words}")
            mapped(figure, below, found[i], quantity.scale)
    style.complete(figure, grid, style.of_table(table, of_stroke=_of_stroke(quantities)))
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
        axes.plot(x, reference.curve(0.5) * factor, **REFERENCE, label=words)


def bound(axes: Axes, table: Table, quantity: Shown) -> None:
    """Draw the stroke limit all cases share, or the line at which nothing is gained."""
    stroke = table.scenario.stroke
    axes.set_ylim(bottom=0.0)
    if quantity.metric != STROKE:
        axes.axhline(1.0, **UNITY)
    elif any(axis.key == LIMIT for axis in table.axes):
        return
    elif stroke is not None and stroke.limit * quantity.scale <= 2.0 * axes.get_ylim()[1]:
        limit = stroke.limit * quantity.scale
        words = f"stroke limit {wording.number(limit, quantity.unit)}"
        axes.axhline(limit, **response.LIMIT, label=words)
        axes.set_ylim(top=max(axes.get_ylim()[1], 1.05 * limit))


def along_bins(axes: Axes, bins: Bins, named: bool) -> None:
    """Make the axis of the key along."""
    axes.set_xlim(bins.fences[0], bins.fences[-1])
    _scale(axes.set_xscale, axes.xaxis, bins)
    axes.tick_params(labelbottom=named)
    if named:
        axes.set_xlabel(key_label(bins.axis))


def _scale(set_scale: Callable[[str], None], axis: Any, bins: Bins) -> None:
    """Spread and number the axis of a swept key as its bins are."""
    if bins.even_in_ratio:
        set_scale("log")
        decades(axis, bins.fences[0], bins.fences[-1])
    else:
        plain(axis)


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


# How a metric scatters along a swept key, counted block by block.


MOST_VALUES, FEWEST_BINS, BINS = 120, 6, 48
"""Values of a key up to which each is a bin of its own; least and most bins of other keys."""

A_CELL = 4
"""Cases of a sample that a cell of a map has on the average: few cells remain empty."""

FINENESS = 256
"""Bins of a metric to a factor of e: less than the width of a line."""

SPAN = (log(1e-9), log(1e6))
"""Logarithms between which a metric may lie; what lies beyond is counted at the end."""

FAR_POINT = 1e-3
"""Share of a distribution without end that is drawn at the end of its axis."""


def gathered(batches: Iterable[Batch], approach: str, scatters: Sequence[Scatter]) -> None:
    """Let scatters count the cases of an approach."""
    for batch in batches:
        if batch.approach == approach:
            for scatter in scatters:
                scatter.add(batch)


@dataclass
class Scatter:
    """How often a metric has which value in which bin, its greatest, and its mean on a map."""

    metric: str
    along: Bins
    across: Bins | None
    counts: NDArray[np.int64] = field(init=False)
    sums: Floats = field(init=False)
    cells: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        """Begin with nothing."""
        width = int((SPAN[1] - SPAN[0]) * FINENESS) + 2
        self.counts = np.zeros((len(self.along), width), dtype=np.int64)
        size = len(self.along) * (len(self.across) if self.across else 0)
        self.sums, self.cells = np.zeros(size), np.zeros(size, dtype=np.int64)

    def add(self, batch: Batch) -> None:
        """Count the cases of a block that know the metric."""
        values = batch.metrics[self.metric]
        known = values == values
        x = batch.points.get(self.along.axis.key)
        if x is None or not known.any():
            return
        values, at = values[known], self.along.find(x[known])
        width = self.counts.shape[1]
        with np.errstate(divide="ignore"):
            logs = np.log(values)
        place = np.clip((logs - SPAN[0]) * FINENESS + 1, 0, width - 1).astype(np.int64)
        np.add.at(self.counts, (at, place), 1)
        y = batch.points.get(self.across.axis.key) if self.across else None
        if self.across is not None and y is not None:
            cell = at * len(self.across) + self.across.find(y[known])
            self.sums += np.bincount(cell, values, minlength=len(self.sums))
            self.cells += np.bincount(cell, minlength=len(self.cells))

    def quantile(self, level: float) -> Floats:
        """Give a quantile of the metric in every bin; NaN where nothing is known."""
        below = np.cumsum(self.counts, axis=1)
        total = below[:, -1]
        at = np.argmax(below >= level * np.maximum(total, 1)[:, None], axis=1)
        values = np.array([0.0 if k == 0 else exp(SPAN[0] + (k - 0.5) / FINENESS) for k in at])
        return np.where(total > 0, values, np.nan)

    def curve(self, level: float) -> Floats:
        """Give a quantile at the points of a curve: that of a range's last bin to its end."""
        return np.pad(self.quantile(level), self.along.beyond, mode="edge")

    @property
    def map(self) -> Floats:
        """The mean of the metric, shape (bins across, bins along); NaN where none is known."""
        assert self.across is not None, "asked for where there is something across"
        with np.errstate(invalid="ignore", divide="ignore"):
            means = self.sums / self.cells
        return np.asarray(means.reshape(len(self.along), len(self.across)).T)


@dataclass(frozen=True)
class Bins:
    """A swept key as bins.

    Attributes
    ----------
    axis : Axis
    middles, fences : ndarray
        Middles of the bins, and their edges, both ends included.
    x : ndarray
        Where curves have their points: the middles, and the ends of a range.
    even_in_ratio : bool
        Whether the key is drawn on a logarithmic axis.
    """

    axis: Axis
    middles: Floats
    fences: Floats
    x: Floats
    even_in_ratio: bool

    @classmethod
    def of(cls, axis: Axis) -> Bins:
        """Give a bin to each of few values; else bins of equal width or ratio."""
        values = axis.values
        if isinstance(values, Drawn):
            most = max(FEWEST_BINS, isqrt(len(values) // A_CELL))
            fences, even = _fences(*_ends(values.law), min(BINS, most), _by_ratio(values.law))
        else:
            ordered = values if isinstance(values, Spread) else sorted({*values})
            if len(ordered) <= MOST_VALUES:
                middles, even = np.array(ordered, dtype=float), wide(ordered)
                return cls(axis, middles, _between(middles, even), middles, even)
            fences, even = _fences(ordered[0], ordered[-1], BINS)
            fences = _filled(fences, ordered)
        middles = np.sqrt(fences[1:] * fences[:-1]) if even else (fences[1:] + fences[:-1]) / 2
        return cls(axis, middles, fences, np.array([fences[0], *middles, fences[-1]]), even)

    def __len__(self) -> int:
        """Give the number of bins."""
        return len(self.middles)

    @property
    def beyond(self) -> int:
        """How many points a curve has beyond the middles at either end."""
        return (len(self.x) - len(self)) // 2

    def find(self, values: Floats) -> NDArray[np.intp]:
        """Give the bin of every value."""
        return np.searchsorted(self.fences[1:-1], values, side="right")


def _between(middles: Floats, even_in_ratio: bool) -> Floats:
    """Give edges halfway between values by the scale of their axis, and as far beyond them."""
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    x = np.log(middles) if even_in_ratio else middles
    between = 0.5 * (x[1:] + x[:-1])
    edges = np.array([2 * x[0] - between[0], *between, 2 * x[-1] - between[-1]])
    return np.asarray(np.exp(edges) if even_in_ratio else edges)


def _fences(low: float, high: float, count: int, by_ratio: bool = True) -> tuple[Floats, bool]:
    """Give edges of bins between two ends, and whether they are even in ratio."""
    even = by_ratio and wide((low, high))
    return (np.geomspace if even else np.linspace)(low, high, count + 1), even


def _filled(fences: Floats, ordered: Sequence[float]) -> Floats:
    """Give edges with a value between any two: those of a range may lie farther apart."""
    below = [bisect_left(ordered, fence) for fence in fences[1:-1].tolist()]
    _, first = np.unique([0, *below, len(ordered)], return_index=True)
    return np.append(fences[first[:-1]], fences[-1])


def _ends(law: Distribution) -> tuple[float, float]:
    """Give the ends of a distribution, for one without some that hold nearly all of it."""
    share = FAR_POINT if isinstance(law, Normal | LogNormal) else 0.0
    low, high = law.quantile(np.array([share, 1.0 - share])).tolist()
    return low, high


def _by_ratio(law: Distribution) -> bool:
    """Tell whether a logarithmic axis may suit a key that is drawn so."""
    return isinstance(law, LogNormal) or getattr(law, "log", False)
