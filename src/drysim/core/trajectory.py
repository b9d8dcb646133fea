"""Trajectory of an exact solution: state at any time, output grids, integrals, turning points.

Problem
    A march (`core.march`, `core.sampled`) returns only the start of every segment: time, state
    and mode. Everything else is derived here from these values without a new solution.

Method
    Within a segment the motion has a closed form, so no interpolation error arises.

    - State at any time: the flow of the segment, `motion_at`.
    - Output grid under sines: the flow and the sine responses over 0, 1, ... grid steps are
      tabulated once. Every grid point is then a linear combination of table rows and does not
      depend on the point before it. So is ü (`forcing.sample_base`).
    - Integrals: Gauss-Legendre quadrature on panels of at most `PANEL_RADIANS` of the fastest
      rate that is still present, with an error below rounding. Whole sampled steps are
      summed (`core.measure`).
    - Turning points of x_r: every zero of v_r ends a segment. Between two of them x_r is
      monotone, so peaks, zero crossings and crossings of the stroke limit follow from them and
      none is missed.

A solution is stored as `Segments`: segment i starts at the time segments.s[i] within step
segments.n[i]. It is evaluated by way of a `ResumedSegment`: the equation of motion, the forces
and the start of one segment. Kernels that evaluate segments expect ascending times.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import ZERO, compiled, inlined, merged
from drysim.core.events import record_segment, sign
from drysim.core.forcing import (
    FIRST_COLUMNS,
    FREQUENCY,
    GRID_COLUMNS,
    IN_PHASE,
    OMEGA,
    PHASE,
    QUADRATURE,
    STEADY,
    STEADY_V,
    STEADY_X,
    TURN_ROWS,
    WAVE_COLUMNS,
    A,
    Equation,
    base_motion,
    fill_turns,
    motion_at,
    phase_at,
    response_from_rest,
    sample_base,
    set_phases,
    turn_coefficients,
)
from drysim.core.model import (
    FOUR_NODES,
    FOUR_WEIGHTS,
    MAX_STAGES,
    TWELVE_NODES,
    TWELVE_WEIGHTS,
)
from drysim.core.modes import (
    ARRIVAL,
    AT_REST,
    CHATTERING,
    FREE,
    HOLD,
    SegmentBase,
    bumper_force,
    chatter_mean_square,
    contact_force,
    decode_mode,
    friction_and_stop_forces,
    is_rigid_slip,
    load_at,
    mode_equation,
    mode_forces,
    origin_of,
    return_accelerations,
    side_of,
    wall_side,
)
from drysim.core.oscillator import (
    SERIES_SEGMENT,
    free_response,
    series_distance,
    series_factors,
    series_velocity,
    sine_response,
    velocity_series,
)
from drysim.core.peak import Decay, bend, peak_of_segment
from drysim.core.roots import (
    MAX_BISECTIONS,
    RESOLUTION,
)

# A solution, and a segment of it.


class Solution(NamedTuple):
    """Solution stored as segments.

    Attributes
    ----------
    scene : Scene
        As of `core.forcing`; under waves alone its one step is as long as the motion.
    segments : Segments
        With encoded modes. Under waves the state at the end of the motion follows.
    """

    scene: Any
    segments: Any


class SampledSolution(NamedTuple):
    """Solution over samples, or under waves alone as one step.

    Attributes
    ----------
    scene : Scene
        As of `core.forcing`.
    samples : SampledMotion
        xi and v_r at all samples; not used under waves alone.
    rows : Segments
        Starts of the segments, except those that begin at a sample in the mode before.
    """

    scene: Any
    samples: Any
    rows: Any


class ResumedSegment(NamedTuple):
    """A segment with the phases of the waves set at its start.

    Attributes
    ----------
    mode, equation, ramp, forces
        Its mode and equation of motion, the course of the normal force, and the forces in this
        mode.
    x_origin, xi, v_r : float
        Origin of xi [m], and state at the start.
    u_0, slope : float
        ü besides the waves at the start [m/s²], and its rate [m/s³].
    """

    mode: Any
    equation: Any
    ramp: Any
    forces: Any
    x_origin: float
    xi: float
    v_r: float
    u_0: float
    slope: float


@inlined
def segment_base(u_dd, dt, segments, i):
    """Return the `SegmentBase` of segment i."""
    return base_at(u_dd, dt, segments.n[i], segments.s[i])


@inlined
def base_at(u_dd, dt, n, s):
    """Return the `SegmentBase` at time s [s] of step n."""
    slope = (u_dd[n + 1] - u_dd[n]) / dt
    return SegmentBase(n * dt + s, u_dd[n] + slope * s, slope)


@inlined
def segment_index(segments, dt, i, t):
    """Return the index of the segment that contains time t [s], searching upwards from i."""
    while i + 1 < len(segments.n) and segments.n[i + 1] * dt + segments.s[i + 1] <= t:
        i += 1
    return i


@inlined
def last_event_index(t, time):
    """Return the index of the last event at or before a time, 0 if there is none; bisection."""
    low, high = 0, len(t)
    while high - low > 1:
        middle = (low + high) // 2
        if t[middle] <= time:
            low = middle
        else:
            high = middle
    return low


@inlined
def last_row_index(rows, dt, n, t):
    """Return the index of the last row at or before a time t [s] in step n; bisection."""
    low, high = 0, len(rows.n)
    while high - low > 1:
        middle = (low + high) // 2
        m = rows.n[middle]
        if m < n or (m == n and n * dt + rows.s[middle] <= t):
            low = middle
        else:
            high = middle
    return low


@inlined
def segment_length(segments, dt, i):
    """Return the time from the start of segment i to that of the next, or to the step's end."""
    followed = i + 1 < len(segments.n) and segments.n[i + 1] == segments.n[i]
    return (segments.s[i + 1] if followed else dt) - segments.s[i]


