"""Taylor-series solution for friction laws that depend on velocity or on an internal state.

Problem
    With Stribeck, Dahl, LuGre and Leuven friction the motion has no closed form, but within a
    direction of motion it is analytic. Fixed-step methods smear the events and need tiny steps
    for stiff bristles.

Method
    - The Taylor coefficients of x_r, v_r and z about an instant follow one from the other by
      Cauchy products (automatic differentiation), up to order `ORDER`. The last coefficients
      give the step over which the truncation error is below the tolerance. The series is also
      the dense output.
    - `march_taylor` proceeds from series to series and stores only the start of each;
      `evaluate_series` and `integrate_series` rebuild the series from there.
    - Stiff bristles relax within a distance F/σ_0, and a series that resolves this transient
      takes about ten steps per such distance. After the transient z lies on the slow manifold z
      = d g(v) (1 - w/v)^(1/power)/σ_0, where g is the Stribeck curve and w is the rate of the
      bristle deflection (for Leuven the rate of travel). Fixed-point iteration on this equation
      converges by the ratio of the fast and the slow time scale, and the series of the result
      is as long as the slow motion permits (`solve_quasi_steady`).

Why nothing of the truncated series is missed
    The first zero of v_r within a step is approached from below by steps that a bound on the
    second derivative proves safe (`first_series_root`); likewise the ends of the hysteresis
    branches (`core.dynamic_friction`). A step ends early where the last coefficients do not yet
    reflect the rise of the Stribeck curve.

Reference: E. Hairer, S. P. Nørsett and G. Wanner, Solving Ordinary Differential Equations I
(1993), section I.8.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined, merged
from drysim.core.dynamic_friction import (
    AT_LIMIT,
    branch_exit,
    dissipated_power,
    dynamic_force,
    excess_term,
    flat_speed,
    force_term,
    has_fractional_exponent,
    negligible_speed,
    next_branch,
    product_term,
    set_masing_slope,
    stribeck_curve,
    stribeck_exponent,
    update_branch,
)
from drysim.core.events import (
    FORCE_ROUNDING,
    REVERSAL,
    SERIES_LOG_RESERVE,
    SLIP,
    SampledLimit,
    decision_margin,
    direction_from_rest,
    excess_margin,
    limit_force,
    record_event,
    record_segment,
    sign,
)
from drysim.core.forcing import FREQUENCY, OMEGA, PHASE, WAVE_COLUMNS, A, set_phases
from drysim.core.march import Interval
from drysim.core.model import LEUVEN, STRIBECK, TWELVE_NODES, TWELVE_WEIGHTS, CoulombLaw
from drysim.core.roots import NEVER, RESOLUTION, Stuck, break_away_time, first_series_root
from drysim.core.status import NO_PROGRESS
from drysim.core.trajectory import (
    TIME_ROUNDING,
    relative,
    segment_base,
    segment_index,
    segment_window,
)

ORDER = 20
"""Highest order of a series: near the minimum of work for errors of rounding size."""

FLAT_MARGIN = 1.05
"""A series that starts below this multiple of the speed `flat_speed` includes the curve's
rise."""


class TaylorSeries(NamedTuple):
    """Taylor coefficients about one instant as arrays (or lists), shape (ORDER + 2,).

    Attributes
    ----------
    x, v, z : array of float
        Coefficients of x_r [m], v_r [m/s] and the deflection z [m], each per s^n.
    u : array of float
        Coefficients of ü [m/s²].
    F : array of float
        Coefficients of the friction force [N].
    s, g, p : array of float
        Work: n times the coefficients of the Stribeck exponent; the excess of the Stribeck
        curve over F_fk [N]; and |v| z over the curve, or for `LEUVEN` the hysteresis force over
        the curve. The excess is held apart because far above v_s it is below the rounding of
        the curve.
    w : array of float
        Rate of bristle travel [m/s]; for `LEUVEN` and for quasi-steady series.
    square, share : array of float
        Powers of p; of a quasi-steady series, work of its own.
    scale : array of float
        scale[0] is the greatest speed so far [m/s], to which tolerances refer.
    slope : array of float
        Slope dz/dtravel = slope[0] + slope[1] z of the hysteresis branch; `LEUVEN` only.
    reversals : array of float
        Deflections at the remembered reversals of the bristles [m]; `LEUVEN` only.
    branch : array of int
        Number of reversals, direction of travel, and whether z is at its limit; `LEUVEN` only.
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


