"""Many cases as counts: how a metric scatters along a swept key, gathered block by block."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import exp, isqrt, log
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drysim.report.plots.scales import wide
from drysim.scenario.sweep.drawn import Drawn, LogNormal, Normal

if TYPE_CHECKING:
    from drysim.scenario import Axis
    from drysim.study.sweeps.batch import Batch

Floats = NDArray[np.float64]

MOST_VALUES, FEWEST_BINS, BINS = 120, 6, 48
"""Values of a key up to which each is a bin of its own; least and most bins of other keys."""

FINENESS = 256
"""Bins of a metric to a factor of e: less than the width of a line."""

SPAN = (log(1e-9), log(1e6))
"""Logarithms between which a metric may lie; what lies beyond is counted at the end."""

FAR = 1e-3
"""Share of a distribution without end that is drawn at the end of its axis."""


@dataclass
class Bins:
    """A swept key as bins: their middles, and the edges between them."""

    axis: Axis
    middles: Floats
    edges: Floats

    @classmethod
    def of(cls, axis: Axis) -> Bins:
        """Give a bin to each of few values; else bins of equal width or ratio."""
        values = axis.values
        if len(values) <= MOST_VALUES and not isinstance(values, Drawn):
            middles = np.unique(np.array(values, dtype=float))
            return cls(axis, middles, 0.5 * (middles[1:] + middles[:-1]))
        low, high = _ends(values)
        even = _by_ratio(values) and low > 0 and high >= 10 * low
        scale = np.geomspace if even else np.linspace
        most = isqrt(len(values)) if isinstance(values, Drawn) else BINS
        edges = scale(low, high, min(BINS, max(FEWEST_BINS, most)) + 1)
        middles = np.sqrt(edges[1:] * edges[:-1]) if even else 0.5 * (edges[1:] + edges[:-1])
        return cls(axis, middles, edges[1:-1])

    @property
    def even_in_ratio(self) -> bool:
        """Whether the key is drawn on a logarithmic axis."""
        return _by_ratio(self.axis.values) and wide(self.middles.tolist())

    def __len__(self) -> int:
        """Give the number of bins."""
        return len(self.middles)

    def fences(self) -> Floats:
        """Give the edges of all bins for drawing, halfway by the scale of the axis."""
        if len(self) == 1:
            return np.array([self.middles[0] - 0.5, self.middles[0] + 0.5])
        even = self.even_in_ratio
        x = np.log(self.middles) if even else self.middles
        between = 0.5 * (x[1:] + x[:-1])
        edges = np.array([2 * x[0] - between[0], *between, 2 * x[-1] - between[-1]])
        return np.asarray(np.exp(edges) if even else edges)

    def find(self, values: Floats) -> NDArray[np.intp]:
        """Give the bin of every value."""
        return np.searchsorted(self.edges, values, side="right")


def _ends(values: Any) -> tuple[float, float]:
    """Give the ends of the values of a key, those of a distribution where it has none."""
    if not isinstance(values, Drawn):
        return float(values[0]), float(values[-1])
    share = FAR if isinstance(values.law, Normal | LogNormal) else 0.0
    low, high = values.law.quantile(np.array([share, 1.0 - share])).tolist()
    return low, high


def _by_ratio(values: Any) -> bool:
    """Tell whether a logarithmic axis may suit a key: of a drawn one, where it is drawn so."""
    if not isinstance(values, Drawn):
        return True
    return isinstance(values.law, LogNormal) or getattr(values.law, "log", False)


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
