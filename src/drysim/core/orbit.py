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
       and of a saltation matrix per event, all in closed form (`event_monodromy`). A step
       must reduce the residual by `NEWTON_REDUCTION` and the spectral radius of DP must be
       below 1; otherwise the iteration resumes from its own state.
    3. Sum the geometric series of the remaining changes, (I - DP)⁻¹ (P(x) - x): the distance to
       the orbit (`uniqueness_and_distance`). Where the free motion decays little per
       repetition, a large sum means that the orbit is not reached, and a spectral radius of 1
       that the orbit is one of a continuum: neutrally stable and not unique.
    4. A repetition of k periods counts only where the motion does not come as close to itself
       over a divisor of k as it does while it swings in on a shorter orbit (`is_distinct`), and
       where its distance to the orbit explains less than the change over that divisor.

The outer loops are compiled into `solve_orbits` (`merged`).

A creeping overdamped mass gets few periods (`period_budget`). `solve_orbits` handles a block of
scenes in one call.

Reference: R. I. Leine and H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical
Systems (2004), for saltation matrices and the Poincaré map of systems with friction.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined, merged
from drysim.core.events import REVERSAL, STICK, Segments
from drysim.core.forcing import (
    OMEGA,
    PHASE,
    SCENE_COLUMNS,
    V_R,
    WAVE_COLUMNS,
    X_R,
    A,
    Scene,
    Waves,
    mean_squares,
    plant_and_law,
    set_wave,
)
from drysim.core.march import (
    Interval,
    initial_slip_state,
    march_sines,
    write_slip_segments,
)
from drysim.core.model import ATTRACTING_MODULUS, StrokeLimits
from drysim.core.modes import coulomb_kernel_law
from drysim.core.sampled import SlipState
from drysim.core.status import LOG_FULL, NOT_SETTLED, NOT_UNIQUE, OVERFLOW
from drysim.core.stroke import (
    crossing_times,
    extremes_and_crossings,
    limit_crossings,
    stroke_side,
    sum_excursions,
)
from drysim.core.trajectory import (
    SampledSolution,
    Solution,
    integrate_segments,
    last_event_index,
    motion_in_segment,
    resume_segment,
)
from drysim.core.variational import event_monodromy

# A block of scenes in one call.


PERIOD, UP, DOWN, SINES = range(SCENE_COLUMNS, SCENE_COLUMNS + 4)
"""Columns of a scene after those of `drysim.core.forcing`: period of the excitation [s] and
stroke limits [m] (infinite for none); from SINES on amplitude [m/s²], frequency [Hz] and
phase [rad] of each sine."""

(
    STATUS, TIME, MULTIPLE, CLOSURE, RUN_UP, RUN_UP_PEAK, X_BEGIN, V_BEGIN, X_END, V_END,
    X2, V2, X_DD2, POWER, SLIDING_DISTANCE, STUCK, U_DD2, U2, LOWEST, HIGHEST, UPCROSSINGS,
    ENTRIES, EXCURSIONS_UP, EXCURSIONS_DOWN, T_FIRST, TIME_BEYOND, TRACE, DETERMINANT,
    STOPS, ASYMMETRY, VIOLATION, ANSWER_COLUMNS,
) = range(32)  # fmt: skip
"""Columns of an answer: `Status`; time reported with a failure [s]; periods per repetition,
closure residual [-] and run-up [s, m] as in `iterate_period_map`; states at both ends of one
repetition; its integrals as in `Totals`; extremes of x_r [m], upcrossings of zero and entries
beyond the limits; excursions as in `excursions`; trace and determinant of the Jacobian of the
repetition, whose eigenvalues are the Floquet multipliers; stops that end sliding, and how far
half the repetition is from the mirror image of the other half, as in `half_wave_change`; the
violation of the laws as in `Totals`.
ANSWER_COLUMNS is the number of columns."""


class SineMarch(NamedTuple):
    """Input of a march under waves, and the log that takes the events of a period."""

    plant: Any
    law: Any
    waves: Any
    log: Any


class PeriodState(NamedTuple):
    """State between two periods: x_r [m], v_r [m/s], direction of sliding (0 when stuck)."""

    x_r: float
    v_r: float
    d: int


