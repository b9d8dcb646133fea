"""Compare: what approaches and laws make of one base motion, how far apart they are, and why.

The last word is the yardstick that all others are held against, case by case; `viscous` is
always compared, too. A comparison tells where the words agree, and its verdict says in
sentences, each decided by computing, what ails those that do not: vibration that fixed steps
bring in, too long a step, too soft a friction law.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, log2, nan
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from drysim.approach import APPROACHES_BY_NAME
from drysim.approach.solution import FIXED_STEP, Response
from drysim.approach.stick_slip import ExactApproach
from drysim.errors import SolverError, UsageError, WarningMessage
from drysim.scenario.axes import Axis
from drysim.scenario.model import Scenario
from drysim.scenario.reading import LAWS
from drysim.study.case import Case, prepare, require_scenario
from drysim.study.outcome import format_repr
from drysim.study.run import MotionCache, response_of, scenario_at, try_measure
from drysim.study.statistics import OK, BatchCallback, Row, Rows, ignore_batch, interval
from drysim.study.table import Table, Tally
from drysim.study.warnings import format_at
from drysim.units import closest_match, shorten
from drysim.wording import (
    describe_cases,
    describe_range,
    format_number,
    format_percent,
    join_words,
)


@dataclass(frozen=True, eq=False)
class Comparison:
    """Several approaches, or friction laws, on the very same base motion.

    Attributes
    ----------
    table : Table
        One row for each word and case; a row's approach is the word.
    yardstick : str
        The word that the others are measured against.
    responses : mapping
        Response of each approach for one case, for a picture of the motion itself.
    shown : mapping
        The swept values of that case; empty without a sweep.
    verdict : tuple of str
        What the comparison says, in sentences; the first is the verdict itself.
    laws : mapping
        The friction law behind each word; empty for none.
    """

    table: Table
    yardstick: str
    responses: Mapping[str, Response]
    shown: Mapping[str, float]
    verdict: tuple[str, ...]
    laws: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Give the verdict, in a line."""
        words = f"{', '.join(self.table.approaches)} against {self.yardstick}"
        return format_repr("Comparison", self.table.scenario.name, words, *self.verdict[:1])

    @property
    def of_laws(self) -> bool:
        """Whether any of the words is a friction law."""
        return any(word == law for word, law in self.laws.items())

    def counterpart(self, row: Row) -> Row | None:
        """Give the yardstick's row at the same point; None where there is no single one.

        A key that the yardstick has no use for takes no part.
        """
        return self._reference_rows.get(_point_key(row, self._reference_keys))

    def deviation(self, row: Row) -> float | None:
        """Give T_a of a row relative to the yardstick's at the same point, minus 1 [-].

        Of many seeds it is the mean over those that both have, compared seed by seed.
        """
        if not isinstance(row, Row) or row != self._rows.get(_row_key(row)):
            received = shorten(repr(row))
            raise UsageError(f"a deviation is that of a row of the table, not of {received}")
        found = self.off(row)
        return found[0] if found else None

    def off(self, row: Row) -> tuple[float, float | None] | None:
        """Give the deviation of a row and, of a mean, the half-width of its interval."""
        other = self.counterpart(row)
        return relative_deviation(row, other) if other else None

    def pairs(self, approach: str) -> Iterator[tuple[Row, Row]]:
        """Give the rows of an approach, each with the yardstick's row at the same point.

        Where the approach has no use for a key of the yardstick, its row stands for many.
        """
        own = list(self.table.of(approach))
        keys: Set[str] = own[0].point.keys() if own else frozenset()
        if not self._reference_keys - keys:
            found = ((row, self.counterpart(row)) for row in own)
            yield from ((row, other) for row, other in found if other is not None)
            return
        places = {_point_key(row, keys): row for row in own}
        for other in self.table.of(self.yardstick):
            if (row := places.get(_point_key(other, keys))) is not None:
                yield row, other

    @cached_property
    def _rows(self) -> dict[tuple[str, frozenset[tuple[str, float]]], Row]:
        return {_row_key(row): row for row in self.table.rows}

    @cached_property
    def _reference_keys(self) -> Set[str]:
        return next((row.point.keys() for row in self.table.of(self.yardstick)), frozenset())

    @cached_property
    def _reference_rows(self) -> dict[frozenset[tuple[str, float]], Row]:
        rows = self.table.of(self.yardstick)
        return {_point_key(row, self._reference_keys): row for row in rows}


