"""Periodic orbits under sines: convergence, uniqueness and measures of the orbit.

Problem
    The motion from a given start converges to a periodic orbit: a fixed point of the period map
    P (the state after one period of the excitation) or of a power P^k. With little damping the
    iterates approach it slowly, and a small change per period does not prove that the orbit is
    near.

Method
    1. Iterate P (`iterate_period_map`) until the state repeats after k periods to within
       `CLOSURE_TOLERANCE`. The closure residual is the scaled change over the repetition.
    2. Close to an orbit and with an unchanged number of events per period, take Newton steps (I
       - DP)⁻¹ (P(x) - x) (`newton_step`). The Jacobian DP is the product of the segment flows
       and of a saltation matrix per event, all in closed form (`period_map_jacobian`). A step
       must reduce the residual by `NEWTON_REDUCTION` and the spectral radius of DP must be
       below 1; otherwise the iteration resumes from its own state.
    3. Where the free motion decays little per repetition, sum the geometric series of the
       remaining changes, (I - DP)⁻¹ (P(x) - x) (`uniqueness_and_distance`). A large sum means
       that the orbit is not reached. A spectral radius of 1 means that the orbit is one of a
       continuum: neutrally stable and not unique.

The outer loops are compiled into `solve_orbits` (`merged`).

A creeping overdamped mass gets few periods (`period_budget`). `solve_orbits` handles a block of
scenes in one call.

Reference: R. I. Leine and H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical
Systems (2004), for saltation matrices and the Poincaré map of systems with friction.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled, merged
from drysim.core.events import direction_after, initial_direction
from drysim.core.forcing import (
    OMEGA,
    PHASE,
    SCENE_COLUMNS,
    V_R,
    WAVE_COLUMNS,
    X_R,
    A,
    Waves,
    base_motion,
    mean_squares,
    plant_and_law,
    relative_normal_force,
    set_phases,
    set_wave,
)
from drysim.core.march import Interval, SlipState, march_sines
from drysim.core.model import CoulombLaw, StrokeLimits
from drysim.core.oscillator import flow
from drysim.core.trajectory import (
    EventSolution,
    excursions,
    extremes_and_crossings,
    integrate_events,
    state_at,
)

# A block of scenes in one call.


PERIOD, UP, DOWN, SINES = range(SCENE_COLUMNS, SCENE_COLUMNS + 4)
"""Columns of a scene after those of `drysim.core.forcing`: period of the excitation [s] and
stroke limits [m] (infinite for none); from SINES on amplitude [m/s²], frequency [Hz] and
phase [rad] of each sine."""

(
    STATUS, TIME, MULTIPLE, CLOSURE, RUN_UP, RUN_UP_PEAK, X_BEGIN, V_BEGIN, X_END, V_END,
    X2, V2, X_DD2, POWER, SLIDING_DISTANCE, STUCK, U_DD2, U2, LOWEST, HIGHEST, UPCROSSINGS,
    ENTRIES, EXCURSIONS_UP, EXCURSIONS_DOWN, T_FIRST, TIME_BEYOND, ANSWER_COLUMNS,
) = range(27)  # fmt: skip
"""Columns of an answer: status; time reported with a failure [s]; periods per repetition,
closure residual [-] and run-up [s, m] as in `iterate_period_map`; states at both ends of one
repetition; its integrals as in `Totals`; extremes of x_r [m], upcrossings of zero and entries
beyond the limits; excursions as in `excursions`. ANSWER_COLUMNS is the number of columns."""

CONVERGED, NOT_CONVERGED, NOT_UNIQUE, ENDLESS_EVENTS, OVERFLOW, LOG_FULL = range(6)
"""Status of a scene. The last three have no orbit: endless events without progress in time,
a state that is not finite, and more events per repetition than the log holds."""


INTERVAL, NO_EVENTS, ONE_EVENT = 0, 0, 1
"""Arguments of `march_sines`: the only interval, and the number of events in the log. Kernels
pass them by `int`, because numba compiles a kernel anew for each literal integer."""


@compiled
def solve_orbits(scenes, answers, values, past_x, past_v, most, log, capacity):
    """Find and measure the periodic orbit of every scene.

    Parameters
    ----------
    scenes : array, shape (n, SINES + 3 sines)
        The columns named above.
    answers : array, shape (n, ANSWER_COLUMNS)
        Written.
    values : array, shape (WAVE_COLUMNS (sines + 1),)
        Work space, as are `past_x`, `past_v` and the log of length `capacity`.
    most : int
        Number of periods after which a scene counts as not converged.
    """
    for i in range(len(scenes)):
        scene, answer = scenes[i], answers[i]
        plant, law = plant_and_law(scene)
        waves = scene_waves(scene, values, law)
        x_r, v_r, multiple, closure, periods, peak, unique = find_orbit(
            plant, law, waves, scene[PERIOD], scene[X_R], scene[V_R], most, past_x, past_v,
            log, capacity,
        )  # fmt: skip
        answer[MULTIPLE], answer[CLOSURE] = max(multiple, 1), closure
        answer[RUN_UP], answer[RUN_UP_PEAK] = periods * scene[PERIOD], peak
        answer[TIME] = answer[RUN_UP]
        if multiple < 0:
            answer[STATUS] = ENDLESS_EVENTS
        elif not (math.isfinite(x_r) and math.isfinite(v_r)):
            answer[STATUS] = OVERFLOW
        elif multiple == 0:
            answer[STATUS] = NOT_CONVERGED
        elif not unique:
            answer[STATUS] = NOT_UNIQUE
        else:
            length = answer[MULTIPLE] * scene[PERIOD]
            answer[STATUS] = CONVERGED
            limits = StrokeLimits(scene[UP], scene[DOWN])
            measure_orbit(plant, law, waves, x_r, v_r, length, limits, log, capacity, answer)


@compiled
def scene_waves(scene, values, law):
    """Return the waves of a scene, written into a table with room for them."""
    base = (len(scene) - SINES) // 3
    for k in range(base):
        at = SINES + 3 * k
        set_wave(values, k, scene[at], scene[at + 1], scene[at + 2])
    if law.variation == 0.0:
        return Waves(values, base, base)
    set_wave(values, base, 0.0, law.omega / (2.0 * math.pi), law.phase)
    return Waves(values, base + 1, base)


@merged
def measure_orbit(plant, law, waves, x_r, v_r, length, limits, log, capacity, answer):
    """Solve one repetition of an orbit and write its integrals, peaks and crossings."""
    d = initial_direction_under_sines(plant, law, waves, x_r, v_r)
    log.s[0], log.kind[0], log.x_r[0] = 0.0, d, x_r
    interval = Interval(int(INTERVAL), 0.0, length, 0.0, 0.0)
    state = SlipState(0.0, x_r, v_r, d, int(ONE_EVENT), math.inf)
    reached, x, v, _, count, _ = march_sines(plant, law, waves, interval, state, log)
    answer[TIME] = reached
    if count < 0 or reached < length or not (math.isfinite(x) and math.isfinite(v)):
        answer[STATUS] = (
            ENDLESS_EVENTS if count < 0 else (LOG_FULL if reached < length else OVERFLOW)
        )
        return
    t, kind, x_events = log.s[:count], log.kind[:count], log.x_r[:count]
    solution = EventSolution(plant, law, waves, t, kind, x_events, v_r)
    answer[X_BEGIN], answer[V_BEGIN] = state_at(solution, 0.0)
    answer[X_END], answer[V_END] = state_at(solution, length)
    sums = integrate_events(solution, 0.0, length)
    answer[X2], answer[V2], answer[X_DD2] = sums.x2, sums.v2, sums.x_dd2
    answer[POWER], answer[SLIDING_DISTANCE] = sums.power, sums.sliding_distance
    answer[STUCK] = sums.stuck
    u_dd2, u2 = mean_squares(waves, 0.0, length)
    answer[U_DD2], answer[U2] = u_dd2 * length, u2 * length
    (
        answer[LOWEST],
        answer[HIGHEST],
        answer[UPCROSSINGS],
        answer[ENTRIES],
    ) = extremes_and_crossings(t, x_events, answer[X_BEGIN], answer[X_END], length, limits)
    answer[EXCURSIONS_UP], answer[EXCURSIONS_DOWN] = 0.0, 0.0
    answer[T_FIRST], answer[TIME_BEYOND] = -1.0, 0.0
    if answer[HIGHEST] >= limits.up or answer[LOWEST] <= -limits.down:
        (
            answer[EXCURSIONS_UP],
            answer[EXCURSIONS_DOWN],
            answer[T_FIRST],
            answer[TIME_BEYOND],
        ) = excursions(solution, answer[X_END], length, limits, True)


# Fixed points of the period map and of its powers.


MAX_MULTIPLE, USUAL_MULTIPLE = 64, 8
"""Longest repetition tested, in periods of the excitation; and the longest one tested after
every period, as hardly any orbit is longer."""

LONG_MULTIPLE_INTERVAL = 16
"""Periods between two tests for the longer repetitions."""

CLOSURE_TOLERANCE = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings."""

