"""Coulomb friction over samples and sines: creep, parts of long motions, integrals, grids."""

from __future__ import annotations

import numpy as np
import pytest
from law_scenes import elastic_law, separating_law, stopped_law

import drysim
from drysim.approach import coulomb, exact, piecewise, progress
from drysim.approach import solution as responses
from drysim.approach.stick_slip import StickSlip, Viscous
from drysim.core.model import (
    BLOCK_SIZE,
    CoulombLaw,
    EndStops,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
    base_acceleration,
)
from drysim.core.sampled import CHUNK
from drysim.errors import SolverError
from drysim.metrics import stroke
from drysim.metrics.table import measure
from drysim.plots import response
from drysim.plots.response import excursions

# A mass that creeps to rest on a silent base never stops, however small its velocity.


PAPER = Plant(75.0, 7500.0, 500.0)
PLANT = Plant(1.0, 1.0, 2.0)
"""Critically damped: time constant 1 s."""


def silence(step: float, length: float, push: float = 0.9) -> np.ndarray:
    """Return a base that is silent but for a push in the last quarter."""
    u_dd = np.zeros(round(length / step) + 1)
    u_dd[len(u_dd) * 3 // 4 :] = push
    return u_dd


def test_creeping_mass_does_not_stop_on_a_silent_base() -> None:
    response = drysim.simulate(
        m=1, k_x=1, b=2, F_fk=1, F_fs=2, u_dd=silence(1.0, 80.0), dt=1, x_r=5
    )
    assert response.events.kind.tolist() == [-1]
    # By 80 digits.
    assert response.x_r[-1] == pytest.approx(0.100000025, rel=1e-8)


def test_seat_creeping_after_a_shock_is_never_stuck() -> None:
    m, k_x, step = 75.0, 7500.0, 1e-3
    t = np.arange(10_001) * step
    pulse = np.where((t >= 0.01) & (t <= 0.03), 50.0 * np.sin(np.pi * (t - 0.01) / 0.02), 0.0)
    scene = {"m": m, "k_x": k_x, "b": 2.0 * np.sqrt(m * k_x), "F_fk": 45.0, "F_fs": 54.0}
    response = drysim.simulate(**scene, u_dd=pulse, dt=step)
    assert response.events.kind.tolist() == [0, -1, 2]
    assert not response.stuck[t > 0.012].any()


@pytest.mark.parametrize("step", [0.01, 1.0, 7.0, 900.0])
def test_creeping_mass_does_not_stop_when_its_velocity_underflows(step: float) -> None:
    u_dd = np.zeros(round(1500.0 / step) + 2)
    response = drysim.simulate(m=1, k_x=1, b=2, F_fk=1, F_fs=2, u_dd=u_dd, dt=step, x_r=5)
    assert response.events.kind.tolist() == [-1]


def test_freely_decaying_mass_does_not_stop_when_its_velocity_underflows() -> None:
    still = Sines((), (), ())
    response = StickSlip().solve(
        PLANT, CoulombLaw(1.0, 2.0), still, State(5.0, 0.0), 1.0, 2000.0
    )
    assert response.events.kind.tolist() == [-1]


def test_barely_underdamped_creep_stops_when_its_half_swing_ends() -> None:
    xi = 0.999
    response = drysim.simulate(
        m=1, k_x=1, b=2 * xi, F_fk=1, F_fs=2, u_dd=np.zeros(1001), dt=0.1, x_r=5
    )
    assert response.events.kind.tolist() == [-1, 0]
    assert response.events.t[1] == pytest.approx(np.pi / np.sqrt(1 - xi**2), rel=1e-8)


@pytest.mark.parametrize("step", [0.5, 1.0, 4.8])
@pytest.mark.parametrize("b", [2.0, 2.5, 20.0])
def test_creep_is_the_same_by_every_core_and_mirrored(step: float, b: float) -> None:
    plant, friction, start = Plant(1.0, 1.0, b), (1.0, 1.5), State(5.0, 0.0)
    u_dd = silence(step, 120.0 * step)
    motion = Samples(u_dd, step)
    whole = StickSlip().solve(plant, CoulombLaw(*friction), motion, start, step, None)
    mirrored = StickSlip().solve(
        plant, CoulombLaw(*friction), Samples(-u_dd, step), State(-5.0, 0.0), step, None
    )
    assert np.array_equal(mirrored.x_r, -whole.x_r)
    assert np.array_equal(mirrored.events.t, whole.events.t)
    steady = NormalForceRecord(np.ones(len(u_dd)), step, 1.0)
    pressed = exact.solve(
        plant, separating_law(*friction, force_record=steady), motion, start, step, None, True
    )
    far = piecewise.compute_trajectory(plant, stopped_law(*friction, 1e3), motion, start, None)
    for events in (pressed.events, far.events):
        assert events.kind.tolist() == whole.events.kind.tolist()
        assert events.t == pytest.approx(whole.events.t, rel=1e-9, abs=1e-9 * step)
    assert pressed.x_r == pytest.approx(whole.x_r, abs=1e-13)


def test_creep_handed_over_between_blocks_goes_on_to_the_last_bit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion = Samples(silence(0.05, 200.0), 0.05)
    scene = (PLANT, CoulombLaw(1.0, 2.0), motion, State(5.0, 0.0), motion.dt, None)
    whole = StickSlip().solve(*scene)
    monkeypatch.setattr(coulomb, "MAX_CACHED", 0)
    monkeypatch.setattr(coulomb, "BLOCK_SIZE", CHUNK)
    parts = StickSlip().solve(*scene, whole=False)
    assert len(parts.trajectory.march.checkpoints) > 10
    assert np.array_equal(parts.x_r, whole.x_r)
    assert np.array_equal(parts.events.t, whole.events.t)


@pytest.mark.parametrize("seed", [13, 26, 35])
def test_spring_contact_at_its_limit_on_a_silent_base_makes_no_storm_of_events(
    seed: int,
) -> None:
    rng = np.random.Generator(np.random.PCG64(seed))
    pulses, gap = rng.uniform(-2, 2, 3), np.zeros(rng.integers(20, 60))
    u_dd = np.concatenate([pulses, gap, rng.uniform(-2, 2, 4), np.zeros(5)])
    step = rng.uniform(2.0, 5.0)
    plant = Plant(1.3, 2.7, 2.0 * np.sqrt(1.3 * 2.7))
    scene = elastic_law(0.9, 1e3), Samples(u_dd, step), State(0.0, 0.0), step, None, True
    response = exact.solve(plant, *scene)
    mirrored = exact.solve(plant, scene[0], Samples(-u_dd, step), *scene[2:])
    assert np.array_equal(mirrored.x_r, -response.x_r)
    fine = np.interp(np.arange(2 * len(u_dd) - 1) / 2, np.arange(len(u_dd)), u_dd)
    halved = exact.solve(
        plant, scene[0], Samples(fine, step / 2), scene[2], step / 2, None, True
    )
    assert halved.x_r[::2] == pytest.approx(response.x_r, abs=1e-11)


# A long motion is solved and written part by part: the same, to the last bit, as the whole.


START = State(0.001, 0.02)
LAWS = {
    "friction": CoulombLaw(45.0, 54.0),
    "variation": CoulombLaw(30.0, 40.0, 0.5, 20.0, 0.3),
    "none": CoulombLaw(0.0, 0.0),
}
TIGHT = StrokeLimits(0.0011, 0.0008)
PIECEWISE = {
    "bumper": PiecewiseLaw(30.0, 36.0, stops=EndStops(TIGHT, ((0.0, 2e4), (1e-3, 3e4)), 300.0)),
    "rigid": PiecewiseLaw(30.0, 36.0, stops=EndStops(TIGHT, e=0.5)),
    "elastic": PiecewiseLaw(30.0, 30.0, 1e5),
    "elastic between stops": PiecewiseLaw(30, 30, 1e5, stops=EndStops(TIGHT, ((0.0, 2e4),))),
    "by direction": PiecewiseLaw(45.0, 54.0, compression=(20.0, 30.0), damping=(300.0, 700.0)),
}
STEP, LENGTH, SIZE = 2.5e-3, 6001, CHUNK


@pytest.fixture
def motion():
    """Return a random base motion."""
    random = np.random.Generator(np.random.PCG64(3))
    return Samples(random.standard_normal(LENGTH), STEP)


@pytest.fixture
def small(monkeypatch):
    """Make everything long: blocks of a few samples."""
    for module in (coulomb, responses, piecewise):
        monkeypatch.setattr(module, "MAX_CACHED", 0)
        monkeypatch.setattr(module, "BLOCK_SIZE", SIZE)


@pytest.mark.parametrize("law", LAWS | PIECEWISE)
@pytest.mark.parametrize("duration", [None, 14.0, 13.9987])
def test_parts_of_a_march_are_those_of_the_whole(law, duration, motion, small):
    scene = (PAPER, (LAWS | PIECEWISE)[law], motion, START, STEP, duration)
    whole, parted = StickSlip().solve(*scene), StickSlip().solve(*scene, whole=False)
    assert len(parted.trajectory.march.checkpoints) > 20
    assert len(whole.trajectory.march.checkpoints) == 1
    for name in ("t", "kind", "x_r", "F_L"):
        assert np.array_equal(getattr(parted.events, name), getattr(whole.events, name))
    for part in parted.parts():
        for one, other in zip(parted.points(part), whole.points(part), strict=True):
            assert np.array_equal(one, other)
        assert np.array_equal(parted.acceleration(part), whole.acceleration(part))
        assert np.array_equal(parted.friction(part), whole.friction(part))
    assert (0, len(parted)) not in parted.grid.cached
    assert np.array_equal(parted.x_r, whole.x_r)
    assert np.array_equal(parted.d, whole.d)


@pytest.mark.parametrize(("F", "first"), [(0.0, 0), (1.0, 1), (2.0, 2)])
def test_state_after_a_break_away_at_a_sample_is_that_of_finer_samples(F, first):
    """ü rises so that F_L is at its limit exactly at a sample."""
    plant, law, dt = Plant(1.0, 4.0, 0.1), CoulombLaw(F, F), 0.25
    u_dd = np.concatenate(([0.0], np.arange(8.0), [3.0, -2.0, 0.0, 1.0]))[1:]
    coarse = exact.compute_trajectory(plant, law, Samples(u_dd, dt), State(0.0, 0.0), None)
    assert coarse.events.t[1 - (F == 0.0)] == first * dt
    finer = np.interp(np.arange(16 * (len(u_dd) - 1) + 1) / 16, np.arange(len(u_dd)), u_dd)
    fine = StickSlip().solve(plant, law, Samples(finer, dt / 16), State(0.0, 0.0), dt / 16)
    x_r, v_r = np.array([coarse.state(t) for t in fine.t.tolist()]).T
    assert x_r == pytest.approx(fine.x_r, rel=1e-12, abs=1e-14)
    assert v_r == pytest.approx(fine.v_r, rel=1e-12, abs=1e-13)
    size = float(np.abs(fine.x_r).max())
    for share in (1e-6, 0.01, 0.5, 0.9):
        limits = StrokeLimits(share * size, 0.9 * share * size)
        ours, theirs = (stroke.excursions(one, limits) for one in (coarse, fine.trajectory))
        assert ours == pytest.approx(theirs, rel=1e-11)


def test_part_without_points_is_not_taken_for_the_whole(motion, small):
    response = StickSlip().solve(PAPER, LAWS["friction"], motion, START, STEP, whole=False)
    assert len(response.points(slice(0, 0)).x_r) == 0
    assert len(response.x_r) == len(response) == LENGTH


@pytest.mark.parametrize("law", LAWS | PIECEWISE)
def test_metrics_of_parts_are_those_of_the_whole(law, motion, small):
    scene = (PAPER, (LAWS | PIECEWISE)[law], motion, START, STEP, 9.7)
    window = (0.7003, 9.7)
    whole, parted = (
        measure(response.trajectory, window, StrokeLimits(0.004, 0.004))
        for response in (StickSlip().solve(*scene), StickSlip().solve(*scene, whole=False))
    )
    for name, value in whole.items():
        if name in ("energy_residual", "law_residual"):
            assert max(value, parted[name]) < 1e-12
        elif value is None:
            assert parted[name] is None
        else:
            # The energy that a bumper keeps is a difference of equal ones.
            tiny = 1e-14 if name == "energy_stops" else 0
            assert parted[name] == pytest.approx(value, rel=1e-12, abs=tiny), name


@pytest.mark.parametrize("law", LAWS)
def test_parts_under_sines_are_those_of_the_whole(law, small):
    sines = Sines((1.0, 0.7), (1.3, 4.1), (0.0, 0.4))
    parted = StickSlip().solve(PAPER, LAWS[law], sines, START, STEP, 14.0, whole=False)
    parts = [parted.points(part) for part in parted.parts()]
    whole = parted.grid.evaluate(0, len(parted))
    assert len(parts) > 20
    for name in ("x_r", "v_r", "d", "x_dd"):
        joined = np.concatenate([getattr(points, name) for points in parts])
        assert np.array_equal(joined, getattr(whole, name))
    base = np.concatenate([parted.base(part) for part in parted.parts()])
    assert np.array_equal(base, parted.grid.base(0, len(parted)))


def test_blocks_begin_where_a_march_may_be_handed_over():
    assert BLOCK_SIZE % CHUNK == coulomb.SAMPLES_PER_CALL % CHUNK == 0


def test_any_stretch_of_a_march_can_be_had(motion, small):
    parted = StickSlip().solve(PAPER, LAWS["friction"], motion, START, STEP, whole=False)
    x_r = StickSlip().solve(PAPER, LAWS["friction"], motion, START, STEP).x_r
    for first, last in ((0, 1), (5, 100), (SIZE - 1, SIZE + 1), (LENGTH - 10, LENGTH)):
        assert np.array_equal(parted.points(slice(first, last)).x_r, x_r[first:last])


def test_viscous_by_parts_has_nothing_stuck(motion, small):
    parted = Viscous().solve(PAPER, LAWS["friction"], motion, START, STEP, whole=False)
    assert all((parted.points(part).d == 1).all() for part in parted.parts())


def test_excursion_across_parts_is_one(motion, small):
    parted = StickSlip().solve(PAPER, LAWS["friction"], motion, START, STEP, whole=False)
    whole = StickSlip().solve(PAPER, LAWS["friction"], motion, START, STEP)
    limit = 0.3 * response.largest_magnitude(whole, "x_r").value
    over = np.abs(whole.x_r) >= limit
    begins = np.diff(over, prepend=False) & over
    assert len(excursions(parted, StrokeLimits(limit, limit))) == np.count_nonzero(begins)
    assert response.largest_magnitude(parted, "x_r", 70) == (
        np.abs(whole.x_r[70:]).max(), 70 + np.abs(whole.x_r[70:]).argmax()
    )  # fmt: skip


# Integrals over samples: sums over whole steps are those of the motion between the samples.


NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)


