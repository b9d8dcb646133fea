"""Spring contacts, jenkins and petrov-ewins: against a state machine, limits, invariants."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from contacts import at, march_contact
from invariants import Invariants, TouchingZero
from law_scenes import PAPER, REST, STEP, doubled, elastic_law, mirrored, noise, sine, solved
from paths import measured_path
from reference import assert_agrees, peak

from drysim.approach import piecewise
from drysim.approach.buffers import empty_columns, empty_log, empty_samples
from drysim.approach.piecewise import PiecewiseTrajectory, mode_steps_table, to_kernel
from drysim.approach.stick_slip import StickSlip
from drysim.core.events import SLIP, STICK, Segments
from drysim.core.forcing import Scene, Waves
from drysim.core.march import Course, MarchState, ModesLog, march_modes
from drysim.core.model import (
    BRISTLE,
    NO_LIMITS,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
    base_acceleration,
)
from drysim.core.modes import APART, HOLD, mode_of
from drysim.errors import SolverError
from drysim.metrics.energy import contact_energy
from drysim.metrics.stroke import excursions, path_measures
from drysim.metrics.table import measure
from drysim.orbits.search import find_orbit

NOISE = noise(1200, 1.0, seed=3)
CONTACTS = {
    "stiff": elastic_law(45.0, 1e5),
    "soft": elastic_law(45.0, 2e4),
    "swinging": elastic_law(30.0, 1e5, 0.5, 2 * math.pi * 2.3, 0.4),
    "lifting": elastic_law(30.0, 1e5, 1.6, 2 * math.pi * 0.7, 0.4),
    "hammering": elastic_law(30.0, 5e4, 1.3, 2 * math.pi * 5.7, 0.0),
}
each_contact = pytest.mark.parametrize("law", CONTACTS.values(), ids=CONTACTS)
each_motion = pytest.mark.parametrize("motion", [sine(1.0, 1.6), NOISE], ids=["sine", "noise"])


@pytest.mark.parametrize("sampled", [False, True])
@each_contact
def test_contact_agrees_with_a_state_machine(law, sampled):
    motion, end = (NOISE, 0.6) if sampled else (sine(1.0, 1.6), 1.5)
    response = solved(law, motion, duration=end)
    kinks = np.arange(len(NOISE.u_dd)) * STEP if sampled else ()

    def base(t):
        if sampled:
            return np.interp(t, kinks, NOISE.u_dd)
        return motion.A[0] * math.sin(2 * math.pi * 1.6 * t)

    def known(rtol):
        return at(march_contact(PAPER, law, base, end, kinks=kinks, rtol=rtol), response.t)

    x_r, v_r = response.x_r, response.v_r
    rounding = (1e-12, 1e-11) if sampled else (1e-11, 1e-10)
    assert_agrees([x_r, v_r], known, [rounding[0] * peak(x_r), rounding[1] * peak(v_r)])


@each_contact
@each_motion
class TestInvariants(Invariants):
    def test_force_is_within_its_limit_and_smooth(self, law, motion):
        response = solved(law, motion, duration=2.9)
        load = 1.0 + law.variation * np.sin(law.omega * response.t + law.phase)
        limit = law.F_fk * np.maximum(load, 0.0)
        assert (np.abs(response.F_f) <= limit * (1.0 + 1e-12) + 1e-9).all()
        fastest = law.k_t * np.abs(response.v_r).max() + law.F_fk * law.variation * law.omega
        assert np.abs(np.diff(response.F_f)).max() <= fastest * response.dt * (1.0 + 1e-9)


class TestTouchingZero(TouchingZero):
    law = elastic_law(30.0, 1e5, 1.0, 2 * math.pi * 2.3)


def test_contact_that_outruns_its_limit_at_the_start_yields_from_the_start():
    law = elastic_law(1.0, 1e3, 0.5, 2.0, 1.0)
    reach = 1e-3 * (1.0 + 0.5 * math.sin(1.0))
    for v_r, name in ((1e-3, "slip+"), (3e-4, "stick")):  # the limit grows by 5.4e-4 m/s
        found = solved(law, Sines((), (), ()), ContactState(reach, v_r, 0.0), duration=0.1)
        assert found.events.names[0] == name


@pytest.mark.parametrize("share", [0.91, 0.95, 0.999])
@pytest.mark.parametrize("side", [1, -1])
def test_contact_that_swings_past_its_limit_within_a_step_yields(side, share):
    # The peak lies amid the second step, which begins and ends at nine tenths of it.
    swing, turn = 1e-3, 0.9
    plant, law = Plant(1.0, 0.0, 0.0), elastic_law(share, 1e3)
    dt = turn / math.sqrt(1e3)
    v_r = swing * math.sqrt(1e3) * math.sin(1.5 * turn)
    start = ContactState(side * swing * math.cos(1.5 * turn), side * v_r, 0.0)
    coarse = solved(law, Samples(np.zeros(9), dt), start, plant=plant)
    fine = solved(law, Samples(np.zeros(8 * 16 + 1), dt / 16), start, plant=plant)
    assert coarse.x_r == pytest.approx(fine.x_r[::16], rel=1e-11, abs=1e-15)
    assert "slip+" in coarse.events.names or "slip-" in coarse.events.names


def test_contact_whose_time_does_not_move_on_is_told_as_a_storm():
    # After 1e20 s the next double is 16 384 s away, and this contact yields at each swing.
    begin, waves = 1e20, Waves(np.zeros(0), 0, 0)
    out = ModesLog(empty_columns(Segments, 1000), empty_log(1000), empty_samples(2))
    plant = Plant(1.0, 40.0, 0.0)
    law = to_kernel(plant, elastic_law(1.0, 1e3))
    scene = Scene(plant, law, waves, np.zeros(2), 2 * begin)
    state = MarchState(
        0, begin, 100.0, 0.0, math.nan, 100.0, mode_of(HOLD, 1, APART, 0), 0, 0, math.inf
    )
    course = Course(0, 2 * begin, 1, True, 1000)
    assert march_modes(scene, course, state, mode_steps_table(0), out).events == -1


def test_integrals_of_a_contact_that_holds_in_resonance_are_those_of_a_spring():
    plant, motion = Plant(75.0, 7500.0, 0.0), sine(1.0, math.sqrt(12500 / 75) / 2 / math.pi)
    one = solved(elastic_law(1e6, 5000.0), motion, duration=3.0, plant=plant)
    other = solved(
        CoulombLaw(0.0, 0.0), motion, duration=3.0, plant=plant._replace(k_x=12500.0)
    )
    totals, others = one.trajectory.totals(0.0, 3.0), other.trajectory.totals(0.0, 3.0)
    assert totals[:3] == pytest.approx(others[:3], rel=1e-10)


@pytest.mark.parametrize("side", [1, -1])
def test_contact_that_begins_at_its_limit_yields_at_once_to_a_push_beyond(side):
    # 3 N push the kilogram, the contact bears 1 N: it is off with 2 m/s².
    push = Samples(np.full(6, -3.0 * side), 0.1)
    start = ContactState(1e-3 * side, 0.0, 0.0)
    found = solved(elastic_law(1.0, 1e3), push, start, plant=Plant(1.0, 0.0, 0.0))
    assert found.x_r == pytest.approx(side * (1e-3 + found.t**2), rel=1e-13)


@each_motion
@pytest.mark.parametrize("far", [1.001, 1.5, 30.0])
@pytest.mark.parametrize("side", [1, -1])
def test_contact_said_to_be_bent_beyond_its_limit_has_given_way_to_it(motion, side, far):
    law, limit = elastic_law(45.0, 1e5), 45.0 / 1e5
    for v_r in (0.0, -1e-4 * side, -3e-3 * side):
        beyond, at_limit = (
            solved(law, motion, ContactState(0.0, v_r, -side * z), 0.5)
            for z in (far * limit, limit)
        )
        assert np.abs(beyond.F_f).max() <= law.F_fk * (1 + 1e-12)
        assert np.array_equal(beyond.x_r, at_limit.x_r)


@each_motion
def test_limit_that_is_met_just_after_a_run_is_not_met_in_it(motion):
    path = solved(CONTACTS["stiff"], motion, duration=1.5).trajectory.path
    far = np.abs(path.x_r)
    highest = np.flatnonzero(far[1:] > np.maximum.accumulate(far)[:-1]) + 1
    assert len(highest) > 3
    for t, limit in zip(path.t[highest].tolist(), far[highest].tolist(), strict=True):
        trajectory = solved(CONTACTS["stiff"], motion, duration=t - 0.05 * STEP).trajectory
        limits = StrokeLimits(limit, limit)
        found = trajectory.path
        assert found.t.max() <= trajectory.end
        assert excursions(trajectory, limits)[:2] == (0, 0)


@each_motion
def test_homogeneity(motion):
    law = CONTACTS["stiff"]
    one = solved(law, motion, duration=2.9)
    two = solved(law._replace(F_fk=2 * law.F_fk), doubled(motion), duration=2.9)
    assert (two.x_r == 2 * one.x_r).all()


@each_contact
def test_grid_under_sines_is_the_motion_read_point_by_point(law):
    """Whole and in part, by sums of a table's columns; phases round at 20 s in 1e-13."""
    motion = Sines((1.0, 0.7, 0.5), (1.6, 0.9, 3.3), (0.0, 1.0, 2.0))
    response = solved(law, motion, duration=20.0)
    x_r, v_r, _, _, F_f, *_ = response.trajectory.at(response.t)
    assert np.abs(response.x_r - x_r).max() < 3e-13 * np.abs(x_r).max()
    assert np.abs(response.v_r - v_r).max() < 3e-13 * np.abs(v_r).max()
    assert np.abs(response.F_f - F_f).max() < 3e-13 * law.k_t * np.abs(x_r).max()
    part = response.grid.evaluate(777, 1500)
    assert (part.x_r == response.x_r[777:1500]).all()
    assert (part.F_f == response.F_f[777:1500]).all()
    assert (response.grid.base(777, 1500) == response.u_dd[777:1500]).all()


