"""The cases of a sweep in words: what is swept, and where one of them is."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

from drysim.wording.numbers import SIGNIFICANT, number, pretty

FEW = 5
"""Values of a swept key up to which each is named."""


MANY = 10_000
"""Values of a swept key beyond which they can only be evenly spread, in order."""


class Swept(Protocol):
    """A swept key with its unit and values."""

    @property
    def key(self) -> str:
        """Dotted key of the scenario."""

    @property
    def unit(self) -> str:
        """SI unit as in the header of a table."""

    @property
    def values(self) -> Sequence[float]:
        """Values in the unit."""

    @property
    def told(self) -> str:
        """The values in words, where their range does not tell them."""


def swept(axis: Swept) -> str:
    """Give what is swept, e.g. `excitation.frequency 0.5 to 10 Hz (96 values)`."""
    if axis.told:
        return f"{axis.key} {axis.told}"
    unit, values = pretty(axis.unit), axis.values
    if len(values) <= FEW:
        *most, last = apart(values)
        return f"{axis.key} {', '.join([*most, f'{last} {unit}'.rstrip()])}"
    ends = (values[0], values[-1]) if len(values) > MANY else (min(values), max(values))
    low, high = number(ends[0]), number(ends[1], unit)
    return f"{axis.key} {low} to {high} ({len(values)} values)"


def apart(values: Sequence[float]) -> list[str]:
    """Return values in words, with as many digits as it takes to tell them apart."""
    for digits in range(SIGNIFICANT, 18):
        words = [number(value, digits=digits) for value in values]
        if len({*words}) == len({*values}):
            break
    return words


def place(point: Mapping[str, float], axes: Sequence[Swept]) -> str:
    """Give where a case is, e.g. `frequency 1.6 Hz, rms 0.5 m/s²`."""
    return located(point, {axis.key: axis.unit for axis in axes})


def located(point: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Give where a case is by the unit of every swept key."""
    return ", ".join(
        f"{short(key, units)} {number(value, pretty(units.get(key, '')))}"
        for key, value in point.items()
    )


def places(points: Sequence[Mapping[str, float]], axes: Sequence[Swept]) -> str:
    """Give where a few cases are, e.g. `frequency 0.5, 7 Hz`; of several keys one by one."""
    if len(points[0]) > 1:
        return "; ".join(place(point, axes) for point in points)
    units = {axis.key: pretty(axis.unit) for axis in axes}
    *values, last = sorted(value for point in points for value in point.values())
    (key,) = points[0]
    spelled = [*map(number, values), number(last, units.get(key, ""))]
    return f"{short(key, units)} {', '.join(spelled)}"


def stretch(ends: Mapping[str, tuple[float, float]], axes: Sequence[Swept]) -> str:
    """Give between what some cases lie, e.g. `frequency 0.5 to 8 Hz, rms 0.5 to 1 m/s²`."""
    units = {axis.key: pretty(axis.unit) for axis in axes}
    return ", ".join(
        f"{short(key, units)} {f'{number(low)} to ' * (low < high)}"
        f"{number(high, units.get(key, ''))}"
        for key, (low, high) in ends.items()
    )


def short(key: str, keys: Collection[str]) -> str:
    """Give the last word of a swept key, as long as no other ends in it."""
    last = key.rpartition(".")[2]
    return key if sum(other.rpartition(".")[2] == last for other in keys) > 1 else last