def integrals(trajectory, begin, end):
    """Return the integrals of `Totals` up to ü², by quadrature between samples and events."""
    (m, k_x, b), F_fk = trajectory.plant, trajectory.law.F_fk
    motion, sums = trajectory.march.motion, np.zeros(7)
    samples = np.arange(len(motion.u_dd)) * motion.dt
    inner = np.concatenate((samples, trajectory.events.t))
    edges = np.unique(np.concatenate(([begin, end], inner[(inner > begin) & (inner < end)])))
    for lo, hi in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        t = 0.5 * (lo + hi) + 0.5 * (hi - lo) * NODES
        x, v = np.array([trajectory.state(s) for s in t.tolist()]).T
        u_dd = np.interp(t, samples, motion.u_dd)
        d = np.sign(v)
        x_dd = np.where(d == 0, u_dd, -(k_x * x + b * v + d * F_fk) / m)
        values = (x * x, v * v, x_dd**2, u_dd * v, np.abs(v), d == 0, u_dd**2)
        sums += 0.5 * (hi - lo) * np.array(values, dtype=float) @ WEIGHTS
    return sums


@pytest.mark.parametrize(
    "plant", [(75.0, 7500.0, 500.0), (75.0, 0.0, 0.0), (75.0, 7.5e5, 500.0)]
)
@pytest.mark.parametrize("F", [(15.0, 15.0), (30.0, 36.0), (0.0, 0.0), (500.0, 500.0)])
@pytest.mark.parametrize("window", [(0.0, 0.9975), (0.2811, 0.92)])
def test_integrals_over_samples_are_those_of_the_motion(plant, F, window, monkeypatch):
    monkeypatch.setattr(coulomb, "BLOCK_SIZE", 256)
    noise = np.random.Generator(np.random.PCG64(9)).normal(size=400)
    motion = Samples(0.2 * np.convolve(noise, np.hanning(41), mode="same"), 2.5e-3)
    scene = Plant(*plant), CoulombLaw(*F), motion, State(0.002, -0.01)
    trajectory = exact.compute_trajectory(*scene, None)
    found = trajectory.totals(*window)[:7]
    assert found == pytest.approx(integrals(trajectory, *window), rel=1e-11, abs=1e-20)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("law", LAWS | PIECEWISE)
