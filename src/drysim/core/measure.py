"""Integrals and peak acceleration of a motion over samples.

Problem
    A march over samples leaves the state at every sample, and the starts of the segments that
    do not begin at one. The integrals over a window and the largest |x_dd| follow from them.
    They should cost less than the march: a few nanoseconds a step.

Method
    `measure_steps` goes through the motion once. Runs of whole steps in one mode apart from the
    stops, most of a motion, are summed; all other segments are integrated one by one.

    - Integrals over runs. In one mode a motion is linear in its state and in ü at both ends of
      a step, so that every integral is a quadratic form of these, the same for all steps. Only
      sums of products are formed step by step. Spring force and friction may nearly balance;
      then x_dd and the displacement are far smaller than either, and expanding their squares
      would cancel. The differences are therefore formed first and are variables of their own.
    - The distance slid is that between the ends of a step only where v_r keeps its direction.
      Steps in which it may turn are left to the quadrature.
    - Other segments are integrated by Gauss-Legendre quadrature (`trajectory`).
    - Peak of |x_dd|. The largest value at the samples of each run, and a bound of what lies
      between them, are formed in the same loop. Few runs may exceed the largest of all values
      and are searched (`peak`).

    Runs are loops without branches, which the compiler turns into vector instructions. In plain
    Python numpy does the same (`sum_run_plain`).
"""

from __future__ import annotations

import math
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from drysim.core.compile import (
    ZERO,
    as_engine_array,
    by_engine,
    compiled,
    inlined,
    python_of,
    summed,
)
from drysim.core.model import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.modes import (
    APART,
    ARRIVAL,
    AT_REST,
    CHATTERING,
    HOLD,
    decode_mode,
    load_varies,
    mode_forces,
    origin_of,
    side_of,
)
from drysim.core.oscillator import (
    SERIES_SEGMENT,
    SeriesFactors,
    flow,
    series_distance,
    series_factors,
    series_velocity,
    velocity_series,
)
from drysim.core.peak import Decay, bend, peak_of_segment
from drysim.core.roots import NEVER
from drysim.core.trajectory import (
    FOUR,
    FOUR_NODE_PANELS,
    NO_SUMS,
    NODES,
    PANEL_RADIANS,
    SIX,
    TIME_ROUNDING,
    WEIGHTS,
    SampledSolution,
    SegmentSums,
    add_segment_sums,
    base_at,
    fastest_rate,
    integrate_part,
    last_event_index,
    peak_in_segment,
    relative,
    resume_mode,
    starts_as_cubic,
)


class Runs(NamedTuple):
    """Runs of whole steps in one mode; arrays of shape (runs,).

    Attributes
    ----------
    row : array of int
        Index of the row whose mode it is.
    begin, end : array of int
        First step, and the one after the last.
    at_samples, between : array of float
        Largest |x_dd| at the samples of the run, its end included, and a bound of what it is
        exceeded by between two samples [m/s²].
    """

    row: Any
    begin: Any
    end: Any
    at_samples: Any
    between: Any


