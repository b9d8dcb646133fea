"""Motions that are followed period by period until they repeat themselves."""

from __future__ import annotations

import numpy as np
import pytest
from law_scenes import elastic_law, stopped_law
from periods import draw_steady_scene

from drysim.approach import taylor
from drysim.approach.solution import Orbit
from drysim.core.model import (
    BRISTLE,
    STRIBECK,
    ContactState,
    DynamicLaw,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
)
from drysim.errors import ScenarioError
from drysim.orbits import search
from drysim.orbits.search import STEP_THRESHOLD, OrbitConvergence
from drysim.scenario.axes import iter_points, point_columns
from drysim.study.ensemble import run
from drysim.study.run import MotionCache, solve_row
from drysim.study.sweep import sweep

FAINT = Plant(80.0, 6000.0, 2.0 * 0.01 * (6000.0 * 80.0) ** 0.5)
DAHL = DynamicLaw(3.0, 3.0, BRISTLE, sigma_0=1e3)
SINE = Sines((0.5 * 2.0**0.5,), (1.3,), (0.0,))
PERIOD = 1.0 / 1.3

SCENE = """\
drysim: 1
oscillator: {mass: 80, stiffness: 6000, damping_ratio: 0.01}
friction: {law: dahl, kinetic: 3, bristle_stiffness: 1 kN/m}
excitation: {kind: harmonic, frequency: 1.3 Hz, rms: 0.5 m/s2}
solver: {step: 10 ms}
"""


def follow(matrix, fixed, state, convergence):
    """Close a linear map; give the states that were followed."""
    states = [state]
    while len(states) < 400:
        end = State(*(fixed + matrix @ (np.array(states[-1]) - fixed)).tolist())
        convergence.add(end, [1.0, 1.0])
        if convergence.repetition()[0] <= convergence.closed:
            return [*states, end]
        states.append(convergence.next_state())
    return states


def test_changes_of_a_linear_map_are_summed_to_where_they_end():
    matrix, fixed = np.array([[0.9, 0.2], [-0.3, 0.85]]), np.array([0.3, -0.2])
    states = follow(matrix, fixed, State(0.35, -0.1), OrbitConvergence(1e-13))
    plain = np.log(1e-12) / np.log(np.abs(np.linalg.eigvals(matrix)).max())
    assert len(states) < 0.2 * plain
    np.testing.assert_allclose(states[-1], fixed, rtol=0.0, atol=1e-12)


def test_motion_that_grows_is_not_moved_on():
    convergence = OrbitConvergence(1e-13)
    states = follow(1.01 * np.eye(2), np.zeros(2), State(1e-6, 1e-6), convergence)
    np.testing.assert_allclose(states[-1], 1e-6 * 1.01**399, rtol=1e-12)


@pytest.mark.parametrize("periods", [3, 10, 37, 64])
def test_repetition_of_up_to_64_periods_is_found(periods):
    convergence, draw = OrbitConvergence(1e-12), np.random.default_rng(periods)
    states = [State(*draw.uniform(-1.0, 1.0, 2)) for _ in range(periods)]
    for state in [*states, *states]:
        convergence.add(state, [1.0, 1.0])
    change, multiple = convergence.repetition()
    assert (change, multiple) == (0.0, periods)


def test_motion_that_circles_in_on_its_orbit_is_not_taken_for_a_long_repetition():
    """Ten periods are a whole turn, over which the motion changes ten thousand times less."""
    convergence, turn = OrbitConvergence(1e-12), 2.0 * np.pi / 10.0
    for n in range(100):
        size = 1e-9 * (1.0 - 1e-5) ** n
        convergence.add(State(size * np.cos(n * turn), size * np.sin(n * turn)), [1.0, 1.0])
    assert convergence.repetition()[0] > convergence.closed


def test_orbit_of_ten_periods_between_stops_is_found():
    F_fk, f = 0.11999109888519495, 0.07957747154594767
    law = stopped_law(F_fk, 5.0 * F_fk, 10.0, e=0.5)
    motion = Sines((1.0,), (f,), (0.6791759369443524,))
    start = State(0.0, -0.5202476676680174)
    orbit = search.find_orbit(Plant(1.0, 1.0, 0.002), law, motion, start, 1.0 / f)
    assert (orbit.settled, orbit.periods) == (True, 10)


