"""Branches: all periodic motions along one key, stable and unstable, with their bifurcations.

A march in time shows the motion that one start leads to. Here the motions reached from many
starts are continued along the first key of the sweep (`orbits.continuation`). With F_fs =
F_fk and a linear spring two motions never move apart, so a single start finds the only branch;
without a damper there may be continua at single frequencies.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.stick_slip import ExactApproach
from drysim.core import compile
from drysim.core.model import Floats, Input, Sines, State
from drysim.core.status import Status
from drysim.errors import ScenarioError, WarningMessage
from drysim.excitation.harmonic import Harmonic
from drysim.friction import Leuven
from drysim.metrics.checks import Verdict
from drysim.metrics.table import evaluate
from drysim.orbits.continuation import (
    LOST,
    MANY_BRANCHES,
    MANY_PERIODS,
    MANY_POINTS,
    MAX_PERIODS,
    MERGED,
    NOT_ISOLATED,
    NOT_SWITCHED,
    Continuation,
    Gap,
    Point,
    Repetition,
)
from drysim.scenario.axes import Axis
from drysim.scenario.model import EQUATION_BLOCKS, Scenario, scene_period
from drysim.study.budget import case_cost
from drysim.study.case import Case
from drysim.study.outcome import Result, format_repr
from drysim.study.plan import approaches_of, can_solve_together, orbit_metrics, scene_array
from drysim.study.preparation import (
    assemble,
    base_motion,
    prepare,
    refuse_direction,
    require_blocks,
    require_scenario,
)
from drysim.study.run import observe_window
from drysim.study.sweep import describe_numerics
from drysim.wording import (
    format_count,
    format_length,
    format_number,
    format_quantity,
    format_quantity_range,
    format_range,
    join_words,
)
from drysim.yaml_document import KeyPath

if TYPE_CHECKING:
    from drysim.orbits.coulomb import ParameterRows
    from drysim.orbits.return_map import PeriodicSystem, ShootingReturnMap


SEED_VALUES = 17
"""Values of the key at which the motions from all starts are found."""

MARGINS = 5
"""Margins beyond either end of the range that are tried: each is half the one before."""

MAX_BRANCHES = 40

UNLOCKING_TOLERANCE = 1e-13
"""Width, as a share of the range, to which the value is located at which a stuck mass starts to
slide."""

LOCKED, UNLOCKING, GRAZING = "locked", "unlocking", "grazing"

FREQUENCY_KEYS = {"excitation.frequency", "friction.normal_variation.frequency"}


@dataclass(frozen=True, eq=False)
class Branch:
    """A branch of periodic motions."""

    number: int
    """From 1."""
    periods: int
    """Periods of the excitation per repetition."""
    symmetric: bool
    """Whether the motion repeats after half its periods with the opposite sign."""
    has_mirror_image: bool
    """Whether that makes a motion of every motion: the scene is symmetric."""
    is_locked: bool
    """Whether the mass sticks all the time, as it does from rest."""
    values: Floats
    """Values of the key along the branch, in SI, shape (n,)."""
    stops: Floats
    """Stops per period of the excitation, without immediate reversals, shape (n,); of an
    elastic contact, how often it ceases to yield."""
    contacts: Floats
    """Contacts with an end stop per period of the excitation, shape (n,)."""
    multipliers: NDArray[np.complex128]
    """Floquet multipliers of a repetition, complex, shape (n, 2); the two largest."""
    stable: NDArray[np.bool_]
    """Whether all multipliers are within the unit circle, shape (n,); not at a bifurcation at
    which one is on it."""
    residual: Floats
    """Scaled change of the state over a repetition, with the error of the march [-], shape
    (n,)."""
    multiplier_error: Floats
    """Estimated error of the multipliers [-], shape (n,); 0 where they are in closed form."""
    metrics: Mapping[str, Floats]
    """Metrics as columns, shape (n,)."""
    ends: tuple[str, str]
    """Why it ends on either side: `range`, `loop`, `merged`, `grazing`, `unlocking` or
    `limit`."""

    def parts(self) -> Iterator[tuple[bool, slice]]:
        """Yield stable and unstable parts in turn; neighbouring ones share a point.

        A step belongs to a stable part if either of its ends is stable, because the point of a
        bifurcation is not.
        """
        steps = self.stable[:-1] | self.stable[1:] if len(self.stable) > 1 else self.stable
        changes = (np.flatnonzero(np.diff(steps)) + 1).tolist()
        for begin, end in itertools.pairwise([0, *changes, len(steps)]):
            yield bool(steps[begin]), slice(begin, end + 1)

    @property
    def kind(self) -> str:
        """The kind of motion in words."""
        if self.is_locked:
            return LOCKED
        if not self.has_mirror_image:
            return f"period {self.periods}"
        symmetry = "symmetric" if self.symmetric else "unsymmetric"
        return symmetry if self.periods == 1 else f"period {self.periods}, {symmetry}"


class Bifurcation(NamedTuple):
    """A point at which motions appear, vanish or change their kind."""

    kind: str
    branch: int
    """Number of the branch."""
    value: float
    """Value of the key, in SI."""
    stops: tuple[float, float]
    """Stops per period on either side, in the order of the branch."""
    x_r_peak: float
    """Largest |x_r| [m]."""
    contacts: tuple[float, float] = (0.0, 0.0)
    """The same of contacts with an end stop."""
    position: int = 0
    """Index of the point on the branch; an end that is extrapolated is close to it."""


class Motion(NamedTuple):
    """A periodic motion at the value of the key in the scenario."""

    branch: Branch
    stable: bool
    T_a: float
    x_r_peak: float


@dataclass(frozen=True, eq=False)
class BranchesResult(Result):
    """All periodic motions that were found along a key.

    Attributes
    ----------
    scenario : Scenario
        With the sweep block.
    case : Case
    axis : Axis
        The key that varies.
    stated_value : float or None
        Its value in the scenario, if that is in the range.
    branches : tuple of Branch
    bifurcations : tuple of Bifurcation
        By value of the key.
    motions : tuple of Motion
        The motions at `stated_value`, the stable ones first.
    starts : int
        Starts from which motions were sought.
    warnings : tuple of WarningMessage
    """

    kind: ClassVar[str] = "branches"

    scenario: Scenario
    case: Case = field(compare=False)
    axis: Axis
    stated_value: float | None
    branches: tuple[Branch, ...]
    bifurcations: tuple[Bifurcation, ...]
    motions: tuple[Motion, ...]
    starts: int
    warnings: tuple[WarningMessage, ...]

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """Verdicts on the checks: skipped, as they judge one motion or many cases."""
        return tuple(
            check.skipped("branches judge no checks") for check in self.scenario.checks
        )

    @property
    def inputs(self) -> tuple[Input, ...]:
        """Records of the base motion: none under sines."""
        return self.case.inputs

    @property
    def motion(self) -> Sines:
        """Base motion of the scenario."""
        assert isinstance(self.case.motion, Sines), "only sines have orbits"
        return self.case.motion

    @property
    def method(self) -> str:
        """How orbits and multipliers are computed: in closed form, or by shooting."""
        return "by shooting" if self.multiplier_error > 0.0 else "in closed form"

    @property
    def residual(self) -> float:
        """Largest residual of all orbits [-]."""
        return max((float(branch.residual.max()) for branch in self.branches), default=0.0)

    @property
    def multiplier_error(self) -> float:
        """Largest estimated error of all multipliers [-]; 0 in closed form."""
        return max(
            (float(branch.multiplier_error.max()) for branch in self.branches), default=0.0
        )

    @property
    def numerics(self) -> dict[str, object]:
        """Core, reason, engine and step of the solutions."""
        return describe_numerics(self.case)

    def place(self, value: float) -> str:
        """Return a value of the key as text."""
        return format_quantity(value, self.axis.unit, 6)

    def interval(self, values: Floats) -> str:
        """Return the smallest and the largest of some values of the key as text."""
        low, high = float(values.min()), float(values.max())
        return format_quantity_range(low, high, self.axis.unit, 6)

    def __repr__(self) -> str:
        """Return the number of branches in one line."""
        return format_repr(
            "BranchesResult",
            self.scenario.name,
            format_count(len(self.branches), "branch"),
            format_count(len(self.bifurcations), "bifurcation"),
        )


def branches(scenario: Scenario) -> BranchesResult:
    """Follow all periodic motions along the first key of a scenario's sweep.

    Parameters
    ----------
    scenario : Scenario
        With a steady sine as base motion, and a range of one key of the oscillator, the
        friction, the excitation or the end stops as sweep.

    Returns
    -------
    BranchesResult

    Raises
    ------
    ScenarioError
        When the scenario has no such range, no steady sine, or a law that is not supported.
    UsageError
        When `scenario` is not a Scenario.
    """
    return solve(prepare_branches(scenario))


def prepare_branches(scenario: Scenario) -> Case:
    """Return the case of a scenario whose branches can be followed; errors as `branches`."""
    require_scenario(scenario)
    require_blocks(scenario)
    refuse_direction(scenario, "drysim branches")
    if not isinstance(scenario.excitation, Harmonic):
        sentence = (
            f"branches needs base motion that is a sine (`kind: harmonic`), not "
            f"{scenario.excitation.kind}: only periodic motions have branches"
        )
        raise scenario.error(sentence, ("excitation", "kind"))
    approaches_of(scenario)  # requires a sweep
    axis = scenario.sweep[0]
    if axis.group:
        sentence = "branches follows a single key: values that vary together have no branches"
        raise scenario.error(sentence, axis.location or ("sweep",))
    if axis.key == "excitation.phase":
        sentence = "a phase only shifts the time: follow another key"
        raise scenario.error(sentence, ("sweep", axis.key))
    numbers = [value for value in axis.values if isinstance(value, int | float)]
    # A limit of the stroke moves the motion where there are end stops only.
    models = (*EQUATION_BLOCKS, *["stroke"] * (scenario.stops is not None))
    if axis.key.split(".")[0] not in models or len({*numbers}) < 2:
        sentence = (
            f"branches follows the first key of the sweep, {axis.key}, which must be a range "
            "of numbers of oscillator, friction or excitation"
        )
        raise scenario.error(sentence, ("sweep", axis.key))
    checks = tuple(check for check in scenario.checks if check.keys <= {axis.key})
    # Weighted metrics are left out, as checks are.
    kept = {"sweep": (axis,), "checks": checks, "measure": scenario.measure.without_weights()}
    alone = scenario.copy_with({**kept, "reference": None})
    if refused := refusal(alone):
        sentence, keys = refused
        raise scenario.error(sentence, keys or ("sweep", axis.key))
    case = prepare(alone)
    # The start and the reference of the scenario do not matter.
    return replace(case, warnings=tuple(further_keys_warnings(scenario)))


def further_keys_warnings(scenario: Scenario) -> Iterator[WarningMessage]:
    """Warn of swept keys after the first one, which keep the values of the file."""
    first, *others = scenario.sweep
    if not others:
        return
    stated = scenario.values_of([axis.key for axis in others])
    kept = [
        f"{axis.key} at {format_quantity(stated[axis.key], axis.unit)}"
        if axis.key in stated
        else axis.key
        for axis in others
    ]
    sentence = f"branches follows {first.key} only; it keeps {join_words(kept)}"
    if lost := sum(not check.keys <= {first.key} for check in scenario.checks):
        sentence += f", and leaves out {format_count(lost, 'check')} at values of further keys"
    yield WarningMessage("one-key", sentence, {"keys": len(others)})


def refusal(scenario: Scenario) -> tuple[str, KeyPath] | None:
    """Return why branches cannot be followed, and the keys; None if they can."""
    friction, measure = scenario.active_friction, scenario.measure
    variation = getattr(friction, "normal_variation", None)
    keys = {axis.key for axis in scenario.sweep}
    if not isinstance(scenario.solver.member(), ExactApproach):
        return "branches needs an exact approach: stick-slip or viscous", ("solver", "approach")
    if getattr(friction, "normal_record", None) is not None:
        sentence = (
            "branches does not support a recorded normal force, which does not repeat; use a "
            "constant one, or normal_variation"
        )
        return sentence, ("friction", "normal_record")
    if not measure.steady:
        sentence = "branches needs a steady state: give `measure.steady`, and no window of time"
        return sentence, ("measure",)
    if isinstance(friction, Leuven):
        sentence = (
            "branches does not support the Leuven law, whose state is a stack of reversals; "
            "use lugre"
        )
        return sentence, ("friction", "law")
    if variation is not None and keys & FREQUENCY_KEYS:
        sentence = (
            "a normal force that varies has no common period with the base motion along a "
            "range of frequencies: follow another key"
        )
        return sentence, ()
    return None


def solve(case: Case) -> BranchesResult:
    """Follow the branches of a prepared case."""
    scenario = case.scenario
    axis = scenario.sweep[0]
    friction = scenario.active_friction
    varies = getattr(friction, "normal_variation", None) is not None
    if can_solve_together(scenario) and not varies:
        # As long as a large plain job: compiled kernels are used, but not compiled for this.
        steps = compile.COLD_CACHE_FACTOR * compile.MAX_PLAIN_STEPS
        compile.choose_engine(steps, "orbit.flow_and_monodromy")
        return Study(scenario, axis).solve(case)
    compile.choose_engine(MARCHED_PERIODS * case_cost(case), case.kernels)
    return MarchedStudy(scenario, axis).solve(case)


class Study:
    """Search for the branches of a scenario along an axis: Coulomb friction in closed form."""

    seed_values = SEED_VALUES
    margin = 0.5
    max_branch_points = 4000

    def __init__(self, scenario: Scenario, axis: Axis) -> None:
        self.scenario, self.axis = scenario, axis
        self.range = axis.range

    @cached_property
    def rows(self) -> ParameterRows:
        """Scenes of the orbit kernel along the key."""
        from drysim.orbits.coulomb import ParameterRows

        return ParameterRows(self.exact_rows, *map(self.value, self.limits))

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Shares of the range between which branches are followed.

        They are beyond the range by `margin`, or a part of it where that is not admissible.
        """
        ends = []
        for end, sense in ((0.0, -1.0), (1.0, 1.0)):
            shares = (end + sense * self.margin * 0.5**i for i in range(MARGINS))
            ends.append(next(filter(self.is_admissible, shares), end))
        return ends[0], ends[1]

    def is_admissible(self, p: float) -> bool:
        """Whether the scenario may have the value of the key at a share of the range."""
        try:
            scenario = self.scenario.at({self.axis.key: self.value(p)})
        except ScenarioError:
            return False
        return scene_period(scenario) is not None

    @cached_property
    def return_map(self) -> ShootingReturnMap:
        """Return map along the key."""
        from drysim.orbits.return_map import ShootingReturnMap

        return ShootingReturnMap(self.scene)

    def scene(self, p: float) -> PeriodicSystem | None:
        """Return the scene at a share of the range; None where there is none."""
        from drysim.orbits.return_map import PeriodicSystem

        return PeriodicSystem.from_row(self.rows.at(self.value(p)))

    @property
    def is_symmetric(self) -> bool:
        """Whether half a period and a change of sign leave the equation of motion as it is."""
        return True

    @property
    def section_of_start(self) -> float:
        """Section at which the scenario begins: phase of its base motion, in periods."""
        motion = self.scenario.excitation.motion()
        assert isinstance(motion, Sines), "see `prepare_branches`"
        return float(motion.phase[0]) / math.tau % 1.0

    def exact_rows(self, values: Floats) -> Floats:
        """Return the rows of the orbit kernel for many values of the key.

        A phase of the base motion only shifts the time: it is 0.
        """
        from drysim.core.orbit import SINES

        rows = scene_array(self.scenario, {self.axis.key: values}, len(values))[0]
        rows[:, SINES + 2] = 0.0
        return rows

    def value(self, p: float) -> float:
        """Return the value of the key at a share of its range."""
        return float(self.range.value(p))

    def solve(self, case: Case) -> BranchesResult:
        """Find seeds, follow the branches through them, and measure all points."""
        continuation = Continuation(
            self.return_map, self.is_symmetric, self.limits, self.max_branch_points
        )
        value_here = self.scenario.values_of([self.axis.key]).get(self.axis.key)
        if value_here is not None and not self.range.low <= value_here <= self.range.high:
            value_here = None
        shares = np.linspace(0.0, 1.0, self.seed_values)
        seeds = self.seeds(shares, [] if value_here is None else [*self.own_start(value_here)])
        followed, gaps = continuation.find_branches(seeds.orbits, MAX_BRANCHES)
        branches: list[Branch] = []
        bifurcations: list[Bifurcation] = []
        for number, low, high in self.locked_ranges(shares, seeds.stuck):
            branch = self.locked_branch(number, low, high)
            branches.append(branch)
            bifurcations += [
                Bifurcation(UNLOCKING, number, value, (0.0, 0.0), 0.0, position=position)
                for value, end, position in zip(
                    (low, high), branch.ends, (0, len(branch.values) - 1), strict=True
                )
                if end == UNLOCKING
            ]
        for course in followed:
            number = len(branches) + 1
            branches.append(self.measured_branch(number, course, continuation))
            per_period = (2.0 if course.repetition.half else 1.0) / course.repetition.periods
            marked = {bifurcation.position for bifurcation in course.bifurcations}
            for kind, point, position in course.bifurcations:
                before, after = (
                    [count * per_period for count in course.points[i].image.counts]
                    for i in neighbours(position, marked, len(course.points))
                )
                bifurcations.append(
                    Bifurcation(
                        kind,
                        number,
                        self.value(point.p),
                        (before[0], after[0]),
                        point.image.peak,
                        (before[2], after[2]),
                        position,
                    )
                )
        motions = (
            []
            if value_here is None
            else [*self.motions_at(value_here, branches, followed, continuation)]
        )
        return BranchesResult(
            self.scenario,
            case,
            self.axis,
            value_here,
            tuple(branches),
            tuple(sorted(bifurcations, key=lambda bifurcation: bifurcation.value)),
            tuple(sorted(motions, key=lambda motion: (not motion.stable, motion.x_r_peak))),
            seeds.starts,
            tuple(self.warnings(case, seeds, gaps)),
        )

    # Motions reached from many starts

    def own_start(self, value: float) -> Iterator[tuple[float, Floats]]:
        """Yield the start of the scenario at its own value of the key: what a run shows.

        It is given as the share of the range and the state at the section 0, to which the mass
        moves from a start at another phase of the base motion.
        """
        p, state = self.range.share(value), np.array(self.scenario.start.state())
        if begin := self.section_of_start:
            later = np.array([1.0 - begin])
            states = self.return_map.states(p, state, Repetition(begin=begin), later)
            if states is None:
                return
            state = states[0]
        yield p, state

    def seeds(self, shares: Floats, others: Sequence[tuple[float, Floats]]) -> Seeds:
        """Return the orbits reached from many starts at some shares of the range, and others.

        `others` are shares and states at the section 0.
        """
        from drysim.core import orbit as o
        from drysim.core.forcing import V_R, X_R
        from drysim.orbits.coulomb import solve_orbits
        from drysim.study.other_motions import can_have_other_motions, orbit_starts

        starts: list[tuple[float, Floats]] = []
        for p in shares.tolist():
            row = self.rows.at(self.value(p))[None]
            has_others = can_have_other_motions(row)[0]
            starts += [
                (p, state)
                for state in (orbit_starts(row)[:, 0] if has_others else np.zeros((1, 2)))
            ]
        starts += others
        scenes = np.array([self.rows.at(self.value(p)) for p, _ in starts])
        scenes[:, [X_R, V_R]] = [state for _, state in starts]
        orbits, stuck, lost = [], set(), 0
        for (p, _), scene, answer in zip(starts, scenes, solve_orbits(scenes), strict=True):
            status = answer[o.STATUS]
            if status != Status.OK:
                lost += 1
                continue
            if answer[o.SLIDING_DISTANCE] == 0.0:
                # Only from rest: other positions at which the mass sticks are alike.
                if not scene[[X_R, V_R]].any():
                    stuck.add(p)
                continue
            peak = max(answer[o.HIGHEST], -answer[o.LOWEST])
            state = answer[[o.X_BEGIN, o.V_BEGIN]].copy()
            orbits.append((p, state, float(peak), int(answer[o.MULTIPLE])))
        return Seeds(orbits, stuck, lost, len(scenes))

    def locked_ranges(
        self, shares: Floats, stuck: set[float]
    ) -> Iterator[tuple[int, float, float]]:
        """Yield number, first and last value of the ranges in which a mass at rest sticks."""
        number, begin = 0, None
        listed = [*shares.tolist()]
        for i, p in enumerate(listed):
            if p in stuck and begin is None:
                begin = p if i == 0 else self.unlocking(listed[i - 1], p)
            if begin is not None and (p not in stuck or i == len(listed) - 1):
                end = p if p in stuck else self.unlocking(p, listed[i - 1])
                number += 1
                yield number, self.value(begin), self.value(end)
                begin = None

    def unlocking(self, moving: float, stuck: float) -> float:
        """Return the share of the range between two at which a mass at rest begins to slide."""
        while abs(moving - stuck) > UNLOCKING_TOLERANCE:
            middle = 0.5 * (moving + stuck)
            if middle in (moving, stuck):
                break
            if self.return_map.sticks(middle):
                stuck = middle
            else:
                moving = middle
        return stuck

    def locked_branch(self, number: int, low: float, high: float) -> Branch:
        """Return the branch of a mass that sticks at x_r = 0."""
        inside = [
            value
            for value in map(self.value, np.linspace(0.0, 1.0, SEED_VALUES))
            if low < value < high
        ]
        values = np.array([low, *inside, high])
        states = np.zeros((len(values), 2))
        metrics = self.metrics_at(values, states, [Repetition()] * len(values))
        ends = tuple(
            "range" if math.isclose(value, end, rel_tol=1e-12) else UNLOCKING
            for value, end in ((low, self.range.low), (high, self.range.high))
        )
        multipliers = np.tile(np.array([1.0 + 0j, 0j]), (len(values), 1))
        none = np.zeros(len(values))
        return Branch(
            number, 1, self.is_symmetric, self.is_symmetric, True, values, none, none,
            multipliers, np.ones(len(values), bool), none, none, metrics, (ends[0], ends[1]),
        )  # fmt: skip

    # Points of a branch

    def measured_branch(self, number: int, course: Any, continuation: Continuation) -> Branch:
        """Return a branch with the metrics of its points."""
        half, periods = course.repetition.half, course.repetition.periods
        residuals = [
            continuation.residual(point) + self.march_error(point) for point in course.points
        ]
        values = np.array([self.value(min(max(point.p, 0.0), 1.0)) for point in course.points])
        states = np.array([point.state for point in course.points])
        multipliers = np.array([point.multipliers for point in course.points])
        order = np.argsort(-abs(multipliers), axis=1, kind="stable")
        multipliers = np.take_along_axis(multipliers, order, axis=1)
        if half:
            multipliers = multipliers**2
        # Up to a bifurcation, which is located, its neighbours are as stable as the branch.
        stable = np.asarray((abs(multipliers) < 1.0).all(axis=1))
        neutral = [
            bifurcation.position
            for bifurcation in course.bifurcations
            if bifurcation.kind != GRAZING
        ]
        neutral += [
            position
            for position, end in zip((0, -1), course.ends, strict=True)
            if end == MERGED
        ]
        stable[neutral] = False
        counts = np.array([point.image.counts for point in course.points], dtype=float)
        stops, _, contacts = counts.T * (2.0 if half else 1.0) / periods
        return Branch(
            number,
            periods,
            half,
            self.is_symmetric,
            False,
            values,
            stops,
            contacts,
            multipliers[:, :2],
            stable,
            np.array(residuals),
            np.array([point.image.jacobian_error for point in course.points]),
            self.metrics_at(
                values,
                states,
                [point.repetition._replace(half=False) for point in course.points],
            ),
            course.ends,
        )

    def march_error(self, point: Point) -> float:
        """Return the scaled error of the motion over a repetition."""
        return self.return_map.march_error(point.p, point.state, point.image, point.repetition)

    def metrics_at(
        self, values: Floats, states: Floats, repetitions: Sequence[Repetition]
    ) -> dict[str, Floats]:
        """Return the metrics of orbits over whole periods as columns."""
        from drysim.core.forcing import V_R, X_R
        from drysim.core.orbit import SINES
        from drysim.orbits.coulomb import measure_orbits

        scenes = self.exact_rows(values)
        scenes[:, [X_R, V_R]] = states
        scenes[:, SINES + 2] += [math.tau * repetition.begin for repetition in repetitions]
        results = measure_orbits(
            scenes, np.array([float(repetition.periods) for repetition in repetitions])
        )
        return orbit_metrics(scenes, results, np.zeros(len(values), np.int8))

    def motions_at(
        self, value: float, branches: list[Branch], followed: Any, continuation: Any
    ) -> Iterator[Motion]:
        """Yield the motions at one value of the key."""
        locked = [branch for branch in branches if branch.is_locked]
        for branch in locked:
            if branch.values[0] <= value <= branch.values[-1]:
                yield Motion(branch, True, 1.0, 0.0)
        p = self.range.share(value)
        for branch, course in zip(branches[len(locked) :], followed, strict=True):
            for point in continuation.crossings(course, p):
                whole = point.repetition._replace(half=False)
                metrics = self.metrics_at(np.array([value]), point.state[None], [whole])
                stable = bool((abs(point.multipliers) < 1.0).all())
                T_a, peak = float(metrics["T_a"][0]), float(metrics["x_r_peak"][0])
                yield Motion(branch, stable, T_a, peak)

    def warnings(
        self, case: Case, seeds: Seeds, gaps: Sequence[Gap]
    ) -> Iterator[WarningMessage]:
        """Yield the warnings about a search for branches."""
        yield from case.warnings
        if seeds.lost:
            sentence = (
                f"{seeds.lost} of {seeds.starts} starts did not settle on one periodic motion: "
                "it decays too slowly, is not periodic, or is one of a continuum; branches may "
                "be missing"
            )
            yield WarningMessage("starts-not-settled", sentence, {"starts": seeds.lost})
        for reason, (slug, sentence) in GAP_WARNINGS.items():
            values = sorted({self.value(gap.p) for gap in gaps if gap.reason == reason})
            if values:
                places = format_count(len(values), "place")
                where = f"{places} ({describe_values(values, self.axis.unit)})"
                numbers = {"count": len(values), "lowest": values[0], "highest": values[-1]}
                sentence = sentence.format(at=where, points=self.max_branch_points)
                yield WarningMessage(slug, sentence, numbers)


