"""The exact solution under waves: leaps from event to event, with no grid in between.

The next zero is approached from below by steps that a bound on the curvature proves safe, so none is skipped;
near a simple zero the steps converge like Newton's, and a near miss is passed at its own distance.
"""

from __future__ import annotations

import math

from drysim.core.compiled import compiled
from drysim.core.march import REVERSAL, ROOM, SLIP, STICK, limit_force, note, sign, tightness
from drysim.core.slide import anchor, base_motion, margin, normal_force, slide
from drysim.core.stop import NEVER, RESOLUTION

STALL = 100
"""Events in a row without any progress in time after which a scene is at the end of double precision."""

TOUCH = 1e-6
"""A margin that is zero this close (in radians of the fastest wave) to its minimum only touches the limit."""


@compiled
def parabola(value, rate, bend):
    """Give the largest h up to which value + rate h - bend h²/2 stays above zero."""
    root = math.sqrt(rate * rate + 2.0 * bend * value)
    if rate <= 0.0:
        return 2.0 * value / (root - rate) if root > rate else NEVER
    return (rate + root) / bend if bend > 0.0 else NEVER


@compiled
def safe_step(value, rate, bend, growth, cap):
    """Give a step within which a function provably stays above zero.

    Parameters
    ----------
    value, rate : float
        Of the function now; value above 0.
    bend, growth : float
        Its second rate is at most bend + growth·h in magnitude after any h up to cap.
    cap : float
        Longest step.
    """
    reach = min(parabola(value, rate, bend), cap)
    if growth == 0.0 or reach == NEVER:
        return reach
    return min(parabola(value, rate, bend + growth * reach / 3.0), cap)


@compiled
def first_step(rate, bend, bend_bound, third_bound):
    """Give a step that provably leaves zero upwards; not above 0 where the function does not rise."""
    by_rate = rate / bend_bound if rate > 0.0 else 0.0
    by_bend = 1.5 * bend / third_bound if rate >= 0.0 and bend > 0.0 and third_bound > 0.0 else 0.0
    return max(by_rate, by_bend)


@compiled
def leave_slip(c, w, waves, x_r, v_r, a, j, g, r, d, h):
    """Give the first time in (0, h] at which sliding in direction d stops, or infinity.

    The jerk and its rate obey the oscillator's equation driven by ü", so
    |jerk|(s) <= sqrt(jerk² + w a²) + s·max|ü"|: the bound that makes every step safe.
    """
    growth = 0.0
    fastest = 0.0
    for i in range(len(waves.A)):
        growth += abs(waves.A[i]) * waves.omega[i] ** 2
        fastest = max(fastest, waves.omega[i])
    cap = 1.0 / fastest if fastest > 0.0 else NEVER
    s = 0.0
    v_r_0 = v_r
    v, a, j = d * v_r, d * a, d * j
    while True:
        bend = math.sqrt(j * j + w * a * a)
        if v > 0.0:
            step = safe_step(v, a, bend, growth, cap)
        else:
            bound = bend + growth * cap if growth > 0.0 else bend
            if bound == 0.0:
                return NEVER
            step = min(first_step(a, j, bound, (c + math.sqrt(w)) * bound + growth), cap)
            if step <= 0.0:
                return s
        if s + step >= h:
            # The end of the stretch lies within the safe step.
            return NEVER
        if step <= RESOLUTION * s:
            return s
        s += step
        _, v, a, j = slide(c, w, waves, x_r, v_r_0, g, r, s)
        v, a, j = d * v, d * a, d * j
        if v <= 0.0:
            return s


