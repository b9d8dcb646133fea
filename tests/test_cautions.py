"""What a sound scenario deserves to be told about before anything is computed."""

from __future__ import annotations

import numpy as np
import pytest
from seat import dotted

import drysim
from drysim.core.model import Samples
from drysim.scenario.warnings import scenario_warnings

PLANT = {"mass": 75, "stiffness": 7500}
WORDS = {
    "oscillator": {**PLANT, "damping": 500},
    "friction": {"law": "coulomb", "kinetic": 15, "static": 18},
    "excitation": {"kind": "harmonic", "frequency": 1.6, "rms": 1.0},
    "solver": {"step": 2.5e-3},
    "stroke": {"limit": "25 mm"},
}


@pytest.fixture
def slugs():
    """Return the slugs and sentences of the warnings on a scenario with overrides."""

    def warned(motion=None, **keys: object) -> dict[str, str]:
        scenario = drysim.scenario(WORDS, dotted(keys))
        return {
            caution.slug: caution.sentence for caution in scenario_warnings(scenario, motion)
        }

    return warned


@pytest.mark.parametrize(
    ("words", "slug", "part"),
    [
        ({"stroke__limit": 25}, "looks-like-millimetres", "write `25 mm`"),
        ({"checks": ["x_r_peak < 25"]}, "looks-like-millimetres", "`x_r_peak < 25` is 25 m"),
        ({"stroke__limit": 20e6}, "looks-like-millimetres", "millimetres, write `20 mm`"),
        ({"start__x_r": 12}, "looks-like-millimetres", "start.x_r is 12 m"),
        ({"excitation__rms": 1000}, "looks-like-millimetres", "an amplitude of 14 m"),
        ({"oscillator__mass": 75000}, "looks-like-grams", "(`75000 g`)"),
        ({"oscillator__stiffness": 7.5}, "looks-like-grams", "(`7.5 N/mm`)"),
        ({"excitation__phase": 90}, "looks-like-degrees", "`90 deg`"),
        ({"oscillator": {**PLANT, "damping_ratio": 33.3}}, "looks-like-percent", "`33.3 %`"),
        ({"solver": {"step": 1e-3, "approach": "smooth", "smooth": {"sharpness": 1e5,
         "method": "rk4"}}, "friction__static": 15}, "smooth-stiff",
         "smooth with rk4 is unstable above about 2.8"),
        ({"solver__step": 0.05}, "coarse-step", "12.5 steps per period at 1.6 Hz; 0.031 s"),
    ],
)  # fmt: skip
def test_value_in_another_unit_or_too_coarse_is_said(slugs, words, slug, part):
    assert part in slugs(**words)[slug]


@pytest.mark.parametrize(
    ("key", "values", "slug", "part"),
    [
        ("stroke.limit", [0.02, 5, 10], "looks-like-millimetres", "stroke.limit is 10 m"),
        ("excitation.rms", [1, 1000], "looks-like-millimetres", "an amplitude of 14 m"),
        ("excitation.frequency", [1, 50, 25], "coarse-step", "8 steps per period at 50 Hz"),
        ("solver.step", [0.05, 1e-3], "coarse-step", "12.5 steps per period at 1.6 Hz"),
        ("oscillator.stiffness", [7.5, 7500], "looks-like-grams", "(`7.5 N/mm`)"),
    ],
)
def test_swept_value_in_another_unit_is_said_once(slugs, key, values, slug, part):
    assert part in slugs(sweep={key: values}, stroke__stops={"stiffness": 1e5})[slug]


def test_value_that_is_swept_is_not_held_against_the_file(slugs):
    """Of a swept key no case has the value of the file."""
    stopped = {"stroke__stops": {"stiffness": 1e5}, "stroke__limit": 25}
    assert slugs(sweep={"stroke.limit": ["20 mm", "30 mm"]}, **stopped) == {}
    assert slugs(sweep={"excitation.rms": [1, 2]}, excitation__rms=0.1) == {}
    assert slugs(sweep={"excitation.frequency": [1, 2]}, excitation__frequency=50) == {}


