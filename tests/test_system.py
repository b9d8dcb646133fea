"""The operating system: limits of containers, private folders."""

from __future__ import annotations

import os
from math import inf
from pathlib import Path

import pytest

from drysim import system
from drysim.parallel import worker_count
from drysim.system import private_folder

# Limits.

GB = 10**9


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """Return a function that makes a machine of files below /proc and /sys."""
    monkeypatch.setattr(system, "ROOT", tmp_path)
    monkeypatch.setattr(system, "_physical_memory", lambda: 64.0 * GB)
    for name in ("process_cpu_count", "sched_getaffinity"):
        monkeypatch.delattr(os, name, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 16)

    def made(groups, files):
        (tmp_path / "proc/self").mkdir(parents=True)
        (tmp_path / "proc/self/cgroup").write_text(groups)
        for name, text in files.items():
            file = tmp_path / "sys/fs/cgroup" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)

    return made


MEMORY = {
    "own group": ("0::/\n", {"memory.max": "2000000000\n"}, 2),
    "group of a job": ("0::/slurm/job1\n", {"slurm/job1/memory.max": "2000000000\n"}, 2),
    "group above": (
        "0::/a/b\n", {"a/memory.max": "3000000000\n", "a/b/memory.max": "max\n"}, 3,
    ),
    "the smaller of two": (
        "0::/a/b\n", {"a/memory.max": "3000000000", "a/b/memory.max": "4000000000"}, 3,
    ),
    "no limit": ("0::/\n", {"memory.max": "max\n"}, 64),
    "more than there is": ("0::/\n", {"memory.max": "900000000000\n"}, 64),
    "version 1": (
        "9:memory:/docker/1\n0::/x\n",
        {"memory/docker/1/memory.limit_in_bytes": "2000000000\n"}, 2,
    ),
    "version 1 whose group is seen as the root": (
        "9:cpuset,memory:/docker/1\n", {"memory/memory.limit_in_bytes": "2000000000\n"}, 2,
    ),
    "version 1 without a limit": (
        "9:memory:/\n", {"memory/memory.limit_in_bytes": "9223372036854771712\n"}, 64,
    ),
    "another controller": ("9:cpu:/\n", {"memory/memory.limit_in_bytes": "1\n"}, 64),
    "no files": ("0::/\n", {}, 64),
    "an empty file": ("0::/\n", {"memory.max": ""}, 64),
    "words": ("0::/\n", {"memory.max": "plenty of it\n"}, 64),
    "groups that nobody knows": ("what:is this?\n", {"memory.max": "1"}, 64),
}  # fmt: skip
"""Groups of the process, files of groups, and the memory that may be used [GB]."""


@pytest.mark.parametrize("name", MEMORY)
def test_memory_is_that_of_the_container(machine, name):
    groups, files, expected = MEMORY[name]
    machine(groups, files)
    assert system.total_memory() == expected * GB


PROCESSORS = {
    "two": ("0::/\n", {"cpu.max": "200000 100000\n"}, 2),
    "part of one": ("0::/\n", {"cpu.max": "50000 100000\n"}, 1),
    "one and a half": ("0::/\n", {"cpu.max": "150000 100000\n"}, 2),
    "group above": ("0::/a/b\n", {"a/cpu.max": "300000 100000", "a/b/cpu.max": "max 1"}, 3),
    "no limit": ("0::/\n", {"cpu.max": "max 100000\n"}, 16),
    "more than there are": ("0::/\n", {"cpu.max": "9900000 100000\n"}, 16),
    "version 1": (
        "4:cpu,cpuacct:/\n",
        {"cpu/cpu.cfs_quota_us": "400000\n", "cpu/cpu.cfs_period_us": "100000\n"}, 4,
    ),
    "version 1 without a limit": (
        "4:cpu,cpuacct:/\n",
        {"cpu/cpu.cfs_quota_us": "-1\n", "cpu/cpu.cfs_period_us": "100000\n"}, 16,
    ),
    "half of version 1": ("4:cpu:/\n", {"cpu/cpu.cfs_quota_us": "400000\n"}, 16),
    "a period of zero": ("0::/\n", {"cpu.max": "1 0\n"}, 16),
    "one word": ("0::/\n", {"cpu.max": "100000\n"}, 16),
    "no files": ("0::/\n", {}, 16),
}  # fmt: skip


@pytest.mark.parametrize("name", PROCESSORS)
def test_processors_are_those_of_the_container(machine, name):
    groups, files, expected = PROCESSORS[name]
    machine(groups, files)
    assert system.processor_count() == expected
    assert worker_count(None) == expected


def test_processors_are_those_that_the_process_may_use(machine, monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 5, 7}, raising=False)
    assert system.processor_count() == 3
    monkeypatch.setattr(os, "process_cpu_count", lambda: 2, raising=False)
    assert system.processor_count() == 2
    monkeypatch.setattr(os, "process_cpu_count", lambda: None, raising=False)
    assert system.processor_count() == 1


def test_system_without_proc_has_no_control_groups(machine):
    assert system.processor_count() == 16
    assert system.total_memory() == 64 * GB


def test_limits_of_the_container_are_read_once(machine, monkeypatch):
    machine("0::/\n", {"memory.max": "2000000000\n"})
    read, original = [], Path.read_text

    def counted(path, *args, **options):
        read.append(path)
        return original(path, *args, **options)

    monkeypatch.setattr(Path, "read_text", counted)
    assert [system.total_memory() for _ in range(3)] == [2 * GB] * 3
    assert len(read) == len(set(read)) == 2


# Private folders.


