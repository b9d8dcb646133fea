"""Plot fit.png: measured and fitted motion, residuals, friction force; and profiles.png.

The friction force as measured is that of the force balance with the fitted values. It follows
from the fitted force and the residual of the acceleration, F_f - m (x_dd,measured - x_dd), so
that springs, dampers and end stops need not be subtracted one by one. Without a measured
acceleration the residual is differentiated, smoothed over part of a natural period.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from math import ceil, inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drysim.core.model import Floats
from drysim.plots import style
from drysim.plots.response import (
    ENVELOPE_BINS,
    FRAME_STYLE,
    LIMIT_STYLE,
    MASS_STYLE,
    ZOOM_PERIODS,
    envelope,
    natural_period,
    runs,
    shade_intervals,
)
from drysim.plots.style import KeyLabel, Style, plotted, set_axis, set_title, spans_decade
from drysim.plots.sweep import COLORMAP_END, MARKERS
from drysim.scenario.fit import CHANNEL_UNITS
from drysim.scenario.model import STATIC_PATHS
from drysim.scenario.text import short_key
from drysim.study.fit import FitResult, Profile, format_profile_interval
from drysim.study.fit_curves import FittedCurve
from drysim.study.fit_law import EXACT, ChannelFit, Parameter
from drysim.study.fit_profiles import CHI_SQUARE_95
from drysim.study.statistics import NORMAL_95
from drysim.wording import (
    display_unit,
    format_count,
    format_interval,
    format_number,
    format_percent,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNIT_HEIGHT = 0.62
"""Height of a unit of the height ratios [inch]."""

OVERVIEW, CHANNEL, RESIDUAL, SQUARE, CURVE = 1.4, 2.8, 2.0, 4.6, 5.0
"""Heights of the kinds of rows, in units."""

SHORTEST_SHOWN, LONGEST_SHARE = 150, 0.4
"""Number of samples of the shown interval at least; largest share of the record, above which
the whole record is shown."""

SMOOTHING = 0.25
"""Window that smooths a differentiated residual, in natural periods."""

MAX_DOTS = 20_000
"""Number of dots of a panel above which not every sample is drawn."""

USUAL, SHOWN_SHARE = 6.0, 0.98
"""Residuals, in units of the noise, that are always within the axis, and their share."""

BINS = 24
"""Number of bins of the mean residual over the velocity."""

MOST_BINNED_NOISE = 0.3
"""Standard error of a mean residual, in units of the noise, above which it is not drawn."""

MEASURED_STYLE: Style = {
    "color": "#9d9d9d", "linestyle": "none", "marker": "o", "markersize": 3.2,
    "markeredgewidth": 0.0, "zorder": 1.9,
}  # fmt: skip
FITTED_STYLE: Style = {**MASS_STYLE, "linewidth": 0.9}
DOT_STYLE: Style = {
    "linestyle": "none", "marker": "o", "markersize": 1.6, "markeredgewidth": 0.0,
}  # fmt: skip
USED_COLOR, UNUSED_COLOR = "#3b6ea5", "#c4c4c4"
MEAN_STYLE: Style = {"color": "black", "linewidth": 1.3, "marker": "s", "markersize": 3.2}
CHANNEL_DOTS: tuple[Style, ...] = (
    {**DOT_STYLE, "color": "#6f95bf"},
    {**DOT_STYLE, "color": "#e3b778", "zorder": 1.8},
    {**DOT_STYLE, "color": "#a9c9a4", "zorder": 1.7},
)
MEAN_LINES = ("-", (0, (4, 2)), (0, (1, 1.5)))
NOISE_STYLE: Style = {"color": "#444444", "linewidth": 1.0, "linestyle": (0, (1, 2))}
LEGEND_DOT = 5.0
"""Size of a dot in the legend [pt]."""
HELD_OUT_STYLE: Style = {
    "facecolor": "none", "edgecolor": "#b9b9b9", "hatch": "//", "linewidth": 0.0, "zorder": 0.5,
}  # fmt: skip
UNITY_STYLE: Style = {"color": "#9d9d9d", "linewidth": 0.8, "zorder": 0.5}
LINEAR_STYLE: Style = {"color": "#8a8a8a", "linewidth": 1.6, "linestyle": (0, (2, 1.5))}
INTERVAL_STYLE: Style = {"facecolor": "#e3ebf5", "edgecolor": "none", "zorder": 0}

SYMBOLS = {
    "x_dd": "acceleration of the mass ẍ",
    "x_r": "relative displacement xᵣ",
    "v_r": "relative velocity vᵣ",
    "F_f": "friction force",
}
SHORT_SYMBOLS = {"x_dd": "ẍ", "x_r": "xᵣ", "v_r": "vᵣ", "F_f": "F_f"}


class Scale(NamedTuple):
    """Displayed unit of a channel: units per SI unit, and symbol."""

    factor: float
    unit: str


# fit.png


def draw_fit(result: FitResult) -> Figure:
    """Return the figure of a fit: motion, residuals, friction force; or the curves."""
    if result.curves:
        return draw_fitted_curves(result)
    channels, t = result.channels, result.measurement.t
    part = shown_part(result)
    zoomed = part.stop - part.start < len(t)
    heights = [OVERVIEW] * zoomed + [CHANNEL] * len(channels) + [RESIDUAL] * len(channels)
    height = UNIT_HEIGHT * (sum(heights) + SQUARE)
    figure, grid = style.panel_grid(
        len(heights) + 1, 2, height, height_ratios=[*heights, SQUARE]
    )
    rows = [figure.add_subplot(grid[i, :]) for i in range(len(heights))]
    if zoomed:
        draw_overview(rows.pop(0), result, part)
    for i, channel in enumerate(channels):
        draw_channel(rows[i], result, channel, part)
        draw_residuals(rows[len(channels) + i], result, channel)
    remark = ", framed interval" if zoomed else ""
    rows[len(channels) - 1].set_xlabel(f"time [s]{remark}")
    rows[-1].set_xlabel("time [s]")
    for axes in rows[: len(channels) - 1] + rows[len(channels) : -1]:
        axes.tick_params(labelbottom=False)
    draw_residuals_over_velocity(figure.add_subplot(grid[-1, 0]), result)
    draw_force(figure.add_subplot(grid[-1, 1]), result)
    style.finish_figure(figure, heading(result))
    return figure


def draw_fitted_curves(result: FitResult) -> Figure:
    """Return the figure of a fit to curves: each ratio over the frequency, and residuals."""
    ratios = [channel.name for channel in result.channels]
    heights = [CURVE, RESIDUAL] * len(ratios)
    height = UNIT_HEIGHT * sum(heights)
    figure, grid = style.panel_grid(len(heights), 1, height, height_ratios=heights)
    for i, ratio in enumerate(ratios):
        upper, lower = (figure.add_subplot(grid[2 * i + k]) for k in (0, 1))
        curves = [curve for curve in result.curves if curve.ratio == ratio]
        draw_ratio(upper, curves)
        draw_relative_residuals(lower, curves, result.channels[i])
        label = KeyLabel("frequency [Hz]" if i == len(ratios) - 1 else "")
        every = np.concatenate([curve.frequency for curve in curves])
        low, high = float(every.min()), float(every.max())
        if low == high:
            low, high = 0.5 * low, 2.0 * high
        for axes, text in ((upper, KeyLabel("")), (lower, label)):
            set_axis(axes, "x", text, low, high, spans_decade([low, high]))
    style.finish_figure(figure, heading(result))
    return figure


def curve_styles(curves: Sequence[FittedCurve]) -> list[Style]:
    """Return color and marker of each level, as those of the lines of a sweep."""
    import matplotlib

    colormap, last = matplotlib.colormaps["viridis"], max(len(curves) - 1, 1)
    return [
        {"color": colormap(COLORMAP_END * i / last), "marker": MARKERS[i % len(MARKERS)]}
        for i in range(len(curves))
    ]


def draw_ratio(axes: Axes, curves: Sequence[FittedCurve]) -> None:
    """Draw a ratio over the frequency: measured as markers, fitted as lines."""
    metric = plotted(curves[0].ratio)
    for curve, look in zip(curves, curve_styles(curves), strict=True):
        axes.plot(
            curve.frequency, curve.fitted, color=look["color"], linewidth=1.3,
            label=f"fitted, {curve.level}",
        )  # fmt: skip
        axes.plot(
            curve.frequency, curve.measured, **look, linestyle="none", markersize=4,
            markerfacecolor="white", label=f"measured, {curve.level}", clip_on=False,
        )  # fmt: skip
    every = np.concatenate([[*curve.measured, *curve.fitted] for curve in curves])
    positive = every[every > 0.0]
    axes.axhline(1.0, **UNITY_STYLE)
    is_log = len(positive) == len(every) and spans_decade(every.tolist())
    low, high = (0.9 * float(positive.min()), 1.1) if is_log else (0.0, 1.05)
    set_axis(axes, "y", KeyLabel(""), low, max(high, 1.06 * float(every.max())), is_log)
    axes.tick_params(labelbottom=False)
    set_title(axes, metric.full_title)


def draw_relative_residuals(
    axes: Axes, curves: Sequence[FittedCurve], channel: ChannelFit
) -> None:
    """Draw measured minus fitted values, in percent of the measured ones."""
    relative = [
        100.0 * (curve.measured - curve.fitted) / np.where(curve.measured, curve.measured, 1.0)
        for curve in curves
    ]
    noise = 100.0 * channel.noise
    limit, beyond = axis_limit(np.concatenate(relative) / noise)
    for curve, values, look in zip(curves, relative, curve_styles(curves), strict=True):
        shown = np.clip(values, -limit * noise, limit * noise)
        axes.plot(curve.frequency, shown, **look, linestyle="none", markersize=3, clip_on=False)
    for side in (-NORMAL_95, NORMAL_95):
        axes.axhline(side * noise, **NOISE_STYLE, label="±1.96 times the noise")
    axes.set_ylim(-1.08 * limit * noise, 1.08 * limit * noise)
    symbol = plotted(channel.name).symbol.partition(" ")[0]
    remark = f", {beyond} beyond the axis" if beyond else ""
    set_title(axes, f"residual of {symbol} [%], noise {format_number(noise, '%', 3)}{remark}")


def heading(result: FitResult) -> style.Heading:
    """Return the heading: values with their intervals, then how well they fit."""
    metrics, (agree, starts) = result.metrics, result.starts
    values = "; ".join(describe_value(parameter, result) for parameter in result.parameters)
    parts = [f"{law_words(result)}fit error {format_percent(metrics['fit_error'])}"]
    held_out = metrics["fit_error_held_out"]
    if held_out is not None:
        parts.append(f"on the part held out {format_percent(held_out)}")
    noun = "values" if result.curves else "samples"
    parts.append(f"{int(result.selected.sum())} {noun} fitted")
    if starts > 1:
        parts.append(f"{agree} of {format_count(starts, 'start')} agree")
    return style.make_heading(result.source, values, "", ", ".join(parts))


def law_words(result: FitResult) -> str:
    """Return the friction law, if several were compared."""
    if len(result.laws) < 2:
        return ""
    best, *others = result.laws
    tied = [score.law for score in others if score.tied]
    return f"{best.law}, as good as {' and '.join(tied)}: " if tied else f"{best.law}: "


def describe_value(parameter: Parameter, result: FitResult) -> str:
    """Return a fitted value with half the width of its interval."""
    name = short_key(parameter.key, [each.key for each in result.parameters])
    if parameter.deviation is None:
        return f"{name} not determined"
    shown = parameter.displayed
    return f"{name} {format_interval(shown.value, half_width(shown), shown.unit)}"


def scale_of(result: FitResult, name: str) -> Scale:
    """Return the displayed unit of a channel."""
    size = float(np.abs(result.measurement.channels[name]).max())
    return Scale(*display_unit(CHANNEL_UNITS[name], size))


def shown_part(result: FitResult) -> slice:
    """Return the fitted interval with the largest motion, or all samples of a short record."""
    n, dt = len(result.measurement.t), result.measurement.dt
    rig = result.source.fit is not None and result.source.fit.is_rig
    period = inf if rig else natural_period(result.scenario.oscillator.plant())
    count = max(ZOOM_PERIODS * period / dt, SHORTEST_SHOWN)
    if count > LONGEST_SHARE * n:
        return slice(0, n)
    power = np.zeros(n)
    for channel in result.channels:
        values = result.measurement.channels[channel.name] - (channel.offset or 0.0)
        power += (values / (float(values.std()) or 1.0)) ** 2
    sums = np.concatenate(([0.0], np.cumsum(power[: max(len(result.selected), int(count))])))
    first = int((sums[int(count) :] - sums[: len(sums) - int(count)]).argmax())
    return slice(first, first + int(count))


def measured_values(result: FitResult, channel: ChannelFit) -> Floats:
    """Return the measured samples of a channel without its offset."""
    values: Floats = result.measurement.channels[channel.name] - (channel.offset or 0.0)
    return values


def draw_overview(axes: Axes, result: FitResult, part: slice) -> None:
    """Draw the first channel over the whole record, and frame the shown interval."""
    t, channel = result.measurement.t, result.channels[0]
    scale = scale_of(result, channel.name)
    measured = scale.factor * measured_values(result, channel)
    fitted = scale.factor * result.prediction.channels[channel.name]
    if len(t) > 2 * ENVELOPE_BINS:
        times, low, high = envelope(lambda bins: measured[bins], len(t))
        times = t[0] + times * result.measurement.dt
        axes.fill_between(times, low, high, color=MEASURED_STYLE["color"], linewidth=0.4)
        _, low, high = envelope(lambda bins: fitted[bins], len(t))
        for line in (low, high):
            axes.plot(times, line, color=FITTED_STYLE["color"], linewidth=0.5)
    else:
        axes.plot(t, measured, color=MEASURED_STYLE["color"], linewidth=2.0)
        axes.plot(t, fitted, color=FITTED_STYLE["color"], linewidth=0.6)
    set_title(axes, f"whole record: {SHORT_SYMBOLS[channel.name]} [{scale.unit}]")
    axes.axvspan(t[part.start], t[part.stop - 1], **FRAME_STYLE)
    shade_held_out(axes, result)
    axes.set_xlim(t[0], t[-1])


def draw_channel(axes: Axes, result: FitResult, channel: ChannelFit, part: slice) -> None:
    """Draw a measured and fitted channel over an interval, with shaded stick phases."""
    t, scale = result.measurement.t[part], scale_of(result, channel.name)
    error = format_percent(channel.error)
    name = SYMBOLS[channel.name]
    if result.spring_in_force:
        name = "force of friction, spring and damper"
    set_title(axes, f"{name} [{scale.unit}], fit error {error}")
    measured = scale.factor * measured_values(result, channel)[part]
    draw_dots(axes, t, measured, "measured", **MEASURED_STYLE)
    fitted = scale.factor * result.prediction.channels[channel.name][part]
    axes.plot(t, fitted, **FITTED_STYLE, label="fitted")
    stuck = runs(result.prediction.mode[part] == 0)
    intervals = [(t[i], t[j - 1] - t[i]) for i, j in stuck]
    shade_intervals(axes, intervals, "stuck, as fitted")
    axes.set_xlim(t[0], t[-1])
    if t[-1] > result.fitted_end:
        shade_held_out(axes, result)


def draw_dots(axes: Axes, x: Floats, y: Floats, label: str, **dots: Any) -> None:
    """Draw dots, of very many an evenly spaced part; they are larger in the legend."""
    every = ceil(len(x) / MAX_DOTS)
    axes.plot(x[::every], y[::every], **dots)
    if label:
        axes.plot([], [], **{**dots, "markersize": LEGEND_DOT}, label=label)


def shade_held_out(axes: Axes, result: FitResult) -> None:
    """Shade the part of the record that is held out, if there is one."""
    end = float(result.measurement.t[-1])
    if result.fitted_end < end:
        axes.axvspan(result.fitted_end, end, **HELD_OUT_STYLE, label="held out")


def draw_residuals(axes: Axes, result: FitResult, channel: ChannelFit) -> None:
    """Draw the residuals of a channel over time, those that were not fitted lighter."""
    t, scale = result.measurement.t, scale_of(result, channel.name)
    noise = channel.noise * scale.factor
    residuals = scale.factor * result.residuals(channel)
    limit, beyond = axis_limit(residuals / noise)
    shown = np.clip(residuals, -limit * noise, limit * noise)
    fitted = np.zeros(len(t), dtype=bool)
    fitted[: len(result.selected)] = result.selected
    held_out = t > result.fitted_end
    for mask, color, label in (
        (fitted, USED_COLOR, "residual"),
        (held_out, USED_COLOR, ""),
        (~fitted & ~held_out, UNUSED_COLOR, "next to an event: not fitted"),
    ):
        if mask.any():
            draw_dots(axes, t[mask], shown[mask], label, **DOT_STYLE, color=color)
    for side in (-NORMAL_95, NORMAL_95):
        axes.axhline(side * noise, **NOISE_STYLE, label="±1.96 times the noise")
    shade_held_out(axes, result)
    axes.set_ylim(-1.08 * limit * noise, 1.08 * limit * noise)
    axes.set_xlim(t[0], t[-1])
    remark = f", {beyond} beyond the axis" if beyond else ""
    symbol = SHORT_SYMBOLS[channel.name]
    level = format_number(noise, scale.unit, 3)
    set_title(axes, f"residual of {symbol} [{scale.unit}], noise {level}{remark}")


def axis_limit(relative: Floats) -> tuple[float, int]:
    """Return the end of an axis of residuals in units of the noise, and how many are beyond."""
    size = np.abs(relative)
    usual = max(USUAL, 1.2 * float(np.quantile(size, SHOWN_SHARE)))
    limit = max(min(float(size.max()), usual), 1.1 * NORMAL_95)
    return limit, int(np.sum(size > limit))


def draw_residuals_over_velocity(axes: Axes, result: FitResult) -> None:
    """Draw the residuals of all channels, in units of the noise, over v_r, and their means."""
    v_r = set_velocity_axis(axes, result)
    used = np.ones(len(v_r), dtype=bool)
    used[: len(result.selected)] = result.selected
    relative = [result.residuals(channel)[used] / channel.noise for channel in result.channels]
    limit, _ = axis_limit(np.concatenate(relative))
    for i, channel in enumerate(result.channels):
        symbol = SHORT_SYMBOLS[channel.name]
        residuals = np.clip(relative[i], -limit, limit)
        several = len(result.channels) > 1
        label = f"residual of {symbol} over vᵣ" if several else ""
        draw_dots(axes, v_r[used], residuals, label, **CHANNEL_DOTS[i])
        middle, mean = binned_means(v_r[used], residuals)
        if len(middle):
            axes.plot(
                middle, mean, **MEAN_STYLE, linestyle=MEAN_LINES[i],
                markerfacecolor="white" if i else "black",
                label=f"mean residual of {symbol}" if several else "mean residual",
            )  # fmt: skip
    axes.set_ylim(-1.08 * limit, 1.08 * limit)
    set_title(axes, "residual / noise [–]")


def set_velocity_axis(axes: Axes, result: FitResult) -> Floats:
    """Label the x-axis of a panel over v_r, and return v_r in its displayed unit."""
    v_r = result.prediction.channels["v_r"]
    scale = Scale(*display_unit("m/s", float(np.abs(v_r).max())))
    axes.locator_params(axis="x", nbins=6)
    axes.set_xlabel(f"relative velocity vᵣ [{scale.unit}]", loc="left")
    shown: Floats = scale.factor * v_r
    return shown


def binned_means(positions: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return the middle and the mean of bins of equal width with enough samples."""
    low, high = float(positions.min()), float(positions.max())
    if low == high:
        return np.array([]), np.array([])
    place = np.minimum((BINS * (positions - low) / (high - low)).astype(int), BINS - 1)
    count = np.bincount(place, minlength=BINS)
    enough = count >= (1.0 / MOST_BINNED_NOISE) ** 2
    mean = np.bincount(place, values, BINS)[enough] / count[enough]
    middle: Floats = low + (np.flatnonzero(enough) + 0.5) * (high - low) / BINS
    return middle, mean