def test_damping_that_may_be_a_ratio_is_said(slugs):
    oscillator = {"mass": 85, "stiffness": 7500, "damping": 0.25}
    sentence = slugs(oscillator=oscillator)["looks-like-ratio"]
    assert sentence.startswith(
        "oscillator.damping 0.25 N·s/m hardly damps 85 kg, ξ is 0.00016;"
    )
    assert sentence.endswith("write `damping_ratio: 0.25`")
    assert "looks-like-ratio" not in slugs(oscillator=oscillator | {"mass": 1e-3})
    assert "looks-like-ratio" not in slugs(oscillator=oscillator | {"damping": 0})


def test_natural_frequency_far_above_that_of_a_mount_is_said(slugs):
    oscillator = {"mass": 85, "stiffness": 5.6e9, "damping": 500}
    sentence = slugs(oscillator=oscillator, solver__step=1e-5)["natural-frequency-high"]
    assert sentence.startswith(
        "the natural frequency is 1292 Hz, far above that of a mount for"
    )
    light = {"mass": 1e-3, "stiffness": 1e5, "damping": 0.1}
    assert "natural-frequency-high" not in slugs(oscillator=light, solver__step=1e-5)


OWN_UNITS = {
    "oscillator": {"mass": 1, "stiffness": 1, "damping": 0},
    "friction": {"law": "coulomb", "kinetic": 1, "static": 1},
    "start": {"x_r": 12, "v_r": 6},
    "excitation": {"kind": "rest"},
    "measure": {"duration": 25},
}
NOT_AT_HAND = {"excitation": {"kind": "record", "file": "no.csv"}, "solver": {}}


@pytest.mark.parametrize(
    "words",
    [{}, OWN_UNITS, NOT_AT_HAND, {"excitation__frequency": 0.05}],
    ids=["plausible", "units of its own", "record not at hand", "slow sine"],
)
def test_plausible_scenario_deserves_no_warning(slugs, words):
    assert slugs(**words) == {}


def test_mass_that_will_not_move_is_said(slugs):
    """The base pulls at the mass with √2·m·a_u = 53.03 N at most."""
    assert "will-not-move" in slugs(excitation__rms=0.5, friction__static=53.1)
    assert slugs(excitation__rms=0.5, friction__static=53) == {}
    for start in ({"x_r": 0.001}, {"v_r": 0.1}):  # outside the stuck zone
        assert slugs(excitation__rms=0.5, friction__static=53.1, start=start) == {}


def test_weakest_hold_of_a_varying_normal_force_counts(slugs):
    varied = {"amplitude": 0.4, "frequency": 1.6}
    held = {"law": "coulomb", "kinetic": 15, "static": 60, "normal_variation": varied}
    assert slugs(excitation__rms=0.5, friction=held) == {}
    assert "will-not-move" in slugs(excitation__rms=0.5, friction={**held, "static": 89})


def test_answer_that_hinges_on_a_static_limit_nobody_gave_is_said(slugs):
    """45 N at 0.50 m/s² creeps when F_fs = F_fk, and stands still from a ratio of 1.1785 up."""
    friction = {"law": "coulomb", "kinetic": 45}
    assert "1.179" in slugs(excitation__rms=0.5, friction=friction)["static-not-given"]
    assert slugs(excitation__rms=0.5, friction={**friction, "static_ratio": 1}) == {}
    assert slugs(excitation__rms=0.75, friction=friction) == {}


def test_static_limit_nobody_gave_is_held_against_the_weakest_hold(slugs):
    """A ratio is told from which the mass stays; it was one below 1 where F_N is near zero."""
    varied = {"amplitude": 0.4, "frequency": 1.6}
    friction = {"law": "coulomb", "kinetic": 75, "normal_variation": varied}
    assert "1.179" in slugs(excitation__rms=0.5, friction=friction)["static-not-given"]
    for amplitude in (0.9, 1.5):
        varied["amplitude"] = amplitude
        assert slugs(excitation__rms=0.5, friction=friction) == {}
    moving = {"law": "coulomb", "kinetic": 500}
    assert slugs(excitation__rms=0.5, friction=moving, start={"v_r": 0.1}) == {}


