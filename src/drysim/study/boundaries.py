"""Boundaries between labelled regions of a plane: from crossings on edges to lines.

Method
    The plane has a grid of nodes with labels, and on the edges between them crossings at which
    the label changes. Around each cell the crossings of the same two labels are joined; where
    three or more regions meet, all crossings are joined in one point of the cell. The segments
    make polylines.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats

Integers = NDArray[np.int64]


REGIME, LOCKED = "regime", -1
"""The main field of labels of a plane, and its label for a mass that never moves."""


class Crossing(NamedTuple):
    """A boundary on an edge: share of the edge, labels on both sides, width of the strip."""

    share: float
    before: int
    after: int
    width: float


Crossings = Mapping[int, Sequence[Crossing]]
"""Crossings by the number of their edge, in order along it."""


def on_edges(ends: Floats, share: Floats) -> Floats:
    """Return the points at shares of edges with these ends, shapes (n, 2, 2) and (n,)."""
    a, b = ends[:, 0], ends[:, 1]
    points: Floats = np.where(share[:, None] == 1.0, b, a + share[:, None] * (b - a))
    return points


class Grid(NamedTuple):
    """Numbers of nodes along both axes; the first varies fastest in the numbers of nodes."""

    columns: int
    rows: int

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.columns * self.rows

    @property
    def shares(self) -> tuple[Floats, Floats]:
        """Nodes along both axes, as shares of the axes."""
        return np.linspace(0.0, 1.0, self.columns), np.linspace(0.0, 1.0, self.rows)

    @property
    def edges(self) -> Integers:
        """Numbers of the nodes at both ends of each edge: along the first axis, then others."""
        number = np.arange(self.nodes).reshape(self.rows, self.columns)
        along = np.stack([number[:, :-1], number[:, 1:]], axis=-1).reshape(-1, 2)
        across = np.stack([number[:-1], number[1:]], axis=-1).reshape(-1, 2)
        return np.concatenate([along, across])

    def sides(self, cell: tuple[int, int]) -> Iterator[tuple[int, int, bool]]:
        """Yield the sides around a cell: first node, edge, and whether it is reversed."""
        i, j = cell
        node, along = j * self.columns + i, j * (self.columns - 1) + i
        across = self.rows * (self.columns - 1) + node
        yield node, along, False
        yield node + 1, across + 1, False
        yield node + self.columns + 1, along + self.columns - 1, True
        yield node + self.columns, across, True

    def cells_at(self, edge: int) -> Iterator[tuple[int, int]]:
        """Yield the cells on both sides of an edge."""
        count = self.rows * (self.columns - 1)
        if edge < count:
            j, i = divmod(edge, self.columns - 1)
            yield from ((i, row) for row in (j - 1, j) if 0 <= row < self.rows - 1)
        else:
            j, i = divmod(edge - count, self.columns)
            yield from ((column, j) for column in (i - 1, i) if 0 <= column < self.columns - 1)


Pair = tuple[int, int]
"""Labels on both sides of a boundary, the smaller first."""


class Joined(NamedTuple):
    """Crossings joined in the cells."""

    points: list[Floats]
    """Points, as shares of the axes."""
    widths: list[float]
    """Width of the strip at each point."""
    segments: dict[Pair, list[tuple[int, int]]]
    """Pairs of points by the labels that they separate."""
    patches: list[tuple[int, Floats]]
    """Label and polygon of the parts of divided cells."""


class Corner(NamedTuple):
    """A point on the perimeter of a cell, and the label that begins there; -1 for a node."""

    number: int
    edge: int
    point: Floats
    before: int
    after: int

    @property
    def pair(self) -> Pair:
        """The labels that a crossing separates."""
        return min(self.before, self.after), max(self.before, self.after)


def join_crossings(
    grid: Grid, points: Floats, labels: Integers, crossings: Crossings
) -> Joined:
    """Join the crossings of all edges in the cells between them."""
    edges = grid.edges
    joined = Joined([], [], defaultdict(list), [])
    numbers: dict[int, list[int]] = {}
    for edge, several in crossings.items():
        a, b = points[edges[edge]]
        numbers[edge] = list(range(len(joined.points), len(joined.points) + len(several)))
        joined.points.extend(a + crossing.share * (b - a) for crossing in several)
        joined.widths.extend(
            crossing.width * float(np.abs(b - a).max()) for crossing in several
        )
    for cell in sorted({cell for edge in crossings for cell in grid.cells_at(edge)}):
        perimeter: list[Corner] = []
        for node, edge, is_reversed in grid.sides(cell):
            label = int(labels[node])
            perimeter.append(Corner(-1, edge, points[node], label, label))
            on_edge = [
                Corner(number, edge, joined.points[number], crossing.before, crossing.after)
                for number, crossing in zip(
                    numbers.get(edge, ()), crossings.get(edge, ()), strict=True
                )
            ]
            if is_reversed:
                on_edge = [
                    corner._replace(before=corner.after, after=corner.before)
                    for corner in on_edge[::-1]
                ]
            perimeter += on_edge
        join_cell(perimeter, joined)
    return joined


def join_cell(perimeter: Sequence[Corner], joined: Joined) -> None:
    """Join the crossings on the perimeter of one cell, and divide the cell along the lines."""
    left = [corner for corner in perimeter if corner.number >= 0]
    if len(left) < 2:
        return
    # Of a saddle, the shorter way; of a band between two nodes, along it.
    if len(left) == 4 and len({corner.pair for corner in left}) == 1:
        lengths = [
            np.hypot(*(left[i].point - left[i - 1].point))
            if left[i].edge != left[i - 1].edge
            else np.inf
            for i in range(4)
        ]
        if lengths[0] + lengths[2] < lengths[1] + lengths[3]:
            left = [left[-1], *left[:-1]]
    lines: list[tuple[Corner, Corner]] = []
    index = 0
    while index + 1 < len(left):
        if left[index].pair == left[index + 1].pair:
            lines.append((left[index], left[index + 1]))
            del left[index : index + 2]
            index = max(0, index - 1)
        else:
            index += 1
    while len(left) > 1 and left[0].pair == left[-1].pair:
        lines.append((left[-1], left[0]))
        left = left[1:-1]
    for corner, other in lines:
        joined.segments[corner.pair].append((corner.number, other.number))
    if left:  # three or more regions meet
        joined.points.append(np.mean([corner.point for corner in left], axis=0))
        joined.widths.append(0.0)
        for corner in left:
            joined.segments[corner.pair].append((corner.number, len(joined.points) - 1))
    joined.patches.extend(divided_cell(perimeter, lines, left, joined.points[-1]))


def divided_cell(
    perimeter: Sequence[Corner],
    lines: Sequence[tuple[Corner, Corner]],
    meeting: Sequence[Corner],
    middle: Floats,
) -> Iterator[tuple[int, Floats]]:
    """Yield label and polygon of the parts of a cell between lines across it.

    Parameters
    ----------
    perimeter : sequence of Corner
    lines : sequence of pairs of Corner
        Lines between two crossings; they do not intersect.
    meeting : sequence of Corner
        The other crossings, whose lines meet.
    middle : ndarray, shape (2,)
        Where they meet.
    """
    first = next(i for i, corner in enumerate(perimeter) if corner.number >= 0)
    ring = [*perimeter[first:], *perimeter[: first + 1]]
    arcs: dict[int, list[Corner]] = {}  # from one crossing to the next, by its number
    begin = 0
    for end in range(1, len(ring)):
        if ring[end].number >= 0:
            arcs[ring[begin].number] = ring[begin : end + 1]
            begin = end
    # A part goes along an arc, back along the line that its end is on, and so on.
    back = {corner.number: other.number for corner, other in lines}
    back |= {other.number: corner.number for corner, other in lines}
    back |= {corner.number: meeting[i - 1].number for i, corner in enumerate(meeting)}
    over_middle = {corner.number for corner in meeting}
    while arcs:
        number = next(iter(arcs))
        label, polygon = arcs[number][0].after, list[Floats]()
        while number in arcs:
            arc = arcs.pop(number)
            polygon += [corner.point for corner in arc]
            if arc[-1].number in over_middle:
                polygon.append(middle)
            number = back[arc[-1].number]
        yield label, np.array(polygon)


def polylines(segments: Sequence[tuple[int, int]]) -> Iterator[list[int]]:
    """Yield lines of segments between numbered points; a loop ends where it begins."""
    neighbours: dict[int, list[int]] = defaultdict(list)
    for a, b in segments:
        neighbours[a].append(b)
        neighbours[b].append(a)
    ends = [point for point, others in neighbours.items() if len(others) % 2]
    for start in [*ends, *neighbours]:
        while neighbours[start]:
            line = [start]
            while neighbours[line[-1]]:
                following = neighbours[line[-1]].pop()
                neighbours[following].remove(line[-1])
                line.append(following)
            yield line
