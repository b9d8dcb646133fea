"""The motion under a dynamic law as Taylor series about one instant.

Every term follows from those before it by sums of products, so a series costs little, tells
its own radius, and is the motion between the instants as well.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.dynamic_laws.dynamic import flat_from
from drysim.core.dynamic_laws.terms import excess_start, force_term
from drysim.core.plant import STRIBECK
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A

ORDER = 20
"""Terms of a series at most: near the least work for errors of rounding size."""

BEYOND = 1.05
"""A series that begins nearer than this to the edge of the flat part foresees the rise."""


class Jet(NamedTuple):
    """Taylor coefficients about one instant as arrays (or lists), shape (ORDER + 2,).

    Attributes
    ----------
    x, v, z : array of float
        Of relative displacement [m], velocity [m/s] and deflection [m], each per s^n.
    u : array of float
        Of ü.
    F : array of float
        Of the friction force [N].
    s, g, p : array of float
        Work: exponent of the Stribeck curve, its terms n times each; its excess over F_fk; and
        |v| z over the curve, or under `LEUVEN` the deflecting force over the curve.
        The excess is held apart: far above v_s it is below the rounding of the curve.
    w : array of float
        Rate of the bristles' travel [m/s]; `LEUVEN` alone.
    square, share : array of float
        Powers of p; `LEUVEN` alone.
    scale : array of float
        Its first value is the greatest speed so far [m/s], the measure of what is small.
    slope : array of float
        Rise of the deflection per travel: slope[0] + slope[1] z; `LEUVEN` alone.
    turned : array of float
        Deflections at which the bristles turned and which they remember [m]; `LEUVEN` alone.
    branch : array of int
        How many those are, the direction of travel, and whether z is at its limit just now.
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
    turned: Any
    branch: Any


@compiled
def drive(jet, waves, u_0, slope, t):
    """Set the series of ü about time t [s]: u_0 + slope s and waves."""
    for n in range(ORDER + 1):
        jet.u[n] = 0.0
    jet.u[0] = u_0
    jet.u[1] = slope
    for i in range(waves.base):
        at = STRIDE * i
        amplitude, omega = waves.values[at + A], waves.values[at + OMEGA]
        turns = (waves.values[at + FREQUENCY] * t) % 1.0
        angle = 2.0 * math.pi * turns + waves.values[at + PHASE]
        sine = amplitude * math.sin(angle)
        cosine = amplitude * math.cos(angle)
        for n in range(ORDER + 1):
            jet.u[n] += sine
            sine, cosine = cosine * omega / (n + 1), -sine * omega / (n + 1)


@compiled
def grow(plant, law, jet, d, x, v, z, poised, slow, h, v_least, z_least):
    """Set the series of the motion from one state on, as far as they are needed.

    Parameters
    ----------
    plant, law : Plant, Dynamic
    jet : Jet
        Driven; the rest is written.
    d : int
        Direction of motion.
    x, v, z : float
        The state [m, m/s, m].
    poised : bool
        Whether the mass rests or breaks away just now: its relative acceleration is exactly
        zero.
    slow : bool
        Whether the mass is too slow for friction to have fallen.
    h : float
        Length that is wished for [s].
    v_least, z_least : float
        What may be neglected [m/s, m].

    Returns
    -------
    n, h : int, float
        The last term, and the length for which the series holds [s], at most that asked for.
    """
    m, k_x, b = plant
    per_m = 1.0 / m
    jet.x[0] = x
    jet.v[0] = v
    jet.z[0] = z
    falls = start_curve(law, jet, d, v, slow)
    per_curve = 1.0 / (law.F_fk + jet.g[0])
    power = 1.0
    small = 0
    for n in range(ORDER):
        force_term(law, jet, d, n, falls, per_curve)
        per_n = 1.0 / (n + 1)
        jet.x[n + 1] = jet.v[n] * per_n
        a = -(jet.u[n] + (k_x * jet.x[n] + b * jet.v[n] + jet.F[n]) * per_m) * per_n
        jet.v[n + 1] = 0.0 if poised and n == 0 else a
        power *= h
        tiny = abs(jet.v[n + 1]) * power <= v_least
        if law.kind != STRIBECK:
            tiny = tiny and abs(jet.z[n + 1]) * power <= z_least
        small = small + 1 if tiny else 0
        # Odd and even terms may vanish in turn, and ü has two terms that the state has not.
        if small == 3:
            return n + 1, h
    return ORDER, min(h, reach(law, jet, v_least, z_least))


@inlined
def start_curve(law, jet, d, v, slow):
    """Begin the series of the Stribeck curve; tells whether it changes with the speed here."""
    falls = not slow and law.F_fs != law.F_fk and d * v <= BEYOND * flat_from(law)
    if falls:
        excess_start(law, jet, d, v)
    else:
        for n in range(ORDER + 1):
            jet.g[n] = 0.0
        if slow:
            jet.g[0] = law.F_fs - law.F_fk
    return falls


@compiled
def reach(law, jet, v_least, z_least):
    """Give the length [s] at which the last terms of the series are what may be neglected."""
    h = math.inf
    for n in range(ORDER - 1, ORDER + 1):
        size = abs(jet.v[n]) / v_least
        if law.kind != STRIBECK:
            size = max(size, abs(jet.z[n]) / z_least)
        if size > 0.0:
            h = min(h, size ** (-1.0 / n))
    return h


@compiled
def value(series, n, s):
    """Give the value of a series up to term n at s."""
    total = series[n]
    for k in range(n - 1, -1, -1):
        total = total * s + series[k]
    return total


@compiled
def state_at(jet, n, s):
    """Give x, v and z [m, m/s, m] at s from terms up to n: three at the price of one."""
    x, v, z = jet.x[n], jet.v[n], jet.z[n]
    for k in range(n - 1, -1, -1):
        x = x * s + jet.x[k]
        v = v * s + jet.v[k]
        z = z * s + jet.z[k]
    return x, v, z
