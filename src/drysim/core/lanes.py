"""Many sampled records in one call, vectorised over the records (seeds).

Problem
    An ensemble needs the metrics of hundreds of records but not their motion. One march per
    record leaves the vector units of the processor idle.

Method
    - One lane per record: all lanes are at the same sample, and each quantity is a row of one
      array, so that the compiler vectorises over the lanes.
    - All lanes take four steps as if no event occurred. A bound on what a step may hide
      (`step_constants`) finds the lanes in which an event is possible; they keep their state.
    - These lanes are gathered into full registers and advance step by step. A step with one
      event is solved in vector form. Any other case (two events in a step, a velocity that only
      touches zero, a root search that fails) is left to the march of a single record. The lanes
      are scattered back at the end of the four steps.
    - Integrals come from sums over samples by the Euler-Maclaurin formula, which is exact for
      the smooth motion within a step: the trapezoidal rule plus end terms. Where two steps
      meet, only the slope of ü differs, so one end term per sample remains. In a step with
      events the formula is replaced by integrals over the segments between them.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from drysim.core import oscillator
from drysim.core.compile import compiled, inlined, inlined_with_fma
from drysim.core.events import (
    FORCE_ROUNDING,
    SLIP,
    EventLog,
    direction_after,
    initial_direction,
)
from drysim.core.oscillator import DIP_SAFETY, AffineMap
from drysim.core.sampled import make_substeps, step_through_events
from drysim.core.trajectory import integrate_linear_segment

X2, V2, X_DD2, POWER, DISTANCE, STUCK, U_DD2, INTEGRALS = range(8)
"""Integrals, as in `Totals`, and how many."""

EVENTS, CLOSEST, FARTHEST, RESULT_COUNT = range(INTEGRALS, INTEGRALS + 4)
"""Results of a lane after the integrals: number of events, margin of the closest stop decision,
and greatest |x_r| at a stop; and the number of results."""

X_BEGIN, V_BEGIN, X_END, V_END, BEGIN, STOP_COUNT, ANSWER_COLUMNS = range(
    RESULT_COUNT, RESULT_COUNT + 7
)
"""Columns of an answer after the results: states at both ends of the window; number of stops
before the window, and in total; and the number of columns."""

LANES = 128
"""Maximum number of records marched together: few enough to stay in the cache, and enough for
those that wait for an event to fill whole registers."""

WIDTH = 8
"""Numbers in the widest register; lanes are processed in groups of this size."""

STRIDE = 4
"""Steps that are taken at once."""

SAMPLES_PER_STRIDE = STRIDE + 2
"""Samples that a stride reads: those in it, at both ends, and the one before."""

SAMPLES_PER_READ = 256
"""Samples read at a time: a whole number of strides."""

READ_BUFFER_SIZE = (SAMPLES_PER_READ + 2) * WIDTH
"""Size of the buffer of samples of a group of lanes: ü at the sample before, at the first one
and so on, for all lanes of the group."""

X, V, D, AHEAD = (row * LANES for row in range(4))
"""Rows of the lanes and of the queue: x_r, v_r and direction; ü at the samples that a stride
reads, one row each."""

SUMS = AHEAD + SAMPLES_PER_STRIDE * LANES
SUM_COUNT = 12
"""First row and number of sums over samples, see `integrals_from_sums`; in the queue
`RESULT_COUNT` rows, with the additions to the results."""

WAITS = SUMS + SUM_COUNT * LANES
"""Row: whether the lane waits for the search of an event."""

LANES_SIZE = WAITS + LANES
"""Size of the array of all lanes."""

DONE, AT_EVENT, U, U_1, X_STOP, STOPS, HANDLED = (
    SUMS + row * LANES for row in range(RESULT_COUNT, RESULT_COUNT + 7)
)
"""Rows of the queue: number of finished steps of the stride; whether the next step may hold an
event, and ü at its ends; x_r at the stop, whether there is one, and whether it converged."""

QUEUE_SIZE = HANDLED + LANES
"""Size of the queue."""


class LaneBuffers(NamedTuple):
    """Work space shared by the lanes of a march, and results of each lane; arrays.

    Attributes
    ----------
    at : array, shape (LANES_SIZE,)
        The lanes.
    base : array, shape (READ_BUFFER_SIZE * LANES / WIDTH,)
        Samples of ü.
    queue : array, shape (QUEUE_SIZE,)
        The lanes that wait for the search of an event.
    lane : array of int, shape (LANES,)
        Numbers of these lanes.
    results : array, shape (LANES, RESULT_COUNT)
        Results of every lane.
    stop_counts : array of int, shape (LANES,)
        Number of stops written for every lane.
    log : EventLog
        Log of a step that is solved without the other lanes.
    """

    at: Any
    base: Any
    queue: Any
    lane: Any
    results: Any
    stop_counts: Any
    log: EventLog


@compiled
def measure_records(
    plant, law, steps, rule, records, begin, end, start, buffers, stops, answers
):  # fmt: skip
    """March and measure every record.

    Parameters
    ----------
    plant, law, steps
        Steps for which `is_accurate` holds.
    rule : EndForms
        End forms of such a step.
    records : array, shape (records, samples)
        Base acceleration [m/s²].
    begin, end : int
        Samples at which the window begins and ends.
    start : State
    buffers : LaneBuffers
    stops : array, shape (records, n)
        Written: x_r at the first n stops up to the end of the window [m].
    answers : array, shape (records, ANSWER_COLUMNS)
        Written: the columns named above; NaN where the numerics fail.
    """
    for first in range(0, len(records), LANES):
        count = min(LANES, len(records) - first)
        initialise_lanes(plant, law, records, first, count, start, buffers)
        march_lanes(plant, law, steps, rule, records, first, count, 0, begin, buffers, stops)
        note_begin(steps, rule, records, begin, buffers, answers, first, count)
        march_lanes(plant, law, steps, rule, records, first, count, begin, end, buffers, stops)
        note_end(steps, rule, records, end, buffers, answers, first, count)


@inlined
def lane_count(count):
    """Return the number of lanes for a number of records, a multiple of `WIDTH`."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@compiled
