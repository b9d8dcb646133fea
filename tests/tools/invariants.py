"""What holds of every contact and of every base motion."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from law_scenes import REST, mirrored, sine, solved

from drysim.core.model import State
from drysim.metrics.table import measure


class Invariants:
    """Tests of a class that is parametrised by `law` and `motion`."""

    residual = 1e-13

    def test_energy_closes(self, law, motion):
        metrics = measure(solved(law, motion, duration=2.9).trajectory, (0.7, 2.9), None)
        assert metrics["energy_residual"] < self.residual
        assert metrics["energy_friction"] > 0

    def test_mirrored_base_motion_gives_the_mirrored_response_bit_for_bit(self, law, motion):
        one, two = (solved(law, each, duration=2.0) for each in (motion, mirrored(motion)))
        assert (one.x_r == -two.x_r).all()
        assert (one.F_f == -two.F_f).all()


class TouchingZero:
    """Tests of a class whose `law` has a normal force that touches zero once a period."""

    law: Any

    @pytest.mark.parametrize("phase", [-0.5 * math.pi, 1.5 * math.pi])
    @pytest.mark.parametrize("start", [REST, State(0.0, 0.01), State(1e-3, 0.0)])
    def test_force_that_touches_zero_at_the_start_does_not_part_the_surfaces(
        self, start, phase
    ):
        # They were taken for lifted off, and they never met again.
        law, near = (self.law._replace(phase=at) for at in (phase, phase + 1e-7))
        one, other = (solved(each, sine(1.0, 1.6), start, duration=2.0) for each in (law, near))
        assert "lift" not in one.events.names
        assert np.abs(one.x_r - other.x_r).max() < 1e-6 * np.abs(other.x_r).max()
