"""From the numbers of a record to ü: the spline and the window."""

from __future__ import annotations

from math import ceil, floor
from typing import NamedTuple

import numpy as np

from drysim.core.motion import Samples
from drysim.core.signal import Signal
from drysim.excitation.record.file import fault
from drysim.excitation.record.spoken import Window
from drysim.excitation.record.stored import stretch

EDGE = 1e-6
"""Share of a step by which the edge of a window may miss a sample: rounding of its time."""

EXACT = ".15g"
"""Format of a time: seconds since 1970 have ten digits before the point."""


class Series(NamedTuple):
    """Evenly spaced samples in SI, their distance and the time of the first [s]."""

    values: Signal
    dt: float
    first: float


def span(series: Series, window: Window | None, shown: str) -> tuple[int, int]:
    """Give the first and the last sample of a window, 0-based.

    Raises
    ------
    RecordError
        When the window does not lie in the record, or holds fewer than two samples.
    """
    first, last = 0, len(series.values) - 1
    if window is None:
        return first, last
    if window.start is not None:
        first = ceil(_steps(window.start, series) - EDGE)
    if window.to is not None:
        # A record of 60 s has its last sample one step before 60 s.
        end = floor(_steps(window.to, series) + EDGE)
        last = last if end == last + 1 else end
    if 0 <= first < last < len(series.values):
        return first, last
    wrong, until = "", series.first + (len(series.values) - 1) * series.dt
    for key, t, at in (("from", window.start, first), ("to", window.to, last)):
        if not wrong and not 0 <= at < len(series.values):
            side = "before the beginning" if at < 0 else "behind the end"
            wrong = f"`window.{key}`, {t:{EXACT}} s, is {side} of"
    sentence = (
        f"{wrong or 'the window must hold two samples of'} the record, which runs from "
        f"{series.first:{EXACT}} s to {until:{EXACT}} s in steps of {series.dt:.6g} s"
    )
    raise fault(shown, sentence)


def _steps(t: float, series: Series) -> float:
    """Steps from the first sample to a time, within what a whole number can be made of."""
    return max(-1e18, min(1e18, (t - series.first) / series.dt))


def cut(motion: Samples, first: int, last: int, n: int) -> Samples:
    """Give the motion from the first to the last of n samples of the record."""
    finer = (len(motion.u_dd) - 1) // (n - 1)
    part = first * finer, last * finer + 1
    u = None if motion.u is None else motion.u[slice(*part)]
    return motion._replace(u_dd=stretch(motion.u_dd, *part), u=u)


def from_acceleration(series: Series) -> Samples:
    """Give samples of acceleration as they are, linear between them."""
    return Samples(series.values, series.dt)


def from_velocity(series: Series) -> Samples:
    """Give the derivative of the quadratic spline through samples of velocity.

    Notes
    -----
    The spline's pieces meet midway between samples, where its derivative bends. So ü is given
    at every half step, which holds each bend: linear between those, it is the spline's
    derivative exactly.
    """
    from scipy.interpolate import make_interp_spline

    n = len(series.values)
    spline = make_interp_spline(np.arange(n), series.values[:], k=min(2, n - 1))
    u_dd = np.asarray(spline(np.arange(2 * n - 1) / 2, 1), dtype=np.float64) / series.dt
    return Samples(u_dd, series.dt / 2)


def from_displacement(series: Series) -> Samples:
    """Give the second derivative of the C² cubic spline through samples of displacement.

    Notes
    -----
    Not-a-knot at the ends. The second derivative is linear between the samples.
    """
    from scipy.interpolate import CubicSpline

    u, steps = series.values[:], np.arange(len(series.values))
    u_dd = np.asarray(CubicSpline(steps, u)(steps, 2), dtype=np.float64) / series.dt**2
    return Samples(u_dd, series.dt, u)


SPLINES = {
    "acceleration": from_acceleration,
    "velocity": from_velocity,
    "displacement": from_displacement,
}
