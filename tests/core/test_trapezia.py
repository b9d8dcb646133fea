"""The rule of trapezia with what its ends say: exact for a step, in both engines."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.core.trajectory import TWELVE_NODES, TWELVE_WEIGHTS


@pytest.mark.parametrize(
    ("c", "w"),
    [(6.7, 100.0), (0.0, 0.0), (0.0, 1.6e5), (390.0, 0.0), (190.0, 4e4)],
    ids=["paper", "block", "undamped", "no spring", "as long as may be"],
)
@pytest.mark.parametrize("d", [1.0, 0.0])
def test_rule_of_trapezia_is_exact_for_a_step_by_what_its_ends_say(kernel, c, w, d):
    h, f, u, slope = 2.5e-3, 0.3, -0.7, 11.0
    x, v = (0.004, 0.02) if d else (0.004, 0.0)
    rule, t = kernel.lanes.trapezia(c, w, h), np.array(TWELVE_NODES) * h

    def state(s):
        if not d:
            return x, 0.0
        y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
        push = u + d * f
        return (
            x * (1.0 - w * Y) + v * y - push * Y - slope * YY,
            v * y_d - (push + w * x) * y - slope * Y,
        )

    def felt(x, v):
        return c * v + (w * x + d * f)

    between = np.array([state(s) for s in t])
    u_dd = u + slope * t
    x_dd = felt(*between.T) if d else u_dd
    there, found = state(h), np.zeros(kernel.lanes.INTEGRALS)
    for at, base, side in (((x, v), u, -1.0), (there, u + slope * h, 1.0)):
        what = rule, d, at[0], felt(*at), base, at[1]
        found += kernel.lanes.halves(*what)
        found += side * np.array(kernel.lanes.ends(*what, slope))
    heights = [
        between[:, 0] ** 2, between[:, 1] ** 2, x_dd**2, u_dd * between[:, 1],
        d * between[:, 1], np.full(len(t), float(d == 0.0)), u_dd**2,
    ]  # fmt: skip
    assert found == pytest.approx(h * np.array(heights) @ TWELVE_WEIGHTS, rel=2e-14, abs=1e-22)
