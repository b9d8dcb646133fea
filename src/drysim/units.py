"""Units, quantities with units, blocks of a scenario, and suggestions for misspelled names.

`convert` turns a number, or text such as `25 mm`, into SI and rounds once. Common unit
spellings are in a table; pint resolves the others and is imported only for them, because a dry
run takes 1.6 times as long with it. `Quantity` is the pydantic type of a field with a unit.
`Block` is the base class of every block of a scenario: frozen, strict, and documented under its
fields. `closest_match`, `did_you_mean` and `format_value` serve error messages.
"""

import ast
import inspect
import math
import operator
import re
import sys
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Tag,
)
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
    digits = number[0] if len(number[0]) <= 300 else repr(value)  # bounds the cost of Fraction
    try:
        return float(Fraction(digits) * _exact_factor(scale))
    except OverflowError:
        return math.copysign(math.inf, value)


def unit_suffix(text: str) -> str:
    """Return the unit that follows the number in a text; empty if there is none."""
    words = text.translate(_ASCII_CHARACTERS).strip()
    number = NUMBER_PATTERN.match(words)
    return words[number.end() :].strip() if number else ""


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
    known = UNIT_FACTORS[unit].get(spelling)
    return float(known) if known is not None else _pint_factor(unit_text, spelling, unit)


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


def _canonical_spelling(unit_text: str) -> str:
    """Return a unit in the spelling of `UNIT_FACTORS`."""
    spelling = re.sub(
        r"\s*([*/])\s*", r"\1", unit_text.translate(_ASCII_CHARACTERS | _MICRO).strip()
    )
    return re.sub(r"(?<=[^\W\d])(?:\^|\*\*)?(-?[0-9])", r"^\1", re.sub(r"\s+", "*", spelling))


def _pint_factor(unit_text: str, spelling: str, unit: str) -> float:
    """Return the conversion factor of an uncommon unit from pint."""
    found = _look_up_in_pint(spelling)
    if found is None:
        nearest = closest_match(unit_text.strip(), UNIT_FACTORS[unit]) or ""
        hint = did_you_mean(nearest.replace("^2", "²"))
        raise ValueError(f"unknown unit `{shorten(unit_text)}`{hint}")
    target = _pint_unit_of(unit)
    # rad/s is a frequency of 1/2π Hz; in other units that are no angles a radian is an error.
    if unit == "Hz" and found.angle and found.dimension == target.dimension:
        return found.factor / (2 * math.pi)
    if found[1:] != target[1:]:
        hint = did_you_mean(
            next((u for u in UNIT_FACTORS[unit] if u.lower() == spelling.lower()), None)
        )
        # Name the quantities that the unit measures; `g` has two.
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
    decimal = float(f"{computed:.12g}")  # removes pint's rounding of e.g. 0.0254
    return decimal if math.isclose(decimal, computed, rel_tol=1e-15) else computed


def _pint_unit_of(unit: str) -> _PintUnit:
    """Return the properties of a unit of `QUANTITY_NAMES` according to pint."""
    found = _look_up_in_pint(next(iter(UNIT_FACTORS[unit])) if unit else "m/m")
    assert found is not None
    return found


@cache
def _look_up_in_pint(spelling: str) -> _PintUnit | None:
    """Return the properties of a unit according to pint, or None if pint does not know it."""
    if not _UNIT_PATTERN.fullmatch(spelling):
        return None
    registry = _registry()
    try:
        one, two = (registry.Quantity(n, spelling).to_root_units() for n in (1.0, 2.0))
    except Exception:  # pint raises exceptions of many types
        return None
    if two.magnitude != 2 * one.magnitude:  # not proportional: degrees Celsius, decibels
        return None
    return _PintUnit(float(one.magnitude), str(one.dimensionality), "radian" in str(one.units))


@cache
def _registry() -> Any:
    """Return the pint registry, created once."""
    import pint

    return pint.UnitRegistry()


# Fields with units.


MIN_MAGNITUDE, MAX_MAGNITUDE = 1e-30, 1e30
"""Bounds of the magnitude of a nonzero number: squares and cubes stay within double range."""


@dataclass(frozen=True)
class Quantity:
    """Pydantic type of a number with a unit, within bounds.

    Accepts a number in `unit`, or text with a unit.
    """

    unit: str
    """A key of `QUANTITY_NAMES`."""
    at_least: float | None = None
    above: float | None = None
    below: float | None = None
    at_most: float | None = None
    """Bounds [unit]; `above` and `below` exclude the bound itself."""

    def read(self, value_in: object) -> float:
        """Return the validated number [unit].

        Raises
        ------
        ValueError
            With a sentence that lacks its subject, e.g. `must be above 0 kg, not -1`.
        """
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
                f"must be 0 or between {span} in magnitude, not {format_value(value_in)}"
            )
        return value

    @property
    def ends(self) -> tuple[float, float]:
        """The smallest and the largest accepted value; infinite where there is no bound."""
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
        """Validate with `read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema of the field."""
        bounds = {
            "minimum": self.at_least,
            "exclusiveMinimum": self.above,
            "exclusiveMaximum": self.below,
            "maximum": self.at_most,
        }
        number = {"type": "number"} | {k: v for k, v in bounds.items() if v is not None}
        return {"anyOf": [number, {"type": "string", "pattern": r"^\s*[-+−]?[.0-9]"}]}


