"""Whether a case fits into the memory of this machine; asked before any work."""

from __future__ import annotations

from drysim import machine

BYTES_PER_STEP = 64
"""Memory of one step where a response is held whole, as by fixed steps, or a signal is made:
some 50 were seen, in the transforms of noise."""

BYTES_BY_PARTS = 8
"""Memory of one step where a response is made part by part: its events alone are held, 25 bytes
each, twice that while they are put together; 2 were seen at an event in 24 steps."""

BYTES_WEIGHED = 96
"""Memory of a step on top of it where it is weighted or its spectra are taken; 77 were seen."""

BYTES_PER_SEED = 6_000
"""Memory of the metrics of a seed; 3,500 were seen, with what writes them 5,000."""

GIGA = 1e9


def shortage(steps: int, weighed: bool = False, by_parts: bool = False) -> str:
    """Say what a response of so many steps lacks, or nothing when it fits."""
    wanted = bytes_of(steps, weighed, by_parts)
    return _lacking(f"{steps:.4g} steps", wanted, "take a longer step or a shorter duration")


def bytes_of(steps: int, weighed: bool = False, by_parts: bool = False) -> float:
    """Give the memory that a response of so many steps takes [bytes].

    One that is weighted, or whose spectra are taken, is held whole.
    """
    if by_parts and not weighed:
        return float(steps * BYTES_BY_PARTS)
    return float(steps * (BYTES_PER_STEP + weighed * BYTES_WEIGHED))


def shortage_of_seeds(seeds: int) -> str:
    """Say what the metrics of so many seeds lack, or nothing when they fit."""
    return _lacking(f"{seeds:.4g} seeds", float(seeds) * BYTES_PER_SEED, "take fewer")


def _lacking(what: str, wanted: float, way: str) -> str:
    """Say what memory lacks for something [bytes], and what to do; nothing when it fits."""
    owned = machine.memory()
    if wanted <= owned:
        return ""
    return (
        f"{what} need {wanted / GIGA:.3g} GB of memory, this machine has "
        f"{owned / GIGA:.3g} GB; {way}"
    )
