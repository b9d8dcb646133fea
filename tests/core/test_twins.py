"""The plain engine and the compiled one give the same answer for any scene."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from drawn import Scene, scenes
from hypothesis import HealthCheck, given, settings
from scenes import march, march_sines

FAST, MANY = 40, 1000

NEAR = 1e-9
"""Under sines the compiler may round a power or a remainder its own way: 1e-13 as a rule."""


def twins_agree(plain: SimpleNamespace, fast: SimpleNamespace, scene: Scene) -> None:
    """Solve a scene with both engines: bit for bit over samples."""
    plant, start = (scene.m, scene.k_x, scene.b), (scene.x_r, scene.v_r)
    if scene.u_dd:
        u_dd, F = np.array(scene.u_dd), (scene.F_fk, scene.F_fs)
        one, other = (
            march(kernel, u_dd, scene.dt, F, plant, start) for kernel in (plain, fast)
        )
        assert np.array_equal(one.x_r, other.x_r)
        assert np.array_equal(one.v_r, other.v_r)
        assert np.array_equal(one.t, other.t)
        return
    law = tuple(scene.law)
    one, other = (
        march_sines(kernel, list(scene.sines), law, scene.end, plant, start)
        for kernel in (plain, fast)
    )
    if one.closest > NEAR and other.closest > NEAR:
        assert one.kind.tolist() == other.kind.tolist()
        assert np.abs(one.t - other.t).max(initial=0.0) <= NEAR * scene.end
        scale = np.abs(one.x).max(initial=abs(one.end[1]))
        assert abs(one.end[1] - other.end[1]) <= NEAR * scale


def draw(plain: SimpleNamespace, fast: SimpleNamespace, examples: int, **chosen: bool) -> None:
    """Try so many scenes."""

    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
        **chosen,
    )
    @given(scenes(radians=500.0))
    def tried(scene: Scene) -> None:
        # A number of numpy says aloud what a float does not: that a quotient has overflowed.
        with np.errstate(over="ignore"):
            twins_agree(plain, fast, scene)

    tried()


@pytest.mark.parametrize("examples", [FAST, pytest.param(MANY, marks=pytest.mark.slow)])
def test_engines_agree_on_drawn_scenes(plain, fast, examples):
    draw(plain, fast, examples, derandomize=examples == FAST)


def test_engines_agree_where_a_limit_underflows_beside_the_load(plain, fast):
    wave = ((1.0, 0.5 / np.pi, 0.0),)
    for F in (5e-324, 2.225073858507e-311, 1e-300):
        scene = Scene(
            1.0, 1.0, 0.0, F, F, 0.0, 0.0, wave, (), 0.0, (0.5, 0.5 / np.pi, 0.0), 170.0
        )
        with np.errstate(over="ignore"):
            twins_agree(plain, fast, scene)
