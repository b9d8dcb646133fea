"""The case at a point of a sweep, and the same scene under another approach."""

from __future__ import annotations

import time
from math import sqrt

import numpy as np
import pytest

from drysim.approach import SHELF
from drysim.core.model import Law, Plant
from drysim.errors import ScenarioError
from drysim.scenario.axes import points
from drysim.scenario.load import load
from drysim.scenario.model import Scenario, period
from drysim.yaml_document import dump
from seat import dotted

WORDS = {
    "name": "seat",
    "oscillator": {"mass": 75, "stiffness": 7500, "damping_ratio": 0.25},
    "friction": {"law": "coulomb", "kinetic": 15, "static_ratio": 1.2},
    "stroke": {"limit": "25 mm"},
    "excitation": {"kind": "harmonic", "frequency": 1.6, "rms": 1.0},
    "solver": {"step": 2.5e-3},
}
NOISE = {"kind": "psd", "points": [[0.5, 1], [10, 1]], "duration": 60, "seed": 1}


@pytest.fixture
def scenario(tmp_path):
    """Give the scenario of some words laid over those of the seat."""

    def loaded(**words: object) -> Scenario:
        (tmp_path / "seat.yaml").write_text(dump(WORDS))
        return load(tmp_path / "seat.yaml", dotted(words))

    return loaded


def test_case_is_what_the_same_overrides_would_give(scenario):
    swept = {"excitation.frequency": [1, 5], "oscillator.mass": [75, 300]}
    point = {"excitation.frequency": 5.0, "oscillator.mass": 300.0}
    case = scenario(sweep=swept, reference="viscous").at(point)
    alone = scenario(excitation__frequency=5, oscillator__mass=300)
    assert case.resolved() == alone.resolved()
    assert (case.sweep, case.reference) == ((), None)


def test_case_keeps_the_origin_of_its_file(scenario):
    whole = scenario(sweep={"excitation.rms": [1, 2]})
    assert whole.at({"excitation.rms": 2.0}).origin == whole.origin
    assert whole.at({"excitation.rms": 2.0}).folder == whole.folder


def test_damping_ratio_follows_a_swept_mass(scenario):
    case = scenario(sweep={"oscillator.mass": [75, 300]}).at({"oscillator.mass": 300.0})
    assert case.oscillator.plant() == Plant(300.0, 7500.0, 0.25 * 2 * sqrt(7500 * 300))


def test_static_limit_follows_swept_kinetic_friction(scenario):
    case = scenario(sweep={"friction.kinetic": [0, 30]}).at({"friction.kinetic": 30.0})
    assert case.law() == Law(30.0, 36.0)


def test_normal_force_follows_a_swept_mass(scenario):
    words = {"law": "coulomb", "mu_kinetic": 0.02}
    whole = scenario(friction=words, sweep={"oscillator.mass": [1, 2]})
    assert whole.at({"oscillator.mass": 2.0}).law().F_fk == 0.02 * (9.81 * 2)


def test_window_in_periods_follows_a_swept_frequency(scenario):
    measure = {"settle": "4 periods", "duration": "20 periods"}
    whole = scenario(measure=measure, sweep={"excitation.frequency": [2, 5]})
    case = whole.at({"excitation.frequency": 5.0})
    assert (case.measure.settle, case.measure.duration) == (0.8, 4.0)
    assert period(case) == 0.2


def test_common_period_follows_a_swept_normal_force(scenario):
    friction = {**WORDS["friction"], "normal_variation": {"amplitude": 0.2, "frequency": 1.6}}
    sweep = {"friction.normal_variation.frequency": [0.4, 0.8]}
    whole = scenario(friction=friction, measure={"duration": "1 period"}, sweep=sweep)
    assert whole.at({"friction.normal_variation.frequency": 0.4}).measure.duration == 2.5


def test_swept_duration_counts_in_place_of_that_of_the_file(scenario):
    whole = scenario(measure={"duration": 5}, sweep={"measure.duration": [1, 2]})
    assert whole.at({"measure.duration": 2.0}).measure.duration == 2.0


def test_block_that_the_file_does_not_have_is_made(scenario):
    whole = scenario(sweep={"start.x_r": [0, 0.01], "solver.smooth.sharpness": [10, 20]})
    case = whole.at({"start.x_r": 0.01, "solver.smooth.sharpness": 20.0})
    assert case.start.x_r == 0.01
    assert case.solver.smooth.sharpness == 20.0


def test_cases_share_the_blocks_that_do_not_differ(scenario):
    whole = scenario(sweep={"friction.kinetic": [1, 2], "excitation.rms": [1, 2]})
    one, other = (whole.at({"friction.kinetic": F, "excitation.rms": 2.0}) for F in (1.0, 2.0))
    assert one.excitation is other.excitation
    assert one.oscillator is whole.oscillator


def test_whole_numbers_may_come_from_an_array(scenario):
    whole = scenario(excitation=NOISE, sweep={"excitation.seed": [1, 2]})
    assert whole.at({"excitation.seed": float(np.float64(2))}).excitation.seed == 2


def test_key_that_is_not_swept_may_be_set_as_well(scenario):
    assert scenario().at({"friction.kinetic": 30.0}).law() == Law(30.0, 36.0)


@pytest.mark.parametrize("key", ["friction", "friction.kinetik", "oscillator.mass.x", "no.key"])
def test_key_that_is_no_number_is_refused(scenario, key):
    with pytest.raises(ScenarioError, match="1 problem"):
        scenario().at({key: 30.0})


