"""A table as curves: what goes along the axis, what tells lines and panels apart."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from math import nan
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from drysim.report.plots.labels import FORCES, axis_label, spoken, title
from drysim.study.sweeps.survey import FREQUENCY

if TYPE_CHECKING:
    from drysim.scenario import Axis
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.sweeps.table import Row, Table

DENSE = 5
"""Frequencies from which on a sweep is drawn over them, whatever varies fastest."""

MOST_PANELS, MOST_LINES = 4, 60
"""Panels and lines of one picture; of more some evenly spread ones are drawn."""

MOST_COMPARED = 3
"""Panels of a comparison, which have the motion above them."""

Point = Mapping[str, float]
Choice = TypeVar("Choice")


class Line(NamedTuple):
    """A curve: its words, its place among the other lines, and its rows along the axis."""

    label: str
    value: float
    rows: Sequence[Row]


class Panel(NamedTuple):
    """The curves of one picture panel, and its words where there are several."""

    point: Point
    title: str
    lines: Sequence[Line]
    references: Sequence[Line]


class View(NamedTuple):
    """How a table is drawn.

    Attributes
    ----------
    key : str
        What goes along the axis; empty where nothing is swept.
    label : str
        The words below the axis.
    line : Axis or None
        What tells the lines of a panel apart.
    panels : sequence of Panel
    left_out : int
        Curves that are not drawn.
    """

    key: str
    label: str
    line: Axis | None
    panels: Sequence[Panel]
    left_out: int

    def x(self, row: Row) -> float:
        """Give where a row is along the axis; nan for a reference that is all along it."""
        if self.key not in row.point:
            return nan
        return row.F_fk if self.key in FORCES else row.point[self.key]


def view(table: Table) -> View:
    """Give how to draw a sweep: its approach as lines, its reference dashed."""
    along = along_axis(table.axes)
    others = [axis for axis in table.axes if axis is not along]
    line = max(others, key=lambda axis: len(axis.values), default=None)
    line = line if line and len(line.values) > 1 else None
    apart = [axis for axis in others if axis is not line]
    key = along.key if along else ""
    own = Curves(table.own, key)
    references = [Curves(table.of(name), key) for name in table.approaches[1:]]
    points = _points(apart)
    shown = spread(points, MOST_PANELS)
    values = spread(line.values if line else (nan,), MOST_LINES)
    panels = [_panel(point, line, values, own, references, table.axes) for point in shown]
    curves = len(points) * (len(line.values) if line else 1)
    label = axis_label(along) if along else ""
    return View(key, label, line, panels, curves - len(shown) * len(values))


def compared(made: Comparison) -> View:
    """Give how to draw a comparison: lines are approaches, one panel is the case shown."""
    table = made.table
    along = along_axis(table.axes)
    key, label = (along.key, axis_label(along)) if along else ("", "")
    curves = [Curves(table.of(name), key) for name in table.approaches]
    points = _points([axis for axis in table.axes if axis is not along])
    case = [at for at in points if all(made.shown.get(k, v) == v for k, v in at.items())]
    shown = spread(points, MOST_COMPARED)
    if case and case[0] not in shown:
        shown = [case[0], *shown[1:]]
    panels = [
        Panel(
            at, title(at, table.axes), [Line(one.name, nan, one.at(at)) for one in curves], ()
        )
        for at in shown
    ]
    return View(key, label, None, panels, len(points) - len(shown))


def _points(axes: Sequence[Axis]) -> list[dict[str, float]]:
    """Give every combination of the values of some axes."""
    return [
        dict(zip((axis.key for axis in axes), values, strict=True))
        for values in product(*(axis.values for axis in axes))
    ]


def along_axis(axes: Sequence[Axis]) -> Axis | None:
    """Give the swept key that a sweep is drawn over: the frequency, or what varies fastest."""
    several = [axis for axis in axes if len(axis.values) > 1] or list(axes)
    frequency = [a for a in several if a.key == FREQUENCY and len(a.values) >= DENSE]
    return next(iter(frequency + several), None)


class Curves:
    """Rows by everything but where they are along the axis."""

    def __init__(self, rows: Iterable[Row], along: str) -> None:
        self.found: defaultdict[frozenset[tuple[str, float]], list[Row]] = defaultdict(list)
        self.keys: set[str] = set()
        self.name = ""
        for row in rows:
            rest = {key: value for key, value in row.point.items() if key != along}
            self.keys |= rest.keys()
            self.name = row.approach
            self.found[frozenset(rest.items())].append(row)

    def at(self, point: Point) -> list[Row]:
        """Give the rows at a point; keys that these rows do not know take no part."""
        known = {key: value for key, value in point.items() if key in self.keys}
        return self.found.get(frozenset(known.items()), [])


def _panel(
    point: Point,
    line: Axis | None,
    values: Sequence[float],
    own: Curves,
    references: Sequence[Curves],
    axes: Sequence[Axis],
) -> Panel:
    """Give the curves of one panel."""
    places = [{**point, line.key: value} if line else dict(point) for value in values]
    lines = [
        Line(spoken({line.key: value}, axes) if line else own.name, value, own.at(place))
        for value, place in zip(values, places, strict=True)
    ]
    drawn = [
        Line(curves.name, value, curves.at(place))
        for curves in references
        for value, place in zip(values, places, strict=True)
    ]
    return Panel(point, title(point, axes), lines, drawn)


def spread(choices: Sequence[Choice], most: int) -> list[Choice]:
    """Give at most so many of the choices, evenly spread, the first and the last among them."""
    if len(choices) <= most:
        return list(choices)
    return [choices[round(at * (len(choices) - 1) / (most - 1))] for at in range(most)]
