"""Integrals and peak acceleration of a motion over samples.

Problem
    A march over samples leaves the state at every sample, and the starts of the segments that
    do not begin at one. The integrals over a window and the largest |x_dd| follow from them.
    They should cost less than the march: a few nanoseconds a step.

Method
    `divide_steps` separates runs of whole steps in one mode apart from the stops, most of a
    motion, from all other segments.

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

    Runs are long loops without branches, which the compiler turns into vector instructions. In
    plain Python numpy does the same (`sum_runs_plain`).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from drysim.core.compile import ZERO, as_engine_array, compiled, inlined, is_plain, summed
from drysim.core.events import Segments, record_segment
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
)
from drysim.core.oscillator import flow
from drysim.core.peak import Decay, peak_of_segment
from drysim.core.trajectory import (
    NO_SUMS,
    PANEL_RADIANS,
    SampledSolution,
    SegmentSums,
    Solution,
    fastest_rate,
    integrate_segments,
    last_event_index,
)


class Runs(NamedTuple):
    """Runs of whole steps in one mode; integer arrays of shape (runs,).

    Attributes
    ----------
    row : array
        Index of the row whose mode it is.
    begin, end : array
        First step, and the one after the last.
    """

    row: Any
    begin: Any
    end: Any


# Runs, and all other segments.


@compiled
def divide_steps(solution, steps, window, runs, segments):
    """Divide steps into runs and segments; return the number of runs and that of segments.

    Parameters
    ----------
    solution : SampledSolution
    steps : (int, int)
        First step, and the one after the last.
    window : (float, float)
        Begin and end [s], in the first and in the last of these steps. A step that they cut
        belongs to no run.
    runs, segments : Runs, Segments
        Written. There are no more runs than rows, and no more segments than steps and twice the
        rows. A segment ends where the next one begins, or with its step.
    """
    (_, law, _, u_dd, dt), samples, rows = solution
    first, last = steps
    lowest, highest = first + int(window[0] > first * dt), last - int(window[1] < last * dt)
    varies = load_varies(law)
    i = last_event_index(rows.n, first - 1)
    count, used = int(ZERO), int(ZERO)
    while i < len(rows.n) and rows.n[i] < last:
        n, d, x_0 = rows.n[i], rows.d[i], rows.x_0[i]
        followed = i + 1 < len(rows.n) and rows.n[i + 1] < last
        until = rows.n[i + 1] if followed else last
        after = rows.s[i + 1] if followed else 0.0
        mode = decode_mode(d)
        summed = not varies and d != ARRIVAL and is_summed(law, mode)
        rests = summed and mode.direction == AT_REST
        if n < first:
            n = first
        elif not (rests and rows.s[i] == 0.0 and until > n):
            state = rows.x_r[i], rows.v_r[i], x_0
            used = record_segment(segments, used, (n, rows.s[i]), state, d)
            n += 1
        begin = end = until
        if summed:
            # Where the next mode begins at a sample, the motion there is that after it; at the
            # last sample of all it may be.
            goes_on = i + 1 < len(rows.n) and rows.n[i + 1] == until
            changes = goes_on and rows.s[i + 1] == 0.0
            stop = until - int(changes or until == len(u_dd) - 1)
            begin = min(max(n, lowest), until)
            end = max(min(until if rests else stop, highest), begin)
        for k in range(n, begin):
            state = samples.x_r[k], samples.v_r[k], x_0
            used = record_segment(segments, used, (k, 0.0), state, d)
        if end > begin:
            runs.row[count], runs.begin[count], runs.end[count] = i, begin, end
            count += 1
        # The step in which the next mode begins belongs to this one, too.
        for k in range(max(end, n), until + int(after > 0.0)):
            state = samples.x_r[k], samples.v_r[k], x_0
            used = record_segment(segments, used, (k, 0.0), state, d)
        i += 1
    return count, used


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


class Peaks(NamedTuple):
    """Peaks of |x_dd| in runs [m/s²]: arrays of shape (runs,).

    Attributes
    ----------
    at_samples : array
        Largest value at the samples of the run, its end included.
    between : array
        Bound of what it is exceeded by between two samples.
    """

    at_samples: Any
    between: Any


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


@compiled
def sum_runs_compiled(solution, runs, peaks, sums, rest, turns):
    """Sum products over runs; return the number of steps that are left out.

    Parameters
    ----------
    solution : SampledSolution
    runs : Runs
    peaks : Peaks
        Written.
    sums : array, shape (GROUPS, SUMS)
        Increased by the sums over the runs in motion.
    rest : array, shape (4,)
        Integrals of x_r² and ü² over runs at rest, divided by dt [m², m²/s⁴], their number of
        steps, and the largest violation of the friction limits, which are all increased.
    turns : (array, array)
        Written: row and number of the steps in which v_r may turn.
    """
    (plant, law, _, u_dd, dt), samples, rows = solution
    count = int(ZERO)
    for i in range(len(runs.row)):
        row, begin, end = runs.row[i], runs.begin[i], runs.end[i]
        forces = run_forces(plant, law, rows.d[row], rows.x_0[row])
        if forces.d == 0.0:
            x_r = forces.origin + samples.x_r[begin]
            u2, low, high = sum_rest(u_dd, begin, end)
            rest[0] += x_r * x_r * (end - begin)
            rest[1] += u2
            rest[2] += end - begin
            rest[3] = max(rest[3], rest_violation(plant, law, x_r, low, high))
            peaks.at_samples[i], peaks.between[i] = max(-low, high), 0.0
            continue
        bound, group = turning_bound(forces, dt), group_of(forces)
        motion = samples.x_r, samples.v_r, u_dd
        found = sum_run(forces, bound, motion, begin, end, sums[group])
        y = step_variables(forces, samples.x_r[end], samples.v_r[end], u_dd[end], u_dd[end])[5]
        peaks.at_samples[i] = max(found.x_dd, abs(y))
        peaks.between[i] = overshoot_bound(forces, dt, found)
        if found.turned > 0.0:
            for n in range(begin, end):
                v_0, v_1 = samples.v_r[n], samples.v_r[n + 1]
                if not keeps_direction(bound, forces.d, v_0, v_1, u_dd[n + 1] - u_dd[n]):
                    turns[0][count], turns[1][count] = row, n
                    count += 1
        if forces.hold > 0.0:
            for n in range(begin, end):
                excess = hold_violation(law, forces, samples.x_r[n])
                rest[3] = max(rest[3], excess)
    return count


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
def sum_run(forces, bound, motion, begin, end, sums):
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


def sum_runs_plain(
    solution: SampledSolution, runs: Runs, peaks: Peaks, sums: Any, rest: Any, turns: Any
) -> int:
    """As `sum_runs_compiled`, by numpy."""
    (plant, law, _, u_dd, dt), (xi, v_r, _), rows = solution
    u_dd, xi, v_r = np.asarray(u_dd), np.asarray(xi), np.asarray(v_r)
    count, codes = 0, np.asarray(rows.d)[runs.row]
    for code in np.unique(codes).tolist():
        chosen = np.flatnonzero(codes == code)
        row, begin, end = (column[chosen] for column in runs)
        n, index = steps_of_runs(begin, end)
        starts, x_0 = np.searchsorted(index, np.arange(len(row))), np.asarray(rows.x_0)[row]
        forces = run_forces(plant, law, code, float(x_0[0]))
        if forces.d == 0.0:
            x_r, u_0, u_1 = forces.origin + xi[begin], u_dd[n], u_dd[n + 1]
            low = np.minimum(np.minimum.reduceat(u_0, starts), u_dd[end])
            high = np.maximum(np.maximum.reduceat(u_0, starts), u_dd[end])
            rest[0] += float((x_r * x_r * (end - begin)).sum())
            rest[1] += float((u_0 * u_0 + u_0 * u_1 + u_1 * u_1).sum()) / 3.0
            rest[2] += len(n)
            cases = zip(x_r.tolist(), low.tolist(), high.tolist(), strict=True)
            rest[3] = max(rest[3], *(rest_violation(plant, law, *case) for case in cases))
            peaks.at_samples[chosen], peaks.between[chosen] = np.maximum(-low, high), 0.0
            continue
        at_step, at_end = forces._replace(x_0=x_0[index]), forces._replace(x_0=x_0)
        variables = step_variables(at_step, xi[n], v_r[n], u_dd[n], u_dd[n + 1])
        x, v, g, j, _, y = map(np.abs, variables)
        largest = y, v, g + forces.c * v, j
        extremes = RunExtremes(0.0, *(np.maximum.reduceat(each, starts) for each in largest))
        y = np.abs(step_variables(at_end, xi[end], v_r[end], u_dd[end], u_dd[end])[5])
        peaks.at_samples[chosen] = np.maximum(extremes.x_dd, y)
        peaks.between[chosen] = overshoot_bound(forces, dt, extremes)
        kept = keeps_direction(
            turning_bound(forces, dt), forces.d, v_r[n], v_r[n + 1], variables[3]
        )
        left = np.flatnonzero(~kept)
        turns[0][count : count + len(left)] = row[index[left]]
        turns[1][count : count + len(left)] = n[left]
        count += len(left)
        table, group = np.array(variables) * kept, sums[group_of(forces)]
        for k in range(PRODUCTS):
            group[k] += float((table[FIRST[k]] * table[SECOND[k]]).sum())
        group[PRODUCTS:] += forces.share * table[1:4].sum(axis=1)
        if forces.hold > 0.0:
            limit, size = max(law.up.F_fk, law.down.F_fk), x + np.abs(at_step.x_0)
            excess = law.k_t * np.abs(variables[0] - at_step.x_0) - limit
            rest[3] = max(rest[3], float((excess / (limit + law.k_t * size)).max()))
    return count


def steps_of_runs(begin: Any, end: Any) -> Any:
    """Return the steps of runs, and the index of the run of each, as arrays."""
    lengths = end - begin
    index = np.repeat(np.arange(len(begin)), lengths)
    return np.arange(len(index)) + (begin - np.cumsum(lengths) + lengths)[index], index


sum_runs = sum_runs_plain if is_plain() else sum_runs_compiled


@lru_cache(maxsize=64)
def step_forms(c: float, w: float, dt: float) -> Any:
    """Return the quadratic forms that integrate a whole step.

    Parameters
    ----------
    c, w, dt : float
        Damping per mass [1/s], stiffness per mass [1/s²] and length of the step [s].

    Returns
    -------
    squares : ndarray, shape (4, PRODUCTS)
        Coefficients of the products in the integrals of x_r², v_r², x_dd² and ü v_r.
    distance : ndarray, shape (3,)
        Coefficients of v_r, the force and its increment in the integral of v_r.

    Notes
    -----
    Cached: the cases of an ensemble share oscillator and step.
    """
    forms = np.zeros((4, 6, 6))
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
            pairs = (x, x), (v, v), (x_dd, x_dd), (u_dd, v)
            for form, (one, other) in zip(forms, pairs, strict=True):
                form += weight * length * np.outer(one, other)
        begin = begin + length if length < dt - begin else dt
    y, _, Y, YY = flow(c, w, dt)
    both = forms + forms.transpose(0, 2, 1)
    both[:, range(6), range(6)] *= 0.5
    squares, distance = both[:, FIRST, SECOND], np.array([y, -Y, -YY / dt])
    squares.flags.writeable = distance.flags.writeable = False  # shared by all callers
    return squares, distance


@compiled
def peak_of_runs(solution, runs, peaks):
    """Return the largest |x_dd| in runs, between the samples too [m/s²]."""
    (plant, law, _, u_dd, dt), samples, rows = solution
    peak = 0.0
    for i in range(len(runs.row)):
        peak = max(peak, peaks.at_samples[i])
    for i in range(len(runs.row)):
        if peaks.at_samples[i] + peaks.between[i] <= peak:
            continue
        row = runs.row[i]
        forces = run_forces(plant, law, rows.d[row], rows.x_0[row])
        c, w = forces.c, forces.spring + forces.hold
        for n in range(runs.begin[i], runs.end[i]):
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

    Parameters
    ----------
    solution : SampledSolution
    steps : (int, int)
        First step, and the one after the last.
    window : (float, float)
        Begin and end [s], as in `divide_steps`; time counts from the first sample.

    Returns
    -------
    sums : SegmentSums
        Without impacts on rigid stops, which take no time.
    peak : float
        [m/s²]; not meaningful where the normal force varies.
    """
    (plant, law, _, _, dt), samples, rows = solution
    runs, segments = divided(solution, steps, window)
    sums, rest, table = np.zeros((GROUPS, SUMS)), np.zeros(4), np.empty((2, len(runs.row)))
    turns = np.empty((2, int((runs.end - runs.begin).sum())), dtype=np.int64)
    peaks = Peaks(table[0], table[1])
    count = sum_runs(solution, runs, peaks, sums, rest, (turns[0], turns[1]))
    peak = peak_of_runs(solution, runs, peaks)
    more, peak = integrate_segments(Solution(solution.scene, segments), *window, peak)
    found = [more]
    if count:
        row, n = turns[:, :count]
        x_r, v_r = (np.asarray(column)[n] for column in samples[:2])
        left = Segments(n, np.zeros(count), x_r, v_r, rows.x_0[row], rows.d[row])
        left = Segments(*map(as_engine_array, left))
        more, peak = integrate_segments(Solution(solution.scene, left), *window, peak)
        found.append(more)
    x2, x_dd2, stuck = (dt * rest[:3]).tolist()
    found.append(SegmentSums(x2, 0.0, x_dd2, 0.0, 0.0, stuck, 0.0, 0.0, float(rest[3])))
    for holds in (0, 1):
        pair = []
        for group, side in ((holds, law.down), (2 + holds, law.up)):
            if not sums[group].any():
                continue
            w = (plant.k_x + law.k_t * holds) / plant.m
            squares, distance = step_forms(side.b / plant.m, w, dt)
            x2, v2, x_dd2, power = (squares @ sums[group][:PRODUCTS]).tolist()
            # Squares, whatever rounding says.
            x2, v2, x_dd2 = max(x2, 0.0), max(v2, 0.0), max(x_dd2, 0.0)
            slid = 0.0 if holds else float(distance @ sums[group][PRODUCTS:])
            loss = side.b * v2
            pair.append(SegmentSums(x2, v2, x_dd2, power, slid, 0.0, 0.0, loss, 0.0))
        # Both directions first: a mirrored motion exchanges them.
        found.append(total_of(pair))
    return total_of(found), float(peak)


def total_of(parts: list[SegmentSums]) -> SegmentSums:
    """Return the sum of several parts; the largest of their violations counts."""
    if not parts:
        return NO_SUMS
    table = np.array(parts)
    total = SegmentSums(*table.sum(axis=0).tolist())
    return total._replace(violation=float(table[:, -1].max()))


def divided(
    solution: SampledSolution, steps: tuple[int, int], window: tuple[float, float]
) -> tuple[Runs, Segments]:
    """Return runs and segments from `divide_steps`."""
    first, last = steps
    begin, end = np.searchsorted(solution.rows.n, steps).tolist()
    size = end - begin + 1
    runs = Runs(*np.empty((3, size), dtype=np.int64))
    columns = np.empty((4, last - first + 2 * size))
    d, n = np.empty((2, last - first + 2 * size), dtype=np.int64)
    segments = Segments(n, columns[0], columns[1], columns[2], columns[3], d)
    count, used = divide_steps(solution, steps, window, runs, segments)
    runs = Runs(*(column[:count] for column in runs))
    return runs, Segments(*(as_engine_array(column[:used]) for column in segments))
