"""Random scenes of every law under periodic excitation, and how their motion repeats."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    AnyLaw,
    AnyState,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
    StrokeLimits,
)
from drysim.orbits.return_map import PeriodicSystem
from drysim.orbits.search import march_period

KINDS = (
    "coulomb", "load", "lift-off", "friction by direction", "damper by direction", "stribeck",
    "dahl", "lugre", "leuven", "jenkins", "petrov", "bumpers", "one bumper", "rigid stops",
)  # fmt: skip

M, K_X = 75.0, 7500.0


class SteadyScene(NamedTuple):
    """A periodic scene, and a start."""

    scene: PeriodicSystem
    start: AnyState


def draw_steady_scene(kind: str, seed: int) -> SteadyScene:
    """Return a random scene of a kind, under one sine or under two with a common period."""
    draw = np.random.default_rng([KINDS.index(kind), seed])
    omega_0 = math.sqrt(K_X / M)
    b = 2.0 * math.exp(draw.uniform(math.log(0.01), math.log(0.3))) * math.sqrt(K_X * M)
    f = round(math.exp(draw.uniform(math.log(0.3), math.log(3.2))) * omega_0 / math.tau, 3)
    A = draw.uniform(0.3, 6.0)
    F, ratio = M * A * draw.uniform(0.02, 0.6), float(draw.choice([1.0, 1.2, 2.0]))
    phase, static = draw.uniform(0.0, 6.0), F * ratio
    omega, swing = math.tau * f, A / (math.tau * f) ** 2
    k_t, v_s = K_X * draw.uniform(0.5, 8.0), 0.3 * A / omega * draw.uniform(0.05, 1.0)
    sigma = {"sigma_0": k_t, "sigma_1": draw.uniform(0.0, 0.3) * b}
    limit = swing * draw.uniform(0.2, 1.2)
    stage = ((0.0, K_X * draw.uniform(0.3, 10.0)),)
    law: AnyLaw
    match kind:
        case "coulomb":
            law = CoulombLaw(F, static)
        case "load":
            law = CoulombLaw(F, static, draw.uniform(0.1, 0.95), omega, phase)
        case "lift-off":
            law = PiecewiseLaw(F, static, 0.0, draw.uniform(1.0, 2.0), omega, phase)
        case "friction by direction":
            less = draw.uniform(0.3, 0.9)
            law = PiecewiseLaw(F, static, compression=(less * F, less * static))
        case "damper by direction":
            F *= float(draw.choice([0.0, 1.0]))
            law = PiecewiseLaw(F, F * ratio, damping=(b, b * draw.uniform(0.2, 0.8)))
        case "stribeck":
            law = DynamicLaw(F, F * 1.2, STRIBECK, v_s)
        case "dahl":
            law = DynamicLaw(F, F, BRISTLE, sigma_0=k_t)
        case "lugre":
            law = DynamicLaw(F, F * 1.2, BRISTLE, v_s, **sigma)
        case "leuven":
            law = DynamicLaw(F, F * 1.2, LEUVEN, v_s, F_h=1.8 * F, **sigma)
        case "jenkins":
            law = PiecewiseLaw(F, F, k_t)
        case "petrov":
            law = PiecewiseLaw(F, F, k_t, draw.uniform(0.1, 1.6), omega, phase)
        case "bumpers":
            law = PiecewiseLaw(F, static, stops=EndStops(StrokeLimits(limit, limit), stage))
        case "one bumper":
            law = PiecewiseLaw(F, F, stops=EndStops(StrokeLimits(limit, 1.0), stage))
        case "rigid stops":
            stops = EndStops(StrokeLimits(limit, limit), e=draw.uniform(0.0, 0.8))
            law = PiecewiseLaw(F, static, stops=stops)
    motion, period = Sines((A,), (f,), (0.0,)), 1.0 / f
    if draw.random() < 0.15 and kind not in ("load", "lift-off", "petrov"):
        motion, period = Sines((A, 0.6 * A), (f, 1.5 * f), (0.0, phase)), 2.0 / f
    has_contact = isinstance(law, DynamicLaw) or law.is_elastic
    start = ContactState(0.0, 0.0, 0.0) if has_contact else State(0.0, 0.0)
    return SteadyScene(PeriodicSystem(Plant(M, K_X, b), law, motion, period), start)


def changes_after(
    scene: PeriodicSystem, state: AnyState, periods: int, most: int
) -> np.ndarray:
    """Return how far a motion is from itself 1, 2, ..., `most` periods earlier, scaled [-].

    It is marched for so many periods from a state, and as many more as are compared.
    """
    plant, law, motion, period = scene
    ends, peak = [], 0.0
    for n in range(periods + most + 1):
        trajectory = march_period(plant, law, motion, state, period)
        state = trajectory.state(period)
        if n >= periods:
            ends.append(state[:3])
            peak = max(peak, float(np.abs(trajectory.path.x_r).max()), abs(state.x_r))
    rows = np.array(ends)[::-1] / (peak or 1.0)
    rows[:, 1] *= period / math.tau
    return np.asarray(np.abs(rows[1:] - rows[0]).max(axis=1))


def true_period(changes: np.ndarray, closed: float) -> int:
    """Return the least number of periods after which a motion repeats; 0 if there is none."""
    found = np.flatnonzero(changes <= closed)
    return int(found[0]) + 1 if found.size else 0
