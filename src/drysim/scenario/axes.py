"""Swept axes: lists, ranges and samples of exact decimals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from math import lcm, nan, prod
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    NamedTuple,
    Union,
    get_args,
    get_origin,
)

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError, WithJsonSchema

from drysim.excitation.base import as_whole
from drysim.scenario.reading import (
    BY_NAME,
    LAWS,
    Model,
    Reading,
    keys_of,
    models_in,
    own_options,
    refuse,
    tag_of,
    worded,
    words_for,
)
from drysim.scenario.sampling import Drawn, Lazy
from drysim.units import Block, Misfit, Quantity, shown
from drysim.wording import listed
from drysim.yaml_document import Keys

if TYPE_CHECKING:
    from drysim.friction import Friction


# The numeric keys of a scenario: what may be swept, and in which unit.


_TABLE = str.maketrans({"²": "2", "³": "3", "·": "*"})


class Numeral(NamedTuple):
    """A key whose value is a number."""

    quantity: Quantity | None
    """What its value may be; None for a whole number."""
    annotation: Any
    """Type of its value."""
    model: Model | None
    """The block that it stands in; None in a list of numbers."""
    given: Mapping[str, Any]
    """What the scenario says in that block."""
    there: bool
    """Whether the scenario has that block."""

    @property
    def unit(self) -> str:
        """Unit of the value, as scenarios spell it."""
        return self.quantity.unit if self.quantity else ""

    @property
    def header(self) -> str:
        """Unit of the value, as tables spell it."""
        return self.unit.translate(_TABLE) or "-"

    def read(self, given: object) -> float:
        """Give the number that a value means; a ValueError is a sentence without subject."""
        if self.quantity is not None:
            return self.quantity.read(given)
        try:
            return int(TypeAdapter(self.annotation).validate_python(given))
        except ValidationError as fault:
            raise ValueError(worded(fault.errors(include_url=False)[0])) from None

    def here(self, key: str) -> float | None:
        """Give the value that the scenario itself has for a key; None where it has none."""
        name = key.rpartition(".")[2]
        field = keys_of(self.model).get(name) if self.model else None
        given = self.given.get(name, field.default if field else None)
        try:
            return None if given is None else self.read(given)
        except ValueError:  # a problem of its own
            return None


Known = Mapping[str, Numeral | None]
"""Every key of a scenario by its dotted name, the numeric ones with what is known of them."""


def numerals(model: Model, words: Mapping[str, Any]) -> Known:
    """Give every key of a scenario.

    Parameters
    ----------
    model : type
        Of the whole scenario.
    words : mapping
        What the scenario says; members of shelves are known by their tags.
    """
    return {**dict(_in_block(model, words, "", True)), "drysim": None}


def _in_block(
    model: Model, given: Mapping[str, Any], at: str, there: bool
) -> Iterator[tuple[str, Numeral | None]]:
    """Give the keys of a block and of the blocks within."""
    for name, entry in keys_of(model).items():
        annotation: Any = entry.annotation
        if entry.metadata:
            annotation = Annotated[(annotation, *entry.metadata)]
        found = _numeral(annotation, model, given, there)
        yield f"{at}{name}", found
        value = given.get(name)
        if not isinstance(value, dict | list) and value == entry.default:
            value = None  # such as `remove: nothing`, which says no more than its absence
        if found is None and not (value is None and entry.is_required()):
            yield from _within(annotation, value, f"{at}{name}")


def _within(annotation: Any, value: Any, at: str) -> Iterator[tuple[str, Numeral | None]]:
    """Give the keys in a value that is a block or a list."""
    kind, _ = _bare(annotation)
    if get_origin(kind) is tuple:
        for i, entry in enumerate(value if isinstance(value, list | tuple) else ()):
            types = get_args(kind)[0 if Ellipsis in get_args(kind) else i :]
            found = _numeral(types[0], None, {}, True) if types else None
            yield f"{at}.{i}", found
            if types and found is None:
                yield from _within(types[0], entry, f"{at}.{i}")
    elif isinstance(value, dict | None) and (models := models_in(kind)):
        given = value or {}
        if chosen := _chosen(models, given):
            yield from _in_block(chosen, given, f"{at}.", value is not None)


def _chosen(models: list[Model], given: Mapping[str, Any]) -> Model | None:
    """Give the member of a shelf that a block names, or the only model that there is."""
    for model in models:
        tag = tag_of(model)
        if tag is None or given.get(tag[0]) == tag[1]:
            return model
    return None


def _numeral(
    annotation: Any, model: Model | None, given: Mapping[str, Any], there: bool
) -> Numeral | None:
    """Give what is known of a number; None for a value that is none."""
    kind, metadata = _bare(annotation)
    quantity = next((piece for piece in metadata if isinstance(piece, Quantity)), None)
    if quantity is None and kind is not int:
        return None
    return Numeral(quantity, annotation, model, given, there)


def _bare(annotation: Any, metadata: tuple[Any, ...] = ()) -> tuple[Any, tuple[Any, ...]]:
    """Give a type without its metadata and the None that it may be; and its metadata."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _bare(parts[0], (*metadata, *parts[1:]))
    some = [part for part in parts if part is not type(None)]
    if origin in (Union, UnionType) and len(some) == 1:
        return _bare(some[0], metadata)
    return annotation, metadata


