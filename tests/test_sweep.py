"""Sweeps: every case in order, whatever the workers, the interruptions and the statuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from seat import fields_of, rows_of
from shown import show

from drysim import output
from drysim.errors import ScenarioError
from drysim.metrics.checks import Check
from drysim.plots.sweep import draw_stroke
from drysim.results import sweep as sweep_kind
from drysim.results import tables
from drysim.results.sweep import transmissibility_text, write_transmissibility_csv
from drysim.scenario.load import load
from drysim.study import plan as study_plan
from drysim.study import statistics
from drysim.study import sweep as tally_sweep
from drysim.study.compare import compare
from drysim.study.ensemble import run
from drysim.study.plan import CaseRanges, approaches_of, solve_range
from drysim.study.preparation import prepare
from drysim.study.run import MotionCache
from drysim.study.statistics import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, Batch, Row, interval
from drysim.study.store import Store, work_identity
from drysim.study.sweep import partial_table, solve, sweep
from drysim.study.table import Table, Tally

GRID = """\
drysim: 1
name: grid
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
stroke: {limit: 16 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
sweep:
  excitation.frequency: {from: 1, to: 4, step: 1}
  friction.kinetic: [15, 45]
reference: viscous
checks: [T_a < 1.6, T_a < 0.9 at excitation.frequency >= 4]
"""


@pytest.fixture
def grid(tmp_path: Path) -> Path:
    """Write a small sweep."""
    file = tmp_path / "grid.yaml"
    file.write_text(GRID)
    return file


def as_written(table: Table) -> list[Row]:
    """Return the rows with everything that a file would hold of them."""
    return [
        Row(dict(row.point), row.approach, row.F_fk, row.F_fs, dict(row.metrics), row.status)
        for row in table.rows
    ]


def test_first_key_varies_fastest_and_the_reference_comes_last(grid):
    table = sweep(load(grid))
    own = list(table.of("stick-slip"))
    assert [tuple(row.point.values()) for row in own] == [
        (f, F) for F in (15.0, 45.0) for f in (1.0, 2.0, 3.0, 4.0)
    ]
    assert [row.F_fk for row in own] == [15.0] * 4 + [45.0] * 4
    reference = list(table.of("viscous"))
    assert list(table.rows[-len(reference) :]) == reference
    assert [dict(row.point) for row in reference] == [
        {"excitation.frequency": f} for f in (1.0, 2.0, 3.0, 4.0)
    ]
    alone = run(load(grid, {"excitation.frequency": 3, "friction.kinetic": 45})).metrics
    assert {name: alone[name] for name in own[6].metrics} == dict(own[6].metrics)
    first, second = table.checks
    worst = max(own, key=lambda row: row.metrics["T_a"])
    assert (first.value, first.where) == (worst.metrics["T_a"], dict(worst.point))
    assert second.where["excitation.frequency"] == 4.0


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_table_does_not_depend_on_the_workers(grid, workers):
    assert as_written(sweep(load(grid), workers=workers)) == as_written(sweep(load(grid)))


@pytest.mark.parametrize("overrides", [(), ("sweep.direction=both",)])
def test_interrupted_sweep_goes_on_to_the_very_same_table(grid, tmp_path, overrides):
    scenario = load(grid, overrides)
    whole = sweep(scenario)
    case, every = prepare(scenario), list(CaseRanges(approaches_of(scenario)))
    store = Store(tmp_path / "cases", work_identity(scenario), resume=False)
    for case_range in every:
        store.write(case_range, solve_range(case_range, MotionCache()))
    # A power cut may leave a file that was never written through.
    file = store.file(every[-1])
    file.write_bytes(file.read_bytes()[:-17])
    computed = []
    again = Store(tmp_path / "cases", work_identity(scenario), resume=True)
    resumed = solve(case, store=again, finished=lambda batch: computed.append(batch.first))
    assert as_written(resumed) == as_written(whole)
    assert computed == [every[-1].first]
    assert as_written(partial_table(case, again)) == as_written(whole)


NOISE = "{kind: standard, class: EM3, duration: 2 s, seed: 1}"


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("friction.static_ratio=1.4", "sweep.direction=both"),
        ("stroke={limit: {up: 15 mm, down: 20 mm}}",),
        (
            f"excitation={NOISE}",
            "checks=[]",
            "sweep={excitation.seeds: [2, 3], friction.kinetic: [10, 40]}",
        ),
        (
            f"excitation={NOISE}",
            "checks=[]",
            "excitation.seeds=2",
            "sweep={friction.kinetic: [10, 40]}",
        ),
        (
            f"excitation={NOISE}",
            "checks=[]",
            "sweep={excitation.seed: [3, 5]}",
            "measure={weighting: Wk}",
        ),
    ],
)
def test_text_that_workers_format_is_that_of_the_table(grid, tmp_path, overrides, monkeypatch):
    case = prepare(load(grid, overrides), swept=True)
    write_transmissibility_csv(solve(case, workers=1), tmp_path / "transmissibility.csv")
    expected = (tmp_path / "transmissibility.csv").read_bytes()
    for module in (tables, sweep_kind, tally_sweep, statistics):
        monkeypatch.setattr(module, "MAX_CACHED_ROWS", 1)
    as_text = transmissibility_text(case.scenario)
    assert as_text is not None
    every = list(CaseRanges(approaches_of(case.scenario)))
    # Some blocks are there without their text, some with it, as after an interruption.
    store = Store(tmp_path / "cases", work_identity(case.scenario), resume=False)
    solve(case, store=store, as_text=as_text)
    for case_range in every[::3]:
        store.write(case_range, solve_range(case_range, MotionCache()))
    store.file(every[-1]).unlink()
    for resume, columns in ((True, as_text), (False, as_text), (False, None)):
        again = Store(tmp_path / "cases", work_identity(case.scenario), resume)
        table = solve(case, workers=2, store=again, as_text=columns)
        write_transmissibility_csv(table, tmp_path / "transmissibility.csv")
        assert (tmp_path / "transmissibility.csv").read_bytes() == expected
    marked = solve(case, workers=1, store=store, as_text=lambda batch: b"mark\n")
    write_transmissibility_csv(marked, tmp_path / "transmissibility.csv")
    assert (tmp_path / "transmissibility.csv").read_bytes() == expected  # nothing is missing
    empty = Store(tmp_path / "cases", work_identity(case.scenario), resume=False)
    marked = solve(case, workers=1, store=empty, as_text=lambda batch: b"mark\n")
    write_transmissibility_csv(marked, tmp_path / "transmissibility.csv")
    assert (tmp_path / "transmissibility.csv").read_bytes().count(b"mark\n") == len(every)


def test_blocks_of_another_sweep_is_refused(grid, tmp_path):
    from drysim.errors import UsageError

    Store(tmp_path / "cases", work_identity(load(grid)), resume=False)
    other = load(grid, {"oscillator.mass": 76})
    with pytest.raises(UsageError, match="cases of other work"):
        Store(tmp_path / "cases", work_identity(other), resume=True)


def test_stroke_violations_are_summed_up_with_their_worst_case(grid):
    table = sweep(load(grid, {"stroke.limit": 0.010}))
    found = [warning for warning in table.warnings if warning.slug == "stroke-violated"]
    assert len(found) == 1
    assert "10 mm" in found[0].sentence
    assert found[0].numbers["cases"] == sum(
        bool(row.metrics["violations"]) for row in table.of("stick-slip")
    )


def test_sweep_fails_where_one_case_does_not_settle(grid):
    """Without damping, friction below π/4 of the force lets resonance grow without end."""
    words = {
        "oscillator.damping": 0,
        "stroke": {"limit": 0.9},
        "sweep": {"friction.kinetic": [10, 1000]},
        "excitation.frequency": 1.5915494309189535,
        "reference": None,
        "checks": ["x_r_peak < 0.9 m", "x_r_peak < 0.9 m at status == ok"],
    }
    table = sweep(load(grid, words))
    assert [row.status for row in table] == ["not settled", "ok"]
    assert table[0].metrics["T_a"] is None
    assert "not-settled" in [warning.slug for warning in table.warnings]
    assert table.checks[0].reason == "not settled: x_r_peak is not known"
    assert [verdict.passed for verdict in table.checks] == [False, True]
    assert table.checks[0].where == {"friction.kinetic": 10.0}
    assert table.exit_code() == 1


def test_scenario_without_a_sweep_says_so(grid):
    grid.write_text(GRID[: GRID.index("sweep:")])
    with pytest.raises(ScenarioError) as fault:
        approaches_of(load(grid))
    assert "sweep" in fault.value.problems[0].sentence


def test_spectra_that_only_a_run_gives_are_told_of(grid):
    noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 1, duration: 10, seed: 3}"
    text = GRID.replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", noise)
    text = text.replace("  excitation.frequency: {from: 1, to: 4, step: 1}\n", "")
    grid.write_text(text.replace(", T_a < 0.9 at excitation.frequency >= 4", ""))
    slugs = [warning.slug for warning in sweep(load(grid, {"measure.spectra": True})).warnings]
    assert "spectra-left-out" in slugs


# A stroke limit that is swept: every case is judged by its own, never by that of the file.


SEAT = """\
name: seat
oscillator: {mass: 80, stiffness: 6000, damping: 250}
friction: {law: coulomb, kinetic: 30, static: 40}
stroke: {limit: 15 mm}
excitation: {kind: harmonic, frequency: 1.7 Hz, rms: 1.5 m/s2}
solver: {step: 2 ms}
"""
PEAK = 34.42  # mm, whatever the limit


@pytest.fixture
def swept(scenario):
    """Return the table of the seat over some swept keys, stops as a file says them."""

    def solved(words, stops=""):
        text = SEAT.replace("15 mm", f"15 mm{stops}")
        return sweep(scenario(f"{text}sweep: {words}\n"))

    return solved


def said(table, capsys):
    """Return the summary of a table, every run of blanks as one."""
    show(table)
    return " ".join(capsys.readouterr().out.split())


def limits(figure):
    """Return the stroke limits that a picture draws, as the points of each curve."""
    dashed = [
        line for axes in figure.axes for line in axes.lines if line.get_linestyle() == "--"
    ]
    level = [line for line in dashed if len({*line.get_xdata()}) > 1]
    return [list(map(float, line.get_ydata())) for line in level]


def test_summary_holds_every_case_to_its_own_limit(swept, capsys):
    table = swept("{stroke.limit: [10 mm, 20 mm, 50 mm, 100 mm]}")
    out = said(table, capsys)
    assert f"peak |x_r| {PEAK} mm 344 % of the stroke limit, at limit 10 mm" in out
    assert f"limit in 2 of 4 cases exceeded by up to {PEAK - 10:.2f} mm" in out
    (warning,) = [one for one in table.warnings if one.slug == "stroke-violated"]
    assert warning.sentence == (
        f"the stroke limit is exceeded in 2 of 4 cases; |x_r| reaches {PEAK} mm at limit 10 mm"
    )
    assert warning.numbers["limit"] == 0.01


def test_case_that_uses_the_most_of_its_own_limit_is_told_beside_the_peak(swept, capsys):
    out = said(swept("{stroke.limit: [100 mm, 10 mm]}"), capsys)
    assert f"peak |x_r| {PEAK} mm 34.4 % of the stroke limit, at limit 100 mm" in out
    assert "344 % largest share of the stroke limit, at limit 10 mm" in out
    assert f"by up to {PEAK - 10:.2f} mm" in out


def test_rigid_stops_use_all_of_any_limit_and_no_more(swept, capsys):
    out = said(swept("{stroke.limit: [6 mm, 30 mm]}", ", stops: {restitution: 0.4}"), capsys)
    assert "peak |x_r| 30 mm 100 % of the stroke limit, at limit 30 mm" in out
    assert "largest share" not in out


def test_limit_with_one_value_is_not_told_as_that_of_the_file(swept, capsys):
    out = said(swept("{stroke.limit: [30 mm]}", ", stops: {restitution: 0.4}"), capsys)
    assert "15 mm" not in out


def test_picture_draws_the_own_limit_of_every_line(swept):
    words = "{excitation.frequency: [1, 1.5, 2, 3, 4], stroke.limit: [10 mm, 30 mm]}"
    figure = draw_stroke(swept(words))
    assert [set(line) for line in limits(figure)] == [{10.0}, {30.0}]
    many = ", ".join(f"{limit} mm" for limit in range(10, 20))
    assert not limits(draw_stroke(swept(words.replace("10 mm, 30 mm", many))))


# Sweeps and comparisons over many seeds: the same seeds everywhere, means with intervals.


SEEDS_SEAT = """\
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
    file.write_text(SEEDS_SEAT)
    return file


def test_every_case_is_the_ensemble_of_that_case_alone(noisy):
    table = sweep(load(noisy))
    for row in table.own:
        alone = {**row.point, "sweep": None, "reference": None}
        many = run(load(noisy, alone))
        assert row.seeds == 5
        assert row.metrics == many.metrics
        assert row.over.values["T_a"] == [one.metrics["T_a"] for one in many.rows]
        assert row.half_widths["T_a"] == many.statistics["T_a"].half_width


def test_every_case_and_the_reference_have_the_same_seeds(noisy, monkeypatch):
    observed = study_plan.observe_motion
    drawn = []

    def noted(case, start):
        drawn.append(case.motion.u_dd.tobytes())
        return observed(case, start)

    monkeypatch.setattr(study_plan, "observe_motion", noted)
    table = sweep(load(noisy, {"sweep": {"friction.kinetic": [15, 45]}}), workers=1)
    every = [drawn[at : at + 5] for at in range(0, len(drawn), 5)]
    assert len(every) == len(table.rows) == 3
    assert all(one == every[0] for one in every)
    assert len(set(every[0])) == 5
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


def test_columns_and_summary_tell_how_well_the_means_are_known(drysim, noisy, tmp_path):
    answer = drysim("sweep", noisy, "--no-plots")
    assert answer.code == 0
    assert "seeds       5 in every case, from 3 to 7; values are mean" in answer.out
    assert "widest interval: 0." in answer.out
    assert "exceeded in 2 of 4 cases; up to 191 % of it is used at kinetic 15 N" in answer.err
    plan = drysim("sweep", noisy, "--dry-run").out
    assert plan.startswith("noisy: 4 cases by stick-slip and viscous, each 5 seeds;")
    found = rows_of(tmp_path / "out" / "noisy" / "transmissibility.csv")
    table = sweep(load(noisy))
    for cells, row in zip(found, table.rows, strict=True):
        assert cells["seeds [-]"] == "5"
        assert float(cells["T_a [-]"]) == row.metrics["T_a"]
        for name in ("T_a", "T_x", "stuck_share"):
            assert float(cells[f"{name}_half_width [-]"]) == row.half_widths[name]
    told = fields_of(tmp_path / "out" / "noisy")
    assert told["numerics"]["seeds"] == {"least": 5, "greatest": 5}
    assert told["metrics"]["T_a"]["least"]["half_width"] > 0
    drysim("sweep", noisy, "--no-plots", "--set", "excitation.seeds=null")
    (first, *_) = rows_of(tmp_path / "out" / "noisy" / "transmissibility.csv")
    assert [*first][-1] == "status"


def test_checks_of_a_sweep_judge_means_and_name_what_is_not_decided(noisy):
    T_a = min(row.metrics["T_a"] for row in sweep(load(noisy)).own)
    table = sweep(load(noisy, {"checks": [f"T_a > {T_a + 1e-5}", "T_a < 1.5"]}))
    failed, passed = table.checks
    assert (failed.passed, failed.seeds, passed.passed) == (False, 5, True)
    assert failed.undecided
    (warning,) = [one for one in table.warnings if one.slug == "check-undecided"]
    assert "is undecided in 1 of 4 cases, the first at kinetic 15 N, " in warning.sentence


def test_the_number_of_seeds_may_be_swept(noisy):
    table = sweep(load(noisy, {"sweep": {"excitation.seeds": [2, 8]}, "reference": None}))
    assert [row.seeds for row in table.rows] == [2, 8]
    # Few seeds are solved one by one, many by blocks: rounding may tell.
    assert table[0].over.values["T_a"] == pytest.approx(
        table[1].over.values["T_a"][:2], rel=1e-13
    )


def test_deviations_are_paired_by_seed(drysim, noisy, tmp_path):
    made = compare(load(noisy, {"sweep": None, "reference": None}), ["smooth", "stick-slip"])
    smooth, exact, _ = made.table.rows
    pairs = zip(smooth.over.values["T_a"], exact.over.values["T_a"], strict=True)
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
    assert "of 8 seeds failed, the first is seed " in failed.note
    assert table.exit_code() == 3


def test_an_interrupted_sweep_goes_on_where_it_was(drysim, noisy, tmp_path, monkeypatch):
    assert drysim("sweep", noisy, "--no-plots", "--out", "whole").code == 0
    solve_seeds, count = study_plan.solve_seeds, 0

    def stopped(*words):
        nonlocal count
        count += 1
        if count == 3:
            raise KeyboardInterrupt
        return solve_seeds(*words)

    monkeypatch.setattr(study_plan, "solve_seeds", stopped)
    checks = "--set", "checks=[T_a < 1e9, T_a < 1e-9]"
    answer = drysim("sweep", noisy, "--no-plots", "--out", "part", "--workers", 1, *checks)
    assert answer.code == 130
    assert "2 finished cases are kept" in answer.err
    assert "  state       incomplete: 2 of 6 cases\n" in answer.out
    assert "· skipped   T_a < 1e9; not decided before all cases are computed" in answer.out
    assert "✗ fails     T_a < 1e-9 in 2 of 2 cases" in answer.out
    assert "best " not in answer.out
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    assert drysim("sweep", noisy, "--no-plots", "--out", "part", "--resume", *checks).code == 1
    one, other = (tmp_path / name / "transmissibility.csv" for name in ("whole", "part"))
    assert one.read_bytes() == other.read_bytes()


def test_seeds_that_a_run_has_left_do_not_disturb_a_sweep(drysim, noisy, tmp_path, monkeypatch):
    def stopped(case, case_range, motions):
        if case_range.begin == 2:
            raise KeyboardInterrupt
        return solve_seeds(case, case_range, motions)

    solve_seeds = study_plan.solve_seeds
    monkeypatch.setattr(study_plan, "solve_seeds", stopped)
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
    from drysim.study.preparation import base_motion as drawn

    sweep(load(noisy, {"sweep": {"friction.kinetic": [5, 15, 25, 35, 45]}}), workers=1)
    seeds = [scenario.excitation.seed for scenario in made]
    assert sorted(seeds) == [3, 4, 5, 6, 7]


def test_seeds_that_do_not_fit_are_not_kept(noisy):
    case = prepare(load(noisy, {"excitation.seeds": 100_000}))
    assert MotionCache.starting_with(case).max_size < 10


# What many cases come to, gathered block by block, is what all of them come to at once.


@pytest.fixture
def tally_many(grid: Path):
    """Return a sweep of some hundred cases."""
    axes = {
        "excitation.frequency": {"from": 1, "to": 4, "step": 0.1},
        "friction.kinetic": [15, 45],
        "excitation.rms": {"from": 0.5, "to": 1, "count": 10},
    }
    checks = ["T_a < 1.6", "T_a < 0.9 at excitation.frequency >= 3.95"]
    return load(grid, {"sweep": axes, "checks": checks})


def test_tally_does_not_depend_on_the_blocks(tally_many):
    table = tally_sweep.sweep(tally_many)
    whole = next(iter(table.tallies.values()))
    own = [row for row in table if row.approach == "stick-slip"]
    small = Tally("stick-slip", tally_many.checks)
    for at in range(0, len(own), 7):
        small.add(Batch.of(at, own[at : at + 7]))
    for name, ends in whole.extremes.items():
        assert [one.value for one in ends] == [one.value for one in small.extremes[name]]
        points = [one.row.point for one in small.extremes[name]]
        assert [one.row.point for one in ends] == points
    for name in ("verdicts", "cases", "beyond", "forces"):
        assert getattr(whole, name) == getattr(small, name)


def test_extremes_are_the_first_of_their_kind(tally_many):
    table = tally_sweep.sweep(tally_many)
    own = list(table.of("stick-slip"))
    for metric in ("T_a", "x_r_peak", "stuck_share"):
        least, most = next(iter(table.tallies.values())).extremes[metric]
        values = [row.metrics[metric] for row in own]
        assert least.row.point == own[values.index(min(values))].point
        assert most.row.point == own[values.index(max(values))].point
    rows = list(table)
    for i in (0, 333, len(rows) - 1):
        assert table[i] == rows[i]


def test_cases_without_numbers_are_counted_by_their_reason():
    good = Row({"a": 1.0}, "stick-slip", 1.0, 1.0, {"T_a": 2.0})
    lost = [Row({"a": float(i)}, "stick-slip", 1.0, 1.0, {}, FAILED, "no") for i in (2, 3)]
    tally = Tally("stick-slip")
    tally.add(Batch.of(0, [good, *lost]))
    assert (tally.lost[FAILED].cases, tally.lost[FAILED].first.note) == (2, "no")
    assert tally.extremes["T_a"][0].row.point == {"a": 1.0}


@pytest.mark.parametrize("status", [NOT_SETTLED, NOT_UNIQUE, FAILED])
def test_case_without_metrics_fails_the_checks_that_apply_to_it(status):
    good, lost = ({"friction.kinetic": force} for force in (1000.0, 10.0))
    rows_ = [
        Row(good, "stick-slip", 1.0, 1.0, {"x_r_peak": 0.0}),
        Row(lost, "stick-slip", 1.0, 1.0, {}, status, "no"),
    ]
    texts = {
        "x_r_peak < 1 m": False,
        "x_r_peak < 1 m at friction.kinetic < 11": False,
        "x_r_peak < 1 m at friction.kinetic > 11": True,
        "x_r_peak < 1 m at status == ok": True,
        "x_r_peak < 1 m at friction.kinetic > 0 and status == ok": True,
        "x_r_peak < 1 m at status == ok and friction.kinetic < 11": False,
    }
    for order in (rows_, rows_[::-1]):
        tally = Tally("stick-slip", tuple(map(Check.parse, texts)))
        tally.add(Batch.of(0, order))
        assert dict(zip(texts, (v.passed for v in tally.verdicts), strict=True)) == texts
        every, here, *_, none = tally.verdicts
        assert every.where == here.where == lost
        assert every.described_value == f"{status}: x_r_peak is not known"
        assert none.described_value == "no case meets the condition"


def test_large_table_is_written_as_a_small_one(tally_many, tmp_path, monkeypatch):
    table = tally_sweep.sweep(tally_many)
    kept = output.write(table, tmp_path / "a", plots=False, command="", exit_code=0)
    monkeypatch.setattr(tables, "MAX_CACHED_ROWS", 10)
    other = output.write(table, tmp_path / "b", plots=False, command="", exit_code=0)
    assert kept["files"] == other["files"]
    cells = rows_of(tmp_path / "a/transmissibility.csv")
    assert cells[-1]["friction.kinetic [N]"] == ""
    assert {row["violations [-]"] for row in cells} >= {"0", "2"}


def test_blocks_on_the_disk_give_the_table_that_blocks_at_hand_give(
    tally_many, tmp_path, monkeypatch
):
    monkeypatch.setattr(tally_sweep, "MAX_CACHED_ROWS", 0)
    monkeypatch.setattr(statistics, "MAX_CACHED_ROWS", 0)
    store = Store(tmp_path / "cases", work_identity(tally_many), resume=False)
    table = tally_sweep.solve(prepare(tally_many), store=store)
    assert list(table) == list(tally_sweep.sweep(tally_many))
    assert all(row.status == OK for row in table.rows[:5])


def test_summary_of_a_table_on_the_disk_is_shown_after_its_store_is_gone(
    drysim, tmp_path, monkeypatch
):
    (tmp_path / "grid.yaml").write_text(GRID)
    whole = drysim("sweep", "grid.yaml", "--no-plots")
    for module in (tally_sweep, statistics):
        monkeypatch.setattr(module, "MAX_CACHED_ROWS", 0)
    assert drysim("sweep", "grid.yaml", "--no-plots") == whole
    assert "isolation" in whole.out


@pytest.mark.parametrize("key", ["damping", "kinetic", "static"])
def test_steady_sweep_over_a_value_of_one_direction_gives_the_single_cases(scenario, key):
    pair, plain = "{extension: 40, compression: 60}", {"kinetic": 30, "static": 60}
    plain |= {"damping": 500, key: pair}
    block = "oscillator" if key == "damping" else "friction"
    text = f"""\
drysim: 1
oscillator: {{mass: 75, stiffness: 7500, damping: {plain["damping"]}}}
friction: {{law: coulomb, kinetic: {plain["kinetic"]}, static: {plain["static"]}}}
excitation: {{kind: sines, components: [{{amplitude: 1, frequency: 1.6}}]}}
solver: {{step: 5e-3}}
measure: {{steady: true}}
sweep: {{{block}.{key}.extension: [42, 50]}}
"""
    rows = list(sweep(scenario(text)).rows)
    assert [row.status for row in rows] == [OK, OK]
    for row in rows:
        single = run(scenario(text, row.point)).metrics
        assert row.metrics["T_a"] == pytest.approx(single["T_a"], rel=1e-9)
    assert rows[0].metrics["T_a"] != rows[1].metrics["T_a"]
