"""A scenario from a stranger: it runs nothing, and touches its record and its folder alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from drysim import output
from drysim.errors import OutputError
from seat import SEAT

PROGRAM = """\
import json, os, sys
from fuzz.watch import OURS, PROGRAMS, CHANGES
touched = set()
def note(event, words):
    if event in PROGRAMS and words[0] is not None:
        touched.add(f"{event} {words[0]}")
    if event == "open" and isinstance(words[0], str | bytes) or event in CHANGES:
        path = os.path.realpath(os.fsdecode(words[0]))
        if not path.startswith(OURS) and not path.startswith(sys.base_prefix):
            touched.add(os.path.relpath(path))
from drysim.cli import main
sys.addaudithook(note)
code = main(sys.argv[1:])
sys.stdout = sys.__stdout__
print("\\n" + json.dumps([code, sorted(touched)]))
"""

RECORDED = """\
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: FILE, column: u_dd, time: t}
"""
ROWS = "t [s],u_dd [m/s2]\n0.00,0.1\n0.01,0.2\n0.02,0.3\n0.03,0.1\n"
HARMONIC = "kind: harmonic, frequency: 1.6, rms: 1.0"


def touched(folder, *words):
    """Run drysim in a process; give its exit code and what it opened, changed or ran."""
    environment = os.environ | {"DRYSIM_ENGINE": "plain"}
    path = [str(Path(__file__).parent), environment.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words],
        cwd=folder,
        env=environment | {"PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
    )
    code, paths = json.loads(done.stdout.splitlines()[-1])
    return code, set(paths)


def test_run_touches_scenario_record_and_folder_alone(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "data").mkdir()
    (tmp_path / "data/base.csv").write_text(ROWS)
    (tmp_path / "in/seat.yaml").write_text(RECORDED.replace("FILE", "../data/base.csv"))
    code, paths = touched(tmp_path / "in", "run", "seat.yaml", "--no-plots", "-q")
    assert code == 0
    outside = {path for path in paths if not path.startswith("out/seat")}
    assert outside == {"seat.yaml", "../data/base.csv", "out"}


EVIL = {
    "tag that runs a program": SEAT + "about: !!python/object/apply:os.system [touch owned]\n",
    "tag of an object": SEAT + "start: !!python/object/new:os.system [touch owned]\n",
    "folder above": SEAT.replace("name: seat", "name: ../../owned"),
    "absolute folder": SEAT.replace("name: seat", "name: /tmp/owned"),
    "folder of a home": SEAT.replace("name: seat", "name: ~root"),
    "hidden folder": SEAT.replace("name: seat", "name: .ssh"),
    "folder with a line end": SEAT.replace("name: seat", 'name: "a\\nb"'),
    "folder with an escape": SEAT.replace("name: seat", 'name: "a\\e[31m"'),
    "password file": RECORDED.replace("FILE", "/etc/passwd"),
    "device": RECORDED.replace("FILE", "/dev/zero"),
    "process": RECORDED.replace("FILE", "/proc/self/environ"),
    "address": RECORDED.replace("FILE", "http://127.0.0.1:9/x.csv"),
    "pipe of a shell": RECORDED.replace("FILE", "'|touch owned'"),
    "formula": SEAT + "checks: ['__import__(\"os\").system(\"touch owned\") < 1']\n",
    "formula as a unit": SEAT + "stroke: {limit: '1 __import__(\"os\").abort()'}\n",
    "power as a unit": SEAT + "stroke: {limit: '1 m^9^9^9^9'}\n",
    "options of numpy": SEAT.replace(HARMONIC, "kind: record, file: a.npy, allow_pickle: true"),
}  # fmt: skip


@pytest.mark.parametrize("text", EVIL.values(), ids=EVIL)
def test_scenario_that_means_harm_is_refused_and_nothing_happens(drysim, tmp_path, text):
    (tmp_path / "seat.yaml").write_text(text)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    answer = drysim("run", "seat.yaml")
    assert answer.code == 2, answer
    assert "Traceback" not in answer.err
    assert "root:" not in answer.err
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before


@pytest.mark.slow
@pytest.mark.parametrize("text", EVIL.values(), ids=EVIL)
def test_scenario_that_means_harm_touches_nothing_but_itself(tmp_path, text):
    (tmp_path / "seat.yaml").write_text(text)
    code, paths = touched(tmp_path, "run", "seat.yaml")
    assert code == 2
    assert paths <= {"seat.yaml"}


def test_column_that_drives_the_terminal_is_shown_and_not_obeyed(drysim, tmp_path):
    (tmp_path / "seat.yaml").write_text(RECORDED.replace("FILE", '"a\\e]0;owned\\a.csv"'))
    for file, rows in {
        "a\x1b]0;owned\x07.csv": ROWS.replace("u_dd", "\x1b[2Ju_dd\u202e"),
        "b.csv": ROWS,
    }.items():
        (tmp_path / file).write_text(rows)
    said = drysim("run", "seat.yaml").err
    assert "there is no column" in said
    assert all(sign.isprintable() for sign in said.replace("\n", ""))


def test_unit_and_key_that_drive_the_terminal_are_shown_and_not_obeyed(drysim, tmp_path):
    unit = SEAT + 'stroke: {limit: "25 m\\e[31m\\u009b2J"}\n"k\\e[2J\\u202e": 1\n'
    (tmp_path / "seat.yaml").write_text(unit)
    for words in (["run"], ["validate"], ["validate", "--format", "json"]):
        answer = drysim(*words, "seat.yaml")
        assert answer.code == 2
        assert all(sign.isprintable() for sign in (answer.out + answer.err).replace("\n", ""))


# Folders that somebody else has prepared


@pytest.mark.parametrize(
    "marker",
    ['{"format": 1, "files": 5}', '{"format": 1, "files": [["x"]]}',
     '{"format": 1, "files": null}', "[" * 10_000, "5", '{"format": "1"}',
     '{"format": ' + "1" * 5000 + "}", ""],
    ids=["number", "lists", "nothing", "deep", "no block", "text", "endless", "torn"],
)  # fmt: skip
def test_folder_with_a_strange_marker_is_refused_in_a_sentence(tmp_path, monkeypatch, marker):
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    Path("out/drysim.json").write_text(marker)
    Path("out/mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"drysim did not write|not written by drysim"):
        output.check(Path("out"))
    assert Path("out/mine.txt").read_text() == "mine"


def test_links_in_a_prepared_folder_lead_nowhere(drysim, seat):
    (seat.parent / "mine.txt").write_text("mine")
    (seat.parent / "mine").mkdir()
    (seat.parent / "mine/thesis.txt").write_text("years of work")
    for folder in ("out/seat", "out/seat.partial"):
        (seat.parent / folder).mkdir(parents=True)
        named = dict.fromkeys(("response.csv", "cases.jsonl", "sub", "cases.new"), "")
        marker = json.dumps({"format": 1, "files": named})
        (seat.parent / folder / "drysim.json").write_text(marker)
        for name in ("response.csv", "cases.jsonl", "cases.new"):
            (seat.parent / folder / name).symlink_to(seat.parent / "mine.txt")
        (seat.parent / folder / "sub").symlink_to(seat.parent / "mine")
    assert drysim("run", seat, "--no-plots").code == 0
    assert (seat.parent / "mine.txt").read_text() == "mine"
    assert (seat.parent / "mine/thesis.txt").read_text() == "years of work"
    assert not (seat.parent / "out/seat/response.csv").is_symlink()


@pytest.mark.parametrize(("target", "code"), [("/dev/zero", 0), ("mine.txt", 2), ("mine", 2)])
def test_finished_cases_that_are_links_are_never_taken_as_such(drysim, seat, target, code):
    (seat.parent / "mine.txt").write_text("mine")
    (seat.parent / "mine").mkdir()
    partial = seat.parent / "out/seat.partial"
    partial.mkdir(parents=True)
    (partial / "drysim.json").write_text('{"format": 1}')
    if target == "mine":
        (partial / "cases").symlink_to(seat.parent / target)
    else:
        (partial / "cases").mkdir()
        (partial / "cases/sweep.json").symlink_to(seat.parent / target)
    words = ("--resume", "--no-plots", "--set", "sweep={excitation.frequency: [1, 2]}")
    assert drysim("sweep", seat, *words).code == code
    assert (seat.parent / "mine.txt").read_text() == "mine"
    assert list((seat.parent / "mine").iterdir()) == []
