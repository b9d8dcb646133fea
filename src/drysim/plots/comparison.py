"""Plot comparison.png: several approaches or friction laws under the same base motion.

Top row: acceleration over a short interval in which the reference sticks; for friction laws
also their friction loops. Rows below: T_a of each approach and its deviation from the
reference, over the swept key, or as bars for a single case. The deviation axis is linear
within the agreement band and logarithmic outside it, so that small and large deviations are
both readable.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import inf, log10, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim import wording
from drysim.approach.solution import FIXED_STEP, Response
from drysim.core.model import Floats, Sines
from drysim.plots import style, sweep
from drysim.plots.response import (
    Curve,
    curve_with_events,
    grid_curve,
    natural_period,
    shade_intervals,
    stuck_intervals,
    stuck_label,
)
from drysim.plots.style import A_W, SEAT, T_A, PlottedMetric, Style
from drysim.plots.sweep import Panel, View, comparison_view, point_label
from drysim.study import compare
from drysim.study.compare import Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


# Lines differ in width, lightness, dashes and markers, so that they are distinct in greyscale.
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


def draw(result: Comparison) -> Figure:
    """Return the figure of a comparison."""
    line_styles, view = approach_styles(result), comparison_view(result)
    has_T_a = any("T_a" in tally.extremes for tally in result.table.tallies.values())
    swept = has_T_a and bool(view.key)
    ends = [tally.ends for tally in result.table.tallies.values()]
    weighted = [
        metric for metric in (SEAT, A_W) if any(metric.name in has_T_a for has_T_a in ends)
    ][:1]
    columns: Columns = (T_A, DEVIATION, *weighted)
    figure, grid = style.panel_grid(1 + has_T_a * len(view.panels), len(columns))
    above = figure.add_subplot(grid[0, :-1] if result.of_laws else grid[0, :])
    _draw_acceleration(above, result, line_styles, named=not swept)
    if result.of_laws:
        _draw_loops(figure.add_subplot(grid[0, -1]), result, line_styles)
    if swept:
        draw_curves(figure, grid, result, view, columns, line_styles)
    elif has_T_a:
        draw_bars(figure, grid, result, columns, line_styles)
    style.finish_figure(figure, style.comparison_heading(result, view.left_out))
    return figure


def approach_styles(result: Comparison) -> Mapping[str, Style]:
    """Return the line style of every approach."""
    line_styles, rest = {result.reference: REFERENCE_STYLE}, 0
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
    """Draw the acceleration of all approaches over the shown interval.

    Curves are drawn in order of decreasing total variation, so that a chattering curve does
    not hide a smooth one. A curve with more than twice the total variation of the reference
    lies below the reference.
    """
    reference = result.responses[result.reference]
    first, last = _shown_interval(result)
    label = stuck_label(reference.law)
    intervals = stuck_intervals(reference, first, last)
    shade_intervals(axes, intervals, f"{label} ({result.reference})")
    curves = _curves(result, result.responses, first, last)
    total_variation = {
        name: float(np.abs(np.diff(curve.x_dd)).sum()) for name, curve in curves.items()
    }
    for name in sorted(total_variation, key=lambda name: -total_variation[name]):
        hides_reference = total_variation[name] > 2 * total_variation[result.reference]
        zorder = 2.5 if name == result.reference else 2.2 if hides_reference else 3
        line_style = {**line_styles[name], "marker": "", "zorder": zorder}
        shown = curves[name]
        axes.plot(shown.t, shown.x_dd, **line_style, label=name if named else "")
    title = f"acceleration of the mass ẍ [m/s²]: {point_label(result.shown, result.table.axes)}"
    room = style.HEADING_WIDTH
    if result.of_laws:  # the loops take the last column
        room *= 1 - 1 / style.column_count(axes)
    style.set_title(axes, style.fit_line(title.removesuffix(": "), room, size=style.TITLE_SIZE))
    axes.set_xlabel("time [s]")
    if last > first:
        axes.set_xlim(first, last)


def _draw_loops(axes: Axes, result: Comparison, line_styles: Mapping[str, Style]) -> None:
    """Draw the friction loop of every law over a cycle around the shown interval."""
    first, last = cycle_interval(result.responses[result.reference], *_shown_interval(result))
    names = [name for name in result.responses if result.laws.get(name)]
    curves = _curves(result, names, first, last)
    peaks = (float(np.abs(shown.x_r).max()) for shown in curves.values())
    unit = wording.length_unit(max(peaks, default=0.0))
    for name, shown in curves.items():
        axes.plot(
            shown.x_r * unit.units_per_metre, shown.F_f, **{**line_styles[name], "marker": ""}
        )
    style.set_title(axes, "friction force [N]")
    axes.set_xlabel(f"relative displacement xᵣ [{unit.symbol}]")


def _shown_interval(result: Comparison) -> Interval:
    """Return begin and end [s] of the interval to draw."""
    excluded = (result.reference, FRICTIONLESS)
    rivals = [response for name, response in result.responses.items() if name not in excluded]
    measure = result.table.scenario.measure
    begin = 0.0 if measure.steady else measure.settle
    return choose_interval(
        result.responses[result.reference], rivals or [*result.responses.values()], begin
    )


def _curves(
    result: Comparison, names: Collection[str], first: float, last: float
) -> dict[str, Curve]:
    return {name: _interval_curve(result.responses[name], first, last) for name in names}


def _interval_curve(response: Response, first: float, last: float) -> Curve:
    """Return the curve of a response over an interval [s], with vertical jumps at events.

    Periodic orbits of different approaches may have different periods; each is repeated until
    it fills the interval. Fixed-step responses have no events between grid points.
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


