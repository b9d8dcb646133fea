"""What the words and numbers of a scenario are made of: units, quantities, blocks, near names.

A number is in SI, or a text with a unit that `convert` turns into SI, rounded once. Everyday
spellings stand in a table; pint knows the rest and is imported only for one of those.
`Quantity` is what a field accepts; `Block` is what every block of a scenario shares: it is
frozen, strict and documented in itself. `closest_match`, `did_you_mean` and `format_value` are how messages speak of
what somebody wrote. No key and no file is known here.
"""

from __future__ import annotations

import ast
import inspect
import math
import operator
import re
import sys
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

if TYPE_CHECKING:
    from pydantic.json_schema import JsonSchemaValue


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
    "": "plain number",
}
"""The units of a scenario and what they measure."""

UNIT_SYNONYMS = {
    "m/s2": "m/s²",
    "m/s^2": "m/s²",
    "N*s/m": "N·s/m",
    "N*s": "N·s",
    "1/s": "Hz",
    "-": "",
    "–": "",
}

# The everyday spellings need no units library. `g` depends on what is asked for. The first of
# each row is the unit itself.
UNIT_FACTORS: dict[str, dict[str, float]] = {
    "kg": {"kg": 1, "g": 1e-3, "t": 1e3},
    "N/m": {"N/m": 1, "kN/m": 1e3, "N/mm": 1e3},
    "N·s/m": {"N*s/m": 1, "Ns/m": 1, "kg/s": 1, "kN*s/m": 1e3, "kNs/m": 1e3},
    "N": {"N": 1, "kN": 1e3},
    "N·s": {"N*s": 1, "Ns": 1, "kN*s": 1e3, "kNs": 1e3, "kg*m/s": 1},
    "m": {"m": 1, "cm": 1e-2, "mm": 1e-3},
    "m/s": {"m/s": 1, "cm/s": 1e-2, "mm/s": 1e-3},
    "m/s²": {"m/s^2": 1, "g": 9.80665, "mg": 9.80665e-3, "cm/s^2": 1e-2, "mm/s^2": 1e-3},
    "s": {"s": 1, "ms": 1e-3, "min": 60},
    "Hz": {"Hz": 1, "1/s": 1, "kHz": 1e3},
    "J": {"J": 1, "mJ": 1e-3, "kJ": 1e3},
    "rad": {"rad": 1, "deg": math.pi / 180, "°": math.pi / 180},
    "(m/s²)²/Hz": {
        "m^2/s^3": 1,
        "(m/s^2)^2/Hz": 1,
        "(m/s^2)2/Hz": 1,
        "g^2/Hz": 96.1703842225,
    },
    "m³": {"m^3": 1, "cm^3": 1e-6, "mm^3": 1e-9},
    "s/m": {"s/m": 1, "s/mm": 1e3},
    "m/s^1.75": {"m/s^1.75": 1},
    "1/m": {"1/m": 1, "cycle/m": 1, "cycles/m": 1, "rad/m": 0.5 / math.pi},
    "": {"-": 1, "–": 1, "%": 1e-2},
}


# A number with a unit in a text, converted.


NUMBER_PATTERN = re.compile(r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?|\.[0-9]++)(?:[eE][-+]?[0-9]++)?")
"""A decimal number; possessive, so that a megabyte of digits costs no more than reading it."""

MAX_UNIT_LENGTH = 60
"""Characters of a unit; what is longer is none, and is not looked into."""

_UNIT_PATTERN = re.compile(r"(?:1/)?(?:[^\W\d]\w*+(?:\^-?\d(?:\.\d\d)?)?|[*/()%°])++")
_UNIT_START = re.compile(r"\s*+(?:[^\W\d_]|[%°(–/-]|1/)")
_ASCII_CHARACTERS = str.maketrans("⁻¹²³·⋅×−", "-123***-")


class _PintUnit(NamedTuple):
    """What the units library knows of a unit: factor to base units, dimension, angle or not."""

    factor: float
    dimension: str
    angle: bool


def convert(text: str, unit: str) -> float:
    """Give the number that a text such as `25 mm` means in a unit of `QUANTITY_NAMES`.

    A number without a unit is in that unit already. The product is rounded once, so
    `35 mm` is the very double 0.035.

    Raises
    ------
    ValueError
        With a sentence, when the text is no number with a unit of the right kind.
    """
    unit, words = UNIT_SYNONYMS.get(unit, unit), text.translate(_ASCII_CHARACTERS).strip()
    if re.match(r"[-+]?[0-9]+,[0-9]", words):
        raise ValueError(f"`{shorten(text)}` has a comma; write numbers with a decimal point")
    number, rest = NUMBER_PATTERN.match(words), unit_suffix(text)
    if number is None or (rest and not _UNIT_START.match(rest)):
        kind = f"a number [{unit}] or a number with a unit" if unit else "a number"
        raise ValueError(f"must be {kind}, not `{shorten(text)}`")
    value, scale = float(number[0]), conversion_factor(rest, unit) if rest else 1.0
    if scale == 1.0 or value == 0.0 or not math.isfinite(value):
        return value
    digits = number[0] if len(number[0]) <= 300 else repr(value)  # of a longer one the double
    try:
        return float(Fraction(digits) * _exact_factor(scale))
    except OverflowError:
        return math.copysign(math.inf, value)


