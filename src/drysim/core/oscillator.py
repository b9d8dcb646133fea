"""Closed-form flow, sine response, affine step maps, short series of the linear oscillator.

The equation is x" + c x' + w x = g(s) with c = b/m and w = k_x/m; every exact solution is made
of its closed-form flow.

- `flow`: response to a kick, a step and a ramp. A short segment is summed as its power series
  until nothing is left to add; a long one is doubled up from a short one. No damping regime is
  special: no formula divides by w, by c, or by a difference of roots. `free_response` is the same
  without the ramp, by the shortest way: what motion under waves needs.
- `sine_response`: what a sine adds to the flow. Resonance without damping is no special case either.
- `linear_recursion`: the oscillator without dry friction over samples, without any event code.
- `velocity_series`, `long_velocity_series`: most steps that hold an event are far shorter than the times of the
  oscillator; there ten terms of v(s) do the same as the flow for a third of the work, and six
  more serve a segment five times as long. `chebyshev_stop` finds a stop in them.
- `SlipSteps` (Coulomb) and `OscillatorSteps` (elastic contact): the affine map of whole steps of sampled base
  motion, and all else about them that does not change during a march.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compile import compiled, inlined

# The flow.


SHORT_SEGMENT = 0.5
"""A segment is short when its length times the fastest rate is below this."""

FLOW_TERMS = 17
"""Terms that exhaust double precision on a short segment: 0.5^17·17/19! is below 1e-20."""

OVERDAMPED_CY = 0.75
"""Value of c y that only a motion far beyond critical damping comes to, critical is 2/e, and
only while its spring has given back less than the rest of 1."""

UNDERDAMPED_SHARE = 0.05
"""Share of w that is left of w - c²/4 where sines and cosines are as good as the series."""

INVERSE_FACTORIAL = tuple(1.0 / math.factorial(n) for n in range(FLOW_TERMS + 4))


@compiled
def flow(c, w, s):
    """Return the response to a unit kick, its slope, and its first two integrals.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²], at least 0.
    s : float
        Length of the segment [s], at least 0.

    Returns
    -------
    y, y_d : float
        Solution of y" + c y' + w y = 0, y(0) = 0, y'(0) = 1 [s], and its slope [-].
    Y, YY : float
        Integral of y from 0 to s [s²], the response to a unit step, and the integral of Y [s³],
        the response to a unit ramp.

    Notes
    -----
    From x_0, v_0 under g = g_0 + r s: x = x_0 + v_0 y + (g_0 - w x_0) Y + r YY.
    """
    rate = (c + math.sqrt(w)) * s
    doublings = 0
    h = s
    while rate > SHORT_SEGMENT:
        rate *= 0.5
        h *= 0.5
        doublings += 1
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
    # The equation, integrated, gives the rest without cancellation on a short stretch.
    YY = second * h * h * h
    Y = h * h * (0.5 - ch * second - wh * third)
    y = h - c * Y - w * YY
    y_d = 1.0 - c * y - w * Y
    for _ in range(doublings):
        # Both are the same; but 1 - w Y loses what is left of a motion that dies away, and
        # y_d + c y of one that a damper holds doubles the rounding of y each time.
        x_x = 1.0 - w * Y if c * y > OVERDAMPED_CY else y_d + c * y
        YY = YY * (1.0 + x_x) + Y * (h + y)
        Y, y, y_d = Y * (1.0 + x_x) + y * y, y * (x_x + y_d), y_d * y_d - w * y * y
        h *= 2.0
    return y, y_d, Y, YY


@compiled
def series_terms(rate):
    """Return the number of series terms that exhaust double precision at rate·length `series_acceleration`."""
    if rate > 0.0625:
        return FLOW_TERMS
    return 10 if rate > 0.004 else 7


@inlined
def free_response(c, w, s):
    """Return y, y_d and Y as `flow` does: in closed form where that loses nothing.

    It would cancel on a short segment, and near critical damping.
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
    """Return the response from rest to sin(omega s)/omega, and the wave itself.

    Parameters
    ----------
    c, w, s : float
        As in `flow`.
    omega : float
        Angular frequency of the wave [rad/s], at least 0.
    y, y_d : float
        What `flow` gives for the segment.

    Returns
    -------
    R, P, P_d : float
        Response from rest to sin(omega s)/omega [s³]; its slope, which is the response to
        cos(omega s) [s²]; and the slope of that [s].
    sine, cosine : float
        sin(omega s)/omega [s] and cos(omega s) [-].
    """
    if (c + math.sqrt(w) + omega) * s <= SHORT_SEGMENT:
        return sine_response_series(c, w, omega, s)
    # The response to exp(mu s) is a divided difference of exponentials over mu and both roots.
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


