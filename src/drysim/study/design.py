"""Design: the values of some keys that minimise one or two metrics within limits.

Every design is a case of a sweep, solved under the same base motion (the same seeds), so that
differences between designs are not differences between noises. `search` chooses the designs;
the cases of each of its rounds are solved, stored and resumed like those of a sweep.

With several seeds the optimum is uncertain, because means over seeds are: of the objective, and
of metrics with limits. Resampled seeds have other optima (bootstrap), which are found with the
same surrogate model as in the search, one interpolant per seed. The designs among them cannot
be told apart from the best one with these seeds.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import floor, inf, isfinite, isnan, log, log10, nan
from statistics import fmean
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from drysim.core.model import Floats, Input, Samples, Sines
from drysim.errors import ScenarioError, SolverError, WarningMessage
from drysim.metrics.checks import EVERY_SEED, Check, Verdict, violation
from drysim.metrics.checks import MEAN as SEED_MEAN
from drysim.metrics.table import FIT_NAMES, METRICS_BY_NAME, SIGNED, STROKE_USED, Values
from drysim.metrics.text import format_metric
from drysim.scenario.axes import Axis, KeyRange, iter_points
from drysim.scenario.design import DESIGN_KEY, MEAN, Design
from drysim.scenario.examples import design_example
from drysim.scenario.keys import numeric_keys
from drysim.scenario.laws import LAWS
from drysim.scenario.model import Scenario, provides
from drysim.scenario.text import describe_point
from drysim.scenario.validation import spoken_name
from drysim.study.case import Case
from drysim.study.outcome import Result, format_repr
from drysim.study.plan import CaseRanges, Plan
from drysim.study.preparation import prepare, require_scenario
from drysim.study.run import MotionCache, unused_spectra_warnings
from drysim.study.search import (
    GAP_SHARES,
    ROUNDS,
    SEED,
    Evaluations,
    Surrogate,
    candidates,
    interpolate,
    pareto,
    search,
)
from drysim.study.statistics import (
    FAILED,
    NORMAL_95,
    OK,
    Batch,
    Row,
    interval,
    judge_row,
    judged_value,
    max_seeds,
    stopping_rule,
    student_t,
)
from drysim.study.sweep import Execute, choose_engine, describe_numerics, on_workers
from drysim.study.table import STROKE_LIMIT, hourly_stroke_used
from drysim.study.warnings import hourly_stroke_warnings
from drysim.wording import Point, format_deviation, join_words

if TYPE_CHECKING:
    from drysim.study.store import Store

DIGITS = 4
"""Decimal digits of chosen values: of the value on a log scale, else of the range."""

CHANGE = 0.1
"""Relative change of friction and stiffness in the sensitivity of the best design."""

SAME = 0.01
"""Relative difference up to which designs count as equally good."""

MIN_RELAXATION = 1e-3
"""Relative gain without a limit from which the limit binds."""

STROKE_WITH_EVERY_SEED = Check.parse(f"{STROKE_LIMIT} with {EVERY_SEED}")
"""The stroke limit of a file with several seeds: a limit in `within` applies to their mean."""

MAX_CORNERS = 256
"""Largest number of corners of the ranges that are checked before a study."""

AT_BOUND = 1e-3
"""Distance from a bound, as a share of the range, up to which a key is at its bound."""

MIN_SEEDS, RESAMPLES, POINTS_AT_ONCE = 5, 400, 100
"""Seeds from which they are resampled, number of resamples, and points that are resampled
together."""

NEAR_WIDTHS = (0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
NEAR_COUNT = 1000
"""Points around the best design that are compared with it: their spread as shares of the box,
and their number."""

FILE_WARNINGS = ("will-not-move", "sweep-changes-nothing")
"""Warnings about a single case, or about the axes of a sweep."""

FRICTION, STIFFNESS = "friction", "stiffness"
"""Names of the groups of keys that are changed together."""

STIFFNESS_KEYS = ("oscillator.stiffness", "oscillator.natural_frequency")
DAMPING_RATIO_KEY = "oscillator.damping_ratio"
POWERS = {"oscillator.natural_frequency": 0.5, DAMPING_RATIO_KEY: -0.5}
"""Keys that state the stiffness, and the power of it that they are proportional to; the damping
ratio of a damper that stays the same, too."""


class Candidate(NamedTuple):
    """An evaluated design."""

    number: int
    """From 1, in the order of the evaluations."""
    values: Mapping[str, float]
    """Varied keys in SI."""
    rows: tuple[Row, ...]
    """One per condition; means over the seeds if there are several."""
    objectives: tuple[float, ...]
    """Of the worst condition, or the mean over the conditions; NaN where not known."""
    excess: tuple[float, ...]
    """By how much each limit is exceeded under its worst condition, relative to the limit."""

    @property
    def is_known(self) -> bool:
        """Whether all objectives and limits have numbers."""
        return all(map(isfinite, (*self.objectives, *self.excess)))

    @property
    def is_admissible(self) -> bool:
        """Whether the design keeps all limits."""
        return self.is_known and all(excess <= 0.0 for excess in self.excess)

    @property
    def status(self) -> str:
        """Status of the first case without numbers, or `ok`."""
        return next((row.status for row in self.rows if row.status != OK), OK)


class Region(NamedTuple):
    """Designs as good as the best one."""

    ends: Mapping[str, tuple[float | None, float | None]]
    """Least and greatest value of each varied key; None for an end that is not known."""
    points: Floats
    """Points of the region in the unit cube, for pictures, shape (n, keys)."""


class Binding(NamedTuple):
    """A limit that keeps the best design from being better."""

    limit: Check
    objective: float
    """Objective of a design that exceeds only this limit and those beside it."""
    beside: tuple[Check, ...] = ()
    """Further limits that keep it from that as well, such as the stroke limit beside a check
    that repeats it: without only some of them nothing is gained."""

    @property
    def text(self) -> str:
        """All these limits, joined by `and`."""
        return join_words([str(limit) for limit in (self.limit, *self.beside)])


class Variant(NamedTuple):
    """The best design with something changed: its objectives."""

    name: str
    """Such as `friction +10 %`."""
    candidate: Candidate


@dataclass(frozen=True, eq=False)
class DesignResult(Result):
    """The best design, how well it is known, and all designs that were evaluated.

    Attributes
    ----------
    source : Scenario
        The scenario with its design block.
    case : Case
        The prepared case.
    candidates : tuple of Candidate
        In the order of their evaluation.
    converged : bool
        Whether the search ended because nothing can be gained, not at `evaluations`.
    optimum : Region or None
        Where the optimum may be, at 95 %, with several seeds.
    flat : Region or None
        Designs within 1 % of the best.
    binding : tuple of Binding
    variants : tuple of Variant
        The design as in the file, and the shown one with friction and stiffness changed.
    warnings : tuple of WarningMessage
    complete : bool
        Whether the search came to its end.
    """

    kind: ClassVar[str] = "design"

    source: Scenario
    case: Case = field(compare=False)
    candidates: tuple[Candidate, ...]
    converged: bool = False
    optimum: Region | None = None
    flat: Region | None = None
    binding: tuple[Binding, ...] = ()
    variants: tuple[Variant, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    complete: bool = True

    @property
    def design(self) -> Design:
        """The design block."""
        return design_of(self.source)

    @property
    def limits(self) -> tuple[Check, ...]:
        """The limits that every design must keep."""
        return limits_of(self.source)

    @cached_property
    def front(self) -> tuple[Candidate, ...]:
        """Admissible designs that no other dominates; of one objective the best."""
        admissible = [candidate for candidate in self.candidates if candidate.is_admissible]
        if not admissible:
            return ()
        if len(self.design.minimise) == 1:
            return (min(admissible, key=lambda candidate: candidate.objectives[0]),)
        order = pareto(np.array([candidate.objectives for candidate in admissible]))
        return tuple(admissible[i] for i in order.tolist())

    @cached_property
    def best(self) -> Candidate | None:
        """The best admissible design; of a front its knee. None if none is admissible.

        The knee is the point that is farthest below the line between the ends of the front; a
        front without such a point has its end instead.
        """
        if len(self.front) < 3:
            return self.front[0] if self.front else None
        values = np.array([candidate.objectives for candidate in self.front])
        low, high = values.min(axis=0), values.max(axis=0)
        return self.front[int(np.argmin(((values - low) / (high - low)).sum(axis=1)))]

    @cached_property
    def closest(self) -> Candidate | None:
        """The design with the least excess over the limits; None if no design has numbers."""
        candidates = [candidate for candidate in self.candidates if candidate.is_known]
        return min(
            candidates, key=lambda candidate: max(candidate.excess, default=0.0), default=None
        )

    @property
    def shown(self) -> Candidate | None:
        """The best design or, if none is admissible, the closest one."""
        return self.best or self.closest

    @property
    def shown_name(self) -> str:
        """What the shown design is: `best`, `knee`, `end of the front` or `closest`."""
        if self.best is None:
            return "closest"
        if len(self.front) < 2:
            return "best"
        return "end of the front" if self.best in (self.front[0], self.front[-1]) else "knee"

    @cached_property
    def checks(self) -> tuple[Verdict, ...]:
        """The limits, judged on the shown design under its worst condition."""
        if self.shown is None:
            return tuple(limit.no_case_verdict() for limit in self.limits)
        return self.judge(self.shown.rows)

    def judge(self, rows: Sequence[Row]) -> tuple[Verdict, ...]:
        """Return the limits, judged on the worst of some rows of a design."""
        return tuple(
            max((judge_row(limit, row, self.place_of(row)) for row in rows), key=violation)
            for limit in self.limits
        )

    @property
    def several_rows(self) -> tuple[Row, ...]:
        """The rows of the shown design under several conditions; empty for a single one."""
        return self.shown.rows if self.shown and len(self.shown.rows) > 1 else ()

    def place_of(self, row: Row) -> dict[str, object]:
        """Return the condition of a row."""
        return {axis.key: row.point[axis.key] for axis in self.design.conditions.axes}

    @property
    def scenario(self) -> Scenario:
        """The scenario with the shown design, its limits as checks; it runs."""
        values = self.shown.values if self.shown else {}
        kept: dict[str, object] = {DESIGN_KEY: None, "checks": self.limits}
        return (
            self.source.copy_with({"sweep": (), "reference": None}).at(values).copy_with(kept)
        )

    @property
    def metrics(self) -> Values:
        """Metrics of the shown design under its worst condition; empty if there is none."""
        return dict(self.shown_row.metrics) if self.shown_row else {}

    @property
    def shown_row(self) -> Row | None:
        """The row of the shown design under the condition with the worst first objective."""
        if self.shown is None:
            return None
        name = self.design.minimise[0]
        return max(self.shown.rows, key=lambda row: number_of(row.metrics.get(name)))

    @property
    def half_widths(self) -> tuple[float | None, ...]:
        """Half-width of the 95 % interval of each objective of the shown design over seeds."""
        if self.shown is None:
            return (None,) * len(self.design.minimise)
        widths = []
        for name in self.design.minimise:
            values = seed_values(self.shown, name)
            several = values[int(np.argmax(values.mean(axis=1)))]
            if self.design.conditions.take == MEAN:
                several = values.mean(axis=0)
            widths.append(interval(several.tolist())[1] if len(several) > 1 else None)
        return tuple(widths)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Records of the base motion."""
        return self.case.inputs

    @property
    def numerics(self) -> dict[str, object]:
        """Core, reason, engine and step of the solutions."""
        return describe_numerics(self.case)

    @property
    def motion(self) -> Sines | Samples | None:
        """Base motion of the first seed, or of the first record."""
        return self.case.motion

    def place(self, candidate: Candidate) -> str:
        """Return the values of a design as text."""
        return describe_point(
            candidate.values, {axis.key: axis.unit for axis in self.design.vary}
        )

    def result(self, candidate: Candidate) -> str:
        """Return the objectives of a design as text."""
        names = zip(self.design.minimise, candidate.objectives, strict=True)
        return ", ".join(f"{name} {format_metric(name, x)}" for name, x in names)

    def __repr__(self) -> str:
        """Return the best design in one line."""
        many, name = f"{len(self.candidates)} designs", self.source.name
        if self.best is None:
            return format_repr("DesignResult", name, many, "none is admissible")
        return format_repr(
            "DesignResult", name, many, self.place(self.best), self.result(self.best)
        )


