"""Closed-form flow of the linear oscillator, and step maps and power series made of it.

Problem
    Between events the relative motion obeys x" + c x' + w x = g(s) with constant c = b/m and
    w = k_x/m. Its solution is needed to rounding, for segments of any length and for any
    damping: c = 0, critical, far above critical, and w = 0.

Method
    - `flow` returns the impulse response, its slope and its first two integrals: the responses
      to a unit impulse, step and ramp. A short segment is summed as a power series; a long one
      is halved until it is short and rebuilt by doubling formulas. No formula divides by w, by
      c or by a difference of characteristic roots, so no damping regime is a special case.
      `free_response` omits the ramp and uses sine and cosine where these lose no digits.
    - `sine_response` adds the response to a sine as a divided difference of exp over the
      frequency and both characteristic roots, which is regular at resonance.
    - `linear_recursion` solves the oscillator without dry friction on samples.
    - `velocity_series` is the Taylor series of v in a segment with linear forcing. Most steps
      with an event are much shorter than the time constants of the oscillator: there twelve
      terms reach rounding at a third of the cost of `flow`. `chebyshev_stop` finds the zero of
      the series.
    - `SlipSteps` holds the affine maps of whole sample steps in one mode, and all other
      constants of such steps that do not depend on the force.

Accuracy
    Every series is truncated below the last bit. Where two equal forms differ in cancellation,
    the code takes the one that keeps the digits (`OVERDAMPED_CY`, `exponential_difference`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compile import compiled, inlined

# The flow.


SHORT_SEGMENT = 0.5
"""A segment is short if its length times (c + √w) is at most this: `flow` sums its series
directly."""

FLOW_TERMS = 17
"""Number of terms of the series on a short segment: 0.5^17·17/19! is below 1e-20."""

OVERDAMPED_CY = 0.75
"""Value of c·y above which the system is overdamped: at critical damping c·y is at most 2/e.
The spring term w·Y is then small, so that 1 - w·Y does not cancel."""

UNDERDAMPED_SHARE = 0.05
"""Least (ω_d/ω_0)² for the closed form: the difference w - c²/4 is then at least a twentieth
of w, so that ω_d keeps its digits to 10 units of rounding, as the doubled series does."""

INVERSE_FACTORIAL = tuple(1.0 / math.factorial(n) for n in range(FLOW_TERMS + 4))


@inlined
def halve_until_short(rate, s):
    """Return length [s] and radians of a segment halved until short, and the halvings.

    `rate` is its fastest rate [1/s], and s its length [s].
    """
    rate *= s
    doublings = 0
    h = s
    while rate > SHORT_SEGMENT:
        rate *= 0.5
        h *= 0.5
        doublings += 1
    return h, rate, doublings


@compiled
def flow(c, w, s):
    """Return the impulse response, its slope and its first two integrals.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²], both at least 0.
    s : float
        Length of the segment [s], at least 0.

    Returns
    -------
    y, y_d : float
        Solution of y" + c y' + w y = 0, y(0) = 0, y'(0) = 1 [s], and its slope [-].
    Y, YY : float
        Integral of y over [0, s], the response to a unit step [s²]; integral of Y, the response
        to a unit ramp [s³].

    Notes
    -----
    From x_0, v_0 under the force per mass g_0 + r s, the solution is
    x = x_0 + v_0 y + (g_0 - w x_0) Y + r YY.
    """
    h, rate, doublings = halve_until_short(c + math.sqrt(w), s)
    ch = c * h
    wh = w * h * h
    q_before = 0.0
    q = 1.0
    second = 0.0
    third = 0.0
    for n in range(1, series_terms(rate)):
        second += q * INVERSE_FACTORIAL[n + 2]
        third += q * INVERSE_FACTORIAL[n + 3]
        q, q_before = -(ch * q + wh * q_before), q
    # The oscillator equation, integrated once and twice, gives Y and y without cancellation.
    YY = second * h * h * h
    Y = h * h * (0.5 - ch * second - wh * third)
    y = h - c * Y - w * YY
    y_d = 1.0 - c * y - w * Y
    for _ in range(doublings):
        # Response to a unit initial displacement: 1 - w Y = y_d + c y. The first form cancels
        # once the motion has decayed; the second doubles the rounding error of y at every
        # doubling if the system is overdamped.
        x_x = 1.0 - w * Y if c * y > OVERDAMPED_CY else y_d + c * y
        YY = YY * (1.0 + x_x) + Y * (h + y)
        Y, y, y_d = Y * (1.0 + x_x) + y * y, y * (x_x + y_d), y_d * y_d - w * y * y
        h *= 2.0
    return y, y_d, Y, YY


@compiled
def flow_and_slope(c, w, s):
    """Return `flow` and its derivative with respect to w.

    Parameters
    ----------
    c, w, s : float
        As in `flow`.

    Returns
    -------
    y, y_d, Y, YY : float
        As from `flow`.
    z, z_d, Z, ZZ : float
        Their derivatives [s³, s², s⁴, s⁵].

    Notes
    -----
    Every line of `flow` is differentiated. z'' + c z' + w z = -y, so that z_d is also the slope
    of z. Derivatives with respect to c need no more: those of y, y_d, Y and YY are z_d, its
    slope -(y + c z_d + w z), z and Z.
    """
    h, rate, doublings = halve_until_short(c + math.sqrt(w), s)
    ch = c * h
    wh = w * h * h
    q_before, q, p_before, p = 0.0, 1.0, 0.0, 0.0
    second, third, second_w, third_w = 0.0, 0.0, 0.0, 0.0
    for n in range(1, series_terms(rate)):
        second += q * INVERSE_FACTORIAL[n + 2]
        third += q * INVERSE_FACTORIAL[n + 3]
        second_w += p * INVERSE_FACTORIAL[n + 2]
        third_w += p * INVERSE_FACTORIAL[n + 3]
        p, p_before = -(ch * p + q_before + wh * p_before), p
        q, q_before = -(ch * q + wh * q_before), q
    # Derivatives of the series are with respect to w h².
    square = h * h
    YY, ZZ = second * h * h * h, second_w * square * square * h
    Y = square * (0.5 - ch * second - wh * third)
    Z = -square * square * (ch * second_w + third + wh * third_w)
    y, z = h - c * Y - w * YY, -(c * Z + YY + w * ZZ)
    y_d, z_d = 1.0 - c * y - w * Y, -(c * z + Y + w * Z)
    for _ in range(doublings):
        if c * y > OVERDAMPED_CY:
            x_x, x_w = 1.0 - w * Y, -(Y + w * Z)
        else:
            x_x, x_w = y_d + c * y, z_d + c * z
        ZZ = ZZ * (1.0 + x_x) + YY * x_w + Z * (h + y) + Y * z
        YY = YY * (1.0 + x_x) + Y * (h + y)
        Z = Z * (1.0 + x_x) + Y * x_w + 2.0 * y * z
        Y = Y * (1.0 + x_x) + y * y
        z_d, z = 2.0 * (y_d * z_d - w * y * z) - y * y, z * (x_x + y_d) + y * (x_w + z_d)
        y_d, y = y_d * y_d - w * y * y, y * (x_x + y_d)
        h *= 2.0
    return y, y_d, Y, YY, z, z_d, Z, ZZ


@compiled
def series_terms(rate):
    """Return the number of series terms for double precision at (c + √w)·length = rate.

    As at `FLOW_TERMS`, what is left out is below rateⁿ·n/(n + 2)!, here 2e-20 and 4e-22.
    """
    if rate > 0.0625:
        return FLOW_TERMS
    return 10 if rate > 0.004 else 7


@inlined
def free_response(c, w, s):
    """Return y, y_d and Y of `flow`, in closed form where that loses no digits.

    The closed form cancels on a short segment and near critical damping; `flow` serves these.
    """
    square = w - 0.25 * c * c
    if square < UNDERDAMPED_SHARE * w or w * s * s < SHORT_SEGMENT * SHORT_SEGMENT:
        return flow(c, w, s)[:3]
    omega_d = math.sqrt(square)
    decay = math.exp(-0.5 * c * s)
    even = decay * math.cos(omega_d * s)
    y = decay * math.sin(omega_d * s) / omega_d
    return y, even - 0.5 * c * y, (1.0 - even - 0.5 * c * y) / w


# The response to a sine.


@compiled
def sine_response(c, w, omega, s, y, y_d):
    """Return the response from rest to sin(omega s)/omega, with its derivatives.

    Parameters
    ----------
    c, w, s : float
        As in `flow`.
    omega : float
        Angular frequency [rad/s], at least 0.
    y, y_d : float
        Impulse response and its slope at s, from `flow` [s, -].

    Returns
    -------
    R, P, P_d : float
        Response from rest to sin(omega s)/omega [s³]; its derivative, which is the response to
        cos(omega s) [s²]; and the derivative of that [s].
    sine, cosine : float
        sin(omega s)/omega [s] and cos(omega s) [-].

    Notes
    -----
    The response to exp(mu s) from rest is the divided difference of z -> exp(z s) over mu and
    both characteristic roots. It is finite at resonance, where mu meets a root.
    """
    if (c + math.sqrt(w) + omega) * s <= SHORT_SEGMENT:
        return sine_response_series(c, w, omega, s)
    mu = complex(0.0, omega)
    root, other, decay = characteristic_roots(c, w, y, y_d)
    phasor = complex(math.cos(omega * s), math.sin(omega * s))
    first_difference = exponential_difference(mu - root, decay, phasor, s)
    second_difference = (first_difference - y) / (mu - other)
    rate = (phasor + root * first_difference - y_d) / (mu - other)
    return (
        second_difference.imag / omega,
        second_difference.real,
        rate.real,
        phasor.imag / omega,
        phasor.real,
    )


class WaveResponse(NamedTuple):
    """Response from rest to exp(i omega s) as force per mass, and its derivatives.

    Attributes
    ----------
    x, v : complex
        Displacement [s²] and velocity [s].
    x_w, v_w : complex
        Their derivatives with respect to w [s⁴, s³]; those with respect to c are v_w and its
        slope, -(x + c v_w + w x_w).
    x_omega, v_omega : complex
        Their derivatives with respect to omega [s³, s²].
    """

    x: complex
    v: complex
    x_w: complex
    v_w: complex
    x_omega: complex
    v_omega: complex


@compiled
def wave_response(c, w, omega, s):
    """Return the `WaveResponse` at s [s]; parameters as in `sine_response`.

    Notes
    -----
    As in `flow`, a short segment is summed as a power series; a long one is halved until it is
    short, and rebuilt: the response over both halves is the free motion over the second half
    after the response over the first, plus this response again, turned by the phase.
    """
    h, rate, doublings = halve_until_short(c + math.sqrt(w) + omega, s)
    x, v = complex(0.0, 0.0), complex(0.0, 0.0)
    x_w, v_w, x_omega, v_omega = x, v, x, v
    # Derivatives of order n and n + 1: of the response and of its derivatives, at 0.
    a, b, a_w, b_w, a_omega, b_omega = x, v, x, v, x, v
    push, push_omega, power = complex(1.0, 0.0), complex(0.0, 0.0), 1.0
    for n in range(series_terms(rate) + 2):
        factor = power * INVERSE_FACTORIAL[n]
        x, v = x + a * factor, v + b * factor
        x_w, v_w = x_w + a_w * factor, v_w + b_w * factor
        x_omega, v_omega = x_omega + a_omega * factor, v_omega + b_omega * factor
        a_w, b_w = b_w, -(a + c * b_w + w * a_w)
        a, b = b, push - (c * b + w * a)
        a_omega, b_omega = b_omega, push_omega - (c * b_omega + w * a_omega)
        push, push_omega = (
            complex(-omega * push.imag, omega * push.real),
            complex(-push.imag - omega * push_omega.imag, push.real + omega * push_omega.real),
        )
        power *= h
    for _ in range(doublings):
        y, y_d, Y, _, z, z_d, Z, _ = flow_and_slope(c, w, h)
        x_x, v_x = 1.0 - w * Y, -w * y
        x_xw, v_xw = -(Y + w * Z), -(y + w * z)
        turn = complex(math.cos(omega * h), math.sin(omega * h))
        turned = complex(0.0, h) * turn
        x_w, v_w = (
            x_xw * x + z * v + x_x * x_w + y * v_w + turn * x_w,
            v_xw * x + z_d * v + v_x * x_w + y_d * v_w + turn * v_w,
        )
        x_omega, v_omega = (
            x_x * x_omega + y * v_omega + turn * x_omega + turned * x,
            v_x * x_omega + y_d * v_omega + turn * v_omega + turned * v,
        )
        x, v = x_x * x + y * v + turn * x, v_x * x + y_d * v + turn * v
        h *= 2.0
    return WaveResponse(x, v, x_w, v_w, x_omega, v_omega)


@compiled
def characteristic_roots(c, w, y, y_d):
    """Return the slow characteristic root [1/s], the fast one, and exp(slow root·s).

    Where the roots are complex, the one with positive imaginary part comes first.
    """
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
def exponential_difference(difference, decay, phasor, s):
    """Return (exp(mu s) - exp(root s))/(mu - root), also where mu and root coincide.

    `difference` is mu - root [1/s], `decay` is exp(root s), and `phasor` is exp(mu s).
    """
    z = difference * s
    if abs(z) > 0.25:
        return (phasor - decay) / difference
    total = complex(0.0, 0.0)
    term = complex(1.0, 0.0)
    for n in range(2, 15):
        total += term
        term *= z / n
    return decay * s * total


@compiled
def sine_response_series(c, w, omega, s):
    """Return `sine_response` by its power series, for (c + √w + omega)·s up to 0.5."""
    rate = (c + math.sqrt(w) + omega) * s
    cs = c * s
    ws = w * s * s
    os = omega * omega * s * s
    q_before, q = 0.0, 1.0
    cosine_term = 1.0
    even = True
    R = 0.0
    P = 0.0
    for n in range(1, series_terms(rate)):
        R += q * INVERSE_FACTORIAL[n + 2]
        P += q * INVERSE_FACTORIAL[n + 1]
        even = not even
        if even:
            cosine_term *= -os
            q, q_before = cosine_term - (cs * q + ws * q_before), q
        else:
            q, q_before = -(cs * q + ws * q_before), q
    R *= s * s * s
    P *= s * s
    sine = math.sin(omega * s) / omega if omega > 0.0 else s
    cosine = math.cos(omega * s)
    return R, P, sine - c * P - w * R, sine, cosine


# Samples without dry friction.


@compiled
def linear_recursion(plant, u_dd, dt, x_r, v_r, x_out, v_out):
    """Solve the oscillator without dry friction on sampled base motion.

    Parameters
    ----------
    plant : Plant
    u_dd : array, shape (n,)
        Base acceleration [m/s²], linear between samples.
    dt : float
        Sample interval [s].
    x_r, v_r : float
        State at the first sample [m, m/s].
    x_out, v_out : array, shape (n,)
        Overwritten with the state at every sample [m, m/s].
    """
    m, k_x, b = plant
    w = k_x / m
    y, y_d, Y, YY = flow(b / m, w, dt)
    x_x, v_x = 1.0 - w * Y, -w * y
    x_0, x_1, v_0, v_1 = hold_weights(y, Y, YY, dt)
    x_out[0] = x_r
    v_out[0] = v_r
    before = u_dd[0]
    for n in range(1, len(u_dd)):
        now = u_dd[n]
        x_r, v_r = (
            x_x * x_r + y * v_r - (x_0 * before + x_1 * now),
            v_x * x_r + y_d * v_r - (v_0 * before + v_1 * now),
        )
        before = now
        x_out[n] = x_r
        v_out[n] = v_r


@compiled
def hold_weights(y, Y, YY, dt):
    """Return the weights x_0, x_1 [s²], v_0, v_1 [s] of ü at both ends of a step.

    They are those of an exact first-order-hold discretisation: ü is linear in between. The base
    subtracts x_0 ü(0) + x_1 ü(dt) from x_r, and v_0 ü(0) + v_1 ü(dt) from v_r.
    """
    x_1, v_1 = YY / dt, Y / dt
    return Y - x_1, x_1, y - v_1, v_1


# The power series of a short segment of sliding.

SERIES_SEGMENT = 0.2
"""Largest (c + √w)·length that `velocity_series` serves: the first omitted term is then
0.2^10/12!, or 2e-16, of that of the jerk."""

CHEBYSHEV_TOLERANCE = 1e-6
"""Relative step of Chebyshev's third-order method after which the error is below rounding."""

