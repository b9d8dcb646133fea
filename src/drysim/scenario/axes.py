"""The axes of a sweep: keys of the scenario, each with the values that it takes.

An `Axis` has its values as a sequence: held (a list), evenly `Spread`, or drawn from a sample
(`Drawn` of `sampling`); the latter two make each when it is asked for, so that no sweep is ever
held as a whole. Axes multiply to a grid, of which the first varies fastest; those of a zip or a
sample walk together, as one. Spread values are the doubles next to the decimal numbers that are
meant. The blocks by which a file asks for all that stand last; `sweep` reads them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from math import lcm, prod
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import CoreSchema

from drysim.scenario.sampling import Drawn, Lazy
from drysim.units import Block
from drysim.yaml_document import Keys

SWEEP = "sweep"
"""The block; its keys are dotted keys of the scenario."""

ZIP, SAMPLE = "zip", "sample"
"""Keys of a sweep block that are no keys of the scenario: several walk together there."""

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


# The blocks of a sweep, and the type of its field.

Number = Annotated[object, WithJsonSchema({"type": ["number", "string"]})]
"""A number or a text with a unit, which the rules of its key are to read."""

KEY = r"^\w+(\.[\w-]+)+$"
"""What dotted keys look like to an editor."""


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


TOGETHER = "Keys that take their values side by side, as many each: one case for each place."


def _read_before(given: object) -> tuple[Axis, ...]:
    """Give the axes, which the loading has made: it knows every key of the scenario."""
    if not isinstance(given, tuple) or not all(isinstance(axis, Axis) for axis in given):
        raise ValueError("must be read from a file, whose keys it is about")
    return given


class _SweepSchema:
    """What the sweep block looks like to an editor."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema: dotted keys, each with a list or a range."""

        def part(model: type[Block]) -> dict[str, Any]:
            return model.__get_pydantic_json_schema__(model.__pydantic_core_schema__, handler)

        values = {"type": "array", "minItems": 1, "items": {"type": ["number", "string"]}}
        axis = {"anyOf": [values, part(Range)]}
        walk = {"type": "object", "minProperties": 2, "patternProperties": {KEY: axis}}
        walk |= {"additionalProperties": False}
        groups = {"type": "array", "minItems": 1, "items": walk}
        beside = {"description": TOGETHER, "anyOf": [walk, groups]}
        sample = part(Sample)
        sample["properties"]["over"]["additionalProperties"] = part(Draw)
        return {
            "type": "object",
            "minProperties": 1,
            "properties": {"zip": beside, "sample": sample},
            "patternProperties": {KEY: axis},
            "additionalProperties": False,
            "examples": [{"excitation.frequency": {"from": 0.5, "to": 10, "step": 0.1}}],
        }


Sweep = Annotated[
    tuple[Axis, ...],
    PlainValidator(_read_before),
    PlainSerializer(spelled),
    _SweepSchema(),
]
