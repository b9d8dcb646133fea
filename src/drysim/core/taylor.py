"""The motion under laws with a rate or a state of their own: Taylor series, one after another.

Stribeck, Dahl, LuGre and Leuven friction have no closed form. Every term of the motion's series
about one instant follows from those before it by sums of products, so a series costs little,
tells its own radius, and is the motion between the instants as well. `march_taylor` follows a motion
from series to series and keeps only where each begins; `evaluate_series` and `integrate_series` make it
anew from there.

Nothing is missed: the velocity's first zero in a step is reached from below, by steps that a
bound on the curvature proves safe; the ends of the branches of Leuven's bristles likewise (see
`drysim.core.dynamic_friction`). Where the last terms do not foresee the Stribeck curve, a step
ends early.

Stiff bristles: at stiffness σ_0 they settle within the distance F/σ_0. A series that resolves
this takes steps of some ten such distances, however smooth the motion. Once they have settled,
z is the solution of z = d g(v) (1 - w/v)/σ_0 with w its own rate: each round through this
equation is nearer by the ratio of the two times, and the series is as long as the slow motion
allows.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import compiled, inlined
from drysim.core.dynamic_friction import (
    AT_LIMIT,
    branch_exit,
    dynamic_force,
    excess_term,
    flat_speed,
    force_term,
    has_fractional_exponent,
    negligible_speed,
    next_branch,
    product_term,
    set_masing_slope,
    start_excess,
    stribeck_curve,
    update_branch,
)
from drysim.core.events import (
    FORCE_ROUNDING,
    LOG_RESERVE,
    REVERSAL,
    SLIP,
    limit_force,
    record_event,
    record_segment,
    sign,
)
from drysim.core.forcing import FREQUENCY, OMEGA, PHASE, WAVE_COLUMNS, A, set_phases
from drysim.core.model import LEUVEN, STRIBECK, CoulombLaw
from drysim.core.roots import NEVER, RESOLUTION, break_away_time, concave_parabola_root
from drysim.core.trajectory import (
    TWELVE_NODES,
    TWELVE_WEIGHTS,
    segment_base,
    segment_index,
    segment_window,
)

ORDER = 20
"""Terms of a series at most: near the least work for errors of rounding size."""

FLAT_MARGIN = 1.05
"""A series that begins nearer than this to the edge of the flat part foresees the rise."""


class TaylorSeries(NamedTuple):
    """Taylor coefficients about one instant as arrays (or lists), shape (ORDER + 2,).

    Attributes
    ----------
    x, v, z : array of float
        Of relative displacement [m], velocity [m/s] and deflection [m], each per s^n.
    u : array of float
        Of ü.
    F : array of float
        Of the friction force [N].
    s, g, p : array of float
        Work: exponent of the Stribeck curve, its terms n times each; its excess over F_fk; and
        |v| z over the curve, or under `LEUVEN` the deflecting force over the curve.
        The excess is held apart: far above v_s it is below the rounding of the curve.
    w : array of float
        Rate of the bristles' travel [m/s]; `LEUVEN` alone.
    square, share : array of float
        Powers of p; `LEUVEN` alone.
    scale : array of float
        Its first value is the greatest speed so far [m/s], the measure of what is small.
    slope : array of float
        Rise of the deflection per travel: slope[0] + slope[1] z; `LEUVEN` alone.
    turned : array of float
        Deflections at which the bristles turned and which they remember [m]; `LEUVEN` alone.
    branch : array of int
        How many those are, the direction of travel, and whether z is at its limit just now.
    """

    x: Any
    v: Any
    z: Any
    u: Any
    F: Any
    s: Any
    g: Any
    p: Any
    w: Any
    square: Any
    share: Any
    scale: Any
    slope: Any
    reversals: Any
    branch: Any


# The motion series after series, with every zero of the velocity.


CREEPING = 3
"""Besides the sign, the direction in a trail of a mass too slow for friction to have fallen."""

MAX_STALLED_STEPS = 100
"""Changes in a row without progress in time that put a scene at the end of double precision."""


@compiled
def march_taylor(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, z, d, series, segments, at, log, count,
    capacity,
):  # fmt: skip
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters
    ----------
    plant, law, waves : Plant, Dynamic, Waves
    u_dd : array, shape (samples,)
        Base acceleration besides the waves [m/s²], linear in between.
    dt : float
        Length of an interval [s].
    n, s : int, float
        Where to begin: the interval, and the time within it [s].
    h : float
        Length of the last interval [s], at most `dt`.
    end : int
        The last interval.
    x_r, v_r, z, d
        The state there, and the direction as in `Trail`.
    jet : Jet
        To work in.
    trail, at : Trail, int
        Where to write the steps, and how many are written.
    log, count : Log, int
        The same for events.
    capacity : int
        Length of both.

    Returns
    -------
    n, s, x_r, v_r, z, d, at, count
        As given; `count` is -1 where the time no longer moves on.
    """
    z_tolerance = law.tolerance * law.F_fs / law.sigma_0 if law.kind != STRIBECK else 0.0
    requested = NEVER
    stalled = 0
    time_scale = min(wave_time_scale(waves), plant_time_scale(plant))
    pause, wait = 0, 0
    while n <= end and at + LOG_RESERVE < capacity and count + LOG_RESERVE < capacity:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        if d == 0 and law.kind != STRIBECK:
            # Whoever rested without a cause to move may have one now, to either side.
            d = motion_direction_at(plant, law, waves, series, u_0, slope, t, x_r, v_r, z)
            if law.kind == LEUVEN and d != 0:
                update_branch(law, series, sign(d), v_r, z)
            if d != 0:
                F_L = limit_force(plant, x_r, series.u[0])
                count = record_event(log, count, n, s, REVERSAL * sign(d), x_r, F_L)
        at = record_segment(segments, at, n, s, x_r, v_r, z, d)
        left = length - s
        if d == 0 and law.kind == STRIBECK:
            horizon = min(left, wave_time_scale(waves))
            stay, side = stribeck_break_away(plant, law, waves, x_r, u_0, slope, t, horizon)
            s = length if min(stay, horizon) >= left else s + min(stay, horizon)
            if stay != NEVER:
                d = 2 * side
                F_L = -side * law.F_fs
                count = record_event(log, count, n, s, side * SLIP, x_r, F_L)
        else:
            set_forcing(series, waves, u_0, slope, t)
            if law.kind == LEUVEN:
                set_masing_slope(law, series)
                segments.rise[at - 1], segments.bend[at - 1] = series.slope[0], series.slope[1]
            direction = 1 if d >= 0 else -1
            v_tolerance = law.tolerance * series.scale[0]
            slow = negligible_speed(law, series)
            creeping = slow > 0.0 and direction * v_r <= slow
            last, step, iterations, pause, wait = begin_step(
                plant,
                law,
                series,
                d,
                x_r,
                v_r,
                z,
                creeping,
                left,
                min(left, time_scale),
                requested,
                v_tolerance,
                z_tolerance,
                pause,
                wait,
            )
            segments.terms[at - 1] = last
            if iterations > 0:
                segments.d[at - 1] = direction * (QUASI_STEADY + iterations)
            elif creeping and abs(d) != 2:
                segments.d[at - 1] = direction * CREEPING
            step, stop, end_of_branch, cause = step_extent(
                plant,
                law,
                series,
                last,
                direction,
                step,
                iterations > 0,
                creeping,
                slow,
                v_tolerance,
            )
            event = min(stop, end_of_branch)
            if slow > 0.0 and event == NEVER and step <= RESOLUTION * (t + step):
                event = stop = step
            no_progress = (
                min(event, step) <= RESOLUTION * (t + step) and min(event, step) < left
            )
            stalled = stalled + 1 if no_progress else 0
            if stalled > (0 if event == NEVER else MAX_STALLED_STEPS):
                return n, s, x_r, v_r, z, d, at, -1
            requested = 4.0 * step if step < left else NEVER
            step = min(event, step)
            s = length if step == left else min(s + step, length)
            x_r, v_r, z = series_state(series, last, step)
            series.scale[0] = max(series.scale[0], abs(v_r))
            d = direction if d != 0 else 0
            if law.kind == LEUVEN and step > 0.0:
                series.branch[AT_LIMIT] = 0
            if end_of_branch < stop:
                z = next_branch(law, series, cause, z)
            if stop <= end_of_branch and stop != NEVER:
                v_r = 0.0
                F_L = limit_force(plant, x_r, horner(series.u, ORDER, step))
                d = motion_direction_at(
                    plant,
                    law,
                    waves,
                    series,
                    u_dd[n] + slope * s,
                    slope,
                    n * dt + s,
                    x_r,
                    v_r,
                    z,
                )
                if law.kind == LEUVEN and d != 0:
                    update_branch(law, series, sign(d), 0.0, z)
                # Bristles never stick: a mass that rests on them has no event until it moves.
                if d != 0 or law.kind == STRIBECK:
                    count = record_event(log, count, n, s, REVERSAL * sign(d), x_r, F_L)
        if s >= length:
            n += 1
            s = 0.0
    return n, s, x_r, v_r, z, d, at, count


