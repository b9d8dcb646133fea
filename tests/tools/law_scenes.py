"""The scenes that laws beyond Coulomb's are tested on: the paper's oscillator, sines, noise."""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    DynamicLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
)

PAPER = Plant(75.0, 7500.0, 500.0)
REST = State(0.0, 0.0)
STEP = 2.5e-3


def elastic_law(F, k_t, variation=0.0, omega=0.0, phase=0.0):
    """Return an elastic contact with a friction limit."""
    return PiecewiseLaw(F, F, k_t, variation, omega, phase)


def separating_law(F_fk, F_fs, variation=0.0, omega=0.0, phase=0.0, force_record=None):
    """Return Coulomb friction under a normal force that may vanish or is recorded."""
    return PiecewiseLaw(F_fk, F_fs, 0.0, variation, omega, phase, force_record)


def stopped_law(F_fk, F_fs, limit, k_s=0.0, b_s=0.0, e=0.0, wave=(0.0, 0.0, 0.0)):
    """Return Coulomb friction between end stops, rigid without a stiffness."""
    stops = EndStops(StrokeLimits(limit, limit), ((0.0, k_s),) if k_s else (), b_s, e)
    return PiecewiseLaw(F_fk, F_fs, 0.0, *wave, stops=stops)


def sine(a_u: float, f: float, phase: float = 0.0) -> Sines:
    return Sines((math.sqrt(2.0) * a_u,), (f,), (phase,))


def noise(n: int, a_u: float, seed: int = 1) -> Samples:
    """Return band-limited noise with no value in common with any law's constants."""
    spectrum = np.fft.rfft(np.random.default_rng(seed).standard_normal(n))
    f = np.fft.rfftfreq(n, STEP)
    spectrum[(f < 0.5) | (f > 10.0)] = 0.0
    u_dd = np.fft.irfft(spectrum, n)
    return Samples(u_dd * (a_u / np.sqrt(np.mean(u_dd**2))), STEP)


def solved(law, motion, start=REST, duration=None, plant=PAPER):
    return StickSlip().solve(plant, law, motion, start, STEP, duration)


def mirrored(motion: Sines | Samples) -> Sines | Samples:
    """Return the same base motion with its sign turned."""
    if isinstance(motion, Sines):
        return Sines(tuple(-A for A in motion.A), motion.f, motion.phase)
    return Samples(-motion.u_dd, motion.dt)


def doubled(motion: Sines | Samples) -> Sines | Samples:
    """Return twice the same base motion."""
    if isinstance(motion, Sines):
        return Sines(tuple(2 * A for A in motion.A), motion.f, motion.phase)
    return Samples(2 * motion.u_dd, motion.dt)


def halved(motion: Samples) -> Samples:
    """Return the same base motion at half the step: it is linear between samples."""
    n = len(motion.u_dd)
    u_dd = np.interp(np.arange(2 * n - 1) / 2, np.arange(n), motion.u_dd)
    return Samples(u_dd, motion.dt / 2)


def sparse(name: str, seed: int) -> tuple[Plant, DynamicLaw, Samples]:
    """Return a random oscillator under a law, on a few pulses between long silences."""
    random = np.random.default_rng(seed)
    n, dt = int(random.integers(30, 70)), 10 ** random.uniform(-2.5, 0.5)
    m, F = 10 ** random.uniform(-0.5, 2.5), 10 ** random.uniform(-3.0, 2.5)
    omega = 10 ** random.uniform(-1.5, 0.5) / dt
    k_x = m * omega**2
    b = 2.0 * 10 ** random.uniform(-1.0, 1.5) * m * omega
    F_fs = F * random.choice([1.0, 1.1, 1.5, 2.0, 4.0])
    v_s = 10 ** random.uniform(-2.0, 0.0) * F / m * min(dt, 1.0 / omega)
    sigma_0 = 10 ** random.uniform(0.3, 4.0) * k_x
    sigma_1 = random.choice([0.0, 10 ** random.uniform(-2.0, 0.5)]) * math.sqrt(sigma_0 * m)
    bristles = {"sigma_0": sigma_0, "sigma_1": sigma_1, "sigma_2": random.choice([0.0, b])}
    law = {
        "stribeck": DynamicLaw(F, F_fs, STRIBECK, v_s, random.choice([0.7, 1.0, 2.0])),
        "dahl": DynamicLaw(F, F, BRISTLE, sigma_0=sigma_0),
        "lugre": DynamicLaw(F, F_fs, BRISTLE, v_s, **bristles),
        "leuven": DynamicLaw(F, F_fs, LEUVEN, v_s, **bristles)._replace(
            F_h=F_fs * random.choice([1.1, 1.5, 2.0, 5.0]),
            power=random.choice([1.0, 1.5, 2.0, 3.0]),
        ),
    }[name]
    u_dd, pulses = np.zeros(n), int(random.integers(1, 5))
    at = random.choice(np.arange(1, n - 1), pulses, replace=False)
    u_dd[at] = random.choice([-1.0, 1.0], pulses) * random.uniform(0.3, 10.0, pulses) * F / m
    # Python's numbers, as a scenario has: those of numpy warn of an overflow to infinity.
    law = DynamicLaw(*(one.item() if isinstance(one, np.generic) else one for one in law))
    return Plant(m, k_x, b), law, Samples(u_dd, dt)
