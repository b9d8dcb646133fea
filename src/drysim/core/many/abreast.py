"""One step of many records abreast that may hold one event: as many at once as there is room.

What is not so plain - two events in a step, a velocity that only touches zero, a root that
strays - is left to the march of one record.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled, inlined
from drysim.core.events import ROUNDING
from drysim.core.many.lanes import LANES, WIDTH
from drysim.core.samples.series import NEARLY, distance, rate, series, speed
from drysim.core.stretches import NODES, WEIGHTS

X, V, D, U_0, U_1 = range(5)
(
    X_END, V_END, D_END, X_STOP, TIGHT, STOPS, EVENTS, X2, V2, X_DD2, POWER, RUB, STUCK, PLAIN,
) = range(5, 19)  # fmt: skip
"""Rows of a step: state, direction and ü at its ends; the state at its end, x_r where it stops,
how tight that decision is, whether it stops and how many events there are; the integrals as in
`Totals`; and whether all that holds. ROWS is their number."""

ROWS = 19

ALONE = 2.0
"""Tightness of what was no decision: above all that are."""

ROUNDS = 3
"""Of Halley's method, of third order: the first guess is good to a thousandth mostly."""


@inlined
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


@inlined
def fall_abreast(q, h):
    """Give where a velocity that ends below zero is zero, and whether that holds."""
    s, good = first_guess(q, h)
    step = 0.0
    for _ in range(ROUNDS):
        a = rate(q, s)
        good = good and a < 0.0 and s > 0.0
        per_a = 1.0 / (a if good else -1.0)
        step = -speed(q, s) * per_a
        step -= step * step * (q[2] + 3.0 * q[3] * s) * per_a
        step = step if good else 0.0
        s += step
    return min(s, h), good and abs(step) <= NEARLY * s


@inlined
def bend_of(steps, a, j):
    """Give what a velocity can fall below its lower end within a step that is short."""
    h = steps.dt
    return 0.25 * h * h * (abs(j) + h * (steps.c * abs(j) + steps.w * abs(a)))


@inlined
def integrals_abreast(steps, q, u_0, slope, x_r, d, h):
    """Give what `short_stretch` gives of a stretch of length h; d is 0 where it sticks."""
    c, w, f = steps.c, steps.w, d * steps.f
    x2, v2, x_dd2, power = 0.0, 0.0, 0.0, 0.0
    for i in range(len(NODES)):
        s = h * NODES[i]
        u = u_0 + slope * s
        x, v = x_r + d * distance(q, s), d * speed(q, s)
        felt = w * x + c * v + f
        x_dd = u if d == 0.0 else felt
        x2 += WEIGHTS[i] * x * x
        v2 += WEIGHTS[i] * v * v
        x_dd2 += WEIGHTS[i] * x_dd * x_dd
        power += WEIGHTS[i] * u * v
    return h * x2, h * v2, h * x_dd2, h * power


@compiled
def through_abreast(plant, law, steps, at, count):
    """Carry that many states through a step each; `at` has the rows named above.

    A number above `count` is filled up to whole registers with steps that are no matter.
    """
    for first in range(0, count, WIDTH):
        eight(plant, law, steps, at[first:])


@compiled
def eight(plant, law, steps, at):
    """Carry as many states as a register holds through a step each."""
    h, c, w, f = steps.dt, steps.c, steps.w, steps.f
    m, k_x, F_fs, F_fk = plant.m, plant.k_x, law.F_fs, law.F_fk
    for i in range(WIDTH):
        x, v, d = at[X * LANES + i], at[V * LANES + i], at[D * LANES + i]
        u_0, u_1 = at[U_0 * LANES + i], at[U_1 * LANES + i]
        slides = d != 0.0
        slope = (u_1 - u_0) / h
        a = -d * (u_0 + c * v + w * x + d * f)
        j = -d * slope - c * a - w * (d * v)
        q = series(steps.tail, d * v, a, j)
        v_end = speed(q, h)
        stop, good = fall_abreast(q, h)
        bend = bend_of(steps, a, j)
        none = slides and min(d * v, v_end) > bend
        # Break-away: F_L is linear in time, so it meets the limit at a quotient.
        F_1 = m * u_1 + k_x * x
        way_out = 1.0 if F_1 < 0.0 else -1.0
        rise = m * slope
        meets = (-way_out * F_fs - (m * u_0 + k_x * x)) / (rise if rise != 0.0 else 1.0)
        meets = min(max(meets, 0.0), h)
        stop = stop if slides else meets
        stop = h if none else stop
        way = distance(q, stop)
        x_stop = x + d * way
        u_stop = u_0 + slope * stop
        F_L = m * u_stop + k_x * x_stop
        hold = F_fs + ROUNDING * (F_fs + abs(k_x * x_stop))
        sticks = slides and abs(F_L) <= hold
        turned = 1.0 if F_L < 0.0 else -1.0
        d_2 = turned if slides else way_out
        d_2 = 0.0 if sticks else d_2
        d_2 = d if none else d_2
        jump = (abs(F_L) - F_fk) / m if slides else (F_fs - F_fk) / m
        a_2 = 0.0 if none or sticks else jump
        j_2 = 0.0 if none or sticks else -d_2 * slope - c * a_2
        q_2 = series(steps.tail, 0.0, a_2, j_2)
        rest = h - stop
        way_2, v_2 = distance(q_2, rest), speed(q_2, rest)
        x_2 = x_stop + d_2 * way_2
        bears = abs(m * u_1 + k_x * x_stop) <= hold
        fine = v_2 > 0.0
        fine = bears if sticks else fine
        falls = good and v_end <= 0.0 and d * F_L > 0.0
        falls = good and v_end <= 0.0 if sticks else falls
        fine = fine and (falls if slides else rise != 0.0)
        fine = fine or none
        larger = max(abs(F_L), F_fs)
        tight = abs(abs(F_L) - F_fs) / (larger if larger > 0.0 else 1.0)
        one = integrals_abreast(steps, q, u_0, slope, x, d, stop)
        two = integrals_abreast(steps, q_2, u_stop, slope, x_stop, d_2, rest)
        at[X_END * LANES + i] = x_2
        at[V_END * LANES + i] = d * v_end if none else d_2 * v_2
        at[D_END * LANES + i] = d_2
        at[X_STOP * LANES + i] = x_stop
        stops = slides and not none
        at[TIGHT * LANES + i] = tight if stops else ALONE
        at[STOPS * LANES + i] = 1.0 if stops else 0.0
        at[EVENTS * LANES + i] = 0.0 if none else 1.0
        at[X2 * LANES + i] = one[0] + two[0]
        at[V2 * LANES + i] = one[1] + two[1]
        at[X_DD2 * LANES + i] = one[2] + two[2]
        at[POWER * LANES + i] = one[3] + two[3]
        at[RUB * LANES + i] = way + way_2
        still = stop if d == 0.0 else 0.0
        at[STUCK * LANES + i] = still + (rest if d_2 == 0.0 else 0.0)
        at[PLAIN * LANES + i] = 1.0 if fine else 0.0
