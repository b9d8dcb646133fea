"""Spectra of base and mass: PSD, transmissibility H1 and coherence; RMS values in bands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach.solution import Response
from drysim.core.model import Floats, Plant
from drysim.metrics.comfort import (
    Complexes,
    averaging_gain,
    step_means,
    steps_in_window,
    weighting_gain,
)

MIN_SEGMENTS = 8
"""Fewest segments in a window, without overlap, unless the scenario says otherwise. Half
overlapped they are 15: the standard error of a PSD is 26 %. Half as many would give 39 %."""

PERIODS_PER_SEGMENT, MIN_SEGMENT_TIME = 8.0, 5.0
"""Natural periods per segment of a long window: eight lines below the natural frequency, about
one in the width of a resonance with 6 % of critical damping. And the shortest such segment [s],
whose lines are 0.2 Hz apart: a few below the natural frequency of any seat."""

MIN_SEGMENT_STEPS = 16
"""Steps of the shortest segment, which gives eight spectral lines: about five independent ones
by `HANN_BANDWIDTH`. Fewer show no shape."""

HANN_BANDWIDTH = 1.5
"""Noise bandwidth of the Hann window [lines]: the ratio of the mean of its square, 3/8, to the
square of its mean, 1/4."""


BANDS = (
    0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0, 10.0, 12.5, 16.0, 20.0,
    25.0, 31.5, 40.0, 50.0, 63.0, 80.0,
)  # fmt: skip
"""Nominal centres of the one-third-octave bands [Hz]."""

FIRST_BAND = -3
"""The exact centre of band i is 10^((FIRST_BAND + i)/10) Hz, IEC 61260-1."""


class Bands(NamedTuple):
    """RMS acceleration in one-third-octave bands [m/s²]; each array has shape (23,).

    NaN in a band that is narrower than the resolution of the window, or beyond half the
    sampling rate.
    """

    a_u: Floats
    a_x: Floats
    """Of base and mass."""
    a_wu: Floats | None
    a_w: Floats | None
    """The same, frequency-weighted, times the factor k; None without a weighting."""


class Spectra(NamedTuple):
    """One-sided spectra at the lines above 0 Hz; each array has shape (n,)."""

    f: Floats
    """Frequency [Hz]."""
    G_u: Floats
    G_x: Floats
    """PSD of ü and of ẍ [(m/s²)²/Hz]."""
    H1: Complexes
    """Transmissibility from ü to ẍ [-], cross spectrum over G_u."""
    coherence: Floats
    """Share of G_x that is linearly related to ü [-]."""
    segment: float
    """Length of a segment [s]."""
    segments: int
    """Number of segments averaged, half overlapping."""
    bands: Bands | None = None
    """RMS values in bands, if requested."""


def spectra(response: Response, window: tuple[float, float], segment: float) -> Spectra:
    """Return the spectra of a response in a window.

    Parameters
    ----------
    response : Response
    window : tuple of float
        Begin and end [s].
    segment : float
        Length of a segment [s]; lines are 1/segment apart.

    Notes
    -----
    Welch's method with Hann windows, half overlap, and the mean of the window removed. H1 =
    G_ux/G_u is unbiased by the part of ẍ that friction adds, which lowers the coherence
    instead. With n segments the standard error of a PSD is about 1/√(0.95 n). The accelerations
    are means over the steps, and the gain of averaging is divided out. G_u is therefore that of
    the linear interpolation between the samples: (x cot x)² times that of the samples, with x =
    π f dt, which is less by (2/3) x². Of what interpolation adds above half the sampling rate,
    a share of x⁴/15 of the amplitude is folded back, in base and mass alike.
    """
    dt, part = response.dt, steps_in_window(response, window)
    u_dd, x_dd = (series[part] - series[part].mean() for series in step_means(response))
    n = max(1, round(segment / dt))
    f: Floats = np.arange(1, n // 2 + 1) / (n * dt)
    G_u, G_x, G_ux = _spectral_matrix(u_dd, x_dd, n, dt)
    with np.errstate(invalid="ignore", divide="ignore"):
        H1, coherence = G_ux / G_u, np.square(np.abs(G_ux)) / (G_u * G_x)
    # H1 and coherence are ratios: the gain of averaging cancels in them.
    fading = np.square(averaging_gain(f, dt))
    count = 1 + (len(u_dd) - n) // (n - n // 2)
    return Spectra(f, G_u / fading, G_x / fading, H1, coherence, n * dt, count)


def third_octaves(
    response: Response, window: tuple[float, float], weights: tuple[str, float] | None
) -> Bands:
    """Return the RMS acceleration of base and mass in one-third-octave bands.

    Parameters
    ----------
    response : Response
    window : tuple of float
        Begin and end [s].
    weights : tuple or None
        Frequency weighting and its factor k [-].

    Notes
    -----
    Sums of squares of the Fourier series of the window, without its mean. The squares of all
    bands add up to the mean square between the outer band edges, 0.45 and 89 Hz. The gain of
    averaging over the steps is divided out, so that the bands are those of a base that is
    linear between its samples, as in `spectra`. Band edges are 10^(±1/20) times the centre.
    """
    dt, part = response.dt, steps_in_window(response, window)
    u_dd, x_dd = (series[part] for series in step_means(response))
    n = len(u_dd)
    f: Floats = np.arange(1, (n + 1) // 2) / (n * dt)
    powers = np.arange(len(BANDS) + 1) + FIRST_BAND - 0.5
    edges = 10.0 ** (powers / 10.0)
    is_resolved = (np.diff(edges) >= 1.0 / (n * dt)) & (edges[1:] <= 0.5 / dt)

    def band_rms(series: Floats, gain: Complexes | float = 1.0) -> Floats:
        """Return the RMS in each band of a series with this gain at the lines."""
        lines = np.fft.rfft(series)[1 : len(f) + 1] * gain / (n * averaging_gain(f, dt))
        square, _ = np.histogram(f, edges, weights=2.0 * np.square(np.abs(lines)))
        return np.where(is_resolved, np.sqrt(square), np.nan)

    if weights is None:
        return Bands(band_rms(u_dd), band_rms(x_dd), None, None)
    gain = weights[1] * weighting_gain(weights[0], f)
    return Bands(band_rms(u_dd), band_rms(x_dd), band_rms(u_dd, gain), band_rms(x_dd, gain))


def _spectral_matrix(
    u_dd: Floats, x_dd: Floats, n: int, dt: float, detrend: Literal["constant", False] = False
) -> tuple[Floats, Floats, Complexes]:
    """Return the one-sided PSDs of u_dd and x_dd and their cross spectrum [(m/s²)²/Hz].

    Each has shape (n // 2,), the lines above 0 Hz of segments of n samples with step dt [s].
    `detrend` is that of `scipy.signal.csd`.
    """
    u, x = (segment_transforms(series, n, dt, detrend) for series in (u_dd, x_dd))
    G_u, G_x = (np.mean(np.square(np.abs(lines)), axis=-1) for lines in (u, x))
    return G_u, G_x, np.mean(np.conj(u) * x, axis=-1)


def segment_transforms(
    series: Floats, n: int, dt: float, detrend: Literal["constant", False] = "constant"
) -> Complexes:
    """Return the Fourier transforms of half-overlapping segments.

    They have the shape (..., n // 2, segments), the lines above 0 Hz. The mean of the squares
    of a line over the segments is its one-sided PSD by Welch's method.

    Parameters
    ----------
    series : ndarray, shape (..., samples)
    n : int
        Samples of a segment.
    dt : float
        Step [s].
    detrend : {"constant", False}, optional
        Whether the mean of each segment is removed.
    """
    from scipy import signal

    _, _, transforms = signal.stft(
        series, fs=1.0 / dt, window="hann", nperseg=n, noverlap=n // 2, detrend=detrend,
        boundary=None, padded=False, scaling="psd",
    )  # fmt: skip
    # Both sides of the spectrum; the line at half the sampling rate has no other side.
    sides = np.full((n // 2, 1), np.sqrt(2.0))
    if n % 2 == 0:
        sides[-1] = 1.0
    lines: Complexes = sides * transforms[..., 1:, :]
    return lines


MIN_POWER_SHARE = 1e-3
"""PSD of the base over its peak below which a transmissibility is dominated by leakage [-]."""


def excited_lines(G_u: Floats) -> NDArray[np.bool_]:
    """Return the mask of lines at which the base and both neighbours have significant power.

    The neighbours count because a Hann window leaks into adjacent lines.
    """
    excited: NDArray[np.bool_] = G_u > MIN_POWER_SHARE * G_u.max(initial=0.0)
    inside = excited.copy()
    inside[1:] &= excited[:-1]
    inside[:-1] &= excited[1:]
    return inside


HANN_OVERLAP_CORRELATION = 1.0 / 36.0
"""Squared correlation of the spectra of white noise in two Hann windows that overlap by half:
the square of the mean of the product of both windows over the mean of its square, 1/6."""


class TransferEstimate(NamedTuple):
    """Transmissibility of a measured mass over frequency; each array has shape (n,)."""

    f: Floats
    """Frequency [Hz]."""
    G_u: Floats
    G_x: Floats
    """PSD of the samples of ü and of ẍ [(m/s²)²/Hz]."""
    G_ux: Complexes
    """Cross spectrum from ü to ẍ [(m/s²)²/Hz]."""
    segment: float
    """Length of a segment [s]."""
    segments: int
    """Number of segments averaged, half overlapping."""
    averages: float
    """Effective number of independent averages."""

    @property
    def H1(self) -> Complexes:
        """G_ux/G_u [-]: with noise of the base too small by 1 + noise/signal of G_u."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.G_ux / self.G_u, dtype=np.complex128)

    @property
    def H2(self) -> Complexes:
        """G_x/G_xu [-]: with noise of the mass too large by 1 + noise/signal of G_x."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.G_x / np.conj(self.G_ux), dtype=np.complex128)

    @property
    def Hv(self) -> Complexes:
        """Geometric mean of H1 and H2 [-]: right if both have noise in the same proportion."""
        with np.errstate(invalid="ignore", divide="ignore"):
            size = np.sqrt(self.G_x / self.G_u)
            return np.asarray(size * np.exp(1j * np.angle(self.G_ux)), dtype=np.complex128)

    @property
    def coherence(self) -> Floats:
        """|G_ux|²/(G_u G_x): share of G_x that is linearly related to ü [-]."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.minimum(np.square(np.abs(self.G_ux)) / (self.G_u * self.G_x), 1.0)


def transfer_estimate(
    u_dd: Floats, x_dd: Floats, dt: float, segment: float
) -> TransferEstimate:
    """Return the transmissibility between measured samples of base and mass.

    Parameters
    ----------
    u_dd, x_dd : ndarray, shape (n,)
        Samples at the same instants [m/s²].
    dt : float
        Step [s].
    segment : float
        Length of a segment [s]; lines are 1/segment apart.

    Notes
    -----
    Welch's method with Hann windows and half overlap, the mean of each segment removed, as
    `scipy.signal.csd` does by default. H1 and H2: Bendat and Piersol, Random Data (2010),
    section 6.2; Hv: Rocklin, Crowley and Vold (1985).

    N segments that overlap by half are N/(1 + 2 c (N - 1)/N) independent averages, where c is
    `HANN_OVERLAP_CORRELATION` (Welch 1967).
    """
    n = max(1, round(segment / dt))
    f: Floats = np.arange(1, n // 2 + 1) / (n * dt)
    count = 1 + (len(u_dd) - n) // (n - n // 2)
    averages = count / (1.0 + 2.0 * HANN_OVERLAP_CORRELATION * (count - 1) / count)
    matrix = _spectral_matrix(u_dd, x_dd, n, dt, "constant")
    return TransferEstimate(f, *matrix, n * dt, count, averages)


def combined_estimate(
    estimates: Sequence[TransferEstimate], are_independent: Sequence[bool]
) -> TransferEstimate:
    """Return the estimate from all segments of several runs, whose lines are the same.

    The spectra are means, weighted by the number of segments. The averages of the independent
    runs add up.
    """
    weights = [estimate.segments for estimate in estimates]
    G_u, G_x, G_ux = (
        np.average([getattr(estimate, name) for estimate in estimates], axis=0, weights=weights)
        for name in ("G_u", "G_x", "G_ux")
    )
    averages = sum(
        estimate.averages
        for estimate, is_independent in zip(estimates, are_independent, strict=True)
        if is_independent
    )
    first = estimates[0]
    return TransferEstimate(first.f, G_u, G_x, G_ux, first.segment, sum(weights), averages)


SAME_SIGNAL = 0.7
"""Correlation at any lag from which two base motions are the same signal [-]. Of independent
ones of 20 s of the classes of ISO 7096 it reaches 0.53, the more the narrower the band."""


def is_same_signal(first: Floats, second: Floats) -> bool:
    """Return whether two records of one step, of any lengths, repeat the same signal.

    The signal may be of the opposite sign, and begin at different instants.
    """
    from scipy import signal

    a, b = first - first.mean(), second - second.mean()
    scale = min(len(a), len(b)) * float(a.std() * b.std())
    return float(np.abs(signal.correlate(a, b, method="fft")).max()) >= SAME_SIGNAL * scale


def viscous_transmissibility(plant: Plant, f: Floats) -> Floats:
    """Return T_a without dry friction at frequencies [Hz], in closed form [-].

    |T_a| = |(k_x + j b ω)/(k_x + j b ω - m ω²)|.
    """
    m, k_x, b = plant
    omega = 2.0 * np.pi * f
    carried = k_x + 1j * b * omega
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.abs(carried / (carried - m * omega**2)), dtype=np.float64)