@compiled
def segment_window(segments, dt, i, begin, end):
    """Return the part of segment i within a window, as times since its start [s]."""
    t = segments.n[i] * dt + segments.s[i]
    return max(begin - t, 0.0), min(end - t, segment_length(segments, dt, i))


@inlined
def resume_segment(solution, i):
    """Return segment i of a solution, ready for evaluation."""
    scene, segments = solution
    state = segments.x_r[i], segments.v_r[i], segments.x_0[i]
    return resume_mode(scene, (segments.n[i], segments.s[i]), state, segments.d[i])


@compiled
def resume_mode(scene, time, state, code):
    """Return a segment, ready for evaluation.

    Parameters
    ----------
    scene : Scene
    time : (int, float)
        Step, and time since it began [s].
    state : tuple of float
        xi [m], v_r [m/s] and x_0 [m] at the start.
    code : int
        Encoded mode.
    """
    (plant, law, waves, u_dd, dt), (n, s), (xi, v_r, x_0) = scene, time, state
    base, mode = base_at(u_dd, dt, n, s), decode_mode(code)
    equation, ramp = mode_equation(plant, law, waves, mode, x_0, base)
    forces, x_origin = mode_forces(plant, law, mode, x_0), origin_of(law, mode.origin)
    return ResumedSegment(mode, equation, ramp, forces, x_origin, xi, v_r, base.u_0, base.slope)


@compiled
def motion_in_segment(waves, part, s):
    """Return xi and v_r at time s of a resumed segment."""
    if part.mode.direction == AT_REST:
        return part.xi, 0.0
    if s == 0.0:
        return part.xi, part.v_r
    return motion_at(part.equation, waves, part.xi, part.v_r, s)[:2]


@compiled
def fill_segments(rows, samples, row, steps, out):
    """Write the segments of a motion over samples, one per whole step; return their number.

    Parameters
    ----------
    rows : Segments
        Those that do not begin at a sample in the mode before.
    samples : SampledMotion
        State at every sample.
    row : int
        Number of the first row at or after the first step.
    steps : (int, int)
        First step, and the one to stop before. Of that one the start is written, too.
    out : Segments
        Written.
    """
    first, end = steps
    count, last = int(ZERO), len(rows.n)
    for n in range(first, end + 1):
        if row < last and rows.n[row] == n and rows.s[row] == 0.0:
            state, d = (rows.x_r[row], rows.v_r[row], rows.x_0[row]), rows.d[row]
            count, row = record_segment(out, count, (n, 0.0), state, d), row + 1
        elif n < end or row < last:
            state = samples.x_r[n], samples.v_r[n], rows.x_0[row - 1]
            count = record_segment(out, count, (n, 0.0), state, rows.d[row - 1])
        while n < end and row < last and rows.n[row] == n:
            time, state = (n, rows.s[row]), (rows.x_r[row], rows.v_r[row], rows.x_0[row])
            count, row = record_segment(out, count, time, state, rows.d[row]), row + 1
    return count


# Motion at given times.


@compiled
def evaluate_segments(solution, t, out):
    """Write a motion at ascending times t [s] to `Points`."""
    (_, law, waves, _, dt), segments = solution
    i = resumed = int(ZERO)
    part = resume_segment(solution, i)
    for k in range(len(t)):
        i = segment_index(segments, dt, i, t[k])
        if resumed != i:
            part = resume_segment(solution, i)
            resumed = i
        s = t[k] - (segments.n[i] * dt + segments.s[i])
        state = motion_in_segment(waves, part, s)
        u_dd = base_motion(waves, part.u_0, part.slope, s)[0]
        load = max(load_at(law, waves, part.ramp, s)[0], 0.0)
        write_point(solution.scene, part.mode, part.forces, state, (u_dd, load), k, out)


