"""Sweeps and comparisons over many seeds: the same seeds everywhere, means with intervals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from drysim.scenario.load import load
from drysim.study import ensemble
from drysim.study.compare import compare
from drysim.study.ensemble import run
from drysim.study.run import Motions
from drysim.study.statistics import interval
from drysim.study.sweep import sweep
from seat import rows_of

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45}
stroke: {limit: 5 mm}
excitation: {kind: psd, points: [[0.5, 1], [10, 1]], rms: 0.67, duration: 10, seed: 3, seeds: 5}
solver: {step: 5e-3}
sweep:
  friction.kinetic: [15, 45]
  excitation.rms: [0.5, 0.67]
reference: viscous
"""


@pytest.fixture
def noisy(tmp_path):
    """Write a small random sweep."""
    file = tmp_path / "noisy.yaml"
    file.write_text(SEAT)
    return file


def test_every_case_is_the_ensemble_of_that_case_alone(noisy):
    table = sweep(load(noisy))
    for row in table.own:
        alone = {**row.point, "sweep": None, "reference": None}
        many = run(load(noisy, alone))
        assert row.seeds == 5
        assert row.metrics == many.metrics
        assert row.over.T_a == tuple(one.metrics["T_a"] for one in many.rows)
        assert row.half_widths["T_a"] == many.statistics["T_a"].half_width


def test_every_case_and_the_reference_have_the_same_seeds(noisy):
    table = sweep(load(noisy, {"sweep": {"friction.kinetic": [15, 45]}}))
    assert len({row.over.sha256 for row in table.rows}) == 1
    assert {row.approach for row in table.rows} == {"stick-slip", "viscous"}


def test_a_sweep_does_not_depend_on_the_number_of_workers(noisy):
    wish = {
        "excitation.until": {"metric": "T_a", "half_width": "0.6 %"},
        "excitation.seeds": 24,
    }
    tables = [sweep(load(noisy, wish), workers=workers) for workers in (1, 3, 8)]
    one, *others = ([vars(row) for row in table.rows] for table in tables)
    assert others == [one, one]
    assert len({row["over"].count for row in one}) > 1, "cases differ in how many they need"


def test_one_case_is_many_seeds_side_by_side(noisy):
    alone = {"sweep": {"friction.kinetic": [15]}, "reference": None, "excitation.seeds": 20}
    one, four = (sweep(load(noisy, alone), workers=workers) for workers in (1, 4))
    assert vars(one[0]) == vars(four[0])


def test_columns_tell_how_well_the_means_are_known(drysim, noisy, tmp_path):
    assert drysim("sweep", noisy).code == 0
    found = rows_of(tmp_path / "out" / "noisy" / "transmissibility.csv")
    table = sweep(load(noisy))
    for cells, row in zip(found, table.rows, strict=True):
        assert cells["seeds [-]"] == "5"
        assert float(cells["T_a [-]"]) == row.metrics["T_a"]
        for name in ("T_a", "T_x", "stuck_share"):
            assert float(cells[f"{name}_half_width [-]"]) == row.half_widths[name]
    told = json.loads((tmp_path / "out" / "noisy" / "drysim.json").read_text())
    assert told["numerics"]["seeds"] == {"least": 5, "greatest": 5}
    assert told["metrics"]["T_a"]["least"]["half_width"] > 0


def test_columns_of_single_seeds_are_as_they_were(drysim, noisy, tmp_path):
    drysim("sweep", noisy, "--no-plots", "--set", "excitation.seeds=null")
    (first, *_) = rows_of(tmp_path / "out" / "noisy" / "transmissibility.csv")
    assert [*first][-1] == "status"


def test_checks_of_a_sweep_judge_means_and_name_what_is_not_decided(noisy):
    T_a = min(row.metrics["T_a"] for row in sweep(load(noisy)).own)
    table = sweep(load(noisy, {"checks": [f"T_a > {T_a + 1e-5}", "T_a < 1.5"]}))
    failed, passed = table.checks
    assert (failed.passed, failed.seeds, passed.passed) == (False, 5, True)
    assert failed.undecided
    (caution,) = [one for one in table.warnings if one.slug == "check-undecided"]
    assert "is not decided in 1 of 4 cases, the first at kinetic 15 N, " in caution.sentence


def test_a_summary_tells_seeds_and_intervals(drysim, noisy):
    answer = drysim("sweep", noisy, "--no-plots")
    assert "seeds       5 in every case, from 3 to 7; values are means" in answer.out
    assert "at the worst: 0." in answer.out
    assert "with some seeds" in answer.err
    plan = drysim("sweep", noisy, "--dry-run").out
    assert plan.startswith("noisy: 4 cases by stick-slip and viscous, each 5 seeds;")


