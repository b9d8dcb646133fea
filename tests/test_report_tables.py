"""The files of sweeps and comparisons: tables, sidecar, and the folder that is worked in."""

from __future__ import annotations

import json
import os
import shutil
import time
from dataclasses import replace
from pathlib import Path

import pytest

from drysim import output
from drysim.errors import Caution, OutputError
from drysim.metrics import METRICS
from drysim.metrics.checks import Check
from drysim.output import folder, many, tables
from drysim.output.sidecar import Ending
from drysim.output.tables import transmissibility
from drysim.study import compare as study_compare
from drysim.study.rows import FAILED, NOT_SETTLED, Row
from drysim.study.table import Table
from grids import FORCE, FREQUENCY, RMS, axes, comparison, orbits, spoil, sweep
from killing import kills
from outcomes import judgement, names, record
from seat import rows_of

pytestmark = pytest.mark.usefixtures("place")

HEADER = (
    "approach,excitation.frequency [Hz],excitation.rms [m/s2],F_fk [N],F_fs [N],a_u [m/s2],"
    "a_x [m/s2],T_a [-],T_x [-],x_r_rms [m],x_r_peak [m],stroke_used [-],stuck_share [-],"
    "chatter_share [-],violations [-],closure [-],status"
)


def small(**words):
    return sweep(*axes(frequency=[1, 2, 4], rms=[0.5, 1.0]), **words)


def write(table, folder="out", **words):
    options = {"plots": False, "command": "drysim sweep seat.yaml", "exit_code": 0}
    target = folder if isinstance(folder, output.Claim) else Path(folder)
    return output.write_table(table, target, **options | words)


def compare(made, **words):
    options = {"plots": False, "command": "drysim compare", "exit_code": 0}
    return output.write_comparison(made, Path("out"), **options | words)


# tables


def test_transmissibility_has_the_columns_of_the_contract():
    write(small())
    data = Path("out/transmissibility.csv").read_bytes()
    assert data.decode().split("\n", 1)[0] == HEADER
    assert data.endswith(b"ok\n")
    assert b"\r" not in data