@compiled
def evaluate_samples(solution, samples, out):
    """Write a solution over samples, under a constant normal force, to `Points`.

    Parameters
    ----------
    solution : SampledSolution
    samples : (int, int)
        First sample, and the one after the last.
    out : Points
        Written. Where the mode changes at a sample, they are those after it.
    """
    scene, motion, rows = solution
    (first, end), i = samples, last_event_index(rows.n, samples[0])
    while i > 0 and rows.n[i] == first and rows.s[i] > 0.0:
        i -= 1
    n = first
    while n < end:
        # The last row that begins at or before sample n.
        while i + 1 < len(rows.n) and rows.n[i + 1] + (rows.s[i + 1] > 0.0) <= n:
            i += 1
        until = end
        if i + 1 < len(rows.n):
            until = min(until, rows.n[i + 1] + (rows.s[i + 1] > 0.0))
        mode = decode_mode(rows.d[i])
        forces = mode_forces(scene.plant, scene.law, mode, rows.x_0[i])
        for k in range(n, until):
            state = motion.x_r[k], motion.v_r[k]
            write_point(scene, mode, forces, state, (scene.u_dd[k], 1.0), k - first, out)
        n = until


@inlined
def write_point(scene, mode, forces, state, base, k, out):
    """Write one of the `Points`.

    Parameters
    ----------
    scene : Scene
    mode, forces
        Of the segment.
    state : (float, float)
        xi [m], and v_r where the mass moves [m/s].
    base : (float, float)
        ü [m/s²], and relative normal force [-], at least 0.
    k : int
        Index of the point.
    out : Points
    """
    plant, law, _, _, _ = scene
    xi, u_dd, load, moves = state[0], base[0], base[1], mode.direction != AT_REST
    x_r, v_r = origin_of(law, mode.origin) + xi, state[1] if moves else 0.0
    F_f, F_stop = friction_and_stop_forces(law, mode, forces, (xi, v_r), u_dd, load)
    d = int(moves) if v_r >= 0.0 else -int(moves)
    if is_rigid_slip(law, mode):
        d = mode.contact
    pull = forces.plant.b * v_r + plant.k_x * x_r + F_f + F_stop
    out.x_r[k], out.v_r[k], out.d[k] = x_r, v_r, d
    out.x_dd[k] = -pull / plant.m if moves else u_dd
    out.F_f[k], out.F_stop[k] = F_f, F_stop
    out.z[k] = x_r - F_f / law.k_t if law.k_t > 0.0 else 0.0


@compiled
def state_in_step(solution, n, t):
    """Return x_r [m], v_r [m/s] and F_f [N] of a `SampledSolution` at a time t [s] in step n.

    Where the state changes at this time, as at an impact, it is that after it.
    """
    scene, samples, rows = solution
    i = last_row_index(rows, scene.dt, n, t)
    s, xi, v_r = 0.0, samples.x_r[n], samples.v_r[n]
    if rows.n[i] == n:
        s, xi, v_r = rows.s[i], rows.x_r[i], rows.v_r[i]
    part = resume_mode(scene, (n, s), (xi, v_r, rows.x_0[i]), rows.d[i])
    s, law, waves = t - (n * scene.dt + s), scene.law, scene.waves
    state = motion_in_segment(waves, part, s)
    u_dd = base_motion(waves, part.u_0, part.slope, s)[0]
    load = max(load_at(law, waves, part.ramp, s)[0], 0.0)
    F_f, _ = friction_and_stop_forces(law, part.mode, part.forces, state, u_dd, load)
    return part.x_origin + state[0], state[1], F_f


# Motion on a grid under sines: linear combinations of table columns.

FLOW_ROWS = 3
"""Rows of the free motion: y, y_d and Y of `flow`."""

RESPONSE_ROWS = 3
"""Rows of a wave: R, P and P_d of `sine_response`, or sin(omega s)/omega, cos(omega s) and the
derivative of the latter where the steady response is used."""


def table_shape(size: int) -> tuple[int, int]:
    """Return the shape of the table for a number of waves: turns, free motion, responses."""
    return FLOW_ROWS + (TURN_ROWS + RESPONSE_ROWS) * size, GRID_COLUMNS


