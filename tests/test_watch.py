"""The watch over speed: what changed is named, by counts that are invented."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "bench"))

from watch import compare, read_total


def test_counts_within_two_percent_are_not_named():
    assert compare({"march": 100.0, "sweep": 5e4}, {"march": 101.9, "sweep": 4.91e4}) == []


@pytest.mark.parametrize(
    ("now", "line"),
    [
        (102.1, "march: +2.1 %, from 100 to 102.1"),
        (97.0, "march: -3.0 %, from 100 to 97"),
        (25e3, "march: +24900.0 %, from 100 to 25,000"),
    ],
)
def test_changed_count_is_named_with_its_change(now, line):
    assert compare({"march": 100.0, "sweep": 7.0}, {"march": now, "sweep": 7.0}) == [line]


def test_job_that_comes_or_goes_is_named():
    found = compare({"march": 100.0, "gone": 1.0}, {"march": 100.0, "added": 2.0})
    assert found == ["added: new", "gone: no longer counted"]


def test_total_of_a_dump_is_read():
    dump = "version: 1\nevents: Ir\nsummary: 77\n\nfn=(1) main\n12 34\n\ntotals: 12345\n"
    assert read_total(dump) == 12345