@each_motion
@each_contact
def test_direction_on_the_grid_is_the_sign_of_the_velocity(law, motion):
    response = solved(law, motion, duration=2.0)
    moves = response.v_r != 0.0
    assert (response.d[moves] == np.sign(response.v_r[moves])).all()


RINGING = {
    "holding": elastic_law(150.0, 1e6),
    "yielding": elastic_law(45.0, 1e7),
    "swinging": elastic_law(45.0, 1e7, 0.3, 2 * math.pi * 2.3, 0.4),
}
each_ringing = pytest.mark.parametrize("law", RINGING.values(), ids=RINGING)
WAVES = Sines((0.45, 0.1), (1.6, 0.9), (0.0, 1.0))


@pytest.mark.parametrize("motion", [WAVES, NOISE])
@each_ringing
def test_path_of_a_ringing_contact_tells_what_a_fine_grid_does(law, motion):
    """Peaks, passages of zero and of limits that the ringing crosses and those it does not."""
    trajectory = StickSlip().trajectory(PAPER, law, motion, State(0.0, 0.01), 1.5)
    grid, levels = np.linspace(0.0, 1.5, 60_001), np.linspace(0.05, 1.05, 21)
    fine = seen(trajectory, grid)
    for window in ((0.0, 1.5), (0.311, 1.107)):
        inside = fine[(grid >= window[0]) & (grid <= window[1])]
        found, peaks = path_measures(trajectory, (*window, window[1]), NO_LIMITS)
        expected, heights = measured_path(inside)
        assert found.lowest == pytest.approx(inside.min(), rel=1e-6)
        assert found.highest == pytest.approx(inside.max(), rel=1e-6)
        before = fine[grid <= window[1]]
        assert found.run_lowest == pytest.approx(before.min(), rel=1e-6)
        assert found.run_highest == pytest.approx(before.max(), rel=1e-6)
        assert found.upcrossings == expected.upcrossings
        assert peaks == pytest.approx(heights, rel=1e-3)
        for level in (levels * np.abs(inside).max()).tolist():
            limits = StrokeLimits(level, level)
            found = path_measures(trajectory, (*window, window[1]), limits)[0]
            assert found.entries == measured_path(inside, limits)[0].entries
            beyond = np.abs(fine) >= level
            up, down, _, t_beyond = excursions(trajectory, limits)
            times = up + down
            assert times == beyond[0] + np.count_nonzero(beyond[1:] & ~beyond[:-1])
            assert t_beyond == pytest.approx(1.5 * np.mean(beyond), abs=1e-5 * (times + 2))


