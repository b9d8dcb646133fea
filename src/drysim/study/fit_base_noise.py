"""What the noise of the base record adds to the residuals of a fit, and to its intervals.

Problem
    The computed motion follows the *measured* base, whose noise e_b passes through the
    oscillator: to first order the residuals are e - G e_b, with G the response to the base.
    Where the mass slides this is slow, as the motion is, and far larger in the band that
    decides over the parameters than its RMS tells. The inverse of J'J takes the residuals for
    white and is then too small.

Method
    1. The response to the noise is that of the fitted motion itself: noise is drawn, added to
       the base record, and the motion solved anew. The changes d_i of the residuals contain
       the shifts of stops and break-aways, too.
    2. The residuals have the spectrum a S_w + b S_d, with S_w that of white noise and S_d that
       of the d_i, both without the part that the fit of the parameters takes away.
       The shares a (of each channel) and b maximise Whittle's likelihood, by Fisher scoring:
       least squares of the periodogram, weighted by the spectrum itself. Stated noise is a
       share that is given. Otherwise the noise of the base is that which the fourth
       differences of its record show, unless the residuals contradict: then the motion itself
       is rough, and the residuals tell the noise.
    3. The least-squares estimate has the covariance P J' C J P with P = (J'J)^-1 and C the
       covariance of the residuals ("sandwich"; Huber 1967, White 1980).
    4. In a profile the rise of the sum of squares is compared with the quantile of chi-square
       times the ratio of both variances of the parameter, as for a composite likelihood (Pace,
       Salvan and Sartori 2011, Statistica Sinica 21, 129; Chandler and Bate 2007, Biometrika
       94, 167).
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats, Samples
from drysim.errors import SolverError
from drysim.parallel import WorkerPool
from drysim.study.fit_least_squares import NOISELESS, OUTLIER, Solution
from drysim.study.starting_values import noise_level
from drysim.study.statistics import NORMAL_95

NOISES, FEW_NOISES, PILOT_NOISES = 256, 64, 16
"""Number of drawn noises; of those that tell the samples to select, and the size of the noise.
With 256 the standard deviation that the noise adds to a parameter is known to 4 %."""

CONTRADICTED, ROUGH = 5.0, 0.05
"""Standard deviations, by the ratio of likelihoods, from which residuals contradict the noise
of the base record, and the largest share of it that they then leave: of a rough motion it is
far less. Noise that is taken for too small makes intervals too narrow, and where stops are just
made or missed its changes seem larger than they are, as a fit chooses among them."""

SEED = 2011
"""Seed of the noises, with the number of the draw."""

SCORINGS = 30
"""Number of steps of Fisher scoring."""

LEAST_FREEDOM, MOST_FREEDOM = 5.0, 1e6
"""Bounds of the degrees of freedom of a variance."""

SMALLEST_SPECTRUM = 1e-9
"""Spectrum of the residuals, relative to its largest value, below which a bin has no more
weight."""


SMALLEST_PERIODOGRAM = 1e-100
"""Periodogram that counts as none."""


class BaseNoise(NamedTuple):
    """Noise of the base record, and the residuals that it leaves."""

    level: float
    """Standard deviation of each sample [m/s²]."""
    is_stated: bool
    spectra: Floats
    """Expected periodogram of the residuals of each channel, shape (channels, bins)."""

    def lag_correlation(self, channel: int) -> float:
        """Return the expected correlation of neighbouring residuals of a channel."""
        power = self.spectra[channel]
        angles = np.linspace(0.0, np.pi, len(power) + 1)[1:]
        return float(np.sum(power * np.cos(angles)) / np.sum(power))


class Changes(NamedTuple):
    """What drawn noises of the base record change."""

    spectra: Floats
    """Spectrum of the changed residuals in each channel, shape (channels, bins): the geometric
    mean of periodograms, whose logarithms are too low by Euler's constant. A mean would be that
    of the few noises by which the motion makes a stop more or less."""
    errors: Floats
    """Errors of the scaled parameters, shape (draws, p); 0 where no motion can be solved."""


class Shares(NamedTuple):
    """Shares of the noise of each channel and of the base, and how well they are known."""

    shares: Floats
    """Share of each channel's noise in its residuals, and that of the base noise."""
    covariance: Floats
    """That of the shares, 0 for stated ones."""
    log_likelihood: float
    """Whittle's, up to a constant."""


def drawn_noise(level: float, number: int, count: int) -> Floats:
    """Return a drawn noise of the base: `count` samples of a standard deviation."""
    noise: Floats = level * np.random.default_rng((SEED, number)).normal(size=count)
    return noise


