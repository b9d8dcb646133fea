"""The scenario blocks of a measured record: fields, short forms and validation.

No file is opened and no reader is imported here.
"""

import os
import re
from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationInfo,
    field_validator,
    model_validator,
)

from drysim import system
from drysim.block import Block, InvalidValue
from drysim.messages import closest_match, did_you_mean, format_value
from drysim.quantity import Dimensionless, Frequency, Quantity, Time
from drysim.records import SI
from drysim.units import NUMBER_PATTERN, conversion_factor, convert

SUGGESTED_HIGH_PASS = 0.3
"""Corner frequency of the high-pass that messages suggest [Hz], below human sensitivity."""

LARGE_MEAN = 0.1
"""Ratio of mean to RMS about the mean from which the mean changes the RMS by over 0.5 %."""

Trend = Literal["nothing", "rest", "mean", "line"]
TRENDS: tuple[str, ...] = get_args(Trend)
"""Values of `remove` that are a single word, each removing more than the one before."""

MAX_FILTER_ORDER = 8
"""Filters of higher order, applied forwards and backwards, ring for too long to be useful."""

MAX_SKIPPED_ROWS = 10_000
"""Limit of `skip`. Headers of loggers are shorter; more rows would be samples."""

Interpolation = Literal["line", "spline"]
"""Interpolation between samples: linear, or a cubic spline."""

PositiveTime = Annotated[float, Quantity("s", above=0)]

RowNumber = Annotated[int, Field(strict=True, ge=1)]


class Gaps(Block):
    """Interpolation of short gaps; longer gaps remain errors."""

    fill: Interpolation
    """Interpolation method: linear between the neighbouring samples (`line`), or a cubic spline
    through all samples (`spline`).
    """
    at_most: PositiveTime
    """Longest gap to fill [s], from the last sample before it to the first one after it."""


