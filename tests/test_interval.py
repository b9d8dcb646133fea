"""A static ratio of which only bounds are known: ranges of the metrics, and their jumps."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from seat import fields_of, ranges
from shown import show

import drysim as package
from drysim.errors import ScenarioError
from drysim.plots.sweep import draw_stroke
from drysim.scenario.load import load
from drysim.study import interval
from drysim.study.statistics import Row
from drysim.study.sweep import sweep
from drysim.study.table import RATIO_KEY
from drysim.yaml_document import dump

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: {from: 1, to: 1.4}}
excitation: {kind: harmonic, frequency: 1.6, rms: 0.5}
solver: {step: 2.5e-3}
checks: [T_a < 0.999, x_r_peak < 1 mm]
"""
LOCKED = sqrt(2) * 0.5 * 75 / 45
"""Ratio from which on the mass never leaves its rest: F_fs = m A."""


@pytest.fixture
def seat(scenario):
    """Return the scenario of a seat, with overrides."""
    return lambda *overrides, text=SEAT: scenario(text, overrides)


@pytest.fixture
def table(seat):
    """Return the answer over the interval."""
    return package.run(seat())


def test_jump_is_where_the_base_can_no_longer_break_the_mass_away(table, capsys):
    (jump,) = table.jumps
    assert jump.value == pytest.approx(LOCKED, abs=1e-6)
    assert jump.below.metrics["T_a"] == pytest.approx(0.9939, abs=1e-4)
    assert jump.above.metrics["T_a"] == 1.0
    assert jump.above.metrics["stuck_share"] == 1.0
    axes = draw_stroke(table).axes[0]
    (marked,) = (line for line in axes.lines if line.get_label() == "jump")
    assert marked.get_xdata()[0] == jump.value
    show(table)
    shown = " ".join(capsys.readouterr().out.split())
    assert "jumps at 1.178511 T_a from 0.99392 to 1, peak |x_r| from 0.2121 mm" in shown


def test_metrics_range_over_the_interval(seat, table):
    ratios = np.array([row.point[RATIO_KEY] for row in table])
    assert (ratios[0], ratios[-1]) == (1.0, 1.4)
    assert (np.diff(ratios) > 0.0).all()
    assert len(table) < 200
    low, high = table.tallies["stick-slip"].ends["T_a"]
    axis = {"friction.static_ratio": {"from": 1, "to": 1.4, "count": 201}}
    fixed = seat(text=SEAT.replace("{from: 1, to: 1.4}", "1") + dump({"sweep": axis}))
    swept = [row.metrics["T_a"] for row in sweep(fixed)]
    assert low == pytest.approx(min(swept), abs=1e-4)
    assert high == max(swept) == 1.0


def test_row_is_the_run_with_that_ratio(seat, table):
    row = table[5]
    alone = package.run(seat(f"friction.static_ratio={row.point[RATIO_KEY]!r}"))
    assert row.metrics["x_r_peak"] == pytest.approx(alone.metrics["x_r_peak"], rel=1e-9)


def test_check_must_hold_for_every_ratio(table):
    some, every = table.checks
    assert some.passed is False
    assert 0 < some.failed < some.cases == len(table)
    assert every.passed is True
    (warning,) = (one for one in table.warnings if one.slug == "check-undecided")
    assert warning.numbers["from"] == pytest.approx(LOCKED, abs=1e-6)
    assert warning.numbers["to"] == 1.4
    assert table.exit_code() == 1
    assert table.best is None


def test_answer_without_a_jump_says_so(seat, capsys):
    table = package.run(seat("friction.static_ratio.to=1.1"))
    assert table.jumps == ()
    assert table.checks[0].passed is True
    show(table)
    shown = " ".join(capsys.readouterr().out.split())
    assert "jumps none" in shown
    assert f"anywhere from 1 to 1.1 ({len(table)} values solved)" in shown


def test_number_of_solutions_is_limited(seat, monkeypatch, capsys):
    monkeypatch.setattr(interval, "MAX_VALUES", 40)
    table = package.run(seat())
    assert len(table) == 40
    assert [one.slug for one in table.warnings if one.slug.startswith("jumps")] == [
        "jumps-unresolved"
    ]
    show(table)
    shown = " ".join(capsys.readouterr().out.split())
    assert "jumps not known" in shown
    assert "jumps none" not in shown


