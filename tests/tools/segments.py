"""Drawn motions over samples, and all segments of them, for independent sums over them."""

from __future__ import annotations

from math import pi

import numpy as np

from drysim.approach.buffers import empty_columns
from drysim.approach.stick_slip import StickSlip
from drysim.core.compile import as_engine_array
from drysim.core.events import Segments
from drysim.core.model import (
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    Samples,
    State,
    StrokeLimits,
)
from drysim.core.sampled import SampledMotion
from drysim.core.trajectory import SampledSolution, Solution, fill_segments


def every_segment(solution: SampledSolution) -> Solution:
    """Return all segments of a solution, one or more for each step."""
    scene, samples, rows = solution
    count = len(scene.u_dd) - 1
    segments = empty_columns(Segments, count + len(rows.n) + 1)
    rows = Segments(*map(as_engine_array, rows))
    samples = SampledMotion(*map(as_engine_array, samples))
    used = fill_segments(rows, samples, 0, (0, count), segments)
    return Solution(scene, Segments(*(column[:used] for column in segments)))


STOPS = StrokeLimits(0.02, 0.03)


def drawn_law(rng: np.random.Generator) -> CoulombLaw | PiecewiseLaw:
    """Draw a law of one of the kinds that are solved in closed form."""
    F = 5.0 * rng.choice([0.0, 0.1, 0.5, 1.0])
    coulomb = CoulombLaw(F, F * rng.choice([1.0, 1.3]))
    rigid = coulomb.as_piecewise()
    soft, e = ((0.0, 4e3), (0.005, 1e4)), rng.uniform(0.0, 0.9)
    k_t = 10 ** rng.uniform(2.0, 4.5)
    kinds = (
        coulomb,
        rigid._replace(damping=(30.0, 10.0)),
        rigid._replace(compression=(0.5 * F, 0.6 * F)),
        rigid._replace(stops=EndStops(STOPS, soft, 20.0)),
        rigid._replace(stops=EndStops(STOPS, (), 0.0, e)),
        PiecewiseLaw(F + 1.0, F + 1.0, k_t),
        PiecewiseLaw(F + 1.0, F + 1.0, k_t)._replace(stops=EndStops(STOPS, soft, 20.0)),
    )
    return kinds[rng.integers(len(kinds))]


def drawn_trajectory(rng: np.random.Generator, samples: int):
    """Draw a scene, steps of up to two radians and silent bases included, and solve it."""
    f_0, xi = 10 ** rng.uniform(-0.5, 1.0), rng.choice([0.0, 0.02, 0.3, 2.0])
    plant = Plant(5.0, 5.0 * (2 * pi * f_0) ** 2, 2.0 * xi * 5.0 * 2 * pi * f_0)
    dt = 10 ** rng.uniform(-2.0, 0.3) / (2 * pi * f_0)
    u_dd = np.convolve(rng.standard_normal(samples), np.ones(rng.integers(1, 9)) / 2.0, "same")
    u_dd[rng.integers(samples) :] *= rng.choice([0.0, 1.0])
    start = State(0.01, rng.choice([0.0, 0.1]))
    law, motion = drawn_law(rng), Samples(u_dd, dt)
    return StickSlip().trajectory(plant, law, motion, start)


def sampled_solution(trajectory) -> SampledSolution:
    """Return a trajectory in one block as kernels take it."""
    return trajectory.march.block(0).solution


def as_arrays(values):
    """Return a solution as both engines take it: with arrays where the plain one has lists."""
    if hasattr(values, "_make"):
        return values._make(map(as_arrays, values))
    return np.array(values, dtype=float) if isinstance(values, list) else values
