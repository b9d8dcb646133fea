"""Turns of a mass on a spring contact of constant limit over samples, as far as they tell."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.contacts.contact import holds
from drysim.core.contacts.hit import next_stop
from drysim.core.contacts.telling import holds_unseen
from drysim.core.events import onset
from drysim.core.samples.stop import NEVER


@compiled
def tell_steps(
    plant, law, sprung, u_dd, x_out, v_out, trail, whole, x_rM, at, t_told, x_told
):  # fmt: skip
    """Write what `tell` does, of a march over samples; a contact of constant limit.

    Parameters
    ----------
    plant, law, trail, whole, x_rM
        As in `tell`.
    sprung : Whole
        The steps of a contact that holds.
    u_dd, x_out, v_out : array, shape (samples,)
        Base acceleration [m/s²], and the state [m, m/s].
    at : tuple
        Where to go on: piece, sample, time since it [s], x_r and v_r then [m, m/s]; the sample
        is negative at the beginning of a piece.
    t_told, x_told : array, shape (room,)
        Written: time [s] and displacement [m].
    """
    i, n, s, x, v = at
    c, w, dt, stiffness = sprung.c, sprung.w, sprung.dt, law.k_t / plant.m
    count = 0
    while i < len(trail.n) and count + 2 <= len(t_told):
        if n < 0:
            n, s, x, v = trail.n[i], trail.s[i], trail.x_r[i], trail.v_r[i]
            t_told[count], x_told[count] = n * dt + s, x
            count += 1
            if not holds(trail.d[i]) or not (whole[i] or not holds_unseen(law, trail, i, x_rM)):
                i, n = i + 1, -1
                continue
        last, end = len(u_dd) - 1, 0.0
        if i + 1 < len(trail.n):
            last, end = trail.n[i + 1], trail.s[i + 1]
        f = -stiffness * trail.z[i]
        while (n < last or (n == last and s < end)) and count + 2 <= len(t_told):
            slope = (u_dd[n + 1] - u_dd[n]) * sprung.per_dt
            a = -(u_dd[n] + slope * s + c * v + w * x + f)
            way = onset(v, a, -slope)
            h = (end if n == last else dt) - s
            stop, far = NEVER, 0.0
            if way != 0:
                stop, far, _ = next_stop(sprung, way * v, way * a, -way * slope, h)
            if stop < h and s + stop > s:
                x, v, s = x + way * far, 0.0, s + stop
                t_told[count], x_told[count] = n * dt + s, x
                count += 1
            else:
                n, s = n + 1, 0.0
                x, v = x_out[n], v_out[n]
        if n > last or (n == last and s >= end):
            i, n = i + 1, -1
    return (i, n, s, x, v), count
