"""When a sliding mass stops, a stuck one breaks away, a contact opens: first roots, guaranteed.

Problem
    Within a segment the motion is smooth, and an observable starts at or above zero: a
    velocity, the force still missing for break-away, what a contact may still bear, the force
    of a bumper. Find the *first* time at which it reaches zero. Looking for a change of sign
    between samples is not enough: two roots may lie between them.

Method
    1. The force changes linearly (`locate_stop`): the acceleration obeys the free equation, so
       the extrema of the velocity are known in closed form; between them it is monotone.
    2. Waves act (`slip_exit_time` for v_r, `first_root` for any `Observable` of x_r, v_r and normal force):
       a Taylor polynomial less a bound on its remainder lies below the observable. The first
       root of the polynomial is a step that cannot skip a root of the observable (`safe_step`).
       Step there and repeat: the root is approached from one side, and a near miss is passed at
       its own distance. Once the bound proves that the observable only falls until it is below
       zero (`is_monotone_to_zero`), Newton's method on the cubic has nothing to miss.
    3. The mass sticks under waves (`break_away_time`): such steps by a bound on the curvature.
    4. A power series is given (`first_series_root`): such steps too; the series is moved along.
    5. A step is far shorter than the times of the oscillator (`next_stop`, `next_crossing`):
       the cubic through both ends guesses; the closed form at the guess, and the series about
       that point, leave rounding only. What they do not settle takes the general way.

Bound
    The jerk j obeys the oscillator's equation driven by the second rate of the force, so that
    |j|(s) <= sqrt(j² + w a²) + s·max|second rate|, and likewise one rate higher.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compile import compiled, inlined
from drysim.core.events import FORCE_ROUNDING
from drysim.core.forcing import (
    COSINE,
    OMEGA,
    SINE,
    THETA,
    WAVE_COLUMNS,
    A,
    break_away_margin,
    force_rate_bounds,
    motion_and_snap_at,
    relative_normal_force,
)
from drysim.core.oscillator import flow, flow_within_step

NEVER = math.inf

RESOLUTION = 4e-16
"""Relative step below which a root is as sharp as double precision makes it."""

MAX_BISECTIONS = 100
"""Newton needs about 4 rounds; a halved bracket is down to one float after 60."""


@inlined
def keep_in_bracket(low, high, s):
    """Return a guess of a root that lies between two bounds, else the middle of them.

    What is not between them then, either, is next to `high`: one float is left.
    """
    return s if low < s < high else 0.5 * (low + high)


# A velocity under linearly changing force.


@compiled
def locate_stop(c, w, v, a, r, h):
    """Return the first time in (0, h] at which a velocity above zero is zero again.

    Parameters
    ----------
    c, w : float
        As in `flow`.
    v, a, r : float
        Velocity in the direction of sliding [m/s], at least 0, and its rate [m/s²] at time 0;
        rate of the force per mass [m/s³].
    h : float
        Length of the segment [s].

    Returns
    -------
    float
        Time [s], or infinity when the velocity stays above zero.

    Notes
    -----
    No stop is missed: every falling part between extrema is looked at in turn. A velocity
    that just touches zero has stopped. One that decays for so long that it underflows has not.
    """
    if (v > 0.0 or a > 0.0) and never_stops(c, w, v, a, r):
        return NEVER
    j = r - c * a - w * v
    end = first_extremum(c, w, a, j)
    square = w - 0.25 * c * c
    gap = math.pi / math.sqrt(square) if square > 0.0 else NEVER  # between neighbouring extrema
    begin = 0.0
    if a > 0.0 or (a == 0.0 and j > 0.0):
        begin = end
        end = begin + gap
    while begin < h:
        until = min(end, h)
        if velocity_and_acceleration(c, w, v, a, r, until)[0] <= 0.0:
            return bracketed_newton(c, w, v, a, r, begin, until)
        begin = end + gap
        end = begin + gap
    return NEVER


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
def first_extremum(c, w, a, j):
    """Return the first time above 0 [s] at which the acceleration vanishes, or infinity.

    `a` and `j` are acceleration [m/s²] and jerk [m/s³] at time 0.
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
def velocity_and_acceleration(c, w, v, a, r, s):
    """Return velocity and acceleration at time s from those at time 0.

    A motion that dies away keeps its sign: where r = 0 nothing is subtracted from the rest of
    it.
    """
    y, y_d, Y, _ = flow(c, w, s)
    return v * y_d + (a + c * v) * y + r * Y, a * y_d + (r - w * v) * y