STAGNATION_TOLERANCE = 1e-10
"""Closure accepted when it has stopped decreasing: rounding of a stiff scene."""

STAGNATION_PERIODS = 20
"""Periods without a new smallest change that count as stagnation; oscillations of the change
are shorter."""

NEWTON_RADIUS = 1e-2
"""Scaled change per period below which Newton's method is tried."""

NEWTON_REDUCTION = 0.5
"""Factor by which each Newton step must reduce the change."""

NEWTON_PAUSE = 10
"""Periods of plain iteration after the first failure of Newton's method; doubled at each
failure."""


@merged
def find_orbit(plant, law, waves, period, x_r, v_r, most, past_x, past_v, log, capacity):
    """Return the periodic orbit to which the motion from a start converges.

    Parameters as in `iterate_period_map`. Without dry friction the linear steady state replaces
    the start.

    Returns
    -------
    x_r, v_r, multiple, closure, periods, peak
        As in `iterate_period_map`.
    unique : bool
        Whether the orbit attracts its neighbours; false if it is one of a continuum.
    """
    if law.F_fs == 0.0 and plant.k_x > 0.0 and plant.b > 0.0:
        x_r, v_r = linear_steady_state(plant, waves)
    d = initial_direction_under_sines(plant, law, waves, x_r, v_r)
    x_r, v_r, d, multiple, closure, periods, peak = iterate_period_map(
        plant,
        law,
        waves,
        period,
        x_r,
        v_r,
        d,
        period_budget(plant, period, most),
        past_x,
        past_v,
        log,
        capacity,
    )
    unique = True
    length = multiple * period
    if multiple > 0 and decay_count(plant, length) < SLOW_DECAYS:
        unique, distance = uniqueness_and_distance(
            plant, law, waves, length, x_r, v_r, d, log, capacity
        )
        if distance > MAX_ORBIT_DISTANCE:
            multiple = 0
    return x_r, v_r, multiple, closure, periods, peak, unique


