"""Records side by side: one lane of a vector register each, and where their numbers lie.

All of it is one array, so that the compiler sees which numbers do not overlap and works at as
many lanes at once as the processor has room for. A row holds one number of every lane. Lanes
need not be at the same sample: one that waits for an event falls behind.
"""

from __future__ import annotations

from drysim.core.compiled import compiled

LANES = 128
"""Most records that are marched together: so few that they stay near the processor, so many
that those which wait for an event fill whole registers."""

WIDTH = 8
"""Numbers in the widest register; lanes come in such groups."""

STRIDE = 4
"""Steps that are taken at once."""

FETCHED = 256
"""Samples that are fetched at a time; at their end lanes wait for each other."""

PLACES = FETCHED + 2 * STRIDE
"""Of a lane in what is fetched, more than samples: a stride looks beyond them, and the rows
shall not all fall on the same lines of the cache."""

X, V, D, U, RISE, PLACE, WAITS, AHEAD = (row * LANES for row in range(8))
"""Rows: x_r, v_r and direction; ü, and its change in the step before; the sample, counted from
the first one fetched; whether the lane waits; ü at the samples of the next stride."""

SUMS = AHEAD + STRIDE * LANES
KINDS = 12
"""Rows of sums over samples, and how many: see `trapezia`."""

SIZE = SUMS + KINDS * LANES
"""Numbers of all lanes together."""

FORWARD = (1 << 40) - 1
"""More samples than there are: tells the compiler that no index counts from the end."""


@compiled
def fetch(base, records, first, count, lanes, n, length):
    """Fetch ü from sample n to n + length; lanes that are left over follow the last record."""
    for lane in range(lanes):
        record = records[first + min(lane, count - 1), n : n + length + 1]
        places = base[lane * PLACES : lane * PLACES + length + 1]
        for k in range(length + 1):
            places[k] = record[k]


@compiled
def look_ahead(at, base, lanes):
    """Put ü at the samples of the next stride of every lane side by side."""
    for lane in range(lanes):
        begin = lane * PLACES + (int(at[PLACE + lane]) & FORWARD)
        for k in range(STRIDE):
            at[AHEAD + k * LANES + lane] = base[begin + 1 + k]