@compiled
def characteristic_roots(c, w, y, y_d):
    """Return the slower root of the oscillator [1/s], the other, and exp(root s)."""
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
    """Return (exp(mu s) - exp(root s))/(mu - root), also where mu and root meet.

    `difference` is mu - root [1/s], `decay` exp(root s) and `phasor` exp(mu s).
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
    """Return what `sine_response` does by a series: short for wave and oscillator."""
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
    """March from the first sample to the last.

    Parameters
    ----------
    plant : Plant
    u_dd : array, shape (n,)
        Base acceleration [m/s²], linear between samples.
    dt : float
        Distance of the samples [s].
    x_r, v_r : float
        State at the first sample [m, m/s].
    x_out, v_out : array, shape (n,)
        Written.
    """
    m, k_x, b = plant
    w = k_x / m
    y, y_d, Y, YY = flow(b / m, w, dt)
    x_x, v_x = 1.0 - w * Y, -w * y
    x_0, x_1, v_0, v_1 = end_weights(y, Y, YY, dt)
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
def end_weights(y, Y, YY, dt):
    """Return what ü at both ends of a step takes from x_r [s²], and from v_r [s]."""
    x_1, v_1 = YY / dt, Y / dt
    return Y - x_1, x_1, y - v_1, v_1


# The power series of a short segment of sliding.

SERIES_TERMS, EXTRA_TERMS = 10, 6
"""Terms of the series, and those that `long_velocity_series` adds. They are counted from the end, for
the compiler leaves out what a series has not, but looks whether it could be there."""

BRIEF_SEGMENT = 0.1
"""Radians (or decays) in a brief segment: ten terms of its series exhaust double precision."""

CHEBYSHEV_TOLERANCE = 1e-6
"""Relative step of Halley's method, of third order, after which nothing is left to mend."""

MAX_CHEBYSHEV_ROUNDS = 8
"""The first guess is off by less than that mostly; what strays takes the general way."""


class SeriesFactors(NamedTuple):
    """How acceleration (a) and jerk (j) at the start go on in the terms of v from s³ to s⁹."""

    a_3: float
    j_3: float
    a_4: float
    j_4: float
    a_5: float
    j_5: float
    a_6: float
    j_6: float
    a_7: float
    j_7: float
    a_8: float
    j_8: float
    a_9: float
    j_9: float


class HigherSeriesFactors(NamedTuple):
    """How acceleration (a) and jerk (j) at the start go on in v's terms from s¹⁰ to s¹⁵."""

    a_10: float
    j_10: float
    a_11: float
    j_11: float
    a_12: float
    j_12: float
    a_13: float
    j_13: float
    a_14: float
    j_14: float
    a_15: float
    j_15: float


