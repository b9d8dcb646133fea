"""A mass that creeps to rest on a silent base never stops, however small its velocity."""

from __future__ import annotations

import numpy as np
import pytest

import drysim
from drysim.approach import coulomb, exact, stops
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import (
    Law,
    Plant,
    Pressed,
    Pressure,
    Samples,
    Sines,
    Slider,
    State,
    Stopped,
)
from drysim.core.sampled import STRETCH

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
    response = StickSlip().solve(PLANT, Law(1.0, 2.0), still, State(5.0, 0.0), 1.0, 2000.0)
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
    whole = StickSlip().solve(plant, Law(*friction), motion, start, step, None)
    mirrored = StickSlip().solve(
        plant, Law(*friction), Samples(-u_dd, step), State(-5.0, 0.0), step, None
    )
    assert np.array_equal(mirrored.x_r, -whole.x_r)
    assert np.array_equal(mirrored.events.t, whole.events.t)
    steady = Pressure(np.ones(len(u_dd)), step, 1.0)
    pressed = exact.solve(
        plant, Pressed(*friction, pressure=steady), motion, start, step, None, True
    )
    far = stops.march(plant, Stopped(*friction, 1e3), motion, start, None)
    for events in (pressed.events, far.events):
        assert events.kind.tolist() == whole.events.kind.tolist()
        assert events.t == pytest.approx(whole.events.t, rel=1e-9, abs=1e-9 * step)
    assert pressed.x_r == pytest.approx(whole.x_r, abs=1e-13)


def test_creep_handed_over_between_blocks_goes_on_to_the_last_bit(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion = Samples(silence(0.05, 200.0), 0.05)
    scene = (PLANT, Law(1.0, 2.0), motion, State(5.0, 0.0), motion.dt, None)
    whole = StickSlip().solve(*scene)
    monkeypatch.setattr(coulomb, "KEPT", 0)
    monkeypatch.setattr(coulomb, "BLOCK", STRETCH)
    parts = StickSlip().by_parts(*scene)
    assert len(parts.track.march.marks) > 10
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
    scene = Slider(0.9, 1e3), Samples(u_dd, step), State(0.0, 0.0), step, None, True
    response = exact.solve(plant, *scene)
    mirrored = exact.solve(plant, scene[0], Samples(-u_dd, step), *scene[2:])
    assert np.array_equal(mirrored.x_r, -response.x_r)
    fine = np.interp(np.arange(2 * len(u_dd) - 1) / 2, np.arange(len(u_dd)), u_dd)
    halved = exact.solve(
        plant, scene[0], Samples(fine, step / 2), scene[2], step / 2, None, True
    )
    assert halved.x_r[::2] == pytest.approx(response.x_r, abs=1e-11)
