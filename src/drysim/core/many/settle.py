"""Lanes that waited are sent on, and those by themselves whose step is not so plain."""

from __future__ import annotations

from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.events import SLIP, Log, direction
from drysim.core.many import queue
from drysim.core.many.lanes import (
    LANES,
    PLACE,
    PLACES,
    RISE,
    D,
    U,
    V,
    X,
)
from drysim.core.many.trapezia import INTEGRALS, ends, halves
from drysim.core.samples.eventful import through_events
from drysim.core.stretches import stretch

EVENTS, CLOSEST, FARTHEST, KEPT = range(INTEGRALS, INTEGRALS + 4)
"""What is kept of every lane after the integrals: its events, its tightest decision, and the
greatest |x_r| at a stop."""


class Side(NamedTuple):
    """What the lanes of a march share as scratch, and what is kept of each; arrays.

    Attributes
    ----------
    at : array, shape (SIZE,)
        The lanes, see `lanes`.
    base : array, shape (PLACES * LANES,)
        ü as it is fetched.
    queue : array, shape (queue.SIZE,)
        Those that wait, see `queue`.
    lane : array of int, shape (LANES,)
        Which they are.
    kept : array, shape (LANES, KEPT)
        What is kept of every lane.
    turns : array of int, shape (LANES,)
        How many stops were written of every lane.
    log : Log
        Of a step that is solved by itself.
    """

    at: Any
    base: Any
    queue: Any
    lane: Any
    kept: Any
    turns: Any
    log: Log


@inlined
def settle(plant, law, steps, rule, inner, parts, waves, side, count, turns, first):
    """Send the lanes on to where they got, and those by themselves that did not get there."""
    at, found, last = side.at, side.queue, len(turns) - 1
    for i in range(count):
        lane = side.lane[i]
        at[X + lane], at[V + lane] = found[queue.X + i], found[queue.V + i]
        at[D + lane], at[U + lane] = found[queue.D + i], found[queue.U + i]
        at[RISE + lane] = found[queue.RISE + i]
        at[PLACE + lane] += found[queue.WENT + i]
    for i in range(count):
        kept = side.kept[side.lane[i]]
        for k in range(INTEGRALS):
            kept[k] += found[queue.SUMS + k * LANES + i]
        kept[EVENTS] += found[queue.EVENTS + i]
        kept[CLOSEST] = min(kept[CLOSEST], found[queue.TIGHT + i])
    for i in range(count):
        lane = side.lane[i]
        # Lanes that are left over follow the last record, so they write what it writes.
        mine = turns[min(first + lane, last)]
        if found[queue.STOPS + i] > 0.0:
            stops(side.kept[lane], mine, side.turns, lane, found[queue.X_STOP + i])
        if found[queue.PLAIN + i] == 0.0:
            by_itself(plant, law, steps, rule, inner, parts, waves, side, lane, mine)


@inlined
def stops(kept, mine, turns, lane, x_r):
    """Note a stop of a lane."""
    n = turns[lane]
    if n < len(mine):
        mine[n] = x_r
    turns[lane] = n + 1
    kept[FARTHEST] = max(kept[FARTHEST], abs(x_r))


@compiled
def by_itself(plant, law, steps, rule, inner, parts, waves, side, lane, turns):
    """Carry one lane through a step that holds any number of events."""
    at, log, kept = side.at, side.log, side.kept[lane]
    x, v, d = at[X + lane], at[V + lane], int(at[D + lane])
    place = int(at[PLACE + lane])
    u_0, u_1 = at[U + lane], side.base[lane * PLACES + place + 1]
    at[U + lane], at[RISE + lane], at[PLACE + lane] = u_1, u_1 - u_0, place + 1.0
    x_end, v_end, d_end, count, closest = through_events(
        plant, law, steps, inner, parts, u_0, u_1, 0, x, v, d, log, 0, kept[CLOSEST]
    )
    if count < 0:
        at[X + lane], at[V + lane] = float("nan"), float("nan")
        return
    at[X + lane], at[V + lane], at[D + lane] = x_end, v_end, float(d_end)
    kept[CLOSEST] = closest
    kept[EVENTS] += count
    slope, start = (u_1 - u_0) / steps.dt, 0.0
    replace(rule, steps, kept, x, v, d, u_0, slope, -1.0)
    replace(rule, steps, kept, x_end, v_end, d_end, u_1, slope, 1.0)
    for k in range(count + 1):
        end = log.s[k] if k < count else steps.dt
        part = stretch(
            plant, law, steps, waves, u_0 + slope * start, slope, x, v, d, end - start
        )
        for i in range(5):
            kept[i] += part[i]
        kept[5] += end - start if d == 0 else 0.0
        if k < count:
            start, x, v, d = end, log.x_r[k], 0.0, direction(log.kind[k])
            if abs(log.kind[k]) != SLIP:
                stops(kept, turns, side.turns, lane, x)


@inlined
def replace(rule, steps, kept, x, v, d, u, slope, side):
    """Take off what sums make of an end of a step; the end has side 1, the beginning -1."""
    felt = steps.c * v + (steps.w * x + d * steps.f)
    half, end = halves(rule, d, x, felt, u, v), ends(rule, d, x, felt, u, v, slope)
    for k in range(6):
        kept[k] -= half[k] + side * end[k]
