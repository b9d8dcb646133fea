"""Results of many cases: one case as a row, many as columns, and statistics over seeds.

A row is the point of a case, its metrics and what became of it. A batch holds the columns of a
block of cases that follow each other; `Rows` makes the rows of many batches when they are
asked for, so that none need be held.

Over the seeds of a scenario each metric has a mean, its confidence interval, quantiles and
extremes, over the seeds that know it; `has_enough_seeds` says when there are enough seeds.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import accumulate, chain, groupby
from math import fsum, isfinite, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.errors import WarningMessage
from drysim.excitation.random import RandomMotion
from drysim.metrics.checks import Verdict
from drysim.metrics.table import UNITS, Metrics
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.sampling import LazySequence

if TYPE_CHECKING:
    from drysim.excitation.base import Until
    from drysim.scenario.model import Scenario


OK, NOT_SETTLED, NOT_UNIQUE, FAILED = "ok", "not settled", "not unique", "failed"

STATUSES = (OK, NOT_SETTLED, NOT_UNIQUE, FAILED)
"""What a case may come to; its place here is its code in a batch."""

LIMIT_KEY = "stroke.limit"
"""The key of the stroke limit, which a case has of its own where it is swept."""


@dataclass(frozen=True)
class Row:
    """One case of a sweep, solved by one approach.

    Attributes
    ----------
    point : mapping
        Swept keys and their values in SI, in the order of the axes; a key that the approach has
        no use for (friction under `viscous`) is missing.
    approach : str
        Name on the shelf.
    F_fk, F_fs : float
        Friction forces [N].
    metrics : mapping
        As `drysim.metrics.measure` gives them; all None where the status is not `ok`.
    status : str
        `ok`, `not settled`, `not unique` or `failed`.
    note : str
        What is to be said about a status other than `ok`.
    sha256 : str
        Of the base acceleration (hex), where the case is one seed of many.
    over : OverSeeds or None
        How well the metrics are known, where they are means over many seeds.
    """

    point: Mapping[str, float]
    approach: str
    F_fk: float
    F_fs: float
    metrics: Metrics
    status: str = OK
    note: str = ""
    sha256: str = ""
    over: OverSeeds | None = None

    @property
    def seed(self) -> int:
        """Its seed, where the case is one of many."""
        return int(self.point[SEED_KEY])

    @property
    def seeds(self) -> int:
        """How many seeds the metrics are means over."""
        return self.over.count if self.over else 1

    @property
    def half_widths(self) -> Mapping[str, float | None]:
        """Half of the 95 % confidence interval of every metric that is a mean."""
        return self.over.half_widths if self.over else {}


@dataclass(frozen=True)
class OverSeeds:
    """What is known of a case that is many seeds, beside the means of its metrics.

    Attributes
    ----------
    count : int
        How many seeds.
    half_widths : mapping
        Half of the 95 % confidence interval, by metric.
    T_a : sequence of float
        By seed: two approaches are compared seed by seed.
    sha256 : str
        Of the hashes of all base accelerations (hex).
    narrow : bool
        Whether the interval is as narrow as `until` asks for, if it does.
    """

    count: int
    half_widths: Mapping[str, float | None] = field(default_factory=dict)
    T_a: Sequence[float | None] = ()
    sha256: str = ""
    narrow: bool = True


COUNT_METRICS = frozenset({"violations", "contacts"})
"""Metrics that are whole numbers, unless they are means over many seeds."""

METRIC_NAMES = tuple(UNITS)
Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Batch:
    """Cases of one approach that follow each other in the order of the sweep.

    Attributes
    ----------
    first : int
        Number of the first case among those of all approaches.
    approach : str
        Name on the shelf.
    points : mapping
        Column of every swept key, shape (n,); whole numbers where the key takes no others.
    F_fk, F_fs : ndarray, shape (n,)
        Friction forces [N].
    metrics : mapping
        Column of every metric of `METRICS`, shape (n,); NaN where it is not known.
    status : ndarray of int8, shape (n,)
        Index into `STATUSES`.
    notes : mapping
        What is to be said about cases without numbers, by their place in the batch.
    over : mapping
        What is known of cases that are many seeds, by their place in the batch.
    """

    first: int
    approach: str
    points: Mapping[str, NDArray[Any]]
    F_fk: Floats
    F_fs: Floats
    metrics: Mapping[str, Floats]
    status: NDArray[np.int8]
    notes: Mapping[int, str] = field(default_factory=dict)
    over: Mapping[int, OverSeeds] = field(default_factory=dict)

    def __len__(self) -> int:
        """Give the number of cases."""
        return len(self.status)

    def __iter__(self) -> Iterator[Row]:
        """Give the cases as rows."""
        keys = tuple(self.points)
        columns = (column.tolist() for column in self.points.values())
        points = list(zip(*columns, strict=True)) or [()] * len(self)
        values = zip(
            *(_to_values(name, self.metrics[name]) for name in METRIC_NAMES), strict=True
        )
        forces = zip(self.F_fk.tolist(), self.F_fs.tolist(), strict=True)
        codes = self.status.tolist()
        every = zip(points, values, forces, codes, strict=True)
        for i, (point, row, force, code) in enumerate(every):
            yield Row(
                dict(zip(keys, point, strict=True)),
                self.approach,
                *force,
                dict(zip(METRIC_NAMES, row, strict=True)),
                STATUSES[code],
                self.notes.get(i, ""),
                over=self.over.get(i),
            )

    def row(self, i: int) -> Row:
        """Give one case as a row."""
        return Row(
            {key: column[i].item() for key, column in self.points.items()},
            self.approach,
            float(self.F_fk[i]),
            float(self.F_fs[i]),
            {name: _to_value(name, self.metrics[name][i].item()) for name in METRIC_NAMES},
            STATUSES[self.status[i]],
            self.notes.get(i, ""),
            over=self.over.get(i),
        )

    @classmethod
    def of(cls, first: int, rows: Sequence[Row]) -> Self:
        """Give rows of one approach as a batch."""
        keys = tuple(rows[0].point)
        return cls(
            first,
            rows[0].approach,
            {key: np.array([row.point[key] for row in rows]) for key in keys},
            np.array([row.F_fk for row in rows]),
            np.array([row.F_fs for row in rows]),
            {
                name: _to_column([row.metrics.get(name) for row in rows])
                for name in METRIC_NAMES
            },
            np.array([STATUSES.index(row.status) for row in rows], dtype=np.int8),
            {i: row.note for i, row in enumerate(rows) if row.note},
            {i: row.over for i, row in enumerate(rows) if row.over},
        )


BatchCallback = Callable[[Batch], None]


def ignore_batch(batch: Batch) -> None:
    """Do nothing with finished cases."""


def _to_column(values: Sequence[float | None]) -> Floats:
    """Give values as a column, NaN for not known."""
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _to_value(name: str, value: float) -> float | int | None:
    """Give the value of a metric, None for not known; a mean of counts stays what it is."""
    if value != value:
        return None
    return int(value) if name in COUNT_METRICS and value.is_integer() else value


def _to_values(name: str, column: Floats) -> list[float | int | None]:
    """Give a column as values, None for not known."""
    if name in COUNT_METRICS:
        return [_to_value(name, value) for value in column.tolist()]
    if np.isnan(column).any():
        return [None if value != value else value for value in column.tolist()]
    values: list[float | int | None] = column.tolist()
    return values


MAX_CACHED_ROWS = 20_000
"""Rows up to which they are made once and held: some 30 MB."""

ROWS_PER_BATCH = 4096
"""Rows that are gathered into a block."""


class Rows(LazySequence[Row]):
    """The rows of blocks that follow each other."""

    def __init__(self, batches: Sequence[Batch], firsts: Sequence[int], length: int) -> None:
        self.batches = batches
        self._firsts = firsts
        self._length = length
        self._cached: tuple[Row, ...] | None = None

    @classmethod
    def of(cls, batches: Sequence[Batch], lengths: Sequence[int] = ()) -> Rows:
        """Give the rows of blocks; their lengths, where the blocks are not at hand."""
        ends = [0, *accumulate(lengths or map(len, batches))]
        return cls(batches, ends[:-1], ends[-1])

    def __len__(self) -> int:
        """Give the number of rows."""
        return self._length

    def __iter__(self) -> Iterator[Row]:
        """Give the rows in order."""
        if self._length > MAX_CACHED_ROWS:
            return chain.from_iterable(self.batches)
        if self._cached is None:
            self._cached = tuple(chain.from_iterable(self.batches))
        return iter(self._cached)

    def one(self, number: int) -> Row:
        """Give one row."""
        at = bisect_right(self._firsts, number) - 1
        return self.batches[at].row(number - self._firsts[at])


def as_batches(rows: Iterable[Row]) -> Iterable[Batch]:
    """Give rows as blocks, each of one approach."""
    return rows.batches if isinstance(rows, Rows) else _group_batches(rows)


def _group_batches(rows: Iterable[Row]) -> Iterator[Batch]:
    first = 0
    for _, group in groupby(rows, key=lambda row: (row.approach, tuple(row.point))):
        several = list(group)
        for at in range(0, len(several), ROWS_PER_BATCH):
            part = several[at : at + ROWS_PER_BATCH]
            yield Batch.of(first, part)
            first += len(part)


# Statistics over seeds.


CONFIDENCE = 0.95
"""Share of ensembles whose interval holds the true mean [-]."""

QUANTILES = (0.05, 0.50, 0.95)
"""Shares of the seeds [-] below the quantiles that are given."""


class Statistic(NamedTuple):
    """What a metric is over the seeds that know it, in its unit.

    Attributes
    ----------
    seeds : int
        How many know it.
    mean : float
    half_width : float or None
        Half of the confidence interval of the mean, by Student's t; None for one seed.
    std : float or None
        Standard deviation of a single seed, by n - 1; None for one seed.
    quantiles : tuple of float
        As `QUANTILES` says.
    least, greatest : tuple of (float, int)
        Value and the first seed that has it.
    """

    seeds: int
    mean: float
    half_width: float | None
    std: float | None
    quantiles: tuple[float, ...]
    least: tuple[float, int]
    greatest: tuple[float, int]


def statistics(rows: Sequence[Row]) -> dict[str, Statistic | None]:
    """Give the statistics of every metric that rows have, one row for each seed, in order.

    None where no row knows it.
    """
    names = dict.fromkeys(name for row in rows for name in row.metrics)
    return {name: _statistic(rows, name) for name in names}


def _statistic(rows: Sequence[Row], name: str) -> Statistic | None:
    """Give the statistics of a metric over the seeds that know it."""
    found = ((row.seed, row.metrics.get(name)) for row in rows)
    values = {seed: value for seed, value in found if value is not None and isfinite(value)}
    if not values:
        return None
    import numpy as np

    series = np.array(list(values.values()))
    # Of the common definitions the one that leans least on how the values are distributed.
    quantiles = np.quantile(series, QUANTILES, method="median_unbiased").tolist()
    least, greatest = (choose(values, key=values.__getitem__) for choose in (min, max))
    return Statistic(
        len(values), *_moments(series.tolist()), tuple(quantiles),
        (values[least], least), (values[greatest], greatest),
    )  # fmt: skip


def interval(values: Iterable[float]) -> tuple[float, float | None]:
    """Give the mean of values and half of its confidence interval, None for a single one.

    Notes
    -----
    Sums are exact, so neither depends on the order of the values.
    """
    mean, half_width, _ = _moments(list(values))
    return mean, half_width


def _moments(values: Sequence[float]) -> tuple[float, float | None, float | None]:
    """Give mean, half-width of its interval and standard deviation."""
    n, least = len(values), min(values)
    # Over what they span: equal values have themselves for a mean, and no square overflows.
    span = max(values) - least or 1.0
    shares = [(value - least) / span for value in values]
    share = fsum(shares) / n
    mean = least + span * share
    if n < 2:
        return mean, None, None
    std = span * sqrt(fsum((one - share) ** 2 for one in shares) / (n - 1))
    return mean, student_t(n - 1) * std / sqrt(n), std


@cache
def student_t(degrees_of_freedom: int) -> float:
    """Give Student's t that both tails beyond the confidence share, by degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees_of_freedom, 0.5 + 0.5 * CONFIDENCE))


