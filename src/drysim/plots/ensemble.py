"""ensemble.png: how the main metrics scatter over the seeds, and how their means settle."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from drysim import wording
from drysim.approach.solution import Floats
from drysim.plots import response, style, sweep
from drysim.plots.style import SEAT, STROKE, T_A, Shown, Style, peak
from drysim.study.ensemble import Ensemble
from drysim.study.statistics import QUANTILES, Statistic, student, until_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FEW = 60
"""Seeds up to which each is marked."""

MOST = 2_000
"""Points of a running mean that a picture can show."""

FAR = 1.0
"""How many times the scatter of the seeds a check's limit may be away to be drawn."""

SEEDS: Style = {"color": "#0b3c6f", "linewidth": 1.2}
MEAN: Style = {"color": "black", "linewidth": 1.3, "label": "mean"}
BAND: Style = {
    "facecolor": "#c9d8ea", "edgecolor": "none", "zorder": 1,
    "label": "95 % confidence interval of the mean",
}  # fmt: skip
QUANTILE: Style = {"color": "#8a8a8a", "linewidth": 1.0, "linestyle": (0, (4, 1.5))}

TOLD = (
    ("T_a", "T_a", ""),
    ("SEAT", "SEAT", ""),
    ("peak |x_r|", "x_r_peak", "m"),
    ("stuck", "stuck_share", "%"),
)
"""Name, metric and unit of the results in the heading."""


def ensemble(made: Ensemble, folder: Path) -> None:
    """Write ensemble.png: the distribution of the main metrics, and their running means."""
    style.paint(lambda: draw(made), folder / "ensemble.png")


def draw(made: Ensemble) -> Figure:
    """Give the picture of an ensemble, not yet rendered."""
    shown = list(_shown(made))
    figure, grid = style.sheet(len(shown), 2, left=0.085)
    for at, quantity in enumerate(shown):
        found = made.statistics[quantity.metric]
        assert found is not None, "only what is known is shown"
        values = np.array([row.metrics.get(quantity.metric) for row in made.rows], dtype=float)
        values = values[np.isfinite(values)] * quantity.scale
        left, right = figure.add_subplot(grid[at, 0]), figure.add_subplot(grid[at, 1])
        last = at == len(shown) - 1
        _distribution(left, values, found, quantity, last)
        _settling(right, values, quantity, last)
        _limits(left, right, made, values, quantity)
    style.complete(figure, grid, _words(made))
    return figure


def _shown(made: Ensemble) -> Iterator[Shown]:
    """Give what is drawn: the main metrics, and the one that decided when to stop."""
    greatest = made.statistics[STROKE]
    main = (T_A, SEAT, peak(greatest.greatest[0] if greatest else 0.0))
    yield from (one for one in main if made.statistics[one.metric])
    until = until_of(made.scenario)
    others = {quantity.metric for quantity in main}
    if until and until.metric not in others and made.statistics[until.metric]:
        yield Shown(until.metric, until.metric)


def _distribution(
    axes: Axes, values: Floats, found: Statistic, quantity: Shown, last: bool
) -> None:
    """Draw which share of the seeds lies below a value."""
    sweep.name(axes, f"{quantity.symbol}: share of the seeds below [%]")
    ordered, n = np.sort(values), len(values)
    mark: Style = {"marker": "o", "markersize": 3} if n <= FEW else {}
    mean, half_width = found.mean * quantity.scale, (found.half_width or 0.0) * quantity.scale
    axes.axvspan(mean - half_width, mean + half_width, **BAND)
    for value in found.quantiles:
        axes.axvline(value * quantity.scale, **QUANTILE, label="5, 50 and 95 %")
    axes.axvline(mean, **MEAN)
    shares = 100.0 * (np.arange(n) + 0.5) / n
    axes.plot(ordered, shares, **SEEDS, **mark, label="distribution over the seeds")
    axes.set_yticks([100 * share for share in QUANTILES])
    axes.set_ylim(0.0, 100.0)
    if last:
        axes.set_xlabel("value")


def _settling(axes: Axes, values: Floats, quantity: Shown, last: bool) -> None:
    """Draw the mean of the first n seeds with its interval, over n."""
    sweep.name(axes, f"{quantity.symbol}: mean of the first seeds")
    n = np.arange(1, len(values) + 1)
    if len(values) <= FEW:
        axes.plot(n, values, "o", markersize=3, color=SEEDS["color"], label="one seed")
    # About the last mean, so that squares do not cancel.
    about = values - values.mean()
    sums, squares = np.cumsum(about), np.cumsum(about * about)
    part = np.unique(np.linspace(1, len(values) - 1, min(MOST, len(values) - 1)).astype(int))
    means = values.mean() + sums / n
    spread = (
        np.maximum(squares[part] - sums[part] ** 2 / n[part], 0.0) / (n[part] - 1) / n[part]
    )
    width = np.array([student(int(k) - 1) for k in n[part]]) * np.sqrt(spread)
    axes.fill_between(n[part], means[part] - width, means[part] + width, **BAND)
    axes.plot(n[part], means[part], **MEAN)
    low, high = values.min(), values.max()
    room = 0.15 * (high - low) or 0.5 * abs(high) or 1.0
    # The interval of two seeds would hide all others.
    axes.set_ylim(low - room, high + room)
    axes.set_xlim(0, len(values) + 1)
    if last:
        axes.set_xlabel("seeds")


def _limits(left: Axes, right: Axes, made: Ensemble, values: Floats, quantity: Shown) -> None:
    """Draw the limits that checks set, where they are near."""
    scatter = float(np.ptp(values))
    for verdict in made.checks:
        check = verdict.check
        limit = check.limit * quantity.scale
        if check.metric == quantity.metric and verdict.passed is not None:
            if min(abs(values - limit)) > FAR * scatter:
                continue
            label = f"limit of a check: {wording.clean(check.text)}"
            left.axvline(limit, **response.LIMIT, label=label)
            right.axhline(limit, **response.LIMIT, label=label)
            low, high = right.get_ylim()
            right.set_ylim(min(low, limit - 0.05 * scatter), max(high, limit + 0.05 * scatter))


def _words(made: Ensemble) -> style.Lines:
    """Give the heading: the scene, the seeds and the main results."""
    until = until_of(made.scenario)
    drawn = f"seeds: {wording.seeds(made.seeds, until)}"
    found = [
        f"{name} {_told(one, unit)}"
        for name, metric, unit in TOLD
        if (one := made.statistics[metric]) is not None
    ]
    return style.lines(made.shown, drawn, ", ".join(found))


def _told(found: Statistic, unit: str) -> str:
    """Give a mean with its interval, in the unit in which the greatest value reads well."""
    scale, sign = wording.told_in(unit, found.greatest[0])
    return wording.around(found.mean * scale, (found.half_width or 0.0) * scale, sign)
