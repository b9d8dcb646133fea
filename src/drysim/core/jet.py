"""The motion under a dynamic law as Taylor series about one instant.

Every term follows from those before it by sums of products, so a series costs little, tells
its own radius, and is the motion between the instants as well.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.plant import BRISTLE, STRIBECK
from drysim.core.waves import FREQUENCY, OMEGA, PHASE, STRIDE, A

ORDER = 20
"""Terms of a series at most: near the least work for errors of rounding size."""


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
        Work: exponent of the Stribeck curve, its excess over F_fk, and |v| z over the curve.
        The excess is held apart: far above v_s it is below the rounding of the curve.
    scale : array of float
        Its first value is the greatest speed so far [m/s], the measure of what is small.
    """

    x: Any
    v: Any
    z: Any
    u: Any
    F: Any
    s: Any
    g: Any
    p: Any
    scale: Any


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


@inlined
def inner_sums(jet, n):
    """Give the inner part of term n of the products v v, v z, s' g and g p.

    One loop for all: the sums do not wait for each other.
    """
    vv, vz, sg, gp = 0.0, 0.0, 0.0, 0.0
    for k in range(1, n):
        vv += jet.v[k] * jet.v[n - k]
        vz += jet.v[k] * jet.z[n - k]
        sg += k * jet.s[k] * jet.g[n - k]
        gp += jet.g[k] * jet.p[n - k]
    return vv, vz, sg, gp


@inlined
def excess_term(law, jet, d, n, vv, sg):
    """Set term n of the Stribeck curve's excess over F_fk [N]: its rate is -s' times it."""
    if law.exponent == 1:
        jet.s[n] = d * jet.v[n] / law.v_s
    else:
        square = vv + (2.0 if n > 0 else 1.0) * jet.v[0] * jet.v[n]
        jet.s[n] = square / (law.v_s * law.v_s)
    if n == 0:
        jet.g[0] = (law.F_fs - law.F_fk) * math.exp(-jet.s[0])
    else:
        jet.g[n] = -(sg + n * jet.s[n] * jet.g[0]) / n


@inlined
def force_term(law, jet, d, n):
    """Set term n of the friction force [N] and, for bristles, term n + 1 of z."""
    vv, vz, sg, gp = inner_sums(jet, n)
    if law.F_fs != law.F_fk:
        excess_term(law, jet, d, n, vv, sg)
    if law.kind == STRIBECK:
        jet.F[n] = d * ((law.F_fk if n == 0 else 0.0) + jet.g[n])
        return
    product = vz + jet.v[0] * jet.z[n]
    if n > 0:
        product += jet.v[n] * jet.z[0]
        gp += jet.g[n] * jet.p[0]
    jet.p[n] = (d * product - gp) / (law.F_fk + jet.g[0])
    z_d = jet.v[n] - law.sigma_0 * jet.p[n]
    jet.z[n + 1] = z_d / (n + 1)
    jet.F[n] = law.sigma_0 * jet.z[n] + law.sigma_1 * z_d + law.sigma_2 * jet.v[n]


@compiled
def grow(plant, law, jet, d, x, v, z, poised, h, v_least, z_least):
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
        Whether the mass breaks away just now: its relative acceleration is exactly zero.
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
    jet.x[0] = x
    jet.v[0] = v
    jet.z[0] = z
    power = 1.0
    small = 0
    for n in range(ORDER):
        force_term(law, jet, d, n)
        jet.x[n + 1] = jet.v[n] / (n + 1)
        a = -(jet.u[n] + (k_x * jet.x[n] + b * jet.v[n] + jet.F[n]) / m) / (n + 1)
        jet.v[n + 1] = 0.0 if poised and n == 0 else a
        power *= h
        tiny = abs(jet.v[n + 1]) * power <= v_least
        if law.kind == BRISTLE:
            tiny = tiny and abs(jet.z[n + 1]) * power <= z_least
        small = small + 1 if tiny else 0
        # Odd and even terms may vanish in turn, and ü has two terms that the state has not.
        if small == 3:
            return n + 1, h
    return ORDER, min(h, reach(law, jet, v_least, z_least))


@compiled
def reach(law, jet, v_least, z_least):
    """Give the length [s] at which the last terms of the series are what may be neglected."""
    h = math.inf
    for n in range(ORDER - 1, ORDER + 1):
        size = abs(jet.v[n]) / v_least
        if law.kind == BRISTLE:
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
