"""A case whose static ratio F_fs/F_fk is an interval: the range of its metrics, and its jumps.

Problem
    The static limit is rarely known. With F_fs above F_fk the answer may jump where a motion
    ends or another one is reached, so two values of the ratio do not bound the metrics.

Method
    The case is solved at evenly spaced values of the ratio. Where the metrics of neighbours
    differ by more than `MAX_DIFFERENCE` of their greatest value, the interval between them is
    halved, largest differences first. A difference that is left over `MIN_WIDTH` is a jump.
    Then the intervals beside the least and the greatest value of each metric that tells motions
    apart or that a check judges are halved, until a parabola through it and its neighbours goes
    beyond it by no more than `MAX_EXCESS`.

    A run gives the table of a sweep over these values; a sweep has two rows for each case, the
    least and the greatest value of each metric. So extremes, checks, files and pictures are
    those of any other sweep.

What may be missed
    Extremes are those of the solved values. A motion that exists over less than a step between
    two values with equal metrics is not seen.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, pairwise
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import WarningMessage
from drysim.metrics.checks import Verdict
from drysim.parallel import WorkerPool
from drysim.scenario.axes import EXTREME_KEY, LEAST, Axis, decimal_linspace
from drysim.scenario.model import Scenario
from drysim.study.plan import CaseRanges, solve_range
from drysim.study.run import MotionCache
from drysim.study.statistics import OK, Row, judged_value
from drysim.study.table import JUMP_METRICS, RATIO_KEY, Jump
from drysim.wording import format_number, format_range

FIRST_VALUES, MAX_VALUES = 33, 600
"""Number of evenly spaced values of the ratio, and of all values that are solved at most."""

MAX_DIFFERENCE = 0.01
"""Difference of a metric between neighbours that is resolved no further, relative to its
greatest value [-]."""

MAX_EXCESS = 1e-5
"""Excess of a metric over the extreme of the solved values, estimated between them, that is
resolved no further, relative to its greatest value [-]."""

MIN_WIDTH = 1e-7
"""Difference of the ratio below which a difference that remains is a jump [-]."""


class Covered(NamedTuple):
    """A case over the interval: its rows by value of the ratio, and the steps left in them."""

    rows: dict[float, Row]
    steps: list[tuple[float, float]]

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Where the answer jumps."""
        narrow = sorted(step for step in self.steps if step[1] - step[0] <= MIN_WIDTH)
        return tuple(
            Jump(0.5 * (low + high), self.rows[low], self.rows[high]) for low, high in narrow
        )

    @property
    def is_resolved(self) -> bool:
        """Whether every step is known to be a jump."""
        return all(high - low <= MIN_WIDTH for low, high in self.steps)

    def extreme(self, point: Mapping[str, Any], which: str) -> Row:
        """Return a row of the least or the greatest value of each metric.

        Values of the ratio without an answer do not count, unless there is no other one.
        """
        rows = [row for row in self.rows.values() if row.status == OK]
        first = next(iter(rows or self.rows.values()))
        pick = min if which == LEAST else max
        columns = {name: [row.metrics[name] for row in rows] for name in first.metrics}
        metrics = {
            name: pick((value for value in values if value is not None), default=None)
            for name, values in columns.items()
        }
        here = {**point, EXTREME_KEY: which}
        F_fs = pick(row.F_fs for row in rows or [first])
        return replace(first, point=here, F_fs=F_fs, metrics=metrics)


def cover(
    scenario: Scenario,
    points: Sequence[Mapping[str, Any]],
    motions: MotionCache,
    pool: WorkerPool,
) -> list[Covered]:
    """Solve the cases at some points of the sweep over the interval of the static ratio.

    Parameters
    ----------
    scenario : Scenario
        With an interval.
    points : sequence of mapping
        Swept keys of each case; an empty one for a scenario without sweep.
    motions : MotionCache
    pool : WorkerPool

    Returns
    -------
    list of Covered
        For each point, with the values of the ratio in ascending order.
    """
    interval = scenario.static_interval
    assert interval is not None, "only called with an interval"
    solved: list[dict[float, Row]] = [{} for _ in points]
    left: list[list[tuple[float, float]]] = [[] for _ in points]
    first = decimal_linspace(interval.low, interval.high, FIRST_VALUES)
    pending = [(i, value) for i in range(len(points)) for value in first]
    names = dict.fromkeys([*JUMP_METRICS, *(check.metric for check in scenario.checks)])
    while pending:
        numbers, values = zip(*pending, strict=True)
        swept = at_points(scenario, [points[i] for i in numbers], values)
        solve = partial(solve_range, motions=motions)
        batches = pool.map_in_order(solve, CaseRanges([swept]), (motions,))
        for i, row in zip(numbers, chain.from_iterable(batches), strict=True):
            solved[i][row.point[RATIO_KEY]] = row
        pending = []
        for i in dict.fromkeys(numbers):
            left[i] = large_steps(solved[i])
            room = max(MAX_VALUES - len(solved[i]), 0)
            wide = [(low, high) for low, high in left[i] if high - low > MIN_WIDTH]
            wide = (wide or list(dict.fromkeys(extreme_steps(solved[i], names))))[:room]
            middles = sorted(0.5 * (low + high) for low, high in wide)
            pending += [(i, value) for value in middles]
    return [
        Covered({value: rows[value] for value in sorted(rows)}, steps)
        for rows, steps in zip(solved, left, strict=True)
    ]


