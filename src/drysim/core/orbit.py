"""The periodic orbits of scenes under sines: found, told apart from a continuum, and measured.

A start is followed period by period (`settle`) until the state comes back to where it was one
or several periods before: the orbit is closed, of that multiple. That may take long where
little dies out. So, close to an orbit, Newton's method takes over (`refine`): it needs the
slopes of the period map, which the events on the way give in closed form (`slopes`); it must
bring the change down at every step, else the motion goes on from where it was.

A change that is small need not mean that the orbit is near. Where what dies out slowest hardly
does so within a repetition, `reached` sums up what the motion would go on changing by; and an
orbit whose map does not draw its neighbours is one of a continuum, which no start settles. A
mass that only creeps is given few periods (`patience`).

`solve_orbits` finds and measures the orbits of a block of scenes in one call.
"""

from __future__ import annotations

import math

from drysim.core.compile import compiled
from drysim.core.events import direction, first_mode
from drysim.core.forcing import (
    OMEGA,
    PHASE,
    REST,
    STRIDE,
    V_R,
    X_R,
    A,
    Waves,
    anchor,
    base_motion,
    mean_squares,
    normal_force,
    plant_and_law,
    set_wave,
)
from drysim.core.march import leap
from drysim.core.model import Law
from drysim.core.oscillator import flow
from drysim.core.trajectory import excursions, integrate_leaps, passages, state_at

# Many scenes: one call finds and measures a block.


PERIOD, X_RM, SINES = range(REST, REST + 3)
"""Columns of a scene behind those of `drysim.core.forcing`: period of the excitation [s],
stroke limit (infinite for none); from SINES on amplitude [m/s²], frequency [Hz] and phase [rad]
of each sine."""

(
    STATUS, TIME, MULTIPLE, CLOSURE, RUN_UP, RUN_UP_PEAK, X_BEGIN, V_BEGIN, X_END, V_END,
    X2, V2, X_DD2, POWER, RUB, STUCK, U_DD2, U2, PEAK, UPCROSSINGS, ENTRIES,
    TIMES, T_FIRST, T_BEYOND, FOUND,
) = range(25)  # fmt: skip
"""Columns of an answer: status; the time that a failure is told with [s]; periods, closure [-]
and run-up [s, m] as in `settle`; the states at both ends of one repetition; its integrals as in
`Totals`; greatest |x_r| [m], upcrossings of zero and entries beyond the limit; excursions as in
`excursions`. FOUND is their number."""

SETTLED, NOT_SETTLED, NOT_UNIQUE, STORM, OVERFLOW, CROWDED = range(6)
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
        waves = waves_in(scene, values, law)
        x_r, v_r, multiple, closure, periods, peak, unique = find(
            plant, law, waves, scene[PERIOD], scene[X_R], scene[V_R], most, past_x, past_v,
            log, capacity,
        )  # fmt: skip
        answer[MULTIPLE], answer[CLOSURE] = max(multiple, 1), closure
        answer[RUN_UP], answer[RUN_UP_PEAK] = periods * scene[PERIOD], peak
        answer[TIME] = answer[RUN_UP]
        if multiple < 0:
            answer[STATUS] = STORM
        elif not (math.isfinite(x_r) and math.isfinite(v_r)):
            answer[STATUS] = OVERFLOW
        elif multiple == 0:
            answer[STATUS] = NOT_SETTLED
        elif not unique:
            answer[STATUS] = NOT_UNIQUE
        else:
            length = answer[MULTIPLE] * scene[PERIOD]
            answer[STATUS] = SETTLED
            measure(plant, law, waves, x_r, v_r, length, scene[X_RM], log, capacity, answer)


