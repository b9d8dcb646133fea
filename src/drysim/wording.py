"""Text shared by all outputs: numbers, ranges, lengths, counts and units.

Each function returns text on one line. Numbers have four significant digits, units are written
as in print (`m/s²`, `N·s/m`), and unprintable characters of foreign text are escaped.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import floor, log10
from typing import Any, NamedTuple

SIGNIFICANT_DIGITS = 4
"""Significant digits in text; the output files contain all digits."""

UNKNOWN = "not known"

Point = Mapping[str, Any]
"""Swept keys of a case with their values: numbers in SI, text for files."""


def format_number(
    value: float | str | None, unit: str = "", digits: int = SIGNIFICANT_DIGITS
) -> str:
    """Return a number with few digits, without trailing zeros, followed by its unit.

    Parameters
    ----------
    value : float or str or None
        None yields `not known`; of text, such as a swept file, control characters are
        escaped.
    unit : str, optional
        Unit of the value; empty or a dash for none.
    digits : int, optional
        Significant digits.

    Returns
    -------
    str
        E.g. `17.26 mm`, `7500 N/m`, `2.1e-15`.
    """
    if isinstance(value, str):
        return sanitise(value)
    if value is None:
        return UNKNOWN
    value += 0.0  # -0.0 is printed as 0
    size = floor(log10(abs(value))) if value and abs(value) < float("inf") else 0
    if -4 <= size < 6:
        text = f"{value:.{max(0, digits - 1 - size)}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
    else:
        mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return with_unit(text, unit)


def interval_digits(width: float, largest: float, more: int = 0) -> int:
    """Return the digits in which the ends of an interval differ, at least 4."""
    return min(max(4, 2 + more + len(f"{largest / width:.0f}")), 12) if width > 0.0 else 4


def format_range(
    low: float | str | None,
    high: float | str | None,
    unit: str = "",
    digits: int = SIGNIFICANT_DIGITS,
) -> str:
    """Return a range or interval; one value if both ends read the same.

    Parameters
    ----------
    low, high : float or str or None
        Ends, as numbers or as text; None for an end that is not known.
    unit : str, optional
        Unit of both, as in `format_number`.
    digits : int, optional
        Significant digits of numbers.

    Returns
    -------
    str
        E.g. `1 to 2 Hz`, `at least 1 Hz`, `at most 2 Hz`.
    """
    first, last = (format_number(end, digits=digits) for end in (low, high))
    if low is None and high is None:
        return UNKNOWN
    if high is None:
        text = f"at least {first}"
    elif low is None:
        text = f"at most {last}"
    else:
        text = first if first == last else f"{first} to {last}"
    return with_unit(text, unit)


def format_distinct(values: Sequence[float]) -> list[str]:
    """Return values as text, with as many digits as needed to distinguish them."""
    for digits in range(SIGNIFICANT_DIGITS, 18):
        texts = [format_number(value, digits=digits) for value in values]
        if len({*texts}) == len({*values}):
            break
    return texts


def with_unit(text: str, unit: str) -> str:
    """Return text followed by a unit; empty or a dash for none."""
    return f"{text} {unit}" if unit not in ("", "-", "–") else text


def format_deviation(deviation: float, half_width: float | None = None, digits: int = 3) -> str:
    """Return a relative deviation [-] in percent with its sign, of a mean with its interval.

    Returns
    -------
    str
        E.g. `+84 %`, `-1.20 ± 0.35 %`.
    """
    sign = "+" if deviation >= 0 else ""
    if half_width:
        return sign + format_interval(100 * deviation, 100 * half_width, "%")
    return sign + format_number(100 * deviation, "%", digits)


MIN_RELATIVE_HALF_WIDTH = 1e-6
"""Relative half-width [-] below which an interval is rounding and not shown."""


def format_interval(value: float | None, half_width: float | None, unit: str = "") -> str:
    """Return a mean with the half-width of its confidence interval, e.g. `0.8376 ± 0.0014`.

    Both end at the second significant digit of the half-width.
    """
    if value is None or not half_width or half_width < MIN_RELATIVE_HALF_WIDTH * abs(value):
        return format_number(value, unit)
    places = 1 - floor(log10(half_width))
    if places < 0 or max(abs(value), half_width) < 1e-3 or half_width >= 1e6:
        return f"{format_number(value)} ± {format_number(half_width, unit, 2)}"
    text = f"{value + 0.0:.{places}f} ± {half_width:.{places}f}"
    return f"{text} {unit}" if unit else text


class LengthUnit(NamedTuple):
    """A unit of length: units per metre, and symbol."""

    units_per_metre: float
    symbol: str


UNIT_CHANGE_RATIO = 1e3
"""Ratio of two lengths above which each has a unit of its own."""


def length_unit(size: float, reference: float = 0.0) -> LengthUnit:
    """Return the unit in which a length is readable: mm, or m or µm for extreme lengths.

    Parameters
    ----------
    size : float
        The length [m].
    reference : float, optional
        A length [m] in the same output. Its unit is used unless `size` is more than
        `UNIT_CHANGE_RATIO` times as long.
    """
    size = reference if abs(size) <= UNIT_CHANGE_RATIO * abs(reference) else size
    if abs(size) >= 10.0:
        return LengthUnit(1.0, "m")
    return LengthUnit(1e6, "µm") if 0.0 < abs(size) < 1e-5 else LengthUnit(1e3, "mm")


def display_unit(unit: str, size: float, reference: float = 0.0) -> tuple[float, str]:
    """Return the factor from SI and the unit in which a value is shown.

    Lengths are shown as in `length_unit`, shares in percent, all else in SI.
    """
    if unit == "m":
        return length_unit(size, reference)
    return (100.0 if unit == "%" else 1.0), unit


def format_quantity(
    value: float | str | None, unit: str, digits: int = SIGNIFICANT_DIGITS
) -> str:
    """Return the value of a key in SI, e.g. `7 Hz`; a length is shown as in `length_unit`."""
    if value is None or isinstance(value, str):
        return format_number(value)
    factor, symbol = display_unit(format_unit(unit), value)
    return format_number(factor * value, symbol, digits)


def format_quantity_range(
    low: float | str | None,
    high: float | str | None,
    unit: str,
    digits: int = SIGNIFICANT_DIGITS,
) -> str:
    """Return a range of values of a key in SI as `format_range`, lengths as `length_unit`."""
    if isinstance(low, str) or isinstance(high, str):
        return format_range(low, high)
    size = max((abs(end) for end in (low, high) if end is not None), default=0.0)
    factor, symbol = display_unit(format_unit(unit), size)
    first, last = (None if end is None else factor * end for end in (low, high))
    return format_range(first, last, symbol, digits)


def format_length(value: float | None, reference: float | None = None) -> str:
    """Return a length [m], e.g. `17.26 mm`; `reference` as in `length_unit`."""
    unit = length_unit(value or 0.0, reference or 0.0)
    return format_number(None if value is None else value * unit.units_per_metre, unit.symbol)


def format_percent(share: float | None) -> str:
    """Return a share [-] in percent; only 0 and 1 are shown as 0 % and 100 %."""
    if share is None:
        return UNKNOWN
    if 0 < share < 0.001 or 0.999 < share < 1:
        return "below 0.1 %" if share < 0.5 else "above 99.9 %"
    return format_number(share * 100, "%", 3)


def format_percent_range(low: float, high: float) -> str:
    """Return a range of shares [-] in percent, both ends with the decimals of the larger.

    Only 0 and 1 are shown as 0 % and 100 %.
    """
    first, last = format_percent(low), format_percent(high)
    decimals = len(last.removesuffix(" %").partition(".")[2])
    rounded = f"{100 * low:.{decimals}f}"
    if first[0].isdigit() and 0 < float(rounded) < 100:
        first = f"{rounded} %"
    return format_range(first, last)


def format_count(count: int, thing: str) -> str:
    """Return a count with its noun, e.g. `1 case` or `3 cases`."""
    plural = "es" if thing.endswith("ch") else "s"
    return f"{count} {thing}{plural * (count != 1)}"


def format_times(count: float | None) -> str:
    """Return a number of repetitions, e.g. `once` or `3 times`."""
    return "once" if count == 1 else f"{count} times"


def join_words(words: Sequence[str], last: str = "and") -> str:
    """Join words to a list in a sentence, e.g. `a, b and c`; `last` precedes the last word."""
    *most, end = words
    return f"{', '.join(most)} {last} {end}" if most else end


def sanitise(text: str) -> str:
    """Return foreign text on one line, with control characters and escape sequences escaped."""
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode()
        for character in " ".join(text.split())
    )


def format_unit(unit: str) -> str:
    """Return a unit as in print, e.g. `m/s²` for `m/s2`; empty for a plain number."""
    superscripts = {"2": "²", "3": "³"}
    unit = re.sub(r"(?<=[a-z)])[23]", lambda digit: superscripts[digit[0]], unit)
    return "" if unit == "-" else unit.replace("*", "·")


SUBSCRIPTS = str.maketrans("012ehkmnoprstuvxa", "₀₁₂ₑₕₖₘₙₒₚᵣₛₜᵤᵥₓₐ")
"""The letters and digits of indices that are characters of their own; f and w are not."""


def typeset(text: str) -> str:
    """Lower the indices of T_a, x_r and the like; those of F_fk and a_w stay as they are.

    x_r_min is no symbol.
    """
    return re.sub(
        r"\b([A-Za-zσ])_([012aehkmnoprstuvx]+)\b",
        lambda symbol: symbol[1] + symbol[2].translate(SUBSCRIPTS),
        text,
    )
