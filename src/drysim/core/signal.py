"""Numbers in the order of time that are had by parts: an array, or what stays in a file."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

BLOCK = 65_536
"""Numbers worked on at a time: a few megabytes, which stay near the processor."""

KEPT = 1 << 20
"""Numbers up to which what can be had again is kept: some megabytes. A longer motion is solved
by parts, each made anew whenever it is asked for: that costs a tenth of writing it down."""


class Signal(Protocol):
    """Numbers of which any stretch can be had as an array; arrays are signals."""

    def __len__(self) -> int:
        """Give how many there are."""

    def __getitem__(self, part: slice, /) -> NDArray[np.float64]:
        """Give a stretch of them."""


def blocks(signal: Signal, size: int = BLOCK) -> Iterator[NDArray[np.float64]]:
    """Give a signal block by block."""
    return (signal[at : at + size] for at in range(0, len(signal), size))


def moments(signal: Signal) -> tuple[float, float]:
    """Return the mean of a signal and its RMS about that mean."""
    mean = sum(float(part.sum()) for part in blocks(signal)) / len(signal)
    squares = sum(float(np.square(part - mean).sum()) for part in blocks(signal))
    return mean, sqrt(squares / len(signal))


def largest(signal: Signal) -> float:
    """Give the greatest magnitude in a signal."""
    return max((float(np.abs(part).max()) for part in blocks(signal)), default=0.0)
