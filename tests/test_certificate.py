"""The certificate of a motion: right ones pass, and those broken on purpose never do.

It is the energy residual, whose dissipated energies are those that the law demands of the
motion, and the largest violation of the laws that does no work.
"""

from __future__ import annotations

import math
import zlib

import numpy as np
import pytest
from broken import BREAKS, break_motion, with_segments
from seat import EM6_SEAT, SEAT

import drysim
from drysim.approach.exact import compute_trajectory
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    AnyLaw,
    CoulombLaw,
    DynamicLaw,
    EndStops,
    NormalForceRecord,
    PiecewiseLaw,
    Plant,
    Samples,
    Sines,
    State,
    StrokeLimits,
)
from drysim.metrics.energy import hysteresis_energy
from drysim.metrics.table import measure
from drysim.study import warnings
from drysim.study.warnings import MAX_RESIDUAL, certificate_warnings

DURATION = 40.0
"""Length of a motion in radians of the natural frequency."""

FAST, MANY = range(4), range(4, 100)
SEEDS = [pytest.param(FAST, id="few"), pytest.param(MANY, id="many", marks=pytest.mark.slow)]
"""Seeds of the scenes in `make test` and in `make slow`."""

WRONG = 1e-3
"""Deviation of x_r or v_r, relative to its peak, from which a motion is wrong."""

TRIES = 8
"""Places at which a motion is broken in one way until it is wrong."""

CLOSES = 1e-11
"""What rounding, or the tolerance of the Taylor series, may leave of a right motion [-]."""


def draw_scene(name: str, rng: np.random.Generator) -> tuple[Plant, AnyLaw, Sines | Samples]:
    """Draw an oscillator that stops and slides, or yields, under a law; ω_0 is 1."""
    m, A = float(rng.uniform(0.5, 3.0)), float(rng.uniform(0.5, 2.0))
    plant = Plant(m, m, float(rng.uniform(0.0, 0.3)) * m)
    F = float(rng.uniform(0.2, 0.7)) * m * A
    if rng.random() < 0.5:
        f = rng.uniform(0.5, 2.0, 2) / math.tau
        motion: Sines | Samples = Sines((A, 0.5 * A), tuple(f.tolist()), (0.0, 1.0))
    else:
        u_dd = np.convolve(rng.standard_normal(int(DURATION / 0.1) + 20), np.ones(20), "valid")
        motion = Samples(A / 3.0 * u_dd, 0.1)
    return plant, LAWS[name](F, m, A, rng), motion


def coulomb(F, m, A, rng):
    return CoulombLaw(F, F * float(rng.choice([1.0, 1.3])))


def varying(F, m, A, rng):
    return CoulombLaw(
        F, 1.2 * F, float(rng.uniform(0.2, 0.9)), float(rng.uniform(0.3, 3.0)), 1.0
    )


def by_direction(F, m, A, rng):
    less = float(rng.uniform(0.3, 0.9))
    return PiecewiseLaw(F, 1.2 * F, compression=(less * F, less * F * 1.3))


def directed_damper(F, m, A, rng):
    return PiecewiseLaw(F, 1.2 * F, damping=(0.1 * m, float(rng.uniform(0.3, 0.8)) * m))


def separating(F, m, A, rng):
    return PiecewiseLaw(F, 1.2 * F, 0.0, float(rng.uniform(1.1, 2.0)), 0.7, 0.3)


def recorded(F, m, A, rng):
    load = 1.0 + rng.uniform(0.5, 1.5) * np.sin(np.arange(600) * rng.uniform(0.02, 0.2))
    return PiecewiseLaw(0.6 * F, 0.7 * F, force_record=NormalForceRecord(load, 0.1, 1.0))


def jenkins(F, m, A, rng):
    return PiecewiseLaw(F, F, m * float(rng.uniform(2.0, 50.0)))


def petrov_ewins(F, m, A, rng):
    swing, k_t = float(rng.uniform(0.3, 1.8)), m * float(rng.uniform(2.0, 50.0))
    return PiecewiseLaw(F, F, k_t, swing, float(rng.uniform(0.3, 3.0)), 1.0)


def stops_at(A, rng, **kwargs):
    limit = A * float(rng.uniform(0.1, 0.3))
    return EndStops(StrokeLimits(limit, limit * float(rng.uniform(0.7, 1.4))), **kwargs)


