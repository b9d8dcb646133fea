"""The periodic orbits of scenes under sines: found, told apart from a continuum, and measured.

A start is followed period by period (`iterate_period_map`) until the state comes back to where it was one
or several periods before: the orbit is closed, of that multiple. That may take long where
little dies out. So, close to an orbit, Newton's method takes over (`newton_step`): it needs the
slopes of the period map, which the events on the way give in closed form (`period_map_jacobian`); it must
bring the change down at every step, else the motion goes on from where it was.

A change that is small need not mean that the orbit is near. Where what dies out slowest hardly
does so within a repetition, `uniqueness_and_distance` sums up what the motion would go on changing by; and an
orbit whose map does not draw its neighbours is one of a continuum, which no start settles. A
mass that only creeps is given few periods (`period_budget`).

`solve_orbits` finds and measures the orbits of a block of scenes in one call.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled
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
from drysim.core.march import march_sines
from drysim.core.model import CoulombLaw
from drysim.core.oscillator import flow
from drysim.core.trajectory import (
    excursions,
    integrate_coulomb_events,
    peak_and_crossings,
    state_at,
)

# Many scenes: one call finds and measures a block.


PERIOD, X_RM, SINES = range(SCENE_COLUMNS, SCENE_COLUMNS + 3)
"""Columns of a scene behind those of `drysim.core.forcing`: period of the excitation [s],
stroke limit (infinite for none); from SINES on amplitude [m/s²], frequency [Hz] and phase [rad]
of each sine."""

(
    STATUS, TIME, MULTIPLE, CLOSURE, RUN_UP, RUN_UP_PEAK, X_BEGIN, V_BEGIN, X_END, V_END,
    X2, V2, X_DD2, POWER, SLIDING_DISTANCE, STUCK, U_DD2, U2, PEAK, UPCROSSINGS, ENTRIES,
    EXCURSIONS, T_FIRST, TIME_BEYOND, ANSWER_COLUMNS,
) = range(25)  # fmt: skip
"""Columns of an answer: status; the time that a failure is told with [s]; periods, closure [-]
and run-up [s, m] as in `iterate_period_map`; the states at both ends of one repetition; its integrals as in
`Totals`; greatest |x_r| [m], upcrossings of zero and entries beyond the limit; excursions as in
`excursions`. FOUND is their number."""

CONVERGED, NOT_CONVERGED, NOT_UNIQUE, ENDLESS_EVENTS, OVERFLOW, LOG_FULL = range(6)
"""What became of a scene; the last three have no orbit: events without end, a motion beyond the
numbers, and more events in a repetition than the log holds."""


@compiled
def solve_orbits(scenes, answers, values, past_x, past_v, most, log, capacity):
    """Find and measure the orbit of every scene.

    Parameters
    ----------
    scenes : array, shape (n, SINES + 3 sines)
        The columns named above.
    answers : array, shape (n, FOUND)
        Written.
    values : array, shape (STRIDE (sines + 1),)
        Scratch, as are `past_x`, `past_v` and the log, which has `capacity` places.
    most : int
        Periods after which a scene counts as not settled.
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
            measure_orbit(
                plant, law, waves, x_r, v_r, length, scene[X_RM], log, capacity, answer
            )


@compiled
def scene_waves(scene, values, law):
    """Give the waves of a scene, written into a table that has room for them."""
    base = (len(scene) - SINES) // 3
    for k in range(base):
        at = SINES + 3 * k
        set_wave(values, k, scene[at], scene[at + 1], scene[at + 2])
    if law.variation == 0.0:
        return Waves(values, base, base)
    set_wave(values, base, 0.0, law.omega / (2.0 * math.pi), law.phase)
    return Waves(values, base + 1, base)