@pytest.mark.parametrize("begin", [0.0, 11.0])
def test_half_cycle_within_a_long_hold_is_as_high_as_its_own_peak(begin):
    # Farther out on the same side the mass had been before: that tells of another half cycle,
    # or of the same one before a window that begins within it.
    law = elastic_law(40.0, 400.0, 0.99, 0.2 * math.pi)
    motion = Sines((50.0, 5.0), (0.5, 0.2), (0.0, 0.0))
    trajectory = StickSlip().trajectory(
        Plant(1.0, 4.0, 0.0), law, motion, State(0.0, 0.4), 20.0
    )
    window = (begin, 20.0)
    heights = measured_path(trajectory.at(np.linspace(*window, 400_001))[0])[1]
    told = path_measures(trajectory, (*window, window[1]), NO_LIMITS)[1]
    assert told == pytest.approx(heights, rel=1e-5)


def seen(trajectory, t):
    """Return x_r at equidistant times from 0 on [s]; samples are taken as finer ones are."""
    if isinstance(trajectory, PiecewiseTrajectory):
        return trajectory.at(t)[0]
    known = np.arange(len(trajectory.u_dd)) * trajectory.motion.dt
    finer = Samples(np.interp(t, known, trajectory.u_dd), t[1])
    return solved(trajectory.law, finer, trajectory.state(0.0)).x_r