# T_a of several approaches and its deviation from the reference.


AGREEMENT_BAND = 100.0 * compare.AGREEMENT_TOLERANCE
"""Deviation of T_a within which two approaches agree [%]."""

LARGE_DEVIATION = 20.0
"""Deviation above which the axis is logarithmic outside the agreement band [%]."""

DEVIATION_TICKS = (5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000)
MAX_DENSE_DECADES = 2.5
"""Decades of the logarithmic parts of the axis from which on only every third tick fits."""

BAR_LABEL_SHARE = 0.15
"""Margin for the numbers at the bars, relative to the range of the bars and by the number of
columns [-]."""

WIDE_COLUMNS = 2
"""Columns of panels up to which a title names the reference."""

SAMPLE_STYLE: Style = {"linestyle": "none", "marker": ".", "markersize": 4}
"""Style of random samples, which no line connects."""

LABEL_BOX: Style = {"facecolor": "white", "edgecolor": "none", "pad": 1}
AGREEMENT_STYLE: Style = {
    "facecolor": "#e8efe6", "edgecolor": "none", "zorder": 0,
    "label": f"within ±{AGREEMENT_BAND:g} %",
}  # fmt: skip

DEVIATION = None
Columns = Sequence[PlottedMetric | None]
"""What the columns of panels show: a metric, or the deviation of T_a from the reference."""


def draw_curves(
    figure: Figure,
    grid: GridSpec,
    result: Comparison,
    view: View,
    columns: Columns,
    line_styles: Mapping[str, Style],
) -> None:
    """Draw every column over the swept key, with the same y-axis in all rows."""
    shared: list[Axes | None] = [None] * len(columns)
    deviations: list[float] = []
    for row, panel in enumerate(view.panels, 1):
        for column, metric in enumerate(columns):
            axes = figure.add_subplot(grid[row, column], sharey=shared[column])
            shared[column] = axes
            sweep.set_row_title(
                axes, panel.title, _column_title(grid, result, metric, panel.title)
            )
            for line in panel.lines:
                if metric is not None:
                    x, y = sweep.line_series(view, line, metric.of)
                    _, width = sweep.line_series(view, line, metric.half_width)
                elif line.label != result.reference:
                    x, y, width = _deviations(result, view, panel, line.label)
                    deviations += y
                else:
                    continue
                curve_style = _curve_style(view, line_styles[line.label])
                sweep.draw_curve(axes, x, y, curve_style, line.label)
                sweep.draw_interval(axes, x, y, width, curve_style)
            _mark_agreement(metric, axes.axhline, axes.axhspan)
            if metric is T_A:
                sweep.mark_gaps(axes, view, panel)
            sweep.set_x_axis(axes, view, is_labelled=style.is_lowest(axes))
            if row == len(view.panels):  # all curves of the column are drawn
                if metric is not None:
                    axes.set_ylim(bottom=0.0)
                else:
                    _set_deviation_scale(axes, deviations)


def _column_title(
    grid: GridSpec, result: Comparison, metric: PlottedMetric | None, row_title: str = ""
) -> str:
    """Return the title of a column of panels, which names the reference if there is room."""
    if metric is not None:
        return metric.symbol
    beside = "" if row_title or grid.ncols > WIDE_COLUMNS else f" from {result.reference}"
    return f"deviation of Tₐ{beside} [%]"


