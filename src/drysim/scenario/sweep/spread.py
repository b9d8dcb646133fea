"""Evenly spread values: each is the double next to the decimal number that is meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from math import lcm

from drysim.scenario.sweep.lazy import Lazy

MOST_VALUES = 10_000_000
"""Values of one axis: beyond it somebody has typed a step in other units."""

HELD = 10_000
"""Values up to which an axis holds them; of more each is made when it is asked for."""

ON_STEP = Fraction(1, 10**9)
"""An end this close to a whole number of steps, in steps, is met: 30 deg are no decimal."""

STRIDE = 4096
"""Values on a log scale between two whose ratio to the first is worked out for itself: all are
products of two of some 2 * 4096 ratios, where 1e7 values have as many exponentials."""

_DIGITS = Context(prec=25)
"""Enough for a logarithmic value to be the double next to it: 0.1, 1, 10, 100."""


def steps_between(low: float, high: float, step: float) -> tuple[int, float]:
    """Give the whole number of steps next to an end, and the value that so many lead to.

    At least one; the value is `high` itself when it is met.
    """
    first, last, width = _exact(low), _exact(high), _exact(step)
    n = max(1, round((last - first) / width))
    end = first + n * width
    return n, high if abs(end - last) <= ON_STEP * width else float(end)


@dataclass(frozen=True)
class Spread(Lazy[float]):
    """Evenly spread values, each made when it is asked for: (first + i width)/common.

    On a log scale each is low (high/low)^(i/n).
    """

    low: float
    high: float
    steps: int
    fraction: tuple[int, int, int] | None

    def __len__(self) -> int:
        """Give the number of values."""
        return self.steps + 1

    def one(self, number: int) -> float:
        """Give one value."""
        return self.at([number])[0]

    def at(self, numbers: Sequence[int]) -> list[float]:
        """Give some values by their numbers, each named once."""
        if self.fraction is None:
            values = self._by_ratio(numbers)
        else:
            first, width, common = self.fraction
            values = [(first + i * width) / common for i in numbers]
        for i in {0, self.steps} & set(numbers):
            values[numbers.index(i)] = self.high if i else self.low
        return values

    def _by_ratio(self, numbers: Sequence[int]) -> list[float]:
        low, times, ratio = Decimal(repr(self.low)), _DIGITS.multiply, self._ratio
        firsts = {at: times(low, ratio(at)) for at in {i - i % STRIDE for i in numbers}}
        return [float(times(firsts[i - i % STRIDE], ratio(i % STRIDE))) for i in numbers]

    def _ratio(self, i: int) -> Decimal:
        """Give (high/low)^(i/n); few of them are worked out, and kept."""
        found = self._ratios.get(i)
        if found is None:
            share = _DIGITS.divide(
                _DIGITS.multiply(self._span, Decimal(i)), Decimal(self.steps)
            )
            found = self._ratios[i] = _DIGITS.exp(share)
        return found

    @cached_property
    def _ratios(self) -> dict[int, Decimal]:
        return {}

    @cached_property
    def _span(self) -> Decimal:
        """The logarithm of high/low."""
        low, high = Decimal(repr(self.low)), Decimal(repr(self.high))
        return _DIGITS.ln(_DIGITS.divide(high, low))


def by_step(low: float, high: float, step: float, n: int) -> Sequence[float]:
    """Give low, low + step, ... high: the ends of n steps."""
    first, width = _exact(low), _exact(step)
    common = lcm(first.denominator, width.denominator)
    return _few(Spread(low, high, n, (int(first * common), int(width * common), common)))


def by_count(low: float, high: float, count: int) -> Sequence[float]:
    """Give values from low to high at equal distances."""
    first, last, n = _exact(low), _exact(high), count - 1
    common = lcm(first.denominator, last.denominator)
    a, b = int(first * common), int(last * common)
    return _few(Spread(low, high, n, (a * n, b - a, common * n)))


def by_ratio(low: float, high: float, count: int) -> Sequence[float]:
    """Give values from low to high at equal ratios."""
    return _few(Spread(low, high, count - 1, None))


def _few(values: Spread) -> Sequence[float]:
    """Hold values that are few."""
    return tuple(values) if len(values) <= HELD else values


def _exact(value: float) -> Fraction:
    """Give the decimal number that a value is written as."""
    return Fraction(repr(value))
