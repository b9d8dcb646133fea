"""The lanes that wait, side by side: where their numbers lie, and how they get there."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.many import lanes
from drysim.core.many.lanes import LANES, STRIDE
from drysim.core.many.trapezia import INTEGRALS

X, V, D, U, RISE, LEFT, AHEAD = (row * LANES for row in range(7))
HERE, U_1, X_STOP, TIGHT, STOPS, EVENTS, WENT, PLAIN, SUMS = (
    row * LANES for row in range(6 + STRIDE, 15 + STRIDE)
)
"""Rows: x_r, v_r, direction, ü and its change in the step before; how many samples are left;
ü at the next. What is found: whether a lane stands before an event, and ü at the end of that
step; x_r where it stops, how tight that decision is, whether it stops and how many events there
are; how many samples it went on, and whether all that holds; the integrals."""

SIZE = SUMS + INTEGRALS * LANES


@compiled
def gather(at, count, until, queue, whose):
    """Gather the lanes that wait among so many; gives how many there are.

    Parameters
    ----------
    at : array, shape (lanes.SIZE,)
    count : int
    until : float
        Place of the last sample that was fetched.
    queue : array, shape (SIZE,)
        Written: the rows up to `AHEAD`.
    whose : array of int, shape (LANES,)
        Written: which lanes they are.
    """
    some = 0
    for lane in range(count):
        whose[some] = lane
        some += 1 if at[lanes.WAITS + lane] > 0.0 else 0
    for i in range(some):
        lane = whose[i]
        queue[X + i], queue[V + i] = at[lanes.X + lane], at[lanes.V + lane]
        queue[D + i], queue[U + i] = at[lanes.D + lane], at[lanes.U + lane]
        queue[RISE + i] = at[lanes.RISE + lane]
        queue[LEFT + i] = until - at[lanes.PLACE + lane]
        for k in range(STRIDE):
            queue[AHEAD + k * LANES + i] = at[lanes.AHEAD + k * LANES + lane]
    return some
