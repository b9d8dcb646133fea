"""Where the order of events changes with friction, both sides say that a decision is close."""

from __future__ import annotations

import math

import numpy as np
import pytest
from seat import ranges

from drysim.approach.stick_slip import StickSlip
from drysim.core.events import IMPACT, REVERSAL, SLIP, STICK
from drysim.core.model import (
    STRIBECK,
    CoulombLaw,
    DynamicLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
)

CHANGE = 1e-12
"""Relative change of friction that changes the order of events [-]."""

CLOSE = 1e-7
"""Largest margin that is right beside such a change: a scene amplifies it [-]."""

AT_ZERO = (STICK, SLIP, REVERSAL, IMPACT)
"""Kinds of event at which v_r of a rigid contact is zero, or turns."""

REST = State(0.0, 0.0)
STEP, END = 0.01, 6.0
LAWS = ("coulomb", "varying", "by direction", "bumpers")
BASES = ("one sine", "sines", "samples", "coarse samples")


def drawn_scene(law, base, seed):
    """Return plant, base motion, and the law as a function of a factor of friction."""
    draw = np.random.default_rng([LAWS.index(law), BASES.index(base), seed])
    m = 10.0
    k_x = m * float(draw.uniform(3.0, 12.0)) ** 2
    plant = Plant(m, k_x, float(draw.choice([0.0, 20.0, 60.0])))
    f = draw.uniform(0.5, 3.0, 3)
    A, phase = draw.uniform(0.5, 2.0, 3), draw.uniform(0.0, 6.0, 3)
    count = 1 if base == "one sine" else 3
    sines = Sines(*(tuple(map(float, column[:count])) for column in (A, f, phase)))
    if base in BASES[:2]:
        motion = sines
    else:
        step = STEP if base == "samples" else 12.0 * STEP
        t = np.arange(int(END / step) + 1) * step
        u_dd = sum(a * np.sin(math.tau * g * t + p) for a, g, p in zip(*sines, strict=True))
        motion = Samples(u_dd, step)
    F, ratio = float(draw.uniform(3.0, 12.0)), float(draw.choice([1.05, 1.1, 1.5]))

    def with_friction(factor):
        F_fk, F_fs = factor * F, factor * F * ratio
        stops = EndStops(StrokeLimits(0.003, 0.003), ((0.0, 3e3),))
        return {
            "coulomb": CoulombLaw(F_fk, F_fs),
            "varying": CoulombLaw(F_fk, F_fs, 0.4, 8.0, 0.3),
            "by direction": PiecewiseLaw(F_fk, F_fs, compression=(0.7 * F_fk, F_fs)),
            "bumpers": PiecewiseLaw(F_fk, F_fs, stops=stops),
        }[law]

    return plant, motion, with_friction


def solved(plant, motion, law):
    found = StickSlip().trajectory(plant, law, motion, REST, END)
    return found if found.reaches_stops else found.without_stops


def order_changes(one, other):
    """Whether the events come in another order; one more at the end does not count.

    That a stop is just reached does not count either: it is no decision about sticking.
    """
    if type(one.law) is not type(other.law):
        return False
    kinds = [
        events.kind[np.isin(np.abs(events.kind), AT_ZERO)]
        for events in (one.events, other.events)
    ]
    common = min(map(len, kinds))
    return not np.array_equal(kinds[0][:common], kinds[1][:common])


def change_of_order(plant, motion, with_friction):
    """Return the trajectories on both sides of a change in the order of events, or None."""
    low = 1.0
    for high in np.linspace(1.005, 1.2, 40).tolist():
        ends = [solved(plant, motion, with_friction(factor)) for factor in (low, high)]
        if order_changes(*ends):
            break
        low = high
    else:
        return None
    while high - low > CHANGE:
        middle = 0.5 * (low + high)
        between = solved(plant, motion, with_friction(middle))
        if order_changes(ends[0], between):
            high, ends[1] = middle, between
        else:
            low, ends[0] = middle, between
    return ends


def check(law, base, seed):
    ends = change_of_order(*drawn_scene(law, base, seed))
    if ends is not None:
        assert max(trajectory.closest_decision for trajectory in ends) < CLOSE, seed
    return ends is not None


@pytest.mark.parametrize("seeds", ranges(4, 60))
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("law", LAWS)
def test_a_change_of_the_order_of_events_is_a_close_decision(law, base, seeds):
    assert sum(check(law, base, seed) for seed in seeds) > 0


def test_force_at_the_end_of_the_step_of_a_stop_is_a_close_decision():
    assert check("coulomb", "coarse samples", 44)


RIGID_LAWS = {
    "coulomb": CoulombLaw,
    "by direction": lambda F_fk, F_fs: PiecewiseLaw(F_fk, F_fs, compression=(F_fk, F_fs)),
    "stribeck": lambda F_fk, F_fs: DynamicLaw(F_fk, F_fs, STRIBECK, 0.01),
}
A = 1.5
WAVE = np.sin(math.tau * np.arange(1201) / 100)
BASE_MOTIONS = {
    "one sine": Sines((A,), (1.6,), (0.0,)),
    "two sines": Sines((0.5 * A, 0.5 * A), (1.6, 1.6), (0.0, 0.0)),
    "samples": Samples(A * WAVE, 0.00625),
}


@pytest.mark.parametrize("ratio", [1.0, 1.2])
@pytest.mark.parametrize("base", BASE_MOTIONS)
@pytest.mark.parametrize("law", RIGID_LAWS)
def test_break_away_that_is_nearly_missed_or_reached_is_known_by_its_distance(law, base, ratio):
    plant = Plant(75.0, 7500.0, 500.0)
    for distance in (-1e-12, 1e-12, -1e-4, 1e-4):
        F_fs = plant.m * A * (1.0 + distance)
        found = StickSlip().solve(
            plant, RIGID_LAWS[law](F_fs / ratio, F_fs), BASE_MOTIONS[base], REST, 0.00625, 7.5
        )
        assert (len(found.events) == 1) == (distance > 0.0)
        closest = found.numerics.closest_decision
        assert closest == pytest.approx(abs(distance), rel=1e-3, abs=5e-15)


@pytest.mark.parametrize("base", BASE_MOTIONS)
@pytest.mark.parametrize("law", RIGID_LAWS)
def test_mass_that_stands_far_below_its_limit_is_no_close_decision(law, base):
    plant = Plant(75.0, 7500.0, 500.0)
    law = RIGID_LAWS[law](2.0 * plant.m * A, 2.0 * plant.m * A)
    found = StickSlip().solve(plant, law, BASE_MOTIONS[base], REST, 0.00625, 7.5)
    # What is far from a decision may be left out.
    assert (found.numerics.closest_decision or 1.0) > 0.45
    still = StickSlip().solve(plant, law, Samples(np.zeros(9), 0.1), REST, 0.1)
    assert still.numerics.closest_decision is None
