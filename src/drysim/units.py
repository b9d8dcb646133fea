"""Units: conversion of a number, or of text such as `25 mm`, into SI.

`convert` rounds once. Common unit spellings are in a table; pint resolves the others and is
imported only for them, because a dry run takes 1.6 times as long with it.
"""

import math
import re
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from drysim.messages import closest_match, did_you_mean, shorten

QUANTITY_NAMES = {
    "kg": "mass",
    "N/m": "stiffness",
    "N·s/m": "damping",
    "N": "force",
    "N·s": "impulse",
    "m": "length",
    "m/s": "velocity",
    "m/s²": "acceleration",
    "s": "time",
    "Hz": "frequency",
    "J": "energy",
    "rad": "angle",
    "(m/s²)²/Hz": "acceleration PSD",
    "m³": "PSD of height",
    "1/m": "wave number",
    "s/m": "sharpness",
    "m/s^1.75": "vibration dose",
    "": "ratio",
}
"""The SI units of scenarios and the name of the quantity that each measures."""

UNIT_SYNONYMS = {
    "m/s2": "m/s²",
    "m/s^2": "m/s²",
    "N*s/m": "N·s/m",
    "N*s": "N·s",
    "1/s": "Hz",
    "-": "",
    "–": "",
}

# Common spellings, which need no pint. `g` is gram or gravity, depending on the quantity. The
# first entry of each row is the SI unit itself.
UNIT_FACTORS: dict[str, dict[str, float]] = {
    "kg": {"kg": 1, "g": 1e-3, "t": 1e3},
    "N/m": {"N/m": 1, "kN/m": 1e3, "N/mm": 1e3},
    "N·s/m": {"N*s/m": 1, "Ns/m": 1, "kg/s": 1, "kN*s/m": 1e3, "kNs/m": 1e3},
    "N": {"N": 1, "kN": 1e3},
    "N·s": {"N*s": 1, "Ns": 1, "kN*s": 1e3, "kNs": 1e3, "kg*m/s": 1},
    "m": {"m": 1, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3},
    "m/s²": {
        "m/s^2": 1,
        "g": 9.80665,
        "mg": 9.80665e-3,
        "cm/s^2": 1e-2,
        "mm/s^2": 1e-3,
        "ug": 9.80665e-6,
        "G": 9.80665,
        "mG": 9.80665e-3,
        "gn": 9.80665,
        "g_n": 9.80665,
        "Gal": 1e-2,
        "gal": 1e-2,
        "mGal": 1e-5,
        "mgal": 1e-5,
    },
    "s": {"s": 1, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60, "h": 3600},
    "Hz": {"Hz": 1, "1/s": 1, "kHz": 1e3},
    "J": {"J": 1, "mJ": 1e-3, "kJ": 1e3},
    "rad": {"rad": 1, "deg": math.pi / 180, "°": math.pi / 180},
    "(m/s²)²/Hz": {"m^2/s^3": 1, "(m/s^2)^2/Hz": 1, "(m/s^2)2/Hz": 1, "g^2/Hz": 96.1703842225},
    "m³": {"m^3": 1, "cm^3": 1e-6, "mm^3": 1e-9},
    "s/m": {"s/m": 1, "s/mm": 1e3},
    "m/s^1.75": {"m/s^1.75": 1},
    "1/m": {"1/m": 1, "cycle/m": 1, "cycles/m": 1, "rad/m": 0.5 / math.pi},
    "": {"-": 1, "–": 1, "%": 1e-2},
}


# Conversion of text to numbers.


