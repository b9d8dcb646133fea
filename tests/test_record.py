"""Records: what is read, what is refused and in which words, and how ü comes of it."""

from __future__ import annotations

import hashlib
import importlib.util
import math
import os
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from drysim import system
from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.records import text as cells_module
from drysim.records.columns import open_record
from drysim.records.formats import FORMATS_BY_SUFFIX
from drysim.records.text import _read_by_cell, _read_fast, text_columns
from drysim.study.ensemble import run

HERE = Path(__file__).parent
DATA = HERE / "data"
GALLERY = HERE.parent / "scenarios"
ROWS = "t [s],u_dd [m/s2]\n0,1\n0.01,2\n0.02,4\n"


def record(folder, **words):
    """Return the record of a scenario in a folder."""
    return Record.model_validate({"kind": "record", **words}, context={"folder": folder})


def motion_of(folder, text, **words):
    """Return the motion of a record with this text."""
    content = text if isinstance(text, bytes) else text.encode()
    (folder / "r.csv").write_bytes(content)
    return record(folder, file="r.csv", **words).motion()


def problem_of(folder, text, **words):
    """Return the problem that a record with this text has."""
    with pytest.raises(RecordError) as caught:
        motion_of(folder, text, **words)
    return caught.value.problem


# what is read


G = 9.80665


@pytest.mark.parametrize(
    ("file", "words", "u_dd", "dt"),
    [
        # comments, a mark at the beginning, CRLF, quotes
        ("spreadsheet.csv", {"time": "t", "column": "u_dd"}, [0.5, -0.25, 0.1, 0.75], 0.0025),
        ("decimal-comma.csv", {"time": "t"}, [0.1 * G, -0.2 * G, 0], 0.01),
        ("blanks.txt", {"time": "time [s]", "column": "u_dd [m/s2]"}, [1, 2, 4], 0.004),
        ("bare.dat", {"unit": "m/s2", "rate": 400}, [0.25, -0.5, 1], 0.0025),
    ],
)
def test_tables_of_any_layout_are_read(file, words, u_dd, dt):
    motion = record(DATA, file=file, **words).motion()
    assert motion.u_dd.tolist() == pytest.approx(u_dd, rel=1e-15)
    assert motion.dt == dt


UNDERSTOOD = {
    "decimal commas": ("a [m/s2]\n0,5\n-0,25\n1\n", {"step": 1}, [0.5, -0.25, 1]),
    "commas later": ("a [m/s2]\n1\n0,5\n-0,25\n", {"step": 1}, [1, 0.5, -0.25]),
    "row of units": ("acc\nm/s2\n0,5\n-2,5e-1\n1,0\n", {"step": 1}, [0.5, -0.25, 1]),
    "rows above": ("Log 7\nacc\nm/s2\n0,5\n1,0\n", {"step": 1, "skip": 1}, [0.5, 1]),
    "no header": ("0,5\n-0,05\n1,5\n", {"step": 1, "unit": "m/s2"}, [0.5, -0.05, 1.5]),
    "blanks": ("t [s] a [m/s2]\n0,0 0,5\n0,1 -0,25\n0,2 1\n", {"time": "t"}, [0.5, -0.25, 1]),
    "whole numbers": ("0,5\n1,15\n2,25\n", {"time": 1, "unit": "m/s2"}, [5, 15, 25]),
    "blank in a name": ("base motion [g]\n1\n2\n", {"step": 1}, [G, 2 * G]),
    "unit elsewhere": ("t,acc (filtered)\n0,1\n1,2\n", {"time": "t", "unit": "g"}, [G, 2 * G]),
    "unit twice": (ROWS, {"time": "t", "unit": "m/s^2"}, [1, 2, 4]),
    "skip": ("run 7\n1,2\n3,4\n", {"skip": 1, "column": 2, "unit": "m/s2", "step": 1}, [2, 4]),
    "skip behind a mark": (
        "\ufeffrun 7\r\n1,2\r\n3,4\r\n",
        {"skip": 1, "column": 2, "unit": "m/s2", "step": 1},
        [2, 4],
    ),
    "Windows": (
        "Zeit [s];Schütteln [m/s²]\n0;1\n1;2\n".encode("cp1252"),
        {"time": "Zeit", "column": "Schütteln"},
        [1, 2],
    ),
    "no last name": ("t [s],a [m/s2],\n0,1,\n1,2,\n", {"time": "t"}, [1, 2]),
    "no first name": (",t [s],a [m/s2]\n0,0,1\n1,1,2\n", {"time": "t"}, [1, 2]),
}


@pytest.mark.parametrize("name", UNDERSTOOD)
def test_layout_of_a_text_is_understood(tmp_path, name):
    text, words, u_dd = UNDERSTOOD[name]
    assert motion_of(tmp_path, text, **words).u_dd.tolist() == u_dd


def test_quick_and_careful_pass_agree_on_one_column_with_decimal_commas(tmp_path, monkeypatch):
    values = np.random.default_rng(7).normal(size=1000).round(4)
    text = "a [m/s2]\n" + "".join(f"{v!r}\n" for v in values.tolist()).replace(".", ",")
    quick = motion_of(tmp_path, text, step=0.01).u_dd
    monkeypatch.setattr(cells_module, "_read_fast", lambda *_: None)
    careful = motion_of(tmp_path, text, step=0.01).u_dd
    assert np.array_equal(quick, values)
    assert np.array_equal(careful, values)


