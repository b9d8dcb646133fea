"""When a stretch of sliding under waves ceases, rigorously.

The zero of v_r is approached from below by steps that a bound on its third rate proves safe, so
none is skipped and a near miss is passed at its own distance. Where the bound proves that v_r
only falls until it is below zero, Newton's method has nothing to miss.
"""

from __future__ import annotations

import math

from drysim.core.compiled import inlined
from drysim.core.samples.stop import NEVER, RESOLUTION, never_stops
from drysim.core.sines.slide import slide_and_snap
from drysim.core.waves import OMEGA, SINE, STRIDE, A

FALLS = 3.0
"""A slope this many times what it may lose up to 1.5 times the zero of its parabola leads below
zero on the way."""

NEWTON_CAP = 20
"""The cubic errs in the fourth order: 2 rounds do, as none is allowed to turn back."""

REACH = 2.0
"""Radians of the fastest wave that are tried at once: the bound never proves more."""

SMALL = 0.01
"""Share of the longest step below which a step is tried without the jerk, too."""

HALVINGS = 60
"""Of the longest step at most: where a slow wave drags the mass along, the bound may leave a
millionth of it."""


@inlined
def to_zero(v, a, j):
    """Give the smaller time at which v + a h + j h²/2, falling, is zero; infinity for none."""
    square = a * a - 2.0 * v * j
    return 2.0 * v / (math.sqrt(square) - a) if square > 0.0 else NEVER


@inlined
def to_zero_of_cubic(v, a, j, k):
    """Give what `to_zero` does with k h³/6 besides, but for what a round of Newton's leaves."""
    h = to_zero(v, a, j)
    return h - h * h * h * k / (6.0 * a + (6.0 * j + 3.0 * k * h) * h)


@inlined
def is_sharp(h, a, fourth, s):
    """Tell whether the zero at time s is, as the cubic errs after h by fourth h⁴/24 at most."""
    return fourth * h * h * h * h <= -24.0 * a * RESOLUTION * s or h == 0.0


@inlined
def falls_surely(v, a, j, snap, growth):
    """Tell whether a velocity only falls until it is below zero, at 1.5 times its parabola's.

    Parameters
    ----------
    v, a, j, snap, growth : float
        As in `safe_slip`; the velocity may be below zero.
    """
    if not a < 0.0 < v:
        return False
    far = 1.5 * to_zero(v, a, j)
    return -a >= FALLS * (max(j, 0.0) + (0.5 * snap + growth * far / 6.0) * far) * far


@inlined
def above_zero(v, a, bend):
    """Give the largest h up to which v + a h - bend h²/2, not below zero, stays so."""
    square = a * a + 2.0 * bend * v
    if square < 0.0:
        return NEVER
    root = math.sqrt(square)
    if a > 0.0:
        return (a + root) / bend if bend > 0.0 else NEVER
    if root > a:
        return 2.0 * v / (root - a)
    return 0.0 if bend > 0.0 else NEVER


@inlined
def safe_slip(v, a, j, snap, growth, cap):
    """Give a step within which a velocity provably stays above zero.

    Parameters
    ----------
    v, a, j : float
        Velocity, at least 0, acceleration and jerk now.
    snap, growth : float
        The rate of the jerk is at most snap + growth·h in magnitude after any h.
    cap : float
        Longest step that is tried.

    Notes
    -----
    v stays above P = v + a h + j h²/2 - snap h³/6 - growth h⁴/24. Where the jerk is not above
    zero P bends downwards: a chord from before its zero to behind it ends before it.
    """
    third, twelfth = snap * (1.0 / 3.0), growth * (1.0 / 12.0)
    if j > 0.0:
        # Up to here P is above v + a h.
        divisor = third + math.sqrt(third * third + 4.0 * twelfth * j)
        rises = min(2.0 * j / divisor, cap) if divisor > 0.0 else cap
        return rises if a >= 0.0 else min(rises, -v / a)
    behind = min(above_zero(v, a, -j), cap)
    low = below_slip(v, a, j, third, twelfth, behind)
    if low > 0.0:
        return behind
    for _ in range(HALVINGS):
        before = 0.5 * behind
        high = below_slip(v, a, j, third, twelfth, before)
        if high > 0.0:
            return before + (behind - before) * high / (high - min(low, 0.0))
        behind, low = before, high
    return min(behind, above_zero(v, a, (third + twelfth * behind) * behind - j))


@inlined
def below_slip(v, a, j, third, twelfth, h):
    """Give what a velocity is above after a time h, see `safe_slip`."""
    return v + h * (a + 0.5 * h * (j - h * (third + twelfth * h)))


@inlined
def leave_slip(c, w, waves, x_r, v_r, a, j, g, r, d, h):
    """Give the first time in (0, h] at which sliding in direction d stops, and where it does.

    The snap and its rate obey the oscillator's equation driven by the third rate of ü, so
    |snap|(s) <= sqrt(snap² + w jerk²) + s·max|third rate|: the bound that makes every step
    safe. The time is infinite where nothing stops.
    """
    moves = d * v_r > 0.0 or d * a > 0.0
    if waves.size == 0 and moves and never_stops(c, w, d * v_r, d * a, d * r):
        return NEVER, x_r
    growth = 0.0
    fastest = 0.0
    k = -c * j - w * a
    for i in range(waves.size):
        at = STRIDE * i
        omega = waves.values[at + OMEGA]
        bend = waves.values[at + A] * omega * omega
        growth += abs(bend) * omega
        k += bend * waves.values[at + SINE]
        fastest = max(fastest, omega)
    cap = min(REACH / fastest, h) if fastest > 0.0 else h
    s, x = 0.0, x_r
    v, a, j, k = d * v_r, d * a, d * j, d * k
    while True:
        snap = math.sqrt(k * k + w * j * j)
        if falls_surely(v, a, j, snap, growth):
            s, x = sharpen(c, w, waves, x_r, v_r, g, r, d, s, x, v, a, j, k, growth)
            return (s, x) if s < h else (NEVER, x)
        step = safe_slip(v, a, j, snap, growth, cap)
        if j > 0.0 and step < SMALL * cap:
            # A jerk that is next to nothing proves less than one that is left out: what is
            # strongly damped would take a million steps.
            step = max(step, safe_slip(v, a, 0.0, snap, growth, cap))
        if s + step >= h:
            # The end of the stretch lies within the safe step.
            return NEVER, x
        if step <= RESOLUTION * s:
            return s, x
        s += step
        x, v, a, j, k = slide_and_snap(c, w, waves, x_r, v_r, g, r, s)
        v, a, j, k = d * v, d * a, d * j, d * k
        if v <= 0.0:
            return s, x


@inlined
def sharpen(c, w, waves, x_r, v_r, g, r, d, s, x, v, a, j, k, growth):
    """Give the zero of a velocity that only falls, and x_r there, from what is at time s."""
    for _ in range(NEWTON_CAP):
        h = to_zero_of_cubic(v, a, j, k)
        snap = math.sqrt(k * k + w * j * j) + growth * abs(h)
        fourth = (c + math.sqrt(w)) * snap + growth
        s += h
        if is_sharp(h, a, fourth, s):
            return s, x + d * h * (v + h * (0.5 * a + h * (j / 6.0 + h * k / 24.0)))
        x, v, a, j, k = slide_and_snap(c, w, waves, x_r, v_r, g, r, s)
        v, a, j, k = d * v, d * a, d * j, d * k
    return s, x