@compiled
def bracketed_newton(c, w, v, a, r, lo, hi):
    """Return the zero of a velocity that falls once from lo to hi: guarded Newton."""
    s = hi
    if lo == 0.0 and a < 0.0:
        # Where the parabola through the start meets zero.
        square = a * a - 2.0 * v * (r - c * a - w * v)
        if square >= 0.0:
            s = min(2.0 * v / (-a + math.sqrt(square)), hi)
    for _ in range(MAX_BISECTIONS):
        value, slope = velocity_and_acceleration(c, w, v, a, r, s)
        if value > 0.0:
            lo = s
        elif value < 0.0:
            hi = s
        else:
            return s
        step = -value / slope if slope < 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s = keep_in_bracket(lo, hi, s + step)
        if not lo < s < hi:
            return hi
    return s


# Safe steps, and Newton's method where it has nothing to miss.

MONOTONE_FACTOR = 3.0
"""A slope this many times what it may lose up to 1.5 times the zero of its parabola leads below
zero on the way."""

MAX_NEWTON_ROUNDS = 20
"""The cubic errs in the fourth order: 2 rounds do, as none is allowed to turn back."""

MAX_STEP_RADIANS = 2.0
"""Radians of the fastest wave that are tried at once: the bound never proves more."""

SMALL_STEP_SHARE = 0.01
"""Share of the longest step below which a step is tried without the jerk, too."""

MAX_HALVINGS = 60
"""Of the longest step at most: where a slow wave drags the mass along, the bound may leave a
millionth of it."""


@inlined
def safe_step(v, a, j, snap, growth, max_step):
    """Return a step within which a velocity provably stays above zero.

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
        rises = min(2.0 * j / divisor, max_step) if divisor > 0.0 else max_step
        return rises if a >= 0.0 else min(rises, -v / a)
    behind = min(parabola_root(v, a, -j), max_step)
    low = lower_envelope(v, a, j, third, twelfth, behind)
    if low > 0.0:
        return behind
    for _ in range(MAX_HALVINGS):
        before = 0.5 * behind
        high = lower_envelope(v, a, j, third, twelfth, before)
        if high > 0.0:
            return before + (behind - before) * high / (high - min(low, 0.0))
        behind, low = before, high
    return min(behind, parabola_root(v, a, (third + twelfth * behind) * behind - j))


@inlined
def lower_envelope(v, a, j, third, twelfth, h):
    """Return the lower bound P of `safe_step` after a time h."""
    return v + h * (a + 0.5 * h * (j - h * (third + twelfth * h)))


@inlined
def parabola_root(v, a, curvature):
    """Return the largest h up to which v + a h - bend h²/2, not below zero, stays so."""
    square = a * a + 2.0 * curvature * v
    if square < 0.0:
        return NEVER
    root = math.sqrt(square)
    if a > 0.0:
        return (a + root) / curvature if curvature > 0.0 else NEVER
    if root > a:
        return 2.0 * v / (root - a)
    return 0.0 if curvature > 0.0 else NEVER


@inlined
def is_monotone_to_zero(v, a, j, snap, growth):
    """Return whether a velocity falls below zero within 1.5 times the zero of its parabola.

    It does not rise on the way.

    Parameters as in `safe_step`; the velocity may be below zero.
    """
    if not a < 0.0 < v:
        return False
    far = 1.5 * quadratic_taylor_root(v, a, j)
    return -a >= MONOTONE_FACTOR * (max(j, 0.0) + (0.5 * snap + growth * far / 6.0) * far) * far


@inlined
def quadratic_taylor_root(v, a, j):
    """Return the time at which v + a h + j h²/2, falling, is zero; infinity for none."""
    square = a * a - 2.0 * v * j
    return 2.0 * v / (math.sqrt(square) - a) if square > 0.0 else NEVER


@inlined
def cubic_taylor_root(v, a, j, k):
    """Return what `quadratic_taylor_root` does with k h³/6 besides, to within a round of Newton's."""
    h = quadratic_taylor_root(v, a, j)
    return h - h * h * h * k / (6.0 * a + (6.0 * j + 3.0 * k * h) * h)