# What keeps a friction law from acting in the block of another, in sentences.


def lacking(friction: Friction, name: str) -> list[str]:
    """Give the keys, with their units, that a block must get before a law can act."""
    law, words = LAWS[name], words_for(friction, name)
    found = [
        key
        for key, field in keys_of(law).items()
        if field.is_required() and key not in words and key != BY_NAME
    ]
    either = [group[0] for group in law.one_of if not words.keys() & {*group}]
    return [f"friction.{name}.{key}{_unit(law, key)}" for key in (*either, *found)]


def _unit(law: Model, key: str) -> str:
    """Give the unit of a key in brackets; nothing for a key that is no number."""
    numeral = dict(numerals(law, {}))[key]
    return f" [{numeral.unit or '-'}]" if numeral else ""


def faults(friction: Friction | None, name: str) -> Iterator[tuple[str, str]]:
    """Give the dotted key and the sentence for everything that keeps a law from acting."""
    if friction is None or name in ("", friction.law):
        return
    if needed := lacking(friction, name):
        way = f"give them in a block `{name}` of friction"
        yield "friction", f"law {name} needs {listed(needed)}: {way}"
        return
    try:
        LAWS[name].model_validate(words_for(friction, name) | {BY_NAME: name})
    except ValidationError as fault:
        for error in fault.errors(include_url=False):
            cause = error.get("ctx", {}).get("error")
            at = [*error["loc"], *(cause.at if isinstance(cause, Misfit) else ())]
            told = str(cause) if cause is not None else worded(error)
            yield (
                key_of(friction, name, at),
                f"friction as {name}: {'.'.join(map(str, at))} {told}",
            )


def key_of(friction: Friction, name: str, at: list[str | int]) -> str:
    """Give the dotted key of a value of a law: in its own options, or shared."""
    own = bool(at) and at[0] in own_options(friction, name)
    return ".".join(map(str, ("friction", *([name] if own else []), *at)))


# Evenly spread values: each is the double next to the decimal number that is meant.


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


# Axis: a swept key with its values; and the two ways in which a file may say them.


Number = Annotated[object, WithJsonSchema({"type": ["number", "string"]})]
"""A number or a text with a unit, which the rules of its key are to read."""

ZIP, SAMPLE = "zip", "sample"
"""Keys of a sweep block that are no keys of the scenario: several walk together there."""

KEY = r"^\w+(\.[\w-]+)+$"
"""What dotted keys look like to an editor."""

AT_A_TIME = 1024
"""Points made at a time."""


@dataclass(frozen=True)
class Axis:
    """A key of the scenario that a sweep varies, and over what."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    unit: str
    """SI unit as in the header of a table, such as m/s2; `-` for a plain number."""
    values: Sequence[float]
    """In the order of the sweep, in the unit; whole numbers where the key takes no others."""
    words: Any = field(default=None, compare=False, repr=False)
    """What a scenario file says for them: a list, or a block of from, to and step or count."""
    walk: str = ""
    """What the keys share that walk together, a zip or the sample; empty for a key alone."""
    told: str = field(default="", compare=False, repr=False)
    """The values in words, where their range does not tell them."""
    place: Keys = field(default=(), compare=False, repr=False)
    """Where a file says them, where that is not the key itself."""

    def walking(self, walk: str, place: Keys) -> Axis:
        """Give the axis as one of those that walk together."""
        return replace(self, walk=walk, place=place)

    def at(self, numbers: NDArray[np.int64]) -> NDArray[Any]:
        """Give some values by their numbers."""
        if isinstance(self.values, Drawn):
            return self.values.at(numbers)
        if isinstance(self.values, Spread):
            found, back = np.unique(numbers, return_inverse=True)
            return np.array(self.values.at(found.tolist()))[back.ravel()]
        return self.column[numbers]

    @cached_property
    def column(self) -> NDArray[Any]:
        """The values as an array, where they are held."""
        return np.array(self.values)


class Range(Block):
    """Evenly spread values, both ends included."""

    low: Number = Field(alias="from")
    """First value, a number in SI or a text with a unit."""
    high: Number = Field(alias="to")
    """Last value, above the first."""
    step: Number = None
    """Distance of the values, which meets `to`."""
    count: int | None = None
    """Number of values, at least 2, in place of `step`."""
    scale: Literal["linear", "log"] | None = None
    """Whether a `count` of values is spread by difference (linear, the default) or by ratio
    (log)."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("step", "count"),)
    needs: ClassVar[dict[str, str]] = {"scale": "count"}


