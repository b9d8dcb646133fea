"""Scenarios, results and faults are plain values: they can be copied, pickled and sent."""

from __future__ import annotations

import copy
import multiprocessing
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from seat import SEAT

import drysim
from drysim import errors
from drysim.approach import APPROACHES_BY_NAME
from drysim.metrics.table import measure
from drysim.scenario.laws import LAWS

GALLERY = Path(__file__).parents[1] / "scenarios"
SCENARIOS = sorted(GALLERY.glob("*.yaml"))

SINE = "kind: harmonic, frequency: 1.6, rms: 1.0"
STANDARD = "kind: standard, class: EM3, duration: 2 s, seed: 1"
STEADY = SEAT.replace("steady: false, settle: 0, duration: 2", "steady: true")
WHOLE = SEAT.replace(", settle: 0, duration: 2", "")
RECORD = "t [s],a [m/s^2]\n" + "".join(
    f"{0.01 * n:.2f},{3.0 * np.sin(0.1 * n):.6f}\n" for n in range(200)
)

SCENES = {
    "sine": SEAT,
    "steady": STEADY,
    "rest": SEAT.replace(SINE, "kind: rest") + "start: {x_r: 10 mm}\n",
    "record": WHOLE.replace(SINE, "kind: record, file: base.csv, time: t").replace(
        ", step: 2.5e-3", ""
    ),
    "spectra": WHOLE.replace(SINE, STANDARD).replace("measure: {", "measure: {spectra: true, "),
    "bumpers": SEAT + "stroke: {limit: 4 mm, stops: {stiffness: 1e5, damping: 10}}\n",
    "rigid": SEAT + "stroke: {limit: 4 mm, stops: {restitution: 0.5}}\nchecks: [T_a < 9]\n",
    "options": SEAT.replace("kinetic: 15", "kinetic: 15, dahl: {bristle_stiffness: 1e5}"),
}
"""The last one holds options of another law, for which models are made when a file has some."""

FAULT = errors.Problem("is not a number", "seat.csv", 3, 4, key="friction.kinetic")
FAULTS = {
    type(fault).__name__: fault
    for fault in (
        errors.DrysimError("what", "do this"),
        errors.UsageError("what", "do this"),
        errors.ScenarioError("no scenario yet", (FAULT, FAULT), "do this"),
        errors.RecordError(FAULT, "do this"),
        errors.OutputError("what", "do this"),
        errors.SolverError("what", "do this"),
        errors.ClusterError("what", "do this"),
    )
}

WAYS = {
    "pickled": lambda value: pickle.loads(pickle.dumps(value)),
    "copied": copy.copy,
    "deepcopied": copy.deepcopy,
}
every_way = pytest.mark.parametrize("again", WAYS.values(), ids=WAYS)


@pytest.fixture
def scene(scenario, tmp_path):
    """Return the scenario of a text, beside a record."""
    (tmp_path / "base.csv").write_text(RECORD)
    return scenario


def same(one, two):
    """Whether two responses have the same points, events, numerics and metrics."""
    points = ("t", "u_dd", "x_r", "v_r", "d", "F_f", "x_dd")
    pairs = [(getattr(one, name), getattr(two, name)) for name in points]
    events = ("t", "kind", "x_r", "F_L")
    pairs += [(getattr(one.events, name), getattr(two.events, name)) for name in events]
    alike = all(np.array_equal(a, b) for a, b in pairs) and one.numerics == two.numerics
    if one.trajectory is None:
        return alike and two.trajectory is None
    span = (0.0, (len(one) - 1) * one.dt)
    return alike and measure(one.trajectory, span, None) == measure(two.trajectory, span, None)


def assert_kept(outcome):
    """Assert that an outcome is kept all ways, before and after its points are asked for."""
    for _ in range(2):
        for again in WAYS.values():
            twin = again(outcome)
            assert twin.scenario == outcome.scenario
            assert (twin.metrics, twin.checks) == (outcome.metrics, outcome.checks)
            assert twin.warnings == outcome.warnings
            assert same(twin.response, outcome.response)


