"""Exact solution of scenes with end stops at |x_r| = x_rM, rigid or elastic.

The scene is first solved without its stops, which is faster. If |x_r| stays below x_rM, this
solution is exact for the scene with stops as well. Otherwise the scene is marched by modes:
apart from the stops, sliding or stuck against one, and impacts with a coefficient of
restitution. |x_r| is compared at the extreme points of the path, so that no contact is missed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from drysim.approach import coulomb, piecewise
from drysim.approach.scene import (
    base_acceleration_on_grid,
    count_grid_points,
    describe_numerics,
    grid_times,
)
from drysim.approach.solution import (
    EventDriven,
    Events,
    Floats,
    Numerics,
    Path,
    Points,
    Response,
    StoredGrid,
    Trajectory,
)
from drysim.core.events import CONTACT, RELEASE, REVERSAL, SLIP, STICK, decision_margin
from drysim.core.model import AnyState, EndStopLaw, Plant, Samples, Sines, State, Totals
from drysim.core.modes import ARRIVAL
from drysim.core.trajectory import peak_bumper_force

NOT_REACHED = "the end stops are never reached"

NON_TURNING_EVENTS = (CONTACT, -CONTACT, RELEASE, -RELEASE)
"""Kinds of event at which the velocity keeps its sign: x_r has no extremum there."""


def solve(
    plant: Plant,
    law: EndStopLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene and return its response on a grid; parameters as in `exact.solve`."""
    unstopped = coulomb.solve(plant, law.coulomb, motion, start, step, duration, whole)
    assert unstopped.trajectory is not None, "it always has a trajectory"
    if not reaches_stops(unstopped.trajectory, law.x_rM):
        compute_numerics = partial(unreached_numerics, unstopped)
        return replace(
            unstopped,
            law=law,
            compute_numerics=compute_numerics,
            trajectory=UnreachedStopsTrajectory(law, unstopped.trajectory),
        )
    trajectory = trajectory_with_stops(plant, law, motion, start, duration)
    dt = motion.dt if isinstance(motion, Samples) else step
    n = count_grid_points(trajectory.end, dt)
    x_r, v_r, F_stop, F_f, d = trajectory.at(grid_times(0, n, dt))
    grid = StoredGrid(
        dt, base_acceleration_on_grid(motion, 0, n, dt), Points(x_r, v_r, d, F_f, F_stop)
    )
    events, approach = trajectory.events, "stick-slip"
    if law.F_fs == 0.0:
        # As without stops, turning points are no events here; rest at a stop is one.
        kind, at_stop = np.abs(events.kind), np.abs(events.x_r) == law.x_rM
        stays = (kind >= CONTACT) | (at_stop & (kind <= SLIP))
        events, approach = events.select(stays), "viscous"
    compute_numerics = partial(
        describe_numerics,
        law,
        motion,
        n,
        events,
        trajectory.closest_decision,
        approach=approach,
    )
    return Response(plant, law, motion, grid, events, compute_numerics, trajectory)


def unreached_numerics(unstopped: Response) -> Numerics:
    """Return the `Numerics` of a response that never reaches the stops."""
    return replace(unstopped.numerics, why=f"{unstopped.numerics.why}; {NOT_REACHED}")


