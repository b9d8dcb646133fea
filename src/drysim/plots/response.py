"""Plot response.png: acceleration and displacement over time, and the friction force.

The friction force is drawn over the relative displacement, the friction loop, and over the
relative velocity, beside the law's own force at steady sliding (the paper, Fig. 1).

A short response with few events is drawn in full. Any other response has two parts: an overview
(with very many points as an envelope from minimum to maximum) and below it a zoomed view around
the largest stroke. Every event is in a curve twice, with its values just before and just after,
so that jumps of force and acceleration are vertical. Stick phases are shaded, and points at
which the stroke limit is reached are marked. Other pictures use the curves and styles as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim import wording
from drysim.approach.solution import Response
from drysim.core.model import (
    BLOCK_SIZE,
    AnyLaw,
    DynamicLaw,
    Floats,
    PiecewiseLaw,
    Plant,
    StrokeLimits,
    acceleration_at,
    has_friction,
)
from drysim.metrics.table import PEAK_STROKE
from drysim.plots import style
from drysim.plots.style import Style, set_title
from drysim.study.outcome import Outcome
from drysim.wording import LengthUnit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.gridspec import GridSpec


ROW_HEIGHT = 2.15
"""Height of a row of panels [inch]; a loop on its own takes two."""

MAX_LINE_POINTS = 20_000
"""Grid points above which a zoomed view is added."""

MAX_EVENTS_WITHOUT_ZOOM = 60
"""Events above which a zoomed view is added."""

MAX_LIMIT_RATIO, MAX_LIMIT_RATIO_ZOOMED = 3.0, 1.3
"""Stroke limit over peak |x_r| up to which the limit is drawn [-]: full and zoomed view."""


def draw(outcome: Outcome) -> Figure:
    """Return the figure of a response."""
    motion = outcome.response
    zoomed = len(motion) > MAX_LINE_POINTS or len(motion.events) > MAX_EVENTS_WITHOUT_ZOOM
    rows = 4 if zoomed else 2
    figure, grid = style.panel_grid(rows, 2, rows * ROW_HEIGHT, width_ratios=(1.5, 1))
    if zoomed:
        _draw_zoomed(figure, grid, outcome)
    else:
        _draw_interval(figure, grid, slice(None), outcome, MAX_LIMIT_RATIO)
    overview = 2 if zoomed else 0
    entries = style.legend_entries(figure.axes[overview:] + figure.axes[:overview])
    style.finish_figure(figure, style.response_heading(outcome), entries)
    return figure


def _draw_zoomed(figure: Figure, grid: GridSpec, outcome: Outcome) -> None:
    """Draw an overview of a long response and a zoomed view below it."""
    motion, stroke = outcome.response, outcome.scenario.stroke
    part, unit = zoom_slice(motion, _settling_time(outcome)), _stroke_unit(outcome)
    ends = time_bounds(motion, slice(None))
    above, below = response_panels(figure, (grid[0, :], grid[1, :]), *ends, unit)
    if len(motion) > 2 * ENVELOPE_BINS:
        draw_bands(above, below, motion, unit)
    else:
        draw_lines(above, below, curve_with_events(motion, slice(None)), unit)
    if stroke:
        draw_limit(below, motion, stroke.limits, MAX_LIMIT_RATIO, unit)
    mark_settling_end(above, below, _settling_time(outcome))
    for axes in (above, below):
        axes.axvspan(*time_bounds(motion, part), **FRAME_STYLE)
    _draw_interval(figure, grid, part, outcome, MAX_LIMIT_RATIO_ZOOMED)
    figure.axes[3].set_xlabel("time [s], framed interval")


def _draw_interval(
    figure: Figure, grid: GridSpec, part: slice, outcome: Outcome, max_ratio: float
) -> None:
    """Draw an interval of a response: time histories, stick phases and friction force."""
    motion, stroke, unit = outcome.response, outcome.scenario.stroke, _stroke_unit(outcome)
    shown, (begin, end) = curve_with_events(motion, part), time_bounds(motion, part)
    above, below = response_panels(figure, (grid[-2, 0], grid[-1, 0]), begin, end, unit)
    draw_lines(above, below, shown, unit)
    shade_stuck(above, below, part, motion)
    if stroke:
        draw_limit(below, motion, stroke.limits, max_ratio, unit)
    if begin < _settling_time(outcome) < end:
        mark_settling_end(above, below, _settling_time(outcome))
    shown = closed_curve(shown, motion)
    if not has_friction(motion.law) or not np.ptp(shown.v_r):
        draw_loop(figure.add_subplot(grid[-2:, 1]), shown, motion, unit)
        return
    draw_loop(figure.add_subplot(grid[-2, 1]), shown, motion, unit)
    draw_friction_over_velocity(figure.add_subplot(grid[-1, 1]), shown, motion)


def _stroke_unit(outcome: Outcome) -> LengthUnit:
    """Return the unit of x_r, the same as that of its peak in the summary."""
    return wording.length_unit(outcome.metrics[PEAK_STROKE] or 0.0)


def _settling_time(outcome: Outcome) -> float:
    """Return the settling time excluded from the metrics [s]; 0 for a periodic orbit."""
    steady = outcome.response.numerics.period_multiple is not None
    return 0.0 if steady else outcome.scenario.measure.settle


# Panels: accelerations, relative displacement, friction loop.


CROWDED_MARKERS = 40
"""Markers above which they are drawn small, so that they do not hide the peaks."""

MAX_BASE_RATIO, CUT_OFF_RATIO = 10.0, 4.0
"""Acceleration of the base over that of the mass above which the base is cut off, and half the
height of the panel over the peak of the mass then [-]."""

DENSE_TURNING_POINTS, THIN_LINEWIDTH = 300, 0.6
"""Turning points above which a line would fill its panel, and the width of such a line [pt]."""

VISIBLE_LEVELS = 500
"""Number of distinguishable levels over the height of a panel."""

MIN_IMPACT_SHARE = 1e-6
"""Change of v_r at one instant over its peak above which it is an impact, not rounding [-]."""

CHARACTERISTIC_POINTS = 100
"""Points on either side of a friction characteristic that depends on the velocity."""

MARKED_POINTS = 12
"""Points below which each has a marker: the line alone may be too short to be visible."""

# Lines differ in lightness, width and dashes, so that they are distinct in greyscale. The base
# is drawn below the mass.
BASE_STYLE: Style = {"color": "#9d9d9d", "linewidth": 0.8, "zorder": 1.9}
MASS_STYLE: Style = {"color": "#0b3c6f", "linewidth": 1.4}
LIMIT_STYLE: Style = {"color": "#b3261e", "linewidth": 1.2, "linestyle": (0, (6, 3))}
STATIC_LIMIT_STYLE: Style = {"color": "#444444", "linewidth": 1.0, "linestyle": (0, (1, 2))}
CHARACTERISTIC_STYLE: Style = {
    **LIMIT_STYLE,
    "linewidth": 1.0,
    "linestyle": (0, (3, 2)),
    "zorder": 2.5,
}
VIOLATION_STYLE: Style = {
    "color": "#b3261e", "marker": "x", "markersize": 6, "zorder": 3, "linestyle": "none",
    "clip_on": False,
}  # fmt: skip
STUCK_STYLE: Style = {"facecolor": "#f0e2c0", "edgecolor": "none", "zorder": 0}
FRAME_STYLE: Style = {"facecolor": "#0000000c", "edgecolor": "black", "linewidth": 0.8}
SETTLING_STYLE: Style = {"color": "black", "linewidth": 1.0, "linestyle": (0, (7, 2, 1, 2))}
BASE_BAND_COLOR = "#bdbdbd"


def response_panels(
    figure: Figure, places: Sequence[Any], begin: float, end: float, unit: LengthUnit
) -> tuple[Axes, Axes]:
    """Return empty panels of acceleration (upper) and relative displacement (lower)."""
    above = figure.add_subplot(places[0])
    below = figure.add_subplot(places[1], sharex=above)
    set_title(above, "acceleration [m/s²]")
    above.tick_params(labelbottom=False)
    set_title(below, f"relative displacement xᵣ [{unit.symbol}]")
    below.set_xlabel("time [s]")
    if end > begin:
        below.set_xlim(begin, end)
    return above, below


def draw_lines(above: Axes, below: Axes, shown: Curve, unit: LengthUnit) -> None:
    """Draw acceleration and relative displacement over time."""
    mark = "." if len(shown.t) < MARKED_POINTS else ""
    above.plot(shown.t, shown.x_dd, **mass_style(shown.x_dd), marker=mark, label="mass ẍ")
    above.plot(shown.t, shown.u_dd, **base_style(shown.u_dd), label="base ü")
    _cut_off_base(above, np.std(shown.u_dd), np.std(shown.x_dd), np.abs(shown.x_dd).max())
    x_r = shown.x_r * unit.units_per_metre
    below.plot(shown.t, x_r, **MASS_STYLE, marker=mark)


def mass_style(series: Floats) -> Style:
    """Return the line style of the mass: thin for a dense line."""
    return {**MASS_STYLE, "linewidth": THIN_LINEWIDTH} if _is_dense(series) else MASS_STYLE


def base_style(series: Floats) -> Style:
    """Return the line style of the base: thin and lighter for a dense line."""
    thin = {"linewidth": THIN_LINEWIDTH, "color": BASE_BAND_COLOR}
    return BASE_STYLE | thin if _is_dense(series) else BASE_STYLE


def _is_dense(series: Floats) -> bool:
    """Whether a line has so many turning points that it would fill its panel.

    Turning points smaller than a visible level, such as rounding on a constant, do not count.
    """
    finite = series[np.isfinite(series)]
    scale = float(np.ptp(finite)) if len(finite) else 0.0
    if not scale:
        return False
    steps = np.diff(np.round(VISIBLE_LEVELS * (finite - finite.min()) / scale))
    reversals = int(np.count_nonzero(np.diff(np.signbit(steps[steps != 0]))))
    return reversals > DENSE_TURNING_POINTS


def draw_bands(above: Axes, below: Axes, motion: Response, unit: LengthUnit) -> None:
    """Draw a long response as envelopes, the mass in front of the base."""
    filled: tuple[tuple[Axes, Callable[[slice], Floats], str], ...] = (
        (above, motion.base, BASE_BAND_COLOR),
        (above, motion.acceleration, MASS_STYLE["color"]),
        (
            below,
            lambda part: motion.points(part).x_r * unit.units_per_metre,
            MASS_STYLE["color"],
        ),
    )
    widths, peaks = [], []
    for axes, series, color in filled:
        centre, low, high = envelope(series, len(motion))
        axes.fill_between(centre * motion.dt, low, high, color=color, linewidth=0.6)
        widths.append(np.mean(high - low))
        peaks.append(max(-low.min(), high.max()))
    _cut_off_base(above, widths[0], widths[1], peaks[1])


def _cut_off_base(axes: Axes, base: Any, mass: Any, peak: Any) -> None:
    """Cut off a base acceleration that would make that of the mass a straight line.

    `base` and `mass` are the widths of their curves in the same measure [m/s²], and `peak` is
    the largest acceleration of the mass [m/s²].
    """
    if base > MAX_BASE_RATIO * mass > 0:
        axes.set_ylim(-CUT_OFF_RATIO * peak, CUT_OFF_RATIO * peak)
        set_title(axes, "acceleration (base cut off) [m/s²]")


def shade_stuck(above: Axes, below: Axes, part: slice, motion: Response) -> None:
    """Shade the stick phases; of an elastic contact those without slip."""
    intervals = stuck_intervals(motion, *time_bounds(motion, part))
    for axes in (above, below):
        shade_intervals(axes, intervals, stuck_label(motion.law))


def shade_intervals(axes: Axes, intervals: Sequence[tuple[float, float]], label: str) -> None:
    """Shade intervals of time, each given by its begin and its length [s], as one artist."""
    if intervals:
        begin, length = np.array(intervals).T
        sides = np.column_stack((begin, begin + length, begin + length)).ravel()
        inside = np.tile((True, True, False), len(intervals))
        place = axes.get_xaxis_transform()
        axes.fill_between(
            sides, 0, 1, where=inside, transform=place, **STUCK_STYLE, label=label
        )


def stuck_label(law: AnyLaw) -> str:
    """Return the label of shaded phases: with an elastic contact the mass moves in them."""
    return "no slip" if law.is_elastic else "stuck"


def mark_settling_end(above: Axes, below: Axes, begin: float) -> None:
    """Mark the end of the settling time, if there is one."""
    if begin > 0:
        for axes in (above, below):
            axes.axvline(begin, **SETTLING_STYLE, label="end of settling time")


def draw_limit(
    axes: Axes, motion: Response, limits: StrokeLimits, max_ratio: float, unit: LengthUnit
) -> None:
    """Draw the stroke limits and mark where they are reached.

    A limit above `max_ratio` times the peak would flatten the curve and is omitted.
    """
    peak = largest_magnitude(motion, "x_r").value
    near = [
        level for level in (-limits.down, limits.up) if not abs(level) > max_ratio * peak > 0
    ]
    if not near:
        return
    hits = stop_impacts(motion)
    what = "end stops" if hits else "stroke limit"
    texts = [wording.format_number(level * unit.units_per_metre) for level in near]
    if limits.up == limits.down:
        texts = [f"±{texts[-1]}"]
    label = f"{what} {' and '.join(texts)} {unit.symbol}"  # one entry of the legend
    for level in near:
        axes.axhline(level * unit.units_per_metre, **LIMIT_STYLE, label=label)
    begin, end = axes.get_xlim()
    marked = np.array(hits or excursions(motion, limits), dtype=float).reshape(-1, 2)
    marked = marked[(marked[:, 0] >= begin) & (marked[:, 0] <= end)] * (
        1.0,
        unit.units_per_metre,
    )
    if len(marked):
        label = "stop hit" if hits else "limit exceeded"
        crowded = {"markersize": 3.5} if len(marked) > CROWDED_MARKERS else {}
        axes.plot(*marked.T, **{**VIOLATION_STYLE, **crowded}, label=label)


def stop_impacts(response: Response) -> list[tuple[float, float]]:
    """Return time [s] and x_r [m] of every impact on an end stop."""
    stops, trajectory = response.law.stops, response.trajectory
    if stops is None or trajectory is None:
        return []
    (t, v_r), limits = trajectory.hits(), stops.limits
    x_r = np.where(v_r > 0.0, limits.up, -limits.down)
    return list(zip(t.tolist(), x_r.tolist(), strict=True))


def excursions(response: Response, limits: StrokeLimits) -> list[tuple[float, float]]:
    """Return time [s] and x_r [m] of the maximum of every excursion beyond a limit."""
    peaks: list[tuple[float, float]] = []
    continues = False
    for part in response.parts():
        x_r = response.points(part).x_r
        size = np.abs(x_r)
        beyond = limits.side(x_r) != 0.0
        for a, b in runs(beyond):
            index = a + int(size[a:b].argmax())
            peak = (part.start + index) * response.dt, float(x_r[index])
            if not (continues and a == 0):
                peaks.append(peak)
            elif size[index] > abs(peaks[-1][1]):
                peaks[-1] = peak
        continues = bool(beyond[-1])
    return peaks


def draw_loop(axes: Axes, shown: Curve, motion: Response, unit: LengthUnit) -> None:
    """Draw the friction force over the relative displacement; the enclosed area is its work.

    Without friction the damping force is drawn.
    """
    x_r = shown.x_r * unit.units_per_metre
    axes.set_xlabel(f"relative displacement xᵣ [{unit.symbol}]", loc="left")
    axes.locator_params(axis="x", nbins=5)
    if not has_friction(motion.law):
        set_title(axes, "damping force b vᵣ [N]")
        damping = motion.law.damping
        b = motion.plant.b if damping is None else np.where(shown.v_r > 0.0, *damping)
        force = b * shown.v_r
        axes.plot(x_r, force, **mass_style(force))
        return
    set_title(axes, "friction force [N]")
    mark = "." if len(shown.t) < MARKED_POINTS else ""
    axes.plot(x_r, shown.F_f, **mass_style(shown.F_f), marker=mark)
    if not has_varying_load(motion.law):
        # A contact that never sticks and has equal limits has no static limit.
        static = motion.law.can_stick or motion.law.F_fs > motion.law.F_fk
        label = "static limit" if static else "friction limit"
        limits = motion.law.F_fs, (motion.law.compression or (0.0, motion.law.F_fs))[1]
        for side, F_fs in zip((1, -1), limits, strict=True):
            axes.axhline(side * F_fs, **STATIC_LIMIT_STYLE, label=label)


def draw_friction_over_velocity(axes: Axes, shown: Curve, motion: Response) -> None:
    """Draw the friction force over the relative velocity, and the law's own characteristic."""
    unit = wording.length_unit(float(np.abs(shown.v_r).max()))
    set_title(axes, "friction force [N]")
    axes.set_xlabel(f"relative velocity vᵣ [{unit.symbol}/s]", loc="left")
    axes.locator_params(axis="x", nbins=5)
    v_r = shown.v_r * unit.units_per_metre
    # An impact on a rigid stop passes no velocity in between.
    steps = np.abs(np.diff(v_r)) > MIN_IMPACT_SHARE * np.abs(v_r).max()
    impacts = np.flatnonzero((np.diff(shown.t) == 0.0) & steps) + 1
    broken = np.insert(v_r, impacts, np.nan), np.insert(shown.F_f, impacts, np.nan)
    axes.plot(*broken, **mass_style(shown.F_f))
    if not has_varying_load(motion.law):
        low, high = min(float(shown.v_r.min()), 0.0), max(float(shown.v_r.max()), 0.0)
        v, force = characteristic(motion.law, low, high)
        label = "at steady sliding, and sticking"
        axes.plot(v * unit.units_per_metre, force, **CHARACTERISTIC_STYLE, label=label)


