"""Entry point of `drysim` and of `python -m drysim`."""

from __future__ import annotations

import gc
import signal

GC_THRESHOLD = 1_000_000
"""Allocations between two garbage collections, at most about 100 MB of garbage: a process of
one command has little of it while it loads packages and the compiler."""

gc.set_threshold(GC_THRESHOLD, 20, 20)

from drysim.cli import command  # noqa: E402 - collected rarely, too

if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing to tidy up yet


if __name__ == "__main__":
    command()
