"""Scenes drawn by hypothesis from the whole space of legal numbers; how drysim solves them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from drysim.approach.solution import Response, Trajectory
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import CoulombLaw, Plant, Samples, Sines, State

SPECIAL_DAMPING = (0.0, 1e-4, 0.05, 1.0, 1.0 + 1e-8, 1.0 - 1e-8, 1.0 + 2e-16, 50.0)
SPECIAL_FRICTION = (0.0, 1e-300, 1e-12, 0.3, math.pi / 4, 1.0)
"""F_fk over m A."""
SPECIAL_RATIOS = (1.0, 1.0 + 1e-7, 1.2, 5.0)
SPECIAL_TURNS = (2.0, 0.5, 1.0 + 1e-9, 3.0)
"""Frequencies of further sines over that of the first."""


class Scene(NamedTuple):
    """A scene in plain numbers: `sines` of (amplitude, frequency, phase), or samples and dt.

    Both friction limits are times 1 + a sin(2π f t + phase), with these three in `variation`.
    """

    m: float
    k_x: float
    b: float
    F_fk: float
    F_fs: float
    x_r: float = 0.0
    v_r: float = 0.0
    sines: tuple[tuple[float, float, float], ...] = ()
    u_dd: tuple[float, ...] = ()
    dt: float = 0.0
    variation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    duration: float = 0.0

    @property
    def plant(self) -> Plant:
        """The oscillator."""
        return Plant(self.m, self.k_x, self.b)

    @property
    def law(self) -> CoulombLaw:
        """Its friction."""
        swing, f, phase = self.variation
        return CoulombLaw(self.F_fk, self.F_fs, swing, 2.0 * math.pi * f, phase)

    @property
    def motion(self) -> Sines | Samples:
        """The motion of its base."""
        if self.u_dd:
            return Samples(np.array(self.u_dd), self.dt)
        return Sines(*zip(*self.sines, strict=True)) if self.sines else Sines((), (), ())

    @property
    def end(self) -> float:
        """Where a solution ends [s]."""
        return self.dt * (len(self.u_dd) - 1) if self.u_dd else self.duration

    def trajectory(self) -> Trajectory:
        """Solve it with drysim."""
        start = State(self.x_r, self.v_r)
        return StickSlip().trajectory(self.plant, self.law, self.motion, start, self.end)

    def response(self, points: int = 50) -> Response:
        """Solve it with drysim, on a grid."""
        start, step = State(self.x_r, self.v_r), self.dt or self.end / points
        return StickSlip().solve(self.plant, self.law, self.motion, start, step, self.end)


def tens(low: float, high: float) -> st.SearchStrategy[float]:
    """Return powers of ten between two exponents."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def signed(magnitudes: st.SearchStrategy[float]) -> st.SearchStrategy[float]:
    """Return both signs, and zero."""
    return st.one_of(st.just(0.0), magnitudes, magnitudes.map(lambda value: -value))


@st.composite
def scenes(draw: Any, radians: float = 2000.0, varied: bool = True) -> Scene:
    """Draw a scene that lasts at most so many radians of its fastest rate."""
    m, omega_0, A = draw(tens(-6, 9)), draw(tens(-2, 4)), draw(tens(-6, 6))
    xi = draw(st.one_of(st.sampled_from(SPECIAL_DAMPING), st.floats(0, 2), tens(-4, 3)))
    k_x = draw(st.sampled_from((1.0, 1.0, 1.0, 0.0))) * m * omega_0**2
    F_fk = (
        m
        * A
        * draw(st.one_of(st.sampled_from(SPECIAL_FRICTION), st.floats(0, 1.2), tens(-6, 1)))
    )
    F_fs = F_fk * draw(st.one_of(st.sampled_from(SPECIAL_RATIOS), st.floats(1, 3), tens(0, 3)))
    swing = A / omega_0**2
    edge = st.just(F_fs / k_x if k_x else 0.0)
    x_r = draw(signed(st.one_of(edge, tens(-3, 3).map(lambda value: value * swing))))
    v_r = draw(signed(tens(-3, 2))) * swing * omega_0
    variation = (0.0, 0.0, 0.0)
    if varied and draw(st.integers(0, 4)) == 0:
        beat = omega_0 / (2 * math.pi) * draw(tens(-2, 0.5))
        variation = (draw(st.floats(0, 0.99)), beat, draw(st.floats(0, 6)))
    rate = (1.0 + 2.0 * xi) * omega_0 + 2.0 * math.pi * variation[1]
    one = Scene(m, k_x, 2.0 * xi * m * omega_0, F_fk, F_fs, x_r, v_r, variation=variation)
    drawn = under_sines if draw(st.booleans()) else over_samples
    return draw(drawn(one, A, omega_0, rate, radians))


@st.composite
def under_sines(
    draw: Any, one: Scene, A: float, omega_0: float, rate: float, radians: float
) -> Scene:
    """Draw up to three sines, some of them related, and how long they last."""
    f = omega_0 / (2.0 * math.pi) * draw(st.one_of(st.just(1.0), tens(-2, 1)))
    turns = st.one_of(st.sampled_from(SPECIAL_TURNS), tens(-1, 1))
    ratios = [1.0, *draw(st.lists(turns, max_size=2))]
    angles, shares = st.one_of(st.just(0.0), st.floats(-7, 7)), st.floats(0.01, 1)
    sines = tuple((A * draw(shares), f * ratio, draw(angles)) for ratio in ratios)
    rate += 2.0 * math.pi * f * max(ratios)
    return one._replace(sines=sines, duration=radians * draw(st.floats(0.01, 1)) / rate)


@st.composite
def over_samples(
    draw: Any, one: Scene, A: float, omega_0: float, rate: float, radians: float
) -> Scene:
    """Draw samples: quantised or not, with flat tops, at rest for a while."""
    turn = draw(st.one_of(st.sampled_from((5.0, 50.0)), tens(-6, 3)))
    most = max(2, min(40, int(radians / turn)))
    levels = st.one_of(
        st.integers(-4, 4).map(lambda level: 0.5 * level), st.floats(-3, 3), st.just(0.0)
    )
    u_dd = draw(st.lists(levels, min_size=2, max_size=most))
    held = draw(st.sampled_from((1, 1, 4)))
    values = tuple(A * level for level in u_dd for _ in range(held))
    return one._replace(u_dd=values[: max(most, 2)], dt=turn / rate)
