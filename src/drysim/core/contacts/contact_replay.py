"""A motion over a spring contact between its steps: at any instant, and its integrals."""

from __future__ import annotations

import math

import numpy as np

from drysim.core.compiled import compiled, held, inlined
from drysim.core.contacts.contact import FREE, begin_stretch, contact_force, holds
from drysim.core.contacts.long_hold import integrate_long, settles
from drysim.core.gauss import SIX_NODES, SIX_WEIGHTS, TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.integrals import panel_length
from drysim.core.sines.slide import slide
from drysim.core.waves import STRIDE, V_START, X_START, A, base_motion, normal_force

SIX_SUFFICE = 0.125
"""Panels up to which six nodes serve: half a radian, where they err by 2e-16 of a product."""

LONG = 2.0
"""Panels from which on a hold is integrated in closed form: more than a swing of its own."""


@compiled
def resume(plant, law, waves, u_dd, dt, trail, i):
    """Set the waves for step i; gives c, w, g, r, and ü and its rate besides the waves."""
    n = trail.n[i]
    s = trail.s[i]
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    u_0 = u_dd[n] + slope * s
    c, w, f = begin_stretch(plant, law, waves, trail.d[i], trail.z[i], n * dt + s)
    return c, w, -u_0 - f, -slope, u_0, slope


@compiled
def read_contact(plant, law, waves, u_dd, dt, trail, t, x_out, v_out, z_out, F_out, d_out):
    """Write the motion at ascending times t [s].

    Parameters as in `replay.read`; `z_out` is where the contact carries no force [m], and
    `d_out` the direction of motion.
    """
    i = 0
    known = -1
    c, w, g, r = 0.0, 0.0, 0.0, 0.0
    for k in range(len(t)):
        while i + 1 < len(trail.n) and trail.n[i + 1] * dt + trail.s[i + 1] <= t[k]:
            i += 1
        if known != i:
            c, w, g, r, _, _ = resume(plant, law, waves, u_dd, dt, trail, i)
            known = i
        s = t[k] - (trail.n[i] * dt + trail.s[i])
        x, v = trail.x_r[i], trail.v_r[i]
        if s != 0.0:
            x, v, _, _ = slide(c, w, waves, x, v, g, r, s)
        load = max(normal_force(law, waves, s)[0], 0.0) if trail.d[i] != FREE else 0.0
        x_out[k] = x
        v_out[k] = v
        F_out[k] = contact_force(law, trail.d[i], x, trail.z[i], load)
        z_out[k] = x - F_out[k] / law.k_t
        d_out[k] = -1 if v < 0.0 else 1


def integrate_contact(plant, law, waves, u_dd, dt, trail, begin, end):
    """Integrate a motion over a spring contact from `begin` to `end` [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck : float
        As in `Totals`; `rub` is the work that the contact took over F_fk.
    """
    n, s = np.asarray(trail.n), np.asarray(trail.s)
    lengths = np.append(np.diff(n) * dt + np.diff(s), math.inf)
    sums = integrate_pieces(plant, law, waves, u_dd, dt, trail, held(lengths), begin, end)
    return *sums, 0.0


@compiled
def integrate_pieces(plant, law, waves, u_dd, dt, trail, lengths, begin, end):
    """Integrate pieces of some lengths [s] as far as they lie between `begin` and `end` [s].

    Returns as in `integrate_contact`, without the last.
    """
    x2, v2, x_dd2, power, rub = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(trail.n)):
        t = trail.n[i] * dt + trail.s[i]
        s = max(begin - t, 0.0)
        hi = min(end - t, lengths[i])
        if hi <= s:
            continue
        c, w, g, r, u_0, slope = resume(plant, law, waves, u_dd, dt, trail, i)
        mode, x_0, x_r, v_r = trail.d[i], trail.z[i], trail.x_r[i], trail.v_r[i]
        long = hi - s > LONG * panel_length(c, w, waves, s)
        if long and holds(mode) and u_0 == 0.0 == slope and settles(c, w, waves):
            part = integrate_hold(law, waves, c, w, g, x_r, v_r, x_0, s, hi)
        else:
            part = integrate_panels(
                plant, law, waves, c, w, g, r, u_0, slope, mode, x_r, v_r, x_0, s, hi
            )
        x2 += part[0]
        v2 += part[1]
        x_dd2 += part[2]
        power += part[3]
        rub += part[4]
    return x2, v2, x_dd2, power, rub


@compiled
def integrate_panels(plant, law, waves, c, w, g, r, u_0, slope, mode, x_r, v_r, x_0, lo, hi):
    """Integrate a piece from lo to hi [s] by panels; returns as `integrate_pieces`."""
    scene = plant, law, waves, c, w, g, r, u_0, slope, mode, x_r, v_r, x_0
    longest = panel_length(c, w, waves, lo)
    if hi - lo <= SIX_SUFFICE * longest:
        return integrate_panel(SIX_NODES, SIX_WEIGHTS, *scene, lo, hi - lo)
    x2, v2, x_dd2, power, rub = 0.0, 0.0, 0.0, 0.0, 0.0
    s = lo
    while s < hi:
        length = min(panel_length(c, w, waves, s), hi - s)
        part = integrate_panel(TWELVE_NODES, TWELVE_WEIGHTS, *scene, s, length)
        x2 += part[0]
        v2 += part[1]
        x_dd2 += part[2]
        power += part[3]
        rub += part[4]
        s = s + length if length < hi - s else hi
    return x2, v2, x_dd2, power, rub


@inlined
def integrate_panel(
    nodes, weights, plant, law, waves, c, w, g, r, u_0, slope, mode, x_r, v_r, x_0, s, length
):  # fmt: skip
    """Integrate one panel that begins at time s [s]; returns as `integrate_pieces`."""
    m, k_x, b = plant
    x2, v2, x_dd2, power, rub = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(nodes)):
        at = s + length * nodes[k]
        weight = length * weights[k]
        x, v, _, _ = slide(c, w, waves, x_r, v_r, g, r, at)
        F = contact_force(law, mode, x, x_0, normal_force(law, waves, at)[0])
        x_dd = (k_x * x + b * v + F) / m
        x2 += weight * x * x
        v2 += weight * v * v
        x_dd2 += weight * x_dd * x_dd
        power += weight * base_motion(waves, u_0, slope, at)[0] * v
        rub += weight * F * v / law.F_fk
    return x2, v2, x_dd2, power, rub


@compiled
def integrate_hold(law, waves, c, w, g, x_r, v_r, x_0, lo, hi):
    """Integrate a hold under waves alone from lo to hi [s]; returns as `integrate_pieces`."""
    middle = g / w
    lag, rate = x_r - middle, v_r
    for i in range(waves.base):
        at = STRIDE * i
        if waves.values[at + A] != 0.0:
            lag -= waves.values[at + X_START]
            rate -= waves.values[at + V_START]
    sums = integrate_long(c, w, waves, middle, lag, rate, lo, hi)
    x_lo = slide(c, w, waves, x_r, v_r, g, 0.0, lo)[0]
    x_hi = slide(c, w, waves, x_r, v_r, g, 0.0, hi)[0]
    work = law.k_t * (x_hi - x_lo) * (0.5 * (x_lo + x_hi) - x_0)
    return sums[0], sums[1], sums[2], sums[3], work / law.F_fk
