"""Verdict: a check with what the metric turned out to be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drysim.checks.condition import Point
from drysim.metrics import UNITS
from drysim.quantity import factor
from drysim.wording import around, number, pretty

if TYPE_CHECKING:
    from drysim.checks import Check

FINE, FINEST = 6, 17
"""Digits of a value beside the bound of its check; and all that it takes to tell them apart."""


@dataclass(frozen=True)
class Verdict:
    """A check with what the metric turned out to be."""

    check: Check
    passed: bool | None
    """None where the check was not judged."""
    value: float | None
    """In the unit of the metric; None where there is none, for a reason."""
    where: Point | None = None
    """Of many cases the one that decided, by its swept keys; None for a single case."""
    reason: str = ""
    """Why there is no value; empty where there is one."""
    half_width: float | None = None
    """Half of the 95 % confidence interval, where the value is a mean over several seeds."""
    seeds: int = 1
    """How many seeds the value is a mean over."""

    @property
    def undecided(self) -> bool:
        """Whether the limit lies within the confidence interval of the mean."""
        if self.value is None or self.half_width is None:
            return False
        return abs(self.value - self.check.limit) < self.half_width

    @property
    def sentence(self) -> str:
        """What was asked, and what came out."""
        outcome = {True: "holds", False: "fails", None: "not judged"}[self.passed]
        parted = ";" if self.reason else ""
        return f"{self.check}: {outcome}{parted} {self.found}{self.place}"

    @property
    def found(self) -> str:
        """What the metric turned out to be, in the unit that the check has; or the reason."""
        if self.value is None:
            return self.reason
        check, unit = self.check, UNITS[self.check.metric]
        scale = factor(check.unit, unit) if check.unit else 1.0
        value, limit, unit = self.value / scale, check.limit / scale, pretty(check.unit or unit)
        if self.half_width:
            words = around(value, self.half_width / scale, unit)
        else:
            words = number(value, unit, _digits(value, limit))
        return f"with {words}{f', mean of {self.seeds} seeds' if self.seeds > 1 else ''}"

    @property
    def place(self) -> str:
        """The deciding case in words, such as ` at excitation.frequency = 8`."""
        point = self.where or {}
        values = [f"{key} = {number(value, digits=6)}" for key, value in point.items()]
        return f" at {', '.join(values)}" if values else ""


def _digits(value: float, limit: float) -> int:
    """Give how many digits of a value tell it from a limit that it does not equal."""
    digits = FINE
    while value != limit and digits < FINEST and _alike(value, limit, digits):
        digits += 1
    return digits


def _alike(value: float, limit: float, digits: int) -> bool:
    """Tell whether two numbers read the same."""
    return number(value, digits=digits) == number(limit, digits=digits)


def badness(verdict: Verdict) -> float:
    """Give how far a case is from what was promised; what is not known is the worst."""
    if verdict.value is None or math.isnan(verdict.value):
        return math.inf
    return float(verdict.check.off(verdict.value))