@pytest.mark.parametrize("mark", [",", ";", "\t", "  ", " , "])
def test_delimiter_is_found_by_itself(tmp_path, mark):
    text = "".join(f"{k / 100}{mark}{k}{mark}{-k}\n" for k in range(5))
    motion = motion_of(tmp_path, text, time=1, column=3, unit="m/s2")
    assert (motion.u_dd.tolist(), motion.dt) == ([0, -1, -2, -3, -4], 0.01)


def test_response_of_drysim_is_a_record_again(tmp_path):
    dt, u_dd = 0.003, np.random.default_rng(1).normal(size=2000)
    names = "t [s],u_dd [m/s2],x_r [m],v_r [m/s],x_dd [m/s2],F_f [N],stuck [-]\n"
    rows = (f"{k * dt!r},{v!r},0.0,0.0,{v!r},,1\n" for k, v in enumerate(u_dd.tolist()))
    motion = motion_of(tmp_path, names + "".join(rows), column="u_dd", time="t")
    assert np.array_equal(motion.u_dd, u_dd)
    assert motion.dt == dt


def test_input_is_named_and_hashed_as_read(tmp_path):
    motion = motion_of(tmp_path, ROWS, time="t")
    digest = hashlib.sha256(ROWS.encode()).hexdigest()
    assert motion.inputs == (("r.csv", digest, len(ROWS)),)


def test_path_of_the_record_can_be_told_from_another_folder(tmp_path):
    (tmp_path / "out" / "seat").mkdir(parents=True)
    chosen = record(tmp_path, file="logs/r.csv", step=1)
    assert chosen.file_from(tmp_path / "out" / "seat") == "../../logs/r.csv"


# the quick and the careful pass


@pytest.mark.parametrize("size", [1, 5, 8, 1000])
def test_lines_are_numbered_whatever_ends_them_and_is_read_at_a_time(monkeypatch, size):
    monkeypatch.setattr(cells_module, "LINES_SIZE", size)
    text = cells_module.TextFile("r.csv", b"\xef\xbb\xbft,a\r\n1,2\r3,4\n\r\n5,6", begin=3)
    assert [*cells_module.raw_lines(text)] == [
        (1, 3, b"t,a"), (2, 8, b"1,2"), (3, 12, b"3,4"), (4, 16, b""), (5, 18, b"5,6"),
    ]  # fmt: skip
    assert [*cells_module.raw_lines(text, 18, 5)] == [(5, 18, b"5,6")]


@pytest.mark.parametrize("mark", [",", ";", "\t", " "])
def test_quick_and_careful_pass_agree_to_the_bit(tmp_path, monkeypatch, mark):
    monkeypatch.setattr(cells_module, "PARSE_SIZE", 64)
    rng = np.random.default_rng(2)
    values = rng.normal(size=(300, 3)) * 10.0 ** rng.integers(-30, 30, (300, 3))
    lines = [mark.join(map(repr, row)) for row in values.tolist()]
    lines[100:100] = ["# a remark, in between"]
    (tmp_path / "r.csv").write_text("\n".join(lines))
    table = text_columns(open_record(tmp_path / "r.csv", FORMATS_BY_SUFFIX))
    quick = _read_fast(table, [0, 2], ".")
    assert quick is not None
    assert np.array_equal(quick, _read_by_cell(table, [0, 2]))
    assert np.array_equal(np.transpose(quick), values[:, [0, 2]])


@pytest.mark.parametrize(
    "rows",
    [
        "1,2,3\n4,5\n6,7,8,9\n",
        "1,2,3\n4 5,6,7\n8,,9\n",
        "1,2,3\n4,5,6,\n7,8\n",
        '1,2,3\n"4,5",6\n7,8,9\n',
        "1,2,3\n\n4,5,6\n",
        "1 2 3\n4 5\n6 7 8 9\n",
        "1 2 3\n4-5 6\n7 8 9\n",
        "1,2,3\n4,0x5,6\n",
        "1,2,3\n4,1_0,6\n",
    ],
)
def test_quick_pass_leaves_every_irregular_row_to_the_careful_one(tmp_path, rows):
    (tmp_path / "r.csv").write_text(rows)
    assert (
        _read_fast(text_columns(open_record(tmp_path / "r.csv", FORMATS_BY_SUFFIX)), [1], ".")
        is None
    )


# what is refused

CELLS = {
    "oops": "row 3, column 2 (`u_dd [m/s2]`): `oops` is not a number",
    "": "row 3, column 2 (`u_dd [m/s2]`): the cell is empty: the record has a gap",
    "nan": "row 3, column 2 (`u_dd [m/s2]`): `nan` is not a finite number",
    "-inf": "row 3, column 2 (`u_dd [m/s2]`): `-inf` is not a finite number: an infinite samp",
    "1e999": "row 3, column 2 (`u_dd [m/s2]`): `1e999` is not a finite number: an infinite sam",
    '"1,5"': "row 3, column 2 (`u_dd [m/s2]`): `1,5` has a decimal comma; write points",
}