@each_ringing
def test_ringing_contact_follows_an_integrator(law):
    start = State(0.0, 0.01)
    trajectory = StickSlip().trajectory(PAPER, law, WAVES, start, 1.0)

    def base(t):
        waves = zip(*WAVES, strict=True)
        return sum(A * math.sin(2 * math.pi * f * t + phase) for A, f, phase in waves)

    t = np.linspace(0.0, 1.0, 4001)

    def known(rtol):
        pieces = march_contact(PAPER, law, base, 1.0, start, rtol=rtol)
        slides = [mode != "hold" for _, _, _, mode in pieces]
        assert slides == (np.abs(trajectory.events.kind) == SLIP).tolist()
        return *at(pieces, t), [begin for begin, _, _, _ in pieces]

    x_r, v_r = trajectory.at(t)[:2]
    own = 1e-10 * peak(x_r), 1e-8 * peak(v_r), 1e-9
    assert_agrees([x_r, v_r, trajectory.events.t], known, own)


@pytest.mark.parametrize("motion", [sine(0.5, 1.6), NOISE], ids=["sine", "noise"])
@each_ringing
def test_turns_of_a_contact_that_rings_as_it_holds_are_no_events(law, motion):
    trajectory = StickSlip().trajectory(PAPER, law, motion, State(0.0, 0.01), 2.9)
    holds = trajectory.events.kind == STICK
    assert holds[0]
    assert (holds[1:] != holds[:-1]).all()
    assert (np.diff(trajectory.events.t) > 0.0).all()
    assert measure(trajectory, (0.4, 2.9), None)["energy_residual"] < 1e-12


@each_ringing
def test_mirrored_ringing_is_the_same_bit_for_bit(law):
    one, two = (solved(law, each, duration=2.0) for each in (WAVES, mirrored(WAVES)))
    assert (one.x_r == -two.x_r).all()
    assert (one.trajectory.march.block(0).rows.s == two.trajectory.march.block(0).rows.s).all()


@pytest.mark.parametrize("b", [0.0, 500.0, 3000.0])
@pytest.mark.parametrize("window", [(0.0, 2.0), (0.137, 1.731)])
def test_integrals_of_a_long_hold_are_those_of_its_motion(b, window):
    plant, motion = Plant(75.0, 7500.0, b), Sines((0.7, 0.4), (1.6, 3.7), (0.3, 1.0))
    trajectory = StickSlip().trajectory(
        plant, elastic_law(1e3, 1e5), motion, State(1e-4, 0.01), 2.0
    )
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(*window, 401)
    half = 0.5 * np.diff(edges)[:, None]
    t = (0.5 * (edges[1:] + edges[:-1])[:, None] + half * nodes).ravel()
    weights = (half * weights).ravel()
    x_r, v_r, _, _, F_f, *_ = trajectory.at(t)
    u_dd = base_acceleration(motion, t)
    x_dd = -(plant.k_x * x_r + b * v_r + F_f) / plant.m
    rows = x_r**2, v_r**2, x_dd**2, u_dd * v_r, F_f * v_r
    scales = [np.abs(row) @ weights for row in rows]
    totals = trajectory.totals(*window)
    assert totals.sliding_distance == 0.0
    # The work done on the contact is stored in its spring.
    before, after = (contact_energy(trajectory.law, trajectory.state(t)) for t in window)
    known = *totals[:4], after - before
    off = [row @ weights - total for row, total in zip(rows, known, strict=True)]
    assert (np.abs(off) < 1e-12 * np.array(scales)).all()


