"""Random base motion: a given PSD, seat-test spectra, and roads of ISO 8608.

Problem
    Generate a stationary random signal with a prescribed PSD, reproducible from a seed, whose
    displacement is known and has no drift.

Method
    A sum of sines at multiples of 1/duration with amplitudes from the PSD and random phases,
    computed by inverse FFT. The signal is periodic and has the PSD exactly. The displacement is
    obtained in the frequency domain: it is the one whose second derivative is ü linear between
    samples (`random_signal`), so the core stays exact.

Reproducibility
    Phase number k of the generator belongs to line k. A finer step or another band does not
    change the phases of the lines.

`spectral_lines` and `random_signal` do not depend on scenarios; the classes below define the
spectra.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import pairwise
from math import ceil, expm1, floor, log, pi, sqrt
from typing import Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from drysim.block import Block, InvalidValue
from drysim.core.model import BLOCK_SIZE, MAX_CACHED, Floats, Samples, recall
from drysim.errors import WarningMessage
from drysim.excitation.base import STEP_TOLERANCE, FiniteMotion, as_integer
from drysim.messages import closest_match, did_you_mean, format_value
from drysim.parallel import completed_in_threads
from drysim.quantity import Frequency, Quantity
from drysim.system import processor_count
from drysim.wording import format_number, format_range

Density = Callable[[Floats], Floats]

N_PHASES = 1 << 16
"""Number of equidistant phases: a table replaces sine and cosine per line."""

MIN_LINES = 30
"""Fewer equal lines [-] are visibly not Gaussian: the excess kurtosis is -1.5 over their
number."""

MAX_RMS_LOSS = 0.01
"""Relative RMS loss by linear interpolation above which a warning is given [-]."""


class SpectralLines(NamedTuple):
    """Lines k/T of a signal of period T: index of the first, mean squares [m²/s⁴], T [s]."""

    first: int
    squares: Floats
    T: float


def line_range(low: float, high: float, T: float) -> tuple[int, int]:
    """Return the first and last index k of the lines k/T within a band [Hz].

    Band edges within rounding of a line include it. The first is above the last if there is no
    line.
    """
    return ceil(low * T * (1 - STEP_TOLERANCE)), floor(high * T * (1 + STEP_TOLERANCE))


def spectral_lines(
    G: Density, band: tuple[float, float], square: float, T: float
) -> SpectralLines:
    """Return the lines of a one-sided PSD within a band.

    Parameters
    ----------
    G : callable
        PSD [(m/s²)²/Hz] at an array of frequencies [Hz].
    band : tuple of float
        First and last frequency [Hz]; the PSD is zero outside.
    square : float
        Integral of the PSD over the band [m²/s⁴], which the lines share.
    T : float
        Period of the signal [s].
    """
    first, last = line_range(*band, T)
    squares = np.empty(last + 1 - first)

    def fill(part: slice) -> None:
        squares[part] = G(np.clip(np.arange(first + part.start, first + part.stop) / T, *band))

    _for_lines(fill, len(squares))
    squares *= square / squares.sum()
    return SpectralLines(first, squares, T)


class Amplitudes(NamedTuple):
    """What all random signals with the same lines and samples share.

    Attributes
    ----------
    first : int
        Index of the first line.
    samples : int
        Number of samples in a period.
    step : float
        Step of the samples [s].
    u_dd : ndarray
        Amplitude of each line of ü, half that of a sine [m/s²].
    u_share : ndarray
        That of the displacement over that of ü [s²].
    mean_squares : tuple of float
        Of ü, linear between samples, and of the displacement [m²/s⁴, m²]; the same for all
        phases.
    realised, warnings
        As in `Samples`.
    """

    first: int
    samples: int
    step: float
    u_dd: Floats
    u_share: Floats
    mean_squares: tuple[float, float]
    realised: dict[str, object]
    warnings: tuple[WarningMessage, ...]


def line_amplitudes(wanted: SpectralLines, step: float, rms: float | None = None) -> Amplitudes:
    """Return the amplitudes of the lines of a sampled signal.

    Parameters
    ----------
    wanted : SpectralLines
        Lines, all below the Nyquist frequency.
    step : float
        Step of the samples [s]; the period is a whole number of steps.
    rms : float, optional
        RMS value [m/s²] to which ü, linear between its samples, is scaled.

    Notes
    -----
    Linear between samples, a line of the phase x = ω Δt/2 per half step has lines at x + πj for
    all integers j, with amplitudes in the ratio of sin² x/(x + πj)²; those of the displacement
    have (Δt/2)² sin² x/(x + πj)⁴. The mean squares are sums over j, closed by derivatives of
    Σ 1/(x + πj)² = 1/sin² x.
    """
    first, squares, T = wanted
    n, sin2_half = round(T / step), np.empty(len(squares))

    def square_of_sine(part: slice) -> None:
        k = np.arange(first + part.start, first + part.stop)
        sin2_half[part] = np.square(np.sin(pi / T * step * k))  # sin²(ω Δt/2)

    _for_lines(square_of_sine, len(squares))
    kept = float(squares @ (1 - 2 / 3 * sin2_half))
    scale = 1.0 if rms is None else rms / sqrt(kept)
    asked = float(squares.sum())
    realised: dict[str, object] = {
        "rms_asked": sqrt(asked) if rms is None else rms,
        "rms": sqrt(kept) * scale,
        "scale": scale,
        "lines": len(squares),
    }
    warnings = (
        *_few_lines_warnings(squares),
        *coarse_step_warnings(sqrt(kept / asked), step, "the base RMS"),
    )
    # -1/ω² as step -> 0
    u_share = step * step * (1 / 6 - 1 / 4 / sin2_half)
    u_dd = np.sqrt(squares / 2) * scale
    share = (1 / sin2_half - 4 / 3) / sin2_half + 2 / 5 - 4 / 315 * sin2_half
    u2 = step**4 / 16 * float(squares @ share)
    mean_squares = scale * scale * kept, scale * scale * u2
    return Amplitudes(first, n, step, u_dd, u_share, mean_squares, realised, warnings)


def random_signal(amplitudes: Amplitudes, seed: int) -> Samples:
    """Return one period of a random signal with these amplitudes.

    Parameters
    ----------
    amplitudes : Amplitudes
    seed : int
        Seed of the phases.

    Returns
    -------
    Samples
        Base acceleration with its displacement; first and last sample are equal.

    Notes
    -----
    Only the phases are random; the amplitude of each line follows from the PSD. Line k takes
    phase k of `PCG64(seed)`. The displacement has zero mean and no drift, and its second
    derivative is ü linear between samples.
    """
    n, step = amplitudes.samples, amplitudes.step
    u_dd = _one_period(line_spectrum(amplitudes, seed), n)
    displacement = RandomDisplacement(amplitudes, seed)
    return Samples(
        u_dd,
        step,
        displacement,
        (),
        amplitudes.warnings,
        amplitudes.realised,
        mean_squares=amplitudes.mean_squares,
    )


@dataclass(frozen=True, eq=False)
class RandomDisplacement:
    """Displacement of a random signal [m], a signal computed at its first use.

    Over a whole period its mean square is known without it.
    """

    amplitudes: Amplitudes
    seed: int

    def __len__(self) -> int:
        """Return the number of samples."""
        return self.amplitudes.samples + 1

    def __getitem__(self, part: slice) -> Floats:
        """Return a slice as an array."""
        return self._values[part]

    @cached_property
    def _values(self) -> Floats:
        first, share = self.amplitudes.first, self.amplitudes.u_share
        spectrum = line_spectrum(self.amplitudes, self.seed)
        spectrum[first : first + len(share)] *= share
        return _one_period(spectrum, self.amplitudes.samples)


def line_spectrum(amplitudes: Amplitudes, seed: int) -> NDArray[np.complex128]:
    """Return the one-sided spectrum of ü with the phases of a seed, scaled as by `irfft`."""
    first, each = amplitudes.first, amplitudes.u_dd
    random = np.random.Generator(np.random.PCG64(seed))
    codes = random.integers(N_PHASES, size=first + len(each), dtype=np.uint16)[first:]
    table = _phase_factors()
    spectrum = np.zeros(amplitudes.samples // 2 + 1, dtype=complex)

    def fill(part: slice) -> None:
        lines = spectrum[first + part.start : first + part.stop]
        np.multiply(each[part], table[codes[part]], out=lines)

    _for_lines(fill, len(each))
    return spectrum


def _one_period(spectrum: NDArray[np.complex128], n: int) -> Floats:
    """Return n samples from a one-sided spectrum, the first repeated at the end."""
    signal = np.fft.irfft(spectrum, n, norm="forward")
    return np.append(signal, signal[0])


def _for_lines(do: Callable[[slice], None], count: int) -> None:
    """Call `do` for slices of `count` lines that fit into the cache; of many, in threads."""
    parts = [
        slice(start, min(start + BLOCK_SIZE, count)) for start in range(0, count, BLOCK_SIZE)
    ]
    # More than four threads do not help: memory bandwidth is the limit.
    threads = 1 if count <= MAX_CACHED else min(processor_count(), 4)
    for _ in completed_in_threads(do, parts, threads):
        pass


@cache
def _phase_factors() -> NDArray[np.complex128]:
    """Return e^(jφ) for all phases; computed once."""
    factors: NDArray[np.complex128] = np.exp(2j * pi / N_PHASES * np.arange(N_PHASES))
    factors.flags.writeable = False
    return factors


def _few_lines_warnings(squares: Floats) -> Iterator[WarningMessage]:
    """Warn if the lines are too few for Gaussian noise."""
    effective = float(squares.sum() ** 2 / (squares @ squares))
    if effective < MIN_LINES:
        sentence = (
            f"the random signal has {effective:.3g} effective spectral lines, too few for "
            f"Gaussian noise; {MIN_LINES / effective:.2g} times the duration gives {MIN_LINES}"
        )
        yield WarningMessage("few-lines", sentence, {"lines": effective})


def coarse_step_warnings(kept: float, step: float, what: str) -> Iterator[WarningMessage]:
    """Warn if linear interpolation between samples loses too much.

    Parameters
    ----------
    kept : float
        Ratio of RMS or amplitude with and without linear interpolation [-].
    step : float
        Step of the samples [s]; the loss is proportional to its square.
    what : str
        What is lost, for the message.
    """
    if kept < 1 - MAX_RMS_LOSS:
        fine = 0.9 * step * sqrt(MAX_RMS_LOSS / (1 - kept))
        sentence = (
            "solver.step is too coarse: linear interpolation loses "
            f"{(1 - kept) * 100:.2g} % of {what}; use {fine:.2g} s or less"
        )
        yield WarningMessage("coarse-step", sentence, {"solver.step": step, "kept": kept})


class Until(Block):
    """Stopping rule: precision required of the mean over seeds."""

    metric: str
    """Name of a metric, from `a_u` to `law_residual` in the table of metrics."""
    half_width: Annotated[float, Quantity("", above=0)]
    """Half-width of the 95 % confidence interval relative to the mean [-], such as `1 %`."""


WholeNumber = Annotated[int, BeforeValidator(as_integer), Field(strict=True)]

DEFAULT_MAX_SEEDS = 400
"""Default maximum number of seeds for `until`: the half-width of the confidence interval is
then about a tenth of the standard deviation of a single seed."""


class RandomMotion(FiniteMotion):
    """Random base motion, periodic in `duration`: the same seed gives the same signal.

    With `seeds` or `until` it is an ensemble, one signal for each seed from `seed` on.
    """

    seed: Annotated[WholeNumber, Field(ge=0)] = 1
    """Seed of the random numbers, an integer; each seed gives another signal. For an ensemble:
    the first seed."""
    seeds: Annotated[WholeNumber, Field(le=1_000_000_000)] | None = None
    """Number of seeds of an ensemble [-], at least 2: `seed`, `seed` + 1, ..., one run each.
    Metrics are means over the seeds, with confidence intervals. With `until`: the maximum
    number, 400 by default."""
    until: Until | None = None
    """Adds seeds until the confidence interval of a metric is narrow enough; checked after
    every tenth seed."""

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("seed", "seeds", "until"),)

    @property
    def max_seeds(self) -> int:
        """Maximum number of seeds [-]; 1 without `seeds` and `until`."""
        return (self.seeds or DEFAULT_MAX_SEEDS) if self.until else (self.seeds or 1)

    def with_seed(self, seed: int) -> Self:
        """Return the motion of a single seed."""
        return self.model_copy(update={"seed": seed, "seeds": None, "until": None})

    @field_validator("seeds")
    @classmethod
    def _several(cls, seeds: int | None) -> int | None:
        if seeds is not None and seeds < 2:
            sentence = "must be at least 2, as one seed has no confidence interval"
            raise ValueError(f"{sentence}; not {format_value(seeds)}")
        return seeds

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency of the spectrum [Hz]."""
        raise NotImplementedError

    @property
    def highest_frequency(self) -> float:
        """Last frequency of the spectrum [Hz]."""
        return self.band[1]

    @model_validator(mode="after")
    def _long_enough(self) -> Self:
        low, high = self.band
        first, last = line_range(low, high, self.duration)
        if first > last:
            raise InvalidValue(
                f"must be at least {1 / (high - low):.4g} s: the spectral lines are "
                f"1/duration apart, and none would be between {low:g} and {high:g} Hz",
                "duration",
            )
        return self