@compiled
def motion_direction_at(plant, law, waves, series, u_0, slope, t, x_r, v_r, z):
    """Return the direction of motion as in `Trail`: 0 for stuck or without a cause to move."""
    if v_r != 0.0:
        return sign(v_r)
    if law.kind == STRIBECK:
        set_forcing(series, waves, u_0, slope, t)
        F_L = limit_force(plant, x_r, series.u[0])
        hold = law.F_fs + FORCE_ROUNDING * (law.F_fs + abs(plant.k_x * x_r))
        return 0 if abs(F_L) <= hold else -sign(F_L)
    return bristle_start_direction(plant, law, waves, series, u_0, slope, t, x_r, z)


@compiled
def bristle_start_direction(plant, law, waves, series, u_0, slope, t, x_r, z):
    """Return the direction in which a mass at rest on bristles starts, as in `Trail`.

    It is 2 or -2 in equilibrium, from where ü moves the mass, and 0 where no term of ü does.
    """
    set_forcing(series, waves, u_0, slope, t)
    a = series.u[0] + (plant.k_x * x_r + law.sigma_0 * z) / plant.m
    if abs(a) > equilibrium_tolerance(plant, law, series, x_r, z):
        return -sign(a)
    for n in range(1, ORDER + 1):
        if series.u[n] != 0.0:
            return -2 * sign(series.u[n])
    return 0