def test_sum_that_does_not_come_true_is_taken_back():
    convergence = OrbitConvergence(1e-13)
    for share in (0.0, 1 / 2, 3 / 4, 7 / 8, 15 / 16):
        convergence.add(State(share * STEP_THRESHOLD, 0.0), [1.0, 1.0])
        next_state = convergence.next_state()
    assert next_state.x_r == pytest.approx(STEP_THRESHOLD, rel=1e-12)
    convergence.add(State(next_state.x_r + STEP_THRESHOLD, 0.0), [1.0, 1.0])
    assert convergence.next_state() == State(15 * STEP_THRESHOLD / 16, 0.0)


def test_orbit_of_a_faintly_damped_plant_is_where_many_periods_lead():
    orbit = search.find_orbit(FAINT, DAHL, SINE, ContactState(0.0, 0.0, 0.0), PERIOD)
    state = ContactState(0.0, 0.0, 0.0)
    for _ in range(500):
        state = taylor.compute_trajectory(FAINT, DAHL, SINE, state, PERIOD).state(PERIOD)
    assert orbit.settled
    assert orbit.run_up < 100 * PERIOD
    np.testing.assert_allclose(orbit.state[:3], state[:3], rtol=1e-11)


def test_orbit_of_a_contact_is_one_that_was_followed():
    law = elastic_law(30.0, 1e5)
    orbit = search.find_orbit(FAINT, law, SINE, ContactState(0.0, 0.0, 0.0), PERIOD)
    again = search.march_period(FAINT, law, SINE, orbit.state, PERIOD).state(PERIOD)
    np.testing.assert_allclose(again[:3], orbit.state[:3], rtol=1e-10)


NEXT_TO_NONE = {
    "dahl": DynamicLaw(1e-14, 1e-14, BRISTLE, sigma_0=1.0),
    "stribeck": DynamicLaw(1e-14, 1e-14, STRIBECK),
    "contact that holds": elastic_law(100.0, 1.0),
}
"""Laws that take next to nothing from a motion within metres [N, N/m]."""


def at_half_its_natural_frequency(
    law: PiecewiseLaw | DynamicLaw, xi: float
) -> tuple[Orbit, float]:
    """Return the orbit reached from rest, and its distance from -(m A/k)/(1 - 1/4) sin."""
    k = 1.0 + (law.k_t if law.is_elastic else 0.0)
    period = 4.0 * np.pi / k**0.5
    plant = Plant(1.0, 1.0, 2.0 * xi * k**0.5)
    sine = Sines((1.0,), (1.0 / period,), (0.0,))
    orbit = search.find_orbit(plant, law, sine, ContactState(0.0, 0.0, 0.0), period)
    fastest = 2.0 * np.pi / period / k / 0.75
    return orbit, abs(orbit.state.v_r / fastest + 1.0)


@pytest.mark.parametrize("law", NEXT_TO_NONE.values(), ids=NEXT_TO_NONE)
def test_motion_that_repeats_itself_because_nothing_stills_it_is_one_of_a_continuum(law):
    # From rest the free oscillation, as large, goes on for ever and repeats itself, too.
    orbit, off = at_half_its_natural_frequency(law, 1e-15)
    assert off > 0.1
    assert orbit.settled
    assert not orbit.unique


def test_changes_that_fall_by_less_than_rounding_tells_are_not_summed(monkeypatch):
    # A sum of them had put a contact on a motion 210 times as large.
    monkeypatch.setattr(search, "MAX_PERIODS", 200)
    orbit, off = at_half_its_natural_frequency(NEXT_TO_NONE["contact that holds"], 1e-13)
    assert off < 1.1
    assert not orbit.settled


@pytest.mark.parametrize("law", NEXT_TO_NONE.values(), ids=NEXT_TO_NONE)
def test_orbit_that_a_little_damping_leads_to_is_the_only_one(law):
    orbit, off = at_half_its_natural_frequency(law, 2e-4)
    assert off < 1e-6
    assert orbit.settled
    assert orbit.unique


