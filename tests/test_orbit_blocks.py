"""Many orbits in one call are what each of them is by itself, rules and statuses included."""

from __future__ import annotations

import pytest

from drysim.errors import ScenarioError
from drysim.scenario.axes import columns_of, points
from drysim.scenario.load import load
from drysim.scenario.model import columned
from drysim.study.run import Job, Motions, row_of
from drysim.study.sweep import sweep

BASE = """\
drysim: 1
name: block
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
"""

SWEEPS = {
    "oscillator": "oscillator.mass: [60, 90]\n  oscillator.stiffness: [0, 5000]\n"
    "  oscillator.damping: [20, 5000]",
    "friction": "friction.kinetic: [0, 15, 200]\n  friction.static_ratio: [1, 1.3]",
    "limit": "stroke.limit: [0.004, 0.1]\n  excitation.frequency: [0.9, 1.6, 8]",
    "start": "start.x_r: [0, 0.02]\n  start.v_r: [-0.2, 0]\n  excitation.phase: [0, 1]",
}


def case_by_case(scenario):
    """Give the rows of a sweep, each solved by itself."""
    motions = Motions()
    return [row_of(Job(i, scenario, p), motions) for i, p in enumerate(points(scenario.sweep))]


def same(table, scenario):
    """Tell whether a sweep gives what its cases give one by one, to the last bit."""
    alone = case_by_case(scenario)
    assert [row.status for row in table] == [row.status for row in alone]
    for row, other in zip(table, alone, strict=True):
        assert dict(row.point) == dict(other.point)
        assert dict(row.metrics) == {name: other.metrics.get(name) for name in row.metrics}
        assert (row.F_fk, row.F_fs, row.note) == (other.F_fk, other.F_fs, other.note)


@pytest.mark.parametrize("keys", SWEEPS)
def test_block_of_a_sweep_is_what_its_cases_are_alone(tmp_path, keys):
    file = tmp_path / "block.yaml"
    file.write_text(f"{BASE}sweep:\n  {SWEEPS[keys]}\n")
    scenario = load(file)
    same(sweep(scenario), scenario)


def test_coefficients_of_friction_are_swept_in_blocks(tmp_path):
    file = tmp_path / "block.yaml"
    coefficients = BASE.replace("kinetic: 15", "mu_kinetic: 0.01, mu_static: 0.03")
    file.write_text(
        f"{coefficients}sweep:\n  friction.mu_kinetic: [0, 0.02]\n"
        "  friction.mu_static: [0.02, 0.03]\n  friction.normal: [600, 900]\n"
        "  oscillator.mass: [60, 90]\n"
    )
    scenario = load(file)
    same(sweep(scenario), scenario)


def test_sums_of_sines_and_varying_limits_are_solved_in_blocks(tmp_path):
    file = tmp_path / "block.yaml"
    sines = "{kind: sines, components: [{frequency: 1.2, rms: 1}, {frequency: 2.4, rms: 0.4}]}"
    text = BASE.replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", sines)
    varied = "15, normal_variation: {amplitude: 0.3, frequency: 0.6}}"
    file.write_text(
        f"{text.replace('15}', varied)}measure: {{steady: true}}\nsweep:\n"
        "  excitation.components.0.frequency: [0.6, 1.8]\n"
        "  friction.normal_variation.amplitude: [0, 0.3]\n"
        "  friction.normal_variation.frequency: [0.3, 1.2]\n"
    )
    scenario = load(file)
    same(sweep(scenario), scenario)


def test_undamped_orbits_keep_their_statuses(tmp_path):
    file = tmp_path / "block.yaml"
    file.write_text(
        BASE.replace("damping: 500", "damping: 0")
        + "sweep:\n  excitation.frequency: [0.795774715459, 1.591549430918954]\n"
        + "  friction.kinetic: [1, 40]\n"
    )
    scenario = load(file)
    table = sweep(scenario)
    assert {row.status for row in table} > {"ok", "not settled"}
    same(table, scenario)


def test_values_that_do_not_go_together_are_refused_in_their_block(tmp_path):
    file = tmp_path / "block.yaml"
    axis = "{from: 10, to: 30, count: 110}"
    static = BASE.replace("kinetic: 15}", "kinetic: 15, static: 30}")
    file.write_text(f"{static}sweep:\n  friction.kinetic: {axis}\n  friction.static: {axis}\n")
    with pytest.raises(ScenarioError) as fault:
        sweep(load(file))
    assert "must be at least the kinetic" in fault.value.problems[0].sentence
    assert fault.value.problems[0].line == 9


def test_columns_walk_as_the_points_do(tmp_path):
    file = tmp_path / "block.yaml"
    file.write_text(f"{BASE}sweep:\n  {SWEEPS['start']}\n")
    axes = load(file).sweep
    every = list(points(axes))
    columns = columns_of(axes, 3, 7)
    assert [{k: column[i] for k, column in columns.items()} for i in range(4)] == every[3:7]


def test_columned_scenario_gives_columns_of_symbols(tmp_path):
    file = tmp_path / "block.yaml"
    file.write_text(
        BASE.replace("damping: 500", "damping_ratio: 0.3")
        + f"sweep:\n  {SWEEPS['friction']}\n  oscillator.mass: [60, 90]\n"
    )
    scenario = load(file)
    case = columned(scenario, columns_of(scenario.sweep, 0, 12))
    alone = [scenario.at(point) for point in points(scenario.sweep)]
    assert case.oscillator.plant().b.tolist() == [one.oscillator.plant().b for one in alone]
    assert case.law().F_fs.tolist() == [one.law().F_fs for one in alone]
