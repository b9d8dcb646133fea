"""The base on a grid: its acceleration, each wave by its sine and cosine after whole steps."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.table import ANGLES, FLOW, ROWS, WAVE
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A


@compiled
def sample_base(waves, first, dt, table, u_out):
    """Write ü of the base [m/s²] on the grid n·dt, from point `first` on."""
    fill_angles(waves, dt, table)
    values = waves.values
    last = first + len(u_out)
    for k in range(len(u_out)):
        u_out[k] = 0.0
    for i in range(waves.base):
        wave = STRIDE * i
        f, phase, A_i = values[wave + FREQUENCY], values[wave + PHASE], values[wave + A]
        start = first - first % ROWS
        while start < last:
            theta = 2.0 * math.pi * ((f * (start * dt)) % 1.0) + phase
            n, end = max(first, start), min(last, start + ROWS)
            add_angles(
                table, i, n - start, end - n, A_i * math.sin(theta), A_i * math.cos(theta),
                n - first, u_out,
            )  # fmt: skip
            start = end


@compiled
def fill_angles(waves, dt, table):
    """Write by what angle every wave of the base turns."""
    for i in range(waves.base):
        omega = waves.values[STRIDE * i + OMEGA]
        at = ROWS * (FLOW + WAVE * i + ANGLES)
        for k in range(ROWS):
            table[at + k] = math.sin(omega * (k * dt))
            table[at + ROWS + k] = math.cos(omega * (k * dt))


@compiled
def add_angles(table, i, row, rows, sine, cosine, at, u_out):
    """Add a wave itself, of which it began with these parts [m/s²]."""
    begin = row + ROWS * (FLOW + WAVE * i + ANGLES)
    if begin < 0 or at < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return
    second = begin + ROWS
    for k in range(rows):
        u_out[at + k] += sine * table[second + k] + cosine * table[begin + k]
