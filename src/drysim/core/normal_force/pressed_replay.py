"""A motion under a normal force that varies, between its steps: any instant, and integrals."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import limit_force
from drysim.core.gauss import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.integrals import panel_length
from drysim.core.normal_force.load import load_within, span_at
from drysim.core.normal_force.pressed import FREE, STUCK, heading
from drysim.core.sines.slide import slide
from drysim.core.waves import anchor, base_motion


@compiled
def rub_of(law, waves, span, mode, s):
    """Give the friction force of sliding relative to F_fk [-] at time s of a stretch."""
    if mode == FREE:
        return 0.0
    return heading(mode) * max(load_within(law, waves, span, s)[0], 0.0)


@compiled
def resume(plant, law, waves, u_dd, dt, trail, i):
    """Set the waves for step i; gives the span of the force, g, r, ü and its rate."""
    n = trail.n[i]
    s = trail.s[i]
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    u_0 = u_dd[n] + slope * s
    d = heading(trail.d[i])
    anchor(waves, plant, law, n * dt + s, d)
    span = span_at(law, n * dt + s)
    f = d * law.F_fk / plant.m
    return span, -u_0 - f * span.load, -slope - f * span.rate, u_0, slope


@compiled
def read_pressed(plant, law, waves, u_dd, dt, trail, t, x_out, v_out, z_out, F_out, d_out):
    """Write the motion at ascending times t [s]; parameters as in `replay.read`, z is 0."""
    c, w = plant.b / plant.m, plant.k_x / plant.m
    i = 0
    known = -1
    span, g, r, u_0, slope = span_at(law, 0.0), 0.0, 0.0, 0.0, 0.0
    for k in range(len(t)):
        while i + 1 < len(trail.n) and trail.n[i + 1] * dt + trail.s[i + 1] <= t[k]:
            i += 1
        if known != i:
            span, g, r, u_0, slope = resume(plant, law, waves, u_dd, dt, trail, i)
            known = i
        s = t[k] - (trail.n[i] * dt + trail.s[i])
        mode, x, v = trail.d[i], trail.x_r[i], trail.v_r[i]
        z_out[k] = 0.0
        if mode == STUCK:
            x_out[k], v_out[k], d_out[k] = x, 0.0, 0
            F_out[k] = -limit_force(plant, x, base_motion(waves, u_0, slope, s)[0])
            continue
        if s != 0.0:
            x, v, _, _ = slide(c, w, waves, x, v, g, r, s)
        x_out[k], v_out[k] = x, v
        F_out[k] = law.F_fk * rub_of(law, waves, span, mode, s)
        d_out[k] = heading(mode)
        if mode == FREE:
            d_out[k] = -1 if v < 0.0 else 1


@compiled
def integrate_pressed(plant, law, waves, u_dd, dt, trail, begin, end):
    """Integrate such a motion from `begin` to `end` [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck : float
        As in `Totals`.
    """
    c, w = plant.b / plant.m, plant.k_x / plant.m
    x2, v2, x_dd2, power, rub, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(trail.n)):
        t = trail.n[i] * dt + trail.s[i]
        s = max(begin - t, 0.0)
        hi = end - t
        if i + 1 < len(trail.n):
            between = trail.s[i + 1] - trail.s[i] + (trail.n[i + 1] - trail.n[i]) * dt
            hi = min(hi, between)
        if hi <= s:
            continue
        span, g, r, u_0, slope = resume(plant, law, waves, u_dd, dt, trail, i)
        mode, x_r, v_r = trail.d[i], trail.x_r[i], trail.v_r[i]
        if mode == STUCK:
            stuck += hi - s
            x2 += x_r * x_r * (hi - s)
        while s < hi:
            # A stuck oscillator has no rate of its own.
            own = (0.0, 0.0) if mode == STUCK else (c, w)
            length = min(panel_length(own[0], own[1], waves, s), hi - s)
            for k in range(len(TWELVE_NODES)):
                at = s + length * TWELVE_NODES[k]
                weight = length * TWELVE_WEIGHTS[k]
                u_now = base_motion(waves, u_0, slope, at)[0]
                if mode == STUCK:
                    x_dd2 += weight * u_now * u_now
                    continue
                x, v, _, _ = slide(c, w, waves, x_r, v_r, g, r, at)
                share = rub_of(law, waves, span, mode, at)
                x_dd = -(w * x + c * v + law.F_fk / plant.m * share)
                x2 += weight * x * x
                v2 += weight * v * v
                x_dd2 += weight * x_dd * x_dd
                power += weight * u_now * v
                rub += weight * share * v
            s = s + length if length < hi - s else hi
    return x2, v2, x_dd2, power, rub, stuck
