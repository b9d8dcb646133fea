"""How well the means of many cases are known, gathered block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from drysim.study.sweeps.table import OK, Row

if TYPE_CHECKING:
    from drysim.checks import Check
    from drysim.study.sweeps.batch import Batch


class Count(NamedTuple):
    """How many cases have something in common, and the first of them."""

    cases: int
    first: Row


@dataclass
class Seeds:
    """What the cases of one approach have in common that are means over many seeds.

    Attributes
    ----------
    cases : int
        Those of them that have numbers.
    least, most : int
        Seeds of a case.
    hashes : set of str
        Of the base motions of all seeds; no more than two are held.
    widest : dict
        By metric the row with the widest interval.
    wide : Count or None
        Cases whose interval is wider than asked.
    open : dict
        By check: cases in which its limit lies within the interval.
    """

    cases: int = 0
    least: int = 0
    most: int = 0
    hashes: set[str] = field(default_factory=set)
    widest: dict[str, Row] = field(default_factory=dict)
    wide: Count | None = None
    open: dict[Check, Count] = field(default_factory=dict)

    def add(self, batch: Batch, checks: Sequence[Check]) -> None:
        """Take a block of cases into account; blocks come in order."""
        for row in map(batch.row, batch.over):
            self.least = min(self.least or row.seeds, row.seeds)
            self.most = max(self.most, row.seeds)
            if row.status == OK:
                self._add(row, checks)

    def _add(self, row: Row, checks: Sequence[Check]) -> None:
        self.cases += 1
        if row.over and len(self.hashes) < 2:
            self.hashes.add(row.over.sha256)
        for name, width in row.half_widths.items():
            before = self.widest.get(name)
            if width is not None and (
                before is None or width > (before.half_widths[name] or 0)
            ):
                self.widest[name] = row
        if row.over and not row.over.narrow:
            self.wide = more(self.wide, row)
        for check in checks:
            if check.applies(row.point) and lies_within(check, row):
                self.open[check] = more(self.open.get(check), row)


def more(before: Count | None, row: Row, cases: int = 1) -> Count:
    """Give a count with so many more cases in it, the first of which is a row."""
    return Count(before.cases + cases, before.first) if before else Count(cases, row)


def lies_within(check: Check, row: Row) -> bool:
    """Tell whether the limit of a check lies within the interval of a mean."""
    mean = row.metrics.get(check.metric)
    return mean is not None and abs(mean - check.limit) < (
        row.half_widths.get(check.metric) or 0
    )