def test_every_point_is_tried_when_the_grid_is_small(scenario):
    friction = {"law": "coulomb", "kinetic": 15, "static": 30}
    sweep = {"friction.kinetic": {"from": 0, "to": 40, "step": 10}}
    with pytest.raises(ScenarioError) as fault:
        scenario(friction=friction, sweep=sweep)
    (problem,) = fault.value.problems
    assert problem.sentence == (
        "friction.static must be at least the kinetic 40 N, not 30 N (at friction.kinetic = 40)"
    )


def test_point_of_a_large_grid_is_tried_when_it_is_met(scenario):
    many = {"from": 1, "to": 40, "count": 200}
    friction = {"law": "coulomb", "kinetic": 15, "static": 30}
    sweep = {"friction.kinetic": many, "friction.static": many}
    whole = scenario(friction=friction, sweep=sweep)
    with pytest.raises(ScenarioError) as fault:
        whole.at({"friction.kinetic": 20.0, "friction.static": 10.0})
    assert "(at friction.kinetic = 20, friction.static = 10)" in str(fault.value.problems)


def test_approach_without_static_friction_is_refused_at_the_point_that_needs_it(scenario):
    words = {"solver.approach": "signum", "friction.static_ratio": 1}
    overrides = {key.replace(".", "__"): value for key, value in words.items()}
    with pytest.raises(ScenarioError) as fault:
        scenario(**overrides, sweep={"friction.static_ratio": [1, 1.2]})
    (problem,) = fault.value.problems
    assert "signum has no use for a static limit above kinetic" in problem.sentence
    assert problem.sentence.endswith("(at friction.static_ratio = 1.2)")


def test_step_that_is_too_coarse_for_a_swept_spectrum_is_refused(scenario):
    sweep = {"excitation.points.1.0": [10, 1000]}
    with pytest.raises(ScenarioError) as fault:
        scenario(excitation=NOISE, sweep=sweep)
    assert "solver.step must be below 0.0005 s" in fault.value.problems[0].sentence


def test_points_are_enumerated_lazily_and_the_first_key_varies_fastest(scenario):
    many = {"from": 1, "to": 100_000, "step": 1}
    sweep = {"excitation.rms": many, "excitation.frequency": many, "friction.kinetic": many}
    grid = points(scenario(sweep=sweep).sweep)
    first, second = next(grid), next(grid)
    assert list(first.values()) == [1.0, 1.0, 1.0]
    assert list(second.values()) == [2.0, 1.0, 1.0]


def test_thousands_of_cases_are_made_in_a_fraction_of_a_second(scenario):
    whole = scenario(
        sweep={
            "excitation.frequency": {"from": 0.5, "to": 10, "step": 0.1},
            "excitation.rms": {"from": 0.1, "to": 1, "step": 0.1},
            "friction.kinetic": [15, 30, 45, 60],
        }
    )
    began = time.process_time()
    laws = [whole.at(point).law() for point in points(whole.sweep)]
    assert len(laws) == 3840
    assert time.process_time() - began < 2


# Another approach


@pytest.mark.parametrize("name", SHELF)
def test_every_approach_can_take_the_scene(scenario, name):
    friction = {**WORDS["friction"], "normal_variation": {"amplitude": 0.2, "frequency": 1.6}}
    other = scenario(friction=friction).with_approach(name)
    assert other.solver.approach == name
    assert load_again(other).law() == other.law()


def load_again(scenario: Scenario) -> Scenario:
    """Give the scenario that a file with the words of another would be."""
    file = scenario.folder / "again.yaml"
    file.write_text(dump(scenario.resolved()))
    return load(file)


def test_approach_without_friction_drops_the_block_and_its_axes(scenario):
    sweep = {"friction.kinetic": [15, 45], "excitation.rms": [1, 2]}
    other = scenario(sweep=sweep, reference="viscous").with_approach("viscous")
    assert other.friction is None
    assert other.reference is None
    assert [axis.key for axis in other.sweep] == ["excitation.rms"]
    assert other.at({"excitation.rms": 2.0}).excitation.rms == 2.0


def test_approach_without_static_friction_takes_it_as_kinetic(scenario):
    sweep = {"friction.static_ratio": [1, 1.2], "friction.kinetic": [10, 20]}
    other = scenario(sweep=sweep).with_approach("signum")
    assert other.law() == Law(15.0, 15.0)
    assert other.at({"friction.kinetic": 20.0}).law() == Law(20.0, 20.0)
    assert [axis.key for axis in other.sweep] == ["friction.kinetic"]


def test_options_of_another_approach_are_not_swept(scenario):
    sweep = {"solver.smooth.sharpness": [10, 20], "excitation.rms": [1, 2]}
    whole = scenario(sweep=sweep)
    assert [axis.key for axis in whole.with_approach("smooth").sweep] == list(sweep)
    assert [axis.key for axis in whole.with_approach("moreau").sweep] == ["excitation.rms"]


def test_losses_name_the_approach_and_what_it_leaves_out(scenario):
    friction = {**WORDS["friction"], "normal_variation": {"amplitude": 0.2, "frequency": 1.6}}
    whole = scenario(friction=friction)
    assert whole.losses("stick-slip") == ()
    assert whole.losses("viscous") == ("viscous leaves the dry friction out",)
    assert whole.losses("moreau") == (
        "moreau knows no static limit above kinetic friction and takes F_fs = F_fk",
        "moreau knows no varying normal force and takes it as constant",
    )


def test_swept_friction_is_a_loss_even_when_the_base_has_none(scenario):
    sweep = {"friction.kinetic": [0, 20], "friction.static_ratio": [1, 1.2]}
    whole = scenario(friction__kinetic=0, sweep=sweep)
    assert whole.losses("viscous") == ("viscous leaves the dry friction out",)
    assert len(whole.losses("signum")) == 1


def test_approach_that_is_not_on_the_shelf_is_refused(scenario):
    with pytest.raises(ValueError, match="did you mean `signum`"):
        scenario().with_approach("signun")
