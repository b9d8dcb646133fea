"""What a contact that holds has of its own besides the response to the base."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from drysim.core.forcing import Waves, anchor, set_wave, slide, starting
from drysim.core.model import Plant, Slider
from drysim.core.modes import ringing

SINES = (1.0, 1.6, 0.2), (0.1, 0.9, 1.0)
LAW = Slider(1500.0, 1e6)


def stretch_of(v_r, r):
    """Give a holding contact that has just been struck, under two sines; the waves with it."""
    plant = Plant(75.0, 7500.0 + LAW.k_t, 500.0)
    waves = Waves(np.zeros(24), 2, 2)
    for i, (A, f, phase) in enumerate(SINES):
        set_wave(waves.values, i, A, f, phase)
    anchor(waves, plant, LAW, 0.0, 0)
    c, w = plant.b / plant.m, plant.k_x / plant.m
    return waves, starting(c, w, waves, 1e-4, v_r, 0.3, r)


def responses(stretch):
    """Give the steady response to every sine, as a rotating length [m], and how it turns."""
    for A, f, phase in SINES:
        turn = 2j * math.pi * f
        answer = -A / (turn * turn + stretch.c * turn + stretch.w)
        yield turn, answer * cmath.exp(1j * phase)


@pytest.mark.parametrize("v_r", [0.1, -0.1])
@pytest.mark.parametrize("r", [0.0, 30.0])
def test_ringing_and_steady_response_make_the_motion(v_r, r):
    waves, stretch = stretch_of(v_r, r)
    own, c, w = ringing(stretch, waves), stretch.c, stretch.w
    assert abs(own.phase) <= 0.5 * math.pi
    for s in np.linspace(0.0, 0.1, 23).tolist():
        x_r = (
            own.side * own.size * math.exp(-own.fade * s) * math.cos(own.omega * s - own.phase)
        )
        x_r += (stretch.g + r * (s - c / w)) / w
        x_r += sum((each * cmath.exp(turn * s)).imag for turn, each in responses(stretch))
        found = slide(c, w, waves, stretch.x_r, stretch.v_r, stretch.g, r, s)[0]
        assert found == pytest.approx(x_r, abs=1e-15)


def test_steady_response_bends_by_no_more_than_all_sines_together():
    waves, stretch = stretch_of(0.1, 0.0)
    most = sum(abs(turn * turn * each) for turn, each in responses(stretch))
    assert ringing(stretch, waves).bend == pytest.approx(most, rel=1e-12)