@compiled
def measure_steps(solution, steps, window, runs, sums, forms):
    """Return the integrals and the largest |x_dd| of some steps within a window.

    Parameters
    ----------
    solution : SampledSolution
    steps : (int, int)
        First step, and the one after the last.
    window : (float, float)
        Begin and end [s], in the first and in the last of these steps. A step that they cut
        belongs to no run.
    runs : Runs
        Work space for as many runs as there are rows up to the last step.
    sums : array, shape (GROUPS, SUMS)
        Work space.
    forms : array, shape (4, SUMS)
        Work space.

    Returns
    -------
    total : SegmentSums
        Without impacts on rigid stops, which take no time.
    peak : float
        [m/s²]; not meaningful where the normal force varies.
    """
    (plant, law, _, u_dd, dt), samples, rows = solution
    first, last = steps
    lowest, highest = first + int(window[0] > first * dt), last - int(window[1] < last * dt)
    varies = load_varies(law)
    w, fastest = plant.k_x / plant.m, max(law.up.b, law.down.b) / plant.m
    held = w + law.k_t / plant.m
    # Whether every segment is short, and there are no stops that it may meet.
    radians = (fastest + math.sqrt(held)) * dt
    short = radians <= SERIES_SEGMENT and min(law.up.limit, law.down.limit) == NEVER
    rule = FOUR if radians <= FOUR_NODE_PANELS * PANEL_RADIANS else SIX
    factors = (
        series_factors(law.down.b / plant.m, w),
        series_factors(law.down.b / plant.m, held),
        series_factors(law.up.b / plant.m, w),
        series_factors(law.up.b / plant.m, held),
    )
    for group in range(GROUPS):
        for k in range(SUMS):
            sums[group][k] = 0.0
    total, peak, count = NO_SUMS, 0.0, int(ZERO)
    i = last_event_index(rows.n, first - 1)
    while i < len(rows.n) and rows.n[i] < last:
        n, s, d, x_0 = rows.n[i], rows.s[i], rows.d[i], rows.x_0[i]
        followed = i + 1 < len(rows.n) and rows.n[i + 1] < last
        until = rows.n[i + 1] if followed else last
        after = rows.s[i + 1] if followed else 0.0
        mode = decode_mode(d)
        summed = not varies and d != ARRIVAL and is_summed(law, mode)
        rests = summed and mode.direction == AT_REST
        state = rows.x_r[i], rows.v_r[i], x_0
        if n < first:
            n, s, state = first, 0.0, (samples.x_r[first], samples.v_r[first], x_0)
        begin = end = until
        if summed:
            # Where the next mode begins at a sample, the motion there is that after it; at the
            # last sample of all it may be.
            goes_on = i + 1 < len(rows.n) and rows.n[i + 1] == until
            changes = goes_on and rows.s[i + 1] == 0.0
            stop = until - int(changes or until == len(u_dd) - 1)
            # A slide that begins in this step need not have its velocity at the sample.
            at_sample = rows.n[i] < first or (rests and s == 0.0 and until > n)
            begin = min(max(n + int(not at_sample), lowest), until)
            end = max(min(until if rests else stop, highest), begin)
        # The step in which the next mode begins belongs to this one, too.
        while n < until + int(after > 0.0):
            if n == begin and begin < end:
                runs.row[count], runs.begin[count], runs.end[count] = i, begin, end
                total, peak = sum_mode(solution, runs, count, window, sums, total, peak)
                n, count = end, count + 1
            else:
                length = (after if n == until else dt) - s
                whole = lowest <= n < highest and length > 0.0
                if summed and whole and (rests or short):
                    forces, base = run_forces(plant, law, d, x_0), base_at(u_dd, dt, n, s)
                    slide = Slide(forces, factors[group_of(forces)], rule)
                    part, peak = integrate_simple(plant, law, slide, base, state, length, peak)
                    total = add_segment_sums(total, part)
                else:
                    total, peak = add_segment(
                        solution.scene, window, (n, s, length), state, d, (total, peak)
                    )
                n += 1
            s = 0.0
            if n < len(u_dd):
                state = samples.x_r[n], samples.v_r[n], x_0
        i += 1
    for i in range(count):
        if runs.at_samples[i] + runs.between[i] > peak:
            peak = peak_of_run(solution, runs.row[i], runs.begin[i], runs.end[i], peak)
    for holds in (0, 1):
        w = (plant.k_x + law.k_t * holds) / plant.m
        # Both directions first: a mirrored motion exchanges them.
        down = group_sums(law.down.b, plant.m, w, dt, sums[holds], forms, holds)
        up = group_sums(law.up.b, plant.m, w, dt, sums[2 + holds], forms, holds)
        total = add_segment_sums(total, add_segment_sums(down, up))
    return total, peak