@compiled
def waves_in(scene, values, law):
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
def measure(plant, law, waves, x_r, v_r, length, x_rM, log, capacity, answer):
    """Follow one repetition of an orbit from its beginning, and write what it comes to."""
    d = first_direction(plant, law, waves, x_r, v_r)
    log.s[0], log.kind[0], log.x_r[0] = 0.0, d, x_r
    reached, x, v, _, count, _ = leap(
        plant, law, waves, 0.0, 0.0, 0, 0.0, length, 0.0, x_r, v_r, d, log, 1, capacity
    )
    answer[TIME] = reached
    if count < 0 or reached < length or not (math.isfinite(x) and math.isfinite(v)):
        answer[STATUS] = STORM if count < 0 else (CROWDED if reached < length else OVERFLOW)
        return
    t, kind, turns = log.s[:count], log.kind[:count], log.x_r[:count]
    scene = (plant, law, waves, t, kind, turns, v_r)
    answer[X_BEGIN], answer[V_BEGIN] = state_at(*scene, 0.0)
    answer[X_END], answer[V_END] = state_at(*scene, length)
    (
        answer[X2], answer[V2], answer[X_DD2], answer[POWER], answer[RUB], answer[STUCK],
    ) = integrate_leaps(*scene, 0.0, length)  # fmt: skip
    u_dd2, u2 = mean_squares(waves, 0.0, length)
    answer[U_DD2], answer[U2] = u_dd2 * length, u2 * length
    answer[PEAK], answer[UPCROSSINGS], answer[ENTRIES] = passages(
        t, turns, answer[X_BEGIN], answer[X_END], length, x_rM
    )
    answer[TIMES], answer[T_FIRST], answer[T_BEYOND] = 0.0, -1.0, 0.0
    if answer[PEAK] >= x_rM:
        answer[TIMES], answer[T_FIRST], answer[T_BEYOND] = excursions(
            *scene, answer[X_END], length, x_rM, True
        )


# The orbit that a start leads to: a fixed point of the period map or of its powers.


MOST_MULTIPLE, USUAL = 64, 8
"""Longest repetition looked for, in periods of the excitation; and up to which in each period,
as hardly any orbit takes longer."""

SELDOM = 16
"""Periods from one look for the longer ones to the next."""

CLOSED = 1e-13
"""Scaled change over one repetition at which the orbit is closed: a few hundred roundings."""

NOISE = 1e-10
"""A change below this that has long found no smaller one is rounding of a stiff scene."""

PATIENCE = 20
"""Periods without a new smallest change: swings of the change itself are shorter."""

NEAR = 1e-2
"""Scaled change below which Newton's method may take over."""

BETTER = 0.5
"""Share of the change before to which each of Newton's steps must bring it."""

WAIT = 10
"""Periods of the motion itself after Newton's method has failed first; then twice as many."""


@compiled
def find(plant, law, waves, period, x_r, v_r, most, past_x, past_v, log, capacity):
    """Give the periodic orbit that a start leads to.

    Parameters as in `settle`, from rest on; without dry friction the steady motion itself is
    the start.

    Returns
    -------
    x_r, v_r, multiple, closure, periods, peak
        As in `settle`.
    unique : bool
        Whether neighbours are drawn to the orbit; false for one of a continuum.
    """
    if law.F_fs == 0.0 and plant.k_x > 0.0 and plant.b > 0.0:
        x_r, v_r = steady_start(plant, waves)
    d = first_direction(plant, law, waves, x_r, v_r)
    x_r, v_r, d, multiple, closure, periods, peak = settle(
        plant, law, waves, period, x_r, v_r, d, patience(plant, period, most), past_x, past_v,
        log, capacity,
    )  # fmt: skip
    unique = True
    length = multiple * period
    if multiple > 0 and decays(plant, length) < SLOW:
        unique, left = reached(plant, law, waves, length, x_r, v_r, d, log, capacity)
        if left > AWAY:
            multiple = 0
    return x_r, v_r, multiple, closure, periods, peak, unique


@compiled
def first_direction(plant, law, waves, x_r, v_r):
    """Give the direction of sliding at t = 0, 0 for stuck."""
    u_dd = 0.0
    for i in range(waves.base):
        at = STRIDE * i
        u_dd += waves.values[at + A] * math.sin(waves.values[at + PHASE])
    load = 1.0 + law.variation * math.sin(law.phase)
    limits = Law(law.F_fk * load, law.F_fs * load, law.variation, law.omega, law.phase)
    return first_mode(plant, limits, x_r, v_r, u_dd)


@compiled
def steady_start(plant, waves):
    """Give the steady x_r and v_r at t = 0 of the oscillator without dry friction."""
    x_r, v_r = 0.0, 0.0
    for i in range(waves.base):
        at = STRIDE * i
        omega, phase = waves.values[at + OMEGA], waves.values[at + PHASE]
        stiff = complex(plant.k_x - plant.m * omega * omega, plant.b * omega)
        turn = complex(math.cos(phase), math.sin(phase))
        swing = -plant.m * waves.values[at + A] * turn / stiff
        x_r += swing.imag
        v_r += omega * swing.real
    return x_r, v_r


