"""Integrals over a long stretch of a holding contact under waves: sums of exponentials.

Not for short stretches: there the parts of the motion all but cancel, and so would the sums.
"""

from __future__ import annotations

import cmath
import math

from drysim.core.compiled import compiled, inlined
from drysim.core.fade import CALM
from drysim.core.flow import SHORT
from drysim.core.waves import ACROSS, ALONG, OMEGA, STEADY, STRIDE, THETA, A

TERMS = 16
"""Terms that exhaust double precision where z·length is below `SHORT`."""


@compiled
def settles(c, w, waves):
    """Tell whether the motion is one that fades while it swings, and steady responses."""
    steady = w > 0.0 and w - 0.25 * c * c >= CALM * w
    for i in range(waves.base):
        at = STRIDE * i
        steady = steady and (waves.values[at + STEADY] > 0.0 or waves.values[at + A] == 0.0)
    return steady


@inlined
def part(c, w, waves, lag, rate, i, s):
    """Give one part of the motion at time s: the waves in turn, then what fades.

    Parameters
    ----------
    lag, rate : float
        What x_r and v_r lacked of the steady response at the start of the stretch [m, m/s].

    Returns
    -------
    root, x, u_dd : complex
        The part of x_r is the real part of x exp(root·time), that of ü likewise.
    """
    if i == waves.base:
        omega_d = math.sqrt(w - 0.25 * c * c)
        root = complex(-0.5 * c, omega_d)
        x = complex(lag, -(rate + 0.5 * c * lag) / omega_d) * cmath.exp(root * s)
        return root, x, complex(0.0, 0.0)
    at = STRIDE * i
    omega = waves.values[at + OMEGA]
    angle = omega * s + waves.values[at + THETA]
    turn = complex(math.cos(angle), math.sin(angle))
    u_dd = complex(0.0, -waves.values[at + A]) * turn
    x = complex(0.0, 0.0)
    if waves.values[at + A] != 0.0:
        x = complex(waves.values[at + ACROSS], -waves.values[at + ALONG]) * turn
    return complex(0.0, omega), x, u_dd


@inlined
def over(z, turned, length):
    """Give the integral of exp(z s) from 0 to a length, where it is `turned` at the end."""
    q = z * length
    if abs(q) > SHORT:
        return (turned - 1.0) / z
    total = complex(0.0, 0.0)
    for n in range(TERMS, 0, -1):
        total = (1.0 + total) * q / (n + 1)
    return length * (1.0 + total)


@compiled
def integrate_long(c, w, waves, middle, lag, rate, lo, hi):
    """Integrate from lo to hi.

    Parameters
    ----------
    c, w, waves
        Of the holding contact, anchored at the start of the stretch, as `settles` wants them.
    middle : float
        Where the mass would rest without waves [m].
    lag, rate
        As in `part`.
    lo, hi : float
        Limits, counted from the start [s].

    Returns
    -------
    x2, v2, x_dd2, power : float
        As in `Totals`.
    """
    length = hi - lo
    x2, v2, x_dd2, power = middle * middle * length, 0.0, 0.0, 0.0
    for i in range(waves.base + 1):
        root, x, u_dd = part(c, w, waves, lag, rate, i, lo)
        turn = cmath.exp(root * length)
        v, x_dd = root * x, -(w + c * root) * x
        x2 += 2.0 * middle * (x * over(root, turn, length)).real
        for k in range(i + 1):
            twice, other, x_k, u_k, turn_k = 1.0, root, x, u_dd, turn
            if k < i:
                other, x_k, u_k = part(c, w, waves, lag, rate, k, lo)
                twice, turn_k = 2.0, cmath.exp(other * length)
            v_k, x_dd_k = other * x_k, -(w + c * other) * x_k
            both = 0.5 * over(root + other, turn * turn_k, length)
            against = 0.5 * over(root + other.conjugate(), turn * turn_k.conjugate(), length)
            x2 += twice * (x * x_k * both + x * x_k.conjugate() * against).real
            v2 += twice * (v * v_k * both + v * v_k.conjugate() * against).real
            x_dd2 += twice * (x_dd * x_dd_k * both + x_dd * x_dd_k.conjugate() * against).real
            power += (u_dd * (v_k * both + v_k.conjugate() * against)).real
            if k < i:
                power += (v * (u_k * both + u_k.conjugate() * against)).real
    return x2, v2, x_dd2, power