def test_samples_at_hand_tell_whether_the_mass_moves(slugs):
    motion = Samples(np.array([0.0, 0.2, -0.24, 0.0]), 0.01)
    assert "will-not-move" in slugs(motion)
    assert slugs(motion._replace(u_dd=motion.u_dd * 1.1)) == {}


def warned_of_record(folder, record, **keys):
    """Return the sentences of the warnings on a record, by their slugs."""
    (folder / "base.csv").write_text(record)
    base = {"kind": "record", "file": str(folder / "base.csv"), "column": "a", **keys}
    scenario = drysim.scenario({"oscillator": WORDS["oscillator"], "excitation": base})
    warnings = scenario_warnings(scenario, scenario.excitation.motion())
    return {warning.slug: warning.sentence for warning in warnings}


@pytest.mark.parametrize(("header", "said"), [("t", True), ("t [s]", True), ("t [ms]", False)])
def test_times_in_milliseconds_without_a_unit_make_a_record_that_is_too_coarse(
    tmp_path, header, said
):
    rows = "".join(f"{2 * k},{np.sin(0.02 * k):.6f}\n" for k in range(100))
    found = warned_of_record(tmp_path, f"{header},a [m/s2]\n{rows}", time="t")
    assert ("coarse-record" in found) is said
    if said:
        assert "a sample every 2 s, 0.314 per natural period" in found["coarse-record"]
        assert "unless their header has a unit, such as `t [ms]`" in found["coarse-record"]


def test_record_of_even_steps_is_not_told_about_units_of_time(tmp_path):
    (sentence,) = warned_of_record(tmp_path, "a [m/s2]\n1\n-1\n1\n", step=0.1).values()
    assert sentence.endswith("too few to resolve the excitation")


SWEPT = {"excitation.frequency": [1, 2, 3]}


@pytest.mark.parametrize(
    ("checks", "slug", "part"),
    [
        (["stuck_share < 80"], "check-cannot-fail", "if it is in percent, write `80 %`"),
        (["stuck_share <= 1"], "check-cannot-fail", "shares are between 0 and 1"),
        (["stuck_share > 1"], "check-cannot-hold", "shares are between 0 and 1"),
        (["T_a >= 0"], "check-cannot-fail", "T_a is never negative"),
        (["x_r_peak > -1 mm"], "check-cannot-fail", "x_r_peak is never negative"),
        (["T_a < 0"], "check-cannot-hold", "T_a is never negative"),
        (["T_a == -1"], "check-cannot-hold", "T_a is never negative"),
        (["SEAT < 60"], "check-cannot-hold", "give measure.direction or measure.weighting"),
        (["energy_stops < 2 J"], "check-cannot-hold", "without end stops; give stroke.stops"),
        (["stroke_used < 80"], "looks-like-percent", "write `80 %`"),
        (["x_r_peak < 25 km"], "implausible-length", "is 25000 m, over 1000 times the 0.021 m"),
        (["x_r_peak < 25 m"], "implausible-length", "is 25 m"),
        (["T_a < 1", "T_a > 1.2"], "checks-contradict", "`T_a < 1` and `T_a > 1.2`"),
        (["T_a < 1", "T_a >= 1"], "checks-contradict", "one must fail"),
        (["T_a == 1", "T_a == 2"], "checks-contradict", "one must fail"),
        (["x_r_peak < 25 mm", "x_r_peak < 0.025"], "check-twice", "is listed twice"),
    ],
)
def test_check_without_sense_is_said(slugs, checks, slug, part):
    assert part in slugs(checks=checks)[slug]
    others = {"looks-like-percent"} if "SEAT" in checks[0] else set()
    assert slugs(checks=checks).keys() - others == {slug}


def test_share_of_a_weighted_metric_may_be_meant_in_percent(slugs):
    found = slugs(checks=["SEAT < 60"], measure={"direction": "vertical"})
    assert [*found] == ["looks-like-percent"]
    assert "write `60 %`" in found["looks-like-percent"]


@pytest.mark.parametrize(
    "checks",
    [
        ["stuck_share < 80 %", "SEAT < 60 %", "x_r_peak < 25 mm", "x_r_peak > 0"],
        ["T_a <= 1", "T_a >= 1"],
        ["violations == 0", "stuck_share == 0", "stuck_share < 1", "energy_residual < 1e-9"],
        ["energy_friction > -1", "energy_stored < 0"],
    ],
)
def test_check_of_sense_is_left_alone(slugs, checks):
    assert slugs(checks=checks, measure={"direction": "vertical"}) == {}


