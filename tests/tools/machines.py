"""A Dask scheduler and its workers as processes of their own, to be killed one by one."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

PATIENCE = 60.0
"""Time that a process may take to appear [s], on a machine that is busy."""


def command(*words: object) -> list[str]:
    """Return the words that start drysim."""
    return [sys.executable, "-m", "drysim", *map(str, words)]


class Machines:
    """A scheduler on loopback and two workers of one thread each, by Dask's own commands."""

    def __init__(self, folder: Path, certificates: Sequence[object] = (), nanny: bool = True):
        self.folder, self.certificates = folder, certificates
        self.workers = () if nanny else ("--no-nanny",)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"{'tls' if certificates else 'tcp'}://127.0.0.1:{self.port}"
        self.running: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> Machines:
        """Start all of them."""
        self.mend()
        return self

    def __exit__(self, *fault: object) -> None:
        """Kill all of them."""
        for name in list(self.running):
            self.kill(name)

    def mend(self) -> None:
        """Start whatever is missing."""
        if not self.alive("scheduler"):
            for name in list(self.running):
                self.kill(name)  # workers leave a scheduler that is gone, in their own time
            words = ("--host", "127.0.0.1", "--port", self.port, "--no-dashboard")
            words = *words, "--protocol", self.address.partition(":")[0]
            self._start("scheduler", "scheduler", *words)
            self._wait()
        for name in ("one", "two"):
            if not self.alive(name):
                words = ("--nthreads", 1, "--no-dashboard", "--death-timeout", 60)
                self._start(name, "worker", self.address, *words, *self.workers)

    def alive(self, name: str) -> bool:
        """Return whether a process runs; of a worker the nanny, who starts it anew."""
        return name in self.running and self.running[name].poll() is None

    def kill(self, name: str) -> None:
        """Kill a process and all that it has started."""
        process = self.running.pop(name)
        with suppress(ProcessLookupError):  # it has ended by itself
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()

    def kill_worker(self, name: str) -> None:
        """Kill a worker, but not the nanny who starts it anew."""
        nanny = self.running[name].pid
        for child in Path(f"/proc/{nanny}/task/{nanny}/children").read_text().split():
            words = Path(f"/proc/{child}/cmdline").read_bytes()
            if b"spawn_main" in words:
                os.kill(int(child), signal.SIGKILL)

    def _start(self, name: str, *words: object) -> None:
        self.running[name] = subprocess.Popen(
            [sys.executable, "-m", "dask", *map(str, (*words, *self.certificates))],
            cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=os.environ | {"DASK_TEMPORARY_DIRECTORY": str(self.folder)},
            start_new_session=True,
        )  # fmt: skip

    def _wait(self) -> None:
        """Wait for the scheduler to listen."""
        late = time.monotonic() + PATIENCE
        while time.monotonic() < late:
            try:
                socket.create_connection(("127.0.0.1", self.port), 1.0).close()
            except OSError:
                time.sleep(0.05)
            else:
                return
        raise TimeoutError("the scheduler does not listen")
