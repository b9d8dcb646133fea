"""Axis: a swept key with its values; and how evenly spread values are spoken and made."""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from math import lcm
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, WithJsonSchema

from drysim.quantity import Block

MOST_VALUES = 10_000_000
"""Values of one axis: beyond it somebody has typed a step in other units."""

ON_STEP = 1e-9
"""An end this close to a whole number of steps, in steps, is met: 30 deg are no decimal."""

_DIGITS = Context(prec=25)
"""Enough for a logarithmic value to be the double next to it: 0.1, 1, 10, 100."""

_Number = Annotated[object, WithJsonSchema({"type": ["number", "string"]})]


@dataclass(frozen=True)
class Axis:
    """A key of the scenario that a sweep varies, and over what."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    unit: str
    """SI unit as in the header of a table, such as m/s2; `-` for a plain number."""
    values: tuple[float, ...]
    """In the order of the sweep, in the unit."""
    words: Any = field(default=None, compare=False, repr=False)
    """What a scenario file says for them: a list, or a block of from, to and step or count."""


class Range(Block):
    """Evenly spread values, both ends included."""

    low: _Number = Field(alias="from")
    """First value, a number in SI or a text with a unit."""
    high: _Number = Field(alias="to")
    """Last value, above the first."""
    step: _Number = None
    """Distance of the values, which meets `to`."""
    count: int | None = None
    """Number of values, at least 2, in place of `step`."""
    scale: Literal["linear", "log"] | None = None
    """Whether a `count` of values is spread by difference (linear, the default) or by ratio
    (log)."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("step", "count"),)
    needs: ClassVar[dict[str, str]] = {"scale": "count"}


def steps_between(low: float, high: float, step: float) -> tuple[int, float]:
    """Give the whole number of steps next to an end, and the value that so many lead to.

    At least one; the value is `high` itself when it is met.
    """
    first, last, width = (Fraction(repr(value)) for value in (low, high, step))
    n = max(1, round((last - first) / width))
    end = first + n * width
    return n, high if abs(end - last) <= Fraction(ON_STEP) * width else float(end)


def by_step(low: float, high: float, step: float, n: int) -> tuple[float, ...]:
    """Give low, low + step, ... high: n steps, each value the decimal number that it means."""
    first, width = Fraction(repr(low)), Fraction(repr(step))
    common = lcm(first.denominator, width.denominator)
    a, s = int(first * common), int(width * common)
    return (*((a + i * s) / common for i in range(n)), high)


def by_count(low: float, high: float, count: int) -> tuple[float, ...]:
    """Give values from low to high at equal distances, each the double next to the number."""
    first, last = Fraction(repr(low)), Fraction(repr(high))
    n, common = count - 1, lcm(first.denominator, last.denominator)
    a, b = int(first * common), int(last * common)
    return tuple((a * (n - i) + b * i) / (common * n) for i in range(count))


def by_ratio(low: float, high: float, count: int) -> tuple[float, ...]:
    """Give values from low to high at equal ratios, each the double next to the number."""
    first, last, n = Decimal(repr(low)), Decimal(repr(high)), count - 1
    span = _DIGITS.ln(_DIGITS.divide(last, first))
    inner = (
        float(
            first * _DIGITS.exp(_DIGITS.divide(_DIGITS.multiply(span, Decimal(i)), Decimal(n)))
        )
        for i in range(1, n)
    )
    return (low, *inner, high)
