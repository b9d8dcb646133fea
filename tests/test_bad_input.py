"""Bad input: exit code 2, a sentence that names what and where, and not a byte changed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

RECORDED = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: base.csv, column: u_dd, time: t}
"""

SOUND = "t [s],u_dd [m/s2]\n0.00,0.1\n0.01,0.2\n0.02,0.3\n0.03,0.1\n"


@pytest.mark.parametrize("content", [None, b"\n\n  \n", bytes(range(256)) * 4, b"- 1\n- 2\n"])
def test_faulty_scenario_is_refused_by_every_command(refused, tmp_path, drysim, content):
    """Each fault has its sentence in `tests/problems`."""
    if content is not None:
        (tmp_path / "bad.yaml").write_bytes(content)
    assert "bad.yaml: " in refused("run", "bad.yaml")
    answer = drysim("validate", "bad.yaml")
    assert answer.code == 2
    assert "bad.yaml" in answer.out + answer.err


RECORDS = {
    "text cell": (SOUND.replace("0.2", "high"), ["base.csv:3", "high"]),
    "uneven steps": (SOUND.replace("0.02", "0.025"), ["base.csv:", "step"]),
    "no such column": (SOUND.replace("u_dd", "acc"), ["u_dd", "acc"]),
    "empty": ("", ["base.csv", "empty"]),
}


@pytest.mark.parametrize(("text", "words"), RECORDS.values(), ids=RECORDS)
def test_faulty_record_is_refused(refused, tmp_path, drysim, text, words):
    (tmp_path / "seat.yaml").write_text(RECORDED)
    (tmp_path / "base.csv").write_text(text)
    said = refused("run", "seat.yaml")
    assert [word for word in words if word not in said] == []
    assert drysim("validate", "seat.yaml").code == 2


def test_missing_record_is_refused(drysim, refused, tmp_path):
    """The message names the line of the scenario, of a record of base or mass."""
    (tmp_path / "seat.yaml").write_text(RECORDED)
    place = r"seat\.yaml:\d+:\d+: excitation\.file: base\.csv: the record does not exist\n  \d"
    assert re.search(place, refused("run", "seat.yaml"))
    assert drysim("validate", "seat.yaml").code == 2


ALTERNATIVES = {
    "damping: 25 %": "oscillator.damping: `%` is a unit of ratio, not damping [N·s/m]; did you "
    "mean `damping_ratio`?",
    "stiffness: 1.6 Hz": "oscillator.stiffness: `Hz` is a unit of frequency, not stiffness "
    "[N/m]; did you mean `natural_frequency`?",
    "mass: 75 N": "oscillator.mass: `N` is a unit of force, not mass [kg]\n",
}


@pytest.mark.parametrize(("line", "sentence"), ALTERNATIVES.items())
def test_unit_of_another_key_names_that_key(refused, tmp_path, line, sentence):
    keys = {"mass": "75", "stiffness": "7500", "damping": "500"}
    name, _, value = line.partition(": ")
    block = "".join(f"  {key}: {text}\n" for key, text in (keys | {name: value}).items())
    (tmp_path / "seat.yaml").write_text(f"oscillator:\n{block}excitation: {{kind: rest}}\n")
    assert sentence in refused("run", "seat.yaml")


def test_missing_key_is_marked_in_its_block_or_in_none(refused, tmp_path):
    (tmp_path / "seat.yaml").write_text(
        "oscillator:\n  mass: 75\n  damping: 1\nexcitation: {kind: psd}\n"
    )
    said = refused("run", "seat.yaml")
    assert "  1 │ oscillator:\n    │ ^^^^^^^^^^ in this block\n" in said
    (tmp_path / "seat.yaml").write_text("excitation: {kind: rest}\n")
    said = refused("run", "seat.yaml")
    assert "  1 │ excitation: {kind: rest}\n    │ ^^^^^^^^^^ in this file\n" in said
    assert "measure.duration is required for rest\n" in said
    assert "^^^^ there is no block `measure`\n" in said