def test_records_have_intervals_too(seat, tmp_path):
    t = np.arange(400) * 0.005
    u_dd = 0.8 * np.sin(2 * np.pi * 2 * t)
    rows = "".join(f"{a:.3f},{b!r}\n" for a, b in zip(t, u_dd.tolist(), strict=True))
    (tmp_path / "base.csv").write_text("t [s],u_dd [m/s2]\n" + rows)
    text = (
        SEAT.partition("excitation")[0]
        + "excitation: {kind: record, file: base.csv, time: t}\n"
    )
    table = package.run(seat(text=text))
    peak = max(abs(u_dd))
    assert table.jumps[-1].value == pytest.approx(75 * peak / 45, abs=1e-6)
    assert table.jumps[-1].above.metrics["x_r_peak"] == 0.0


def test_files_are_those_of_a_sweep_with_its_jumps(drysim, seat, tmp_path):
    seat()
    assert drysim("run", "seat.yaml", "-q", "-o", "out").code == 1
    head, *rows = (tmp_path / "out" / "transmissibility.csv").read_text().splitlines()
    assert head.startswith("approach,friction.static_ratio [-],F_fk [N],F_fs [N]")
    kept = fields_of(tmp_path / "out")
    assert len(rows) == kept["numerics"]["cases"]
    (jump,) = kept["jumps"]
    assert jump["key"] == "friction.static_ratio"
    assert jump["at"] == pytest.approx(LOCKED, abs=1e-6)
    assert jump["T_a"]["above"] == 1.0
    assert "quantiles" not in kept["metrics"]["T_a"]
    again = load(tmp_path / "out" / "scenario.yaml")
    assert again.static_interval == seat().static_interval
    assert drysim("validate", "out/scenario.yaml").code == 0


SWEEP = """
sweep:
  excitation.frequency: {from: 0.4, to: 4, count: 7, scale: log}
  friction.kinetic: [30, 45]
"""


@pytest.fixture
def swept(seat):
    """Return the answer of a sweep over the interval."""
    return sweep(seat(text=SEAT + SWEEP))


def test_sweep_has_least_and_greatest_value_of_each_metric(seat, swept):
    rows = swept.rows
    assert [row.point["extreme"] for row in rows] == ["least"] * 14 + ["greatest"] * 14
    for i in (0, 5, 13):
        least, greatest = rows[i], rows[14 + i]
        where = [f"{key}={value!r}" for key, value in least.point.items() if key != "extreme"]
        alone = package.run(seat(*where))
        for name, (low, high) in alone.tallies["stick-slip"].ends.items():
            assert least.metrics[name] == pytest.approx(low, rel=1e-9, abs=1e-15), name
            assert greatest.metrics[name] == pytest.approx(high, rel=1e-9, abs=1e-15), name
        jumps = [one.value for one in swept.jumps if one.point.items() <= least.point.items()]
        assert jumps == pytest.approx([one.value for one in alone.jumps], abs=1e-9)


def test_run_of_a_scenario_with_a_sweep_is_its_single_case(seat, table):
    alone = package.run(seat(text=SEAT + SWEEP))
    assert [row.metrics for row in alone] == [row.metrics for row in table]


def test_check_of_a_sweep_must_hold_over_the_interval(swept):
    some, every = swept.checks
    assert some.passed is False
    assert some.where is not None
    assert some.where["extreme"] == "greatest"
    assert every.passed is False or every.failed == 0


def test_sweep_over_the_interval_does_not_depend_on_workers_or_blocks(seat, swept, monkeypatch):
    from drysim.study import sweep as module

    monkeypatch.setattr(module, "CASES_PER_COVER", 3)
    other = sweep(seat(text=SEAT + SWEEP), workers=1)
    for one, two in zip(swept.rows, other.rows, strict=True):
        assert one.point == two.point
        assert one.metrics == two.metrics


def test_ratio_without_an_answer_is_left_out_and_told():
    rows = {ratio: Row({}, "", 1.0, ratio, {"T_a": ratio}) for ratio in (1.0, 1.2, 1.4)}
    rows[1.4] = replace(rows[1.4], metrics={"T_a": None}, status="not settled")
    covered = interval.Covered(rows, [])
    assert covered.extreme({}, "greatest").metrics == {"T_a": 1.2}
    assert covered.extreme({}, "least").metrics == {"T_a": 1.0}
    (warning,) = interval.unknown_warnings([covered])
    assert warning.slug == "interval-incomplete"
    lost = interval.Covered({1.4: rows[1.4]}, [])
    assert lost.extreme({}, "least").status == "not settled"
    assert [*interval.unknown_warnings([lost])] == []


