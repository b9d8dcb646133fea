"""Results of many cases as rows and columns, and statistics over seeds.

A `Row` holds the point of one case, its metrics and its status. A `Batch` holds the columns of
consecutive cases. `Rows` converts batches to rows on access, so that a table of millions of
cases is never in memory as objects.

For each metric, `statistics` returns mean, confidence interval, quantiles and extremes over
the seeds for which the metric is known. `needed_seeds` implements the stopping rule.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from itertools import accumulate, chain, groupby
from math import fsum, isnan, nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats
from drysim.errors import WarningMessage
from drysim.excitation.random import RandomMotion, Until
from drysim.metrics.checks import EVERY_SEED, MEAN, Check, Verdict
from drysim.metrics.table import COUNT, METRICS, Metrics
from drysim.scenario.blocks import SEED_KEY
from drysim.scenario.sampling import LazySequence
from drysim.wording import Point

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario


OK, NOT_SETTLED, NOT_UNIQUE, FAILED = "ok", "not settled", "not unique", "failed"

STATUSES = (OK, NOT_SETTLED, NOT_UNIQUE, FAILED)
"""Possible results of a case; the index is the code in a batch."""


@dataclass(frozen=True)
class Row:
    """One case, solved by one approach."""

    point: Point
    """Swept keys and their values in SI, in the order of the axes; without keys that the
    approach does not use (friction under `viscous`)."""
    approach: str
    """Name of the approach, or of the law in a comparison of laws."""
    F_fk: float
    F_fs: float
    """Kinetic and static friction force [N]."""
    metrics: Metrics
    """As `drysim.metrics.measure` returns them; all None if the status is not `ok`."""
    status: str = OK
    """`ok`, `not settled`, `not unique` or `failed`."""
    note: str = ""
    """Explanation of a status other than `ok`."""
    over: OverSeeds | None = None
    """Statistics beside the means, if the metrics are means over seeds."""

    @property
    def seed(self) -> int:
        """Seed of the base motion, if the case is one seed of an ensemble."""
        return int(self.point[SEED_KEY])

    @property
    def seeds(self) -> int:
        """Number of seeds over which the metrics are means."""
        return self.over.count if self.over else 1

    def largest(self, name: str) -> float | None:
        """Return the largest of the values kept for each seed; None if one is not known."""
        values = self.over.values.get(name) if self.over else None
        if values is None:
            return self.metrics.get(name)
        numbers = [value for value in values if value is not None]
        return max(numbers) if len(numbers) == len(values) else None

    @property
    def half_widths(self) -> Mapping[str, float | None]:
        """Half-width of the 95 % confidence interval of each metric that is a mean."""
        return self.over.half_widths if self.over else {}


@dataclass(frozen=True)
class OverSeeds:
    """Statistics of a case over its seeds, beside the means of its metrics."""

    count: int
    """Number of seeds."""
    first: int
    """The first seed; the others follow it."""
    half_widths: Mapping[str, float | None] = field(default_factory=dict)
    """Half-width of the 95 % confidence interval, by metric."""
    values: Mapping[str, Sequence[float | None]] = field(default_factory=dict)
    """Values of each seed, by metric: T_a, by which approaches are compared seed by seed, and
    those by which designs are."""
    narrow: bool = True
    """Whether the interval satisfies the stopping rule `until`, if there is one."""


COUNT_METRICS = frozenset(metric.name for metric in METRICS if metric.kind == COUNT)
"""Metrics that are whole numbers, unless they are means over seeds."""

METRIC_NAMES = tuple(metric.name for metric in METRICS)
FORCES = "F_fk", "F_fs"
"""Names of the friction forces, before those of the metrics in the columns of a batch."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Consecutive cases of one approach, as columns."""

    first: int
    """Number of the first case, counted over all approaches."""
    approach: str
    """Name of the approach, or of the law in a comparison of laws."""
    points: Mapping[str, NDArray[Any]]
    """Column of each swept key, shape (n,); integers if the key takes only whole numbers."""
    names: tuple[str, ...]
    """Names of the rows of `numbers`: the `FORCES`, and the metrics that some case knows."""
    numbers: Floats
    """Forces [N] and metrics, shape (len(names), n); NaN where unknown."""
    status: NDArray[np.int8]
    """Index into `STATUSES`, shape (n,)."""
    notes: Mapping[int, str] = field(default_factory=dict)
    """Notes of cases without numbers, by index in the batch."""
    over: Mapping[int, OverSeeds] = field(default_factory=dict)
    """`OverSeeds` of cases with several seeds, by index in the batch."""
    text: bytes = b""
    """Rows of the cases in a table that a command writes, if it has the workers format them."""

    @property
    def F_fk(self) -> Floats:
        """Kinetic friction forces [N], shape (n,)."""
        column: Floats = self.numbers[0]
        return column

    @property
    def F_fs(self) -> Floats:
        """Static friction forces [N], shape (n,)."""
        column: Floats = self.numbers[1]
        return column

    @cached_property
    def metrics(self) -> Mapping[str, Floats]:
        """Column of each metric in `METRICS`, shape (n,); NaN where unknown."""
        columns = zip(self.names[len(FORCES) :], self.numbers[len(FORCES) :], strict=True)
        return dict.fromkeys(METRIC_NAMES, np.full(len(self), np.nan)) | dict(columns)

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields, without what follows from them."""
        return {column.name: getattr(self, column.name) for column in fields(self)}

    def __len__(self) -> int:
        """Return the number of cases."""
        return len(self.status)

    def __iter__(self) -> Iterator[Row]:
        """Yield the cases as rows."""
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
                self.over.get(i),
            )

    def row(self, i: int) -> Row:
        """Return one case as a row."""
        F_fk, F_fs, *values = self.numbers[:, i].tolist()
        metrics = zip(self.names[len(FORCES) :], values, strict=True)
        return Row(
            {key: column[i].item() for key, column in self.points.items()},
            self.approach,
            F_fk,
            F_fs,
            dict.fromkeys(METRIC_NAMES)
            | {name: _to_value(name, value) for name, value in metrics},
            STATUSES[self.status[i]],
            self.notes.get(i, ""),
            self.over.get(i),
        )

    @classmethod
    def of(cls, first: int, rows: Sequence[Row]) -> Self:
        """Convert rows of one approach to a batch."""
        names = [
            name
            for name in METRIC_NAMES
            if any(row.metrics.get(name) is not None for row in rows)
        ]
        numbers = [
            [row.F_fk for row in rows],
            [row.F_fs for row in rows],
            *([row.metrics.get(name) for row in rows] for name in names),
        ]
        return cls(
            first,
            rows[0].approach,
            {key: np.array([row.point[key] for row in rows]) for key in rows[0].point},
            (*FORCES, *names),
            np.array(numbers, dtype=float),  # None becomes NaN
            np.array([STATUSES.index(row.status) for row in rows], dtype=np.int8),
            {i: row.note for i, row in enumerate(rows) if row.note},
            {i: row.over for i, row in enumerate(rows) if row.over},
        )

    def values(self, name: str) -> list[float | int | None]:
        """Return a metric of all cases, None where unknown."""
        return _to_values(name, self.metrics[name])

    def has_numbers(self) -> NDArray[np.bool_]:
        """Return which cases have numbers, shape (n,)."""
        has_numbers: NDArray[np.bool_] = self.status == STATUSES.index(OK)
        return has_numbers

    def part(self, which: slice | NDArray[np.bool_]) -> Self:
        """Return some of the cases; `first` remains that of all."""
        numbers = np.arange(len(self))[which].tolist()
        return replace(
            self,
            points={key: column[which] for key, column in self.points.items()},
            numbers=self.numbers[:, which],
            status=self.status[which],
            notes={i: self.notes[k] for i, k in enumerate(numbers) if k in self.notes},
            over={i: self.over[k] for i, k in enumerate(numbers) if k in self.over},
            text=b"",
        )

    @classmethod
    def join(cls, batches: Sequence[Self]) -> Self:
        """Return the cases of consecutive batches of one approach as one batch."""
        firsts = [0, *accumulate(map(len, batches))]
        stored = {name for batch in batches for name in batch.names}
        names = (*FORCES, *(name for name in METRIC_NAMES if name in stored))

        def by_index(several: Iterable[Mapping[int, Any]]) -> dict[int, Any]:
            parts = zip(firsts, several, strict=False)
            return {first + i: value for first, part in parts for i, value in part.items()}

        return cls(
            batches[0].first,
            batches[0].approach,
            {
                key: np.concatenate([batch.points[key] for batch in batches])
                for key in batches[0].points
            },
            names,
            np.concatenate([batch.select(names) for batch in batches], axis=1),
            np.concatenate([batch.status for batch in batches]),
            by_index(batch.notes for batch in batches),
            by_index(batch.over for batch in batches),
        )

    def select(self, names: Sequence[str]) -> Floats:
        """Return rows of `numbers` by their names, NaN where unknown."""
        rows = dict(zip(self.names, self.numbers, strict=True))
        unknown = np.full(len(self), np.nan)
        return np.array([rows.get(name, unknown) for name in names])


BatchCallback = Callable[[Batch], None]


def ignore_batch(batch: Batch) -> None:
    """Do nothing: the default callback."""


def _to_value(name: str, value: float) -> float | int | None:
    """Convert one value of a metric, NaN to None."""
    return None if value != value else _to_number(name, value)


def _to_number(name: str, value: float) -> float | int:
    """Convert a known value of a metric; a mean of counts stays a float."""
    return int(value) if name in COUNT_METRICS and value.is_integer() else value


def _to_values(name: str, column: Floats) -> list[float | int | None]:
    """Convert a column to values, NaN to None."""
    if name in COUNT_METRICS:
        return [_to_value(name, value) for value in column.tolist()]
    if np.isnan(column).any():
        return [None if value != value else value for value in column.tolist()]
    values: list[float | int | None] = column.tolist()
    return values


MAX_CACHED_ROWS = 20_000
"""Number of rows up to which they are converted once and cached: about 30 MB."""

ROWS_PER_BATCH = 4096
"""Rows per batch where rows are converted to batches."""


class Rows(LazySequence[Row]):
    """Rows of consecutive batches; `lengths` avoids reading batches that are on disk."""

    def __init__(self, batches: Sequence[Batch], lengths: Sequence[int] = ()) -> None:
        self.batches = batches
        *self._firsts, self._length = 0, *accumulate(lengths or map(len, batches))
        self._cached: tuple[Row, ...] | None = None

    def __len__(self) -> int:
        """Return the number of rows."""
        return self._length

    def __iter__(self) -> Iterator[Row]:
        """Yield the rows in order."""
        if self._length > MAX_CACHED_ROWS:
            return chain.from_iterable(self.batches)
        if self._cached is None:
            self._cached = tuple(chain.from_iterable(self.batches))
        return iter(self._cached)

    def __eq__(self, other: object) -> bool:
        """Return whether another sequence has equal rows."""
        if not isinstance(other, Sequence) or len(other) != len(self):
            return False
        return all(mine == theirs for mine, theirs in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Return the number of rows."""
        return f"<Rows: {len(self)}>"

    def item(self, number: int) -> Row:
        """Return one row."""
        index = bisect_right(self._firsts, number) - 1
        return self.batches[index].row(number - self._firsts[index])


