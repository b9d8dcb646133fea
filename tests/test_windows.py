"""What Windows and macOS do differently, simulated: locks, renames, missing calls, consoles."""

from __future__ import annotations

import fcntl
import os
import sys
from io import BytesIO, TextIOWrapper
from pathlib import Path
from types import SimpleNamespace

import pytest

from drysim import output, system
from drysim.cli import main
from drysim.errors import OutputError
from drysim.output import folder
from drysim.plots.sweep import file_labels

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="simulates Windows")


class Locks:
    """The module msvcrt of Windows, with the locks of this system."""

    LK_NBLCK = 2

    @staticmethod
    def locking(handle, mode, size):
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(13, "Permission denied") from None


@pytest.fixture
def windows(monkeypatch, place):
    """Work as on Windows: no folder is opened, and none is moved while a file of it is open."""
    whole_open, whole_replace, whole_flush = os.open, os.replace, os.fsync
    opened = set()

    def open_file(path, flags, *words, **options):
        if Path(path).is_dir():
            raise PermissionError(13, "Permission denied", str(path))
        return whole_open(path, flags, *words, **options)

    def replace(source, target):
        if Path(target).is_dir():
            raise FileExistsError(17, "File exists", str(target))
        if any(path.is_relative_to(place / source) for path in opened):
            raise PermissionError(13, "The process cannot access the file", str(source))
        whole_replace(source, target)

    def flush(handle):
        if fcntl.fcntl(handle, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(9, "Bad file descriptor")
        whole_flush(handle)

    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setitem(sys.modules, "msvcrt", Locks)
    monkeypatch.setattr(os, "open", open_file)
    monkeypatch.setattr(os, "replace", replace)
    monkeypatch.setattr(os, "fsync", flush)
    monkeypatch.setattr(os, "supports_dir_fd", set())
    monkeypatch.setattr(system, "MAX_WAIT", 0.2)
    return opened


def names():
    """Return what lies in the working folder."""
    return sorted(path.name for path in Path().iterdir())


def put(word):
    """Write a result of one file."""
    with output.lock_partial(Path("out")) as locked:
        (locked.partial / "events.csv").write_text(word)
        folder.write_marker(locked.partial, '{"format": 1, "files": {"events.csv": ""}}')
        folder.install_partial(locked)


def test_result_replaces_another_where_folders_are_not_opened(windows):
    put("old")
    put("new")
    assert Path("out/events.csv").read_text() == "new"
    assert names() == ["out"]


def test_folder_is_locked_by_a_file_beside_it(windows):
    with output.lock_partial(Path("out")):
        assert "out.partial.drysim-lock" in names()
        with pytest.raises(OutputError, match="another drysim process is writing out"):
            put("other")
    assert names() == ["out.partial"]


def test_disk_without_locks_is_written_all_the_same(windows, monkeypatch):
    def locking(*_):
        raise OSError(22, "Invalid argument")

    monkeypatch.setattr(Locks, "locking", locking)
    put("one")
    assert Path("out/events.csv").read_text() == "one"


def test_result_is_kept_while_a_program_shows_the_old_one(windows, place):
    put("old")
    windows.add(place / "out/events.csv")
    with pytest.raises(OutputError, match="cannot replace out: ") as fault:
        put("new")
    assert "the result is complete in out.partial" in fault.value.hint
    assert Path("out/events.csv").read_text() == "old"
    assert Path("out.partial/events.csv").read_text() == "new"
    windows.clear()
    put("newest")
    assert names() == ["out"]
    assert Path("out/events.csv").read_text() == "newest"


def test_rename_is_tried_again_while_a_scanner_has_a_file_open(windows, place, monkeypatch):
    put("old")
    windows.add(place / "out/events.csv")
    waits = []
    monkeypatch.setattr(system, "time", SimpleNamespace(
        monotonic=lambda: 0.0, sleep=lambda pause: waits.append(pause) or windows.clear()
    ))  # fmt: skip
    put("new")
    assert waits == [system.WAIT]
    assert Path("out/events.csv").read_text() == "new"


def test_rename_is_tried_once_on_other_systems(monkeypatch, place):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    monkeypatch.setattr(
        system, "time", SimpleNamespace(monotonic=lambda: 0.0, sleep=pytest.fail)
    )
    with pytest.raises(PermissionError):
        system.replace(Path("one"), Path("other"))


@pytest.mark.parametrize("left", ["cases/.nfs0000000123", "cases/000000000000.npz"])
def test_finished_cases_that_cannot_be_removed_are_in_nobodys_way(place, left):
    put("old")
    Path("out", left).parent.mkdir()
    Path("out", left).write_text("open elsewhere")
    output.check_writable(Path("out"))
    put("new")
    assert names() == ["out"]
    assert not Path("out/cases").exists()


@pytest.mark.parametrize("name", ["~$events.csv", ".~lock.events.csv#"])
def test_lock_of_an_office_program_is_no_file_of_the_user(place, name):
    put("old")
    Path("out", name).write_text("shown")
    put("new")
    assert names() == ["out"]


def test_file_beside_finished_cases_is_refused_and_stays(place):
    put("old")
    Path("out/cases").mkdir()
    Path("out/cases/notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"out holds cases/notes\.txt"):
        put("new")
    Path("out/cases/notes.txt").unlink()
    Path("out/mine").mkdir()
    with pytest.raises(OutputError, match="out holds mine"):
        put("new")


LONG = "C:\\" + "x" * 300


@pytest.mark.parametrize(
    ("code", "path", "long"),
    [(206, "x", True), (3, LONG, True), (3, "x", False), (5, LONG, False)],
)
def test_path_that_is_too_long_is_named(code, path, long):
    fault = OSError(2, "The system cannot find the path specified", path)
    fault.winerror = code
    with pytest.raises(OutputError) as error, folder.translate_os_errors(Path("out")):
        raise fault
    assert ("shorter name" in error.value.hint) == long


def test_memory_is_asked_of_the_kernel_of_windows(monkeypatch):
    import ctypes

    def answer(pointer):
        fields = pointer._obj
        assert fields[0] == 64  # the size of MEMORYSTATUSEX
        fields[1] = 8 * 10**9
        return 1

    kernel = SimpleNamespace(GlobalMemoryStatusEx=answer)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ctypes, "windll", SimpleNamespace(kernel32=kernel), raising=False)
    assert system._physical_memory() == 8e9
    kernel.GlobalMemoryStatusEx = lambda _: 0
    assert system._physical_memory() == float("inf")


def test_record_named_as_on_windows_is_found(drysim, seat):
    Path("data").mkdir()
    rows = "\n".join(f"{0.01 * i:.2f},{i % 7}" for i in range(300))
    Path("data/floor.csv").write_text(f"time [s],u_dd [m/s^2]\n{rows}\n")
    record = "excitation={kind: record, file: 'data\\floor.csv', column: u_dd, time: time}"
    words = ["--set", record, "--set", "measure=null", "--set", "solver={approach: stick-slip}"]
    done = drysim("validate", seat, *words)
    assert done.code == 0, done.out
    Path("data\\floor.csv").write_text("a file of this name")
    assert drysim("validate", seat, *words).code == 2


def test_pattern_of_records_as_on_windows_is_found(drysim, seat):
    Path("data/runs").mkdir(parents=True)
    rows = "\n".join(f"{0.01 * i:.2f},{i % 7}" for i in range(300))
    for name in "ab":
        Path(f"data/runs/{name}.csv").write_text(f"time [s],u_dd [m/s^2]\n{rows}\n")
    record = "{kind: record, file: data/runs/a.csv, column: u_dd, time: time}"
    words = ["--set", f"excitation={record}", "--set", "measure=null"]
    words += ["--set", "solver={approach: stick-slip}", "--no-plots"]
    pattern = "sweep={excitation.file: 'data\\runs\\*.csv'}"
    done = drysim("sweep", seat, *words, "--set", pattern)
    assert done.code == 0, done.out
    (table,) = Path("out").glob("*/transmissibility.csv")
    assert [row.split(",")[1] for row in table.read_text().splitlines()[-2:]] == [
        "data/runs/a.csv", "data/runs/b.csv"
    ]  # fmt: skip


def test_file_on_another_drive_is_named_by_its_whole_path(monkeypatch):
    assert system.relative_path("/data/runs/a.csv", "/data/seats") == "../runs/a.csv"

    def relpath(path, folder):
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    monkeypatch.setattr(os.path, "relpath", relpath)
    assert system.relative_path("/data/runs/a.csv", "/data/seats") == "/data/runs/a.csv"


def test_files_on_several_drives_are_labelled_by_their_paths():
    # A relative and an absolute path have no common folder either.
    assert file_labels(["runs/a.csv", "/data/b.csv"]) == ["runs/a", "/data/b"]


CODE_PAGES = ["ascii", "cp437", "cp850", "cp1252", "cp932"]

COMMANDS = [
    ("--help",), ("run", "--help"), ("explain", "T_a"), ("manual",), ("schema",),
    ("run", "seat.yaml", "--no-plots"), ("run", "µ–Ω\udcff.yaml"), ("manual", "–µ"), ("–µ",),
    ("run", "seat.yaml", "--µ–"), ("validate", "µ–Ω.yaml", "--format", "json"),
]  # fmt: skip


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_console_of_any_code_page_shows_every_text(seat, place, monkeypatch, words):
    for page in CODE_PAGES:
        streams = [TextIOWrapper(BytesIO(), encoding=page) for _ in range(2)]
        monkeypatch.setattr(sys, "stdout", streams[0])
        monkeypatch.setattr(sys, "stderr", streams[1])
        code = main([*words])
        for stream in streams:
            stream.flush()
        out, err = (stream.buffer.getvalue().decode(page) for stream in streams)
        assert code in (0, 2)
        assert "Traceback" not in err
        assert out or err
