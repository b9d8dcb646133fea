"""Exact march over sampled base motion with Coulomb friction.

Problem
    Between two samples ü is linear. While the mass slides in one direction or sticks, a step is
    therefore one fixed affine map, and exact. Only a step with an event needs more. Friction
    limits are constant here; `march.march_sines` serves limits that vary.

Method
    1. Steps without events. `advance_stick` covers sticking, `advance_slip` sliding. Each step
       depends on the one before, which limits the throughput. Four consecutive states, each
       advanced by a four-step map, are four independent chains; what the base contributes
       within four steps does not depend on the state and is summed beforehand
       (`advance_slip_by_four`).
    2. Steps with events. `step_through_events` follows any number of events within a step.
       Stops are located in the power series of a short step; a step too long for that is
       divided into substeps up to the one with the first stop.
    3. Creep. Once the base is silent, a mass that creeps to rest has a velocity far below the
       forces from which the affine map computes it. Below a threshold `advance_creep`
       propagates velocity and acceleration by themselves, which keeps their relative accuracy.

No stop is missed
    A fine step holds at most one extremum of v_r, so the acceleration at both ends shows any
    dip of v_r. Four steps at once are accepted only where |v_r| at both ends is above a bound
    on the dip in between. Every other step goes to step 2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drysim.core.compile import as_engine_array, compiled, inlined
from drysim.core.events import (
    MAX_EVENTS_PER_STEP,
    REVERSAL,
    SLIP,
    STICK,
    decision_margin,
    limit_force,
    record_event,
    sign,
    stick_limit,
)
from drysim.core.oscillator import (
    FINE_STEP,
    SHORT_SEGMENT,
    cancellation_threshold,
    characteristic_rate,
    chebyshev_stop,
    flow,
    long_velocity_series,
    series_acceleration,
    series_distance,
    series_velocity,
    slip_steps,
    step_end,
    velocity_series,
)
from drysim.core.roots import (
    NEVER,
    locate_stop,
    never_stops,
)

# Coulomb friction, chunk by chunk.


CHUNK = 256
"""Samples per chunk: a few kilobytes. The chains of four steps restart at each multiple, so
that a march interrupted there continues to the last bit."""

STICK_BLOCK = 16
"""Stuck samples that are tested at once; a few vector registers hold them."""


def march(
    plant, law, u_dd, dt, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count, capacity
):  # fmt: skip
    """March from sample n to sample `end`, or until the log is nearly full.

    Parameters
    ----------
    plant : Plant
    law : CoulombLaw
        With constant limits.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Sample interval [s].
    n, end : int
        First and last sample of this march.
    x_r, v_r : float
        State at sample n [m, m/s].
    d : int
        Direction of sliding at sample n, 0 if stuck.
    a : float
        Relative acceleration at sample n [m/s²] in creep; NaN where x_r and v_r determine it.
    x_out, v_out, d_out : array, shape (samples,)
        Overwritten from n + 1 to the sample reached; values after that, up to `end`, are
        undefined.
    log : EventLog
    count, capacity : int
        Number of events in the log, and its length; `MAX_EVENTS_PER_STEP` entries must be free.

    Returns
    -------
    n, x_r, v_r, d, a, count, closest
        Sample reached and the state there; number of events in the log, negative if one step
        holds too many; smallest relative margin of a stick decision [-]. x_r is NaN if the next
        chunk of samples has values that are not finite.

    Notes
    -----
    A march that continues from the returned state gives the same result as one without
    interruption: to the last bit where n is a multiple of `CHUNK` or the log was full, to
    rounding elsewhere.
    """
    base_sums = as_engine_array(np.empty(CHUNK)), as_engine_array(np.empty(CHUNK))
    steps = slip_steps(plant, law, dt)
    # The type of `substeps` selects one of two compiled versions of the kernel.
    substeps = () if steps.short else make_substeps(steps)
    return march_chunks(
        plant, law, steps, substeps, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out,
        log, count, capacity, *base_sums,
    )  # fmt: skip


@compiled
def march_chunks(
    plant, law, steps, substeps, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count,
    capacity, x_base_sums, v_base_sums,
):  # fmt: skip
    """Run `march` chunk by chunk; the last two arguments are work arrays of length `CHUNK`."""
    closest = math.inf
    full = capacity - MAX_EVENTS_PER_STEP
    while n < end and 0 <= count <= full and x_r == x_r:
        if a == a:
            n, x_r, v_r, d, a, count, margin = march_creep(
                plant, law, steps, substeps, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out,
                log, count, full,
            )  # fmt: skip
        else:
            n, x_r, v_r, d, a, count, margin = march_regular(
                plant,
                law,
                steps,
                substeps,
                u_dd,
                n,
                end,
                x_r,
                v_r,
                d,
                x_out,
                v_out,
                d_out,
                log,
                count,
                full,
                x_base_sums,
                v_base_sums,
            )
        closest = min(closest, margin)
    return n, x_r, v_r, d, a, count, closest


@compiled
def march_regular(
    plant,
    law,
    steps,
    substeps,
    u_dd,
    n,
    end,
    x_r,
    v_r,
    d,
    x_out,
    v_out,
    d_out,
    log,
    count,
    full,
    x_base_sums,
    v_base_sums,
):
    """March until v_r is below the cancellation threshold; parameters as in `march_chunks`."""
    begin, until = n, n
    closest = math.inf
    while n < end and 0 <= count <= full:
        if n >= until:
            begin, until = -1, min(n - n % CHUNK + CHUNK, end)
            if not all_finite(u_dd[n : until + 1]):
                x_r = math.nan
                break
        if d == 0:
            n = advance_stick(plant, law, u_dd, n, until, x_r, x_out, v_out, d_out)
        elif steps.fine:
            if begin < 0:
                begin = n
                sum_base_motion(steps.x_base, u_dd[n : until + 1], x_base_sums)
                sum_base_motion(steps.v_base, u_dd[n : until + 1], v_base_sums)
            n, x_r, v_r = advance_slip(
                steps,
                u_dd,
                n,
                until,
                x_r,
                v_r,
                d,
                x_out,
                v_out,
                d_out,
                begin,
                x_base_sums,
                v_base_sums,
            )
        if n < until:
            before = count
            x_r, v_r, a, d, count, closest = step_through_events(
                plant,
                law,
                steps,
                substeps,
                (),
                u_dd[n],
                u_dd[n + 1],
                n,
                x_r,
                v_r,
                d,
                log,
                count,
                closest,
            )
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = d
            # No event: v_r may have fallen below the cancellation threshold.
            if count == before and d != 0 and abs(v_r) <= cancellation_threshold(steps, x_r):
                if a != a:
                    a = -(u_dd[n] + steps.c * v_r + steps.w * x_r + d * steps.f)
                return n, x_r, v_r, d, a, count, closest
    return n, x_r, v_r, d, math.nan, count, closest


@compiled
def march_creep(
    plant, law, steps, substeps, u_dd, n, end, x_r, v_r, d, a, x_out, v_out, d_out, log, count,
    full,
):  # fmt: skip
    """March in creep, with v_r and a propagated; parameters as in `march_chunks`."""
    closest = math.inf
    while n < end and a == a and 0 <= count <= full:
        until = min(n - n % CHUNK + CHUNK, end)
        if not all_finite(u_dd[n : until + 1]):
            x_r = math.nan
            break
        v_r, a = rescale(v_r, a)
        if steps.fine:
            n, x_r, v_r, a = advance_creep(
                steps, u_dd, n, until, x_r, v_r, a, d, x_out, v_out, d_out
            )
        if n < until:
            x_r, v_r, a, d, count, closest = step_through_events(
                plant, law, steps, substeps, (a,), u_dd[n], u_dd[n + 1], n, x_r, v_r, d, log,
                count, closest,
            )  # fmt: skip
            n += 1
            x_out[n] = x_r
            v_out[n] = v_r
            d_out[n] = d
    return n, x_r, v_r, d, a, count, closest


@compiled
def all_finite(u_dd):
    """Return whether all values are finite."""
    finite = 0
    for k in range(len(u_dd)):
        finite += abs(u_dd[k]) < math.inf
    return finite == len(u_dd)


@inlined
def advance_stick(plant, law, u_dd, n, until, x_r, x_out, v_out, d_out):
    """Stick up to sample `until`, or to the step at whose end |F_L| exceeds the limit."""
    F_k = plant.k_x * x_r
    hold = stick_limit(law.F_fs, F_k)
    if n < 0:
        # Never true; tells the compiler that no index counts from the end.
        return n
    while n + STICK_BLOCK <= until and stays_stuck(
        plant.m, F_k, hold, u_dd[n + 1 : n + 1 + STICK_BLOCK]
    ):
        for k in range(STICK_BLOCK):
            x_out[n + 1 + k] = x_r
        for k in range(STICK_BLOCK):
            v_out[n + 1 + k] = 0.0
        for k in range(STICK_BLOCK):
            d_out[n + 1 + k] = 0
        n += STICK_BLOCK
    while n < until and abs(plant.m * u_dd[n + 1] + F_k) <= hold:
        n += 1
        x_out[n] = x_r
        v_out[n] = 0.0
        d_out[n] = 0
    return n


@compiled
def stays_stuck(m, F_k, hold, u_dd):
    """Return whether |F_L| is within the limit at all of these samples."""
    beyond = 0
    for k in range(len(u_dd)):
        beyond += abs(m * u_dd[k] + F_k) > hold
    return beyond == 0


# Sliding without events.


ONE_STEP_DIP = 0.0625
"""Largest dip within one step relative to that within four: it grows with the
square of the length."""

UNDERFLOW_SPEED, RESCALING = 1e-250, 2.0**300
"""Speed below which velocity and acceleration are multiplied by RESCALING, see `rescale`."""


@compiled
def sum_base_motion(base, u_dd, base_sums):
    """Compute what the base contributes in every four consecutive steps of a chunk.

    `base` is `SlipSteps.x_base` or `v_base`, and `u_dd` holds the chunk and the sample after
    it. Element i of `base_sums` is for the four steps from sample i on.
    """
    p_0, p_1, p_2, p_3, p_4 = base
    for i in range(len(u_dd) - 4):
        base_sums[i] = (
            p_0 * u_dd[i] + p_1 * u_dd[i + 1] + p_2 * u_dd[i + 2] + p_3 * u_dd[i + 3]
            + p_4 * u_dd[i + 4]
        )  # fmt: skip


@inlined
def advance_slip(
    steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out, begin, x_base_sums, v_base_sums
):
    """Slide up to sample `until`, or to a step that may hold an event or reach the threshold.

    Parameters
    ----------
    steps : SlipSteps
        With `fine` steps.
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    n, until : int
        Sample to start from, and the last one.
    x_r, v_r, d
        State at sample n [m, m/s], and direction of sliding.
    x_out, v_out, d_out : array, shape (samples,)
        Overwritten from n + 1 to the sample reached; up to three more are undefined.
    begin : int
        Sample, not after n, at which `x_base_sums` and `v_base_sums` begin.
    x_base_sums, v_base_sums : array, shape (CHUNK,)
        Contribution of the base in four steps, from `sum_base_motion`.

    Returns
    -------
    n, x_r, v_r
        Sample reached and the state there.
    """
    while n < until:
        fourth = n + 4 if steps.steep < math.inf else until
        n, x_r, v_r = advance_slip_by_one(
            steps, u_dd, n, min(fourth, until), x_r, v_r, d, x_out, v_out, d_out
        )
        if n < fourth:
            break
        n = advance_slip_by_four(
            steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_base_sums, v_base_sums
        )
        x_r = x_out[n]
        v_r = v_out[n]
    return n, x_r, v_r


@inlined
def advance_slip_by_one(steps, u_dd, n, until, x_r, v_r, d, x_out, v_out, d_out):
    """Slide step by step; parameters and returns as in `advance_slip`."""
    c, w, f = steps.c, steps.w, d * steps.f
    x_x, x_v, x_f, v_x, v_v, v_f = steps.step_map
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f *= d
    v_f *= d
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    threshold = cancellation_threshold(steps, x_r)
    while n < until:
        u_1 = u_dd[n + 1]
        x_next = x_x * x_r + x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v_next = v_x * x_r + v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_next = -(u_1 + c * v_next + w * x_next + f)
        # At or below the threshold, or a minimum of the speed within the step.
        if d * v_next <= threshold or (d * a < 0.0 and d * a_next > 0.0):
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
def advance_slip_by_four(
    steps, u_dd, n, until, d, x_out, v_out, d_out, begin, x_base_sums, v_base_sums
):
    """Advance the last four states by four steps each; return the sample reached.

    Parameters as in `advance_slip`. All four new states are accepted if |v_r| at both ends is
    above the bound on a dip in between; else those before the first that may hold one.
    """
    i = n - 3 - begin
    if begin < 0 or i < 0:
        # Never true; tells the compiler that no index counts from the end.
        return n
    x_x, x_v, x_f, v_x, v_v, v_f = steps.four_step_map
    x_f *= d
    v_f *= d
    m = begin + 3
    x_a, x_b, x_c, x_d = x_out[m + i - 3], x_out[m + i - 2], x_out[m + i - 1], x_out[m + i]
    v_a, v_b, v_c, v_d = v_out[m + i - 3], v_out[m + i - 2], v_out[m + i - 1], v_out[m + i]
    u_0 = u_dd[m + i]
    before = d * v_d
    threshold = cancellation_threshold(steps, x_d)
    while i + 4 <= until - m:
        # Four independent chains: samples m + i - 3 to m + i advance by four steps each.
        x_a, v_a = (
            x_x * x_a + x_v * v_a - (x_base_sums[i] + x_f),
            v_x * x_a + v_v * v_a - (v_base_sums[i] + v_f),
        )
        x_b, v_b = (
            x_x * x_b + x_v * v_b - (x_base_sums[i + 1] + x_f),
            v_x * x_b + v_v * v_b - (v_base_sums[i + 1] + v_f),
        )
        x_c, v_c = (
            x_x * x_c + x_v * v_c - (x_base_sums[i + 2] + x_f),
            v_x * x_c + v_v * v_c - (v_base_sums[i + 2] + v_f),
        )
        x_d, v_d = (
            x_x * x_d + x_v * v_d - (x_base_sums[i + 3] + x_f),
            v_x * x_d + v_v * v_d - (v_base_sums[i + 3] + v_f),
        )
        u_1, u_2, u_3, u_4 = (
            u_dd[m + i + 1], u_dd[m + i + 2], u_dd[m + i + 3], u_dd[m + i + 4]
        )  # fmt: skip
        change = max(max(abs(u_1 - u_0), abs(u_2 - u_1)), max(abs(u_3 - u_2), abs(u_4 - u_3)))
        after = d * v_d
        dip = steps.steep * change + steps.fast * max(before, abs(after))
        if not min(before, after) > dip + threshold:
            # Keep the states up to the first step that may hold a dip, without branches.
            x_out[m + i + 1] = x_a
            x_out[m + i + 2] = x_b
            x_out[m + i + 3] = x_c
            v_out[m + i + 1] = v_a
            v_out[m + i + 2] = v_b
            v_out[m + i + 3] = v_c
            d_out[m + i + 1] = d
            d_out[m + i + 2] = d
            d_out[m + i + 3] = d
            one_step_threshold = dip * ONE_STEP_DIP + threshold
            first = (before > one_step_threshold) * (d * v_a > one_step_threshold)
            second = first * (d * v_b > one_step_threshold)
            return m + i + first + second + second * (d * v_c > one_step_threshold)
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
def advance_creep(steps, u_dd, n, until, x_r, v_r, a, d, x_out, v_out, d_out):
    """Slide in creep up to sample `until`, or to a step that may hold an event.

    Parameters and returns as in `advance_slip`, with the relative acceleration a [m/s²] at the
    sample.

    Notes
    -----
    The derivative of the equation of motion is v" + c v' + w v = -dü/dt. It contains neither ü
    nor the spring force nor friction, so v and a keep their relative accuracy however small
    they are compared with these forces. The displacement follows from the affine map as usual.
    """
    c, w = steps.c, steps.w
    y, y_d, Y, _ = steps.whole
    x_x, x_v, x_f, _, _, _ = steps.step_map
    x_f *= d
    while n < until and UNDERFLOW_SPEED < d * v_r <= cancellation_threshold(steps, x_r):
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
def rescale(v_r, a):
    """Return v_r and a, multiplied by a power of two where they are about to underflow.

    While the base is silent only their ratio decides whether and when the mass stops, and the
    scaled values are still far below the rounding of x_r.
    """
    scale = RESCALING if max(abs(v_r), abs(a)) <= UNDERFLOW_SPEED else 1.0
    return v_r * scale, a * scale


# One step with events: any number of stops, break-aways and reversals.


MIN_REMAINDER = 1e-3
"""Where the update after a reversal leaves less than this share of the velocity, the velocity
is computed anew instead, because the sum cancels."""


@inlined
def step_through_events(
    plant, law, steps, substeps, carried, u_0, u_1, n, x_r, v_r, d, log, count, closest
):  # fmt: skip
    """Advance the state through a step with any number of events.

    Parameters
    ----------
    plant, law, steps
    substeps : Substeps or tuple
        Of such steps; empty where a series serves the whole step.
    carried : tuple of float
        Relative acceleration at the start of the step in creep [m/s²]; empty where x_r and v_r
        determine it.
    u_0, u_1 : float
        ü at both ends of the step [m/s²].
    n : int
        Sample at the start of the step.
    x_r, v_r : float
        State at the start of the step [m, m/s].
    d : int
        Direction of sliding, 0 if stuck.
    log : EventLog
    count : int
        Number of events in the log; `MAX_EVENTS_PER_STEP` entries must be free.
    closest : float
        Smallest relative margin of a stick decision so far [-].

    Returns
    -------
    x_r, v_r, a, d, count, closest
        At the end of the step. a [m/s²] is known in creep and after a long step, else NaN.
        `count` is negative if the step holds too many events.

    Notes
    -----
    `x_end` and `v_end` are the state at the end of the step if no further event follows. A
    reversal adds the response to the jump of the friction force in the rest of the step,
    because the motion between events is linear. In a long step `slip_long_step` returns
    this state as well.
    """
    h, f = steps.dt, steps.f
    max_count = count + MAX_EVENTS_PER_STEP
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
        if len(substeps) == 0:
            distance, v_end = slip_by_series(steps, d * v_r, d * a, -d * slope, h)
            x_end, v_end = x_r + d * distance, d * v_end
    while count < max_count:
        if d == 0:
            F_L = limit_force(plant, x_r, u_1)
            if abs(F_L) <= stick_limit(law.F_fs, plant.k_x * x_r):
                return x_r, 0.0, math.nan, 0, count, closest
            # Break-away: F_L is linear in time, so the time at the limit is a quotient.
            d = -sign(F_L)
            F_L = -d * law.F_fs
            meets = (F_L - limit_force(plant, x_r, u_0)) / (plant.m * slope)
            begin = min(max(meets, begin), h)
            count = record_event(log, count, n, begin, d * SLIP, x_r, F_L)
            a = d * (law.F_fs - law.F_fk) * per_m
            v_r = 0.0
            if len(substeps) == 0:
                distance, v_end = slip_by_series(steps, 0.0, d * a, -d * slope, h - begin)
                x_end, v_end = x_r + d * distance, d * v_end
        if len(substeps) == 0:
            stop, distance = stop_in_short_step(
                steps, d * v_r, d * a, -d * slope, d * v_end, h - begin
            )
        else:
            stop, distance, v_end, a_end = slip_long_step(
                steps, substeps, d * v_r, d * a, -d * slope, h - begin
            )
            x_end, v_end = x_r + d * distance, d * v_end
        if stop == NEVER:
            # The search and the end state round differently where v_r is next to zero.
            if d * v_end < 0.0:
                v_end = 0.0
            if len(substeps) == 0:
                if len(carried) == 0:
                    return x_end, v_end, math.nan, d, count, closest
                a_end = acceleration_by_series(steps, d * v_r, d * a, -d * slope, h - begin)
            if abs(v_end) > cancellation_threshold(steps, x_end):
                return x_end, v_end, math.nan, d, count, closest
            return x_end, v_end, d * a_end, d, count, closest
        # A stop: Eq. (9) decides between stick and slip.
        x_r += d * distance
        v_r = 0.0
        begin = min(begin + stop, h)
        F_L = limit_force(plant, x_r, u_0 + slope * begin)
        closest = min(closest, decision_margin(F_L, law.F_fs))
        if abs(F_L) <= stick_limit(law.F_fs, plant.k_x * x_r):
            d = 0
            count = record_event(log, count, n, begin, STICK, x_r, F_L)
            continue
        reverses = d * F_L > 0.0
        jump = 2.0 * d * f
        d = -sign(F_L)
        a = -(F_L + d * law.F_fk) * per_m
        count = record_event(log, count, n, begin, d * REVERSAL, x_r, F_L)
        if reverses and len(substeps) == 0:
            distance, v = slip_by_series(steps, 0.0, jump, 0.0, h - begin)
            x_end += distance
            v_end += v
            if abs(v_end) < MIN_REMAINDER * abs(v):
                distance, v_end = slip_by_series(steps, 0.0, d * a, -d * slope, h - begin)
                x_end, v_end = x_r + d * distance, d * v_end
    return x_r, v_r, a, d, -1, closest


@inlined
def slip_by_series(steps, v, a, r, h):
    """Return distance and velocity after sliding for h; parameters as in `locate_stop`."""
    if steps.brief:
        q = velocity_series(steps.factors, v, a, r - steps.c * a - steps.w * v)
        return series_distance(q, h), series_velocity(q, h)
    q = long_velocity_series(steps.factors, v, a, r - steps.c * a - steps.w * v)
    return series_distance(q, h), series_velocity(q, h)


@inlined
def acceleration_by_series(steps, v, a, r, h):
    """Return the acceleration after sliding for h; parameters as in `locate_stop`."""
    j = r - steps.c * a - steps.w * v
    if steps.brief:
        return series_acceleration(velocity_series(steps.factors, v, a, j), h)
    return series_acceleration(long_velocity_series(steps.factors, v, a, j), h)


@inlined
def stop_in_short_step(steps, v, a, r, v_end, h):
    """Return the first stop in a short step, or in the rest of one.

    Parameters
    ----------
    v, a, r, h : float
        As in `locate_stop`.
    v_end : float
        Velocity at h if the mass does not stop before [m/s].

    Returns
    -------
    stop, path : float
        Time of the stop [s], infinity for none, and distance until then [m].
    """
    c, w = steps.c, steps.w
    j = r - c * a - w * v
    if steps.brief:
        stop, distance = stop_by_series(velocity_series(steps.factors, v, a, j), v_end, h)
    else:
        stop, distance = stop_by_series(long_velocity_series(steps.factors, v, a, j), v_end, h)
    if stop > 0.0:
        return stop, distance
    return stop_by_flow(c, w, v, a, r, v_end, h)


@inlined
def stop_by_series(q, v_end, h):
    """Return `stop_in_short_step` by the series; a time of -1 if the series does not decide."""
    if v_end > 0.0 and (q[1] >= 0.0 or series_acceleration(q, h) <= 0.0):
        return NEVER, 0.0
    if q[0] > 0.0 and v_end <= 0.0:
        return chebyshev_stop(q, h)
    return -1.0, 0.0


@compiled
def stop_by_flow(c, w, v, a, r, v_end, h):
    """Return `stop_in_short_step` for any length, by `locate_stop`."""
    stop = locate_stop(c, w, v, a, r, h)
    if stop == NEVER:
        if v_end > 0.0 or v == 0.0:
            return NEVER, 0.0
        stop = h
    y, _, Y, YY = flow(c, w, stop)
    return stop, v * y + (a + c * v) * Y + r * YY


# A step too long for a series, divided into substeps up to the first stop.


MAX_SUBSTEPS = 64
"""Most substeps of a long step; `locate_stop` searches the rest. It tests every extremum in
turn, but covers creep in one step."""


class Substeps(NamedTuple):
    """Division of a step that is too long for a series.

    Attributes
    ----------
    h, h_short : float
        Length of a substep, which holds at most one extremum of v_r, and of a short one, which
        a series serves [s].
    whole, short : tuple of float, shape (4,)
        `flow` over each.
    """

    h: float
    h_short: float
    whole: tuple[float, float, float, float]
    short: tuple[float, float, float, float]


@compiled
def make_substeps(steps):
    """Return the division of such steps."""
    c, w = steps.c, steps.w
    h = steps.dt if steps.fine else FINE_STEP / characteristic_rate(c, w)
    h_short = h / max(math.ceil((c + math.sqrt(w)) * h / SHORT_SEGMENT), 1)
    return Substeps(h, h_short, flow(c, w, h), flow(c, w, h_short))


@inlined
def slip_long_step(steps, substeps, v, a, r, h):
    """Slide to the first stop in a long step, or in the rest of one, or to its end.

    Parameters
    ----------
    v, a, r, h : float
        As in `locate_stop`.

    Returns
    -------
    stop, distance, v_end, a_end : float
        Time of the stop [s], infinity for none; distance until then or until the end [m];
        velocity [m/s] and, at the end, acceleration there [m/s²].
    """
    c, w = steps.c, steps.w
    s, distance = 0.0, 0.0
    until = 0.0 if never_stops(c, w, v, a, r) else min(h, MAX_SUBSTEPS * substeps.h)
    while s < until:
        s, path, v, a = skip_substeps(steps, substeps, v, a, r, s, until)
        distance += path
        length = min(substeps.h_short, until - s)
        q = long_velocity_series(steps.factors, v, a, r - c * a - w * v)
        v_end = series_velocity(q, length)
        stop, path = stop_by_series(q, v_end, length)
        if not stop > 0.0:
            stop, path = stop_by_flow(c, w, v, a, r, v_end, length)
        if stop != NEVER:
            return s + stop, distance + path, 0.0, a
        distance += series_distance(q, length)
        a = series_acceleration(q, length)
        v = max(v_end, 0.0)
        s += length
    left = h - until
    if left > 0.0:
        y, y_d, Y, YY = steps.whole if left == steps.dt else flow(c, w, left)
        p = a + c * v
        v_end = v * y_d + p * y + r * Y
        if not never_stops(c, w, v, a, r):
            stop, path = stop_by_flow(c, w, v, a, r, v_end, left)
            if stop != NEVER:
                return until + stop, distance + path, 0.0, a
        distance += v * y + p * Y + r * YY
        v, a = v_end, a * y_d + (r - w * v) * y
    return NEVER, distance, v, a


@inlined
def skip_substeps(steps, substeps, v, a, r, s, h):
    """Skip the substeps from s up to h without a stop; return s, distance, v and a there."""
    c, w = steps.c, steps.w
    length, (y, y_d, Y, YY) = substeps.h, substeps.whole
    distance, coarse = 0.0, True
    while True:
        p = a + c * v
        v_1 = v * y_d + p * y + r * Y
        a_1 = a * y_d + (r - w * v) * y
        if s + length > h or v_1 <= 0.0 or (a < 0.0 < a_1 and not never_stops(c, w, v, a, r)):
            if not coarse:
                return s, distance, v, a
            coarse = False
            length, (y, y_d, Y, YY) = substeps.h_short, substeps.short
            continue
        distance += v * y + p * Y + r * YY
        v, a = v_1, a_1
        s += length
