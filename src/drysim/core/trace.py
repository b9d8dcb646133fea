"""The motion under a dynamic law, series after series, with every zero of the velocity."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled
from drysim.core.dynamic import sliding_limit
from drysim.core.events import REVERSAL, ROUNDING, SLIP, STICK, limit_force, note, sign
from drysim.core.jet import ORDER, drive, grow, value
from drysim.core.leave import leave_stick, parabola
from drysim.core.plant import BRISTLE, STRIBECK, Law
from drysim.core.stop import NEVER, RESOLUTION
from drysim.core.waves import OMEGA, STRIDE, anchor

ENOUGH = 3
"""Events and steps that one step may add to their logs, and one to spare."""


FLAT = 37.0
"""Exponent from which on the Stribeck curve is flat to double precision."""

BEYOND = 1.05
"""A series that begins nearer than this to the edge of the flat part foresees the rise."""


CURVE_SLACK = 10.0
"""Tolerances of F_fs that the curve at the end of a series may be off; roundings add up."""


class Steps(NamedTuple):
    """Where each series begins: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int
        Sample at or before the beginning; 0 under sines.
    s : array of float
        Time since that sample [s].
    x_r, v_r, z : array of float
        The state there [m, m/s, m].
    d : array of int
        Direction of motion, 0 where stuck; 2 and -2 where the mass breaks away just then.
    """

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    z: Any
    d: Any


@compiled
def first_zero(series, n, d, h):
    """Give the first time in (0, h] at which a velocity in direction d is zero, or infinity.

    Steps that a bound on the curvature proves safe lead to the first zero from below, so none
    is missed; a zero at the beginning itself is divided out.
    """
    first = 0
    while first <= n and series[first] == 0.0:
        first += 1
    if first >= n:
        return NEVER
    rest = 0.0
    bend = 0.0
    power = 1.0
    for k in range(1, n - first + 1):
        size = abs(series[first + k])
        rest += size * power * h
        if k > 1:
            bend += k * (k - 1) * size * power / h
        power *= h
    if abs(series[first]) > rest:
        return NEVER
    s = 0.0
    while True:
        v = 0.0
        a = 0.0
        for k in range(n, first - 1, -1):
            a = a * s + v
            v = v * s + d * series[k]
        if v <= 0.0:
            return s
        step = parabola(v, a, bend)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step


@compiled
def foreseen(law, jet, n, d, h):
    """Give the length [s], at most h, over which a series foresees the Stribeck curve.

    Where the speed is far above v_s the rise of the curve lies beyond the last term, so a
    series ends where the rise begins to count.
    """
    edge = (FLAT if law.exponent == 1 else math.sqrt(FLAT)) * law.v_s
    v = jet.v[0]
    if law.F_fs == law.F_fk or d * v <= BEYOND * edge:
        return h
    jet.v[0] = v - d * edge
    arrives = first_zero(jet.v, n, d, h)
    jet.v[0] = v
    return min(arrives, h)


@compiled
def followed(law, jet, n, h):
    """Give the length [s], at most h, at whose end the series still is the Stribeck curve.

    Near the edge of the flat part the terms of the rise grow for long before they fall, so
    small terms alone do not tell that a series is complete.
    """
    if law.F_fs == law.F_fk:
        return h
    slack = CURVE_SLACK * law.tolerance * law.F_fs
    while (
        abs(law.F_fk + value(jet.g, n - 1, h) - sliding_limit(law, value(jet.v, n, h))) > slack
        and h > 0.0
    ):
        h *= 0.5
    return h


@compiled
def heading(jet, waves, u_0, slope, t, F):
    """Give the direction in which a mass at rest under a friction force per mass F starts.

    0 where no term of ü moves it.
    """
    drive(jet, waves, u_0, slope, t)
    if jet.u[0] + F != 0.0:
        return -sign(jet.u[0] + F)
    for n in range(1, ORDER + 1):
        if jet.u[n] != 0.0:
            return -sign(jet.u[n])
    return 0


@compiled
def first_heading(plant, law, waves, jet, u_0, slope, t, x_r, v_r, z):
    """Give the direction of motion at the start, 0 for stuck or without any cause to move."""
    if v_r != 0.0:
        return sign(v_r)
    if law.kind == STRIBECK:
        drive(jet, waves, u_0, slope, t)
        F_L = limit_force(plant, x_r, jet.u[0])
        hold = law.F_fs + ROUNDING * (law.F_fs + abs(plant.k_x * x_r))
        return 0 if abs(F_L) <= hold else -sign(F_L)
    return heading(jet, waves, u_0, slope, t, (plant.k_x * x_r + law.sigma_0 * z) / plant.m)


@compiled
def trace(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, z, d, jet, steps, at, log, count,
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
        The state there, and the direction as in `Steps`.
    jet : Jet
        To work in.
    steps, at : Steps, int
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
    z_least = law.tolerance * law.F_fs / law.sigma_0 if law.kind == BRISTLE else 0.0
    wish = NEVER
    while n <= end and at + ENOUGH < capacity and count + ENOUGH < capacity:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        steps.n[at] = n
        steps.s[at] = s
        steps.x_r[at] = x_r
        steps.v_r[at] = v_r
        steps.z[at] = z
        steps.d[at] = d
        at += 1
        left = length - s
        if d == 0 and law.kind == STRIBECK:
            calm = min(left, calm_length(waves))
            stay, side = break_away(plant, law, waves, x_r, u_0, slope, t, calm)
            s = length if min(stay, calm) >= left else s + min(stay, calm)
            if stay != NEVER:
                d = 2 * side
                F_L = -side * law.F_fs
                count = note(log, count, n, s, side * SLIP, x_r, F_L)
        else:
            drive(jet, waves, u_0, slope, t)
            poised = abs(d) == 2
            way = 1 if d >= 0 else -1
            v_least = law.tolerance * jet.scale[0]
            last, step = grow(
                plant, law, jet, way, x_r, v_r, z, poised, min(left, wish), v_least, z_least
            )
            step = foreseen(law, jet, last, way, step)
            stop = first_zero(jet.v, last, way, step)
            seen = followed(law, jet, last, min(stop, step))
            if seen < stop:
                step = min(seen, step)
                stop = NEVER
            if stop == NEVER and step <= RESOLUTION * (t + step):
                return n, s, x_r, v_r, z, d, at, -1
            wish = 4.0 * step if step < left else NEVER
            step = min(stop, step)
            s = length if step == left else min(s + step, length)
            x_r = value(jet.x, last, step)
            v_r = value(jet.v, last, step)
            if law.kind == BRISTLE:
                z = value(jet.z, last, step)
            jet.scale[0] = max(jet.scale[0], abs(v_r))
            d = way
            if stop != NEVER:
                v_r = 0.0
                F_L = limit_force(plant, x_r, value(jet.u, ORDER, step))
                d = first_heading(
                    plant, law, waves, jet, u_dd[n] + slope * s, slope, n * dt + s, x_r, v_r, z
                )
                count = note(log, count, n, s, REVERSAL * d if d != 0 else STICK, x_r, F_L)
        if s >= length:
            n += 1
            s = 0.0
    return n, s, x_r, v_r, z, d, at, count


@compiled
def calm_length(waves):
    """Give the longest step [s] of a stuck mass, within which a series knows the waves."""
    fastest = 0.0
    for i in range(waves.size):
        fastest = max(fastest, waves.values[STRIDE * i + OMEGA])
    return 1.0 / fastest if fastest > 0.0 else NEVER


@compiled
def break_away(plant, law, waves, x_r, u_0, slope, t, h):
    """Give when a stuck mass breaks away within h [s], or infinity, and in which direction."""
    limits = Law(law.F_fs, law.F_fs, 0.0, 0.0, 0.0)
    anchor(waves, plant, limits, t, 0)
    up = leave_stick(plant, limits, waves, x_r, u_0, slope, 1, h)
    down = leave_stick(plant, limits, waves, x_r, u_0, slope, -1, min(up, h))
    if down < up:
        return down, 1
    return up, -1
