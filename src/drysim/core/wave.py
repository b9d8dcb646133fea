"""The response of the oscillator to a sine, from rest: what sines add to the flow."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.flow import INVERSE_FACTORIAL, SHORT, few


@compiled
def wave(c, w, omega, s, y, y_d):
    """Give the response from rest to sin(omega s)/omega, and the wave itself.

    Parameters
    ----------
    c, w, s : float
        As in `flow`.
    omega : float
        Angular frequency of the wave [rad/s], at least 0.
    y, y_d : float
        What `flow` gives for the stretch.

    Returns
    -------
    R, P, P_d : float
        Response from rest to sin(omega s)/omega [s³]; its slope, which is the response to
        cos(omega s) [s²]; and the slope of that [s].
    sine, cosine : float
        sin(omega s)/omega [s] and cos(omega s) [-].

    Notes
    -----
    Resonance without damping is no special case.
    """
    if (c + math.sqrt(w) + omega) * s <= SHORT:
        return short_wave(c, w, omega, s)
    # The response to exp(mu s) is a divided difference of exponentials over mu and both roots.
    mu = complex(0.0, omega)
    root, other, decay = roots(c, w, y, y_d)
    turn = complex(math.cos(omega * s), math.sin(omega * s))
    near = confluent(mu - root, decay, turn, s)
    to_wave = (near - y) / (mu - other)
    rate = (turn + root * near - y_d) / (mu - other)
    return to_wave.imag / omega, to_wave.real, rate.real, turn.imag / omega, turn.real


@compiled
def roots(c, w, y, y_d):
    """Give the slower root of the oscillator [1/s], the other, and exp(root s)."""
    square = w - 0.25 * c * c
    if square > 0.0:
        omega_d = math.sqrt(square)
        root = complex(-0.5 * c, omega_d)
        return root, complex(-0.5 * c, -omega_d), complex(y_d + 0.5 * c * y, omega_d * y)
    kappa = math.sqrt(-square)
    fast = 0.5 * c + kappa
    slow = w / fast if fast > 0.0 else 0.0
    return complex(-slow, 0.0), complex(-fast, 0.0), complex(y_d + fast * y, 0.0)


@compiled
def confluent(difference, decay, turn, s):
    """Give (exp(mu s) - exp(root s))/(mu - root), also where mu and root meet.

    Parameters
    ----------
    difference, decay, turn : complex
        mu - root [1/s], exp(root s) and exp(mu s).
    s : float
        Time [s].
    """
    z = difference * s
    if abs(z) > 0.25:
        return (turn - decay) / difference
    total = complex(0.0, 0.0)
    term = complex(1.0, 0.0)
    for n in range(2, 15):
        total += term
        term *= z / n
    return decay * s * total


@compiled
def short_wave(c, w, omega, s):
    """Give what `wave` gives for a stretch that is short for wave and oscillator: a series."""
    rate = (c + math.sqrt(w) + omega) * s
    cs = c * s
    ws = w * s * s
    os = omega * omega * s * s
    answer_before, answer = 0.0, 1.0
    push = 1.0
    even = True
    R = 0.0
    P = 0.0
    for n in range(1, few(rate)):
        R += answer * INVERSE_FACTORIAL[n + 2]
        P += answer * INVERSE_FACTORIAL[n + 1]
        even = not even
        if even:
            push *= -os
            answer, answer_before = push - (cs * answer + ws * answer_before), answer
        else:
            answer, answer_before = -(cs * answer + ws * answer_before), answer
    R *= s * s * s
    P *= s * s
    sine = math.sin(omega * s) / omega if omega > 0.0 else s
    cosine = math.cos(omega * s)
    return R, P, sine - c * P - w * R, sine, cosine