@compiled
def initial_direction_under_sines(plant, law, waves, x_r, v_r):
    """Return the direction of sliding at t = 0, 0 for stuck."""
    u_dd = 0.0
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        u_dd += waves.values[at + A] * math.sin(waves.values[at + PHASE])
    load = 1.0 + law.variation * math.sin(law.phase)
    limits = CoulombLaw(law.F_fk * load, law.F_fs * load, law.variation, law.omega, law.phase)
    return initial_direction(plant, limits, x_r, v_r, u_dd)


@merged
def linear_steady_state(plant, waves):
    """Return x_r and v_r at t = 0 of the steady response without dry friction."""
    x_r, v_r = 0.0, 0.0
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        omega, phase = waves.values[at + OMEGA], waves.values[at + PHASE]
        stiff = complex(plant.k_x - plant.m * omega * omega, plant.b * omega)
        turn = complex(math.cos(phase), math.sin(phase))
        swing = -plant.m * waves.values[at + A] * turn / stiff
        x_r += swing.imag
        v_r += omega * swing.real
    return x_r, v_r


@merged
def iterate_period_map(
    plant, law, waves, period, x_r, v_r, d, most, past_x, past_v, log, capacity
):
    """Iterate the period map from a start to a periodic orbit, with Newton steps near it.

    Parameters
    ----------
    plant, law, waves
    period : float
        Period of the excitation [s].
    x_r, v_r, d
        State at t = 0 [m, m/s] and direction of sliding.
    most : int
        Number of periods after which the scene counts as not converged.
    past_x, past_v : array, shape (MAX_MULTIPLE,)
        Work space: states at the start of the latest periods.
    log : EventLog
        Work space.
    capacity : int
        Length of the log.

    Returns
    -------
    x_r, v_r, d
        State at the start of the repetition.
    multiple : int
        Excitation periods per repetition; 0 if not converged, -1 if events recur without
        progress in time.
    closure : float
        Closure residual: largest scaled change over the repetition [-].
    periods : int
        Periods solved.
    peak : float
        Largest |x_r| during the run-up [m].
    """
    rate = characteristic_rate(plant, period)
    highest = abs(x_r)
    events_before = -1
    step_before = math.inf
    smallest = math.inf
    smallest_at = 0
    wait, pause = 0, NEWTON_PAUSE
    refined = False
    fallback_x, fallback_v, fallback_d = x_r, v_r, d
    closure = math.inf
    for n in range(most):
        past_x[n % MAX_MULTIPLE] = x_r
        past_v[n % MAX_MULTIPLE] = v_r
        d_before, x_before, v_before = d, x_r, v_r
        image = period_map(plant, law, waves, period, x_r, v_r, d, log, capacity)
        x_r, v_r, d, events, peak = image
        if events < 0:
            return x_r, v_r, d, -1, closure, n + 1, highest
        step = max(abs(x_r - x_before), abs(v_r - v_before) / rate)
        same_events = (
            events == events_before and d == d_before and events + SINES_LOG_RESERVE <= capacity
        )
        if refined and not (same_events and step < NEWTON_REDUCTION * step_before):
            # The Newton step failed: resume the iteration from the last state of its own.
            x_r, v_r, d = fallback_x, fallback_v, fallback_d
            for i in range(MAX_MULTIPLE):
                past_x[i] = math.inf
            refined, wait, pause = False, pause, 2 * pause
            continue
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
        # Compare with the states 1, 2, ... periods before: the shortest repetition counts.
        for multiple in range(1, min(n + 1, USUAL_MULTIPLE) + 1):
            i = (n + 1 - multiple) % MAX_MULTIPLE
            change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate) / scale
            closure = change if multiple == 1 else min(closure, change)
            if multiple == 1 and change < smallest:
                smallest, smallest_at = change, n
            stagnant = (
                change <= STAGNATION_TOLERANCE
                and change <= 10.0 * smallest
                and n - smallest_at > STAGNATION_PERIODS
            )
            # A closed repetition of k > 1 periods requires a change within a single period.
            is_distinct = multiple == 1 or step > STAGNATION_TOLERANCE * scale
            if is_distinct and (change <= CLOSURE_TOLERANCE or stagnant):
                return x_r, v_r, d, multiple, change, n + 1, highest
        if (n + 1) % LONG_MULTIPLE_INTERVAL == 0 and step > STAGNATION_TOLERANCE * scale:
            limit = (
                STAGNATION_TOLERANCE
                if n - smallest_at > STAGNATION_PERIODS
                else CLOSURE_TOLERANCE
            )
            multiple, change = find_long_multiple(
                past_x, past_v, n, x_r, v_r, rate, limit * scale
            )
            if multiple > 0:
                return x_r, v_r, d, multiple, change / scale, n + 1, highest
        wait -= 1
        if wait <= 0 and step < NEWTON_RADIUS * scale and same_events:
            # With F_fs > F_fk the rest position depends on the path. A failed sequence of
            # Newton steps must then not change the state from which the iteration resumes.
            if not refined or law.F_fs <= law.F_fk:
                fallback_x, fallback_v, fallback_d = x_r, v_r, d
            refined, x_r, v_r = newton_step(
                plant, law, waves, period, rate, x_before, v_before, d, image, log
            )
            if not refined:
                wait = NEWTON_PAUSE
        step_before = step
        events_before = events
    return x_r, v_r, d, 0, closure, most, highest


