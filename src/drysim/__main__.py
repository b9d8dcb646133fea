"""The command `drysim`, also as `python -m drysim`: ends quietly while it loads, if asked."""

import signal

if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # nothing is written yet

from drysim.cli import command

if __name__ == "__main__":
    command()
