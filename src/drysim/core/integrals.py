"""Exact time integrals of the motion over stretches of sliding and sticking.

Gauss-Legendre panels short enough to exhaust double precision; a panel never holds more than
a few radians of the fastest thing that is still alive.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.events import direction
from drysim.core.gauss import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.samples.longer import more_of
from drysim.core.samples.series import tail_of
from drysim.core.sines.slide import slide
from drysim.core.stretches import slid
from drysim.core.waves import OMEGA, STRIDE, anchor, base_motion, normal_force

PANEL = 4.0
"""Radians (or decays) a panel may hold: 12 nodes integrate exp(±2i·4) to 4e-17."""

FADED = 90.0
"""What decays with rate c/2 is below double precision after 90/c."""


@compiled
def own_rate(c, w, s):
    """Give the fastest rate of the oscillator that is still alive at time s of a stretch."""
    if c * s < FADED:
        return c + math.sqrt(w)
    return w / (0.5 * c + math.sqrt(0.25 * c * c - w)) if 0.25 * c * c > w else 0.0


@compiled
def panel_length(c, w, waves, s):
    """Give the length of the panel that may start at time s of a stretch [s]."""
    rate = 0.0
    for i in range(waves.size):
        rate = max(rate, waves.values[STRIDE * i + OMEGA])
    rate = max(rate, own_rate(c, w, s))
    return PANEL / rate if rate > 0.0 else math.inf


@compiled
def integrate(plant, law, waves, u_0, slope, t, x_r, v_r, d, lo, hi):
    """Integrate one stretch from lo to hi.

    Parameters
    ----------
    plant, law, waves
    u_0, slope : float
        Part of ü that is not waves: at the start of the stretch [m/s²], and its rate [m/s³].
    t : float
        Start of the stretch [s].
    x_r, v_r, d
        State at the start [m, m/s] and direction of sliding, 0 when stuck.
    lo, hi : float
        Limits, counted from the start [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub : float
        As in `Totals`.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    f = d * law.F_fk / m
    if d != 0 and lo == 0.0 and waves.size == 0 and (c + math.sqrt(w)) * hi <= FADED:
        # Without waves a panel by series takes half the time, until what decays is gone.
        tail = tail_of(c, w)
        return slid(c, w, f, tail, more_of(tail, c, w), u_0, slope, x_r, v_r, d, hi)
    anchor(waves, plant, law, t, d)
    x2, v2, x_dd2, power, rub = 0.0, 0.0, 0.0, 0.0, 0.0
    s = lo
    while s < hi:
        own = (c, w) if d != 0 else (0.0, 0.0)  # a stuck oscillator has no rate of its own
        length = min(panel_length(own[0], own[1], waves, s), hi - s)
        for i in range(len(TWELVE_NODES)):
            at = s + length * TWELVE_NODES[i]
            weight = length * TWELVE_WEIGHTS[i]
            u_dd = base_motion(waves, u_0, slope, at)[0]
            if d == 0:
                x_dd2 += weight * u_dd * u_dd
                continue
            load = normal_force(law, waves, at)[0]
            x, v, _, _ = slide(c, w, waves, x_r, v_r, -u_0 - f, -slope, at)
            x_dd = -(w * x + c * v + f * load)
            x2 += weight * x * x
            v2 += weight * v * v
            x_dd2 += weight * x_dd * x_dd
            power += weight * u_dd * v
            rub += weight * load * abs(v)
        s = s + length if length < hi - s else hi
    if d == 0:
        x2 = x_r * x_r * (hi - lo)
    return x2, v2, x_dd2, power, rub


@compiled
def integrate_leaps(plant, law, waves, t, kind, x_r, v_first, begin, end):
    """Integrate a solution under waves from `begin` to `end`.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        The events; the first is the start of the run, with velocity `v_first` [m/s].
    begin, end : float
        The window [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck : float
        As in `Totals`.
    """
    x2, v2, x_dd2, power, rub, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(t)):
        until = min(t[i + 1], end) if i + 1 < len(t) else end
        if until <= begin or until <= t[i]:
            continue
        d = direction(kind[i])
        v_r = v_first if i == 0 else 0.0
        lo = max(begin - t[i], 0.0)
        part = integrate(plant, law, waves, 0.0, 0.0, t[i], x_r[i], v_r, d, lo, until - t[i])
        x2 += part[0]
        v2 += part[1]
        x_dd2 += part[2]
        power += part[3]
        rub += part[4]
        if d == 0:
            stuck += until - t[i] - lo
    return x2, v2, x_dd2, power, rub, stuck


@compiled
def integrate_steps(plant, law, waves, u_dd, dt, first, steps, x_r, v_r, d, log, begin, end):
    """Integrate the named steps of a march; each may hold events or an end of the window.

    Parameters
    ----------
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Distance of the samples [s].
    first : int
        How many samples of the motion come before those that are given.
    steps : array of int, shape (steps,)
        Numbers of the steps, ascending; they and the log count from `first`.
    x_r, v_r, d : array, shape (samples,)
        The march.
    log : Log
        Its events, ascending.
    begin, end : float
        The window [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck : float
        As in `Totals`.
    """
    x2, v2, x_dd2, power, rub, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    event = 0
    for i in range(len(steps)):
        n = steps[i]
        while event < len(log.n) and log.n[event] < n:
            event += 1
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = (first + n) * dt
        start, x, v, mode = 0.0, x_r[n], v_r[n], d[n]
        going = True
        while going:
            going = event < len(log.n) and log.n[event] == n
            stop = log.s[event] if going else dt
            lo = max(begin - t - start, 0.0)
            hi = min(end - t, stop) - start
            if hi > lo:
                part = integrate(
                    plant, law, waves, u_dd[n] + slope * start, slope, t + start,
                    x, v, mode, lo, hi,
                )  # fmt: skip
                x2 += part[0]
                v2 += part[1]
                x_dd2 += part[2]
                power += part[3]
                rub += part[4]
                if mode == 0:
                    stuck += hi - lo
            if going:
                start, x, v, mode = stop, log.x_r[event], 0.0, direction(log.kind[event])
                event += 1
    return x2, v2, x_dd2, power, rub, stuck
