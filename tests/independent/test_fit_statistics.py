"""Fits of drawn twins: identifiable values come back, and the intervals hold the truth."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from twin import CHANNELS, RATE, base_motion, fit_twin, keys, values_of, write_columns

import drysim
from drysim.errors import SolverError

pytestmark = [pytest.mark.slow, pytest.mark.by_hand]

MASS = 75.0
KNOWN = f"oscillator: {{mass: {MASS}}}\nfriction: {{law: coulomb}}\n"


class Twin(NamedTuple):
    """A drawn scene by its free keys, with its motion."""

    truth: dict[str, float]
    response: drysim.approach.solution.Response


def draw(seed: int, seconds: float, largest_ratio: float = 3.0) -> Twin:
    """Return a seat of 1 to 3 Hz and its motion on band-limited noise of 1 m/s² RMS."""
    random = np.random.default_rng(seed)
    k_x = MASS * (2.0 * np.pi * random.uniform(1.0, 3.0)) ** 2
    b = 2.0 * random.uniform(0.1, 0.5) * np.sqrt(k_x * MASS)
    F_fk, ratio = MASS * random.uniform(0.1, 0.5), random.uniform(1.0, largest_ratio)
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


def fitted(
    folder: Path, twin: Twin, noise: float, seed: int, base_noise: float = 0.0
) -> drysim.FitResult | None:
    """Return the fit of a twin's acceleration, or None if its mass does not slide.

    `noise` and `base_noise` are relative to the RMS of both accelerations.
    """
    t, x_dd = twin.response.t, np.array(twin.response.x_dd)
    u_dd = np.array(twin.response.motion.u_dd[:])
    random = np.random.default_rng(seed + 2000)
    x_dd += noise * x_dd.std() * random.normal(size=len(x_dd))
    u_dd += base_noise * u_dd.std() * random.normal(size=len(u_dd))
    write_columns(folder / "base.csv", {"t [s]": t, "u_dd [m/s2]": u_dd})
    write_columns(folder / "run.csv", {"t [s]": t, f"x_dd [{CHANNELS['x_dd']}]": x_dd})
    try:
        return fit_twin(folder, KNOWN, keys(*twin.truth))
    except SolverError:
        return None


BASE_NOISE, RESPONSE_NOISE = 0.013, 0.02
"""Noise of base and response, relative to the RMS of each."""


def test_intervals_of_300_twins_with_a_noisy_base_hold_the_truth_in_87_to_98_percent(tmp_path):
    # By chance 91 to 98.3 % of 300 intervals hold it, with a probability of 99.7 %. The static
    # ratio decides over the order of events, and its interval may be somewhat too narrow.
    held: dict[str, list[bool]] = {}
    for seed in range(300):
        twin = draw(seed, 10.0, 2.5)
        result = fitted(tmp_path, twin, RESPONSE_NOISE, seed, BASE_NOISE)
        for parameter in result.parameters if result is not None else ():
            if parameter.key in twin.truth and not parameter.note:
                low, high, value = (
                    parameter.profile_low,
                    parameter.profile_high,
                    twin.truth[parameter.key],
                )
                holds = (low is None or low <= value) and (high is None or value <= high)
                held.setdefault(parameter.key, []).append(holds)
    shares = {key: (len(several), float(np.mean(several))) for key, several in held.items()}
    for key, (count, share) in shares.items():
        least = 0.87 if key == "friction.static_ratio" else 0.91
        assert count >= 250, shares
        assert least <= share <= 0.985, shares


# Records that begin in mid-motion

CUT_SECONDS, MEASURED = 4.0, (("x_r",), ("x_dd", "x_r"), ("v_r",), ("x_dd",))
"""Length of a cut record, and the channels of one after another."""


def cut_twin(seed: int) -> tuple[dict[str, float], dict[str, np.ndarray], tuple[str, ...]]:
    """Return the truth, the columns and the channels of a record cut out of a motion."""
    random = np.random.default_rng(seed)
    k_x = MASS * (2.0 * np.pi * random.uniform(1.0, 3.0)) ** 2
    b = 2.0 * random.uniform(0.1, 0.5) * np.sqrt(k_x * MASS)
    F_fk, dt = MASS * random.uniform(0.1, 0.4), 2.0 / RATE
    u_dd = base_motion(CUT_SECONDS + 4.0, seed + 1000)[::2]
    motion = drysim.simulate(m=MASS, k_x=k_x, b=b, F_fk=F_fk, u_dd=u_dd, dt=dt)
    begin = round(random.uniform(1.0, 4.0) / dt)
    part = slice(begin, begin + round(CUT_SECONDS / dt) + 1)
    columns = {"u_dd": np.array(u_dd[part])}
    for name in ("x_dd", "x_r", "v_r"):
        values = np.array(getattr(motion, name))[part]
        columns[name] = values + 0.02 * values.std() * random.normal(size=len(values))
    truth = {
        "oscillator.stiffness": k_x,
        "oscillator.damping": b,
        "friction.kinetic": F_fk,
        "start.x_r": float(motion.x_r[begin]),
        "start.v_r": float(motion.v_r[begin]),
    }
    return truth, columns, MEASURED[seed % len(MEASURED)]


def held_by_intervals(folder: Path, seed: int, start: str = "") -> dict[str, bool]:
    """Return whether each interval of the fit of a cut record holds the truth."""
    truth, columns, names = cut_twin(seed)
    t = np.arange(len(columns["u_dd"])) * 2.0 / RATE
    write_columns(folder / "base.csv", {"t [s]": t, "u_dd [m/s2]": columns["u_dd"]})
    channels = {f"{name} [{CHANNELS[name]}]": columns[name] for name in names}
    write_columns(folder / "run.csv", {"t [s]": t} | channels)
    known = (
        f"oscillator: {{mass: {MASS}}}\nfriction: {{law: coulomb, static_ratio: 1}}\n{start}"
    )
    measured = ", ".join(f"{name}: {name}" for name in names)
    free = keys(*(key for key in truth if not key.startswith("start.")))
    result = fit_twin(folder, known, free, measured, "  hold_out: 0\n")
    return {
        one.key: (one.profile_low is None or one.profile_low <= truth[one.key])
        and (one.profile_high is None or truth[one.key] <= one.profile_high)
        for one in result.parameters
        if not one.note
    }


def test_intervals_of_100_cut_records_hold_the_truth_in_93_to_97_percent(tmp_path):
    # Of 480 independent intervals of 95 %, 93 to 97 % hold it with a probability of 95 %, and
    # of 100 at least 87 % with one of 99.9 %.
    held: dict[str, list[bool]] = {}
    for seed in range(100):
        for key, holds in held_by_intervals(tmp_path, seed).items():
            held.setdefault(key, []).append(holds)
    shares = {key: (len(several), float(np.mean(several))) for key, several in held.items()}
    every = [holds for several in held.values() for holds in several]
    assert len(every) >= 480, shares
    assert 0.93 <= np.mean(every) <= 0.97, shares
    assert all(share >= 0.87 for _, share in shares.values()), shares


def test_intervals_of_cut_records_miss_the_truth_if_the_start_is_said_to_be_rest(tmp_path):
    start = "start: {x_r: 0, v_r: 0}\n"
    held = [
        one for seed in range(12) for one in held_by_intervals(tmp_path, seed, start).values()
    ]
    assert len(held) >= 12
    assert np.mean(held) < 0.8


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