def _mark_agreement(
    metric: PlottedMetric | None, line: Callable[..., Any], span: Callable[..., Any]
) -> None:
    """Mark T_a = 1, or no deviation with the agreement band, by methods of the axes."""
    if metric is T_A:
        line(1.0, **sweep.UNITY_STYLE)
    elif metric is DEVIATION:
        span(-AGREEMENT_BAND, AGREEMENT_BAND, **AGREEMENT_STYLE)
        line(0.0, **sweep.UNITY_STYLE)


def _curve_style(view: View, line_style: Style) -> Style:
    """Return the style of a curve; points only for random samples."""
    return {**line_style, **(SAMPLE_STYLE if view.sampled else {"markersize": 4})}


def _deviations(
    result: Comparison, view: View, panel: Panel, name: str
) -> tuple[list[float], list[float], list[float]]:
    """Return abscissa, deviation [%] and half width of its interval [%] of an approach."""
    deviations = [
        (view.x(deviation.row), 100.0 * deviation.value, 100.0 * (deviation.half_width or nan))
        for deviation in compare.deviations(result, name)
        if all(
            deviation.row.point.get(key, value) == value for key, value in panel.point.items()
        )
    ]
    deviations.sort()
    return (
        [x for x, _, _ in deviations],
        [y for _, y, _ in deviations],
        [w for _, _, w in deviations],
    )


def _set_deviation_scale(axes: Axes, values: Sequence[float]) -> None:
    """Use a symmetric logarithmic y-axis where deviations are large."""
    low, high = min(values, default=0.0), max(values, default=0.0)
    if max(high, -low) <= LARGE_DEVIATION:
        return
    axes.set_yscale("symlog", linthresh=AGREEMENT_BAND, linscale=0.7)
    ends = max(high, AGREEMENT_BAND), max(-low, AGREEMENT_BAND)
    decades = sum(log10(end / AGREEMENT_BAND) for end in ends)
    steps = DEVIATION_TICKS[:: 1 if decades <= MAX_DENSE_DECADES else 3]
    below, above = ([tick for tick in steps if tick <= end] for end in reversed(ends))
    ticks = [*(-tick for tick in below), 0, *above]
    axes.set_yticks(ticks, labels=[style.tick_label(tick) for tick in ticks])
    for panel in axes.get_shared_y_axes().get_siblings(axes):
        panel.minorticks_off()
        panel.set_ylabel(f"logarithmic beyond ±{AGREEMENT_BAND:g} %", size=8, color="#606060")


def draw_bars(
    figure: Figure,
    grid: GridSpec,
    result: Comparison,
    columns: Columns,
    line_styles: Mapping[str, Style],
) -> None:
    """Draw every column of a single case as labelled bars."""
    rows = result.table.rows
    for column, metric in enumerate(columns):
        axes = figure.add_subplot(grid[1, column])
        style.set_title(axes, _column_title(grid, result, metric))
        for place, row in enumerate(rows):
            if metric is not None:
                value = metric.of(row)
                label = wording.format_number(value)
            elif (
                row.approach != result.reference and (off := result.deviation(row)) is not None
            ):
                value = 100.0 * off
                label = wording.format_deviation(off)
            else:
                continue
            color = line_styles[row.approach]["color"]
            axes.barh(-place, value or 0.0, color=color, height=0.6)
            _label_bar(axes, value or 0.0, -place, label)
        _mark_agreement(metric, axes.axvline, axes.axvspan)
        names = [row.approach if column == 0 else "" for row in rows]
        axes.set_yticks([-place for place in range(len(rows))], labels=names)
        axes.set_ylim(-len(rows) + 0.4, 0.6)
        _widen_for_labels(axes)
        axes.grid(visible=False, axis="y")


def _widen_for_labels(axes: Axes) -> None:
    """Extend the x-axis for the numbers at the bars, on each side of zero that has bars."""
    low, high = axes.dataLim.intervalx
    margin = BAR_LABEL_SHARE * style.column_count(axes) * (max(high, 0.0) - min(low, 0.0))
    axes.set_xlim(low - margin * (low < 0.0), high + margin)


