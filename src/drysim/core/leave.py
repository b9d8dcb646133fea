"""When a stretch of sliding or sticking under waves ends, rigorously.

The next zero is approached from below by steps that a bound on the curvature proves safe, so
none is skipped; near a simple zero the steps converge like Newton's, and a near miss is
passed at its own distance.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.slide import margin, slide
from drysim.core.stop import NEVER, RESOLUTION

TOUCH = 1e-6
"""A zero margin this near to its minimum, in radians of the fastest wave, only touches."""


@compiled
def parabola(value, rate, bend):
    """Give the largest h up to which value + rate h - bend h²/2 stays above zero."""
    root = math.sqrt(rate * rate + 2.0 * bend * value)
    if rate <= 0.0:
        return 2.0 * value / (root - rate) if root > rate else NEVER
    return (rate + root) / bend if bend > 0.0 else NEVER


@compiled
def safe_step(value, rate, bend, growth, cap):
    """Give a step within which a function provably stays above zero.

    Parameters
    ----------
    value, rate : float
        Of the function now; value above 0.
    bend, growth : float
        Its second rate is at most bend + growth·h in magnitude after any h up to cap.
    cap : float
        Longest step.
    """
    reach = min(parabola(value, rate, bend), cap)
    if growth == 0.0 or reach == NEVER:
        return reach
    return min(parabola(value, rate, bend + growth * reach / 3.0), cap)


@compiled
def first_step(rate, bend, bend_bound, third_bound):
    """Give a step that provably leaves zero upwards; 0 or less where the function falls."""
    by_rate = rate / bend_bound if rate > 0.0 else 0.0
    by_bend = 0.0
    if rate >= 0.0 and bend > 0.0:
        by_bend = 1.5 * bend / third_bound if third_bound > 0.0 else NEVER
    return max(by_rate, by_bend)


@compiled
def leave_slip(c, w, waves, x_r, v_r, a, j, g, r, d, h):
    """Give the first time in (0, h] at which sliding in direction d stops, or infinity.

    The jerk and its rate obey the oscillator's equation driven by ü", so
    |jerk|(s) <= sqrt(jerk² + w a²) + s·max|ü"|: the bound that makes every step safe.
    """
    growth = 0.0
    fastest = 0.0
    for i in range(len(waves.A)):
        growth += abs(waves.A[i]) * waves.omega[i] ** 2
        fastest = max(fastest, waves.omega[i])
    cap = 1.0 / fastest if fastest > 0.0 else NEVER
    s = 0.0
    v_r_0 = v_r
    v, a, j = d * v_r, d * a, d * j
    while True:
        bend = math.sqrt(j * j + w * a * a)
        if v > 0.0:
            step = safe_step(v, a, bend, growth, cap)
        else:
            bound = bend + growth * cap if growth > 0.0 else bend
            if bound == 0.0:
                return NEVER
            step = min(first_step(a, j, bound, (c + math.sqrt(w)) * bound + growth), cap)
            if step <= 0.0:
                return s
        if s + step >= h:
            # The end of the stretch lies within the safe step.
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step
        _, v, a, j = slide(c, w, waves, x_r, v_r_0, g, r, s)
        v, a, j = d * v, d * a, d * j
        if v <= 0.0:
            return s


@compiled
def leave_stick(plant, law, waves, x_r, u_0, slope, side, h):
    """Give the first time in [0, h] at which |F_L| exceeds F_fs on one side, or infinity.

    A margin that only touches zero does not break away: equality sticks.
    """
    bend = 0.0
    third = 0.0
    fastest = 0.0
    for i in range(len(waves.A)):
        force = plant.m * abs(waves.A[i]) if i < waves.base else law.F_fs * law.variation
        omega = waves.omega[i]
        bend += force * omega**2
        third += force * omega**3
        fastest = max(fastest, omega)
    s = 0.0
    while True:
        G, G_d, G_dd = margin(plant, law, waves, x_r, u_0, slope, side, s)
        if G < 0.0:
            return s
        if G > 0.0:
            step = parabola(G, G_d, bend)
        elif bend == 0.0:
            step = NEVER if G_d >= 0.0 else 0.0
        else:
            step = first_step(G_d, G_dd, bend, third)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            if G_dd <= 0.0 or -G_d * fastest > TOUCH * G_dd:
                return s
            step = -G_d / G_dd
            if margin(plant, law, waves, x_r, u_0, slope, side, s + step)[0] < 0.0:
                return s
            step += first_step(0.0, G_dd, bend, third)
        s += step
