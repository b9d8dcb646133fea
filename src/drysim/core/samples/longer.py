"""The series of a short stretch with six terms more: it serves one five times as long."""

from __future__ import annotations

from typing import NamedTuple

from drysim.core.compiled import compiled
from drysim.core.samples.series import series

SHORT = 0.5
"""Radians (or decays) in a short stretch: 16 terms of its series exhaust double precision."""


class More(NamedTuple):
    """How acceleration (a) and jerk (j) at the start go on in v's terms from s¹⁰ to s¹⁵."""

    a_10: float
    j_10: float
    a_11: float
    j_11: float
    a_12: float
    j_12: float
    a_13: float
    j_13: float
    a_14: float
    j_14: float
    a_15: float
    j_15: float


@compiled
def more_of(tail, c, w):
    """Give what follows on a tail: each term from the two before it."""
    a_10, j_10 = term(c, w, tail.a_9, tail.a_8, 10), term(c, w, tail.j_9, tail.j_8, 10)
    a_11, j_11 = term(c, w, a_10, tail.a_9, 11), term(c, w, j_10, tail.j_9, 11)
    a_12, j_12 = term(c, w, a_11, a_10, 12), term(c, w, j_11, j_10, 12)
    a_13, j_13 = term(c, w, a_12, a_11, 13), term(c, w, j_12, j_11, 13)
    a_14, j_14 = term(c, w, a_13, a_12, 14), term(c, w, j_13, j_12, 14)
    a_15, j_15 = term(c, w, a_14, a_13, 15), term(c, w, j_14, j_13, 15)
    return More(
        a_10, j_10, a_11, j_11, a_12, j_12, a_13, j_13, a_14, j_14, a_15, j_15
    )  # fmt: skip


@compiled
def term(c, w, last, one_before, n):
    """Give the coefficient of sⁿ in v from the two before it."""
    return -(c * last + w * one_before / (n - 1)) / n


@compiled
def longer_series(tail, more, v, a, j):
    """Give the coefficients of v(s) = q_0 + q_1 s + q_2 s² + ... from v, a and the jerk."""
    return (
        *series(tail, v, a, j),
        more.a_10 * a + more.j_10 * j, more.a_11 * a + more.j_11 * j,
        more.a_12 * a + more.j_12 * j, more.a_13 * a + more.j_13 * j,
        more.a_14 * a + more.j_14 * j, more.a_15 * a + more.j_15 * j,
    )  # fmt: skip
