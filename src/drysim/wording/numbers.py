"""Numbers, units and other people's words as a line of text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import floor, log10
from typing import NamedTuple

SIGNIFICANT = 4
"""Digits that an engineer reads; the files hold them all."""

UNKNOWN = "not known"


def number(value: float | None, unit: str = "", digits: int = SIGNIFICANT) -> str:
    """Give a number as people write it: few digits, no needless zeros, the unit behind.

    Parameters
    ----------
    value : float or None
        None reads `not known`.
    unit : str, optional
        Unit of the value; empty or a dash for none.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        E.g. `17.26 mm`, `7500 N/m`, `2.1e-15`.
    """
    if value is None:
        return UNKNOWN
    value += 0.0  # -0.0 is 0 to people
    size = floor(log10(abs(value))) if value and abs(value) < float("inf") else 0
    if -4 <= size < 6:
        text = f"{value:.{max(0, digits - 1 - size)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return f"{text} {unit}" if unit not in ("", "-", "–") else text


class LengthUnit(NamedTuple):
    """A unit of length: how many of it a metre has, and its sign."""

    per_metre: float
    sign: str


FARTHER = 1e3
"""Times a length that another must exceed to be told in a unit of its own."""


def length_unit(size: float, beside: float = 0.0) -> LengthUnit:
    """Return the unit in which a length [m] reads well: mm, or m and µm far from it.

    Lengths of one output share the unit of the one that they stand beside, unless they are
    more than 1000 times as long.
    """
    size = beside if abs(size) <= FARTHER * abs(beside) else size
    if abs(size) >= 10.0:
        return LengthUnit(1.0, "m")
    return LengthUnit(1e6, "µm") if 0.0 < abs(size) < 1e-5 else LengthUnit(1e3, "mm")


def told_in(unit: str, size: float, beside: float = 0.0) -> tuple[float, str]:
    """Return the factor and the unit by which SI values of a size are told.

    Lengths `m` as `length_unit` has it, shares `%` as a hundredth, all else as it is.
    """
    if unit == "m":
        return length_unit(size, beside)
    return (100.0 if unit == "%" else 1.0), unit


def length(value: float | None, beside: float | None = None) -> str:
    """Return a length [m], e.g. `17.26 mm`; `beside` is explained in `length_unit`."""
    unit = length_unit(value or 0.0, beside or 0.0)
    return number(None if value is None else value * unit.per_metre, unit.sign)


def percent(share: float | None) -> str:
    """Give a share [-] in percent; what is neither 0 nor 1 is never rounded to look so."""
    if share is None:
        return UNKNOWN
    if 0 < share < 0.001 or 0.999 < share < 1:
        return "below 0.1 %" if share < 0.5 else "above 99.9 %"
    return number(share * 100, "%", 3)


def several(count: int, thing: str) -> str:
    """Give how many things there are, e.g. `1 case` or `3 cases`."""
    return f"{count} {thing}{'s' * (count != 1)}"


def times(count: float | None) -> str:
    """Give how often something happened, e.g. `once` or `3 times`."""
    return "once" if count == 1 else f"{count} times"


def listed(words: Sequence[str], last: str = "and") -> str:
    """Give words as a list in a sentence, e.g. `a, b and c`; `last` stands before the last."""
    *most, end = words
    return f"{', '.join(most)} {last} {end}" if most else end


def clean(text: str) -> str:
    """Give a user's text on one line, with all that could drive a terminal spelled out."""
    return "".join(map(_visible, " ".join(text.split())))


def _visible(sign: str) -> str:
    return sign if sign.isprintable() else sign.encode("unicode_escape").decode()


def pretty(unit: str) -> str:
    """Give the unit of a table as people write it; nothing for a plain number."""
    signs = {"2": "²", "3": "³"}
    unit = re.sub(r"(?<=[a-z)])[23]", lambda digit: signs[digit[0]], unit)
    return "" if unit == "-" else unit.replace("*", "·")