MAX_CHEBYSHEV_ROUNDS = 8
"""Two rounds suffice almost always. Where these do not converge, `locate_stop` takes over."""


class SeriesFactors(NamedTuple):
    """Factors of acceleration (a) and jerk (j) in the coefficients q_3 to q_11 of v(s).

    With linear forcing, q_n = a[n - 3]·a(0) + j[n - 3]·j(0) for n >= 3.
    """

    a: tuple[float, ...]
    j: tuple[float, ...]


@compiled
def series_factors(c, w):
    """Return the factors of q_3 to q_11, from v⁽ⁿ⁾ = -(c v⁽ⁿ⁻¹⁾ + w v⁽ⁿ⁻²⁾)."""
    return SeriesFactors(
        series_recursion(c, w, -w / 6.0, -c * -w / 24.0),
        series_recursion(c, w, -c / 6.0, -(c * -c + w) / 24.0),
    )


@compiled
def series_recursion(c, w, q_3, q_4):
    """Return q_3 to q_11 from n q_n = -(c q_(n-1) + w q_(n-2)/(n - 1)).

    By reciprocals: divisions would take a tenth of the time in which a segment is integrated.
    """
    q_5 = -(c * q_4 + w * q_3 * (1.0 / 4.0)) * (1.0 / 5.0)
    q_6 = -(c * q_5 + w * q_4 * (1.0 / 5.0)) * (1.0 / 6.0)
    q_7 = -(c * q_6 + w * q_5 * (1.0 / 6.0)) * (1.0 / 7.0)
    q_8 = -(c * q_7 + w * q_6 * (1.0 / 7.0)) * (1.0 / 8.0)
    q_9 = -(c * q_8 + w * q_7 * (1.0 / 8.0)) * (1.0 / 9.0)
    q_10 = -(c * q_9 + w * q_8 * (1.0 / 9.0)) * (1.0 / 10.0)
    q_11 = -(c * q_10 + w * q_9 * (1.0 / 10.0)) * (1.0 / 11.0)
    return q_3, q_4, q_5, q_6, q_7, q_8, q_9, q_10, q_11


