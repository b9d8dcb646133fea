"""Plot speed_error.png: error of every benchmark entry over its computing time per sample.

A thick line is the Pareto front: the least error reached within each computing time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from typing import TYPE_CHECKING

from drysim.plots import style
from drysim.plots.style import Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from drysim.bench.score import Bench, BenchCase, Score


MIN_ERROR = 1e-16
"""Smallest drawn error [-]: rounding."""

EXACT_OFFSET = 0.1
"""Drawn error of an exact entry, which has none, relative to the least other error [-]."""

REFERENCE_ACCURACY = 1e-11
"""Errors below this are equal for the Pareto front [-]: accuracy of the reference itself."""

EXACT_STYLE: Style = {"color": "#0b3c6f", "marker": "*", "markersize": 15, "zorder": 5}
OWN_STYLES: dict[str, Style] = {
    "switch": {"color": "#1b7837", "marker": "s"},
    "moreau": {"color": "#5a8fc7", "marker": "D"},
    "signum": {"color": "#b3261e", "marker": "^"},
    "smooth": {"color": "#e08214", "marker": "o"},
    "viscous": {"color": "#404040", "marker": "X"},
}
"""Styles of drysim's approaches other than the exact one."""

PEER_STYLE: Style = {"color": "#6b6b6b", "fillstyle": "none"}
PEER_MARKERS = "svoDP^<>"
"""Style and markers of other programs."""

FRONT_STYLE: Style = {"color": "#0b3c6f", "linewidth": 5.0, "alpha": 0.18, "zorder": 1}
"""Style of the Pareto front."""

LFILTER_STYLE: Style = {
    "color": "#404040",
    "linewidth": 1.0,
    "linestyle": (0, (1, 2)),
    "zorder": 1,
}

"""Style of the vertical line at the time of scipy's lfilter."""

CAPTION = "filled: approaches of drysim; hollow: other programs; thick line: Pareto front"

ERRORS: tuple[tuple[str, Callable[[Score], float | None]], ...] = (
    ("error of xᵣ over peak [–]", lambda score: score.error_x_r),
    (
        "relative error of Tₐ [–]",
        lambda score: None if score.error_T_a is None else abs(score.error_T_a),
    ),
)


def draw(bench: Bench) -> Figure:
    """Return the figure of a benchmark: errors of x_r and T_a over the time per sample."""
    figure, grid = style.panel_grid(len(bench.cases), 2)
    alone = len(bench.cases) == 1
    for row, panel in enumerate(bench.cases):
        for column, (quantity, error) in enumerate(ERRORS):
            axes = figure.add_subplot(grid[row, column])
            _draw_panel(axes, panel, error)
            style.set_title(axes, quantity if alone else f"{panel.scenario.name}: {quantity}")
    title = bench.cases[0].scenario.name if alone else "speed against error"
    style.finish_figure(figure, style.Heading(style.fit_title(title), (CAPTION,)))
    return figure


def _draw_panel(axes: Axes, panel: BenchCase, error: Callable[[Score], float | None]) -> None:
    """Draw the entries of one case."""
    axes.set(xscale="log", yscale="log")
    style.label_decades(axes.xaxis)
    style.label_decades(axes.yaxis)
    points: list[tuple[float, float]] = []
    errors = [value for score in panel.scores if (value := error(score)) and isfinite(value)]
    floor = max(EXACT_OFFSET * min(errors, default=1.0), MIN_ERROR)
    for scores, line_style in group_by_style(panel.scores):
        shown = sorted(
            (score.time, floor if value is None else max(value, MIN_ERROR))
            for score in scores
            if score.time and ((value := error(score)) is None) is _is_exact(score)
            if value is None or isfinite(value)
        )
        if shown:
            label = scores[0].approach + ": exact" * any(map(_is_exact, scores))
            drawn_style = {"markersize": 5, **line_style}
            axes.plot(*zip(*shown, strict=True), linewidth=0.9, **drawn_style, label=label)
            points += shown
    axes.axvline(panel.lfilter, **LFILTER_STYLE, label="lfilter of scipy")
    axes.set_xlabel("time per sample [ns]")
    axes.margins(x=0.1, y=0.15)
    axes.autoscale_view()
    axes.autoscale(False)
    _draw_pareto_front(axes, points)


def _is_exact(score: Score) -> bool:
    """Whether an entry is the exact solution itself and has no error to draw."""
    return score.by_drysim and score.error_x_r is None and score.verdict.startswith("exact")


def _draw_pareto_front(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """Draw the Pareto front: the least error reached within each computing time."""
    best, t, y = float("inf"), [], []
    for time, error in sorted(points):
        if max(error, REFERENCE_ACCURACY) < best:
            best = error
            t.append(time)
            y.append(error)
    if t:
        # Extend the front to the upper and the right edge of the panel.
        (_, right), (_, top) = axes.get_xlim(), axes.get_ylim()
        t, y = [t[0], *t, right], [top, *y, best]
        axes.plot(t, y, drawstyle="steps-post", solid_joinstyle="round", **FRONT_STYLE)


def group_by_style(scores: Sequence[Score]) -> Iterator[tuple[list[Score], Style]]:
    """Group the scores by line: equal but for step, sharpness and tolerance."""
    grouped: dict[tuple[str, ...], list[Score]] = {}
    for score in scores:
        word, _, rest = score.setting.partition(", ")
        group = (score.approach, *((word, rest.partition(", ")[2]) if score.by_drysim else ()))
        grouped.setdefault(group, []).append(score)
    peers = [group for group, members in grouped.items() if not members[0].by_drysim]
    for group, members in grouped.items():
        if members[0].by_drysim:
            yield members, OWN_STYLES.get(group[0], EXACT_STYLE)
        else:
            yield (
                members,
                {**PEER_STYLE, "marker": PEER_MARKERS[peers.index(group) % len(PEER_MARKERS)]},
            )