@compiled
def equilibrium_tolerance(plant, law, series, x_r, z):
    """Return the acceleration [m/s²] up to which a mass at rest on bristles is in equilibrium.

    It is that of rounding; or that of a swing on the bristles whose speed may be neglected.
    Bristles near their limit give way without end, and no swing comes of it.
    """
    m, k_x, _ = plant
    pull = law.sigma_0 * abs(z)
    rounding = FORCE_ROUNDING * (abs(k_x * x_r) + pull) / m
    firm = max(1.0 - pull / law.F_fs, 0.0) * (1.0 - law.F_fs / law.F_h)
    swing = law.tolerance * series.scale[0] * math.sqrt((k_x + law.sigma_0 * firm) / m)
    return max(rounding, swing)


@compiled
def wave_time_scale(waves):
    """Give the longest step [s] of a stuck mass, within which a series knows the waves."""
    fastest = 0.0
    for i in range(waves.size):
        fastest = max(fastest, waves.values[WAVE_COLUMNS * i + OMEGA])
    return 1.0 / fastest if fastest > 0.0 else NEVER


@compiled
def plant_time_scale(plant):
    """Give the shortest time of the oscillator itself [s]."""
    rate = max(math.sqrt(plant.k_x / plant.m), plant.b / plant.m)
    return 1.0 / rate if rate > 0.0 else NEVER


@compiled
def stribeck_break_away(plant, law, waves, x_r, u_0, slope, t, h):
    """Give when a stuck mass breaks away within h [s], or infinity, and in which direction."""
    limits = CoulombLaw(law.F_fs, law.F_fs, 0.0, 0.0, 0.0)
    set_phases(waves, plant, limits, t, 0)
    return break_away_time(plant, limits, waves, x_r, u_0, slope, slope, h)


MAX_QUASI_STEADY_PAUSE = 31
"""Steps at most before bristles that had not settled are asked again."""


