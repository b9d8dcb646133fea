"""Sweeps: every case in order, whatever the workers, the interruptions and the statuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from drysim.errors import ScenarioError
from drysim.scenario.axes import points, size
from drysim.scenario.load import load
from drysim.study.case import prepare
from drysim.study.plan import Pieces, approaches_of, solve_piece
from drysim.study.rows import Row
from drysim.study.run import Motions, count
from drysim.study.store import Store, identity
from drysim.study.sweep import leftover, solve, sweep
from drysim.study.table import Table

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
    """Give the rows with everything that a file would hold of them."""
    return [
        Row(dict(row.point), row.approach, row.F_fk, row.F_fs, dict(row.metrics), row.status)
        for row in table.rows
    ]


def test_first_key_varies_fastest_and_the_reference_comes_last(grid: Path) -> None:
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


def test_case_of_a_sweep_is_what_a_run_of_it_gives(grid: Path) -> None:
    from drysim.study.ensemble import run

    row = list(sweep(load(grid)).of("stick-slip"))[6]
    overrides = {"excitation.frequency": 3, "friction.kinetic": 45}
    alone = run(load(grid, overrides)).metrics
    assert {name: alone[name] for name in row.metrics} == dict(row.metrics)


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_table_does_not_depend_on_the_workers(grid: Path, workers: int) -> None:
    assert as_written(sweep(load(grid), workers=workers)) == as_written(sweep(load(grid)))


def test_interrupted_sweep_goes_on_to_the_very_same_table(grid: Path, tmp_path: Path) -> None:
    scenario = load(grid)
    whole = sweep(scenario)
    case, every = prepare(scenario), list(Pieces(approaches_of(scenario)))
    store = Store(tmp_path / "cases", identity(scenario), resume=False)
    for piece in every:
        store.write(piece, solve_piece(piece, Motions()))
    # A power cut may leave a file that was never written through.
    (file,) = store.folder.glob("*.cases")
    file.write_bytes(file.read_bytes()[:-17])
    computed = []
    again = Store(tmp_path / "cases", identity(scenario), resume=True)
    resumed = solve(case, store=again, finished=lambda batch: computed.append(batch.first))
    assert as_written(resumed) == as_written(whole)
    assert computed == [every[-1].first]
    assert as_written(leftover(case, again)) == as_written(whole)


def test_blocks_of_another_sweep_is_refused(grid: Path, tmp_path: Path) -> None:
    from drysim.errors import UsageError

    Store(tmp_path / "cases", identity(load(grid)), resume=False)
    other = load(grid, {"oscillator.mass": 76})
    with pytest.raises(UsageError, match="cases of another sweep"):
        Store(tmp_path / "cases", identity(other), resume=True)


def test_checks_are_judged_by_their_worst_case(grid: Path) -> None:
    table = sweep(load(grid))
    first, second = table.checks
    worst = max(table.of("stick-slip"), key=lambda row: row.metrics["T_a"])
    assert first.value == worst.metrics["T_a"]
    assert first.where == dict(worst.point)
    assert second.where is not None
    assert second.where["excitation.frequency"] == 4.0


def test_stroke_violations_are_summed_up_with_their_worst_case(grid: Path) -> None:
    table = sweep(load(grid, {"stroke.limit": 0.010}))
    found = [caution for caution in table.warnings if caution.slug == "stroke-violated"]
    assert len(found) == 1
    assert "10 mm" in found[0].sentence
    assert found[0].numbers["cases"] == sum(
        bool(row.metrics["violations"]) for row in table.of("stick-slip")
    )


def test_motion_that_does_not_settle_is_a_status_and_not_a_number(grid: Path) -> None:
    # Without damping, friction below π/4 of the force cannot hold resonance.
    resonance = GRID.replace("{from: 1, to: 4, step: 1}", "[1.5915494309189535]")
    grid.write_text(resonance.replace("damping: 500", "damping: 0").replace("[15, 45]", "[1]"))
    table = sweep(load(grid))
    row = next(table.of("stick-slip"))
    assert row.status == "not settled"
    assert row.metrics["T_a"] is None
    assert any(caution.slug == "not-settled" for caution in table.warnings)
    assert not table.checks[0].passed
    assert table.checks[0].reason == "not settled: T_a is not known"


def test_sweep_fails_where_one_case_does_not_settle(grid: Path) -> None:
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
    assert [verdict.passed for verdict in table.checks] == [False, True]
    assert table.checks[0].where == {"friction.kinetic": 10.0}
    assert table.exit_code() == 1


def test_scenario_without_a_sweep_says_so(grid: Path) -> None:
    grid.write_text(GRID[: GRID.index("sweep:")])
    with pytest.raises(ScenarioError) as fault:
        approaches_of(load(grid))
    assert "sweep" in fault.value.problems[0].sentence


def test_huge_grid_is_counted_and_begun_without_being_built(grid: Path) -> None:
    axis = "{from: 1, to: 2, count: 3000}"
    text = GRID.replace("{from: 1, to: 4, step: 1}", axis).replace("[15, 45]", axis)
    grid.write_text(text)
    scenario = load(grid)
    assert size(scenario.sweep) == 9_000_000
    assert count(approaches_of(scenario)) == 9_003_000
    assert set(next(points(scenario.sweep))) == {"friction.kinetic", "excitation.frequency"}


def test_spectra_that_only_a_run_gives_are_told_of(grid: Path) -> None:
    noise = "{kind: psd, points: [[0.5, 1], [10, 1]], rms: 1, duration: 10, seed: 3}"
    text = GRID.replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", noise)
    text = text.replace("  excitation.frequency: {from: 1, to: 4, step: 1}\n", "")
    grid.write_text(text.replace(", T_a < 0.9 at excitation.frequency >= 4", ""))
    slugs = [caution.slug for caution in sweep(load(grid, {"measure.spectra": True})).warnings]
    assert "spectra-left-out" in slugs
