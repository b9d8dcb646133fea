"""The exact march over sampled base motion: slide, stop, stick, break away.

Within a sample interval ü is linear, so a step of sliding is one fixed affine map and only a
step that holds an event needs more. Friction limits are constant here; `leap` serves limits
that vary.
"""

from __future__ import annotations

import math

import numpy as np

from drysim.core.compiled import compiled, held, inlined
from drysim.core.events import ROOM, holding_force
from drysim.core.samples.eventful import through_events
from drysim.core.samples.glide import creep, glide, lifted, look_ahead
from drysim.core.samples.parts import parts_of
from drysim.core.samples.steps import faint_below, steps_of

STRETCH = 256
"""Samples prepared at once: a few kilobytes. Chains of steps begin anew at each multiple, so
that a march handed over there goes on to the last bit."""

BLOCK = 16
"""Stuck samples that are tested at once: two or four in the widest registers."""


def march(
    plant, law, u_dd, dt, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count, capacity
):  # fmt: skip
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
    a : float
        Relative acceleration at sample n [m/s²]; NaN where x_r and v_r determine it.
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached; what lies up to `end` may be scribbled on.
    log : Log
    count, capacity : int
        Events already in the log, and its length; at least `ROOM` must be free.

    Returns
    -------
    n, x_r, v_r, d, a, count, closest
        Sample reached, the state there, events in the log (negative when one step holds too
        many) and the tightest stop decision [-]; x_r is no number where a stretch of samples
        ahead is not of finite numbers. A march that starts there goes on as if never
        stopped: to the last bit where n is a multiple of `STRETCH` or the log was full, to
        rounding elsewhere.
    """
    ahead = held(np.empty(STRETCH)), held(np.empty(STRETCH))
    steps = steps_of(plant, law, dt)
    # By what comes in place of parts a kernel is compiled for one way or the other.
    parts = () if steps.short else parts_of(steps)
    return march_on(
        plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out,
        log, count, capacity, *ahead,
    )  # fmt: skip


@compiled
def march_on(
    plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count,
    capacity, x_ahead, v_ahead,
):  # fmt: skip
    """March as `march` says; the last two are scratch for one stretch of samples."""
    closest = math.inf
    full = capacity - ROOM
    while n < end and 0 <= count <= full and x_r == x_r:
        if a == a:
            n, x_r, v_r, d, a, count, tight = march_faint(
                plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out,
                log, count, full,
            )  # fmt: skip
        else:
            n, x_r, v_r, d, a, count, tight = march_firm(
                plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, x_out, v_out, d_out, log,
                count, full, x_ahead, v_ahead,
            )  # fmt: skip
        closest = min(closest, tight)
    return n, x_r, v_r, d, a, count, closest


@compiled
def march_firm(
    plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, full,
    x_ahead, v_ahead,
):  # fmt: skip
    """March stretch by stretch until v_r is faint; parameters as in `march_on`."""
    begin, until = n, n
    closest = math.inf
    while n < end and 0 <= count <= full:
        if n >= until:
            begin, until = -1, min(n - n % STRETCH + STRETCH, end)
            if not numbers(u_dd[n : until + 1]):
                x_r = math.nan
                break
        if d == 0:
            n = rest(plant, law, u_dd, n, until, x_r, x_out, v_out, d_out)
        elif steps.fine:
            if begin < 0:
                begin = n
                look_ahead(steps.x_base, u_dd[n : until + 1], x_ahead)
                look_ahead(steps.v_base, u_dd[n : until + 1], v_ahead)
            n, x_r, v_r = glide(
                steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out, begin, x_ahead, v_ahead
            )
        if n < until:
            before = count
            x_r, v_r, a, d, count, closest = through_events(
                plant, law, steps, parts, (), u_dd[n], u_dd[n + 1], n, x_r, v_r, d, log, count,
                closest,
            )  # fmt: skip
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = d
            # No event after all: v_r may have become faint.
            if count == before and d != 0 and abs(v_r) <= faint_below(steps, x_r):
                if a != a:
                    a = -(u_dd[n] + steps.c * v_r + steps.w * x_r + d * steps.f)
                return n, x_r, v_r, d, a, count, closest
    return n, x_r, v_r, d, math.nan, count, closest


@compiled
def march_faint(
    plant,
    law,
    steps,
    parts,
    u_dd,
    n,
    end,
    x_r,
    v_r,
    d,
    a,
    x_out,
    v_out,
    d_out,
    log,
    count,
    full,
):
    """March while v_r is faint, with its acceleration; parameters as in `march_on`."""
    closest = math.inf
    while n < end and a == a and 0 <= count <= full:
        until = min(n - n % STRETCH + STRETCH, end)
        if not numbers(u_dd[n : until + 1]):
            x_r = math.nan
            break
        v_r, a = lifted(v_r, a)
        if steps.fine:
            n, x_r, v_r, a = creep(steps, u_dd, n, until, x_r, v_r, a, d, x_out, v_out, d_out)
        if n < until:
            x_r, v_r, a, d, count, closest = through_events(
                plant, law, steps, parts, (a,), u_dd[n], u_dd[n + 1], n, x_r, v_r, d, log,
                count, closest,
            )  # fmt: skip
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = d
    return n, x_r, v_r, d, a, count, closest


@inlined
def rest(plant, law, u_dd, n, until, x_r, x_out, v_out, d_out):
    """Stick until `until` or a step at whose end F_L is more than the contact bears."""
    F_k = plant.k_x * x_r
    hold = holding_force(plant, law, x_r)
    if n < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return n
    while n + BLOCK <= until and bears(plant.m, F_k, hold, u_dd[n + 1 : n + 1 + BLOCK]):
        for k in range(BLOCK):
            x_out[n + 1 + k] = x_r
        for k in range(BLOCK):
            v_out[n + 1 + k] = 0.0
        for k in range(BLOCK):
            d_out[n + 1 + k] = 0
        n += BLOCK
    while n < until and abs(plant.m * u_dd[n + 1] + F_k) <= hold:
        n += 1
        x_out[n] = x_r
        v_out[n] = 0.0
        d_out[n] = 0
    return n


@compiled
def numbers(u_dd):
    """Tell whether all of these are finite numbers."""
    finite = 0
    for k in range(len(u_dd)):
        finite += abs(u_dd[k]) < math.inf
    return finite == len(u_dd)


@compiled
def bears(m, F_k, hold, u_dd):
    """Tell whether the contact bears F_L at every one of these samples."""
    beyond = 0
    for k in range(len(u_dd)):
        beyond += abs(m * u_dd[k] + F_k) > hold
    return beyond == 0