class Resample(Block):
    """Resampling onto another time grid, or of uneven times onto an even grid."""

    rate: Frequency | None = None
    """Sampling rate [Hz]."""
    step: PositiveTime | None = None
    """Time step [s], instead of `rate`."""
    by: Interpolation
    """Interpolation method: linear (`line`), or a cubic spline (`spline`)."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rate", "step"),)


class Removal(Block):
    """What is removed from the whole record: a trend, and frequencies outside a band."""

    trend: Trend = "nothing"
    """Trend to subtract: the level at `rest`, that of a quiet end of the record, the `mean`, or
    the least-squares `line`."""
    below: Frequency | None = None
    """Remove frequencies below this one [Hz], by a zero-phase Butterworth high-pass that halves
    the amplitude at this frequency."""
    above: Frequency | None = None
    """Remove frequencies above this one [Hz], by a zero-phase Butterworth low-pass."""
    order: Annotated[int, Field(strict=True, ge=1, le=MAX_FILTER_ORDER)] = 2
    """Order of the filters in each of the two directions [-]; together the slope is 12 dB per
    octave and order."""

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
        fields = self.model_copy(update=more).model_dump(exclude_defaults=True)
        if fields.keys() == {"trend"}:
            return f"`remove: {fields['trend']}`"
        items = (
            f"{key}: {value:.6g} Hz" if isinstance(value, float) else f"{key}: {value}"
            for key, value in fields.items()
        )
        return f"`remove: {{{', '.join(items)}}}`"

    @model_validator(mode="after")
    def _a_band(self) -> Self:
        if self.below is not None and self.above is not None and not self.below < self.above:
            raise InvalidValue(f"must be above `below`, {format_value(self.below)} Hz", "above")
        return self


class Window(Block):
    """The part of a record to use; its first sample becomes t = 0."""

    start: Time | None = Field(None, alias="from")
    """First time [s] on the time axis of the record; default: its first sample."""
    to: Time | None = None
    """Last time [s]; default: the last sample of the record."""

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if self.start is not None and self.to is not None and not self.start < self.to:
            raise InvalidValue(f"must be above `from`, {format_value(self.start)} s", "to")
        return self

    @property
    def ends(self) -> tuple[float, float]:
        """First and last time [s]; infinite where the file gives none."""
        return -inf if self.start is None else self.start, inf if self.to is None else self.to


class Rows(Block):
    """The rows of a text file that are samples."""

    start: RowNumber | None = Field(None, alias="from")
    """First row, by its line in the file from 1; default: the first one below the header."""
    to: RowNumber | None = None
    """Last row; default: the last one of the file."""
    where: dict[str | int, str | int] = Field({})
    """A column, by name or number, and the contents of its cell in the rows to use, such as
    `{sensor: S1}` where several sensors take turns; default: every row."""

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if self.start is not None and self.to is not None and not self.start < self.to:
            raise InvalidValue(f"must be above `from`, {self.start}", "to")
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
    raise ValueError(f"must include a unit, such as `50 m/s²`, not {format_value(value)}")


FullScale = Annotated[str, BeforeValidator(_validate_full_scale)]
"""A number with a unit."""

NOTHING = "nothing"


def _validate_missing(value: object) -> object:
    """Require a number without a unit: it is looked for among the numbers of the file."""
    if value == NOTHING:
        return value
    if isinstance(value, float | int) and not isinstance(value, bool) and abs(value) < inf:
        return float(value)
    raise ValueError(f"must be a number, or `{NOTHING}`, not {format_value(value)}")


MissingCode = Annotated[float | Literal["nothing"], BeforeValidator(_validate_missing)]
"""A number of the file that is no sample."""

Column = Annotated[str | int, BeforeValidator(_validate_column)]
"""Name of a column, or its number from 1."""


RemovalOption = Annotated[
    Removal,
    BeforeValidator(_expand_removal, json_schema_input_type=Trend | Frequency | Removal),
]
"""The block, or as short forms the name of its trend or the frequency of its high-pass."""


class InFile(Block):
    """Block whose samples are in a file."""

    file: Annotated[str, Field(min_length=1)]
    """File of the record, relative to the folder of the scenario; its extension determines the
    format."""

    _folder: Path = PrivateAttr(default_factory=Path)

    def model_post_init(self, context: Any, /) -> None:
        """Store the folder of the scenario from the validation context."""
        if isinstance(context, Mapping) and "folder" in context:
            self._folder = Path(context["folder"])

    @property
    def path(self) -> Path:
        """Path of the file as messages show it.

        A scenario from Windows may separate folders by backslashes, which elsewhere belong to
        a name.
        """
        path = self._folder / self.file
        if os.sep in self.file or "\\" not in self.file or os.path.lexists(path):
            return path
        return self._folder / self.file.replace("\\", "/")

    @property
    def named(self) -> str:
        """File name as in the scenario, but never an absolute path, for use in results."""
        return Path(self.file).name if Path(self.file).is_absolute() else self.file

    def file_from(self, folder: Path) -> str:
        """Return the path of the record relative to another folder."""
        path = self.path
        here = os.path.join(os.path.realpath(path.parent), path.name)
        return system.relative_path(here, os.path.realpath(folder))


class RatioTable(InFile):
    """Ratios over frequency, as columns of a file."""

    skip: Annotated[int, Field(strict=True, ge=0, le=MAX_SKIPPED_ROWS)] = 0
    """Rows to skip at the top of a text file [-]; default 0."""
    rows: Rows | None = None
    """The rows of a text file that are used, such as `{from: 4, to: 28}` or
    `{where: {level: "0.5"}}`; default: all below the header."""
    frequency: Column
    """Column of the frequencies, in Hz unless the header has another unit."""


class Recorded(InFile):
    """Evenly spaced samples in a column or channel of a file."""

    skip: Annotated[int, Field(strict=True, ge=0, le=MAX_SKIPPED_ROWS)] = 0
    """Rows to skip at the top of a text file, such as a preamble above the header [-]; default
    0."""
    rows: Rows | None = None
    """The rows of a text file that are samples, `{from: 4, to: 6004}`, by their lines in the
    file; default: all below the header."""
    column: Column | None = None
    """Column of the samples: its name in the header, with or without unit, or its number from
    1; in MATLAB files the variable. Optional if there is only one besides the time."""
    channel: Column | None = None
    """Channel of the samples: its number from 1 or its name, for formats with channels.
    Optional if there is only one."""
    unit: str | None = None
    """Unit of the samples, such as m/s2, g or N; required unless the file contains it, as in
    the header `u_dd [m/s2]`."""
    full_scale: FullScale | None = None
    """Value of digital full scale with its unit, such as `50 m/s2`, instead of `unit`: for WAV
    files with integer samples."""
    time: Column | None = None
    """Column of the times, evenly spaced: numbers, or dates and times of day, which count from
    midnight. Numbers are in the unit of their header (`t [ms]`, `time_ms`) or of `time_unit`,
    else in seconds; times since 1970 in s, ms, µs or ns and Excel's days are recognised."""
    time_unit: str | None = None
    """Unit of the times, such as ms, if the header has none."""
    rate: Frequency | None = None
    """Sampling rate [Hz], instead of `time`."""
    step: PositiveTime | None = None
    """Time step [s], instead of `time`."""
    scale: Dimensionless = 1.0
    """Factor on every sample [-]."""
    missing: MissingCode | None = None
    """Number that stands for missing samples, as it is written in the file, such as -9999; or
    `nothing`, if all numbers are samples. By default a number that looks like such a code is an
    error."""
    gaps: Gaps | None = None
    """Interpolation of missing samples; by default each is an error."""
    resample: Resample | None = None
    """Resampling onto another time grid; default: the grid of the record, which must be
    even."""
    remove: RemovalOption = Field({}, validate_default=True)
    """What is removed from the whole record: `rest`, `mean`, `line`, a band as in
    `{below: 0.3 Hz, above: 80 Hz}`, or `nothing`, the default.
    """
    window: Window | None = None
    """The part to use, `{from: 10 s, to: 70 s}`; its first sample becomes t = 0."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("time", "rate", "step"),
        ("column", "channel"),
        ("unit", "full_scale"),
    )

    _block: str = PrivateAttr("excitation")

    def model_post_init(self, context: Any, /) -> None:
        """Store folder and block of the scenario from the validation context."""
        super().model_post_init(context)
        if isinstance(context, Mapping) and "block" in context:
            self._block = context["block"]

    if TYPE_CHECKING:
        quantity: str
        """Measured quantity, a key of `SI`; a field of every class with a choice."""

    @field_validator("time_unit")
    @classmethod
    def _of_time(cls, unit: str | None, info: ValidationInfo) -> str | None:
        if unit is not None:
            conversion_factor(unit, "s")
            if info.data.get("time") is None:
                raise ValueError("needs `time`, the column whose unit it is")
        return unit

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

    @field_validator(
        "skip", "rows", "column", "channel", "unit", "full_scale", "time", "time_unit", "rate",
        "step",
    )  # fmt: skip
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
                "must be spline, not line: linear interpolation of displacement has kinks", key
            )
        return value

    @classmethod
    def si_of(cls, values: Mapping[str, Any]) -> str | None:
        """Return the SI unit of the samples given the validated fields; None if unknown."""
        return SI.get(values.get("quantity", getattr(cls, "quantity", "")))

    @property
    def block(self) -> str:
        """Block of the scenario that has the options of the column."""
        return self._block

    def with_file(self, file: str) -> Self:
        """Return the same block for another file, not validated."""
        return self.model_copy(update={"file": file})


class Measured(Block):
    """The measured quantity of a record of base motion."""

    quantity: Literal["acceleration", "velocity", "displacement"] = "acceleration"
    """Measured quantity. Velocity and displacement are differentiated through splines."""
    gravity: Literal["refuse", "keep"] = "refuse"
    """Treatment of a mean of ü near 9.81 m/s²: `refuse`, the default, makes it an error; `keep`
    keeps it, so that the spring carries the weight of the mass."""


class RecordedMotion(Recorded, Measured):
    """Measured base motion: file, column and quantity."""
