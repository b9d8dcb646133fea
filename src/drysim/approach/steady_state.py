"""The periodic orbit that a start leads to, under any law.

Coulomb friction under sines has an algorithm of its own (`drysim.core.orbit`). Any other motion
is followed period by period until it closes on itself; changes that die away are summed up on
the way. Neighbours then tell whether the orbit is one, or one of a continuum.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.approach import coulomb, end_stops, exact
from drysim.approach.solution import Orbit
from drysim.core.model import (
    AnyLaw,
    AnyState,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    ElasticContactLaw,
    EndStopLaw,
    Plant,
    Sines,
)
from drysim.core.orbit import (
    MAX_ORBIT_DISTANCE,
    REST_SPREAD,
    SLOW_DECAYS,
    decay_count,
    fixed_point_offset,
    period_budget,
    spectral_radius,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drysim.approach.piecewise import PiecewiseLaw, PiecewiseTrajectory
    from drysim.approach.solution import Floats, Path
    from drysim.approach.taylor import TaylorTrajectory


def find_orbit(
    plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit with the core that fits the law."""
    if isinstance(law, EndStopLaw):
        return find_orbit_with_stops(plant, law, motion, start, period)
    if not isinstance(law, CoulombLaw):
        return find_orbit_by_marching(plant, law, motion, start, period)
    return coulomb.find_orbit(plant, law, motion, start, period)


STOP_SEARCH_PERIODS = 2_000
"""Periods on the way to an orbit that are looked at for a stop."""

DECAY_TIMES = 40.0
"""Decays after which what a start has left is below double precision."""


