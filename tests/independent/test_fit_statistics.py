"""Fits of drawn twins: identifiable values come back, and the intervals hold the truth."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from twin import CHANNELS, RATE, base_motion, fit_twin, keys, values_of, write_columns

import drysim
from drysim.errors import SolverError

pytestmark = pytest.mark.slow

MASS = 75.0
KNOWN = f"oscillator: {{mass: {MASS}}}\nfriction: {{law: coulomb}}\n"


class Twin(NamedTuple):
    """A drawn scene by its free keys, with its motion."""

    truth: dict[str, float]
    response: drysim.approach.solution.Response


def draw(seed: int, seconds: float) -> Twin:
    """Return a seat of 1 to 3 Hz and its motion on band-limited noise of 1 m/s² RMS."""
    random = np.random.default_rng(seed)
    k_x = MASS * (2.0 * np.pi * random.uniform(1.0, 3.0)) ** 2
    b = 2.0 * random.uniform(0.1, 0.5) * np.sqrt(k_x * MASS)
    F_fk, ratio = MASS * random.uniform(0.1, 0.5), random.uniform(1.0, 3.0)
    truth = {
        "friction.kinetic": F_fk,
        "friction.static_ratio": ratio,
        "oscillator.damping": b,
        "oscillator.stiffness": k_x,
    }
    u_dd = base_motion(seconds, seed + 1000)
    response = drysim.simulate(
        m=MASS, k_x=k_x, b=b, F_fk=F_fk, F_fs=ratio * F_fk, u_dd=u_dd, dt=1.0 / RATE
    )
    return Twin(truth, response)


def fitted(folder: Path, twin: Twin, noise: float, seed: int) -> drysim.FitResult | None:
    """Return the fit of a twin's acceleration, or None if its mass does not slide.

    `noise` is relative to the RMS of the acceleration.
    """
    t, x_dd = twin.response.t, np.array(twin.response.x_dd)
    u_dd = np.array(twin.response.motion.u_dd[:])
    random = np.random.default_rng(seed + 2000)
    x_dd += noise * x_dd.std() * random.normal(size=len(x_dd))
    write_columns(folder / "base.csv", {"t [s]": t, "u_dd [m/s2]": u_dd})
    write_columns(folder / "run.csv", {"t [s]": t, f"x_dd [{CHANNELS['x_dd']}]": x_dd})
    try:
        return fit_twin(folder, KNOWN, keys(*twin.truth))
    except SolverError:
        return None


def test_nine_of_ten_drawn_twins_without_noise_come_back_to_1e_8(tmp_path):
    exact, wrong = 0, []
    for seed in range(40):
        twin = draw(seed, 10.0)
        result = fitted(tmp_path, twin, 0.0, seed)
        if result is None:  # correctly refused: the mass is stuck throughout
            assert not np.array(twin.response.stuck[:-1] == 0).any(), seed
            continue
        found = values_of(result)
        known = [one.key for one in result.parameters if not one.note]
        worst = max((abs(found[key] / twin.truth[key] - 1.0) for key in known), default=0.0)
        exact += worst <= 1e-8
        if worst > 1e-8:
            wrong.append((seed, worst))
    assert exact >= 9 * len(wrong), wrong


def test_intervals_of_noisy_twins_hold_the_truth_in_88_to_100_percent(tmp_path):
    names = ("oscillator.stiffness", "oscillator.damping", "friction.kinetic")
    held: dict[str, list[bool]] = {name: [] for name in names}
    for seed in range(100):
        twin = draw(seed, 10.0)
        result = fitted(tmp_path, twin, 0.02, seed)
        for one in result.parameters if result is not None else ():
            if one.key in names and one.deviation is not None:
                held[one.key].append(one.low <= twin.truth[one.key] <= one.high)
    for name, several in held.items():
        assert len(several) >= 80, name
        assert 0.88 <= np.mean(several) <= 1.0, name
