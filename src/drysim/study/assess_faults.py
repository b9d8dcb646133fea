"""Faults of measured channels, such as a wrong sign, that their transmissibility shows.

A mass on a spring and a damper has the transmissibility (ω_0² + 2jζω_0ω)/(ω_0² + 2jζω_0ω - ω²),
whatever ω_0 and ζ are. If the measured one comes much closer to such a curve once the
sign, the unit, the order or the lag of the channels is changed, that is most likely wrong. The
stroke is compared with the accelerations, of which it is the double integral. Records of
different runs, or of clocks far apart, have next to no coherence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from drysim.core.model import Floats
from drysim.errors import WarningMessage
from drysim.metrics.comfort import Complexes
from drysim.metrics.spectra import TransferEstimate, excited_lines, transfer_estimate
from drysim.study.fit_warnings import (
    LAG_FAULT,
    MUCH_BETTER,
    SWAP_FAULT,
    UNIT_FAULT,
    WRONG_UNITS,
    sign_fault,
)
from drysim.wording import format_number

WRONG_MODEL = 0.15
"""Difference of the measured transmissibility from that of the closest oscillator, relative to
the measured one, from which a fault of the channels is looked for [-]. Dry friction alone makes
it 0.3, and the few wide lines of a short record on a narrow band 0.14."""

ITERATIONS = 10
"""Number of linear fits of an oscillator; each takes its weights from the one before."""

MOST_COHERENT = 0.3
"""Mean coherence from which base and mass are related, however few the averages [-]. With
friction a seat has 0.7 or more."""

CLEAR_PEAK = 4.5
"""Peak of the cross-correlation over its RMS from which it shows a lag [-]. Unrelated records
reach 3.2; those of a seat on a narrow band, 20 s long, have at least 5.4."""

LAG_RANGE, LAG_STEPS = 0.4, 20
"""Lags to either side of the peak of the cross-correlation that are tried, in mean periods of
the base, and steps to them. The peak includes the phase of the mount; a whole period off, the
next such peak follows."""

LEAST_PHASE = 0.6
"""Phase of a lag at the mean frequency of the base up to which friction may cause it [rad]: of
seats that stick most of the time it reaches 0.58."""

GAIN_TOLERANCE = 0.3
"""Relative distance from a factor of `WRONG_UNITS` within which the gain of the stroke is taken
for that factor [-]. It may be wide, since the factors are at least 10 apart."""


def fault_warning(
    u_dd: Floats,
    x_dd: Floats,
    dt: float,
    transfer: TransferEstimate,
    stroke: TransferEstimate | None,
    scales: Mapping[str, float],
) -> WarningMessage | None:
    """Return the warning about the most likely fault of the channels; None if there is none.

    Parameters
    ----------
    u_dd, x_dd : ndarray, shape (n,)
        Samples of base and mass [m/s²].
    dt : float
        Step of the samples [s].
    transfer : TransferEstimate
        From the base to the mass.
    stroke : TransferEstimate or None
        From the base to the stroke x_r, at the same lines; None without a stroke.
    scales : mapping
        Stated factor of each channel [-].
    """
    f, H, excited = transfer.f, transfer.H1, excited_lines(transfer.G_u)
    if excited.sum() < 3 or not (transfer.G_x[excited] > 0.0).all():
        return None
    if (coherence := mean_coherence(transfer)) < chance_coherence(transfer):
        numbers = {"coherence": coherence}
        shift = coarse_lag(u_dd, x_dd, transfer, dt)
        if not shift:
            sentence = (
                "base and mass seem to be unrelated: check files, columns and time axes; their "
                f"coherence is {format_number(coherence, digits=2)}, as by chance"
            )
            return WarningMessage("channels-suspect", sentence, numbers)
        cause = describe_lag(lagged_transfer(u_dd, x_dd, dt, transfer, shift)[0])
        sentence = f"{cause}; without it base and mass seem to be unrelated"
        return WarningMessage("channels-suspect", sentence, numbers)
    error = oscillator_error(f, H, np.where(excited, transfer.G_u, 0.0))
    best, cause, numbers = error, "", {"difference": error}
    if error > WRONG_MODEL:
        for fault, other, weight in possible_faults(u_dd, x_dd, dt, transfer, scales):
            if (other_error := oscillator_error(f, other, weight)) < best:
                best, cause = other_error, fault
    if best < MUCH_BETTER * min(error, 1.0) and cause:
        sentence = f"{cause}; the transmissibility is that of no mass on a spring and a damper"
        return WarningMessage("channels-suspect", sentence, numbers)
    if stroke is not None and (cause := fault_of_stroke(transfer, stroke, scales["x_r"])):
        return WarningMessage("channels-suspect", f"{cause}; the accelerations say so", {})
    return None


def mean_coherence(transfer: TransferEstimate) -> float:
    """Return the mean coherence of the excited lines [-].

    It is weighted by the PSD of the base or by that of the mass, whichever gives more: a mount
    may isolate the strongest line.
    """
    lines = excited_lines(transfer.G_u)
    power = [each[lines] for each in (transfer.G_u, transfer.G_x)]
    return max(float(np.average(transfer.coherence[lines], weights=each)) for each in power)


def chance_coherence(transfer: TransferEstimate) -> float:
    """Return the coherence that unrelated records exceed at 1 % of the lines [-], at most 0.3.

    With n independent averages it is 1 - 0.01^(1/(n - 1)) (Bendat and Piersol 2010); their mean
    is 1/n.
    """
    freedom = transfer.averages - 1.0
    return min(1.0 - 0.01 ** (1.0 / freedom), MOST_COHERENT) if freedom > 0.0 else 0.0


def possible_faults(
    u_dd: Floats,
    x_dd: Floats,
    dt: float,
    transfer: TransferEstimate,
    scales: Mapping[str, float],
) -> Iterator[tuple[str, Complexes, Floats]]:
    """Yield usual faults, each with the transmissibility without it and the weights of lines.

    The transmissibility [-] and the weights, which are the PSD of the base where it moves
    [(m/s²)²/Hz], have shape (n,). The parameters are those of `fault_warning`.
    """
    weight = np.where(excited_lines(transfer.G_u), transfer.G_u, 0.0)
    yield sign_fault("x_dd", scales["x_dd"]), -transfer.H1, weight
    of_mass = np.where(excited_lines(transfer.G_x), transfer.G_x, 0.0)
    yield SWAP_FAULT, 1.0 / transfer.H2, of_mass
    for factor, fault in WRONG_UNITS["x_dd"].items():
        yield UNIT_FAULT.format(name="x_dd", size=fault), factor * transfer.H1, weight
    shift = coarse_lag(u_dd, x_dd, transfer, dt)
    lag, H, of_base = lagged_transfer(u_dd, x_dd, dt, transfer, shift)
    if abs(2.0 * np.pi * lag * mean_frequency(transfer)) > LEAST_PHASE:
        yield describe_lag(lag), H, of_base


def describe_lag(lag: float) -> str:
    """Return a lag of the response [s] in words.

    It is not precise: friction changes the phase of a mount as a lag does.
    """
    return LAG_FAULT.format(lag=f"about {format_number(lag, 's', 2)}", remedy="add it to")


def mean_frequency(transfer: TransferEstimate) -> float:
    """Return the mean frequency of the base at its excited lines [Hz]."""
    lines = excited_lines(transfer.G_u)
    return float(np.average(transfer.f[lines], weights=transfer.G_u[lines]))


def coarse_lag(u_dd: Floats, x_dd: Floats, transfer: TransferEstimate, dt: float) -> int:
    """Return the lag of the peak of the cross-correlation, in samples; 0 if none is clear.

    It is at most half the record, and leaves two segments.
    """
    n = len(u_dd)
    limit = min(n // 2, n - 2 * round(transfer.segment / dt))
    U, X = (np.fft.rfft(series - series.mean()) for series in (u_dd, x_dd))
    correlation = np.abs(np.fft.irfft(np.conj(U) * X, n))
    lags = (np.arange(n) + n // 2) % n - n // 2
    within = np.where(np.abs(lags) <= limit, correlation, 0.0)
    peak = int(np.argmax(within))
    is_clear = within[peak] > CLEAR_PEAK * np.sqrt(np.mean(np.square(correlation)))
    return int(lags[peak]) if is_clear else 0


def lagged_transfer(
    u_dd: Floats, x_dd: Floats, dt: float, transfer: TransferEstimate, shift: int
) -> tuple[float, Complexes, Floats]:
    """Return the lag [s] near a shift [samples] without which an oscillator is closest.

    And the transmissibility H1 [-] without it and the weights of its lines, of shape (n,).
    """
    n, late, early = len(u_dd), max(shift, 0), max(-shift, 0)
    u_dd, x_dd = u_dd[early : n - late], x_dd[late : n - early]
    shifted = transfer_estimate(u_dd, x_dd, dt, transfer.segment)
    weight = np.where(excited_lines(shifted.G_u), shifted.G_u, 0.0)
    lag, step = 0.0, LAG_RANGE / mean_frequency(shifted) / LAG_STEPS
    for width in (step, step / LAG_STEPS):
        lags = lag + width * np.arange(-LAG_STEPS, LAG_STEPS + 1)
        without = [without_lag(shifted, each) for each in lags]
        errors = [oscillator_error(shifted.f, H1, weight) for H1 in without]
        lag = float(lags[int(np.argmin(errors))])
    return shift * dt + lag, without_lag(shifted, lag), weight


def without_lag(transfer: TransferEstimate, lag: float) -> Complexes:
    """Return the transmissibility H1 [-], shape (n,), of a response earlier by a lag [s]."""
    return np.asarray(transfer.H1 * np.exp(2j * np.pi * transfer.f * lag), dtype=np.complex128)


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


def fault_of_stroke(transfer: TransferEstimate, stroke: TransferEstimate, scale: float) -> str:
    """Return the fault of the stroke that the accelerations show; empty if there is none.

    As the second derivative of x_r is x_dd - u_dd, the transmissibility from the base to the
    stroke is -(H1 - 1)/ω² [s²]. The gain that brings the measured one closest to it, by least
    squares weighted by the PSD of the base, is 1 if the stroke is right.
    `scale` is its stated factor [-].
    """
    lines = excited_lines(transfer.G_u)
    expected = -(transfer.H1[lines] - 1.0) / np.square(2.0 * np.pi * transfer.f[lines])
    root = np.sqrt(transfer.G_u[lines])
    H = stroke.H1[lines] * root
    power = float(np.sum(np.square(np.abs(H))))
    gain = float(np.sum((np.conj(H) * expected * root).real)) / power if power else 1.0
    if abs(gain + 1.0) < GAIN_TOLERANCE:
        return sign_fault("x_r", scale)
    for factor, fault in WRONG_UNITS["x_r"].items():
        if abs(gain / factor - 1.0) < GAIN_TOLERANCE:
            return UNIT_FAULT.format(name="x_r", size=fault)
    return ""