class PeriodStarts(NamedTuple):
    """States at the start of the latest periods: arrays of shape (MAX_MULTIPLE,)."""

    x_r: Any
    v_r: Any


class Workspace(NamedTuple):
    """Arrays that `solve_orbits` works with; their contents do not matter, except of `u_dd`.

    Attributes
    ----------
    values : array, shape (WAVE_COLUMNS (sines + 1),)
        Takes the waves of a scene.
    past : PeriodStarts
    log : EventLog
    segments : Segments
        Takes the events of an orbit and its end.
    crossings : Crossings
        Takes those of the stroke limits.
    samples : SampledMotion
        At the ends of an orbit, not used.
    u_dd : array, shape (2,)
        Zeros: base acceleration besides the waves [m/s²].
    """

    values: Any
    past: Any
    log: Any
    segments: Any
    crossings: Any
    samples: Any
    u_dd: Any


class FoundOrbit(NamedTuple):
    """What the search for a periodic orbit found.

    Attributes
    ----------
    state : PeriodState
        At the start of the repetition.
    multiple : int
        Excitation periods per repetition, or the `Status` of a motion without an orbit.
    closure : float
        Closure residual: largest scaled change over the repetition [-].
    periods : int
        Periods solved.
    peak : float
        Largest |x_r| during the run-up [m].
    unique : bool
        False if the orbit is found to be one of a continuum; tested where the decay is slow.
    distance : float
        Estimated distance of the state from the orbit, relative to the largest |x_r| [-];
        infinite where neighbours are not attracted, NaN if unknown.
    """

    state: PeriodState
    multiple: int
    closure: float
    periods: int
    peak: float
    unique: bool
    distance: float


@compiled
def solve_orbits(scenes, answers, most, work):
    """Find and measure the periodic orbit of every scene.

    Parameters
    ----------
    scenes : array, shape (n, SINES + 3 sines)
        The columns named above.
    answers : array, shape (n, ANSWER_COLUMNS)
        Written.
    most : int
        Number of periods after which a scene counts as not converged. With 0 the starts are on
        orbits that are only measured, and `answers` holds their periods per repetition.
    work : Workspace
    """
    for i in range(len(scenes)):
        row, answer = scenes[i], answers[i]
        plant, law = plant_and_law(row)
        scene = SineMarch(plant, law, scene_waves(row, work.values, law), work.log)
        if most > 0:
            orbit = converge_to_orbit(scene, row[PERIOD], row[X_R], row[V_R], most, work.past)
        else:
            state = PeriodState(row[X_R], row[V_R], int(ZERO))
            orbit = FoundOrbit(state, int(answer[MULTIPLE]), 0.0, int(ZERO), 0.0, True, 0.0)
        state, multiple = orbit.state, orbit.multiple
        answer[MULTIPLE], answer[CLOSURE] = max(multiple, 1), orbit.closure
        answer[RUN_UP], answer[RUN_UP_PEAK] = orbit.periods * row[PERIOD], orbit.peak
        answer[TIME] = answer[RUN_UP]
        if multiple < 0:
            answer[STATUS] = float(multiple)
        elif not orbit.unique:
            answer[STATUS] = float(NOT_UNIQUE)
        else:
            answer[STATUS] = 0.0
            length, limits = answer[MULTIPLE] * row[PERIOD], StrokeLimits(row[UP], row[DOWN])
            start = state.x_r, state.v_r
            measure_orbit(scene, start, length, limits, work, answer)


@compiled
def scene_waves(scene, values, law):
    """Return the waves of a scene, written into a table with room for them."""
    base = (len(scene) - SINES) // 3
    for k in range(base):
        row = SINES + 3 * k
        set_wave(values, k, scene[row], scene[row + 1], scene[row + 2])
    if law.variation == 0.0:
        return Waves(values, base, base)
    set_wave(values, base, 0.0, law.omega / (2.0 * math.pi), law.phase)
    return Waves(values, base + 1, base)


