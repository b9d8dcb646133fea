"""Every contact, normal force and end stop together: laws of physics, and a second solution."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from law_scenes import PAPER, mirrored, noise

from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    EndStops,
    NormalForceRecord,
    PiecewiseLaw,
    Samples,
    Sines,
    State,
    acceleration_at,
)
from drysim.metrics.table import measure

LIMIT = 0.004
RECORD = NormalForceRecord(1.0 + 1.1 * np.sin(np.arange(400) * 0.07), 0.01, 100.0)
CONTACTS = {"rigid": (45.0, 54.0, 0.0), "elastic": (45.0, 45.0, 1e5)}
LOADS = {
    "constant": {},
    "varying": {"variation": 0.6, "omega": 14.0, "phase": 0.3},
    "lifting": {"variation": 1.4, "omega": 9.0, "phase": 1.0},
    "recorded": {"force_record": RECORD},
}
STOPS = {
    "bumper": EndStops(LIMIT, LIMIT, ((0.0, 2e5),)),
    "damped bumper": EndStops(LIMIT, LIMIT, ((0.0, 2e5),), 300.0),
    "staged bumper": EndStops(LIMIT, LIMIT, ((0.0, 5e4), (2e-4, 1e5), (4e-4, 4e5)), 400.0),
    "rigid": EndStops(LIMIT, LIMIT, e=0.5),
    "dead": EndStops(LIMIT, LIMIT, e=0.0),
}
COMBINATIONS = list(itertools.product(CONTACTS, LOADS, STOPS))
MOTIONS = {"sines": Sines((3.0, 1.2), (1.6, 3.7), (0.0, 1.0)), "samples": noise(1200, 2.5, 3)}
SPAN = 2.5


def law_of(contact: str, load: str, stops: str) -> PiecewiseLaw:
    F_fk, F_fs, k_t = CONTACTS[contact]
    return PiecewiseLaw(F_fk, F_fs, k_t, stops=STOPS[stops], **LOADS[load])


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize(("contact", "load", "stops"), COMBINATIONS)
def test_forces_keep_their_limits_and_energy_is_conserved(contact, load, stops, motion):
    law = law_of(contact, load, stops)
    trajectory = StickSlip().trajectory(PAPER, law, motion, State(0.0, 0.0), 1e-3, SPAN)
    values = measure(trajectory, (0.0, SPAN), LIMIT)
    assert values["contacts"] > 3
    assert values["energy_residual"] < 1e-11
    t = np.linspace(0.0, SPAN, 20_001)
    found = trajectory.at(t)
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
    one = StickSlip().trajectory(PAPER, law, motion, State(1e-3, 0.02), 1e-3, SPAN).at(t)
    other = StickSlip().trajectory(
        PAPER, law, mirrored(motion), State(-1e-3, -0.02), 1e-3, SPAN
    )
    assert (other.at(t).x_r == -one.x_r).all()


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
    stages, b_s, limit = law.stops.stages, law.stops.b_s, law.stops.up
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
    trajectory = StickSlip().trajectory(PAPER, law, motion, State(0.0, 0.0), 1e-3, span)
    exact = trajectory.at(np.arange(len(fine)) * 1000 * h).x_r
    assert np.abs(exact).max() > LIMIT
    # Halving the steps shows their error, but for that of a step in which the mode changes.
    error = np.abs(fine[::2] - coarse[: len(fine[::2])]).max()
    assert error < 1e-6
    assert np.abs(exact - fine).max() < 3.0 * error + 2e-7


def test_stages_that_continue_the_line_are_a_single_bumper():
    motion, start, t = MOTIONS["sines"], State(0.0, 0.0), np.linspace(0.0, SPAN, 999)
    single = PiecewiseLaw(45.0, 54.0, stops=EndStops(LIMIT, LIMIT, ((0.0, 2e5),), 300.0))
    stages = ((0.0, 2e5), (1e-4, 0.0), (3e-4, 0.0))
    staged = PiecewiseLaw(45.0, 54.0, stops=EndStops(LIMIT, LIMIT, stages, 300.0))
    one, other = (
        StickSlip().trajectory(PAPER, law, motion, start, 1e-3, SPAN)
        for law in (single, staged)
    )
    assert np.abs(one.at(t).x_r - other.at(t).x_r).max() < 1e-13
    assert len(one.events) == len(other.events)