@compiled
def find_long_multiple(past_x, past_v, n, x_r, v_r, rate, limit):
    """Return the shortest repetition above `USUAL_MULTIPLE` that closes, and its change.

    Parameters
    ----------
    past_x, past_v : array, shape (MAX_MULTIPLE,)
        States at the start of the latest periods; period n ends in state x_r, v_r.
    limit : float
        Largest change of x_r and v_r/rate that counts as closed [m].

    Returns
    -------
    multiple : int
        Repetition in periods, 0 for none.
    change : float
        Its change [m].
    """
    for multiple in range(USUAL_MULTIPLE + 1, min(n + 1, MAX_MULTIPLE) + 1):
        i = (n + 1 - multiple) % MAX_MULTIPLE
        change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate)
        if change <= limit:
            return multiple, change
    return 0, math.inf


# Distance of a slowly changing motion from its orbit.


SLOW_DECAYS = 1e-2
"""Time constants of decay per repetition below which a small change does not prove
convergence."""

CREEP_DECAYS, CREEP_PERIODS = 0.1, 100
"""Time constants of decay over all allowed periods below which an overdamped mass only
creeps, and the number of periods allowed in that case."""

MAX_ORBIT_DISTANCE = 1e-6
"""Scaled distance from an orbit above which a slowly changing motion has not converged."""