@inlined
def has_converged(h, a, fourth, s):
    """Return whether a zero is sharp: the cubic errs after h by fourth h⁴/24 at most."""
    return fourth * h * h * h * h <= -24.0 * a * RESOLUTION * s or h == 0.0


# A velocity under waves.


@inlined
def slip_exit_time(c, w, waves, x_r, v_r, a, j, g, r, d, h):
    """Return the first time in (0, h] at which sliding in direction d stops, and x_r there.

    The time is infinite where nothing stops. It is the root of `first_root` for v_r alone, in fewer
    operations.
    """
    moves = d * v_r > 0.0 or d * a > 0.0
    if waves.size == 0 and moves and never_stops(c, w, d * v_r, d * a, d * r):
        return NEVER, x_r
    growth = 0.0
    max_omega = 0.0
    k = -c * j - w * a
    for i in range(waves.size):
        at = WAVE_COLUMNS * i
        omega = waves.values[at + OMEGA]
        curvature = waves.values[at + A] * omega * omega
        growth += abs(curvature) * omega
        k += curvature * waves.values[at + SINE]
        max_omega = max(max_omega, omega)
    max_step = min(MAX_STEP_RADIANS / max_omega, h) if max_omega > 0.0 else h
    s, x = 0.0, x_r
    v, a, j, k = d * v_r, d * a, d * j, d * k
    while True:
        snap = math.sqrt(k * k + w * j * j)
        if is_monotone_to_zero(v, a, j, snap, growth):
            break
        step = safe_step(v, a, j, snap, growth, max_step)
        if j > 0.0 and step < SMALL_STEP_SHARE * max_step:
            # A jerk that is next to nothing proves less than one that is left out: what is
            # strongly damped would take a million steps.
            step = max(step, safe_step(v, a, 0.0, snap, growth, max_step))
        if s + step >= h:
            # The end of the segment lies within the safe step.
            return NEVER, x
        if step <= RESOLUTION * s:
            return s, x
        s += step
        x, v, a, j, k = motion_and_snap_at(c, w, waves, x_r, v_r, g, r, s)
        v, a, j, k = d * v, d * a, d * j, d * k
        if v <= 0.0:
            return s, x
    for _ in range(MAX_NEWTON_ROUNDS):
        step = cubic_taylor_root(v, a, j, k)
        snap = math.sqrt(k * k + w * j * j) + growth * abs(step)
        fourth = (c + math.sqrt(w)) * snap + growth
        s += step
        if has_converged(step, a, fourth, s):
            x += d * step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            break
        x, v, a, j, k = motion_and_snap_at(c, w, waves, x_r, v_r, g, r, s)
        v, a, j, k = d * v, d * a, d * j, d * k
    return (s, x) if s < h else (NEVER, x)


# Any linear observable under waves.


class Observable(NamedTuple):
    """The sum x (x_r - x_0) + v v_r + load N + rate N', N the normal force and N' its rate.

    Attributes
    ----------
    x_0 : float
        Where x_r counts from [m].
    x, v : float
        Shares of x_r and v_r.
    load, rate : float
        Shares of the normal force relative to its mean, and of its rate.
    """

    x_0: float
    x: float
    v: float
    load: float
    rate: float


class InstantState(NamedTuple):
    """A time of a segment [s], and the motion then as `motion_and_snap_at` gives it."""

    s: float
    x_r: float
    v_r: float
    a: float
    j: float
    k: float


class Derivatives(NamedTuple):
    """A blend at an instant, and its first three rates."""

    value: float
    rate: float
    curvature: float
    third_rate: float


