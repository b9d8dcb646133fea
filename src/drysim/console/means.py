"""What the summary of many cases says of means over many seeds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from drysim import wording
from drysim.console.parts import Row
from drysim.study.ensembles.seeds import until_of

if TYPE_CHECKING:
    from drysim.scenario import Axis, Scenario
    from drysim.study.sweeps.known import Seeds


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