# PSD given by its corners


def _validate_pair(value: object) -> object:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError(f"must be a pair [frequency, PSD], not {format_value(value)}")
    return value


Point = Annotated[
    tuple[Frequency, Annotated[float, Quantity("(m/s²)²/Hz", above=0)]],
    BeforeValidator(_validate_pair),
]
"""Corner of a PSD: frequency [Hz] and one-sided PSD [(m/s²)²/Hz]."""


class Psd(RandomMotion):
    """Random base motion with a given PSD of the acceleration.

    Not to be confused with a record: the signal is generated as a sum of sines at multiples of
    1/duration with random phases, and repeats after `duration`.
    """

    kind: Literal["psd"]
    """Random base motion with a given PSD."""
    also_called: ClassVar[tuple[str, ...]] = ("random", "noise", "spectrum")
    points: Annotated[tuple[Point, ...], Field(json_schema_extra={"minItems": 2})]
    """Corners [frequency, PSD] of the one-sided PSD of ü, in Hz and (m/s²)²/Hz (or `g²/Hz`), in
    ascending order. The PSD is linear in log-log axes between them and zero outside."""
    rms: Annotated[float, Quantity("m/s²", above=0)] | None = None
    """RMS value a_u of the base acceleration [m/s²]. If given, only the shape of the PSD is
    used, and the signal is scaled to exactly this RMS over its duration."""

    @field_validator("points")
    @classmethod
    def _ascending(cls, points: tuple[Point, ...]) -> tuple[Point, ...]:
        if len(points) < 2:
            raise ValueError("must have at least two points [frequency, PSD]")
        for i, ((low, _), (high, _)) in enumerate(pairwise(points)):
            if not low < high:
                sentence = f"must be above the previous frequency, {low:g} Hz; not {high:g}"
                raise InvalidValue(sentence, i + 1, 0)
        return points

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency of the PSD [Hz]."""
        return self.points[0][0], self.points[-1][0]

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return the band."""
        if any(key.startswith("points") for key in varied):
            return ""
        return format_range(*self.band, "Hz")

    def sample(self, step: float) -> Samples:
        """Return the base acceleration on a grid, with its displacement."""
        T = self.duration
        amplitudes = recall(T / step, polygon_amplitudes, T, step, self.points, self.rms)
        return random_signal(amplitudes, self.seed)


