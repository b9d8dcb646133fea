"""Verdict: a check with what the metric turned out to be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drysim.checks.condition import Point
from drysim.metrics import UNITS
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.checks import Check


@dataclass(frozen=True)
class Verdict:
    """A check with what the metric turned out to be."""

    check: Check
    passed: bool
    value: float | None
    """In the unit of the metric; None when it is not known in this scene."""
    where: Point | None = None
    """Of many cases the one that decided, by its swept keys; None for a single case."""
    applies: bool = True
    """Whether the check is about this case, or about any case of the sweep."""
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
    def unit(self) -> str:
        """Unit of the metric."""
        return UNITS[self.check.metric]

    @property
    def sentence(self) -> str:
        """What was asked, and what came out."""
        if not self.applies and self.passed:
            return f"{self.check}: passed over, this case lies elsewhere"
        if not self.applies:
            return f"{self.check}: no case lies there, so the check fails"
        if self.value is None:
            where = self.place or " here"
            return f"{self.check}: {self.check.metric} is not known{where}, so the check fails"
        unit = "" if self.unit == "-" else f" {self.unit}"
        outcome = "holds" if self.passed else "fails"
        width = "" if self.half_width is None else f" ± {self.half_width:.3g}"
        mean = f" (mean of {self.seeds} seeds)" if self.seeds > 1 else ""
        return f"{self.check}: {outcome} with {self.value:.6g}{width}{unit}{mean}{self.place}"

    @property
    def place(self) -> str:
        """The deciding case in words, such as ` at excitation.frequency = 8`."""
        point = self.where or {}
        values = [f"{key} = {number(value, digits=6)}" for key, value in point.items()]
        return f" at {', '.join(values)}" if values else ""


def badness(verdict: Verdict) -> float:
    """Give how far a case is from what was promised; what is not known is the worst."""
    if verdict.value is None or math.isnan(verdict.value):
        return math.inf
    return float(verdict.check.off(verdict.value))
