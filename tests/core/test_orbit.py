"""Periodic orbits against the tables of independent solutions."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scenes import PAPER, log_of, waves_of

from drysim.core.status import Status

M, K = 1.0, 100.0


def orbit(
    kernel: SimpleNamespace, beta: float, zeta: float, phi: float, ratio: float = 1.0,
    start: tuple[float, float] = (0.0, 0.0), most: int = 5000,
) -> SimpleNamespace:  # fmt: skip
    """Settle the scene at frequency ratio β, damping ratio ζ and F_fk/(m A) = φ, with A = 1."""
    omega = beta * math.sqrt(K / M)
    plant = kernel.model.Plant(M, K, 2 * zeta * math.sqrt(K * M))
    law = kernel.model.CoulombLaw(phi * M, ratio * phi * M)
    waves = waves_of(kernel, [(1.0, omega / (2 * math.pi), 0.0)], law)
    log = log_of(kernel)
    d = kernel.events.initial_direction(plant, law, *start, 0.0)[0]
    period = 2 * math.pi / omega
    scene = kernel.orbit.SineMarch(plant, law, waves, log)
    state, multiple, closure, periods, _ = kernel.orbit.iterate_period_map(
        scene, period, kernel.orbit.PeriodState(*start, d), most, period_starts(kernel)
    )
    marginal = not kernel.orbit.uniqueness_and_distance(scene, period, state)[0]
    _, events, peak = kernel.orbit.period_map(scene, period, state)
    return SimpleNamespace(
        state=state[:2], marginal=marginal, peak=peak * K / M, multiple=multiple,
        closure=closure, periods=periods, events=events, kinds=log.kind[:events].tolist(),
    )  # fmt: skip


def den_hartog(beta: float, zeta: float, phi: float) -> float:
    """Return x_max k/P of steady sliding without stops (Den Hartog 1930, viscous form)."""
    q = math.sqrt(1 - zeta**2)
    D = math.cosh(math.pi * zeta / beta) + math.cos(math.pi * q / beta)
    G = (math.sinh(math.pi * zeta / beta) - zeta / q * math.sin(math.pi * q / beta)) / D
    H = math.sin(math.pi * q / beta) / (beta * q * D)
    return -G * phi + math.sqrt(
        1 / ((1 - beta**2) ** 2 + (2 * zeta * beta) ** 2) - (H * phi) ** 2
    )


@pytest.mark.parametrize(
    ("beta", "zeta", "phi"),
    [(0.8, 0.05, 0.1), (0.8, 0.05, 0.5), (1.0, 0.05, 0.3), (1.0, 1 / 3, 0.3), (1.5, 0.05, 0.5),
     (2.0, 1 / 3, 0.3), (3.0, 1 / 3, 0.5), (0.8, 1e-3, 0.3)],
)  # fmt: skip
def test_sliding_without_stops_is_den_hartogs(kernel, beta, zeta, phi):
    found = orbit(kernel, beta, zeta, phi)
    assert sorted(found.kinds) == [-2, 2]
    assert found.multiple == 1
    assert found.peak == pytest.approx(den_hartog(beta, zeta, phi), rel=1e-11)


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "ratio", "peak"),
    [(0.3, 0.05, 0.2, 1.0, 0.863591), (0.5, 0.05, 0.5, 1.0, 1.208992),
     (0.5, 1 / 3, 0.5, 1.0, 0.748854), (1.0, 1 / 3, 0.8, 1.0, 0.083048),
     (2.0, 0.05, 0.9, 1.0, 0.005990), (0.5, 0.05, 0.5, 1.2, 1.217104),
     (1.0, 1 / 3, 0.6, 1.2, 0.343902), (2.0, 0.05, 0.7, 1.3, 0.053530)],
)  # fmt: skip
def test_stick_slip_orbits_have_their_known_stroke(kernel, beta, zeta, phi, ratio, peak):
    found = orbit(kernel, beta, zeta, phi, ratio)
    assert found.peak == pytest.approx(peak, abs=2e-6)
    assert found.closure < 1e-12


@pytest.mark.parametrize(
    ("beta", "zeta", "phi"),
    [(0.8, 0.05, 0.72954), (0.8, 1 / 3, 0.41904), (1.5, 0.05, 0.62223), (2.0, 1 / 3, 0.49963),
     (5.0, 0.05, 0.54109)],
)  # fmt: skip
def test_stops_begin_at_the_known_friction(kernel, beta, zeta, phi):
    # The tabulated onset is up to 1.5e-4 late: stops of a few microseconds come before it.
    assert 0 not in orbit(kernel, beta, zeta, phi - 2e-4).kinds
    assert 0 in orbit(kernel, beta, zeta, phi).kinds


def test_rigid_block_begins_to_stop_at_the_closed_form(kernel):
    # Without spring and damper the onset is 1/sqrt(1 + π²/4); the phase makes it symmetric.
    onset = 1 / math.sqrt(1 + math.pi**2 / 4)
    for phi, stops in ((onset - 1e-9, False), (onset + 1e-9, True)):
        plant, law = kernel.model.Plant(1.0, 0.0, 0.0), kernel.model.CoulombLaw(phi, phi)
        # v turns where cos(t) = π φ/2; slide one cycle from there.
        phase = math.acos(math.pi * phi / 2)
        log = log_of(kernel)
        waves = waves_of(kernel, [(1.0, 1 / (2 * math.pi), phase)], law)
        interval = kernel.march.Interval(0, 0.0, 20.0, 0.0, 0.0)
        state = kernel.march.SlipState(0, 0.0, 0.0, 0.0, -1, math.nan, 0, math.inf)
        found = kernel.march.march_sines(plant, law, waves, interval, state, log)
        assert (0 in log.kind[: found.events].tolist()) == stops


def test_light_damping_is_settled_by_newton_not_by_patience(kernel):
    found = orbit(kernel, 0.8, 1e-4, 0.3, most=5000)
    assert found.multiple == 1
    assert found.peak == pytest.approx(den_hartog(0.8, 1e-4, 0.3), rel=1e-9)
    assert found.periods < 2000


def test_motion_that_keeps_growing_is_not_called_settled(kernel):
    assert orbit(kernel, 1.0, 0.0, 0.5, most=300).multiple == Status.NOT_SETTLED


def test_mass_that_never_moves_is_settled_after_one_period(kernel):
    found = orbit(kernel, 1.0, 0.1, 1.0)
    assert (found.multiple, found.periods, found.events, found.peak) == (1, 1, 0, 0.0)


@pytest.mark.parametrize(("zeta", "marginal"), [(0.0, True), (0.01, False)])
def test_continuum_of_orbits_at_half_the_natural_frequency_is_recognised(
    kernel, zeta, marginal
):
    # Without damping β = 1/2 has a continuum of orbits (Csernák, Stépán and Shaw 2007).
    ends = []
    for x_r in (0.0035, 0.0045):
        found = orbit(kernel, 0.5, zeta, 0.2, start=(x_r, -0.0666666))
        assert found.multiple == 1
        assert found.marginal == marginal
        ends.append(found.state[0])
    assert (abs(ends[1] - ends[0]) > 9e-4) == marginal


def test_newton_leaves_no_trace_in_where_a_creeping_mass_comes_to_rest(fast):
    # With F_fs above F_fk the place of rest depends on every period of the way there.
    beta, zeta, phi, ratio, start = 6.751, 20.0, 0.9, 1.2, (-0.0152, 0.03)
    found = orbit(fast, beta, zeta, phi, ratio, start=start)
    plant, law = (
        fast.model.Plant(M, K, 2 * zeta * math.sqrt(K * M)),
        fast.model.CoulombLaw(phi, ratio * phi),
    )
    period = 2 * math.pi / (beta * math.sqrt(K / M))
    waves, log = waves_of(fast, [(1.0, 1 / period, 0.0)], law), log_of(fast)
    scene = fast.orbit.SineMarch(plant, law, waves, log)
    state, before = fast.orbit.PeriodState(*start, 1), None
    while state != before:
        before = state
        state = fast.orbit.period_map(scene, period, state)[0]
    assert state[1:] == (0.0, 0)
    assert found.state == state[:2]


def test_steady_start_without_friction_is_the_impedance_of_every_sine(kernel):
    plant, law = kernel.model.Plant(75.0, 7500.0, 500.0), kernel.model.CoulombLaw(0.0, 0.0)
    sines = [(1.2, 0.7, 0.3), (0.4, 2.1, -1.1), (2.0, 1.6, 2.0)]
    x_r, v_r = kernel.orbit.linear_steady_state(plant, waves_of(kernel, sines, law))
    omega = 2 * math.pi * np.array([f for _, f, _ in sines])
    swings = -75.0 * np.array([A * np.exp(1j * phase) for A, _, phase in sines])
    swings /= 7500.0 - 75.0 * omega**2 + 500.0j * omega
    assert x_r == pytest.approx(swings.imag.sum(), rel=1e-13)
    assert v_r == pytest.approx((1j * omega * swings).imag.sum(), rel=1e-13)


def test_orbit_that_rounding_keeps_from_closing_is_settled_where_it_comes_no_closer(
    plain, monkeypatch
):
    closed = orbit(plain, 1.3, 0.02, 0.2)
    monkeypatch.setattr(plain.orbit, "CLOSURE_TOLERANCE", -1.0)
    found = orbit(plain, 1.3, 0.02, 0.2)
    assert found.multiple == 1
    assert closed.periods + plain.orbit.STAGNATION_PERIODS <= found.periods < 200
    assert found.closure <= plain.orbit.STAGNATION_TOLERANCE
    assert found.state == pytest.approx(closed.state, rel=1e-10)


def period_starts(kernel: SimpleNamespace) -> Any:
    """Return work space of a search for an orbit."""
    return kernel.orbit.PeriodStarts(*np.zeros((2, kernel.orbit.MAX_MULTIPLE)))


def found_for(
    kernel: SimpleNamespace, plant: tuple[float, float, float], f: float, F_fk: float
) -> SimpleNamespace:
    """Find the orbit from rest under a sine of 1 m/s² and frequency f."""
    plant, law = kernel.model.Plant(*plant), kernel.model.CoulombLaw(F_fk, F_fk)
    waves, log = waves_of(kernel, [(1.0, f, 0.0)], law), log_of(kernel)
    scene = kernel.orbit.SineMarch(plant, law, waves, log)
    (x_r, v_r, _), multiple, closure, _, _, unique, _ = kernel.orbit.converge_to_orbit(
        scene, 1.0 / f, 0.0, 0.0, 300, period_starts(kernel)
    )
    d = kernel.events.initial_direction(plant, law, x_r, v_r, 0.0)[0]
    one = kernel.orbit.period_map(scene, 1.0 / f, kernel.orbit.PeriodState(x_r, v_r, d))
    return SimpleNamespace(multiple=multiple, unique=unique, closure=closure, peak=one[2])


@pytest.mark.parametrize("beta", [60.0, 6e3, 6e4, 6e5, 6e8])
def test_motion_that_hardly_changes_far_from_its_orbit_is_not_called_settled(kernel, beta):
    # Far above its natural frequency a mass changes by little in a period wherever it is: at
    # β = 6e5 it was called settled at nearly four times the amplitude of its orbit.
    found = found_for(kernel, (M, K, 2 / 3 * math.sqrt(K * M)), beta * 10 / (2 * math.pi), 0.3)
    peak = den_hartog(beta, 1 / 3, 0.3) / K
    if beta < 1e4:
        assert (found.multiple, found.unique) == (1, True)
        assert found.peak == pytest.approx(peak, rel=1e-6)
    else:
        assert found.multiple == Status.NOT_SETTLED or not found.unique
        assert found.peak > 2.0 * peak


def test_mass_that_creeps_to_the_edge_of_its_resting_places_has_come_to_rest(fast):
    # Kicked under a base too weak to move it from rest, it slides a little less in each period.
    beta, phi = 3.41048, 1.08319
    found = orbit(fast, beta, 0.001958, phi, start=(-0.02544344, -0.29677443))
    assert found.multiple == 1
    assert found.state == pytest.approx(((phi - 1.0) * M / K, 0.0), rel=1e-5)
    assert not found.marginal


@pytest.mark.parametrize("b", [0.0, 1e-9, 0.5])
def test_block_without_a_spring_has_one_orbit_wherever_it_lies(kernel, b):
    # No place is drawn to another, but speeds are, with and without a damper.
    found = found_for(kernel, (M, 0.0, b), 1.0, 0.3)
    assert (found.multiple, found.unique) == (1, True)
    assert found.closure < 1e-12


def newton(kernel: SimpleNamespace, zeta: float, dx: float, dv: float) -> SimpleNamespace:
    """Take a step of Newton's method from beside an orbit at β = 1/2 or 0.8."""
    beta = 0.8 if zeta else 0.5
    found, omega = orbit(kernel, beta, zeta, 0.3), beta * math.sqrt(K / M)
    plant = kernel.model.Plant(M, K, 2 * zeta * math.sqrt(K * M))
    law, log = kernel.model.CoulombLaw(0.3 * M, 0.3 * M), log_of(kernel)
    waves, period = (
        waves_of(kernel, [(1.0, omega / (2 * math.pi), 0.0)], law),
        2 * math.pi / omega,
    )
    x_r, v_r = found.state[0] + dx, found.state[1] + dv
    scene = kernel.orbit.SineMarch(plant, law, waves, log)
    state = kernel.orbit.PeriodState(x_r, v_r, 1 if v_r > 0 else -1)
    image, events, _ = kernel.orbit.period_map(scene, period, state)
    rate = kernel.orbit.velocity_scale_rate(plant, period)
    good, end = kernel.orbit.newton_step(scene, period, rate, state, image, events)
    return SimpleNamespace(good=good, state=end[:2], image=image[:2], orbit=found.state)