def polygon_amplitudes(
    T: float, step: float, points: tuple[tuple[float, float], ...], rms: float | None = None
) -> Amplitudes:
    """Return the amplitudes of a log-log polygon in a signal of period T [s]."""
    f, G = (np.array(column) for column in zip(*points, strict=True))
    band = points[0][0], points[-1][0]
    square = loglog_integral(points)
    lines = spectral_lines(partial(loglog_density, f, G), band, square, T)
    return line_amplitudes(lines, step, rms)


def loglog_density(f: Floats, G: Floats, frequencies: Floats) -> Floats:
    """Evaluate a PSD with corners (f, G), linear in log-log axes, at ascending frequencies."""
    density = np.empty(len(frequencies))
    edges = np.searchsorted(frequencies, f)
    edges[-1] = len(frequencies)
    for i in range(len(f) - 1):
        part = slice(edges[i], edges[i + 1])
        p = log(G[i + 1] / G[i]) / log(f[i + 1] / f[i])
        density[part] = G[i] * (frequencies[part] / f[i]) ** p
    return density


def loglog_integral(points: tuple[tuple[float, float], ...]) -> float:
    """Return the integral of a log-log polygon, the mean square of the signal [m²/s⁴].

    Notes
    -----
    A segment contributes P1 f1/(p+1) [(f2/f1)^(p+1) - 1], or P1 f1 ln(f2/f1) if p = -1.
    """
    total = 0.0
    for (f_1, P_1), (f_2, P_2) in pairwise(points):
        octaves = log(f_2 / f_1)
        rise = log(P_2 / P_1) + octaves  # (p + 1) ln(f2/f1)
        total += P_1 * f_1 * octaves * (expm1(rise) / rise if rise else 1.0)
    return total


