"""Many sampled records in one call, vectorised over the records (seeds).

Problem
    An ensemble needs the metrics of hundreds of records but not their motion. One march per
    record leaves the vector units of the processor idle.

Method
    - One lane per record: all lanes are at the same sample, and each quantity is a row of one
      array, so that the compiler vectorises over the lanes.
    - All lanes take four steps as if no event occurred. A bound on what a step may hide
      (`pace_of`) finds the lanes in which an event is possible; they keep their state.
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

X2, V2, X_DD2, POWER, RUB, STUCK, U_DD2, INTEGRALS = range(8)
"""Integrals, as in `Totals`, and how many."""

EVENTS, TIGHT, FAR, KEPT = range(INTEGRALS, INTEGRALS + 4)
"""What is kept of every lane after the integrals: its events, its tightest stop decision, and
the greatest |x_r| at a stop. KEPT is how many numbers that is."""

X_BEGIN, V_BEGIN, X_END, V_END, BEGIN, TURNS, FOUND = range(KEPT, KEPT + 7)
"""Columns of an answer after what is kept: the states at both ends of the window; stops before
the window, and in all. FOUND is their number."""

LANES = 128
"""Maximum number of records marched together: few enough to stay in the cache, and enough for
those that wait for an event to fill whole registers."""

WIDTH = 8
"""Numbers in the widest register; lanes are processed in groups of this size."""

STRIDE = 4
"""Steps that are taken at once."""

SEEN = STRIDE + 2
"""Samples that a stride reads: those in it, at both ends, and the one before."""

FETCHED = 256
"""Samples read at a time: a whole number of strides."""

PLACES = (FETCHED + 2) * WIDTH
"""Size of the buffer of samples of a group of lanes: ü at the sample before, at the first one
and so on, for all lanes of the group."""

X, V, D, AHEAD = (row * LANES for row in range(4))
"""Rows of the lanes and of the queue: x_r, v_r and direction; ü at the samples that a stride
reads, one row each."""

SUMS = AHEAD + SEEN * LANES
KINDS = 12
"""First row and number of sums over samples, see `summed`; in the queue KEPT rows, with the
additions to the results."""

WAITS = SUMS + KINDS * LANES
"""Row: whether the lane waits for the search of an event."""

SIZE = WAITS + LANES
"""Size of the array of all lanes."""

DONE, HERE, U, U_1, X_STOP, STOPS, PLAIN = (SUMS + row * LANES for row in range(KEPT, KEPT + 7))
"""Rows of the queue: number of finished steps of the stride; whether the next step may hold an
event, and ü at its ends; x_r at the stop, whether there is one, and whether it converged."""

QUEUE_SIZE = PLAIN + LANES
"""Size of the queue."""


class Side(NamedTuple):
    """Work space shared by the lanes of a march, and results of each lane; arrays.

    Attributes
    ----------
    at : array, shape (SIZE,)
        The lanes.
    base : array, shape (PLACES * LANES / WIDTH,)
        Samples of ü.
    queue : array, shape (QUEUE_SIZE,)
        The lanes that wait for the search of an event.
    lane : array of int, shape (LANES,)
        Numbers of these lanes.
    kept : array, shape (LANES, KEPT)
        Results of every lane.
    turns : array of int, shape (LANES,)
        Number of stops written for every lane.
    log : Log
        Log of a step that is solved without the other lanes.
    """

    at: Any
    base: Any
    queue: Any
    lane: Any
    kept: Any
    turns: Any
    log: EventLog


@compiled
def measure_records(
    plant, law, steps, rule, records, begin, end, start, side, turns, answers
):  # fmt: skip
    """March and measure every record.

    Parameters
    ----------
    plant, law, steps
        Steps that the rule serves.
    rule : Trapezia
        Of such a step.
    records : array, shape (records, samples)
        Base acceleration [m/s²].
    begin, end : int
        Samples at which the window begins and ends.
    start : State
    side : Side
        Scratch.
    turns : array, shape (records, places)
        Written: x_r at every stop up to the end of the window [m], as far as there are places.
    answers : array, shape (records, FOUND)
        Written: the columns named above; no numbers where the numerics fail.
    """
    for first in range(0, len(records), LANES):
        count = min(LANES, len(records) - first)
        set_out(plant, law, records, first, count, start, side)
        march_abreast(plant, law, steps, rule, records, first, count, 0, begin, side, turns)
        note_begin(steps, rule, records, begin, side, answers, first, count)
        march_abreast(plant, law, steps, rule, records, first, count, begin, end, side, turns)
        note_end(steps, rule, records, end, side, answers, first, count)


@inlined
def lanes_of(count):
    """Return the number of lanes for a number of records, a multiple of `WIDTH`."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@compiled
