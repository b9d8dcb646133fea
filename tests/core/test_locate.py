"""Zeros of a Taylor series: what is divided out of it before they are looked for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from drysim.core.roots import NEVER


@pytest.mark.parametrize(
    ("series", "last", "zeros"),
    [([0.0, 0.0, 1.0, 2.0, 3.0], 2, 2), ([0.0, 0.0, 5.0], 0, 2), ([4.0, 0.0, 5.0], 2, 0)],
)
def test_zeros_at_the_beginning_of_a_series_are_divided_out(
    kernel: SimpleNamespace, series: list[float], last: int, zeros: int
) -> None:
    c = np.array(series)
    assert kernel.roots.lowered(c, len(series) - 1) == (last, zeros)
    assert c[: last + 1].tolist() == series[zeros:]


def test_series_of_zeros_alone_is_told_apart(kernel: SimpleNamespace) -> None:
    assert kernel.roots.lowered(np.zeros(3), 2)[1] == -1


@pytest.mark.parametrize(
    ("series", "at"),
    [
        ([1.0, -2.0], 0.5),
        ([1.0, -3.0, 2.0], 0.5),
        ([0.0, 3.0, -4.0], 0.75),
        ([1.0, -0.9], NEVER),
    ],
    ids=["line", "parabola", "from zero", "later"],
)
def test_first_zero_of_a_polynomial_is_found(
    kernel: SimpleNamespace, series: list[float], at: float
) -> None:
    assert kernel.roots.locate(np.array(series), len(series) - 1, 1.0) == pytest.approx(at)


def test_zero_nearer_by_many_powers_of_ten_is_come_to(kernel: SimpleNamespace) -> None:
    # Bristles whose motion had died away to 1e-322 m closed a loop so: a search without end.
    series = np.array([1e-200, 0.0, 0.0, -1.0, 0.2])
    found = kernel.roots.locate(series, 4, 1.0)
    assert found == pytest.approx(1e-200 ** (1.0 / 3.0), rel=1e-12, abs=0.0)