LOGGER = [
    "logger X\ndate 2026\n\n",
    "7;8\n",
    "Test 12\n2026-03-12 10:00\nchannels: 2\nnotes;none\n",
    "t0 = 0\n# remark\n1;2;3\n\n",
    "Lab 3;\n",
    # The header of the next ones is not in the first row that fits the numbers.
    "Logger: X; serial 12\nDate: 12.05.2026\n",
    "Messung um 13:45 in Halle 3\nKanal 1, Boden, 250 Hz\nKanal 2, Temp\n",
    "Name;X200\nOrt;Halle 3;Linie 2\n",
]


@pytest.mark.parametrize("head", LOGGER)
@pytest.mark.parametrize("begin", ["0", "12.05.2026 13:45:07,0"])
def test_rows_of_a_logger_above_the_header_are_told_and_passed_over(tmp_path, head, begin):
    name, end = ("Zeit [s]", "1") if begin == "0" else ("Zeit", begin.replace("7,0", "8,0"))
    text, rows = f"{head}{name};acc [m/s2]\n{begin};1\n{end};2\n", head.count("\n")
    found = problem_of(tmp_path, text, time="Zeit", column="acc")
    assert f"row {rows + 1} looks like the header" in found.sentence
    assert found.sentence.endswith(f"`skip: {rows}` skips the rows above it")
    assert found.line == rows + 1
    motion = motion_of(tmp_path, text, time="Zeit", column="acc", skip=rows)
    assert motion.u_dd.tolist() == [1, 2]
    bad = problem_of(tmp_path, text + "2;oops\n", time="Zeit", column="acc", skip=rows)
    assert bad.line == rows + 4  # as an editor counts


DATED = "Datum;acc [g]\n12.03.2026 14:05:00;-0,5\n12.03.2026 14:05:00;1,25e0\n"


def test_decimal_commas_count_in_the_columns_that_are_used(tmp_path):
    words = {"column": "acc", "rate": 500}
    motion = motion_of(tmp_path, DATED, **words)
    assert motion.u_dd.tolist() == [-0.5 * 9.80665, 1.25 * 9.80665]
    for delimited in (DATED.replace(";", "\t"), DATED.replace("12.03.2026 14:05:00", "v1.2")):
        assert motion_of(tmp_path, delimited, **words).u_dd.tolist() == motion.u_dd.tolist()
    numbers = "x;acc [g]\n1.5;-0,5\n2.5;1,25\n"
    assert motion_of(tmp_path, numbers, **words).u_dd.tolist() == motion.u_dd.tolist()
    found = problem_of(tmp_path, DATED + "12.03.2026 14:05:01;0.5\n", **words)
    assert found.sentence.endswith("`0.5` has a decimal point; write commas throughout")
    found = problem_of(tmp_path, DATED.replace("-0,5", "-0.5"), **words)
    assert found.sentence.endswith("`1,25e0` has a decimal comma; write points throughout")


@pytest.mark.parametrize("row", ["sep=;", "SEP=;", '"sep=;"'])
def test_row_that_tells_excel_the_delimiter_is_passed_over(tmp_path, row):
    words = {"time": "t", "column": "a"}
    text = f"\ufeff{row}\r\nt [s];a [m/s2]\r\n0,0;0,01\r\n0,1;0,02\r\n"
    for skip in (0, 1):
        assert motion_of(tmp_path, text, **words, skip=skip).u_dd.tolist() == [0.01, 0.02]
    found = problem_of(tmp_path, text + "0,2;oops\r\n", **words)
    assert found.line == 5


def test_header_with_another_unit_may_be_passed_over(tmp_path):
    text = "t [s],a [mg]\n0,1\n1,2\n"
    motion = motion_of(tmp_path, text, time="t", column="a")
    np.testing.assert_allclose(motion.u_dd, [9.80665e-3, 2 * 9.80665e-3], rtol=1e-15)
    scaled = {"unit": "g", "scale": 1e-3}
    for unit, why in (("mg", "the scenario says `unit: g`"), ("mV", "is a unit of something")):
        other = text.replace("mg", unit)
        found = problem_of(tmp_path, other, time="t", column="a", **scaled)
        assert why in found.sentence
        assert found.sentence.endswith("`skip: 1` skips the header; then select columns "
                                       "by number")  # fmt: skip
        numbered = motion_of(tmp_path, other, time=1, column=2, skip=1, **scaled)
        np.testing.assert_allclose(numbered.u_dd, motion.u_dd, rtol=1e-15)


def test_rows_of_a_file_that_is_no_text_cannot_be_passed_over(tmp_path):
    with pytest.raises(ValidationError, match="a WAV is not a text table; remove `skip`"):
        record(tmp_path, file="r.wav", skip=1)


def test_row_of_units_below_the_names_is_read(tmp_path):
    text = "Time,Acc,Temp\nms,(g),degC\n\n0,1,20\n10,2,21\n"
    motion = motion_of(tmp_path, text, time="Time", column="Acc")
    assert motion.dt == 0.01
    assert motion.u_dd.tolist() == [9.80665, 2 * 9.80665]
    said = problem_of(tmp_path, text, time="Time", column="Acc", unit="m/s2").sentence
    assert "the header says `g`, the scenario says `unit: m/s2`" in said
    said = problem_of(tmp_path, text, time="Time", column="Temp").sentence
    assert said.startswith("column 3 (`Temp`): unknown unit `degC`")