def find_orbit_with_stops(
    plant: Plant, law: EndStopLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit, between the stops or without reaching them."""
    bare = coulomb.find_orbit(plant, law.coulomb, motion, start, period)
    if bare.settled and bare.run_up_peak < law.x_rM:
        decay = 0.5 * plant.b / plant.m * period
        periods = (
            STOP_SEARCH_PERIODS
            if decay * STOP_SEARCH_PERIODS < DECAY_TIMES
            else math.ceil(DECAY_TIMES / decay)
        )
        path = coulomb.compute_trajectory(
            plant, law.coulomb, motion, start, max(periods, 1) * period
        )
        if not end_stops.reaches_stops(path, law.x_rM):
            return bare
    return find_orbit_by_marching(plant, law, motion, start, period)


# The orbit of a motion that is followed step by step.


MAX_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

CLOSURE_TOLERANCE = 1e-12
"""Scaled change of the state over a repetition that is none in closed form [-]."""

TOLERANCE_FACTOR = 10.0
"""Tolerances of a series that two repetitions may differ by."""

PERTURBATION = 1e-6
"""How far a neighbour is put from the orbit, relative to the motion."""

MAX_CONTRACTION = 1.0 - 1e-4
"""A map that shrinks distances less than this would not have settled; slopes by neighbours are
this sharp."""

ReturnMap = Callable[[float, float], AnyState]


def find_orbit_by_marching(
    plant: Plant,
    law: PiecewiseLaw | DynamicLaw,
    motion: Sines,
    start: AnyState,
    period: float,
) -> Orbit:
    """Follow a start, period by period, to its periodic orbit.

    Notes
    -----
    A contact that holds all through a repetition has kept where it yielded last. No sum of
    changes tells that, so the motion is then followed without any until it holds. So is one
    that sums led to no orbit: where nothing settles, the start itself says what is told.
    """
    convergence = OrbitConvergence(closure_tolerance(law))
    orbit, events = march_to_orbit(plant, law, motion, start, period, convergence)
    if convergence.extrapolated and isinstance(law, ElasticContactLaw) and events == 0:
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
    """Give the orbit that a start leads to, and how many events its last period has."""
    state, peak, periods = start, 0.0, 0
    most = period_budget(plant, period, MAX_PERIODS)
    while True:
        trajectory = march_period(plant, law, motion, state, period)
        path = trajectory.path((0.0, period), None)
        sizes, end = state_scales(trajectory, path, period), trajectory.state(period)
        if convergence.add(end, sizes, len(trajectory.turning_points) - 1):
            periods, peak = periods + 1, max(peak, sizes[0])
            change, multiple = convergence.repetition()
            if change <= convergence.closed or periods >= most:
                break
        state = convergence.next_state()
    settled, run_up = change <= convergence.closed, periods * period
    left, multiple = change * convergence.gain, multiple if settled else 1

    # By a series that is not sharp neighbours would not be told apart.
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
            # Nothing draws it anywhere, and it does move on: slowly beside its own size.
            settled, multiple, unique = False, 1, True
    orbit = Orbit(end, multiple, change, settled, unique, run_up, peak, left)
    return orbit, len(trajectory.turning_points) - 1


def march_period(
    plant: Plant, law: PiecewiseLaw | DynamicLaw, motion: Sines, state: AnyState, period: float
) -> PiecewiseTrajectory | TaylorTrajectory:
    """Follow a state for one period."""
    if isinstance(law, EndStopLaw):
        return end_stops.trajectory_with_stops(plant, law, motion, state, period)
    trajectory: Any = exact.compute_trajectory(plant, law, motion, state, period)
    found: PiecewiseTrajectory | TaylorTrajectory = trajectory
    return found


def state_scales(
    trajectory: PiecewiseTrajectory | TaylorTrajectory, path: Path, period: float
) -> list[float]:
    """Give the largest of each number of the state within a period.

    One without events is a single piece, at whose ends the mass may be at rest: its mean speed
    is a measure then.
    """
    sizes = [float(np.abs(column).max()) for column in trajectory.series]
    travelled = float(np.abs(np.diff(path.x_r)).sum())
    return [float(np.abs(path.x_r).max()), max(sizes[1], travelled / period), *sizes[2:]]


def perturbed_state(
    law: PiecewiseLaw | DynamicLaw, state: AnyState, dx: float, dv: float
) -> AnyState:
    """Give a state beside another; a contact stays in its place, and bristles bend."""
    x_r, v_r = state.x_r + dx, state.v_r + dv
    if isinstance(law, DynamicLaw) and isinstance(state, ContactState):
        return ContactState(x_r, v_r, state.z + dx, state.reversals)
    return state._replace(x_r=x_r, v_r=v_r)


def closure_tolerance(law: PiecewiseLaw | DynamicLaw) -> float:
    """Give the scaled change of the state over a repetition that counts as none [-]."""
    if isinstance(law, DynamicLaw):
        return max(CLOSURE_TOLERANCE, TOLERANCE_FACTOR * law.tolerance)
    return CLOSURE_TOLERANCE


def check_attraction(
    return_map: ReturnMap, end: AnyState, has_spring: bool, scale: tuple[float, float]
) -> tuple[bool, float]:
    """Tell whether neighbours in x_r and v_r come closer to an orbit, and how far off it is.

    Parameters
    ----------
    repeat : callable
        Gives the state a repetition after that at the end, moved by dx_r [m] and dv_r [m/s].
    end : State or Deflected
        Of the orbit.
    held : bool
        Whether a spring holds the mass; without one no place is like another, and speeds count.
    scale : tuple of float
        Largest |x_r| [m] and |v_r| [m/s] of the motion.

    Returns
    -------
    unique : bool
        Whether they do.
    left : float
        What the motion would go on changing by, summed up and scaled [-]; in a repetition,
        where they do not.
    """
    image, slopes = return_map(0.0, 0.0), []
    # Inwards, for beyond a rigid stop there is nothing.
    for dx, dv in ((-math.copysign(PERTURBATION, end.x_r), 0.0), (0.0, PERTURBATION)):
        moved = return_map(dx * scale[0], dv * scale[1])
        off = (moved.x_r - image.x_r) / scale[0], (moved.v_r - image.v_r) / scale[1]
        slopes.append([each / (dx or dv) for each in off])
    (a, c), (b, e) = slopes
    gap = (image.x_r - end.x_r) / scale[0], (image.v_r - end.v_r) / scale[1]
    if not has_spring:
        a, b, gap = 0.0, 0.0, (0.0, gap[1])
    if not spectral_radius(a, b, c, e) < MAX_CONTRACTION:
        return False, max(map(abs, gap))
    return True, max(map(abs, fixed_point_offset(a, b, c, e, 1.0, *gap)))


# How a motion that is followed period by period closes on itself.


MAX_MULTIPLE, USUAL_MULTIPLE = 64, 8
"""Longest repetition that is looked for, in periods of the excitation; and the longest by which
changes may be summed."""

CHANGES_PER_EXTRAPOLATION = 4
"""Changes that a sum is made of: one more than a state has numbers."""

DECAY_THRESHOLD = 1e-2
"""Change below which a motion is taken to die away [-]."""

MAX_CHANGE_RATIO = 0.5
"""Share of the change before to which a sum must bring it: a motion that grows for ever changes
as much wherever it is put, and less only beside its own size."""

RANK_TOLERANCE = 1e-8
"""Changes this much smaller than the others tell nothing [-]."""

ROUNDING_ERROR = 1e-15
"""Of a change [-]: where changes fall so slowly that it adds up to more than the change itself,
their sum is a guess."""


class OrbitConvergence:
    """The ends of the last periods, and where they lead to.

    Changes that die away like geometric series have a sum, to which the motion is moved on
    (reduced rank extrapolation; Sidi, Vector Extrapolation Methods, SIAM 2017). From there it
    is followed as before: an orbit is always followed, never extrapolated. `extrapolated` tells
    whether that was done and kept, and `gain` by how much the state may be farther from the
    orbit than its last change.

    Parameters
    ----------
    closed : float
        Scaled change over a repetition that counts as none [-].
    quiet : float, optional
        Repetitions without events that a sum asks for; infinite for no sums at all.
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
        """Add the state at the end of a period, and the largest of each number on the way.

        Gives whether it counts. The period after a sum shows whether that led to where the
        motion changes less, in the scale from before. If not, the period is forgotten: the
        motion goes on from where it was.
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
        """Give the scaled change over a repetition [-], and of how many periods that is.

        The shortest that is closed; where none is, the usual one that is closest to it. One
        that is longer is none where the motion hardly changes over a usual one: it dies away.
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
        """Give how far two states are apart, scaled [-]."""
        period_ends = self.scaled((one, other))
        return float(np.abs(period_ends[0] - period_ends[1]).max())

    def scaled(self, states: Sequence[AnyState]) -> Floats:
        """Return the numbers of states in units of their scale [-], a row each."""
        return np.array([state[:3] for state in states]) / [size or 1.0 for size in self.scale]

    def next_state(self) -> AnyState:
        """Give where to follow the motion from: its end, or where its changes add up to."""
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
        """Give where the changes between some ends add up to; None where they do not die away.

        Parameters
        ----------
        ends : ndarray, shape (changes + 1, numbers)
        """
        changes = np.diff(period_ends, axis=0)
        sizes = np.abs(changes).max(axis=1)
        if not sizes[-1] < sizes[0]:
            return None
        last = changes[-1]
        shares = np.linalg.lstsq((changes[:-1] - last).T, -last, rcond=RANK_TOLERANCE)[0]
        total: Floats = period_ends[-1] + shares @ (period_ends[1:-1] - period_ends[-1])
        gain = max(1.0, float(np.abs(total - period_ends[-1]).max() / sizes[-1]))
        if gain * ROUNDING_ERROR > sizes[-1]:
            return None
        self.pending_gain = gain
        return total
