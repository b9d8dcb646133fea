"""The files of runs, sweeps and comparisons, and the folder that holds them."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import json
import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from grids import FORCE, FREQUENCY, RMS, axes, comparison, orbits, spoil, sweep
from hang import no_hang
from killing import ended, kills
from outcomes import SINE, judgement, names, outcome, record
from seat import rows_of, tree

from drysim import output
from drysim.bench import speed_error
from drysim.core.model import CoulombLaw
from drysim.errors import OutputError, WarningMessage
from drysim.metrics.checks import Check
from drysim.metrics.table import METRICS, UNITS
from drysim.output import folder
from drysim.output.folder import install_partial, read_stored_fields, write_marker
from drysim.results import all_kinds, kind_named, tables
from drysim.results import run as run_kind
from drysim.results.comparison import comparison_fields, write_comparison_csv
from drysim.results.fields import Provenance
from drysim.results.run import run_fields
from drysim.results.sweep import write_transmissibility_csv
from drysim.study import compare as study_compare
from drysim.study.statistics import FAILED, NOT_SETTLED, Row
from drysim.study.table import Table

pytestmark = pytest.mark.usefixtures("place")


def write(folder, made=None, **options):
    """Write a result into a folder; return what its sidecar says."""
    options = {"plots": False, "command": "drysim run seat.yaml", "exit_code": 0} | options
    place = Path(folder) if isinstance(folder, str) else folder
    return output.write(outcome() if made is None else made, place, **options)


def columns(file):
    """Read a table with the csv module of Python: header and columns."""
    with open(file, encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    return dict(zip(header, zip(*rows, strict=True), strict=True))


# tables


def test_response_reads_back_to_the_last_bit():
    made = outcome(CoulombLaw(45.0, 54.0), record(700))
    write("out", made)
    table = columns("out/response.csv")
    assert list(table) == [
        "t [s]", "u_dd [m/s2]", "x_r [m]", "v_r [m/s]", "x_dd [m/s2]", "F_f [N]", "stuck [-]",
    ]  # fmt: skip
    for name in ("t", "u_dd", "x_r", "v_r", "x_dd", "F_f", "stuck"):
        read = np.array(table[f"{name} [{tables.COLUMN_UNITS[name]}]"], dtype=float)
        assert np.array_equal(read, getattr(made.response, name)), name
    assert set(table["stuck [-]"]) == {"0", "1"}


def test_blocks_give_the_same_file_as_one_piece(monkeypatch):
    made = outcome()
    write("one", made)
    monkeypatch.setattr(run_kind, "BLOCK_SIZE", 7)
    write("many", made)
    for name in ("response.csv", "events.csv"):
        assert Path("one", name).read_bytes() == Path("many", name).read_bytes()


def test_tables_have_unix_lines_and_no_negative_zero():
    write("out", outcome(CoulombLaw(500.0, 500.0)))
    data = Path("out/response.csv").read_bytes()
    assert data.endswith(b"\n")
    assert b"\r" not in data
    assert b"-0.0," not in data


def test_events_begin_with_the_state_at_zero_and_name_directions():
    made = outcome()
    write("out", made)
    table = columns("out/events.csv")
    assert list(table) == ["t [s]", "event", "x_r [m]", "F_L [N]"]
    assert (table["t [s]"][0], table["event"][:2]) == ("0.0", ("stick", "slip-"))
    assert set(table["event"]) <= {"stick", "slip+", "slip-", "reversal+", "reversal-"}
    assert len(table["event"]) == len(made.events)


def test_stroke_violations_are_written_only_when_the_limit_was_met():
    write("kept", outcome(limit=0.1))
    assert "stroke_violations.csv" not in names("kept")
    made = outcome(limit=0.005)
    write("met", made)
    assert columns("met/stroke_violations.csv") == {
        "t_first [s]": (str(made.metrics["t_first_violation"]),),
        "x_r_peak [m]": (str(made.metrics["x_r_peak"]),),
        "t_beyond [s]": (str(made.metrics["t_beyond"]),),
        "violations [-]": (str(made.metrics["violations"]),),
    }


def test_violation_while_settling_shows_its_own_peak():
    made = outcome(limit=0.005)
    made.metrics["x_r_peak"] = 0.001
    whole = WarningMessage("stroke-violated", "met", {"x_r_peak": 0.007})
    write("out", replace(made, warnings=(whole,)))
    assert columns("out/stroke_violations.csv")["x_r_peak [m]"] == ("0.007",)


# sidecar


def test_sidecar_tells_what_made_the_numbers(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    made = outcome(
        CoulombLaw(15.0, 15.0), record(700), None, checks=["T_a < 9"], warnings=["careful"]
    )
    told = write("out", made)
    assert told == json.loads(Path("out/drysim.json").read_text())
    assert (told["format"], told["complete"], told["exit_code"]) == (2, True, 0)
    assert told["created"] == "1970-01-02T00:00:00Z"
    assert told["scenario"] == {
        "name": "seat", "file": "seat.yaml", "sha256": "cd" * 32, "overrides": {},
    }  # fmt: skip
    assert told["inputs"] == [{"file": "road.csv", "sha256": "ab" * 32, "size": 1234}]
    series = made.response.motion.u_dd.tobytes()
    assert told["excitation"]["sha256"] == hashlib.sha256(series).hexdigest()
    assert told["numerics"]["approach"] == "stick-slip"
    assert told["numerics"]["steps"] == len(made.response.x_r) - 1
    assert told["numerics"]["energy_residual"] == made.metrics["energy_residual"]
    assert told["metrics"] == made.metrics
    assert told["checks"] == [
        {
            "check": "T_a < 9",
            "metric": "T_a",
            "operator": "<",
            "limit": 9.0,
            "unit": "-",
            "passed": True,
            "value": made.metrics["T_a"],
        }
    ]
    assert told["units"] == {name: UNITS[name] for name in told["metrics"]}
    assert told["warnings"] == [{"slug": "slug", "sentence": "careful", "numbers": {}}]
    for name, sha256 in told["files"].items():
        assert hashlib.sha256(Path("out", name).read_bytes()).hexdigest() == sha256
    assert sorted([*told["files"], "drysim.json"]) == names("out")


@pytest.mark.parametrize("epoch", ["", "soon", "-", "9" * 30])
def test_senseless_source_date_is_the_time_of_day(monkeypatch, epoch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    assert run_fields(outcome(), Provenance("", 0, {}))["created"] > "2024"


def test_sidecar_names_no_folder_of_the_user():
    made = outcome(
        CoulombLaw(15.0, 15.0), record(700), None,
        warnings=["/home/joe/road.csv:3: gravity in m/s2, a/b", "see C:\\Users\\joe\\x.csv"],
        origin={
            "file": "/home/joe smith/seat.yaml",
            "sha256": "",
            "overrides": {"excitation.file": "/home/joe/road.csv", "excitation.unit": "m/s2"},
        },
    )  # fmt: skip
    command = "drysim run '/home/joe smith/seat.yaml' --out=/tmp/joe/x -o ~joe/y --set a=m/s2"
    told = run_fields(made, Provenance(command, 0, {}))
    assert "joe" not in json.dumps(told)
    assert told["command"] == "drysim run seat.yaml --out=x -o y --set a=m/s2"
    assert told["scenario"]["overrides"] == {
        "excitation.file": "road.csv", "excitation.unit": "m/s2",
    }  # fmt: skip
    assert told["warnings"][0]["sentence"] == "road.csv:3: gravity in m/s2, a/b"


def test_sidecar_is_strict_json_whatever_the_numbers():
    made = outcome(motion=SINE)
    made.metrics.update(T_a=float("inf"), T_x=float("nan"), violations=np.int64(3))
    told = json.loads(output.json_text(run_fields(made, Provenance("", 3, {}))))
    assert told["metrics"]["T_a"] is told["metrics"]["T_x"] is None
    assert told["metrics"]["violations"] == 3
    assert told["complete"] is False
    assert "sha256" not in told["excitation"]
    assert told["inputs"] == []


def test_two_runs_differ_in_created_alone():
    made = outcome()
    write("one", made, plots=True)
    write("two", made, plots=True)
    assert names("one") == names("two")
    for name in names("one"):
        texts = [Path(folder, name).read_bytes() for folder in ("one", "two")]
        if name == "drysim.json":
            told = [json.loads(text) | {"created": ""} for text in texts]
            assert told[0] == told[1]
        else:
            assert texts[0] == texts[1], name


# folder


def test_new_folder_replaces_what_drysim_wrote_and_nothing_is_left_beside():
    output.check_writable(Path("deep/out"))
    assert names(".") == []
    write("deep/out", plots=True)
    write("deep/out")
    assert names("deep") == ["out"]
    assert names("deep/out") == ["drysim.json", "events.csv", "response.csv", "scenario.yaml"]
    Path("empty").mkdir()
    write("empty")
    assert names("empty") == names("deep/out")


@pytest.mark.parametrize(
    ("folder", "file", "sentence"),
    [
        ("out", "out/thesis.txt", "out was not written by drysim"),
        ("out", "out/drysim.json", "out was not written by drysim"),
        ("ours", "ours/notes.txt", "ours holds notes.txt, which drysim did not write"),
        ("out", "out", "out is a file, not a folder"),
        ("out", "out.partial/mine.txt", "out.partial was not written by drysim"),
        ("out", "out.replaced", "out.replaced is a file, not a folder"),
        ("link", "", "link is a symbolic link"),
        ("nowhere", "", "nowhere is a symbolic link"),
    ],
)
def test_what_is_not_ours_is_refused_and_stays(folder, file, sentence):
    write("ours")
    Path("link").symlink_to("ours")
    Path("nowhere").symlink_to("does not exist")
    if file:
        Path(file).parent.mkdir(exist_ok=True)
        Path(file).write_text('{"my": "notes"}')
    before = tree(Path())
    for attempt in (output.check_writable, write):
        with pytest.raises(OutputError, match=sentence) as fault:
            attempt(Path(folder))
        assert "--out" in fault.value.hint
        assert fault.value.exit_code == 2
    assert tree(Path()) == before


@pytest.mark.parametrize(
    ("folder", "sentence"),
    [
        ("file/out", "file is not a folder"),
        ("file/a/b/out", "file is not a folder"),
        ("x" * 250, "name too long"),
        ("a\0b", "cannot be the name of a folder"),
        (".", "was not written by drysim"),
        ("..", "not written by drysim"),
        ("/", "not written by drysim"),
    ],
)
def test_folder_that_cannot_be_is_refused_before_any_work(folder, sentence):
    Path("file").write_text("mine")
    before = tree(Path())
    with pytest.raises(OutputError, match=sentence) as fault:
        output.check_writable(Path(folder))
    assert fault.value.hint
    assert tree(Path()) == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folder_without_permission_is_refused():
    Path("locked").mkdir(mode=0o500)
    with pytest.raises(OutputError, match="permission denied"):
        output.check_writable(Path("locked/out"))


@contextlib.contextmanager
def fresh(folder):
    """Return an empty folder that takes its place when the block ends well."""
    with output.lock_partial(folder) as claim:
        yield claim.partial
        install_partial(claim)


def fail_half_way(fault):
    with fresh(Path("out")) as partial:
        (partial / "response.csv").write_text("half")
        raise fault


def test_failure_while_writing_leaves_the_old_folder():
    write("out")
    before = tree(Path())
    with pytest.raises(OutputError, match="no space left") as fault:
        fail_half_way(OSError(28, "No space left on device"))
    assert "free disk space" in fault.value.hint
    with pytest.raises(KeyboardInterrupt):
        fail_half_way(KeyboardInterrupt())
    assert tree(Path()) == before
    assert names(".") == ["out"]


def test_two_at_once_do_not_mix():
    with fresh(Path("out")) as partial:
        (partial / "response.csv").write_text("first")
        for resume in (False, True):
            with (
                pytest.raises(OutputError, match="another drysim process is writing out"),
                output.lock_partial(Path("out"), resume),
            ):
                pass
        write_marker(partial, '{"format": 1, "files": {"response.csv": ""}}')
    assert Path("out/response.csv").read_text() == "first"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_instant_leaves_the_old_the_new_or_the_partial():
    def put(word):
        with fresh(Path("out")) as partial:
            (partial / "events.csv").write_text(word)
            write_marker(partial, '{"format": 1, "files": {"events.csv": ""}}')

    put("old")
    seen = []
    for _ in kills(lambda: put("new")):
        partial = Path("out.partial/events.csv")
        if Path("out").exists():
            word = Path("out/events.csv").read_text()
            assert sorted(json.loads(Path("out/drysim.json").read_text())["files"]) == [
                "events.csv"
            ]
        else:
            word = "partial"
            assert partial.read_text() == "new"
            with pytest.raises(OutputError, match="about to be replaced when its command was"):
                read_stored_fields(Path("out"))
        assert word in {"old", "new", "partial"}
        seen.append(word)
        assert set(names(".")) <= {"out", "out.partial", "out.replaced"}
        output.check_writable(Path("out"))
        put("old")
        assert names(".") == ["out"]
        assert Path("out/events.csv").read_text() == "old"
    assert len(seen) > 8
    assert set(seen) == {"old", "new", "partial"}


# files of somebody else, and what happens to the folders meanwhile

STRANGERS = ["notes.txt", "cases/notes.txt", "sub/notes.txt", "transmissibility/a.parquet"]


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("name", STRANGERS)
def test_file_of_the_user_in_the_partial_is_refused_and_stays(name, resume):
    Path("out.partial/cases").mkdir(parents=True)
    Path("out.partial/drysim.json").write_text('{"format": 1, "complete": false}')
    Path("out.partial", name).parent.mkdir(exist_ok=True)
    Path("out.partial", name).write_text("mine")
    before = tree(Path())
    with (
        pytest.raises(OutputError, match=f"out.partial holds {name}, which drysim did not"),
        output.lock_partial(Path("out"), resume),
    ):
        pass
    assert tree(Path()) == before


@pytest.mark.parametrize("name", STRANGERS)
def test_file_put_into_the_partial_meanwhile_is_never_removed(name):
    def fail():
        with output.lock_partial(Path("out")) as claim:
            (claim.partial / name).parent.mkdir(exist_ok=True, parents=True)
            (claim.partial / name).write_text("mine")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert Path("out.partial", name).read_text() == "mine"
    shutil.rmtree("out.partial")
    with output.lock_partial(Path("out")) as claim:
        (claim.partial / name).parent.mkdir(exist_ok=True, parents=True)
        (claim.partial / name).write_text("mine")
        assert name not in write(claim)["files"]
    assert Path("out", name).read_text() == "mine"
    with pytest.raises(OutputError, match="which drysim did not write"):
        output.check_writable(Path("out"))


def test_file_put_into_the_old_folder_meanwhile_is_never_removed():
    write("out")

    def late():
        with output.lock_partial(Path("out")) as claim:
            Path("out/notes.txt").write_text("mine")
            write(claim)

    with pytest.raises(OutputError, match=r"out holds notes\.txt, which drysim did not write"):
        late()
    assert Path("out/notes.txt").read_text() == "mine"


def test_kinds_know_their_files_by_name_and_no_others():
    named = {
        f"{name}.yaml"
        for name, _ in (*speed_error.BENCH_SCENARIOS, *speed_error.STEADY_SCENARIOS)
    }
    assert [name for name in named if not kind_named("bench").writes(name)] == []
    parts = "transmissibility/approach=viscous/000000000000.parquet"
    assert kind_named("sweep").writes(parts)
    foreign = (
        "notes.txt", "response.txt", "mine/response.csv", f"mine/{parts}", f"{parts}/x.parquet",
        "transmissibility/approach=viscous", "scenario.yaml.png",
    )  # fmt: skip
    assert [name for name in foreign for kind in all_kinds() if kind.writes(name)] == []


@pytest.mark.parametrize("again", [False, True], ids=["removed", "of another"])
def test_partial_that_is_removed_meanwhile_is_told(again):
    def lose():
        with output.lock_partial(Path("out")) as claim:
            shutil.rmtree(claim.partial)
            if again:
                claim.partial.mkdir()
            write(claim)

    with pytest.raises(OutputError, match=r"out\.partial was removed, in whole or in part"):
        lose()
    assert names(".") == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_read_only_old_folder_leaves_no_partial_behind():
    def act():
        os.umask(0o022)
        with contextlib.suppress(PermissionError):
            os.setuid(65534)  # nobody, where root runs the tests: root may write everywhere
        fresh_word("old")
        Path("out/transmissibility/approach=viscous").chmod(0o555)
        Path("out").chmod(0o555)
        fresh_word("new")
        assert names(".") == ["out"]
        assert Path("out/events.csv").read_text() == "new"

    home = Path(tempfile.mkdtemp())
    try:
        home.chmod(0o777)
        os.chdir(home)
        assert ended(act, lambda *_: None) == 0
    finally:
        os.chdir("/")
        shutil.rmtree(home)


def fresh_word(word):
    """Write a result of two files, one in a folder of its own."""
    with fresh(Path("out")) as partial:
        inner = partial / "transmissibility/approach=viscous"
        inner.mkdir(parents=True)
        (inner / "000000000000.parquet").write_text(word)
        (partial / "events.csv").write_text(word)
        files = {path.relative_to(partial).as_posix(): "" for path in partial.rglob("*.*")}
        write_marker(partial, json.dumps({"format": 1, "files": files}))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("spare", range(6))
def test_process_that_can_open_few_files_leaves_nothing_in_the_way(spare):
    import resource

    def act():
        free = os.dup(0)
        os.close(free)
        resource.setrlimit(resource.RLIMIT_NOFILE, (free + spare, free + spare))
        with contextlib.suppress(OutputError):
            write("out")

    assert ended(act, lambda *_: None) == 0
    assert set(names(".")) <= {"out", "out.partial"}
    write("out")
    assert names(".") == ["out"]


# The files of sweeps and comparisons: tables, sidecar, and the folder that is worked in.


HEADER = (
    "approach,excitation.frequency [Hz],excitation.rms [m/s2],F_fk [N],F_fs [N],a_u [m/s2],"
    "a_x [m/s2],T_a [-],T_x [-],x_r_rms [m],x_r_peak [m],stroke_used [-],stuck_share [-],"
    "chatter_share [-],violations [-],closure [-],status,"
    "multiplier_1 [-],multiplier_1_phase [rad],multiplier_2 [-],multiplier_2_phase [rad],"
    "stable [-]"
)


def small(**words):
    return sweep(*axes(frequency=[1, 2, 4], rms=[0.5, 1.0]), **words)


# tables


def test_every_case_reads_back_to_the_last_bit_in_the_order_of_the_grid():
    table = small()
    write("out", table)
    data = Path("out/transmissibility.csv").read_bytes()
    assert data.decode().split("\n", 1)[0] == HEADER
    assert data.endswith(b"\n")
    assert b"\r" not in data
    rows = rows_of("out/transmissibility.csv")
    assert len(rows) == len(table.rows) == 12
    for cells, row in zip(rows, table.rows, strict=True):
        assert (cells["approach"], cells["status"]) == (row.approach, "ok")
        assert float(cells["excitation.frequency [Hz]"]) == row.point[FREQUENCY]
        assert float(cells["excitation.rms [m/s2]"]) == row.point[RMS]
        assert (float(cells["F_fk [N]"]), float(cells["F_fs [N]"])) == (row.F_fk, row.F_fs)
        for name in ("a_u", "a_x", "T_a", "T_x", "x_r_rms", "x_r_peak", "closure"):
            (cell,) = (cells[key] for key in cells if key.split(" ")[0] == name)
            assert float(cell) == row.metrics[name], name
    frequencies = [row["excitation.frequency [Hz]"] for row in rows[:4]]
    assert frequencies == ["1.0", "2.0", "4.0", "1.0"]


def test_what_is_not_known_is_an_empty_cell():
    table = spoil(sweep(*axes(force=[0, 15], rms=[0.5]), limit=None), NOT_SETTLED, 1)
    write("out", table)
    good, lost, reference = rows_of("out/transmissibility.csv")
    assert (lost["T_a [-]"], lost["status"]) == ("", "not settled")
    assert (good["stroke_used [-]"], good["violations [-]"]) == ("", "")
    assert reference["friction.kinetic [N]"] == ""
    assert reference["excitation.rms [m/s2]"] == "0.5"


def test_stroke_violations_name_the_cases_of_the_seat_and_not_of_its_reference():
    table = small(limit=0.015)
    write("out", table)
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
    write("out", small(limit=1.0))
    assert "stroke_violations.csv" not in names("out")


def test_comparison_adds_the_deviation_from_the_reference_and_tells_the_worst():
    swept = axes(force=[15, 45], rms=[0.33, 0.67])
    made = comparison(["signum", "stick-slip"], *swept, n=800, verdict=("off", "so"))
    told = write("out", made)
    header = Path("out/comparison.csv").read_text().split("\n", 1)[0]
    assert header.endswith(",stable [-],T_a_deviation [-]")
    rows = rows_of("out/comparison.csv")
    own = {
        (row["friction.kinetic [N]"], row["excitation.rms [m/s2]"]): float(row["T_a [-]"])
        for row in rows
        if row["approach"] == "stick-slip"
    }
    for row in rows:
        at = row["friction.kinetic [N]"], row["excitation.rms [m/s2]"]
        if row["approach"] == "viscous":  # One row beside many of the reference.
            assert (at[0], row["T_a_deviation [-]"]) == ("", "")
        else:
            deviation = float(row["T_a [-]"]) / own[at] - 1.0
            assert float(row["T_a_deviation [-]"]) == deviation
    assert "stroke_violations.csv" not in names("out")
    assert told["verdict"] == ["off", "so"]
    assert told["numerics"]["approaches"] == ["signum", "stick-slip", "viscous"]
    assert told["numerics"]["yardstick"] == "stick-slip"
    worst = told["metrics"]["signum"]["T_a_deviation"]
    assert worst["value"] > 0.5
    assert worst["where"] == {FORCE: 45.0, RMS: 0.33}
    assert "T_a_deviation" not in told["metrics"]["stick-slip"]
    assert told["inputs"][0]["file"] == "road.csv"


def test_reference_without_friction_measures_every_case():
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
    assert study_compare.largest_deviation(found) is found[2]


def test_comparison_of_one_case_has_no_swept_columns():
    write("out", orbits(["signum", "stick-slip"]))
    rows = rows_of("out/comparison.csv")
    assert list(rows[0])[:2] == ["approach", "F_fk [N]"]
    assert float(rows[0]["T_a_deviation [-]"]) > 0.2


def test_cost_of_a_case_does_not_grow_with_their_number(tmp_path):
    count = 20_000  # 1 s; a scan of all rows for each takes a minute
    first = sweep(*axes(frequency=[2.0])).rows[0]
    (swept,) = axes(frequency=range(1, count // 2 + 1))
    rows = [
        Row({FREQUENCY: f}, name, 15.0, 15.0, first.metrics)
        for name in ("stick-slip", "viscous")
        for f in swept.values
    ]
    table = replace(sweep(*axes(frequency=[2.0])), axes=(swept,), rows=tuple(rows))
    made = replace(orbits(["stick-slip"]), table=table)
    with no_hang():
        write_transmissibility_csv(table, tmp_path / "transmissibility.csv")
        write_comparison_csv(made, tmp_path / "comparison.csv")
        comparison_fields(made, Provenance("", 0, {}))


# sidecar


def test_sidecar_of_a_sweep_tells_extremes_and_checks_with_where():
    table = small()
    cases = [(row.point, row.metrics) for row in table.own]
    table = replace(
        table,
        warnings=(WarningMessage("slug", "careful"),),
        checks=(judgement(Check.parse("T_a < 1.2"), cases),),
        motion=record(700),
        numerics={"core": "orbit"},
    )
    told = write("out", table, exit_code=1)
    assert told == json.loads(Path("out/drysim.json").read_text())
    numerics, metrics = told["numerics"], told["metrics"]
    assert (numerics["approach"], numerics["reference"]) == ("stick-slip", "viscous")
    assert (numerics["cases"], numerics["statuses"]) == (12, {"ok": 12})
    assert numerics["swept"][0] == {"key": FREQUENCY, "unit": "Hz", "values": 3}
    assert numerics["core"] == "orbit"
    assert 0 < numerics["closure"] < 1e-9
    best = max(table.own, key=lambda row: row.metrics["T_a"])
    assert metrics["T_a"]["greatest"] == {
        "value": best.metrics["T_a"], "where": dict(best.point)
    }  # fmt: skip
    assert set(metrics) <= {metric.name for metric in METRICS}
    (check,) = told["checks"]
    assert (check["passed"], check["where"]) == (False, {FREQUENCY: 1.0, RMS: 1.0})
    assert told["warnings"][0]["sentence"] == "careful"
    assert told["inputs"][0]["file"] == "road.csv"
    assert len(told["excitation"]["sha256"]) == 64
    assert sorted([*told["files"], "drysim.json"]) == names("out")
    assert (told["exit_code"], told["complete"]) == (1, True)


def test_failed_case_marks_the_folder_as_incomplete():
    told = write("out", spoil(small(), FAILED, 2), exit_code=3)
    assert told["complete"] is False
    assert told["numerics"]["statuses"] == {"ok": 11, "failed": 1}
    assert "transmissibility.csv" in names("out")


# the folder that is worked in

CASES = "a finished block"


def keep(claim, words=CASES):
    """Keep a block of finished cases in a locked folder."""
    (claim.partial / "cases").mkdir(exist_ok=True)
    (claim.partial / "cases/000000.npz").write_text(words)


def interrupted(cases=CASES, table=None):
    """Leave a sweep half done, as Ctrl-C does."""
    with output.lock_partial(Path("out")) as claim:
        keep(claim, cases)
        return write(claim, small() if table is None else table, exit_code=130)


def test_claim_is_finished_in_place_of_the_old_folder():
    write("out", small(), plots=True)
    with output.lock_partial(Path("out")) as claim:
        assert claim.partial == Path("out.partial")
        keep(claim)
        write(claim, small(limit=0.015))
    assert names(".") == ["out"]
    assert "stroke_violations.csv" in names("out")
    assert "transmissibility.png" not in names("out")
    assert "cases" not in names("out")
    assert not any(
        name.startswith("cases")
        for name in json.loads(Path("out/drysim.json").read_text())["files"]
    )


def test_interrupted_sweep_keeps_its_cases_and_the_old_folder():
    write("out", small())
    told = interrupted()
    assert names(".") == ["out", "out.partial"]
    assert names("out.partial") == [
        "cases", "drysim.json", "scenario.yaml", "transmissibility.csv"
    ]  # fmt: skip
    assert (told["complete"], told["exit_code"]) == (False, 130)
    assert json.loads(Path("out.partial/drysim.json").read_text()) == told
    assert Path("out.partial/cases/000000.npz").read_text() == CASES
    assert json.loads(Path("out/drysim.json").read_text())["complete"] is True


@pytest.mark.parametrize("resume", [True, False])
def test_resume_keeps_the_finished_cases_and_nothing_else(resume):
    interrupted()
    with output.lock_partial(Path("out"), resume=resume) as claim:
        assert names(claim.partial) == ["cases", "drysim.json"][not resume :]
        if resume:
            assert (claim.partial / "cases/000000.npz").read_text() == CASES
        write(claim, small())
    assert names(".") == ["out"]


def test_nothing_stays_of_a_sweep_without_a_finished_case():
    empty = Table(small().scenario, small().axes, (), complete=False)
    told = interrupted("", empty)
    assert told["metrics"] == {}
    assert names(".") == []


@pytest.mark.parametrize(("cases", "left"), [(CASES, ["out.partial"]), ("", []), (None, [])])
def test_fault_in_a_sweep_keeps_finished_cases_only(cases, left):
    def fail():
        with output.lock_partial(Path("out")) as claim:
            if cases is not None:
                keep(claim, cases)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert names(".") == left


def test_full_disk_at_the_end_keeps_the_finished_cases(monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(output, "write_scenario", full)

    def end():
        with output.lock_partial(Path("out")) as claim:
            keep(claim)
            write(claim, small())

    with pytest.raises(OutputError, match="no space left"):
        end()
    assert names("out.partial") == ["cases", "drysim.json"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_kill_at_any_instant_leaves_what_resumes():
    def act():
        with output.lock_partial(Path("out"), resume=True) as claim:
            keep(claim)
            (claim.partial / "events.csv").write_text("new")
            folder.write_marker(claim.partial, '{"format": 1, "files": {"events.csv": ""}}')
            folder.install_partial(claim)

    at, kept = [], 0
    for passed in kills(act):
        at.append(passed)
        output.check_writable(Path("out"))
        assert set(names(".")) <= {"out", "out.partial"}
        if Path("out.partial/cases/000000.npz").exists():
            kept += 1
            assert not Path("out").exists()
            with output.lock_partial(Path("out"), resume=True) as claim:
                assert (claim.partial / "cases/000000.npz").read_text() in ("", CASES)
        act()
        assert names("out") == ["drysim.json", "events.csv"]
        shutil.rmtree("out")
    assert at[-1] > 100 > kept > 2


def test_result_never_replaces_a_file_that_it_reads(seat, drysim, refused):
    drysim("run", seat, "--out", "first")
    seat.write_text(
        "drysim: 1\nname: second\noscillator: {mass: 75, stiffness: 4500, damping: 300}\n"
        "excitation: {kind: record, file: first/response.csv, time: t, column: x_dd}\n"
    )
    for out in ("first", "first/../first"):
        assert "reads response.csv of first" in refused("run", seat, "--out", out)
    assert drysim("run", seat, "--out", "second").code == 0
