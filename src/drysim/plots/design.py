"""Plot design.png: the objective over the varied keys, or the front of two objectives.

One objective
    Over one or two keys the surrogate model of the search is drawn as a curve or a map, with
    the region that it takes for inadmissible in grey, unless no design is admissible. Over more
    keys each panel shows all evaluated designs over one key.

Two objectives
    All evaluated designs with the front, then the keys of the front over the first objective;
    those of all designs where none is admissible.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.core.model import Floats
from drysim.metrics.table import METRICS_BY_NAME
from drysim.metrics.text import format_metric
from drysim.plots import metric_map, style
from drysim.plots.style import (
    Style,
    axis_label,
    plotted,
    set_axis,
    set_ticks,
)
from drysim.plots.sweep import BEST_STYLE
from drysim.scenario.axes import KeyRange
from drysim.scenario.text import describe_clean_up, short_key
from drysim.study.design import (
    Candidate,
    DesignResult,
    Region,
    evaluations_of,
    keys_at_bounds,
)
from drysim.study.search import Surrogate
from drysim.wording import format_count, join_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CURVE_POINTS, MAP_POINTS = 400, 120
"""Points of a curve, and along one side of a map."""

KEY_MARGIN = 0.02
"""Margin beyond the range of a key, as a share of it."""

SHOWN_RANGE = 3.0
"""Largest objective that is shown, as a multiple of the median of the evaluated designs; that
of negative ones is as far above the median."""

ADMISSIBLE_STYLE: Style = {
    "linestyle": "none", "marker": "o", "markersize": 4.5, "color": "#1f4e79",
    "markeredgewidth": 0.6, "markeredgecolor": "white", "label": "evaluated, admissible",
}  # fmt: skip
EXCLUDED_STYLE: Style = {
    "linestyle": "none", "marker": "o", "markersize": 4.0, "color": "white",
    "markeredgecolor": "#8a8a8a", "markeredgewidth": 0.9, "label": "evaluated, exceeds a limit",
}  # fmt: skip
CURVE_STYLE: Style = {"color": "#1f4e79", "linewidth": 1.3, "label": "interpolated"}
FRONT_STYLE: Style = {
    "color": "#1f4e79", "linewidth": 1.0, "drawstyle": "steps-post", "marker": "o",
    "markersize": 3.5, "label": "front",
}  # fmt: skip
GIVEN_STYLE: Style = {
    "linestyle": "none", "marker": "s", "markersize": 7.0, "color": "white",
    "markeredgecolor": "#b3261e", "markeredgewidth": 1.5, "label": "as given",
}  # fmt: skip
OPTIMUM_STYLE: Style = {
    "facecolor": "#f0b429", "edgecolor": "#8a6000", "alpha": 0.45, "linewidth": 0.0,
    "hatch": "////",
}  # fmt: skip
FLAT_STYLE: Style = {"color": "#7fb3d5", "alpha": 0.25, "linewidth": 0.0}
CLOUD_STYLE: Style = {
    "linestyle": "none", "marker": "D", "markersize": 4.5, "color": "white", "zorder": 6,
    "markeredgewidth": 0.8, "markeredgecolor": "black", "clip_on": False,
}  # fmt: skip
END_STYLE: Style = {
    "linestyle": "none", "marker": "D", "markersize": 7.0, "color": "white", "zorder": 4,
    "markeredgewidth": 1.2, "markeredgecolor": "#1f4e79", "label": "ends of the front",
    "clip_on": False,
}  # fmt: skip
EXCLUDED_COLOR = metric_map.EXCLUDED_STYLE["facecolor"]
BOUNDARY_STYLE: Style = {"color": "black", "linewidth": 1.4}


def draw(result: DesignResult, ax: Axes | None = None) -> Figure:
    """Return the figure of a design study."""
    if len(result.design.minimise) > 1:
        figure = draw_front(result, ax)
    elif len(result.design.vary) == 2:
        figure, grid = style.panel_grid(1, 1, metric_map.HEIGHT, ax)
        draw_map(result, ax or figure.add_subplot(grid[0, 0]))
    else:
        count = len(result.design.vary)
        columns = 1 if count == 1 else 2
        figure, grid = style.panel_grid(ceil(count / columns), columns, ax=ax)
        for i, vary in enumerate(result.design.vary):
            axes = ax or figure.add_subplot(grid[i // columns, i % columns])
            draw_curve(result, axes, vary, alone=count == 1)
    style.finish_figure(figure, heading(result), ax=ax)
    return figure


def heading(result: DesignResult) -> style.Heading:
    """Return the heading: the best design, then what was varied."""
    shown, source = result.shown, result.source
    results = "no design has numbers"
    if shown is not None:
        values = zip(result.design.minimise, shown.objectives, result.half_widths, strict=True)
        objectives = ", ".join(
            f"{METRICS_BY_NAME[name].label} {format_metric(name, x, half)}"
            for name, x, half in values
        )
        best = result.shown_name if result.best else "no design keeps all limits; the closest"
        results = f"{best}: {objectives} at {result.place(shown)}"
    limits = ", ".join(str(limit) for limit in result.limits)
    conditions, case = result.design.conditions, result.case
    base = source.excitation.describe_cases(
        None, [axis.key for axis in conditions.axes], case.records
    )
    base = style.CLEANED * bool(describe_clean_up(case.motion, records=case.records)) + base
    parts = [f"within {limits}"] if limits else []
    if conditions.axes and shown is not None:
        parts.append(f"{conditions.take} of {format_count(len(shown.rows), 'condition')}")
    if bounds := keys_at_bounds(result):
        keys = join_words([short_key(key, bounds) for key in bounds])
        parts.insert(0, f"at the bounds of {keys}")
    return style.make_heading(source, results, "", "; ".join([*parts, base]))


def metric_scale(result: DesignResult, name: str) -> tuple[float, str]:
    """Return the displayed units of an objective per SI unit, and the label of its axis."""
    greatest = max((x for x in values_of(result, name) if x == x), default=0.0)
    metric = plotted(name, greatest)
    return metric.scale, metric.symbol


def values_of(result: DesignResult, name: str) -> Floats:
    """Return an objective of all designs."""
    index = result.design.minimise.index(name)
    return np.array([candidate.objectives[index] for candidate in result.candidates])


def set_key_axis(axes: Axes, vary: KeyRange, which: str = "x") -> None:
    """Set scale, limits and label of the axis of a varied key."""
    low, high = vary.value(np.array([-KEY_MARGIN, 1.0 + KEY_MARGIN])).tolist()
    set_axis(axes, which, axis_label(vary), low, high, vary.is_log)


def draw_curve(result: DesignResult, axes: Axes, vary: KeyRange, alone: bool) -> None:
    """Draw the objective over one key: all designs, the best, where the optimum may be."""
    name = result.design.minimise[0]
    scale, label = metric_scale(result, name)
    if alone and (surrogate := surrogate_of(result)) is not None:
        shares = np.linspace(0.0, 1.0, CURVE_POINTS)[:, None]
        predicted, x = surrogate.at(shares), vary.value(shares[:, 0])
        axes.plot(x, scale * predicted.objectives[:, 0], **CURVE_STYLE)
        outside = predicted.excess > 0.0
        if outside.any():
            axes.fill_between(
                x, 0.0, 1.0, where=outside, transform=axes.get_xaxis_transform(),
                color=EXCLUDED_COLOR, linewidth=0.0, zorder=0, label="exceeds a limit",
            )  # fmt: skip
            for edge in np.flatnonzero(np.diff(outside)):
                axes.axvline(x[edge : edge + 2].mean(), **BOUNDARY_STYLE, zorder=1)
    draw_designs(axes, result, lambda a: (a.values[vary.key], scale * a.objectives[0]))
    for region, drawn, legend in regions(result):
        low, high = region.ends[vary.key]
        axes.axvspan(
            vary.low if low is None else low, vary.high if high is None else high,
            **drawn, label=legend,
        )  # fmt: skip
    mark_shown(axes, result, lambda a: (a.values[vary.key], scale * a.objectives[0]))
    set_key_axis(axes, vary)
    axes.set_ylabel(label)
    values = scale * values_of(result, name)
    values = values[np.isfinite(values)]
    low, median = values.min(), float(np.median(values))
    top = min(values.max(), median + (SHOWN_RANGE - 1.0) * abs(median))
    axes.set_ylim(low - 0.05 * (top - low or 1.0), top + 0.05 * (top - low or 1.0))


def regions(result: DesignResult) -> Iterator[tuple[Region, Style, str]]:
    """Yield the regions that are drawn, each with its style and its label."""
    if result.flat is not None:
        yield result.flat, FLAT_STYLE, "within 1 % of the best"
    if result.optimum is not None:
        yield result.optimum, OPTIMUM_STYLE, "optimum, 95 %"


def surrogate_of(result: DesignResult) -> Surrogate | None:
    """Return the surrogate model of all designs."""
    return Surrogate.of(evaluations_of(result.source, result.candidates))


def mark_shown(
    axes: Axes, result: DesignResult, point_of: Callable[[Candidate], tuple[float, ...]]
) -> None:
    """Mark the best design with a star, a white one for the closest."""
    if result.shown is not None:
        fill: Style = {} if result.best else {"color": "white"}
        x, y = point_of(result.shown)
        axes.plot([x], [y], **{**BEST_STYLE, **fill}, label=result.shown_name)


def draw_map(result: DesignResult, axes: Axes) -> None:
    """Draw the objective over two keys as a map, with the inadmissible region in grey."""
    first, second = result.design.vary
    set_key_axis(axes, first)
    set_key_axis(axes, second, "y")
    scale, label = metric_scale(result, result.design.minimise[0])
    if (surrogate := surrogate_of(result)) is not None:
        side = np.linspace(0.0, 1.0, MAP_POINTS)
        grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        predicted = surrogate.at(grid)
        shape = (MAP_POINTS, MAP_POINTS)
        values = scale * predicted.objectives[:, 0].reshape(shape)
        excess = predicted.constraints.max(axis=1, initial=-1.0).reshape(shape)
        if result.best is None:
            excess[:] = -1.0  # nowhere admissible: the map shows the objective everywhere
        x, y = first.value(side), second.value(side)
        metric_map.add_bar(axes, metric_map.draw_levels(axes, x, y, values, excess), label)
    draw_designs(axes, result, lambda a: (a.values[first.key], a.values[second.key]))
    if result.optimum is not None:
        x, y = (key.value(result.optimum.points[:, i]) for i, key in enumerate((first, second)))
        axes.plot(x, y, **CLOUD_STYLE, label="optima of resampled seeds")
    given = [variant.candidate for variant in result.variants if variant.name == "as given"]
    axes.plot(*pairs(given, first, second), **GIVEN_STYLE)
    mark_shown(axes, result, lambda a: (a.values[first.key], a.values[second.key]))


def draw_designs(
    axes: Axes,
    result: DesignResult,
    point_of: Callable[[Candidate], tuple[float, ...]],
    **options: Any,
) -> None:
    """Draw the evaluated designs that have numbers; those that exceed a limit are hollow."""
    with_numbers = [candidate for candidate in result.candidates if candidate.is_known]
    for keeps, drawn in ((True, ADMISSIBLE_STYLE), (False, EXCLUDED_STYLE)):
        points = [
            point_of(candidate)
            for candidate in with_numbers
            if candidate.is_admissible is keeps
        ]
        if points:
            axes.plot(*zip(*points, strict=True), **{**drawn, **options})


def pairs(
    designs: Sequence[Candidate], first: KeyRange, second: KeyRange
) -> tuple[list[float], list[float]]:
    """Return the values of two keys of designs."""
    return [a.values[first.key] for a in designs], [a.values[second.key] for a in designs]


def draw_front(result: DesignResult, ax: Axes | None = None) -> Figure:
    """Return the figure of two objectives: all designs with the front, and its keys."""
    vary = result.design.vary
    columns = 1 if len(vary) == 1 else 2
    rows = ceil(len(vary) / columns)
    ratios = [1.6, *[1.0] * rows]
    figure, grid = style.panel_grid(rows + 1, columns, ax=ax, height_ratios=ratios)
    axes = figure.add_subplot(grid[0, :])
    scales, labels = zip(
        *(metric_scale(result, name) for name in result.design.minimise), strict=True
    )
    draw_designs(axes, result, lambda a: tuple(a.objectives * np.array(scales)), alpha=0.5)
    front = (
        np.array([candidate.objectives for candidate in result.front]).reshape(-1, 2) * scales
    )
    if len(front):
        axes.plot(*front.T, **FRONT_STYLE)
    given = [variant.candidate for variant in result.variants if variant.name == "as given"]
    points = np.array([candidate.objectives for candidate in given]).reshape(-1, 2) * scales
    axes.plot(*points.T, **GIVEN_STYLE)
    if len(front) > 1:
        axes.plot(*front[[0, -1]].T, **END_STYLE)
    mark_shown(axes, result, lambda a: tuple(a.objectives * np.array(scales)))
    if len(front):
        span = np.maximum(np.ptp(front, axis=0), 1e-9 * np.abs(front).max(axis=0))
        shown = [front, *([points] if len(points) else [])]
        low = np.min([part.min(axis=0) for part in shown], axis=0) - 0.1 * span
        high = np.max([part.max(axis=0) for part in shown], axis=0) + 0.3 * span
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    for i, key_range in enumerate(vary):
        below = figure.add_subplot(grid[1 + i // columns, i % columns])

        def place(candidate: Candidate, key: str = key_range.key) -> tuple[float, float]:
            return scales[0] * candidate.objectives[0], candidate.values[key]

        if len(front):
            x, y = zip(*map(place, result.front), strict=True)
            below.plot(x, y, **{**FRONT_STYLE, "linestyle": "none"})
            below.plot(x[:: len(x) - 1 or 1], y[:: len(y) - 1 or 1], **END_STYLE)
        else:
            draw_designs(below, result, place, alpha=0.5)
        mark_shown(below, result, place)
        set_key_axis(below, key_range, "y")
        below.set_xlabel(labels[0])
        set_ticks(below.xaxis)
    return figure
