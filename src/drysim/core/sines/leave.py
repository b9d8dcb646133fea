"""When a stretch of sticking under waves ends, rigorously.

The next zero is approached from below by steps that a bound on the curvature proves safe, so
none is skipped and a near miss is passed at its own distance.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import ROUNDING
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.slide import margin
from drysim.core.waves import COSINE, OMEGA, SINE, STRIDE, THETA, A

TOUCH = 1e-6
"""A zero margin this near to its minimum, in radians of the fastest wave, only touches."""

WINDOW = 32.0
"""Radians of the fastest wave within which either side is looked at first."""

FAINT = 1e-140
"""Below this, squares lose digits to the end of double precision."""


@compiled
def parabola(value, rate, bend):
    """Give the largest h up to which value + rate h - bend h²/2 stays above zero."""
    root = math.sqrt(rate * rate + 2.0 * bend * value)
    if root < FAINT and value > 0.0:
        root = math.hypot(rate, math.sqrt(2.0 * bend) * math.sqrt(value))
    if rate <= 0.0:
        return 2.0 * value / (root - rate) if root > rate else NEVER
    return (rate + root) / bend if bend > 0.0 else NEVER


@compiled
def first_step(rate, bend, bend_bound, third_bound):
    """Give a step that provably leaves zero upwards; 0 or less where the function falls."""
    by_rate = rate / bend_bound if rate > 0.0 else 0.0
    by_bend = 0.0
    if rate >= 0.0 and bend > 0.0:
        by_bend = 1.5 * bend / third_bound if third_bound > 0.0 else NEVER
    return max(by_rate, by_bend)


@inlined
def break_away(plant, law, waves, x_r, u_0, rise, fall, h):
    """Return when within h [s] a stuck mass breaks away, or infinity, and which way it slips.

    Parameters
    ----------
    u_0 : float
        Part of ü that is not waves at the start [m/s²].
    rise, fall : float
        Its rate as the side sees it where F_L breaks the contact by rising and by falling
        [m/s³].

    Notes
    -----
    Both sides are looked at window by window: one that never breaks away must not be followed
    to the end each time that the other does.
    """
    fastest = 0.0
    if not is_one_sine(waves, u_0, rise) or fall != 0.0:
        for i in range(waves.size):
            fastest = max(fastest, waves.values[STRIDE * i + OMEGA])
    begin, until = 0.0, min(WINDOW / fastest, h) if fastest > 0.0 else h
    while True:
        up = leave_stick(plant, law, waves, x_r, u_0, rise, 1, begin, until)
        down = leave_stick(plant, law, waves, x_r, u_0, fall, -1, begin, min(up, until))
        if up < NEVER or down < NEVER or until >= h:
            return (down, 1) if down < up else (up, -1)
        begin, until = until, min(3.0 * until, h)


@inlined
def is_one_sine(waves, u_0, slope):
    """Tell whether one sine alone moves the base."""
    return waves.size == 1 and waves.base == 1 and u_0 == 0.0 and slope == 0.0


@inlined
def leave_stick(plant, law, waves, x_r, u_0, slope, side, begin, h):
    """Return the first time in [begin, h] when |F_L| exceeds F_fs on one side, or infinity.

    A margin that only touches zero does not break away: equality sticks.
    """
    if begin == 0.0 and is_one_sine(waves, u_0, slope):
        return leave_one_sine(plant, law, waves, x_r, side, h)
    bend = 0.0
    third = 0.0
    fastest = 0.0
    for i in range(waves.size):
        A_i = abs(waves.values[STRIDE * i + A])
        force = plant.m * A_i if i < waves.base else law.F_fs * law.variation
        omega = waves.values[STRIDE * i + OMEGA]
        bend += force * omega**2
        third += force * omega**3
        fastest = max(fastest, omega)
    s = begin
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


@inlined
def leave_one_sine(plant, law, waves, x_r, side, h):
    """Give what `leave_stick` gives where one sine moves the base: its inverse."""
    values = waves.values
    F_k, force = plant.k_x * x_r, side * plant.m * values[A]
    level = law.F_fs + ROUNDING * (law.F_fs + abs(F_k)) - side * F_k
    if force * values[SINE] > level:
        return 0.0
    if abs(force) <= level:
        return NEVER
    theta = values[THETA] if force > 0.0 else values[THETA] + math.pi
    turn = (math.asin(level / abs(force)) - theta) % (2.0 * math.pi)
    # Rising, and beyond the limit by less than the rounding of an angle.
    if force * values[COSINE] > 0.0 and turn > math.pi:
        turn = 0.0
    s = turn / values[OMEGA]
    return s if s <= h else NEVER