def unit_suffix(text: str) -> str:
    """Give the unit that a text with a number in front names; empty for none."""
    words = text.translate(_ASCII_CHARACTERS).strip()
    number = NUMBER_PATTERN.match(words)
    return words[number.end() :].strip() if number else ""


def _exact_factor(scale: float) -> Fraction:
    """Give the number that a factor stands for: 1/60 or 0.001, not the double next to it."""
    simple = Fraction(scale).limit_denominator(1_000_000)
    close = math.isclose(float(simple), scale, rel_tol=4e-16)
    return simple if close else Fraction(repr(scale))


def conversion_factor(unit_text: str, unit: str) -> float:
    """Give what one of the unit written is in a unit of `QUANTITY_NAMES`, e.g. 0.001 for mm in m.

    Raises
    ------
    ValueError
        With a sentence, when the unit is unknown or measures something else.
    """
    unit = UNIT_SYNONYMS.get(unit, unit)
    if len(unit_text) > MAX_UNIT_LENGTH:
        raise ValueError(f"unknown unit `{shorten(unit_text)}`")
    spelling = _canonical_spelling(unit_text)
    known = UNIT_FACTORS[unit].get(spelling)
    return float(known) if known is not None else _pint_factor(unit_text, spelling, unit)


def is_common_unit(unit_text: str, unit: str) -> bool:
    """Tell whether a text is a usual way to write a unit of the kind of one of `QUANTITY_NAMES`."""
    short_enough = len(unit_text) <= MAX_UNIT_LENGTH
    return (
        short_enough
        and _canonical_spelling(unit_text) in UNIT_FACTORS[UNIT_SYNONYMS.get(unit, unit)]
    )


def _canonical_spelling(unit_text: str) -> str:
    """Give a unit as `UNIT_FACTORS` spells it."""
    spelling = re.sub(r"\s*([*/])\s*", r"\1", unit_text.translate(_ASCII_CHARACTERS).strip())
    return re.sub(r"(?<=[^\W\d])(?:\^|\*\*)?(-?[0-9])", r"^\1", re.sub(r"\s+", "*", spelling))


def _pint_factor(unit_text: str, spelling: str, unit: str) -> float:
    """Give the factor by the units library, which is imported only for this."""
    found = _look_up_in_pint(spelling)
    if found is None:
        nearest = closest_match(unit_text.strip(), UNIT_FACTORS[unit]) or ""
        hint = did_you_mean(nearest.replace("^2", "²"))
        raise ValueError(f"unknown unit `{shorten(unit_text)}`{hint}")
    target = _pint_unit_of(unit)
    # Per second, a radian is 1/2π of a cycle; anywhere else but in an angle it is a slip.
    if unit == "Hz" and found.angle and found.dimension == target.dimension:
        return found.factor / (2 * math.pi)
    if found[1:] != target[1:]:
        hint = did_you_mean(
            next((u for u in UNIT_FACTORS[unit] if u.lower() == spelling.lower()), None)
        )
        # What it measures, as far as drysim has a word for it; `g` is one of two.
        same = [
            QUANTITY_NAMES[unit]
            for unit in UNIT_FACTORS
            if _pint_unit_of(unit)[1:] == found[1:]
        ]
        usually = [
            QUANTITY_NAMES[unit] for unit in UNIT_FACTORS if spelling in UNIT_FACTORS[unit]
        ]
        wrong = " or ".join(dict.fromkeys([*same[:1], *usually])) or "something else"
        named = f"{QUANTITY_NAMES[unit]} [{unit}]" if unit else "a plain number"
        raise ValueError(f"`{shorten(unit_text)}` is a unit of {wrong}, not {named}{hint}")
    computed = found.factor / target.factor
    decimal = float(f"{computed:.12g}")  # drops the library's rounding of 0.0254 and its like
    return decimal if math.isclose(decimal, computed, rel_tol=1e-15) else computed


def _pint_unit_of(unit: str) -> _PintUnit:
    """Give a unit of `QUANTITY_NAMES` as the units library knows it."""
    found = _look_up_in_pint(next(iter(UNIT_FACTORS[unit])) if unit else "m/m")
    assert found is not None
    return found


