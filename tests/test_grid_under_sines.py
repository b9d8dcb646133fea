"""Sines on a grid: stepping from point to point gives what the events alone give."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.approach import coulomb
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import Law, Plant, Sines, State, base_acceleration

PAPER = Plant(75.0, 7500.0, 500.0)
ONE = Sines((1.06,), (2.0,), (0.3,))
TWO = Sines((1.4, 0.9), (1.1, 3.7), (0.4, 1.0))
REST = Sines((), (), ())
SCENES = {
    "one sine": (PAPER, Law(45.0, 54.0), ONE, 2.5e-3),
    "two sines": (PAPER, Law(30.0, 36.0), TWO, 2.5e-3),
    "varying friction": (PAPER, Law(30.0, 36.0, 0.4, 10.7, 0.2), TWO, 2.5e-3),
    "no friction": (PAPER, Law(0.0, 0.0), TWO, 2.5e-3),
    "no damping": (Plant(75.0, 7500.0, 0.0), Law(15.0, 15.0), ONE, 2.5e-3),
    "no spring": (Plant(75.0, 0.0, 500.0), Law(45.0, 45.0), ONE, 2.5e-3),
    "nothing but friction": (Plant(75.0, 0.0, 0.0), Law(45.0, 45.0), ONE, 2.5e-3),
    "fifty times critical": (Plant(75.0, 7500.0, 75000.0), Law(15.0, 18.0), ONE, 2.5e-3),
    "fifty radians a step": (Plant(75.0, 3e10, 1e5), Law(15.0, 18.0), ONE, 2.5e-3),
    "free motion": (Plant(1.0, 1.0, 0.0), Law(0.01, 0.01), REST, 0.01),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_grid_has_the_states_between_the_events(scene):
    plant, law, motion, step = scene
    found = StickSlip().solve(plant, law, motion, State(0.02, 0.1), step, 2000 * step)
    states = np.array([found.track.state(n * step) for n in range(2001)])
    for series, column in ((found.x_r, states[:, 0]), (found.v_r, states[:, 1])):
        assert np.abs(series - column).max() <= 1e-12 * np.abs(column).max()
    assert np.abs(found.u_dd - base_acceleration(motion, found.t)).max() < 1e-13


def test_friction_only_takes_at_every_point_also_where_the_motion_dies_out():
    # Far above critical damping the mass creeps to its place and never stops.
    plant, law = Plant(75.0, 7500.0, 15000.0), Law(1.0, 1.0)
    found = StickSlip().solve(plant, law, REST, State(0.02, 0.0), 0.05, 200.0)
    assert (found.F_f * found.v_r >= 0.0).all()
    assert not found.stuck.any()
    states = np.array([found.track.state(t) for t in found.t.tolist()])
    for series, column in ((found.x_r, states[:, 0]), (found.v_r, states[:, 1])):
        assert np.abs(series - column).max() <= 1e-12 * np.abs(column).max()


def test_blocks_of_a_grid_are_those_of_the_whole_to_the_last_bit():
    plant, law, motion, step = SCENES["two sines"]
    found = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 3000 * step)
    for first, last in ((0, 7), (100, 1000), (255, 258), (1777, 3001)):
        part = found.grid.part(first, last)
        assert (part.x_r == found.x_r[first:last]).all()
        assert (part.v_r == found.v_r[first:last]).all()
        assert (found.grid.base(first, last) == found.u_dd[first:last]).all()


def test_mirrored_base_gives_the_mirrored_grid_to_the_last_bit():
    plant, law, motion, step = SCENES["two sines"]
    mirrored = motion._replace(A=tuple(-A for A in motion.A))
    one = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 3000 * step)
    other = StickSlip().solve(plant, law, mirrored, State(0.0, 0.0), step, 3000 * step)
    assert (one.x_r == -other.x_r).all()
    assert (one.v_r == -other.v_r).all()


def test_base_is_computed_for_those_who_ask_for_it():
    plant, law, motion, step = SCENES["one sine"]
    found = StickSlip().solve(plant, law, motion, State(0.0, 0.0), step, 300 * step)
    assert len(found.x_r) == len(found.v_r) == 301
    assert "u_dd" not in vars(found)
    assert np.abs(found.u_dd - base_acceleration(motion, found.t)).max() < 1e-13


@pytest.mark.parametrize("room", [2, 3, 7])
def test_room_for_events_that_grows_leaves_no_trace(room, monkeypatch):
    plant, law, motion, step = SCENES["two sines"]
    scene = (plant, law, motion, State(0.02, 0.1), step, 3000 * step)
    one = StickSlip().solve(*scene)
    monkeypatch.setattr(coulomb, "FEW_EVENTS", room)
    other = StickSlip().solve(*scene)
    assert len(one.events) > 20
    for name in ("t", "kind", "x_r", "F_L"):
        assert np.array_equal(getattr(one.events, name), getattr(other.events, name))
    assert one.numerics.closest_decision == other.numerics.closest_decision
