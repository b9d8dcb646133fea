"""The text of CSV tables: numbers read back as the same floats, and are as short as can be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from seat import SEAT, rows_of

from drysim.results import tables
from drysim.results.sweep import write_transmissibility_csv
from drysim.scenario.load import load
from drysim.study.sweep import sweep

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
def test_number_reads_back_as_the_same_float_and_has_the_digits_of_repr(kind):
    values = NUMBERS[kind] + 0.0  # -0.0 becomes 0.0
    cells = tables.format_numbers([values])
    assert np.array(cells, dtype="S32").astype(np.float64).tobytes() == values.tobytes()
    for cell, value in zip(cells, values.tolist(), strict=True):
        assert significant(cell.decode()) == significant(repr(value))


def test_missing_number_is_an_empty_cell_and_no_zero_is_negative():
    columns = [np.array([1.0, np.nan, -0.0]), np.array([np.nan, 2.5, 1e-7])]
    assert tables.format_numbers(columns) == [b"1.0,", b",2.5", b"0.0,1e-7"]
    assert tables.format_counts(np.array([3.0, np.nan, 0.0])) == [b"3", b"", b"0"]
    assert tables.format_numbers([np.empty(0), np.empty(0)]) == []
    values = (None, math.nan, math.inf, -0.0, 2.5, 3)
    assert [tables.format_cell(value) for value in values] == ["", "", "", "0.0", "2.5", "3"]


@pytest.mark.parametrize("place", [0, 1, 2, 4])
def test_text_and_counts_are_where_they_belong_among_the_numbers(place):
    columns: list[tables.Values] = [
        np.array([0.5, 1.5]),
        np.array([np.nan, 2.0]),
        tables.format_counts(np.array([3.0, np.nan])),
        tables.format_counts(np.array([7, 8])),
    ]
    cells = [["0.5", "", "3", "7"], ["1.5", "2.0", "", "8"]]
    words = ("ok", "not settled")
    columns.insert(place, tables.format_words(words, np.array([0, 1])))
    for row, word in zip(cells, words, strict=True):
        row.insert(place, word)
    assert tables.format_rows(columns).decode() == "".join(
        f"{','.join(row)}\n" for row in cells
    )


def test_mean_of_counts_has_decimals_only_where_it_needs_them():
    assert tables.format_counts(np.array([2.0, 2.5, np.nan])) == [b"2", b"2.5", b""]


def test_column_for_all_tables_is_a_field_of_its_metric(tmp_path, monkeypatch):
    from drysim.metrics import table

    added = table.METRICS_BY_NAME["v_r_rms"]._replace(in_tables=True)
    metrics = tuple(added if one.name == added.name else one for one in table.METRICS)
    monkeypatch.setattr(tables, "METRICS", metrics)
    (tmp_path / "seat.yaml").write_text(f"{SEAT}sweep: {{friction.kinetic: [10, 20]}}\n")
    write_transmissibility_csv(
        sweep(load(tmp_path / "seat.yaml")), tmp_path / "transmissibility.csv"
    )
    rows = rows_of(tmp_path / "transmissibility.csv")
    assert all(float(row["v_r_rms [m/s]"]) > 0 for row in rows)


class Batch:
    """Points of one case."""

    def __init__(self, points):
        self.points = points

    def __len__(self):
        return 1


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("=cmd|' /C calc'!A0.csv", "'=cmd|' /C calc'!A0.csv"),
        ("+1+1.csv", "'+1+1.csv"),
        ("-2+3.csv", "'-2+3.csv"),
        ("@SUM(1).csv", "'@SUM(1).csv"),
        ("=1,2.csv", '"\'=1,2.csv"'),
        ("a\x1b[31m.csv", "a\\x1b[31m.csv"),
        ("-9.81", "-9.81"),
        ("-", "-"),
        ("+3e-5", "+3e-5"),
        ("plain.csv", "plain.csv"),
        ('a "b", c', '"a ""b"", c"'),
    ],
)
def test_text_in_a_csv_is_no_formula_and_drives_no_terminal(text, cell):
    assert tables.quote_cell(text) == cell
    column = tables.key_column("excitation.file", "")
    assert column.values(Batch({"excitation.file": [text]})) == [cell.encode()]
