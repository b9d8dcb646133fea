"""The level of a sensor at rest: whose mean is an offset, and whose belongs to the motion."""

from __future__ import annotations

import numpy as np
import pytest
from seat import seeds

from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.records.inspection import inspect_record
from drysim.records.level import measure_level

G = 9.80665
DT = 0.01


def pulse(dice, n):
    """Return one of the motions that begin and end at rest, n samples long."""
    t, size = np.linspace(0.0, 1.0, n), dice.uniform(2.0, 60.0) * dice.choice([-1, 1])
    shape = {
        "half-sine": np.sin(np.pi * t),
        "haversine": np.sin(np.pi * t) ** 2,
        "trapezoid": np.clip(5 * np.minimum(t, 1 - t), 0, 1),
        "sawtooth": t * (t < 0.99),
        "braking": np.where((t > 0.05) & (t < 0.9), 1 + 0.02 * np.sin(90 * t), 0.0),
        "lift": np.where(t < 0.5, np.sin(2 * np.pi * t), 0.7 * np.sin(2 * np.pi * t)),
    }
    return size * shape[str(dice.choice(list(shape)))]


def event(dice):
    """Return a record of an event between stretches of silence or noise, and its noise."""
    motion = pulse(dice, int(dice.integers(20, 600)))
    before, after = (int(dice.integers(10, 400)) for _ in range(2))
    x = np.concatenate((np.zeros(before), motion, np.zeros(after)))
    noise = dice.choice([0.0, 0.003]) * np.abs(motion).max()
    return x + noise * dice.normal(size=len(x)), noise


def vibration(dice):
    """Return random or harmonic vibration without mean, RMS about 1."""
    n = int(dice.integers(400, 3000))
    if dice.random() < 0.5:
        x = np.convolve(dice.normal(size=n + 9), np.ones(10), "valid")
    else:
        x = sum(np.sin(2 * np.pi * dice.uniform(8, 40) * np.arange(n) / n + dice.uniform(0, 6))
                for _ in range(3))  # fmt: skip
    return (x - x.mean()) / x.std()


def motion_of(folder, x, **words):
    """Return the motion of samples of ü [m/s²] in a file."""
    rows = "".join(f"{k * DT:.2f},{v!r}\n" for k, v in enumerate(x.tolist()))
    (folder / "r.csv").write_text("t [s],a [m/s2]\n" + rows)
    block = {"kind": "record", "file": "r.csv", "time": "t", **words}
    return Record.model_validate(block, context={"folder": folder}).motion()


def removal(folder):
    """Return the proposal to remove something from the record, None if there is none."""
    return {one.key: one for one in inspect_record(folder / "r.csv").proposals}.get("remove")


@pytest.mark.parametrize("seed", seeds(10, 40))
def test_mean_of_a_shock_a_braking_or_a_lift_is_no_offset_and_not_removed(tmp_path, seed):
    x, _ = event(np.random.default_rng(seed))
    if seed % 4 == 0:  # the mean of an event may be that of gravity by chance
        x *= G / x.mean() if abs(x.mean()) > 1e-3 * np.abs(x).max() else 1.0
    assert "record-mean" not in {one.slug for one in motion_of(tmp_path, x).warnings}
    assert removal(tmp_path) is None


@pytest.mark.parametrize("seed", seeds(10, 20))
def test_motion_that_begins_at_zero_without_a_pause_is_no_gravity(tmp_path, seed):
    dice = np.random.default_rng(seed)
    n = int(dice.integers(2, 40))
    for x in (
        np.linspace(0.0, 2 * G, n),  # a ramp
        np.r_[0.0, np.full(n, 10.0)],  # a step
        G * np.pi / 2 * np.sin(np.linspace(0, np.pi, n + 20)),
    ):
        assert len(motion_of(tmp_path, x).u_dd) == len(x)
        assert removal(tmp_path) is None


