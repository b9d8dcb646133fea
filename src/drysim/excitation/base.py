"""Base classes of excitations.

`ExcitationBase` declares what every excitation provides, and describes it for all outputs, in
words on one line. `PeriodicMotion` is a sum of sines. `GeneratedMotion` is sampled on the
grid of solver.step and checks that the grid suits its corners and its highest frequency.
"""

from cmath import rect
from collections.abc import Collection, Sequence
from math import sqrt
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from drysim.block import Block, InvalidValue
from drysim.core.model import RecordSummary, Samples, Sines, without_rest
from drysim.quantity import Quantity
from drysim.wording import format_number, format_percent, format_range


class ExcitationBase(Block):
    """Base class of the excitation blocks."""

    also_called: ClassVar[tuple[str, ...]] = ()
    """Synonyms for the `kind`, recognised in error messages."""
    has_own_step: ClassVar[bool] = False
    """Whether the samples have their own step, so that solver.step is not used."""
    has_own_end: ClassVar[bool] = False
    """Whether the motion has an end, which is the default end of the run."""
    periodic: ClassVar[bool] = False
    """Whether the motion is a sum of sines, used analytically."""
    steady_by_default: ClassVar[bool] = False
    """Whether the metrics cover the steady state by default."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies of the sines [Hz]; empty unless `periodic`."""
        return ()

    @property
    def phases(self) -> tuple[float, ...]:
        """Phases of the sines as stated [rad]; those of the motion are within a turn."""
        return ()

    if TYPE_CHECKING:

        @property
        def kind(self) -> str:
            """Kind of excitation, a field of every subclass."""

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return a short text for the parameters, e.g. `C at 10 m/s` for a road.

        Parameters
        ----------
        varied : collection of str
            Keys of the excitation that a sweep varies; they are left out.
        """
        return ""

    def describe(self, motion: Sines | Samples, level: bool = True) -> str:
        """Return a description: kind, parameters, samples or frequencies, RMS.

        Parameters
        ----------
        motion : Sines or Samples
            The base motion of this excitation.
        level : bool, optional
            Whether to include the RMS of a record.
        """
        parameters = f"{self.kind} {self.parameters()}".strip()
        source = without_rest(motion) if isinstance(motion, Samples) else motion
        return parameters + self._describe_motion(source, level)

    def describe_cases(
        self,
        motion: Sines | Samples | None,
        swept: Collection[str],
        records: Sequence[RecordSummary] = (),
    ) -> str:
        """Return the base motion of all cases of a sweep, or what they have in common.

        Parameters
        ----------
        motion : Sines or Samples or None
            None if it differs between the cases, or is left out.
        swept : collection of str
            Dotted keys that vary; what they determine is omitted.
        records : sequence of RecordSummary, optional
            The records of the cases, if the sweep varies them.
        """
        prefix = "excitation."
        varied = [key.removeprefix(prefix) for key in swept if key.startswith(prefix)]
        if motion is not None and not varied:
            return self.describe(motion)
        if records:
            return self._describe_records(records, varied)
        parameters = f"{self.kind} {self.parameters(varied)}".strip()
        return parameters + self._describe_shared(varied)

    def _describe_motion(self, motion: Any, level: bool) -> str:
        """Return what `describe` adds to the parameters."""
        raise NotImplementedError

    def _describe_records(
        self, records: Sequence[RecordSummary], varied: Collection[str]
    ) -> str:
        """Return the description of several records."""
        raise NotImplementedError

    def _describe_shared(self, varied: Collection[str]) -> str:
        """Return what `describe_cases` adds to the parameters."""
        return ""


def describe_grid(motion: Samples) -> str:
    """Return number, rate and duration of samples in words."""
    rate, duration = 1 / motion.dt, (len(motion.u_dd) - 1) * motion.dt
    return (
        f"{len(motion.u_dd)} samples at {format_number(rate, 'Hz')}, "
        f"{format_number(duration, 's')}"
    )


# Sums of sines


class PeriodicMotion(ExcitationBase):
    """Base motion that is a sum of sines, used analytically."""

    periodic: ClassVar[bool] = True

    def motion(self, step: float | None = None, end: float | None = None) -> Sines:
        """Return the base acceleration."""
        raise NotImplementedError

    def _describe_motion(self, motion: Any, level: bool) -> str:
        count = f", {len(motion.A)} components," if len(motion.A) > 1 else ""
        rms = format_number(_rms_of_sines(motion), "m/s² RMS")
        return f"{count} {_format_band(motion)}, {rms}"

    def _describe_shared(self, varied: Collection[str]) -> str:
        keys = {key.rpartition(".")[2] for key in varied}  # of any component
        motion = self.motion()
        text = "" if "frequency" in keys else f" {_format_band(motion)}"
        if not keys & {"rms", "amplitude", "phase"}:
            text += f", {format_number(_rms_of_sines(motion), 'm/s² RMS')}"
        return text


def _format_band(motion: Sines) -> str:
    """Return the frequency of a sine, or the range of several."""
    return format_range(min(motion.f), max(motion.f), "Hz")


def _rms_of_sines(motion: Sines) -> float:
    """Return the RMS of a sum of sines, adding sines of equal frequency with their phases."""
    sums: dict[float, complex] = {}
    for A, f, phase in zip(*motion, strict=True):
        sums[f] = sums.get(f, 0.0) + rect(A, phase)
    return sqrt(sum(abs(amplitude) ** 2 for amplitude in sums.values()) / 2)


# Generated motion


STEP_TOLERANCE = 1e-9
"""Relative tolerance within which a time is a whole number of steps."""

Duration = Annotated[float, Quantity("s", above=0)]


def as_integer(value: object) -> object:
    """Convert a float with an integer value, such as 1e3, to int."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