def with_interval(verdict: Verdict, half_width: float | None, seeds: int) -> Verdict:
    """Give a verdict with what is known of the mean that it is about, if it applies."""
    if verdict.passed is None:
        return verdict
    return replace(verdict, half_width=half_width, seeds=seeds)


# The seeds, one after the other, and when they are enough.

SEEDS_PER_CHECK = 10
"""Seeds between two looks at the interval. Looks are taken at fixed numbers of seeds, in their
order, so that what is decided does not depend on which of them was ready first."""


def max_seeds(scenario: Scenario) -> int:
    """Give how many seeds a scenario asks for at most; 1 where it asks for no more."""
    excitation = scenario.excitation
    return excitation.max_seeds if isinstance(excitation, RandomMotion) else 1


def stopping_rule(scenario: Scenario) -> Until | None:
    """Give when the seeds of a scenario are to be enough; None where their number is given."""
    excitation = scenario.excitation
    return excitation.until if isinstance(excitation, RandomMotion) else None


def seed_range(scenario: Scenario) -> range:
    """Give the seeds that a scenario asks for, as far as they may have to go."""
    excitation = scenario.excitation
    assert isinstance(excitation, RandomMotion), "only random base motion has seeds"
    return range(excitation.seed, excitation.seed + excitation.max_seeds)


