"""A normal force in scenarios: recorded or lifting; what uses it, refuses it, and says so."""

from __future__ import annotations

import math

import numpy as np
import pytest
from contacts import at
from invariants import Invariants, TouchingZero
from law_scenes import PAPER, REST, STEP, doubled, noise, separating_law, sine, solved
from pressing import march_pressed
from reference import assert_agrees, peak
from seat import fields_of

import drysim
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, NormalForceRecord, Plant, Samples, Sines, State
from drysim.errors import RecordError, ScenarioError
from drysim.orbits.search import find_orbit
from drysim.scenario.load import load
from drysim.study.preparation import prepare
from drysim.study.validate import validate

HEAD = """drysim: 1
oscillator: {{mass: 75, stiffness: 7500, damping: 500}}
friction: {{law: coulomb, mu_kinetic: 0.3, mu_static: 0.36, {force}}}
stroke: {{limit: 25 mm}}
excitation: {{kind: harmonic, frequency: 2, rms: 0.75}}
solver: {{step: 2.5e-3}}
"""
RECORD = "normal_record: {file: force.csv, column: F_N, rate: 100 Hz}"
WINDOW = "measure: {settle: 1 s, duration: 3 s}\n"


@pytest.fixture
def scene(tmp_path):
    """Write a scenario beside a record of its normal force, 5 s long; gives its path."""

    def written(force=RECORD, more=WINDOW, values=None, header="F_N [N]"):
        t = np.arange(501) / 100
        values = 100 + 130 * np.sin(2 * np.pi * 0.9 * t) if values is None else values
        lines = "\n".join(map(repr, np.asarray(values).tolist()))
        (tmp_path / "force.csv").write_text(f"{header}\n{lines}\n")
        path = tmp_path / "seat.yaml"
        path.write_text(HEAD.format(force=force) + more)
        return path

    return written


def test_record_lifts_off_and_its_run_says_so(scene):
    outcome = drysim.run(load(scene()))
    assert {"lift", "slip+", "slip-", "stick"} <= set(outcome.response.events.names)
    assert outcome.response.numerics.core == "rigid-contact"
    assert outcome.response.numerics.closest_decision > 0
    assert outcome.metrics["energy_residual"] < 1e-12


def test_forces_stand_for_the_mean_and_units_are_converted(scene):
    law = load(scene(values=[0.1, 0.3] * 250 + [0.2], header="F_N [kN]")).law()
    assert law.F_fk == pytest.approx(0.3 * 200, rel=1e-12)
    assert law.F_fs == pytest.approx(0.36 * 200, rel=1e-12)
    assert law.force_record.relative[:2] == pytest.approx([0.5, 1.5], rel=1e-12)


def test_resolved_scenario_runs_again(scene, tmp_path):
    scenario = load(scene())
    words = scenario.resolved(tmp_path / "out")
    assert words["friction"]["normal_record"]["file"] == "../force.csv"
    assert "normal" not in words["friction"]


def test_record_in_options_of_another_law_is_resolved_to_its_own_file(scene, tmp_path):
    loaded = load(scene())
    pressed = {k: v for k, v in loaded.file_block("friction").items() if k != "law"}
    dahl = {"law": "dahl", "kinetic": 15, "bristle_stiffness": 1e5, "coulomb": pressed}
    scenario = load(scene(), {"friction": dahl})
    assert [one.slug for one in prepare(scenario).warnings if one.slug == "unread-record"] == []
    words = scenario.resolved(tmp_path / "out")
    assert words["friction"]["coulomb"]["normal_record"]["file"] == "../force.csv"


def test_amplitude_of_one_and_more_is_solved_by_modes(scene):
    for amplitude, kind in (
        (0.999, "event-to-event"),
        (1.0, "rigid-contact"),
        (1.7, "rigid-contact"),
    ):
        force = f"normal: 100, normal_variation: {{amplitude: {amplitude}, frequency: 4}}"
        outcome = drysim.run(load(scene(force, more="")))
        assert outcome.response.numerics.core == kind
        assert outcome.metrics["closure"] < 1e-11