def initialise_lanes(plant, law, records, first, count, start, buffers):
    """Set the start of every record; surplus lanes repeat the last record."""
    at = buffers.at
    for i in range(SUM_COUNT * LANES):
        at[SUMS + i] = 0.0
    for lane in range(lane_count(count)):
        u_dd = records[first + min(lane, count - 1), 0]
        at[X + lane], at[V + lane] = start.x_r, start.v_r
        at[D + lane] = initial_direction(plant, law, start.x_r, start.v_r, u_dd)
        buffers.stop_counts[lane] = 0
        for i in range(RESULT_COUNT):
            buffers.results[lane, i] = 0.0
        buffers.results[lane, CLOSEST] = math.inf


@compiled
def note_begin(steps, rule, records, begin, buffers, answers, first, count):
    """Store the state at the beginning of the window, and restart the sums."""
    at = buffers.at
    for lane in range(lane_count(count)):
        for i in range(INTEGRALS):
            buffers.results[lane, i] = 0.0
    for lane in range(count):
        answer, u_dd = answers[first + lane], records[first + lane, begin]
        # The sums begin as if ü had been constant before the window.
        end_of_window(steps, rule, buffers, lane, -1.0, u_dd, u_dd)
        answer[X_BEGIN], answer[V_BEGIN] = at[X + lane], at[V + lane]
        answer[BEGIN] = buffers.stop_counts[lane]


@compiled
def note_end(steps, rule, records, end, buffers, answers, first, count):
    """Store the state at the end of the window, and the results."""
    at = buffers.at
    for lane in range(count):
        answer, results, u_dd = (
            answers[first + lane],
            buffers.results[lane],
            records[first + lane],
        )
        end_of_window(steps, rule, buffers, lane, 1.0, u_dd[end - 1], u_dd[end])
        answer[X_END], answer[V_END] = at[X + lane], at[V + lane]
        answer[STOP_COUNT] = buffers.stop_counts[lane]
        for i in range(RESULT_COUNT):
            answer[i] = results[i]


@inlined
def end_of_window(steps, rule, buffers, lane, sign, u_b, u):
    """Add half a sample at the end of the window; subtract it at the beginning.

    `u` is ü there, `u_b` at the sample before.
    """
    at, results = buffers.at, buffers.results[lane]
    x, v, d = at[X + lane], at[V + lane], at[D + lane]
    minus_x_dd = steps.c * v + (steps.w * x + d * steps.f)
    half = half_sample(rule, d, x, minus_x_dd, u, v)
    end = end_corrections(rule, d, x, minus_x_dd, u, v, (u - u_b) / steps.dt)
    for i in range(INTEGRALS):
        results[i] += sign * (half[i] + end[i])


@compiled
def march_lanes(plant, law, steps, rule, records, first, count, n, end, buffers, stops):
    """March records from sample n to sample `end`, and update their integrals."""
    lanes, before = lane_count(count), n
    parts, constants = make_substeps(steps), step_constants(plant, law, steps)
    while n < end:
        length = min(SAMPLES_PER_READ, end - n)
        read_samples(buffers.base, records, first, count, lanes, n, length, before)
        for k in range(0, length, STRIDE):
            left = min(STRIDE, length - k)
            gather_stride_samples(buffers.at, buffers.base, lanes, k)
            if left == STRIDE:
                stride(constants, buffers.at, lanes)
            else:
                # Less than a stride is left: all lanes wait.
                for lane in range(lanes):
                    buffers.at[WAITS + lane] = 1.0
            waiting_count = gather_waiting(buffers.at, lanes, buffers.queue, buffers.lane)
            for group in range(0, waiting_count, WIDTH):
                waiting = buffers.queue[group:]
                while advance_waiting(constants, rule, waiting, left) > 0:
                    if steps.brief:
                        advance_events(plant, law, steps, constants, rule, waiting)
                    else:
                        defer_events(waiting)
                    finish_event_steps(
                        plant, law, steps, parts, rule, buffers, group, stops, first
                    )
            restore_lanes(buffers, waiting_count)
        n += length
        before = n - 1
        gather_sums(rule, constants, buffers, lanes)


@compiled
def gather_sums(rule, constants, buffers, lanes):
    """Add the sums to the results. Restarting the sums often limits their rounding."""
    at = buffers.at
    for lane in range(lanes):
        i = SUMS + lane
        z = (
            at[i], at[i + LANES], at[i + 2 * LANES], at[i + 3 * LANES], at[i + 4 * LANES],
            at[i + 5 * LANES], at[i + 6 * LANES], at[i + 7 * LANES], at[i + 8 * LANES],
        )  # fmt: skip
        total = integrals_from_sums(
            rule, constants, z, at[i + 11 * LANES], at[i + 9 * LANES], at[i + 10 * LANES]
        )
        for k in range(INTEGRALS):
            buffers.results[lane, k] += total[k]
    for i in range(SUM_COUNT * LANES):
        at[SUMS + i] = 0.0


