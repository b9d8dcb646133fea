"""Spring contacts by an integrator and a state machine: independent of the core."""

from __future__ import annotations

import math

import numpy as np
from legs import event, leg
from reference import RTOL


def load_of(law, t):
    """Return the normal force relative to its mean, and its rate, at time t [s]."""
    angle = law.omega * t + law.phase
    return (1.0 + law.variation * math.sin(angle), law.variation * law.omega * math.cos(angle))


def march_contact(plant, law, base, duration, state=(0.0, 0.0), kinks=(), rtol=RTOL):
    """Solve a spring contact by scipy's DOP853, restarted at every change of mode.

    `kinks` are the times at which the rate of the base acceleration jumps [s].

    Returns
    -------
    list of (t_begin, t_end, solution, mode)
    """
    m, k_x, b = plant
    mode, x_0, t, y = "hold", state[0], 0.0, np.array(state, dtype=float)
    if load_of(law, 0.0)[0] <= 0.0:
        mode = "free"
    pieces = []

    def force(mode, x_0, t, x):
        if mode == "free":
            return 0.0
        if mode == "hold":
            return law.k_t * (x - x_0)
        return mode * law.F_fk * load_of(law, t)[0]

    while t < duration - 1e-12:

        def rates(t, y, mode=mode, x_0=x_0):
            return [y[1], -base(t) - (k_x * y[0] + b * y[1] + force(mode, x_0, t, y[0])) / m]

        if mode == "free":
            events = [event(lambda t, y: load_of(law, t)[0], 1)]
        else:
            events = [event(lambda t, y: load_of(law, t)[0], -1)]
            if mode == "hold":
                for side in (1, -1):
                    events.append(
                        event(
                            lambda t, y, s=side, x_0=x_0: (
                                law.F_fk * load_of(law, t)[0] - s * law.k_t * (y[0] - x_0)
                            ),
                            -1,
                        )
                    )
            else:
                events.append(
                    event(
                        lambda t, y, d=mode: d * law.k_t * y[1] - law.F_fk * load_of(law, t)[1],
                        -1,
                    )
                )
        begin = t
        t, y, solution, hit = leg(rates, t, y, duration, kinks, events, rtol)
        pieces.append((begin, t, solution, mode))
        if hit is None:
            continue
        load, load_d = load_of(law, t)
        if mode == "free":
            x_0 = y[0]
            outruns = law.k_t * abs(y[1]) > law.F_fk * load_d
            mode = int(np.sign(y[1])) if outruns else "hold"
        elif hit == 0:
            mode = "free"
        elif mode == "hold":
            mode = 1 if hit == 1 else -1
        else:
            x_0 = y[0] - mode * law.F_fk * load / law.k_t
            mode = "hold"
    return pieces


def at(pieces, t):
    """Return x_r and v_r of such a solution at times t [s]."""
    found = np.empty((2, len(t)))
    for begin, end, solution, _ in pieces:
        inside = (t >= begin) & (t <= end)
        if inside.any():
            found[:, inside] = solution(t[inside])
    return found
