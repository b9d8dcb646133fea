"""Clean-up of records: nothing is filled, moved or filtered unasked, and all is told."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.plots.response import draw as draw_response
from drysim.plots.sweep import draw_stroke
from drysim.quantity import Quantity
from drysim.records.warnings import displacement_warnings
from drysim.scenario.load import load
from drysim.scenario.text import describe_clean_up
from drysim.study.ensemble import run
from drysim.study.sweep import sweep

RATE = 200.0
T = np.arange(2000) / RATE
WAVE = 2 * np.sin(2 * np.pi * 1.6 * T) + 0.5 * np.sin(2 * np.pi * 7 * T)
LINES = {"gaps": {"fill": "line", "at_most": "50 ms"}}
SPLINES = {"gaps": {"fill": "spline", "at_most": "50 ms"}}


def motion_of(folder, text, **words):
    """Return the motion of a record with this text."""
    (folder / "r.csv").write_text(text)
    words = {"kind": "record", "file": "r.csv", **words}
    return Record.model_validate(words, context={"folder": folder}).motion()


def refused(folder, text, **words):
    """Return the message on a record."""
    with pytest.raises(RecordError) as caught:
        motion_of(folder, text, **words)
    return caught.value.problem.sentence


def rows(t, values, unit="m/s2"):
    """Return a CSV of times and samples; None is an empty cell."""
    samples = values if isinstance(values, list) else values.tolist()
    pairs = zip(t.tolist(), samples, strict=True)
    lines = (f"{x!r},{'' if v is None else repr(v)}\n" for x, v in pairs)
    return f"t [s],a [{unit}]\n" + "".join(lines)


def holed(values, *holes):
    """Return samples with None where they are to be missing."""
    found = values.tolist()
    for at in holes:
        found[at] = None
    return found


def step(motion, name):
    """Return the report of one step of a clean-up."""
    (found,) = (one for one in motion.realised["clean_up"] if one["step"] == name)
    return found


# gaps


def test_a_gap_is_a_fault_that_says_how_to_fill_it(tmp_path):
    said = refused(tmp_path, rows(T, holed(WAVE, 70, 71)), time="t")
    assert said == (
        "row 72, column 2 (`a [m/s2]`): the cell is empty: the record has a gap; "
        "`gaps: {fill: line, at_most: 50 ms}` fills short ones"
    )


def test_missing_rows_are_counted_and_named(tmp_path):
    kept = np.delete(np.arange(2000), [500, 501, 502, 900])
    said = refused(tmp_path, rows(T[kept], WAVE[kept]), time="t")
    assert said.startswith(
        "row 502, column 1 (`t [s]`): 3 samples are missing before this row: a step of "
        "0.02 s, not 0.005 s (2 gaps in total): the record has a gap; `gaps: {fill: line, "
        "at_most: 20 ms}` fills them all"
    )


@pytest.mark.parametrize("samples", [1, 5, 11, 190, 210])
@pytest.mark.parametrize("step", [0.005, 1 / 173, 3e-5, 0.7])
def test_way_to_fill_a_gap_that_is_proposed_fills_it(tmp_path, samples, step):
    kept = np.delete(np.arange(2000), np.arange(300, 300 + samples))
    text = rows(kept * step, WAVE[kept])
    said = refused(tmp_path, text, time="t")
    word, window = re.search(
        r"`gaps: {fill: line, at_most: (.*)}` fills it, `(window: .*)` leaves it out$", said
    ).groups()
    gaps = {"fill": "line", "at_most": word}
    assert len(motion_of(tmp_path, text, time="t", gaps=gaps).u_dd) == 2000
    assert Quantity("s", above=0).read(word) < 1.011 * (samples + 1) * step
    part = motion_of(tmp_path, text, time="t", **yaml.safe_load(window)).u_dd
    assert len(part) == pytest.approx(2000 - 300 - samples, abs=1)


@pytest.mark.parametrize("word", ["", "nan", "NaN", "-NAN", "NA", "n/a", "null", "--"])
def test_gap_may_be_spelt_as_loggers_do(tmp_path, word):
    text = f"a [m/s2]\n1\n{word}\n3\n"
    assert motion_of(tmp_path, text, step="10 ms", **LINES).u_dd.tolist() == [1, 2, 3]


@pytest.mark.parametrize("word", ["inf", "1e999", "oops"])
def test_what_is_no_number_is_no_gap(tmp_path, word):
    said = refused(tmp_path, f"a [m/s2]\n1\n{word}\n3\n", step="10 ms", **LINES)
    assert said.startswith("row 3, column 1")
    assert ("if it is no sample" in said) == (word == "oops")


@pytest.mark.parametrize("way", ["rows", "cells"])
def test_gap_is_filled_by_a_line_as_asked_for_and_told(tmp_path, way):
    lost = [300, 301, 302, 800]
    kept = np.delete(np.arange(2000), lost)
    text = rows(T[kept], WAVE[kept]) if way == "rows" else rows(T, holed(WAVE, *lost))
    motion = motion_of(tmp_path, text, time="t", **LINES)
    assert (len(motion.u_dd), motion.dt) == (2000, 1 / RATE)
    assert np.array_equal(motion.u_dd[kept], WAVE[kept])
    expected = np.interp(T[lost], T[kept], WAVE[kept])
    np.testing.assert_allclose(motion.u_dd[lost], expected, rtol=1e-12)
    told = step(motion, "gaps")
    assert told["numbers"] == pytest.approx({"gaps": 2, "samples": 4, "longest": 0.02})
    assert told["rms_before"] == pytest.approx(WAVE[kept].std())
    assert told["rms_after"] == pytest.approx(motion.u_dd.std())
    assert told["mean_before"] == pytest.approx(WAVE[kept].mean())
    assert told["mean_after"] == pytest.approx(motion.u_dd.mean())
    assert describe_clean_up(motion)[0].startswith(
        "2 gaps (4 samples) filled by linear interpolation, the longest of 0.02 s; "
        "RMS about the mean 1.4"
    )
    assert motion.warnings == ()


def test_spline_fills_a_smooth_gap_better_than_a_line(tmp_path):
    lost = [300, 301, 302]
    text = rows(T, holed(WAVE, *lost))
    by_line = motion_of(tmp_path, text, time="t", **LINES).u_dd - WAVE
    by_spline = motion_of(tmp_path, text, time="t", **SPLINES).u_dd - WAVE
    assert np.abs(by_spline).max() < 0.05 * np.abs(by_line).max()


def test_gap_longer_than_allowed_stays_a_fault(tmp_path):
    text = rows(T, holed(WAVE, *range(300, 310)))
    said = refused(tmp_path, text, time="t", **LINES)
    assert said == (
        "row 312, column 2 (`a [m/s2]`): 10 samples are missing before this row: a step of "
        "0.055 s, not 0.005 s: `gaps.at_most` allows 0.05 s; "
        "`gaps: {fill: line, at_most: 55 ms}` fills it, `window: {from: 1.55 s}` leaves it out"
    )
    longer = {"gaps": {"fill": "line", "at_most": 0.055}}
    assert len(motion_of(tmp_path, text, time="t", **longer).u_dd) == 2000


@pytest.mark.parametrize("at", [0, -1])
def test_gap_at_an_end_has_only_one_side(tmp_path, at):
    said = refused(tmp_path, rows(T, holed(WAVE, at)), time="t", **LINES)
    assert "the record begins or ends with a gap; cut it off" in said


def test_gaps_allowed_but_not_there_change_nothing(tmp_path):
    motion = motion_of(tmp_path, rows(T, WAVE), time="t", **LINES)
    assert np.array_equal(motion.u_dd, WAVE)
    assert dict(motion.realised) == {}


def test_many_filled_samples_are_a_warning(tmp_path):
    text = rows(T, holed(WAVE, *range(100, 200, 3)))
    (caution,) = motion_of(tmp_path, text, time="t", **LINES).warnings
    assert caution.slug == "record-filled"
    assert caution.numbers["share"] == pytest.approx(34 / 2000)
    assert "changed the RMS" not in caution.sentence


def test_rms_that_filling_changed_is_named(tmp_path):
    gaps = {"fill": "spline", "at_most": "5 s"}
    text = rows(T, holed(WAVE, *range(600, 1500)))
    motion = motion_of(tmp_path, text, time="t", gaps=gaps)
    (caution,) = (one for one in motion.warnings if one.slug == "record-filled")
    before, after = np.delete(WAVE, range(600, 1500)).std(), motion.u_dd.std()
    said = f"changed the RMS from {before:.4g} to {after:.4g} m/s²"
    assert said in caution.sentence


def test_missing_time_is_a_fault_whatever_is_said_of_gaps(tmp_path):
    text = rows(T, WAVE).replace("\n0.05,", "\n,")
    assert "column 1 (`t [s]`): the cell is empty" in refused(
        tmp_path, text, time="t", column="a", **LINES
    )


WINDOW = {"from": "3 s", "to": "6 s"}
INSIDE = slice(600, 1201)


@pytest.mark.parametrize("lost", [range(400), range(300, 500), range(1300, 1990), [1999], [50]])
@pytest.mark.parametrize("way", ["rows", "cells", "column"])
def test_gap_outside_the_window_is_no_fault_and_changes_nothing(tmp_path, way, lost):
    kept = np.delete(np.arange(2000), lost)
    words = {"time": "t", "window": WINDOW}
    text = rows(T[kept], WAVE[kept]) if way == "rows" else rows(T, holed(WAVE, *lost))
    if way == "column":  # without times
        words = {"rate": RATE, "window": WINDOW}
        cells = (str(np.nan if v is None else v) for v in holed(WAVE, *lost))
        text = "a [m/s2]\n" + "\n".join(cells)
    motion = motion_of(tmp_path, text, **words)
    np.testing.assert_allclose(motion.u_dd, WAVE[INSIDE], rtol=1e-12)
    assert motion.warnings == ()


def test_clean_up_acts_on_the_part_between_the_gaps_around_the_window_and_says_so(tmp_path):
    kept = np.delete(np.arange(2000), [*range(200, 300), 800, *range(1500, 1600)])
    text = rows(T[kept], (WAVE + 9.81)[kept])
    motion = motion_of(tmp_path, text, time="t", window=WINDOW, remove="mean", **SPLINES)
    level = np.delete(WAVE[300:1500], 500).mean()
    np.testing.assert_allclose(motion.u_dd, WAVE[INSIDE] - level, atol=2e-2)
    steps = [one["step"] for one in motion.realised["clean_up"]]
    assert steps == ["window", "gaps", "remove"]
    assert step(motion, "window")["numbers"] == pytest.approx({"first": 1.5, "last": 7.495})
    assert step(motion, "gaps")["numbers"] == pytest.approx(
        {"gaps": 1, "samples": 1, "longest": 0.01}
    )


def test_share_of_filled_samples_is_that_of_the_window(tmp_path):
    text = rows(T, holed(WAVE, *range(1300, 1500, 3), *range(700, 719, 2)))
    motion = motion_of(tmp_path, text, time="t", window=WINDOW, **LINES)
    (warning,) = motion.warnings
    assert warning.numbers["share"] == pytest.approx(10 / 601)
    assert step(motion, "gaps")["numbers"]["samples"] == 10
    text = rows(T, holed(WAVE, *range(1300, 1500, 3)))
    assert motion_of(tmp_path, text, time="t", window=WINDOW, **LINES).warnings == ()


@pytest.mark.parametrize("lost", [range(700, 800), range(580, 601), range(1200, 1220)])
def test_gap_that_reaches_into_the_window_stays_a_fault(tmp_path, lost):
    kept = np.delete(np.arange(2000), lost)
    text = rows(T[kept], WAVE[kept])
    said = refused(tmp_path, text, time="t", window=WINDOW, **LINES)
    assert f"{len(lost)} samples are missing before this row" in said


@pytest.mark.parametrize("lost", [[0], [0, 1, 2], [1999], [0, 1999]])
def test_window_that_is_proposed_cuts_off_a_gap_at_an_end(tmp_path, lost):
    text = rows(T, holed(WAVE, *lost))
    said = refused(tmp_path, text, time="t", **LINES)
    words = yaml.safe_load(re.search(r"cut it off: `(.*)`$", said)[1])
    motion = motion_of(tmp_path, text, time="t", **words)
    assert np.array_equal(motion.u_dd, np.delete(WAVE, lost))


# uneven times and resampling


@pytest.mark.parametrize("pause", [0.3337, 2.5012, 60.0021])
@pytest.mark.parametrize("quantity", ["acceleration", "displacement"])
@pytest.mark.parametrize("jitter", [0.0, 5e-4])
def test_pause_of_a_logger_is_called_a_gap_with_remedies_that_work(
    tmp_path, pause, quantity, jitter
):
    t = T + np.random.default_rng(3).uniform(-jitter, jitter, len(T))
    t[1200:] += pause
    unit = {"acceleration": "m/s2", "displacement": "m"}[quantity]
    text, words = rows(t, WAVE, unit), {"time": "t", "quantity": quantity}
    said = refused(tmp_path, text, **words)
    assert "gap" in said
    assert "row 1202" in said or jitter
    keys = re.search(r"`(gaps: {.*?})` and `(resample: {.*?})` together", said).groups()
    filled = motion_of(tmp_path, text, **words, **yaml.safe_load("\n".join(keys)))
    assert len(filled.u_dd) * filled.dt == pytest.approx(t[-1], rel=1e-2)
    alone = yaml.safe_load(keys[0])
    assert "together" in refused(tmp_path, text, **words, **alone)
    if not jitter:
        window = yaml.safe_load(re.search(r"`(window: {.*?})` leaves it out", said)[1])
        part = motion_of(tmp_path, text, **words, **window)
        assert (len(part.u_dd), part.dt) == (1200, 1 / RATE)


def jittered(seed=1):
    """Return times that jitter by a fifth of a step."""
    return T + np.random.default_rng(seed).uniform(-0.2, 0.2, len(T)) / RATE


def test_jitter_is_a_fault_with_its_measured_spread(tmp_path):
    t = jittered()
    said = refused(tmp_path, rows(t, WAVE), time="t")
    steps = np.diff(t)
    assert f"{steps.min():.6g} to {steps.max():.6g} overall" in said
    remedy = re.search(r"`(resample: .*?)` makes them even", said)[1]
    motion_of(tmp_path, rows(t, WAVE), time="t", **yaml.safe_load(remedy))


@pytest.mark.parametrize(("by", "error"), [("line", 0.02), ("spline", 1e-4)])
def test_jittered_record_is_resampled_as_asked_for_and_told(tmp_path, by, error):
    t = jittered()
    wave = 2 * np.sin(2 * np.pi * 1.6 * t)
    words = {"time": "t", "resample": {"rate": "400 Hz", "by": by}}
    motion = motion_of(tmp_path, rows(t, wave), **words)
    even = t[0] + np.arange(len(motion.u_dd)) / 400
    assert motion.dt == 1 / 400
    assert t[-1] - even[-1] < 1 / 400
    np.testing.assert_allclose(motion.u_dd, 2 * np.sin(2 * np.pi * 1.6 * even), atol=error)
    told = step(motion, "resample")
    assert told["numbers"]["least_step"] == pytest.approx(np.diff(t).min())
    assert told["numbers"]["greatest_step"] == pytest.approx(np.diff(t).max())
    method = {"line": "linear interpolation", "spline": "cubic spline"}[by]
    assert f"to 400 Hz by {method}" in describe_clean_up(motion)[0]


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_jittered_record_keeps_the_rate_that_it_was_sampled_with(tmp_path, seed):
    t = jittered(seed)
    words = {"time": "t", "resample": {"rate": RATE, "by": "line"}}
    motion = motion_of(tmp_path, rows(t, WAVE), **words)
    assert motion.dt == 1 / RATE
    slower = {"time": "t", "resample": {"rate": 0.95 * RATE, "by": "line"}}
    assert "aliases frequencies" in refused(tmp_path, rows(t, WAVE), **slower)


def test_hole_among_uneven_times_is_a_gap_and_no_jitter(tmp_path):
    t, kept = jittered(), np.delete(np.arange(2000), [500, 501, 502])
    wave = 2 * np.sin(2 * np.pi * 1.6 * t[kept]) + 0.5 * np.sin(2 * np.pi * 7 * t[kept])
    text, words = rows(t[kept], wave), {"time": "t"}
    words["resample"] = {"step": "5 ms", "by": "spline"}
    assert "samples are missing before this row" in refused(tmp_path, text, **words)
    motion = motion_of(tmp_path, text, **words, **SPLINES)
    assert [one["step"] for one in motion.realised["clean_up"]] == ["gaps", "resample"]
    even = t[0] + np.arange(len(motion.u_dd)) / 200
    expected = 2 * np.sin(2 * np.pi * 1.6 * even) + 0.5 * np.sin(2 * np.pi * 7 * even)
    np.testing.assert_allclose(motion.u_dd, expected, atol=0.03)


def test_finer_grid_by_lines_is_the_same_motion(tmp_path):
    from drysim.core.model import integrate_base_squares

    text = rows(T, WAVE)
    coarse = motion_of(tmp_path, text, time="t")
    fine = motion_of(tmp_path, text, time="t", resample={"rate": 800, "by": "line"})
    np.testing.assert_allclose(fine.u_dd[::4], coarse.u_dd, atol=1e-12)
    end = T[-1]
    ours, theirs = (integrate_base_squares(motion, 0, end)[0] for motion in (fine, coarse))
    assert ours == pytest.approx(theirs, rel=1e-12)


def test_loss_of_rate_asks_for_a_low_pass_and_names_one_that_does(tmp_path):
    text, words = rows(T, WAVE), {"time": "t"}
    words["resample"] = {"rate": 50, "by": "line"}
    said = refused(tmp_path, text, **words)
    assert said == (
        "resampling from 200 to 50 Hz aliases frequencies above 25 Hz; add a low-pass with "
        "a gain of at most 0.1 there, `remove: {above: 14.3 Hz, order: 2}` or lower"
    )
    assert said.startswith(refused(tmp_path, text, **words, remove={"above": 15})[:40])
    motion = motion_of(tmp_path, text, **words, remove={"above": 14.3})
    assert (len(motion.u_dd), motion.dt) == (500, 0.02)


def test_what_would_fold_is_gone_before_samples_are_left_out(tmp_path):
    hum = np.sin(2 * np.pi * 48 * T)  # would be 2 Hz at 50 Hz
    text = rows(T, WAVE + hum)
    words = {"time": "t", "remove": {"above": 18, "order": 5}}
    motion = motion_of(tmp_path, text, **words, resample={"rate": 50, "by": "line"})
    middle = slice(50, -50)
    np.testing.assert_allclose(motion.u_dd[middle], WAVE[::4][middle], atol=2e-3)


@pytest.mark.parametrize(
    ("mean", "remove", "remedy"),
    [(0.0, {}, "{above: 30 Hz}"), (9.81, {"remove": "mean"}, "{trend: mean, above: 30 Hz}")],
)
def test_resampling_that_costs_level_is_a_warning_whatever_the_mean(
    tmp_path, mean, remove, remedy
):
    noise = np.random.default_rng(2).normal(size=len(T)) + mean
    words = {"time": "t", "resample": {"rate": 210, "by": "line"}, **remove}
    caution, other = motion_of(tmp_path, rows(T, noise), **words).warnings
    assert (caution.slug, other.slug) == ("record-lost", "record-interpolated")
    assert f"`by: spline` loses less; a low-pass, `remove: {remedy}`" in caution.sentence
    assert caution.numbers["rms_after"] < 0.9 * caution.numbers["rms_before"]


@pytest.mark.parametrize("level", [9.7, 0.1])
def test_resampling_of_constant_samples_is_no_warning(tmp_path, level):
    text = rows(T, [level] * len(T))
    resample = {"resample": {"rate": 260, "by": "spline"}, "gravity": "keep"}
    motion = motion_of(tmp_path, text, time="t", **resample)
    assert [warning.slug for warning in motion.warnings] == ["record-still"]


def test_level_that_a_low_pass_takes_is_not_held_against_the_resampling(tmp_path):
    noise = np.random.default_rng(2).normal(size=len(T))
    noise -= noise.mean()
    words = {"time": "t", "resample": {"rate": 1600, "by": "spline"}}
    (caution,) = motion_of(tmp_path, rows(T, noise), **words).warnings
    assert caution.sentence.endswith(
        "a low-pass, `remove: {above: 30 Hz}` or lower, removes the high frequencies"
    )
    words["remove"] = {"above": 30}
    assert motion_of(tmp_path, rows(T, noise), **words).warnings == ()


def test_clean_up_tells_the_rms_about_the_mean_and_the_mean(tmp_path):
    text = rows(T, 9.81 + WAVE)
    motion = motion_of(tmp_path, text, time="t", remove="mean")
    assert describe_clean_up(motion)[0].endswith(
        "; RMS about the mean 1.458 before, 1.458 m/s² after; mean 9.81 before, 0 m/s² after"
    )


# what interpolation costs


def band(low, high, quantity, n=4000):
    """Return noise of unit RMS{ü} between two frequencies [Hz], sampled at RATE."""
    f = np.fft.rfftfreq(n, 1 / RATE)
    lines = np.where((f >= low) & (f <= high), np.exp(2j * np.pi * f * f), 0)
    omega = 2j * np.pi * np.maximum(f, 1e-9)
    power = {"acceleration": 0, "velocity": 1, "displacement": 2}[quantity]
    return np.fft.irfft(lines / omega**power, n) / np.fft.irfft(lines, n).std()


UNITS = {"acceleration": "m/s2", "velocity": "m/s", "displacement": "m"}


def column(values, quantity):
    """Return the text of a record of one column."""
    return f"x [{UNITS[quantity]}]\n" + "".join(f"{v!r}\n" for v in values.tolist())


def rms(motion):
    """Return the RMS of ü, linear between samples."""
    from drysim.core.model import integrate_base_squares

    end = (len(motion.u_dd) - 1) * motion.dt
    return np.sqrt(integrate_base_squares(motion._replace(u=None), 0, end)[0] / end)


@pytest.mark.parametrize(
    ("quantity", "low", "high", "lossy"),
    [
        ("acceleration", 1, 10, False),
        ("acceleration", 1, 30, True),
        ("acceleration", 60, 95, True),
        ("velocity", 1, 45, False),
        ("velocity", 40, 60, True),
        ("displacement", 1, 50, False),
        ("displacement", 55, 65, True),
    ],
)
def test_rms_that_interpolation_loses_is_a_warning_in_every_quantity(
    tmp_path, quantity, low, high, lossy
):
    text = column(band(low, high, quantity), quantity)
    motion = motion_of(tmp_path, text, rate=RATE, quantity=quantity)
    assert [c.slug for c in motion.warnings] == ["record-interpolated"] * lossy
    if lossy:
        kept = motion.warnings[0].numbers["kept"]
        assert kept == pytest.approx(rms(motion), abs=2e-3)
    else:
        assert rms(motion) > 0.99


@pytest.mark.parametrize("seed", range(20))
def test_loss_of_interpolation_at_one_spike_names_its_sample(tmp_path, seed):
    dice = np.random.default_rng(seed)
    spike = int(dice.integers(1, len(T) - 1))
    x = WAVE.copy()
    x[spike] += dice.uniform(20, 500) * dice.choice([-1, 1])
    (warning,) = motion_of(tmp_path, column(x, "acceleration"), rate=RATE).warnings
    value, time = x[spike], spike / RATE
    assert f"at one sample, {value:.6g} m/s² at {time:.6g} s" in warning.sentence
    noise = column(dice.normal(size=len(T)), "acceleration")
    (warning,) = motion_of(tmp_path, noise, rate=RATE).warnings
    assert "at one sample" not in warning.sentence


@pytest.mark.parametrize("quantity", ["velocity", "displacement"])
def test_resampling_does_not_hide_what_the_spline_of_a_record_loses(tmp_path, quantity):
    text = column(band(55, 95, quantity) + band(1, 5, quantity), quantity)
    words = {"rate": RATE, "quantity": quantity, "resample": {"rate": 1600, "by": "spline"}}
    assert "record-interpolated" in [
        c.slug for c in motion_of(tmp_path, text, **words).warnings
    ]


@pytest.mark.parametrize(
    ("quantity", "low", "high"),
    [
        ("acceleration", 1, 45),
        ("acceleration", 1, 95),
        ("acceleration", 60, 95),
        ("velocity", 1, 95),
        ("displacement", 1, 95),
        ("displacement", 60, 95),
    ],
)
def test_every_remedy_of_lost_rms_serves(tmp_path, quantity, low, high):
    words = {"rate": RATE, "quantity": quantity, "remove": {"trend": "line", "order": 3}}
    text = column(band(low, high, quantity) + band(1, 4, quantity), quantity)
    (caution,) = motion_of(tmp_path, text, **words).warnings
    given = re.findall(r"`(\w+): ({.*?})`", caution.sentence)
    remedies = [{key: yaml.safe_load(value)} for key, value in given]
    if "is enough" in caution.sentence:
        corner = float(re.search(r"` (\S+) Hz is enough", caution.sentence)[1])
        remedies[1]["remove"] = remedies[0]["remove"] | {"above": corner}
    assert {"trend", "above", "order"} == remedies[0 if "remove" in remedies[0] else 1][
        "remove"
    ].keys()
    for remedy in remedies:
        assert motion_of(tmp_path, text, **words | remedy).warnings == ()


def test_few_samples_are_corners_of_a_motion_on_lines(tmp_path):
    text = "a [m/s2]\n0\n0\n1\n0\n-1\n0\n0\n"
    assert motion_of(tmp_path, text, rate=RATE).warnings == ()


def test_rate_that_no_memory_holds_is_refused(tmp_path):
    words = {"time": "t", "resample": {"rate": "1e15 Hz", "by": "line"}}
    said = refused(tmp_path, rows(T, WAVE), **words)
    assert "GB of memory, this machine has" in said


def test_window_counts_on_the_times_of_the_record_after_resampling(tmp_path):
    words = {"time": "t", "resample": {"rate": 400, "by": "line"}, "window": {"from": 5}}
    motion = motion_of(tmp_path, rows(T + 2, WAVE), **words)
    np.testing.assert_allclose(motion.u_dd[::2], WAVE[600:], atol=1e-11)


@pytest.mark.parametrize("words", [{"resample": {"rate": 400, "by": "line"}}, LINES])
def test_displacement_is_never_put_on_lines(words):
    with pytest.raises(ValidationError, match="linear interpolation of displacement has kinks"):
        Record.model_validate(
            {"kind": "record", "file": "r.csv", "quantity": "displacement", **words}
        )


# band limits, and the displacement that they make known


def test_band_is_removed_on_both_sides_and_told(tmp_path):
    slow, mid, fast = (np.sin(2 * np.pi * f * T) for f in (0.2, 4, 60))
    text = rows(T, 3 + slow + mid + fast)
    words = {"trend": "mean", "below": "1 Hz", "above": "20 Hz", "order": 4}
    motion = motion_of(tmp_path, text, time="t", remove=words)
    middle = slice(400, -400)
    np.testing.assert_allclose(motion.u_dd[middle], mid[middle], atol=3e-3)
    assert describe_clean_up(motion)[0].startswith(
        "the mean, frequencies above 20 Hz and frequencies below 1 Hz removed (zero-phase "
        "Butterworth of order 4); the removed part changes by "
    )


@pytest.mark.parametrize("order", [1, 2, 4, 8])
def test_low_pass_halves_its_own_frequency_and_falls_as_its_order_says(tmp_path, order):
    from drysim.records.clean import low_pass_gain

    for frequency in (10.0, 20.0):
        wave = np.sin(2 * np.pi * frequency * T)
        text = rows(T, wave)
        motion = motion_of(tmp_path, text, time="t", remove={"above": 10, "order": order})
        middle = slice(600, -600)
        left = np.abs(motion.u_dd[middle]).max() / np.abs(wave[middle]).max()
        # The digital filter is the analogue one, its frequencies bent towards half the rate.
        bent = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * 10 / RATE)
        assert left == pytest.approx(low_pass_gain(bent, 1, order), rel=0.02)


def test_displacement_is_known_above_a_stated_high_pass_only(tmp_path):
    u = 1e-2 * np.sin(2 * np.pi * 1.6 * T) + 2e-3 * np.sin(2 * np.pi * 7 * T)
    factors = (2 * np.pi * 1.6) ** 2, (2 * np.pi * 7) ** 2
    u_dd = -1e-2 * factors[0] * np.sin(2 * np.pi * 1.6 * T)
    u_dd -= 2e-3 * factors[1] * np.sin(2 * np.pi * 7 * T)
    text = rows(T, u_dd + 0.3)
    assert motion_of(tmp_path, text, time="t", remove="mean").u is None
    assert motion_of(tmp_path, text, time="t", remove={"above": 50}).u is None
    motion = motion_of(tmp_path, text, time="t", remove={"below": 0.2})
    middle = slice(500, -500)
    assert np.sqrt(np.mean(motion.u[middle] ** 2)) == pytest.approx(
        np.sqrt(np.mean(u[middle] ** 2)), rel=0.01
    )


def seat_test(seed, rms_of_slow=0.0):
    """Return 30 s of EM1, and its displacement [m], with some slow motion on request."""
    random = np.random.default_rng(seed)
    f, t = np.arange(30, 480) / 120, np.arange(int(30 * RATE) + 1) / RATE
    G = 2.82 / ((1 + (1.5 / f) ** 8) * (1 + (f / 2.5) ** 8)) + rms_of_slow**2
    waves = np.sin(2 * np.pi * np.outer(t, f) + random.uniform(0, 2 * np.pi, len(f)))
    u_dd = waves @ np.sqrt(G / 60)
    return rows(t, u_dd), -(waves @ (np.sqrt(G / 60) / (2 * np.pi * f) ** 2))


BAND = {"time": "t", "remove": {"below": 0.2, "order": 4}}


@pytest.mark.parametrize("seed", [16, 27, 28, 35])
def test_ends_of_a_record_without_slow_parts_add_next_to_nothing_to_its_displacement(
    tmp_path, seed
):
    text, u = seat_test(seed)
    found = motion_of(tmp_path, text, **BAND).u
    assert np.sqrt(np.mean(found**2)) == pytest.approx(np.sqrt(np.mean(u**2)), rel=0.01)


def test_displacement_that_depends_on_the_ends_of_the_record_is_a_warning(tmp_path):
    text, _ = seat_test(3, rms_of_slow=1.0)
    (caution,) = (
        one for one in motion_of(tmp_path, text, **BAND).warnings
        if one.slug == "displacement-ends"
    )  # fmt: skip
    assert caution.numbers["share"] > 0.01
    assert "it depends on how the record is continued beyond its ends" in caution.sentence
    assert "exclude the first and the last 5 s with `excitation.window`" in caution.sentence


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.125, "uncertain by about 12 %"), (0.995, "is not determined by this record")],
)
def test_large_uncertainty_of_the_displacement_is_said_in_words(share, words):
    record = Record.model_validate({"kind": "record", "file": "r.csv", "remove": 0.3})
    u = np.ones(100)
    (warning,) = displacement_warnings(record, u, u * (1 - np.sqrt(2 * share)))
    assert words in warning.sentence
    assert "e+" not in warning.sentence


def test_window_without_the_ends_has_a_displacement_without_a_warning(tmp_path):
    text, u = seat_test(3)
    inner = motion_of(tmp_path, text, **BAND, window={"from": 5.0, "to": 25.0})
    assert "displacement-ends" not in {one.slug for one in inner.warnings}
    part = u[int(5 * RATE) : int(25 * RATE) + 1]
    rms = np.sqrt(np.mean(part**2))
    assert np.sqrt(np.mean(inner.u**2)) == pytest.approx(rms, rel=0.005)


def test_displacement_of_a_velocity_record_is_on_its_own_grid(tmp_path):
    v = np.cos(2 * np.pi * 1.6 * T)
    text = rows(T, v, "m/s")
    words = {"time": "t", "quantity": "velocity", "remove": {"below": 0.2}}
    motion = motion_of(tmp_path, text, **words, window={"from": 2, "to": 8})
    assert len(motion.u) == len(motion.u_dd) == 2401
    t = 2 + np.arange(2401) * motion.dt
    expected = np.sin(2 * np.pi * 1.6 * t) / (2 * np.pi * 1.6)
    np.testing.assert_allclose(motion.u, expected, atol=2e-3)


# ends of a high-pass

ENDS = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {kinetic: 45, static: 54}
excitation: {kind: record, file: r.csv, rate: 200, remove: {below: 0.3 Hz}}
"""


