"""Other stable motions of a scene: the starts that may lead to them, and what they lead to.

With F_fs > F_fk the motion from rest need not be the only one: a kicked mass may slide for ever
where one at rest sticks. Many starts are tried, and the motions that they lead to compared.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core import orbit
from drysim.core.forcing import F_FK, F_FS, K_X, V_R, X_R, B, M
from drysim.core.model import AnyState, CoulombLaw, Floats, Plant, Sines
from drysim.core.status import Status
from drysim.orbits.coulomb import scene_row, solve_orbits

START_SIZES, START_PHASES = (0.5, 1.0, 2.0), 4
"""Starts besides rest from which other motions are sought: the steady response without
friction, scaled, at phases within half its period. They lead to 99 % of the stable motions of
random scenes with F_fs > F_fk that 70 starts lead to."""

LARGEST_START = 20.0
"""Largest amplitude of a sine of this response, as a multiple of its static deflection: beside
resonance with little damping, where friction keeps every motion smaller."""


def orbit_starts(scenes: Floats) -> Floats:
    """Return starts from which different motions may be reached: x_r [m] and v_r [m/s].

    Parameters
    ----------
    scenes : ndarray, shape (n, SINES + 3 sines)
        As in `solve_orbits`.

    Returns
    -------
    ndarray, shape (starts, n, 2)
        Rest first.
    """
    m, k_x, b = (scenes[:, [column]] for column in (M, K_X, B))
    sines = scenes[:, orbit.SINES :]
    force, omega, phase = m * sines[:, ::3], math.tau * sines[:, 1::3], sines[:, 2::3]
    stiffness, least = k_x - m * omega**2 + 1j * b * omega, k_x / LARGEST_START
    swing = -force * np.exp(1j * phase)
    swing /= np.where(np.abs(stiffness) < least, 1j * least, stiffness)
    starts = [np.zeros((len(scenes), 2))]
    for share in START_SIZES:
        for i in range(START_PHASES):
            shifted = share * swing * np.exp(-1j * math.pi * i / START_PHASES)
            state = shifted.imag.sum(axis=1), (omega * shifted.real).sum(axis=1)
            starts.append(np.stack(state, axis=1))
    return np.array(starts)


def can_have_other_motions(scenes: Floats) -> NDArray[np.bool_]:
    """Whether different starts may lead to different motions, shape (n,).

    With F_fs = F_fk and a linear spring the distance of two motions never grows, in the energy
    norm, because the friction force is a monotone function of the velocity. All motions then
    approach the same one.
    """
    possible: NDArray[np.bool_] = scenes[:, F_FS] > scenes[:, F_FK]
    return possible


SAME_MOTION = 1e-3
"""Relative difference of sliding distance and mean squared velocity up to which two motions are
the same; mirror images agree in both, and one that settles slowly is close to its end."""


def are_different(first: Floats, other: Floats) -> NDArray[np.bool_]:
    """Whether the orbits of two arrays of answers are different motions, and both settled."""
    settled = (first[:, orbit.STATUS] == Status.OK) & (other[:, orbit.STATUS] == Status.OK)
    columns = [orbit.V2, orbit.SLIDING_DISTANCE]
    with np.errstate(invalid="ignore"):
        a, b = (
            answers[:, columns] / answers[:, [orbit.MULTIPLE]] for answers in (first, other)
        )
        apart = np.abs(a - b) > SAME_MOTION * np.maximum(np.abs(a), np.abs(b))
    different: NDArray[np.bool_] = settled & apart.any(axis=1)
    return different


class OtherMotion(NamedTuple):
    """Another stable motion of a scene: transmissibility [-] and largest |x_r| [m]."""

    T_a: float
    x_r_peak: float


def find_other_motions(
    plant: Plant, law: CoulombLaw, motion: Sines, start: AnyState, period: float
) -> tuple[list[OtherMotion], int]:
    """Return the stable motions that other starts lead to, and the number of these starts.

    Parameters
    ----------
    plant, law, motion, start
        The scene.
    period : float
        Period of the excitation [s].
    """
    row = scene_row(plant, law, motion, start, period)[None]
    starts = orbit_starts(row)[:, 0]
    rows = np.tile(row, (len(starts) + 1, 1))
    rows[1:, [X_R, V_R]] = starts
    distinct, *answers = solve_orbits(rows)[:, None]
    motions: list[OtherMotion] = []
    for answer in answers:
        if not are_different(distinct, np.tile(answer, (len(distinct), 1))).all():
            continue
        distinct = np.concatenate([distinct, answer])
        # A mass that sticks for ever does so at many positions.
        is_stuck = answer[0, orbit.SLIDING_DISTANCE] == 0.0
        T_a = 1.0 if is_stuck else math.sqrt(answer[0, orbit.X_DD2] / answer[0, orbit.U_DD2])
        peak = max(answer[0, orbit.HIGHEST], -answer[0, orbit.LOWEST])
        motions.append(OtherMotion(T_a, 0.0 if is_stuck else float(peak)))
    return motions, len(starts)
