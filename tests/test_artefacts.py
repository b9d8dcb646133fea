"""Samples that were not measured are named, and what a motion does is not taken for them."""

from __future__ import annotations

import numpy as np
import pytest
from seat import seeds

from drysim.errors import RecordError
from drysim.records.artefacts import clipped_peaks, frozen_stretches, missing_code
from drysim.records.inspection import inspect_record
from test_level import lift, motion_of, pulse, vibration

CODES = -9999.0, 9999.0, 999.0, -999.25, 99999.0, 999.9, 32767.0, -32768.0, 1e30, 9.9e37


def quantised(x, dice):
    """Return a signal rounded to some 20 to 4000 digits between its extremes."""
    digit = np.ptp(x) / dice.integers(20, 4000)
    return np.round(x / digit) * digit


def smooth(dice):
    """Return a decay, a harmonic or a slow or fast random motion."""
    t = np.arange(int(dice.integers(500, 4000)))
    period = dice.uniform(6, 300)
    kinds = (
        np.exp(-t / dice.uniform(100, 1000)) * np.cos(2 * np.pi * t / period),
        np.sin(2 * np.pi * t / period + 1),
        np.interp(t, t[::20], dice.normal(size=len(t[::20]))),
        vibration(dice),
        pulse(dice, int(dice.integers(40, 600))),
    )
    return kinds[int(dice.integers(len(kinds)))]


def clipping(x):
    """Return the samples that look clipped."""
    return [one for limit in (x.min(), x.max()) for one in clipped_peaks(x, limit)]


@pytest.mark.parametrize("seed", seeds(40, 200))
def test_quantised_flat_and_smooth_signals_do_not_look_clipped(seed):
    dice = np.random.default_rng(seed)
    x = smooth(dice)
    assert not clipping(x)
    assert not clipping(quantised(x, dice))
    held = np.r_[np.full(50, x[0]), x, np.full(50, x[-1])]  # before and after the motion
    assert not clipping(quantised(held, dice))


@pytest.mark.parametrize("seed", seeds(40, 200))
def test_truly_clipped_peaks_are_named(seed):
    dice = np.random.default_rng(seed)
    n, period = 3000, dice.uniform(60, 200)
    if seed % 4 == 0:  # samples and levels repeat
        period = round(period)
    x = np.sin(2 * np.pi * np.arange(n) / period + 0.3 * (seed % 8 != 0))
    if seed % 2:
        x = np.convolve(dice.normal(size=n + 29), np.hanning(30), "valid")
        x /= np.abs(x).max()
    x = np.round(x * 2**11) / 2**11
    limit = np.quantile(np.abs(x), 0.8)
    x = np.clip(x, -limit, limit)
    assert {one.value for one in clipping(x)} == {limit, -limit}
    assert not frozen_stretches(x)
    for one in clipping(x):
        assert (x[one.first : one.first + one.length] == one.value).all()


@pytest.mark.parametrize("seed", seeds(15, 40))
def test_clipped_peak_is_not_called_a_frozen_sensor(seed):
    dice = np.random.default_rng(seed)
    period = int(dice.integers(40, 400)) if seed % 2 else dice.uniform(30, 400)
    x = np.sin(2 * np.pi * np.arange(4000) / period + dice.uniform(0, 6))
    if seed % 4 < 2:
        x += 0.01 * dice.normal(size=4000)
    limit = dice.uniform(0.5, 0.95)
    x = np.round(np.clip(x, -limit, limit), int(dice.integers(4, 9)))
    assert {one.value for one in clipping(x)} == {x.max(), x.min()}
    assert not frozen_stretches(x)


@pytest.mark.parametrize("seed", seeds(15, 40))
def test_plateaus_of_repeated_events_do_not_look_clipped(seed):
    dice = np.random.default_rng(seed)
    x = lift(dice, 12)
    trips = lift(dice, 12, size=1.2)
    for one in (x, trips, np.round(trips, 5), np.round(trips, 3)):
        assert not clipping(one)
        assert not frozen_stretches(one)


