"""Stroke limits that differ between the sides, and an offset of the working point."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from law_scenes import PAPER, REST, mirrored, noise, sine

import drysim
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, EndStops, PiecewiseLaw, StrokeLimits
from drysim.errors import ScenarioError
from drysim.metrics.table import measure

LAWS = {
    "coulomb": CoulombLaw(15.0, 18.0),
    "elastic": PiecewiseLaw(15.0, 15.0, 5e4),
    "varying load": PiecewiseLaw(15.0, 15.0, 5e4, 0.6, 14.0, 0.3),
    "by direction": PiecewiseLaw(30.0, 36.0, compression=(15.0, 18.0)),
}
MOTIONS = {"sine": sine(1.0, 1.6), "noise": noise(1200, 1.2, seed=3)}
END = 2.9
LIMITS = StrokeLimits(0.004, 0.007)
SIDES = {
    "x_r_max": "x_r_min",
    "violations_up": "violations_down",
    "stroke_once_an_hour_up": "stroke_once_an_hour_down",
    "contacts_up": "contacts_down",
}

SCENARIO = {
    "drysim": 1,
    "name": "sides",
    "oscillator": {"mass": 75, "stiffness": 7500, "damping": 500},
    "friction": {"kinetic": 15, "static_ratio": 1.2},
    "excitation": {"kind": "harmonic", "frequency": 1.6, "rms": 1.0},
    "solver": {"step": 2.5e-3},
}
STOPS = {
    "without stops": {},
    "bumpers": {"stops": {"stiffness": 2e5, "damping": 300}},
    "rigid stops": {"stops": {"restitution": 0.4}},
}


def trajectory_of(law, motion):
    return StickSlip().trajectory(PAPER, law, motion, REST, END)


def scenario(stroke, **blocks):
    """Return the scenario with a stroke block and other blocks."""
    blocks = {**SCENARIO, "stroke": stroke, **blocks}
    return drysim.scenario({key: block for key, block in blocks.items() if block})


def exchanged(values):
    """Return metrics with those of the sides exchanged, without the rate of up-crossings."""
    other = SIDES | {down: up for up, down in SIDES.items()}
    found = {name: values[other.get(name, name)] for name in values if name != "crossing_rate"}
    return found | {name: -found[name] for name in ("x_r_max", "x_r_min")}


@pytest.mark.parametrize(("law", "motion"), [*itertools.product(LAWS, MOTIONS)])
def test_excursions_are_those_of_a_fine_grid(law, motion):
    trajectory = trajectory_of(LAWS[law], MOTIONS[motion])
    values = measure(trajectory, (0.0, END), LIMITS)
    t = np.linspace(0.0, END, 20_001)
    x_r = np.array([trajectory.state(at).x_r for at in t.tolist()])
    assert values["x_r_max"] == pytest.approx(x_r.max(), rel=1e-5)
    assert values["x_r_min"] == pytest.approx(x_r.min(), rel=1e-5)
    assert values["stroke_used"] == max(values["x_r_max"] / 0.004, -values["x_r_min"] / 0.007)
    counts, inside = {"up": x_r >= LIMITS.up, "down": x_r <= -LIMITS.down}, 0.0
    for side, beyond in counts.items():
        entries = int(beyond[0]) + np.count_nonzero(beyond[1:] & ~beyond[:-1])
        assert values[f"violations_{side}"] == entries
        inside += END * np.mean(beyond)
    assert values["violations"] == values["violations_up"] + values["violations_down"] > 0
    assert values["t_beyond"] == pytest.approx(inside, abs=2e-4 * values["violations"])
    first = t[np.argmax(counts["up"] | counts["down"])]
    assert values["t_first_violation"] == pytest.approx(first, abs=END / 10_000)


@pytest.mark.parametrize(("law", "motion"), [*itertools.product(LAWS, MOTIONS)])
def test_mirrored_motion_exchanges_the_sides_exactly(law, motion):
    mirror = LAWS[law]
    if law == "by direction":
        mirror = PiecewiseLaw(15.0, 18.0, compression=(30.0, 36.0))
    here = measure(trajectory_of(LAWS[law], MOTIONS[motion]), (0.4, END), LIMITS)
    there = trajectory_of(mirror, mirrored(MOTIONS[motion]))
    found = exchanged(measure(there, (0.4, END), StrokeLimits(0.007, 0.004)))
    # Integrals under samples are matrix products, whose rounding depends on the processor.
    integrals = [name for name in found if name.startswith("energy") or name.endswith("_rms")]
    for name in filter(here.get, integrals):
        assert found.pop(name) == pytest.approx(here.pop(name), rel=1e-12, abs=1e-12)
    assert found == {name: value for name, value in here.items() if name != "crossing_rate"}


@pytest.mark.parametrize("stops", STOPS.values(), ids=STOPS)
def test_mirrored_scene_with_exchanged_stops_is_the_mirrored_motion_exactly(stops):
    sides = {"up": 0.004, "down": 0.007}
    harmonic = SCENARIO["excitation"]
    here = drysim.run(scenario({"limit": sides, **stops}))
    exchanged_sides = {"limit": {"up": 0.007, "down": 0.004}, **stops}
    there = drysim.run(scenario(exchanged_sides, excitation={**harmonic, "phase": np.pi}))
    apart = ("closure", "energy_input", "energy_stored", "energy_residual", "energy_stops")
    # sin(x + pi) is not -sin(x) to the last digit.
    for name, value in exchanged(there.metrics).items():
        if name not in apart and value is not None:
            assert value == pytest.approx(here.metrics[name], rel=1e-9), name


@pytest.mark.parametrize("stops", STOPS.values(), ids=STOPS)
def test_equal_limits_by_side_are_one_limit(stops):
    one = drysim.run(scenario({"limit": 0.005, **stops}))
    two = drysim.run(scenario({"limit": {"up": 0.005, "down": 0.005}, **stops}))
    none = drysim.run(scenario({"limit": 0.005, "offset": 0, **stops}))
    assert one.metrics == two.metrics == none.metrics
    assert one.response.x_r.tobytes() == two.response.x_r.tobytes()


@pytest.mark.parametrize("stops", STOPS.values(), ids=STOPS)
def test_offset_brings_one_side_nearer_and_the_other_farther(stops):
    near = drysim.run(scenario({"limit": 0.005, "offset": 0.002, **stops}))
    sides = drysim.run(scenario({"limit": {"up": 0.003, "down": 0.007}, **stops}))
    assert near.metrics == sides.metrics
    more = scenario({"limit": {"up": 0.004, "down": 0.006}, "offset": 0.001, **stops})
    assert drysim.run(more).metrics == sides.metrics
    assert near.metrics["violations_up"] >= 1


def test_start_counts_from_the_working_point():
    still = {"excitation": {"kind": "rest"}, "measure": {"duration": 1}}
    begin = {"start": {"x_r": 0.004}}
    found = drysim.run(scenario({"limit": 0.005, "offset": 0.002}, **still, **begin))
    assert found.response.x_r[0] == 0.004
    assert found.metrics["violations_up"] == 1
    assert found.metrics["t_first_violation"] == 0.0


def test_sides_are_left_when_the_displacement_is_back_at_the_limit():
    still = {"excitation": {"kind": "rest"}, "measure": {"duration": 1}, "friction": None}
    limit = {"up": 0.02, "down": 0.004}
    found = drysim.run(scenario({"limit": limit}, start={"x_r": -0.012}, **still))
    # A damped free oscillation, in closed form, is back at the limit then.
    decay, w, t = 500 / 150, np.sqrt(100 - (500 / 150) ** 2), found.metrics["t_beyond"]
    x_r = -0.012 * np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    assert x_r == pytest.approx(-0.004, rel=1e-12)
    assert t < np.pi / w
    assert found.metrics["violations_down"] == found.metrics["violations"] == 1


@pytest.mark.parametrize("stops", STOPS.values(), ids=STOPS)
def test_sweep_of_the_offset_gives_what_single_runs_give(stops):
    offsets = [-0.003, 0.0, 0.002]
    swept = scenario({"limit": 0.005, **stops}, sweep={"stroke.offset": offsets})
    table = drysim.sweep(swept)
    assert len(table.rows) == 3
    for row, offset in zip(table.rows, offsets, strict=True):
        alone = drysim.run(scenario({"limit": 0.005, "offset": offset, **stops})).metrics
        for name, value in alone.items():
            if name.startswith(("x_r", "violations", "contacts", "t_", "stroke")):
                same = value if value is None else pytest.approx(value, rel=1e-9, abs=1e-12)
                assert row.metrics[name] == same, name


def test_worst_case_is_the_one_that_exceeds_the_limit_of_its_side_by_most():
    swept = scenario({"limit": 0.005}, sweep={"stroke.offset": [-0.001, 0.003, 0.001]})
    (warning,) = (one for one in drysim.sweep(swept).warnings if one.slug == "stroke-violated")
    assert "at offset 3 mm" in warning.sentence
    assert warning.numbers["limit_up"] == pytest.approx(0.002)


def test_worst_case_exceeds_its_own_limit_by_most_in_metres():
    zipped = {"zip": {"stroke.limit": [0.001, 0.010], "excitation.rms": [1.0, 2.5]}}
    table = drysim.sweep(scenario({"limit": 0.01}, sweep=zipped))
    (tally,) = table.tallies.values()
    excess = [row.metrics["x_r_peak"] - row.point["stroke.limit"] for row in table.rows]
    used = [row.metrics["stroke_used"] for row in table.rows]
    assert excess[1] > excess[0] > 0.0
    assert used[0] > used[1]
    assert tally.worst.point["stroke.limit"] == 0.010


def test_motion_on_one_side_does_not_use_the_other():
    still = {"excitation": {"kind": "rest"}, "measure": {"duration": 0.01}}
    found = drysim.run(scenario({"limit": 0.02}, start={"x_r": 0.01}, **still)).metrics
    assert found["x_r_max"] == 0.01
    assert found["x_r_min"] == 0.0
    assert str(found["stroke_used"]) == "0.5"


def test_warning_names_the_side_that_is_exceeded_most():
    found = drysim.run(scenario({"limit": {"up": 0.1, "down": 0.002}}))
    (warning,) = (one for one in found.warnings if one.slug == "stroke-violated")
    low = found.metrics["x_r_min"]
    assert "100 mm up and 2 mm down is exceeded once (0 up, 1 down)" in warning.sentence
    assert f"x_r reaches {1e3 * low:.4g} mm, {1e3 * (-low - 0.002):.4g} mm" in warning.sentence
    assert warning.numbers["limit_up"] == 0.1


def test_negative_limit_of_a_check_on_one_side_is_meant():
    checks = ["x_r_min > -8 mm", "x_r_max < 8 mm", "violations_down < 1"]
    found = drysim.run(scenario({"limit": {"up": 0.004, "down": 0.02}}, checks=checks))
    assert [verdict.passed for verdict in found.checks] == [
        found.metrics["x_r_min"] > -0.008,
        found.metrics["x_r_max"] < 0.008,
        True,
    ]
    assert not [one.slug for one in found.warnings if one.slug.startswith("check")]


def test_contacts_are_told_apart():
    values = drysim.run(
        scenario({"limit": {"up": 0.003, "down": 0.05}, "stops": {"stiffness": 2e5}})
    ).metrics
    assert values["contacts"] == values["contacts_up"] > 0
    assert values["contacts_down"] == 0
    law = PiecewiseLaw(15.0, 18.0, stops=EndStops(StrokeLimits(0.003, 0.05), ((0.0, 2e5),)))
    trajectory = trajectory_of(law, MOTIONS["noise"])
    hits = trajectory.hits()[1]
    values = measure(trajectory, (0.0, END), law.stops.limits)
    assert values["contacts_up"] == np.count_nonzero(hits > 0)


@pytest.mark.parametrize(
    ("stroke", "words"),
    [
        ({"limit": 0.005, "offset": 0.005}, "must be above -0.005 m and below 0.005 m"),
        (
            {"limit": {"up": 0.01, "down": 0.02}, "offset": -0.03},
            "must be above -0.02 m and below 0.01 m",
        ),
        ({"limit": {"up": 0.0, "down": 0.02}}, "stroke.limit.up must be above 0"),
        ({"limit": {"up": 0.01}}, "stroke.limit.down is required"),
        ({"offset": 0.01}, "stroke.limit is required"),
    ],
)
def test_stroke_without_room_is_refused(stroke, words):
    with pytest.raises(ScenarioError) as caught:
        scenario(stroke)
    assert words in str(caught.value.problems[0])


def test_offset_that_leaves_no_room_in_one_case_of_a_sweep_is_refused():
    swept = {"stroke.offset": [0.0, 0.004, 0.006]}
    with pytest.raises(ScenarioError) as caught:
        scenario({"limit": 0.005}, sweep=swept)
    sentence = (
        "stroke.offset must be above -0.005 m and below 0.005 m, the limits of the stroke"
    )
    assert sentence in str(caught.value.problems[0])
    assert "(at stroke.offset = 0.006)" in str(caught.value.problems[0])


def test_start_beyond_the_nearer_rigid_stop_is_refused():
    stroke = {"limit": 0.005, "offset": 0.003, "stops": {"restitution": 0.5}}
    with pytest.raises(ScenarioError) as caught:
        scenario(stroke, start={"x_r": 0.003})
    assert "must be between -0.008 and 0.002 m with rigid stops" in str(
        caught.value.problems[0]
    )


@pytest.mark.parametrize(
    ("stroke", "key", "typed"),
    [
        ({"limit": 40.0, "offset": 5.0}, "stroke.limit", "40"),
        ({"limit": {"up": 0.04, "down": 50.0}, "offset": -5.0}, "stroke.limit.down", "50"),
        ({"limit": {"up": 30.0, "down": 0.05}, "offset": 7.0}, "stroke.limit.up", "30"),
    ],
)
def test_limit_that_looks_like_millimetres_is_shown_as_typed(stroke, key, typed):
    (warning,) = drysim.scenario.scenario_warnings(scenario(stroke))
    assert warning.slug == "looks-like-millimetres"
    assert warning.sentence.startswith(f"{key} is {typed} m; ")
    assert warning.sentence.endswith(f"write `{typed} mm`")
    assert warning.numbers == {key: float(typed)}


def test_limits_of_both_sides_that_look_like_millimetres_are_both_named():
    limits = {"up": 30.0, "down": 50.0}
    found = drysim.scenario.scenario_warnings(scenario({"limit": limits}))
    assert [[*one.numbers] for one in found] == [["stroke.limit.up"], ["stroke.limit.down"]]
