"""Passages and excursions counted from turn to turn, where the answer can be seen."""

from __future__ import annotations

import numpy as np
import pytest

TURNS = [0.0, 3.0, -4.0, 1.0, -1.0, 5.0]
"""Displacements at the turns of a motion that goes on to 2 [m]."""


def test_passages_count_each_return_to_the_limit_on_either_side(kernel):
    t, turns = np.arange(6.0), np.array(TURNS)
    count, limits = kernel.stroke.extremes_and_crossings, kernel.model.StrokeLimits
    scene = (t, turns, 0.0, 2.0, 6.0)
    assert tuple(count(*scene, limits(2.5, 2.5))) == (-4.0, 5.0, 2, 3)
    assert tuple(count(*scene, limits(4.5, 4.5))) == (-4.0, 5.0, 2, 1)
    assert tuple(count(*scene, limits(2.5, 4.5))) == (-4.0, 5.0, 2, 2)
    back_and_forth = np.array([3.0, -3.0, 3.0])
    found = count(np.arange(3.0), back_and_forth, 3.0, 2.9, 3.0, limits(2.5, 2.5))
    assert tuple(found) == (-3.0, 3.0, 1, 2)


@pytest.mark.parametrize("repeats", [False, True])
def test_mass_that_never_comes_back_has_one_excursion_as_long_as_all(kernel, repeats):
    find, limits = kernel.stroke.limit_crossings, kernel.model.StrokeLimits
    for one, known in ((limits(0.2, 0.4), (1, 0, 0.0, 7.0)), (limits(0.4, 0.2), (0, 0, -1, 0))):
        crossings = kernel.stroke.Crossings(*np.empty((5, 2)))
        assert find(np.zeros(1), np.full(1, 0.3), 0.3, 7.0, one, crossings) == 0
        side = kernel.stroke.stroke_side(0.3, one)
        scene = crossings, np.empty(0), (side, side), 7.0, repeats
        assert tuple(kernel.stroke.sum_excursions(*scene)) == known


@pytest.mark.parametrize(("repeats", "counted"), [(False, (2, 1)), (True, (1, 1))])
def test_excursion_across_the_end_of_an_orbit_counts_once(kernel, repeats, counted):
    t, turns = np.arange(2.0), np.array([3.0, -3.0])
    crossings, limits = kernel.stroke.Crossings(*np.empty((5, 4))), kernel.model.StrokeLimits
    count = kernel.stroke.limit_crossings(t, turns, 3.0, 2.0, limits(2.0, 2.0), crossings)
    assert count == 4
    assert crossings.enters.tolist() == [0.0, 1.0, 0.0, 1.0]
    times = np.array([0.25, 0.75, 1.25, 1.75])
    scene = crossings, times, (1, 1), 2.0, repeats
    assert tuple(kernel.stroke.sum_excursions(*scene)) == (*counted, 0.0, 1.0)
