"""Fixed-step marches: both engines alike, and each method right to its order."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scenes import PAPER

DT = 2.5e-3
RANDOM = np.random.Generator(np.random.PCG64(8))
BASE = RANDOM.normal(0.0, 1.0, 400).cumsum() * 0.1


def on_grid(kernel: SimpleNamespace, base: np.ndarray = BASE, dt: float = DT) -> tuple:
    """Return a base motion and the buffers of a motion on its grid, from rest."""
    n, middles = len(base), 0.5 * (base[:-1] + base[1:])
    buffers = (*np.zeros((3, n)), np.full(n, 9, dtype=np.int64))
    grid = kernel.fixed_step
    return grid.BaseOnGrid(base, middles, dt), grid.MotionOnGrid(*buffers)


def stepped(kernel: SimpleNamespace, form: int, method: int) -> np.ndarray:
    """March with a function of velocity; gives x_r and v_r."""
    base, out = on_grid(kernel)
    plant = kernel.model.Plant(*PAPER)
    kernel.fixed_step.march_fixed_step(plant, 15.0, form, 100.0, method, base, out)
    return np.array(out[:2])


def banded(kernel: SimpleNamespace, march: str) -> np.ndarray:
    """March with stick; gives x_r, v_r, F_f and direction."""
    base, out = on_grid(kernel)
    plant = kernel.model.Plant(*PAPER)
    if march == "switch":
        kernel.fixed_step.march_switch(plant, 15.0, 18.0, 6e-4, base, out)
    else:
        kernel.fixed_step.march_moreau(plant, 15.0, base, out)
    return np.array(out)


@pytest.mark.parametrize("method", range(4))
def test_twins_agree_bit_for_bit_on_the_bare_sign(plain, fast, method):
    found = stepped(plain, plain.fixed_step.SIGN, method)
    assert np.abs(found[0]).max() > 1e-5
    assert np.array_equal(found, stepped(fast, fast.fixed_step.SIGN, method))


@pytest.mark.parametrize("form", range(1, 5))
def test_twins_agree_on_smooth_signs_to_the_rounding_of_their_functions(plain, fast, form):
    found = stepped(plain, form, plain.fixed_step.RK4)
    assert found == pytest.approx(stepped(fast, form, fast.fixed_step.RK4), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("march", ["switch", "moreau"])
def test_twins_agree_bit_for_bit_where_the_mass_sticks(plain, fast, march):
    found = banded(plain, march)
    assert {0.0} < set(found[3]) <= {-1.0, 0.0, 1.0}
    assert np.array_equal(found, banded(fast, march))


@pytest.mark.parametrize(("method", "order"), [(0, 1), (1, 1), (2, 2), (3, 4)])
def test_method_is_of_its_order_without_friction(kernel, method, order):
    def error(dt: float) -> float:
        base, out = on_grid(kernel, np.ones(round(0.5 / dt) + 1), dt)
        plant = kernel.model.Plant(*PAPER)
        kernel.fixed_step.march_fixed_step(plant, 0.0, 0, 0.0, method, base, out)
        _, _, Y, _ = kernel.oscillator.flow(plant.b / plant.m, plant.k_x / plant.m, 0.5)
        return abs(out.x_r[-1] + Y)

    assert math.log2(error(5e-3) / error(2.5e-3)) == pytest.approx(order, abs=0.3)


@pytest.mark.parametrize("form", range(1, 5))
def test_smooth_sign_is_odd_steep_and_at_most_one(kernel, form):
    share = kernel.fixed_step.regularised_sign
    assert share(form, 1e3, 0.0) == 0.0
    assert share(form, 1e3, -0.02) == -share(form, 1e3, 0.02)
    assert 0.0 < share(form, 1e3, 1e-4) < share(form, 1e3, 1e-3) < share(form, 1e3, 10.0) <= 1.0


def test_every_form_of_the_sign_is_its_formula(kernel):
    law, c = kernel.fixed_step, 3.0
    for v in (-2.0, -1e-3, 0.0, 0.4):
        forms = {
            law.SIGN: float(np.sign(v)), law.TANH: math.tanh(c * v), law.ERF: math.erf(c * v),
            law.ARCTAN: 2 / math.pi * math.atan(c * v), law.RATIONAL: c * v / (1 + c * abs(v)),
        }  # fmt: skip
        assert len(forms) == 5
        for form, share in forms.items():
            assert law.regularised_sign(form, c, v) == pytest.approx(share, rel=1e-15)


@pytest.mark.parametrize(("v", "d"), [(0.0, 0), (0.1, 1), (-0.1, -1)])
def test_moreau_begins_in_the_direction_of_its_start(kernel, v, d):
    base, out = on_grid(kernel)
    out.v_r[0] = v
    kernel.fixed_step.march_moreau(kernel.model.Plant(*PAPER), 15.0, base, out)
    assert (out.d[0], out.F_f[0]) == (d, 15.0 * d)
