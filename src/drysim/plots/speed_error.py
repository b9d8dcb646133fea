"""speed_error.png: the error of every entry of a bench over its time a sample.

A broad line is the front that nothing beats. The name of a curve stands beside one of its
points, at the place that covers least: all are tried, nearest the point first in price.
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

    from drysim.bench.score import Bench, Panel, Score


LEAST = 1e-16
"""Errors below rounding are drawn at rounding [-]."""

BELOW = 0.1
"""Where the exact entry stands, over the least error of all others [-]: its own is none."""

ALIKE = 1e-11
"""Errors below this [-] are alike: the reference itself knows no better."""

GAP = 0.85
"""How far rows of panels are apart [inch]: each has its axis."""

EXACT: Style = {"color": "#0b3c6f", "marker": "*", "markersize": 15, "zorder": 5}
OWN: dict[str, Style] = {
    "switch": {"color": "#1b7837", "marker": "s"},
    "moreau": {"color": "#5a8fc7", "marker": "D"},
    "signum": {"color": "#b3261e", "marker": "^"},
    "smooth": {"color": "#e08214", "marker": "o"},
    "viscous": {"color": "#404040", "marker": "X"},
}
PEER: Style = {"color": "#6b6b6b", "fillstyle": "none"}
PEER_MARKS = "svoDP^<>"
FRONT: Style = {"color": "#0b3c6f", "linewidth": 5.0, "alpha": 0.18, "zorder": 1}
LFILTER: Style = {"color": "#404040", "linewidth": 1.0, "linestyle": (0, (1, 2)), "zorder": 1}

MEANING = (
    "filled: approaches of drysim; hollow: other programs; broad line: what no other beats"
)

ERRORS: tuple[tuple[str, Callable[[Score], float | None]], ...] = (
    ("error of $x_r$ / peak [–]", lambda score: score.error_x_r),
    (
        "error of $T_a$, relative [–]",
        lambda score: None if score.error_T_a is None else abs(score.error_T_a),
    ),
)


def speed_error(bench: Bench, folder: Path) -> None:
    """Write speed_error.png: error of x_r and of T_a over the time a sample."""
    style.paint(lambda: draw(bench), folder / "speed_error.png")


def draw(bench: Bench) -> Figure:
    """Give the picture of a bench, not yet rendered."""
    figure, grid = style.sheet(len(bench.panels), 2, gap=GAP)
    alone = len(bench.panels) == 1
    drawn = []
    for row, panel in enumerate(bench.panels):
        for column, (words, error) in enumerate(ERRORS):
            axes = figure.add_subplot(grid[row, column])
            known = _panel(axes, panel, error)
            sweep.name(axes, words if alone else f"{panel.scenario.name}: {words}")
            drawn.append((axes, known))
    title = bench.panels[0].scenario.name if alone else "speed against error"
    style.complete(figure, grid, (title, [MEANING], []))
    for axes, known in drawn:
        label(axes, known)
    return figure


def _panel(axes: Axes, panel: Panel, error: Callable[[Score], float | None]) -> list[Curve]:
    """Draw the entries of one scene; gives what is to be labelled."""
    axes.set(xscale="log", yscale="log")
    known: dict[str, Curve] = {}
    errors = [value for one in panel.scores if (value := error(one)) and isfinite(value)]
    floor = max(BELOW * min(errors, default=1.0), LEAST)
    for scores, look in styled(panel.scores):
        shown = sorted(
            (one.time, floor if value is None else max(value, LEAST))
            for one in scores
            if one.time and ((value := error(one)) is None) is _exact(one)
            if value is None or isfinite(value)
        )
        if shown:
            t, y = zip(*shown, strict=True)
            axes.plot(t, y, linewidth=0.9, **{"markersize": 5, **look})
            name = scores[0].approach
            before = known[name].lines if name in known else ()
            label = f"{name}: exact, no error" if any(map(_exact, scores)) else name
            known[name] = Curve(label, (*before, tuple(shown)), look["color"])
    axes.axvline(panel.lfilter, **LFILTER)
    axes.text(
        panel.lfilter, 0.98, "lfilter ", transform=axes.get_xaxis_transform(), size=7.5,
        rotation=90, ha="right", va="top",
    )  # fmt: skip
    axes.set_xlabel("time a sample [ns]")
    axes.margins(x=0.1, y=0.15)
    axes.autoscale_view()
    axes.autoscale(False)
    _front(axes, [at for curve in known.values() for line in curve.lines for at in line])
    return list(known.values())


def _exact(score: Score) -> bool:
    """Tell whether an entry is what the others are held to, and has no error to be drawn."""
    return score.own and score.error_x_r is None and score.verdict.startswith("exact")


def _front(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """Draw the front: for every time the least error that is to be had in it."""
    best, t, y = float("inf"), [], []
    for time, error in sorted(points):
        if max(error, ALIKE) < best:
            best = error
            t.append(time)
            y.append(error)
    if t:
        # From the top down to the quickest, and on to the right from the most exact.
        (_, right), (_, top) = axes.get_xlim(), axes.get_ylim()
        t, y = [t[0], *t, right], [top, *y, best]
        axes.plot(t, y, drawstyle="steps-post", solid_joinstyle="round", **FRONT)


def styled(scores: Sequence[Score]) -> Iterator[tuple[list[Score], Style]]:
    """Give the entries of every line, which share all but step, sharpness and tolerance."""
    grouped: dict[tuple[str, ...], list[Score]] = {}
    for one in scores:
        word, _, rest = one.setting.partition(", ")
        kin = (one.approach, *((word, rest.partition(", ")[2]) if one.own else ()))
        grouped.setdefault(kin, []).append(one)
    peers = [kin for kin, members in grouped.items() if not members[0].own]
    for kin, members in grouped.items():
        if members[0].own:
            yield members, OWN.get(kin[0], EXACT)
        else:
            yield members, {**PEER, "marker": PEER_MARKS[peers.index(kin) % len(PEER_MARKS)]}


# Where labels go in a crowded picture: beside a point of their curve, clear of all else.


SIZE = 7.5
"""Size of the letters [pt]."""

WIDE, TALL = 0.53, 1.15
"""Width and height of a letter over its size [-]."""

AWAY = (7.0, 14.0, 24.0, 36.0, 50.0)
"""Distances from the point at which a place is tried [pt]."""

WAYS = 16
"""Directions in which a place is tried."""

ROOM = 3.0
"""Room around a label [pt]."""

CLOSE = 4.0
"""Distance of the points that stand for a line [pt]."""

CLASH, FAR, OUTSIDE = 10.0, 0.02, 100.0
"""What covering something costs, a point of distance, and leaving the panel."""


class Curve(NamedTuple):
    """A curve that wants a label.

    Attributes
    ----------
    label : str
    lines : sequence of sequence of (x, y)
        Its lines, each by its points in the units of the axes.
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


