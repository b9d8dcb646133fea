"""Largest Lyapunov exponent of a motion under sines that does not become periodic.

Problem
    Such a motion may still settle slowly, be quasi-periodic or be chaotic. It is chaotic where
    small deviations grow on average, at the rate of the largest Lyapunov exponent.

Method
    A deviation follows the linearised motion exactly (`drysim.core.variational`). It is scaled
    back to unit length after some periods, and the logarithms of the lengths are its growth. No
    second motion at a finite distance is needed, and there is no difference of nearly equal
    numbers. The 95 % interval is that of the mean of blocks of periods.

Reference: P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with
discontinuities, Chaos, Solitons & Fractals 5 (1995) 1671.
"""

from __future__ import annotations

import math

import numpy as np

from drysim.approach.piecewise import compute_trajectory
from drysim.approach.solution import LyapunovExponent
from drysim.core.model import AnyState, CoulombLaw, DynamicLaw, Floats, PiecewiseLaw
from drysim.core.orbit import velocity_scale_rate
from drysim.orbits.coulomb import deviation_growth
from drysim.orbits.return_map import PeriodicSystem

BLOCKS, BLOCK_PERIODS = 32, 128
"""Blocks over which the growth of a deviation is averaged, and periods of the excitation in
each. One more block before them turns the deviation into its own direction."""

MARCHED_PERIODS = 8
"""Periods in one march, a divisor of `BLOCK_PERIODS`: their growth does not overflow."""

STUDENT_T = 2.0395
"""Half width of a 95 % interval of the mean of as many blocks, in standard errors."""

MIN_GROWTH = 10.0
"""Logarithmic growth of a deviation over all blocks [-], with 95 % confidence, above which a
motion is chaotic: a neutral one grows like a power of time at most."""


def lyapunov_exponent(scene: PeriodicSystem, start: AnyState) -> LyapunovExponent | None:
    """Return the largest Lyapunov exponent of a motion from its state after the transient.

    Parameters
    ----------
    scene : PeriodicSystem
    start : State or ContactState
        State at the beginning of a period.

    Returns
    -------
    LyapunovExponent or None
        None under a dynamic law; where the linearised motion is not defined, as at a grazing
        stop; and where the distance of two motions in the norm of the energy never grows, so
        that none is chaotic (`PeriodicSystem.has_one_motion`).
    """
    plant, law, motion, period = scene
    if isinstance(law, DynamicLaw) or scene.has_one_motion:
        return None
    periods = (1 + BLOCKS) * BLOCK_PERIODS
    if isinstance(law, CoulombLaw):
        growth = deviation_growth(plant, law, motion, start, period, periods)
    else:
        growth = marched_growth(scene, law, start, periods // MARCHED_PERIODS)
    rates = growth.reshape(1 + BLOCKS, -1)[1:].sum(axis=1) / (BLOCK_PERIODS * period)
    if not np.isfinite(rates).all():
        return None
    mean = float(rates.mean())
    half = STUDENT_T * float(rates.std(ddof=1)) / math.sqrt(BLOCKS)
    averaged = BLOCKS * BLOCK_PERIODS
    chaotic = (mean - half) * averaged * period > MIN_GROWTH
    return LyapunovExponent(mean, mean - half, mean + half, averaged, chaotic)


def marched_growth(
    scene: PeriodicSystem, law: PiecewiseLaw, state: AnyState, marches: int
) -> Floats:
    """Return the logarithmic growth of a deviation in each of some marches, as `coulomb` does.

    Each is of `MARCHED_PERIODS`. The deviation leaves the anchor of an elastic contact as it
    is, which keeps it for ever where the contact does not yield.
    """
    plant, _, motion, period = scene
    length, rate = MARCHED_PERIODS * period, velocity_scale_rate(plant, period)
    scale = np.array([1.0, rate, 1.0][: 3 if law.is_elastic else 2])
    deviation = np.array([1.0, 1.0, 0.0][: len(scale)]) / math.sqrt(2.0)
    growth = np.full(marches, np.nan)
    for n in range(marches):
        trajectory = compute_trajectory(plant, law, motion, state, length)
        state = trajectory.state(length)
        deviation = trajectory.monodromy() @ (deviation * scale) / scale
        size = float(np.linalg.norm(deviation))
        if not 0.0 < size < math.inf:
            growth[n] = -math.inf if size == 0.0 else math.nan
            break
        growth[n], deviation = math.log(size), deviation / size
    return growth
