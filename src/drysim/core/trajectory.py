"""Trajectory of an exact solution: state at any time, output grids, integrals, turning points.

Problem
    A march (`core.march`, `core.sampled`) returns only the start of every segment: time, state
    and mode. Everything else is derived here from these values without a new solution.

Method
    Within a segment the motion has a closed form, so no interpolation error arises.

    - State at any time: the flow of the segment, `motion_at`.
    - Output grid under sines: the flow and the sine responses over 0, 1, ... grid steps are
      tabulated once. Every grid point is then a linear combination of table columns and does
      not depend on the point before it.
    - Integrals: Gauss-Legendre quadrature on panels of at most `PANEL_RADIANS` of the fastest
      rate that is still present, with an error below rounding; quadratic forms of the state for
      whole sampled steps; sums of complex exponentials for long holding segments.
    - Turning points of x_r: v_r = 0 within a segment. Between two of them x_r is monotone, so
      peaks, zero crossings and crossings of the stroke limit follow from them and none is
      missed.

A solution with Coulomb friction is stored as its events: v_r is 0 after each event except the
first. Every other solution is stored as `Segments`; segment i starts at the time segments.s[i]
within step segments.n[i]. Kernels that evaluate segments expect ascending times.
"""

from __future__ import annotations

import cmath
import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from drysim.core.compile import compiled, inlined
from drysim.core.events import direction_after, motion_direction, sign
from drysim.core.forcing import (
    COSINE,
    FREQUENCY,
    IN_PHASE,
    OMEGA,
    PHASE,
    QUADRATURE,
    SINE,
    STEADY,
    STEADY_V,
    STEADY_X,
    THETA,
    V_R,
    WAVE_COLUMNS,
    A,
    base_motion,
    motion_at,
    relative_normal_force,
    response_from_rest,
    set_phases,
    start_segment,
    unpack_scene,
)
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_REST,
    CHATTERING,
    HOLD,
    bumper_force,
    bumper_line,
    chatter_mean_square,
    contact_force,
    coulomb_limits,
    decode_mode,
    effective_plant,
    friction_and_stop_forces,
    is_rigid_slip,
    load_at,
    mode_equation,
    origin_of,
    return_accelerations,
    safe_until,
    side_of,
    touches_bumper,
    transient_response,
)
from drysim.core.oscillator import (
    SHORT_SEGMENT,
    UNDERDAMPED_SHARE,
    flow,
    free_response,
    higher_series_factors,
    long_velocity_series,
    series_acceleration,
    series_distance,
    series_factors,
    series_velocity,
    sine_response,
)
from drysim.core.roots import MAX_BISECTIONS, NEVER, RESOLUTION, slip_exit_time

# Gauss-Legendre nodes and weights on [0, 1], as literals: importing them from numpy is slow.


SIX_NODES = (
    0.03376524289842399, 0.16939530676686773, 0.38069040695840156, 0.6193095930415985,
    0.8306046932331322, 0.966234757101576,
)  # fmt: skip
SIX_WEIGHTS = (
    0.08566224618958518, 0.1803807865240693, 0.23395696728634552, 0.23395696728634552,
    0.1803807865240693, 0.08566224618958518,
)  # fmt: skip

TWELVE_NODES = (
    0.009219682876640378, 0.0479413718147626, 0.11504866290284765, 0.20634102285669126,
    0.31608425050090994, 0.43738329574426554, 0.5626167042557344, 0.6839157494990901,
    0.7936589771433087, 0.8849513370971523, 0.9520586281852375, 0.9907803171233596,
)  # fmt: skip
TWELVE_WEIGHTS = (
    0.023587668193255706, 0.05346966299765953, 0.08003916427167321, 0.10158371336153287,
    0.1167462682691773, 0.12457352290670134, 0.12457352290670134, 0.1167462682691773,
    0.10158371336153287, 0.08003916427167321, 0.05346966299765953, 0.023587668193255706,
)  # fmt: skip


# State at any time between events.


@compiled
def segment_state(plant, law, waves, u_0, slope, t, x_r, v_r, d, s):
    """Return x_r and v_r at time s [s] of a segment that starts at time t in state x_r, v_r, d.

    `u_0` and `slope` are the part of ü besides the waves at its start [m/s²] and its rate
    [m/s³].
    """
    if d == 0:
        return x_r, 0.0
    set_phases(waves, plant, law, t, d)
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    return motion_at(c, w, waves, x_r, v_r, -u_0 - d * law.F_fk / plant.m, -slope, s)[:2]


@compiled
def state_at(plant, law, waves, t, kind, x_r, v_first, at):
    """Return x_r [m] and v_r [m/s] at the time `at` [s] of a solution stored as events.

    Parameters
    ----------
    t, kind, x_r : array, shape (events,)
        Time [s], kind and displacement [m] of the events; the first event is the start.
    v_first : float
        Velocity at the start [m/s]; it is 0 at every later event.
    at : float
        Time, not before the first event [s].
    """
    i = last_event_index(t, at)
    v_r = v_first if i == 0 else 0.0
    d = direction_after(kind[i])
    return segment_state(plant, law, waves, 0.0, 0.0, t[i], x_r[i], v_r, d, at - t[i])


@inlined
def last_event_index(t, at):
    """Return the index of the last event at or before a time [s], by bisection."""
    low, high = 0, len(t)
    while high - low > 1:
        middle = (low + high) // 2
        if t[middle] <= at:
            low = middle
        else:
            high = middle
    return low


# States on a grid under sines: linear combinations of table columns.


TABLE_ROWS = 128
"""Number of grid steps in the table: a few kilobytes per wave, computed once per grid."""

FLOW_COLUMNS = 3
"""Columns of the free motion: y, y_d and Y of `flow`."""

ANGLE_COLUMN = 3
"""First of the two columns of a wave that hold its sine and cosine."""

RESPONSE_COLUMNS = 5
"""Columns of a wave: R, P and P_d of `sine_response`, or sin(omega s)/omega, cos(omega s)
and the derivative of the latter where the steady response is used; then sin(omega s) and
cos(omega s)."""


def table_size(size: int) -> int:
    """Return the length of the table for a number of waves."""
    return TABLE_ROWS * (FLOW_COLUMNS + RESPONSE_COLUMNS * size)


@compiled
def sample_coulomb_grid(scene, t, kind, x_r, first, dt, table, out, d_out):
    """Write a solution with Coulomb friction under waves at the grid points n·dt.

    Parameters
    ----------
    scene : array
        Plant, law, start and waves as in `drysim.core.forcing`.
    t, kind, x_r : array, shape (events,)
        Time [s], kind and displacement [m] of the events; the first event is the start.
    first : int
        Index of the first grid point.
    dt : float
        Grid spacing [s].
    table : array, shape (`table_size`,)
        Work space for the responses over whole grid steps.
    out, d_out : array, shape (2, n) and (n,)
        Written: x_r [m] and v_r [m/s], and the direction of sliding.

    Notes
    -----
    The sums restart at every `TABLE_ROWS`-th point after an event, counted from the event and
    not from `first`. The result is therefore independent of the blocks in which a grid is
    written.
    """
    plant, law, waves = unpack_scene(scene)
    x_out, v_out = out[0], out[1]
    last = first + len(d_out)
    filled = 0
    event = last_event_index(t, first * dt)
    n = first
    set_phases(waves, plant, law, t[0], 0)
    while n < last:
        while event + 1 < len(t) and t[event + 1] <= n * dt:
            event += 1
        d = direction_after(kind[event])
        until = last
        if event + 1 < len(t):
            until = min(until, grid_index_before(t[event + 1], dt) + 1)
        if d == 0:
            for k in range(n - first, until - first):
                x_out[k] = x_r[event]
                v_out[k] = 0.0
                d_out[k] = 0
            n = until
            continue
        begin = grid_index_before(t[event], dt) + 1
        v_r = scene[V_R] if event == 0 else 0.0
        while n < until:
            start = n - (n - begin) % TABLE_ROWS
            end = min(until, start + TABLE_ROWS)
            filled = fill_table(plant, waves, dt, table, filled, end - start)
            sample_slip(
                plant, law, waves, table, t[event], x_r[event], v_r, d, start, n, end, first,
                dt, x_out, v_out, d_out,
            )  # fmt: skip
            n = end


