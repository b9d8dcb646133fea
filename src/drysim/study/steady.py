"""The periodic orbit by fixed steps: march until the motion repeats, and say how well."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from drysim.approach.orbit import Orbit
from drysim.approach.stick_slip import Exact, StickSlip
from drysim.core.motion import Sines
from drysim.core.state import AnyState, State

if TYPE_CHECKING:
    from drysim.approach.events import Floats
    from drysim.study.case import Case

BURST = 8
"""Periods marched at a time at least, and the longest repetition that is looked for; those of
the exact orbit where these are more."""

MOST_BURSTS = 64
"""Bursts after which a motion counts as not settled: what decays has decayed by then."""

PATIENCE = 3
"""Bursts at least; more only while each closes better than the one before."""

BETTER = 0.99
"""Share of the change before that counts as closing better: what creeps closes slowly."""

CLOSED = 1e-9
"""Scaled change of the state over a repetition that counts as none [-]."""

ON_GRID = 1e-9
"""A period this close to a whole number of steps, in steps, is that number."""


def fitted(step: float, period: float) -> float:
    """Give the greatest step that is at most `step` and divides the period [s]."""
    return period / max(1, ceil(period / step - ON_GRID))


def orbit_of(case: Case) -> tuple[Orbit, float]:
    """Give the periodic orbit of a case, and the step that it is solved with [s]."""
    period = case.period
    assert period is not None, "only what repeats has an orbit"
    approach, motion = case.approach, case.motion
    assert isinstance(motion, Sines), "samples end, so they repeat nothing"
    scene = (case.plant, case.law, motion)
    if isinstance(approach, Exact):
        return approach.orbit(*scene, case.start, period), case.step
    step = fitted(case.step, period)
    exact = StickSlip().orbit(*scene, case.start, period)
    return march_to_orbit(case, exact.state, step, period, max(BURST, exact.periods)), step


def march_to_orbit(
    case: Case, state: AnyState, dt: float, period: float, burst: int = BURST
) -> Orbit:
    """Follow the exact orbit, step by step, to the orbit of a fixed-step approach.

    Notes
    -----
    Fixed steps have an orbit of their own near that of the motion, so a march begins on the
    latter. One that chatters may have none, and its closure says so.
    """
    steps = round(period / dt)
    scene = (case.plant, case.law, case.motion)
    peak, closure, before, multiple, bursts = 0.0, np.inf, np.inf, burst, 0
    while bursts < PATIENCE or (CLOSED < closure < BETTER * before and bursts < MOST_BURSTS):
        response = case.approach.solve(*scene, state, dt, burst * period)
        x_r, v_r = response.x_r, response.v_r
        changes = np.maximum(repeats(x_r, steps, burst), repeats(v_r, steps, burst))
        closed = np.flatnonzero(changes <= CLOSED)
        multiple = int(closed[0]) + 1 if len(closed) else burst
        closure, before = float(changes[multiple - 1]), closure
        state = State(float(x_r[burst * steps]), float(v_r[burst * steps]))
        peak, bursts = max(peak, float(np.abs(x_r).max())), bursts + 1
    run_up = bursts * burst * period
    return Orbit(state, multiple, closure, closure <= CLOSED, True, run_up, peak)


def repeats(series: Floats, steps: int, burst: int) -> Floats:
    """Give the change of a series over the last 1, 2, ... periods of a burst, scaled [-]."""
    ends = series[steps * burst - steps * np.arange(burst + 1)]
    scale = float(np.abs(series).max())
    changes: Floats = np.abs(ends[1:] - ends[0]) / (scale or 1.0)
    return changes