@compiled
def settle(plant, law, waves, period, x_r, v_r, d, most, past_x, past_v, log, capacity):
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
    rate = rate_of(plant, period)
    highest = abs(x_r)
    events_before = -1
    step_before = math.inf
    smallest = math.inf
    smallest_at = 0
    wait, pause = 0, WAIT
    refined = False
    plain_x, plain_v, plain_d = x_r, v_r, d
    closure = math.inf
    for n in range(most):
        past_x[n % MOST_MULTIPLE] = x_r
        past_v[n % MOST_MULTIPLE] = v_r
        d_before, x_before, v_before = d, x_r, v_r
        image = one_period(plant, law, waves, period, x_r, v_r, d, log, capacity)
        x_r, v_r, d, events, peak = image
        if events < 0:
            return x_r, v_r, d, -1, closure, n + 1, highest
        step = max(abs(x_r - x_before), abs(v_r - v_before) / rate)
        alike = events == events_before and d == d_before and events + ROOM <= capacity
        if refined and not (alike and step < BETTER * step_before):
            # Newton leads astray: the motion goes on from where it was.
            x_r, v_r, d = plain_x, plain_v, plain_d
            for i in range(MOST_MULTIPLE):
                past_x[i] = math.inf
            refined, wait, pause = False, pause, 2 * pause
            continue
        highest = max(highest, peak)
        scale = peak if peak > 0.0 else 1.0
        for multiple in range(1, min(n + 1, USUAL) + 1):
            i = (n + 1 - multiple) % MOST_MULTIPLE
            change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate) / scale
            closure = change if multiple == 1 else min(closure, change)
            if multiple == 1 and change < smallest:
                smallest, smallest_at = change, n
            still = change <= NOISE and change <= 10.0 * smallest and n - smallest_at > PATIENCE
            apart = multiple == 1 or step > NOISE * scale
            if apart and (change <= CLOSED or still):
                return x_r, v_r, d, multiple, change, n + 1, highest
        if (n + 1) % SELDOM == 0 and step > NOISE * scale:
            limit = NOISE if n - smallest_at > PATIENCE else CLOSED
            multiple, change = longer(past_x, past_v, n, x_r, v_r, rate, limit * scale)
            if multiple > 0:
                return x_r, v_r, d, multiple, change / scale, n + 1, highest
        wait -= 1
        if wait <= 0 and step < NEAR * scale and alike:
            # Where a mass may come to rest depends on its way there, if F_fs exceeds F_fk: a
            # step that leads to no orbit must leave no trace then.
            if not refined or law.F_fs <= law.F_fk:
                plain_x, plain_v, plain_d = x_r, v_r, d
            refined, x_r, v_r = refine(
                plant, law, waves, period, rate, x_before, v_before, d, image, log
            )
            if not refined:
                wait = WAIT
        step_before = step
        events_before = events
    return x_r, v_r, d, 0, closure, most, highest


@compiled
def longer(past_x, past_v, n, x_r, v_r, rate, limit):
    """Return the shortest repetition beyond the usual over which a state changes little enough.

    `past_x` and `past_v` are the states at the beginning of the latest periods, the last of
    which is the n-th and ends with the state given; a change of x_r and v_r/rate up to `limit`
    [m] is little. Gives the repetition in periods, 0 for none, and its change [m].
    """
    for multiple in range(USUAL + 1, min(n + 1, MOST_MULTIPLE) + 1):
        i = (n + 1 - multiple) % MOST_MULTIPLE
        change = max(abs(x_r - past_x[i]), abs(v_r - past_v[i]) / rate)
        if change <= limit:
            return multiple, change
    return 0, math.inf


# How far a motion that hardly changes any more still is from its orbit.


SLOW = 1e-2
"""Decays over a repetition below which little change does not yet mean a closed orbit."""

CREEPS, FEW = 0.1, 100
"""Decays over all the periods that a motion is given, below which an overdamped mass only
creeps; and the periods that it is given then."""

AWAY = 1e-6
"""Scaled distance from an orbit at which a motion that hardly changes has not reached it."""

RESTS = 1e-9
"""Share of the largest |x_r| within which a mass that sticks in each period is as good as at
rest: it creeps to the edge of where it may stay, and any place within is like another."""

ROOM = 2
"""Places that `leap` leaves free in a log that held all events of a period."""


@compiled
def decays(plant, length):
    """Give how often what dies out slowest falls by e within a time [s]; 0 for never."""
    half = 0.5 * plant.b / plant.m
    w = plant.k_x / plant.m
    square = half * half - w
    if w == 0.0:
        return 2.0 * half * length
    return (w / (half + math.sqrt(square)) if square > 0.0 else half) * length


