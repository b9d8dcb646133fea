"""The gallery: every scenario is one to learn from, and keeps what it promises."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import golden
import pytest
from golden import ASSESSED, DESIGNS, FITS, GALLERY, HARD, SCENARIOS, SHIPPED, SWEEPS

import drysim
from drysim.scenario.laws import LAWS
from drysim.study import gallery

KEPT = json.loads(golden.FILE.read_text())


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_scenario_keeps_its_promises(file):
    outcome = golden.outcome(file)
    assert outcome.checks
    assert not any(verdict.passed is False for verdict in outcome.checks)


@pytest.mark.parametrize("file", SWEEPS, ids=lambda file: file.stem)
def test_sweep_keeps_the_promises_of_its_scenario(file):
    checks = golden.table(file).checks
    assert checks
    assert all(verdict.passed for verdict in checks)


@pytest.mark.parametrize("file", FITS, ids=lambda file: file.stem)
def test_fit_keeps_the_promises_of_its_scenario_and_gives_one_that_runs(file):
    result = golden.fitted(file)
    assert result.checks
    assert all(verdict.passed for verdict in result.checks)
    plain = drysim.run(result.scenario)
    assert not any(verdict.passed is False for verdict in plain.checks)


@pytest.mark.parametrize("file", ASSESSED, ids=lambda file: file.stem)
def test_assessment_keeps_the_promises_of_its_scenario(file):
    result = drysim.assess(drysim.load(file))
    assert result.checks
    assert all(verdict.passed for verdict in result.checks)
    assert not result.warnings


@pytest.mark.parametrize("file", DESIGNS, ids=lambda file: file.stem)
def test_design_keeps_the_limits_of_its_scenario_and_gives_one_that_runs(file):
    result = drysim.design(drysim.load(file))
    assert result.converged
    assert result.checks
    assert all(verdict.passed for verdict in result.checks)
    assert result.best.objectives < result.variants[0].candidate.objectives
    assert drysim.run(result.scenario).metrics["x_r_peak"] > 0.0


@pytest.fixture(scope="module")
def records():
    """Return the script that writes the synthetic measurements."""
    place = importlib.util.spec_from_file_location("it", GALLERY / "fit_records.py")
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module


def test_synthetic_measurements_are_what_their_script_writes(records):
    for file, write in records.FILES.items():
        assert file.read_text(encoding="utf-8") == write()
        assert file.stat().st_size < 300_000


@pytest.mark.parametrize("name", ["SEAT", "DECAY"])
def test_intervals_of_a_fit_hold_what_its_record_was_computed_with(records, name):
    true = getattr(records, name)
    keys = {
        "oscillator.stiffness": "k_x",
        "oscillator.damping": "b",
        "friction.kinetic": "F_fk",
    }
    wanted = {key: true[symbol] for key, symbol in keys.items()}
    if name == "SEAT":
        wanted["friction.static_ratio"] = true["F_fs"] / true["F_fk"]
    else:
        wanted["start.x_r"] = records.RELEASE
    result = golden.fitted(GALLERY / f"fit-{name.lower()}.yaml")
    assert {one.key for one in result.parameters} == wanted.keys()
    for one in result.parameters:
        assert one.profile_low < wanted[one.key] < one.profile_high
    assert result.warnings == ()


def test_coefficient_of_the_fitted_rig_agrees_with_the_published_one():
    (mu,) = golden.fitted(GALLERY / "fit-rig.yaml").parameters
    low, high = 0.140794, 0.154256  # 95 %, published with the data
    assert low < mu.value < high
    assert mu.profile_low < 0.147525 < mu.profile_high
    assert mu.deviation == pytest.approx(0.0033, rel=0.1)


def test_rows_of_a_rig_are_fitted_at_their_own_times():
    assert len(golden.fitted(GALLERY / "fit-rig.yaml").measurement.t) == 433


@pytest.mark.parametrize("file", [*SCENARIOS, *HARD], ids=lambda file: file.stem)
def test_run_gives_what_it_gave_when_last_written(file):
    kept = KEPT["run"][file.stem]
    a_u = kept["metrics"]["a_u"] or 1.0
    # Where the whole motion is tiny, rounding is, too.
    assert golden.of_run(file) == close(kept, scale=min(1.0, 1e6 * a_u**2))


@pytest.mark.parametrize("file", SWEEPS, ids=lambda file: file.stem)
def test_sweep_gives_what_it_gave_when_last_written(file):
    assert golden.of_sweep(file) == close(KEPT["sweep"][file.stem])


def close(kept, scale=1.0):
    """Return what was kept with room for what rounds differently on another processor."""
    if isinstance(kept, dict):
        return {key: close(value, scale) for key, value in kept.items()}
    if isinstance(kept, list):
        return [close(value, scale) for value in kept]
    room = 1e-12 * scale
    return pytest.approx(kept, rel=1e-8, abs=room) if isinstance(kept, float) else kept


def test_gallery_sweeps_the_figures_of_the_paper():
    sizes = {
        file.stem: [len(axis.values) for axis in drysim.load(file).sweep] for file in SWEEPS
    }
    assert sizes["paper-low-friction"] == sizes["paper-high-friction"] == [96, 3]
    assert sizes["paper-random"] == [15, 2]


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_scenario_is_named_after_its_file_and_says_what_it_is(file):
    scenario = drysim.load(file)
    assert scenario.name == file.stem
    assert scenario.about.endswith(".")
    assert file.read_text().startswith("# yaml-language-server: $schema=scenario.schema.json\n")


def test_free_decay_stops_where_the_closed_form_says():
    events = drysim.run(drysim.load(GALLERY / "free-decay.yaml")).events
    turns = 12 + 1.3178210632763534, 2.0  # the first turn, and what each half cycle takes
    expected = [(-1) ** k * (turns[0] - k * turns[1]) for k in range(7)]
    assert events.x_r[1:8] == pytest.approx(expected, abs=1e-12)
    assert (events.t[-1], events.x_r[-1]) == pytest.approx((22.42355635, 0.68217894), abs=1e-8)


def test_without_friction_the_seat_meets_its_stroke_limit():
    scenario = drysim.load(GALLERY / "seat-on-em1.yaml", {"friction.kinetic": 0})
    assert drysim.run(scenario).metrics["violations"] > 0


@pytest.mark.parametrize("law", LAWS)
def test_every_law_has_a_scenario_of_its_own_with_a_small_picture_of_its_loop(law):
    shipped = gallery.find(f"friction-{law}")
    assert drysim.load(shipped.file).friction.law == law
    assert shipped.loop.read_bytes().startswith(b"\x89PNG")
    assert shipped.loop.stat().st_size < 20_000


@pytest.mark.parametrize("law", LAWS)
def test_every_law_can_act_in_the_scenario_of_all_laws(law):
    scenario = drysim.load(GALLERY / "friction-laws.yaml")
    assert scenario.with_law(law).law().F_fk == 45.0
    assert tuple(scenario.omissions(law)) == ()


def test_scenario_for_comparisons_is_followed_by_one():
    found = gallery.find("friction-laws").command_line(Path("mine.yaml"))
    assert found == "drysim compare coulomb vs lugre vs stick-slip mine.yaml"
    commands = {"regime-map": "map", "paper-random": "sweep", "rough-road": "run"}
    for name, command in commands.items():
        line = gallery.find(name).command_line(Path("mine.yaml"))
        assert line == f"drysim {command} mine.yaml"


def test_program_that_draws_the_pictures_of_the_gallery_runs(tmp_path):
    name = "friction-dahl.png"
    shutil.copytree(GALLERY, tmp_path / "scenarios")
    loop = tmp_path / "scenarios" / "pictures" / "loops" / name
    loop.unlink()
    draw = [sys.executable, str(tmp_path / "scenarios" / "pictures" / "draw.py"), name]
    assert subprocess.run(draw, check=False).returncode == 0
    assert loop.read_bytes().startswith(b"\x89PNG")
