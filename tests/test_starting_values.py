"""Starting values of a fit in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import drysim
from drysim.study.starting_values import Kinematics, decay_start, liveliest_part

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


def test_starts_of_a_long_record_follow_from_its_liveliest_minute():
    t = np.arange(30_000) * 0.01
    relative = np.where((t >= 130.0) & (t < 190.0), 2.0, 0.1) * np.sin(7.0 * t)
    u_dd = np.cos(3.0 * t)
    motion = Kinematics(0.01, u_dd, u_dd + relative, x_r=t)
    part = liveliest_part(motion)

    assert len(part.u_dd) == len(part.x_dd) == len(part.x_r) == 6_000
    assert part.x_r[0] == pytest.approx(130.0, abs=0.5)
    assert part.v_r is None
    assert np.array_equal(part.u_dd, u_dd[np.isin(t, part.x_r)])


def test_starts_of_a_short_record_follow_from_all_of_it():
    motion = decay(**SCENE)
    assert liveliest_part(motion) is motion