def relative_deviation(row: Row, other: Row) -> tuple[float, float | None] | None:
    """Give T_a of a row relative to another's, minus 1 [-], and the half-width of its interval.

    None where T_a is not known; no half-width where it is no mean over seeds.
    """
    if row.over and other.over:
        pairs = zip(row.over.T_a, other.over.T_a, strict=False)
        found = [own / theirs - 1.0 for own, theirs in pairs if own is not None and theirs]
        return interval(found) if found else None
    own, theirs = row.metrics.get("T_a"), other.metrics.get("T_a")
    return (own / theirs - 1.0, None) if own is not None and theirs else None


def _row_key(row: Row) -> tuple[str, frozenset[tuple[str, float]]]:
    """Give what tells a row of a table from all others."""
    return row.approach, frozenset(row.point.items())


def _point_key(row: Row, keys: Collection[str]) -> frozenset[tuple[str, float]]:
    """Give what a row is at, as far as some keys tell."""
    return frozenset((key, value) for key, value in row.point.items() if key in keys)


KNOWN_NAMES = (*APPROACHES_BY_NAME, *LAWS)
"""What a comparison may name: an approach to the scene's law, or a law to be solved exactly."""


def parse_names(words: str | Sequence[str]) -> tuple[str, ...]:
    """Give the approaches and laws that words name, in a list or in one text; `vs` is dropped.

    Raises
    ------
    UsageError
        When a word is neither, is named twice, or there are fewer than two.
    """
    received = [words] if isinstance(words, str) else words
    if not isinstance(received, Sequence) or not all(
        isinstance(word, str) for word in received
    ):
        text = shorten(repr(words))
        raise UsageError(
            f"a comparison takes words, such as `signum vs stick-slip`, or a list, not {text}"
        )
    names = [name for word in received for name in word.split() if name != "vs"]
    for name in names:
        if name not in KNOWN_NAMES:
            nearest = closest_match(name, KNOWN_NAMES)
            known = (
                f"approaches are {', '.join(APPROACHES_BY_NAME)}; laws are {', '.join(LAWS)}"
            )
            hint = f"did you mean `{nearest}`?" if nearest else known
            if Path(name).suffix in (".yaml", ".yml"):
                hint = f"name a file by its option, `--scenario {name}`"
            raise UsageError(f"there is no approach or friction law `{name}`", hint)
        if names.count(name) > 1:
            raise UsageError(f"`{name}` is named twice", "compare it with another word")
    if len(names) < 2:
        others = ", ".join(name for name in KNOWN_NAMES if name not in names)
        raise UsageError(
            "a comparison needs two approaches or laws, such as `signum vs stick-slip`",
            f"add one of {others}",
        )
    return tuple(names)


def compare(
    scenario: Scenario,
    names: str | Sequence[str],
    *,
    workers: int | None = None,
    finished: BatchCallback = ignore_batch,
) -> Comparison:
    """Give what several approaches, or friction laws, make of one scenario.

    Parameters
    ----------
    scenario : Scenario
        With a sweep block, every case of it is compared.
    names : str or sequence of str
        Approaches and friction laws, such as `"signum vs stick-slip"` or a list of them; the
        last is the yardstick. `viscous` is added.
    workers : int, optional
        Threads.
    finished : callable, optional
        As in `sweep`.

    Returns
    -------
    Comparison

    Raises
    ------
    UsageError
        When a name is neither, stands there twice, or there are fewer than two; or when it is
        no scenario.
    ScenarioError
        When the scenario lacks a key of a law.
    """
    names = parse_names(names)
    require_scenario(scenario)
    case = prepare(scenario.variant(names[-1]), compared=True)
    return solve(scenario, case, names, workers=workers, finished=finished)