@merged
def measure_orbit(scene, start, length, limits, work, answer):
    """Solve one repetition of an orbit and write its integrals, peaks and crossings."""
    (plant, law, waves, log), (x_r, v_r) = scene, start
    interval = Interval(int(ZERO), 0.0, length, 0.0, 0.0)
    state = initial_slip_state(plant, law, waves, x_r, v_r, log)
    end = march_sines(plant, law, waves, interval, state, log)
    _, reached, x, v, _, _, count, _ = end
    answer[TIME] = reached
    if count < 0 or reached < length or not (math.isfinite(x) and math.isfinite(v)):
        answer[STATUS] = float(
            count if count < 0 else (LOG_FULL if reached < length else OVERFLOW)
        )
        return
    t, x_events = log.s[:count], log.x_r[:count]
    solution = orbit_solution(scene, v_r, end, work)
    answer[X_BEGIN], answer[V_BEGIN], answer[X_END], answer[V_END] = x_r, v_r, end.x_r, end.v_r
    sums, _ = integrate_segments(solution, 0.0, length, 0.0)
    answer[X2], answer[V2], answer[X_DD2] = sums.x2, sums.v2, sums.x_dd2
    answer[POWER], answer[SLIDING_DISTANCE] = sums.power, sums.sliding_distance
    answer[STUCK], answer[VIOLATION] = sums.stuck, sums.violation
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
        ) = excursions(solution, (t, x_events), limits, work)
    # The first event is the state at the start.
    a, b, c, e = event_monodromy(scene, length, 1.0, state.d, 1, count)
    answer[TRACE], answer[DETERMINANT] = a + e, a * e - b * c
    answer[STOPS] = count_stops(log, count)
    peak = max(answer[HIGHEST], -answer[LOWEST])
    answer[ASYMMETRY] = half_wave_change(solution, length) / (peak if peak > 0.0 else 1.0)


@merged
def orbit_solution(scene, v_r, end, work):
    """Return a repetition of an orbit as `Solution`, from the events in the log of a scene.

    `v_r` is the velocity at the start [m/s], and `end` the `SlipState` at the end.
    """
    plant, law, waves, log = scene
    write_slip_segments(log, v_r, end, work.segments)
    (n, s, x, v, x_0, d), rows = work.segments, end.events + 1
    segments = Segments(n[:rows], s[:rows], x[:rows], v[:rows], x_0[:rows], d[:rows])
    kernel_law = coulomb_kernel_law(plant, law, work.u_dd)
    return Solution(Scene(plant, kernel_law, waves, work.u_dd, end.s), segments)


@merged
def excursions(solution, path, limits, work):
    """Return the excursions of an orbit with this path, as `sum_excursions`."""
    (scene, rows), (t, x_r), last = solution, path, len(solution.segments.n) - 1
    end, x_end = rows.s[last], rows.x_r[last]
    count = limit_crossings(t, x_r, x_end, end, limits, work.crossings)
    # Each time replaces that before it.
    times = work.crossings.low[:count]
    crossing_times(SampledSolution(scene, work.samples, rows), work.crossings, times)
    sides = stroke_side(x_r[0], limits), stroke_side(x_end, limits)
    return sum_excursions(work.crossings, times, sides, end, True)


@compiled
def count_stops(log, events):
    """Return the number of stops among the events of a motion, however short they are.

    The first event is the state at its start.
    """
    stops = 0
    for i in range(1, events):
        stops += log.kind[i] == STICK
    return stops


@inlined
def half_wave_change(solution, length):
    """Return the change from a state to the mirror image of that half a repetition later [m].

    It is 0 for an orbit whose halves mirror each other. Without a spring only velocities count,
    as all positions are equivalent.
    """
    (plant, _, waves, _, _), (_, s, x_r, v_r, _, _) = solution
    i = last_event_index(s, 0.5 * length)
    part = resume_segment(solution, i)
    x_half, v_half = motion_in_segment(waves, part, 0.5 * length - s[i])
    rate = velocity_scale_rate(plant, length)
    change = abs(x_r[0] + x_half) if plant.k_x > 0.0 else 0.0
    return max(change, abs(v_r[0] + v_half) / rate)


# Fixed points of the period map and of its powers.


