"""Hybrid automaton of the piecewise-linear laws: modes, their equations, exits and resets.

Problem
    A friction contact, rigid or elastic, under a normal force that may vary and vanish; a
    damper, and end stops. In each mode of these the relative motion is that of a linear
    oscillator driven by waves and a linearly changing force. A march needs, per mode, the
    equation of motion, the first exit from the mode, and the mode and state after it:

    ===========  ==================================  =========================================
    part         modes                               exits
    ===========  ==================================  =========================================
    contact      stick or hold, slip or yield ±1,    limit, v_r, rate of the limit, normal
                 separated                           force
    damper       one per direction of motion         v_r
    end stops    apart, touching, released, ±side    position, bumper force, break-away
    ===========  ==================================  =========================================

Method
    `mode_equation` gives the equation; of each part the guards (`guard_*`) find the exits, and
    the resets (`reset_*`) follow them. `core.march` combines them. An exit is the first root of
    an observable, which `roots` finds without missing one. Two cases need more:

    - At an end stop the state is xi = x_r - x_origin, with x_origin its position. A penetration
      or rebound of any size then keeps all its digits, next to a limit however large.
    - At a rigid stop infinitely many rebounds may end in finite time (Zeno). Those below the
      resolution of x_r are not followed one by one: their duration and their contribution to
      x"² are summed in closed form.

Reference
    Petrov and Ewins, J. Turbomach. 125 (2003) 364, for the contact with normal force.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined
from drysim.core.events import (
    CONTACT,
    LIFT,
    RELEASE,
    SLIP,
    STICK,
    decision_margin,
    direction_from_rest,
    limit_force,
    motion_direction,
    sign,
)
from drysim.core.forcing import (
    OMEGA,
    STEADY,
    THETA,
    WAVE_COLUMNS,
    Equation,
    base_motion,
    force_rate_bounds,
    motion_at,
    relative_normal_force,
    set_phases,
)
from drysim.core.model import MAX_STAGES, CoulombLaw, Plant
from drysim.core.roots import (
    MAX_BISECTIONS,
    NEVER,
    Observable,
    Stuck,
    break_away_time,
    first_root,
    first_stop,
    safeguarded_newton,
    stick_exit_time,
)

# Law and mode, as kernels read them.


class Side(NamedTuple):
    """What depends on the direction of v_r, or on the side of x_r.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force and static limit [N] against motion in this direction.
    b : float
        Damping [N·s/m] of motion in this direction.
    limit : float
        Distance of the end stop on this side [m], infinite for none.
    """

    F_fk: float
    F_fs: float
    b: float
    limit: float


class KernelLaw(NamedTuple):
    """Friction contact, damper and end stops of a piecewise-linear law.

    Attributes
    ----------
    up, down : Side
        For v_r > 0 or x_r > 0 (extension), and for the opposite (compression).
    k_t : float
        Tangential stiffness of the contact [N/m]; 0 for a rigid contact, which sticks.
    variation, omega, phase : float
        The relative normal force is 1 + variation·sin(omega·t + phase).
    load, step : array of float, float
        Recorded relative normal force in place of the sine, and its sample interval [s]; the
        interval is 0 without a record.
    k_s, begins : tuple of float, shape (MAX_STAGES,)
        Stiffness [N/m] that each stage of a bumper adds, and the penetration at which it begins
        [m]: 0 for the first, infinite where there is none. Stops without stiffness are rigid.
    b_s, e : float
        Damping of a bumper [N·s/m]; coefficient of restitution of a rigid stop [-].
    """

    up: Side
    down: Side
    k_t: float
    variation: float
    omega: float
    phase: float
    load: Any
    step: float
    k_s: tuple[float, float, float]
    begins: tuple[float, float, float]
    b_s: float
    e: float


HOLD, FREE = 0, 2
"""Contact besides slip or yield in direction +1 or -1: it sticks or holds; it is separated."""

AT_REST = 0
"""Motion besides direction +1 or -1: at rest on the base or at a rigid stop."""

APART, RELEASED = 0, 3
"""With respect to an end stop, besides touching stage 1, 2 or 3 of it: within the limits; or
beyond the stage, plus RELEASED: separated there, because a bumper only pushes and relaxes more
slowly than the mass moves away. All but APART carry the sign of the side."""

REGULAR, BUMPER_AT_ZERO, CHATTERING, LEAVING = 0, 1, 2, 3
"""How a segment begins at an end stop: in regular motion; with a bumper force that is exactly
zero; as the rest of a chatter against a rigid stop, with v_r of the first rebound; or as the
mass leaves a rigid stop where the force that pressed it there is exactly zero."""


class Mode(NamedTuple):
    """Mode of a scene: one linear equation of motion.

    Attributes
    ----------
    contact : int
        HOLD, ±1 or FREE.
    direction : int
        Direction of motion, ±1, or AT_REST.
    end_stop : int
        APART; ±stage while touching; ±(stage + RELEASED).
    origin : int
        Side of the end stop from which xi is measured; 0 where xi is x_r.
    poised : int
        Side at whose limit a hold starts exactly, or direction in which a slip breaks away; 0
        for neither.
    entry : int
        How the segment begins at an end stop, see `REGULAR`.
    """

    contact: int
    direction: int
    end_stop: int
    origin: int
    poised: int
    entry: int


class ModeState(NamedTuple):
    """State of a scene: its mode, xi [m], v_r [m/s], and x_0 [m] as in `mode_equation`."""

    mode: Mode
    xi: float
    v_r: float
    x_0: float


class Instant(NamedTuple):
    """ü [m/s²] and relative normal force [-] at one time [s]."""

    t: float
    u_dd: float
    load: float


ARRIVAL = -1
"""Code of a record that holds the velocity with which the mass arrives at a stop."""


@compiled
def encode_mode(mode):
    """Return a mode as one integer, at least 0."""
    code = mode.entry
    code = 3 * code + mode.poised + 1
    code = 3 * code + mode.origin + 1
    code = 13 * code + mode.end_stop + 6
    code = 3 * code + mode.direction + 1
    return 4 * code + mode.contact + 1


@compiled
def decode_mode(code):
    """Return the mode of an integer from `encode_mode`."""
    contact, code = code % 4 - 1, code // 4
    direction, code = code % 3 - 1, code // 3
    end_stop, code = code % 13 - 6, code // 13
    origin, code = code % 3 - 1, code // 3
    return Mode(contact, direction, end_stop, origin, code % 3 - 1, code // 3)


@compiled
def mode_of(contact, direction, end_stop, origin):
    """Return a mode that begins in regular motion."""
    return Mode(contact, direction, end_stop, origin, 0, REGULAR)


@compiled
def stop_stage(end_stop):
    """Return side, stage and whether the mass is released from it, of `Mode.end_stop`."""
    side, stage = sign(end_stop), abs(end_stop)
    released = stage > RELEASED
    return side, stage - RELEASED if released else stage, released


@compiled
def side_of(law, d):
    """Return the constants of a direction of motion, or of a side."""
    return law.up if d > 0 else law.down


@compiled
def origin_of(law, origin):
    """Return the position from which xi is measured [m]."""
    if origin == 0:
        return 0.0
    return law.up.limit if origin > 0 else -law.down.limit


@compiled
def is_rigid_slip(law, mode):
    """Return whether a rigid contact slides."""
    return law.k_t == 0.0 and abs(mode.contact) == 1


@compiled
def coulomb_limits(law, d):
    """Return the friction limits of a direction of motion as a `CoulombLaw`."""
    side = side_of(law, d)
    return CoulombLaw(side.F_fk, side.F_fs, law.variation, law.omega, law.phase)


@compiled
def coulomb_kernel_law(plant, law, record):
    """Return a `CoulombLaw`, with the damper of the plant, as a `KernelLaw`.

    Its record of the normal force is never read: the array only has the right type.
    """
    side = Side(law.F_fk, law.F_fs, plant.b, NEVER)
    stages, begins = (0.0, 0.0, 0.0), (0.0, NEVER, NEVER)
    wave = law.variation, law.omega, law.phase
    return KernelLaw(side, side, 0.0, *wave, record, 0.0, stages, begins, 0.0, 0.0)


# The equation of motion in a mode, and the forces.


class SegmentBase(NamedTuple):
    """Start of a segment [s], and ü besides the waves there [m/s²] with its rate [m/s³]."""

    t: float
    u_0: float
    slope: float


QUASI_STATIC_RATIO = 16.0
"""Least square of the ratio of natural to driving frequency for which a wave is followed
quasi-statically."""


@compiled
def mode_equation(plant, law, waves, mode, x_0, base):
    """Return the equation of a segment and its `LoadRamp`; set the phases of the waves.

    Parameters
    ----------
    plant, law, waves, mode
    x_0 : float
        x_r at which an elastic contact carries no force [m].
    base : SegmentBase
    """
    t, u_0, slope = base
    forces, x_origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    m, k_x, b = forces.plant
    d = mode.contact if abs(mode.contact) == 1 else 0
    ramp, f = load_ramp_at(law, t), forces.F / m
    g = -u_0 - f * ramp.load - forces.k_t * (x_origin - x_0) / m
    g += forces.offset / m - k_x / m * x_origin
    r = -slope - f * ramp.rate
    effective = Plant(m, k_x + forces.k_t + forces.k_s, b + forces.b_s)
    w = effective.k_x / m
    set_phases(waves, effective, coulomb_limits(law, d), t, d)
    if law.k_t > 0.0:
        for i in range(waves.size):
            row = WAVE_COLUMNS * i
            if (
                waves.values[row + STEADY] > 0.0
                and QUASI_STATIC_RATIO * waves.values[row + OMEGA] ** 2 <= w
            ):
                waves.values[row + STEADY] = 2.0
    return Equation(effective.b / m, w, g, r), ramp


class Forces(NamedTuple):
    """Forces on the mass in a mode, linear in its motion.

    The friction force is k_t (x_r - x_0) + F N, with N the relative normal force, and the force
    of a stop k_s xi - offset + b_s v_r.

    Attributes
    ----------
    plant : Plant
        Oscillator, with the damper of this direction of motion.
    k_t, x_0, F : float
        Stiffness of a contact that holds [N/m], displacement at which it carries no force [m],
        and friction force of a contact that slides [N].
    k_s, offset, b_s : float
        Stiffness [N/m], offset [N] and damping [N·s/m] of a bumper in contact.
    reference : float
        Friction force by which the work done on the contact is divided [N].
    """

    plant: Any
    k_t: float
    x_0: float
    F: float
    k_s: float
    offset: float
    b_s: float
    reference: float


@compiled
def mode_forces(plant, law, mode, x_0):
    """Return the `Forces` of a mode; `x_0` is x_r where a contact carries no force [m]."""
    damped = Plant(plant.m, plant.k_x, side_of(law, mode.direction).b)
    k_t = law.k_t if mode.contact == HOLD else 0.0
    F = mode.contact * side_of(law, mode.contact).F_fk if abs(mode.contact) == 1 else 0.0
    k_s, offset, b_s = 0.0, 0.0, 0.0
    side, stage, released = stop_stage(mode.end_stop)
    if stage > 0 and not released and law.k_s[0] > 0.0:
        k_s, offset = bumper_line(law, stage)
        offset, b_s = side * offset, law.b_s
    reference = max(law.up.F_fk, law.down.F_fk)
    return Forces(damped, k_t, x_0, F, k_s, offset, b_s, reference)


@compiled
def bumper_line(law, stage):
    """Return stiffness [N/m] and offset [N] of a bumper: force = stiffness·depth - offset."""
    stiffness, offset = 0.0, 0.0
    for i in range(stage):
        stiffness += law.k_s[i]
        if i > 0:
            offset += law.k_s[i] * law.begins[i]
    return stiffness, offset


@compiled
def contact_force(forces, x_r, load):
    """Return the force of a contact that is not stuck [N]; `load` is the normal force [-]."""
    return forces.k_t * (x_r - forces.x_0) + forces.F * load


@compiled
def bumper_force(forces, xi, v_r):
    """Return the force of a bumper on the mass [N], positive at the positive stop.

    Notes
    -----
    The force grows with the depth side·xi by the stiffness of the stages that act, plus b_s
    times the velocity; it cannot pull. Where the mass moves away faster than the bumper
    relaxes, contact is lost beyond the limit, and found again if the mass slows down there.
    """
    return forces.k_s * xi - forces.offset + forces.b_s * v_r


@compiled
def wall_side(law, mode, xi):
    """Return the side of the rigid stop that the mass touches, 0 for none."""
    return mode.origin if law.k_s[0] == 0.0 and xi == 0.0 else 0


@compiled
def friction_and_stop_forces(law, mode, forces, state, u_dd, load):
    """Return the friction force and the force of a stop [N].

    `forces` are those of the mode, and the state is xi [m] and v_r [m/s]. At rest against a
    rigid stop only the sum is determined: friction then carries as much as its static limit
    allows, the stop the rest.
    """
    xi, v_r = state
    x_r = origin_of(law, mode.origin) + xi
    stop = bumper_force(forces, xi, v_r)
    sticks = mode.direction == AT_REST and mode.contact == HOLD and law.k_t == 0.0
    friction = 0.0 if sticks else contact_force(forces, x_r, load)
    if mode.direction != AT_REST:
        return friction, stop
    F_L = limit_force(forces.plant, x_r, u_dd) + stop
    if wall_side(law, mode, xi) == 0:
        return -F_L, stop
    if sticks:
        friction = min(max(-F_L, -law.down.F_fs * load), law.up.F_fs * load)
    return friction, -F_L - friction


# Start of a motion.

LIMIT_TOLERANCE = 1e-14
"""Relative distance from its limit below which a contact that starts is at its limit: some 50
units of rounding of x_r - x_0, a difference of two numbers of a file or of an orbit."""

REACHED_TOLERANCE = 1e-12
"""The same for a contact that a march has brought to its limit: x_0 was reset at an event,
whose place is a sum over waves and has lost some more digits."""


@compiled
def initial_piecewise_state(plant, law, waves, base, x_r, v_r, x_0):
    """Return the `ModeState` at t = 0, with x_r [m] and v_r [m/s] then, and its `rest_margin`.

    An elastic contact deflected to its limit, and moving on, yields already, so that no event
    follows at once. One deflected beyond the limit, as rounding of a periodic orbit may
    produce, has yielded: x_0 moves.
    """
    d = int(ZERO)
    set_phases(waves, plant, coulomb_limits(law, d), 0.0, d)
    load, load_d = load_at(law, waves, load_ramp_at(law, 0.0), 0.0)
    u_dd = base_motion(waves, base.u_0, base.slope, 0.0)[0]
    origin, xi, end_stop = end_stop_coordinates(law, x_r, v_r)
    # A normal force that only touches zero does not separate the surfaces.
    lifts = law.step > 0.0 or law.variation > 1.0
    contact = HOLD
    if load < 0.0 or (load == 0.0 and load_d <= 0.0 and lifts):
        contact, x_0 = FREE, x_r
    elif law.k_t > 0.0 and load == 0.0:
        contact, x_0 = closing_contact(law, v_r, law.up.F_fk * load_d), x_r
    elif law.k_t > 0.0:
        side = sign(x_r - x_0)
        x_limit, distance = law.up.F_fk * load / law.k_t, abs(x_r - x_0)
        if distance > x_limit:
            x_0 = x_r - side * x_limit
        deflected = distance >= x_limit - LIMIT_TOLERANCE * (x_limit + abs(x_r))
        if deflected and law.k_t * side * v_r > law.up.F_fk * load_d:
            contact = side
    elif v_r != 0.0:
        contact = sign(v_r)
    mode = mode_of(contact, sign(v_r), end_stop, origin)
    margin = NEVER
    if v_r == 0.0:
        mode = mode_from_rest(plant, law, mode, x_0, xi, u_dd, max(load, 0.0))
        F_L = limit_force(plant, x_r, u_dd) + bumper_force(
            mode_forces(plant, law, mode, x_0), xi, 0.0
        )
        if F_L != 0.0:
            margin = rest_margin(law, mode, xi, F_L, max(load, 0.0))
    return ModeState(mode, xi, v_r, x_0), margin


@compiled
def limit_side(law, stretch, load):
    """Return the side at whose limit an elastic contact is, to within rounding, or 0."""
    x_limit = law.up.F_fk * load / law.k_t
    return sign(stretch) if abs(stretch) >= x_limit * (1.0 - REACHED_TOLERANCE) else 0


@inlined
def closing_contact(law, v_r, rate):
    """Return the state of an elastic contact whose surfaces just touch.

    It yields where the limit rises slower than the force would, at `rate` [N/s]; or it holds.
    """
    return sign(v_r) if law.k_t * abs(v_r) > rate else HOLD


@compiled
def end_stop_coordinates(law, x_r, v_r):
    """Return the origin of xi, xi [m] and the state at the end stops at x_r, v_r."""
    side = 1 if x_r > 0.0 else -1
    limit = side_of(law, side).limit
    if not abs(x_r) >= limit:
        return 0, x_r, APART
    xi = x_r - side * limit
    if law.k_s[0] == 0.0 or xi == 0.0:
        return side, xi, APART
    stage = 1
    while stage < MAX_STAGES and side * xi > law.begins[stage]:
        stage += 1
    stiffness, offset = bumper_line(law, stage)
    presses = stiffness * side * xi - offset + law.b_s * side * v_r > 0.0
    return side, xi, side * (stage if presses else stage + RELEASED)


@compiled
def mode_from_rest(plant, law, mode, x_0, xi, u_dd, load):
    """Return the mode of a mass with v_r = 0.

    A rigid contact sticks or slides on, Eq. (9) of the paper. Elsewhere the mass moves on,
    unless it rests against a rigid stop, which carries any force towards it.
    """
    x_r = origin_of(law, mode.origin) + xi
    forces = mode_forces(plant, law, mode, x_0)
    pull = plant.k_x * x_r + bumper_force(forces, xi, 0.0)
    sticks = law.k_t == 0.0 and mode.contact != FREE
    if not sticks:
        pull += contact_force(forces, x_r, load)
    F_L = plant.m * u_dd + pull
    hold, wall = 0.0, wall_side(law, mode, xi)
    if sticks:
        hold = side_of(law, -sign(F_L)).F_fs * load
    d = direction_from_rest(F_L, hold, pull)
    if d == wall:
        d = AT_REST
    if sticks:
        return mode_of(d, d, mode.end_stop, mode.origin)
    if wall == 0 and d == AT_REST:
        d = mode.direction if mode.direction != AT_REST else 1
    return mode_of(mode.contact, d, mode.end_stop, mode.origin)


@compiled
def rest_margin(law, mode, xi, F_L, load):
    """Return the relative margin of the decision whether a mass with v_r = 0 sticks [-].

    `F_L` includes the force of a bumper [N]. The margin is infinite where friction does not
    decide.
    """
    if law.k_t > 0.0 or mode.contact == FREE or wall_side(law, mode, xi) != 0:
        return NEVER
    F_fs = side_of(law, -sign(F_L)).F_fs * load
    return decision_margin(F_L, F_fs) if F_fs > 0.0 else NEVER


# Elastic contact: exits from hold and yield.

RATE_TOLERANCE = 1e-12
"""Relative difference of two rates, those of stretch and limit, that counts as rounding: a
contact at its limit stays there. A rate is a sum over waves that may cancel."""


class Hold(NamedTuple):
    """A segment of an elastic contact that holds.

    Attributes
    ----------
    segment, waves
        As in `first_root`, with the stiffness of the contact in the segment.
    law : KernelLaw
    ramp : LoadRamp
        Of the normal force at the start.
    x_0 : float
        Value of the segment's x_r at which the contact carries no force [m].
    poised : int
        The side at whose limit the contact starts exactly, 0 for none.
    """

    segment: Any
    waves: Any
    law: Any
    ramp: Any
    x_0: float
    poised: int


@compiled
def guard_hold(hold, d, h):
    """Return when within h [s] a contact that holds yields, and how.

    Parameters
    ----------
    hold : Hold
    d : int
        Direction of motion, which v_r keeps up to h; 0 if nothing moves.
    h : float
        Length of the interval [s].

    Returns
    -------
    s, side, x_r, v_r
        Time [s], infinite for never; direction of yielding; state at that time.

    Notes
    -----
    Under a constant normal force the contact yields in the direction of motion only. A limit
    that falls may also reach the force from the other side.
    """
    side = d if d != 0 else 1
    s, x, v = guard_hold_side(hold, side, h)
    if load_varies(hold.law):
        t, x_t, v_t = guard_hold_side(hold, -side, min(s, h))
        if t < s:
            return t, -side, x_t, v_t
    return s, side, x, v


@compiled
def guard_hold_side(hold, side, h):
    """Return when within h [s] a holding contact yields to a side, and the state.

    `side` is +1 for yielding with increasing x_r, -1 with decreasing.
    """
    segment, waves, law, ramp, x_0, poised = hold
    F_fk, zeros = law.up.F_fk, 0
    if side == poised:
        # The value is zero; so is the rate, unless the slope of a recorded force jumps here,
        # and the curvature where the mass leaves a rigid stop.
        jumps = limit_outpaces_force(law, ramp, side, segment.v_r)
        zeros = 1 if jumps else 2
        if segment.v_r == 0.0 and segment.a == 0.0 and law.variation == 0.0 and not jumps:
            zeros = 3
    clearance = Observable(
        x_0, -side * law.k_t, 0.0, F_fk, 0.0, F_fk * (ramp.load - 1.0), F_fk * ramp.rate
    )
    return first_root(segment, waves, law, clearance, zeros, h)[:3]


@compiled
def limit_outpaces_force(law, ramp, side, v_r):
    """Return whether the limit rises faster than the force of a contact that is at it.

    This happens at once where the slope of a recorded normal force jumps.
    """
    falls, gains = side * law.k_t * v_r, law.up.F_fk * ramp.rate
    return law.step > 0.0 and gains - falls > RATE_TOLERANCE * (abs(gains) + abs(falls))


@compiled
def guard_yield(segment, waves, law, ramp, d, h):
    """Return when within h [s] a contact yielding in direction d holds again, and the state.

    It holds when v_r falls to the rate of the limit over k_t; with constant normal force, when
    the mass stops.
    """
    if load_varies(law):
        if limit_outpaces_force(law, ramp, d, segment.v_r):
            return 0.0, segment.x_r, segment.v_r
        share = law.up.F_fk / law.k_t
        excess = Observable(0.0, 0.0, float(d), 0.0, -share, -share * ramp.rate, 0.0)
        return first_root(segment, waves, law, excess, int(ZERO), h)[:3]
    if motion_direction(segment.v_r, segment.a, segment.j) != d:
        return 0.0, segment.x_r, 0.0
    stop, x, _ = first_stop(segment, waves, law, d, h)
    return stop, x, 0.0


# End stops: exits.


@compiled
def guard_arrival(segment, waves, d, distance, until):
    """Return when within [0, until] xi, moving in direction d, is at d·distance; or infinity.

    The velocity does not change its sign up to `until` [s]; `distance` is the target position
    in the direction of motion [m].
    """
    equation, xi, v_r = segment.equation, segment.x_r, segment.v_r
    gap = distance - d * xi
    if gap <= 0.0:
        return 0.0
    rest = distance - d * motion_at(equation, waves, xi, v_r, until).x_r
    if rest > 0.0:
        return NEVER
    low, high = 0.0, until
    s = until * (gap / (gap - rest))
    for _ in range(MAX_BISECTIONS):
        now = motion_at(equation, waves, xi, v_r, s)
        gap, speed = distance - d * now.x_r, d * now.v_r
        low, high, s, done = safeguarded_newton(low, high, s, gap, -speed)
        if done:
            break
    return s


@compiled
def guard_bumper_force(segment, waves, law, mode, side, h):
    """Return when within [0, h] the force of a bumper, times a sign, is zero, or infinity.

    Parameters
    ----------
    segment, waves, law
    mode : Mode
        Touching the bumper, or released from it.
    side : int
        The side of the stop for the loss of contact, the other side for contact anew.
    h : float
        Length of the segment [s].
    """
    stop_side, stage, _ = stop_stage(mode.end_stop)
    stiffness, offset = bumper_line(law, stage)
    at_zero = mode.entry == BUMPER_AT_ZERO
    constant = -side * stop_side * offset
    if (
        not at_zero
        and side * (stiffness * segment.x_r + law.b_s * segment.v_r) + constant <= 0.0
    ):
        return 0.0
    force = Observable(0.0, side * stiffness, side * law.b_s, 0.0, 0.0, constant, 0.0)
    return first_root(segment, waves, law, force, 1 if at_zero else 0, h)[0]


@compiled
def guard_end_stop(segment, waves, law, mode, until):
    """Return when the mass reaches or leaves a stop or a stage of it, else infinity.

    Returns also the state at the stops that follows. The velocity keeps its sign up to `until`
    [s].
    """
    d, x_origin = mode.direction, origin_of(law, mode.origin)
    if mode.end_stop == APART:
        distance = side_of(law, d).limit - d * x_origin
        if distance == NEVER:
            return NEVER, APART
        return guard_arrival(segment, waves, d, distance, until), d
    side, stage, released = stop_stage(mode.end_stop)
    if side == d:
        begin = law.begins[stage] if stage < MAX_STAGES and not released else NEVER
        if begin == NEVER:
            return NEVER, mode.end_stop
        return guard_arrival(segment, waves, d, begin, until), side * (stage + 1)
    # A released bumper is ahead of a mass that moves outwards, so this one moves inwards.
    force, passed = NEVER, NEVER
    if released or law.b_s > 0.0:
        lost = -side if released else side
        force = guard_bumper_force(segment, waves, law, mode, lost, until)
    if released or law.b_s == 0.0 or stage > 1:
        begin = -law.begins[stage - 1]
        passed = guard_arrival(segment, waves, d, begin, min(force, until))
    if passed < force:
        return passed, APART if stage == 1 else mode.end_stop - side
    return force, side * (stage if released else stage + RELEASED)


@compiled
def guard_rest(plant, law, waves, state, base, ramp, left):
    """Return when a mass at rest breaks away, or infinity, and in which direction.

    A rigid contact sticks up to its static limit; returns also the margin of the closest
    decision, as in `break_away_time`, or infinity. Against a rigid stop the mass rests as long
    as the sum of the other forces presses it there.
    """
    mode, xi, _, x_0 = state
    _, u_0, slope = base
    x_r = origin_of(law, mode.origin) + xi
    forces = mode_forces(plant, law, mode, x_0)
    pull = plant.k_x * x_r + bumper_force(forces, xi, 0.0)
    wall = wall_side(law, mode, xi)
    hold_up, hold_down = law.up.F_fs, law.down.F_fs
    if law.k_t > 0.0 or mode.contact == FREE:
        hold_up = hold_down = 0.0
        pull += contact_force(forces, x_r, 0.0)
    elif waves.base == 0 and slope == 0.0 and plant.m * u_0 + pull == 0.0:
        # F_L stays 0, and no limit is exceeded even where it vanishes.
        return NEVER, 0, NEVER
    rising = hold_down * ramp.load, slope - hold_down * ramp.rate / plant.m
    falling = hold_up * ramp.load, slope + hold_up * ramp.rate / plant.m
    stuck = Stuck(plant.m, pull, u_0, rising, falling, law.variation, law.omega)
    if wall != 0:
        return stick_exit_time(stuck, waves, wall, 0.0, left)[0], -wall, NEVER
    return break_away_time(stuck, waves, left)


@compiled
def reset_break_away(law, mode, d, stretch, load):
    """Return mode and event kind after a mass at rest breaks away in direction d.

    `stretch` is x_r less that at which an elastic contact carries no force [m].
    """
    if law.k_t == 0.0 and mode.contact == HOLD:
        return Mode(d, d, mode.end_stop, mode.origin, d, REGULAR), d * SLIP
    poised = limit_side(law, stretch, load) if mode.contact == HOLD else 0
    return Mode(mode.contact, d, mode.end_stop, mode.origin, poised, LEAVING), d * RELEASE


# End stops: resets.


@compiled
def reset_bumper(mode, after, xi):
    """Return xi and mode after a change of the state at a bumper, and the event kind or 0."""
    d, kind = mode.direction, 0
    _, stage, released = stop_stage(mode.end_stop)
    _, next_stage, releases = stop_stage(after)
    touched, touches = stage > 0 and not released, next_stage > 0 and not releases
    if releases and d * xi >= 0.0:
        after = APART
    if touched and not touches:
        kind = d * RELEASE
    elif touches and not touched:
        kind = d * CONTACT
    if after == APART:
        return 0.0, mode_of(mode.contact, d, APART, mode.origin), kind
    at_zero = BUMPER_AT_ZERO if touched != touches else REGULAR
    return xi, Mode(mode.contact, d, after, mode.origin, 0, at_zero), kind


@compiled
def reset_impact(plant, law, state, now, rate):
    """Return v_r and mode after an impact on a rigid stop, at which the mode measures xi.

    Parameters
    ----------
    plant, law
    state : ModeState
        Before the impact.
    now : Instant
        Of the impact.
    rate : float
        Bound on the rate of the force per mass [m/s³].
    """
    mode, _, v_r, x_0 = state
    side = mode.origin
    contact = mode.contact
    if law.k_t == 0.0 and contact != FREE:
        contact = -side
    speed = law.e * max(side * v_r, 0.0)
    apart = mode_of(contact, -side, APART, side)
    if speed == 0.0:
        return 0.0, apart
    if is_unresolved_chatter(plant, law, ModeState(apart, 0.0, speed, x_0), now, rate):
        rest = HOLD if law.k_t == 0.0 and contact != FREE else contact
        return -side * speed, Mode(rest, AT_REST, APART, side, 0, CHATTERING)
    return -side * speed, apart


@compiled
def is_unresolved_chatter(plant, law, state, now, rate):
    """Return whether all further rebounds are below the resolution of x_r and end at rest.

    Parameters as in `reset_impact`, after the impact, with the speed for v_r.

    Notes
    -----
    This holds if the next flight is too low to change x_r or too short to change t, and if the
    force provably presses the mass against the stop until the last flight ends, see
    `chatter_time`. The motion afterwards is then the same to the last bit.
    """
    mode, _, v, x_0 = state
    p, q = return_accelerations(plant, law, mode, x_0, now.u_dd, now.load)
    if p <= 0.0:
        return False
    whole, flight = chatter_time(law, p, q, v)
    x_r = abs(origin_of(law, mode.origin))
    if x_r - v * v / (2.0 * p) != x_r and now.t + flight != now.t:
        return False
    return q <= 0.0 or rate * whole < q


@compiled
def force_rate_bound(plant, law, waves, slope, ramp):
    """Return a bound on the rate of the force per mass in a segment [m/s³]."""
    drift = max(law.up.F_fk, law.down.F_fk) * abs(ramp.rate) / plant.m
    return force_rate_bounds(waves, slope)[0] + drift


@compiled
def return_accelerations(plant, law, mode, x_0, u_dd, load):
    """Return the accelerations towards a rigid stop, p moving away and q moving back [m/s²]."""
    side = mode.origin
    x_r = origin_of(law, side)
    F_L = limit_force(plant, x_r, u_dd)
    away, back = side_of(law, -side).F_fk * load, side_of(law, side).F_fk * load
    if law.k_t > 0.0 or mode.contact == FREE:
        F_L += contact_force(mode_forces(plant, law, mode, x_0), x_r, load)
        away = back = 0.0
    return (-side * F_L + away) / plant.m, (-side * F_L - back) / plant.m


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
def chatter_mean_square(u_dd, side, p, q):
    """Return the mean square of x" over all flights of a chatter at a stop [m²/s⁴].

    Of each flight, the share √q/(√p + √q) moves away: 1/p of 1/p + 1/√(p q). Friction changes
    sign at the turning point. `side` is that of the stop.
    """
    share = math.sqrt(q) / (math.sqrt(p) + math.sqrt(q)) if q > 0.0 else 1.0
    return share * (u_dd + side * p) ** 2 + (1.0 - share) * (u_dd + side * q) ** 2


# Varying normal force, and its zeros.


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
def load_varies(law):
    """Return whether the normal force depends on time."""
    return law.variation > 0.0 or law.step > 0.0


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
def reset_zero_load(plant, law, state, u_dd, load_d):
    """Return mode and event kind after the normal force passes zero at the rate load_d [1/s].

    Separated surfaces close; others separate. x_0 of the state is x_r then.
    """
    mode, xi, v_r, x_0 = state
    d = mode.direction
    contact, rests = int(FREE), d == AT_REST
    if mode.contact == FREE and law.k_t > 0.0:
        contact, rests = closing_contact(law, v_r, law.up.F_fk * load_d), False
    elif mode.contact == FREE:
        contact, rests = sign(v_r), v_r == 0.0
        d = d if rests else contact
    after = mode_of(contact, d, mode.end_stop, mode.origin)
    if rests:
        after = mode_from_rest(plant, law, after, x_0, xi, u_dd, 0.0)
    if after.contact == FREE:
        return after, LIFT
    return after, STICK if after.contact == HOLD else after.contact * SLIP


@compiled
def guard_separation(law, waves, ramp, contact):
    """Return when in a segment the surfaces separate, or close if separated [s], or infinity.

    `ramp` is that of the segment, at whose start the phases are set.
    """
    closes = contact == FREE
    if law.step > 0.0:
        if closes:
            return max(-ramp.load / ramp.rate, 0.0) if ramp.rate > 0.0 else NEVER
        if ramp.rate < 0.0:
            return max(ramp.load / -ramp.rate, 0.0)
        return 0.0 if ramp.load <= 0.0 and ramp.rate == 0.0 else NEVER
    if law.variation <= 1.0:
        return NEVER
    load, load_d, _ = relative_normal_force(law, waves, 0.0)
    if not closes and load <= 0.0 and load_d < 0.0:
        return 0.0
    if closes and load >= 0.0 and load_d > 0.0:
        return 0.0
    dip = math.asin(1.0 / law.variation)
    angle = 2.0 * math.pi - dip if closes else math.pi + dip
    theta = waves.values[WAVE_COLUMNS * waves.base + THETA]
    return (angle - theta) % (2.0 * math.pi) / law.omega
