"""Many records of base motion in one call: marched and measured, with nothing kept of them."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import first_mode
from drysim.core.many.abreast import through_abreast
from drysim.core.many.lanes import (
    EVENTFUL,
    FETCHED,
    KINDS,
    LANES,
    PRODUCTS,
    TILE,
    WIDTH,
    D,
    U,
    V,
    X,
    fetch,
    go_round,
    take,
)
from drysim.core.many.lockstep import CLOSEST, E_X2, EVENTS, KEPT, gather, settle, step_all
from drysim.core.many.products import add_products
from drysim.core.samples.series import BRIEF
from drysim.core.samples.steps import parts_of, steps_of

(
    X_BEGIN, V_BEGIN, X_END, V_END, BEGIN, TURNS, COUNT, TIGHT, X2, V2, X_DD2, POWER, RUB,
    STUCK_TIME, FOUND,
) = range(KINDS, KINDS + 15)  # fmt: skip
"""Columns of an answer, after the sums of products over the whole steps of the window: the
states at both ends of the window; stops before the window, and in all; events; tightest stop
decision; the integrals over the steps of the window that hold events, as in `Totals`. FOUND is
their number."""

GATHERED = 1024
"""Samples after which sums are added to those of longer stretches: so rounding does not grow
with the length of a record."""


@compiled
def measure_records(
    plant, law, steps, waves, records, begin, end, start, side, turns, answers
):  # fmt: skip
    """March and measure every record.

    Parameters
    ----------
    plant, law, steps
        Steps that are `fine`.
    waves : Waves
        None of them.
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
        march_abreast(
            plant, law, steps, waves, records, first, count, 0, begin, side, turns, answers
        )
        note_begin(side, answers, first, count)
        march_abreast(
            plant, law, steps, waves, records, first, count, begin, end, side, turns, answers
        )
        note_end(side, answers, first, count)


@inlined
def lanes_of(count):
    """Give how many lanes so many records take: whole registers."""
    return (count + WIDTH - 1) // WIDTH * WIDTH


@compiled
def set_out(plant, law, records, first, count, start, side):
    """Begin with every record; lanes that are left over follow the last one."""
    at = side.at
    for lane in range(lanes_of(count)):
        u_dd = records[first + min(lane, count - 1), 0]
        at[X + lane], at[V + lane] = start.x_r, start.v_r
        at[D + lane] = first_mode(plant, law, start.x_r, start.v_r, u_dd)
        side.turns[lane] = 0
        for i in range(KEPT):
            side.kept[lane, i] = 0.0
        side.kept[lane, CLOSEST] = math.inf


@compiled
def note_begin(side, answers, first, count):
    """Note the beginning of the window, and sum from there on."""
    at = side.at
    for lane in range(count):
        answer = answers[first + lane]
        for i in range(KINDS):
            answer[i] = 0.0
        answer[X_BEGIN], answer[V_BEGIN] = at[X + lane], at[V + lane]
        answer[BEGIN] = side.turns[lane]
        for i in range(6):
            side.kept[lane, E_X2 + i] = 0.0
    for i in range(KINDS * LANES):
        at[PRODUCTS + i] = 0.0


@compiled
def note_end(side, answers, first, count):
    """Note the end of the window and what has been found."""
    at = side.at
    for lane in range(count):
        answer, kept = answers[first + lane], side.kept[lane]
        answer[X_END], answer[V_END] = at[X + lane], at[V + lane]
        answer[TURNS], answer[COUNT] = side.turns[lane], kept[EVENTS]
        answer[TIGHT] = kept[CLOSEST]
        for i in range(6):
            answer[X2 + i] = kept[E_X2 + i]


@compiled
def march_abreast(
    plant, law, steps, waves, records, first, count, n, end, side, turns, answers
):
    """March records from sample n to sample `end`, and sum."""
    parts, lanes, at = parts_of(steps, BRIEF), lanes_of(count), side.at
    inner = steps_of(plant, law, steps.dt / parts)
    gathered = n + GATHERED
    fetched, until = n, n
    while n < end:
        if n >= until:
            fetched, until = n, min(n + FETCHED, end)
            fetch(side.base, records, first, count, n, until - n)
        here = min(TILE, until - n)
        take(at, side.base, lanes, n - fetched, here)
        for k in range(here):
            tile = at[k * LANES :]
            step_all(plant, law, steps, tile, lanes)
            some = gather(tile, lanes, side.some, side.events, side.lane)
            if parts == 1:
                through_abreast(plant, law, steps, side.events, some)
            settle(plant, law, steps, inner, parts, waves, side, tile, some, turns, first)
        for k in range(here, TILE):
            leave_out(at, lanes, k)
        add_products(steps, at, lanes)
        go_round(at, lanes)
        n += here
        if n >= gathered or n >= end:
            gathered = n + GATHERED
            gather_sums(at, answers, first, count)


@compiled
def leave_out(at, lanes, k):
    """Let a step of a tile count for nothing, and lead to where it begins."""
    for lane in range(lanes):
        at[X + (k + 1) * LANES + lane] = at[X + k * LANES + lane]
        at[V + (k + 1) * LANES + lane] = at[V + k * LANES + lane]
        at[D + (k + 1) * LANES + lane] = at[D + k * LANES + lane]
        at[X + k * LANES + lane], at[V + k * LANES + lane] = 0.0, 0.0
        at[D + k * LANES + lane] = EVENTFUL
        at[U + (k + 1) * LANES + lane] = 0.0


@compiled
def gather_sums(at, answers, first, count):
    """Add the sums of products to those of a whole window."""
    for lane in range(count):
        answer = answers[first + lane]
        for i in range(KINDS):
            answer[i] += at[PRODUCTS + i * LANES + lane]
    for i in range(KINDS * LANES):
        at[PRODUCTS + i] = 0.0