def test_swept_amplitudes_on_both_sides_of_one_agree_with_runs(scene):
    force = "normal: 100, normal_variation: {amplitude: 0.5, frequency: 4}"
    sweep = "sweep: {friction.normal_variation.amplitude: [0.5, 0.99, 1.0, 1.5]}\n"
    scenario = load(scene(force, more=sweep))
    for row in drysim.sweep(scenario):
        alone = drysim.run(scenario.at(row.point))
        assert row.metrics["T_a"] == pytest.approx(alone.metrics["T_a"], rel=1e-9)


def test_record_is_read_once_for_all_cases_and_hashed(scene, tmp_path, monkeypatch):
    from drysim.records import formats, record

    scenario = load(scene(more=WINDOW + "sweep: {friction.mu_kinetic: [0.1, 0.2, 0.3]}\n"))
    calls, read = [], formats.open_with_format
    monkeypatch.setattr(
        record, "open_with_format", lambda *given: calls.append(given) or read(*given)
    )
    rows = list(drysim.sweep(scenario))
    assert len({row.metrics["T_a"] for row in rows}) == 3
    assert len(calls) == 1


def test_sidecar_names_the_record(scene, drysim):
    assert drysim("run", scene(), "--no-plots", "-q", "-o", "out").code == 0
    inputs = fields_of("out")["inputs"]
    assert [entry["file"] for entry in inputs] == ["force.csv"]
    assert len(inputs[0]["sha256"]) == 64


def test_other_approaches_take_the_mean_in_a_comparison(scene):
    scenario = load(scene())
    mean = scenario.law().force_record.mean
    law = scenario.with_approach("signum").law()
    assert not law.may_separate
    assert law.F_fk == pytest.approx(0.3 * mean, rel=1e-12)
    omissions = scenario.omissions("signum")
    assert "signum uses a constant normal force" in omissions


def test_other_laws_take_the_mean_in_a_comparison(scene):
    scenario = load(scene(RECORD + ", stribeck: {stribeck_velocity: 0.01}"))
    law = scenario.with_law("stribeck").law()
    assert law.F_fk == pytest.approx(scenario.law().F_fk, rel=1e-12)


VERTICAL = "normal_record: {file: force.csv, column: z, rate: 100 Hz, quantity: acceleration}"


@pytest.mark.parametrize(("amplitude", "lifts"), [(3.0, False), (12.0, True)])
def test_vertical_acceleration_presses_the_mass(scene, amplitude, lifts):
    t, m = np.arange(501) / 100, 75.0
    z_dd = amplitude * (np.sin(2 * np.pi * 0.9 * t) + 0.2 * np.cos(11 * t))
    z_dd -= z_dd.mean()
    by_force = load(scene(values=m * (9.81 + z_dd)))
    expected = drysim.run(by_force)
    other = by_force.with_approach("signum").law()
    scenario = load(scene(VERTICAL, values=z_dd / 9.80665, header="z [g]"))
    result = drysim.run(scenario)
    assert scenario.law().F_fk == pytest.approx(0.3 * m * 9.81, rel=1e-12)
    assert np.abs(result.response.x_r - expected.response.x_r).max() < 1e-12
    assert ("lift" in result.response.events.names) == lifts
    assert scenario.with_approach("signum").law().F_fk == pytest.approx(other.F_fk, rel=1e-12)


def test_gravity_in_a_vertical_acceleration_is_refused_and_an_offset_told(scene):
    z_dd = np.sin(2 * np.pi * 0.9 * np.arange(501) / 100)
    for sign in (1.0, -1.0):
        with pytest.raises(RecordError, match="looks like gravity: `remove: mean` removes it"):
            load(scene(VERTICAL, values=z_dd + sign * 9.81, header="z [m/s2]")).law()
    with pytest.raises(RecordError, match="nothing presses the mass"):
        load(scene(VERTICAL, values=z_dd - 12.0, header="z [m/s2]")).law()
    file = scene(VERTICAL, values=z_dd - z_dd.mean() + 0.3, header="z [m/s2]")
    (warning,) = load(file).law().force_record.warnings
    assert warning.slug == "record-mean"
    assert "the normal force is 3.1 % above the weight on average" in warning.sentence
    mean = {"friction.normal_record.remove": "mean"}
    assert load(file, mean).law().force_record.warnings == ()


