"""States between events: at any instant, or on a grid."""

from __future__ import annotations

import math

from drysim.core.base import RENEW
from drysim.core.compiled import compiled
from drysim.core.events import direction
from drysim.core.fade import fade
from drysim.core.slide import slide
from drysim.core.wave import wave
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A, anchor

TO_X_COSINE, TO_X_SINE, TO_V_COSINE, TO_V_SINE = 0, 1, 2, 3
"""What a wave of unit amplitude adds to x_r and v_r in one step, by its sine and cosine."""

TURN_SINE, TURN_BACK, NOW_SINE, NOW_COSINE = 4, 5, 6, 7
"""The angle by which a wave turns in one step, as its sine and 1 - cosine, which keeps the
rounding of a turn small; and where the wave is."""

STEP = 8
"""Columns of a wave in the table of steps."""


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
def point_before(t, dt):
    """Give the number of the last grid point before time t [s]; -1 for none."""
    n = int(t / dt)
    while n * dt >= t:
        n -= 1
    while (n + 1) * dt < t:
        n += 1
    return n


@compiled
def turn_to(values, steps, size, at):
    """Set every wave to where it is at a time [s]."""
    for i in range(size):
        wave_at = STRIDE * i
        theta = (
            2.0 * math.pi * ((values[wave_at + FREQUENCY] * at) % 1.0) + values[wave_at + PHASE]
        )
        steps[STEP * i + NOW_SINE] = math.sin(theta)
        steps[STEP * i + NOW_COSINE] = math.cos(theta)


@compiled
def step_map(c, w, waves, dt, steps):
    """Write what every wave does in one step; gives the flow of the step without waves."""
    y, y_d, Y = fade(c, w, dt)
    for i in range(waves.size):
        omega = waves.values[STRIDE * i + OMEGA]
        R, P, P_d, sine, _ = wave(c, w, omega, dt, y, y_d)
        at = STEP * i
        steps[at + TO_X_COSINE] = omega * R
        steps[at + TO_X_SINE] = P
        steps[at + TO_V_COSINE] = omega * P
        steps[at + TO_V_SINE] = P_d
        steps[at + TURN_SINE] = omega * sine
        steps[at + TURN_BACK] = 2.0 * math.sin(0.5 * omega * dt) ** 2
    return y, y_d, Y


@compiled
def sample_leaps(
    plant, law, waves, t, kind, x_r, v_first, first, dt, steps, x_out, v_out, d_out
):
    """Write a solution under waves on the grid n·dt, from point `first` on.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        The events; the first is before the first point and leaves with `v_first` [m/s].
    first : int
        Number of the first point.
    dt : float
        Distance of the grid points [s].
    steps : array, shape (STEP waves,)
        Room for what the waves do in a step.
    x_out, v_out, d_out : array, shape (n,)
        Written.

    Notes
    -----
    Between two events a step is an affine map of the state and of the waves' phases, so a point
    costs a few multiplications; every `RENEW` points it is worked out from the event.
    """
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    flow = step_map(c, w, waves, dt, steps)
    last = first + len(x_out)
    event = 0
    n = first
    while n < last:
        while event + 1 < len(t) and t[event + 1] <= n * dt:
            event += 1
        d = direction(kind[event])
        until = last
        if event + 1 < len(t):
            until = min(until, point_before(t[event + 1], dt) + 1)
        if d == 0:
            for k in range(n, until):
                x_out[k - first] = x_r[event]
                v_out[k - first] = 0.0
                d_out[k - first] = 0
            n = until
            continue
        begin = point_before(t[event], dt) + 1
        v_r = v_first if event == 0 else 0.0
        while n < until:
            start = max(begin, n - n % RENEW)
            end = min(until, n - n % RENEW + RENEW)
            sample_stretch(
                plant, law, waves, flow, t[event], x_r[event], v_r, d, start, n, end, first, dt,
                steps, x_out, v_out, d_out,
            )  # fmt: skip
            n = end


@compiled
def sample_stretch(
    plant,
    law,
    waves,
    flow,
    t,
    x_r,
    v_r,
    d,
    start,
    n,
    end,
    first,
    dt,
    steps,
    x_out,
    v_out,
    d_out,
):
    """March over the grid from point `start` of a slip to `end`, and write from point n on."""
    y, y_d, Y = flow
    w = plant.k_x / plant.m
    g = -d * law.F_fk / plant.m
    values = waves.values
    size = waves.size
    x, v = state_within(plant, law, waves, 0.0, 0.0, t, x_r, v_r, d, start * dt - t)
    turn_to(values, steps, size, start * dt)
    for k in range(start, end):
        if k > start and v * d <= 0.0:
            # Rounding has the last word where the velocity is next to nothing.
            x, v = state_within(plant, law, waves, 0.0, 0.0, t, x_r, v_r, d, k * dt - t)
        if k >= n:
            x_out[k - first] = x
            v_out[k - first] = v
            d_out[k - first] = d
        pull = g - w * x
        x_next = x + v * y + pull * Y
        v_next = v * y_d + pull * y
        for i in range(size):
            at = STEP * i
            sine = steps[at + NOW_SINE]
            cosine = steps[at + NOW_COSINE]
            A_i = values[STRIDE * i + A]
            x_next -= A_i * (steps[at + TO_X_COSINE] * cosine + steps[at + TO_X_SINE] * sine)
            v_next -= A_i * (steps[at + TO_V_COSINE] * cosine + steps[at + TO_V_SINE] * sine)
            turn = steps[at + TURN_SINE]
            back = steps[at + TURN_BACK]
            steps[at + NOW_SINE] = sine + (cosine * turn - sine * back)
            steps[at + NOW_COSINE] = cosine - (sine * turn + cosine * back)
        x, v = x_next, v_next
