"""A motion over a spring contact under sines on a grid: sums of the columns of two tables."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.contacts.contact import contact_force, holds, spring, steady_force
from drysim.core.grid import point_before, write_stretch
from drysim.core.table import ROWS, fill
from drysim.core.waves import anchor, normal_force


@compiled
def sample_contact(
    plant, law, waves, trail, first, dt, bare, sprung, x_out, v_out, F_out, d_out
):
    """Write a solution under waves on the grid n·dt, from point `first` on.

    Parameters
    ----------
    plant, law, waves
    trail : Trail
        Where each piece begins; the first one is before the first point.
    first, dt
        As in `sample_leaps`.
    bare, sprung : array, shape (`drysim.core.table.room`,)
        Room for the tables of the oscillator without and with the spring of the contact.
    x_out, v_out, F_out, d_out : array, shape (n,)
        Written: x_r, v_r, the contact force [N] and the direction of motion.
    """
    last = first + len(x_out)
    n, filled, filled_sprung = first, 0, 0
    for i in range(len(trail.s)):
        until = last
        if i + 1 < len(trail.s):
            until = min(last, point_before(trail.s[i + 1], dt) + 1)
        t, mode, x_0 = trail.s[i], trail.d[i], trail.z[i]
        d = mode if abs(mode) == 1 else 0
        effective = spring(plant, law, mode)
        g = -steady_force(law, mode, x_0) / plant.m
        begin = point_before(t, dt) + 1 if until > n else n
        while n < until:
            start = n - (n - begin) % ROWS
            end = min(until, start + ROWS)
            # Which waves have a steady response hangs on the spring.
            anchor(waves, effective, law, t, d)
            if holds(mode):
                table = sprung
                filled_sprung = fill(effective, waves, dt, sprung, filled_sprung, end - start)
            else:
                table = bare
                filled = fill(effective, waves, dt, bare, filled, end - start)
            write_stretch(
                effective, law, waves, table, t, trail.x_r[i], trail.v_r[i], d, g, start, n,
                end, first, dt, x_out, v_out,
            )  # fmt: skip
            for k in range(n, end):
                at = k - first
                load = 1.0
                if d != 0 and law.variation > 0.0:
                    load = max(normal_force(law, waves, (k - start) * dt)[0], 0.0)
                F_out[at] = contact_force(law, mode, x_out[at], x_0, load)
                d_out[at] = -1 if v_out[at] < 0.0 else 1
            n = end
