"""Exact solution of a scene, by the module that fits its law."""

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
    """Solve a scene with the core that fits its law, to be had on its grid.

    `whole` keeps the motion over samples at hand, however long it is.
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
    """Solve a scene with the core that fits its law, without a grid where it can."""
    trajectory: Trajectory = solver_module(law).compute_trajectory(
        plant, law, motion, start, duration
    )
    return trajectory


def solver_module(law: AnyLaw) -> Any:
    """Give the module that solves scenes of a law, loaded with its kernels when needed."""
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
