"""Table of many cases without their responses, and statistics over its cases.

`Tally` gathers the statistics of one approach (extremes with their cases, quantiles, verdicts,
confidence intervals) batch by batch, in memory that does not depend on the number of cases.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from itertools import islice, takewhile
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Input, RecordSummary, Samples, Sines, StrokeLimits
from drysim.errors import WarningMessage
from drysim.excitation.harmonic import Shock
from drysim.metrics.checks import EVERY_SEED, STATUS, Check, Verdict, violation
from drysim.metrics.table import (
    HOURLY_STROKE,
    HOURLY_STROKES_BY_SIDE,
    METRICS,
    STROKE_USED,
    UNITS,
    Metrics,
)
from drysim.metrics.text import format_metric_ranges
from drysim.scenario.axes import (
    DIRECTION_KEY,
    FILE_KEY,
    FREQUENCY_KEY,
    Axis,
    are_draws,
    chain_length,
    count_points,
)
from drysim.scenario.model import LIMIT_KEYS, STATIC_RATIO, Scenario
from drysim.scenario.text import describe_case
from drysim.study.outcome import (
    Result,
    count_verdicts,
    format_repr,
)
from drysim.study.statistics import (
    FAILED,
    FORCES,
    OK,
    STATUSES,
    Batch,
    Row,
    as_batches,
    judge_row,
    judged_column,
    judged_value,
)
from drysim.wording import Point, format_count, format_number, format_percent, format_unit


@dataclass(frozen=True, eq=False)
class Table(Result):
    """All cases of a sweep or of a comparison.

    Attributes
    ----------
    scenario : Scenario
    axes : tuple of Axis
        Swept keys with unit and values; the first varies fastest. Empty for a comparison of one
        case.
    rows : sequence of Row
        Approach by approach, each in the order of the grid.
    checks : tuple of Verdict
    warnings : tuple of WarningMessage
    complete : bool
        Whether every case was computed.
    motion : Sines or Samples or None
        Base motion, if all cases share one.
    numerics : mapping
        Core, reason, engine, step, as far as all cases share them.
    summary : mapping
        `Tally` by approach, if it was gathered during the computation.
    inputs : tuple of Input
        Records of the base motion.
    records : tuple of RecordSummary
        The swept records; none for other sweeps.
    jumps : tuple of Jump or None
        Where the answer jumps along an interval of the static ratio; None without one.
    """

    kind: ClassVar[str] = "sweep"

    scenario: Scenario
    axes: tuple[Axis, ...]
    rows: Sequence[Row]
    checks: tuple[Verdict, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    complete: bool = True
    motion: Sines | Samples | None = field(default=None, compare=False)
    numerics: Mapping[str, object] = field(default_factory=dict, compare=False)
    summary: Mapping[str, Tally] = field(default_factory=dict, compare=False)
    inputs: tuple[Input, ...] = ()
    records: tuple[RecordSummary, ...] = ()
    jumps: tuple[Jump, ...] | None = None

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        """Yield the rows in order."""
        return iter(self.rows)

    def __getitem__(self, number: int) -> Row:
        """Return one row."""
        return self.rows[number]

    def __repr__(self) -> str:
        """Return cases, ranges of the key metrics, and verdicts in one line."""
        name, verdicts = self.scenario.name, count_verdicts(self.checks, self.warnings)
        tallies = list(self.tallies.values())
        summary = [
            f"{format_count(tally.cases, 'case')} by {tally.approach}" for tally in tallies
        ]
        tally = self._judged_tally
        ranges = (
            f"{format_metric_ranges(tally.ends)}{f' by {tally.approach}' * (len(tallies) > 1)}"
            if tally
            else ""
        )
        best = f"best {self.best.result}" if self.best else ""
        return format_repr("Table", name, ", ".join(summary), ranges, best, verdicts)

    @property
    def approaches(self) -> tuple[str, ...]:
        """Approaches, in the order in which they were requested."""
        return tuple(self.tallies)

    @cached_property
    def tallies(self) -> Mapping[str, Tally]:
        """Statistics of the cases by approach, in the order of the request."""
        return self.summary or Tally.of(as_batches(self.rows), self.scenario)

    @property
    def own_tally(self) -> Tally | None:
        """Statistics of the scenario's own approach; of a comparison, of the first one."""
        return next(iter(self.tallies.values()), None)

    @property
    def _judged_tally(self) -> Tally | None:
        """Statistics of the approach under the checks; in a comparison the reference."""
        return next((tally for tally in self.tallies.values() if tally.checks), self.own_tally)

    @cached_property
    def best(self) -> BestCase | None:
        """The best admissible case of the scenario's approach.

        None unless the cases are designs to choose from: under the same base motion or the same
        records, and limited by a stroke limit or by checks. A static ratio known within bounds
        only is no choice, nor are the draws of a fit. None before all cases are computed.
        """
        if (
            not self.complete
            or self.jumps is not None
            or any(axis.source is not None for axis in self.axes)
        ):
            return None
        tally, limits = self._judged_tally, self.scenario.checks or self.scenario.stroke
        designs = [axis for axis in self.axes if axis.key != FILE_KEY]
        if tally is None or not designs or not has_shared_motion(designs) or not limits:
            return None
        of_shock = isinstance(self.scenario.excitation, Shock)
        names = (name for name in OBJECTIVES if of_shock or name != "x_dd_peak")
        objective = next((name for name in names if name in tally.extremes), None)
        if objective is None:
            return None
        extreme, over_records = tally.best.get(objective), None
        if len(designs) < len(self.axes):
            over_records = self._best_design(tally, objective)
        closest = None if extreme else self._closest(tally, 1, 1)
        row = extreme and extreme.row
        return BestCase(objective, row, tally.admissible, tally.cases, closest, over_records)

    @property
    def is_of_draws(self) -> bool:
        """Whether the cases are the draws of a fit, and differ in nothing else."""
        return are_draws(self.axes)

    def values_of(self, metric: str) -> NDArray[np.float64]:
        """Return the values of a metric in the own cases that have one."""
        tally = self.own_tally
        if tally is None:
            return np.empty(0)
        values = self._column(tally, lambda batch: batch.metrics[metric])
        return values[np.isfinite(values)]

    @cached_property
    def hysteresis(self) -> tuple[Hysteresis, ...] | None:
        """Where the sweeps up and down differ, for each pair of them that does.

        None unless the scenario was swept in both directions, and completely.
        """
        directions = next((a.values for a in self.axes if a.key == DIRECTION_KEY), ())
        tally = self.own_tally
        if len(directions) < 2 or not self.complete or tally is None:
            return None
        length = chain_length(self.axes)
        T_a = self._column(tally, lambda batch: batch.metrics["T_a"]).reshape(2, -1, length)
        values = self.axes[0].take(np.arange(length))
        with np.errstate(invalid="ignore"):
            gap = abs(T_a[0] - T_a[1]) / np.fmax(*T_a)
        gap = np.where(np.isnan(T_a[0]) == np.isnan(T_a[1]), np.nan_to_num(gap), np.inf)
        differences = []
        for chain in np.flatnonzero((gap > HYSTERESIS_TOLERANCE).any(axis=1)).tolist():
            differ = values[gap[chain] > HYSTERESIS_TOLERANCE]
            finite = np.where(np.isfinite(gap[chain]), gap[chain], 0.0)
            place = chain * length + int(np.argmax(finite if finite.any() else gap[chain]))
            up, down = (self._row_of(tally, place + k * gap.size) for k in (0, 1))
            differences.append(Hysteresis(differ.min().item(), differ.max().item(), up, down))
        return tuple(differences)

    @cached_property
    def isolation(self) -> tuple[Isolation, ...] | None:
        """Where isolation begins on each curve over the frequency.

        None without such curves, and for more than `MAX_ISOLATION_CASES` cases. A frequency
        with unknown T_a counts as not isolated.
        """
        tally = self.own_tally
        if tally is None or not self.has_frequency_curves or tally.cases > MAX_ISOLATION_CASES:
            return None
        # Copies: a view would keep all columns of its batch in memory.
        parts = [
            {key: np.array(column) for key, column in batch.points.items()}
            | {"T_a": np.array(batch.metrics["T_a"])}
            for batch in self._batches_of(tally)
        ]
        columns = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
        f = columns.pop(FREQUENCY_KEY)
        amplifies = ~(columns.pop("T_a") < 1.0)
        curve = np.zeros(len(f), dtype=np.intp)  # number of the curve of each case
        for column in columns.values():
            values, inverse = np.unique(column, return_inverse=True)
            _, curve = np.unique(curve * len(values) + inverse, return_inverse=True)
        _, first = np.unique(curve, return_index=True)
        highest, begin = np.full(len(first), -np.inf), np.full(len(first), np.inf)
        np.maximum.at(highest, curve[amplifies], f[amplifies])
        above = f > highest[curve]
        np.minimum.at(begin, curve[above], f[above])
        return tuple(
            Isolation(
                {key: column[first[i]].item() for key, column in columns.items()},
                float(begin[i]) if begin[i] < np.inf else None,
            )
            for i in np.argsort(first)
        )

    @property
    def has_frequency_curves(self) -> bool:
        """Whether all of the frequency is swept by itself, and T_a is known in some case."""
        has_values = self.own_tally is not None and "T_a" in self.own_tally.extremes
        return (
            self.complete
            and has_values
            and any(
                axis.key == FREQUENCY_KEY and len(axis.values) > 1 and not axis.group
                for axis in self.axes
            )
        )

    @property
    def answers(self) -> list[tuple[str, BestCase]]:
        """The best case, and the best design over all records, with their names."""
        named = [("best", self.best), ("all records", self.best and self.best.over_records)]
        return [(name, case) for name, case in named if case]

    def _best_design(self, tally: Tally, objective: str) -> BestCase:
        """Return the best values of the other keys, each judged by its worst record."""

        def values(batch: Batch) -> NDArray[np.float64]:
            return np.where(
                is_admissible(batch, tally.checks), batch.metrics[objective], np.inf
            )

        keys = next(batch.points for batch in self._batches_of(tally))
        axes = [axis for axis in self.axes if axis.key in keys]
        records = next(len(axis.values) for axis in axes if axis.key == FILE_KEY)
        stride = count_points(list(takewhile(lambda axis: axis.key != FILE_KEY, axes)))
        worst, number = minmax_design(self._column(tally, values), records, stride)
        admissible = int((worst != np.inf).sum())
        row = None if number is None else self._row_of(tally, number)
        closest = None if row else self._closest(tally, records, stride)
        return BestCase(objective, row, admissible, len(worst), closest, kind="design")

    def _closest(self, tally: Tally, records: int, stride: int) -> Verdict | None:
        """Return the check that the case closest to admissible fails by most."""
        misses = self._column(tally, lambda batch: misses_of(batch, tally.checks).max(axis=0))
        _, number = minmax_design(misses, records, stride)
        if number is None:
            return None
        row = self._row_of(tally, number)
        by_check = misses_of(Batch.of(0, [row]), tally.checks)[:, 0]
        check = (STROKE_LIMIT, *tally.checks)[int(by_check.argmax())]
        if check is not STROKE_LIMIT or row.over is None:
            return check.verdict(judged_value(check, row), row.point)
        every = replace(STROKE_LIMIT, judges=EVERY_SEED)
        verdict = every.verdict(row.largest(STROKE_USED), row.point)
        return replace(verdict, seeds=row.seeds, failed_seeds=seeds_beyond(row))

    def _batches_of(self, tally: Tally) -> Iterator[Batch]:
        """Yield the batches of one approach."""
        return (batch for batch in as_batches(self.rows) if batch.approach == tally.approach)

    def _column(
        self, tally: Tally, values: Callable[[Batch], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Return one number per case of an approach."""
        return np.concatenate([values(batch) for batch in self._batches_of(tally)])

    def _row_of(self, tally: Tally, number: int) -> Row:
        """Return a case of an approach by its number."""
        before = takewhile(lambda other: other is not tally, self.tallies.values())
        return self.rows[sum(other.cases for other in before) + number]

    @property
    def has_failed_cases(self) -> bool:
        """Whether the numerics failed in a case."""
        return any(FAILED in tally.lost for tally in self.tallies.values())

    @property
    def own(self) -> tuple[Row, ...]:
        """Rows of the scenario's own approach, without those of its reference."""
        return tuple(islice(self, self.own_tally.cases if self.own_tally else 0))

    def of(self, approach: str) -> Iterator[Row]:
        """Yield the rows of one approach."""
        return (row for row in self.rows if row.approach == approach)


HYSTERESIS_TOLERANCE = 1e-6
"""Relative difference of T_a above which two motions are different ones [-]."""


class Hysteresis(NamedTuple):
    """Difference between a sweep up and the sweep down along the same values."""

    low: float
    high: float
    """Least and greatest value of the first key at which T_a differs."""
    up: Row
    down: Row
    """The case with the greatest difference of T_a, in both directions."""

    @property
    def point(self) -> dict[str, Any]:
        """Values of the swept keys at the greatest difference, without the direction."""
        return {key: value for key, value in self.up.point.items() if key != DIRECTION_KEY}

    @property
    def gap(self) -> float:
        """Greatest difference of T_a [-]; 0 if it is unknown in one of the directions."""
        up, down = self.up.metrics["T_a"], self.down.metrics["T_a"]
        return 0.0 if up is None or down is None else abs(up - down)


JUMP_METRICS = ("T_a", "x_r_rms", "x_r_peak", "stuck_share")
"""Metrics by which motions are told apart."""


class Isolation(NamedTuple):
    """Frequency [Hz] above which T_a stays below 1; None if there is none."""

    point: Point
    above: float | None


MAX_ISOLATION_CASES = 1_000_000
"""Cases up to which the isolation on each curve is determined; they are read once more."""

RATIO_KEY = ".".join(map(str, STATIC_RATIO))
"""Key of which only an interval may be known."""


class Jump(NamedTuple):
    """Value at which the answer jumps, and the cases closest to it on both sides."""

    value: float
    below: Row
    above: Row

    @property
    def point(self) -> dict[str, Any]:
        """Values of the swept keys, without the static ratio."""
        return {key: value for key, value in self.below.point.items() if key != RATIO_KEY}


class BestCase(NamedTuple):
    """The admissible case with the least objective; no row if there is none."""

    objective: str
    """One of the `OBJECTIVES`."""
    row: Row | None
    admissible: int
    cases: int
    """Number of cases that stay within the stroke limit and keep all checks, and of all."""
    closest: Verdict | None = None
    """If no case is admissible: the check that the case closest to it fails by most, relative
    to the limit; the stroke limit counts as `stroke_used < 1`."""
    over_records: BestCase | None = None
    """In a sweep over records, the same for designs, the values of all other keys. A design
    counts as its worst record, and is admissible only if it is with every record."""
    kind: str = "case"
    """What is chosen: a `case`, or a `design` over all records."""

    @property
    def value(self) -> float | None:
        """The least objective; None if no case is admissible."""
        return None if self.row is None else self.row.metrics[self.objective]

    @property
    def result(self) -> str:
        """The objective and its value, or `none`."""
        unit = format_unit(UNITS[self.objective])
        has_value = self.row is not None
        return f"{self.objective} {format_number(self.value, unit)}" if has_value else "none"

    def describe(self, axes: Sequence[Axis], least: str = "") -> str:
        """Describe where the best case is, or which check the closest one fails.

        `least` is said in between if no case is admissible.
        """
        if self.row is None:
            sentence = f"no {self.kind} of {self.cases} is admissible{least}"
            if self.closest:
                where = describe_case(self.closest.where or {}, axes)
                check = f"{self.closest.check}{self.closest.share}"
                worst = "worst " * bool(self.closest.failed_seeds)
                value = f"{worst}{self.closest.described_value}"
                sentence += f"; the closest fails {check}, {value} at {where}"
            return sentence
        of = f"least of {self.admissible} admissible {self.kind}s of {self.cases}"
        if self.kind == "design":
            of = f"{self.row.point[FILE_KEY]} being its worst record; {of}"
        if (stuck := self.row.metrics.get("stuck_share") or 0.0) > MOSTLY_STUCK:
            of += f"; stuck for {format_percent(stuck)} of the time"
        return "; ".join([f"at {self.place(axes)}, {of}", *self._ends(axes)])

    def _ends(self, axes: Sequence[Axis]) -> Iterator[str]:
        """Yield the keys whose value is an end of their range: a better one may lie beyond."""
        point = self.row.point if self.row else {}
        for axis in axes:
            value = point.get(axis.key)
            if axis.group or isinstance(value, str) or len(axis.values) < MIN_RANGE:
                continue
            ends = axis.range
            if value is None or value not in (ends.low, ends.high):
                continue
            if value in axis.bounds:
                continue
            side = "lower" if value == min(ends.low, ends.high) else "upper"
            where = describe_case({axis.key: value}, axes)
            yield f"{where} is the {side} end of its range"

    def place(self, axes: Sequence[Axis]) -> str:
        """The values of the best case, without the record if it is the best over all."""
        point = dict(self.row.point) if self.row else {}
        if self.kind == "design":
            point.pop(FILE_KEY, None)
        return describe_case(point, axes)


MIN_RANGE = 3
"""Least number of values of a key that are a range, in which a better one is sought."""

MOSTLY_STUCK = 0.5
"""Share of the time from which a best case that sticks is said to."""


MOTION_KEYS = ("excitation.", "solver.step", "measure.")
"""Prefixes of the keys that change the base motion."""


def has_shared_motion(axes: Iterable[Axis]) -> bool:
    """Whether all cases have the same base motion."""
    return not any(axis.key.startswith(MOTION_KEYS) for axis in axes)


def minmax_design(
    values: NDArray[np.float64], records: int, stride: int
) -> tuple[NDArray[np.float64], int | None]:
    """Return the worst value of each design over the records, and the case of the smallest.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One value per case; NaN where it is unknown, infinite where the design is excluded.
    records : int
        Number of records, which are one axis of the grid of cases.
    stride : int
        Number of cases between one record and the next, in the order of the grid.

    Returns
    -------
    worst : ndarray, shape (n/records,)
    case : int or None
        Index into `values`; the first design, and its first record, wins a tie. None if no
        design has a finite value.
    """
    grid = values.reshape(-1, records, stride)
    worst = np.fmax.reduce(grid, axis=1)
    least = np.fmin.reduce(worst, axis=None)
    if not np.isfinite(least):
        return worst.ravel(), None
    high, low = divmod(int(np.argmax(worst == least)), stride)
    record = int(np.argmax(grid[high, :, low] == least))
    return worst.ravel(), (high * records + record) * stride + low


def stroke_limits(scenario: Scenario, point: Mapping[str, Any]) -> StrokeLimits | None:
    """Return the stroke limits of a case [m], with the swept values of its point; or None.

    With columns of values, the limits are columns, too.
    """
    swept = {key: value for key, value in point.items() if key in LIMIT_KEYS}
    stroke = scenario.with_values(swept).stroke if swept else scenario.stroke
    return None if stroke is None else stroke.limits


def largest_excess(metrics: Metrics, limits: StrokeLimits) -> tuple[str, float, float]:
    """Return name and value of the displacement farthest beyond its limit, and by how much [m].

    It is that of the whole run, relative to its limit. With equal limits it is |x_r|.
    """
    reached, share = metrics["stroke_suffices"] or 0.0, metrics[STROKE_USED] or 0.0
    if limits.up == limits.down:
        return "|x_r|", reached, reached - limits.up
    limit, up = (array.item() for array in nearest_limit(reached, share, limits))
    return "x_r", share * limit if up else -share * limit, (share - 1.0) * limit


def nearest_limit(
    reached: Any, share: Any, limits: StrokeLimits
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the limit of which the largest share is used [m], and whether it is the upper one.

    `reached` is the largest |x_r| [m]. Where the share is that of the larger limit, no
    displacement is larger.
    """
    larger, smaller = np.maximum(*limits), np.minimum(*limits)
    at_larger: NDArray[np.bool_] = np.asarray(
        reached >= share * larger * (1.0 - SHARE_ROUNDING)
    )
    up = np.asarray((np.asarray(limits.up) > limits.down) == at_larger)
    return np.asarray(np.where(at_larger, larger, smaller), dtype=np.float64), up


def hourly_shares(
    metrics: Mapping[str, Any], limits: StrokeLimits
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the shares of the upper and the lower limit that are reached once an hour [-].

    They are 0 if unknown, and of equal limits the same, that of |x_r|. Metrics and limits may
    be columns.
    """
    stroke, *by_side = (
        np.asarray(metrics.get(name), float)
        for name in (HOURLY_STROKE, *HOURLY_STROKES_BY_SIDE)
    )
    up, down = (
        np.nan_to_num(np.where(np.equal(*limits), stroke, side) / limit)
        for side, limit in zip(by_side, limits, strict=True)
    )
    return up, down


class HourlyStroke(NamedTuple):
    """The displacement reached once an hour that uses the largest share of its limit."""

    share: float
    x_r: float
    """Displacement [m]; of equal limits its magnitude."""
    limit: str
    """Name of the limit."""


def hourly_stroke_used(metrics: Metrics, limits: StrokeLimits) -> HourlyStroke:
    """Return what is reached once an hour of the limit of which the largest share is used."""
    up, down = (share.item() for share in hourly_shares(metrics, limits))
    if limits.up == limits.down:
        return HourlyStroke(up, up * limits.up, "the limit")
    if up >= down:
        return HourlyStroke(up, up * limits.up, "the upper limit")
    return HourlyStroke(down, -down * limits.down, "the lower limit")


SHARE_ROUNDING = 1e-12
"""Relative difference of two displacements that is rounding [-]."""


# Statistics of the cases of one approach, updated batch by batch.

OBJECTIVES = "SEAT", "x_dd_peak", "T_a"
"""Metrics of which the best case has the least value: SEAT where the vibration is weighted, the
peak acceleration under a shock."""


class Extreme(NamedTuple):
    """Least or greatest value of a metric, and its row."""

    value: float
    row: Row


LimitsOf = Callable[[Mapping[str, Any]], StrokeLimits | None]
"""Function that returns the stroke limits at a point, or columns of them."""

RowAt = Callable[[int], Row]
"""Function that returns a row by its index in a batch."""


@dataclass
class Tally:
    """Statistics of the cases of one approach."""

    approach: str
    checks: Sequence[Check] = ()
    """Checks that apply to these cases."""
    limits_of: LimitsOf = lambda _: None
    """Returns the stroke limits at a point, or None."""
    cases: int = 0
    beyond: int = 0
    """Number of cases, and of those that exceed the stroke limit."""
    lost: dict[str, Count] = field(default_factory=dict)
    """Number and first of the cases without numbers, by status."""
    extremes: dict[str, tuple[Extreme, Extreme]] = field(default_factory=dict)
    """Least and greatest value of each metric over the cases with numbers; the first case wins
    a tie."""
    quantiles: dict[str, Quantiles] = field(
        default_factory=lambda: {
            metric.name: Quantiles() for metric in METRICS if metric.with_quantiles
        }
    )
    """`Quantiles` over the cases with numbers, of the metrics `with_quantiles`."""
    too_short: Count | None = None
    """Cases that keep the stroke limit but reach more than it once an hour, and the worst."""
    worst: Row | None = None
    """The case that exceeds its stroke limit by most."""
    admissible: int = 0
    """Number of cases that stay within the stroke limit and keep all checks."""
    best: dict[str, Extreme] = field(default_factory=dict)
    """The first of these cases with the least value of each of the `OBJECTIVES`."""
    seeds: SeedSummary | None = None
    """Statistics of the means, if the cases have several seeds."""
    forces: list[float] = field(default_factory=lambda: [np.inf, -np.inf, np.inf, -np.inf])
    """Least and greatest F_fk, least and greatest F_fs [N]."""
    _most_beyond: float = -np.inf
    _shortest: float = 0.0
    _verdicts: dict[int, Verdict] = field(default_factory=dict)
    _failed: Counter[int] = field(default_factory=Counter)
    _judged: Counter[int] = field(default_factory=Counter)

    @classmethod
    def of(
        cls, batches: Iterable[Batch], scenario: Scenario, checked: str = ""
    ) -> dict[str, Self]:
        """Return the tally of each approach, in order; the checks apply to `checked`."""
        limits_of = partial(stroke_limits, scenario)
        tallies: dict[str, Self] = {}
        for batch in batches:
            name = batch.approach
            if name not in tallies:
                tallies[name] = cls(name, scenario.checks if name == checked else (), limits_of)
            tallies[name].add(batch)
        return tallies

    @property
    def ends(self) -> dict[str, tuple[float, float]]:
        """Least and greatest value of each metric that is known in some case."""
        return {name: (low.value, high.value) for name, (low, high) in self.extremes.items()}

    def add(self, batch: Batch) -> None:
        """Add a batch; batches come in order."""
        self.cases += len(batch)
        ends = batch.F_fk.min(), batch.F_fk.max(), batch.F_fs.min(), batch.F_fs.max()
        pick = (min, max, min, max)
        self.forces = [float(p(a, b)) for p, a, b in zip(pick, self.forces, ends, strict=True)]
        good, row = batch.status == STATUSES.index(OK), cache(batch.row)
        self._count_lost(batch, row)
        self._update_extremes(batch, good, row)
        for name, quantiles in self.quantiles.items():
            quantiles.add(batch.metrics[name][good])
        self._update_limit(batch, row)
        self._update_best(batch, row)
        if batch.over:
            self.seeds = self.seeds or SeedSummary()
            self.seeds.add(batch, self.checks)
        for i, check in enumerate(self.checks):
            self._judge(i, check, batch, good, row)

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """One verdict per check, in order."""
        return tuple(
            replace(self._verdicts[i], failed=self._failed[i], cases=self._judged[i])
            if i in self._verdicts
            else check.no_case_verdict()
            for i, check in enumerate(self.checks)
        )

    @property
    def shared(self) -> dict[str, bool]:
        """Whether all cases share the `kinetic` and the `static` friction force."""
        low_k, high_k, low_s, high_s = self.forces
        return {"kinetic": low_k >= high_k, "static": low_s >= high_s}

    def greatest(self, metric: str) -> float | None:
        """Return the greatest value of a metric; None if it is unknown in all cases."""
        ends = self.extremes.get(metric)
        return None if ends is None else ends[1].value

    def _count_lost(self, batch: Batch, row: RowAt) -> None:
        for code in np.unique(batch.status).tolist():
            if (status := STATUSES[code]) == OK:
                continue
            places = np.flatnonzero(batch.status == code)
            self.lost[status] = add_cases(
                self.lost.get(status), row(int(places[0])), len(places)
            )

    def _update_extremes(self, batch: Batch, good: NDArray[np.bool_], row: RowAt) -> None:
        """Update the extremes; only a new extreme is converted to a row."""
        names, columns = batch.names[len(FORCES) :], batch.numbers[len(FORCES) :]
        if not good.all():
            columns = np.where(good, columns, np.nan)
        lows = np.fmin.reduce(columns, axis=1).tolist()
        highs = np.fmax.reduce(columns, axis=1).tolist()
        for name, column, low, high in zip(names, columns, lows, highs, strict=True):
            if low != low:
                continue
            least, most = self.extremes.get(name, (None, None))
            if least is None or low < least.value:
                least = Extreme(low, row(int(np.argmax(column == low))))
            if most is None or high > most.value:
                most = Extreme(high, row(int(np.argmax(column == high))))
            self.extremes[name] = least, most

    def _update_limit(self, batch: Batch, row: RowAt) -> None:
        met = np.flatnonzero(np.nan_to_num(batch.metrics["violations"]) > 0)
        self.beyond += len(met)
        if len(met):
            beyond = np.nan_to_num(self._beyond_limits(batch)[met])
            if self.worst is None or beyond.max() > self._most_beyond:
                self._most_beyond = float(beyond.max())
                self.worst = row(int(met[np.argmax(beyond)]))
        if (limits := self.limits_of(batch.points)) is None:
            return
        share = np.maximum(*hourly_shares(batch.metrics, limits))
        share[met] = 0.0
        if number := int((share > 1.0).sum()):
            worst = float(share.max())
            before = self.too_short or Count(0, row(0))
            first = row(int(share.argmax())) if worst > self._shortest else before.first
            self.too_short = Count(before.cases + number, first)
            self._shortest = max(self._shortest, worst)

    def _beyond_limits(self, batch: Batch) -> NDArray[np.float64]:
        """Return how far the cases move beyond their stroke limits [m]."""
        limits = self.limits_of(batch.points) or StrokeLimits(0.0, 0.0)
        share = batch.metrics[STROKE_USED]
        return (share - 1.0) * nearest_limit(batch.metrics["stroke_suffices"], share, limits)[0]

    def _update_best(self, batch: Batch, row: RowAt) -> None:
        keeps = is_admissible(batch, self.checks)
        self.admissible += int(keeps.sum())
        for name in OBJECTIVES:
            values = np.where(keeps, batch.metrics[name], np.nan)
            least = float(np.fmin.reduce(values))
            if least == least and (name not in self.best or least < self.best[name].value):
                self.best[name] = Extreme(least, row(int(np.argmax(values == least))))

    def _judge(
        self, i: int, check: Check, batch: Batch, good: NDArray[np.bool_], row: RowAt
    ) -> None:
        applicable = check.applicable({**batch.points, STATUS: batch.status}, len(batch))
        # A case without metrics fails a check that applies to it.
        values = np.where(good, judged_column(check, batch), np.nan)
        self._judged[i] += int(applicable.sum())
        self._failed[i] += int((applicable & ~check.holds(values)).sum())
        worst = check.worst(applicable, values)
        if worst is not None:
            verdict = judge_row(check, row(worst))
            before = self._verdicts.get(i)
            if before is None or violation(verdict) > violation(before):
                self._verdicts[i] = verdict


def verdict_over_draws(verdict: Verdict, batches: Sequence[Batch]) -> Verdict:
    """Return the verdict of a sweep over the draws of a fit, which are like seeds.

    `batches` are its cases. Where these have no seeds, a quantile is that over the draws.
    """
    verdict, check = replace(verdict, of_draws=True), verdict.check
    if verdict.value is None or not check.is_quantile or any(batch.over for batch in batches):
        return verdict
    values = [
        judged_column(check, batch)[
            check.applicable({**batch.points, STATUS: batch.status}, len(batch))
        ]
        for batch in batches
    ]
    value = float(check.over_seeds(np.concatenate(values)))
    return replace(verdict, value=value, passed=bool(check.holds(value)), where=None)


STROKE_LIMIT = Check.parse("stroke_used < 1")
"""The stroke limit as a check, which every seed of a case must pass: it is met by a mass that
reaches it, as `violations` counts."""


def seeds_beyond(row: Row) -> int:
    """Return how many seeds of a case exceed the stroke limit."""
    values = row.over.values.get("violations", ()) if row.over else ()
    return sum(bool(count) for count in values)


def excess_of(batch: Batch, checks: Iterable[Check]) -> NDArray[np.float64]:
    """Return by how much each case exceeds the stroke limit, and then the limit of each check.

    The amounts, of shape (1 + checks, n), are relative to the limits, and above 0 exactly where
    the case fails these; that of the stroke is the largest of the seeds, those of checks are of
    the values that they judge. They are infinite if the case has no numbers or a value is
    unknown, and minus infinity for a limit that does not apply to the case.
    """
    used = batch.metrics[STROKE_USED].copy()
    largest = [batch.row(i).largest(STROKE_USED) for i in batch.over]
    used[[*batch.over]] = np.array(largest, dtype=float)  # None becomes NaN
    excess = [np.where(np.isnan(used), -np.inf, STROKE_LIMIT.relative_excess(used))]
    for check in checks:
        applies = check.applicable({**batch.points, STATUS: batch.status}, len(batch))
        amount = check.relative_excess(judged_column(check, batch))
        excess.append(np.where(applies, np.where(np.isnan(amount), np.inf, amount), -np.inf))
    return np.where(batch.status == STATUSES.index(OK), excess, np.inf)


def misses_of(batch: Batch, checks: Sequence[Check]) -> NDArray[np.float64]:
    """Return by how much each case fails the stroke limit, and then each check.

    The amounts are those of `excess_of`, but minus infinity for a limit that the case keeps.
    """
    excess = excess_of(batch, checks)
    return np.where(excess > 0.0, excess, -np.inf)


def is_admissible(batch: Batch, checks: Sequence[Check]) -> NDArray[np.bool_]:
    """Return which cases have numbers, stay within the stroke limit and keep all checks."""
    return np.asarray(misses_of(batch, checks).max(axis=0) == -np.inf)


class Count(NamedTuple):
    """Number of cases that have something in common, and the first of them."""

    cases: int
    first: Row


def add_cases(before: Count | None, row: Row, cases: int = 1) -> Count:
    """Return the count with more cases, of which `row` is the first."""
    return Count(before.cases + cases, before.first) if before else Count(cases, row)


@dataclass
class SeedSummary:
    """Statistics of the cases of one approach that are means over several seeds."""

    cases: int = 0
    """Number of those that have numbers."""
    least: int = 0
    most: int = 0
    """Smallest and largest number of seeds of a case."""
    widest: dict[str, Row] = field(default_factory=dict)
    """Row with the widest interval, by metric."""
    too_wide: Count | None = None
    """Cases whose interval is wider than the stopping rule demands."""
    undecided: dict[Check, Count] = field(default_factory=dict)
    """Cases in which the limit lies within the interval, by check."""

    def add(self, batch: Batch, checks: Sequence[Check]) -> None:
        """Add a batch; batches come in order."""
        for row in map(batch.row, batch.over):
            self.least = min(self.least or row.seeds, row.seeds)
            self.most = max(self.most, row.seeds)
            if row.status == OK:
                self._add(row, checks)

    def _add(self, row: Row, checks: Sequence[Check]) -> None:
        self.cases += 1
        for name, width in row.half_widths.items():
            before = self.widest.get(name)
            if width is not None and (
                before is None or width > (before.half_widths[name] or 0)
            ):
                self.widest[name] = row
        if row.over and not row.over.narrow:
            self.too_wide = add_cases(self.too_wide, row)
        for check in checks:
            if check.applies(row.point) and judge_row(check, row).undecided:
                self.undecided[check] = add_cases(self.undecided.get(check), row)


BINS_PER_E_FOLD = 256
"""Bins per factor e: the error of a quantile is at most 0.2 % of its value."""


def log_bins(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the bin of each positive value, of which each is wider by a constant factor."""
    bins: NDArray[np.int64] = np.floor(np.log(values) * BINS_PER_E_FOLD).astype(np.int64)
    return bins


def bin_values(bins: Any) -> Any:
    """Return the value at the centre of bins of `log_bins`."""
    return np.exp((bins + 0.5) / BINS_PER_E_FOLD)


QUANTILE_LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Levels of the quantiles over cases [-]."""


class Quantiles:
    """Histogram with bins of constant ratio; values at or below zero share one bin."""

    def __init__(self) -> None:
        self._counts: Counter[int] = Counter()
        self._not_positive = 0
        self._low, self._high = np.inf, -np.inf

    def add(self, values: NDArray[np.float64]) -> None:
        """Count values; NaN is ignored."""
        values = values[values == values]
        if not len(values):
            return
        self._low = min(self._low, float(values.min()))
        self._high = max(self._high, float(values.max()))
        above = values[values > 0.0]
        self._not_positive += len(values) - len(above)
        if len(above):
            bins = log_bins(above)
            counts = np.bincount(bins - (first := int(bins.min())))
            held = np.flatnonzero(counts)
            held_counts = zip((held + first).tolist(), counts[held].tolist(), strict=True)
            self._counts.update(dict(held_counts))

    def at(self, level: float) -> float | None:
        """Return the quantile at a level; None without values."""
        total = self._not_positive + self._counts.total()
        if not total:
            return None
        for value, below in self._steps():
            if below >= level * total:
                return float(min(max(value, self._low), self._high))
        return self._high

    def summary(self) -> dict[str, float]:
        """Return the quantiles by level, with keys such as `0.5`; empty without values."""
        values = ((f"{level:g}", self.at(level)) for level in QUANTILE_LEVELS)
        return {name: value for name, value in values if value is not None}

    def _steps(self) -> Iterator[tuple[float, int]]:
        """Yield the centre of each bin, and the number of values up to its end."""
        below = self._not_positive
        yield min(self._low, 0.0), below
        for number in sorted(self._counts):
            below += self._counts[number]
            yield float(bin_values(number)), below
