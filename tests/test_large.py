"""Large sweeps: described, counted and begun without being built; Parquet; summaries."""

from __future__ import annotations

import json

import mpmath
import numpy as np
import pytest
from hang import no_hang
from seat import rows_of

from drysim.scenario.axes import count_points, decimal_geomspace, point_columns
from drysim.scenario.load import load
from drysim.study.plan import CaseRanges, approaches_of, solve_range
from drysim.study.run import MotionCache, count_cases
from drysim.study.table import Quantiles

HUGE = """\
drysim: 1
name: huge
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
stroke: {limit: 25 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
sweep:
  excitation.frequency: {from: 0.5, to: 10, count: 1000000}
  friction.kinetic: {from: 1, to: 45, count: 1000, scale: log}
  oscillator.damping: [100, 500]
"""


@pytest.fixture
def huge(tmp_path):
    """Write a sweep of two milliard cases."""
    file = tmp_path / "huge.yaml"
    file.write_text(HUGE)
    return file


def test_two_milliard_cases_are_counted_and_begun_at_once(huge):
    with no_hang():
        scenario = load(huge)
        assert count_points(scenario.sweep) == 2_000_000_000
        assert count_cases(approaches_of(scenario)) == 2_000_000_000
        first = next(iter(CaseRanges(approaches_of(scenario))))
    batch = solve_range(first._replace(end=20), MotionCache())
    assert batch.points["excitation.frequency"][0] == 0.5
    assert (batch.status == 0).all()


def test_last_point_of_a_huge_grid_is_its_corner(huge):
    axes = load(huge).sweep
    columns = point_columns(axes, count_points(axes) - 2, count_points(axes))
    assert columns["excitation.frequency"][1] == 10
    assert columns["excitation.frequency"][0] == float("9.9999904999905")
    assert columns["friction.kinetic"].tolist() == [45, 45]


def test_values_of_a_long_log_axis_are_the_doubles_next_to_their_decimals():
    values = decimal_geomspace(1e-3, 1e3, 6_000_001)
    assert values[::1_000_000] == [1e-3, 1e-2, 0.1, 1, 10, 100, 1e3]
    assert values[2_000_000] == 0.1
    exact = 1e-3 * mpmath.mpf(10) ** (mpmath.mpf(6 * 12_345) / 6_000_000)
    assert values[12_345] == pytest.approx(float(exact), rel=3e-16)


def test_dry_run_of_a_huge_sweep_tells_its_cases(drysim, huge):
    done = drysim("sweep", huge, "--dry-run")
    assert done.code == 0
    assert "2000000000 cases" in done.out


def test_quantiles_do_not_depend_on_the_blocks():
    values = np.random.Generator(np.random.PCG64(1)).lognormal(size=20_000)
    values[:500] = 0.0
    whole, parts = Quantiles(), Quantiles()
    whole.add(values)
    for part in np.array_split(values, 33):
        parts.add(part)
    assert whole.summary() == parts.summary()
    for name, value in whole.summary().items():
        assert value == pytest.approx(np.quantile(values, float(name)), rel=4e-3)
    assert Quantiles().summary() == {}


SEEDS = {
    "excitation": "{kind: psd, points: [[1, 0.1], [10, 0.1]], duration: 10, seed: 1, seeds: 3}",
    "measure": "{settle: 0, duration: 10}",
    "sweep": "{friction.kinetic: [5, 45]}",
}
ORBITS = {"sweep": "{excitation.frequency: [1, 2], friction.kinetic: [5, 45]}"}


@pytest.mark.parametrize("asked", [ORBITS, SEEDS], ids=["orbits", "seeds"])
def test_parquet_holds_what_the_csv_holds(drysim, huge, asked):
    dataset = pytest.importorskip("pyarrow.dataset")
    sets = [word for item in asked.items() for word in ("--set", "=".join(item))]
    words = (*sets, "--set", "reference=viscous", "--no-plots", "--quiet")
    assert drysim("sweep", huge, *words, "-o", "a").code == 0
    assert drysim("sweep", huge, *words, "-o", "b", "--format", "parquet").code == 0
    lines = (huge.parent / "a/transmissibility.csv").read_text().splitlines()
    names = [cell.partition(" [")[0] for cell in lines[0].split(",")]
    folder = huge.parent / "b/transmissibility"
    table = dataset.dataset(folder, partitioning="hive").to_table()
    assert set(table.column_names) == set(names)
    assert table.schema.field("x_r_peak").metadata == {b"unit": b"m"}
    found = {
        ",".join("" if row[name] is None else str(row[name]) for name in names)
        for row in table.to_pylist()
    }
    assert found == set(lines[1:])
    assert drysim("sweep", huge, *words, "-o", "b").code == 0  # replaces what is ours
    assert not folder.exists()


