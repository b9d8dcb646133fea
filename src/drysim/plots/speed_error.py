"""Plot speed_error.png: error of every benchmark entry over its computing time per sample.

A thick line is the Pareto front. Curves are labelled directly: a label is placed next to a
point of its curve, at the candidate position with the lowest cost (overlaps, distance, leaving
the panel). Curves with fewer points come first, as they have fewer candidates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.plots import style, sweep
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

ROW_GAP = 0.85
"""Gap between rows of panels, each with an x-axis of its own [inch]."""

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
    ("error of $x_r$ over peak [–]", lambda score: score.error_x_r),
    (
        "relative error of $T_a$ [–]",
        lambda score: None if score.error_T_a is None else abs(score.error_T_a),
    ),
)


def speed_error(bench: Bench, folder: Path) -> None:
    """Write speed_error.png: errors of x_r and T_a over the time per sample.

    Parameters
    ----------
    bench : Bench
    folder : Path
        Output folder.
    """
    style.save_png(lambda: draw(bench), folder / "speed_error.png")


def draw(bench: Bench) -> Figure:
    """Return the figure of a benchmark, not yet rendered."""
    figure, grid = style.panel_grid(len(bench.cases), 2, row_gap=ROW_GAP)
    alone = len(bench.cases) == 1
    drawn = []
    for row, panel in enumerate(bench.cases):
        for column, (words, error) in enumerate(ERRORS):
            axes = figure.add_subplot(grid[row, column])
            known = _draw_panel(axes, panel, error)
            sweep.set_title(axes, words if alone else f"{panel.scenario.name}: {words}")
            drawn.append((axes, known))
    title = bench.cases[0].scenario.name if alone else "speed against error"
    style.finish_figure(figure, grid, (title, [CAPTION], []))
    for axes, known in drawn:
        place_labels(axes, known)
    return figure


def _draw_panel(
    axes: Axes, panel: BenchCase, error: Callable[[Score], float | None]
) -> list[LabelledCurve]:
    """Draw the entries of one case; return the curves to be labelled."""
    axes.set(xscale="log", yscale="log")
    known: dict[str, LabelledCurve] = {}
    errors = [value for one in panel.scores if (value := error(one)) and isfinite(value)]
    floor = max(EXACT_OFFSET * min(errors, default=1.0), MIN_ERROR)
    for scores, line_style in group_by_style(panel.scores):
        shown = sorted(
            (one.time, floor if value is None else max(value, MIN_ERROR))
            for one in scores
            if one.time and ((value := error(one)) is None) is _is_exact(one)
            if value is None or isfinite(value)
        )
        if shown:
            t, y = zip(*shown, strict=True)
            axes.plot(t, y, linewidth=0.9, **{"markersize": 5, **line_style})
            name = scores[0].approach
            before = known[name].lines if name in known else ()
            label = f"{name}: exact" if any(map(_is_exact, scores)) else name
            known[name] = LabelledCurve(label, (*before, tuple(shown)), line_style["color"])
    axes.axvline(panel.lfilter, **LFILTER_STYLE)
    axes.text(
        panel.lfilter, 0.98, "lfilter ", transform=axes.get_xaxis_transform(), size=7.5,
        rotation=90, ha="right", va="top",
    )  # fmt: skip
    axes.set_xlabel("time per sample [ns]")
    axes.margins(x=0.1, y=0.15)
    axes.autoscale_view()
    axes.autoscale(False)
    _draw_pareto_front(
        axes, [at for curve in known.values() for line in curve.lines for at in line]
    )
    return list(known.values())


def _is_exact(score: Score) -> bool:
    """Whether an entry is the exact solution itself and has no error to draw."""
    return score.own and score.error_x_r is None and score.verdict.startswith("exact")


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
    for one in scores:
        word, _, rest = one.setting.partition(", ")
        group = (one.approach, *((word, rest.partition(", ")[2]) if one.own else ()))
        grouped.setdefault(group, []).append(one)
    peers = [group for group, members in grouped.items() if not members[0].own]
    for group, members in grouped.items():
        if members[0].own:
            yield members, OWN_STYLES.get(group[0], EXACT_STYLE)
        else:
            yield (
                members,
                {**PEER_STYLE, "marker": PEER_MARKERS[peers.index(group) % len(PEER_MARKERS)]},
            )


# Placement of labels.


LABEL_SIZE = 7.5
"""Font size of the labels [pt]."""

LETTER_WIDTH, LETTER_HEIGHT = 0.53, 1.15
"""Mean width and height of a character over the font size [-]."""

LABEL_DISTANCES = (7.0, 14.0, 24.0, 36.0, 50.0)
"""Distances of candidate positions from the point [pt]."""

LABEL_DIRECTIONS = 16
"""Number of directions of candidate positions."""

LABEL_MARGIN = 3.0
"""Margin around a label [pt]."""

POINT_SPACING = 4.0
"""Spacing of the points that represent a line [pt]."""

OVERLAP_COST, DISTANCE_COST, OUTSIDE_COST = 10.0, 0.02, 100.0
"""Costs of a covered point, of a distance of 1 pt, and of leaving the panel."""


class LabelledCurve(NamedTuple):
    """A curve to be labelled.

    Attributes
    ----------
    label : str
    lines : sequence of sequence of (x, y)
        Lines, each as points in data coordinates.
    color : str
    """

    label: str
    lines: Sequence[Sequence[tuple[float, float]]]
    color: str


class Box(NamedTuple):
    """A rectangle [pt]: left, right, bottom, top."""

    left: float
    right: float
    bottom: float
    top: float


def place_labels(axes: Axes, curves: Sequence[LabelledCurve]) -> None:
    """Label every curve; position and limits of the axes must be final."""
    scale = 72.0 / axes.figure.dpi
    lines = [
        [np.asarray(axes.transData.transform(line)) * scale for line in curve.lines]
        for curve in curves
    ]
    if not lines:
        return
    shown = [np.concatenate(own) for own in lines]
    occupied = np.concatenate([densify(line) for own in lines for line in own])
    frame = axes.get_window_extent()
    panel = Box(*(scale * end for end in (frame.x0, frame.x1, frame.y0, frame.y1)))
    placed: list[Box] = []
    for curve, points in sorted(zip(curves, shown, strict=True), key=lambda pair: len(pair[1])):
        box, point = min(
            candidate_boxes(curve.label, points),
            key=lambda one: placement_cost(one[0], one[1], occupied, placed, panel),
        )
        placed.append(box)
        middle = (0.5 * (box.left + box.right) / scale, 0.5 * (box.bottom + box.top) / scale)
        axes.annotate(
            curve.label, tuple(point / scale), middle, size=LABEL_SIZE,
            xycoords="figure pixels", textcoords="figure pixels", ha="center", va="center",
            color=curve.color, zorder=6,
            arrowprops={"arrowstyle": "-", "color": curve.color, "linewidth": 0.4,
                        "shrinkA": 0, "shrinkB": 3},
        )  # fmt: skip


def densify(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points of a line together with interpolated points every `POINT_SPACING`."""
    samples = []
    for begin, step in zip(line[:-1], np.diff(line, axis=0), strict=True):
        shares = np.linspace(0.0, 1.0, int(np.abs(step).max() / POINT_SPACING) + 2)
        samples.append(begin + shares[:, None] * step)
    return np.concatenate([line, *samples])


