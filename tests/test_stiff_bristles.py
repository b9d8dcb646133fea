"""Bristles so stiff that they settle in no time: the same answer, at a cost that stays."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp  # noqa: TID253 - the independent solution

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import BRISTLE, LEUVEN, Dynamic, Law
from drysim.core.taylor import SETTLED
from drysim.metrics import measure
from law_scenes import PAPER, REST, STEP, noise, sine, solved
from reference import assert_agrees, peak
from test_dynamic_laws import bristle_rates

DAHL = Dynamic(45.0, 45.0, BRISTLE)
LUGRE = Dynamic(45.0, 54.0, BRISTLE, v_s=5e-3, sigma_1=300.0, sigma_2=0.4)
LAWS = {
    "dahl": DAHL,
    "lugre": LUGRE,
    "leuven": LUGRE._replace(kind=LEUVEN, F_h=80.0),
    "leuven-2": LUGRE._replace(kind=LEUVEN, F_h=80.0, power=2.0),
    "leuven-1.5": LUGRE._replace(kind=LEUVEN, F_h=80.0, power=1.5),
    "leuven-3": LUGRE._replace(kind=LEUVEN, F_h=80.0, power=3.0),
}
every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)


def followed(law, motion, sigma_0, end=2.0):
    law = law._replace(sigma_0=sigma_0)
    return StickSlip().track(PAPER, law, motion, REST, STEP, end)


def directions(track):
    """Give the direction that each step has in its trail."""
    course = track.course
    return np.concatenate([course.leg(i).trail.d for i in range(len(course.marks) - 1)])


@pytest.mark.parametrize("law", [DAHL, LUGRE], ids=["dahl", "lugre"])
def test_settled_bristles_move_as_those_resolved_by_an_integrator(law):
    motion, law = sine(1.0, 1.6), law._replace(sigma_0=1e7)
    track = StickSlip().track(PAPER, law, motion, REST, STEP, 0.6)
    assert (np.abs(directions(track)) > SETTLED).any()
    rates = bristle_rates(law, PAPER, lambda t: motion.A[0] * math.sin(2 * math.pi * 1.6 * t))
    t = np.linspace(0.0, 0.6, 200)

    def known(rtol):
        # Longer steps are unstable with such bristles: they tremble by more than the tolerance.
        return solve_ivp(
            rates, (0.0, 0.6), [0.0] * 3, "DOP853", t, rtol=rtol, atol=1e-5 * rtol,
            max_step=2e-4,
        ).y  # fmt: skip

    x_r, v_r, z, _, _ = track.at(t)
    own = 1e-11 * peak(x_r), 1e-10 * peak(v_r), 1e-9 * peak(z)
    assert_agrees([x_r, v_r, z], known, own)


@every_law
@pytest.mark.parametrize("motion", [sine(1.0, 1.6), noise(801, 1.0)], ids=["sine", "noise"])
def test_steps_grow_far_less_than_stiffness(law, motion):
    """A step that resolves the bristles is as short as they are stiff; a mass at rest on them
    still vibrates with the root of the stiffness."""
    soft, stiff = (len(directions(followed(law, motion, s))) for s in (1e6, 1e10))
    assert stiff < 30 * soft


@every_law
@pytest.mark.parametrize("sigma_0", [1e7, 1e9, 1e11])
def test_settled_bristles_do_not_depend_on_the_tolerance(law, sigma_0):
    motion, t = sine(1.0, 1.6), np.linspace(0.0, 2.0, 801)
    fine, coarse = (
        followed(law._replace(tolerance=tolerance), motion, sigma_0)
        for tolerance in (1e-12, 1e-8)
    )
    assert np.abs(fine.at(t)[0] - coarse.at(t)[0]).max() < 1e-9 * np.abs(fine.at(t)[0]).max()
    assert measure(fine, (0.5, 2.0), None)["energy_residual"] < 1e-10


@every_law
def test_the_stiffest_bristles_come_to_coulomb_at_the_same_rate(law):
    motion = sine(1.0, 1.6)
    law = law._replace(F_fs=45.0, sigma_1=0.0, sigma_2=0.0)
    coulomb = solved(Law(45.0, 45.0), motion, duration=2.0).x_r
    errors = [
        np.abs(solved(law._replace(sigma_0=s), motion, duration=2.0).x_r - coulomb).max()
        for s in (1e8, 1e10)
    ]
    assert errors[1] < 2e-3 * np.abs(coulomb).max()
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)
