"""What a scenario may say about a record, where a word or a number alone does not do."""

from __future__ import annotations

import re
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema

from drysim.quantity import NUMBER, Block, Frequency, Misfit, Quantity, Time, meant, near, shown

SI = {"acceleration": "m/s²", "velocity": "m/s", "displacement": "m", "force": "N"}
"""The unit of ü, u̇ and u, and of a normal force."""

TRENDS = ("nothing", "mean", "line")
"""What `remove` may take away by a word alone, each more than the one before."""

HIGHEST_ORDER = 8
"""Beyond this order a filter run both ways rings longer than it helps."""

Way = Literal["line", "spline"]
"""How values between samples are found: on straight lines, or on the cubic spline."""

Span = Annotated[float, Quantity("s", above=0)]


class Gaps(Block):
    """Short gaps are filled; longer ones stay faults."""

    fill: Way
    """By what: a straight `line` between the samples on either side, or the cubic `spline`
    through all samples that are there."""
    at_most: Span
    """Longest gap that is filled [s], from the last sample before it to the first behind."""


class Resample(Block):
    """Another grid, or an even one for times that are uneven."""

    rate: Frequency | None = None
    """Samples per second [Hz]."""
    step: Span | None = None
    """Distance of the samples [s], in place of `rate`."""
    by: Way
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
    order: Annotated[int, Field(strict=True, ge=1, le=HIGHEST_ORDER)] = 2
    """Order of these filters [-] in each of their two directions; both together fall by 12 dB
    an octave and order."""

    @property
    def filters(self) -> bool:
        """Whether anything is filtered."""
        return self.below is not None or self.above is not None

    @property
    def any(self) -> bool:
        """Whether there is anything to do."""
        return self.filters or self.trend != "nothing"

    def with_too(self, **more: object) -> str:
        """Return the key `remove` as a file would have it with further keys; Hz as floats."""
        words = self.model_copy(update=more).model_dump(exclude_defaults=True)
        if words.keys() == {"trend"}:
            return f"`remove: {words['trend']}`"
        told = (
            f"{key}: {value:.6g} Hz" if isinstance(value, float) else f"{key}: {value}"
            for key, value in words.items()
        )
        return f"`remove: {{{', '.join(told)}}}`"

    @model_validator(mode="after")
    def _a_band(self) -> Self:
        if self.below is not None and self.above is not None and not self.below < self.above:
            raise Misfit(f"must be above `below`, {shown(self.below)} Hz", "above")
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
            raise Misfit(f"must be above `from`, {shown(self.start)} s", "to")
        return self


def _column(given: object) -> object:
    if isinstance(given, str) and given.strip():
        return given
    if isinstance(given, int) and not isinstance(given, bool) and given >= 1:
        return given
    raise ValueError(f"must be the name of a column or its number from 1, not {shown(given)}")


def _removal(given: object) -> object:
    """Give `mean` and `0.3 Hz` as the blocks that they are short for."""
    if isinstance(given, dict | Removal):
        return given
    if given in TRENDS:
        return {"trend": given}
    if isinstance(given, float | int) and not isinstance(given, bool):
        return {"below": given}
    if isinstance(given, str) and re.match(r"\s*[-+]?\.?[0-9]", given):
        return {"below": given}
    hint = meant(near(given, TRENDS)) if isinstance(given, str) else ""
    raise ValueError(f"must be {', '.join(TRENDS)} or a frequency, not {shown(given)}{hint}")


def _full_scale(given: object) -> object:
    """Ask for a text: a number without a unit is what a full scale must not be."""
    if isinstance(given, str) and not NUMBER.fullmatch(given.strip()):
        return given
    raise ValueError(f"must say its unit, such as `50 m/s²`, not {shown(given)}")


FullScale = Annotated[str, BeforeValidator(_full_scale)]
"""A number with a unit."""

Column = Annotated[str | int, BeforeValidator(_column)]
"""Name of a column, or its number from 1."""


class _ShortSchema:
    """What `remove` looks like to an editor."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Give the JSON schema: a word, a frequency or the block."""
        frequency = Quantity("Hz", above=0).__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [{"enum": list(TRENDS)}, frequency, handler(schema)]}


Removed = Annotated[Removal, BeforeValidator(_removal), _ShortSchema()]
"""The block, or short for it a word of its trend or the frequency of its high-pass."""
