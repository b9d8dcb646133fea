"""What a table says at a glance: extremes with where they are, and where the seat isolates."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from drysim.study.comparisons.comparison import Comparison, off_by
from drysim.study.sweeps.table import Row

FREQUENCY = "excitation.frequency"
"""The key over which a transmissibility is drawn and read."""

AGREE = 0.05
"""Deviation of T_a up to which two approaches agree [-]."""


class Isolation(NamedTuple):
    """From which frequency [Hz] on T_a stays below 1; None where it does nowhere."""

    point: Mapping[str, float]
    above: float | None


class Deviation(NamedTuple):
    """T_a of a row relative to the yardstick's at the same point, minus 1 [-].

    The row is the one of the two that tells the point in full. Of many seeds the value is a
    mean, with half the width of its confidence interval.
    """

    value: float
    row: Row
    half_width: float | None = None


def isolation(rows: Iterable[Row]) -> list[Isolation]:
    """Give where isolation begins on every curve over the frequency.

    Notes
    -----
    A frequency at which T_a is not known counts as one that is not isolated.
    """
    curves: dict[tuple[tuple[str, float], ...], list[Row]] = {}
    for row in rows:
        rest = tuple(item for item in row.point.items() if item[0] != FREQUENCY)
        curves.setdefault(rest, []).append(row)
    return [Isolation(dict(rest), _begin(curve)) for rest, curve in curves.items()]


def _begin(curve: Sequence[Row]) -> float | None:
    """Give the frequency from which on T_a stays below 1."""
    begin = None
    for row in sorted(curve, key=lambda row: -row.point[FREQUENCY]):
        T_a = row.metrics.get("T_a")
        if T_a is None or T_a >= 1.0:
            break
        begin = row.point[FREQUENCY]
    return begin


def compared(
    comparison: Comparison, approach: str
) -> Iterator[tuple[Row, tuple[float, float | None] | None]]:
    """Give what an approach is off by, with half of its interval, at every point.

    Each row is the one of the approach or of the yardstick that tells the point in full.
    """
    for row, other in comparison.pairs(approach):
        yield row if len(row.point) >= len(other.point) else other, off_by(row, other)


def deviations(comparison: Comparison, approach: str) -> list[Deviation]:
    """Give by how much an approach is off its yardstick, wherever both know T_a."""
    found = compared(comparison, approach)
    return [Deviation(off[0], row, off[1]) for row, off in found if off is not None]


def worst(found: Sequence[Deviation]) -> Deviation | None:
    """Give the greatest deviation, the first of its kind."""
    return max(found, key=lambda one: abs(one.value), default=None)
