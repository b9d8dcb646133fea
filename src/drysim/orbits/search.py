"""Periodic orbit reached from a start, under any friction law.

Problem
    The state after a period of the excitation is a function of the state before it, the period
    map. A periodic orbit of n periods is a fixed point of its n-th iterate.

Method
    Coulomb friction under sines has an algorithm of its own, which is faster
    (`drysim.core.orbit`). All other motions are marched period by period until the state
    repeats. Close to the limit the state is moved there:

    - by a Newton step on the map of a repetition, where the law is in closed form and the
      latest two repetitions have the same events: (I - M)⁻¹ times the change, with the
      monodromy matrix M (`drysim.core.variational`);
    - else by reduced rank extrapolation of the latest states (Sidi, Vector Extrapolation
      Methods, SIAM 2017).

    The step is accepted only if the next repetition of the true motion changes less. The orbit
    itself is always marched.

Period
    A motion that swings about its orbit, with a multiplier near -1 or a complex pair, is nearer
    to itself two or more periods earlier than one period earlier. Such a repetition counts only
    where its change is far smaller than that over each divisor of it (`shortest_repetition`).

Distance and uniqueness
    The distance to the orbit is (I - M)⁻¹ times the change over a repetition: beside a
    multiplier near 1 it is far larger than that change. Where the spectral radius of M is not
    below 1, neighbours are not attracted: the orbit is one of a continuum (Csernák, Stépán and
    Shaw 2007), or the motion still drifts. Finite differences estimate M for a dynamic law. A
    contact with hysteresis remembers more than its state has components; its distance follows
    from the rate at which the changes decay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drysim.approach import exact, piecewise
from drysim.approach.coulomb import sine_trajectory
from drysim.approach.solution import Orbit, keeps_anchor
from drysim.core.events import IMPACT, REVERSAL, SLIP, STICK
from drysim.core.model import (
    ATTRACTING_MODULUS,
    AnyLaw,
    AnyState,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
)
from drysim.core.orbit import (
    DIVISOR_RATIO,
    EXPLAINED_CHANGE,
    MAX_MULTIPLE,
    MAX_ORBIT_DISTANCE,
    REST_SPREAD,
    ROUNDING_PER_REPETITION,
    SLOW_DECAYS,
    USUAL_MULTIPLE,
    decay_count,
    period_budget,
)
from drysim.orbits.coulomb import find_coulomb_orbit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drysim.approach.piecewise import PiecewiseTrajectory
    from drysim.approach.solution import Path, Trajectory
    from drysim.approach.taylor import TaylorTrajectory
    from drysim.core.model import Floats


def find_orbit(
    plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Return the periodic orbit reached from a start, by the method that fits the law.

    Parameters
    ----------
    plant, law, motion, start
        The scene; the base motion is periodic.
    period : float
        Period of the excitation [s].

    Returns
    -------
    Orbit
        With `settled` false where the motion does not converge.

    Raises
    ------
    SolverError
        If events do not advance in time, or the motion is not finite.
    """
    if isinstance(law, CoulombLaw):
        return find_coulomb_orbit(plant, law, motion, start, period)
    if law.stops is not None and isinstance(law.without_stops, CoulombLaw):
        # Thirty times faster than to march, where it is the orbit.
        orbit = find_coulomb_orbit(plant, law.without_stops, motion, start, period)
        if stays_between_stops(plant, law, motion, start, period, orbit):
            return orbit
    return find_orbit_by_marching(plant, law, motion, start, period)


STOP_SEARCH_PERIODS = 2_000
"""Periods of the transient that are searched for contact with a stop, where damping is weak: as
many as a motion with stops has to settle (`MAX_PERIODS`)."""

DECAY_TIMES = 40.0
"""Time constants after which the free response is below double precision: e⁻⁴⁰ is 4e-18."""


def stays_between_stops(
    plant: Plant, law: PiecewiseLaw, motion: Sines, start: AnyState, period: float, orbit: Orbit
) -> bool:
    """Return whether a motion with Coulomb friction leads to its orbit without its end stops.

    `orbit` is that without them.
    """
    assert law.stops is not None, "only called with end stops"
    if not orbit.settled or orbit.run_up_peak >= min(law.stops.limits):
        return False
    decay = 0.5 * plant.b / plant.m * period
    periods = STOP_SEARCH_PERIODS
    if decay * periods >= DECAY_TIMES:
        periods = math.ceil(DECAY_TIMES / decay)
    return not sine_trajectory(plant, law, motion, start, periods * period).reaches_stops