@inlined
def begin_step(
    plant,
    law,
    series,
    d,
    x_r,
    v_r,
    z,
    creeping,
    left,
    time_scale,
    requested,
    v_tolerance,
    z_tolerance,
    pause,
    wait,
):
    """Set the series of a step: of settled bristles where they have, else of all that moves.

    Parameters
    ----------
    plant, law, jet, x_r, v_r, z, v_least, z_least
        As in `extend_series`.
    d : int
        Direction as in `Trail`.
    creeps : bool
        Whether the mass is too slow for friction to have fallen.
    left, calm, wish : float
        What is left of the interval, what is short beside the oscillator's own times, and the
        length that is wished for [s].
    pause, wait : int
        Steps before bristles are asked again whether they have settled: still, and in all.

    Returns
    -------
    last, step, rounds, pause, wait
        Last term, length for which the series holds [s], and rounds of settled bristles.
    """
    direction = 1 if d >= 0 else -1
    if law.kind != STRIBECK and relaxation_rate(law, v_r, z) * time_scale > STIFF_RATIO:
        if pause == 0:
            last, step, iterations = solve_quasi_steady(
                plant, law, series, direction, x_r, v_r, z, left, v_tolerance, z_tolerance
            )
            if iterations > 0:
                return last, step, iterations, 0, 0
            wait = min(2 * wait + 1, MAX_QUASI_STEADY_PAUSE)
            pause = wait
        else:
            pause -= 1
    poised = d == 0 or abs(d) == 2
    last, step = extend_series(
        plant,
        law,
        series,
        direction,
        x_r,
        v_r,
        z,
        poised,
        creeping,
        min(left, requested),
        v_tolerance,
        z_tolerance,
    )
    return last, step, 0, pause, wait


@inlined
def step_extent(
    plant, law, series, last, direction, step, settled, creeping, slow, v_tolerance
):
    """Give how far a series is used [s], and what ends it there.

    Parameters
    ----------
    plant, law, jet, last, way, step
        The series up to its last term, the direction, and the length for which it holds [s].
    settled, creeps : bool
        Whether it is one of settled bristles, or of a mass too slow for friction to fall.
    slow : float
        Speed within which it creeps [m/s].
    v_least : float
        What may be neglected [m/s].

    Returns
    -------
    step, stop, end, what
        Length [s]; when v_r is zero and when a branch of the bristles ends, or infinity; and
        what ends it, as in `branch_exit`.
    """
    step = curve_valid_length(law, series, last, direction, step, slow)
    stop = first_series_root(series.v, last, direction, step)
    if settled and stop != NEVER:
        step, stop = 0.5 * stop, NEVER
    end, cause = NEVER, 0
    if law.kind == LEUVEN:
        end, cause = branch_exit(law, series, last, direction, min(stop, step))
    seen = min(stop, end, step)
    if not creeping:
        seen = curve_checked_length(plant, law, series, last, direction, seen, v_tolerance)
    if seen < min(stop, end):
        return min(seen, step), NEVER, NEVER, 0
    return step, stop, end, cause


# A traced motion between its steps.


NO_TRUNCATION = 1e-300
"""Nothing that a series has may be neglected where it is read."""


@compiled
def evaluate_series(
    plant, law, waves, u_dd, dt, series, segments, t, x_out, v_out, z_out, F_out, d_out
):
    """Write the motion at ascending times t [s].

    Parameters
    ----------
    plant, law, waves, u_dd, dt, jet, trail
        As in `march_taylor`; `segments` ends with its last step.
    t : array, shape (n,)
        Ascending, not before the first step [s].
    x_out, v_out, z_out, F_out : array, shape (n,)
        Written: state [m, m/s, m] and friction force [N].
    d_out : array of int, shape (n,)
        Written: direction of motion, 0 where stuck; bristles never stick.
    """
    i = 0
    known = -1
    last = 0
    for k in range(len(t)):
        i = segment_index(segments, dt, i, t[k])
        if known != i:
            last = rebuild_series(plant, law, waves, u_dd, dt, series, segments, i)
            known = i
        s = t[k] - (segments.n[i] * dt + segments.s[i])
        d = (segments.d[i] > 0) - (segments.d[i] < 0)
        x_out[k] = segments.x_r[i]
        v_out[k] = 0.0
        z_out[k] = segments.z[i]
        d_out[k] = d if d != 0 or law.kind == STRIBECK else 1
        if d == 0:
            F_out[k] = -limit_force(plant, x_out[k], horner(series.u, ORDER, s))
            continue
        if s == 0.0:
            v_out[k] = segments.v_r[i]
        else:
            x_out[k], v_out[k], z_out[k] = series_state(series, last, s)
        F_out[k] = dynamic_force(law, d, v_out[k], z_out[k])


