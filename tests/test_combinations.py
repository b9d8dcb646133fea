"""Every contact, normal force and end stop together: laws of physics, and a second solution."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from law_scenes import PAPER, REST, mirrored, noise

import drysim as package
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    CoulombLaw,
    EndStops,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
    acceleration_at,
)
from drysim.errors import ScenarioError, UsageError
from drysim.metrics.table import measure
from drysim.scenario.axes import iter_points
from drysim.scenario.text import describe_scene

LIMIT = 0.004
LIMITS = StrokeLimits(LIMIT, LIMIT)
RECORD = NormalForceRecord(1.0 + 1.1 * np.sin(np.arange(400) * 0.07), 0.01, 100.0)
CONTACTS = {"rigid": (45.0, 54.0, 0.0), "elastic": (45.0, 45.0, 1e5)}
LOADS = {
    "constant": {},
    "varying": {"variation": 0.6, "omega": 14.0, "phase": 0.3},
    "lifting": {"variation": 1.4, "omega": 9.0, "phase": 1.0},
    "recorded": {"force_record": RECORD},
}
STOPS = {
    "bumper": EndStops(LIMITS, ((0.0, 2e5),)),
    "damped bumper": EndStops(LIMITS, ((0.0, 2e5),), 300.0),
    "staged bumper": EndStops(LIMITS, ((0.0, 5e4), (2e-4, 1e5), (4e-4, 4e5)), 400.0),
    "rigid": EndStops(LIMITS, e=0.5),
    "dead": EndStops(LIMITS, e=0.0),
}
COMBINATIONS = [
    (contact, load, stops)
    for contact, load, stops in itertools.product(CONTACTS, LOADS, STOPS)
    if not (contact == "elastic" and load != "constant" and STOPS[stops].rigid)
]
MOTIONS = {"sines": Sines((3.0, 1.2), (1.6, 3.7), (0.0, 1.0)), "samples": noise(1200, 2.5, 3)}
SPAN = 2.5


def law_of(contact: str, load: str, stops: str) -> PiecewiseLaw:
    F_fk, F_fs, k_t = CONTACTS[contact]
    return PiecewiseLaw(F_fk, F_fs, k_t, stops=STOPS[stops], **LOADS[load])


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize(("contact", "load", "stops"), COMBINATIONS)
def test_forces_keep_their_limits_and_energy_is_conserved(contact, load, stops, motion):
    law = law_of(contact, load, stops)
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, SPAN)
    values = measure(trajectory, (0.0, SPAN), LIMITS)
    assert values["contacts"] > 3
    assert values["energy_residual"] < 1e-11
    t = np.linspace(0.0, SPAN, 20_001)
    found = trajectory.at(t)
    assert values["x_r_peak"] == pytest.approx(np.abs(found.x_r).max(), rel=1e-5)
    assert values["x_r_peak"] >= np.abs(found.x_r).max() * (1.0 - 1e-12)
    limit = law.load(t) * (law.F_fk if law.is_elastic else law.F_fs)
    x_r, F_f, F_stop = found.x_r, found.F_f, found.F_stop
    assert (np.abs(F_f) <= limit * (1.0 + 1e-9) + 1e-9).all()
    # A stop only pushes inwards, and only where the mass is.
    assert (F_stop * np.sign(x_r) >= -1e-9 * np.abs(F_stop).max()).all()
    assert (np.abs(x_r[F_stop != 0.0]) >= LIMIT * (1.0 - 1e-12)).all()
    if law.stops.rigid:
        assert (np.abs(x_r) <= LIMIT * (1.0 + 1e-12)).all()
    moving = np.abs(found.v_r) > 1e-9
    if not law.is_elastic:
        kinetic = law.F_fk * law.load(t) * np.sign(found.v_r)
        assert F_f[moving] == pytest.approx(kinetic[moving], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("contact", "load", "stops"), COMBINATIONS)
def test_mirrored_scene_gives_the_mirrored_motion(contact, load, stops):
    law, motion, t = law_of(contact, load, stops), MOTIONS["sines"], np.linspace(0, SPAN, 999)
    one = StickSlip().trajectory(PAPER, law, motion, State(1e-3, 0.02), SPAN).at(t)
    other = StickSlip().trajectory(PAPER, law, mirrored(motion), State(-1e-3, -0.02), SPAN)
    assert (other.at(t).x_r == -one.x_r).all()


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("k_t", [1e4, 1e5, 1e7])
@pytest.mark.parametrize("load", LOADS)
def test_elastic_contact_under_a_directed_damper_closes_its_energy(load, k_t, motion):
    law = PiecewiseLaw(45.0, 45.0, k_t, damping=(900.0, 300.0), **LOADS[load])
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, SPAN)
    values = measure(trajectory, (0.0, SPAN), LIMITS)
    x_r = trajectory.at(np.linspace(0.0, SPAN, 20_001)).x_r
    assert values["energy_residual"] < 1e-11
    assert values["x_r_peak"] == pytest.approx(np.abs(x_r).max(), rel=1e-5)
    response = StickSlip().solve(PAPER, law, motion, REST, 1e-3, SPAN)
    exact = trajectory.at(np.arange(len(response)) * response.dt).x_r
    assert np.abs(response.x_r - exact).max() <= 1e-9 * np.abs(exact).max()


def test_long_hold_under_a_directed_damper_loses_what_its_direction_takes():
    law = PiecewiseLaw(4500.0, 4500.0, 1e8, damping=(900.0, 100.0))
    trajectory = StickSlip().trajectory(PAPER, law, Sines((3.0,), (0.1,), (0.0,)), REST, 40.0)
    assert measure(trajectory, (0.0, 40.0), None)["energy_residual"] < 1e-11


@pytest.mark.parametrize("e", [0.0, 0.3])
@pytest.mark.parametrize("f", np.arange(1.1, 2.75, 0.15).tolist())
def test_contact_at_its_limit_leaves_a_rigid_stop_on_which_the_mass_rests(f, e):
    """It arrived yielding: as it leaves, the contact holds from its very limit."""
    law = PiecewiseLaw(1.0, 1.0, 4e3, stops=EndStops(StrokeLimits(0.005, 0.005), e=e))
    base, plant = Sines((8.0**0.5,), (f,), (0.0,)), Plant(2.0, 200.0, 10.0)
    trajectory = StickSlip().trajectory(plant, law, base, REST, 6.0)
    assert measure(trajectory, (0.0, 6.0), None)["energy_residual"] < 1e-11
    found = trajectory.at(np.linspace(0.0, 6.0, 20_001))
    assert (np.abs(found.F_f) <= 1.0 + 1e-9).all()
    assert (found.F_stop * np.sign(found.x_r) >= -1e-9).all()


def test_rigid_stops_refuse_an_elastic_contact_under_a_varying_force():
    law, base = law_of("elastic", "varying", "rigid"), MOTIONS["sines"]
    with pytest.raises(UsageError, match="does not go with rigid stops"):
        StickSlip().trajectory(PAPER, law, base, State(2 * LIMIT, 0.0), SPAN)


def directed(F_up, F_down, ratio=1.2, **further) -> PiecewiseLaw:
    """Return Coulomb friction by direction."""
    return PiecewiseLaw(F_up, ratio * F_up, compression=(F_down, ratio * F_down), **further)


def test_free_decay_under_unequal_friction_turns_where_the_energy_says():
    """Half a swing in direction d turns about -d F_d/k: the closed form of every reversal."""
    plant, law = Plant(2.0, 800.0, 0.0), directed(3.0, 7.0, 1.0)
    still = Samples(np.zeros(401), 0.01)
    trajectory = StickSlip().trajectory(plant, law, still, State(0.1, 0.0), 4.0)
    turns, x, d = [0.1], 0.1, -1
    while abs(plant.k_x * x) > (7.0 if x > 0.0 else 3.0):
        x = 2.0 * (-d * (3.0 if d > 0 else 7.0) / plant.k_x) - x
        turns.append(x)
        d = -d
    assert trajectory.events.x_r == pytest.approx(turns, rel=1e-12)
    half = math.pi / math.sqrt(plant.k_x / plant.m)
    assert trajectory.events.t == pytest.approx(
        [half * n for n in range(len(turns))], rel=1e-12
    )
    work = trajectory.totals(0.0, 4.0).friction_loss
    lost = 0.5 * plant.k_x * (turns[0] ** 2 - turns[-1] ** 2)
    assert work == pytest.approx(lost, rel=1e-12)


def test_free_decay_of_a_directed_damper_loses_each_half_swing_its_own_share():
    plant, still = Plant(1.0, 100.0, 1.2), Samples(np.zeros(801), 0.005)
    law = PiecewiseLaw(0.0, 0.0, damping=(2.0, 0.4))
    trajectory = StickSlip().trajectory(plant, law, still, State(0.1, 0.0), 3.0)
    turns = [0.1]
    for n in range(len(trajectory.events.x_r) - 1):
        c = (0.4, 2.0)[n % 2]
        omega = math.sqrt(100.0 - 0.25 * c * c)
        turns.append(-turns[-1] * math.exp(-0.5 * c * math.pi / omega))
    assert trajectory.events.x_r == pytest.approx(turns, rel=1e-12)
    assert measure(trajectory, (0.0, 3.0), None)["energy_residual"] < 1e-13


@pytest.mark.parametrize("stops", [None, *STOPS])
@pytest.mark.parametrize("load", LOADS)
def test_exchanged_directions_in_the_mirrored_scene_give_the_mirrored_motion(load, stops):
    further = LOADS[load] | {"stops": None if stops is None else STOPS[stops]}
    motion, t = MOTIONS["sines"], np.linspace(0.0, SPAN, 999)
    one = directed(30.0, 55.0, damping=(200.0, 700.0), **further)
    other = directed(55.0, 30.0, damping=(700.0, 200.0), **further)
    seen, mirror = (
        StickSlip().trajectory(PAPER, law, base, State(side * 1e-3, 0.0), SPAN)
        for law, base, side in ((one, motion, 1), (other, mirrored(motion), -1))
    )
    assert (mirror.at(t).x_r == -seen.at(t).x_r).all()
    assert measure(seen, (0.0, SPAN), None)["energy_residual"] < 1e-11


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("stops", ["damped bumper", "rigid"])
def test_equal_directions_solve_as_one_value_does(stops, motion):
    single = PiecewiseLaw(45.0, 54.0, stops=STOPS[stops])
    pair = single._replace(compression=(45.0, 54.0), damping=(PAPER.b, PAPER.b))
    t = np.linspace(0.0, SPAN, 999)
    one, other = (
        StickSlip().trajectory(PAPER, law, motion, REST, SPAN).at(t) for law in (single, pair)
    )
    assert (one.x_r == other.x_r).all()


def test_mean_displacement_under_directed_damping_is_that_of_small_steps():
    """A damper that resists extension more draws the mass below its rest (jacking down)."""
    law, motion = PiecewiseLaw(0.0, 0.0, damping=(900.0, 300.0)), Sines((3.0,), (2.0,), (0.0,))
    h, span = 2e-5, 12.0
    x, v, total, n = 0.0, 0.0, 0.0, round(span / h)
    u_dd = acceleration_at(motion, np.arange(2 * n + 1) * (h / 2)).tolist()
    m, k_x, _ = PAPER

    def rate(x, v, u):
        return -u - (k_x * x + (900.0 if v > 0.0 else 300.0) * v) / m

    for i in range(n):
        a = rate(x, v, u_dd[2 * i])
        v_mid = v + 0.5 * h * a
        a_mid = rate(x + 0.5 * h * v, v_mid, u_dd[2 * i + 1])
        total += x * h if i * h >= 11.0 else 0.0
        x, v = x + h * v_mid, v + h * a_mid
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, span)
    mean = float(trajectory.at(11.0 + np.arange(10_000) * 1e-4).x_r.mean())
    assert mean == pytest.approx(total, rel=1e-4)
    assert abs(mean) > 1e-3


def stepped(law: PiecewiseLaw, motion: Sines | Samples, span: float, h: float) -> np.ndarray:
    """Return x_r every 1000 steps by a return mapping with small steps: no events, no modes.

    The elastic contact is a spring whose force is cut at its limit in every step; the rest is
    the explicit midpoint rule.
    """
    m, k_x, b = PAPER
    n = round(span / h)
    t = np.arange(n + 1) * h
    u_dd = acceleration_at(motion, t).tolist()
    limits = (law.F_fk * law.load(t)).tolist()
    stages, b_s, limit = law.stops.stages, law.stops.b_s, law.stops.limits.up
    x, v, F, kept = 0.0, 0.0, 0.0, [0.0]

    def stop_force(x, v):
        depth, side = abs(x) - limit, math.copysign(1.0, x)
        if depth <= 0.0:
            return 0.0
        force = sum(k * max(depth - begin, 0.0) for begin, k in stages) + b_s * side * v
        return side * max(force, 0.0)

    for i in range(n):
        a = -u_dd[i] - (k_x * x + b * v + F + stop_force(x, v)) / m
        x_mid, v_mid = x + 0.5 * h * v, v + 0.5 * h * a
        F_mid = F + law.k_t * 0.5 * h * v
        bound = 0.5 * (limits[i] + limits[i + 1])
        F_mid = min(max(F_mid, -bound), bound)
        u_mid = 0.5 * (u_dd[i] + u_dd[i + 1])
        pull = k_x * x_mid + b * v_mid + F_mid + stop_force(x_mid, v_mid)
        x, v = x + h * v_mid, v - h * (u_mid + pull / m)
        F = min(max(F + law.k_t * h * v_mid, -limits[i + 1]), limits[i + 1])
        if (i + 1) % 1000 == 0:
            kept.append(x)
    return np.array(kept)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("stops", ["bumper", "damped bumper", "staged bumper"])
@pytest.mark.parametrize("load", LOADS)
def test_elastic_contact_between_bumpers_follows_small_steps(load, stops, motion):
    law, span, h = law_of("elastic", load, stops), 0.6, 4e-6
    coarse, fine = stepped(law, motion, span, 2 * h), stepped(law, motion, span, h)
    trajectory = StickSlip().trajectory(PAPER, law, motion, REST, span)
    exact = trajectory.at(np.arange(len(fine)) * 1000 * h).x_r
    assert np.abs(exact).max() > LIMIT
    # Halving the steps shows their error, but for that of a step in which the mode changes.
    error = np.abs(fine[::2] - coarse[: len(fine[::2])]).max()
    assert error < 1e-6
    assert np.abs(exact - fine).max() < 3.0 * error + 2e-7


def test_stages_that_continue_the_line_are_a_single_bumper():
    motion, start, t = MOTIONS["sines"], REST, np.linspace(0.0, SPAN, 999)
    single = PiecewiseLaw(45.0, 54.0, stops=EndStops(LIMITS, ((0.0, 2e5),), 300.0))
    stages = ((0.0, 2e5), (1e-4, 0.0), (3e-4, 0.0))
    staged = PiecewiseLaw(45.0, 54.0, stops=EndStops(LIMITS, stages, 300.0))
    one, other = (
        StickSlip().trajectory(PAPER, law, motion, start, SPAN) for law in (single, staged)
    )
    assert np.abs(one.at(t).x_r - other.at(t).x_r).max() < 1e-13
    assert len(one.events) == len(other.events)


# The same in scenario files.

SCENE = """\
oscillator: {mass: 75, stiffness: 7500, damping: DAMPING}
friction: {kinetic: KINETIC, static_ratio: 1.2}
excitation: {kind: harmonic, frequency: 1.6, rms: 1.0}
solver: {step: 2.5e-3}
"""


def scene(kinetic="30 N", damping="500", overrides=()):
    text = SCENE.replace("KINETIC", kinetic).replace("DAMPING", damping)
    return package.scenario(text, overrides)


def test_values_by_direction_are_read_described_written_and_swept():
    made = scene(
        "{extension: 30 N, compression: 0.06 kN}", "{extension: 900, compression: 300}"
    )
    assert made.law() == directed(30.0, 60.0, damping=(900.0, 300.0))
    assert made.oscillator.plant().b == 600.0
    words = dict(describe_scene(made, made.oscillator.plant(), made.law()))
    assert "b 900 in extension, 300 N·s/m in compression" in words["oscillator"]
    assert words["friction"].startswith("F_fk 30 in extension, 60 N in compression")
    assert made.resolved()["friction"]["kinetic"] == {"extension": 30.0, "compression": 60.0}
    axis = {"sweep": {"friction.kinetic.compression": [40, "50 N"]}}
    swept = scene("{extension: 30 N, compression: 60 N}", overrides=axis)
    laws = [swept.at(point).law() for point in iter_points(swept.sweep)]
    assert [law.compression[0] for law in laws] == [40.0, 50.0]


def test_equal_values_by_direction_are_one_value():
    pair = scene("{extension: 30 N, compression: 30 N}", "{extension: 500, compression: 500}")
    single = scene()
    assert pair.law() == single.law()
    assert package.run(pair).metrics == package.run(single).metrics


@pytest.mark.parametrize(
    ("kinetic", "damping", "words"),
    [
        ("{extension: 30 N}", "500", "friction.kinetic.compression is required"),
        ("{extension: 30, compression: -1}", "500", "must be at least 0 N, not -1"),
        ("{extension: 30, compression: 0}", "500", "above 0 in both directions, or 0 in both"),
        ("{up: 30, compression: 5}", "500", "unknown key `up` in friction.kinetic"),
        ("30 N", "{extension: a, compression: 1}", "oscillator.damping.extension"),
        ("[30, 40]", "500", "must be a number [N], not a list"),
    ],
)
def test_faulty_values_by_direction_are_located(kinetic, damping, words):
    with pytest.raises(ScenarioError) as found:
        scene(kinetic, damping)
    assert any(words in problem.sentence for problem in found.value.problems)


def test_what_cannot_use_directions_refuses_them_or_says_what_it_leaves_out():
    pairs = "{extension: 30, compression: 60}", "{extension: 900, compression: 300}"
    with pytest.raises(ScenarioError) as found:
        scene(*pairs, {"solver.approach": "signum", "friction.static_ratio": 1})
    assert [problem.sentence for problem in found.value.problems] == [
        "approach signum does not support damping that depends on direction; give one value "
        "or choose stick-slip",
        "approach signum does not support friction that depends on direction; give one value "
        "or choose stick-slip",
    ]
    made = scene(*pairs)
    assert made.omissions("signum")[:2] == (
        "signum uses the mean of oscillator.damping in both directions",
        "signum uses the mean of the friction forces in both directions",
    )
    assert made.with_approach("signum").law() == CoulombLaw(45.0, 45.0)
    assert made.with_approach("viscous").law().damping == (900.0, 300.0)
    law = made.copy_with({}).with_law("coulomb").law()
    assert law == made.law()


@pytest.mark.parametrize("stops", [None, *STOPS])
@pytest.mark.parametrize("k_t", [0.0, 1e5])
def test_integrals_of_whole_steps_are_those_of_their_parts(k_t, stops):
    """A window that cuts every step in two leaves no step whole."""
    law = PiecewiseLaw(45.0, 45.0, k_t, stops=None if stops is None else STOPS[stops])
    if not law.is_elastic:
        law = law._replace(compression=(30.0, 30.0), damping=(300.0, 700.0))
    motion = MOTIONS["samples"]
    trajectory = StickSlip().trajectory(PAPER, law, motion, State(1e-3, 0.0))
    whole, parts = trajectory.totals(0.0, trajectory.end), np.zeros(8)
    for n in range(len(motion.u_dd) - 1):
        t = n * motion.dt, (n + 0.4) * motion.dt, (n + 1) * motion.dt
        for begin, end in itertools.pairwise(t):
            one = trajectory.totals(begin, end)
            parts += (*one[:6], one.stop_work, one.damper_work or 0.0)
    known = (*whole[:6], whole.stop_work, whole.damper_work or 0.0)
    scale = 1e-12 * np.abs(parts).max()
    assert np.array(known) == pytest.approx(parts, rel=1e-9, abs=scale)


def test_ratio_that_would_hold_the_mass_is_that_of_the_weaker_direction():
    changes = {"friction.static_ratio": None, "excitation.rms": 0.33}
    made = scene("{extension: 60, compression: 30}", overrides=changes)
    (found,) = (one for one in package.run(made).warnings if one.slug == "static-not-given")
    assert found.numbers["F_fk"] == 30.0
    assert found.numbers["ratio"] == pytest.approx(75.0 * 0.33 * math.sqrt(2.0) / 30.0)


@pytest.mark.parametrize("approach", ["stick-slip", "viscous"])
def test_damping_by_direction_is_refused_beside_a_law_that_would_ignore_it(approach):
    dahl = {"law": "dahl", "kinetic": 30.0, "bristle_stiffness": 1e5}
    with pytest.raises(ScenarioError) as found:
        scene(
            damping="{extension: 900, compression: 300}",
            overrides={"friction": dahl, "solver.approach": approach},
        )
    assert "coulomb, jenkins, petrov-ewins" in found.value.problems[0].sentence


def test_equal_dampers_by_direction_are_one_damper():
    plant, start = Plant(1.0, 1.0, 0.4), REST
    motion = Sines((1.0,), (0.2,), (0.0,))
    one = PiecewiseLaw(100.0, 100.0, k_t=20.0)  # it never yields
    both = one._replace(damping=(0.4, 0.4))
    paths = [
        StickSlip().trajectory(plant, law, motion, start, 30.0).path for law in (one, both)
    ]
    assert paths[0].x_r.tolist() == paths[1].x_r.tolist()
    assert len(paths[0].x_r) > 5


FIRST_AT_REST = Sines((1.0, -0.5), (1.0, 2.0), (0.0, 0.0))
"""The first three derivatives of the base acceleration that follow vanish with it at t = 0."""

BUMPERS = EndStops(StrokeLimits(2e-3, 2e-3), ((0.0, 1e5),), 10.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    "law",
    [
        PiecewiseLaw(0.05, 0.05, 1000.0),
        PiecewiseLaw(0.05, 0.05, 1000.0, stops=BUMPERS),
        PiecewiseLaw(0.0, 0.0, stops=BUMPERS),
        PiecewiseLaw(0.0, 0.0, stops=BUMPERS._replace(stages=(), b_s=0.0, e=0.3)),
        PiecewiseLaw(0.05, 0.05, 0.0, 3.0, 0.1, -1.5),
    ],
    ids=["elastic", "elastic with bumpers", "bumpers", "rigid stops", "separated"],
)
def test_mass_that_the_base_moves_slowly_at_first_goes_where_it_is_pushed(law, side):
    plant, t = Plant(1.0, 100.0, 0.5), np.linspace(0.0, 2.0, 2001)
    A, f, _ = FIRST_AT_REST
    found, near = (
        StickSlip().trajectory(
            plant, law, Sines(tuple(side * a for a in A), f, (0.0, shift)), REST, 2.0
        )
        for shift in (0.0, 1e-9)
    )
    assert np.abs(found.at(t).x_r - near.at(t).x_r).max() < 1e-7
    assert np.abs(found.path.x_r).max() == pytest.approx(np.abs(near.path.x_r).max(), rel=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_friction_in_one_direction_only_is_friction(side):
    one_way = (0.0, 0.0), (40.0, 48.0)
    up, down = one_way[::-1] if side > 0.0 else one_way
    law, motion = PiecewiseLaw(*up, compression=down), Sines((side * 1.5,), (1.6,), (0.0,))
    response = StickSlip().solve(PAPER, law, motion, REST, 2.5e-3, 5.0)
    assert len(response.events) > 10
    assert response.numerics.approach == "stick-slip"
    assert response.trajectory.closest_decision < 1.0
    assert (response.d == 0).any() == (response.trajectory.totals(0.0, 5.0).stuck > 0.0)


@pytest.mark.parametrize("start", [State(0.0054, 0.0), State(0.0054, 0.1), REST])
def test_closest_decision_counts_the_start_under_every_rigid_law(start):
    motion = Sines((0.5, 0.3), (1.6, 2.3), (0.3, 0.0))
    laws = CoulombLaw(40.0, 48.0), PiecewiseLaw(40.0, 48.0, compression=(40.0, 48.0))
    one, other = (
        StickSlip().solve(PAPER, law, motion, start, 2.5e-3, 5.0).trajectory for law in laws
    )
    assert one.closest_decision == pytest.approx(other.closest_decision, rel=1e-9)
