"""Solutions by an integrator as references, and how far these may be off themselves."""

from __future__ import annotations

import numpy as np

RTOL = 1e-12
"""Relative tolerance of a reference, not far above the least that scipy takes."""

SAFETY = 3.0
"""A reference may be off by this times what twice its tolerance changes: near rounding and
near the limit of their stability, the errors of both runs are of one size."""

USEFUL = 1e-6
"""Share of its peak by which a reference may be off and still tell anything."""


def assert_agrees(ours, reference, own):
    """Assert that arrays agree with a reference within the errors that both may have.

    Parameters
    ----------
    ours : sequence of array_like
    reference : callable
        Takes a relative tolerance and returns the same arrays by an integrator.
    own : sequence of float or array_like
        The error that each of ours may have.
    """
    fine, coarse = reference(RTOL), reference(2.0 * RTOL)
    for value, known, other, error in zip(ours, fine, coarse, own, strict=True):
        known = np.asarray(known)
        assert np.shape(value) == np.shape(known) == np.shape(other)
        doubt = SAFETY * np.abs(known - other).max()
        assert doubt <= USEFUL * np.abs(known).max(), "the reference is in doubt"
        assert (np.abs(np.asarray(value) - known) <= error + doubt).all()


def peak(values):
    """Return the greatest size of some values."""
    return np.abs(values).max()
