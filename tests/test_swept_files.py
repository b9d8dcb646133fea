"""A sweep over records: every file is read, hashed, and solved over its own length."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from seat import fields_of, write_records

import drysim as package
from drysim.excitation.recorded import Record
from drysim.plots.sweep import file_labels
from drysim.scenario.files import file_hashes
from drysim.study.preparation import prepare
from drysim.study.store import Store, work_identity
from drysim.study.sweep import solve

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
    Path("seat.yaml").write_text(SCENARIO)
    return write_records(Path("runs"), COUNT)


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


def test_one_table_and_scenario_have_all_files_whatever_the_number_of_workers(drysim, runs):
    tables = []
    for workers in (1, 2, 3):
        out = f"out/{workers}"
        words = "sweep", "seat.yaml", "--no-plots", "--workers", workers, "--out", out
        assert drysim(*words).code == 0
        tables.append(Path(out, "transmissibility.csv").read_bytes())
    assert tables[0] == tables[1] == tables[2]
    header, *rows = tables[0].decode().splitlines()
    assert header.startswith("approach,excitation.file,friction.kinetic [N],F_fk [N],")
    assert [row.split(",")[1] for row in rows] == 2 * runs
    frame = package.sweep(package.load("seat.yaml")).to_frame()
    assert frame["excitation.file"].tolist() == 2 * runs
    inputs = fields_of("out/1")["inputs"]
    assert [one["file"] for one in inputs] == runs
    for one in inputs:
        content = Path(one["file"]).read_bytes()
        assert one["sha256"] == hashlib.sha256(content).hexdigest()
    again = drysim("sweep", "out/1/scenario.yaml", "--no-plots", "--out", "out/again")
    assert again.code == 0
    theirs = package.load("out/1/scenario.yaml").sweep[0].values
    assert [Path("out/1", file).resolve() for file in theirs] == [
        Path(file).resolve() for file in package.load("seat.yaml").sweep[0].values
    ]


def test_pictures_of_files_are_drawn(drysim, runs):
    assert drysim("sweep", "seat.yaml", "--out", "out/lines").code == 0
    files = "sweep={excitation.file: runs/*.csv}"
    assert drysim("sweep", "seat.yaml", "--set", files).code == 0
    for folder in ("out/lines", "out/seat"):
        for name in ("transmissibility.png", "stroke.png"):
            assert Path(folder, name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("kept", [0, 0.3, 0.99])
def test_interrupted_sweep_over_files_is_resumed_to_the_same_bytes(drysim, runs, kept):
    many = "sweep={excitation.file: runs/*.csv, friction.kinetic: {from: 0, to: 40, count: 9}}"
    words = ("sweep", "seat.yaml", "--no-plots", "--set", many)
    scenario = package.load("seat.yaml", [many])
    assert drysim(*words).code == 0
    whole = Path("out/seat/transmissibility.csv").read_bytes()
    partial = Path("out/seat.partial")
    partial.mkdir()
    store = Store(partial / "cases", work_identity(scenario), resume=False)
    solve(prepare(scenario, swept=True), store=store)
    # A power cut may lose the latest files, and the end of one.
    files = sorted(store.folder.glob("*.npz"))
    first, *lost = files[int(kept * len(files)) :]
    first.write_bytes(first.read_bytes()[:-17])
    for file in lost:
        file.unlink()
    (partial / "drysim.json").write_text('{"format": 1, "complete": false}')
    assert drysim(*words, "--resume").code == 0
    assert Path("out/seat/transmissibility.csv").read_bytes() == whole
    assert not partial.exists()


def test_interrupted_sweep_over_files_is_not_resumed_once_a_file_has_changed(drysim, runs):
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


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (
            "nothing/*.csv",
            "sweep.excitation.file is a pattern that matches no file: `nothing/*.csv`",
        ),
        ("nothing/*.csv", "; there is no folder `nothing`"),
        ("runs/*.txt", "; write one such as `records/*.csv`, relative to this file"),
        ("runs", "is a folder, `runs`; write a pattern: `excitation.file: runs/*.csv`"),
        ("runs/", "is a folder, `runs/`; write a pattern: `excitation.file: runs/*.csv`"),
        (
            "[runs/]",
            "excitation.file #1 is a folder, `runs/`; write a pattern: `excitation.file",
        ),
        ("[runs/*.csv]", "file #1 is a pattern, not a file; write it without a list: `exc"),
        ("[]", "sweep.excitation.file has no files"),
        ("[1]", "sweep.excitation.file #1 must be the name of a file, not 1"),
        ("[runs/run-01.csv, runs/run-01.csv]", "is a duplicate: `runs/run-01.csv`"),
        ("{from: 1, to: 2, count: 2}", "must be a list of files"),
        ("[runs/run-01.csv, runs/missing.csv]", "missing.csv: the record does not exist"),
    ],
)
def test_fault_of_the_files_is_located_before_any_work(drysim, runs, value, words):
    change = ("--set", f"sweep={{excitation.file: {value}}}")
    answer = drysim("validate", "seat.yaml", *change)
    assert answer.code == 2
    assert words in answer.out
    assert drysim("sweep", "seat.yaml", *change).code == 2
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("runs", "6:20: sweep.excitation.file is a folder"),
        ("[runs/]", "6:21: sweep.excitation.file #1 is a folder"),
        ("no/*.csv", "6:20: sweep.excitation.file is a pattern that matches no file"),
        (
            "[runs/run-01.csv, runs/run-91.csv]",
            "6:38: sweep.excitation.file #2: runs/run-91.csv:",
        ),
    ],
)
def test_fault_of_the_files_is_at_its_place_in_the_scenario(drysim, runs, value, words):
    Path("seat.yaml").write_text(SCENARIO.replace("runs/*.csv", value))
    for command in ("validate", "sweep"):
        answer = drysim(command, "seat.yaml")
        assert answer.code == 2
        assert f"seat.yaml:{words}" in answer.out + answer.err


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("u_dd", "acc", "there is no column `u_dd`; there are: `t [s]`, `acc [m/s2]`"),
        ("[m/s2]", "", "has no unit"),
        ("t [s]", "s", "there is no column `t`"),
    ],
)
def test_record_of_another_layout_is_told_from_the_others(drysim, runs, old, new, fault):
    Path(runs[4]).write_text(Path(runs[4]).read_text().replace(old, new, 1))
    answer = drysim("validate", "seat.yaml")
    assert answer.code == 2
    words = " ".join(answer.out.split())
    assert f"{runs[4]}:1:" in words
    assert fault in words
    assert "; all files are read with the same keys of `excitation`" in words
    assert f"which suit `{runs[0]}`: give this file the same columns and units, or" in words


def test_fault_of_a_sample_says_nothing_about_the_other_records(drysim, runs):
    rows = Path(runs[4]).read_text().splitlines()
    Path(runs[4]).write_text("\n".join([*rows[:50], "0.49,abc", *rows[51:]]))
    answer = drysim("validate", "seat.yaml")
    assert "`abc` is not a number" in answer.out
    assert "all files" not in answer.out


def test_warning_about_one_of_the_files_names_it(drysim, runs):
    rows = Path(runs[5]).read_text().splitlines()
    clipped = rows[:50] + [f"{row.split(',')[0]},9.000000" for row in rows[50:60]] + rows[60:]
    Path(runs[5]).write_text("\n".join(clipped) + "\n")
    answer = drysim("validate", "seat.yaml")
    assert "runs/run-05.csv: 10 samples look clipped" in answer.out


def test_each_warning_about_the_files_is_given_once(runs):
    for i, file in enumerate(runs):  # shocks that are cut while the base moves
        rows = [f"{0.01 * k:.2f},{(i + 5) * (k > 40):.6f}" for k in range(60)]
        Path(file).write_text("\n".join(["t,u_dd [m/s^2]", *rows]) + "\n")
    warnings = prepare(package.load("seat.yaml"), swept=True).warnings
    cut = [one.sentence for one in warnings if one.slug == "response-cut"]
    assert [one.partition(":")[0] for one in cut] == runs
    assert len({one.sentence for one in warnings}) == len(warnings)


def test_file_cannot_be_swept_where_there_is_no_record(drysim, tmp_path):
    Path("x.yaml").write_text(
        "oscillator: {mass: 1, stiffness: 1, damping: 1}\n"
        "excitation: {kind: harmonic, frequency: 1, rms: 1}\n"
        "sweep: {excitation.file: [a.csv]}\n"
    )
    answer = drysim("validate", "x.yaml")
    assert answer.code == 2
    assert "excitation.file" in answer.out


def test_window_beyond_the_end_of_one_file_is_a_fault_that_names_it(drysim, runs):
    settle = ("--set", "measure={settle: 5 s}", "--set", "excitation.file=runs/run-15.csv")
    answer = drysim("validate", "seat.yaml", *settle)
    assert answer.code == 2
    assert "runs/run-00.csv: measure.settle" in answer.out
    assert drysim("sweep", "seat.yaml", *settle).code == 2
    assert not Path("out").exists()


def test_run_reads_and_names_its_own_record_only(drysim, runs):
    Path(runs[9]).write_text("no record\n")
    assert drysim("validate", "seat.yaml").code == 2
    assert drysim("run", "seat.yaml", "--no-plots").code == 0
    inputs = fields_of("out/seat")["inputs"]
    assert [one["file"] for one in inputs] == [runs[0]]


def test_unused_record_of_the_scenario_is_no_input_of_the_sweep(drysim, runs):
    files = f"sweep={{excitation.file: [{runs[1]}, {runs[2]}]}}"
    assert drysim("sweep", "seat.yaml", "--no-plots", "--set", files).code == 0
    inputs = fields_of("out/seat")["inputs"]
    assert [one["file"] for one in inputs] == runs[1:3]


def test_results_have_no_absolute_path(drysim, runs):
    here = Path().resolve()
    files = f"sweep={{excitation.file: '{here}/runs/run-0?.csv'}}"
    assert drysim("sweep", "seat.yaml", "--set", files, "--picture-format", "svg").code == 0
    for file in Path("out/seat").iterdir():
        assert str(here) not in file.read_text(), file


def test_each_file_is_read_once_to_be_checked_and_once_to_be_solved(runs, monkeypatch):
    read, whole = [], Record.motion

    def counted(self, *rest):
        read.append(self.file)
        return whole(self, *rest)

    monkeypatch.setattr(Record, "motion", counted)
    package.sweep(package.load("seat.yaml", {"reference": "viscous"}), workers=1)
    assert max(read.count(file) for file in runs[1:]) == 2


def test_labels_of_files_are_short_and_distinct():
    name = "m/2024-05-17/a very long name of a measurement run number {} of the day.csv"
    labels = file_labels([name.format(number) for number in range(45)])
    assert max(map(len, labels)) <= 24
    assert len({*labels}) == 45
    name = "m/line {} in the morning of a long day in the year 2024.csv"
    labels = file_labels([name.format(number) for number in (3, 10, 31)])
    assert labels == ["…3…", "…10…", "…31…"]
    assert file_labels(["runs/a.csv", "runs/b.csv"]) == ["a", "b"]
    assert file_labels(["runs/a.csv", "b.wav"]) == ["runs/a.csv", "b.wav"]


def test_groups_of_keys_take_no_files(drysim, runs):
    zipped = "sweep={zip: {excitation.file: [runs/run-01.csv], friction.kinetic: [1]}}"
    answer = drysim("validate", "seat.yaml", "--set", zipped)
    assert answer.code == 2
    assert "must be a key of sweep itself" in answer.out


def test_key_that_one_file_of_a_pattern_has_not_is_a_located_fault(drysim, runs):
    Path("runs/x.wav").write_bytes(b"RIFF")
    Path("seat.yaml").write_text(
        SCENARIO.replace("*.csv", "*").replace("time: t,", "time: t, skip: 1,")
    )
    answer = drysim("validate", "seat.yaml")
    assert answer.code == 2
    assert "excitation.skip: a WAV is not a text table" in answer.out


@pytest.mark.parametrize("condition", ["== runs/run-01.csv", "> 3"])
def test_condition_on_a_record_is_refused_with_what_to_do(drysim, runs, condition):
    check = f"checks=['T_a < 1 at excitation.file {condition}']"
    words = " ".join(drysim("validate", "seat.yaml", "--set", check).out.split())
    assert "`excitation.file` after `at` is not a numeric key of this scenario; cond" in words
    assert "put a record with limits of its own into a scenario of its own" in words


def test_summary_has_number_level_and_clean_up_of_the_records(drysim, runs):
    text = SCENARIO.replace("column: u_dd", "column: u_dd, remove: {below: 0.5 Hz}")
    Path("seat.yaml").write_text(text)
    found = [prepare(package.load("seat.yaml", {"sweep": None, "excitation.file": one}))
             for one in (runs[0], runs[-1])]  # fmt: skip
    summaries = prepare(package.load("seat.yaml"), swept=True).records
    for one, summary in zip(found, (summaries[0], summaries[-1]), strict=True):
        level = one.scenario.excitation.describe(one.motion).split(" m/s² RMS")[0].split()[-1]
        assert f"{summary.rms:.4g}" == level
    done = drysim("sweep", "seat.yaml", "--no-plots")
    words = " ".join(done.out.split())
    low, high = (f"{pick(one.rms for one in summaries):.4g}" for pick in (min, max))
    assert f"base record from {COUNT} files, 2.99 to 10.59 s, {low} to {high} m/s² RMS" in words
    assert f"cleaned {runs[0]}: frequencies below 0.5 Hz removed" in words
    assert f"{COUNT - 1} more records likewise" in words


def test_level_of_records_is_not_stated_where_their_scale_varies(drysim, runs):
    text = SCENARIO.replace("friction.kinetic: [0, 20]", "excitation.scale: [1, 2]")
    Path("seat.yaml").write_text(text)
    words = drysim("sweep", "seat.yaml", "--no-plots").out
    assert f"record from {COUNT} files, 2.99 to 10.59 s\n" in words
