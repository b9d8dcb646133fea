"""A motion between end stops between its steps: at any instant, its integrals, its hits."""

from __future__ import annotations

from drysim.core.bracket import BISECTIONS
from drysim.core.compiled import compiled
from drysim.core.gauss import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.integrals import panel_length
from drysim.core.samples.stop import RESOLUTION
from drysim.core.sines.slide import slide
from drysim.core.stops.bounded import begin_stretch
from drysim.core.stops.bumper import (
    CHATTERS,
    MEET,
    bumper_force,
    fresh_of,
    pushes,
    steady_pull,
    touch_of,
    wall_of,
    way_of,
)
from drysim.core.stops.impact import chatter_acceleration, pressures
from drysim.core.waves import base_motion, normal_force

FINELY = 40.0
"""Parts of a panel that a force has one extremum in at most: a tenth of a radian each."""


@compiled
def resume(plant, law, waves, u_dd, dt, trail, i):
    """Set the waves for step i; gives c, w, g, r, and ü and its rate besides the waves."""
    n = trail.n[i]
    s = trail.s[i]
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    u_0 = u_dd[n] + slope * s
    c, w, g = begin_stretch(plant, law, waves, trail.d[i], trail.z[i], u_0, n * dt + s)
    return c, w, g, -slope, u_0, slope


@compiled
def forces(plant, law, mode, z, xi, v_r, u_dd, load):
    """Give friction force and force of a stop [N]; what neither shows is decided so.

    At rest against a rigid stop friction bears what it can and the stop the rest.
    """
    touch, d = touch_of(mode), way_of(mode)
    if d != 0:
        return d * law.F_fk * load, bumper_force(law, touch, xi, v_r)
    F_L = plant.m * u_dd + steady_pull(plant, law, touch, z, xi)
    if wall_of(law, z, xi) != 0:
        hold = law.F_fs * load
        F_f = min(max(-F_L, -hold), hold)
        return F_f, -F_L - F_f
    return -F_L, bumper_force(law, touch, xi, 0.0)


@compiled
def read_bounded(plant, law, waves, u_dd, dt, trail, t, x_out, v_out, stop_out, F_out, d_out):
    """Write the motion at ascending times t [s].

    Parameters as in `replay.read`; `stop_out` is the force of a stop [N], and `d_out` the
    direction of sliding, 0 where stuck.
    """
    i = 0
    known = -1
    c, w, g, r, u_0, slope = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(t)):
        while i + 1 < len(trail.n) and trail.n[i + 1] * dt + trail.s[i + 1] <= t[k]:
            i += 1
        if known != i:
            c, w, g, r, u_0, slope = resume(plant, law, waves, u_dd, dt, trail, i)
            known = i
        s = t[k] - (trail.n[i] * dt + trail.s[i])
        z, xi, v, mode = trail.z[i], trail.x_r[i], trail.v_r[i], trail.d[i]
        if way_of(mode) == 0:
            v = 0.0
        elif s != 0.0:
            xi, v, _, _ = slide(c, w, waves, xi, v, g, r, s)
        u = base_motion(waves, u_0, slope, s)[0]
        load = normal_force(law, waves, s)[0]
        x_out[k] = z + xi
        v_out[k] = v
        F_out[k], stop_out[k] = forces(plant, law, mode, z, xi, v, u, load)
        d_out[k] = way_of(mode)