def test_newtons_step_from_beside_an_orbit_lands_on_it(kernel):
    found = newton(kernel, 0.05, 1e-7, -1e-6)
    assert found.good
    assert found.state == pytest.approx(found.orbit, rel=1e-9)
    assert found.image != pytest.approx(found.orbit, rel=1e-8)


def test_newtons_method_leaves_an_orbit_alone_that_keeps_distances(kernel):
    found = newton(kernel, 0.0, 1e-7, -1e-6)
    assert not found.good
    assert found.state == found.image


@pytest.mark.parametrize(
    ("k_x", "b", "most"),
    [(K, 0.0, 5000), (K, 0.1, 5000), (K, 1e6, 5000), (K, 1e7, 100), (0.0, 1e-3, 5000)],
)
def test_mass_that_only_creeps_is_not_followed_for_thousands_of_periods(kernel, k_x, b, most):
    # At ξ = 1e10 its spring takes decades: 5000 periods had taken a minute in plain Python.
    assert kernel.orbit.period_budget(kernel.model.Plant(M, k_x, b), 0.6, 5000) == most


def test_orbit_of_ten_periods_is_found_and_repeats_itself(kernel):
    F_fk, f, phase = 0.11999109888519495, 0.07957747154594767, 0.6791759369443524
    plant, law = kernel.model.Plant(1.0, 1.0, 0.002), kernel.model.CoulombLaw(F_fk, 5.0 * F_fk)
    waves, log = waves_of(kernel, [(1.0, f, phase)], law), log_of(kernel)
    scene = kernel.orbit.SineMarch(plant, law, waves, log)
    (x_r, v_r, _), multiple, closure, periods, _, unique, _ = kernel.orbit.converge_to_orbit(
        scene, 1.0 / f, 0.0, -0.5202476676680174, 5000, period_starts(kernel)
    )
    assert (multiple, unique) == (10, True)
    assert closure <= kernel.orbit.STAGNATION_TOLERANCE
    assert periods < 500
    d = kernel.march.initial_slip_state(plant, law, waves, x_r, v_r, log).d
    state, seen = kernel.orbit.PeriodState(x_r, v_r, d), []
    for _ in range(10):
        state = kernel.orbit.period_map(scene, 1 / f, state)[0]
        seen.append(state.x_r)
    assert seen[-1] == pytest.approx(x_r, abs=1e-9)
    assert min(abs(x - x_r) for x in seen[:-1]) > 1e-3


