"""The two ways the base may move, as plain values."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.errors import Caution


class Input(NamedTuple):
    """A file that was read: its name as the scenario gives it, SHA-256 (hex) and size [bytes]."""

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
    u_dd : ndarray, shape (n,)
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
    """

    u_dd: NDArray[np.float64]
    dt: float
    u: NDArray[np.float64] | None = None
    inputs: tuple[Input, ...] = ()
    cautions: tuple[Caution, ...] = ()
