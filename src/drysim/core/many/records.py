"""Many records of base motion in one call: marched and measured, with nothing kept of them."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import first_mode
from drysim.core.many.abreast import eight, leave
from drysim.core.many.lanes import (
    FETCHED,
    KINDS,
    LANES,
    STRIDE,
    SUMS,
    WAITS,
    WIDTH,
    D,
    V,
    X,
    fetch,
    look_ahead,
)  # fmt: skip
from drysim.core.many.queue import gather
from drysim.core.many.settle import CLOSEST, EVENTS, FARTHEST, KEPT, put_back, settle
from drysim.core.many.stride import pace_of, stride
from drysim.core.many.trapezia import INTEGRALS, ends, halves, summed
from drysim.core.many.walk import walk
from drysim.core.samples.parts import parts_of

X_BEGIN, V_BEGIN, X_END, V_END, BEGIN, TURNS, COUNT, TIGHT, FAR, FOUND = range(
    INTEGRALS, INTEGRALS + 10
)
"""Columns of an answer after the integrals over the window: the states at both ends of the
window; stops before the window, and in all; events; tightest stop decision; greatest |x_r| at
a stop. FOUND is their number."""


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
    """Give how many lanes so many records take: whole registers."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@compiled
def set_out(plant, law, records, first, count, start, side):
    """Begin with every record; lanes that are left over follow the last one."""
    at = side.at
    for i in range(KINDS * LANES):
        at[SUMS + i] = 0.0
    for lane in range(lanes_of(count)):
        u_dd = records[first + min(lane, count - 1), 0]
        at[X + lane], at[V + lane] = start.x_r, start.v_r
        at[D + lane] = first_mode(plant, law, start.x_r, start.v_r, u_dd)
        side.turns[lane] = 0
        for i in range(KEPT):
            side.kept[lane, i] = 0.0
        side.kept[lane, CLOSEST] = math.inf


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
        answer, kept = answers[first + lane], side.kept[lane]
        u_dd = records[first + lane]
        end_of_window(steps, rule, side, lane, 1.0, u_dd[end - 1], u_dd[end])
        answer[X_END], answer[V_END] = at[X + lane], at[V + lane]
        answer[TURNS], answer[COUNT] = side.turns[lane], kept[EVENTS]
        answer[TIGHT], answer[FAR] = kept[CLOSEST], kept[FARTHEST]
        for i in range(INTEGRALS):
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
    parts, pace = parts_of(steps), pace_of(plant, law, steps)
    while n < end:
        length = min(FETCHED, end - n)
        fetch(side.base, records, first, count, lanes, n, length, before)
        for k in range(0, length, STRIDE):
            left = min(STRIDE, length - k)
            look_ahead(side.at, side.base, lanes, k)
            if left == STRIDE:
                stride(pace, side.at, lanes)
            else:
                hold_all(side.at, lanes)
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


@inlined
def hold_all(at, lanes):
    """Let all lanes wait: less than a stride is left."""
    for lane in range(lanes):
        at[WAITS + lane] = 1.0


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
