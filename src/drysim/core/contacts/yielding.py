"""When a spring contact yields, and when a yielding one holds again, rigorously.

Steps that a bound on the curvature proves safe lead to the zero from below; where the bound
proves that the function only falls until it is below zero, Newton's method does.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.cease import FALLS, to_zero
from drysim.core.sines.leave import first_step, safe_step
from drysim.core.sines.slide import slide
from drysim.core.waves import COSINE, OMEGA, SINE, STRIDE, A, normal_force


@compiled
def bounds(waves, r):
    """Give bounds of the first two rates of the force per mass, and the greatest omega.

    Parameters
    ----------
    waves : Waves
        Anchored.
    r : float
        Rate of the force per mass besides the waves [m/s³].
    """
    first = abs(r)
    second = 0.0
    fastest = 0.0
    for i in range(waves.size):
        omega = waves.values[STRIDE * i + OMEGA]
        first += abs(waves.values[STRIDE * i + A]) * omega
        second += abs(waves.values[STRIDE * i + A]) * omega * omega
        fastest = max(fastest, omega)
    return first, second, fastest


@compiled
def off_zero(rate, bend, bend_bound, third_bound, cap):
    """Give a step that provably leaves zero upwards: 0 for none, infinity if all is still."""
    if bend_bound == 0.0:
        return NEVER
    return max(min(first_step(rate, bend, bend_bound, third_bound), cap), 0.0)


@inlined
def starting(c, w, waves, x_r, v_r, g, r):
    """Give acceleration and jerk as a stretch starts; parameters as in `slide`."""
    push, push_d = g, r
    for i in range(waves.size):
        at = STRIDE * i
        A_i = waves.values[at + A]
        push -= A_i * waves.values[at + SINE]
        push_d -= A_i * waves.values[at + OMEGA] * waves.values[at + COSINE]
    a = push - c * v_r - w * x_r
    return a, push_d - c * a - w * v_r


@inlined
def only_falls(value, rate, bend, bound, growth, cap):
    """Tell whether a function above zero falls all the way to 1.5 times its parabola's zero.

    `bound` and `growth` are as in `safe_step`.
    """
    if not value > 0.0 > rate:
        return False
    far = 1.5 * to_zero(value, rate, bend)
    return far < cap and -rate >= FALLS * (bound + growth * far) * far


@compiled
def leave_hold(c, w, waves, law, x_r, v_r, a, g, r, x_0, side, poised, h):
    """Give the first time in [0, h] at which a holding contact yields to one side, or infinity.

    Parameters
    ----------
    c, w, waves, x_r, v_r, g, r
        As in `slide`, with the spring of the contact in w.
    a : float
        Acceleration at the start [m/s²].
    law : Slider
    x_0 : float
        Where the contact carries no force [m].
    side : int
        +1 where x_r yields upwards, -1 downwards.
    poised : bool
        Whether it holds at this very limit, and just so: value and rate are zero exactly.
    h : float
        Length of the stretch [s].

    Notes
    -----
    The acceleration obeys the oscillator's equation driven by the rate of the force, which
    bounds it; with it the second rate of what the contact may still bear.
    """
    growth, third, fastest = bounds(waves, r)
    growth *= law.k_t
    third *= law.k_t
    swing = law.F_fk * law.variation
    fastest = max(fastest, law.omega if swing > 0.0 else 0.0)
    cap = 1.0 / fastest if fastest > 0.0 else NEVER
    s, falls = 0.0, False
    x, v = x_r, v_r
    while True:
        load, load_d, load_dd = normal_force(law, waves, s)
        value = law.F_fk * load - side * law.k_t * (x - x_0)
        rate = law.F_fk * load_d - side * law.k_t * v
        bend = law.F_fk * load_dd - side * law.k_t * a
        if poised and s == 0.0:
            value, rate = 0.0, 0.0
        bound = law.k_t * math.sqrt(a * a + w * v * v) + swing * law.omega**2
        if falls or only_falls(value, rate, bend, bound, growth, cap):
            falls = True
            step = to_zero(value, rate, bend)
            s += step
            thrice = (c + math.sqrt(w)) * bound + third + swing * law.omega**3
            if thrice * abs(step) ** 3 <= -6.0 * rate * RESOLUTION * s or not step < h:
                return s if s < h else NEVER
            x, v, a, _ = slide(c, w, waves, x_r, v_r, g, r, s)
            continue
        if value <= 0.0 and s > 0.0:
            return s
        if value > 0.0:
            step = safe_step(value, rate, bound, growth, cap)
        else:
            bound += growth * min(cap, h)
            fourth = (c + math.sqrt(w)) * bound + third + swing * law.omega**3
            step = off_zero(rate, bend, bound, fourth, cap)
        if step == 0.0:
            return s
        if s + step >= h:
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step
        x, v, a, _ = slide(c, w, waves, x_r, v_r, g, r, s)


@compiled
def leave_yield(c, w, waves, law, x_r, v_r, a, j, g, r, d, h):
    """Give the first time in (0, h] at which a contact that yields in direction d holds again.

    It does when the mass no longer outruns the limit of its spring, which with a constant
    normal force is when it stops. Parameters as in `leave_hold`, w without the contact, and
    the jerk j at the start [m/s³].
    """
    _, growth, fastest = bounds(waves, r)
    swing = law.F_fk * law.variation / law.k_t
    cap = 1.0 / fastest if fastest > 0.0 else NEVER
    s, falls = 0.0, False
    v = v_r
    while True:
        _, load_d, load_dd = normal_force(law, waves, s)
        value = d * v - law.F_fk / law.k_t * load_d
        rate = d * a - law.F_fk / law.k_t * load_dd
        bend = d * j + law.F_fk / law.k_t * load_d * law.omega**2
        bound = math.sqrt(j * j + w * a * a) + swing * law.omega**3
        if falls or only_falls(value, rate, bend, bound, growth, cap):
            falls = True
            step = to_zero(value, rate, bend)
            s += step
            thrice = (c + math.sqrt(w)) * bound + growth + swing * law.omega**4
            if thrice * abs(step) ** 3 <= -6.0 * rate * RESOLUTION * s or not step < h:
                return s if s < h else NEVER
            _, v, a, j = slide(c, w, waves, x_r, v_r, g, r, s)
            continue
        if value <= 0.0 and s > 0.0:
            return s
        if value > 0.0:
            step = safe_step(value, rate, bound, growth, cap)
        else:
            bound += growth * min(cap, h)
            fourth = (c + math.sqrt(w)) * bound + growth + swing * law.omega**4
            step = off_zero(rate, bend, bound, fourth, cap)
        if step == 0.0:
            return s
        if s + step >= h:
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step
        _, v, a, j = slide(c, w, waves, x_r, v_r, g, r, s)