def _label_bar(axes: Axes, value: float, position: float, label: str) -> None:
    """Write the number of a bar next to its end."""
    margin, side = (4, "left") if value >= 0 else (-4, "right")
    axes.annotate(
        label, (value, position), xytext=(margin, 0), textcoords="offset points",
        ha=side, va="center", size=9, bbox=LABEL_BOX,
    )  # fmt: skip


# Selection of the interval in which the responses are drawn.


INTERVAL_PERIODS = (1.0, 3.0)
"""Minimum and maximum length of the interval, in periods of the sine or of the oscillator."""

INTERVAL_STEPS = 240
"""Grid steps in the interval with which a sign change at every step is visible."""

STOP_CONTEXT = 4.0
"""Length of the interval relative to the stick phase in its middle [-]."""

MIN_INTERVAL_SHARE = 0.3
"""Minimum share of the regular length around a short stick phase [-]."""

Interval = tuple[float, float]


def choose_interval(response: Response, others: Iterable[Response], begin: float) -> Interval:
    """Return begin and end of the interval to draw.

    Parameters
    ----------
    response : Response
        Response of the reference.
    others : iterable of Response
        Responses of the other approaches.
    begin : float
        End of the settling time [s].

    Returns
    -------
    tuple of float
        Begin and end [s].

    Notes
    -----
    The interval contains the longest stick phase that fits together with the slip before and
    after it; else the beginning of a longer one; without stick phases the largest deviation
    of the acceleration.
    """
    end = (len(response) - 1) * response.dt
    least, most = (count * _reference_period(response) for count in INTERVAL_PERIODS)
    span = min(max(least, min(INTERVAL_STEPS * response.dt, most)), end - begin)
    stops = stuck_intervals(response, begin, end)
    fitting = [stop for stop in stops if stop[0] > begin and stop[1] <= 0.5 * span]
    if fitting:
        start, length = max(fitting, key=lambda stop: stop[1])
        middle, width = (
            start + 0.5 * length,
            max(STOP_CONTEXT * length, MIN_INTERVAL_SHARE * span),
        )
        return _interval_around(middle, min(width, span), begin, end)
    if stops:
        start, length = max(stops, key=lambda stop: stop[1])
        return _interval_around(start if start > begin else start + length, span, begin, end)
    return _interval_around(_largest_deviation_time(response, others, begin), span, begin, end)


def _largest_deviation_time(
    response: Response, others: Iterable[Response], begin: float
) -> float:
    """Return the time at which the acceleration of another response differs most [s]."""
    gaps = [acceleration_difference(response, other, begin) for other in others]
    worst = max(gaps, key=lambda gap: float(gap.max(initial=0.0)), default=np.empty(0))
    return begin + int(worst.argmax()) * response.dt if len(worst) else begin


def acceleration_difference(response: Response, other: Response, begin: float) -> Floats:
    """Return the absolute difference of two accelerations from `begin` [s] on [m/s²].

    The other response is interpolated to the grid of the first; a periodic orbit is repeated.
    """
    first = round(begin / response.dt)
    t = np.arange(first, len(response)) * response.dt
    acceleration = response.acceleration(slice(first, None))
    beside = np.interp(np.mod(t, repeat_time(other)), other.t, other.x_dd)
    gap: Floats = np.abs(beside - acceleration)
    return gap


def repeat_time(response: Response) -> float:
    """Return the period of a periodic orbit [s]; infinity for any other response."""
    if response.numerics.period_multiple is None:
        return inf
    assert response.trajectory is not None, "a periodic orbit has a trajectory"
    return response.trajectory.end


def cycle_interval(response: Response, first: float, last: float) -> Interval:
    """Return begin and end [s] of a full cycle around an interval, so that loops close."""
    if (length := repeat_time(response)) < inf:
        return 0.0, length
    end = (len(response) - 1) * response.dt
    least = _reference_period(response)
    if last - first >= least:
        return first, last
    return _interval_around(0.5 * (first + last), min(least, end), 0.0, end)


def _interval_around(middle: float, width: float, begin: float, end: float) -> Interval:
    """Return an interval of a given width around a time, shifted into [begin, end] [s]."""
    first = max(min(middle - 0.5 * width, end - width), begin)
    return first, min(first + width, end)


def _reference_period(response: Response) -> float:
    """Return the longest period of a harmonic base motion, else the natural period [s]."""
    if isinstance(response.motion, Sines) and response.motion.f:
        return 1.0 / min(response.motion.f)
    period = natural_period(response.plant)
    return period if period < inf else 1.0
