"""Response: what every approach gives. Plain values; knows no file and no metric."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drysim.approach.events import Codes, Events, Floats
from drysim.approach.numerics import Numerics
from drysim.approach.points import Grid, Points
from drysim.approach.track import Track
from drysim.core.motion import Samples, Sines
from drysim.core.plant import AnyLaw, Law, Plant, Stopped
from drysim.core.signal import BLOCK, KEPT

WHOLE = (0, -1)
"""Stands for all points among the parts of a response that are kept; no part ends there."""


@dataclass(frozen=True, eq=False)
class Response:
    """Relative motion on an equidistant grid, with the events between its points.

    A long one that is not asked for as a whole never is one: `parts` cuts its grid into blocks,
    `base`, `points`, `acceleration` and `friction` give what belongs to each. What is not asked
    for is not computed.

    Attributes
    ----------
    plant, law, motion
        The scene.
    grid : Grid
        Where its points come from.
    events : Events
    how : callable
        Gives how the numbers were made.
    track : Track or None
        The solution between the grid points; None where only the motion was asked for.
    """

    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    grid: Grid
    events: Events
    how: Callable[[], Numerics]
    track: Track | None = None
    _kept: dict[tuple[int, int], Points] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        """Give the number of grid points."""
        return len(self.grid)

    def __repr__(self) -> str:
        """Give how much there is of it, in a line."""
        grid = f"{len(self)} points at {self.dt:.6g} s"
        return f"<Response: {grid}, {len(self.events)} events>"

    @property
    def dt(self) -> float:
        """Distance of the grid points [s]."""
        return self.grid.dt

    @cached_property
    def numerics(self) -> Numerics:
        """How the numbers were made."""
        return self.how()

    @property
    def whole(self) -> Points:
        """All points."""
        # Kept as a part is: a cached property would lock, some hundredths of a short run.
        if WHOLE not in self._kept:
            self._kept[WHOLE] = self.grid.part(0, len(self.grid))
        return self._kept[WHOLE]

    @cached_property
    def u_dd(self) -> Floats:
        """Base acceleration [m/s²], shape (n,)."""
        return self.grid.base(0, len(self))

    @property
    def x_r(self) -> Floats:
        """Relative displacement [m], shape (n,)."""
        return self.whole.x_r

    @property
    def v_r(self) -> Floats:
        """Relative velocity [m/s], shape (n,)."""
        return self.whole.v_r

    @property
    def d(self) -> Codes:
        """Direction of sliding, shape (n,): -1, +1, or 0 where stuck."""
        return self.whole.d

    @cached_property
    def t(self) -> Floats:
        """Time of the grid points [s], shape (n,)."""
        t: Floats = np.arange(len(self), dtype=np.float64) * self.dt
        return t

    @cached_property
    def stuck(self) -> NDArray[np.bool_]:
        """Whether the mass sticks to the base, shape (n,)."""
        stuck: NDArray[np.bool_] = self.d == 0
        return stuck

    @cached_property
    def F_f(self) -> Floats:
        """Friction force as it acts on the mass [N], shape (n,); balances F_L while stuck."""
        return self.friction(slice(None))

    @cached_property
    def F_stop(self) -> Floats:
        """Force of an end stop, counted like F_f [N], shape (n,); an impact has none."""
        return self.stop(slice(None))

    @cached_property
    def x_dd(self) -> Floats:
        """Absolute acceleration of the mass [m/s²], shape (n,); equals ü while stuck."""
        return self.acceleration(slice(None))

    def parts(self) -> Iterator[slice]:
        """Cut the grid into blocks, in the order of time."""
        return (slice(at, min(at + BLOCK, len(self))) for at in range(0, len(self), BLOCK))

    def base(self, part: slice) -> Floats:
        """Give ü [m/s²] on a part of the grid."""
        if len(self) <= KEPT or "u_dd" in vars(self):
            return self.u_dd[part]
        first, last, _ = part.indices(len(self))
        return self.grid.base(first, last)

    def points(self, part: slice) -> Points:
        """Give a part of the grid, so that long responses need not be held whole."""
        if len(self) <= KEPT or WHOLE in self._kept:
            return self.whole.cut(part)
        first, last, _ = part.indices(len(self))
        if (first, last) not in self._kept:
            self._kept.clear()
            self._kept[first, last] = self.grid.part(first, last)
        return self._kept[first, last]

    def friction(self, part: slice) -> Floats:
        """Give F_f [N] on a part of the grid."""
        x_r, _, d, force, _ = self.points(part)
        if force is not None:
            return force
        kinetic = d * self.law.F_fk
        if isinstance(self.law, Law | Stopped) and self.law.variation:
            t = np.arange(*part.indices(len(self))) * self.dt
            kinetic = kinetic * (
                1 + self.law.variation * np.sin(self.law.omega * t + self.law.phase)
            )
        F_L = self.plant.m * self.base(part) + self.plant.k_x * x_r
        return np.where(d == 0, -F_L, kinetic)

    def acceleration(self, part: slice) -> Floats:
        """Give x_dd [m/s²] on a part of the grid."""
        m, k_x, b = self.plant
        x_r, v_r, d, force, stop = self.points(part)
        pull = k_x * x_r + b * v_r + self.friction(part)
        if stop is not None:
            pull += stop
        sticks = force is None or stop is not None
        return np.where(d == 0 if sticks else False, self.base(part), -pull / m)

    def stop(self, part: slice) -> Floats:
        """Give F_stop [N] on a part of the grid; 0 where there is no end stop."""
        x_r, *_, stop = self.points(part)
        return np.zeros_like(x_r) if stop is None else stop