@pytest.mark.parametrize(
    ("force", "more", "sentence"),
    [
        (RECORD, "measure: {duration: 6 s}\n", "friction.normal_record ends at 5 s, before"),
        (RECORD, "measure: {duration: 5.0004 s}\n", "end of the run at 5.0004 s; use"),
        (RECORD, "", "measure.duration is required for harmonic"),
        (RECORD, "measure: {steady: true}\n", "needs a periodic normal force"),
        (RECORD + ", normal: 3", WINDOW, "give normal or normal_record, not both"),
        (RECORD.replace("rate", "unit: m, rate"), WINDOW, "is a unit of length, not force"),
        (RECORD.replace("file: force.csv, ", ""), WINDOW, "normal_record.file is required"),
        (RECORD.replace(", rate: 100 Hz", ""), WINDOW, "the time step is unknown"),
        (RECORD.replace("force.csv", "farce.csv"), WINDOW, "did you mean `force.csv`?"),
        (RECORD.replace("F_N", "F_T"), WINDOW, "there is no column `F_T`"),
        (RECORD.replace("rate", "scale: -1, rate"), WINDOW, "mean of the normal force is -"),
        (
            "normal_variation: {amplitude: 1.2, frequency: 4}, " + RECORD,
            WINDOW,
            "give normal_record or normal_variation, not both",
        ),
    ],
)
def test_faults_are_told_before_anything_is_computed(scene, force, more, sentence):
    problems = validate(str(scene(force, more)))
    assert [problem.severity for problem in problems] == ["error"]
    assert sentence in problems[0].sentence


@pytest.mark.parametrize(
    ("amplitude", "frequency", "slugs"),
    [(40, 35, ["record-interpolated"]), (40, 3, []), (2, 35, [])],
)
def test_force_that_interpolation_takes_away_is_a_warning(scene, amplitude, frequency, slugs):
    t = np.arange(501) / 100
    values = 100 + amplitude * np.sin(2 * np.pi * frequency * t)
    force_record = load(scene(values=values)).law().force_record
    assert [caution.slug for caution in force_record.warnings] == slugs
    if slugs:
        assert "the RMS from 28.26 to 19.36 N" in force_record.warnings[0].sentence


def test_unit_is_mandatory(scene):
    way = "write `unit: N` in the scenario's `friction.normal_record` block"
    with pytest.raises(RecordError, match=way):
        load(scene(header="F_N")).law()


@pytest.mark.parametrize("name", ["switch", "moreau", "signum", "smooth"])
@pytest.mark.parametrize(
    "force", [RECORD, "normal: 100, normal_variation: {amplitude: 1.2, frequency: 4}"]
)
def test_approaches_without_a_use_for_it_refuse_it(scene, name, force):
    with pytest.raises(ScenarioError) as found:
        load(scene(force), {"solver.approach": name, "friction.mu_static": 0.3})
    assert "does not support a varying normal force" in found.value.problems[0].sentence


@pytest.mark.parametrize(
    "force", [RECORD, "normal: 100, normal_variation: {amplitude: 1.2, frequency: 4}"]
)
def test_surfaces_that_part_go_between_end_stops(scene, force):
    scenario = load(scene(force), {"stroke.stops.restitution": 0.3})
    assert scenario.law().stops.rigid
    assert scenario.law().may_separate


def test_faintest_force_that_varies_holds_what_nothing_pulls():
    """The squares of its rates are below the numbers: a margin that stays was missed."""
    law = CoulombLaw(1e-300, 1e-300, 0.5, 1.0, 0.0)
    still = Samples(np.zeros(3), 2.5)
    events = StickSlip().solve(Plant(1.0, 1.0, 0.0), law, still, State(0.0, 0.0), 2.5).events
    assert events.t.tolist() == [0.0]


# Coulomb under a normal force that lifts off or was recorded: a state machine, invariants.


NOISE = noise(1200, 1.0, seed=3)


