"""Exact solution of a scene, by the module that fits its law."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

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
    scene = (motion, start, step, duration)
    if isinstance(law, Law):
        return coulomb.solve(plant, law, *scene, whole)
    if isinstance(law, Stopped):
        from drysim.approach import stops

        return stops.solve(plant, law, *scene, whole)
    response = core_of(law, motion).solve(plant, law, *scene)
    return response if law.F_fs > 0.0 else coulomb.frictionless(response)


def follow(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Track:
    """Solve a scene with the core that fits its law, without a grid where it can."""
    if isinstance(law, Law):
        return coulomb.follow(plant, law, motion, start, duration)
    if isinstance(law, Stopped):
        from drysim.approach import stops

        return stops.follow(plant, law, motion, start, duration)
    return core_of(law, motion).follow(plant, law, motion, start, duration)


class Core(NamedTuple):
    """What solves the scenes of some laws: `solve` on a grid, `follow` without one."""

    solve: Callable[..., Response]
    follow: Callable[..., Track]


def core_of(law: AnyLaw, motion: Sines | Samples) -> Core:
    """Give what solves scenes of a law other than Coulomb's.

    Each module is loaded with its kernels when first needed.
    """
    if isinstance(law, Dynamic):
        from drysim.approach import taylor

        return Core(taylor.solve, taylor.follow)
    if isinstance(law, Slider) and isinstance(motion, Samples) and not law.variation:
        from drysim.approach import elastic

        return Core(elastic.solve_joints, elastic.follow_joints)
    if isinstance(law, Slider):
        from drysim.approach import elastic

        return Core(elastic.solve_contact, elastic.follow_contact)
    from drysim.approach import piecewise

    return Core(piecewise.solve, piecewise.follow)