# Input spectra of laboratory tests of vehicle seats, by class


MIDPOINTS = 100_000
"""Points of the midpoint rule for the integral of a spectrum; nine digits."""

CHECK_BANDWIDTH = 0.5
"""Width of the bands in which the realised PSD is reported [Hz]."""

BAND_A = (0.89, 11.22)
BAND_B = (0.89, 17.78)
"""Bands of the stated RMS values [Hz]: third octaves from 1 Hz to 10 Hz and to 16 Hz."""


class SeatSpectrum(NamedTuple):
    """Seat-test PSD G0 |HP|² |LP|² with Butterworth filters: (order, corner [Hz]) each.

    `G0` is in (m/s²)²/Hz, `rms` is the RMS value stated by the standard [m/s²], `band` the band
    of that value [Hz].
    """

    high_pass: tuple[int, float]
    low_pass: tuple[int, float]
    G0: float
    rms: float
    band: tuple[float, float]
    recalled: bool = False
    """Whether the stated RMS is quoted from memory, not checked against the standard."""

    def density(self, f: Floats) -> Floats:
        """Return the PSD of ü [(m/s²)²/Hz]."""
        (n, f_h), (p, f_l) = self.high_pass, self.low_pass
        high = (f / f_h) ** (2 * n)
        return self.G0 * high / (1 + high) / (1 + (f / f_l) ** (2 * p))


