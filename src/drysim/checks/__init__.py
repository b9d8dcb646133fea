"""Checks: `T_a < 1.5` becomes a check, and a check with metrics becomes a verdict."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.checks.condition import AT as AT
from drysim.checks.condition import (
    BOUND,
    COMPARISONS,
    Condition,
    Point,
    conditions,
    limit,
    refuse_unknown,
)
from drysim.checks.condition import STATUS as STATUS
from drysim.checks.verdict import Verdict as Verdict
from drysim.checks.verdict import badness as badness
from drysim.metrics import SHARES, SIGNED, UNITS
from drysim.quantity import meant_or_known, shown, unit_behind

Metrics = Mapping[str, float | None]
Column = NDArray[Any]

_FORM = re.compile(rf"\s*+(?P<metric>[A-Za-z_]\w*){BOUND}")


@dataclass(frozen=True)
class Check:
    """A promise about a metric, e.g. `x_r_peak < 25 mm`, everywhere or `at` some cases."""

    text: str
    """As it stands in the scenario."""
    metric: str
    """A name of `drysim.metrics.METRICS`."""
    op: str
    """One of < <= > >= and ==."""
    limit: float
    """In the unit of the metric."""
    conditions: tuple[Condition, ...] = ()
    """All must hold where the check applies."""
    unit: str = ""
    """The unit that the limit is written in; empty where it is a bare number."""

    @classmethod
    def parse(cls, text: str, units: Mapping[str, str] | None = None) -> Check:
        """Give the check that a text means: `metric op value [at key op value [and ...]]`.

        Parameters
        ----------
        text : str
            Every value with or without unit.
        units : mapping, optional
            Unit of every key that a condition may name; default: any key, without units.

        Raises
        ------
        ValueError
            With a sentence, when it means none.
        """
        where = AT.split(text, maxsplit=1)[1:]
        promise = cls.promise(text)
        return replace(promise, conditions=conditions(where[0], units)) if where else promise

    @classmethod
    def promise(cls, text: str) -> Check:
        """Give a check without its conditions; errors as in `parse`."""
        promise = AT.split(text, maxsplit=1)[0]
        form = _FORM.fullmatch(promise)
        if form is None:
            raise ValueError(f"write `metric < value`, such as `T_a < 1.5`, not {shown(text)}")
        metric, op = form["metric"], form["op"]
        if metric not in UNITS:
            hint = meant_or_known(metric, UNITS)
            raise ValueError(f"unknown metric {shown(metric)}{hint}")
        refuse_unknown(op)
        bound, unit = limit(form["limit"], UNITS[metric]), unit_behind(form["limit"])
        return cls(text, metric, op, bound, unit=unit)

    def based_on(self, here: Mapping[str, float | None]) -> Check:
        """Give the check of a scenario in which some keys have these values."""
        known = (replace(one, here=here.get(one.key, one.here)) for one in self.conditions)
        return replace(self, conditions=tuple(known))

    def judge(self, metrics: Metrics) -> Verdict:
        """Give the verdict on one case; a metric that is not known fails the check.

        A check that does not apply to the case, by its `at`, is not judged.
        """
        if not self.applies({}):
            return Verdict(self, None, None, reason="this case lies elsewhere")
        return self.verdict(metrics.get(self.metric), None)

    def reach(self, points: Mapping[str, Column], count: int) -> Column:
        """Give which of so many cases the check applies to, as truth values of shape (count,).

        Parameters
        ----------
        points : mapping
            Column of every key that the cases have of their own, shape (count,).
        count : int
        """
        applies = np.ones(count, dtype=bool)
        for one in self.conditions:
            here = np.nan if one.here is None else one.here
            column = points.get(one.key, np.full(count, here))
            column = np.where(np.isnan(column), here, column)
            applies &= COMPARISONS[one.op](column, one.limit)
        return applies

    def worst(self, judged: Column, values: Column) -> int | None:
        """Give the place of the case that decides; None where none is judged.

        Parameters
        ----------
        judged : ndarray of bool, shape (n,)
            Cases that the check is about, whether they have metrics or not.
        values : ndarray, shape (n,)
            Of the metric; NaN where it is not known, which fails the check.
        """
        if not judged.any():
            return None
        bad = np.where(np.isnan(values), np.inf, self.off(values))
        return int(np.argmax(np.where(judged, bad, -np.inf)))

    def off(self, value: Any) -> Any:
        """Give how far a value, or a column, is from what was promised; below 0 it holds."""
        away = value - self.limit
        return {"<": away, ">": -away, "=": abs(away)}[self.op[0]]

    def holds(self, value: float) -> bool:
        """Whether a value of the metric is as promised."""
        return bool(COMPARISONS[self.op](value, self.limit))

    @property
    def foregone(self) -> bool | None:
        """Whether every value that the metric may have holds (True) or fails (False), if so."""
        low = -math.inf if self.metric in SIGNED else 0.0
        high = 1.0 if self.metric in SHARES else math.inf
        answers = {
            self.holds(value) for value in (low, high, *self._edge) if low <= value <= high
        }
        return answers.pop() if len(answers) == 1 else None

    def contradicts(self, other: Check) -> bool:
        """Whether no value of the metric, which both are about, is as both promise."""
        values = (*self._edge, *other._edge)
        return not any(self.holds(value) and other.holds(value) for value in values)

    @property
    def _edge(self) -> tuple[float, float, float]:
        """The limit and its neighbours: between two limits at least one of them lies."""
        below, above = (
            math.nextafter(self.limit, -math.inf),
            math.nextafter(self.limit, math.inf),
        )
        return below, self.limit, above

    def missed(self) -> Verdict:
        """Return the verdict where the check applies to none of many cases: it fails."""
        return Verdict(self, False, None, reason="no case lies there")

    def applies(self, point: Point) -> bool:
        """Whether a check is about the case at a point."""
        return all(condition.holds(point) for condition in self.conditions)

    def verdict(self, value: float | None, where: Point | None, status: str = "") -> Verdict:
        """Return the verdict on a case that the check applies to, by its metric.

        `status` says why a case has no metrics, where that is so.
        """
        if value is None or math.isnan(value):
            here = "" if where else " here"
            why = f"{status}: " if status else ""
            return Verdict(self, False, None, where, f"{why}{self.metric} is not known{here}")
        return Verdict(self, self.holds(value), value, where)

    def __str__(self) -> str:
        """Give the text of the scenario."""
        return self.text
