"""Where a stretch of sliding under linearly changing force comes to a stop, rigorously.

Within such a stretch the relative acceleration obeys the free equation, so its zeros - the
extrema of the velocity - are known in closed form. Between neighbouring extrema the velocity
is monotone.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.flow import flow

NEVER = math.inf

NEWTON_CAP = 100
"""Newton needs about 3 rounds; a halved bracket is down to one float after 60."""

RESOLUTION = 4e-16
"""Relative step below which a root is as sharp as double precision makes it."""


@compiled
def spacing_of_extrema(c, w):
    """Give the distance of neighbouring extrema of v_r [s]: π/ω_d, or infinity at ξ >= 1."""
    square = w - 0.25 * c * c
    return math.pi / math.sqrt(square) if square > 0.0 else NEVER


@compiled
def first_extremum(c, w, a, j):
    """Give the first time after 0 at which the relative acceleration vanishes.

    Parameters
    ----------
    c, w : float
        As in `flow`.
    a, j : float
        Relative acceleration [m/s²] and jerk [m/s³] at time 0.

    Returns
    -------
    float
        Time [s], above 0; infinity when there is none.
    """
    square = w - 0.25 * c * c
    lean = j + 0.5 * c * a
    if square > 0.0:
        omega_d = math.sqrt(square)
        # a cos + (lean/omega_d) sin = 0; both arguments turn together, so angles are mod π.
        angle = math.atan2(-a * omega_d, lean) if a != 0.0 else math.pi
        return (angle if angle > 0.0 else angle + math.pi) / omega_d
    if a == 0.0 or a * lean >= 0.0:
        return NEVER
    kappa = math.sqrt(-square)
    reach = -a * kappa / lean
    if reach >= 1.0:
        return NEVER
    return math.atanh(reach) / kappa if reach > 0.0 else -a / lean


@compiled
def velocity(c, w, v, a, r, s):
    """Give the velocity and acceleration at time s from those at time 0.

    Written so that a motion that dies away keeps its sign: where r = 0 nothing is subtracted
    from what is left of it.
    """
    y, y_d, Y, _ = flow(c, w, s)
    return v * y_d + (a + c * v) * y + r * Y, a * y_d + (r - w * v) * y


@compiled
def polish(c, w, v, a, r, lo, hi):
    """Give the zero of a velocity that falls once through it from lo to hi: guarded Newton."""
    s = hi
    if lo == 0.0 and a < 0.0:
        # Where the parabola through the start meets zero.
        square = a * a - 2.0 * v * (r - c * a - w * v)
        if square >= 0.0:
            s = min(2.0 * v / (-a + math.sqrt(square)), hi)
    for _ in range(NEWTON_CAP):
        value, slope = velocity(c, w, v, a, r, s)
        if value > 0.0:
            lo = s
        elif value < 0.0:
            hi = s
        else:
            return s
        step = -value / slope if slope < 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s += step
        if not lo < s < hi:
            s = 0.5 * (lo + hi)
            if s <= lo or s >= hi:
                return hi
    return s


@inlined
def never_stops(c, w, v, a, r):
    """Return whether a velocity that is not below zero provably stays so under this force.

    Parameters as in `locate_stop`.

    Notes
    -----
    The velocity is an oscillator of its own under the steady force r, whose energy
    a² + w v² - 2 r v, counted from rest, only falls; it has to be at least 0 where v = 0.
    At and beyond critical damping v = A exp(-s_1 t) + B exp(-s_2 t) with s_2 >= s_1 has no zero
    if a + s_2 v >= 0, and a force r >= 0 only adds to it.
    """
    if v < 0.0:
        return False
    if a * a < v * (2.0 * r - w * v):
        return True
    square = 0.25 * c * c - w
    return square >= 0.0 and r >= 0.0 and a + (0.5 * c + math.sqrt(square)) * v >= 0.0


@compiled
def locate_stop(c, w, v, a, r, h):
    """Give the first time in (0, h] at which a velocity above zero is zero again.

    Parameters
    ----------
    c, w : float
        As in `flow`.
    v, a, r : float
        Velocity in the direction of sliding [m/s], at least 0, and its rate [m/s²] at time 0;
        rate of the force per mass [m/s³].
    h : float
        Length of the stretch [s].

    Returns
    -------
    float
        Time [s], or infinity when the velocity stays above zero.

    Notes
    -----
    No stop is missed: every falling stretch between extrema is looked at in turn. A velocity
    that just touches zero has stopped. One that decays for so long that it underflows has not.
    """
    if (v > 0.0 or a > 0.0) and never_stops(c, w, v, a, r):
        return NEVER
    j = r - c * a - w * v
    end = first_extremum(c, w, a, j)
    gap = spacing_of_extrema(c, w)
    begin = 0.0
    if a > 0.0 or (a == 0.0 and j > 0.0):
        begin = end
        end = begin + gap
    while begin < h:
        until = min(end, h)
        if velocity(c, w, v, a, r, until)[0] <= 0.0:
            return polish(c, w, v, a, r, begin, until)
        begin = end + gap
        end = begin + gap
    return NEVER