def set_out(plant, law, records, first, count, start, side):
    """Set the start of every record; surplus lanes repeat the last record."""
    at = side.at
    for i in range(KINDS * LANES):
        at[SUMS + i] = 0.0
    for lane in range(lanes_of(count)):
        u_dd = records[first + min(lane, count - 1), 0]
        at[X + lane], at[V + lane] = start.x_r, start.v_r
        at[D + lane] = initial_direction(plant, law, start.x_r, start.v_r, u_dd)
        side.turns[lane] = 0
        for i in range(KEPT):
            side.kept[lane, i] = 0.0
        side.kept[lane, TIGHT] = math.inf


@compiled
def note_begin(steps, rule, records, begin, side, answers, first, count):
    """Note the beginning of the window, and sum from there on."""
    at = side.at
    for lane in range(lanes_of(count)):
        for i in range(INTEGRALS):
            side.kept[lane, i] = 0.0
    for lane in range(count):
        answer, u_dd = answers[first + lane], records[first + lane, begin]
        # What comes before is out of the window: the sums begin as if ü had not changed.
        end_of_window(steps, rule, side, lane, -1.0, u_dd, u_dd)
        answer[X_BEGIN], answer[V_BEGIN] = at[X + lane], at[V + lane]
        answer[BEGIN] = side.turns[lane]


@compiled
def note_end(steps, rule, records, end, side, answers, first, count):
    """Note the end of the window and what has been found."""
    at = side.at
    for lane in range(count):
        answer, kept, u_dd = answers[first + lane], side.kept[lane], records[first + lane]
        end_of_window(steps, rule, side, lane, 1.0, u_dd[end - 1], u_dd[end])
        answer[X_END], answer[V_END] = at[X + lane], at[V + lane]
        answer[TURNS] = side.turns[lane]
        for i in range(KEPT):
            answer[i] = kept[i]


@inlined
def end_of_window(steps, rule, side, lane, way, u_b, u):
    """Add half a sample at the end of the window; take it off at its beginning.

    There ü is `u`, and `u_b` at the sample before.
    """
    at, kept = side.at, side.kept[lane]
    x, v, d = at[X + lane], at[V + lane], at[D + lane]
    felt = steps.c * v + (steps.w * x + d * steps.f)
    half = halves(rule, d, x, felt, u, v)
    end = ends(rule, d, x, felt, u, v, (u - u_b) / steps.dt)
    for i in range(INTEGRALS):
        kept[i] += way * (half[i] + end[i])


@compiled
def march_abreast(plant, law, steps, rule, records, first, count, n, end, side, turns):
    """March records from sample n to sample `end`, and sum."""
    lanes, before = lanes_of(count), n
    parts, pace = make_substeps(steps), pace_of(plant, law, steps)
    while n < end:
        length = min(FETCHED, end - n)
        fetch(side.base, records, first, count, lanes, n, length, before)
        for k in range(0, length, STRIDE):
            left = min(STRIDE, length - k)
            look_ahead(side.at, side.base, lanes, k)
            if left == STRIDE:
                stride(pace, side.at, lanes)
            else:
                # Less than a stride is left: all lanes wait.
                for lane in range(lanes):
                    side.at[WAITS + lane] = 1.0
            some = gather(side.at, lanes, side.queue, side.lane)
            for group in range(0, some, WIDTH):
                waiting = side.queue[group:]
                while walk(pace, rule, waiting, left) > 0:
                    if steps.brief:
                        eight(plant, law, steps, pace, rule, waiting)
                    else:
                        leave(waiting)
                    settle(plant, law, steps, parts, rule, side, group, turns, first)
            put_back(side, some)
        n += length
        before = n - 1
        gather_sums(rule, pace, side, lanes)


@compiled
def gather_sums(rule, pace, side, lanes):
    """Add the sums to what is kept of a whole window: so rounding does not grow with them."""
    at = side.at
    for lane in range(lanes):
        i = SUMS + lane
        z = (
            at[i], at[i + LANES], at[i + 2 * LANES], at[i + 3 * LANES], at[i + 4 * LANES],
            at[i + 5 * LANES], at[i + 6 * LANES], at[i + 7 * LANES], at[i + 8 * LANES],
        )  # fmt: skip
        total = summed(rule, pace, z, at[i + 11 * LANES], at[i + 9 * LANES], at[i + 10 * LANES])
        for k in range(INTEGRALS):
            side.kept[lane, k] += total[k]
    for i in range(KINDS * LANES):
        at[SUMS + i] = 0.0


