"""drysim.json of many cases: what made the numbers, and their extremes with where they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from typing import TYPE_CHECKING

from drysim.metrics import METRICS
from drysim.report.sidecar import Ending, Fields, framed
from drysim.study.sweeps import survey
from drysim.study.sweeps.table import OK

if TYPE_CHECKING:
    from drysim.study.comparisons.comparison import Comparison
    from drysim.study.sweeps.table import Table
    from drysim.study.sweeps.tally import Extreme, Tally


def of_table(table: Table, ending: Ending) -> Fields:
    """Give everything that made the numbers of a sweep, ready for JSON.

    The metrics are extremes over the approach that was asked for, its reference left aside.
    """
    approach, *references = table.approaches or ("",)
    own = table.tallies.get(approach)
    numerics = {
        "approach": approach,
        "reference": next(iter(references), None),
        **_numerics(table, own),
    }
    return framed(table, table.motion, numerics, _metrics(own), ending)


def of_comparison(comparison: Comparison, ending: Ending) -> Fields:
    """Give the same for a comparison: extremes for each approach, deviations, the verdict."""
    table, yardstick = comparison.table, comparison.yardstick
    numerics = {
        "approaches": table.approaches,
        "yardstick": yardstick,
        "laws": comparison.laws,
        **_numerics(table, table.tallies.get(yardstick)),
    }
    metrics = {
        name: {**_metrics(tally), **_deviation(comparison, name)}
        for name, tally in table.tallies.items()
    }
    response = comparison.responses.get(yardstick)
    motion = table.motion if response is None else response.motion
    return framed(table, motion, numerics, metrics, ending, verdict=comparison.verdict)


def _numerics(table: Table, own: Tally | None) -> Fields:
    """Give how the numbers were made, and how well the worst of them closes."""
    return {
        "cases": len(table.rows),
        "statuses": _statuses(table.tallies.values()),
        "swept": [
            {"key": axis.key, "unit": axis.unit, "values": len(axis.values)}
            for axis in table.axes
        ],
        "step": table.scenario.solver.step,
        **table.numerics,
        "energy_residual": own and own.greatest("energy_residual"),
        "closure": own and own.greatest("closure"),
    } | _seeds(own)


def _seeds(own: Tally | None) -> Fields:
    """Give how many seeds the cases are means over; where all share them, their hash."""
    if own is None or own.seeds is None:
        return {}
    found = own.seeds
    shared = {"sha256_of_seeds": min(found.hashes)} if len(found.hashes) == 1 else {}
    return {"seeds": {"least": found.least, "greatest": found.most}} | shared


def _statuses(tallies: Collection[Tally]) -> dict[str, int]:
    """Count what became of the cases of all approaches."""
    lost: Counter[str] = Counter()
    for tally in tallies:
        lost.update({status: found.cases for status, found in tally.lost.items()})
    good = sum(tally.cases for tally in tallies) - lost.total()
    return {OK: good, **lost} if good else dict(lost)


def _metrics(tally: Tally | None) -> Fields:
    """Give the extremes of every metric that is known anywhere."""
    if tally is None:
        return {}
    return {
        name: {"least": _where(ends[0], name), "greatest": _where(ends[1], name)}
        | _quantiles(tally, name)
        for metric in METRICS
        if (ends := tally.extremes.get(name := metric.name)) is not None
    }


def _quantiles(tally: Tally, name: str) -> Fields:
    """Give the quantiles of a metric, where they were gathered."""
    known = tally.quantiles[name].told() if name in tally.quantiles else {}
    return {"quantiles": known} if known else {}


def _where(extreme: Extreme, metric: str) -> Fields:
    """Give an extreme and where it is; of a mean over many seeds how well it is known."""
    row = extreme.row
    mean = {"half_width": row.half_widths.get(metric), "seeds": row.seeds}
    return {"value": extreme.value, "where": dict(row.point)} | (mean if row.over else {})


def _deviation(comparison: Comparison, approach: str) -> Fields:
    """Give the greatest deviation from the yardstick, with where it is."""
    worst = survey.worst(survey.deviations(comparison, approach))
    if worst is None or approach == comparison.yardstick:
        return {}
    found = {"value": worst.value, "where": dict(worst.row.point)}
    mean = {} if worst.half_width is None else {"half_width": worst.half_width}
    return {"T_a_deviation": found | mean}
