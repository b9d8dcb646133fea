"""Where a series that begins above zero comes down to it first, however near it passes."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.leave import parabola

SHORTER = 6
"""Times at most that the stretch over which the curvature is bounded is made shorter, before
the series is moved."""


@compiled
def locate(c, n, h):
    """Give the first time in [0, h] at which a series comes down to zero, or infinity.

    A bound on the curvature gives a step that is surely above zero; after it the series is
    moved there, so that its bounds are those of what is left. A zero at the beginning itself is
    divided out.

    Parameters
    ----------
    c : array of float
        Terms up to n; lost.
    n : int
        Last term.
    h : float
        Length looked at, above 0 [s].
    """
    n, zeros = lowered(c, n)
    if zeros < 0:
        return NEVER
    rest, power = 0.0, h
    for k in range(1, n + 1):
        c[k] *= power
        rest += abs(c[k])
        power *= h
    s = 0.0
    while c[0] <= rest:
        if c[0] <= 0.0:
            return s * h
        step = stride(c, n, 1.0 - s)
        if s + step >= 1.0:
            return NEVER
        if step <= RESOLUTION * s:
            return s * h
        s += step
        move(c, n, step)
    return NEVER


@inlined
def lowered(c, n):
    """Divide out zeros at the beginning; gives the last term and how many, -1 for all."""
    zeros = 0
    while zeros <= n and c[zeros] == 0.0:
        zeros += 1
    if zeros > 0 and zeros <= n:
        for k in range(n - zeros + 1):
            c[k] = c[k + zeros]
    return n - zeros, (zeros if zeros <= n else -1)


@inlined
def stride(c, n, left):
    """Give a step of a scaled series within which it surely stays above zero."""
    best = 0.0
    for _ in range(SHORTER):
        bend = 0.0
        power = 1.0
        for k in range(2, n + 1):
            bend += k * (k - 1) * abs(c[k]) * power
            power *= left
        step = min(parabola(c[0], c[1] if n > 0 else 0.0, bend), left)
        best = max(best, step)
        if step >= 0.5 * left:
            return best
        # Where the zero is nearer by many powers of ten, halves would never come to it.
        left = min(0.5 * left, math.sqrt(step) * math.sqrt(left))
    return best


@inlined
def move(c, n, step):
    """Move a series to `step` after its beginning."""
    for i in range(n):
        for k in range(n - 1, i - 1, -1):
            c[k] += step * c[k + 1]
