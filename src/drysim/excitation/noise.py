"""Noise: a random signal of given spectrum, as lines of random phase. Knows no scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from math import ceil, floor, pi, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.motion import Samples
from drysim.core.signal import BLOCK
from drysim.errors import Caution
from drysim.excitation.periods import periods, share

Floats = NDArray[np.float64]
Density = Callable[[Floats], Floats]

ON_LINE = 1e-9
"""A corner of the spectrum this close to a line, relative to it, lies on the line."""

PHASES = 1 << 16
"""Phases that a line may have, evenly spread: a table in place of a sine and cosine a line."""

FEW = 30
"""Sums of fewer equal lines than this [-] are seen to be no Gaussian noise: the excess
kurtosis is -1.5 over their number."""

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
    squares = np.empty(last + 1 - first)

    def fill(part: slice) -> None:
        squares[part] = G(np.clip(np.arange(first + part.start, first + part.stop) / T, *band))

    share(fill, _parts(len(squares)), len(squares))
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
    n, turn, weights = round(T / step), pi / T * step, np.empty(len(squares))

    def weigh(part: slice) -> None:
        weights[part] = 1 - 2 / 3 * _bend(turn, first, part)

    share(weigh, _parts(len(squares)), n)
    kept = float(squares @ weights)  # mean square, straight lines between samples
    scale = 1.0 if rms is None else rms / sqrt(kept)
    codes, table = _codes(first, len(squares), seed), _turns()
    spectra = np.zeros((2, n // 2 + 1), dtype=complex)

    def fill(part: slice) -> None:
        u_dd, u = spectra[:, first + part.start : first + part.stop]
        np.multiply(np.sqrt(squares[part] / 2) * scale, table[codes[part]], out=u_dd)
        bend = _bend(turn, first, part)
        np.multiply(u_dd, step * step * (1 / 6 - 1 / 4 / bend), out=u)  # -1/ω² for no step

    share(fill, _parts(len(squares)), n)
    u_dd, u = periods(spectra, n)
    asked = float(squares.sum())
    realised: dict[str, object] = {
        "rms_asked": sqrt(asked) if rms is None else rms,
        "rms": sqrt(kept) * scale,
        "scale": scale,
        "lines": len(squares),
    }
    cautions = (*_few(squares), *coarse(sqrt(kept / asked), step, "RMS than its spectrum"))
    return Samples(u_dd, step, u, (), cautions, realised)


def _parts(count: int) -> Iterator[slice]:
    """Cut so many lines into parts that stay near the processor."""
    return (slice(at, min(at + BLOCK, count)) for at in range(0, count, BLOCK))


def _bend(turn: float, first: int, part: slice) -> Floats:
    """Give sin² of half the turn that some lines make in a step."""
    return np.square(np.sin(turn * np.arange(first + part.start, first + part.stop)))


def _codes(first: int, count: int, seed: int) -> NDArray[np.uint16]:
    """Give a random phase for every line, by its number."""
    random = np.random.Generator(np.random.PCG64(seed))
    return random.integers(PHASES, size=first + count, dtype=np.uint16)[first:]


@cache
def _turns() -> NDArray[np.complex128]:
    """Give e^(jφ) of every phase that a line may have, made once: each seed wants it."""
    turns: NDArray[np.complex128] = np.exp(2j * pi / PHASES * np.arange(PHASES))
    turns.flags.writeable = False
    return turns


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
