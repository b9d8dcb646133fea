"""Checks: `T_a < 1.5` becomes a check, and a check with metrics becomes a verdict."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from drysim.metrics import METRICS
from drysim.quantity import convert, near, shown

_OPERATORS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
}
_UNITS = {metric.name: metric.unit for metric in METRICS}
_FORM = re.compile(r"\s*(?P<metric>[A-Za-z_]\w*)\s*(?P<op>[<>=!]{1,2})\s*(?P<limit>.*\S)\s*")


@dataclass(frozen=True)
class Check:
    """A promise about a metric, e.g. `x_r_peak < 25 mm`."""

    text: str
    """As it stands in the scenario."""
    metric: str
    """A name of `drysim.metrics.METRICS`."""
    op: str
    """One of < <= > >= and ==."""
    limit: float
    """In the unit of the metric."""

    @classmethod
    def parse(cls, text: str) -> Check:
        """Give the check that a text means: `metric op value`, the value with or without unit.

        Raises
        ------
        ValueError
            With a sentence, when it means none.
        """
        form = _FORM.fullmatch(text)
        if form is None:
            raise ValueError(f"write `metric < value`, such as `T_a < 1.5`, not {shown(text)}")
        metric, op = form["metric"], form["op"]
        if metric not in _UNITS:
            nearest = near(metric, _UNITS)
            hint = f"did you mean `{nearest}`?" if nearest else f"known are {', '.join(_UNITS)}"
            raise ValueError(f"unknown metric `{metric}`; {hint}")
        if op not in _OPERATORS:
            raise ValueError(f"unknown comparison `{op}`; use one of {' '.join(_OPERATORS)}")
        return cls(text, metric, op, _limit(form["limit"], metric))

    def judge(self, metrics: Mapping[str, float | None]) -> Verdict:
        """Give the verdict; a metric that is not known fails the check."""
        value = metrics.get(self.metric)
        holds = value is not None and _OPERATORS[self.op](value, self.limit)
        return Verdict(self, bool(holds), value)

    def __str__(self) -> str:
        """Give the text of the scenario."""
        return self.text


@dataclass(frozen=True)
class Verdict:
    """A check with what the metric turned out to be."""

    check: Check
    passed: bool
    value: float | None
    """In the unit of the metric; None when it is not known in this scene."""

    @property
    def unit(self) -> str:
        """Unit of the metric."""
        return _UNITS[self.check.metric]

    @property
    def sentence(self) -> str:
        """What was asked, and what came out."""
        if self.value is None:
            return f"{self.check}: {self.check.metric} is not known here, so the check fails"
        unit = "" if self.unit == "-" else f" {self.unit}"
        return (
            f"{self.check}: {'holds' if self.passed else 'fails'} with {self.value:.6g}{unit}"
        )


def _limit(text: str, metric: str) -> float:
    """Give the number [unit of the metric] that a check compares with."""
    if re.search(r"\sat\s", text):
        raise ValueError("`at` belongs to a sweep; the check of one case is `metric < value`")
    limit = convert(text, _UNITS[metric])
    if not math.isfinite(limit):
        raise ValueError(f"must compare with a finite number, not {shown(text)}")
    return limit