def test_row_of_words_below_the_names_is_no_row_of_units(tmp_path):
    for row in ("left,right", "s,g,m", "0,g"):
        said = problem_of(tmp_path, f"t [s],a [g]\n{row}\n0,1\n1,2\n", time="t").sentence
        assert "is not a number" in said or "names 2 columns" in said, row
    assert (
        "`left` is not a number"
        in problem_of(tmp_path, "t,a\nleft,right\n0,1\n1,2\n", time="t").sentence
    )


def test_what_is_missing_is_asked_for_in_order(tmp_path):
    text = "Zeit [ms];acc [m/s2];b [m/s2]\n0;1;3\n1;2;4\n"
    said = problem_of(tmp_path, text).sentence
    assert said.endswith("`time: Zeit` fits, as the header has `Zeit [ms]`")
    assert problem_of(tmp_path, text, time="Zeit").sentence.startswith("set `column`")


def test_times_of_day_are_no_samples_and_not_read_without_seconds(tmp_path):
    for stamp in ("10:00:00.002", "2026-03-12T10:00:00Z"):
        text = f"t,a [g]\n{stamp},1\n{stamp},2\n"
        said = problem_of(tmp_path, text, column="t", unit="g", rate=1).sentence
        assert said.endswith("is a time of day, no sample")
    text = "t,a [g]\n12.03.2026 10:00,1\n12.03.2026 10:01,2\n"
    said = problem_of(tmp_path, text, time="t").sentence
    assert "may be hours and minutes, or minutes and seconds; set `rate` or `step`" in said


@pytest.mark.parametrize(("cell", "sentence"), CELLS.items())
def test_faulty_cell_is_named_by_row_and_column(tmp_path, cell, sentence):
    found = problem_of(tmp_path, ROWS.replace("0.01,2", f"0.01,{cell}"), time="t")
    assert found.sentence.startswith(sentence)
    assert (found.file, found.line) == (str(tmp_path / "r.csv"), 3)
    assert found.column == (7 if '"' in cell else 6)


@pytest.mark.parametrize(
    ("text", "column", "row", "cell"),
    [
        ('t [s],a [g],b\n0,1,2\n1,"2,3\n9,9,9\n', 2, 3, '"2,3'),
        ('# no names\n0,1,2\n1,"2,3\n9,9,9\n', 2, 3, '"2,3'),
        ('a [g],b\n0,"1,2\n1,2,3\n', 1, 2, '"1,2'),  # the row by which others are counted
        ('a [g],b,c\n0,"1,2\n1,2,3\n', 1, 2, '"1,2'),
    ],
)
def test_quotation_mark_that_is_not_closed_is_named(tmp_path, text, column, row, cell):
    found = problem_of(tmp_path, text, column=column, unit="g", rate=1)
    assert found.sentence == f"row {row} has a quotation mark that is not closed: `{cell}`"
    assert (found.line, found.source.lstrip("… ")) == (row, cell)


def test_header_with_a_quotation_mark_that_is_not_closed_is_named(tmp_path):
    said = problem_of(tmp_path, 't [s],"a [g],b\n0,1,2\n1,2,3\n', time="t").sentence
    assert said == 'row 1 has a quotation mark that is not closed: `"a [g],b`'
    kept = motion_of(tmp_path, 't [s],a 5" up [g]\n0,1\n1,2\n', time="t")
    assert len(kept.u_dd) == 2


@pytest.mark.parametrize("first", ["++1", "--2.5", "+-3e4", "\u22121", "\u22121.5"])
def test_first_row_of_a_number_with_a_wrong_sign_is_a_fault_and_no_header(tmp_path, first):
    found = problem_of(tmp_path, f"{first}\n2\n3\n", unit="g", step=1)
    assert found.sentence == f"row 1, column 1: `{first}` is not a number"


def test_message_quotes_nothing_but_the_faulty_cell(tmp_path):
    secret = "s3cret-" * 20
    found = problem_of(tmp_path, f"a,b,c\n1,2,3\n4,{secret},6\n", column="b", unit="g", step=1)
    assert found.source.lstrip("… ") == secret[:39] + "…"
    assert found.source.index(secret[:39]) == found.column - 1
    assert len(found.sentence) < 100


STEPS = {
    "0\n1\n2\n4\n5\n": (4, "1 sample is missing before this row: a step of 2 s, not 1 s"),
    "0\n1\n2.1\n3.1\n4.1\n5.1\n": (3, "the time steps are uneven: 1.1 before this row"),
    "0\n1\n2\n1.5\n3\n": (4, "time decreases: from 2 to 1.5"),
    "0\n1\n1\n2\n": (3, "time repeats: from 1 to 1"),
}


@pytest.mark.parametrize(("times", "fault"), STEPS.items())
def test_uneven_time_names_the_row_and_both_differences(tmp_path, times, fault):
    text = times.replace("\n", ";0\n")
    found = problem_of(tmp_path, text, time=1, column=2, unit="m/s2")
    assert found.line == fault[0]
    assert fault[1] in found.sentence


@pytest.mark.parametrize("digits", [4, 5, 6, 9])
def test_rounded_times_of_a_whole_rate_are_even(tmp_path, digits):
    text = "".join(f"{3 + k / 256:.{digits}f},0\n" for k in range(1000))
    assert motion_of(tmp_path, text, time=1, column=2, unit="g").dt == 1 / 256


