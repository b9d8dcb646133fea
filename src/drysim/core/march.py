"""The exact march over sampled base motion: slide, stop, stick, break away.

Within a sample interval ü is linear, so a step of sliding is one fixed affine map and only a
step that holds an event needs more. Friction limits are constant here; `leap` serves limits
that vary.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
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
from drysim.core.flow import flow
from drysim.core.series import SHORT
from drysim.core.stop import NEVER, coast

FINE = 1.0
"""Radians (or decays) a fine step may hold: what decays within it leaves a third, far above
rounding, and extrema are π apart."""


@compiled
def through_events(plant, law, c, w, short, u_0, slope, h, n, x_r, v_r, d, log, count, closest):
    """Carry the state through one step that may hold any number of events.

    Parameters
    ----------
    plant, law : Plant, Law
    c, w : float
        b/m [1/s] and k_x/m [1/s²].
    short : bool
        Whether the step is short enough for `series`.
    u_0, slope, h : float
        ü at the start of the step [m/s²], its rate [m/s³], length of the step [s].
    n : int
        Number of the sample at the start of the step.
    x_r, v_r : float
        State at the start of the step [m, m/s].
    d : int
        Direction of sliding, 0 when stuck.
    log : Log
    count : int
        Events written so far.
    closest : float
        Tightest stop decision so far [-].

    Returns
    -------
    x_r, v_r, d, count, closest
        At the end of the step; `count` is negative when the step holds more than `ROOM` events.
    """
    m, b = plant.m, plant.b
    room = count + ROOM
    begin = 0.0
    a = -(limit_force(plant, x_r, u_0) + b * v_r + d * law.F_fk) / m
    while count < room:
        if d == 0:
            F_L = limit_force(plant, x_r, u_0 + slope * h)
            if abs(F_L) <= holding_force(plant, law, x_r):
                return x_r, 0.0, 0, count, closest
            # Break-away: F_L is linear in time, so it meets the limit at a quotient.
            d = -sign(F_L)
            F_L = -d * law.F_fs
            meets = (F_L - limit_force(plant, x_r, u_0)) / (m * slope)
            begin = min(max(meets, begin), h)
            count = note(log, count, n, begin, d * SLIP, x_r, F_L)
            a = d * (law.F_fs - law.F_fk) / m
            v_r = 0.0
        stop, way, v_r = coast(c, w, d * v_r, d * a, -d * slope, h - begin, short)
        x_r += d * way
        if stop == NEVER:
            return x_r, d * v_r, d, count, closest
        begin = min(begin + stop, h)
        v_r = 0.0
        F_L = limit_force(plant, x_r, u_0 + slope * begin)
        closest = min(closest, tightness(F_L, law.F_fs))
        if abs(F_L) <= holding_force(plant, law, x_r):
            d = 0
            count = note(log, count, n, begin, STICK, x_r, F_L)
        else:
            d = -sign(F_L)
            a = -(F_L + d * law.F_fk) / m
            count = note(log, count, n, begin, d * REVERSAL, x_r, F_L)
    return x_r, v_r, d, -1, closest


@compiled
def march(plant, law, u_dd, dt, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, capacity):
    """March from sample n to sample `end`, or until the log is nearly full.

    Parameters
    ----------
    plant : Plant
    law : Law
        Constant limits only.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Distance of the samples [s].
    n, end : int
        First and last sample of this march.
    x_r, v_r : float
        State at sample n [m, m/s].
    d : int
        Direction of sliding at sample n, 0 when stuck.
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached.
    log : Log
    count, capacity : int
        Events already in the log, and its length; at least `ROOM` must be free.

    Returns
    -------
    n, x_r, v_r, d, count, closest
        Sample reached, the state there, events in the log (negative when one step holds too
        many) and the tightest stop decision [-]. A march that starts there goes on as if never
        stopped.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    y, y_d, Y, YY = flow(c, w, dt)
    x_x, x_v, x_1 = 1.0 - w * Y, y, YY / dt
    x_0 = Y - x_1
    v_x, v_v, v_1 = -w * y, y_d, Y / dt
    v_0 = y - v_1
    f = law.F_fk / m
    x_f, v_f = Y * f, y * f
    # A fine step holds at most one extremum of v_r, and the acceleration outlasts it, so its
    # signs at both ends tell of a dip. Every coarse step of sliding is looked into.
    coarse = (c + math.sqrt(w)) * dt > FINE
    short = (c + math.sqrt(w)) * dt <= SHORT
    closest = math.inf
    full = capacity - ROOM
    while n < end and 0 <= count <= full:
        if d == 0:
            F_k = k_x * x_r
            hold = holding_force(plant, law, x_r)
            while n < end and abs(m * u_dd[n + 1] + F_k) <= hold:
                n += 1
                x_out[n] = x_r
                v_out[n] = 0.0
                d_out[n] = 0
        else:
            a = -(u_dd[n] + c * v_r + w * x_r + d * f)
            while n < end and not coarse:
                u_0 = u_dd[n]
                u_1 = u_dd[n + 1]
                x_next = x_x * x_r + x_v * v_r - (x_0 * u_0 + x_1 * u_1 + d * x_f)
                v_next = v_x * x_r + v_v * v_r - (v_0 * u_0 + v_1 * u_1 + d * v_f)
                a_next = -(u_1 + c * v_next + w * x_next + d * f)
                if d * v_next <= 0.0 or (d * a < 0.0 and d * a_next > 0.0):
                    break
                n += 1
                x_r = x_next
                v_r = v_next
                a = a_next
                x_out[n] = x_r
                v_out[n] = v_r
                d_out[n] = d
        if n < end:
            slope = (u_dd[n + 1] - u_dd[n]) / dt
            x_r, v_r, d, count, closest = through_events(
                plant, law, c, w, short, u_dd[n], slope, dt, n, x_r, v_r, d, log, count, closest
            )
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = d
    return n, x_r, v_r, d, count, closest