def seat_amplitudes(
    T: float, step: float, spectrum: SeatSpectrum, rms: float | None
) -> Amplitudes:
    """Return the amplitudes of a seat test in a signal of period T [s]."""
    square = spectrum_mean_square(spectrum)
    lines = spectral_lines(spectrum.density, spectrum.band, square, T)
    return line_amplitudes(lines, step, rms)


@cache
def spectrum_mean_square(spectrum: SeatSpectrum) -> float:
    """Return the integral of the PSD over its band [m²/s⁴]; the same for every seed."""
    low, high = spectrum.band
    share = (np.arange(MIDPOINTS, dtype=np.float64) + 0.5) / MIDPOINTS
    return float(spectrum.density(low + share * (high - low)).mean() * (high - low))


MACHINE_CLASSES = {
    "EM1": SeatSpectrum((4, 1.5), (4, 2.5), 2.82, 1.71, BAND_A),
    "EM2": SeatSpectrum((4, 1.5), (4, 3.0), 2.72, 2.05, BAND_A),
    "EM3": SeatSpectrum((4, 1.5), (4, 3.0), 1.93, 1.73, BAND_A),
    "EM4": SeatSpectrum((4, 1.5), (4, 3.0), 0.60, 0.96, BAND_A),
    "EM5": SeatSpectrum((4, 1.5), (1, 3.5), 1.11, 1.94, BAND_B),
    "EM6": SeatSpectrum((2, 6.5), (2, 9.0), 0.79, 1.65, BAND_B),
    "EM7": SeatSpectrum((8, 3.0), (8, 3.5), 9.25, 2.25, BAND_A, recalled=True),
    "EM8": SeatSpectrum((4, 3.0), (2, 3.0), 1.45, 1.05, BAND_B),
    "EM9": SeatSpectrum((4, 3.5), (2, 4.0), 2.10, 1.63, BAND_B),
    "IT1": SeatSpectrum((4, 4.5), (2, 5.0), 1.66, 1.58, BAND_B),
    "IT2": SeatSpectrum((4, 3.0), (2, 3.0), 1.45, 1.05, BAND_B),
    "IT3": SeatSpectrum((4, 1.5), (4, 3.0), 0.60, 0.96, BAND_A),
    "IT4": SeatSpectrum((4, 1.5), (4, 3.0), 1.64, 1.59, BAND_B),
    "AG1": SeatSpectrum((8, 3.0), (8, 3.5), 9.25, 2.26, BAND_A),
    "AG2": SeatSpectrum((8, 2.1), (8, 2.6), 7.22, 1.94, BAND_A),
    "AG3": SeatSpectrum((8, 1.95), (8, 2.45), 5.85, 1.74, BAND_A),
}
"""EM: earth-moving machines, EN ISO 7096. IT: industrial trucks, EN 13490. AG: agricultural
tractors, ISO 5007."""


