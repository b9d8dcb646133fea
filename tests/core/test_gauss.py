"""Gauss and Legendre's rules are those of numpy, moved to a panel of length 1."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.core import trajectory


@pytest.mark.parametrize(("name", "points"), [("FOUR", 4), ("SIX", 6), ("TWELVE", 12)])
def test_rule_is_that_of_numpy(name, points):
    nodes, weights = np.polynomial.legendre.leggauss(points)
    np.testing.assert_allclose(
        getattr(trajectory, f"{name}_NODES"), 0.5 + 0.5 * nodes, rtol=1e-14
    )
    np.testing.assert_allclose(
        getattr(trajectory, f"{name}_WEIGHTS"), 0.5 * weights, rtol=1e-13
    )