class SeriesStart(NamedTuple):
    """What a series starts from.

    Attributes
    ----------
    d : int
        Direction of motion.
    x, v, z : float
        State [m, m/s, m].
    poised : bool
        Whether the mass rests or breaks away at this instant: its relative acceleration is
        exactly zero.
    creeping : bool
        Whether the mass is too slow for the Stribeck curve to have fallen.
    """

    d: int
    x: float
    v: float
    z: float
    poised: bool
    creeping: bool


class Tolerances(NamedTuple):
    """Negligible changes of speed [m/s] and of the deflection z [m]."""

    v: float
    z: float


class SeriesState(NamedTuple):
    """State of a march.

    Attributes
    ----------
    n, s : int, float
        Interval of ü, and time since its start [s].
    x_r, v_r, z : float
        Displacement [m], velocity [m/s] and deflection [m].
    d : int
        Direction as in `SeriesSegments`.
    used, events : int
        Numbers of segments and of events in the logs; `events` may be a
        `Status` instead.
    closest : float
        Smallest relative margin of a decision about sticking so far [-].
    """

    n: int
    s: float
    x_r: float
    v_r: float
    z: float
    d: int
    used: int
    events: int
    closest: float


class StepControl(NamedTuple):
    """What a march remembers to choose its next step.

    Attributes
    ----------
    time_scale : float
        Time scale of waves and oscillator [s].
    requested : float
        Longest step of a full series [s].
    pause_left, pause_length : int
        Steps left before the next attempt at a quasi-steady series, and the length of that
        pause.
    stalled : int
        Steps without progress in time so far, one after the other.
    """

    time_scale: float
    requested: float
    pause_left: int
    pause_length: int
    stalled: int


# The march from series to series.


CREEPING = 3
"""Magnitude of d in `SeriesSegments` for a mass too slow for the Stribeck curve to have
fallen."""

MAX_STALLED_STEPS = 100
"""Events in a row without progress in time after which double precision is exhausted."""


@compiled
def march_taylor(scene, until, state, series, segments, log):
    """Solve the motion from interval to interval of ü, until one of the logs is nearly full.

    Parameters
    ----------
    scene : Scene
        With a `DynamicLaw`.
    until : tuple
        Number of the last interval, and time [s] within it to which to march.
    state : SeriesState
    series : TaylorSeries
        Work space, with the remembered reversals.
    segments, log : SeriesSegments, EventLog
        Written: the start of each series, and the events; of one length.

    Returns
    -------
    SeriesState
    """
    plant, law, waves, u_dd, dt = scene
    (end, h), full = until, len(log.n) - SERIES_LOG_RESERVE
    wave_scale, time_scale = time_scales(plant, waves)
    control = StepControl(time_scale, NEVER, 0, 0, 0)
    while state.n <= end and state.used < full and 0 <= state.events < full:
        n = state.n
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        interval = Interval(n, n * dt, h if n == end else dt, u_dd[n], slope)
        if state.d == 0 and law.kind == STRIBECK:
            state = stick(scene, interval, wave_scale, state, segments, log)
        else:
            state, control = slide(scene, interval, state, control, series, segments, log)
        if state.s >= interval.h:
            state = SeriesState(n + 1, 0.0, *state[2:])
    return state


@merged
def stick(scene, interval, wave_scale, state, segments, log):
    """Return the state after sticking: at break-away, or `wave_scale` [s] later at most."""
    plant, law, waves, samples, _ = scene
    n, s, x_r, v_r, z, d, used, events, closest = state
    used = record_segment(segments, used, (n, s), (x_r, v_r, z), d)
    limits = CoulombLaw(law.F_fs, law.F_fs, 0.0, 0.0, 0.0)
    set_phases(waves, plant, limits, interval.t + s, 0)
    left = interval.h - s
    horizon = min(left, wave_scale)
    u_dd, hold = interval.u_0 + interval.slope * s, (law.F_fs, interval.slope)
    stuck = Stuck(plant.m, plant.k_x * x_r, u_dd, hold, hold, 0.0, 0.0)
    stay, side, margin = break_away_time(stuck, waves, horizon)
    closest = min(closest, margin)
    s = interval.h if min(stay, horizon) >= left else s + min(stay, horizon)
    if stay != NEVER:
        d = 2 * side
        events = record_event(log, events, n, s, side * SLIP, x_r, -side * law.F_fs)
        if waves.base == 0:
            F_k, limit = plant.k_x * x_r, SampledLimit(law.F_fs, 0.0, 0.0, 0.0)
            closest = excess_margin(plant, samples, limit, n, F_k, side, closest)
    return SeriesState(n, s, x_r, v_r, z, d, used, events, closest)


