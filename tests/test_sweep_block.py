"""The sweep block of a scenario: axes from words, and how a file says them again."""

from __future__ import annotations

import json
from functools import partial
from math import pi, prod, sqrt

import numpy as np
import pytest
from seat import load_text

from drysim.approach import APPROACHES_BY_NAME
from drysim.core.model import CoulombLaw, Plant
from drysim.errors import ScenarioError
from drysim.scenario import schema
from drysim.scenario.axes import Axis
from drysim.scenario.load import load
from drysim.scenario.model import Scenario, scene_period
from drysim.scenario.warnings import scenario_warnings
from drysim.yaml_document import dump

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""

RECORD = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: base.csv, column: u_dd, time: t}
"""

NOISE = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
excitation: {kind: psd, points: [[0.5, 1], [10, 1]], duration: 60, seed: 1}
solver: {step: 2.5e-3}
"""


@pytest.fixture
def scenario(scenario):
    """Return the scenario of a text with a sweep block, with overrides."""

    def loaded(text: str, sweep: object = None, overrides: object = ()) -> Scenario:
        return scenario(text + ("" if sweep is None else dump({"sweep": sweep})), overrides)

    return loaded


@pytest.fixture
def values(scenario):
    """Return the values of the only axis that a sweep of some key has."""

    def found(spoken: object, key: str = "excitation.frequency", text: str = SEAT) -> object:
        (axis,) = scenario(text, {key: spoken}).sweep
        return axis.values

    return found


@pytest.fixture
def fault(scenario):
    """Return the messages on a faulty sweep."""

    def told(sweep: object, text: str = SEAT, overrides: object = ()) -> list[str]:
        with pytest.raises(ScenarioError) as found:
            scenario(text, sweep, overrides)
        return [problem.sentence for problem in found.value.problems]

    return told


def test_axes_are_in_the_order_of_the_file_and_in_si(scenario):
    sweep = {"excitation.rms": [0.5, "0.1 g"], "friction.kinetic": ["15 N", 45]}
    assert scenario(SEAT, sweep).sweep == (
        Axis("excitation.rms", "m/s2", (0.5, 0.980665)),
        Axis("friction.kinetic", "N", (15.0, 45.0)),
    )


def test_scenario_without_a_sweep_has_no_axes(scenario):
    assert scenario(SEAT).sweep == ()
    assert scenario(SEAT).reference is None


def test_steps_that_are_no_decimals_meet_their_end_exactly(values):
    found = values({"from": 0, "to": "90 deg", "step": "30 deg"}, "excitation.phase")
    assert found == pytest.approx([0, pi / 6, pi / 3, pi / 2])
    assert found[-1] == pi / 2


@pytest.mark.parametrize(
    ("key", "spoken", "expected"),
    [
        ("excitation.frequency", {"from": 0.5, "to": 10, "step": 0.1},
         tuple(n / 10 for n in range(5, 101))),
        ("start.x_r", {"from": 0, "to": "25 mm", "step": "5 mm"},
         (0.0, 0.005, 0.01, 0.015, 0.02, 0.025)),
        ("solver.smooth.sharpness", ["1e3 s/m", "2 s/mm"], (1e3, 2e3)),
        ("excitation.frequency", {"from": 0.1, "to": 0.7, "count": 7},
         (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)),
        ("excitation.rms", {"from": 1, "to": 2, "count": 4},
         pytest.approx([1, 4 / 3, 5 / 3, 2])),
        ("excitation.rms", {"from": 1, "to": 2, "count": 1e3},
         pytest.approx(np.linspace(1, 2, 1000))),
        ("excitation.frequency", {"from": 0.001, "to": 1000, "count": 7, "scale": "log"},
         (0.001, 0.01, 0.1, 1.0, 10.0, 100.0, 1000.0)),
    ],
)  # fmt: skip
def test_values_of_an_axis_are_the_numbers_that_its_words_mean(values, key, spoken, expected):
    assert values(spoken, key) == expected


