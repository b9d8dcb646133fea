"""Periodic orbit reached from a start, under any friction law.

Problem
    The state after a period of the excitation is a function of the state before it, the period
    map. A periodic orbit of n periods is a fixed point of its n-th iterate.

Method
    Coulomb friction under sines has an algorithm of its own, which is faster
    (`drysim.core.orbit`). All other motions are marched period by period until the state
    repeats. Where its changes decay like geometric series, reduced rank extrapolation moves the
    state close to the limit (Sidi, Vector Extrapolation Methods, SIAM 2017); it is
    accepted only if the next period of the true motion changes less. The orbit itself is always
    marched, never extrapolated.

Uniqueness
    Finite differences of the period map at the orbit estimate its Jacobian. Where its spectral
    radius is not below 1, neighbours are not attracted: the orbit is one of a continuum
    (Csernák, Stépán and Shaw 2007), or the motion still drifts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.approach import coulomb, exact, piecewise
from drysim.approach.solution import Orbit
from drysim.core.model import (
    AnyLaw,
    AnyState,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    PiecewiseLaw,
    Plant,
    Sines,
)
from drysim.core.orbit import (
    MAX_MULTIPLE,
    MAX_ORBIT_DISTANCE,
    REST_SPREAD,
    SLOW_DECAYS,
    USUAL_MULTIPLE,
    decay_count,
    fixed_point_offset,
    period_budget,
    spectral_radius,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drysim.approach.piecewise import PiecewiseTrajectory
    from drysim.approach.solution import Floats, Path
    from drysim.approach.taylor import TaylorTrajectory


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
    if law.stops is not None:
        return find_orbit_with_stops(plant, law, motion, start, period)
    if not isinstance(law, CoulombLaw):
        return find_orbit_by_marching(plant, law, motion, start, period)
    return coulomb.find_orbit(plant, law, motion, start, period)


STOP_SEARCH_PERIODS = 2_000
"""Periods of the transient that are searched for contact with a stop, where damping is weak."""

DECAY_TIMES = 40.0
"""Time constants after which the free response is below double precision."""


def find_orbit_with_stops(
    plant: Plant, law: PiecewiseLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Return the periodic orbit of a scene with end stops, which may not be reached at all."""
    assert law.stops is not None, "only called with end stops"
    inner = law.without_stops
    without_stops = find_orbit(plant, inner, motion, start, period)
    nearest = min(law.stops.limits)
    if without_stops.settled and without_stops.run_up_peak < nearest:
        decay = 0.5 * plant.b / plant.m * period
        periods = (
            STOP_SEARCH_PERIODS
            if decay * STOP_SEARCH_PERIODS < DECAY_TIMES
            else math.ceil(DECAY_TIMES / decay)
        )
        path = exact.compute_trajectory(plant, inner, motion, start, max(periods, 1) * period)
        if not exact.reaches_stops(path, law.stops):
            return without_stops
    return find_orbit_by_marching(plant, law, motion, start, period)


# Orbit of a motion that is marched period by period.


MAX_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

CLOSURE_TOLERANCE = 1e-12
"""Scaled change of the state over a repetition that counts as zero, for solutions in closed
form [-]."""

TOLERANCE_FACTOR = 10.0
"""The same for Taylor series, in units of their tolerance: two repetitions differ by a few."""

PERTURBATION = 1e-6
"""Relative perturbation of the state for finite differences of the period map [-]."""

MAX_CONTRACTION = 1.0 - 1e-4
"""Largest spectral radius of an attracting orbit [-]. A map closer to 1 would not have settled,
and finite differences are about this accurate."""

