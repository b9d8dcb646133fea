"""Quadratic forms that integrate a whole step of sliding at once."""

from __future__ import annotations

import math

import numpy as np

from drysim.core.flow import flow
from drysim.core.integrals import NODES, PANEL, WEIGHTS


def step_forms(c, w, dt):
    """Give the quadratic forms that integrate a whole step of sliding.

    Parameters
    ----------
    c, w, dt : float
        b/m [1/s], k_x/m [1/s²] and length of the step [s].

    Returns
    -------
    ndarray, shape (4, 5, 5)
        Forms of x_r², v_r², x_dd² and ü v_r in the step's (x_r, v_r, g_0, g_1, f): the state at
        its start, the force per mass at both ends, and its part that is friction, d F_fk/m.
    """
    forms = np.zeros((4, 5, 5))
    panels = max(1, math.ceil(dt * (c + math.sqrt(w)) / PANEL))
    for panel in range(panels):
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            s = dt * (panel + node) / panels
            y, y_d, Y, YY = flow(c, w, s)
            x = np.array([1.0 - w * Y, y, Y - YY / dt, YY / dt, 0.0])
            v = np.array([-w * y, y_d, y - Y / dt, Y / dt, 0.0])
            u_dd = -np.array([0.0, 0.0, 1.0 - s / dt, s / dt, 1.0])
            x_dd = -(w * x + c * v) - np.array([0.0, 0.0, 0.0, 0.0, 1.0])
            for form, one, other in zip(
                forms, (x, v, x_dd, u_dd), (x, v, x_dd, v), strict=True
            ):
                form += weight * dt / panels * np.outer(one, other)
    return forms
