"""The best admissible case of a sweep is the one that a look through all rows finds."""

from __future__ import annotations

import json

import numpy as np
import pytest
from seat import EM6_SEAT, fields_of, rows_of, write_records
from seat import SEAT as HARMONIC_SEAT

import drysim
from drysim.metrics.checks import Check
from drysim.metrics.table import METRICS
from drysim.plots.sweep import draw_stroke
from drysim.study.statistics import FAILED, OK, Batch, Row
from drysim.study.table import Tally, excess_of, minmax_design, misses_of

KEY = "friction.kinetic"
SEAT = f"""\
{EM6_SEAT}
sweep:
  friction.kinetic: [0, 10, 20, 30, 40, 60]
  oscillator.damping: [150, 400]
checks: [SEAT < 0.9, T_a < 0.4 at friction.kinetic >= 30]
"""


def by_hand(rows, checks, objective):
    """Return the admissible rows, and the first of them with the least objective."""
    kept = []
    for row in rows:
        values = [row.metrics[check.metric] for check in checks if check.applies(row.point)]
        limits = [check for check in checks if check.applies(row.point)]
        holds = all(
            value is not None and check.holds(value)
            for check, value in zip(limits, values, strict=True)
        )
        if row.status == OK and not row.metrics["violations"] and holds:
            kept.append(row)
    known = [row for row in kept if row.metrics[objective] is not None]
    return kept, min(known, key=lambda row: row.metrics[objective], default=None)


@pytest.mark.parametrize("seed", range(60))
def test_tally_finds_what_a_look_through_all_rows_finds(seed):
    random = np.random.default_rng(seed)
    checks = [
        Check.parse(text, {KEY: "N"}) for text in ("T_a < 0.6", f"SEAT < 0.8 at {KEY} > 3")
    ]
    rows = []
    for i in range(40):
        # Few distinct values, so that there are ties.
        metrics = {metric.name: float(random.integers(0, 9)) / 10 for metric in METRICS}
        metrics["violations"] = int(random.random() < 0.2)
        metrics["stroke_used"] += metrics["violations"]
        for name in ("T_a", "SEAT"):
            metrics[name] = None if random.random() < 0.1 else metrics[name]
        status = FAILED if random.random() < 0.1 else OK
        rows.append(Row({KEY: float(i % 7)}, "stick-slip", 1.0, 1.0, metrics, status))
    chosen = checks[: seed % 3]
    tally = Tally("stick-slip", chosen)
    for first in range(0, 40, 8):
        tally.add(Batch.of(first, rows[first : first + 8]))
    for objective in ("SEAT", "T_a"):
        kept, best = by_hand(rows, chosen, objective)
        assert tally.admissible == len(kept)
        found = tally.best.get(objective)
        assert (best is None) == (found is None)
        if found is not None:
            assert found.value == best.metrics[objective]
            assert found.row.point == best.point


def test_best_case_is_named_on_the_console_and_in_the_file(command, tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT)
    answer = command("sweep", "seat.yaml", "--no-plots")
    table = drysim.sweep(drysim.load("seat.yaml"))
    kept, best = by_hand(table.own, table.scenario.checks, "SEAT")
    assert 0 < len(kept) < len(table.own)
    assert table.best.row == best
    words = fields_of(tmp_path / "out/seat")["best"]
    assert words == {
        "metric": "SEAT",
        "value": best.metrics["SEAT"],
        "at": dict(best.point),
        "admissible": len(kept),
        "cases": 12,
    }
    assert f"least of {len(kept)} admissible cases of 12" in " ".join(answer.out.split())


def test_no_admissible_case_is_said(command, tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT)
    answer = command("sweep", "seat.yaml", "--no-plots", "--set", "checks=[SEAT < 0.01]")
    assert answer.code == 1
    words = " ".join(answer.out.split())
    assert "no case of 12 is admissible; the least peak |x_r| is " in words
    words = fields_of(tmp_path / "out/seat")["best"]
    assert (words["value"], words["at"], words["admissible"]) == (None, None, 0)
    # The least SEAT is that of the closest case.
    least = min(
        float(row["SEAT [-]"]) for row in rows_of(tmp_path / "out/seat/transmissibility.csv")
    )
    assert words["closest"]["check"] == "SEAT < 0.01"
    assert words["closest"]["value"] == least
    told = f"the closest fails SEAT < 0.01, with {least:.6g} at "
    assert told in " ".join(answer.out.split())


