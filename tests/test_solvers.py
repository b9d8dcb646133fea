"""The table of exact algorithms: which one solves a scene, and what a result says about it."""

from importlib import import_module

import numpy as np
import pytest

from drysim.approach.solvers import SOLVERS, solver_of
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
    Sines,
    State,
    StrokeLimits,
)

PLANT = Plant(75.0, 7500.0, 500.0)
SINE = Sines((1.0,), (1.6,), (0.0,))
SAMPLES = Samples(np.sin(np.arange(200) * 0.05), 5e-3)
STOPS = EndStops(StrokeLimits(1e-3, 1e-3), ((0.0, 1e5),))
RECORD = NormalForceRecord(np.array([1.0, 0.5, 1.5, 1.0]), 0.5, 100.0)

SCENES = {
    "stops": (PiecewiseLaw(30.0, 40.0, stops=STOPS), SINE, "end-stops", "end stops"),
    "stops of an elastic contact": (
        PiecewiseLaw(30.0, 30.0, 2e4, stops=STOPS), SAMPLES, "end-stops", "end stops",
    ),
    "elastic": (PiecewiseLaw(30.0, 30.0, 2e4), SINE, "elastic-contact", "elastic contact"),
    "damper by direction": (
        PiecewiseLaw(30.0, 40.0, damping=(900.0, 100.0)), SAMPLES, "by-direction",
        "friction or",
    ),
    "friction by direction": (
        PiecewiseLaw(30.0, 40.0, compression=(10.0, 12.0)), SINE, "by-direction", "friction or",
    ),
    "recorded": (
        PiecewiseLaw(30.0, 40.0, force_record=RECORD), SINE, "rigid-contact", "recorded normal",
    ),
    "vanishing": (
        PiecewiseLaw(30.0, 40.0, 0.0, 1.5, 8.0), SAMPLES, "rigid-contact", "vanishing normal",
    ),
    "rigid": (PiecewiseLaw(30.0, 40.0, 0.0, 0.5, 8.0), SINE, "rigid-contact", "rigid contact"),
    "stribeck": (
        DynamicLaw(30.0, 40.0, STRIBECK), SINE, "taylor-series", "friction that depends",
    ),
    "lugre": (
        DynamicLaw(30.0, 40.0, BRISTLE, 1e-2, 2.0, 1e5, 300.0), SAMPLES, "taylor-series",
        "bristles,",
    ),
    "leuven": (
        DynamicLaw(30.0, 40.0, LEUVEN, 1e-2, 2.0, 1e5, 300.0, 0.0, 60.0), SINE, "taylor-series",
        "bristles with hysteresis",
    ),
    "coulomb, sine": (CoulombLaw(30.0, 40.0), SINE, "event-to-event", "under sines"),
    "varying, sine": (CoulombLaw(30.0, 40.0, 0.5, 8.0), SINE, "event-to-event", "under sines"),
    "varying, samples": (
        CoulombLaw(30.0, 40.0, 0.5, 8.0), SAMPLES, "event-to-event", "varying friction limits",
    ),
    "coulomb, samples": (
        CoulombLaw(30.0, 40.0), SAMPLES, "sample-to-sample", "between samples",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_the_result_of_a_scene_names_the_algorithm_that_solved_it(name):
    law, motion, core, why = SCENES[name]
    solver = solver_of(law, motion)
    response = StickSlip().solve(PLANT, law, motion, State(0.0, 0.0), 5e-3, 0.9)
    assert (response.numerics.core, response.numerics.why) == (solver.core, solver.why)
    assert solver.core == core
    assert why in solver.why
    module = type(response.trajectory.march).__module__
    assert module == f"drysim.approach.{solver.module}"


def test_every_algorithm_solves_a_scene_and_has_a_reference():
    reached = {solver_of(law, motion) for law, motion, *_ in SCENES.values()}
    assert reached == {*SOLVERS}
    for solver in SOLVERS:
        module = import_module(f"drysim.approach.{solver.module}")
        assert callable(module.compute_trajectory)
        assert solver.reference
