"""Hybrid automaton of the piecewise-linear laws: modes, exits and resets.

Problem
    In each mode of a law the relative motion is that of a linear oscillator driven by waves and
    a linearly changing force. A march needs, per mode, the oscillator and the constant force,
    the first exit from the mode, and the mode and state after it. Three laws have more modes
    than stick and slip:

    ======================  ===============================  ================================
    law                     modes                            exits
    ======================  ===============================  ================================
    elastic contact         hold, yield ±1, lifted off       limit, its rate, normal force
    end stops               apart, touching, separated ×     position, bumper force, v_r,
                            stick, slip ±1                   break-away
    vanishing normal force  lifted off, stick, slip ±1       normal force, v_r, break-away
    ======================  ===============================  ================================

Method
    An exit is the first root of an observable, which `roots` finds without missing one. Three
    cases need more:

    - A stiff contact that holds oscillates fast about its slow response to the base. Its motion
      lies within an exponentially decaying envelope, which it touches once per half period.
      `end_of_hold` searches only near these peaks, and only where the envelope does not prove
      that the contact holds.
    - At an end stop the state is xi = x_r - z with z = ±x_rM. A penetration or rebound of any
      size then keeps all its digits, next to a limit however large.
    - At a rigid stop infinitely many rebounds may end in finite time (Zeno). Those below the
      resolution of x_r are not followed one by one: their duration and their contribution to
      x"² are summed in closed form.

Reference
    Petrov and Ewins, J. Turbomach. 125 (2003) 364, for the contact with normal force.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import compiled, inlined
from drysim.core.events import (
    CONTACT,
    FORCE_ROUNDING,
    IMPACT,
    RELEASE,
    REVERSAL,
    STICK,
    motion_direction,
    record_event,
    sign,
)
from drysim.core.forcing import (
    IN_PHASE,
    OMEGA,
    QUADRATURE,
    STEADY,
    STEADY_V,
    STEADY_X,
    WAVE_COLUMNS,
    A,
    force_rate_bounds,
    motion_at,
    relative_normal_force,
    set_phases,
    start_segment,
    steady_response,
)
from drysim.core.model import Plant
from drysim.core.roots import (
    MAX_BISECTIONS,
    NEVER,
    RESOLUTION,
    WINDOW_RADIANS,
    Observable,
    break_away_time,
    first_root,
    keep_in_bracket,
    parabola_root,
    slip_exit_time,
    stick_exit_time,
)

# Elastic contact: modes, and the oscillator and the force in each.


HOLD, FREE, AT_LIMIT = 0, 2, 4
"""Modes of the contact besides yielding in direction +1 or -1: it holds; it is lifted off; or,
with the sign of the direction, it has just ceased to yield and holds exactly at its limit."""

QUASI_STATIC_RATIO = 16.0
"""Least square of the ratio of natural to driving frequency for which a wave is followed
quasi-statically."""

LIMIT_TOLERANCE = 1e-14
"""Relative distance from its limit below which a contact that continues is at its limit."""


@compiled
def is_holding(mode):
    """Return whether the contact holds."""
    return mode == HOLD or abs(mode) == AT_LIMIT


@compiled
def effective_plant(plant, law, mode):
    """Return the oscillator in a mode: a holding contact adds its tangential stiffness."""
    return Plant(plant.m, plant.k_x + (law.k_t if is_holding(mode) else 0.0), plant.b)


@compiled
def constant_force(law, mode, x_0):
    """Return the part of the contact force that is constant in a mode [N]."""
    if is_holding(mode):
        return -law.k_t * x_0
    return 0.0 if mode == FREE else mode * law.F_fk


@compiled
def contact_force(law, mode, x_r, x_0, load):
    """Return the contact force [N]; `load` is the relative normal force."""
    if is_holding(mode):
        return law.k_t * (x_r - x_0)
    return 0.0 if mode == FREE else mode * law.F_fk * load


@compiled
def begin_segment(plant, law, waves, mode, x_0, t):
    """Set the phases of the waves at t [s]; return c, w and constant force/m of the segment."""
    effective = effective_plant(plant, law, mode)
    set_phases(waves, effective, law, t, mode if abs(mode) == 1 else 0)
    m = plant.m
    w = effective.k_x / m
    for i in range(waves.size):
        at = WAVE_COLUMNS * i
        if (
            waves.values[at + STEADY] > 0.0
            and QUASI_STATIC_RATIO * waves.values[at + OMEGA] ** 2 <= w
        ):
            waves.values[at + STEADY] = 2.0
    return effective.b / m, w, constant_force(law, mode, x_0) / m


@compiled
def initial_contact_mode(law, x_r, v_r, x_0):
    """Return mode and x_0 at t = 0 of a contact that carries no force at x_0 [m].

    A contact deflected to its limit, and moving on, yields already, so that no event follows at
    once. One deflected beyond the limit, as rounding of a periodic orbit may produce, has
    yielded: x_0 moves.
    """
    load = 1.0 + law.variation * math.sin(law.phase)
    rate = law.F_fk * law.variation * law.omega * math.cos(law.phase)
    if load <= 0.0:
        # A normal force that only touches zero does not separate the surfaces.
        separated = load < 0.0 or (law.variation > 1.0 and rate <= 0.0)
        return FREE if separated else closing_mode(law, v_r, rate), x_r
    direction = sign(x_r - x_0)
    x_limit = law.F_fk * load / law.k_t
    distance = abs(x_r - x_0)
    if distance > x_limit:
        x_0 = x_r - direction * x_limit
    deflected = distance >= x_limit - LIMIT_TOLERANCE * (x_limit + abs(x_r))
    return (direction if deflected and law.k_t * direction * v_r > rate else HOLD), x_0


@inlined
def closing_mode(law, v_r, rate):
    """Return the mode of surfaces that just touch: yield where the limit rises slower, or hold.

    `rate` is the rate of the limit force [N/s].
    """
    return sign(v_r) if law.k_t * abs(v_r) > rate else HOLD


# Elastic contact: exits from hold and yield.

MIN_ENVELOPE_STEP = 0.5
"""Shortest useful step of the envelope bound, in radians of the transient."""

HALF_SWING_RADIANS = 3.2
"""Half a period of the oscillator in radians, rounded up: the first search interval."""


@compiled
def end_of_hold(segment, waves, law, x_0, at_limit, h):
    """Return when within h [s] a contact that holds yields, and how.

    Parameters
    ----------
    segment, waves, law, x_0
        As in `hold_exit_time`.
    at_limit : int
        The side at whose limit the contact starts exactly, 0 for none.
    h : float
        Length of the segment [s].

    Returns
    -------
    s, side, x_r, v_r
        Time [s], infinite for never; direction of yielding; state at that time.

    Notes
    -----
    Each peak of the transient is responsible for one side of the contact over half a period
    before and after it. The peaks alternate in side, so that both sides are covered at all
    times.
    """
    x_limit, direction = law.F_fk / law.k_t, motion_direction(segment.v_r, segment.a, segment.j)
    gap = x_limit * relative_normal_force(law, waves, 0.0)[0] - direction * (segment.x_r - x_0)
    # Most contacts yield within the first half period, in the direction of motion.
    if direction * at_limit <= 0 and may_reach(segment, direction, gap):
        searched = min(HALF_SWING_RADIANS / math.sqrt(segment.w), h)
        s, x, v = hold_exit_time(segment, waves, law, x_0, direction, False, 0.0, searched)
        if s < NEVER:
            other = -direction, at_limit == -direction, 0.0, s
            return earlier_hold_exit(segment, waves, law, x_0, *other, s, x, v)
    transient = transient_response(segment, waves)
    if transient.side == 0 or h <= transient.half_period:
        side = direction if direction != 0 else 1
        # Search window by window, so that a side that never yields is not searched to the
        # end each time the other one does.
        fastest = force_rate_bounds(waves, segment.r)[3]
        begin, until = 0.0, min(WINDOW_RADIANS / fastest, h) if fastest > 0.0 else h
        while True:
            s, x, v = hold_exit_time(
                segment, waves, law, x_0, side, at_limit == side, begin, until
            )
            other = -side, at_limit == -side, begin, min(s, until)
            s, side, x, v = earlier_hold_exit(segment, waves, law, x_0, *other, s, x, v)
            if s < NEVER or until >= h:
                return s, side, x, v
            begin, until = until, min(3.0 * until, h)
    # Peak by peak: `number` counts half periods, and the contact provably holds up to `safe`.
    number, safe = -1 if transient.phase > 0.0 else 0, 0.0
    while safe < h:
        side = transient.side if number % 2 == 0 else -transient.side
        peak = transient.phase / transient.omega + number * transient.half_period
        before = transient.half_period
        if safe > 0.0 or side != at_limit:
            before = search_time_before_peak(transient, segment, waves, law, x_0, side, peak)
        begin, until = max(safe, peak - before), min(peak + transient.half_period, h)
        if before >= 0.0 and begin < until:
            s, x, v = hold_exit_time(
                segment, waves, law, x_0, side, at_limit == side, begin, until
            )
            if s < NEVER:
                other = -side, at_limit == -side, max(safe, peak), s
                return earlier_hold_exit(segment, waves, law, x_0, *other, s, x, v)
        number += 1
        if peak >= safe:
            # Skip the peaks of an envelope that stays within the limit.
            safe = safe_until(transient, segment, waves, law, x_0, x_limit, True, peak, h)
            number = max(
                number, math.floor((transient.omega * safe - transient.phase) / math.pi)
            )
    return NEVER, 0, segment.x_r, segment.v_r


@compiled
def hold_exit_time(segment, waves, law, x_0, side, at_limit, begin, until):
    """Return the first time at which a holding contact yields to one side, and the state.

    Parameters
    ----------
    segment, waves
        As in `first_root`, with the stiffness of the contact in the segment.
    law : ElasticContactLaw
    x_0 : float
        Displacement at which the contact carries no force [m].
    side : int
        +1 for yielding with increasing x_r, -1 with decreasing.
    at_limit : bool
        Whether the segment starts exactly at this limit: value and rate of the observable are
        zero.
    begin, until : float
        Times of the segment [s].
    """
    clearance = Observable(x_0, -side * law.k_t, 0.0, law.F_fk, 0.0)
    return first_root(segment, waves, law, clearance, 2 if at_limit else 0, begin, until)


@compiled
def earlier_hold_exit(segment, waves, law, x_0, side, at_limit, begin, until, s, x, v):
    """Return time, side and state of the first yielding: to `side`, or at s to the other side.

    s, x and v are time and state of yielding to the other side. Other parameters as in
    `hold_exit_time`.
    """
    if begin < until:
        t, x_t, v_t = hold_exit_time(segment, waves, law, x_0, side, at_limit, begin, until)
        if t < s:
            return t, side, x_t, v_t
    return s, -side, x, v


@compiled
def may_reach(segment, direction, gap):
    """Return whether the oscillator without waves would move by `gap` [m] in its direction.

    An estimate only: it decides where to search first.
    """
    lean = direction * segment.a / segment.w
    return lean + math.sqrt(lean * lean + segment.v_r * segment.v_r / segment.w) >= gap


class Transient(NamedTuple):
    """Free oscillation of a segment: the motion less the steady response to its forcing.

    Attributes
    ----------
    side : int
        Sign of the first peak, near the start: 1 or -1; 0 where there is no usable transient.
    size, decay : float
        The transient is side·size·exp(-decay s)·cos(omega s - phase) at time s [m, 1/s].
    omega, phase : float
        As above [rad/s, rad]; the phase lies within ±π/2.
    half_period, growth : float
        π/omega [s], and exp(decay·half_period) - 1.
    max_acceleration : float
        Bound on the acceleration of the steady response [m/s²].
    """

    side: int
    size: float
    decay: float
    omega: float
    phase: float
    half_period: float
    growth: float
    max_acceleration: float


@compiled
def transient_response(segment, waves):
    """Return the transient of a segment; waves after `set_phases` at its start."""
    c, w, x_r, v_r, _, _, _, g, r = segment
    decay, square = 0.5 * c, w - 0.25 * c * c
    none = Transient(0, 0.0, decay, 0.0, 0.0, 0.0, 0.0, 0.0)
    if square < 0.5 * w or w == 0.0:
        return none
    lag, rate, max_acceleration = x_r - (g - c * r / w) / w, v_r - r / w, 0.0
    for i in range(waves.size):
        at = WAVE_COLUMNS * i
        if waves.values[at + A] == 0.0:
            continue
        if waves.values[at + STEADY] == 0.0:
            return none
        lag -= waves.values[at + STEADY_X]
        rate -= waves.values[at + STEADY_V]
        swing = math.hypot(waves.values[at + IN_PHASE], waves.values[at + QUADRATURE])
        max_acceleration += waves.values[at + OMEGA] ** 2 * swing
    omega = math.sqrt(square)
    across = (rate + decay * lag) / omega
    side = sign(lag) if lag != 0.0 else sign(across)
    phase = math.atan2(side * across, side * lag)
    half_period = math.pi / omega
    growth = math.exp(decay * half_period) - 1.0
    return Transient(
        side,
        math.hypot(lag, across),
        decay,
        omega,
        phase,
        half_period,
        growth,
        max_acceleration,
    )


@inlined
def steady_motion(segment, waves, s):
    """Return x_r and v_r of the steady response at time s of a segment."""
    c, w, _, _, _, _, _, g, r = segment
    x, v = (g + r * (s - c / w)) / w, r / w
    for i in range(waves.size):
        at = WAVE_COLUMNS * i
        if waves.values[at + A] != 0.0:
            swing, rate, _, _, _ = steady_response(waves.values, at, s)
            x += swing
            v += rate
    return x, v


@compiled
def safe_until(transient, segment, waves, law, center, x_limit, loaded, begin, h):
    """Return until when x_r provably stays within x_limit of a center, at most h.

    Parameters
    ----------
    transient : Transient
        Of the segment, with side != 0.
    segment, waves, law
        Waves after `set_phases` at the start of the segment.
    center, x_limit : float
        Center and half width of the interval [m].
    loaded : bool
        Whether the half width is proportional to the normal force.
    begin, h : float
        Time of the segment to begin at, and its length [s].

    Notes
    -----
    The clearance between envelope and limit has a second derivative of at least
    -(max_acceleration + x_limit·variation·omega² + decay²·envelope), and the last term only
    decreases. So a parabola lies below the clearance, and its root is a safe step. The bound
    ends where the envelope meets the limit, which the motion itself need not reach.
    """
    max_acceleration = transient.max_acceleration + (
        x_limit * law.variation * law.omega**2 if loaded else 0.0
    )
    s = begin
    while s < h:
        x, v = steady_motion(segment, waves, s)
        left = transient.size * math.exp(-transient.decay * s)
        clearance, gain = x_limit - left, transient.decay * left
        if loaded:
            load, load_d, _ = relative_normal_force(law, waves, s)
            clearance, gain = x_limit * load - left, gain + x_limit * load_d
        if clearance <= abs(x - center):
            break
        max_curvature = max_acceleration + transient.decay * transient.decay * left
        up = parabola_root(clearance - (x - center), gain - v, max_curvature)
        down = parabola_root(clearance + (x - center), gain + v, max_curvature)
        s += min(up, down)
        if min(up, down) * transient.omega < MIN_ENVELOPE_STEP:
            break
    return min(s, h)


@compiled
def search_time_before_peak(transient, segment, waves, law, x_0, side, peak):
    """Return the length of the interval before a peak that must be searched for yielding [s].

    At most half a period. Negative if the contact provably holds for half a period before and
    after the peak. `side` is that of the peak at time `peak` [s]; x_0 is as in
    `hold_exit_time`.

    Notes
    -----
    Within half a period h of the peak, cos(omega t) <= 1 - 2 (t/h)². Decay adds at most 2
    (exp(decay·h) - 1) |t|/h, and the steady response and the limit change by at most their
    rates and bounds on their accelerations allow. The sum is a parabola in t.
    """
    half_period, x_limit = transient.half_period, law.F_fk / law.k_t
    x, v = steady_motion(segment, waves, peak)
    load, load_d, _ = relative_normal_force(law, waves, peak)
    left = transient.size * math.exp(-transient.decay * peak)
    clearance = x_limit * load - side * (x - x_0) - left
    loss = abs(x_limit * load_d - side * v)
    loss += (
        0.5
        * half_period
        * (transient.max_acceleration + x_limit * law.variation * law.omega**2)
    )
    loss += 2.0 * left * transient.growth / half_period
    cosine_term = 2.0 * left / (half_period * half_period)
    square = loss * loss - 4.0 * cosine_term * clearance
    if square < 0.0:
        return -1.0
    before = loss + math.sqrt(square)
    return (
        before / (2.0 * cosine_term)
        if before < 2.0 * cosine_term * half_period
        else half_period
    )


@compiled
def end_of_yield(segment, waves, law, d, h):
    """Return when within h [s] a contact yielding in direction d holds again, and the state.

    It holds when v_r falls to the rate of the limit over k_t; with constant normal force, when
    the mass stops.
    """
    c, w, x_r, v_r, a, j, _, g, r = segment
    if law.variation > 0.0:
        excess_rate = Observable(0.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)
        return first_root(segment, waves, law, excess_rate, 0, 0.0, h)
    if motion_direction(segment.v_r, segment.a, segment.j) != d:
        return 0.0, x_r, v_r
    stop, x = slip_exit_time(c, w, waves, x_r, v_r, a, j, g, r, d, h)
    return stop, x, 0.0


# End stops: modes, and the force of a bumper.

APART, TOUCHING, SEPARATED = 0, 1, 2
"""State of the mass with respect to a stop: within the limits; in contact; or beyond the limit
but separated, because a bumper only pushes and relaxes more slowly than the mass moves away.
The last two carry the sign of the side."""

BUMPER_STEADY, BREAKING_AWAY, BUMPER_AT_ZERO, CHATTERING = 0, 1, 2, 3
"""How a segment begins: in regular motion; with a break-away; with a bumper force that is
exactly zero; or as the rest of a chatter against a rigid stop, with v_r of the first
rebound."""

ARRIVAL = 1000
"""Mode of a record that holds the velocity with which the mass arrives at a stop."""


@compiled
def encode_mode(stop_state, d, beginning):
    """Return the mode as one integer, from stop state, direction and beginning."""
    return d + 4 * stop_state + 64 * beginning


@compiled
def decode_beginning(mode):
    """Return how a segment in this mode begins."""
    return (mode + 32) // 64


@compiled
def decode_stop_state(mode):
    """Return the stop state of a mode, see `APART`, with the sign of the side."""
    return (mode - 64 * decode_beginning(mode) + 1) // 4


@compiled
def decode_direction(mode):
    """Return the direction of sliding, 0 if stuck."""
    return mode - 64 * decode_beginning(mode) - 4 * decode_stop_state(mode)


@compiled
def bumper_acts(law, stop_state):
    """Return whether a bumper exerts a force."""
    return law.k_s > 0.0 and abs(stop_state) == TOUCHING


@compiled
def bumper_force(law, stop_state, xi, v_r):
    """Return the force of a bumper on the mass [N], positive at the positive stop.

    Notes
    -----
    F = k_s xi + b_s v_r while the bumper is in contact, else 0; it cannot pull. Where the mass
    moves away faster than the bumper relaxes, contact is lost beyond the limit, and found again
    if the mass slows down there.
    """
    return law.k_s * xi + law.b_s * v_r if bumper_acts(law, stop_state) else 0.0


@compiled
def restoring_force(plant, law, stop_state, z, xi):
    """Return the static force of the spring and of a bumper [N]."""
    return plant.k_x * (z + xi) + bumper_force(law, stop_state, xi, 0.0)


@compiled
def rigid_stop_side(law, z, xi):
    """Return the side of the rigid stop that the mass touches, 0 for none."""
    if law.k_s > 0.0 or xi != 0.0 or abs(z) != law.x_rM:
        return 0
    return 1 if z > 0.0 else -1


@compiled
def stop_coordinates(law, x_r, v_r):
    """Return z, xi and the stop state of a motion at x_r, v_r."""
    if abs(x_r) < law.x_rM:
        return 0.0, x_r, APART
    side = 1 if x_r > 0.0 else -1
    z = side * law.x_rM
    xi = x_r - z
    if law.k_s == 0.0 or xi == 0.0:
        return z, xi, APART
    presses = side * (law.k_s * xi + law.b_s * v_r) > 0.0
    return z, xi, side * (TOUCHING if presses else SEPARATED)


@compiled
def initial_stop_mode(plant, law, x_r, v_r, u_dd, load):
    """Return xi, v_r, z and the mode at t = 0."""
    z, xi, stop_state = stop_coordinates(law, x_r, v_r)
    d = sign(v_r)
    if d == 0:
        d, _ = direction_from_rest(plant, law, stop_state, z, xi, u_dd, load)
    return xi, v_r, z, encode_mode(stop_state, d, BUMPER_STEADY)


# End stops: exits.


@compiled
def arrival_time(c, w, waves, xi, v_r, g, r, d, distance, until):
    """Return when within [0, until] xi, moving in direction d, is at d·distance; or infinity.

    Parameters
    ----------
    c, w, waves, v_r, g, r
        As in `motion_at`, with xi for x_r. The velocity does not change its sign up to `until`.
    distance : float
        Target position, in the direction of motion [m].
    """
    gap = distance - d * xi
    if gap <= 0.0:
        return 0.0
    rest = distance - d * motion_at(c, w, waves, xi, v_r, g, r, until)[0]
    if rest > 0.0:
        return NEVER
    low, high = 0.0, until
    s = until * (gap / (gap - rest))
    for _ in range(MAX_BISECTIONS):
        x, v, _, _ = motion_at(c, w, waves, xi, v_r, g, r, s)
        gap = distance - d * x
        low, high = (s, high) if gap > 0.0 else (low, s)
        step = gap / (d * v) if d * v > 0.0 else NEVER
        if abs(step) <= RESOLUTION * s:
            return s
        s = keep_in_bracket(low, high, s + step)
        if not low < s < high:
            return high
    return s


@compiled
def bumper_zero_time(c, w, waves, law, xi, v_r, g, r, side, at_limit, h):
    """Return when within [0, h] side·(k_s xi + b_s v_r) is no longer above zero, or infinity.

    With the side of the stop this is loss of contact, with the other side contact anew.

    Parameters
    ----------
    c, w, waves, v_r, g, r
        As in `motion_at`, with xi for x_r.
    law : EndStopLaw
    side : int
        +1 or -1.
    at_limit : bool
        Whether the value is exactly zero at the start.
    h : float
        Length of the segment [s].
    """
    if not at_limit and side * (law.k_s * xi + law.b_s * v_r) <= 0.0:
        return 0.0
    force = Observable(0.0, side * law.k_s, side * law.b_s, 0.0, 0.0)
    segment = start_segment(c, w, waves, xi, v_r, g, r)
    return first_root(segment, waves, law, force, 1 if at_limit else 0, 0.0, h)[0]


@compiled
def rest_exit_time(plant, law, waves, stop_state, z, xi, u_0, slope, left):
    """Return when a stuck mass breaks away, or infinity, and in which direction."""
    # The spring force is constant while stuck: pass it as the extension of a 1 N/m spring.
    spring_force = restoring_force(plant, law, stop_state, z, xi)
    wall = rigid_stop_side(law, z, xi)
    one = Plant(plant.m, 1.0, 0.0)
    if wall == 0:
        return break_away_time(one, law, waves, spring_force, u_0, slope, slope, left)
    return stick_exit_time(one, law, waves, spring_force, u_0, slope, wall, 0.0, left), -wall


# End stops: resets.


@compiled
def direction_from_rest(plant, law, stop_state, z, xi, u_dd, load):
    """Return the direction in which a mass with v_r = 0 starts to slide, 0 to stick; and F_L.

    Eq. (9) of the paper with the force of a bumper. A rigid stop carries any force towards it.
    """
    spring_force = restoring_force(plant, law, stop_state, z, xi)
    F_L = plant.m * u_dd + spring_force
    hold = law.F_fs * load
    d = -sign(F_L) if abs(F_L) > hold + FORCE_ROUNDING * (hold + abs(spring_force)) else 0
    return (0 if d != 0 and d == rigid_stop_side(law, z, xi) else d), F_L


@compiled
def stick_or_slide(plant, law, n, s, xi, z, mode, u_dd, load, log, count):
    """Record whether a mass with v_r = 0 sticks or slides on; return mode and event count."""
    stop_state = decode_stop_state(mode)
    if abs(stop_state) == SEPARATED:
        stop_state = stop_state // SEPARATED
    d, F_L = direction_from_rest(plant, law, stop_state, z, xi, u_dd, load)
    count = record_event(log, count, n, s, d * REVERSAL if d != 0 else STICK, z + xi, F_L)
    return encode_mode(stop_state, d, BUMPER_STEADY), count


@compiled
def release_bumper(stop_state, after, d, n, s, z, xi, F_L, log, count):
    """Change the stop state of a mass that moves inwards; return xi, mode and event count."""
    if abs(after) == SEPARATED and d * xi >= 0.0:
        after = APART
    if abs(stop_state) == TOUCHING:
        count = record_event(log, count, n, s, d * RELEASE, z + xi, F_L)
    elif after != APART:
        count = record_event(log, count, n, s, d * CONTACT, z + xi, F_L)
    if after == APART:
        return 0.0, encode_mode(APART, d, BUMPER_STEADY), count
    return xi, encode_mode(after, d, BUMPER_AT_ZERO), count


@compiled
def rebound(plant, law, waves, slope, n, s, t, v_r, z, d, u_dd, load, log, count):
    """Reflect v_r at a rigid stop, or start a chatter; return v_r, mode and event count.

    Parameters
    ----------
    n, s, t : int, float, float
        Interval; time in it [s]; and time since the start of the motion [s].
    v_r, d : float, int
        Velocity before the impact [m/s], and its direction: the side of the stop.
    z : float
        Position of the stop [m].
    u_dd, load : float
        ü [m/s²] and relative normal force at the impact.
    """
    F_L = plant.m * u_dd + plant.k_x * z
    count = record_event(log, count, n, s, -d * IMPACT, z, F_L)
    speed = law.e * max(d * v_r, 0.0)
    if speed == 0.0:
        return 0.0, encode_mode(APART, -d, BUMPER_STEADY), count
    if is_unresolved_chatter(plant, law, waves, slope, d, F_L, load, t, speed):
        return -d * speed, encode_mode(APART, 0, CHATTERING), count
    return -d * speed, encode_mode(APART, -d, BUMPER_STEADY), count


@compiled
def is_unresolved_chatter(plant, law, waves, slope, side, F_L, load, t, v):
    """Return whether all further rebounds are below the resolution of x_r and end at rest.

    Parameters
    ----------
    plant, law, waves
        Waves after `set_phases` at the impact.
    slope : float
        Derivative of ü without the waves [m/s³].
    side, F_L, load, t
        Side of the stop; F_L [N], relative normal force [-] and time [s] of the impact.
    v : float
        Speed after the impact [m/s].

    Notes
    -----
    This holds if the next flight is too low to change x_r or too short to change t, and if the
    force provably presses the mass against the stop until the last flight ends, see
    `chatter_time`. The motion afterwards is then the same to the last bit.
    """
    p, q = return_accelerations(plant, law, side, F_L, load)
    if p <= 0.0:
        return False
    whole, flight = chatter_time(law, p, q, v)
    if law.x_rM - v * v / (2.0 * p) != law.x_rM and t + flight != t:
        return False
    return q <= 0.0 or force_rate_bounds(waves, slope)[0] * whole < q


@compiled
def return_accelerations(plant, law, side, F_L, load):
    """Return the accelerations towards a rigid stop, p moving away and q moving back [m/s²]."""
    friction = law.F_fk * load
    return (-side * F_L + friction) / plant.m, (-side * F_L - friction) / plant.m


@compiled
def chatter_time(law, p, q, v):
    """Return the duration of all flights after a rebound at speed v, and of the first one [s].

    Parameters
    ----------
    p, q : float
        As in `return_accelerations`, p above 0.

    Notes
    -----
    A flight reaches the height v²/(2 p), lasts v (1/p + 1/√(p q)), and arrives at speed v
    √(q/p). With restitution e the durations form a geometric series of ratio e √(q/p). If q <=
    0, friction holds the mass where it turns.
    """
    if q <= 0.0:
        return v / p, v / p
    flight = v * (1.0 / p + 1.0 / math.sqrt(p * q))
    keeps = law.e * math.sqrt(q / p)
    return flight / (1.0 - keeps) if keeps < 1.0 else math.inf, flight


@compiled
def chatter_mean_square(plant, law, p, q, z, load):
    """Return the mean square of x" over all flights of a chatter at z [m²/s⁴].

    Of each flight, the share √q/(√p + √q) moves away: 1/p of 1/p + 1/√(p q). Friction changes
    sign at the turning point.
    """
    spring_force, friction = plant.k_x * abs(z) / plant.m, law.F_fk * load / plant.m
    away = math.sqrt(q) / (math.sqrt(p) + math.sqrt(q)) if q > 0.0 else 1.0
    return away * (spring_force - friction) ** 2 + (1.0 - away) * (spring_force + friction) ** 2


# Varying normal force, and its zeros.


class NormalForceArrays(NamedTuple):
    """A law with varying normal force, as kernels read it.

    Attributes
    ----------
    F_fk, F_fs, variation, omega, phase : float
        As in `NormalForceLaw`.
    load : array of float, shape (n,)
        Recorded relative normal force [-].
    step : float
        Sample interval of the record [s]; 0 without a record.
    """

    F_fk: float
    F_fs: float
    variation: float
    omega: float
    phase: float
    load: Any
    step: float


class LoadRamp(NamedTuple):
    """Linear part of the relative normal force in a segment, without its wave.

    Attributes
    ----------
    load, rate : float
        Value at the start [-], and derivative [1/s].
    left : float
        Time to the next sample of the record [s], or infinity.
    """

    load: float
    rate: float
    left: float


@compiled
def load_ramp_at(law, t):
    """Return the linear part of the normal force from time t [s] on."""
    if law.step == 0.0:
        return LoadRamp(1.0, 0.0, NEVER)
    last = len(law.load) - 2
    k = min(int(t / law.step), last)
    while k < last and (k + 1) * law.step <= t:
        k += 1
    while k * law.step > t:
        k -= 1
    rate = (law.load[k + 1] - law.load[k]) / law.step
    left = (k + 1) * law.step - t if k < last else NEVER
    return LoadRamp(law.load[k] + rate * (t - k * law.step), rate, left)


@compiled
def load_at(law, waves, ramp, s):
    """Return the relative normal force [-] at time s, and its derivative [1/s]."""
    swing, swing_d, _ = relative_normal_force(law, waves, s)
    return ramp.load * swing + ramp.rate * s, swing_d + ramp.rate


@compiled
def separation_time(law, waves, ramp, t):
    """Return how long after t [s] the surfaces separate, or infinity."""
    if law.step == 0.0:
        return next_zero_load(law, waves, t, True)
    if ramp.rate < 0.0:
        return max(ramp.load / -ramp.rate, 0.0)
    return 0.0 if ramp.load <= 0.0 and ramp.rate == 0.0 else NEVER


@compiled
def closing_time(law, waves, ramp, t):
    """Return how long after t [s] separated surfaces touch again, or infinity."""
    if law.step == 0.0:
        return next_zero_load(law, waves, t, False)
    return max(-ramp.load / ramp.rate, 0.0) if ramp.rate > 0.0 else NEVER


@compiled
def next_zero_load(law, waves, t, falling):
    """Return how long after t [s] the normal force falls or rises through zero, or infinity.

    The segment starts at t; the relative force is 1 + variation·sin(omega t + phase).
    """
    if law.variation <= 1.0:
        return NEVER
    load, load_d, _ = relative_normal_force(law, waves, 0.0)
    if falling and load <= 0.0 and load_d < 0.0:
        return 0.0
    if not falling and load >= 0.0 and load_d > 0.0:
        return 0.0
    dip = math.asin(1.0 / law.variation)
    angle = math.pi + dip if falling else 2.0 * math.pi - dip
    return (angle - (law.omega * t + law.phase)) % (2.0 * math.pi) / law.omega
