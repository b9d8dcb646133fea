"""Exact solution of a scene, by the module that fits its law."""

from __future__ import annotations

from typing import Any

from drysim.approach import coulomb
from drysim.approach.solution import Response, Track
from drysim.core.model import (
    AnyLaw,
    AnyState,
    Dynamic,
    Law,
    Plant,
    Samples,
    Sines,
    Slider,
    Stopped,
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
    if isinstance(law, Law | Stopped):
        response: Response = core_of(law).solve(*scene, whole)
        return response
    response = core_of(law).solve(*scene)
    return response if law.F_fs > 0.0 else coulomb.frictionless(response)


def follow(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Track:
    """Solve a scene with the core that fits its law, without a grid where it can."""
    track: Track = core_of(law).follow(plant, law, motion, start, duration)
    return track


def core_of(law: AnyLaw) -> Any:
    """Give the module that solves scenes of a law, loaded with its kernels when needed."""
    if isinstance(law, Law):
        return coulomb
    if isinstance(law, Stopped):
        from drysim.approach import end_stops

        return end_stops
    if isinstance(law, Dynamic):
        from drysim.approach import taylor

        return taylor
    if isinstance(law, Slider):
        from drysim.approach import elastic

        return elastic
    from drysim.approach import piecewise

    return piecewise
