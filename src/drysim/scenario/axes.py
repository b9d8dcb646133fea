"""Axes of a sweep: keys of the scenario with the values they take.

The values of an `Axis` are a sequence: stored (a list), `EvenlySpaced`, or random
(`SampledValues`); the latter two compute values on demand.
Axes form a grid whose first axis varies fastest; the axes of a zip or a sample vary together as
one group. Evenly spaced values are the doubles closest to the decimal numbers meant. The models
of the sweep block, which `sweep` reads, are at the end.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from math import inf, lcm, log, prod
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

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

from drysim.block import Block
from drysim.core.model import Floats
from drysim.scenario.sampling import LazySequence, SampledValues, Uniform
from drysim.yaml_document import KeyPath

SWEEP_KEY = "sweep"
"""Key of the sweep block; the keys in it are dotted keys of the scenario."""

FREQUENCY_KEY = "excitation.frequency"
"""Key of the abscissa of a transmissibility."""

FILE_KEY = "excitation.file"
"""Key of the records of a sweep; its values are file names."""

DIRECTION_KEY = "direction"
"""Key of the sweep block by which each case starts where the previous one ended. It is an axis
as well, the last one: its values are the directions in which the first axis is run through."""

UP, DOWN, BOTH = "up", "down", "both"
"""Directions of a sweep: by increasing value of the first axis, by decreasing value, or one
after the other, each from the scenario's start."""

EXTREME_KEY, LEAST, GREATEST = "extreme", "least", "greatest"
"""Key and values of the last axis of a table whose cases cover an interval of the static ratio:
the least and the greatest value of each metric."""

TEXT_KEYS = (FILE_KEY, DIRECTION_KEY, EXTREME_KEY)
"""Keys of axes whose values are text."""

ZIP_KEY, SAMPLE_KEY = "zip", "sample"
"""Keys of the sweep block that contain groups of keys varying together."""

FROM_FIT_KEY = "from_fit"
"""Key of a sample, and of the conditions of a design, whose value is the folder of a fit."""

SRS_KEY, NATURAL_FREQUENCY_KEY = "srs", "oscillator.natural_frequency"
"""Key of the sweep block for a shock response spectrum, and the key that it varies."""

POINTS_PER_BLOCK = 1024
"""Points computed at a time."""


class KeyRange(NamedTuple):
    """A key and the range in which it varies continuously."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    unit: str
    """SI unit as in table headers, such as m/s2; `-` for a dimensionless value."""
    low: float
    high: float
    """Ends of the range in SI."""
    is_log: bool = False
    """Whether equal shares of the range have equal ratios."""
    bounds: tuple[float, float] = (-inf, inf)
    """Least and greatest value that the key accepts, in SI."""

    def value(self, share: Floats | float) -> Floats:
        """Return the value at a share of the range, from 0 to 1; below and above it, too."""
        return Uniform(self.low, self.high, self.is_log).quantile(np.asarray(share))

    def share(self, value: float) -> float:
        """Return the share of the range at a value."""
        if self.is_log:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    @property
    def description(self) -> str:
        """The range as text."""
        return Uniform(self.low, self.high, self.is_log).describe(self.unit)

    @property
    def entry(self) -> dict[str, Any]:
        """The range as a file writes it, in SI."""
        scale = "log" if self.is_log else "linear"
        return {"from": self.low, "to": self.high, "scale": scale}


@dataclass(frozen=True)
class Axis:
    """A swept key and its values."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    unit: str
    """SI unit as in table headers, such as m/s2; `-` for a dimensionless value."""
    values: Sequence[Any]
    """Values in sweep order and in SI; integers for integer keys, text for files."""
    entry: Any = field(default=None, compare=False, repr=False)
    """The values as a scenario file writes them: a list, or from, to and step or count."""
    group: str = ""
    """Identifier of the zip, sample, fit or `srs` it belongs to; empty for a single axis."""
    description: str = field(default="", compare=False, repr=False)
    """Text for the values where their range is not enough, as for distributions."""
    location: KeyPath = field(default=(), compare=False, repr=False)
    """Keys where the file defines the values, if not at `sweep.<key>`."""
    bounds: tuple[float, float] = field(default=(-inf, inf), compare=False, repr=False)
    """Least and greatest value that the key accepts, in SI."""
    source: Path | None = field(default=None, compare=False, repr=False)
    """Folder of the fit whose draws the values are, or their table; None for other values."""

    @property
    def is_random(self) -> bool:
        """Whether the values have no order, as those of a sample."""
        return self.group == SAMPLE_KEY or self.source is not None

    @property
    def range(self) -> KeyRange:
        """Range of its values, which are numbers; a list has a linear one."""
        if isinstance(self.entry, Mapping):
            ends = self.values[0], self.values[-1]
            is_log = self.entry.get("scale") == "log"
            return KeyRange(self.key, self.unit, *ends, is_log, self.bounds)
        ends = min(self.values), max(self.values)
        return KeyRange(self.key, self.unit, *ends, bounds=self.bounds)

    def take(self, numbers: NDArray[np.int64]) -> NDArray[Any]:
        """Return values by index."""
        if isinstance(self.values, EvenlySpaced):
            return self.values.take(numbers)
        return self.column[numbers]

    @cached_property
    def column(self) -> NDArray[Any]:
        """Stored values as an array."""
        return np.array(self.values)


