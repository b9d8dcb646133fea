"""A bound on what a test may take that guards against work without an end."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

LIMIT = 20.0
"""Processor time [s]: ten times what any of these tests needs on a slow and busy machine. What
they guard against takes minutes or never ends."""


@contextmanager
def no_hang() -> Iterator[None]:
    """Fail where the block takes more than `LIMIT`."""
    began = time.process_time()
    yield
    assert time.process_time() - began < LIMIT
