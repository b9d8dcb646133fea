"""Growth of a small deviation along a motion under sines, period by period.

Problem
    A motion that does not become periodic may still settle slowly, be quasi-periodic or be
    chaotic. It is chaotic where small deviations grow on average, at the rate of the largest
    Lyapunov exponent.

Method
    A deviation follows the linearised motion exactly: the product of the segment flows and of a
    saltation matrix per event (`drysim.core.variational`). It is scaled back to
    unit length after each period, and the logarithms of the lengths are the growth. No second
    motion at a finite distance is needed, and there is no difference of nearly equal numbers.

Reference: P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with
discontinuities, Chaos, Solitons & Fractals 5 (1995) 1671.
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
    scene : SineScene
    period : float
        Period of the excitation [s].
    state : PeriodState
        State at the start of the first period.
    growth : array, shape (periods,)
        Written [-]: minus infinity where the deviation vanishes, NaN from the first period on
        in which it is not defined, as where the mass just touches the state of rest.
    """
    rate = velocity_scale_rate(scene.plant, period)
    p, q = math.sqrt(0.5), math.sqrt(0.5)
    broken = False
    for n in range(len(growth)):
        if broken:
            growth[n] = math.nan
            continue
        d = state.d
        state, events, _ = period_map(scene, period, state)
        if events < 0 or events + SINES_LOG_RESERVE > len(scene.log.kind):
            broken = True
            growth[n] = math.nan
            continue
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
            broken = True
            growth[n] = math.nan