def _next_accepted(bound: float, towards: float) -> float:
    """Return the accepted number next to an excluded bound."""
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


# Blocks of a scenario.


class Block(BaseModel):
    """Base class of the blocks of a scenario.

    Blocks are frozen, reject unknown keys, and take the description of each field from the
    string below it. Modules of blocks have no `from __future__ import annotations`: pydantic
    evaluates annotations that are text for each class again, a tenth of the time of `validate`.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True
    )

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which exactly one must be set."""
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which at least one must be set."""
    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = ()
    """Groups of keys of which at most one may be set."""
    needs: ClassVar[dict[str, str]] = {}
    """Keys that require another key."""

    @classmethod
    def exclusive_groups(cls) -> tuple[tuple[str, ...], ...]:
        """Return the groups of mutually exclusive keys."""
        return (*cls.one_of, *cls.at_most_one_of)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> "JsonSchemaValue":
        """Return the JSON schema with field descriptions and the constraints between keys."""
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


class ByDirection(Block):
    """Values [unit] that differ between extension (v_r > 0) and compression (v_r < 0)."""

    extension: Any
    compression: Any


class ForceByDirection(ByDirection):
    """Friction force that depends on the direction of motion."""

    extension: Force
    """Force [N] against v_r > 0."""
    compression: Force
    """Force [N] against v_r < 0."""


class DampingByDirection(ByDirection):
    """Damping that depends on the direction of motion, as of a shock absorber."""

    extension: Damping
    """Damping [N·s/m] of v_r > 0."""
    compression: Damping
    """Damping [N·s/m] of v_r < 0."""


def _plain_or_block(value: object) -> str:
    """Return the tag of the type that validates a value: a plain value, or a block."""
    return "block" if isinstance(value, Mapping | Block) else "plain"


Plain = TypeVar("Plain")
Nested = TypeVar("Nested")

PlainOrBlock = Annotated[
    Annotated[Plain, Tag("plain")] | Annotated[Nested, Tag("block")],
    Discriminator(_plain_or_block),
]
"""A plain value, or a block in its place; messages concern the one that is written."""

DirectedForce = PlainOrBlock[Force, ForceByDirection]
"""One force [N], or one per direction of motion."""

DirectedDamping = PlainOrBlock[Damping, DampingByDirection]
"""One damping [N·s/m], or one per direction of motion."""


def depends_on_direction(value: Any) -> bool:
    """Return whether a value differs between the directions; columns of many cases may."""
    if not isinstance(value, ByDirection):
        return False
    one, other = by_direction(value)
    return not (isinstance(one, float) and isinstance(other, float) and one == other)


def by_direction(value: Any) -> tuple[Any, Any]:
    """Return a value for extension and for compression."""
    if isinstance(value, ByDirection):
        return value.extension, value.compression
    return value, value


def mean_of_directions(value: Any) -> Any:
    """Return the mean of a value that may depend on the direction of motion."""
    if isinstance(value, ByDirection):
        return 0.5 * (value.extension + value.compression)
    return value


def field_descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Return the description of every field of a model, by field name.

    Notes
    -----
    Descriptions are parsed from the source on demand. Doing so at import would take a third of
    the time needed to load a scenario.
    """
    texts: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, Block) and cls.__module__ in sys.modules:
            texts |= _descriptions_in(cls.__module__).get(cls.__name__, {})
    return {name: text for name, text in texts.items() if name in model.model_fields}


@cache
def _descriptions_in(module: str) -> dict[str, dict[str, str]]:
    """Return the strings below the annotated names of every class in a module."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # no source, e.g. in a frozen program
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
    """An error that concerns two values which contradict each other.

    `at` is the path of the key to blame, relative to the block.
    """

    def __init__(self, sentence: str, *at: str | int) -> None:
        super().__init__(sentence)
        self.at = at


# Suggestions for misspelled names; values in messages.


def closest_match(name: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate closest to a misspelled name, or None.

    It has the smallest edit distance, which is at most one third of the length of the name.
    Abbreviations of at least three letters match, too.

    `difflib.get_close_matches` finds as many misspelled keys of a scenario, but suggests a key
    for three times as many words that are none.
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
    """Return the suffix `; did you mean …?` of an error message; empty without a suggestion."""
    return f"; did you mean `{nearest}`?" if nearest else ""


def name_hint(name: str, known: Collection[str]) -> str:
    """Return the suffix that suggests the closest known name, or else lists all of them."""
    return did_you_mean(closest_match(name, known)) or f"; use one of {', '.join(known)}"


def _edit_distance(a: str, b: str) -> int:
    """Return the edit distance: substitutions, insertions, deletions and adjacent swaps."""
    if abs(len(a) - len(b)) > 4 or len(a) > 60:
        return 99
    # Rows of the dynamic programme: `row[j]` is the distance of a[: i + 1] to b[:j].
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
    """Return a value as error messages show it: text in backticks, blocks and lists by type."""
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
        case int() if abs(value) >= 10**1000:  # exceeds Python's limit for int to str
            return f"a whole number of {value.bit_length()} bits"
    return shorten(str(value))


def shorten(text: str, most: int = 40) -> str:
    """Return the text on one line, cut to at most `most` characters."""
    line = " ".join(text[: 8 * most].split())
    return line if len(line) <= most and len(text) <= 8 * most else line[: most - 1] + "…"