def test_octaves_have_at_least_the_values_asked_for_and_both_ends(values):
    assert values({"from": 1, "to": 8, "per_octave": 1}) == pytest.approx([1, 2, 4, 8])
    found = values({"from": 1, "to": 50, "per_octave": 12})
    assert (found[0], found[-1], len(found)) == (1.0, 50.0, 69)  # log2(50) = 5.64


def test_shock_spectrum_runs_again_as_it_was_resolved(scenario):
    shock = {"kind": "shock", "pulse": "sawtooth", "amplitude": 9, "duration": 0.01}
    text = dump(
        {
            "oscillator": {"mass": 5, "natural_frequency": 9, "damping_ratio": 0.05},
            "excitation": shock,
            "solver": {"step": 1e-3},
            "measure": {"duration": 1},
        }
    )
    found = scenario(text, {"srs": {"from": "1 Hz", "to": 50, "per_octave": 12}})
    words = found.resolved()
    assert words["sweep"] == {"srs": {"from": 1.0, "to": 50.0, "count": 69, "scale": "log"}}
    assert scenario(dump(words)).sweep == found.sweep
    assert scenario(text, {"srs": [1, 50]}).sweep[0].values == (1.0, 50.0)


def test_seeds_stay_whole_numbers(values):
    found = values({"from": 1, "to": 4, "step": 1}, "excitation.seed", NOISE)
    assert [repr(value) for value in found] == ["1", "2", "3", "4"]


@pytest.mark.parametrize(
    ("text", "key", "unit"),
    [
        (SEAT, "oscillator.mass", "kg"),
        (SEAT, "oscillator.stiffness", "N/m"),
        (SEAT, "oscillator.damping", "N*s/m"),
        (SEAT, "friction.static_ratio", "-"),
        (SEAT, "stroke.limit", "m"),
        (SEAT, "start.v_r", "m/s"),
        (SEAT, "solver.smooth.sharpness", "s/m"),
        (SEAT, "solver.switch.band", "m/s"),
        (SEAT, "excitation.phase", "rad"),
        (RECORD, "excitation.scale", "-"),
        (RECORD, "measure.duration", "s"),
        (RECORD, "excitation.window.from", "s"),
        (RECORD, "excitation.remove.below", "Hz"),
        (NOISE, "excitation.rms", "m/s2"),
        (NOISE, "excitation.points.1.0", "Hz"),
        (NOISE, "excitation.points.0.1", "(m/s2)2/Hz"),
    ],
)
def test_any_numeric_key_of_the_file_may_be_swept(scenario, text, key, unit):
    found = scenario(text, {key: [2, 3]})
    assert [(axis.key, axis.unit, axis.values) for axis in found.sweep] == [(key, unit, (2, 3))]
    assert found.at({key: 3}).sweep == ()


def test_entries_of_lists_may_be_swept(scenario):
    sines = "sines, components: [{frequency: 1, rms: 1}, {frequency: 2, rms: 1}]"
    text = SEAT.replace("harmonic, frequency: 1.6, rms: 1.0", sines)
    text += "measure: {duration: 5}\n"
    found = scenario(text, {"excitation.components.1.frequency": [3, 4]})
    case = found.at({"excitation.components.1.frequency": 4.0})
    assert case.excitation.frequencies == (1.0, 4.0)


def test_word_that_is_the_default_makes_room_for_a_swept_block(scenario):
    found = scenario(RECORD, {"excitation.remove.below": [0.3, 0.5]})
    again = scenario(dump(found.resolved()))
    assert again.at({"excitation.remove.below": 0.5}).excitation.remove.below == 0.5


@pytest.mark.parametrize("text", [SEAT, RECORD, NOISE])
def test_sweep_runs_again_as_it_was_resolved(scenario, text):
    sweep = {
        "oscillator.mass": {"from": 1, "to": 100, "count": 3, "scale": "log"},
        "oscillator.damping": [1, 2],
        "oscillator.stiffness": {"from": "1 kN/m", "to": "2 kN/m", "step": "0.5 kN/m"},
    }
    found = scenario(text, sweep, {"reference": "moreau"} if text != NOISE else ())
    words = found.resolved()
    again = scenario(dump(words))
    assert again.resolved() == words
    assert (again.sweep, again.reference) == (found.sweep, found.reference)
    assert words["sweep"]["oscillator.stiffness"] == {"from": 1e3, "to": 2e3, "step": 500.0}


