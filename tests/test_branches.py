"""Branches of periodic motions: multipliers, folds and other bifurcations, faults, files."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from seat import fields_of, load_text, rows_of

import drysim
from drysim.core.orbit import SINES
from drysim.orbits import continuation
from drysim.orbits.continuation import Continuation
from drysim.study.branches import Study, prepare_branches

SCALED = """
drysim: 1
oscillator: {{mass: 1, stiffness: 1, damping_ratio: {zeta}}}
friction: {{law: coulomb, kinetic: {phi}, static_ratio: {eta}}}
excitation: {{kind: harmonic, frequency: {frequency}, amplitude: 1}}
solver: {{step: 0.01}}
"""
PAPER = """
drysim: 1
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
excitation: {kind: harmonic, frequency: HZ, rms: 0.5}
solver: {step: 2.5e-3}
sweep:
  friction.static_ratio: {from: 1, to: 1.5, step: 0.1}
"""


def scaled(folder: Path, beta, zeta, phi, eta, sweep: str = "", **keys) -> drysim.Scenario:
    """Return a scene with m = k_x = 1 and base acceleration of amplitude 1."""
    text = SCALED.format(frequency=repr(beta / math.tau), zeta=zeta, phi=phi, eta=eta)
    return load_text(folder, text + (f"sweep:\n  {sweep}\n" if sweep else ""), **keys)


UNSYMMETRIC = (0.5, 0.05, 0.2, 2, "friction.kinetic: {from: 0.05, to: 0.45, count: 5}")
"""A scene in which symmetry breaks."""


def paper(folder: Path, hz: float, **keys) -> drysim.Scenario:
    """Return the scene of the paper's Fig. 4 over the static ratio."""
    return load_text(folder, PAPER.replace("HZ", str(hz)), **keys)


def bifurcations(result, kind):
    """Return the values of the key at the bifurcations of a kind."""
    return [one.value for one in result.bifurcations if one.kind == kind]


# Multipliers of the orbit of a run


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "eta", "expected"),
    [
        (0.8, 0.05, 0.3, 1, 0.03306541 + 0.44755169j),
        (1.5, 0.05, 0.5, 1, -0.12863689 + 0.27502674j),
        (2.0, 1 / 3, 0.3, 1, -0.1560542 + 0.07507111j),
        (0.8, 0.0, 0.3, 1, 0.02294045 + 0.6967003j),
        (0.3, 0.05, 0.2, 1, 0.50863404),
        (1.0, 1 / 3, 0.6, 1.2, 0.07120099),
        (0.5, 0.05, 0.5, 1, 0.05770276),
    ],
)
def test_multipliers_of_an_orbit_are_those_of_the_closed_form(
    tmp_path, beta, zeta, phi, eta, expected
):
    metrics = drysim.run(scaled(tmp_path, beta, zeta, phi, eta)).metrics
    first, second = (
        metrics[f"multiplier_{i}"] * np.exp(1j * metrics[f"multiplier_{i}_phase"])
        for i in (1, 2)
    )
    if isinstance(expected, complex):
        assert {round(abs(one - expected), 7) for one in (first, second)} >= {0.0}
        assert first == pytest.approx(second.conjugate(), abs=1e-12)
    else:
        assert first == pytest.approx(expected, abs=1e-7)
        assert abs(second) < 1e-12
    assert metrics["stable"] == 1


def test_multipliers_of_a_case_of_a_sweep_are_those_of_its_run(tmp_path):
    swept = scaled(tmp_path, 0.8, 0.05, 0.3, 1.1, "friction.kinetic: [0.2, 0.3, 0.6]")
    for row in drysim.sweep(swept).rows:
        alone = scaled(tmp_path, 0.8, 0.05, row.point["friction.kinetic"], 1.1)
        metrics = drysim.run(alone).metrics
        for name in ("multiplier_1", "multiplier_1_phase", "multiplier_2", "stable"):
            assert row.metrics[name] == pytest.approx(metrics[name], abs=1e-9)


def test_a_motion_that_is_not_periodic_has_no_multipliers(tmp_path):
    windowed = scaled(tmp_path, 0.8, 0.05, 0.3, 1, measure={"settle": 0, "duration": 10})
    assert drysim.run(windowed).metrics["multiplier_1"] is None


# Other motions of a run


