"""What a scenario may say about a record, where a word or a number alone does not do."""

from __future__ import annotations

import re
from typing import Annotated, Literal, Self

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    Tag,
    TypeAdapter,
    WithJsonSchema,
    model_validator,
)

from drysim.quantity import NUMBER, Block, Frequency, Misfit, Time, near, shown

WORDS = ("nothing", "mean", "line")


class Below(Block):
    """Everything slower than a frequency."""

    below: Frequency
    """Frequency [Hz] of the high-pass, which halves the amplitude there."""


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
    """Give `0.3 Hz` as `{below: 0.3 Hz}`."""
    if isinstance(given, dict | Below) or given in WORDS:
        return given
    if isinstance(given, float | int) and not isinstance(given, bool):
        return {"below": given}
    if isinstance(given, str) and re.match(r"\s*[-+]?\.?[0-9]", given):
        return {"below": given}
    nearest = near(given, WORDS) if isinstance(given, str) else None
    hint = f"; did you mean `{nearest}`?" if nearest else ""
    raise ValueError(f"must be {', '.join(WORDS)} or a frequency, not {shown(given)}{hint}")


def _full_scale(given: object) -> object:
    """Ask for a text: a number without a unit is what a full scale must not be."""
    if isinstance(given, str) and not NUMBER.fullmatch(given.strip()):
        return given
    raise ValueError(f"must say its unit, such as `50 m/s²`, not {shown(given)}")


FullScale = Annotated[str, BeforeValidator(_full_scale)]
"""A number with a unit."""

Column = Annotated[str | int, BeforeValidator(_column)]
"""Name of a column, or its number from 1."""

Removal = Annotated[
    Annotated[Literal["nothing", "mean", "line"], Tag("word")] | Annotated[Below, Tag("below")],
    Discriminator(lambda given: "word" if isinstance(given, str) else "below"),
    BeforeValidator(_removal),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": list(WORDS)},
                TypeAdapter(Frequency).json_schema(),
                TypeAdapter(Below).json_schema(),
            ]
        }
    ),
]
"""Nothing, mean, line, or what is below a frequency."""