@compiled
def patience(plant, period, most):
    """Give after how many periods, `most` as a rule, a motion counts as not settled.

    Where all of them would take it a tenth of its way at best, Newton's method or a sum of
    changes leads it to its orbit soon, or nothing does.
    """
    half = 0.5 * plant.b / plant.m
    creeps = half * half > plant.k_x / plant.m > 0.0 and decays(plant, most * period) < CREEPS
    return min(most, FEW) if creeps else most


@compiled
def reached(plant, law, waves, length, x_r, v_r, d, log, capacity):
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
    x_end, v_end, _, events, peak = one_period(
        plant, law, waves, length, x_r, v_r, d, log, capacity
    )
    if events <= 0 or events + ROOM > capacity:
        return True, 0.0
    if d == 0 and spread(log, events, x_r) <= RESTS * peak:
        return True, 0.0
    rate = rate_of(plant, length)
    a, b, c, e = slopes(plant, law, waves, length, rate, d, events, log)
    gap_x, gap_v = x_end - x_r, v_end - v_r
    if plant.k_x == 0.0:
        a, b, gap_x = 0.0, 0.0, 0.0
    if not radius(a, b, c, e) < CONTRACTS:
        return False, 0.0
    left_x, left_v = fixed_point(a, b, c, e, rate, gap_x, gap_v)
    return True, max(abs(left_x), abs(left_v) / rate) / (peak if peak > 0.0 else 1.0)


@compiled
def spread(log, events, x_r):
    """Give how far from a place the events of a repetition are [m]."""
    most = 0.0
    for i in range(events):
        most = max(most, abs(log.x_r[i] - x_r))
    return most


# The period map: what one period of the excitation makes of a state, and of its neighbours.


CONTRACTS = 1.0 - 1e-7
"""A map that shrinks distances less than this is marginal; Newton would pick any orbit."""


@compiled
def one_period(plant, law, waves, period, x_r, v_r, d, log, capacity):
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
        begin, x_r, v_r, d, count, _ = leap(
            plant, law, waves, 0.0, 0.0, 0, 0.0, period, begin, x_r, v_r, d, log, 0, capacity
        )
        if count < 0:
            return x_r, v_r, d, -1, peak
        for i in range(count):
            peak = max(peak, abs(log.x_r[i]))
        events += count
    return x_r, v_r, d, events, max(peak, abs(x_r))


@compiled
def rate_of(plant, period):
    """Give what turns velocities into displacements of like size [1/s]."""
    return max(2.0 * math.pi / period, math.sqrt(plant.k_x / plant.m))


@compiled
def refine(plant, law, waves, period, rate, x_r, v_r, d, image, log):
    """Take one Newton step from a state, of which `one_period` made `image`, to a fixed point.

    Returns
    -------
    good : bool
        Whether the map contracts there, so that the better state may be trusted.
    x_r, v_r : float
        The better state; the image where there is none.
    """
    a, b, c, e = slopes(plant, law, waves, period, rate, d, image[3], log)
    if not radius(a, b, c, e) < CONTRACTS:
        return False, image[0], image[1]
    step_x, step_v = fixed_point(a, b, c, e, rate, image[0] - x_r, image[1] - v_r)
    x_r += step_x
    v_r += step_v
    if d != 0 and d * v_r <= 0.0:
        return False, image[0], image[1]
    return True, x_r, v_r


@compiled
def radius(a, b, c, e):
    """Give the factor by which a map with these slopes stretches in the long run."""
    mean = 0.5 * (a + e)
    root = mean * mean - (a * e - b * c)
    return abs(mean) + math.sqrt(root) if root > 0.0 else math.sqrt(a * e - b * c)


@compiled
def fixed_point(a, b, c, e, rate, gap_x, gap_v):
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
def slopes(plant, law, waves, period, rate, d, events, log):
    """Give the slopes of the period map at a state, from the events on its way.

    `one_period` has written those to the log; it began in direction d. `rate` is that of
    `rate_of`.

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
        begin, after = until, direction(log.kind[i])
        anchor(waves, plant, law, begin, d)
        lag = saltation(plant, law, waves, d, after, log.x_r[i])
        # Stops are felt by the velocity before them, break-aways by the place of the mass.
        c, e = (lag * c, lag * e) if d != 0 else (lag * a / rate, lag * b / rate)
        d = after
    return a, b, c, e


@compiled
def saltation(plant, law, waves, d, after, x_r):
    """Give what an event makes of a neighbour's distance: the factor on its velocity.

    At a break-away it is the velocity for a distance in x_r [1/s]; waves are anchored at the
    event.
    """
    u_dd, u_ddd, _ = base_motion(waves, 0.0, 0.0, 0.0)
    load, load_d, _ = normal_force(law, waves, 0.0)
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