@compiled
def add_segment(scene, window, time, state, d, measured):
    """Return integrals and largest |x_dd| with those of a segment within a window.

    Parameters
    ----------
    scene : Scene
    window : (float, float)
        Begin and end [s].
    time : (int, float, float)
        Step, time since it began and length of the segment [s].
    state : tuple of float
        xi [m], v_r [m/s] and x_0 [m] at the start.
    d : int
        Encoded mode.
    measured : (SegmentSums, float)
        Integrals and largest |x_dd| before [m/s²].
    """
    (n, s, length), (total, peak) = time, measured
    t = n * scene.dt + s
    lo, hi = max(window[0] - t, 0.0), min(window[1] - t, length)
    if hi <= lo or d == ARRIVAL:
        return total, peak
    part = resume_mode(scene, (n, s), state, d)
    total = add_segment_sums(total, integrate_part(scene, part, t, lo, hi))
    if scene.waves.size == 0:
        peak = peak_in_segment(scene.waves, part, lo, hi, peak)
    return total, peak


@inlined
def rest_sums(plant, law, x_r, u2, low, high, length):
    """Return the integrals at rest from that of ü², its extremes and the time [s]."""
    violation = rest_violation(plant, law, x_r, low, high)
    return SegmentSums(x_r * x_r * length, 0.0, u2, 0.0, 0.0, length, 0.0, 0.0, violation)


@compiled
def integrate_rest_of_step(plant, law, x_r, base, length):
    """Return the integrals over a part of a step at rest, and its largest |x_dd| [m/s²]."""
    u_0, u_1 = base.u_0, base.u_0 + base.slope * length
    u2 = length * (u_0 * u_0 + u_0 * u_1 + u_1 * u_1) / 3.0
    # The rounding of the time at which it breaks away is no violation.
    drift = TIME_ROUNDING * base.t * abs(base.slope)
    low, high = min(u_0, u_1) + drift, max(u_0, u_1) - drift
    sums = rest_sums(plant, law, x_r, u2, low, high, length)
    return sums, max(abs(u_0), abs(u_1))


@compiled
def integrate_simple(plant, law, slide, base, state, length, peak):
    """Integrate rest, or a short motion without stops, under a constant normal force.

    As `integrate_part` and `peak_in_segment`; a motion by the power series of its velocity.

    Parameters
    ----------
    plant, law
    slide : Slide
    base : SegmentBase
    state : tuple of float
        xi [m], v_r [m/s] and x_0 [m] at the start.
    length : float
        [s].
    peak : float
        Largest |x_dd| before [m/s²].
    """
    (forces, factors, rule), (t, u_0, slope), m = slide, base, plant.m
    if forces.d == 0.0:
        sums, highest = integrate_rest_of_step(
            plant, law, forces.origin + state[0], base, length
        )
        return sums, max(peak, highest)
    c, w = forces.c, forces.spring + forces.hold
    x_0, v_0 = forces.origin + state[0], state[1]
    y_0 = c * v_0 + (forces.spring * x_0 + (forces.hold * (x_0 - forces.x_0) + forces.f))
    e = -(u_0 + y_0)
    decay = Decay(c, w, u_0, slope, e, -slope - c * e - w * v_0)
    series = velocity_series(factors, v_0, e, decay.e_1)
    if starts_as_cubic(x_0, v_0, e, decay.e_1, length):
        rule = SIX
    x2, v2, x_dd2, power, path, loss, damped, violation = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(rule[0], rule[1]):
        s, weight = length * NODES[k], length * WEIGHTS[k]
        x, v = x_0 + series_distance(series, s), series_velocity(series, s)
        y = c * v + (forces.spring * x + (forces.hold * (x - forces.x_0) + forces.f))
        side = law.up if v > 0.0 else law.down
        x2 += weight * x * x
        v2 += weight * v * v
        x_dd2 += weight * y * y
        power += weight * (u_0 + slope * s) * v
        path += weight * abs(v)
        loss += weight * side.F_fk * abs(v)
        damped += weight * side.b * v * v
        if forces.hold > 0.0:
            violation = max(violation, hold_violation(law, forces, x - forces.origin))
    if v_0 == 0.0 and law.k_t == 0.0:
        hold = side_of(law, int(forces.d)).F_fs
        pull, drift = m * forces.spring * x_0, TIME_ROUNDING * t * abs(m * slope)
        shortfall = hold + forces.d * (m * u_0 + pull) - drift
        violation = max(violation, relative(shortfall, abs(m * u_0) + abs(pull) + hold))
    reference = max(law.up.F_fk, law.down.F_fk)
    slid = 0.0
    if forces.hold == 0.0:
        slid = loss / reference if reference > 0.0 else path
    sums = SegmentSums(x2, v2, x_dd2, power, slid, 0.0, 0.0, damped, violation)
    highest = abs(y_0)
    if highest + length * (abs(slope) + abs(decay.e_1) + length * bend(decay)) > peak:
        x, v = x_0 + series_distance(series, length), series_velocity(series, length)
        y = c * v + (forces.spring * x + (forces.hold * (x - forces.x_0) + forces.f))
        highest = max(highest, abs(y))
        peak = peak_of_segment(decay, highest, length, max(peak, highest))
    return sums, peak


