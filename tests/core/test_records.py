"""Many records side by side: alike under both engines, and mirrored."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

DT, SAMPLES = 2.5e-3, 600


def answers(
    kernel: SimpleNamespace,
    u_dd: np.ndarray,
    F: tuple[float, float],
    dt: float = DT,
    x_r: float = 0.001,
) -> tuple[np.ndarray, np.ndarray]:
    """Give what the kernel answers for a window from sample 101 on, and the stops."""
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.Law(*F)
    lanes, length = kernel.lanes, 4 * kernel.events.ROOM
    kinds = (np.int64, np.float64, np.int64, np.float64, np.float64)
    rule = kernel.lanes.trapezia(plant.b / plant.m, plant.k_x / plant.m, dt)
    side = kernel.lanes.Side(
        np.zeros(lanes.SIZE), np.zeros(lanes.PLACES * lanes.LANES // lanes.WIDTH),
        np.zeros(kernel.lanes.QUEUE_SIZE), np.zeros(lanes.LANES, dtype=np.int64),
        np.zeros((lanes.LANES, kernel.lanes.KEPT)), np.zeros(lanes.LANES, dtype=np.int64),
        kernel.events.Log(*(np.zeros(length, dtype=kind) for kind in kinds)),
    )  # fmt: skip
    found, turns = np.zeros((len(u_dd), kernel.lanes.FOUND)), np.zeros(u_dd.shape)
    kernel.lanes.measure_records(
        plant, law, kernel.oscillator.steps_of(plant, law, dt), rule, u_dd, 101,
        SAMPLES - 1, kernel.model.State(x_r, 0.0), side, turns, found,
    )  # fmt: skip
    return found, turns


def noise(records: int) -> np.ndarray:
    """Give rows of smooth noise."""
    rows = np.random.Generator(np.random.PCG64(4)).normal(size=(records, SAMPLES))
    window = np.hanning(31)
    return 0.4 * np.array([np.convolve(row, window, mode="same") for row in rows])


@pytest.mark.parametrize("F", [(15.0, 15.0), (30.0, 36.0), (0.0, 0.0)])
@pytest.mark.parametrize("dt", [DT, 4.0 * DT], ids=["short", "in parts"])
def test_engines_agree_on_records_side_by_side(plain, fast, F, dt):
    u_dd = noise(5)
    for one, other in zip(answers(plain, u_dd, F, dt), answers(fast, u_dd, F, dt), strict=True):
        assert other == pytest.approx(one, rel=1e-12, abs=1e-20)


def test_mirrored_records_give_mirrored_stops(kernel):
    u_dd, r = noise(9), kernel.lanes
    found, turns = answers(kernel, u_dd, (20.0, 24.0))
    mirrored, back = answers(kernel, -u_dd, (20.0, 24.0), x_r=-0.001)
    assert (found[:, r.EVENTS] > 0).all()
    assert np.array_equal(turns, -back)
    alike = [*range(r.KEPT), r.BEGIN, r.TURNS]
    assert np.array_equal(found[:, alike], mirrored[:, alike])


@pytest.mark.parametrize(("v", "a", "j"), [(0.78, 1e-4, -16.0), (0.14, -0.99, -311.0)])
def test_root_that_strays_is_told_and_stays_within_its_step(kernel, v, a, j):
    # Its lane is left to the march of one record; far away its numbers had overflowed.
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.Law(15.0, 15.0)
    steps = kernel.oscillator.steps_of(plant, law, DT)
    s, good = kernel.lanes.fall_abreast(kernel.oscillator.series(steps.tail, v, a, j), DT)
    assert not good
    assert 0.0 <= s <= DT
