"""Where labels go in a crowded picture: beside a point of their curve, clear of all else."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

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
        middle = (0.5 * (box.left + box.right), 0.5 * (box.bottom + box.top))
        axes.annotate(
            curve.label, tuple(point / scale), middle_of(middle, scale), size=SIZE,
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


def middle_of(middle: tuple[float, float], scale: float) -> tuple[float, float]:
    """Give a place in dots."""
    return middle[0] / scale, middle[1] / scale


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
