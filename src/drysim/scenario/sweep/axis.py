"""Axis: a swept key with its values; and the two ways in which a file may say them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, WithJsonSchema

from drysim.quantity import Block
from drysim.scenario.sweep.drawn import Drawn
from drysim.scenario.sweep.spread import Spread
from drysim.source import Keys

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
