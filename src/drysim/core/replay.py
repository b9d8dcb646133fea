"""A traced motion between its steps: states at any instant, and integrals over a window."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.dynamic_laws.dynamic import dynamic_force, fractional
from drysim.core.dynamic_laws.jet import ORDER, drive, grow, state_at, value
from drysim.core.dynamic_laws.settled import SETTLED, settle_again
from drysim.core.events import limit_force
from drysim.core.gauss import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.plant import LEUVEN, STRIBECK

TINY = 1e-300
"""Nothing that a series has may be neglected where it is read."""


@compiled
def revive(plant, law, waves, u_dd, dt, jet, trail, i):
    """Make the series of step i anew; gives the last term that counts, 0 where nothing moves.

    What comes behind it is not the motion: the rise of the Stribeck curve, a step away.
    """
    n = trail.n[i]
    s = trail.s[i]
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    d = trail.d[i]
    drive(jet, waves, u_dd[n] + slope * s, slope, n * dt + s)
    if d == 0:
        return 0
    way = 1 if d > 0 else -1
    if law.kind == LEUVEN:
        jet.slope[0], jet.slope[1] = trail.rise[i], trail.bend[i]
    if law.kind != STRIBECK and abs(d) > SETTLED:
        settle_again(plant, law, jet, way, trail.x_r[i], trail.v_r[i], abs(d) - SETTLED)
        return trail.terms[i]
    slow = fractional(law) and abs(d) > 1
    state = trail.x_r[i], trail.v_r[i], trail.z[i]
    grow(plant, law, jet, way, *state, abs(d) == 2, slow, 1.0, TINY, TINY)
    return trail.terms[i]


@compiled
def read(plant, law, waves, u_dd, dt, jet, trail, t, x_out, v_out, z_out, F_out, d_out):
    """Write the motion at ascending times t [s].

    Parameters
    ----------
    plant, law, waves, u_dd, dt, jet, trail
        As in `trace`; `trail` ends with its last step.
    t : array, shape (n,)
        Ascending, not before the first step [s].
    x_out, v_out, z_out, F_out : array, shape (n,)
        Written: state [m, m/s, m] and friction force [N].
    d_out : array of int, shape (n,)
        Written: direction of motion, 0 where stuck; bristles never stick.
    """
    i = 0
    known = -1
    last = 0
    for k in range(len(t)):
        while i + 1 < len(trail.n) and trail.n[i + 1] * dt + trail.s[i + 1] <= t[k]:
            i += 1
        if known != i:
            last = revive(plant, law, waves, u_dd, dt, jet, trail, i)
            known = i
        s = t[k] - (trail.n[i] * dt + trail.s[i])
        d = (trail.d[i] > 0) - (trail.d[i] < 0)
        x_out[k] = trail.x_r[i]
        v_out[k] = 0.0
        z_out[k] = trail.z[i]
        d_out[k] = d if d != 0 or law.kind == STRIBECK else 1
        if d == 0:
            F_out[k] = -limit_force(plant, x_out[k], value(jet.u, ORDER, s))
            continue
        if s == 0.0:
            v_out[k] = trail.v_r[i]
        else:
            x_out[k], v_out[k], z_out[k] = state_at(jet, last, s)
        F_out[k] = dynamic_force(law, d, v_out[k], z_out[k])


@compiled
def integrate_series(plant, law, waves, u_dd, dt, jet, trail, begin, end):
    """Integrate a traced motion from `begin` to `end` [s].

    Returns
    -------
    x2, v2, x_dd2, power, rub, stuck : float
        As in `Totals`; `rub` is the loss in the contact over F_fk.
    """
    m, k_x, b = plant
    x2, v2, x_dd2, power, rub, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(trail.n)):
        t = trail.n[i] * dt + trail.s[i]
        lo = max(begin - t, 0.0)
        hi = end - t
        if i + 1 < len(trail.n):
            hi = min(hi, trail.n[i + 1] * dt + trail.s[i + 1] - t)
        if hi <= lo:
            continue
        last = revive(plant, law, waves, u_dd, dt, jet, trail, i)
        d = (trail.d[i] > 0) - (trail.d[i] < 0)
        if d == 0:
            stuck += hi - lo if law.kind == STRIBECK else 0.0
            x2 += trail.x_r[i] ** 2 * (hi - lo)
        for k in range(len(TWELVE_NODES)):
            s = lo + (hi - lo) * TWELVE_NODES[k]
            weight = (hi - lo) * TWELVE_WEIGHTS[k]
            push = value(jet.u, ORDER, s)
            if d == 0:
                x_dd2 += weight * push * push
                continue
            x, v, z = state_at(jet, last, s)
            F = dynamic_force(law, d, v, z)
            x_dd = (k_x * x + b * v + F) / m
            x2 += weight * x * x
            v2 += weight * v * v
            x_dd2 += weight * x_dd * x_dd
            power += weight * push * v
            rub += weight * F * v / law.F_fk
    return x2, v2, x_dd2, power, rub, stuck
