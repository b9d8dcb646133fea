"""The periodic orbit that a start leads to: a fixed point of the period map or its powers."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.period_map import CONTRACTS, one_period, radius, refine, slopes

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


@compiled
def marginal(plant, law, waves, period, x_r, v_r, d, log, capacity):
    """Tell whether an orbit that moves is one of a continuum: its map keeps distances."""
    image = one_period(plant, law, waves, period, x_r, v_r, d, log, capacity)
    if image[3] <= 0:
        return False
    rate = max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))
    alike, a, b, c, e = slopes(
        plant, law, waves, period, rate, x_r, v_r, d, image, log, capacity
    )
    return alike and radius(a, b, c, e) >= CONTRACTS


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
        image = one_period(plant, law, waves, period, x_r, v_r, d, log, capacity)
        x_r, v_r, d, events, peak = image
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
            image = (x_r, v_r, d, events, scale)
            good, x_new, v_new = refine(
                plant, law, waves, period, rate, x_before, v_before, d, image, log, capacity
            )
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
