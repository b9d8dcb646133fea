"""Workers of our own, which a Ctrl-C at the terminal reaches, too: they leave when told to."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Let a worker pass over Ctrl-C; Dask calls this in every worker that it starts."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
