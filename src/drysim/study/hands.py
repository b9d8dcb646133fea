"""How many threads work on many cases or seeds."""

from __future__ import annotations

from numbers import Integral

from drysim import machine
from drysim.errors import UsageError
from drysim.quantity import short


def hands(workers: int | None) -> int:
    """Give the number of threads: as many as asked for, else one for each processor.

    Raises
    ------
    UsageError
        When it is no number of threads.
    """
    if workers is None:
        return machine.processors()
    if isinstance(workers, bool) or not isinstance(workers, Integral) or workers < 1:
        given = short(repr(workers))
        raise UsageError(f"workers must be a whole number of at least 1, not {given}")
    return int(workers)
