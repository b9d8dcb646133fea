"""Whether a case fits into the memory of this machine; asked before any work."""

from __future__ import annotations

import os

BYTES_PER_STEP = 64
"""Memory of one step of the output grid: the response itself takes 25; with what measures and
writes it some 30 were seen under sines, twice that is safe for samples, too."""

BYTES_WEIGHED = 96
"""Memory of a step on top of it where it is weighted or its spectra are taken; 77 were seen."""

BYTES_PER_SEED = 6_000
"""Memory of the metrics of a seed; 3,500 were seen, with what writes them 5,000."""

GIGA = 1e9


def shortage(steps: int, weighed: bool = False) -> str:
    """Say what a response of so many steps lacks, or nothing when it fits."""
    wanted, owned = bytes_of(steps, weighed), machine()
    if wanted <= owned:
        return ""
    return (
        f"{steps:.4g} steps need {wanted / GIGA:.3g} GB of memory, this machine has "
        f"{owned / GIGA:.3g} GB; take a longer step or a shorter duration"
    )


def bytes_of(steps: int, weighed: bool = False) -> float:
    """Give the memory that a response of so many steps takes [bytes]."""
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
