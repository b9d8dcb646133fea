"""Numbers had by parts: the same whatever the parts are."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.core.model import blocks, largest


@pytest.mark.parametrize("length", [1, 7, 8, 9, 24])
def test_blocks_of_a_signal_make_the_whole(length: int) -> None:
    signal = np.arange(length) - 3.0
    parts = list(blocks(signal, 8))
    assert max(map(len, parts)) <= 8
    assert np.concatenate(parts).tolist() == signal.tolist()
    assert largest(signal) == max(3.0, length - 4.0)


def test_nothing_has_no_magnitude() -> None:
    assert largest(np.zeros(0)) == 0.0
