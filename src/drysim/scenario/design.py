"""The design block of a scenario: keys to choose, objectives, limits and conditions.

`read_design` reads what depends on other keys of the file: the bounds of the varied keys, and
the conditions under which every design is judged, which are axes as in a sweep.
"""

from typing import Annotated, Literal, NamedTuple, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    WithJsonSchema,
    model_validator,
)

from drysim.block import Block, InvalidValue
from drysim.metrics.checks import Check, known_metric
from drysim.metrics.table import METRICS_BY_NAME
from drysim.scenario.axes import (
    FILE_KEY,
    FILES_DESCRIPTION,
    FROM_FIT_KEY,
    KEY_PATTERN,
    VALUES_SCHEMA,
    Axis,
    DottedKeysSchema,
    KeyRange,
    NumberOrText,
    sweep_to_dict,
)
from drysim.scenario.blocks import SEED_KEY, Checks

DESIGN_KEY = "design"
"""Key of the block."""

VARY_PATH, OVER_PATH = f"{DESIGN_KEY}.vary", f"{DESIGN_KEY}.over"
"""Paths of the blocks whose keys are dotted keys of the scenario."""

MAX_KEYS = 8
"""Largest number of varied keys; the number of evaluations grows steeply with it."""

MAX_EVALUATIONS = 2000
"""Largest number of evaluated designs; the surrogate takes time of its third power."""

DEFAULT_EVALUATIONS = 400

WORST, MEAN = "worst", "mean"
"""How the values under several conditions become one."""

TAKE_KEY = "take"

DRAWS_OF_DESIGN = 16
"""Number of draws of a fit that are conditions, by default: each design is solved under all."""


class VaryRange(Block):
    """Bounds between which a key is chosen."""

    low: NumberOrText = Field(alias="from")
    """Lower bound, a number in SI or text with a unit."""
    high: NumberOrText = Field(alias="to")
    """Upper bound, above the lower one."""
    scale: Literal["linear", "log"] | None = None
    """Scale on which designs are spread, linear by default; log suits bounds that differ by a
    factor of 10 or more."""


class Conditions(NamedTuple):
    """Conditions under which every design is judged."""

    axes: tuple[Axis, ...] = ()
    """Keys with their values; every combination is a condition."""
    take: str = WORST
    """`worst` or `mean`: how the objectives become one. Limits hold under every condition."""


def _require_vary(value: object) -> tuple[KeyRange, ...]:
    """Return the varied keys that `read_design` has read; reject anything else."""
    if not isinstance(value, tuple) or not value:
        raise ValueError("must be keys such as `oscillator.damping: {from: 100, to: 3000}`")
    return value


def _require_conditions(value: object) -> Conditions:
    """Return the conditions that `read_design` has read; reject anything else."""
    if not isinstance(value, Conditions):
        raise ValueError("must be keys with their values, such as `oscillator.mass: [60, 90]`")
    return value


_OVER_SCHEMA = {
    "type": "object",
    "minProperties": 1,
    "properties": {
        TAKE_KEY: {
            "enum": [WORST, MEAN],
            "description": "How the objectives under several conditions become one: that of "
            "the worst (the default) or their mean.",
        },
        FILE_KEY: {"description": FILES_DESCRIPTION, "type": ["array", "string"]},
        FROM_FIT_KEY: {
            "description": "Folder of a `drysim fit`, relative to this file: joint draws of "
            "the fitted values are conditions. A varied key has the value of the design.",
            "type": "string",
        },
        "count": {
            "description": "Number of these draws; default 16.",
            "type": "integer",
            "minimum": 1,
        },
    },
    "patternProperties": {KEY_PATTERN: {"anyOf": [VALUES_SCHEMA, {"type": "object"}]}},
    "additionalProperties": False,
}

MetricName = Annotated[
    str, AfterValidator(known_metric), WithJsonSchema({"enum": list(METRICS_BY_NAME)})
]


class Design(Block):
    """What `drysim design` chooses, what it minimises, and what every design must keep."""

    vary: Annotated[
        tuple[KeyRange, ...],
        PlainValidator(_require_vary),
        PlainSerializer(lambda ranges: {axis.key: axis.entry for axis in ranges}),
        DottedKeysSchema(VaryRange),
    ]
    """Keys to choose: dotted keys of this file, each with from and to."""
    minimise: Annotated[
        tuple[MetricName, ...],
        BeforeValidator(lambda value: [value] if isinstance(value, str) else value),
        PlainSerializer(lambda names: names[0] if len(names) == 1 else list(names)),
        Field(min_length=1, max_length=2),
    ]
    """Metric to minimise, or a list of two for their Pareto front."""
    within: Checks | None = None
    """Limits that every design must keep, written as checks; default: the checks of the file
    and its stroke limit."""
    over: (
        Annotated[
            Conditions,
            PlainValidator(_require_conditions),
            PlainSerializer(lambda over: sweep_to_dict(over.axes) | {TAKE_KEY: over.take}),
            WithJsonSchema(_OVER_SCHEMA),
        ]
        | None
    ) = None
    """Conditions under which every design is judged: keys with a list of values or a range,
    such as the records of a machine or the masses of its drivers. `take: worst` (the default)
    or `take: mean` combines the objectives; limits hold under every condition."""
    evaluations: Annotated[int, Field(strict=True, ge=1, le=MAX_EVALUATIONS)] = (
        DEFAULT_EVALUATIONS
    )
    """Largest number of designs to evaluate [-]; fewer if nothing more can be gained."""

    @model_validator(mode="after")
    def _check_names(self) -> Self:
        if len({*self.minimise}) < len(self.minimise):
            raise InvalidValue("names the same metric twice", "minimise")
        for i, check in enumerate(self.within or ()):
            if check.conditions:
                rule = "has a condition, but limits hold for every design"
                raise InvalidValue(f"{rule}; remove `at`", "within", i)
        varied = {key_range.key for key_range in self.vary}
        for axis in self.conditions.axes:
            if axis.key in varied:
                raise InvalidValue("is varied as well; remove one of them", "over", axis.key)
            if axis.key in (SEED_KEY, "excitation.seeds"):
                raise InvalidValue(
                    "is not a condition; use excitation.seeds for several seeds",
                    "over", axis.key,
                )  # fmt: skip
        return self

    @property
    def conditions(self) -> Conditions:
        """Conditions under which every design is judged."""
        return self.over or Conditions()

    def limits(
        self, checks: tuple[Check, ...], stroke_limit: Check | None
    ) -> tuple[Check, ...]:
        """Return the limits that every design must keep.

        By default they are the checks of the file and its stroke limit as a check, if it has
        one.
        """
        if self.within is not None:
            return self.within
        if stroke_limit is None or stroke_limit in checks:
            return checks
        return (*checks, stroke_limit)
