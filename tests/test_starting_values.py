"""Starting values of a fit in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import drysim
from drysim.study.starting_values import Kinematics, decay_start

SCENE = {"m": 4.0, "k_x": 900.0, "b": 1.5, "F_fk": 1.2}


def decay(noise=0.0, **scene):
    """Return the motion of a mass released at 30 mm."""
    motion = drysim.simulate(**scene, u_dd=np.zeros(1_000), dt=4e-3, x_r=0.03)
    x_r = motion.x_r + noise * np.random.default_rng(1).standard_normal(1_000)
    return Kinematics(4e-3, np.zeros(1_000), motion.x_dd, x_r, motion.v_r)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_free_decay_gives_stiffness_damping_and_friction_by_its_turning_points(noise):
    found = decay_start(decay(noise, **SCENE), {"m": 4.0})

    assert found["k_x"] == pytest.approx(900.0, rel=0.01)
    assert found["b"] == pytest.approx(1.5, rel=0.15)
    assert found["F_fk"] == pytest.approx(1.2, rel=0.05)


def test_stiffness_that_is_known_gives_the_mass_of_a_free_decay():
    found = decay_start(decay(**SCENE), {"k_x": 900.0})
    assert (found["m"], found["k_x"]) == (pytest.approx(4.0, rel=0.01), 900.0)


def test_decay_of_few_half_cycles_gives_no_start():
    assert decay_start(decay(**{**SCENE, "F_fk": 10.0}), {"m": 4.0}) is None