@pytest.mark.parametrize(
    ("checks", "slug"),
    [(["T_a < 1 at excitation.frequency > 3"], "check-cannot-hold"),
     (["T_a < 1", "T_a > 2 at excitation.frequency == 3"], "checks-contradict"),
     (["T_a < 1 at excitation.frequency >= 2", "T_a > 2 at excitation.frequency <= 2"],
      "checks-contradict"),
     (["T_a < 1 at status == ok", "T_a > 1.2"], "checks-contradict"),
     (["T_a < 1 at excitation.frequency > 2", "T_a > 2 at excitation.frequency <= 2"], ""),
     (["T_a < 1 at excitation.frequency > 2", "T_a < 1 at excitation.frequency < 2"], ""),
     (["T_a < 1", "T_a < 1 at excitation.frequency == 2"], "")],
)  # fmt: skip
def test_checks_are_held_against_each_other_where_both_apply(slugs, checks, slug):
    assert [*slugs(checks=checks, sweep=SWEPT)] == [slug] * bool(slug)


def test_sweep_of_the_phase_of_a_steady_orbit_is_said(slugs):
    phases = {"excitation.phase": [0, 1, 2]}
    assert "has no effect" in slugs(sweep=phases)["sweep-changes-nothing"]
    assert slugs(sweep=phases, measure={"duration": 5}) == {}
    varied = {"amplitude": 0.4, "frequency": 1.6}
    friction = {"law": "coulomb", "kinetic": 15, "static": 18, "normal_variation": varied}
    assert slugs(sweep=phases, friction=friction) == {}


def test_ratio_of_a_force_of_zero_is_said(slugs):
    ratio = {"law": "coulomb", "kinetic": 0, "static_ratio": 1.2}
    assert "friction.kinetic is 0" in slugs(friction=ratio)["no-effect"]
    assert slugs(friction={**ratio, "static_ratio": 1}) == {}
    assert slugs(friction=ratio, sweep={"friction.kinetic": [0, 15]}) == {}
    assert slugs(friction={"law": "coulomb", "kinetic": 0, "static": 5}) == {}


@pytest.mark.parametrize(("half_width", "said"), [(3, True), (1, True), (0.5, False)])
def test_interval_in_percent_is_said(slugs, half_width, said):
    noise = {"kind": "psd", "points": [[1, 1], [10, 1]], "duration": 10}
    until = {"metric": "T_a", "half_width": half_width}
    found = slugs(excitation={**noise, "until": until})
    assert ("looks-like-percent" in found) == said


def test_options_of_an_approach_that_does_not_run_are_said(slugs):
    solver = {"step": 2.5e-3, "smooth": {"form": "erf"}}
    assert "the approach is stick-slip" in slugs(solver=solver)["no-effect"]
    assert slugs(solver=solver, sweep=SWEPT, reference="smooth", friction__static=15) == {}
    assert slugs(solver={**solver, "approach": "smooth"}, friction__static=15) == {}


def slugs_of(scenario, **options):
    """Return the slugs of the warnings on a scenario."""
    return [warning.slug for warning in scenario_warnings(scenario, **options)]


def test_options_of_an_approach_are_left_alone_where_it_may_run():
    """In a comparison, and where the command line chooses another approach than the file."""
    friction = {"law": "coulomb", "kinetic": 9}
    smooth = {"approach": "smooth", "step": 2.5e-3, "smooth": {"form": "erf"}}
    file = WORDS | {"solver": smooth, "friction": friction}
    chosen = ["solver.approach=stick-slip"]
    assert slugs_of(drysim.scenario(file, ["solver.approach=viscous", "friction=null"])) == []
    assert slugs_of(drysim.scenario(file, chosen)) == []
    chosen = drysim.scenario(file, [*chosen, "solver.smooth.form=tanh"])
    assert slugs_of(chosen) == ["no-effect"]
    assert slugs_of(chosen, compared=True) == []
    exact = drysim.scenario(file | {"solver": smooth | {"approach": "stick-slip"}})
    assert slugs_of(exact) == ["no-effect"]
    table = drysim.compare(exact, "smooth vs stick-slip").table
    assert "no-effect" not in [warning.slug for warning in table.warnings]


