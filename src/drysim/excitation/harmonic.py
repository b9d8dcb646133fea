"""Base motion that is known in closed form: rest, one sine, sums of sines.

A sine is given by its acceleration, as RMS value or amplitude, and used analytically.
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from drysim.core.model import Sines
from drysim.excitation.base import Member
from drysim.units import Angle, Block, Frequency, Quantity


class Rest(Member):
    """A base that stands still: the free motion from `start`.

    Not to be confused with a mass at rest: it may be let go from anywhere, at any speed.
    """

    kind: Literal["rest"]
    """The base stands still."""

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Give the base acceleration: no sine at all."""
        return Sines((), (), ())


Level = Annotated[float, Quantity("m/s²", at_least=0)]

ROUNDING = 4.0 * 2.0**-52
"""Of a sum of sines, relative to their amplitudes."""


class Component(Block):
    """One sine of the base acceleration: ü = A sin(2πft + phase)."""

    frequency: Frequency
    """Frequency f [Hz], above 0."""
    rms: Level | None = None
    """RMS value a_u of the base acceleration [m/s²]."""
    amplitude: Level | None = None
    """Amplitude A of the base acceleration [m/s²], in place of `rms` and √2 times it."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rms", "amplitude"),)

    @property
    def A(self) -> float:
        """Amplitude of the base acceleration [m/s²]."""
        if self.amplitude is not None:
            return self.amplitude
        assert self.rms is not None, "one of both is given"
        return sqrt(2) * self.rms


class Harmonic(Component, Member):
    """A shaker table that moves as one sine, given by its acceleration.

    Not to be confused with a sine of given displacement: a_u stays when the frequency changes.
    """

    kind: Literal["harmonic"]
    """One sine."""

    also_called: ClassVar[tuple[str, ...]] = ("sin", "sine", "sinus", "sinusoid", "sinusoidal")
    """Those whose slip `sines` would be are among them."""
    periodic: ClassVar[bool] = True
    steady_by_default: ClassVar[bool] = True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """What repeats [Hz]."""
        return (self.frequency,)

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Give the base acceleration, used analytically."""
        return Sines((self.A,), (self.frequency,), (self.phase,))


class SineSum(Member):
    """A base that moves as a sum of sines, each given by its acceleration.

    Not to be confused with a sine sweep, whose frequency changes with time.
    """

    kind: Literal["sines"]
    """A sum of sines."""
    components: Annotated[tuple[Component, ...], Field(min_length=1)]
    """The sines: frequency, rms or amplitude, phase."""

    periodic: ClassVar[bool] = True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """What repeats [Hz], if the sines have a common period."""
        return tuple(sine.frequency for sine in self.components)

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Give the base acceleration, used analytically; sines of one frequency are one."""
        alike: list[list[Component]] = []
        for sine in self.components:
            others = (some for some in alike if same(some[0].frequency, sine.frequency))
            if (some := next(others, None)) is None:
                alike.append([sine])
            else:
                some.append(sine)
        waves = [(one.A, one.phase) if not more else sum_of(one, *more) for one, *more in alike]
        A, phases = zip(*waves, strict=True)
        return Sines(A, tuple(some[0].frequency for some in alike), phases)


def same(one: object, other: object) -> bool:
    """Tell whether two frequencies are one; those of many cases at once are columns."""
    return isinstance(one, float) and one == other


def sum_of(*sines: Component) -> tuple[Any, Any]:
    """Give amplitude [m/s²] and phase [rad] of the sum of sines of one frequency.

    What the rounding of their phases leaves of sines that cancel is nothing: the base stands
    still, and no solution need follow it.
    """
    import numpy as np  # values of many cases at once are columns

    along = sum(sine.A * np.cos(sine.phase) for sine in sines)
    across = sum(sine.A * np.sin(sine.phase) for sine in sines)
    A, noise = np.hypot(along, across), ROUNDING * sum(sine.A for sine in sines)
    return np.where(noise < A, A, 0.0)[()], np.arctan2(across, along)[()]
