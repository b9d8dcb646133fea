"""Laws that are a spring in series with a slider, piecewise linear: Jenkins, Petrov-Ewins."""

from __future__ import annotations

from math import pi
from typing import Annotated, Any, ClassVar, Literal

from drysim.core.model import Slider
from drysim.friction.base import Rubbing
from drysim.units import Angle, Block, Frequency, Quantity


class Jenkins(Rubbing):
    """A contact that is a linear spring until it yields, as joints and bushings are.

    Not to be confused with `dahl`, whose spring softens all the way.

    Notes
    -----
    While it holds f = f_0 + k_t (x_r - x_0), it yields at |f| = F_fk, and holds again as v_r
    turns; piecewise linear, so solved in closed form. Known as Jenkins' element and as the
    elastic slider. Jenkins, Brit. J. Appl. Phys. 13 (1962) 30.
    """

    law: Literal["jenkins"]
    """Dry friction behind a spring."""
    tangential_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness k_t [N/m], above 0, of the contact while it holds."""

    symbols: ClassVar[dict[str, str]] = {"tangential_stiffness": "k_t"}

    def limits(self, m: float) -> Slider:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        return Slider(self.kinetic_force(m), self.tangential_stiffness)


class NormalMotion(Block):
    """How the surfaces approach each other: amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("m", at_least=0)]
    """Amplitude [m] of the approach."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class PetrovEwins(Block):
    """A contact with a spring along and one across the surfaces, which may part and meet again.

    Not to be confused with `jenkins`, whose normal load is constant.

    Notes
    -----
    F_N = normal + k_n y(t); while it holds f = f_0 + k_t (x_r - x_0), it yields at
    |f| = mu F_N, and where F_N <= 0 there is no force. Piecewise linear, so solved in closed
    form. Petrov and Ewins, J. Turbomach. 125 (2003) 364.
    """

    law: Literal["petrov-ewins"]
    """Dry friction behind a spring, under a normal load that varies."""
    mu_kinetic: Annotated[float, Quantity("", above=0)]
    """Coefficient of friction [-], above 0."""
    normal: Annotated[float, Quantity("N", above=0)]
    """Mean normal load [N], above 0."""
    tangential_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness k_t [N/m], above 0, along the surfaces."""
    normal_stiffness: Annotated[float, Quantity("N/m", above=0)] | None = None
    """Stiffness k_n [N/m], above 0, across the surfaces; without it the load is constant."""
    normal_motion: NormalMotion | None = None
    """Approach of the surfaces; needs a normal stiffness."""

    symbols: ClassVar[dict[str, str]] = {
        "tangential_stiffness": "k_t",
        "normal_stiffness": "k_n",
    }
    needs: ClassVar[dict[str, str]] = {
        "normal_stiffness": "normal_motion",
        "normal_motion": "normal_stiffness",
    }

    @property
    def static_given(self) -> bool:
        """Give True: one limit serves both."""
        return True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """The frequency of the normal load, where it varies [Hz]."""
        moved = self.normal_motion
        return (moved.frequency,) if moved and moved.amplitude else ()

    def limits(self, m: float) -> Slider:
        """Give the law in forces; the mass [kg] plays no part."""
        F_fk = self.mu_kinetic * self.normal
        moved = self.normal_motion
        if moved is None or self.normal_stiffness is None:
            return Slider(F_fk, self.tangential_stiffness)
        variation = self.normal_stiffness * moved.amplitude / self.normal
        omega = 2 * pi * moved.frequency
        return Slider(F_fk, self.tangential_stiffness, variation, omega, moved.phase)

    def spelled_out(self, m: float) -> dict[str, Any]:
        """Give the words of the block with every default in them."""
        return self.model_dump(exclude_none=True)
