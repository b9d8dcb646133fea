"""A contact that rings while it holds: what is its own, and that every turn is told."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from drysim.core.contacts.ring import OUTRUNS, ring, ringing
from drysim.core.events import REVERSAL, Log
from drysim.core.plant import Plant, Slider
from drysim.core.sines.slide import slide
from drysim.core.sines.stretch import starting
from drysim.core.waves import Waves, anchor, set_wave

SINES = (0.45, 1.6, 0.2), (0.1, 0.9, 1.0)
LAW = Slider(1500.0, 1e6)


def stretch_of(b, v_r, r=0.0):
    """Give a holding contact that has just been struck, under two sines; the plant with it."""
    plant = Plant(75.0, 7500.0 + LAW.k_t, b)
    waves = Waves(np.zeros(24), 2, 2)
    for i, (A, f, phase) in enumerate(SINES):
        set_wave(waves.values, i, A, f, phase)
    anchor(waves, plant, LAW, 0.0, 0)
    c, w = b / plant.m, plant.k_x / plant.m
    return plant, waves, starting(c, w, waves, 0.0, v_r, 0.0, r)


@pytest.mark.parametrize("r", [0.0, 30.0])
def test_ringing_outruns_the_slow_response_until_it_is_but_twice_as_quick(r):
    _, waves, stretch = stretch_of(500.0, 0.1, r)
    own = ringing(stretch, waves)
    fastest = abs(r) / stretch.w
    for A, f, _ in SINES:
        turn = 2j * math.pi * f
        fastest += abs(turn * A / (turn * turn + stretch.c * turn + stretch.w))
    left = own.speed * math.exp(-own.fade * own.until)
    assert left == pytest.approx(OUTRUNS * fastest, rel=1e-12)


def test_ringing_and_slow_response_make_the_motion():
    _, waves, stretch = stretch_of(500.0, 0.1, 30.0)
    own = ringing(stretch, waves)
    c, w = stretch.c, stretch.w
    for s in np.linspace(0.0, 0.1, 23).tolist():
        v_r = stretch.r / w
        v_r += own.speed * math.exp(-own.fade * s) * math.cos(own.omega * s - own.phase)
        for A, f, phase in SINES:
            turn = 2j * math.pi * f
            steady = turn * A / (turn * turn + c * turn + w)
            v_r -= (steady * cmath.exp(turn * s + 1j * phase)).imag
        found = slide(c, w, waves, stretch.x_r, stretch.v_r, stretch.g, stretch.r, s)[1]
        assert found == pytest.approx(v_r, abs=1e-13)


def test_undamped_contact_is_followed_through_all_its_turns_at_once():
    plant, waves, stretch = stretch_of(0.0, 0.1)
    own, left = ringing(stretch, waves), 0.5
    assert own.until == math.inf
    room = 100
    log = Log(*(np.zeros(room, dtype=kind) for kind in "qdbdd"))
    begin = (own.phase + 0.5 * math.pi) / own.omega
    x_r = slide(0.0, stretch.w, waves, 0.0, 0.1, 0.0, 0.0, begin)[0]
    _, _, count = ring(
        plant, LAW, waves, stretch, 0.0, -1, 0, 0.0, begin, x_r, left, log, 0, room
    )
    assert count == math.floor((left - begin) * own.omega / math.pi - 1.0 / 6.0)
    assert (log.kind[:count] == REVERSAL * np.array([1, -1] * room)[:count]).all()
    for s in log.s[:count].tolist():
        v_r = slide(0.0, stretch.w, waves, 0.0, 0.1, 0.0, 0.0, s)[1]
        assert abs(v_r) < 1e-13
