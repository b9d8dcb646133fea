"""Plot ensemble.png: distribution of the main metrics over the seeds, and running means."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.core.model import Floats
from drysim.metrics.checks import seeds_for_quantile
from drysim.metrics.table import METRICS_BY_NAME, PEAK_STROKE
from drysim.metrics.text import format_metric
from drysim.plots import response, style
from drysim.plots.style import PlottedMetric, Style, plotted
from drysim.scenario.text import describe_seeds
from drysim.study.ensemble import Ensemble
from drysim.study.statistics import QUANTILES, Statistic, stopping_rule, student_t

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_MARKED_SEEDS = 60
"""Seeds up to which each has a marker."""

MAX_MEAN_POINTS = 2_000
"""Points of a running mean, about the width of the picture in pixels."""

MAX_LIMIT_DISTANCE = 1.0
"""Distance of a check's limit from the nearest seed, over the range of all seeds, up to which
the limit is drawn [-]."""

SEEDS_STYLE: Style = {"color": "#0b3c6f", "linewidth": 1.2}
MEAN_STYLE: Style = {"color": "black", "linewidth": 1.3, "label": "mean"}
INTERVAL_STYLE: Style = {
    "facecolor": "#c9d8ea", "edgecolor": "none", "zorder": 1,
    "label": "95 % confidence interval of the mean",
}  # fmt: skip
QUANTILE_STYLE: Style = {"color": "#8a8a8a", "linewidth": 1.0, "linestyle": (0, (4, 1.5))}

DRAWN_METRICS = ("T_a", "SEAT", PEAK_STROKE)
"""Metrics with panels of their own, besides that of the stopping rule."""

HEADING_METRICS = (*DRAWN_METRICS, "stuck_share")
"""Metrics in the heading."""


def draw(result: Ensemble) -> Figure:
    """Return the figure of an ensemble."""
    (seeds,), shown = result.rows.batches, list(_shown_metrics(result))
    figure, grid = style.panel_grid(len(shown), 2)
    for row, metric in enumerate(shown):
        statistic = result.statistics[metric.name]
        assert statistic is not None, "only known metrics are drawn"
        values = seeds.metrics[metric.name]
        values = values[np.isfinite(values)] * metric.scale
        left, right = figure.add_subplot(grid[row, 0]), figure.add_subplot(grid[row, 1])
        last = row == len(shown) - 1
        _draw_distribution(left, values, statistic, metric, last)
        _draw_running_mean(right, values, metric, last)
        _draw_check_limits(left, right, result, values, metric)
        style.set_ticks(left.xaxis)
    style.finish_figure(figure, _heading(result))
    return figure


def _shown_metrics(result: Ensemble) -> Iterator[PlottedMetric]:
    """Return the drawn metrics: the main ones and that of the stopping rule."""
    until = stopping_rule(result.scenario)
    for name in dict.fromkeys((*DRAWN_METRICS, *([until.metric] if until else []))):
        if statistic := result.statistics[name]:
            yield plotted(name, statistic.greatest[0])


def _draw_distribution(
    axes: Axes, values: Floats, statistic: Statistic, metric: PlottedMetric, last: bool
) -> None:
    """Draw the empirical distribution function over the seeds."""
    style.set_title(axes, f"{metric.symbol}: cumulative distribution [%]")
    mean, half_width = (
        statistic.mean * metric.scale,
        (statistic.half_width or 0.0) * metric.scale,
    )
    axes.axvspan(mean - half_width, mean + half_width, **INTERVAL_STYLE)
    quantiles = [
        (level, value)
        for level, value in zip(QUANTILES, statistic.quantiles, strict=True)
        if statistic.seeds >= seeds_for_quantile(level)
    ]
    levels = ", ".join(f"{100 * level:g}" for level, _ in quantiles)
    label = f"{levels} % quantiles" if len(quantiles) > 1 else "median"
    for _, value in quantiles:
        axes.axvline(value * metric.scale, **QUANTILE_STYLE, label=label)
    axes.axvline(mean, **MEAN_STYLE)
    draw_cumulative(axes, values, QUANTILES)
    if last:
        axes.set_xlabel("value")


def draw_cumulative(axes: Axes, values: Floats, levels: Sequence[float]) -> None:
    """Draw the empirical distribution function of values, with ticks at levels."""
    n = len(values)
    marker_style: Style = {"marker": "o", "markersize": 3} if n <= MAX_MARKED_SEEDS else {}
    shares = 100.0 * (np.arange(n) + 0.5) / n
    label = "empirical distribution"
    axes.plot(np.sort(values), shares, **SEEDS_STYLE, **marker_style, label=label)
    axes.set_yticks([100 * level for level in levels], [f"{100 * level:g}" for level in levels])
    axes.set_ylim(0.0, 100.0)


def _draw_running_mean(axes: Axes, values: Floats, metric: PlottedMetric, last: bool) -> None:
    """Draw the mean of the first n seeds and its confidence interval over n."""
    style.set_title(axes, f"{metric.symbol}: running mean")
    n = np.arange(1, len(values) + 1)
    if len(values) <= MAX_MARKED_SEEDS:
        axes.plot(n, values, "o", markersize=3, color=SEEDS_STYLE["color"], label="single seed")
    # Centred at the final mean: the sum of squares would cancel otherwise.
    centred = values - values.mean()
    sums, squares = np.cumsum(centred), np.cumsum(centred * centred)
    part = np.unique(
        np.linspace(1, len(values) - 1, min(MAX_MEAN_POINTS, len(values) - 1)).astype(int)
    )
    means = values.mean() + sums / n
    spread = (
        np.maximum(squares[part] - sums[part] ** 2 / n[part], 0.0) / (n[part] - 1) / n[part]
    )
    width = np.array([student_t(int(k) - 1) for k in n[part]]) * np.sqrt(spread)
    axes.fill_between(n[part], means[part] - width, means[part] + width, **INTERVAL_STYLE)
    axes.plot(n[part], means[part], **MEAN_STYLE)
    low, high = values.min(), values.max()
    margin = 0.15 * (high - low) or 0.5 * abs(high) or 1.0
    # The confidence interval of two seeds would dominate an automatic range.
    axes.set_ylim(low - margin, high + margin)
    axes.set_xlim(0, len(values) + 1)
    if last:
        axes.set_xlabel("number of seeds")


def _draw_check_limits(
    left: Axes, right: Axes, result: Ensemble, values: Floats, metric: PlottedMetric
) -> None:
    """Draw the limits of checks that are close to the values."""
    scatter = float(np.ptp(values))
    for verdict in result.checks:
        check = verdict.check
        limit = check.limit * metric.scale
        if check.metric == metric.name and verdict.passed is not None:
            if min(abs(values - limit)) > MAX_LIMIT_DISTANCE * scatter:
                continue
            label = f"limit of check {wording.sanitise(check.text)}"
            left.axvline(limit, **response.LIMIT_STYLE, label=label)
            right.axhline(limit, **response.LIMIT_STYLE, label=label)
            low, high = right.get_ylim()
            right.set_ylim(min(low, limit - 0.05 * scatter), max(high, limit + 0.05 * scatter))


def _heading(result: Ensemble) -> style.Heading:
    """Return the heading: main results and seeds, then the scene."""
    until = stopping_rule(result.scenario)
    means = [
        f"{METRICS_BY_NAME[name].label} {_format_mean(name, statistic)}"
        for name in HEADING_METRICS
        if (statistic := result.statistics[name]) is not None
    ]
    seeds = f"seeds {describe_seeds(result.seeds, until)}"
    return style.response_heading(result.shown, f"{', '.join(means)}; {seeds}")


def _format_mean(name: str, statistic: Statistic) -> str:
    """Return a mean with its confidence interval, in a unit suited to the largest value."""
    return format_metric(name, statistic.mean, statistic.half_width, statistic.greatest[0])