def test_parquet_keeps_the_decimals_of_a_mean_of_counts(drysim, huge):
    dataset = pytest.importorskip("pyarrow.dataset")
    asked = SEEDS | {"stroke": "{limit: 2 mm}"}
    sets = [word for item in asked.items() for word in ("--set", "=".join(item))]
    words = (*sets, "--no-plots", "--quiet")
    assert drysim("sweep", huge, *words, "-o", "a").code == 0
    assert drysim("sweep", huge, *words, "-o", "b", "--format", "parquet").code == 0
    folder = huge.parent / "b/transmissibility"
    means = dataset.dataset(folder, partitioning="hive").to_table()["violations"].to_pylist()
    rows = rows_of(huge.parent / "a/transmissibility.csv")
    assert means == [float(row["violations [-]"]) for row in rows]
    assert any(mean % 1 for mean in means)


def test_file_of_the_user_in_a_dataset_is_not_removed(drysim, huge):
    pytest.importorskip("pyarrow")
    words = ("--set", "sweep={excitation.frequency: [1, 2]}", "--no-plots", "--quiet",
             "-o", "b", "--format", "parquet")  # fmt: skip
    assert drysim("sweep", huge, *words).code == 0
    mine = huge.parent / "b/transmissibility/notes.txt"
    mine.write_text("mine")
    done = drysim("sweep", huge, *words)
    assert done.code == 2
    assert "transmissibility/notes.txt, which drysim did not write" in done.err
    assert mine.read_text() == "mine"


def test_summary_is_retold_without_computing(drysim, huge):
    words = ("--set", "sweep={excitation.frequency: [1, 2]}", "--set", "checks=[T_a < 1]")
    assert drysim("sweep", huge, *words, "--no-plots", "-o", "a").code == 1
    done = drysim("summarise", "a")
    assert done.code == 0
    (fails,) = [line for line in done.out.splitlines() if "✗ fails" in line]
    assert "T_a < 1 in 2 of 2 cases, worst with" in fails
    assert fails.endswith("Hz")
    told = json.loads(drysim("summarise", "a", "--json").out)
    assert told["metrics"]["T_a"]["quantiles"].keys() == {"0.05", "0.25", "0.5", "0.75", "0.95"}


def test_check_is_retold_in_its_own_unit(drysim, seat):
    words = ("--no-plots", "--set", "checks=[x_r_peak < 60 mm at excitation.frequency > 1 Hz]")
    shown = drysim("run", seat, *words, "-o", "a").out
    (held,) = [line for line in shown.splitlines() if "✓ holds" in line]
    assert held.endswith(" mm")
    assert held in drysim("summarise", "a").out.splitlines()


def test_folder_without_a_result_cannot_be_summarised(drysim, tmp_path):
    done = drysim("summarise", tmp_path)
    assert done.code == 2
    assert "name an output folder" in done.err


def table(out):
    """Return the headers of a table that was printed, and the cells of T_a."""
    rows = [line.split() for line in out.splitlines() if line.startswith(("metric ", "T_a "))]
    return rows[0][2:], [float(cell) for cell in rows[1][1:]]


def test_value_and_mean_are_not_told_as_the_least(drysim, seat):
    assert drysim("run", seat, "--no-plots", "--quiet", "-o", "a").code == 0
    headings, (value,) = table(drysim("summarise", "a").out)
    told = json.loads(drysim("summarise", "a", "--json").out)
    assert headings == ["value"]
    assert value == pytest.approx(told["metrics"]["T_a"], rel=1e-3)
    noise = "excitation={kind: psd, points: [[0.8, 1], [4, 1]], duration: 4 s, seeds: 4}"
    times = "measure={settle: 1 s}"
    words = ("run", seat, "--set", noise, "--set", times, "--no-plots", "--quiet", "-o", "c")
    assert drysim(*words).code == 0
    headings, (mean, _, least, *inner, most) = table(drysim("summarise", "c").out)
    assert headings == ["mean", "±", "minimum", "5", "%", "median", "95", "%", "maximum"]
    told = json.loads(drysim("summarise", "c", "--json").out)["ensemble"]["metrics"]["T_a"]
    assert least <= inner[0] <= inner[1] <= inner[2] <= most
    assert least < mean < most
    assert mean == pytest.approx(told["mean"], rel=1e-3)
    assert least == pytest.approx(told["least"]["value"], rel=1e-3)


def test_comparison_is_summarised_too(drysim, seat):
    compare = ("compare", "signum", "vs", "stick-slip", "-s", seat, "--no-plots", "--quiet")
    assert drysim(*compare, "-o", "b").code == 0
    assert "signum" in drysim("summarise", "b").out


def test_pieces_of_a_huge_sweep_are_known_by_their_numbers(huge):
    every = CaseRanges(approaches_of(load(huge, {"reference": "viscous"})))
    last = every[-1]
    assert last.end == every.cases[1]
    assert last.first + last.end - last.begin == sum(every.cases)
    small = CaseRanges(approaches_of(load(huge, {"sweep": {"friction.kinetic": [5, 45]}})))
    assert [case_range[1:] for case_range in small] == [(0, 0, 2)]
    for k in (0, 1, len(every) // 2 - 1, len(every) // 2, len(every) - 2):
        assert every[k].first + every[k].end - every[k].begin == every[k + 1].first
