"""A long motion is solved and written part by part: the same, to the last bit, as the whole."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.approach import coulomb as marching
from drysim.approach import scene
from drysim.approach import solution as responses
from drysim.approach.stick_slip import StickSlip, Viscous
from drysim.core.model import BLOCK, Law, Plant, Samples, Sines, State
from drysim.core.sampled import STRETCH
from drysim.metrics import measure
from drysim.plots import response
from drysim.plots.response import excursions

PLANT, START = Plant(75.0, 7500.0, 500.0), State(0.001, 0.02)
LAWS = {
    "friction": Law(45.0, 54.0),
    "variation": Law(30.0, 40.0, 0.5, 20.0, 0.3),
    "none": Law(0.0, 0.0),
}
STEP, LENGTH, SIZE = 2.5e-3, 6001, STRETCH


@pytest.fixture
def motion():
    """Give a random base motion."""
    random = np.random.Generator(np.random.PCG64(3))
    return Samples(random.standard_normal(LENGTH), STEP)


@pytest.fixture
def small(monkeypatch):
    """Make everything long: blocks of a few samples."""
    for module in (marching, responses):
        monkeypatch.setattr(module, "KEPT", 0)
        monkeypatch.setattr(module, "BLOCK", SIZE)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("duration", [None, 14.0, 13.9987])
def test_parts_of_a_march_are_those_of_the_whole(law, duration, motion, small):
    scene = (PLANT, LAWS[law], motion, START, STEP, duration)
    whole, parted = StickSlip().solve(*scene), StickSlip().by_parts(*scene)
    assert len(parted.track.march.marks) > 20 > len(whole.track.march.marks) == 1
    for name in ("t", "kind", "x_r", "F_L"):
        assert np.array_equal(getattr(parted.events, name), getattr(whole.events, name))
    for part in parted.parts():
        for one, other in zip(parted.points(part), whole.points(part), strict=True):
            assert np.array_equal(one, other)
        assert np.array_equal(parted.acceleration(part), whole.acceleration(part))
        assert np.array_equal(parted.friction(part), whole.friction(part))
    assert responses.WHOLE_RUN not in parted._kept
    assert np.array_equal(parted.x_r, whole.x_r)
    assert np.array_equal(parted.d, whole.d)


def test_part_without_points_is_not_taken_for_the_whole(motion, small):
    response = StickSlip().by_parts(PLANT, LAWS["friction"], motion, START, STEP, None)
    assert len(response.points(slice(0, 0)).x_r) == 0
    assert len(response.x_r) == len(response) == LENGTH


@pytest.mark.parametrize("law", LAWS)
def test_metrics_of_parts_are_those_of_the_whole(law, motion, small):
    scene = (PLANT, LAWS[law], motion, START, STEP, 9.7)
    window = (0.7003, 9.7)
    whole, parted = (
        measure(response.track, window, 0.004)
        for response in (StickSlip().solve(*scene), StickSlip().by_parts(*scene))
    )
    for name, value in whole.items():
        if name == "energy_residual":
            assert max(value, parted[name]) < 1e-12
        elif value is None:
            assert parted[name] is None
        else:
            assert parted[name] == pytest.approx(value, rel=1e-12, abs=0), name


@pytest.mark.parametrize("law", LAWS)
def test_parts_under_sines_are_those_of_the_whole(law, small):
    sines = Sines((1.0, 0.7), (1.3, 4.1), (0.0, 0.4))
    parted = StickSlip().by_parts(PLANT, LAWS[law], sines, START, STEP, 14.0)
    parts = [parted.points(part) for part in parted.parts()]
    whole = parted.grid.part(0, len(parted))
    assert len(parts) > 20
    for number in range(3):
        joined = np.concatenate([points[number] for points in parts])
        assert np.array_equal(joined, whole[number])
    base = np.concatenate([parted.base(part) for part in parted.parts()])
    assert np.array_equal(base, parted.grid.base(0, len(parted)))


def test_blocks_begin_where_a_march_may_be_handed_over():
    assert BLOCK % STRETCH == 0
    assert scene.PER_CALL % STRETCH == 0


def test_any_stretch_of_a_march_can_be_had(motion, small):
    parted = StickSlip().by_parts(PLANT, LAWS["friction"], motion, START, STEP)
    x_r = StickSlip().solve(PLANT, LAWS["friction"], motion, START, STEP).x_r
    for first, last in [
        (0, 1),
        (5, 100),
        (SIZE - 1, SIZE + 1),
        (100, 1000),
        (LENGTH - 10, LENGTH),
    ]:
        assert np.array_equal(parted.points(slice(first, last)).x_r, x_r[first:last])


def test_viscous_by_parts_has_nothing_stuck(motion, small):
    parted = Viscous().by_parts(PLANT, LAWS["friction"], motion, State(0.0, 0.0), STEP)
    assert all((parted.points(part).d == 1).all() for part in parted.parts())


def test_excursion_across_parts_is_one(motion, small):
    parted = StickSlip().by_parts(PLANT, LAWS["friction"], motion, START, STEP)
    whole = StickSlip().solve(PLANT, LAWS["friction"], motion, START, STEP)
    limit = 0.3 * response.greatest(whole, "x_r").value
    over = np.abs(whole.x_r) >= limit
    begins = np.diff(over, prepend=False) & over
    assert len(excursions(parted, limit)) == np.count_nonzero(begins)
    assert response.greatest(parted, "x_r", 70) == (
        np.abs(whole.x_r[70:]).max(), 70 + np.abs(whole.x_r[70:]).argmax()
    )  # fmt: skip