def test_every_fault_is_among_those_tried():
    kinds = {kind.__name__ for kind in errors.DrysimError.__subclasses__()}
    assert FAULTS.keys() == kinds | {"DrysimError"}


@every_way
@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_fault_keeps_its_words_problems_and_hint(fault, again):
    twin = again(fault)
    assert type(twin) is type(fault)
    assert (str(twin), vars(twin), twin.args) == (str(fault), vars(fault), fault.args)


@every_way
@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_scenario_of_the_gallery_stays_what_it_is(file, again):
    scenario = drysim.load(file)
    twin = again(scenario)
    assert twin == scenario
    assert twin.resolved() == scenario.resolved()


@every_way
def test_scenario_with_options_of_another_law_still_reads_them(scenario, again):
    one = scenario(SCENES["options"])
    assert type(again(one)) is type(one)
    assert again(one).with_law("dahl").law() == one.with_law("dahl").law()


@pytest.mark.parametrize("name", SCENES)
def test_metrics_and_verdicts_are_numbers_of_python(scenario, tmp_path, name):
    (tmp_path / "base.csv").write_text(RECORD)
    checks = {"checks": ["stuck_share < 2", "v_r_rms < 1e9"]}
    outcome = drysim.run(scenario(SCENES[name], checks))
    assert {type(value) for value in outcome.metrics.values()} <= {int, float, type(None)}
    assert {type(verdict.passed) for verdict in outcome.checks} == {bool}
    assert "2 of 2 checks held" in repr(outcome)


@pytest.mark.parametrize("law", LAWS)
def test_outcome_of_every_law_keeps_its_numbers(law):
    short = {"steady": False, "settle": 0, "duration": 1}
    file = GALLERY / f"friction-{law}.yaml"
    assert_kept(drysim.run(drysim.load(file, {"measure": short})))


@pytest.mark.parametrize("approach", APPROACHES_BY_NAME)
def test_outcome_of_every_approach_keeps_its_numbers(scenario, approach):
    assert_kept(drysim.run(scenario(SEAT).with_approach(approach)))


@pytest.mark.parametrize("text", SCENES.values(), ids=SCENES)
def test_outcome_of_every_scene_keeps_its_numbers(scene, text):
    assert_kept(drysim.run(scene(text)))


@every_way
@pytest.mark.parametrize("F_fk", [0.0, 1.0])
def test_motion_of_simulate_keeps_its_numbers(again, F_fk):
    u_dd = 3.0 * np.sin(0.05 * np.arange(400))
    response = drysim.simulate(m=1, k_x=1, b=0.1, F_fk=F_fk, u_dd=u_dd, dt=0.05)
    assert same(again(response), response)


def job(asked):
    """Run a scenario; a fault is raised."""
    if isinstance(asked, Exception):
        raise asked
    return drysim.run(asked)


def through_a_pool(method, file):
    """Send a scenario and all faults to another process, and what becomes of them back."""
    here = drysim.run(drysim.load(file))
    with multiprocessing.get_context(method).Pool(1) as pool:
        there = pool.apply(job, (here.scenario,))
        assert there.scenario == here.scenario
        assert there.metrics == here.metrics
        assert same(there.response, here.response)
        for fault in FAULTS.values():
            with pytest.raises(type(fault)) as found:
                pool.apply(job, (fault,))
            assert (str(found.value), vars(found.value)) == (str(fault), vars(fault))


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_scenario_outcome_and_faults_pass_between_processes(seat, method):
    # A process of its own: this one has threads, which a fork would not take along.
    done = subprocess.run(
        [sys.executable, __file__, method, str(seat)],
        env={**os.environ, "DRYSIM_ENGINE": "plain", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr


if __name__ == "__main__":
    through_a_pool(*sys.argv[1:])
