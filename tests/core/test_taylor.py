"""Motions under dynamic laws: the plain engine and the compiled one go the same way."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scenes import PAPER, log_of, waves_of

STEP, COUNT = 2.5e-3, 400
FEW = 4
"""Turns that make a short memory full within the noise."""

BRISTLES = {
    "F_fk": 45.0, "F_fs": 54.0, "v_s": 5e-3, "sigma_0": 1e5, "sigma_1": 300.0, "sigma_2": 0.4,
}  # fmt: skip
LAWS: dict[str, dict[str, Any]] = {
    "stribeck": {"kind": "STRIBECK", "F_fk": 15.0, "F_fs": 24.0, "v_s": 2e-2},
    "stribeck-1.5": {
        "kind": "STRIBECK", "F_fk": 15.0, "F_fs": 24.0, "v_s": 2e-2, "exponent": 1.5,
    },
    "dahl": {"kind": "BRISTLE", "F_fk": 45.0, "F_fs": 45.0, "sigma_0": 1e5},
    "lugre": {"kind": "BRISTLE", **BRISTLES},
    "stiff lugre": {"kind": "BRISTLE", **BRISTLES, "sigma_0": 1e8},
    "leuven": {"kind": "LEUVEN", **BRISTLES, "F_h": 80.0},
    "leuven-2": {"kind": "LEUVEN", **BRISTLES, "F_h": 80.0, "power": 2.0},
    "leuven-0.7": {"kind": "LEUVEN", **BRISTLES, "F_h": 80.0, "power": 0.7},
    "forgetful leuven": {
        "kind": "LEUVEN", **BRISTLES, "F_h": 80.0, "sigma_1": 0.0, "depth": FEW,
    },
}  # fmt: skip
"""Words of a `DynamicLaw`, whose kinds each engine has of its own."""


def noise(count: int) -> np.ndarray:
    """Return smooth noise [m/s²]."""
    rough = np.random.default_rng(5).normal(size=count + 40)
    return 1.5 * np.convolve(rough, np.hanning(9) / 3.0, mode="valid")[:count]


def followed(kernel: SimpleNamespace, words: dict[str, Any], sines: bool) -> SimpleNamespace:
    """Follow a motion from rest by one engine; gives its steps, events, end and memory."""
    plant = kernel.model.Plant(*PAPER)
    kind = getattr(kernel.model, words["kind"])
    law = kernel.model.DynamicLaw(**{**words, "kind": kind})
    waves = waves_of(
        kernel,
        [(1.4, 1.6, 0.3), (0.6, 3.9, 0.0)] if sines else [],
        kernel.model.CoulombLaw(0.0, 0.0),
    )
    u_dd, dt, end = (np.zeros(2), STEP * COUNT, 0) if sines else (noise(COUNT), STEP, COUNT - 2)
    series, segments = work(kernel, law), segments_of(kernel)
    kernel.taylor.set_forcing(series, waves, u_dd[0], 0.0, 0.0)
    d = kernel.taylor.motion_direction_at(plant, law, series, 0.0, 0.0, 0.0)
    if kind == kernel.model.LEUVEN:
        kernel.dynamic_friction.update_branch(law, series, d or 1, 0.0, 0.0)
    log, scene = log_of(kernel), kernel.forcing.Scene(plant, law, waves, u_dd, dt)
    start = kernel.taylor.SeriesState(0, 0.0, 0.0, 0.0, 0.0, d, 0, 0, math.inf)
    state = kernel.taylor.march_taylor(scene, (end, dt), start, series, segments, log)
    return SimpleNamespace(
        state=tuple(state),
        segments=[column[: state.used] for column in segments[:7]],
        log=[column[: state.events] for column in log],
        reversals=series.reversals[: series.branch[kernel.dynamic_friction.COUNT]],
    )


def work(kernel: SimpleNamespace, law: Any) -> Any:
    """Return the work space of a kernel, for a scale of velocity of 0.1 m/s."""
    series = kernel.taylor
    sizes = {"scale": 1, "slope": 2, "reversals": law.depth}
    rows = {
        name: np.zeros(sizes.get(name, series.ORDER + 2))
        for name in series.TaylorSeries._fields
    }
    rows["scale"][0] = 0.1
    return series.TaylorSeries(**rows | {"branch": np.zeros(3, dtype=np.int64)})


def segments_of(kernel: SimpleNamespace, length: int = 20_000) -> Any:
    """Return empty segments of Taylor series."""
    whole = ("n", "d", "terms")
    return kernel.events.SeriesSegments(
        *(np.zeros(length, np.int64 if name in whole else float)
          for name in kernel.events.SeriesSegments._fields)
    )  # fmt: skip


@pytest.mark.parametrize("sines", [True, False], ids=["sines", "samples"])
@pytest.mark.parametrize("words", LAWS.values(), ids=LAWS)
def test_engines_agree_step_by_step_and_remember_the_same(plain, fast, words, sines):
    one, other = (followed(kernel, words, sines) for kernel in (plain, fast))
    assert one.state == other.state
    for column, twin in zip(
        [*one.segments, *one.log], [*other.segments, *other.log], strict=True
    ):
        assert np.array_equal(column, twin)
    assert np.array_equal(one.reversals, other.reversals)


def test_bristles_at_their_limit_to_the_last_bit_keep_their_way(kernel):
    law = kernel.model.DynamicLaw(
        32.0, 32.0, kernel.model.LEUVEN, sigma_0=1024.0, F_h=64.0, v_s=1.0
    )
    series, z = work(kernel, law), 32.0 / 1024.0
    for z_now, way in ((0.5 * z, 1), (z, 1), (2.0 * z, -1)):
        kernel.dynamic_friction.update_branch(law, series, 1, 0.1, z_now)
        assert series.branch[kernel.dynamic_friction.DIRECTION] == way


def test_two_turns_whose_neighbours_are_most_like_them_are_forgotten(kernel):
    law = kernel.model.DynamicLaw(
        32.0, 32.0, kernel.model.LEUVEN, sigma_0=1024.0, F_h=64.0, v_s=1.0
    )
    series, turns = work(kernel, law), [10.0, -9.0, 9.9, -3.0, 2.0, -2.9]
    series.reversals[:6], series.branch[kernel.dynamic_friction.COUNT] = turns, 6
    kernel.dynamic_friction.drop_smallest_loop(series)
    # Without -9 and 9.9 the force errs by 0.1 and 6; any other two would let it err by more.
    assert series.branch[kernel.dynamic_friction.COUNT] == 4
    assert series.reversals[:4].tolist() == [10.0, -3.0, 2.0, -2.9]


def test_series_that_holds_for_no_time_has_no_zero_in_it(kernel):
    # One had ended in a division by zero: bristles and a force at the end of double precision.
    series = kernel.compile.as_engine_array(np.array([0.5, -1.0, 0.3, 0.1]))
    assert kernel.roots.first_series_root(series, 3, 0.0) == np.inf