REST_SPREAD = 1e-9
"""Share of the largest |x_r| within which a mass that sticks in each period is at rest. It
creeps towards the edge of its stick zone, and all positions in that zone are equivalent."""

SINES_LOG_RESERVE = 2
"""Free places that `march_sines` leaves in a log that held all events of a period."""


@compiled
def decay_count(plant, length):
    """Return the number of time constants of the slowest decay within a time [s], or 0."""
    half = 0.5 * plant.b / plant.m
    w = plant.k_x / plant.m
    square = half * half - w
    if w == 0.0:
        return 2.0 * half * length
    return (w / (half + math.sqrt(square)) if square > 0.0 else half) * length


@compiled
def period_budget(plant, period, most):
    """Return the number of periods after which a motion counts as not converged.

    It is `most`, or `CREEP_PERIODS` for a creeping mass: all `most` periods would cover a tenth
    of its motion at best, so Newton's method or the summed series converges early or nothing
    does.
    """
    half = 0.5 * plant.b / plant.m
    creeps = (
        half * half > plant.k_x / plant.m > 0.0
        and decay_count(plant, most * period) < CREEP_DECAYS
    )
    return min(most, CREEP_PERIODS) if creeps else most


@merged
def uniqueness_and_distance(plant, law, waves, length, x_r, v_r, d, log, capacity):
    """Return whether an orbit is isolated, and the distance of the motion from it.

    Returns
    -------
    unique : bool
        Whether the map of the repetition of `length` [s] is a contraction; false if it keeps
        distances, as for an orbit of a continuum. Without a spring only the velocity contracts
        and all positions are equivalent.
    left : float
        Sum of all further changes of the state, relative to the largest |x_r| [-].
    """
    x_end, v_end, _, events, peak = period_map(
        plant, law, waves, length, x_r, v_r, d, log, capacity
    )
    if events <= 0 or events + SINES_LOG_RESERVE > capacity:
        return True, 0.0
    if d == 0 and event_spread(log, events, x_r) <= REST_SPREAD * peak:
        return True, 0.0
    rate = characteristic_rate(plant, length)
    a, b, c, e = period_map_jacobian(plant, law, waves, length, rate, d, events, log)
    gap_x, gap_v = x_end - x_r, v_end - v_r
    if plant.k_x == 0.0:
        a, b, gap_x = 0.0, 0.0, 0.0
    # Written so that a NaN counts as not contracting.
    if not spectral_radius(a, b, c, e) < MAX_SPECTRAL_RADIUS:
        return False, 0.0
    left_x, left_v = fixed_point_offset(a, b, c, e, rate, gap_x, gap_v)
    return True, max(abs(left_x), abs(left_v) / rate) / (peak if peak > 0.0 else 1.0)


@compiled
def event_spread(log, events, x_r):
    """Return the largest distance of the events of a repetition from a displacement [m]."""
    most = 0.0
    for i in range(events):
        most = max(most, abs(log.x_r[i] - x_r))
    return most


# The period map and its Jacobian.


MAX_SPECTRAL_RADIUS = 1.0 - 1e-7
"""Spectral radius above which the period map counts as neutral: its fixed point is not
isolated."""


@compiled
def period_map(plant, law, waves, period, x_r, v_r, d, log, capacity):
    """Propagate a state through one period.

    Returns
    -------
    x_r, v_r, d
        State at the end of the period.
    events : int
        Number of events; negative if they recur without progress in time.
    peak : float
        Largest |x_r| at an event or at an end of the period [m].
    """
    begin = 0.0
    events = 0
    peak = abs(x_r)
    while begin < period:
        interval = Interval(int(INTERVAL), 0.0, period, 0.0, 0.0)
        state = SlipState(begin, x_r, v_r, d, int(NO_EVENTS), math.inf)
        begin, x_r, v_r, d, count, _ = march_sines(plant, law, waves, interval, state, log)
        if count < 0:
            return x_r, v_r, d, -1, peak
        for i in range(count):
            peak = max(peak, abs(log.x_r[i]))
        events += count
    return x_r, v_r, d, events, max(peak, abs(x_r))


@compiled
def characteristic_rate(plant, period):
    """Return the rate that scales velocities to displacements [1/s]."""
    return max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))