@merged
def slide(scene, interval, state, control, series, segments, log):
    """Return the state after one series, or at the event that ends it, and the `StepControl`.

    Parameters as in `march_taylor`; `interval` is that of ü, and `control` from the last step.
    """
    plant, law, _, _, _ = scene
    if state.d == 0:
        # The forcing of this interval may move a mass in equilibrium, to either side.
        state = pass_rest(scene, interval, state, series, log)
    else:
        set_forcing_at(scene, interval, state.s, series)
    n, s, x_r, v_r, z, d, used, events, closest = state
    t, left = interval.t + s, interval.h - s
    if law.kind == LEUVEN:
        set_masing_slope(law, series)
    direction = 1 if d >= 0 else -1
    z_tolerance = law.tolerance * law.F_fs / law.sigma_0 if law.kind != STRIBECK else 0.0
    tolerances = Tolerances(law.tolerance * series.scale[0], z_tolerance)
    slow = negligible_speed(law, series)
    creeping = slow > 0.0 and direction * v_r <= slow
    start = SeriesStart(direction, x_r, v_r, z, d == 0 or abs(d) == 2, creeping)
    last, step, iterations, control = begin_step(
        plant, law, series, start, left, tolerances, control
    )
    code = d
    if iterations > 0:
        code = direction * (QUASI_STEADY + iterations)
    elif creeping and abs(d) != 2:
        code = direction * CREEPING
    used = record_segment(segments, used, (n, s), (x_r, v_r, z), code)
    segments.terms[used - 1] = last
    if law.kind == LEUVEN:
        segments.rise[used - 1] = series.slope[0]
        segments.bend[used - 1] = series.slope[1]
    step, stop, end_of_branch, cause = step_extent(
        plant, law, series, start, (last, step, iterations), slow, tolerances.v
    )
    event = min(stop, end_of_branch)
    # A creeping mass whose step is below the resolution of time stops here.
    if slow > 0.0 and event == NEVER and step <= RESOLUTION * (t + step):
        event = stop = step
    no_progress = min(event, step) <= RESOLUTION * (t + step) and min(event, step) < left
    time_scale, _, pause_left, pause_length, stalled = control
    stalled = stalled + 1 if no_progress else 0
    requested = 4.0 * step if step < left else NEVER
    control = StepControl(time_scale, requested, pause_left, pause_length, stalled)
    if stalled > (0 if event == NEVER else MAX_STALLED_STEPS):
        return SeriesState(n, s, x_r, v_r, z, d, used, NO_PROGRESS, closest), control
    step = min(event, step)
    s = interval.h if step == left else min(s + step, interval.h)
    x_r, v_r, z = series_state(series, last, step)
    series.scale[0] = max(series.scale[0], abs(v_r))
    if law.kind == LEUVEN and step > 0.0:
        series.branch[AT_LIMIT] = 0
    d = direction if d != 0 else 0
    if end_of_branch < stop:
        z = next_branch(law, series, cause, z)
    state = SeriesState(n, s, x_r, v_r, z, d, used, events, closest)
    if stop <= end_of_branch and stop != NEVER:
        state = pass_rest(scene, interval, state, series, log)
    return state, control


