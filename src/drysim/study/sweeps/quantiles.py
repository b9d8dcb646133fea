"""Quantiles of any number of values in little memory, whatever the blocks they come in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

FINENESS = 256
"""Bins to a factor of e: a quantile is known within 0.2 % of its value."""

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
"""The quantiles that are told."""


class Quantiles:
    """A histogram in bins of equal ratio; values at or below zero share one bin."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()
        self._none = 0
        self._low, self._high = np.inf, -np.inf

    def add(self, values: NDArray[np.float64]) -> None:
        """Count values; NaN is passed over."""
        values = values[values == values]
        if not len(values):
            return
        self._low = min(self._low, float(values.min()))
        self._high = max(self._high, float(values.max()))
        above = values[values > 0.0]
        self._none += len(values) - len(above)
        if len(above):
            bins = np.floor(np.log(above) * FINENESS).astype(np.int64)
            counts = np.bincount(bins - (first := int(bins.min())))
            held = np.flatnonzero(counts)
            found = zip((held + first).tolist(), counts[held].tolist(), strict=True)
            self._counts.update(dict(found))

    def at(self, level: float) -> float | None:
        """Give a quantile; None where there are no values."""
        total = self._none + self._counts.total()
        if not total:
            return None
        for value, below in self._steps():
            if below >= level * total:
                return float(min(max(value, self._low), self._high))
        return self._high

    def told(self) -> dict[str, float]:
        """Give the quantiles of `LEVELS` by name, such as `0.5`; empty without values."""
        found = ((f"{level:g}", self.at(level)) for level in LEVELS)
        return {name: value for name, value in found if value is not None}

    def _steps(self) -> Iterator[tuple[float, int]]:
        """Give the middle of every bin and how many values lie up to its end."""
        below = self._none
        yield min(self._low, 0.0), below
        for at in sorted(self._counts):
            below += self._counts[at]
            yield float(np.exp((at + 0.5) / FINENESS)), below