def bumpers(F, m, A, rng):
    stages = ((0.0, m * float(rng.uniform(5.0, 50.0))), (0.02 * A, 20.0 * m))
    stops = stops_at(A, rng, stages=stages, b_s=m * float(rng.uniform(0.0, 3.0)))
    return PiecewiseLaw(0.5 * F, 0.6 * F, stops=stops)


def rigid_stops(F, m, A, rng):
    return PiecewiseLaw(
        0.5 * F, 0.6 * F, stops=stops_at(A, rng, e=float(rng.uniform(0.0, 0.8)))
    )


def elastic_in_rigid_stops(F, m, A, rng):
    stops = stops_at(A, rng, e=float(rng.uniform(0.0, 0.8)))
    return PiecewiseLaw(0.5 * F, 0.5 * F, m * float(rng.uniform(2.0, 50.0)), stops=stops)


def stribeck(F, m, A, rng):
    exponent = float(rng.choice([0.7, 1.0, 2.0]))
    return DynamicLaw(F, 1.3 * F, STRIBECK, A * float(rng.uniform(0.1, 1.0)), exponent)


def bristles(F, m, A, rng, passive):
    sigma_0 = m * float(rng.uniform(20.0, 300.0))
    sigma_1 = float(rng.uniform(0.0, 0.5)) * math.sqrt(sigma_0 * m)
    return {
        "v_s": A * float(rng.uniform(0.1, 1.0)), "sigma_0": sigma_0, "sigma_1": sigma_1,
        "sigma_2": passive * sigma_1,
    }  # fmt: skip


def dahl(F, m, A, rng):
    return DynamicLaw(F, F, BRISTLE, sigma_0=m * float(rng.uniform(20.0, 300.0)))


def lugre(F, m, A, rng):
    return DynamicLaw(F, 1.2 * F, BRISTLE, **bristles(F, m, A, rng, passive=0.2))


def leuven(F, m, A, rng):
    power = float(rng.choice([1.0, 1.5, 2.0, 3.0]))
    F_h = 1.2 * F * float(rng.uniform(1.05, 3.0))
    return DynamicLaw(
        F, 1.2 * F, LEUVEN, **bristles(F, m, A, rng, passive=0.2), F_h=F_h, power=power
    )


LAWS = {
    law.__name__: law
    for law in (
        coulomb, varying, by_direction, directed_damper, separating, recorded, jenkins,
        petrov_ewins, bumpers, rigid_stops, elastic_in_rigid_stops, stribeck, dahl, lugre,
        leuven,
    )
}  # fmt: skip


def solve(name: str, seed: int):
    rng = np.random.default_rng([zlib.crc32(name.encode()), seed])
    plant, law, motion = draw_scene(name, rng)
    return compute_trajectory(plant, law, motion, State(0.0, 0.0), DURATION), rng


def residuals(trajectory, window):
    values = measure(trajectory, window, None)
    return values["energy_residual"], values["law_residual"]


def states(trajectory):
    times = np.linspace(0.0, DURATION, 81)[1:-1].tolist()
    try:
        return np.array([trajectory.state(t)[:2] for t in times])
    except ZeroDivisionError:  # a broken motion may slide at rest, without nan in plain Python
        return np.full((len(times), 2), np.nan)


# Right motions.


@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("name", LAWS)
def test_right_motion_is_certified_and_friction_only_takes_energy(name, seeds):
    """In every window."""
    for seed in seeds:
        trajectory, rng = solve(name, seed)
        whole = measure(trajectory, (0.0, DURATION), None)
        for window in [(0.0, DURATION), *np.sort(rng.uniform(0.0, DURATION, (3, 2))).tolist()]:
            values = measure(trajectory, tuple(window), None)
            assert values["energy_residual"] < CLOSES, (seed, window)
            assert values["law_residual"] < CLOSES, (seed, window)
            taken = values["energy_friction"]
            assert taken >= -1e-13 * whole["energy_friction"], (seed, window)


# Motions broken on purpose.


