"""Checks: `T_a < 1.5` becomes a check, and a check with metrics becomes a verdict.

A check promises something of a metric, everywhere or, behind `at`, where conditions on keys of
the scenario hold; a metric that is not known fails it.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drysim.metrics.table import SHARE_METRICS, SIGNED_METRICS, UNITS, Metrics
from drysim.units import (
    closest_match,
    conversion_factor,
    convert,
    did_you_mean,
    format_value,
    name_hint,
    unit_suffix,
)
from drysim.wording import format_interval, format_number, format_unit

Point = Mapping[str, float]
Column = NDArray[Any]

COMPARISONS: dict[str, Callable[[Any, float], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
}
COMPARISON_PATTERN = r"\s*+(?P<op>[<>=!]{1,2}+)\s*+(?P<limit>\S.*+)\s*"
"""A comparison and what is compared with; possessive, lest a megabyte of blanks take hours."""

AT_PATTERN = re.compile(r"\sat(?=\s|$)")
"""What parts a promise from where it applies."""

_CONDITION_PATTERN = re.compile(rf"\s*+(?P<key>[A-Za-z_][\w.-]*){COMPARISON_PATTERN}")
_CHECK_PATTERN = re.compile(rf"\s*+(?P<metric>[A-Za-z_]\w*){COMPARISON_PATTERN}")

STATUS, OK = "status", "ok"
"""What a condition names to leave out cases without metrics: `at status == ok`."""

_STATUS_OK_PATTERN = re.compile(rf"\s*+{STATUS}\s*+==\s*+{OK}\s*+")


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
        where = AT_PATTERN.split(text, maxsplit=1)[1:]
        comparison = cls.comparison(text)
        return (
            replace(comparison, conditions=parse_conditions(where[0], units))
            if where
            else comparison
        )

    @classmethod
    def comparison(cls, text: str) -> Check:
        """Give a check without its conditions; errors as in `parse`."""
        comparison = AT_PATTERN.split(text, maxsplit=1)[0]
        form = _CHECK_PATTERN.fullmatch(comparison)
        if form is None:
            raise ValueError(
                f"write `metric < value`, such as `T_a < 1.5`, not {format_value(text)}"
            )
        metric, op = form["metric"], form["op"]
        if metric not in UNITS:
            hint = name_hint(metric, UNITS)
            raise ValueError(f"unknown metric {format_value(metric)}{hint}")
        check_operator(op)
        bound, unit = parse_limit(form["limit"], UNITS[metric]), unit_suffix(form["limit"])
        return cls(text, metric, op, bound, unit=unit)

    def with_values(self, here: Mapping[str, float | None]) -> Check:
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

    def applicable(self, points: Mapping[str, Column], count: int) -> Column:
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
        bad = np.where(np.isnan(values), np.inf, self.excess(values))
        return int(np.argmax(np.where(judged, bad, -np.inf)))

    def excess(self, value: Any) -> Any:
        """Give how far a value, or a column, is from what was promised; below 0 it holds."""
        away = value - self.limit
        return {"<": away, ">": -away, "=": abs(away)}[self.op[0]]

    def holds(self, value: float) -> bool:
        """Whether a value of the metric is as promised."""
        return bool(COMPARISONS[self.op](value, self.limit))

    @property
    def constant_result(self) -> bool | None:
        """Whether every value that the metric may have holds (True) or fails (False), if so."""
        low = -math.inf if self.metric in SIGNED_METRICS else 0.0
        high = 1.0 if self.metric in SHARE_METRICS else math.inf
        answers = {
            self.holds(value)
            for value in (low, high, *self._values_at_limit)
            if low <= value <= high
        }
        return answers.pop() if len(answers) == 1 else None

    def contradicts(self, other: Check) -> bool:
        """Whether no value of the metric, which both are about, is as both promise."""
        values = (*self._values_at_limit, *other._values_at_limit)
        return not any(self.holds(value) and other.holds(value) for value in values)

    @property
    def _values_at_limit(self) -> tuple[float, float, float]:
        """The limit and its neighbours: between two limits at least one of them lies."""
        limit = self.limit
        return math.nextafter(limit, -math.inf), limit, math.nextafter(limit, math.inf)

    def no_case_verdict(self) -> Verdict:
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
        scale = conversion_factor(check.unit, unit) if check.unit else 1.0
        value, limit, unit = (
            self.value / scale,
            check.limit / scale,
            format_unit(check.unit or unit),
        )
        if self.half_width:
            words = format_interval(value, self.half_width / scale, unit)
        else:
            words = format_number(value, unit, _distinguishing_digits(value, limit))
        return f"with {words}{f', mean of {self.seeds} seeds' if self.seeds > 1 else ''}"

    @property
    def place(self) -> str:
        """The deciding case in words, such as ` at excitation.frequency = 8`."""
        point = self.where or {}
        values = [f"{key} = {format_number(value, digits=6)}" for key, value in point.items()]
        return f" at {', '.join(values)}" if values else ""


USUAL_DIGITS, MAX_DIGITS = 6, 17
"""Digits of a value beside the bound of its check; and all that it takes to tell them apart."""


def _distinguishing_digits(value: float, limit: float) -> int:
    """Give how many digits of a value tell it from a limit that it does not equal."""
    digits = USUAL_DIGITS
    while (
        value != limit
        and digits < MAX_DIGITS
        and format_number(value, digits=digits) == format_number(limit, digits=digits)
    ):
        digits += 1
    return digits


def violation(verdict: Verdict) -> float:
    """Give how far a case is from what was promised; what is not known is the worst."""
    if verdict.value is None or math.isnan(verdict.value):
        return math.inf
    return float(verdict.check.excess(verdict.value))


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


def has_condition(text: object) -> bool:
    """Whether a text is that of a check with an `at`."""
    return isinstance(text, str) and AT_PATTERN.search(text) is not None


def parse_conditions(text: str, units: Mapping[str, str] | None) -> tuple[Condition, ...]:
    """Give the conditions in the text behind `at`, which `and` joins; `units` as in `parse`."""
    return tuple(_parse_condition(part, units) for part in re.split(r"\sand(?=\s|$)", text))


def _parse_condition(text: str, units: Mapping[str, str] | None) -> Condition:
    """Give one condition."""
    if _STATUS_OK_PATTERN.fullmatch(text):
        # Cases are told apart by the number of their status, of which that of `ok` is 0.
        return Condition(STATUS, "==", 0.0, here=0.0)
    form = _CONDITION_PATTERN.fullmatch(text)
    if form is None:
        found = f"at{text}" if text.strip() else "at"
        example = "at excitation.frequency >= 8"
        raise ValueError(
            f"write `at key >= value`, such as `{example}`, not {format_value(found)}"
        )
    key, op = form["key"], form["op"]
    if units is not None and key not in units:
        hint = did_you_mean(
            next((other for other in units if _is_similar_key(key, other)), None)
        )
        raise ValueError(
            f"{format_value(key)} behind `at` is no numeric key of this scenario{hint}"
        )
    check_operator(op)
    return Condition(key, op, parse_limit(form["limit"], units[key] if units else ""))


def _is_similar_key(key: str, other: str) -> bool:
    """Whether one dotted key may have been meant by another, step by step."""
    pairs = list(zip_longest(key.split("."), other.split("."), fillvalue=""))
    return all(a == b or closest_match(a, [b]) for a, b in pairs)


def check_operator(op: str) -> None:
    """Make sure that there is such a comparison."""
    if op not in COMPARISONS:
        raise ValueError(f"unknown comparison `{op}`; use one of {' '.join(COMPARISONS)}")


def parse_limit(text: str, unit: str) -> float:
    """Give the number [unit] that a text compares with; a ValueError says why it has none."""
    value = convert(text, unit)
    if not math.isfinite(value):
        raise ValueError(f"must compare with a finite number, not {format_value(text)}")
    return value