@compiled
def integrate_series(plant, law, waves, u_dd, dt, series, segments, begin, end):
    """Integrate a traced motion from `begin_step` to `end` [s].

    Returns x2, v2, x_dd2, power, rub and stuck, as in `Totals`; `sliding_distance` is the loss in the
    contact over F_fk.
    """
    m, k_x, b = plant
    x2, v2, x_dd2, power, sliding_distance, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(segments.n)):
        lo, hi = segment_window(segments, dt, i, begin, end)
        if hi <= lo:
            continue
        last = rebuild_series(plant, law, waves, u_dd, dt, series, segments, i)
        d = (segments.d[i] > 0) - (segments.d[i] < 0)
        if d == 0:
            stuck += hi - lo if law.kind == STRIBECK else 0.0
            x2 += segments.x_r[i] ** 2 * (hi - lo)
        for k in range(len(TWELVE_NODES)):
            s = lo + (hi - lo) * TWELVE_NODES[k]
            weight = (hi - lo) * TWELVE_WEIGHTS[k]
            push = horner(series.u, ORDER, s)
            if d == 0:
                x_dd2 += weight * push * push
                continue
            x, v, z = series_state(series, last, s)
            F = dynamic_force(law, d, v, z)
            x_dd = (k_x * x + b * v + F) / m
            x2 += weight * x * x
            v2 += weight * v * v
            x_dd2 += weight * x_dd * x_dd
            power += weight * push * v
            sliding_distance += weight * F * v / law.F_fk
    return x2, v2, x_dd2, power, sliding_distance, stuck


@compiled
def rebuild_series(plant, law, waves, u_dd, dt, series, segments, i):
    """Make the series of step i anew; gives the last term that counts, 0 where nothing moves.

    What comes behind it is not the motion: the rise of the Stribeck curve, a step away.
    """
    t, u_0, slope = segment_base(u_dd, dt, segments, i)
    d = segments.d[i]
    set_forcing(series, waves, u_0, slope, t)
    if d == 0:
        return 0
    direction = 1 if d > 0 else -1
    if law.kind == LEUVEN:
        series.slope[0], series.slope[1] = segments.rise[i], segments.bend[i]
    if law.kind != STRIBECK and abs(d) > QUASI_STEADY:
        rebuild_quasi_steady(
            plant,
            law,
            series,
            direction,
            segments.x_r[i],
            segments.v_r[i],
            abs(d) - QUASI_STEADY,
        )
        return segments.terms[i]
    slow = has_fractional_exponent(law) and abs(d) > 1
    state = segments.x_r[i], segments.v_r[i], segments.z[i]
    extend_series(
        plant,
        law,
        series,
        direction,
        *state,
        abs(d) == 2,
        slow,
        1.0,
        NO_TRUNCATION,
        NO_TRUNCATION,
    )
    return segments.terms[i]


# The series of all that moves.


@compiled
def set_forcing(series, waves, u_0, slope, t):
    """Set the series of ü about time t [s]: u_0 + slope s and waves."""
    for n in range(ORDER + 1):
        series.u[n] = 0.0
    series.u[0] = u_0
    series.u[1] = slope
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        amplitude, omega = waves.values[at + A], waves.values[at + OMEGA]
        turns = (waves.values[at + FREQUENCY] * t) % 1.0
        angle = 2.0 * math.pi * turns + waves.values[at + PHASE]
        sine = amplitude * math.sin(angle)
        cosine = amplitude * math.cos(angle)
        for n in range(ORDER + 1):
            series.u[n] += sine
            sine, cosine = cosine * omega / (n + 1), -sine * omega / (n + 1)


