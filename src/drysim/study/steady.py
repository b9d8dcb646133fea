"""The periodic orbit by fixed steps: march until the motion repeats, and say how well."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach.response import Orbit
from drysim.core.plant import State

if TYPE_CHECKING:
    from drysim.approach.events import Floats
    from drysim.study.case import Case

BURST = 8
"""Periods marched at a time, and the longest repetition that is looked for."""

MOST_BURSTS = 64
"""Bursts after which a motion counts as not settled: what decays has decayed by then."""

CLOSED = 1e-9
"""Scaled change of the state over a repetition that counts as none [-]."""

ON_GRID = 1e-9
"""A period this close to a whole number of steps, in steps, is that number."""


def fitted(step: float, period: float) -> float:
    """Give the greatest step that is at most `step` and divides the period [s]."""
    return period / max(1, ceil(period / step - ON_GRID))


def march_to_orbit(case: Case, period: float) -> Orbit:
    """Follow the start of a case to its periodic orbit, step by step.

    Notes
    -----
    Fixed steps have an orbit of their own near that of the motion; a march that chatters may
    have none, and its closure says so.
    """
    dt = fitted(case.step, period)
    steps = round(period / dt)
    scene = (case.plant, case.law, case.motion)
    state, peak, closure, multiple, bursts = case.start, 0.0, np.inf, BURST, 0
    while closure > CLOSED and bursts < MOST_BURSTS:
        response = case.approach.solve(*scene, state, dt, BURST * period)
        x_r, v_r = response.x_r, response.v_r
        changes = np.maximum(repeats(x_r, steps), repeats(v_r, steps))
        closed = np.flatnonzero(changes <= CLOSED)
        multiple = int(closed[0]) + 1 if len(closed) else BURST
        closure = float(changes[multiple - 1])
        state = State(float(x_r[BURST * steps]), float(v_r[BURST * steps]))
        peak, bursts = max(peak, float(np.abs(x_r).max())), bursts + 1
    return Orbit(state, multiple, closure, closure <= CLOSED, True, bursts * BURST * period, peak)


def repeats(series: Floats, steps: int) -> Floats:
    """Give the change of a series over the last 1, 2, ... periods of a burst, scaled [-]."""
    ends = series[steps * BURST - steps * np.arange(BURST + 1)]
    scale = float(np.abs(series).max())
    changes: Floats = np.abs(ends[1:] - ends[0]) / (scale or 1.0)
    return changes
