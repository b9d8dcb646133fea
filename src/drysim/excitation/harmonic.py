"""Deterministic base motion: rest, sines, sine sweeps and shock pulses.

Sines are given by the RMS value or amplitude of their acceleration and used analytically.
Transient motion (sine sweeps, shocks) is sampled on the grid of solver.step.
"""

from collections.abc import Collection, Iterator
from math import ceil, log, pi, sqrt
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from drysim.block import Block, InvalidValue
from drysim.core.model import Floats, Samples, Sines, principal_angle
from drysim.errors import WarningMessage
from drysim.excitation.base import (
    STEP_TOLERANCE,
    Duration,
    ExcitationBase,
    FiniteMotion,
    GeneratedMotion,
    PeriodicMotion,
)
from drysim.excitation.random import coarse_step_warnings
from drysim.quantity import Acceleration, Angle, Frequency, Quantity
from drysim.wording import format_number, format_range


class Rest(ExcitationBase):
    """A base at rest: free vibration from `start`.

    Not to be confused with a mass at rest: `start` sets its displacement and velocity.
    """

    kind: Literal["rest"]
    """The base is at rest."""

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Return the base acceleration: an empty sum of sines."""
        return Sines((), (), ())

    def _describe_motion(self, motion: Any, level: bool) -> str:
        return ", the base stands still"


RmsOrAmplitude = Annotated[float, Quantity("m/s²", at_least=0)]

CANCELLATION_TOLERANCE = 4.0 * 2.0**-52
"""Amplitude of a sum below which it is rounding, relative to the sum of amplitudes."""


class Component(Block):
    """One sine of the base acceleration: ü = A sin(2πft + phase)."""

    frequency: Frequency
    """Frequency f [Hz], above 0."""
    rms: RmsOrAmplitude | None = None
    """RMS value a_u of the base acceleration [m/s²]."""
    amplitude: RmsOrAmplitude | None = None
    """Amplitude A of the base acceleration [m/s²], √2 times `rms`; an alternative to it."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rms", "amplitude"),)

    @property
    def A(self) -> float:
        """Amplitude of the base acceleration [m/s²]."""
        if self.amplitude is not None:
            return self.amplitude
        assert self.rms is not None, "one of the two is given"
        return sqrt(2) * self.rms


