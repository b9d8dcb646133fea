"""Samples that stay in their file, however many they are: each stretch is read when needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from drysim.core.signal import Signal
from drysim.excitation.record.columns import Floats


@dataclass(frozen=True)
class Stored:
    """Samples in a file, from number `first` to the one before `last`, times a factor.

    `read` gives those from one number to the one before another.
    """

    read: Callable[[int, int], Floats]
    first: int
    last: int
    factor: float = 1.0

    def __len__(self) -> int:
        """Give how many there are."""
        return self.last - self.first

    def __getitem__(self, part: slice, /) -> Floats:
        """Read a stretch of them."""
        first, last, every = part.indices(len(self))
        values = self.read(self.first + first, self.first + max(first, last))
        values *= self.factor
        return values[::every]


def scaled(signal: Signal, factor: float) -> Signal:
    """Give a signal times a factor; an array is changed in place."""
    if isinstance(signal, Stored):
        return replace(signal, factor=signal.factor * factor)
    values = signal[:]
    values *= factor
    return values


def stretch(signal: Signal, first: int, last: int) -> Signal:
    """Give a signal from one number to the one before another."""
    if isinstance(signal, Stored):
        return replace(signal, first=signal.first + first, last=signal.first + last)
    return signal[first:last]
