"""Sensitivities of an exact response to the numbers of its scene, in closed form.

`linearise` returns the derivatives of the motion at every grid point in given directions of the
plant, the friction law, the end stops and the start. They belong to the modes and events of
the response itself: where a mode changes within a neighbourhood, the motion there does not
follow them. `core.variational` has the method.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from drysim.approach.base_motion import make_waves
from drysim.approach.piecewise import to_kernel
from drysim.approach.solution import Response
from drysim.core.compile import as_engine_array
from drysim.core.events import Segments
from drysim.core.forcing import Scene
from drysim.core.model import AnyLaw, AnyState, DynamicLaw, Floats, Plant, Samples
from drysim.core.trajectory import Solution
from drysim.core.variational import (
    Deviations,
    MotionResponse,
    Sensitivities,
    Sources,
    Workspace,
    propagate_sensitivities,
    scene_numbers,
)


def numbers_of(plant: Plant, law: AnyLaw, start: AnyState, count: int) -> Floats:
    """Return the numbers of scenes in closed form, shape (NUMBERS, count).

    Those of `plant`, `law` and `start` may be arrays of shape (count,).
    """
    assert not isinstance(law, DynamicLaw), "dynamic laws have no closed form"
    x_r, v_r = start[:2]
    numbers = scene_numbers(plant, to_kernel(plant, law.as_piecewise()), x_r, v_r)
    return np.array([np.broadcast_to(number, count) for number in numbers])


def linearise(response: Response, rates: Floats) -> Sensitivities:
    """Return the derivatives of a response at its grid points.

    Parameters
    ----------
    response : Response
        Of a law in closed form, kept in memory as a whole.
    rates : ndarray, shape (NUMBERS, n)
        Derivatives of `numbers_of` its scene, one column per direction.

    Returns
    -------
    Sensitivities
        Arrays of shape (n, points).
    """
    points, n = len(response), rates.shape[1]
    out = Sensitivities(*(as_engine_array(np.empty((n, points))) for _ in range(4)))
    deviations = Deviations(*(as_engine_array(np.zeros(n)) for _ in range(3)))
    sources = Sources(*(as_engine_array(np.zeros(n)) for _ in range(5)))
    responses = MotionResponse(*(as_engine_array(np.empty(points)) for _ in range(4)))
    motion = as_engine_array(response.x_r), as_engine_array(response.v_r)
    solution, work = solution_on_grid(response), Workspace(deviations, sources, responses)
    propagate_sensitivities(solution, motion, as_engine_array(rates), work, out)
    return Sensitivities(*map(np.asarray, out))


def solution_on_grid(response: Response) -> Solution:
    """Return the segments of a response, with times that count from its grid points."""
    trajectory: Any = response.trajectory
    plant, law, motion = trajectory.plant, trajectory.law, response.motion
    dt, last = response.dt, len(response) - 1
    solved, _, rows = trajectory.march.block(0).solution
    n, s, x_r, v_r, x_0, d = map(np.asarray, rows)
    t = n * solved.dt + s
    inside = t < last * dt
    inside[0] = True
    t = t[inside]
    n = np.minimum((t / dt).astype(np.int64), last - 1)
    s = np.maximum(t - n * dt, 0.0)
    columns = (as_engine_array(column[inside]) for column in (x_r, v_r, x_0, d))
    u_dd = motion.u_dd[: last + 1] if isinstance(motion, Samples) else np.zeros(last + 1)
    kernel_law = to_kernel(plant, law.as_piecewise())
    scene = Scene(plant, kernel_law, make_waves(motion, law), as_engine_array(u_dd), dt)
    segments = Segments(as_engine_array(n), as_engine_array(s), *columns)
    return Solution(scene, segments)
