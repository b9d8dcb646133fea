"""The two ways the base may move, as plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.signal import Signal
from drysim.errors import Caution

HALF_RULE = ((0.0694318442029737, 0.1739274225687269), (0.3300094782075719, 0.3260725774312731))
"""Half of four Gauss-Legendre nodes and weights on 0..1: exact for the square of a cubic."""

WHOLE = 8192
"""Steps whose squares are summed at once: so few that no linear algebra starts threads."""


class Input(NamedTuple):
    """A file that was read: name in the scenario, SHA-256 (hex) and size [bytes]."""

    file: str
    sha256: str
    size: int


class Sines(NamedTuple):
    """Base acceleration ü(t) = Σ A sin(2π f t + phase), used analytically.

    Not to be confused with `Samples` of a sine: nothing is interpolated here.

    Attributes
    ----------
    A : tuple of float
        Amplitudes of ü [m/s²], not RMS values.
    f : tuple of float
        Frequencies [Hz], above 0.
    phase : tuple of float
        Phases at t = 0 [rad].
    """

    A: tuple[float, ...]
    f: tuple[float, ...]
    phase: tuple[float, ...]


class Samples(NamedTuple):
    """Equidistant base acceleration, linear between samples; ends at its last sample.

    Attributes
    ----------
    u_dd : ndarray, shape (n,), or another signal
        Base acceleration [m/s²]; the first sample is t = 0.
    dt : float
        Distance of the samples [s].
    u : ndarray, shape (n,), or None
        Base displacement [m] at the samples where the source knows it; the cubic between two
        samples follows from `u` and `u_dd`. Only T_x needs it.
    inputs : tuple of Input
        The files behind the samples.
    cautions : tuple of Caution
        What a reader of the numbers should know about them.
    realised : mapping
        Of a generated signal: what was asked for and what came out, by name and in SI.
    """

    u_dd: Signal
    dt: float
    u: NDArray[np.float64] | None = None
    inputs: tuple[Input, ...] = ()
    cautions: tuple[Caution, ...] = ()
    realised: Mapping[str, object] = {}


def base_acceleration(sines: Sines, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give ü of sines at any times [m/s²], shape of `t` [s]."""
    u_dd = np.zeros_like(t)
    for A, f, phase in zip(*sines, strict=True):
        u_dd += A * np.sin(2.0 * np.pi * ((f * t) % 1.0) + phase)
    return u_dd


def acceleration_at(motion: Sines | Samples, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give ü of any base motion at times [s] within it, shape of `t` [m/s²]."""
    if isinstance(motion, Sines):
        return base_acceleration(motion, t)
    n = np.minimum((t / motion.dt).astype(np.intp), len(motion.u_dd) - 2)
    u_dd = motion.u_dd[:]
    q = t / motion.dt - n
    between: NDArray[np.float64] = (1.0 - q) * u_dd[n] + q * u_dd[n + 1]
    return between


def displacement_between(
    motion: Samples, n: NDArray[np.intp], q: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give u [m] at the share q of the steps n: the cubic whose second derivative is ü."""
    assert motion.u is not None, "asked for where u is known only"
    p = 1.0 - q
    u_dd = motion.u_dd[:]
    bend = (p**3 - p) * u_dd[n] + (q**3 - q) * u_dd[n + 1]
    u: NDArray[np.float64] = p * motion.u[n] + q * motion.u[n + 1] + motion.dt**2 / 6.0 * bend
    return u


def sample_squares(motion: Samples, begin: float, end: float) -> tuple[float, float | None]:
    """Give the integrals of ü² and, where u is known, of u² over a window of sampled motion."""
    dt = motion.dt
    first, last = int(begin / dt), min(math.ceil(end / dt), len(motion.u_dd) - 1)
    # Steps that the window cuts are integrated by a rule, the whole ones by their forms.
    lo = first + (first * dt < begin)
    hi = max(last - (last * dt > end), lo)
    u_dd2, u2 = 0.0, 0.0
    for n in sorted({first, last - 1}):
        if lo <= n < hi:
            continue
        part = cut_step_squares(motion, n, begin, end)
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    for at in range(lo, hi, WHOLE):
        part = whole_step_squares(motion, at, min(at + WHOLE, hi))
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    return u_dd2, None if motion.u is None else u2


def cut_step_squares(motion: Samples, n: int, begin: float, end: float) -> tuple[float, float]:
    """Give the integrals of ü² and u² over what of step n lies in a window."""
    dt, u_dd2, u2 = motion.dt, 0.0, 0.0
    lo = max(begin / dt - n, 0.0)
    width = min(end / dt - n, 1.0) - lo
    a_0, a_1 = motion.u_dd[n : n + 2].tolist()
    for node, weight in HALF_RULE:
        for place in (node, 1.0 - node):
            q = lo + width * place
            u_dd2 += weight * dt * width * ((1.0 - q) * a_0 + q * a_1) ** 2
            if motion.u is not None:
                u = displacement_between(motion, np.array([n]), np.array([q]))
                u2 += weight * dt * width * float(u[0]) ** 2
    return u_dd2, u2


def whole_step_squares(motion: Samples, first: int, last: int) -> tuple[float, float]:
    """Give the integrals of ü² and u² over the steps from one sample to another."""
    u_dd, dt = motion.u_dd[first : last + 1], motion.dt
    a_0, a_1 = u_dd[:-1], u_dd[1:]
    own, next_to = np.dot(a_0, a_0), np.dot(a_0, a_1)
    ends = float(u_dd[-1]) ** 2 - float(u_dd[0]) ** 2
    u_dd2 = dt / 3.0 * (2.0 * own + ends + next_to)
    if motion.u is None:
        return float(u_dd2), 0.0
    path = motion.u[first : last + 1]
    x_0, x_1 = path[:-1], path[1:]
    bend = dt * dt / 6.0
    # Integrals of the cubics whose second derivative is ü, of a step of length 1.
    squares = (np.dot(x_0, x_0) + np.dot(x_0, x_1) + np.dot(x_1, x_1)) / 3.0
    bent = (np.dot(x_0, a_0) + np.dot(x_1, a_1)) * 4.0 / 15.0
    bent += (np.dot(x_0, a_1) + np.dot(x_1, a_0)) * 7.0 / 30.0
    bends = (2.0 * own + ends) * 8.0 / 105.0 + next_to * 31.0 / 210.0
    return float(u_dd2), float(dt * (squares - bend * bent + bend * bend * bends))
