"""Largest absolute acceleration of the mass in a segment over samples.

Problem
    x_dd jumps where friction changes sign or the mass sticks, and has maxima between the points
    of any grid. The peak is the supremum over a window: both sides of every jump count.

Method
    Within a segment x_dd = ü + e, where ü is linear in time and the relative acceleration e is
    a free vibration, e" + c e' + w e = 0. |x_dd| exceeds the larger of its end values by at
    most length²/8 times a bound of |e"|, which follows from the energy of e". Only segments
    that may exceed the peak so far are searched. The zeros of e" are known in closed form, and
    between two of them x_dd' is monotone, so that each of its roots is bracketed and no maximum
    is missed.

Rigid impacts are not included: they have a momentum and no acceleration.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compile import compiled, inlined
from drysim.core.oscillator import flow
from drysim.core.roots import MAX_BISECTIONS, safeguarded_newton

MAX_ENDS_SEARCHED = 4
"""Half cycles searched at both ends of a segment. Over one of more cycles the maxima of a decay
plus a ramp are convex in time, so that the largest is the first or the last."""


class Decay(NamedTuple):
    """x_dd in a segment: u_0 + slope s + e(s), with e" + c e' + w e = 0.

    Attributes
    ----------
    c, w : float
        [1/s, 1/s²].
    u_0, slope : float
        ü at the start [m/s²] and its rate [m/s³].
    e, e_1 : float
        e [m/s²] and e' [m/s³] at the start.
    """

    c: float
    w: float
    u_0: float
    slope: float
    e: float
    e_1: float


@inlined
def bend(decay):
    """Return a bound of |e"| in a segment [m/s⁴].

    y = e" is a free vibration itself: its energy, w y² + y'², never grows.
    """
    c, w, _, _, e, e_1 = decay
    e_2 = -c * e_1 - w * e
    e_3 = -c * e_2 - w * e_1
    return math.sqrt(e_2 * e_2 + e_3 * e_3 / w) if w > 0.0 else abs(e_2)


@compiled
def peak_of_segment(decay, highest, length, peak):
    """Return the larger of `peak` and |x_dd| in a segment; `highest` is that at its ends."""
    if highest + 0.125 * length * length * bend(decay) <= peak:
        return peak
    return max(peak, interior_peak(decay, length))


@compiled
def interior_peak(decay, length):
    """Return the largest |x_dd| where its rate vanishes in a segment [m/s²]."""
    c, w, _, _, e, e_1 = decay
    e_2 = -c * e_1 - w * e
    e_3 = -c * e_2 - w * e_1
    # e" = exp(-c s/2) (e_2 C(s) + B S(s)), with C and S the circular or hyperbolic functions.
    B, square = e_3 + 0.5 * c * e_2, w - 0.25 * c * c
    first, period, count = 0.0, 0.0, 0
    if square > 0.0 and (e_2 != 0.0 or e_3 != 0.0):
        omega = math.sqrt(square)
        period = math.pi / omega
        first = math.atan2(-omega * e_2, B) % math.pi / omega
        count = int(max(length - first, -period) / period) + 1
    elif B != 0.0:
        kappa = math.sqrt(max(-square, 0.0))
        share = -kappa * e_2 / B
        if kappa == 0.0:
            first = -e_2 / B
        elif abs(share) < 1.0:
            first = math.atanh(share) / kappa
        count = 1
    peak, low, before = 0.0, 0.0, acceleration_rate(decay, 0.0)[0]
    for i in range(count + 1):
        if MAX_ENDS_SEARCHED <= i < count - MAX_ENDS_SEARCHED:
            continue
        high = first + i * period if i < count else length
        if not low < high <= length:
            continue
        behind = acceleration_rate(decay, high)[0]
        if before * behind < 0.0:
            s = zero_of_rate(decay, low, high, before)
            y, y_d, _, _ = flow(c, w, s)
            x_dd = decay.u_0 + decay.slope * s + e * (y_d + c * y) + e_1 * y
            peak = max(peak, abs(x_dd))
        low, before = high, behind
    return peak


@compiled
def acceleration_rate(decay, s):
    """Return the first two derivatives of x_dd at time s of a segment."""
    c, w, _, slope, e, e_1 = decay
    y, y_d, _, _ = flow(c, w, s)
    now, rate = e * (y_d + c * y) + e_1 * y, e_1 * y_d - w * e * y
    return slope + rate, -c * rate - w * now


@compiled
def zero_of_rate(decay, low, high, before):
    """Return where the rate of x_dd vanishes, which changes its sign once from `before`."""
    side = 1.0 if before > 0.0 else -1.0
    s = 0.5 * (low + high)
    for _ in range(MAX_BISECTIONS):
        rate, curvature = acceleration_rate(decay, s)
        low, high, s, done = safeguarded_newton(low, high, s, side * rate, side * curvature)
        if done:
            break
    return s