def count_seen(name: str, seed: int) -> int:
    """Break a motion in every way until it is wrong; return how often it became that.

    Every one of these must be seen. Some places do not matter, as that of a light contact.
    """
    trajectory, rng = solve(name, seed)
    right, seen = states(trajectory), 0
    for way in BREAKS:
        for _ in range(TRIES):
            broken = break_motion(trajectory, way, rng)
            off = np.abs(states(broken) - right).max(axis=0) / np.abs(right).max(axis=0)
            if off.max() > WRONG:
                energy, law = residuals(broken, (0.0, DURATION))
                assert not (energy <= MAX_RESIDUAL and law <= MAX_RESIDUAL), (seed, way, off)
                seen += 1
                break
    return seen


@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("name", LAWS)
def test_motion_broken_on_purpose_is_not_certified(name, seeds):
    seen = sum(count_seen(name, seed) for seed in seeds)
    assert seen >= len(seeds) / (2 if seeds is MANY else 1)


PAPER, BASE = Plant(75.0, 7500.0, 500.0), Sines((2.0,), (2.0,), (0.0,))


def motion_of(law, base=BASE, end=10.0, plant=PAPER):
    return compute_trajectory(plant, law, base, State(0.0, 0.0), end)


@pytest.mark.parametrize("kept", [2, 5, 10])
def test_missed_turning_points_leave_energy_of_the_size_of_the_error(kept):
    right = motion_of(CoulombLaw(45.0, 54.0))
    wrong = first_rows(right, kept)
    T_a = [measure(one, (0.0, 10.0), None)["T_a"] for one in (right, wrong)]
    assert T_a[1] > 1.1 * T_a[0]
    assert residuals(wrong, (0.0, 10.0))[0] > 0.3


def test_mass_that_sticks_beyond_its_limit_is_seen_though_nothing_does_work():
    right = motion_of(CoulombLaw(90.0, 108.0))
    events = right.events
    stop = int(np.flatnonzero(events.kind[1:] == 0)[0]) + 1
    wrong = first_rows(right, stop + 1)
    energy, law = residuals(wrong, (float(events.t[stop]), 10.0))
    assert energy == 0.0
    assert law > 0.1


def test_slip_that_begins_below_the_static_limit_is_seen_though_friction_opposes_it():
    right = motion_of(CoulombLaw(90.0, 108.0))
    events = right.events
    slip = int(np.flatnonzero(np.abs(events.kind[1:]) == 1)[0]) + 1
    wrong = first_rows(right, slip + 1)
    wrong.march.block(0).rows.s[slip] = 0.05 * events.t[slip - 1] + 0.95 * events.t[slip]
    energy, law = residuals(wrong, (float(events.t[slip - 1]), float(events.t[slip])))
    assert energy < CLOSES
    assert law > 1e-3


def first_rows(trajectory, count):
    rows = trajectory.march.block(0).rows
    return with_segments(trajectory, type(rows)(*(column[:count].copy() for column in rows)))


def without_rows(trajectory, i, count=1):
    rows = trajectory.march.block(0).rows
    others = (np.delete(column, slice(i, i + count)) for column in rows)
    return with_segments(trajectory, type(rows)(*others))


def test_elastic_contact_beyond_its_limit_is_seen_though_it_is_a_spring():
    right = motion_of(PiecewiseLaw(45.0, 45.0, 1e5))
    starts = right.march.block(0).rows.s
    wrong = first_rows(right, 1)
    energy, law = residuals(wrong, (0.0, float(starts[3])))
    assert energy < CLOSES
    assert law > 1e-2


def test_missed_impact_penetrates_the_rigid_stop():
    limits = StrokeLimits(0.005, 0.005)
    right = motion_of(PiecewiseLaw(15.0, 15.0, stops=EndStops(limits, e=0.5)))
    hit = int(np.flatnonzero(right.march.block(0).rows.d == -1)[0])
    wrong = without_rows(right, hit, 2)
    window = (0.0, float(right.march.block(0).rows.s[hit + 2]))
    energy, law = residuals(wrong, (0.0, window[1] * (1.0 - 1e-9)))
    assert energy < CLOSES
    assert law > 1e-3


def test_mass_that_a_rigid_stop_would_have_to_pull_is_seen():
    stops = EndStops(StrokeLimits(0.005, 0.005), e=0.0)
    right = motion_of(PiecewiseLaw(15.0, 15.0, stops=stops), Sines((8.0,), (1.0,), (0.0,)))
    rows = right.march.block(0).rows
    for i in np.flatnonzero(rows.x_r[:-1] == 0.0).tolist():
        window = (float(rows.s[i]), float(rows.s[i + 1]))
        if window[1] - window[0] < 0.05:
            continue
        later = (window[0], min(window[1] + 0.2, right.end))
        energy, law = residuals(without_rows(right, i + 1, len(rows.s)), later)
        assert energy < CLOSES
        assert law > 0.1
        return
    raise AssertionError("the mass never rests against a stop")


