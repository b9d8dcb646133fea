"""The exact march of many records in lockstep: no step waits for another record's events."""

from __future__ import annotations

from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.events import ROUNDING, SLIP, Log, direction
from drysim.core.many import abreast
from drysim.core.many.lanes import EVENTFUL, LANES, OUT, WIDTH, D, U, V, X
from drysim.core.samples.eventful import through_events
from drysim.core.samples.glide import ONE_OF_FOUR
from drysim.core.stretches import stretch

EVENTS, CLOSEST, E_X2, E_V2, E_X_DD2, E_POWER, E_RUB, E_STUCK, KEPT = range(9)
"""What is kept of every lane: its events and tightest decision, and the integrals over the
steps that hold events."""


class Side(NamedTuple):
    """What the lanes of a march share as scratch, and what is kept of each; arrays.

    Attributes
    ----------
    at : array, shape (SIZE,)
        The tile, see `lanes`.
    base : array, shape ((FETCHED + 1) * LANES,)
        ü as it is fetched.
    events : array, shape (abreast.ROWS * LANES,)
        The steps that hold events, see `abreast`.
    some : array, shape (LANES,)
        Whether any of some lanes has one.
    lane : array of int, shape (LANES,)
        Whose they are.
    kept : array, shape (LANES, KEPT)
        What is kept of every lane.
    turns : array of int, shape (LANES,)
        How many stops were written of every lane.
    log : Log
        Of a step that is solved by itself.
    capacity : int
        Its length.
    """

    at: Any
    base: Any
    events: Any
    some: Any
    lane: Any
    kept: Any
    turns: Any
    log: Log
    capacity: int


@compiled
def step_all(plant, law, steps, at, lanes):
    """Carry all lanes through a step as if nothing happened, and mark those where it may.

    `at` begins at the step within the tile; it is told by ü there, see `lanes`.
    """
    m, k_x, F_fs = plant.m, plant.k_x, law.F_fs
    c, w, f = steps.c, steps.w, steps.f
    x_x, x_v, x_f, v_x, v_v, v_f = steps.one
    x_0, x_1, v_0, v_1 = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    steep, fast = ONE_OF_FOUR * steps.steep, ONE_OF_FOUR * steps.fast
    for lane in range(lanes):
        x, v, d = at[X + lane], at[V + lane], at[D + lane]
        u, u_1 = at[U + lane], at[U + LANES + lane]
        a = u + (c * v + (w * x + f * d))
        x_end = x_x * x + x_v * v - (x_0 * u + x_1 * u_1 + x_f * d)
        v_end = v_x * x + v_v * v - (v_0 * u + v_1 * u_1 + v_f * d)
        a_end = u_1 + (c * v_end + (w * x_end + f * d))
        F_k = k_x * x
        hold = F_fs + ROUNDING * (F_fs + abs(F_k))
        stops = 1.0 if d * v_end <= 0.0 else 0.0
        doubt = steep * abs(u_1 - u) + fast * max(abs(v), abs(v_end))
        dips = (1.0 if d * a > 0.0 else 0.0) * (1.0 if d * a_end < 0.0 else 0.0)
        dips = 0.0 if min(d * v, d * v_end) > doubt else dips
        breaks = 1.0 if abs(m * u_1 + F_k) > hold else 0.0
        at[X + LANES + lane] = x if d == 0.0 else x_end
        at[V + LANES + lane] = 0.0 if d == 0.0 else v_end
        at[D + LANES + lane] = d
        at[OUT + lane] = breaks if d == 0.0 else stops + dips


@compiled
def gather(at, lanes, some, events, whose):
    """Gather the steps that may hold events; gives how many.

    Lanes that are an eighth of all apart are looked at together.
    """
    groups = lanes // WIDTH
    for i in range(groups):
        some[i] = at[OUT + i]
    for k in range(1, WIDTH):
        marks = at[OUT + k * groups :]
        for i in range(groups):
            some[i] += marks[i]
    count = 0
    for i in range(groups):
        if some[i] > 0.0:
            for lane in range(i, lanes, groups):
                whose[count] = lane
                count += 1 if at[OUT + lane] > 0.0 else 0
    for k in range(count):
        lane = whose[k]
        events[abreast.X * LANES + k] = at[X + lane]
        events[abreast.V * LANES + k] = at[V + lane]
        events[abreast.D * LANES + k] = at[D + lane]
        events[abreast.U_0 * LANES + k] = at[U + lane]
        events[abreast.U_1 * LANES + k] = at[U + LANES + lane]
    return count


@inlined
def settle(plant, law, steps, inner, parts, waves, side, at, count, turns, first):
    """Write what became of steps that may hold events back to their lanes."""
    events, last = side.events, len(turns) - 1
    for k in range(count):
        lane = side.lane[k]
        # Lanes that are left over follow the last record, so they write what it writes.
        kept, mine = side.kept[lane], turns[min(first + lane, last)]
        if parts == 1 and events[abreast.PLAIN * LANES + k] > 0.0:
            n = side.turns[lane]
            kept[EVENTS] += events[abreast.EVENTS * LANES + k]
            kept[CLOSEST] = min(kept[CLOSEST], events[abreast.TIGHT * LANES + k])
            if events[abreast.STOPS * LANES + k] > 0.0 and n < len(mine):
                mine[n] = events[abreast.X_STOP * LANES + k]
            side.turns[lane] = n + int(events[abreast.STOPS * LANES + k])
            for i in range(6):
                kept[E_X2 + i] += events[(abreast.X2 + i) * LANES + k]
            x, v = events[abreast.X_END * LANES + k], events[abreast.V_END * LANES + k]
            d = events[abreast.D_END * LANES + k]
        else:
            x, v, d = by_itself(plant, law, steps, inner, parts, waves, side, at, lane, mine)
        at[X + lane], at[V + lane], at[D + lane] = 0.0, 0.0, EVENTFUL
        at[X + LANES + lane], at[V + LANES + lane], at[D + LANES + lane] = x, v, d


@compiled
def by_itself(plant, law, steps, inner, parts, waves, side, at, lane, turns):
    """Carry one lane through a step that holds any number of events; gives the state."""
    log, kept = side.log, side.kept[lane]
    x, v, d = at[X + lane], at[V + lane], int(at[D + lane])
    u_0, u_1 = at[U + lane], at[U + LANES + lane]
    x_end, v_end, d_end, count, closest = through_events(
        plant, law, steps, inner, parts, u_0, u_1, 0, x, v, d, log, 0, kept[CLOSEST]
    )
    if count < 0:
        return float("nan"), float("nan"), EVENTFUL
    kept[CLOSEST] = closest
    kept[EVENTS] += count
    slope, start = (u_1 - u_0) / steps.dt, 0.0
    for k in range(count + 1):
        end = log.s[k] if k < count else steps.dt
        part = stretch(
            plant, law, steps, waves, u_0 + slope * start, slope, x, v, d, end - start
        )
        for i in range(5):
            kept[E_X2 + i] += part[i]
        kept[E_STUCK] += end - start if d == 0 else 0.0
        if k < count:
            start, x, v, d = end, log.x_r[k], 0.0, direction(log.kind[k])
            if abs(log.kind[k]) != SLIP:
                n = side.turns[lane]
                if n < len(turns):
                    turns[n] = x
                side.turns[lane] = n + 1
    return x_end, v_end, float(d_end)
