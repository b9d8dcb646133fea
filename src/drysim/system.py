"""The operating system: memory, processors, files and private folders.

Only regular files are read. Opening a device can have side effects, and reading a pipe can
block forever. What Linux, macOS and Windows do differently is decided here and nowhere else.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from io import BufferedReader
from math import ceil, inf
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from drysim.errors import OutputError

# Limits: of the machine, and of the container or job that the process runs in.

ROOT = Path("/")
"""Where `proc` and `sys` are found."""


def total_memory() -> float:
    """Return the memory that the process may use [bytes]; infinity where that is not known.

    It is the smallest of the physical memory and the limits of the control groups.
    """
    limits = _cgroup_limits(ROOT, "memory", ("memory.max",), ("memory.limit_in_bytes",))
    return min([_physical_memory(), *(float(size) for (size,) in limits)])


def processor_count() -> int:
    """Return the number of processors that the process may use, at least 1.

    A quota of a control group counts in whole processors, rounded up. `taskset`, a job of a
    cluster and PYTHON_CPU_COUNT (from Python 3.13) limit the processors themselves.
    """
    if hasattr(os, "process_cpu_count"):  # Python 3.13
        allowed = os.process_cpu_count()
    elif hasattr(os, "sched_getaffinity"):
        allowed = len(os.sched_getaffinity(0))
    else:
        allowed = os.cpu_count()
    legacy = "cpu.cfs_quota_us", "cpu.cfs_period_us"
    quotas = _cgroup_limits(ROOT, "cpu", ("cpu.max",), legacy)
    shares = [ceil(quota / period) for quota, period in quotas if period]
    return max(1, min([allowed or 1, *shares]))


def _physical_memory() -> float:
    """Return the physical memory [bytes]; infinity where the system does not report it."""
    if sys.platform == "win32":
        import ctypes

        status = (ctypes.c_uint64 * 8)()  # MEMORYSTATUSEX: its size, ..., the memory, ...
        status[0] = ctypes.sizeof(status)
        done = ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))
        return float(status[1]) if done else inf
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return inf


@cache
def _cgroup_limits(
    root: Path, controller: str, unified: tuple[str, ...], legacy: tuple[str, ...]
) -> tuple[list[int], ...]:
    """Return the limits in the control group of the process and in all above it.

    They are read once: each case of a study asks for the memory.

    Parameters
    ----------
    root : Path
        Folder with `proc` and `sys`.
    controller : str
        `memory` or `cpu`.
    unified, legacy : tuple of str
        Names of the files in version 2 and in version 1 of the groups; together they hold as
        many numbers as there are names in `legacy`, or a word where there is no limit.

    Notes
    -----
    A container may see its own group as the root, so folders that do not exist are passed over.
    """
    try:
        groups = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:  # not Linux
        return ()
    values = []
    for group in groups:
        _, _, rest = group.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers and controller not in controllers.split(","):
            continue
        mount = root / "sys/fs/cgroup" / (controller if controllers else "")
        group_folder = PurePosixPath(path.lstrip("/"))
        for folder in (group_folder, *group_folder.parents):
            files = [mount / folder / name for name in (legacy if controllers else unified)]
            with suppress(OSError):
                numbers = " ".join(file.read_text(encoding="utf-8") for file in files).split()
                if len(numbers) == len(legacy) and all(map(str.isdecimal, numbers)):
                    values.append([int(word) for word in numbers])
    return tuple(values)


# Files.


FileSignature = tuple[int, int, int]
"""Inode, size [bytes] and time of the last change [ns] of a file."""

FILE_TYPES = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


class NotARegularFile(Exception):
    """A path that is no regular file; the message names its type."""


def relative_path(path: str | Path, folder: str | Path) -> str:
    """Return the path of a file from a folder, with `/` between folders.

    It is the whole path where none leads there: from one drive of Windows to another.
    """
    with suppress(ValueError):
        path = os.path.relpath(path, folder)
    return Path(path).as_posix()


def file_size(path: Path) -> int:
    """Return the size [bytes] of a regular file without opening it; links are followed.

    Parameters
    ----------
    path : Path

    Raises
    ------
    NotARegularFile
        If the path is a folder, pipe, socket or device. Opening a device can have side effects.
    OSError, ValueError
        If the path does not exist or is not accessible.
    """
    status = path.stat()
    _require_regular_file(status)
    return status.st_size


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """Return at most `max_bytes` bytes of a regular file; raises like `file_size`."""
    with open_regular_file(path) as stream:
        return stream.read(max_bytes)


@contextmanager
def open_regular_file(path: Path) -> Iterator[BufferedReader]:
    """Open a regular file for reading bytes; raises like `file_size`."""
    with open(path, "rb", opener=_open_nonblocking) as stream:
        _require_regular_file(os.fstat(stream.fileno()))  # it may have been replaced since
        yield stream


def file_sha256(path: Path) -> str:
    """Return the SHA-256 (hex) of a regular file; raises like `file_size`."""
    with open_regular_file(path) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def file_signature(file: Path | int) -> FileSignature:
    """Return a signature that differs between two files and changes when a file is modified.

    Parameters
    ----------
    file : Path or int
        A path, or the descriptor of an open file.
    """
    status = os.stat(file)
    return status.st_ino, status.st_size, status.st_mtime_ns


def _require_regular_file(status: os.stat_result) -> None:
    """Raise `NotARegularFile` unless the file is regular."""
    if not stat.S_ISREG(status.st_mode):
        kinds = (name for test, name in FILE_TYPES if test(status.st_mode))
        raise NotARegularFile(next(kinds, "a special file"))


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file without blocking on a pipe that has no writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


# Private folders, for what is kept between runs.


NO_LINK = getattr(os, "O_NOFOLLOW", 0)
FOLDER_FLAGS = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) | NO_LINK
"""Flags of `os.open`: fail at a link; open a folder, not a link. Windows has neither."""


class PrivateFolder(NamedTuple):
    """A folder that only the user may write.

    It is held open: whoever may rename a folder above it may put another in its place, but not
    change what the descriptor refers to.
    """

    path: Path
    descriptor: int | None
    """None where a file cannot be opened relative to a folder, as on Windows."""

    def read(self, name: str) -> bytes:
        """Return the contents of a file."""
        with open(name, "rb", opener=self._open) as stream:
            return stream.read()

    def write(self, name: str, contents: bytes) -> None:
        """Write a file completely or not at all."""
        draft = f"{name}.{os.urandom(8).hex()}.new"
        try:
            with open(draft, "xb", opener=self._open) as stream:
                stream.write(contents)
            if self.descriptor is None:
                os.replace(self.path / draft, self.path / name)
            else:
                os.replace(draft, name, src_dir_fd=self.descriptor, dst_dir_fd=self.descriptor)
        except BaseException:
            with suppress(OSError):
                if self.descriptor is None:
                    os.unlink(self.path / draft)
                else:
                    os.unlink(draft, dir_fd=self.descriptor)
            raise

    def _open(self, name: str, flags: int) -> int:
        """Open a file of the folder; links are not followed."""
        if self.descriptor is None:
            return os.open(self.path / name, flags, 0o600)
        return os.open(name, flags | NO_LINK, 0o600, dir_fd=self.descriptor)


@cache
def private_folder(name: str) -> PrivateFolder | None:
    """Return a folder that is kept between runs and that only the user may write, or None.

    It is `drysim/<name>` in the user's cache folder, else below the temporary folder. Each
    level below these two must be a folder, not a link, that is owned by the user and that
    nobody else may write. The levels are opened one within the other: the folder that was
    checked is the one that is used.
    """
    home = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(home):  # relative: to be ignored by the XDG specification
        home = os.path.join(os.path.expanduser("~"), ".cache")
    if os.path.isabs(home):
        with suppress(OSError):
            os.makedirs(home, 0o700, exist_ok=True)
            return _open_private(Path(home), ("drysim", name))
    with suppress(OSError):  # there may be no temporary folder
        import tempfile

        folder_name = f"cache-{_user_id()}"
        return _open_private(Path(tempfile.gettempdir()), (folder_name, "drysim", name))
    return None


def _open_private(parent: Path, names: Sequence[str]) -> PrivateFolder:
    """Create and open folders one within the other; PermissionError if one is not private."""
    path, descriptor = parent, None
    if os.open in os.supports_dir_fd:
        descriptor = os.open(parent.resolve(), FOLDER_FLAGS)
    try:
        for name in names:
            path /= name
            if descriptor is None:
                path.mkdir(exist_ok=True, mode=0o700)
                status = path.lstat()
            else:
                with suppress(FileExistsError):
                    os.mkdir(name, 0o700, dir_fd=descriptor)
                inner = os.open(name, FOLDER_FLAGS, dir_fd=descriptor)
                os.close(descriptor)
                descriptor = inner
                status = os.fstat(descriptor)
            if not _is_private(status):
                raise PermissionError(f"{path} is not a folder of the user alone")
        if not os.access(path, os.W_OK):  # a file system that can only be read
            raise PermissionError(f"{path} cannot be written")
    except BaseException:
        if descriptor is not None:
            os.close(descriptor)
        raise
    return PrivateFolder(path, descriptor)


def _is_private(status: os.stat_result) -> bool:
    """Return whether a path is a folder, not a link, that only the user owns and may write."""
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != _user_id():
        return False
    return not hasattr(os, "getuid") or not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _user_id() -> int:
    """Return the user ID; 0 where the system has none."""
    return os.getuid() if hasattr(os, "getuid") else 0


# Folders that are replaced while others may read them.


MAX_WAIT, WAIT = 2.0, 0.05
"""How long, and how often, a rename is tried on Windows [s]."""

MAX_PATH = 260
"""Length of a path from which Windows may fail without naming the reason [characters]."""

ERROR_PATH_NOT_FOUND, ERROR_FILENAME_EXCED_RANGE = 3, 206
"""What Windows reports where a path is too long; it gives the first for other reasons, too."""


def replace(source: Path, target: Path) -> None:
    """Rename a file or a folder; a file that exists is replaced.

    On Windows, a file can be neither replaced nor moved while a program has it open. A virus
    scanner or an index of files has it open for a moment only, so the rename is tried again.
    """
    begin = time.monotonic()
    while True:
        try:
            os.replace(source, target)
            return
        except PermissionError:
            if sys.platform != "win32" or time.monotonic() - begin > MAX_WAIT:
                raise
        time.sleep(WAIT)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Lock a folder against other processes; the lock ends with the process, even if killed.

    Where the file system has no locks, as on some network disks, there is none.

    Raises
    ------
    BlockingIOError
        When another process holds the lock, or has replaced the folder.
    """
    if sys.platform == "win32":
        import msvcrt

        # A file within the folder would keep it from being renamed. Windows does not remove a
        # file that another process has open, so all processes lock the same file.
        file = folder.with_name(f"{folder.name}.drysim-lock")
        handle = os.open(file, os.O_RDWR | os.O_CREAT)
        try:
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
        except PermissionError:
            os.close(handle)
            raise BlockingIOError(f"{file} is locked") from None
        except OSError:
            pass
        try:
            yield
        finally:
            os.close(handle)
            with suppress(OSError):
                file.unlink()
    else:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise
            except OSError:
                pass
            if not os.path.samestat(os.fstat(handle), os.stat(folder)):
                raise BlockingIOError(f"{folder} was replaced")
            yield
        finally:
            os.close(handle)


def flush_to_disk(path: Path) -> None:
    """Flush a file or folder to the disk.

    On Windows a folder cannot be opened, and a file must be open for writing.
    """
    on_windows = sys.platform == "win32"
    if on_windows and path.is_dir():
        return
    handle = os.open(path, os.O_RDWR if on_windows else os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def is_path_too_long(fault: OSError) -> bool:
    """Return whether a file could not be opened because its path is too long."""
    code = getattr(fault, "winerror", None)  # only on Windows
    return (
        fault.errno == errno.ENAMETOOLONG
        or code == ERROR_FILENAME_EXCED_RANGE
        or (code == ERROR_PATH_NOT_FOUND and len(str(fault.filename)) >= MAX_PATH)
    )


def removed_error(folder: Path) -> OutputError:
    """Return the error for a `<name>.partial` folder that lost files while in use."""
    return OutputError(
        f"{folder} was removed, in whole or in part, while drysim was writing it",
        "make sure that no other process writes there, and run the command again",
    )
