"""Where approaches agree: cases in which T_a is the yardstick's, and words that coincide."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import nan
from typing import TYPE_CHECKING

import numpy as np

from drysim.study.comparisons.comparison import Comparison
from drysim.study.sweeps.survey import AGREE, compared
from drysim.study.sweeps.table import Row
from drysim.wording import listed, percent, places, stretch

if TYPE_CHECKING:
    from drysim.scenario import Axis

MOTION = ("T_a", "x_r_rms", "x_r_peak")
"""The metrics by which words are told apart."""

SAME = 1e-6
"""Difference of a metric, relative to it, that no picture shows."""

Values = dict[frozenset[tuple[str, float]], tuple[float, ...]]

FEW = 5
"""Cases up to which each is named where they do not lie together."""


def range_of_agreement(comparison: Comparison, name: str) -> Iterator[str]:
    """Say in how many cases an approach agrees with the yardstick, and where they lie."""
    found, axes = list(compared(comparison, name)), comparison.table.axes
    rows = [row for row, _ in found]
    good = [row for row, off in found if agrees(off and off[0])]
    if len(rows) < 2:
        return
    if not good:
        yield f"{name} agrees within {percent(AGREE)} nowhere in this sweep"
        return
    share = f"{len(good)} of {len(rows)} cases"
    yield f"{name} agrees within {percent(AGREE)} in {share}{whereabouts(good, rows, axes)}"


def whereabouts(good: Sequence[Row], rows: Sequence[Row], axes: Sequence[Axis]) -> str:
    """Give where some of all cases lie; a range that is that of all tells nothing."""
    ends, every = _ends(good), _ends(rows)
    inside = [
        row for row in rows if all(a <= row.point[key] <= b for key, (a, b) in ends.items())
    ]
    narrower = stretch({key: at for key, at in ends.items() if at != every[key]}, axes)
    if len(inside) == len(good):
        return f": {narrower}"
    if len(good) <= FEW:
        varied = [key for key, (low, high) in every.items() if low < high]
        return f": {places([{key: row.point[key] for key in varied} for row in good], axes)}"
    return f", all within {narrower}" if narrower else ", scattered over the whole sweep"


def _ends(rows: Sequence[Row]) -> dict[str, tuple[float, float]]:
    """Give the least and the greatest value of every key."""
    columns = {key: [row.point[key] for row in rows] for key in rows[0].point}
    return {key: (min(column), max(column)) for key, column in columns.items()}


def coinciding(comparison: Comparison) -> Iterator[str]:
    """Say which words but the yardstick move alike in every case: one curve hides another."""
    groups: list[tuple[Values, list[str]]] = []
    for name in comparison.table.approaches:
        if name == comparison.yardstick:
            continue
        own = _values(comparison.table.of(name))
        like = (words for values, words in groups if _same(values, own))
        if words := next(like, None):
            words.append(name)
        else:
            groups.append((own, [name]))
    for _, words in groups:
        if len(words) > 1:
            yield f"{listed(words)} coincide"


def _values(rows: Iterable[Row]) -> Values:
    """Give what is compared, by where it is."""
    return {
        frozenset(row.point.items()): tuple(
            nan if (value := row.metrics.get(name)) is None else value for name in MOTION
        )
        for row in rows
    }


def _same(one: Values, other: Values) -> bool:
    """Tell whether values are the same but for rounding, and not all of them unknown."""
    if one.keys() != other.keys():
        return False
    own, others = np.array([*one.values()]), np.array([other[place] for place in one])
    known = bool(np.isfinite(own).any())
    return known and np.allclose(own, others, SAME, 0.0, equal_nan=True)


def agrees(deviation: float | None) -> bool:
    """Tell whether a deviation of T_a is within what counts as agreement; none is not."""
    return deviation is not None and abs(deviation) <= AGREE
