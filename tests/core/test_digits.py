"""The compiled text of numbers is that of `repr`, its plain twin, character by character."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from drysim.output import tables

RANDOM = np.random.Generator(np.random.PCG64(7))
BITS = RANDOM.integers(0, 2**64, 100_000, dtype=np.uint64, endpoint=False)
POWERS = 2.0 ** np.arange(-1074, 1024)

NUMBERS = {
    "any bits": BITS.view(np.float64),
    "powers of two": np.concatenate((POWERS, -POWERS, np.nextafter(POWERS, 0.0))),
    "powers of ten": np.array(
        [float(f"{sign}1e{k}") for k in range(-323, 309) for sign in "+-"]
    ),
    "smallest": np.arange(2000) * 5e-324,
    "times": np.arange(50_000) * 2.5e-3,
    "few digits": np.round(RANDOM.standard_normal(20_000), 3),
    "whole": RANDOM.integers(0, 10**18, 20_000).astype(np.float64),
    "borders": np.array([9.999e-5, 1e-4, 1e-5, 1e15, 1e16, 9999999999999998.0, 0.0, -0.0]),
    "none": np.array([np.nan, np.inf, -np.inf]),
}


def rows_of(fast: SimpleNamespace, numbers: np.ndarray, place: int) -> list[str]:
    """Return the rows that the kernel writes of columns of numbers and a word."""
    words = np.array([[98, 0], [97, 97]], dtype=np.uint8)
    codes = np.arange(numbers.shape[1]) % 2
    out = np.empty(numbers.shape[1] * (numbers.shape[0] * 25 + 3), dtype=np.uint8)
    columns = np.ascontiguousarray(numbers).view(np.uint64)
    used = fast.digits.put_rows(columns, codes, words, place, out)
    return out[:used].tobytes().decode().splitlines()


@pytest.mark.parametrize("kind", NUMBERS)
def test_shortest_text_is_that_of_repr(fast: SimpleNamespace, kind: str) -> None:
    values = NUMBERS[kind]
    with np.errstate(invalid="ignore"):
        bare = (values + 0.0).tolist()  # -0.0 is written 0.0
    wanted = [f"{value!r},{('b', 'aa')[i % 2]}" for i, value in enumerate(bare)]
    assert rows_of(fast, values[None, :], 1) == wanted


def test_word_stands_where_it_is_wanted(fast: SimpleNamespace) -> None:
    numbers = np.array([[1.0, 2.5], [-3.0, 1e-7]])
    assert rows_of(fast, numbers, 0) == ["b,1.0,-3.0", "aa,2.5,1e-07"]
    assert rows_of(fast, numbers, 1) == ["1.0,b,-3.0", "2.5,aa,1e-07"]


@pytest.mark.parametrize("place", [0, 1, 3])
def test_cases_are_written_as_plain_python_writes_them(
    fast: SimpleNamespace, monkeypatch: pytest.MonkeyPatch, place: int
) -> None:
    numbers = np.array(
        [BITS.view(np.float64)[:900], NUMBERS["few digits"][:900], np.arange(900)]
    )
    numbers[:2, ::7] = np.nan
    numbers[0, ~np.isfinite(numbers[0])] = np.nan
    status = np.arange(900, dtype=np.int8) % 3
    block = tables.CaseBlock("stick-slip", numbers, (False, False, True), status)
    monkeypatch.setitem(sys.modules, "drysim.core.digits", fast.digits)
    words = ("ok", "not settled", "")
    assert bytes(
        tables._format_cases_kernel(words, place, block)
    ) == tables._format_cases_python(words, place, block)
