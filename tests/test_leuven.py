"""Leuven's law: bristles that remember where they turned and come back to it."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hysteresis import swing
from invariants import Invariants
from law_scenes import PAPER, REST, STEP, halved, mirrored, noise, sine, solved
from reference import assert_agrees, peak

from drysim.approach.base_motion import make_waves
from drysim.approach.stick_slip import StickSlip
from drysim.approach.taylor import compute_trajectory, initial_checkpoint, workspace
from drysim.core.dynamic_friction import COUNT, DIRECTION, drop_smallest_loop
from drysim.core.forcing import Scene
from drysim.core.model import BRISTLE, LEUVEN, ContactState, DynamicLaw, Plant, Samples, Sines
from drysim.metrics.table import measure
from drysim.orbits.search import find_orbit
from drysim.scenario.load import load
from drysim.study.preparation import prepare

LAW = DynamicLaw(
    45.0, 54.0, LEUVEN, v_s=5e-3, sigma_0=1e5, sigma_1=300.0, sigma_2=0.4, F_h=80.0
)  # fmt: skip
WHOLE = [1.0, 2.0, 3.0]
POWERS = [*WHOLE, 0.5, 1.5, 5.0]


@pytest.mark.parametrize("power", [0.5, 0.8, *WHOLE, 1.5, 2.5, 4.0, 7.3, 19.0])
@pytest.mark.parametrize("a_u", [0.3, 1.0])
def test_motion_agrees_with_bristles_told_by_their_travel(power, a_u):
    law, motion = LAW._replace(power=power), sine(a_u, 1.6)
    response = solved(law, motion, duration=2.0)
    base = lambda t: motion.A[0] * math.sin(2.0 * math.pi * 1.6 * t)  # noqa: E731

    def x_r(rtol):
        return [swing(law, PAPER, base, 2.0, response.t, rtol=rtol)]

    assert_agrees([response.x_r], x_r, [1e-8 * peak(response.x_r)])
    assert response.numerics.error < (1e-7 if power < 10 else 1e-5)


RANDOM = """\
drysim: 1
oscillator: {mass: 80, stiffness: 6000, damping: 250}
friction:
  {law: leuven, kinetic: 30, static: 45, stribeck_velocity: 20 mm/s,
   bristle_stiffness: 100 kN/m, bristle_damping: 100}