@pytest.fixture
def drifting(tmp_path):
    """Return the scenario of a record with drift and gravity, whose mass hardly moves."""
    random, n = np.random.default_rng(3), 6000
    f = np.fft.rfftfreq(n, 1 / RATE)
    lines = ((f >= 0.5) & (f <= 12)) * np.exp(2j * np.pi * random.random(len(f)))
    wave, drift = np.fft.irfft(lines, n), np.cumsum(random.normal(size=n))
    values = 0.4 * wave / wave.std() + 0.3 * (drift - drift.mean()) / drift.std() + 9.81
    (tmp_path / "r.csv").write_text("a [m/s2]\n" + "".join(f"{v!r}\n" for v in values.tolist()))
    (tmp_path / "r.yaml").write_text(ENDS)
    return tmp_path / "r.yaml"


def test_ends_of_a_high_pass_that_decide_a_metric_are_a_warning(drifting):
    (given,) = (one for one in run(load(drifting)).warnings if one.slug == "record-ends")
    assert given.numbers["x_r_rms"] == pytest.approx(0.17, abs=0.02)
    assert given.numbers["x_r_peak"] == pytest.approx(0.145, abs=0.02)
    assert "T_a" not in given.numbers
    assert "leave out the first and the last 3.33 s of the record by" in given.sentence
    inside = {"excitation.window": {"from": 3.34, "to": 26.6}}
    assert "record-ends" not in [one.slug for one in run(load(drifting, inside)).warnings]


