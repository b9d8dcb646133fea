"""What this machine has: memory and processors. Knows nothing that needs them."""

from __future__ import annotations

import os


def memory() -> float:
    """Give the memory of this machine [bytes]; infinity where the system does not tell."""
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")


def processors() -> int:
    """Give the number of processors; 1 where the system does not tell."""
    return os.cpu_count() or 1