excitation: {kind: psd, duration: 12 s, points: [[0.8, 0.3], [3, 0.6], [15, 0.02]], seed: 3}
solver: {step: 4 ms}
"""


def test_loop_that_closes_at_the_limit_leaves_the_bristles_there(tmp_path):
    """At 4.696 s speed leaves the limit alone and a loop of no width closes: no event storm."""
    scene = tmp_path / "scene.yaml"
    scene.write_text(RANDOM)
    case = prepare(load(scene))
    response = solved(case.law, case.motion, duration=5.0, plant=case.plant)
    assert response.numerics.error < 1e-8
    assert measure(response.trajectory, (0.0, 5.0), None)["energy_residual"] < 1e-10


def test_bristles_that_the_limit_turned_do_not_turn_back_at_the_same_instant():
    """At 9.609 s a loop of no width closes far above v_s, where the limit hardly moves."""
    law = DynamicLaw(
        5.468161957762935, 8.202242936644403, LEUVEN, v_s=0.004346186854937156,
        sigma_0=3802018.9144284255, sigma_2=50.0, F_h=8.202242936644403,
    )  # fmt: skip
    random = np.random.default_rng(556665)
    u_dd = np.convolve(random.standard_normal(3040), np.hanning(41), "valid")
    motion = Samples(3.0 * u_dd / u_dd.std(), 4e-3)
    response = solved(law, motion, duration=10.0, plant=Plant(80.0, 0.0, 250.0))
    assert response.numerics.error < 1e-8
    assert measure(response.trajectory, (0.0, 10.0), None)["energy_residual"] < 1e-10


STIFF = Plant(75.0, 0.0, 5000.0)
"""A mass that nothing but the contact holds, damped so well that it follows any slow force."""


def slow(levels, law, step=STEP):
    """Lead the friction force slowly from level to level [N], 2 s each."""
    n = round(2.0 / step)
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(n) / n)
    steps = pairwise(levels)
    force = np.concatenate([a + (b - a) * ramp for a, b in steps] + [levels[-1:]])
    return solved(law, Samples(-force / STIFF.m, step), plant=STIFF)


def travel(response, law):
    """Return how far the bristles have travelled [m], by the trapezoidal rule."""
    limit = law.F_fk + (law.F_fs - law.F_fk) * np.exp(-((response.v_r / law.v_s) ** 2))
    q = np.sign(response.v_r) * response.F_f / limit
    rate = response.v_r * (1.0 - np.sign(q) * np.abs(q) ** law.power)
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * response.dt)])


@pytest.mark.parametrize("power", POWERS)
def test_a_minor_loop_closes_where_it_began_and_is_forgotten(power):
    law = LAW._replace(power=power, sigma_1=0.0, sigma_2=0.0)
    response = slow([0.0, 20.0, 6.0, 26.0], law, 1e-4)
    x_r, F, z = response.x_r, response.F_f, travel(response, law)
    top = int(np.argmax(F[: len(F) // 2]))
    again = int(np.argmax((F[top] <= F) & (np.arange(len(F)) > len(F) // 2)))
    loop = z[top] - z[top:again].min()
    assert abs(z[again] - z[top]) < 2e-4 * loop  # the grid's own width
    assert response.trajectory.state(response.trajectory.end).reversals == ()
    assert np.abs(np.diff(F)).max() < 1e-2  # no jump, in closing neither
    assert x_r[again] > x_r[top]  # what is left is creep of the contact, not of the bristles


def test_lugre_creeps_through_the_minor_loop_that_leuven_closes():
    """The bristles of lugre give way in proportion to the force, Leuven's by its power."""
    lugre = LAW._replace(kind=BRISTLE, sigma_1=0.0, sigma_2=0.0)
    leuven = lugre._replace(kind=LEUVEN, power=3.0)
    gaps = []
    for law in (lugre, leuven):
        response = slow([0.0, 6.0, 0.0, 6.0, 0.0, 6.0], law)
        tops = response.x_r[[int(k / STEP) for k in (2.0, 6.0, 10.0)]]
        gaps.append((tops[2] - tops[1]) / np.ptp(response.x_r))
    assert gaps[0] > 0.05
    assert 0.0 < gaps[1] < 2e-3


class Row:
    """Maxwell's slip elements in a row, each a spring that slides at its limit.

    Their virgin curve is that of the bristles, straight between so many points.
    """

    def __init__(self, law, elements):
        scale = law.F_h / law.sigma_0
        self.reach = np.linspace(0.0, 2.0 * scale, elements + 1)[1:]
        curve = law.F_h * (1.0 - np.exp(-np.append(0.0, self.reach) / scale))
        slopes = np.diff(curve) / self.reach[0]
        self.stiffness = slopes - np.append(slopes[1:], 0.0)
        self.bent = np.zeros(elements)

    def follow(self, steps):
        """Return the force [N] after each step of travel [m]."""
        forces = []
        for step in steps:
            self.bent = np.clip(self.bent + step, -self.reach, self.reach)
            forces.append(self.stiffness @ self.bent)
        return np.array(forces)


def test_memory_is_the_limit_of_the_many_maxwell_elements_of_lampaert():
    law = LAW._replace(sigma_1=0.0, sigma_2=0.0)
    trajectory = StickSlip().trajectory(PAPER, law, noise(801, 0.3, seed=3), REST, 2.0)
    points = trajectory.at(np.linspace(0.0, 2.0, 20_001))
    v_r, z, F = points.v_r, points.z, points.F_f
    limit = law.F_fk + (law.F_fs - law.F_fk) * np.exp(-((v_r / law.v_s) ** 2))
    rate = v_r - np.abs(v_r) * law.sigma_0 * z / limit
    steps = 0.5 * (rate[1:] + rate[:-1]) * 1e-4
    off = [np.abs(Row(law, n).follow(steps) - F[1:]).max() for n in (10, 20, 40)]
    assert off[2] < 1e-3 * np.ptp(F)
    for coarse, fine in pairwise(off):
        assert coarse / fine == pytest.approx(4.0, rel=0.1)  # straight pieces of one curve
    assert max(len(trajectory.state(t).reversals) for t in np.arange(0.1, 2.0, 0.1)) > 5


