"""The motion under a dynamic law, series after series, with every zero of the velocity."""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.dynamic_laws.dynamic import slow_speed
from drysim.core.dynamic_laws.jet import ORDER, drive, state_at, value
from drysim.core.dynamic_laws.memory import EVEN, end_branch, head, set_slope
from drysim.core.dynamic_laws.settled import SETTLED, calm_plant
from drysim.core.dynamic_laws.stay import calm_length, end_of_stay
from drysim.core.dynamic_laws.step import begin, extent
from drysim.core.events import REVERSAL, ROUNDING, SLIP, limit_force, note, sign
from drysim.core.plant import LEUVEN, STRIBECK
from drysim.core.samples.stop import NEVER, RESOLUTION
from drysim.core.trail import ENOUGH, mark

SLOW = 3
"""Besides the sign, the direction in a trail of a mass too slow for friction to have fallen."""

STALL = 100
"""Changes in a row without progress in time that put a scene at the end of double precision."""


@compiled
def faint_pull(plant, law, jet, x_r, z):
    """Return the acceleration [m/s²] up to which a mass at rest on bristles is in equilibrium.

    It is that of rounding; or that of a swing on the bristles whose speed may be neglected.
    Bristles near their limit give way without end, and no swing comes of it.
    """
    m, k_x, _ = plant
    pull = law.sigma_0 * abs(z)
    rounding = ROUNDING * (abs(k_x * x_r) + pull) / m
    firm = max(1.0 - pull / law.F_fs, 0.0) * (1.0 - law.F_fs / law.F_h)
    swing = law.tolerance * jet.scale[0] * math.sqrt((k_x + law.sigma_0 * firm) / m)
    return max(rounding, swing)


@compiled
def heading(plant, law, waves, jet, u_0, slope, t, x_r, z):
    """Return the direction in which a mass at rest on bristles starts, as in `Trail`.

    It is 2 or -2 in equilibrium, from where ü moves the mass, and 0 where no term of ü does.
    """
    drive(jet, waves, u_0, slope, t)
    a = jet.u[0] + (plant.k_x * x_r + law.sigma_0 * z) / plant.m
    if abs(a) > faint_pull(plant, law, jet, x_r, z):
        return -sign(a)
    for n in range(1, ORDER + 1):
        if jet.u[n] != 0.0:
            return -2 * sign(jet.u[n])
    return 0


@compiled
def first_heading(plant, law, waves, jet, u_0, slope, t, x_r, v_r, z):
    """Return the direction of motion as in `Trail`: 0 for stuck or without a cause to move."""
    if v_r != 0.0:
        return sign(v_r)
    if law.kind == STRIBECK:
        drive(jet, waves, u_0, slope, t)
        F_L = limit_force(plant, x_r, jet.u[0])
        hold = law.F_fs + ROUNDING * (law.F_fs + abs(plant.k_x * x_r))
        return 0 if abs(F_L) <= hold else -sign(F_L)
    return heading(plant, law, waves, jet, u_0, slope, t, x_r, z)