def test_excursions_found_block_by_block_are_those_found_by_states(law, seed, motion, small):
    """Limits are drawn; one is the position of a stop, and one is never left."""
    law, rng = (LAWS | PIECEWISE)[law], np.random.default_rng(seed)
    scene = PAPER, law, motion, START, 14.0
    parted, whole = (exact.compute_trajectory(*scene, kept) for kept in (False, True))
    end = float(whole.state(whole.end).x_r)
    size = float(np.abs(whole.path.x_r).max())
    drawn = [StrokeLimits(*(size * rng.uniform(0.01, 1.0, 2)).tolist()) for _ in range(5)]
    crossed = 0
    for limits in (*drawn, TIGHT, StrokeLimits(1e-9 * size, 2.0 * size)):
        found = stroke.excursions(parted, limits)
        assert found == pytest.approx(stroke.excursions(whole, limits), rel=1e-9)
        crossings = stroke.crossings_of(whole.path, end, whole.end, limits)
        by_states = responses.Trajectory.crossing_times(whole, crossings)
        assert parted.crossing_times(crossings) == pytest.approx(by_states, rel=1e-11)
        assert (by_states >= crossings.low).all()
        assert (by_states <= crossings.high).all()
        crossed += len(by_states)
    assert crossed > 20


# Sines on a grid: stepping from point to point gives what the events alone give.