MAX_LISTED_GAPS = 4
"""Values of the key that a warning lists."""


def describe_values(values: Sequence[float], unit: str) -> str:
    """Return some values of a key as text, e.g. `1.2 N, 1.3 N and 5 more`."""
    listed = [format_quantity(value, unit, 6) for value in values[:MAX_LISTED_GAPS]]
    more = len(values) - len(listed)
    return join_words([*listed, f"{more} more"] if more else listed)


GAP_WARNINGS = {
    LOST: ("branch-lost", "the continuation failed at {at}: branches may go on there"),
    MANY_POINTS: (
        "branch-too-long",
        "{points} points did not suffice at {at}: branches go on there; take a smaller range",
    ),
    MANY_PERIODS: (
        "periods-left-out",
        f"motions that repeat after more than {MAX_PERIODS} periods are not followed: they "
        "begin at {at}",
    ),
    NOT_SWITCHED: (
        "branching-failed",
        "the branches that leave the bifurcations at {at} were not found",
    ),
    NOT_ISOLATED: (
        "motions-left-out",
        "stable motions at {at} have no branch: their return map could not be solved",
    ),
    MANY_BRANCHES: (
        "branches-left-out",
        f"only the first {MAX_BRANCHES} branches were followed; take a smaller range",
    ),
}
"""Slug and sentence of the warning about each reason of a gap."""