def recorded(n, step, swing, seed=2):
    """Return a normal force of band-limited noise about 1, of mean 1."""
    values = np.random.default_rng(seed).standard_normal(n)
    values = np.convolve(values, np.hanning(9), mode="same")
    values *= swing / np.std(values)
    return NormalForceRecord(1.0 + values - values.mean(), step, 100.0)


FORCES = {
    "touching": separating_law(30.0, 36.0, 1.0, 2 * math.pi * 2.3, 0.4),
    "lifting": separating_law(30.0, 30.0, 1.6, 2 * math.pi * 0.7, 0.4),
    "hammering": separating_law(30.0, 45.0, 1.3, 2 * math.pi * 5.7, 0.0),
    "recorded": separating_law(30.0, 36.0, force_record=recorded(400, 0.0107, 0.2)),
    "record that lifts": separating_law(30.0, 36.0, force_record=recorded(400, 0.0107, 0.9)),
    "record of the same step": separating_law(
        30.0, 30.0, force_record=recorded(1300, STEP, 0.9)
    ),
}
each_force = pytest.mark.parametrize("law", FORCES.values(), ids=FORCES)
each_base = pytest.mark.parametrize("motion", [sine(1.0, 1.6), NOISE], ids=["sine", "noise"])


def load_of(law):
    """Return the normal force, below zero where the surfaces have parted."""
    if law.force_record is None:
        return lambda t: 1.0 + law.variation * math.sin(law.omega * t + law.phase)
    t, values = (
        np.arange(len(law.force_record.relative)) * law.force_record.step,
        law.force_record.relative,
    )
    return lambda now: np.interp(now, t, values)


def kinks_of(law, motion, end):
    """Return the times at which a force or ü has a kink."""
    kinks = [np.arange(0.0, end, motion.dt)] if isinstance(motion, Samples) else []
    if law.force_record is not None:
        kinks.append(np.arange(0.0, end, law.force_record.step))
    return np.unique(np.concatenate(kinks).round(12)) if kinks else ()


def base_of(motion):
    if isinstance(motion, Samples):
        t = np.arange(len(motion.u_dd)) * motion.dt
        return lambda now: np.interp(now, t, motion.u_dd)
    return lambda now: motion.A[0] * math.sin(2 * math.pi * motion.f[0] * now)


@each_force
@each_base
def test_motion_agrees_with_a_state_machine(law, motion):
    end = 0.9
    response = solved(law, motion, duration=end)
    kinks = kinks_of(law, motion, end)
    scene = PAPER, law.F_fk, law.F_fs, load_of(law), base_of(motion), end

    def known(rtol):
        pieces = march_pressed(*scene, kinks=kinks, rtol=rtol)
        modes = {piece[3] for piece in pieces}
        assert {"free", 1, -1} <= modes or "lift" not in response.events.names
        return at(pieces, response.t)

    x_r, v_r = response.x_r, response.v_r
    assert_agrees([x_r, v_r], known, [1e-8 * peak(x_r), 1e-8 * peak(v_r)])


@each_force
@each_base
class TestInvariants(Invariants):
    def test_twice_the_forces_under_twice_the_base_motion_move_twice_as_far(self, law, motion):
        one = solved(law, motion, duration=2.9)
        twice = law._replace(F_fk=2 * law.F_fk, F_fs=2 * law.F_fs)
        two = solved(twice, doubled(motion), duration=2.9)
        assert (two.x_r == 2 * one.x_r).all()

    def test_friction_is_within_its_limits_and_nothing_where_the_surfaces_are_apart(
        self, law, motion
    ):
        response = solved(law, motion, duration=2.9)
        load = law.load(response.t)
        assert (np.abs(response.F_f) <= law.F_fs * load * (1.0 + 1e-12) + 1e-9).all()
        assert (response.F_f[load == 0.0] == 0.0).all()
        assert (response.F_f * response.v_r >= 0.0).all()
        assert (response.v_r[response.stuck] == 0.0).all()
        sliding = (response.v_r != 0.0) & (load > 1e-9)
        F_f = law.F_fk * load * np.sign(response.v_r)
        assert np.abs(response.F_f - F_f)[sliding].max() < 1e-9


MANY_EVENTS = Samples(noise(8000, 1.0, seed=3).u_dd[::160], 160 * STEP)
"""Noise of which a step holds many events."""