@compiled
def sum_mode(solution, runs, i, window, sums, total, peak):
    """Add run i to the sums of its group, or to the integrals; return these and max |x_dd|.

    Parameters
    ----------
    solution : SampledSolution
    runs : Runs
        `at_samples` and `between` are written.
    i : int
    window : (float, float)
        As in `measure_steps`.
    sums : array, shape (GROUPS, SUMS)
        Increased.
    total, peak : SegmentSums and float
        As in `add_segment`.
    """
    (plant, law, _, u_dd, dt), samples, rows = solution
    row, begin, end = runs.row[i], runs.begin[i], runs.end[i]
    forces = run_forces(plant, law, rows.d[row], rows.x_0[row])
    if forces.d == 0.0:
        x_r, length = forces.origin + samples.x_r[begin], (end - begin) * dt
        u2, low, high = sum_rest(u_dd, begin, end)
        rest = rest_sums(plant, law, x_r, u2 * dt, low, high, length)
        runs.at_samples[i], runs.between[i] = max(-low, high), 0.0
        return add_segment_sums(total, rest), max(peak, -low, high)
    bound, group = turning_bound(forces, dt), group_of(forces)
    motion = samples.x_r, samples.v_r, u_dd
    extremes = sum_run(forces, bound, motion, begin, end, sums[group])
    y = step_variables(forces, samples.x_r[end], samples.v_r[end], u_dd[end], u_dd[end])[5]
    runs.at_samples[i] = max(extremes.x_dd, abs(y))
    runs.between[i] = overshoot_bound(forces, dt, extremes)
    peak = max(peak, runs.at_samples[i])
    if extremes.turned > 0.0:
        for n in range(begin, end):
            v_0, v_1 = samples.v_r[n], samples.v_r[n + 1]
            if not keeps_direction(bound, forces.d, v_0, v_1, u_dd[n + 1] - u_dd[n]):
                state = samples.x_r[n], v_0, rows.x_0[row]
                total, peak = add_segment(
                    solution.scene, window, (n, 0.0, dt), state, rows.d[row], (total, peak)
                )
    if forces.hold > 0.0:
        violation = total.violation
        for n in range(begin, end):
            violation = max(violation, hold_violation(law, forces, samples.x_r[n]))
        total = with_violation(total, violation)
    return total, peak


@inlined
def with_violation(sums, violation):
    """Return the sums with another violation."""
    return SegmentSums(
        sums.x2, sums.v2, sums.x_dd2, sums.power, sums.sliding_distance, sums.stuck,
        sums.stop_work, sums.damper_work, violation,
    )  # fmt: skip


