"""The closed-form flow of the oscillator: what every exact solution is made of.

The equation is x" + c x' + w x = g(s) with c = b/m and w = k_x/m. A short stretch is summed as
its power series until nothing is left to add; a long one is doubled up from a short one. No
damping regime is special: no formula divides by w, by c, or by a difference of roots.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled

SHORT = 0.5
"""A stretch is short when its length times the fastest rate is below this."""

TERMS = 17
"""Terms that exhaust double precision on a short stretch: 0.5^17·17/19! is below 1e-20."""

INVERSE_FACTORIAL = tuple(1.0 / math.factorial(n) for n in range(TERMS + 4))


@compiled
def few(rate):
    """Give the number of series terms that exhaust double precision at rate·length `rate`."""
    if rate > 0.0625:
        return TERMS
    return 10 if rate > 0.004 else 7


@compiled
def flow(c, w, s):
    """Give the response to a unit kick, its slope, and its first two integrals.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²], at least 0.
    s : float
        Length of the stretch [s], at least 0.

    Returns
    -------
    y, y_d : float
        Solution of y" + c y' + w y = 0, y(0) = 0, y'(0) = 1 [s], and its slope [-].
    Y, YY : float
        Integral of y from 0 to s [s²], the response to a unit step, and the integral of Y
        [s³], the response to a unit ramp.

    Notes
    -----
    From x_0, v_0 under g = g_0 + r s: x = x_0 + v_0 y + (g_0 - w x_0) Y + r YY.
    """
    rate = (c + math.sqrt(w)) * s
    doublings = 0
    h = s
    while rate > SHORT:
        rate *= 0.5
        h *= 0.5
        doublings += 1
    ch = c * h
    wh = w * h * h
    q_before = 0.0
    q = 1.0
    second = 0.0
    third = 0.0
    for n in range(1, few(rate)):
        second += q * INVERSE_FACTORIAL[n + 2]
        third += q * INVERSE_FACTORIAL[n + 3]
        q, q_before = -(ch * q + wh * q_before), q
    # The equation, integrated, gives the rest without cancellation on a short stretch.
    YY = second * h * h * h
    Y = h * h * (0.5 - ch * second - wh * third)
    y = h - c * Y - w * YY
    y_d = 1.0 - c * y - w * Y
    for _ in range(doublings):
        # Not 1 - w Y, which is the same but loses what is left of a motion that dies away.
        keep = y_d + c * y
        YY = YY * (1.0 + keep) + Y * (h + y)
        Y, y, y_d = Y * (1.0 + keep) + y * y, y * (keep + y_d), y_d * y_d - w * y * y
        h *= 2.0
    return y, y_d, Y, YY


@compiled
def wave(c, w, omega, s):
    """Give the response from rest to sin(omega s)/omega, beside `flow` and the wave itself.

    Parameters
    ----------
    c, w, s : float
        As in `flow`.
    omega : float
        Angular frequency of the wave [rad/s], at least 0.

    Returns
    -------
    y, y_d, Y : float
        As in `flow`.
    R, P, P_d : float
        Response from rest to sin(omega s)/omega [s³]; its slope, which is the response to
        cos(omega s) [s²]; and the slope of that [s].
    sine, cosine : float
        sin(omega s)/omega [s] and cos(omega s) [-].

    Notes
    -----
    Resonance without damping is no special case.
    """
    rate = (c + math.sqrt(w) + omega) * s
    doublings = 0
    h = s
    while rate > SHORT:
        rate *= 0.5
        h *= 0.5
        doublings += 1
    ch = c * h
    wh = w * h * h
    oh = omega * omega * h * h
    kick_before, kick = 0.0, 1.0
    answer_before, answer = 0.0, 1.0
    push = 1.0
    even = True
    y2 = 0.0
    y3 = 0.0
    R = 0.0
    P = 0.0
    for n in range(1, few(rate)):
        y2 += kick * INVERSE_FACTORIAL[n + 2]
        y3 += kick * INVERSE_FACTORIAL[n + 3]
        R += answer * INVERSE_FACTORIAL[n + 2]
        P += answer * INVERSE_FACTORIAL[n + 1]
        kick, kick_before = -(ch * kick + wh * kick_before), kick
        even = not even
        if even:
            push *= -oh
            answer, answer_before = push - (ch * answer + wh * answer_before), answer
        else:
            answer, answer_before = -(ch * answer + wh * answer_before), answer
    YY = y2 * h * h * h
    Y = h * h * (0.5 - ch * y2 - wh * y3)
    y = h - c * Y - w * YY
    y_d = 1.0 - c * y - w * Y
    R *= h * h * h
    P *= h * h
    sine = math.sin(omega * h) / omega if omega > 0.0 else h
    cosine = math.cos(omega * h)
    P_d = sine - c * P - w * R
    for _ in range(doublings):
        keep = y_d + c * y
        back = omega * omega * sine
        R, P, P_d = (
            (keep + cosine) * R + (y + sine) * P,
            (keep + cosine) * P + y * P_d - back * R,
            (y_d + cosine) * P_d - (w * y + back) * P,
        )
        Y, y, y_d = Y * (1.0 + keep) + y * y, y * (keep + y_d), y_d * y_d - w * y * y
        cosine, sine = 1.0 - 2.0 * (omega * sine) ** 2, 2.0 * sine * cosine
    return y, y_d, Y, R, P, P_d, sine, cosine