MAX_MULTIPLE, USUAL_MULTIPLE = 64, 8
"""Longest repetition tested, in periods of the excitation: the sixth period doubling; and the
longest one tested after every period, the third, as hardly any orbit is longer."""

LONG_MULTIPLE_INTERVAL = 16
"""Periods between two tests for the longer repetitions: these cost half as much as the usual
ones then (56/16 of 8), and an orbit is found at most so many periods late."""

DIVISOR_RATIO = 1e-5
"""Largest ratio of the changes over k periods and over a divisor d of them at which k is the
period. A motion that approaches an orbit of d periods, with a multiplier λ per period, changes
by |λ^k - 1| and |λ^d - 1| times its distance: a ratio above (1 - |λ|)/2. It is larger for all
that settle, with 1 - |λ| above 1e-4; `EXPLAINED_CHANGE` decides about the others."""

EXPLAINED_CHANGE = 4.0
"""Change over a divisor of a repetition, in units of the distance to the orbit, up to which the
orbit has that period: a distance explains a change of (1 + |M|) times as much."""

CLOSURE_TOLERANCE = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings, of
which a motion of a few events makes a dozen. Of 90 drawn orbits all close to a tenth of it."""

STAGNATION_TOLERANCE = 1e-10
"""Closure accepted when it has stopped decreasing: the rounding of each repetition, 3e-15, is
summed over as many as a motion remembers, up to some ten thousand, or magnified in a stiff
scene. No drawn scene needs it."""

STAGNATION_PERIODS = 20
"""Periods without a new smallest change that count as stagnation; oscillations of the change
are shorter."""

NEWTON_RADIUS = 1e-2
"""Scaled change per period below which Newton's method is tried. From ten times as far, none
of 150 drawn motions with F_fs > F_fk reached another orbit than by the period map alone: this
keeps a margin of ten. It takes 12 periods instead of 54 there; a tenth of it takes 15."""

NEWTON_REDUCTION = 0.5
"""Factor by which each Newton step must reduce the change. An exact Jacobian reduces it far
more: with 0.05 or 0.9 the mean number of periods of 90 drawn orbits changes by a tenth."""

NEWTON_PAUSE = 10
"""Periods of plain iteration after the first failure of Newton's method; doubled at each
failure, so that a motion without an orbit is marched without it most of the time. A tenth of it
saves 4 % of the periods of weakly damped scenes, ten times as much costs 17 %."""


@merged
def converge_to_orbit(scene, period, x_r, v_r, most, past):
    """Return the `FoundOrbit` to which the motion from a start converges.

    Without dry friction the linear steady state replaces the start. The last two parameters are
    those of `solve_orbits`.
    """
    plant, law, waves, log = scene
    if law.F_fs == 0.0 and plant.k_x > 0.0 and plant.b > 0.0:
        x_r, v_r = linear_steady_state(plant, waves)
    d = initial_slip_state(plant, law, waves, x_r, v_r, log).d
    state, multiple, closure, periods, peak = iterate_period_map(
        scene, period, PeriodState(x_r, v_r, d), period_budget(plant, period, most), past
    )
    unique, distance = True, math.nan
    if multiple > 0:
        length = multiple * period
        attracts, distance = uniqueness_and_distance(scene, length, state)
        if decay_count(plant, length) < SLOW_DECAYS:
            unique = attracts
            if attracts and distance > MAX_ORBIT_DISTANCE:
                multiple = NOT_SETTLED
    if multiple > 1 and distance < math.inf:
        multiple, closure = shortest_period(scene, period, state, multiple, closure, distance)
    return FoundOrbit(state, multiple, closure, periods, peak, unique, distance)


@merged
def shortest_period(scene, period, state, multiple, closure, distance):
    """Return the periods per repetition of an orbit, and the closure residual over them.

    They are the smallest divisor of `multiple` over which the motion changes no more than its
    distance to the orbit explains.
    """
    rate = velocity_scale_rate(scene.plant, period)
    for fewer in range(1, multiple // 2 + 1):
        if multiple % fewer == 0:
            end, events, peak = period_map(scene, fewer * period, state)
            change = state_change(end, state.x_r, state.v_r, rate)
            scale = peak if peak > 0.0 else 1.0
            if events >= 0 and change <= EXPLAINED_CHANGE * distance * scale:
                return fewer, change / scale
    return multiple, closure


@merged
def linear_steady_state(plant, waves):
    """Return x_r and v_r at t = 0 of the steady response without dry friction."""
    x_r, v_r = 0.0, 0.0
    for i in range(waves.base):
        row = WAVE_COLUMNS * i
        omega, phase = waves.values[row + OMEGA], waves.values[row + PHASE]
        stiff = complex(plant.k_x - plant.m * omega * omega, plant.b * omega)
        turn = complex(math.cos(phase), math.sin(phase))
        swing = -plant.m * waves.values[row + A] * turn / stiff
        x_r += swing.imag
        v_r += omega * swing.real
    return x_r, v_r


@merged
def iterate_period_map(scene, period, state, most, past):
    """Iterate the period map from a start to a periodic orbit, with Newton steps near it.

    `most` is the number of periods after which the scene counts as not converged. Returns the
    first five values of `FoundOrbit`.
    """
    law = scene.law
    rate = velocity_scale_rate(scene.plant, period)
    highest = abs(state.x_r)
    events_before = -1
    step_before = math.inf
    smallest = math.inf
    smallest_at = 0
    pause_left, pause_length = 0, NEWTON_PAUSE
    refined = False
    fallback = state
    closure = math.inf
    for n in range(most):
        past.x_r[n % MAX_MULTIPLE] = state.x_r
        past.v_r[n % MAX_MULTIPLE] = state.v_r
        before = state
        state, events, peak = period_map(scene, period, before)
        if events < 0:
            return state, events, closure, n + 1, highest
        step = state_change(state, before.x_r, before.v_r, rate)
        same_events = (
            events == events_before
            and state.d == before.d
            and events + SINES_LOG_RESERVE <= len(scene.log.kind)
        )
        if refined and not (same_events and step < NEWTON_REDUCTION * step_before):
            # The Newton step failed: resume the iteration from the last state of its own.
            state = fallback
            for i in range(MAX_MULTIPLE):
                past.x_r[i] = math.inf
            refined, pause_left, pause_length = False, pause_length, 2 * pause_length
            continue
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
        # Compare with the states 1, 2, ... periods before: the shortest repetition counts.
        longest = MAX_MULTIPLE if (n + 1) % LONG_MULTIPLE_INTERVAL == 0 else USUAL_MULTIPLE
        for multiple in range(1, min(n + 1, longest) + 1):
            change = change_since(past, n + 1 - multiple, state, rate) / scale
            closure = change if multiple == 1 else min(closure, change)
            if multiple == 1 and change < smallest:
                smallest, smallest_at = change, n
            stagnant = (
                change <= STAGNATION_TOLERANCE
                and change <= 10.0 * smallest
                and n - smallest_at > STAGNATION_PERIODS
            )
            is_closed = change <= CLOSURE_TOLERANCE or stagnant
            if is_closed and is_distinct(past, n + 1, state, rate, multiple, change * scale):
                return state, multiple, change, n + 1, highest
        pause_left -= 1
        if pause_left <= 0 and step < NEWTON_RADIUS * scale and same_events:
            # With F_fs > F_fk the rest position depends on the path. A failed sequence of
            # Newton steps must then not change the state from which the iteration resumes.
            if not refined or law.F_fs <= law.F_fk:
                fallback = state
            refined, state = newton_step(scene, period, rate, before, state, events)
            if not refined:
                pause_left = NEWTON_PAUSE
        step_before = step
        events_before = events
    finite = math.isfinite(state.x_r) and math.isfinite(state.v_r)
    return state, NOT_SETTLED if finite else OVERFLOW, closure, most, highest


@compiled
def is_distinct(past, n, state, rate, multiple, change):
    """Return whether a repetition is none of fewer periods that is still being approached.

    The change [m] over `multiple` periods must be far smaller than that over each divisor.
    `past` holds the states up to that before period n.
    """
    for fewer in range(1, multiple // 2 + 1):
        earlier = change_since(past, n - fewer, state, rate)
        if multiple % fewer == 0 and not change <= DIVISOR_RATIO * earlier:
            return False
    return True


@inlined
def change_since(past, n, state, rate):
    """Return the change of a state since the start of period n [m]."""
    return state_change(state, past.x_r[n % MAX_MULTIPLE], past.v_r[n % MAX_MULTIPLE], rate)


@inlined
def state_change(state, x_r, v_r, rate):
    """Return the larger of the changes of x_r and of v_r/rate from another state [m]."""
    return max(abs(state.x_r - x_r), abs(state.v_r - v_r) / rate)


# Distance of a slowly changing motion from its orbit.


SLOW_DECAYS = 1e-2
"""Time constants of decay per repetition below which a small change does not prove
convergence. Above, the distance to the orbit is less than a hundred times the change: 1e-11 at
`CLOSURE_TOLERANCE`."""

CREEP_DECAYS, CREEP_PERIODS = 0.1, 100
"""Time constants of decay over all allowed periods below which an overdamped mass only
creeps, and the number of periods allowed in that case: a tenth of a time constant is far from
any orbit, and Newton's method has taken over within some tens of periods or never does."""