def candidate_boxes(
    label: str, points: NDArray[np.float64]
) -> Iterator[tuple[Box, NDArray[np.float64]]]:
    """Yield candidate boxes of a label around every point of a curve."""
    half = 0.5 * LETTER_WIDTH * LABEL_SIZE * len(label), 0.5 * LETTER_HEIGHT * LABEL_SIZE
    for point in points:
        for distance in LABEL_DISTANCES:
            for angle in np.arange(LABEL_DIRECTIONS) * 2.0 * np.pi / LABEL_DIRECTIONS:
                x = point[0] + np.cos(angle) * (distance + half[0])
                y = point[1] + np.sin(angle) * (distance + half[1])
                yield Box(x - half[0], x + half[0], y - half[1], y + half[1]), point


def placement_cost(
    box: Box,
    point: NDArray[np.float64],
    occupied: NDArray[np.float64],
    placed: Sequence[Box],
    panel: Box,
) -> float:
    """Return the cost of a position: overlaps, distance, leaving the panel."""
    x, y = occupied[:, 0], occupied[:, 1]
    covered = (x > box.left - LABEL_MARGIN) & (x < box.right + LABEL_MARGIN)
    covered &= (y > box.bottom - LABEL_MARGIN) & (y < box.top + LABEL_MARGIN)
    overlap_count = int(covered.sum()) + 2 * sum(boxes_overlap(box, other) for other in placed)
    outside = (
        box.left < panel.left or box.right > panel.right
        or box.bottom < panel.bottom or box.top > panel.top
    )  # fmt: skip
    middle = np.array([0.5 * (box.left + box.right), 0.5 * (box.bottom + box.top)])
    distance = float(np.abs(middle - point).max())
    return OVERLAP_COST * overlap_count + OUTSIDE_COST * outside + DISTANCE_COST * distance


def boxes_overlap(one: Box, other: Box) -> bool:
    """Whether two boxes overlap."""
    return (
        one.left < other.right + LABEL_MARGIN and other.left < one.right + LABEL_MARGIN
        and one.bottom < other.top and other.bottom < one.top
    )  # fmt: skip