@inlined
def sample_slip(
    plant, law, waves, table, t, x_r, v_r, d, start, n, end, first, dt, x_out, v_out, d_out
):
    """Write the grid points n to end - 1 of a slip segment, with the direction of sliding."""
    g, at = -d * law.F_fk / plant.m, n - first
    write_segment(
        plant, law, waves, table, t, x_r, v_r, d, g, start, n, end, first, dt, x_out, v_out
    )
    if write_direction(d, at, end - n, v_out, d_out):
        return
    for k in range(at, end - first):
        if v_out[k] * d <= 0.0:
            # The sum of columns may have the wrong sign where |v_r| is of the size of rounding.
            s = (first + k) * dt - t
            x_out[k], v_out[k] = segment_state(plant, law, waves, 0.0, 0.0, t, x_r, v_r, d, s)


@inlined
def write_direction(d, at, rows, v_out, d_out):
    """Write the direction of sliding; return whether all velocities have its sign."""
    if at < 0:
        # Never true, but it tells the compiler that no index wraps around.
        return False
    for k in range(rows):
        d_out[at + k] = d
    against = 0
    for k in range(rows):
        against += v_out[at + k] * d <= 0.0
    return against == 0


@compiled
def sample_elastic_grid(solution, first, dt, tables, out):
    """Write a solution with an elastic contact under waves at the grid points n·dt.

    Parameters
    ----------
    solution : Solution
        The first segment starts at or before the first grid point.
    first, dt
        As in `sample_coulomb_grid`.
    tables : array, shape (2, `table_size`)
        Work space for the tables of the oscillator without and with the contact stiffness.
    out : Columns
        Written: x_r, v_r, F_f and d.
    """
    plant, law, waves, _, _, segments = solution
    slip_table, hold_table = tables
    last = first + len(out.x_r)
    n, filled_slip, filled_hold = first, 0, 0
    for i in range(len(segments.s)):
        until = last
        if i + 1 < len(segments.s):
            until = min(last, grid_index_before(segments.s[i + 1], dt) + 1)
        t, x_0, mode = segments.s[i], segments.z[i], decode_mode(segments.d[i])
        d = mode.contact if abs(mode.contact) == 1 else 0
        limits, effective = coulomb_limits(law, d), effective_plant(plant, law, mode)
        g = -d * limits.F_fk / plant.m
        if mode.contact == HOLD:
            g = law.k_t * x_0 / plant.m
        begin = grid_index_before(t, dt) + 1 if until > n else n
        while n < until:
            start = n - (n - begin) % TABLE_ROWS
            end = min(until, start + TABLE_ROWS)
            # Whether a steady response is usable depends on the stiffness.
            set_phases(waves, effective, limits, t, d)
            if mode.contact == HOLD:
                table = hold_table
                filled_hold = fill_table(effective, waves, dt, table, filled_hold, end - start)
            else:
                table = slip_table
                filled_slip = fill_table(effective, waves, dt, table, filled_slip, end - start)
            write_segment(
                effective, limits, waves, table, t, segments.x_r[i], segments.v_r[i], d, g,
                start, n, end, first, dt, out.x_r, out.v_r,
            )  # fmt: skip
            for k in range(n, end):
                at = k - first
                load = 1.0
                if d != 0 and law.variation > 0.0:
                    load = max(relative_normal_force(law, waves, (k - start) * dt)[0], 0.0)
                out.F_f[at] = contact_force(law, mode, out.x_r[at], x_0, load)
                out.d[at] = -1 if out.v_r[at] < 0.0 else 1
            n = end


@inlined
def write_segment(
    plant, law, waves, table, t, x_r, v_r, d, g, start, n, end, first, dt, x_out, v_out
):
    """Write the grid points n to end - 1 of a segment from its state at grid point `start`.

    The segment starts at time t [s] and has the constant force per mass g [m/s²]. The motion is
    the steady response plus a free motion that starts with the difference from it.
    """
    w = plant.k_x / plant.m
    set_phases(waves, plant, law, t, d)
    x, v = transient_state(plant.b / plant.m, w, waves, x_r, v_r, g, start * dt - t)
    set_phases(waves, plant, law, start * dt, d)
    row, at = n - start, n - first
    from_sine, from_cosine = wave_coefficients(waves, 0) if waves.size > 0 else (0.0, 0.0)
    write_motion(table, row, end - n, x, v, g - w * x, from_sine, from_cosine, at, x_out, v_out)
    for i in range(1, waves.size):
        from_sine, from_cosine = wave_coefficients(waves, i)
        add_wave_response(table, i, row, end - n, from_sine, from_cosine, at, x_out, v_out)


@inlined
def wave_coefficients(waves, i):
    """Return the coefficients of the sine and cosine columns of wave i at row 0."""
    values, wave = waves.values, WAVE_COLUMNS * i
    if values[wave + STEADY] > 0.0:
        return values[wave + STEADY_V], values[wave + STEADY_X]
    push = -values[wave + A]
    return push * values[wave + COSINE] * values[wave + OMEGA], push * values[wave + SINE]


@inlined
def transient_state(c, w, waves, x_r, v_r, g, s):
    """Return x_r and v_r at time s of a segment minus the steady response to the waves.

    A wave without a usable steady response contributes its response from rest instead.
    Parameters as in `motion_at`.
    """
    values = waves.values
    y, y_d, Y = free_response(c, w, s)
    x, v = 0.0, 0.0
    for i in range(waves.size):
        at = WAVE_COLUMNS * i
        if values[at + STEADY] > 0.0:
            x_r -= values[at + STEADY_X]
            v_r -= values[at + STEADY_V]
        else:
            x_wave, v_wave, _, _, _ = response_from_rest(c, w, values, at, s, y, y_d)
            x += x_wave
            v += v_wave
    push = g - w * x_r
    return x + x_r + v_r * y + push * Y, v + v_r * y_d + push * y


@inlined
def write_motion(table, row, rows, x_r, v_r, push, from_sine, from_cosine, at, x_out, v_out):
    """Write the free motion from a state [m, m/s] under a constant force per mass [m/s²].

    The response to the first wave is included, with coefficients as in `add_wave_response`.
    """
    if row < 0 or at < 0:
        # Never true, but it tells the compiler that no index wraps around.
        return
    # Offsets computed outside the loop, so that the compiler vectorises the loads.
    second, third = row + TABLE_ROWS, row + 2 * TABLE_ROWS
    # Without a wave both coefficients are 0, and any existing column will do.
    wave = row + FLOW_COLUMNS * TABLE_ROWS if from_sine != 0.0 or from_cosine != 0.0 else row
    wave_second, wave_third = wave + TABLE_ROWS, wave + 2 * TABLE_ROWS
    for k in range(rows):
        y, y_d, Y = table[row + k], table[second + k], table[third + k]
        R, P, P_d = table[wave + k], table[wave_second + k], table[wave_third + k]
        x_out[at + k] = x_r + (v_r * y + push * Y) + (from_sine * R + from_cosine * P)
        v_out[at + k] = (v_r * y_d + push * y) + (from_sine * P + from_cosine * P_d)


@inlined
def add_wave_response(table, i, row, rows, from_sine, from_cosine, at, x_out, v_out):
    """Add the response to wave i: its sine and cosine columns times their coefficients."""
    begin = row + TABLE_ROWS * (FLOW_COLUMNS + RESPONSE_COLUMNS * i)
    if begin < 0 or at < 0:
        # Never true, but it tells the compiler that no index wraps around.
        return
    second, third = begin + TABLE_ROWS, begin + 2 * TABLE_ROWS
    for k in range(rows):
        R, P, P_d = table[begin + k], table[second + k], table[third + k]
        x_out[at + k] += from_sine * R + from_cosine * P
        v_out[at + k] += from_sine * P + from_cosine * P_d


@compiled
def fill_table(plant, waves, dt, table, begin, end):
    """Write the rows `begin` to end - 1 of the table; return the number of valid rows.

    The phases of the waves must be set at some time, because `set_phases` decides which waves
    have a usable steady response.
    """
    c, w = plant.b / plant.m, plant.k_x / plant.m
    for k in range(begin, end):
        s = k * dt
        y, y_d, Y = free_response(c, w, s)
        table[k] = y
        table[TABLE_ROWS + k] = y_d
        table[2 * TABLE_ROWS + k] = Y
        for i in range(waves.size):
            at = TABLE_ROWS * (FLOW_COLUMNS + RESPONSE_COLUMNS * i) + k
            omega = waves.values[WAVE_COLUMNS * i + OMEGA]
            if waves.values[WAVE_COLUMNS * i + STEADY] > 0.0:
                R, P = math.sin(omega * s) / omega if omega > 0.0 else s, math.cos(omega * s)
                P_d = -omega * omega * R
            else:
                R, P, P_d, _, _ = sine_response(c, w, omega, s, y, y_d)
            table[at] = R
            table[at + TABLE_ROWS] = P
            table[at + 2 * TABLE_ROWS] = P_d
    return max(begin, end)