@compiled
def fetch(base, records, first, count, lanes, n, length, before):
    """Fetch ü from sample n to n + length; lanes that are left over follow the last record.

    `before` is the sample that comes before: n itself where nothing does.
    """
    last = first + count - 1
    for lane in range(0, lanes, WIDTH):
        r, places = first + lane, base[lane // WIDTH * PLACES :]
        a, b = records[min(r, last)], records[min(r + 1, last)]
        c, d = records[min(r + 2, last)], records[min(r + 3, last)]
        e, f = records[min(r + 4, last)], records[min(r + 5, last)]
        g, h = records[min(r + 6, last)], records[min(r + 7, last)]
        for k in range(length + 2):
            n_k, group = n - 1 + k if k > 0 else before, places[WIDTH * k :]
            group[0], group[1], group[2], group[3] = a[n_k], b[n_k], c[n_k], d[n_k]
            group[4], group[5], group[6], group[7] = e[n_k], f[n_k], g[n_k], h[n_k]


@compiled
def look_ahead(at, base, lanes, k):
    """Put ü at the samples that a stride from the k-th one fetched on sees side by side."""
    for lane in range(0, lanes, WIDTH):
        seen, there = base[lane // WIDTH * PLACES + k * WIDTH :], at[AHEAD + lane :]
        for row in range(SEEN):
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


class Pace(NamedTuple):
    """What a step takes, should nothing happen in it: mass, spring and friction, its map.

    Attributes
    ----------
    m, k_x, F_fs : float
    c, w, f : float
        b/m [1/s], k_x/m [1/s²] and F_fk/m [m/s²].
    one : Map
    x_0, x_1, v_0, v_1 : float
        As in `Steps`.
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
def pace_of(plant, law, steps):
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
    return Pace(
        plant.m, plant.k_x, law.F_fs, c, w, steps.f, steps.step_map,
        steps.x_0, steps.x_1, steps.v_0, steps.v_1, steep, steep * (c + w * dt),
    )  # fmt: skip


class Grip(NamedTuple):
    """What does not change in a lane during a stride.

    Attributes
    ----------
    d : float
        Direction of sliding, 0 where it sticks.
    slides : bool
    pull, x_f, v_f : float
        Friction per mass [m/s²], and what it takes from x_r and v_r in a step.
    F_k, hold : float
        Force of the spring and what the contact bears [N], of a stuck lane.
    """

    d: float
    slides: bool
    pull: float
    x_f: float
    v_f: float
    F_k: float
    hold: float


@inlined_with_fma
def grip_of(pace, x, d):
    """Return the per-record constants of the next four steps, from the state at their start."""
    F_k = pace.k_x * x
    hold = pace.F_fs + FORCE_ROUNDING * (pace.F_fs + abs(F_k))
    return Grip(
        d, d != 0.0, pace.f * d, pace.step_map.x_f * d, pace.step_map.v_f * d, F_k, hold
    )


@inlined_with_fma
def step(pace, grip, x, v, u, u_1):
    """Return the state at the end of a step, and -x_dd at its start where the mass slides."""
    # What the state takes part in comes last: the next step waits for it.
    step_map = pace.step_map
    x_1 = step_map.x_x * x + (step_map.x_v * v - (pace.x_0 * u + (pace.x_1 * u_1 + grip.x_f)))
    v_1 = step_map.v_v * v + (step_map.v_x * x - (pace.v_0 * u + (pace.v_1 * u_1 + grip.v_f)))
    felt = pace.c * v + (pace.w * x + grip.pull)
    return x_1 if grip.slides else x, v_1 if grip.slides else 0.0, felt


@inlined_with_fma
def added(z, x, v, felt, u, bend):
    """Add a sample to sums of products; `bend` is what the change of ü changes by there."""
    return (
        x * x + z[0], v * v + z[1], felt * felt + z[2], u * v + z[3], v + z[4], u * u + z[5],
        x * bend + z[6], v * bend + z[7], u * bend + z[8],
    )  # fmt: skip


NOTHING = (0.0,) * 9
"""Sums of no samples."""


@compiled
def stride(pace, at, lanes):
    """Advance every lane by four steps, or mark it as waiting if a step may hold an event."""
    for first in range(0, lanes, WIDTH):
        stride_of_eight(pace, at[first:])


@inlined_with_fma
def stride_of_eight(pace, at):
    """Advance one register of lanes; see `stride`."""
    for i in range(WIDTH):
        x, v, d = at[X + i], at[V + i], at[D + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + 5 * LANES + i]
        r_0, r_1, r_2, r_3, r_4 = u - u_b, u_1 - u, u_2 - u_1, u_3 - u_2, u_4 - u_3
        grip = grip_of(pace, x, d)
        slides, F_k, hold = grip.slides, grip.F_k, grip.hold
        x_1, v_1, felt = step(pace, grip, x, v, u, u_1)
        z = added(NOTHING, x, v, felt, u, r_1 - r_0)
        x_2, v_2, felt = step(pace, grip, x_1, v_1, u_1, u_2)
        z = added(z, x_1, v_1, felt, u_1, r_2 - r_1)
        x_3, v_3, felt = step(pace, grip, x_2, v_2, u_2, u_3)
        z = added(z, x_2, v_2, felt, u_2, r_3 - r_2)
        x_4, v_4, felt = step(pace, grip, x_3, v_3, u_3, u_4)
        z = added(z, x_3, v_3, felt, u_3, r_4 - r_3)
        # Whether any of these steps may hold an event is asked of all of them at once.
        s_0, s_1, s_2, s_3, s_4 = d * v, d * v_1, d * v_2, d * v_3, d * v_4
        slow = min(min(min(s_0, s_1), min(s_2, s_3)), s_4)
        fast = max(max(max(s_0, s_1), max(s_2, s_3)), s_4)
        change = max(max(abs(r_1), abs(r_2)), max(abs(r_3), abs(r_4)))
        low, high = min(min(u_1, u_2), min(u_3, u_4)), max(max(u_1, u_2), max(u_3, u_4))
        stops = slow <= pace.steep * change + pace.fast * (fast + fast)
        breaks = pace.m * high + F_k > hold or pace.m * low + F_k < -hold
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


# Lanes that wait: gathered, walked to the step they wait for, led through it, and put back.
#
# `walk` and `eight` are kernels of their own: what is fused is compiled into its callers.


@compiled
def gather(at, count, queue, whose):
    """Gather the lanes that wait among the first `count`; gives how many there are.

    Which they are is written to `whose`, and they themselves to `queue`: what is found is
    nothing yet; a group is filled up with lanes that are done.
    """
    some = 0
    for lane in range(count):
        whose[some] = lane
        some += 1 if at[WAITS + lane] > 0.0 else 0
    for i in range(some):
        lane = whose[i]
        queue[X + i], queue[V + i] = at[X + lane], at[V + lane]
        queue[D + i] = at[D + lane]
        for k in range(SEEN):
            queue[AHEAD + k * LANES + i] = at[AHEAD + k * LANES + lane]
    filled = lanes_of(some)
    for i in range(filled):
        queue[DONE + i] = 0.0 if i < some else STRIDE
    for k in range(KEPT):
        nothing = math.inf if k == TIGHT else 0.0
        for i in range(filled):
            queue[SUMS + k * LANES + i] = nothing
    return some


@inlined_with_fma
def may_hold(pace, grip, v, v_1, felt, u, u_1):
    """Return whether a step from one state to another may hold an event."""
    along, along_1 = grip.d * v, grip.d * v_1
    doubt = pace.steep * abs(u_1 - u) + pace.fast * (along + along_1)
    dips = min(along, along_1) <= doubt and grip.d * (felt + u) > 0.0
    stops, breaks = along_1 <= 0.0 or dips, abs(pace.m * u_1 + grip.F_k) > grip.hold
    return stops if grip.slides else breaks


@inlined_with_fma
def one_on(pace, grip, state, u_b, u, u_1, going, z):
    """Return the result of one step of an advancing lane, and whether it is before an event."""
    x, v, done, bends = state
    x_1, v_1, felt = step(pace, grip, x, v, u, u_1)
    event = may_hold(pace, grip, v, v_1, felt, u, u_1)
    goes, here = going and not event, going and event
    bend = (u_1 - u) - (u - u_b)
    counted = added(z, x, v, felt if grip.slides else u, u, bend)
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
def walk(pace, rule, at, length):
    """Advance one register of waiting lanes, to an event or to the end of the stride.

    Returns the number of lanes before an event. `length` is that of the stride in steps.
    """
    return walk_of_eight(pace, rule, at, float(length))


@inlined_with_fma
def walk_of_eight(pace, rule, at, length):
    """Walk; see `walk`."""
    events = 0
    for i in range(WIDTH):
        x, v, d, done = at[X + i], at[V + i], at[D + i], at[DONE + i]
        u_b, u, u_1 = at[AHEAD + i], at[AHEAD + LANES + i], at[AHEAD + 2 * LANES + i]
        u_2, u_3 = at[AHEAD + 3 * LANES + i], at[AHEAD + 4 * LANES + i]
        u_4 = at[AHEAD + (STRIDE + 1) * LANES + i]
        grip, first = grip_of(pace, x, d), done
        state = x, v, done, 0.0
        state, h_1, z = one_on(
            pace, grip, state, u_b, u, u_1, done == 0.0 and length > 0.0, NOTHING
        )
        state, h_2, z = one_on(
            pace, grip, state, u, u_1, u_2, state[2] == 1.0 and length > 1.0, z
        )
        state, h_3, z = one_on(
            pace, grip, state, u_1, u_2, u_3, state[2] == 2.0 and length > 2.0, z
        )
        state, h_4, z = one_on(
            pace, grip, state, u_2, u_3, u_4, state[2] == 3.0 and length > 3.0, z
        )
        here, slides = (h_1 or h_2) or (h_3 or h_4), grip.slides
        reached = state[2] - first + (1.0 if here else 0.0)
        total = summed(
            rule, pace,
            (
                z[0], z[1], z[2], z[3], d * z[4], z[5],
                z[6] if slides else 0.0, z[7], z[8] if slides else 0.0,
            ),
            d * state[3], 0.0 if slides else z[8], 0.0 if slides else reached,
        )  # fmt: skip
        at[X + i], at[V + i], at[DONE + i] = state[0], state[1], state[2]
        at[HERE + i] = 1.0 if here else 0.0
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
def fall_abreast(q, h):
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
    # A root that strays may be anywhere; what is made of it shall stay among the numbers.
    good = good and abs(step) <= NEARLY * s and abs(bend * step) <= NEARLY
    return min(max(s, 0.0), h), good


@compiled
def eight(plant, law, steps, pace, rule, at):
    """Carry as many lanes as a register holds through the step that they stand before."""
    through_of_eight(plant, law, steps, pace, rule, at)


@inlined_with_fma
def through_of_eight(plant, law, steps, pace, rule, at):
    """Carry them; see `eight`."""
    h, c, w, f = steps.dt, steps.c, steps.w, steps.f
    m, k_x, F_fs = plant.m, plant.k_x, law.F_fs
    per_h, per_m = 1.0 / h, 1.0 / m
    for i in range(WIDTH):
        x, v, d, u, u_1 = at[X + i], at[V + i], at[D + i], at[U + i], at[U_1 + i]
        slides = d != 0.0
        slope = (u_1 - u) * per_h
        x_1, v_1, felt = step(pace, grip_of(pace, x, d), x, v, u, u_1)
        v_end, felt_1 = d * v_1, c * v_1 + (w * x_1 + d * f)
        a = -d * (u + felt)
        q = series(steps.factors, d * v, a, -d * slope - c * a - w * (d * v))
        stop, good = fall_abreast(q, h)
        # A short step holds one extremum at most.
        none = slides and v_end > 0.0 and (a >= 0.0 or d * (u_1 + felt_1) >= 0.0)
        # Break-away: F_L is linear in time, so it meets the limit at a quotient.
        F_0, climb = m * u + k_x * x, m * slope
        F_out = F_fs if F_0 + climb * h >= 0.0 else -F_fs
        meets = (F_out - F_0) / (climb if climb != 0.0 else 1.0)
        stop = stop if slides else min(max(meets, 0.0), h)
        way = distance(q, stop)
        x_s, u_s = x + d * way, u + slope * stop
        F_L = m * u_s + k_x * x_s
        hold = F_fs + FORCE_ROUNDING * (F_fs + abs(k_x * x_s))
        sticks = slides and abs(F_L) <= hold
        F_L = F_L if slides else F_out
        d_2 = 1.0 if F_L < 0.0 else -1.0
        d_2 = 0.0 if sticks else d_2
        a_2 = 0.0 if sticks else abs(F_L) * per_m - f
        q_2 = series(steps.factors, 0.0, a_2, 0.0 if sticks else -d_2 * slope - c * a_2)
        rest = h - stop
        way_2, v_2 = distance(q_2, rest), d_2 * speed(q_2, rest)
        x_2 = x_s + d_2 * way_2
        bears = abs(m * u_1 + k_x * x_s) <= hold
        fine = bears if sticks else d_2 * v_2 > 0.0 and (not slides or d * F_L > 0.0)
        fine = fine and ((good and v_end <= 0.0) if slides else climb != 0.0)
        here = at[HERE + i] > 0.0
        goes_on, counts = here and none, here and fine and not none
        stops = counts and slides
        larger = max(abs(F_L), F_fs)
        tight = abs(abs(F_L) - F_fs) / (larger if larger > 0.0 else 1.0)
        # Sums count what the rule makes of the step; the integrals take its place.
        a_s = -(d * F_L * per_m + f) if slides else 0.0
        back = series(steps.factors, 0.0, a_s, -d * slope - c * a_s)
        felt_2 = c * v_2 + (w * x_2 + d_2 * f)
        step_map = beside(steps, back, x_s, d, u_s, slope, -stop, x, v, felt, u)
        two = beside(steps, q_2, x_s, d_2, u_s, slope, rest, x_2, v_2, felt_2, u_1)
        p, r = halves(rule, d, x, felt, u, v), halves(rule, d_2, x_2, felt_2, u_1, v_2)
        b = ends(rule, d, x, felt, u, v, slope)
        e = ends(rule, d_2, x_2, felt_2, u_1, v_2, slope)
        still = (0.0 if slides else stop) + (rest if sticks else 0.0)
        x2 = step_map[0] + two[0] - ((p[0] + r[0]) + (e[0] - b[0]))
        v2 = step_map[1] + two[1] - ((p[1] + r[1]) + (e[1] - b[1]))
        x_dd2 = step_map[2] + two[2] - ((p[2] + r[2]) + (e[2] - b[2]))
        power = step_map[3] + two[3] - ((p[3] + r[3]) + (e[3] - b[3]))
        rub = way + way_2 - ((p[4] + r[4]) + (e[4] - b[4]))
        at[SUMS + i] += x2 if counts else 0.0
        at[SUMS + LANES + i] += v2 if counts else 0.0
        at[SUMS + 2 * LANES + i] += x_dd2 if counts else 0.0
        at[SUMS + 3 * LANES + i] += power if counts else 0.0
        at[SUMS + 4 * LANES + i] += rub if counts else 0.0
        at[SUMS + 5 * LANES + i] += still - (p[5] + r[5]) if counts else 0.0
        x_2, v_2 = x_1 if none else x_2, v_1 if none else v_2
        moves = goes_on or counts
        at[X + i], at[V + i] = x_2 if moves else x, v_2 if moves else v
        at[D + i] = d_2 if counts else d
        at[X_STOP + i], at[STOPS + i] = x_s, 1.0 if stops else 0.0
        at[SUMS + EVENTS * LANES + i] += 1.0 if counts else 0.0
        closest = at[SUMS + TIGHT * LANES + i]
        at[SUMS + TIGHT * LANES + i] = min(closest, tight if stops else math.inf)
        farthest = at[SUMS + FAR * LANES + i]
        at[SUMS + FAR * LANES + i] = max(farthest, abs(x_s) if stops else 0.0)
        at[DONE + i] += 1.0 if moves else 0.0
        at[PLAIN + i] = 1.0 if moves or not here else 0.0


@compiled
def leave(at):
    """Leave as many lanes as a register holds before the steps that they stand before."""
    for i in range(WIDTH):
        at[STOPS + i], at[PLAIN + i] = 0.0, 0.0 if at[HERE + i] > 0.0 else 1.0


@inlined
def settle(plant, law, steps, parts, rule, side, first, turns, record):
    """Note the stops of a group of those that wait, and solve by themselves the odd ones."""
    found, last = side.queue[first:], len(turns) - 1
    for i in range(WIDTH):
        lane = side.lane[first + i]
        # Lanes that are left over follow the last record, so they write what it writes.
        mine = turns[min(record + lane, last)]
        if found[STOPS + i] > 0.0:
            stops(mine, side.turns, lane, found[X_STOP + i])
        if found[PLAIN + i] == 0.0:
            by_itself(plant, law, steps, parts, rule, side, first + i, lane, mine)


@inlined
def stops(mine, turns, lane, x_r):
    """Note a stop of a lane."""
    n = turns[lane]
    if n < len(mine):
        mine[n] = x_r
    turns[lane] = n + 1


@compiled
def by_itself(plant, law, steps, parts, rule, side, i, lane, turns):
    """Carry the i-th of those that wait through a step that holds any number of events."""
    at, log, kept = side.queue, side.log, side.kept[lane]
    x, v, d = at[X + i], at[V + i], int(at[D + i])
    u_0, u_1 = at[U + i], at[U_1 + i]
    at[DONE + i] += 1.0
    x_end, v_end, _, d_end, count, closest = step_through_events(
        plant, law, steps, parts, (), u_0, u_1, 0, x, v, d, log, 0, kept[TIGHT]
    )
    if count < 0:
        at[X + i], at[V + i] = float("nan"), float("nan")
        return
    at[X + i], at[V + i], at[D + i] = x_end, v_end, float(d_end)
    kept[TIGHT] = closest
    kept[EVENTS] += count
    slope, start = (u_1 - u_0) / steps.dt, 0.0
    replace(rule, steps, kept, x, v, d, u_0, slope, -1.0)
    replace(rule, steps, kept, x_end, v_end, d_end, u_1, slope, 1.0)
    for k in range(count + 1):
        end = log.s[k] if k < count else steps.dt
        part = integrate_linear_segment(steps, u_0 + slope * start, slope, x, v, d, end - start)
        for i in range(5):
            kept[i] += part[i]
        kept[STUCK] += end - start if d == 0 else 0.0
        if k < count:
            start, x, v, d = end, log.x_r[k], 0.0, direction_after(log.kind[k])
            if abs(log.kind[k]) != SLIP:
                stops(turns, side.turns, lane, x)
                kept[FAR] = max(kept[FAR], abs(x))


@inlined
def replace(rule, steps, kept, x, v, d, u, slope, side):
    """Take off what sums make of an end of a step; the end has side 1, the beginning -1."""
    felt = steps.c * v + (steps.w * x + d * steps.f)
    half, end = halves(rule, d, x, felt, u, v), ends(rule, d, x, felt, u, v, slope)
    for k in range(6):
        kept[k] -= half[k] + side * end[k]


@compiled
def put_back(side, count):
    """Put the lanes that waited back to where they are, with what they came to."""
    at, found = side.at, side.queue
    for i in range(count):
        lane = side.lane[i]
        at[X + lane], at[V + lane] = found[X + i], found[V + i]
        at[D + lane] = found[D + i]
        kept = side.kept[lane]
        for k in range(EVENTS + 1):
            kept[k] += found[SUMS + k * LANES + i]
        kept[TIGHT] = min(kept[TIGHT], found[SUMS + TIGHT * LANES + i])
        kept[FAR] = max(kept[FAR], found[SUMS + FAR * LANES + i])


# Integrals over many steps, from sums over samples.


TERMS = 18
"""Of the series: each is a tenth of the one before where a step is as long as it may be."""

LONGEST = 1.0
"""Radians (or decays) a step may hold for these terms."""

SCENES = 16
"""Whose forms are kept: each block of a scene asks for them."""

X_R, FELT, BASE, SPEED, RATE, SLOPE = range(6)
"""What a step of sliding is made of: x_r, minus x_dd, ü, v_r and its rate, the slope of ü."""


class Trapezia(NamedTuple):
    """The forms at the ends of a step.

    Attributes
    ----------
    h : float
        Length of a step [s].
    x2, x_dd2 : tuple of float, shape (8,)
        Of x_r (minus x_dd) times v, a and s; of v times v, a and s; of a times a and s. Here v
        is v_r, a its rate and s the slope of ü.
    v2 : tuple of float, shape (5,)
        The last five of these.
    power : tuple of float, shape (5,)
        Of ü times v, a and s; of v times s; of a times s.
    rub : tuple of float, shape (2,)
        Of v and a, in the direction of sliding.
    """

    h: float
    x2: tuple[float, ...]
    v2: tuple[float, ...]
    x_dd2: tuple[float, ...]
    power: tuple[float, ...]
    rub: tuple[float, ...]


def served(plant, dt):
    """Return whether the quadrature rule is accurate for steps of length dt [s]."""
    return bool((plant.b / plant.m + math.sqrt(plant.k_x / plant.m)) * dt <= LONGEST)


@lru_cache(maxsize=SCENES)
def trapezia(c, w, h):
    """Return the end forms of a step h [s] for b/m = c [1/s] and k_x/m = w [1/s²]."""
    rates = np.zeros((6, 6))
    rates[X_R, SPEED] = rates[BASE, SLOPE] = rates[SPEED, RATE] = 1.0
    rates[FELT, [SPEED, RATE]] = w, c
    rates[RATE, [SPEED, RATE, SLOPE]] = -w, -c, -1.0
    rest = ((SPEED, SPEED), (SPEED, RATE), (SPEED, SLOPE), (RATE, RATE), (RATE, SLOPE))

    def of(step_map, other, pairs):
        form = end_form(rates, h, step_map, other)
        return tuple(float(form[pair]) for pair in pairs)

    def beside(row):
        return (row, SPEED), (row, RATE), (row, SLOPE)

    return Trapezia(
        float(h),
        of(X_R, X_R, (*beside(X_R), *rest)),
        of(SPEED, SPEED, rest),
        of(FELT, FELT, (*beside(FELT), *rest)),
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
    factorials = np.cumprod([1.0, *range(1, 2 * TERMS + 2)])
    for n in range(1, 2 * TERMS + 1):
        terms.append(-sum(terms[k] / factorials[n - k + 1] for k in range(n)))
    return terms[2::2]


@inlined_with_fma
def summed(rule, pace, sums, d_bend, stuck_bend, stuck):
    """Return the integrals that follow from sums over samples.

    Parameters
    ----------
    rule : Trapezia
    pace : Pace
    sums : tuple of float, shape (9,)
        Those of x_r², v_r², x_dd², ü v_r, |v_r| and ü²; of x_r, v_r and ü times what the
        change of ü changes by at the sample, the first and the last where it slides.
    d_bend, stuck_bend, stuck : float
        Those of the direction times that, and of ü times that where it sticks; how many
        samples there are where it sticks.

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    h = rule.h
    xs, vs, us = -sums[6] / h, -sums[7] / h, -sums[8] / h
    felt_s = pace.w * xs + pace.c * vs - pace.f * d_bend / h
    as_ = -(felt_s + us)
    p, q, r, t = rule.x2, rule.v2, rule.x_dd2, rule.power
    return (
        h * sums[0] + (p[2] * xs + p[5] * vs + p[7] * as_),
        h * sums[1] + (q[2] * vs + q[4] * as_),
        h * sums[2] + (r[2] * felt_s + r[5] * vs + r[7] * as_) + h / 6.0 * stuck_bend,
        h * sums[3] + (t[2] * us + t[3] * vs + t[4] * as_),
        h * sums[4],
        h * stuck,
        h * sums[5] + h / 6.0 * (sums[8] + stuck_bend),
    )


@inlined_with_fma
def ends(rule, d, x_r, felt, u_dd, v_r, slope):
    """Return the end correction of a step: added at its end, subtracted at its start.

    Parameters
    ----------
    rule : Trapezia
    d : float
        Direction of sliding, 0 where it sticks.
    x_r, felt, u_dd, v_r : float
        Displacement [m]; minus x_dd where it slides, and ü [m/s²]; velocity [m/s].
    slope : float
        Of ü within the step [m/s³].

    Returns
    -------
    tuple of float, shape (INTEGRALS,)
    """
    slides = d != 0.0
    base = -rule.h * rule.h / 6.0 * u_dd * slope
    a = -(felt + u_dd) if slides else 0.0
    s = slope if slides else 0.0
    vv, va, vs, aa, as_ = v_r * v_r, v_r * a, v_r * s, a * a, a * s
    p, q, r, t, o = rule.x2, rule.v2, rule.x_dd2, rule.power, rule.rub
    x2 = x_r * (p[0] * v_r + p[1] * a + p[2] * s)
    x2 += p[3] * vv + p[4] * va + p[5] * vs + p[6] * aa + p[7] * as_
    x_dd2 = felt * (r[0] * v_r + r[1] * a + r[2] * s)
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
def halves(rule, d, x_r, felt, u_dd, v_r):
    """Return the contribution of half a sample to every integral; parameters as in `ends`."""
    half = 0.5 * rule.h
    x_dd = felt if d != 0.0 else u_dd
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
def beside(steps, q, x_s, d, u_s, slope, s, x_e, v_e, felt_e, u_e):
    """Return the integrals of x_r², v_r², x_dd² and ü v_r from an event to an end of the step.

    Parameters
    ----------
    steps : Steps
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
    x_e, v_e, felt_e, u_e : float
        What is there: x_r, v_r, minus x_dd where it slides, and ü.
    """
    c, w, pull, slides = steps.c, steps.w, d * steps.f, d != 0.0
    first = w * x_s + pull if slides else u_s
    last = felt_e if slides else u_e
    x2 = OUTER * (x_s * x_s + x_e * x_e)
    v2, power = OUTER * (v_e * v_e), OUTER * (u_e * v_e)
    x_dd2 = OUTER * (first * first + last * last)
    for i in range(len(INNER)):
        t = s * INNER[i]
        way, speed_there = away_from(q, t)
        x, v, u = x_s + d * way, d * speed_there, u_s + slope * t
        x_dd = w * x + c * v + pull if slides else u
        x2 += WEIGHTS[i] * (x * x)
        v2 += WEIGHTS[i] * (v * v)
        x_dd2 += WEIGHTS[i] * (x_dd * x_dd)
        power += WEIGHTS[i] * (u * v)
    h = abs(s)
    return h * x2, h * v2, h * x_dd2, h * power


@inlined_with_fma
def away_from(q, s):
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