def test_bristles_without_hysteresis_are_those_of_lugre():
    motion = sine(1.0, 1.6)
    lugre = solved(LAW._replace(kind=BRISTLE), motion, duration=3.0).x_r
    errors = [
        np.abs(solved(LAW._replace(F_h=F_h), motion, duration=3.0).x_r - lugre).max()
        for F_h in (1e4, 1e5, 1e6)
    ]
    assert errors[2] < 1e-5 * np.abs(lugre).max()
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(10.0, rel=0.02)


def test_a_full_memory_forgets_what_matters_least():
    """Free vibration within the contact turns inside its last turn every time."""
    plant, rest = Plant(75.0, 7500.0, 0.0), Samples(np.zeros(20_001), 1e-3)
    start = ContactState(1e-4, 0.0, 1e-4)
    law = LAW._replace(sigma_1=0.0, sigma_2=0.0)
    tracks = [
        StickSlip().trajectory(plant, law._replace(depth=depth), rest, start)
        for depth in (1024, 128, 16)
    ]
    ends = [trajectory.state(20.0) for trajectory in tracks]
    assert len(ends[0].reversals) > 200
    assert [len(end.reversals) for end in ends[1:]] == [127, 15]
    paths = [trajectory.at(np.linspace(0.0, 20.0, 1001))[0] for trajectory in tracks]
    scale = np.abs(paths[0]).max()
    assert np.abs(paths[1] - paths[0]).max() < 1e-12 * scale
    assert np.abs(paths[2] - paths[0]).max() < 1e-4 * scale


def risen(reversals, scale, travel):
    """Return z after some upward travel from the last of many reversals, loop by loop."""
    reversals, z = list(reversals), reversals[-1]
    while True:
        top = reversals[-1] + 2.0 * scale
        needs = 2.0 * scale * math.log((top - z) / (top - reversals[-2]))
        if needs > travel:
            return top - (top - z) * math.exp(-travel / (2.0 * scale))
        travel, z = travel - needs, reversals[-2]
        del reversals[-2:]


def test_a_memory_that_overflows_at_its_worst_moves_the_force_by_little():
    """As many turns as it holds, evenly within one another from limit to limit."""
    law = LAW._replace(F_h=2.0 * LAW.F_fs)
    limit, scale = law.F_fs / law.sigma_0, law.F_h / law.sigma_0
    reversals = np.linspace(limit, 0.0, law.depth, endpoint=False) * np.resize(
        [1, -1], law.depth
    )
    reversals[64] *= 1.0 + 1e-9  # so that they are forgotten in the midst
    series = workspace(law, 0.0)
    series.reversals[: law.depth], series.branch[COUNT] = reversals, law.depth
    drop_smallest_loop(series)
    kept = series.reversals[: series.branch[COUNT]]
    assert len(kept) == law.depth - 2
    path = np.linspace(0.0, 1.3 * limit, 1001)
    exact, near = (
        np.array([risen(each, scale, s) for s in path]) for each in (reversals, kept)
    )
    assert 0.9 * limit < exact[-1] < limit
    assert 1e-5 * limit < np.abs(near - exact).max() < 1.2e-4 * limit


@pytest.mark.parametrize("law", [LAW._replace(power=power) for power in POWERS], ids=POWERS)
@pytest.mark.parametrize("motion", [sine(0.6, 1.6), noise(2000, 0.8)], ids=["sine", "noise"])
class TestInvariants(Invariants):
    residual = 1e-10


def test_split_run_with_its_memory_equals_the_whole():
    motion = noise(2000, 0.8)
    whole = solved(LAW, motion, duration=4.0)
    first = solved(LAW, motion, duration=2.0)
    middle = first.trajectory.state(2.0)
    assert middle.reversals
    assert np.allclose(
        whole.trajectory.state(2.0).reversals, middle.reversals, rtol=1e-9, atol=0.0
    )
    rest = Samples(motion.u_dd[800:], motion.dt)
    part = solved(LAW, rest, start=middle, duration=2.0)
    assert np.abs(part.x_r - whole.x_r[800:]).max() < 1e-9 * np.abs(whole.x_r).max()
    deaf = solved(LAW, rest, start=middle._replace(reversals=()), duration=2.0)
    assert np.abs(deaf.x_r - whole.x_r[800:]).max() > 1e-6 * np.abs(whole.x_r).max()