def label(axes: Axes, curves: Sequence[Curve]) -> None:
    """Write the name of every curve into its axes, whose limits and place must be settled."""
    scale = 72.0 / axes.figure.dpi
    lines = [
        [np.asarray(axes.transData.transform(line)) * scale for line in curve.lines]
        for curve in curves
    ]
    if not lines:
        return
    shown = [np.concatenate(own) for own in lines]
    taken = np.concatenate([filled(line) for own in lines for line in own])
    frame = axes.get_window_extent()
    panel = Box(*(scale * end for end in (frame.x0, frame.x1, frame.y0, frame.y1)))
    placed: list[Box] = []
    for curve, points in sorted(zip(curves, shown, strict=True), key=lambda pair: len(pair[1])):
        box, point = min(
            candidates(curve.label, points),
            key=lambda one: cost(one[0], one[1], taken, placed, panel),
        )
        placed.append(box)
        middle = (0.5 * (box.left + box.right) / scale, 0.5 * (box.bottom + box.top) / scale)
        axes.annotate(
            curve.label, tuple(point / scale), middle, size=SIZE,
            xycoords="figure pixels", textcoords="figure pixels", ha="center", va="center",
            color=curve.color, zorder=6,
            arrowprops={"arrowstyle": "-", "color": curve.color, "linewidth": 0.4,
                        "shrinkA": 0, "shrinkB": 3},
        )  # fmt: skip


def filled(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the points of a line, and what lies between them closely enough to be covered."""
    between = []
    for begin, way in zip(line[:-1], np.diff(line, axis=0), strict=True):
        shares = np.linspace(0.0, 1.0, int(np.abs(way).max() / CLOSE) + 2)
        between.append(begin + shares[:, None] * way)
    return np.concatenate([line, *between])


def candidates(
    words: str, points: NDArray[np.float64]
) -> Iterator[tuple[Box, NDArray[np.float64]]]:
    """Give places beside every point of a curve."""
    half = 0.5 * WIDE * SIZE * len(words), 0.5 * TALL * SIZE
    for point in points:
        for away in AWAY:
            for angle in np.arange(WAYS) * 2.0 * np.pi / WAYS:
                x = point[0] + np.cos(angle) * (away + half[0])
                y = point[1] + np.sin(angle) * (away + half[1])
                yield Box(x - half[0], x + half[0], y - half[1], y + half[1]), point


def cost(
    box: Box,
    point: NDArray[np.float64],
    taken: NDArray[np.float64],
    placed: Sequence[Box],
    panel: Box,
) -> float:
    """Give how bad a place is."""
    x, y = taken[:, 0], taken[:, 1]
    covered = (x > box.left - ROOM) & (x < box.right + ROOM)
    covered &= (y > box.bottom - ROOM) & (y < box.top + ROOM)
    clashes = int(covered.sum()) + 2 * sum(overlap(box, other) for other in placed)
    outside = (
        box.left < panel.left or box.right > panel.right
        or box.bottom < panel.bottom or box.top > panel.top
    )  # fmt: skip
    middle = np.array([0.5 * (box.left + box.right), 0.5 * (box.bottom + box.top)])
    far = float(np.abs(middle - point).max())
    return CLASH * clashes + OUTSIDE * outside + FAR * far


def overlap(one: Box, other: Box) -> bool:
    """Tell whether two boxes share a point."""
    return (
        one.left < other.right + ROOM and other.left < one.right + ROOM
        and one.bottom < other.top and other.bottom < one.top
    )  # fmt: skip
