"""Leuven's law once more: its bristles by travel and force, events by scipy's integrator.

Shares no line with the core, which knows the force alone and no travel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from reference import RTOL
from scipy.integrate import solve_ivp  # noqa: TID253 - the independent solution

NOISE = 1e-6
"""Share of the speed [-] that bristles at their limit may seem to take back: the integrator's
own error, times a high power."""


@dataclass
class Bristles:
    """Where the bristles turned, as (travel, force), and the way they go."""

    stiffness: float
    F_h: float
    way: int = 1
    turns: list[tuple[float, float]] = field(default_factory=list)

    def force(self, s: float) -> float:
        """Return F_h [N] at a travel [m], by Masing's rule."""
        if not self.turns:
            return math.copysign(self.virgin(abs(s)), s)
        s_0, F_0 = self.turns[-1]
        return F_0 + self.way * 2.0 * self.virgin(abs(s - s_0) / 2.0)

    def virgin(self, s: float) -> float:
        """Return the virgin curve [N] at a travel above zero [m]."""
        return self.F_h * (1.0 - math.exp(-self.stiffness * s / self.F_h))

    @property
    def close(self) -> float:
        """Return the travel [m] at which the present loop closes."""
        if len(self.turns) > 1:
            return self.turns[-2][0]
        return -self.turns[0][0] if self.turns else self.way * math.inf

    def turn(self, s: float) -> None:
        """Turn round at a travel [m]; on the virgin curve only away from its origin."""
        if self.turns or s != 0.0:
            self.turns.append((s, self.force(s)))
        self.way = -self.way

    def closed(self) -> None:
        """Go on where the loop began."""
        del self.turns[-2:]


def swing(law, plant, base, end, times, method="DOP853", rtol=RTOL):
    """Return x_r [m] from rest at some times [s], the motion restarted at every event."""
    bristles = Bristles(law.sigma_0, law.F_h)
    d = -1 if base(1e-9) > 0.0 else 1
    bristles.way = d
    t, state, path = 0.0, np.zeros(3), []
    while t < end:
        found = _piece(law, plant, base, bristles, d, t, state, end, method, rtol)
        inside = times[(times >= t) & ((times < found.t[-1]) | (found.t[-1] >= end))]
        path.extend(found.sol(inside)[0] if len(inside) else ())
        t, state = found.t[-1], found.y[:, -1]
        stop, limit, loop = (len(each) > 0 for each in found.t_events)
        if stop:
            state[1] = 0.0
            pull = -plant.m * base(t) - plant.k_x * state[0] - bristles.force(state[2])
            if (pull > 0.0) != (d > 0):
                d = -d
                bristles.turn(state[2])
        elif limit:
            bristles.turn(state[2])
        elif loop:
            bristles.closed()
    return np.array(path)


def _piece(law, plant, base, bristles, d, t, state, end, method, rtol):
    """Integrate to the next event: the mass stops, the bristles stop, or a loop closes."""

    def left(v, F_h):
        """Return 1 - sgn(F_h/s) |F_h/s|^n, what the bristles take of the speed [-]."""
        curve = law.F_fk + (law.F_fs - law.F_fk) * math.exp(-((v / law.v_s) ** 2))
        return 1.0 - math.copysign(abs(F_h / curve) ** law.power, d * F_h)

    def rates(t, state):
        x, v, s = state
        F_h = bristles.force(s)
        s_d = v * left(v, F_h)
        F = F_h + law.sigma_1 * s_d + law.sigma_2 * v
        return [v, -base(t) - (plant.k_x * x + plant.b * v + F) / plant.m, s_d]

    far = min(1e3, abs(bristles.close)) * math.copysign(1.0, bristles.close)
    events = [
        lambda t, y: d * y[1],
        lambda t, y: d * bristles.way * left(y[1], bristles.force(y[2])) + NOISE,
        lambda t, y: bristles.way * (far - y[2]),
    ]
    for event in events:
        event.terminal, event.direction = True, -1
    return solve_ivp(
        rates, (t, end), state, method, rtol=rtol, atol=1e-3 * rtol, events=events,
        dense_output=True, first_step=1e-7,
    )  # fmt: skip
