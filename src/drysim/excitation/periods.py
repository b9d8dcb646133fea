"""Periods: signals that repeat, from their spectra. Knows no noise."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from drysim import machine
from drysim.core.signal import KEPT

Floats = NDArray[np.float64]

IN_PLACE = np.lib.NumpyVersion(np.__version__) >= "2.0.0"
"""Whether numpy can transform into memory at hand: the memory of a long signal costs time."""

PAIRED = "scipy.fft"
"""Transforms signals in pairs, one in each half of a register, where numpy takes them singly;
used once it is loaded, see `expect_many`."""

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


def expect_many() -> None:
    """Load what makes two signals in little more than the time of one, to the last bit alike.

    It takes longer to load than a few signals take.
    """
    import scipy.fft  # noqa: F401


def periods(spectra: NDArray[np.complex128], n: int) -> Iterable[Floats]:
    """Give one period of two signals [n], each with its first sample again."""
    # Before 2.0, numpy transforms by other code than scipy, with other roundings.
    if n > KEPT or not IN_PLACE or PAIRED not in sys.modules:
        return share(lambda spectrum: _closed(spectrum, n), spectra, n)
    from scipy import fft  # waits where another thread is about to load it

    signals = np.empty((2, n + 1))
    signals[:, :n] = fft.irfft(spectra, n, norm="forward", overwrite_x=True)
    signals[:, n] = signals[:, 0]
    return signals


def _closed(spectrum: NDArray[np.complex128], n: int) -> Floats:
    """Give one period of a signal [n] and its first sample again, which closes it."""
    signal = np.empty(n + 1)
    if IN_PLACE:
        np.fft.irfft(spectrum, n, norm="forward", out=signal[:n])
    else:
        signal[:n] = np.fft.irfft(spectrum, n, norm="forward")
    signal[n] = signal[0]
    return signal