def design(scenario: Scenario, *, workers: int | None = None) -> DesignResult:
    """Find the design that minimises the objective of a scenario's design block.

    Parameters
    ----------
    scenario : Scenario
        With a design block.
    workers : int, optional
        Number of workers; default: one per processor. The result does not depend on it.

    Returns
    -------
    DesignResult

    Raises
    ------
    ScenarioError
        When the scenario has no design block, or a design is invalid.
    RecordError
        When the record of the excitation is invalid.
    UsageError
        When `scenario` is not a Scenario, or `workers` not a number of workers.
    """
    case = prepare_design(scenario)
    with on_workers(workers) as execute:
        return Study(case, execute).solve()


def prepare_design(scenario: Scenario) -> Case:
    """Return the case of a design study, with its conditions as sweep; errors as `design`."""
    require_scenario(scenario)
    block = scenario.design
    if block is None:
        sentence = "design is required: the keys to vary, and the metric to minimise"
        raise scenario.error(sentence, DESIGN_KEY, design_example(scenario))
    if until := stopping_rule(scenario):
        sentence = (
            "excitation.until is not supported by design, which takes the same seeds for every "
            f"design; remove it and set excitation.seeds, not {until.metric}"
        )
        raise scenario.error(sentence, ("excitation", "until"))
    for i, name in enumerate(block.minimise):
        place = ("minimise",) if len(block.minimise) == 1 else ("minimise", i)
        check_metric(scenario, name, (DESIGN_KEY, *place))
    check_limits(scenario)
    case = prepare(
        scenario.copy_with({"sweep": block.conditions.axes, "reference": None}),
        swept=bool(block.conditions.axes),
    )
    # Warnings about the values of the file do not apply to the designs.
    others = [warning for warning in case.warnings if warning.slug not in FILE_WARNINGS]
    return replace(case, warnings=(*others, *contradiction_warnings(scenario)))


