"""Records side by side: one lane of a vector register each, and where their numbers lie.

All of it is one array, so that the compiler sees which numbers do not overlap and works at as
many lanes at once as the processor has room for. A row holds one number of every lane. All
lanes are at the same sample: one that meets an event is led through it before they go on.
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

SEEN = STRIDE + 2
"""Samples that tell of a stride: those in it, at both ends, and the one before."""

FETCHED = 256
"""Samples that are fetched at a time: a whole number of strides."""

PLACES = (FETCHED + 2) * WIDTH
"""Of a group of lanes in what is fetched: ü at the sample before, at the first one and so on,
each of all its lanes."""

X, V, D, WAITS, AHEAD = (row * LANES for row in range(5))
"""Rows: x_r, v_r and direction; whether the lane waits; ü at the samples that a stride sees."""

SUMS = AHEAD + SEEN * LANES
KINDS = 12
"""Rows of sums over samples, and how many: see `trapezia`."""

SIZE = SUMS + KINDS * LANES
"""Numbers of all lanes together."""


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
