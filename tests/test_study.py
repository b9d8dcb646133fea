"""Studies: from a scenario to an outcome, and what is said about it."""

from __future__ import annotations

import math
from dataclasses import replace
from io import FileIO
from pathlib import Path

import pytest
from seat import dotted

import drysim
from drysim import system
from drysim.errors import WarningMessage
from drysim.study import budget, gallery
from drysim.study.validate import validate
from drysim.study.warnings import response_warnings


def outcome_of(seat, **overrides):
    """Run the seat with overrides."""
    return drysim.run(drysim.load(seat, dotted(overrides)))


def slugs(outcome):
    """Return the slugs of the warnings."""
    return [warning.slug for warning in outcome.warnings]


def test_outcome_holds_response_metrics_checks_and_events(seat):
    outcome = outcome_of(seat, checks=["T_a < 2", "T_a < 0.1"])
    assert len(outcome.response.t) == 801
    assert outcome.events is outcome.response.events
    assert outcome.metrics["T_a"] > 1
    assert [verdict.passed for verdict in outcome.checks] == [True, False]
    assert outcome.warnings == ()


def test_exit_code_is_1_for_a_failed_check_and_under_strict_for_a_warning(seat):
    sound = outcome_of(seat, checks=["T_a < 2"])
    failed = outcome_of(seat, checks=["T_a < 0.1"])
    warned = replace(sound, warnings=(WarningMessage("planted", "A planted warning."),))
    assert [one.exit_code() for one in (sound, failed, warned)] == [0, 1, 0]
    assert [one.exit_code(strict=True) for one in (sound, failed, warned)] == [0, 1, 1]


def test_steady_motion_without_friction_is_the_closed_form(seat):
    outcome = outcome_of(seat, friction=None, measure={"steady": True})
    r, xi = 2 * math.pi * 1.6 / 10, 500 / (2 * 75 * 10)
    expected = math.sqrt((1 + (2 * xi * r) ** 2) / ((1 - r * r) ** 2 + (2 * xi * r) ** 2))
    assert outcome.metrics["T_a"] == pytest.approx(expected, rel=1e-12)
    assert outcome.metrics["closure"] < 1e-10
    assert slugs(outcome) == []


def test_steady_response_is_one_repetition_that_says_how_well_it_closes(seat):
    outcome = outcome_of(seat, measure={"steady": True})
    numerics = outcome.response.numerics
    assert numerics.period_multiple == 1
    assert numerics.closure == outcome.metrics["closure"] < 1e-9
    assert outcome.response.t[-1] == pytest.approx(1 / 1.6)


def test_mass_below_the_static_limit_stands_still(seat):
    outcome = outcome_of(seat, friction__kinetic=75 * 2**0.5 + 1, measure={"steady": True})
    metrics = outcome.metrics
    assert (metrics["x_r_peak"], metrics["T_x"], metrics["stuck_share"]) == (0, 0, 1)
    assert metrics["T_a"] == 1.0
    assert slugs(outcome) == ["will-not-move"]


def test_stroke_violation_in_the_window_is_a_warning_with_its_numbers(seat):
    outcome = outcome_of(seat, stroke__limit="5 mm")
    (warning,) = outcome.warnings
    assert warning.slug == "stroke-violated"
    assert "5 mm" in warning.sentence
    assert warning.numbers["x_r_peak"] == outcome.metrics["x_r_peak"] > 0.005
    assert outcome.exit_code() == 0


def test_stroke_violation_before_the_window_is_a_warning_with_the_peak_of_that_time(seat):
    words = {"start__x_r": 0.03, "stroke__limit": 0.025, "measure__settle": 5}
    outcome = outcome_of(seat, **words)
    (warning,) = outcome.warnings
    assert warning.slug == "stroke-violated"
    assert warning.numbers["x_r_peak"] == 0.03
    assert outcome.metrics["x_r_peak"] < 0.025


def test_stroke_violation_on_the_way_to_the_orbit_is_a_warning(seat):
    words = {"start__x_r": 0.03, "stroke__limit": 0.025, "measure": {"steady": True}}
    outcome = outcome_of(seat, **words)
    assert outcome.metrics["violations"] == 0
    assert slugs(outcome) == ["stroke-violated-settling"]


def test_motion_that_never_settles_is_said_to_be_so(seat):
    words = {"friction": None, "oscillator__damping": 0, "measure": {"steady": True}}
    checks = ["T_a < 1e9", "closure < 1", "T_a < 1 at status == ok"]
    outcome = outcome_of(seat, **words, checks=checks)
    assert slugs(outcome)[0] == "not-settled"
    assert outcome.warnings[0].numbers["closure"] == outcome.metrics["closure"] > 1e-6
    assert [verdict.passed for verdict in outcome.checks] == [False, True, None]
    assert outcome.checks[0].reason == "not settled: T_a is not known"


def test_block_that_walks_on_for_ever_is_told_what_it_does_and_reaches_no_orbit(seat):
    words = {
        "oscillator": {"mass": 75, "stiffness": 0, "damping": 0},
        "friction__normal_variation": {"amplitude": 0.5, "frequency": 1.6},
        "friction__kinetic": 45,
        "stroke": {"limit": "1 m"},
    }
    outcome = outcome_of(seat, **words, measure={"steady": True})
    said = {warning.slug: warning.sentence for warning in outcome.warnings}
    walks, reaches = said["not-settled"], said["stroke-violated-settling"]
    assert "per repetition; without a spring it may drift for ever; use" in walks
    assert reaches.startswith("in this time |x_r| reaches")
    assert reaches.endswith(" and exceeds the stroke limit of 1 m")


