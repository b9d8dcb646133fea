"""Frequency weightings of whole-body vibration, ISO 2631-1 in the filter form of ISO 8041."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

HIGH_PASS, LOW_PASS = 0.4, 100.0
"""Corners of the band limits that all weightings share, both Butterworth of order two [Hz]."""


class Filter(NamedTuple):
    """A weighting inside its band limits.

    Attributes
    ----------
    f_3, Q_4 : float
        Corner [Hz] and resonance [-] of the transition from acceleration to velocity; f4 = f3.
    step : tuple of float, or None
        f5 [Hz], Q5, f6 [Hz], Q6 of the upward step; None for none.
    """

    f_3: float
    Q_4: float
    step: tuple[float, float, float, float] | None = None


WEIGHTINGS = {
    "Wk": Filter(12.5, 0.63, (2.37, 0.91, 3.35, 0.91)),
    "Wd": Filter(2.0, 0.63),
    "Wc": Filter(8.0, 0.63),
}
"""Wk: a seat, vertical. Wd: a seat, horizontal. Wc: a backrest, fore and aft."""

DIRECTIONS = {"vertical": ("Wk", 1.0), "horizontal": ("Wd", 1.4)}
"""Weighting and multiplying factor k [-] of a seat's directions."""

RECALLED = ("horizontal",)
"""Directions whose k is recalled and was not checked against the text of ISO 2631-1."""


def gain(name: str, f: Floats) -> Complexes:
    """Give the complex gain W of a weighting at frequencies.

    Parameters
    ----------
    name : str
        One of `WEIGHTINGS`.
    f : ndarray
        Frequencies [Hz]; 0 has gain 0.

    Returns
    -------
    ndarray of complex
        W = H_hp H_lp H_t H_s [-], shape of `f`.

    Notes
    -----
    The analogue formula itself. Not to be confused with the rounded tables of the standard, or
    with a digital filter, which departs from both towards half of its sampling rate.
    """
    f_3, Q_4, step = WEIGHTINGS[name]
    j: Complexes = (1j * f).astype(np.complex128)  # s/2π
    W = j * j / _second_order(j, HIGH_PASS, 0.5**0.5)
    W *= LOW_PASS**2 / _second_order(j, LOW_PASS, 0.5**0.5)
    W *= (1 + j / f_3) * f_3**2 / _second_order(j, f_3, Q_4)
    if step is not None:
        W *= _second_order(j, *step[:2]) / _second_order(j, *step[2:])
    return np.asarray(W, dtype=np.complex128)


def _second_order(j: Complexes, f_i: float, Q: float) -> Complexes:
    """Give s² + s ω/Q + ω², all divided by 4π²."""
    return j * j + j * (f_i / Q) + f_i**2