def walks(axes: Sequence[Axis]) -> list[tuple[Axis, ...]]:
    """Give the axes of a sweep, those that walk together side by side."""
    groups: list[tuple[Axis, ...]] = []
    for axis in axes:
        if axis.walk and groups and groups[-1][0].walk == axis.walk:
            groups[-1] = (*groups[-1], axis)
        else:
            groups.append((axis,))
    return groups


def size(axes: Sequence[Axis]) -> int:
    """Give the number of points of a sweep without making one."""
    return prod(len(group[0].values) for group in walks(axes))


def columns_of(axes: Sequence[Axis], begin: int, end: int) -> dict[str, NDArray[Any]]:
    """Give the points with numbers from `begin` to the one before `end`, a column for each key.

    The first axis varies fastest.
    """
    left = np.arange(begin, end)
    columns = {}
    for group in walks(axes):
        left, numbers = np.divmod(left, len(group[0].values))
        drawn = group[0].values
        shares = drawn.design.at(numbers) if isinstance(drawn, Drawn) else None
        for axis in group:
            if shares is not None and isinstance(axis.values, Drawn):
                columns[axis.key] = axis.values.of(shares)
            else:
                columns[axis.key] = axis.at(numbers)
    return columns


def points(axes: Sequence[Axis]) -> Iterator[dict[str, float]]:
    """Give every point of a sweep without holding them all; the first axis varies fastest."""
    if not axes:
        yield {}
    for begin in range(0, size(axes) if axes else 0, AT_A_TIME):
        columns = columns_of(axes, begin, min(begin + AT_A_TIME, size(axes)))
        for values in zip(*(column.tolist() for column in columns.values()), strict=True):
            yield dict(zip(columns, values, strict=True))


def spelled(axes: Sequence[Axis]) -> dict[str, Any]:
    """Give the words of a sweep block, every value in SI."""
    words: dict[str, Any] = {}
    for axis in axes:
        kind, _, which = axis.walk.partition(".")
        if not kind:
            words[axis.key] = axis.words
        elif kind == SAMPLE:
            head, law = axis.words
            words.setdefault(SAMPLE, {**head, "over": {}})["over"][axis.key] = law
        elif not which:
            words.setdefault(ZIP, {})[axis.key] = axis.words
        else:
            several = words.setdefault(ZIP, [])
            if len(several) == int(which):
                several.append({})
            several[-1][axis.key] = axis.words
    return words


# The values of an axis, read by the rules of its key: a list, or a range.


class Faulty(Exception):
    """A problem was noted; nothing more can be said about the axis."""