def test_every_case_reads_back_to_the_last_bit_in_the_order_of_the_grid():
    table = small()
    write(table)
    rows = rows_of("out/transmissibility.csv")
    assert len(rows) == len(table.rows) == 12
    for cells, row in zip(rows, table.rows, strict=True):
        assert cells["approach"] == row.approach
        assert float(cells["excitation.frequency [Hz]"]) == row.point[FREQUENCY]
        assert float(cells["excitation.rms [m/s2]"]) == row.point[RMS]
        assert (float(cells["F_fk [N]"]), float(cells["F_fs [N]"])) == (row.F_fk, row.F_fs)
        for name in ("a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "closure"):
            (cell,) = (cells[key] for key in cells if key.split(" ")[0] == name)
            assert float(cell) == row.metrics[name], name
    assert [row["excitation.frequency [Hz]"] for row in rows[:4]] == [
        "1.0",
        "2.0",
        "4.0",
        "1.0",
    ]


def test_what_is_not_known_is_an_empty_cell():
    table = spoil(sweep(*axes(force=[0, 15], rms=[0.5]), limit=None), NOT_SETTLED, 1)
    write(table)
    good, lost, reference = rows_of("out/transmissibility.csv")
    assert (lost["T_a [-]"], lost["status"]) == ("", "not settled")
    assert (good["stroke_used [-]"], good["violations [-]"]) == ("", "")
    assert reference["friction.kinetic [N]"] == ""
    assert reference["excitation.rms [m/s2]"] == "0.5"


def test_stroke_violations_name_the_cases_of_the_seat_and_not_of_its_reference():
    table = small(limit=0.015)
    write(table)
    met = [row for row in table.own if row.metrics["violations"]]
    rows = rows_of("out/stroke_violations.csv")
    assert 0 < len(met) < len(table.own)
    assert list(rows[0]) == [
        "excitation.frequency [Hz]", "excitation.rms [m/s2]", "t_first [s]", "x_r_peak [m]",
        "t_beyond [s]", "violations [-]",
    ]  # fmt: skip
    for cells, row in zip(rows, met, strict=True):
        assert float(cells["excitation.frequency [Hz]"]) == row.point[FREQUENCY]
        assert float(cells["x_r_peak [m]"]) == row.metrics["x_r_peak"] >= 0.015
    write(small(limit=1.0))
    assert "stroke_violations.csv" not in names("out")


def test_comparison_adds_the_deviation_from_the_yardstick():
    made = comparison(["signum", "stick-slip"], *axes(force=[15, 45], rms=[0.33, 0.67]), n=800)
    compare(made)
    header = Path("out/comparison.csv").read_text().split("\n", 1)[0]
    assert header.endswith(",closure [-],status,T_a_deviation [-]")
    rows = rows_of("out/comparison.csv")
    own = {
        (row["friction.kinetic [N]"], row["excitation.rms [m/s2]"]): float(row["T_a [-]"])
        for row in rows
        if row["approach"] == "stick-slip"
    }
    for row in rows:
        at = row["friction.kinetic [N]"], row["excitation.rms [m/s2]"]
        if row["approach"] == "viscous":  # One row beside many of the yardstick.
            assert (at[0], row["T_a_deviation [-]"]) == ("", "")
        else:
            deviation = float(row["T_a [-]"]) / own[at] - 1.0
            assert float(row["T_a_deviation [-]"]) == deviation
    assert "stroke_violations.csv" not in names("out")


def test_yardstick_without_friction_measures_every_case():
    made = comparison(["stick-slip", "viscous"], *axes(force=[0, 45], rms=[0.33]), n=800)
    first, second, own = (made.deviation(row) for row in made.table.rows)
    assert first == pytest.approx(0.0, abs=1e-12)
    assert abs(second) > 0.01
    assert own == 0.0


def test_deviation_of_an_approach_without_friction_is_known_at_every_case():
    made = comparison(["stick-slip"], *axes(force=[0, 15, 45], rms=[0.33]), n=800)
    found = study_compare.deviations(made, "viscous")
    assert [one.row.point[FORCE] for one in found] == [0.0, 15.0, 45.0]
    assert found[0].value == pytest.approx(0.0, abs=1e-12)
    assert study_compare.worst_of(found) is found[2]


def test_comparison_of_one_case_has_no_swept_columns():
    compare(orbits(["signum", "stick-slip"]))
    rows = rows_of("out/comparison.csv")
    assert list(rows[0])[:2] == ["approach", "F_fk [N]"]
    assert float(rows[0]["T_a_deviation [-]"]) > 0.2


@pytest.mark.parametrize("count", [2_000, 20_000])
def test_cost_of_a_case_does_not_grow_with_their_number(tmp_path, count):
    first = sweep(*axes(frequency=[2.0])).rows[0]
    (swept,) = axes(frequency=range(1, count // 2 + 1))
    rows = [
        Row({FREQUENCY: f}, name, 15.0, 15.0, first.metrics)
        for name in ("stick-slip", "viscous")
        for f in swept.values
    ]
    table = replace(sweep(*axes(frequency=[2.0])), axes=(swept,), rows=tuple(rows))
    made = replace(orbits(["stick-slip"]), table=table)
    began = time.process_time()
    transmissibility(table, tmp_path)
    tables.comparison(made, tmp_path)
    many.of_comparison(made, Ending("", 0, {}))
    # 50 µs a case on an idle machine; a scan of all rows for each would take seconds.
    assert (time.process_time() - began) / count < 5e-4


# sidecar


def test_sidecar_of_a_sweep_tells_extremes_with_where():
    table = replace(small(), warnings=(Caution("slug", "careful"),))
    told = write(table)
    assert told == json.loads(Path("out/drysim.json").read_text())
    numerics, metrics = told["numerics"], told["metrics"]
    assert (numerics["approach"], numerics["reference"]) == ("stick-slip", "viscous")
    assert (numerics["cases"], numerics["statuses"]) == (12, {"ok": 12})
    assert numerics["swept"][0] == {"key": FREQUENCY, "unit": "Hz", "values": 3}
    assert 0 < numerics["closure"] < 1e-9
    best = max(table.own, key=lambda row: row.metrics["T_a"])
    assert metrics["T_a"]["greatest"] == {
        "value": best.metrics["T_a"], "where": dict(best.point)
    }  # fmt: skip
    assert set(metrics) <= {metric.name for metric in METRICS}
    assert told["warnings"][0]["sentence"] == "careful"
    assert sorted([*told["files"], "drysim.json"]) == names("out")
    assert told["complete"] is True


def test_sidecar_holds_what_all_cases_share():
    motion = record(700)
    told = write(replace(small(), motion=motion, numerics={"core": "orbit"}))
    assert told["inputs"][0]["file"] == "road.csv"
    assert len(told["excitation"]["sha256"]) == 64
    assert told["numerics"]["core"] == "orbit"


def test_sidecar_of_a_sweep_names_the_case_that_decided_a_check():
    table = small()
    verdict = judgement(
        Check.parse("T_a < 1.2"), [(row.point, row.metrics) for row in table.own]
    )
    told = write(replace(table, checks=(verdict,)), exit_code=1)
    (check,) = told["checks"]
    assert check["passed"] is False
    assert check["where"] == {FREQUENCY: 1.0, RMS: 1.0}
    assert (told["exit_code"], told["complete"]) == (1, True)


def test_failed_case_marks_the_folder_as_incomplete():
    told = write(spoil(small(), FAILED, 2), exit_code=3)
    assert told["complete"] is False
    assert told["numerics"]["statuses"] == {"ok": 11, "failed": 1}
    assert "transmissibility.csv" in names("out")


def test_sidecar_of_a_comparison_tells_the_verdict_and_the_worst_deviation():
    made = comparison(
        ["signum", "stick-slip"],
        *axes(force=[15, 45], rms=[0.33]),
        n=800,
        verdict=("off", "so"),
    )
    told = compare(made)
    assert told["verdict"] == ["off", "so"]
    assert told["numerics"]["approaches"] == ["signum", "stick-slip", "viscous"]
    assert told["numerics"]["yardstick"] == "stick-slip"
    worst = told["metrics"]["signum"]["T_a_deviation"]
    assert worst["value"] > 0.5
    assert worst["where"] == {FORCE: 45.0, RMS: 0.33}
    assert "T_a_deviation" not in told["metrics"]["stick-slip"]
    assert told["inputs"][0]["file"] == "road.csv"


def test_two_sweeps_differ_in_created_alone(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write(small(limit=0.015), "one", plots=True)
    write(small(limit=0.015), "two", plots=True)
    assert names("one") == names("two") == [
        "drysim.json", "scenario.yaml", "stroke.png", "stroke_violations.csv",
        "transmissibility.csv", "transmissibility.png",
    ]  # fmt: skip
    for name in names("one"):
        assert Path("one", name).read_bytes() == Path("two", name).read_bytes(), name


# the folder that is worked in

CASES = '{"what": 1}\n{"number": 0}\n'


def interrupted(cases=CASES, table=None):
    """Leave a sweep half done, as Ctrl-C does."""
    with output.claim_partial(Path("out")) as claim:
        claim.journal.write_text(cases)
        return write(small() if table is None else table, claim, exit_code=130)


def test_claim_is_finished_in_place_of_the_old_folder():
    write(small(), plots=True)
    with output.claim_partial(Path("out")) as claim:
        assert claim.partial == Path("out.partial")
        claim.journal.write_text(CASES)
        write(small(limit=0.015), claim)
    assert names(".") == ["out"]
    assert "stroke_violations.csv" in names("out")
    assert "transmissibility.png" not in names("out")
    assert folder.JOURNAL not in names("out")
    assert folder.JOURNAL not in json.loads(Path("out/drysim.json").read_text())["files"]


def test_interrupted_sweep_keeps_its_cases_and_the_old_folder():
    write(small())
    told = interrupted()
    assert names(".") == ["out", "out.partial"]
    assert names("out.partial") == [
        "cases.jsonl", "drysim.json", "scenario.yaml", "transmissibility.csv"
    ]  # fmt: skip
    assert (told["complete"], told["exit_code"]) == (False, 130)
    assert json.loads(Path("out.partial/drysim.json").read_text()) == told
    assert Path("out.partial/cases.jsonl").read_text() == CASES
    assert json.loads(Path("out/drysim.json").read_text())["complete"] is True


def test_resume_keeps_the_finished_cases_and_nothing_else():
    interrupted()
    with output.claim_partial(Path("out"), resume=True) as claim:
        assert names(claim.partial) == ["cases.jsonl", "drysim.json"]
        assert claim.journal.read_text() == CASES
        write(small(), claim)
    assert names(".") == ["out"]


def test_without_resume_a_sweep_begins_anew():
    interrupted()
    with output.claim_partial(Path("out")) as claim:
        assert names(claim.partial) == ["drysim.json"]


def test_nothing_stays_of_a_sweep_without_a_finished_case():
    empty = Table(small().scenario, small().axes, (), complete=False)
    told = interrupted('{"what": 1}\n', empty)
    assert told["metrics"] == {}
    assert names(".") == []


@pytest.mark.parametrize(
    ("cases", "left"), [(CASES, ["out.partial"]), ('{"what": 1}\n', []), (None, [])]
)
def test_fault_in_a_sweep_keeps_finished_cases_only(cases, left):
    def fail():
        with output.claim_partial(Path("out")) as claim:
            if cases:
                claim.journal.write_text(cases)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert names(".") == left


def test_full_disk_at_the_end_keeps_the_finished_cases(monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(output, "own", full)

    def end():
        with output.claim_partial(Path("out")) as claim:
            claim.journal.write_text(CASES)
            write(small(), claim)

    with pytest.raises(OutputError, match="no space left"):
        end()
    assert names("out.partial") == ["cases.jsonl", "drysim.json"]


def test_foreign_partial_is_refused_and_stays():
    Path("out.partial").mkdir()
    Path("out.partial/cases.jsonl").write_text("mine")
    with (
        pytest.raises(OutputError, match=r"out\.partial was not written by drysim"),
        output.claim_partial(Path("out"), resume=True),
    ):
        pass
    assert Path("out.partial/cases.jsonl").read_text() == "mine"


@pytest.mark.skipif(os.name == "nt", reason="folders cannot be locked there")
def test_two_sweeps_at_once_do_not_mix():
    with output.claim_partial(Path("out")) as claim:
        claim.journal.write_text(CASES)
        for resume in (False, True):
            with (
                pytest.raises(OutputError, match="another drysim is writing out"),
                output.claim_partial(Path("out"), resume),
            ):
                pass
        assert claim.journal.read_text() == CASES


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_instant_leaves_what_resumes():
    def act():
        with output.claim_partial(Path("out"), resume=True) as claim:
            claim.journal.write_text(CASES)
            (claim.partial / "events.csv").write_text("new")
            folder.mark(claim.partial, '{"format": 1, "files": {"events.csv": ""}}')
            folder.finish(claim)

    at, kept = [], 0
    for passed in kills(act):
        at.append(passed)
        output.check(Path("out"))
        assert set(names(".")) <= {"out", "out.partial"}
        if Path("out.partial/cases.jsonl").exists():
            kept += 1
            assert not Path("out").exists()
            with output.claim_partial(Path("out"), resume=True) as claim:
                assert claim.journal.read_text() in ("", CASES)
        act()
        assert names("out") == ["drysim.json", "events.csv"]
        shutil.rmtree("out")
    assert at[-1] > 100 > kept > 2
