"""Lanes that waited: what is noted of them, and those whose step is not so plain."""

from __future__ import annotations

from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.events import SLIP, Log, direction
from drysim.core.many import queue
from drysim.core.many.lanes import LANES, WIDTH, D, V, X
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
    base : array, shape (PLACES * LANES / WIDTH,)
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
def settle(plant, law, steps, parts, rule, side, first, turns, record):
    """Note the stops of a group of those that wait, and solve by themselves the odd ones."""
    found, last = side.queue[first:], len(turns) - 1
    for i in range(WIDTH):
        lane = side.lane[first + i]
        # Lanes that are left over follow the last record, so they write what it writes.
        mine = turns[min(record + lane, last)]
        if found[queue.STOPS + i] > 0.0:
            stops(mine, side.turns, lane, found[queue.X_STOP + i])
        if found[queue.PLAIN + i] == 0.0:
            by_itself(plant, law, steps, parts, rule, side, first + i, lane, mine)


@compiled
def put_back(side, count):
    """Put the lanes that waited back to where they are, with what they came to."""
    at, found = side.at, side.queue
    for i in range(count):
        lane = side.lane[i]
        at[X + lane], at[V + lane] = found[queue.X + i], found[queue.V + i]
        at[D + lane] = found[queue.D + i]
        kept = side.kept[lane]
        for k in range(INTEGRALS):
            kept[k] += found[queue.SUMS + k * LANES + i]
        kept[EVENTS] += found[queue.EVENTS + i]
        kept[CLOSEST] = min(kept[CLOSEST], found[queue.TIGHT + i])
        kept[FARTHEST] = max(kept[FARTHEST], found[queue.FAR + i])


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
    x, v, d = at[queue.X + i], at[queue.V + i], int(at[queue.D + i])
    u_0, u_1 = at[queue.U + i], at[queue.U_1 + i]
    at[queue.DONE + i] += 1.0
    x_end, v_end, _, d_end, count, closest = through_events(
        plant, law, steps, parts, (), u_0, u_1, 0, x, v, d, log, 0, kept[CLOSEST]
    )
    if count < 0:
        at[queue.X + i], at[queue.V + i] = float("nan"), float("nan")
        return
    at[queue.X + i], at[queue.V + i], at[queue.D + i] = x_end, v_end, float(d_end)
    kept[CLOSEST] = closest
    kept[EVENTS] += count
    slope, start = (u_1 - u_0) / steps.dt, 0.0
    replace(rule, steps, kept, x, v, d, u_0, slope, -1.0)
    replace(rule, steps, kept, x_end, v_end, d_end, u_1, slope, 1.0)
    for k in range(count + 1):
        end = log.s[k] if k < count else steps.dt
        part = stretch(steps, u_0 + slope * start, slope, x, v, d, end - start)
        for i in range(5):
            kept[i] += part[i]
        kept[5] += end - start if d == 0 else 0.0
        if k < count:
            start, x, v, d = end, log.x_r[k], 0.0, direction(log.kind[k])
            if abs(log.kind[k]) != SLIP:
                stops(turns, side.turns, lane, x)
                kept[FARTHEST] = max(kept[FARTHEST], abs(x))


@inlined
def replace(rule, steps, kept, x, v, d, u, slope, side):
    """Take off what sums make of an end of a step; the end has side 1, the beginning -1."""
    felt = steps.c * v + (steps.w * x + d * steps.f)
    half, end = halves(rule, d, x, felt, u, v), ends(rule, d, x, felt, u, v, slope)
    for k in range(6):
        kept[k] -= half[k] + side * end[k]