@compiled
def measure_orbit(plant, law, waves, x_r, v_r, length, x_rM, log, capacity, answer):
    """Follow one repetition of an orbit from its beginning, and write what it comes to."""
    d = initial_direction_under_sines(plant, law, waves, x_r, v_r)
    log.s[0], log.kind[0], log.x_r[0] = 0.0, d, x_r
    reached, x, v, _, count, _ = march_sines(
        plant, law, waves, 0.0, 0.0, 0, 0.0, length, 0.0, x_r, v_r, d, log, 1, capacity
    )
    answer[TIME] = reached
    if count < 0 or reached < length or not (math.isfinite(x) and math.isfinite(v)):
        answer[STATUS] = (
            ENDLESS_EVENTS if count < 0 else (LOG_FULL if reached < length else OVERFLOW)
        )
        return
    t, kind, x_events = log.s[:count], log.kind[:count], log.x_r[:count]
    scene = (plant, law, waves, t, kind, x_events, v_r)
    answer[X_BEGIN], answer[V_BEGIN] = state_at(*scene, 0.0)
    answer[X_END], answer[V_END] = state_at(*scene, length)
    (
        answer[X2],
        answer[V2],
        answer[X_DD2],
        answer[POWER],
        answer[SLIDING_DISTANCE],
        answer[STUCK],
    ) = integrate_coulomb_events(*scene, 0.0, length)
    u_dd2, u2 = mean_squares(waves, 0.0, length)
    answer[U_DD2], answer[U2] = u_dd2 * length, u2 * length
    answer[PEAK], answer[UPCROSSINGS], answer[ENTRIES] = peak_and_crossings(
        t, x_events, answer[X_BEGIN], answer[X_END], length, x_rM
    )
    answer[EXCURSIONS], answer[T_FIRST], answer[TIME_BEYOND] = 0.0, -1.0, 0.0
    if answer[PEAK] >= x_rM:
        answer[EXCURSIONS], answer[T_FIRST], answer[TIME_BEYOND] = excursions(
            *scene, answer[X_END], length, x_rM, True
        )


# The orbit that a start leads to: a fixed point of the period map or of its powers.


MAX_MULTIPLE, USUAL_MULTIPLE = 64, 8
"""Longest repetition looked for, in periods of the excitation; and up to which in each period,
as hardly any orbit takes longer."""

LONG_MULTIPLE_INTERVAL = 16
"""Periods from one look for the longer ones to the next."""

CLOSURE_TOLERANCE = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings."""

STAGNATION_TOLERANCE = 1e-10
"""A change below this that has long found no smaller one is rounding of a stiff scene."""

STAGNATION_PERIODS = 20
"""Periods without a new smallest change: swings of the change itself are shorter."""

NEWTON_RADIUS = 1e-2
"""Scaled change below which Newton's method may take over."""

NEWTON_REDUCTION = 0.5
"""Share of the change before to which each of Newton's steps must bring it."""

NEWTON_PAUSE = 10
"""Periods of the motion itself after Newton's method has failed first; then twice as many."""


@compiled
def find_orbit(plant, law, waves, period, x_r, v_r, most, past_x, past_v, log, capacity):
    """Give the periodic orbit that a start leads to.

    Parameters as in `iterate_period_map`, from rest on; without dry friction the steady motion itself is
    the start.

    Returns
    -------
    x_r, v_r, multiple, closure, periods, peak
        As in `iterate_period_map`.
    unique : bool
        Whether neighbours are drawn to the orbit; false for one of a continuum.
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
    """Give the direction of sliding at t = 0, 0 for stuck."""
    u_dd = 0.0
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        u_dd += waves.values[at + A] * math.sin(waves.values[at + PHASE])
    load = 1.0 + law.variation * math.sin(law.phase)
    limits = CoulombLaw(law.F_fk * load, law.F_fs * load, law.variation, law.omega, law.phase)
    return initial_direction(plant, limits, x_r, v_r, u_dd)


@compiled
def linear_steady_state(plant, waves):
    """Give the steady x_r and v_r at t = 0 of the oscillator without dry friction."""
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


@compiled
def iterate_period_map(
    plant, law, waves, period, x_r, v_r, d, most, past_x, past_v, log, capacity
):
    """Follow a start to the periodic orbit it leads to.

    Parameters
    ----------
    plant, law, waves
    period : float
        Of the excitation [s].
    x_r, v_r, d
        State at t = 0.
    most : int
        Periods after which the scene counts as not settled.
    past_x, past_v : array, shape (MOST_MULTIPLE,)
        Scratch.
    log : Log
        Scratch.
    capacity : int
        Length of the log.

    Returns
    -------
    x_r, v_r, d
        At the beginning of the repetition.
    multiple : int
        Excitation periods in the repetition; 0 when not settled, -1 when events follow each
        other without end.
    closure : float
        Largest scaled change over the repetition [-].
    periods : int
        Periods followed.
    peak : float
        Largest |x_r| on the way [m].
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
            # Newton leads astray: the motion goes on from where it was.
            x_r, v_r, d = fallback_x, fallback_v, fallback_d
            for i in range(MAX_MULTIPLE):
                past_x[i] = math.inf
            refined, wait, pause = False, pause, 2 * pause
            continue
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
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
            # Where a mass may come to rest depends on its way there, if F_fs exceeds F_fk: a
            # step that leads to no orbit must leave no trace then.
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
    """Return the shortest repetition beyond the usual over which a state changes little enough.

    `past_x` and `past_v` are the states at the beginning of the latest periods, the last of
    which is the n-th and ends with the state given; a change of x_r and v_r/rate up to `limit`
    [m] is little. Gives the repetition in periods, 0 for none, and its change [m].
    """
    for multiple in range(USUAL_MULTIPLE + 1, min(n + 1, MAX_MULTIPLE) + 1):
        i = (n + 1 - multiple) % MAX_MULTIPLE
        change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate)
        if change <= limit:
            return multiple, change
    return 0, math.inf


