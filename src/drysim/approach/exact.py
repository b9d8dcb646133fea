"""The exact solution of a scene, with the core that fits its base motion."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from drysim.approach import under_sines
from drysim.approach.events import Events
from drysim.approach.numerics import Numerics
from drysim.approach.orbit import Orbit
from drysim.approach.points import Sliding
from drysim.approach.response import Response
from drysim.approach.spans import run_length
from drysim.approach.track import Track
from drysim.approach.under_sines import follow_sines, on_grid
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Dynamic, Law, Plant, Slider, Stopped
from drysim.core.state import AnyState


def solve(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
    whole: bool,
) -> Response:
    """Solve a scene with the core that fits its base motion, to be had on its grid.

    `whole` keeps the motion over samples at hand, however long it is.
    """
    scene = (plant, law, motion, start, step, duration)
    if isinstance(law, Stopped):
        bounded: Response = home_of(law, motion).solve(*scene, whole)
        return bounded
    if not isinstance(law, Law):
        response = home_of(law, motion).solve(*scene)
    elif isinstance(motion, Sines):
        length = run_length(motion, duration)
        response = on_grid(follow_sines(plant, law, motion, start, length), step)
    else:
        from drysim.approach.over_samples import solve_samples

        response = solve_samples(plant, law, motion, start, duration, whole)
    return response if law.F_fs > 0.0 else frictionless(response)


def follow(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Track:
    """Solve a scene with the core that fits its base motion, without a grid where it can."""
    if not isinstance(law, Law):
        track: Track = home_of(law, motion).follow(plant, law, motion, start, duration)
        return track
    if isinstance(motion, Sines):
        return follow_sines(plant, law, motion, start, run_length(motion, duration))
    from drysim.approach.over_samples import solve_samples

    response = solve_samples(plant, law, motion, start, duration, whole=False)
    assert response.track is not None, "samples are solved with their track"
    return response.track


def home_of(law: AnyLaw, motion: Sines | Samples) -> Any:
    """Give the module that solves scenes of a law other than Coulomb's, or between end stops.

    Each has `solve` and `follow`, and is loaded with its kernels when first needed.
    """
    if isinstance(law, Stopped):
        from drysim.approach import bounded

        return bounded
    if isinstance(law, Dynamic):
        from drysim.approach import by_series

        return by_series
    if isinstance(law, Slider) and isinstance(motion, Samples) and not law.variation:
        from drysim.approach import over_joints

        return over_joints
    if isinstance(law, Slider):
        from drysim.approach import touched

        return touched
    from drysim.approach import traced

    return traced


def frictionless(response: Response) -> Response:
    """Give the response of a scene without dry friction: turning points are not events then."""
    events = response.events
    begin = Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    grid, how = Sliding(response.grid), partial(viscous_numerics, response)
    return replace(response, grid=grid, events=begin, how=how)


def viscous_numerics(response: Response) -> Numerics:
    """Give how the numbers of a response were made, where there is no dry friction."""
    why = "no dry friction: the same flow, with turning points for the peaks only"
    return replace(
        response.numerics, approach="viscous", why=why, events=1, closest_decision=None
    )


def find_orbit(
    plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit with the core that fits the law."""
    if isinstance(law, Stopped):
        from drysim.approach import bounded

        return bounded.find_orbit(plant, law, motion, start, period)
    if not isinstance(law, Law):
        from drysim.approach import settled

        return settled.find_orbit(plant, law, motion, start, period)
    return under_sines.find_orbit(plant, law, motion, start, period)