def axis_groups(axes: Sequence[Axis]) -> list[tuple[Axis, ...]]:
    """Return the axes of a sweep, grouped by what varies together."""
    groups: list[tuple[Axis, ...]] = []
    for axis in axes:
        if axis.group and groups and groups[-1][0].group == axis.group:
            groups[-1] = (*groups[-1], axis)
        else:
            groups.append((axis,))
    return groups


def are_draws(axes: Sequence[Axis]) -> bool:
    """Return whether points are the draws of a fit, and differ in nothing else."""
    return bool(axes) and all(axis.source is not None for axis in axes)


def has_shock_spectrum(axes: Sequence[Axis]) -> bool:
    """Return whether a sweep is a shock response spectrum."""
    return any(axis.group == SRS_KEY for axis in axes)


def count_points(axes: Sequence[Axis]) -> int:
    """Return the number of points of a sweep without computing them."""
    return prod(len(group[0].values) for group in axis_groups(axes))


def chain_length(axes: Sequence[Axis]) -> int:
    """Return the number of consecutive cases of which each starts where another one ended.

    These are the cases along the first axis; 0 if every case starts from the scenario's start.
    """
    chained = any(axis.key == DIRECTION_KEY for axis in axes)
    return len(axes[0].values) if chained else 0


def chain_order(axes: Sequence[Axis], points: Mapping[str, NDArray[Any]]) -> list[int]:
    """Return the order in which the cases of a chain are solved.

    `points` are the columns of its points, as from `point_columns`.
    """
    order: list[int] = np.argsort(points[axes[0].key], kind="stable").tolist()
    return order if points[DIRECTION_KEY][0] == UP else order[::-1]


def point_columns(axes: Sequence[Axis], begin: int, end: int) -> dict[str, NDArray[Any]]:
    """Return the points `begin` to `end` - 1 as one column per key.

    The first axis varies fastest.
    """
    left = np.arange(begin, end)
    columns = {}
    for group in axis_groups(axes):
        left, numbers = np.divmod(left, len(group[0].values))
        drawn = group[0].values
        shares = drawn.design.take(numbers) if isinstance(drawn, SampledValues) else None
        for axis in group:
            if shares is not None and isinstance(axis.values, SampledValues):
                columns[axis.key] = axis.values.of(shares)
            else:
                columns[axis.key] = axis.take(numbers)
    return columns


def points_in(columns: Mapping[str, NDArray[Any]]) -> Iterator[dict[str, Any]]:
    """Yield the points of columns as Python numbers and text; without columns a single one."""
    if not columns:
        yield {}
    for values in zip(*(column.tolist() for column in columns.values()), strict=True):
        yield dict(zip(columns, values, strict=True))


