"""Condition: where a check applies, and the comparisons that both are made of."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from drysim.quantity import convert, meant, near, shown

Point = Mapping[str, float]

COMPARISONS: dict[str, Callable[[Any, float], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
}
BOUND = r"\s*+(?P<op>[<>=!]{1,2}+)\s*+(?P<limit>\S.*+)\s*"
"""A comparison and what is compared with; possessive, lest a megabyte of blanks take hours."""

AT = re.compile(r"\sat(?=\s|$)")
"""What parts a promise from where it applies."""

_FORM = re.compile(rf"\s*+(?P<key>[A-Za-z_][\w.-]*){BOUND}")
_AND = re.compile(r"\sand(?=\s|$)")

STATUS, OK = "status", "ok"
"""What a condition names to leave out cases without metrics: `at status == ok`."""

_WITH_METRICS = re.compile(rf"\s*+{STATUS}\s*+==\s*+{OK}\s*+")


@dataclass(frozen=True)
class Condition:
    """Where a check applies: a bound on a key of the scenario."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    op: str
    """One of < <= > >= and ==."""
    limit: float
    """In the SI unit of the key."""
    here: float | None = None
    """Value of the key in the scenario itself, which counts where it is not swept."""

    def holds(self, point: Point) -> bool:
        """Whether a point is where the check applies."""
        value = point.get(self.key, self.here)
        return value is not None and bool(COMPARISONS[self.op](value, self.limit))


def conditions(text: str, units: Mapping[str, str] | None) -> tuple[Condition, ...]:
    """Give the conditions in the text behind `at`, which `and` joins.

    Parameters
    ----------
    text : str
    units : mapping or None
        Unit of every key that there is; None takes any key, and plain numbers.
    """
    return tuple(_condition(part, units) for part in _AND.split(text))


def _condition(text: str, units: Mapping[str, str] | None) -> Condition:
    """Give one condition."""
    if _WITH_METRICS.fullmatch(text):
        # Cases are told apart by the number of their status, of which that of `ok` is 0.
        return Condition(STATUS, "==", 0.0, here=0.0)
    form = _FORM.fullmatch(text)
    if form is None:
        found = f"at{text}" if text.strip() else "at"
        example = "at excitation.frequency >= 8"
        raise ValueError(f"write `at key >= value`, such as `{example}`, not {shown(found)}")
    key, op = form["key"], form["op"]
    if units is not None and key not in units:
        hint = meant(next((other for other in units if _alike(key, other)), None))
        raise ValueError(f"{shown(key)} behind `at` is no numeric key of this scenario{hint}")
    refuse_unknown(op)
    return Condition(key, op, limit(form["limit"], units[key] if units else ""))


def _alike(key: str, other: str) -> bool:
    """Whether one dotted key may have been meant by another, step by step."""
    pairs = list(zip_longest(key.split("."), other.split("."), fillvalue=""))
    return all(a == b or near(a, [b]) for a, b in pairs)


def refuse_unknown(op: str) -> None:
    """Make sure that there is such a comparison."""
    if op not in COMPARISONS:
        raise ValueError(f"unknown comparison `{op}`; use one of {' '.join(COMPARISONS)}")


def limit(text: str, unit: str) -> float:
    """Give the number [unit] that a text compares with; a ValueError says why it has none."""
    value = convert(text, unit)
    if not math.isfinite(value):
        raise ValueError(f"must compare with a finite number, not {shown(text)}")
    return value
