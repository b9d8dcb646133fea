"""The periodic orbit of a motion that is followed step by step."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach import by_series
from drysim.approach.bounded import march
from drysim.approach.by_series import Series
from drysim.approach.orbit import Orbit
from drysim.approach.traced import Traced, follow
from drysim.approach.ways import AnyOther
from drysim.core.motion import Sines
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import Dynamic, Plant, Slider, Stopped
from drysim.core.state import AnyState

MOST_PERIODS = 2_000
"""Periods after which a motion counts as not settled."""

MOST_MULTIPLE = 8
"""Longest repetition that is looked for, in periods of the excitation."""

CLOSED = {Slider: 1e-12, Stopped: 1e-12, Pressed: 1e-12, Dynamic: 1e-9}
"""Scaled change of the state over a repetition that counts as none [-]: in closed form, and by
series of the loosest tolerance that makes sense."""


def once(
    plant: Plant, law: AnyOther | Dynamic, motion: Sines, state: AnyState, period: float
) -> Traced | Series:
    """Follow a state for one period."""
    if isinstance(law, Stopped):
        return march(plant, law, motion, state, period)
    if isinstance(law, Dynamic):
        return by_series.follow(plant, law, motion, state, period)
    return follow(plant, law, motion, state, period)


def find_orbit(
    plant: Plant,
    law: AnyOther | Dynamic,
    motion: Sines,
    start: AnyState,
    period: float,
) -> Orbit:
    """Follow a start, period by period, to its periodic orbit."""
    state: AnyState = start
    past: list[AnyState] = []
    peak, scale, closure = 0.0, [0.0] * 3, math.inf
    for periods in range(1, MOST_PERIODS + 1):
        track = once(plant, law, motion, state, period)
        state = track.state(period)
        peak = max(peak, float(np.abs(track.turns.x_r).max()))
        largest = [float(np.abs(c).max()) for c in track.series]
        scale = [max(new, 0.5 * old) for new, old in zip(largest, scale, strict=False)]
        past = [state, *past[:MOST_MULTIPLE]]
        changes = [
            max(
                abs(a - b) / (c or 1.0)
                for a, b, c in zip(state[:3], old[:3], scale, strict=True)
            )
            for old in past[1:]
        ]
        closed = [i for i, change in enumerate(changes) if change <= CLOSED[type(law)]]
        if closed:
            closure, multiple = changes[closed[0]], closed[0] + 1
            return Orbit(state, multiple, closure, True, True, periods * period, peak)
        closure = min(changes, default=math.inf)
    return Orbit(state, 1, closure, False, True, MOST_PERIODS * period, peak)