def iter_points(axes: Sequence[Axis]) -> Iterator[dict[str, Any]]:
    """Yield the points of a sweep; the first axis varies fastest."""
    for begin in range(0, count_points(axes), POINTS_PER_BLOCK):
        end = min(begin + POINTS_PER_BLOCK, count_points(axes))
        yield from points_in(point_columns(axes, begin, end))


def sweep_to_dict(axes: Sequence[Axis]) -> dict[str, Any]:
    """Return the sweep block as plain values in SI."""
    block: dict[str, Any] = {}
    for axis in axes:
        kind, _, which = axis.group.partition(".")
        if not kind:
            block[axis.key] = axis.entry
        elif kind == SAMPLE_KEY:
            head, law = axis.entry
            sample = block.setdefault(SAMPLE_KEY, {})
            sample |= head
            if law is not None:
                sample.setdefault("over", {})[axis.key] = law
        elif kind == FROM_FIT_KEY:
            block |= axis.entry
        elif kind == SRS_KEY:
            block[SRS_KEY] = axis.entry
        elif not which:
            block.setdefault(ZIP_KEY, {})[axis.key] = axis.entry
        else:
            several = block.setdefault(ZIP_KEY, [])
            if len(several) == int(which):
                several.append({})
            several[-1][axis.key] = axis.entry
    return block


# Evenly spaced values: each is the double closest to the decimal number meant

MAX_AXIS_VALUES = 10_000_000
"""Maximum number of values of an axis; more are probably a step in the wrong unit."""

MAX_SAMPLE_POINTS = 10**12
"""Maximum number of random points whose values follow from their numbers."""

MAX_STORED_VALUES = 10_000
"""Axes with at most this many values store them; longer ones compute them on demand."""

STEP_TOLERANCE = Fraction(1, 10**9)
"""Tolerance, in steps, within which the end of a range is reached: 30 deg in rad is not a
decimal number."""

EXACT_INTEGERS = 2**53
"""Integers below this are doubles: the quotient of two of them is the closest double."""

_DECIMAL_CONTEXT = Context(prec=25)
"""Precision at which log-spaced values round to the closest double: 0.1, 1, 10, 100."""


def nearest_steps(low: float, high: float, step: float) -> tuple[int, float]:
    """Return the number of steps closest to the end of a range, and the value reached.

    The number is at least 1. The value is `high` itself if it is reached.
    """
    first, last, width = _as_fraction(low), _as_fraction(high), _as_fraction(step)
    n = max(1, round((last - first) / width))
    end = first + n * width
    return n, high if abs(end - last) <= STEP_TOLERANCE * width else float(end)