MAX_ORBIT_DISTANCE = 1e-6
"""Scaled distance from an orbit above which a slowly changing motion has not converged: six
digits of every metric, as many as are printed."""

REST_SPREAD = 1e-9
"""Share of the largest |x_r| within which a mass that sticks in each period is at rest: far
above the rounding of x_r, and below all that is printed. It creeps towards the edge of its
stick zone, and all positions in that zone are equivalent."""

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


ROUNDING_PER_REPETITION = 3e-15
"""Relative rounding error of the motion over a repetition [-]: a dozen roundings."""


@merged
def uniqueness_and_distance(scene, length, state):
    """Return whether an orbit is isolated, and the distance of the motion from it.

    Returns
    -------
    unique : bool
        Whether the map of the repetition of `length` [s] is a contraction; false if it keeps
        distances, as for an orbit of a continuum. Without a spring only the velocity contracts
        and all positions are equivalent.
    left : float
        Sum of all further changes of the state and of the rounding in each repetition, relative
        to the largest |x_r| [-]; infinite without contraction, NaN where the log is full.
    """
    plant, log = scene.plant, scene.log
    end, events, peak = period_map(scene, length, state)
    if events < 0 or events + SINES_LOG_RESERVE > len(log.kind):
        return True, math.nan
    if state.d == 0 and event_spread(log, events, state.x_r) <= REST_SPREAD * peak:
        return True, 0.0
    rate = velocity_scale_rate(plant, length)
    a, b, c, e = event_monodromy(scene, length, rate, state.d, int(ZERO), events)
    gap_x, gap_v = end.x_r - state.x_r, end.v_r - state.v_r
    if plant.k_x == 0.0:
        a, b, gap_x = 0.0, 0.0, 0.0
    # Written so that a NaN counts as not contracting.
    if not spectral_radius(a, b, c, e) < ATTRACTING_MODULUS:
        return False, math.inf
    left_x, left_v = fixed_point_offset(a, b, c, e, rate, gap_x, gap_v)
    left = max(abs(left_x), abs(left_v) / rate) / (peak if peak > 0.0 else 1.0)
    row = max(abs(1.0 - e) + abs(b), abs(c) + abs(1.0 - a))
    amplification = row / abs((1.0 - a) * (1.0 - e) - b * c)
    return True, left + ROUNDING_PER_REPETITION * amplification


