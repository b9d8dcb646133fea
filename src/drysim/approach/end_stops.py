"""Exact solution of scenes with end stops at |x_r| = x_rM, rigid or elastic.

The scene is first solved without its stops, which is faster. If |x_r| stays below x_rM, this
solution is exact for the scene with stops as well. Otherwise the scene is marched by modes:
apart from the stops, sliding or stuck against one, and impacts with a coefficient of
restitution. |x_r| is compared at the extreme points of the path, so that no contact is missed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from drysim.approach import coulomb, piecewise
from drysim.approach.solution import (
    EventDriven,
    Numerics,
    Path,
    Response,
    Trajectory,
)
from drysim.core.model import AnyState, EndStopLaw, Plant, Samples, Sines, Totals

NOT_REACHED = "the end stops are never reached"


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
    return piecewise.solve(plant, law, motion, start, step, duration)


def unreached_numerics(unstopped: Response) -> Numerics:
    """Return the `Numerics` of a response that never reaches the stops."""
    return replace(unstopped.numerics, why=f"{unstopped.numerics.why}; {NOT_REACHED}")


def compute_trajectory(
    plant: Plant,
    law: EndStopLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> piecewise.PiecewiseTrajectory | UnreachedStopsTrajectory:
    """Solve a scene and return its trajectory; parameters as in `exact.solve`."""
    unstopped = coulomb.compute_trajectory(plant, law.coulomb, motion, start, duration)
    if not reaches_stops(unstopped, law.x_rM):
        return UnreachedStopsTrajectory(law, unstopped)
    return piecewise.compute_trajectory(plant, law, motion, start, duration)


def reaches_stops(trajectory: Trajectory, x_rM: float) -> bool:
    """Whether |x_r| reaches x_rM [m], at an extreme point of the path or at its end."""
    far = float(np.abs(trajectory.path((0.0, trajectory.end), x_rM).x_r).max())
    return max(far, abs(trajectory.state(trajectory.end).x_r)) >= x_rM


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

    def hits(self) -> piecewise.Impacts:
        """Return no contacts."""
        return piecewise.Impacts(np.empty(0), np.empty(0))

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return 0 N."""
        return 0.0
