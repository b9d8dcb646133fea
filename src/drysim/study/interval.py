"""A case whose static ratio F_fs/F_fk is an interval: the range of its metrics, and its jumps.

Problem
    The static limit is rarely known. With F_fs above F_fk the answer may jump where a motion
    ends or another one is reached, so two values of the ratio do not bound the metrics.

Method
    The case is solved at evenly spaced values of the ratio. Where the metrics of neighbours
    differ by more than `MAX_DIFFERENCE` of their greatest value, the interval between them is
    halved, largest differences first. A difference that is left over `MIN_WIDTH` is a jump. The
    result is the table of a sweep over these values, so that extremes, checks, files and
    pictures are those of any other sweep.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import inf

from drysim.errors import WarningMessage
from drysim.metrics.checks import Verdict
from drysim.scenario.axes import Axis, decimal_linspace
from drysim.scenario.model import STATIC_RATIO, Scenario
from drysim.study.case import Case
from drysim.study.plan import CaseRanges, solve_range
from drysim.study.run import MotionCache
from drysim.study.statistics import OK, Batch, Row, Rows
from drysim.study.sweep import choose_engine, make_table
from drysim.study.table import JUMP_METRICS, Jump, Table, Tally, stroke_limits
from drysim.wording import format_number

KEY = ".".join(map(str, STATIC_RATIO))

FIRST_VALUES, MAX_VALUES = 33, 600
"""Number of evenly spaced values of the ratio, and of all values that are solved at most."""

MAX_DIFFERENCE = 0.01
"""Difference of a metric between neighbours that is resolved no further, relative to its
greatest value [-]."""

MIN_WIDTH = 1e-7
"""Difference of the ratio below which a difference that remains is a jump [-]."""


def solve(case: Case) -> Table:
    """Solve a prepared case over the interval of its static ratio.

    Returns
    -------
    Table
        One row per value of the ratio that was solved, in ascending order.
    """
    scenario = case.scenario
    interval = scenario.static_interval
    assert interval is not None, "only called with an interval"
    rows: dict[float, Row] = {}
    values = [*decimal_linspace(interval.low, interval.high, FIRST_VALUES)]
    choose_engine(case, [_swept(scenario, values)], 2 * FIRST_VALUES)
    motions = MotionCache.starting_with(case)
    while values:
        for case_range in CaseRanges([_swept(scenario, values)]):
            rows |= {row.point[KEY]: row for row in solve_range(case_range, motions)}
        steps = large_steps(rows)
        room = max(MAX_VALUES - len(rows), 0)
        wide = [(low, high) for low, high in steps if high - low > MIN_WIDTH][:room]
        values = sorted(0.5 * (low + high) for low, high in wide)
    jumps = sorted(step for step in steps if step[1] - step[0] <= MIN_WIDTH)
    swept = _swept(scenario, sorted(rows))
    batch = Batch.of(0, [rows[value] for value in sorted(rows)])
    tallies = Tally.of([batch], partial(stroke_limits, swept), scenario.checks, scenario.label)
    for tally in tallies.values():
        tally.quantiles.clear()  # the values gather at jumps: their shares mean nothing
    table = make_table(swept, replace(case, scenario=swept), Rows.of([batch]), tallies)
    further = [*_undecided_warnings(table.checks, rows)]
    if len(jumps) < len(steps):
        further.append(_unresolved_warning(len(rows)))
    return replace(
        table,
        scenario=scenario,
        warnings=(*table.warnings, *further),
        jumps=tuple(Jump(0.5 * (low + high), rows[low], rows[high]) for low, high in jumps),
    )


def _swept(scenario: Scenario, values: Sequence[float]) -> Scenario:
    """Return the scenario with a sweep over these values of the ratio."""
    low, high = (format_number(value, digits=7) for value in (values[0], values[-1]))
    words = f"anywhere from {low} to {high} ({len(values)} values solved)"
    axis = Axis(KEY, "-", tuple(values), description=words)
    return scenario.copy_with({"sweep": (axis,)})


def large_steps(rows: Mapping[float, Row]) -> list[tuple[float, float]]:
    """Return the neighbouring values whose motions differ, largest difference first."""
    scales = {
        name: max((abs(row.metrics.get(name) or 0.0) for row in rows.values()), default=0.0)
        for name in JUMP_METRICS
    } | {"stuck_share": 1.0}

    def difference(low: float, high: float) -> float:
        one, other = rows[low], rows[high]
        if one.status != OK or other.status != OK:
            return inf if one.status != other.status else 0.0
        return max(
            abs((one.metrics[name] or 0.0) - (other.metrics[name] or 0.0)) / (scale or 1.0)
            for name, scale in scales.items()
        )

    steps = {step: difference(*step) for step in pairwise(sorted(rows))}
    large = [step for step, size in steps.items() if size > MAX_DIFFERENCE]
    return sorted(large, key=lambda step: -steps[step])


def _undecided_warnings(
    verdicts: Sequence[Verdict], rows: Mapping[float, Row]
) -> Iterator[WarningMessage]:
    """Warn of checks that hold for a part of the interval only."""
    for verdict in verdicts:
        if not 0 < verdict.failed < verdict.cases:
            continue
        check = verdict.check
        values = (
            (value, row.metrics.get(check.metric) if row.status == OK else None)
            for value, row in sorted(rows.items())
        )
        failed = [value for value, found in values if found is None or not check.holds(found)]
        low, high = (format_number(value, digits=7) for value in (failed[0], failed[-1]))
        sentence = (
            f"`{check}` is undecided: it holds for some values of {KEY} and fails for others, "
            f"between {low} and {high}"
        )
        numbers = {"from": failed[0], "to": failed[-1]}
        yield WarningMessage("check-undecided", sentence, numbers)


def _unresolved_warning(count: int) -> WarningMessage:
    """Return the warning of an answer that changes at too many values of the ratio."""
    sentence = (
        f"the answer changes so often with {KEY} that {count} solutions do not resolve it: "
        "jumps may be missing; use a narrower interval"
    )
    return WarningMessage("jumps-unresolved", sentence, {"values": count})