@compiled
def integrate_bounded(plant, law, waves, u_dd, dt, trail, begin, end):
    """Integrate a motion between end stops from `begin` to `end` [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck, hits : float
        As in `Totals`; `hits` without what rigid stops take, which is at instants.
    """
    m, k_x, b = plant
    x2, v2, x_dd2, power, rub, stuck, hits = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(trail.n)):
        t = trail.n[i] * dt + trail.s[i]
        s = max(begin - t, 0.0)
        hi = end - t
        if i + 1 < len(trail.n):
            hi = min(hi, trail.n[i + 1] * dt + trail.s[i + 1] - t)
        if hi <= s or trail.d[i] == MEET:
            continue
        c, w, g, r, u_0, slope = resume(plant, law, waves, u_dd, dt, trail, i)
        z, xi, v, mode = trail.z[i], trail.x_r[i], trail.v_r[i], trail.d[i]
        d = way_of(mode)
        if fresh_of(mode) == CHATTERS:
            load = normal_force(law, waves, 0.0)[0]
            F_L = m * base_motion(waves, u_0, slope, 0.0)[0] + k_x * z
            p, q = pressures(plant, law, 1 if z > 0.0 else -1, F_L, load)
            x2 += z * z * (hi - s)
            x_dd2 += chatter_acceleration(plant, law, p, q, z, load) * (hi - s)
            continue
        if d == 0:
            stuck += hi - s
            x2 += (z + xi) ** 2 * (hi - s)
            c, w = 0.0, 0.0
        while s < hi:
            length = min(panel_length(c, w, waves, s), hi - s)
            for k in range(len(TWELVE_NODES)):
                at = s + length * TWELVE_NODES[k]
                weight = length * TWELVE_WEIGHTS[k]
                u = base_motion(waves, u_0, slope, at)[0]
                if d == 0:
                    x_dd2 += weight * u * u
                    continue
                xi, v, _, _ = slide(c, w, waves, trail.x_r[i], trail.v_r[i], g, r, at)
                load = normal_force(law, waves, at)[0]
                F_f, F = forces(plant, law, mode, z, xi, v, u, load)
                x = z + xi
                x_dd = (k_x * x + b * v + F_f + F) / m
                x2 += weight * x * x
                v2 += weight * v * v
                x_dd2 += weight * x_dd * x_dd
                power += weight * u * v
                rub += weight * load * abs(v)
                hits += weight * F * v
            s = s + length if length < hi - s else hi
    return x2, v2, x_dd2, power, rub, stuck, hits


@compiled
def hardest_push(plant, law, waves, u_dd, dt, trail, begin, end):
    """Give the greatest force of a bumper between `begin` and `end` [N]."""
    greatest = 0.0
    for i in range(len(trail.n)):
        t = trail.n[i] * dt + trail.s[i]
        s = max(begin - t, 0.0)
        hi = end - t
        if i + 1 < len(trail.n):
            hi = min(hi, trail.n[i + 1] * dt + trail.s[i + 1] - t)
        mode = trail.d[i]
        if hi < s or mode == MEET or not pushes(law, touch_of(mode)):
            continue
        xi, v = trail.x_r[i], trail.v_r[i]
        if way_of(mode) == 0:
            greatest = max(greatest, abs(law.k_s * xi))
            continue
        c, w, g, r, _, _ = resume(plant, law, waves, u_dd, dt, trail, i)
        side = 1.0 if touch_of(mode) > 0 else -1.0
        push, rate = push_at(c, w, waves, law, xi, v, g, r, side, s)
        greatest = max(greatest, push)
        while s < hi:
            length = min(panel_length(c, w, waves, s) / FINELY, hi - s)
            until = s + length if length < hi - s else hi
            push, after = push_at(c, w, waves, law, xi, v, g, r, side, until)
            greatest = max(greatest, push)
            if rate > 0.0 and after < 0.0:
                push = summit(c, w, waves, law, xi, v, g, r, side, s, until)
                greatest = max(greatest, push)
            s, rate = until, after
    return greatest


@compiled
def push_at(c, w, waves, law, xi, v_r, g, r, side, s):
    """Give the force of a bumper [N] and its rate [N/s] at time s of a stretch."""
    x, v, a, _ = slide(c, w, waves, xi, v_r, g, r, s)
    return side * (law.k_s * x + law.b_s * v), side * (law.k_s * v + law.b_s * a)


@compiled
def summit(c, w, waves, law, xi, v_r, g, r, side, low, high):
    """Give the greatest force of a bumper between two times at which it rises and falls [N]."""
    s = 0.5 * (low + high)
    for _ in range(BISECTIONS):
        rate = push_at(c, w, waves, law, xi, v_r, g, r, side, s)[1]
        low, high = (s, high) if rate > 0.0 else (low, s)
        if high - low <= RESOLUTION * high:
            break
        s = 0.5 * (low + high)
    return push_at(c, w, waves, law, xi, v_r, g, r, side, s)[0]
