"""Multipliers of drawn periodic orbits, against differences of marches from moved states."""

from __future__ import annotations

from math import inf, pi

import numpy as np

from drysim.approach.stick_slip import ExactApproach
from drysim.core import orbit as o
from drysim.core.model import CoulombLaw, Plant, Sines, State
from drysim.core.status import Status
from drysim.orbits.coulomb import solve_orbits

STEPS = (1e-4, 1e-5, 1e-6, 1e-7)
"""Changes of the state, relative to its size. Next to an event that is about to be born or lost
only small ones see the same events; large ones are less disturbed by rounding."""

ORBITS = 500


def drawn_scene(rng: np.random.Generator) -> tuple[Plant, CoulombLaw, Sines]:
    """Return an oscillator with m = k_x = 1 under one sine, or two of them."""
    omega = rng.uniform(0.15, 4.0)
    zeta = 10.0 ** rng.uniform(-2.0, 0.0)
    F_fk = rng.uniform(0.0, 0.9) if rng.random() < 0.9 else 0.0
    F_fs = F_fk * (rng.uniform(1.0, 1.6) if rng.random() < 0.6 else 1.0)
    if rng.random() < 0.1:  # where one sine has unsymmetric orbits (Shaw 1986)
        omega, zeta, F_fk, F_fs = rng.uniform((0.45, 0.03, 0.1, 0.25), (0.55, 0.06, 0.24, 0.45))
    count = 1 if rng.random() < 0.6 else 2
    f = omega / (2.0 * pi) * np.arange(1, count + 1)
    A = np.array([1.0, rng.uniform(0.1, 1.0)])[:count]
    phase = rng.uniform(0.0, 2.0 * pi, count)
    motion = Sines(tuple(A.tolist()), tuple(f.tolist()), tuple(phase.tolist()))
    return Plant(1.0, 1.0, 2.0 * zeta), CoulombLaw(F_fk, F_fs), motion


def differences(
    plant: Plant, law: CoulombLaw, motion: Sines, state: np.ndarray, length: float, step: float
) -> np.ndarray:
    """Return the Jacobian of the map over a time by central differences.

    Of a mass that sticks at the beginning only x_r is changed: between F_fk and F_fs any
    velocity would end the sticking.
    """
    size = np.abs(state).max() * step
    columns = []
    for change in size * np.eye(2)[: 1 if state[1] == 0.0 else 2]:
        ends = [
            ExactApproach().trajectory(plant, law, motion, State(*begin), length).state(length)
            for begin in ((state + change).tolist(), (state - change).tolist())
        ]
        columns.append([(ends[0].x_r - ends[1].x_r), (ends[0].v_r - ends[1].v_r)])
    columns += [[0.0, 0.0]] * (2 - len(columns))
    return np.array(columns).T / (2.0 * size)


def test_multipliers_of_drawn_orbits_are_those_of_differences():
    rng = np.random.default_rng(7)
    kinds = {"stops": 0, "sliding": 0, "unsymmetric": 0, "several periods": 0, "static": 0}
    checked, errors = 0, []
    while checked < ORBITS:
        plant, law, motion = drawn_scene(rng)
        period = 1.0 / motion.f[0]
        sines = [column for sine in zip(*motion, strict=True) for column in sine]
        start = rng.uniform(-1.0, 1.0, 2)
        row = [*plant, *law, *start, period, inf, inf, *sines]
        (found,) = solve_orbits(np.array([row]))
        if found[o.STATUS] != Status.OK or found[o.SLIDING_DISTANCE] == 0.0:
            continue
        checked += 1
        kinds["stops" if found[o.STOPS] else "sliding"] += 1
        kinds["unsymmetric"] += bool(len(motion.A) == 1 and found[o.ASYMMETRY] > 1e-6)
        kinds["several periods"] += bool(found[o.MULTIPLE] > 1.0)
        kinds["static"] += law.F_fs > law.F_fk
        state = found[[o.X_BEGIN, o.V_BEGIN]]
        length = float(found[o.MULTIPLE]) * period
        known = np.array([found[o.TRACE], found[o.DETERMINANT]])
        misses = []
        for step in STEPS:
            jacobian = differences(plant, law, motion, state, length, step)
            other = np.array([np.trace(jacobian), np.linalg.det(jacobian)])
            misses.append(np.abs(other - known).max())
        errors.append(min(misses))
    assert min(kinds.values()) > 0, kinds
    assert max(errors) < 1e-7, np.sort(errors)[-20:]
