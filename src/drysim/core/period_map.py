"""The period map: what one period of the excitation makes of a state, and of its neighbours."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.leap import leap

PROBE = 1e-6
"""Scaled distance of the neighbours that give the slope of the period map."""

CONTRACTS = 1.0 - 1e-7
"""A map that shrinks distances less than this is marginal; Newton would pick any orbit."""


@compiled
def one_period(plant, law, waves, period, x_r, v_r, d, log, capacity):
    """Carry a state through one period.

    Returns
    -------
    x_r, v_r, d
        At the end of the period.
    events : int
        Number of events, negative when they follow each other without end.
    peak : float
        Largest |x_r| at an event or an end [m].
    """
    begin = 0.0
    events = 0
    peak = abs(x_r)
    while begin < period:
        begin, x_r, v_r, d, count, _ = leap(
            plant, law, waves, 0.0, 0.0, 0, 0.0, period, begin, x_r, v_r, d, log, 0, capacity
        )
        if count < 0:
            return x_r, v_r, d, -1, peak
        for i in range(count):
            peak = max(peak, abs(log.x_r[i]))
        events += count
    return x_r, v_r, d, events, max(peak, abs(x_r))


@compiled
def slopes(plant, law, waves, period, rate, x_r, v_r, d, image, log, capacity):
    """Give the slopes of the period map at a state, from its neighbours.

    Parameters
    ----------
    rate : float
        Turns velocities into displacements of like size [1/s].
    x_r, v_r, d
        The state.
    image : tuple
        What `one_period` makes of it.

    Returns
    -------
    alike : bool
        Whether the neighbours do what the state does, so that the slopes are the map's.
    a, b, c, e : float
        Change of x_r and v_r/rate at the end for one of x_r (a, c) and of v_r/rate (b, e).
    """
    h = PROBE * image[4]
    one = one_period(plant, law, waves, period, x_r + h, v_r, d, log, capacity)
    a = (one[0] - image[0]) / h
    c = (one[1] - image[1]) / (h * rate)
    alike = one[3] == image[3] and one[2] == image[2]
    if d == 0:
        return alike, a, 0.0, c, 0.0
    # Towards larger speed, so that the neighbour slides in the same direction.
    other = one_period(plant, law, waves, period, x_r, v_r + d * h * rate, d, log, capacity)
    b = (other[0] - image[0]) / (d * h)
    e = (other[1] - image[1]) / (d * h * rate)
    return alike and other[3] == image[3] and other[2] == image[2], a, b, c, e


@compiled
def radius(a, b, c, e):
    """Give the factor by which a map with these slopes stretches in the long run."""
    mean = 0.5 * (a + e)
    root = mean * mean - (a * e - b * c)
    return abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)


@compiled
def refine(plant, law, waves, period, rate, x_r, v_r, d, image, log, capacity):
    """Take one Newton step towards the fixed point of the period map.

    Parameters
    ----------
    As in `slopes`.

    Returns
    -------
    good : bool
        Whether the neighbours behave alike and the map contracts.
    x_r, v_r : float
        The better state.
    """
    alike, a, b, c, e = slopes(
        plant, law, waves, period, rate, x_r, v_r, d, image, log, capacity
    )
    if not alike or not radius(a, b, c, e) < CONTRACTS:
        return False, x_r, v_r
    gap_x = image[0] - x_r
    gap_v = (image[1] - v_r) / rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    x_r += ((1.0 - e) * gap_x + b * gap_v) / determinant
    v_r += rate * (c * gap_x + (1.0 - a) * gap_v) / determinant
    return d == 0 or d * v_r > 0.0, x_r, v_r
