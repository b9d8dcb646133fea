"""The two ways the base may move, as plain values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.signal import BLOCK, Signal
from drysim.errors import Caution

HALF_RULE = ((0.0694318442029737, 0.1739274225687269), (0.3300094782075719, 0.3260725774312731))
"""Half of four Gauss-Legendre nodes and weights on 0..1: exact for the square of a cubic."""


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
    realised: Mapping[str, object] = MappingProxyType({})


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
    u_dd2, u2 = 0.0, 0.0
    for at in range(first, last, BLOCK):
        n = np.arange(at, min(at + BLOCK, last))
        lo = np.maximum(begin / dt - n, 0.0)
        width = np.minimum(end / dt - n, 1.0) - lo
        u_dd = motion.u_dd[at : at + len(n) + 1]
        a_0, a_1 = u_dd[:-1], u_dd[1:]
        for node, weight in HALF_RULE:
            for place in (node, 1.0 - node):
                q = lo + width * place
                p = 1.0 - q
                u_dd2 += weight * dt * (width * np.square(p * a_0 + q * a_1)).sum()
                if motion.u is not None:
                    u = displacement_between(motion, n, q)
                    u2 += weight * dt * (width * np.square(u)).sum()
    return float(u_dd2), None if motion.u is None else float(u2)