class Standard(RandomMotion):
    """Vertical base motion of a seat test, by machine class.

    Not to be confused with a record of the machine: the signal is generated from the spectrum
    of the standard, within the band of the class.
    """

    kind: Literal["standard"]
    """Base motion of a seat test."""
    machine: Annotated[
        str, Field(alias="class", json_schema_extra={"enum": list(MACHINE_CLASSES)})
    ]
    """Class: EM1 to EM9 (earth-moving machines, ISO 7096), IT1 to IT4 (industrial trucks, EN
    13490), AG1 to AG3 (agricultural tractors, ISO 5007)."""
    scale: Literal["to definition", "nothing"] = "to definition"
    """Whether the signal is scaled to exactly the RMS value stated in the standard, or keeps
    the RMS of the spectrum, which differs by up to 1 %."""

    @field_validator("machine")
    @classmethod
    def _known_class(cls, name: str) -> str:
        if name not in MACHINE_CLASSES:
            hint = did_you_mean(closest_match(name, MACHINE_CLASSES))
            raise ValueError(
                f"must be EM1 to EM9, IT1 to IT4 or AG1 to AG3, not {format_value(name)}{hint}"
            )
        return name

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return the class."""
        return self.machine

    @property
    def band(self) -> tuple[float, float]:
        """Band of the stated RMS [Hz]."""
        spectrum = MACHINE_CLASSES.get(self.machine)
        return spectrum.band if spectrum else BAND_A

    def sample(self, step: float) -> Samples:
        """Return the base acceleration on a grid, with a check against its definition."""
        spectrum = MACHINE_CLASSES[self.machine]
        rms = spectrum.rms if self.scale == "to definition" else None
        T = self.duration
        amplitudes = recall(T / step, seat_amplitudes, T, step, spectrum, rms)
        motion = random_signal(amplitudes, self.seed)
        realised = LazyMapping(partial(realised_psd, self.machine, motion))
        motion = motion._replace(realised=realised)
        if not spectrum.recalled:
            return motion
        sentence = (
            f"the stated RMS of {self.machine}, {spectrum.rms:g} m/s², is quoted from memory, "
            "not checked against the text of the standard; `scale: nothing` does not use it"
        )
        warning = WarningMessage("recalled", sentence, {"rms": spectrum.rms})
        return motion._replace(warnings=(*motion.warnings, warning))


class LazyMapping(Mapping[str, object]):
    """Mapping that is computed at its first use.

    Comparing a signal with its definition takes as long as generating it, and an ensemble shows
    the comparison of one seed only.
    """

    def __init__(self, compute: Callable[[], Mapping[str, object]]) -> None:
        self._compute = compute

    @cached_property
    def _computed(self) -> Mapping[str, object]:
        return self._compute()

    def __getitem__(self, key: str) -> object:
        """Return a value."""
        return self._computed[key]

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the keys."""
        return iter(self._computed)

    def __len__(self) -> int:
        """Return the number of keys."""
        return len(self._computed)

    def __repr__(self) -> str:
        """Return the computed mapping in words."""
        return repr(self._computed)