def test_defaults_that_follow_a_swept_key_are_not_spelled_out(scenario):
    text = SEAT.replace("kinetic: 15", "mu_kinetic: 0.02")
    found = scenario(text, {"oscillator.mass": [75, 150], "friction.mu_static": [0.03, 0.04]})
    again = scenario(dump(found.resolved()))
    point = {"oscillator.mass": 150.0, "friction.mu_static": 0.04}
    assert again.at(point).law() == found.at(point).law()
    assert again.at(point).law().F_fk == 0.02 * (9.81 * 150)


def test_window_in_periods_stays_so_for_a_swept_frequency(scenario):
    text = SEAT + "measure: {settle: 1 period, duration: 4 periods}\n"
    found = scenario(text, {"excitation.frequency": [2, 4]})
    again = scenario(dump(found.resolved()))
    assert again.measure == found.measure
    case = again.at({"excitation.frequency": 4.0})
    assert (case.measure.settle, case.measure.duration, scene_period(case)) == (0.25, 1.0, 0.25)


def test_sweep_without_an_end_is_not_held_in_memory(scenario):
    many = {"from": 1, "to": 100_000, "step": 1}
    sweep = {"excitation.frequency": many, "friction.kinetic": many, "oscillator.mass": many}
    axes = scenario(SEAT, sweep).sweep
    assert prod(len(axis.values) for axis in axes) == 10**15


# Overrides


def test_set_behind_sweep_takes_the_rest_for_one_key(scenario):
    found = scenario(SEAT, None, ["sweep.excitation.frequency=[1, 2]"])
    assert found.sweep == (Axis("excitation.frequency", "Hz", (1.0, 2.0)),)
    assert found.origin["overrides"] == {"sweep.excitation.frequency": [1, 2]}


def test_set_leads_into_what_the_file_sweeps_already(scenario):
    sweep = {"excitation.frequency": {"from": 1, "to": 2, "step": 1}, "excitation.rms": [1, 2]}
    words = ["sweep.excitation.frequency.step=0.5", "sweep.excitation.rms.1=3 m/s2"]
    found = scenario(SEAT, sweep, words)
    assert [axis.values for axis in found.sweep] == [(1.0, 1.5, 2.0), (1.0, 3.0)]


def test_set_takes_an_axis_or_the_whole_sweep_away(scenario):
    sweep = {"excitation.frequency": [1, 2], "excitation.rms": [1, 2]}
    found = scenario(SEAT, sweep, ["sweep.excitation.rms=null"])
    assert [axis.key for axis in found.sweep] == ["excitation.frequency"]
    assert scenario(SEAT, sweep, ["sweep=null"]).sweep == ()


def test_fault_of_a_set_axis_names_the_word(fault, scenario):
    override = "sweep.excitation.rms=[1, -1]"
    with pytest.raises(ScenarioError) as found:
        scenario(SEAT, None, [override])
    assert [problem.file for problem in found.value.problems] == [f"--set {override}"]


# Faults that need a scene of their own; the others stand in problems/


