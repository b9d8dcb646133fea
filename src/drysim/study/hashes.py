"""Hashes of base motions, by which two results are seen to stand on the same one."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np

from drysim.core.signal import Signal, blocks


def sha256_of(signal: Signal) -> str:
    """Give the SHA-256 (hex) of a signal as little-endian doubles."""
    digest = hashlib.sha256()
    for part in blocks(signal):
        digest.update(np.ascontiguousarray(part, dtype="<f8").data)
    return digest.hexdigest()


def sha256_together(hashes: Iterable[str]) -> str:
    """Give the SHA-256 (hex) of hashes, one a line, in order."""
    return hashlib.sha256("\n".join(hashes).encode()).hexdigest()
