"""Trends, and filters without phase shift, of evenly spaced samples; displacement from ü."""

from __future__ import annotations

from typing import Literal

import numpy as np

from drysim.core.motion import Samples
from drysim.excitation.record.columns import Floats

Ends = Literal["even", "odd"]
"""How a filter continues the ends of samples: mirrored, without or with a change of sign."""

DRIFT = 3
"""Degree of the drift that is taken from a double integral by least squares, before a filter:
an acceleration that is off by a line drifts so."""


def trend(values: Floats, what: str) -> Floats:
    """Give the `mean` or the `line` (least squares) of samples.

    Returns
    -------
    ndarray, shape (n,)
    """
    n = len(values)
    if what == "mean":
        return np.broadcast_to(values.mean(), n)
    steps = np.arange(n) - (n - 1) / 2  # from the middle, mean and slope do not mix
    return np.asarray(values.mean() + (steps @ values) / (steps @ steps) * steps)


def low_pass(values: Floats, dt: float, frequency: float, order: int) -> Floats:
    """Give what is slower than a frequency [Hz]; see `high_pass`."""
    return _both_ways(values, dt, frequency, order, "lowpass", "odd")


def high_pass(
    values: Floats, dt: float, frequency: float, order: int, ends: Ends = "even"
) -> Floats:
    """Give what is faster than a frequency, by a Butterworth filter run forwards and backwards.

    Parameters
    ----------
    values : ndarray, shape (n,)
    dt : float
        Their distance [s].
    frequency : float
        Where half the amplitude is left [Hz].
    order : int
        In each direction; both together fall by 12 dB an octave and order.
    ends : str
        How each end is continued by one period of the frequency: mirrored as it is (`even`), or
        about its last sample (`odd`).

    Notes
    -----
    The line of least squares goes first: it is slow. Ends that are mirrored as they are leave
    the least of slow parts behind.
    """
    level = values - trend(values, "line")
    return _both_ways(level, dt, frequency, order, "highpass", ends)


def _both_ways(
    values: Floats,
    dt: float,
    frequency: float,
    order: int,
    kind: Literal["highpass", "lowpass"],
    ends: Ends,
) -> Floats:
    from scipy.signal import butter, sosfiltfilt

    sections = butter(order, frequency, kind, fs=1 / dt, output="sos")
    period = int(min(len(values) - 1, 1 / (frequency * dt)))
    passed = sosfiltfilt(sections, values, padtype=ends, padlen=period)
    return np.asarray(passed, dtype=np.float64)


def gain(frequency: float, corner: float, order: int) -> float:
    """Give what `low_pass` leaves of an amplitude at a frequency [-]."""
    return 1 / (1 + (frequency / corner) ** (2 * order))


def displacements(motion: Samples, frequency: float, order: int) -> tuple[Floats, Floats]:
    """Return the part of the displacement of samples that is faster than a frequency, twice.

    Parameters
    ----------
    motion : Samples
        With its slow parts.
    frequency, order
        As in `high_pass`.

    Returns
    -------
    u : ndarray, shape (n,)
        Displacement [m].
    otherwise : ndarray, shape (n,)
        The same with another continuation of the ends: what both differ by is uncertain.

    Notes
    -----
    The double integral of ü, linear between its samples, less its drift, through the filter.
    Filtered before the integration, what an end leaves of slow parts would grow to be most of
    u. What is left lies within a period of either end, where u depends on how it is continued:
    mirrored about its last sample, which suits slow parts, or mirrored as it is, which suits a
    seat-test signal without any. What a continuation leaves of slow parts adds to u, so the
    one with the smaller RMS is u.
    """
    u_dd, dt = motion.u_dd[:] - trend(motion.u_dd[:], "line"), motion.dt
    u_d = np.zeros_like(u_dd)
    np.cumsum((u_dd[1:] + u_dd[:-1]) * (dt / 2), out=u_d[1:])
    u_d -= u_d.mean()
    u = np.zeros_like(u_dd)
    np.cumsum(u_d[:-1] * dt + (2 * u_dd[:-1] + u_dd[1:]) * (dt * dt / 6), out=u[1:])
    span = np.linspace(-1.0, 1.0, len(u))
    u -= np.polynomial.Legendre.fit(span, u, min(DRIFT, len(u) - 1), domain=[-1, 1])(span)
    ways: tuple[Literal["odd", "even"], ...] = "odd", "even"
    found = [_both_ways(u, dt, frequency, order, "highpass", ends) for ends in ways]
    least, most = sorted(found, key=lambda values: float(values @ values))
    return least, most
