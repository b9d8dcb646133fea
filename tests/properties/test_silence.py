"""A base that is silent at first: its step of motion is not booked as rest, nor twice."""

from __future__ import annotations

import math

import numpy as np
import pytest
from law_scenes import halved
from seat import ranges

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    CoulombLaw,
    DynamicLaw,
    EndStops,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    Samples,
    State,
    StrokeLimits,
)
from drysim.metrics.table import measure

AGREES = 1e-8
"""Relative difference of an integral from that of an equivalent scene [-]."""

NOTHING = 1e-20
"""Friction that changes no motion, relative to the greatest force of the base [-]."""

STOPS = {
    "no stops": None,
    "bumper": ((0.0, 4e4),),
    "bumper of two stages": ((0.0, 2e4), (1e-3, 6e4)),
    "rigid": (),
}
DYNAMIC = ("stribeck", "dahl", "lugre", "leuven")
LAWS = (
    "no friction", "coulomb", "by direction", "damper by direction", "separating",
    "recorded load", "jenkins", "petrov-ewins", *DYNAMIC,
)  # fmt: skip
KINDS = [
    (law, stops)
    for law in LAWS
    for stops in STOPS
    if stops == "no stops" or law not in DYNAMIC
    if (law, stops) != ("petrov-ewins", "rigid")
]


def drawn_scene(law, stops, seed):
    """Return plant, law, samples that are silent at first, and start of a drawn scene."""
    draw = np.random.default_rng([LAWS.index(law), list(STOPS).index(stops), seed])
    dt, n, lead = 10 ** draw.uniform(-3.0, -2.0), 48, int(draw.integers(0, 7))
    u_dd = np.zeros(n)
    u_dd[lead + 1 :] = draw.uniform(-30.0, 30.0, n - lead - 1)
    # A shock holds its value for some samples, and a record of few digits repeats them.
    if seed % 2:
        u_dd[lead + 1 :] = np.repeat(u_dd[lead + 1 :: 6], 6)[: n - lead - 1]
    m, k_x = 5.0, float(draw.choice([0.0, 2e3, 1e4]))
    plant = Plant(m, k_x, float(draw.choice([0.0, 40.0])))
    start = State(0.0 if k_x else float(draw.uniform(-1e-3, 1e-3)), 0.0)
    F = float(draw.uniform(5.0, 40.0))
    law = drawn_law(law, F, plant, dt, n, draw)
    if STOPS[stops] is not None:
        limit = float(draw.uniform(0.002, 0.004))
        rigid = not STOPS[stops]
        b_s, e = 0.0 if rigid else float(draw.choice([0.0, 50.0])), 0.0
        if rigid:
            e = float(draw.choice([0.0, 0.4]))
        ends = EndStops(StrokeLimits(limit, 1.5 * limit), STOPS[stops], b_s, e)
        law = law.as_piecewise()._replace(stops=ends)
    return plant, law, Samples(u_dd, dt), start


def drawn_law(name, F, plant, dt, n, draw):
    """Return a law whose largest friction force is about F [N]."""
    F_fs = F * float(draw.choice([1.0, 1.3]))
    wave = float(draw.uniform(1.2, 2.0)), math.tau * float(draw.uniform(2.0, 9.0)), 0.4
    load = np.abs(draw.normal(1.0, 1.0, n))
    record = NormalForceRecord(load, dt, 1.0)
    by_direction = {"damping": (60.0, 25.0)}
    return {
        "no friction": PiecewiseLaw(0.0, 0.0),
        "coulomb": CoulombLaw(F, F_fs),
        "by direction": PiecewiseLaw(F, F_fs, compression=(0.5 * F, F), **by_direction),
        "damper by direction": PiecewiseLaw(0.0, 0.0, **by_direction),
        "separating": PiecewiseLaw(F, F_fs, 0.0, *wave),
        "recorded load": PiecewiseLaw(F, F_fs, force_record=record),
        "jenkins": PiecewiseLaw(F, F, 2e4),
        "petrov-ewins": PiecewiseLaw(F, F, 2e4, *wave),
        "stribeck": DynamicLaw(F, F_fs, STRIBECK, 0.02),
        "dahl": DynamicLaw(F, F, BRISTLE, sigma_0=2e4),
        "lugre": DynamicLaw(F, F_fs, BRISTLE, 0.02, sigma_0=2e4, sigma_1=20.0),
        "leuven": DynamicLaw(F, F_fs, LEUVEN, 0.02, sigma_0=2e4, sigma_1=20.0, F_h=2.0 * F_fs),
    }[name]


def totals_of(plant, law, motion, start, begin=0.0):
    """Return the integrals from a time [s] on, and the response."""
    response = StickSlip().solve(plant, law, motion, start, motion.dt)
    trajectory = response.trajectory
    values = measure(trajectory, (begin, trajectory.end), None)
    names = "a_x", "x_r_rms", "v_r_rms", "stuck_share", "energy_friction", "energy_input"
    return np.array([values[name] for name in names]), trajectory.end


def assert_same(found, expected):
    scale = np.maximum(np.abs(expected), 1e-6 * np.abs(expected).max())
    assert found == pytest.approx(expected, abs=AGREES * scale.max(), rel=AGREES)


def check(law, stops, seed):
    plant, law, motion, start = drawn_scene(law, stops, seed)
    found, _ = totals_of(plant, law, motion, start)
    # The base is linear between its samples: half the step changes nothing.
    assert_same(totals_of(plant, law, halved(motion), start)[0], found)
    if isinstance(law, PiecewiseLaw) and not law.F_fk and law.compression is None:
        F = NOTHING * plant.m * np.abs(motion.u_dd).max()
        some, _ = totals_of(plant, law._replace(F_fk=F, F_fs=F), motion, start)
        assert_same(some, found)


@pytest.mark.parametrize("seeds", ranges(6, 200))
@pytest.mark.parametrize(("law", "stops"), KINDS)
def test_a_start_from_silence_is_booked_as_it_is(law, stops, seeds):
    for seed in seeds:
        check(law, stops, seed)
