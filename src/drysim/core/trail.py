"""The trail of a motion: where each of its pieces begins."""

from __future__ import annotations

from typing import Any, NamedTuple

from drysim.core.compiled import inlined

ENOUGH = 3
"""Events and steps that one step may add to their logs, and one to spare."""


class Trail(NamedTuple):
    """Where each piece begins: parallel arrays (or lists) of one length.

    Attributes
    ----------
    n : array of int
        Sample at or before the beginning; 0 under sines.
    s : array of float
        Time since that sample [s].
    x_r, v_r, z : array of float
        The state there [m, m/s, m].
    d : array of int
        Direction of motion, 0 where stuck or at rest on bristles; 2 and -2 where the mass
        breaks away just then, or leaves its equilibrium on bristles; 3
        and -3 where it is too slow for friction to have fallen. Under bristles, above 2: how
        many rounds a series on settled ones took, as in `settle`.
    terms : array of int
        Last term of its series; else not written.
    rise, bend : array of float
        Slope of the branch that bristles with a memory are on, as in `Jet`; else not written.
    """

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    z: Any
    d: Any
    terms: Any
    rise: Any
    bend: Any


class Pieces(NamedTuple):
    """The trail of a motion that is solved in closed form: no series belongs to its pieces.

    Attributes
    ----------
    n, s, x_r, v_r, z, d
        As in `Trail`.
    """

    n: Any
    s: Any
    x_r: Any
    v_r: Any
    z: Any
    d: Any


@inlined
def mark(trail, at, n, s, x_r, v_r, z, d):
    """Write where a piece begins; gives the new number of pieces."""
    trail.n[at] = n
    trail.s[at] = s
    trail.x_r[at] = x_r
    trail.v_r[at] = v_r
    trail.z[at] = z
    trail.d[at] = d
    return at + 1
