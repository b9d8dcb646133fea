"""Tally: what many cases come to at a glance, gathered block by block."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from drysim.checks import STATUS, Check, Verdict, badness
from drysim.study.ensembles.doubts import about_mean
from drysim.study.sweeps.batch import NAMES, STATUSES, Batch
from drysim.study.sweeps.known import Count, Seeds, more
from drysim.study.sweeps.quantiles import Quantiles
from drysim.study.sweeps.table import LIMIT, OK, Row

if TYPE_CHECKING:
    from numpy.typing import NDArray

    RowAt = Callable[[int], Row]


TOLD = ("T_a", "T_x", "x_r_peak", "stuck_share", "SEAT", "a_w")
"""Metrics whose quantiles are gathered."""


class Extreme(NamedTuple):
    """A metric at its least or greatest, and the row that has it."""

    value: float
    row: Row


@dataclass
class Tally:
    """What the cases of one approach come to.

    Attributes
    ----------
    approach : str
    checks : sequence of Check
        What was promised about them.
    cases, beyond : int
        Number of cases, and of those in which the stroke limit is met.
    lost : dict
        By status: cases that have no numbers for that reason.
    extremes : dict
        Least and greatest value of every metric that is known somewhere, each the first of its
        kind, over the cases that have numbers.
    quantiles : dict
        `Quantiles` of the metrics of `TOLD`, over the cases that have numbers.
    worst : Row or None
        Of the cases that meet their stroke limit the one that goes the furthest beyond it.
    seeds : Seeds or None
        What is known of means, where the cases are many seeds.
    forces : list of float
        Least and greatest F_fk, least and greatest F_fs [N].
    """

    approach: str
    checks: Sequence[Check] = ()
    cases: int = 0
    beyond: int = 0
    lost: dict[str, Count] = field(default_factory=dict)
    extremes: dict[str, tuple[Extreme, Extreme]] = field(default_factory=dict)
    quantiles: dict[str, Quantiles] = field(
        default_factory=lambda: {name: Quantiles() for name in TOLD}
    )
    worst: Row | None = None
    seeds: Seeds | None = None
    forces: list[float] = field(default_factory=lambda: [np.inf, -np.inf, np.inf, -np.inf])
    _beyond: float = -np.inf
    _decided: dict[int, Verdict] = field(default_factory=dict)

    @classmethod
    def of(
        cls, batches: Iterable[Batch], checks: Sequence[Check] = (), judged: str = ""
    ) -> dict[str, Self]:
        """Give the tally of every approach in the order in which they come; one is judged."""
        found: dict[str, Self] = {}
        for batch in batches:
            name = batch.approach
            if name not in found:
                found[name] = cls(name, checks if name == judged else ())
            found[name].add(batch)
        return found

    @property
    def ends(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of every metric that is known somewhere."""
        return {name: (low.value, high.value) for name, (low, high) in self.extremes.items()}

    def add(self, batch: Batch) -> None:
        """Take a block of cases into account; blocks come in order."""
        self.cases += len(batch)
        ends = batch.F_fk.min(), batch.F_fk.max(), batch.F_fs.min(), batch.F_fs.max()
        pick = (min, max, min, max)
        self.forces = [float(p(a, b)) for p, a, b in zip(pick, self.forces, ends, strict=True)]
        good, row = batch.status == STATUSES.index(OK), cache(batch.row)
        self._count_lost(batch, row)
        self._stretch(batch, good, row)
        for name, quantiles in self.quantiles.items():
            quantiles.add(batch.metrics[name][good])
        self._meet_limit(batch, row)
        if batch.over:
            self.seeds = self.seeds or Seeds()
            self.seeds.add(batch, self.checks)
        for i, check in enumerate(self.checks):
            self._judge(i, check, batch, good, row)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """One for every check, in order."""
        return tuple(
            self._decided.get(i) or check.missed() for i, check in enumerate(self.checks)
        )

    @property
    def shared(self) -> dict[str, bool]:
        """Whether all cases share the `kinetic` and the `static` friction force."""
        low_k, high_k, low_s, high_s = self.forces
        return {"kinetic": low_k >= high_k, "static": low_s >= high_s}

    def greatest(self, metric: str) -> float | None:
        """Give the greatest value of a metric; None where it is known nowhere."""
        ends = self.extremes.get(metric)
        return None if ends is None else ends[1].value

    def _count_lost(self, batch: Batch, row: RowAt) -> None:
        for code in np.unique(batch.status).tolist():
            if (status := STATUSES[code]) == OK:
                continue
            places = np.flatnonzero(batch.status == code)
            self.lost[status] = more(self.lost.get(status), row(int(places[0])), len(places))

    def _stretch(self, batch: Batch, good: NDArray[np.bool_], row: RowAt) -> None:
        """Widen the ranges of the metrics; a row is made for none but a new end."""
        every = good.all()
        for name in NAMES:
            column = batch.metrics[name]
            column = column if every else np.where(good, column, np.nan)
            low, high = float(np.fmin.reduce(column)), float(np.fmax.reduce(column))
            if low != low:
                continue
            least, most = self.extremes.get(name, (None, None))
            if least is None or low < least.value:
                least = Extreme(low, row(int(np.argmax(column == low))))
            if most is None or high > most.value:
                most = Extreme(high, row(int(np.argmax(column == high))))
            self.extremes[name] = least, most

    def _meet_limit(self, batch: Batch, row: RowAt) -> None:
        met = np.flatnonzero(np.nan_to_num(batch.metrics["violations"]) > 0)
        self.beyond += len(met)
        if len(met):
            peaks = np.nan_to_num(batch.metrics["x_r_peak"][met])
            # A limit that all cases share plays no part in which is the worst.
            beyond = peaks - (batch.points[LIMIT][met] if LIMIT in batch.points else 0.0)
            if self.worst is None or beyond.max() > self._beyond:
                self._beyond = float(beyond.max())
                self.worst = row(int(met[np.argmax(beyond)]))

    def _judge(
        self, i: int, check: Check, batch: Batch, good: NDArray[np.bool_], row: RowAt
    ) -> None:
        reach = check.reach({**batch.points, STATUS: batch.status}, len(batch))
        # A case without metrics fails what it is asked for, unless the check leaves it out.
        at = check.worst(reach, np.where(good, batch.metrics[check.metric], np.nan))
        if at is not None:
            case = row(at)
            status = "" if good[at] else case.status
            verdict = check.verdict(case.metrics.get(check.metric), case.point, status)
            if case.over:
                verdict = about_mean(verdict, case.half_widths.get(check.metric), case.seeds)
            before = self._decided.get(i)
            if before is None or badness(verdict) > badness(before):
                self._decided[i] = verdict