@pytest.mark.parametrize(
    ("text", "sweep", "sentence"),
    [
        (
            RECORD,
            {"solver.step": ["1 ms", "2 ms"]},
            "solver.step is not used: a record has its own step; remove it",
        ),
        (
            RECORD,
            {"excitation.rate": [100, 200]},
            "excitation.rate is not used: excitation has time; vary excitation.time, or "
            "give rate instead",
        ),
        (
            RECORD,
            {"excitation.rms": [1, 2]},
            "unknown key `excitation.rms` in sweep; known in excitation of kind record are "
            "skip, rows.from, rows.to, rate, step, scale, gaps.at_most, resample.rate, "
            "resample.step, remove.below, remove.above, remove.order, window.from, window.to",
        ),
        (
            NOISE,
            {"friction.kinetic": [1, 2]},
            "unknown key `friction.kinetic` in sweep; this scenario has no friction block",
        ),
        (
            NOISE,
            {"excitation.seed": {"from": 1, "to": 2, "count": 3}},
            "sweep.excitation.seed.count gives 1.5, but excitation.seed takes whole numbers",
        ),
        (
            NOISE,
            {"excitation.seed": [1, 1.5]},
            "sweep.excitation.seed #2 must be a whole number, not 1.5",
        ),
        (
            SEAT,
            {"friction.normal_variation.amplitude": [0.1, 0.2]},
            "friction.normal_variation.amplitude needs its block: give "
            "friction.normal_variation with frequency",
        ),
        (
            SEAT,
            {"measure.duration": [1, 2]},
            "measure.duration is not used: metrics cover the steady state; set it in measure "
            "as well",
        ),
    ],
)
def test_key_that_the_scenario_has_no_use_for_is_refused(fault, text, sweep, sentence):
    assert fault(sweep, text) == [sentence]


@pytest.mark.parametrize("fault_of", ["kind: harmonics, ", ""])
def test_fault_of_a_block_is_not_retold_for_the_keys_swept_in_it(fault, fault_of):
    block = "excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}\n"
    text = SEAT.replace(block, block.replace("harmonic", "harmonics") if fault_of else "")
    assert len(fault({"excitation.frequency": [1, 2], "excitation.rms": [1, 2]}, text)) == 1


def test_reference_is_another_approach_beside_a_sweep(fault, scenario):
    sweep = {"excitation.rms": [1, 2]}
    assert scenario(SEAT, sweep, ["reference=viscous"]).reference == "viscous"
    assert fault(None, overrides=["reference=viscous"]) == ["reference requires a sweep"]
    assert fault(sweep, overrides=["reference=stick-slip"]) == [
        "reference must differ from solver.approach, stick-slip (--set reference=null)"
    ]
    assert fault(sweep, overrides=["reference=viscos"]) == [
        "reference: unknown approach `viscos`; did you mean `viscous`?"
    ]


# Cautions


@pytest.mark.parametrize(
    ("sweep", "part"),
    [
        ({"excitation.rms": [1]}, "has a single value"),
        ({"stroke.limit": ["1 cm", "2 cm"]}, "does not affect the motion"),
        ({"solver.smooth.sharpness": [1e2, 1e3]}, "the approach is stick-slip"),
        ({"solver.step": [1e-3, 2e-3]}, "is exact under sines at any step"),
        ({"friction.kinetic": [5, 0], "friction.static_ratio": [1, 2]}, "is 0 or not used"),
    ],
)
def test_swept_key_that_changes_nothing_is_said(scenario, sweep, part):
    (caution,) = scenario_warnings(scenario(SEAT, sweep))
    assert caution.slug == "sweep-changes-nothing"
    assert part in caution.sentence


def test_useful_sweep_deserves_no_warning(scenario):
    sweep = {"excitation.frequency": [1, 2], "friction.static_ratio": [1, 1.2]}
    assert scenario_warnings(scenario(SEAT, sweep, ["reference=viscous"])) == ()


def test_reference_that_leaves_more_out_than_friction_is_said(scenario):
    overrides = ["reference=signum", "friction.static=18"]
    (caution,) = scenario_warnings(scenario(SEAT, {"excitation.frequency": [1, 2]}, overrides))
    assert caution.sentence.startswith("reference: signum has no static limit above kinetic")


