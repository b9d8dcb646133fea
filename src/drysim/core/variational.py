"""Variational equation: derivatives of a motion by its start and the numbers of its scene.

Problem
    Newton's method on a return map, Floquet multipliers, continuation and Lyapunov exponents
    need the monodromy matrix: the derivative of the state after some time with respect to the
    state before. A fit needs the sensitivities: the derivatives of the motion at the samples
    with respect to stiffness, damping, friction forces, stops and start. Differences of two
    marches lose half of the digits, and all of them where an event lies between the two.

Method
    - Within a segment the equation of motion is linear. A deviation of the state obeys the
      same equation without its forcing, and `flow` propagates it. One of the scene adds the
      source -(δw x_r + δc v_r) + δg - δ(f N), with w, c, g and f as in `Sources`: the response
      to it is minus the derivative of the closed-form motion with respect to w, c and the
      other numbers (`flow_and_slope`, `wave_response`).
    - At an event the motion crosses a guard h(t, z) = 0 and is reset to R(t, z). A deviation
      reaches the guard earlier or later, and moves meanwhile under the other field: it is
      multiplied by the saltation matrix

          S = DR + (F⁺ - DR F⁻ - R_t) ∇h / (∇h·F⁻ + h_t)

      with the fields F⁻ before and F⁺ after the event. At a fixed time S = DR. A deviation of
      the scene moves guard and reset as well: with h_p and R_p the derivatives of these, the
      deviation after the event has the further terms R_p + (F⁺ - DR F⁻ - R_t) h_p / (∇h·F⁻ +
      h_t).

Why nothing is missed
    The march has found every event and stored the mode before and after it. S differs from
    the identity where the force jumps or the state is reset. Forces jump at three guards only:

    ============================  ========================  ================================
    event                         guard                     S
    ============================  ========================  ================================
    a slip stops or turns         v_r = 0                   v_v = a⁺/a⁻
    break-away, direction d       d F_L + F_fs N = 0        v_x = d k a⁺/(d m ü' + F_fs N')
    contact with an end stop      x_r at the limit          x_x = v⁺/v⁻, v_v = r,
                                                            v_x = (a⁺ - r a⁻)/v⁻
    ============================  ========================  ================================

    with r = -e at a rigid stop, and 1 at a bumper, where the damper sets in. The guard v_r = 0
    has no parameter; that of a break-away has all that F_L and the static limit depend on, and
    x_r at a stop counts from its position. Everywhere else the force is continuous, and the
    guard does not matter: where an elastic contact yields or holds again, at each stage of a
    bumper, where it is released, where the normal force vanishes, and in a damper at v_r = 0.
    There only x_0 is reset, the x_r at which an elastic contact carries no force: it follows
    x_r where the contact yields, at a distance of F N/k_t, or is separated.

    Where a denominator is zero the mass grazes the guard, and the derivative is infinite.

References: M. A. Aizerman and F. R. Gantmakher, Q. J. Mech. Appl. Math. 11 (1958) 407; P. C.
Müller, Chaos, Solitons & Fractals 5 (1995) 1671; R. I. Leine and H. Nijmeijer, Dynamics and
Bifurcations of Non-Smooth Mechanical Systems (2004); M. di Bernardo, C. J. Budd,
A. R. Champneys and P. Kowalczyk, Piecewise-smooth Dynamical Systems (2008).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined, merged
from drysim.core.events import sign
from drysim.core.forcing import (
    FREQUENCY,
    OMEGA,
    PHASE,
    WAVE_COLUMNS,
    A,
    base_motion,
    phase_at,
    relative_normal_force,
    set_phases,
)
from drysim.core.model import MAX_STAGES, Plant
from drysim.core.modes import (
    ARRIVAL,
    AT_REST,
    CHATTERING,
    FREE,
    HOLD,
    KernelLaw,
    ModeState,
    bumper_force,
    contact_force,
    coulomb_limits,
    decode_mode,
    load_at,
    load_ramp_at,
    load_varies,
    mode_forces,
    origin_of,
    side_of,
    stop_stage,
)
from drysim.core.oscillator import (
    flow,
    flow_and_slope,
    wave_response,
)
from drysim.core.trajectory import segment_base, segment_length

# The saltation of a deviation.


@inlined
def turn_factor(a_before, a_after):
    """Return the factor of a deviation of v_r where a slip stops, a_after = 0, or turns."""
    return a_after / a_before if a_before != 0.0 else math.inf


@inlined
def break_away_factor(d, k, away, approach):
    """Return the deviation of v_r per deviation of x_r at a break-away in direction d [1/s].

    `k` is the stiffness [N/m], `away` the jump of the acceleration [m/s²], and `approach` the
    rate at which F_L approaches the static limit [N/s].
    """
    if away == 0.0:
        return 0.0
    return away * d * k / approach if approach != 0.0 else math.inf


# Coulomb friction under waves, from its events.


@compiled
def event_monodromy(scene, length, rate, d, first, events):
    """Return the monodromy matrix of a motion with Coulomb friction, from its events.

    Parameters
    ----------
    scene : SineMarch
        Its log holds the events.
    length : float
        Length of the motion [s].
    rate : float
        Scale of v_r/x_r [1/s].
    d : int
        Direction of sliding at the start, 0 when stuck.
    first, events : int
        The events are the rows `first` to `events` - 1 of the log.

    Returns
    -------
    a, b, c, e : float
        Derivatives of x_r and v_r/rate at the end with respect to x_r (a, c) and to v_r/rate
        (b, e) at the start; infinite where the motion grazes.

    Notes
    -----
    `propagate_deviations` finds the same from the segments of any law. In the kernel of orbits
    it takes 0.6 µs more each time, of 26 for an orbit, and 10 s to compile.
    """
    plant, law, waves, log = scene
    damping = plant.b / plant.m
    w = plant.k_x / plant.m
    a, c, b, e = 1.0, 0.0, 0.0, 1.0 if d != 0 else 0.0
    begin = 0.0
    for i in range(first, events + 1):
        until = log.s[i] if i < events else length
        if d != 0:
            y, y_d, _, _ = flow(damping, w, until - begin)
            # Free motion of the deviation, with velocities divided by `rate`.
            keep = y_d + damping * y
            a, c = keep * a + y * rate * c, y_d * c - w * y / rate * a
            b, e = keep * b + y * rate * e, y_d * e - w * y / rate * b
        if i == events:
            return a, b, c, e
        begin, after = until, sign(log.kind[i])
        set_phases(waves, plant, law, begin, d)
        factor = event_factor(plant, law, waves, d, after, log.x_r[i])
        # A stop depends on the velocity before it, a break-away on the displacement.
        c, e = (factor * c, factor * e) if d != 0 else (factor * a / rate, factor * b / rate)
        d = after
    return a, b, c, e


@compiled
def event_factor(plant, law, waves, d, after, x_r):
    """Return `turn_factor` or, where d is 0, `break_away_factor` of an event at x_r [m].

    The phases of the waves must be set at the event.
    """
    u_dd, u_ddd, _ = base_motion(waves, 0.0, 0.0, 0.0)
    load, load_d, _ = relative_normal_force(law, waves, 0.0)
    if d == 0:
        away = after * (law.F_fs - law.F_fk) * load / plant.m
        approach = law.F_fs * load_d + after * plant.m * u_ddd
        return break_away_factor(after, plant.k_x, away, approach)
    free = -(u_dd + plant.k_x / plant.m * x_r)
    slip = law.F_fk * load / plant.m
    return turn_factor(free - d * slip, free - after * slip if after != 0 else 0.0)


# Any law in closed form: the segments are the solution.


class Deviations(NamedTuple):
    """Small deviations of the state: arrays of shape (n,), one element per deviation.

    Attributes
    ----------
    x_r, v_r : array of float
        Of displacement and velocity.
    x_0 : array of float
        Of the x_r at which an elastic contact carries no force; follows x_r where the contact
        yields or is separated. Unused of a rigid contact.
    """

    x_r: Any
    v_r: Any
    x_0: Any


class Forcing(NamedTuple):
    """Base motion and normal force at an event.

    Attributes
    ----------
    u_dd, u_ddd : float
        ü [m/s²] and its derivative [m/s³].
    load, load_d : float
        Relative normal force [-] and its derivative [1/s].
    """

    u_dd: float
    u_ddd: float
    load: float
    load_d: float


@compiled
def propagate_deviations(solution, deviations):
    """Propagate `Deviations` from the start of a `Solution` to its end, in place."""
    (plant, law, _, _, dt), segments = solution
    mode = decode_mode(segments.d[0])
    for i in range(len(segments.n) - 1):
        if segments.d[i] == ARRIVAL:
            continue
        before = mode
        move_deviations(plant, law, before, segment_length(segments, dt, i), deviations)
        mode = next_mode(segments, i)
        pass_event(solution, before, mode, i, deviations)
    if law.k_t > 0.0 and mode.contact != HOLD:
        reset_anchor(deviations, False)


@compiled
def next_mode(segments, i):
    """Return the mode after the event that ends segment i."""
    return decode_mode(segments.d[i + 2 if segments.d[i + 1] == ARRIVAL else i + 1])


@compiled
def pass_event(solution, before, after, i, deviations):
    """Apply the event that ends segment i to deviations of the state."""
    (_, law, _, _, _), segments = solution
    arrives = segments.d[i + 1] == ARRIVAL
    if arrives:
        meet_stop(solution, before, after, i, deviations)
    elif is_stop_or_break_away(law, before, after):
        stop_or_break_away(solution, before, after, i, deviations)
    if is_anchored(law, before, after):
        reset_anchor(deviations, arrives)


@compiled
def is_stop_or_break_away(law, before, after):
    """Return whether a rigid contact stops, turns or breaks away, if it meets no end stop."""
    rigid = law.k_t == 0.0 and before.contact != FREE and after.contact != FREE
    return rigid and before.contact != after.contact


@compiled
def is_anchored(law, before, after):
    """Return whether an elastic contact begins to hold."""
    return law.k_t > 0.0 and before.contact != HOLD and after.contact == HOLD


@merged
def move_deviations(plant, law, mode, s, deviations):
    """Propagate deviations through a time s of a mode [s]."""
    x_r, v_r, x_0 = deviations
    if mode.direction == AT_REST:
        for k in range(len(x_r)):
            v_r[k] = 0.0
        return
    forces = mode_forces(plant, law, mode, 0.0)
    m, k_x, b = forces.plant
    w, pull = (k_x + forces.k_t + forces.k_s) / m, forces.k_t / m
    y, y_d, Y, _ = flow((b + forces.b_s) / m, w, s)
    for k in range(len(x_r)):
        x, v = x_r[k], v_r[k]
        push = pull * x_0[k] - w * x
        x_r[k], v_r[k] = x + v * y + push * Y, v * y_d + push * y


@merged
def meet_stop(solution, before, after, i, deviations):
    """Apply the contact with an end stop between segments i and i + 2 to deviations."""
    (plant, law, _, _, _), segments = solution
    v_before, v_after = segments.v_r[i + 1], segments.v_r[i + 2]
    # All rebounds of a chatter end in the same state of rest.
    x_x = v_x = v_v = 0.0
    if after.entry != CHATTERING:
        limit = origin_of(law, after.origin)
        now = forcing_at(solution, i + 2)
        xi = limit - origin_of(law, before.origin)
        begin = ModeState(before, xi, v_before, segments.x_0[i])
        end = ModeState(after, 0.0, v_after, segments.x_0[i + 2])
        a_before = acceleration(plant, law, begin, now)
        a_after = acceleration(plant, law, end, now)
        v_v = -law.e if law.k_s[0] == 0.0 else 1.0
        x_x, v_x = math.inf, math.inf
        if v_before != 0.0:
            x_x, v_x = v_after / v_before, (a_after - v_v * a_before) / v_before
    for k in range(len(deviations.x_r)):
        x, v = deviations.x_r[k], deviations.v_r[k]
        deviations.x_r[k], deviations.v_r[k] = x_x * x, v_x * x + v_v * v


@merged
def stop_or_break_away(solution, before, after, i, deviations):
    """Apply a stop, a turn or a break-away at the end of segment i to deviations."""
    (plant, law, _, _, _), segments = solution
    now, xi = forcing_at(solution, i + 1), segments.x_r[i + 1]
    if before.contact != HOLD:
        # The origin of xi does not change where the mass does not meet a stop.
        a_before = acceleration(plant, law, ModeState(before, xi, 0.0, 0.0), now)
        a_after = acceleration(plant, law, ModeState(after, xi, 0.0, 0.0), now)
        factor = turn_factor(a_before, a_after)
        for k in range(len(deviations.v_r)):
            deviations.v_r[k] *= factor
        return
    d, stiffness = after.contact, plant.k_x + mode_forces(plant, law, before, 0.0).k_s
    away, approach = break_away_rates(plant, law, d, now)
    factor = break_away_factor(d, stiffness, away, approach)
    for k in range(len(deviations.v_r)):
        deviations.v_r[k] = factor * deviations.x_r[k]


@compiled
def break_away_rates(plant, law, d, now):
    """Return `away` and `approach` of `break_away_factor` in direction d."""
    side = side_of(law, d)
    away = d * (side.F_fs - side.F_fk) * now.load / plant.m
    return away, side.F_fs * now.load_d + d * plant.m * now.u_ddd


@compiled
def forcing_at(solution, i):
    """Return the `Forcing` at the start of segment i."""
    (plant, law, waves, u_dd, dt), segments = solution
    t, u_0, slope = segment_base(u_dd, dt, segments, i)
    d = int(ZERO)
    set_phases(waves, plant, coulomb_limits(law, d), t, d)
    u, u_ddd, _ = base_motion(waves, u_0, slope, 0.0)
    load, load_d = load_at(law, waves, load_ramp_at(law, t), 0.0)
    return Forcing(u, u_ddd, max(load, 0.0), load_d)


@compiled
def acceleration(plant, law, state, now):
    """Return the acceleration in a `ModeState` [m/s²]; 0 at rest."""
    mode, xi, v_r, x_0 = state
    if mode.direction == AT_REST:
        return 0.0
    forces, x_r = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin) + xi
    m, k_x, b = forces.plant
    push = contact_force(forces, x_r, now.load) + bumper_force(forces, xi, v_r)
    return -now.u_dd - (k_x * x_r + b * v_r + push) / m


@merged
def reset_anchor(deviations, at_stop):
    """Reset x_0 to x_r, which is the same for all deviations at a rigid stop."""
    for k in range(len(deviations.x_0)):
        deviations.x_0[k] = 0.0 if at_stop else deviations.x_r[k]


# Sensitivities: the numbers of the scene deviate, too.

MASS, SPRING, UP, DOWN, TANGENTIAL = 0, 1, 2, 6, 10
VARIATION, LOAD_OMEGA, LOAD_PHASE = 11, 12, 13
STIFFNESS, BEGIN, STOP_DAMPER, RESTITUTION = 14, 14 + MAX_STAGES, 14 + 2 * MAX_STAGES, 21
START_X, START_V, NUMBERS = 22, 23, 24
"""Rows of the numbers of a scene, see `scene_numbers`."""

KINETIC, STATIC, DAMPER, LIMIT = 0, 1, 2, 3
"""Rows of a `Side`, from UP or DOWN on."""


def scene_numbers(plant: Plant, law: KernelLaw, x_r: float, v_r: float) -> tuple[float, ...]:
    """Return all numbers on which a motion depends, except those of its base."""
    wave, stops = (law.variation, law.omega, law.phase), (*law.k_s, *law.begins, law.b_s, law.e)
    return (plant.m, plant.k_x, *law.up, *law.down, law.k_t, *wave, *stops, x_r, v_r)


class Sensitivities(NamedTuple):
    """Derivatives of a motion at grid points: arrays of shape (n, points).

    Row k is in the direction of column k of the rates, see `propagate_sensitivities`.

    Attributes
    ----------
    x_r, v_r, x_dd : array of float
        Of displacement, velocity and absolute acceleration.
    F_f : array of float
        Of the friction force; at rest of the sum with that of a stop.
    """

    x_r: Any
    v_r: Any
    x_dd: Any
    F_f: Any


class Sources(NamedTuple):
    """Deviations of the equation of a mode, x" + c x' + w x = g - F N/m - ü: arrays (n,).

    N is the relative normal force. The part of g that comes from x_0 is left out, as x_0 is
    one of the `Deviations`.

    Attributes
    ----------
    c, w, g : array of float
        [1/s, 1/s², m/s²].
    f, F : array of float
        Of F/m [m/s²] and of F [N].
    """

    c: Any
    w: Any
    g: Any
    f: Any
    F: Any


class Workspace(NamedTuple):
    """Work space of `propagate_sensitivities`.

    Attributes
    ----------
    deviations : Deviations
    sources : Sources
    responses : MotionResponse
        Arrays with an element per grid point.
    """

    deviations: Any
    sources: Any
    responses: Any


@compiled
def propagate_sensitivities(solution, motion, rates, work, out):
    """Write the derivatives of a motion at the grid points n·dt to `Sensitivities`.

    Parameters
    ----------
    solution : Solution
        Of the segments only those that do not begin at a grid point in the mode before are
        needed. u_dd, besides the waves, has a value at each point. Events at the last point are
        left out.
    motion : (array, array)
        x_r [m] and v_r [m/s] at the grid points, after the events there.
    rates : array of float, shape (NUMBERS, n)
        Directions: derivatives of the numbers of the scene.
    work : Workspace
    out : Sensitivities
        Written.
    """
    scene, rows = solution
    plant, law, _, _, dt = scene
    deviations, last = work.deviations, len(motion[0]) - 1
    for k in range(len(deviations.x_r)):
        deviations.x_r[k] = deviations.x_0[k] = rates[START_X][k]
        deviations.v_r[k] = rates[START_V][k]
    constant = not load_varies(law)
    mode = decode_mode(rows.d[0])
    for i in range(len(rows.n)):
        if rows.d[i] == ARRIVAL:
            continue
        state = ModeState(mode, rows.x_r[i], rows.v_r[i], rows.x_0[i])
        set_sources(plant, law, state, rates, work.sources)
        n, s = rows.n[i], rows.s[i]
        followed = i + 1 < len(rows.n)
        until, end = (rows.n[i + 1], rows.s[i + 1]) if followed else (last, 0.0)
        if s == 0.0:
            write_point(scene, state, n, rates, work, out)
        while n < until:
            if s == 0.0 and constant and mode.direction != AT_REST:
                move_whole_steps(scene, state, (n, until), motion, rates, work, out)
                n = until
                state = state_at_point(law, state, motion, n)
            else:
                move_in_segment(scene, state, (n, s, dt), rates, work)
                n, s = n + 1, 0.0
                state = state_at_point(law, state, motion, n)
                write_point(scene, state, n, rates, work, out)
        if end > s:
            move_in_segment(scene, state, (n, s, end), rates, work)
        if followed:
            before, mode = mode, next_mode(rows, i)
            pass_event_of_scene(solution, (before, mode), i, rates, deviations)


@compiled
def state_at_point(law, state, motion, n):
    """Return the `ModeState` at grid point n of a segment."""
    mode, _, _, x_0 = state
    return ModeState(mode, motion[0][n] - origin_of(law, mode.origin), motion[1][n], x_0)


# Deviations of the equation, of forces and positions.


@compiled
def set_sources(plant, law, state, rates, sources):
    """Set the `Sources` of a mode."""
    mode, x_0 = state.mode, state.x_0
    forces, origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    c, w, f, _ = equation_of(forces)
    m = plant.m
    g = (forces.k_t * x_0 + forces.k_s * origin + forces.offset) / m
    for k in range(len(sources.c)):
        mass, stiffness, push = rates[MASS][k], rates[SPRING][k], 0.0
        damping = rates[side_row(mode.direction) + DAMPER][k]
        if forces.k_t > 0.0:
            stiffness += rates[TANGENTIAL][k]
            push += rates[TANGENTIAL][k] * x_0
        if forces.k_s > 0.0:
            k_s, offset = stop_deviation(law, mode, rates, k)
            stiffness += k_s
            damping += rates[STOP_DAMPER][k]
            limit = limit_deviation(mode.origin, rates, k)
            push += k_s * origin + forces.k_s * limit + offset
        F = slip_force_deviation(mode, rates, k)
        sources.c[k] = (damping - c * mass) / m
        sources.w[k] = (stiffness - w * mass) / m
        sources.g[k] = (push - g * mass) / m
        sources.f[k], sources.F[k] = (F - f * mass) / m, F


@compiled
def equation_of(forces):
    """Return damping, stiffness, contact force and stiffness of the contact, per mass."""
    m, k_x, b = forces.plant
    stiffness = k_x + forces.k_t + forces.k_s
    return (b + forces.b_s) / m, stiffness / m, forces.F / m, forces.k_t / m


@compiled
def side_row(d):
    """Return the first row of a side, or of a direction of motion."""
    return UP if d > 0 else DOWN


@compiled
def slip_force_deviation(mode, rates, k):
    """Return the deviation of the force of a contact that slides, 0 in other modes [N]."""
    d = mode.contact
    return d * rates[side_row(d) + KINETIC][k] if abs(d) == 1 else 0.0


@compiled
def limit_deviation(side, rates, k):
    """Return the deviation of the position of the end stop on a side [m]; 0 for no side."""
    return side * rates[side_row(side) + LIMIT][k] if side != 0 else 0.0


@compiled
def stop_deviation(law, mode, rates, k):
    """Return the deviations of k_s [N/m] and offset [N] of a bumper, as in `Forces`."""
    side, stage, released = stop_stage(mode.end_stop)
    stiffness, offset = 0.0, 0.0
    for i in range(0 if released else stage):
        stiffness += rates[STIFFNESS + i][k]
        if i > 0:
            offset += rates[STIFFNESS + i][k] * law.begins[i]
            offset += law.k_s[i] * rates[BEGIN + i][k]
    return stiffness, side * offset


@compiled
def load_deviation(law, t, rates, k):
    """Return the deviation of the relative normal force at time t [s] [-]."""
    phase = phase_at(law.omega / math.tau, law.phase, t)
    turn = t * rates[LOAD_OMEGA][k] + rates[LOAD_PHASE][k]
    return rates[VARIATION][k] * math.sin(phase) + law.variation * math.cos(phase) * turn


# Motion between events.


@compiled
def write_point(scene, state, n, rates, work, out):
    """Write the derivatives at grid point n, where the motion is in a `ModeState`."""
    plant, law, _, _, dt = scene
    mode, xi, v_r, x_0 = state
    (x, v, anchor), sources = work.deviations, work.sources
    forces, x_r = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin) + xi
    c, w, f, pull = equation_of(forces)
    t, varies = n * dt, load_varies(law)
    load = load_ramp_at(law, t).load
    if varies:
        load *= 1.0 + law.variation * math.sin(phase_at(law.omega / math.tau, law.phase, t))
    for k in range(len(x)):
        change = load_deviation(law, t, rates, k) if varies else 0.0
        F_f = sources.F[k] * load + forces.F * change
        F_f += forces.k_t * (x[k] - anchor[k])
        a = pull * anchor[k] + sources.g[k] - sources.f[k] * load - f * change
        a -= w * x[k] + c * v[k] + sources.w[k] * x_r + sources.c[k] * v_r
        if forces.k_t > 0.0:
            F_f += rates[TANGENTIAL][k] * (x_r - x_0)
        elif mode.direction == AT_REST:
            F_f = -(rates[SPRING][k] * x_r + plant.k_x * x[k])
            if rates[MASS][k] != 0.0:
                F_f -= rates[MASS][k] * base_acceleration_at(scene, n)
        rests = mode.direction == AT_REST
        out.x_r[k][n], out.v_r[k][n] = x[k], 0.0 if rests else v[k]
        out.x_dd[k][n], out.F_f[k][n] = 0.0 if rests else a, F_f


@compiled
def base_acceleration_at(scene, n):
    """Return ü at grid point n [m/s²]."""
    _, _, waves, u_dd, dt = scene
    total, values = u_dd[n], waves.values
    for i in range(waves.base):
        row = WAVE_COLUMNS * i
        phase = phase_at(values[row + FREQUENCY], values[row + PHASE], n * dt)
        total += values[row + A] * math.sin(phase)
    return total


class MotionResponse(NamedTuple):
    """Response from rest of the oscillator to its own motion as force per mass.

    It is minus the derivative of the motion with respect to w and c.

    Attributes
    ----------
    x_w, v_w : float
        Displacement and velocity under the displacement as force.
    x_c, v_c : float
        Displacement and velocity under the velocity as force.
    """

    x_w: Any
    v_w: Any
    x_c: Any
    v_c: Any


@inlined
def response_to_motion(c, w, constants, start, force):
    """Return the `MotionResponse` to a motion under a linear force.

    Parameters
    ----------
    c, w, constants
        Equation, and what `flow_and_slope` returns for the length of the motion.
    start : (float, float, float)
        Displacement from the origin of the mode, displacement, and velocity at the start.
    force : (float, float)
        Force per mass at the start, and its derivative.
    """
    y, _, Y, _, z, z_d, Z, ZZ = constants
    xi, x_r, v_r = start
    p, r = force[0] - w * xi, force[1]
    x_c = -(v_r * z_d + p * z + r * Z)
    v_c = v_r * (y + c * z_d + w * z) - p * z_d - r * z
    return MotionResponse(x_r * Y - (v_r * z + p * Z + r * ZZ), x_r * y + x_c, x_c, v_c)


@inlined
def response_to_swing(c, w, wave, push):
    """Return the `MotionResponse` to the part of a motion that a wave drives from rest.

    Parameters
    ----------
    c, w, wave
        Equation, and the `WaveResponse`.
    push : complex
        A exp(i theta) of the wave, with which -A sin(omega s + theta) is the force per mass.
    """
    slope = -(wave.x + c * wave.v_w + w * wave.x_w)
    x_w, v_w, v_c = push * wave.x_w, push * wave.v_w, push * slope
    return MotionResponse(x_w.imag, v_w.imag, v_w.imag, v_c.imag)


@inlined
def phasor(amplitude, phase):
    """Return a complex number by amplitude and phase."""
    return complex(amplitude * math.cos(phase), amplitude * math.sin(phase))


@compiled
def static_force(forces, origin):
    """Return the force of springs and stops per mass at the origin of a mode [m/s²]."""
    m, k_x, _ = forces.plant
    return (forces.offset - k_x * origin - forces.k_t * (origin - forces.x_0)) / m


@compiled
def move_whole_steps(scene, state, steps, motion, rates, work, out):
    """Propagate deviations over grid steps of a motion in one mode, and write them.

    `steps` are the first step and the one to stop before. The normal force is constant, so that
    one response serves all steps.
    """
    plant, law, waves, u_dd, dt = scene
    mode, _, _, x_0 = state
    (x, v, anchor), sources, responses = work
    forces, origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    c, w, f, pull = equation_of(forces)
    first, until = steps
    g, (x_r, v_r) = static_force(forces, origin) - f, motion
    constants = flow_and_slope(c, w, dt)
    for n in range(first, until):
        start = x_r[n] - origin, x_r[n], v_r[n]
        force = g - u_dd[n], (u_dd[n] - u_dd[n + 1]) / dt
        x_w, v_w, x_c, v_c = response_to_motion(c, w, constants, start, force)
        responses.x_w[n], responses.v_w[n] = x_w, v_w
        responses.x_c[n], responses.v_c[n] = x_c, v_c
    for i in range(waves.base):
        row, values = WAVE_COLUMNS * i, waves.values
        wave = wave_response(c, w, values[row + OMEGA], dt)
        for n in range(first, until):
            phase = phase_at(values[row + FREQUENCY], values[row + PHASE], n * dt)
            push = phasor(values[row + A], phase)
            x_w, v_w, x_c, v_c = response_to_swing(c, w, wave, push)
            responses.x_w[n] += x_w
            responses.v_w[n] += v_w
            responses.x_c[n] += x_c
            responses.v_c[n] += v_c
    y, y_d, Y, _, _, _, _, _ = constants
    for k in range(len(x)):
        x_out, v_out, a_out, F_out = out.x_r[k], out.v_r[k], out.x_dd[k], out.F_f[k]
        x_k, v_k, w_k, c_k, F_k = x[k], v[k], sources.w[k], sources.c[k], sources.F[k]
        constant = pull * anchor[k] + sources.g[k] - sources.f[k]
        for n in range(first, until):
            push = constant - w * x_k
            x_k, v_k = (
                x_k + v_k * y + push * Y - w_k * responses.x_w[n] - c_k * responses.x_c[n],
                v_k * y_d + push * y - w_k * responses.v_w[n] - c_k * responses.v_c[n],
            )
            x_out[n + 1], v_out[n + 1], F_out[n + 1] = x_k, v_k, F_k
            a_out[n + 1] = constant - w * x_k - c * v_k - w_k * x_r[n + 1] - c_k * v_r[n + 1]
        if forces.k_t > 0.0:
            for n in range(first + 1, until + 1):
                F_out[n] += forces.k_t * (x_out[n] - anchor[k])
                F_out[n] += rates[TANGENTIAL][k] * (x_r[n] - x_0)
        x[k], v[k] = x_k, v_k


@compiled
def move_in_segment(scene, state, times, rates, work):
    """Propagate deviations in one mode, within a step.

    `times` are the step, and begin and end within it [s].
    """
    plant, law, waves, u_dd, dt = scene
    mode, xi, v_r, x_0 = state
    (x, v, anchor), sources = work.deviations, work.sources
    if mode.direction == AT_REST:
        for k in range(len(x)):
            v[k] = 0.0
        return
    n, s, end = times
    t, length, slope = n * dt + s, end - s, (u_dd[n + 1] - u_dd[n]) / dt
    forces, origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    c, w, f, pull = equation_of(forces)
    ramp, constants = load_ramp_at(law, t), flow_and_slope(c, w, length)
    y, y_d, Y, YY, _, _, _, _ = constants
    g = static_force(forces, origin) - f * ramp.load - (u_dd[n] + slope * s)
    start, force = (xi, origin + xi, v_r), (g, -slope - f * ramp.rate)
    x_w, v_w, x_c, v_c = response_to_motion(c, w, constants, start, force)
    # Response to the normal force, and to sine, cosine and time times cosine of its phase.
    x_load, v_load = ramp.load * Y + ramp.rate * YY, ramp.load * y + ramp.rate * Y
    x_sine = v_sine = x_cosine = v_cosine = x_turn = v_turn = 0.0
    for i in range(waves.size):
        row, values = WAVE_COLUMNS * i, waves.values
        wave = wave_response(c, w, values[row + OMEGA], length)
        turn = phasor(1.0, phase_at(values[row + FREQUENCY], values[row + PHASE], t))
        swing = values[row + A] if i < waves.base else f * law.variation
        swung = response_to_swing(c, w, wave, swing * turn)
        x_w, v_w, x_c, v_c = x_w + swung.x_w, v_w + swung.v_w, x_c + swung.x_c, v_c + swung.v_c
        if i == waves.base:
            x_swing, v_swing = turn * wave.x, turn * wave.v
            x_sine, v_sine, x_cosine, v_cosine = (
                x_swing.imag, v_swing.imag, x_swing.real, v_swing.real
            )  # fmt: skip
            x_omega, v_omega = turn * wave.x_omega, turn * wave.v_omega
            x_turn, v_turn = x_omega.imag + t * x_cosine, v_omega.imag + t * v_cosine
    x_load, v_load = x_load + law.variation * x_sine, v_load + law.variation * v_sine
    for k in range(len(x)):
        w_k, c_k, f_k = sources.w[k], sources.c[k], sources.f[k]
        push = pull * anchor[k] + sources.g[k] - w * x[k]
        amplitude, phase = f * rates[VARIATION][k], f * law.variation * rates[LOAD_PHASE][k]
        omega = f * law.variation * rates[LOAD_OMEGA][k]
        x_k = x[k] + v[k] * y + push * Y - w_k * x_w - c_k * x_c - f_k * x_load
        x_k -= amplitude * x_sine + phase * x_cosine + omega * x_turn
        v_k = v[k] * y_d + push * y - w_k * v_w - c_k * v_c - f_k * v_load
        v_k -= amplitude * v_sine + phase * v_cosine + omega * v_turn
        x[k], v[k] = x_k, v_k


# Events.


@compiled
def pass_event_of_scene(solution, modes, i, rates, deviations):
    """Apply the event that ends segment i to deviations of state and scene."""
    (plant, law, _, _, dt), rows = solution
    (x, v, x_0), (before, after) = deviations, modes
    arrives, v_r = rows.d[i + 1] == ARRIVAL, rows.v_r[i + 1]
    side = after.origin if arrives else 0
    # Displacements at a stop count from its position.
    for k in range(len(x)):
        x[k] -= limit_deviation(side, rates, k)
    pass_event(solution, before, after, i, deviations)
    for k in range(len(x)):
        x[k] += limit_deviation(side, rates, k)
        if arrives and law.k_s[0] == 0.0 and after.entry != CHATTERING:
            v[k] -= rates[RESTITUTION][k] * v_r
    t = rows.n[i + 1] * dt + rows.s[i + 1]
    if not arrives and is_stop_or_break_away(law, before, after) and before.contact == HOLD:
        now = forcing_at(solution, i + 1)
        away, approach = break_away_rates(plant, law, after.contact, now)
        factor = break_away_factor(1, 1.0, away, approach)
        state = ModeState(before, rows.x_r[i + 1], 0.0, 0.0)
        for k in range(len(x)):
            v[k] += factor * excess_deviation(plant, law, state, after.contact, now, rates, k)
            v[k] += factor * side_of(law, after.contact).F_fs * load_deviation(law, t, rates, k)
    if is_anchored(law, before, after):
        now = forcing_at(solution, i + 2 if arrives else i + 1)
        F = mode_forces(plant, law, before, 0.0).F
        for k in range(len(x)):
            load = load_deviation(law, t, rates, k)
            F_k = slip_force_deviation(before, rates, k) - F * rates[TANGENTIAL][k] / law.k_t
            x_0[k] += limit_deviation(side, rates, k) - (F_k * now.load + F * load) / law.k_t
            if before.contact == FREE and load != 0.0:
                x_0[k] -= v_r * load / now.load_d


@compiled
def excess_deviation(plant, law, state, d, now, rates, k):
    """Return the deviation of d F_L + F_fs N at a state [N], at the same normal force.

    It is that of the excess over the static limit of a mass that breaks away in direction d.
    """
    mode, xi, _, _ = state
    k_s, offset = stop_deviation(law, mode, rates, k)
    F_L = rates[MASS][k] * now.u_dd + rates[SPRING][k] * (origin_of(law, mode.origin) + xi)
    F_L += k_s * xi - offset
    F_L -= mode_forces(plant, law, mode, 0.0).k_s * limit_deviation(mode.origin, rates, k)
    return d * F_L + rates[side_row(d) + STATIC][k] * now.load