def solve(
    scenario: Scenario,
    case: Case,
    names: Sequence[str],
    *,
    workers: int | None = None,
    finished: BatchCallback = ignore_batch,
) -> Comparison:
    """Compare where the yardstick's case is ready to be solved; otherwise as `compare` does."""
    from drysim.study.sweep import (  # readers of a comparison need none
        choose_engine,
        make_table,
        solve_ranges,
    )

    yardstick, scenarios = names[-1], scenarios_by_name(scenario, names)
    compared = list(scenarios.values())
    choose_engine(case, compared)
    batches = [batch for _, batch in solve_ranges(compared, case, workers, finished=finished)]
    tallies = Tally.of(batches, scenario.checks, yardstick)
    left_out = (sentence for name in scenarios for sentence in scenario.omissions(name))
    omissions = [WarningMessage("left-out", sentence) for sentence in left_out]
    table = make_table(scenario, case, Rows.of(batches), tallies, omissions)
    shown = most_deviating_row(table, names, yardstick)
    responses = dict(responses_at(shown.point, scenarios, yardstick))
    laws = {
        name: one.active_friction.law if one.active_friction else ""
        for name, one in scenarios.items()
    }
    bare = Comparison(table, yardstick, responses, shown.point, (), laws)
    return replace(bare, verdict=diagnose(bare, scenarios))


def scenarios_by_name(scenario: Scenario, names: Sequence[str]) -> dict[str, Scenario]:
    """Give the scenario by every word; `viscous`, without dry friction, is always compared."""
    return {name: scenario.variant(name) for name in dict.fromkeys((*names, "viscous"))}


def most_deviating_row(table: Table, names: Sequence[str], yardstick: str) -> Row:
    """Give the yardstick's row at the worst case of the first word that is off it."""
    scale = Comparison(table, yardstick, {}, {}, ())
    for name in names:
        worst = largest_deviation(deviations(scale, name))
        if worst is not None and worst.value:
            return scale.counterpart(worst.row) or worst.row
    first = next(iter(table.of(names[0])))
    return scale.counterpart(first) or first


def responses_at(
    point: Mapping[str, float], scenarios: Mapping[str, Scenario], yardstick: str
) -> Iterator[tuple[str, Response]]:
    """Give the responses at one point; an approach whose numerics fail there has none.

    Raises
    ------
    SolverError
        When it is the yardstick that fails: there is nothing to compare with then.
    """
    for name, scenario in scenarios.items():
        try:
            yield name, response_of(scenario_at(scenario, point))
        except SolverError:
            if name == yardstick:
                raise


# At a glance: where the seat isolates, how far an approach is off and where the most.

FREQUENCY_KEY = "excitation.frequency"
"""The key over which a transmissibility is drawn and read."""


class Isolation(NamedTuple):
    """From which frequency [Hz] on T_a stays below 1; None where it does nowhere."""

    point: Mapping[str, float]
    above: float | None


def isolation_limits(rows: Iterable[Row]) -> list[Isolation]:
    """Give where isolation begins on every curve over the frequency.

    A frequency at which T_a is not known counts as one that is not isolated.
    """
    curves: dict[tuple[tuple[str, float], ...], list[Row]] = {}
    for row in rows:
        rest = tuple(item for item in row.point.items() if item[0] != FREQUENCY_KEY)
        curves.setdefault(rest, []).append(row)
    return [
        Isolation(dict(rest), _isolation_frequency(curve)) for rest, curve in curves.items()
    ]


def _isolation_frequency(curve: Sequence[Row]) -> float | None:
    """Give the frequency from which on T_a stays below 1."""
    begin = None
    for row in sorted(curve, key=lambda row: -row.point[FREQUENCY_KEY]):
        T_a = row.metrics.get("T_a")
        if T_a is None or T_a >= 1.0:
            break
        begin = row.point[FREQUENCY_KEY]
    return begin


class Deviation(NamedTuple):
    """T_a of a row relative to the yardstick's at the same point, minus 1 [-].

    The row is the one of the two that tells the point in full. Of many seeds the value is a
    mean, with half the width of its confidence interval.
    """

    value: float
    row: Row
    half_width: float | None = None


def deviations(comparison: Comparison, approach: str) -> list[Deviation]:
    """Give by how much an approach is off its yardstick, wherever both know T_a."""
    found = paired_deviations(comparison, approach)
    return [Deviation(off[0], row, off[1]) for row, off in found if off is not None]


def largest_deviation(found: Sequence[Deviation]) -> Deviation | None:
    """Give the greatest deviation, the first of its kind."""
    return max(found, key=lambda one: abs(one.value), default=None)


