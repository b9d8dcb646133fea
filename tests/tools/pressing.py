"""Coulomb's friction under a normal force of any course: an integrator and a state machine."""

from __future__ import annotations

import numpy as np
from legs import event, leg
from reference import RTOL


def march_pressed(
    plant, F_fk, F_fs, load, base, duration, state=(0.0, 0.0), kinks=(), rtol=RTOL
):
    """Solve by scipy's DOP853, restarted at every change of mode and at every kink.

    Parameters
    ----------
    load, base : callable
        Normal force relative to its mean, and ü, at a time [s]; smooth but for the kinks [s].

    Returns
    -------
    list of (t_begin, t_end, solution, mode)
    """
    m, k_x, b = plant
    t, y, pieces = 0.0, np.array(state, dtype=float), []

    def limit_force(t, x):
        return m * base(t) + k_x * x

    def fresh(t, y):
        """Return the mode by the rules; where limits vanish, a slightly later time decides."""
        if load(t + 1e-9) <= 0.0:
            return "free"
        if y[1] != 0.0:
            return int(np.sign(y[1]))
        F_L = limit_force(t, y[0])
        return "stuck" if abs(F_L) <= F_fs * max(load(t), 0.0) else -int(np.sign(F_L))

    mode = fresh(0.0, y)
    while t < duration - 1e-12:
        d = mode if isinstance(mode, int) else 0

        def rates(t, y, d=d, mode=mode):
            if mode == "stuck":
                return [0.0, 0.0]
            return [y[1], -base(t) - (k_x * y[0] + b * y[1] + d * F_fk * load(t)) / m]

        events = [event(lambda t, y: load(t), 1 if mode == "free" else -1)]
        if mode == "stuck":
            for side in (1, -1):
                events.append(
                    event(
                        lambda t, y, side=side: F_fs * load(t) - side * limit_force(t, y[0]), -1
                    )
                )
        elif d:
            events.append(event(lambda t, y, d=d: d * y[1], -1))
        begin = t
        t, y, solution, hit = leg(rates, t, y, duration, kinks, events, rtol)
        pieces.append((begin, t, solution, mode))
        if hit is None:
            continue
        if hit == 0:
            mode = fresh(t, y)
        elif mode == "stuck":
            mode = -1 if hit == 1 else 1
        else:
            y[1] = 0.0
            mode = fresh(t, y)
    return pieces
