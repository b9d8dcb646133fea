"""Forcing and motion within a segment: base acceleration, normal force, closed-form motion.

Problem
    Within a segment the base acceleration is ü = u_0 + slope·s + Σ A sin(omega s + theta), with
    s the time since its start. Friction limits that vary with the normal force add one more
    sine, in the direction of sliding. The motion and its derivatives are needed at any s.

Method
    - The sines ("waves") are rows of a flat table; `set_phases` updates their phases and steady
      responses at the start of a segment.
    - `motion_at` adds the steady response of each wave and the free motion, which starts from
      the start state less the steady states. Where the time is short or a wave is close to
      resonance, these two would cancel, and the response from rest (`sine_response`) takes the
      place of the steady response.
    - `mean_squares` integrates ü² and u² of a sum of sines in closed form.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from drysim.core.compile import compiled, inlined
from drysim.core.model import CoulombLaw, Plant
from drysim.core.oscillator import SHORT_SEGMENT, flow, free_response, sine_response

# Waves.

WAVE_COLUMNS = 12
"""Columns of a wave in the flat table. One array costs less per call than one per column."""

A, FREQUENCY, OMEGA, PHASE = 0, 1, 2, 3
"""Amplitude of ü [m/s²], frequency [Hz], angular frequency [rad/s], phase at t = 0 [rad]."""

THETA, SINE, COSINE = 4, 5, 6
"""Phase at the start of the segment [rad], its sine and its cosine."""

IN_PHASE, QUADRATURE, STEADY_X, STEADY_V, STEADY = 7, 8, 9, 10, 11
"""Steady response IN_PHASE·sin + QUADRATURE·cos [m]; its state at the start of the segment
[m, m/s]; and whether it may be used (0 no, 1 yes once the segment is long enough, 2 yes in a
stiff system that follows the wave quasi-statically)."""

UNSET_COLUMNS = (0.0,) * (WAVE_COLUMNS - THETA)
"""Initial values of the columns that `set_phases` computes."""

MAX_AMPLIFICATION_SQUARED = 16.0
"""Largest square of the steady amplitude relative to A/(w + omega²) up to which the steady
response is used: subtracting it then costs at most two bits."""


class Waves(NamedTuple):
    """Sum of sines that drives a segment.

    Attributes
    ----------
    values : array (or list) of float, shape (WAVE_COLUMNS·size,)
        Row by row the columns named above; `set_phases` computes those from THETA on.
    size : int
        Number of waves.
    base : int
        Number of waves of the base motion. If size > base, the last wave is the variation of
        kinetic friction, whose amplitude `set_phases` computes for the direction of sliding.
    """

    values: Any
    size: int
    base: int


class Scene(NamedTuple):
    """What a march needs to know and does not change.

    Attributes
    ----------
    plant : Plant
    law : KernelLaw, CoulombLaw or DynamicLaw
    waves : Waves
    u_dd, dt : array of float, float
        Base acceleration besides the waves at the samples [m/s²], and their interval [s].
    """

    plant: Any
    law: Any
    waves: Any
    u_dd: Any
    dt: float


@compiled
def set_wave(values, i, amplitude, frequency, phase):
    """Write amplitude, frequency and phase of wave i into the table."""
    row = WAVE_COLUMNS * i
    values[row + A] = amplitude
    values[row + FREQUENCY] = frequency
    values[row + OMEGA] = 2.0 * math.pi * frequency
    values[row + PHASE] = phase


@inlined
def set_phases(waves, plant, law, t, d):
    """Start a segment at t [s], sliding in direction d: compute phases and steady responses.

    Also sets the amplitude of the friction wave: d·F_fk·variation/m.
    """
    c = plant.b / plant.m
    w = plant.k_x / plant.m
    values = waves.values
    if waves.size > waves.base:
        values[WAVE_COLUMNS * waves.base + A] = d * law.F_fk * law.variation / plant.m
    for i in range(waves.size):
        row = WAVE_COLUMNS * i
        theta = phase_at(values[row + FREQUENCY], values[row + PHASE], t)
        sine, cosine = math.sin(theta), math.cos(theta)
        values[row + THETA] = theta
        values[row + SINE] = sine
        values[row + COSINE] = cosine
        omega = values[row + OMEGA]
        spring = w - omega * omega
        size = spring * spring + (c * omega) ** 2
        values[row + STEADY] = 0.0
        if size > 0.0 and MAX_AMPLIFICATION_SQUARED * size >= (w + omega * omega) ** 2:
            along = -values[row + A] * spring / size
            across = values[row + A] * c * omega / size
            values[row + STEADY] = 1.0
            values[row + IN_PHASE] = along
            values[row + QUADRATURE] = across
            values[row + STEADY_X] = along * sine + across * cosine
            values[row + STEADY_V] = omega * (along * cosine - across * sine)


@inlined
def phase_at(f, phase, t):
    """Return the phase 2π f t + phase of a wave at t [s], whole periods removed [rad]."""
    return 2.0 * math.pi * ((f * t) % 1.0) + phase


@inlined
def sine_and_cosine(values, row, omega, s):
    """Return sine and cosine of the phase of a wave at time s of a segment."""
    if s == 0.0:
        return values[row + SINE], values[row + COSINE]
    phase = omega * s + values[row + THETA]
    return math.sin(phase), math.cos(phase)


@inlined
def base_motion(waves, u_0, slope, s):
    """Return ü [m/s²] and its first two derivatives at time s of a segment."""
    u_dd = u_0 + slope * s
    rate = slope
    second_rate = 0.0
    values = waves.values
    for i in range(waves.base):
        row = WAVE_COLUMNS * i
        omega = values[row + OMEGA]
        sine, cosine = sine_and_cosine(values, row, omega, s)
        value = values[row + A] * sine
        u_dd += value
        rate += values[row + A] * omega * cosine
        second_rate -= value * omega * omega
    return u_dd, rate, second_rate


@inlined
def relative_normal_force(law, waves, s):
    """Return N/N_mean [-] at time s of a segment, and its first two derivatives."""
    if waves.size == waves.base:
        return 1.0, 0.0, 0.0
    sine, cosine = sine_and_cosine(waves.values, WAVE_COLUMNS * waves.base, law.omega, s)
    swing = law.variation * sine
    return 1.0 + swing, law.variation * law.omega * cosine, -swing * law.omega**2


@compiled
def force_rate_bounds(waves, r):
    """Return bounds on three derivatives of the force per mass, and the largest omega.

    Parameters
    ----------
    waves : Waves
        After `set_phases`.
    r : float
        Derivative of the force per mass without the waves [m/s³].
    """
    first, second, third, fastest = abs(r), 0.0, 0.0, 0.0
    for i in range(waves.size):
        omega = waves.values[WAVE_COLUMNS * i + OMEGA]
        rate = abs(waves.values[WAVE_COLUMNS * i + A]) * omega
        first += rate
        second += rate * omega
        third += rate * omega * omega
        fastest = max(fastest, omega)
    return first, second, third, fastest


# Base acceleration on a grid: linear combinations of table columns.

GRID_COLUMNS = 128
"""Grid points that follow from one by rotation, to a rounding or two."""

FIRST_COLUMNS = 16
"""Columns that are computed one by one, as is every so many-th; they give the others."""

TURN_ROWS = 2
"""Rows of a wave: sine and cosine of the angle by which it turns in 0, 1, ... grid steps."""


@compiled
def fill_turns(waves, dt, table):
    """Write `TURN_ROWS` rows a wave, the first ones of a table with `GRID_COLUMNS` columns."""
    for i in range(waves.size):
        turn = waves.values[WAVE_COLUMNS * i + OMEGA] * dt
        sine, cosine = table[TURN_ROWS * i], table[TURN_ROWS * i + 1]
        for k in range(FIRST_COLUMNS):
            sine[k], cosine[k] = math.sin(turn * k), math.cos(turn * k)
        for k in range(FIRST_COLUMNS, GRID_COLUMNS, FIRST_COLUMNS):
            s, c = math.sin(turn * k), math.cos(turn * k)
            for j in range(FIRST_COLUMNS):
                sine[k + j] = s * cosine[j] + c * sine[j]
                cosine[k + j] = c * cosine[j] - s * sine[j]


@compiled
def sample_base(waves, points, dt, table, first, u_dd):
    """Write ü of the waves [m/s²] at grid points n·dt.

    Parameters
    ----------
    waves : Waves
    points : (int, int)
        First grid point, and the one after the last.
    dt : float
        Grid spacing [s].
    table : array
        Rows of `fill_turns`.
    first : int
        Grid point of the first element of `u_dd`.
    u_dd : array
        Written.

    Notes
    -----
    Phases are computed at every `GRID_COLUMNS`-th point, counted from t = 0. The result is
    therefore independent of the blocks in which a grid is written.
    """
    n, last = points
    while n < last:
        start = n - n % GRID_COLUMNS
        count = min(last, start + GRID_COLUMNS) - n
        column, point = n - start, n - first
        if column < 0 or point < 0:
            # Never true; tells the compiler that no index counts from the end.
            return
        for k in range(count):
            u_dd[point + k] = 0.0
        for i in range(waves.base):
            sine, cosine = table[TURN_ROWS * i], table[TURN_ROWS * i + 1]
            from_sine, from_cosine = turn_coefficients(waves, i, start * dt)
            for k in range(count):
                u_dd[point + k] += (
                    from_sine * sine[column + k] + from_cosine * cosine[column + k]
                )
        n += count


@inlined
def turn_coefficients(waves, i, t):
    """Return the coefficients of the rows of `fill_turns` for wave i, column 0 at t [s]."""
    values, wave = waves.values, WAVE_COLUMNS * i
    angle = phase_at(values[wave + FREQUENCY], values[wave + PHASE], t)
    return values[wave + A] * math.cos(angle), values[wave + A] * math.sin(angle)


# A scene as a row of numbers, which costs less per call than tuples.

M, K_X, B, F_FK, F_FS, VARIATION, OMEGA_N, PHASE_N, X_R, V_R, SCENE_COLUMNS = range(11)
"""Columns of a scene: plant, law and start state. The waves, or other kernel inputs, follow
from SCENE_COLUMNS on."""


@inlined
def plant_and_law(scene):
    """Return the plant and the law of a scene."""
    law = CoulombLaw(scene[F_FK], scene[F_FS], scene[VARIATION], scene[OMEGA_N], scene[PHASE_N])
    return Plant(scene[M], scene[K_X], scene[B]), law


@inlined
def unpack_scene(scene):
    """Return plant, law and waves of a scene; a varying normal force is the last wave."""
    plant, law = plant_and_law(scene)
    values = scene[SCENE_COLUMNS:]
    size = len(values) // WAVE_COLUMNS
    return plant, law, Waves(values, size, size - 1 if law.variation != 0.0 else size)


# Motion within a segment.

TRANSIENT_DECAYS = 40.0
"""Value of c·s after which a strong damper has removed the initial difference in velocity:
e^-40 is below rounding."""


class Equation(NamedTuple):
    """x" + c x' + w x = g + r s + waves, at time s of a segment.

    Attributes
    ----------
    c, w : float
        As in `flow`.
    g, r : float
        Force per mass without the waves at the start [m/s²], and its derivative [m/s³].
    """

    c: float
    w: float
    g: float
    r: float


class Segment(NamedTuple):
    """Motion in one mode: its equation, and its state and derivatives at the start.

    Attributes
    ----------
    equation : Equation
    x_r, v_r, a, j, k : float
        As in `Motion`.
    """

    equation: Equation
    x_r: float
    v_r: float
    a: float
    j: float
    k: float


class Motion(NamedTuple):
    """Relative displacement [m], velocity, acceleration, jerk and snap [m/s⁴] at one time."""

    x_r: float
    v_r: float
    a: float
    j: float
    k: float


@inlined
def slip_equation(plant, law, d, u_0, slope):
    """Return the equation of sliding in direction d under ü = u_0 + slope·s plus the waves."""
    f = d * law.F_fk / plant.m
    return Equation(plant.b / plant.m, plant.k_x / plant.m, -u_0 - f, -slope)


@inlined
def start_segment(equation, waves, x_r, v_r):
    """Return the segment that starts in this state; waves after `set_phases`."""
    push, push_d, push_dd = equation.g, equation.r, 0.0
    for i in range(waves.size):
        row = WAVE_COLUMNS * i
        omega = waves.values[row + OMEGA]
        swing = waves.values[row + A] * waves.values[row + SINE]
        push -= swing
        push_d -= waves.values[row + A] * omega * waves.values[row + COSINE]
        push_dd += omega * omega * swing
    a = push - equation.c * v_r - equation.w * x_r
    j = push_d - equation.c * a - equation.w * v_r
    return Segment(equation, x_r, v_r, a, j, push_dd - equation.c * j - equation.w * a)


@compiled
def motion_at(equation, waves, x_r, v_r, s):
    """Return the `Motion` at time s of a segment.

    Parameters
    ----------
    equation : Equation
    waves : Waves
        After `set_phases` at the start of the segment.
    x_r, v_r : float
        State at the start [m, m/s].
    s : float
        Time since the start [s].
    """
    c, w, g, r = equation
    YY = 0.0
    if r == 0.0:
        y, y_d, Y = free_response(c, w, s)
    else:
        y, y_d, Y, YY = flow(c, w, s)
    x, v, a, j, k = 0.0, 0.0, 0.0, 0.0, 0.0
    values = waves.values
    for i in range(waves.size):
        row = WAVE_COLUMNS * i
        if values[row + A] == 0.0:
            continue
        omega = values[row + OMEGA]
        steady = values[row + STEADY]
        is_long = (
            omega * s > SHORT_SEGMENT
            or c * s > TRANSIENT_DECAYS
            or (steady > 1.0 and w * s * s > SHORT_SEGMENT * SHORT_SEGMENT)
        )
        if steady > 0.0 and is_long:
            swing, rate, push, push_d, push_dd = steady_response(values, row, s)
            # The start state less the steady state is the free motion.
            x_r -= values[row + STEADY_X]
            v_r -= values[row + STEADY_V]
        else:
            swing, rate, push, push_d, push_dd = response_from_rest(
                c, w, values, row, s, y, y_d
            )
        x += swing
        v += rate
        a += push
        j += push_d
        k += push_dd
    # Waves and free motion are summed separately, so that a free motion that decays under a
    # constant force keeps the signs of its velocity and acceleration.
    p = g - w * x_r
    a_start = (p - c * v_r) * y_d + (r - w * v_r) * y
    v_start = v_r * y_d + p * y + r * Y
    x += x_r + v_r * y + p * Y + r * YY
    j_start = r - c * a_start - w * v_start
    return Motion(x, v + v_start, a + a_start, j + j_start, k - c * j_start - w * a_start)


@inlined
def steady_response(values, row, s):
    """Return x_r, v_r, a, j and k of the steady response to a wave at time s."""
    omega = values[row + OMEGA]
    sine, cosine = sine_and_cosine(values, row, omega, s)
    swing = values[row + IN_PHASE] * sine + values[row + QUADRATURE] * cosine
    rate = omega * (values[row + IN_PHASE] * cosine - values[row + QUADRATURE] * sine)
    push, push_d = -omega * omega * swing, -omega * omega * rate
    return swing, rate, push, push_d, -omega * omega * push


@compiled
def response_from_rest(c, w, values, row, s, y, y_d):
    """Return x_r, v_r, a, j and k of the response to a wave from rest at time s."""
    omega = values[row + OMEGA]
    from_sine = -values[row + A] * values[row + COSINE]
    from_cosine = -values[row + A] * values[row + SINE]
    R, P, P_d, sine, cosine = sine_response(c, w, omega, s, y, y_d)
    x = from_sine * omega * R + from_cosine * P
    v = from_sine * omega * P + from_cosine * P_d
    push = from_sine * omega * sine + from_cosine * cosine
    a = push - c * v - w * x
    j = omega * (from_sine * cosine - from_cosine * omega * sine) - c * a - w * v
    return x, v, a, j, -omega * omega * push - c * j - w * a


# Mean squares of a base that moves by sines, in closed form.

SMALL_ANGLE = 0.5
"""Angle up to which six terms of the series suffice: the first omitted term, 6·0.5^12/15!, is
1.1e-15 of the first."""


@compiled
def mean_squares(waves, begin, end):
    """Return the mean squares of ü [m²/s⁴] and of u [m²] over a window [s].

    u is the displacement without offset and drift, -Σ A/(2π f)² sin(2π f t + phase).
    """
    length, middle = end - begin, 0.5 * (begin + end)
    u_dd2, u2 = 0.0, 0.0
    values = waves.values
    for i in range(waves.base):
        for j in range(waves.base):
            p, q = WAVE_COLUMNS * i, WAVE_COLUMNS * j
            at_i = phase_at(values[p + FREQUENCY], values[p + PHASE], middle)
            at_j = phase_at(values[q + FREQUENCY], values[q + PHASE], middle)
            # Time counts from the middle of the window: products of sine and cosine integrate
            # to zero.
            half_i = math.pi * values[p + FREQUENCY] * length
            half_j = math.pi * values[q + FREQUENCY] * length
            apart, along = one_minus_sinc(half_i - half_j), one_minus_sinc(half_i + half_j)
            product = values[p + A] * values[q + A] * (
                math.sin(at_i) * math.sin(at_j) * (1.0 - 0.5 * (apart + along))
                + math.cos(at_i) * math.cos(at_j) * 0.5 * (along - apart)
            )  # fmt: skip
            both = values[p + OMEGA] * values[q + OMEGA]
            u_dd2 += product
            u2 += product / (both * both)
    return u_dd2, u2


@compiled
def one_minus_sinc(x):
    """Return 1 - sin(x)/x without cancellation at small x."""
    if abs(x) > SMALL_ANGLE:
        return 1.0 - math.sin(x) / x
    s = x * x
    tail = 1.0 - s / 72.0 * (1.0 - s / 110.0 * (1.0 - s / 156.0))
    return s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * tail))
