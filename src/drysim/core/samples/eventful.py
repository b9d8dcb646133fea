"""One step that may hold events: stops, break-aways, reversals, any number of each."""

from __future__ import annotations

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
from drysim.core.samples.steps import step_end
from drysim.core.samples.stop import NEVER
from drysim.core.samples.within import coast, stop_within

CANCELS = 1e-3
"""Where a reversal leaves less than this share of a velocity, it is worked out afresh."""


@inlined
def through_part(plant, law, steps, u_0, u_1, n, t, x_r, v_r, d, log, count, room, closest):
    """Carry the state through a step, or part of one, that may hold any number of events.

    Parameters
    ----------
    plant, law, steps
    u_0, u_1 : float
        ü at both ends of the step [m/s²].
    n : int
        Number of the sample at the start of the step.
    t : float
        Where in the step the part begins [s].
    x_r, v_r : float
        State at the start of the step [m, m/s].
    d : int
        Direction of sliding, 0 when stuck.
    log : Log
    count, room : int
        Events written so far, and how many there is room for.
    closest : float
        Tightest stop decision so far [-].

    Returns
    -------
    x_r, v_r, d, count, closest
        At the end of the step; `count` is negative when there is no room for its events.

    Notes
    -----
    `x_end` and `v_end` are the state at the end of the step should nothing more happen. A
    reversal adds what the jump of the friction force does in the rest of the step: between
    events the motion is linear.
    """
    h, f = steps.dt, steps.f
    slope = (u_1 - u_0) / h
    per_m = 1.0 / plant.m
    begin = 0.0
    a = -(u_0 + steps.c * v_r + steps.w * x_r + d * f)
    x_end, v_end = x_r, v_r
    if d != 0:
        x_end, v_end = step_end(steps, x_r, v_r, d, u_0, u_1)
        if not steps.short:
            way, v_end = coast(steps, d * v_r, d * a, -d * slope, h)
            x_end, v_end = x_r + d * way, d * v_end
    while count < room:
        if d == 0:
            F_L = limit_force(plant, x_r, u_1)
            if abs(F_L) <= holding_force(plant, law, x_r):
                return x_r, 0.0, 0, count, closest
            # Break-away: F_L is linear in time, so it meets the limit at a quotient.
            d = -sign(F_L)
            F_L = -d * law.F_fs
            meets = (F_L - limit_force(plant, x_r, u_0)) / (plant.m * slope)
            begin = min(max(meets, begin), h)
            count = note(log, count, n, t + begin, d * SLIP, x_r, F_L)
            a = d * (law.F_fs - law.F_fk) * per_m
            v_r = 0.0
            way, v_end = coast(steps, 0.0, d * a, -d * slope, h - begin)
            x_end, v_end = x_r + d * way, d * v_end
        stop, way = stop_within(steps, d * v_r, d * a, -d * slope, d * v_end, h - begin)
        if stop == NEVER:
            # What two ways of rounding make of a velocity next to zero.
            if d * v_end < 0.0:
                v_end = 0.0
            return x_end, v_end, d, count, closest
        x_r += d * way
        v_r = 0.0
        begin = min(begin + stop, h)
        F_L = limit_force(plant, x_r, u_0 + slope * begin)
        closest = min(closest, tightness(F_L, law.F_fs))
        if abs(F_L) <= holding_force(plant, law, x_r):
            d = 0
            count = note(log, count, n, t + begin, STICK, x_r, F_L)
            continue
        turns = d * F_L > 0.0
        jump = 2.0 * d * f
        d = -sign(F_L)
        a = -(F_L + d * law.F_fk) * per_m
        count = note(log, count, n, t + begin, d * REVERSAL, x_r, F_L)
        if turns:
            way, v = coast(steps, 0.0, jump, 0.0, h - begin)
            x_end += way
            v_end += v
            if not steps.short or abs(v_end) < CANCELS * abs(v):
                way, v_end = coast(steps, 0.0, d * a, -d * slope, h - begin)
                x_end, v_end = x_r + d * way, d * v_end
    return x_r, v_r, d, -1, closest


@inlined
def through_events(
    plant, law, steps, inner, parts, u_0, u_1, n, x_r, v_r, d, log, count, closest
):
    """Carry the state through one step that may hold any number of events.

    A fine step too long for a series is walked in `parts` that are not, the steps `inner`: the
    base moves on a line in each as in the whole. Else parameters and returns as in
    `through_part`.
    """
    room = count + ROOM
    if parts == 1:
        return through_part(
            plant, law, steps, u_0, u_1, n, 0.0, x_r, v_r, d, log, count, room, closest
        )
    rise = (u_1 - u_0) / parts
    for k in range(parts):
        u_a = u_0 + k * rise
        u_b = u_0 + (k + 1) * rise if k + 1 < parts else u_1
        x_r, v_r, d, count, closest = through_part(
            plant, law, inner, u_a, u_b, n, k * inner.dt, x_r, v_r, d, log, count, room, closest
        )
        if count < 0:
            break
    return x_r, v_r, d, count, closest
