"""Faults of measured channels, such as a wrong sign, that their transmissibility shows.

A mass on a spring and a damper has the transmissibility (ω_0² + 2jζω_0ω)/(ω_0² + 2jζω_0ω - ω²),
whatever ω_0 and ζ are. If the measured one comes much closer to such a curve once the
sign, the unit, the order or the lag of the channels is changed, that is most likely wrong. The
stroke is compared with the accelerations, of which it is the double integral.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drysim.core.model import Floats
from drysim.errors import WarningMessage
from drysim.metrics.comfort import Complexes
from drysim.metrics.spectra import TransferEstimate, excited_lines
from drysim.study.fit_warnings import (
    LAG_FAULT,
    MUCH_BETTER,
    SIGN_FAULT,
    SWAP_FAULT,
    UNIT_FAULT,
    WRONG_UNITS,
)
from drysim.wording import format_number

WRONG_MODEL = 0.1
"""Difference of the measured transmissibility from that of the closest oscillator, relative to
the measured one, from which a fault of the channels is looked for [-]. Dry friction alone makes
it 0.3."""

ITERATIONS = 10
"""Number of linear fits of an oscillator; each takes its weights from the one before."""

LONGEST_LAG = 20
"""Longest lag of the response that is tried, in samples."""

LEAST_PHASE = 0.6
"""Phase of a lag at the mean frequency of the base up to which friction may cause it [rad]: of
seats that stick most of the time it reaches 0.58."""

GAIN_TOLERANCE = 0.3
"""Relative distance from a factor of `WRONG_UNITS` within which the gain of the stroke is taken
for that factor [-]. It may be wide, since the factors are at least 10 apart."""


def fault_warning(
    transfer: TransferEstimate, stroke: TransferEstimate | None, dt: float
) -> WarningMessage | None:
    """Return the warning about the most likely fault of the channels; None if there is none.

    Parameters
    ----------
    transfer : TransferEstimate
        From the base to the mass.
    stroke : TransferEstimate or None
        From the base to the stroke x_r, at the same lines; None without a stroke.
    dt : float
        Step of the channels [s].
    """
    f, H, excited = transfer.f, transfer.H1, excited_lines(transfer.G_u)
    if excited.sum() < 3:
        return None
    error = oscillator_error(f, H, np.where(excited, transfer.G_u, 0.0))
    best, cause, numbers = error, "", {"difference": error}
    if error > WRONG_MODEL:
        for fault, other, weight in possible_faults(transfer, dt):
            if (other_error := oscillator_error(f, other, weight)) < best:
                best, cause = other_error, fault
    if best < MUCH_BETTER * min(error, 1.0) and cause:
        sentence = f"{cause}; the transmissibility is that of no mass on a spring and a damper"
        return WarningMessage("channels-suspect", sentence, numbers)
    if stroke is not None and (cause := fault_of_stroke(transfer, stroke)):
        return WarningMessage("channels-suspect", f"{cause}; the accelerations say so", {})
    return None


def possible_faults(
    transfer: TransferEstimate, dt: float
) -> Iterator[tuple[str, Complexes, Floats]]:
    """Yield usual faults, each with the transmissibility without it and the weights of lines.

    The transmissibility [-] and the weights, which are the PSD of the base where it moves
    [(m/s²)²/Hz], have shape (n,). `dt` is the step of the channels [s].
    """
    weight = np.where(excited_lines(transfer.G_u), transfer.G_u, 0.0)
    yield SIGN_FAULT.format(name="x_dd"), -transfer.H1, weight
    of_mass = np.where(excited_lines(transfer.G_x), transfer.G_x, 0.0)
    yield SWAP_FAULT, 1.0 / transfer.H2, of_mass
    for factor, fault in WRONG_UNITS["x_dd"].items():
        yield UNIT_FAULT.format(name="x_dd", size=fault), factor * transfer.H1, weight
    lag = closest_lag(transfer, weight, dt)
    if abs(2.0 * np.pi * lag * float(np.average(transfer.f, weights=weight))) > LEAST_PHASE:
        sentence = LAG_FAULT.format(lag=format_number(lag, "s", 3), remedy="state")
        yield sentence, without_lag(transfer, lag), weight


def without_lag(transfer: TransferEstimate, lag: float) -> Complexes:
    """Return the transmissibility H1 [-], shape (n,), of a response earlier by a lag [s]."""
    return np.asarray(transfer.H1 * np.exp(2j * np.pi * transfer.f * lag), dtype=np.complex128)


def closest_lag(transfer: TransferEstimate, weight: Floats, dt: float) -> float:
    """Return the lag [s] without which the transmissibility is closest to an oscillator's."""
    lags = dt * np.arange(-LONGEST_LAG, LONGEST_LAG + 1)
    errors = [oscillator_error(transfer.f, without_lag(transfer, lag), weight) for lag in lags]
    return float(lags[int(np.argmin(errors))])