@compiled
def group_sums(b, m, w, dt, sums, forms, holds):
    """Return the integrals over the runs of a group from its sums of products.

    Parameters
    ----------
    b, m : float
        Damping [N·s/m] and mass [kg].
    w, dt : float
        Stiffness per mass [1/s²] and length of a step [s].
    sums : array, shape (SUMS,)
    forms : array, shape (4, SUMS)
        Work space.
    holds : int
        Whether the contact holds, so that nothing slides.
    """
    size = 0.0
    for k in range(PRODUCTS):
        size = max(size, abs(sums[k]))
    if size == 0.0:
        return NO_SUMS
    step_forms(b / m, w, dt, forms)
    x2, v2, x_dd2, power, slid = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(PRODUCTS):
        x2 += forms[0][k] * sums[k]
        v2 += forms[1][k] * sums[k]
        x_dd2 += forms[2][k] * sums[k]
        power += forms[3][k] * sums[k]
    for k in range(PRODUCTS, SUMS):
        slid += forms[0][k] * sums[k]
    # Squares, whatever rounding says.
    x2, v2, x_dd2 = max(x2, 0.0), max(v2, 0.0), max(x_dd2, 0.0)
    slid = 0.0 if holds == 1 else slid
    return SegmentSums(x2, v2, x_dd2, power, slid, 0.0, 0.0, b * v2, 0.0)


@compiled
def is_summed(law, mode):
    """Return whether whole steps in a mode are summed: at rest, held or sliding."""
    if mode.end_stop != APART or mode.entry == CHATTERING:
        return False
    if mode.direction == AT_REST:
        free = mode.origin == 0 or law.k_s[0] > 0.0
        return law.k_t == 0.0 and mode.contact == HOLD and free
    return mode.contact == mode.direction or (law.k_t > 0.0 and mode.contact == HOLD)


# Integrals over runs: quadratic forms.

FIRST = 0, 0, 0, 0, 1, 1, 1, 2, 2, 3, 1, 1, 3, 3, 4, 4, 5, 2
SECOND = 0, 1, 2, 3, 1, 2, 3, 2, 3, 3, 4, 5, 4, 5, 4, 5, 5, 4
"""Products of the `step_variables` that the integrals need."""

PRODUCTS = len(FIRST)

SUMS = PRODUCTS + 3
"""Sums of a group of runs: these products; v_r, the force and its increment, each times the
friction force over its reference."""

GROUPS = 4
"""Groups of runs with the same quadratic forms: by direction, and whether the contact holds."""

MIN_DIVISOR = 0.25
"""Divisor of the bound in `turning_bound` below which a step is too long for it: the bound is
then at most four times what the step's curvature gives."""


class RunForces(NamedTuple):
    """Forces in a run, per mass.

    Attributes
    ----------
    d : float
        Direction of motion.
    origin, x_0 : float
        Origin of xi, and x_r where the contact carries no force [m].
    c, spring, hold : float
        Damping [1/s], and stiffness of spring and contact [1/s²].
    f : float
        Friction of a contact that slides [m/s²].
    share : float
        The same over its reference [-]; the direction where the reference is 0.
    """

    d: float
    origin: float
    x_0: float
    c: float
    spring: float
    hold: float
    f: float
    share: float


class Slide(NamedTuple):
    """A mode under a constant normal force.

    Attributes
    ----------
    forces : RunForces
    factors : SeriesFactors
        Of the power series in motion.
    rule : (int, int)
        The quadrature that suffices for a step.
    """

    forces: RunForces
    factors: SeriesFactors
    rule: tuple[int, int]


class RunExtremes(NamedTuple):
    """Largest absolute values at the starts of the steps of a run.

    Attributes
    ----------
    turned : float
        Number of steps in which v_r may turn.
    x_dd, v_r, relative, increment : float or ndarray
        Of x_dd [m/s²], v_r [m/s], x_r" [m/s²] and the increment of ü in a step [m/s²].
    """

    turned: float
    x_dd: Any
    v_r: Any
    relative: Any
    increment: Any


@inlined
def run_forces(plant, law, code, x_0):
    """Return the `RunForces` of an encoded mode; `x_0` as in `mode_forces`."""
    mode = decode_mode(code)
    forces, m = mode_forces(plant, law, mode, x_0), plant.m
    share = float(mode.contact)
    if forces.reference > 0.0:
        share = forces.F / forces.reference
    return RunForces(
        float(mode.direction), origin_of(law, mode.origin), forces.x_0, forces.plant.b / m,
        plant.k_x / m, forces.k_t / m, forces.F / m, share,
    )  # fmt: skip


