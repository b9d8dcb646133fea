"""Regime map: the kinds of steady motion over two keys, and the boundaries between them.

Problem
    The steady motion under sines and Coulomb friction is of distinct kinds: locked, sliding
    without stops, with two or more stops per period, unsymmetric, of several periods. In the
    plane of two keys each kind is a region with sharp boundaries, and so are the regions of
    isolation (T_a < 1), of a stroke beyond its limit, and of several stable motions.

Method
    1. Solve the periodic orbit from the start of the scenario at every node of a grid, many in
       one call of the kernel, and label it in each field.
    2. With F_fs above F_fk other starts may lead to other orbits. Where one is found, continue
       it to the neighbouring nodes: its basin may be too small to be hit by a fixed start.
       Where the regime changes on an edge, continue the orbit of each side past the change: a
       region of two motions that begins there may be narrower than a cell.
    3. On every edge whose ends have different labels, bisect to the label of one end; if that
       does not lead to the label of the other end, bisect the rest of the edge again. The
       workers bisect some edges each, all of them at once.
    4. Join the crossings in the cells to lines (`boundaries`).

    Random base motion has no steady motion: its map shows how often the mass breaks away from
    sticking (`break_aways`).

What may be missed
    A region without a node of the grid, and between two equal labels on an edge, but for a
    second motion next to a change of regime. Where the motion settles too slowly to be
    labelled, as next to a loss of symmetry, the boundary is the middle of the unlabelled strip,
    whose width is reported.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.stick_slip import ExactApproach
from drysim.core.model import CoulombLaw, Floats, Sines, has_friction
from drysim.core.status import Status
from drysim.errors import WarningMessage
from drysim.excitation.harmonic import Harmonic, SineSum
from drysim.excitation.random import RandomMotion
from drysim.friction import Coulomb
from drysim.metrics.checks import Verdict
from drysim.metrics.table import Values
from drysim.parallel import WorkerPool, worker_count
from drysim.scenario.axes import SWEEP_KEY, Axis, KeyRange
from drysim.scenario.examples import map_example
from drysim.scenario.model import EQUATION_BLOCKS, Scenario
from drysim.scenario.text import ALL_SHARED, describe_scene
from drysim.study.boundaries import (
    LOCKED,
    REGIME,
    Crossing,
    Crossings,
    Grid,
    Integers,
    Joined,
    join_crossings,
    on_edges,
    polylines,
)
from drysim.study.break_aways import (
    FIRST,
    RICE,
    RateNet,
    RatePlane,
    Rates,
    describe_label,
    describe_level,
)
from drysim.study.case import Case
from drysim.study.outcome import Result, format_repr
from drysim.study.plan import can_solve_together, scene_array
from drysim.study.preparation import (
    prepare,
    refuse_direction,
    require_blocks,
    require_scenario,
)
from drysim.study.sweep import choose_engine
from drysim.wording import format_quantity

Labels = Mapping[str, Integers]
Columns = tuple[NDArray[Any], ...]
Advance = Callable[[int], None]

ISOLATION, STROKE, SEVERAL = "isolation", "stroke", "several"
"""Fields of labels of a steady motion, beside its `REGIME`: whether T_a is below 1; whether
|x_r| reaches the stroke limit; whether other starts lead to another stable motion."""

UNRESOLVED, UNSETTLED = -3, -2
"""Regimes of a motion too small to be told from rounding, and of one without a settled or
unique orbit. Labels of other fields are the same where they mean nothing, and 0 or 1
otherwise. No node and no region is unresolved: bisection takes the label of the neighbour."""

UNSYMMETRIC, PERIODS = 10_000, 1_000_000
"""Added to the number of stops per period of an unsymmetric orbit, and the regime of all orbits
that repeat after several periods: their numbers change from point to point next to chaos."""

MIN_NODES, USUAL_NODES, MAX_ORBITS = 33, 129, 1_000_000
"""Nodes along an axis: those of the sweep if they are at least `MIN_NODES`, else `USUAL_NODES`;
and most nodes of a grid."""

MIN_ORBITS, ORBITS_PER_CALL = 32, 512
"""Least and most orbits in one call of the kernel: 0.5 to 10 ms of work."""

EDGES_PER_PIECE = 32
"""Edges that a worker bisects at once, whatever the number of workers. With fewer, numpy takes
more than a fifth of the time, beside the kernel."""

STARTED_NODES = 3
"""Other starts are tried at every third node of a grid, as there are 13 of them."""

ASYMMETRY_TOLERANCE = 1e-6
"""Relative asymmetry above which an orbit is unsymmetric; converged symmetric orbits have less
than 1e-9. Near the loss of symmetry it grows as the root of the distance."""

SMALLEST_MOTION = 1e-9
"""Largest |x_r| as a share of A/f² below which the kind of a motion is rounding, as next to the
locked mass with F_fs = F_fk."""

SMALLEST_EXCESS = 1e-4
"""Excess of m A over F_fs and F_fk, relative, below which a motion from rest is too small. It
would take thousands of periods to close to rounding."""

SMALLEST_SHARE = 1e-9
"""Share of the map up to which a regime is rounding between two others."""

SMALLEST_CHANGE = 1e-11
"""Difference of T_a² from 1 that is rounding."""

HALVINGS, HALVINGS_TO_FOLD = 35, 20
"""Bisections of an edge: to 1e-12 of the axis; and to 3e-8 of it up to the end of a second
motion, where both the motion and its continuation settle ever more slowly. The last interval is
the width of that boundary."""

NEXT_TO_CHANGE = 1e-6
"""Distance from a change of regime, as a share of the edge, at which the orbit of one side is
continued to the other."""

MAX_REGIONS_PER_EDGE = 16
"""Most regions that are looked for on one edge."""


# Axes and place of a map.


def require_map(scenario: Scenario) -> tuple[tuple[KeyRange, KeyRange], Grid]:
    """Return axes and grid of a map; raise ScenarioError for what it does not support."""
    require_scenario(scenario)
    require_blocks(scenario)
    refuse_direction(scenario, "drysim map")
    sweep, excitation = scenario.sweep, scenario.excitation
    if not isinstance(excitation, Harmonic | SineSum | RandomMotion):
        sentence = (
            f"excitation.kind {excitation.kind} has no periodic orbits and no rates; a "
            "map needs `harmonic`, `sines` or random base motion"
        )
        raise scenario.error(sentence, ("excitation", "kind"))
    if not sweep:
        sentence = "sweep is required: its two keys are the axes of the map"
        raise scenario.error(sentence, SWEEP_KEY, map_example(scenario))
    for axis in sweep:
        if axis.group:
            kind = axis.group.partition(".")[0]
            sentence = f"{SWEEP_KEY}.{kind} varies keys together; a map needs two ranges"
            raise scenario.error(sentence, (SWEEP_KEY, kind))
    if len(sweep) != 2:
        keys = ", ".join(axis.key for axis in sweep)
        remedy = "keep two" if len(sweep) > 2 else "add a second one"
        sentence = f"a map has two axes, but {SWEEP_KEY} has {len(sweep)}: {keys}; {remedy}"
        raise scenario.error(sentence, SWEEP_KEY)
    axes = read_axis(scenario, sweep[0]), read_axis(scenario, sweep[1])
    counts = (len(axis.values) for axis in sweep)
    least = 2 if is_random(scenario) else MIN_NODES
    grid = Grid(*(count if count >= least else USUAL_NODES for count in counts))
    if grid.nodes > MAX_ORBITS:
        sentence = f"sweep has {grid.nodes} nodes; a map takes at most {MAX_ORBITS}"
        raise scenario.error(f"{sentence}, as with larger steps", SWEEP_KEY)
    if scenario.stops is not None:
        sentence = "stroke has end stops, which a map does not support; remove them"
        raise scenario.error(sentence, "stroke")
    law = scenario.active_friction
    if law is not None and not isinstance(law, Coulomb):
        sentence = f"friction.law {law.law} is not supported by a map; take coulomb"
        raise scenario.error(sentence, ("friction", "law"))
    if is_random(scenario):
        require_rates(scenario)
    elif not can_solve_together(steady_scenario(scenario)):
        sentence = (
            "a map needs the approach stick-slip, a damper and friction that are the same in "
            "both directions, and a normal force that never vanishes"
        )
        raise scenario.error(sentence, "friction" if law else "oscillator")
    return axes, grid


def is_random(scenario: Scenario) -> bool:
    """Return whether the map shows the rate of break-aways, as there are no regimes."""
    return isinstance(scenario.excitation, RandomMotion)


def require_rates(scenario: Scenario) -> None:
    """Raise ScenarioError where the break-aways of a random motion cannot be counted."""
    law = scenario.law()
    if not has_friction(law) and scenario.active_friction is None:
        sentence = (
            "under random base motion a map shows how often friction breaks away; state it"
        )
        raise scenario.error(sentence, "friction")
    is_exact = isinstance(scenario.solver.member(), ExactApproach)
    if not is_exact or not isinstance(law, CoulombLaw) or law.variation:
        sentence = (
            "a map under random base motion needs the approach stick-slip, a damper and "
            "friction that are the same in both directions, and a constant normal force"
        )
        raise scenario.error(sentence, "friction")
    if isinstance(scenario.excitation, RandomMotion) and scenario.excitation.until is not None:
        sentence = "excitation.until is not supported by a map; state a number of seeds"
        raise scenario.error(sentence, ("excitation", "until"))


def read_axis(scenario: Scenario, axis: Axis) -> KeyRange:
    """Return an axis of the map; raise ScenarioError for one that is not a range of floats."""
    location = axis.location or (SWEEP_KEY, axis.key)
    if axis.key.partition(".")[0] not in EQUATION_BLOCKS or isinstance(
        axis.values[0], int | str
    ):
        sentence = (
            f"{axis.key} cannot be an axis of a map; take a number of oscillator, friction or "
            "excitation"
        )
        raise scenario.error(sentence, location)
    if not isinstance(axis.entry, Mapping):
        low, high = min(axis.values), max(axis.values)
        sentence = (
            f"{axis.key} has a list of values; a map needs a range, such as "
            f"{{from: {low:g}, to: {high:g}, count: {USUAL_NODES}}}"
        )
        raise scenario.error(sentence, location)
    return axis.range


def steady_scenario(scenario: Scenario) -> Scenario:
    """Return the scenario with the steady state as its window, without weighting."""
    steady = scenario.measure.without_weights().model_copy(update={"steady": True})
    return scenario.copy_with({"measure": steady})


# Results.


class Boundary(NamedTuple):
    """A traced line between two regions."""

    field: str
    """`REGIME` or another field."""
    labels: tuple[int, int]
    """Labels of the regions on both sides."""
    points: Floats
    """Values at both axes in SI, shape (n, 2)."""
    width: float
    """Largest width of the strip in which the boundary lies, as a share of an axis; 0 if it is
    known to rounding. A second motion ends within this width of the line."""

    @property
    def name(self) -> str:
        """What the line separates."""
        if min(self.labels) >= FIRST:
            rate = describe_level(self.labels)
            return rate if self.field == REGIME else f"{rate} by Rice's formula"
        if self.field == REGIME:
            return " | ".join(map(describe_regime, self.labels))
        return LINE_NAMES[self.field]


LINE_NAMES = {
    ISOLATION: "T_a = 1",
    STROKE: "stroke limit reached",
    SEVERAL: "several stable motions",
}
"""Names of the boundaries of the other fields."""


class Change(NamedTuple):
    """A boundary that the scenario meets along one axis."""

    key: str
    unit: str
    distance: float
    """Signed change of the key up to the boundary, SI."""
    share: float
    """The same as a share of the axis."""
    field: str
    """The field that changes."""
    sentence: str
    """What changes there."""

    @property
    def step(self) -> str:
        """The change of the key as text."""
        more = "more" if self.distance > 0.0 else "less"
        return f"{format_quantity(abs(self.distance), self.unit, 3)} {more}"

    def __str__(self) -> str:
        """Return the change as one sentence."""
        return f"{self.step} {self.key}: {self.sentence}"


class Place(NamedTuple):
    """The scenario itself in the map."""

    values: Mapping[str, float]
    """Its values at the axes; empty if it does not state both."""
    labels: Mapping[str, int]
    """Its label in each field."""
    changes: tuple[Change, ...]
    """In each direction along each axis the nearest boundary and, if that is another one, the
    nearest at which the regime changes; empty if the scenario lies outside the map."""
    is_inside: bool
    rates: Rates | None = None
    """Under random base motion."""

    @property
    def nearest(self) -> Change | None:
        """The change of regime at the smallest share of an axis, or any change without one."""
        of_regime = [change for change in self.changes if change.field == REGIME]
        return min(
            of_regime or self.changes, key=lambda change: abs(change.share), default=None
        )


class Patch(NamedTuple):
    """Part of a cell with one label of a field."""

    field: str
    label: int
    points: Floats
    """Polygon in SI, shape (n, 2)."""
    area: float
    """As a share of the map."""


@dataclass(frozen=True, eq=False)
class RegimeMap(Result):
    """Regimes of the steady motion over two keys, and the boundaries between them.

    Attributes
    ----------
    case : Case
    axes : tuple of KeyRange
    grid : Grid
        Numbers of nodes along both axes.
    labels : mapping
        Labels of the nodes in each field, arrays of shape (second axis, first axis).
    boundaries : tuple of Boundary
    patches : tuple of Patch
        The cells that hold a boundary, divided along it.
    place : Place
        The scenario itself.
    cases : int
        Number of orbits, or of points of a random motion, that were solved.
    """

    kind: ClassVar[str] = "map"

    case: Case = field(compare=False)
    axes: tuple[KeyRange, KeyRange]
    grid: Grid
    labels: Labels
    boundaries: tuple[Boundary, ...]
    patches: tuple[Patch, ...]
    place: Place
    cases: int

    @property
    def checks(self) -> tuple[Verdict, ...]:
        """Verdicts on the checks: skipped, as they judge one motion or many cases."""
        return tuple(check.skipped("a map judges no checks") for check in self.scenario.checks)

    @property
    def scenario(self) -> Scenario:
        """The scenario with its sweep."""
        return self.case.scenario

    @property
    def warnings(self) -> tuple[WarningMessage, ...]:
        """Warnings about the scenario."""
        return self.case.warnings

    @property
    def motion(self) -> Sines | None:
        """Base motion of the scenario itself."""
        return self.case.motion if isinstance(self.case.motion, Sines) else None

    @property
    def metrics(self) -> Values:
        """A map has regimes in place of metrics."""
        return {}

    @cached_property
    def nodes(self) -> tuple[Floats, Floats]:
        """Values at the nodes along both axes."""
        (along, across), shares = self.axes, self.grid.shares
        return along.value(shares[0]), across.value(shares[1])

    @cached_property
    def shares(self) -> dict[int, float]:
        """Share of the map in each regime, the largest first."""
        labels = {*np.unique(self.labels[REGIME]).tolist()}
        labels |= {patch.label for patch in self.patches if patch.field == REGIME}
        shares = {label: self.share(REGIME, label) for label in sorted(labels)}
        return {
            label: share
            for label, share in sorted(shares.items(), key=lambda item: -item[1])
            if share > SMALLEST_SHARE
        }

    @property
    def regimes(self) -> dict[str, float]:
        """Share of the map by the name of the regime, the largest first."""
        return {describe_regime(label): share for label, share in self.shares.items()}

    def share(self, field: str, label: int = 1) -> float:
        """Return the share of the map with a label in a field, its narrowest parts included."""
        cells = (self.grid.columns - 1) * (self.grid.rows - 1)
        whole = float(self.whole_cells(field, label).sum()) / cells
        return whole + sum(patch.area for patch in self.parts(field, label))

    def whole_cells(self, field: str, label: int = 1) -> NDArray[np.bool_]:
        """Return the cells with a label at all four corners; no boundary divides them."""
        inside = self.labels[field] == label
        whole: NDArray[np.bool_] = (
            inside[:-1, :-1] & inside[1:, :-1] & inside[:-1, 1:] & inside[1:, 1:]
        )
        return whole

    def parts(self, field: str, label: int = 1) -> list[Patch]:
        """Return the parts of divided cells with a label in a field."""
        return [p for p in self.patches if p.field == field and p.label == label]

    def describe_place(self) -> Iterator[str]:
        """Yield what the scenario itself does, in the fields that have a meaning."""
        labels = self.place.labels
        if self.place.rates is not None:
            yield str(self.place.rates)
        elif REGIME in labels:
            yield describe_regime(labels[REGIME])
        if labels.get(ISOLATION, LOCKED) >= 0:
            yield "isolates, T_a below 1" if labels[ISOLATION] else "does not isolate"
        if labels.get(STROKE) == 1:
            yield "reaches the stroke limit"
        if labels.get(SEVERAL) == 1:
            yield "another start leads to another stable motion"

    def __repr__(self) -> str:
        """Return the regimes in one line."""
        names = ", ".join(self.regimes)
        lines = f"{len(self.boundaries)} lines"
        return format_repr("RegimeMap", self.scenario.name, lines, names)


def describe_fixed(case: Case, keys: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield label and text of the oscillator and the friction, without what varies."""
    varies = any(key.startswith("friction.") for key in keys)
    shared = dict.fromkeys(ALL_SHARED, not varies)
    yield from describe_scene(case.scenario, case.plant, case.scenario.law(), keys, shared)


