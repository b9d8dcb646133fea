"""States between events: at any instant, or on a grid."""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.events import direction
from drysim.core.fade import fade
from drysim.core.sines.scene import V_R, unpacked
from drysim.core.sines.slide import from_rest, slide
from drysim.core.table import ROWS, add_wave, fill, set_mode, write_motion
from drysim.core.waves import (
    COSINE,
    OMEGA,
    SINE,
    STEADY,
    STRIDE,
    V_START,
    X_START,
    A,
    anchor,
)


@compiled
def state_within(plant, law, waves, u_0, slope, t, x_r, v_r, d, s):
    """Give x_r and v_r at time s of a stretch that starts at time t with this state."""
    if d == 0:
        return x_r, 0.0
    anchor(waves, plant, law, t, d)
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    return slide(c, w, waves, x_r, v_r, -u_0 - d * law.F_fk / plant.m, -slope, s)[:2]


@inlined
def point_before(t, dt):
    """Give the number of the last grid point before time t [s]; -1 for none."""
    n = int(t / dt)
    while n * dt >= t:
        n -= 1
    while (n + 1) * dt < t:
        n += 1
    return n


@inlined
def latest(t, at):
    """Give the number of the last event that is not after a time [s]; the first is not."""
    low, high = 0, len(t)
    while high - low > 1:
        middle = (low + high) // 2
        if t[middle] <= at:
            low = middle
        else:
            high = middle
    return low


@compiled
def sample_leaps(scene, t, kind, x_r, first, dt, table, out, d_out):
    """Write a solution under waves on the grid n·dt, from point `first` on.

    Parameters
    ----------
    scene : array
        As in `drysim.core.sines.scene`, its waves included.
    t, kind, x_r : array, shape (events,)
        The events; the first is the start.
    first : int
        Number of the first point.
    dt : float
        Distance of the grid points [s].
    table : array, shape (`drysim.core.table.room`,)
        Room for what the oscillator and the waves do in whole numbers of steps.
    out, d_out : array, shape (2, n) and (n,)
        Written: x_r and v_r, and the direction of sliding.

    Notes
    -----
    Between two events the points are sums of a few columns of the table, anew from the first of
    every `ROWS` behind the event: always the same ones, so that blocks change no number.
    """
    plant, law, waves = unpacked(scene)
    x_out, v_out = out[0], out[1]
    last = first + len(d_out)
    filled = 0
    event = latest(t, first * dt)
    n = first
    anchor(waves, plant, law, t[0], 0)
    while n < last:
        while event + 1 < len(t) and t[event + 1] <= n * dt:
            event += 1
        d = direction(kind[event])
        until = last
        if event + 1 < len(t):
            until = min(until, point_before(t[event + 1], dt) + 1)
        if d == 0:
            for k in range(n - first, until - first):
                x_out[k] = x_r[event]
                v_out[k] = 0.0
                d_out[k] = 0
            n = until
            continue
        begin = point_before(t[event], dt) + 1
        v_r = scene[V_R] if event == 0 else 0.0
        while n < until:
            start = n - (n - begin) % ROWS
            end = min(until, start + ROWS)
            filled = fill(plant, waves, dt, table, filled, end - start)
            sample_stretch(
                plant, law, waves, table, t[event], x_r[event], v_r, d, start, n, end, first,
                dt, x_out, v_out, d_out,
            )  # fmt: skip
            n = end


@inlined
def sample_stretch(
    plant, law, waves, table, t, x_r, v_r, d, start, n, end, first, dt, x_out, v_out, d_out
):
    """Write a slip from point n to the one before `end`, its mode included."""
    g, at = -d * law.F_fk / plant.m, n - first
    write_stretch(
        plant, law, waves, table, t, x_r, v_r, d, g, start, n, end, first, dt, x_out, v_out
    )
    if set_mode(d, at, end - n, v_out, d_out):
        return
    for k in range(at, end - first):
        if v_out[k] * d <= 0.0:
            # Rounding has the last word where the velocity is next to nothing.
            s = (first + k) * dt - t
            x_out[k], v_out[k] = state_within(plant, law, waves, 0.0, 0.0, t, x_r, v_r, d, s)


@inlined
def write_stretch(
    plant, law, waves, table, t, x_r, v_r, d, g, start, n, end, first, dt, x_out, v_out
):
    """Write a stretch from point n to the one before `end`, by its state at point `start`.

    It begins at time t [s] under the steady force g per mass [m/s²]. What it lacks of the
    steady response to the waves fades from there.
    """
    w = plant.k_x / plant.m
    anchor(waves, plant, law, t, d)
    x, v = lack(plant.b / plant.m, w, waves, x_r, v_r, g, start * dt - t)
    anchor(waves, plant, law, start * dt, d)
    row, at = n - start, n - first
    from_sine, from_cosine = wave_parts(waves, 0) if waves.size > 0 else (0.0, 0.0)
    write_motion(table, row, end - n, x, v, g - w * x, from_sine, from_cosine, at, x_out, v_out)
    for i in range(1, waves.size):
        from_sine, from_cosine = wave_parts(waves, i)
        add_wave(table, i, row, end - n, from_sine, from_cosine, at, x_out, v_out)


@inlined
def wave_parts(waves, i):
    """Give by how much each column of a wave counts from where it is anchored."""
    values, wave = waves.values, STRIDE * i
    if values[wave + STEADY] > 0.0:
        return values[wave + V_START], values[wave + X_START]
    push = -values[wave + A]
    return push * values[wave + COSINE] * values[wave + OMEGA], push * values[wave + SINE]


@inlined
def lack(c, w, waves, x_r, v_r, g, s):
    """Give x_r and v_r at time s of a slip, less the steady response to the waves.

    A wave that has none counts with what it has made from rest. Parameters as in `slide`.
    """
    values = waves.values
    y, y_d, Y = fade(c, w, s)
    x, v = 0.0, 0.0
    for i in range(waves.size):
        at = STRIDE * i
        if values[at + STEADY] > 0.0:
            x_r -= values[at + X_START]
            v_r -= values[at + V_START]
        else:
            swing, rate, _, _, _ = from_rest(c, w, values, at, s, y, y_d)
            x += swing
            v += rate
    push = g - w * x_r
    return x + x_r + v_r * y + push * Y, v + v_r * y_d + push * y