@compiled
def first_root(segment, waves, law, observable, zeros, begin, h):
    """Return the first time in [begin, h] at which a blend is not above zero, and the state.

    Parameters
    ----------
    stretch : Stretch
    waves : Waves
        Anchored at its start.
    law
        Whose normal force it is.
    blend : Blend
        What is at least zero at the start, roundings apart.
    zeros : int
        What is zero exactly at the start of the segment: 1 the blend, 2 its rate as well.
    begin, h : float
        Time of the segment to begin at, and its length [s].

    Returns
    -------
    s, x_r, v_r : float
        Time [s], infinite where the blend stays above zero, and the state then.
    """
    w = segment.w
    # The third rate of the blend grows so fast at most; the normal force adds so much to it.
    _, second, third, max_omega = force_rate_bounds(waves, segment.r)
    growth = abs(observable.x) * second + abs(observable.v) * third
    load_bound = (
        law.variation * (abs(observable.load) + abs(observable.rate) * law.omega) * law.omega**3
    )
    max_step = min(MAX_STEP_RADIANS / max_omega, h) if max_omega > 0.0 else h
    if begin == 0.0:
        now = InstantState(0.0, segment.x_r, segment.v_r, segment.a, segment.j, segment.k)
        value, rate, curvature, third_rate = observable_derivatives(law, waves, observable, now)
        value = 0.0 if zeros > 0 else max(value, 0.0)
        derivatives = Derivatives(value, 0.0 if zeros > 1 else rate, curvature, third_rate)
    else:
        now = instant_state(segment, waves, begin)
        derivatives = observable_derivatives(law, waves, observable, now)
        if derivatives.value <= 0.0:
            return now.s, now.x_r, now.v_r
    third_bound = third_derivative_bound(observable, w, load_bound, now)
    if is_far_from_zero(derivatives, third_bound, growth, h - begin):
        return NEVER, now.x_r, now.v_r
    while not is_monotone_to_zero(
        derivatives.value, derivatives.rate, derivatives.curvature, third_bound, growth
    ):
        value, rate, curvature, _ = derivatives
        step = safe_step(value, rate, curvature, third_bound, growth, max_step)
        if value > 0.0 and curvature > 0.0 and step < max_step:
            # Where it hardly bends upwards, what it bends is better left out.
            step = max(step, safe_step(value, rate, 0.0, third_bound, growth, max_step))
        if step != 0.0 and now.s + step >= h:
            return NEVER, now.x_r, now.v_r
        if step <= RESOLUTION * now.s:
            return now.s, now.x_r, now.v_r
        now = instant_state(segment, waves, now.s + step)
        derivatives = observable_derivatives(law, waves, observable, now)
        if derivatives.value <= 0.0:
            return now.s, now.x_r, now.v_r
        third_bound = third_derivative_bound(observable, w, load_bound, now)
    s, x, v, a, j, k = now
    for _ in range(MAX_NEWTON_ROUNDS):
        value, rate, curvature, third_rate = derivatives
        step = cubic_taylor_root(value, rate, curvature, third_rate)
        third_bound += growth * abs(step)
        fourth = (segment.c + math.sqrt(w)) * third_bound + growth + load_bound * law.omega
        s += step
        if has_converged(step, rate, fourth, s):
            x += step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            v += step * (a + step * (0.5 * j + step * k / 6.0))
            break
        now = instant_state(segment, waves, s)
        s, x, v, a, j, k = now
        derivatives = observable_derivatives(law, waves, observable, now)
        third_bound = third_derivative_bound(observable, w, load_bound, now)
    return (s, x, v) if s < h else (NEVER, x, v)


@inlined
def instant_state(segment, waves, s):
    """Return the motion at time s of a segment."""
    c, w, x_r, v_r, _, _, _, g, r = segment
    x, v, a, j, k = motion_and_snap_at(c, w, waves, x_r, v_r, g, r, s)
    return InstantState(s, x, v, a, j, k)


@inlined
def observable_derivatives(law, waves, observable, now):
    """Return a blend at an instant of a segment."""
    s, x, v, a, j, k = now
    value, rate = (
        observable.x * (x - observable.x_0) + observable.v * v,
        observable.x * v + observable.v * a,
    )
    curvature, third_rate = (
        observable.x * a + observable.v * j,
        observable.x * j + observable.v * k,
    )
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
    """Return a bound of the third rate of a blend, up to what its growth adds."""
    a, j, k = now.a, now.j, now.k
    third_bound = load_bound + abs(observable.x) * math.sqrt(j * j + w * a * a)
    return third_bound + abs(observable.v) * math.sqrt(k * k + w * j * j)


@inlined
def is_far_from_zero(derivatives, third_bound, growth, h):
    """Return whether a blend is above zero for h [s] to come, as in most steps of a record."""
    loses = max(-derivatives.curvature, 0.0) + h * (third_bound + h * growth)
    return derivatives.value > h * (max(-derivatives.rate, 0.0) + h * loses)