@compiled
def sample_coulomb_grid(scene, events, first, dt, table, out):
    """Write a motion with Coulomb friction under waves at the grid points n·dt.

    Parameters
    ----------
    scene : (Plant, CoulombLaw, Waves)
    events : tuple
        Time [s], kind and x_r [m] of the events as arrays, of which the first is the start; and
        v_r there [m/s], which is 0 at every later event.
    first : int
        Index of the first grid point.
    dt : float
        Grid spacing [s].
    table : array, shape `table_shape`
        Work space for the responses over whole grid steps.
    out : tuple of array, shape (n,)
        Written: x_r [m], v_r [m/s], direction of sliding, x_dd [m/s²].

    Notes
    -----
    The motion is the steady response plus a free motion that starts with the difference from
    it. The sums restart at every `GRID_COLUMNS`-th point after an event, counted from the
    event and not from `first`. The result is therefore independent of the blocks in which a
    grid is written.
    """
    (plant, law, waves), (t, kind, x_r, v_first) = scene, events
    x_out, v_out, d_out, x_dd = out
    c, w, last = plant.b / plant.m, plant.k_x / plant.m, first + len(d_out)
    event, n = last_event_index(t, first * dt), first
    fill_table(plant, law, waves, dt, table)
    flow_row = TURN_ROWS * waves.size
    y, y_d, Y = table[flow_row], table[flow_row + 1], table[flow_row + 2]
    while n < last:
        while event + 1 < len(t) and t[event + 1] <= n * dt:
            event += 1
        d = sign(kind[event])
        until = last
        if event + 1 < len(t):
            until = min(until, grid_index_before(t[event + 1], dt) + 1)
        if d == 0:
            for k in range(n - first, until - first):
                x_out[k], v_out[k], d_out[k] = x_r[event], 0.0, 0
            sample_base(waves, (n, until), dt, table, first, x_dd)
            n = until
            continue
        begin = grid_index_before(t[event], dt) + 1
        v_r, f = v_first if event == 0 else 0.0, d * law.F_fk / plant.m
        set_phases(waves, plant, law, t[event], d)
        while n < until:
            # Column 0 of the table is grid point `start`.
            start = n - (n - begin) % GRID_COLUMNS
            count = min(until, start + GRID_COLUMNS) - n
            x, v = transient_state(c, w, waves, x_r[event], v_r, -f, start * dt - t[event])
            push = -f - w * x
            column, point = n - start, n - first
            if column < 0 or point < 0:
                # Never true; tells the compiler that no index counts from the end.
                return
            for k in range(count):
                i = column + k
                x_out[point + k] = x + (v * y[i] + push * Y[i])
                v_out[point + k] = v * y_d[i] + push * y[i]
            for wave in range(waves.size):
                row = flow_row + FLOW_ROWS + RESPONSE_ROWS * wave
                R, P, P_d = table[row], table[row + 1], table[row + 2]
                from_sine, from_cosine = wave_coefficients(waves, wave, start * dt)
                for k in range(count):
                    i = column + k
                    x_out[point + k] += from_sine * R[i] + from_cosine * P[i]
                    v_out[point + k] += from_sine * P[i] + from_cosine * P_d[i]
            against = 0
            for k in range(count):
                d_out[point + k] = d
                against += v_out[point + k] * d <= 0.0
            # A sum of rows may have the wrong sign where |v_r| is of the size of rounding.
            for k in range(count if against > 0 else 0):
                if v_out[point + k] * d <= 0.0:
                    equation, s = Equation(c, w, -f, 0.0), (n + k) * dt - t[event]
                    state = motion_at(equation, waves, x_r[event], v_r, s)
                    x_out[point + k], v_out[point + k] = state[:2]
            for k in range(count):
                x_dd[point + k] = -(f + c * v_out[point + k] + w * x_out[point + k])
            # Any wave besides those of the base varies the friction.
            for wave in range(waves.base, waves.size):
                sine, cosine = table[TURN_ROWS * wave], table[TURN_ROWS * wave + 1]
                from_sine, from_cosine = turn_coefficients(waves, wave, start * dt)
                for k in range(count):
                    i = column + k
                    x_dd[point + k] -= from_sine * sine[i] + from_cosine * cosine[i]
            n += count


@inlined
def wave_coefficients(waves, i, t):
    """Return the coefficients of the response rows R and P of wave i, column 0 at t [s]."""
    values, wave = waves.values, WAVE_COLUMNS * i
    omega = values[wave + OMEGA]
    along, across = -values[wave + A], 0.0
    if values[wave + STEADY] > 0.0:
        along, across = values[wave + IN_PHASE], values[wave + QUADRATURE]
    angle = phase_at(values[wave + FREQUENCY], values[wave + PHASE], t)
    sine, cosine = math.sin(angle), math.cos(angle)
    return omega * (along * cosine - across * sine), along * sine + across * cosine


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
        row = WAVE_COLUMNS * i
        if values[row + STEADY] > 0.0:
            x_r -= values[row + STEADY_X]
            v_r -= values[row + STEADY_V]
        else:
            x_wave, v_wave, _, _, _ = response_from_rest(c, w, values, row, s, y, y_d)
            x += x_wave
            v += v_wave
    push = g - w * x_r
    return x + x_r + v_r * y + push * Y, v + v_r * y_d + push * y


