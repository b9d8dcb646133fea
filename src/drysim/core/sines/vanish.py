"""When a blend of the motion and of the normal force vanishes, rigorously.

What a contact may still bear, how fast it yields, the force of a bumper: each is a sum of x_r,
v_r and the normal force, whose rates a stretch knows. Steps that a bound on the third rate
proves safe lead to the zero from below; where the bound proves that the blend only falls until
it is below zero, Newton's method does.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.sines.blend import (
    Instant,
    blended,
    bound_of,
    far_from_zero,
    instant,
    most_twist,
    safe_blend,
    starting_course,
)
from drysim.core.sines.cease import NEWTON_CAP, falls_surely, is_sharp, to_zero_of_cubic


@compiled
def vanish(stretch, waves, law, blend, zeros, h):
    """Give the first time in [0, h] at which a blend is no longer above zero, and the motion.

    Parameters
    ----------
    stretch : Stretch
    waves : Waves
        Anchored at its start.
    law
        Whose normal force it is.
    blend : Blend
        What is at least zero at the start, roundings apart.
    zeros : int
        What is zero exactly at the start: 1 the blend, 2 its rate as well.
    h : float
        Length of the stretch [s].

    Returns
    -------
    s, x_r, v_r : float
        Time [s], infinite where the blend stays above zero, and the state then.

    Notes
    -----
    Jerk and its rate obey the oscillator's equation driven by rates of the force, so that
    |jerk|(s) <= sqrt(jerk² + w a²) + s·max|second rate|, and likewise the next one.
    """
    bound = bound_of(waves, law, blend, stretch.r, h)
    now = Instant(0.0, stretch.x_r, stretch.v_r, stretch.a, stretch.j, stretch.k)
    course = starting_course(law, waves, blend, now, zeros)
    if far_from_zero(course, most_twist(blend, stretch.w, now, bound), bound, h):
        return NEVER, now.x_r, now.v_r
    return seek(stretch, waves, law, blend, bound, now, course, h)


@compiled
def seek(stretch, waves, law, blend, bound, now, course, h):
    """Give what `vanish` gives, from some time of the stretch on.

    Parameters
    ----------
    stretch, waves, law, blend, h
        As in `vanish`.
    bound : Bound
    now, course : Instant, Course
        Where to begin.
    """
    w = stretch.w
    while True:
        most = most_twist(blend, w, now, bound)
        if falls_surely(course.value, course.rate, course.bend, most, bound.growth):
            break
        step = safe_blend(course, most, bound)
        if step == 0.0:
            return now.s, now.x_r, now.v_r
        if now.s + step >= h:
            return NEVER, now.x_r, now.v_r
        if step <= RESOLUTION * now.s:
            return now.s, now.x_r, now.v_r
        now = instant(stretch, waves, now.s + step)
        course = blended(law, waves, blend, now)
        if course.value <= 0.0:
            return now.s, now.x_r, now.v_r
    s, x, v, a, j, k = now
    for _ in range(NEWTON_CAP):
        value, rate, bend, twist = course
        step = to_zero_of_cubic(value, rate, bend, twist)
        most += bound.growth * abs(step)
        fourth = (stretch.c + math.sqrt(w)) * most + bound.growth + bound.swing * law.omega
        s += step
        if is_sharp(step, rate, fourth, s):
            x += step * (v + step * (0.5 * a + step * (j / 6.0 + step * k / 24.0)))
            v += step * (a + step * (0.5 * j + step * k / 6.0))
            break
        now = instant(stretch, waves, s)
        s, x, v, a, j, k = now
        course = blended(law, waves, blend, now)
        most = most_twist(blend, w, now, bound)
    return (s, x, v) if s < h else (NEVER, x, v)
