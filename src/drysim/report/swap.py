"""One folder in the place of another at one instant, locks, and what a kill leaves behind."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Collection, Iterator
from pathlib import Path

from drysim.errors import OutputError
from drysim.report.claim import ELSEWHERE, MARKER


def swap(partial: Path, place: Path, aside: Path) -> None:
    """Put the new folder in place of the old one, and remove that."""
    if place.exists() and not any(place.iterdir()):
        place.rmdir()
    if not place.exists():
        partial.rename(place)
        sync(place.parent)
        return
    with alone(place, place):
        if _exchange(partial, place):
            aside = partial
        else:
            # A kill between these two leaves the old folder aside: see recover().
            place.rename(aside)
            try:
                partial.rename(place)
            except OSError:
                aside.rename(place)
                raise
        sync(place.parent)
        remove(aside)


def _exchange(one: Path, other: Path) -> bool:
    """Swap two folders at one instant; False where the system cannot (all but Linux)."""
    import ctypes

    try:
        rename = ctypes.CDLL(None).renameat2
    except (AttributeError, OSError, TypeError):
        return False
    here, swap = -100, 2  # AT_FDCWD and RENAME_EXCHANGE of <linux/fs.h>
    return bool(rename(here, os.fsencode(one), here, os.fsencode(other), swap) == 0)


def recover(place: Path, aside: Path) -> None:
    """Finish what a kill between two renames left behind."""
    if aside.exists() and place.exists():
        remove(aside)
    elif aside.exists():
        aside.rename(place)


@contextlib.contextmanager
def alone(place: Path, folder: Path) -> Iterator[None]:
    """Hold a folder against other drysims; the lock dies with the process, even by kill -9.

    Raises
    ------
    OutputError
        When another one holds it, or has put another folder in its place.
    """
    if os.name == "nt":  # Folders cannot be locked there.
        yield
        return
    import fcntl

    taken = OutputError(
        f"another drysim is writing {folder} right now", f"wait for it, or {ELSEWHERE}"
    )
    handle = os.open(place, os.O_RDONLY)
    try:
        # Some network disks know no locks: any other OSError means to go on without.
        with contextlib.suppress(OSError):
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise taken from None
        if not os.path.samestat(os.fstat(handle), os.stat(place)):
            raise taken
        yield
    finally:
        os.close(handle)


def empty(folder: Path, keep: Collection[str] = ()) -> None:
    """Remove what a folder holds, the marker last, so that the rest stays known as ours."""
    for path in (folder, *folder.rglob("*")):
        if path.is_dir() and not path.is_symlink():
            path.chmod(path.stat().st_mode | stat.S_IRWXU)  # nothing leaves a read-only folder
    for path in sorted(folder.iterdir(), key=lambda path: path.name == MARKER):
        if path.name in keep:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def remove(folder: Path) -> None:
    """Remove a folder of ours; what cannot be removed now goes with the next run."""
    with contextlib.suppress(OSError):
        empty(folder)
    with contextlib.suppress(OSError):
        folder.rmdir()  # an empty one even where no more files can be opened to see it


def sync(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    if os.name == "nt" and path.is_dir():  # Folders cannot be opened there.
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
