"""Lanes that wait, abreast: through the step that they stand before, which may hold one event.

What is not so plain - two events in a step, a velocity that only touches zero, a root that
strays - is left to the march of one record.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, fused
from drysim.core.events import ROUNDING
from drysim.core.many.beside import beside
from drysim.core.many.lanes import LANES, WIDTH
from drysim.core.many.queue import (
    DONE,
    EVENTS,
    FAR,
    HERE,
    NO_DECISION,
    PLAIN,
    STOPS,
    SUMS,
    TIGHT,
    U_1,
    X_STOP,
    D,
    U,
    V,
    X,
)
from drysim.core.many.stride import grip_of, step
from drysim.core.many.trapezia import ends, halves
from drysim.core.samples import series as brief

NEARLY = 2e-5
"""Step of a method of fourth order after which nothing is left to mend, relative to the root
and to how far the velocity bends: the first guess is as good but once in a thousand times."""

series, distance = fused(brief.series), fused(brief.distance)
speed, rate = fused(brief.speed), fused(brief.rate)


@fused
def first_guess(q, h):
    """Give where the parabola through the start of a fall is zero, mended by two terms."""
    square = q[1] * q[1] - 4.0 * q[0] * q[2]
    root = math.sqrt(square if square > 0.0 else 1.0)
    down = root > q[1]
    above = 2.0 * q[0] if down else -q[1] - root
    below = root - q[1] if down else 2.0 * q[2]
    s = above / (below if below != 0.0 else 1.0)
    s = min(max(s, 0.0), h)
    return s + s * s * s * (q[3] + s * q[4]) / root, square > 0.0


@fused
def fall_abreast(q, h):
    """Give where a velocity that ends below zero is zero, and whether that holds."""
    s, good = first_guess(q, h)
    a = rate(q, s)
    good = good and a < 0.0 and s > 0.0
    per_a = 1.0 / (a if good else -1.0)
    bend, twist = q[2] + s * (3.0 * q[3] + 6.0 * q[4] * s), q[3] + 4.0 * q[4] * s
    step, bend, twist = -speed(q, s) * per_a, bend * per_a, twist * per_a
    step -= step * step * (bend - (2.0 * bend * bend - twist) * step)
    step = step if good else 0.0
    s += step
    # A root that strays may be anywhere; what is made of it shall stay among the numbers.
    good = good and abs(step) <= NEARLY * s and abs(bend * step) <= NEARLY
    return min(max(s, 0.0), h), good


@compiled
def eight(plant, law, steps, pace, rule, at):
    """Carry as many lanes as a register holds through the step that they stand before."""
    through_of_eight(plant, law, steps, pace, rule, at)


@fused
def through_of_eight(plant, law, steps, pace, rule, at):
    """Carry them; see `eight`."""
    h, c, w, f = steps.dt, steps.c, steps.w, steps.f
    m, k_x, F_fs = plant.m, plant.k_x, law.F_fs
    per_h, per_m = 1.0 / h, 1.0 / m
    for i in range(WIDTH):
        x, v, d, u, u_1 = at[X + i], at[V + i], at[D + i], at[U + i], at[U_1 + i]
        slides = d != 0.0
        slope = (u_1 - u) * per_h
        x_1, v_1, felt = step(pace, grip_of(pace, x, d), x, v, u, u_1)
        v_end, felt_1 = d * v_1, c * v_1 + (w * x_1 + d * f)
        a = -d * (u + felt)
        q = series(steps.tail, d * v, a, -d * slope - c * a - w * (d * v))
        stop, good = fall_abreast(q, h)
        # A short step holds one extremum at most.
        none = slides and v_end > 0.0 and (a >= 0.0 or d * (u_1 + felt_1) >= 0.0)
        # Break-away: F_L is linear in time, so it meets the limit at a quotient.
        F_0, climb = m * u + k_x * x, m * slope
        F_out = F_fs if F_0 + climb * h >= 0.0 else -F_fs
        meets = (F_out - F_0) / (climb if climb != 0.0 else 1.0)
        stop = stop if slides else min(max(meets, 0.0), h)
        way = distance(q, stop)
        x_s, u_s = x + d * way, u + slope * stop
        F_L = m * u_s + k_x * x_s
        hold = F_fs + ROUNDING * (F_fs + abs(k_x * x_s))
        sticks = slides and abs(F_L) <= hold
        F_L = F_L if slides else F_out
        d_2 = 1.0 if F_L < 0.0 else -1.0
        d_2 = 0.0 if sticks else d_2
        a_2 = 0.0 if sticks else abs(F_L) * per_m - f
        q_2 = series(steps.tail, 0.0, a_2, 0.0 if sticks else -d_2 * slope - c * a_2)
        rest = h - stop
        way_2, v_2 = distance(q_2, rest), d_2 * speed(q_2, rest)
        x_2 = x_s + d_2 * way_2
        bears = abs(m * u_1 + k_x * x_s) <= hold
        fine = bears if sticks else d_2 * v_2 > 0.0 and (not slides or d * F_L > 0.0)
        fine = fine and ((good and v_end <= 0.0) if slides else climb != 0.0)
        here = at[HERE + i] > 0.0
        goes_on, counts = here and none, here and fine and not none
        stops = counts and slides
        larger = max(abs(F_L), F_fs)
        tight = abs(abs(F_L) - F_fs) / (larger if larger > 0.0 else 1.0)
        # Sums count what the rule makes of the step; the integrals take its place.
        a_s = -(d * F_L * per_m + f) if slides else 0.0
        back = series(steps.tail, 0.0, a_s, -d * slope - c * a_s)
        felt_2 = c * v_2 + (w * x_2 + d_2 * f)
        one = beside(steps, back, x_s, d, u_s, slope, -stop, x, v, felt, u)
        two = beside(steps, q_2, x_s, d_2, u_s, slope, rest, x_2, v_2, felt_2, u_1)
        p, r = halves(rule, d, x, felt, u, v), halves(rule, d_2, x_2, felt_2, u_1, v_2)
        b = ends(rule, d, x, felt, u, v, slope)
        e = ends(rule, d_2, x_2, felt_2, u_1, v_2, slope)
        still = (0.0 if slides else stop) + (rest if sticks else 0.0)
        x2 = one[0] + two[0] - ((p[0] + r[0]) + (e[0] - b[0]))
        v2 = one[1] + two[1] - ((p[1] + r[1]) + (e[1] - b[1]))
        x_dd2 = one[2] + two[2] - ((p[2] + r[2]) + (e[2] - b[2]))
        power = one[3] + two[3] - ((p[3] + r[3]) + (e[3] - b[3]))
        rub = way + way_2 - ((p[4] + r[4]) + (e[4] - b[4]))
        at[SUMS + i] += x2 if counts else 0.0
        at[SUMS + LANES + i] += v2 if counts else 0.0
        at[SUMS + 2 * LANES + i] += x_dd2 if counts else 0.0
        at[SUMS + 3 * LANES + i] += power if counts else 0.0
        at[SUMS + 4 * LANES + i] += rub if counts else 0.0
        at[SUMS + 5 * LANES + i] += still - (p[5] + r[5]) if counts else 0.0
        x_2, v_2 = x_1 if none else x_2, v_1 if none else v_2
        moves = goes_on or counts
        at[X + i], at[V + i] = x_2 if moves else x, v_2 if moves else v
        at[D + i] = d_2 if counts else d
        at[X_STOP + i], at[STOPS + i] = x_s, 1.0 if stops else 0.0
        at[TIGHT + i] = min(at[TIGHT + i], tight if stops else NO_DECISION)
        at[FAR + i] = max(at[FAR + i], abs(x_s) if stops else 0.0)
        at[EVENTS + i] += 1.0 if counts else 0.0
        at[DONE + i] += 1.0 if moves else 0.0
        at[PLAIN + i] = 1.0 if moves or not here else 0.0


@compiled
def leave(at):
    """Leave as many lanes as a register holds before the steps that they stand before."""
    for i in range(WIDTH):
        at[STOPS + i], at[PLAIN + i] = 0.0, 0.0 if at[HERE + i] > 0.0 else 1.0