ONE = Sines((1.06,), (2.0,), (0.3,))
SINES_TWO = Sines((1.4, 0.9), (1.1, 3.7), (0.4, 1.0))
REST = Sines((), (), ())
SCENES = {
    "one sine": (PAPER, CoulombLaw(45.0, 54.0), ONE, 2.5e-3),
    "two sines": (PAPER, CoulombLaw(30.0, 36.0), SINES_TWO, 2.5e-3),
    "varying friction": (PAPER, CoulombLaw(30.0, 36.0, 0.4, 10.7, 0.2), SINES_TWO, 2.5e-3),
    "no friction": (PAPER, CoulombLaw(0.0, 0.0), SINES_TWO, 2.5e-3),
    "no damping": (Plant(75.0, 7500.0, 0.0), CoulombLaw(15.0, 15.0), ONE, 2.5e-3),
    "no spring": (Plant(75.0, 0.0, 500.0), CoulombLaw(45.0, 45.0), ONE, 2.5e-3),
    "nothing but friction": (Plant(75.0, 0.0, 0.0), CoulombLaw(45.0, 45.0), ONE, 2.5e-3),
    "fifty times critical": (Plant(75.0, 7500.0, 75000.0), CoulombLaw(15.0, 18.0), ONE, 2.5e-3),
    "fifty radians a step": (Plant(75.0, 3e10, 1e5), CoulombLaw(15.0, 18.0), ONE, 2.5e-3),
    "free motion": (Plant(1.0, 1.0, 0.0), CoulombLaw(0.01, 0.01), REST, 0.01),
}


