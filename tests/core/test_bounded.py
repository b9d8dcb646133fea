"""The march between end stops: both engines, the code of its modes, rest after a chatter."""

from __future__ import annotations

import numpy as np
import pytest

N, DT = 300, 5e-3
U_DD = 2.0 * np.convolve(np.random.default_rng(4).standard_normal(N), np.ones(8), "same")
LAWS = {
    "bumper": (45.0, 54.0, 0.004, 2e5, 300.0, 0.0),
    "dead bumper": (20.0, 20.0, 0.002, 5e4, 8e3, 0.0),
    "rigid": (45.0, 54.0, 0.004, 0.0, 0.0, 0.6),
}


def follow(kernel, law, plant=(75.0, 7500.0, 300.0), u_dd=U_DD, start=(0.0, 0.05)):
    """March from sample to sample; gives what was written of the trail and of the log."""
    core, room = kernel.march, 20 * len(u_dd)
    plant, law = kernel.model.Plant(*plant), kernel.model.Stopped(*law)
    waves = kernel.forcing.Waves(np.zeros(0), 0, 0)
    trail = kernel.events.Trail(
        *(np.zeros(room, int if name in ("n", "d", "terms") else float)
          for name in kernel.events.Trail._fields)
    )  # fmt: skip
    log = kernel.events.Log(
        *(np.zeros(room, int if name in ("n", "kind") else float)
          for name in kernel.events.Log._fields)
    )  # fmt: skip
    state = kernel.modes.first_bounds(plant, law, *start, u_dd[0], 1.0)
    last = len(u_dd) - 2
    *_, at, count = core.bound(
        plant, law, waves, u_dd, DT, 0, 0.0, DT, last, *state, trail, 0, log, 0, room
    )
    written = [column[:at] for column in trail[:6]] + [column[:count] for column in log]
    return at, count, written


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_engines_agree_bit_for_bit(plain, fast, law):
    slow, quick = follow(plain, law), follow(fast, law)
    assert slow[:2] == quick[:2]
    assert slow[1] > 30
    for one, other in zip(slow[2], quick[2], strict=True):
        assert (one == other).all()


def test_mode_is_one_number_that_tells_all_three(kernel):
    core = kernel.modes
    for touch in (-core.AWAY, -core.TOUCHING, core.APART, core.TOUCHING, core.AWAY):
        for d in (-1, 0, 1):
            for fresh in (core.STEADY, core.BROKE, core.POISED):
                mode = core.mode_of(touch, d, fresh)
                told = core.touch_of(mode), core.way_of(mode), core.fresh_of(mode)
                assert told == (touch, d, fresh)
                assert mode != core.MEET


@pytest.mark.parametrize(
    ("x_r", "v_r", "touch"),
    [(0.003, 9.0, 0), (0.004, 1.0, 0), (-0.005, 0.0, -1), (0.005, -1.0, 2), (0.005, 1.0, 1)],
)
def test_place_tells_how_a_mass_is_to_a_bumper(kernel, x_r, v_r, touch):
    law = kernel.model.Stopped(*LAWS["dead bumper"])._replace(x_rM=0.004)
    z, xi, found = kernel.modes.place(law, x_r, v_r)
    assert z + xi == x_r
    assert found == touch


@pytest.mark.parametrize("e", [0.2, 0.9, 0.99])
def test_chatter_under_steady_pressure_ends_after_few_impacts(kernel, e):
    """Heights fall by e² from one to the next, from 1 to 2^-54 of the limit."""
    pressed = np.full(4000, -5.0)
    law = (0.0, 0.0, 0.01, 0.0, 0.0, e)
    *_, written = follow(kernel, law, (1.0, 0.0, 0.0), pressed, (0.01, -0.3))
    kinds = written[8]
    assert kinds[-1] == 0
    fewest = np.log(0.3 / np.sqrt(2 * 5.0 * 0.01 * 2.0**-54)) / -np.log(e)
    assert (kinds == -6).sum() == pytest.approx(fewest, rel=0.02, abs=2)
    assert written[2][-1] == 0.0
    assert written[4][-1] == 0.01
