"""Write the synthetic bus-floor record of the gallery, with the flaws of a measured one.

python scenarios/bus_floor_record.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SEED = 2631
SAMPLES = 18_000
DT = 5e-3
"""Step of the samples [s]."""
G = 9.80665
"""Acceleration of 1 g [m/s²]."""

MODES = ((1.7, 0.7, 0.15), (11.0, 0.5, 0.2))
"""Frequency [Hz], RMS acceleration [m/s²] and damping ratio of body bounce and wheel hop."""
SENSOR_NOISE = 0.06
"""RMS of white noise up to half the sampling rate [m/s²]."""
DRIFT = 0.15
"""Change of the sensor's offset over the record [m/s²]."""
DOOR = (52.0, 4.0, 24.0, 0.06)
"""Door slam: time [s], peak [m/s²], frequency [Hz] and time constant of its decay [s]."""

FILE = Path(__file__).with_name("bus-floor-synthetic.csv")
HEADER = f"""\
# Synthetic: no measurement. Floor of a bus, 90 s at 200 Hz, with the flaws of a logger file:
# gravity, drift of the offset, sensor noise, a door slam, and three digits.
# Written by scenarios/bus_floor_record.py with seed {SEED}.
Time [s];Floor Y [g];Floor Z [g]
"""


def vibration(draw: Generator) -> Floats:
    """Return noise with the resonances of body and wheels [m/s²], shape (SAMPLES,)."""
    f = np.fft.rfftfreq(SAMPLES, DT)
    total = np.zeros(SAMPLES)
    for f_0, rms, damping in MODES:
        ratio = f / f_0
        gain = ratio**2 / np.hypot(1 - ratio**2, 2 * damping * ratio) / (1 + (f / 20) ** 4)
        real, imaginary = draw.standard_normal((2, len(f)))
        part = np.fft.irfft(gain * (real + 1j * imaginary), SAMPLES)
        total += rms / part.std() * part
    return total


def floor(seed: int = SEED) -> tuple[Floats, Floats]:
    """Return lateral and vertical acceleration as the logger sees them [m/s²]."""
    draw = Generator(PCG64(seed))
    t = DT * np.arange(SAMPLES)
    lateral = 0.4 * vibration(draw) + SENSOR_NOISE * draw.standard_normal(SAMPLES)
    vertical = vibration(draw) + SENSOR_NOISE * draw.standard_normal(SAMPLES)
    begin, peak, frequency, decay = DOOR
    late = np.maximum(t - begin, 0.0)
    vertical += peak * np.exp(-late / decay) * np.sin(2 * np.pi * frequency * late)
    return lateral, vertical + G + DRIFT * t / t[-1]


def text(seed: int = SEED) -> str:
    """Return the content of the file."""
    y, z = (np.round(values / G, 3) + 0.0 for values in floor(seed))  # no -0.000
    rows = (
        f"{k * DT:.3f};{lateral:.3f};{vertical:.3f}\n"
        for k, (lateral, vertical) in enumerate(zip(y.tolist(), z.tolist(), strict=True))
    )
    return HEADER + "".join(rows)


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8", newline="\n")
