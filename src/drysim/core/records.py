"""Many records of base motion in one call: marched and measured, with nothing kept of them."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import first_mode, sign
from drysim.core.march import march_on
from drysim.core.pieces import (
    PIECE,
    acceleration_squared,
    base_squared,
    displacement_squared,
    mark,
    path_squared,
    power_given,
    speed_squared,
    way_slid,
)
from drysim.core.stretches import eventful_steps

(
    STATUS, TIME, X_BEGIN, V_BEGIN, X_END, V_END, X2, V2, X_DD2, POWER, RUB, STUCK, U_DD2, U2,
    PEAK, SUFFICES, UPCROSSINGS, ENTRIES, EVENTS, CLOSEST, HEIGHTS, FOUND,
) = range(22)  # fmt: skip
"""Columns of an answer: status; the time that a failure is told with [s]; the states at both
ends of the window; its integrals as in `Totals`; greatest |x_r| in the window and up to its end
[m]; upcrossings of zero and entries beyond the limit; events; tightest stop decision; number of
half cycles. FOUND is their number."""

MEASURED, STORM, OVERFLOW, CROWDED = range(4)
"""What became of a record; the rest: events without end, a motion beyond the numbers, and more
events in a piece than the log holds."""


@compiled
def measure_records(
    plant, law, steps, forms, waves, records, paths, begin, end, start, x_rM, piece, log,
    capacity, heights, answers,
):  # fmt: skip
    """March and measure every record.

    Parameters
    ----------
    plant, law, steps, forms
    waves : Waves
        None of them.
    records : array, shape (records, samples)
        Base acceleration [m/s²].
    paths : array, shape (records, samples) or (records, 0)
        Base displacement [m], where it is known.
    begin, end : int
        Samples at which the window begins and ends.
    start : State
    x_rM : float
        Stroke limit [m]; infinite for none.
    piece : Piece
        Scratch, as is the log, which has `capacity` places.
    heights : array, shape (records, places)
        Written: the greatest |x_r| of every half cycle in the window [m].
    answers : array, shape (records, FOUND)
        Written: the columns named above.
    """
    for r in range(len(records)):
        measure_record(
            plant, law, steps, forms, waves, records[r], paths[r], begin, end, start, x_rM,
            piece, log, capacity, heights[r], answers[r],
        )  # fmt: skip


@compiled
def measure_record(
    plant, law, steps, forms, waves, u_dd, u, begin, end, start, x_rM, piece, log, capacity,
    heights, answer,
):  # fmt: skip
    """March and measure one record; parameters as in `measure_records`."""
    for i in range(FOUND):
        answer[i] = 0.0
    answer[CLOSEST] = math.inf
    x_r, v_r = start
    d = first_mode(plant, law, x_r, v_r, u_dd[0])
    path = set_out(x_r, x_rM)
    answer[SUFFICES] = abs(x_r)
    for at in range(0, end, PIECE):
        last = min(PIECE, end - at)
        given = u_dd[at : at + last + 1]
        piece.x_r[0], piece.v_r[0], piece.d[0] = x_r, v_r, d
        n, x_r, v_r, d, count, closest = march_on(
            plant, law, steps, given, 0, last, x_r, v_r, d, piece.x_r, piece.v_r, piece.d,
            log, 0, capacity, piece.x_ahead, piece.v_ahead,
        )  # fmt: skip
        answer[CLOSEST] = min(answer[CLOSEST], closest)
        answer[TIME] = (at + n) * steps.dt
        if count < 0 or n < last or not math.isfinite(x_r + v_r):
            answer[STATUS] = STORM if count < 0 else (CROWDED if n < last else OVERFLOW)
            return
        answer[EVENTS] += count
        first = max(begin - at, 0)
        if first < last:
            if begin >= at:
                answer[X_BEGIN], answer[V_BEGIN] = piece.x_r[first], piece.v_r[first]
                path = set_out(piece.x_r[first], x_rM)
                answer[PEAK] = abs(piece.x_r[first])
            if len(u) > 0:
                beneath = u[at : at + last + 1]
                answer[U2] += path_squared(steps.dt, beneath, given, first, last, piece.part)
            add(plant, law, steps, forms, waves, given, first, last, piece, log, count, answer)
        path = follow(
            steps.dt, first, last, at + last == end, x_rM, log, count, path, heights, answer
        )
    answer[X_END], answer[V_END] = x_r, v_r
    answer[SUFFICES] = max(answer[SUFFICES], abs(x_r))
    path = visit(x_r, x_rM, path, heights, answer)
    finish(path, heights, answer)


@compiled
def add(plant, law, steps, forms, waves, u_dd, first, last, piece, log, count, answer):
    """Add the integrals over the steps of a piece from sample `first` to sample `last`."""
    mark(piece, log, count, first, last)
    x2, v2, x_dd2, power, rub, stuck = eventful_steps(
        plant, law, steps, waves, u_dd, piece, log, count, first, last
    )
    answer[X2] += x2 + max(displacement_squared(steps, forms.x2, u_dd, piece, last), 0.0)
    answer[V2] += v2 + max(speed_squared(steps, forms.v2, u_dd, piece, last), 0.0)
    whole = acceleration_squared(steps, forms.x_dd2, u_dd, piece, last)
    answer[X_DD2] += x_dd2 + max(whole, 0.0)
    answer[POWER] += power + power_given(steps, forms.power, u_dd, piece, last)
    answer[RUB] += rub + way_slid(steps, forms.rub, u_dd, piece, last)
    answer[U_DD2] += base_squared(steps.dt, u_dd, first, last, piece.part)
    whole_stuck = 0.0
    for i in range(last):
        whole_stuck += piece.stuck[i]
    answer[STUCK] += stuck + steps.dt * whole_stuck


@compiled
def set_out(x, x_rM):
    """Give a path that begins at x [m]: its side, its side beyond the limit, and height."""
    return sign(x), sign(x) if abs(x) >= x_rM else 0, abs(x)


@inlined
def visit(x, x_rM, path, heights, answer):
    """Go on to the next turn of x_r [m], or to the end of the window; gives the path."""
    side, beyond, height = path
    answer[PEAK] = max(answer[PEAK], abs(x))
    now = sign(x) if abs(x) >= x_rM else 0
    answer[ENTRIES] += 1.0 if now != 0 and now != beyond else 0.0
    if x == 0.0:
        return side, now, height
    if side * x < 0.0:
        answer[UPCROSSINGS] += 1.0 if x > 0.0 else 0.0
        finish(path, heights, answer)
        height = 0.0
    return sign(x), now, max(height, abs(x))


@inlined
def finish(path, heights, answer):
    """Write the height of a half cycle, unless nothing has moved."""
    if path[0] != 0:
        n = int(answer[HEIGHTS])
        if n < len(heights):
            heights[n] = path[2]
        answer[HEIGHTS] += 1.0


@inlined
def follow(dt, first, last, ends, x_rM, log, count, path, heights, answer):
    """Follow the turns of a piece; `ends` tells whether the window ends with it."""
    for k in range(count):
        n, s, x = log.n[k], log.s[k], log.x_r[k]
        answer[SUFFICES] = max(answer[SUFFICES], abs(x))
        if n < first or (n == first and s == 0.0):
            continue
        if not (ends and n == last - 1 and s >= dt):
            path = visit(x, x_rM, path, heights, answer)
    return path