@compiled
def extend_series(plant, law, series, d, x, v, z, poised, slow, h, v_tolerance, z_tolerance):
    """Set the series of the motion from one state on, as far as they are needed.

    Parameters
    ----------
    plant, law : Plant, Dynamic
    jet : Jet
        Driven; the rest is written.
    d : int
        Direction of motion.
    x, v, z : float
        The state [m, m/s, m].
    poised : bool
        Whether the mass rests or breaks away just now: its relative acceleration is exactly
        zero.
    slow : bool
        Whether the mass is too slow for friction to have fallen.
    h : float
        Length that is wished for [s].
    v_least, z_least : float
        What may be neglected [m/s, m].

    Returns
    -------
    n, h : int, float
        The last term, and the length for which the series holds [s], at most that asked for.
    """
    m, k_x, b = plant
    per_m = 1.0 / m
    series.x[0] = x
    series.v[0] = v
    series.z[0] = z
    falls = start_stribeck_series(law, series, d, v, slow)
    per_curve = 1.0 / (law.F_fk + series.g[0])
    power = 1.0
    small = 0
    for n in range(ORDER):
        force_term(law, series, d, n, falls, per_curve)
        per_n = 1.0 / (n + 1)
        series.x[n + 1] = series.v[n] * per_n
        a = -(series.u[n] + (k_x * series.x[n] + b * series.v[n] + series.F[n]) * per_m) * per_n
        series.v[n + 1] = 0.0 if poised and n == 0 else a
        power *= h
        tiny = abs(series.v[n + 1]) * power <= v_tolerance
        if law.kind != STRIBECK:
            tiny = tiny and abs(series.z[n + 1]) * power <= z_tolerance
        small = small + 1 if tiny else 0
        # Odd and even terms may vanish in turn, and ü has two terms that the state has not.
        if small == 3:
            return n + 1, h
    return ORDER, min(h, truncation_length(law, series, v_tolerance, z_tolerance))


@inlined
def start_stribeck_series(law, series, d, v, slow):
    """Begin the series of the Stribeck curve; tells whether it changes with the speed here."""
    falls = not slow and law.F_fs != law.F_fk and d * v <= FLAT_MARGIN * flat_speed(law)
    if falls:
        start_excess(law, series, d, v)
    else:
        for n in range(ORDER + 1):
            series.g[n] = 0.0
        if slow:
            series.g[0] = law.F_fs - law.F_fk
    return falls


@compiled
def truncation_length(law, series, v_tolerance, z_tolerance):
    """Give the length [s] at which the last terms of the series are what may be neglected."""
    h = math.inf
    for n in range(ORDER - 1, ORDER + 1):
        size = abs(series.v[n]) / v_tolerance
        if law.kind != STRIBECK:
            size = max(size, abs(series.z[n]) / z_tolerance)
        if size > 0.0:
            h = min(h, size ** (-1.0 / n))
    return h


@compiled
def horner(coefficients, n, s):
    """Give the value of a series up to term n at s."""
    total = coefficients[n]
    for k in range(n - 1, -1, -1):
        total = total * s + coefficients[k]
    return total


@compiled
def series_state(series, n, s):
    """Give x, v and z [m, m/s, m] at s from terms up to n: three at the price of one."""
    x, v, z = series.x[n], series.v[n], series.z[n]
    for k in range(n - 1, -1, -1):
        x = x * s + series.x[k]
        v = v * s + series.v[k]
        z = z * s + series.z[k]
    return x, v, z


# Sliding on stiff bristles that have settled: their deflection follows the speed.


QUASI_STEADY = 2
"""What a direction in a trail has besides the rounds of a series on settled bristles."""

STIFF_RATIO = 40.0
"""Times of settling in a step from which on the settled series pays: four steps that resolve
them cost as much as its rounds."""

MAX_ITERATIONS = 12
"""Rounds after which bristles count as not settled: each takes a power of a small ratio."""

QUASI_STEADY_DISTANCE = 0.1
"""Relative distance from the sliding limit beyond which bristles surely have not settled."""