@compiled
def velocity_series(factors, v, a, j):
    """Return the coefficients q_0 to q_11 of v(s) = Σ q_n sⁿ from v, a and jerk j at 0."""
    f, g = factors
    return (
        v, a, 0.5 * j, f[0] * a + g[0] * j, f[1] * a + g[1] * j, f[2] * a + g[2] * j,
        f[3] * a + g[3] * j, f[4] * a + g[4] * j, f[5] * a + g[5] * j, f[6] * a + g[6] * j,
        f[7] * a + g[7] * j, f[8] * a + g[8] * j,
    )  # fmt: skip


@compiled
def series_distance(q, s):
    """Return the integral of the series over [0, s]: the distance [m]."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * (1.0 / 2.0) * s) + s_2 * (q[2] * (1.0 / 3.0) + q[3] * (1.0 / 4.0) * s)
    mid = (q[4] * (1.0 / 5.0) + q[5] * (1.0 / 6.0) * s) + s_2 * (
        q[6] * (1.0 / 7.0) + q[7] * (1.0 / 8.0) * s
    )
    high = (q[8] * (1.0 / 9.0) + q[9] * (1.0 / 10.0) * s) + s_2 * (
        q[10] * (1.0 / 11.0) + q[11] * (1.0 / 12.0) * s
    )
    return s * (low + s_4 * (mid + s_4 * high))


@compiled
def series_velocity(q, s):
    """Return the value of the series at s: the velocity [m/s]."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * s) + s_2 * (q[2] + q[3] * s)
    mid = (q[4] + q[5] * s) + s_2 * (q[6] + q[7] * s)
    high = (q[8] + q[9] * s) + s_2 * (q[10] + q[11] * s)
    return low + s_4 * (mid + s_4 * high)