def realised_psd(machine: str, motion: Samples) -> dict[str, object]:
    """Return what a signal for a machine class realises: its RMS, and its PSD in bands."""
    spectrum = MACHINE_CLASSES[machine]
    bands = compare_psd(spectrum, motion)
    worst = max(abs(band["found"] - band["asked"]) for band in bands)
    peak = float(spectrum.density(np.linspace(*spectrum.band, 1000)).max())
    return {
        **motion.realised,
        "class": machine,
        "rms_asked": spectrum.rms,
        "psd_error": worst / peak,
        "psd": bands,
    }


def compare_psd(spectrum: SeatSpectrum, motion: Samples) -> tuple[dict[str, float], ...]:
    """Return the realised and the prescribed PSD in bands.

    Each band has `from` and `to` [Hz], and `asked` and `found`, the means of both PSDs over the
    lines in it [(m/s²)²/Hz].
    """
    n = len(motion.u_dd) - 1
    low, high = spectrum.band
    length = n * motion.dt
    lines = slice(floor(low * length), ceil(high * length) + 1)
    amplitudes = np.fft.rfft(motion.u_dd[:-1], norm="forward")[lines]
    f = np.arange(lines.start, lines.start + len(amplitudes)) / length
    realised, asked = 2 * length * np.square(np.abs(amplitudes)), spectrum.density(f)
    edges = np.linspace(low, high, round((high - low) / CHECK_BANDWIDTH) + 1)
    bands = []
    for left, right in pairwise(edges.tolist()):
        in_band = (f >= left) & (f < right)
        if in_band.any():
            means = {
                "asked": float(asked[in_band].mean()),
                "found": float(realised[in_band].mean()),
            }
            bands.append({"from": left, "to": right, **means})
    return tuple(bands)


# Road profile of ISO 8608 under a wheel at constant speed


N_0, OMEGA_0 = 0.1, 1.0
"""Reference wave number n0 [cycle/m] and angular wave number Ω0 [rad/m]."""

ROAD_CLASSES = {name: 16e-6 * 4.0**i for i, name in enumerate("ABCDEFGH")}
"""Geometric means G_d(n0) of the classes [m³]; the class limits are half and twice the mean."""

UNVERIFIED_CLASSES = "EFGH"
"""Classes whose value is quoted from memory, not checked against the standard."""

WaveNumber = Annotated[float, Quantity("1/m", above=0)]


class Band(Block):
    """Range of wave numbers of a road."""

    low: Annotated[WaveNumber, Field(alias="from")] = 0.011
    """Lowest wave number [1/m], in cycles per metre."""
    high: Annotated[WaveNumber, Field(alias="to")] = 2.83
    """Highest wave number [1/m], in cycles per metre."""

    @model_validator(mode="after")
    def _upwards(self) -> Self:
        if not self.low < self.high:
            raise InvalidValue(
                f"must be above `from`, {self.low:g} 1/m; not {self.high:g} 1/m", "to"
            )
        return self


