"""Many records in one call: what each would come to by itself."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.approach import exact
from drysim.core.motion import Samples
from drysim.core.plant import Law, Plant, State
from drysim.metrics import greatest
from drysim.peaks import entries, half_cycles, path_of, upcrossings

DT = 2.5e-3
LIMIT = 3e-3


def noise(records: int, samples: int) -> np.ndarray:
    """Give rows of smooth noise of a few hertz."""
    rng = np.random.Generator(np.random.PCG64(9))
    window = np.hanning(41)
    rows = [
        np.convolve(row, window, mode="same") for row in rng.normal(size=(records, samples))
    ]
    return np.array(rows) * 0.2


def path(u_dd: np.ndarray) -> np.ndarray:
    """Give a displacement to go with an acceleration: any will do."""
    return np.cumsum(np.cumsum(u_dd, axis=1), axis=1) * DT**2


@pytest.mark.parametrize(
    "plant",
    [(75.0, 7500.0, 500.0), (75.0, 0.0, 0.0), (75.0, 7.5e5, 500.0), (75.0, 7.5e8, 5e5)],
    ids=["paper", "block", "stiff", "coarse"],
)
@pytest.mark.parametrize("F", [(15.0, 15.0), (30.0, 36.0), (0.0, 0.0), (500.0, 500.0)])
@pytest.mark.parametrize("window", [(0, 2499), (700, 2300), (1024, 2048)])
def test_records_in_one_call_come_to_what_each_comes_to_alone(
    plant: tuple[float, float, float], F: tuple[float, float], window: tuple[int, int]
) -> None:
    u_dd = noise(3, 2500)
    u, scene, start = path(u_dd), (Plant(*plant), Law(*F)), State(0.002, -0.01)
    many = exact.measure_many(*scene, u_dd, DT, start, window, LIMIT, u)
    assert many.found.all()
    begin, end = window[0] * DT, window[1] * DT
    for i in range(3):
        motion = Samples(u_dd[i], DT, u[i])
        alone = exact.follow(*scene, motion, start, end)
        for name, value in alone.totals(begin, end)._asdict().items():
            column = getattr(many.totals, name)
            assert column[i] == pytest.approx(value, rel=1e-12, abs=1e-25), name
        assert many.peak[i] == pytest.approx(greatest(alone, (begin, end)), rel=1e-13)
        assert many.suffices[i] == pytest.approx(greatest(alone, (0.0, end)), rel=1e-13)
        way = path_of(alone, (begin, end))
        assert many.upcrossings[i] == upcrossings(way)
        assert many.entries[i] == entries(way, LIMIT)
        assert many.heights[i] == pytest.approx(half_cycles(way), rel=1e-12)
        assert many.last.x_r[i] == pytest.approx(alone.state(end).x_r, rel=1e-12)
        assert many.first.v_r[i] == pytest.approx(alone.state(begin).v_r, rel=1e-12)
        assert many.events[i] == np.count_nonzero(alone.turns.t <= end) - 1
        assert many.closest[i] == pytest.approx(alone.closest)


# Plain Python tells of numbers that a kernel takes in silence.
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning")
def test_record_whose_motion_leaves_the_numbers_spoils_no_other() -> None:
    u_dd = noise(3, 2500)
    scene = Plant(75.0, 7500.0, 500.0), Law(15.0, 15.0)
    good = exact.measure_many(*scene, u_dd, DT, State(0.0, 0.0), (0, 2499))
    u_dd[1, 1500:] = np.inf
    found = exact.measure_many(*scene, u_dd, DT, State(0.0, 0.0), (0, 2499))
    assert found.found.tolist() == [True, False, True]
    assert np.array_equal(found.totals.x2[[0, 2]], good.totals.x2[[0, 2]])
