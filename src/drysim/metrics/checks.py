"""Checks: text such as `T_a < 1.5` is parsed to a `Check`, which gives a `Verdict` on metrics.

A check compares a metric with a limit, in all cases or, after `at`, in those whose scenario
keys satisfy conditions. Over several seeds it judges the mean, every seed, or a quantile. An
unknown metric fails the check.
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

from drysim.messages import closest_match, did_you_mean, format_value, name_hint
from drysim.metrics.table import METRICS_BY_NAME, SHARE, SIGNED, UNITS, Metrics
from drysim.units import conversion_factor, convert, unit_suffix
from drysim.wording import Point, format_interval, format_number, format_unit

Column = NDArray[Any]

COMPARISONS: dict[str, Callable[[Any, float], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
}
COMPARISON_PATTERN = r"\s*+(?P<op>[<>=!]{1,2}+)\s*+(?P<limit>\S.*+)\s*"
"""A comparison and its limit. Possessive quantifiers prevent quadratic backtracking on long
blanks."""

AT_PATTERN = re.compile(r"\sat(?=\s|$)")
"""Separates a comparison from its conditions."""

MEAN, EVERY_SEED = "mean", "every seed"
"""What a check judges over several seeds, besides quantiles such as `p95`."""

_EVERY_SEED_PATTERN = re.compile(r"(?<!\s)\s++with\s++every\s++seed\s*+$")
"""Ends the text of a check that each seed must pass. It begins at the first of several blanks,
so that a million of them are read once."""

_CONDITION_PATTERN = re.compile(rf"\s*+(?P<key>[A-Za-z_][\w.-]*){COMPARISON_PATTERN}")
_CHECK_PATTERN = re.compile(
    rf"\s*+(?P<metric>[A-Za-z_]\w*)(?:\s++p(?P<percent>\d++(?:\.\d++)?+))?+"
    rf"{COMPARISON_PATTERN}"
)

LEAST_EXCESS = 1e-200
"""Relative excess of a value that fails and is equal to its limit."""

STATUS, OK = "status", "ok"
"""Condition that selects cases with metrics: `at status == ok`."""

_STATUS_OK_PATTERN = re.compile(rf"\s*+{STATUS}\s*+==\s*+{OK}\s*+")


def seeds_for_quantile(level: float) -> int:
    """Return the number of seeds of which one is expected beyond a quantile, on its rarer side.

    Of fewer seeds the quantile is about an extreme: there is no order statistic beyond it.
    """
    return math.ceil(1.0 / min(level, 1.0 - level) - LEVEL_ROUNDING)


LEVEL_ROUNDING = 1e-6
"""Rounding of the number of seeds that a level written in decimals asks for."""


@dataclass(frozen=True)
class Check:
    """Comparison of a metric with a limit, e.g. `x_r_peak < 25 mm`, in all cases or in some."""

    text: str
    """Text in the scenario."""
    metric: str
    """A name of `drysim.metrics.table.METRICS`."""
    op: str
    """One of < <= > >= and ==."""
    limit: float
    """Limit in the unit of the metric."""
    conditions: tuple[Condition, ...] = ()
    """Conditions, all of which must hold where the check applies."""
    unit: str = ""
    """Unit in which the limit is written; empty for a bare number."""
    judges: str = MEAN
    """What is judged over several seeds: `mean`, `every seed`, or a quantile such as `p95`."""

    @classmethod
    def parse(cls, text: str, units: Mapping[str, str] | None = None) -> Check:
        """Parse `metric [p95] op value [with every seed] [at key op value [and ...]]`.

        Parameters
        ----------
        text : str
            Every value with or without unit.
        units : mapping, optional
            Unit of every key allowed in a condition; default: any key, without units.

        Raises
        ------
        ValueError
            If the text is not a check; the message says what to write.
        """
        where = AT_PATTERN.split(text, maxsplit=1)[1:]
        if where and _EVERY_SEED_PATTERN.search(where[0]):
            raise ValueError(f"write `with {EVERY_SEED}` before `at`")
        comparison = cls.comparison(text)
        return (
            replace(comparison, conditions=parse_conditions(where[0], units))
            if where
            else comparison
        )

    @classmethod
    def comparison(cls, text: str) -> Check:
        """Parse a check without its conditions; errors as in `parse`."""
        comparison = AT_PATTERN.split(text, maxsplit=1)[0]
        single = _EVERY_SEED_PATTERN.sub("", comparison)
        form = _CHECK_PATTERN.fullmatch(single)
        if form is None:
            raise ValueError(
                f"write `metric < value`, such as `T_a < 1.5`, not {format_value(text)}"
            )
        metric, op = known_metric(form["metric"]), form["op"]
        check_operator(op)
        bound, unit = parse_limit(form["limit"], UNITS[metric]), unit_suffix(form["limit"])
        judges = MEAN if single == comparison else EVERY_SEED
        if percent := form["percent"]:
            if judges == EVERY_SEED:
                raise ValueError(f"write either `p{percent}` or `with {EVERY_SEED}`, not both")
            if not 0.0 < float(percent) < 100.0:
                raise ValueError(f"a quantile lies between p0 and p100, not at `p{percent}`")
            judges = f"p{float(percent):g}"
        return cls(text, metric, op, bound, unit=unit, judges=judges)

    @property
    def is_quantile(self) -> bool:
        """Whether a quantile is judged."""
        return self.judges not in (MEAN, EVERY_SEED)

    @property
    def least_seeds(self) -> int:
        """Number of seeds below which a quantile is about an extreme; 1 for what is none."""
        if not self.is_quantile:
            return 1
        return seeds_for_quantile(float(self.judges[1:]) / 100.0)

    @property
    def keys(self) -> set[str]:
        """Keys of the conditions."""
        return {condition.key for condition in self.conditions}

    def with_values(self, here: Mapping[str, float | None]) -> Check:
        """Return the check for a scenario in which some keys have these values."""
        conditions = (
            replace(condition, here=here.get(condition.key, condition.here))
            for condition in self.conditions
        )
        return replace(self, conditions=tuple(conditions))

    def over_seeds(self, values: Column) -> Any:
        """Return the value over several seeds that the check judges, other than their mean.

        Parameters
        ----------
        values : ndarray, shape (seeds, ...)
            Metric of each seed. NaN where unknown, which makes the value NaN.
        """
        if self.judges == EVERY_SEED:
            worst = self.excess(values).argmax(axis=0)  # of NaN, if there is any
            return np.take_along_axis(values, np.expand_dims(worst, 0), axis=0)[0]
        level = float(self.judges[1:]) / 100.0
        return np.quantile(values, level, axis=0, method="median_unbiased")

    def judge(self, metrics: Metrics, status: str = OK) -> Verdict:
        """Return the verdict on a single case; an unknown metric fails the check.

        A check whose conditions exclude the case is not judged. `status` is that of the case.
        """
        lost = status != OK
        if not self.applies({STATUS: 1.0} if lost else {}):
            return self.skipped("the condition is not met")
        return self.verdict(metrics.get(self.metric), None, status if lost else "")

    def skipped(self, reason: str) -> Verdict:
        """Return the verdict where the check is not judged."""
        return Verdict(self, None, None, reason=reason)

    def undecided_before_all(self, things: str) -> Verdict:
        """Return the verdict while some cases or seeds, which may decide, are not computed."""
        return self.skipped(f"not decided before all {things} are computed")

    def applicable(self, points: Mapping[str, Column], count: int) -> Column:
        """Return the cases to which the check applies, as booleans of shape (count,).

        `points` are columns of the keys that differ between the `count` cases, shape (count,).
        """
        applies = np.ones(count, dtype=bool)
        for condition in self.conditions:
            here = np.nan if condition.here is None else condition.here
            column = points.get(condition.key, np.full(count, here))
            column = np.where(np.isnan(column), here, column)
            applies &= COMPARISONS[condition.op](column, condition.limit)
        return applies

    def worst(self, judged: Column, values: Column) -> int | None:
        """Return the index of the case that decides; None where none is judged.

        `judged` are the cases to which the check applies, with or without metrics, and `values`
        their values of the metric: NaN where it is unknown, which fails the check.
        """
        if not judged.any():
            return None
        bad = np.where(np.isnan(values), np.inf, self.excess(values))
        return int(np.argmax(np.where(judged, bad, -np.inf)))

    def excess(self, value: Any) -> Any:
        """Return by how much a value, or a column, exceeds the limit; below 0 it holds."""
        away = value - self.limit
        return {"<": away, ">": -away, "=": abs(away)}[self.op[0]]

    def relative_excess(self, values: Column) -> Column:
        """Return by how much values exceed the limit, relative to it; NaN where unknown.

        It is above 0 exactly where the check fails, also for a value equal to the limit.
        """
        amount: Column = self.excess(values) / (abs(self.limit) or 1.0)
        return np.where(self.holds(values), amount, np.maximum(amount, LEAST_EXCESS))

    def holds(self, value: Any) -> Any:
        """Whether a value, or each value of a column, of the metric satisfies the check."""
        return COMPARISONS[self.op](value, self.limit)

    @property
    def constant_result(self) -> bool | None:
        """Result that all possible values of the metric have in common; None if they differ."""
        # The result changes at the limit only: the ends of the range and the floats around the
        # limit stand for all values.
        kind = METRICS_BY_NAME[self.metric].kind
        low = -math.inf if kind == SIGNED else 0.0
        high = 1.0 if kind == SHARE else math.inf
        answers = {
            self.holds(value)
            for value in (low, high, *self._values_at_limit)
            if low <= value <= high
        }
        return answers.pop() if len(answers) == 1 else None

    def contradicts(self, other: Check) -> bool:
        """Whether no value of the metric satisfies both this check and another."""
        if self.judges != other.judges and EVERY_SEED not in (self.judges, other.judges):
            return False  # such as a mean and a quantile, which are two values
        values = (*self._values_at_limit, *other._values_at_limit)
        return not any(self.holds(value) and other.holds(value) for value in values)

    @property
    def _values_at_limit(self) -> tuple[float, float, float]:
        """The limit and its floating-point neighbours: one of them lies between two limits."""
        limit = self.limit
        return math.nextafter(limit, -math.inf), limit, math.nextafter(limit, math.inf)

    def no_case_verdict(self) -> Verdict:
        """Return the verdict where the check applies to none of many cases: it fails."""
        return Verdict(self, False, None, reason="no case meets the condition")

    def applies(self, point: Point) -> bool:
        """Whether the check applies to the case at a point."""
        return all(condition.holds(point) for condition in self.conditions)

    def verdict(self, value: float | None, where: Point | None, status: str = "") -> Verdict:
        """Return the verdict on a case to which the check applies, by its metric.

        `status` is the reason for missing metrics.
        """
        if value is None or math.isnan(value):
            here = "" if where or status else " here"
            why = f"{status}: " if status else ""
            known_for = METRICS_BY_NAME[self.metric].known_for
            which = f": it is known for {known_for} only" if known_for and not status else ""
            reason = f"{why}{self.metric} is not known{here}{which}"
            return Verdict(self, False, None, where, reason)
        return Verdict(self, bool(self.holds(value)), value, where)

    def __str__(self) -> str:
        """Text in the scenario."""
        return self.text


@dataclass(frozen=True)
class Verdict:
    """Result of a check."""

    check: Check
    passed: bool | None
    """None where the check was not judged."""
    value: float | None
    """Value of the metric in its unit; None where it is unknown, see `reason`."""
    where: Point | None = None
    """Swept keys of the case that decided; None for a single case."""
    reason: str = ""
    """Reason for a missing value; empty where there is one."""
    half_width: float | None = None
    """Half width of the 95 % confidence interval of a mean over several seeds."""
    seeds: int = 1
    """Number of seeds over which it is judged."""
    failed: int = 0
    """Number of cases of a table that fail the check."""
    cases: int = 0
    """Number of cases to which it applies; 0 for a single case."""
    failed_seeds: int = 0
    """Number of seeds whose own values do not satisfy the check."""
    worst_seed: int | None = None
    """The seed that fails by most where each must pass; None if none fails."""
    of_draws: bool = False
    """Whether the cases are draws of a fit, of which none is named."""

    @property
    def undecided(self) -> bool:
        """Whether the limit lies within the confidence interval of the mean."""
        if self.value is None or self.half_width is None:
            return False
        return abs(self.value - self.check.limit) < self.half_width

    @property
    def sentence(self) -> str:
        """The check and its result."""
        outcome = {True: "holds", False: "fails", None: "skipped"}[self.passed]
        parted = ";" if self.reason else self.share and ","
        return f"{self.check}: {outcome}{self.share}{parted} {self.described_value}{self.place}"

    @property
    def share(self) -> str:
        """How many cases or seeds fail, such as ` in 3 of 12 cases`; empty for a single one."""
        if self._fails_in_cases:
            return f" in {self.failed} of {self._many}"
        if not self._fails_in_seeds:
            return ""
        share = f"{self.failed_seeds} of {self.seeds} seeds"
        is_said = _EVERY_SEED_PATTERN.search(self.check.text)
        return f": {share} fail" if is_said else f" in {share}"

    @property
    def _many(self) -> str:
        """Number of cases."""
        return f"{self.cases} {'draws' if self.of_draws else 'cases'}"

    @property
    def is_quantile_of_draws(self) -> bool:
        """Whether the value is a quantile over draws, which have no seeds."""
        return self.of_draws and self.seeds == 1 and self.check.is_quantile

    @property
    def _fails_in_cases(self) -> bool:
        """Whether some of several cases fail."""
        return self.failed > 0 and self.cases > 1 and not self.is_quantile_of_draws

    @property
    def _fails_in_seeds(self) -> bool:
        """Whether a single case has seeds that fail where each must pass."""
        is_alone = not self._fails_in_cases
        return bool(self.failed_seeds) and is_alone and self.check.judges == EVERY_SEED

    @property
    def described_value(self) -> str:
        """Value of the metric in the unit of the check, or the reason for its absence."""
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
            value_text = format_interval(value, self.half_width / scale, unit)
        else:
            value_text = format_number(value, unit, _distinguishing_digits(value, limit))
        return f"with {value_text}{self._described_seeds}{self._described_draws}"

    @property
    def _described_draws(self) -> str:
        """What the value is over the draws of a fit, such as `, the worst of 64 draws`."""
        if self.is_quantile_of_draws:
            fail = f" ({self.failed} fail)" if self.failed else ""
            return f", {self.check.judges} of {self._many}{fail}"
        is_worst = self.of_draws and self.cases > 1 and not self._fails_in_cases
        return f", the worst of {self._many}" if is_worst else ""

    @property
    def _described_seeds(self) -> str:
        """What the value is over several seeds, such as `, mean of 20 seeds (3 fail)`."""
        if self.seeds == 1:
            return ""
        if self.check.judges == EVERY_SEED:
            worst = "" if self.worst_seed is None else f" for seed {self.worst_seed}"
            if self._fails_in_cases:  # whose worst is named, as is its worst seed
                return f" over {self.seeds} seeds{worst and f',{worst}'}"
            return worst if self._fails_in_seeds else f", the worst of {self.seeds} seeds"
        fail = f" ({self.failed_seeds} fail)" if self.failed_seeds else ""
        return f", {self.check.judges} of {self.seeds} seeds{fail}"

    @property
    def named_point(self) -> Point:
        """Swept keys of the case to name: of draws only one whose value is unknown."""
        return {} if self.of_draws and not self.reason else self.where or {}

    @property
    def place(self) -> str:
        """The case that decided, such as ` at excitation.frequency = 8`."""
        point = self.named_point.items()
        values = [f"{key} = {format_number(value, digits=6)}" for key, value in point]
        return f" at {', '.join(values)}" if values else ""


USUAL_DIGITS, MAX_DIGITS = 6, 17
"""Digits of a value beside the limit of its check, and most digits to distinguish the two."""


def _distinguishing_digits(value: float, limit: float) -> int:
    """Return the digits needed to distinguish a value from a limit that it does not equal."""
    digits = USUAL_DIGITS
    while (
        value != limit
        and digits < MAX_DIGITS
        and format_number(value, digits=digits) == format_number(limit, digits=digits)
    ):
        digits += 1
    return digits


def violation(verdict: Verdict) -> float:
    """Return by how much a case violates its check; infinite for an unknown value."""
    if verdict.value is None or math.isnan(verdict.value):
        return math.inf
    return float(verdict.check.excess(verdict.value))


@dataclass(frozen=True)
class Condition:
    """Condition on a scenario key, which restricts where a check applies."""

    key: str
    """Dotted key, such as `excitation.frequency`."""
    op: str
    """One of < <= > >= and ==."""
    limit: float
    """Limit in the SI unit of the key."""
    here: float | None = None
    """Value of the key in the scenario itself, used where it is not swept."""

    def holds(self, point: Point) -> bool:
        """Whether a point satisfies the condition."""
        value = point.get(self.key, self.here)
        return value is not None and bool(COMPARISONS[self.op](value, self.limit))


def has_condition(text: object) -> bool:
    """Whether a text is a check with `at`."""
    return isinstance(text, str) and AT_PATTERN.search(text) is not None


def parse_conditions(text: str, units: Mapping[str, str] | None) -> tuple[Condition, ...]:
    """Parse the conditions after `at`, joined by `and`; `units` as in `Check.parse`."""
    return tuple(_parse_condition(part, units) for part in re.split(r"\sand(?=\s|$)", text))


def _parse_condition(text: str, units: Mapping[str, str] | None) -> Condition:
    """Parse one condition."""
    if _STATUS_OK_PATTERN.fullmatch(text):
        # Cases carry the code of their status; that of `ok` is 0.
        return Condition(STATUS, "==", 0.0, here=0.0)
    form = _CONDITION_PATTERN.fullmatch(text)
    if form is None:
        text_given = f"at{text}" if text.strip() else "at"
        example = "at excitation.frequency >= 8"
        raise ValueError(
            f"write `at key >= value`, such as `{example}`, not {format_value(text_given)}"
        )
    key, op = form["key"], form["op"]
    if units is not None and key not in units:
        hint = did_you_mean(
            next((other for other in units if _is_similar_key(key, other)), None)
        )
        raise ValueError(
            f"{format_value(key)} after `at` is not a numeric key of this scenario{hint}"
        )
    check_operator(op)
    return Condition(key, op, parse_limit(form["limit"], units[key] if units else ""))


def _is_similar_key(key: str, other: str) -> bool:
    """Whether a dotted key may be a misspelling of another, part by part."""
    pairs = list(zip_longest(key.split("."), other.split("."), fillvalue=""))
    return all(a == b or closest_match(a, [b]) for a, b in pairs)


def known_metric(name: str) -> str:
    """Return the name of a metric; raise ValueError for an unknown one."""
    if name not in UNITS:
        raise ValueError(f"unknown metric {format_value(name)}{name_hint(name, UNITS)}")
    return name


def check_operator(op: str) -> None:
    """Raise ValueError for an unknown comparison."""
    if op not in COMPARISONS:
        raise ValueError(f"unknown comparison `{op}`; use one of {' '.join(COMPARISONS)}")


def parse_limit(text: str, unit: str) -> float:
    """Return the limit of a comparison [unit]; raise ValueError if it is not finite."""
    value = convert(text, unit)
    if not math.isfinite(value):
        raise ValueError(f"must compare with a finite number, not {format_value(text)}")
    return value
