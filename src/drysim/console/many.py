"""What the summary of many cases says of means over seeds, and of the stroke.

Each case is held to its own stroke limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isclose
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.parts import Row
from drysim.study.ensembles.seeds import until_of
from drysim.study.sweeps.table import stroke_limit
from drysim.wording import length, number, percent, several

if TYPE_CHECKING:
    from drysim.scenario import Axis, Scenario
    from drysim.study.sweeps.known import Seeds
    from drysim.study.sweeps.table import Table
    from drysim.study.sweeps.tally import Extreme, Tally

ROUNDING = 1e-9
"""Difference of extremes, relative to them, that says nothing about where they are [-]."""


def seeds(scenario: Scenario, found: Seeds | None) -> str:
    """Give which seeds every case has; nothing where none has many."""
    if found is None:
        return ""
    first: int = getattr(scenario.excitation, "seed", 1)
    until = until_of(scenario)
    counts = sorted({found.least, found.most})
    return wording.seeds(range(first, first + found.most), until, counts)


def known(axes: Sequence[Axis], found: Seeds | None, metric: str) -> Iterator[Row]:
    """Give how well the means of a metric are known at the worst."""
    row = found.widest.get(metric) if found else None
    if row is not None:
        width = row.half_widths[metric]
        mean, where = row.metrics.get(metric), wording.place(row.point, axes)
        words = f"at the worst: {wording.around(mean, width)} at {where}"
        yield Row("", f"± {wording.number(width, digits=2)}", words)


def alike(own: Tally, metric: str) -> bool:
    """Whether a metric is the same in several cases, but for rounding."""
    least, most = own.extremes[metric]
    known = own.cases - sum(count for count, _ in own.lost.values())
    return known > 1 and isclose(least.value, most.value, rel_tol=ROUNDING)


def extent(table: Table, own: Tally, metric: str) -> str:
    """Return where a metric is least and greatest, in words."""
    if alike(own, metric):
        return "the same in every case" + " that has numbers" * bool(own.lost)
    least, most = (at(table, end) for end in own.extremes[metric])
    return f"least {least}, greatest {most}" if least != most else least


def stroke(table: Table, own: Tally) -> Iterator[Row]:
    """Give the greatest stroke, and by how much the limit is met."""
    ends, used = own.extremes.get("x_r_peak"), own.extremes.get("stroke_used")
    if ends is None:
        return
    peak, share = ends[1], percent(ends[1].row.metrics.get("stroke_used"))
    remark = f"{share} of the stroke limit, " if used else ""
    same = alike(own, "x_r_peak") and not (used and not alike(own, "stroke_used"))
    where = extent(table, own, "x_r_peak") if same else at(table, peak)
    yield Row("peak |x_r|", length(peak.value), f"{remark}{where}")
    # Where the limit is swept, another case may use more of its own.
    if used and percent(used[1].value) != share:
        most = percent(used[1].value)
        yield Row("", most, f"of the stroke limit at the most, {at(table, used[1])}")
    if own.beyond:
        name, remark = _met(table, own)
        yield Row(name, several(own.beyond, "case"), f"of {own.cases}, {remark}", "bold red")


def _met(table: Table, own: Tally) -> tuple[str, str]:
    """Give what was met and how hard or how far."""
    ends, worst = own.extremes.get("impact_speed"), own.worst
    if ends and table.scenario.stops:
        return "stops met", f"at up to {number(ends[1].value, 'm/s')}, {at(table, ends[1])}"
    limit = stroke_limit(table.scenario, worst) if worst else None
    if own.seeds or worst is None or limit is None:
        return "limit met", "with some of the seeds"
    peak = worst.metrics["x_r_peak"] or 0.0
    if peak < limit:
        return "limit met", "while it settles"
    return "limit met", f"{length(peak - limit, own.greatest('x_r_peak'))} too far at the worst"


def at(table: Table, extreme: Extreme) -> str:
    """Give where an extreme is."""
    return f"at {wording.place(extreme.row.point, table.axes)}"
