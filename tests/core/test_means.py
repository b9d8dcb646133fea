"""Mean squares of the base over any window, against forty digits."""

from __future__ import annotations

from random import Random
from types import SimpleNamespace

import mpmath
import pytest
from scenes import waves_of

AGREES = 1e-11
"""Relative: an angle of thousands of radians is known to 1e-12."""


def exact(sines: list[tuple[float, float, float]], begin: float, end: float) -> float:
    """Give the mean of ü² in forty digits."""
    with mpmath.workdps(40):
        waves = [(A, 2 * mpmath.pi * mpmath.mpf(f), mpmath.mpf(p)) for A, f, p in sines]
        total = mpmath.mpf(0)
        for A, v, p in waves:
            for B, w, q in waves:
                apart = along(v - w, p - q, begin, end)
                total += A * B * (apart - along(v + w, p + q, begin, end))
        return float(total / 2)


def along(omega, phase, begin, end):
    """Give the mean of a cosine over a window."""
    if not omega:
        return mpmath.cos(phase)
    rise = mpmath.sin(omega * end + phase) - mpmath.sin(omega * begin + phase)
    return rise / omega / (mpmath.mpf(end) - mpmath.mpf(begin))


@pytest.mark.parametrize("begin", [0.0, 1.3])
def test_mean_square_is_right_over_windows_of_any_length(
    kernel: SimpleNamespace, begin: float
) -> None:
    for number in range(60):
        dice = Random(number)
        sines = [
            (dice.choice((0.1, 1.0, 1e3)), 10.0 ** dice.uniform(-3, 3), dice.choice((0.0, 0.4)))
            for _ in range(dice.choice((1, 2, 3)))
        ]
        end = begin + 10.0 ** dice.uniform(-9, 2)
        waves = waves_of(kernel, sines, kernel.model.Law(0.0, 0.0))
        found, _ = kernel.forcing.mean_squares(waves, begin, end)
        assert found == pytest.approx(exact(sines, begin, end), rel=AGREES), number
