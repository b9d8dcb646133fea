"""The scenario blocks of a measured record: fields, short forms and validation.

No file is opened and no reader is imported here.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    PrivateAttr,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema

from drysim.units import (
    NUMBER_PATTERN,
    Block,
    Dimensionless,
    Frequency,
    InvalidValue,
    Quantity,
    Time,
    closest_match,
    conversion_factor,
    convert,
    did_you_mean,
    format_value,
)

SUGGESTED_HIGH_PASS = 0.3
"""Corner frequency of the high-pass that messages suggest [Hz], below human sensitivity."""

TRENDS = ("nothing", "mean", "line")
"""Values of `remove` that are a single word, each removing more than the one before."""

MAX_FILTER_ORDER = 8
"""Filters of higher order, applied forwards and backwards, ring for too long to be useful."""

MAX_SKIPPED_ROWS = 10_000
"""Limit of `skip`. Headers of loggers are shorter; more rows would be samples."""

Interpolation = Literal["line", "spline"]
"""Interpolation between samples: linear, or a cubic spline."""

PositiveTime = Annotated[float, Quantity("s", above=0)]


class Gaps(Block):
    """Short gaps are filled; longer ones stay faults."""

    fill: Interpolation
    """By what: a straight `line` between the samples on either side, or the cubic `spline`
    through all samples that are there."""
    at_most: PositiveTime
    """Longest gap that is filled [s], from the last sample before it to the first behind."""


class Resample(Block):
    """Another grid, or an even one for times that are uneven."""

    rate: Frequency | None = None
    """Samples per second [Hz]."""
    step: PositiveTime | None = None
    """Distance of the samples [s], in place of `rate`."""
    by: Interpolation
    """By what: the straight `line` between two samples, or the cubic `spline` through all."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rate", "step"),)


class Removal(Block):
    """What is taken away from the whole record: its trend, and what is outside a band."""

    trend: Literal["nothing", "mean", "line"] = "nothing"
    """Its mean or its line (least squares)."""
    below: Frequency | None = None
    """What is slower than this frequency [Hz], by a Butterworth high-pass without phase shift,
    which halves the amplitude there."""
    above: Frequency | None = None
    """What is faster than this frequency [Hz], by such a low-pass."""
    order: Annotated[int, Field(strict=True, ge=1, le=MAX_FILTER_ORDER)] = 2
    """Order of these filters [-] in each of their two directions; both together fall by 12 dB
    an octave and order."""

    @property
    def has_filters(self) -> bool:
        """Whether a filter is requested."""
        return (self.below, self.above) != (None, None)

    @property
    def any(self) -> bool:
        """Whether anything is removed."""
        return self.has_filters or self.trend != "nothing"

    def yaml_with(self, **more: object) -> str:
        """Return the key `remove` as YAML with further keys; floats are frequencies [Hz]."""
        words = self.model_copy(update=more).model_dump(exclude_defaults=True)
        if words.keys() == {"trend"}:
            return f"`remove: {words['trend']}`"
        items = (
            f"{key}: {value:.6g} Hz" if isinstance(value, float) else f"{key}: {value}"
            for key, value in words.items()
        )
        return f"`remove: {{{', '.join(items)}}}`"

    @model_validator(mode="after")
    def _a_band(self) -> Self:
        if self.below is not None and self.above is not None and not self.below < self.above:
            raise InvalidValue(f"must be above `below`, {format_value(self.below)} Hz", "above")
        return self


class Window(Block):
    """The part of a record that counts; its first sample becomes t = 0."""

    start: Time | None = Field(None, alias="from")
    """First time [s], on the record's own time axis; default its first sample."""
    to: Time | None = None
    """Last time [s]; default the record's last sample."""

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if self.start is not None and self.to is not None and not self.start < self.to:
            raise InvalidValue(f"must be above `from`, {format_value(self.start)} s", "to")
        return self


def _validate_column(value: object) -> object:
    if isinstance(value, str) and value.strip():
        return value
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    raise ValueError(
        f"must be the name of a column or its number from 1, not {format_value(value)}"
    )


def _expand_removal(value: object) -> object:
    """Expand the short forms `mean` and `0.3 Hz` to blocks."""
    if isinstance(value, dict | Removal):
        return value
    if value in TRENDS:
        return {"trend": value}
    if isinstance(value, float | int) and not isinstance(value, bool):
        return {"below": value}
    if isinstance(value, str) and re.match(r"\s*[-+]?\.?[0-9]", value):
        return {"below": value}
    hint = did_you_mean(closest_match(value, TRENDS)) if isinstance(value, str) else ""
    raise ValueError(
        f"must be {', '.join(TRENDS)} or a frequency, not {format_value(value)}{hint}"
    )


def _validate_full_scale(value: object) -> object:
    """Require text with a unit; the unit of a full scale cannot be guessed."""
    if isinstance(value, str) and not NUMBER_PATTERN.fullmatch(value.strip()):
        return value
    raise ValueError(f"must say its unit, such as `50 m/s²`, not {format_value(value)}")


FullScale = Annotated[str, BeforeValidator(_validate_full_scale)]
"""A number with a unit."""

Column = Annotated[str | int, BeforeValidator(_validate_column)]
"""Name of a column, or its number from 1."""


class _RemovalSchema:
    """JSON schema of `remove`: a word, a frequency or the block."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the JSON schema."""
        frequency = Quantity("Hz", above=0).__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [{"enum": list(TRENDS)}, frequency, handler(schema)]}