class Harmonic(Component, PeriodicMotion):
    """Base motion that is a single sine, as on a shaker, given by its acceleration.

    Not to be confused with a sine of given displacement: a_u does not depend on the frequency.
    """

    kind: Literal["harmonic"]
    """A single sine."""

    also_called: ClassVar[tuple[str, ...]] = ("sin", "sine", "sinus", "sinusoid", "sinusoidal")
    """Includes words that `closest_match` would take for `sines`."""
    steady_by_default: ClassVar[bool] = True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """The frequency [Hz]."""
        return (self.frequency,)

    @property
    def phases(self) -> tuple[float, ...]:
        """The phase [rad]."""
        return (self.phase,)

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Return the base acceleration."""
        return Sines((self.A,), (self.frequency,), (principal_angle(self.phase),))


class SineSum(PeriodicMotion):
    """Base motion that is a sum of sines, each given by its acceleration.

    Not to be confused with a sine sweep, whose frequency changes with time.
    """

    kind: Literal["sines"]
    """A sum of sines."""
    components: Annotated[tuple[Component, ...], Field(min_length=1)]
    """The sines: frequency, rms or amplitude, phase."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies of the components [Hz]."""
        return tuple(sine.frequency for sine in self.components)

    @property
    def phases(self) -> tuple[float, ...]:
        """Phases of the components [rad]."""
        return tuple(sine.phase for sine in self.components)

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Return the base acceleration; components of equal frequency are added."""
        alike: dict[object, list[Component]] = {}
        for number, sine in enumerate(self.components):
            f = sine.frequency  # a column of many cases stays a sine of its own
            alike.setdefault(f if isinstance(f, float) else (number,), []).append(sine)
        waves = [
            (first.A, principal_angle(first.phase)) if not more else sum_sines(first, *more)
            for first, *more in alike.values()
        ]
        A, phases = zip(*waves, strict=True)
        return Sines(A, tuple(first.frequency for first, *_ in alike.values()), phases)


def sum_sines(*sines: Component) -> tuple[Any, Any]:
    """Return the amplitude [m/s²] and phase [rad] of a sum of sines of one frequency.

    The amplitude is 0 where the sines cancel up to rounding, so that the base is exactly at
    rest. Values may be columns of many cases.
    """
    along = sum(sine.A * np.cos(sine.phase) for sine in sines)
    across = sum(sine.A * np.sin(sine.phase) for sine in sines)
    A, noise = np.hypot(along, across), CANCELLATION_TOLERANCE * sum(sine.A for sine in sines)
    return np.where(noise < A, A, 0.0)[()], np.arctan2(across, along)[()]


# Transient motion: sine sweep and shock pulses
#
# Both are sampled on the grid of solver.step; a warning reports the error of linear
# interpolation between the samples.


class Chirp(FiniteMotion):
    """Sine sweep on a shaker: constant acceleration amplitude, varying frequency.

    Not to be confused with the `sweep` block, which runs a scenario once per value: this is a
    single run through all frequencies, and the response at each is not stationary.
    """

    kind: Literal["sweep"]
    """A sine sweep."""
    also_called: ClassVar[tuple[str, ...]] = ("chirp", "sine sweep", "swept sine")
    first: Annotated[Frequency, Field(alias="from")]
    """Start frequency [Hz]."""
    last: Annotated[Frequency, Field(alias="to")]
    """End frequency [Hz], above or below `from`."""
    scale: Literal["linear", "log"] = "linear"
    """Whether the frequency changes linearly (`linear`) or exponentially (`log`) in time."""
    rms: RmsOrAmplitude | None = None
    """RMS value of the sine [m/s²]."""
    amplitude: RmsOrAmplitude | None = None
    """Amplitude of the sine [m/s²], √2 times `rms`; an alternative to it."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("rms", "amplitude"),)

    @property
    def A(self) -> float:
        """Amplitude of the base acceleration [m/s²]."""
        return sqrt(2) * (self.rms or 0.0) if self.amplitude is None else self.amplitude

    @property
    def highest_frequency(self) -> float:
        """Highest frequency [Hz]."""
        return max(self.first, self.last)

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return the frequency range and the scale."""
        band = f"{format_range(self.first, self.last, 'Hz')}, "
        return ("" if {"from", "to"} & {*varied} else band) + self.scale

    def cycles(self, share: Floats) -> Floats:
        """Return the phase in cycles.

        Parameters
        ----------
        share : array
            Time over duration [-].

        Notes
        -----
        Closed-form integral of the frequency: with r = f1/f0 and s = t/T it is f0 T s + (f1 -
        f0) T s²/2 for a linear and f0 T (r^s - 1)/ln r for a logarithmic sweep.
        """
        T, f_0, f_1 = self.duration, self.first, self.last
        octaves = log(f_1 / f_0)
        if self.scale == "linear" or octaves == 0.0:
            return share * (f_0 * T + 0.5 * (f_1 - f_0) * T * share)
        return np.asarray(f_0 * T / octaves * np.expm1(octaves * share))

    def sample(self, step: float) -> Samples:
        """Return the samples of the sweep; it begins at phase 0 and its phase is exact."""
        n = round(self.duration / step)
        cycles = self.cycles(np.arange(n + 1) / n)
        u_dd = self.A * np.sin(2 * pi * (cycles % 1.0))
        left, right = u_dd[:-1], u_dd[1:]
        square = float((left @ left + left @ right + right @ right) / (3 * n))
        realised = {
            "rms_asked": self.A / sqrt(2),
            "rms": sqrt(square),
            "cycles": float(cycles[-1]),
        }
        # Linear interpolation reduces the amplitude of a sine by the factor sinc²(f step).
        kept = float(np.sinc(self.highest_frequency * step) ** 2)
        warnings = tuple(
            coarse_step_warnings(kept, step, f"the amplitude at {self.highest_frequency:g} Hz")
        )
        return Samples(u_dd, step, None, (), warnings, realised)


# Shock pulses


PULSE_SHAPES = ("half-sine", "haversine", "sawtooth", "trapezoid")

CHORD_ERROR = {"half-sine": pi**2 / 8, "haversine": pi**2 / 4}
"""Largest deviation of linear interpolation from a pulse sampled at N intervals, relative to
the amplitude and times N²."""

MAX_GRID_ERROR = 0.01
"""Relative error of amplitude or velocity change above which the grid is warned about [-]."""


def _strip_terminal_peak(value: object) -> object:
    """Return `terminal-peak sawtooth` as `sawtooth`."""
    return value.removeprefix("terminal-peak").strip(" -") if isinstance(value, str) else value


Pulse = Annotated[
    Literal["half-sine", "haversine", "sawtooth", "trapezoid"],
    BeforeValidator(_strip_terminal_peak),
    WithJsonSchema({"enum": [*PULSE_SHAPES, "terminal-peak sawtooth"]}),
]


class Shock(GeneratedMotion):
    """Base acceleration that is a single pulse, as on a drop table; a velocity change remains.

    Not to be confused with a force on the mass. The pulse is linear between grid points; its
    corners lie on grid points.
    """

    kind: Literal["shock"]
    """A single pulse of acceleration."""
    pulse: Pulse
    """Shape: half-sine, haversine, trapezoid or sawtooth with its peak at the end, from which
    it falls within one step."""
    amplitude: Acceleration
    """Peak acceleration [m/s²]."""
    duration: Duration
    """Duration of the pulse [s], a whole number of steps; measure.duration is that of the run.
    """
    start: Annotated[float, Quantity("s", at_least=0)] = 0.0
    """Start of the pulse [s], a whole number of steps."""
    rise: Duration | None = None
    """Rise time and fall time of a trapezoid [s]; default: a tenth of `duration`."""

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.rise is not None and self.pulse != "trapezoid":
            raise InvalidValue(
                f"is not used for a {self.pulse}; only a trapezoid has a rise", "rise"
            )
        if 2 * (self.rise or 0.0) > self.duration * (1 + STEP_TOLERANCE):
            raise InvalidValue(
                f"must be at most half of duration, {self.duration:g} s; not {self.rise:g} s",
                "rise",
            )
        return self

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return shape, amplitude and duration of the pulse."""
        text: str = self.pulse
        if "amplitude" not in varied:
            text += f" of {format_number(self.amplitude, 'm/s²')}"
        return (
            text if "duration" in varied else f"{text} for {format_number(self.duration, 's')}"
        )

    @property
    def grid_times(self) -> dict[str, float]:
        """Times of the corners of the pulse [s]."""
        corners = {"start": self.start, "duration": self.duration}
        if self.pulse == "trapezoid":
            corners["rise"] = self._rise
        return corners

    @property
    def _rise(self) -> float:
        return 0.1 * self.duration if self.rise is None else self.rise

    @property
    def velocity_change(self) -> float:
        """Integral of the pulse [m/s]."""
        whole = self.amplitude * self.duration
        if self.pulse == "half-sine":
            return 2 / pi * whole
        trapezoid = self.pulse == "trapezoid"
        return self.amplitude * (self.duration - self._rise) if trapezoid else whole / 2

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Return the samples of the pulse from 0 to `end`.

        Parameters
        ----------
        step : float
            Step of the grid [s].
        end : float, optional
            End of the motion [s]; default: end of the pulse.

        Raises
        ------
        InvalidValue
            As in `check_step`.
        """
        assert step is not None, "a generated signal needs a step"
        self.check_step(step)
        n, first = round(self.duration / step), round(self.start / step)
        last = first + n if end is None else max(1, ceil(end / step * (1 - STEP_TOLERANCE)))
        # What lies beyond the end of the run needs no memory.
        rise, count = round(self._rise / step), max(min(n, last - first) + 1, 0)
        values = self._pulse_values(float(n), float(rise), count)
        u_dd = np.zeros(last + 1)
        u_dd[first : first + len(values)] = values
        realised = {
            "velocity_change_asked": self.velocity_change,
            "velocity_change": float(values.sum() * step),
        }
        warnings = (*self._grid_warnings(step), *self._cut_warnings(last * step))
        return Samples(u_dd, step, None, (), warnings, realised)

    def _pulse_values(self, n: float, rise: float, count: int) -> Floats:
        """Return the first `count` values of the pulse, which lasts n steps.

        Numbers of steps are floats, as they may be beyond the integers of an array.
        """
        i = np.arange(count, dtype=np.float64)
        middle = np.minimum(i, n - i)  # makes the pulse symmetric to the last bit
        match self.pulse:
            case "half-sine":
                shape = np.sin(pi / n * middle)
            case "haversine":
                shape = np.square(np.sin(pi / n * middle))
            case "sawtooth":
                shape = i / n
            case "trapezoid":
                shape = np.minimum(middle / rise, 1.0)
        return np.asarray(self.amplitude * shape, dtype=np.float64)

    def _grid_warnings(self, step: float) -> Iterator[WarningMessage]:
        """Warn if linear interpolation on the grid distorts the pulse."""
        share = step / self.duration
        if self.pulse == "sawtooth":
            off, power, what = share, 1.0, "its fall adds {} to the velocity change"
        else:
            off, power = CHORD_ERROR.get(self.pulse, 0.0) * share**2, 0.5
            what = "linear interpolation deviates by {} of the amplitude"
        if off > MAX_GRID_ERROR:
            sentence = (
                f"solver.step is too coarse for the {self.pulse}: "
                f"{what.format(f'{off:.2%}')}; for {MAX_GRID_ERROR:.0%} use "
                f"{step * (MAX_GRID_ERROR / off) ** power:.2g} s or less"
            )
            yield WarningMessage("coarse-step", sentence, {"solver.step": step, "off": off})

    def _cut_warnings(self, end: float) -> Iterator[WarningMessage]:
        """Warn if the run ends before the pulse."""
        over = self.start + self.duration
        if end < over * (1 - STEP_TOLERANCE):
            sentence = f"the run ends at {end:g} s, before the end of the pulse at {over:g} s"
            yield WarningMessage("pulse-cut", sentence, {"end": end, "over": over})
