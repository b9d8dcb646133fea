"""Whether a case fits into the memory of this machine; asked before any work."""

from __future__ import annotations

import os

from drysim.errors import UsageError

BYTES_PER_STEP = 64
"""Memory of one step of the output grid: the response itself takes 25; with what measures and
writes it some 30 were seen under sines, twice that is safe for samples, too."""

GIGA = 1e9


def require(steps: int) -> None:
    """Make sure that a response of so many steps fits.

    Raises
    ------
    UsageError
        When it needs more memory than the machine has; says how much.
    """
    wanted, owned = steps * BYTES_PER_STEP, machine()
    if wanted > owned:
        raise UsageError(
            f"{steps:.4g} steps need {wanted / GIGA:.3g} GB of memory, "
            f"this machine has {owned / GIGA:.3g} GB",
            hint="take a longer solver.step or a shorter measure.duration",
        )


def machine() -> float:
    """Give the memory of this machine [bytes]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")