def warned(outcome) -> list[str]:
    """Return the warnings of a run about other motions."""
    return [one.sentence for one in outcome.warnings if one.slug == "other-motion"]


def test_run_warns_of_the_other_stable_motion_from_either_side(tmp_path):
    scene = paper(tmp_path, 0.5, sweep=None)
    assert "T_a 1.01, stroke 1.745 mm" in warned(drysim.run(scene))[0]
    kicked = paper(tmp_path, 0.5, sweep=None, start={"x_r": 0.02})
    assert "another stable motion exists (T_a 1, stroke 0 mm)" in warned(drysim.run(kicked))[0]


@pytest.mark.parametrize(
    "changes",
    [{"friction__static_ratio": 1.4}, {"friction__static_ratio": 1},
     {"measure": {"coexisting": False}}],
)  # fmt: skip
def test_run_does_not_warn_where_no_other_motion_exists_or_none_is_sought(tmp_path, changes):
    assert not warned(drysim.run(paper(tmp_path, 0.5, sweep=None, **changes)))


# Branches


@pytest.mark.parametrize(("hz", "fold"), [(0.5, 1.38072), (1.0, 1.23209), (1.5916, 1.19776)])
def test_stable_sliding_ends_in_a_fold_while_rest_stays_locked(tmp_path, hz, fold):
    result = drysim.branches(paper(tmp_path, hz))
    (found,) = bifurcations(result, "fold")
    assert found == pytest.approx(fold, abs=6e-6)
    (unlocking,) = bifurcations(result, "unlocking")
    assert unlocking == pytest.approx(math.sqrt(2) * 0.5 * 75 / 45, rel=1e-12)
    locked = result.motions[0]
    assert (locked.branch.is_locked, locked.T_a, locked.stable) == (True, 1.0, True)


@pytest.mark.parametrize(
    ("hz", "value"), [(0.5, 1.3095309342), (1.0, 1.2188633266), (1.5916, 1.1955915412)]
)
def test_sliding_ends_where_the_load_just_reaches_the_static_limit(tmp_path, hz, value):
    # Two stops per period; released at the largest load, F_fs = k_x X + m A.
    (found,) = bifurcations(drysim.branches(paper(tmp_path, hz)), "grazing")
    assert found == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("hz", "peak", "T_a"), [(0.5, 1.745e-3, 1.01034), (1.0, 0.662e-3, 0.998)]
)
def test_both_stable_motions_of_the_paper_are_found_at_the_value_of_the_scenario(
    tmp_path, hz, peak, T_a
):
    result = drysim.branches(paper(tmp_path, hz))
    stable = [one for one in result.motions if one.stable]
    assert [one.branch.kind for one in stable] == ["locked", "symmetric"]
    assert stable[1].x_r_peak == pytest.approx(peak, abs=5e-7)
    assert stable[1].T_a == pytest.approx(T_a, abs=5e-6)


def test_a_motion_whose_branch_turns_back_beyond_the_range_is_found(tmp_path):
    # The stable and the unstable motion are born together at 1.38.
    part = {"friction.static_ratio": {"from": 1.32, "to": 1.37, "step": 0.01}}
    result = drysim.branches(paper(tmp_path, 0.5, sweep=part))
    locked, *sliding = result.branches
    assert locked.is_locked
    assert not result.bifurcations
    assert [bool(one.stable.all()) for one in sliding] == [True, False]
    for one in sliding:
        assert sorted([one.values[0], one.values[-1]]) == [1.32, 1.37]
        assert one.ends == ("range", "range")
    # The value of the scenario is not in the range, so the report has no row for it.
    assert result.stated_value is None
    assert ">motions<" not in drysim.report(result)


def test_symmetry_breaks_where_the_bracket_is_one_and_an_unsymmetric_branch_leaves(tmp_path):
    result = drysim.branches(scaled(tmp_path, *UNSYMMETRIC))
    breaking = [one for one in result.bifurcations if one.kind == "symmetry breaking"]
    assert breaking[-1].value == pytest.approx(0.217466646, abs=1e-8)
    assert breaking[-1].x_r_peak == pytest.approx(1.32333950, abs=1e-7)
    kinds = {one.branch.kind: one for one in result.motions}
    assert kinds["symmetric"].x_r_peak == pytest.approx(1.31807057, abs=1e-8)
    assert not kinds["symmetric"].stable
    assert kinds["unsymmetric"].stable
    assert ">motions<" in drysim.report(result)
    (symmetric,) = [one for one in result.branches if one.kind == "symmetric"]
    at = int(np.argmin(abs(symmetric.values - 0.2)))
    assert abs(symmetric.multipliers[at, 0]) == pytest.approx(1.1088, abs=0.1)


