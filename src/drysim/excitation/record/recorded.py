"""Recorded: a column or channel of a file, whatever it holds."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import Field, PrivateAttr, ValidationInfo, field_validator

from drysim.excitation.record.spoken import (
    Column,
    FullScale,
    Gaps,
    Removed,
    Resample,
    Window,
)
from drysim.quantity import Block, Frequency, Misfit, Plain, Quantity, convert, factor, shown

MOST_SKIPPED = 10_000
"""Rows that may be passed over: words of a logger are fewer, and what is more are samples."""


class Recorded(Block):
    """Evenly spaced samples in a column or channel of a file, and how they are read."""

    file: Annotated[str, Field(min_length=1)]
    """The record, relative to the scenario's folder; its suffix tells its format."""
    skip: Annotated[int, Field(strict=True, ge=0, le=MOST_SKIPPED)] = 0
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
    step: Annotated[float, Quantity("s", above=0)] | None = None
    """Distance of the samples [s], in place of `time`."""
    scale: Plain = 1.0
    """Factor on every sample [-]."""
    gaps: Gaps | None = None
    """What becomes of missing samples; default: each is a fault."""
    resample: Resample | None = None
    """Another grid for the record; default: its own, which must be even."""
    remove: Removed = Field({}, validate_default=True)
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
            factor(unit, si)
        return unit

    @field_validator("full_scale")
    @classmethod
    def _above_zero(cls, full_scale: str | None, info: ValidationInfo) -> str | None:
        si = cls.si_of(info.data)
        if full_scale is not None and si and not convert(full_scale, si) > 0:
            raise ValueError(f"must be above 0 {si}, not {shown(full_scale)}")
        return full_scale

    @field_validator("skip", "column", "channel", "unit", "full_scale", "time", "rate", "step")
    @classmethod
    def _of_the_format(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse a key that says nothing about a file of this format."""
        if not value:
            return value
        from drysim.excitation.record.formats import format_of

        member, key = format_of(info.data.get("file", "")), str(info.field_name)
        if member is not None and key in member.idle:
            raise ValueError(f"{member.name} {member.idle[key].format(key=key)}")
        return value

    @field_validator("gaps", "resample")
    @classmethod
    def _without_kinks(cls, value: Any, info: ValidationInfo) -> Any:
        """Refuse lines through displacements: their kinks would be shocks of the base."""
        key = "fill" if info.field_name == "gaps" else "by"
        if getattr(value, key, "") == "line" and info.data.get("quantity") == "displacement":
            raise Misfit("must be spline: a displacement on lines has kinks, not line", key)
        return value

    def model_post_init(self, context: Any, /) -> None:
        """Keep the scenario's folder, which the context of the validation names."""
        if isinstance(context, Mapping) and "folder" in context:
            self._folder = Path(context["folder"])

    @property
    def measured(self) -> str:
        """What the samples are, as `SI` names it."""
        raise NotImplementedError

    @classmethod
    def si_of(cls, words: Mapping[str, Any]) -> str | None:
        """Give the SI unit of the samples from the words read so far; None where unknown."""
        raise NotImplementedError

    def file_from(self, folder: Path) -> str:
        """Give the path of the record relative to another folder."""
        path = self.path
        here = os.path.join(os.path.realpath(path.parent), path.name)
        return Path(os.path.relpath(here, os.path.realpath(folder))).as_posix()

    @property
    def path(self) -> Path:
        """Where the record is, as messages name it."""
        return self._folder / self.file

    @property
    def named(self) -> str:
        """The file as the scenario gives it; results hold no absolute path."""
        return Path(self.file).name if Path(self.file).is_absolute() else self.file