def with_base_noise(
    solution: Solution, pool: WorkerPool, noises: int = NOISES
) -> tuple[Solution, BaseNoise | None]:
    """Return the solution with its covariance under noise of the base record, and this noise.

    There is none if the base is not a record, as that of a rig or of a formula. The pool
    solves the motions with a number of drawn noises.
    """
    model = solution.squares.model
    motion = model.motion
    if not model.has_recorded_base:
        return solution, None
    assert isinstance(motion, Samples), "a record has samples"
    stated = getattr(model.fit.noise, "u_dd", None)
    level, given = stated, None if stated is None else 1.0
    if level is None:
        u_dd = np.asarray(motion.u_dd[:])
        level = noise_level(u_dd)
        if level <= NOISELESS * float(np.abs(u_dd).max()):  # the curvature of the motion
            return solution, BaseNoise(0.0, False, white_spectra(solution))
        seen = changes_under(solution, level, PILOT_NOISES, pool)
        likely, stated_share = (
            noise_shares(solution, seen.spectra, share) for share in (None, 1.0)
        )
        gain = 2.0 * (likely.log_likelihood - stated_share.log_likelihood)
        if gain < CONTRADICTED**2 or likely.shares[-1] > ROUGH:
            given = 1.0
        else:
            level *= float(np.sqrt(likely.shares[-1]))
    white = white_spectra(solution)
    if level == 0.0:
        return solution, BaseNoise(0.0, stated is not None, white)
    changes = changes_under(solution, level, noises, pool)
    likely = noise_shares(solution, changes.spectra, given)
    shares = likely.shares
    robust, base_errors = sandwich(solution, changes, likely)
    noise = BaseNoise(
        level * float(np.sqrt(shares[-1])),
        stated is not None,
        shares[:-1, None] * white + shares[-1] * changes.spectra,
    )
    return solution._replace(robust_covariance=robust, base_errors=base_errors), noise


def sandwich(solution: Solution, changes: Changes, likely: Shares) -> tuple[Floats, Floats]:
    """Return covariance of the parameters for shares of noise, and errors by noise of the base.

    Both are widened as the quantile of Student's t exceeds that of a normal distribution: the
    variance is itself an estimate, of few degrees of freedom (Satterthwaite 1946, Biometrics
    Bulletin 2, 110).
    """
    from scipy.special import stdtrit

    shares, samples = likely.shares, int(solution.mask.sum())
    bread = solution.covariance
    channels = solution.jacobian.reshape(-1, samples, len(bread))
    parts = np.array([bread @ (rows.T @ rows) @ bread for rows in channels])
    base = changes.errors.T @ changes.errors / np.count_nonzero(changes.errors.any(axis=1))
    parts = np.append(parts, base[None], axis=0)
    robust: Floats = np.tensordot(shares, parts, axes=1)
    diagonals = np.diagonal(parts, axis1=1, axis2=2)
    variance = np.einsum("ij,ik,kj->j", diagonals, likely.covariance, diagonals)
    variance += 2.0 / len(changes.errors) * (shares[-1] * diagonals[-1]) ** 2
    freedom = 2.0 * np.diag(robust) ** 2 / np.maximum(variance, 1e-300)
    wider = stdtrit(np.clip(freedom, LEAST_FREEDOM, MOST_FREEDOM), 0.975) / NORMAL_95
    return robust * np.outer(wider, wider), np.sqrt(shares[-1]) * changes.errors * wider


def changes_under(solution: Solution, level: float, draws: int, pool: WorkerPool) -> Changes:
    """Return what white noise of the base record changes.

    Raises
    ------
    SolverError
        If no motion with drawn noise can be solved.
    """
    model = solution.squares.model
    fitted = solution.squares.solve(solution.x)
    assert fitted is not None, "the solution was solved before"
    change = partial(
        change_under,
        solution,
        level,
        fitted.modes,
        solution.squares.residuals(fitted, solution.mask),
        tangent_basis(solution),
    )
    shared = model.motion, model.measurement
    total, errors = np.zeros(()), np.zeros((draws, len(solution.x)))
    solved = 0
    for number, each in enumerate(pool.map_in_order(change, range(draws), shared)):
        if each is not None:
            spectra, errors[number] = each
            total = total + np.log(np.maximum(spectra, SMALLEST_PERIODOGRAM))
            solved += 1
    if not solved:
        raise SolverError(
            f"no motion can be solved under noise of the base of {level:.3g} m/s²; "
            "`fit.noise.u_dd: 0` takes the base as exact"
        )
    return Changes(np.exp(total / solved + np.euler_gamma), errors)


