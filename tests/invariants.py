"""What holds of every contact and of every base motion."""

from __future__ import annotations

from drysim.metrics import measure
from law_scenes import mirrored, solved


class Invariants:
    """Tests of a class that is parametrised by `law` and `motion`."""

    residual = 1e-13

    def test_energy_closes(self, law, motion):
        metrics = measure(solved(law, motion, duration=2.9).track, (0.7, 2.9), None)
        assert metrics["energy_residual"] < self.residual
        assert metrics["energy_friction"] > 0

    def test_mirrored_base_motion_gives_the_mirrored_response_bit_for_bit(self, law, motion):
        one, two = (solved(law, each, duration=2.0) for each in (motion, mirrored(motion)))
        assert (one.x_r == -two.x_r).all()
        assert (one.F_f == -two.F_f).all()
