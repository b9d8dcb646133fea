"""Motion between end stops by an integrator and a state machine: independent of the core."""

from __future__ import annotations

import numpy as np
from legs import event
from reference import RTOL

LAID_DOWN = 1e-7
"""Rebound [m/s] at which the machine lays a pressed mass down: it would fly some 1e-15 m."""


def march_stops(plant, law, base, duration, state=(0.0, 0.0), knots=(), rtol=RTOL):
    """Solve a scene with end stops by scipy's DOP853, restarted at every change of mode.

    Returns
    -------
    list of (t_begin, t_end, solution, direction), and list of (t, velocity at a stop)
    """
    from scipy.integrate import solve_ivp

    (m, k_x, b), limit = plant, law.stops.limits.up
    k_s = 0.0 if law.stops.rigid else law.stops.stages[0][1]
    t, y, touch, pieces, hits = 0.0, np.array(state, dtype=float), 0, [], []

    def push(touch, x, v):
        return k_s * (x - touch * limit) + law.stops.b_s * v if touch else 0.0

    def heading(t, x, touch):
        F_L = m * base(t) + k_x * x + push(touch, x, 0.0)
        if abs(F_L) <= law.F_fs:
            return 0, F_L
        d = -int(np.sign(F_L))
        wall = int(np.sign(x)) if law.stops.rigid and abs(x) == limit else 0
        return (0 if d == wall else d), F_L

    if not law.stops.rigid and abs(y[0]) > limit:
        side = int(np.sign(y[0]))
        touch = side if side * push(side, *y) > 0 else 0
    d = int(np.sign(y[1])) or heading(t, y[0], touch)[0]
    while t < duration - 1e-12:
        end = min([knot for knot in knots if knot > t + 1e-13] + [duration])
        if d == 0:
            x = y[0]
            wall = int(np.sign(x)) if law.stops.rigid and abs(x) == limit else 0
            pull = k_x * x + push(touch, x, 0.0)

            def still(t, y):
                return [0.0, 0.0]

            sides = [side for side in (1, -1) if wall in (0, side)]
            events = [
                event(lambda t, y, s=s, p=pull: law.F_fs - s * (m * base(t) + p), -1)
                for s in sides
            ]
            found = solve_ivp(
                still, (t, end), [x, 0.0], "DOP853", events=events, max_step=1e-3,
                dense_output=True,
            )  # fmt: skip
            pieces.append((t, found.t[-1], found.sol, d))
            t, y = found.t[-1], np.array([x, 0.0])
            broke = [s for s, times in zip(sides, found.t_events, strict=True) if len(times)]
            d = -broke[0] if broke else 0
            continue

        def rates(t, y, d=d, touch=touch):
            pull = k_x * y[0] + b * y[1] + d * law.F_fk + push(touch, *y)
            return [y[1], -base(t) - pull / m]

        away = int(np.sign(y[0])) if not touch and abs(y[0]) > limit else 0
        events = [event(lambda t, y, d=d: d * y[1], -1)]
        if not touch:
            events.append(event(lambda t, y, d=d: d * y[0] - limit, 1))
        if touch:
            events.append(event(lambda t, y, s=touch: s * push(s, *y), -1))
        elif away:
            events.append(event(lambda t, y, s=away: s * push(s, *y), 1))
        found = solve_ivp(
            rates, (t, end), y, "DOP853", events=events, rtol=rtol, atol=1e-3 * rtol,
            max_step=1e-3, dense_output=True,
        )  # fmt: skip
        pieces.append((t, found.t[-1], found.sol, d))
        t, y = found.t[-1], found.y[:, -1]
        turned, *others = [len(times) > 0 for times in found.t_events]
        met, changed = (False, others[0]) if touch else (others[0], any(others[1:]))
        if met:
            hits.append((t, y[1]))
            y[0] = d * limit
            if law.stops.rigid:
                y[1] *= -law.stops.e
                d = -d
                pressed = -np.sign(y[0]) * (m * base(t) + k_x * y[0]) - law.F_fk > 0
                if abs(y[1]) < LAID_DOWN and (pressed or law.stops.e == 0.0):
                    y[1] = 0.0
                    d = heading(t, y[0], 0)[0]
            else:
                touch = d
        elif changed:
            touch = 0 if touch else away
        elif turned:
            y[1] = 0.0
            if law.stops.rigid and abs(abs(y[0]) - limit) < 1e-15:
                y[0] = np.sign(y[0]) * limit
            d = heading(t, y[0], touch)[0]
    return pieces, hits