def as_batches(rows: Iterable[Row]) -> Iterable[Batch]:
    """Return rows as batches, each of one approach."""
    return rows.batches if isinstance(rows, Rows) else group_batches(rows)


def group_batches(rows: Iterable[Row]) -> Iterator[Batch]:
    """Yield rows as batches of up to `ROWS_PER_BATCH` rows of one approach."""
    first = 0
    for _, group in groupby(rows, key=lambda row: (row.approach, tuple(row.point))):
        several = list(group)
        for start in range(0, len(several), ROWS_PER_BATCH):
            part = several[start : start + ROWS_PER_BATCH]
            yield Batch.of(first, part)
            first += len(part)


# Statistics over seeds.


CONFIDENCE = 0.95
"""Confidence level: share of ensembles whose interval contains the true mean [-]."""

NORMAL_95 = 1.959964
"""Two-sided quantile of the normal distribution at `CONFIDENCE`."""

QUANTILES = (0.05, 0.50, 0.95)
"""Levels of the quantiles over seeds [-]."""


def quantiles_of_draws(values: NDArray[np.float64], levels: Sequence[float]) -> list[float]:
    """Return quantiles of the draws of a fit."""
    quantiles: list[float] = np.quantile(values, levels, method="hazen").tolist()
    return quantiles


