"""The march against the leap, which finds its events another way: random scenes, no misses."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scenes import log_of, march, waves_of

SAMPLES = 600


def scene(rng: Any) -> tuple[np.ndarray, float, tuple[float, ...], tuple[float, float], Any]:
    """Draw a record, its step, a plant, friction and a start."""
    dt = 10.0 ** rng.uniform(-4.0, -1.7)
    radians = 10.0 ** rng.uniform(-3.0, 0.7)
    omega = radians / dt * rng.choice([1.0, 1.0, 1.0, 0.0])
    damping = 2.0 * rng.choice([0.0, 0.03, 0.3, 1.0, 3.0]) * max(omega, 0.1 * radians / dt)
    width = int(rng.choice([1, 4, 15, 60]))
    rough = np.convolve(
        rng.normal(size=SAMPLES + 2 * width), np.hanning(width + 2), mode="same"
    )
    u_dd = rough[:SAMPLES] / np.std(rough)
    limit = 10.0 ** rng.uniform(-1.5, 0.3)
    friction = (limit, limit * rng.choice([1.0, 1.0, 1.2, 3.0]))
    start = (0.0, 0.0) if rng.random() < 0.5 else (0.0, rng.normal() * dt * width)
    return u_dd, dt, (1.0, omega**2, damping), friction, start


def leap(
    kernel: SimpleNamespace, u_dd: np.ndarray, dt: float, F: Any, plant: Any, start: Any
) -> SimpleNamespace:
    """Leap over samples, step by step; gives x_r, v_r and the events."""
    core_plant, law = kernel.model.Plant(*plant), kernel.model.Law(*F)
    x_r, v_r, d = np.zeros(len(u_dd)), np.zeros(len(u_dd)), np.zeros(len(u_dd), dtype=np.int64)
    mode = kernel.events.first_mode(core_plant, law, *start, u_dd[0])
    x_r[0], v_r[0] = start
    log = log_of(kernel)
    out = kernel.march.leap_steps(
        core_plant, law, waves_of(kernel, [], law), 0, u_dd, dt, 0, len(u_dd) - 1, *start, mode,
        x_r, v_r, d, log, 0, len(log.n),
    )  # fmt: skip
    events = [column[: out[4]].copy() for column in log]
    return SimpleNamespace(
        x_r=x_r, v_r=v_r, kinds=events[2], t=events[0] * dt + events[1], closest=out[5]
    )


def differ(kernel: SimpleNamespace, seed: int) -> tuple[int, float]:
    """Solve one random scene both ways; gives its events and how far the answers differ."""
    u_dd, dt, plant, F, start = scene(np.random.Generator(np.random.PCG64(seed)))
    one = march(kernel, u_dd, dt, F, plant, start)
    other = leap(kernel, u_dd, dt, F, plant, start)
    if not np.array_equal(one.events[2], other.kinds):
        return len(other.t), math.inf
    x, v = np.abs(other.x_r).max() or 1.0, np.abs(other.v_r).max() or 1.0
    return len(other.t), max(
        np.abs(one.x_r - other.x_r).max() / x, np.abs(one.v_r - other.v_r).max() / v
    )


def test_march_finds_what_the_leap_finds(fast: SimpleNamespace) -> None:
    found = [differ(fast, seed) for seed in range(60)]
    assert sum(events for events, _ in found) > 2000
    assert max(error for _, error in found) < 1e-10


@pytest.mark.slow
def test_march_finds_what_the_leap_finds_in_thousands_of_scenes(fast: SimpleNamespace) -> None:
    # Undamped stiff scenes turn some hundred times, and each turn multiplies a rounding.
    assert max(differ(fast, seed)[1] for seed in range(1000, 4000)) < 1e-8
