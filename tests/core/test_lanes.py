"""Many records side by side: alike under both engines, and mirrored."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from drysim.core.trajectory import TWELVE_NODES, TWELVE_WEIGHTS

# Many records side by side: alike under both engines, and mirrored.


DT, SAMPLES = 2.5e-3, 600


def answers(
    kernel: SimpleNamespace,
    u_dd: np.ndarray,
    F: tuple[float, float],
    dt: float = DT,
    x_r: float = 0.001,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the results of the kernel for a window from sample 101 on, and the stops."""
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.CoulombLaw(*F)
    lanes, length = kernel.lanes, 4 * kernel.events.MAX_EVENTS_PER_STEP
    kinds = (np.int64, np.float64, np.int64, np.float64, np.float64)
    rule = kernel.lanes.make_end_forms(plant.b / plant.m, plant.k_x / plant.m, dt)
    buffers = kernel.lanes.LaneBuffers(
        np.zeros(lanes.LANES_SIZE),
        np.zeros(lanes.READ_BUFFER_SIZE * lanes.LANES // lanes.WIDTH),
        np.zeros(kernel.lanes.QUEUE_SIZE), np.zeros(lanes.LANES, dtype=np.int64),
        np.zeros((lanes.LANES, lanes.RESULT_COUNT)), np.zeros(lanes.LANES, dtype=np.int64),
        kernel.events.EventLog(*(np.zeros(length, dtype=kind) for kind in kinds)),
    )  # fmt: skip
    found, stops = np.zeros((len(u_dd), kernel.lanes.ANSWER_COLUMNS)), np.zeros(u_dd.shape)
    kernel.lanes.measure_records(
        plant, law, kernel.oscillator.slip_steps(plant, law, dt), rule, u_dd, 101,
        SAMPLES - 1, kernel.model.State(x_r, 0.0), buffers, stops, found,
    )  # fmt: skip
    return found, stops


def noise(records: int) -> np.ndarray:
    """Return rows of smooth noise."""
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
    found, stops = answers(kernel, u_dd, (20.0, 24.0))
    mirrored, mirrored_stops = answers(kernel, -u_dd, (20.0, 24.0), x_r=-0.001)
    assert (found[:, r.EVENTS] > 0).all()
    assert np.array_equal(stops, -mirrored_stops)
    alike = [*range(r.RESULT_COUNT), r.BEGIN, r.STOP_COUNT]
    assert np.array_equal(found[:, alike], mirrored[:, alike])


@pytest.mark.parametrize(("v", "a", "j"), [(0.78, 1e-4, -16.0), (0.14, -0.99, -311.0)])
def test_root_that_diverges_is_reported_and_stays_within_its_step(kernel, v, a, j):
    # Its lane is left to the march of one record; far away its numbers had overflowed.
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.CoulombLaw(15.0, 15.0)
    steps = kernel.oscillator.slip_steps(plant, law, DT)
    s, good = kernel.lanes.stop_time(
        kernel.oscillator.velocity_series(steps.factors, v, a, j), DT
    )
    assert not good
    assert 0.0 <= s <= DT


# The trapezoidal rule with end corrections is exact for a step, in both engines.


@pytest.mark.parametrize(
    ("c", "w"),
    [(6.7, 100.0), (0.0, 0.0), (0.0, 1.6e5), (390.0, 0.0), (190.0, 4e4)],
    ids=["paper", "block", "undamped", "no spring", "as long as may be"],
)
@pytest.mark.parametrize("d", [1.0, 0.0])
def test_trapezoidal_rule_with_end_corrections_is_exact_for_a_step(kernel, c, w, d):
    h, f, u, slope = 2.5e-3, 0.3, -0.7, 11.0
    x, v = (0.004, 0.02) if d else (0.004, 0.0)
    rule, t = kernel.lanes.make_end_forms(c, w, h), np.array(TWELVE_NODES) * h

    def state(s):
        if not d:
            return x, 0.0
        y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
        push = u + d * f
        return (
            x * (1.0 - w * Y) + v * y - push * Y - slope * YY,
            v * y_d - (push + w * x) * y - slope * Y,
        )

    def felt(x, v):
        return c * v + (w * x + d * f)

    between = np.array([state(s) for s in t])
    u_dd = u + slope * t
    x_dd = felt(*between.T) if d else u_dd
    there, found = state(h), np.zeros(kernel.lanes.INTEGRALS)
    for at, base, side in (((x, v), u, -1.0), (there, u + slope * h, 1.0)):
        what = rule, d, at[0], felt(*at), base, at[1]
        found += kernel.lanes.half_sample(*what)
        found += side * np.array(kernel.lanes.end_corrections(*what, slope))
    heights = [
        between[:, 0] ** 2, between[:, 1] ** 2, x_dd**2, u_dd * between[:, 1],
        d * between[:, 1], np.full(len(t), float(d == 0.0)), u_dd**2,
    ]  # fmt: skip
    assert found == pytest.approx(h * np.array(heights) @ TWELVE_WEIGHTS, rel=2e-14, abs=1e-22)