# Orbit of a motion that is marched period by period.


MAX_PERIODS = 2_000
"""Periods after which a motion counts as not settled: a period is marched and differentiated in
about a millisecond, all of them in two seconds."""

CLOSURE_TOLERANCE = 1e-12
"""Scaled change of the state over a repetition that counts as zero, for solutions in closed
form [-]: ten times that of Coulomb friction, as a mode is entered many times a period."""

CONTACT_EVENTS = (STICK, SLIP, REVERSAL, IMPACT)
"""Kinds of event after which an elastic contact may carry no force at another x_r."""

TOLERANCE_FACTOR = 10.0
"""The same for Taylor series, in units of their tolerance: two repetitions differ by a few."""

PERTURBATION = 1e-6
"""Relative perturbation of the state for finite differences of the period map [-]. The error of
the march, 1e-12, and the curvature of the map then add errors of 1e-6 each."""

MULTIPLIER_ERROR = 1e-4
"""Error of a multiplier from finite differences, or from the rate of decay [-]: a hundred times
that of a smooth map, as the curvature is large where an event is about to vanish."""


def find_orbit_by_marching(
    plant: Plant,
    law: PiecewiseLaw | DynamicLaw,
    motion: Sines,
    start: AnyState,
    period: float,
) -> Orbit:
    """March a start period by period to its periodic orbit.

    Notes
    -----
    A contact that holds throughout a repetition keeps the position at which it last yielded,
    which no step determines; so the motion is marched again until the contact holds, without
    steps.
    """
    convergence = OrbitConvergence(closure_tolerance(law))
    orbit, events = march_to_orbit(plant, law, motion, start, period, convergence)
    if convergence.moved and law.is_elastic and events == 0:
        convergence = OrbitConvergence(
            closure_tolerance(law), quiet_repetitions=CHANGES_PER_EXTRAPOLATION
        )
        orbit, _ = march_to_orbit(plant, law, motion, start, period, convergence)
    return orbit


def march_to_orbit(
    plant: Plant,
    law: PiecewiseLaw | DynamicLaw,
    motion: Sines,
    start: AnyState,
    period: float,
    convergence: OrbitConvergence,
) -> tuple[Orbit, int]:
    """Return the orbit reached from a start, and the number of events in its last period."""
    state, peak, periods = start, 0.0, 0
    most = period_budget(plant, period, MAX_PERIODS)
    while True:
        trajectory = march_period(plant, law, motion, state, period)
        path = trajectory.path
        sizes, end = state_scales(trajectory, path, period), trajectory.state(period)
        events = int(np.isin(np.abs(trajectory.events.kind[1:]), CONTACT_EVENTS).sum())
        closed_form = None if isinstance(law, DynamicLaw) else trajectory
        if convergence.add(end, sizes, events, closed_form):
            periods, peak = periods + 1, max(peak, sizes[0])
            change, multiple = convergence.repetition()
            if change <= convergence.closed or periods >= most:
                break
        state = convergence.next_state()
    settled, run_up = change <= convergence.closed, periods * period
    unique, left = True, change * convergence.gain
    if settled and float(np.ptp(path.x_r)) > REST_SPREAD * peak:
        multiple, change, unique, left = examine_orbit(plant, law, motion, period, convergence)
        if not unique and change > MAX_ORBIT_DISTANCE:
            # Neutrally stable and still moving: a slow drift, not an orbit.
            settled, unique = False, True
    if not settled:
        multiple = 1
    return Orbit(end, multiple, change, settled, unique, run_up, peak, left), events