def contradiction_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn if values within the ranges of a design block contradict those of the file."""
    vary = design_of(scenario).vary
    conditions = list(iter_points(design_of(scenario).conditions.axes))
    corners = itertools.product(*([axis.low, axis.high] for axis in vary))
    for corner in itertools.islice(corners, MAX_CORNERS):
        point = dict(zip((axis.key for axis in vary), corner, strict=True))
        if note := invalid_note(scenario, conditions, point):
            where = describe_point(point, {axis.key: axis.unit for axis in vary})
            sentence = (
                f"design.vary: at {where} {note}; such designs have no numbers and are passed "
                "over: narrow the range, or state the other value relative to it"
            )
            yield WarningMessage("contradicting-range", sentence, point)
            return


def check_limits(scenario: Scenario) -> None:
    """Raise a ScenarioError for a limit that no design can keep, alone or with another one."""
    within = design_of(scenario).within
    head = ("checks",) if within is None else (DESIGN_KEY, "within")
    limits = [STROKE_LIMIT] * (within is None and scenario.stroke is not None)
    for i, limit in enumerate(scenario.checks if within is None else within):
        keys = (*head, i)
        where = spoken_name(keys)
        if limit.conditions:
            sentence = f"{where} has a condition, but limits hold for every design"
            raise scenario.error(f"{sentence}; give design.within", keys)
        check_metric(scenario, limit.metric, keys)
        if limit.constant_result is False:
            sentence = f"{where}: no design can keep `{limit}`; change or remove it"
            raise scenario.error(sentence, keys)
        for other in limits:
            if other.metric == limit.metric and other.contradicts(limit):
                sentence = f"{where}: no design can keep both `{other}` and `{limit}`"
                raise scenario.error(f"{sentence}; change or remove one of them", keys)
        limits.append(limit)


def check_metric(scenario: Scenario, name: str, keys: tuple[str | int, ...]) -> None:
    """Raise a ScenarioError for a metric that the scenario does not have."""
    where = spoken_name(keys)
    if name in FIT_NAMES:
        raise scenario.error(f"{where}: {name} is known to `drysim fit` only", keys)
    for need in METRICS_BY_NAME[name].needs:
        if not provides(scenario, need):
            sentence = f"{where}: {name} is not available without {need.name}"
            raise scenario.error(f"{sentence}; give {' or '.join(need.keys)}", keys)


def design_of(scenario: Scenario) -> Design:
    """Return the design block of a scenario that has one."""
    assert scenario.design is not None, "a design study has a design block"
    return scenario.design


def stroke_limit_of(scenario: Scenario) -> Check:
    """Return the stroke limit as designs keep it: with every seed."""
    return STROKE_WITH_EVERY_SEED if max_seeds(scenario) > 1 else STROKE_LIMIT


def limits_of(scenario: Scenario) -> tuple[Check, ...]:
    """Return the limits that every design of a scenario must keep."""
    stroke = None if scenario.stroke is None else stroke_limit_of(scenario)
    return design_of(scenario).limits(scenario.checks, stroke)


@dataclass
class Study:
    """Evaluation of designs, round by round."""

    case: Case
    execute: Execute
    """Solves the cases of designs."""
    store: Store | None = None
    """Cases that it holds are not computed again, all others are written to it."""
    advance: Callable[[int], None] = lambda count: None
    """Called with the number of new designs."""
    candidates: list[Candidate] = field(default_factory=list)
    """All designs so far."""
    first: int = 0
    """Number of the next case."""

    @cached_property
    def motions(self) -> MotionCache:
        """Base motions, which all designs share."""
        return MotionCache.starting_with(self.case)

    @property
    def design(self) -> Design:
        """The design block."""
        return design_of(self.case.scenario)

    def solve(self) -> DesignResult:
        """Return the result of the study.

        Raises
        ------
        SolverError
            When no design has numbers.
        """
        block = self.design
        least = [
            -inf if METRICS_BY_NAME[name].kind == SIGNED else 0.0 for name in block.minimise
        ]
        evaluated, converged = search(self.evaluate, len(block.vary), least, block.evaluations)
        result = replace(self.partial(), converged=converged, complete=True)
        if result.shown is None:
            first = self.candidates[0]
            note = next(row.note or row.status for row in first.rows if row.status != OK)
            raise SolverError(f"no design has numbers; the first: {note}")
        result = replace(result, variants=tuple(self.variants(result.shown)))
        if result.best is not None and len(block.minimise) == 1:
            result = replace(
                result,
                optimum=optimum_region(result, evaluated),
                flat=flat_region(result, evaluated),
                binding=tuple(self.binding_limits(result, evaluated)),
            )
        return replace(result, warnings=tuple(design_warnings(result)))

    def partial(self) -> DesignResult:
        """Return the designs that an interrupted study has evaluated."""
        source = self.case.scenario.copy_with({"sweep": ()})  # which has the conditions
        return DesignResult(source, self.case, tuple(self.candidates), complete=False)

    def evaluate(self, points: Floats) -> Evaluations:
        """Evaluate designs at points of the unit cube; their values are rounded.

        Raises
        ------
        SolverError
            When a metric is not known for the motion of any design.
        """
        values = [round_values(self.design.vary, point) for point in points]
        keys = {axis.key: axis.unit for axis in self.design.vary}
        rows = self.rows(self.case.scenario, keys, values)
        for point, several in zip(values, rows, strict=True):
            number = len(self.candidates) + 1
            self.candidates.append(make_candidate(self.case.scenario, number, point, several))
        wanted = (
            *self.design.minimise,
            *(limit.metric for limit in limits_of(self.case.scenario)),
        )
        solved = [row for several in rows for row in several if row.status == OK]
        for name in dict.fromkeys(wanted):
            if solved and all(row.metrics.get(name) is None for row in solved):
                sentence = f"{name} is not known for the motion of any of the first designs"
                raise SolverError(f"{sentence}; minimise or limit another metric")
        return evaluations_of(self.case.scenario, self.candidates[-len(values) :])

    def rows(
        self, scenario: Scenario, keys: Mapping[str, str], points: Sequence[Mapping[str, float]]
    ) -> list[tuple[Row, ...]]:
        """Solve designs under all conditions, and return the rows of each.

        Parameters
        ----------
        scenario : Scenario
            With the conditions as its sweep.
        keys : mapping
            Units of the keys that vary, by key.
        points : sequence of mapping
            Values of these keys for each design.
        """
        conditions = scenario.sweep
        under = list(iter_points(conditions))
        faults = [invalid_note(scenario, under, point) for point in points]
        sound = [point for point, fault in zip(points, faults, strict=True) if not fault]
        zipped = tuple(
            Axis(key, unit, values, list(values), "zip", location=(DESIGN_KEY, "vary", key))
            for key, unit in keys.items()
            for values in [tuple(point[key] for point in sound)]
        )
        swept = scenario.copy_with({"sweep": (*conditions, *zipped)})
        case = replace(self.case, scenario=swept)
        each, begun = len(under), self.first
        choose_engine(case, [swept], count=each * self.design.evaluations)
        done = 0

        def count(batch: Batch) -> None:
            nonlocal done
            before, done = done // each, done + len(batch)
            self.advance(done // each - before)

        rows: list[Row] = []
        if sound:
            plan = Plan(CaseRanges([swept], begun), self.motions)
            batches = self.execute(plan, case, self.store, count)
            rows = [row for _, batch in batches for row in batch]
        self.first = begun + len(rows)
        solved = iter([tuple(rows[i : i + each]) for i in range(0, len(rows), each)])
        return [
            tuple(
                Row({**condition, **point}, scenario.label, nan, nan, {}, FAILED, fault)
                for condition in under
            )
            if fault
            else next(solved)
            for point, fault in zip(points, faults, strict=True)
        ]

    def variants(self, shown: Candidate) -> Iterator[Variant]:
        """Yield the design of the file, if it has all values, and variants of the shown one."""
        scenario = self.case.scenario
        file_values, conditions = known_values(scenario), {axis.key for axis in scenario.sweep}
        given = {
            key: entry.value for key, entry in file_values.items() if key not in conditions
        }
        best = {**given, **shown.values}
        forces = [
            key
            for key, entry in file_values.items()
            if entry.is_friction and best.get(key, 1.0)
        ]
        groups = {
            FRICTION: [] if conditions & {*forces} else forces,
            STIFFNESS: [key for key in STIFFNESS_KEYS if best.get(key)],
        }
        if groups[STIFFNESS] and best.get(DAMPING_RATIO_KEY):
            groups[STIFFNESS].append(DAMPING_RATIO_KEY)
        points = {"as given": given} if shown.values.keys() <= given.keys() else {}
        for name, keys in groups.items():
            for change in (CHANGE, -CHANGE) if keys else ():
                factors = {key: (1.0 + change) ** POWERS.get(key, 1.0) for key in keys}
                scaled = {key: value * factors.get(key, 1.0) for key, value in best.items()}
                points[f"{name} {format_deviation(change)}"] = scaled
        units = {key: entry.unit for key, entry in file_values.items() if key in best}
        units |= {axis.key: axis.unit for axis in self.design.vary}
        for (name, point), rows in zip(
            points.items(), self.rows(scenario, units, [*points.values()]), strict=True
        ):
            values = {key: point[key] for key in shown.values}
            yield Variant(name, make_candidate(scenario, 0, values, rows))
        if forces and scenario.stops is None:
            used = {k: unit for k, unit in units.items() if not k.startswith("friction.")}
            viscous = scenario.with_approach("viscous")
            (rows,) = self.rows(viscous, used, [{key: best[key] for key in used}])
            yield Variant("no dry friction", make_candidate(scenario, 0, shown.values, rows))

    def binding_limits(self, result: DesignResult, evaluated: Evaluations) -> Iterator[Binding]:
        """Yield the limits without which a design is better, as a solved design shows.

        Limits of which none binds alone may bind together, as where a check repeats the stroke
        limit.
        """
        surrogate, best = Surrogate.of(evaluated), result.best
        if surrogate is None or best is None:
            return
        predicted = surrogate.at(candidates(np.random.default_rng(SEED), evaluated, 1))
        least = best.objectives[0]
        better = least - MIN_RELAXATION * abs(least)

        def without(places: Sequence[int]) -> Candidate | None:
            """Return a design that is better without the limits at some places."""
            holds = np.delete(predicted.constraints <= 0.0, places, axis=1).all(axis=1)
            values = np.where(holds, predicted.objectives[:, 0], inf)
            lowest = int(np.argmin(values))
            if not values[lowest] < better:
                return None
            point = round_values(self.design.vary, predicted.points[lowest])
            keys = {axis.key: axis.unit for axis in self.design.vary}
            (rows,) = self.rows(self.case.scenario, keys, [point])
            relaxed = make_candidate(self.case.scenario, 0, point, rows)
            return relaxed if relaxed.objectives[0] < better else None

        others = []
        for place, limit in enumerate(result.limits):
            if relaxed := without([place]):
                yield Binding(limit, relaxed.objectives[0])
            else:
                others.append(place)
        if len(others) > 1 and (relaxed := without(others)):
            exceeded = [result.limits[i] for i in others if relaxed.excess[i] > 0.0]
            if exceeded:
                yield Binding(exceeded[0], relaxed.objectives[0], tuple(exceeded[1:]))


def invalid_note(
    scenario: Scenario, conditions: Sequence[Point], point: Mapping[str, float]
) -> str:
    """Return why the values of a design contradict each other; empty if they do not."""
    try:
        for condition in conditions:
            scenario.at({**condition, **point})
    except ScenarioError as fault:
        return fault.problems[0].sentence
    return ""


class KnownValue(NamedTuple):
    """A value in the file, its unit, and whether it is a friction force or coefficient."""

    value: float
    unit: str
    is_friction: bool


def known_values(scenario: Scenario) -> dict[str, KnownValue]:
    """Return the values in the file of what a study varies by itself, by key.

    These are the keys of the design block, the friction forces, the stiffness and the damping
    ratio.
    """
    numeric = numeric_keys(type(scenario), scenario.resolved())
    varied = {axis.key for axis in design_of(scenario).vary}
    values = {}
    for key, entry in numeric.items():
        if entry is None or not entry.present or (value := entry.here(key)) is None:
            continue
        block, option, *_ = f"{key}.".split(".")
        force = entry.unit == "N" or option in ("mu_kinetic", "mu_static")
        is_friction = block == "friction" and option not in ("normal", *LAWS) and force
        if key in varied or key in (*STIFFNESS_KEYS, DAMPING_RATIO_KEY) or is_friction:
            values[key] = KnownValue(value, entry.header, is_friction)
    return values


def round_values(vary: Sequence[KeyRange], point: Floats) -> dict[str, float]:
    """Return the values of a design at a point of the unit cube, as short decimals."""
    values = {}
    for axis, share in zip(vary, point.tolist(), strict=True):
        exact = float(axis.value(share))
        if axis.is_log:
            digits = DIGITS - min(0, floor(log10(log(axis.high / axis.low))))
            value = float(f"{exact:.{digits}g}")
        else:
            value = round(exact, DIGITS - 1 - floor(log10(axis.high - axis.low)))
        values[axis.key] = min(max(value, axis.low), axis.high)
    return values


def shares_of(vary: Sequence[KeyRange], values: Mapping[str, float]) -> list[float]:
    """Return the point of the unit cube at which a design lies."""
    return [axis.share(values[axis.key]) for axis in vary]


def number_of(value: float | None) -> float:
    """Return a metric as a float, NaN where it is not known."""
    return nan if value is None else float(value)


def make_candidate(
    scenario: Scenario, number: int, values: Mapping[str, float], rows: tuple[Row, ...]
) -> Candidate:
    """Return a design with its objectives and the excess over its limits."""
    block = design_of(scenario)
    take = fmean if block.conditions.take == MEAN else max
    objectives = []
    for name in block.minimise:
        several = [number_of(row.metrics.get(name)) for row in rows]
        objectives.append(nan if any(map(isnan, several)) else float(take(several)))
    excess = (max_excess(limit, rows) for limit in limits_of(scenario))
    return Candidate(number, values, rows, tuple(objectives), tuple(excess))


def max_excess(limit: Check, rows: Sequence[Row]) -> float:
    """Return the largest excess over a limit, relative to it; NaN where it is not known.

    It is above 0 exactly where the limit does not hold, also at the limit itself.
    """
    values = np.array([number_of(judged_value(limit, row)) for row in rows])
    return float(limit.relative_excess(values).max())


def evaluations_of(scenario: Scenario, candidates: Sequence[Candidate]) -> Evaluations:
    """Return designs as evaluations of the search."""
    vary = design_of(scenario).vary
    return Evaluations(
        np.array([shares_of(vary, candidate.values) for candidate in candidates]),
        np.array([candidate.objectives for candidate in candidates]),
        np.array([candidate.excess for candidate in candidates]).reshape(len(candidates), -1),
    )


# What the evaluated designs tell about the best one


def seed_values(candidate: Candidate, name: str) -> Floats:
    """Return a metric of a design for each seed, shape (conditions, seeds)."""
    several = [
        row.over.values[name] if row.over else [row.metrics.get(name)] for row in candidate.rows
    ]
    return np.array(several, dtype=float)


def points_near(point: Floats) -> Floats:
    """Return a point of the unit cube and points around it at all distances."""
    random = np.random.default_rng(SEED)
    spread = [
        np.clip(point + width * random.normal(size=(NEAR_COUNT, len(point))), 0.0, 1.0)
        for width in NEAR_WIDTHS
    ]
    return np.concatenate([point[None], *spread, random.random((NEAR_COUNT, len(point)))])


def make_region(vary: Sequence[KeyRange], low: Floats, high: Floats, points: Floats) -> Region:
    """Return a region by its ends in the unit cube."""
    ends = zip(round_values(vary, low).items(), round_values(vary, high).values(), strict=True)
    return Region({key: (a, b) for (key, a), b in ends}, points)


def flat_region(result: DesignResult, evaluated: Evaluations) -> Region | None:
    """Return the admissible designs within 1 % of the best, by the surrogate model.

    None if there are too few designs for the model.
    """
    vary, best = result.design.vary, result.best
    assert best is not None, "only an admissible design has a region"
    if (surrogate := Surrogate.of(evaluated)) is None:
        return None
    points = points_near(np.array(shares_of(vary, best.values)))
    predicted, least = surrogate.at(points), best.objectives[0]
    same = predicted.objectives[:, 0] <= least + SAME * abs(least)
    same &= (predicted.constraints <= 0.0).all(axis=1)
    points = points[same | (np.arange(len(points)) == 0)]
    return make_region(vary, points.min(axis=0), points.max(axis=0), points)


def optimum_region(result: DesignResult, evaluated: Evaluations) -> Region | None:
    """Return where the optimum may be, at 95 %, from several seeds.

    None if there are too few seeds or designs, or if a metric is unknown for some seed.

    Notes
    -----
    Bootstrap: the optima of resampled seeds, by interpolants of objective and limits for each
    seed. Their 95 % percentiles are widened by Student's t. Points count as optimal within the
    error of the interpolant, which is estimated by leaving the last rounds out.

    A limit with every seed is one of the largest value, which no resampling exceeds but more
    seeds would; a quantile of few seeds is little else. Where such a limit binds, the end
    towards which a stricter limit moves the optimum is not known.
    """
    design, limits, best = result.design, result.limits, result.best
    assert best is not None, "only an admissible design has a region"
    seeds, vary = best.rows[0].seeds, design.vary
    if seeds < MIN_SEEDS:
        return None
    names = (design.minimise[0], *(limit.metric for limit in limits))
    series = np.array(
        [
            [seed_values(candidate, name) for name in names]
            for candidate in result.candidates
            if candidate.is_known
        ]
    )  # shape (designs, metrics, conditions, seeds)
    if not np.isfinite(series).all():
        return None
    centre = np.array(shares_of(vary, best.values))
    points = points_near(centre)
    tried, last = evaluated.points[evaluated.has_numbers], ROUNDS * len(GAP_SHARES)
    means = series.mean(axis=-1)
    at_points = interpolate(tried, means, points)
    earlier = interpolate(tried[:-last], means[:-last, 0], points)
    matrix = interpolate(tried, np.eye(len(tried)), points)
    if at_points is None or earlier is None or matrix is None:
        return None
    take = np.mean if design.conditions.take == MEAN else np.max
    error = abs(take(earlier, axis=-1) - take(at_points[:, 0], axis=-1))
    # Interpolants are linear in the values, so that a matrix interpolates any of them. Rounding
    # in it grows with the closeness of the points: it takes small values only.
    deviations = series - means[..., None]
    # Points come last from here on: maxima over the few conditions are then fast.
    at_points, matrix = np.moveaxis(at_points, 0, -1), matrix.T
    drawn = np.random.default_rng(SEED).integers(seeds, size=(RESAMPLES, seeds))
    weights = np.array([np.bincount(each, minlength=seeds) / seeds for each in drawn])
    resampled, used = np.empty((RESAMPLES, len(points))), np.zeros(len(points))
    for begin in range(0, len(points), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        # Shapes (metrics, conditions, 1 or seeds, points).
        centres = at_points[..., None, part]
        changes = np.tensordot(deviations, matrix[:, part], (0, 0))
        holds = np.ones((RESAMPLES, centres.shape[-1]), dtype=bool)
        for i, limit in enumerate(limits, 1):
            values = centres[i] + changes[i]
            if limit.judges == SEED_MEAN:
                holds &= limit.holds(centres[i] + weights @ changes[i]).all(axis=0)
                continue
            judged = limit.over_seeds(np.moveaxis(values, 1, 0))
            excess = limit.excess(judged).max(axis=0) / (abs(limit.limit) or 1.0)
            used[part] = np.maximum(used[part], 1.0 + excess)
            if limit.judges == EVERY_SEED:  # judged with each seed, so before resampling
                beyond = ~limit.holds(values).all(axis=0)
                holds &= weights @ beyond == 0.0
            else:
                several = np.moveaxis(values[:, drawn], 2, 0)
                holds &= limit.holds(limit.over_seeds(several)).all(axis=0)
        objectives = take(centres[0] + weights @ changes[0], axis=0)
        resampled[:, part] = np.where(holds, objectives, np.inf)
    lows, highs, optimal = [], [], np.zeros(len(points), dtype=bool)
    for reached in resampled:
        least = int(np.argmin(reached))
        if np.isfinite(reached[least]):
            near = reached <= reached[least] + error[least] + error
            lows.append(points[near].min(axis=0))
            highs.append(points[near].max(axis=0))
            optimal[least] = True
    if not lows:
        return None
    widening = student_t(seeds - 1) / NORMAL_95
    ends = np.quantile(lows, 0.025, axis=0), np.quantile(highs, 0.975, axis=0)
    low, high = (np.clip(centre + widening * (end - centre), 0.0, 1.0) for end in ends)
    region = make_region(
        vary, np.minimum(low, centre), np.maximum(high, centre), points[optimal]
    )
    kept = np.ones(len(points), dtype=bool)
    for i, limit in enumerate(limits, 1):
        if limit.judges == SEED_MEAN:
            kept &= limit.holds(at_points[i]).all(axis=0)
    objective = np.where(kept, take(at_points[0], axis=0), np.inf)
    return without_unknown_ends(region, vary, points, objective, used)


STRICTER = 0.95
"""Share of a limit with every seed to which it is tightened, to see which way the optimum
moves."""

MOVES = 0.01
"""Least move of the optimum, as a share of the range of a key, that is more than noise of the
points that are tried."""


def without_unknown_ends(
    region: Region, vary: Sequence[KeyRange], points: Floats, objective: Floats, used: Floats
) -> Region:
    """Return a region without the ends that a limit with every seed leaves unknown.

    Parameters
    ----------
    region, vary
    points : ndarray, shape (n, keys)
        Points of the unit cube.
    objective, used : ndarray, shape (n,)
        Objective, infinite where another limit is exceeded, and share of the limit that is used
        with the worst seed.
    """
    within, stricter = (np.where(used <= share, objective, np.inf) for share in (1.0, STRICTER))
    best = points[np.argmin(within)]
    if np.min(objective) >= np.min(within):
        return region
    moves = points[np.argmin(stricter)] - best
    unknown = not np.isfinite(np.min(stricter))
    ends = {}
    for (key, (low, high)), move in zip(region.ends.items(), moves.tolist(), strict=True):
        ends[key] = (
            None if unknown or move < -MOVES else low,
            None if unknown or move > MOVES else high,
        )
    return region._replace(ends=ends)


def limit_warnings(result: DesignResult) -> Iterator[WarningMessage]:
    """Warn of limits within the interval of a mean, and of a stroke limit that is exceeded."""
    for verdict in result.checks:
        if result.best is not None and verdict.undecided:
            sentence = (
                f"`{verdict.check}` is undecided for the best design: the limit lies within "
                "the 95 % confidence interval of the mean, and single seeds may exceed it; use "
                "a stricter limit, or the stroke limit, which holds with every seed"
            )
            yield WarningMessage("check-undecided", sentence, {"value": verdict.value or 0.0})
    shown = result.best
    if (
        shown is None
        or result.source.stroke is None
        or stroke_limit_of(result.source) in result.limits
    ):
        return
    used = np.array([seed_values(shown, STROKE_USED)]).ravel()
    beyond = int((~STROKE_LIMIT.holds(used)).sum())
    if beyond and result.source.stops is None:
        sentence = (
            f"the best design exceeds the stroke limit in {beyond} of {len(used)} motions: "
            "design.within replaces it; leave design.within out to keep it with every seed"
        )
        yield WarningMessage("stroke-violated", sentence, {"motions": beyond})


def keys_at_bounds(result: DesignResult) -> dict[str, str]:
    """Return which keys of the shown design are at a bound: `lower` or `upper`."""
    if result.shown is None:
        return {}
    shares = shares_of(result.design.vary, result.shown.values)
    return {
        axis.key: "lower" if share <= AT_BOUND else "upper"
        for axis, share in zip(result.design.vary, shares, strict=True)
        if not AT_BOUND < share < 1.0 - AT_BOUND
    }


def design_warnings(result: DesignResult) -> Iterator[WarningMessage]:
    """Yield the warnings about a design study."""
    yield from result.case.warnings
    yield from unused_spectra_warnings(result.case)
    lost = [candidate for candidate in result.candidates if not candidate.is_known]
    if lost:
        sentence = (
            f"{len(lost)} of {len(result.candidates)} designs have no numbers ({lost[0].status}"
            f") and were passed over; the first is at {result.place(lost[0])}"
        )
        yield WarningMessage("designs-lost", sentence, {"designs": len(lost)})
    yield from limit_warnings(result)
    best, stroke = result.best, result.scenario.stroke
    if best is not None and stroke is not None and result.source.stops is None:
        exceeds = [
            row for row in best.rows if not STROKE_LIMIT.holds(row.metrics[STROKE_USED] or 0.0)
        ]
        hardest = max(best.rows, key=lambda row: hourly_stroke_used(row.metrics, stroke.limits))
        if not exceeds:
            where = ", with the best design"
            yield from hourly_stroke_warnings(hardest.metrics, stroke.limits, where)
    if not result.converged:
        sentence = (
            f"the search ended at design.evaluations, {result.design.evaluations}, before it "
            "converged; allow more"
        )
        yield WarningMessage(
            "search-not-finished", sentence, {"evaluations": result.design.evaluations}
        )
