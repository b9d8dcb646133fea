"""What must not happen while input is read: files written, programs run, memory lost."""

from __future__ import annotations

import os
import re
import resource
import sys
import sysconfig
import tempfile
from pathlib import Path

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = (
    "os.mkdir", "os.remove", "os.rename", "os.rmdir", "os.link", "os.symlink", "os.truncate",
    "os.chmod", "os.chown", "shutil.rmtree",
)  # fmt: skip
PROGRAMS = (
    "os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn", "os.system", "pty.spawn",
    "socket.connect", "socket.bind", "subprocess.Popen", "ctypes.dlopen",
)  # fmt: skip
OURS = tuple(
    os.path.realpath(path)
    for path in (*sysconfig.get_paths().values(), Path(__file__).parents[2])
)
"""Where modules are; their caches may be written when they are first imported."""


class Watch:
    """Notes what the interpreter does from now on that is none of a reader's business."""

    def __init__(self) -> None:
        self.noted: list[str] = []
        self.paused = False
        sys.addaudithook(self._hook)

    def _hook(self, event: str, words: tuple[object, ...]) -> None:
        if self.paused:
            return
        if event == "open":
            path, _, flags = words
            if isinstance(flags, int) and flags & WRITES and not _is_ours(path):
                self.noted.append(f"{path} was opened for writing")
        elif event in CHANGES and not _is_ours(words[0]):
            self.noted.append(f"{event} of {words[0]}")
        elif event in PROGRAMS and not _is_ours(words[0]):
            self.noted.append(f"{event} of {words[0]!r}")


TEMPORARY = os.path.realpath(tempfile.gettempdir())
SCRATCH = re.compile(re.escape(TEMPORARY) + r"(/tmp[a-z0-9_]{8})?")
"""A file without a name of its own, which asammdf opens for every MDF and removes again."""


def _is_ours(path: object) -> bool:
    """Whether a path belongs to the installation, or is that of a temporary file."""
    if not isinstance(path, str | bytes | os.PathLike):
        return path is None
    real = os.path.realpath(os.fsdecode(path))
    return real.startswith(OURS) or SCRATCH.fullmatch(real) is not None


def megabytes() -> float:
    """Return the greatest memory that this program ever had.

    What the system counts for a process goes on from the one that started it; the high-water
    mark of its own memory does not.
    """
    status = Path("/proc/self/status")
    if status.exists():
        marks = re.findall(r"^VmHWM:\s*(\d+) kB", status.read_text(), re.MULTILINE)
        if marks:
            return float(marks[0]) * 1.024e-3
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most / (1e6 if sys.platform == "darwin" else 1e3)