def test_closest_case_fails_its_worst_check_by_least_relative_to_the_limit():
    checks = [Check.parse("T_a < 0.5"), Check.parse("x_r_peak < 10 mm")]
    found = [(0.6, 5e-3, 0.5), (0.4, 13e-3, 0.65), (0.45, 11e-3, 1.04), (None, 1e-3, 0.1)]
    rows = []
    for T_a, peak, used in found:
        metrics = dict.fromkeys((metric.name for metric in METRICS), 0.0)
        metrics |= {"T_a": T_a, "x_r_peak": peak, "stroke_used": used}
        metrics["violations"] = int(used > 1)
        rows.append(Row({KEY: 1.0}, "stick-slip", 1.0, 1.0, metrics))
    misses = misses_of(Batch.of(0, rows), checks)
    assert misses.max(axis=0).tolist() == pytest.approx([0.2, 0.3, 0.1, np.inf])
    assert misses.argmax(axis=0).tolist() == [1, 2, 2, 1]  # of the stroke limit and both checks
    misses = misses_of(Batch.of(0, rows[2:3]), checks[:1])
    assert (misses.max(), misses.argmax()) == (pytest.approx(0.04), 0)


@pytest.mark.parametrize("text", ["T_a < 0.5", "T_a <= 0.5", "T_a > 0.5", "T_a == 0.5"])
def test_excess_over_a_limit_has_the_sign_of_its_verdict(text):
    check = Check.parse(f"{text} at {KEY} > 1", {KEY: "N"})
    rows = []
    for T_a in (0.4, 0.5, 0.6, None):
        metrics = dict.fromkeys((metric.name for metric in METRICS), 0.0) | {"T_a": T_a}
        rows += [Row({KEY: force}, "stick-slip", 1.0, 1.0, metrics) for force in (1.0, 2.0)]
    batch = Batch.of(0, rows)
    (stroke, excess), misses = excess_of(batch, [check]), misses_of(batch, [check])[1]
    assert (stroke == -1.0).all()  # none of it is used
    for row, amount, miss in zip(rows, excess, misses, strict=True):
        if not check.applies(row.point):
            assert amount == miss == -np.inf
        elif row.metrics["T_a"] is None:
            assert amount == miss == np.inf
        else:
            assert amount == pytest.approx(check.excess(row.metrics["T_a"]) / 0.5)
            assert (miss == -np.inf) == bool(check.holds(row.metrics["T_a"]))


def test_failed_check_counts_its_cases_and_the_best_case_is_the_answer(command, tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT)
    answer = command("sweep", "seat.yaml", "--no-plots", "--set", "checks=[SEAT < 0.5]")
    assert answer.code == 1
    rows = rows_of(tmp_path / "out/seat/transmissibility.csv")
    failed = sum(float(row["SEAT [-]"]) >= 0.5 for row in rows)
    assert 0 < failed < 12
    screen = " ".join(answer.out.split())
    assert f"✗ fails SEAT < 0.5 in {failed} of 12 cases, worst with " in screen
    words = fields_of(tmp_path / "out/seat")
    assert (words["checks"][0]["failed"], words["checks"][0]["cases"]) == (failed, 12)
    kinetic, damping = words["best"]["at"].values()
    where = f"kinetic {kinetic:g} N, damping {damping:g} N·s/m"
    assert f"✓ best the best admissible case, at {where}, keeps every check" in screen
    assert "✓ best" not in command("sweep", "seat.yaml", "--no-plots", "--set", "checks=[]").out


@pytest.mark.parametrize(
    ("frequency", "values", "end"),
    [(1.6, [100, 500, 3000], "upper"), (4, [100, 500, 3000], "lower"), (4, [100, 3000], "")],
)
def test_best_case_at_the_end_of_its_range_says_so(frequency, values, end):
    changes = {
        "excitation.frequency": frequency, "friction": None, "stroke": {"limit": 1},
        "measure": {"direction": "vertical"}, "sweep": {"oscillator.damping": values},
    }  # fmt: skip
    table = drysim.sweep(drysim.scenario(HARMONIC_SEAT, changes))
    best = table.best.row.point["oscillator.damping"]
    said = f"; damping {best:g} N·s/m is the {end} end of its range"
    assert table.best.describe(table.axes).endswith(said) == bool(end)
    assert (" end of its range" in table.best.describe(table.axes)) == bool(end)