# How far a motion that hardly changes any more still is from its orbit.


SLOW_DECAYS = 1e-2
"""Decays over a repetition below which little change does not yet mean a closed orbit."""

CREEP_DECAYS, CREEP_PERIODS = 0.1, 100
"""Decays over all the periods that a motion is given, below which an overdamped mass only
creeps; and the periods that it is given then."""

MAX_ORBIT_DISTANCE = 1e-6
"""Scaled distance from an orbit at which a motion that hardly changes has not reached it."""

REST_SPREAD = 1e-9
"""Share of the largest |x_r| within which a mass that sticks in each period is as good as at
rest: it creeps to the edge of where it may stay, and any place within is like another."""

SINES_LOG_RESERVE = 2
"""Places that `march_sines` leaves free in a log that held all events of a period."""


@compiled
def decay_count(plant, length):
    """Give how often what dies out slowest falls by e within a time [s]; 0 for never."""
    half = 0.5 * plant.b / plant.m
    w = plant.k_x / plant.m
    square = half * half - w
    if w == 0.0:
        return 2.0 * half * length
    return (w / (half + math.sqrt(square)) if square > 0.0 else half) * length


@compiled
def period_budget(plant, period, most):
    """Give after how many periods, `most` as a rule, a motion counts as not settled.

    Where all of them would take it a tenth of its way at best, Newton's method or a sum of
    changes leads it to its orbit soon, or nothing does.
    """
    half = 0.5 * plant.b / plant.m
    creeps = (
        half * half > plant.k_x / plant.m > 0.0
        and decay_count(plant, most * period) < CREEP_DECAYS
    )
    return min(most, CREEP_PERIODS) if creeps else most


@compiled
def uniqueness_and_distance(plant, law, waves, length, x_r, v_r, d, log, capacity):
    """Tell whether an orbit is the only one around, and how far from it the motion still is.

    Returns
    -------
    unique : bool
        Whether the map of its repetition, `length` [s], draws neighbours; false for one that
        keeps distances, as those of a continuum do. Without a spring only speeds are drawn: no
        place is like another then.
    left : float
        What the motion would go on changing by, summed up and over its largest |x_r| [-].
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
    if not spectral_radius(a, b, c, e) < MAX_SPECTRAL_RADIUS:
        return False, 0.0
    left_x, left_v = fixed_point_offset(a, b, c, e, rate, gap_x, gap_v)
    return True, max(abs(left_x), abs(left_v) / rate) / (peak if peak > 0.0 else 1.0)


@compiled
def event_spread(log, events, x_r):
    """Give how far from a place the events of a repetition are [m]."""
    most = 0.0
    for i in range(events):
        most = max(most, abs(log.x_r[i] - x_r))
    return most


# The period map: what one period of the excitation makes of a state, and of its neighbours.


MAX_SPECTRAL_RADIUS = 1.0 - 1e-7
"""A map that shrinks distances less than this is marginal; Newton would pick any orbit."""


@compiled
def period_map(plant, law, waves, period, x_r, v_r, d, log, capacity):
    """Carry a state through one period.

    Returns
    -------
    x_r, v_r, d
        At the end of the period.
    events : int
        Number of events, negative when they follow each other without end.
    peak : float
        Largest |x_r| at an event or an end [m].
    """
    begin = 0.0
    events = 0
    peak = abs(x_r)
    while begin < period:
        begin, x_r, v_r, d, count, _ = march_sines(
            plant, law, waves, 0.0, 0.0, 0, 0.0, period, begin, x_r, v_r, d, log, 0, capacity
        )
        if count < 0:
            return x_r, v_r, d, -1, peak
        for i in range(count):
            peak = max(peak, abs(log.x_r[i]))
        events += count
    return x_r, v_r, d, events, max(peak, abs(x_r))


@compiled
def characteristic_rate(plant, period):
    """Give what turns velocities into displacements of like size [1/s]."""
    return max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))


@compiled
def newton_step(plant, law, waves, period, rate, x_r, v_r, d, image, log):
    """Take one Newton step from a state, of which `period_map` made `image`, to a fixed point.

    Returns
    -------
    good : bool
        Whether the map contracts there, so that the better state may be trusted.
    x_r, v_r : float
        The better state; the image where there is none.
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
    """Give the factor by which a map with these slopes stretches in the long run."""
    mean = 0.5 * (a + e)
    root = mean * mean - (a * e - b * c)
    return abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)


