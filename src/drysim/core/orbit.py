"""The periodic orbit that a start leads to: a fixed point of the period map or its powers."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.leap import leap

MOST_MULTIPLE = 8
"""Longest repetition looked for, in periods of the excitation."""

CLOSED = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings."""

NOISE = 1e-10
"""A change below this that has long found no smaller one is rounding of a stiff scene."""

PATIENCE = 20
"""Periods without a new smallest change: swings of the change itself are shorter."""

NEAR = 1e-2
"""Scaled change below which Newton's method may take over."""

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
def refine(
    plant, law, waves, period, rate, x_r, v_r, d, image_x, image_v, events, peak, log, capacity
):
    """Take one Newton step towards the fixed point of the period map.

    Parameters
    ----------
    rate : float
        Turns velocities into displacements of like size [1/s].
    x_r, v_r, d
        A state near the fixed point.
    image_x, image_v, events, peak
        Where one period takes it, and what happened on the way.

    Returns
    -------
    good : bool
        Whether the neighbours behave alike and the map contracts.
    x_r, v_r : float
        The better state.
    """
    h = PROBE * peak
    one = one_period(plant, law, waves, period, x_r + h, v_r, d, log, capacity)
    a = (one[0] - image_x) / h
    c = (one[1] - image_v) / (h * rate)
    b = 0.0
    e = 0.0
    alike = one[3] == events and one[2] == d
    if d != 0:
        # Towards larger speed, so that the neighbour slides in the same direction.
        other = one_period(plant, law, waves, period, x_r, v_r + d * h * rate, d, log, capacity)
        b = (other[0] - image_x) / (d * h)
        e = (other[1] - image_v) / (d * h * rate)
        alike = alike and other[3] == events and other[2] == d
    mean = 0.5 * (a + e)
    root = mean * mean - (a * e - b * c)
    radius = abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)
    if not alike or not radius < CONTRACTS:
        return False, x_r, v_r
    gap_x = image_x - x_r
    gap_v = (image_v - v_r) / rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    x_r += ((1.0 - e) * gap_x + b * gap_v) / determinant
    v_r += rate * (c * gap_x + (1.0 - a) * gap_v) / determinant
    return d == 0 or d * v_r > 0.0, x_r, v_r


@compiled
def settle(plant, law, waves, period, x_r, v_r, d, most, past_x, past_v, log, capacity):
    """Follow a start to the periodic orbit it leads to.

    Parameters
    ----------
    plant, law, waves
    period : float
        Of the excitation [s].
    x_r, v_r, d
        State at t = 0.
    most : int
        Periods after which the scene counts as not settled.
    past_x, past_v : array, shape (MOST_MULTIPLE,)
        Scratch.
    log : Log
        Scratch.
    capacity : int
        Length of the log.

    Returns
    -------
    x_r, v_r, d
        At the beginning of the repetition.
    multiple : int
        Excitation periods in the repetition; 0 when not settled, -1 when events follow each
        other without end.
    closure : float
        Largest scaled change over the repetition [-].
    periods : int
        Periods followed.
    peak : float
        Largest |x_r| on the way [m].
    """
    rate = max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))
    highest = abs(x_r)
    events_before = -1
    change_before = math.inf
    smallest = math.inf
    smallest_at = 0
    wait = 0
    closure = math.inf
    for n in range(most):
        past_x[n % MOST_MULTIPLE] = x_r
        past_v[n % MOST_MULTIPLE] = v_r
        d_before = d
        x_before, v_before = x_r, v_r
        x_r, v_r, d, events, peak = one_period(
            plant, law, waves, period, x_r, v_r, d, log, capacity
        )
        if events < 0:
            return x_r, v_r, d, -1, closure, n + 1, highest
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
        for multiple in range(1, min(n + 1, MOST_MULTIPLE) + 1):
            i = (n + 1 - multiple) % MOST_MULTIPLE
            change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate) / scale
            closure = change if multiple == 1 else min(closure, change)
            if multiple == 1 and change < smallest:
                smallest, smallest_at = change, n
            still = change <= NOISE and change <= 10.0 * smallest and n - smallest_at > PATIENCE
            if change <= CLOSED or still:
                return x_r, v_r, d, multiple, change, n + 1, highest
        change = max(abs(x_r - x_before), abs(v_r - v_before) / rate) / scale
        wait -= 1
        slow = change < NEAR and change > 0.3 * change_before
        if wait <= 0 and slow and events == events_before and d == d_before:
            good, x_new, v_new = refine(
                plant, law, waves, period, rate, x_before, v_before, d, x_r, v_r, events, scale,
                log, capacity,
            )  # fmt: skip
            wait = 1
            if good:
                one = one_period(plant, law, waves, period, x_new, v_new, d, log, capacity)
                left = max(abs(one[0] - x_new), abs(one[1] - v_new) / rate) / scale
                good = one[3] == events and one[2] == d and left < 0.5 * change
            if good:
                x_r, v_r = x_new, v_new
                change = math.inf
            else:
                wait = 10
        change_before = change
        events_before = events
    return x_r, v_r, d, 0, closure, most, highest