def assert_states_of_the_trajectory(response):
    """Check that points of the grid are states of the motion."""
    states = np.array([response.trajectory.state(t)[:2] for t in response.t.tolist()])
    for series, column in zip((response.x_r, response.v_r), states.T, strict=True):
        assert np.abs(series - column).max() <= 1e-12 * np.abs(column).max()


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_grid_has_the_states_between_the_events(scene):
    plant, law, motion, step = scene
    found = StickSlip().solve(plant, law, motion, State(0.02, 0.1), step, 2000 * step)
    assert_states_of_the_trajectory(found)
    assert np.abs(found.u_dd - base_acceleration(motion, found.t)).max() < 1e-13
    forces = plant.m * found.x_dd, plant.b * found.v_r, plant.k_x * found.x_r, found.F_f
    assert np.abs(sum(forces)).max() <= 1e-13 * max(np.abs(force).max() for force in forces)
    assert (found.x_dd[found.stuck] == found.u_dd[found.stuck]).all()


@pytest.mark.parametrize("law", LAWS | PIECEWISE)
def test_points_at_samples_obey_newton_and_are_those_of_the_motion_there(law, motion):
    found = StickSlip().solve(PAPER, (LAWS | PIECEWISE)[law], motion, START, STEP, 9.7)
    (m, k_x, b), damping = PAPER, found.law.damping
    b = b if damping is None else np.where(found.v_r > 0.0, *damping)
    forces = m * found.x_dd, b * found.v_r, k_x * found.x_r, found.F_f, found.F_stop
    assert np.abs(sum(forces)).max() <= 1e-13 * max(np.abs(force).max() for force in forces)
    assert_states_of_the_trajectory(found)
    assert (found.x_dd[found.stuck] == found.u_dd[found.stuck]).all()