def characteristic(law: AnyLaw, low: float, high: float) -> tuple[Floats, Floats]:
    """Return the friction force [N] at steady sliding over velocities [m/s], as a curve.

    At v_r = 0 the curve is vertical, from one static limit to the other: what the contact bears
    at rest. A law of constant force has four corners, another one many points. The normal force
    is constant; the curve runs from `low` <= 0 to `high` >= 0 [m/s].
    """
    if isinstance(law, DynamicLaw):
        from drysim.core.dynamic_friction import stribeck_curve

        def slide(v: float, d: int) -> float:
            return float(d * stribeck_curve(law, v) + law.sigma_2 * v)

        # Even in the square root: the curve is steepest at rest.
        share = np.linspace(0.0, 1.0, CHARACTERISTIC_POINTS) ** 2
        down, up = (low * share[::-1]).tolist(), (high * share).tolist()
        force = [*(slide(v, -1) for v in down), *(slide(v, 1) for v in up)]
        return np.array(down + up), np.array(force)
    back_fk, back_fs = law.compression or (law.F_fk, law.F_fs)
    v = np.array([low, 0.0, 0.0, 0.0, 0.0, high])
    return v, np.array([-back_fk, -back_fk, -back_fs, law.F_fs, law.F_fk, law.F_fk])


