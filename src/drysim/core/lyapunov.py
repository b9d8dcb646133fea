"""Growth of a small deviation along a motion with Coulomb friction under sines.

It is the inner loop of `drysim.orbits.lyapunov`, period by period.
"""

from __future__ import annotations

import math

from drysim.core.compile import ZERO, compiled
from drysim.core.orbit import (
    SINES_LOG_RESERVE,
    period_map,
    velocity_scale_rate,
)
from drysim.core.variational import event_monodromy


@compiled
def deviation_growth(scene, period, state, growth):
    """Compute the logarithmic growth of a deviation in consecutive periods.

    Parameters
    ----------
    scene : SineMarch
    period : float
        Period of the excitation [s].
    state : PeriodState
        State at the start of the first period.
    growth : array, shape (periods,)
        Filled with NaN by the caller. Entry n becomes the growth in period n [-], minus
        infinity if the deviation vanishes. It stays NaN from the first period in which it is
        undefined, as where the mass just touches the state of rest.
    """
    rate = velocity_scale_rate(scene.plant, period)
    p, q = math.sqrt(0.5), math.sqrt(0.5)
    for n in range(len(growth)):
        d = state.d
        state, events, _ = period_map(scene, period, state)
        if events < 0 or events + SINES_LOG_RESERVE > len(scene.log.kind):
            return
        a, b, c, e = event_monodromy(scene, period, rate, d, int(ZERO), events)
        p, q = a * p + b * q, c * p + e * q
        size = math.hypot(p, q)
        if size == 0.0:
            growth[n] = -math.inf
            p, q = math.sqrt(0.5), math.sqrt(0.5)
        elif size < math.inf:
            growth[n] = math.log(size)
            p, q = p / size, q / size
        else:
            return