@pytest.mark.parametrize("seed", seeds(10, 30))
def test_offset_of_a_vibration_is_named_and_its_removal_proposed(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x = vibration(dice)
    offset = dice.uniform(0.2, 3.0) * dice.choice([-1, 1])
    warnings = motion_of(tmp_path, x + offset).warnings
    (warning,) = [one for one in warnings if one.slug == "record-mean"]
    assert "`remove: mean` removes a sensor offset" in warning.sentence
    assert removal(tmp_path).value == "mean"
    with pytest.raises(RecordError, match="looks like gravity: remove it with `remove: mean`"):
        motion_of(tmp_path, dice.uniform(0.1, 2.0) * x + G * dice.choice([-1, 1]))
    assert "looks like gravity" in removal(tmp_path).reason


@pytest.mark.parametrize("seed", seeds(10, 20))
def test_offset_at_rest_before_an_event_is_named_and_not_confused_with_its_mean(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x, _ = event(dice)
    x = np.abs(x)
    x += (offset := dice.uniform(1.5, 3.0) * x.std())
    level = measure_level(x)
    assert level.rest == pytest.approx(offset, rel=0.02)
    assert level.has_offset
    if level.is_at_rest:
        found = {w.slug: w.sentence for w in motion_of(tmp_path, x, gravity="keep").warnings}
        assert "record-mean" not in found
        words = motion_of(tmp_path, x / 1e3).warnings  # far from gravity in any unit
        assert any("`remove: rest` removes this offset" in one.sentence for one in words)
    x = np.zeros(200)
    x[50:90] = -20.0
    with pytest.raises(RecordError, match="at rest ü is 9"):
        motion_of(tmp_path, x + G)
    assert removal(tmp_path).value == "rest"


@pytest.mark.parametrize("seed", seeds(10, 40))
def test_level_at_rest_is_proposed_and_removed_from_an_event_however_small(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x, noise = event(dice)
    offset = dice.uniform(0.2, 3.0) * x.std() * dice.choice([-1, 1])
    if abs(abs(offset) - G) < 0.1 * G:
        offset *= 2.0
    cleaned = motion_of(tmp_path, x + offset, remove="rest")
    count = min(50, int(0.02 * len(x)))
    assert np.abs(cleaned.u_dd - x).max() <= 5 * noise / max(1, count) ** 0.5 + 1e-12
    assert "record-mean" not in {one.slug for one in cleaned.warnings}
    if min(abs(x.mean() + offset), abs(offset)) > 0.1 * x.std():
        assert removal(tmp_path).value == "rest"


def test_level_at_rest_cannot_be_removed_from_a_record_without_a_quiet_end(tmp_path):
    with pytest.raises(RecordError, match="neither end is quiet; `remove: mean`"):
        motion_of(tmp_path, vibration(np.random.default_rng(1)) + 2.0, remove="rest")


def padded(x, dice):
    """Return samples with zeros before them, after them, or both, and their number."""
    before, after = (int(dice.integers(4, max(5, len(x) // 9))) for _ in range(2))
    before, after = [(before, 0), (0, after), (before, after)][int(dice.integers(3))]
    return np.r_[np.zeros(before), x, np.zeros(after)], before, after


@pytest.mark.parametrize("seed", seeds(10, 40))
def test_zeros_that_pad_a_vibration_prove_no_rest(tmp_path, seed):
    dice = np.random.default_rng(seed)
    size, rest = dice.uniform(0.02, 1.0), G * dice.choice([-1, 1])
    v = vibration(dice)[:2600] * size  # of a longer record a high-pass is proposed
    x, before, after = padded(rest + v, dice)
    with pytest.raises(RecordError, match="samples are 0, and the mean of ü without") as caught:
        motion_of(tmp_path, x)
    assert "cut these zeros off, with `rows`" in str(caught.value)
    found = {one.key: one for one in inspect_record(tmp_path / "r.csv").proposals}
    lines = {"from": before + 2} if before else {}
    lines |= {"to": len(x) - after + 1} if after else {}
    assert found["rows"].value == lines
    assert found["remove"].value == "mean"
    kept = motion_of(tmp_path, x, rows=found["rows"].value, remove="mean")
    np.testing.assert_allclose(kept.u_dd, v - v.mean(), atol=1e-9)
    offset = dice.uniform(0.6, 3.0) * size * dice.choice([-1, 1])
    x, _, _ = padded((offset + v) / 10, dice)
    for remove in ("nothing", "mean", "1 Hz"):
        found = motion_of(tmp_path, x, remove=remove).warnings
        (warning,) = [one for one in found if one.slug == "record-mean"]
        assert "cut these zeros off" in warning.sentence
    x, _, _ = padded(v, dice)
    assert "record-mean" not in {w.slug for w in motion_of(tmp_path, x).warnings}


def lift(dice, trips, size=None):
    """Return trips of a lift with ramps and pauses, up and down in turn, at 100 Hz."""
    parts = [np.zeros(int(dice.integers(40, 300)))]
    for k in range(trips):
        ramp = np.linspace(0, 1, int(dice.integers(20, 80)))
        hold = np.ones(int(dice.integers(50, 300)))
        pulse = (-1) ** k * (size or dice.uniform(0.5, 1.5)) * np.r_[ramp, hold, ramp[::-1]]
        pause = np.zeros(int(dice.integers(100, 300)))
        parts += [pulse, pause, -pulse, pause]
    return np.concatenate(parts)


@pytest.mark.parametrize("seed", seeds(10, 20))
def test_motion_between_silence_at_zero_keeps_its_low_frequencies(tmp_path, seed):
    dice = np.random.default_rng(seed)
    x = lift(dice, 8)
    x += dice.choice([0.0, 0.003]) * dice.normal(size=len(x))
    assert len(x) * DT > 34.0
    assert "record-mean" not in {one.slug for one in motion_of(tmp_path, x).warnings}
    assert removal(tmp_path) is None
    drift = x + np.linspace(-0.5, 0.5, len(x))
    motion_of(tmp_path, drift)
    assert removal(tmp_path).value == {"below": "0.3 Hz"}
    shaken = np.convolve(dice.normal(size=4009), np.ones(10), "valid")
    motion_of(tmp_path, shaken - shaken.mean())
    assert removal(tmp_path).value == {"below": "0.3 Hz"}


def test_rest_outside_the_window_shows_that_there_is_no_offset(tmp_path):
    x = np.zeros(600)
    x[200:400] = -4.9 + 0.1 * np.sin(np.arange(200))
    part = motion_of(tmp_path, x, window={"from": 2, "to": 3.9})
    assert "record-mean" not in {one.slug for one in part.warnings}
    part = motion_of(tmp_path, x[200:400], window={"from": 0.1, "to": 1.9})
    assert "record-mean" in {one.slug for one in part.warnings}


@pytest.mark.parametrize(
    ("header", "unit"),
    [("disp1", None), ("U", None), ("acc", "m/s2"), ("Az", "m/s2"), ("z", "m/s2")],
)
def test_gravity_is_guessed_from_mean_and_name_together(tmp_path, header, unit):
    x = 9.81 + 0.1 * vibration(np.random.default_rng(1))
    rows = "".join(f"{k * DT:.2f},{v!r}\n" for k, v in enumerate(x.tolist()))
    (tmp_path / "r.csv").write_text(f"t [s],{header}\n" + rows)
    found = {one.key: one.value for one in inspect_record(tmp_path / "r.csv").proposals}
    assert found["unit"] == unit
