"""Monodromy matrices: against differences of marches, closed forms and Liouville's formula."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from seat import ranges

from drysim.approach import coulomb, piecewise
from drysim.approach.piecewise import PiecewiseTrajectory
from drysim.approach.solution import keeps_anchor
from drysim.core.model import (
    AnyState,
    ContactState,
    CoulombLaw,
    EndStops,
    Floats,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
    StrokeLimits,
)
from drysim.core.modes import ARRIVAL, decode_mode, stop_stage
from drysim.orbits import search
from drysim.orbits.continuation import FOLD, PERIOD_DOUBLING, Branch, Continuation
from drysim.orbits.return_map import PeriodicSystem, ShootingReturnMap

M, K_X, B = 75.0, 7500.0, 150.0
PLANT, PERIOD = Plant(M, K_X, B), 0.5
WAVE = 0.5, 2.0 * math.pi * 4.0, 0.3
LIFTS = 1.5, 2.0 * math.pi * 4.0, 0.3
EQUAL, UNEQUAL = StrokeLimits(0.006, 0.006), StrokeLimits(0.006, 0.005)
ONE, TWO = ((0.0, 40e3),), ((0.0, 40e3), (0.001, 80e3))
THREE = ((0.0, 40e3), (0.001, 80e3), (0.002, 100e3))
BUMPER = EndStops(EQUAL, ONE, 400.0)
BY_DIRECTION = PiecewiseLaw(20.0, 24.0, compression=(35.0, 40.0), damping=(100.0, 400.0))

LAWS = {
    "coulomb": PiecewiseLaw(45.0, 54.0),
    "coulomb, equal limits": PiecewiseLaw(45.0, 45.0),
    "varying load": PiecewiseLaw(45.0, 54.0, 0.0, *WAVE),
    "lift-off": PiecewiseLaw(45.0, 54.0, 0.0, *LIFTS),
    "by direction": BY_DIRECTION,
    "jenkins": PiecewiseLaw(45.0, 45.0, 30e3),
    "petrov-ewins": PiecewiseLaw(45.0, 45.0, 30e3, *WAVE),
    "petrov-ewins, lift-off": PiecewiseLaw(45.0, 45.0, 30e3, *LIFTS),
    "bumpers": PiecewiseLaw(20.0, 20.0, stops=EndStops(EQUAL, ONE)),
    "damped bumpers": PiecewiseLaw(20.0, 24.0, stops=BUMPER),
    "staged bumpers": PiecewiseLaw(20.0, 24.0, stops=EndStops(UNEQUAL, THREE)),
    "damped staged bumpers": PiecewiseLaw(20.0, 24.0, stops=EndStops(UNEQUAL, TWO, 400.0)),
    "bumpers by direction": BY_DIRECTION._replace(stops=BUMPER),
    "jenkins, bumpers": PiecewiseLaw(20.0, 20.0, 30e3, stops=BUMPER),
    "petrov-ewins, bumpers": PiecewiseLaw(45.0, 45.0, 30e3, *WAVE, stops=BUMPER),
    "rigid stops": PiecewiseLaw(20.0, 24.0, stops=EndStops(EQUAL, e=0.6)),
    "rigid stops, no rebound": PiecewiseLaw(20.0, 24.0, stops=EndStops(EQUAL)),
    "rigid stops, no friction": PiecewiseLaw(0.0, 0.0, stops=EndStops(EQUAL, e=0.6)),
    "jenkins, rigid stops": PiecewiseLaw(20.0, 20.0, 30e3, stops=EndStops(EQUAL, e=0.6)),
}

ROUNDING = 3e-15
"""Relative rounding error of a marched state: a dozen roundings."""

STEPS = (1e-4, 1e-5, 1e-6)
"""Changes of the state, relative to its size."""

ACCURATE = 1e-5
"""Largest error of a difference that is compared."""


def march(law: PiecewiseLaw, motion: Sines, state: AnyState, time: float = PERIOD):
    return piecewise.compute_trajectory(PLANT, law, motion, state, time)


def drawn_motion(rng: np.random.Generator) -> Sines:
    A = float(rng.uniform(1.0, 4.0)), float(rng.uniform(0.0, 2.0))
    phase = float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.0, 6.0))
    return Sines(A, (2.0, 6.0), phase)


def drawn_start(law: PiecewiseLaw, rng: np.random.Generator) -> tuple[Sines, AnyState]:
    """Return a base motion, and a state that a motion under it reaches."""
    motion = drawn_motion(rng)
    start = State(0.003, 0.05)
    return motion, march(law, motion, start, 7.0 * PERIOD).state(7.0 * PERIOD)


def ends_of(law: PiecewiseLaw, motion: Sines, state: Floats) -> tuple[Floats, list[int]]:
    """Return the final state, and the kinds of the events, of a march from a state."""
    start = ContactState(*state) if law.is_elastic else State(*state)
    trajectory = march(law, motion, start)
    end = np.array(trajectory.state(PERIOD)[: len(state)])
    kinds = trajectory.events.kind.tolist()
    # A contact that yields at the start begins to yield at once if it is a little less bent.
    return end, kinds[1:] if law.is_elastic and kinds[0] == 0 else kinds


def differences(law: PiecewiseLaw, motion: Sines, state: Floats, sizes: Floats, part: int):
    """Yield slopes of a component by central differences, with the bounds on their errors.

    The error of a slope is below its difference to that with twice the step, and rounding.
    Steps across which events are born or lost are left out.
    """
    kinds = ends_of(law, motion, state)[1]
    for step in STEPS:
        slopes = []
        for h in (step, 0.5 * step):
            change = np.zeros(len(state))
            change[part] = h * sizes[part]
            above, below = (ends_of(law, motion, state + sign * change) for sign in (1, -1))
            if above[1] != kinds or below[1] != kinds:
                break
            slopes.append((above[0] - below[0]) / sizes / (2.0 * h))
        if len(slopes) == 2:
            largest = np.abs(slopes[1]).max(initial=1.0)
            error = 2.0 * np.abs(slopes[0] - slopes[1]).max() + 30.0 * ROUNDING * largest / step
            yield slopes[1], error


def assert_jacobians_are_those_of_differences(name: str, seeds: range, monodromy) -> None:
    law, compared, columns = LAWS[name], 0, 0
    for seed in seeds:
        motion, reached = drawn_start(law, np.random.default_rng([len(name), seed]))
        state = np.array(reached[: 3 if law.is_elastic else 2])
        sizes = np.array([1e-2, 1e-2 * 2.0 * math.pi / PERIOD, 1e-2])[: len(state)]
        start = ContactState(*state) if law.is_elastic else State(*state)
        trajectory = march(law, motion, start)
        jacobian = monodromy(trajectory) * sizes / sizes[:, None]
        # A contact that rebounds between the same stops yields just where it meets them.
        rebounds = law.is_elastic and law.stops is not None and law.stops.rigid
        # At the limit of the contact no state is beyond it.
        holds = trajectory.events.kind[0] == 0
        for part in range(len(state) if holds and not rebounds else 2):
            if part == 1 and state[1] == 0.0:
                continue
            columns += 1
            found = list(differences(law, motion, state, sizes, part))
            slope, error = min(found, key=lambda one: one[1], default=(state, math.inf))
            if error > ACCURATE:
                continue
            compared += 1
            off = np.abs(jacobian[:, part] - slope).max()
            assert off <= error, (name, seed, part, off, error)
    assert compared > 0.7 * columns, (compared, columns)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seeds", ranges(4, 150))
def test_derivative_of_every_law_is_that_of_differences_within_their_error(name, seeds):
    assert_jacobians_are_those_of_differences(name, seeds, PiecewiseTrajectory.monodromy)


# Without the jumps at events, the same comparison fails.


def by_kernels(variational):
    """Return a function that returns the monodromy matrix by the kernels of a module."""

    def monodromy(trajectory: PiecewiseTrajectory) -> Floats:
        deviations = variational.Deviations(*np.eye(3).tolist())
        variational.propagate_deviations(as_lists(trajectory), deviations)
        n = 3 if trajectory.law.is_elastic else 2
        return np.array(deviations)[:n, :n]

    return monodromy


def as_lists(trajectory: PiecewiseTrajectory):
    """Return the solution with columns as the plain engine takes them."""
    scene, segments = trajectory.solution
    columns = (np.asarray(column).tolist() for column in segments)
    waves = scene.waves._replace(values=list(scene.waves.values))
    u_dd = list(scene.u_dd)
    return trajectory.solution._replace(
        scene=scene._replace(waves=waves, u_dd=u_dd), segments=type(segments)(*columns)
    )


@pytest.mark.parametrize(
    ("name", "jump"),
    [
        ("coulomb", "stop_or_break_away"),
        ("damped bumpers", "meet_stop"),
        ("rigid stops, no friction", "meet_stop"),
        ("jenkins", "reset_anchor"),
    ],
)
def test_without_a_saltation_the_derivative_is_refuted(plain, monkeypatch, name, jump):
    assert_jacobians_are_those_of_differences(name, range(2), by_kernels(plain.variational))
    monkeypatch.setattr(plain.variational, jump, lambda *_: None)
    with pytest.raises(AssertionError):
        assert_jacobians_are_those_of_differences(name, range(2), by_kernels(plain.variational))


@pytest.mark.parametrize("name", LAWS)
def test_both_engines_have_the_same_derivative(plain, name):
    law = LAWS[name]
    motion, start = drawn_start(law, np.random.default_rng(len(name)))
    trajectory = march(law, motion, start)
    one, other = by_kernels(plain.variational)(trajectory), trajectory.monodromy()
    assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max()


# Liouville's formula: the determinant from the damping along the motion and the jumps alone.


def time_in_contact(trajectory: PiecewiseTrajectory) -> float:
    """Return the time for which a bumper touches the mass [s]."""
    starts, codes = trajectory.solution.segments.s, trajectory.solution.segments.d
    rows = [row for row in zip(starts, codes, strict=True) if row[1] != ARRIVAL]
    total = 0.0
    for (begin, code), (end, _) in itertools.pairwise(rows):
        _, stage, released = stop_stage(decode_mode(int(code)).end_stop)
        total += (end - begin) if stage > 0 and not released else 0.0
    return total


@pytest.mark.parametrize("b_s", [0.0, 400.0])
@pytest.mark.parametrize("stages", [ONE, TWO, THREE])
def test_determinant_between_bumpers_is_the_decay_in_both_dampers(stages, b_s):
    rng, met = np.random.default_rng(5), 0
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(UNEQUAL, stages, b_s))
    for _ in range(5):
        trajectory = march(law, *drawn_start(law, rng))
        contact = time_in_contact(trajectory)
        met += contact > 0.0
        expected = -(B * PERIOD + b_s * contact) / M
        assert math.log(np.linalg.det(trajectory.monodromy())) == pytest.approx(expected)
    assert met > 0


@pytest.mark.parametrize("e", [0.3, 0.6, 0.95])
def test_determinant_between_rigid_stops_has_the_square_of_e_for_each_impact(e):
    rng, impacts = np.random.default_rng(6), 0
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(UNEQUAL, e=e))
    for _ in range(5):
        trajectory = march(law, *drawn_start(law, rng))
        hits = len(trajectory.hits().t)
        impacts += hits
        expected = e ** (2 * hits) * math.exp(-B * PERIOD / M)
        monodromy = trajectory.monodromy()
        rounding = 1e-14 * max(1.0, float(np.abs(monodromy).max()) ** 2)
        assert np.linalg.det(monodromy) == pytest.approx(expected, rel=1e-9, abs=rounding)
    assert impacts > 0


# Multipliers in closed form.


def multipliers(trajectory: PiecewiseTrajectory) -> Floats:
    """Return the two multipliers of a motion over its repetition, the larger first."""
    trace, determinant = trajectory.jacobian()
    values = np.roots([1.0, -trace, determinant]).astype(complex)
    return values[np.argsort(-np.abs(values), kind="stable")]


def linear_flow(stiffness: float) -> Floats:
    """Return the monodromy matrix of the oscillator with a stiffness [N/m] and no friction."""
    from scipy.linalg import expm

    return expm(np.array([[0.0, 1.0], [-stiffness / M, -B / M]]) * PERIOD)


def test_multipliers_without_friction_are_those_of_the_matrix_exponential():
    trajectory = march(PiecewiseLaw(0.0, 0.0), Sines((1.0,), (2.0,), (0.0,)), State(0.0, 0.1))
    flow = linear_flow(K_X)
    assert trajectory.monodromy() == pytest.approx(flow, rel=1e-12, abs=1e-14)


def orbit_of(plant: Plant, law: PiecewiseLaw, motion: Sines, start: AnyState):
    """Return the trajectory of one repetition of the orbit that a start leads to."""
    period = 1.0 / motion.f[0]
    orbit = search.find_orbit(plant, law, motion, start, period)
    assert orbit.settled
    return piecewise.compute_trajectory(plant, law, motion, orbit.state, orbit.periods * period)


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "expected"),
    [
        (0.8, 0.05, 0.3, 0.03306541 + 0.44755169j),
        (1.5, 0.05, 0.5, -0.12863689 + 0.27502674j),
        (2.0, 1.0 / 3.0, 0.3, -0.1560542 + 0.07507111j),
        (0.8, 0.0, 0.3, 0.02294045 + 0.6967003j),
    ],
)
def test_multipliers_of_sliding_without_stops_are_those_of_den_hartog(
    beta, zeta, phi, expected
):
    law = PiecewiseLaw(phi, phi, compression=(phi, phi))
    motion = Sines((1.0,), (beta / (2.0 * math.pi),), (0.0,))
    found = multipliers(orbit_of(Plant(1.0, 1.0, 2.0 * zeta), law, motion, State(0.0, 0.0)))
    assert found.real == pytest.approx(expected.real, abs=1e-8)
    assert np.abs(found.imag) == pytest.approx(abs(expected.imag), abs=1e-8)


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "eta", "expected"),
    [
        (0.3, 0.05, 0.2, 1.0, 0.50863404),
        (1.0, 1.0 / 3.0, 0.6, 1.2, 0.07120099),
        (0.5, 0.05, 0.5, 1.0, 0.05770276),
    ],
)
def test_multipliers_of_two_stops_a_period_are_those_of_the_closed_form(
    beta, zeta, phi, eta, expected
):
    law = PiecewiseLaw(phi, eta * phi, compression=(phi, eta * phi))
    motion = Sines((1.0,), (beta / (2.0 * math.pi),), (0.0,))
    found = multipliers(orbit_of(Plant(1.0, 1.0, 2.0 * zeta), law, motion, State(0.5, 0.0)))
    assert found[0] == pytest.approx(expected, abs=1e-8)
    assert abs(found[1]) < 1e-12


# An elastic contact: its third multiplier is trivial.


def test_elastic_contact_that_yields_has_a_multiplier_of_zero():
    trajectory = orbit_of(
        PLANT, LAWS["jenkins"], Sines((2.0,), (2.0,), (0.0,)), ContactState(0.0, 0.0, 0.0)
    )
    values = np.sort(np.abs(np.linalg.eigvals(trajectory.monodromy())))
    assert values[0] < 1e-12
    assert np.abs(multipliers(trajectory)) == pytest.approx(values[:0:-1], rel=1e-8)


def test_elastic_contact_that_never_yields_is_a_second_spring():
    law, k_t = LAWS["jenkins"]._replace(F_fk=1e3, F_fs=1e3), 30e3
    trajectory = march(law, Sines((1.0,), (2.0,), (0.0,)), ContactState(0.0, 0.1, 0.0))
    flow = linear_flow(K_X + k_t)
    assert keeps_anchor(trajectory.monodromy())
    assert trajectory.jacobian() == pytest.approx((np.trace(flow), np.linalg.det(flow)))


# At the border of what has a derivative.


def test_mass_that_rests_against_a_stop_forgets_its_start():
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(EQUAL, e=0.5))
    trajectory = march(law, Sines((20.0,), (0.3,), (0.2,)), State(-0.005, 0.0))
    assert trajectory.state(PERIOD) == (-0.006, 0.0)
    assert not trajectory.monodromy().any()


def test_derivative_where_the_mass_grazes_a_guard_is_infinite(plain):
    assert plain.variational.turn_factor(0.0, 1.0) == math.inf
    assert plain.variational.break_away_factor(1, 1.0, 1.0, 0.0) == math.inf
    assert plain.variational.break_away_factor(1, 1.0, 0.0, 0.0) == 0.0


# Impacts of an undamped oscillator on one stop, once a period: the orbit, its multipliers and
# its bifurcations in closed form. S. W. Shaw and P. J. Holmes, J. Sound Vib. 90 (1983) 129;
# J. M. T. Thompson and R. Ghaffari, Phys. Lett. A 91 (1982) 5, for the period doubling.


E, GAP = 0.8, 0.2
"""Restitution, and the distance of the stop; m = k_x = 1."""


def impact_speed_and_trace(omega: float, A: float, larger: bool = True) -> tuple[float, float]:
    """Return the speed v of the impact, and the trace of the monodromy matrix.

    With the particular solution of amplitude R, displacement p and velocity q at the impact, a
    free motion that returns after a period T to the stop with the velocity turned and divided
    by E has q = v (1 - E)/2 and p = GAP + v (1 + E)/2 cot(T/2); and p² + (q/omega)² = R².
    """
    T, R = 2.0 * math.pi / omega, A / abs(1.0 - omega**2)
    g, h = 0.5 * (1.0 + E) / math.tan(0.5 * T), 0.5 * (1.0 - E) / omega
    roots = np.roots([g * g + h * h, 2.0 * GAP * g, GAP * GAP - R * R])
    v = float(sorted(roots.real)[1 if larger else 0])
    p = GAP + g * v
    a = -(omega**2) * p - (GAP - p)
    return v, -2.0 * E * math.cos(T) + (1.0 + E) * a / v * math.sin(T)


def fold_of_impacts(omega: float) -> float:
    """Return the least amplitude of the base acceleration with one impact a period [m/s²]."""
    T = 2.0 * math.pi / omega
    g, h = 0.5 * (1.0 + E) / math.tan(0.5 * T), 0.5 * (1.0 - E) / omega
    return GAP * h / math.hypot(g, h) * abs(1.0 - omega**2)


def impacting(omega: float, A: float) -> PeriodicSystem:
    """Return the scene."""
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(StrokeLimits(GAP, 1e3), e=E))
    motion = Sines((A,), (omega / (2.0 * math.pi),), (0.0,))
    return PeriodicSystem(Plant(1.0, 1.0, 0.0), law, motion, 2.0 * math.pi / omega)


def impacting_orbit(omega: float, A: float, start: AnyState) -> PiecewiseTrajectory:
    plant, law, motion, _ = impacting(omega, A)
    return orbit_of(plant, law, motion, start)


@pytest.mark.parametrize("omega", [1.7, 1.9, 2.1, 2.2])
def test_multipliers_of_one_impact_a_period_are_those_of_the_closed_form(omega):
    trajectory = impacting_orbit(omega, 1.0, State(0.0, 1.0))
    v, trace = impact_speed_and_trace(omega, 1.0)
    assert trajectory.hits().v_r == pytest.approx([v], rel=1e-9)
    assert trajectory.jacobian() == pytest.approx((trace, E * E), rel=1e-8)


def followed(scene, start: AnyState) -> Branch:
    """Return the branch through the orbit that a start leads to at p = 0.5."""
    return_map = ShootingReturnMap(scene)
    continuation = Continuation(return_map, symmetric=False)
    orbit = return_map.orbit(0.5, start)
    seed = continuation.isolate(0.5, orbit.state, orbit.peak, orbit.periods)
    return continuation.branch_through(seed)


def test_period_doubling_of_one_impact_a_period_is_that_of_the_closed_form():
    from scipy.optimize import brentq

    def omega(p: float) -> float:
        return 2.2 + 0.08 * p

    def test(at: float) -> float:
        return 1.0 + impact_speed_and_trace(at, 1.0)[1] + E * E

    branch = followed(lambda p: impacting(omega(p), 1.0), State(0.0, 1.0))
    (doubling,) = (one for one in branch.bifurcations if one.kind == PERIOD_DOUBLING)
    assert omega(doubling.point.p) == pytest.approx(brentq(test, 2.2, 2.28), rel=1e-9)
    assert branch.points[0].image.jacobian_error == 0.0


def test_fold_of_one_impact_a_period_is_that_of_the_closed_form():
    omega, expected = 1.6, fold_of_impacts(1.6)

    def scene(p: float) -> PeriodicSystem:
        return impacting(omega, (0.9 + 0.4 * p) * expected)

    branch = followed(scene, State(0.0, 1.0))
    (fold,) = (one for one in branch.bifurcations if one.kind == FOLD)
    assert 0.9 + 0.4 * fold.point.p == pytest.approx(1.0, rel=1e-9)
    # Beyond the fold the orbit of the slower impact is followed, which no march reaches.
    largest = [float(np.abs(point.multipliers).max()) for point in branch.points]
    assert min(largest) < 1.0 < max(largest)


@pytest.mark.parametrize("seed", range(8))
def test_monodromy_from_events_under_sines_is_that_from_the_segments(seed):
    draw = np.random.default_rng(seed)
    plant = Plant(10.0, float(draw.uniform(100.0, 1500.0)), float(draw.choice([0.0, 30.0])))
    F, swing = float(draw.uniform(2.0, 8.0)), float(draw.choice([0.0, 0.4]))
    law = CoulombLaw(F, 1.2 * F, swing, 7.0 * swing, 0.3)
    A, f, phase = (tuple(draw.uniform(0.5, 2.0, 2).tolist()) for _ in range(3))
    start = State(float(draw.normal(0.0, 5e-3)), float(draw.normal(0.0, 0.1)))
    trajectory = coulomb.sine_trajectory(plant, law, Sines(A, f, phase), start, 1.5)
    assert len(trajectory.events) > 2
    known = PiecewiseTrajectory.monodromy(trajectory)
    assert np.abs(trajectory.monodromy() - known).max() <= 1e-11 * np.abs(known).max()