def with_seed(scenario: Scenario, seed: int) -> Scenario:
    """Give the scenario with the base motion of one seed alone."""
    excitation = scenario.excitation
    assert isinstance(excitation, RandomMotion), "only random base motion has seeds"
    return scenario.copy_with({"excitation": excitation.with_seed(seed)})


def unused_seeds_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Say that one seed is taken where a scenario asks for many, which is of no use."""
    if max_seeds(scenario) > 1:
        first = seed_range(scenario)[0]
        sentence = f"excitation.seeds has no use here: only the first seed, {first}, is taken"
        yield WarningMessage("one-seed", sentence, {"seed": first})


def has_enough_seeds(scenario: Scenario, rows: Sequence[Row]) -> bool:
    """Tell whether these seeds, the first ones in order, are all that are needed."""
    return len(rows) == max_seeds(scenario) or (
        len(rows) % SEEDS_PER_CHECK == 0 and is_narrow(scenario, rows)
    )


def is_narrow(scenario: Scenario, rows: Sequence[Row]) -> bool:
    """Tell whether the interval of a metric is as narrow as `until` asks for.

    A seed that does not know the metric, or has failed, leaves it open.
    """
    until = stopping_rule(scenario)
    if until is None:
        return False
    mean, half_width, known = metric_interval(rows, until.metric)
    if known < len(rows) or half_width is None:
        return False
    return half_width <= until.half_width * abs(mean)


def metric_interval(rows: Sequence[Row], metric: str) -> tuple[float, float | None, int]:
    """Give mean and half-width of a metric over the seeds that know it, and their number."""
    values = [row.metrics.get(metric) for row in rows]
    known = [value for value in values if value is not None]
    return (*interval(known), len(known)) if known else (0.0, None, 0)