def test_command_writes_extremes_jumps_and_pictures(drysim, tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT + SWEEP)
    answer = drysim("sweep", "seat.yaml", "-o", "out", "--report")
    assert answer.code == 1, answer.err
    assert "jumps" in answer.out
    rows = (tmp_path / "out" / "transmissibility.csv").read_text().splitlines()
    assert rows[0].split(",")[3] == "extreme"
    kept = fields_of(tmp_path / "out")
    assert {"excitation.frequency", "friction.kinetic"} == kept["jumps"][0]["where"].keys()
    assert (tmp_path / "out" / "transmissibility.png").exists()
    refused = drysim("sweep", "seat.yaml", "-o", "out", "--resume")
    assert refused.code == 2
    assert "--resume does not apply" in refused.err


NOISE = "kind: psd, points: [[1, 1], [9, 1]], duration: 9, seed: 1, seeds: 3"


@pytest.mark.parametrize(
    ("overrides", "sentence"),
    [
        (("friction.static_ratio.to=0.9",), "must be at least 1, not 0.9"),
        (("friction.static_ratio.from=1.5",), "must be above `from`, 1.5"),
        (("solver.approach=moreau",), "moreau does not support a static limit"),
        (("sweep={friction.static_ratio: [1, 2]}",), "friction.static_ratio is a block"),
        (("sweep={excitation.rms: [1, 2], direction: up}",), "a sweep up or down cannot have"),
        (
            ("sweep={excitation.rms: [1, 2]}", "reference=viscous"),
            "beside a reference approach",
        ),
        (
            (f"excitation={{{NOISE}}}",),
            "an interval is for `drysim run` and `sweep` with one seed",
        ),
    ],
)
def test_interval_is_refused_in_its_place(seat, overrides, sentence):
    with pytest.raises(ScenarioError) as fault:
        package.run(seat(*overrides))
    assert sentence in fault.value.problems[0].sentence


@pytest.mark.parametrize(
    "words",
    [
        ("compare", "viscous", "vs", "stick-slip", "-s", "seat.yaml"),
        ("compare", "stick-slip", "vs", "viscous", "-s", "seat.yaml"),
        ("bench", "seat.yaml"),
    ],
)
def test_other_commands_refuse_an_interval(drysim, seat, words):
    seat()
    answer = drysim(*words)
    assert answer.code == 2
    assert "seat.yaml:2:" in answer.err


DRAWN = """\
drysim: 1
oscillator: {{mass: 75, stiffness: 7500, damping: {b}}}
friction: {{law: coulomb, kinetic: {F_fk}, static_ratio: {ratio}}}
excitation:
  kind: sines
  components: [{{frequency: {f}, amplitude: {A}}}, {{frequency: {g}, amplitude: {A}, phase: 1}}]
solver: {{step: {dt}}}
measure: {{steady: true}}
"""


def missed(folder, seed: int) -> float:
    """Return how far a dense scan goes beyond the range of a drawn case, relative."""
    draw = np.random.default_rng(seed)
    b, f, A = draw.uniform(20, 300), round(draw.uniform(0.4, 5), 2), draw.uniform(0.4, 4)
    F_fk = 75 * A * draw.uniform(0.1, 0.4)
    numbers = {"b": b, "f": f, "g": round(3 * f, 4), "A": A, "F_fk": F_fk, "dt": 0.01 / f}
    file, scan = folder / "drawn.yaml", "{from: 1, to: 3, count: 1201}"
    file.write_text(DRAWN.format(**numbers, ratio="{from: 1, to: 3}"))
    solved = package.run(load(file))
    dense = DRAWN.format(**numbers, ratio=1) + f"sweep: {{friction.static_ratio: {scan}}}\n"
    file.write_text(dense)
    scanned, worst = sweep(load(file)), 0.0
    for name in ("T_a", "x_r_rms", "x_r_peak", "stuck_share"):
        some, all_of = (
            np.array([row.metrics[name] for row in table if row.status == "ok"])
            for table in (solved, scanned)
        )
        beyond = max(all_of.max() - some.max(), some.min() - all_of.min())
        worst = max(worst, float(beyond / (np.abs(all_of).max() or 1.0)))
    return worst


@pytest.mark.parametrize("seeds", [(0, 1, 8), *ranges(0, 80)[1:]])
def test_range_over_the_interval_misses_no_more_than_stated(tmp_path, seeds):
    assert max(missed(tmp_path, seed) for seed in seeds) <= interval.MAX_EXCESS