@inlined
def relaxation_rate(law, v, z):
    """Give the rate at which bristles settle [1/s]; 0 where they are far from it."""
    limit = stribeck_curve(law, v)
    pull = law.sigma_0 * abs(z)
    return (
        law.sigma_0 * abs(v) / limit
        if abs(pull - limit) < QUASI_STEADY_DISTANCE * limit
        else 0.0
    )


@compiled
def solve_quasi_steady(plant, law, series, d, x, v, z, h, v_tolerance, z_tolerance):
    """Set the series of the motion on settled bristles; parameters as in `extend_series`.

    Returns the last term, the length for which the series holds [s], and the rounds that it
    took; 0 where the bristles at z have not settled.
    """
    rate = law.sigma_0 * abs(v) / stribeck_curve(law, v)
    for n in range(ORDER + 2):
        series.w[n] = 0.0
    change = 0.0
    for iterations in range(1, MAX_ITERATIONS + 1):
        last = quasi_steady_iteration(plant, law, series, d, x, v, h, v_tolerance, z_tolerance)
        if last == ORDER:
            h = min(h, truncation_length(law, series, v_tolerance, z_tolerance))
        before = change
        change = update_deflection_rate(
            plant, law, series, last, rate, h, v_tolerance, z_tolerance
        )
        if rate * h < STIFF_RATIO or (iterations > 2 and not change < 0.5 * before):
            return 0, h, 0
        if change <= 1.0:
            settled = abs(series.z[0] - z) <= z_tolerance
            return last, h, (iterations if settled else 0)
    return 0, h, 0


@compiled
def rebuild_quasi_steady(plant, law, series, d, x, v, iterations):
    """Set the whole series of settled bristles after so many rounds."""
    for n in range(ORDER + 2):
        series.w[n] = 0.0
    for _ in range(iterations):
        quasi_steady_iteration(plant, law, series, d, x, v, 1.0, 0.0, 0.0)
        update_deflection_rate(plant, law, series, ORDER, 1.0, 1.0, 1.0, 1.0)


@compiled
def quasi_steady_iteration(plant, law, series, d, x, v, h, v_tolerance, z_tolerance):
    """Go once through the equation of settled bristles; gives the last term that counts."""
    m, k_x, b = plant
    series.x[0] = x
    series.v[0] = v
    falls = start_stribeck_series(law, series, d, v, False)
    power = 1.0
    small = 0
    for n in range(ORDER + 1):
        deflection = quasi_steady_term(law, series, d, n, falls)
        series.z[n] = deflection
        tiny = abs(deflection) * power <= z_tolerance
        series.F[n] = (
            law.sigma_0 * deflection + law.sigma_1 * series.w[n] + law.sigma_2 * series.v[n]
        )
        series.x[n + 1] = series.v[n] / (n + 1)
        pull = (k_x * series.x[n] + b * series.v[n] + series.F[n]) / m
        series.v[n + 1] = -(series.u[n] + pull) / (n + 1)
        power *= h
        small = small + 1 if tiny and abs(series.v[n + 1]) * power <= v_tolerance else 0
        if small == 3:
            series.z[n + 1] = 0.0
            return min(n + 1, ORDER)
    return ORDER


@inlined
def quasi_steady_term(law, series, d, n, falls):
    """Give term n of z = d g(v) (1 - w/v)^(1/power)/σ_0 [m]."""
    if falls and n > 0:
        excess_term(law, series, d, n)
    lag = series.w[n]
    for k in range(1, n + 1):
        lag -= series.v[k] * series.p[n - k]
    series.p[n] = lag / series.v[0]
    series.share[n] = fractional_root_term(law, series, n)
    limit = law.F_fk * series.share[n]
    if falls:
        limit += product_term(series.g, series.share, n)
    return d * limit / law.sigma_0


@inlined
def fractional_root_term(law, series, n):
    """Give term n of (1 - p)^(1/power)."""
    rest = 1.0 - series.p[0]
    if n == 0:
        return rest if law.power == 1 else rest ** (1.0 / law.power)
    if law.power == 1:
        return -series.p[n]
    total = 0.0
    for k in range(1, n + 1):
        total -= (k / law.power - (n - k)) * series.p[k] * series.share[n - k]
    return total / (n * rest)


