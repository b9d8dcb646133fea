"""comparison.png: approaches or friction laws side by side, on the very same base motion.

On top the acceleration over the stretch that tells most, where the yardstick sticks; of
friction laws their loops beside it. Below it T_a of each and how far it is off its yardstick:
over what is swept, or of one case as bars. The scale of deviations is logarithmic beyond the
band in which approaches agree, so that small and large ones can be read.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from math import inf, nan, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.approach.solution import FIXED_STEP, Floats, Response
from drysim.core.model import Sines
from drysim.plots import style, sweep
from drysim.plots.response import STUCK, Curve, curve, grid, label_held, stuck_stretches
from drysim.plots.style import T_A, Style
from drysim.plots.sweep import Panel, View, compared, spoken
from drysim.study import compare
from drysim.study.compare import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


# Told apart in grey as well: by width, lightness, dashes and marks.
YARDSTICK: Style = {"color": "#86aed6", "linewidth": 3.4, "marker": "o", "zorder": 1.8}
WITHOUT: Style = {"color": "#6b6b6b", "linewidth": 1.2, "linestyle": (0, (4, 2))}
OTHERS: tuple[Style, ...] = (
    {"color": "#b3261e", "linewidth": 1.1, "marker": "s"},
    {"color": "black", "linewidth": 1.2, "linestyle": (0, (6, 1.5, 1, 1.5)), "marker": "^"},
    {"color": "#2e7d32", "linewidth": 1.2, "linestyle": (0, (1.5, 1)), "marker": "D"},
    {"color": "#7b3fa0", "linewidth": 1.1, "linestyle": (0, (8, 2)), "marker": "v"},
    {"color": "#c77700", "linewidth": 1.4, "marker": "P"},
    {"color": "#00897b", "linewidth": 1.2, "linestyle": (0, (4, 1, 1, 1, 1, 1)), "marker": "X"},
    {"color": "#8d6e63", "linewidth": 1.4, "linestyle": (0, (3, 1)), "marker": "<"},
    {"color": "#c2187e", "linewidth": 1.2, "linestyle": (0, (2, 2)), "marker": ">"},
)
FRICTIONLESS = "viscous"

LEFT_OF_BARS, GAP = 0.115, 0.8
"""Where bars begin [-], and how far rows of panels are apart [inch]: each has its axis."""


def comparison(made: Comparison, folder: Path) -> None:
    """Write comparison.png: several approaches on the very same base motion."""
    style.paint(lambda: draw(made), folder / "comparison.png")


def draw(made: Comparison) -> Figure:
    """Give the picture of a comparison, not yet rendered."""
    looks, view = styles(made), compared(made)
    known = any("T_a" in tally.extremes for tally in made.table.tallies.values())
    swept, bars = known and bool(view.key), known and not view.key
    left = LEFT_OF_BARS if bars else style.LEFT
    figure, grid = style.sheet(1 + known * len(view.panels), 2, left=left, gap=GAP)
    above = figure.add_subplot(grid[0, 0] if made.of_laws else grid[0, :])
    _overlay(above, made, looks, named=not swept)
    if made.of_laws:
        _loops(figure.add_subplot(grid[0, 1]), made, looks)
    if swept:
        over_axis(figure, grid, made, view, looks)
    elif bars:
        as_bars(figure, grid, made, looks)
    style.complete(figure, grid, style.of_comparison(made, view.left_out))
    return figure


def styles(made: Comparison) -> Mapping[str, Style]:
    """Give every approach its style."""
    looks, rest = {made.yardstick: YARDSTICK}, 0
    for name in made.table.approaches:
        if name == FRICTIONLESS:
            looks.setdefault(name, WITHOUT)
        elif name not in looks:
            looks[name] = OTHERS[rest % len(OTHERS)]
            rest += 1
    return looks


def _overlay(axes: Axes, made: Comparison, looks: Mapping[str, Style], named: bool) -> None:
    """Draw the acceleration of all approaches over a stretch.

    The rougher it is, the more it goes up and down, the lower it lies; what is twice as rough
    as the yardstick would hide that, and lies below it.
    """
    yardstick = made.responses[made.yardstick]
    first, last = _told(made)
    held = label_held(yardstick.law)
    for at, length in stuck_stretches(yardstick, first, last):
        axes.axvspan(at, at + length, **STUCK, label=f"{held} ({made.yardstick})")
    stretches = _stretches(made, made.responses, first, last)
    rough = {name: float(np.abs(np.diff(one.x_dd)).sum()) for name, one in stretches.items()}
    for name in sorted(rough, key=lambda name: -rough[name]):
        hides = rough[name] > 2 * rough[made.yardstick]
        depth = 2.5 if name == made.yardstick else 2.2 if hides else 3
        look = {**looks[name], "marker": "", "zorder": depth}
        shown = stretches[name]
        axes.plot(shown.t, shown.x_dd, **look, label=name if named else "")
    where = spoken(made.shown, made.table.axes)
    sweep.name(axes, f"acceleration of the mass ẍ [m/s²]{': ' if where else ''}{where}")
    axes.set_xlabel("time $t$ [s]")
    if last > first:
        axes.set_xlim(first, last)


def _loops(axes: Axes, made: Comparison, looks: Mapping[str, Style]) -> None:
    """Draw the friction force of every word around the stretch that is drawn beside it."""
    first, last = cycle(made.responses[made.yardstick], *_told(made))
    words = [name for name in made.responses if made.laws.get(name)]
    stretches = _stretches(made, words, first, last)
    peaks = (float(np.abs(shown.x_r).max()) for shown in stretches.values())
    unit = wording.length_unit(max(peaks, default=0.0))
    for name, shown in stretches.items():
        axes.plot(shown.x_r * unit.per_metre, shown.F_f, **{**looks[name], "marker": ""})
    sweep.name(axes, "friction force $F_f$ [N]")
    axes.set_xlabel(f"relative displacement $x_r$ [{unit.sign}]")


def _told(made: Comparison) -> Stretch:
    """Give the stretch to look at, by the yardstick and what is held against it."""
    apart = (made.yardstick, FRICTIONLESS)
    rivals = [response for name, response in made.responses.items() if name not in apart]
    measure = made.table.scenario.measure
    begin = 0.0 if measure.steady else measure.settle
    return telling(made.responses[made.yardstick], rivals or [*made.responses.values()], begin)


def _stretches(
    made: Comparison, names: Collection[str], first: float, last: float
) -> dict[str, Curve]:
    return {name: _stretch(made.responses[name], first, last) for name in names}


def _stretch(response: Response, first: float, last: float) -> Curve:
    """Give a stretch [s]; jumps of an exact response stand upright.

    Orbits of several approaches may repeat after different times, so each is drawn as often as
    the stretch asks for.
    """
    fixed, length = response.numerics.core == FIXED_STEP, repetition(response)
    pieces = []
    for turn in range(int(first // length), int(last // length) + 1):
        passed = turn * length if turn else 0.0
        begin = max(int((first - passed) / response.dt) - 1, 0)
        part = slice(begin, min(int((last - passed) / response.dt) + 2, len(response)))
        piece = grid(response, part) if fixed else curve(response, part)
        pieces.append(piece._replace(t=piece.t + passed))
    return Curve(*map(np.concatenate, zip(*pieces, strict=True)))


# T_a of several approaches, and how far each is off its yardstick.


AGREE = 100.0 * compare.AGREE
"""Deviation of T_a up to which two approaches agree [%]."""

FAR = 20.0
"""Deviation [%] from which on the scale is logarithmic beyond the band of agreement."""

TICKS = (5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000)
NUMBERS = 0.3
"""Room for the number of a bar, over the length of the bars."""

POINTS: Style = {"linestyle": "none", "marker": ".", "markersize": 4}
"""The cases of a sample, between which there is nothing."""

PAPER: Style = {"facecolor": "white", "edgecolor": "none", "pad": 1}
BAND: Style = {"facecolor": "#e8efe6", "edgecolor": "none", "zorder": 0}


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
            x, y = sweep.series(view, line, T_A.of)
            sweep.curve(left, x, y, style, line.label)
            sweep.band(left, x, y, sweep.series(view, line, T_A.width)[1], style)
            if line.label != made.yardstick:
                x, y, width = _deviations(made, view, panel, line.label)
                sweep.curve(right, x, y, style, line.label)
                sweep.band(right, x, y, width, style)
                values += y
        left.axhline(1.0, **sweep.UNITY)
        right.axhspan(-AGREE, AGREE, **BAND, label=f"within ±{AGREE:g} %")
        right.axhline(0.0, **sweep.UNITY)
        sweep.gaps(left, view, panel)
        for axes in (left, right):
            sweep.scale_axis(axes, view, named=at == len(view.panels))
    if left and right:
        left.set_ylim(bottom=0.0)
        _scale(right, values)


def _deviations(
    made: Comparison, view: View, panel: Panel, name: str
) -> tuple[list[float], list[float], list[float]]:
    """Give the deviation of an approach [%] along the axis, and half of its intervals."""
    found = [
        (view.x(one.row), 100.0 * one.value, 100.0 * (one.half_width or nan))
        for one in compare.deviations(made, name)
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
    axes.set_yticks(ticks, labels=[sweep.numeral(tick) for tick in ticks])
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
        value, color = T_A.of(row), looks[name]["color"]
        left.barh(places[name], value or 0.0, color=color, height=0.6)
        _note(left, value or 0.0, places[name], wording.number(value))
        off = made.deviation(row)
        if name != made.yardstick and off is not None:
            right.barh(places[name], 100.0 * off, color=color, height=0.6)
            _note(right, 100.0 * off, places[name], f"{100.0 * off:+.3g} %")
    left.axvline(1.0, **sweep.UNITY)
    right.axvspan(-AGREE, AGREE, **BAND, label=f"within ±{AGREE:g} %")
    right.axvline(0.0, **sweep.UNITY)
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


def _titles(left: Axes, right: Axes, made: Comparison, title: str = "") -> None:
    """Name what two panels show."""
    words, beside = (f"{title}: ", "") if title else ("", f" from {made.yardstick}")
    sweep.name(left, f"{words}$T_a$ [–]")
    sweep.name(right, f"{words}deviation of $T_a${beside} [%]")


# Which stretch of several responses tells most: where the yardstick sticks.


PERIODS = (1.0, 3.0)
"""Least and most periods in the stretch, of the sine or else of the oscillator."""

STEPS = 240
"""Steps between them at which what flips with every step can be seen to do so."""

AROUND = 4.0
"""Lengths of a stuck stretch that are shown around it."""

CLOSEST = 0.3
"""Least part of the periods that is shown."""

Stretch = tuple[float, float]


def telling(response: Response, others: Iterable[Response], begin: float) -> Stretch:
    """Give begin and end [s] of the stretch to look at.

    Parameters
    ----------
    response : Response
        Of the yardstick.
    others : iterable of Response
        Of the approaches that are compared with it.
    begin : float
        End of the settling time [s].

    Notes
    -----
    It holds the longest stop that fits with the slips around it; the beginning of a longer one;
    without any, the greatest deviation.
    """
    end = (len(response) - 1) * response.dt
    least, most = (count * _period(response) for count in PERIODS)
    span = min(max(least, min(STEPS * response.dt, most)), end - begin)
    stops = stuck_stretches(response, begin, end)
    fitting = [stop for stop in stops if stop[0] > begin and stop[1] <= 0.5 * span]
    if fitting:
        at, length = max(fitting, key=lambda stop: stop[1])
        middle, width = at + 0.5 * length, max(AROUND * length, CLOSEST * span)
        return _within(middle, min(width, span), begin, end)
    if stops:
        at, length = max(stops, key=lambda stop: stop[1])
        return _within(at if at > begin else at + length, span, begin, end)
    return _within(_apart(response, others, begin), span, begin, end)


def _apart(response: Response, others: Iterable[Response], begin: float) -> float:
    """Give the instant at which another response differs most [s]."""
    gaps = [difference(response, other, begin) for other in others]
    worst = max(gaps, key=lambda gap: float(gap.max(initial=0.0)), default=np.empty(0))
    return begin + int(worst.argmax()) * response.dt if len(worst) else begin


def difference(response: Response, other: Response, begin: float) -> Floats:
    """Give |x_dd - x_dd of another| on the grid of a response from some instant on [m/s²]."""
    first = round(begin / response.dt)
    t = np.arange(first, len(response)) * response.dt
    own = response.acceleration(slice(first, None))
    beside = np.interp(np.mod(t, repetition(other)), other.t, other.x_dd)
    gap: Floats = np.abs(beside - own)
    return gap


def repetition(response: Response) -> float:
    """Give after how long a response repeats [s]: one of a steady orbit goes on and on."""
    if response.numerics.period_multiple is None:
        return inf
    assert response.track is not None, "an orbit is measured by its track"
    return response.track.end


def cycle(response: Response, first: float, last: float) -> Stretch:
    """Give begin and end [s] of a whole cycle around a stretch, on which loops can close."""
    if (length := repetition(response)) < inf:
        return 0.0, length
    end = (len(response) - 1) * response.dt
    least = _period(response)
    if last - first >= least:
        return first, last
    return _within(0.5 * (first + last), min(least, end), 0.0, end)


def _within(middle: float, width: float, begin: float, end: float) -> Stretch:
    """Give a stretch around an instant, moved to lie between two others."""
    first = max(min(middle - 0.5 * width, end - width), begin)
    return first, min(first + width, end)


def _period(response: Response) -> float:
    """Give the period of the base, or of the oscillator [s]."""
    if isinstance(response.motion, Sines) and response.motion.f:
        return 1.0 / min(response.motion.f)
    m, k_x, _ = response.plant
    return 2 * pi * sqrt(m / k_x) if k_x > 0 else 1.0
