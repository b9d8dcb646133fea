"""Fits to transmissibility under random motion: estimators, twins, intervals, wrong levels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import golden
import numpy as np
import pytest
from twin import CURVE_KEYS, values_of, write_random_curves

import drysim as package
from drysim.metrics.comfort import averaging_gain, step_means
from drysim.metrics.spectra import transfer_estimate
from drysim.study import fit_spectrum_curves
from drysim.study.fit import read_model
from drysim.study.fit_spectrum_curves import Components, LocalModel, SpectrumModel
from drysim.study.gallery import list_scenarios

GALLERY = next(each.file for each in list_scenarios() if each.name == "fit-spectrum")
TRUE = dict(zip(CURVE_KEYS, (4500.0, 300.0, 32.0, 1.3125), strict=True))


def curves_of_gallery(levels: tuple[float, ...], **more: Any) -> dict[str, Any]:
    """Return the curves of the gallery with other levels and further keys."""
    return {
        "fit.curves": [
            {
                "file": "fit-spectrum-synthetic.csv", "frequency": "f", "rms": level,
                "T_a": f"T_a {column}", "T_x": f"T_x {column}", **more,
            }
            for column, level in zip(("0.6", "1.0", "1.8"), levels, strict=True)
        ]
    }  # fmt: skip


def holds(result: package.FitResult, true: dict[str, float]) -> np.ndarray:
    """Return whether the interval of each value holds the true one."""
    low = [-np.inf if p.profile_low is None else p.profile_low for p in result.parameters]
    high = [np.inf if p.profile_high is None else p.profile_high for p in result.parameters]
    values = np.array([true[p.key] for p in result.parameters])
    return (np.array(low) <= values) & (values <= np.array(high))


def test_seat_of_the_gallery_comes_back():
    result = golden.fitted(GALLERY)
    assert holds(result, TRUE).all()
    assert values_of(result)["friction.kinetic"] == pytest.approx(32.0, rel=0.02)
    *_, ratio = result.parameters
    assert ratio.profile_low is None
    assert 1.4 < ratio.profile_high < 2.0
    assert not result.warnings
    assert 100.0 < result.scatter.measured < 1200.0


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
def test_ratios_are_the_estimates_of_an_assessment_of_the_same_motion(estimator):
    # 100 samples a second are transformed, and a segment has an even number of them. Rows begin
    # next to the first line, into which the mean of a segment would leak.
    step = {"solver.step": 5e-3, "measure.segment": 2.0, "excitation.rms": 0.6}
    curves = curves_of_gallery((0.6, 0.6, 0.6), estimator=estimator)
    model = read_model(package.load(GALLERY, curves | step))
    assert isinstance(model, SpectrumModel)
    rows = model.rows
    ratios, _ = replace(model, seeds=1).ratios(np.array([list(TRUE.values())]))
    response = package.run(golden.fitted(GALLERY).scenario.at(TRUE | step)).response
    u_dd, x_dd = step_means(response)
    for i, channel in enumerate((x_dd, np.array(response.x_r)[:-1])):
        estimate = transfer_estimate(u_dd, channel, response.dt, 2.0)
        size = np.abs(getattr(estimate, estimator))
        if i == 1:
            omega = 2.0 * np.pi * estimate.f
            size = size * omega**2 * averaging_gain(estimate.f, response.dt)
        here = (rows.curve == 0) & (rows.ratio == i)
        wanted = np.interp(rows.frequency[here], estimate.f, size)
        assert ratios[0, here] == pytest.approx(wanted, rel=1e-2)


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
def test_ratios_of_a_mass_that_never_slides_are_finite(estimator):
    curves = curves_of_gallery((0.6, 1.0, 1.8), estimator=estimator)
    model = read_model(package.load(GALLERY, curves)).short
    locked = np.array([4500.0, 300.0, 1e4, 1.0])
    ratios, stuck = model.ratios(locked[None])
    assert (stuck == 1.0).all()
    assert ratios[0] == pytest.approx(np.where(model.rows.ratio == 0, 1.0, 0.0), abs=1e-6)
    assert all(np.isfinite(errors).all() for _, errors in model.scatter(locked))


@pytest.mark.parametrize(("curve", "factor"), [(1, 2.0**0.5), (2, 0.8)])
def test_a_wrong_level_is_named(curve, factor):
    levels = [0.6, 1.0, 1.8]
    levels[curve] *= factor
    result = package.fit(package.load(GALLERY, curves_of_gallery(tuple(levels))), workers=1)
    named = next(warning for warning in result.warnings if warning.slug == "bad-fit")
    start = f"the level of curves #{curve + 1} seems to be wrong: with "
    _, _, rest = named.sentence.partition(start)
    assert float(rest.split()[0]) == pytest.approx(1.0 / factor, rel=0.06)


@pytest.mark.parametrize(
    ("levels", "names"), [((1.0, 0.6, 1.8), "#1 and #2"), ((1.8, 1.0, 0.6), "#1 and #3")]
)
def test_exchanged_levels_are_named_and_no_factor(levels, names):
    result = package.fit(package.load(GALLERY, curves_of_gallery(levels)), workers=1)
    named = next(warning for warning in result.warnings if warning.slug == "bad-fit")
    assert named.sentence.endswith(f"; the levels of curves {names} seem to be exchanged")


def test_a_wrong_level_of_two_entries_is_named():
    levels = {"0.6": 0.6, "1.0": 2.0**0.5, "1.8": 1.8}
    apart = [
        {
            "file": "fit-spectrum-synthetic.csv", "frequency": "f", "rms": level,
            ratio: f"{ratio} {column}",
        }
        for column, level in levels.items() for ratio in ("T_a", "T_x")
    ]  # fmt: skip
    result = package.fit(package.load(GALLERY, {"fit.curves": apart}), workers=1)
    named = next(warning for warning in result.warnings if warning.slug == "bad-fit")
    start = "the level of curves #3 and #4 seems to be wrong: with "
    _, _, rest = named.sentence.partition(start)
    assert float(rest.split()[0]) == pytest.approx(2.0**-0.5, rel=0.06)


def test_a_stated_time_is_not_estimated(drysim, tmp_path):
    write_random_curves(tmp_path, 2, 200.0, ", duration: 200 s")
    said = drysim("fit", "twin.yaml", "--out", "out")
    assert said.code == 0
    assert "base        psd 0.5 to 20 Hz of " in said.out
    assert "fitted      H1 over 2400 s of motion at each level, seeds 201 to 320" in said.out
    assert "the signal of `excitation`" in said.out
    assert "scatter " not in said.out
    assert drysim("run", "out/fitted.yaml", "--no-plots").code == 0


def test_a_fit_that_does_not_settle_warns(monkeypatch):
    monkeypatch.setattr(fit_spectrum_curves, "MAX_POLYNOMIALS", 1)
    monkeypatch.setattr(fit_spectrum_curves, "FIRST_TAYLOR_STEP", 1e-3)
    fewer = curves_of_gallery((0.6, 1.0, 1.8)) | {"excitation.seeds": 2}
    result = package.fit(package.load(GALLERY, fewer), workers=1)
    (warning,) = (each for each in result.warnings if each.slug == "starts-disagree")
    assert "ended before its values had settled" in warning.sentence


@pytest.mark.parametrize(
    ("low", "centre", "high"),
    [(0.0, 5.0, 1e4), (0.0, 1e-10, 1e4), (4.0, 5.0, 6.0), (4.0, 5.9, 6.0), (0.0, 70.0, 75.0)],
)
def test_points_of_a_polynomial_are_within_bounds_and_apart(monkeypatch, low, centre, high):
    tried = []

    def ratios(self, values):
        tried.extend(values[:, 0].tolist())
        return np.exp(values[:, :1] ** 2 / 1e3), values[:, :1]

    curves = curves_of_gallery((0.6, 1.0, 1.8)) | {
        "fit.free": {"friction.kinetic": {"from": low, "to": high}},
        "oscillator.stiffness": 4500.0, "oscillator.damping": 300.0,
    }  # fmt: skip
    model = read_model(package.load(GALLERY, curves))
    monkeypatch.setattr(SpectrumModel, "ratios", ratios)
    local = LocalModel.about(model, np.array([centre]), np.array([50.0]))
    assert len(tried) == 3
    assert low <= min(tried) < max(tried) <= high
    assert local.coefficients[2] == pytest.approx((local.size / 50.0) ** 2 * 2.5, rel=1e-3)


def test_scatter_of_11_blocks_widens_as_student_s_t_of_10_degrees_of_freedom():
    errors = np.ones((2, 11))
    components = Components(np.zeros(2), np.ones(2), 0.0, np.ones(2), [(np.arange(2), errors)])
    widening = components.widening(np.eye(2), np.zeros(2))
    assert widening == pytest.approx(2.2281 / 1.9600, rel=1e-4)


@pytest.mark.slow
@pytest.mark.by_hand
def test_intervals_of_40_twins_hold_the_truth_in_88_percent_or_more(tmp_path):
    held, errors, scores = np.zeros(len(CURVE_KEYS)), [], []
    for seed in range(40):
        true = write_random_curves(tmp_path, seed)
        result = package.fit(package.load(tmp_path / "twin.yaml"), workers=1)
        held += holds(result, true)
        errors.append(values_of(result)["friction.kinetic"] / true["friction.kinetic"] - 1.0)
        stiffness = result.parameters[0]
        width = stiffness.profile_high - stiffness.profile_low
        scores.append((stiffness.value - true[stiffness.key]) / (width / 3.92))
    assert (held >= 35).all()
    assert np.sqrt(np.mean(np.square(errors))) < 0.02
    assert abs(np.mean(scores)) < 0.5


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("rms: 0.", "displacement: 0.",
         "#1: displacement is that of a sine, but the base motion is random; give rms"),
        ("[[0.5, 1], [20, 1]]", "[[0.5, 1], [10, 1]]",
         "the base hardly moves at 10.82 Hz: its spectrum with segments of 5 s is from 0.5 to "
         "10 Hz; leave other rows out by `rows`"),
        ("solver: {step: 5 ms}",
         "solver: {step: 5 ms}\nmeasure: {spectra: true, segment: 70}",
         "measure.segment is longer than the window of 60 s"),
        ("solver: {step: 5 ms}", "solver: {step: 5 ms, approach: moreau}",
         "curves are fitted under Coulomb friction by stick-slip"),
        ("{kind: psd, points: [[0.5, 1], [20, 1]], rms: 1, duration: 60, seed: 201}",
         "{kind: standard, class: AG1, duration: 60, seed: 1}",
         "fit.curves #1: the base hardly moves at 0.6 Hz: its spectrum with segments of 5 s"),
        ("T_x0,", "T_x0, estimator: H3,", "estimator must be H1, H2 or Hv"),
    ],
)  # fmt: skip
def test_what_is_refused(refused, tmp_path: Path, before, after, message):
    write_random_curves(tmp_path, 2, 60.0)
    file = tmp_path / "twin.yaml"
    text = file.read_text()
    assert before in text
    file.write_text(text.replace(before, after, 1))
    assert message in refused("fit", "twin.yaml")


def test_rows_of_a_table_leave_out_what_the_spectrum_does_not_reach():
    curves = curves_of_gallery((0.6, 1.0, 1.8), rows={"from": 6, "to": 40})
    curves["excitation.points"] = [[0.85, 1.0], [10.0, 1.0]]
    rows = read_model(package.load(GALLERY, curves)).rows
    assert (rows.frequency.min(), rows.frequency.max()) == (1.0, 7.8)