@pytest.mark.parametrize(("approach", "share"), [("switch", 0.01), ("moreau", 0.002)])
def test_fixed_steps_find_an_orbit_of_their_own_near_the_exact_one(seat, approach, share):
    words = {"friction__kinetic": 45, "measure": {"steady": True}, "solver__step": 0.0023}
    exact = outcome_of(seat, **words)
    stepped = outcome_of(seat, **words, solver__approach=approach)
    assert stepped.metrics["T_a"] == pytest.approx(exact.metrics["T_a"], rel=share)
    assert stepped.metrics["closure"] <= 1e-9
    assert stepped.response.dt <= 0.0023
    assert stepped.response.t[-1] == pytest.approx(1 / 1.6)
    assert slugs(stepped) == []


def test_chattering_signum_is_said_not_to_settle(seat):
    words = {"friction__kinetic": 45, "excitation__rms": 0.33, "excitation__frequency": 5}
    outcome = outcome_of(seat, **words, solver__approach="signum", measure={"steady": True})
    assert "not-settled" in slugs(outcome)
    assert outcome.metrics["T_a"] == pytest.approx(1.84, abs=0.02)  # tends to F_fk/(m a_u)


def test_open_energy_balance_and_close_decision_are_warnings(seat):
    outcome = outcome_of(seat)
    response, metrics = outcome.response, outcome.metrics
    assert list(response_warnings(response, metrics, None)) == []
    numerics = replace(response.numerics, closest_decision=1e-8)
    close = replace(response, numerics=numerics)
    said = list(response_warnings(close, {**metrics, "energy_residual": 1e-6}, None))
    assert [warning.slug for warning in said] == ["energy-open", "close-decision"]
    (said,) = response_warnings(response, {**metrics, "energy_residual": math.nan}, None)
    assert said.slug == "energy-open"


@pytest.mark.parametrize(
    ("error", "said"), [(1e-9, []), (2.5, ["inexact"]), (math.nan, ["inexact"])]
)
def test_stated_error_that_a_picture_would_show_is_a_warning(seat, error, said):
    outcome = outcome_of(seat)
    numerics = replace(outcome.response.numerics, error=error)
    inexact = replace(outcome.response, numerics=numerics)
    warnings = list(response_warnings(inexact, outcome.metrics, None))
    assert [warning.slug for warning in warnings] == said
    assert all("of its peak" in warning.sentence for warning in warnings)


def test_response_that_does_not_fit_into_memory_is_refused_with_both_numbers(monkeypatch):
    assert system.total_memory() > 1e8
    monkeypatch.setattr(system, "total_memory", lambda: 8e9)
    assert budget.memory_shortage(int(8e9 / budget.BYTES_PER_STEP)) == ""
    said = budget.memory_shortage(int(16e9 / budget.BYTES_PER_STEP))
    assert "need 16 GB of memory, this machine has 8 GB" in said
    # Written by parts it needs a fraction of that, unless it is weighted.
    assert budget.memory_shortage(10**9, streamed=True) == ""
    assert budget.memory_shortage(10**9, weighted=True, streamed=True)
    assert budget.memory_shortage(2 * 10**9, streamed=True)


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["oscillator.mass=-1"],
        ["measure.duration=1e15"],
        ["friction.static=1"],
        ["nonsense"],
    ],
)
def test_validate_says_no_exactly_when_run_would(seat, overrides):
    if any(one.severity == "error" for one in validate(str(seat), overrides)):
        with pytest.raises(drysim.DrysimError):
            drysim.run(drysim.load(seat, overrides))
    else:
        drysim.run(drysim.load(seat, overrides))


# gallery


def test_gallery_is_found_in_the_checkout_or_beside_the_package():
    assert (gallery.folder() / "paper-low-friction.yaml").is_file()
    assert all(piece.about for piece in gallery.list_scenarios())


def test_record_of_a_scenario_is_copied_with_it_and_never_replaced(tmp_path):
    written = gallery.copy("seat-on-em1", tmp_path)
    assert len(written) == 2
    assert sorted(written) == sorted(tmp_path.iterdir())
    scenario, record = written
    scenario.unlink()
    assert gallery.copy("seat-on-em1", tmp_path) == [scenario]
    scenario.unlink()
    record.write_text("mine")
    with pytest.raises(drysim.OutputError, match="already exists"):
        gallery.copy("seat-on-em1", tmp_path)
    assert record.read_text() == "mine"
    assert not scenario.exists()


def test_file_that_cannot_be_written_completely_is_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "open", lambda file, _: Interrupted(file, "x"))
    with pytest.raises(KeyboardInterrupt):
        gallery.write_new(tmp_path / "new", b"whole")
    assert not (tmp_path / "new").exists()


class Interrupted(FileIO):
    """A file that half its content is written to when somebody presses Ctrl-C."""

    def write(self, content):
        super().write(content[: len(content) // 2])
        raise KeyboardInterrupt


def test_target_that_is_no_folder_is_a_fault(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(drysim.OutputError, match="cannot be written"):
        gallery.copy("paper-low-friction", tmp_path / "file")