class Values:
    """What is written for one axis, and the problems of reading it."""

    def __init__(self, reading: Reading, at: Keys, numeral: Numeral) -> None:
        self.reading = reading
        self.at = at
        self.numeral = numeral

    def axis(self, key: str, given: Any) -> Axis | None:
        """Give the axis that the words mean; None when they have a problem."""
        known = len(self.reading.problems)
        try:
            values, words = self._read(given)
        except Faulty:
            return None
        if len(self.reading.problems) > known:
            return None
        return Axis(key, self.numeral.header, values, words)

    def _read(self, given: Any) -> tuple[Sequence[float], Any]:
        """Give the values, and how a file says them in SI."""
        if isinstance(given, list):
            values = self._listed(given)
            return values, list(values)
        if isinstance(given, Mapping):
            return self._spread(self.reading.block(Range, given, self.at))
        form = "a list such as `[1, 2]`, or {from, to, step}"
        raise self._fault(f"must be {form}; not {shown(given)}")

    def _fault(self, sentence: str, *inner: str | int) -> Faulty:
        """Note a problem of a value."""
        keys = (*self.at, *inner)
        refuse(self.reading, sentence, keys)
        return Faulty()

    def _one(self, given: Any, *inner: str | int) -> float:
        """Give one value, which is no number when it has a problem."""
        try:
            return self.numeral.read(given)
        except ValueError as fault:
            self._fault(str(fault), *inner)
            return nan

    def _listed(self, given: list[Any]) -> tuple[float, ...]:
        """Give the values of a list."""
        if not given:
            raise self._fault("has no values")
        values = tuple(self._one(value, i) for i, value in enumerate(given))
        seen: set[float] = set()
        for i, value in enumerate(values):
            if value in seen and value == value:
                self._fault(f"stands in the list already: {shown(given[i])}", i)
            seen.add(value)
        return values

    def _spread(self, words: Mapping[str, Any]) -> tuple[Sequence[float], Any]:
        """Give the values of a range, and the range in SI."""
        if not {"from", "to"} <= words.keys() or not {"step", "count"} & words.keys():
            raise Faulty  # noted when the block was read
        low, high = self._one(words["from"], "from"), self._one(words["to"], "to")
        if low != low or high != high:
            raise Faulty
        if low >= high:
            raise self._fault(f"must be above `from`, {shown(words['from'])}", "to")
        ends = {"from": low, "to": high}
        if "step" in words:
            step, values = self._stepped(low, high, words["step"])
            return self._whole(values, "step"), {**ends, "step": step}
        scale = words.get("scale", "linear")
        values = self._counted(low, high, words["count"], scale)
        whole = self._whole(values, "count")
        return whole, {**ends, "count": words["count"], "scale": scale}

    def _stepped(self, low: float, high: float, given: Any) -> tuple[float, Sequence[float]]:
        """Give the step and the values."""
        unit = self.numeral.unit
        try:
            step = Quantity(unit, above=0).read(given)
        except ValueError as fault:
            raise self._fault(str(fault), "step") from None
        self._refuse_too_many((high - low) / step + 1, "step")
        n, end = steps_between(low, high, step)
        if end != high:
            first, width, last = (f"{x:.12g} {unit}".strip() for x in (low, step, end))
            sentence = f"is not met by steps of {width} from {first}; the nearest is {last}"
            raise self._fault(sentence, "to")
        return step, by_step(low, high, step, n)

    def _counted(self, low: float, high: float, count: Any, scale: Any) -> Sequence[float]:
        """Give a number of values."""
        count = as_whole(count)
        if isinstance(count, bool) or not isinstance(count, int):
            raise self._fault(f"must be a whole number, not {shown(count)}", "count")
        if count < 2:
            sentence = f"must be at least 2, not {count}: both ends are included"
            raise self._fault(sentence, "count")
        if scale not in ("linear", "log"):
            raise self._fault(f"must be linear or log, not {shown(scale)}", "scale")
        if scale == "log" and low <= 0:
            raise self._fault(f"must be above 0 on a log scale, not {low:.12g}", "from")
        self._refuse_too_many(count, "count")
        return by_ratio(low, high, count) if scale == "log" else by_count(low, high, count)

    def _refuse_too_many(self, count: float, key: str) -> None:
        """Note a problem when an axis is beyond all reason."""
        if count > MOST_VALUES:
            sentence = f"asks for {count:.4g} values; an axis has {MOST_VALUES} at most"
            raise self._fault(sentence, key)

    def _whole(self, values: Sequence[float], key: str) -> Sequence[float]:
        """Give the values of a key that takes whole numbers only as such."""
        if self.numeral.quantity is not None:
            return values
        if odd := next((value for value in values if not float(value).is_integer()), None):
            raise self._fault(f"gives {odd:.6g}, and {self.at[1]} takes whole numbers", key)
        return tuple(int(value) for value in values)


# The blocks by which a file asks for a sample: points drawn over several keys at once.


OVER = {"type": "object", "minProperties": 1, "propertyNames": {"pattern": KEY}}
"""What the keys of a sample look like to an editor."""


class Draw(Block):
    """How the values of one key scatter: between two ends, or by a distribution."""

    low: Number = Field(None, alias="from")
    """Least value. A normal or lognormal distribution is cut there; without ends it is cut at
    the bounds of the key itself, as a mass is above 0."""
    high: Number = Field(None, alias="to")
    """Greatest value; as for `from`."""
    scale: Literal["linear", "log"] | None = None
    """Whether equal differences (linear, the default) or equal ratios (log) have equal chances;
    for the uniform distribution."""
    distribution: Literal["uniform", "normal", "lognormal", "triangular"] | None = None
    """Default: uniform."""
    mean: Number = None
    """Mean of a normal or lognormal distribution."""
    sd: Number = None
    """Standard deviation of a normal or lognormal distribution, in the unit of the key."""
    mode: Number = None
    """Most likely value of a triangular distribution."""

    takes: ClassVar[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
        "uniform": (("from", "to"), ("scale",)),
        "normal": (("mean", "sd"), ("from", "to")),
        "lognormal": (("mean", "sd"), ("from", "to")),
        "triangular": (("from", "mode", "to"), ()),
    }
    """What a distribution needs, and what it may have besides."""


class Sample(Block):
    """Cases that are drawn, in place of a grid: every case has its own value of every key."""

    kind: Literal["latin", "sobol", "uniform"]
    """Latin hypercube (every layer of every key has one case), Sobol sequence (scrambled; best
    with a power of two), or independent draws."""
    count: int
    """Number of cases, at least 1."""
    seed: int
    """Seed of the random numbers, a whole number; the same seed, the same cases."""
    over: Annotated[dict[str, Any], WithJsonSchema(OVER)]
    """Dotted keys of this file, each with the range or distribution that it is drawn from."""