@inlined
def step_variables(forces, xi, v_r, u_0, u_1):
    """Return the variables of a step in which its integrals do not cancel.

    Parameters
    ----------
    forces : RunForces
    xi, v_r, u_0, u_1 : float or ndarray
        State at the start [m, m/s], and ü at both ends [m/s²].

    Returns
    -------
    tuple
        x_r; v_r; ü - x_dd without the damper, at the start; the increment of ü; ü at the start;
        and -x_dd at the start.
    """
    x_r = xi + forces.origin
    contact = forces.spring * x_r + (forces.hold * (x_r - forces.x_0) + forces.f)
    return x_r, v_r, u_0 + contact, u_1 - u_0, u_0, forces.c * v_r + contact


@inlined
def turning_bound(forces, dt):
    """Return two factors of a bound on the dip of |v_r| within a step; 1 for none.

    Notes
    -----
    With |v_r"| <= M within a step |v_r| falls at most M dt²/8 below its lower end. The equation
    of motion, v_r" = -(ü' + c v_r' + w v_r), bounds M by |Δü|/dt + c (v/dt + M dt) + w (v + M
    dt²/8), with v the larger |v_r| of both ends. The dip is at most the first factor times v
    plus the second times |Δü|.
    """
    c, w = forces.c, forces.spring + forces.hold
    divisor = 1.0 - c * dt - w * dt * dt / 8.0
    if divisor < MIN_DIVISOR:
        return 1.0, 1.0
    factor = dt / 8.0 / divisor
    return factor * (c + w * dt), factor


@inlined
def keeps_direction(bound, d, v_0, v_1, increment):
    """Return whether v_r provably keeps the direction d between the values at both ends."""
    before, after, rest = d * v_0, d * v_1, bound[1] * abs(increment)
    by_before, by_after = bound[0] * before + rest, bound[0] * after + rest
    above = (before > by_before) & (before > by_after)
    return (bound[0] < 1.0) & above & (after > by_before) & (after > by_after)


@inlined
def group_of(forces):
    """Return the group of a run."""
    return 2 * int(forces.d > 0.0) + int(forces.hold > 0.0)


@inlined
def larger_bits(bits, value):
    """Return the larger of |value| and the number that has these bits, as bits.

    Numbers above 0 are in the order of their bits. A loop with the largest of integers is
    vectorized, with that of numbers it is not.
    """
    other = np.float64(abs(value)).view(np.int64)
    return other if other > bits else bits


@inlined
def float_of_bits(bits):
    """Return the number that has these bits."""
    return np.int64(bits).view(np.float64)


@summed
def sum_run_compiled(forces, bound, motion, begin, end, sums):
    """Increase the `SUMS` of a group by those of a run; return its `RunExtremes`."""
    # Slices: an index that may count from the end keeps the loop from being vectorized.
    x_r, v_r, u_dd = motion[0][begin:end], motion[1][begin:end], motion[2][begin:end]
    v_after, u_after = motion[1][begin + 1 : end + 1], motion[2][begin + 1 : end + 1]
    xx = xv = xg = xj = vv = vg = vj = gg = gj = jj = 0.0
    vu = vy = ju = jy = uu = uy = yy = gu = 0.0
    along = force = increase = turned = 0.0
    x_dd = speed = relative = steep = np.int64(0)
    for n in range(len(x_r)):
        x, v, g, j, u, y = step_variables(forces, x_r[n], v_r[n], u_dd[n], u_after[n])
        x_dd = larger_bits(x_dd, y)
        speed = larger_bits(speed, v)
        relative = larger_bits(relative, abs(g) + forces.c * abs(v))
        steep = larger_bits(steep, j)
        kept = 1.0 if keeps_direction(bound, forces.d, v, v_after[n], j) else 0.0
        turned += 1.0 - kept
        x, v, g, j, u, y = kept * x, kept * v, kept * g, kept * j, kept * u, kept * y
        xx += x * x
        xv += x * v
        xg += x * g
        xj += x * j
        vv += v * v
        vg += v * g
        vj += v * j
        gg += g * g
        gj += g * j
        jj += j * j
        vu += v * u
        vy += v * y
        ju += j * u
        jy += j * y
        uu += u * u
        uy += u * y
        yy += y * y
        gu += g * u
        along += v
        force += g
        increase += j
    products = (
        xx, xv, xg, xj, vv, vg, vj, gg, gj, jj, vu, vy, ju, jy, uu, uy, yy, gu,
        forces.share * along, forces.share * force, forces.share * increase,
    )  # fmt: skip
    for k in range(SUMS):
        sums[k] += products[k]
    largest = float_of_bits(x_dd), float_of_bits(speed), float_of_bits(relative)
    return RunExtremes(turned, *largest, float_of_bits(steep))


