"""Means over many seeds in words: a value with its interval, and which seeds there were."""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, log10
from typing import Protocol

from drysim.wording.numbers import number

FINEST = 1e-6
"""Half-width over value from which on an interval is told [-]; a narrower one is rounding."""


class Wish(Protocol):
    """When seeds are to be enough."""

    @property
    def metric(self) -> str:
        """Name of the metric."""

    @property
    def half_width(self) -> float:
        """Half-width of its interval over its mean [-]."""


def around(value: float | None, half_width: float | None, unit: str = "") -> str:
    """Give a mean with half of its confidence interval, e.g. `0.8376 ± 0.0014`.

    Both end at the second digit of the half-width, beyond which the mean says nothing.
    """
    if value is None or not half_width or half_width < FINEST * abs(value):
        return number(value, unit)
    places = 1 - floor(log10(half_width))
    if places < 0 or max(abs(value), half_width) < 1e-3 or half_width >= 1e6:
        return f"{number(value)} ± {number(half_width, unit, 2)}"
    words = f"{value + 0.0:.{places}f} ± {half_width:.{places}f}"
    return f"{words} {unit}" if unit else words


def seeds(drawn: Sequence[int], until: Wish | None, counts: Sequence[int] = ()) -> str:
    """Give which seeds there were, and what the values behind a ± are.

    `counts` are the numbers of seeds of many cases, ascending.
    """
    number_of = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else str(len(drawn))
    span = f"{number_of}{' in every case' * bool(counts)}, from {drawn[0]} to {drawn[-1]}"
    wish = ""
    if until is not None:
        share = number(100 * until.half_width, "%")
        wish = f"until the interval of {until.metric} is ±{share} of its mean; "
    return f"{span}; {wish}values are means, ± half of their 95 % confidence interval"