def has_varying_load(law: AnyLaw) -> bool:
    """Whether the normal force varies, so that no limit is constant."""
    return bool(law.variation) or law.force_record is not None


# Curves of a response for drawing.


ENVELOPE_BINS = 1200
"""Bins of an envelope: about the width of the picture in pixels."""

ZOOM_PERIODS = 8.0
"""Length of a zoomed view in natural periods."""

SEPARATION_TOLERANCE = 1e-9
"""Normal force over its mean below which the contact is open [-]: rounding at separation."""

MAX_ZOOM_SHARE = 0.4
"""Maximum share of the response in a zoomed view [-], so that it shows more detail."""

ZOOM_POINTS = (150, 4000)
"""Minimum and maximum number of grid points in a zoomed view."""


class Curve(NamedTuple):
    """Time histories of an interval, with two points per event: just before and just after."""

    t: Floats
    """Time [s], shape (n,)."""
    u_dd: Floats
    x_dd: Floats
    """Acceleration of base and mass [m/s²], shape (n,)."""
    x_r: Floats
    v_r: Floats
    """Relative displacement [m] and velocity [m/s], shape (n,)."""
    F_f: Floats
    """Friction force [N], shape (n,)."""


class Peak(NamedTuple):
    """Largest magnitude of a series, and the index of its grid point."""

    value: float
    point: int


