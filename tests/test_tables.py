"""The text of CSV tables: numbers read back as the same floats, and are as short as can be."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drysim.output import tables

RANDOM = np.random.Generator(np.random.PCG64(7))
BITS = RANDOM.integers(0, 2**64, 100_000, dtype=np.uint64, endpoint=False)
POWERS = 2.0 ** np.arange(-1074, 1024)

NUMBERS = {
    "any bits": BITS.view(np.float64)[np.isfinite(BITS.view(np.float64))],
    "powers of two": np.concatenate((POWERS, -POWERS, np.nextafter(POWERS, 0.0))),
    "powers of ten": np.array(
        [float(f"{sign}1e{k}") for k in range(-323, 309) for sign in "+-"]
    ),
    "smallest": np.arange(2000) * 5e-324,
    "times": np.arange(50_000) * 2.5e-3,
    "few digits": np.round(RANDOM.standard_normal(20_000), 3),
    "whole": RANDOM.integers(0, 10**18, 20_000).astype(np.float64),
    "borders": np.array([9.999e-5, 1e-4, 1e-5, 1e15, 1e16, 9999999999999998.0, 0.0]),
}


def significant(text: str) -> str:
    """Return the significant digits of a number."""
    return text.partition("e")[0].replace(".", "").lstrip("-0").rstrip("0")


@pytest.mark.parametrize("kind", NUMBERS)
def test_number_reads_back_as_the_same_float_and_has_the_digits_of_repr(kind: str) -> None:
    values = NUMBERS[kind] + 0.0  # -0.0 becomes 0.0
    cells = tables.format_numbers([values])
    assert np.array(cells, dtype="S32").astype(np.float64).tobytes() == values.tobytes()
    for cell, value in zip(cells, values.tolist(), strict=True):
        assert significant(cell.decode()) == significant(repr(value))


def test_missing_number_is_an_empty_cell_and_no_zero_is_negative() -> None:
    columns = [np.array([1.0, np.nan, -0.0]), np.array([np.nan, 2.5, 1e-7])]
    assert tables.format_numbers(columns) == [b"1.0,", b",2.5", b"0.0,1e-7"]
    assert tables.format_counts(np.array([3.0, np.nan, 0.0])) == [b"3", b"", b"0"]
    assert tables.format_numbers([np.empty(0), np.empty(0)]) == []
    values = (None, math.nan, math.inf, -0.0, 2.5, 3)
    assert [tables.format_cell(value) for value in values] == ["", "", "", "0.0", "2.5", "3"]


@pytest.mark.parametrize("place", [1, 2])
def test_text_of_a_series_is_where_it_belongs(place: int) -> None:
    block = tables.SeriesBlock((np.array([1.0, 2.5]), np.array([-3.0, 4.0])), np.array([0, 1]))
    (rows,) = tables.format_series([block], ["b", "aa"], place)
    expected = {1: b"1.0,b,-3.0\n2.5,aa,4.0\n", 2: b"1.0,-3.0,b\n2.5,4.0,aa\n"}
    assert rows == expected[place]


@pytest.mark.parametrize("place", [0, 1, 3, 4])
def test_cases_are_rows_of_approach_numbers_counts_and_status(place: int) -> None:
    numbers = np.array([[0.5, 1.5], [np.nan, 2.0], [3.0, np.nan], [7.0, 8.0]])
    status = np.array([0, 1], dtype=np.int8)
    block = tables.CaseBlock("stick-slip", numbers, (False, False, True, True), status)
    (rows,) = tables.format_cases([block], ("ok", "not settled"), place)
    cells = [["0.5", "", "3", "7"], ["1.5", "2.0", "", "8"]]
    for row, word in zip(cells, ("ok", "not settled"), strict=True):
        row.insert(place, word)
    assert rows.decode() == "".join(f"stick-slip,{','.join(row)}\n" for row in cells)
