"""How far a motion that hardly changes any more still is from its periodic orbit."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.sines.period_map import (
    CONTRACTS,
    fixed_point,
    one_period,
    radius,
    rate_of,
    slopes,
)

SLOW = 1e-2
"""Decays over a repetition below which little change does not yet mean a closed orbit."""

CREEPS, FEW = 0.1, 100
"""Decays over all the periods that a motion is given, below which an overdamped mass only
creeps; and the periods that it is given then."""

AWAY = 1e-6
"""Scaled distance from an orbit at which a motion that hardly changes has not reached it."""

RESTS = 1e-9
"""Share of the largest |x_r| within which a mass that sticks in each period is as good as at
rest: it creeps to the edge of where it may stay, and any place within is like another."""

ROOM = 2
"""Places that `leap` leaves free in a log that held all events of a period."""


@compiled
def decays(plant, length):
    """Give how often what dies out slowest falls by e within a time [s]; 0 for never."""
    half = 0.5 * plant.b / plant.m
    w = plant.k_x / plant.m
    square = half * half - w
    if w == 0.0:
        return 2.0 * half * length
    return (w / (half + math.sqrt(square)) if square > 0.0 else half) * length


@compiled
def patience(plant, period, most):
    """Give after how many periods, `most` as a rule, a motion counts as not settled.

    Where all of them would take it a tenth of its way at best, Newton's method or a sum of
    changes leads it to its orbit soon, or nothing does.
    """
    half = 0.5 * plant.b / plant.m
    creeps = half * half > plant.k_x / plant.m > 0.0 and decays(plant, most * period) < CREEPS
    return min(most, FEW) if creeps else most


@compiled
def reached(plant, law, waves, length, x_r, v_r, d, log, capacity):
    """Tell whether an orbit is the only one around, and how far from it the motion still is.

    Parameters
    ----------
    length : float
        Of the repetition [s].

    Returns
    -------
    unique : bool
        Whether its map draws neighbours; false for one that keeps distances, as those of a
        continuum do. Without a spring only speeds are drawn: no place is like another then.
    left : float
        What the motion would go on changing by, summed up and over its largest |x_r| [-].
    """
    x_end, v_end, _, events, peak = one_period(
        plant, law, waves, length, x_r, v_r, d, log, capacity
    )
    if events <= 0 or events + ROOM > capacity:
        return True, 0.0
    if d == 0 and spread(log, events, x_r) <= RESTS * peak:
        return True, 0.0
    rate = rate_of(plant, length)
    a, b, c, e = slopes(plant, law, waves, length, rate, d, events, log)
    gap_x, gap_v = x_end - x_r, v_end - v_r
    if plant.k_x == 0.0:
        a, b, gap_x = 0.0, 0.0, 0.0
    if not radius(a, b, c, e) < CONTRACTS:
        return False, 0.0
    left_x, left_v = fixed_point(a, b, c, e, rate, gap_x, gap_v)
    return True, max(abs(left_x), abs(left_v) / rate) / (peak if peak > 0.0 else 1.0)


@compiled
def spread(log, events, x_r):
    """Give how far from a place the events of a repetition are [m]."""
    most = 0.0
    for i in range(events):
        most = max(most, abs(log.x_r[i] - x_r))
    return most
