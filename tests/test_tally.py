"""What many cases come to, gathered block by block, is what all of them come to at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from drysim import output
from drysim.metrics.checks import Check
from drysim.output import tables
from drysim.scenario.load import load
from drysim.study import plan as study_plan
from drysim.study import rows, sweep
from drysim.study.case import prepare
from drysim.study.plan import Pieces, Plan
from drysim.study.rows import FAILED, NOT_SETTLED, NOT_UNIQUE, OK, Batch, Row
from drysim.study.store import Store, identity
from drysim.study.table import Tally
from seat import rows_of

GRID = """\
drysim: 1
name: many
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
stroke: {limit: 16 mm}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
sweep:
  excitation.frequency: {from: 1, to: 4, step: 0.1}
  friction.kinetic: [15, 45]
  excitation.rms: {from: 0.5, to: 1, count: 10}
reference: viscous
checks: [T_a < 1.6, T_a < 0.9 at excitation.frequency >= 3.95]
"""


@pytest.fixture
def many(tmp_path: Path):
    """Give a sweep of some hundred cases."""
    (tmp_path / "many.yaml").write_text(GRID)
    return load(tmp_path / "many.yaml")


def test_tally_does_not_depend_on_the_blocks(many):
    table = sweep.sweep(many)
    whole = next(iter(table.tallies.values()))
    own = [row for row in table if row.approach == "stick-slip"]
    small = Tally("stick-slip", many.checks)
    for at in range(0, len(own), 7):
        small.add(Batch.of(at, own[at : at + 7]))
    for name, ends in whole.extremes.items():
        assert [one.value for one in ends] == [one.value for one in small.extremes[name]]
        assert [one.row.point for one in ends] == [
            one.row.point for one in small.extremes[name]
        ]
    assert whole.verdicts == small.verdicts
    assert (whole.cases, whole.beyond, whole.forces) == (
        small.cases,
        small.beyond,
        small.forces,
    )


def test_extremes_are_the_first_of_their_kind(many):
    table = sweep.sweep(many)
    own = list(table.of("stick-slip"))
    for metric in ("T_a", "x_r_peak", "stuck_share"):
        least, most = next(iter(table.tallies.values())).extremes[metric]
        values = [row.metrics[metric] for row in own]
        assert least.row.point == own[values.index(min(values))].point
        assert most.row.point == own[values.index(max(values))].point


def test_cases_without_numbers_are_counted_by_their_reason():
    good = Row({"a": 1.0}, "stick-slip", 1.0, 1.0, {"T_a": 2.0})
    lost = [Row({"a": float(i)}, "stick-slip", 1.0, 1.0, {}, FAILED, "no") for i in (2, 3)]
    tally = Tally("stick-slip")
    tally.add(Batch.of(0, [good, *lost]))
    assert (tally.lost[FAILED].cases, tally.lost[FAILED].first.note) == (2, "no")
    assert tally.extremes["T_a"][0].row.point == {"a": 1.0}


@pytest.mark.parametrize("status", [NOT_SETTLED, NOT_UNIQUE, FAILED])
def test_case_without_metrics_fails_the_checks_that_apply_to_it(status):
    """A sweep had passed: the other cases hold, and this one was not asked."""
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
        assert every.found == f"{status}: x_r_peak is not known"
        assert none.found == "no case lies there"


def test_row_of_a_block_is_that_of_its_iteration(many):
    table = sweep.sweep(many)
    assert [table[i] for i in (0, 333, len(table) - 1)] == [
        list(table)[i] for i in (0, 333, len(table) - 1)
    ]


def test_large_table_is_written_as_a_small_one(many, tmp_path, monkeypatch):
    table = sweep.sweep(many)
    kept = output.write_table(table, tmp_path / "a", plots=False, command="", exit_code=0)
    monkeypatch.setattr(tables, "HELD", 10)
    other = output.write_table(table, tmp_path / "b", plots=False, command="", exit_code=0)
    assert kept["files"] == other["files"]
    cells = rows_of(tmp_path / "a/transmissibility.csv")
    assert cells[-1]["friction.kinetic [N]"] == ""
    assert {row["violations [-]"] for row in cells} >= {"0", "2"}


def test_blocks_on_the_disk_give_the_table_that_blocks_at_hand_give(
    many, tmp_path, monkeypatch
):
    monkeypatch.setattr(sweep, "HELD", 0)
    monkeypatch.setattr(rows, "HELD", 0)
    store = Store(tmp_path / "cases", identity(many), resume=False)
    table = sweep.solve(prepare(many), store=store)
    assert list(table) == list(sweep.sweep(many))
    assert all(row.status == OK for row in table.rows[:5])


def test_numbers_of_a_block_read_back_to_the_last_bit(many, tmp_path):
    store = Store(tmp_path / "cases", identity(many), resume=False)
    plan = Plan(Pieces(study_plan.approaches_of(many)))
    piece, batch = plan.pieces[0], plan.block(0)
    store.write(piece, batch)
    again = store.read(piece)
    for name, column in batch.metrics.items():
        assert np.array_equal(column, again.metrics[name], equal_nan=True)
    assert list(again) == list(batch)