@pytest.mark.parametrize("motion", [sine(1.0, 1.6), NOISE, MANY_EVENTS])
@pytest.mark.parametrize(("count", "step"), [(1000, 0.0071), (3, 50.0)])
def test_constant_record_is_a_constant_force(motion, count, step):
    flat = NormalForceRecord(np.ones(count), step, 100.0)
    law, other = separating_law(30.0, 40.0, force_record=flat), CoulombLaw(30.0, 40.0)
    one, other = (solved(each, motion, duration=2.9) for each in (law, other))
    assert np.abs(one.x_r - other.x_r).max() < 1e-12 * np.abs(other.x_r).max()
    assert one.events.kind.tolist() == other.events.kind.tolist()
    assert np.abs(one.events.t - other.events.t).max() < 1e-11
    totals, others = one.trajectory.totals(0.4, 2.8), other.trajectory.totals(0.4, 2.8)
    assert totals[:7] == pytest.approx(others[:7], rel=1e-11)


@each_force
@each_base
def test_motion_that_ends_within_a_step_is_the_beginning_of_a_longer_one(law, motion):
    short, long = (solved(law, motion, duration=end).trajectory for end in (0.4013, 0.9))
    assert short.state(0.4013)[:2] == pytest.approx(long.state(0.4013)[:2], rel=1e-9)
    one, other = short.totals(0.1, 0.4013), long.totals(0.1, 0.4013)
    assert one[:7] == pytest.approx(other[:7], rel=1e-9)


@each_base
def test_force_that_stays_above_zero_is_that_of_a_varying_limit(motion):
    """The two ways to the same limits: by a wave among the others, and by modes."""
    words = (30.0, 40.0, 0.6, 2 * math.pi * 1.7, 0.3)
    one, other = (
        solved(law, motion, duration=2.9)
        for law in (separating_law(*words), CoulombLaw(*words))
    )
    assert np.abs(one.x_r - other.x_r).max() < 1e-11 * np.abs(other.x_r).max()


class TestTouchingZero(TouchingZero):
    law = separating_law(30.0, 36.0, 1.0, 2 * math.pi * 2.3)


def test_mass_that_is_never_touched_moves_freely():
    apart = NormalForceRecord(np.array([1.0, -1.0, -1.0]), 1e-9, 1.0)
    motion = sine(1.0, 1.6)
    response = solved(separating_law(30.0, 40.0, force_record=apart), motion, duration=2.0)
    free = solved(CoulombLaw(0.0, 0.0), motion, duration=2.0)
    assert "lift" in response.events.names[:4]
    assert np.abs(response.x_r - free.x_r).max() < 1e-9 * np.abs(free.x_r).max()


def test_mass_at_rest_stays_at_rest_through_lift_and_landing():
    response = solved(FORCES["lifting"], Sines((), (), ()), duration=3.0)
    assert (response.x_r == 0.0).all()
    assert {"lift", "stick"} <= set(response.events.names)


def test_split_run_equals_the_whole():
    law = FORCES["record that lifts"]
    whole, cut = solved(law, NOISE), 428 * STEP  # the hundredth sample of the force
    force = law.force_record.relative[100:]
    rest = Samples(NOISE.u_dd[428:], STEP)
    later = law._replace(force_record=NormalForceRecord(force, law.force_record.step, 100.0))
    part = solved(later, rest, start=State(*whole.trajectory.state(cut)[:2]))
    assert np.abs(part.x_r - whole.x_r[428:]).max() < 1e-12


def test_orbit_of_a_lifting_force_closes():
    law = separating_law(30.0, 36.0, 1.4, 2 * math.pi * 0.8, 0.3)
    orbit = find_orbit(PAPER, law, sine(1.0, 1.6), REST, 1 / 0.8)
    assert orbit.settled
    assert orbit.closure <= 1e-12
    trajectory = solved(
        law, sine(1.0, 1.6), start=State(*orbit.state[:2]), duration=1 / 0.8
    ).trajectory
    assert trajectory.state(1 / 0.8)[:2] == pytest.approx(orbit.state[:2], rel=1e-10)
