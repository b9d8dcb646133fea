"""Where a guess of a root may be: between its bounds."""

from __future__ import annotations

import math

import pytest

from drysim.core.roots import kept_between


@pytest.mark.parametrize("guess", [1.0, 3.0, -7.0, math.inf, math.nan])
def test_guess_that_is_not_between_the_bounds_gives_way_to_their_middle(guess: float) -> None:
    assert kept_between(1.0, 3.0, guess) == 2.0
    assert kept_between(1.0, 3.0, 2.5) == 2.5