def examine_orbit(
    plant: Plant,
    law: PiecewiseLaw | DynamicLaw,
    motion: Sines,
    period: float,
    convergence: OrbitConvergence,
) -> tuple[int, float, bool, float]:
    """Return the period of a motion that repeats, and its distance to the orbit.

    Returns
    -------
    periods : int
        Excitation periods per repetition: those found by `convergence`, or a divisor of them
        over which the motion changes no more than its distance to the orbit explains.
    change : float
        Scaled change over a repetition [-].
    unique : bool
        Whether neighbours are attracted; tested where the motion decays slowly.
    distance : float
        Scaled distance to the orbit [-]; infinite where neighbours are not attracted, NaN if
        unknown.
    """
    change, periods = convergence.repetition()
    length = periods * period
    if getattr(convergence.period_ends[0], "reversals", False):
        distance = convergence.observed_distance(periods, law)
    elif isinstance(law, DynamicLaw):
        # Finite differences need a smaller error than the tolerance of the law may allow.
        fine = law._replace(tolerance=CLOSURE_TOLERANCE)

        def flow(state: AnyState) -> AnyState:
            return march_period(plant, fine, motion, state, length).state(length)

        end, begin = convergence.period_ends[0], convergence.period_ends[periods]
        image = end if fine == law else flow(begin)
        parts = [
            i
            for i, size in enumerate(convergence.scale)
            # Without a spring all positions are equivalent.
            if size > 0.0 and (plant.k_x > 0.0 or i != 0)
        ]
        sizes = np.array(convergence.scale)[parts]
        M = scaled_jacobian(flow, begin, image, parts, sizes)
        gap = (np.array(end[:3]) - np.array(begin[:3]))[parts] / sizes
        distance = fixed_point_distance(M, gap, error_per_repetition(law), MULTIPLIER_ERROR)
    else:
        M, gap, _ = convergence.linearised(periods)
        distance = fixed_point_distance(M, gap, error_per_repetition(law))
    if math.isinf(distance):
        return periods, change, decay_count(plant, length) >= SLOW_DECAYS, distance
    for fewer, less in enumerate(convergence.changes()[: periods - 1].tolist(), start=1):
        if periods % fewer == 0 and less <= EXPLAINED_CHANGE * distance:
            return fewer, less, True, distance
    return periods, change, True, distance


def fixed_point_distance(
    M: Floats, gap: Floats, error: float, multiplier_error: float = 0.0
) -> float:
    """Return the scaled distance of a state to the fixed point of a map [-].

    Parameters
    ----------
    M : ndarray, shape (n, n)
        Jacobian of the map.
    gap : ndarray, shape (n,)
        Image minus state.
    error : float
        Error of the image.
    multiplier_error : float, optional
        Error of the multipliers.

    Returns
    -------
    float
        Infinite if the map is no contraction.
    """
    if not attracts(M, multiplier_error):
        return math.inf
    inverse = np.linalg.inv(np.eye(len(M)) - M)
    largest = float(np.abs(inverse).sum(axis=1).max(initial=0.0))
    return float(np.abs(inverse @ gap).max(initial=0.0)) + error * largest


def attracts(M: Floats, multiplier_error: float = 0.0) -> bool:
    """Return whether all multipliers of a matrix are below 1, with their error."""
    if not np.isfinite(M).all():
        return False
    radius = np.abs(np.linalg.eigvals(M)).max(initial=0.0)
    return bool(radius < ATTRACTING_MODULUS - multiplier_error)


def error_per_repetition(law: PiecewiseLaw | DynamicLaw) -> float:
    """Return the relative error of the motion over a repetition [-]."""
    return law.tolerance if isinstance(law, DynamicLaw) else ROUNDING_PER_REPETITION


def scaled_jacobian(
    flow: Callable[[AnyState], AnyState],
    state: AnyState,
    image: AnyState,
    parts: list[int],
    sizes: Floats,
) -> Floats:
    """Return the scaled Jacobian of a flow at a state, by finite differences.

    Parameters
    ----------
    flow : callable
        Returns the state some time after a state.
    state, image : State or ContactState
        State and its image.
    parts : list of int
        Components of the state that count.
    sizes : ndarray, shape (parts,)
        Their scales.
    """
    columns = []
    for part, size in zip(parts, sizes.tolist(), strict=True):
        moved, step = perturbed_state(state, part, PERTURBATION * size)
        off = np.array(flow(moved)[:3]) - np.array(image[:3])
        columns.append(off[parts] / sizes * (size / step))
    return np.array(columns).T


def march_period(
    plant: Plant,
    law: AnyLaw,
    motion: Sines,
    state: AnyState,
    period: float,
) -> PiecewiseTrajectory | TaylorTrajectory:
    """Return the trajectory of one period from a state."""
    if law.stops is not None:
        return piecewise.compute_trajectory(plant, law, motion, state, period)
    solved: Any = exact.compute_trajectory(plant, law, motion, state, period)
    trajectory: PiecewiseTrajectory | TaylorTrajectory = solved
    return trajectory