# Stored and dissipated energy.


def test_contact_that_never_yields_dissipates_nothing():
    values = measure(motion_of(PiecewiseLaw(1e4, 1e4, 1e5)), (0.3, 7.7), None)
    assert values["energy_friction"] == 0.0
    assert values["energy_residual"] < CLOSES


def test_cycle_of_a_slider_takes_its_limit_times_the_distance_slid():
    law, period = PiecewiseLaw(45.0, 45.0, 1e5), 0.5
    trajectory = motion_of(law, end=20.0)
    values = measure(trajectory, (20.0 - period, 20.0), None)
    slid = 4.0 * (values["x_r_peak"] - law.F_fk / law.k_t)
    assert values["energy_friction"] == pytest.approx(law.F_fk * slid, rel=1e-9)
    assert values["energy_stored"] == pytest.approx(0.0, abs=1e-9)


def iwan_springs(turns, limits):
    """Return the deflections of springs behind sliders that follow a travel over its turns."""
    stretch, last = np.zeros(len(limits)), 0.0
    for turn in turns:
        stretch = np.clip(stretch + turn - last, -limits, limits)
        last = turn
    return stretch


@pytest.mark.parametrize("seed", range(12))
def test_hysteresis_stores_what_the_springs_of_its_sliders_store(seed):
    rng = np.random.default_rng(seed)
    law = DynamicLaw(4.0, 5.0, LEUVEN, sigma_0=200.0, F_h=float(rng.uniform(5.1, 20.0)))
    length = law.F_h / law.sigma_0
    spread = float(rng.uniform(0.1, 2.0)) * length
    # Turns nested in one another, so that every reversal is remembered.
    turns = spread * (-0.8) ** np.arange(1, 1 + int(rng.integers(1, 7)))
    edges = np.linspace(0.0, 40.0 * length, 400_001)
    limits = 0.5 * (edges[1:] + edges[:-1])
    stiffness = law.sigma_0 * -np.diff(np.exp(-edges / length))
    deflections = [
        float(stiffness @ iwan_springs(turns[:i], limits)) / law.sigma_0
        for i in range(1, 1 + len(turns))
    ]
    stored = float(0.5 * stiffness @ iwan_springs(turns, limits) ** 2)
    *reversals, z = deflections
    assert hysteresis_energy(law, z, tuple(reversals)) == pytest.approx(stored, rel=1e-6)


def test_hysteresis_that_hardly_moves_is_a_spring():
    law = DynamicLaw(4.0, 5.0, LEUVEN, sigma_0=200.0, F_h=6.0)
    assert hysteresis_energy(law, 1e-12, ()) == pytest.approx(0.5 * 200.0 * 1e-24, rel=1e-9)
    assert hysteresis_energy(law, 0.0, ()) == 0.0
    assert hysteresis_energy(law, 0.04, ()) == math.inf


# What is said of it.


def test_failed_certificate_is_a_warning_but_not_for_fixed_steps():
    def slugs(energy, law):
        return [warning.slug for warning in certificate_warnings(energy, law)]

    assert slugs(1e-12, 1e-12) == slugs(1e-3, None) == []
    assert slugs(1e-3, 0.0) == ["energy-open"]
    assert slugs(1e-15, 1e-3) == slugs(1e-15, math.nan) == ["law-violated"]


def test_run_sweep_and_ensemble_judge_the_certificate(seat, monkeypatch):
    monkeypatch.setattr(warnings, "MAX_RESIDUAL", -1.0)
    many = seat.with_name("many.yaml")
    many.write_text(EM6_SEAT.replace("seed: 1", "seed: 1, seeds: 2"))
    swept = seat.with_name("swept.yaml")
    swept.write_text(f"{SEAT}sweep: {{friction.kinetic: [15, 30]}}")
    for solve, file in ((drysim.run, seat), (drysim.sweep, swept), (drysim.run, many)):
        slugs = {warning.slug for warning in solve(drysim.load(file)).warnings}
        assert {"energy-open", "law-violated"} <= slugs
