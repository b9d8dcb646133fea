"""The scenes that laws beyond Coulomb's are tested on: the paper's oscillator, sines, noise."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.stick_slip import StickSlip
from drysim.core.motion import Samples, Sines
from drysim.core.plant import Plant
from drysim.core.state import State

PAPER = Plant(75.0, 7500.0, 500.0)
REST = State(0.0, 0.0)
STEP = 2.5e-3


def sine(a_u: float, f: float, phase: float = 0.0) -> Sines:
    return Sines((math.sqrt(2.0) * a_u,), (f,), (phase,))


def noise(n: int, a_u: float, seed: int = 1) -> Samples:
    """Give band-limited noise with no value in common with any law's constants."""
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(n))
    f = np.fft.rfftfreq(n, STEP)
    spectrum[(f < 0.5) | (f > 10.0)] = 0.0
    u_dd = np.fft.irfft(spectrum, n)
    return Samples(u_dd * (a_u / np.sqrt(np.mean(u_dd**2))), STEP)


def solved(law, motion, start=REST, duration=None, plant=PAPER):
    return StickSlip().solve(plant, law, motion, start, STEP, duration)


def mirrored(motion: Sines | Samples) -> Sines | Samples:
    """Give the same base motion with its sign turned."""
    if isinstance(motion, Sines):
        return Sines(tuple(-A for A in motion.A), motion.f, motion.phase)
    return Samples(-motion.u_dd, motion.dt)


def doubled(motion: Sines | Samples) -> Sines | Samples:
    """Give twice the same base motion."""
    if isinstance(motion, Sines):
        return Sines(tuple(2 * A for A in motion.A), motion.f, motion.phase)
    return Samples(2 * motion.u_dd, motion.dt)
