"""Exact solution of a scene by the module that fits its friction law."""

from __future__ import annotations

from typing import Any

from drysim.approach import coulomb
from drysim.approach.solution import Response, Trajectory
from drysim.core.model import (
    AnyLaw,
    AnyState,
    CoulombLaw,
    DynamicLaw,
    ElasticContactLaw,
    EndStopLaw,
    Plant,
    Samples,
    Sines,
)


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
        Friction law; its type selects the solver.
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
    scene = (plant, law, motion, start, step, duration)
    if isinstance(law, CoulombLaw | EndStopLaw):
        response: Response = solver_module(law).solve(*scene, whole)
        return response
    response = solver_module(law).solve(*scene)
    return response if law.F_fs > 0.0 else coulomb.without_friction(response)


def compute_trajectory(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Trajectory:
    """Solve a scene and return its trajectory; under sines no grid is involved.

    Parameters and errors as in `solve`.
    """
    trajectory: Trajectory = solver_module(law).compute_trajectory(
        plant, law, motion, start, duration
    )
    return trajectory


def solver_module(law: AnyLaw) -> Any:
    """Return the module that solves scenes of a law; its kernels are loaded on first use."""
    if isinstance(law, CoulombLaw):
        return coulomb
    if isinstance(law, EndStopLaw):
        from drysim.approach import end_stops

        return end_stops
    if isinstance(law, DynamicLaw):
        from drysim.approach import taylor

        return taylor
    if isinstance(law, ElasticContactLaw):
        from drysim.approach import elastic

        return elastic
    from drysim.approach import piecewise

    return piecewise
