"""Comparison of approaches and friction laws on the same base motion.

The last name is the reference: all others are compared with it, case by case. `viscous`, the
oscillator without dry friction, is always added. The verdict gives the range in which an
approach agrees with the reference and, where it does not, a diagnosis from further
computations: parasitic vibration of fixed steps, a step that is too long, or a regularisation
that is too soft.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, log2
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeGuard

import numpy as np

from drysim.approach import APPROACHES_BY_NAME
from drysim.approach.solution import FIXED_STEP, Response
from drysim.approach.stick_slip import ExactApproach
from drysim.errors import SolverError, UsageError, WarningMessage
from drysim.messages import closest_match, shorten
from drysim.metrics.checks import Verdict
from drysim.metrics.table import PEAK_STROKE
from drysim.metrics.text import label_of
from drysim.scenario.axes import FILE_KEY, Axis
from drysim.scenario.laws import LAWS
from drysim.scenario.model import Scenario
from drysim.scenario.text import describe_cases, describe_range
from drysim.study.case import Case
from drysim.study.outcome import Result, format_repr
from drysim.study.plan import Plan
from drysim.study.preparation import (
    prepare,
    refuse_direction,
    refuse_interval,
    require_scenario,
)
from drysim.study.run import MotionCache, response_of, scenario_at, try_measure
from drysim.study.statistics import OK, BatchCallback, Row, Rows, ignore_batch, interval
from drysim.study.table import Table
from drysim.study.warnings import format_at
from drysim.wording import Point, format_deviation, format_number, format_percent, join_words


@dataclass(frozen=True, eq=False)
class Comparison(Result):
    """Several approaches, or friction laws, on the same base motion.

    Attributes
    ----------
    table : Table
        One row per name and case; `approach` of a row is the name.
    reference : str
        Name of the reference.
    responses : mapping
        Response of each approach in one case, for a picture of the motion.
    shown : mapping
        Swept values of this case; empty without a sweep.
    verdict : tuple of str
        Findings in sentences, the most important one first.
    laws : mapping
        Friction law of each name; empty for none.
    """

    kind: ClassVar[str] = "comparison"

    table: Table
    reference: str
    responses: Mapping[str, Response]
    shown: Point
    verdict: tuple[str, ...]
    laws: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return the names and the first sentence of the verdict in one line."""
        names = f"{', '.join(self.table.approaches)} against {self.reference}"
        return format_repr("Comparison", self.table.scenario.name, names, *self.verdict[:1])

    @property
    def scenario(self) -> Scenario:
        """The scenario of the reference."""
        return self.table.scenario

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """Verdicts on the checks, by the reference."""
        return self.table.checks

    @property
    def warnings(self) -> tuple[WarningMessage, ...]:
        """Warnings about all cases."""
        return self.table.warnings

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed in a case."""
        return self.table.has_failed_cases

    @property
    def of_laws(self) -> bool:
        """Whether any of the names is a friction law."""
        return any(name == law for name, law in self.laws.items())

    def counterpart(self, row: Row) -> Row | None:
        """Return the row of the reference at the same point; None if there is not exactly one.

        Keys that the reference does not use are ignored.
        """
        return self._reference_rows.get(_point_key(row, self._reference_keys))

    def deviation(self, row: Row) -> float | None:
        """Return T_a of a row relative to the reference at the same point, minus 1 [-].

        With several seeds, it is the mean of the deviations seed by seed.

        Raises
        ------
        UsageError
            When `row` is not a row of the table.
        """
        if not isinstance(row, Row) or row != self._rows.get(_row_key(row)):
            received = shorten(repr(row))
            raise UsageError(f"expected a row of the table, not {received}")
        deviation = self.off(row)
        return deviation[0] if deviation else None

    def off(self, row: Row) -> tuple[float, float | None] | None:
        """Return the deviation of a row and, for a mean, the half-width of its interval."""
        other = self.counterpart(row)
        return relative_deviation(row, other) if other else None

    def pairs(self, approach: str) -> Iterator[tuple[Row, Row]]:
        """Yield each row of an approach with the row of the reference at the same point.

        If the approach does not use a key of the reference, one row has several partners.
        """
        rows = list(self.table.of(approach))
        keys: Set[str] = rows[0].point.keys() if rows else frozenset()
        if not self._reference_keys - keys:
            partners = ((row, self.counterpart(row)) for row in rows)
            yield from ((row, other) for row, other in partners if other is not None)
            return
        places = {_point_key(row, keys): row for row in rows}
        for other in self.table.of(self.reference):
            if (row := places.get(_point_key(other, keys))) is not None:
                yield row, other

    @cached_property
    def _rows(self) -> dict[tuple[str, frozenset[tuple[str, float]]], Row]:
        return {_row_key(row): row for row in self.table.rows}

    @cached_property
    def _reference_keys(self) -> Set[str]:
        first = next(iter(self.table.of(self.reference)), None)
        return frozenset(first.point if first else ())  # a view of keys cannot be pickled

    @cached_property
    def _reference_rows(self) -> dict[frozenset[tuple[str, float]], Row]:
        rows = self.table.of(self.reference)
        return {_point_key(row, self._reference_keys): row for row in rows}


def relative_deviation(row: Row, other: Row) -> tuple[float, float | None] | None:
    """Return T_a of a row relative to another, minus 1 [-], and the half-width of its interval.

    None if T_a is unknown; the half-width is None without seeds.
    """
    if row.over and other.over:
        pairs = zip(row.over.values["T_a"], other.over.values["T_a"], strict=False)
        deviations = [
            value / theirs - 1.0 for value, theirs in pairs if value is not None and theirs
        ]
        return interval(deviations) if deviations else None
    value, theirs = row.metrics.get("T_a"), other.metrics.get("T_a")
    return (value / theirs - 1.0, None) if value is not None and theirs else None


def _row_key(row: Row) -> tuple[str, frozenset[tuple[str, float]]]:
    """Return a key that identifies a row of a table."""
    return row.approach, frozenset(row.point.items())


def _point_key(row: Row, keys: Collection[str]) -> frozenset[tuple[str, float]]:
    """Return the point of a row, restricted to some keys."""
    return frozenset((key, value) for key, value in row.point.items() if key in keys)


KNOWN_NAMES = (*APPROACHES_BY_NAME, *LAWS)
"""Names for a comparison: an approach (to the law of the scene), or a law (solved exactly)."""


def parse_names(text_or_names: str | Sequence[str]) -> tuple[str, ...]:
    """Return the approaches and laws of a list or a text; the word `vs` is ignored.

    Raises
    ------
    UsageError
        When a name is unknown or repeated, or there are fewer than two.
    """
    received = [text_or_names] if isinstance(text_or_names, str) else text_or_names
    if not isinstance(received, Sequence) or not all(
        isinstance(word, str) for word in received
    ):
        shown = shorten(repr(text_or_names))
        raise UsageError(
            f"expected names, such as `signum vs stick-slip`, or a list of them, not {shown}"
        )
    names = [name for word in received for name in word.split() if name != "vs"]
    for name in names:
        if name not in KNOWN_NAMES:
            nearest = closest_match(name, KNOWN_NAMES)
            names_by_kind = (
                f"approaches are {', '.join(APPROACHES_BY_NAME)}; laws are {', '.join(LAWS)}"
            )
            hint = f"did you mean `{nearest}`?" if nearest else names_by_kind
            if Path(name).suffix in (".yaml", ".yml"):
                hint = f"name the scenario last: `drysim compare signum vs stick-slip {name}`"
            raise UsageError(f"unknown approach or friction law `{name}`", hint)
        if names.count(name) > 1:
            raise UsageError(
                f"`{name}` is named twice", "compare it with another approach or law"
            )
    if len(names) < 2:
        others = ", ".join(name for name in KNOWN_NAMES if name not in names)
        raise UsageError(
            "a comparison needs two approaches or laws, such as `signum vs stick-slip`",
            f"{'add one' if names else 'give two'} of {others}",
        )
    return tuple(names)


def compare(
    scenario: Scenario,
    names: str | Sequence[str] = (),
    *more: str,
    workers: int | None = None,
    finished: BatchCallback = ignore_batch,
) -> Comparison:
    """Compare several approaches, or friction laws, on one scenario.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block, each of its cases is compared.
    names : str or sequence of str
        Approaches and friction laws, such as `"signum vs stick-slip"` or a list of them; the
        last is the reference. `viscous` is added.
    *more : str
        Further names, as in `compare(scenario, "signum", "stick-slip")`.
    workers : int, optional
        Number of workers.
    finished : callable, optional
        As in `sweep`.

    Returns
    -------
    Comparison

    Raises
    ------
    UsageError
        When a name is unknown or repeated, there are fewer than two, or `scenario` is not a
        Scenario.
    ScenarioError
        When the scenario lacks a key of a law.
    """
    require_scenario(scenario)
    if more:
        names = [*([names] if isinstance(names, str) else names), *more]
    names = parse_names(names)
    case = prepare(scenario.variant(names[-1]), compared=True, swept=True)
    return solve(scenario, case, names, workers=workers, finished=finished)


def solve(
    scenario: Scenario,
    case: Case,
    names: Sequence[str],
    *,
    workers: int | None = None,
    finished: BatchCallback = ignore_batch,
) -> Comparison:
    """Compare as `compare` does, with the case of the reference already prepared."""
    from drysim.study.sweep import (  # not needed to read a comparison
        choose_engine,
        make_table,
        on_workers,
    )

    reference, scenarios = names[-1], scenarios_by_name(scenario, names)
    compared = list(scenarios.values())
    choose_engine(case, compared)
    with on_workers(workers) as execute:
        solved = execute(Plan.of(compared, case), case, None, finished)
        batches = [batch for _, batch in solved]
    omissions = [
        WarningMessage("left-out", sentence)
        for name in scenarios
        for sentence in scenario.omissions(name)
    ]
    table = make_table(scenario, case, Rows(batches), omissions)
    shown = most_deviating_row(table, names, reference)
    responses = dict(responses_at(shown.point, scenarios, reference))
    laws = {
        name: variant.active_friction.law if variant.active_friction else ""
        for name, variant in scenarios.items()
    }
    comparison = Comparison(table, reference, responses, shown.point, (), laws)
    return replace(comparison, verdict=diagnose(comparison, scenarios))


def scenarios_by_name(scenario: Scenario, names: Sequence[str]) -> dict[str, Scenario]:
    """Return the scenario for each name; `viscous` is always included.

    Raises
    ------
    ScenarioError
        When the scenario is swept up or down, its static ratio is an interval, or it lacks a
        key of a law.
    """
    refuse_direction(scenario, "drysim compare")
    refuse_interval(scenario)
    return {name: scenario.variant(name) for name in dict.fromkeys((*names, "viscous"))}


def most_deviating_row(table: Table, names: Sequence[str], reference: str) -> Row:
    """Return the row of the reference where the first name that deviates does so most."""
    comparison = Comparison(table, reference, {}, {}, ())
    for name in names:
        worst = largest_deviation(deviations(comparison, name))
        if worst is not None and worst.value:
            return comparison.counterpart(worst.row) or worst.row
    first = next(iter(table.of(names[0])))
    return comparison.counterpart(first) or first


def responses_at(
    point: Point, scenarios: Mapping[str, Scenario], reference: str
) -> Iterator[tuple[str, Response]]:
    """Yield the responses at one point, without approaches whose numerics fail there.

    Raises
    ------
    SolverError
        When the numerics of the reference fail.
    """
    for name, scenario in scenarios.items():
        try:
            yield name, response_of(scenario_at(scenario, point))
        except SolverError:
            if name == reference:
                raise


# Deviations.


class Deviation(NamedTuple):
    """T_a of a row relative to the reference at the same point, minus 1 [-].

    The row is whichever of the two has more swept keys. With several seeds, `value` is a mean
    and `half_width` that of its confidence interval.
    """

    value: float
    row: Row
    half_width: float | None = None


def deviations(comparison: Comparison, approach: str) -> list[Deviation]:
    """Return the deviations of an approach wherever T_a is known."""
    judged = judge(comparison, approach)
    return [
        Deviation(judgement.T_a[0], judgement.row, judgement.T_a[1])
        for judgement in judged
        if judgement.T_a is not None
    ]


def largest_deviation(several: Sequence[Deviation]) -> Deviation | None:
    """Return the deviation with the largest magnitude; the first one of several."""
    return max(several, key=lambda deviation: abs(deviation.value), default=None)


# Range of agreement, and coinciding curves.

AGREEMENT_TOLERANCE = 0.05
"""Deviation of a judged metric up to which two approaches agree [-]."""

MAX_LISTED_CASES = 5
"""Number of cases up to which each is listed if they are not adjacent."""


JUDGED_METRICS = (PEAK_STROKE, "SEAT")
"""Metrics besides T_a in which two approaches have to agree."""

SMALL_PEAK = 0.05
"""Peaks |x_r| are compared relative to at least this share of the largest of the reference."""

MAX_CHATTER = 0.01
"""Share of chatter above which an approach agrees in no case, whatever its metrics [-]."""

CHATTER_DECIMALS = 4
"""Decimals of a share of chatter that are shown: 1.00 % does not exceed 1 %."""


class Judgement(NamedTuple):
    """How an approach and the reference compare at one point."""

    row: Row
    """Whichever of the two has more swept keys."""
    T_a: tuple[float, float | None] | None
    """Deviation of T_a and half-width, as by `relative_deviation`."""
    others: Mapping[str, float]
    """Deviation of the other judged metrics by name, where both are known [-]."""
    chatter: float
    """Share of the time in which the approach chatters [-]."""

    @property
    def agrees(self) -> bool:
        """Whether all judged metrics are within the tolerance, without chatter."""
        return self.is_within and not self.chatters

    @property
    def is_within(self) -> bool:
        """Whether all judged metrics are within the tolerance."""
        deviations = [] if self.T_a is None else [self.T_a[0], *self.others.values()]
        return bool(deviations) and max(map(abs, deviations)) <= AGREEMENT_TOLERANCE

    @property
    def chatters(self) -> bool:
        """Whether the share of chatter, as it is shown, exceeds the largest allowed one."""
        return round(self.chatter, CHATTER_DECIMALS) > MAX_CHATTER


def judge(comparison: Comparison, name: str) -> Iterator[Judgement]:
    """Yield how an approach compares with the reference at each point."""
    ends = comparison.table.tallies[comparison.reference].ends
    least = {PEAK_STROKE: SMALL_PEAK * ends.get(PEAK_STROKE, (0.0, 0.0))[1]}
    for row, other in comparison.pairs(name):
        others = {}
        for metric in JUDGED_METRICS:
            value, theirs = row.metrics.get(metric), other.metrics.get(metric)
            scale = max(theirs or 0.0, least.get(metric, 0.0))
            if not scale and metric == PEAK_STROKE:  # the reference never moves
                scale = static_deflection(comparison.table.scenario, row)
            if value is not None and theirs is not None and scale:
                others[metric] = (value - theirs) / scale
        yield Judgement(
            row if len(row.point) >= len(other.point) else other,
            relative_deviation(row, other),
            others,
            row.metrics.get("chatter_share") or 0.0,
        )


def static_deflection(scenario: Scenario, row: Row) -> float:
    """Return the deflection of the spring under m a_u [m]; 0 without a spring."""
    m, k_x, _ = scenario.oscillator.plant()
    return m * (row.metrics.get("a_u") or 0.0) / k_x if k_x > 0.0 else 0.0


def describe_others(judged: Sequence[Judgement], axes: Sequence[Axis]) -> tuple[str, str]:
    """Describe the largest deviations besides that of T_a: those beyond the tolerance, others.

    Chatter counts as a deviation.
    """
    beyond, within = [], []
    for metric in JUDGED_METRICS:
        comparable = [judgement for judgement in judged if metric in judgement.others]
        if not comparable:
            continue
        worst = max(comparable, key=lambda judgement: abs(judgement.others[metric]))
        text = f"{label_of(metric)} {format_deviation(worst.others[metric])}"
        if abs(worst.others[metric]) > AGREEMENT_TOLERANCE:
            beyond.append(f"{text}{format_at(worst.row, axes)}")
        else:
            within.append(text)
    worst = max(judged, key=lambda judgement: judgement.chatter)
    if worst.chatters:
        beyond.append(f"chatter {format_percent(worst.chatter)}{format_at(worst.row, axes)}")
    return "; ".join(beyond), ", ".join(within)


def describe_agreement(judged: Sequence[Judgement], name: str, axes: Sequence[Axis]) -> str:
    """Describe in how many cases an approach agrees with the reference, and where these are."""
    rows = [judgement.row for judgement in judged]
    good = [judgement.row for judgement in judged if judgement.agrees]
    tolerance = format_percent(AGREEMENT_TOLERANCE)
    if any(judgement.is_within and judgement.chatters for judgement in judged):
        tolerance += " and without chatter"
    if not good:
        return f"{name} agrees within {tolerance} in no case"
    where = describe_region(good, rows, axes)
    return f"{name} agrees within {tolerance} in {len(good)} of {len(rows)} cases{where}"


def describe_region(good: Sequence[Row], rows: Sequence[Row], axes: Sequence[Axis]) -> str:
    """Describe where some of all cases lie, without ranges that cover all cases."""
    ends, every = _key_ranges(good), _key_ranges(rows)
    inside = [
        row for row in rows if all(a <= row.point[key] <= b for key, (a, b) in ends.items())
    ]
    narrower = describe_range(
        {key: span for key, span in ends.items() if span != every[key]}, axes
    )
    if len(inside) == len(good):
        return f": {narrower}"
    if len(good) <= MAX_LISTED_CASES:
        varied = [key for key, (low, high) in every.items() if low < high]
        points = [{key: row.point[key] for key in varied} for row in good]
        return f": {describe_cases(points, axes)}"
    return f", all within {narrower}" if narrower else ", scattered over the whole sweep"


def _key_ranges(rows: Sequence[Row]) -> dict[str, tuple[float, float]]:
    """Return least and greatest value of each key."""
    columns = {
        key: [row.point[key] for row in rows] for key in rows[0].point if key != FILE_KEY
    }
    return {key: (min(column), max(column)) for key, column in columns.items()}


MOTION_METRICS = ("T_a", "x_r_rms", PEAK_STROKE)
"""Metrics by which curves are distinguished."""

METRIC_TOLERANCE = 1e-6
"""Relative difference of a metric that is invisible in a picture."""

MetricValues = dict[frozenset[tuple[str, float]], tuple[float | None, ...]]
"""Values of the `MOTION_METRICS` by point."""


def describe_coinciding(comparison: Comparison) -> Iterator[str]:
    """Yield the names, except the reference, whose metrics are equal in all cases."""
    groups: list[tuple[MetricValues, list[str]]] = []
    for name in comparison.table.approaches:
        if name == comparison.reference:
            continue
        metrics = _metric_values(comparison.table.of(name))
        like = (group for values, group in groups if _are_close(values, metrics))
        if group := next(like, None):
            group.append(name)
        else:
            groups.append((metrics, [name]))
    for _, group in groups:
        if len(group) > 1:
            yield f"{join_words(group)} coincide"


def _metric_values(rows: Iterable[Row]) -> MetricValues:
    """Return the compared metrics by point."""
    return {
        frozenset(row.point.items()): tuple(row.metrics.get(name) for name in MOTION_METRICS)
        for row in rows
    }


def _are_close(values: MetricValues, other: MetricValues) -> bool:
    """Whether two sets of values are equal except for rounding, and not all unknown."""
    if values.keys() != other.keys():
        return False
    columns, others = (
        np.array([metrics[place] for place in values], dtype=float)  # None becomes NaN
        for metrics in (values, other)
    )
    is_known = bool(np.isfinite(columns).any())
    return is_known and np.allclose(columns, others, METRIC_TOLERANCE, 0.0, equal_nan=True)


# Verdict in sentences, decided by further computations.

MAX_REMAINING_SHARE = 0.7
"""Share of an error that may remain with half the step: a first-order method leaves 0.5."""

MAX_ALTERNATING_CORRELATION = -0.3
"""Correlation of successive errors of x_dd below which the error alternates at every step."""

TARGET_ERROR = 0.01
"""Error of T_a for which the required sharpness is estimated [-]."""


def diagnose(comparison: Comparison, scenarios: Mapping[str, Scenario]) -> tuple[str, ...]:
    """Return the verdict on all approaches except the reference, largest deviation first."""
    names = [name for name in scenarios if name not in (comparison.reference, "viscous")]
    largest = [(largest_deviation(deviations(comparison, name)), name) for name in names]
    deviating = [(deviation, name) for deviation, name in largest if deviation is not None]
    sentences: list[str] = []
    for deviation, name in sorted(deviating, key=lambda pair: -abs(pair[0].value)):
        sentences += describe_approach(comparison, scenarios, name, deviation)
    sentences += describe_unknown(
        comparison, [name for deviation, name in largest if deviation is None]
    )
    sentences += describe_coinciding(comparison)
    return (*sentences, *describe_frictionless(comparison))


def describe_approach(
    comparison: Comparison, scenarios: Mapping[str, Scenario], name: str, worst: Deviation
) -> Iterator[str]:
    """Yield the findings about one approach, in the case where it deviates most."""
    deviation, row, _ = worst
    reference, exact = comparison.reference, comparison.counterpart(row)
    axes = comparison.table.axes
    place = format_at(row, axes)
    if is_same_solution(scenarios[name], scenarios[reference]):
        law = comparison.laws[name]
        yield (
            f"{name} and {reference} are the same here: the law of the scene is {law}, solved "
            "by stick-slip"
        )
        return
    judged = list(judge(comparison, name))
    reference_label = describe_reference(comparison)
    T_a_deviation = f"T_a {format_deviation(deviation)}{place}"
    beyond, within = describe_others(judged, axes)
    limits = reference_limits(comparison)
    if abs(deviation) <= AGREEMENT_TOLERANCE and not beyond:
        also = f"; {within}" if within else ""
        yield f"{name} agrees with {reference_label}: {T_a_deviation}{also}"
    else:
        # With another law, or an inexact reference, a deviation is no error of the approach.
        is_error = not limits and comparison.laws.get(name) != name
        verb, also = "deviates" if is_error else "differs", f"; {beyond}" if beyond else ""
        yield f"{name} {verb} from {reference_label}: {T_a_deviation}{also}{limits}"
        if len(judged) > 1:
            yield describe_agreement(judged, name, axes)
    if exact is None or limits:
        return
    case = scenario_at(scenarios[name], row.point)
    response = response_of(case)
    if response.numerics.core != FIXED_STEP:
        return
    correlation = error_correlation(response, response_of(scenarios[reference].at(exact.point)))
    if correlation < MAX_ALTERNATING_CORRELATION and abs(deviation) > AGREEMENT_TOLERANCE:
        yield (
            f"the error of {name} is parasitic vibration with period 2Δt = "
            f"{format_number(2 * response.dt, 's')}: where the mass should stick, the friction "
            f"force of {format_number(row.F_fk, 'N')} changes sign with each step"
        )
    metric, deviation = largest_error(row, exact, deviation)
    if abs(deviation) > TARGET_ERROR:
        # With several seeds, the first one is computed.
        value = exact.over.values[metric][0] if exact.over else exact.metrics[metric]
        yield from describe_remedies(case, name, metric, deviation, value)


def largest_error(row: Row, exact: Row, T_a_deviation: float) -> tuple[str, float]:
    """Return the metric that a remedy has to correct, and its deviation in a case.

    It is T_a, or SEAT where the scenario has a weighting and SEAT deviates more.
    """
    value, reference = (each.metrics.get("SEAT") for each in (row, exact))
    seat = value / reference - 1.0 if value is not None and reference else 0.0
    return ("SEAT", seat) if abs(seat) > abs(T_a_deviation) else ("T_a", T_a_deviation)


def is_same_solution(scenario: Scenario, other: Scenario) -> bool:
    """Whether two scenarios have the same law and the same approach."""
    return (
        scenario.solver.member() == other.solver.member()
        and scenario.active_friction == other.active_friction
    )


def reference_limits(comparison: Comparison) -> str:
    """Return why a deviation from the reference may be no error; "" if it is exact."""
    reference, scenario = comparison.reference, comparison.table.scenario
    variant = scenario.variant(reference)
    if omissions := scenario.omissions(reference):
        return f"; {'; '.join(omissions)}"
    if variant.friction is None and scenario.friction is not None:
        return f"; {reference} ignores dry friction"
    if not isinstance(variant.solver.member(), ExactApproach):
        return f"; {reference} uses fixed steps and has errors of its own"
    return ""


def describe_reference(comparison: Comparison) -> str:
    """Return the name of the reference, with its law if laws are compared."""
    reference, law = comparison.reference, comparison.laws.get(comparison.reference)
    names_law = comparison.of_laws and law not in (None, "", reference)
    return f"{reference} ({law})" if names_law else reference


def error_correlation(response: Response, exact: Response) -> float:
    """Return the lag-1 autocorrelation of the error of x_dd; -1 if its sign alternates."""
    last = min(response.t[-1], exact.t[-1])
    t = response.t[response.t <= last]
    error = response.x_dd[: len(t)] - np.interp(t, exact.t, exact.x_dd)
    error -= error.mean()
    power = float(np.dot(error, error))
    return float(np.dot(error[1:], error[:-1])) / power if power else 0.0


def describe_remedies(
    case: Scenario, name: str, metric: str, deviation: float, value: float | None
) -> Iterator[str]:
    """Yield whether half the step, or twice the sharpness, reduces the deviation of a metric.

    `value` is that of the reference.
    """
    step, chosen = case.solver.step, case.solver.member()
    if step is not None:
        finer = deviation_with(case, {"step": 0.5 * step}, metric, value)
        if is_reduced(finer, deviation):
            left, whole = format_deviation(finer), format_deviation(deviation)
            yield f"half the step of {name} leaves {metric} {left} instead of {whole}"
        elif finer is not None and abs(deviation) > AGREEMENT_TOLERANCE:
            halved, left = format_number(0.5 * step, "s"), format_deviation(finer)
            yield f"a smaller step does not help {name}: {halved} leaves {metric} {left}"
    sharpness = getattr(chosen, "sharpness", None)
    if sharpness is not None:
        doubled = chosen.model_copy(update={"sharpness": 2 * sharpness})
        sharper = deviation_with(case, {name: doubled}, metric, value)
        if is_reduced(sharper, deviation):
            order = log2(abs(deviation / sharper)) if sharper else inf
            needed = sharpness * (abs(deviation) / TARGET_ERROR) ** (1 / order)
            yield (
                f"{name} needs a sharpness of about {format_number(needed, 's/m', 2)} for an "
                f"error of {format_percent(TARGET_ERROR)} in {metric}"
            )
        elif sharper is not None and abs(deviation) > AGREEMENT_TOLERANCE:
            twice, left = format_number(2 * sharpness, "s/m"), format_deviation(sharper)
            yield f"a sharper {name} does not help: {twice} leaves {metric} {left}"


def is_reduced(left: float | None, deviation: float) -> TypeGuard[float]:
    """Whether the remaining deviation is at most `MAX_REMAINING_SHARE` of the original one."""
    return left is not None and abs(left) <= MAX_REMAINING_SHARE * abs(deviation)


def deviation_with(
    case: Scenario, change: Mapping[str, Any], metric: str, reference: float | None
) -> float | None:
    """Return the deviation of a metric with changed solver options; None if it fails."""
    solver = case.solver.model_copy(update=dict(change))
    variant = case.model_copy(update={"solver": solver})
    (metrics, _, _), _ = try_measure(variant, MotionCache().of)
    value = metrics.get(metric)
    return value / reference - 1.0 if value is not None and reference else None


def describe_unknown(comparison: Comparison, names: Sequence[str]) -> Iterator[str]:
    """Yield for which names T_a is unknown, and why."""
    reference = comparison.reference
    if names and (reason := unknown_reason(comparison, reference)):
        yield f"T_a of {reference}, the reference, is unknown: {reason}"
        return
    for name in names:
        reason = unknown_reason(comparison, name)
        where = f": {reason}" if reason else f" where that of {reference} is known"
        yield f"T_a of {name} is unknown{where}"


def unknown_reason(comparison: Comparison, name: str) -> str:
    """Return why T_a is unknown in all cases of a name; "" if it is known in any case."""
    rows = list(comparison.table.of(name))
    if any(row.metrics.get("T_a") is not None for row in rows):
        return ""
    lost = (f"{row.status}; {row.note}".removesuffix("; ") for row in rows if row.status != OK)
    return next(lost, "the base does not move")


def describe_frictionless(comparison: Comparison) -> Iterator[str]:
    """Yield the effect of dry friction on T_a, where one case is compared."""
    if comparison.table.axes or comparison.reference == "viscous":
        return
    by_name = {row.approach: row.metrics.get("T_a") for row in comparison.table.rows}
    frictionless, exact = by_name.get("viscous"), by_name.get(comparison.reference)
    if frictionless and exact and format_number(frictionless) != format_number(exact):
        without, dry = format_number(frictionless), format_number(exact)
        yield f"without dry friction T_a would be {without} instead of {dry}"