ReturnMap = Callable[[float, float], AnyState]


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
    Extrapolation is dropped in two cases. A contact that holds throughout a repetition keeps
    the position at which it last yielded; extrapolated changes do not determine it, so the
    motion is marched again until the contact holds, without extrapolation. Where extrapolation
    leads to no orbit, the motion is marched from the start as it is.
    """
    convergence = OrbitConvergence(closure_tolerance(law))
    orbit, events = march_to_orbit(plant, law, motion, start, period, convergence)
    if convergence.extrapolated and law.is_elastic and events == 0:
        convergence = OrbitConvergence(
            closure_tolerance(law), quiet_repetitions=CHANGES_PER_EXTRAPOLATION
        )
        orbit, _ = march_to_orbit(plant, law, motion, start, period, convergence)
    if convergence.extrapolated and not orbit.settled:
        convergence = OrbitConvergence(closure_tolerance(law), quiet_repetitions=math.inf)
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
        if convergence.add(end, sizes, len(trajectory.turning_points) - 1):
            periods, peak = periods + 1, max(peak, sizes[0])
            change, multiple = convergence.repetition()
            if change <= convergence.closed or periods >= most:
                break
        state = convergence.next_state()
    settled, run_up = change <= convergence.closed, periods * period
    left, multiple = change * convergence.gain, multiple if settled else 1

    # Finite differences need a smaller error than the tolerance of the law may allow.
    fine_law = law._replace(tolerance=CLOSURE_TOLERANCE) if isinstance(law, DynamicLaw) else law

    def return_map(dx: float, dv: float) -> AnyState:
        state, length = perturbed_state(law, end, dx, dv), multiple * period
        return march_period(plant, fine_law, motion, state, length).state(length)

    unique = True
    moves = float(np.ptp(path.x_r)) > REST_SPREAD * peak
    if settled and moves and decay_count(plant, multiple * period) < SLOW_DECAYS:
        unique, remaining = check_attraction(
            return_map, end, plant.k_x > 0.0, (convergence.scale[0], convergence.scale[1])
        )
        left = max(left, remaining)
        if not unique and remaining > MAX_ORBIT_DISTANCE:
            # Neutrally stable and still moving: a slow drift, not an orbit.
            settled, multiple, unique = False, 1, True
    orbit = Orbit(end, multiple, change, settled, unique, run_up, peak, left)
    return orbit, len(trajectory.turning_points) - 1


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
    trajectory: Any = exact.compute_trajectory(plant, law, motion, state, period)
    found: PiecewiseTrajectory | TaylorTrajectory = trajectory
    return found


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


def perturbed_state(
    law: PiecewiseLaw | DynamicLaw, state: AnyState, dx: float, dv: float
) -> AnyState:
    """Return a state displaced by dx [m] and dv [m/s].

    An elastic contact keeps its anchor; the deflection of a dynamic law moves along.
    """
    x_r, v_r = state.x_r + dx, state.v_r + dv
    if isinstance(law, DynamicLaw) and isinstance(state, ContactState):
        return ContactState(x_r, v_r, state.z + dx, state.reversals)
    return state._replace(x_r=x_r, v_r=v_r)


def closure_tolerance(law: PiecewiseLaw | DynamicLaw) -> float:
    """Return the scaled change over a repetition that counts as zero [-]."""
    if isinstance(law, DynamicLaw):
        return max(CLOSURE_TOLERANCE, TOLERANCE_FACTOR * law.tolerance)
    return CLOSURE_TOLERANCE


def check_attraction(
    return_map: ReturnMap, end: AnyState, has_spring: bool, scale: tuple[float, float]
) -> tuple[bool, float]:
    """Return whether an orbit attracts its neighbours, and its remaining distance.

    Parameters
    ----------
    return_map : callable
        Returns the state one repetition after the end, perturbed by dx_r [m] and dv_r [m/s].
    end : State or ContactState
        State at the end of a repetition.
    has_spring : bool
        Whether a spring acts on the mass; without one, all positions are equivalent and only
        speeds count.
    scale : tuple of float
        Largest |x_r| [m] and |v_r| [m/s] of the motion.

    Returns
    -------
    unique : bool
        Whether neighbours are attracted.
    distance : float
        Estimated distance from the fixed point, scaled [-]; the change over one repetition
        where neighbours are not attracted.
    """
    image, slopes = return_map(0.0, 0.0), []
    # Perturb inwards: a state beyond a rigid stop does not exist.
    for dx, dv in ((-math.copysign(PERTURBATION, end.x_r), 0.0), (0.0, PERTURBATION)):
        moved = return_map(dx * scale[0], dv * scale[1])
        off = (moved.x_r - image.x_r) / scale[0], (moved.v_r - image.v_r) / scale[1]
        slopes.append([each / (dx or dv) for each in off])
    (a, c), (b, e) = slopes
    gap = (image.x_r - end.x_r) / scale[0], (image.v_r - end.v_r) / scale[1]
    # Without a spring the position is a free integral of the velocity: only the derivative
    # of the velocity by the velocity decides.
    if not has_spring:
        a, b, gap = 0.0, 0.0, (0.0, gap[1])
    if not spectral_radius(a, b, c, e) < MAX_CONTRACTION:
        return False, max(map(abs, gap))
    return True, max(map(abs, fixed_point_offset(a, b, c, e, 1.0, *gap)))


# Convergence of a motion that is marched period by period.


CHANGES_PER_EXTRAPOLATION = 4
"""Changes used for one extrapolation: one more than the state has components."""

DECAY_THRESHOLD = 1e-2
"""Scaled change below which extrapolation may begin [-]."""

MAX_CHANGE_RATIO = 0.5
"""Largest ratio of the changes after and before an accepted extrapolation. A motion that grows
without bound changes equally wherever it starts, and less only relative to its own size."""

RANK_TOLERANCE = 1e-8
"""Relative size below which changes are rounding [-]."""

ROUNDING_ERROR = 1e-15
"""Relative rounding error of a change [-]. Extrapolation is rejected where it magnifies this
error to more than the last change."""


class OrbitConvergence:
    """States at the ends of the latest periods, their changes and their extrapolated limit.

    Changes that decay like geometric series are summed by reduced rank extrapolation (Sidi,
    Vector Extrapolation Methods, SIAM 2017). The motion is then marched on from the limit.
    `extrapolated` tells whether such a step was accepted; `gain` bounds the distance from the
    orbit relative to the last change.

    Parameters
    ----------
    closed : float
        Scaled change over a repetition that counts as zero [-].
    quiet_repetitions : float, optional
        Repetitions without events required before an extrapolation; infinite to disable it.
    """

    def __init__(self, closed: float, quiet_repetitions: float = 0.0) -> None:
        self.closed = closed
        self.quiet_repetitions, self.extrapolated = quiet_repetitions, False
        self.eventless_periods = 0
        self.period_ends: list[AnyState] = []
        self.scale: Sequence[float] = ()
        self.gain = 1.0
        self.previous: tuple[float, AnyState] | None = None
        self.pending_gain = 1.0

    def add(self, end: AnyState, largest: Sequence[float], events: int = 0) -> bool:
        """Add the state at the end of a period, and the scale of each component in it.

        Return whether the period counts. The period after an extrapolation shows whether the
        changes are smaller there, in the earlier scale. If not, it is discarded, and the motion
        goes on from the state before the extrapolation.
        """
        if self.previous is not None:
            (least, last), self.previous = self.previous, None
            if self.distance(end, self.period_ends[0]) > max(
                MAX_CHANGE_RATIO * least, self.closed
            ):
                self.period_ends = [last]
                return False
            self.gain, self.extrapolated = self.pending_gain, True
        self.eventless_periods = 0 if events else self.eventless_periods + 1
        previous = self.scale or (0.0,) * len(largest)
        self.scale = [max(new, 0.5 * old) for new, old in zip(largest, previous, strict=True)]
        self.period_ends = [end, *self.period_ends[:MAX_MULTIPLE]]
        return True

    def repetition(self) -> tuple[float, int]:
        """Return the scaled change over a repetition [-], and its length in periods.

        This is the shortest repetition within the tolerance; where there is none, the one up to
        `USUAL_MULTIPLE` with the smallest change. A longer one does not count while the change
        over a usual one is small: such a motion decays and does not repeat.
        """
        if len(self.period_ends) < 2:
            return math.inf, 1
        period_ends = self.scaled(self.period_ends)
        changes = np.abs(period_ends[1:] - period_ends[0]).max(axis=1)
        least = int(changes[:USUAL_MULTIPLE].argmin())
        closed = np.flatnonzero(changes <= self.closed)
        if closed.size and (closed[0] < USUAL_MULTIPLE or changes[least] > RANK_TOLERANCE):
            least = int(closed[0])
        return float(changes[least]), least + 1

    def distance(self, one: AnyState, other: AnyState) -> float:
        """Return the scaled distance of two states [-]."""
        period_ends = self.scaled((one, other))
        return float(np.abs(period_ends[0] - period_ends[1]).max())

    def scaled(self, states: Sequence[AnyState]) -> Floats:
        """Return the components of states in units of their scale [-], one row per state."""
        return np.array([state[:3] for state in states]) / [size or 1.0 for size in self.scale]

    def next_state(self) -> AnyState:
        """Return the state to march from: the last one, or its extrapolated limit."""
        change, periods = self.repetition()
        end = self.period_ends[0]
        period_ends = self.period_ends[: CHANGES_PER_EXTRAPOLATION * periods + 1 : periods]
        early = change > DECAY_THRESHOLD or len(period_ends) <= CHANGES_PER_EXTRAPOLATION
        early |= self.eventless_periods < self.quiet_repetitions * periods
        if early or getattr(end, "reversals", False):
            return end
        total = self.extrapolate(self.scaled(period_ends[::-1]))
        if total is not None:
            self.previous = change, end
            sizes = [size or 1.0 for size in self.scale]
            self.period_ends = [type(end)(*(total * sizes).tolist())]
        return self.period_ends[0]

    def extrapolate(self, period_ends: Floats) -> Floats | None:
        """Return the limit of a sequence of states; None where their changes do not decay.

        Parameters
        ----------
        period_ends : ndarray, shape (changes + 1, components)
            Scaled states in order of time.
        """
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
        if gain * ROUNDING_ERROR > sizes[-1]:
            return None
        self.pending_gain = gain
        return total
