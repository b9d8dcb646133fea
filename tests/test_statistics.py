"""Means over many values: their interval, quantiles and extremes."""

from __future__ import annotations

import numpy as np
import pytest

from drysim.scenario.blocks import SEED
from drysim.study.rows import Row
from drysim.study.statistics import interval, statistics
from drysim.wording import around


def rows(*values, first=1):
    """Give the rows of seeds with these values of T_a."""
    return [
        Row({SEED: seed}, "stick-slip", 0.0, 0.0, {"T_a": value})
        for seed, value in enumerate(values, first)
    ]


def test_interval_is_that_of_students_t():
    from scipy import stats

    values = [0.98, 1.01, 1.03, 0.97, 1.0]
    mean, half_width = interval(values)
    low, high = stats.t.interval(0.95, 4, np.mean(values), stats.sem(values))
    assert (mean - half_width, mean + half_width) == pytest.approx((low, high), rel=1e-12)


def test_interval_holds_the_true_mean_in_95_of_100_cases():
    random = np.random.Generator(np.random.PCG64(2))
    held = 0
    for values in random.normal(3.0, 2.0, (4000, 6)):
        mean, half_width = interval(values.tolist())
        held += abs(mean - 3.0) <= half_width
    # The share itself scatters by 0.35 %.
    assert held / 4000 == pytest.approx(0.95, abs=0.012)


def test_interval_does_not_depend_on_the_order_of_the_values():
    values = np.random.Generator(np.random.PCG64(4)).normal(0.0, 1.0, 50)
    assert interval(values.tolist()) == interval(values[::-1].tolist())


def test_a_single_value_has_no_interval():
    assert interval([2.5]) == (2.5, None)
    found = statistics(rows(2.5))["T_a"]
    assert (found.mean, found.half_width, found.std) == (2.5, None, None)


def test_equal_values_have_an_interval_of_no_width():
    found = statistics(rows(0.1, 0.1, 0.1))["T_a"]
    assert (found.mean, found.half_width, found.quantiles) == (0.1, 0.0, (0.1, 0.1, 0.1))


def test_extremes_name_their_seed():
    found = statistics(rows(3.0, 1.0, 7.0, 1.0, first=11))["T_a"]
    assert (found.least, found.greatest) == ((1.0, 12), (7.0, 13))


def test_quantiles_are_those_of_the_values():
    found = statistics(rows(*np.linspace(0, 1, 1001)))["T_a"]
    assert found.quantiles == pytest.approx((0.05, 0.5, 0.95), abs=1e-3)


def test_seeds_that_do_not_know_a_metric_are_left_out_and_counted():
    found = statistics(rows(1.0, None, 3.0))["T_a"]
    assert (found.seeds, found.mean) == (2, 2.0)
    assert statistics(rows(None, None))["T_a"] is None


@pytest.mark.parametrize(
    ("mean", "half_width", "words"),
    [
        (0.837619, 0.00137, "0.8376 ± 0.0014 mm"),
        (5.88168, 0.487, "5.88 ± 0.49 mm"),
        (47.087, 3.2, "47.1 ± 3.2 mm"),
        (1234.5, 96.0, "1234 ± 96 mm"),
        (12345.0, 960.0, "12345 ± 960 mm"),
        (3e-16, 1e-16, "3e-16 ± 1e-16 mm"),
        (0.67, 0.0, "0.67 mm"),
        (0.67, 1e-17, "0.67 mm"),
        (0.67, None, "0.67 mm"),
        (None, None, "not known"),
    ],
)
def test_a_mean_ends_where_its_interval_begins(mean, half_width, words):
    assert around(mean, half_width, "mm") == words
