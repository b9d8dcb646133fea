"""Periods: signals that repeat, from their spectra. Knows no noise."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import machine
from drysim.core.signal import KEPT

Floats = NDArray[np.float64]

IN_PLACE = np.lib.NumpyVersion(np.__version__) >= "2.0.0"
"""Whether numpy can transform into memory at hand: the memory of a long signal costs time."""

MOST = 4
"""Threads for a long signal: memory is no faster with more."""

Job = TypeVar("Job")
Done = TypeVar("Done")


def share(do: Callable[[Job], Done], jobs: Iterable[Job], n: int) -> list[Done]:
    """Give what is done to every job; for a signal of many samples [n] in threads."""
    if n <= KEPT:
        return [do(job) for job in jobs]
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(min(machine.processors(), MOST)) as pool:
        return list(pool.map(do, jobs))


def periods(spectra: NDArray[np.complex128], n: int) -> Iterable[Floats]:
    """Give one period of two signals [n], each with its first sample again.

    Other libraries transform two real signals faster, but round otherwise in some releases: a
    seed would not be the same signal to the last bit alone and among others.
    """
    return share(lambda spectrum: _closed(spectrum, n), spectra, n)


def _closed(spectrum: NDArray[np.complex128], n: int) -> Floats:
    """Give one period of a signal [n] and its first sample again, which closes it."""
    signal = np.empty(n + 1)
    if IN_PLACE:
        np.fft.irfft(spectrum, n, norm="forward", out=signal[:n])
    else:
        signal[:n] = np.fft.irfft(spectrum, n, norm="forward")
    signal[n] = signal[0]
    return signal
