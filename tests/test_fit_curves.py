"""Fits to transmissibility curves: twins come back, intervals hold, faults are named."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from seat import rows_of
from twin import CURVE_KEYS, values_of, write_curves

import drysim as package
from drysim.study import fit_curves
from drysim.study.fit_curves import read_curves
from drysim.study.gallery import list_scenarios
from drysim.study.statistics import NORMAL_95


def load(folder: Path) -> Any:
    """Return twin.yaml in a folder as a scenario."""
    return package.load(folder / "twin.yaml")


def fit_in(folder: Path) -> package.FitResult:
    """Return the fit of twin.yaml in a folder."""
    return package.fit(load(folder), workers=1)


def edit(folder: Path, *pairs: tuple[str, str]) -> None:
    """Replace texts in twin.yaml."""
    file = folder / "twin.yaml"
    text = file.read_text()
    for before, after in pairs:
        assert before in text
        text = text.replace(before, after, 1)
    file.write_text(text)


@pytest.mark.parametrize(
    "seed", [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 33))]
)
def test_digitised_curves_give_friction_to_2_and_its_static_ratio_to_5_percent(tmp_path, seed):
    true = write_curves(tmp_path, seed)
    values = values_of(fit_in(tmp_path))
    for key, error in (("friction.kinetic", 0.02), ("friction.static_ratio", 0.05)):
        assert values[key] == pytest.approx(true[key], rel=error)


@pytest.mark.slow
def test_intervals_of_100_digitised_curves_hold_the_truth_in_88_to_100_percent(tmp_path):
    held = np.zeros(len(CURVE_KEYS))
    for seed in range(100):
        true = write_curves(tmp_path, seed)
        for i, parameter in enumerate(fit_in(tmp_path).parameters):
            low = -np.inf if parameter.profile_low is None else parameter.profile_low
            high = np.inf if parameter.profile_high is None else parameter.profile_high
            held[i] += low <= true[parameter.key] <= high
    assert (held >= 88).all()


def test_other_values_that_explain_one_curve_as_well_are_named():
    file = next(each.file for each in list_scenarios() if each.name == "fit-curves")
    curve = {"file": "fit-curves-synthetic.csv", "frequency": "f", "T_a": "T_a 0.7", "rms": 0.7}
    result = package.fit(package.load(file, {"fit.curves": [curve]}), workers=1)
    (warning,) = result.warnings
    assert warning.slug == "starts-disagree"
    assert "other values explain these curves as well" in warning.sentence
    assert "friction.static_ratio 1;" in warning.sentence


def test_draws_of_a_fit_to_curves_explain_the_curves(tmp_path):
    write_curves(tmp_path, 2)
    result = fit_in(tmp_path)
    spread = 2.0 * NORMAL_95 * result.draws.values.std(axis=0)
    for parameter, width in zip(result.parameters, spread.tolist(), strict=True):
        assert parameter.profile_high - parameter.profile_low == pytest.approx(width, rel=0.2)


def test_curves_without_noise_come_back_to_rounding(tmp_path):
    true = write_curves(tmp_path, 2, ("T_a",), noise=0.0)
    result = fit_in(tmp_path)
    assert values_of(result) == pytest.approx(true, rel=1e-6)
    assert not result.warnings


@pytest.mark.parametrize(
    ("level", "power"),
    [("amplitude: 1 m/s2", 0), ("velocity: 1000 mm/s", 1), ("displacement: 100 cm", 2)],
)
def test_a_level_is_an_amplitude_of_acceleration_velocity_or_displacement(
    tmp_path, level, power
):
    write_curves(tmp_path, 2)
    rms = load(tmp_path).fit.curves[0].rms
    edit(tmp_path, (f"rms: {rms}", level))
    frequency = np.array([0.7, 3.0])
    expected = (2.0 * np.pi * frequency) ** power / np.sqrt(2.0)
    assert load(tmp_path).fit.curves[0].base_rms(frequency) == pytest.approx(expected)


def test_files_of_a_fit_to_curves_and_its_scenario_that_runs(drysim, tmp_path):
    write_curves(tmp_path, 2)
    edit(tmp_path, ("fit:\n", "sweep: {excitation.frequency: [0.5, 20]}\nfit:\n"))
    said = drysim("fit", "twin.yaml", "--out", "out")
    assert said.code == 0
    assert "T_a and T_x of lab.csv, 150 values" in said.out
    sine = next(line.split(maxsplit=3) for line in said.out.splitlines() if "  at " in line)
    assert sine == ["at", "2", "Hz", "0.5 m/s² RMS, the sine of `excitation`"]
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert {"curves.csv", "fit.csv", "fit.png", "profiles.png", "fitted.yaml"} <= names
    assert "residuals.csv" not in names
    assert "step" not in (tmp_path / "out" / "fitted.yaml").read_text()  # may differ by case
    rows = rows_of(tmp_path / "out" / "curves.csv")
    assert len(rows) == 150
    row = rows[30]
    left = float(row["measured [-]"]) - float(row["fitted [-]"])
    assert float(row["residual [-]"]) == pytest.approx(left)
    level, frequency = row["a_u [m/s2]"], row["frequency [Hz]"]
    sets = f"excitation.rms={level}", f"excitation.frequency={frequency}"
    run = ("run", "out/fitted.yaml", "--out", "again", "--set", sets[0], "--set", sets[1])
    assert drysim(*run, "--no-plots").code == 0
    metrics = json.loads((tmp_path / "again" / "drysim.json").read_text())["metrics"]
    assert metrics[row["ratio"]] == pytest.approx(float(row["fitted [-]"]), rel=1e-9)


def test_rows_in_any_order_missing_cells_percent_and_decimal_commas_change_nothing(tmp_path):
    write_curves(tmp_path, 2, ("T_a",))
    plain = fit_in(tmp_path)
    header, *lines = (tmp_path / "lab.csv").read_text().splitlines()
    cells = [[float(cell) for cell in line.split(",")] for line in reversed(lines)]
    rows = [
        ";".join([f"{f * 1e-3:.5f}", *(f"{100.0 * ratio:.1f}" for ratio in ratios)])
        for f, *ratios in cells
    ]
    rows.insert(3, "0.0031;;;")
    names = ";".join(f"{name} [%]" for name in header.split(",")[1:])
    text = "\n".join([f"f [kHz];{names}", *(row.replace(".", ",") for row in rows)])
    (tmp_path / "lab.csv").write_text(text + "\n")
    other = fit_in(tmp_path)
    assert values_of(other) == pytest.approx(values_of(plain), rel=1e-4)


def test_levels_below_each_other_in_one_column_are_told_apart_by_rows(tmp_path):
    write_curves(tmp_path, 2, ("T_a",))
    beside, _ = read_curves(load(tmp_path))
    _, *lines = (tmp_path / "lab.csv").read_text().splitlines()
    cells = [line.split(",") for line in lines]
    levels = range(len(cells[0]) - 1)
    rows = [f"L{i},{f},{ratios[i]}" for i in levels for f, *ratios in cells]
    (tmp_path / "lab.csv").write_text("\n".join(["level,f [Hz],T_a", *rows]) + "\n")
    edit(
        tmp_path,
        *((f"T_a: T_a{i}", f"T_a: T_a, rows: {{where: {{level: L{i}}}}}") for i in levels),
    )
    below, _ = read_curves(load(tmp_path))
    assert all(map(np.array_equal, below, beside))


def test_a_wrong_level_of_one_curve_is_named_and_one_of_all_scales_the_friction(
    tmp_path, monkeypatch
):
    true = write_curves(tmp_path, 2)
    levels = [curve.rms for curve in load(tmp_path).fit.curves]
    edit(tmp_path, (f"rms: {levels[1]}", f"amplitude: {levels[1]}"))
    named = next(w for w in fit_in(tmp_path).warnings if w.slug == "bad-fit")
    assert "the level of curves #2 seems to be wrong: with 1.41 times" in named.sentence
    monkeypatch.setattr(fit_curves, "MAX_SUSPECTS", 1)
    monkeypatch.setattr(fit_curves, "MAX_WITNESSES", 1)
    named = next(w for w in fit_in(tmp_path).warnings if w.slug == "bad-fit")
    assert named.sentence.endswith("; this was tried on 2 of 3 curves only")
    write_curves(tmp_path, 2)
    edit(tmp_path, *((f"rms: {level}", f"rms: {2.0 * level}") for level in levels))
    doubled = fit_in(tmp_path)
    assert not doubled.warnings
    assert values_of(doubled)["friction.kinetic"] == pytest.approx(
        2.0 * true["friction.kinetic"], rel=0.02
    )


@pytest.mark.parametrize(
    ("exchanged", "cause"),
    [
        ("columns", "T_a and T_x of curves #1, #2 and #3 seem to be exchanged"),
        ("levels", "the levels of curves #1 and #3 seem to be exchanged"),
        ("all", "check levels, columns and units of the curves"),
    ],
)
def test_exchanged_columns_or_levels_are_named_and_no_factor(
    tmp_path, monkeypatch, exchanged, cause
):
    write_curves(tmp_path, 2)
    first, _, third = [curve.rms for curve in load(tmp_path).fit.curves]
    if exchanged != "levels":
        names = [(f"T_a: T_a{i}, T_x: T_x{i}", f"T_a: T_x{i}, T_x: T_a{i}") for i in range(3)]
        edit(tmp_path, *names)
    if exchanged != "columns":
        edit(tmp_path, (f"{first}}}", "9}"), (f"{third}}}", f"{first}}}"), ("9}", f"{third}}}"))
    named = next(w for w in fit_in(tmp_path).warnings if w.slug == "bad-fit")
    assert named.sentence.endswith(cause)
    if exchanged == "columns":
        return
    # Of many curves some are tried, beside a few others.
    monkeypatch.setattr(fit_curves, "MAX_SUSPECTS", 2)
    named = next(w for w in fit_in(tmp_path).warnings if w.slug == "bad-fit")
    end = (
        "; other levels and columns were tried for curves #2 and #3 only, those of the largest "
    )
    assert named.sentence.endswith(cause + f"{end}residuals" * (exchanged == "all"))


def test_curves_with_a_free_mass_give_ratios_only_and_the_fit_ends_soon(tmp_path):
    write_curves(tmp_path, 2, ("T_a",))
    edit(tmp_path, ("free:\n", "free:\n    oscillator.mass: {}\n"))
    result = fit_in(tmp_path)
    assert [profile.key for profile in result.profiles] == ["friction.static_ratio"]
    scaled = {p.key for p in result.parameters if "only the ratios of" in p.note}
    assert {"oscillator.mass", "friction.kinetic"} <= scaled
    assert "state one of them" in result.draws.reason
    edit(tmp_path, ("    oscillator.mass: {}\n", ""))
    free, stated = (
        next(p for p in fit.parameters if p.key == "friction.static_ratio")
        for fit in (result, fit_in(tmp_path))
    )
    for end in ("profile_low", "profile_high"):
        assert getattr(free, end) == pytest.approx(getattr(stated, end), rel=1e-3)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("fit:\n", "fit:\n  measured: {file: lab.csv, time: f, x_dd: T_a0}\n",
         "fit.curves stands beside `measured`; a fit is to one of them: remove one"),
        ("fit:\n", "fit:\n  hold_out: 0.2\n", "fit.hold_out has no meaning for curves"),
        ("fit:\n", "fit:\n  laws: [coulomb]\n", "fit.laws has no meaning for curves"),
        ("friction.kinetic: {}", "friction.kinetic: {}\n    start.x_r: {}",
         "fit.free.start.x_r is not fitted to curves, only keys of oscillator or friction are"),
        ("T_a: T_a0", "T_a: T_b0", "there is no column `T_b0`"),
        ("T_x: T_x0", "T_x: 2",
         "fit.curves #1.T_x is column 2 of lab.csv, and so is fit.curves #1.T_a: each"),
        ("T_x: T_x0", "T_x: T_a1", "fit.curves #2.T_a is column 4 of lab.csv, and so is"),
        ("T_a: T_a0, T_x: T_x0, ", "", "fit.curves #1 needs T_a or T_x"),
        ("T_x: T_x0, rms: ", "T_x: T_x0, rms: -", "error: twin.yaml: 1 error"),
        ("T_a: T_a0,", "T_a: T_a0, velocity: 1,", "give rms or velocity, not both"),
        ("{kind: harmonic, frequency: 2 Hz, rms: 0.5}",
         "{kind: sweep, from: 1, to: 9, rms: 1, duration: 60}\nsolver: {step: 1 ms}",
         "the base motion of a measured curve is a sine, or random"),
        ("T_x0,", "T_x0, estimator: Hv,", "#1: estimator has no meaning under a sine"),
        ("fit:", "stroke: {limit: 20 mm, stops: {restitution: 0.5}}\nfit:",
         "curves are fitted under Coulomb friction by stick-slip, without end stops"),
    ],
)  # fmt: skip
def test_what_is_refused(refused, tmp_path, before, after, message):
    write_curves(tmp_path, 2)
    edit(tmp_path, (before, after))
    assert message in refused("fit", "twin.yaml")


@pytest.mark.parametrize(
    ("header", "cell", "message"),
    [
        ("T_a0", "n.a.", "`n.a.` is not a number; leave the cell empty if it has none"),
        ("T_a0", "0", "must be above 0, not 0; leave the cell empty where the mass sticks"),
        ("T_a0", "-3.1", "a ratio of RMS values must be above 0, not -3.1; of values in dB"),
        ("T_a0 [dB]", "0.9", "is in dB: write the ratio, 10^(dB/20)"),
        ("T_a0", "0.9,1,1,1,1,1\n5", "row 3 has 6 cells, not 7; delete the row"),
        ("T_a0 [m]", "0.9", "`m` is a unit of length"),
    ],
)
def test_a_file_with_other_numbers_is_refused(refused, tmp_path, header, cell, message):
    write_curves(tmp_path, 2)
    names, first, *lines = (tmp_path / "lab.csv").read_text().splitlines()
    cells = first.split(",")
    cells[1] = cell
    names = names.replace("T_a0", header)
    (tmp_path / "lab.csv").write_text("\n".join([names, ",".join(cells), *lines]) + "\n")
    assert message in refused("fit", "twin.yaml")


def test_curves_of_a_mass_that_never_slides_determine_nothing(drysim, tmp_path):
    write_curves(tmp_path, 2, ("T_a",))
    names, *lines = (tmp_path / "lab.csv").read_text().splitlines()
    locked = [f"{line.partition(',')[0]},1,1,1" for line in lines]
    (tmp_path / "lab.csv").write_text("\n".join([names, *locked]) + "\n")
    said = drysim("fit", "twin.yaml")
    assert said.code == 3
    assert "the mass moves with the base in all rows of the curves" in said.err