@inlined
def overshoot_bound(forces, dt, extremes):
    """Return by how much |x_dd| exceeds its values at the ends of a step at most [m/s²].

    Parameters
    ----------
    forces : RunForces
    dt : float
        Length of the step [s].
    extremes : RunExtremes
        Of the run that it belongs to; floats or arrays.

    Notes
    -----
    As `peak.bend`, from the largest values in the run.
    """
    c, w = forces.c, forces.spring + forces.hold
    first = w * extremes.v_r + c * extremes.relative + extremes.increment / dt
    second = c * first + w * extremes.relative
    rate = (c * second + w * first) / math.sqrt(w) if w > 0.0 else 0.0 * second
    return 0.125 * dt * dt * (second * second + rate * rate) ** 0.5


@summed
def sum_rest(u_dd, begin, end):
    """Return the integral of ü² over steps divided by dt, and the extremes of ü there."""
    u2, low, high = 0.0, u_dd[end], u_dd[end]
    for n in range(begin, end):
        u_0, u_1 = u_dd[n], u_dd[n + 1]
        u2 += u_0 * u_0 + u_0 * u_1 + u_1 * u_1
        low = u_0 if u_0 < low else low
        high = u_0 if u_0 > high else high
    return u2 / 3.0, low, high


@inlined
def rest_violation(plant, law, x_r, low, high):
    """Return the largest excess of F_L over its limits at rest, relative to the forces [-].

    `low` and `high` are the extremes of ü [m/s²].
    """
    up, down = law.up.F_fs, law.down.F_fs
    spring = plant.k_x * x_r
    excess = max(plant.m * high + spring - down, -(plant.m * low + spring) - up)
    size = plant.m * max(abs(low), abs(high)) + abs(spring) + max(up, down)
    return excess / size if excess > 0.0 else 0.0


@inlined
def hold_violation(law, forces, xi):
    """Return by how much an elastic contact that holds exceeds its limit [-]."""
    limit, x_r = max(law.up.F_fk, law.down.F_fk), forces.origin + xi
    excess = law.k_t * abs(x_r - forces.x_0) - limit
    return excess / (limit + law.k_t * (abs(x_r) + abs(forces.x_0))) if excess > 0.0 else 0.0


def sum_run_plain(
    forces: RunForces, bound: Any, motion: Any, begin: int, end: int, sums: Any
) -> RunExtremes:
    """As `sum_run_compiled`, by numpy."""
    x_r, v_r, u_dd = (np.asarray(column[begin : end + 1]) for column in motion)
    variables = step_variables(forces, x_r[:-1], v_r[:-1], u_dd[:-1], u_dd[1:])
    kept = keeps_direction(bound, forces.d, v_r[:-1], v_r[1:], variables[3])
    table = np.array(variables) * kept
    products = (table[list(FIRST)] * table[list(SECOND)]).sum(axis=1)
    for k, more in enumerate((*products, *forces.share * table[1:4].sum(axis=1))):
        sums[k] += float(more)
    _, v, g, j, _, y = map(np.abs, variables)
    largest = (float(each.max()) for each in (y, v, g + forces.c * v, j))
    return RunExtremes(float((~kept).sum()), *largest)


sum_run = by_engine(sum_run_plain, sum_run_compiled)