@cache
def _look_up_in_pint(spelling: str) -> _PintUnit | None:
    """Give what the units library knows, or None where it knows nothing."""
    if not _UNIT_PATTERN.fullmatch(spelling):
        return None
    registry = _registry()
    try:
        one, two = (registry.Quantity(n, spelling).to_root_units() for n in (1.0, 2.0))
    except Exception:  # it raises whatever its parser raises
        return None
    if two.magnitude != 2 * one.magnitude:  # degrees Celsius, decibels
        return None
    return _PintUnit(float(one.magnitude), str(one.dimensionality), "radian" in str(one.units))


@cache
def _registry() -> Any:
    """Give the units library, loaded once."""
    import pint

    return pint.UnitRegistry()


# What a field accepts.


MIN_MAGNITUDE, MAX_MAGNITUDE = 1e-30, 1e30
"""Sizes of a number, 0 apart, whose squares and cubes keep clear of the ends of doubles."""


@dataclass(frozen=True)
class Quantity:
    """What a field accepts: a number in `unit`, or a text with a unit, within bounds."""

    unit: str
    at_least: float | None = None
    above: float | None = None
    below: float | None = None
    at_most: float | None = None

    def read(self, value_in: object) -> float:
        """Give the number [unit]; a ValueError is a sentence without its subject."""
        if isinstance(value_in, str):
            value = convert(value_in, self.unit)
        elif isinstance(value_in, bool) or not isinstance(value_in, int | float):
            raise ValueError(f"must be a number{self._in}, not {format_value(value_in)}")
        else:
            value = (
                float(value_in) if abs(value_in) < 1e308 or value_in != value_in else math.inf
            )
        if not math.isfinite(value):
            raise ValueError(f"must be a finite number{self._in}, not {format_value(value_in)}")
        for limit, words, holds in (
            (self.at_least, "at least", operator.ge),
            (self.above, "above", operator.gt),
            (self.below, "below", operator.lt),
            (self.at_most, "at most", operator.le),
        ):
            if limit is not None and not holds(value, limit):
                bound = f"{limit:g} {self.unit}".strip()
                raise ValueError(f"must be {words} {bound}, not {format_value(value_in)}")
        if value and not MIN_MAGNITUDE <= abs(value) <= MAX_MAGNITUDE:
            span = f"{MIN_MAGNITUDE:g} and {MAX_MAGNITUDE:g} {self.unit}".strip()
            raise ValueError(
                f"must lie between {span} in size, or be 0, not {format_value(value_in)}"
            )
        return value

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest value that it accepts; infinite without a bound."""
        low, high = self.at_least, self.at_most
        if low is None:
            low = -math.inf if self.above is None else _next_accepted(self.above, math.inf)
        if high is None:
            high = math.inf if self.below is None else _next_accepted(self.below, -math.inf)
        return low, high

    @property
    def _in(self) -> str:
        return f" [{self.unit}]" if self.unit else ""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Hand `read` to pydantic."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema of the field."""
        bounds = {
            "minimum": self.at_least,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number"} | {k: v for k, v in bounds.items() if v is not None}
        return {"anyOf": [number, {"type": "string", "pattern": r"^\s*[-+−]?[.0-9]"}]}


def _next_accepted(bound: float, towards: float) -> float:
    """Give the accepted number next to a bound that is none itself."""
    return math.nextafter(bound, towards) if bound else math.copysign(MIN_MAGNITUDE, towards)


Mass = Annotated[float, Quantity("kg", above=0)]
Stiffness = Annotated[float, Quantity("N/m", at_least=0)]
Damping = Annotated[float, Quantity("N·s/m", at_least=0)]
Force = Annotated[float, Quantity("N", at_least=0)]
Length = Annotated[float, Quantity("m")]
Velocity = Annotated[float, Quantity("m/s")]
Acceleration = Annotated[float, Quantity("m/s²")]
Time = Annotated[float, Quantity("s")]
Frequency = Annotated[float, Quantity("Hz", above=0)]
Angle = Annotated[float, Quantity("rad")]
Dimensionless = Annotated[float, Quantity("")]


# What every block of a scenario shares.


class Block(BaseModel):
    """A block of a scenario: frozen, unknown keys refused, documented under its fields."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True
    )

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which exactly one is given."""
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which one at least is given."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which one may be given."""
    needs: ClassVar[dict[str, str]] = {}
    """Keys that make sense only beside another key."""

    @classmethod
    def exclusive_groups(cls) -> tuple[tuple[str, ...], ...]:
        """Give the groups of keys of which no two go together."""
        return (*cls.one_of, *cls.at_most_one_of)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Give the schema with the texts under the fields and the rules between the keys."""
        schema = handler.resolve_ref_schema(handler(core_schema))
        for name, text in field_descriptions(cls).items():
            schema["properties"][cls.model_fields[name].alias or name]["description"] = text
        rules: list[JsonSchemaValue] = [
            {"oneOf": [{"required": [key]} for key in group]} for group in cls.one_of
        ]
        rules += [{"anyOf": [{"required": [key]} for key in group]} for group in cls.any_of]
        for group in cls.at_most_one_of:
            pairs = [[a, b] for i, a in enumerate(group) for b in group[i + 1 :]]
            rules.append({"not": {"anyOf": [{"required": pair} for pair in pairs]}})
        if rules:
            schema["allOf"] = rules
        if cls.needs:
            schema["dependentRequired"] = {key: [other] for key, other in cls.needs.items()}
        return schema


def field_descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Give the text under every field of a model, by the name of the field.

    It is read from the source when somebody asks: at import it would take a third of the
    time that loading a scenario takes.
    """
    texts: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, Block) and cls.__module__ in sys.modules:
            texts |= _descriptions_in(cls.__module__).get(cls.__name__, {})
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _descriptions_in(module: str) -> dict[str, dict[str, str]]:
    """Give the texts under the annotated names of every class in a module."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # there is no source, as in a frozen program
        return {}
    texts: dict[str, dict[str, str]] = {}
    for cls in (node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)):
        under = texts[cls.name] = {}
        for field, below in pairwise(cls.body):
            match field, below:
                case (
                    ast.AnnAssign(target=ast.Name(id=name)),
                    ast.Expr(value=ast.Constant(value=str() as text)),
                ):
                    under[name] = inspect.cleandoc(text)
    return texts


class InvalidValue(ValueError):
    """A sentence about two values that do not fit; `at` is the key of the one to blame."""

    def __init__(self, sentence: str, *at: str | int) -> None:
        super().__init__(sentence)
        self.at = at


# Near names, and how a sentence shows a value.


def closest_match(name: str, candidates: Iterable[str]) -> str | None:
    """Give the candidate that was probably meant, or None.

    One slip for each three letters is forgiven: a letter wrong, missing, too many, or two
    swapped; of a single letter nothing would be left. An abbreviation of at least three letters
    is understood.
    """
    word, best = name.lower().replace("-", "_"), None
    for candidate in candidates:
        other = candidate.lower().replace("-", "_")
        distance = _edit_distance(word, other)
        if min(len(word), len(other)) >= 3 and (
            other.startswith(word) or word.startswith(other)
        ):
            distance = min(distance, 1)
        rank = (distance, abs(len(other) - len(word)), other[:1] != word[:1], candidate)
        forgiven = min(max(1, len(word) // 3), len(word) - 1)
        if distance <= forgiven and (best is None or rank < best):
            best = rank
    return best[-1] if best else None


def did_you_mean(nearest: str | None) -> str:
    """Ask behind a sentence for what was probably meant; nothing where none comes near."""
    return f"; did you mean `{nearest}`?" if nearest else ""


def name_hint(name: str, known: Collection[str]) -> str:
    """Ask for the known name that was probably meant, or else list them all."""
    return did_you_mean(closest_match(name, known)) or f"; known are {', '.join(known)}"


def _edit_distance(a: str, b: str) -> int:
    """Give how many letters to change, drop, add or swap with their neighbour."""
    if abs(len(a) - len(b)) > 4 or len(a) > 60:
        return 99
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a):
        last, before, row = before, row, [i + 1]
        for j, y in enumerate(b):
            row.append(min(before[j] + (x != y), before[j + 1] + 1, row[j] + 1))
            if i and j and x == b[j - 1] and y == a[i - 1]:
                row[-1] = min(row[-1], last[j - 1] + 1)
    return row[-1]


def format_value(value: object) -> str:
    """Give a value as a sentence names it: words in backticks, blocks by their kind."""
    match value:
        case None:
            return "nothing"
        case bool():
            return "true" if value else "false"
        case float():
            return repr(value).removesuffix(".0")
        case str():
            return f"`{shorten(value)}`"
        case dict():
            return "a block of keys"
        case list() | tuple():
            return "a list"
        case int() if abs(value) >= 10**1000:  # Python prints no such
            return f"a whole number of {value.bit_length()} bits"
    return shorten(str(value))


def shorten(text: str, most: int = 40) -> str:
    """Give the text in one line of at most so many characters."""
    line = " ".join(text[: 8 * most].split())
    return line if len(line) <= most and len(text) <= 8 * most else line[: most - 1] + "…"