def state_scales(
    trajectory: PiecewiseTrajectory | TaylorTrajectory, path: Path, period: float
) -> list[float]:
    """Return the largest value of each state component within a period.

    Without events a period is one segment, and the mass may be at rest at both ends; the mean
    speed then replaces the largest one.
    """
    sizes = [float(np.abs(column).max()) for column in trajectory.series]
    travelled = float(np.abs(np.diff(path.x_r)).sum())
    return [float(np.abs(path.x_r).max()), max(sizes[1], travelled / period), *sizes[2:]]


def perturbed_state(state: AnyState, part: int, size: float) -> tuple[AnyState, float]:
    """Return a state under a dynamic law with one component displaced, and by how much [m].

    Displacements and deflections decrease; the deflection moves along with the displacement.
    """
    values = list(state[:3])
    step = size if part == 1 else -math.copysign(size, values[part])
    values[part] += step
    if part == 0 and len(values) > 2:
        values[2] += step
    x_r, v_r, *deflection = values
    if isinstance(state, ContactState):
        return ContactState(x_r, v_r, deflection[0], state.reversals), step
    return State(x_r, v_r), step


def closure_tolerance(law: PiecewiseLaw | DynamicLaw) -> float:
    """Return the scaled change over a repetition that counts as zero [-]."""
    if isinstance(law, DynamicLaw):
        return max(CLOSURE_TOLERANCE, TOLERANCE_FACTOR * law.tolerance)
    return CLOSURE_TOLERANCE


# Convergence of a motion that is marched period by period.


CHANGES_PER_EXTRAPOLATION = 4
"""Changes used for one extrapolation: one more than the state has components."""

STEP_THRESHOLD = 1e-2
"""Scaled change below which a step towards the limit may begin [-]: as `NEWTON_RADIUS`."""

MAX_CHANGE_RATIO = 0.5
"""Largest ratio of the changes after and before an accepted step. A motion that grows without
bound changes equally wherever it starts, and less only relative to its own size."""

RANK_TOLERANCE = 1e-8
"""Relative size below which changes are rounding [-]: the root of the rounding of the states,
as the normal equations of the mean square their ratio."""

ROUNDING_ERROR = 1e-15
"""Relative rounding error of a change [-]. Extrapolation is rejected where it magnifies this
error to more than the last change."""


