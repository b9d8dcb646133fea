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
from drysim.plots.response import (
    STUCK_STYLE,
    Curve,
    curve_with_events,
    grid_curve,
    stuck_intervals,
    stuck_label,
)
from drysim.plots.style import T_A, Style
from drysim.plots.sweep import Panel, View, comparison_view, point_label
from drysim.study import compare
from drysim.study.compare import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


# Told apart in grey as well: by width, lightness, dashes and marks.
REFERENCE_STYLE: Style = {"color": "#86aed6", "linewidth": 3.4, "marker": "o", "zorder": 1.8}
FRICTIONLESS_STYLE: Style = {"color": "#6b6b6b", "linewidth": 1.2, "linestyle": (0, (4, 2))}
OTHER_STYLES: tuple[Style, ...] = (
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

BARS_LEFT, ROW_GAP = 0.115, 0.8
"""Where bars begin [-], and how far rows of panels are apart [inch]: each has its axis."""


def comparison(result: Comparison, folder: Path) -> None:
    """Write comparison.png: several approaches on the very same base motion."""
    style.save_png(lambda: draw(result), folder / "comparison.png")


def draw(result: Comparison) -> Figure:
    """Give the picture of a comparison, not yet rendered."""
    line_styles, view = approach_styles(result), comparison_view(result)
    known = any("T_a" in tally.extremes for tally in result.table.tallies.values())
    swept, bars = known and bool(view.key), known and not view.key
    left = BARS_LEFT if bars else style.LEFT
    figure, grid = style.panel_grid(1 + known * len(view.panels), 2, left=left, gap=ROW_GAP)
    above = figure.add_subplot(grid[0, 0] if result.of_laws else grid[0, :])
    _draw_acceleration(above, result, line_styles, named=not swept)
    if result.of_laws:
        _draw_loops(figure.add_subplot(grid[0, 1]), result, line_styles)
    if swept:
        draw_curves(figure, grid, result, view, line_styles)
    elif bars:
        draw_bars(figure, grid, result, line_styles)
    style.finish_figure(figure, grid, style.comparison_heading(result, view.left_out))
    return figure


def approach_styles(result: Comparison) -> Mapping[str, Style]:
    """Give every approach its style."""
    line_styles, rest = {result.yardstick: REFERENCE_STYLE}, 0
    for name in result.table.approaches:
        if name == FRICTIONLESS:
            line_styles.setdefault(name, FRICTIONLESS_STYLE)
        elif name not in line_styles:
            line_styles[name] = OTHER_STYLES[rest % len(OTHER_STYLES)]
            rest += 1
    return line_styles


def _draw_acceleration(
    axes: Axes, result: Comparison, line_styles: Mapping[str, Style], named: bool
) -> None:
    """Draw the acceleration of all approaches over a stretch.

    The rougher it is, the more it goes up and down, the lower it lies; what is twice as rough
    as the yardstick would hide that, and lies below it.
    """
    yardstick = result.responses[result.yardstick]
    first, last = _shown_interval(result)
    label = stuck_label(yardstick.law)
    for at, length in stuck_intervals(yardstick, first, last):
        axes.axvspan(at, at + length, **STUCK_STYLE, label=f"{label} ({result.yardstick})")
    curves = _curves(result, result.responses, first, last)
    total_variation = {
        name: float(np.abs(np.diff(one.x_dd)).sum()) for name, one in curves.items()
    }
    for name in sorted(total_variation, key=lambda name: -total_variation[name]):
        hides_reference = total_variation[name] > 2 * total_variation[result.yardstick]
        zorder = 2.5 if name == result.yardstick else 2.2 if hides_reference else 3
        line_style = {**line_styles[name], "marker": "", "zorder": zorder}
        shown = curves[name]
        axes.plot(shown.t, shown.x_dd, **line_style, label=name if named else "")
    where = point_label(result.shown, result.table.axes)
    sweep.set_title(axes, f"acceleration of the mass ẍ [m/s²]{': ' if where else ''}{where}")
    axes.set_xlabel("time $t$ [s]")
    if last > first:
        axes.set_xlim(first, last)


def _draw_loops(axes: Axes, result: Comparison, line_styles: Mapping[str, Style]) -> None:
    """Draw the friction force of every word around the stretch that is drawn beside it."""
    first, last = cycle_interval(result.responses[result.yardstick], *_shown_interval(result))
    words = [name for name in result.responses if result.laws.get(name)]
    curves = _curves(result, words, first, last)
    peaks = (float(np.abs(shown.x_r).max()) for shown in curves.values())
    unit = wording.length_unit(max(peaks, default=0.0))
    for name, shown in curves.items():
        axes.plot(
            shown.x_r * unit.units_per_metre, shown.F_f, **{**line_styles[name], "marker": ""}
        )
    sweep.set_title(axes, "friction force $F_f$ [N]")
    axes.set_xlabel(f"relative displacement $x_r$ [{unit.sign}]")


def _shown_interval(result: Comparison) -> Interval:
    """Give the stretch to look at, by the yardstick and what is held against it."""
    excluded = (result.yardstick, FRICTIONLESS)
    rivals = [response for name, response in result.responses.items() if name not in excluded]
    measure = result.table.scenario.measure
    begin = 0.0 if measure.steady else measure.settle
    return choose_interval(
        result.responses[result.yardstick], rivals or [*result.responses.values()], begin
    )


def _curves(
    result: Comparison, names: Collection[str], first: float, last: float
) -> dict[str, Curve]:
    return {name: _interval_curve(result.responses[name], first, last) for name in names}


def _interval_curve(response: Response, first: float, last: float) -> Curve:
    """Give a stretch [s]; jumps of an exact response stand upright.

    Orbits of several approaches may repeat after different times, so each is drawn as often as
    the stretch asks for.
    """
    fixed, length = response.numerics.core == FIXED_STEP, repeat_time(response)
    parts = []
    for repeat in range(int(first // length), int(last // length) + 1):
        offset = repeat * length if repeat else 0.0
        begin = max(int((first - offset) / response.dt) - 1, 0)
        part = slice(begin, min(int((last - offset) / response.dt) + 2, len(response)))
        segment = grid_curve(response, part) if fixed else curve_with_events(response, part)
        parts.append(segment._replace(t=segment.t + offset))
    return Curve(*map(np.concatenate, zip(*parts, strict=True)))


# T_a of several approaches, and how far each is off its yardstick.


AGREEMENT_BAND = 100.0 * compare.AGREEMENT_TOLERANCE
"""Deviation of T_a up to which two approaches agree [%]."""

LARGE_DEVIATION = 20.0
"""Deviation [%] from which on the scale is logarithmic beyond the band of agreement."""

DEVIATION_TICKS = (5, 10, 20, 50, 100, 200, 500, 1000, 10_000, 100_000)
BAR_LABEL_SHARE = 0.3
"""Room for the number of a bar, over the length of the bars."""

SAMPLE_STYLE: Style = {"linestyle": "none", "marker": ".", "markersize": 4}
"""The cases of a sample, between which there is nothing."""

LABEL_BOX: Style = {"facecolor": "white", "edgecolor": "none", "pad": 1}
AGREEMENT_STYLE: Style = {"facecolor": "#e8efe6", "edgecolor": "none", "zorder": 0}


def draw_curves(
    figure: Figure,
    grid: GridSpec,
    result: Comparison,
    view: View,
    line_styles: Mapping[str, Style],
) -> None:
    """Draw T_a and its deviation over what is swept, one scale for all rows."""
    left, right = None, None
    values: list[float] = []
    for at, panel in enumerate(view.panels, 1):
        left = figure.add_subplot(grid[at, 0], sharey=left)
        right = figure.add_subplot(grid[at, 1], sharey=right)
        _set_titles(left, right, result, panel.title)
        for line in panel.lines:
            style = {
                **line_styles[line.label],
                **(SAMPLE_STYLE if view.sampled else {"markersize": 4}),
            }
            x, y = sweep.line_series(view, line, T_A.of)
            sweep.draw_curve(left, x, y, style, line.label)
            sweep.draw_interval(left, x, y, sweep.line_series(view, line, T_A.width)[1], style)
            if line.label != result.yardstick:
                x, y, width = _deviations(result, view, panel, line.label)
                sweep.draw_curve(right, x, y, style, line.label)
                sweep.draw_interval(right, x, y, width, style)
                values += y
        left.axhline(1.0, **sweep.UNITY_STYLE)
        right.axhspan(
            -AGREEMENT_BAND,
            AGREEMENT_BAND,
            **AGREEMENT_STYLE,
            label=f"within ±{AGREEMENT_BAND:g} %",
        )
        right.axhline(0.0, **sweep.UNITY_STYLE)
        sweep.mark_gaps(left, view, panel)
        for axes in (left, right):
            sweep.set_x_axis(axes, view, named=at == len(view.panels))
    if left and right:
        left.set_ylim(bottom=0.0)
        _set_deviation_scale(right, values)


def _deviations(
    result: Comparison, view: View, panel: Panel, name: str
) -> tuple[list[float], list[float], list[float]]:
    """Give the deviation of an approach [%] along the axis, and half of its intervals."""
    found = [
        (view.x(one.row), 100.0 * one.value, 100.0 * (one.half_width or nan))
        for one in compare.deviations(result, name)
        if all(one.row.point.get(key, value) == value for key, value in panel.point.items())
    ]
    found.sort()
    return [x for x, _, _ in found], [y for _, y, _ in found], [w for _, _, w in found]


def _set_deviation_scale(axes: Axes, values: Sequence[float]) -> None:
    """Make a scale on which both small and large deviations can be read."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    if max(high, -low) <= LARGE_DEVIATION:
        return
    axes.set_yscale("symlog", linthresh=AGREEMENT_BAND, linscale=0.7)
    above = [tick for tick in DEVIATION_TICKS if tick <= max(high, AGREEMENT_BAND)]
    ticks = [
        *(-tick for tick in DEVIATION_TICKS if -tick >= min(low, -AGREEMENT_BAND)),
        0,
        *above,
    ]
    axes.set_yticks(ticks, labels=[sweep.tick_label(tick) for tick in ticks])
    axes.minorticks_off()


def draw_bars(
    figure: Figure, grid: GridSpec, result: Comparison, line_styles: Mapping[str, Style]
) -> None:
    """Draw T_a and its deviation of one case as bars, with their numbers."""
    left, right = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    _set_titles(left, right, result)
    rows = {row.approach: row for row in result.table.rows}
    positions = {name: -at for at, name in enumerate(rows)}
    for name, row in rows.items():
        value, color = T_A.of(row), line_styles[name]["color"]
        left.barh(positions[name], value or 0.0, color=color, height=0.6)
        _label_bar(left, value or 0.0, positions[name], wording.format_number(value))
        off = result.deviation(row)
        if name != result.yardstick and off is not None:
            right.barh(positions[name], 100.0 * off, color=color, height=0.6)
            _label_bar(right, 100.0 * off, positions[name], f"{100.0 * off:+.3g} %")
    left.axvline(1.0, **sweep.UNITY_STYLE)
    right.axvspan(
        -AGREEMENT_BAND,
        AGREEMENT_BAND,
        **AGREEMENT_STYLE,
        label=f"within ±{AGREEMENT_BAND:g} %",
    )
    right.axvline(0.0, **sweep.UNITY_STYLE)
    for axes in (left, right):
        axes.set_yticks(
            list(positions.values()), labels=list(positions) if axes is left else []
        )
        axes.set_ylim(-len(rows) + 0.4, 0.6)
        _widen_for_labels(axes)
        axes.grid(visible=False, axis="y")


def _widen_for_labels(axes: Axes) -> None:
    """Make room for the numbers beyond the bars, on the side of zero where there are any."""
    low, high = axes.dataLim.intervalx
    margin = BAR_LABEL_SHARE * (max(high, 0.0) - min(low, 0.0))
    axes.set_xlim(low - margin * (low < 0.0), high + margin)


def _label_bar(axes: Axes, value: float, position: float, words: str) -> None:
    """Write the number of a bar beyond its end."""
    margin, side = (4, "left") if value >= 0 else (-4, "right")
    axes.annotate(
        words, (value, position), xytext=(margin, 0), textcoords="offset points",
        ha=side, va="center", size=9, bbox=LABEL_BOX,
    )  # fmt: skip


def _set_titles(left: Axes, right: Axes, result: Comparison, title: str = "") -> None:
    """Name what two panels show."""
    words, beside = (f"{title}: ", "") if title else ("", f" from {result.yardstick}")
    sweep.set_title(left, f"{words}$T_a$ [–]")
    sweep.set_title(right, f"{words}deviation of $T_a${beside} [%]")


# Which stretch of several responses tells most: where the yardstick sticks.


INTERVAL_PERIODS = (1.0, 3.0)
"""Least and most periods in the stretch, of the sine or else of the oscillator."""

INTERVAL_STEPS = 240
"""Steps between them at which what flips with every step can be seen to do so."""

STOP_CONTEXT = 4.0
"""Lengths of a stuck stretch that are shown around it."""

MIN_INTERVAL_SHARE = 0.3
"""Least part of the periods that is shown."""

Interval = tuple[float, float]


def choose_interval(response: Response, others: Iterable[Response], begin: float) -> Interval:
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
    least, most = (count * _reference_period(response) for count in INTERVAL_PERIODS)
    span = min(max(least, min(INTERVAL_STEPS * response.dt, most)), end - begin)
    stops = stuck_intervals(response, begin, end)
    fitting = [stop for stop in stops if stop[0] > begin and stop[1] <= 0.5 * span]
    if fitting:
        at, length = max(fitting, key=lambda stop: stop[1])
        middle, width = at + 0.5 * length, max(STOP_CONTEXT * length, MIN_INTERVAL_SHARE * span)
        return _interval_around(middle, min(width, span), begin, end)
    if stops:
        at, length = max(stops, key=lambda stop: stop[1])
        return _interval_around(at if at > begin else at + length, span, begin, end)
    return _interval_around(_largest_deviation_time(response, others, begin), span, begin, end)


def _largest_deviation_time(
    response: Response, others: Iterable[Response], begin: float
) -> float:
    """Give the instant at which another response differs most [s]."""
    gaps = [acceleration_difference(response, other, begin) for other in others]
    worst = max(gaps, key=lambda gap: float(gap.max(initial=0.0)), default=np.empty(0))
    return begin + int(worst.argmax()) * response.dt if len(worst) else begin


def acceleration_difference(response: Response, other: Response, begin: float) -> Floats:
    """Give |x_dd - x_dd of another| on the grid of a response from some instant on [m/s²]."""
    first = round(begin / response.dt)
    t = np.arange(first, len(response)) * response.dt
    own = response.acceleration(slice(first, None))
    beside = np.interp(np.mod(t, repeat_time(other)), other.t, other.x_dd)
    gap: Floats = np.abs(beside - own)
    return gap


def repeat_time(response: Response) -> float:
    """Give after how long a response repeats [s]: one of a steady orbit goes on and on."""
    if response.numerics.period_multiple is None:
        return inf
    assert response.trajectory is not None, "an orbit is measured by its track"
    return response.trajectory.end


def cycle_interval(response: Response, first: float, last: float) -> Interval:
    """Give begin and end [s] of a whole cycle around a stretch, on which loops can close."""
    if (length := repeat_time(response)) < inf:
        return 0.0, length
    end = (len(response) - 1) * response.dt
    least = _reference_period(response)
    if last - first >= least:
        return first, last
    return _interval_around(0.5 * (first + last), min(least, end), 0.0, end)


def _interval_around(middle: float, width: float, begin: float, end: float) -> Interval:
    """Give a stretch around an instant, moved to lie between two others."""
    first = max(min(middle - 0.5 * width, end - width), begin)
    return first, min(first + width, end)


def _reference_period(response: Response) -> float:
    """Give the period of the base, or of the oscillator [s]."""
    if isinstance(response.motion, Sines) and response.motion.f:
        return 1.0 / min(response.motion.f)
    m, k_x, _ = response.plant
    return 2 * pi * sqrt(m / k_x) if k_x > 0 else 1.0
