"""The sketch of the model has the elements of the scene, with their values."""

from __future__ import annotations

import pytest
from seat import SEAT

from drysim.plots import sketch


def words(figure):
    return " ".join(text.get_text().replace("\n", " ") for text in figure.axes[0].texts)


def test_sketch_without_a_scenario_has_symbols_only():
    assert words(sketch.draw()) == (
        "mass m moving base kₓ b friction F_fk, F_fs x(t) u(t) stroke xᵣ = x − u"
    )


@pytest.mark.parametrize(
    ("overrides", "there", "absent"),
    [
        ({}, ["kₓ 7500 N/m", "b 500 N·s/m", "F_fk 15 N", "moving base"], ["stops"]),
        ({"friction": None}, ["kₓ", "b"], ["friction"]),
        (
            {"oscillator": {"mass": 2, "stiffness": 5, "damping": 0}},
            ["m 2 kg"],
            ["b 0", "N·s/m"],
        ),
        ({"excitation": {"kind": "rest"}, "start.x_r": 0.1}, ["base at rest"], ["u(t)"]),
        ({"stroke": {"limit": "25 mm"}}, ["limit 25 mm"], ["stops"]),
        (
            {"stroke": {"limit": "25 mm", "stops": {"restitution": 0.5}}},
            ["rigid stops 25 mm"],
            ["limit"],
        ),
    ],
    ids=["all", "no friction", "no damper", "rest", "limit", "stops"],
)
def test_sketch_has_what_the_scene_has(scenario, overrides, there, absent):
    shown = words(sketch.draw(scenario(SEAT, overrides)))
    assert [word for word in there if word not in shown] == []
    assert [word for word in absent if word in shown] == []


def test_values_that_vary_are_left_out(scenario):
    varied = ["oscillator.mass", "oscillator.damping_ratio", "friction.kinetic"]
    shown = words(sketch.draw(scenario(SEAT), varied))
    assert "mass m varied" in shown
    assert "b varied" in shown
    assert "friction varied" in shown
    assert "kₓ 7500 N/m" in shown


@pytest.mark.parametrize("key", ["natural_frequency", "mass"])
def test_spring_and_damper_vary_with_what_they_follow_from(scenario, key):
    oscillator = {"mass": 2, "natural_frequency": 3, "damping_ratio": 0.2}
    study = scenario(SEAT, {"oscillator": oscillator})
    shown = words(sketch.draw(study, [f"oscillator.{key}"]))
    assert "kₓ varied" in shown
    assert "b varied" in shown
    assert ("mass m varied" in shown) is (key == "mass")
