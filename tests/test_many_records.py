"""Many records in one call: what each would come to by itself."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.approach.exact import compute_trajectory
from drysim.approach.many_records import BatchResult, can_batch, make_batch, measure_batch
from drysim.core.model import STRIBECK, AnyLaw, CoulombLaw, DynamicLaw, Plant, Samples, State
from drysim.metrics.stroke import (
    count_limit_entries,
    count_upcrossings,
    half_cycle_peaks,
    path_in_window,
)
from drysim.metrics.table import peak_displacement

DT = 2.5e-3
LIMIT = 3e-3


def noise(records: int, samples: int) -> np.ndarray:
    """Return rows of smooth noise of a few hertz."""
    rng = np.random.Generator(np.random.PCG64(9))
    window = np.hanning(41)
    rows = [
        np.convolve(row, window, mode="same") for row in rng.normal(size=(records, samples))
    ]
    return np.array(rows) * 0.2


def measured(
    plant: Plant, law: CoulombLaw, motions: list[Samples], start: State, window: tuple[int, int]
) -> BatchResult:
    """Return what motions come to side by side."""
    given = make_batch(iter(motions), len(motions), window)
    return measure_batch(plant, law, given, start)


def path(u_dd: np.ndarray) -> np.ndarray:
    """Return a displacement to go with an acceleration: any will do."""
    return np.cumsum(np.cumsum(u_dd, axis=1), axis=1) * DT**2


@pytest.mark.parametrize(
    "plant",
    [(75.0, 7500.0, 500.0), (75.0, 0.0, 0.0), (75.0, 7.5e5, 500.0)],
    ids=["paper", "block", "stiff"],
)
@pytest.mark.parametrize("F", [(15.0, 15.0), (30.0, 36.0), (0.0, 0.0), (500.0, 500.0)])
@pytest.mark.parametrize("window", [(0, 2499), (701, 2300), (1024, 2048)])
def test_records_in_one_call_come_to_what_each_comes_to_alone(
    plant: tuple[float, float, float], F: tuple[float, float], window: tuple[int, int]
) -> None:
    u_dd = noise(3, 2500)
    u, scene, start = path(u_dd), (Plant(*plant), CoulombLaw(*F)), State(0.002, -0.01)
    motions = [Samples(u_dd[i], DT, u[i]) for i in range(3)]
    assert can_batch(*scene, DT)
    many = measured(*scene, motions, start, window)
    assert many.found.all()
    begin, end = window[0] * DT, window[1] * DT
    for i, motion in enumerate(motions):
        alone = compute_trajectory(*scene, motion, start, end)
        told = alone.path((0.0, end), None)
        for name, value in alone.totals(begin, end)._asdict().items():
            column = np.broadcast_to(getattr(many.totals, name), 3)
            assert column[i] == pytest.approx(value, rel=1e-12, abs=1e-25), name
        assert many.suffices[i] == pytest.approx(
            peak_displacement(alone, told, (0.0, end)), rel=1e-13
        )
        way = path_in_window(alone, told, (begin, end))
        assert np.abs(many.paths[i]).max() == pytest.approx(np.abs(way).max(), rel=1e-13)
        assert count_upcrossings(many.paths[i]) == count_upcrossings(way)
        assert count_limit_entries(many.paths[i], LIMIT) == count_limit_entries(way, LIMIT)
        assert half_cycle_peaks(many.paths[i]) == pytest.approx(
            half_cycle_peaks(way), rel=1e-12
        )
        assert many.last.x_r[i] == pytest.approx(alone.state(end).x_r, rel=1e-12)
        assert many.first.v_r[i] == pytest.approx(alone.state(begin).v_r, rel=1e-12)
        assert many.events[i] == np.count_nonzero(alone.turning_points.t <= end) - 1
        assert many.closest_decision[i] == pytest.approx(alone.closest_decision)


def test_record_does_not_depend_on_those_beside_it() -> None:
    motions = [Samples(row, DT) for row in noise(21, 900)]
    scene, start = (Plant(75.0, 7500.0, 500.0), CoulombLaw(15.0, 18.0)), State(0.0, 0.0)
    many = measured(*scene, motions, start, (100, 899))
    for i in (0, 7, 8, 20):
        alone = measured(*scene, motions[i : i + 1], start, (100, 899))
        assert [column[i] for column in many.totals[:7]] == [
            column[0] for column in alone.totals[:7]
        ]
        assert many.paths[i].tolist() == alone.paths[0].tolist()


# Plain Python tells of numbers that a kernel takes in silence.
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_record_whose_motion_leaves_the_numbers_spoils_no_other() -> None:
    u_dd = noise(3, 2500)
    scene = Plant(75.0, 7500.0, 500.0), CoulombLaw(15.0, 15.0)
    rest, window = State(0.0, 0.0), (0, 2499)
    good = measured(*scene, [Samples(row, DT) for row in u_dd], rest, window)
    u_dd[1, 1500:] = np.inf
    found = measured(*scene, [Samples(row, DT) for row in u_dd], rest, window)
    assert found.found.tolist() == [True, False, True]
    assert np.array_equal(found.totals.x2[[0, 2]], good.totals.x2[[0, 2]])


@pytest.mark.parametrize(
    ("law", "dt"),
    [
        (CoulombLaw(15.0, 15.0, 0.4, 10.0), DT),
        (DynamicLaw(15.0, 15.0, STRIBECK), DT),
        (CoulombLaw(15.0, 15.0), 1.0),
    ],
    ids=["varying", "dynamic", "coarse"],
)
def test_what_cannot_be_marched_side_by_side_is_told_beforehand(law: AnyLaw, dt: float) -> None:
    assert not can_batch(Plant(75.0, 7500.0, 500.0), law, dt)
