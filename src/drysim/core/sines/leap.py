"""The exact solution under waves: leaps from event to event, with no grid in between."""

from __future__ import annotations

from drysim.core.compiled import compiled
from drysim.core.events import (
    REVERSAL,
    ROOM,
    ROUNDING,
    SLIP,
    STICK,
    Log,
    limit_force,
    note,
    opening,
    sign,
    tightness,
)
from drysim.core.samples.stop import NEVER
from drysim.core.sines.cease import leave_slip
from drysim.core.sines.leave import break_away
from drysim.core.sines.scene import V_R, X_R, unpacked
from drysim.core.sines.slide import slide
from drysim.core.waves import anchor, base_motion, normal_force

STALL = 100
"""Events in a row without progress in time that put a scene at the end of double precision."""


@compiled
def leap(plant, law, waves, u_0, slope, n, t, h, begin, x_r, v_r, d, log, count, capacity):
    """Solve one interval from event to event, or until the log is nearly full.

    Parameters
    ----------
    plant, law : Plant, Law
    waves : Waves
    u_0, slope : float
        Part of ü that is not waves: at the start of the interval [m/s²], and its rate [m/s³].
    n : int
        Number of the interval, for the log.
    t, h : float
        Start and length of the interval [s].
    begin : float
        Where in the interval to start [s].
    x_r, v_r, d
        State there [m, m/s] and direction of sliding, 0 when stuck.
    log : Log
    count, capacity : int
        Events already in the log, and its length.

    Returns
    -------
    begin, x_r, v_r, d, count, closest
        Time reached within the interval and the state there, events in the log
        (negative when they follow each other without end), tightest stop decision [-]. A leap
        that starts there goes on as if never stopped.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    closest = NEVER
    broke = False
    stalled = 0
    while begin < h and (broke or count + 2 <= capacity):
        before = begin
        anchor(waves, plant, law, t + begin, d)
        u_begin = u_0 + slope * begin
        left = h - begin
        if d == 0:
            stay, d = break_away(plant, law, waves, x_r, u_begin, slope, slope, left)
            if stay == NEVER:
                return h, x_r, 0.0, 0, count, closest
            begin = min(begin + stay, h)
            load = normal_force(law, waves, stay)[0]
            count = note(log, count, n, begin, d * SLIP, x_r, -d * law.F_fs * load)
            broke = True
            continue
        u_dd, rate, _ = base_motion(waves, u_begin, slope, 0.0)
        load, load_d, _ = normal_force(law, waves, 0.0)
        if broke:
            a = d * (law.F_fs - law.F_fk) * load / m
        else:
            a = -(u_dd + c * v_r + w * x_r + d * law.F_fk * load / m)
        broke = False
        j = -rate - d * law.F_fk * load_d / m - c * a - w * v_r
        g = -u_begin - d * law.F_fk / m
        stop, x_stop = leave_slip(c, w, waves, x_r, v_r, a, j, g, -slope, d, left)
        if stop == NEVER:
            x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, g, -slope, left)
            return h, x_r, v_r, d, count, closest
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > STALL:
            return begin, x_r, v_r, d, -1, closest
        x_r, v_r = x_stop, 0.0
        u_dd = base_motion(waves, u_begin, slope, stop)[0]
        F_L = limit_force(plant, x_r, u_dd)
        F_fs = law.F_fs * normal_force(law, waves, stop)[0]
        closest = min(closest, tightness(F_L, F_fs))
        if abs(F_L) <= F_fs + ROUNDING * (F_fs + abs(k_x * x_r)):
            d = 0
            count = note(log, count, n, begin, STICK, x_r, F_L)
        else:
            d = -sign(F_L)
            count = note(log, count, n, begin, d * REVERSAL, x_r, F_L)
    return begin, x_r, v_r, d, count, closest


@compiled
def leap_off(scene, end, log, kind):
    """Solve a scene under waves alone from t = 0 to `end` [s], or until the log is nearly full.

    Returns as in `leap`; it begins with the state at t = 0, and `closest` counts how near its
    mode is to the other.

    Parameters
    ----------
    scene : array
        As in `drysim.core.sines.scene`, its waves included.
    end : float
    log, kind : array
        The rows of a log as one array, and its kinds.
    """
    plant, law, waves = unpacked(scene)
    x_r, v_r = scene[X_R], scene[V_R]
    capacity = len(kind)
    log = Log(log[0], log[1], kind, log[2], log[3])
    anchor(waves, plant, law, 0.0, 0)
    u_dd = base_motion(waves, 0.0, 0.0, 0.0)[0]
    d, F_L, margin = opening(plant, law, x_r, v_r, u_dd)
    count = note(log, 0, 0, 0.0, d, x_r, F_L)
    begin, x_r, v_r, d, count, closest = leap(
        plant, law, waves, 0.0, 0.0, 0, 0.0, end, 0.0, x_r, v_r, d, log, count, capacity
    )
    return begin, x_r, v_r, d, count, min(closest, margin)


@compiled
def leap_steps(
    plant, law, waves, past, u_dd, dt, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, cap
):
    """March over samples where the friction limits vary: one leap a step; else like `march`.

    `past` is how many samples of the motion come before those that are given; `cap` is the
    capacity of the log.
    """
    closest = NEVER
    while n < end and count + ROOM <= cap:
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        reached, x_r, v_r, d, count, tight = leap(
            plant, law, waves, u_dd[n], slope, n, (past + n) * dt, dt, 0.0, x_r, v_r, d, log,
            count, cap
        )  # fmt: skip
        closest = min(closest, tight)
        if reached < dt or count < 0:
            return n, x_r, v_r, d, -1, closest
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, d, count, closest