def test_approach_where_it_errs_is_said(scenario):
    signum = scenario(SEAT, None, ["solver.approach=signum", "friction.kinetic=45"])
    (caution,) = scenario_warnings(signum)
    assert caution.slug == "signum-chatters"
    assert "if the mass should always stick T_a tends to this number" in caution.sentence
    smooth = ["solver.approach=smooth", "solver.smooth={sharpness: 1e4, method: rk4}"]
    (caution,) = scenario_warnings(scenario(SEAT, None, smooth))
    assert caution.numbers == {"stiffness": pytest.approx(15 * 1e4 * 2.5e-3 / 75)}
    adaptive = [*smooth, "solver.smooth.method=adaptive"]
    assert scenario_warnings(scenario(SEAT, None, adaptive)) == ()


# Schema


def test_schema_knows_both_ways_to_say_the_values_of_an_axis():
    words = schema()
    sweep = words["properties"]["sweep"]
    listed, spread = next(iter(sweep["patternProperties"].values()))["anyOf"]
    assert listed["type"] == "array"
    assert set(spread["properties"]) == {"from", "to", "step", "count", "per_octave", "scale"}
    assert spread["required"] == ["from", "to"]
    assert "viscous" in words["properties"]["reference"]["enum"]
    assert json.dumps(words)


# The case at a point of a sweep, and the same scene under another approach.


WORDS = {
    "name": "seat",
    "oscillator": {"mass": 75, "stiffness": 7500, "damping_ratio": 0.25},
    "friction": {"law": "coulomb", "kinetic": 15, "static_ratio": 1.2},
    "stroke": {"limit": "25 mm"},
    "excitation": {"kind": "harmonic", "frequency": 1.6, "rms": 1.0},
    "solver": {"step": 2.5e-3},
}
POINTS_NOISE = {"kind": "psd", "points": [[0.5, 1], [10, 1]], "duration": 60, "seed": 1}


@pytest.fixture
def points_scenario(tmp_path):
    """Return the scenario of a text merged over that of the seat."""
    return partial(load_text, tmp_path, dump(WORDS))


def test_case_is_what_the_same_overrides_would_give(points_scenario):
    swept = {"excitation.frequency": [1, 5], "oscillator.mass": [75, 300]}
    point = {"excitation.frequency": 5.0, "oscillator.mass": 300.0}
    whole = points_scenario(sweep=swept, reference="viscous")
    case = whole.at(point)
    alone = points_scenario(excitation__frequency=5, oscillator__mass=300)
    assert case.resolved() == alone.resolved()
    assert case.oscillator.plant() == Plant(300.0, 7500.0, 0.25 * 2 * sqrt(7500 * 300))
    assert (case.sweep, case.reference) == ((), None)
    assert (case.origin, case.folder) == (whole.origin, whole.folder)


def test_stiffness_follows_mass_and_natural_frequency(points_scenario):
    oscillator = {"mass": 75, "natural_frequency": "3 rad/s", "damping_ratio": 0.25}
    swept = {"oscillator.mass": [75, 300], "oscillator.natural_frequency": [1.5, 2.5]}
    whole = points_scenario(oscillator=oscillator, sweep=swept)
    assert whole.oscillator.plant().k_x == pytest.approx(75 * 3**2, rel=1e-15)
    case = whole.at({"oscillator.mass": 300.0, "oscillator.natural_frequency": 2.5})
    k_x = 300.0 * (2 * pi * 2.5) ** 2
    m, stiffness, b = case.oscillator.plant()
    assert (m, case.resolved()["oscillator"]["natural_frequency"]) == (300.0, 2.5)
    assert (stiffness, b) == pytest.approx((k_x, 0.25 * 2 * sqrt(k_x * 300)), rel=1e-15)


def test_columns_of_natural_frequencies_give_the_stiffness_of_each_case(points_scenario):
    oscillator = {"mass": 75, "natural_frequency": 1.6, "damping_ratio": 0.25}
    whole = points_scenario(oscillator=oscillator)
    values = {"oscillator.natural_frequency": [0.1, 1.6, 7.3], "oscillator.mass": [0.3, 75, 9]}
    columns = {key: np.array(column, dtype=float) for key, column in values.items()}
    together = whole.with_values(columns).oscillator.plant()
    for i in range(3):
        point = {key: float(column[i]) for key, column in columns.items()}
        assert whole.at(point).oscillator.plant() == tuple(column[i] for column in together)