NUMBER_PATTERN = re.compile(r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")
"""A decimal number. Possessive quantifiers keep matching linear in the length of the text."""

MAX_UNIT_LENGTH = 60
"""Characters of a unit; longer text is rejected without parsing it."""

_UNIT_PATTERN = re.compile(r"(?:1/)?(?:[^\W\d]\w*+(?:\^-?\d(?:\.\d\d)?)?|[*/()%°])++")
_UNIT_START = re.compile(r"\s*+(?:[^\W\d_]|[%°(–/-]|1/)")
_ASCII_CHARACTERS = str.maketrans("⁻¹²³·⋅×−", "-123***-")
_MICRO = str.maketrans("µμ", "uu")


class _PintUnit(NamedTuple):
    """Properties of a unit from pint: factor to base units, dimension, whether an angle."""

    factor: float
    dimension: str
    angle: bool


def convert(text: str, unit: str) -> float:
    """Convert text such as `25 mm` into a number in a given unit.

    Parameters
    ----------
    text : str
        A number, or a number with a unit. Without a unit it is taken to be in `unit`.
    unit : str
        A key of `QUANTITY_NAMES`.

    Returns
    -------
    float
        The value in `unit`. The product is rounded once: `35 mm` is exactly the double 0.035.

    Raises
    ------
    ValueError
        With a sentence, if the text is no number with a unit of the right quantity.
    """
    unit, plain = UNIT_SYNONYMS.get(unit, unit), text.translate(_ASCII_CHARACTERS).strip()
    if re.match(r"[-+]?[0-9]+,[0-9]", plain):
        raise ValueError(f"`{shorten(text)}` has a comma; write numbers with a decimal point")
    number, rest = NUMBER_PATTERN.match(plain), unit_suffix(text)
    if number is None or (rest and not _UNIT_START.match(rest)):
        kind = f"a number [{unit}] or a number with a unit" if unit else "a number"
        raise ValueError(f"must be {kind}, not `{shorten(text)}`")
    value, scale = float(number[0]), conversion_factor(rest, unit) if rest else 1.0
    if scale == 1.0 or value == 0.0 or not math.isfinite(value):
        return value
    digits = number[0] if len(number[0]) <= 300 else repr(value)  # bounds the cost of Fraction
    try:
        return float(Fraction(digits) * _exact_factor(scale))
    except OverflowError:
        return math.copysign(math.inf, value)


def unit_suffix(text: str) -> str:
    """Return the unit that follows the number in a text; empty if there is none."""
    plain = text.translate(_ASCII_CHARACTERS).strip()
    number = NUMBER_PATTERN.match(plain)
    return plain[number.end() :].strip() if number else ""


def _exact_factor(scale: float) -> Fraction:
    """Return the exact rational that a factor stands for, e.g. 1/60 or 0.001."""
    simple = Fraction(scale).limit_denominator(1_000_000)
    close = math.isclose(float(simple), scale, rel_tol=4e-16)
    return simple if close else Fraction(repr(scale))


def conversion_factor(unit_text: str, unit: str) -> float:
    """Return the factor from one unit to another, e.g. 0.001 for mm to m.

    Parameters
    ----------
    unit_text : str
        The unit to convert from, as written by a user.
    unit : str
        The unit to convert to, a key of `QUANTITY_NAMES`.

    Raises
    ------
    ValueError
        With a sentence, if the unit is unknown or measures another quantity.
    """
    unit = UNIT_SYNONYMS.get(unit, unit)
    if len(unit_text) > MAX_UNIT_LENGTH:
        raise ValueError(f"unknown unit `{shorten(unit_text)}`")
    spelling = _canonical_spelling(unit_text)
    factor = UNIT_FACTORS[unit].get(spelling)
    return float(factor) if factor is not None else _pint_factor(unit_text, spelling, unit)


def is_common_unit(unit_text: str, unit: str) -> bool:
    """Return whether a text is a common spelling of a unit of the same quantity as `unit`."""
    short_enough = len(unit_text) <= MAX_UNIT_LENGTH
    return (
        short_enough
        and _canonical_spelling(unit_text) in UNIT_FACTORS[UNIT_SYNONYMS.get(unit, unit)]
    )


def is_known_unit(text: str) -> bool:
    """Return whether a text is a unit of any quantity, as opposed to a comment."""
    if not text.strip() or len(text) > MAX_UNIT_LENGTH:
        return False
    spelling = _canonical_spelling(text)
    if any(spelling in spellings for spellings in UNIT_FACTORS.values()):
        return True
    if not _UNIT_PATTERN.fullmatch(spelling):
        return False
    for name in (spelling, spelling.lower()):  # `Volts` is written for `volts`
        try:
            _registry().Unit(name)
        except Exception:  # pint raises exceptions of many types
            continue
        return True
    return False


USUAL_PREFIXES = (
    "giga", "mega", "kilo", "hecto", "deca", "deci", "centi", "milli", "micro", "nano"
)  # fmt: skip
PREFIXED_UNITS = ("meter", "gram", "second", "newton", "hertz", "joule", "radian")
"""Prefixes and units of which pint's compounds are units that somebody writes."""


def is_usual_unit(text: str) -> bool:
    """Return whether a unit is one that somebody writes, unlike `ma`, pint's milli-year."""
    spelling = _canonical_spelling(text)
    if any(spelling in spellings for spellings in UNIT_FACTORS.values()):
        return True
    if not spelling.isalpha():  # a compound, such as `lbf/in`
        return True
    return len(spelling) > 1 and any(
        not prefix or (prefix in USUAL_PREFIXES and unit in PREFIXED_UNITS)
        for prefix, unit, _ in _registry().parse_unit_name(spelling)
    )


def _canonical_spelling(unit_text: str) -> str:
    """Return a unit in the spelling of `UNIT_FACTORS`."""
    spelling = re.sub(
        r"\s*([*/])\s*", r"\1", unit_text.translate(_ASCII_CHARACTERS | _MICRO).strip()
    )
    return re.sub(r"(?<=[^\W\d])(?:\^|\*\*)?(-?[0-9])", r"^\1", re.sub(r"\s+", "*", spelling))


def _pint_factor(unit_text: str, spelling: str, unit: str) -> float:
    """Return the conversion factor of an uncommon unit from pint."""
    source = _look_up_in_pint(spelling)
    if source is None:
        nearest = closest_match(unit_text.strip(), UNIT_FACTORS[unit]) or ""
        hint = did_you_mean(nearest.replace("^2", "²"))
        raise ValueError(f"unknown unit `{shorten(unit_text)}`{hint}")
    target = _pint_unit_of(unit)
    # rad/s is a frequency of 1/2π Hz; in other units that are no angles a radian is an error.
    if unit == "Hz" and source.angle and source.dimension == target.dimension:
        return source.factor / (2 * math.pi)
    if source[1:] != target[1:]:
        hint = did_you_mean(
            next((u for u in UNIT_FACTORS[unit] if u.lower() == spelling.lower()), None)
        )
        # Name the quantities that the unit measures; `g` has two.
        same = [
            QUANTITY_NAMES[unit]
            for unit in UNIT_FACTORS
            if _pint_unit_of(unit)[1:] == source[1:]
        ]
        usually = [
            QUANTITY_NAMES[unit] for unit in UNIT_FACTORS if spelling in UNIT_FACTORS[unit]
        ]
        wrong = " or ".join(dict.fromkeys([*same[:1], *usually])) or "something else"
        named = f"{QUANTITY_NAMES[unit]} [{unit}]" if unit else "a plain number"
        raise ValueError(f"`{shorten(unit_text)}` is a unit of {wrong}, not {named}{hint}")
    computed = source.factor / target.factor
    decimal = float(f"{computed:.12g}")  # removes pint's rounding of e.g. 0.0254
    return decimal if math.isclose(decimal, computed, rel_tol=1e-15) else computed


def _pint_unit_of(unit: str) -> _PintUnit:
    """Return the properties of a unit of `QUANTITY_NAMES` according to pint."""
    pint_unit = _look_up_in_pint(next(iter(UNIT_FACTORS[unit])) if unit else "m/m")
    assert pint_unit is not None
    return pint_unit


@cache
def _look_up_in_pint(spelling: str) -> _PintUnit | None:
    """Return the properties of a unit according to pint, or None if pint does not know it."""
    if not _UNIT_PATTERN.fullmatch(spelling):
        return None
    registry = _registry()
    try:
        single, double = (registry.Quantity(n, spelling).to_root_units() for n in (1.0, 2.0))
    except Exception:  # pint raises exceptions of many types
        return None
    if double.magnitude != 2 * single.magnitude:  # not proportional: degrees Celsius, decibels
        return None
    return _PintUnit(
        float(single.magnitude), str(single.dimensionality), "radian" in str(single.units)
    )


@cache
def _registry() -> Any:
    """Return the pint registry, created once."""
    import pint

    return pint.UnitRegistry()