def change_under(
    solution: Solution,
    level: float,
    modes: NDArray[np.int8],
    residuals: Floats,
    basis: Floats,
    number: int,
) -> tuple[Floats, Floats] | None:
    """Return the periodograms and the step of one drawn noise; None if it cannot be solved.

    Parameters
    ----------
    solution : Solution
    level : float
        Standard deviation of the noise [m/s²].
    modes, residuals : ndarray
        Those of the solution.
    basis : ndarray
        Its `tangent_basis`.
    number : int
        Of the draw.
    """
    squares, mask = solution.squares, solution.mask
    motion = squares.model.motion
    assert isinstance(motion, Samples), "the base is recorded"
    u_dd = np.asarray(motion.u_dd[:])
    noisy = motion._replace(u_dd=u_dd + drawn_noise(level, number, len(u_dd)), u=None)
    solved = replace(squares, model=replace(squares.model, motion=noisy)).solve(solution.x)
    if solved is None:
        return None
    change = squares.residuals(solved, mask) - residuals
    # A measured sample at which an event passes is an outlier, and not selected.
    same = (solved.modes == modes)[mask]
    same = np.tile(same, len(change) // len(same))
    change[~same | (np.abs(change) > OUTLIER)] = 0.0
    step = solution.covariance @ (solution.jacobian.T @ change)
    beside = change - basis @ (basis.T @ change)
    return periodograms(solution, beside), step


def tangent_basis(solution: Solution) -> Floats:
    """Return an orthonormal basis of the changes of the residuals that parameters make."""
    from scipy.linalg import orth

    basis: Floats = orth(solution.jacobian[:, solution.jacobian.any(axis=0)])
    return basis


def periodograms(solution: Solution, residuals: Floats) -> Floats:
    """Return the periodogram of the selected residuals of each channel; the others count as 0.

    White residuals of variance 1 have about the value 1 in each bin, less with few samples
    selected. The mean is left out.
    """
    mask, rows = solution.mask, residuals.reshape(-1, int(solution.mask.sum()))
    series = np.zeros((len(rows), len(mask)))
    series[:, mask] = rows
    spectra: Floats = np.abs(np.fft.rfft(series, axis=1)[:, 1:]) ** 2 / len(mask)
    return spectra


def white_spectra(solution: Solution) -> Floats:
    """Return the expected periodograms of white noise, less what the parameters take away."""
    columns = (periodograms(solution, column) for column in tangent_basis(solution).T)
    spectra: Floats = np.mean(solution.mask) - np.sum([*columns], axis=0)
    return spectra


def noise_shares(solution: Solution, spectra: Floats, base: float | None = None) -> Shares:
    """Return the most likely shares.

    A share that is stated is 1, as that of a channel whose noise the file states.

    Parameters
    ----------
    solution : Solution
    spectra : ndarray, shape (channels, bins)
        Periodograms of what the base noise changes.
    base : float, optional
        Share of the base noise; default: the most likely one.
    """
    from scipy.optimize import nnls

    squares = solution.squares
    stated = squares.model.fit.noise
    residuals = squares.residuals(squares.solve(solution.x), solution.mask)
    power, white = periodograms(solution, residuals), white_spectra(solution)
    count, bins = power.shape
    terms = np.zeros((count + 1, count, bins))
    terms[np.arange(count), np.arange(count)] = white
    terms[count] = spectra
    terms, wanted = terms.reshape(count + 1, -1).T, power.ravel()
    known = [1.0 if getattr(stated, name, None) else None for name in squares.model.compared]
    fixed = np.array([value is not None for value in (*known, base)])
    shares, spread = np.ones(count + 1), np.zeros((count + 1, count + 1))

    def spectrum() -> Floats:
        mixed = terms @ shares
        expected: Floats = np.maximum(mixed, SMALLEST_SPECTRUM * mixed.max())
        return expected

    for _ in range(SCORINGS):
        if fixed.all():
            break
        expected = spectrum()
        left = wanted - terms[:, fixed] @ shares[fixed]
        shares[~fixed] = nnls(terms[:, ~fixed] / expected[:, None], left / expected)[0]
    expected = spectrum()
    information = terms[:, ~fixed] / expected[:, None]
    spread[np.ix_(~fixed, ~fixed)] = np.linalg.pinv(information.T @ information)
    return Shares(shares, spread, -float(np.sum(np.log(expected) + wanted / expected)))
