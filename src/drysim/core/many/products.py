"""Sums of products over whole steps: what the forms of `forms` make integrals of."""

from __future__ import annotations

from drysim.core.compiled import inlined
from drysim.core.many.lanes import LANES, PRODUCTS, TILE, D, U, V, X

WAY, STUCK_U2, STUCK = 18, 21, 22
"""First come the products of the `PAIRS` of forms; then those of the direction with rows 1 to
3; three times the mean ü² of steps of sticking; and how many those are."""


@inlined
def rows_of(steps, at, k, lane):
    """Give the rows of step k of a tile, and whether it sticks; zero where it does not slide.

    The displacement is given also where the mass sticks.
    """
    x, v, d = at[X + k * LANES + lane], at[V + k * LANES + lane], at[D + k * LANES + lane]
    u, u_1 = at[U + k * LANES + lane], at[U + (k + 1) * LANES + lane]
    slides = 1.0 if d * d == 1.0 else 0.0
    stuck = 1.0 if d == 0.0 else 0.0
    contact = slides * (steps.w * x + steps.f * d)
    base = slides * u
    squared = stuck * (u * u + u * u_1 + u_1 * u_1)
    return (
        x, v, base + contact, slides * (u_1 - u), base, steps.c * v + contact, d, squared, stuck
    )  # fmt: skip


@inlined
def add_products(steps, at, lanes):
    """Add the products of a tile."""
    for lane in range(lanes):
        x, v, p, q, u, a, d, s, r = rows_of(steps, at, 0, lane)
        x_1, v_1, p_1, q_1, u_1, a_1, d_1, s_1, r_1 = rows_of(steps, at, 1, lane)
        x_2, v_2, p_2, q_2, u_2, a_2, d_2, s_2, r_2 = rows_of(steps, at, 2, lane)
        x_3, v_3, p_3, q_3, u_3, a_3, d_3, s_3, r_3 = rows_of(steps, at, 3, lane)
        i = PRODUCTS + lane
        at[i] += (x * x + x_1 * x_1) + (x_2 * x_2 + x_3 * x_3)
        at[i + 1 * LANES] += (x * v + x_1 * v_1) + (x_2 * v_2 + x_3 * v_3)
        at[i + 2 * LANES] += (x * p + x_1 * p_1) + (x_2 * p_2 + x_3 * p_3)
        at[i + 3 * LANES] += (x * q + x_1 * q_1) + (x_2 * q_2 + x_3 * q_3)
        at[i + 4 * LANES] += (v * v + v_1 * v_1) + (v_2 * v_2 + v_3 * v_3)
        at[i + 5 * LANES] += (v * p + v_1 * p_1) + (v_2 * p_2 + v_3 * p_3)
        at[i + 6 * LANES] += (v * q + v_1 * q_1) + (v_2 * q_2 + v_3 * q_3)
        at[i + 7 * LANES] += (p * p + p_1 * p_1) + (p_2 * p_2 + p_3 * p_3)
        at[i + 8 * LANES] += (p * q + p_1 * q_1) + (p_2 * q_2 + p_3 * q_3)
        at[i + 9 * LANES] += (q * q + q_1 * q_1) + (q_2 * q_2 + q_3 * q_3)
        at[i + 10 * LANES] += (v * u + v_1 * u_1) + (v_2 * u_2 + v_3 * u_3)
        at[i + 11 * LANES] += (v * a + v_1 * a_1) + (v_2 * a_2 + v_3 * a_3)
        at[i + 12 * LANES] += (q * u + q_1 * u_1) + (q_2 * u_2 + q_3 * u_3)
        at[i + 13 * LANES] += (q * a + q_1 * a_1) + (q_2 * a_2 + q_3 * a_3)
        at[i + 14 * LANES] += (u * u + u_1 * u_1) + (u_2 * u_2 + u_3 * u_3)
        at[i + 15 * LANES] += (u * a + u_1 * a_1) + (u_2 * a_2 + u_3 * a_3)
        at[i + 16 * LANES] += (a * a + a_1 * a_1) + (a_2 * a_2 + a_3 * a_3)
        at[i + 17 * LANES] += (p * u + p_1 * u_1) + (p_2 * u_2 + p_3 * u_3)
        at[i + 18 * LANES] += (d * v + d_1 * v_1) + (d_2 * v_2 + d_3 * v_3)
        at[i + 19 * LANES] += (d * p + d_1 * p_1) + (d_2 * p_2 + d_3 * p_3)
        at[i + 20 * LANES] += (d * q + d_1 * q_1) + (d_2 * q_2 + d_3 * q_3)
        at[i + 21 * LANES] += (s + s_1) + (s_2 + s_3)
        at[i + 22 * LANES] += (r + r_1) + (r_2 + r_3)


assert TILE == 4, "the products of a tile are written out"