class GeneratedMotion(ExcitationBase):
    """Base motion sampled on the grid of solver.step, linear between samples."""

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of the base motion [Hz]; it must be below the Nyquist frequency."""
        return 0.0

    @property
    def grid_times(self) -> dict[str, float]:
        """Times [s] that must be whole numbers of steps, by key."""
        return {}

    def check_step(self, step: float) -> None:
        """Check that a grid of this step can represent the base motion.

        Parameters
        ----------
        step : float
            Step of the grid [s].

        Raises
        ------
        InvalidValue
            If a time in `grid_times` is not a whole number of steps, or the step is at least
            half a period of the highest frequency.
        """
        for key, span in self.grid_times.items():
            steps = round(span / step)
            if abs(span / step - steps) > STEP_TOLERANCE * steps:
                raise InvalidValue(
                    f"must divide excitation.{key} = {span:.12g} s into whole steps; "
                    f"{step:.12g} s divides {max(steps, 1) * step:.12g} s",
                    "step",
                )
        if 2 * self.highest_frequency * step >= 1:
            raise InvalidValue(
                f"must be below {1 / (2 * self.highest_frequency):.4g} s, half a period of the "
                f"highest frequency of the excitation, {self.highest_frequency:.6g} Hz; "
                f"not {step:.12g} s",
                "step",
            )

    def _describe_motion(self, motion: Any, level: bool) -> str:
        """Return the grid, and the realised properties beside the requested ones."""
        parts, realised = [describe_grid(motion)], motion.realised
        for name, unit in (("rms", "m/s² RMS"), ("velocity_change", "m/s velocity change")):
            if name in realised:
                asked = format_number(realised[f"{name}_asked"])
                parts.append(f"{format_number(realised[name], unit)} (requested: {asked})")
        if "psd_error" in realised:
            error = format_percent(realised["psd_error"])
            parts.append(f"PSD error up to {error} of its peak")
        return "".join(f", {word}" for word in parts)


class FiniteMotion(GeneratedMotion):
    """Generated base motion of finite duration."""

    duration: Duration
    """Duration of the base motion [s], a whole number of steps."""

    has_own_end: ClassVar[bool] = True

    @property
    def grid_times(self) -> dict[str, float]:
        """The duration."""
        return {"duration": self.duration}

    def sample(self, step: float) -> Samples:
        """Return the samples from 0 to `duration` for a valid step [s]."""
        raise NotImplementedError

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Return the base acceleration on a grid.

        Parameters
        ----------
        step : float
            Step of the grid [s].
        end : float, optional
            Ignored: the motion has its own duration.

        Raises
        ------
        InvalidValue
            As in `check_step`.
        """
        assert step is not None, "a generated signal needs a step"
        self.check_step(step)
        return self.sample(step)

    def _describe_shared(self, varied: Collection[str]) -> str:
        """Return the duration and the requested level."""
        text = "" if "duration" in varied else f", {format_number(self.duration, 's')}"
        for key, unit in (("rms", "m/s² RMS"), ("amplitude", "m/s² amplitude")):
            level = getattr(self, key, None)
            if level is not None and key not in varied:
                text += f", {format_number(level, unit)}"
        return text