@compiled
def pass_rest(scene, interval, state, series, log):
    """Return the state after v_r = 0: the mass rests or moves on; write an event to the log.

    The forcing is set there.
    """
    plant, law, _, _, _ = scene
    n, s, x_r, _, z, _, used, events, closest = state
    set_forcing_at(scene, interval, s, series)
    d = motion_direction_at(plant, law, series, x_r, 0.0, z)
    if law.kind == LEUVEN and d != 0:
        update_branch(law, series, sign(d), 0.0, z)
    # A mass on bristles does not stick: at rest it has no event until it moves.
    if d != 0 or law.kind == STRIBECK:
        F_L = limit_force(plant, x_r, series.u[0])
        events = record_event(log, events, n, s, REVERSAL * sign(d), x_r, F_L)
        if law.kind == STRIBECK:
            closest = min(closest, decision_margin(F_L, law.F_fs))
    return SeriesState(n, s, x_r, 0.0, z, d, used, events, closest)


@compiled
def motion_direction_at(plant, law, series, x_r, v_r, z):
    """Return the direction of motion as in `SeriesSegments`, with the forcing set.

    A mass at rest on bristles is in equilibrium until a coefficient of ü moves it, with code ±2
    as at a break-away; 0 if none does. Without bristles 0 means stuck.
    """
    if v_r != 0.0:
        return sign(v_r)
    if law.kind == STRIBECK:
        F_L = limit_force(plant, x_r, series.u[0])
        return direction_from_rest(F_L, law.F_fs, plant.k_x * x_r)
    a = series.u[0] + (plant.k_x * x_r + law.sigma_0 * z) / plant.m
    if abs(a) > equilibrium_tolerance(plant, law, series, x_r, z):
        return -sign(a)
    for n in range(1, ORDER + 1):
        if series.u[n] != 0.0:
            return -2 * sign(series.u[n])
    return 0


@compiled
def equilibrium_tolerance(plant, law, series, x_r, z):
    """Return the acceleration [m/s²] that counts as equilibrium on bristles.

    It is the rounding of the forces, or the acceleration of an oscillation on the bristles with
    a negligible speed. Near their limit the bristles have no stiffness and do not oscillate.
    """
    m, k_x, _ = plant
    pull = law.sigma_0 * abs(z)
    rounding = FORCE_ROUNDING * (abs(k_x * x_r) + pull) / m
    firm = max(1.0 - pull / law.F_fs, 0.0) * (1.0 - law.F_fs / law.F_h)
    swing = law.tolerance * series.scale[0] * math.sqrt((k_x + law.sigma_0 * firm) / m)
    return max(rounding, swing)


@compiled
def time_scales(plant, waves):
    """Return 1/omega of the fastest wave [s], and the shortest scale of wave or oscillator.

    Infinite without waves, or without spring and damper.
    """
    fastest = 0.0
    for i in range(waves.size):
        fastest = max(fastest, waves.values[WAVE_COLUMNS * i + OMEGA])
    rate = max(fastest, math.sqrt(plant.k_x / plant.m), plant.b / plant.m)
    return (
        1.0 / fastest if fastest > 0.0 else NEVER,
        1.0 / rate if rate > 0.0 else NEVER,
    )


MAX_QUASI_STEADY_PAUSE = 31
"""Most steps between two attempts at a quasi-steady series."""


@inlined
def begin_step(plant, law, series, start, left, tolerances, control):
    """Set the series of a step: quasi-steady where that converges, else the full one.

    The step is at most the rest of the interval, `left` [s].

    Returns
    -------
    last, step, iterations : int, float, int
        Degree of the series, its valid length [s], and the iterations of a quasi-steady series;
        0 for a full one.
    control : StepControl
    """
    time_scale, requested, pause_left, pause_length, stalled = control
    relaxation = relaxation_rate(law, start.v, start.z) if law.kind != STRIBECK else 0.0
    if relaxation * min(left, time_scale) > STIFF_RATIO:
        if pause_left == 0:
            last, step, iterations = solve_quasi_steady(
                plant, law, series, start, left, tolerances
            )
            if iterations > 0:
                return last, step, iterations, StepControl(time_scale, requested, 0, 0, stalled)
            pause_length = min(2 * pause_length + 1, MAX_QUASI_STEADY_PAUSE)
            pause_left = pause_length
        else:
            pause_left -= 1
    last, step = extend_series(plant, law, series, start, min(left, requested), tolerances)
    control = StepControl(time_scale, requested, pause_left, pause_length, stalled)
    return last, step, 0, control