def oscillator_error(f: Floats, H: Complexes, weight: Floats) -> float:
    """Return the RMS difference from the closest transmissibility of an oscillator [-].

    Parameters
    ----------
    f : ndarray, shape (n,)
        Frequencies [Hz].
    H : ndarray, shape (n,)
        Transmissibility [-].
    weight : ndarray, shape (n,)
        Weight of each line in the sum of squares; lines of weight 0 do not count.

    Returns
    -------
    float
        Relative to the RMS of H; infinite if no line counts, or if H is not finite at one that
        does.

    Notes
    -----
    (H - 1)(ω_0² + jωc) = H ω² is linear in ω_0² and c. Each fit is weighted by the denominator
    of the one before, so that the last one minimises the difference itself (Sanathanan and
    Koerner 1963).
    """
    lines = weight > 0.0
    if not lines.any() or not np.isfinite(H[lines]).all():
        return np.inf
    H, omega, root = H[lines], 2.0 * np.pi * f[lines], np.sqrt(weight[lines])
    omega = omega / omega.mean()
    fitted, scale = np.ones(len(H), dtype=complex), root
    for _ in range(ITERATIONS):
        columns = np.stack([H - 1.0, 1j * omega * (H - 1.0)], axis=1) * scale[:, None]
        stiffness, damping = positive_least_squares(columns, H * omega**2 * scale)
        carried = stiffness + 1j * omega * damping  # over the mass, of mean frequency 1
        denominator = carried - omega**2
        denominator[denominator == 0.0] = 1e-12
        fitted, scale = carried / denominator, root / np.abs(denominator)
    size = float(np.sum(np.square(root * np.abs(H))))
    # A spring stiffer than any, which is no solution of the equation, holds the mass.
    errors = [np.sum(np.square(root * np.abs(H - each))) for each in (fitted, 1.0)]
    return float(np.sqrt(min(errors) / size))


def positive_least_squares(columns: Complexes, values: Complexes) -> Floats:
    """Return the real factors p >= 0, shape (2,), that minimise |columns @ p - values|.

    `columns` has shape (n, 2), `values` has shape (n,). Without the bounds the minimum is that
    of least squares; if it violates them, one factor is 0.
    """
    A = np.concatenate([columns.real, columns.imag])
    y = np.concatenate([values.real, values.imag])
    factors: Floats = np.linalg.lstsq(A, y, rcond=None)[0]
    if (factors >= 0.0).all():
        return factors
    squares = np.maximum(np.sum(np.square(A), axis=0), 1e-300)
    single = np.maximum(A.T @ y, 0.0) / squares
    gains = single * (A.T @ y)  # by how much each alone lowers the sum of squares
    return np.where(gains == gains.max(), single, 0.0)


def fault_of_stroke(transfer: TransferEstimate, stroke: TransferEstimate) -> str:
    """Return the fault of the stroke that the accelerations show; empty if there is none.

    As the second derivative of x_r is x_dd - u_dd, the transmissibility from the base to the
    stroke is -(H1 - 1)/ω² [s²]. The gain that brings the measured one closest to it, by least
    squares weighted by the PSD of the base, is 1 if the stroke is right.
    """
    lines = excited_lines(transfer.G_u)
    expected = -(transfer.H1[lines] - 1.0) / np.square(2.0 * np.pi * transfer.f[lines])
    root = np.sqrt(transfer.G_u[lines])
    H = stroke.H1[lines] * root
    power = float(np.sum(np.square(np.abs(H))))
    gain = float(np.sum((np.conj(H) * expected * root).real)) / power if power else 1.0
    if abs(gain + 1.0) < GAIN_TOLERANCE:
        return SIGN_FAULT.format(name="x_r")
    for factor, fault in WRONG_UNITS["x_r"].items():
        if abs(gain / factor - 1.0) < GAIN_TOLERANCE:
            return UNIT_FAULT.format(name="x_r", size=fault)
    return ""