def shortest_repetition(changes: Floats, closed: float) -> int:
    """Return the least number of periods after which a motion repeats, or may repeat; else 0.

    Parameters
    ----------
    changes : ndarray, shape (n,)
        Scaled changes of the state since 1, 2, ..., n periods earlier [-].
    closed : float
        Change that counts as zero [-].

    Notes
    -----
    Where the change over a divisor of the repetition is not far larger, that divisor is
    returned, although its change is not yet zero: the motion may still be on its way there.
    """
    for periods in (np.flatnonzero(changes <= closed)[:1] + 1).tolist():
        for fewer in range(1, periods // 2 + 1):
            distinct = changes[periods - 1] <= DIVISOR_RATIO * changes[fewer - 1]
            if periods % fewer == 0 and not distinct:
                return fewer
        return int(periods)
    return 0


OBSERVED_CHANGES = 9
"""Changes over a repetition whose mean ratio is the rate of their decay: enough for the turns
of a complex multiplier to average out."""


class Step(NamedTuple):
    """A step towards the limit, which the next repetition of the motion confirms or refutes.

    Attributes
    ----------
    change : float
        Scaled change over the repetition before it [-].
    state : State or ContactState
        State before it.
    periods : int
        Periods of the repetition.
    scale : sequence of float
        Scale of the states before it.
    gain : float
        Bound on the distance from the orbit relative to the last change [-].
    """

    change: float
    state: AnyState
    periods: int
    scale: Sequence[float]
    gain: float


class OrbitConvergence:
    """States at the ends of the latest periods, their changes and their limit.

    Near the limit the state steps towards it: by Newton's method where the trajectories of the
    periods are given, else by the sum of their changes as geometric series. The motion is then
    marched on from there. `moved` tells whether such a step was accepted; `gain` bounds the
    distance from the orbit relative to the last change; `patience` is the number of repetitions
    before the next Newton step, and doubles with each one that is refuted.

    Parameters
    ----------
    closed : float
        Scaled change over a repetition that counts as zero [-].
    quiet_repetitions : int, optional
        Repetitions without events required before a step.
    """

    def __init__(self, closed: float, quiet_repetitions: int = 0) -> None:
        self.closed = closed
        self.quiet_repetitions, self.moved = quiet_repetitions, False
        self.eventless_periods = 0
        self.period_ends: list[AnyState] = []
        self.trajectories: list[Trajectory] = []
        self.scale: Sequence[float] = ()
        self.gain, self.patience = 1.0, 1
        self.step: Step | None = None

    def add(
        self,
        end: AnyState,
        largest: Sequence[float],
        events: int = 0,
        trajectory: Trajectory | None = None,
    ) -> bool:
        """Add the state at the end of a period, and the scale of each component in it.

        Return whether the period counts. The repetition after a step shows whether the changes
        are smaller there, in the earlier scale. If not, it is discarded, and the motion goes on
        from the state before the step.
        """
        if self.step is not None and len(self.period_ends) == self.step.periods:
            (least, last, _, scale, gain), self.step = self.step, None
            if distance_between(end, self.period_ends[-1], scale) > max(
                MAX_CHANGE_RATIO * least, self.closed
            ):
                self.period_ends, self.trajectories = [last], []
                self.patience *= 2
                return False
            self.gain, self.moved = gain, True
        self.eventless_periods = 0 if events else self.eventless_periods + 1
        previous = self.scale or (0.0,) * len(largest)
        self.scale = [max(new, 0.5 * old) for new, old in zip(largest, previous, strict=True)]
        self.period_ends = [end, *self.period_ends[:MAX_MULTIPLE]]
        if trajectory is not None:
            self.trajectories = [trajectory, *self.trajectories[: 2 * MAX_MULTIPLE - 1]]
        return True

    def repetition(self) -> tuple[float, int]:
        """Return the scaled change over a repetition [-], and its length in periods.

        This is the `shortest_repetition` within the tolerance; where there is none, the one up
        to `USUAL_MULTIPLE` with the smallest change. A longer one does not count while the
        change over a usual one is small: such a motion decays and does not repeat.
        """
        if len(self.period_ends) < 2:
            return math.inf, 1
        changes = self.changes()
        least = int(changes[:USUAL_MULTIPLE].argmin()) + 1
        closed = shortest_repetition(changes, self.closed)
        if closed and (closed <= USUAL_MULTIPLE or changes[least - 1] > RANK_TOLERANCE):
            least = closed
        return float(changes[least - 1]), least

    def changes(self) -> Floats:
        """Return the scaled changes since 1, 2, ... periods earlier [-]."""
        period_ends = self.scaled(self.period_ends)
        changes: Floats = np.abs(period_ends[1:] - period_ends[0]).max(axis=1)
        return changes

    def observed_distance(self, periods: int, law: PiecewiseLaw | DynamicLaw) -> float:
        """Return the distance to an orbit of so many periods from the decay of the changes [-].

        It is infinite where they do not decay, and NaN where only one is known.
        """
        states = self.scaled(self.period_ends[::periods][: OBSERVED_CHANGES + 1])
        changes = np.abs(np.diff(states, axis=0)).max(axis=1)
        if len(changes) < 2:
            return math.nan
        ratio = (changes[0] / changes[-1]) ** (1.0 / (len(changes) - 1)) if changes[0] else 0.0
        if not ratio < ATTRACTING_MODULUS - MULTIPLIER_ERROR:
            return math.inf
        return float(changes[0] + error_per_repetition(law)) / (1.0 - float(ratio))

    def scaled(self, states: Sequence[AnyState]) -> Floats:
        """Return the components of states in units of their scale [-], one row per state."""
        return in_units(states, self.scale)

    def next_state(self) -> AnyState:
        """Return the state to march from: the last one, or a step from it to the limit."""
        change, periods = self.repetition()
        end = self.period_ends[0]
        early = change > STEP_THRESHOLD or self.step is not None
        early |= self.eventless_periods < self.quiet_repetitions * periods
        if early or getattr(end, "reversals", False):
            return end
        estimate = self.newton(periods) if self.trajectories else self.extrapolate(periods)
        if estimate is not None:
            total, gain = estimate
            sizes = [size or 1.0 for size in self.scale]
            self.step = Step(change, end, periods, self.scale, gain)
            self.period_ends = [type(end)(*(total * sizes).tolist())]
        return self.period_ends[0]

    def linearised(self, periods: int) -> tuple[Floats, Floats, list[int]]:
        """Return the linear map of the latest repetition about its beginning.

        Returns
        -------
        M : ndarray, shape (n, n)
            Scaled monodromy matrix.
        change : ndarray, shape (n,)
            Scaled change of the state.
        parts : list of int
            The components of the state. Left out are those in which all states are equivalent:
            the position without a spring, and the anchor of an elastic contact that does not
            yield.
        """
        M = reduce(np.matmul, (motion.monodromy() for motion in self.trajectories[:periods]))
        free = self.trajectories[0].plant.k_x == 0.0, False, keeps_anchor(M)
        parts = [i for i in range(len(M)) if not free[i] and self.scale[i] > 0.0]
        sizes = np.array(self.scale)[parts]
        end, begin = self.scaled((self.period_ends[0], self.period_ends[periods]))
        return M[np.ix_(parts, parts)] * sizes / sizes[:, None], (end - begin)[parts], parts

    def newton(self, periods: int) -> tuple[Floats, float] | None:
        """Return the scaled state after a Newton step on the map of a repetition, and its gain.

        None unless the latest two repetitions have the same events and the map attracts. A step
        neither turns the motion back nor passes a rigid stop.
        """
        kinds = [motion.events.kind.tolist() for motion in self.trajectories[: 2 * periods]]
        if len(self.period_ends) <= self.patience * periods or len(kinds) < 2 * periods:
            return None
        if kinds[:periods] != kinds[periods:]:
            return None
        M, change, parts = self.linearised(periods)
        if not attracts(M):
            return None
        # The orbit is (I - M)⁻¹ change from the beginning of the repetition.
        left = np.linalg.solve(np.eye(len(M)) - M, M @ change)
        end = self.scaled(self.period_ends[:1])[0]
        total = end.copy()
        total[parts] += left
        stops, x_r = self.trajectories[0].law.stops, total[0] * self.scale[0]
        moves = stops is not None and stops.rigid and total[0] != end[0]
        if total[1] * end[1] < 0.0 or (moves and stops and stops.limits.side(x_r)):
            return None
        gain = float(np.abs(left).max(initial=0.0) / np.abs(change).max(initial=0.0))
        return total, max(1.0, gain)

    def extrapolate(self, periods: int) -> tuple[Floats, float] | None:
        """Return the scaled limit of the latest states by their changes, and its gain.

        None where the changes do not decay.
        """
        latest = self.period_ends[: CHANGES_PER_EXTRAPOLATION * periods + 1 : periods]
        if len(latest) <= CHANGES_PER_EXTRAPOLATION:
            return None
        period_ends = self.scaled(latest[::-1])
        changes = np.diff(period_ends, axis=0)
        sizes = np.abs(changes).max(axis=1)
        if not sizes[-1] < sizes[0]:
            return None
        # Reduced rank extrapolation: the limit is a mean of the states whose weights sum to one
        # and make the same mean of the changes as small as possible (least squares). Taking the
        # last change out of the others eliminates the constraint.
        last = changes[-1]
        shares = np.linalg.lstsq((changes[:-1] - last).T, -last, rcond=RANK_TOLERANCE)[0]
        total: Floats = period_ends[-1] + shares @ (period_ends[1:-1] - period_ends[-1])
        gain = max(1.0, float(np.abs(total - period_ends[-1]).max() / sizes[-1]))
        return None if gain * ROUNDING_ERROR > sizes[-1] else (total, gain)


def distance_between(state: AnyState, other: AnyState, scale: Sequence[float]) -> float:
    """Return the distance of two states in units of a scale [-]."""
    states = in_units((state, other), scale)
    return float(np.abs(states[0] - states[1]).max())


def in_units(states: Sequence[AnyState], scale: Sequence[float]) -> Floats:
    """Return the components of states in units of their scale [-], one row per state."""
    return np.array([state[:3] for state in states]) / [size or 1.0 for size in scale]