@compiled
def fill_table(plant, law, waves, dt, table):
    """Write the table of a grid: turns of the waves, free motion, responses to the waves.

    Sets the phases of the waves, because `set_phases` decides which of them have a usable
    steady response.
    """
    c, w, d = plant.b / plant.m, plant.k_x / plant.m, int(ZERO)
    set_phases(waves, plant, law, 0.0, d)
    fill_turns(waves, dt, table)
    row = TURN_ROWS * waves.size
    y, y_d, Y = table[row], table[row + 1], table[row + 2]
    for k in range(FIRST_COLUMNS):
        y[k], y_d[k], Y[k] = free_response(c, w, k * dt)
    for k in range(FIRST_COLUMNS, GRID_COLUMNS, FIRST_COLUMNS):
        a, a_d, a_sum = free_response(c, w, k * dt)
        for j in range(FIRST_COLUMNS):
            # The free motion over both times, one after the other.
            y[k + j] = (a_d + c * a) * y[j] + a * y_d[j]
            y_d[k + j] = a_d * y_d[j] - w * a * y[j]
            Y[k + j] = a_sum + a * y[j] + (1.0 - w * a_sum) * Y[j]
    for i in range(waves.size):
        row += RESPONSE_ROWS
        R, P, P_d = table[row], table[row + 1], table[row + 2]
        sine, cosine = table[TURN_ROWS * i], table[TURN_ROWS * i + 1]
        omega = waves.values[WAVE_COLUMNS * i + OMEGA]
        for k in range(GRID_COLUMNS):
            s = k * dt
            if waves.values[WAVE_COLUMNS * i + STEADY] > 0.0:
                R[k], P[k] = sine[k] / omega if omega > 0.0 else s, cosine[k]
                P_d[k] = -omega * omega * R[k]
            else:
                R[k], P[k], P_d[k], _, _ = sine_response(c, w, omega, s, y[k], y_d[k])


@inlined
def grid_index_before(t, dt):
    """Return the index of the last grid point before time t [s]; -1 if there is none."""
    n = int(t / dt)
    while n * dt >= t:
        n -= 1
    while (n + 1) * dt < t:
        n += 1
    return n


# Integrals by Gauss-Legendre quadrature on panels. Nodes and weights on [0, 1] are literals:
# importing them from numpy is slow.

SIX_NODES = (
    0.03376524289842399, 0.16939530676686773, 0.38069040695840156, 0.6193095930415985,
    0.8306046932331322, 0.966234757101576,
)  # fmt: skip

SIX_WEIGHTS = (
    0.08566224618958518, 0.1803807865240693, 0.23395696728634552, 0.23395696728634552,
    0.1803807865240693, 0.08566224618958518,
)  # fmt: skip

NODES = FOUR_NODES + SIX_NODES + TWELVE_NODES
WEIGHTS = FOUR_WEIGHTS + SIX_WEIGHTS + TWELVE_WEIGHTS

FOUR, SIX, TWELVE = (0, 4), (4, 10), (10, 22)
"""All rules, and where each begins and ends: one kernel takes any."""

PANEL_RADIANS = 4.0
"""Radians (or decays) per panel. A square varies twice as fast: twelve nodes integrate
exp(±2i·4) with an error of 4e-17."""

FOUR_NODE_PANELS = 0.025
"""Panels, as a share of `panel_length`, up to which four nodes suffice: a tenth of a radian,
where their error is 1e-15 of the product of two amplitudes, and 2e-11 of the integral over a
segment that begins or ends at rest."""

SIX_NODE_PANELS = 0.125
"""Panels, as a share of `panel_length`, up to which six nodes suffice: half a radian, where
their error is 2e-16 of a product."""

CUBIC_START = 32.0
"""Ratio of |x_r| + |v_r| s + |a| s² at the start to the growth |j| s³ by the jerk in a time s,
below which x_r is close to a cubic. Of its square four nodes then miss up to 3e-7 within a
tenth of a radian; above they miss 1e-11."""

TIME_ROUNDING = 1e-15
"""Relative rounding error of the time of an event."""

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


class SegmentSums(NamedTuple):
    """Integrals over segments, as the fields of `Totals` that have these names.

    What a force does is integrated from the force that the law demands of the state, not from
    that of the mode of the segment: friction takes its limit times |v_r|. A motion in a wrong
    mode then leaves a residual of the energy.
    """

    x2: float
    v2: float
    x_dd2: float
    power: float
    sliding_distance: float
    stuck: float
    stop_work: float
    damper_work: float
    violation: float


