"""One step that may hold events: stops, break-aways, reversals, any number of each."""

from __future__ import annotations

import math

from drysim.core.compiled import inlined
from drysim.core.events import (
    REVERSAL,
    ROOM,
    SLIP,
    STICK,
    holding_force,
    limit_force,
    note,
    sign,
    tightness,
)
from drysim.core.samples.parts import slide_on
from drysim.core.samples.steps import faint_below, step_end
from drysim.core.samples.stop import NEVER
from drysim.core.samples.within import coast, rate_after, stop_within

CANCELS = 1e-3
"""Where a reversal leaves less than this share of a velocity, it is worked out afresh."""


@inlined
def through_events(
    plant, law, steps, parts, carried, u_0, u_1, n, x_r, v_r, d, log, count, closest
):  # fmt: skip
    """Carry the state through a step that may hold any number of events.

    Parameters
    ----------
    plant, law, steps
    parts : Parts or tuple
        Of such steps; empty where a series serves them.
    carried : tuple of float
        Relative acceleration at the start of the step [m/s²], which carries a faint velocity
        on, see `creep`; empty where x_r and v_r determine it.
    u_0, u_1 : float
        ü at both ends of the step [m/s²].
    n : int
        Number of the sample at the start of the step.
    x_r, v_r : float
        State at the start of the step [m, m/s].
    d : int
        Direction of sliding, 0 when stuck.
    log : Log
    count : int
        Events written so far; there is room for `ROOM` more.
    closest : float
        Tightest stop decision so far [-].

    Returns
    -------
    x_r, v_r, a, d, count, closest
        At the end of the step, a [m/s²] where v_r is faint and a is carried or the step is
        long, else NaN; `count` is negative when there is no room for its events.

    Notes
    -----
    `x_end` and `v_end` are the state at the end of the step should nothing more happen. A
    reversal adds what the jump of the friction force does in the rest of the step: between
    events the motion is linear. In a long step `slide_on` finds that state on its way.
    """
    h, f = steps.dt, steps.f
    room = count + ROOM
    slope = (u_1 - u_0) / h
    per_m = 1.0 / plant.m
    begin = 0.0
    x_end, v_end = x_r, v_r
    if len(carried) == 0:
        a = -(u_0 + steps.c * v_r + steps.w * x_r + d * f)
        if d != 0:
            x_end, v_end = step_end(steps, x_r, v_r, d, u_0, u_1)
    else:
        a = carried[0]
        if len(parts) == 0:
            way, v_end = coast(steps, d * v_r, d * a, -d * slope, h)
            x_end, v_end = x_r + d * way, d * v_end
    while count < room:
        if d == 0:
            F_L = limit_force(plant, x_r, u_1)
            if abs(F_L) <= holding_force(plant, law, x_r):
                return x_r, 0.0, math.nan, 0, count, closest
            # Break-away: F_L is linear in time, so it meets the limit at a quotient.
            d = -sign(F_L)
            F_L = -d * law.F_fs
            meets = (F_L - limit_force(plant, x_r, u_0)) / (plant.m * slope)
            begin = min(max(meets, begin), h)
            count = note(log, count, n, begin, d * SLIP, x_r, F_L)
            a = d * (law.F_fs - law.F_fk) * per_m
            v_r = 0.0
            if len(parts) == 0:
                way, v_end = coast(steps, 0.0, d * a, -d * slope, h - begin)
                x_end, v_end = x_r + d * way, d * v_end
        if len(parts) == 0:
            stop, way = stop_within(steps, d * v_r, d * a, -d * slope, d * v_end, h - begin)
        else:
            stop, way, v_end, a_end = slide_on(
                steps, parts, d * v_r, d * a, -d * slope, h - begin
            )
            x_end, v_end = x_r + d * way, d * v_end
        if stop == NEVER:
            # What two ways of rounding make of a velocity next to zero.
            if d * v_end < 0.0:
                v_end = 0.0
            if len(parts) == 0:
                if len(carried) == 0:
                    return x_end, v_end, math.nan, d, count, closest
                a_end = rate_after(steps, d * v_r, d * a, -d * slope, h - begin)
            if abs(v_end) > faint_below(steps, x_end):
                return x_end, v_end, math.nan, d, count, closest
            return x_end, v_end, d * a_end, d, count, closest
        x_r += d * way
        v_r = 0.0
        begin = min(begin + stop, h)
        F_L = limit_force(plant, x_r, u_0 + slope * begin)
        closest = min(closest, tightness(F_L, law.F_fs))
        if abs(F_L) <= holding_force(plant, law, x_r):
            d = 0
            count = note(log, count, n, begin, STICK, x_r, F_L)
            continue
        turns = d * F_L > 0.0
        jump = 2.0 * d * f
        d = -sign(F_L)
        a = -(F_L + d * law.F_fk) * per_m
        count = note(log, count, n, begin, d * REVERSAL, x_r, F_L)
        if turns and len(parts) == 0:
            way, v = coast(steps, 0.0, jump, 0.0, h - begin)
            x_end += way
            v_end += v
            if abs(v_end) < CANCELS * abs(v):
                way, v_end = coast(steps, 0.0, d * a, -d * slope, h - begin)
                x_end, v_end = x_r + d * way, d * v_end
    return x_r, v_r, a, d, -1, closest