def curve_with_events(response: Response, part: slice) -> Curve:
    """Return a part of the grid with its events: force and acceleration jump vertically.

    The points are in the order of time; at equal times an event precedes a grid point.
    """
    points = grid_curve(response, part)
    sides = _event_sides(response, *time_bounds(response, part))
    merged = [np.concatenate(series) for series in zip(*sides, points, strict=True)]
    order = np.argsort(merged[0], kind="stable")
    return Curve(*(series[order] for series in merged))


def closed_curve(shown: Curve, response: Response) -> Curve:
    """Return the whole of a periodic orbit with its begin as its end; another curve as it is.

    The last grid point may lie before the end of the period.
    """
    whole = shown.t[0] == 0.0 and shown.t[-1] >= (len(response) - 1) * response.dt
    if not (whole and response.numerics.period_multiple):
        return shown
    return Curve(*(np.append(series, series[0]) for series in shown))


def grid_curve(response: Response, part: slice) -> Curve:
    """Return a part of the grid without events."""
    first, last, _ = part.indices(len(response))
    t = np.arange(first, last) * np.float64(response.dt)
    u_dd, x_dd = response.base(part), response.acceleration(part)
    x_r, v_r, *_ = response.points(part)
    return Curve(t, u_dd, x_dd, x_r, v_r, response.friction(part))