NO_SUMS = SegmentSums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def add_segment_sums(first, second):
    """Return the sum of two `SegmentSums`."""
    return SegmentSums(
        first.x2 + second.x2,
        first.v2 + second.v2,
        first.x_dd2 + second.x_dd2,
        first.power + second.power,
        first.sliding_distance + second.sliding_distance,
        first.stuck + second.stuck,
        first.stop_work + second.stop_work,
        first.damper_work + second.damper_work,
        max(first.violation, second.violation),
    )


@compiled
def integrate_segments(solution, begin, end, peak):
    """Integrate segments over their parts between two times, and find the peak of |x_dd|.

    Parameters
    ----------
    solution : Solution
        It need not be complete: a segment ends with its step, or where the next one begins.
    begin, end : float
        Window of integration [s].
    peak : float
        Largest |x_dd| known so far [m/s²].

    Returns
    -------
    sums : SegmentSums
        `sliding_distance` is the energy dissipated in the contact divided by the larger F_fk;
        `stop_work` does not include the energy lost in rigid impacts, which have no duration.
    peak : float
        The larger of `peak` and |x_dd| in the segments; `peak` where waves act.
    """
    scene, segments = solution
    waves, dt, sums = scene.waves, scene.dt, NO_SUMS
    for i in range(len(segments.n)):
        lo, hi = segment_window(segments, dt, i, begin, end)
        if hi <= lo or segments.d[i] == ARRIVAL:
            continue
        t = segments.n[i] * dt + segments.s[i]
        part = resume_segment(solution, i)
        sums = add_segment_sums(sums, integrate_part(scene, part, t, lo, hi))
        if waves.size == 0:
            peak = peak_in_segment(waves, part, lo, hi, peak)
    return sums, peak


@compiled
def integrate_part(scene, part, t, lo, hi):
    """Integrate a resumed segment, which begins at t [s], between two times since then [s]."""
    plant, law, waves, _, _ = scene
    if part.mode.entry == CHATTERING:
        return integrate_chatter(plant, law, waves, part, lo, hi)
    if part.mode.direction == AT_REST:
        return integrate_rest(law, waves, part, lo, hi)
    return integrate_motion(law, waves, part, t, lo, hi)


@compiled
def peak_in_segment(waves, part, lo, hi, peak):
    """Return the larger of `peak` and |x_dd| between two times of a segment without waves."""
    u_0, u_1 = part.u_0 + part.slope * lo, part.u_0 + part.slope * hi
    if part.mode.direction == AT_REST:
        return max(peak, abs(u_0), abs(u_1))
    c, w, g, r = part.equation
    xi, v_r = motion_in_segment(waves, part, lo)
    e, length = g + r * lo - c * v_r - w * xi, hi - lo
    decay = Decay(c, w, u_0, part.slope, e, r - c * e - w * v_r)
    highest = abs(u_0 + e)
    # Where even this bound is below the peak, the other end need not be known.
    if highest + length * (abs(part.slope) + abs(decay.e_1) + length * bend(decay)) <= peak:
        return peak
    xi, v_r = motion_in_segment(waves, part, hi)
    highest = max(highest, abs(u_1 + g + r * hi - c * v_r - w * xi))
    return peak_of_segment(decay, highest, length, max(peak, highest))


