"""A record on another grid, on request: between its samples by a stated way, never folded."""

from __future__ import annotations

from math import asin, ceil, floor, sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from drysim.core.motion import Samples
from drysim.core.signal import BLOCK, Signal
from drysim.errors import RecordError
from drysim.excitation.record.columns import Floats
from drysim.excitation.record.file import fault, fit
from drysim.excitation.record.filters import gain
from drysim.excitation.record.gaps import between
from drysim.excitation.record.grid import Grid
from drysim.excitation.record.reports import Report, report
from drysim.excitation.record.shape import Series

if TYPE_CHECKING:
    from drysim.excitation.record.spoken import Removal, Resample

ALIAS = 0.1
"""What a low-pass may leave of an amplitude at half the new rate: a tenth, 20 dB down."""

CLEAR = 0.99
"""Share of the highest frequency of such a low-pass that a message names in few digits."""

SAME = 1e-9
"""Two steps this close, relative to them, are one."""

LOST = 0.01
"""Share of the RMS that straight lines between samples may take before it is said [-]."""

SAME_UNEVEN = 1e-2
"""The same against the mean of uneven steps: their half rate is no sharper than that."""


class Onto(NamedTuple):
    """A grid that is `times` as fine as the one that was asked for, and that one's step [s].

    A record that loses rate is filtered in between, on the finer grid.
    """

    step: float
    times: int


def target(wanted: Resample, removal: Removal, grid: Grid, shown: str) -> Onto:
    """Give the grid to go by: as fine as the record's own, or finer.

    Raises
    ------
    RecordError
        When frequencies would fold, because no low-pass is stated that keeps them out.
    """
    step = wanted.step or 1 / (wanted.rate or 1.0)
    same = SAME if grid.spread is None else SAME_UNEVEN
    times = max(1, ceil(step / grid.dt * (1 - same)))
    if times > 1:
        half, order = 1 / (2 * step), removal.order
        if removal.above is None or gain(half, removal.above, order) > ALIAS * (1 + SAME):
            raise _folding(half, order, grid, shown)
    return Onto(step, times)


def _folding(half: float, order: int, grid: Grid, shown: str) -> RecordError:
    """Give the error for a loss of rate without the filter for it."""
    most = half * (1 / ALIAS - 1) ** (-1 / (2 * order))
    sentence = (
        f"resampling from {1 / grid.dt:.6g} to {2 * half:.6g} Hz would fold what is above "
        f"{half:.6g} Hz; state a low-pass that leaves a tenth of it or less there, "
        f"`remove: {{above: {CLEAR * most:.3g} Hz, order: {order}}}` or lower"
    )
    return fault(shown, sentence)


def onto(values: Floats, grid: Grid, wanted: Resample, goal: Onto, shown: str) -> Series:
    """Give samples on the grid to go by, which ends where the record does."""
    at, fine = grid.at, goal.step / goal.times
    n = len(values)
    length = (n - 1.0 if at is None else float(at[-1])) * grid.dt
    count = floor(length / fine * (1 + SAME)) + 1
    if at is None and abs(fine / grid.dt - 1) <= SAME:
        return Series(values, fine, grid.first)
    fit(shown, 8 * count)
    if count < 2:
        raise fault(shown, f"the record lasts {length:.6g} s, less than `resample` asks for")
    places = np.minimum(np.arange(count) * (fine / grid.dt), length / grid.dt)
    own = np.arange(float(n)) if at is None else at
    return Series(between(own, values, places, wanted.by), fine, grid.first)


def thinned(series: Series, goal: Onto) -> Series:
    """Give every sample that lies on the grid that was asked for."""
    return series._replace(values=series.values[:: goal.times].copy(), dt=goal.step)


def told(
    before: Floats, grid: Grid, after: Series, goal: Onto, wanted: Resample, unit: str
) -> Report:
    """Give the report of a resampling: samples as they were, and between them."""
    numbers = {"step_before": grid.dt, "step_after": goal.step}
    was = f"{1 / grid.dt:.6g} Hz"
    if grid.spread is not None:
        least, most = grid.spread
        numbers |= {"least_step": least, "greatest_step": most}
        was = f"uneven steps of {least:.4g} to {most:.4g} s, {grid.dt:.4g} s in the mean,"
    sentence = f"resampled from {was} to {1 / goal.step:.6g} Hz by {wanted.by}s"
    return report("resample", sentence, before, after.values[:], unit, numbers)


