"""Write the synthetic measurements of the gallery that are fitted: a seat, its curves, a decay.

python scenarios/fit_records.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.random import PCG64, Generator
from numpy.typing import NDArray

import drysim
from drysim.metrics.spectra import transfer_estimate

Floats = NDArray[np.float64]

SEED = 6
HERE = Path(__file__).parent

SEAT = {"m": 75.0, "k_x": 4500.0, "b": 300.0, "F_fk": 32.0, "F_fs": 42.0}
"""The seat that is to be found again."""
SEAT_SAMPLES, SEAT_DT = 8_000, 5e-3
"""Number of samples of the seat and their step [s]."""
FLOOR = (1.6, 0.9, 0.25)
"""Resonance of the floor: frequency [Hz], RMS acceleration [m/s²] and damping ratio."""
CUT_OFF = 8.0
"""Frequency above which the floor moves little [Hz]."""
SEAT_NOISE = (0.03, 1e-4)
"""RMS of the noise of acceleration [m/s²] and stroke [m]."""

LEVELS = (0.42, 0.7, 1.2)
"""RMS acceleration of sines under this seat [m/s²]; at the lowest it just breaks away."""
FREQUENCIES = np.round(np.geomspace(0.5, 20.0, 25), 2)
"""Their frequencies [Hz]."""
CURVE_SEED, CURVE_NOISE = 7, 0.02
"""Seed and relative noise of the ratios."""

RANDOM_LEVELS = (0.6, 1.0, 1.8)
"""RMS acceleration of random motion under this seat [m/s²]."""
LINES = np.round(np.arange(0.6, 12.1, 0.2), 1)
"""Frequencies of its transmissibility [Hz]."""
RANDOM_BASE = {"kind": "psd", "points": [[0.5, 1.0], [20.0, 1.0]], "duration": 300.0}
"""Its spectrum, flat, and the length of each test [s]; segments are 5 s long."""
FIRST_TEST, RANDOM_SEED = 1001, 8
"""Seed of the first test, and that of the noise."""

DECAY = {"m": 4.0, "k_x": 900.0, "b": 1.5, "F_fk": 1.2, "F_fs": 1.5}
"""The instrument on its slide that is to be found again."""
DECAY_SAMPLES, DECAY_DT = 1_000, 4e-3
"""Number of samples of the decay and their step [s]."""
RELEASE = 30e-3
"""Displacement from which it is released [m]."""
DECAY_NOISE = 5e-5
"""RMS of the noise of the displacement [m]."""


def written(seed: int) -> str:
    """Return the comment that names this script and its seed."""
    return f"# Written by scenarios/fit_records.py with seed {seed}.\n"


WORDS = "# Synthetic: no measurement. Computed by drysim, with noise of the sensors added.\n"
SEAT_HEADER = f"{WORDS}{written(SEED)}t [s],floor [m/s2],seat [m/s2],stroke [mm]\n"
DECAY_HEADER = f"{WORDS}{written(SEED)}t [s],x [mm]\n"
RATIOS = ",".join(f"T_a {level},T_x {level}" for level in LEVELS)
RANDOM_RATIOS = ",".join(f"T_a {level},T_x {level}" for level in RANDOM_LEVELS)
RANDOM_HEADER = f"{WORDS}{written(RANDOM_SEED)}f [Hz],{RANDOM_RATIOS}\n"
CURVES_HEADER = f"{WORDS}{written(CURVE_SEED)}f [Hz],{RATIOS}\n"


def floor(draw: Generator) -> Floats:
    """Return the acceleration of a floor [m/s²] to three digits, shape (SEAT_SAMPLES,)."""
    f_0, rms, damping = FLOOR
    f = np.fft.rfftfreq(SEAT_SAMPLES, SEAT_DT)
    ratio = f / f_0
    gain = ratio**2 / np.hypot(1 - ratio**2, 2 * damping * ratio) / (1 + (f / CUT_OFF) ** 4)
    real, imaginary = draw.standard_normal((2, len(f)))
    noise = np.fft.irfft(gain * (real + 1j * imaginary), SEAT_SAMPLES)
    return np.round(rms / noise.std() * noise, 3) + 0.0


def seat(seed: int = SEED) -> str:
    """Return the record of the seat: floor, acceleration and stroke."""
    draw = Generator(PCG64(seed))
    u_dd = floor(draw)
    motion = drysim.simulate(**SEAT, u_dd=u_dd, dt=SEAT_DT)
    of_x_dd, of_x_r = (rms * draw.standard_normal(SEAT_SAMPLES) for rms in SEAT_NOISE)
    columns = u_dd, motion.x_dd + of_x_dd, 1e3 * (motion.x_r + of_x_r)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return SEAT_HEADER + "".join(
        f"{k * SEAT_DT:.3f},{base:.3f},{mass:.3f},{stroke:.2f}\n"
        for k, (base, mass, stroke) in enumerate(rows)
    )


def curves(seed: int = CURVE_SEED) -> str:
    """Return the transmissibility curves of the seat, to three digits."""
    draw = Generator(PCG64(seed))
    seat_on_sines = {
        "oscillator": {"mass": SEAT["m"], "stiffness": SEAT["k_x"], "damping": SEAT["b"]},
        "friction": {"kinetic": SEAT["F_fk"], "static": SEAT["F_fs"]},
        "excitation": {"kind": "harmonic", "frequency": 1.0, "rms": 1.0},
        "sweep": {"excitation.frequency": FREQUENCIES.tolist(), "excitation.rms": [*LEVELS]},
    }
    exact = {
        (row.point["excitation.frequency"], row.point["excitation.rms"]): row.metrics
        for row in drysim.sweep(drysim.scenario(seat_on_sines)).rows
    }
    columns = np.array(
        [
            [exact[f, level][ratio] for level in LEVELS for ratio in ("T_a", "T_x")]
            for f in FREQUENCIES.tolist()
        ]
    )
    columns *= 1.0 + CURVE_NOISE * draw.standard_normal(columns.shape)
    lines = zip(FREQUENCIES.tolist(), columns.tolist(), strict=True)
    return CURVES_HEADER + "".join(
        f"{f:g},{','.join(f'{ratio:.3f}' for ratio in ratios)}\n" for f, ratios in lines
    )


def random_curves(seed: int = RANDOM_SEED) -> str:
    """Return the transmissibility of the seat under random motion by H1, to three digits."""
    draw, columns = Generator(PCG64(seed)), []
    for i, level in enumerate(RANDOM_LEVELS):
        scenario = {
            "oscillator": {"mass": SEAT["m"], "stiffness": SEAT["k_x"], "damping": SEAT["b"]},
            "friction": {"kinetic": SEAT["F_fk"], "static": SEAT["F_fs"]},
            "excitation": RANDOM_BASE | {"rms": level, "seed": FIRST_TEST + i},
            "solver": {"step": 1e-3},
        }
        motion = drysim.run(drysim.scenario(scenario)).response
        for series in (motion.x_dd, motion.x_r):
            estimate = transfer_estimate(motion.u_dd, np.array(series), motion.dt, 5.0)
            columns.append(np.interp(LINES, estimate.f, np.abs(estimate.H1)))
        columns[-1] *= (2.0 * np.pi * LINES) ** 2
    ratios = np.array(columns) * (1.0 + CURVE_NOISE * draw.standard_normal((6, len(LINES))))
    return RANDOM_HEADER + "".join(
        f"{f:g},{','.join(f'{ratio:.3f}' for ratio in row)}\n"
        for f, row in zip(LINES.tolist(), ratios.T.tolist(), strict=True)
    )


def decay(seed: int = SEED) -> str:
    """Return the record of the free decay: the displacement."""
    rest = np.zeros(DECAY_SAMPLES)
    motion = drysim.simulate(**DECAY, u_dd=rest, dt=DECAY_DT, x_r=RELEASE)
    noise = DECAY_NOISE * Generator(PCG64(seed)).standard_normal(DECAY_SAMPLES)
    rows = enumerate((1e3 * (motion.x_r + noise)).tolist())
    return DECAY_HEADER + "".join(f"{k * DECAY_DT:.3f},{x:.2f}\n" for k, x in rows)


FILES = {
    HERE / "fit-seat-synthetic.csv": seat,
    HERE / "fit-curves-synthetic.csv": curves,
    HERE / "fit-spectrum-synthetic.csv": random_curves,
    HERE / "fit-decay-synthetic.csv": decay,
}
"""Each file and what writes it."""


if __name__ == "__main__":
    for file, write in FILES.items():
        file.write_text(write(), encoding="utf-8", newline="\n")