@compiled
def event_spread(log, events, x_r):
    """Return the largest distance of the events of a repetition from a displacement [m]."""
    most = 0.0
    for i in range(events):
        most = max(most, abs(log.x_r[i] - x_r))
    return most


# The period map.


@compiled
def period_map(scene, period, state):
    """Propagate a state through one period.

    Returns
    -------
    state : PeriodState
        State at the end of the period.
    events : int
        Number of events, or a `Status`.
    peak : float
        Largest |x_r| at an event or at an end of the period [m].
    """
    plant, law, waves, log = scene
    x_r, v_r, d = state
    begin = 0.0
    events = 0
    peak = abs(x_r)
    while begin < period:
        interval = Interval(int(ZERO), 0.0, period, 0.0, 0.0)
        none = int(ZERO)
        state = SlipState(none, begin, x_r, v_r, d, math.nan, none, math.inf)
        state = march_sines(plant, law, waves, interval, state, log)
        _, begin, x_r, v_r, d, _, count, _ = state
        if count < 0:
            return PeriodState(x_r, v_r, d), count, peak
        for i in range(count):
            peak = max(peak, abs(log.x_r[i]))
        events += count
    return PeriodState(x_r, v_r, d), events, max(peak, abs(x_r))


(
    X_IMAGE, V_IMAGE, X_BY_X, X_BY_V, V_BY_X, V_BY_V, IMAGE_STOPS, IMAGE_REVERSALS,
    IMAGE_PEAK, IMAGE_EVENTS, IMAGE_COLUMNS,
) = range(11)  # fmt: skip
"""Columns of an image: state after a repetition [m, m/s], its derivatives with respect to the
state before, stops and immediate reversals, largest |x_r| at an event or an end [m], number of
all events or `Status`."""


