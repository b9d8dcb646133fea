"""The command line: exit codes, streams and files."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from seat import fields_of, tree
from typer.main import get_command

from drysim import __version__, output
from drysim.cli import COMMANDS, app
from drysim.core.model import CoulombLaw
from drysim.errors import SolverError
from drysim.manual import pages
from drysim.study import gallery

RUN_FILES = ["drysim.json", "events.csv", "response.csv", "response.png", "scenario.yaml"]
WITHOUT_PICTURE = [name for name in RUN_FILES if not name.endswith(".png")]


# run


def test_run_writes_its_files_in_place_of_another_run_and_ends_with_0(drysim, seat):
    place = seat.parent / "here"
    for words, files in ((), RUN_FILES), (("--no-plots",), WITHOUT_PICTURE):
        answer = drysim("run", seat, *words, f"--out={place}")
        assert answer.code == 0, answer.err
        assert "T_a" in answer.out
        assert sorted(file.name for file in place.iterdir()) == files
    assert sorted(file.name for file in seat.parent.iterdir()) == ["here", "seat.yaml"]
    assert str(seat.parent) not in (place / "drysim.json").read_text()


def test_json_is_exactly_one_object_on_stdout_also_with_warnings(drysim, seat):
    answer = drysim("run", seat, "--json", "--no-plots", "--set", "stroke.limit=1 mm")
    sidecar = json.loads(answer.out)
    assert answer.code == sidecar["exit_code"] == 0
    assert sidecar["format"]
    assert [warning["slug"] for warning in sidecar["warnings"]] == ["stroke-violated"]
    assert sidecar["metrics"]["violations"] > 0
    assert sidecar == fields_of("out/seat")


def test_quiet_prints_nothing_but_faults(drysim, seat):
    assert drysim("run", seat, "-q", "--no-plots", "--set", "stroke.limit=1 mm")[1:] == ("", "")
    assert drysim("run", "none.yaml", "-q").err != ""


def test_dry_run_tells_the_base_and_how_strong_a_record_is(drysim, seat, tmp_path):
    assert "base: harmonic " in drysim("run", seat, "--dry-run").out
    (seat.parent / "r.csv").write_text("a [mm/s2]\n" + "500\n-500\n" * 100)
    record = "excitation={kind: record, file: r.csv, rate: 100}"
    less = ("--set", "solver.step=null", "--set", "measure=null")
    words = ("run", seat, "--dry-run", "--set", record, *less)
    told = "base: record r.csv, 200 samples at 100 Hz, 1.99 s, 0.2887 m/s² RMS, linear between"
    assert told in drysim(*words).out


def test_help_lists_every_command_in_a_whole_sentence(drysim, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    listed = drysim("--help").out.partition("Commands:")[2].split("\n")
    names = [line.split()[0] for line in listed if line.strip()]
    assert names == [command.__name__ for command in COMMANDS]
    assert all(line.endswith(".") and "..." not in line for line in listed if line.strip())


def test_run_and_sweep_say_that_they_replace_each_other(drysim, seat):
    over = ("--no-plots", "--set", "sweep={friction.kinetic: [10, 20]}")
    assert "replaced" not in drysim("run", seat, *over).err
    told = "the run in out/seat will be replaced; use --out to keep it\n"
    assert drysim("sweep", seat, *over).err.startswith(told)
    told = "the sweep in out/seat will be replaced; use --out to keep it\n"
    assert drysim("run", seat, *over).err.startswith(told)
    assert "replaced" not in drysim("run", seat, *over).err
    drysim("sweep", seat, *over)
    assert drysim("run", seat, *over, "--quiet")[1:] == ("", told)


def test_folder_of_a_study_has_the_name_of_the_command_once(drysim, seat):
    over = ("--no-plots", "--set", "name=seat-compare", "--set", "measure=null")
    compare = ("compare", "signum", "vs", "stick-slip", "-s", seat, *over)
    assert drysim(*compare).out.endswith("written     out/seat-compare\n")
    told = "the comparison in out/seat-compare will be replaced; use --out to keep it\n"
    assert drysim("run", seat, *over, "--dry-run").err == ""
    assert drysim("run", seat, *over).err.startswith(told)


def test_over_writes_the_sweep_block(drysim, seat):
    block = "{friction.kinetic: {from: 0, to: 0.02 kN, step: 5}, excitation.rms: [0.5, 1]}"
    assert drysim("sweep", seat, "--no-plots", "--set", f"sweep={block}").code == 0
    table = Path("out/seat/transmissibility.csv").read_text()
    resolved = Path("out/seat/scenario.yaml").read_text()
    over = ("--over", "friction.kinetic=0:0.02 kN:5", "--over", "excitation.rms=0.5,1")
    seat.write_text(seat.read_text() + "sweep: {start.x_r: [0, 1]}\n")  # is replaced
    for command in ("run", "sweep"):
        answer = drysim(command, seat, "--no-plots", *over, "-o", command)
        assert (answer.code, answer.err) == (0, "")
        assert Path(command, "transmissibility.csv").read_text() == table
        assert Path(command, "scenario.yaml").read_text() == resolved
    again = drysim("sweep", "run/scenario.yaml", "--no-plots", "-o", "again")
    assert again.code == 0
    assert Path("again/transmissibility.csv").read_text() == table


@pytest.mark.parametrize("command", ["branches", "map", "compare signum vs stick-slip"])
def test_over_is_taken_where_a_sweep_is(drysim, seat, command):
    seat.write_text(seat.read_text().replace("measure: ", "# "))
    over = ("--over", "excitation.frequency=1:9:0.25", "--over", "friction.kinetic=1:9:0.25")
    answer = drysim(
        *command.split(), seat, *over[: 2 if command == "branches" else 4], "--dry-run"
    )
    assert answer.code == 0
    assert "33" in answer.out


@pytest.mark.parametrize(
    ("over", "sentence"),
    [
        (["friction.kinetic=0:10"], "--over friction.kinetic=0:10 has no STEP"),
        (["friction.kinetic=:10:"], "has no FROM and STEP"),
        (["friction.kinetic=0:1:2:3"], "has more than FROM:TO:STEP"),
        (["=0:10:1"], "--over =0:10:1 has no key"),
        (["friction.kinetic"], "--over friction.kinetic has no values"),
        (["friction.kinetic=0,1"] * 2, "--over names friction.kinetic twice"),
        (["friction.kinetc=0,1"], "--over friction.kinetc=0,1: unknown key `friction.kinetc`"),
        (["friction.kinetic=0:5:2"], "friction.kinetic.to is not reached by steps of 2 N"),
        (["friction.kinetic=0:5 mm:1"], "`mm` is a unit of length, not force"),
        (["friction.kinetic=0..60"], "`0..60` is not a number several are FROM:TO:STEP"),
        (["friction.kinetic=0;10 N"], "`0;10 N` is not a number"),
        (["friction.kinetic=20"], "a single value `--set friction.kinetic=20` sets it"),
        (["friction.kinetic=0:1:}"], "this is not YAML"),
    ],
)
def test_faulty_over_is_said(refused, seat, over, sentence):
    words = [word for value in over for word in ("--over", value)]
    assert sentence in " ".join(refused("run", seat, *words).split())


@pytest.mark.parametrize(
    "change", ["sweep={excitation.rms: [0.5, 1]}", "sweep.excitation.rms=[1, 2]", "sweep=null"]
)
@pytest.mark.parametrize("command", ["run", "sweep", "compare signum vs stick-slip"])
def test_over_and_set_of_the_sweep_are_refused_together(drysim, refused, seat, command, change):
    over = ("--over", "friction.kinetic=5,15")
    key = change.partition("=")[0]
    told = f"--over makes the sweep block, which --set {key} would change"
    assert told in refused(*command.split(), seat, *over, "--set", change)
    assert drysim("sweep", seat, *over, "--set", "oscillator.mass=80", "--dry-run").code == 0


def test_block_to_copy_keeps_its_lines(refused, seat):
    assert refused("sweep", seat).endswith(
        "\nfor example:\n\nsweep:\n  friction.kinetic: {from: 0, to: 30, step: 3}\n\n"
        "or, without a block, --over friction.kinetic=0:30:3\n"
    )


def test_quiet_says_what_makes_the_exit_code(drysim, seat):
    failing = ("run", seat, "-q", "--no-plots", "--set", "checks=[T_a < 0.1, T_a > 0]")
    code, out, err = drysim(*failing)
    T_a = fields_of("out/seat")["metrics"]["T_a"]
    assert (code, out, err) == (1, "", f"check failed: T_a < 0.1, with {T_a:.6g}\n")
    unknown = ("run", seat, "-q", "--no-plots", "--set", "checks=[SEAT < 1]")
    assert drysim(*unknown) == (1, "", "check failed: SEAT < 1; SEAT is not known here\n")
    strict = ("--strict", "--set", "stroke.limit=1 mm")
    code, out, err = drysim("run", seat, "-q", "--no-plots", *strict)
    assert (code, out) == (1, "")
    assert "the stroke limit of 1 mm is exceeded" in err


def test_check_about_another_case_is_not_judged_and_fails_under_strict_alone(drysim, seat):
    check = "T_a < 0.1 at friction.kinetic >= 500"
    words = ("run", seat, "--no-plots", "--set", f"checks=[{check}]")
    code, out, err = drysim(*words)
    sentence = f"{check}; the condition is not met"
    assert (code, err) == (0, "")
    assert f"  · skipped   {sentence}\n" in out
    told = json.loads(drysim(*words, "--json").out)["checks"]
    assert told == [
        {
            "check": check, "metric": "T_a", "operator": "<", "limit": 0.1, "unit": "-",
            "passed": None, "value": None, "reason": "the condition is not met",
        }
    ]  # fmt: skip
    assert sentence in drysim("summarise", seat.parent / "out/seat").out
    assert drysim(*words, "--strict", "-q") == (1, "", f"check skipped: {sentence}\n")


def test_warning_fails_under_strict_only(drysim, seat):
    words = ("run", seat, "--no-plots", "--set", "stroke.limit=1 mm")
    answer = drysim(*words)
    assert answer.code == 0
    assert "the stroke limit of 1 mm is exceeded" in answer.err
    assert "first at t = " in answer.err
    assert "mm beyond the limit" in " ".join(answer.err.split())
    assert drysim(*words, "--strict").code == fields_of("out/seat")["exit_code"] == 1


def test_approach_is_chosen_on_the_command_line(drysim, seat):
    viscous = ("--approach", "viscous", "--set", "friction=null")
    answer = drysim("run", seat, "--json", "--no-plots", *viscous)
    assert json.loads(answer.out)["numerics"]["approach"] == "viscous"


def test_mistyped_approach_is_a_fault_with_a_near_name(refused, seat):
    error = refused("run", seat, "--approach", "stickslip")
    assert "\n--approach stickslip: " in error
    assert "stick-slip" in error


def test_resolved_scenario_runs_again_and_gives_the_same_numbers(drysim, seat):
    drysim("run", seat, "--no-plots", "--set", "friction.kinetic=30")
    drysim("run", "out/seat/scenario.yaml", "--no-plots", "-o", "again")
    assert fields_of("again")["metrics"] == fields_of("out/seat")["metrics"]


# dry run


def test_dry_run_says_what_and_where_and_writes_nothing(drysim, seat):
    before = tree(seat.parent)
    answer = drysim("run", seat, "--dry-run")
    assert answer.code == 0
    assert "800 steps" in answer.out
    assert os.path.join("out", "seat") in answer.out
    plan = json.loads(drysim("run", seat, "--dry-run", "--json").out)
    assert (plan["steps"], plan["folder"]) == (800, "out/seat")
    assert tree(seat.parent) == before


PLAIN = "engine: DRYSIM_ENGINE=plain: kernels run as plain Python, up to 100 times slower\n"


@pytest.mark.parametrize(
    "words",
    [
        "run seat-on-em1.yaml",
        "sweep paper-low-friction.yaml",
        "compare signum vs stick-slip -s paper-random.yaml",
        "fit fit-seat.yaml",
        "map regime-map.yaml",
        "design design-seat.yaml",
    ],
)
def test_dry_run_says_that_no_compiled_code_is_used(drysim, tmp_path, monkeypatch, words):
    monkeypatch.chdir(Path(__file__).parents[1] / "scenarios")
    for engine in ("plain", "compiled", "auto"):
        monkeypatch.setenv("DRYSIM_ENGINE", engine)
        told = drysim(*words.split(), "--dry-run", "--out", tmp_path / "out").out
        assert (PLAIN in told) == ("engine:" in told) == (engine == "plain")


def test_dry_run_says_that_kernels_cannot_be_kept(drysim, seat, monkeypatch):
    monkeypatch.setenv("DRYSIM_ENGINE", "auto")
    monkeypatch.setattr("drysim.study.doctor.private_folder", lambda name: None)
    told = drysim("run", seat, "--dry-run").out
    assert "engine: no writable cache folder: each command compiles its kernels anew" in told
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert (
        "engine: NUMBA_DISABLE_JIT is set: kernels run" in drysim("run", seat, "--dry-run").out
    )


def test_dry_run_finds_the_same_faults(refused, seat):
    assert refused("run", seat, "--dry-run", "--set", "oscillator.mass=-1")
    (seat.parent / "file").write_text("")
    assert refused("run", seat, "--dry-run", "-o", "file/deep")


# command line


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("rum seat.yaml", "Did you mean 'run'"),
        ("run seat.yaml --strct", "--strict"),
        ("run", "Missing argument"),
        ("fit a.yaml b.yaml", "unexpected extra argument"),
        ("validate --format xml seat.yaml", "'xml' is not one of"),
        ("run seat.yaml --set", "requires an argument"),
        ("run seat.yaml --set friction.kinetic", "KEY=VALUE"),
        ("run seat.yaml --picture-format gif", "'png', 'svg', 'pdf'"),
        ("init paper-low-frictoin", "did you mean `paper-low-friction`"),
    ],
)
def test_wrong_words_end_with_2_and_one_sentence(refused, seat, words, sentence):
    assert sentence.lower() in refused(*words.split()).lower()


def test_no_words_show_the_help_and_end_with_2(drysim):
    answer = drysim()
    assert answer.code == 2
    assert answer.out == ""
    assert "validate" in answer.err


def test_help_and_version_end_with_0(drysim):
    assert drysim("--version") == (0, f"drysim {__version__}\n", "")
    assert drysim("run", "--help").code == 0


def test_unknown_engine_is_a_fault_of_the_command_line(process, seat):
    answer = process("run", seat, DRYSIM_ENGINE="turbo")
    assert answer.code == 2
    assert "DRYSIM_ENGINE" in answer.err
    assert "Traceback" not in answer.err


@pytest.mark.parametrize(
    ("fault", "code", "sentences"),
    [
        (ZeroDivisionError("a bug"), 70, ["Traceback", "ZeroDivisionError: a bug", "report"]),
        (MemoryError(), 2, ["error: out of memory"]),
        (KeyboardInterrupt(), 130, ["interrupted"]),
    ],
)
def test_only_a_bug_shows_its_traceback_and_nothing_is_written(
    drysim, seat, monkeypatch, fault, code, sentences
):
    def broken(*_):
        raise fault

    monkeypatch.setattr("drysim.study.run.solve", broken)
    before = tree(seat.parent)
    answer = drysim("run", seat)
    assert answer.code == code
    assert all(sentence in answer.err for sentence in sentences)
    assert ("Traceback" in answer.err) == (code == 70)
    assert tree(seat.parent) == before


def test_reader_of_stdout_may_leave_early(seat):
    command = f"{sys.executable} -m drysim schema | head -c 1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", command], cwd=seat.parent, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "{", "")


def test_finished_cases_are_said_to_be_given_up_only_where_they_are(drysim, seat):
    words = ["sweep", seat, "--no-plots", "--set", "sweep={excitation.frequency: [1, 2]}"]
    with output.lock_partial(Path("out/seat")) as claim:
        (claim.partial / "cases").mkdir()
        (claim.partial / "cases/000000.npz").write_text("a finished block")
        refused = drysim(*words)
    assert refused.code == 2
    assert "another drysim process is writing" in refused.err
    assert "starting over" not in refused.err
    assert "starting over: finished cases" in drysim(*words).err


def test_seeds_of_an_interrupted_run_are_never_discarded_silently(drysim, seat):
    sweep = ["sweep", seat, "--no-plots", "--set", "sweep={excitation.frequency: [1, 2]}"]
    seeds = Path("out/seat.partial/seeds/000000.npz")

    def interrupt():
        seeds.parent.mkdir(parents=True)
        seeds.write_text("a finished block")
        (seeds.parents[1] / "drysim.json").write_text('{"format": 1, "complete": false}')

    interrupt()
    for words in (sweep, [*sweep, "--resume"]):
        answer = drysim(*words)
        assert answer.code == 0
        assert "starting over: finished seeds in out/seat.partial are disc" in answer.err
        assert "(`drysim run --resume` keeps them)" in answer.err
        interrupt()
    assert "starting over: finished seeds" in drysim(*sweep, "--quiet").err
    interrupt()
    for silence in ((), ("--quiet",)):
        answer = drysim("run", seat, "--no-plots", *silence)
        assert answer.code == 0
        assert "discards the finished seeds in out/seat.partial; use --out" in answer.err
        interrupt()


def test_fault_that_nobody_reads_keeps_its_exit_code(tmp_path):
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "drysim", "run", "nowhere.yaml"]
    done = subprocess.run(command, cwd=tmp_path, stdout=write, stderr=write)
    os.close(write)
    assert done.returncode == 2


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
def test_full_stdout_is_a_fault_and_not_a_traceback(seat):
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "drysim", "schema"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert "cannot write to stdout" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_closed_streams_change_nothing_but_what_is_heard(seat, closed):
    command = f"{sys.executable} -m drysim run seat.yaml --no-plots {closed}"
    done = subprocess.run(
        ["bash", "-c", command], cwd=seat.parent, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (seat.parent / "out/seat/response.csv").exists()


# several scenarios


@pytest.fixture
def three(seat):
    """Write three scenarios: without checks, with one that holds, with one that fails."""
    checks = {"holds": "checks: [T_a < 9]\n", "fails": "checks: [T_a < 0.1, T_a > 0]\n"}
    texts = {"quiet": "", **checks}
    for name, checks in texts.items():
        text = seat.read_text().replace("name: seat", f"name: {name}") + checks
        seat.with_name(f"{name}.yaml").write_text(text)
    seat.unlink()
    return [seat.with_name(f"{name}.yaml") for name in texts]


def test_several_scenarios_have_a_folder_and_a_line_each_and_the_worst_exit_code(drysim, three):
    code, out, err = drysim("run", *three, "--no-plots")
    assert (code, err) == (1, "")
    assert out.splitlines()[:3] == [
        "ok: quiet: no checks; out/quiet",
        "ok: holds: 1 check holds; out/holds",
        "fails: fails: 1 of 2 checks fails; out/fails",
    ]
    assert out.count("✗ fails") == 1
    assert [fields_of(f"out/{file.stem}")["exit_code"] for file in three] == [0, 0, 1]
    assert drysim("run", *three[:2], "--no-plots", "--quiet") == (0, "", "")


def test_several_scenarios_are_swept(drysim, three):
    words = ["--over", "friction.kinetic=5,15", "--no-plots"]
    for command in ("run", "sweep"):
        code, out, _ = drysim(command, *three, *words)
        assert code == 1
        assert "ok: holds: 1 check holds; out/holds" in out
        assert "fails: fails: 1 of 2 checks fails; out/fails" in out
    assert (three[0].parent / "out/quiet/transmissibility.csv").exists()


def test_out_of_several_scenarios_holds_their_folders(drysim, three):
    assert drysim("run", *three, "--no-plots", "-q", "--out", "results").code == 1
    folders = sorted(path.name for path in three[0].parent.joinpath("results").iterdir())
    assert folders == ["fails", "holds", "quiet"]
    assert "name one of them, such as results/fails" in drysim("summarise", "results").err


@pytest.mark.parametrize("out", ["results", "out"])
@pytest.mark.parametrize(
    ("suffix", "sentence"),
    [
        ("", "{} is a result itself"),
        (".partial", "{0} has {0}.partial beside it"),
        (".replaced", "{0} has {0}.replaced beside it"),
    ],
)
def test_several_scenarios_are_never_written_into_a_result(
    drysim, refused, three, out, suffix, sentence
):
    assert drysim("run", three[0], "--no-plots", "-q", "--out", out).code == 0
    place = Path(out).rename(out + suffix)
    error = refused("run", *three, *(["--out", out] if out != "out" else []))
    assert f"error: {sentence.format(out)}: the results of several scenarios" in error
    place.rename(out)
    assert drysim("run", three[0], "--no-plots", "-q", "--out", out).code == 0


def test_result_within_a_result_is_named(drysim, refused, three):
    for out in ("results", "results/inner"):
        assert drysim("run", three[0], "--no-plots", "-q", "--out", out).code == 0
    error = refused("run", three[0], "--no-plots", "--out", "results")
    assert "error: results holds another result, inner" in error


def test_nothing_is_written_where_one_of_several_scenarios_is_refused(refused, three):
    assert "several scenarios are named quiet" in refused("run", three[0], three[0])
    error = refused("run", *three, "--workers", 2)
    assert all(f"error: {file}: --workers needs several seeds" in error for file in three)
    mine = three[2].parent / "out/fails/notes.txt"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    assert "was not written by drysim" in refused("run", *three)
    for file in three[1:]:
        file.write_text(file.read_text().replace("stiffness", "stifness"))
    error = refused("run", *three)
    assert all(f"error: {file}: 1 error" in error for file in three[1:])


def test_several_results_and_plans_are_one_json_object(drysim, three):
    answer = drysim("run", *three, "--no-plots", "--json")
    results = json.loads(answer.out)["results"]
    assert [each["scenario"]["name"] for each in results] == ["quiet", "holds", "fails"]
    assert [each["exit_code"] for each in results] == [0, 0, 1]
    plans = json.loads(drysim("run", *three, "--dry-run", "--json").out)["plans"]
    assert [each["folder"] for each in plans] == ["out/quiet", "out/holds", "out/fails"]
    shown = drysim("run", *three, "--dry-run").out
    assert [line for line in shown.splitlines() if line.startswith("output folder")] == [
        f"output folder: out/{name}" for name in ("quiet", "holds", "fails")
    ]


def test_reasons_and_warnings_of_several_scenarios_name_theirs(drysim, three):
    answer = drysim("run", *three, "--no-plots", "-q", "--set", "stroke.limit=1 mm", "--strict")
    assert answer.code == 1
    lines = answer.err.splitlines()
    assert any(line.startswith("check failed: fails: T_a < 0.1, with ") for line in lines)
    assert any(line.startswith("warning: quiet: the stroke limit of 1 mm") for line in lines)


def test_numerics_that_fail_in_one_of_several_scenarios_stop_no_other(
    drysim, three, monkeypatch
):
    from drysim.study import run

    whole = run.solve

    def solve(case):
        if case.scenario.name == "holds":
            raise SolverError("the numerics failed at t = 1 s")
        return whole(case)

    monkeypatch.setattr(run, "solve", solve)
    code, out, err = drysim("run", *three, "--no-plots")
    assert code == 3
    assert err == "error: holds: the numerics failed at t = 1 s\n"
    assert "ok: quiet" in out
    assert "fails: fails" in out


# validate, schema, init, doctor


def test_validate_fails_on_warnings_under_strict_and_is_silent_of_what_does_not_fail(
    drysim, seat
):
    doubtful, faulty = seat.with_name("doubtful.yaml"), seat.with_name("faulty.yaml")
    doubtful.write_text(seat.read_text() + "stroke: {limit: 60}\n")
    faulty.write_text(seat.read_text().replace("stiffness", "stifness"))
    assert drysim("validate", seat, doubtful, "-q") == (0, "", "")
    assert drysim("validate", seat, "--strict", "-q") == (0, "", "")
    code, out, _ = drysim("validate", seat, doubtful, "--strict", "-q")
    assert code == 1
    assert "doubtful.yaml:8:10: warning: stroke.limit is 60 m" in out
    assert "seat.yaml" not in out
    code, out, _ = drysim("validate", seat, doubtful, faulty, "-q")
    assert code == 2
    assert "faulty.yaml:3" in out
    assert "did you mean `stiffness`" in out
    assert "doubtful.yaml" not in out
    told = json.loads(drysim("validate", doubtful, "-q", "--format", "json").out)
    (problem,) = told["files"][0]["problems"]
    assert (problem["severity"], problem["line"], problem["column"]) == ("warning", 8, 10)


def test_schema_is_json_with_descriptions(drysim):
    described = json.loads(drysim("schema").out)
    assert "oscillator" in described["properties"]
    assert "description" in json.dumps(described)


def test_init_never_replaces_a_file(refused, tmp_path):
    (tmp_path / "paper-low-friction.yaml").write_text("mine")
    assert "already exists" in refused("init", "paper-low-friction")


def test_list_shows_every_scenario_and_which_have_pictures(drysim):
    listed = drysim("init", "--list")
    shown = {line.split()[0]: line for line in listed.out.splitlines() if line.strip()}
    assert {file.stem for file in gallery.folder().glob("*.yaml")} <= shown.keys()
    marked = {name for name, line in shown.items() if line.endswith("[loop]")}
    assert marked == {file.stem for file in (gallery.folder() / gallery.LOOPS_FOLDER).iterdir()}
    assert str(gallery.folder() / gallery.LOOPS_FOLDER) in "".join(listed.err.splitlines())
    assert "drysim init --list hard" in listed.err
    assert "friction-lugre.png" in drysim("init", "friction-lugre").err


def test_list_shows_every_hard_case_by_the_name_it_is_taken_out_with(drysim):
    names = [f"hard/{file.stem}" for file in sorted(gallery.folder().glob("hard/*.yaml"))]
    assert names
    shown = drysim("init", "--list", "hard").out.splitlines()
    assert [line.split()[0] for line in shown] == names


def test_every_scenario_of_the_gallery_can_be_taken_out_and_is_sound(drysim, tmp_path):
    hard = gallery.list_scenarios(gallery.HARD_FOLDER)
    for piece in (*gallery.list_scenarios(), *hard):
        answer = drysim("init", piece.name)
        assert (answer.code, answer.out.split("\n")[0]) == (0, piece.file.name)
        assert drysim("validate", piece.file.name).code == 0


def test_doctor_solves_and_runs_a_scenario_to_its_picture(drysim, monkeypatch):
    answer = drysim("doctor")
    assert answer.code == 0, answer.out
    for told in ("22.42355635", "1.307242", "free-decay and its picture"):
        assert told in answer.out

    def broken(*_):
        raise AttributeError("no such method")

    monkeypatch.setattr("drysim.plots.response.draw", broken)
    code, out, _ = drysim("doctor")
    assert code == 3
    assert "FAIL  run          AttributeError: no such method" in out


@pytest.mark.parametrize(
    ("least", "sound"), [("1", True), ("1.26.0", True), ("2.0.0", False), ("1.27", False)]
)
def test_doctor_checks_versions_against_the_minimums(drysim, monkeypatch, least, sound):
    declared = [f"numpy>={least}", "ruff>=1000; extra == 'dev'", "pyuff>=1; extra == 'uff'"]
    found = {"numpy": "1.26.0", "ruff": "1"}
    monkeypatch.setattr("drysim.study.doctor.requires", lambda _: declared)
    monkeypatch.setattr("drysim.study.doctor.version", lambda name: found.get(name, "99"))
    code, out, _ = drysim("doctor")
    wrong = [line for line in out.splitlines() if line.startswith("FAIL")]
    assert (code, wrong == []) == ((0, True) if sound else (3, False))
    if not sound:
        (line,) = wrong
        assert f"1.26.0 is older than {least}; update it: " in line


def test_doctor_finds_each_answer_wrong_if_friction_is_a_little_too_low(drysim, monkeypatch):
    def weaker(*forces):
        return CoulombLaw(*(0.999999 * force for force in forces))

    monkeypatch.setattr("drysim.study.doctor.CoulombLaw", weaker)
    code, out, _ = drysim("doctor")
    assert code == 3
    wrong = re.findall(r"^FAIL  (.*?)  ", out, re.M)
    assert wrong == ["free decay", "Den Hartog", "standstill"]


# Formats of pictures.

BEGINNINGS = {"png": b"\x89PNG\r\n", "svg": b"<?xml version", "pdf": b"%PDF-"}


@pytest.mark.parametrize("form", BEGINNINGS)
def test_pictures_are_written_in_the_format_that_is_asked_for(drysim, seat, form):
    words = ("--set", "sweep={friction.kinetic: [10, 20]}", "--picture-format", form)
    folders = []
    for folder in ("one", "two"):
        assert drysim("sweep", seat, *words, "--out", folder).code == 0
        folders.append(seat.parent / folder)
    for name in ("transmissibility", "stroke"):
        one, two = ((folder / f"{name}.{form}").read_bytes() for folder in folders)
        assert one.startswith(BEGINNINGS[form])
        assert one == two
    assert drysim("run", seat, "--picture-format", form, "--out", "one").code == 0
    suffixes = {file.suffix for file in folders[0].iterdir()}
    assert suffixes == {".yaml", ".json", ".csv", f".{form}"}


def test_help_of_each_command_ends_with_two_examples_that_run_and_its_page(drysim, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    group = get_command(app)
    names = [scenario.name for scenario in gallery.list_scenarios()]
    assert {drysim("init", name).code for name in names} == {0}
    assert drysim("run", "seat-on-em1.yaml", "--no-plots").code == 0
    for name in group.commands:
        *_, examples, more = drysim(name, "--help").out.strip().split("\n\n")
        title, *lines = examples.split("\n")
        assert title.strip().startswith("Examples")
        assert len(lines) == 2
        assert more.strip().removeprefix("More: drysim manual ") in pages()
        for line in lines:
            assert len(line) <= 80
            program, command, *arguments = shlex.split(re.split(r" [|>] | && ", line)[0])
            assert (program, command) == ("drysim", name)
            assert group.commands[name].make_context(name, [*arguments])
            if any("--dry-run" in option.opts for option in group.commands[name].params):
                assert drysim(name, *arguments, "--dry-run").code == 0, line
            elif name not in ("init", "validate", "doctor"):
                assert drysim(name, *arguments).code == 0, line
