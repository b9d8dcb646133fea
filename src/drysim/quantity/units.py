"""A number with a unit in a text, converted. The one place that knows the units library."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from drysim.quantity.kinds import ASCII, KINDS, PLAIN
from drysim.quantity.words import meant, near, short

NUMBER = re.compile(r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")
"""A decimal number; possessive, so that a megabyte of digits costs no more than reading it."""

LONGEST_UNIT = 60
"""Characters of a unit; what is longer is none, and is not looked into."""

LONGEST_NUMBER = 300
"""Characters of a number that is converted digit by digit; of a longer one the double."""

_UNIT = re.compile(r"(?:1/)?(?:[^\W\d]\w*+(?:\^-?\d(?:\.\d\d)?)?|[*/()%°])++")
_NUMBERED = re.compile(r"\s*+(?:[^\W\d_]|[%°(–/-]|1/)")
_SIGNS = str.maketrans("⁻¹²³·⋅×−", "-123***-")


class _Found(NamedTuple):
    """What the units library knows of a unit: factor to base units, dimension, angle or not."""

    factor: float
    dimension: str
    angle: bool


def convert(text: str, unit: str) -> float:
    """Give the number that a text such as `25 mm` means in a unit of `KINDS`.

    A number without a unit is in that unit already. The product is rounded once, so
    `35 mm` is the very double 0.035.

    Raises
    ------
    ValueError
        With a sentence, when the text is no number with a unit of the right kind.
    """
    unit, words = ASCII.get(unit, unit), text.translate(_SIGNS).strip()
    if re.match(r"[-+]?[0-9]+,[0-9]", words):
        raise ValueError(f"`{short(text)}` has a comma; write numbers with a decimal point")
    number = NUMBER.match(words)
    rest = words[number.end() :].strip() if number else ""
    if number is None or (rest and not _NUMBERED.match(rest)):
        kind = f"a number [{unit}] or a number with a unit" if unit else "a number"
        raise ValueError(f"must be {kind}, not `{short(text)}`")
    value, scale = float(number[0]), factor(rest, unit) if rest else 1.0
    if scale == 1.0 or value == 0.0 or not math.isfinite(value):
        return value
    digits = number[0] if len(number[0]) <= LONGEST_NUMBER else repr(value)
    try:
        return float(Fraction(digits) * _exact(scale))
    except OverflowError:
        return math.copysign(math.inf, value)


def unit_behind(text: str) -> str:
    """Give the unit that a text with a number in front names; empty for none."""
    words = text.translate(_SIGNS).strip()
    number = NUMBER.match(words)
    return words[number.end() :].strip() if number else ""


def _exact(scale: float) -> Fraction:
    """Give the number that a factor stands for: 1/60 or 0.001, not the double next to it."""
    simple = Fraction(scale).limit_denominator(1_000_000)
    close = math.isclose(float(simple), scale, rel_tol=4e-16)
    return simple if close else Fraction(repr(scale))


def factor(unit_text: str, unit: str) -> float:
    """Give what one of the unit written is in a unit of `KINDS`, e.g. 0.001 for mm in m.

    Raises
    ------
    ValueError
        With a sentence, when the unit is unknown or measures something else.
    """
    unit = ASCII.get(unit, unit)
    if len(unit_text) > LONGEST_UNIT:
        raise ValueError(f"unknown unit `{short(unit_text)}`")
    spelt = _spelt(unit_text)
    known = PLAIN[unit].get(spelt)
    return float(known) if known is not None else _rare_factor(unit_text, spelt, unit)


def usual(unit_text: str, unit: str) -> bool:
    """Tell whether a text is a usual way to write a unit of the kind of one of `KINDS`."""
    short_enough = len(unit_text) <= LONGEST_UNIT
    return short_enough and _spelt(unit_text) in PLAIN[ASCII.get(unit, unit)]


def _spelt(unit_text: str) -> str:
    """Give a unit as `PLAIN` spells it."""
    spelt = re.sub(r"\s*([*/])\s*", r"\1", unit_text.translate(_SIGNS).strip())
    return re.sub(r"(?<=[^\W\d])(?:\^|\*\*)?(-?[0-9])", r"^\1", re.sub(r"\s+", "*", spelt))


def _rare_factor(unit_text: str, spelt: str, unit: str) -> float:
    """Give the factor by the units library, which is imported only for this."""
    found = _look_up(spelt)
    if found is None:
        nearest = near(unit_text.strip(), PLAIN[unit]) or ""
        hint = meant(nearest.replace("^2", "²"))
        raise ValueError(f"unknown unit `{short(unit_text)}`{hint}")
    target = _target(unit)
    # Per second, a radian is 1/2π of a cycle; anywhere else but in an angle it is a slip.
    if unit == "Hz" and found.angle and found.dimension == target.dimension:
        return found.factor / (2 * math.pi)
    if found[1:] != target[1:]:
        hint = meant(next((u for u in PLAIN[unit] if u.lower() == spelt.lower()), None))
        wrong = _measured(found, spelt)
        raise ValueError(f"`{short(unit_text)}` is a unit of {wrong}, not {_named(unit)}{hint}")
    computed = found.factor / target.factor
    decimal = float(f"{computed:.12g}")  # drops the library's rounding of 0.0254 and its like
    return decimal if math.isclose(decimal, computed, rel_tol=1e-15) else computed


def _measured(found: _Found, spelt: str) -> str:
    """Name what a unit measures, as far as drysim has a word for it; `g` is one of two."""
    same = [KINDS[unit] for unit in PLAIN if _target(unit)[1:] == found[1:]]
    usually = [KINDS[unit] for unit in PLAIN if spelt in PLAIN[unit]]
    return " or ".join(dict.fromkeys([*same[:1], *usually])) or "something else"


def _named(unit: str) -> str:
    """Name a kind with its unit, e.g. `length [m]`."""
    return f"{KINDS[unit]} [{unit}]" if unit else "a plain number"


def _target(unit: str) -> _Found:
    """Give a unit of `KINDS` as the units library knows it."""
    found = _look_up(next(iter(PLAIN[unit])) if unit else "m/m")
    assert found is not None
    return found


@cache
def _look_up(spelt: str) -> _Found | None:
    """Give what the units library knows, or None where it knows nothing."""
    if not _UNIT.fullmatch(spelt):
        return None
    registry = _registry()
    try:
        one, two = (registry.Quantity(n, spelt).to_root_units() for n in (1.0, 2.0))
    except Exception:  # it raises whatever its parser raises
        return None
    if two.magnitude != 2 * one.magnitude:  # degrees Celsius, decibels
        return None
    return _Found(float(one.magnitude), str(one.dimensionality), "radian" in str(one.units))


@cache
def _registry() -> Any:
    """Give the units library, loaded once."""
    import pint

    return pint.UnitRegistry()