@inlined
def step_extent(plant, law, series, start, trial, slow, v_tolerance):
    """Return the length over which a series is used [s], and what ends it there.

    Parameters
    ----------
    plant, law, series, start
        As in `extend_series`.
    trial : tuple
        Degree, valid length [s] and iterations of the series as returned by `begin_step`.
    slow : float
        Speed below which the mass creeps [m/s].
    v_tolerance : float
        Negligible change of speed [m/s].

    Returns
    -------
    step, stop, end, cause
        Length [s]; time at which v_r is zero and time at which a hysteresis branch ends, or
        infinity; and the cause of that end as in `branch_exit`.
    """
    last, step, iterations = trial
    d = start.d
    step = curve_valid_length(law, series, last, d, step, slow)
    stop = speed_crossing_time(series, last, d, 0.0, step)
    if iterations > 0 and stop != NEVER:
        # Near v_r = 0 the slow manifold does not exist: approach it, then use the full series.
        step, stop = 0.5 * stop, NEVER
    end, cause = NEVER, 0
    if law.kind == LEUVEN:
        end, cause = branch_exit(law, series, last, d, min(stop, step))
    seen = min(stop, end, step)
    if not start.creeping:
        seen = curve_checked_length(plant, law, series, last, d, seen, v_tolerance)
    if seen < min(stop, end):
        return min(seen, step), NEVER, NEVER, 0
    return step, stop, end, cause


# Evaluation and integrals of a solution.


NO_TRUNCATION = 1e-300
"""Tolerance at which a rebuilt series keeps all its terms."""


@compiled
def evaluate_series(solution, series, t, out):
    """Write a motion at ascending times t [s] to `Points`; parameters as `rebuild_series`.

    A mass on bristles is never stuck: at rest its direction is 1.
    """
    (plant, law, _, _, dt), segments = solution
    i, rebuilt, last = int(ZERO), -1, 0
    for k in range(len(t)):
        i = segment_index(segments, dt, i, t[k])
        if rebuilt != i:
            last = rebuild_series(solution, series, i)
            rebuilt = i
        s = t[k] - (segments.n[i] * dt + segments.s[i])
        d = sign(segments.d[i])
        x, v, z = segments.x_r[i], 0.0, segments.z[i]
        if d == 0:
            out.x_dd[k] = horner(series.u, ORDER, s)
            out.F_f[k] = -limit_force(plant, x, out.x_dd[k])
        else:
            v = segments.v_r[i]
            if s != 0.0:
                x, v, z = series_state(series, last, s)
            out.F_f[k] = dynamic_force(law, d, v, z)
            out.x_dd[k] = -(plant.b * v + plant.k_x * x + out.F_f[k]) / plant.m
        out.x_r[k] = x
        out.v_r[k] = v
        out.z[k] = z
        out.F_stop[k] = 0.0
        out.d[k] = d if d != 0 or law.kind == STRIBECK else 1


@compiled
def integrate_series(solution, series, begin, end):
    """Integrate the motion from `begin` to `end` [s]; other parameters as `rebuild_series`.

    Returns x2, v2, x_dd2, power, sliding_distance, stuck and violation as in `Totals`.
    """
    (plant, law, _, _, dt), segments = solution
    m, k_x, b = plant
    x2, v2, x_dd2, power, sliding_distance, stuck = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    violation = 0.0
    for i in range(len(segments.n)):
        lo, hi = segment_window(segments, dt, i, begin, end)
        if hi <= lo:
            continue
        last = rebuild_series(solution, series, i)
        d = sign(segments.d[i])
        if d == 0:
            stuck += hi - lo if law.kind == STRIBECK else 0.0
            x2 += segments.x_r[i] ** 2 * (hi - lo)
        elif law.kind == STRIBECK and segments.v_r[i] == 0.0:
            t = segments.n[i] * dt + segments.s[i]
            violation = max(violation, early_series_slip(plant, law, series, d, t))
        for k in range(len(TWELVE_NODES)):
            s = lo + (hi - lo) * TWELVE_NODES[k]
            weight = (hi - lo) * TWELVE_WEIGHTS[k]
            push = horner(series.u, ORDER, s)
            if d == 0:
                x_dd2 += weight * push * push
                x, z = segments.x_r[i], segments.z[i]
                violation = max(violation, rest_violation(plant, law, x, z, push))
                continue
            x, v, z = series_state(series, last, s)
            F = dynamic_force(law, d, v, z)
            x_dd = (k_x * x + b * v + F) / m
            x2 += weight * x * x
            v2 += weight * v * v
            x_dd2 += weight * x_dd * x_dd
            power += weight * push * v
            slope = series.slope[0] + series.slope[1] * z
            sliding_distance += weight * dissipated_power(law, v, z, slope) / law.F_fk
    return x2, v2, x_dd2, power, sliding_distance, stuck, violation


