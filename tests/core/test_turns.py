"""Passages and excursions counted from turn to turn, where the answer can be seen."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scenes import waves_of

TURNS = [0.0, 3.0, -4.0, 1.0, -1.0, 5.0]
"""Displacements at the turns of a motion that goes on to 2 [m]."""


def test_passages_count_each_return_to_the_limit_on_either_side(
    kernel: SimpleNamespace,
) -> None:
    t, turns = np.arange(6.0), np.array(TURNS)
    assert tuple(kernel.trajectory.passages(t, turns, 0.0, 2.0, 6.0, 2.5)) == (5.0, 2, 3)
    assert tuple(kernel.trajectory.passages(t, turns, 0.0, 2.0, 6.0, 4.5)) == (5.0, 2, 1)
    back_and_forth = np.array([3.0, -3.0, 3.0])
    found = kernel.trajectory.passages(np.arange(3.0), back_and_forth, 3.0, 2.9, 3.0, 2.5)
    assert tuple(found) == (3.0, 1, 2)


@pytest.mark.parametrize("repeats", [False, True])
def test_mass_that_never_comes_back_has_one_excursion_as_long_as_all(
    kernel: SimpleNamespace, repeats: bool
) -> None:
    law, plant = kernel.model.Law(1.0, 1.0), kernel.model.Plant(1.0, 0.0, 0.0)
    waves = waves_of(kernel, [(1.0, 1.0, 0.0)], law)
    still = (np.zeros(1), np.zeros(1, dtype=np.int64), np.full(1, 0.3), 0.0)
    scene = (plant, law, waves, *still, 0.3, 7.0)
    assert tuple(kernel.trajectory.excursions(*scene, 0.2, repeats)) == (1, 0.0, 7.0)
    assert tuple(kernel.trajectory.excursions(*scene, 0.4, repeats)) == (0, -1.0, 0.0)