@pytest.mark.parametrize(
    ("key", "values", "said"),
    [("friction.static_ratio", [1, 1.2, 1.4], False),
     ("friction.static_ratio", [1.1, 1.2, 1.4], True),
     ("friction.kinetic", [0, 10, 20], False),
     ("stroke.offset", [0, 0.01, 0.02], True)],
)  # fmt: skip
def test_end_of_a_range_that_is_a_bound_of_the_key_is_not_said(key, values, said):
    changes = {"sweep": {key: values}, "checks": ["SEAT < 5"], "stroke.limit": 1}
    table = drysim.sweep(drysim.scenario(SEAT, changes))
    assert table.best.row.point[key] == values[0]
    assert table.best.describe(table.axes).count("end of its range") == said


def test_table_shows_its_best_case_in_a_notebook():
    table = drysim.sweep(drysim.scenario(SEAT))
    assert f"; best SEAT {table.best.value:.4g}; " in repr(table)
    assert f"<td>best</td><td>SEAT {table.best.value:.4g}</td>" in table._repr_html_()


AT_REST = {
    "excitation": {"kind": "rest"}, "start": {"x_r": 5e-3}, "measure": {"duration": 1},
    "checks": None,
}  # fmt: skip
BASES = {"sweep": {"excitation.seed": [1, 2]}, "checks": ["SEAT < 1"]}


@pytest.mark.parametrize(
    "changes",
    [BASES, {"stroke": None, "checks": None}, AT_REST],
    ids=["different base motions", "no limits", "no objective"],
)
def test_nothing_is_best_of_what_cannot_be_compared(changes):
    assert drysim.sweep(drysim.scenario(SEAT, changes)).best is None


def test_unknown_metric_is_not_admissible():
    check = Check.parse("T_x < 1")
    metrics = dict.fromkeys((metric.name for metric in METRICS), 0.5) | {"violations": 0}
    tally = Tally("stick-slip", [check])
    tally.add(Batch.of(0, [Row({KEY: 1.0}, "stick-slip", 1.0, 1.0, metrics | {"T_x": None})]))
    assert tally.admissible == 0
    assert not tally.best


def test_best_case_of_a_comparison_is_that_of_its_reference():
    scenario = drysim.scenario(SEAT)
    compared = drysim.compare(scenario, "signum vs stick-slip").table.best
    alone = drysim.sweep(scenario).best
    assert compared.row.approach == "stick-slip"
    assert (compared.row.point, compared.admissible) == (alone.row.point, alone.admissible)


# A sweep over records: the best values of the other keys, judged by their worst record.

FILE, DAMPING = "excitation.file", "oscillator.damping"
ON_RECORDS = """\
oscillator: {mass: 75 kg, stiffness: 3500 N/m, damping: 250}
friction: {law: coulomb, kinetic: 20 N}
stroke: {limit: 80 mm}
excitation: {kind: record, file: runs/run-00.csv, time: t, column: u_dd}
"""
AXES = {FILE: "runs/*.csv", KEY: [0, 20, 40], DAMPING: [250, 500]}


def through_the_file(rows, passes):
    """Return the worst row of the best design, and how many designs are admissible."""
    names = {FILE: "excitation.file", KEY: f"{KEY} [N]", DAMPING: f"{DAMPING} [N*s/m]"}
    designs = {}
    for row in rows:
        designs.setdefault((row[names[KEY]], row[names[DAMPING]]), []).append(row)
    kept = [several for several in designs.values() if all(map(passes, several))]
    worst = [max(several, key=lambda row: float(row["T_a [-]"])) for several in kept]
    best = min(worst, key=lambda row: float(row["T_a [-]"]), default=None)
    point = best and {key: float(best[names[key]]) for key in (KEY, DAMPING)}
    return best, point, len(kept), len(designs)


