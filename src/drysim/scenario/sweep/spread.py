"""Evenly spread values: each is the double next to the decimal number that is meant."""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction
from math import lcm

MOST_VALUES = 10_000_000
"""Values of one axis: beyond it somebody has typed a step in other units."""

ON_STEP = Fraction(1, 10**9)
"""An end this close to a whole number of steps, in steps, is met: 30 deg are no decimal."""

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


def by_step(low: float, high: float, step: float, n: int) -> tuple[float, ...]:
    """Give low, low + step, ... high: the ends of n steps."""
    first, width = _exact(low), _exact(step)
    common = lcm(first.denominator, width.denominator)
    a, s = int(first * common), int(width * common)
    return (*((a + i * s) / common for i in range(n)), high)


def by_count(low: float, high: float, count: int) -> tuple[float, ...]:
    """Give values from low to high at equal distances."""
    first, last, n = _exact(low), _exact(high), count - 1
    common = lcm(first.denominator, last.denominator)
    a, b = int(first * common), int(last * common)
    return tuple((a * (n - i) + b * i) / (common * n) for i in range(count))


def by_ratio(low: float, high: float, count: int) -> tuple[float, ...]:
    """Give values from low to high at equal ratios."""
    first, last, n = Decimal(repr(low)), Decimal(repr(high)), count - 1
    span = _DIGITS.ln(_DIGITS.divide(last, first))

    def value(i: int) -> float:
        share = _DIGITS.divide(_DIGITS.multiply(span, Decimal(i)), Decimal(n))
        return float(_DIGITS.multiply(first, _DIGITS.exp(share)))

    return (low, *(value(i) for i in range(1, n)), high)


def _exact(value: float) -> Fraction:
    """Give the decimal number that a value is written as."""
    return Fraction(repr(value))
