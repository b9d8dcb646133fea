"""Sweeps up and down: each case begins where the previous one ended."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from seat import fields_of
from shown import show

from drysim import plot
from drysim.errors import ScenarioError
from drysim.plots.sweep import sweep_view
from drysim.scenario.axes import point_columns
from drysim.scenario.load import load
from drysim.study.compare import compare
from drysim.study.ensemble import run
from drysim.study.plan import CaseRanges, approaches_of, solve_chain, solve_range
from drysim.study.preparation import prepare
from drysim.study.run import MotionCache
from drysim.study.sweep import sweep
from drysim.yaml_document import dump

SEAT = """\
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}
excitation: {kind: harmonic, frequency: 0.5, rms: 0.5}
solver: {step: 2.5e-3}
"""
F_FS, MASS = 54.0, 75.0


@pytest.fixture
def seat(scenario):
    """Return the scenario of a seat with a sweep block, with overrides."""
    return lambda axes, *overrides, text=SEAT: scenario(text + dump({"sweep": axes}), overrides)


def levels(direction, low=0.3, high=0.8, step=0.01):
    """Return a sweep over the level of the base motion."""
    return {"excitation.rms": {"from": low, "to": high, "step": step}, "direction": direction}


def T_a(table, direction):
    """Return T_a along the first axis."""
    rows = [row for row in table.own if row.point["direction"] == direction]
    return np.array([row.metrics["T_a"] for row in rows])


# Physics: where two steady motions exist, history decides.


def test_level_turned_up_breaks_away_at_the_static_limit(seat):
    table = sweep(seat(levels("both")))
    rms = np.array(table.axes[0].values)
    up, down = T_a(table, "up"), T_a(table, "down")
    slides = rms > F_FS / (sqrt(2) * MASS)
    assert (up[~slides] == 1.0).all()
    assert (abs(up[slides] - 1.0) > 1e-2).all()
    at = int(np.argmin(abs(rms - 0.5)))
    assert down[at] == pytest.approx(1.01034, abs=1e-5)
    row = next(r for r in table if r.point == {"excitation.rms": 0.5, "direction": "down"})
    assert row.metrics["x_r_peak"] == pytest.approx(1.745e-3, abs=1e-6)


@pytest.mark.parametrize(
    ("frequency", "fold"), [(0.5, 1.38072), (1.0, 1.23209), (1.5916, 1.19776)]
)
def test_sliding_motion_ends_in_its_fold(seat, frequency, fold):
    axes = {"friction.static_ratio": {"from": 1.15, "to": 1.4, "step": 5e-4}, "direction": "up"}
    table = sweep(seat(axes, f"excitation.frequency={frequency}"))
    stuck = np.array([row.metrics["stuck_share"] for row in table])
    first = table.axes[0].values[int(np.argmax(stuck == 1.0))]
    assert fold - 1e-5 < first < fold + 5e-4 + 1e-5


def test_directions_agree_where_the_orbit_is_unique(seat):
    table = sweep(seat(levels("both"), "friction.static_ratio=1"))
    assert T_a(table, "up") == pytest.approx(T_a(table, "down"), rel=1e-9)
    assert table.hysteresis == ()


def test_stuck_position_is_carried_over(seat):
    table = sweep(seat(levels("down")))
    offsets = [r.metrics["x_r_peak"] for r in table.own if r.metrics["stuck_share"] == 1.0]
    assert len(offsets) > 10
    assert offsets[0] > 1e-4
    assert offsets == pytest.approx([offsets[0]] * len(offsets), rel=1e-12)


def test_first_case_of_each_chain_starts_from_the_start(seat):
    table = sweep(seat(levels("both"), "start.x_r=1e-3"))
    for at, direction in ((0.3, "up"), (0.8, "down")):
        point = {"excitation.rms": at, "direction": direction}
        row = next(row for row in table if row.point == point)
        alone = run(seat(levels("both"), "start.x_r=1e-3").at({"excitation.rms": at}))
        assert row.metrics["x_r_rms"] == pytest.approx(alone.metrics["x_r_rms"], rel=1e-9)


# The order of the cases, and the state that is carried over.


def test_other_keys_have_chains_of_their_own(seat):
    axes = {"excitation.rms": [0.7, 0.5, 0.45], "friction.static_ratio": [1.2, 1.0]}
    axes["direction"] = "down"
    scenario = seat(axes)
    table = sweep(scenario)
    assert [row.point["excitation.rms"] for row in table] == [0.7, 0.5, 0.45] * 2
    alone = sweep(seat(axes | {"friction.static_ratio": [1.2]}))
    assert [row.metrics for row in alone] == [row.metrics for row in table][:3]
    assert len(CaseRanges(approaches_of(scenario))) == 2


def test_order_of_the_list_does_not_matter(seat):
    values = [0.45, 0.7, 0.3, 0.5]
    table = sweep(seat({"excitation.rms": values, "direction": "up"}))
    other = sweep(seat({"excitation.rms": sorted(values), "direction": "up"}))
    by_level = {row.point["excitation.rms"]: row.metrics for row in table}
    assert [by_level[value] for value in sorted(values)] == [row.metrics for row in other]


def test_chain_of_orbits_is_that_of_single_cases(seat):
    (one,) = CaseRanges(approaches_of(seat(levels("down"))))
    together = solve_range(one, MotionCache())
    alone = solve_chain(one, MotionCache(), lambda: False)
    for name in ("T_a", "x_r_peak", "x_r_rms", "stuck_share"):
        np.testing.assert_allclose(together.metrics[name], alone.metrics[name], rtol=1e-9)
    points = point_columns(one.scenario.sweep, one.begin, one.end)
    assert set(points["direction"].tolist()) == {"down"}


def test_window_begins_with_the_last_state_of_the_previous_one(seat):
    settings = ("measure.settle=0", "measure.duration=1.3")
    table = sweep(seat({"excitation.rms": [0.6, 0.8], "direction": "up"}, *settings))
    first = run(seat(levels("up"), *settings).at({"excitation.rms": 0.6}))
    state = first.response.trajectory.state(1.3)
    begun = (f"start.x_r={state.x_r!r}", f"start.v_r={state.v_r!r}")
    second = run(seat(levels("up"), *settings, *begun).at({"excitation.rms": 0.8}))
    assert state.x_r != 0.0
    for name in ("T_a", "x_r_peak", "x_r_rms"):
        assert table[1].metrics[name] == pytest.approx(second.metrics[name], rel=1e-9)


@pytest.mark.parametrize(
    "friction",
    [
        "{law: jenkins, kinetic: 45, tangential_stiffness: 1e5}",
        "{law: stribeck, kinetic: 45, static_ratio: 1.2, stribeck_velocity: 0.01}",
        "{law: coulomb, kinetic: {extension: 45, compression: 40}}",
    ],
)
def test_other_laws_and_approaches_are_swept_up_and_down(seat, friction):
    table = sweep(
        seat({"excitation.rms": [0.3, 0.6, 0.9], "direction": "both"}, f"friction={friction}")
    )
    assert {row.status for row in table} == {"ok"}
    assert table.hysteresis is not None


def test_reference_without_friction_has_no_direction(seat):
    table = sweep(seat(levels("both", step=0.1), "reference=viscous"))
    assert [tally.cases for tally in table.tallies.values()] == [12, 6]
    assert all("direction" not in row.point for row in table.of("viscous"))
    other = sweep(seat(levels("both", step=0.1), "reference=moreau", "friction.static_ratio=1"))
    assert [tally.cases for tally in other.tallies.values()] == [12, 12]


def test_resolved_scenario_has_the_same_sweep(seat, tmp_path):
    scenario = seat(levels("both"))
    (tmp_path / "again.yaml").write_text(dump(scenario.resolved()))
    again = load(tmp_path / "again.yaml")
    assert again.sweep == scenario.sweep
    assert again.resolved()["sweep"]["direction"] == "both"
    assert seat(levels("both"), "sweep.direction=null").sweep == scenario.sweep[:1]


# What is shown.


def test_hysteresis_says_where_the_directions_differ(seat, capsys):
    table = sweep(seat(levels("both")))
    (found,) = table.hysteresis
    assert (found.low, found.high) == (0.48, 0.5)
    assert found.point == {"excitation.rms": 0.5}
    assert found.gap == pytest.approx(0.01034, abs=1e-5)
    show(table)
    shown = " ".join(capsys.readouterr().out.split())
    assert "hysteresis 0.48 to 0.5 m/s² T_a 1 up against 1.0103 down at rms 0.5" in shown
    assert sweep(seat(levels("up"))).hysteresis is None


def test_lines_of_a_picture_tell_the_directions_apart(seat):
    axes = {"excitation.rms": [0.3, 0.5, 0.8], "friction.static_ratio": [1.0, 1.2, 1.3]}
    table = sweep(seat(axes | {"direction": "both"}))
    (panel,) = sweep_view(table).panels
    assert [line.direction for line in panel.lines] == ["up", "down"] * 3
    curves = plot(table).axes[0].lines
    drawn = {line.get_label(): line for line in curves}
    words = [name for name in drawn if name.startswith("direction")]
    assert len(words) == 6
    up, down = (drawn[name] for name in words[:2])
    assert up.get_color() == down.get_color()
    assert up.get_linestyle() == "-"
    assert down.get_linestyle() == "--"


def test_files_tell_the_directions_apart(drysim, seat, tmp_path):
    seat(levels("both", step=0.1))
    assert drysim("sweep", "seat.yaml", "-q", "--no-plots", "-o", "out").code == 0
    head, *rows = (tmp_path / "out" / "transmissibility.csv").read_text().splitlines()
    assert head.startswith("approach,excitation.rms [m/s2],direction,F_fk [N]")
    assert [row.split(",")[2] for row in rows] == ["up"] * 6 + ["down"] * 6
    kept = fields_of(tmp_path / "out")
    (found,) = kept["hysteresis"]
    assert found["key"] == "excitation.rms"
    assert found["from"] == found["to"] == 0.5
    assert found["T_a"]["up"] == 1.0
    assert found["T_a"]["down"] == pytest.approx(1.01034, abs=1e-5)
    assert found["where"] == {"excitation.rms": 0.5}


# What is refused.


NOISE = "kind: psd, points: [[1, 1], [9, 1]], duration: 9, seed: 1"
SAMPLE = {"kind": "latin", "count": 3, "seed": 1}
SAMPLE["over"] = {"excitation.rms": {"from": 0.1, "to": 1}}


@pytest.mark.parametrize(
    ("axes", "overrides", "sentence"),
    [
        (levels("sideways"), (), "sweep.direction must be up, down or both, not `sideways`"),
        ({"direction": "up"}, (), "sweep.direction needs a key to vary"),
        ({"start.x_r": [0.0, 1e-3], "direction": "up"}, (), "start.x_r, the first key"),
        ({"sample": SAMPLE, "direction": "up"}, (), "are random and have no order"),
        (
            {"friction.kinetic": [10, 20], "direction": "up"},
            (f"excitation={{{NOISE}, seeds: 3}}",),
            "needs a single seed",
        ),
        (
            {"excitation.seed": [1, 2], "direction": "up"},
            (f"excitation={{{NOISE}}}",),
            "excitation.seed, the first key, have no order",
        ),
        (
            {"friction.kinetic": [10, 20], "direction": "up"},
            ("excitation={kind: rest}", "measure.duration=1"),
            "is not possible for rest",
        ),
        (
            {"stroke.limit": [0.01, 0.02], "direction": "up"},
            ("stroke={limit: 0.02, stops: {restitution: 0.5}}",),
            "rigid stops",
        ),
        (levels("up", 0.1, 0.9, 1e-6), (), "more than 100000"),
    ],
)
def test_sweep_that_has_no_order_is_refused_in_its_place(seat, axes, overrides, sentence):
    with pytest.raises(ScenarioError) as fault:
        seat(axes, *overrides)
    (problem,) = fault.value.problems
    assert sentence in problem.sentence
    assert problem.line == len(SEAT.splitlines()) + len(dump({"sweep": axes}).splitlines())


def test_records_have_no_order(seat, tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("t [s],u_dd [m/s2]\n0,0\n0.1,1\n0.2,0\n")
    text = (
        SEAT.partition("excitation")[0] + "excitation: {kind: record, file: a.csv, time: t}\n"
    )
    with pytest.raises(ScenarioError, match="1 error") as fault:
        seat({"excitation.file": ["a.csv", "b.csv"], "direction": "up"}, text=text)
    assert "excitation.file, the first key, have no order" in fault.value.problems[0].sentence
    axes = {"friction.kinetic": [10, 20], "excitation.file": ["a.csv", "b.csv"]}
    table = sweep(seat(axes | {"direction": "up"}, text=text))
    assert len(table) == 4


def test_comparison_and_bench_are_refused(drysim, seat):
    scenario = seat(levels("both"))
    with pytest.raises(ScenarioError) as fault:
        compare(scenario, ["signum", "stick-slip"])
    assert "drysim compare" in fault.value.problems[0].sentence
    assert drysim("compare", "signum", "vs", "viscous", "-s", "seat.yaml").code == 2
    assert drysim("bench", "seat.yaml", "--steady").code == 2
    assert prepare(scenario, swept=True).period == 2.0