@merged
def newton_step(plant, law, waves, period, rate, x_r, v_r, d, image, log):
    """Take one Newton step from a state with known image under `period_map` to a fixed point.

    Returns
    -------
    good : bool
        Whether the map contracts there, so that the new state is trusted.
    x_r, v_r : float
        The new state; the image if it is not trusted.
    """
    a, b, c, e = period_map_jacobian(plant, law, waves, period, rate, d, image[3], log)
    if not spectral_radius(a, b, c, e) < MAX_SPECTRAL_RADIUS:
        return False, image[0], image[1]
    step_x, step_v = fixed_point_offset(a, b, c, e, rate, image[0] - x_r, image[1] - v_r)
    x_r += step_x
    v_r += step_v
    if d != 0 and d * v_r <= 0.0:
        return False, image[0], image[1]
    return True, x_r, v_r


@compiled
def spectral_radius(a, b, c, e):
    """Return the spectral radius of the matrix [[a, b], [c, e]]."""
    mean = 0.5 * (a + e)
    # Eigenvalues mean ± sqrt(root); of a complex pair the modulus is the root of det.
    root = mean * mean - (a * e - b * c)
    return abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)


@compiled
def fixed_point_offset(a, b, c, e, rate, gap_x, gap_v):
    """Return the offset [m, m/s] from a state to the fixed point of the linearised map.

    `gap_x` and `gap_v` are image minus state; a, b, c, e are scaled as in
    `period_map_jacobian`.
    """
    gap_v /= rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    return (
        ((1.0 - e) * gap_x + b * gap_v) / determinant,
        rate * (c * gap_x + (1.0 - a) * gap_v) / determinant,
    )


@compiled
def period_map_jacobian(plant, law, waves, period, rate, d, events, log):
    """Return the Jacobian of the period map at a state, from the events of one period.

    `period_map` has written the events to the log; the period starts in direction d. `rate` is
    the scale of `characteristic_rate`.

    Returns
    -------
    a, b, c, e : float
        Derivatives of x_r and v_r/rate at the end with respect to x_r (a, c) and to v_r/rate
        (b, e) at the start; infinite where the map is not differentiable.

    Notes
    -----
    The Jacobian is the product of the segment flows and of a saltation matrix per event. An
    event that comes later by tau shifts a neighbouring solution, seen at the same time, by the
    jump of the acceleration times tau.
    """
    damping = plant.b / plant.m
    w = plant.k_x / plant.m
    a, c, b, e = 1.0, 0.0, 0.0, 1.0 if d != 0 else 0.0
    begin = 0.0
    for i in range(events + 1):
        until = log.s[i] if i < events else period
        if d != 0:
            y, y_d, _, _ = flow(damping, w, until - begin)
            # Free motion of the deviation, with velocities divided by `rate`.
            keep = y_d + damping * y
            a, c = keep * a + y * rate * c, y_d * c - w * y / rate * a
            b, e = keep * b + y * rate * e, y_d * e - w * y / rate * b
        if i == events:
            return a, b, c, e
        begin, after = until, direction_after(log.kind[i])
        set_phases(waves, plant, law, begin, d)
        lag = saltation_factor(plant, law, waves, d, after, log.x_r[i])
        # A stop depends on the velocity before it, a break-away on the displacement.
        c, e = (lag * c, lag * e) if d != 0 else (lag * a / rate, lag * b / rate)
        d = after
    return a, b, c, e


@compiled
def saltation_factor(plant, law, waves, d, after, x_r):
    """Return the factor that an event applies to a deviation of the state.

    At a stop it multiplies the deviation of v_r. At a break-away it is the deviation of v_r per
    deviation of x_r [1/s]. The phases of the waves must be set at the event.
    """
    u_dd, u_ddd, _ = base_motion(waves, 0.0, 0.0, 0.0)
    load, load_d, _ = relative_normal_force(law, waves, 0.0)
    free = -(u_dd + plant.k_x / plant.m * x_r)
    slip = law.F_fk * load / plant.m
    if d == 0:
        # Jump of the acceleration, and rate at which F_L approaches the static limit.
        away = after * (law.F_fs - law.F_fk) * load / plant.m
        approach = law.F_fs * load_d + after * plant.m * u_ddd
        if away == 0.0:
            return 0.0
        return away * after * plant.k_x / approach if approach != 0.0 else math.inf
    # Ratio of the accelerations after and before the stop; 0 if the mass sticks.
    stop = free - d * slip
    if after == 0:
        return 0.0
    return (free - after * slip) / stop if stop != 0.0 else math.inf
