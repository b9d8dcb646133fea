"""A table as curves: what goes along the axis, what tells lines and panels apart."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from math import nan
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from drysim.report.plots.labels import FORCES, axis_label, spoken, title
from drysim.scenario.sweep.axis import points as every_point
from drysim.scenario.sweep.axis import walks
from drysim.scenario.sweep.drawn import Drawn
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
    """A curve: its words, its value on the axis of the lines, and its rows along the axis."""

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
        What tells the lines of a panel apart; the first of several keys that walk together.
    panels : sequence of Panel
    left_out : int
        Curves that are not drawn.
    sampled : bool
        Whether the cases are drawn at random, so that no line leads from one to the next.
    """

    key: str
    label: str
    line: Axis | None
    panels: Sequence[Panel]
    left_out: int
    sampled: bool = False

    def x(self, row: Row) -> float:
        """Give where a row is along the axis; nan for a reference that is all along it."""
        if self.key not in row.point:
            return nan
        return row.F_fk if self.key in FORCES else row.point[self.key]


def view(table: Table) -> View:
    """Give how to draw a sweep: its approach as lines, its reference dashed."""
    along, label, beside, others = _along(table.axes)
    told = max(others, key=lambda group: len(group[0].values), default=())
    told = told if told and len(told[0].values) > 1 else ()
    points = _points([group for group in others if group is not told])
    shown = spread(points, MOST_PANELS)
    places = _points([told] if told else [])
    drawn = spread(places, MOST_LINES)
    own = Curves(table.own, beside)
    references = [Curves(table.of(name), beside) for name in table.approaches[1:]]
    panels = [_panel(point, drawn, own, references, table.axes) for point in shown]
    left_out = len(points) * len(places) - len(shown) * len(drawn)
    return View(along, label, told[0] if told else None, panels, left_out)


def compared(made: Comparison) -> View:
    """Give how to draw a comparison: lines are approaches, one panel is the case shown."""
    table = made.table
    along, label, beside, others = _along(table.axes)
    curves = [Curves(table.of(name), beside) for name in table.approaches]
    points = _points(others)
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
    sampled = any(isinstance(axis.values, Drawn) for axis in table.axes)
    return View(along, label, None, panels, len(points) - len(shown), sampled)


def _along(axes: Sequence[Axis]) -> tuple[str, str, Collection[str], list[tuple[Axis, ...]]]:
    """Give the key of the axis, its words, what walks with it, and the other groups of keys."""
    along, groups = along_axis(axes), walks(axes)
    if along is None:
        return "", "", (), groups
    beside = {axis.key for group in groups if along in group for axis in group}
    others = [group for group in groups if along not in group]
    return along.key, axis_label(along), beside, others


def _points(groups: Iterable[Sequence[Axis]]) -> list[dict[str, float]]:
    """Give every combination of the values of some keys, those of a group side by side."""
    return [*every_point([axis for group in groups for axis in group])]


def along_axis(axes: Sequence[Axis]) -> Axis | None:
    """Give the swept key that a sweep is drawn over: the frequency, or what varies fastest."""
    several = [axis for axis in axes if len(axis.values) > 1] or list(axes)
    frequency = [a for a in several if a.key == FREQUENCY and len(a.values) >= DENSE]
    return next(iter(frequency + several), None)


class Curves:
    """Rows by everything but where they are along the axis, and what walks with it."""

    def __init__(self, rows: Iterable[Row], along: Collection[str]) -> None:
        self.found: defaultdict[frozenset[tuple[str, float]], list[Row]] = defaultdict(list)
        self.keys: set[str] = set()
        self.name = ""
        for row in rows:
            rest = {key: value for key, value in row.point.items() if key not in along}
            self.keys |= rest.keys()
            self.name = row.approach
            self.found[frozenset(rest.items())].append(row)

    def at(self, point: Point) -> list[Row]:
        """Give the rows at a point; keys that these rows do not know take no part."""
        known = {key: value for key, value in point.items() if key in self.keys}
        return self.found.get(frozenset(known.items()), [])


def _panel(
    point: Point,
    places: Sequence[Point],
    own: Curves,
    references: Sequence[Curves],
    axes: Sequence[Axis],
) -> Panel:
    """Give the curves of one panel, one at each place."""
    values = [next(iter(place.values()), nan) for place in places]
    lines = [
        Line(spoken(place, axes) or own.name, value, own.at({**point, **place}))
        for value, place in zip(values, places, strict=True)
    ]
    drawn = [
        Line(curves.name, value, curves.at({**point, **place}))
        for curves in references
        for value, place in zip(values, places, strict=True)
    ]
    return Panel(point, title(point, axes), lines, drawn)


def spread(choices: Sequence[Choice], most: int) -> list[Choice]:
    """Give at most so many of the choices, evenly spread, the first and the last among them."""
    if len(choices) <= most:
        return list(choices)
    return [choices[round(at * (len(choices) - 1) / (most - 1))] for at in range(most)]