@compiled
def update_deflection_rate(plant, law, series, last, rate, h, v_tolerance, z_tolerance):
    """Set w from the series of z; gives how far that moves z or v, over what may be."""
    change = 0.0
    power = 1.0
    for n in range(ORDER + 1):
        fresh = (n + 1) * series.z[n + 1] if n < last else 0.0
        if law.kind == LEUVEN:
            for k in range(n):
                fresh -= series.slope[1] * series.w[k] * series.z[n - k]
            fresh /= series.slope[0] + series.slope[1] * series.z[0]
        off = abs(fresh - series.w[n]) * power
        series.w[n] = fresh
        push = law.sigma_1 * off * h / (plant.m * v_tolerance)
        change = max(change, off / (rate * z_tolerance), push)
        power *= h
    return change


# How far a series may be trusted, and where its velocity is zero first.


CURVE_TOLERANCE = 10.0
"""Tolerances of F_fs that the curve at the end of a series may be off; roundings add up."""


@compiled
def first_series_root(coefficients, n, d, h):
    """Give the first time in (0, h] at which a velocity in direction d is zero, or infinity.

    Steps that a bound on the curvature proves safe lead to the first zero from below, so none
    is missed; a zero at the beginning itself is divided out.
    """
    first = 0
    while first <= n and coefficients[first] == 0.0:
        first += 1
    if first >= n:
        return NEVER
    rest = 0.0
    bend = 0.0
    power_before, power = 0.0, 1.0
    for k in range(1, n - first + 1):
        size = abs(coefficients[first + k])
        rest += size * power * h
        bend += k * (k - 1) * size * power_before
        power_before, power = power, power * h
    if abs(coefficients[first]) > rest:
        return NEVER
    s = 0.0
    while True:
        v = 0.0
        a = 0.0
        for k in range(n, first - 1, -1):
            a = a * s + v
            v = v * s + d * coefficients[k]
        if v <= 0.0:
            return s
        step = concave_parabola_root(v, a, bend)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step


@compiled
def curve_valid_length(law, series, n, d, h, slow):
    """Give the length [s], at most h, over which a series foresees the Stribeck curve.

    Where the speed is far above v_s the rise of the curve lies beyond the last term, so a
    series ends where the rise begins to count; and where it is too slow for friction to have
    fallen, at `slow` [m/s].
    """
    if law.F_fs == law.F_fk:
        return h
    edge = flat_speed(law)
    v = series.v[0]
    if d * v > FLAT_MARGIN * edge:
        return min(speed_crossing_time(series, n, d, edge, h), h)
    if slow > 0.0 and d * v <= slow:
        return min(speed_crossing_time(series, n, -d, -2.0 * slow, h), h)
    return h


@compiled
def speed_crossing_time(series, n, d, level, h):
    """Give when within h [s] the velocity in direction d comes down to a level [m/s]."""
    v = series.v[0]
    series.v[0] = v - d * level
    arrives = first_series_root(series.v, n, d, h)
    series.v[0] = v
    return arrives


@compiled
def curve_checked_length(plant, law, series, n, d, h, v_tolerance):
    """Give the length [s], at most h, at whose end the series still is the Stribeck curve.

    Near rest a curve that is steep there may be off by what changes the speed by
    `v_tolerance` [m/s].

    Near the edge of the flat part the terms of the rise grow for long before they fall, so
    small terms alone do not tell that a series is complete. One that begins on the flat part
    is `curve_valid_length` to stay there.
    """
    if law.F_fs == law.F_fk or d * series.v[0] > FLAT_MARGIN * flat_speed(law):
        return h
    steep = 1.0 if has_fractional_exponent(law) else 0.0
    while h > 0.0:
        slack = max(
            CURVE_TOLERANCE * law.tolerance * law.F_fs, steep * plant.m * v_tolerance / h
        )
        v, excess = series.v[n], 0.0
        for k in range(n - 1, -1, -1):
            v = v * h + series.v[k]
            excess = excess * h + series.g[k]
        if abs(law.F_fk + excess - stribeck_curve(law, v)) <= slack:
            return h
        h *= 0.5
    return h
