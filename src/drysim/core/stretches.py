"""Exact integrals over the steps of a piece of a march that hold events, stretch by stretch."""

from __future__ import annotations

from drysim.core.compiled import compiled, inlined
from drysim.core.events import direction
from drysim.core.integrals import integrate
from drysim.core.series import distance, series, speed

NODES = (
    0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262,
)  # fmt: skip
WEIGHTS = (
    0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692,
)  # fmt: skip
"""Gauss-Legendre: on a stretch that is short enough for `series` four exhaust double
precision, for the error is below (2·0.0625)⁸/10⁹."""


@inlined
def stretch(plant, law, steps, waves, u_0, slope, x_r, v_r, d, h):
    """Give x2, v2, x_dd2, power and rub of one stretch between events, as in `Totals`."""
    if d != 0 and not steps.short:
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


@compiled
def eventful_steps(plant, law, steps, waves, u_dd, piece, log, count, begin, last):
    """Give x2, v2, x_dd2, power, rub and stuck of the steps of a piece that hold events."""
    x2, v2, x_dd2, power, rub, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    before, start, x, v, d = -1, 0.0, 0.0, 0.0, 0
    for k in range(count):
        n = log.n[k]
        if not begin <= n < last:
            continue
        if n != before:
            before, start, x, v, d = n, 0.0, piece.x_r[n], piece.v_r[n], piece.d[n] * 1
        slope = (u_dd[n + 1] - u_dd[n]) / steps.dt
        final = k + 1 == count or log.n[k + 1] != n
        for end in (log.s[k], steps.dt):
            part = stretch(
                plant, law, steps, waves, u_dd[n] + slope * start, slope, x, v, d, end - start
            )
            x2 += part[0]
            v2 += part[1]
            x_dd2 += part[2]
            power += part[3]
            rub += part[4]
            stuck += end - start if d == 0 else 0.0
            start, x, v, d = log.s[k], log.x_r[k], 0.0, direction(log.kind[k])
            if not final:
                break
    return x2, v2, x_dd2, power, rub, stuck