def test_clean_up_says_how_much_hangs_on_the_ends_of_a_high_pass(drifting, drysim):
    told = " ".join(drysim("validate", str(drifting)).out.split())
    assert (
        "; the first and the last 3.33 s depend on how the record is continued beyond its "
        "ends; RMS "
    ) in told


def test_record_without_a_high_pass_is_solved_once(tmp_path, monkeypatch):
    from drysim.study import run as one_case

    monkeypatch.setattr(one_case, "measure_case", lambda _: pytest.fail("solved twice"))
    write_scene(tmp_path, "  remove: {trend: mean, above: 30 Hz}\n")
    assert run(load(tmp_path / "r.yaml")).warnings == ()


def test_record_that_is_gone_before_its_ends_are_looked_at_keeps_its_answer(drifting):
    from drysim.study.preparation import prepare
    from drysim.study.run import solve

    case = prepare(load(drifting))
    (drifting.parent / "r.csv").unlink()
    assert "record-ends" not in [one.slug for one in solve(case).warnings]


# what people see

SCENE = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation:
  kind: record
  file: r.csv
  time: t
"""


def write_scene(folder, words="", values=WAVE):
    """Write a record and a scenario with it."""
    (folder / "r.csv").write_text(rows(T, values))
    (folder / "r.yaml").write_text(SCENE + words)


def test_clean_up_is_in_summary_sidecar_validate_and_dry_run(tmp_path, drysim):
    write_scene(tmp_path, "  gaps: {fill: line, at_most: 10 ms}\n", holed(WAVE, 70))
    words = (
        "1 gap (1 sample) filled by linear interpolation, the longest of 0.01 s; "
        "RMS about the mean 1.4"
    )
    answer = drysim("run", "r.yaml", "--no-plots", "--strict")
    assert answer.code == 0
    assert words in " ".join(answer.out.split())
    told = json.loads((tmp_path / "out/r/drysim.json").read_text())
    (one,) = told["excitation"]["realised"]["clean_up"]
    assert one["sentence"].startswith(words)
    assert drysim("validate", "r.yaml").out.startswith(f"ok: r.yaml\n\nr.yaml: note: {words}")
    assert drysim("validate", "r.yaml", "--format", "github").out.startswith(
        f"::notice file=r.yaml::{words}"
    )
    assert words in drysim("run", "r.yaml", "--dry-run").out
    assert json.loads(drysim("run", "r.yaml", "--dry-run", "--json").out)["clean_up"]
    again = drysim("run", "out/r/scenario.yaml", "--no-plots", "-o", "again")
    assert words in " ".join(again.out.split())


def test_validate_dry_run_and_run_tell_one_rms_and_which_it_is(tmp_path, drysim):
    write_scene(tmp_path, values=0.5 + WAVE)
    words = "1.541 m/s² RMS, linear between samples; mean 0.5 m/s², 1.457 m/s² RMS about it"
    run = drysim("run", "r.yaml", "--no-plots").out
    for told in (
        drysim("validate", "r.yaml").out,
        drysim("run", "r.yaml", "--dry-run").out,
        run,
    ):
        assert words in " ".join(told.split())
    assert "base 1.541 m/s² RMS" in " ".join(run.split())


def test_pictures_tell_what_was_done_to_a_record_and_its_factor(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_scene(tmp_path, "  scale: 2\n  remove: {trend: mean, above: 30 Hz}\n")
    one, many = load("r.yaml"), load("r.yaml", {"sweep": {"oscillator.mass": [50, 75]}})
    table, scales = sweep(many), {"sweep": {"excitation.scale": [1, 2]}}
    for figure in (draw_response(run(one)), draw_stroke(table)):
        told = " ".join(text.get_text() for text in figure.texts)
        assert "; cleaned record r.csv times 2" in told
    figure = draw_stroke(sweep(load("r.yaml", scales)))
    assert "record r.csv; swept: excitation.scale 1, 2" in figure.texts[2].get_text()


def test_factor_on_a_record_is_told_in_every_summary(tmp_path, drysim):
    write_scene(tmp_path, "  scale: 2.5\n")
    assert "record r.csv times 2.5, " in drysim("run", "r.yaml", "--no-plots").out
    told = json.loads((tmp_path / "out/r/drysim.json").read_text())
    assert told["excitation"]["realised"] == {"scale": 2.5}
    swept = ("sweep", "r.yaml", "--no-plots", "--set", "sweep={oscillator.mass: [50, 75]}")
    assert "record r.csv times 2.5, " in drysim(*swept).out


@pytest.mark.parametrize(
    ("removed", "remedy"),
    [("", "{below"), ("  remove: {trend: mean, above: 30 Hz}\n",
                      "{trend: mean, below: 0.3 Hz, above: 30 Hz}`")],
)  # fmt: skip
def test_unknown_displacement_of_a_record_comes_with_the_way_to_it(
    tmp_path, drysim, removed, remedy
):
    write_scene(tmp_path, removed)
    answer = " ".join(drysim("run", "r.yaml", "--no-plots").out.split())
    told = "base displacement not known; it needs a high-pass: `remove: "
    assert f"{told}{remedy}" in answer
    answer = drysim("run", "r.yaml", "--no-plots", "--set", "excitation.remove=0.3 Hz").out
    assert "not known" not in answer


# what is probably wrong


@pytest.mark.parametrize("remove", ["nothing", "mean", "1 Hz"])
@pytest.mark.parametrize("mean", [1.0, -1.0, 96.2])
@pytest.mark.parametrize("where", ["scenario", "file"])
def test_unit_that_is_wrong_by_gravity_is_suspected_with_a_remedy(
    tmp_path, remove, mean, where
):
    factor = 9.80665 if mean == 96.2 else 1.0
    unit = "g" if mean == 96.2 else "m/s2"
    text = rows(T, ((WAVE / 5 + mean) / factor), unit)
    words = {"time": "t", "remove": remove, "gravity": "keep"}
    if where == "scenario":
        text = text.replace(f" [{unit}]", "", 1)
        words["unit"] = unit
    warnings = motion_of(tmp_path, text, **words).warnings
    (warning,) = (one for one in warnings if one.slug == "record-unit")
    assert "record-mean" not in {one.slug for one in warnings}
    remedy = yaml.safe_load(re.search("`(.*)` corrects it", warning.sentence)[1])
    motion = motion_of(tmp_path, text, **{**words, **remedy})
    assert "record-unit" not in {one.slug for one in motion.warnings}
    if remove == "nothing":
        assert abs(motion.u_dd.mean()) == pytest.approx(9.81, rel=0.03)


@pytest.mark.parametrize(("mean", "size"), [(1.2, 0.2), (0.9, 0.2), (1.0, 2.0), (9.81, 0.2)])
def test_ordinary_mean_raises_no_doubt_about_the_unit(tmp_path, mean, size):
    text = rows(T, size * WAVE + mean)
    warnings = motion_of(tmp_path, text, time="t", gravity="keep").warnings
    assert "record-unit" not in {one.slug for one in warnings}


@pytest.mark.parametrize(("size", "slug"), [(1000.0, "record-large"), (0.0, "record-still")])
@pytest.mark.parametrize("remove", ["nothing", "mean"])
def test_acceleration_in_millimetres_and_one_without_motion_are_named(
    tmp_path, remove, size, slug
):
    words = {"time": "t", "remove": remove}
    (warning,) = motion_of(tmp_path, rows(T, size * WAVE), **words).warnings
    assert warning.slug == slug
    fast = 300 * np.sign(np.sin(2 * np.pi * 0.24 * RATE * T))
    shock = 600 * np.sin(np.pi * np.clip(T[:60] - 0.1, 0, 0.1) / 0.1)
    for strong in (fast, shock):
        warnings = motion_of(tmp_path, rows(T[: len(strong)], strong), **words).warnings
        assert not {"record-large", "record-still"} & {each.slug for each in warnings}


@pytest.mark.parametrize("remove", ["nothing", "mean", "1 Hz"])
def test_column_that_rises_as_times_do_is_a_warning(tmp_path, remove):
    text = "t,n,a\n" + "".join(
        f"{t:.3f},{i},{a:.6f}\n" for i, (t, a) in enumerate(zip(T, WAVE, strict=True))
    )
    words = {"rate": RATE, "unit": "m/s2", "remove": remove}
    for column in ("t", "n"):
        warnings = motion_of(tmp_path, text, column=column, **words).warnings
        (warning,) = (one for one in warnings if one.slug == "record-rises")
        assert f"(`{column}`) rises evenly" in warning.sentence
    slugs = {one.slug for one in motion_of(tmp_path, text, column="a", **words).warnings}
    assert "record-rises" not in slugs


def test_one_column_cannot_be_times_and_samples(tmp_path):
    said = refused(tmp_path, "t,a\n0,1\n1,2\n", time="t", column="t", unit="m/s2")
    assert (
        said
        == "column 1 (`t`) is both `time` and `column`: select the samples; there are: `t`, `a`"
    )
