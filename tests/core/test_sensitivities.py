"""Sensitivities: against differences of marches, closed forms, and without their jumps."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from drysim.approach import exact, sensitivity
from drysim.approach.solution import Response
from drysim.core import variational
from drysim.core.model import (
    CoulombLaw,
    EndStops,
    Floats,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
    base_acceleration,
)
from drysim.core.variational import Sensitivities

PLANT = Plant(75.0, 7500.0, 150.0)
WAVE, LIFTS = (0.5, 2.0 * math.pi * 4.0, 0.3), (1.5, 2.0 * math.pi * 4.0, 0.3)
LIMITS = StrokeLimits(0.006, 0.005)
THREE = ((0.0, 40e3), (0.001, 80e3), (0.002, 100e3))
BUMPER = EndStops(LIMITS, THREE[:1], 400.0)
BY_DIRECTION = PiecewiseLaw(20.0, 24.0, compression=(35.0, 40.0), damping=(100.0, 400.0))
EVERY = "plant.m", "plant.k_x", "plant.b", "start.x_r", "start.v_r"
"""Numbers of every scene."""

PLAIN = "law.F_fk", "law.F_fs"
ELASTIC = "law.both", "law.k_t"
LOAD = "law.variation", "law.omega", "law.phase"
STOPS = "stops.up", "stops.down"
BUMPERS = (*STOPS, "stages.0.1", "stops.b_s")
STAGES = (*STOPS, "stages.0.1", "stages.1.0", "stages.1.1", "stages.2.0")
RIGID = (*STOPS, "stops.e")
SIDES = (*PLAIN, "compression.0", "compression.1", "damping.0", "damping.1")

LAWS = {
    "coulomb": (CoulombLaw(45.0, 54.0), PLAIN),
    "coulomb, equal limits": (CoulombLaw(45.0, 45.0), ("law.both",)),
    "no friction": (CoulombLaw(0.0, 0.0), ()),
    "varying load": (CoulombLaw(45.0, 54.0, *WAVE), (*PLAIN, *LOAD)),
    "lift-off": (PiecewiseLaw(45.0, 54.0, 0.0, *LIFTS), (*PLAIN, *LOAD)),
    "by direction": (BY_DIRECTION, SIDES),
    "jenkins": (PiecewiseLaw(45.0, 45.0, 30e3), ELASTIC),
    "petrov-ewins": (PiecewiseLaw(45.0, 45.0, 30e3, *WAVE), (*ELASTIC, *LOAD)),
    "petrov-ewins, lift-off": (PiecewiseLaw(45.0, 45.0, 30e3, *LIFTS), (*ELASTIC, *LOAD)),
    "damped bumpers": (PiecewiseLaw(20.0, 24.0, stops=BUMPER), (*PLAIN, *BUMPERS)),
    "staged bumpers": (
        PiecewiseLaw(20.0, 24.0, stops=EndStops(LIMITS, THREE)),
        (*PLAIN, *STAGES),
    ),
    "damped staged bumpers": (
        PiecewiseLaw(20.0, 24.0, stops=EndStops(LIMITS, THREE, 400.0)),
        (*PLAIN, *STAGES, "stops.b_s"),
    ),
    "bumpers by direction": (BY_DIRECTION._replace(stops=BUMPER), (*SIDES, *BUMPERS)),
    "jenkins, bumpers": (PiecewiseLaw(20.0, 20.0, 30e3, stops=BUMPER), (*ELASTIC, *BUMPERS)),
    "petrov-ewins, bumpers": (
        PiecewiseLaw(45.0, 45.0, 30e3, *WAVE, stops=BUMPER),
        (*ELASTIC, *LOAD, *BUMPERS),
    ),
    "rigid stops": (PiecewiseLaw(20.0, 24.0, stops=EndStops(LIMITS, e=0.6)), (*PLAIN, *RIGID)),
    "rigid stops, no rebound": (
        PiecewiseLaw(20.0, 24.0, stops=EndStops(LIMITS)),
        (*PLAIN, *STOPS),
    ),
    "rigid stops, no friction": (PiecewiseLaw(0.0, 0.0, stops=EndStops(LIMITS, e=0.6)), RIGID),
    "rigid stops, varying load": (
        PiecewiseLaw(20.0, 24.0, 0.0, *WAVE, stops=EndStops(LIMITS, e=0.6)),
        (*PLAIN, *LOAD, *RIGID),
    ),
    "jenkins, rigid stops": (
        PiecewiseLaw(20.0, 20.0, 30e3, stops=EndStops(LIMITS, e=0.6)),
        (*ELASTIC, *RIGID),
    ),
}
"""Laws, and the paths of their numbers besides those of all scenes."""


class Scene(NamedTuple):
    """A scene over `TIME`."""

    plant: Plant
    law: CoulombLaw | PiecewiseLaw
    motion: Sines | Samples
    start: State


TIME, STEP = 0.6, 0.01


def scaled(scene: Scene, path: str, factor: float) -> Scene:
    """Return the scene with one number times a factor."""
    plant, law, _, start = scene
    block, _, field = path.partition(".")
    if block == "plant":
        plant = plant._replace(**{field: factor * getattr(plant, field)})
        if field == "b" and law.damping is not None:
            law = law._replace(damping=tuple(factor * b for b in law.damping))
    elif block == "start":
        start = start._replace(**{field: factor * getattr(start, field)})
    elif field == "both":
        law = law._replace(F_fk=factor * law.F_fk, F_fs=factor * law.F_fs)
    elif block == "law":
        law = law._replace(**{field: factor * getattr(law, field)})
    elif block in ("compression", "damping"):
        values = list(getattr(law, block))
        values[int(field)] *= factor
        law = law._replace(**{block: tuple(values)})
    elif block == "stages":
        i, j = map(int, field.split("."))
        stages = [list(stage) for stage in law.stops.stages]
        stages[i][j] *= factor
        law = law._replace(stops=law.stops._replace(stages=tuple(map(tuple, stages))))
    elif field in ("up", "down"):
        limits = law.stops.limits
        limits = limits._replace(**{field: factor * getattr(limits, field)})
        law = law._replace(stops=law.stops._replace(limits=limits))
    else:
        stops = law.stops._replace(**{field: factor * getattr(law.stops, field)})
        law = law._replace(stops=stops)
    return scene._replace(plant=plant, law=law, start=start)


def solved(scene: Scene) -> Response:
    """Return the response of a scene."""
    return exact.solve(*scene, STEP, TIME, True)


def direction(scene: Scene, path: str) -> Floats:
    """Return the derivatives of all numbers by the logarithm of one, by differences."""
    h, found = 1e-3, []
    for factor in (1.0 + h, 1.0 - h):
        plant, law, _, start = scaled(scene, path, factor)
        found.append(sensitivity.numbers_of(plant, law, start, 1)[:, 0])
    with np.errstate(invalid="ignore"):
        slope = (found[0] - found[1]) / (2.0 * h)
    return np.where(np.isfinite(slope), slope, 0.0)


def drawn_scene(law: CoulombLaw | PiecewiseLaw, seed: int, sampled: bool) -> Scene:
    """Return a scene with a law, under sines or their samples."""
    rng = np.random.default_rng(seed)
    # Without stops less, so that the mass sticks at times.
    size = 0.4 if law.stops is None else 1.0
    A = size * float(rng.uniform(1.0, 4.0)), size * float(rng.uniform(0.0, 2.0))
    phase = float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.0, 6.0))
    start = State(float(rng.uniform(-0.004, 0.004)), float(rng.uniform(0.02, 0.1)))
    motion: Sines | Samples = Sines(A, (2.0, 6.0), phase)
    if sampled:
        t = np.arange(round(TIME / STEP) + 1) * STEP
        motion = Samples(base_acceleration(motion, t), STEP)
    return Scene(PLANT, law, motion, start)


CHANNELS = "x_r", "v_r", "x_dd", "F_f"

STEPS = 4e-5, 2e-5, 1e-5
"""Relative changes of a number."""

ROUNDING = 3e-13
"""Relative rounding error of a channel."""


def values(response: Response) -> Floats:
    """Return the channels at all points, shape (channels, points)."""
    return np.array([getattr(response, name) for name in CHANNELS])


def alike(one: Response, other: Response) -> NDArray[np.bool_]:
    """Return the points with the same mode, after the same events."""
    first, second = (getattr(r.trajectory, "events", r.events) for r in (one, other))
    n = min(len(first), len(second))
    differ = np.flatnonzero(first.kind[:n] != second.kind[:n])
    at = differ[0] if len(differ) else n
    until = min((e.t[at] for e in (first, second) if at < len(e)), default=math.inf)
    same: NDArray[np.bool_] = (one.d == other.d) & (one.t < until - STEP)
    return same


def differences(scene: Scene, path: str) -> tuple[Floats, Floats]:
    """Return extrapolated central differences by the logarithm of a number, and their errors.

    The error is infinite where a mode changes within the largest change of the number.
    """
    here, found = solved(scene), []
    same = np.ones(len(here), dtype=bool)
    for h in STEPS:
        above, below = (solved(scaled(scene, path, 1.0 + sign * h)) for sign in (1, -1))
        same &= alike(here, above) & alike(here, below)
        found.append((values(above) - values(below)) / (2.0 * h))
    first, second = ((4.0 * found[i + 1] - found[i]) / 3.0 for i in (0, 1))
    rounding = ROUNDING / STEPS[-1] * np.abs(values(here)).max(axis=1, keepdims=True)
    error = 3.0 * (np.abs(first - second) + rounding)
    error[:, ~same] = math.inf
    return second, error


def assert_slopes_are_those_of_differences(name: str, seed: int, sampled: bool) -> float:
    """Return the share of points at which they could be compared."""
    law, own = LAWS[name]
    paths, scene = (*EVERY, *own), drawn_scene(law, seed, sampled)
    here = solved(scene)
    rates = np.stack([direction(scene, path) for path in paths], axis=1)
    found = sensitivity.linearise(here, rates)
    compared = []
    for k, path in enumerate(paths):
        slope, error = differences(scene, path)
        if law.stops is not None:
            error[3, here.d == 0] = math.inf  # friction alone is not determined at a stop
        off = np.abs(np.array([channel[k] for channel in found]) - slope)
        compared.append(float(np.mean(np.isfinite(error[0]))))
        assert (off <= error).all(), (name, seed, sampled, path, float((off / error).max()))
    return float(np.mean(compared))


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seeds", [(1,), pytest.param(range(2, 12), marks=pytest.mark.slow)])
def test_slopes_by_every_number_are_those_of_differences(name, sampled, seeds):
    # Where a mode changes early within the change of a number, the rest is left out.
    shares = [assert_slopes_are_those_of_differences(name, seed, sampled) for seed in seeds]
    assert np.mean(shares) > 0.5, shares


# What guards and resets contribute: without it the same comparison fails.


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("coulomb", "excess_deviation"),
        ("varying load", "load_deviation"),
        ("damped bumpers", "limit_deviation"),
        ("rigid stops", "limit_deviation"),
        ("jenkins", "slip_force_deviation"),
    ],
)
def test_without_what_moves_a_guard_the_slopes_are_refuted(plain, monkeypatch, name, part):
    kernel = plain.variational
    monkeypatch.setattr(sensitivity, "propagate_sensitivities", kernel.propagate_sensitivities)
    assert_slopes_are_those_of_differences(name, 1, True)
    right, events = getattr(kernel, part), kernel.pass_event_of_scene

    def pass_without(*arguments):
        setattr(kernel, part, lambda *_: 0.0)
        events(*arguments)
        setattr(kernel, part, right)

    monkeypatch.setattr(kernel, "pass_event_of_scene", pass_without)
    with pytest.raises(AssertionError):
        assert_slopes_are_those_of_differences(name, 1, True)


@pytest.mark.parametrize("name", LAWS)
def test_both_engines_have_the_same_slopes(plain, monkeypatch, name):
    law, own = LAWS[name]
    scene = drawn_scene(law, 1, sampled=False)
    rates = np.stack([direction(scene, path) for path in (*EVERY, *own)], axis=1)
    one = np.array(sensitivity.linearise(solved(scene), rates))
    kernel = plain.variational.propagate_sensitivities
    monkeypatch.setattr(sensitivity, "propagate_sensitivities", kernel)
    other = np.array(sensitivity.linearise(solved(scene), rates))
    assert np.abs(one - other).max() <= 1e-12 * np.abs(one).max()


# Closed forms.


def slopes_by(scene: Scene, rates: dict[int, float], step: float, time: float):
    """Return response and its derivatives by one number, or by several that change together."""
    response = exact.solve(*scene, step, time, True)
    columns = np.zeros((variational.NUMBERS, 1))
    for row, rate in rates.items():
        columns[row] = rate
    found = sensitivity.linearise(response, columns)
    return response, Sensitivities(*(channel[0] for channel in found))


REST = Sines((), (), ())
UP, DOWN = variational.UP, variational.DOWN
DAMPER = {UP + variational.DAMPER: 1.0, DOWN + variational.DAMPER: 1.0}
KINETIC = {UP + variational.KINETIC: 1.0, DOWN + variational.KINETIC: 1.0}
STATIC = {UP + variational.STATIC: 1.0, DOWN + variational.STATIC: 1.0}


@pytest.mark.parametrize("b", [0.0, 30.0, 150.0, 1500.0, 3000.0])
@pytest.mark.parametrize("part", ["k_x", "b"])
def test_slopes_of_a_linear_decay_are_those_of_its_formula(b, part):
    def x_r(k_x: complex, b: complex, t: Floats):
        c, w = b / PLANT.m, k_x / PLANT.m
        omega = np.sqrt(w - c * c / 4.0 + 0j)
        free = np.cos(omega * t) + c / 2.0 * np.sin(omega * t) / omega
        return np.exp(-c * t / 2.0) * (0.01 * free + 0.2 * np.sin(omega * t) / omega)

    plant, state = PLANT._replace(b=b), State(0.01, 0.2)
    rates = {variational.SPRING: 1.0} if part == "k_x" else DAMPER
    scene = Scene(plant, CoulombLaw(0.0, 0.0), REST, state)
    response, found = slopes_by(scene, rates, 0.01, 1.0)
    h = 1e-3 * getattr(PLANT, part)
    near = [plant._replace(**{part: getattr(plant, part) + s * h}) for s in (2, 1, -1, -2)]
    up, half_up, half_down, down = (x_r(p.k_x, p.b, response.t).real for p in near)
    expected = (8.0 * (half_up - half_down) - (up - down)) / (12.0 * h)
    assert found.x_r == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("b", [0.0, 40.0])
def test_slope_of_the_amplitude_after_n_half_cycles_is_that_of_the_free_decay(b):
    # x_(n+1) = -sgn(x_n) (|x_n| d - x_f (1 + d)), x_f = F/k, d = exp(-pi zeta/q), a half cycle
    # after another.
    plant, F = PLANT._replace(b=b), 20.0
    omega = math.sqrt(plant.k_x / plant.m - (b / plant.m / 2.0) ** 2)
    half, d = math.pi / omega, math.exp(-math.pi / omega * b / plant.m / 2.0)
    scene = Scene(plant, CoulombLaw(F, F), REST, State(0.05, 0.0))
    response, found = slopes_by(scene, KINETIC | STATIC, half / 8.0, 6.0 * half)
    slope, amplitude = 0.0, 0.05
    for n in range(1, 6):
        amplitude = amplitude * d - F / plant.k_x * (1.0 + d)
        slope = slope * d - (1.0 + d) / plant.k_x
        assert response.x_r[8 * n] == pytest.approx((-1) ** n * amplitude)
        assert found.x_r[8 * n] == pytest.approx((-1) ** n * slope, rel=1e-9)


def test_slope_by_the_static_limit_is_the_delay_of_the_break_away():
    # At rest until m r t = F_fs; then v' = -r t + F_fk/m.
    m, r, F_fk, F_fs = 2.0, 3.0, 1.0, 1.53
    t = np.arange(101) * 0.01
    scene = Scene(
        Plant(m, 0.0, 0.0), CoulombLaw(F_fk, F_fs), Samples(r * t, 0.01), State(0.0, 0.0)
    )
    _, found = slopes_by(scene, STATIC, 0.01, 1.0)
    slides = t > F_fs / (m * r)
    expected = np.where(slides, (F_fs - F_fk) / (m * m * r), 0.0)
    assert found.v_r == pytest.approx(expected, abs=1e-14)
    assert found.x_r == pytest.approx(expected * (t - F_fs / (m * r)), abs=1e-14)


def test_slopes_by_a_rigid_stop_are_those_of_a_mass_that_flies():
    L, e, v = 0.3, 0.6, 1.0
    law = PiecewiseLaw(0.0, 0.0, stops=EndStops(StrokeLimits(L, 10.0), e=e))
    scene = Scene(Plant(1.0, 0.0, 0.0), law, REST, State(0.0, v))
    response, by_limit = slopes_by(scene, {UP + variational.LIMIT: 1.0}, 0.01, 1.0)
    _, by_restitution = slopes_by(scene, {variational.RESTITUTION: 1.0}, 0.01, 1.0)
    after = response.t > L / v
    assert by_limit.x_r == pytest.approx(np.where(after, 1.0 + e, 0.0), abs=1e-12)
    assert by_limit.v_r == pytest.approx(0.0, abs=1e-12)
    expected = np.where(after, -v * (response.t - L / v), 0.0)
    assert by_restitution.x_r == pytest.approx(expected, abs=1e-12)
    assert by_restitution.v_r == pytest.approx(np.where(after, -v, 0.0), abs=1e-12)