def paired_deviations(
    comparison: Comparison, approach: str
) -> Iterator[tuple[Row, tuple[float, float | None] | None]]:
    """Give what an approach is off by, with half of its interval, at every point.

    Each row is the one of the approach or of the yardstick that tells the point in full.
    """
    for row, other in comparison.pairs(approach):
        yield (
            row if len(row.point) >= len(other.point) else other,
            relative_deviation(row, other),
        )


# Where approaches agree: cases in which T_a is the yardstick's, and words that coincide.

AGREEMENT_TOLERANCE = 0.05
"""Deviation of T_a up to which two approaches agree [-]."""

MAX_LISTED_CASES = 5
"""Cases up to which each is named where they do not lie together."""


def describe_agreement(comparison: Comparison, name: str) -> Iterator[str]:
    """Say in how many cases an approach agrees with the yardstick, and where they lie."""
    found, axes = list(paired_deviations(comparison, name)), comparison.table.axes
    rows = [row for row, _ in found]
    good = [row for row, off in found if off is not None and abs(off[0]) <= AGREEMENT_TOLERANCE]
    if len(rows) < 2:
        return
    if not good:
        yield f"{name} agrees within {format_percent(AGREEMENT_TOLERANCE)} nowhere in this sweep"
        return
    share = f"{len(good)} of {len(rows)} cases"
    yield f"{name} agrees within {format_percent(AGREEMENT_TOLERANCE)} in {share}{describe_region(good, rows, axes)}"


def describe_region(good: Sequence[Row], rows: Sequence[Row], axes: Sequence[Axis]) -> str:
    """Give where some of all cases lie; a range that is that of all tells nothing."""
    ends, every = _key_ranges(good), _key_ranges(rows)
    inside = [
        row for row in rows if all(a <= row.point[key] <= b for key, (a, b) in ends.items())
    ]
    narrower = describe_range({key: at for key, at in ends.items() if at != every[key]}, axes)
    if len(inside) == len(good):
        return f": {narrower}"
    if len(good) <= MAX_LISTED_CASES:
        varied = [key for key, (low, high) in every.items() if low < high]
        return f": {describe_cases([{key: row.point[key] for key in varied} for row in good], axes)}"
    return f", all within {narrower}" if narrower else ", scattered over the whole sweep"


def _key_ranges(rows: Sequence[Row]) -> dict[str, tuple[float, float]]:
    """Give the least and the greatest value of every key."""
    columns = {key: [row.point[key] for row in rows] for key in rows[0].point}
    return {key: (min(column), max(column)) for key, column in columns.items()}


MOTION_METRICS = ("T_a", "x_r_rms", "x_r_peak")
"""The metrics by which words are told apart."""

METRIC_TOLERANCE = 1e-6
"""Difference of a metric, relative to it, that no picture shows."""

MetricValues = dict[frozenset[tuple[str, float]], tuple[float, ...]]


def describe_coinciding(comparison: Comparison) -> Iterator[str]:
    """Say which words but the yardstick move alike in every case: one curve hides another."""
    groups: list[tuple[MetricValues, list[str]]] = []
    for name in comparison.table.approaches:
        if name == comparison.yardstick:
            continue
        own = _metric_values(comparison.table.of(name))
        like = (words for values, words in groups if _are_close(values, own))
        if words := next(like, None):
            words.append(name)
        else:
            groups.append((own, [name]))
    for _, words in groups:
        if len(words) > 1:
            yield f"{join_words(words)} coincide"


def _metric_values(rows: Iterable[Row]) -> MetricValues:
    """Give what is compared, by where it is."""
    return {
        frozenset(row.point.items()): tuple(
            nan if (value := row.metrics.get(name)) is None else value
            for name in MOTION_METRICS
        )
        for row in rows
    }


def _are_close(one: MetricValues, other: MetricValues) -> bool:
    """Tell whether values are the same but for rounding, and not all of them unknown."""
    if one.keys() != other.keys():
        return False
    own, others = np.array([*one.values()]), np.array([other[place] for place in one])
    known = bool(np.isfinite(own).any())
    return known and np.allclose(own, others, METRIC_TOLERANCE, 0.0, equal_nan=True)


# The verdict in sentences, each decided by computing.

MAX_REMAINING_SHARE = 0.7
"""Share of an error that a halved step may leave to be a cure: first order leaves half."""

