"""Exact integrals over a stretch between two events of a step."""

from __future__ import annotations

from drysim.core.compiled import inlined
from drysim.core.integrals import integrate
from drysim.core.samples.series import distance, series, speed

NODES = (
    0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262,
)  # fmt: skip
WEIGHTS = (
    0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692,
)  # fmt: skip
"""Gauss-Legendre: on a stretch that is brief enough for `series` four exhaust double
precision, for the error is below (2·0.1)⁸/10⁹."""


@inlined
def stretch(plant, law, steps, waves, u_0, slope, x_r, v_r, d, h):
    """Give x2, v2, x_dd2, power and rub of one stretch between events, as in `Totals`."""
    if d != 0 and not steps.brief:
        return integrate(plant, law, waves, u_0, slope, 0.0, x_r, v_r, d, 0.0, h)
    if d == 0:
        u_1 = u_0 + slope * h
        u2 = h / 3.0 * (u_0 * u_0 + u_0 * u_1 + u_1 * u_1)
        return x_r * x_r * h, 0.0, u2, 0.0, 0.0
    return short_stretch(steps, u_0, slope, x_r, v_r, d, h)


@inlined
def short_stretch(steps, u_0, slope, x_r, v_r, d, h):
    """Give what `stretch` gives where `series` serves."""
    c, w, f = steps.c, steps.w, d * steps.f
    a = -(u_0 + c * v_r + w * x_r + f)
    q = series(steps.tail, v_r, a, -slope - c * a - w * v_r)
    x2, v2, x_dd2, power = 0.0, 0.0, 0.0, 0.0
    for i in range(len(NODES)):
        s = h * NODES[i]
        x, v = x_r + distance(q, s), speed(q, s)
        x_dd = w * x + c * v + f
        x2 += WEIGHTS[i] * x * x
        v2 += WEIGHTS[i] * v * v
        x_dd2 += WEIGHTS[i] * x_dd * x_dd
        power += WEIGHTS[i] * (u_0 + slope * s) * v
    return h * x2, h * v2, h * x_dd2, h * power, d * distance(q, h)
