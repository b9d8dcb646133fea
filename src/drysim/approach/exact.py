"""Exact solution of a scene by the algorithm that `SOLVERS` has for it.

Under sines a scene with Coulomb friction and end stops is first solved without the stops, which
is faster. If x_r stays between them at the extreme points of its path, this motion is that of
the scene with stops as well.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from drysim.approach.solution import ExactTrajectory, Response
from drysim.approach.solvers import solver_of
from drysim.core.model import (
    AnyLaw,
    AnyState,
    CoulombLaw,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
)

if TYPE_CHECKING:
    from drysim.approach.piecewise import PiecewiseTrajectory


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
    response: Response = load_module("grid").response_on_grid(trajectory, step)
    return response


def compute_trajectory(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
    whole: bool = False,
) -> ExactTrajectory:
    """Solve a scene and return its trajectory; under sines no grid is involved.

    Parameters and errors as in `solve`.
    """
    scene = plant, law, motion, start, duration
    slides = isinstance(law, PiecewiseLaw) and isinstance(law.without_stops, CoulombLaw)
    if isinstance(motion, Sines) and slides and law.stops is not None:
        unstopped: PiecewiseTrajectory = load_module("coulomb").sine_trajectory(*scene)
        if not unstopped.reaches_stops:
            return unstopped
    solver = load_module(solver_of(law, motion).module)
    trajectory: ExactTrajectory = solver.compute_trajectory(*scene, whole)
    return trajectory


@cache
def load_module(name: str) -> Any:
    """Return a module of this package; its kernels are loaded on first use."""
    return import_module(f"drysim.approach.{name}")