@pytest.fixture(autouse=True)
def fresh():
    """Forget which private folders were found."""
    private_folder.cache_clear()
    yield
    private_folder.cache_clear()


@pytest.fixture
def nowhere(monkeypatch, tmp_path):
    """Return the temporary folder of a user without a home."""
    (tmp_path / "file").write_text("")
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    return tmp_path / "tmp"


def test_private_folder_lies_in_the_users_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = private_folder("kernels")
    assert folder.path == tmp_path / "cache/drysim/kernels"
    folder.write("one", b"1")
    folder.write("one", b"2")
    assert folder.read("one") == b"2"
    assert [file.name for file in folder.path.iterdir()] == ["one"]


def test_private_folder_lies_below_the_temporary_folder_without_a_home(nowhere):
    folder = private_folder("kernels")
    assert folder.path.is_relative_to(nowhere)
    folder.write("one", b"1")
    assert folder.read("one") == b"1"


def test_there_is_no_private_folder_without_any_writable_folder(nowhere, monkeypatch):
    def nothing():
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setattr("tempfile._get_default_tempdir", nothing)
    assert private_folder("kernels") is None


@pytest.mark.parametrize("home", ["XDG_CACHE_HOME", "HOME"])
def test_relative_cache_folder_is_ignored(monkeypatch, nowhere, tmp_path, home):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv(home, "here")
    folder = private_folder("kernels")
    assert folder.path.is_relative_to(tmp_path / ("home/.cache" if home != "HOME" else "tmp"))
    assert not (tmp_path / "here").exists()


def levels(place):
    """Return the folders down to the private one below a temporary folder."""
    own = place / f"cache-{os.getuid()}"
    return [own, own / "drysim", own / "drysim" / "kernels"]


OWNED = pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders have no owner there")


@OWNED
@pytest.mark.parametrize("mask", [0o000, 0o002, 0o022])
def test_private_folders_are_for_the_user_alone(nowhere, mask):
    before = os.umask(mask)
    try:
        assert private_folder("kernels").path == levels(nowhere)[-1]
    finally:
        os.umask(before)
    assert {folder.stat().st_mode & 0o777 for folder in levels(nowhere)} == {0o700}


@OWNED
@pytest.mark.parametrize("relative", [True, False], ids=["by descriptor", "by path"])
@pytest.mark.parametrize(
    ("where", "level"), [("cache", -2), ("cache", -1), ("tmp", -3), ("tmp", -2), ("tmp", -1)]
)
@pytest.mark.parametrize("trap", ["writable by a group", "writable by all", "link", "owner"])
def test_folder_that_somebody_has_prepared_is_not_used(
    nowhere, monkeypatch, tmp_path, relative, where, level, trap
):
    if not relative:  # as on Windows
        monkeypatch.setattr(os, "supports_dir_fd", set())
    if where == "cache":
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "file"))
        folders = [tmp_path / "cache/drysim", tmp_path / "cache/drysim/kernels"]
    else:
        folders = levels(nowhere)
    folder = folders[level]
    folder.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    if trap == "link":
        (nowhere / "mine").mkdir(mode=0o700)
        folder.symlink_to(nowhere / "mine")
    else:
        folder.mkdir(mode=0o700)
    if trap.startswith("writable"):
        folder.chmod(0o770 if trap.endswith("group") else 0o707)
    if trap == "owner":
        about = folder.lstat()
        theirs = os.stat_result((*about[:4], about.st_uid + 1, *about[5:10]))

        def seen(whole):
            return lambda *words: (
                theirs if (status := whole(*words)).st_ino == about.st_ino else status
            )

        monkeypatch.setattr(os, "fstat", seen(os.fstat))
        monkeypatch.setattr(Path, "lstat", seen(Path.lstat))
    assert private_folder("kernels") is None


@OWNED
@pytest.mark.parametrize("level", [0, 1, 2])
def test_folder_swapped_after_the_check_is_neither_read_nor_written(nowhere, level):
    folder = private_folder("kernels")
    folder.write("kernel", b"mine")
    place = levels(nowhere)[level]
    place.rename(nowhere / "away")
    levels(nowhere)[-1].mkdir(parents=True)
    theirs = levels(nowhere)[-1] / "kernel"
    theirs.write_bytes(b"theirs")
    assert folder.read("kernel") == b"mine"
    folder.write("kernel", b"new")
    assert folder.read("kernel") == b"new"
    assert theirs.read_bytes() == b"theirs"


@OWNED
def test_link_in_a_private_folder_is_not_followed(nowhere, tmp_path):
    folder = private_folder("kernels")
    (tmp_path / "theirs").write_bytes(b"theirs")
    (folder.path / "kernel").symlink_to(tmp_path / "theirs")
    with pytest.raises(OSError, match="symbolic links"):
        folder.read("kernel")


@pytest.mark.parametrize("relative", [True, False], ids=["by descriptor", "by path"])
def test_file_that_cannot_be_completed_leaves_the_old_one(nowhere, monkeypatch, relative):
    if not relative:
        monkeypatch.setattr(os, "supports_dir_fd", set())
    folder = private_folder("kernels")
    folder.write("kernel", b"old")

    def fail(*_, **__):
        raise OSError(28, "no space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="no space"):
        folder.write("kernel", b"new")
    assert folder.read("kernel") == b"old"
    assert [file.name for file in folder.path.iterdir()] == ["kernel"]


def test_memory_is_infinite_where_the_system_does_not_report_it(monkeypatch):
    monkeypatch.delattr(os, "sysconf")
    assert system._physical_memory() == inf