def test_mass_that_creeps_from_afar_is_followed_until_it_reaches_its_orbit(fast):
    # 5e-4 of its way in a period, at ξ = 1000: it is there after 320, Newton's steps included.
    plant, law = fast.model.Plant(M, 1.0, 2000.0), fast.model.CoulombLaw(0.1, 0.1)
    waves, log = waves_of(fast, [(1.0, 1.0, 0.3)], law), log_of(fast)
    scene = fast.orbit.SineMarch(plant, law, waves, log)
    (x_r, *_), multiple, _, periods, _, unique, _ = fast.orbit.converge_to_orbit(
        scene, 1.0, 1.0, 0.0, 5000, period_starts(fast)
    )
    assert (multiple, unique) == (1, True)
    assert periods < 1000
    assert abs(x_r) < 1e-3


def test_creep_that_comes_to_no_orbit_in_time_has_not_settled(fast):
    plant, law = (
        fast.model.Plant(M, K, 2e10 * math.sqrt(K * M)),
        fast.model.CoulombLaw(0.3, 0.3),
    )
    waves, log = waves_of(fast, [(1.0, 1.6, 0.0)], law), log_of(fast)
    scene = fast.orbit.SineMarch(plant, law, waves, log)
    _, multiple, _, periods, *_ = fast.orbit.converge_to_orbit(
        scene, 1 / 1.6, 0.0, 0.0, 5000, period_starts(fast)
    )
    assert multiple == Status.NOT_SETTLED
    assert periods <= 100


