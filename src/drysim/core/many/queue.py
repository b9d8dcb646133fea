"""The lanes that wait, side by side: where their numbers lie, and how they get there."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.many import lanes
from drysim.core.many.lanes import LANES, SEEN, STRIDE, WIDTH
from drysim.core.many.trapezia import INTEGRALS

X, V, D, DONE, HERE, U, U_1, X_STOP, STOPS, PLAIN, TIGHT, EVENTS, FAR = (
    row * LANES for row in range(13)
)
"""Rows: x_r, v_r and direction; how many steps of the stride are done. What is found: whether a
lane stands before an event, and ü at both ends of that step; x_r where it stops, whether it
does, and whether all that holds; the tightest decision, how many events there are, and the
greatest |x_r| at a stop."""

SUMS = FAR + LANES
AHEAD = SUMS + INTEGRALS * LANES
"""Rows of the integrals, and of ü at the samples that a stride sees."""

SIZE = AHEAD + SEEN * LANES

NO_DECISION = math.inf
"""Tightness of what was no stop."""


@compiled
def gather(at, count, queue, whose):
    """Gather the lanes that wait among so many; gives how many there are.

    Parameters
    ----------
    at : array, shape (lanes.SIZE,)
    count : int
    queue : array, shape (SIZE,)
        Written: what is found is nothing yet; a group is filled up with lanes that are done.
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
        queue[D + i] = at[lanes.D + lane]
        for k in range(SEEN):
            queue[AHEAD + k * LANES + i] = at[lanes.AHEAD + k * LANES + lane]
    filled = (some + WIDTH - 1) // WIDTH * WIDTH
    for i in range(filled):
        queue[DONE + i] = 0.0 if i < some else STRIDE
        queue[TIGHT + i] = NO_DECISION
    for row in range(EVENTS, AHEAD, LANES):
        for i in range(filled):
            queue[row + i] = 0.0
    return some