def describe_regime(label: int) -> str:
    """Return the name of a regime."""
    if label == UNSETTLED:
        return "no single steady motion"
    if label == LOCKED:
        return "locked"
    if label == PERIODS:
        return "repeats after several periods"
    if label >= FIRST:
        return describe_label(label)
    stops = describe_stops(label % UNSYMMETRIC)
    return f"unsymmetric, {stops}" if label >= UNSYMMETRIC else stops


def describe_stops(count: int) -> str:
    """Return the number of stops per period as text."""
    if count == 0:
        return "sliding without stops"
    return f"{count} stop{'s' * (count > 1)} a period"


def describe_change(field: str, label: int) -> str:
    """Return what happens where a label begins."""
    if field == ISOLATION:
        return f"isolation {'begins, T_a falls below' if label else 'ends, T_a rises above'} 1"
    if field == STROKE:
        return f"it {'reaches' if label else 'stays within'} the stroke limit"
    if field == SEVERAL:
        return f"a second stable motion {'appears' if label else 'ends'}"
    if label == UNSETTLED:
        return "there is no single steady motion"
    if label == LOCKED:
        return "it locks"
    if label == PERIODS:
        return "it repeats only after several periods"
    count = label % UNSYMMETRIC
    times = {0: "slides without stops", 1: "stops once a period", 2: "stops twice a period"}
    stops = times.get(count, f"stops {count} times a period")
    return f"it {stops}{', unsymmetrically' * (label >= UNSYMMETRIC)}"