@dataclass(frozen=True)
class EvenlySpaced(LazySequence[float]):
    """Evenly spaced values computed on demand: (first + i width)/common.

    On a log scale value i is low (high/low)^(i/n).
    """

    low: float
    high: float
    steps: int
    fraction: tuple[int, int, int] | None

    def __len__(self) -> int:
        """Return the number of values."""
        return self.steps + 1

    def item(self, number: int) -> float:
        """Return a value by index."""
        if number in (0, self.steps):
            return self.high if number else self.low
        if self.fraction is not None:
            first, width, common = self.fraction
            return (first + number * width) / common
        low, ratio = self._logarithms
        return float(_DECIMAL_CONTEXT.exp(_DECIMAL_CONTEXT.fma(ratio, number, low)))

    def take(self, numbers: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return values by index."""
        if self.fraction is not None:
            first, width, common = self.fraction
            if max(abs(first), abs(first + width * self.steps), common) < EXACT_INTEGERS:
                inner = (first + width * numbers) / common
                ends = [numbers == 0, numbers == self.steps]
                return np.select(ends, [self.low, self.high], inner)
        distinct, back = np.unique(numbers, return_inverse=True)
        return np.array([self.item(i) for i in distinct.tolist()])[back.ravel()]

    @cached_property
    def _logarithms(self) -> tuple[Decimal, Decimal]:
        """Logarithms of the first value and of the ratio of two neighbours."""
        low, high = (_DECIMAL_CONTEXT.ln(Decimal(repr(end))) for end in (self.low, self.high))
        return low, _DECIMAL_CONTEXT.divide(high - low, self.steps)


def decimal_arange(low: float, high: float, step: float, n: int) -> Sequence[float]:
    """Return low, low + step, ..., high for n steps."""
    first, width = _as_fraction(low), _as_fraction(step)
    common = lcm(first.denominator, width.denominator)
    return _store_if_small(
        EvenlySpaced(low, high, n, (int(first * common), int(width * common), common))
    )


def decimal_linspace(low: float, high: float, count: int) -> Sequence[float]:
    """Return `count` values from low to high with equal differences."""
    first, last, n = _as_fraction(low), _as_fraction(high), count - 1
    common = lcm(first.denominator, last.denominator)
    a, b = int(first * common), int(last * common)
    return _store_if_small(EvenlySpaced(low, high, n, (a * n, b - a, common * n)))


def decimal_geomspace(low: float, high: float, count: int) -> Sequence[float]:
    """Return `count` values from low to high with equal ratios."""
    return _store_if_small(EvenlySpaced(low, high, count - 1, None))


def _store_if_small(values: EvenlySpaced) -> Sequence[float]:
    """Return a tuple if there are few values."""
    return tuple(values) if len(values) <= MAX_STORED_VALUES else values


def _as_fraction(value: float) -> Fraction:
    """Return the decimal number a float is written as."""
    return Fraction(repr(value))


# Models of the sweep block, and the type of the field

NumberOrText = Annotated[object, WithJsonSchema({"type": ["number", "string"]})]
"""Number, or text with a unit; read according to the swept key."""

KEY_PATTERN = r"^\w+(\.[\w-]+)+$"
"""Pattern of dotted keys in the schema."""


class Range(Block):
    """Evenly spaced values, both ends included."""

    low: NumberOrText = Field(alias="from")
    """First value, a number in SI or text with a unit."""
    high: NumberOrText = Field(alias="to")
    """Last value, above the first."""
    step: NumberOrText = None
    """Difference between values; a whole number of steps reaches `to`."""
    count: int | None = None
    """Number of values, at least 2, instead of `step`."""
    per_octave: int | None = None
    """Least number of values per octave, with equal ratios, instead of `step`."""
    scale: Literal["linear", "log"] | None = None
    """Whether `count` values have equal differences (linear, the default) or equal ratios
    (log)."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("step", "count", "per_octave"),)
    needs: ClassVar[dict[str, str]] = {"scale": "count"}


def inline_schema(model: type[Block], handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """Return the JSON schema of a block, to be used within a hand-written one."""
    return model.__get_pydantic_json_schema__(model.__pydantic_core_schema__, handler)


@dataclass(frozen=True)
class DottedKeysSchema:
    """JSON schema of a block whose keys are dotted keys of the scenario, each with a block."""

    model: type[Block]
    """Model of the block of each key."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema."""
        return {
            "type": "object",
            "minProperties": 1,
            "propertyNames": {"pattern": KEY_PATTERN},
            "additionalProperties": inline_schema(self.model, handler),
        }


VALUES_SCHEMA = {"type": "array", "minItems": 1, "items": {"type": ["number", "string"]}}
"""Schema of a list of values."""


class Draw(Block):
    """Distribution of the values of a key: a range, or a named distribution."""

    low: NumberOrText = Field(None, alias="from")
    """Lower end. A normal or lognormal distribution is truncated there; by default at the
    bounds of the key itself, such as 0 for a mass."""
    high: NumberOrText = Field(None, alias="to")
    """Upper end; as for `from`."""
    scale: Literal["linear", "log"] | None = None
    """Whether the value (linear, the default) or its logarithm (log) is uniformly distributed.
    """
    distribution: Literal["uniform", "normal", "lognormal", "triangular"] | None = None
    """Type of distribution; default: uniform."""
    mean: NumberOrText = None
    """Mean of a normal or lognormal distribution."""
    sd: NumberOrText = None
    """Standard deviation of a normal or lognormal distribution, in the unit of the key."""
    mode: NumberOrText = None
    """Mode of a triangular distribution."""

    parameters: ClassVar[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
        "uniform": (("from", "to"), ("scale",)),
        "normal": (("mean", "sd"), ("from", "to")),
        "lognormal": (("mean", "sd"), ("from", "to")),
        "triangular": (("from", "mode", "to"), ()),
    }
    """Required and optional parameters of each distribution."""


SampleKind = Literal["latin", "sobol", "uniform"]
"""Kinds of random points."""


class Sample(Block):
    """Random cases instead of a grid: every case has its own value of every key."""

    kind: SampleKind | None = None
    """Latin hypercube (each layer of each key has one case), Sobol sequence (scrambled; best
    with a power of two), or independent random values; required with `over`."""
    count: int | None = None
    """Number of cases, at least 1; required with `over`, by default all draws of a fit."""
    seed: int | None = None
    """Seed of the random numbers, an integer; the same seed gives the same cases; required
    with `over`."""
    over: Annotated[dict[str, Any], DottedKeysSchema(Draw)] | None = None
    """Dotted keys of this file, each with its range or distribution."""
    from_fit: str | None = None
    """Folder of a `drysim fit`, relative to this file: each case has a joint draw of the fitted
    values. Keys that are varied elsewhere in the block keep the values given there."""

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("over", "from_fit"),)
    needs: ClassVar[dict[str, str]] = {"kind": "over", "seed": "over"}
    with_over: ClassVar[tuple[str, ...]] = ("kind", "count", "seed")
    """Keys that `over` requires."""


DIRECTION_DESCRIPTION = (
    "Start each case along the first key where the previous one ended, by increasing or "
    "decreasing value; default: each case starts from `start`."
)
FILES_DESCRIPTION = "Records to compare: a list of files, or a pattern such as `runs/*.csv`."
SRS_DESCRIPTION = (
    "Shock response spectrum: values of `oscillator.natural_frequency` as a list or a range, "
    "whose `count` values have equal ratios by default; needs a `shock` or a `record`."
)
ZIP_DESCRIPTION = "Keys that vary together, with equally many values: one case per position."


def _require_axes(value: object) -> tuple[Axis, ...]:
    """Return the axes that `load` has read; reject anything else."""
    if not isinstance(value, tuple) or not all(isinstance(axis, Axis) for axis in value):
        raise ValueError("must be read from a scenario file")
    return value


class _SweepSchema:
    """JSON schema of the sweep block."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema: dotted keys, each with a list or a range."""
        axis = {"anyOf": [VALUES_SCHEMA, inline_schema(Range, handler)]}
        group = {"type": "object", "minProperties": 2, "patternProperties": {KEY_PATTERN: axis}}
        group |= {"additionalProperties": False}
        groups = {"type": "array", "minItems": 1, "items": group}
        sample = inline_schema(Sample, handler)
        sample["dependentRequired"] |= {"over": [*Sample.with_over]}
        zip_schema = {"description": ZIP_DESCRIPTION, "anyOf": [group, groups]}
        return {
            "type": "object",
            "minProperties": 1,
            "properties": {
                "zip": zip_schema,
                "sample": sample,
                SRS_KEY: {"description": SRS_DESCRIPTION, **axis},
                DIRECTION_KEY: {
                    "description": DIRECTION_DESCRIPTION,
                    "enum": [UP, DOWN, BOTH, None],
                },
                FILE_KEY: {
                    "description": FILES_DESCRIPTION,
                    "anyOf": [
                        {"type": "array", "minItems": 1, "items": {"type": "string"}},
                        {"type": "string"},
                    ],
                },
            },
            "patternProperties": {KEY_PATTERN: axis},
            "additionalProperties": False,
            "examples": [{"excitation.frequency": {"from": 0.5, "to": 10, "step": 0.1}}],
        }


Sweep = Annotated[
    tuple[Axis, ...],
    PlainValidator(_require_axes),
    PlainSerializer(sweep_to_dict),
    _SweepSchema(),
]
