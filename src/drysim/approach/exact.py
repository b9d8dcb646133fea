"""Exact solution of a scene by the algorithm that `SOLVERS` has for it.

Under sines a scene with end stops is first solved without them, which is faster. If x_r stays
between the stops, this solution is exact for the scene with stops as well. x_r is compared at
the extreme points of the path, so that no contact is missed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import import_module
from typing import Any

import numpy as np

from drysim.approach.solution import (
    EventDriven,
    Events,
    Grid,
    Impacts,
    Path,
    Points,
    Response,
    Trajectory,
)
from drysim.approach.solvers import solver_of
from drysim.core.model import (
    AnyLaw,
    AnyState,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    Totals,
    has_friction,
)

NOT_REACHED = "the end stops are never reached"


def solve(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene and return its response on a grid.

    Parameters
    ----------
    plant : Plant
        Mass [kg], stiffness [N/m] and damping [N·s/m].
    law : AnyLaw
        Friction law.
    motion : Sines or Samples
        Base motion.
    start : AnyState
        State at t = 0.
    step : float
        Step of the output grid [s]; not used for samples, which have their own.
    duration : float or None
        Length of the run [s]; optional for samples.
    whole : bool
        Whether to keep the motion over samples in memory, however long it is.

    Returns
    -------
    Response

    Raises
    ------
    SolverError
        If events do not advance in time, or the motion is not finite.
    """
    trajectory = compute_trajectory(plant, law, motion, start, duration, whole)
    return response_on_grid(trajectory, step)


def response_on_grid(trajectory: Trajectory, step: float) -> Response:
    """Return the response of a solution on a grid; samples have their own step."""
    law = trajectory.law
    if isinstance(trajectory, UnreachedStopsTrajectory):
        response: Response = response_on_grid(trajectory.unstopped, step)
        numerics = replace(response.numerics, why=f"{response.numerics.why}; {NOT_REACHED}")
        return replace(response, law=law, numerics=numerics, trajectory=trajectory)
    response = solver_module(law, trajectory.motion).response_on_grid(trajectory, step)
    if has_friction(law) or law.stops is not None:
        return response
    return without_friction(response)


def without_friction(response: Response) -> Response:
    """Return the response of a scene without friction, where turning points are no events."""
    events, grid = response.events, response.grid
    begin = Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    why = "no dry friction: closed form in each step"
    numerics = replace(
        response.numerics, approach="viscous", why=why, events=1, closest_decision=None
    )
    sliding = replace(grid, part=partial(sliding_points, grid))
    return replace(response, grid=sliding, events=begin, numerics=numerics)


def sliding_points(grid: Grid, first: int, last: int) -> Points:
    """Return grid points `first` to `last` - 1, none of them stuck."""
    points = grid.part(first, last)
    return points._replace(d=np.ones_like(points.d))


def compute_trajectory(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
    whole: bool = False,
) -> Trajectory:
    """Solve a scene and return its trajectory; under sines no grid is involved.

    Parameters and errors as in `solve`.
    """
    scene = plant, law, motion, start, duration
    if isinstance(motion, Sines) and isinstance(law, PiecewiseLaw) and law.stops is not None:
        unstopped = compute_trajectory(plant, law.without_stops, motion, start, duration, whole)
        if not reaches_stops(unstopped, law.stops):
            return UnreachedStopsTrajectory(law, unstopped)
    trajectory: Trajectory = solver_module(law, motion).compute_trajectory(*scene, whole)
    return trajectory


def solver_module(law: AnyLaw, motion: Sines | Samples) -> Any:
    """Return the module that solves a scene."""
    return load_solver(solver_of(law, motion).module)


@cache
def load_solver(name: str) -> Any:
    """Return a module of this package; its kernels are loaded on first use."""
    return import_module(f"drysim.approach.{name}")


# End stops that are not reached.


def reaches_stops(trajectory: Trajectory, stops: EndStops) -> bool:
    """Return whether x_r reaches a stop, at an extreme point of the path or at its end."""
    path = trajectory.path.x_r
    end = trajectory.state(trajectory.end).x_r
    return bool(stops.limits.side(np.append(path, end)).any())


@dataclass(frozen=True, eq=False)
class UnreachedStopsTrajectory(EventDriven):
    """Solution of a scene that never reaches its end stops; wraps that without stops."""

    law: PiecewiseLaw
    unstopped: Trajectory

    @property
    def plant(self) -> Plant:
        """Oscillator."""
        return self.unstopped.plant

    @property
    def motion(self) -> Sines | Samples:
        """Base motion."""
        return self.unstopped.motion

    @property
    def closest_decision(self) -> float:
        """Smallest relative margin of a decision between stick and slip [-]."""
        return self.unstopped.closest_decision

    @property
    def path(self) -> Path:
        """The start and the turning points of x_r."""
        return self.unstopped.path

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

    def jacobian(self) -> tuple[float, float] | None:
        """Return that of the motion without stops."""
        return self.unstopped.jacobian()

    def hits(self) -> Impacts:
        """Return no contacts."""
        return Impacts(np.empty(0), np.empty(0))

    def peak_bumper_force(self, begin: float, end: float) -> float:
        """Return 0 N."""
        return 0.0
