"""Many cases as counts: how a metric scatters along a swept key, gathered block by block."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import exp, isqrt, log
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drysim.report.plots.scales import wide
from drysim.scenario.sweep.drawn import Distribution, Drawn, LogNormal, Normal
from drysim.scenario.sweep.spread import Spread

if TYPE_CHECKING:
    from drysim.scenario import Axis
    from drysim.study.sweeps.batch import Batch

Floats = NDArray[np.float64]

MOST_VALUES, FEWEST_BINS, BINS = 120, 6, 48
"""Values of a key up to which each is a bin of its own; least and most bins of other keys."""

A_CELL = 4
"""Cases of a sample that a cell of a map has on the average: few cells remain empty."""

FINENESS = 256
"""Bins of a metric to a factor of e: less than the width of a line."""

SPAN = (log(1e-9), log(1e6))
"""Logarithms between which a metric may lie; what lies beyond is counted at the end."""

FAR = 1e-3
"""Share of a distribution without end that is drawn at the end of its axis."""


@dataclass(frozen=True)
class Bins:
    """A swept key as bins.

    Attributes
    ----------
    axis : Axis
    middles, fences : ndarray
        Middles of the bins, and their edges, both ends included.
    x : ndarray
        Where curves have their points: the middles, and the ends of a range.
    even_in_ratio : bool
        Whether the key is drawn on a logarithmic axis.
    """

    axis: Axis
    middles: Floats
    fences: Floats
    x: Floats
    even_in_ratio: bool

    @classmethod
    def of(cls, axis: Axis) -> Bins:
        """Give a bin to each of few values; else bins of equal width or ratio."""
        values = axis.values
        if isinstance(values, Drawn):
            most = max(FEWEST_BINS, isqrt(len(values) // A_CELL))
            fences, even = _fences(*_ends(values.law), min(BINS, most), _by_ratio(values.law))
        else:
            ordered = values if isinstance(values, Spread) else sorted({*values})
            if len(ordered) <= MOST_VALUES:
                middles, even = np.array(ordered, dtype=float), wide(ordered)
                return cls(axis, middles, _between(middles, even), middles, even)
            fences, even = _fences(ordered[0], ordered[-1], BINS)
            fences = _filled(fences, ordered)
        middles = np.sqrt(fences[1:] * fences[:-1]) if even else (fences[1:] + fences[:-1]) / 2
        return cls(axis, middles, fences, np.array([fences[0], *middles, fences[-1]]), even)

    def __len__(self) -> int:
        """Give the number of bins."""
        return len(self.middles)

    @property
    def beyond(self) -> int:
        """How many points a curve has beyond the middles at either end."""
        return (len(self.x) - len(self)) // 2

    def find(self, values: Floats) -> NDArray[np.intp]:
        """Give the bin of every value."""
        return np.searchsorted(self.fences[1:-1], values, side="right")


def _between(middles: Floats, even_in_ratio: bool) -> Floats:
    """Give edges halfway between values by the scale of their axis, and as far beyond them."""
    if len(middles) == 1:
        return np.array([middles[0] - 0.5, middles[0] + 0.5])
    x = np.log(middles) if even_in_ratio else middles
    between = 0.5 * (x[1:] + x[:-1])
    edges = np.array([2 * x[0] - between[0], *between, 2 * x[-1] - between[-1]])
    return np.asarray(np.exp(edges) if even_in_ratio else edges)


def _fences(low: float, high: float, count: int, by_ratio: bool = True) -> tuple[Floats, bool]:
    """Give edges of bins between two ends, and whether they are even in ratio."""
    even = by_ratio and wide((low, high))
    return (np.geomspace if even else np.linspace)(low, high, count + 1), even


def _filled(fences: Floats, ordered: Sequence[float]) -> Floats:
    """Give edges with a value between any two: those of a range may lie farther apart."""
    below = [bisect_left(ordered, fence) for fence in fences[1:-1].tolist()]
    _, first = np.unique([0, *below, len(ordered)], return_index=True)
    return np.append(fences[first[:-1]], fences[-1])


def _ends(law: Distribution) -> tuple[float, float]:
    """Give the ends of a distribution, for one without some that hold nearly all of it."""
    share = FAR if isinstance(law, Normal | LogNormal) else 0.0
    low, high = law.quantile(np.array([share, 1.0 - share])).tolist()
    return low, high


def _by_ratio(law: Distribution) -> bool:
    """Tell whether a logarithmic axis may suit a key that is drawn so."""
    return isinstance(law, LogNormal) or getattr(law, "log", False)


@dataclass
class Scatter:
    """How often a metric has which value in which bin, its greatest, and its mean on a map."""

    metric: str
    along: Bins
    across: Bins | None
    counts: NDArray[np.int64] = field(init=False)
    sums: Floats = field(init=False)
    cells: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        """Begin with nothing."""
        width = int((SPAN[1] - SPAN[0]) * FINENESS) + 2
        self.counts = np.zeros((len(self.along), width), dtype=np.int64)
        size = len(self.along) * (len(self.across) if self.across else 0)
        self.sums, self.cells = np.zeros(size), np.zeros(size, dtype=np.int64)

    def add(self, batch: Batch) -> None:
        """Count the cases of a block that know the metric."""
        values = batch.metrics[self.metric]
        known = values == values
        x = batch.points.get(self.along.axis.key)
        if x is None or not known.any():
            return
        values, at = values[known], self.along.find(x[known])
        width = self.counts.shape[1]
        with np.errstate(divide="ignore"):
            logs = np.log(values)
        place = np.clip((logs - SPAN[0]) * FINENESS + 1, 0, width - 1).astype(np.int64)
        np.add.at(self.counts, (at, place), 1)
        y = batch.points.get(self.across.axis.key) if self.across else None
        if self.across is not None and y is not None:
            cell = at * len(self.across) + self.across.find(y[known])
            self.sums += np.bincount(cell, values, minlength=len(self.sums))
            self.cells += np.bincount(cell, minlength=len(self.cells))

    def quantile(self, level: float) -> Floats:
        """Give a quantile of the metric in every bin; NaN where nothing is known."""
        below = np.cumsum(self.counts, axis=1)
        total = below[:, -1]
        at = np.argmax(below >= level * np.maximum(total, 1)[:, None], axis=1)
        values = np.array([0.0 if k == 0 else exp(SPAN[0] + (k - 0.5) / FINENESS) for k in at])
        return np.where(total > 0, values, np.nan)

    def curve(self, level: float) -> Floats:
        """Give a quantile at the points of a curve: that of a range's last bin to its end."""
        return np.pad(self.quantile(level), self.along.beyond, mode="edge")

    @property
    def map(self) -> Floats:
        """The mean of the metric, shape (bins across, bins along); NaN where none is known."""
        assert self.across is not None, "asked for where there is something across"
        with np.errstate(invalid="ignore", divide="ignore"):
            means = self.sums / self.cells
        return np.asarray(means.reshape(len(self.along), len(self.across)).T)


def gathered(batches: Iterable[Batch], approach: str, scatters: Sequence[Scatter]) -> None:
    """Let scatters count the cases of an approach."""
    for batch in batches:
        if batch.approach == approach:
            for scatter in scatters:
                scatter.add(batch)
