"""A table as curves: what goes along the axis, what tells lines and panels apart."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from math import nan
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from drysim import wording
from drysim.study.survey import FREQUENCY

if TYPE_CHECKING:
    from drysim.scenario import Axis
    from drysim.study.table import Row, Table

DENSE = 5
"""Frequencies from which on a sweep is drawn over them, whatever varies fastest."""

FORCES = ("friction.kinetic", "friction.mu_kinetic", "friction.normal")
"""Keys that are drawn as what they come to: the kinetic friction force."""

LABELS = {
    FREQUENCY: "frequency $f$ [Hz]",
    "excitation.rms": "base acceleration $a_u$ RMS [m/s²]",
    **dict.fromkeys(FORCES, "kinetic friction force $F_{fk}$ [N]"),
}

SYMBOLS = {
    FREQUENCY: "$f$",
    "excitation.rms": "$a_u$",
    "oscillator.mass": "$m$",
    "oscillator.stiffness": "$k_x$",
    "oscillator.damping": "$b$",
    "oscillator.damping_ratio": "$\\xi$",
    "friction.kinetic": "$F_{fk}$",
    "friction.static": "$F_{fs}$",
    "friction.static_ratio": "$F_{fs}/F_{fk}$",
    "friction.normal": "$F_N$",
    "friction.mu_kinetic": "$\\mu_k$",
}
"""Keys that a legend calls by the symbols of the paper."""

MOST_PANELS, MOST_LINES = 4, 60
"""Panels and lines of one picture; of more some evenly spread ones are drawn."""

Point = Mapping[str, float]
Choice = TypeVar("Choice")


class Line(NamedTuple):
    """A curve: its words, its place among the other lines, and its rows along the axis."""

    label: str
    value: float
    rows: Sequence[Row]


class Panel(NamedTuple):
    """The curves of one picture panel, and its words where there are several."""

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
    points = [
        dict(zip((axis.key for axis in apart), values, strict=True))
        for values in product(*(axis.values for axis in apart))
    ]
    shown = spread(points, MOST_PANELS)
    values = spread(line.values if line else (nan,), MOST_LINES)
    panels = [_panel(point, line, values, own, references, table.axes) for point in shown]
    curves = len(points) * (len(line.values) if line else 1)
    label = axis_label(along) if along else ""
    return View(key, label, line, panels, curves - len(shown) * len(values))


def axis_label(axis: Axis) -> str:
    """Give the words for a swept key with their unit."""
    return LABELS.get(axis.key, f"{axis.key} [{wording.pretty(axis.unit) or '–'}]")


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
    several = {axis.key for axis in axes if len(axis.values) > 1}
    title = spoken({key: value for key, value in point.items() if key in several}, axes)
    return Panel(title, lines, drawn)


def spoken(point: Point, axes: Sequence[Axis]) -> str:
    """Give where a curve is, in symbols where the paper has some."""
    units = {axis.key: wording.pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{SYMBOLS.get(key, wording.short(key, units))} {wording.number(value, units[key])}"
        for key, value in point.items()
    )


def spread(choices: Sequence[Choice], most: int) -> list[Choice]:
    """Give at most so many of the choices, evenly spread, the first and the last among them."""
    if len(choices) <= most:
        return list(choices)
    return [choices[round(at * (len(choices) - 1) / (most - 1))] for at in range(most)]
