"""A block of orbits is what each of its scenes is alone, and Newton's slopes are the map's."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import PAPER, log_of, waves_of

FEW = 5000


def solve(kernel: SimpleNamespace, scenes: np.ndarray, capacity: int = 2000) -> np.ndarray:
    """Give the answers of a block of scenes."""
    answers = np.full((len(scenes), kernel.orbit.FOUND), np.nan)
    room = (scenes.shape[1] - kernel.orbit.SINES) // 3 + 1
    past = np.zeros((2, kernel.orbit.MOST_MULTIPLE))
    values = np.zeros(kernel.forcing.STRIDE * room)
    kernel.orbit.solve_orbits(
        scenes, answers, values, *past, FEW, log_of(kernel, capacity), capacity
    )
    return answers


def scene(
    f: float, F: float, rms: float = 0.75, limit: float = math.inf, **more: float
) -> list:
    """Give the columns of the paper's oscillator on a sine."""
    varied = more.get("variation", 0.0), more.get("omega", 0.0), 0.3
    rest = more.get("x_r", 0.0), 0.0
    ratio = more.get("ratio", 1.0)
    return [*PAPER, F, ratio * F, *varied, *rest, 1 / f, limit, math.sqrt(2) * rms, f, 0.0]


def test_block_is_what_its_scenes_are_alone(fast: SimpleNamespace) -> None:
    scenes = np.array([scene(f, F) for F in (0.0, 15.0, 45.0) for f in (0.5, 1.6, 5.0)])
    whole = solve(fast, scenes)
    alone = [solve(fast, scenes[i : i + 1])[0] for i in range(len(scenes))]
    assert np.array_equal(whole, np.array(alone), equal_nan=True)
    assert (whole[:, fast.orbit.STATUS] == fast.orbit.SETTLED).all()


def test_energy_of_every_orbit_balances(kernel: SimpleNamespace) -> None:
    o, s = kernel.orbit, kernel.forcing
    scenes = np.array([scene(f, F, ratio=1.2) for F in (0.0, 15.0, 45.0) for f in (0.6, 3.0)])
    for row, found in zip(scenes, solve(kernel, scenes), strict=True):
        work = -row[s.M] * found[o.POWER]
        lost = row[s.B] * found[o.V2] + row[s.F_FK] * found[o.RUB]
        assert lost == pytest.approx(work, rel=1e-11)


def test_limit_that_varies_takes_one_wave_more(kernel: SimpleNamespace) -> None:
    o = kernel.orbit
    varied = scene(2.0, 30.0, variation=0.4, omega=2 * math.pi * 2.0)
    found = solve(kernel, np.array([varied, scene(2.0, 30.0), varied]))
    assert found[0].tolist() == found[2].tolist()
    assert found[0, o.X2] != found[1, o.X2]


def test_excursions_are_where_the_displacement_says(fast: SimpleNamespace) -> None:
    o = fast.orbit
    free = solve(fast, np.array([scene(1.6, 15.0)]))[0]
    found = solve(fast, np.array([scene(1.6, 15.0, limit=0.8 * free[o.PEAK])]))[0]
    assert (found[o.TIMES], found[o.ENTRIES]) == (2, 2)
    assert 0 < found[o.T_BEYOND] < 1 / 1.6
    assert (free[o.TIMES], free[o.ENTRIES], free[o.T_BEYOND]) == (0, 0, 0)


def test_more_events_than_the_log_holds_are_told_of(kernel: SimpleNamespace) -> None:
    found = solve(kernel, np.array([scene(0.5, 15.0)]), capacity=4)
    assert found[0, kernel.orbit.STATUS] == kernel.orbit.CROWDED


@pytest.mark.parametrize("law", [(15.0, 15.0), (30.0, 38.0), (30.0, 38.0, 0.3, 12.0, 0.2)])
@pytest.mark.parametrize("start", [(0.004, 0.03), (0.0, 0.0), (-0.003, -0.2)])
def test_slopes_of_the_period_map_are_those_of_its_neighbours(
    kernel: SimpleNamespace, law: tuple[float, ...], start: tuple[float, float]
) -> None:
    plant, law = kernel.model.Plant(*PAPER), kernel.model.Law(*law)
    waves, log = waves_of(kernel, [(1.0, 1.1, 0.4), (0.9, 2.2, 1.0)], law), log_of(kernel)
    period, rate, h = 1 / 1.1, 10.0, 1e-7
    d = kernel.orbit.first_direction(plant, law, waves, *start)

    def image(x_r: float, v_r: float) -> np.ndarray:
        found = kernel.orbit.one_period(plant, law, waves, period, x_r, v_r, d, log, len(log.n))
        return np.array([found[0], found[1] / rate, found[3]])

    (x_r, v_r), moving = start, d != 0
    by_x = (image(x_r + h, v_r) - image(x_r - h, v_r)) / (2 * h)
    by_v = (image(x_r, v_r + h * rate) - image(x_r, v_r - h * rate)) / (2 * h)
    events = int(image(x_r, v_r)[2])
    a, b, c, e = kernel.orbit.slopes(plant, law, waves, period, rate, d, events, log)
    assert (a, c) == pytest.approx(by_x[:2], abs=1e-6)
    if moving and v_r:
        assert (b, e) == pytest.approx(by_v[:2], abs=1e-6)
