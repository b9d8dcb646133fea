"""What excitations share: what each says of itself, and how motion is generated.

Generated motion lies on the grid of solver.step and has corners and an end that must suit it.
`periodic_signals` makes signals that repeat of their spectra, in threads where they are long.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import Annotated, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field

from drysim import system
from drysim.core.model import MAX_KEPT, Samples
from drysim.units import Block, InvalidValue, Quantity

Floats = NDArray[np.float64]


class ExcitationBase(Block):
    """An excitation with its keys."""

    also_called: ClassVar[tuple[str, ...]] = ()
    """Words that somebody may have for it."""
    has_own_step: ClassVar[bool] = False
    """Whether its samples have a distance of their own, so that solver.step has no use."""
    has_own_end: ClassVar[bool] = False
    """Whether a run ends with it unless the scenario says otherwise."""
    periodic: ClassVar[bool] = False
    """Whether it is made of sines, which are used analytically and may repeat."""
    steady_by_default: ClassVar[bool] = False
    """Whether it is measured over the periodic orbit unless the scenario says otherwise."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        """What repeats [Hz]; none unless it is periodic."""
        return ()

    def description(self, varied: Collection[str] = ()) -> str:
        """Give what it is by its keys, behind its kind, without those that a sweep varies.

        E.g. `C at 10 m/s` of a road; nothing where its motion tells it all.
        """
        return ""


# Motion that is generated.


STEP_TOLERANCE = 1e-9
"""A time this close to a whole number of steps, relative to it, is that number."""

Duration = Annotated[float, Quantity("s", above=0)]


def as_integer(value: object) -> object:
    """Give 1e3 as the whole number that it is."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


WholeNumber = Annotated[int, BeforeValidator(as_integer), Field(strict=True)]

DEFAULT_MAX_SEEDS = 400
"""Seeds at which `until` gives up by default: then the interval is no wider than a tenth of
what a single seed scatters."""


class GeneratedMotion(ExcitationBase):
    """Base motion that is computed on the grid of solver.step, linear between its points."""

    @property
    def highest_frequency(self) -> float:
        """Highest frequency of the base motion [Hz], which the step must be able to carry."""
        return 0.0

    @property
    def grid_times(self) -> dict[str, float]:
        """Times of the base motion [s] that must be whole numbers of steps, by key."""
        return {}

    def check_step(self, step: float) -> None:
        """Make sure that a grid of this step [s] can hold the base motion.

        Raises
        ------
        Misfit
            When a span is no whole number of steps, or half a period of the highest frequency
            is not longer than a step.
        """
        for key, span in self.grid_times.items():
            steps = round(span / step)
            if abs(span / step - steps) > STEP_TOLERANCE * steps:
                raise InvalidValue(
                    f"must divide excitation.{key}, {span:.12g} s, into whole steps; "
                    f"{step:.12g} s does so with {max(steps, 1) * step:.12g} s",
                    "step",
                )
        if 2 * self.highest_frequency * step >= 1:
            raise InvalidValue(
                f"must be below {1 / (2 * self.highest_frequency):.4g} s, half a period of the highest "
                f"frequency of the excitation, {self.highest_frequency:.6g} Hz; not {step:.12g} s",
                "step",
            )


class FiniteMotion(GeneratedMotion):
    """Base motion that is generated and has a length of its own."""

    duration: Duration
    """Length of the base motion [s], a whole number of steps."""

    has_own_end: ClassVar[bool] = True

    @property
    def grid_times(self) -> dict[str, float]:
        """The whole of it."""
        return {"duration": self.duration}

    def sample(self, step: float) -> Samples:
        """Give the samples from 0 to `duration` at a step [s] that suits."""
        raise NotImplementedError

    def motion(self, step: float | None = None, end: float | None = None) -> Samples:
        """Give the base acceleration on a grid, and what else is known of the motion.

        It has a length of its own, whatever `end` is; the errors are those of `check_step`.
        """
        assert step is not None, "a generated signal needs a step"
        self.check_step(step)
        return self.sample(step)


class Until(Block):
    """How narrow the confidence interval of a mean over seeds is to become."""

    metric: str
    """Name of a metric, from `a_u` to `energy_residual` in their table."""
    half_width: Annotated[float, Quantity("", above=0)]
    """Half of its 95 % confidence interval over its mean [-], such as `1 %`."""


# Signals that repeat, from their spectra.


HAS_FFT_OUT = np.lib.NumpyVersion(np.__version__) >= "2.0.0"
"""Whether numpy can transform into memory at hand: the memory of a long signal costs time."""

Job = TypeVar("Job")
Done = TypeVar("Done")


def map_in_threads(do: Callable[[Job], Done], jobs: Iterable[Job], n: int) -> list[Done]:
    """Give what is done to every job; for a signal of many samples [n] in threads."""
    if n <= MAX_KEPT:
        return [do(job) for job in jobs]
    from concurrent.futures import ThreadPoolExecutor

    # Memory is no faster with more threads than four.
    with ThreadPoolExecutor(min(system.processor_count(), 4)) as pool:
        return list(pool.map(do, jobs))


def periodic_signals(spectra: NDArray[np.complex128], n: int) -> Iterable[Floats]:
    """Give one period of two signals [n], each with its first sample again.

    Other libraries transform two real signals faster, but round otherwise in some releases: a
    seed would not be the same signal to the last bit alone and among others.
    """

    def closed(spectrum: NDArray[np.complex128]) -> Floats:
        signal = np.empty(n + 1)
        if HAS_FFT_OUT:
            np.fft.irfft(spectrum, n, norm="forward", out=signal[:n])
        else:
            signal[:n] = np.fft.irfft(spectrum, n, norm="forward")
        signal[n] = signal[0]
        return signal

    return map_in_threads(closed, spectra, n)