@compiled
def rest_violation(plant, law, x_r, z, u_dd):
    """Return the force at rest that friction may not carry, relative to the forces [-].

    A rigid contact carries up to its static limit; bristles carry what their deflection says.
    """
    inertia, spring, bristles = plant.m * u_dd, plant.k_x * x_r, law.sigma_0 * z
    if law.kind == STRIBECK:
        excess = abs(inertia + spring) - law.F_fs
        return relative(excess, abs(inertia) + abs(spring) + law.F_fs)
    excess = abs(inertia + spring + bristles)
    return relative(excess, abs(inertia) + abs(spring) + abs(bristles) + law.F_fk)


@compiled
def early_series_slip(plant, law, series, d, t):
    """Return by how much a slip from v_r = 0 at t [s] begins below the static limit [-].

    The rounding of t, to which the force under waves belongs, is allowed.
    """
    inertia, spring = plant.m * series.u[0], plant.k_x * series.x[0]
    drift = TIME_ROUNDING * t * abs(plant.m * series.u[1])
    shortfall = law.F_fs + d * (inertia + spring) - drift
    return relative(shortfall, abs(inertia) + abs(spring) + law.F_fs)


@compiled
def rebuild_series(solution, series, i):
    """Rebuild the series of segment i; return its degree, 0 where nothing moves.

    Coefficients above that degree must not be used.

    Parameters
    ----------
    solution : Solution
        With a `DynamicLaw` and `SeriesSegments`.
    series : TaylorSeries
        Work space.
    i : int
    """
    (plant, law, waves, u_dd, dt), segments = solution
    t, u_0, slope = segment_base(u_dd, dt, segments, i)
    code = segments.d[i]
    set_forcing(series, waves, u_0, slope, t)
    if code == 0:
        return 0
    if law.kind == LEUVEN:
        series.slope[0], series.slope[1] = segments.rise[i], segments.bend[i]
    creeping = has_fractional_exponent(law) and abs(code) > 1
    state = segments.x_r[i], segments.v_r[i], segments.z[i]
    start = SeriesStart(sign(code), *state, abs(code) == 2, creeping)
    if law.kind != STRIBECK and abs(code) > QUASI_STEADY:
        rebuild_quasi_steady(plant, law, series, start, abs(code) - QUASI_STEADY)
    else:
        every = Tolerances(NO_TRUNCATION, NO_TRUNCATION)
        extend_series(plant, law, series, start, 1.0, every)
    return segments.terms[i]


# The series of the full equation of motion.


@compiled
def set_forcing_at(scene, interval, s, series):
    """Set the series of ü about the time s [s] in an interval."""
    u_0 = interval.u_0 + interval.slope * s
    set_forcing(series, scene.waves, u_0, interval.slope, interval.t + s)


@compiled
def set_forcing(series, waves, u_0, slope, t):
    """Set the series of ü about time t [s]: u_0 + slope s and the waves."""
    for n in range(ORDER + 1):
        series.u[n] = 0.0
    series.u[0] = u_0
    series.u[1] = slope
    for i in range(waves.base):
        row = WAVE_COLUMNS * i
        amplitude, omega = waves.values[row + A], waves.values[row + OMEGA]
        cycles = (waves.values[row + FREQUENCY] * t) % 1.0
        angle = 2.0 * math.pi * cycles + waves.values[row + PHASE]
        sine = amplitude * math.sin(angle)
        cosine = amplitude * math.cos(angle)
        for n in range(ORDER + 1):
            series.u[n] += sine
            sine, cosine = cosine * omega / (n + 1), -sine * omega / (n + 1)


