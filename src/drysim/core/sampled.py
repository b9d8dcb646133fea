"""The exact march over sampled base motion: slide, stop, stick, break away; hold and yield.

Between two samples ü is linear, so as long as the mass slides in one direction, sticks, or is
held by a spring contact, a step is one fixed affine map, and exact. Only a step that holds an
event needs more. Friction limits are constant here; `march.leap` serves limits that vary.

Most steps hold no event. `rest` passes those in which the mass sticks, `glide` those in which
it slides, `skim` those in which a spring contact holds, `pass_on` those between two end stops.
A step waits for the one before it; but four states in a row, each carried four steps further,
are four chains that do not wait for each other, and what the base does within four steps hangs
on no state, so it is summed beforehand (`four_by_four`).

No stop is missed: a fine step holds at most one extremum of v_r, and the acceleration outlasts
it, so its signs at both ends tell of a dip. Four steps stand only where both ends are so fast
that no dip fits in between. Any step in doubt is left to `through_events`, or to `through` on a
spring contact, which carry the state through any number of events: stops are located in the
power series of a short step; one too long for that is walked in parts, up to the one that holds
its first stop.

A mass that creeps to rest after the base has fallen silent has a velocity far below the forces
that the affine map makes it of: it is faint, and `creep` carries velocity and acceleration on
by themselves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drysim.core.compile import compiled, held, inlined
from drysim.core.events import (
    REVERSAL,
    ROOM,
    SLIP,
    STICK,
    holding_force,
    limit_force,
    mark,
    note,
    onset,
    sign,
    tightness,
)
from drysim.core.model import Plant
from drysim.core.modes import HOLD, POISED, holds
from drysim.core.oscillator import (
    FINE,
    SHORT,
    distance,
    faint_below,
    faint_per_force,
    fall,
    flow,
    longer_series,
    map_of,
    rate,
    rate_of,
    series,
    speed,
    step_end,
    steps_of,
    whole_steps,
)
from drysim.core.roots import NEVER, locate_stop, never_stops, next_crossing, next_stop, turn_of

# Under Coulomb's friction, stretch by stretch of samples.


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
    plant, law, steps, parts, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count,
    full,
):  # fmt: skip
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


@compiled
def numbers(u_dd):
    """Tell whether all of these are finite numbers."""
    finite = 0
    for k in range(len(u_dd)):
        finite += abs(u_dd[k]) < math.inf
    return finite == len(u_dd)


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
def bears(m, F_k, hold, u_dd):
    """Tell whether the contact bears F_L at every one of these samples."""
    beyond = 0
    for k in range(len(u_dd)):
        beyond += abs(m * u_dd[k] + F_k) > hold
    return beyond == 0


# Sliding for as long as nothing happens.


ONE_OF_FOUR = 0.0625
"""What one step can hide, relative to what four can: the square of its length."""

LEAST, LIFT = 1e-250, 2.0**300
"""Below the first a velocity and its rate are multiplied by the second, see `lifted`."""


@compiled
def look_ahead(base, u_dd, ahead):
    """Sum what the base takes from the state within every four steps of a stretch.

    `base` is `Steps.x_base` or `Steps.v_base`, `u_dd` that of the stretch and of the sample
    behind; `ahead` is written for the four steps that begin at each sample.
    """
    p_0, p_1, p_2, p_3, p_4 = base
    for i in range(len(u_dd) - 4):
        ahead[i] = (
            p_0 * u_dd[i] + p_1 * u_dd[i + 1] + p_2 * u_dd[i + 2] + p_3 * u_dd[i + 3]
            + p_4 * u_dd[i + 4]
        )  # fmt: skip


@inlined
def glide(steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out, begin, x_ahead, v_ahead):
    """Slide until sample `until`, a step that may hold an event or a faint velocity.

    Parameters
    ----------
    steps : Steps
        Of fine steps.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    n, until : int
        Sample to begin at, and the last.
    x_r, v_r, d
        State there [m, m/s], and direction of sliding.
    x_out, v_out, d_out : array, shape (samples,)
        Written from n + 1 to the sample reached; up to three more may be scribbled on.
    begin : int
        Sample, not after n, at which `x_ahead` and `v_ahead` begin.
    x_ahead, v_ahead : array
        What the base does in every four steps, see `look_ahead`.

    Returns
    -------
    n, x_r, v_r
        Sample reached and the state there.
    """
    while n < until:
        fourth = n + 4 if steps.steep < math.inf else until
        n, x_r, v_r = one_by_one(
            steps, u_dd, n, min(fourth, until), x_r, v_r, d, x_out, v_out, d_out
        )
        if n < fourth:
            break
        n = four_by_four(steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_ahead, v_ahead)
        x_r = x_out[n]
        v_r = v_out[n]
    return n, x_r, v_r


@inlined
def one_by_one(steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out):
    """Slide step by step; parameters and returns as in `glide`."""
    c, w, f = steps.c, steps.w, d * steps.f
    x_x, x_v, x_f, v_x, v_v, v_f = steps.one
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f *= d
    v_f *= d
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    faint = faint_below(steps, x_r)
    while n < until:
        u_1 = u_dd[n + 1]
        x_next = x_x * x_r + x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v_next = v_x * x_r + v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_next = -(u_1 + c * v_next + w * x_next + f)
        if d * v_next <= faint or (d * a < 0.0 and d * a_next > 0.0):
            break
        n += 1
        u_0 = u_1
        x_r = x_next
        v_r = v_next
        a = a_next
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r


@compiled
def four_by_four(steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_ahead, v_ahead):
    """Carry the four states up to sample n on, four steps each; gives the sample reached.

    Parameters as in `glide`. Four new states stand when both ends are so fast that no dip fits
    in between; else those stand that come before the first in doubt.
    """
    i = n - 3 - begin
    if begin < 0 or i < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return n
    x_x, x_v, x_f, v_x, v_v, v_f = steps.four
    x_f *= d
    v_f *= d
    m = begin + 3
    x_a, x_b, x_c, x_d = x_out[m + i - 3], x_out[m + i - 2], x_out[m + i - 1], x_out[m + i]
    v_a, v_b, v_c, v_d = v_out[m + i - 3], v_out[m + i - 2], v_out[m + i - 1], v_out[m + i]
    u_0 = u_dd[m + i]
    before = d * v_d
    faint = faint_below(steps, x_d)
    while i + 4 <= until - m:
        x_a, v_a = (
            x_x * x_a + x_v * v_a - (x_ahead[i] + x_f),
            v_x * x_a + v_v * v_a - (v_ahead[i] + v_f),
        )
        x_b, v_b = (
            x_x * x_b + x_v * v_b - (x_ahead[i + 1] + x_f),
            v_x * x_b + v_v * v_b - (v_ahead[i + 1] + v_f),
        )
        x_c, v_c = (
            x_x * x_c + x_v * v_c - (x_ahead[i + 2] + x_f),
            v_x * x_c + v_v * v_c - (v_ahead[i + 2] + v_f),
        )
        x_d, v_d = (
            x_x * x_d + x_v * v_d - (x_ahead[i + 3] + x_f),
            v_x * x_d + v_v * v_d - (v_ahead[i + 3] + v_f),
        )
        u_1, u_2, u_3, u_4 = (
            u_dd[m + i + 1], u_dd[m + i + 2], u_dd[m + i + 3], u_dd[m + i + 4]
        )  # fmt: skip
        change = max(max(abs(u_1 - u_0), abs(u_2 - u_1)), max(abs(u_3 - u_2), abs(u_4 - u_3)))
        after = d * v_d
        dip = steps.steep * change + steps.fast * max(before, abs(after))
        if not min(before, after) > dip + faint:
            x_out[m + i + 1] = x_a
            x_out[m + i + 2] = x_b
            x_out[m + i + 3] = x_c
            v_out[m + i + 1] = v_a
            v_out[m + i + 2] = v_b
            v_out[m + i + 3] = v_c
            d_out[m + i + 1] = d
            d_out[m + i + 2] = d
            d_out[m + i + 3] = d
            doubt = dip * ONE_OF_FOUR + faint
            first = (before > doubt) * (d * v_a > doubt)
            second = first * (d * v_b > doubt)
            return m + i + first + second + second * (d * v_c > doubt)
        x_out[m + i + 1] = x_a
        x_out[m + i + 2] = x_b
        x_out[m + i + 3] = x_c
        x_out[m + i + 4] = x_d
        v_out[m + i + 1] = v_a
        v_out[m + i + 2] = v_b
        v_out[m + i + 3] = v_c
        v_out[m + i + 4] = v_d
        d_out[m + i + 1] = d
        d_out[m + i + 2] = d
        d_out[m + i + 3] = d
        d_out[m + i + 4] = d
        before = after
        u_0 = u_4
        i += 4
    return m + i


@compiled
def creep(steps, u_dd, n, until, x_r, v_r, a, d, x_out, v_out, d_out):
    """Slide with a faint velocity until sample `until` or a step that may hold an event.

    Parameters and returns as in `glide`, with the relative acceleration a [m/s²] at the sample.

    Notes
    -----
    Differentiated, the equation of motion is v" + c v' + w v = -dü/dt. Neither ü, the spring
    nor friction occurs in it, so v and a keep their relative accuracy however small they are
    beside the forces. The position follows from the affine map as ever.
    """
    c, w = steps.c, steps.w
    y, y_d, Y, _ = steps.whole
    x_x, x_v, x_f, _, _, _ = steps.one
    x_f *= d
    while n < until and LEAST < d * v_r <= faint_below(steps, x_r):
        r = (u_dd[n] - u_dd[n + 1]) / steps.dt
        v_next = v_r * y_d + (a + c * v_r) * y + r * Y
        a_next = a * y_d + (r - w * v_r) * y
        if d * v_next <= 0.0 or (d * a < 0.0 and d * a_next > 0.0):
            break
        x_r = x_x * x_r + x_v * v_r - (steps.x_0 * u_dd[n] + steps.x_1 * u_dd[n + 1] + x_f)
        v_r = v_next
        a = a_next
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, a


@inlined
def lifted(v_r, a):
    """Return v_r and a, multiplied by a power of two where they are about to underflow.

    While the base is silent only their ratio decides whether and when the mass stops, and
    what is lifted is still far below any rounding.
    """
    lift = LIFT if max(abs(v_r), abs(a)) <= LEAST else 1.0
    return v_r * lift, a * lift


# One step that may hold events: stops, break-aways, reversals, any number of each.


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


@inlined
def coast(steps, v, a, r, h):
    """Give distance and velocity after sliding for a time h, parameters as in `locate_stop`."""
    if steps.brief:
        q = series(steps.tail, v, a, r - steps.c * a - steps.w * v)
        return distance(q, h), speed(q, h)
    q = longer_series(steps.tail, steps.more, v, a, r - steps.c * a - steps.w * v)
    return distance(q, h), speed(q, h)


@inlined
def rate_after(steps, v, a, r, h):
    """Return the acceleration after sliding for a time h, parameters as in `locate_stop`."""
    j = r - steps.c * a - steps.w * v
    if steps.brief:
        return rate(series(steps.tail, v, a, j), h)
    return rate(longer_series(steps.tail, steps.more, v, a, j), h)


@inlined
def stop_within(steps, v, a, r, v_end, h):
    """Give the first stop in a short step, or in what is left of it.

    Parameters
    ----------
    v, a, r, h : float
        As in `locate_stop`.
    v_end : float
        Velocity at the end, should the mass not stop before [m/s].

    Returns
    -------
    stop, way : float
        When it stops [s] and how far it slides until then [m]; infinity when it does not.
    """
    c, w = steps.c, steps.w
    j = r - c * a - w * v
    if steps.brief:
        stop, way = stop_by_series(series(steps.tail, v, a, j), v_end, h)
    else:
        stop, way = stop_by_series(longer_series(steps.tail, steps.more, v, a, j), v_end, h)
    if stop > 0.0:
        return stop, way
    return stop_by_flow(c, w, v, a, r, v_end, h)


@inlined
def stop_by_series(q, v_end, h):
    """Give what `stop_within` does of a short stretch; -1 leaves it to the general way."""
    if v_end > 0.0 and (q[1] >= 0.0 or rate(q, h) <= 0.0):
        return NEVER, 0.0
    if q[0] > 0.0 and v_end <= 0.0:
        return fall(q, h)
    return -1.0, 0.0


@compiled
def stop_by_flow(c, w, v, a, r, v_end, h):
    """Give what `stop_within` does of a stretch of any length, in the general way."""
    stop = locate_stop(c, w, v, a, r, h)
    if stop == NEVER:
        if v_end > 0.0 or v == 0.0:
            return NEVER, 0.0
        stop = h
    y, _, Y, YY = flow(c, w, stop)
    return stop, v * y + (a + c * v) * Y + r * YY


# A step too long for a series, walked in parts up to the one that holds its first stop.


MOST_PARTS = 64
"""Parts, each no longer than a fine step, that are walked at most: a stop that is farther off
is left to the general way. That takes long for each swing, but a creep at one stride."""


class Parts(NamedTuple):
    """What a step too long for a series is walked in.

    Attributes
    ----------
    h, h_short : float
        Lengths of a part, which holds one extremum of v_r at most, and of a short one [s].
    whole, short : tuple of float, shape (4,)
        `flow` over them.
    """

    h: float
    h_short: float
    whole: tuple[float, float, float, float]
    short: tuple[float, float, float, float]


@compiled
def parts_of(steps):
    """Give the parts of such steps."""
    c, w = steps.c, steps.w
    h = steps.dt if steps.fine else FINE / rate_of(c, w)
    h_short = h / max(math.ceil((c + math.sqrt(w)) * h / SHORT), 1)
    return Parts(h, h_short, flow(c, w, h), flow(c, w, h_short))


@inlined
def slide_on(steps, parts, v, a, r, h):
    """Slide up to the first stop in a long step, or in what is left of it, or to its end.

    Parameters
    ----------
    v, a, r, h : float
        As in `locate_stop`.

    Returns
    -------
    stop, way, v_end, a_end : float
        When it stops [s], infinity when it does not; how far it slides until then, or to the
        end [m]; velocity [m/s] and, at the end, acceleration there [m/s²].
    """
    c, w = steps.c, steps.w
    s, way = 0.0, 0.0
    until = 0.0 if never_stops(c, w, v, a, r) else min(h, MOST_PARTS * parts.h)
    while s < until:
        s, far, v, a = pass_parts(steps, parts, v, a, r, s, until)
        way += far
        length = min(parts.h_short, until - s)
        q = longer_series(steps.tail, steps.more, v, a, r - c * a - w * v)
        v_end = speed(q, length)
        stop, far = stop_by_series(q, v_end, length)
        if not stop > 0.0:
            stop, far = stop_by_flow(c, w, v, a, r, v_end, length)
        if stop != NEVER:
            return s + stop, way + far, 0.0, a
        way += distance(q, length)
        a = rate(q, length)
        v = max(v_end, 0.0)
        s += length
    left = h - until
    if left > 0.0:
        y, y_d, Y, YY = steps.whole if left == steps.dt else flow(c, w, left)
        p = a + c * v
        v_end = v * y_d + p * y + r * Y
        if not never_stops(c, w, v, a, r):
            stop, far = stop_by_flow(c, w, v, a, r, v_end, left)
            if stop != NEVER:
                return until + stop, way + far, 0.0, a
        way += v * y + p * Y + r * YY
        v, a = v_end, a * y_d + (r - w * v) * y
    return NEVER, way, v, a


@inlined
def pass_parts(steps, parts, v, a, r, s, h):
    """Pass the parts from time s up to h that hold no stop; gives s, the way, v and a there."""
    c, w = steps.c, steps.w
    length, (y, y_d, Y, YY) = parts.h, parts.whole
    way, coarse = 0.0, True
    while True:
        p = a + c * v
        v_1 = v * y_d + p * y + r * Y
        a_1 = a * y_d + (r - w * v) * y
        if s + length > h or v_1 <= 0.0 or (a < 0.0 < a_1 and not never_stops(c, w, v, a, r)):
            if not coarse:
                return s, way, v, a
            coarse = False
            length, (y, y_d, Y, YY) = parts.h_short, parts.short
            continue
        way += v * y + p * Y + r * YY
        v, a = v_1, a_1
        s += length


# On a spring contact of constant limit: hold and yield.


def march_joint(
    plant, law, u_dd, dt, n, end, x_r, v_r, x_0, mode, x_out, v_out, d_out, trail, at, log,
    count,
):  # fmt: skip
    """March from sample n to sample `end`, or until trail or log is nearly full.

    Parameters
    ----------
    law : Slider
        Of constant normal force.
    x_0 : float
        Where the contact carries no force [m].
    mode : int
        Of the contact, as in `touch`.
    d_out : array, shape (samples,)
        Written: in which direction the contact yields, 0 where it holds.
    trail, at : Trail, int
        Where to write each beginning of a mode, and how many are written.
    log, count : Log, int
        Where to write changes of mode, and how many are written.
    others
        As in `march`.

    Returns
    -------
    n, x_r, v_r, x_0, mode, at, count
        The sample reached, the state there, and what is written; `count` is negative when one
        step holds too many events.
    """
    bare = whole_steps(plant, dt)
    sprung = whole_steps(Plant(plant.m, plant.k_x + law.k_t, plant.b), dt)
    # A contact that yields holds with the force it has, so a faint velocity decides nothing.
    yields = steps_of(plant, law, dt)._replace(faint_f=0.0, faint_x=0.0)
    ahead = held(np.empty(STRETCH)), held(np.empty(STRETCH))
    return march_joint_on(
        plant, law, bare, sprung, yields, u_dd, n, end, x_r, v_r, x_0, mode,
        x_out, v_out, d_out, trail, at, log, count, *ahead,
    )  # fmt: skip


@compiled
def march_joint_on(
    plant, law, bare, sprung, yields, u_dd, n, end, x_r, v_r, x_0, mode, x_out, v_out, d_out,
    trail, at, log, count, x_ahead, v_ahead,
):  # fmt: skip
    """March stretch by stretch, as `march_joint` says; the last two are scratch for one."""
    reach = law.F_fk / law.k_t
    stiffness, f_k = law.k_t / plant.m, law.F_fk / plant.m
    begin, until = n, n
    full = len(trail.n) - ROOM
    while n < end and at <= full and 0 <= count <= full:
        if n >= until:
            begin, until = -1, min(n - n % STRETCH + STRETCH, end)
        if mode == HOLD and v_r != 0.0 and sprung.fine:
            n, x_r, v_r = skim(
                sprung, u_dd, n, until, x_r, v_r, -stiffness * x_0, x_0 - reach, x_0 + reach,
                x_out, v_out, d_out,
            )  # fmt: skip
        elif mode * v_r > 0.0 and yields.fine:
            if begin < 0:
                begin = n
                look_ahead(yields.x_base, u_dd[n : until + 1], x_ahead)
                look_ahead(yields.v_base, u_dd[n : until + 1], v_ahead)
            n, x_r, v_r = glide(
                yields, u_dd, n, until, x_r, v_r, mode, x_out, v_out, d_out, begin, x_ahead,
                v_ahead
            )  # fmt: skip
        if n < until:
            x_r, v_r, x_0, mode, at, count = through(
                plant, reach, stiffness, f_k, bare, sprung, u_dd[n], u_dd[n + 1], n, x_r, v_r,
                x_0, mode, trail, at, log, count,
            )  # fmt: skip
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = 0 if holds(mode) else mode
    return n, x_r, v_r, x_0, mode, at, count


@inlined
def skim(steps, u_dd, n, until, x_r, v_r, f, low, high, x_out, v_out, d_out):
    """Take whole steps while the contact holds: between two limits of x_r, there and back.

    Parameters and returns as in `glide`, with the constant contact force per mass f [m/s²], and
    the limits low and high [m] in place of the direction; `steps` is a `Whole`.

    Notes
    -----
    A fine step holds one extremum of v_r at most. So a velocity that falls as the step begins
    is no greater than then until the mass turns, and no greater than at the end once it has
    turned twice: where that takes x_r to no limit, its turns need not be known.
    """
    c, w, dt, one = steps.c, steps.w, steps.dt, steps.one
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f, v_f = one.x_f * f, one.v_f * f
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    way = 1.0 if v_r > 0.0 else -1.0
    while n < until:
        u_1 = u_dd[n + 1]
        x = one.x_x * x_r + one.x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v = one.v_x * x_r + one.v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_end = -(u_1 + c * v + w * x + f)
        if way * v <= 0.0 or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            if v == 0.0 or not low < x < high:
                break
            turns = way * v < 0.0
            inside = low < x_r + v_r * dt < high and (turns or low < x - v * dt < high)
            if way * a >= 0.0 or not inside:
                if not turns:
                    break
                r = -way * (u_1 - u_0) * steps.per_dt
                s, far = turn_of(steps, way * v_r, way * a, r, way * v, way * a_end, dt)
                if s < 0.0 or not low < x_r + way * far < high:
                    break
            if turns:
                way = -way
        n += 1
        u_0, x_r, v_r, a = u_1, x, v, a_end
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = 0
    return n, x_r, v_r


@inlined
def through(
    plant, reach, stiffness, f_k, bare, sprung, u_0, u_1, n, x_r, v_r, x_0, mode, trail, at,
    log, count
):  # fmt: skip
    """Carry the state through one step that may hold any number of events.

    `stiffness` and `f_k` are k_t [1/s²] and F_fk [m/s²] per mass, the rest as in `march_joint`.
    """
    h, c = bare.dt, bare.c
    slope = (u_1 - u_0) / h
    begin = 0.0
    room = count + ROOM
    # The force of the contact does not jump, so neither does a: what takes no time keeps it.
    a, stopped = math.nan, 0
    while count < room:
        left = h - begin
        if left <= 0.0:
            return x_r, v_r, x_0, mode, at, count
        holding = holds(mode)
        w, f = (sprung.w, -stiffness * x_0) if holding else (bare.w, mode * f_k)
        if a != a:
            a = -(u_0 + slope * begin + c * v_r + w * x_r + f)
            # A velocity that has just fallen to zero does not rise by the rounding of forces.
            a = 0.0 if stopped * a > 0.0 else a
        way = onset(v_r, a, -slope)
        if way == 0:
            return x_r, v_r, x_0, mode, at, count
        v, push, r = way * v_r, way * a, -way * slope
        if holding:
            gap = reach - way * (x_r - x_0) if mode != way * POISED else 0.0
            stop, far, v_end = (
                next_stop(sprung, v, push, r, left) if gap > 0.0 else (0.0, 0.0, v)
            )
            if far >= gap:
                s, x_next = 0.0, x_r
                if gap > 0.0:
                    s, v = next_crossing(sprung, v, push, r, gap, far, v_end, min(stop, left))
                    x_next = x_0 + way * reach
                    a, stopped = math.nan, 0
                begin = min(begin + s, h)
                x_r, v_r, mode = x_next, way * v, way
                at = mark(trail, at, n, begin, x_r, v_r, x_0, mode)
                F_L = limit_force(plant, x_r, u_0 + slope * begin)
                count = note(log, count, n, begin, way * SLIP, x_r, F_L)
                continue
            mode = HOLD
        elif way != mode:
            stop, far, v_end = 0.0, 0.0, 0.0
        else:
            stop, far, v_end = next_stop(bare, v, push, r, left)
        x_r += way * far
        v_r = way * v_end
        if stop == NEVER:
            return x_r, v_r, x_0, mode, at, count
        begin = min(begin + stop, h)
        if stop > 0.0:
            a, stopped = math.nan, way
        if not holding:
            F_L = limit_force(plant, x_r, u_0 + slope * begin)
            x_0, mode = x_r - mode * reach, mode * POISED
            at = mark(trail, at, n, begin, x_r, v_r, x_0, mode)
            count = note(log, count, n, begin, STICK, x_r, F_L)
    return x_r, v_r, x_0, mode, at, -1


# On the way between two end stops.


@compiled
def pass_on(plant, u_dd, dt, n, end, xi, v_r, f, low, high, trail, at, full, z, mode):
    """Take whole steps while the mass goes on in its direction between two limits.

    Parameters
    ----------
    u_dd, dt : array, float
        Base acceleration at the samples [m/s²], and their distance [s].
    n, end : int
        Step to begin with and the one to stop before.
    xi, v_r : float
        State at sample n [m, m/s].
    f, low, high : float
        Constant force per mass against the motion [m/s²], and limits of xi [m].
    trail, at, full : Trail, int, int
        Where to write the steps, how many are written and may be.
    z, mode : float, int
        What is written with each step.

    Returns
    -------
    n, xi, v_r, at
        The first step that wants a closer look, and the state there.
    """
    c, w = plant.b / plant.m, plant.k_x / plant.m
    if rate_of(c, w) * dt > FINE:
        # Only a fine step tells by its ends of a dip of v_r in between.
        return n, xi, v_r, at
    y, _, Y, YY = flow(c, w, dt)
    one = map_of(c, w, 1.0, dt)
    x_1, v_1 = YY / dt, Y / dt
    x_0, v_0 = Y - x_1, y - v_1
    a = -(u_dd[n] + c * v_r + w * xi + f)
    way = 1.0 if v_r > 0.0 else -1.0
    faint = faint_per_force(c, w)
    while n < end and at < full:
        u_0 = u_dd[n]
        u_1 = u_dd[n + 1]
        x = one.x_x * xi + one.x_v * v_r - (x_0 * u_0 + x_1 * u_1 + one.x_f * f)
        v = one.v_x * xi + one.v_v * v_r - (v_0 * u_0 + v_1 * u_1 + one.v_f * f)
        a_end = -(u_1 + c * v + w * x + f)
        slow = way * v <= faint * (abs(f) + w * abs(x))
        if slow or (way * a < 0.0 and way * a_end > 0.0) or not low < x < high:
            break
        at = mark(trail, at, n, 0.0, xi, v_r, z, mode)
        n += 1
        xi, v_r, a = x, v, a_end
    return n, xi, v_r, at