def test_stops_are_born_and_lost_where_two_parametrisations_say(tmp_path):
    sweep = "friction.kinetic: {from: 0.02, to: 0.9, count: 5}"
    result = drysim.branches(scaled(tmp_path, 0.25, 0.05, 0.2, 1, sweep))
    expected = [(0.051111380, 0, 2), (0.229713945, 2, 4), (0.282327218, 4, 2)]
    found = [one for one in result.bifurcations if one.kind == "grazing"]
    for one, (value, before, after) in zip(found, expected, strict=True):
        assert one.value == pytest.approx(value, abs=1e-9)
        assert one.stops == (before, after)


def test_a_continuum_of_orbits_without_damping_is_no_bifurcation(tmp_path):
    sweep = "excitation.frequency: {from: 0.07, to: 0.085, count: 4}"
    result = drysim.branches(scaled(tmp_path, 0.5, 0, 0.2, 1, sweep))
    (value,) = bifurcations(result, "continuum")
    assert value == pytest.approx(1 / (4 * math.pi), rel=1e-6)
    assert not bifurcations(result, "symmetry breaking")


def test_the_only_branch_without_static_excess_is_stable(tmp_path):
    sweep = "excitation.frequency: {from: 0.04, to: 0.4, scale: log, count: 9}"
    result = drysim.branches(scaled(tmp_path, 0.5, 0.05, 0.4, 1, sweep))
    assert len(result.branches) == 1
    assert result.branches[0].stable.all()
    assert result.starts == 18  # from rest, and its own: two motions never move apart


def test_axes_of_ratio_and_stroke_do_not_reach_below_zero(tmp_path):
    sweep = "excitation.frequency: {from: 0.04, to: 1.6, scale: log, count: 9}"
    result = drysim.branches(scaled(tmp_path, 0.5, 0.05, 0.05, 1, sweep))
    ratio = result.branches[0].metrics["T_a"]
    assert ratio.min() < 0.05 * ratio.max()
    assert [panel.get_ylim()[0] for panel in result.plot().axes] == [0.0, 0.0]


def test_rounding_of_a_range_adds_no_branch_and_no_bifurcation(tmp_path):
    # 1.4 is no binary fraction: at its lower end both limits must still be equal.
    short = paper(tmp_path, 1.0, sweep={"friction.static_ratio": [1, 1.2, 1.4]})
    one, other = (
        [each.kind for each in drysim.branches(scene).bifurcations]
        for scene in (short, paper(tmp_path, 1.0))
    )
    assert one == other
    listed = paper(tmp_path, 1.0, sweep={"friction.kinetic": [10, 20, 30]})
    (branch,) = drysim.branches(listed).branches
    assert (branch.values[0], branch.values[-1]) == (10.0, 30.0)


def test_branches_scale_with_base_motion_and_friction(tmp_path):
    sweep = "friction.static_ratio: {from: 1, to: 2, count: 3}"
    scene, tenfold = (
        (0.5, 0.05, 0.6, 1.5, sweep),
        {"friction.kinetic": 6, "excitation.amplitude": 10},
    )
    small, large = (
        drysim.branches(scaled(tmp_path, *scene, overrides=factor)) for factor in ({}, tenfold)
    )
    for a, b in zip(small.bifurcations, large.bifurcations, strict=True):
        assert a.kind == b.kind
        assert a.value == pytest.approx(b.value, rel=1e-9)
        assert 10 * a.x_r_peak == pytest.approx(b.x_r_peak, rel=1e-7)


def test_bifurcations_are_points_of_their_branches(tmp_path):
    result = drysim.branches(scaled(tmp_path, *UNSYMMETRIC))
    for one in result.bifurcations:
        branch = result.branches[one.branch - 1]
        assert branch.values[one.position] == one.value
        assert branch.metrics["x_r_peak"][one.position] == pytest.approx(one.x_r_peak, rel=1e-9)
    symmetric = result.branches[0]
    parts = [(stable, symmetric.values[part]) for stable, part in symmetric.parts()]
    assert [stable for stable, _ in parts] == [True, False, True]
    assert [stable for stable, _ in result.branches[1].parts()] == [True]
    breaking = bifurcations(result, "symmetry breaking")
    assert [parts[1][1][0], parts[1][1][-1]] == breaking


