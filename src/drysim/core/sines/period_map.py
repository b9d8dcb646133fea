"""The period map: what one period of the excitation makes of a state, and of its neighbours."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.events import direction
from drysim.core.flow import flow
from drysim.core.sines.leap import leap
from drysim.core.waves import anchor, base_motion, normal_force

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
def rate_of(plant, period):
    """Give what turns velocities into displacements of like size [1/s]."""
    return max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))


@compiled
def slopes(plant, law, waves, period, rate, d, events, log):
    """Give the slopes of the period map at a state, from the events on its way.

    Parameters
    ----------
    rate : float
        Turns velocities into displacements of like size [1/s].
    d : int
        Direction of sliding at the start, 0 when stuck.
    events : int
        What `one_period` has written to the log.
    log : Log

    Returns
    -------
    a, b, c, e : float
        Change of x_r and v_r/rate at the end for one of x_r (a, c) and of v_r/rate (b, e);
        infinite where a neighbour, however near, does something else.

    Notes
    -----
    An event that comes later by tau leaves a neighbour that, seen at one instant, lags by the
    acceleration times tau: what dynamics with jumps calls a saltation matrix.
    """
    damping = plant.b / plant.m
    w = plant.k_x / plant.m
    a, c, b, e = 1.0, 0.0, 0.0, 1.0 if d != 0 else 0.0
    begin = 0.0
    for i in range(events + 1):
        until = log.s[i] if i < events else period
        if d != 0:
            y, y_d, _, _ = flow(damping, w, until - begin)
            keep = y_d + damping * y
            a, c = keep * a + y * rate * c, y_d * c - w * y / rate * a
            b, e = keep * b + y * rate * e, y_d * e - w * y / rate * b
        if i == events:
            return a, b, c, e
        begin, after = until, direction(log.kind[i])
        anchor(waves, plant, law, begin, d)
        lag = saltation(plant, law, waves, d, after, log.x_r[i])
        # Stops are felt by the velocity before them, break-aways by the place of the mass.
        c, e = (lag * c, lag * e) if d != 0 else (lag * a / rate, lag * b / rate)
        d = after
    return a, b, c, e


@compiled
def saltation(plant, law, waves, d, after, x_r):
    """Give what an event makes of a neighbour's distance: the factor on its velocity.

    At a break-away it is the velocity for a distance in x_r [1/s]; waves are anchored at the
    event.
    """
    u_dd, u_ddd, _ = base_motion(waves, 0.0, 0.0, 0.0)
    load, load_d, _ = normal_force(law, waves, 0.0)
    free = -(u_dd + plant.k_x / plant.m * x_r)
    slip = law.F_fk * load / plant.m
    if d == 0:
        away = after * (law.F_fs - law.F_fk) * load / plant.m
        approach = law.F_fs * load_d + after * plant.m * u_ddd
        if away == 0.0:
            return 0.0
        return away * after * plant.k_x / approach if approach != 0.0 else math.inf
    stop = free - d * slip
    if after == 0:
        return 0.0
    return (free - after * slip) / stop if stop != 0.0 else math.inf


@compiled
def radius(a, b, c, e):
    """Give the factor by which a map with these slopes stretches in the long run."""
    mean = 0.5 * (a + e)
    root = mean * mean - (a * e - b * c)
    return abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)


@compiled
def fixed_point(a, b, c, e, rate, gap_x, gap_v):
    """Give how far [m, m/s] the fixed point of a map with these slopes is from a state.

    The gaps are what the map changes of that state.
    """
    gap_v /= rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    return (
        ((1.0 - e) * gap_x + b * gap_v) / determinant,
        rate * (c * gap_x + (1.0 - a) * gap_v) / determinant,
    )


@compiled
def refine(plant, law, waves, period, rate, x_r, v_r, d, image, log):
    """Take one Newton step towards the fixed point of the period map.

    Parameters
    ----------
    x_r, v_r, d
        The state.
    image : tuple
        What `one_period` has made of it.

    Returns
    -------
    good : bool
        Whether the map contracts there, so that the better state may be trusted.
    x_r, v_r : float
        The better state; the image where there is none.
    """
    a, b, c, e = slopes(plant, law, waves, period, rate, d, image[3], log)
    if not radius(a, b, c, e) < CONTRACTS:
        return False, image[0], image[1]
    step_x, step_v = fixed_point(a, b, c, e, rate, image[0] - x_r, image[1] - v_r)
    x_r += step_x
    v_r += step_v
    if d != 0 and d * v_r <= 0.0:
        return False, image[0], image[1]
    return True, x_r, v_r