# A block of orbits is what each of its scenes is alone, and Newton's slopes are the map's.


FEW = 5000


def solve(kernel: SimpleNamespace, scenes: np.ndarray, capacity: int = 2000) -> np.ndarray:
    """Return the answers of a block of scenes."""
    answers = np.full((len(scenes), kernel.orbit.ANSWER_COLUMNS), np.nan)
    room = (scenes.shape[1] - kernel.orbit.SINES) // 3 + 1
    values = np.zeros(kernel.forcing.WAVE_COLUMNS * room)
    log, no_samples = log_of(kernel, capacity), np.zeros(2)
    n, d = np.zeros((2, capacity + 1), np.int64)
    segments = kernel.events.Segments(n, *np.zeros((4, capacity + 1)), d)
    crossings = kernel.stroke.Crossings(*np.empty((5, 2 * capacity)))
    samples = kernel.sampled.SampledMotion(*np.empty((2, 2)), np.empty(2, np.int8))
    work = kernel.orbit.Workspace(
        values, period_starts(kernel), log, segments, crossings, samples, no_samples
    )
    kernel.orbit.solve_orbits(scenes, answers, FEW, work)
    return answers


def scene(
    f: float, F: float, rms: float = 0.75, limit: float = math.inf, **more: float
) -> list:
    """Return the columns of the paper's oscillator on a sine."""
    varied = more.get("variation", 0.0), more.get("omega", 0.0), 0.3
    rest = more.get("x_r", 0.0), 0.0
    ratio = more.get("ratio", 1.0)
    return [
        *PAPER,
        F,
        ratio * F,
        *varied,
        *rest,
        1 / f,
        limit,
        limit,
        math.sqrt(2) * rms,
        f,
        0.0,
    ]