def draw_force(axes: Axes, result: FitResult) -> None:
    """Draw the friction force over v_r, as measured and as fitted."""
    v_r, fitted = set_velocity_axis(axes, result), result.prediction.channels["F_f"]
    measured = measured_force(result)
    if result.spring_in_force:
        channels, plant = result.prediction.channels, result.scenario.oscillator.plant()
        of_plant = plant.k_x * channels["x_r"] + plant.b * channels["v_r"]
        measured, fitted = measured - of_plant, fitted - of_plant
    label = "measured force" if "F_f" in result.measurement.channels else (
        "force by the measured acceleration" if "x_dd" in result.measurement.channels
        else "force by the measured motion, smoothed"
    )  # fmt: skip
    draw_dots(axes, v_r, measured, label, **{**MEASURED_STYLE, "markersize": 2.2})
    dark: Style = {**DOT_STYLE, "color": FITTED_STYLE["color"]}
    draw_dots(axes, v_r, fitted, "fitted force", **dark)
    set_title(axes, "friction force [N]")
    size = float(np.abs(fitted).max())
    limit = max(1.3 * size, 1.1 * float(np.quantile(np.abs(measured), SHOWN_SHARE)))
    if limit > 0.0:
        axes.set_ylim(-limit, limit)


def measured_force(result: FitResult) -> Floats:
    """Return the friction force at the measured instants [N], by the force balance."""
    by_name = {channel.name: channel for channel in result.channels}
    fitted = result.prediction.channels["F_f"]
    if "F_f" in by_name:
        return measured_values(result, by_name["F_f"])
    plant = result.scenario.oscillator.plant()
    if "x_dd" in by_name:
        return fitted - plant.m * result.residuals(by_name["x_dd"])
    from scipy.signal import savgol_filter

    name, order = ("v_r", 1) if "v_r" in by_name else ("x_r", 2)
    dt, residuals = result.measurement.dt, result.residuals(by_name[name])
    period = natural_period(plant) if plant.k_x > 0.0 else 1.0
    width = max(3, min(round(0.5 * SMOOTHING * period / dt), (len(residuals) - 1) // 2))
    derived = savgol_filter(residuals, 2 * width + 1, 3, deriv=order, delta=dt)
    force: Floats = fitted - plant.m * derived
    return force


# profiles.png


PROFILE_COLUMNS = 2
PROFILE_HEIGHT, NOTE_HEIGHT = 2.6, 1.2
"""Heights of a row of profiles and of a row of notes [inch]."""

HIGHEST_RISE = 8.0
"""Upper end of the axis of the rise [-]."""

PROFILE_MARGIN = 0.45
"""Room beyond the interval, relative to its half width."""

FARTHEST_SHIFT = 0.5
"""Distance of a value from the middle of its interval, over half the width, up to which the
interval is written with ±."""

NOTE_WIDTH = 54
"""Characters in a line of a note."""


def draw_profiles(result: FitResult, ax: Axes | None = None) -> Figure:
    """Return the figure of the profiles: the rise of the sum of squares over each parameter."""
    profiles = {profile.key: profile for profile in result.profiles}
    parameters = result.parameters
    drawn = [
        parameter
        for parameter in parameters
        if parameter.key in profiles
        and (parameter.deviation or 0.0) > EXACT * abs(parameter.value)
    ]
    notes = [parameter for parameter in parameters if parameter not in drawn]
    label = "95 % interval by the profile"
    if not result.curves and any(p.key.startswith(STATIC_PATHS) for p in drawn):
        label += ", of a static limit also by the samples between events"
    if result.base_noise is not None and result.base_noise.level:
        label += "; it holds 95 % of the draws"
    columns = min(len(parameters), PROFILE_COLUMNS)
    upper, lower = ceil(len(drawn) / columns), ceil(len(notes) / columns)
    heights = [PROFILE_HEIGHT] * upper + [NOTE_HEIGHT] * lower
    figure, grid = style.panel_grid(
        upper + lower, columns, sum(heights), ax, height_ratios=heights
    )
    for i, parameter in enumerate(drawn):
        axes = ax or figure.add_subplot(grid[i // columns, i % columns])
        profile = profiles[parameter.key]
        profile = profile._replace(values=parameter.scale * profile.values)
        draw_profile(axes, parameter.displayed, profile, label, i % columns == 0)
    for i, parameter in enumerate(notes):
        axes = ax or figure.add_subplot(grid[upper + i // columns, i % columns])
        exact = "exact to rounding: the record has no noise"
        unknown = (
            f"not determined: {parameter.note}"
            if parameter.note
            else f"95 %: {format_profile_interval(parameter.displayed, 1, with_unit=True)}"
        )
        draw_note(axes, exact if parameter.deviation else unknown)
    panels = figure.axes if ax is None else [ax]
    for axes, parameter in zip(panels, (*drawn, *notes), strict=True):
        shown = parameter.displayed
        value = format_interval(shown.value, half_width(shown), shown.unit)
        set_title(axes, f"{parameter.key} {value}")
    style.finish_figure(figure, heading(result), ax=ax)
    return figure


def half_width(parameter: Parameter) -> float | None:
    """Return half the width of the interval by the profile.

    None if an end is open, or the value is far from the middle, as that of a static limit may
    be: ± would state another interval.
    """
    if parameter.profile_low is None or parameter.profile_high is None:
        return None
    half = 0.5 * (parameter.profile_high - parameter.profile_low)
    shift = abs(0.5 * (parameter.profile_low + parameter.profile_high) - parameter.value)
    return half if shift <= FARTHEST_SHIFT * half else None


def draw_note(axes: Axes, note: str) -> None:
    """Write in a panel why there is no profile."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    text = textwrap.fill(note, NOTE_WIDTH)
    axes.text(0.0, 0.95, text, size=9, va="top", transform=axes.transAxes)


def draw_profile(
    axes: Axes, parameter: Parameter, profile: Profile, label: str, first: bool
) -> None:
    """Draw the rise of the sum of squares over one parameter, and its prediction.

    `label` is that of the interval.
    """
    deviation = parameter.deviation or 0.0
    half = NORMAL_95 * deviation
    low, high = (
        parameter.value + sign * half if end is None else end
        for sign, end in ((-1.0, parameter.profile_low), (1.0, parameter.profile_high))
    )
    room = PROFILE_MARGIN * max(0.5 * (high - low), 1e-300)
    left, right = (
        min(low, parameter.value - half) - room,
        max(high, parameter.value + half) + room,
    )
    x = np.linspace(left, right, 400)
    axes.axvspan(
        left if parameter.profile_low is None else low,
        right if parameter.profile_high is None else high,
        **INTERVAL_STYLE, label=label,
    )  # fmt: skip
    axes.plot(
        x, ((x - parameter.value) / deviation) ** 2, **LINEAR_STYLE,
        label="parabola of the linear interval", zorder=2.2,
    )  # fmt: skip
    axes.plot(*profile_curve(profile, x), **MASS_STYLE, label="profile")
    axes.plot(
        profile.values, profile.rise, color=MASS_STYLE["color"], linestyle="none", marker="o",
        markersize=5, label="fit with this value fixed",
    )  # fmt: skip
    axes.axhline(CHI_SQUARE_95, **LIMIT_STYLE, label="3.84: limit of 95 %")
    axes.set_xlim(left, right)
    least = float(profile.rise.min())  # below 0 where fits with another value are better
    axes.set_ylim(max(1.1 * least, -HIGHEST_RISE) - 0.25, HIGHEST_RISE)
    interval = format_profile_interval(parameter, 1, with_unit=True)
    axes.set_xlabel(f"95 %: {interval}", loc="left")
    style.set_ticks(axes.xaxis)
    if first:
        axes.set_ylabel("rise / noise variance [–]")


def profile_curve(profile: Profile, x: Floats) -> tuple[Floats, Floats]:
    """Return the profile through its points: its root, which is nearly linear, interpolated."""
    values, lowest = profile.values, int(profile.rise.argmin())
    least = float(profile.rise[lowest])
    root = np.sign(values - values[lowest]) * np.sqrt(profile.rise - least)
    x = np.sort(np.concatenate([x, values]))
    inside = x[(x >= values.min()) & (x <= values.max())]
    return inside, least + np.interp(inside, values, root) ** 2
