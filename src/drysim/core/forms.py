"""Forms that integrate a whole step of sliding at once."""

from __future__ import annotations

import numpy as np

from drysim.core.flow import flow
from drysim.core.gauss import TWELVE_NODES, TWELVE_WEIGHTS
from drysim.core.integrals import PANEL, own_rate

PAIRS = (
    (0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3), (1, 4),
    (1, 5), (3, 4), (3, 5), (4, 4), (4, 5), (5, 5), (2, 4),
)  # fmt: skip
"""Two of the `step_rows` of every product that a form asks for."""


def step_rows(c, w, f, x_r, v_r, u_0, u_1):
    """Give what a step of sliding is made of, such that no integral is a small difference.

    Parameters
    ----------
    c, w : float
        b/m [1/s] and k_x/m [1/s²].
    f : array, shape (steps,)
        Friction force per mass, d F_fk/m [m/s²].
    x_r, v_r, u_0, u_1 : array, shape (steps,)
        State at the start of the steps [m, m/s], and ü at both ends [m/s²].

    Returns
    -------
    ndarray, shape (6, steps)
        x_r; v_r; the force per mass at the start that all but the damper exert, the change of
        ü, and ü at the start; and x_dd at the start. The third and the last have their sign
        changed.

    Notes
    -----
    Spring and friction may all but balance, so that x_dd and the way are far smaller than
    either: they are formed once, here, and integrated as such.
    """
    rows = np.empty((6, len(x_r)))
    rows[0] = x_r
    rows[1] = v_r
    contact = w * x_r
    contact += f
    np.add(u_0, contact, out=rows[2])
    np.subtract(u_1, u_0, out=rows[3])
    rows[4] = u_0
    np.multiply(v_r, c, out=rows[5])
    rows[5] += contact
    return rows


def step_forms(c, w, dt):
    """Give the forms that integrate a whole step of sliding, in its `step_rows`.

    Parameters
    ----------
    c, w, dt : float
        b/m [1/s], k_x/m [1/s²] and length of the step [s].

    Returns
    -------
    squares : ndarray, shape (4, 6, 6)
        Quadratic forms of x_r², v_r², x_dd² and ü v_r.
    way : ndarray, shape (6,)
        Linear form of v_r: the distance slid.
    """
    squares = np.zeros((4, 6, 6))
    begin = 0.0
    while begin < dt:
        rate = own_rate(c, w, begin)
        length = min(PANEL / rate, dt - begin) if rate > 0.0 else dt - begin
        for node, weight in zip(TWELVE_NODES, TWELVE_WEIGHTS, strict=True):
            s = begin + length * node
            y, y_d, Y, YY = flow(c, w, s)
            x = np.array([1.0, y, -Y, -YY / dt, 0.0, 0.0])
            v = np.array([0.0, y_d, -y, -Y / dt, 0.0, 0.0])
            u_dd = np.array([0.0, 0.0, 0.0, s / dt, 1.0, 0.0])
            x_dd = np.array([0.0, -w * y, 0.0, (c * Y + w * YY) / dt, c * y + w * Y, -y_d])
            for square, one, other in zip(
                squares, (x, v, x_dd, u_dd), (x, v, x_dd, v), strict=True
            ):
                square += weight * length * np.outer(one, other)
        begin = begin + length if length < dt - begin else dt
    y, _, Y, YY = flow(c, w, dt)
    return squares, np.array([0.0, y, -Y, -YY / dt, 0.0, 0.0])


def integrals(forms, products, way):
    """Give the integrals over steps of sliding from sums over these steps.

    Parameters
    ----------
    forms : tuple
        As `step_forms` gives them.
    products : sequence of float, or of arrays of one shape
        Sums of the products of two `step_rows`, in the order of `PAIRS`.
    way : sequence likewise
        Sums of rows 1 to 3 times the direction of sliding.

    Returns
    -------
    ndarray, shape (6,) or (6, n)
        x2, v2, x_dd2, power, rub and a last row of zeros, as in `Totals`.

    Notes
    -----
    Term by term: what a column comes to does not depend on the others.
    """
    squares, distance = forms
    sums = np.zeros((6, *np.shape(way[0])))
    for (i, j), product in zip(PAIRS, products, strict=True):
        terms = squares[:, i, j] + (squares[:, j, i] if i != j else 0.0)
        for k in np.flatnonzero(terms):
            sums[k] += terms[k] * product
    sums[:3] = np.maximum(sums[:3], 0.0)  # squares, whatever rounding says
    for i, part in enumerate(way, 1):
        sums[4] += distance[i] * part
    return sums