@compiled
def trace(
    plant, law, waves, u_dd, dt, n, s, h, end, x_r, v_r, z, d, jet, trail, at, log, count,
    capacity,
):  # fmt: skip
    """Follow the motion over intervals of ü, or until steps or log are nearly full.

    Parameters
    ----------
    plant, law, waves : Plant, Dynamic, Waves
    u_dd : array, shape (samples,)
        Base acceleration besides the waves [m/s²], linear in between.
    dt : float
        Length of an interval [s].
    n, s : int, float
        Where to begin: the interval, and the time within it [s].
    h : float
        Length of the last interval [s], at most `dt`.
    end : int
        The last interval.
    x_r, v_r, z, d
        The state there, and the direction as in `Trail`.
    jet : Jet
        To work in.
    trail, at : Trail, int
        Where to write the steps, and how many are written.
    log, count : Log, int
        The same for events.
    capacity : int
        Length of both.

    Returns
    -------
    n, s, x_r, v_r, z, d, at, count
        As given; `count` is -1 where the time no longer moves on.
    """
    z_least = law.tolerance * law.F_fs / law.sigma_0 if law.kind != STRIBECK else 0.0
    wish = NEVER
    stalled = 0
    calm = min(calm_length(waves), calm_plant(plant))
    pause, wait = 0, 0
    while n <= end and at + ENOUGH < capacity and count + ENOUGH < capacity:
        length = h if n == end else dt
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = n * dt + s
        u_0 = u_dd[n] + slope * s
        if d == 0 and law.kind != STRIBECK:
            # Whoever rested without a cause to move may have one now, to either side.
            d = first_heading(plant, law, waves, jet, u_0, slope, t, x_r, v_r, z)
            if law.kind == LEUVEN and d != 0:
                head(law, jet, sign(d), v_r, z)
            if d != 0:
                F_L = limit_force(plant, x_r, jet.u[0])
                count = note(log, count, n, s, REVERSAL * sign(d), x_r, F_L)
        at = mark(trail, at, n, s, x_r, v_r, z, d)
        left = length - s
        if d == 0 and law.kind == STRIBECK:
            looked = min(left, calm_length(waves))
            stay, side = end_of_stay(plant, law, waves, x_r, u_0, slope, t, looked)
            s = length if min(stay, looked) >= left else s + min(stay, looked)
            if stay != NEVER:
                d = 2 * side
                F_L = -side * law.F_fs
                count = note(log, count, n, s, side * SLIP, x_r, F_L)
        else:
            drive(jet, waves, u_0, slope, t)
            if law.kind == LEUVEN:
                set_slope(law, jet)
                trail.rise[at - 1], trail.bend[at - 1] = jet.slope[0], jet.slope[1]
            way = 1 if d >= 0 else -1
            v_least = law.tolerance * jet.scale[0]
            slow = slow_speed(law, jet)
            creeps = slow > 0.0 and way * v_r <= slow
            last, step, rounds, pause, wait = begin(
                plant, law, jet, d, x_r, v_r, z, creeps, left, min(left, calm), wish, v_least,
                z_least, pause, wait,
            )  # fmt: skip
            trail.terms[at - 1] = last
            if rounds > 0:
                trail.d[at - 1] = way * (SETTLED + rounds)
            elif creeps and abs(d) != 2:
                trail.d[at - 1] = way * SLOW
            step, stop, end_of_branch, what = extent(
                plant, law, jet, last, way, step, rounds > 0, creeps, slow, v_least
            )
            event = min(stop, end_of_branch)
            if slow > 0.0 and event == NEVER and step <= RESOLUTION * (t + step):
                event = stop = step
            crawls = min(event, step) <= RESOLUTION * (t + step) and min(event, step) < left
            stalled = stalled + 1 if crawls else 0
            if stalled > (0 if event == NEVER else STALL):
                return n, s, x_r, v_r, z, d, at, -1
            wish = 4.0 * step if step < left else NEVER
            step = min(event, step)
            s = length if step == left else min(s + step, length)
            x_r, v_r, z = state_at(jet, last, step)
            jet.scale[0] = max(jet.scale[0], abs(v_r))
            d = way if d != 0 else 0
            if law.kind == LEUVEN and step > 0.0:
                jet.branch[EVEN] = 0
            if end_of_branch < stop:
                z = end_branch(law, jet, what, z)
            if stop <= end_of_branch and stop != NEVER:
                v_r = 0.0
                F_L = limit_force(plant, x_r, value(jet.u, ORDER, step))
                d = first_heading(
                    plant, law, waves, jet, u_dd[n] + slope * s, slope, n * dt + s, x_r, v_r, z
                )
                if law.kind == LEUVEN and d != 0:
                    head(law, jet, sign(d), 0.0, z)
                # Bristles never stick: a mass that rests on them has no event until it moves.
                if d != 0 or law.kind == STRIBECK:
                    count = note(log, count, n, s, REVERSAL * sign(d), x_r, F_L)
        if s >= length:
            n += 1
            s = 0.0
    return n, s, x_r, v_r, z, d, at, count