@each_motion
@pytest.mark.parametrize("law", (CONTACTS | RINGING).values(), ids=CONTACTS | RINGING)
def test_integrals_over_a_window_are_the_sums_of_those_over_its_parts(law, motion):
    """Parts of a millisecond take a few points each, and the whole what suits its pieces."""
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, 2.0)
    edges = np.linspace(0.3, 1.3, 1001).tolist()
    parts = np.array([trajectory.totals(*each)[:5] for each in pairwise(edges)])
    scale = np.abs(parts).sum(axis=0)
    # A contact that holds throughout slides nowhere.
    assert (np.abs(parts.sum(axis=0) - trajectory.totals(0.3, 1.3)[:5]) <= 2e-13 * scale).all()


def test_stiff_contact_comes_to_coulomb_as_one_over_its_stiffness():
    motion = sine(1.0, 1.6)
    coulomb = solved(CoulombLaw(45.0, 45.0), motion, duration=3.0).x_r
    errors = [
        np.abs(solved(elastic_law(45.0, k_t), motion, duration=3.0).x_r - coulomb).max()
        for k_t in (1e7, 1e8, 1e9)
    ]
    assert errors[2] < 3e-5
    assert errors[0] / errors[1] == pytest.approx(math.sqrt(10.0), rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(math.sqrt(10.0), rel=0.05)


def test_contact_that_never_yields_is_one_more_spring():
    motion = sine(0.5, 1.6)
    response = solved(elastic_law(1e6, 5e3), motion, duration=3.0)
    spring = solved(
        CoulombLaw(0.0, 0.0), motion, duration=3.0, plant=Plant(75.0, 12500.0, 500.0)
    )
    assert np.abs(response.x_r - spring.x_r).max() < 1e-14


def test_split_run_equals_the_whole():
    motion, law = NOISE, CONTACTS["stiff"]
    whole = solved(law, motion)
    rest = Samples(motion.u_dd[400:], motion.dt)
    part = solved(law, rest, start=whole.trajectory.state(400 * STEP))
    assert np.abs(part.x_r - whole.x_r[400:]).max() < 1e-12


def test_steps_of_any_length_give_one_motion():
    """Whole steps by their map, and the same steps looked into one by one."""
    motion, law = NOISE, CONTACTS["stiff"]
    finer = Samples(np.interp(np.arange(2399) / 2, np.arange(1200), motion.u_dd), STEP / 2)
    coarse, fine = solved(law, motion), solved(law, finer)
    assert np.abs(fine.x_r[::2] - coarse.x_r).max() < 1e-13


@pytest.mark.parametrize(
    "law",
    [CONTACTS["stiff"], CONTACTS["swinging"], DynamicLaw(45.0, 45.0, BRISTLE, sigma_0=1e5)],
    ids=["jenkins", "petrov-ewins", "dahl"],
)
@pytest.mark.parametrize("b", [0.0, 500.0, 5000.0])
@pytest.mark.parametrize("motion", [Sines((), (), ()), Samples(np.zeros(2001), 5e-3)])
@pytest.mark.parametrize("start", [State(0.01, 0.0), State(0.0, 0.1)], ids=["rest", "kick"])
def test_energy_of_a_contact_that_hardly_moves_is_no_open_balance(law, b, motion, start):
    """Nothing but the contact holds the mass: what is left of its motion is rounding."""
    trajectory = solved(law, motion, start, 10.0, Plant(75.0, 0.0, b)).trajectory
    for window in ((0.0, 10.0), (8.0, 10.0)):
        assert measure(trajectory, window, None)["energy_residual"] < 1e-8


def test_orbit_closes():
    orbit = find_orbit(PAPER, CONTACTS["soft"], sine(1.0, 1.6), REST, 1 / 1.6)
    assert orbit.settled
    assert orbit.closure <= 1e-12


@pytest.mark.parametrize("k_t", [1e5, 1e7, 1e9])
def test_orbit_that_begins_as_the_contact_yields_yields_on(k_t):
    law, period = elastic_law(45.0, k_t), 1 / 1.6
    for phase in np.linspace(0.0, 6.0, 13):
        motion = Sines((1.5,), (1.6,), (phase,))
        orbit = find_orbit(PAPER, law, motion, REST, period)
        response = StickSlip().solve(PAPER, law, motion, orbit.state, STEP, period)
        assert response.events.t[1] > 1e-9
        yields = abs(orbit.state.x_r - orbit.state.z) > 0.999999 * 45.0 / k_t
        assert (response.events.kind[0] != 0) == (yields and orbit.state.v_r != 0.0)


@pytest.mark.parametrize("k_t", [1e3, 1e5, 1e6, 1e7, 1e8, 1e9])
@pytest.mark.parametrize("b", [0.0, 500.0, 5000.0])
def test_march_agrees_with_the_general_way_at_any_stiffness(k_t, b):
    """A normal force that swings by next to nothing takes the way of one that varies."""
    plant, law = Plant(75.0, 7500.0, b), elastic_law(45.0, k_t)
    one = solved(law, NOISE, plant=plant)
    other = solved(law._replace(variation=1e-300, omega=1.0), NOISE, plant=plant)
    scale = np.abs(one.x_r).max()
    assert np.abs(one.x_r - other.x_r).max() < 1e-11 * scale
    assert np.abs(one.F_f - other.F_f).max() < 1e-9 * law.F_fk * max(1.0, k_t / 1e7)
    # The general way may stutter where the contact begins to hold: at the same instant.
    apart = np.abs(one.events.t[:, None] - other.events.t)
    assert apart.min(axis=0).max() < 1e-9
    assert apart.min(axis=1).max() < 1e-9
    sums, others = (np.array(each.trajectory.totals(0.4, 2.5)[:5]) for each in (one, other))
    assert sums == pytest.approx(others, rel=1e-9)


def test_state_between_samples_and_events_goes_on_from_both():
    response = solved(CONTACTS["stiff"], NOISE)
    trajectory, events = response.trajectory, response.events
    for t, x_r in zip(events.t[1:40].tolist(), events.x_r[1:40].tolist(), strict=True):
        assert trajectory.state(t).x_r == pytest.approx(x_r, abs=1e-16)
    found = trajectory.state(500 * STEP)
    assert (found.x_r, found.v_r) == (response.x_r[500], response.v_r[500])


@pytest.mark.parametrize("late", [-1e-9, 0.0, 1e-9])
def test_contact_that_yields_at_a_sample_is_followed_with_its_own_acceleration(late):
    plant, law = Plant(1.0, 0.0, 2.684230774197828), elastic_law(1.0, 76.82843978994063)
    dt, u_dd = 0.008723931482282812, np.full(65, -9.952050748899849)
    u_dd[9:] = 115.9606901843842
    start = ContactState(0.0, 0.1 + late, 0.0)
    found = StickSlip().solve(plant, law, Samples(u_dd, dt), start, dt)
    held = found.events.t[found.events.kind == 0]
    assert held[1] == pytest.approx(0.08015, abs=1e-5)
    assert found.v_r[10] == pytest.approx(-0.820, abs=1e-3)
    assert found.x_r[-1] == pytest.approx(-8.91917, abs=1e-4)
    fine = np.interp(np.arange(129) / 2, np.arange(65), u_dd)
    other = StickSlip().solve(plant, law, Samples(fine, dt / 2), start, dt / 2)
    assert other.x_r[::2] == pytest.approx(found.x_r, rel=1e-9, abs=1e-12)


@each_motion
@pytest.mark.parametrize("k_t", [1e4, 1e6])
def test_force_under_a_recorded_normal_force_is_that_of_a_return_mapping(k_t, motion):
    # The slope of the record jumps at each sample, so a yielding contact may hold at once.
    record = 1.0 + np.random.default_rng(5).normal(0.0, 0.6, 400)
    law = PiecewiseLaw(60.0, 60.0, k_t, force_record=NormalForceRecord(record, 0.01, 1.0))
    trajectory = solved(law, motion, duration=2.5).trajectory
    t = np.linspace(0.0, 2.5, 500_001)
    found = trajectory.at(t)
    limit = 60.0 * np.maximum(np.interp(t, np.arange(400) * 0.01, record), 0.0)
    force, known = 0.0, []
    for step, most in zip(np.diff(found.x_r).tolist(), limit[1:].tolist(), strict=True):
        force = min(max(force + k_t * step, -most), most)
        known.append(force)
    assert np.abs(found.F_f[1:] - known).max() < 0.05


def test_too_many_turning_points_are_an_error_that_names_them(monkeypatch):
    monkeypatch.setattr(piecewise, "MAX_SEGMENTS", 20_000)
    plant, law = Plant(75.0, 7500.0, 0.0), elastic_law(1e3, 1e8)
    with pytest.raises(SolverError, match="too many turning points"):
        solved(law, sine(1.0, 1.6), duration=60.0, plant=plant)
    assert len(solved(law, sine(1.0, 1.6), duration=30.0, plant=plant).trajectory.path.t) > 1e4
