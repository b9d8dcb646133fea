"""Accelerations as means over every step of a response: what spectra and weightings sample."""

from __future__ import annotations

import numpy as np

from drysim.approach.events import Floats
from drysim.approach.response import Response
from drysim.core.motion import Samples, Sines, base_acceleration

ON_GRID = 1e-6
"""A time this close to a grid point, in steps, is on it."""


def step_means(response: Response) -> tuple[Floats, Floats]:
    """Give the mean accelerations of base and mass over every step.

    Parameters
    ----------
    response : Response
        On a grid of n points.

    Returns
    -------
    u_dd, x_dd : ndarray, shape (n - 1,)
        Means over the steps [m/s²].

    Notes
    -----
    ẍ = ü + dv_r/dt, so the mean over a step follows exactly from v_r at its ends, wherever in
    it ẍ jumps. A point sample would miss up to half a step of each jump by 2 F_fk/m; what
    remains here is aliasing, which a mean over the step keeps small. A mean has the gain
    sin(π f dt)/(π f dt), which `faded` gives so that it can be taken back.
    """
    dt, motion = response.dt, response.motion
    if isinstance(motion, Samples):
        u_dd = 0.5 * (response.u_dd[:-1] + response.u_dd[1:])
    else:
        A = tuple(A * float(np.sinc(f * dt)) for A, f in zip(motion.A, motion.f, strict=True))
        middles = (np.arange(len(response) - 1, dtype=np.float64) + 0.5) * dt
        u_dd = base_acceleration(Sines(A, motion.f, motion.phase), middles)
    return u_dd, u_dd + np.diff(response.v_r) / dt


def faded(f: Floats, dt: float) -> Floats:
    """Give the gain of a mean over a step [s] at frequencies [Hz]: sin(π f dt)/(π f dt)."""
    return np.asarray(np.sinc(f * dt), dtype=np.float64)


def steps_within(response: Response, window: tuple[float, float]) -> slice:
    """Give the steps that lie in a window [s] as a whole."""
    first = int(np.ceil(window[0] / response.dt - ON_GRID))
    last = int(np.floor(window[1] / response.dt + ON_GRID))
    return slice(first, max(first, min(last, len(response) - 1)))
