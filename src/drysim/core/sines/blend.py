"""A blend of the motion and of the normal force, and what bounds it within a stretch."""

from __future__ import annotations

import math
from typing import NamedTuple

from drysim.core.compiled import inlined
from drysim.core.sines.cease import REACH, safe_slip
from drysim.core.sines.slide import slide_and_snap
from drysim.core.sines.stretch import force_rates
from drysim.core.waves import normal_force


class Blend(NamedTuple):
    """The sum x (x_r - x_0) + v v_r + load N + rate N', N the normal force and N' its rate.

    Attributes
    ----------
    x_0 : float
        Where x_r counts from [m].
    x, v : float
        Shares of x_r and v_r.
    load, rate : float
        Shares of the normal force relative to its mean, and of its rate.
    """

    x_0: float
    x: float
    v: float
    load: float
    rate: float


class Instant(NamedTuple):
    """A time of a stretch [s], and the motion then as `slide_and_snap` gives it."""

    s: float
    x_r: float
    v_r: float
    a: float
    j: float
    k: float


class Course(NamedTuple):
    """A blend at an instant, and its first three rates."""

    value: float
    rate: float
    bend: float
    twist: float


class Bound(NamedTuple):
    """What bounds the third rate of a blend within a stretch.

    Attributes
    ----------
    growth : float
        How fast it may grow at most.
    swing : float
        Share of the normal force in it at most.
    cap : float
        Longest step that is tried [s].
    """

    growth: float
    swing: float
    cap: float


@inlined
def instant(stretch, waves, s):
    """Give the motion at time s of a stretch."""
    c, w, x_r, v_r, _, _, _, g, r = stretch
    x, v, a, j, k = slide_and_snap(c, w, waves, x_r, v_r, g, r, s)
    return Instant(s, x, v, a, j, k)


@inlined
def blended(law, waves, blend, now):
    """Give a blend at an instant of a stretch."""
    s, x, v, a, j, k = now
    value, rate = blend.x * (x - blend.x_0) + blend.v * v, blend.x * v + blend.v * a
    bend, twist = blend.x * a + blend.v * j, blend.x * j + blend.v * k
    if blend.load != 0.0 or blend.rate != 0.0:
        load, load_d, load_dd = normal_force(law, waves, s)
        square = law.omega * law.omega
        value += blend.load * load + blend.rate * load_d
        rate += blend.load * load_d + blend.rate * load_dd
        bend += blend.load * load_dd - blend.rate * square * load_d
        twist -= square * (blend.load * load_d + blend.rate * load_dd)
    return Course(value, rate, bend, twist)


@inlined
def starting_course(law, waves, blend, now, zeros):
    """Give a blend as a stretch starts; `zeros` as in `vanish`."""
    value, rate, bend, twist = blended(law, waves, blend, now)
    value = 0.0 if zeros > 0 else max(value, 0.0)
    return Course(value, 0.0 if zeros > 1 else rate, bend, twist)


@inlined
def most_twist(blend, w, now, bound):
    """Give a bound of the third rate of a blend, up to what its growth adds."""
    a, j, k = now.a, now.j, now.k
    most = bound.swing + abs(blend.x) * math.sqrt(j * j + w * a * a)
    return most + abs(blend.v) * math.sqrt(k * k + w * j * j)


@inlined
def bound_of(waves, law, blend, r, h):
    """Give the bound of a blend; r and h as in `slide` and `vanish`."""
    _, second, third, fastest = force_rates(waves, r)
    growth = abs(blend.x) * second + abs(blend.v) * third
    swing = law.variation * (abs(blend.load) + abs(blend.rate) * law.omega) * law.omega**3
    return Bound(growth, swing, min(REACH / fastest, h) if fastest > 0.0 else h)


@inlined
def far_from_zero(course, most, bound, h):
    """Tell whether a blend is above zero for h [s] to come, as in most steps of a record."""
    loses = max(-course.bend, 0.0) + h * (most + h * bound.growth)
    return course.value > h * (max(-course.rate, 0.0) + h * loses)


@inlined
def safe_blend(course, most, bound):
    """Give a step within which a blend provably stays above zero."""
    value, rate, bend, _ = course
    step = safe_slip(value, rate, bend, most, bound.growth, bound.cap)
    if value > 0.0 and bend > 0.0 and step < bound.cap:
        # Where it hardly bends upwards, what it bends is better left out.
        step = max(step, safe_slip(value, rate, 0.0, most, bound.growth, bound.cap))
    return step
