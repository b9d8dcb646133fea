"""Comfort: what a person on the mass feels of its vibration, by ISO 2631-1."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.response import Response
from drysim.peaks import Values
from drysim.step_means import faded, step_means, steps_within
from drysim.weighting import gain

FADE = 20.0
"""Time [s] after which the weightings have forgotten: their slowest pole, in the high-pass,
decays by exp(-1.78/s t), to 4e-16."""

TAU = 1.0
"""Integration time of the running RMS [s]."""


def comfort(
    response: Response, window: tuple[float, float], name: str, k: float, periodic: bool
) -> Values:
    """Give a_w, SEAT, VDV, SEAT_VDV, MTVV and crest_factor of a response; None where unknown.

    Parameters
    ----------
    response : Response
        From t = 0 on. When it is periodic, its grid divides the repetition.
    window : tuple of float
        Begin and end of the window [s]; the steps that lie in it as a whole count.
    name : str
        Weighting, one of `drysim.weighting.WEIGHTINGS`.
    k : float
        Multiplying factor of the direction [-].
    periodic : bool
        Whether the response is one repetition of a periodic motion.

    Notes
    -----
    ISO 2631-1: a_w is the RMS of the weighted acceleration of the mass times k; VDV is
    (∫ a_w⁴ dt)^(1/4), so it grows with the window; MTVV is the greatest running RMS, here with
    the linear integration of 1 s (not the exponential one), wholly within the window; the
    crest factor is the greatest |a_w(t)| over a_w. SEAT and SEAT_VDV are a_w and VDV on the
    mass over those of the base.

    A motion that is not periodic is weighted as an instrument would that is switched on at
    t = 0, before which nothing moved: `settle` passes over the transients of both.
    """
    part, dt = steps_within(response, window), response.dt
    base, mass = (weighted(series, dt, name, periodic)[part] for series in step_means(response))
    if not len(mass):
        return {}
    a_u, a_w = k * rms(base), k * rms(mass)
    dose_u, dose = k * _dose(base, dt), k * _dose(mass, dt)
    running = greatest_running(mass, dt, periodic)
    return {
        "a_w": a_w,
        "SEAT": a_w / a_u if a_u else None,
        "VDV": dose,
        "SEAT_VDV": dose / dose_u if dose_u else None,
        "MTVV": None if running is None else k * running,
        "crest_factor": k * float(np.abs(mass).max()) / a_w if a_w else None,
    }


def weighted(means: Floats, dt: float, name: str, periodic: bool = False) -> Floats:
    """Give the weighted series of an acceleration, in the middles of the steps.

    Parameters
    ----------
    means : ndarray, shape (n,)
        Means over the steps [m/s²].
    dt : float
        Step [s].
    name : str
        Weighting.
    periodic : bool
        Whether the series repeats; else it is taken to be preceded and followed by nothing.

    Notes
    -----
    By FFT, with the exact gain at every line: a periodic series needs no padding, any other
    is followed by `FADE` of nothing, so that its end does not reach round to its beginning.
    """
    from scipy import fft

    n = len(means)
    length = n if periodic else fft.next_fast_len(n + math.ceil(FADE / dt), real=True)
    f: Floats = np.fft.rfftfreq(length, dt).astype(np.float64)
    spectrum = fft.rfft(means, length)
    spectrum *= gain(name, f) / faded(f, dt)
    return np.asarray(fft.irfft(spectrum, length)[:n], dtype=np.float64)


def rms(series: Floats) -> float:
    """Give the RMS of a series."""
    return math.sqrt(float(np.mean(np.square(series))))


def _dose(series: Floats, dt: float) -> float:
    """Give the fourth root of the integral of the fourth power."""
    return math.sqrt(math.sqrt(float(np.sum(np.square(np.square(series)))) * dt))


def greatest_running(series: Floats, dt: float, periodic: bool = False) -> float | None:
    """Give the greatest RMS over 1 s of a series; None for one that is shorter and ends."""
    span = TAU / dt
    if periodic:
        series = np.tile(series, 1 + math.ceil(span / len(series)))
    if len(series) < span:
        return None
    energy = np.concatenate(([0.0], np.cumsum(np.square(series))))
    ends = np.arange(len(energy))
    begins = ends - span
    before = np.interp(begins, ends, energy)
    squares = (energy - before)[begins >= 0] / span
    return math.sqrt(max(float(squares.max()), 0.0))