def test_window_beyond_the_end_of_the_record_is_refused(drysim, refused, tmp_path):
    (tmp_path / "seat.yaml").write_text(RECORDED + "measure: {settle: 0, duration: 1}\n")
    (tmp_path / "base.csv").write_text(SOUND)
    said = refused("run", "seat.yaml")
    assert "seat.yaml:4:" in said
    assert "0.03 s" in said
    assert drysim("validate", "seat.yaml").code == 2


def test_more_memory_than_the_machine_has_is_refused_with_the_number(drysim, refused, seat):
    said = refused("run", seat, "--set", "measure.duration=1e12")
    assert "GB of memory" in said
    assert "4e+14 steps" in said
    assert drysim("validate", seat, "--set", "measure.duration=1e12").code == 2


def test_sharpness_that_asks_for_more_points_than_memory_holds_is_refused(refused, seat):
    words = ("--approach", "smooth", "--set", "solver.smooth.sharpness=1e15")
    said = refused("run", seat, *words)
    assert "solver.smooth subdivides each step" in said
    assert "GB of memory" in said


def test_result_whose_scenario_was_edited_is_refused_as_output(drysim, seat, tmp_path):
    assert drysim("run", seat, "--no-plots").code == 0
    assert drysim("run", seat, "--no-plots").code == 0
    edited = tmp_path / "out" / "seat" / "scenario.yaml"
    edited.write_text(edited.read_text() + "# mine\n")
    answer = drysim("run", seat, "--no-plots")
    assert answer.code == 2
    assert "scenario.yaml was edited since drysim wrote it" in answer.err
    assert "save it elsewhere" in answer.err
    assert edited.read_text().endswith("# mine\n")


def test_output_is_refused_before_anything_is_computed(seat):
    program = (
        "import sys, drysim.cli\n"
        "code = drysim.cli.main(['run', 'seat.yaml', '-o', 'seat.yaml/deep'])\n"
        "print(code, 'drysim.study.run' in sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=seat.parent, capture_output=True, text=True
    )
    assert done.stdout == "2 False\n"


@pytest.mark.parametrize("option", [(), ("--dry-run",)])
def test_disk_without_room_for_all_responses_is_told_before_the_work(
    refused, seat, monkeypatch, option
):
    almost_full = SimpleNamespace(total=10**12, used=10**12 - 100_000, free=100_000)
    monkeypatch.setattr("shutil.disk_usage", lambda place: almost_full)
    monkeypatch.setattr("drysim.study.run.solve", lambda case: pytest.fail("began to work"))
    short = seat.with_name("short.yaml")
    text = seat.read_text().replace("name: seat", "name: short")
    short.write_text(text.replace("duration: 2", "duration: 1"))
    said = " ".join(refused("run", short, seat, *option).split())
    assert "cannot write out: it needs about 120 kB, and 100 kB are free" in said
    assert "use a longer step or a shorter duration, free disk space" in said


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("seat.csv", SOUND.encode()),
        ("quoted.csv", b'"t [s]","u_dd [m/s2]"\n0,1\n0.1,2\n'),
        ("words first.txt", b"Device: ABC\nt,u\n0,1\n0.1,2\n"),
        ("seat.wav", b"RIFF\0\0\0\0WAVE"),
    ],
)
@pytest.mark.parametrize("command", ["run", "sweep", "validate"])
def test_record_in_place_of_a_scenario_is_told_how_to_become_one(
    drysim, tmp_path, monkeypatch, name, content, command
):
    monkeypatch.chdir(tmp_path)
    Path(name).write_bytes(content)
    answer = drysim(command, name)
    assert answer.code == 2
    quoted = f"'{name}'" if " " in name else name
    words = f"`drysim init --from {quoted}` writes a scenario for a record"
    assert words in " ".join((answer.out + answer.err).split())


def test_fault_of_a_scenario_or_of_a_name_says_nothing_about_records(drysim, tmp_path):
    file = tmp_path / "seat.txt"
    file.write_text("oscillator: {mass: 1}\n")
    for wrong in (file, tmp_path / "none.csv"):
        assert "init --from" not in drysim("validate", wrong).out