@compiled
def series_factors(c, w):
    """Return the tail: each derivative is -(c times the last + w times the one before)."""
    a_3, j_3 = -w, -c
    a_4, j_4 = -c * a_3, -(c * j_3 + w)
    a_5, j_5 = -(c * a_4 + w * a_3), -(c * j_4 + w * j_3)
    a_6, j_6 = -(c * a_5 + w * a_4), -(c * j_5 + w * j_4)
    a_7, j_7 = -(c * a_6 + w * a_5), -(c * j_6 + w * j_5)
    a_8, j_8 = -(c * a_7 + w * a_6), -(c * j_7 + w * j_6)
    a_9, j_9 = -(c * a_8 + w * a_7), -(c * j_8 + w * j_7)
    return SeriesFactors(
        a_3 / 6.0, j_3 / 6.0, a_4 / 24.0, j_4 / 24.0, a_5 / 120.0, j_5 / 120.0,
        a_6 / 720.0, j_6 / 720.0, a_7 / 5040.0, j_7 / 5040.0, a_8 / 40320.0, j_8 / 40320.0,
        a_9 / 362880.0, j_9 / 362880.0,
    )  # fmt: skip


@compiled
def higher_series_factors(factors, c, w):
    """Return what follows on a tail: each term from the two before it."""
    a_10, j_10 = (
        next_factor(c, w, factors.a_9, factors.a_8, 10),
        next_factor(c, w, factors.j_9, factors.j_8, 10),
    )
    a_11, j_11 = (
        next_factor(c, w, a_10, factors.a_9, 11),
        next_factor(c, w, j_10, factors.j_9, 11),
    )
    a_12, j_12 = next_factor(c, w, a_11, a_10, 12), next_factor(c, w, j_11, j_10, 12)
    a_13, j_13 = next_factor(c, w, a_12, a_11, 13), next_factor(c, w, j_12, j_11, 13)
    a_14, j_14 = next_factor(c, w, a_13, a_12, 14), next_factor(c, w, j_13, j_12, 14)
    a_15, j_15 = next_factor(c, w, a_14, a_13, 15), next_factor(c, w, j_14, j_13, 15)
    return HigherSeriesFactors(
        a_10, j_10, a_11, j_11, a_12, j_12, a_13, j_13, a_14, j_14, a_15, j_15
    )  # fmt: skip


@compiled
def next_factor(c, w, last, one_before, n):
    """Return the coefficient of sⁿ in v from the two before it."""
    return -(c * last + w * one_before / (n - 1)) / n


@compiled
def velocity_series(factors, v, a, j):
    """Return the coefficients of v(s) = q_0 + q_1 s + q_2 s² + ... from v, a and jerk."""
    return (
        v,
        a,
        0.5 * j,
        factors.a_3 * a + factors.j_3 * j,
        factors.a_4 * a + factors.j_4 * j,
        factors.a_5 * a + factors.j_5 * j,
        factors.a_6 * a + factors.j_6 * j,
        factors.a_7 * a + factors.j_7 * j,
        factors.a_8 * a + factors.j_8 * j,
        factors.a_9 * a + factors.j_9 * j,
    )


@compiled
def long_velocity_series(factors, more, v, a, j):
    """Return the coefficients of `velocity_series` and six more."""
    return (
        *velocity_series(factors, v, a, j),
        more.a_10 * a + more.j_10 * j, more.a_11 * a + more.j_11 * j,
        more.a_12 * a + more.j_12 * j, more.a_13 * a + more.j_13 * j,
        more.a_14 * a + more.j_14 * j, more.a_15 * a + more.j_15 * j,
    )  # fmt: skip


@compiled
def series_distance(q, s):
    """Return the distance slid in time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * (1.0 / 2.0) * s) + s_2 * (q[2] * (1.0 / 3.0) + q[3] * (1.0 / 4.0) * s)
    high = (q[4] * (1.0 / 5.0) + q[5] * (1.0 / 6.0) * s) + s_2 * (
        q[6] * (1.0 / 7.0) + q[7] * (1.0 / 8.0) * s
    )
    high += s_4 * (q[8] * (1.0 / 9.0) + q[9] * (1.0 / 10.0) * s)
    if len(q) > SERIES_TERMS:
        n = len(q) - EXTRA_TERMS
        far = (q[n] * (1.0 / 11.0) + q[n + 1] * (1.0 / 12.0) * s) + s_2 * (
            (q[n + 2] * (1.0 / 13.0) + q[n + 3] * (1.0 / 14.0) * s)
            + s_2 * (q[n + 4] * (1.0 / 15.0) + q[n + 5] * (1.0 / 16.0) * s)
        )
        high += s_4 * s_2 * far
    return s * (low + s_4 * high)


@compiled
def series_velocity(q, s):
    """Return the velocity after time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[0] + q[1] * s) + s_2 * (q[2] + q[3] * s)
    high = (q[4] + q[5] * s) + s_2 * (q[6] + q[7] * s) + s_4 * (q[8] + q[9] * s)
    if len(q) > SERIES_TERMS:
        n = len(q) - EXTRA_TERMS
        far = (q[n] + q[n + 1] * s) + s_2 * (
            (q[n + 2] + q[n + 3] * s) + s_2 * (q[n + 4] + q[n + 5] * s)
        )
        high += s_4 * s_2 * far
    return low + s_4 * high


