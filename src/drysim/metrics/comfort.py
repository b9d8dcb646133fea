"""Whole-body vibration after ISO 2631-1: a_w, VDV, MTVV, crest factor and SEAT.

The frequency weightings are the analogue filters of ISO 8041, applied in the frequency domain.
They act on the mean acceleration in each step, which `metrics.spectra` uses as well.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.solution import Response
from drysim.core.model import Floats, Samples, Sines, base_acceleration, recall, recall_for

Complexes = NDArray[np.complex128]

STEP_TOLERANCE = 1e-6
"""Distance from a grid point, in steps, within which a time counts as on it: above the rounding
of a time after 1e9 steps, 1e-7 of a step, and a change of the window that no metric shows."""

PADDING_TIME = 20.0
"""Zero padding [s] after which the weightings have decayed: the slowest pole, of the high-pass
filter, decays as exp(-1.78/s t), to 4e-16."""

RUNNING_RMS_TIME = 1.0
"""Integration time of the running RMS [s], as ISO 2631-1 recommends for MTVV."""

HIGH_PASS, LOW_PASS = 0.4, 100.0
"""Corner frequencies of the band limits of all weightings, second-order Butterworth [Hz]."""


class WeightingFilter(NamedTuple):
    """Frequency weighting without its band limits; f4 = f3."""

    f_3: float
    Q_4: float
    """Corner [Hz] and resonance [-] of the transition from acceleration to velocity."""
    step: tuple[float, float, float, float] | None = None
    """f5 [Hz], Q5, f6 [Hz], Q6 of the upward step; None for none."""


WEIGHTINGS = {
    "Wk": WeightingFilter(12.5, 0.63, (2.37, 0.91, 3.35, 0.91)),
    "Wd": WeightingFilter(2.0, 0.63),
    "Wc": WeightingFilter(8.0, 0.63),
}
"""Wk: seat, vertical. Wd: seat, horizontal. Wc: backrest, fore and aft."""

DIRECTIONS = {"vertical": ("Wk", 1.0), "horizontal": ("Wd", 1.4)}
"""Weighting and multiplying factor k [-] for the directions of a seat: 1.4 a_wx, 1.4 a_wy and
a_wz, directive 2002/44/EC, annex B.1."""


class ExposureLimit(NamedTuple):
    """Limit of the daily exposure to whole-body vibration."""

    name: str
    A_8: float
    """Weighted RMS acceleration over 8 h [m/s²]."""
    VDV: float
    """Vibration dose of a day [m/s^1.75]."""

    def hours(self, weighted: float, dose: float, length: float) -> tuple[float, float]:
        """Return the hours a day until A(8), and until the dose, reaches the limit.

        Parameters
        ----------
        weighted, dose : float
            Weighted RMS acceleration [m/s²] and dose [m/s^1.75] of a record.
        length : float
            Length of the record [s].
        """
        day, hour = DAY_OF_WORK / HOUR, length / HOUR
        by_rms = day * (self.A_8 / weighted) ** 2 if weighted else math.inf
        return by_rms, hour * (self.VDV / dose) ** 4 if dose else math.inf


HOUR, DAY_OF_WORK = 3600.0, 8 * 3600.0
"""An hour, and the reference duration of daily exposures [s]."""

EXPOSURE_LIMITS = (
    ExposureLimit("action value", 0.5, 9.1),
    ExposureLimit("limit value", 1.15, 21.0),
)
"""Directive 2002/44/EC, article 3 (2)."""


class Weighted(NamedTuple):
    """Frequency-weighted accelerations in a window, times the factor k of the direction."""

    a_w: float
    base_a_w: float
    """RMS on the mass and on the base [m/s²]."""
    dose: float
    base_dose: float
    """Fourth root of the integral of the fourth power [m/s^1.75]."""
    running: float | None
    """Largest running RMS on the mass [m/s²]; None for a window that is too short."""
    peak: float
    """Largest magnitude on the mass [m/s²]."""


def weighted_accelerations(
    response: Response, window: tuple[float, float], name: str, k: float, periodic: bool
) -> Weighted | None:
    """Return the frequency-weighted accelerations; None if no step lies within the window.

    Parameters
    ----------
    response : Response
        From t = 0. The grid of a periodic response divides its repetition.
    window : tuple of float
        Begin and end of the window [s]; steps wholly within it count.
    name : str
        Weighting, one of `WEIGHTINGS`.
    k : float
        Multiplying factor of the direction [-].
    periodic : bool
        Whether the response is one repetition of a periodic motion.

    Notes
    -----
    ISO 2631-1: a_w is k times the RMS of the weighted acceleration of the mass. VDV is (∫ a_w⁴
    dt)^(1/4) and so grows with the window. MTVV is the largest running RMS within the window,
    here with linear integration over 1 s (not the exponential one). The crest factor is the
    largest |a_w(t)| over a_w. SEAT and SEAT_VDV are a_w and VDV on the mass over those of the
    base.

    A motion that is not periodic is weighted as by an instrument that is switched on at t = 0,
    with no motion before. `settle` excludes the transients of motion and filters.
    """
    part, dt, motion = steps_in_window(response, window), response.dt, response.motion
    mass = apply_weighting(step_means(response)[1], dt, name, periodic)[part]
    if not len(mass):
        return None
    grid = dt, len(response), part.start, part.stop
    base = recall_for(motion, weighted_base, *grid, name, periodic)
    return _of_weighted(mass, base, dt, k, periodic)


def weighted_samples(
    x_dd: Floats, u_dd: Floats | None, dt: float, part: slice, name: str, k: float
) -> Weighted:
    """Return the frequency-weighted accelerations of measured samples of mass and base.

    Parameters
    ----------
    x_dd, u_dd : ndarray, shape (n,)
        Samples [m/s²], taken as those of signals without power above half the sampling rate.
        Without a base its values are 0.
    dt : float
        Step [s].
    part : slice
        Samples that count.
    name : str
        Weighting, one of `WEIGHTINGS`.
    k : float
        Multiplying factor of the direction [-].

    Notes
    -----
    As `weighted_accelerations`, but the samples themselves are weighted: a record does not jump
    between them.
    """
    mass, base = (
        np.zeros(1)
        if series is None
        else apply_weighting(series, dt, name, averaged=False)[part]
        for series in (x_dd, u_dd)
    )
    return _of_weighted(mass, (rms(base), _vibration_dose(base, dt)), dt, k)


def _of_weighted(
    mass: Floats, base: tuple[float, float], dt: float, k: float, periodic: bool = False
) -> Weighted:
    """Return what follows from a weighted mass, and from RMS and dose of a weighted base."""
    running = max_running_rms(mass, dt, periodic)
    return Weighted(
        k * rms(mass),
        k * base[0],
        k * _vibration_dose(mass, dt),
        k * base[1],
        None if running is None else k * running,
        k * float(np.abs(mass).max()),
    )


def weighted_base(
    motion: Sines | Samples,
    dt: float,
    size: int,
    first: int,
    last: int,
    name: str,
    periodic: bool,
) -> tuple[float, float]:
    """Return RMS and dose of the weighted base acceleration in steps `first` to `last` - 1.

    The grid has `size` points with step dt [s].
    """
    base = apply_weighting(base_means(motion, dt, size), dt, name, periodic)[first:last]
    return rms(base), _vibration_dose(base, dt)


def apply_weighting(
    series: Floats, dt: float, name: str, periodic: bool = False, averaged: bool = True
) -> Floats:
    """Return the weighted acceleration at the midpoints of the steps, or at the samples.

    Parameters
    ----------
    series : ndarray, shape (n,)
        Means over the steps, or samples [m/s²].
    dt : float
        Step [s].
    name : str
        Weighting.
    periodic : bool
        Whether the series repeats; else it is zero before its beginning and after its end.
    averaged : bool
        Whether the series has means, whose attenuation with frequency is compensated.

    Notes
    -----
    By FFT, with the exact gain at every line. A series that is not periodic is padded with
    zeros for `PADDING_TIME`, so that the filter's response to its end does not wrap around to
    its beginning.
    """
    n = len(series)
    length = n if periodic else fast_length(n + math.ceil(PADDING_TIME / dt))
    spectrum = np.fft.rfft(series, length)
    # Once for all series of a length.
    spectrum *= recall(length, gain_at_lines, name, length, dt, averaged)
    return np.asarray(np.fft.irfft(spectrum, length)[:n], dtype=np.float64)


@lru_cache(maxsize=1)
def fast_length(least: int) -> int:
    """Return the smallest length of at least `least` without prime factors above 5.

    The FFT of such a length is fast. `scipy.fft` has this function, but its import takes as
    long as a hundred such transforms.
    """
    odd: list[int] = [3**i * 5**j for i in range(20) for j in range(14)]
    return min(factor << (-(-least // factor) - 1).bit_length() for factor in odd)


def gain_at_lines(name: str, length: int, dt: float, averaged: bool = True) -> Complexes:
    """Return the gain at all lines of a series of means over steps dt [s], or of samples.

    It is read-only.
    """
    f: Floats = np.fft.rfftfreq(length, dt).astype(np.float64)
    gain: Complexes = weighting_gain(name, f)
    if averaged:
        gain /= averaging_gain(f, dt)
    gain.flags.writeable = False
    return gain


def rms(series: Floats) -> float:
    """Return the RMS of a series."""
    return math.sqrt(float(np.mean(np.square(series))))


def _vibration_dose(series: Floats, dt: float) -> float:
    """Return the fourth root of the integral of the fourth power."""
    return math.sqrt(math.sqrt(float(np.sum(np.square(np.square(series)))) * dt))


def max_running_rms(series: Floats, dt: float, periodic: bool = False) -> float | None:
    """Return the largest RMS over 1 s; None for a shorter series that does not repeat."""
    span = RUNNING_RMS_TIME / dt
    if periodic:
        series = np.tile(series, 1 + math.ceil(span / len(series)))
    if len(series) < span:
        return None
    # Differences of the cumulative energy; a window that begins within a step takes a share
    # of it.
    energy = np.concatenate(([0.0], np.cumsum(np.square(series))))
    first, share = math.ceil(span), math.ceil(span) - span
    before = energy[: len(energy) - first]
    if share:
        before = before + share * np.diff(energy[: len(before) + 1])
    return math.sqrt(max(float((energy[first:] - before).max()) / span, 0.0))


def weighting_gain(name: str, f: Floats) -> Complexes:
    """Return the complex gain W of a weighting.

    Parameters
    ----------
    name : str
        One of `WEIGHTINGS`.
    f : ndarray
        Frequencies [Hz]; the gain at 0 is 0.

    Returns
    -------
    ndarray of complex
        W = H_hp H_lp H_t H_s [-], shape of `f`.

    Notes
    -----
    The analogue formula itself, not the rounded tables of the standard and not a digital
    filter, which departs from both towards half of its sampling rate.
    """
    f_3, Q_4, step = WEIGHTINGS[name]
    j: Complexes = (1j * f).astype(np.complex128)  # s/2π
    W = j * j / _second_order(j, HIGH_PASS, 0.5**0.5)
    W *= LOW_PASS**2 / _second_order(j, LOW_PASS, 0.5**0.5)
    W *= (1 + j / f_3) * f_3**2 / _second_order(j, f_3, Q_4)
    if step is not None:
        W *= _second_order(j, *step[:2]) / _second_order(j, *step[2:])
    return np.asarray(W, dtype=np.complex128)


def _second_order(j: Complexes, f_i: float, Q: float) -> Complexes:
    """Return (s² + s ω/Q + ω²)/(4π²)."""
    return j * j + j * (f_i / Q) + f_i**2


def step_means(response: Response) -> tuple[Floats, Floats]:
    """Return the mean accelerations of base and mass in every step.

    Parameters
    ----------
    response : Response
        On a grid of n points.

    Returns
    -------
    u_dd, x_dd : ndarray, shape (n - 1,)
        Means over the steps [m/s²].

    Notes
    -----
    ẍ = ü + dv_r/dt, so the mean over a step follows exactly from v_r at its ends, even if ẍ
    jumps within it. Point samples would be wrong by up to half a step at each jump of 2 F_fk/m.
    What remains is aliasing, which averaging keeps small. Averaging has the gain sin(π f dt)/(π
    f dt), see `averaging_gain`, which can be divided out.
    """
    u_dd = base_means(response.motion, response.dt, len(response))
    return u_dd, u_dd + np.diff(response.v_r) / response.dt


def base_means(motion: Sines | Samples, dt: float, size: int) -> Floats:
    """Return the mean base acceleration [m/s²] in every step of a grid of `size` points."""
    if isinstance(motion, Samples):
        u_dd = motion.u_dd[:size]
        return 0.5 * (u_dd[:-1] + u_dd[1:])
    A = tuple(A * float(np.sinc(f * dt)) for A, f in zip(motion.A, motion.f, strict=True))
    middles = (np.arange(size - 1, dtype=np.float64) + 0.5) * dt
    return base_acceleration(Sines(A, motion.f, motion.phase), middles)


def averaging_gain(f: Floats, dt: float) -> Floats:
    """Return the gain sin(π f dt)/(π f dt) of a mean over a step [s] at frequencies [Hz]."""
    return np.asarray(np.sinc(f * dt), dtype=np.float64)


def steps_in_window(response: Response, window: tuple[float, float]) -> slice:
    """Return the steps that lie wholly within a window [s]."""
    first = int(np.ceil(window[0] / response.dt - STEP_TOLERANCE))
    last = int(np.floor(window[1] / response.dt + STEP_TOLERANCE))
    return slice(first, max(first, min(last, len(response) - 1)))