def time_bounds(response: Response, part: slice) -> tuple[float, float]:
    """Return begin and end [s] of a part; the motion may end after the last grid point."""
    first, last, _ = part.indices(len(response))
    begin, trajectory = first * response.dt, response.trajectory
    if trajectory is None or last < len(response):
        return begin, (last - 1) * response.dt
    return begin, trajectory.end


def _event_sides(response: Response, begin: float, end: float) -> tuple[Curve, Curve]:
    """Return the one-sided values at the events of an interval: just before and just after."""
    if response.points(slice(0, 1)).F_stop is not None or response.law.is_directed:
        return _event_sides_at_stops(response, begin, end)
    events = response.events
    directions = np.sign(events.kind)
    # The first event is the state at t = 0, without a jump.
    inside = np.flatnonzero((events.t >= begin) & (events.t <= end))
    inside = inside[(inside > 0) & response.law.can_stick]
    t, x_r, F_L = events.t[inside], events.x_r[inside], events.F_L[inside]
    plant, law = response.plant, response.law
    if isinstance(law, PiecewiseLaw) and law.may_separate:
        limit = law.F_fk * law.load(t)
        # While the contact opens, closes or is open no force jumps, and v_r may be nonzero.
        in_contact = limit > SEPARATION_TOLERANCE * law.F_fk
        inside, t, x_r, F_L, limit = (each[in_contact] for each in (inside, t, x_r, F_L, limit))
    elif not isinstance(law, DynamicLaw) and not law.is_elastic:
        limit = law.F_fk * (1 + law.variation * np.sin(law.omega * t + law.phase))
    else:
        limit = np.full_like(t, law.F_fs)
    u_dd = (F_L - plant.k_x * x_r) / plant.m

    def side(direction: Floats) -> Curve:
        F_f = np.where(direction == 0, -F_L, direction * limit)
        x_dd = -(plant.k_x * x_r + F_f) / plant.m
        return Curve(t, u_dd, x_dd, x_r, np.zeros_like(t), F_f)

    return side(directions[inside - 1]), side(directions[inside])