def test_option_that_stands_for_a_key_of_the_same_law_is_said():
    friction = {
        "law": "coulomb", "kinetic": 15, "coulomb": {"kinetic": 30},
        "dahl": {"kinetic": 9, "bristle_stiffness": 1e5},
    }  # fmt: skip
    file = WORDS | {"friction": friction}
    (caution,) = scenario_warnings(drysim.scenario(file))
    sentence = "friction.kinetic has no effect: friction.coulomb.kinetic replaces it"
    assert caution.sentence == sentence
    assert slugs_of(drysim.scenario(file, ["friction.law=dahl"])) == []
    assert slugs_of(drysim.scenario(file, ["friction.kinetic=null"])) == []


def test_record_that_is_missing_in_options_of_another_law_is_said(slugs):
    record = {"file": "nope.csv", "column": 1, "unit": "N", "rate": 100}
    pressed = {"mu_kinetic": 0.1, "normal_record": record}
    friction = {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e5, "coulomb": pressed}
    assert "the record does not exist" in slugs(friction=friction)["unread-record"]


def test_force_of_zero_from_outside_is_no_slip():
    """It takes the friction of a file away for once, and its ratio with it."""
    file = WORDS | {"friction": {"law": "coulomb", "kinetic": 9, "static_ratio": 2}}
    assert slugs_of(drysim.scenario(file, ["friction.kinetic=0"])) == []
    both = ["friction.kinetic=0", "friction.static_ratio=3"]
    assert slugs_of(drysim.scenario(file, both)) == ["no-effect"]


def drawn_base(rng, frequency):
    """Return a shock of drawn length, or a sine near or at this natural frequency."""
    width = float(10.0 ** rng.uniform(-2.0, 0.5) / frequency)
    shock = {"kind": "shock", "pulse": "half-sine", "amplitude": 5.0, "duration": width}
    near = {"kind": "harmonic", "rms": 1.0, "frequency": frequency * rng.uniform(0.5, 1.5)}
    return [shock, near, near | {"frequency": frequency}][rng.integers(3)]


@pytest.mark.parametrize("seed", range(12))
def test_the_travel_that_is_expected_is_not_exceeded(seed):
    rng = np.random.default_rng([41, seed])
    frequency = float(10.0 ** rng.uniform(0.0, 2.0))
    base = drawn_base(rng, frequency)
    damping = float(10.0 ** rng.uniform(-3.0, 0.3))
    step = base.get("duration", 0.1 / frequency) / 100
    words = {
        "oscillator": {"mass": 5, "natural_frequency": frequency, "damping_ratio": damping},
        "excitation": base,
        "solver": {"step": step},
        "checks": ["x_r_peak < 1e6 km"],
        "measure": {"duration": step * 200} if base["kind"] == "shock" else {},
    }
    outcome = drysim.run(drysim.scenario(words))
    [warning] = [each for each in outcome.warnings if each.slug == "implausible-length"]
    expected = float(warning.sentence.split(" m expected")[0].split()[-1])
    assert outcome.metrics["x_r_peak"] <= 1.05 * expected  # two digits


def test_a_limit_that_one_case_of_a_sweep_may_reach_is_plausible():
    words = {
        "oscillator": {"mass": 1, "natural_frequency": 10, "damping_ratio": 0.05},
        "excitation": {
            "kind": "shock", "pulse": "half-sine", "amplitude": 98.0, "duration": 0.011,
        },
        "solver": {"step": 1e-4},
        "measure": {"duration": 0.02},
        "sweep": {"srs": [2, 20, 160]},
    }  # fmt: skip
    for limit, is_said in (("1000 mm", False), ("1000 m", True)):
        table = drysim.sweep(drysim.scenario(words, {"checks": [f"x_r_peak < {limit}"]}))
        slugs = [warning.slug for warning in table.warnings]
        assert ("implausible-length" in slugs) is is_said
