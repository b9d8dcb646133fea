"""Variational equation: the derivative of a motion with respect to its start, in closed form.

Problem
    Newton's method on a return map, Floquet multipliers, continuation and Lyapunov exponents
    need the monodromy matrix: the derivative of the state after some time with respect to the
    state before. Differences of two marches lose half of the digits, and all of them where an
    event lies between the two.

Method
    - Within a segment the equation of motion is linear. A deviation obeys the same equation
      without its forcing, and `flow` propagates it.
    - At an event the motion crosses a guard h(t, z) = 0 and is reset to R(t, z). A deviation
      reaches the guard earlier or later, and moves meanwhile under the other field: it is
      multiplied by the saltation matrix

          S = DR + (F⁺ - DR F⁻ - R_t) ∇h / (∇h·F⁻ + h_t)

      with the fields F⁻ before and F⁺ after the event. At a fixed time S = DR.

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

    with r = -e at a rigid stop, and 1 at a bumper, where the damper sets in. Everywhere else
    the force is continuous, and the guard does not matter: where an elastic contact yields or
    holds again, at each stage of a bumper, where it is released, where the normal force
    vanishes, and in a damper at v_r = 0. There only x_0 is reset, the x_r at which an elastic
    contact carries no force: it follows x_r where the contact yields or is separated.

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
from drysim.core.forcing import base_motion, relative_normal_force, set_phases
from drysim.core.modes import (
    ARRIVAL,
    AT_REST,
    CHATTERING,
    FREE,
    HOLD,
    ModeState,
    bumper_force,
    contact_force,
    coulomb_limits,
    decode_mode,
    load_at,
    load_ramp_at,
    mode_forces,
    origin_of,
    side_of,
)
from drysim.core.oscillator import flow
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


# Coulomb friction under waves: the events are the solution.


@compiled
def event_monodromy(scene, length, rate, d, first, events):
    """Return the monodromy matrix of a motion with Coulomb friction, from its events.

    Parameters
    ----------
    scene : SineScene
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
        arrives = segments.d[i + 1] == ARRIVAL
        mode = decode_mode(segments.d[i + 2 if arrives else i + 1])
        rigid = law.k_t == 0.0 and before.contact != FREE and mode.contact != FREE
        if arrives:
            meet_stop(solution, before, mode, i, deviations)
        elif rigid and before.contact != mode.contact:
            stop_or_break_away(solution, before, mode, i, deviations)
        if law.k_t > 0.0 and before.contact != HOLD and mode.contact == HOLD:
            reset_anchor(deviations, arrives)
    if law.k_t > 0.0 and mode.contact != HOLD:
        reset_anchor(deviations, False)


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
    d = after.contact
    side, k_s = side_of(law, d), mode_forces(plant, law, before, 0.0).k_s
    away = d * (side.F_fs - side.F_fk) * now.load / plant.m
    approach = side.F_fs * now.load_d + d * plant.m * now.u_ddd
    factor = break_away_factor(d, plant.k_x + k_s, away, approach)
    for k in range(len(deviations.v_r)):
        deviations.v_r[k] = factor * deviations.x_r[k]


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