MARCHED_PERIODS = 20_000
"""Periods marched along the branches of a scene that is not in closed form, roughly."""


class MarchedStudy(Study):
    """Search for the branches of a scene that is marched: other laws, end stops, directions."""

    seed_values = 9
    margin = 0.25
    max_branch_points = 1000

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether half a period and a change of sign leave the equation of motion as it is."""
        scenes = [self.scene(p) for p in (0.0, 0.5, 1.0)]
        return all(scene is not None and scene.is_symmetric for scene in scenes)

    def scene(self, p: float) -> PeriodicSystem | None:
        """Return the scene at a share of the range; None where there is none."""
        from drysim.orbits.return_map import PeriodicSystem

        try:
            scenario = self.scenario.at({self.axis.key: self.value(p)})
        except ScenarioError:
            return None
        approach, period, motion = (
            scenario.solver.member(),
            scene_period(scenario),
            scenario.excitation.motion(),
        )
        assert isinstance(approach, ExactApproach), "see `refusal`"
        assert isinstance(motion, Sines), "see `prepare_branches`"
        if period is None:
            return None
        law = approach.effective_law(scenario.law())
        scene = PeriodicSystem(scenario.oscillator.plant(), law, motion, period)
        # A phase of the base motion only shifts the time.
        return scene.delayed(-motion.phase[0] / (math.tau * motion.f[0] * period))

    def own_start(self, value: float) -> Iterator[tuple[float, Floats]]:
        """Yield the start of the scenario if it is at the section 0: see `Study.own_start`."""
        if self.section_of_start == 0.0:
            yield from super().own_start(value)

    def seeds(self, shares: Floats, others: Sequence[tuple[float, Floats]]) -> Seeds:
        """Return the orbits reached from many starts, as of Coulomb friction."""
        starts = [
            (p, start)
            for p in shares.tolist()
            if (scene := self.scene(p)) is not None
            for start in scene.starts
        ]
        starts += [(p, State(*state.tolist())) for p, state in others]
        orbits, stuck, lost = [], set(), 0
        for p, start in starts:
            orbit = self.return_map.orbit(p, start)
            if orbit is None:
                lost += 1
            elif not orbit.is_stuck:
                orbits.append((p, orbit.state, orbit.peak, orbit.periods))
            elif not any(start):
                stuck.add(p)
        return Seeds(orbits, stuck, lost, len(starts))

    def metrics_at(
        self, values: Floats, states: Floats, repetitions: Sequence[Repetition]
    ) -> dict[str, Floats]:
        """Return the metrics of orbits over whole periods as columns."""
        rows = []
        for value, state, repetition in zip(values.tolist(), states, repetitions, strict=True):
            scenario = self.scenario.at({self.axis.key: value})
            case, scene = (
                assemble(scenario, base_motion(scenario)),
                self.scene(self.range.share(value)),
            )
            assert scene is not None, "a motion has a scene"
            scene = scene.delayed(repetition.begin)
            _, trajectory = self.return_map.march(scene, state, repetition)
            window = 0.0, trajectory.end
            rows.append(evaluate(observe_window(case, trajectory, window, None, None)))
        return {
            name: np.array([row[name] for row in rows], dtype=float)  # None becomes NaN
            for name in rows[0]
        }


def neighbours(index: int, marked: set[int], count: int) -> tuple[int, int]:
    """Return the indices before and after a bifurcation that are no bifurcations themselves.

    At an end of the branch, with `count` points, it is the end itself.
    """
    before, after = index, index
    while before in marked and before > 0:
        before -= 1
    while after in marked and after < count - 1:
        after += 1
    return before, after


def describe_branch(branch: Branch) -> str:
    """Describe the motion on a branch, e.g. `symmetric, 2 stops per period`."""
    if branch.is_locked:
        return "locked from rest"
    counted = [
        f"{format_range(float(counts.min()), float(counts.max()))} {name}"
        for counts, name in ((branch.stops, "stops"), (branch.contacts, "contacts"))
        if counts.any()
    ]
    counts_per_period = f"{' and '.join(counted)} per period" if counted else "no stops"
    return f"{branch.kind}, {counts_per_period}"


def describe_motions(result: BranchesResult) -> str:
    """Describe the motions at the value of the key in the scenario."""
    if result.stated_value is None:
        return ""
    listed = "; ".join(
        f"{'stable' if motion.stable else 'unstable'}, "
        + (LOCKED if motion.branch.is_locked else motion.branch.kind)
        + f": T_a {format_number(motion.T_a, digits=4)}, "
        f"stroke {format_length(motion.x_r_peak)}"
        for motion in result.motions
    )
    return f"at {result.place(result.stated_value)}: {listed or 'none found'}"


class Seeds(NamedTuple):
    """Orbits reached from many starts."""

    orbits: list[tuple[float, Floats, float, int]]
    """Share of the range, state, largest |x_r| [m] and periods of each orbit."""
    stuck: set[float]
    """Shares of the range at which a mass at rest sticks."""
    lost: int
    """Number of starts that did not settle."""
    starts: int
    """Number of all starts."""