@compiled
def series_acceleration(q, s):
    """Return the acceleration after time s."""
    s_2 = s * s
    s_4 = s_2 * s_2
    low = (q[1] + 2.0 * q[2] * s) + s_2 * (3.0 * q[3] + 4.0 * q[4] * s)
    high = (5.0 * q[5] + 6.0 * q[6] * s) + s_2 * (7.0 * q[7] + 8.0 * q[8] * s)
    high += s_4 * (9.0 * q[9])
    if len(q) > SERIES_TERMS:
        n = len(q) - EXTRA_TERMS
        far = (10.0 * q[n] + 11.0 * q[n + 1] * s) + s_2 * (
            (12.0 * q[n + 2] + 13.0 * q[n + 3] * s)
            + s_2 * (14.0 * q[n + 4] + 15.0 * q[n + 5] * s)
        )
        high += s_4 * s * far
    return low + s_4 * high


@inlined
def chebyshev_stop(q, h):
    """Return when in (0, h] a velocity above zero that ends below is zero, and the path there.

    A short segment holds at most one extremum, so there is one such time. The first guess is
    where the parabola through the start is zero, mended by the next two terms; where Halley's
    method strays from there, a time of -1 says so. The path is that to the last guess and what
    the last step adds, so it need not wait for the time.
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
"""Radians (or decays) a fine step may hold: what decays within it leaves a twentieth, far above
rounding, and extrema are π apart."""

CANCELLATION_SHARE = 1e-6
"""Share of the force balance below which v_r is carried on with its own rate, see `creep`.
The smaller it is, the less of the rate survives the rounding of that balance: 1e-10 here."""

DIP_SAFETY = 2.0
"""What the bound on a dip between samples is widened by, so that rounding cannot matter."""


class AffineMap(NamedTuple):
    """The affine map of a segment of sliding, without what the base does.

    x_r becomes x_x x_r + x_v v_r - d x_f, and v_r becomes v_x x_r + v_v v_r - d v_f.
    """

    x_x: float
    x_v: float
    x_f: float
    v_x: float
    v_v: float
    v_f: float


class SlipSteps(NamedTuple):
    """The steps of a march.

    Attributes
    ----------
    c, w, f : float
        b/m [1/s], k_x/m [1/s²] and F_fk/m [m/s²].
    dt : float
        Length of a step [s].
    whole : tuple of float, shape (4,)
        `flow` over a step.
    fine, short, brief : bool
        Whether a step holds one extremum of v_r at most, and whether `long_velocity_series` and
        `velocity_series` serve it.
    tail, more : Tail, More
    one, four : Map
        Of one step and of four.
    x_0, x_1, v_0, v_1 : float
        What ü at both ends of a step takes from x_r [s²] and v_r [s].
    x_base, v_base : tuple of float, shape (5,)
        What ü at five samples in a row takes from x_r and v_r in the four steps between them.
    steep, fast : float
        Four steps hide no dip of v_r to zero while |v_r| at both ends is above
        steep max |Δü| + fast max |v_r|; infinite where they are too long to tell.
    faint_f, faint_x : float
        v_r is faint where |v_r| <= faint_f + faint_x |x_r|, see `cancellation_threshold`.
    """

    c: float
    w: float
    f: float
    dt: float
    whole: tuple[float, float, float, float]
    fine: bool
    short: bool
    brief: bool
    factors: SeriesFactors
    more: HigherSeriesFactors
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
    threshold_f: float
    threshold_x: float


@compiled
def slip_steps(plant, law, dt):
    """Return the steps of a march, each of length dt [s].

    Notes
    -----
    In four steps |v_r"| <= M = |Δü|/dt + c (v/(4 dt) + 4 M dt) + w (v + 2 M dt²), with v the
    greater |v_r| of both ends; and a function that bends so little falls at most 2 M dt² below
    its lower end.
    """
    c, w, f = plant.b / plant.m, plant.k_x / plant.m, law.F_fk / plant.m
    radians = (c + math.sqrt(w)) * dt
    whole = flow(c, w, dt)
    y, _, Y, YY = whole
    x_0, x_1, v_0, v_1 = end_weights(y, Y, YY, dt)
    # What each end of a step gives, one, two and three steps later.
    a, p = free_motion(c, w, dt, x_0, v_0), free_motion(c, w, dt, x_1, v_1)
    b, q = free_motion(c, w, 2.0 * dt, x_0, v_0), free_motion(c, w, 2.0 * dt, x_1, v_1)
    g, r = free_motion(c, w, 3.0 * dt, x_0, v_0), free_motion(c, w, 3.0 * dt, x_1, v_1)
    divisor = 1.0 - (4.0 * c + 2.0 * w * dt) * dt
    factors = series_factors(c, w)
    dip_factor = DIP_SAFETY * 2.0 / divisor if divisor > 0.25 else math.inf
    rate, speed_per_force = characteristic_rate(c, w), cancellation_speed(c, w)
    return SlipSteps(
        c,
        w,
        f,
        dt,
        whole,
        rate * dt <= FINE_STEP,
        radians <= SHORT_SEGMENT,
        radians <= BRIEF_SEGMENT,
        factors,
        higher_series_factors(factors, c, w),
        affine_map(c, w, f, dt),
        affine_map(c, w, f, 4.0 * dt),
        x_0,
        x_1,
        v_0,
        v_1,
        (g[0], b[0] + r[0], a[0] + q[0], x_0 + p[0], x_1),
        (g[1], b[1] + r[1], a[1] + q[1], v_0 + p[1], v_1),
        dip_factor * dt,
        dip_factor * (0.25 * c + w * dt) * dt,
        speed_per_force * f,
        speed_per_force * w,
    )


@compiled
def affine_map(c, w, f, s):
    """Return the affine map of a segment of length s [s]."""
    y, y_d, Y, _ = flow(c, w, s)
    return AffineMap(1.0 - w * Y, y, Y * f, -w * y, y_d, y * f)


@compiled
def free_motion(c, w, s, x_r, v_r):
    """Return what is left of a state after free motion of length s [s]."""
    y, y_d, Y, _ = flow(c, w, s)
    return x_r * (1.0 - w * Y) + v_r * y, v_r * y_d - w * y * x_r


@compiled
def characteristic_rate(c, w):
    """Return the radians, or the decays of what lasts, that a second holds at most [1/s]."""
    return max(math.sqrt(w), 0.5 * c)


@compiled
def cancellation_speed(c, w):
    """Return the largest faint |v_r| [m/s] for forces of 1 N/kg, see `cancellation_threshold`."""
    rate = characteristic_rate(c, w)
    return CANCELLATION_SHARE / rate if rate > 0.0 else 0.0


@inlined
def cancellation_threshold(steps, x_r):
    """Return the |v_r| up to which v_r is faint [m/s].

    The affine map makes v_r of forces that cancel; the rounding of those would decide the sign
    of a velocity that is fainter still.
    """
    return steps.threshold_f + steps.threshold_x * abs(x_r)


@compiled
def step_end(steps, x_r, v_r, d, u_0, u_1):
    """Return x_r and v_r at the end of a step, should nothing happen in it."""
    step_map = steps.step_map
    return (
        step_map.x_x * x_r
        + step_map.x_v * v_r
        - (steps.x_0 * u_0 + steps.x_1 * u_1 + d * step_map.x_f),
        step_map.v_x * x_r
        + step_map.v_v * v_r
        - (steps.v_0 * u_0 + steps.v_1 * u_1 + d * step_map.v_f),
    )


# Whole steps over an elastic contact, and parts of them.

STEP_TERMS = 16
"""Terms that exhaust double precision on a fine step: 6/19! is below 1e-16."""

SERIES_STEP = 1.0
"""Radians (or decays) a fine step may hold for these terms."""


class OscillatorSteps(NamedTuple):
    """Steps in one mode of the contact.

    Attributes
    ----------
    c, w : float
        b/m [1/s] and stiffness/m [1/s²].
    dt, per_dt, rate : float
        Length of a step [s], its inverse and the fastest rate of the oscillator [1/s].
    fine : bool
        Whether a step holds one extremum of v_r at most, so that its ends tell of a dip, and
        `second` and `third` serve it.
    end : tuple of float
        The flow of a whole step.
    one : Map
        Of the state, with a unit of constant force per mass against it.
    x_0, x_1, v_0, v_1 : float
        What ü at both ends of a step takes from x_r [s²] and v_r [s].
    second, third : tuple of float, shape (STEP_TERMS,)
        Series of the second and third integral of the flow in the share of a step.
    """

    c: float
    w: float
    dt: float
    per_dt: float
    rate: float
    fine: bool
    end: tuple[float, float, float, float]
    step_map: AffineMap
    x_0: float
    x_1: float
    v_0: float
    v_1: float
    second: tuple[float, ...]
    third: tuple[float, ...]


def oscillator_steps(plant, dt):
    """Return the steps of length dt [s] of an oscillator."""
    c, w = plant.b / plant.m, plant.k_x / plant.m
    rate = c + math.sqrt(w)
    end = flow(c, w, dt)
    y, _, Y, YY = end
    x_0, x_1, v_0, v_1 = end_weights(y, Y, YY, dt)
    terms = [1.0, -c * dt]
    while len(terms) < STEP_TERMS:
        terms.append(-(c * dt * terms[-1] + w * dt * dt * terms[-2]))
    second, third = (
        tuple(term * INVERSE_FACTORIAL[n + more] for n, term in enumerate(terms))
        for more in (3, 4)
    )
    return OscillatorSteps(
        c, w, dt, 1.0 / dt, rate, rate * dt <= SERIES_STEP, end, affine_map(c, w, 1.0, dt),
        x_0, x_1, v_0, v_1, second, third,
    )  # fmt: skip


@inlined
def flow_within_step(steps, s):
    """Return what `flow` does, for a time s within a step [s]."""
    c, w = steps.c, steps.w
    if s == steps.dt:
        return steps.end
    if not steps.fine:
        return flow(c, w, s)
    z = s * steps.per_dt
    s_2 = s * s
    second = s * evaluate_polynomial(steps.second, z)
    YY = s_2 * second
    Y = s_2 * (0.5 - c * second - w * s_2 * evaluate_polynomial(steps.third, z))
    y = s - c * Y - w * YY
    return y, 1.0 - c * y - w * Y, Y, YY


@inlined
def evaluate_polynomial(q, z):
    """Return the sum of a series of `STEP_TERMS` terms."""
    z_2 = z * z
    z_4 = z_2 * z_2
    low = q[0] + q[1] * z + z_2 * (q[2] + q[3] * z)
    middle = q[4] + q[5] * z + z_2 * (q[6] + q[7] * z)
    high = q[8] + q[9] * z + z_2 * (q[10] + q[11] * z)
    last = q[12] + q[13] * z + z_2 * (q[14] + q[15] * z)
    return low + z_4 * (middle + z_4 * (high + z_4 * last))