@compiled
def extend_series(plant, law, series, start, h, tolerances):
    """Compute the series of the full equation of motion to the order needed.

    Parameters
    ----------
    plant, law : Plant, DynamicLaw
    series : TaylorSeries
        With the forcing set; the rest is written.
    start : SeriesStart
    h : float
        Requested length [s].
    tolerances : Tolerances

    Returns
    -------
    n, h : int, float
        Degree of the series, and the length over which it is valid [s], at most the requested
        one.
    """
    m, k_x, b = plant
    d, x, v, z, poised, creeping = start
    per_m = 1.0 / m
    series.x[0] = x
    series.v[0] = v
    series.z[0] = z
    falls = start_stribeck_series(law, series, d, v, creeping)
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
        tiny = abs(series.v[n + 1]) * power <= tolerances.v
        if law.kind != STRIBECK:
            tiny = tiny and abs(series.z[n + 1]) * power <= tolerances.z
        small = small + 1 if tiny else 0
        # Three in a row: odd or even terms may vanish by symmetry, and the linear part of ü
        # enters v two orders after x.
        if small == 3:
            return n + 1, h
    return ORDER, min(h, truncation_length(law, series, tolerances))


@inlined
def start_stribeck_series(law, series, d, v, creeping):
    """Start the series of the Stribeck curve; return whether it depends on speed here."""
    falls = not creeping and law.F_fs != law.F_fk and d * v <= FLAT_MARGIN * flat_speed(law)
    if falls:
        series.s[0] = stribeck_exponent(law, abs(v))
        series.g[0] = (law.F_fs - law.F_fk) * math.exp(-series.s[0])
    else:
        for n in range(ORDER + 1):
            series.g[n] = 0.0
        if creeping:
            series.g[0] = law.F_fs - law.F_fk
    return falls


@compiled
def truncation_length(law, series, tolerances):
    """Return the length [s] up to which the last terms of the series are within tolerance."""
    h = math.inf
    for n in range(ORDER - 1, ORDER + 1):
        size = abs(series.v[n]) / tolerances.v
        if law.kind != STRIBECK:
            size = max(size, abs(series.z[n]) / tolerances.z)
        if size > 0.0:
            h = min(h, size ** (-1.0 / n))
    return h


@compiled
def horner(coefficients, n, s):
    """Evaluate a polynomial of degree n at s by Horner's rule."""
    total = coefficients[n]
    for k in range(n - 1, -1, -1):
        total = total * s + coefficients[k]
    return total


@compiled
def series_state(series, n, s):
    """Return x, v and z [m, m/s, m] at s from the terms up to n, by Horner's rule."""
    x, v, z = series.x[n], series.v[n], series.z[n]
    for k in range(n - 1, -1, -1):
        x = x * s + series.x[k]
        v = v * s + series.v[k]
        z = z * s + series.z[k]
    return x, v, z


# Quasi-steady sliding on stiff bristles: the deflection follows the speed.


QUASI_STEADY = 2
"""Offset added to the iterations of a quasi-steady series in the codes of
`SeriesSegments.d`."""

STIFF_RATIO = 40.0
"""Relaxation times per step from which on the quasi-steady series pays: four steps that
resolve the transient cost as much as its iterations."""

MAX_ITERATIONS = 12
"""Iterations after which the bristles count as not relaxed; each gains a factor, the small
ratio of time scales."""

QUASI_STEADY_DISTANCE = 0.1
"""Relative distance from the sliding limit above which bristles are surely not quasi-steady."""


@inlined
def relaxation_rate(law, v, z):
    """Return the rate at which bristles relax [1/s]; 0 where they are far from quasi-steady."""
    limit = stribeck_curve(law, v)
    pull = law.sigma_0 * abs(z)
    return (
        law.sigma_0 * abs(v) / limit
        if abs(pull - limit) < QUASI_STEADY_DISTANCE * limit
        else 0.0
    )


