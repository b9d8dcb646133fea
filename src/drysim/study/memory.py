"""Whether a case fits into the memory of this machine; asked before any work."""

from __future__ import annotations

import os

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
    wanted, owned = bytes_of(steps, weighed, by_parts), machine()
    if wanted <= owned:
        return ""
    return (
        f"{steps:.4g} steps need {wanted / GIGA:.3g} GB of memory, this machine has "
        f"{owned / GIGA:.3g} GB; take a longer step or a shorter duration"
    )


def bytes_of(steps: int, weighed: bool = False, by_parts: bool = False) -> float:
    """Give the memory that a response of so many steps takes [bytes].

    One that is weighted, or whose spectra are taken, is held whole.
    """
    if by_parts and not weighed:
        return float(steps * BYTES_BY_PARTS)
    return float(steps * (BYTES_PER_STEP + weighed * BYTES_WEIGHED))


def shortage_of_seeds(seeds: int) -> str:
    """Say what the metrics of so many seeds lack, or nothing when they fit."""
    wanted, owned = float(seeds) * BYTES_PER_SEED, machine()
    if wanted <= owned:
        return ""
    return (
        f"{seeds:.4g} seeds need {wanted / GIGA:.3g} GB of memory, this machine has "
        f"{owned / GIGA:.3g} GB; take fewer"
    )


def machine() -> float:
    """Give the memory of this machine [bytes]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")
