"""Axis: a swept key with its values; and the two ways in which a file may say them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, WithJsonSchema

from drysim.quantity import Block

_Number = Annotated[object, WithJsonSchema({"type": ["number", "string"]})]


@dataclass(frozen=True)
class Axis:
    """A key of the scenario that a sweep varies, and over what."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    unit: str
    """SI unit as in the header of a table, such as m/s2; `-` for a plain number."""
    values: tuple[float, ...]
    """In the order of the sweep, in the unit; whole numbers where the key takes no others."""
    words: Any = field(default=None, compare=False, repr=False)
    """What a scenario file says for them: a list, or a block of from, to and step or count."""

    @cached_property
    def column(self) -> NDArray[Any]:
        """The values as an array."""
        return np.array(self.values)


class Range(Block):
    """Evenly spread values, both ends included."""

    low: _Number = Field(alias="from")
    """First value, a number in SI or a text with a unit."""
    high: _Number = Field(alias="to")
    """Last value, above the first."""
    step: _Number = None
    """Distance of the values, which meets `to`."""
    count: int | None = None
    """Number of values, at least 2, in place of `step`."""
    scale: Literal["linear", "log"] | None = None
    """Whether a `count` of values is spread by difference (linear, the default) or by ratio
    (log)."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("step", "count"),)
    needs: ClassVar[dict[str, str]] = {"scale": "count"}


def points(axes: Sequence[Axis]) -> Iterator[dict[str, float]]:
    """Give every point of a grid without holding them all; the first axis varies fastest."""
    if not axes:
        yield {}
        return
    *inner, last = axes
    for value in last.values:
        for point in points(inner):
            yield {**point, last.key: value}
