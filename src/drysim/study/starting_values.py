"""Starting values of a fit in closed form, from base and mass motion alone.

While the mass slides, the force balance m x'' + k_x x_r + b v_r + F_fk sgn(v_r) = 0 is linear
in its parameters, so that linear least squares gives them. The relative motion follows from
integrating x'' - ü, whose drift is corrected where the mass sticks (v_r = 0 is known there)
or, if it rarely does, by a high-pass. What remains of the drift of x_r is a slow, unknown
function of time, fitted along as a piecewise-linear one. The static limit is the load at
break-away.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import ceil

import numpy as np

from drysim.core.model import Floats

LOWEST_FREQUENCY = 0.3
"""Corner of the high-pass against drift where the mass does not stick often [Hz]."""

LONGEST_DRIFT = 4.0
"""Time between knots of the remaining drift, and longest time without a stop for which the
drift of the velocity is taken from the stops [s]."""

STILL_NOISE = 4.0
"""Multiple of the noise of x'' - ü below which the mass may stick."""

SHORTEST_STICK = 6
"""Number of consecutive samples that count as a stop."""

NOISELESS, AVERAGED_TIME = 1e-3, 0.02
"""Noise relative to the largest difference from which it is averaged, and for how long [s]."""

PASSES = 3.0
"""Length of a stop in times that a pass through zero takes."""

SLOW = 0.1
"""Share of the RMS velocity below which the direction of sliding is uncertain."""

LONGEST_PART = 60.0
"""Longest part of a record from which starts are computed [s]."""

FRICTION_FACTORS = (1.0, 0.4, 1.8)
STATIC_RATIOS = (1.3, 1.02, 2.0, 3.0)
"""Factors on the friction force and ratios of the static limit to it, tried as starts."""


@dataclass(frozen=True)
class Kinematics:
    """Base and mass motion on an even grid; arrays of shape (n,)."""

    dt: float
    """Time step [s]."""
    u_dd: Floats
    x_dd: Floats
    """Acceleration of base and mass [m/s²]."""
    x_r: Floats | None = None
    v_r: Floats | None = None
    """Relative motion [m, m/s], where it was measured."""


def noise_level(values: Floats) -> float:
    """Return the standard deviation of white noise in a smooth series.

    The median of the fourth differences is not affected by jumps.
    """
    if len(values) < 5:
        return 0.0
    return float(np.median(np.abs(np.diff(values, 4))) / (0.6745 * np.sqrt(70.0)))


def sticks(motion: Kinematics) -> list[tuple[int, int]]:
    """Return the ranges of samples over which base and mass move alike.

    Their difference also passes through zero while the mass slides, which takes a time that its
    typical slope gives; a stop takes several times longer. Noise is averaged first.
    """
    from scipy.ndimage import uniform_filter1d

    relative = motion.x_dd - motion.u_dd
    noise, width = noise_level(relative), 1
    if noise > NOISELESS * float(np.abs(relative).max()):
        width = max(1, round(AVERAGED_TIME / motion.dt))
        relative = uniform_filter1d(relative, width)
    level = STILL_NOISE * noise / np.sqrt(width) + 1e-9 * float(np.abs(motion.u_dd).max())
    slope = float(np.sqrt(np.mean(np.diff(relative) ** 2))) or 1.0
    shortest = max(SHORTEST_STICK, round(PASSES * 2.0 * level / slope))
    still = np.concatenate(([0], (np.abs(relative) <= level).astype(int), [0]))
    edges = np.flatnonzero(np.diff(still))
    ranges = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [(i, j) for i, j in ranges if j - i >= shortest]


def relative_motion(
    motion: Kinematics, stops: list[tuple[int, int]], by_stops: bool
) -> tuple[Floats, Floats]:
    """Return x_r and v_r, apart from a slow drift of x_r."""
    if motion.x_r is not None:
        v_r = np.gradient(motion.x_r, motion.dt) if motion.v_r is None else motion.v_r
        return motion.x_r, v_r
    v_r = motion.v_r
    if v_r is None:
        v_r = integrate(motion.x_dd - motion.u_dd, motion.dt)
        if by_stops:
            still = np.concatenate([np.arange(i, j) for i, j in stops])
            v_r = v_r - np.interp(np.arange(len(v_r)), still, v_r[still])
        else:
            v_r = remove_drift(v_r, motion.dt)
    x_r = integrate(v_r, motion.dt)
    return (x_r if by_stops else remove_drift(x_r, motion.dt)), v_r


def integrate(values: Floats, dt: float) -> Floats:
    """Return the integral by the trapezoidal rule, 0 at the first sample."""
    steps: Floats = 0.5 * dt * (values[1:] + values[:-1])
    return np.concatenate(([0.0], np.cumsum(steps)))


def remove_drift(values: Floats, dt: float) -> Floats:
    """Return a series without what is slower than `LOWEST_FREQUENCY`."""
    from scipy.signal import sosfiltfilt

    if 1.0 / dt <= 4.0 * LOWEST_FREQUENCY or len(values) < 32:
        about: Floats = values - values.mean()
        return about
    filtered: Floats = sosfiltfilt(high_pass(1.0 / dt), values)
    return filtered


@cache
def high_pass(rate: float) -> Floats:
    """Return the high-pass of `remove_drift` as second-order sections."""
    from scipy.signal import butter

    sections: Floats = butter(2, LOWEST_FREQUENCY, "high", fs=rate, output="sos")
    return sections


def liveliest_part(motion: Kinematics) -> Kinematics:
    """Return the part of a long record in which the mass moves most relative to the base."""
    count = max(2, round(LONGEST_PART / motion.dt))
    if len(motion.u_dd) <= count:
        return motion
    square = np.cumsum((motion.x_dd - motion.u_dd) ** 2)
    begin = int(np.argmax(square[count:] - square[:-count])) + 1
    part = slice(begin, begin + count)
    x_r, v_r = (None if series is None else series[part] for series in (motion.x_r, motion.v_r))
    return Kinematics(motion.dt, motion.u_dd[part], motion.x_dd[part], x_r, v_r)


def closed_form_starts(
    motion: Kinematics, fixed: Mapping[str, float]
) -> Iterator[dict[str, float]]:
    """Yield starting values, the most likely first.

    Parameters
    ----------
    motion : Kinematics
    known : mapping
        Values that are not fitted, of `m`, `k_x`, `b` and `F_fk`.

    Yields
    ------
    dict
        Positive values of `m`, `k_x`, `b`, `F_fk` and `static_ratio`.
    """
    motion = liveliest_part(motion)
    stops = sticks(motion)
    bounds = [0, *(i for pair in stops for i in pair), len(motion.u_dd)]
    longest = max(b - a for a, b in zip(bounds[::2], bounds[1::2], strict=True)) * motion.dt
    for by_stops in (True, False) if stops and longest < LONGEST_DRIFT else (False,):
        balance = force_balance(motion, stops, fixed, by_stops)
        ratio = balance.pop("static_ratio", None)
        likely, *others = STATIC_RATIOS if ratio is None else (ratio, *STATIC_RATIOS[::2])
        for factor in FRICTION_FACTORS:
            yield balance | {"F_fk": balance["F_fk"] * factor, "static_ratio": likely}
        for other in others:
            yield balance | {"static_ratio": other}


def decay_start(motion: Kinematics, fixed: Mapping[str, float]) -> dict[str, float] | None:
    """Return the parameters of a free decay from its turning points, or None without enough.

    Over a half cycle the amplitude X falls to r X - (1 + r) F_fk/k_x, where r is the ratio due
    to viscous damping: a straight line through the pairs of successive amplitudes gives both.

    References
    ----------
    Feeny & Liang, J. Sound Vib. 195 (1996) 149.
    """
    if motion.x_r is None:
        return None
    x_r = motion.x_r
    crossings = np.flatnonzero(np.diff(np.signbit(x_r)))
    level = 0.05 * float(np.abs(x_r).max())
    halves = [part for part in np.split(np.arange(len(x_r)), crossings + 1)[:-1] if len(part)]
    turns = [int(part[np.abs(x_r[part]).argmax()]) for part in halves]
    turns = [i for i in turns if abs(x_r[i]) > level]  # noise about zero has no turning points
    if len(turns) < 4:
        return None
    size = np.abs(x_r[turns])
    slope, constant = np.polyfit(size[:-1], size[1:], 1)
    ratio = float(np.clip(slope, 0.1, 1.0))
    decrement = -float(np.log(ratio)) / np.pi
    half = (turns[-1] - turns[1]) / (len(turns) - 2) * motion.dt
    omega = np.pi / half * float(np.hypot(1.0, decrement))
    zeta = decrement / float(np.hypot(1.0, decrement))
    stiffness = fixed.get("k_x")
    m = fixed["m"] if "m" in fixed else (stiffness or omega**2) / omega**2
    k_x = stiffness or m * omega**2
    size_x = float(x_r.std())
    return {
        "m": m,
        "k_x": k_x,
        "b": 2.0 * zeta * omega * m,
        "F_fk": k_x * max(-float(constant) / (1.0 + ratio), 1e-3 * size_x),
        "static_ratio": STATIC_RATIOS[0],
    }


def force_balance(
    motion: Kinematics, stops: list[tuple[int, int]], fixed: Mapping[str, float], by_stops: bool
) -> dict[str, float]:
    """Return the parameters of the force balance by linear least squares."""
    x_r, v_r = relative_motion(motion, stops, by_stops)
    stuck = np.zeros(len(x_r), dtype=bool)
    for i, j in stops:
        stuck[i:j] = True
    n, length = len(x_r), len(x_r) * motion.dt
    knots = np.linspace(0.0, n - 1.0, max(2, ceil(length / LONGEST_DRIFT) + 1))
    drift = np.stack(
        [np.interp(np.arange(n), knots, row) for row in np.eye(len(knots))], axis=1
    )
    terms = {"m": motion.x_dd, "k_x": x_r, "b": v_r, "F_fk": np.sign(v_r)}
    speed = float(v_r[~stuck].std()) if not stuck.all() else 0.0
    slides = ~stuck & (np.abs(v_r) > SLOW * speed)
    unknown = [name for name in terms if name not in fixed]
    right = -sum((fixed[name] * terms[name] for name in fixed), np.zeros(n))
    columns = np.column_stack([*(terms[name] for name in unknown), drift])
    values = dict(fixed)
    constant = np.zeros(len(knots))
    if slides.sum() > columns.shape[1]:
        size = np.abs(columns[slides]).max(axis=0)
        size[size == 0.0] = 1.0
        solved = np.linalg.lstsq(columns[slides] / size, right[slides], rcond=None)[0] / size
        values |= dict(zip(unknown, solved.tolist(), strict=False))
        constant = solved[len(unknown) :]
    m = max(values.get("m", 1.0), 1e-12)
    force = m * float(np.std(motion.x_dd)) or 1.0
    smallest = {
        "m": 1e-3,
        "k_x": m * (2.0 * np.pi * LOWEST_FREQUENCY) ** 2,
        "b": 0.01 * force / (speed or 1.0),
        "F_fk": 0.02 * force,
    }
    for name, least in smallest.items():
        if name not in fixed:
            values[name] = max(values.get(name, 0.0), least)
    load = m * motion.u_dd + values["k_x"] * x_r + drift @ constant
    late = round(0.5 * AVERAGED_TIME / motion.dt)  # averaging ends a stop too early
    leaving = [float(np.abs(load[j - 1 : j + late]).max()) for _, j in stops if j < n]
    if leaving and values["F_fk"] > 0.0:
        ratio = float(np.median(leaving)) / values["F_fk"]
        values["static_ratio"] = min(max(ratio, 1.001), 10.0)
    return values