def test_every_point_of_a_branch_repeats(tmp_path):
    result = drysim.branches(paper(tmp_path, 0.5))
    scenario = result.scenario.copy_with({"sweep": ()})
    branch = result.branches[1]
    assert (branch.metrics["energy_residual"] < 1e-9).all()
    for i in range(0, len(branch.values), 20):
        if branch.stable[i]:
            peak = branch.metrics["x_r_peak"][i]
            case = scenario.at({"friction.static_ratio": float(branch.values[i])})
            start = case.start.model_copy(update={"x_r": peak})
            near = drysim.run(case.copy_with({"start": start}))
            assert near.metrics["x_r_peak"] == pytest.approx(peak, rel=1e-8)


# The section


def same_bifurcations(one, other) -> bool:
    """Whether two results have the same branches and bifurcations."""
    assert [each.kind for each in one.branches] == [each.kind for each in other.branches]
    for a, b in zip(one.branches, other.branches, strict=True):
        assert a.ends == b.ends
        ends = (a.values.min(), a.values.max())
        assert (b.values.min(), b.values.max()) == pytest.approx(ends, abs=1e-4)
    listed = [(each.kind, each.branch, {*each.stops}) for each in one.bifurcations]
    assert [(each.kind, each.branch, {*each.stops}) for each in other.bifurcations] == listed
    for a, b in zip(one.bifurcations, other.bifurcations, strict=True):
        assert a.value == pytest.approx(b.value, abs=1e-9)
    return True


@pytest.mark.parametrize("phase", ["30 deg", "160 deg", "275 deg"])
def test_the_phase_of_the_base_motion_changes_nothing(tmp_path, phase):
    scene, shifted = paper(tmp_path, 1.0), paper(tmp_path, 1.0, excitation__phase=phase)
    assert same_bifurcations(drysim.branches(scene), drysim.branches(shifted))


def test_the_phase_changes_nothing_where_the_normal_force_varies(tmp_path):
    # The same motion, begun a tenth of a period later.
    varied = {"amplitude": 0.3, "frequency": 2.0, "phase": 0.2}
    later = {**varied, "phase": 0.2 + 2 * math.tau / 10}
    sweep = {"sweep": {"excitation.rms": [0.9, 1.0]}, "friction.static_ratio": 1}
    one, other = (
        sweep | {"excitation.phase": phase, "friction.normal_variation": variation}
        for phase, variation in ((0.0, varied), (math.tau / 10, later))
    )
    assert same_bifurcations(
        *(drysim.branches(paper(tmp_path, 1.0, overrides=changes)) for changes in (one, other))
    )


class Delayed(Study):
    """Search for branches whose seeds have another section, in a stick or in a slip."""

    def __init__(self, case, phase: float) -> None:
        super().__init__(case.scenario, case.scenario.sweep[0])
        self.phase = phase

    def exact_rows(self, values):
        rows = super().exact_rows(values)
        rows[:, SINES + 2] += self.phase
        return rows


@pytest.mark.parametrize("phase", [0.7, 2.1, 4.0])
def test_branches_do_not_depend_on_the_section(tmp_path, phase):
    for scene in (paper(tmp_path, 1.0), scaled(tmp_path, *UNSYMMETRIC)):
        case = prepare_branches(scene)
        assert same_bifurcations(drysim.branches(scene), Delayed(case, phase).solve(case))


def test_a_branch_passes_a_sharp_corner_where_a_stop_is_lost_and_merges_again(tmp_path):
    # Beyond the corner the state changes in the opposite direction while the key goes on.
    sweep = "excitation.frequency: {from: 0.08, to: 0.1, count: 3}"
    result = drysim.branches(scaled(tmp_path, 0.3, 0.02, 0.3, 2, sweep))
    (unsymmetric,) = [one for one in result.branches if one.kind == "unsymmetric"]
    assert unsymmetric.ends == ("merged", "merged")
    assert [stable for stable, _ in unsymmetric.parts()] == [True]
    (corner,) = [one for one in result.bifurcations if one.branch == unsymmetric.number]
    assert {*corner.stops} == {1.0, 2.0}
    ends = bifurcations(result, "symmetry breaking") + bifurcations(result, "grazing")[-1:]
    found = [unsymmetric.values.min(), unsymmetric.values.max()]
    assert found == pytest.approx(ends, abs=1e-7)