VARIED = WORDS["friction"] | {"normal_variation": {"amplitude": 0.2, "frequency": 1.6}}


@pytest.mark.parametrize(
    ("words", "key", "value", "field", "expected"),
    [
        ({}, "friction.kinetic", 30.0, lambda case: case.law(), CoulombLaw(30.0, 36.0)),
        ({}, "start.x_r", 0.01, lambda case: case.start.x_r, 0.01),
        ({}, "solver.smooth.sharpness", 20.0, lambda case: case.solver.smooth.sharpness, 20.0),
        ({"measure": {"duration": 5}}, "measure.duration", 2.0,
         lambda case: case.measure.duration, 2.0),
        ({"friction": VARIED, "measure": {"duration": "1 period"}},
         "friction.normal_variation.frequency", 0.4, lambda case: case.measure.duration, 2.5),
        ({"excitation": POINTS_NOISE}, "excitation.seed", float(np.float64(2)),
         lambda case: case.excitation.seed, 2),
    ],
)  # fmt: skip
def test_blocks_and_defaults_of_a_case_follow_its_value(
    points_scenario, words, key, value, field, expected
):
    case = points_scenario(words, sweep={key: [value / 2, value]}).at({key: value})
    assert field(case) == expected


def test_key_that_is_not_swept_may_be_set_as_well(points_scenario):
    assert points_scenario().at({"friction.kinetic": 30.0}).law() == CoulombLaw(30.0, 36.0)


def test_cases_share_the_blocks_that_do_not_differ(points_scenario):
    whole = points_scenario(sweep={"friction.kinetic": [1, 2], "excitation.rms": [1, 2]})
    one, other = (whole.at({"friction.kinetic": F, "excitation.rms": 2.0}) for F in (1.0, 2.0))
    assert one.excitation is other.excitation
    assert one.oscillator is whole.oscillator


@pytest.mark.parametrize("key", ["friction", "friction.kinetik", "oscillator.mass.x", "no.key"])
def test_key_that_is_no_number_is_refused(points_scenario, key):
    with pytest.raises(ScenarioError, match="1 error"):
        points_scenario().at({key: 30.0})


@pytest.mark.parametrize(
    ("words", "sweep", "sentence", "value"),
    [
        ({"friction": {"law": "coulomb", "kinetic": 15, "static": 30}},
         {"friction.kinetic": {"from": 0, "to": 40, "step": 10}},
         "friction.static must be at least the kinetic 40 N, not 30 N", 40),
        ({"solver.approach": "signum", "friction.static_ratio": 1},
         {"friction.static_ratio": [1, 1.2]},
         "signum does not support a static limit above kinetic", 1.2),
        ({"excitation": POINTS_NOISE}, {"excitation.points.1.0": [10, 1000]},
         "solver.step must be below 0.0005 s", 1000),
    ],
)  # fmt: skip
def test_every_point_is_tried_when_the_grid_is_small(
    points_scenario, words, sweep, sentence, value
):
    with pytest.raises(ScenarioError) as fault:
        points_scenario(words, sweep=sweep)
    (problem,) = fault.value.problems
    assert sentence in problem.sentence
    (key,) = sweep
    assert problem.sentence.endswith(f" (at {key} = {value:g})")


def test_point_of_a_large_grid_is_tried_when_it_is_met(points_scenario):
    many = {"from": 1, "to": 40, "count": 200}
    friction = {"law": "coulomb", "kinetic": 15, "static": 30}
    sweep = {"friction.kinetic": many, "friction.static": many}
    whole = points_scenario(friction=friction, sweep=sweep)
    with pytest.raises(ScenarioError) as fault:
        whole.at({"friction.kinetic": 20.0, "friction.static": 10.0})
    assert "(at friction.kinetic = 20, friction.static = 10)" in str(fault.value.problems)


# Another approach


@pytest.mark.parametrize("name", APPROACHES_BY_NAME)
def test_every_approach_can_take_the_scene(points_scenario, name):
    other = points_scenario(friction=VARIED).with_approach(name)
    assert other.solver.approach == name
    assert load_again(other).law() == other.law()