def test_block_is_what_its_scenes_are_alone(fast):
    scenes = np.array([scene(f, F) for F in (0.0, 15.0, 45.0) for f in (0.5, 1.6, 5.0)])
    whole = solve(fast, scenes)
    alone = [solve(fast, scenes[i : i + 1])[0] for i in range(len(scenes))]
    assert np.array_equal(whole, np.array(alone), equal_nan=True)
    assert (whole[:, fast.orbit.STATUS] == Status.OK).all()


def test_energy_of_every_orbit_balances(kernel):
    o, s = kernel.orbit, kernel.forcing
    scenes = np.array([scene(f, F, ratio=1.2) for F in (0.0, 15.0, 45.0) for f in (0.6, 3.0)])
    for row, found in zip(scenes, solve(kernel, scenes), strict=True):
        work = -row[s.M] * found[o.POWER]
        lost = row[s.B] * found[o.V2] + row[s.F_FK] * found[o.SLIDING_DISTANCE]
        assert lost == pytest.approx(work, rel=1e-11)


def test_limit_that_varies_takes_one_wave_more(kernel):
    o = kernel.orbit
    varied = scene(2.0, 30.0, variation=0.4, omega=2 * math.pi * 2.0)
    found = solve(kernel, np.array([varied, scene(2.0, 30.0), varied]))
    assert found[0].tolist() == found[2].tolist()
    assert found[0, o.X2] != found[1, o.X2]


def test_excursions_are_where_the_displacement_says(fast):
    o = fast.orbit
    free = solve(fast, np.array([scene(1.6, 15.0)]))[0]
    found = solve(fast, np.array([scene(1.6, 15.0, limit=0.8 * free[o.HIGHEST])]))[0]
    assert (found[o.EXCURSIONS_UP], found[o.EXCURSIONS_DOWN], found[o.ENTRIES]) == (1, 1, 2)
    assert 0 < found[o.TIME_BEYOND] < 1 / 1.6
    assert (free[o.EXCURSIONS_UP], free[o.ENTRIES], free[o.TIME_BEYOND]) == (0, 0, 0)