@compiled
def solve_quasi_steady(plant, law, series, start, h, tolerances):
    """Compute the series of the motion on the slow manifold by fixed-point iteration.

    Parameters as in `extend_series`. Returns the degree, the valid length [s], and the number
    of iterations; 0 iterations if the deflection z is not quasi-steady.
    """
    rate = law.sigma_0 * abs(start.v) / stribeck_curve(law, start.v)
    for n in range(ORDER + 2):
        series.w[n] = 0.0
    change = 0.0
    for iterations in range(1, MAX_ITERATIONS + 1):
        last = quasi_steady_iteration(plant, law, series, start, h, tolerances)
        if last == ORDER:
            h = min(h, truncation_length(law, series, tolerances))
        before = change
        change = update_deflection_rate(plant, law, series, last, rate, h, tolerances)
        # Not stiff enough to pay, or the iteration does not contract.
        if rate * h < STIFF_RATIO or (iterations > 2 and not change < 0.5 * before):
            return 0, h, 0
        if change <= 1.0:
            converged = abs(series.z[0] - start.z) <= tolerances.z
            return last, h, (iterations if converged else 0)
    return 0, h, 0


@compiled
def rebuild_quasi_steady(plant, law, series, start, iterations):
    """Rebuild the quasi-steady series after a number of iterations."""
    for n in range(ORDER + 2):
        series.w[n] = 0.0
    for _ in range(iterations):
        quasi_steady_iteration(plant, law, series, start, 1.0, Tolerances(0.0, 0.0))
        update_deflection_rate(plant, law, series, int(ORDER), 1.0, 1.0, Tolerances(1.0, 1.0))


@compiled
def quasi_steady_iteration(plant, law, series, start, h, tolerances):
    """Iterate the quasi-steady equation once with the present w; return the degree needed."""
    m, k_x, b = plant
    d = start.d
    series.x[0] = start.x
    series.v[0] = start.v
    falls = start_stribeck_series(law, series, d, start.v, False)
    power = 1.0
    small = 0
    for n in range(ORDER + 1):
        deflection = quasi_steady_term(law, series, d, n, falls)
        series.z[n] = deflection
        tiny = abs(deflection) * power <= tolerances.z
        series.F[n] = (
            law.sigma_0 * deflection + law.sigma_1 * series.w[n] + law.sigma_2 * series.v[n]
        )
        series.x[n + 1] = series.v[n] / (n + 1)
        pull = (k_x * series.x[n] + b * series.v[n] + series.F[n]) / m
        series.v[n + 1] = -(series.u[n] + pull) / (n + 1)
        power *= h
        small = small + 1 if tiny and abs(series.v[n + 1]) * power <= tolerances.v else 0
        if small == 3:
            series.z[n + 1] = 0.0
            return min(n + 1, ORDER)
    return ORDER


@inlined
def quasi_steady_term(law, series, d, n, falls):
    """Return term n of z = d g(v) (1 - w/v)^(1/power)/σ_0 [m]."""
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
    """Set and return term n of (1 - p)^(1/power)."""
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
def update_deflection_rate(plant, law, series, last, rate, h, tolerances):
    """Update w from the series of z; return the change of z or v relative to its tolerance."""
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
        push = law.sigma_1 * off * h / (plant.m * tolerances.v)
        change = max(change, off / (rate * tolerances.z), push)
        power *= h
    return change


# Valid length of a series, and the first zero of its velocity.


CURVE_TOLERANCE = 10.0
"""Error of the curve at the end of a series, in tolerances of F_fs, that is accepted;
roundings add up."""


@compiled
def curve_valid_length(law, series, n, d, h, slow):
    """Return the length [s], at most h, over which a series represents the Stribeck curve.

    Far above v_s the rise of the curve is beyond the last term, so a series ends where the
    speed falls to the rise. A series of a creeping mass ends at twice the speed `slow` [m/s].
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
    """Return when within h [s] the velocity in direction d decreases to a level [m/s].

    Infinite for never. `series.share` is used as work space.
    """
    for k in range(n + 1):
        series.share[k] = d * series.v[k]
    series.share[0] -= level
    return first_series_root(series.share, n, h)


@compiled
def curve_checked_length(plant, law, series, n, d, h, v_tolerance):
    """Return the length [s], at most h, at whose end the series matches the Stribeck curve.

    Near the edge of the flat part, the terms of the rise grow for long before they decrease, so
    small terms alone do not prove that a series is complete. The curve at the end is therefore
    compared with its exact value. A fractional curve is steep near rest and may be off by what
    changes the speed by `v_tolerance` [m/s].
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
