"""Coulomb's friction under a normal force that lifts off or was recorded, as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.compiled import held
from drysim.core.motion import Input
from drysim.errors import Caution


@dataclass(frozen=True, eq=False)
class Pressure:
    """A recorded normal force, linear between its samples; equal to itself alone.

    Attributes
    ----------
    relative : ndarray, shape (n,)
        The force relative to its mean [-]; the first sample is t = 0.
    step : float
        Distance of the samples [s].
    mean : float
        Mean of the samples [N], above 0.
    inputs : tuple of Input
        The file behind it.
    cautions : tuple of Caution
        What a reader of the numbers should know about it.
    clean_up : tuple of mapping
        What was done to it on request, step by step.
    """

    relative: NDArray[np.float64]
    step: float
    mean: float
    inputs: tuple[Input, ...] = ()
    cautions: tuple[Caution, ...] = ()
    clean_up: tuple[Mapping[str, object], ...] = ()

    @cached_property
    def given(self) -> Any:
        """The force as the kernels want it."""
        return held(self.relative)

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return (len(self.relative) - 1) * self.step


class Pressed(NamedTuple):
    """Coulomb's dry friction under a normal force that may vanish or be any recorded one.

    The limits at time t are `F_fk` and `F_fs` times the normal force relative to its mean:
    1 + variation·sin(omega·t + phase), or what `pressure` says. Where that is not above zero
    the surfaces have parted and there is no friction. Not to be confused with `Law`, whose
    surfaces never part.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force and static limit under the mean normal force [N].
    variation : float
        Relative amplitude of the normal force [-], at least 0.
    omega, phase : float
        Angular frequency of the variation [rad/s] and its phase at t = 0 [rad].
    pressure : Pressure or None
        The recorded normal force, in place of a variation.
    """

    F_fk: float
    F_fs: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0
    pressure: Pressure | None = None

    @property
    def sticks(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True

    def load(self, t: Any) -> Any:
        """Give the normal force relative to its mean [-] at times t [s], 0 where parted."""
        if self.pressure is None:
            found = 1.0 + self.variation * np.sin(self.omega * t + self.phase)
        else:
            times = np.arange(len(self.pressure.relative)) * self.pressure.step
            found = np.interp(t, times, self.pressure.relative)
        return np.maximum(found, 0.0)
