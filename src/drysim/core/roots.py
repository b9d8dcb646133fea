"""First root of an observable of the motion, guaranteed: stops, break-away, contact events.

Problem
    Within a segment the motion is smooth. An observable y(s), such as a velocity, the force
    that is missing for break-away, the remaining capacity of a contact or the force of a
    bumper, starts at or above zero. Find the *first* time at which it reaches zero. A test for
    a change of sign between samples is not enough: two roots may lie between them.

Method
    1. Linear forcing (`locate_stop`): the acceleration obeys the free equation, so the extrema
       of the velocity are known in closed form. Between two of them the velocity is monotone,
       and Newton's method safeguarded by bisection finds its root.
    2. Forcing by waves (`first_root`): a Taylor polynomial of y minus a bound on its remainder
       is a lower envelope P(s) <= y(s). The first root of P is a step that cannot skip a root
       of y (`safe_step`). Step there and repeat: the root is approached from one side, and a
       near miss is passed at its own distance. Once the bound proves that y decreases
       monotonically to its root (`is_monotone_to_zero`), Newton's method on the cubic Taylor
       polynomial converges in about two iterations.
    3. Break-away under waves (`break_away_time`): the same with a bound on the second
       derivative of the margin F_fs - |F_L|.
    4. A power series (`first_series_root`): the same; the series is shifted after each step.

Bound
    The jerk j obeys the oscillator equation driven by the second derivative f" of the forcing,
    and damping only reduces sqrt(j² + w·a²). So |j(s)| <= sqrt(j² + w·a²) + s·max|f"|, and
    likewise one derivative higher.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compile import ZERO, compiled, inlined
from drysim.core.events import stick_limit
from drysim.core.forcing import (
    COSINE,
    OMEGA,
    SINE,
    THETA,
    WAVE_COLUMNS,
    A,
    Motion,
    base_motion,
    force_rate_bounds,
    motion_at,
    relative_normal_force,
)
from drysim.core.oscillator import flow

NEVER = math.inf

RESOLUTION = 4e-16
"""Relative step below which a root is exact to double precision."""

MAX_BISECTIONS = 100
"""Newton's method takes about 4 iterations; bisection reaches adjacent floats
after about 60."""


@inlined
def safeguarded_newton(low, high, s, value, slope):
    """Improve the root s of a function that decreases through zero once between two times.

    Parameters
    ----------
    low, high : float
        Times between which the root lies.
    s, value, slope : float
        A time between them, and the value and derivative of the function there.

    Returns
    -------
    low, high, s, done
        Closer bounds, and the next time: by Newton's method, or the midpoint where that leaves
        the bounds; and whether it is the root. If the midpoint does not lie between the bounds
        either, they are adjacent floats, and `high` is the root.
    """
    if value == 0.0:
        return low, high, s, True
    low, high = (s, high) if value > 0.0 else (low, s)
    step = -value / slope if slope < 0.0 else NEVER
    if abs(step) <= RESOLUTION * s:
        return low, high, s, True
    s = s + step if low < s + step < high else 0.5 * (low + high)
    return (low, high, s, False) if low < s < high else (low, high, high, True)


# A velocity under linearly changing force.


@compiled
def locate_stop(c, w, v, a, r, h):
    """Return the first time in [0, h] at which a velocity is no longer above zero.

    Parameters
    ----------
    c, w : float
        As in `flow`.
    v, a, r : float
        Velocity in the direction of sliding at time 0 [m/s], at least 0; acceleration [m/s²];
        derivative of the force per mass [m/s³], constant.
    h : float
        Length of the segment [s].

    Returns
    -------
    float
        Time [s], or infinity if the velocity stays above zero.

    Notes
    -----
    No stop is missed: between extrema the velocity is monotone, and a later minimum is not
    below the first one, because the velocity is r/w plus an oscillation that does not grow. A
    velocity that only touches zero has stopped; one that decays until it underflows has not.
    """
    if (v > 0.0 or a > 0.0) and never_stops(c, w, v, a, r):
        return NEVER
    begin, end = first_fall(c, w, a, r - c * a - w * v)
    until = min(end, h)
    if begin < h and velocity_and_acceleration(c, w, v, a, r, until)[0] <= 0.0:
        return bracketed_newton(c, w, v, a, r, begin, until)
    return NEVER


@inlined
def first_fall(c, w, a, j):
    """Return when a velocity first begins to fall, and its minimum after that [s].

    Parameters as in `first_extremum`.
    """
    end = first_extremum(c, w, a, j)
    if not (a > 0.0 or (a == 0.0 and j > 0.0)):
        return 0.0, end
    omega_d_square = w - 0.25 * c * c
    # Time between neighbouring extrema.
    spacing = math.pi / math.sqrt(omega_d_square) if omega_d_square > 0.0 else NEVER
    return end, end + spacing


@compiled
def lowest_speed(c, w, v, a, r, h):
    """Return the minimum of a velocity that has no zero within h, or infinity for none.

    Parameters as in `locate_stop`.
    """
    end = first_fall(c, w, a, r - c * a - w * v)[1]
    if end >= h:
        return NEVER
    return max(velocity_and_acceleration(c, w, v, a, r, end)[0], 0.0)


@inlined
def never_stops(c, w, v, a, r):
    """Return whether a velocity that is not below zero provably stays so under this force.

    Parameters as in `locate_stop`; h is unlimited.

    Notes
    -----
    The velocity obeys v" + c v' + w v = r. Its energy a² + w v² - 2 r v does not increase, and
    where v = 0 it is a² >= 0. So v cannot reach zero while the energy is negative. At or above
    critical damping and with r = 0, v = A exp(-s_1 t) + B exp(-s_2 t) with s_2 >= s_1 has no
    zero if a + s_2 v >= 0. A force r > 0 only increases v.
    """
    if v < 0.0:
        return False
    if a * a < v * (2.0 * r - w * v):
        return True
    discriminant = 0.25 * c * c - w
    return (
        discriminant >= 0.0 and r >= 0.0 and a + (0.5 * c + math.sqrt(discriminant)) * v >= 0.0
    )


@compiled
def first_extremum(c, w, a, j):
    """Return the first time above 0 [s] at which the acceleration is zero, or infinity.

    `a` and `j` are acceleration [m/s²] and jerk [m/s³] at time 0; the forcing is linear.
    """
    omega_d_square = w - 0.25 * c * c
    # a(s) = exp(-c s/2) (a cos(omega_d s) + rate/omega_d sin(omega_d s)); above critical
    # damping, with cosh and sinh instead.
    rate = j + 0.5 * c * a
    if omega_d_square > 0.0:
        omega_d = math.sqrt(omega_d_square)
        # Roots are π apart; take the first above zero.
        angle = math.atan2(-a * omega_d, rate) if a != 0.0 else math.pi
        return (angle if angle > 0.0 else angle + math.pi) / omega_d
    if a == 0.0 or a * rate >= 0.0:
        return NEVER
    kappa = math.sqrt(-omega_d_square)
    tanh_end = -a * kappa / rate
    if tanh_end >= 1.0:
        return NEVER
    return math.atanh(tanh_end) / kappa if tanh_end > 0.0 else -a / rate


@compiled
def velocity_and_acceleration(c, w, v, a, r, s):
    """Return velocity and acceleration at time s under linear forcing.

    Where r = 0 the velocity is computed without subtraction of a steady part, so a velocity
    that decays keeps its sign.
    """
    y, y_d, Y, _ = flow(c, w, s)
    return v * y_d + (a + c * v) * y + r * Y, a * y_d + (r - w * v) * y


@compiled
def bracketed_newton(c, w, v, a, r, lo, hi):
    """Return the zero of a velocity that decreases through zero once between lo and hi."""
    s = hi
    if lo == 0.0 and a < 0.0:
        # First guess: the root of the quadratic Taylor polynomial.
        square = a * a - 2.0 * v * (r - c * a - w * v)
        if square >= 0.0:
            s = min(2.0 * v / (-a + math.sqrt(square)), hi)
    for _ in range(MAX_BISECTIONS):
        value, slope = velocity_and_acceleration(c, w, v, a, r, s)
        lo, hi, s, done = safeguarded_newton(lo, hi, s, value, slope)
        if done:
            break
    return s


# Safe steps, and Newton's method once the observable is proved monotone.

MONOTONE_FACTOR = 3.0
"""Ratio of |slope| to its largest decrease up to 1.5 times the root of the quadratic Taylor
polynomial. At 3 the slope keeps two thirds of its value, which suffices to reach zero there."""

MAX_NEWTON_ROUNDS = 20
"""The cubic has an error of fourth order, so that 2 rounds suffice. Where rounding keeps
`has_converged` from being met in ten times as many, `bracketed_root` takes over."""

MAX_STEP_RADIANS = 2.0
"""Longest step that is tried, in radians of the fastest wave. The bound never proves more."""

MAX_HALVINGS = 60
"""Maximum number of halvings of the longest step. Where a slow wave drives an overdamped mass,
the safe step may be a millionth of it."""


@compiled
def safe_step(y, rate, curvature, bound, growth, max_step):
    """Return a step within which a smooth function provably stays above zero.

    Parameters
    ----------
    y, rate, curvature : float
        Value, at least 0, and first two derivatives now.
    bound, growth : float
        Bound on the third derivative: at most bound + growth·h in magnitude at any time h from
        now.
    max_step : float
        Longest step that is tried.

    Notes
    -----
    y stays above the envelope P(h) = y + rate h + curvature h²/2 - bound h³/6 - growth h⁴/24.
    If the curvature is not above zero, P is concave: the chord between a point with P > 0 and
    one with P <= 0 lies below P, and its zero is a safe step. Else P stays above y + rate h
    until the remainder exceeds curvature h²/2.
    """
    third, twelfth = bound * (1.0 / 3.0), growth * (1.0 / 12.0)
    if curvature > 0.0:
        # Largest h up to which curvature h²/2 outweighs the remainder, so that P >= y + rate h.
        divisor = third + math.sqrt(third * third + 4.0 * twelfth * curvature)
        safe = min(2.0 * curvature / divisor, max_step) if divisor > 0.0 else max_step
        return safe if rate >= 0.0 else min(safe, -y / rate)
    # P is concave and below the quadratic, whose root bounds the step from above.
    outer = min(parabola_root(y, rate, -curvature), max_step)
    low = lower_envelope(y, rate, curvature, third, twelfth, outer)
    if low > 0.0:
        return outer
    for _ in range(MAX_HALVINGS):
        inner = 0.5 * outer
        high = lower_envelope(y, rate, curvature, third, twelfth, inner)
        if high > 0.0:
            return inner + (outer - inner) * high / (high - min(low, 0.0))
        outer, low = inner, high
    # The remainder up to `outer`, as a bound on the second derivative.
    return min(outer, parabola_root(y, rate, (third + twelfth * outer) * outer - curvature))


@inlined
def lower_envelope(y, rate, curvature, third, twelfth, h):
    """Return the envelope P of `safe_step` at h, or P/h where y is zero: P may underflow."""
    slope = rate + 0.5 * h * (curvature - h * (third + twelfth * h))
    return y + h * slope if y > 0.0 else slope


SQUARE_UNDERFLOW = 1e-140
"""Below this, squares come near the end of double precision, and `hypot` takes their place."""


@inlined
def parabola_root(y, rate, curvature):
    """Return the largest h up to which y + rate h - curvature h²/2 stays at or above zero."""
    square = rate * rate + 2.0 * curvature * y
    if square < 0.0:
        return NEVER
    root = math.sqrt(square)
    if root < SQUARE_UNDERFLOW and y >= 0.0 and curvature > 0.0:
        root = math.hypot(rate, math.sqrt(2.0 * curvature) * math.sqrt(y))
    if rate > 0.0:
        return (rate + root) / curvature if curvature > 0.0 else NEVER
    if root > rate:
        return 2.0 * y / (root - rate)
    return 0.0 if curvature > 0.0 else NEVER


@inlined
def is_monotone_to_zero(y, rate, curvature, bound, growth):
    """Return whether a function provably decreases to zero within 1.5 quadratic Taylor roots.

    Parameters as in `safe_step`; the value may be below zero, which returns False.
    """
    if not rate < 0.0 < y:
        return False
    far = monotone_reach(y, rate, curvature)
    rise = max(curvature, 0.0) + (0.5 * bound + growth * far / 6.0) * far
    return -rate >= MONOTONE_FACTOR * rise * far


@inlined
def monotone_reach(y, rate, curvature):
    """Return the time within which a function has its root by `is_monotone_to_zero`."""
    return 1.5 * parabola_root(y, rate, -curvature)


@inlined
def cubic_taylor_root(y, rate, curvature, third):
    """Return the root of y + rate h + curvature h²/2 + third h³/6.

    It is one Newton step from that of the quadratic part.
    """
    h = parabola_root(y, rate, -curvature)
    return h - h * h * h * third / (6.0 * rate + (6.0 * curvature + 3.0 * third * h) * h)


@inlined
def has_converged(h, rate, fourth, s):
    """Return whether the error of the cubic, at most fourth·h⁴/24, is below rounding."""
    return fourth * h * h * h * h <= -24.0 * rate * RESOLUTION * s or h == 0.0


# Any linear observable under waves.


class Observable(NamedTuple):
    """Linear observable y = x (x_r - x_0) + v v_r + load N + rate N' + constant + slope s.

    Attributes
    ----------
    x_0 : float
        Origin of x_r [m].
    x, v : float
        Coefficients of x_r and v_r.
    load, rate : float
        Coefficients of the relative normal force N and of its derivative.
    constant, slope : float
        Value at the start of the segment, and derivative, of a part that changes linearly.
    """

    x_0: float
    x: float
    v: float
    load: float
    rate: float
    constant: float
    slope: float


class Derivatives(NamedTuple):
    """Value and first three derivatives of an observable at one time."""

    value: float
    rate: float
    curvature: float
    third_rate: float


@compiled
def first_stop(segment, waves, law, d, h):
    """Return the first time up to h at which v_r is zero, or infinity, and x_r there.

    Returns also the least |v_r| at which the mass turned to faster motion before [m/s], or
    infinity. `d` is the direction of motion; 0 for a mass that does not move. Other parameters
    as in `first_root`.
    """
    equation, x_r, v_r, a, _, _ = segment
    if d == 0:
        return NEVER, x_r, NEVER
    if waves.size == 0:
        c, w, _, r = equation
        s, low = locate_stop(c, w, d * v_r, d * a, d * r, h), NEVER
        if s == NEVER:
            low = lowest_speed(c, w, d * v_r, d * a, d * r, h)
        return s, motion_at(equation, waves, x_r, v_r, min(s, h)).x_r, low
    speed = Observable(0.0, 0.0, float(d), 0.0, 0.0, 0.0, 0.0)
    s, x_r, _, low = first_root(segment, waves, law, speed, int(ZERO), h)
    return s, x_r, low


@compiled
def first_root(segment, waves, law, observable, zeros, h):
    """Return the first time before h at which an observable is zero, and the state.

    Parameters
    ----------
    segment : Segment
    waves : Waves
        After `set_phases` at its start.
    law
        The law that has the normal force.
    observable : Observable
        At least zero at first, up to rounding; a root is where it is no longer above zero.
    zeros : int
        How many of the value and its first two derivatives are exactly zero at the start of the
        segment: 0 to 3. Their computed values would be rounding only.
    h : float
        Length of the segment [s].

    Returns
    -------
    s, x_r, v_r, low : float
        Time [s], infinite if the observable stays above zero; the state at that time; and the
        least minimum of the observable before, infinite for none. Close to zero it is known to
        first order in the root of its height.
    """
    equation, x_r, v_r = segment.equation, segment.x_r, segment.v_r
    c, w, _, r = equation
    # Largest growth of the third derivative; contribution of the normal force to it.
    _, second, third, max_omega = force_rate_bounds(waves, r)
    growth = abs(observable.x) * second + abs(observable.v) * third
    load_bound = (
        law.variation * (abs(observable.load) + abs(observable.rate) * law.omega) * law.omega**3
    )
    max_step = min(MAX_STEP_RADIANS / max_omega, h) if max_omega > 0.0 else h
    s, now = 0.0, Motion(x_r, v_r, segment.a, segment.j, segment.k)
    derivatives = observable_derivatives(law, waves, observable, s, now)
    value, rate, curvature, third_rate = derivatives
    value = 0.0 if zeros > 0 else max(value, 0.0)
    derivatives = Derivatives(value, 0.0 if zeros > 1 else rate, curvature, third_rate)
    if zeros > 2:
        # Positive up to 4·third_rate/fourth, with a bound on the fourth derivative that grows
        # by less than a quarter within the step.
        third_bound = third_derivative_bound(observable, w, load_bound, now)
        fourth = (c + math.sqrt(w)) * third_bound + growth + load_bound * law.omega
        step = min(0.25 * third_rate / fourth, max_step) if fourth > 0.0 else max_step
        if third_rate <= 0.0:
            return s, now.x_r, now.v_r, NEVER
        s = step
        now = motion_at(equation, waves, x_r, v_r, s)
        derivatives = observable_derivatives(law, waves, observable, s, now)
    elif value == rate == curvature == third_rate == 0.0 and max_omega > 0.0:
        # It leaves zero too slowly for the derivatives to tell on which side.
        s = min(quiet_time(waves, equation), h)
        now = motion_at(equation, waves, x_r, v_r, s)
        derivatives = observable_derivatives(law, waves, observable, s, now)
        if derivatives.value <= 0.0:
            return 0.0, x_r, v_r, NEVER
    third_bound = third_derivative_bound(observable, w, load_bound, now)
    low = NEVER
    if is_far_from_zero(derivatives, third_bound, growth, h):
        return NEVER, now.x_r, now.v_r, minimum_ahead(low, derivatives, h)
    while not is_monotone_to_zero(
        derivatives.value, derivatives.rate, derivatives.curvature, third_bound, growth
    ):
        value, rate, curvature, _ = derivatives
        step = safe_step(value, rate, curvature, third_bound, growth, max_step)
        if value > 0.0 and curvature > 0.0 and step < max_step:
            # The bound also holds without a positive curvature. Where that is tiny, this proves
            # a longer step; strongly damped motion would otherwise need a million steps.
            step = max(step, safe_step(value, rate, 0.0, third_bound, growth, max_step))
        if step != 0.0 and s + step >= h:
            return NEVER, now.x_r, now.v_r, minimum_ahead(low, derivatives, h - s)
        if step <= RESOLUTION * s:
            return s, now.x_r, now.v_r, low
        s += step
        before = derivatives
        now = motion_at(equation, waves, x_r, v_r, s)
        derivatives = observable_derivatives(law, waves, observable, s, now)
        # A zero at which it rises has underflowed: the step was safe.
        if derivatives.value < 0.0 or derivatives.value == 0.0 >= derivatives.rate:
            return s, now.x_r, now.v_r, low
        if before.rate < 0.0 <= derivatives.rate:
            low = min(low, minimum_between(before, derivatives))
        third_bound = third_derivative_bound(observable, w, load_bound, now)
    x, v, a, j, k = now
    # The observable decreases monotonically to its root: Newton's method cannot skip another.
    begin, at_begin = s, derivatives
    for _ in range(MAX_NEWTON_ROUNDS):
        value, rate, curvature, third_rate = derivatives
        step = cubic_taylor_root(value, rate, curvature, third_rate)
        third_bound += growth * abs(step)
        fourth = (c + math.sqrt(w)) * third_bound + growth + load_bound * law.omega
        s += step
        if has_converged(step, rate, fourth, s):
            x += step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            v += step * (a + step * (0.5 * j + step * k / 6.0))
            return (s, x, v, low) if s < h else (NEVER, x, v, low)
        now = motion_at(equation, waves, x_r, v_r, s)
        x, v, a, j, k = now
        derivatives = observable_derivatives(law, waves, observable, s, now)
        third_bound = third_derivative_bound(observable, w, load_bound, now)
    end = begin + monotone_reach(at_begin.value, at_begin.rate, at_begin.curvature)
    s, x, v = bracketed_root(segment, waves, law, observable, begin, end)
    return (s, x, v, low) if s < h else (NEVER, x, v, low)


@compiled
def bracketed_root(segment, waves, law, observable, low, high):
    """Return when an observable that decreases through zero between two times does so, [s].

    Returns also x_r and v_r there. Other parameters as in `first_root`.
    """
    s = 0.5 * (low + high)
    for _ in range(MAX_BISECTIONS):
        now = motion_at(segment.equation, waves, segment.x_r, segment.v_r, s)
        derivatives = observable_derivatives(law, waves, observable, s, now)
        low, high, s, done = safeguarded_newton(
            low, high, s, derivatives.value, derivatives.rate
        )
        if done:
            break
    x_r, v_r, _, _, _ = motion_at(segment.equation, waves, segment.x_r, segment.v_r, s)
    return s, x_r, v_r


LOWEST_SHARE = 0.25
"""Least height of a minimum, as a share of the value nearby. Where a minimum is close to zero,
the steps are so short that the parabola through the nearer of their ends shows it."""


@inlined
def parabola_minimum(value, rate, curvature):
    """Return the minimum of a function nearby, from its value and two derivatives."""
    fall = 0.5 * rate * rate / curvature if curvature > 0.0 else 0.0
    return max(value - fall, LOWEST_SHARE * value)


@inlined
def minimum_between(before, after):
    """Return the minimum between two times at which an observable falls and rises."""
    value, rate, curvature, _ = before if before.value < after.value else after
    return parabola_minimum(value, rate, curvature)


@inlined
def minimum_ahead(low, now, h):
    """Return the smaller of `low` and a minimum of an observable within the next h [s]."""
    value, rate, curvature, _ = now
    if not (rate < 0.0 and -rate < curvature * h):
        return low
    return min(low, parabola_minimum(value, rate, curvature))


QUIET_RADIANS = 1e-2
"""Step after which it is seen where a mass moves that the waves leave at rest at first, in
radians of the fastest wave or oscillation. The motion within is below 1e-8 of that of the
base."""


@compiled
def quiet_time(waves, equation):
    """Return for how long a mass hardly moves whose first three derivatives vanish [s]."""
    rate = max(force_rate_bounds(waves, 0.0)[3], equation.c + math.sqrt(equation.w))
    return QUIET_RADIANS / rate


@inlined
def observable_derivatives(law, waves, observable, s, now):
    """Return the value and three derivatives of an observable."""
    x, v, a, j, k = now
    value = observable.x * (x - observable.x_0) + observable.v * v
    value += observable.constant + observable.slope * s
    rate = observable.x * v + observable.v * a + observable.slope
    curvature = observable.x * a + observable.v * j
    third_rate = observable.x * j + observable.v * k
    if observable.load != 0.0 or observable.rate != 0.0:
        load, load_d, load_dd = relative_normal_force(law, waves, s)
        square = law.omega * law.omega
        value += observable.load * load + observable.rate * load_d
        rate += observable.load * load_d + observable.rate * load_dd
        curvature += observable.load * load_dd - observable.rate * square * load_d
        third_rate -= square * (observable.load * load_d + observable.rate * load_dd)
    return Derivatives(value, rate, curvature, third_rate)


@inlined
def third_derivative_bound(observable, w, load_bound, now):
    """Return the bound on the third derivative of an observable at this time."""
    a, j, k = now.a, now.j, now.k
    third_bound = load_bound + abs(observable.x) * math.sqrt(j * j + w * a * a)
    return third_bound + abs(observable.v) * math.sqrt(k * k + w * j * j)


@inlined
def is_far_from_zero(derivatives, third_bound, growth, h):
    """Return whether an observable provably stays above zero for h [s]."""
    fall_rate = max(-derivatives.curvature, 0.0) + h * (third_bound + h * growth)
    return derivatives.value > h * (max(-derivatives.rate, 0.0) + h * fall_rate)


# Break-away under waves.

GRAZING_ANGLE = 1e-6
"""A zero of the margin this near to its minimum, in radians of the fastest wave, counts as a
touch from above: equality sticks."""

WINDOW_RADIANS = 32.0
"""Length of the first search window, in radians of the fastest wave: five of its periods, in
which most sticking contacts break away. The exit does not depend on it. Each later window is
twice as long as all before."""

RISING, FALLING = 1, -1
"""Sides on which F_L breaks the contact, passed by `int` as `compile.ZERO` is."""


class Stuck(NamedTuple):
    """A mass stuck to the base, and the limits at which F_L = m ü + F_k breaks the contact.

    Attributes
    ----------
    m, F_k : float
        Mass [kg], and force of the spring and of all else that is constant [N].
    u_0 : float
        ü without the waves at the start [m/s²].
    rising, falling : (float, float)
        Static limit [N] that F_L reaches by rising, or by falling; and the derivative of the
        part u_0 of ü [m/s³], less that of F_fs/m for rising, plus that for falling.
    variation, omega : float
        Of the limits, as in `CoulombLaw`.
    """

    m: float
    F_k: float
    u_0: float
    rising: tuple[float, float]
    falling: tuple[float, float]
    variation: float
    omega: float


@compiled
def break_away_time(stuck, waves, h):
    """Return when within h [s] a stuck mass breaks away, or infinity, and in which direction.

    Returns also the relative margin of the closest decision between sticking and breaking away
    until then [-], as in `stick_exit_time`.

    Both sides are searched window by window. A side that never breaks away is then not followed
    to the end of the segment each time the other side does.
    """
    rise, fall = stuck.rising[1], stuck.falling[1]
    max_omega = 0.0
    if not is_one_sine(waves, stuck.u_0, rise) or fall != 0.0:
        max_omega = force_rate_bounds(waves, 0.0)[3]
    begin, until = 0.0, min(WINDOW_RADIANS / max_omega, h) if max_omega > 0.0 else h
    margin = NEVER
    while True:
        up, above, near = stick_exit_time(stuck, waves, int(RISING), begin, until)
        down, below, _ = stick_exit_time(stuck, waves, int(FALLING), begin, min(up, until))
        if down < near and above < below:
            # What the other side comes close to later does not happen.
            _, above, _ = stick_exit_time(stuck, waves, int(RISING), begin, down)
        margin = min(margin, min(above, below))
        if up < NEVER or down < NEVER or until >= h:
            return (down, 1, margin) if down < up else (up, -1, margin)
        begin, until = until, min(3.0 * until, h)


@compiled
def stick_exit_time(stuck, waves, side, begin, h):
    """Return the first time in [begin, h] at which side·F_L exceeds F_fs, or infinity.

    A margin that only touches zero does not break away: equality sticks.

    Returns also the relative distance [-] of the extreme of F_L from the limit, by which the
    mass does not break away, or does, and the time [s] of the closest one. Under a base without
    waves the latter depends on the samples that follow, and is left out.
    """
    F_fs, slope = stuck.rising if side > 0 else stuck.falling
    if begin == 0.0 and is_one_sine(waves, stuck.u_0, slope):
        return one_sine_exit_time(stuck, waves, side, h)
    curvature = 0.0
    third = 0.0
    max_omega = 0.0
    for i in range(waves.size):
        A_i = abs(waves.values[WAVE_COLUMNS * i + A])
        force = stuck.m * A_i if i < waves.base else abs(F_fs) * stuck.variation
        omega = waves.values[WAVE_COLUMNS * i + OMEGA]
        curvature += force * omega**2
        third += force * omega**3
        max_omega = max(max_omega, omega)
    # Waves that cancel at the start do not tell times apart that are closer to it.
    radian = 1.0 / max_omega if max_omega > 0.0 else 0.0
    s, low, near, last, rate = begin, NEVER, begin, begin, 0.0
    while True:
        G, G_d, G_dd = break_away_margin(stuck, waves, side, s)
        if rate < 0.0 < G_d:
            margin = margin_between(stuck, waves, side, (last, rate), (s, G_d))
            low, near = (margin, s) if margin < low else (low, near)
        if G < 0.0:
            break
        if G > 0.0:
            step = parabola_root(G, G_d, curvature)
        elif curvature == 0.0:
            step = NEVER if G_d >= 0.0 else 0.0
        else:
            step = safe_step_from_zero(G_d, G_dd, curvature, third)
        if s + step > h:
            margin = margin_until(stuck, waves, side, (s, G, G_d, curvature), h)
            return NEVER, min(low, margin), h if margin < low else near
        if step <= RESOLUTION * max(s, radian):
            # A zero of the margin. If it grazes, test its minimum, and step away from it.
            if G_d == 0.0 and G_dd == 0.0 and max_omega > 0.0:
                step = QUIET_RADIANS / max_omega
            elif G_dd <= 0.0 or -G_d * max_omega > GRAZING_ANGLE * G_dd:
                break
            else:
                step = -G_d / G_dd
            low = 0.0
            if break_away_margin(stuck, waves, side, s + step)[0] < 0.0:
                break
            step += safe_step_from_zero(0.0, G_dd, curvature, third)
        last, rate = s, G_d
        s += step
    if waves.base > 0 and G_d < 0.0 < G_dd:
        excess = 0.5 * G_d * G_d / G_dd - G
        margin = relative_to_limit(stuck, waves, F_fs, s, -excess)
        low, near = (margin, s) if margin < low else (low, near)
    return s, low, near


NEAR_SHARE = 1e-2
"""Margin of force, as a share of the limit, below which the end of a segment is looked at."""


@compiled
def margin_until(stuck, waves, side, now, h):
    """Return the least relative margin from the last step of a search to its end, or infinity.

    `now` holds time [s], margin [N], its rate [N/s], and the bound on its curvature [N/s²].
    """
    s, G, G_d, curvature = now
    F_fs = stuck.rising[0] if side > 0 else stuck.falling[0]
    left = h - s
    if not left < NEVER:
        return NEVER
    G_h = G + G_d * left
    if curvature > 0.0:
        # Far from its limit, and where it only rises, the margin at the end says nothing.
        if G_d >= 0.0 and waves.base > 0:
            return NEVER
        if G_h - 0.5 * curvature * left * left > NEAR_SHARE * F_fs:
            return NEVER
        G_h, rate, _ = break_away_margin(stuck, waves, side, h)
        if G_d < 0.0 < rate:
            return margin_between(stuck, waves, side, (s, G_d), (h, rate))
    return relative_to_limit(stuck, waves, F_fs, h, max(G_h, 0.0))


@compiled
def margin_between(stuck, waves, side, first, last):
    """Return the least relative margin between two times, each with its rate [s, N/s].

    The margin falls at first and rises at last.
    """
    (begin, falls), (end, rises) = first, last
    s = begin + (end - begin) * (falls / (falls - rises))
    F_fs = stuck.rising[0] if side > 0 else stuck.falling[0]
    G = break_away_margin(stuck, waves, side, s)[0]
    return relative_to_limit(stuck, waves, F_fs, s, max(G, 0.0))


@inlined
def relative_to_limit(stuck, waves, F_fs, s, G):
    """Return the size of a margin of force at time s relative to F_fs or to a larger |F_L|.

    Infinite where nothing holds, or where F_L has no end, as in an extreme far away.
    """
    hold = F_fs * relative_normal_force(stuck, waves, s)[0]
    larger = hold - min(G, 0.0)
    return abs(G) / larger if 0.0 < larger < NEVER else NEVER


@compiled
def break_away_margin(stuck, waves, side, s):
    """Return the force that is missing for break-away on one side, with two derivatives.

    Parameters
    ----------
    side : int
        +1 where F_L breaks the contact by rising, -1 by falling.
    s : float
        Time since the start of the segment [s].

    Returns
    -------
    G, G_d, G_dd : float
        F_fs - side·F_L [N], [N/s], [N/s²], plus the rounding error of F_L. The mass has broken
        away where G < 0.

    Notes
    -----
    Eq. (9) of the paper.
    """
    F_fs, slope = stuck.rising if side > 0 else stuck.falling
    u_dd, rate, second_rate = base_motion(waves, stuck.u_0, slope, s)
    load, load_d, load_dd = relative_normal_force(stuck, waves, s)
    hold = F_fs * load
    return (
        stick_limit(hold, stuck.F_k) - side * (stuck.m * u_dd + stuck.F_k),
        F_fs * load_d - side * stuck.m * rate,
        F_fs * load_dd - side * stuck.m * second_rate,
    )


@inlined
def is_one_sine(waves, u_0, slope):
    """Return whether the base moves by a single sine and friction is constant."""
    return waves.size == 1 and waves.base == 1 and u_0 == 0.0 and slope == 0.0


@compiled
def one_sine_exit_time(stuck, waves, side, h):
    """Return `stick_exit_time` for a single sine, in closed form."""
    values, F_k = waves.values, stuck.F_k
    F_fs, _ = stuck.rising if side > 0 else stuck.falling
    force = side * stuck.m * values[A]
    level = stick_limit(F_fs, F_k) - side * F_k
    if force * values[SINE] > level:
        return 0.0, NEVER, 0.0
    excess = abs(force) - level
    theta = values[THETA] if force > 0.0 else values[THETA] + math.pi
    if excess <= 0.0:
        near = (0.5 * math.pi - theta) % (2.0 * math.pi) / values[OMEGA]
        if near > h:
            near, excess = h, abs(force) * math.sin(theta + values[OMEGA] * h) - level
        return NEVER, -excess / F_fs if F_fs > 0.0 else NEVER, near
    phase = (math.asin(level / abs(force)) - theta) % (2.0 * math.pi)
    # F_L rises and exceeds the limit by less than the rounding of the phase: now.
    if force * values[COSINE] > 0.0 and phase > math.pi:
        phase = 0.0
    s = phase / values[OMEGA]
    if s <= h:
        return s, excess / (F_fs + excess), s
    return NEVER, NEVER, h


@compiled
def safe_step_from_zero(rate, curvature, curvature_bound, third_bound):
    """Return a step up to which a function that is 0 at 0 is proved positive after 0.

    It is half the bound; 0 or less if the function does not increase.
    """
    by_rate = rate / curvature_bound if rate > 0.0 else 0.0
    by_curvature = 0.0
    if rate >= 0.0 and curvature > 0.0:
        by_curvature = 1.5 * curvature / third_bound if third_bound > 0.0 else NEVER
    return max(by_rate, by_curvature)


# First root of a power series.

MAX_SHORTENINGS = 6
"""Maximum number of reductions of the interval over which the curvature is bounded, before the
series is shifted. Each at least halves it; the geometric mean ends a fall by ten orders of
magnitude in five. The cap costs a shorter step, never a root."""


@compiled
def first_series_root(c, n, h):
    """Return the first time in [0, h] at which a power series decreases to zero, or infinity.

    Parameters
    ----------
    c : array of float
        Coefficients of s⁰ to sⁿ; overwritten.
    n : int
        Last term.
    h : float
        Length of the interval, above 0 [s].

    Notes
    -----
    A bound on the second derivative gives a step within which the series stays above zero. The
    series is then shifted to the end of the step, so that the bound is one of the rest. Zeros
    at s = 0 are divided out first. The search ends early where the value exceeds the sum of all
    |c_k| hᵏ with k > 0: the series cannot fall by more.
    """
    n = deflate(c, n)
    if n < 0:
        return NEVER
    rest, power = 0.0, h
    for k in range(1, n + 1):
        c[k] *= power
        rest += abs(c[k])
        power *= h
    s = 0.0
    while c[0] <= rest:
        if c[0] <= 0.0:
            return s * h
        step = safe_series_step(c, n, 1.0 - s)
        if s + step >= 1.0:
            return NEVER
        if step <= RESOLUTION * s:
            return s * h
        s += step
        taylor_shift(c, n, step)
    return NEVER


@inlined
def deflate(c, n):
    """Divide out zeros at s = 0; return the last term, which is below 0 if all are zero."""
    zeros = 0
    while zeros <= n and c[zeros] == 0.0:
        zeros += 1
    if zeros > 0 and zeros <= n:
        for k in range(n - zeros + 1):
            c[k] = c[k + zeros]
    return n - zeros


@inlined
def safe_series_step(c, n, left):
    """Return a step of a scaled series within which it provably stays above zero."""
    best = 0.0
    for _ in range(MAX_SHORTENINGS):
        curvature = 0.0
        power = 1.0
        for k in range(2, n + 1):
            curvature += k * (k - 1) * abs(c[k]) * power
            power *= left
        step = min(parabola_root(c[0], c[1] if n > 0 else 0.0, curvature), left)
        best = max(best, step)
        if step >= 0.5 * left:
            return best
        # If the step is shorter by orders of magnitude, halving takes too long: use the
        # geometric mean.
        left = min(0.5 * left, math.sqrt(step) * math.sqrt(left))
    return best


@inlined
def taylor_shift(c, n, step):
    """Shift the origin of a series to `step`."""
    for i in range(n):
        for k in range(n - 1, i - 1, -1):
            c[k] += step * c[k + 1]