# What is missing


def warned_of(result) -> dict[str, str]:
    """Return slugs and sentences of the warnings of a result."""
    return {one.slug: one.sentence for one in result.warnings}


@pytest.fixture
def lost(monkeypatch):
    """Let the continuation fail in the upper half of the range, where no start is."""
    monkeypatch.setattr(Study, "seed_values", 2)
    step = Continuation.step

    def failing(self, last, ds):
        return None if last.p > 0.5 else step(self, last, ds)

    monkeypatch.setattr(Continuation, "step", failing)


@pytest.mark.usefixtures("lost")
def test_a_branch_that_is_lost_is_not_called_grazing(tmp_path):
    result = drysim.branches(paper(tmp_path, 0.5))
    assert not bifurcations(result, "grazing")
    assert result.branches[1].ends == ("range", "limit")
    ((slug, sentence),) = warned_of(result).items()
    assert slug == "branch-lost"
    assert sentence.startswith("the continuation failed at 1 place (1.25")


def test_starts_that_do_not_settle_are_warned_of(tmp_path, monkeypatch):
    seeds = Study.seeds
    monkeypatch.setattr(Study, "seeds", lambda *words: seeds(*words)._replace(lost=2))
    result = drysim.branches(paper(tmp_path, 0.5))
    assert "2 of " in warned_of(result)["starts-not-settled"]


def test_a_branch_with_too_many_points_is_warned_of(tmp_path, monkeypatch):
    monkeypatch.setattr(Study, "max_branch_points", 40)
    monkeypatch.setattr(Study, "seed_values", 2)
    result = drysim.branches(paper(tmp_path, 0.5))
    assert result.branches[1].ends == ("range", "limit")
    assert "40 points did not suffice at 1 place" in warned_of(result)["branch-too-long"]


@pytest.mark.parametrize(
    ("name", "value", "slug"),
    [("MAX_PERIODS", 0, "periods-left-out"), ("SWITCH_OFFSETS", (), "branching-failed")],
)
def test_bifurcations_that_are_not_followed_are_warned_of(
    tmp_path, monkeypatch, name, value, slug
):
    monkeypatch.setattr(continuation, name, value)
    monkeypatch.setattr(Study, "seed_values", 2)
    sweep = "friction.kinetic: {from: 0.05, to: 0.45, count: 2}"
    result = drysim.branches(scaled(tmp_path, 0.5, 0.05, 0.2, 2, sweep))
    assert "at 2 places (0.157119 N and 0.217467 N)" in warned_of(result)[slug]


def test_motions_without_a_branch_are_warned_of(tmp_path, monkeypatch):
    monkeypatch.setattr(Continuation, "isolate", lambda *arguments: None)
    result = drysim.branches(paper(tmp_path, 0.5))
    assert [one.kind for one in result.branches] == ["locked"]
    sentence = warned_of(result)["motions-left-out"]
    assert sentence.startswith("stable motions at 13 places (1, 1.03125, 1.0625, 1.09375 and")


def test_branches_beyond_the_largest_number_are_warned_of(tmp_path, monkeypatch):
    monkeypatch.setattr("drysim.study.branches.MAX_BRANCHES", 0)
    assert "branches-left-out" in warned_of(drysim.branches(paper(tmp_path, 0.5)))


# Command, files and faults


def test_command_writes_branches_bifurcations_and_picture(command, tmp_path):
    result = drysim.branches(paper(tmp_path, 1.0))
    done = command("branches", "seat.yaml", "-o", "out")
    assert done.code == 0, done.err
    assert "at 1.2: stable, locked: T_a 1" in done.out
    out = tmp_path / "out"
    assert (out / "branches.png").is_file()
    rows, points = rows_of(out / "bifurcations.csv"), rows_of(out / "branches.csv")
    assert [row["bifurcation"] for row in rows] == ["unlocking", "grazing", "fold"]
    assert len(points) == fields_of(out)["numerics"]["points"]
    assert {row["stable [-]"] for row in points} == {"0.0", "1.0"}
    again = drysim.load(out / "scenario.yaml")
    assert drysim.branches(again).bifurcations == result.bifurcations


