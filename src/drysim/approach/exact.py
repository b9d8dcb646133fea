"""Exact solution of a scene by the algorithm that `SOLVERS` has for it.

Under sines a scene with Coulomb friction and end stops is first solved without the stops, which
is faster. If x_r stays between them at the extreme points of its path, this motion is that of
the scene with stops as well.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from drysim.approach.solution import (
    Events,
    Grid,
    Points,
    Response,
    Trajectory,
)
from drysim.approach.solvers import solver_of
from drysim.core.model import (
    AnyLaw,
    AnyState,
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    has_friction,
)

if TYPE_CHECKING:
    from drysim.approach.piecewise import PiecewiseTrajectory

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
    law, motion = trajectory.law, trajectory.motion
    if isinstance(motion, Sines) and law.stops is not None and not trajectory.reaches_stops:
        response: Response = response_on_grid(trajectory.without_stops, step)
        numerics = replace(response.numerics, why=f"{response.numerics.why}; {NOT_REACHED}")
        return replace(response, law=law, numerics=numerics, trajectory=trajectory)
    response = solver_module(law, motion).response_on_grid(trajectory, step)
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
    slides = isinstance(law, PiecewiseLaw) and isinstance(law.without_stops, CoulombLaw)
    if isinstance(motion, Sines) and slides and law.stops is not None:
        unstopped: PiecewiseTrajectory = load_solver("coulomb").sine_trajectory(*scene)
        if not unstopped.reaches_stops:
            return unstopped
    trajectory: Trajectory = solver_module(law, motion).compute_trajectory(*scene, whole)
    return trajectory


def solver_module(law: AnyLaw, motion: Sines | Samples) -> Any:
    """Return the module that solves a scene."""
    return load_solver(solver_of(law, motion).module)


@cache
def load_solver(name: str) -> Any:
    """Return a module of this package; its kernels are loaded on first use."""
    return import_module(f"drysim.approach.{name}")