RemovalOption = Annotated[Removal, BeforeValidator(_expand_removal), _RemovalSchema()]
"""The block, or as short forms the name of its trend or the frequency of its high-pass."""


class Recorded(Block):
    """Evenly spaced samples in a column or channel of a file, and how they are read."""

    file: Annotated[str, Field(min_length=1)]
    """The record, relative to the scenario's folder; its suffix tells its format."""
    skip: Annotated[int, Field(strict=True, ge=0, le=MAX_SKIPPED_ROWS)] = 0
    """Rows at the top of a text file that are passed over, as words of a logger above the
    header are [-]; default 0."""
    column: Column | None = None
    """Column of the samples: its name in the header, with or without unit, or its number from
    1; of MATLAB files the variable. May be left out when there is but one besides the time."""
    channel: Column | None = None
    """Channel of the samples, its number from 1 or its name; for formats that have channels.
    May be left out when there is but one."""
    unit: str | None = None
    """Unit of the samples, such as m/s2, g or N; needed unless the file says it, as the header
    `u_dd [m/s2]` does."""
    full_scale: FullScale | None = None
    """What digital full scale means, with its unit, such as `50 m/s2`: in place of `unit` for
    a WAV whose samples are whole numbers."""
    time: Column | None = None
    """Column of the time, evenly spaced; seconds unless its header says otherwise."""
    rate: Frequency | None = None
    """Samples per second [Hz], in place of `time`."""
    step: PositiveTime | None = None
    """Distance of the samples [s], in place of `time`."""
    scale: Dimensionless = 1.0
    """Factor on every sample [-]."""
    gaps: Gaps | None = None
    """What becomes of missing samples; default: each is a fault."""
    resample: Resample | None = None
    """Another grid for the record; default: its own, which must be even."""
    remove: RemovalOption = Field({}, validate_default=True)
    """What is taken away from the whole record: `mean`, `line`, a band as in
    `{below: 0.3 Hz, above: 80 Hz}`, or `nothing`, the default."""
    window: Window | None = None
    """The part that counts, `{from: 10 s, to: 70 s}`; its first sample becomes t = 0."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("time", "rate", "step"),
        ("column", "channel"),
        ("unit", "full_scale"),
    )

    _folder: Path = PrivateAttr(default_factory=Path)

    @field_validator("unit")
    @classmethod
    def _of_the_quantity(cls, unit: str | None, info: ValidationInfo) -> str | None:
        if unit is not None and (si := cls.si_of(info.data)):
            conversion_factor(unit, si)
        return unit

    @field_validator("full_scale")
    @classmethod
    def _above_zero(cls, full_scale: str | None, info: ValidationInfo) -> str | None:
        si = cls.si_of(info.data)
        if full_scale is not None and si and not convert(full_scale, si) > 0:
            raise ValueError(f"must be above 0 {si}, not {format_value(full_scale)}")
        return full_scale

    @field_validator("skip", "column", "channel", "unit", "full_scale", "time", "rate", "step")
    @classmethod
    def _of_the_format(cls, value: Any, info: ValidationInfo) -> Any:
        """Reject a key that has no meaning for the format of the file."""
        if not value:
            return value
        from drysim.records.formats import format_of

        member, key = format_of(info.data.get("file", "")), str(info.field_name)
        if member is not None and key in member.unused_keys:
            raise ValueError(f"{member.name} {member.unused_keys[key].format(key=key)}")
        return value

    @field_validator("gaps", "resample")
    @classmethod
    def _without_kinks(cls, value: Any, info: ValidationInfo) -> Any:
        """Reject linear interpolation of displacement: kinks would be acceleration impulses."""
        key = "fill" if info.field_name == "gaps" else "by"
        if getattr(value, key, "") == "line" and info.data.get("quantity") == "displacement":
            raise InvalidValue(
                "must be spline: a displacement on lines has kinks, not line", key
            )
        return value

    def model_post_init(self, context: Any, /) -> None:
        """Store the folder of the scenario from the validation context."""
        if isinstance(context, Mapping) and "folder" in context:
            self._folder = Path(context["folder"])

    @property
    def measured(self) -> str:
        """Measured quantity, a key of `SI`."""
        raise NotImplementedError

    @classmethod
    def si_of(cls, words: Mapping[str, Any]) -> str | None:
        """Return the SI unit of the samples given the validated fields; None if unknown."""
        raise NotImplementedError

    def file_from(self, folder: Path) -> str:
        """Return the path of the record relative to another folder."""
        path = self.path
        here = os.path.join(os.path.realpath(path.parent), path.name)
        return Path(os.path.relpath(here, os.path.realpath(folder))).as_posix()

    @property
    def path(self) -> Path:
        """Path of the record as messages show it."""
        return self._folder / self.file

    @property
    def named(self) -> str:
        """File name as in the scenario, but never an absolute path, for use in results."""
        return Path(self.file).name if Path(self.file).is_absolute() else self.file


class Measured(Block):
    """What a record of base motion holds."""

    quantity: Literal["acceleration", "velocity", "displacement"] = "acceleration"
    """What the samples are. Velocity and displacement become acceleration through splines."""
    gravity: Literal["refuse", "keep"] = "refuse"
    """What becomes of a mean of ü near 9.81 m/s²: `refuse`, the default, makes it a fault,
    `keep` leaves it in, so that the spring bears the weight of the mass."""


class RecordedMotion(Recorded, Measured):
    """Base motion as it was measured: which column of which file, and what it holds."""