SOFT = LAW._replace(F_fk=1.0, F_fs=1.0, v_s=0.5, sigma_0=10.0, sigma_1=1.0, sigma_2=0.0)


@pytest.mark.parametrize(
    ("first", "gap", "second"),
    [(-1.5, 32, 1.0), (1.5, 25, 2.0), (3.0, 40, 1.0), (-3.0, 15, -1.0)],
)
def test_pulse_after_a_silence_starts_on_the_branch_where_the_bristles_rest(first, gap, second):
    u_dd = np.zeros(gap + 6)
    u_dd[[1, 1 + gap]] = first, second
    law, plant, motion = SOFT._replace(F_h=1.5), Plant(1.0, 1.0, 2.0), Samples(u_dd, 2.0)
    whole = solved(law, motion, plant=plant)
    scale = np.abs(whole.x_r).max()
    assert (solved(law, mirrored(motion), plant=plant).x_r == -whole.x_r).all()
    assert (
        np.abs(solved(law, halved(motion), plant=plant).x_r[::2] - whole.x_r).max()
        < 1e-9 * scale
    )
    if (first, gap, second) == (-1.5, 32, 1.0):
        assert whole.x_r[-1] == pytest.approx(0.0359115498164, rel=1e-10)


OVERDAMPED = Plant(41.46, 4565.0, 17403.0)
STICKY = DynamicLaw(
    0.0018, 0.0072, LEUVEN, v_s=8.6e-6, sigma_0=3.2e7, sigma_1=500.0, sigma_2=48.75,
    F_h=0.0144, power=2.0,
)  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_mass_in_equilibrium_but_for_rounding_makes_no_storm_of_events(seed):
    random = np.random.default_rng(seed)
    force = STICKY.F_fk * random.uniform(0.3, 3.0)
    u_dd = np.where(random.random(40) < 0.1, random.choice([-1, 1], 40), 0) * force
    motion = Samples(u_dd / OVERDAMPED.m, 10 ** random.uniform(-1.0, 0.0))
    whole = solved(STICKY, motion, plant=OVERDAMPED)
    other = solved(STICKY, halved(motion), plant=OVERDAMPED)
    assert np.abs(other.x_r[::2] - whole.x_r).max() <= 1e-9 * np.abs(whole.x_r).max()


def test_steady_orbit_does_not_depend_on_where_t_0_lies():
    """At the end of a period the bristles sit on their limit to the last bit, or do not."""
    plant, f = Plant(250.0, 150e3, 990.0), 5.28
    law = DynamicLaw(
        23.0, 25.3, LEUVEN, v_s=2.4e-3, sigma_0=1.9e6, sigma_1=170.0, F_h=50.6
    )  # fmt: skip
    shares = []
    for phase in (0.0, 0.8, 3.2):
        motion = Sines((0.66,), (f,), (phase,))
        orbit = find_orbit(plant, law, motion, REST, 1.0 / f)
        for start, periods in ((orbit.state, 1), (REST, 61)):
            trajectory = compute_trajectory(plant, law, motion, start, periods / f)
            x_dd2 = trajectory.totals((periods - 1) / f, periods / f).x_dd2
            shares.append(math.sqrt(x_dd2 * f))
    assert shares == pytest.approx([0.5660245563] * 6, rel=1e-9)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 300, 301])
def test_state_handed_over_on_the_sliding_limit_keeps_its_branch(count, side):
    """Nor does a last turn at that very deflection, or more turns than there is room for."""
    law = DynamicLaw(32.0, 32.0, LEUVEN, sigma_0=1024.0, F_h=64.0)
    limit = 32.0 / 1024.0
    reversals = (
        side * limit * np.resize([-1.0, 1.0], count) * (1.0 - 1e-3 * np.arange(count) / count)
    )
    way = -side if count % 2 == 0 else side
    for z in (way * limit, reversals[-1]):
        start = ContactState(0.0, float(way), float(z), tuple(reversals.tolist()))
        scene = Scene(PAPER, law, make_waves(sine(1.0, 1.6)), np.zeros(2), 1.0)
        mark = initial_checkpoint(scene, start, 1.0)
        assert mark.branch[DIRECTION] == way
        assert mark.reversals[0] == reversals[0]
        assert mark.reversals[-1] == reversals[-1]
        assert len(mark.reversals) <= law.depth