@compiled
def integrate_chatter(plant, law, waves, part, lo, hi):
    """Integrate the rest of a chatter against a rigid stop."""
    load = load_at(law, waves, part.ramp, 0.0)[0]
    u = base_motion(waves, part.u_0, part.slope, 0.0)[0]
    p, q = return_accelerations(plant, law, part.mode, part.forces.x_0, u, load)
    x_dd2 = chatter_mean_square(u, part.mode.origin, p, q)
    x, length = part.x_origin, hi - lo
    return SegmentSums(x * x * length, 0.0, x_dd2 * length, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def integrate_rest(law, waves, part, lo, hi):
    """Integrate a segment at rest, where x" is that of the base.

    The violation is the force that neither the static limit nor a rigid stop, which only
    pushes, may carry.
    """
    mode, forces = part.mode, part.forces
    m, x_r = forces.plant.m, part.x_origin + part.xi
    wall = wall_side(law, mode, part.xi)
    sticks = law.k_t == 0.0 and mode.contact == HOLD
    up, down = (law.up.F_fs, law.down.F_fs) if sticks else (0.0, 0.0)
    pull = forces.plant.k_x * x_r + bumper_force(forces, part.xi, 0.0)
    x_dd2, violation, s = 0.0, 0.0, lo
    # Without waves all terms are at most quadratic in time.
    rule = TWELVE if waves.size > 0 else FOUR
    while s < hi:
        length = min(panel_length(0.0, 0.0, waves, s), hi - s)
        for k in range(rule[0], rule[1]):
            time = s + length * NODES[k]
            u = base_motion(waves, part.u_0, part.slope, time)[0]
            x_dd2 += length * WEIGHTS[k] * u * u
            load = max(load_at(law, waves, part.ramp, time)[0], 0.0)
            friction = 0.0 if sticks else contact_force(forces, x_r, load)
            F_L = m * u + pull + friction
            above = -F_L - up * load if wall <= 0 else 0.0
            below = F_L - down * load if wall >= 0 else 0.0
            size = abs(m * u) + abs(pull) + abs(friction) + max(up, down)
            violation = max(violation, relative(max(above, below), size))
            if not sticks:
                violation = max(violation, contact_violation(law, part, x_r, load))
        s = s + length if length < hi - s else hi
    return SegmentSums(
        x_r * x_r * (hi - lo), 0.0, x_dd2, 0.0, 0.0, hi - lo, 0.0, 0.0, violation
    )


@compiled
def integrate_motion(law, waves, part, t, lo, hi):
    """Integrate a segment in motion, which begins at t [s], by Gauss quadrature on panels."""
    c, w, g, r = part.equation
    longest, rule = panel_length(c, w, waves, lo), TWELVE
    if hi - lo <= SIX_NODE_PANELS * longest:
        rule = FOUR if hi - lo <= FOUR_NODE_PANELS * longest else SIX
        _, _, a, j, _ = motion_at(part.equation, waves, part.xi, part.v_r, 0.0)
        if starts_as_cubic(part.x_origin + part.xi, part.v_r, a, j, hi):
            rule = SIX
    starts = part.v_r == 0.0 and is_rigid_slip(law, part.mode)
    early = early_slip(law, waves, part, t) if starts else 0.0
    # A power series is cheaper than the flow at each node.
    short, series = waves.size == 0 and (c + math.sqrt(w)) * hi <= SERIES_SEGMENT, NO_SERIES
    if short:
        a = g - c * part.v_r - w * part.xi
        j = r - c * a - w * part.v_r
        series = velocity_series(series_factors(c, w), part.v_r, a, j)
    sums, s = SegmentSums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, early), lo
    while s < hi:
        length = min(panel_length(c, w, waves, s), hi - s)
        panel = rule, s, length
        sums = add_segment_sums(sums, integrate_panel(law, waves, part, short, series, panel))
        s = s + length if length < hi - s else hi
    return sums


@inlined
def starts_as_cubic(x, v, a, j, s):
    """Return whether x_r grows by its jerk alone over a time s, from nearly 0."""
    return abs(x) + s * (abs(v) + s * abs(a)) < CUBIC_START * abs(j) * s * s * s


NO_SERIES = (0.0,) * 12
"""Coefficients in place of those of `velocity_series`."""


@merged
def integrate_panel(law, waves, part, short, series, panel):
    """Integrate one panel by one of the rules.

    `series` is the velocity in a segment that is short, as from `velocity_series`; the panel is
    its rule, its start and its length [s].
    """
    rule, s, length = panel
    (m, k_x, b), k_t, x_0, F, k_s, offset, b_s, reference = part.forces
    x2, v2, x_dd2, power, loss, stop_work, distance = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    damper_work, violation = 0.0, 0.0
    yields = law.k_t > 0.0 and abs(part.mode.contact) == 1
    lag = part.mode.contact * law.up.F_fk / law.k_t if yields else 0.0
    for k in range(rule[0], rule[1]):
        time, weight = s + length * NODES[k], length * WEIGHTS[k]
        if short:
            xi, v = part.xi + series_distance(series, time), series_velocity(series, time)
        else:
            xi, v, _, _, _ = motion_at(part.equation, waves, part.xi, part.v_r, time)
        u = base_motion(waves, part.u_0, part.slope, time)[0]
        load, load_d = load_at(law, waves, part.ramp, time)
        load = max(load, 0.0)
        x = part.x_origin + xi
        F_f = k_t * (x - x_0) + F * load
        F_stop = k_s * xi - offset + b_s * v
        x_dd = (k_x * x + b * v + F_f + F_stop) / m
        side = law.up if v > 0.0 else law.down
        x2 += weight * x * x
        v2 += weight * v * v
        x_dd2 += weight * x_dd * x_dd
        power += weight * u * v
        distance += weight * load * abs(v)
        damper_work += weight * side.b * v * v
        if yields:
            # The slider lags behind the mass as the spring of the contact follows the limit.
            loss += weight * side.F_fk * load * abs(v - lag * load_d)
        elif law.k_t == 0.0:
            loss += weight * side.F_fk * load * abs(v)
        else:
            violation = max(violation, contact_violation(law, part, x, load))
        depth = max(penetration(law, part, 1, xi), penetration(law, part, -1, xi))
        if depth > 0.0 and law.k_s[0] > 0.0:
            stop_work += weight * pushing_bumper_power(law, depth, v if x > 0.0 else -v)
        elif depth > 0.0:
            violation = max(violation, relative(depth, abs(x)))
    slid = loss / reference if reference > 0.0 else distance
    return SegmentSums(x2, v2, x_dd2, power, slid, 0.0, stop_work, damper_work, violation)