def test_friction_only_takes_at_every_point_also_where_the_motion_dies_out():
    # Far above critical damping the mass creeps to its place and never stops.
    plant, law = Plant(75.0, 7500.0, 15000.0), CoulombLaw(1.0, 1.0)
    found = StickSlip().solve(plant, law, REST, State(0.02, 0.0), 0.05, 200.0)
    assert (found.F_f * found.v_r >= 0.0).all()
    assert not found.stuck.any()
    assert_states_of_the_trajectory(found)


def test_blocks_of_a_grid_are_those_of_the_whole_to_the_last_bit():
    plant, law, motion, step = SCENES["two sines"]
    found = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 3000 * step)
    for first, last in ((0, 7), (100, 1000), (255, 258), (1777, 3001)):
        part = found.grid.evaluate(first, last)
        assert (part.x_r == found.x_r[first:last]).all()
        assert (part.v_r == found.v_r[first:last]).all()
        assert (part.x_dd == found.x_dd[first:last]).all()
        assert (found.grid.base(first, last) == found.u_dd[first:last]).all()


def test_mirrored_base_gives_the_mirrored_grid_to_the_last_bit():
    plant, law, motion, step = SCENES["two sines"]
    mirrored = motion._replace(A=tuple(-A for A in motion.A))
    one = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 3000 * step)
    other = StickSlip().solve(plant, law, mirrored, State(0.0, 0.0), step, 3000 * step)
    assert (one.x_r == -other.x_r).all()
    assert (one.v_r == -other.v_r).all()
    assert (one.x_dd == -other.x_dd).all()


def test_base_is_computed_for_those_who_ask_for_it():
    plant, law, motion, step = SCENES["one sine"]
    found = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 300 * step)
    assert len(found.x_r) == len(found.v_r) == 301
    assert "u_dd" not in vars(found)


@pytest.mark.parametrize("room", [2, 3, 7])
def test_room_for_events_that_grows_leaves_no_trace(room, monkeypatch):
    plant, law, motion, step = SCENES["two sines"]
    scene = (plant, law, motion, State(0.02, 0.1), step, 3000 * step)
    one = StickSlip().solve(*scene)
    monkeypatch.setattr(coulomb, "INITIAL_EVENT_CAPACITY", room)
    other = StickSlip().solve(*scene)
    assert len(one.events) > 20
    for name in ("t", "kind", "x_r", "F_L"):
        assert np.array_equal(getattr(one.events, name), getattr(other.events, name))
    assert one.numerics.closest_decision == other.numerics.closest_decision


def test_motion_under_sines_with_more_events_than_memory_holds_is_refused(monkeypatch):
    """A motion whose events crowd must end in a message, not fill the memory."""
    monkeypatch.setattr(progress, "MAX_EVENTS", 1_500)
    monkeypatch.setattr(progress, "MAX_EVENTS_PER_INTERVAL", 0)
    law, base = CoulombLaw(15.0, 15.0), Sines((2.0,), (1.6,), (0.0,))
    with pytest.raises(SolverError, match="too many events: "):
        StickSlip().trajectory(PAPER, law, base, State(0.0, 0.0), 2e3)


def test_limit_on_events_under_sines_grows_with_all_periods_of_a_long_motion(monkeypatch):
    class Asked(Exception):
        pass

    def asked(count, periods, t):
        raise Asked(periods)

    monkeypatch.setattr(coulomb, "check_event_count", asked)
    with pytest.raises(Asked) as caught:
        coulomb.sine_trajectory(PAPER, CoulombLaw(15.0, 18.0), ONE, State(0.0, 0.0), 1e6)
    assert caught.value.args[0] > 2e6