def test_times_that_once_were_single_precision_are_even(tmp_path):
    times = (np.arange(5000) * 0.01).astype(np.float32).astype(float)
    text = "".join(f"{t!r} 0\n" for t in times.tolist())
    assert motion_of(tmp_path, text, time=1, unit="g").dt == pytest.approx(0.01, rel=1e-7)


FAULTS = {
    "no unit": (
        "t,a\n0,1\n1,2\n",
        {"time": "t"},
        "column 2 (`a`) has no unit; write `unit: m/s²` in the scenario's `excitation` block, "
        "or `[m/s²]` into the header",
    ),
    "words above": (
        "Logger 7\nacc\nm/s2\n0,5\n0,6\n",
        {"step": 1},
        "row 2 looks like the header, not row 1: `skip: 1` skips",
    ),
    "commas of two kinds": (
        "t [s],a [m/s2]\n0,0,0,5\n0,1,-0,25\n",
        {"time": "t"},
        "the header names 2 columns, but row 2 has 4; commas seem to be both delimiter "
        "and decimal mark: use decimal points, or semicolons as delimiter",
    ),
    "skip": ("a [g]\n1\n2\n", {"skip": 3, "step": 1}, "`skip` skips 3 rows, and the file"),
    "unknown unit": ("t,a [foo]\n0,1\n1,2\n", {"time": "t"}, "unknown unit `foo`"),
    "other dimension": ("t,a [kg]\n0,1\n1,2\n", {"time": "t"}, "not acceleration"),
    "two units": (ROWS, {"time": "t", "unit": "g"}, "the scenario says `unit: g`"),
    "near name": (ROWS, {"time": "t", "column": "u_d"}, "did you mean `u_dd`?"),
    "names": (ROWS, {"time": "zeit"}, "there are: `t [s]`, `u_dd [m/s2]`"),
    "length": (
        "t [s],a [mm]\n0,1\n1,2\n",
        {"time": "t"},
        "`quantity: displacement` in the scenario's `excitation` block reads it as such",
    ),
    "force": (
        "t [s],a [N]\n0,1\n1,2\n",
        {"time": "t"},
        "select another column; or, if the unit is wrong, `skip: 1` skips the header",
    ),
    "lower header": (
        "Cab;three;\nDay;23.11.2026;\nTime;Acc;B\n0;1;1\n1;2;2\n",
        {"time": "Time"},
        "row 3 looks like the header, not row 1: `skip: 2` skips the rows above it",
    ),
    "number": (ROWS, {"time": "t", "column": 3}, "there is no column 3"),
    "no header": ("0,1\n1,2\n", {"time": "t"}, "the file has no header"),
    "which column": ("a,b\n0,1\n1,2\n", {"step": 1}, "set `column`, its name or number"),
    "two alike": ("a [g],a [m]\n0,1\n1,2\n", {"step": 1, "column": "a"}, "columns 1 and 2"),
    "no spacing": (ROWS, {"column": "u_dd"}, "`time: t` fits"),
    "ragged": (ROWS + "0.03\n", {"time": "t"}, "row 5 has 1 cell, not 2"),
    "wide start": (
        "0,1,2\n0,1\n1,2\n2,1\n",
        {"time": 1, "column": 2, "unit": "g"},
        "row 2 has 2 cells, not 3, and so have the rows below: `rows: {from: 2}`",
    ),
    "two points": (
        "t;a\n0.5;1.2.3\n1.5;2.5\n2.5;1.125\n",
        {"time": 1, "column": 2, "unit": "g"},
        "row 2, column 2 (`a`): `1.2.3`",
    ),
    "gap": ("a [g]\n1\n\n2\n", {"step": 1}, "row 3 is empty: the record has a gap"),
    "one sample": ("a [g]\n1\n", {"step": 1}, "the record has one sample only"),
    "empty": ("", {"step": 1}, "the record is empty"),
    "only blanks": ("\n \n", {"step": 1}, "the record is empty"),
    "header alone": ("# x\na [g]\n", {"step": 1}, "the record contains no rows of numbers"),
    "binary": (b"a\0b\n1\n", {"step": 1}, "the record is binary"),
    "UTF-16": ("a [g]\n1\n".encode("utf-16"), {"step": 1}, "the record is UTF-16 text"),
    "no letters": (b"a\x81 [m/s2]\n1\n2\n", {"step": 1}, "the header is not UTF-8"),
    "headers": ("a,b\n1\n2\n", {"step": 1}, "the header names 2 columns, but row 2 has 1"),
    "first row": ("1,x\n2,3\n", {"step": 1, "column": 2, "unit": "g"}, "`x` is not a number"),
    "damaged start": ("-0.4x\n2\n", {"step": 1, "unit": "g"}, "`-0.4x` is not a number"),
    "range": (ROWS, {"time": "t", "scale": 1e30}, "ü is out of range"),
    "cell": (ROWS.replace("0.01,2", "0.01,-1e300"), {"time": "t"}, "ü is out of range"),
    "spline": (
        "1\n2\n1\n4\n",
        {"step": 1e-30, "unit": "Gm/s", "quantity": "velocity"},
        "out of range",
    ),
    "window": (ROWS, {"time": "t", "window": {"from": 5}}, "runs from 0 s to 0.02 s"),
    "filter": (ROWS, {"time": "t", "remove": {"below": 99}}, "and below 50 Hz, half its rate"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_fault_of_a_record_earns_its_sentence(tmp_path, name):
    text, words, sentence = FAULTS[name]
    assert sentence in problem_of(tmp_path, text, **words).sentence


def test_only_regular_files_of_known_kinds_are_read(tmp_path):
    (tmp_path / "folder.csv").mkdir()
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "r.mp3").write_text("1\n2\n")
    (tmp_path / "seat.csv").write_text("1\n2\n")
    (tmp_path / "link.csv").symlink_to("nowhere.csv")
    for file, sentence in {
        "folder.csv": "the record is a folder",
        "pipe.csv": "the record is a pipe",
        "/dev/null": "the record is a device",
        "r.mp3": "a record of type `.mp3` is not supported; supported: .csv, .tsv, ",
        "seats.csv": "the record does not exist; did you mean `seat.csv`?",
        "logs/seat.csv": "there is no folder",
        "link.csv": "the record does not exist: broken symbolic link",
        "a\0b.csv": "the record cannot be read",
    }.items():
        with pytest.raises(RecordError, match=sentence.replace("?", r"\?")):
            record(tmp_path, file=file, unit="g", step=1).motion()


def test_record_whose_numbers_are_larger_than_the_memory_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(system, "total_memory", lambda: 40.0)
    sentence = problem_of(tmp_path, ROWS, time="t").sentence
    assert "GB of memory, this machine has 4e-08 GB" in sentence


@pytest.mark.parametrize(
    "words",
    [
        {"unit": "kg"},
        {"unit": "m/s"},
        {"column": 0},
        {"column": True},
        {"column": 1.5},
        {"column": ""},
        {"remove": "meen"},
        {"remove": {"below": -1}},
        {"step": 0},
        {"rate": "-5 Hz"},
        {"window": {"from": 2, "to": 1}},
        {"colour": "red"},
        {"gravity": "leave"},
    ],
)
def test_scenario_that_makes_no_record_is_refused_without_reading(words):
    with pytest.raises(ValidationError):
        record(Path(), file="nowhere.csv", **words)


# from the numbers to ü


def test_acceleration_is_taken_as_it_is(tmp_path):
    motion = motion_of(tmp_path, ROWS, time="t", scale=-2)
    assert (motion.u_dd.tolist(), motion.u) == ([-2, -4, -8], None)


def test_displacement_of_a_cubic_gives_its_second_derivative_exactly(tmp_path):
    t = np.arange(40) * 0.05
    text = "u [mm]\n" + "".join(f"{v!r}\n" for v in (t**3 - 2 * t**2 + t).tolist())
    motion = motion_of(tmp_path, text, quantity="displacement", step=0.05)
    np.testing.assert_allclose(motion.u_dd, (6 * t - 4) * 1e-3, atol=1e-14)
    np.testing.assert_allclose(motion.u, (t**3 - 2 * t**2 + t) * 1e-3, rtol=1e-14)
    assert motion.dt == 0.05


def test_displacement_of_a_sine_has_the_error_of_its_spline(tmp_path):
    omega, dt = 2 * np.pi, 0.01
    t = np.arange(301) * dt
    text = "".join(f"{v!r}\n" for v in np.sin(omega * t).tolist())
    motion = motion_of(tmp_path, text, quantity="displacement", unit="m", step=dt)
    inner = slice(50, -50)  # the ends, where the spline must guess, fade within a few samples
    z = omega * dt
    # The C² condition gives the spline's second derivative of a sampled sine in closed form.
    factor = 6 * (np.cos(z) - 1) / (2 + np.cos(z)) / dt**2
    expected = factor * np.sin(omega * t)
    np.testing.assert_allclose(motion.u_dd[inner], expected[inner], atol=1e-9)


def test_velocity_of_a_parabola_gives_its_derivative_on_the_half_step(tmp_path):
    t = np.arange(20) * 0.1
    text = "v [m/s]\n" + "".join(f"{v!r}\n" for v in (3 * t**2 - t).tolist())
    motion = motion_of(tmp_path, text, quantity="velocity", step=0.1)
    halves = np.arange(39) * 0.05
    np.testing.assert_allclose(motion.u_dd, 6 * halves - 1, atol=1e-12)
    assert (motion.dt, motion.u) == (0.05, None)


def test_velocity_spline_is_met_exactly_by_lines_between_half_steps(tmp_path):
    v = np.random.default_rng(3).normal(size=30)
    text = "".join(f"{x!r}\n" for x in v.tolist())
    motion = motion_of(tmp_path, text, quantity="velocity", unit="m/s", step=0.1)
    areas = (motion.u_dd[1:] + motion.u_dd[:-1]) / 2 * motion.dt
    np.testing.assert_allclose(v[0] + np.cumsum(areas)[1::2], v[1:], atol=1e-12)


@pytest.mark.parametrize("quantity", ["acceleration", "velocity", "displacement"])
def test_two_samples_are_enough(tmp_path, quantity):
    unit = {"acceleration": "m/s2", "velocity": "m/s", "displacement": "m"}[quantity]
    motion = motion_of(tmp_path, "1\n2\n", quantity=quantity, unit=unit, step=0.5)
    expected = {"acceleration": [1, 2], "velocity": [2, 2, 2], "displacement": [0, 0]}
    np.testing.assert_allclose(motion.u_dd, expected[quantity], atol=1e-14)


def test_window_shifts_time_and_keeps_the_spline_of_the_whole(tmp_path):
    text = "".join(f"{10 + k / 10:.1f} {math.sin(k)!r}\n" for k in range(50))
    words = {"time": 1, "unit": "m/s", "quantity": "velocity"}
    whole = motion_of(tmp_path, text, **words)
    part = motion_of(tmp_path, text, **words, window={"from": 11, "to": "12 s"})
    assert np.array_equal(part.u_dd, whole.u_dd[20:41])


@pytest.mark.parametrize(
    ("window", "sentence"),
    [
        ({"from": 0.01, "to": 0.07}, "`window.to`, 0.07 s, is after the end of the record"),
        ({"from": 0.5}, "`window.from`, 0.5 s, is after the end of the record"),
        ({"from": -1}, "`window.from`, -1 s, is before the beginning of the record"),
        ({"to": -1}, "`window.to`, -1 s, is before the beginning of the record"),
        ({"from": 0.01, "to": 0.011}, "the window must hold two samples of the record"),
    ],
)
def test_window_that_does_not_lie_in_the_record_is_told_on_which_side(
    tmp_path, window, sentence
):
    found = problem_of(tmp_path, ROWS, time="t", window=window)
    runs = "which runs from 0 s to 0.02 s in steps of 0.01 s"
    assert found.sentence == f"{sentence}, {runs}"


def test_window_is_told_in_all_digits_of_the_time_since_1970(tmp_path):
    rows = "t [s],u_dd [m/s2]\n1773321234.25,1\n1773321234.5,2\n1773321234.75,4\n"
    found = problem_of(tmp_path, rows, time="t", window={"from": 10})
    assert "runs from 1773321234.25 s to 1773321234.75 s in steps of 0.25 s" in found.sentence


def test_window_may_end_one_step_behind_the_last_sample(tmp_path):
    motion = motion_of(tmp_path, ROWS, time="t", window={"from": 0.01, "to": 0.03})
    assert motion.u_dd.tolist() == [2, 4]


def test_mean_and_line_are_taken_away_and_reported(tmp_path):
    t = np.arange(11) * 0.1
    text = "a [m/s2]\n" + "".join(f"{v!r}\n" for v in (5 + 2 * t).tolist())
    mean = motion_of(tmp_path, text, step=0.1, remove="mean")
    np.testing.assert_allclose(mean.u_dd, 2 * t - 1, atol=1e-14)
    assert mean.realised["clean_up"][0]["numbers"]["mean"] == pytest.approx(6)
    line = motion_of(tmp_path, text, step=0.1, remove="line")
    np.testing.assert_allclose(line.u_dd, 0, atol=1e-14)
    assert line.realised["clean_up"][0]["numbers"]["drift"] == pytest.approx(2)


@pytest.mark.parametrize("spelt", [{"below": "0.5 Hz"}, "0.5 Hz", 0.5])
def test_high_pass_removes_drift_and_halves_its_own_frequency_without_phase(tmp_path, spelt):
    t = np.arange(10_000) * 0.01
    fast, edge = np.sin(2 * np.pi * 5 * t), np.sin(2 * np.pi * 0.5 * t)
    text = "a [m/s2]\n" + "".join(f"{v!r}\n" for v in (3 + fast + edge).tolist())
    motion = motion_of(tmp_path, text, step=0.01, remove=spelt)
    middle = slice(2000, -2000)
    np.testing.assert_allclose(motion.u_dd[middle], (fast + edge / 2)[middle], atol=2e-4)


def text_of(values, unit="m/s2"):
    """Return the text of a record of one column."""
    return f"a [{unit}]\n" + "".join(f"{v!r}\n" for v in np.asarray(values).tolist())


SLOW = np.sin(np.arange(500) * 0.02 * np.pi)
"""Ten periods of fifty samples, which straight lines join without a loss that shows."""


@pytest.mark.parametrize(
    ("unit", "gravity", "scale"),
    [
        ("g", 1.01, 1.0),
        ("m/s2", -9.6, 1.0),
        ("mg", 998, 1.0),
        ("g", 1.0, -1.0),
        ("g", 1.0, 2.5),
    ],
)
def test_gravity_left_in_a_record_is_a_fault_with_its_remedies(tmp_path, unit, gravity, scale):
    text, words = text_of(gravity * (1 + 0.1 * SLOW), unit), {"step": 0.1, "scale": scale}
    said = problem_of(tmp_path, text, **words).sentence
    assert "which looks like gravity: remove it with `remove: mean`" in said
    assert "or a high-pass, `remove: {below: 0.3 Hz}`, or keep it with `gravity: keep`" in said
    for remedy in ({"remove": "mean"}, {"remove": {"below": 0.3}}, {"gravity": "keep"}):
        given = motion_of(tmp_path, text, **words, **remedy).warnings
        # What is slower than the high-pass leaves no displacement that can be trusted.
        assert {one.slug for one in given} <= {"displacement-ends"}


def test_gravity_is_taken_away_as_a_line_of_a_velocity_and_beside_what_else_is_removed(
    tmp_path,
):
    words = {"step": 0.1, "remove": {"above": "2 Hz", "order": 3}}
    said = problem_of(tmp_path, text_of(9.81 + SLOW), **words).sentence
    assert "remove it with `remove: {trend: mean, above: 2 Hz, order: 3}`" in said
    assert "or a high-pass, `remove: {below: 0.3 Hz, above: 2 Hz, order: 3}`," in said
    text = text_of(9.81 * 0.1 * np.arange(500) + SLOW, "m/s")
    said = problem_of(tmp_path, text, step=0.1, quantity="velocity").sentence
    assert "remove it with `remove: line`" in said


def test_large_mean_is_said_and_a_small_one_is_not(tmp_path):
    for mean, slugs in ((0.3, ["record-mean"]), (0.01, [])):
        given = motion_of(tmp_path, text_of(mean + SLOW), step=0.1).warnings
        assert [c.slug for c in given] == slugs


def test_remedy_of_a_mean_keeps_what_is_removed_already(tmp_path):
    words = {"step": 0.1, "remove": {"above": "2 Hz"}}
    (given,) = motion_of(tmp_path, text_of(0.5 + SLOW), **words).warnings
    assert "`remove: {trend: mean, above: 2 Hz}` removes" in given.sentence


def test_mean_behind_a_high_pass_is_not_sent_to_a_removal_that_would_replace_it(tmp_path):
    words = {"step": 0.1, "remove": {"below": "0.3 Hz"}, "window": {"from": 0, "to": 2}}
    given = motion_of(tmp_path, text_of(0.5 + SLOW), **words).warnings[0]
    assert given.slug == "record-mean"
    assert "`remove" not in given.sentence
    assert "the high-pass at 0.3 Hz has removed the mean of the whole record" in given.sentence


def test_mean_of_a_window_is_not_sent_to_the_removal_that_there_is(tmp_path):
    text = "a [m/s2]\n" + "".join(f"{v!r}\n" for v in np.cos(np.arange(500) * 0.02).tolist())
    words = {"step": 0.1, "window": {"from": 0, "to": 10}}
    (given,) = motion_of(tmp_path, text, **words).warnings
    assert given.sentence.endswith("`remove: mean` removes a sensor offset")
    (removed,) = motion_of(tmp_path, text, **words, remove="mean").warnings
    assert removed.slug == "record-mean"
    assert removed.sentence.endswith(
        "the mean of the whole record is removed already; this window has its own"
    )


def test_mean_of_the_acceleration_is_the_line_of_a_velocity(tmp_path):
    text = text_of(0.5 * np.arange(500) + SLOW, "m/s")
    words = {"step": 0.1, "quantity": "velocity"}
    for remove in ("nothing", "mean"):
        (caution,) = motion_of(tmp_path, text, **words, remove=remove).warnings
        assert "`remove: line` removes " in caution.sentence
    assert motion_of(tmp_path, text, **words, remove="line").warnings == ()


# the gallery's synthetic record


@pytest.fixture(scope="module")
def script():
    """Return the script that writes the synthetic record."""
    place = importlib.util.spec_from_file_location("it", GALLERY / "seat_test_record.py")
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    return module


def test_synthetic_record_is_what_its_script_writes(script):
    assert script.FILE.read_bytes() == script.text().encode()


def test_synthetic_record_has_level_and_spectrum_of_em1(script):
    motion = record(GALLERY, file=script.FILE.name, time="t", column="u_dd").motion()
    assert (len(motion.u_dd), motion.dt, motion.warnings) == (24_000, 2.5e-3, ())
    assert np.sqrt(np.mean(motion.u_dd**2)) == pytest.approx(1.71, rel=0.05)
    f = np.fft.rfftfreq(24_000, motion.dt)
    power = np.abs(np.fft.rfft(motion.u_dd)) ** 2 * 2 * motion.dt / 24_000
    assert power[(f < 0.88) | (f > 11.23)].max() < 1e-6
    for low, high in ((1.2, 1.7), (1.7, 2.2), (2.2, 2.7), (2.7, 4.0)):
        band = (f >= low) & (f < high)
        assert power[band].mean() == pytest.approx(script.spectrum(f[band]).mean(), rel=0.6)


def test_run_on_a_displacement_is_the_run_on_the_second_derivative_of_its_spline(
    scenario, tmp_path
):
    from scipy.interpolate import CubicSpline

    t = np.arange(2000) * 5e-3
    u = 0.01 * np.sin(2 * np.pi * 1.6 * t) + 0.002 * np.sin(2 * np.pi * 5 * t + 1)
    u_dd = CubicSpline(t, u)(t, 2)
    rows = np.stack([t, u, u_dd], axis=1).tolist()
    text = "".join(",".join(map(repr, row)) + "\n" for row in rows)
    (tmp_path / "r.csv").write_text(f"t [s],u [m],u_dd [m/s2]\n{text}")
    seat = (
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        "friction: {law: coulomb, kinetic: 45, static_ratio: 1.2}\n"
        "excitation: {kind: record, file: r.csv, time: t, column: u_dd}\n"
    )
    theirs = run(scenario(seat))
    ours = run(scenario(seat, excitation__column="u", excitation__quantity="displacement"))
    assert len(ours.events) == len(theirs.events) > 10
    np.testing.assert_allclose(ours.response.x_r, theirs.response.x_r, atol=1e-12)
    assert ours.metrics["T_x"] == pytest.approx(
        theirs.metrics["x_r_rms"] / np.sqrt(np.mean(u**2)), rel=1e-3
    )
