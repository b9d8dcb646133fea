"""Points: a response on its grid, held or made part by part. Plain values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from drysim.approach.events import Codes, Floats


class Points(NamedTuple):
    """Neighbouring points of a grid, each array of shape (n,).

    Attributes
    ----------
    x_r, v_r : ndarray
        Relative displacement [m] and velocity [m/s].
    d : ndarray of int8
        Direction of sliding: -1, +1, or 0 where stuck.
    force : ndarray or None
        Friction force as the approach had it [N]; None where the mode and the law give it.
    stop : ndarray or None
        Force of an end stop, counted like friction [N]; None where none is met.
    """

    x_r: Floats
    v_r: Floats
    d: Codes
    force: Floats | None = None
    stop: Floats | None = None

    def cut(self, part: slice) -> Points:
        """Give some of the points."""
        x_r, v_r, d, force, stop = self
        bare = Points(x_r[part], v_r[part], d[part])
        if stop is not None:
            bare = bare._replace(stop=stop[part])
        return bare if force is None else bare._replace(force=force[part])


class Grid(Protocol):
    """Where the points of a response come from."""

    @property
    def dt(self) -> float:
        """Distance of the points [s]."""

    def __len__(self) -> int:
        """Give their number."""

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""


@dataclass(frozen=True, eq=False)
class Held:
    """Points that are there with the base's acceleration [m/s²], `dt` seconds apart."""

    dt: float
    u_dd: Floats
    points: Points

    def __len__(self) -> int:
        """Give their number."""
        return len(self.points.x_r)

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return self.u_dd[first:last]

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        return self.points.cut(slice(first, last))


@dataclass(frozen=True, eq=False)
class Sliding:
    """The points of another grid, none of them stuck."""

    grid: Grid

    @property
    def dt(self) -> float:
        """Distance of the points [s]."""
        return self.grid.dt

    def __len__(self) -> int:
        """Give their number."""
        return len(self.grid)

    def base(self, first: int, last: int) -> Floats:
        """Give ü [m/s²] from point number `first` to the one before `last`."""
        return self.grid.base(first, last)

    def part(self, first: int, last: int) -> Points:
        """Give the points from number `first` to the one before `last`."""
        points = self.grid.part(first, last)
        return points._replace(d=points.d * 0 + 1)