def _event_sides_at_stops(response: Response, begin: float, end: float) -> tuple[Curve, Curve]:
    """Return the one-sided values at events where v_r may be nonzero, as at end stops."""
    trajectory = response.trajectory
    assert trajectory is not None, "its events are located"
    t = trajectory.events.t[1:]
    t = t[(t >= begin) & (t <= end)]

    def side(t_side: Floats) -> Curve:
        x_r, v_r, _, x_dd, F_f, *_ = trajectory.at(t_side)
        return Curve(t, acceleration_at(response.motion, t_side), x_dd, x_r, v_r, F_f)

    return side(np.nextafter(t, 0.0)), side(t)


def runs(mask: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Yield the first index of every run of true elements, and the index behind its last."""
    steps = np.flatnonzero(np.diff(mask, prepend=False, append=False)).tolist()
    yield from zip(steps[::2], steps[1::2], strict=True)


def natural_period(plant: Plant) -> float:
    """Return the natural period [s], infinity without a spring."""
    return 2.0 * pi * sqrt(plant.m / plant.k_x) if plant.k_x > 0.0 else inf


def envelope(series: Callable[[slice], Floats], length: int) -> tuple[Floats, Floats, Floats]:
    """Return centre [grid points], minimum and maximum of each bin of a long series.

    `series` returns the values of a part of the grid, so that they are never in memory as a
    whole; `length` is the number of grid points, at least `ENVELOPE_BINS`.
    """
    edges = np.linspace(0, length, ENVELOPE_BINS + 1).astype(np.int64)
    low, high = np.empty(ENVELOPE_BINS), np.empty(ENVELOPE_BINS)
    step = max(ENVELOPE_BINS * BLOCK_SIZE // length, 1)
    for start in range(0, ENVELOPE_BINS, step):
        begin, *inner, end = edges[start : start + step + 1].tolist()
        values, starts = series(slice(begin, end)), [0, *(edge - begin for edge in inner)]
        np.minimum.reduceat(values, starts, out=low[start : start + step])
        np.maximum.reduceat(values, starts, out=high[start : start + step])
    return (edges[:-1] + edges[1:]) / 2, low, high


def largest_magnitude(response: Response, name: str, begin: int = 0) -> Peak:
    """Return the largest magnitude of ü or of a series of `Points` from a grid point on."""
    largest = Peak(-1.0, begin)
    for part in response.parts():
        of = response.base(part) if name == "u_dd" else getattr(response.points(part), name)
        values = np.abs(of[max(begin - part.start, 0) :])
        if len(values) and values.max() > largest.value:
            largest = Peak(float(values.max()), part.stop - len(values) + int(values.argmax()))
    return largest


def zoom_slice(response: Response, begin: float) -> slice:
    """Return the part of the grid around the largest |x_r|, or around the largest |ü| if stuck.

    The settling time before `begin` [s] does not count.
    """
    length, settled = len(response), min(round(begin / response.dt), len(response) - 1)
    x_r = response.points(slice(0, 1)).x_r
    moves = any((response.points(part).x_r != x_r).any() for part in response.parts())
    peak = largest_magnitude(response, "x_r" if moves else "u_dd", settled).point
    points = ZOOM_PERIODS * natural_period(response.plant) / response.dt
    points = min(max(points, ZOOM_POINTS[0]), ZOOM_POINTS[1])
    points = min(points, max(MAX_ZOOM_SHARE * length, 2.0))
    first = int(min(max(peak - points / 2, 0), length - points))
    return slice(first, first + int(points))


def stuck_intervals(response: Response, begin: float, end: float) -> list[tuple[float, float]]:
    """Return begin and length [s] of every stick phase in an interval."""
    never_sticks = isinstance(response.law, DynamicLaw) and not response.law.can_stick
    if not has_friction(response.law) or never_sticks:
        return []
    events = response.events
    until = np.append(events.t[1:], time_bounds(response, slice(None))[1])
    stuck = events.kind == 0
    first = np.maximum(events.t[stuck], begin)
    last = np.minimum(until[stuck], end)
    return [(a, b - a) for a, b in zip(first.tolist(), last.tolist(), strict=True) if b > a]
