"""Largest absolute acceleration of the mass over sampled base motion, jumps included.

Problem
    x_dd jumps where friction changes sign or the mass sticks, and has maxima between the points
    of any grid. The peak is the supremum over the window: both sides of every jump count.

Method
    Between two samples or events ü is linear in time and so are the forces in x_r, v_r and
    time. Hence x_dd = ü + x_r'', where x_r'' is a free vibration,
    e'' + (b/m) e' + (k_x/m) e = 0 (with the stiffness of a contact or bumper added). All ends
    of these segments are evaluated. Within a segment |x_dd| exceeds the larger of its end
    values by at most length²/8 times a bound of |e''|, which follows from the energy of e'';
    only segments that may exceed the peak so far are searched, the most promising first. Zeros
    of e'' are known in closed form, and between two of them x_dd' is monotone, so that each of
    its roots is bracketed and no maximum is missed.

Rigid impacts are not included: they have a momentum and no acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from drysim.approach.coulomb import SampledTrajectory
from drysim.approach.exact import UnreachedStopsTrajectory
from drysim.approach.solution import Floats, Trajectory
from drysim.approach.stepping import FixedStepTrajectory
from drysim.core.events import EventLog
from drysim.core.model import Plant, Samples
from drysim.core.oscillator import flow
from drysim.core.roots import MAX_BISECTIONS, safeguarded_newton

MAX_ENDS_SEARCHED = 4
"""Half cycles searched at both ends of a segment. Over one of more cycles the maxima of a decay
plus a ramp are convex in time, so that the largest is the first or the last."""

STEPS_AT_A_TIME = 65_536
"""Steps evaluated at a time."""


class Rows(NamedTuple):
    """Segments in order of time: their starts, each the end of the one before."""

    n: Any
    s: Any
    """Sample before the start, and time since [s]."""
    x_r: Any
    v_r: Any
    """State at the start [m, m/s]."""
    k: Any
    b: Any
    """Stiffness [N/m] and damping [N·s/m] in -m x_dd = k x_r + b v_r + force."""
    force: Any
    """Constant force [N] in it."""
    rests: Any
    """Whether the mass rests on its base."""


def peak_acceleration(trajectory: Trajectory, begin: float, end: float) -> float | None:
    """Return the largest |x_dd| in a window [m/s²], or None where it is not known.

    It is known for sampled base motion and a constant normal force, except under the laws that
    are solved by series; a fixed-step approach knows its grid points only.
    """
    if isinstance(trajectory, UnreachedStopsTrajectory):
        trajectory = trajectory.unstopped
    if isinstance(trajectory, FixedStepTrajectory):
        inside = trajectory.x_dd[round(begin / trajectory.dt) : round(end / trajectory.dt) + 1]
        return float(np.abs(inside).max(initial=0.0))
    motion = getattr(trajectory, "motion", None)
    if not isinstance(motion, Samples):
        return None
    if isinstance(trajectory, SampledTrajectory):
        if trajectory.law.variation:
            return None
        parts = coulomb_rows(trajectory, begin, end)
    else:
        from drysim.approach.piecewise import PiecewiseTrajectory

        if not isinstance(trajectory, PiecewiseTrajectory) or trajectory.law.varies:
            return None
        parts = piecewise_rows(trajectory, begin, end)
    peak = 0.0
    for first, u_dd, rows in parts:
        t = first * motion.dt
        rows = with_cut(rows, motion.dt, begin - t, trajectory, t)
        rows = with_cut(rows, motion.dt, end - t, trajectory, t)
        window = begin - t, end - t
        peak = peak_of_rows(trajectory.plant.m, u_dd, motion.dt, rows, window, peak)
    return peak


def coulomb_rows(
    trajectory: SampledTrajectory, begin: float, end: float
) -> Iterator[tuple[int, Floats, Rows]]:
    """Yield first sample, ü and segments of the blocks of a motion with Coulomb friction."""
    march, (_, k_x, b) = trajectory.march, trajectory.plant
    dt, F_fk = march.motion.dt, trajectory.law.F_fk
    for block in march.blocks(int(begin / dt), min(math.ceil(end / dt), march.last)):
        log = EventLog(*(column[1:] for column in block.log))
        for at in range(0, len(block.d) - 1, STEPS_AT_A_TIME):
            part = slice(at, min(at + STEPS_AT_A_TIME + 1, len(block.d)))
            found = slice(*np.searchsorted(log.n, (at, part.stop - 1)))
            n, s, kind, x_r, _ = (column[found] for column in log)
            n = n - at
            columns = block.u_dd[part], block.x_r[part], block.v_r[part], block.d[part]
            window = begin / dt - block.first - at, end / dt - block.first - at
            steps = steps_of_peak(trajectory.plant, F_fk, dt, columns, n, window)
            chosen = steps[n]
            n, s, kind, x_r = (column[chosen] for column in (n, s, kind, x_r))
            ends = np.append(steps, False)
            ends[1:] |= steps
            samples = np.flatnonzero(ends)
            # Events come after their sample.
            first = np.searchsorted(samples, n)
            repeats = 1 + np.bincount(first, minlength=len(samples))
            rows_of_events = first + 1 + np.arange(len(n))
            points = samples, *(column[samples] for column in columns[1:])
            every_n, every_x_r, every_v_r, d = (np.repeat(point, repeats) for point in points)
            every_s = np.zeros(len(d))
            every_s[rows_of_events], every_x_r[rows_of_events] = s, x_r
            every_v_r[rows_of_events], d[rows_of_events] = 0.0, np.sign(kind)
            rows = Rows(every_n, every_s, every_x_r, every_v_r, k_x, b, F_fk * d, d == 0)
            yield block.first + at, columns[0], rows


def steps_of_peak(
    plant: Plant, F_fk: float, dt: float, columns: Any, events: Any, window: tuple[float, float]
) -> Any:
    """Return in which steps |x_dd| may be largest within a window, shape (steps,).

    Parameters
    ----------
    plant : Plant
    F_fk, dt : float
        Kinetic friction [N] and length of a step [s].
    columns : tuple of ndarray, shape (steps + 1,)
        ü [m/s²], x_r [m], v_r [m/s] and direction of sliding at the samples.
    events : ndarray of int
        Steps with events.
    window : tuple of float
        Begin and end in steps.

    Notes
    -----
    Within a step without events |x_dd| exceeds the larger end value by at most dt²/8 times a
    bound of its second derivative, common to all steps. In one with events the friction may
    have any direction, or the mass may stick; there |x_r''| <= A + dt (w V + c A), with V the
    largest |v_r|, itself at most its largest value at a sample plus A dt, bounds A.
    """
    (m, k_x, b), (u_dd, x_r, v_r, d) = plant, columns
    pull = k_x * x_r
    pull += b * v_r
    at_begin = pull[:-1] + F_fk * d[:-1]
    at_end = pull[1:] + F_fk * d[:-1]
    at_begin /= m
    at_end /= m
    sticks = np.flatnonzero(d[:-1] == 0)
    at_begin[sticks], at_end[sticks] = u_dd[:-1][sticks], u_dd[1:][sticks]
    ends = np.maximum(np.abs(at_begin, out=at_begin), np.abs(at_end, out=at_end))
    largest, swing, speed = (float(np.abs(one).max()) for one in (u_dd, pull, v_r))
    c, w, relative = b / m, k_x / m, largest + (swing + F_fk) / m
    first = w * speed + c * relative + float(np.abs(np.diff(u_dd)).max()) / dt
    second = c * first + w * relative
    third = c * second + w * first
    highest = ends + 0.125 * dt**2 * (second + dt * (third + math.sqrt(w) * second))
    pulls = np.maximum(np.abs(pull[events]), np.abs(pull[events + 1])) + F_fk
    base = np.maximum(np.abs(u_dd[events]), np.abs(u_dd[events + 1]))
    divisor = 1.0 - (c + w * dt) * dt
    highest[events] = math.inf
    if divisor > 0.5:
        fastest = (relative + w * dt * speed) / divisor
        drift = dt * (w * (speed + dt * fastest) + c * fastest)
        highest[events] = np.maximum(pulls / m + drift, base)
    # Steps that the window cuts are always looked at.
    begin, end = max(math.floor(window[0]), 0), min(math.ceil(window[1]), len(ends))
    quiet = np.ones(len(ends), dtype=bool)
    quiet[events] = False
    inside = slice(begin + 2, max(end - 2, begin + 2))
    known = float(ends[inside].max(initial=0.0, where=quiet[inside]))
    chosen: Any = highest >= known
    chosen[:begin] = chosen[end:] = False
    for n in (begin - 1, begin, begin + 1, end - 1, end):
        if 0 <= n < len(ends):
            chosen[n] = True
    return chosen


def piecewise_rows(
    trajectory: Any, begin: float, end: float
) -> Iterator[tuple[int, Floats, Rows]]:
    """Yield the segments of an elastic contact or of a motion between end stops."""
    from drysim.core.modes import ARRIVAL

    plant, dt = trajectory.plant, trajectory.dt
    for part in trajectory.parts(begin, end):
        # An arrival that comes first ended the part before.
        from_row = int(part.segments.d[0] == ARRIVAL)
        n, s, xi, v_r, x_0, codes = (column[from_row:] for column in part.segments)
        forces = trajectory.march.mode_columns(codes)
        k, b = plant.k_x + forces.k_t + forces.k_s, forces.b + forces.b_s
        force = forces.F - forces.k_t * x_0 - forces.k_s * forces.origin - forces.offset
        x_r, rests = xi + forces.origin, forces.direction == 0
        rows = Rows(n, s, x_r, v_r, k, b, force, rests)
        if part.own == len(n) + from_row:
            # No segment follows to end the last one.
            upto = min((part.last + 1) * dt, trajectory.end)
            last = [column[-1] for column in rows]
            last[1:4] = upto - part.t - n[-1] * dt, *trajectory.state(upto)[:2]
            pairs = zip(rows, last, strict=True)
            rows = Rows(*(np.append(column, value) for column, value in pairs))
        yield round(part.t / dt), np.asarray(part.scene.u_dd), rows


def with_cut(rows: Rows, dt: float, at: float, trajectory: Trajectory, first: float) -> Rows:
    """Return rows with one that begins at a time [s], counted from the time `first`."""
    t = rows.n * dt + rows.s
    i = int(np.searchsorted(t, at, side="right")) - 1
    if i < 0 or i == len(t) - 1 or t[i] == at:
        return rows
    x_r, v_r = trajectory.state(min(first + at, trajectory.end))[:2]
    cut = [column if np.ndim(column) == 0 else column[i] for column in rows]
    cut[1:4] = max(at - rows.n[i] * dt, rows.s[i]), x_r, v_r
    columns = zip(rows, cut, strict=True)
    return Rows(
        *(one if np.ndim(one) == 0 else np.insert(one, i + 1, at) for one, at in columns)
    )


def peak_of_rows(
    m: float, u_dd: Floats, dt: float, rows: Rows, window: tuple[float, float], peak: float
) -> float:
    """Return the larger of `peak` and |x_dd| in the segments within a window [m/s²]."""
    first, last = np.searchsorted(rows.n * dt + rows.s, window).tolist()
    part = np.arange(first, min(last, len(rows.n) - 1))
    # Where steps are left out, the start of the next one ends no segment.
    part = part[rows.n[part + 1] <= rows.n[part] + 1]
    if not len(part):
        return peak
    after = part + 1
    n, s, x, v, k, b, force, rests = (one if np.ndim(one) == 0 else one[part] for one in rows)
    until = np.where(rows.n[after] == n, rows.s[after], dt)
    slope = (u_dd[np.minimum(n + 1, len(u_dd) - 1)] - u_dd[n]) / dt
    u_0, u_1, length = u_dd[n] + slope * s, u_dd[n] + slope * until, until - s
    y_0 = np.where(rests, u_0, -(k * x + b * v + force) / m)
    y_1 = np.where(rests, u_1, -(k * rows.x_r[after] + b * rows.v_r[after] + force) / m)
    highest = np.maximum(np.abs(y_0), np.abs(y_1))
    peak = max(peak, float(highest.max()))

    # Few segments may exceed the largest end: first by a bound common to all of them.
    c, w, e, longest = b / m, k / m, y_0 - u_0, float(length.max())
    c_, w_ = np.max(c), np.max(w)
    greatest_1 = w_ * np.abs(v).max() + c_ * np.abs(e).max() + np.abs(slope).max()
    greatest_2 = c_ * greatest_1 + w_ * np.abs(e).max()
    greatest_3 = c_ * greatest_2 + w_ * greatest_1
    most = greatest_2 + longest * (greatest_3 + math.sqrt(w_) * greatest_2)
    near = np.flatnonzero(~rests & (highest + 0.125 * longest**2 * most > peak))
    c, w = (np.broadcast_to(one, highest.shape)[near] for one in (c, w))
    u_0, slope, e, v, length = (one[near] for one in (u_0, slope, e, v, length))
    e_1 = -w * v - c * e - slope
    e_2 = -c * e_1 - w * e
    e_3 = -c * e_2 - w * e_1
    scaled = np.divide(e_3, np.sqrt(w), out=np.zeros_like(e_3), where=w > 0.0)
    bound = highest[near] + 0.125 * length**2 * np.hypot(e_2, scaled)
    for i in np.argsort(-bound).tolist():
        if bound[i] <= peak:
            break
        segment = (c[i], w[i], u_0[i], slope[i], e[i], e_1[i], length[i])
        peak = max(peak, interior_peak(*map(float, segment)))
    return peak


def interior_peak(
    c: float, w: float, u_0: float, slope: float, e: float, e_1: float, length: float
) -> float:
    """Return the largest |u_0 + slope s + e(s)| where its rate vanishes in a segment [m/s²].

    Parameters
    ----------
    c, w : float
        Of e" + c e' + w e = 0 [1/s, 1/s²].
    u_0, slope : float
        ü at the start [m/s²] and its rate [m/s³].
    e, e_1 : float
        e [m/s²] and e' [m/s³] at the start.
    length : float
        Length of the segment [s].
    """

    def motion(s: float) -> tuple[float, float, float]:
        """Return x_dd and its first two derivatives."""
        y, y_d = flow(c, w, s)[:2]
        now, rate = e * (y_d + c * y) + e_1 * y, e_1 * y_d - w * e * y
        return u_0 + slope * s + now, slope + rate, -c * rate - w * now

    peak, bounds = 0.0, [0.0, *zeros_of_decay(c, w, e, e_1, length), length]
    rates = [motion(s)[1] for s in bounds]
    for low, high, before, behind in zip(bounds, bounds[1:], rates, rates[1:], strict=False):
        if before * behind < 0.0:
            s, side = 0.5 * (low + high), math.copysign(1.0, before)
            for _ in range(MAX_BISECTIONS):
                _, rate, curvature = motion(s)
                low, high, s, done = safeguarded_newton(
                    low, high, s, side * rate, side * curvature
                )
                if done:
                    break
            peak = max(peak, abs(motion(s)[0]))
    return float(peak)


def zeros_of_decay(c: float, w: float, e: float, e_1: float, length: float) -> list[float]:
    """Return the zeros of e'' within a segment [s]; of very many the first and last few."""
    e_2 = -c * e_1 - w * e
    e_3 = -c * e_2 - w * e_1
    if e_2 == 0.0 and e_3 == 0.0:
        return []
    # e'' = exp(-c s/2) (e_2 C(s) + B S(s)), with C and S the circular or hyperbolic functions.
    B, square = e_3 + 0.5 * c * e_2, w - 0.25 * c * c
    if square > 0.0:
        omega = math.sqrt(square)
        first = math.atan2(-omega * e_2, B) % math.pi / omega
        count = int(max(length - first, -1.0) * omega / math.pi) + 1
        few = [*range(min(count, MAX_ENDS_SEARCHED))]
        few += range(max(len(few), count - MAX_ENDS_SEARCHED), count)
        return [s for i in few if 0.0 < (s := first + i * math.pi / omega) < length]
    kappa = math.sqrt(-square)
    if kappa == 0.0:
        s = -e_2 / B if B else 0.0
    else:
        share = -kappa * e_2 / B if B else math.inf
        s = math.atanh(share) / kappa if abs(share) < 1.0 else 0.0
    return [s] if 0.0 < s < length else []
