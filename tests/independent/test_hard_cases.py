"""The hard cases of the gallery: each keeps what is known about its answer."""

from __future__ import annotations

from pathlib import Path

import pytest

import drysim
from drysim.study.sweep import sweep

HARD = Path(__file__).parents[2] / "scenarios" / "hard"
CASES = sorted(HARD.glob("*.yaml"))
SWEEPS = [file for file in CASES if drysim.load(file).sweep]


def slugs(name):
    """Return the warnings of a hard case."""
    return {caution.slug for caution in drysim.run(drysim.load(HARD / name)).warnings}


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.stem)
def test_hard_case_keeps_what_is_known_about_it(file):
    outcome = drysim.run(drysim.load(file))
    assert outcome.checks
    assert [check.sentence for check in outcome.checks if check.passed is False] == []


@pytest.mark.parametrize("file", SWEEPS, ids=lambda file: file.stem)
def test_every_case_of_a_hard_sweep_keeps_what_is_known_about_it(file):
    checks = sweep(drysim.load(file)).checks
    assert checks
    assert [check.sentence for check in checks if not check.passed] == []


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.stem)
def test_hard_case_is_named_after_its_file_and_says_what_is_hard(file):
    scenario = drysim.load(file)
    assert scenario.name == file.stem
    assert scenario.about.endswith(".")
    assert file.read_text().startswith(
        "# yaml-language-server: $schema=../scenario.schema.json\n"
    )


@pytest.mark.parametrize(
    ("name", "slug"),
    [
        ("continuum-of-orbits-half.yaml", "not-unique"),
        ("continuum-of-orbits-quarter.yaml", "not-unique"),
        ("edge-of-the-stuck-zone.yaml", "close-decision"),
        ("limit-just-exceeded.yaml", "close-decision"),
        ("sticks-of-no-length.yaml", "close-decision"),
        ("never-moves.yaml", "will-not-move"),
    ],
)
def test_hard_case_says_what_its_reader_should_know(name, slug):
    assert slug in slugs(name)


def test_gravity_left_in_the_record_is_refused_unless_it_is_kept():
    file = HARD / "gravity-left-in-the-record.yaml"
    left = drysim.load(file, {"excitation.gravity": "refuse"})
    with pytest.raises(drysim.RecordError, match="remove it with `remove: mean`"):
        drysim.run(left)
    assert slugs(file.name) == set()


def test_hardly_damped_orbit_is_unique_and_resonance_is_not_called_settled():
    assert "not-unique" not in slugs("hardly-damped-orbit.yaml")
    growing = drysim.load(
        HARD / "resonance-that-grows.yaml", {"measure": {"steady": True}, "start.x_r": 0.0}
    )
    assert "not-settled" in {caution.slug for caution in drysim.run(growing).warnings}


def test_two_turns_within_one_step_are_where_the_parabola_says():
    events = drysim.run(drysim.load(HARD / "two-turns-in-one-step.yaml")).events
    assert events.t[1:3] == pytest.approx([0.2, 23 / 30], rel=1e-14)
    assert events.x_r[1] == pytest.approx(0.46, rel=1e-14)


def test_tiny_and_huge_motion_are_one_motion_scaled():
    tiny, huge = (
        drysim.run(drysim.load(HARD / f"{word}-motion.yaml")) for word in ("tiny", "huge")
    )
    assert (tiny.events.kind == huge.events.kind).all()
    assert tiny.events.t == pytest.approx(huge.events.t, rel=1e-12)
    assert tiny.response.x_r * 1e24 == pytest.approx(huge.response.x_r, rel=1e-9, abs=1e-3)