NOISE = {"kind": "standard", "class": "EM1", "duration": "10 s", "seed": 1}


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"sweep": None}, "sweep is required"),
     ({"excitation": NOISE, "measure": {"settle": 0}},
      "branches needs base motion that is a sine"),
     ({"sweep": {"start.x_r": [0.0, 0.1]}}, "branches follows the first key of the sweep"),
     ({"measure": {"settle": 0, "duration": 10}}, "needs a steady state"),
     ({"sweep": {"excitation.phase": [0, 1]}}, "a phase only shifts the time"),
     ({"sweep": {"zip": {"oscillator.mass": [50, 100], "friction.kinetic": [10, 20]}}},
      "values that vary together"),
     ({"sweep": {"friction.static_ratio": [1, 1.2], "direction": "up"}},
      "sweep.direction does not apply")],
)  # fmt: skip
def test_scenes_without_branches_are_refused_with_the_reason(tmp_path, changes, words):
    with pytest.raises(drysim.ScenarioError) as fault:
        drysim.branches(paper(tmp_path, 1.0, overrides=changes))
    assert words in str(fault.value) + str(fault.value.problems)


def test_weighted_metrics_are_left_out_as_checks_are(tmp_path):
    changes = {"measure": {"direction": "vertical"}, "checks": ["SEAT < 0.9"]}
    result = drysim.branches(paper(tmp_path, 1.0, overrides=changes))
    assert result.branches
    assert [verdict.passed for verdict in result.checks] == [None]
    assert not result.warnings


def test_further_keys_of_the_sweep_are_told_to_stay(tmp_path):
    further = "  friction.kinetic: [30, 45]\n  excitation.frequency: [0.4, 0.5]\n"
    result = drysim.branches(load_text(tmp_path, PAPER.replace("HZ", "0.5") + further))
    told = warned_of(result)["one-key"]
    assert told.startswith("branches follows friction.static_ratio only; it keeps friction.kin")
    assert "45 N" in told
    assert "0.5 Hz" in told
    assert result.axis.key == "friction.static_ratio"


def test_orbit_of_three_periods_that_half_of_them_mirrors_is_symmetric(tmp_path):
    beta, zeta, phi, eta = 0.45319397252152915, 0.02481257246398982, 0.1060622599005986, 2.52
    sweep = "friction.static_ratio: {from: 2.51, to: 2.53, count: 5}"
    scene = scaled(tmp_path, beta, zeta, phi, eta, sweep, start={"x_r": 0.665, "v_r": -0.663})
    outcome = drysim.run(scene.copy_with({"sweep": ()}))
    period, trajectory = math.tau / beta, outcome.response.trajectory
    assert trajectory.end == pytest.approx(3.0 * period)
    for t in (0.0, 0.3 * period, 0.8 * period, 1.2 * period):
        later = trajectory.state(t + 1.5 * period).x_r
        assert later == pytest.approx(-trajectory.state(t).x_r, abs=1e-9)
    (motion,) = drysim.branches(scene).motions
    assert (motion.branch.periods, motion.branch.symmetric) == (3, True)
    assert motion.T_a == pytest.approx(outcome.metrics["T_a"], rel=1e-9)


@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_motion_that_a_run_shows_is_on_a_branch(tmp_path, monkeypatch, phase):
    def only_rest(scenes):
        return np.zeros((1, len(scenes), 2))

    monkeypatch.setattr("drysim.study.other_motions.orbit_starts", only_rest)
    sweep = {"friction.static_ratio": {"from": 1.19, "to": 1.3, "count": 3}}
    at_rest, kicked = (
        paper(tmp_path, 0.5, sweep=sweep, excitation__phase=phase, start={"x_r": x, "v_r": v})
        for x, v in ((0.0, 0.0), (0.005, 0.01))
    )
    shown = drysim.run(kicked.copy_with({"sweep": ()})).metrics
    assert shown["stuck_share"] < 1.0
    others = [motion.T_a for motion in drysim.branches(at_rest).motions]
    assert shown["T_a"] not in others
    assert any(
        motion.T_a == pytest.approx(shown["T_a"], rel=1e-9)
        for motion in drysim.branches(kicked).motions
    )