# Break-away under waves.

GRAZING_ANGLE = 1e-6
"""A zero margin this near to its minimum, in radians of the fastest wave, only touches."""

WINDOW_RADIANS = 32.0
"""Radians of the fastest wave within which either side is looked at first."""

SQUARE_UNDERFLOW = 1e-140
"""Below this, squares lose digits to the end of double precision."""


@inlined
def break_away_time(plant, law, waves, x_r, u_0, rise, fall, h):
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
    max_omega = 0.0
    if not is_one_sine(waves, u_0, rise) or fall != 0.0:
        max_omega = force_rate_bounds(waves, 0.0)[3]
    begin, until = 0.0, min(WINDOW_RADIANS / max_omega, h) if max_omega > 0.0 else h
    while True:
        up = stick_exit_time(plant, law, waves, x_r, u_0, rise, 1, begin, until)
        down = stick_exit_time(plant, law, waves, x_r, u_0, fall, -1, begin, min(up, until))
        if up < NEVER or down < NEVER or until >= h:
            return (down, 1) if down < up else (up, -1)
        begin, until = until, min(3.0 * until, h)


@inlined
def stick_exit_time(plant, law, waves, x_r, u_0, slope, side, begin, h):
    """Return the first time in [begin, h] when |F_L| exceeds F_fs on one side, or infinity.

    A margin that only touches zero does not break away: equality sticks.
    """
    if begin == 0.0 and is_one_sine(waves, u_0, slope):
        return one_sine_exit_time(plant, law, waves, x_r, side, h)
    curvature = 0.0
    third = 0.0
    max_omega = 0.0
    for i in range(waves.size):
        A_i = abs(waves.values[WAVE_COLUMNS * i + A])
        force = plant.m * A_i if i < waves.base else law.F_fs * law.variation
        omega = waves.values[WAVE_COLUMNS * i + OMEGA]
        curvature += force * omega**2
        third += force * omega**3
        max_omega = max(max_omega, omega)
    s = begin
    while True:
        G, G_d, G_dd = break_away_margin(plant, law, waves, x_r, u_0, slope, side, s)
        if G < 0.0:
            return s
        if G > 0.0:
            step = concave_parabola_root(G, G_d, curvature)
        elif curvature == 0.0:
            step = NEVER if G_d >= 0.0 else 0.0
        else:
            step = step_off_zero(G_d, G_dd, curvature, third)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            if G_dd <= 0.0 or -G_d * max_omega > GRAZING_ANGLE * G_dd:
                return s
            step = -G_d / G_dd
            if break_away_margin(plant, law, waves, x_r, u_0, slope, side, s + step)[0] < 0.0:
                return s
            step += step_off_zero(0.0, G_dd, curvature, third)
        s += step


@inlined
def is_one_sine(waves, u_0, slope):
    """Return whether one sine alone moves the base."""
    return waves.size == 1 and waves.base == 1 and u_0 == 0.0 and slope == 0.0


@inlined
def one_sine_exit_time(plant, law, waves, x_r, side, h):
    """Return what `stick_exit_time` does where one sine moves the base: its inverse."""
    values = waves.values
    F_k, force = plant.k_x * x_r, side * plant.m * values[A]
    level = law.F_fs + FORCE_ROUNDING * (law.F_fs + abs(F_k)) - side * F_k
    if force * values[SINE] > level:
        return 0.0
    if abs(force) <= level:
        return NEVER
    theta = values[THETA] if force > 0.0 else values[THETA] + math.pi
    phase = (math.asin(level / abs(force)) - theta) % (2.0 * math.pi)
    # Rising, and beyond the limit by less than the rounding of an angle.
    if force * values[COSINE] > 0.0 and phase > math.pi:
        phase = 0.0
    s = phase / values[OMEGA]
    return s if s <= h else NEVER


@compiled
def concave_parabola_root(value, rate, curvature):
    """Return the largest h up to which value + rate h - bend h²/2, bend >= 0, is above zero."""
    root = math.sqrt(rate * rate + 2.0 * curvature * value)
    if root < SQUARE_UNDERFLOW and value > 0.0:
        root = math.hypot(rate, math.sqrt(2.0 * curvature) * math.sqrt(value))
    if rate <= 0.0:
        return 2.0 * value / (root - rate) if root > rate else NEVER
    return (rate + root) / curvature if curvature > 0.0 else NEVER