@compiled
def step_forms(c, w, dt, forms):
    """Write the quadratic forms that integrate a whole step.

    Parameters
    ----------
    c, w, dt : float
        Damping per mass [1/s], stiffness per mass [1/s²] and length of the step [s].
    forms : array, shape (4, SUMS)
        Written: coefficients of the products in the integrals of x_r², v_r², x_dd² and ü v_r,
        and in the first row those of v_r, the force and its increment in the integral of v_r.
    """
    for row in range(4):
        for k in range(SUMS):
            forms[row][k] = 0.0
    begin = 0.0
    while begin < dt:
        rate = fastest_rate(c, w, begin)
        length = min(PANEL_RADIANS / rate, dt - begin) if rate > 0.0 else dt - begin
        for node in range(len(TWELVE_NODES)):
            s, weight = begin + length * TWELVE_NODES[node], length * TWELVE_WEIGHTS[node]
            y, y_d, Y, YY = flow(c, w, s)
            x = 1.0, y, -Y, -YY / dt, 0.0, 0.0
            v = 0.0, y_d, -y, -Y / dt, 0.0, 0.0
            u_dd = 0.0, 0.0, 0.0, s / dt, 1.0, 0.0
            x_dd = 0.0, -w * y, 0.0, (c * Y + w * YY) / dt, c * y + w * Y, -y_d
            for k in range(PRODUCTS):
                i, j = FIRST[k], SECOND[k]
                # A product of two different variables occurs twice in a square.
                twice = weight if i == j else 2.0 * weight
                forms[0][k] += twice * x[i] * x[j]
                forms[1][k] += twice * v[i] * v[j]
                forms[2][k] += twice * x_dd[i] * x_dd[j]
                forms[3][k] += 0.5 * twice * (u_dd[i] * v[j] + u_dd[j] * v[i])
        begin = begin + length if length < dt - begin else dt
    y, _, Y, YY = flow(c, w, dt)
    forms[0][PRODUCTS], forms[0][PRODUCTS + 1], forms[0][PRODUCTS + 2] = y, -Y, -YY / dt


@compiled
def peak_of_run(solution, row, begin, end, peak):
    """Return the larger of `peak` and |x_dd| between the samples of a run [m/s²]."""
    (plant, law, _, u_dd, dt), samples, rows = solution
    forces = run_forces(plant, law, rows.d[row], rows.x_0[row])
    c, w = forces.c, forces.spring + forces.hold
    for n in range(begin, end):
        x_r, v_r, u_0 = samples.x_r[n], samples.v_r[n], u_dd[n]
        y_0 = -step_variables(forces, x_r, v_r, u_0, u_0)[5]
        slope, e = (u_dd[n + 1] - u_0) / dt, y_0 - u_0
        x_r, v_1, u_1 = samples.x_r[n + 1], samples.v_r[n + 1], u_dd[n + 1]
        y_1 = -step_variables(forces, x_r, v_1, u_1, u_1)[5]
        decay = Decay(c, w, u_0, slope, e, -w * v_r - c * e - slope)
        peak = peak_of_segment(decay, max(abs(y_0), abs(y_1)), dt, peak)
    return peak


def measure(
    solution: SampledSolution, steps: tuple[int, int], window: tuple[float, float]
) -> tuple[SegmentSums, float]:
    """Return the integrals and the largest |x_dd| of some steps within a window.

    Parameters and result as in `measure_steps`; time counts from the first sample.
    """
    size = int(np.searchsorted(solution.rows.n, steps[1])) + 1
    places, peaks = np.empty((3, size), dtype=np.int64), np.empty((2, size))
    runs = Runs(*map(as_engine_array, (*places, *peaks)))
    sums, forms = map(as_engine_array, (np.empty((GROUPS, SUMS)), np.empty((4, SUMS))))
    measured: tuple[SegmentSums, float] = measure_steps(
        solution, steps, window, runs, sums, forms
    )
    return measured


def total_of(parts: list[SegmentSums]) -> SegmentSums:
    """Return the sum of several parts; the largest of their violations counts."""
    return reduce(add_segment_sums_plain, parts, NO_SUMS)


add_segment_sums_plain = python_of(add_segment_sums)