def at_points(
    scenario: Scenario, points: Sequence[Mapping[str, Any]], values: Sequence[float]
) -> Scenario:
    """Return the scenario with a sweep over points with values of the ratio."""
    ends = format_range(values[0], values[-1], digits=7)
    description = f"anywhere from {ends} ({len(values)} values solved)"
    axes = [
        Axis(axis.key, axis.unit, tuple(point[axis.key] for point in points), group="zip")
        for axis in scenario.sweep
    ]
    group = "zip" if axes else ""
    ratio = Axis(RATIO_KEY, "-", tuple(values), group=group, description=description)
    return scenario.copy_with({"sweep": (*axes, ratio)})


def large_steps(rows: Mapping[float, Row]) -> list[tuple[float, float]]:
    """Return the neighbouring values whose motions differ, largest difference first."""
    scales = {
        name: max((abs(row.metrics.get(name) or 0.0) for row in rows.values()), default=0.0)
        for name in JUMP_METRICS
    } | {"stuck_share": 1.0}

    def difference(low: float, high: float) -> float:
        before, after = rows[low], rows[high]
        if before.status != OK or after.status != OK:
            return inf if before.status != after.status else 0.0
        return max(
            abs((before.metrics[name] or 0.0) - (after.metrics[name] or 0.0)) / (scale or 1.0)
            for name, scale in scales.items()
        )

    steps = {step: difference(*step) for step in pairwise(sorted(rows))}
    large = [step for step, size in steps.items() if size > MAX_DIFFERENCE]
    return sorted(large, key=lambda step: -steps[step])


def extreme_steps(
    rows: Mapping[float, Row], names: Iterable[str]
) -> Iterator[tuple[float, float]]:
    """Yield the intervals beside an extreme that a metric may exceed between solved values."""
    values = [value for value in sorted(rows) if rows[value].status == OK]
    for name in names:
        column_of_rows = [rows[value].metrics.get(name) for value in values]
        column = np.array(column_of_rows, dtype=float)
        if len(column) < 3 or not np.isfinite(column).all():
            continue
        for i in {int(column.argmin()), int(column.argmax())} - {0, len(values) - 1}:
            near = slice(i - 1, i + 2)
            x = np.array(values[near])
            excess = parabola_excess(x, column[near])
            # Beside a jump the extreme is at the jump.
            if np.diff(x).min() > MIN_WIDTH and excess > MAX_EXCESS * float(
                np.abs(column).max()
            ):
                yield values[i - 1], values[i]
                yield values[i], values[i + 1]


def parabola_excess(x: NDArray[np.float64], y: NDArray[np.float64]) -> float:
    """Return how far a parabola through three points goes beyond the middle one."""
    before, after = x[1] - x[0], x[2] - x[1]
    left, right = (y[1] - y[0]) / before, (y[2] - y[1]) / after
    curvature = (right - left) / (before + after)
    slope = left + curvature * before
    return float(abs(slope**2 / (4.0 * curvature))) if curvature else 0.0


def undecided_warnings(
    verdicts: Sequence[Verdict], rows: Mapping[float, Row]
) -> Iterator[WarningMessage]:
    """Warn of checks that hold for a part of the interval only."""
    for verdict in verdicts:
        if not 0 < verdict.failed < verdict.cases:
            continue
        check = verdict.check
        values = (
            (value, judged_value(check, row) if row.status == OK else None)
            for value, row in sorted(rows.items())
        )
        failed = [
            value for value, metric in values if metric is None or not check.holds(metric)
        ]
        low, high = (format_number(value, digits=7) for value in (failed[0], failed[-1]))
        sentence = (
            f"`{check}` is undecided: it holds for some values of {RATIO_KEY} and fails for "
            f"others, between {low} and {high}"
        )
        numbers = {"from": failed[0], "to": failed[-1]}
        yield WarningMessage("check-undecided", sentence, numbers)


def cover_warnings(covered: Sequence[Covered]) -> Iterator[WarningMessage]:
    """Warn of answers that change at too many values, and of values without an answer."""
    unresolved = [case for case in covered if not case.is_resolved]
    if unresolved:
        count = max(len(case.rows) for case in unresolved)
        cases = f" in {len(unresolved)} of {len(covered)} cases" * (len(covered) > 1)
        sentence = (
            f"the answer changes so often with {RATIO_KEY} that {count} solutions do not "
            f"resolve it{cases}: jumps may be missing; use a narrower interval"
        )
        yield WarningMessage("jumps-unresolved", sentence, {"values": count})


def unknown_warnings(covered: Sequence[Covered]) -> Iterator[WarningMessage]:
    """Warn of cases whose extremes leave out values of the ratio without an answer."""
    partly = [
        case for case in covered if len({row.status == OK for row in case.rows.values()}) > 1
    ]
    if partly:
        sentence = (
            f"in {len(partly)} of {len(covered)} cases there is no answer for some values of "
            f"{RATIO_KEY}; least and greatest values leave them out"
        )
        yield WarningMessage("interval-incomplete", sentence, {"cases": len(partly)})
