"""End stops from the scenario to its files: words, columns, metrics, warnings, comparisons."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import drysim as package
from drysim import errors
from drysim.plots.response import curve, stops_met

SEAT = """\
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 150}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
stroke: {limit: 15 mm, stops: STOPS}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.5}
solver: {step: 2.5e-3}
"""
BUMPERS = "{stiffness: 2e5, damping: 300}"
RIGID = "{restitution: 0.4}"


def loaded(folder: Path, stops: str, *overrides: str) -> package.Scenario:
    """Give the seat between some stops, from a file."""
    file = folder / "seat.yaml"
    file.write_text(SEAT.replace("STOPS", stops))
    return package.load(file, list(overrides))


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_stops_go_with_surfaces_that_never_lift_off(tmp_path, stops):
    words = "{law: coulomb, mu_kinetic: 0.1, normal: 400 N, normal_variation: VARIED}"
    varied = "{amplitude: %s, frequency: 3 Hz}"
    pressed = loaded(tmp_path, stops, "friction=" + words.replace("VARIED", varied % 0.9))
    assert pressed.stops is not None
    with pytest.raises(errors.ScenarioError) as found:
        loaded(tmp_path, stops, "friction=" + words.replace("VARIED", varied % 1.3))
    assert [problem.sentence for problem in found.value.problems] == [
        "end stops go with a normal force that stays above zero and is no record; mend "
        "friction.normal_variation, or take them away"
    ]


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_run_tells_its_stops_in_every_file(tmp_path, drysim, stops):
    (tmp_path / "seat.yaml").write_text(SEAT.replace("STOPS", stops))
    answer = drysim("run", "seat.yaml")
    assert answer.code == 0
    assert "end stops   at ±15 mm" in answer.out
    assert "stops met   2 times" in answer.out
    assert "the mass comes to its end stops" in answer.err
    out = tmp_path / "out/seat"
    told = json.loads((out / "drysim.json").read_text())
    assert told["numerics"]["core"] == "bounded"
    assert told["metrics"]["contacts"] == 2
    header, *rows = (out / "response.csv").read_text().splitlines()
    assert header.endswith("stuck [-],F_stop [N]")
    forces = np.array([float(row.rpartition(",")[2]) for row in rows])
    assert (np.abs(forces).max() > 0) == (stops == BUMPERS)
    words = {row.split(",")[1] for row in (out / "events.csv").read_text().splitlines()[1:]}
    own = {"contact+", "contact-", "release+", "release-"}
    assert words >= (own if stops == BUMPERS else {"impact+", "impact-"})
    assert drysim("run", out / "scenario.yaml", "-o", "again").code == 0
    again = json.loads((tmp_path / "again/drysim.json").read_text())
    assert again["metrics"] == told["metrics"]


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
@pytest.mark.parametrize("words", [("run",), ("compare", "signum", "vs", "stick-slip", "-s")])
def test_mass_that_rests_on_its_stop_is_drawn(tmp_path, drysim, stops, words):
    text = SEAT.replace("STOPS", stops).replace("rms: 1.5", "rms: 1e-3")
    (tmp_path / "seat.yaml").write_text(f"{text}start: {{x_r: 4 mm}}\n")
    answer = drysim(*words, "seat.yaml", "--set", "stroke.limit=4 mm")
    assert answer.code == 0, answer.err


def test_no_hour_goes_beyond_rigid_stops(tmp_path, drysim):
    base = "excitation={kind: standard, class: EM1, duration: 80, seed: 1}"
    (tmp_path / "seat.yaml").write_text(SEAT.replace("STOPS", RIGID))
    words = ("run", "seat.yaml", "--no-plots", "--set", base)
    near, far = (drysim(*words, "--set", f"stroke.limit={limit} mm") for limit in (15, 500))
    assert "in an hour  15 mm        as far as the rigid stops let it\n" in near.out
    assert "met once, extrapolated from the greatest peaks\n" in far.out
    free = drysim(*words, "--set", "stroke=null", "--json").out
    assert json.loads(free)["metrics"]["stroke_once_an_hour"] > 0.015


def test_scene_without_stops_has_none_of_it(tmp_path, drysim):
    (tmp_path / "seat.yaml").write_text(SEAT.replace(", stops: STOPS", ""))
    answer = drysim("run", "seat.yaml", "--json")
    told = json.loads(answer.out)
    assert told["numerics"]["core"] == "leap"
    assert told["metrics"]["contacts"] is None
    header = (tmp_path / "out/seat/response.csv").read_text().splitlines()[0]
    assert header.endswith("stuck [-]")


def test_rigid_impacts_are_told_to_stand_in_no_acceleration(tmp_path):
    outcome = package.run(loaded(tmp_path, RIGID))
    assert "impacts-left-out" in {caution.slug for caution in outcome.warnings}
    assert outcome.metrics["stop_force_peak"] is None
    speed = outcome.metrics["impact_speed"]
    assert outcome.metrics["impulse_peak"] == pytest.approx(75 * 1.4 * speed, rel=1e-15)


def test_bumper_tells_its_greatest_force(tmp_path):
    outcome = package.run(loaded(tmp_path, BUMPERS, "solver.step=1e-5"))
    peak = outcome.metrics["stop_force_peak"]
    assert np.abs(outcome.response.F_stop).max() == pytest.approx(peak, rel=1e-6)
    assert np.abs(outcome.response.F_stop).max() <= peak * (1 + 1e-14)
    assert outcome.metrics["impulse_peak"] is None


@pytest.mark.parametrize("stops", [BUMPERS, RIGID])
def test_energies_of_an_orbit_add_up(tmp_path, stops):
    metrics = package.run(loaded(tmp_path, stops)).metrics
    lost = sum(metrics[f"energy_{way}"] for way in ("friction", "viscous", "stops"))
    assert metrics["energy_stops"] > 0
    assert metrics["energy_input"] == pytest.approx(lost, rel=1e-9)


def test_sweep_over_the_stops_has_their_columns(tmp_path, drysim):
    text = SEAT.replace("STOPS", RIGID) + "sweep: {stroke.stops.restitution: [0.2, 0.8]}\n"
    (tmp_path / "seat.yaml").write_text(text)
    assert drysim("sweep", "seat.yaml").code == 0
    header, *rows = (tmp_path / "out/seat/transmissibility.csv").read_text().splitlines()
    columns = header.split(",")
    taken = [float(row.split(",")[columns.index("energy_stops [J]")]) for row in rows]
    assert taken[0] > taken[1] > 0


@pytest.mark.parametrize("words", ["{stroke.limit: [10 mm, 15 mm]}", "{stroke.limit: [1 m]}"])
def test_sweep_that_meets_rigid_stops_says_that_T_a_leaves_the_impacts_out(tmp_path, words):
    """An orbit between close rigid stops has a T_a of 0.4 that reads like good isolation."""
    for stops in (RIGID, BUMPERS):
        table = package.sweep(loaded(tmp_path, stops, f"sweep={words}"))
        slugs = [caution.slug for caution in table.warnings]
        met = any(row.metrics["contacts"] for row in table)
        assert ("impacts-left-out" in slugs) == (met and stops == RIGID)
        assert met == (words != "{stroke.limit: [1 m]}")


def test_sweep_of_a_start_beyond_rigid_stops_is_a_fault_at_its_value(tmp_path):
    with pytest.raises(package.ScenarioError) as fault:
        loaded(tmp_path, RIGID, "sweep={start.x_r: [0, 0.02]}")
    (problem,) = fault.value.problems
    assert "rigid stops let the mass no further" in problem.sentence


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("signum", "stick-slip"), "signum knows no end stops"),
        (("lugre", "coulomb"), "lugre knows no end stops"),
    ],
)
def test_compare_says_who_knows_no_stops(tmp_path, words, sentence):
    lugre = (
        "friction.lugre={bristle_stiffness: 1e5, bristle_damping: 300, stribeck_velocity: 0.01}"
    )
    scenario = loaded(tmp_path, BUMPERS, "friction.static_ratio=1", lugre)
    found = package.compare(scenario, words)
    told = [caution.sentence for caution in found.table.warnings if caution.slug == "left-out"]
    assert any(one.startswith(sentence) for one in told)
    assert not any(one.startswith(("stick-slip", "coulomb", "viscous knows")) for one in told)
    peaks = {row.approach: row.metrics["x_r_peak"] for row in found.table.rows}
    assert peaks[words[1]] < 0.02 < peaks[words[0]]
    assert peaks["viscous"] < 0.02


def test_seeds_count_their_contacts(tmp_path, drysim):
    noise = "excitation: {kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, seeds: 3}"
    old = "excitation: {kind: harmonic, frequency: 1.6, rms: 1.5}"
    (tmp_path / "seat.yaml").write_text(SEAT.replace("STOPS", BUMPERS).replace(old, noise))
    answer = drysim("run", "seat.yaml", "--no-plots")
    assert answer.code == 0
    header, *rows = (tmp_path / "out/seat/ensemble.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    columns = {name: [row[at] for row in cells] for at, name in enumerate(header.split(","))}
    assert all(int(float(cell)) > 0 for cell in columns["contacts [-]"])
    fastest, force = (
        max(map(float, columns[name])) for name in ("impact_speed [m/s]", "stop_force_peak [N]")
    )
    assert f"3 seeds               of 3, at up to {fastest:.4g} m/s with seed" in answer.out
    assert f"pushing with up to {force:.4g} N with seed" in " ".join(answer.out.split())
    assert f"end stops with 3 of 3 seeds, with up to {fastest:.4g} m/s with seed" in answer.err
    assert "all 3 seeds from" in answer.out
    assert "9 of 10 seeds" not in answer.out


def test_speed_that_is_met_while_settling_is_said_to_be(tmp_path):
    """The summary told 0.185 m/s, of the window, beside a warning of 0.220 m/s."""
    times = "measure={settle: 4 s, duration: 4 s}"
    for settle, told in ((times, True), (times.replace("settle: 4 s, ", ""), False)):
        made = package.run(loaded(tmp_path, BUMPERS, settle))
        (warning,) = [one for one in made.warnings if one.slug == "stroke-violated"]
        assert warning.sentence.endswith("settling included") == told


def test_rigid_stops_of_any_seed_leave_impacts_out(tmp_path):
    noise = "excitation={kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, seeds: 3}"
    made = package.run(loaded(tmp_path, RIGID, noise))
    assert [one.slug for one in made.warnings].count("impacts-left-out") == 1


def test_picture_marks_every_hit(tmp_path):
    response = package.run(loaded(tmp_path, BUMPERS)).response
    assert [x_r for _, x_r in stops_met(response)] == [-0.015, 0.015]
    shown = curve(response, slice(None))
    assert (np.diff(shown.t) >= 0).all()
    jumps = np.abs(np.diff(shown.x_dd))[np.diff(shown.t) < 1e-12]
    assert jumps.max() > 0.5


@pytest.mark.parametrize(
    ("name", "needs"), [("contacts", "give stroke.stops"), ("stop_force_peak", "end stops")]
)
def test_until_cannot_ask_for_stops_that_are_not_there(tmp_path, name, needs):
    noise = (
        "excitation={kind: psd, points: [[0.8, 1], [4, 1]], duration: 8 s, "
        f"until: {{metric: {name}, half_width: 5 %}}}}"
    )
    with pytest.raises(package.ScenarioError) as fault:
        loaded(tmp_path, BUMPERS, "stroke.stops=null", noise)
    assert needs in fault.value.problems[0].sentence


def test_mass_that_a_squeezed_bumper_drives_is_not_said_to_stay(tmp_path):
    rest = "excitation={kind: rest}", "measure.duration=1", "friction.kinetic=200"
    inside = package.run(loaded(tmp_path, BUMPERS, *rest, "start.x_r=14 mm"))
    beyond = package.run(loaded(tmp_path, BUMPERS, *rest, "start.x_r=20 mm"))
    slugs = [{caution.slug for caution in made.warnings} for made in (inside, beyond)]
    assert "will-not-move" in slugs[0]
    assert "will-not-move" not in slugs[1]
    assert len(beyond.events) > 1
