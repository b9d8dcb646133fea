"""A normal force that varies, as kernels read it: its course, and when it vanishes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compiled import compiled
from drysim.core.samples.stop import NEVER
from drysim.core.waves import normal_force


class Limits(NamedTuple):
    """A law as kernels read it.

    Attributes
    ----------
    F_fk, F_fs, variation, omega, phase : float
        As in `Pressed`.
    load : array of float, shape (n,)
        Recorded normal force relative to its mean [-].
    step : float
        Distance of its samples [s]; 0 where there is no record.
    """

    F_fk: float
    F_fs: float
    variation: float
    omega: float
    phase: float
    load: Any
    step: float


class Span(NamedTuple):
    """The normal force of a stretch without its wave, relative to its mean.

    Attributes
    ----------
    load, rate : float
        At its start [-], and its rate [1/s].
    left : float
        Time to the next sample of the force [s], or infinity.
    """

    load: float
    rate: float
    left: float


@compiled
def span_at(law, t):
    """Give the span of the normal force from time t [s] on."""
    if law.step == 0.0:
        return Span(1.0, 0.0, NEVER)
    last = len(law.load) - 2
    k = min(int(t / law.step), last)
    while k < last and (k + 1) * law.step <= t:
        k += 1
    while k * law.step > t:
        k -= 1
    rate = (law.load[k + 1] - law.load[k]) / law.step
    left = (k + 1) * law.step - t if k < last else NEVER
    return Span(law.load[k] + rate * (t - k * law.step), rate, left)


@compiled
def load_within(law, waves, span, s):
    """Give the normal force relative to its mean [-] at time s of a stretch, and its rate."""
    swing, swing_d, _ = normal_force(law, waves, s)
    return span.load * swing + span.rate * s, swing_d + span.rate


@compiled
def next_zero_load(law, waves, t, falling):
    """Give how long after t [s] the normal force is zero next, falling or rising; or infinity.

    The stretch starts at t; the force is 1 + variation·sin(omega t + phase) of its mean.
    """
    if law.variation <= 1.0:
        return NEVER
    load, load_d, _ = normal_force(law, waves, 0.0)
    if falling and load <= 0.0 and load_d < 0.0:
        return 0.0
    if not falling and load >= 0.0 and load_d > 0.0:
        return 0.0
    dip = math.asin(1.0 / law.variation)
    angle = math.pi + dip if falling else 2.0 * math.pi - dip
    return (angle - (law.omega * t + law.phase)) % (2.0 * math.pi) / law.omega


@compiled
def parts_at(law, waves, span, t):
    """Give how long after t [s] the surfaces part, or infinity."""
    if law.step == 0.0:
        return next_zero_load(law, waves, t, True)
    if span.rate < 0.0:
        return max(span.load / -span.rate, 0.0)
    return 0.0 if span.load <= 0.0 and span.rate == 0.0 else NEVER


@compiled
def meets_at(law, waves, span, t):
    """Give how long after t [s] surfaces that are apart meet, or infinity."""
    if law.step == 0.0:
        return next_zero_load(law, waves, t, False)
    return max(-span.load / span.rate, 0.0) if span.rate > 0.0 else NEVER
