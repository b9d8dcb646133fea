"""Write the synthetic seat-test record of the gallery, reproducible to the byte.

python scenarios/seat_test_record.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SEED = 7096
SAMPLES = 24_000
DT = 2.5e-3
"""Step of the samples [s]."""

# Spectral class EM1 of EN ISO 7096.
G_0 = 2.82
"""Scale of the PSD [(m/s²)²/Hz]."""
HIGH_PASS = (1.5, 4)
LOW_PASS = (2.5, 4)
"""Corner frequency [Hz] and order, Butterworth."""
BAND = (0.89, 11.22)
"""The PSD is zero outside [Hz]."""

FILE = Path(__file__).with_name("seat-test-em1-synthetic.csv")
HEADER = f"""\
# Synthetic: no measurement, nobody sat on this seat.
# Base acceleration drawn from the EM1 seat-test spectrum of EN ISO 7096, 60 s at 400 Hz,
# by scenarios/seat_test_record.py with seed {SEED}.
t [s],u_dd [m/s2]
"""


def spectrum(f: Floats) -> Floats:
    """Return the one-sided power spectral density of ü [(m/s²)²/Hz] at frequencies [Hz]."""
    inside = (f >= BAND[0]) & (f <= BAND[1])
    high, n = (f / HIGH_PASS[0]) ** (2 * HIGH_PASS[1]), 2 * LOW_PASS[1]
    return np.where(inside, G_0 * high / (1 + high) / (1 + (f / LOW_PASS[0]) ** n), 0.0)


def noise(seed: int = SEED) -> Floats:
    """Return Gaussian noise with this spectrum [m/s²], shape (SAMPLES,)."""
    f = np.fft.rfftfreq(SAMPLES, DT)
    real, imaginary = Generator(PCG64(seed)).standard_normal((2, len(f)))
    # A line has the power of a band of width 1/(SAMPLES·DT), half in each of two normals.
    size = np.sqrt(spectrum(f) * SAMPLES / (4 * DT))
    return np.fft.irfft(size * (real + 1j * imaginary), SAMPLES)


def text(seed: int = SEED) -> str:
    """Return the content of the file."""
    values = np.round(noise(seed), 6) + 0.0  # no -0.000000
    rows = (f"{k * DT:.4f},{value:.6f}\n" for k, value in enumerate(values.tolist()))
    return HEADER + "".join(rows)


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8", newline="\n")
