"""When a blend of the motion and of the normal force vanishes, rigorously.

What a contact may still bear, how fast it yields, the force of a bumper: each is a sum of x_r,
v_r and the normal force, whose rates a stretch knows. Steps that a bound on the third rate
proves safe lead to the zero from below; where the bound proves that the blend only falls until
it is below zero, Newton's method does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.cease import FALLS, NEWTON_CAP, REACH, safe_slip, to_zero
from drysim.core.sines.slide import slide_and_snap
from drysim.core.sines.stretch import force_rates
from drysim.core.waves import normal_force


class Blend(NamedTuple):
    """The sum x (x_r - x_0) + v v_r + load N + rate N', N the normal force and N' its rate.

    Attributes
    ----------
    x_0 : float
        Where x_r counts from [m].
    x, v : float
        Shares of x_r and v_r.
    load, rate : float
        Shares of the normal force relative to its mean, and of its rate.
    """

    x_0: float
    x: float
    v: float
    load: float
    rate: float


@inlined
def blended(law, waves, blend, x, v, a, j, k, s):
    """Give a blend and its first three rates at time s of a stretch, where the motion is so."""
    value, rate = blend.x * (x - blend.x_0) + blend.v * v, blend.x * v + blend.v * a
    bend, twist = blend.x * a + blend.v * j, blend.x * j + blend.v * k
    if blend.load != 0.0 or blend.rate != 0.0:
        load, load_d, load_dd = normal_force(law, waves, s)
        square = law.omega * law.omega
        value += blend.load * load + blend.rate * load_d
        rate += blend.load * load_d + blend.rate * load_dd
        bend += blend.load * load_dd - blend.rate * square * load_d
        twist -= square * (blend.load * load_d + blend.rate * load_dd)
    return value, rate, bend, twist


@inlined
def most_twist(blend, w, a, j, k, swing):
    """Give a bound of the third rate of a blend, up to what its growth adds."""
    most = swing + abs(blend.x) * math.sqrt(j * j + w * a * a)
    return most + abs(blend.v) * math.sqrt(k * k + w * j * j)


@compiled
def vanish(stretch, waves, law, blend, zeros, h, stays):
    """Give the first time in [0, h] at which a blend is no longer above zero, and the motion.

    Parameters
    ----------
    stretch : Stretch
    waves : Waves
        Anchored at its start.
    law
        Whose normal force it is.
    blend : Blend
        What is at least zero at the start, roundings apart.
    zeros : int
        What is zero exactly at the start: 1 the blend, 2 its rate as well.
    h : float
        Length of the stretch [s].
    stays : bool
        Whether the blend is known to be above zero at the end.

    Returns
    -------
    s, x_r, v_r : float
        Time [s], infinite where the blend stays above zero, and the state then.

    Notes
    -----
    Jerk and its rate obey the oscillator's equation driven by rates of the force, so that
    |jerk|(s) <= sqrt(jerk² + w a²) + s·max|second rate|, and likewise the next one.
    """
    c, w, x_r, v_r, a, j, k, g, r = stretch
    _, second, third, fastest = force_rates(waves, r)
    growth = abs(blend.x) * second + abs(blend.v) * third
    swing = law.variation * (abs(blend.load) + abs(blend.rate) * law.omega) * law.omega**3
    cap = min(REACH / fastest, h) if fastest > 0.0 else h
    s, x, v = 0.0, x_r, v_r
    value, rate, bend, twist = blended(law, waves, blend, x, v, a, j, k, s)
    value = 0.0 if zeros > 0 else max(value, 0.0)
    rate = 0.0 if zeros > 1 else rate
    most = most_twist(blend, w, a, j, k, swing)
    if value > h * (max(-rate, 0.0) + h * (max(-bend, 0.0) + h * (most + h * growth))):
        # Far from zero, as in most steps of a record.
        return NEVER, x, v
    while True:
        most = most_twist(blend, w, a, j, k, swing)
        if rate < 0.0 < value:
            far = 1.5 * to_zero(value, rate, bend)
            loses = (max(bend, 0.0) + (0.5 * most + growth * far / 6.0) * far) * far
            if -rate >= FALLS * loses:
                if stays and s + far >= h:
                    return NEVER, x, v
                break
        step = safe_slip(value, rate, bend, most, growth, cap)
        if value > 0.0 and bend > 0.0 and step < cap:
            # Where it hardly bends upwards, what it bends is better left out.
            step = max(step, safe_slip(value, rate, 0.0, most, growth, cap))
        if step == 0.0:
            return s, x, v
        if s + step >= h:
            return NEVER, x, v
        if step <= RESOLUTION * s:
            return s, x, v
        s += step
        x, v, a, j, k = slide_and_snap(c, w, waves, x_r, v_r, g, r, s)
        value, rate, bend, twist = blended(law, waves, blend, x, v, a, j, k, s)
        if value <= 0.0:
            return s, x, v
    for _ in range(NEWTON_CAP):
        step = to_zero(value, rate, bend)
        # The parabola leaves step³ twist/6; what the cubic leaves is at most step⁴/24 of this.
        rises = 6.0 * rate + (6.0 * bend + 3.0 * twist * step) * step
        step -= step * step * step * twist / rises
        most += growth * abs(step)
        fourth = (c + math.sqrt(w)) * most + growth + swing * law.omega
        s += step
        if fourth * step * step * step * step <= -24.0 * rate * RESOLUTION * s or step == 0.0:
            x += step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            v += step * (a + step * (0.5 * j + step * k / 6.0))
            break
        x, v, a, j, k = slide_and_snap(c, w, waves, x_r, v_r, g, r, s)
        value, rate, bend, twist = blended(law, waves, blend, x, v, a, j, k, s)
        most = most_twist(blend, w, a, j, k, swing)
    return (s, x, v) if s < h else (NEVER, x, v)
