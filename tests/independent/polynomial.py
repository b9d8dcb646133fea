"""Polynomials of a stretch of motion in 50 digits: their first zeros, and integrals of squares.

Zeros are found by halving intervals that a bound on value and slope cannot clear.
"""

from __future__ import annotations

from typing import Any

import mpmath as mp

DIGITS = 50

DEEPEST = 126
"""Halvings after which an interval, 1e-38 of a stretch, is one instant: a touch."""

START = 4
"""So many of the narrowest intervals at 0 belong to a start from rest."""

AFTER = mp.mpf(10) ** -15
"""Share of a stretch by which the search goes on behind a touch."""

NOTHING = mp.mpf(10) ** -35
"""Rate of a margin, relative to the margin's scale, that is a touch and not a crossing."""

BITS = 220
"""Fixed-point bits of an integral: 66 digits."""

FINE_BITS = 640
"""Fixed-point bits of a polynomial that is halved: a start as s⁴ is seen to the end."""

CAP = 400
"""Halving alone needs 170 rounds to 50 digits."""

Polynomial = list[Any]


def value(p: Polynomial, s: Any) -> Any:
    """Return a polynomial at s."""
    total = mp.mpf(0)
    for coefficient in reversed(p):
        total = total * s + coefficient
    return total


def slope(p: Polynomial) -> Polynomial:
    """Return the derivative of a polynomial."""
    return [n * p[n] for n in range(1, len(p))]


def magnitude(p: Polynomial, reach: Any = 1) -> Any:
    """Return what a polynomial does not exceed in magnitude on [-reach, reach]."""
    return value([abs(each) for each in p], reach)


def square_integral(p: Polynomial, s: Any) -> Any:
    """Return the integral of a squared polynomial from 0 to s, by integers in fixed point."""
    scaled = [each * s**n for n, each in enumerate(p)]
    if not any(scaled):
        return mp.mpf(0)
    shift = BITS - max(mp.mag(each) for each in scaled if each)
    whole = [int(mp.ldexp(each, shift)) for each in scaled]
    square = [0] * (2 * len(whole))
    for i, one in enumerate(whole):
        for j, other in enumerate(whole):
            square[i + j] += one * other
    total = sum((each << BITS) // (n + 1) for n, each in enumerate(square))
    return s * mp.ldexp(mp.mpf(total), -2 * shift - BITS)


def part(p: Polynomial, lo: Any, hi: Any) -> Polynomial:
    """Return the polynomial of [lo, hi], stretched to [0, 1]."""
    out = list(p)
    for i in range(len(out) - 1):
        for j in range(len(out) - 2, i - 1, -1):
            out[j] += lo * out[j + 1]
    return [each * (hi - lo) ** n for n, each in enumerate(out)]


def fixed(p: Polynomial) -> list[int]:
    """Return the coefficients as integers, the largest with `FINE_BITS` bits."""
    shift = FINE_BITS - max(mp.mag(each) for each in p if each)
    return [int(mp.ldexp(each, shift)) for each in p]


def first_zero(p: Polynomial) -> Any:
    """Return the first s in (0, 1] where a polynomial falls to 0 or touches it, or None.

    It is above zero at 0, or leaves zero upwards there.
    """
    if p[0] > magnitude(p[1:]) or not any(p):
        return None
    stack = [(fixed(p), 0, 0)]
    while stack:
        q, k, depth = stack.pop()
        if q[0] > sum(map(abs, q[1:])):
            continue
        steep = sum(n * abs(q[n]) for n in range(2, len(q)))
        if q[1] > steep:
            continue
        if q[1] < -steep:
            if sum(q) <= 0:
                return polished(p, slope(p), mp.mpf(k) / 2**depth, mp.mpf(k + 1) / 2**depth)
            continue
        if depth == DEEPEST:
            if k < START:
                continue
            return mp.mpf(k + 1) / 2**depth
        left = [each >> n for n, each in enumerate(q)]
        right = list(left)
        for i in range(len(q) - 1):
            for j in range(len(q) - 2, i - 1, -1):
                right[j] += right[j + 1]
        stack += [(right, 2 * k + 1, depth + 1), (left, 2 * k, depth + 1)]
    return None


def polished(p: Polynomial, p_d: Polynomial, lo: Any, hi: Any) -> Any:
    """Return the zero of a polynomial that falls from lo to hi."""
    s = (lo + hi) / 2
    for _ in range(CAP):
        v = value(p, s)
        lo, hi = (s, hi) if v > 0 else (lo, s)
        after = s - v / value(p_d, s)
        if abs(after - s) <= mp.mpf(10) ** (5 - DIGITS) * abs(s):
            return after
        s = after if lo < after < hi else (lo + hi) / 2
    return s


def leaves(gap: Polynomial) -> Any:
    """Return when a margin at or above 0 falls below it on [0, 1], or None; touches do not."""
    begin, scale = mp.mpf(0), magnitude(gap)
    while begin < 1:
        rest = part(gap, begin, 1) if begin else gap
        rate = next((each for each in rest[1:] if abs(each) > NOTHING * scale), mp.mpf(0))
        if abs(rest[0]) <= NOTHING * scale and rate < 0:
            return begin
        found = first_zero(rest)
        if found is None:
            return None
        found = begin + found * (1 - begin)
        if value(slope(gap), found) < -NOTHING * scale:
            return found
        begin = found + AFTER
    return None
