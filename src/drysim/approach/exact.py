"""The exact solution of a scene, with the core that fits its base motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drysim.approach import by_series, under_sines
from drysim.approach.events import Events
from drysim.approach.over_samples import solve_samples
from drysim.approach.response import Orbit, Response, Track
from drysim.approach.under_sines import follow_sines, on_grid
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, AnyState, Dynamic, Plant, State
from drysim.errors import UsageError

__all__ = ["find_orbit", "follow", "frictionless", "solve"]


def solve(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    step: float,
    duration: float | None,
) -> Response:
    """Solve a scene with the core that fits its base motion, and write it on its grid."""
    if isinstance(law, Dynamic):
        return by_series.solve(plant, law, motion, start, step, duration)
    if isinstance(motion, Samples):
        return solve_samples(plant, law, motion, State(*start[:2]), duration)
    return on_grid(follow_sines(plant, law, motion, State(*start[:2]), needed(duration)), step)


def follow(
    plant: Plant,
    law: AnyLaw,
    motion: Sines | Samples,
    start: AnyState,
    duration: float | None,
) -> Track:
    """Solve a scene with the core that fits its base motion, without a grid where it can."""
    if isinstance(law, Dynamic):
        return by_series.follow(plant, law, motion, start, duration)
    if isinstance(motion, Samples):
        track = solve_samples(plant, law, motion, State(*start[:2]), duration).track
        assert track is not None, "samples are solved with their track"
        return track
    return follow_sines(plant, law, motion, State(*start[:2]), needed(duration))


def needed(duration: float | None) -> float:
    """Give the duration [s], which sines need."""
    if duration is None:
        raise UsageError("base motion by sines has no end of its own", "say how long to run")
    return duration


def frictionless(response: Response) -> Response:
    """Give the response of a scene without dry friction: turning points are not events then."""
    whole = np.ones(len(response.x_r), dtype=np.int8)
    events = response.events
    begin = Events(events.t[:1], np.sign(events.kind[:1]), events.x_r[:1], events.F_L[:1])
    why = "no dry friction: the same flow, with turning points for the peaks only"
    numerics = replace(
        response.numerics, approach="viscous", why=why, events=1, closest_decision=None
    )
    return replace(response, d=whole, events=begin, numerics=numerics)


def find_orbit(
    plant: Plant, law: AnyLaw, motion: Sines, start: AnyState, period: float
) -> Orbit:
    """Follow a start to its periodic orbit with the core that fits the law."""
    if isinstance(law, Dynamic):
        return by_series.find_orbit(plant, law, motion, start, period)
    return under_sines.find_orbit(plant, law, motion, State(*start[:2]), period)
