"""What the oscillator and the waves do in whole numbers of steps, column by column.

States on a grid are then sums of columns: no point waits for the one before it.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.fade import fade
from drysim.core.wave import wave
from drysim.core.waves import OMEGA, STEADY, STRIDE

ROWS = 128
"""Numbers of steps in the table: a few kilobytes for one wave, made once for a whole grid."""

FLOW = 3
"""Columns of the free motion: y, y_d and Y of `flow`."""

ANGLES = 3
"""First of the columns of a wave's angle."""

WAVE = 5
"""Columns of a wave: R, P and P_d of `wave`, or where the response to it is steady
sin(omega s)/omega, cos(omega s) and the slope of that; and sine and cosine of its angle."""


def room(size: int) -> int:
    """Give the length of the table for so many waves."""
    return ROWS * (FLOW + WAVE * size)


@compiled
def fill(plant, waves, dt, table, begin, end):
    """Write the motion from row `begin` to the one before `end`; gives the rows written.

    The waves are anchored, wherever that may be: it tells which of them have a steady response.
    """
    c, w = plant.b / plant.m, plant.k_x / plant.m
    for k in range(begin, end):
        s = k * dt
        y, y_d, Y = fade(c, w, s)
        table[k] = y
        table[ROWS + k] = y_d
        table[2 * ROWS + k] = Y
        for i in range(waves.size):
            at = ROWS * (FLOW + WAVE * i) + k
            omega = waves.values[STRIDE * i + OMEGA]
            if waves.values[STRIDE * i + STEADY] > 0.0:
                R, P = math.sin(omega * s) / omega if omega > 0.0 else s, math.cos(omega * s)
                P_d = -omega * omega * R
            else:
                R, P, P_d, _, _ = wave(c, w, omega, s, y, y_d)
            table[at] = R
            table[at + ROWS] = P
            table[at + 2 * ROWS] = P_d
    return max(begin, end)


@inlined
def write_motion(table, row, rows, x_r, v_r, push, from_sine, from_cosine, at, x_out, v_out):
    """Write the motion from a state [m, m/s] under a steady force per mass [m/s²].

    What the first wave adds is in it, by its parts as in `add_wave`: 0 where there is none.
    """
    if row < 0 or at < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return
    # Added up here, not in the loop, or neighbours would not be loaded side by side.
    second, third = row + ROWS, row + 2 * ROWS
    # Without a wave there are no columns of it: nothing times any others is nothing.
    wave = row + FLOW * ROWS if from_sine != 0.0 or from_cosine != 0.0 else row
    wave_second, wave_third = wave + ROWS, wave + 2 * ROWS
    for k in range(rows):
        y, y_d, Y = table[row + k], table[second + k], table[third + k]
        R, P, P_d = table[wave + k], table[wave_second + k], table[wave_third + k]
        x_out[at + k] = x_r + (v_r * y + push * Y) + (from_sine * R + from_cosine * P)
        v_out[at + k] = (v_r * y_d + push * y) + (from_sine * P + from_cosine * P_d)


@inlined
def add_wave(table, i, row, rows, from_sine, from_cosine, at, x_out, v_out):
    """Add what wave i has done since row 0, or its steady response, of such parts there."""
    begin = row + ROWS * (FLOW + WAVE * i)
    if begin < 0 or at < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return
    second, third = begin + ROWS, begin + 2 * ROWS
    for k in range(rows):
        R, P, P_d = table[begin + k], table[second + k], table[third + k]
        x_out[at + k] += from_sine * R + from_cosine * P
        v_out[at + k] += from_sine * P + from_cosine * P_d


@inlined
def set_mode(d, at, rows, v_out, d_out):
    """Write the direction of sliding; tells whether every velocity has it."""
    if at < 0:
        # Never so; but the compiler is told that no index counts from the end.
        return False
    for k in range(rows):
        d_out[at + k] = d
    against = 0
    for k in range(rows):
        against += v_out[at + k] * d <= 0.0
    return against == 0