@pytest.mark.parametrize(
    "order", [(FILE, KEY, DAMPING), (KEY, FILE, DAMPING), (KEY, DAMPING, FILE)]
)
@pytest.mark.parametrize("limit", [1.5, 1.05, 1.02, 0.5])
def test_best_design_over_records_has_the_least_worst(command, tmp_path, order, limit):
    write_records(tmp_path / "runs", 4)
    sweep = {key: AXES[key] for key in order}
    text = f"{ON_RECORDS}sweep: {json.dumps(sweep)}\nchecks: [T_a < {limit}]\n"
    (tmp_path / "seat.yaml").write_text(text)
    answer = command("sweep", "seat.yaml", "--no-plots")
    rows = rows_of(tmp_path / "out/seat/transmissibility.csv")
    best, point, admissible, designs = through_the_file(
        rows, lambda row: float(row["T_a [-]"]) < limit and float(row["violations [-]"]) == 0
    )
    words = fields_of(tmp_path / "out/seat")["best"]["over_records"]
    assert (words["admissible"], words["cases"]) == (admissible, designs)
    screen = " ".join(answer.out.split())
    if best is None:
        assert (words["value"], words["at"]) == (None, None)
        assert f"no design of {designs} is admissible; the closest fails T_a" in screen
        best, *_ = through_the_file(rows, lambda row: True)
        assert words["closest"]["value"] == float(best["T_a [-]"])
    else:
        assert words["value"] == float(best["T_a [-]"])
        record = best["excitation.file"]
        assert words["at"] == {**point, FILE: record}
        count = f"least of {admissible} admissible designs of {designs}"
        assert f"{record} being its worst record; {count}" in screen
    again = " ".join(command("summarise", "out/seat").out.split())
    assert again.count(" of 6") == screen.count(" of 6")
    assert "all records " in again


@pytest.mark.parametrize("seed", range(40))
def test_least_worst_is_what_a_look_through_all_designs_finds(seed):
    random = np.random.default_rng(seed)
    high, records, stride = random.integers(1, 5, size=3).tolist()
    grid = random.integers(0, 4, size=(high, records, stride)).astype(float)  # with ties
    grid[random.random(grid.shape) < 0.1] = np.nan
    grid[random.random(grid.shape) < 0.2] = np.inf
    worst, case = minmax_design(grid.ravel(), records, stride)
    found = []
    for i in range(high):
        for j in range(stride):
            known = [value for value in grid[i, :, j].tolist() if value == value]
            found.append(max(known, default=np.nan))
    assert worst.tolist() == pytest.approx(found, nan_ok=True)
    finite = [value for value in found if np.isfinite(value)]
    if not finite:
        assert case is None
        return
    i, j = divmod(found.index(min(finite)), stride)
    record = grid[i, :, j].tolist().index(min(finite))
    assert case == (i * records + record) * stride + j


def test_summary_of_a_finished_sweep_names_the_best_case(command, tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT)
    command("sweep", "seat.yaml", "--no-plots")
    best = drysim.sweep(drysim.load("seat.yaml")).best
    shown = " ".join(command("summarise", "out/seat").out.split())
    assert f"best {best.result} at {best.place(drysim.load('seat.yaml').sweep)}, " in shown


def test_records_alone_are_no_designs(tmp_path):
    write_records(tmp_path / "runs", 2)
    text = f"{ON_RECORDS}sweep: {{{FILE}: runs/*.csv}}\nchecks: [T_a < 1]\n"
    (tmp_path / "seat.yaml").write_text(text)
    assert drysim.sweep(drysim.load(tmp_path / "seat.yaml")).best is None


MEANS_WITHIN = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {kinetic: 45}
stroke: {limit: 30 mm}
excitation: {kind: standard, class: EM3, duration: 15 s, seed: 1, seeds: 6}
solver: {step: 5e-3}
measure: {settle: 5 s, direction: vertical}
sweep: {oscillator.damping: [500, 600, 700]}
"""


def test_closest_case_is_judged_by_its_worst_seed():
    free = drysim.sweep(drysim.scenario(MEANS_WITHIN, {"stroke.limit": 1.0}))
    reach = [row.over.values["stroke_suffices"] for row in free.rows]
    limit = 0.99 * min(max(values) for values in reach)  # some seed of every case exceeds it
    table = drysim.sweep(drysim.scenario(MEANS_WITHIN, {"stroke.limit": limit}))
    at = int(np.argmin([max(values) for values in reach]))
    closest, row = table.best.closest, table.rows[at]
    assert closest.where == row.point
    assert closest.value == pytest.approx(1.0 / 0.99)
    assert row.metrics["stroke_used"] < 1.0 < closest.value  # the mean stays below
    failed = sum(value >= limit for value in reach[at])
    assert (closest.failed_seeds, closest.seeds) == (failed, 6)
    words = table.best.describe(table.axes)
    assert f"the closest fails stroke_used < 1 in {failed} of 6 seeds, worst with 1.01" in words
    (panel,) = draw_stroke(table).axes
    (met,) = (line for line in panel.lines if line.get_label().startswith("limit exceeded"))
    drawn = [1e3 * max(values) for values in reach]
    assert met.get_ydata() == pytest.approx(drawn)
    assert min(drawn) > 1e3 * limit