@compiled
def flow_and_monodromy(row, values, length, x_r, v_r, log, image):
    """Propagate a state through a time and differentiate its image.

    Parameters
    ----------
    row : array, shape (SINES + 3 sines,)
        A scene, as in `solve_orbits`.
    values : array
        Work space, as in `Workspace`.
    length : float
        Time [s].
    x_r, v_r : float
        State at t = 0 [m, m/s].
    log : EventLog
        Written: the events.
    image : array, shape (IMAGE_COLUMNS,)
        Written, columns as named above; with a `Status`, the derivatives are not.
    """
    plant, law = plant_and_law(row)
    scene = SineMarch(plant, law, scene_waves(row, values, law), log)
    d = initial_slip_state(plant, law, scene.waves, x_r, v_r, log).d
    end, events, peak = period_map(scene, length, PeriodState(x_r, v_r, d))
    image[X_IMAGE], image[V_IMAGE], image[IMAGE_PEAK] = end.x_r, end.v_r, peak
    if events + SINES_LOG_RESERVE > len(log.kind):
        events = LOG_FULL
    image[IMAGE_STOPS], image[IMAGE_REVERSALS], image[IMAGE_EVENTS] = 0.0, 0.0, float(events)
    if events < 0:
        return
    a, b, c, e = event_monodromy(scene, length, 1.0, d, int(ZERO), events)
    image[X_BY_X], image[X_BY_V], image[V_BY_X], image[V_BY_V] = a, b, c, e
    for i in range(events):
        if log.kind[i] == STICK:
            image[IMAGE_STOPS] += 1.0
        elif abs(log.kind[i]) == REVERSAL:
            image[IMAGE_REVERSALS] += 1.0


@compiled
def velocity_scale_rate(plant, period):
    """Return the rate that scales velocities to displacements [1/s]."""
    return max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))


@merged
def newton_step(scene, period, rate, before, image, events):
    """Take one Newton step from a state with known image under `period_map` to a fixed point.

    Returns
    -------
    good : bool
        Whether the map contracts there, so that the new state is trusted.
    state : PeriodState
        The new state; the image if it is not trusted.
    """
    a, b, c, e = event_monodromy(scene, period, rate, image.d, int(ZERO), events)
    if not spectral_radius(a, b, c, e) < ATTRACTING_MODULUS:
        return False, image
    gap_x, gap_v = image.x_r - before.x_r, image.v_r - before.v_r
    step_x, step_v = fixed_point_offset(a, b, c, e, rate, gap_x, gap_v)
    x_r, v_r = before.x_r + step_x, before.v_r + step_v
    if image.d != 0 and image.d * v_r <= 0.0:
        return False, image
    return True, PeriodState(x_r, v_r, image.d)


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
    `event_monodromy`.
    """
    gap_v /= rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    return (
        ((1.0 - e) * gap_x + b * gap_v) / determinant,
        rate * (c * gap_x + (1.0 - a) * gap_v) / determinant,
    )
