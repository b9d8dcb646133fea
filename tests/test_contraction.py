"""Two motions under one base come nearer and nearer: friction and dampers take, and never give.

With a limit that is constant, and the same at rest, the energy of the difference of two motions
never grows, whatever the base does. So there is one periodic orbit, of the period of the base.
"""

from __future__ import annotations

import numpy as np
import pytest
from law_scenes import PAPER, elastic_law, noise, sine, solved

from drysim.core.model import CoulombLaw, Plant, State
from drysim.orbits.search import find_orbit

FAINT = Plant(80.0, 6000.0, 14.0)
BLOCK = Plant(80.0, 0.0, 0.0)
LAWS = {
    "coulomb": CoulombLaw(45.0, 45.0),
    "stiff contact": elastic_law(45.0, 1e7),
    "contact": elastic_law(30.0, 1e5),
    "soft contact": elastic_law(30.0, 1e4),
}
MOTIONS = {"sine": sine(1.0, 1.3), "slow sine": sine(0.8, 0.3), "noise": noise(4000, 1.0)}
ROUNDING = 1e-11
"""Of the energy of the first difference."""


@pytest.mark.parametrize("plant", [PAPER, FAINT, BLOCK], ids=["paper", "faint", "block"])
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_energy_of_the_difference_of_two_motions_never_grows(plant, motion, law):
    one, two = (
        solved(law, motion, start, 9.9, plant) for start in (State(0.0, 0.0), State(0.02, -0.3))
    )
    x, v, F = (getattr(one, name) - getattr(two, name) for name in ("x_r", "v_r", "F_f"))
    energy = 0.5 * (plant.m * v * v + plant.k_x * x * x)
    if law.is_elastic:
        energy += 0.5 * F * F / law.k_t
    assert energy[-1] < 0.9 * energy[0]
    assert np.diff(energy).max() <= ROUNDING * energy[0]


@pytest.mark.parametrize("plant", [PAPER, FAINT], ids=["paper", "faint"])
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_orbit_has_the_period_of_its_base(plant, law):
    orbit = find_orbit(plant, law, sine(0.5, 1.3), State(0.0, 0.0), 1 / 1.3)
    assert orbit.settled
    assert orbit.periods == 1