class Road(RandomMotion):
    """Rough road under a wheel at constant speed that follows the road without loss of contact.

    Not to be confused with the floor of a vehicle: tyre and suspension are not included.
    Roughness values for n0 and Omega0 differ by a factor of 16, so the reference must be named.
    """

    kind: Literal["road"]
    """Road profile at constant speed."""
    grade: Annotated[
        Literal["A", "B", "C", "D", "E", "F", "G", "H"] | None, Field(alias="class")
    ] = None
    """Class of ISO 8608, A (smooth) to H; the geometric mean G_d(n0) is 16e-6 m³ for A and
    increases by a factor of four per class."""
    reference: Literal["n0", "Omega0"] | None = None
    """Reference of `roughness`: n0, per cycle/m at 0.1 cycle/m; Omega0, per rad/m at 1 rad/m.
    """
    roughness: Annotated[float, Quantity("m³", above=0)] | None = None
    """PSD of the profile height at the reference [m³], instead of `class`."""
    speed: Annotated[float, Quantity("m/s", above=0)]
    """Speed V [m/s]."""
    wave_numbers: Band = Field({}, validate_default=True)
    """Range of wave numbers [1/m]; the PSD is zero outside. Default: range of validity of the
    standard."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("class", "roughness"),)
    needs: ClassVar[dict[str, str]] = {"reference": "roughness"}

    @field_validator("roughness")
    @classmethod
    def _refers(cls, roughness: float | None, info: ValidationInfo) -> float | None:
        stated = {"grade", "reference"} & {key for key, word in info.data.items() if word}
        if roughness is not None and not stated and "reference" in info.data:
            raise ValueError(
                "needs its reference: `reference: n0` for a PSD per cycle/m at 0.1 cycle/m, "
                "`reference: Omega0` for one per rad/m at 1 rad/m (16 times as rough)"
            )
        return roughness

    def parameters(self, varied: Collection[str] = ()) -> str:
        """Return roughness and speed."""
        text: str = self.grade or ""
        if self.roughness is not None and "roughness" not in varied:
            text = f"of {format_number(self.roughness, 'm³')} ({self.reference})"
        speed = "" if "speed" in varied else f"at {format_number(self.speed, 'm/s')}"
        return f"{text} {speed}".strip()

    @property
    def G_d(self) -> float:
        """PSD of the height at n0 [m³]."""
        if self.roughness is None:
            return ROAD_CLASSES[self.grade or "A"]
        if self.reference == "n0":
            return self.roughness
        # A PSD per cycle is 2π times that per radian; the PSD is proportional to n^-2.
        return self.roughness * 2 * pi * (OMEGA_0 / (2 * pi * N_0)) ** 2

    @property
    def band(self) -> tuple[float, float]:
        """First and last frequency [Hz]."""
        return self.speed * self.wave_numbers.low, self.speed * self.wave_numbers.high

    def corners(self) -> tuple[tuple[float, float], ...]:
        """Return the end points of the PSD of ü [Hz, (m/s²)²/Hz].

        Notes
        -----
        With f = n V the PSD of ü is 16 π⁴ n0² G_d(n0) V f².
        """
        rise = 16 * pi**4 * N_0**2 * self.G_d * self.speed
        return tuple((f, rise * f**2) for f in self.band)

    def sample(self, step: float) -> Samples:
        """Return the base acceleration on a grid, with the height of the road."""
        T = self.duration
        amplitudes = recall(T / step, polygon_amplitudes, T, step, self.corners())
        motion = random_signal(amplitudes, self.seed)
        if not self.grade or self.grade not in UNVERIFIED_CLASSES:
            return motion
        sentence = (
            f"the roughness of class {self.grade}, {self.G_d:g} m³ at 0.1 cycle/m, is quoted "
            "from memory, not checked against the text of ISO 8608; `roughness` sets another "
            "value"
        )
        warning = WarningMessage("recalled", sentence, {"roughness": self.G_d})
        return motion._replace(warnings=(*motion.warnings, warning))