@pytest.mark.parametrize("tolerance", [1e-12, 1e-8, 1e-6])
def test_stated_error_of_an_orbit_holds_what_its_closure_leaves(scenario, tolerance):
    loose = run(scenario(SCENE, {"friction.tolerance": tolerance}))
    exact = run(scenario(SCENE, {"friction.tolerance": 1e-14}))
    peak = exact.metrics["x_r_peak"]
    assert abs(loose.metrics["x_r_peak"] / peak - 1.0) <= loose.response.numerics.error
    assert loose.response.numerics.error < 1e5 * tolerance


def test_contact_that_ends_up_holding_keeps_where_it_yielded_last():
    # Before it holds for good it yields a little less in each period, and where that leaves it
    # no sum of changes tells: one had put its force off by a sixth of the limit.
    m, contact = Plant(1.0, 100.0, 1.0484), elastic_law(0.1401529, 48.42263)
    motion, period = Sines((1.0,), (23.833 / (2 * np.pi),), (0.0,)), 2 * np.pi / 23.833
    start = state = State(-0.0167221, -0.0871299)
    for _ in range(300):
        state = search.march_period(m, contact, motion, state, period).state(period)
    orbit = search.find_orbit(m, contact, motion, start, period)
    assert orbit.settled
    np.testing.assert_allclose(orbit.state[:3], state[:3], rtol=0.0, atol=1e-13)


# Newton steps, of laws in closed form.


@pytest.mark.parametrize(
    "kind",
    [
        "friction by direction",
        "damper by direction",
        "jenkins",
        "petrov",
        "bumpers",
        "rigid stops",
    ],
)
def test_newton_steps_lead_to_the_orbit_of_the_march_in_fewer_periods(kind, monkeypatch):
    march, marched = search.march_period, [0]

    def counted(*scene):
        marched[0] += 1
        return march(*scene)

    def orbits_and_marches():
        marched[0], orbits = 0, []
        for seed in range(4):
            scene, start = draw_steady_scene(kind, seed)
            orbits.append(
                search.find_orbit(scene.plant, scene.law, scene.motion, start, scene.period)
            )
        return orbits, marched[0]

    monkeypatch.setattr(search, "march_period", counted)
    by_steps, fewer = orbits_and_marches()
    monkeypatch.setattr(OrbitConvergence, "newton", lambda *_: None)
    as_it_is, more = orbits_and_marches()
    assert fewer < 0.8 * more
    for one, other in zip(by_steps, as_it_is, strict=True):
        assert (one.settled, one.unique, one.periods) == (True, True, other.periods)
        off = abs(one.state.x_r - other.state.x_r) / one.run_up_peak
        assert one.periods > 1 or off <= 4.0 * (one.distance + other.distance)


A, F = 1.0, 0.5
RESONANT = {
    "stribeck": DynamicLaw(F, F, STRIBECK),
    "stribeck, loosely": DynamicLaw(F, F, STRIBECK, tolerance=5e-4),
    "jenkins": elastic_law(F, 1e6),
    "dahl": DynamicLaw(F, F, BRISTLE, sigma_0=1e6),
}
"""Laws that take F |v_r| from an oscillation that is far larger than their contacts bend."""


@pytest.mark.parametrize("law", RESONANT.values(), ids=RESONANT)
def test_resonance_without_damper_grows_as_followed_and_is_told_as_not_settled(
    law, monkeypatch
):
    # A sum of its even changes put it at 1e9 m, where a metre a period passed for an orbit.
    monkeypatch.setattr(search, "MAX_PERIODS", 24)
    plant, period, large = Plant(1.0, 1.0, 0.0), 2 * np.pi, 600.0
    sine = Sines((A,), (1.0 / period,), (0.0,))
    orbit = search.find_orbit(plant, law, sine, ContactState(large, 0.0, 0.0), period)
    assert not orbit.settled
    assert orbit.unique
    grown = (A - 4.0 * F / np.pi) * orbit.run_up / 2.0
    assert orbit.state.x_r - large == pytest.approx(grown, rel=1e-2)
    assert orbit.run_up_peak == pytest.approx(orbit.state.x_r, abs=1.0)


# Many orbits in one call are what each of them is by itself, rules and statuses included.


BASE = """\
drysim: 1
name: block
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {approach: stick-slip, step: 2.5e-3}
"""