@inlined
def grid_index_before(t, dt):
    """Return the index of the last grid point before time t [s]; -1 if there is none."""
    n = int(t / dt)
    while n * dt >= t:
        n -= 1
    while (n + 1) * dt < t:
        n += 1
    return n


@compiled
def sample_base_grid(waves, first, dt, table, u_out):
    """Write ü of the waves [m/s²] at the grid points n·dt, from index `first` on.

    Within `TABLE_ROWS` points, each wave is expanded by the addition theorem about the first
    point.
    """
    values = waves.values
    last = first + len(u_out)
    for k in range(len(u_out)):
        u_out[k] = 0.0
    for i in range(waves.base):
        wave, at = (
            WAVE_COLUMNS * i,
            TABLE_ROWS * (FLOW_COLUMNS + RESPONSE_COLUMNS * i + ANGLE_COLUMN),
        )
        omega = values[wave + OMEGA]
        for k in range(TABLE_ROWS):
            table[at + k] = math.sin(omega * (k * dt))
            table[at + TABLE_ROWS + k] = math.cos(omega * (k * dt))
        f, phase, A_i = values[wave + FREQUENCY], values[wave + PHASE], values[wave + A]
        start = first - first % TABLE_ROWS
        while start < last:
            theta = 2.0 * math.pi * ((f * (start * dt)) % 1.0) + phase
            n, end = max(first, start), min(last, start + TABLE_ROWS)
            add_wave_acceleration(
                table, i, n - start, end - n, A_i * math.sin(theta), A_i * math.cos(theta),
                n - first, u_out,
            )  # fmt: skip
            start = end


@compiled
def add_wave_acceleration(table, i, row, rows, sine, cosine, at, u_out):
    """Add the acceleration of a wave whose sine and cosine parts at row 0 are given [m/s²]."""
    begin = row + TABLE_ROWS * (FLOW_COLUMNS + RESPONSE_COLUMNS * i + ANGLE_COLUMN)
    if begin < 0 or at < 0:
        # Never true, but it tells the compiler that no index wraps around.
        return
    second = begin + TABLE_ROWS
    for k in range(rows):
        u_out[at + k] += sine * table[second + k] + cosine * table[begin + k]


# Integrals over segments of Coulomb friction, by panels.


PANEL_RADIANS = 4.0
"""Radians (or decays) per panel. A square varies twice as fast: twelve nodes integrate
exp(±2i·4) with an error of 4e-17."""

NEGLIGIBLE_DECAYS = 90.0
"""A motion that decays at rate c/2 is below double precision after the time 90/c."""


@compiled
def panel_length(c, w, waves, s):
    """Return the length of the quadrature panel that starts at time s of a segment [s]."""
    rate = 0.0
    for i in range(waves.size):
        rate = max(rate, waves.values[WAVE_COLUMNS * i + OMEGA])
    rate = max(rate, fastest_rate(c, w, s))
    return PANEL_RADIANS / rate if rate > 0.0 else math.inf


@compiled
def fastest_rate(c, w, s):
    """Return the fastest rate of the oscillator still present at time s of a segment [1/s]."""
    if c * s < NEGLIGIBLE_DECAYS:
        return c + math.sqrt(w)
    return w / (0.5 * c + math.sqrt(0.25 * c * c - w)) if 0.25 * c * c > w else 0.0


