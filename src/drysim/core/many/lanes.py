"""Records side by side: one lane of a vector register each, and where their numbers lie.

All of it is one array, so that the compiler sees which numbers do not overlap and works at as
many lanes at once as the processor has room for. A row holds one number of every lane; the
rows of a tile follow each other by sample.
"""

from __future__ import annotations

from drysim.core.compiled import compiled

LANES = 128
"""Most records that are marched together: their tile stays near the processor, and a step
holds enough events among them to fill a register."""

WIDTH = 8
"""Numbers in the widest register; lanes come in such groups."""

TILE = 4
"""Steps that are taken before they are summed."""

U, X, V, D = (row * (TILE + 1) * LANES for row in range(4))
OUT = D + (TILE + 1) * LANES
PRODUCTS = OUT + TILE * LANES
"""Where rows begin: ü, x_r, v_r and direction at the samples of a tile; whether a step may hold
an event; the sums of products."""

FETCHED = 32
"""Samples that are fetched at a time: four lines of memory of every record."""

KINDS = 23
"""How many sums of products there are."""

SIZE = PRODUCTS + KINDS * LANES
"""Numbers of all lanes together."""

EVENTFUL = 2.0
"""In place of the direction of a step that holds an event and is summed by itself."""


@compiled
def fetch(base, records, first, count, n, length):
    """Fetch ü from sample n to n + length of the records, sample by sample.

    Eight records at a time, a register: `base` has a row for every sample. Lanes that are left
    over follow the last record.
    """
    last = first + count - 1
    for lane in range(0, count, WIDTH):
        r = first + lane
        a = records[r, n : n + length + 1]
        b = records[min(r + 1, last), n : n + length + 1]
        c = records[min(r + 2, last), n : n + length + 1]
        d = records[min(r + 3, last), n : n + length + 1]
        e = records[min(r + 4, last), n : n + length + 1]
        f = records[min(r + 5, last), n : n + length + 1]
        g = records[min(r + 6, last), n : n + length + 1]
        h = records[min(r + 7, last), n : n + length + 1]
        for k in range(length + 1):
            row = base[k * LANES + lane : k * LANES + lane + WIDTH]
            row[0], row[1], row[2], row[3] = a[k], b[k], c[k], d[k]
            row[4], row[5], row[6], row[7] = e[k], f[k], g[k], h[k]


@compiled
def take(at, base, lanes, n, count):
    """Take ü of a tile that begins at row n of `base`."""
    for k in range(count + 1):
        row, given = at[U + k * LANES :], base[(n + k) * LANES :]
        for lane in range(lanes):
            row[lane] = given[lane]


@compiled
def go_round(at, lanes):
    """Let the end of a tile be the beginning of the next."""
    for lane in range(lanes):
        at[X + lane] = at[X + TILE * LANES + lane]
    for lane in range(lanes):
        at[V + lane] = at[V + TILE * LANES + lane]
    for lane in range(lanes):
        at[D + lane] = at[D + TILE * LANES + lane]