MAX_FLIP_CORRELATION = -0.3
"""Correlation of neighbouring errors of x_dd below which they flip with every step."""

TARGET_ERROR = 0.01
"""Error of T_a for which the needed sharpness is told [-]."""


def diagnose(comparison: Comparison, scenarios: Mapping[str, Scenario]) -> tuple[str, ...]:
    """Give the verdict on every approach that is not the yardstick, the worst first."""
    names = [name for name in scenarios if name not in (comparison.yardstick, "viscous")]
    found = [(largest_deviation(deviations(comparison, name)), name) for name in names]
    known = [(deviation, name) for deviation, name in found if deviation is not None]
    sentences: list[str] = []
    for deviation, name in sorted(known, key=lambda pair: -abs(pair[0].value)):
        sentences += describe_approach(comparison, scenarios, name, deviation)
    sentences += describe_unknown(
        comparison, [name for deviation, name in found if deviation is None]
    )
    sentences += describe_coinciding(comparison)
    return (*sentences, *describe_frictionless(comparison))


def describe_approach(
    comparison: Comparison, scenarios: Mapping[str, Scenario], name: str, worst: Deviation
) -> Iterator[str]:
    """Give what is to be said about one approach at the case where it deviates most."""
    deviation, row, _ = worst
    yardstick, exact = comparison.yardstick, comparison.counterpart(row)
    place = format_at(row, comparison.table.axes)
    if is_same_solution(scenarios[name], scenarios[yardstick]):
        law = comparison.laws[name]
        yield f"{name} is {yardstick} here: {law} is the law of the scene, solved by stick-slip"
        return
    if abs(deviation) <= AGREEMENT_TOLERANCE:
        yield f"{name} agrees with {describe_reference(comparison)}: T_a {format_deviation(deviation)}{place}"
    elif (limits := reference_limits(comparison)) or comparison.laws.get(name) == name:
        # A law is no error, whatever it changes; nor is what the yardstick may err in itself.
        yield f"{name} differs from {describe_reference(comparison)}: T_a {format_deviation(deviation)}{place}{limits}"
        yield from describe_agreement(comparison, name)
    else:
        yield f"{name} is off: T_a {format_deviation(deviation)} against {describe_reference(comparison)}{place}"
        yield from describe_agreement(comparison, name)
    if exact is None or reference_limits(comparison):
        return
    case = scenario_at(scenarios[name], row.point)
    response = response_of(case)
    if response.numerics.core != FIXED_STEP:
        return
    flipping = error_correlation(response, response_of(scenarios[yardstick].at(exact.point)))
    if flipping < MAX_FLIP_CORRELATION and abs(deviation) > AGREEMENT_TOLERANCE:
        yield (
            f"the error of {name} is parasitic vibration of period 2Δt = "
            f"{format_number(2 * response.dt, 's')}: where the mass should stick, friction of "
            f"{format_number(row.F_fk, 'N')} flips with every step"
        )
    if abs(deviation) > TARGET_ERROR:
        # Of many seeds the first is tried.
        T_a = exact.over.T_a[0] if exact.over else exact.metrics["T_a"]
        yield from describe_remedies(case, name, deviation, T_a)


def is_same_solution(one: Scenario, other: Scenario) -> bool:
    """Tell whether two words of a comparison mean one law under one approach."""
    return (
        one.solver.member() == other.solver.member()
        and one.active_friction == other.active_friction
    )


def reference_limits(comparison: Comparison) -> str:
    """Say why the yardstick proves no other wrong; nothing where it solves all of the scene."""
    yardstick, scenario = comparison.yardstick, comparison.table.scenario
    if omissions := scenario.omissions(yardstick):
        return f"; {'; '.join(omissions)}"
    if not isinstance(scenario.variant(yardstick).solver.member(), ExactApproach):
        return f"; {yardstick} marches by fixed steps, so that it may be off itself"
    return ""


def describe_reference(comparison: Comparison) -> str:
    """Give the yardstick; where laws are compared also the law of an approach."""
    yardstick, law = comparison.yardstick, comparison.laws.get(comparison.yardstick)
    names_law = comparison.of_laws and law not in (None, "", yardstick)
    return f"{yardstick} ({law})" if names_law else yardstick