def dimensionless(beta: float, zeta: float, phi: float, ratio: float = 1.0) -> list:
    """Return the columns of an oscillator with m = k_x = 1 on a sine of amplitude 1."""
    law = phi, ratio * phi, 0.0, 0.0, 0.0
    sine = 1.0, beta / (2 * math.pi), 0.0
    return [1.0, 1.0, 2 * zeta, *law, 0.0, 0.0, 2 * math.pi / beta, math.inf, math.inf, *sine]


@pytest.mark.parametrize(
    ("beta", "zeta", "phi", "below", "above"),
    [(0.25, 0.05, 0.051111380, 0, 2), (0.25, 0.05, 0.229713945, 2, 4),
     (0.25, 0.05, 0.282327218, 4, 2), (0.5, 0.05, 0.287808502, 0, 2),
     (0.3, 1 / 3, 0.047206091, 0, 2)],
)  # fmt: skip
def test_number_of_stops_changes_at_the_known_friction(fast, beta, zeta, phi, below, above):
    o = fast.orbit
    scenes = np.array([dimensionless(beta, zeta, phi + step) for step in (-2e-9, 2e-9)])
    found = solve(fast, scenes)
    assert found[:, o.STOPS].tolist() == [below, above]
    assert (found[:, o.ASYMMETRY] < 1e-9).all()


def test_symmetry_breaks_where_two_stops_become_unstable(fast):
    # Shaw (1986): with F_fs = 2 F_fk at β = 1/2, ζ = 0.05 below φ = 0.217466646.
    o = fast.orbit
    found = solve(
        fast, np.array([dimensionless(0.5, 0.05, x, 2.0) for x in (0.2, 0.216, 0.22)])
    )
    assert found[:, o.STOPS].tolist() == [1, 2, 2]
    assert (found[:2, o.ASYMMETRY] > 0.05).all()
    assert found[2, o.ASYMMETRY] < 1e-9


def test_locked_mass_has_no_stops(kernel):
    o = kernel.orbit
    found = solve(kernel, np.array([scene(2.0, 90.0, rms=0.75)]))[0]
    assert (found[o.STOPS], found[o.ASYMMETRY], found[o.SLIDING_DISTANCE]) == (0, 0, 0)


def test_more_events_than_the_log_holds_are_told_of(kernel):
    found = solve(kernel, np.array([scene(0.5, 15.0)]), capacity=4)
    assert found[0, kernel.orbit.STATUS] == Status.LOG_FULL


@pytest.mark.parametrize("law", [(15.0, 15.0), (30.0, 38.0), (30.0, 38.0, 0.3, 12.0, 0.2)])
@pytest.mark.parametrize("start", [(0.004, 0.03), (0.0, 0.0), (-0.003, -0.2)])
def test_slopes_of_the_period_map_are_those_of_its_neighbours(kernel, law, start):
    plant, law = kernel.model.Plant(*PAPER), kernel.model.CoulombLaw(*law)
    waves, log = waves_of(kernel, [(1.0, 1.1, 0.4), (0.9, 2.2, 1.0)], law), log_of(kernel)
    period, rate, h = 1 / 1.1, 10.0, 1e-7
    d = kernel.march.initial_slip_state(plant, law, waves, *start, log).d

    scene = kernel.orbit.SineMarch(plant, law, waves, log)

    def image(x_r: float, v_r: float) -> np.ndarray:
        state = kernel.orbit.PeriodState(x_r, v_r, d)
        end, events, _ = kernel.orbit.period_map(scene, period, state)
        return np.array([end.x_r, end.v_r / rate, events])

    (x_r, v_r), moving = start, d != 0
    by_x = (image(x_r + h, v_r) - image(x_r - h, v_r)) / (2 * h)
    by_v = (image(x_r, v_r + h * rate) - image(x_r, v_r - h * rate)) / (2 * h)
    events = int(image(x_r, v_r)[2])
    a, b, c, e = kernel.variational.event_monodromy(scene, period, rate, d, 0, events)
    assert (a, c) == pytest.approx(by_x[:2], abs=1e-6)
    if moving and v_r:
        assert (b, e) == pytest.approx(by_v[:2], abs=1e-6)
