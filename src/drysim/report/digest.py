"""drysim.json of many cases: what made the numbers, and their extremes with where they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from drysim.metrics import METRICS
from drysim.report.sidecar import Fields, framed, software
from drysim.study import survey
from drysim.study.table import OK

if TYPE_CHECKING:
    from drysim.study.survey import Extreme
    from drysim.study.table import Comparison, Row, Table


def of_table(table: Table, command: str, exit_code: int, files: Mapping[str, str]) -> Fields:
    """Give everything that made the numbers of a sweep, ready for JSON.

    Parameters are those of `report.sidecar`; the metrics are extremes over the approach that
    was asked for, its reference left aside.
    """
    approach, *references = table.approaches or ("",)
    rows = table.own
    numerics = {
        "approach": approach,
        "reference": next(iter(references), None),
        **_numerics(table, rows),
    }
    found = {"numerics": numerics, "software": software(), "metrics": _metrics(rows)}
    return framed(table, table.motion, found, command, exit_code, files)


def of_comparison(
    comparison: Comparison, command: str, exit_code: int, files: Mapping[str, str]
) -> Fields:
    """Give the same for a comparison: extremes for each approach, deviations, the verdict."""
    table, yardstick = comparison.table, comparison.yardstick
    numerics = {
        "approaches": table.approaches,
        "yardstick": yardstick,
        **_numerics(table, list(table.of(yardstick))),
    }
    metrics = {
        name: {**_metrics(list(table.of(name))), **_deviation(comparison, name)}
        for name in table.approaches
    }
    found = {
        "numerics": numerics,
        "software": software(),
        "metrics": metrics,
        "verdict": comparison.verdict,
    }
    response = comparison.responses.get(yardstick)
    motion = table.motion if response is None else response.motion
    return framed(table, motion, found, command, exit_code, files)


def _numerics(table: Table, rows: Sequence[Row]) -> Fields:
    """Give how the numbers were made, and how well the worst of them closes."""
    good = [row for row in rows if row.status == OK]
    return {
        "cases": len(table.rows),
        "statuses": dict(Counter(row.status for row in table.rows)),
        "swept": [
            {"key": axis.key, "unit": axis.unit, "values": len(axis.values)}
            for axis in table.axes
        ],
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": _greatest(good, "energy_residual"),
        "closure": _greatest(good, "closure"),
    }


def _greatest(rows: Sequence[Row], metric: str) -> float | None:
    ends = survey.extremes(rows, metric)
    return None if ends is None else ends[1].value


def _metrics(rows: Sequence[Row]) -> Fields:
    """Give the extremes of every metric that is known anywhere."""
    good = [row for row in rows if row.status == OK]
    found = ((metric.name, survey.extremes(good, metric.name)) for metric in METRICS)
    return {
        name: {"least": _where(ends[0]), "greatest": _where(ends[1])}
        for name, ends in found
        if ends is not None
    }


def _where(extreme: Extreme) -> Fields:
    return {"value": extreme.value, "where": dict(extreme.row.point)}


def _deviation(comparison: Comparison, approach: str) -> Fields:
    """Give the greatest deviation from the yardstick, with where it is."""
    worst = survey.worst(survey.deviations(comparison, approach))
    if worst is None or approach == comparison.yardstick:
        return {}
    return {"T_a_deviation": {"value": worst.value, "where": dict(worst.row.point)}}
