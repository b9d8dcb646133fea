"""Exact integrals over the whole steps of a piece of a march, by forms, many at a time.

A piece is short enough to stay in the processor's cache.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from drysim.core.compiled import compiled

PIECE = 1024
"""Samples of a piece, a power of two and a multiple of the stretches of a march."""


class Piece(NamedTuple):
    """A piece of a march, and scratch for its sums; arrays.

    Attributes
    ----------
    x_r, v_r, d : array, shape (PIECE + 1,)
        State and direction of sliding at every sample.
    way, slip, stuck : array, shape (PIECE,)
        Of every step: direction of sliding, and 1 where the mass slides, or sticks, all
        through it within the window; else 0.
    part : array, shape (PIECE,)
        What each step adds to an integral.
    x_ahead, v_ahead : array, shape (STRETCH,)
        Scratch of the march.
    """

    x_r: Any
    v_r: Any
    d: Any
    way: Any
    slip: Any
    stuck: Any
    part: Any
    x_ahead: Any
    v_ahead: Any


class Forms(NamedTuple):
    """Forms of whole steps in their `step_rows`: arrays of the terms that are not zero.

    `x2` and `x_dd2` have shape (10,), `v2` and `power` (6,), `rub` (3,).
    """

    x2: Any
    v2: Any
    x_dd2: Any
    power: Any
    rub: Any


@compiled
def mark(piece, log, count, begin, last):
    """Mark the whole steps from sample `begin` of a piece to sample `last`."""
    d, way, slip, stuck = piece.d, piece.way, piece.slip, piece.stuck
    for i in range(last):
        way[i] = d[i]
    for i in range(last):
        inside = 1.0 if begin <= i else 0.0
        slip[i] = inside * way[i] * way[i]
        stuck[i] = inside - inside * way[i] * way[i]
    for k in range(count):
        slip[log.n[k]] = 0.0
        stuck[log.n[k]] = 0.0


@compiled
def total(part, last):
    """Add up the first numbers of a piece in pairs, which spoils it: fast, and precise."""
    for i in range(PIECE - last):
        part[last + i] = 0.0
    half = PIECE // 2
    while half > 0:
        for i in range(half):
            part[i] += part[half + i]
        half //= 2
    return part[0]


@compiled
def displacement_squared(steps, form, u_dd, piece, last):
    """Give the integral of x_r² over the whole steps of a piece."""
    w, f, dt = steps.w, steps.f, steps.dt
    xx, xv, xp, xq, vv, vp, vq, pp, pq, qq = (
        form[0], form[1], form[2], form[3], form[4], form[5], form[6], form[7], form[8], form[9]
    )  # fmt: skip
    x_r, v_r, way, slip, stuck, part = (
        piece.x_r, piece.v_r, piece.way, piece.slip, piece.stuck, piece.part
    )  # fmt: skip
    for i in range(last):
        x, v = x_r[i], v_r[i]
        p, q = u_dd[i] + (w * x + f * way[i]), u_dd[i + 1] - u_dd[i]
        slid = (
            x * (xx * x + xv * v + xp * p + xq * q) + v * (vv * v + vp * p + vq * q)
            + p * (pp * p + pq * q) + qq * q * q
        )  # fmt: skip
        part[i] = slip[i] * slid + stuck[i] * (dt * x * x)
    return total(part, last)


@compiled
def speed_squared(steps, form, u_dd, piece, last):
    """Give the integral of v_r² over the whole steps of a piece."""
    w, f = steps.w, steps.f
    vv, vp, vq, pp, pq, qq = form[0], form[1], form[2], form[3], form[4], form[5]
    x_r, v_r, way, slip, part = piece.x_r, piece.v_r, piece.way, piece.slip, piece.part
    for i in range(last):
        v = v_r[i]
        p, q = u_dd[i] + (w * x_r[i] + f * way[i]), u_dd[i + 1] - u_dd[i]
        slid = v * (vv * v + vp * p + vq * q) + p * (pp * p + pq * q) + qq * q * q
        part[i] = slip[i] * slid
    return total(part, last)


@compiled
def acceleration_squared(steps, form, u_dd, piece, last):
    """Give the integral of x_dd² over the whole steps of a piece: of ü² where it sticks."""
    c, w, f, third = steps.c, steps.w, steps.f, steps.dt / 3.0
    vv, vq, vu, va, qq, qu, qa, uu, ua, aa = (
        form[0], form[1], form[2], form[3], form[4], form[5], form[6], form[7], form[8], form[9]
    )  # fmt: skip
    x_r, v_r, way, slip, stuck, part = (
        piece.x_r, piece.v_r, piece.way, piece.slip, piece.stuck, piece.part
    )  # fmt: skip
    for i in range(last):
        v, u, u_1 = v_r[i], u_dd[i], u_dd[i + 1]
        q, a = u_1 - u, c * v + (w * x_r[i] + f * way[i])
        slid = (
            v * (vv * v + vq * q + vu * u + va * a) + q * (qq * q + qu * u + qa * a)
            + u * (uu * u + ua * a) + aa * a * a
        )  # fmt: skip
        part[i] = slip[i] * slid + stuck[i] * (third * (u * u + u * u_1 + u_1 * u_1))
    return total(part, last)


@compiled
def power_given(steps, form, u_dd, piece, last):
    """Give the integral of ü v_r over the whole steps of a piece."""
    w, f = steps.w, steps.f
    qv, qp, qq, uv, up, uq = form[0], form[1], form[2], form[3], form[4], form[5]
    x_r, v_r, way, slip, part = piece.x_r, piece.v_r, piece.way, piece.slip, piece.part
    for i in range(last):
        v, u = v_r[i], u_dd[i]
        p, q = u + (w * x_r[i] + f * way[i]), u_dd[i + 1] - u
        part[i] = slip[i] * (q * (qv * v + qp * p + qq * q) + u * (uv * v + up * p + uq * q))
    return total(part, last)


@compiled
def way_slid(steps, form, u_dd, piece, last):
    """Give the integral of |v_r| over the whole steps of a piece."""
    w, f = steps.w, steps.f
    v_1, p_1, q_1 = form[0], form[1], form[2]
    x_r, v_r, way, slip, part = piece.x_r, piece.v_r, piece.way, piece.slip, piece.part
    for i in range(last):
        p, q = u_dd[i] + (w * x_r[i] + f * way[i]), u_dd[i + 1] - u_dd[i]
        part[i] = slip[i] * way[i] * (v_1 * v_r[i] + p_1 * p + q_1 * q)
    return total(part, last)


@compiled
def base_squared(dt, u_dd, begin, last, part):
    """Give the integral of ü² from sample `begin` of a piece to sample `last`."""
    for i in range(last):
        u, u_1 = u_dd[i], u_dd[i + 1]
        inside = 1.0 if begin <= i else 0.0
        part[i] = inside * (u * u + u * u_1 + u_1 * u_1)
    return dt / 3.0 * total(part, last)


@compiled
def path_squared(dt, u, u_dd, begin, last, part):
    """Give the integral of u² [m²s] likewise: of the cubics whose second derivative is ü."""
    bend = dt * dt / 6.0
    for i in range(last):
        a, b = u[i], u[i + 1]
        p, q = bend * u_dd[i], bend * u_dd[i + 1]
        inside = 1.0 if begin <= i else 0.0
        part[i] = inside * (
            (a * a + a * b + b * b) / 3.0 - (a * p + b * q) * 4.0 / 15.0
            - (a * q + b * p) * 7.0 / 30.0 + (p * p + q * q) * 8.0 / 105.0
            + p * q * 31.0 / 210.0
        )  # fmt: skip
    return dt * total(part, last)