# What the law demands of a motion.


@inlined
def relative(excess, size):
    """Return an excess relative to a size, 0 if there is none."""
    return excess / size if excess > 0.0 else 0.0


@inlined
def contact_violation(law, part, x_r, load):
    """Return by how much an elastic contact exceeds its limit, or is apart under load [-]."""
    if part.mode.contact == FREE:
        return load
    F_fk = law.up.F_fk
    excess = abs(contact_force(part.forces, x_r, load)) - F_fk * load
    return relative(excess, F_fk + law.k_t * (abs(x_r) + abs(part.forces.x_0)))


@inlined
def penetration(law, part, side, xi):
    """Return how far the mass is beyond the end stop on a side [m], below 0 within."""
    if part.mode.origin == side:
        return side * xi
    return side * (part.x_origin + xi) - side_of(law, side).limit


@inlined
def pushing_bumper_power(law, depth, v_r):
    """Return the power done on a bumper, which only pushes [W], at an outward velocity."""
    force = law.b_s * v_r
    for i in range(MAX_STAGES):
        force += law.k_s[i] * max(depth - law.begins[i], 0.0) if law.k_s[i] > 0.0 else 0.0
    return max(force, 0.0) * v_r


@compiled
def early_slip(law, waves, part, t):
    """Return by how much a slip from v_r = 0 at time t [s] begins below the static limit [-].

    The rounding of the time of the event, to which the force under waves belongs, is allowed.
    """
    forces, d = part.forces, part.mode.contact
    u, u_d, _ = base_motion(waves, part.u_0, part.slope, 0.0)
    load, load_d = load_at(law, waves, part.ramp, 0.0)
    hold, m = side_of(law, d).F_fs, forces.plant.m
    pull = forces.plant.k_x * (part.x_origin + part.xi) + bumper_force(forces, part.xi, 0.0)
    drift = TIME_ROUNDING * t * (abs(m * u_d) + hold * abs(load_d))
    shortfall = hold * max(load, 0.0) + d * (m * u + pull) - drift
    return relative(shortfall, abs(m * u) + abs(pull) + hold)


# Peak force of a bumper.

PEAK_SUBDIVISIONS = 40.0
"""Parts per panel, a tenth of a radian each, in which a bumper force has at most one
extremum."""


@compiled
def peak_bumper_force(solution, begin, end):
    """Return the greatest force of a bumper between `begin` and `end` [N]."""
    (_, _, waves, _, dt), segments = solution
    greatest = 0.0
    for i in range(len(segments.n)):
        s, hi = segment_window(segments, dt, i, begin, end)
        if hi < s or segments.d[i] == ARRIVAL:
            continue
        part = resume_segment(solution, i)
        if part.forces.k_s == 0.0:
            continue
        force, rate = bumper_force_and_rate(waves, part, s)
        greatest = max(greatest, force)
        while s < hi and part.mode.direction != AT_REST:
            longest = panel_length(part.equation.c, part.equation.w, waves, s)
            length = min(longest / PEAK_SUBDIVISIONS, hi - s)
            until = s + length if length < hi - s else hi
            force, after = bumper_force_and_rate(waves, part, until)
            greatest = max(greatest, force)
            if rate > 0.0 and after < 0.0:
                greatest = max(greatest, local_force_peak(waves, part, s, until))
            s, rate = until, after
    return greatest


@compiled
def bumper_force_and_rate(waves, part, s):
    """Return the force of a bumper [N] and its rate [N/s] at time s of a segment."""
    side, forces = sign(part.mode.end_stop), part.forces
    x, v, a = part.xi, 0.0, 0.0
    if part.mode.direction != AT_REST:
        x, v, a, _, _ = motion_at(part.equation, waves, part.xi, part.v_r, s)
    force = forces.k_s * x - forces.offset + forces.b_s * v
    return side * force, side * (forces.k_s * v + forces.b_s * a)


@compiled
def local_force_peak(waves, part, low, high):
    """Return the maximum of a bumper force that rises at time `low` and falls at `high` [N]."""
    s = 0.5 * (low + high)
    for _ in range(MAX_BISECTIONS):
        rate = bumper_force_and_rate(waves, part, s)[1]
        low, high = (s, high) if rate > 0.0 else (low, s)
        if high - low <= RESOLUTION * high:
            break
        s = 0.5 * (low + high)
    return bumper_force_and_rate(waves, part, s)[0]