@compiled
def step_off_zero(rate, curvature, curvature_bound, third_bound):
    """Return a step that provably leaves zero upwards; 0 or less where the function falls."""
    by_rate = rate / curvature_bound if rate > 0.0 else 0.0
    by_curvature = 0.0
    if rate >= 0.0 and curvature > 0.0:
        by_curvature = 1.5 * curvature / third_bound if third_bound > 0.0 else NEVER
    return max(by_rate, by_curvature)


# A fine step over a spring contact: a stop, or the limit.

TAYLOR_RADIUS = 2e-4
"""Radians from a point within which four terms of the series about it are exact: the next is
below 1e-16."""

MAX_REFINE_ROUNDS = 6
"""One round does mostly; what has not settled after some takes the general way."""


@inlined
def next_stop(steps, v, a, r, h):
    """Return the first stop within h, or infinity, and the path until then or the end.

    Parameters
    ----------
    steps : Whole
    v, a, r, h : float
        As in `locate_stop`; h is a step at most.

    Returns
    -------
    stop, way, v_end : float
        Time [s]; distance [m] and velocity [m/s] then, or at the end.
    """
    y, y_d, _, _ = flow_within_step(steps, h)
    path, v_end = path_and_velocity(steps, v, a, r, h)
    a_end = a * y_d + (r - steps.w * v) * y
    if steps.fine:
        if v_end > 0.0 and (a >= 0.0 or a_end <= 0.0):
            return NEVER, path, v_end
        if v_end <= 0.0:
            stop, far = turning_point(steps, v, a, r, v_end, a_end, h)
            if stop > 0.0:
                return stop, far, 0.0
    stop = locate_stop(steps.c, steps.w, v, a, r, h)
    if stop == NEVER:
        return NEVER, path, max(v_end, 0.0)
    return stop, path_and_velocity(steps, v, a, r, stop)[0], 0.0


@inlined
def turning_point(steps, v, a, r, v_end, a_end, h):
    """Return when a velocity above zero that does not end above it is zero, and the path then.

    Parameters as in `next_stop`, of fine steps, with velocity and acceleration at the end. The
    time is negative where the guess was not good.
    """
    s, path, _ = refine_root(steps, v, a, r, 0.0, False, hermite_root(v, a, v_end, a_end, h))
    return (s, path) if 0.0 < s <= h else (-1.0, 0.0)


@inlined
def next_crossing(steps, v, a, r, gap, path, v_end, h):
    """Return when a mass that does not stop before h [s] has moved by `gap` [m], and v then.

    `path` and `v_end` are those at h, and `path` is not less than `gap`.
    """
    s = hermite_root(gap, -v, gap - path, -v_end, h)
    s, _, v_s = refine_root(steps, v, a, r, gap, True, s)
    if not 0.0 < s <= h:
        s = min(crossing_time(steps.c, steps.w, v, a, r, gap, h), h)
        v_s = path_and_velocity(steps, v, a, r, s)[1]
    return s, max(v_s, 0.0)


@compiled
def crossing_time(c, w, v, a, r, gap, h):
    """Return the time in (0, h] at which a mass has moved by `gap` [m], or infinity.

    The other parameters are as in `locate_stop`; the velocity keeps its sign up to h.
    """
    y, _, Y, YY = flow(c, w, h)
    p = a + c * v
    if v * y + p * Y + r * YY <= gap:
        return NEVER
    low, high = 0.0, h
    s = gap / v if 0.0 < gap < v * h else 0.5 * h
    for _ in range(MAX_BISECTIONS):
        y, y_d, Y, YY = flow(c, w, s)
        excess = v * y + p * Y + r * YY - gap
        low, high = (low, s) if excess > 0.0 else (s, high)
        speed = v * y_d + p * y + r * Y
        step = -excess / speed if speed > 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s = keep_in_bracket(low, high, s + step)
        if not low < s < high:
            return high
    return s