def median_and_ends(values: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the median of draws, and the ends of the interval that holds 95 % of them."""
    low, median, high = quantiles_of_draws(values, (0.025, 0.5, 0.975))
    return median, low, high


def share_of_draws(count: int) -> str:
    """Return how many draws the interval of `median_and_ends` holds."""
    every = f"all {count} draws" if count > 1 else "1 draw"
    return "95 %" if 0.025 * count > 0.5 else every


class Statistic(NamedTuple):
    """Statistics of a metric over the seeds for which it is known, in its unit."""

    seeds: int
    """Number of these seeds."""
    mean: float
    half_width: float | None
    """Half-width of the confidence interval of the mean, by Student's t; None for one seed."""
    std: float | None
    """Sample standard deviation (n - 1); None for one seed."""
    quantiles: tuple[float, ...]
    """At the levels `QUANTILES`."""
    least: tuple[float, int]
    greatest: tuple[float, int]
    """Extreme value, and the first seed that has it."""


def statistics(seeds: Batch) -> dict[str, Statistic | None]:
    """Return the statistics of every metric over a case per seed; None if no seed knows it."""
    return {name: _statistic(seeds, name) for name in METRIC_NAMES}


def means(seeds: Batch) -> dict[str, tuple[float, float | None]]:
    """Return mean and half-width, as `interval`, of every metric that a seed knows."""
    finite = {name: column[np.isfinite(column)] for name, column in seeds.metrics.items()}
    return {name: _moments(series)[:2] for name, series in finite.items() if len(series)}


def _statistic(seeds: Batch, name: str) -> Statistic | None:
    """Return the statistics of one metric."""
    column = seeds.metrics[name]
    is_finite = np.isfinite(column)
    if not is_finite.any():
        return None
    series, numbers = column[is_finite], seeds.points[SEED_KEY][is_finite]
    # Median-unbiased quantiles do not depend on the distribution (Hyndman & Fan 1996, type 8).
    quantiles = np.quantile(series, QUANTILES, method="median_unbiased").tolist()
    least, greatest = (
        (_to_number(name, series[i].item()), numbers[i].item())
        for i in (series.argmin(), series.argmax())
    )
    return Statistic(len(series), *_moments(series), tuple(quantiles), least, greatest)


def interval(values: Iterable[float]) -> tuple[float, float | None]:
    """Return the mean of values and the half-width of its confidence interval.

    The half-width is None for a single value.

    Notes
    -----
    The sums are exact (`math.fsum`), so the result does not depend on the order of the values.
    """
    mean, half_width, _ = _moments(np.array([*values], dtype=float))
    return mean, half_width


def _moments(values: Floats) -> tuple[float, float | None, float | None]:
    """Return mean, half-width of its interval, and standard deviation."""
    n, least = len(values), values.min().item()
    # Scaled by the range: equal values have exactly that mean, and no square overflows.
    span = values.max().item() - least or 1.0
    shares = (values - least) / span
    share = fsum(shares.tolist()) / n
    mean = least + span * share
    if n < 2:
        return mean, None, None
    std = span * sqrt(fsum(((shares - share) ** 2).tolist()) / (n - 1))
    return mean, student_t(n - 1) * std / sqrt(n), std


@cache
def student_t(degrees_of_freedom: float) -> float:
    """Return the two-sided quantile of Student's t distribution at `CONFIDENCE`."""
    from scipy.special import stdtrit  # not needed without seeds

    return float(stdtrit(degrees_of_freedom, 0.5 + 0.5 * CONFIDENCE))


def seed_column(row: Row, name: str) -> Floats:
    """Return the values of a metric kept for each seed, NaN where unknown; else empty."""
    values = row.over.values.get(name, ()) if row.over else ()
    return np.array(values, dtype=float)


def judged_value(check: Check, row: Row) -> float | None:
    """Return the value of a case that a check judges; None if it is unknown."""
    if check.judges == MEAN or row.over is None:
        return row.metrics.get(check.metric)
    values = seed_column(row, check.metric)
    value = float(check.over_seeds(values)) if len(values) else nan
    return None if isnan(value) else value


def judged_column(check: Check, batch: Batch) -> Floats:
    """Return the values that a check judges, shape (n,); NaN where unknown."""
    column = batch.metrics[check.metric]
    if check.judges == MEAN or not batch.over:
        return column
    column = column.copy()
    for i in batch.over:
        value = judged_value(check, batch.row(i))
        column[i] = nan if value is None else value
    return column


def with_seeds(
    verdict: Verdict, half_width: float | None, count: int, values: Floats, seeds: NDArray[Any]
) -> Verdict:
    """Return a verdict over seeds with the interval of a mean, how many seeds fail, and which.

    `values` are those of single seeds, NaN where not known; empty if they are not kept. A check
    that does not apply has no such numbers.
    """
    if verdict.passed is None:
        return verdict
    check = verdict.check
    is_finite = np.isfinite(values)
    values, seeds = values[is_finite], seeds[is_finite]
    failed = int((~check.holds(values)).sum())
    verdict = replace(verdict, seeds=len(values) or count, failed_seeds=failed)
    if check.judges == MEAN:
        return replace(verdict, half_width=half_width)
    if check.judges != EVERY_SEED or not failed:
        return verdict
    return replace(verdict, worst_seed=int(seeds[check.excess(values).argmax()]))


def judge_row(check: Check, row: Row, where: Point | None = None) -> Verdict:
    """Return the verdict on a case to which a check applies, over its seeds if it has several.

    `where` is the place of the case; default: all its swept keys.
    """
    status = "" if row.status == OK else row.status
    place = row.point if where is None else where
    verdict = check.verdict(judged_value(check, row), place, status)
    if row.over is None:
        return verdict
    width, values = row.half_widths.get(check.metric), seed_column(row, check.metric)
    seeds = row.over.first + np.arange(len(values))
    return with_seeds(verdict, width, row.seeds, values, seeds)


# Seeds of a scenario and their stopping rule.

SEEDS_PER_CHECK = 10
"""Seeds between two evaluations of the stopping rule. The rule is evaluated at fixed numbers of
seeds, in order, so the decision does not depend on which seed finishes first."""


def max_seeds(scenario: Scenario) -> int:
    """Return the largest number of seeds of a scenario; 1 without `seeds`."""
    excitation = scenario.excitation
    return excitation.max_seeds if isinstance(excitation, RandomMotion) else 1


def averages_seeds(scenario: Scenario) -> bool:
    """Return whether the cases of a scenario are means over seeds."""
    swept = any(axis.key == "excitation.seeds" for axis in scenario.sweep)
    return swept or max_seeds(scenario) > 1


def stopping_rule(scenario: Scenario) -> Until | None:
    """Return the stopping rule `until` of a scenario; None for a fixed number of seeds."""
    excitation = scenario.excitation
    return excitation.until if isinstance(excitation, RandomMotion) else None


def seed_range(scenario: Scenario) -> range:
    """Return all seeds of a scenario, as many as the stopping rule may need."""
    excitation = scenario.excitation
    assert isinstance(excitation, RandomMotion), "only random base motion has seeds"
    return range(excitation.seed, excitation.seed + excitation.max_seeds)


def with_seed(scenario: Scenario, seed: int) -> Scenario:
    """Return the scenario with a single seed."""
    excitation = scenario.excitation
    assert isinstance(excitation, RandomMotion), "only random base motion has seeds"
    return scenario.copy_with({"excitation": excitation.with_seed(seed)})


def unused_seeds_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn that only the first seed is used where many are requested."""
    if max_seeds(scenario) > 1:
        first = seed_range(scenario)[0]
        sentence = f"excitation.seeds is ignored: only the first seed, {first}, is used"
        yield WarningMessage("one-seed", sentence, {"seed": first})


def needed_seeds(scenario: Scenario, batches: Iterable[Batch]) -> Batch:
    """Return the first seeds, in order, until the stopping rule is satisfied."""
    until, solved, values = stopping_rule(scenario), list[Batch](), list[float]()
    for batch in batches:
        solved.append(batch)
        if until is None:
            continue
        checked = len(values) // SEEDS_PER_CHECK * SEEDS_PER_CHECK
        values += batch.metrics[until.metric].tolist()
        for count in range(checked + SEEDS_PER_CHECK, len(values) + 1, SEEDS_PER_CHECK):
            if is_narrow(until, values[:count]):
                return Batch.join(solved).part(slice(count))
    return Batch.join(solved)


def is_narrow(until: Until, values: Sequence[float]) -> bool:
    """Whether the interval of the values of a metric, by seed, satisfies a stopping rule.

    It does not while the metric is unknown for any seed, or a seed has failed.
    """
    if len(values) < 2 or any(map(isnan, values)):
        return False
    mean, half_width = interval(values)
    return half_width is not None and half_width <= until.half_width * abs(mean)