def error_correlation(response: Response, exact: Response) -> float:
    """Give the correlation of neighbouring errors of x_dd: -1 where they flip each step."""
    last = min(response.t[-1], exact.t[-1])
    t = response.t[response.t <= last]
    error = response.x_dd[: len(t)] - np.interp(t, exact.t, exact.x_dd)
    error -= error.mean()
    power = float(np.dot(error, error))
    return float(np.dot(error[1:], error[:-1])) / power if power else 0.0


def describe_remedies(
    case: Scenario, name: str, deviation: float, T_a: float | None
) -> Iterator[str]:
    """Say whether a smaller step or a sharper function helps, by trying it."""
    step, chosen = case.solver.step, case.solver.member()
    if step is not None:
        finer, halved = (
            deviation_with(case, {"step": 0.5 * step}, T_a),
            format_number(0.5 * step, "s"),
        )
        if is_cured(finer, deviation):
            yield f"halving the step of {name} leaves {format_deviation(finer)}"
        elif finer is not None and abs(deviation) > AGREEMENT_TOLERANCE:
            yield f"a smaller step will not help {name}: at {halved} T_a is {format_deviation(finer)}"
    sharpness = getattr(chosen, "sharpness", None)
    if sharpness is not None:
        doubled = chosen.model_copy(update={"sharpness": 2 * sharpness})
        sharper, twice = (
            deviation_with(case, {name: doubled}, T_a),
            format_number(2 * sharpness, "s/m"),
        )
        if is_cured(sharper, deviation):
            order = log2(abs(deviation / sharper)) if sharper else inf
            needed = format_number(
                sharpness * (abs(deviation) / TARGET_ERROR) ** (1 / order), "s/m", 2
            )
            share = format_percent(TARGET_ERROR)
            yield f"{name} needs a sharpness of about {needed} for an error of {share}"
        elif sharper is not None and abs(deviation) > AGREEMENT_TOLERANCE:
            yield f"a sharper {name} will not help: at {twice} T_a is {format_deviation(sharper)}"


def is_cured(left: float | None, deviation: float) -> TypeGuard[float]:
    """Tell whether what a change leaves of a deviation is what first order leaves."""
    return left is not None and abs(left) <= MAX_REMAINING_SHARE * abs(deviation)


def deviation_with(
    case: Scenario, change: Mapping[str, Any], T_a: float | None
) -> float | None:
    """Give the deviation from T_a of a case whose solver is changed; None where it fails."""
    solver = case.solver.model_copy(update=dict(change))
    changed = case.model_copy(update={"solver": solver})
    metrics, _, _ = try_measure(changed, MotionCache().of)
    found = metrics.get("T_a")
    return found / T_a - 1.0 if found is not None and T_a else None


def describe_unknown(comparison: Comparison, names: Sequence[str]) -> Iterator[str]:
    """Say of which words T_a is held against no other, and why."""
    yardstick = comparison.yardstick
    if names and (reason := unknown_reason(comparison, yardstick)):
        yield f"T_a of {yardstick}, the yardstick, is not known: {reason}"
        return
    for name in names:
        reason = unknown_reason(comparison, name)
        where = f": {reason}" if reason else f" where that of {yardstick} is"
        yield f"T_a of {name} is not known{where}"


def unknown_reason(comparison: Comparison, name: str) -> str:
    """Say why no case of a word has T_a; nothing where one has."""
    rows = list(comparison.table.of(name))
    if any(row.metrics.get("T_a") is not None for row in rows):
        return ""
    lost = (f"{row.status}; {row.note}".removesuffix("; ") for row in rows if row.status != OK)
    return next(lost, "the base stands still")


def describe_frictionless(comparison: Comparison) -> Iterator[str]:
    """Say what dry friction does to the transmissibility, where one case is compared."""
    if comparison.table.axes or comparison.yardstick == "viscous":
        return
    by_name = {row.approach: row.metrics.get("T_a") for row in comparison.table.rows}
    bare, exact = by_name.get("viscous"), by_name.get(comparison.yardstick)
    if bare and exact and format_number(bare) != format_number(exact):
        yield f"without dry friction T_a would be {format_number(bare)} in place of {format_number(exact)}"


def format_deviation(value: float) -> str:
    """Give a deviation in percent with its sign."""
    return f"{100 * value:+.3g} %"
