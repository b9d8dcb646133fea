"""`drysim validate`: what a file says of itself before anything is computed."""

from __future__ import annotations

import shutil

import pytest
from golden import GALLERY

from drysim.study.validate import validate


def test_scenario_to_fit_is_valid_without_values_of_its_free_keys():
    (note,) = validate(str(GALLERY / "fit-seat.yaml"))
    assert (note.severity, note.sentence) == (
        "note",
        "measured: x_dd, x_r, 8000 samples over 39.995 s",
    )


def test_fault_of_the_measurement_is_found_by_validating():
    (fault,) = validate(str(GALLERY / "fit-seat.yaml"), ["fit.measured.x_dd=seet"])
    assert fault.severity == "error"
    assert "seet" in fault.sentence


def test_key_without_a_start_is_found_by_validating():
    changes = ["friction.law=stribeck", "fit.free={friction.stribeck_velocity: {}}"]
    values = ["oscillator.stiffness=4500", "oscillator.damping=300", "friction.kinetic=32"]
    (fault,) = validate(
        str(GALLERY / "fit-seat.yaml"), [*changes, *values, "friction.static_ratio=1.3"]
    )
    assert fault.sentence.startswith("friction.stribeck_velocity needs a start")


@pytest.mark.parametrize("given", [("mu_static", "mu_kinetic"), ("mu_kinetic", "mu_static")])
def test_one_limit_of_friction_may_be_given_and_the_other_fitted(given, tmp_path):
    known, free = given
    words = (GALLERY / "fit-rig.yaml").read_text(encoding="utf-8")
    words = words.replace("static_ratio: 1.0 ", f"{known}: 0.2").replace(
        "friction.mu_kinetic: {}", f"friction.{free}: {{}}"
    )
    (tmp_path / "rig.yaml").write_text(words, encoding="utf-8")
    shutil.copy(GALLERY / "fit-rig-measured.csv", tmp_path)
    assert not [one for one in validate(str(tmp_path / "rig.yaml")) if one.severity == "error"]
