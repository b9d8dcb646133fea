"""Exact march over sampled base motion with Coulomb friction.

Problem
    Between two samples ü is linear. While the mass slides in one direction or sticks, a step is
    therefore one fixed affine map, and exact. Only a step with an event needs more. Friction
    limits are constant here; `march.march_sines` serves limits that vary.

Method
    1. Steps without events. `advance_rest` covers sticking, `advance_slip` sliding. Each step
       depends on the one before, which limits the throughput. Four consecutive states, each
       advanced by a four-step map, are four independent chains; what the base contributes
       within four steps does not depend on the state and is summed beforehand
       (`advance_slip_by_four`).
    2. Steps with events. `step_through_events` follows any number of events within a step.
       Stops are located in the power series of a short step, and by `roots.locate_stop` in a
       longer one.
    3. Creep. Once the base is silent, a mass that creeps to rest has a velocity far below the
       forces from which the affine map computes it. Below a threshold only
       `step_through_events` advances it: it propagates velocity and acceleration by themselves,
       which keeps their relative accuracy.

    The constants of the steps (`SlipSteps`) are computed within the kernel: to pass the many
    numbers in from Python takes as long as a thousand steps.

No stop is missed
    A fine step holds at most one extremum of v_r, so the acceleration at both ends shows any
    dip of v_r. Four steps at once are accepted only where |v_r| at both ends is above a bound
    on the dip in between. Every other step goes to step 2.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from drysim.core.compile import as_engine_array, compiled, inlined
from drysim.core.events import (
    MAX_EVENTS_PER_STEP,
    REVERSAL,
    SLIP,
    STICK,
    SampledLimit,
    decision_margin,
    direction_from_rest,
    excess_margin,
    grazing_margin,
    limit_force,
    record_event,
    slide_time,
    stick_limit,
    stop_depth,
)
from drysim.core.oscillator import (
    cancellation_threshold,
    chebyshev_stop,
    discretise_slip,
    flow,
    grazing_speed,
    series_acceleration,
    series_distance,
    series_velocity,
    velocity_series,
)
from drysim.core.roots import (
    NEVER,
    locate_stop,
    lowest_speed,
    never_stops,
    velocity_and_acceleration,
)
from drysim.core.status import CROWDED_STEP

# Coulomb friction, chunk by chunk.


CHUNK = 256
"""Samples per chunk: a few kilobytes. The chains of four steps restart at each multiple, so
that a march interrupted there continues to the last bit."""

STICK_BLOCK = 16
"""Stuck samples that are tested at once; a few vector registers hold them."""


class BaseSums(NamedTuple):
    """Work arrays of a march, of shape (CHUNK,) each; see `Chunk`."""

    x: Any
    v: Any


class SlipState(NamedTuple):
    """State of a march with Coulomb friction.

    Attributes
    ----------
    n, s : int, float
        Interval of ü, and time since its start [s].
    x_r, v_r : float
        State there [m, m/s].
    d : int
        Direction of sliding, 0 if stuck.
    a : float
        Relative acceleration [m/s²] in creep; NaN where x_r and v_r determine it.
    events : int
        Number of events in the log, or a `Status`.
    closest : float
        Smallest relative margin of a decision about sticking so far [-]; infinite before the
        first.
    """

    n: int
    s: float
    x_r: float
    v_r: float
    d: int
    a: float
    events: int
    closest: float


class SampledMotion(NamedTuple):
    """Solution at every sample: x_r [m], v_r [m/s] and direction of sliding, 0 if stuck."""

    x_r: Any
    v_r: Any
    d: Any


class OneWay(NamedTuple):
    """A motion in one direction and one mode.

    Attributes
    ----------
    d : int
        Direction.
    f : float
        Constant force per mass against the positive direction [m/s²].
    reach : float
        Position in the direction of motion, d·x_r, at which the mode ends [m].
    grazing : float
        As from `grazing_speed` [m/s].
    """

    d: int
    f: float
    reach: float
    grazing: float


class Chunk(NamedTuple):
    """Part of the samples, and what the base contributes there.

    Attributes
    ----------
    begin, until : int
        First and last sample.
    u_dd : array, shape (samples,)
        Base acceleration of the whole march [m/s²].
    x_base_sums, v_base_sums : array, shape (CHUNK,)
        What the base contributes to x_r [m] and v_r [m/s] in the four steps from each sample
        on; the first is for sample `begin`. See `sum_base_motion`.
    """

    begin: int
    until: int
    u_dd: Any
    x_base_sums: Any
    v_base_sums: Any


def empty_base_sums():
    """Return the work arrays of a march."""
    return BaseSums(as_engine_array(np.empty(CHUNK)), as_engine_array(np.empty(CHUNK)))


@compiled
def march(scene, state, out, log, end, base_sums):
    """March to sample `end`, or until the log is nearly full.

    Parameters
    ----------
    scene : Scene
        With constant limits of friction.
    state : SlipState
        Where to begin, at a sample.
    out : SampledMotion
        Holds x_r and v_r at sample n. Overwritten from n + 1 to the sample reached; values
        after that, up to `end`, are undefined.
    log : EventLog
        `MAX_EVENTS_PER_STEP` entries must be free.
    end : int
        Last sample of this march.
    base_sums : BaseSums

    Returns
    -------
    SlipState
        State reached. x_r is NaN if the next chunk of samples has values that are not finite.

    Notes
    -----
    A march that continues from the returned state gives the same result as one without
    interruption: to the last bit where n is a multiple of `CHUNK` or the log was full, to
    rounding elsewhere.
    """
    plant, law, _, u_dd, dt = scene
    x_base_sums, v_base_sums = base_sums
    steps = discretise_slip(plant.b / plant.m, plant.k_x / plant.m, dt)
    f, grazing = (
        law.F_fk / plant.m,
        grazing_speed(steps.c, steps.w, dt, plant.m, law.F_fk, law.F_fs),
    )
    side = Direction(steps, law.F_fk, law.F_fs, NEVER)
    contact = Contact(plant, 0.0, side, side)
    n, _, x_r, v_r, d, a, count, closest = state
    full = len(log.n) - MAX_EVENTS_PER_STEP
    # The base is summed from sample `begin` on, once the mass slides; negative before that.
    begin, until = n, n
    while n < end and 0 <= count <= full:
        if n >= until:
            begin, until = -1, min(n - n % CHUNK + CHUNK, end)
            if not all_finite(u_dd[n : until + 1]):
                x_r = math.nan
                break
        if a == a:
            v_r, a = rescale(v_r, a)
        elif d == 0:
            rest = Rest(plant.m, plant.k_x * x_r, law.F_fs, law.F_fs)
            n, closest = advance_rest(rest, u_dd, (n, until), out, closest)
        elif steps.fine:
            if begin < 0:
                begin = n
                sum_base_motion(steps.x_base, u_dd[n : until + 1], x_base_sums)
                sum_base_motion(steps.v_base, u_dd[n : until + 1], v_base_sums)
            chunk = Chunk(begin, until, u_dd, x_base_sums, v_base_sums)
            n = advance_slip(steps, chunk, n, OneWay(d, d * f, NEVER, grazing), out)
            x_r = out.x_r[n]
            v_r = out.v_r[n]
        if n < until:
            before = SlipState(n, 0.0, x_r, v_r, d, a, count, closest)
            reached, _, x_r, v_r, d, a, count, closest = step_through_events(
                contact, u_dd, before, log, count + MAX_EVENTS_PER_STEP
            )
            if reached == n:
                return SlipState(n + 1, 0.0, x_r, v_r, d, a, CROWDED_STEP, closest)
            n = reached
            out.x_r[n] = x_r
            out.v_r[n] = v_r
            out.d[n] = d
    return SlipState(n, 0.0, x_r, v_r, d, a, count, closest)


@compiled
def accelerations_at_samples(plant, F_fk, motion, u_dd, x_dd):
    """Write the absolute acceleration of a `SampledMotion` [m/s²]; ü at rest."""
    m, k_x, b = plant
    x_r, v_r, d = motion
    for n in range(len(x_dd)):
        pull = k_x * x_r[n] + b * v_r[n] + d[n] * F_fk
        x_dd[n] = u_dd[n] if d[n] == 0 else -pull / m


@compiled
def all_finite(u_dd):
    """Return whether all values are finite."""
    finite = 0
    for k in range(len(u_dd)):
        finite += abs(u_dd[k]) < math.inf
    return finite == len(u_dd)


class Rest(NamedTuple):
    """A mass at rest on its base, and what holds it.

    Attributes
    ----------
    m, F_k : float
        Mass [kg], and F_L without m ü [N].
    rising, falling : float
        Static limits [N] that F_L reaches by rising, and by falling; infinite for none.
    """

    m: float
    F_k: float
    rising: float
    falling: float


@inlined
def advance_rest(rest, u_dd, samples, out, closest):
    """Rest up to the last of the samples, or to the step at whose end F_L exceeds a limit.

    `samples` are the present and the last one. Returns the sample reached, and the smaller of
    `closest` and the relative distance of F_L from the limits [-].

    Notes
    -----
    A block is looked at sample by sample only if F_L comes closer to a limit than ever.
    """
    n, until = samples
    if n < 0:
        # Never true; tells the compiler that no index counts from the end.
        return n, closest
    (m, F_k, rising, falling), (x_out, v_out, d_out) = rest, out
    x_r = x_out[n]
    up, down = stick_limit(rising, F_k), stick_limit(falling, F_k)
    while n < until:
        share = 1.0 - min(closest, 1.0)
        near_up, near_down = rising * share, falling * share
        while n + STICK_BLOCK <= until and stays_at_rest(
            rest, (near_up, near_down), u_dd[n + 1 : n + 1 + STICK_BLOCK]
        ):
            for k in range(STICK_BLOCK):
                x_out[n + 1 + k] = x_r
            for k in range(STICK_BLOCK):
                v_out[n + 1 + k] = 0.0
            for k in range(STICK_BLOCK):
                d_out[n + 1 + k] = 0
            n += STICK_BLOCK
        stop, highest, lowest = min(n + STICK_BLOCK, until), -math.inf, math.inf
        while n < stop and -down <= m * u_dd[n + 1] + F_k <= up:
            n += 1
            F_L = m * u_dd[n] + F_k
            highest, lowest = max(highest, F_L), min(lowest, F_L)
            x_out[n] = x_r
            v_out[n] = 0.0
            d_out[n] = 0
        if highest > 0.0 and rising < math.inf:
            closest = min(closest, decision_margin(highest, rising))
        if lowest < 0.0 and falling < math.inf:
            closest = min(closest, decision_margin(lowest, falling))
        if n < stop:
            return n, closest
    return n, closest


@inlined
def stays_at_rest(rest, near, u_dd):
    """Return whether F_L is nowhere nearer to its limits than `near` [N] at these samples."""
    (m, F_k, _, _), (rising, falling) = rest, near
    beyond = 0
    for k in range(len(u_dd)):
        F_L = m * u_dd[k] + F_k
        beyond += (rising < F_L) | (-falling > F_L)
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
def advance_slip(steps, chunk, n, course, out):
    """Move to the end of a chunk, or to a step that may hold an event or reach the threshold.

    Parameters
    ----------
    steps : SlipSteps
        With `fine` steps.
    chunk : Chunk
    n : int
        Sample to start from.
    course : OneWay
    out : SampledMotion
        Holds the state at sample n. Overwritten from n + 1 to the sample reached; up to three
        more are undefined.

    Returns
    -------
    int
        Sample reached.

    Notes
    -----
    Where v_r keeps its sign x_r is monotone: whether it has passed a position shows at the end
    of a step.
    """
    until = chunk.until
    while n < until:
        fourth = n + 4 if steps.steep < math.inf else until
        n = advance_slip_by_one(steps, chunk.u_dd, n, min(fourth, until), course, out)
        if n < fourth:
            break
        n = advance_slip_by_four(steps, chunk, n, course, out)
    return n


@inlined
def advance_slip_by_one(steps, u_dd, n, until, course, out):
    """Move step by step, at most to sample `until`; otherwise as `advance_slip`."""
    x_out, v_out, d_out = out
    x_r = x_out[n]
    v_r = v_out[n]
    c, w, (d, f, reach, _) = steps.c, steps.w, course
    x_x, x_v, x_f, v_x, v_v, v_f = steps.step_map
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    x_f *= f
    v_f *= f
    u_0 = u_dd[n]
    a = -(u_0 + c * v_r + w * x_r + f)
    threshold = cancellation_threshold(steps, f, x_r)
    while n < until:
        u_1 = u_dd[n + 1]
        x_next = x_x * x_r + x_v * v_r - (x_0 * u_0 + x_1 * u_1 + x_f)
        v_next = v_x * x_r + v_v * v_r - (v_0 * u_0 + v_1 * u_1 + v_f)
        a_next = -(u_1 + c * v_next + w * x_next + f)
        # At or below the threshold, or a minimum of the speed within the step, or at the end.
        if d * v_next <= threshold or (d * a < 0.0 and d * a_next > 0.0):
            break
        if not d * x_next < reach:
            break
        n += 1
        u_0 = u_1
        x_r = x_next
        v_r = v_next
        a = a_next
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n


@inlined
def advance_slip_by_four(steps, chunk, n, course, out):
    """Advance the last four states by four steps each; return the sample reached.

    Parameters as in `advance_slip`. All four new states are accepted if |v_r| at both ends is
    above the bound on a dip in between, with the speed of a grazing; else those before the
    first that may hold one.
    """
    begin, until, u_dd, x_base_sums, v_base_sums = chunk
    d, f, reach, grazing = course
    x_out, v_out, d_out = out
    i = n - 3 - begin
    if begin < 0 or i < 0:
        # Never true; tells the compiler that no index counts from the end.
        return n
    x_x, x_v, x_f, v_x, v_v, v_f = steps.four_step_map
    x_f *= f
    v_f *= f
    m = begin + 3
    x_a, x_b, x_c, x_d = x_out[m + i - 3], x_out[m + i - 2], x_out[m + i - 1], x_out[m + i]
    v_a, v_b, v_c, v_d = v_out[m + i - 3], v_out[m + i - 2], v_out[m + i - 1], v_out[m + i]
    u_0 = u_dd[m + i]
    before = d * v_d
    threshold = cancellation_threshold(steps, f, x_d) + grazing
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
        if not (min(before, after) > dip + threshold and d * x_d < reach):
            # Keep the states up to the first step that may hold a dip, or the end of the mode,
            # without branches.
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
            first = (
                (before > one_step_threshold)
                * (d * v_a > one_step_threshold)
                * (d * x_a < reach)
            )
            second = first * (d * v_b > one_step_threshold) * (d * x_b < reach)
            third = second * (d * v_c > one_step_threshold) * (d * x_c < reach)
            return m + i + first + second + third
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


@inlined
def rescale(v_r, a):
    """Return v_r and a, multiplied by a power of two where they are about to underflow.

    While the base is silent only their ratio decides whether and when the mass stops, and the
    scaled values are still far below the rounding of x_r.
    """
    scale = RESCALING if max(abs(v_r), abs(a)) <= UNDERFLOW_SPEED else 1.0
    return v_r * scale, a * scale


# One step with events: any number of stops, break-aways and reversals.


class Direction(NamedTuple):
    """Constants of motion in one direction on a rigid contact.

    Attributes
    ----------
    steps : SlipSteps
    F_fk, F_fs : float
        Kinetic friction force and static limit [N].
    reach : float
        As in `OneWay`.
    """

    steps: Any
    F_fk: float
    F_fs: float
    reach: float


class Contact(NamedTuple):
    """Rigid friction contact of a mass on a spring, with constant limits.

    Attributes
    ----------
    plant : Plant
    origin : float
        Position from which displacements are measured [m].
    up, down : Direction
        Motion in the positive and in the negative direction.
    """

    plant: Any
    origin: float
    up: Any
    down: Any


@inlined
def step_through_events(contact, u_dd, state, log, full):
    """Advance through a step with any number of events.

    Parameters
    ----------
    contact : Contact
    u_dd : array
        Base acceleration at the samples [m/s²].
    state : SlipState
        Displacements are measured from the origin of the contact, those in the log included.
    log : EventLog
    full : int
        Number of events after which to stop.

    Returns
    -------
    SlipState
        At the next sample. Or before, with n as it was: the state from which the mass slides
        to the end of its reach, or after `full` events.
    """
    plant, origin, up, down = contact
    n, begin, x_r, v_r, d, a, count, closest = state
    u_0, u_1, h = u_dd[n], u_dd[n + 1], up.steps.dt
    slope = (u_1 - u_0) / h
    per_m = 1.0 / plant.m
    side = up if d > 0 else down
    if a != a:
        a = -(
            (u_0 + slope * begin)
            + side.steps.c * v_r
            + side.steps.w * (origin + x_r)
            + d * (side.F_fk * per_m)
        )
    while count < full:
        if d == 0:
            F_k = plant.k_x * (origin + x_r)
            F_L = limit_force(plant, origin + x_r, u_1)
            F_fs = (down if F_L > 0.0 else up).F_fs
            d = direction_from_rest(F_L, F_fs, F_k)
            if d == 0:
                closest = min(closest, decision_margin(F_L, F_fs))
                return SlipState(n + 1, 0.0, x_r, 0.0, 0, math.nan, count, closest)
            # Break-away: F_L is linear in time, so the time at the limit is a quotient.
            F_L = -d * F_fs
            meets = (F_L - limit_force(plant, origin + x_r, u_0)) / (plant.m * slope)
            begin = min(max(meets, begin), h)
            count = record_event(log, count, n, begin, d * SLIP, x_r, F_L)
            limit = SampledLimit(F_fs, 0.0, 0.0, 0.0)
            closest = excess_margin(plant, u_dd, limit, n, F_k, d, closest)
            side = up if d > 0 else down
            a = d * (F_fs - side.F_fk) * per_m
        steps, F_fk, F_fs, reach = side
        left = h - begin
        grazing = grazing_speed(steps.c, steps.w, h, plant.m, F_fk, F_fs)
        stop, distance, v_end, low = slide(steps, d * v_r, d * a, -d * slope, left, grazing)
        if not distance < reach - d * x_r:
            break
        if low < grazing:
            time = slide_time(log, count, n, h, h)
            closest = min(closest, grazing_margin(plant, F_fs, low, time))
        x_r += d * distance
        if stop == NEVER:
            f = d * (F_fk * per_m) + steps.w * origin
            if v_end <= cancellation_threshold(steps, f, x_r):
                _, a = velocity_and_acceleration(steps.c, steps.w, v_r, a, -slope, left)
            else:
                a = math.nan
            return SlipState(n + 1, 0.0, x_r, d * v_end, d, a, count, closest)
        # A stop: Eq. (9) decides between stick and slip.
        v_r = 0.0
        begin = min(begin + stop, h)
        F_L = limit_force(plant, origin + x_r, u_0 + slope * begin)
        if grazing > 0.0:
            a = -(d * F_L + F_fk) * per_m
            low = stop_depth(a, -d * slope - steps.c * a)
            if low < grazing:
                time = slide_time(log, count, n, begin, h)
                closest = min(closest, grazing_margin(plant, F_fs, low, time))
        F_fs = (down if F_L > 0.0 else up).F_fs
        closest = min(closest, decision_margin(F_L, F_fs))
        d = direction_from_rest(F_L, F_fs, plant.k_x * (origin + x_r))
        side = up if d > 0 else down
        a = -(F_L + d * side.F_fk) * per_m
        kind = STICK if d == 0 else d * REVERSAL
        count = record_event(log, count, n, begin, kind, x_r, F_L)
    return SlipState(n, begin, x_r, v_r, d, a, count, closest)


@inlined
def slide(steps, v, a, r, h, grazing):
    """Slide for h, or to the first stop.

    Parameters
    ----------
    steps : SlipSteps
    v, a, r, h : float
        As in `locate_stop`.
    grazing : float
        As in `OneWay`.

    Returns
    -------
    stop, distance, v_end, low : float
        Time of the stop [s], infinity for none; distance [m] until then, or until h; velocity
        there [m/s], at least 0; and its minimum before, infinite for none or where it does not
        matter.

    Notes
    -----
    The derivative of the equation of motion is v" + c v' + w v = r. It contains neither ü nor
    the spring force nor friction, so v keeps its relative accuracy however small it is compared
    with these forces.
    """
    if steps.short:
        q = velocity_series(steps.factors, v, a, r - steps.c * a - steps.w * v)
        v_end = series_velocity(q, h)
        if v_end > 0.0 and (a >= 0.0 or series_acceleration(q, h) <= 0.0):
            return NEVER, series_distance(q, h), v_end, NEVER
        if v > 0.0 and v_end <= 0.0:
            stop, distance = chebyshev_stop(q, h)
            if stop > 0.0:
                return stop, distance, 0.0, NEVER
    stop, distance, v_end = slide_by_flow(steps.c, steps.w, v, a, r, h)
    sought = stop == NEVER and grazing > 0.0
    low = lowest_speed(steps.c, steps.w, v, a, r, h) if sought else NEVER
    return stop, distance, v_end, low


@compiled
def slide_by_flow(c, w, v, a, r, h):
    """Return `slide` for a step of any length."""
    # Unlike `locate_stop`, do not stop a mass whose velocity has underflowed.
    stop = NEVER if never_stops(c, w, v, a, r) else locate_stop(c, w, v, a, r, h)
    y, y_d, Y, YY = flow(c, w, min(stop, h))
    p = a + c * v
    v_end = v * y_d + p * y + r * Y if stop == NEVER else 0.0
    return stop, v * y + p * Y + r * YY, max(v_end, 0.0)