@inlined
def hermite_root(value, rate, value_end, rate_end, h):
    """Return where the cubic through both ends of a segment falls to zero from above."""
    per_h = 1.0 / h
    curvature = (value_end - value - rate * h) * per_h * per_h
    root = math.sqrt(max(rate * rate - 4.0 * curvature * value, 0.0))
    s = 2.0 * value / (root - rate) if rate < 0.0 else -0.5 * (rate + root) / curvature
    third_rate = (rate_end - rate - 2.0 * curvature * h) * per_h * per_h
    slope = rate + 2.0 * curvature * s + third_rate * s * (3.0 * s - 2.0 * h)
    return s - third_rate * s * s * (s - h) / slope if slope < 0.0 else s


@inlined
def refine_root(steps, v, a, r, gap, crossing, s):
    """Return the time of which s is a good guess, path and velocity; negative where it is not.

    What is looked for is the path `gap` [m] if `crossing`, else a stop. Parameters as in
    `next_stop`.
    """
    c, w = steps.c, steps.w
    p = a + c * v
    for _ in range(MAX_REFINE_ROUNDS):
        y, y_d, Y, YY = flow_within_step(steps, s)
        path = v * y + p * Y + r * YY
        v_s = v * y_d + p * y + r * Y
        a_s = a * y_d + (r - w * v) * y
        j_s = r - c * a_s - w * v_s
        k_s = -(c * j_s + w * a_s)
        value, rate, curvature, third_rate = v_s, a_s, j_s, k_s
        if crossing:
            value, rate, curvature, third_rate = path - gap, v_s, a_s, j_s
        step = -value / rate
        step -= (
            step
            * step
            * (0.5 * curvature + third_rate * step / 6.0)
            / (rate + curvature * step)
        )
        if abs(step) * steps.rate <= TAYLOR_RADIUS and abs(
            curvature * step
        ) <= TAYLOR_RADIUS * abs(rate):
            path += step * (v_s + step * (0.5 * a_s + step * j_s / 6.0))
            return s + step, path, v_s + step * (a_s + step * (0.5 * j_s + step * k_s / 6.0))
        s += step
        if not 0.0 < s <= steps.dt:
            break
    return -1.0, 0.0, 0.0


@inlined
def path_and_velocity(steps, v, a, r, s):
    """Return path and velocity at time s of a segment."""
    y, y_d, Y, YY = flow_within_step(steps, s)
    p = a + steps.c * v
    return v * y + p * Y + r * YY, v * y_d + p * y + r * Y


# The root of a power series.

MAX_SHORTENINGS = 6
"""Times at most that the stretch over which the curvature is bounded is made shorter, before
the series is moved."""


@compiled
def first_series_root(c, n, h):
    """Return the first time in [0, h] at which a series comes down to zero, or infinity.

    A bound on the curvature gives a step that is surely above zero; after it the series is
    moved there, so that its bounds are those of what is left. A zero at the beginning itself is
    divided out.

    Parameters
    ----------
    c : array of float
        Terms up to n; lost.
    n : int
        Last term.
    h : float
        Length looked at, above 0 [s].
    """
    n, zeros = deflate(c, n)
    if zeros < 0:
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
    """Divide out zeros at the beginning; returns the last term and how many, -1 for all."""
    zeros = 0
    while zeros <= n and c[zeros] == 0.0:
        zeros += 1
    if zeros > 0 and zeros <= n:
        for k in range(n - zeros + 1):
            c[k] = c[k + zeros]
    return n - zeros, (zeros if zeros <= n else -1)


@inlined
def safe_series_step(c, n, left):
    """Return a step of a scaled series within which it surely stays above zero."""
    best = 0.0
    for _ in range(MAX_SHORTENINGS):
        curvature = 0.0
        power = 1.0
        for k in range(2, n + 1):
            curvature += k * (k - 1) * abs(c[k]) * power
            power *= left
        step = min(concave_parabola_root(c[0], c[1] if n > 0 else 0.0, curvature), left)
        best = max(best, step)
        if step >= 0.5 * left:
            return best
        # Where the zero is nearer by many powers of ten, halves would never come to it.
        left = min(0.5 * left, math.sqrt(step) * math.sqrt(left))
    return best


@inlined
def taylor_shift(c, n, step):
    """Move a series to `step` after its beginning."""
    for i in range(n):
        for k in range(n - 1, i - 1, -1):
            c[k] += step * c[k + 1]
