"""A stretch of one mode under waves, as it starts, and how fast the force on it may change."""

from __future__ import annotations

from typing import NamedTuple

from drysim.core.compiled import compiled, inlined
from drysim.core.waves import COSINE, OMEGA, SINE, STRIDE, A


class Stretch(NamedTuple):
    """A stretch of one mode, as it starts.

    Attributes
    ----------
    c, w, x_r, v_r, g, r : float
        As in `slide`.
    a, j, k : float
        Acceleration [m/s²], jerk [m/s³] and its rate [m/s⁴] at the start.
    """

    c: float
    w: float
    x_r: float
    v_r: float
    a: float
    j: float
    k: float
    g: float
    r: float


@inlined
def starting(c, w, waves, x_r, v_r, g, r):
    """Give the stretch that starts now, waves anchored; parameters as in `slide`."""
    push, push_d, push_dd = g, r, 0.0
    for i in range(waves.size):
        at = STRIDE * i
        omega = waves.values[at + OMEGA]
        swing = waves.values[at + A] * waves.values[at + SINE]
        push -= swing
        push_d -= waves.values[at + A] * omega * waves.values[at + COSINE]
        push_dd += omega * omega * swing
    a = push - c * v_r - w * x_r
    j = push_d - c * a - w * v_r
    return Stretch(c, w, x_r, v_r, a, j, push_dd - c * j - w * a, g, r)


@compiled
def force_rates(waves, r):
    """Give bounds of the first three rates of the force per mass, and the greatest omega.

    Parameters
    ----------
    waves : Waves
        Anchored.
    r : float
        Rate of the force per mass besides the waves [m/s³].
    """
    first, second, third, fastest = abs(r), 0.0, 0.0, 0.0
    for i in range(waves.size):
        omega = waves.values[STRIDE * i + OMEGA]
        rate = abs(waves.values[STRIDE * i + A]) * omega
        first += rate
        second += rate * omega
        third += rate * omega * omega
        fastest = max(fastest, omega)
    return first, second, third, fastest
