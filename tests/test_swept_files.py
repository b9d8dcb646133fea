"""A sweep over records: every file is read, hashed, and solved over its own length."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

import drysim as package

SCENARIO = """\
oscillator: {mass: 75 kg, stiffness: 3500 N/m, damping: 250}
friction: {law: coulomb, kinetic: 20 N, static_ratio: 1.2}
stroke: {limit: 8 mm}
excitation: {kind: record, file: runs/run-00.csv, time: t, column: u_dd}
sweep:
  excitation.file: runs/*.csv
  friction.kinetic: [0, 20]
"""
COUNT = 20


@pytest.fixture
def runs(tmp_path, monkeypatch):
    """Write records of different lengths and levels, and a scenario that sweeps them."""
    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    random = np.random.default_rng(1)
    for number in range(COUNT):
        n = 300 + 40 * number
        u_dd = np.cumsum(random.normal(size=n)) * 0.1
        u_dd -= u_dd.mean()
        rows = "".join(f"{k / 100:.2f},{u:.6f}\n" for k, u in enumerate(u_dd))
        Path(f"runs/run-{number:02d}.csv").write_text("t [s],u_dd [m/s2]\n" + rows)
    Path("seat.yaml").write_text(SCENARIO)
    return [f"runs/run-{number:02d}.csv" for number in range(COUNT)]


def without(text):
    """Return the scenario without its sweep."""
    return text.partition("sweep:")[0]


def test_each_case_is_the_run_of_its_file(runs):
    table = package.sweep(package.load("seat.yaml"))
    assert [row.point["excitation.file"] for row in table][:COUNT] == runs
    Path("one.yaml").write_text(without(SCENARIO))
    for row in list(table)[::7]:
        single = package.run(package.load("one.yaml", dict(row.point)))
        assert single.metrics["T_a"] == pytest.approx(row.metrics["T_a"], rel=1e-12)
        assert single.metrics["x_r_peak"] == pytest.approx(row.metrics["x_r_peak"], rel=1e-12)


def test_a_list_is_taken_in_its_order_and_a_pattern_in_that_of_the_names(runs):
    some = [runs[7], runs[2]]
    scenario = package.load("seat.yaml", {"sweep": {"excitation.file": some}})
    assert [row.point["excitation.file"] for row in package.sweep(scenario)] == some
    assert list(package.load("seat.yaml").sweep[0].values) == runs


def test_one_table_has_all_files_and_is_the_same_with_any_number_of_workers(drysim, runs):
    tables = []
    for workers in (1, 2):
        out = f"out/{workers}"
        code = drysim(
            "sweep", "seat.yaml", "--no-plots", "--workers", workers, "--out", out
        ).code
        assert code == 0
        tables.append(Path(out, "transmissibility.csv").read_bytes())
    assert tables[0] == tables[1]
    header, *rows = tables[0].decode().splitlines()
    assert header.startswith("approach,excitation.file,friction.kinetic [N],F_fk [N],")
    assert [row.split(",")[1] for row in rows] == 2 * runs


def test_every_file_is_an_input_with_its_hash(drysim, runs):
    assert drysim("sweep", "seat.yaml", "--no-plots").code == 0
    inputs = json.loads(Path("out/seat/drysim.json").read_text())["inputs"]
    assert [one["file"] for one in inputs] == runs
    for one in inputs:
        content = Path(one["file"]).read_bytes()
        assert one["sha256"] == hashlib.sha256(content).hexdigest()


def test_written_scenario_reads_the_same_files(drysim, runs):
    assert drysim("sweep", "seat.yaml", "--no-plots").code == 0
    again = drysim("sweep", "out/seat/scenario.yaml", "--no-plots", "--out", "out/again")
    assert again.code == 0
    ours = package.load("seat.yaml").sweep[0].values
    theirs = package.load("out/seat/scenario.yaml").sweep[0].values
    assert [Path("out/seat", file).resolve() for file in theirs] == [
        Path(file).resolve() for file in ours
    ]


def test_pictures_of_files_are_drawn(drysim, runs):
    assert drysim("sweep", "seat.yaml", "--out", "out/lines").code == 0
    files = {"sweep": {"excitation.file": "runs/*.csv"}}
    assert (
        drysim("sweep", "seat.yaml", "--set", f"sweep={json.dumps(files['sweep'])}").code == 0
    )
    for folder in ("out/lines", "out/seat"):
        for name in ("transmissibility.png", "stroke.png"):
            assert Path(folder, name).read_bytes().startswith(b"\x89PNG")


def test_interrupted_sweep_over_files_is_not_resumed_once_a_file_has_changed(drysim, runs):
    from drysim.study.case import file_hashes

    before = file_hashes(package.load("seat.yaml"))
    Path(runs[3]).write_text(Path(runs[3]).read_text() + "99.00,0.1\n")
    after = file_hashes(package.load("seat.yaml"))
    changed = {name for name in before if before[name] != after[name]}
    assert changed == {"sweep.excitation.file.3"}


def test_a_name_with_a_comma_is_one_cell(drysim, runs):
    Path(runs[0]).rename("runs/a, b.csv")
    sweep = '{excitation.file: ["runs/a, b.csv"]}'
    change = ("--set", f"sweep={sweep}", "--set", "excitation.file=runs/run-01.csv")
    assert drysim("sweep", "seat.yaml", "--no-plots", *change).code == 0
    assert '"runs/a, b.csv"' in Path("out/seat/transmissibility.csv").read_text()


def test_table_of_files_is_a_frame(runs):
    frame = package.sweep(package.load("seat.yaml")).to_frame()
    assert frame["excitation.file"].tolist() == 2 * runs


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (
            "nothing/*.csv",
            "sweep.excitation.file is a pattern that matches no file: `nothing/*.csv`",
        ),
        ("[]", "must be a list of files, or a pattern such as `runs/*.csv`"),
        ("[1]", "sweep.excitation.file.0 must be the name of a file, not 1"),
        ("[runs/run-01.csv, runs/run-01.csv]", "is a duplicate: `runs/run-01.csv`"),
        ("{from: 1, to: 2, count: 2}", "must be a list of files"),
        ("[runs/run-01.csv, runs/missing.csv]", "missing.csv: the record does not exist"),
    ],
)
def test_fault_of_the_files_is_located_before_any_work(drysim, runs, value, words):
    answer = drysim("validate", "seat.yaml", "--set", f"sweep={{excitation.file: {value}}}")
    assert answer.code == 2
    assert words in answer.out
    assert (
        drysim("sweep", "seat.yaml", "--set", f"sweep={{excitation.file: {value}}}").code == 2
    )
    assert not Path("out").exists()


def test_warning_about_one_of_the_files_names_it(drysim, runs):
    rows = Path(runs[5]).read_text().splitlines()
    clipped = rows[:50] + [f"{row.split(',')[0]},9.000000" for row in rows[50:60]] + rows[60:]
    Path(runs[5]).write_text("\n".join(clipped) + "\n")
    answer = drysim("validate", "seat.yaml")
    assert "runs/run-05.csv: 10 samples look clipped" in answer.out


def test_file_cannot_be_swept_where_there_is_no_record(drysim, tmp_path):
    Path("x.yaml").write_text(
        "oscillator: {mass: 1, stiffness: 1, damping: 1}\n"
        "excitation: {kind: harmonic, frequency: 1, rms: 1}\n"
        "sweep: {excitation.file: [a.csv]}\n"
    )
    answer = drysim("validate", "x.yaml")
    assert answer.code == 2
    assert "excitation.file" in answer.out