def kept_by_lines(values: Signal, rms: float) -> float:
    """Return the share of the RMS of samples about their mean that linear interpolation keeps.

    Notes
    -----
    A signal sampled above twice its highest frequency has the RMS of its samples. Of the mean
    square, straight lines lose a sixth of that of the steps from sample to sample: of a sine of
    frequency f, the share 2/3 sin²(π f dt).
    """
    square, steps = rms * rms, 0.0
    for at in range(0, len(values) - 1, BLOCK):
        steps += float(np.square(np.diff(values[at : at + BLOCK + 1])).sum())
    lost = steps / (len(values) - 1) / 6
    return sqrt(max(0.0, 1 - lost / square)) if square else 1.0


def finer(kept: float) -> int:
    """Return how many times finer a grid must be so that straight lines lose a hundredth.

    The samples count as a sine of the frequency at which lines keep this share of the RMS.
    """
    half_turns = [asin(sqrt(min(1.0, 1.5 * (1 - share**2)))) for share in (kept, 1 - LOST)]
    return ceil(half_turns[0] / half_turns[1] * (1 + SAME)) + 1


def kept_by_spline(values: Signal) -> float:
    """Return the share of the RMS about the mean that a cubic spline through samples keeps.

    Notes
    -----
    By their power spectrum: of a sine sampled with z = 2π f dt the spline has the mean square
    B7/B3², with the spectra of the sampled B-splines of degree 7 and 3; see Unser, Splines: a
    perfect fit for signal and image processing (1999). Of a long signal the beginning counts.
    """
    z, power = _spectrum(values[:BLOCK])
    seventh = 2416 + 2382 * np.cos(z) + 240 * np.cos(2 * z) + 2 * np.cos(3 * z)
    kept = power @ (seventh / 5040 * (3 / (2 + np.cos(z))) ** 2)
    return sqrt(kept / power.sum())


def kept_by_splines(motion: Samples, quantity: str, own: float, by: str) -> float:
    """Return the share of RMS{ü} that is left of a record of velocity or displacement.

    Parameters
    ----------
    motion : Samples
        ü from the spline of its quantity.
    quantity : str
        `velocity` or `displacement`.
    own : float
        Step of the samples in the file [s].
    by : str
        How they were resampled, where their step in `motion` is a finer one.

    Notes
    -----
    By the power spectrum of ü and the gain of splines through a sine of z = 2π f dt. Up to a
    quarter of the rate, a spline steepens a sine by as much as the lines between the knots of
    its derivative lose. Resampled, what is above half of the old rate is an image of the rest.
    """
    every = 2 if quantity == "velocity" else 1  # ü bends between the samples of velocity
    dt = motion.dt * every
    z, power = _spectrum(motion.u_dd[every - 1 :: every])
    if own > dt * (1 + SAME):
        z *= own / dt
        power, images, z = power[z < np.pi], power[z >= np.pi].sum(), z[z < np.pi]
        gain = np.sinc(z / 2 / np.pi) ** 2
        if by == "spline":
            gain *= gain * 3 / (2 + np.cos(z))
        kept = power.sum() + images
    elif quantity == "displacement":
        gain = 6 * (1 - np.cos(z)) / (2 + np.cos(z)) / z**2
        kept = (power * (1 - 2 / 3 * np.sin(z / 2) ** 2)).sum()
    else:
        gain = 8 * np.sin(z / 2) / (3 + np.cos(z)) / z
        kept = (power * (1 - 2 / 3 * np.sin(z / 2) ** 2)).sum()
    whole = (power / gain**2).sum()
    return float(np.sqrt(kept / whole)) if whole else 1.0


def _spectrum(values: Floats) -> tuple[Floats, Floats]:
    """Return the angles z = 2π f dt above 0, and the power of samples at each."""
    power = np.asarray(np.square(np.abs(np.fft.rfft(values)[1:])), dtype=np.float64)
    z = 2 * np.pi / len(values) * np.arange(1.0, len(power) + 1)
    return z, power