@pytest.mark.parametrize("seed", seeds(15, 60))
def test_levels_of_a_converter_that_are_printed_do_not_look_clipped(seed):
    dice = np.random.default_rng(seed)
    x = smooth(dice)
    bits = int(dice.integers(6, 14))
    lsb = 2 * np.abs(x).max() / 2**bits
    printed = np.round(np.round(x / lsb) * lsb / lsb * dice.uniform(2, 30)) / 1e4
    assert not clipping(printed)


def test_clipping_is_looked_for_in_the_window_alone(tmp_path):
    x = vibration(np.random.default_rng(3))[:1500]
    x = np.convolve(x, np.hanning(30), "same") / 10
    x[:300] = np.clip(x[:300], -0.5, 0.5) * 20
    slugs = {
        start: {one.slug for one in motion_of(tmp_path, x, window={"from": start}).warnings}
        for start in (0, 3.5)
    }
    assert "record-clipped" in slugs[0]
    assert "record-clipped" not in slugs[3.5]


@pytest.mark.parametrize("seed", seeds(15, 40))
def test_code_among_samples_is_refused_and_left_out_or_kept_on_request(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x, code = vibration(dice)[:400], CODES[seed % len(CODES)]
    clean = motion_of(tmp_path, x).u_dd
    places = np.arange(5, 395, 6)
    at = np.sort(dice.choice(places, size=int(dice.integers(1, 5)), replace=False))
    wrong = x.copy()
    wrong[at] = code
    with pytest.raises(RecordError) as caught:
        motion_of(tmp_path, wrong)
    problem = caught.value.problem
    assert problem.line == at[0] + 2
    assert f"`missing: {code:g}` leaves it out" in problem.sentence
    found = {one.key: one for one in inspect_record(tmp_path / "r.csv").proposals}
    assert found["missing"].value == code
    assert "gaps" in found
    with pytest.raises(RecordError, match="missing before this row"):
        motion_of(tmp_path, wrong, missing=code)
    gaps = {"fill": "line", "at_most": 0.05}
    filled = motion_of(tmp_path, wrong, missing=code, gaps=gaps).u_dd
    others = np.setdiff1d(np.arange(400), at)
    np.testing.assert_allclose(filled[others], clean[others], rtol=1e-12, atol=1e-12)
    assert np.abs(filled).max() <= np.abs(x).max()
    if abs(code) < 1e9:
        kept = motion_of(tmp_path, wrong, missing="nothing", gravity="keep").u_dd
        assert np.array_equal(kept, wrong)


@pytest.mark.parametrize("seed", seeds(15, 60))
def test_sample_of_a_motion_is_no_code_however_large(seed):
    dice = np.random.default_rng(seed)
    x = pulse(dice, 200) if seed % 2 else vibration(dice)
    assert missing_code(x) is None
    for peak in (999.0, 9999.0, 32767.0):  # a motion that happens to reach such a number
        assert missing_code(np.round(x / np.abs(x).max() * peak, 1)) is None
    assert missing_code(np.arange(1000.0)) is None
    assert missing_code(np.array([0.0, 9999.0, 0.0])) is None


@pytest.mark.parametrize("seed", seeds(15, 40))
def test_frozen_stretch_amid_a_motion_is_named_and_a_rest_is_not(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x = vibration(dice)
    if seed % 3 == 0:
        x = np.round(x, 2)
    assert not frozen_stretches(x)
    length, at = len(x) // 6, len(x) // 2 - int(dice.integers(0, 60))
    frozen = x.copy()
    frozen[at : at + length] = frozen[at]
    (one,) = frozen_stretches(frozen)
    assert abs(one.first - at) <= 9  # rounded samples beside it may be equal
    assert abs(one.length - length) <= 9
    (warning,) = [w for w in motion_of(tmp_path, frozen).warnings if w.slug == "record-frozen"]
    assert f"samples {one.first + 1} to {one.first + one.length}" in warning.sentence
    frozen[3::50] = np.nan
    assert frozen_stretches(frozen)
    quiet = np.zeros(300)
    rest = np.r_[quiet, pulse(dice, 200), quiet, pulse(dice, 200), quiet]
    assert not frozen_stretches(rest)
    assert not frozen_stretches(np.r_[np.zeros(300), x, np.full(300, x[-1])])
    assert not frozen_stretches(np.round(x))  # a signal of few digits repeats them