@compiled
def fixed_point_offset(a, b, c, e, rate, gap_x, gap_v):
    """Give how far [m, m/s] the fixed point of a map with these slopes is from a state.

    The gaps are what the map changes of that state.
    """
    gap_v /= rate
    determinant = (1.0 - a) * (1.0 - e) - b * c
    return (
        ((1.0 - e) * gap_x + b * gap_v) / determinant,
        rate * (c * gap_x + (1.0 - a) * gap_v) / determinant,
    )


@compiled
def period_map_jacobian(plant, law, waves, period, rate, d, events, log):
    """Give the slopes of the period map at a state, from the events on its way.

    `period_map` has written those to the log; it began in direction d. `rate` is that of
    `characteristic_rate`.

    Returns
    -------
    a, b, c, e : float
        Change of x_r and v_r/rate at the end for one of x_r (a, c) and of v_r/rate (b, e);
        infinite where a neighbour, however near, does something else.

    Notes
    -----
    An event that comes later by tau leaves a neighbour that, seen at one instant, lags by the
    acceleration times tau: what dynamics with jumps calls a saltation matrix.
    """
    damping = plant.b / plant.m
    w = plant.k_x / plant.m
    a, c, b, e = 1.0, 0.0, 0.0, 1.0 if d != 0 else 0.0
    begin = 0.0
    for i in range(events + 1):
        until = log.s[i] if i < events else period
        if d != 0:
            y, y_d, _, _ = flow(damping, w, until - begin)
            keep = y_d + damping * y
            a, c = keep * a + y * rate * c, y_d * c - w * y / rate * a
            b, e = keep * b + y * rate * e, y_d * e - w * y / rate * b
        if i == events:
            return a, b, c, e
        begin, after = until, direction_after(log.kind[i])
        set_phases(waves, plant, law, begin, d)
        lag = saltation_factor(plant, law, waves, d, after, log.x_r[i])
        # Stops are felt by the velocity before them, break-aways by the place of the mass.
        c, e = (lag * c, lag * e) if d != 0 else (lag * a / rate, lag * b / rate)
        d = after
    return a, b, c, e


@compiled
def saltation_factor(plant, law, waves, d, after, x_r):
    """Give what an event makes of a neighbour's distance: the factor on its velocity.

    At a break-away it is the velocity for a distance in x_r [1/s]; waves are anchored at the
    event.
    """
    u_dd, u_ddd, _ = base_motion(waves, 0.0, 0.0, 0.0)
    load, load_d, _ = relative_normal_force(law, waves, 0.0)
    free = -(u_dd + plant.k_x / plant.m * x_r)
    slip = law.F_fk * load / plant.m
    if d == 0:
        away = after * (law.F_fs - law.F_fk) * load / plant.m
        approach = law.F_fs * load_d + after * plant.m * u_ddd
        if away == 0.0:
            return 0.0
        return away * after * plant.k_x / approach if approach != 0.0 else math.inf
    stop = free - d * slip
    if after == 0:
        return 0.0
    return (free - after * slip) / stop if stop != 0.0 else math.inf