def test_the_number_of_seeds_may_be_swept(noisy):
    table = sweep(load(noisy, {"sweep": {"excitation.seeds": [2, 8]}, "reference": None}))
    assert [row.seeds for row in table.rows] == [2, 8]
    # Few seeds are solved one by one, many by blocks: rounding may tell.
    assert table[0].over.T_a == pytest.approx(table[1].over.T_a[:2], rel=1e-13)


def test_deviations_are_paired_by_seed(drysim, noisy, tmp_path):
    made = compare(load(noisy, {"sweep": None, "reference": None}), ["smooth", "stick-slip"])
    smooth, exact, _ = made.table.rows
    pairs = zip(smooth.over.T_a, exact.over.T_a, strict=True)
    paired = interval([own / theirs - 1 for own, theirs in pairs])
    assert made.off(smooth) == paired
    apart = np.hypot(
        *(row.half_widths["T_a"] / exact.metrics["T_a"] for row in (smooth, exact))
    )
    assert paired[1] < apart, "the same noise cancels"
    words = ("--set", "sweep=null", "--set", "reference=null")
    answer = drysim("compare", "smooth", "vs", "stick-slip", "-s", noisy, *words)
    assert " ± " in answer.out
    found = rows_of(tmp_path / "out" / "noisy-compare" / "comparison.csv")
    assert float(found[0]["T_a_deviation [-]"]) == paired[0]
    assert float(found[0]["T_a_deviation_half_width [-]"]) == paired[1]


def test_a_case_fails_with_one_of_its_seeds(noisy):
    noisy.write_text(
        "oscillator: {mass: 1, stiffness: 100, damping: 300}\n"
        "friction: {law: coulomb, kinetic: 1}\n"
        "excitation: {kind: psd, points: [[0.5, 1], [10, 1]], duration: 3.4, seeds: 8}\n"
        "solver: {approach: signum, step: 1e-2, signum: {method: euler}}\n"
        "sweep: {oscillator.damping: [100, 300]}\n"
    )
    table = sweep(load(noisy))
    good, failed = table.rows
    assert (good.status, failed.status, failed.metrics["T_a"]) == ("ok", "failed", None)
    assert "of 8 seeds, the first " in failed.note
    assert table.exit_code() == 3


def test_an_interrupted_sweep_goes_on_where_it_was(drysim, noisy, tmp_path, monkeypatch):
    assert drysim("sweep", noisy, "--no-plots", "--out", "whole").code == 0
    one_seed, count = ensemble.row_of_seed, 0

    def stopped(*words):
        nonlocal count
        count += 1
        if count == 13:
            raise KeyboardInterrupt
        return one_seed(*words)

    monkeypatch.setattr(ensemble, "row_of_seed", stopped)
    answer = drysim("sweep", noisy, "--no-plots", "--out", "part", "--workers", 1)
    assert answer.code == 130
    assert "2 finished cases are kept" in answer.err
    assert "  state       incomplete: 2 of 6 cases\n" in answer.out
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert drysim("sweep", noisy, "--no-plots", "--out", "part", "--resume").code == 0
    one, other = (tmp_path / name / "transmissibility.csv" for name in ("whole", "part"))
    assert one.read_bytes() == other.read_bytes()


def test_seeds_that_a_run_has_left_do_not_disturb_a_sweep(drysim, noisy, tmp_path, monkeypatch):
    def stopped(scenario, seed, *words):
        if seed == 5:
            raise KeyboardInterrupt
        return one_seed(scenario, seed, *words)

    one_seed = ensemble.row_of_seed
    monkeypatch.setattr(ensemble, "row_of_seed", stopped)
    assert drysim("run", noisy, "--no-plots", "--workers", 1).code == 130
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert drysim("sweep", noisy, "--no-plots", "--resume").code == 0
    found = rows_of(tmp_path / "out" / "noisy" / "transmissibility.csv")
    exact = sweep(load(noisy))
    assert [float(row["T_a [-]"]) for row in found] == [row.metrics["T_a"] for row in exact]
    assert not (tmp_path / "out" / "noisy.partial").exists()


def test_base_motions_are_made_once_for_all_cases(noisy, monkeypatch):
    made = []
    monkeypatch.setattr(
        "drysim.study.run.base_motion", lambda one: made.append(one) or drawn(one)
    )
    from drysim.study.case import base_motion as drawn

    sweep(load(noisy, {"sweep": {"friction.kinetic": [5, 15, 25, 35, 45]}}), workers=1)
    seeds = [scenario.excitation.seed for scenario in made]
    assert sorted(seeds) == [3, 4, 5, 6, 7]


def test_seeds_that_do_not_fit_are_not_kept(noisy):
    from drysim.study.case import prepare

    case = prepare(load(noisy, {"excitation.seeds": 100_000}))
    assert Motions.beginning_with(case).most < 10