@compiled
def read_samples(base, records, first, count, lanes, n, length, before):
    """Copy ü from sample n to n + length; surplus lanes repeat the last record.

    `before` is the index of the sample before n, or n at the first sample.
    """
    last = first + count - 1
    for lane in range(0, lanes, WIDTH):
        r, places = first + lane, base[lane // WIDTH * READ_BUFFER_SIZE :]
        a, b = records[min(r, last)], records[min(r + 1, last)]
        c, d = records[min(r + 2, last)], records[min(r + 3, last)]
        e, f = records[min(r + 4, last)], records[min(r + 5, last)]
        g, h = records[min(r + 6, last)], records[min(r + 7, last)]
        for k in range(length + 2):
            n_k, group = n - 1 + k if k > 0 else before, places[WIDTH * k :]
            group[0], group[1], group[2], group[3] = a[n_k], b[n_k], c[n_k], d[n_k]
            group[4], group[5], group[6], group[7] = e[n_k], f[n_k], g[n_k], h[n_k]


@compiled
def gather_stride_samples(at, base, lanes, k):
    """Copy ü at the samples of a stride from the k-th sample in the buffer, one row each."""
    for lane in range(0, lanes, WIDTH):
        seen, there = base[lane // WIDTH * READ_BUFFER_SIZE + k * WIDTH :], at[AHEAD + lane :]
        for row in range(SAMPLES_PER_STRIDE):
            i, j = row * WIDTH, row * LANES
            a, b, c, d = seen[i], seen[i + 1], seen[i + 2], seen[i + 3]
            e, f, g, h = seen[i + 4], seen[i + 5], seen[i + 6], seen[i + 7]
            there[j], there[j + 1], there[j + 2], there[j + 3] = a, b, c, d
            there[j + 4], there[j + 5], there[j + 6], there[j + 7] = e, f, g, h


# All lanes at once, as if nothing happened; they stand where nothing does.


TAME = 0.05
"""Share that must be left of 1 for the bound on a dip to mean anything."""

EVER = 1e300
"""In place of that bound: then every step is looked at closely. Times nothing it is nothing."""


class StepConstants(NamedTuple):
    """Constants of a step without an event.

    Attributes
    ----------
    m, k_x, F_fs : float
    c, w, f : float
        b/m [1/s], k_x/m [1/s²] and F_fk/m [m/s²].
    step_map : AffineMap
    x_0, x_1, v_0, v_1 : float
        As in `SlipSteps`.
    steep, fast : float
        A step hides no dip of |v_r| to zero above steep |change of ü| + fast |v_r|.
    """

    m: float
    k_x: float
    F_fs: float
    c: float
    w: float
    f: float
    step_map: AffineMap
    x_0: float
    x_1: float
    v_0: float
    v_1: float
    steep: float
    fast: float


@compiled
def step_constants(plant, law, steps):
    """Return the constants of a step.

    Notes
    -----
    In a step |v_r"| <= M = |change|/dt + c (v/dt + M dt) + w (v + M dt²/2), with v the greater
    |v_r| of both ends; and a function that bends so little falls at most M dt²/8 below its
    lower end: steep |change| + fast v, which is widened so that rounding cannot matter.
    """
    c, w, dt = steps.c, steps.w, steps.dt
    tame = 1.0 - (c + 0.5 * w * dt) * dt
    steep = DIP_SAFETY * 0.125 * dt / tame if tame > TAME else EVER
    return StepConstants(
        plant.m, plant.k_x, law.F_fs, c, w, steps.f, steps.step_map,
        steps.x_0, steps.x_1, steps.v_0, steps.v_1, steep, steep * (c + w * dt),
    )  # fmt: skip


class StrideConstants(NamedTuple):
    """Constants of a lane during a stride.

    Attributes
    ----------
    d : float
        Direction of sliding, 0 where it sticks.
    slides : bool
    pull, x_f, v_f : float
        Friction per mass [m/s²], and its effect on x_r and v_r over a step.
    F_k, hold : float
        Spring force and static limit [N], for a stuck lane.
    """

    d: float
    slides: bool
    pull: float
    x_f: float
    v_f: float
    F_k: float
    hold: float


@inlined_with_fma
def stride_constants(constants, x, d):
    """Return the per-record constants of the next four steps, from the state at their start."""
    F_k = constants.k_x * x
    hold = constants.F_fs + FORCE_ROUNDING * (constants.F_fs + abs(F_k))
    return StrideConstants(
        d,
        d != 0.0,
        constants.f * d,
        constants.step_map.x_f * d,
        constants.step_map.v_f * d,
        F_k,
        hold,
    )


@inlined_with_fma
def step(constants, fixed, x, v, u, u_1):
    """Return the state at the end of a step, and -x_dd at its start where the mass slides."""
    # Terms with the state come last, because the next step depends on them.
    step_map = constants.step_map
    x_1 = step_map.x_x * x + (
        step_map.x_v * v - (constants.x_0 * u + (constants.x_1 * u_1 + fixed.x_f))
    )
    v_1 = step_map.v_v * v + (
        step_map.v_x * x - (constants.v_0 * u + (constants.v_1 * u_1 + fixed.v_f))
    )
    minus_x_dd = constants.c * v + (constants.w * x + fixed.pull)
    return x_1 if fixed.slides else x, v_1 if fixed.slides else 0.0, minus_x_dd


@inlined_with_fma
def add_sample(z, x, v, minus_x_dd, u, bend):
    """Add a sample to the sums of products; `bend` is the second difference of ü there."""
    return (
        x * x + z[0], v * v + z[1], minus_x_dd * minus_x_dd + z[2], u * v + z[3], v + z[4],
        u * u + z[5], x * bend + z[6], v * bend + z[7], u * bend + z[8],
    )  # fmt: skip


NOTHING = (0.0,) * 9
"""Sums of no samples."""


@compiled
def stride(constants, at, lanes):
    """Advance every lane by four steps, or mark it as waiting if a step may hold an event."""
    for first in range(0, lanes, WIDTH):
        stride_register(constants, at[first:])


@inlined_with_fma
def stride_register(constants, at):
    """Advance one register of lanes; see `stride`."""
    for i in range(WIDTH):
        x, v, d = at[X + i], at[V + i], at[D + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + 5 * LANES + i]
        r_0, r_1, r_2, r_3, r_4 = u - u_b, u_1 - u, u_2 - u_1, u_3 - u_2, u_4 - u_3
        fixed = stride_constants(constants, x, d)
        slides, F_k, hold = fixed.slides, fixed.F_k, fixed.hold
        x_1, v_1, minus_x_dd = step(constants, fixed, x, v, u, u_1)
        z = add_sample(NOTHING, x, v, minus_x_dd, u, r_1 - r_0)
        x_2, v_2, minus_x_dd = step(constants, fixed, x_1, v_1, u_1, u_2)
        z = add_sample(z, x_1, v_1, minus_x_dd, u_1, r_2 - r_1)
        x_3, v_3, minus_x_dd = step(constants, fixed, x_2, v_2, u_2, u_3)
        z = add_sample(z, x_2, v_2, minus_x_dd, u_2, r_3 - r_2)
        x_4, v_4, minus_x_dd = step(constants, fixed, x_3, v_3, u_3, u_4)
        z = add_sample(z, x_3, v_3, minus_x_dd, u_3, r_4 - r_3)
        # Whether any of these steps may hold an event is asked of all of them at once.
        s_0, s_1, s_2, s_3, s_4 = d * v, d * v_1, d * v_2, d * v_3, d * v_4
        slow = min(min(min(s_0, s_1), min(s_2, s_3)), s_4)
        fast = max(max(max(s_0, s_1), max(s_2, s_3)), s_4)
        change = max(max(abs(r_1), abs(r_2)), max(abs(r_3), abs(r_4)))
        low, high = min(min(u_1, u_2), min(u_3, u_4)), max(max(u_1, u_2), max(u_3, u_4))
        stops = slow <= constants.steep * change + constants.fast * (fast + fast)
        breaks = constants.m * high + F_k > hold or constants.m * low + F_k < -hold
        waits = stops if slides else breaks
        at[X + i], at[V + i] = x if waits else x_4, v if waits else v_4
        at[WAITS + i] = 1.0 if waits else 0.0
        j, bend = SUMS + i, r_4 - r_0
        at[j] = at[j] if waits else at[j] + z[0]
        at[j + LANES] = at[j + LANES] if waits else at[j + LANES] + z[1]
        old, x_dd2 = at[j + 2 * LANES], z[2] if slides else z[5]
        at[j + 2 * LANES] = old if waits else old + x_dd2
        at[j + 3 * LANES] = at[j + 3 * LANES] if waits else at[j + 3 * LANES] + z[3]
        at[j + 4 * LANES] = at[j + 4 * LANES] if waits else at[j + 4 * LANES] + d * z[4]
        at[j + 5 * LANES] = at[j + 5 * LANES] if waits else at[j + 5 * LANES] + z[5]
        old, glides, stays = at[j + 6 * LANES], slides and not waits, not (slides or waits)
        at[j + 6 * LANES] = old + z[6] if glides else old
        at[j + 7 * LANES] = at[j + 7 * LANES] if waits else at[j + 7 * LANES] + z[7]
        at[j + 8 * LANES] = at[j + 8 * LANES] + z[8] if glides else at[j + 8 * LANES]
        at[j + 9 * LANES] = at[j + 9 * LANES] + z[8] if stays else at[j + 9 * LANES]
        at[j + 10 * LANES] = at[j + 10 * LANES] + STRIDE if stays else at[j + 10 * LANES]
        at[j + 11 * LANES] = at[j + 11 * LANES] if waits else at[j + 11 * LANES] + d * bend


# Lanes that wait for an event: gathered, advanced to and through the step with it, restored.
#
# `advance_waiting` and `advance_events` are separate kernels, because functions with FMA are
# inlined in their callers.


@compiled
def gather_waiting(at, count, queue, lane_numbers):
    """Gather the waiting lanes among the first `count`; return their number.

    Their numbers are written to `lane_numbers`, their states to `queue`, with empty results.
    The last register is filled up with lanes that are done.
    """
    waiting = 0
    for lane in range(count):
        lane_numbers[waiting] = lane
        waiting += 1 if at[WAITS + lane] > 0.0 else 0
    for i in range(waiting):
        lane = lane_numbers[i]
        queue[X + i], queue[V + i] = at[X + lane], at[V + lane]
        queue[D + i] = at[D + lane]
        for k in range(SAMPLES_PER_STRIDE):
            queue[AHEAD + k * LANES + i] = at[AHEAD + k * LANES + lane]
    filled = lane_count(waiting)
    for i in range(filled):
        queue[DONE + i] = 0.0 if i < waiting else STRIDE
    for k in range(RESULT_COUNT):
        initial = math.inf if k == CLOSEST else 0.0
        for i in range(filled):
            queue[SUMS + k * LANES + i] = initial
    return waiting


@inlined_with_fma
def may_hold_event(constants, fixed, v, v_1, minus_x_dd, u, u_1):
    """Return whether a step from one state to another may hold an event."""
    along, along_1 = fixed.d * v, fixed.d * v_1
    margin = constants.steep * abs(u_1 - u) + constants.fast * (along + along_1)
    dips = min(along, along_1) <= margin and fixed.d * (minus_x_dd + u) > 0.0
    stops, breaks = along_1 <= 0.0 or dips, abs(constants.m * u_1 + fixed.F_k) > fixed.hold
    return stops if fixed.slides else breaks


@inlined_with_fma
def advance_lane(constants, fixed, state, u_b, u, u_1, going, z):
    """Return the result of one step of an advancing lane, and whether it is before an event."""
    x, v, done, bends = state
    x_1, v_1, minus_x_dd = step(constants, fixed, x, v, u, u_1)
    event = may_hold_event(constants, fixed, v, v_1, minus_x_dd, u, u_1)
    goes, here = going and not event, going and event
    bend = (u_1 - u) - (u - u_b)
    counted = add_sample(z, x, v, minus_x_dd if fixed.slides else u, u, bend)
    z = (
        counted[0] if going else z[0], counted[1] if going else z[1],
        counted[2] if going else z[2], counted[3] if going else z[3],
        counted[4] if going else z[4], counted[5] if going else z[5],
        counted[6] if going else z[6], counted[7] if going else z[7],
        counted[8] if going else z[8],
    )  # fmt: skip
    bends = bends + bend if going else bends
    return (
        (x_1 if goes else x, v_1 if goes else v, done + 1.0 if goes else done, bends),
        here,
        z,
    )


@compiled
def advance_waiting(constants, rule, at, length):
    """Advance one register of waiting lanes, to an event or to the end of the stride.

    Returns the number of lanes before an event. `length` is that of the stride in steps.
    """
    return advance_waiting_register(constants, rule, at, float(length))


@inlined_with_fma
def advance_waiting_register(constants, rule, at, length):
    """Walk; see `advance_waiting`."""
    events = 0
    for i in range(WIDTH):
        x, v, d, done = at[X + i], at[V + i], at[D + i], at[DONE + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + (STRIDE + 1) * LANES + i]
        fixed, first = stride_constants(constants, x, d), done
        state = x, v, done, 0.0
        state, h_1, z = advance_lane(
            constants, fixed, state, u_b, u, u_1, done == 0.0 and length > 0.0, NOTHING
        )
        state, h_2, z = advance_lane(
            constants, fixed, state, u, u_1, u_2, state[2] == 1.0 and length > 1.0, z
        )
        state, h_3, z = advance_lane(
            constants, fixed, state, u_1, u_2, u_3, state[2] == 2.0 and length > 2.0, z
        )
        state, h_4, z = advance_lane(
            constants, fixed, state, u_2, u_3, u_4, state[2] == 3.0 and length > 3.0, z
        )
        here, slides = (h_1 or h_2) or (h_3 or h_4), fixed.slides
        reached = state[2] - first + (1.0 if here else 0.0)
        total = integrals_from_sums(
            rule, constants,
            (
                z[0], z[1], z[2], z[3], d * z[4], z[5],
                z[6] if slides else 0.0, z[7], z[8] if slides else 0.0,
            ),
            d * state[3], 0.0 if slides else z[8], 0.0 if slides else reached,
        )  # fmt: skip
        at[X + i], at[V + i], at[DONE + i] = state[0], state[1], state[2]
        at[AT_EVENT + i] = 1.0 if here else 0.0
        at[U + i] = u if h_1 else (u_1 if h_2 else (u_2 if h_3 else u_3))
        at[U_1 + i] = u_1 if h_1 else (u_2 if h_2 else (u_3 if h_3 else u_4))
        at[SUMS + i] += total[0]
        at[SUMS + LANES + i] += total[1]
        at[SUMS + 2 * LANES + i] += total[2]
        at[SUMS + 3 * LANES + i] += total[3]
        at[SUMS + 4 * LANES + i] += total[4]
        at[SUMS + 5 * LANES + i] += total[5]
        at[SUMS + 6 * LANES + i] += total[6]
        events += 1 if here else 0
    return events


NEARLY = 2e-5
"""Step of a method of fourth order after which nothing is left to mend, relative to the root
and to how far the velocity bends: the first guess is as good but once in a thousand times."""

series, distance = (
    inlined_with_fma(oscillator.velocity_series),
    inlined_with_fma(oscillator.series_distance),
)
speed, rate = (
    inlined_with_fma(oscillator.series_velocity),
    inlined_with_fma(oscillator.series_acceleration),
)


@inlined_with_fma
def first_guess(q, h):
    """Return the root of the quadratic part of a velocity series, corrected by two terms."""
    square = q[1] * q[1] - 4.0 * q[0] * q[2]
    root = math.sqrt(square if square > 0.0 else 1.0)
    down = root > q[1]
    above = 2.0 * q[0] if down else -q[1] - root
    below = root - q[1] if down else 2.0 * q[2]
    s = above / (below if below != 0.0 else 1.0)
    s = min(max(s, 0.0), h)
    return s + s * s * s * (q[3] + s * q[4]) / root, square > 0.0


@inlined_with_fma
def stop_time(q, h):
    """Return the root of a velocity that ends below zero, and whether it has converged."""
    s, good = first_guess(q, h)
    a = rate(q, s)
    good = good and a < 0.0 and s > 0.0
    per_a = 1.0 / (a if good else -1.0)
    bend, twist = q[2] + s * (3.0 * q[3] + 6.0 * q[4] * s), q[3] + 4.0 * q[4] * s
    step, bend, twist = -speed(q, s) * per_a, bend * per_a, twist * per_a
    step -= step * step * (bend - (2.0 * bend * bend - twist) * step)
    step = step if good else 0.0
    s += step
    # An iteration that diverges may end anywhere; the result is limited to stay finite.
    good = good and abs(step) <= NEARLY * s and abs(bend * step) <= NEARLY
    return min(max(s, 0.0), h), good


@compiled
def advance_events(plant, law, steps, constants, rule, at):
    """Advance one register of lanes through the step with an event."""
    advance_events_register(plant, law, steps, constants, rule, at)


@inlined_with_fma
def advance_events_register(plant, law, steps, constants, rule, at):
    """See `advance_events`."""
    h, c, w, f = steps.dt, steps.c, steps.w, steps.f
    m, k_x, F_fs = plant.m, plant.k_x, law.F_fs
    per_h, per_m = 1.0 / h, 1.0 / m
    for i in range(WIDTH):
        x, v, d, u, u_1 = at[X + i], at[V + i], at[D + i], at[U + i], at[U_1 + i]
        slides = d != 0.0
        slope = (u_1 - u) * per_h
        x_1, v_1, minus_x_dd = step(constants, stride_constants(constants, x, d), x, v, u, u_1)
        v_end, minus_x_dd_1 = d * v_1, c * v_1 + (w * x_1 + d * f)
        a = -d * (u + minus_x_dd)
        q = series(steps.factors, d * v, a, -d * slope - c * a - w * (d * v))
        stop, good = stop_time(q, h)
        # A short step holds one extremum at most.
        none = slides and v_end > 0.0 and (a >= 0.0 or d * (u_1 + minus_x_dd_1) >= 0.0)
        # Break-away: F_L is linear in time, so it meets the limit at a quotient.
        F_0, climb = m * u + k_x * x, m * slope
        F_out = F_fs if F_0 + climb * h >= 0.0 else -F_fs
        meets = (F_out - F_0) / (climb if climb != 0.0 else 1.0)
        stop = stop if slides else min(max(meets, 0.0), h)
        path = distance(q, stop)
        x_s, u_s = x + d * path, u + slope * stop
        F_L = m * u_s + k_x * x_s
        hold = F_fs + FORCE_ROUNDING * (F_fs + abs(k_x * x_s))
        sticks = slides and abs(F_L) <= hold
        F_L = F_L if slides else F_out
        d_2 = 1.0 if F_L < 0.0 else -1.0
        d_2 = 0.0 if sticks else d_2
        a_2 = 0.0 if sticks else abs(F_L) * per_m - f
        q_2 = series(steps.factors, 0.0, a_2, 0.0 if sticks else -d_2 * slope - c * a_2)
        rest = h - stop
        path_2, v_2 = distance(q_2, rest), d_2 * speed(q_2, rest)
        x_2 = x_s + d_2 * path_2
        bears = abs(m * u_1 + k_x * x_s) <= hold
        fine = bears if sticks else d_2 * v_2 > 0.0 and (not slides or d * F_L > 0.0)
        fine = fine and ((good and v_end <= 0.0) if slides else climb != 0.0)
        here = at[AT_EVENT + i] > 0.0
        goes_on, counts = here and none, here and fine and not none
        stops = counts and slides
        larger = max(abs(F_L), F_fs)
        tight = abs(abs(F_L) - F_fs) / (larger if larger > 0.0 else 1.0)
        # Sums count what the rule makes of the step; the integrals take its place.
        a_s = -(d * F_L * per_m + f) if slides else 0.0
        back = series(steps.factors, 0.0, a_s, -d * slope - c * a_s)
        minus_x_dd_2 = c * v_2 + (w * x_2 + d_2 * f)
        step_map = integrate_beside_event(
            steps, back, x_s, d, u_s, slope, -stop, x, v, minus_x_dd, u
        )
        two = integrate_beside_event(
            steps, q_2, x_s, d_2, u_s, slope, rest, x_2, v_2, minus_x_dd_2, u_1
        )
        p, r = (
            half_sample(rule, d, x, minus_x_dd, u, v),
            half_sample(rule, d_2, x_2, minus_x_dd_2, u_1, v_2),
        )
        b = end_corrections(rule, d, x, minus_x_dd, u, v, slope)
        e = end_corrections(rule, d_2, x_2, minus_x_dd_2, u_1, v_2, slope)
        still = (0.0 if slides else stop) + (rest if sticks else 0.0)
        x2 = step_map[0] + two[0] - ((p[0] + r[0]) + (e[0] - b[0]))
        v2 = step_map[1] + two[1] - ((p[1] + r[1]) + (e[1] - b[1]))
        x_dd2 = step_map[2] + two[2] - ((p[2] + r[2]) + (e[2] - b[2]))
        power = step_map[3] + two[3] - ((p[3] + r[3]) + (e[3] - b[3]))
        slid = path + path_2 - ((p[4] + r[4]) + (e[4] - b[4]))
        at[SUMS + i] += x2 if counts else 0.0
        at[SUMS + LANES + i] += v2 if counts else 0.0
        at[SUMS + 2 * LANES + i] += x_dd2 if counts else 0.0
        at[SUMS + 3 * LANES + i] += power if counts else 0.0
        at[SUMS + 4 * LANES + i] += slid if counts else 0.0
        at[SUMS + 5 * LANES + i] += still - (p[5] + r[5]) if counts else 0.0
        x_2, v_2 = x_1 if none else x_2, v_1 if none else v_2
        moves = goes_on or counts
        at[X + i], at[V + i] = x_2 if moves else x, v_2 if moves else v
        at[D + i] = d_2 if counts else d
        at[X_STOP + i], at[STOPS + i] = x_s, 1.0 if stops else 0.0
        at[SUMS + EVENTS * LANES + i] += 1.0 if counts else 0.0
        closest = at[SUMS + CLOSEST * LANES + i]
        at[SUMS + CLOSEST * LANES + i] = min(closest, tight if stops else math.inf)
        farthest = at[SUMS + FARTHEST * LANES + i]
        at[SUMS + FARTHEST * LANES + i] = max(farthest, abs(x_s) if stops else 0.0)
        at[DONE + i] += 1.0 if moves else 0.0
        at[HANDLED + i] = 1.0 if moves or not here else 0.0


@compiled
def defer_events(at):
    """Mark the event steps of one register of lanes as not handled."""
    for i in range(WIDTH):
        at[STOPS + i], at[HANDLED + i] = 0.0, 0.0 if at[AT_EVENT + i] > 0.0 else 1.0


@inlined
def finish_event_steps(plant, law, steps, parts, rule, buffers, first, stops, record):
    """Record the stops of one register of lanes, and solve unhandled steps one by one."""
    queue, last = buffers.queue[first:], len(stops) - 1
    for i in range(WIDTH):
        lane = buffers.lane[first + i]
        # Surplus lanes repeat the last record, so they write the same values.
        row = stops[min(record + lane, last)]
        if queue[STOPS + i] > 0.0:
            record_stop(row, buffers.stop_counts, lane, queue[X_STOP + i])
        if queue[HANDLED + i] == 0.0:
            solve_single_step(plant, law, steps, parts, rule, buffers, first + i, lane, row)


@inlined
def record_stop(stops, stop_counts, lane, x_r):
    """Record a stop of a lane."""
    n = stop_counts[lane]
    if n < len(stops):
        stops[n] = x_r
    stop_counts[lane] = n + 1


@compiled
def solve_single_step(plant, law, steps, parts, rule, buffers, i, lane, stops):
    """Advance the i-th waiting lane through a step with any number of events."""
    at, log, results = buffers.queue, buffers.log, buffers.results[lane]
    x, v, d = at[X + i], at[V + i], int(at[D + i])
    u_0, u_1 = at[U + i], at[U_1 + i]
    at[DONE + i] += 1.0
    x_end, v_end, _, d_end, count, closest = step_through_events(
        plant, law, steps, parts, (), u_0, u_1, 0, x, v, d, log, 0, results[CLOSEST]
    )
    if count < 0:
        at[X + i], at[V + i] = float("nan"), float("nan")
        return
    at[X + i], at[V + i], at[D + i] = x_end, v_end, float(d_end)
    results[CLOSEST] = closest
    results[EVENTS] += count
    slope, start = (u_1 - u_0) / steps.dt, 0.0
    add_end_correction(rule, steps, results, x, v, d, u_0, slope, -1.0)
    add_end_correction(rule, steps, results, x_end, v_end, d_end, u_1, slope, 1.0)
    for k in range(count + 1):
        end = log.s[k] if k < count else steps.dt
        part = integrate_linear_segment(steps, u_0 + slope * start, slope, x, v, d, end - start)
        for i in range(5):
            results[i] += part[i]
        results[STUCK] += end - start if d == 0 else 0.0
        if k < count:
            start, x, v, d = end, log.x_r[k], 0.0, direction_after(log.kind[k])
            if abs(log.kind[k]) != SLIP:
                record_stop(stops, buffers.stop_counts, lane, x)
                results[FARTHEST] = max(results[FARTHEST], abs(x))


@inlined
def add_end_correction(rule, steps, results, x, v, d, u, slope, sign):
    """Subtract the contribution of the sums at the end of a step, or at its start (sign -1)."""
    minus_x_dd = steps.c * v + (steps.w * x + d * steps.f)
    half, end = (
        half_sample(rule, d, x, minus_x_dd, u, v),
        end_corrections(rule, d, x, minus_x_dd, u, v, slope),
    )
    for k in range(6):
        results[k] -= half[k] + sign * end[k]


@compiled
def restore_lanes(buffers, count):
    """Copy the waiting lanes back, and add their results."""
    at, queue = buffers.at, buffers.queue
    for i in range(count):
        lane = buffers.lane[i]
        at[X + lane], at[V + lane] = queue[X + i], queue[V + i]
        at[D + lane] = queue[D + i]
        results = buffers.results[lane]
        for k in range(EVENTS + 1):
            results[k] += queue[SUMS + k * LANES + i]
        results[CLOSEST] = min(results[CLOSEST], queue[SUMS + CLOSEST * LANES + i])
        results[FARTHEST] = max(results[FARTHEST], queue[SUMS + FARTHEST * LANES + i])


# Integrals over many steps, from sums over samples.


SERIES_TERMS = 18
"""Terms of the Euler-Maclaurin series. At the longest step each is a tenth of the last one."""

MAX_STEP_RADIANS = 1.0
"""Longest step for this number of terms, in radians (or decays) of the oscillator."""

MAX_CACHED_FORMS = 16
"""Number of steps whose forms are cached: each block of a scene needs them."""

X_R, MINUS_X_DD, BASE, SPEED, RATE, SLOPE = range(6)
"""Variables of a sliding step: x_r, -x_dd, ü, v_r and its rate, the slope of ü."""


class EndForms(NamedTuple):
    """Quadratic forms at the ends of a step: the corrections of the trapezoidal rule.

    Attributes
    ----------
    h : float
        Length of a step [s].
    x2, x_dd2 : tuple of float, shape (8,)
        Coefficients of x_r (-x_dd) times v, a and s; of v times v, a and s; of a times a and
        s. Here v is v_r, a its rate and s the slope of ü.
    v2 : tuple of float, shape (5,)
        The last five of these.
    power : tuple of float, shape (5,)
        Of ü times v, a and s; of v times s; of a times s.
    distance : tuple of float, shape (2,)
        Coefficients of v and a in the distance slid.
    """

    h: float
    x2: tuple[float, ...]
    v2: tuple[float, ...]
    x_dd2: tuple[float, ...]
    power: tuple[float, ...]
    distance: tuple[float, ...]


def is_accurate(plant, dt):
    """Return whether the quadrature rule is accurate for steps of length dt [s]."""
    return bool((plant.b / plant.m + math.sqrt(plant.k_x / plant.m)) * dt <= MAX_STEP_RADIANS)


@lru_cache(maxsize=MAX_CACHED_FORMS)
def make_end_forms(c, w, h):
    """Return the end forms of a step h [s] for b/m = c [1/s] and k_x/m = w [1/s²]."""
    rates = np.zeros((6, 6))
    rates[X_R, SPEED] = rates[BASE, SLOPE] = rates[SPEED, RATE] = 1.0
    rates[MINUS_X_DD, [SPEED, RATE]] = w, c
    rates[RATE, [SPEED, RATE, SLOPE]] = -w, -c, -1.0
    rest = ((SPEED, SPEED), (SPEED, RATE), (SPEED, SLOPE), (RATE, RATE), (RATE, SLOPE))

    def of(step_map, other, pairs):
        form = end_form(rates, h, step_map, other)
        return tuple(float(form[pair]) for pair in pairs)

    def beside(row):
        return (row, SPEED), (row, RATE), (row, SLOPE)

    return EndForms(
        float(h),
        of(X_R, X_R, (*beside(X_R), *rest)),
        of(SPEED, SPEED, rest),
        of(MINUS_X_DD, MINUS_X_DD, (*beside(MINUS_X_DD), *rest)),
        of(BASE, SPEED, (*beside(BASE), (SPEED, SLOPE), (RATE, SLOPE))),
        line_form(rates, h),
    )


def end_form(rates, h, step_map, other):
    """Return the quadratic form at a step end for the product of two variables, symmetrised."""
    form, found = np.zeros((6, 6)), np.zeros((6, 6))
    form[step_map, other] = 1.0
    for k, weight in enumerate(series_weights(), 1):
        form = rates.T @ form + form @ rates
        found -= weight * h ** (2 * k) * form
        form = rates.T @ form + form @ rates
    both = found + found.T
    np.fill_diagonal(both, np.diag(found))
    return both


def line_form(rates, h):
    """Return the weights of v_r and its rate at the end of a step in the distance slid."""
    line, found = np.zeros(6), np.zeros(6)
    line[SPEED] = 1.0
    for k, weight in enumerate(series_weights(), 1):
        line = rates.T @ line
        found -= weight * h ** (2 * k) * line
        line = rates.T @ line
    return float(found[SPEED]), float(found[RATE])


def series_weights():
    """Return B_2k/(2k)! for k = 1, 2, ... (Euler-Maclaurin), with Bernoulli numbers B_2k."""
    terms = [1.0]  # of z/(e^z - 1), whose odd ones but the first vanish
    factorials = np.cumprod([1.0, *range(1, 2 * SERIES_TERMS + 2)])
    for n in range(1, 2 * SERIES_TERMS + 1):
        terms.append(-sum(terms[k] / factorials[n - k + 1] for k in range(n)))
    return terms[2::2]


@inlined_with_fma
def integrals_from_sums(rule, constants, sums, d_bend, stuck_bend, stuck):
    """Return the integrals that follow from sums over samples.

    Parameters
    ----------
    rule : EndForms
    constants : StepConstants
    sums : tuple of float, shape (9,)
        Sums of x_r², v_r², x_dd², ü v_r, |v_r| and ü²; of x_r, v_r and ü times the second
        difference of ü, the first and the last where the mass slides.
    d_bend, stuck_bend, stuck : float
        Those of the direction times that, and of ü times that where it sticks; how many
        samples there are where it sticks.

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    h = rule.h
    xs, vs, us = -sums[6] / h, -sums[7] / h, -sums[8] / h
    minus_x_dd_s = constants.w * xs + constants.c * vs - constants.f * d_bend / h
    as_ = -(minus_x_dd_s + us)
    p, q, r, t = rule.x2, rule.v2, rule.x_dd2, rule.power
    return (
        h * sums[0] + (p[2] * xs + p[5] * vs + p[7] * as_),
        h * sums[1] + (q[2] * vs + q[4] * as_),
        h * sums[2] + (r[2] * minus_x_dd_s + r[5] * vs + r[7] * as_) + h / 6.0 * stuck_bend,
        h * sums[3] + (t[2] * us + t[3] * vs + t[4] * as_),
        h * sums[4],
        h * stuck,
        h * sums[5] + h / 6.0 * (sums[8] + stuck_bend),
    )


@inlined_with_fma
def end_corrections(rule, d, x_r, minus_x_dd, u_dd, v_r, slope):
    """Return the end correction of a step: added at its end, subtracted at its start.

    Parameters
    ----------
    rule : EndForms
    d : float
        Direction of sliding, 0 where it sticks.
    x_r, minus_x_dd, u_dd, v_r : float
        Displacement [m]; minus x_dd where it slides, and ü [m/s²]; velocity [m/s].
    slope : float
        Of ü within the step [m/s³].

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    slides = d != 0.0
    base = -rule.h * rule.h / 6.0 * u_dd * slope
    a = -(minus_x_dd + u_dd) if slides else 0.0
    s = slope if slides else 0.0
    vv, va, vs, aa, as_ = v_r * v_r, v_r * a, v_r * s, a * a, a * s
    p, q, r, t, o = rule.x2, rule.v2, rule.x_dd2, rule.power, rule.distance
    x2 = x_r * (p[0] * v_r + p[1] * a + p[2] * s)
    x2 += p[3] * vv + p[4] * va + p[5] * vs + p[6] * aa + p[7] * as_
    x_dd2 = minus_x_dd * (r[0] * v_r + r[1] * a + r[2] * s)
    x_dd2 += r[3] * vv + r[4] * va + r[5] * vs + r[6] * aa + r[7] * as_
    return (
        x2,
        q[0] * vv + q[1] * va + q[2] * vs + q[3] * aa + q[4] * as_,
        x_dd2 if slides else base,
        u_dd * (t[0] * v_r + t[1] * a + t[2] * s) + (t[3] * vs + t[4] * as_),
        d * (o[0] * v_r + o[1] * a),
        0.0,
        base,
    )


@inlined_with_fma
def half_sample(rule, d, x_r, minus_x_dd, u_dd, v_r):
    """Return the contribution of half a sample; parameters as in `end_corrections`."""
    half = 0.5 * rule.h
    x_dd = minus_x_dd if d != 0.0 else u_dd
    return (
        half * (x_r * x_r), half * (v_r * v_r), half * (x_dd * x_dd), half * (u_dd * v_r),
        half * (d * v_r), 0.0 if d != 0.0 else half, half * (u_dd * u_dd),
    )  # fmt: skip


# Integrals over both parts of a short step with an event.


INNER = (0.17267316464601143, 0.5, 0.8273268353539886)

WEIGHTS = (0.2722222222222222, 0.35555555555555557, 0.2722222222222222)

OUTER = 0.05
"""Gauss-Lobatto rule with five nodes. The values at both ends are known, and it is as accurate
as Gauss-Legendre with four nodes, which reaches double precision on a short step."""


@inlined_with_fma
def integrate_beside_event(steps, q, x_s, d, u_s, slope, s, x_e, v_e, minus_x_dd_e, u_e):
    """Return the integrals of x_r², v_r², x_dd² and ü v_r from an event to an end of the step.

    Parameters
    ----------
    steps : SlipSteps
    q : tuple of float
        Series of the speed from the event on, or back from it.
    x_s, u_s : float
        x_r [m] and ü [m/s²] at the event.
    d : float
        Direction, 0 where it sticks.
    slope : float
        Of ü [m/s³].
    s : float
        Time from the event to the end [s]; below 0 to the beginning of the step.
    x_e, v_e, minus_x_dd_e, u_e : float
        What is there: x_r, v_r, minus x_dd where it slides, and ü.
    """
    c, w, pull, slides = steps.c, steps.w, d * steps.f, d != 0.0
    first = w * x_s + pull if slides else u_s
    last = minus_x_dd_e if slides else u_e
    x2 = OUTER * (x_s * x_s + x_e * x_e)
    v2, power = OUTER * (v_e * v_e), OUTER * (u_e * v_e)
    x_dd2 = OUTER * (first * first + last * last)
    for i in range(len(INNER)):
        t = s * INNER[i]
        path, speed_there = distance_and_speed(q, t)
        x, v, u = x_s + d * path, d * speed_there, u_s + slope * t
        x_dd = w * x + c * v + pull if slides else u
        x2 += WEIGHTS[i] * (x * x)
        v2 += WEIGHTS[i] * (v * v)
        x_dd2 += WEIGHTS[i] * (x_dd * x_dd)
        power += WEIGHTS[i] * (u * v)
    h = abs(s)
    return h * x2, h * v2, h * x_dd2, h * power


@inlined_with_fma
def distance_and_speed(q, s):
    """Return distance and speed at time s from an event, where the speed is 0."""
    s_2 = s * s
    s_4 = s_2 * s_2
    v = (q[1] + q[2] * s) + s_2 * (q[3] + q[4] * s)
    v += s_4 * ((q[5] + q[6] * s) + s_2 * (q[7] + q[8] * s))
    x = (q[1] * (1.0 / 2.0) + q[2] * (1.0 / 3.0) * s) + s_2 * (
        q[3] * (1.0 / 4.0) + q[4] * (1.0 / 5.0) * s
    )
    x += s_4 * (
        (q[5] * (1.0 / 6.0) + q[6] * (1.0 / 7.0) * s)
        + s_2 * (q[7] * (1.0 / 8.0) + q[8] * (1.0 / 9.0) * s)
    )
    return s_2 * x, s * v
