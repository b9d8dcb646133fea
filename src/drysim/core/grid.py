"""States between events: at any instant, or on a grid."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import direction
from drysim.core.slide import slide
from drysim.core.waves import anchor


@compiled
def state_within(plant, law, waves, u_0, slope, t, x_r, v_r, d, s):
    """Give x_r and v_r at time s of a stretch that starts at time t with this state."""
    if d == 0:
        return x_r, 0.0
    anchor(waves, plant, law, t, d)
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    return slide(c, w, waves, x_r, v_r, -u_0 - d * law.F_fk / plant.m, -slope, s)[:2]


@compiled
def sample_leaps(plant, law, waves, t, kind, x_r, v_first, first, dt, x_out, v_out, d_out):
    """Write a solution under waves on the grid n·dt, from point `first` on.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        The events; the first is before the first point and leaves with `v_first` [m/s].
    first : int
        Number of the first point.
    dt : float
        Distance of the grid points [s].
    x_out, v_out, d_out : array, shape (n,)
        Written.
    """
    event = 0
    for n in range(len(x_out)):
        at = (first + n) * dt
        while event + 1 < len(t) and t[event + 1] <= at:
            event += 1
        d = direction(kind[event])
        v_r = v_first if event == 0 else 0.0
        x_out[n], v_out[n] = state_within(
            plant, law, waves, 0.0, 0.0, t[event], x_r[event], v_r, d, at - t[event]
        )
        d_out[n] = d