def compute_trajectory(
    plant: Plant,
    law: EndStopLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> EndStopTrajectory | UnreachedStopsTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    unstopped = coulomb.compute_trajectory(plant, law.coulomb, motion, start, duration)
    if not reaches_stops(unstopped, law.x_rM):
        return UnreachedStopsTrajectory(law, unstopped)
    return trajectory_with_stops(plant, law, motion, start, duration)


def reaches_stops(trajectory: Trajectory, x_rM: float) -> bool:
    """Whether |x_r| reaches x_rM [m], at an extreme point of the path or at its end."""
    far = float(np.abs(trajectory.path((0.0, trajectory.end), x_rM).x_r).max())
    return max(far, abs(trajectory.state(trajectory.end).x_r)) >= x_rM


def trajectory_with_stops(
    plant: Plant,
    law: EndStopLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> EndStopTrajectory:
    """Solve a scene that reaches its stops."""
    trajectory = piecewise.compute_trajectory_as(
        EndStopTrajectory, plant, law, motion, start, duration
    )
    kind, F_L, x_r = trajectory.events.kind, trajectory.events.F_L, trajectory.events.x_r
    decided = np.isin(kind, (STICK, REVERSAL, -REVERSAL))
    decided &= (np.abs(x_r) < law.x_rM) | (not law.rigid)
    closest_decision = min(
        (decision_margin(F, law.F_fs) for F in F_L[decided].tolist()), default=math.inf
    )
    return (
        replace(trajectory, closest_decision=closest_decision) if law.F_fs > 0.0 else trajectory
    )


class Impacts(NamedTuple):
    """Contacts with a stop: arrays of shape (n,).

    Attributes
    ----------
    t : ndarray
        Time [s].
    v_r : ndarray
        Velocity just before [m/s]; its sign is the side of the stop.
    """

    t: Floats
    v_r: Floats


@dataclass(frozen=True, eq=False)
class EndStopTrajectory(piecewise.PiecewiseTrajectory):
    """Solution with end stops, stored as segments."""

    law: EndStopLaw

    @cached_property
    def turning_points(self) -> Events:
        """The start, every zero of v_r and every impact: x_r is monotone between neighbours."""
        return self.events.select(~np.isin(self.events.kind, NON_TURNING_EVENTS))

    @property
    def series(self) -> tuple[Floats, ...]:
        """Values of each state component along the motion."""
        return self.turning_points.x_r, self.segments.v_r

    def state(self, t: float) -> State:
        """Return the state at time t [s]; at an impact, the state after it."""
        x_r, v_r, *_ = self.at(np.array([t]))
        return State(float(x_r[0]), float(v_r[0]))

    def hits(self) -> Impacts:
        """Return the contacts with a stop."""
        met = np.flatnonzero(self.segments.d == ARRIVAL)
        t = self.segments.n[met] * self.base[1] + self.segments.s[met]
        return Impacts(t, self.segments.v_r[met])

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return the largest force of a bumper in a window [N]."""
        kernel: Any = peak_bumper_force
        force: float = kernel(*self.scene, begin, end)
        return force

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s], impacts at its end included."""
        totals = super().totals(begin, end)
        if not self.law.rigid:
            return totals
        t, v_r = self.hits()
        struck = np.square(v_r[(t > begin) & (t <= end)]).sum()
        lost = 0.5 * self.plant.m * (1.0 - self.law.e**2) * struck
        return totals._replace(stop_work=float(lost))


@dataclass(frozen=True, eq=False)
class UnreachedStopsTrajectory(EventDriven):
    """Solution of a scene that never reaches its end stops; wraps that without stops."""

    law: EndStopLaw
    unstopped: Trajectory

    @property
    def plant(self) -> Plant:
        """Oscillator."""
        return self.unstopped.plant

    @property
    def closest_decision(self) -> float:
        """Smallest relative margin of a decision between stick and slip [-]."""
        return self.unstopped.closest_decision

    def path(self, window: tuple[float, float], x_rM: float | None) -> Path:
        """Return the extreme points of x_r from the start to the end of a window [s]."""
        return self.unstopped.path(window, x_rM)

    @property
    def end(self) -> float:
        """Final time [s]."""
        return self.unstopped.end

    def state(self, t: float) -> AnyState:
        """Return the state at time t [s]."""
        return self.unstopped.state(t)

    def totals(self, begin: float, end: float) -> Totals:
        """Return the integrals over a window [s]."""
        return self.unstopped.totals(begin, end)

    def hits(self) -> Impacts:
        """Return no contacts."""
        return Impacts(np.empty(0), np.empty(0))

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return 0 N."""
        return 0.0