@compiled
def leave_stick(plant, law, waves, x_r, u_0, slope, side, h):
    """Give the first time in [0, h] at which |F_L| exceeds F_fs on one side, or infinity.

    A margin that only touches zero does not break away: equality sticks.
    """
    bend = 0.0
    third = 0.0
    fastest = 0.0
    for i in range(len(waves.A)):
        force = plant.m * abs(waves.A[i]) if i < waves.base else law.F_fs * law.variation
        omega = waves.omega[i]
        bend += force * omega**2
        third += force * omega**3
        fastest = max(fastest, omega)
    s = 0.0
    while True:
        G, G_d, G_dd = margin(plant, law, waves, x_r, u_0, slope, side, s)
        if G < 0.0:
            return s
        if G > 0.0:
            step = parabola(G, G_d, bend)
        elif bend == 0.0:
            step = NEVER if G_d >= 0.0 else 0.0
        else:
            step = first_step(G_d, G_dd, bend, third)
        if s + step > h:
            return NEVER
        if step <= RESOLUTION * s:
            if G_dd <= 0.0 or -G_d * fastest > TOUCH * G_dd:
                return s
            step = -G_d / G_dd
            G = margin(plant, law, waves, x_r, u_0, slope, side, s + step)[0]
            if G < 0.0 or s + step == s:
                return s
        s += step


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
        (negative when they follow each other without end), tightest stop decision [-]. A leap that starts there goes on as if never stopped.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    closest = NEVER
    broke = False
    stalled = 0
    while begin < h and (broke or count + 2 <= capacity):
        before = begin
        anchor(waves, law, m, t + begin, d)
        u_begin = u_0 + slope * begin
        left = h - begin
        if d == 0:
            up = leave_stick(plant, law, waves, x_r, u_begin, slope, 1, left)
            down = leave_stick(plant, law, waves, x_r, u_begin, slope, -1, min(up, left))
            stay = min(up, down)
            if stay == NEVER:
                return h, x_r, 0.0, 0, count, closest
            d = 1 if down < up else -1
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
        stop = leave_slip(c, w, waves, x_r, v_r, a, j, g, -slope, d, left)
        x_r, v_r, _, _ = slide(c, w, waves, x_r, v_r, g, -slope, min(stop, left))
        if stop == NEVER:
            return h, x_r, v_r, d, count, closest
        begin = min(begin + stop, h)
        stalled = 0 if begin > before else stalled + 1
        if stalled > STALL:
            return begin, x_r, v_r, d, -1, closest
        v_r = 0.0
        u_dd = base_motion(waves, u_begin, slope, stop)[0]
        F_L = limit_force(plant, x_r, u_dd)
        F_fs = law.F_fs * normal_force(law, waves, stop)[0]
        closest = min(closest, tightness(F_L, F_fs))
        if abs(F_L) <= F_fs:
            d = 0
            count = note(log, count, n, begin, STICK, x_r, F_L)
        else:
            d = -sign(F_L)
            count = note(log, count, n, begin, d * REVERSAL, x_r, F_L)
    return begin, x_r, v_r, d, count, closest


@compiled
def leap_steps(
    plant, law, waves, u_dd, dt, n, end, x_r, v_r, d, x_out, v_out, d_out, log, count, capacity
):
    """March over samples where the friction limits vary: one leap a step; otherwise like `march`."""
    closest = NEVER
    while n < end and count + ROOM <= capacity:
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        reached, x_r, v_r, d, count, tight = leap(
            plant, law, waves, u_dd[n], slope, n, n * dt, dt, 0.0, x_r, v_r, d, log, count, capacity
        )  # fmt: skip
        closest = min(closest, tight)
        if reached < dt or count < 0:
            return n, x_r, v_r, d, -1, closest
        n += 1
        x_out[n] = x_r
        v_out[n] = v_r
        d_out[n] = d
    return n, x_r, v_r, d, count, closest


@compiled
def state_within(plant, law, waves, u_0, slope, t, x_r, v_r, d, s):
    """Give x_r and v_r at time s of a stretch that starts at time t with the given state and direction."""
    if d == 0:
        return x_r, 0.0
    anchor(waves, law, plant.m, t, d)
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    return slide(c, w, waves, x_r, v_r, -u_0 - d * law.F_fk / plant.m, -slope, s)[:2]


@compiled
def sample_leaps(plant, law, waves, t, kind, x_r, v_first, dt, x_out, v_out, d_out):
    """Write a solution under waves on the grid n·dt.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        The events; the first is the start of the run, with velocity `v_first` [m/s].
    dt : float
        Distance of the grid points [s].
    x_out, v_out, d_out : array, shape (n,)
        Written.
    """
    event = 0
    for n in range(len(x_out)):
        while event + 1 < len(t) and t[event + 1] <= n * dt:
            event += 1
        d = 1 if kind[event] > 0 else (-1 if kind[event] < 0 else 0)
        v_r = v_first if event == 0 else 0.0
        x_out[n], v_out[n] = state_within(
            plant, law, waves, 0.0, 0.0, t[event], x_r[event], v_r, d, n * dt - t[event]
        )
        d_out[n] = d