@compiled
def integrate_coulomb_events(plant, law, waves, t, kind, x_r, v_first, begin, end):
    """Integrate a solution under waves from `begin` to `end` [s].

    The solution is given by its events as in `state_at`. Returns x2, v2, x_dd2, power,
    sliding_distance and stuck as in `Totals`.
    """
    sums, stuck = (0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    for i in range(len(t)):
        until = min(t[i + 1], end) if i + 1 < len(t) else end
        if until <= begin or until <= t[i]:
            continue
        d = direction_after(kind[i])
        v_r = v_first if i == 0 else 0.0
        lo = max(begin - t[i], 0.0)
        part = integrate_by_panels(
            plant, law, waves, 0.0, 0.0, t[i], x_r[i], v_r, d, lo, until - t[i]
        )
        sums = add_sums(sums, part)
        if d == 0:
            stuck += until - t[i] - lo
    return *sums, stuck


@compiled
def integrate_coulomb_steps(
    plant, law, waves, u_dd, dt, first, steps, x_r, v_r, d, log, begin, end
):
    """Integrate selected steps of a sampled march; they may hold events or ends of the window.

    Parameters
    ----------
    u_dd : array, shape (samples,)
        Base acceleration [m/s²].
    dt : float
        Sampling interval [s].
    first : int
        Number of samples of the motion before the first one in `u_dd`.
    steps : array of int, shape (steps,)
        Indices of the steps, ascending; like those in the log, they count from `first`.
    x_r, v_r, d : array, shape (samples,)
        State [m, m/s] and direction of sliding at the samples.
    log : EventLog
        Events of the march, ascending.
    begin, end : float
        Window of integration [s].

    Returns
    -------
    x2, v2, x_dd2, power, sliding_distance, stuck : float
        As in `Totals`.
    """
    sums, stuck, event = (0.0, 0.0, 0.0, 0.0, 0.0), 0.0, 0
    for i in range(len(steps)):
        n = steps[i]
        while event < len(log.n) and log.n[event] < n:
            event += 1
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        t = (first + n) * dt
        start, x, v, mode = 0.0, x_r[n], v_r[n], d[n]
        has_event = True
        while has_event:
            has_event = event < len(log.n) and log.n[event] == n
            stop = log.s[event] if has_event else dt
            lo = max(begin - t - start, 0.0)
            hi = min(end - t, stop) - start
            if hi > lo:
                part = integrate_segment(
                    plant, law, waves, u_dd[n] + slope * start, slope, t + start,
                    x, v, mode, lo, hi,
                )  # fmt: skip
                sums = add_sums(sums, part)
                if mode == 0:
                    stuck += hi - lo
            if has_event:
                start, x, v, mode = stop, log.x_r[event], 0.0, direction_after(log.kind[event])
                event += 1
    return *sums, stuck


@inlined
def add_sums(sums, more):
    """Return the elementwise sum of two tuples (x2, v2, x_dd2, power, sliding_distance)."""
    x2, v2, x_dd2, power, sliding_distance = sums
    return (
        x2 + more[0],
        v2 + more[1],
        x_dd2 + more[2],
        power + more[3],
        sliding_distance + more[4],
    )


@compiled
def integrate_segment(plant, law, waves, u_0, slope, t, x_r, v_r, d, lo, hi):
    """Integrate one segment of Coulomb friction.

    Parameters
    ----------
    u_0, slope : float
        Part of ü besides the waves at the start of the segment [m/s²], and its rate [m/s³].
    t, x_r, v_r, d
        Start of the segment [s], state there [m, m/s] and direction of sliding, 0 when stuck.
    lo, hi : float
        Limits of integration, counted from the start [s].

    Returns
    -------
    x2, v2, x_dd2, power, sliding_distance : float
        As in `Totals`.
    """
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    f = d * law.F_fk / m
    if (
        d != 0
        and lo == 0.0
        and waves.size == 0
        and (c + math.sqrt(w)) * hi <= NEGLIGIBLE_DECAYS
    ):
        # Without waves, panels by series halve the time until the free motion has decayed.
        factors = series_factors(c, w)
        return integrate_slip_series(
            c, w, f, factors, higher_series_factors(factors, c, w), u_0, slope, x_r, v_r, d, hi
        )
    return integrate_by_panels(plant, law, waves, u_0, slope, t, x_r, v_r, d, lo, hi)


@compiled
def integrate_by_panels(plant, law, waves, u_0, slope, t, x_r, v_r, d, lo, hi):
    """Integrate one segment by Gauss quadrature on panels; as `integrate_segment`."""
    m, k_x, b = plant
    c = b / m
    w = k_x / m
    f = d * law.F_fk / m
    set_phases(waves, plant, law, t, d)
    x2, v2, x_dd2, power, sliding_distance = 0.0, 0.0, 0.0, 0.0, 0.0
    s = lo
    while s < hi:
        active = (c, w) if d != 0 else (0.0, 0.0)  # a stuck mass has no free motion
        length = min(panel_length(active[0], active[1], waves, s), hi - s)
        for i in range(len(TWELVE_NODES)):
            at = s + length * TWELVE_NODES[i]
            weight = length * TWELVE_WEIGHTS[i]
            u_dd = base_motion(waves, u_0, slope, at)[0]
            if d == 0:
                x_dd2 += weight * u_dd * u_dd
                continue
            load = relative_normal_force(law, waves, at)[0]
            x, v, _, _ = motion_at(c, w, waves, x_r, v_r, -u_0 - f, -slope, at)
            x_dd = -(w * x + c * v + f * load)
            x2 += weight * x * x
            v2 += weight * v * v
            x_dd2 += weight * x_dd * x_dd
            power += weight * u_dd * v
            sliding_distance += weight * load * abs(v)
        s = s + length if length < hi - s else hi
    if d == 0:
        x2 = x_r * x_r * (hi - lo)
    return x2, v2, x_dd2, power, sliding_distance


# Integrals of slip without waves: velocity series, and whole sampled steps.


@compiled
def integrate_slip_series(c, w, f, factors, more, u_0, slope, x_r, v_r, d, h):
    """Integrate a slip segment of any length with linear ü, by velocity series on short panels.

    `f` is the friction force per mass with its sign [m/s²]. Returns x2, v2, x_dd2, power and
    sliding_distance as in `Totals`.
    """
    radians = c + math.sqrt(w)
    longest = SHORT_SEGMENT / radians if radians > 0.0 else math.inf
    a = -(u_0 + c * v_r + w * x_r + f)
    x2, v2, x_dd2, power, x, s = 0.0, 0.0, 0.0, 0.0, x_r, 0.0
    while s < h:
        length = min(longest, h - s)
        q = long_velocity_series(factors, more, v_r, a, -slope - c * a - w * v_r)
        u = u_0 + slope * s
        sums = gauss_sums(q, c, w, f, u, slope, x, length)
        x2, v2 = x2 + sums[0], v2 + sums[1]
        x_dd2, power = x_dd2 + sums[2], power + sums[3]
        x, v_r, a = (
            x + series_distance(q, length),
            series_velocity(q, length),
            series_acceleration(q, length),
        )
        s += length
    return x2, v2, x_dd2, power, d * (x - x_r)


@inlined
def gauss_sums(q, c, w, f, u_0, slope, x_r, h):
    """Return x2, v2, x_dd2 and power by Gauss quadrature of a motion with velocity series q.

    Six nodes suffice where `long_velocity_series` holds: the error is below (2·0.5)¹²/10¹⁵.
    """
    x2, v2, x_dd2, power = 0.0, 0.0, 0.0, 0.0
    for i in range(len(SIX_NODES)):
        s = h * SIX_NODES[i]
        x, v = x_r + series_distance(q, s), series_velocity(q, s)
        x_dd = w * x + c * v + f
        x2 += SIX_WEIGHTS[i] * x * x
        v2 += SIX_WEIGHTS[i] * v * v
        x_dd2 += SIX_WEIGHTS[i] * x_dd * x_dd
        power += SIX_WEIGHTS[i] * (u_0 + slope * s) * v
    return h * x2, h * v2, h * x_dd2, h * power


def step_variables(c, w, f, x_r, v_r, u_0, u_1):
    """Return the variables of sampled slip steps in which the integrals do not cancel.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²].
    f : array, shape (steps,)
        Friction force per mass, d F_fk/m [m/s²].
    x_r, v_r, u_0, u_1 : array, shape (steps,)
        State at the start of the steps [m, m/s], and ü at both ends [m/s²].

    Returns
    -------
    ndarray, shape (6, steps)
        x_r; v_r; ü + w x_r + f at the start; the increment of ü; ü at the start; and
        -x_dd = c v_r + w x_r + f at the start, with x_dd the absolute acceleration.

    Notes
    -----
    Spring force and friction may nearly balance. Then x_dd and the displacement increment are
    far smaller than either, and expanding their squares would cancel. The differences are
    therefore formed once, here, and integrated as variables of their own.
    """
    rows = np.empty((6, len(x_r)))
    rows[0] = x_r
    rows[1] = v_r
    contact = w * x_r
    contact += f
    np.add(u_0, contact, out=rows[2])
    np.subtract(u_1, u_0, out=rows[3])
    rows[4] = u_0
    np.multiply(v_r, c, out=rows[5])
    rows[5] += contact
    return rows


@lru_cache(maxsize=64)
def step_quadratic_forms(c, w, dt):
    """Return the quadratic forms that integrate a whole slip step in its `step_variables`.

    Parameters
    ----------
    c, w, dt : float
        b/m [1/s], k_x/m [1/s²] and length of the step [s].

    Returns
    -------
    squares : ndarray, shape (4, 6, 6)
        Quadratic forms of the integrals of x_r², v_r², x_dd² and ü v_r.
    distance : ndarray, shape (6,)
        Linear form of the integral of v_r, the distance slid.

    Notes
    -----
    Cached: the cases of an ensemble share oscillator and step.
    """
    squares = np.zeros((4, 6, 6))
    begin = 0.0
    while begin < dt:
        rate = fastest_rate(c, w, begin)
        length = min(PANEL_RADIANS / rate, dt - begin) if rate > 0.0 else dt - begin
        for node, weight in zip(TWELVE_NODES, TWELVE_WEIGHTS, strict=True):
            s = begin + length * node
            y, y_d, Y, YY = flow(c, w, s)
            x = np.array([1.0, y, -Y, -YY / dt, 0.0, 0.0])
            v = np.array([0.0, y_d, -y, -Y / dt, 0.0, 0.0])
            u_dd = np.array([0.0, 0.0, 0.0, s / dt, 1.0, 0.0])
            x_dd = np.array([0.0, -w * y, 0.0, (c * Y + w * YY) / dt, c * y + w * Y, -y_d])
            for square, one, other in zip(
                squares, (x, v, x_dd, u_dd), (x, v, x_dd, v), strict=True
            ):
                square += weight * length * np.outer(one, other)
        begin = begin + length if length < dt - begin else dt
    y, _, Y, YY = flow(c, w, dt)
    distance = np.array([0.0, y, -Y, -YY / dt, 0.0, 0.0])
    squares.flags.writeable = distance.flags.writeable = False  # shared by all callers
    return squares, distance


FORM_VARIABLES = (
    ((0, 1, 2, 3), (0, 1, 2, 3)), ((1, 2, 3), (1, 2, 3)), ((1, 3, 4, 5), (1, 3, 4, 5)),
    ((3, 4), (1, 2, 3)),
)  # fmt: skip
"""The `step_variables` whose products occur in the integrals of x_r², v_r², x_dd² and ü v_r;
the forms of all other products are zero."""

FORM_COLUMNS = 10 + 6 + 10 + 6 + 3 + 4
"""Coefficients of these products, of v_r and of x_r in a row of `whole_step_forms`."""


def whole_step_forms(plant, law, dt):
    """Return the forms that integrate whole sampled steps of a `KernelLaw`.

    Returns
    -------
    ndarray, shape (4, FORM_COLUMNS)
        One row each for slip up, slip down, hold up and hold down, see `form_row`.
    """
    m, k_x, _ = plant
    return np.array(
        [
            whole_step_form(side.b / m, (k_x + k_t) / m, dt)
            for k_t in (0.0, law.k_t)
            for side in (law.up, law.down)
        ]
    )


@lru_cache(maxsize=64)
def whole_step_form(c, w, dt):
    """Return a row of `whole_step_forms`; parameters as in `step_quadratic_forms`."""
    squares, distance = step_quadratic_forms(c, w, dt)
    row = []
    for square, (first, second) in zip(squares, FORM_VARIABLES, strict=True):
        for i in first:
            for j in second:
                if first != second or j >= i:
                    row.append(square[i, j] + (square[j, i] if i != j else 0.0))
    _, _, Y, YY = flow(c, w, dt)
    mean = dt, Y, -YY, -cubic_response(c, w, dt) / dt
    return (*row, *distance[1:4].tolist(), *mean)


def cubic_response(c, w, dt):
    """Return the integral of YY of `flow` over [0, dt], by quadrature."""
    total, begin = 0.0, 0.0
    while begin < dt:
        rate = fastest_rate(c, w, begin)
        length = min(PANEL_RADIANS / rate, dt - begin) if rate > 0.0 else dt - begin
        for node, weight in zip(TWELVE_NODES, TWELVE_WEIGHTS, strict=True):
            total += weight * length * flow(c, w, begin + length * node)[3]
        begin = begin + length if length < dt - begin else dt
    return total


# Segments of a piecewise-linear law: evaluation and integrals.


class Solution(NamedTuple):
    """Solution stored as segments.

    Attributes
    ----------
    plant, law : Plant, KernelLaw
    waves : Waves
    u_dd, dt : array of float, float
        Base acceleration besides the waves at the samples [m/s²], and their interval [s].
    segments : Segments
        With encoded modes; z is the x_r at which an elastic contact carries no force [m].
    """

    plant: Any
    law: Any
    waves: Any
    u_dd: Any
    dt: float
    segments: Any


class Columns(NamedTuple):
    """Values of a motion at given times; arrays of shape (n,).

    Attributes
    ----------
    x_r, v_r : array of float
        Displacement [m] and velocity [m/s].
    z : array of float
        x_r at which an elastic contact would carry no force [m]; 0 for a rigid contact.
    F_f, F_stop : array of float
        Friction force and force of an end stop [N].
    d : array of int
        Direction of motion, 0 at rest.
    """

    x_r: Any
    v_r: Any
    z: Any
    F_f: Any
    F_stop: Any
    d: Any


class ResumedSegment(NamedTuple):
    """A segment with the phases of the waves set at its start.

    Attributes
    ----------
    mode, equation
        Its mode and equation of motion.
    z, x_0, xi, v_r : float
        Origin of xi and zero of the contact force [m], and state at the start.
    u_0, slope : float
        ü besides the waves at the start [m/s²], and its rate [m/s³].
    """

    mode: Any
    equation: Any
    z: float
    x_0: float
    xi: float
    v_r: float
    u_0: float
    slope: float


@inlined
def segment_base(u_dd, dt, segments, i):
    """Return the start time of segment i [s], and ü besides the waves there with its rate."""
    n, s = segments.n[i], segments.s[i]
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    return n * dt + s, u_dd[n] + slope * s, slope


@inlined
def segment_index(segments, dt, i, t):
    """Return the index of the segment that contains time t [s], searching upwards from i."""
    while i + 1 < len(segments.n) and segments.n[i + 1] * dt + segments.s[i + 1] <= t:
        i += 1
    return i


@compiled
def resume_segment(solution, i):
    """Return segment i of a solution, ready for evaluation."""
    plant, law, waves, u_dd, dt, segments = solution
    mode, x_0 = decode_mode(segments.d[i]), segments.z[i]
    t, u_0, slope = segment_base(u_dd, dt, segments, i)
    equation = mode_equation(plant, law, waves, mode, x_0, u_0, slope, t)
    z = origin_of(law, mode.origin)
    return ResumedSegment(mode, equation, z, x_0, segments.x_r[i], segments.v_r[i], u_0, slope)


@compiled
def motion_in_segment(waves, part, s):
    """Return xi and v_r at time s of a resumed segment."""
    if part.mode.direction == AT_REST:
        return part.xi, 0.0
    if s == 0.0:
        return part.xi, part.v_r
    c, w, g, r, _ = part.equation
    return motion_at(c, w, waves, part.xi, part.v_r, g, r, s)[:2]


@compiled
def segment_window(segments, dt, i, begin, end):
    """Return the part of segment i within a window, as times since its start [s]."""
    t = segments.n[i] * dt + segments.s[i]
    hi = end - t
    if i + 1 < len(segments.n):
        length = (segments.n[i + 1] - segments.n[i]) * dt
        hi = min(hi, length + (segments.s[i + 1] - segments.s[i]))
    return max(begin - t, 0.0), hi


@compiled
def evaluate_segments(solution, t, out):
    """Write a motion at ascending times t [s] to `Columns`."""
    plant, law, waves, _, dt, segments = solution
    i, known = 0, -1
    part = resume_segment(solution, 0)
    for k in range(len(t)):
        i = segment_index(segments, dt, i, t[k])
        if known != i:
            part = resume_segment(solution, i)
            known = i
        s = t[k] - (segments.n[i] * dt + segments.s[i])
        mode = part.mode
        xi, v = motion_in_segment(waves, part, s)
        x_r = part.z + xi
        u = base_motion(waves, part.u_0, part.slope, s)[0]
        load = max(load_at(law, waves, part.equation.ramp, s)[0], 0.0)
        F_f, F_stop = friction_and_stop_forces(plant, law, mode, part.x_0, xi, v, u, load)
        out.x_r[k], out.v_r[k] = x_r, v
        out.F_f[k], out.F_stop[k] = F_f, F_stop
        out.z[k] = x_r - F_f / law.k_t if law.k_t > 0.0 else 0.0
        if is_rigid_slip(law, mode):
            out.d[k] = mode.contact
        elif mode.direction == AT_REST and law.k_t == 0.0:
            out.d[k] = 0
        else:
            out.d[k] = -1 if v < 0.0 else 1


SIX_NODE_PANELS = 0.125
"""Panels, as a share of `panel_length`, up to which six nodes suffice: half a radian, where
their error is 2e-16 of a product."""

LONG_HOLD_PANELS = 2.0
"""Length of a holding segment, in panels, above which it is integrated in closed form."""


class SegmentSums(NamedTuple):
    """Integrals over segments: fields of `Totals`, and the work of the damper [J]."""

    x2: float
    v2: float
    x_dd2: float
    power: float
    sliding_distance: float
    stuck: float
    stop_work: float
    damper_work: float


@compiled
def add_segment_sums(one, other):
    """Return the sum of two `SegmentSums`."""
    return SegmentSums(
        one.x2 + other.x2,
        one.v2 + other.v2,
        one.x_dd2 + other.x_dd2,
        one.power + other.power,
        one.sliding_distance + other.sliding_distance,
        one.stuck + other.stuck,
        one.stop_work + other.stop_work,
        one.damper_work + other.damper_work,
    )


@compiled
def integrate_segments(solution, forms, lengths, begin, end):
    """Integrate segments over their parts between two times.

    Parameters
    ----------
    solution : Solution
    forms : array, shape (4, FORM_COLUMNS)
        From `whole_step_forms`.
    lengths : array of float
        Length of each segment [s].
    begin, end : float
        Window of integration [s].

    Returns
    -------
    SegmentSums
        `sliding_distance` is the work done on the contact divided by the larger F_fk;
        `stop_work` does not include the energy lost in rigid impacts, which have no duration.
    """
    plant, law, waves, u_dd, dt, segments = solution
    sums = SegmentSums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if len(segments.n) == 0:
        return sums
    affine = waves.size == 0 and law.step == 0.0
    # Whole steps in one mode differ in ü and in the state alone: the last one is kept.
    kept = resume_segment(solution, 0)
    code, x_0 = segments.d[0], segments.z[0]
    for i in range(len(segments.n)):
        t = segments.n[i] * dt + segments.s[i]
        lo, hi = max(begin - t, 0.0), min(end - t, lengths[i])
        if hi <= lo or segments.d[i] == ARRIVAL:
            continue
        if affine and segments.s[i] == 0.0 and hi - lo == dt:
            if segments.d[i] != code or segments.z[i] != x_0:
                kept, code, x_0 = resume_segment(solution, i), segments.d[i], segments.z[i]
            if kept.mode.direction != AT_REST and kept.mode.stop == APART:
                base = u_dd[segments.n[i]], u_dd[segments.n[i] + 1]
                state = segments.x_r[i], segments.v_r[i]
                more = integrate_whole_step(law, kept, forms, dt, base, state)
                sums = add_segment_sums(sums, more)
                continue
        part = resume_segment(solution, i)
        if part.mode.bumper == CHATTERING:
            more = integrate_chatter(plant, law, waves, part, lo, hi)
        elif part.mode.direction == AT_REST:
            more = integrate_rest(law, waves, part, lo, hi)
        elif hi - lo > LONG_HOLD_PANELS * panel_length(
            part.equation.c, part.equation.w, waves, lo
        ) and is_long_hold(law, waves, part):
            more = integrate_hold_exponentials(plant, law, waves, part, lo, hi)
        else:
            more = integrate_motion(plant, law, waves, part, lo, hi)
        sums = add_segment_sums(sums, more)
    return sums


@compiled
def integrate_chatter(plant, law, waves, part, lo, hi):
    """Integrate the rest of a chatter against a rigid stop."""
    load = load_at(law, waves, part.equation.ramp, 0.0)[0]
    u = base_motion(waves, part.u_0, part.slope, 0.0)[0]
    p, q = return_accelerations(plant, law, part.mode, part.x_0, u, load)
    x_dd2 = chatter_mean_square(plant, law, part.mode, part.x_0, p, q, load)
    length = hi - lo
    return SegmentSums(part.z * part.z * length, 0.0, x_dd2 * length, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def integrate_rest(law, waves, part, lo, hi):
    """Integrate a segment at rest, where x" is that of the base."""
    x_dd2, s = 0.0, lo
    while s < hi:
        length = min(panel_length(0.0, 0.0, waves, s), hi - s)
        for k in range(len(TWELVE_NODES)):
            at = s + length * TWELVE_NODES[k]
            u = base_motion(waves, part.u_0, part.slope, at)[0]
            x_dd2 += length * TWELVE_WEIGHTS[k] * u * u
        s = s + length if length < hi - s else hi
    x2 = (part.z + part.xi) ** 2 * (hi - lo)
    stuck = hi - lo if law.k_t == 0.0 else 0.0
    return SegmentSums(x2, 0.0, x_dd2, 0.0, 0.0, stuck, 0.0, 0.0)


@compiled
def integrate_motion(plant, law, waves, part, lo, hi):
    """Integrate a segment in motion by Gauss quadrature on panels."""
    c, w = part.equation.c, part.equation.w
    sums, s = SegmentSums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), lo
    longest = panel_length(c, w, waves, lo)
    if hi - lo <= SIX_NODE_PANELS * longest:
        return integrate_panel(
            SIX_NODES, SIX_WEIGHTS, plant, law, waves, part, lo, hi - lo, sums
        )
    while s < hi:
        length = min(panel_length(c, w, waves, s), hi - s)
        sums = integrate_panel(
            TWELVE_NODES, TWELVE_WEIGHTS, plant, law, waves, part, s, length, sums
        )
        s = s + length if length < hi - s else hi
    return sums


@compiled
def integrate_panel(nodes, weights, plant, law, waves, part, s, length, sums):
    """Add the integrals of one panel, which begins at time s [s], to the sums."""
    m, k_x, _ = plant
    b = side_of(law, part.mode.direction).b
    reference = max(law.up.F_fk, law.down.F_fk)
    x2, v2, x_dd2, power, slid, stuck, stop_work, damper_work = sums
    for k in range(len(nodes)):
        at = s + length * nodes[k]
        weight = length * weights[k]
        xi, v = motion_in_segment(waves, part, at)
        u = base_motion(waves, part.u_0, part.slope, at)[0]
        load = max(load_at(law, waves, part.equation.ramp, at)[0], 0.0)
        F_f, F = friction_and_stop_forces(plant, law, part.mode, part.x_0, xi, v, u, load)
        x = part.z + xi
        x_dd = (k_x * x + b * v + F_f + F) / m
        x2 += weight * x * x
        v2 += weight * v * v
        x_dd2 += weight * x_dd * x_dd
        power += weight * u * v
        slid += weight * (F_f * v / reference if reference > 0.0 else load * abs(v))
        stop_work += weight * F * v
        damper_work += weight * b * v * v
    return SegmentSums(x2, v2, x_dd2, power, slid, stuck, stop_work, damper_work)


@compiled
def form_row(mode):
    """Return the row of `whole_step_forms` for a mode."""
    down = 1 if mode.direction < 0 else 0
    return 2 + down if mode.contact == HOLD else down


@inlined
def square_form(form, at, y):
    """Return the quadratic form whose upper triangle begins at an index of a row."""
    total = 0.0
    for i in range(len(y)):
        for j in range(i, len(y)):
            total += form[at] * (y[i] * y[j])
            at += 1
    return total


@compiled
def integrate_whole_step(law, part, forms, dt, base, state):
    """Integrate a whole sampled step in motion by quadratic forms of its variables.

    The variables are those of `step_variables`, with xi for x_r and all constant forces in f.

    Parameters
    ----------
    part : ResumedSegment
        A segment of the same mode with the same x_0.
    base, state : tuple of float
        ü at both ends [m/s²], and xi [m] and v_r [m/s] at the start.
    """
    c, w, g, _, _ = part.equation
    (u_0, u_1), (xi, v_r), z = base, state, part.z
    form = forms[form_row(part.mode)]
    contact = w * xi - (g + part.u_0)
    p, q, s = u_0 + contact, u_1 - u_0, c * v_r + contact
    x2 = square_form(form, 0, (xi, v_r, p, q))
    v2 = square_form(form, 10, (v_r, p, q))
    x_dd2 = square_form(form, 16, (v_r, q, u_0, s))
    power = q * (form[26] * v_r + form[27] * p + form[28] * q)
    power += u_0 * (form[29] * v_r + form[30] * p + form[31] * q)
    slid = form[32] * v_r + form[33] * p + form[34] * q
    mean = form[35] * xi + form[36] * v_r + form[37] * p + form[38] * q
    # Squares are not below zero, whatever rounding says.
    x2 = max(x2 + z * (2.0 * mean + z * dt), 0.0)
    v2, x_dd2 = max(v2, 0.0), max(x_dd2, 0.0)
    reference = max(law.up.F_fk, law.down.F_fk)
    work = abs(slid)
    if part.mode.contact == HOLD:
        work = law.k_t * (z + xi - part.x_0 + 0.5 * slid) * slid / reference
    elif reference > 0.0:
        work = part.mode.contact * side_of(law, part.mode.contact).F_fk * slid / reference
    damper_work = side_of(law, part.mode.direction).b * v2
    return SegmentSums(x2, v2, x_dd2, power, work, 0.0, 0.0, damper_work)


@compiled
def is_long_hold(law, waves, part):
    """Return whether a holding segment is a sum of exponentials, with ü by waves alone."""
    if law.k_t == 0.0 or part.mode.contact != HOLD or part.mode.stop != APART:
        return False
    if part.u_0 != 0.0 or part.slope != 0.0 or part.z != 0.0:
        return False
    return is_sum_of_exponentials(part.equation.c, part.equation.w, waves)


@compiled
def is_sum_of_exponentials(c, w, waves):
    """Return whether the motion is an underdamped free motion plus steady responses."""
    steady = w > 0.0 and w - 0.25 * c * c >= UNDERDAMPED_SHARE * w
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        steady = steady and (waves.values[at + STEADY] > 0.0 or waves.values[at + A] == 0.0)
    return steady


@compiled
def integrate_hold_exponentials(plant, law, waves, part, lo, hi):
    """Integrate a holding segment from lo to hi [s] as a sum of complex exponentials.

    The motion must satisfy `is_sum_of_exponentials`. The method is not used for short segments,
    where the exponentials nearly cancel.
    """
    c, w, g, _, _ = part.equation
    x_r, v_r = part.xi, part.v_r
    x_mean = g / w  # static equilibrium without waves
    x_transient, rate = x_r - x_mean, v_r
    for i in range(waves.base):
        at = WAVE_COLUMNS * i
        if waves.values[at + A] != 0.0:
            x_transient -= waves.values[at + STEADY_X]
            rate -= waves.values[at + STEADY_V]
    length = hi - lo
    x2, v2, x_dd2, power = x_mean * x_mean * length, 0.0, 0.0, 0.0
    for i in range(waves.base + 1):
        root, x, u_dd = exponential_term(c, w, waves, x_transient, rate, i, lo)
        end_value = cmath.exp(root * length)
        v, x_dd = root * x, -(w + c * root) * x
        x2 += 2.0 * x_mean * (x * integral_of_exponential(root, end_value, length)).real
        for k in range(i + 1):
            multiplicity, other, x_k, u_k, end_value_k = 1.0, root, x, u_dd, end_value
            if k < i:
                other, x_k, u_k = exponential_term(c, w, waves, x_transient, rate, k, lo)
                multiplicity, end_value_k = 2.0, cmath.exp(other * length)
            v_k, x_dd_k = other * x_k, -(w + c * other) * x_k
            # Re(x e^pt) Re(y e^qt) = Re(x y e^(p + q)t + x y* e^(p + q*)t)/2, * the conjugate.
            both = 0.5 * integral_of_exponential(root + other, end_value * end_value_k, length)
            against = 0.5 * integral_of_exponential(
                root + other.conjugate(), end_value * end_value_k.conjugate(), length
            )
            x2 += multiplicity * (x * x_k * both + x * x_k.conjugate() * against).real
            v2 += multiplicity * (v * v_k * both + v * v_k.conjugate() * against).real
            x_dd2 += (
                multiplicity * (x_dd * x_dd_k * both + x_dd * x_dd_k.conjugate() * against).real
            )
            power += (u_dd * (v_k * both + v_k.conjugate() * against)).real
            if k < i:
                power += (v * (u_k * both + u_k.conjugate() * against)).real
    x_lo = motion_at(c, w, waves, x_r, v_r, g, 0.0, lo)[0]
    x_hi = motion_at(c, w, waves, x_r, v_r, g, 0.0, hi)[0]
    work = law.k_t * (x_hi - x_lo) * (0.5 * (x_lo + x_hi) - part.x_0)
    slid = work / max(law.up.F_fk, law.down.F_fk)
    damper_work = side_of(law, part.mode.direction).b * v2
    return SegmentSums(x2, v2, x_dd2, power, slid, 0.0, 0.0, damper_work)


@inlined
def exponential_term(c, w, waves, x_transient, rate, i, s):
    """Return term i of the motion at time s: steady response to wave i, or free motion (last).

    `x_transient` and `rate` are the differences of x_r and v_r from the steady response at the
    start [m, m/s]. Returns root, x and u_dd: x_r has the part Re(x exp(root·time)), ü likewise.
    """
    if i == waves.base:
        omega_d = math.sqrt(w - 0.25 * c * c)
        root = complex(-0.5 * c, omega_d)
        x = complex(x_transient, -(rate + 0.5 * c * x_transient) / omega_d) * cmath.exp(
            root * s
        )
        return root, x, complex(0.0, 0.0)
    at = WAVE_COLUMNS * i
    omega = waves.values[at + OMEGA]
    angle = omega * s + waves.values[at + THETA]
    rotation = complex(math.cos(angle), math.sin(angle))
    u_dd = complex(0.0, -waves.values[at + A]) * rotation
    x = complex(0.0, 0.0)
    if waves.values[at + A] != 0.0:
        x = complex(waves.values[at + QUADRATURE], -waves.values[at + IN_PHASE]) * rotation
    return complex(0.0, omega), x, u_dd


EXPONENTIAL_TERMS = 16
"""Terms of the series that exhaust double precision where |z|·length is below
`SHORT_SEGMENT`."""


@inlined
def integral_of_exponential(z, end_value, length):
    """Return the integral of exp(z s) over 0 <= s <= length, with end_value = exp(z length)."""
    q = z * length
    if abs(q) > SHORT_SEGMENT:
        return (end_value - 1.0) / z
    total = complex(0.0, 0.0)
    for n in range(EXPONENTIAL_TERMS, 0, -1):
        total = (1.0 + total) * q / (n + 1)
    return length * (1.0 + total)


# Peak force of a bumper.

PEAK_SUBDIVISIONS = 40.0
"""Parts per panel, a tenth of a radian each, in which a bumper force has at most one
extremum."""


@compiled
def peak_bumper_force(solution, begin, end):
    """Return the greatest force of a bumper between `begin` and `end` [N]."""
    _, law, waves, _, dt, segments = solution
    greatest = 0.0
    for i in range(len(segments.n)):
        s, hi = segment_window(segments, dt, i, begin, end)
        if hi < s or segments.d[i] == ARRIVAL:
            continue
        part = resume_segment(solution, i)
        if not touches_bumper(law, part.mode):
            continue
        force, rate = bumper_force_and_rate(law, waves, part, s)
        greatest = max(greatest, force)
        while s < hi and part.mode.direction != AT_REST:
            longest = panel_length(part.equation.c, part.equation.w, waves, s)
            length = min(longest / PEAK_SUBDIVISIONS, hi - s)
            until = s + length if length < hi - s else hi
            force, after = bumper_force_and_rate(law, waves, part, until)
            greatest = max(greatest, force)
            if rate > 0.0 and after < 0.0:
                greatest = max(greatest, local_force_peak(law, waves, part, s, until))
            s, rate = until, after
    return greatest


@compiled
def bumper_force_and_rate(law, waves, part, s):
    """Return the force of a bumper [N] and its rate [N/s] at time s of a segment."""
    side = sign(part.mode.stop)
    if part.mode.direction == AT_REST:
        return side * bumper_force(law, part.mode, part.xi, 0.0), 0.0
    c, w, g, r, _ = part.equation
    x, v, a, _ = motion_at(c, w, waves, part.xi, part.v_r, g, r, s)
    stiffness, offset = bumper_line(law, abs(part.mode.stop))
    return side * (stiffness * x + law.b_s * v) - offset, side * (stiffness * v + law.b_s * a)


@compiled
def local_force_peak(law, waves, part, low, high):
    """Return the maximum of a bumper force that rises at time `low` and falls at `high` [N]."""
    s = 0.5 * (low + high)
    for _ in range(MAX_BISECTIONS):
        rate = bumper_force_and_rate(law, waves, part, s)[1]
        low, high = (s, high) if rate > 0.0 else (low, s)
        if high - low <= RESOLUTION * high:
            break
        s = 0.5 * (low + high)
    return bumper_force_and_rate(law, waves, part, s)[0]


# Peaks, crossings and excursions from the turning points.


MAX_NEWTON_STEPS = 100
"""Newton's method needs about 5 steps; bisection reaches adjacent floats after about 60."""


@compiled
def extremes_and_crossings(t, x_r, x_begin, x_end, end, limits):
    """Return the extremes of x_r and the counts of zero and limit crossings.

    Parameters
    ----------
    t, x_r : array, shape (events,)
        Time [s] and displacement [m] of the events; x_r is monotone between
        them.
    x_begin, x_end, end : float
        Displacement at both ends of the window [m], and its end [s].
    limits : StrokeLimits
        Stroke limits [m]; infinite for none.

    Returns
    -------
    lowest, highest : float
        Extremes of x_r [m].
    upcrossings, entries : int
        Number of zero crossings with positive slope, and of entries of x_r into the ranges at
        or beyond the limits.
    """
    lowest, highest = min(x_begin, x_end), max(x_begin, x_end)
    upcrossings, entries = 0, 0
    side = sign(x_begin)
    beyond = limit_side(x_begin, limits)
    for i in range(len(t) + 1):
        x = x_r[i] if i < len(t) else x_end
        if i < len(t):
            lowest, highest = min(lowest, x), max(highest, x)
            if not 0.0 < t[i] < end:
                continue
        if x != 0.0:
            upcrossings += side < 0 and x > 0.0
            side = sign(x)
        now = limit_side(x, limits)
        entries += now != 0 and now != beyond
        beyond = now
    return lowest, highest, upcrossings, entries


@compiled
def limit_side(x_r, limits):
    """Return 1 at or beyond the upper stroke limit, -1 at or beyond the lower one, else 0."""
    if x_r >= limits.up:
        return 1
    return -1 if x_r <= -limits.down else 0


@compiled
def excursions(plant, law, waves, t, kind, x_r, v_first, x_end, end, limits, repeats):
    """Return the numbers of excursions to the limits, the first time and the total time.

    Parameters
    ----------
    t, kind, x_r, v_first
        As in `state_at`.
    x_end, end : float
        Displacement at the end [m], and the end [s].
    limits : StrokeLimits
        Stroke limits [m].
    repeats : bool
        Whether the motion is periodic, so that an excursion at the end continues at the start.

    Returns
    -------
    up, down : int
        Number of excursions to either limit.
    first : float
        Time of the first one [s]; negative if there is none.
    beyond : float
        Total time at or beyond the limit [s].
    """
    scene = (plant, law, waves, t, kind, x_r, v_first)
    begins = limit_side(x_r[0], limits)
    up, down = int(begins > 0), int(begins < 0)
    first = 0.0 if begins != 0 else -1.0
    entered, left = 0.0, 0.0
    side = begins
    for i in range(len(t)):
        until = t[i + 1] if i + 1 < len(t) else end
        x = x_r[i + 1] if i + 1 < len(t) else x_end
        now = limit_side(x, limits)
        if now == side:
            continue
        # The total time is the sum of the leaving times minus that of the entering times.
        if side != 0:
            level = limits.up if side > 0 else -limits.down
            left += level_crossing_time(*scene, level, t[i], until)
        if now != 0:
            level = limits.up if now > 0 else -limits.down
            at = level_crossing_time(*scene, level, t[i], until)
            entered += at
            first = at if up + down == 0 else first
            up, down = up + int(now > 0), down + int(now < 0)
        side = now
    if side != 0:
        left += end
    # On an orbit, an excursion across the end of the period counts once.
    if repeats and begins != 0 and side == begins and up + down > 1:
        up, down = up - int(side > 0), down - int(side < 0)
    return up, down, first, left - entered


@compiled
def level_crossing_time(plant, law, waves, t, kind, x_r, v_first, level, lo, hi):
    """Return the time at which x_r, monotone between lo and hi [s], crosses a level [m].

    Newton's method, safeguarded by bisection.
    """
    scene = (plant, law, waves, t, kind, x_r, v_first)
    rising = state_at(*scene, hi)[0] > state_at(*scene, lo)[0]
    at = 0.5 * (lo + hi)
    for _ in range(MAX_NEWTON_STEPS):
        x, v = state_at(*scene, at)
        if x == level:
            return at
        if (x < level) == rising:
            lo = at
        else:
            hi = at
        before = at
        at = at + (level - x) / v if v != 0.0 else math.inf
        if at == before:  # converged; bisecting what is left would take 50 more steps
            return at
        if not lo < at < hi:
            at = 0.5 * (lo + hi)
        if not lo < at < hi:
            return hi
    return at


# Turning points of x_r on an elastic contact, skipping those that cannot set a new extreme.


@compiled
def write_turning_points(solution, lengths, whole, limits, at, t_out, x_out):
    """Write the start of each segment and its turning points, until the buffer is full.

    Parameters
    ----------
    solution, lengths
        As in `integrate_segments`, of an elastic contact without stops.
    whole : array, shape (segments,)
        Whether all turning points of a segment are required, as for the last one, or only those
        that can set a new extreme or cross zero or the limit.
    limits : StrokeLimits
        Stroke limits [m]; infinite for none.
    at : tuple
        Where to continue: segment, time since its start [s], x_r [m] and v_r [m/s] there, and
        the farthest displacement written in this half cycle [m].
    t_out, x_out : array, shape (n,)
        Written: time [s] and displacement [m].

    Returns
    -------
    at, count
        Where to continue, with the number of segments if all is written; and the number of
        values written.

    Notes
    -----
    A holding contact may reverse hundreds of times without consequence. Segments, and the rest
    of a segment, are skipped as long as a bound on the motion (`is_hold_uneventful`,
    `uneventful_until`) proves that x_r crosses neither zero nor the limit nor sets a new
    extreme.
    """
    plant, law, waves, u_dd, dt, segments = solution
    i, s, x_r, v_r, far = at
    count = 0
    while i < len(segments.n) and count + 2 <= len(t_out):
        mode, t, only = (
            decode_mode(segments.d[i]),
            segments.n[i] * dt + segments.s[i],
            not whole[i],
        )
        if s == 0.0:
            x_r, v_r = segments.x_r[i], segments.v_r[i]
            t_out[count], x_out[count] = t, x_r
            # After a segment cut by a window, the known extreme may lie outside the window.
            far = x_r if i > 0 and whole[i - 1] else half_cycle_extreme(far, x_r)
            count += 1
            # Under a constant limit a yielding contact has no turning point within its segment.
            yields = abs(mode.contact) == 1 and law.variation == 0.0 and law.step == 0.0
            if yields or (
                only and mode.contact == HOLD and is_hold_uneventful(law, segments, i, limits)
            ):
                i += 1
                continue
        n = segments.n[i]
        slope = (u_dd[n + 1] - u_dd[n]) / dt
        u_0 = u_dd[n] + slope * (segments.s[i] + s)
        c, w, g, r, _ = mode_equation(plant, law, waves, mode, segments.z[i], u_0, slope, t + s)
        segment = start_segment(c, w, waves, x_r, v_r, g, r)
        left = lengths[i] - s
        direction, s_turn, x_turn = (
            motion_direction(segment.v_r, segment.a, segment.j),
            NEVER,
            x_r,
        )
        if direction != 0:
            s_turn, x_turn = slip_exit_time(
                c,
                w,
                waves,
                x_r,
                v_r,
                segment.a,
                segment.j,
                segment.g,
                segment.r,
                direction,
                left,
            )
        if s_turn >= left or not t + s + s_turn > t + s:
            i, s = i + 1, 0.0
            continue
        t_out[count], x_out[count] = t + s + s_turn, x_turn
        far = half_cycle_extreme(far, x_turn)
        count += 1
        until = s_turn
        if only and mode.contact == HOLD:
            x_end = segments.x_r[i + 1]
            until = uneventful_until(
                law, waves, segment, x_turn, far, x_end, limits, s_turn, left
            )
        if until > s_turn:
            x_r, v_r, _, _ = motion_at(c, w, waves, x_r, v_r, g, r, until)
        else:
            x_r, v_r = x_turn, 0.0
        s += until
    return (i, s, x_r, v_r, far), count


EXTREME_TOLERANCE = 1e-14
"""Relative excess over a known extreme that counts as rounding and sets no new extreme."""


@compiled
def uneventful_range(x_r, far, limits):
    """Return the interval of displacements in which turning points have no effect [m].

    It contains x_r and is bounded by zero, and by the stroke limit and the extreme `far` on
    the side of x_r [m].
    """
    size = abs(x_r)
    limit = limits.up if x_r > 0.0 else limits.down
    low, high = (0.0, limit) if size < limit else (limit, math.inf)
    high = min(high, max(far, size) * (1.0 + EXTREME_TOLERANCE))
    return (low, high) if x_r > 0.0 else (-high, -low)


@compiled
def is_hold_uneventful(law, segments, i, limits):
    """Return whether the contact limits keep x_r within its uneventful range while holding."""
    side = sign(segments.x_r[i])
    low, high = uneventful_range(segments.x_r[i], side * segments.x_r[i + 1], limits)
    reach = law.up.F_fk / law.k_t * (1.0 + law.variation)
    return low <= segments.z[i] - reach and segments.z[i] + reach <= high


@compiled
def uneventful_until(law, waves, segment, x_turn, far, x_end, limits, s_turn, h):
    """Return the time until which the motion after a turning point stays uneventful [s].

    Parameters
    ----------
    law, waves, segment
        The holding segment, with the phases set at its start.
    x_turn, far, x_end : float
        Displacement at the turning point, farthest displacement written in this half cycle, and
        displacement at the end of the segment [m]. A motion that stays on one side of zero
        passes x_end in the same half cycle, so x_end counts as known.
    limits : StrokeLimits
        Stroke limits [m]; infinite for none.
    s_turn, h : float
        Time of the turning point, and remaining length of the segment [s].
    """
    # Less than half a natural period is left: there is at most one more turning point.
    if segment.w * (h - s_turn) * (h - s_turn) < math.pi * math.pi:
        return s_turn
    transient = transient_response(segment, waves)
    if transient.side == 0:
        return s_turn
    side = sign(x_turn)
    until = s_turn
    # First with x_end as a known extreme. If the motion may change sides before the end of
    # the segment, x_end belongs to another half cycle and only `far` is known.
    for known in (max(side * far, side * x_end), side * far):
        low, high = uneventful_range(x_turn, known, limits)
        middle, reach = 0.5 * (low + high), 0.5 * (high - low)
        until = safe_until(transient, segment, waves, law, middle, reach, False, s_turn, h)
        if until >= h or side * x_end <= side * far:
            return until
    return until


@compiled
def half_cycle_extreme(far, x_r):
    """Return the farthest displacement of a half cycle after one more point [m]."""
    return far if far * x_r > 0.0 and abs(far) > abs(x_r) else x_r
