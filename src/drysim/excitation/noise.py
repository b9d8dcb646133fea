"""Noise: a random signal of given spectrum, as lines of random phase. Knows no scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import ceil, floor, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.motion import Samples
from drysim.errors import Caution

Floats = NDArray[np.float64]
Density = Callable[[Floats], Floats]

ON_LINE = 1e-9
"""A corner of the spectrum this close to a line, relative to it, lies on the line."""

PHASES = 1 << 16
"""Phases that a line may have, evenly spread: a table in place of a sine and cosine a line."""

FEW = 30
"""Sums of fewer equal lines than this [-] are seen to be no Gaussian noise: the excess
kurtosis is -1.5 over their number."""

IN_PLACE = np.lib.NumpyVersion(np.__version__) >= "2.0.0"
"""Whether numpy can transform into memory at hand: the memory of a long signal costs time."""

LOST = 0.01
"""Share of the RMS that straight lines between samples may take before it is said [-]."""


class Lines(NamedTuple):
    """Lines at k/T of a signal with period T: number of the first, mean squares [m²/s⁴]."""

    first: int
    squares: Floats
    T: float


def numbers(low: float, high: float, T: float) -> tuple[int, int]:
    """Give the first and the last line k/T within a band [Hz]; none if the first is above."""
    return ceil(low * T * (1 - ON_LINE)), floor(high * T * (1 + ON_LINE))


def lines(G: Density, band: tuple[float, float], square: float, T: float) -> Lines:
    """Give the lines of a one-sided PSD in a band.

    Parameters
    ----------
    G : callable
        PSD [(m/s²)²/Hz] at frequencies [Hz].
    band : tuple of float
        First and last frequency [Hz]; the PSD is zero outside.
    square : float
        Integral of the PSD over the band [m²/s⁴], which the lines share.
    T : float
        Period of the signal [s].
    """
    first, last = numbers(*band, T)
    squares = G(np.clip(np.arange(first, last + 1) / T, *band))
    squares *= square / squares.sum()
    return Lines(first, squares, T)


def noise(wanted: Lines, step: float, seed: int, rms: float | None = None) -> Samples:
    """Give samples of one signal with these lines, over exactly one period.

    Parameters
    ----------
    wanted : Lines
        All below half of 1/step.
    step : float
        Distance of the samples [s]; a whole number of them makes the period.
    seed : int
    rms : float, optional
        RMS value [m/s²] to which ü is scaled, as it is: linear between its samples.

    Notes
    -----
    Only the phases are random: the amplitude of each line is that of the PSD. Line k takes
    number k of `PCG64(seed)`, so neither a finer step nor another band changes its phase. The
    displacement has no mean and no drift, and is that of ü as it is: linear between samples.
    """
    first, squares, T = wanted
    n, k = round(T / step), np.arange(first, first + len(squares))
    bend = np.square(np.sin(pi / T * step * k))
    kept = float(squares @ (1 - 2 / 3 * bend))  # mean square, straight lines between samples
    scale = 1.0 if rms is None else rms / sqrt(kept)
    spectrum = np.zeros(n // 2 + 1, dtype=complex)
    band = spectrum[first : first + len(squares)]
    np.multiply(np.sqrt(squares / 2) * scale, _turns(first, len(squares), seed), out=band)
    u_dd = _closed(spectrum, n)
    band *= step * step * (1 / 6 - 1 / 4 / bend)  # -1/ω² for steps without end
    asked = float(squares.sum())
    realised: dict[str, object] = {
        "rms_asked": sqrt(asked) if rms is None else rms,
        "rms": sqrt(kept) * scale,
        "scale": scale,
        "lines": len(squares),
    }
    cautions = (*_few(squares), *coarse(sqrt(kept / asked), step, "RMS than its spectrum"))
    return Samples(u_dd, step, _closed(spectrum, n), (), cautions, realised)


def _turns(first: int, count: int, seed: int) -> NDArray[np.complex128]:
    """Give e^(jφ) with a random phase for every line."""
    random = np.random.Generator(np.random.PCG64(seed))
    codes = random.integers(PHASES, size=first + count, dtype=np.uint16)[first:]
    table = np.exp(2j * pi / PHASES * np.arange(PHASES))
    return np.asarray(table[codes])


def _closed(spectrum: NDArray[np.complex128], n: int) -> Floats:
    """Give one period of a signal [n] and its first sample again, which closes it."""
    signal = np.empty(n + 1)
    if IN_PLACE:
        np.fft.irfft(spectrum, n, norm="forward", out=signal[:n])
    else:
        signal[:n] = np.fft.irfft(spectrum, n, norm="forward")
    signal[n] = signal[0]
    return signal


def _few(squares: Floats) -> Iterator[Caution]:
    """Say when so few lines are no noise."""
    effective = float(squares.sum() ** 2 / (squares @ squares))
    if effective < FEW:
        sentence = (
            f"the random signal is a sum of {effective:.3g} lines in effect, too few for "
            f"Gaussian noise; {FEW / effective:.2g} times its duration would give {FEW}"
        )
        yield Caution("few-lines", sentence, {"lines": effective})


def coarse(kept: float, step: float, what: str) -> Iterator[Caution]:
    """Say when the samples are too far apart to be joined by straight lines.

    `kept` is the share of `what` that is left; the loss goes with the step squared.
    """
    if kept < 1 - LOST:
        fine = 0.9 * step * sqrt(LOST / (1 - kept))
        sentence = (
            f"solver.step is coarse: joined by straight lines, the samples of the base have "
            f"{(1 - kept) * 100:.2g} % less {what}; {fine:.2g} s would be fine"
        )
        yield Caution("coarse-step", sentence, {"solver.step": step, "kept": kept})