@compiled
def series_acceleration(q, s):
    """Return the derivative of the series at s: the acceleration [m/s²]."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[1] + 2.0 * q[2] * s) + s_2 * (3.0 * q[3] + 4.0 * q[4] * s)
    mid = (5.0 * q[5] + 6.0 * q[6] * s) + s_2 * (7.0 * q[7] + 8.0 * q[8] * s)
    high = (9.0 * q[9] + 10.0 * q[10] * s) + s_2 * (11.0 * q[11])
    return low + s_4 * (mid + s_4 * high)


@inlined
def chebyshev_stop(q, h):
    """Return the zero in (0, h] of a velocity that is positive at 0 and not above zero at h.

    Parameters
    ----------
    q : tuple of float
        Coefficients from `velocity_series`.
    h : float
        Length of the segment [s]; short, so that v has at most one extremum and one such zero.

    Returns
    -------
    s, path : float
        Time of the stop [s] and distance until then [m]; s = -1 where the iteration does not
        converge.

    Notes
    -----
    The first guess is the zero of the quadratic part, corrected by the cubic and quartic terms.
    Chebyshev's method refines it. The distance is that at the last iterate plus a second-order
    step, which saves one evaluation of the series.
    """
    square = q[1] * q[1] - 4.0 * q[0] * q[2]
    if square <= 0.0:
        return -1.0, 0.0
    root = math.sqrt(square)
    s = 2.0 * q[0] / (root - q[1]) if root > q[1] else (-q[1] - root) / (2.0 * q[2])
    s += s * s * s * (q[3] + s * q[4]) * (1.0 / root)
    for _ in range(MAX_CHEBYSHEV_ROUNDS):
        a = series_acceleration(q, s)
        if not (a < 0.0 and s > 0.0):
            return -1.0, 0.0
        v, path = series_velocity(q, s), series_distance(q, s)
        per_a = 1.0 / a
        step = -v * per_a
        step -= step * step * (q[2] + 3.0 * q[3] * s) * per_a
        s += step
        if abs(step) <= CHEBYSHEV_TOLERANCE * s:
            return min(s, h), path + step * (v + 0.5 * step * a)
    return -1.0, 0.0


# Whole steps of sliding.

FINE_STEP = 3.0
"""Largest characteristic rate times dt of a fine step. Extrema of v_r are at least π apart in
these units, so that a fine step holds at most one; and what decays within it keeps more than
a thousandth, far above rounding."""

CANCELLATION_SHARE = 1e-6
"""Share of the force balance below which the affine map has lost the digits of v_r, which is
then propagated by itself. At 1e-6 the acceleration keeps a relative error of 1e-10."""

LOWEST_RATE = 2.0**-1022
"""Rate of an oscillator whose inverse overflows below it [1/s]; it moves nothing in any run."""

DIP_SAFETY = 2.0
"""Safety factor on the bound of a dip of v_r between samples; it exceeds all rounding."""


class AffineMap(NamedTuple):
    """Affine map of a segment, without the contribution of the base.

    x_r becomes x_x x_r + x_v v_r - x_f f, and v_r becomes v_x x_r + v_v v_r - v_f f, with f the
    constant force per mass against the motion [m/s²].
    """

    x_x: float
    x_v: float
    x_f: float
    v_x: float
    v_v: float
    v_f: float


GRAZING_SHARE, GRAZING_STEPS = 1e-4, 256
"""Change of friction [-], over so many steps or as long as the oscillator remembers a force,
whose change of v_r is the speed below which each minimum of |v_r| is looked at."""


class SlipSteps(NamedTuple):
    """Constants of whole sample steps of sliding, or of any other motion in one mode.

    Attributes
    ----------
    c, w : float
        Damping per mass [1/s] and stiffness per mass [1/s²].
    dt : float
        Length of a step [s].
    fine : bool
        Whether a step holds at most one extremum of v_r.
    short : bool
        Whether `velocity_series` reaches double precision over a step.
    factors : SeriesFactors
        Of this series.
    step_map, four_step_map : AffineMap
        Of one step and of four.
    x_0, x_1, v_0, v_1 : float
        Weights of ü at both ends of a step in x_r [s²] and v_r [s], see `hold_weights`.
    x_base, v_base : tuple of float, shape (5,)
        Weights of ü at five consecutive samples in x_r [s²] and v_r [s] after four steps.
    steep, fast : float
        Bound on a dip: v_r has no zero within four steps while |v_r| at both ends is above
        steep·max |Δü| + fast·max |v_r|. Infinite where the steps are too long for the bound.
    speed_per_force : float
        See `cancellation_threshold` [s].
    """

    c: float
    w: float
    dt: float
    fine: bool
    short: bool
    factors: SeriesFactors
    step_map: AffineMap
    four_step_map: AffineMap
    x_0: float
    x_1: float
    v_0: float
    v_1: float
    x_base: tuple[float, float, float, float, float]
    v_base: tuple[float, float, float, float, float]
    steep: float
    fast: float
    speed_per_force: float


@compiled
def discretise_slip(c, w, dt):
    """Return the constants of steps of length dt [s]; c and w as in `flow`.

    A step is discretised exactly under a first-order hold: ü is linear between samples.

    Notes
    -----
    Over four steps the second derivative of v_r is at most
    M = |Δü|/dt + c (v/(4 dt) + 4 M dt) + w (v + 2 M dt²), with v the larger |v_r| of both ends.
    A function with |v_r"| <= M falls at most 2 M dt² below its lower end. Solved for M, this
    gives `steep` and `fast`.
    """
    radians = (c + math.sqrt(w)) * dt
    y, _, Y, YY = flow(c, w, dt)
    x_0, x_1, v_0, v_1 = hold_weights(y, Y, YY, dt)
    # Contributions of ü at the start and at the end of a step one, two and three steps later.
    one, two = constant_force_map(c, w, dt), constant_force_map(c, w, 2.0 * dt)
    three, four = constant_force_map(c, w, 3.0 * dt), constant_force_map(c, w, 4.0 * dt)
    a, p = free_motion(one, x_0, v_0), free_motion(one, x_1, v_1)
    b, q = free_motion(two, x_0, v_0), free_motion(two, x_1, v_1)
    g, r = free_motion(three, x_0, v_0), free_motion(three, x_1, v_1)
    divisor = 1.0 - (4.0 * c + 2.0 * w * dt) * dt
    dip_factor = DIP_SAFETY * 2.0 / divisor if divisor > 0.25 else math.inf
    steep, fast = dip_factor * dt, dip_factor * (0.25 * c + w * dt) * dt
    return SlipSteps(
        c, w, dt, characteristic_rate(c, w) * dt <= FINE_STEP, radians <= SERIES_SEGMENT,
        series_factors(c, w), one, four, x_0, x_1, v_0, v_1,
        (g[0], b[0] + r[0], a[0] + q[0], x_0 + p[0], x_1),
        (g[1], b[1] + r[1], a[1] + q[1], v_0 + p[1], v_1),
        steep, fast, cancellation_speed(c, w),
    )  # fmt: skip


STEP_COLUMNS = 52
"""Numbers in `SlipSteps`, as a row of a table."""


@compiled
def write_steps(row, steps):
    """Write `SlipSteps` to the row of a table."""
    row[0], row[1], row[2] = steps.c, steps.w, steps.dt
    row[3], row[4] = 1.0 if steps.fine else 0.0, 1.0 if steps.short else 0.0
    for k in range(9):
        row[5 + k], row[14 + k] = steps.factors.a[k], steps.factors.j[k]
    for k in range(6):
        row[23 + k], row[29 + k] = steps.step_map[k], steps.four_step_map[k]
    row[35], row[36], row[37], row[38] = steps.x_0, steps.x_1, steps.v_0, steps.v_1
    for k in range(5):
        row[39 + k], row[44 + k] = steps.x_base[k], steps.v_base[k]
    row[49], row[50], row[51] = steps.steep, steps.fast, steps.speed_per_force


@inlined
def read_steps(row):
    """Return the `SlipSteps` of a row from `write_steps`."""
    a = row[5], row[6], row[7], row[8], row[9], row[10], row[11], row[12], row[13]
    j = row[14], row[15], row[16], row[17], row[18], row[19], row[20], row[21], row[22]
    return SlipSteps(
        row[0], row[1], row[2], row[3] > 0.0, row[4] > 0.0, SeriesFactors(a, j),
        AffineMap(row[23], row[24], row[25], row[26], row[27], row[28]),
        AffineMap(row[29], row[30], row[31], row[32], row[33], row[34]),
        row[35], row[36], row[37], row[38],
        (row[39], row[40], row[41], row[42], row[43]),
        (row[44], row[45], row[46], row[47], row[48]),
        row[49], row[50], row[51],
    )  # fmt: skip


@compiled
def grazing_speed(c, w, dt, m, F_fk, F_fs):
    """Return the speed below which each minimum of |v_r| is looked at [m/s].

    It is 0 where F_fs = F_fk, as a stop then changes nothing.
    """
    if F_fs <= F_fk:
        return 0.0
    rate = characteristic_rate(c, w)
    return GRAZING_SHARE * F_fs / m / (rate + 1.0 / (GRAZING_STEPS * dt))


@compiled
def constant_force_map(c, w, s):
    """Return the `AffineMap` of a segment of length s [s]: exact for a constant force."""
    y, y_d, Y, _ = flow(c, w, s)
    return AffineMap(1.0 - w * Y, y, Y, -w * y, y_d, y)


@compiled
def free_motion(step_map, x_r, v_r):
    """Return x_r and v_r at the end of a segment without forcing."""
    return (
        step_map.x_x * x_r + step_map.x_v * v_r,
        step_map.v_x * x_r + step_map.v_v * v_r,
    )


@compiled
def characteristic_rate(c, w):
    """Return max(√w, c/2): the phase or the decay per second of the oscillator [1/s]."""
    return max(math.sqrt(w), 0.5 * c)


@compiled
def cancellation_speed(c, w):
    """Return the cancellation threshold [m/s] per unit of force per mass [m/s²]."""
    rate = characteristic_rate(c, w)
    return CANCELLATION_SHARE / rate if rate > LOWEST_RATE else 0.0


@inlined
def cancellation_threshold(steps, f, x_r):
    """Return the |v_r| [m/s] at or below which the affine map has lost the digits of v_r.

    The map computes v_r as a sum of terms of the size of the forces; where these nearly cancel,
    their rounding would decide the sign of v_r. `f` is the constant force per mass [m/s²].
    """
    return steps.speed_per_force * abs(f) + steps.speed_per_force * steps.w * abs(x_r)
