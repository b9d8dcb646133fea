"""Spring contacts over samples: both engines agree to the last bit, also in several calls."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

STEP = 2.5e-3


def march(kernel, u_dd, k_t, cuts=()):
    """March over samples, in several calls where `cuts` says so."""
    listed = kernel.engine == "plain"
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.Slider(30.0, k_t)
    n = len(u_dd)

    def room(size, kind=float):
        empty = np.zeros(size, dtype=kind)
        return empty.tolist() if listed else empty

    x_r, v_r, d = room(n), room(n), room(n, np.int8)
    size = 2 * kernel.events.ROOM
    kinds = (int, float, float, float, float, int)
    trail = kernel.events.Pieces(*(room(size, kind) for kind in kinds))
    log = kernel.events.Log(*(room(size, kind) for kind in (int, float, int, float, float)))
    state, at, used, count = (0.0, 0.0, 0.0, 0), 0, 0, 0
    given = u_dd.tolist() if listed else u_dd
    for end in (*cuts, n - 1):
        at, *state, used, count = kernel.sampled.march_joint(
            plant, law, given, STEP, at, end, *state, x_r, v_r, d, trail, used, log, count
        )
    return np.array(x_r), np.array(v_r), np.array(log.s[:count]), np.array(log.kind[:count])


@pytest.mark.parametrize("k_t", [1e4, 1e6, 1e8])
def test_engines_agree_bit_for_bit(plain, fast, k_t):
    u_dd = np.random.default_rng(4).standard_normal(800)
    for one, other in zip(march(plain, u_dd, k_t), march(fast, u_dd, k_t), strict=True):
        assert np.array_equal(one, other)


def test_march_that_is_handed_over_goes_on_as_if_never_stopped(kernel):
    u_dd = np.random.default_rng(5).standard_normal(900)
    whole, parts = march(kernel, u_dd, 1e5), march(kernel, u_dd, 1e5, cuts=(256, 512))
    assert len(whole[3]) > 30
    for one, other in zip(whole, parts, strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(("c", "w"), [(6.7, 100.0), (400.0, 100.0), (0.0, 9e4), (0.0, 0.0)])
@pytest.mark.parametrize("share", [1e-9, 0.3, 0.999])
def test_way_is_gone_at_the_same_time_by_series_and_by_closed_form(kernel, c, w, share):
    # The series is what every step takes; the closed form is there for what it cannot settle.
    hit, v, a, r, h = kernel.roots, 0.2, -1.0, 3.0, 2.5e-3
    y, _, Y, YY = kernel.oscillator.flow(c, w, h)
    gap = share * (v * y + (a + c * v) * Y + r * YY)
    s = hit.cross(c, w, v, a, r, gap, h)
    y, _, Y, YY = kernel.oscillator.flow(c, w, s)
    assert 0.0 < s < h
    assert v * y + (a + c * v) * Y + r * YY == pytest.approx(gap, rel=1e-14)
    assert hit.cross(c, w, v, a, r, gap / share * 1.01, h) == np.inf


@pytest.mark.parametrize(("c", "root"), [(0.5, 0.5), (0.1, 0.9), (0.99, 0.01)])
@pytest.mark.parametrize("share", [0.3, 0.97])
def test_part_of_a_fine_step_is_the_flow_to_the_last_digits(kernel, c, root, share):
    # Rates are in radians, or decays, of a whole step, of which a fine one holds one in all.
    plant = kernel.model.Plant(1.0, (root / STEP) ** 2, c / STEP)
    steps, s = kernel.oscillator.whole_steps(plant, STEP), share * STEP
    assert steps.fine
    found = kernel.oscillator.part_flow(steps, s)
    with mp.workdps(40):
        half, w, s = mp.mpf(plant.b) / 2, mp.mpf(plant.k_x), mp.mpf(s)
        one, two = (-half + sign * mp.sqrt(half * half - w) for sign in (1, -1))
        y, y_d, Y = (
            mp.re((at(one) - at(two)) / (one - two))
            for at in (
                lambda r: mp.exp(r * s), lambda r: r * mp.exp(r * s),
                lambda r: mp.expm1(r * s) / r,
            )
        )  # fmt: skip
        exact = [float(each) for each in (y, y_d, Y)]
    assert found[:3] == pytest.approx(exact, rel=1e-15, abs=0.0)