# The map.


def map_regimes(scenario: Scenario, *, workers: int | None = None) -> RegimeMap:
    """Map the regimes of the steady motion over the two keys of a scenario's sweep block.

    Parameters
    ----------
    scenario : Scenario
        Under sines, with Coulomb friction or none, and two ranges in its sweep block.
    workers : int, optional
        Number of workers; default: one per processor. The result does not depend on it.

    Returns
    -------
    RegimeMap

    Raises
    ------
    ScenarioError
        When the scenario has no two ranges, or something that a map does not support.
    UsageError
        When `scenario` is not a Scenario, or `workers` not a number of workers.
    """
    return solve(prepare_map(scenario), workers=workers)


def prepare_map(scenario: Scenario) -> Case:
    """Return the case of a map; errors as `map_regimes`."""
    require_map(scenario)
    # A map has no weighted metrics and judges no checks: nothing is to be said of them.
    measure = scenario.measure.without_weights()
    case = prepare(scenario.copy_with({"measure": measure, "checks": ()}))
    return replace(case, scenario=scenario)


def solve(
    case: Case, *, workers: int | None = None, advance: Advance = lambda _: None
) -> RegimeMap:
    """Solve the map of a prepared case; `advance` is called with the number of solved nodes."""
    axes, grid = require_map(case.scenario)
    choose_engine(case, (case.scenario,), 10 * grid.nodes)
    with WorkerPool(worker_count(workers)) as pool:
        plane: OrbitPlane | RatePlane
        if is_random(case.scenario):
            plane = RatePlane(case, axes, pool, advance)
        else:
            plane = OrbitPlane(case.scenario, axes, pool, advance)
        points = np.stack(np.meshgrid(*grid.shares), axis=-1).reshape(-1, 2)
        net = plane.net(points, grid.edges, counted=True)
        boundaries: list[Boundary] = []
        patches: list[Patch] = []
        for field in plane.fields:
            joined = join_crossings(grid, points, net.labels[field], net.crossings(field))
            boundaries += trace(axes, field, joined)
            patches += [
                Patch(field, label, to_values(axes, polygon), polygon_area(polygon))
                for label, polygon in joined.patches
            ]
        shape = grid.rows, grid.columns
        labels = {field: net.labels[field].reshape(shape) for field in plane.fields}
        place = find_place(plane, grid)
        return RegimeMap(
            case, axes, grid, labels, tuple(boundaries), tuple(patches), place, plane.cases
        )