def load_again(scenario: Scenario) -> Scenario:
    """Return the scenario that a file with the words of another would be."""
    file = scenario.folder / "again.yaml"
    file.write_text(dump(scenario.resolved()))
    return load(file)


def test_approach_without_friction_drops_the_block_and_its_axes(points_scenario):
    sweep = {"friction.kinetic": [15, 45], "excitation.rms": [1, 2]}
    other = points_scenario(sweep=sweep, reference="viscous").with_approach("viscous")
    assert other.friction is None
    assert other.reference is None
    assert [axis.key for axis in other.sweep] == ["excitation.rms"]
    assert other.at({"excitation.rms": 2.0}).excitation.rms == 2.0


def test_approach_without_static_friction_takes_it_as_kinetic(points_scenario):
    sweep = {"friction.static_ratio": [1, 1.2], "friction.kinetic": [10, 20]}
    other = points_scenario(sweep=sweep).with_approach("signum")
    assert other.law() == CoulombLaw(15.0, 15.0)
    assert other.at({"friction.kinetic": 20.0}).law() == CoulombLaw(20.0, 20.0)
    assert [axis.key for axis in other.sweep] == ["friction.kinetic"]


def test_options_of_another_approach_are_not_swept(points_scenario):
    sweep = {"solver.smooth.sharpness": [10, 20], "excitation.rms": [1, 2]}
    whole = points_scenario(sweep=sweep)
    assert [axis.key for axis in whole.with_approach("smooth").sweep] == list(sweep)
    assert [axis.key for axis in whole.with_approach("moreau").sweep] == ["excitation.rms"]


def test_losses_name_the_approach_and_what_it_leaves_out(points_scenario):
    whole = points_scenario(friction=VARIED)
    assert whole.omissions("stick-slip") == ()
    assert whole.omissions("viscous") == ()  # it is without friction by definition
    assert whole.omissions("moreau") == (
        "moreau has no static limit above kinetic friction and uses F_fs = F_fk",
        "moreau uses a constant normal force",
    )
    sweep = {"friction.kinetic": [0, 20], "friction.static_ratio": [1, 1.2]}
    assert len(points_scenario(friction__kinetic=0, sweep=sweep).omissions("signum")) == 1


def test_approach_that_is_not_on_the_shelf_is_refused(points_scenario):
    with pytest.raises(ValueError, match="did you mean `signum`"):
        points_scenario().with_approach("signun")


def test_fractional_values_of_a_whole_number_in_a_zip_name_the_key(fault):
    half = {"from": 1, "to": 2, "step": 0.5}
    zipped = {"excitation.seed": half, "excitation.rms": [1, 2, 3]}
    (sentence,) = fault({"zip": zipped}, NOISE)
    assert sentence == (
        "sweep.zip.excitation.seed.step gives 1.5, but excitation.seed takes whole numbers"
    )


@pytest.mark.parametrize(
    "words",
    [
        {"from": 0.5, "to": 10, "count": 20_000},
        {"from": 0.1, "to": 1e4, "count": 20_001},
        {"from": 1 / 3, "to": 2e3, "count": 20_000},
        {"from": 1e-6, "to": 123456.789, "count": 10_007},
        {"from": 0.0003, "to": 7.2, "step": 1e-4},
        {"from": 0.1, "to": 100, "count": 20_000, "scale": "log"},
    ],
)
def test_columns_of_a_long_axis_are_its_values(scenario, words):
    """Of integers that doubles hold, and of those of 1/3, which they do not."""
    (axis,) = scenario(SEAT, {"excitation.frequency": words}).sweep
    values = axis.values
    numbers = np.random.default_rng(1).integers(len(values), size=3000)
    numbers[:3] = 0, len(values) - 1, len(values) - 2
    column = axis.take(numbers)
    assert column.dtype == float
    assert column.tolist() == [values[i] for i in numbers.tolist()]
