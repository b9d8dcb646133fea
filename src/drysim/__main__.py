"""Entry point of `drysim` and of `python -m drysim`."""

from __future__ import annotations

import signal

from drysim.cli import command

if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing to tidy up yet


if __name__ == "__main__":
    command()