COEFFICIENTS = BASE.replace("kinetic: 15", "mu_kinetic: 0.01, mu_static: 0.03")
SINES = "{kind: sines, components: [{frequency: 1.2, rms: 1}, {frequency: 2.4, rms: 0.4}]}"
VARIED = "15, normal_variation: {amplitude: 0.3, frequency: 0.6}}"
SUM_OF_SINES = BASE.replace("15}", VARIED) + "measure: {steady: true}\n"
SUM_OF_SINES = SUM_OF_SINES.replace("{kind: harmonic, frequency: 1.6, rms: 1.0}", SINES)
VARYING = (
    "friction.normal_variation.amplitude: [0, 0.3]\n"
    "  friction.normal_variation.frequency: [0.3, 1.2]"
)
SWEEPS = {
    "oscillator": "oscillator.mass: [60, 90]\n  oscillator.stiffness: [0, 5000]\n"
    "  oscillator.damping: [20, 5000]",
    "friction": "friction.kinetic: [0, 15, 200]\n  friction.static_ratio: [1, 1.3]",
    "limit": "stroke.limit: [0.004, 0.1]\n  excitation.frequency: [0.9, 1.6, 8]",
    "start": "start.x_r: [0, 0.02]\n  start.v_r: [-0.2, 0]\n  excitation.phase: [0, 1]",
}


BLOCKS = {
    **{name: (BASE, keys) for name, keys in SWEEPS.items()},
    "coefficients": (
        COEFFICIENTS,
        "friction.mu_kinetic: [0, 0.02]\n  friction.mu_static: [0.02, 0.03]\n"
        "  friction.normal: [600, 900]\n  oscillator.mass: [60, 90]",
    ),
    **{
        f"sine {k}": (
            SUM_OF_SINES,
            f"excitation.components.{k}.frequency: [0.6, 1.8]\n  {VARYING}",
        )
        for k in (0, 1)
    },
}
"""Scenes and the keys of their sweeps."""


def same(table, scenario):
    """Return whether a sweep gives what its cases give one by one, to the last bit."""
    motions = MotionCache()
    alone = [solve_row(scenario, point, motions) for point in iter_points(scenario.sweep)]
    assert [row.status for row in table] == [row.status for row in alone]
    for row, other in zip(table, alone, strict=True):
        assert dict(row.point) == dict(other.point)
        assert dict(row.metrics) == {name: other.metrics.get(name) for name in row.metrics}
        assert (row.F_fk, row.F_fs, row.note) == (other.F_fk, other.F_fs, other.note)


@pytest.mark.parametrize("block", BLOCKS)
def test_block_of_a_sweep_is_what_its_cases_are_alone(scenario, block):
    text, keys = BLOCKS[block]
    swept = scenario(f"{text}sweep:\n  {keys}\n")
    same(sweep(swept), swept)


def test_undamped_orbits_keep_their_statuses(scenario):
    keys = (
        "excitation.frequency: [0.795774715459, 1.591549430918954], friction.kinetic: [1, 40]"
    )
    swept = scenario(BASE.replace("damping: 500", "damping: 0") + f"sweep: {{{keys}}}\n")
    table = sweep(swept)
    assert {row.status for row in table} > {"ok", "not settled"}
    same(table, swept)


def test_values_that_do_not_go_together_are_refused_in_their_block(scenario):
    axis = "{from: 10, to: 30, count: 110}"
    static = BASE.replace("kinetic: 15}", "kinetic: 15, static: 30}")
    text = f"{static}sweep:\n  friction.kinetic: {axis}\n  friction.static: {axis}\n"
    with pytest.raises(ScenarioError) as fault:
        sweep(scenario(text))
    assert "must be at least the kinetic" in fault.value.problems[0].sentence
    assert fault.value.problems[0].line == 9


def test_columned_scenario_gives_columns_of_symbols(scenario):
    text = BASE.replace("damping: 500", "damping_ratio: 0.3")
    swept = scenario(f"{text}sweep:\n  {SWEEPS['friction']}\n  oscillator.mass: [60, 90]\n")
    case = swept.with_values(point_columns(swept.sweep, 0, 12))
    alone = [swept.at(point) for point in iter_points(swept.sweep)]
    assert case.oscillator.plant().b.tolist() == [one.oscillator.plant().b for one in alone]
    assert case.law().F_fs.tolist() == [one.law().F_fs for one in alone]