def to_values(axes: Sequence[KeyRange], shares: Floats) -> Floats:
    """Return points of the map in SI; `shares` has shape (n, 2)."""
    return np.stack([axis.value(shares[:, i]) for i, axis in enumerate(axes)], axis=1)


def polygon_area(points: Floats) -> float:
    """Return the area of a polygon of shape (n, 2)."""
    x, y = points.T
    before = np.arange(len(points)) - 1
    return 0.5 * abs(float(np.dot(x, y[before]) - np.dot(y, x[before])))


class OrbitPlane:
    """Solves and labels points of the map.

    Attributes
    ----------
    fields : tuple of str
        The fields that apply to the scenario.
    cases : int
        Number of orbits solved so far.
    """

    def __init__(
        self, scenario: Scenario, axes: Sequence[KeyRange], pool: WorkerPool, advance: Advance
    ) -> None:
        self.scenario, self.axes, self.pool, self.advance = scenario, axes, pool, advance
        varied = getattr(scenario.active_friction, "normal_variation", None)
        # Only then do both halves of a period mirror each other, unless the motion does not.
        self.is_symmetric = isinstance(scenario.excitation, Harmonic) and varied is None
        limits = [] if scenario.stroke is None else [STROKE]
        several = [] if scenario.active_friction is None else [SEVERAL]
        self.fields = (REGIME, ISOLATION, *limits, *several)
        self.cases = 0

    def net(self, points: Floats, edges: Integers, counted: bool = False) -> OrbitNet:
        """Return labelled points of shape (n, 2), as shares of the axes, and their edges."""
        return OrbitNet(self, points, edges, counted)

    def scenes(self, points: Floats) -> Floats:
        """Return the scenes at points of shape (n, 2), given as shares of the axes."""
        columns = {axis.key: axis.value(points[:, i]) for i, axis in enumerate(self.axes)}
        return scene_array(self.scenario, columns, len(points))[0]

    def solve(self, scenes: Floats, counted: bool = False) -> Floats:
        """Return the answers of the orbit kernel; `counted` nodes count as progress."""
        length = min(max(len(scenes) // (2 * self.pool.workers), MIN_ORBITS), ORBITS_PER_CALL)
        blocks = [scenes[i : i + length] for i in range(0, max(len(scenes), 1), length)]
        answers = []
        for answer in self.pool.map_in_order(self.answers, blocks, (self,)):
            answers.append(answer)
            self.advance(len(answer) if counted else 0)
            self.cases += int(is_solved(answer).sum())
        return np.concatenate(answers)

    def answers(self, scenes: Floats) -> Floats:
        """Return the answers of the orbit kernel to a block of scenes."""
        from drysim.core.orbit import ANSWER_COLUMNS, RUN_UP_PEAK, STATUS
        from drysim.orbits.coulomb import solve_orbits

        small = self.is_too_small(scenes)
        answers = np.full((len(small), ANSWER_COLUMNS), np.nan)
        answers[~small] = solve_orbits(scenes[~small])
        answers[small, STATUS], answers[small, RUN_UP_PEAK] = Status.OK, 0.0
        return answers

    def follow(self, function: Callable[[Columns], Columns], columns: Columns) -> Columns:
        """Return the columns of a function of edges, which all workers follow.

        Parameters
        ----------
        function : callable
            Takes and returns columns of some edges; it returns the number of orbits solved on
            each edge as the last one.
        columns : tuple of ndarray
            Of all edges.
        """
        pieces = [
            tuple(column[i : i + EDGES_PER_PIECE] for column in columns)
            for i in range(0, max(len(columns[0]), 1), EDGES_PER_PIECE)
        ]
        followed = self.pool.map_in_order(function, pieces, (self,))
        *results, solved = (np.concatenate(parts) for parts in zip(*followed, strict=True))
        self.cases += int(solved.sum())
        return tuple(results)

    def bisect(self, field: str, columns: Columns) -> Columns:
        """Return the ends of the intervals in which the first label ends, and the next label.

        Parameters
        ----------
        field : str
        columns : tuple of ndarray
            Of each edge: its ends, shape (n, 2, 2); where on it to begin, as a share; labels
            there and at its second end.
        """
        ends, share, before, last = columns
        low, high, after = share.copy(), np.ones(len(ends)), last.copy()
        solved = np.zeros(len(ends), dtype=np.int64)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            scenes = self.scenes(on_edges(ends, middle))
            answers = self.answers(scenes)
            labels = self.labels(scenes, answers, field)
            nearest = np.where(before == LOCKED, last, before)
            labels = np.where(labels == UNRESOLVED, nearest, labels)
            same = labels == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
            after = np.where(same, after, labels)
            solved += is_solved(answers)
        return low, high, after, solved

    def end_of_second(self, columns: Columns) -> Columns:
        """Return where second motions end on edges, and the width of the last interval.

        Parameters
        ----------
        columns : tuple of ndarray
            Of each edge: its ends, shape (n, 2, 2); where there is a second motion, as a share;
            whether it is continued to the second end, or to the first; states of both motions
            there, shape (n, 4).
        """
        from drysim.study.other_motions import are_different

        ends, low, rises, states = columns
        states, high = states.copy(), np.where(rises, 1.0, 0.0)
        solved = np.zeros(len(ends), dtype=np.int64)
        for _ in range(HALVINGS_TO_FOLD):
            middle = 0.5 * (low + high)
            scenes = self.scenes(on_edges(ends, middle))
            first_answers = self.answers(scenes)
            solved += is_solved(first_answers)
            exists = np.zeros(len(ends), dtype=bool)
            for start in (states[:, 2:].copy(), states[:, :2].copy()):
                left = np.flatnonzero(~exists)
                reached = self.answers(with_start(scenes[left], start[left]))
                solved[left] += is_solved(reached)
                other = are_different(first_answers[left], reached)
                states[left[other], :2] = state_of(first_answers)[left[other]]
                states[left[other], 2:] = state_of(reached)[other]
                exists[left[other]] = True
            low, high = np.where(exists, middle, low), np.where(exists, high, middle)
        return 0.5 * (low + high), abs(high - low), solved

    def is_too_small(self, scenes: Floats) -> NDArray[np.bool_]:
        """Return where the motion from rest is known to be too small to have a regime."""
        from drysim.core.forcing import F_FK, F_FS, V_R, X_R, M
        from drysim.core.orbit import SINES

        peak = scenes[:, M] * scenes[:, SINES]
        excess, drop = peak - scenes[:, F_FS], scenes[:, F_FS] - scenes[:, F_FK]
        at_rest = (scenes[:, X_R] == 0.0) & (scenes[:, V_R] == 0.0)
        small = (excess > 0.0) & (np.maximum(excess, drop) < SMALLEST_EXCESS * peak)
        result: NDArray[np.bool_] = small & at_rest & self.is_symmetric
        return result

    def labels(self, scenes: Floats, answers: Floats, field: str) -> Integers:
        """Return the labels of solved scenes in a field other than `SEVERAL`."""
        from drysim.core import orbit as o

        columns = answers.T
        lost, still = columns[o.STATUS] != Status.OK, columns[o.SLIDING_DISTANCE] == 0.0
        size = SMALLEST_MOTION * scenes[:, o.SINES :: 3].sum(axis=1) * scenes[:, o.PERIOD] ** 2
        small = ~still & (columns[o.RUN_UP_PEAK] < size)
        with np.errstate(invalid="ignore"):
            if field == ISOLATION:
                change = columns[o.X_DD2] / columns[o.U_DD2] - 1.0
                label = np.where(still, LOCKED, change < 0.0)
                small |= ~still & (abs(change) < SMALLEST_CHANGE)
            elif field == STROKE:
                up, down = scenes[:, o.UP], scenes[:, o.DOWN]
                label = (columns[o.HIGHEST] >= up) | (columns[o.LOWEST] <= -down)
                small[:] = False
            else:
                stops = columns[o.STOPS]
                uneven = (columns[o.ASYMMETRY] > ASYMMETRY_TOLERANCE) & self.is_symmetric
                # A symmetric orbit has as many stops in each half; in a stop of no length,
                # rounding decides between them.
                stops = stops + (stops % 2.0) * (self.is_symmetric & ~uneven)
                label = np.where(uneven, UNSYMMETRIC, 0) + stops
                label = np.where(columns[o.MULTIPLE] > 1.0, PERIODS, label)
                label = np.where(still, LOCKED, label)
        label = np.where(lost, UNSETTLED, np.nan_to_num(label))
        return np.where(small, UNRESOLVED, label).astype(np.int64)


def with_start(scenes: Floats, start: Floats) -> Floats:
    """Return scenes with other starts, of shape (n, 2)."""
    from drysim.core.forcing import V_R, X_R

    moved = scenes.copy()
    moved[:, [X_R, V_R]] = start
    return moved


def is_solved(answers: Floats) -> NDArray[np.bool_]:
    """Return which answers are of the kernel: of motions that are not too small."""
    from drysim.core.orbit import MULTIPLE

    return np.isfinite(answers[:, MULTIPLE])


def state_of(answers: Floats) -> Floats:
    """Return x_r and v_r at the beginning of each orbit, shape (n, 2)."""
    from drysim.core.orbit import V_BEGIN, X_BEGIN

    return answers[:, [X_BEGIN, V_BEGIN]]


class OrbitNet:
    """Labelled nodes and the edges between them.

    Parameters
    ----------
    plane : OrbitPlane
    points : ndarray, shape (n, 2)
        Nodes, as shares of the axes.
    edges : ndarray, shape (m, 2)
        Numbers of the nodes at both ends.
    counted : bool, optional
        Whether the nodes count as progress.
    """

    def __init__(
        self, plane: OrbitPlane, points: Floats, edges: Integers, counted: bool = False
    ) -> None:
        self.plane, self.points, self.edges = plane, points, edges
        scenes = plane.scenes(points)
        answers = plane.solve(scenes, counted)
        self.labels: dict[str, Integers] = {
            field: self.filled(plane.labels(scenes, answers, field))
            for field in plane.fields
            if field != SEVERAL
        }
        if SEVERAL in plane.fields:
            self.several = np.zeros(len(points), dtype=bool)
            self.states = np.concatenate([state_of(answers)] * 2, axis=1)
            self.find_second_motions(scenes, answers, STARTED_NODES if counted else 1)
            self.labels[SEVERAL] = self.several.astype(np.int64)

    def filled(self, labels: Integers) -> Integers:
        """Return labels with those of lone unknown nodes taken from a neighbour.

        Such a node lies in a narrow strip, where the motion is small or settles slowly.
        """
        labels = np.where(labels == UNRESOLVED, UNSETTLED, labels)
        settles = labels != UNSETTLED
        if settles.all():
            return labels
        degree, settled = np.zeros(len(labels)), np.zeros(len(labels))
        result = labels.copy()
        for a, b in (self.edges.T, self.edges.T[::-1]):
            np.add.at(degree, a, 1.0)
            np.add.at(settled, a, settles[b])
        lone = ~settles & (2.0 * settled >= degree)
        for a, b in (self.edges.T, self.edges.T[::-1]):
            takes = lone[a] & settles[b]
            result[a[takes]] = labels[b[takes]]
        return result

    def find_second_motions(self, scenes: Floats, answers: Floats, stride: int) -> None:
        """Find the nodes where other starts lead to another motion than the scenario's.

        The starts are tried at every `stride`-th node; what they find spreads to the others.
        """
        from drysim.study.other_motions import can_have_other_motions, orbit_starts

        can_have = self.can_have = can_have_other_motions(scenes)
        possible = np.flatnonzero(can_have)[::stride]
        for start in orbit_starts(scenes[possible]):
            self.try_starts(possible, scenes, answers, start)
        for band in self.continued_past_changes:
            nodes = self.edges[band.edges, 1 if band.rises else 0]
            self.try_starts(nodes, scenes, answers, band.states[:, 2:])
        new = self.several.copy()
        while new.any():
            before = self.several.copy()
            a, b = np.concatenate([self.edges, self.edges[:, ::-1]]).T
            front = new[a] & ~self.several[b] & can_have[b]
            nodes, first = np.unique(b[front], return_index=True)
            states = self.states[a[front][first]]
            for start in (states[:, 2:], states[:, :2]):
                self.try_starts(nodes, scenes, answers, start)
            new = self.several & ~before

    def try_starts(
        self, nodes: Integers, scenes: Floats, answers: Floats, start: Floats
    ) -> None:
        """Note which nodes have a second motion that is reached from a start, and its state."""
        from drysim.study.other_motions import are_different

        left = ~self.several[nodes] & np.isfinite(start).all(axis=1)
        nodes = nodes[left]
        reached = self.plane.solve(with_start(scenes[nodes], start[left]))
        other = are_different(answers[nodes], reached)
        self.several[nodes[other]] = True
        self.states[nodes[other], 2:] = state_of(reached)[other]

    def ends(self, edges: Integers) -> Floats:
        """Return both ends of edges, shape (n, 2, 2)."""
        return self.points[self.edges[edges]]

    def crossings(self, field: str) -> Crossings:
        """Return the boundaries of a field on all edges whose ends differ."""
        if field == SEVERAL:
            return self.crossings_of_several()
        if field == REGIME:
            return self.changes_of_regime
        return self.changes_of(field)

    @cached_property
    def changes_of_regime(self) -> Crossings:
        """The boundaries between regimes."""
        return self.changes_of(REGIME)

    def changes_of(self, field: str) -> Crossings:
        """Return the boundaries of a field of which every point has a label of its own."""
        labels = self.labels[field]
        begin, end = labels[self.edges[:, 0]], labels[self.edges[:, 1]]
        pending = np.flatnonzero(begin != end)
        share, before, last = np.zeros(len(pending)), begin[pending], end[pending]
        by_edge: dict[int, list[Crossing]] = defaultdict(list)
        for _ in range(MAX_REGIONS_PER_EDGE):
            columns = self.ends(pending), share, before, last
            low, high, after = self.plane.follow(partial(self.plane.bisect, field), columns)
            for edge, place, label, following in rows_of(
                pending, 0.5 * (low + high), before, after
            ):
                by_edge[edge].append(Crossing(place, label, following, 0.0))
            left = after != last
            if not left.any():
                break
            pending, share, before, last = pending[left], high[left], after[left], last[left]
        return {edge: merge_unsettled(several) for edge, several in by_edge.items()}

    @cached_property
    def continued_past_changes(self) -> tuple[Continued, ...]:
        """Where the orbit of one side of a change of regime continues on the other side.

        There are two motions next to such a change: on its upper side, then on its lower.
        """
        from drysim.study.other_motions import are_different

        changes = [
            (edge, crossing.share, crossing.width)
            for edge, several in self.changes_of_regime.items()
            for crossing in several
            if self.can_have[self.edges[edge]].all()
        ]
        edges = np.array([edge for edge, _, _ in changes], dtype=np.int64)
        share = np.array([share for _, share, _ in changes])
        gap = np.array([0.5 * width + NEXT_TO_CHANGE for _, _, width in changes])
        sides = [np.clip(share + sign * gap, 0.0, 1.0) for sign in (-1.0, 1.0)]
        scenes = [self.plane.scenes(on_edges(self.ends(edges), side)) for side in sides]
        answers = [self.plane.solve(side) for side in scenes]
        continued = []
        for here, other in ((1, 0), (0, 1)):
            start = state_of(answers[other])
            left = np.flatnonzero(np.isfinite(start).all(axis=1))
            reached = self.plane.solve(with_start(scenes[here][left], start[left]))
            differs = are_different(answers[here][left], reached)
            which = left[differs]
            states = np.concatenate(
                [state_of(answers[here])[which], state_of(reached)[differs]], axis=1
            )
            continued.append(Continued(here == 1, edges[which], share[which], states))
        return tuple(continued)

    def crossings_of_several(self) -> Crossings:
        """Return where a second motion begins and ends, on all edges.

        It is continued along them, from their ends, and from changes of regime between ends
        without a second motion.
        """
        has = self.several[self.edges]
        edges = np.flatnonzero(has[:, 0] != has[:, 1])
        rises = has[edges, 0]
        states = self.states[np.where(rises, self.edges[edges, 0], self.edges[edges, 1])]
        columns = self.ends(edges), np.where(rises, 0.0, 1.0), rises, states
        share, width = self.plane.follow(self.plane.end_of_second, columns)
        crossings = {
            edge: [Crossing(place, int(up), 1 - up, size)]
            for edge, place, up, size in rows_of(edges, share, rises, width)
        }
        for edge, bands in self.narrow_bands(has[:, 0] | has[:, 1]).items():
            crossings[edge] = [
                Crossing(place, label, 1 - label, size)
                for band in bands
                for label, (place, size) in enumerate(band)
            ]
        return crossings

    def narrow_bands(self, has: NDArray[np.bool_]) -> dict[int, list[Band]]:
        """Return the bands of a second motion on edges neither end of which has one."""
        bands: dict[int, list[Band]] = defaultdict(list)
        for continued in self.continued_past_changes:
            left = ~has[continued.edges]
            edges, share = continued.edges[left], continued.share[left]
            rises = np.full(len(edges), continued.rises)
            columns = self.ends(edges), share, rises, continued.states[left]
            folds, widths = self.plane.follow(self.plane.end_of_second, columns)
            for edge, change, fold, width in rows_of(edges, share, folds, widths):
                low, high = sorted([(change, 0.0), (fold, width)])
                bands[edge].append((low, high))
        return {edge: joined_bands(several) for edge, several in bands.items()}


def rows_of(*columns: NDArray[Any]) -> Iterator[tuple[Any, ...]]:
    """Return columns as rows of numbers."""
    return zip(*(column.tolist() for column in columns), strict=True)


class Continued(NamedTuple):
    """Orbits continued past changes of regime, where two motions exist."""

    rises: bool
    """Whether towards the second end of the edges."""
    edges: Integers
    share: Floats
    """Where the regime changes, as a share of the edge."""
    states: Floats
    """States of both motions, shape (n, 4)."""


Band = tuple[tuple[float, float], tuple[float, float]]
"""Part of an edge: share of the edge and width of the strip at its beginning and its end."""


def joined_bands(bands: Sequence[Band]) -> list[Band]:
    """Return bands in order; those that touch or overlap are one."""
    joined: list[Band] = []
    for band in sorted(bands):
        if joined and band[0][0] <= joined[-1][1][0]:
            begin, end = joined.pop()
            joined.append((begin, max(end, band[1])))
        else:
            joined.append(band)
    return joined


def merge_unsettled(several: Sequence[Crossing]) -> list[Crossing]:
    """Replace an unsettled strip within an edge by one boundary in its middle."""
    merged: list[Crossing] = []
    for crossing in several:
        if merged and merged[-1].after == UNSETTLED and crossing.before == UNSETTLED:
            first = merged.pop()
            if first.before != crossing.after:
                middle = 0.5 * (first.share + crossing.share)
                width = crossing.share - first.share
                if first.before == LOCKED:  # what moves is not, however slowly it settles
                    middle, width = first.share, 0.0
                elif crossing.after == LOCKED:
                    middle, width = crossing.share, 0.0
                merged.append(Crossing(middle, first.before, crossing.after, width))
        else:
            merged.append(crossing)
    return merged


# Lines.


def trace(axes: Sequence[KeyRange], field: str, joined: Joined) -> Iterator[Boundary]:
    """Yield the lines of a field, without those of no meaning, as T_a = 1 of a locked mass."""
    for pair in sorted(joined.segments):
        if field == REGIME or min(pair) >= 0:
            for line in polylines(joined.segments[pair]):
                points = to_values(axes, np.array([joined.points[i] for i in line]))
                yield Boundary(field, pair, points, max(joined.widths[i] for i in line))


# The scenario itself.


def find_place(plane: OrbitPlane | RatePlane, grid: Grid) -> Place:
    """Return the labels of the scenario itself, and the nearest boundaries along the axes."""
    axes = plane.axes
    values = plane.scenario.values_of([axis.key for axis in axes])
    if len(values) < len(axes):
        return Place({}, {}, (), False)
    here = np.array([axis.share(values[axis.key]) for axis in axes])
    is_inside = bool(((here >= 0.0) & (here <= 1.0)).all())
    if not is_inside:
        net = plane.net(here[None, :], np.empty((0, 2), dtype=np.int64))
        labels = {name: int(column[0]) for name, column in net.labels.items()}
        return Place(values, labels, (), False, rates_of(net, 0))
    changes: list[Change] = []
    for i, (axis, nodes) in enumerate(zip(axes, grid.shares, strict=True)):
        shares = np.union1d(nodes, here[i])
        points = np.tile(here, (len(shares), 1))
        points[:, i] = shares
        edges = np.arange(len(shares) - 1)[:, None] + np.array([0, 1])
        net = plane.net(points, edges)
        node = int(np.searchsorted(shares, here[i]))
        labels = {name: int(column[node]) for name, column in net.labels.items()}
        met = sorted(
            (on_edges(points[edges[[edge]]], np.array([crossing.share]))[0, i], field, crossing)
            for field in plane.fields
            if field != RICE
            for edge, several in net.crossings(field).items()
            for crossing in several
            if field == REGIME or min(crossing.before, crossing.after) >= 0
        )
        below = [entry for entry in reversed(met) if entry[0] < here[i]]
        above = [entry for entry in met if entry[0] >= here[i]]
        for side, is_above in ((below, False), (above, True)):
            of_regime = [entry for entry in side if entry[1] == REGIME]
            for share, name, crossing in dict.fromkeys([*side[:1], *of_regime[:1]]):
                sentence = describe_change(
                    name, crossing.after if is_above else crossing.before
                )
                if isinstance(net, RateNet):
                    sentence = describe_level((crossing.before, crossing.after))
                distance = float(axis.value(share)) - values[axis.key]
                change = (distance, float(share - here[i]), name, sentence)
                changes.append(Change(axis.key, axis.unit, *change))
    return Place(values, labels, tuple(changes), True, rates_of(net, node))


def rates_of(net: OrbitNet | RateNet, node: int) -> Rates | None:
    """Return the rates of break-aways of a node under random base motion."""
    return net.rates_of_nodes[node] if isinstance(net, RateNet) else None
