"""Files as loggers write them: read right by `init`, `validate` and `run`, or refused by name.

The record of most files is a sine with known samples. A file with a pause, with rows
that are no samples or in another layout must either give these samples at their times, or a
message that names the row and a remedy.
"""

from __future__ import annotations

import math
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import drysim as package
from drysim.errors import DrysimError, RecordError
from drysim.records.clock import find_clock, find_dates, unit_in_name, unit_of_values
from drysim.records.inspection import inspect_record
from drysim.study.draft import write_draft
from drysim.study.preparation import base_motion, prepare

FILES = Path(__file__).parent / "data" / "logger"

START = datetime(2024, 5, 1, 10, 0, 0)


class Expected(NamedTuple):
    """Rate [Hz] and RMS [m/s²] of a file that is read; else parts of what is said about it."""

    rate: float = 0.0
    rms: float = 0.7071
    said: tuple[str, ...] = ()


def judge(record, name="draft"):
    """Draft a scenario for a record and prepare it: its motion, or what is said instead."""
    try:
        file, _ = write_draft(record, name)
    except DrysimError as error:
        return None, str(error)
    said = " ".join(file.read_text().replace("#", " ").split())
    try:
        motion = base_motion(package.load(file))
    except DrysimError as error:
        return None, f"{said} {error}"
    said += " " + " ".join(one.sentence for one in motion.warnings)
    return motion, said


def check(record, expected):
    """Check what becomes of a record: right, or a message that names row and remedy."""
    motion, said = judge(record)
    for part in expected.said:
        assert part in said, said
    if not expected.rate:
        assert motion is None, said
        return
    assert motion is not None, said
    assert 1 / motion.dt == pytest.approx(expected.rate, rel=1e-3)
    assert np.std(motion.u_dd[:]) == pytest.approx(expected.rms, rel=0.01)


NO_UNIT = ("time_unit:", "s, ms or us?")
SPECTRUM = Expected(said=("this is a spectrum",))

OF_FILES = {
    "clock-pause.csv": Expected(said=("at 100 Hz", "before row 8")),
    "count-by-2.csv": Expected(said=("sample numbers", "excitation.rate has no value")),
    "excel-day.csv": Expected(100, 0.6508),
    "loop-table.csv": Expected(said=("does not contain the times",)),
    "na.csv": Expected(100, 0.6516, said=("before row 8",)),
    "percent-units.csv": Expected(said=("excitation.unit has no value",)),
    "psd-table-units.csv": SPECTRUM,
    "psd-table.csv": SPECTRUM,
    "restart.csv": Expected(said=("row 8", "a second record begins here")),
    "sensors.csv": Expected(said=("S1, S2, S3 in turn", "where: {sensor: S1}")),
    "sentinel.csv": Expected(100, 0.6516, said=("missing: -9999", "before row 8")),
    "serial-row.csv": Expected(100, 0.6773, said=("row 3 is no sample",)),
    "srs-table.csv": SPECTRUM,
    "step-2s.csv": Expected(said=NO_UNIT),
    "summary.csv": Expected(100, 0.6508, said=("rows 14 to 16", "`Max`, `Min`")),
    "thousands.csv": Expected(100, 0.6508 * 9.80665e-3),
    "time-cell.csv": Expected(said=("row 5", "the time is missing")),
    "time-ms-pause.csv": Expected(said=("before row 8", "fill: line, at_most:")),
    "time-us.csv": Expected(1000, 0.6508),
    "times-only.csv": Expected(said=("no other column of numbers",)),
    "unsorted.csv": Expected(said=("row 21", "time decreases", "sort the rows by time")),
    "wide.txt": Expected(said=("one series of 48 samples", "skiprows=1")),
}


@pytest.mark.parametrize("name", OF_FILES)
def test_file_is_read_right_or_refused_with_row_and_remedy(place, name):
    check(FILES / name, OF_FILES[name])


# Clock readings.


@pytest.mark.parametrize(
    "form",
    [
        "%Y-%m-%d %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%fZ", "%Y-%m-%dT%H:%M:%S.%f+02:00",
        "%Y/%m/%d %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S,%f", "%d.%m.%y %H:%M:%S.%f",
        "%d/%m/%Y %H:%M:%S.%f", "%m/%d/%Y %I:%M:%S.%f %p", "%m/%d/%y %H:%M:%S.%f",
        "%d-%b-%Y %H:%M:%S.%f", "%d %b %Y %H:%M:%S.%f", "%b %d, %Y %I:%M:%S.%f %p",
        "%Y%m%d %H:%M:%S.%f", "%H:%M:%S.%f", "%I:%M:%S.%f %p", "%H:%M:%S,%f",
    ],
)  # fmt: skip
def test_clock_reading_in_a_common_form_is_read_across_midnight(place, form):
    random = np.random.default_rng(sum(map(ord, form)))
    first = datetime(2024, 4, 30, 23, 59, 58) + timedelta(days=int(random.integers(0, 300)))
    rows = 400
    t = [first + timedelta(milliseconds=10 * i) for i in range(rows)]
    lines = (f"{one.strftime(form)};{math.sin(0.1257 * i):.4f}" for i, one in enumerate(t))
    Path("clock.csv").write_text("Time;a [m/s2]\n" + "\n".join(lines) + "\n")
    check(Path("clock.csv"), Expected(100))


def test_time_of_day_takes_its_date_from_a_column_of_its_own(place):
    t = [datetime(2024, 2, 28, 23, 59, 59) + timedelta(milliseconds=20 * i) for i in range(200)]
    t[100:] = [one + timedelta(days=1) for one in t[100:]]
    lines = (f"{one:%d.%m.%Y},{one:%H:%M:%S.%f},{i % 7}" for i, one in enumerate(t))
    Path("r.csv").write_text("Date,Time,a [m/s2]\n" + "\n".join(lines) + "\n")
    _, said = judge(Path("r.csv"))
    assert "time: Time" in said
    assert "4320000 samples are missing before this row" in said
    assert "before row 102" in said


@pytest.mark.parametrize("noon", [False, True])
def test_twelve_o_clock_is_midnight_or_noon(noon):
    text = f"12:30:00 {'PM' if noon else 'AM'}"
    assert find_clock(text, text).seconds(text) == 1800 + 43200 * noon


def test_day_and_month_are_told_apart_by_the_shorter_record():
    assert find_dates("05/01/2024", "05/02/2024").date_format == "%m/%d/%Y"
    assert find_dates("01/05/2024", "02/05/2024").date_format == "%d/%m/%Y"
    assert find_dates("13/05/2024", "14/05/2024").date_format == "%d/%m/%Y"
    assert find_dates("99/99/2024", "99/99/2024") is None


@pytest.mark.parametrize(
    "text",
    ["10:00", "10:61:00", "10:00:61", "13:00:00 PM", "2024-13-01 10:00:00", "10:00:00 x",
     "1:2:3", "25:00:00 AM", "2024-05-01 24:00:00", "", "nan", "12:00:00:12"],
)  # fmt: skip
def test_what_is_no_clock_reading_is_not_read_as_one(text):
    clock = find_clock(text, text)
    assert clock is None or math.isnan(clock.seconds(text))


@pytest.mark.parametrize(
    ("name", "unit"),
    [("time_us", "us"), ("t_ms", "ms"), ("Time ms", "ms"), ("millis", "ms"), ("ms", "ms"),
     ("elapsed_seconds", "s"), ("Zeit_s", "s"), ("timestamp_ns", "ns"), ("time.min", "min"),
     ("time", ""), ("s", ""), ("NS", ""), ("Min", ""), ("count_ms", ""), ("acc_s", "")],
)  # fmt: skip
def test_unit_at_the_end_of_the_name_of_times_counts(name, unit):
    assert unit_in_name(name) == unit


@pytest.mark.parametrize("seed", range(4))
def test_times_since_an_epoch_identify_their_unit(seed):
    random = np.random.default_rng(seed)
    t = random.uniform(1.1e9, 3.9e9) + np.arange(100) * 1e-2
    for unit, second in (("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)):
        assert unit_of_values(t * second) == unit
    days = random.uniform(30000, 60000) + np.arange(100) * 1e-2 / 86400
    assert unit_of_values(days) == "d"
    assert unit_of_values(np.arange(100) * 1e-2) == ""
    assert unit_of_values(np.array([45000.0, 45001.0, 45002.0])) == ""


# Drawn files.


def drawn_file(seed):
    """Return the text of a drawn logger file and what is expected of it."""
    random = np.random.default_rng(seed)
    rate = float(random.choice([50, 100, 128, 200, 250, 500]))
    count = int(random.integers(300, 800))
    mark = str(random.choice([",", ";", "\t"]))
    t = np.arange(count) / rate
    a = np.sin(2 * np.pi * 2.0 * t)
    pause = float(random.choice([0.0, 0.0, 1.7, 6.0]))
    at = int(random.integers(100, count - 100))
    t[at:] += pause
    form = str(random.choice(["s", "ms", "us", "epoch", "clock", "date", "ampm", "excel"]))
    if form in ("s", "ms", "us"):
        factor = {"s": 1.0, "ms": 1e3, "us": 1e6}[form]
        digits = {"s": 6, "ms": 4, "us": 1}[form]
        name = str(random.choice([f"t [{form}]", f"time_{form}", f"Time ({form})"]))
        texts = [f"{one * factor:.{digits}f}" for one in t]
    elif form == "epoch":
        name, texts = "timestamp", [f"{1_714_557_600_000 + one * 1e3:.0f}" for one in t]
        if rate == 128:
            texts = [f"{1_714_557_600 + one:.6f}" for one in t]
    elif form == "excel":
        name, texts = "Date", [f"{45_413 + one / 86400:.11f}" for one in t]
    else:
        pattern = {
            "clock": "%H:%M:%S.%f", "date": "%Y-%m-%d %H:%M:%S.%f", "ampm": "%I:%M:%S.%f %p",
        }[form]  # fmt: skip
        name = "Time"
        texts = [
            (START + timedelta(microseconds=round(one * 1e6))).strftime(pattern) for one in t
        ]
    head = ["Logger 7", "Run 12"] if random.random() < 0.3 else []
    trailing = mark if random.random() < 0.3 else ""
    foot = [f"Max{mark}1.0", f"RMS{mark}0.7"] if random.random() < 0.3 else []
    if seed % 2:
        foot = [one.lstrip("MaxRS") for one in foot]
    status = random.random() < 0.3
    names = [name, "acc [m/s2]"] + ["Status"] * status
    cells = [[text, f"{x:.5f}"] + ["OK"] * status for text, x in zip(texts, a, strict=True)]
    lost = int(random.integers(20, 80)) if random.random() < 0.3 else 0
    if lost:
        cells[lost][1] = str(random.choice(["#N/A", "OL", "", "NaN"]))
    if status:
        foot = [f"{one}{mark}" for one in foot]
    lines = [*head, mark.join(names), *(mark.join(row) + trailing for row in cells), *foot]
    row = len(head) + 2 + at
    text = "\n".join(lines) + "\n"
    if mark != "," and random.random() < 0.3 and form not in ("clock", "date", "ampm"):
        text = text.replace(".", ",")
    if pause:
        return text, Expected(said=(f"before row {row}", "window: {"))
    return text, Expected(rate, float(a.std()))


@pytest.mark.parametrize("seed", range(50))
def test_drawn_logger_file_is_read_right_or_its_pause_is_named(place, seed):
    text, expected = drawn_file(seed)
    Path("drawn.csv").write_text(text)
    check(Path("drawn.csv"), expected)


# Scenarios.


def motion_of(tmp_path, text, name="r.csv", **words):
    """Return the base motion of a record with the given keys."""
    (tmp_path / name).write_text(text)
    return base_motion(
        package.Scenario.model_validate(
            {
                "drysim": 1,
                "oscillator": {"mass": 75, "stiffness": 7500, "damping": 500},
                "friction": {"law": "coulomb", "kinetic": 45},
                "excitation": {"kind": "record", "file": str(tmp_path / name), **words},
            }
        )
    )


def table(t, a, name="t"):
    """Return a table of times as they are, and samples."""
    return f"{name},a [m/s2]\n" + "".join(
        f"{one},{x:.6f}\n" for one, x in zip(t, a, strict=True)
    )


A = np.sin(np.arange(200) * 0.1)


@pytest.mark.parametrize(
    ("name", "times", "words", "step"),
    [
        ("time_ms", range(200), {}, 1e-3),
        ("time_us", range(0, 200_000, 1000), {}, 1e-3),
        ("t", range(200), {}, 1.0),
        ("t", range(200), {"time_unit": "ms"}, 1e-3),
        ("t", range(200), {"time_unit": "us"}, 1e-6),
        ("when", range(1_714_557_600_000, 1_714_557_602_000, 10), {}, 1e-2),
        ("when", [f"10:00:{i // 100:02d}.{i % 100:02d}" for i in range(200)], {}, 1e-2),
    ],
)
def test_times_of_a_scenario_have_the_unit_that_init_finds(tmp_path, name, times, words, step):
    motion = motion_of(tmp_path, table(times, A, name), time=name, **words)
    assert motion.dt == pytest.approx(step, rel=1e-9)


def test_unit_of_times_is_refused_beside_another_one_and_without_times(tmp_path):
    with pytest.raises(RecordError, match=r"says `s`, the scenario says `ms`"):
        motion_of(tmp_path, table(range(200), A, "t [s]"), time="t", time_unit="ms")
    clock = [f"10:00:{i // 100:02d}.{i % 100:02d}" for i in range(200)]
    with pytest.raises(RecordError, match="remove `time_unit`"):
        motion_of(tmp_path, table(clock, A), time="t", time_unit="ms")
    with pytest.raises(ValueError, match="needs `time`"):
        motion_of(tmp_path, table(range(200), A), rate=100, time_unit="ms")


def test_pause_of_a_clock_in_a_scenario_is_named_and_its_window_works(tmp_path):
    seconds = [i + 500 * (i >= 120) for i in range(200)]
    clock = [f"10:00:{i // 100:02d}.{i % 100:02d}" for i in seconds]
    with pytest.raises(RecordError, match=r"window: \{to: 36001.19 s\}"):
        motion_of(tmp_path, table(clock, A), time="t")
    motion = motion_of(tmp_path, table(clock, A), time="t", window={"to": "36001.19 s"})
    assert np.array_equal(motion.u_dd[:], np.round(A[:120], 6))


ROWS_OF_THREE = "t,sensor,a [m/s2]\n" + "".join(
    f"{i / 100:.2f},S{i % 3 + 1},{(i % 3 + 1) * A[i]:.6f}\n" for i in range(198)
)


def test_rows_of_sensors_in_turn_are_named_and_selected(tmp_path):
    every = motion_of(tmp_path, ROWS_OF_THREE, time="t", column="a")
    assert [one.slug for one in every.warnings if one.slug == "record-rows"] == ["record-rows"]
    for number in (1, 2, 3):
        where = {"where": {"sensor": f"S{number}"}}
        one = motion_of(tmp_path, ROWS_OF_THREE, time="t", column="a", rows=where)
        expected = np.round(number * A[number - 1 : 198 : 3], 6)
        assert one.dt == pytest.approx(0.03)
        assert np.array_equal(one.u_dd[:], expected)
        assert not any(warning.slug == "record-rows" for warning in one.warnings)


def test_labels_that_seldom_change_are_no_sensors(tmp_path):
    text = ROWS_OF_THREE
    for number in (1, 2, 3):
        text = text.replace(f",S{number},", ",OK,")
    motion = motion_of(tmp_path, text.replace("OK", "LOW", 3), time="t", column="a")
    assert not any(warning.slug == "record-rows" for warning in motion.warnings)


@pytest.mark.parametrize("words", [{"time": "t"}, {"rate": 100}])
def test_statistics_below_the_samples_are_refused_and_left_out_on_request(tmp_path, words):
    sound = table([f"{i / 100:.2f}" for i in range(200)], A)
    text = sound + "Max,1.0\nMin,-1.0\nRMS,0.7\n"
    keys = {"column": "a", **words}
    with pytest.raises(
        RecordError, match=r"row 202, .*`Max` is not a number.*rows: \{to: 201\}"
    ):
        motion_of(tmp_path, text, **keys)
    cut = motion_of(tmp_path, text, **keys, rows={"to": 201})
    assert np.array_equal(cut.u_dd[:], motion_of(tmp_path, sound, **keys).u_dd[:])


@pytest.mark.parametrize("words", [{"time": "t"}, {"rate": 100}])
@pytest.mark.parametrize("is_sample", [False, True])
def test_advice_on_a_damaged_row_keeps_the_samples_in_place(tmp_path, words, is_sample):
    lines = table([f"{i / 100:.2f}" for i in range(200)], A).splitlines()
    above, below = lines[:100], lines[101 if is_sample else 100 :]
    keys = {"column": "a", "gaps": {"fill": "spline", "at_most": "30 ms"}, **words}
    advice = (
        "if it is no sample, delete it; if it was a sample, `gaps` fills it: delete it, or "
    )
    with pytest.raises(RecordError, match=f"{advice}with `rate` or `step` leave it empty"):
        motion_of(tmp_path, "\n".join([*above, lines[0], *below]) + "\n", **keys)
    row = [""] if is_sample and "rate" in words else []
    motion = motion_of(tmp_path, "\n".join([*above, *row, *below]) + "\n", **keys)
    assert motion.u_dd[:] == pytest.approx(A, abs=1e-4)


def test_row_without_samples_below_the_header_is_left_out_on_request(tmp_path):
    text = "Time,Acc\ns,m/s2\n,SN 12345\n" + table([i / 100 for i in range(200)], A)[11:]
    with pytest.raises(RecordError, match="row 3"):
        motion_of(tmp_path, text, time="Time", column="Acc")
    motion = motion_of(tmp_path, text, time="Time", column="Acc", rows={"from": 4})
    assert np.array_equal(motion.u_dd[:], np.round(A, 6))


def test_second_record_in_a_file_is_read_by_its_rows(tmp_path):
    once = [f"{i / 100:.2f}" for i in range(200)]
    text = table(once, A) + table(once, -A).partition("\n")[2]
    with pytest.raises(RecordError, match=r"row 202.*`rows: \{to: 201\}` reads the first"):
        motion_of(tmp_path, text, time="t")
    first = motion_of(tmp_path, text, time="t", rows={"to": 201})
    second = motion_of(tmp_path, text, time="t", rows={"from": 202})
    assert np.array_equal(first.u_dd[:], -np.asarray(second.u_dd[:]))


@pytest.mark.parametrize("columns", [3, 8, 10])
@pytest.mark.parametrize("seed", range(3))
def test_series_across_rows_is_told_from_sensors_side_by_side(tmp_path, columns, seed):
    random = np.random.default_rng(seed)
    count = columns * 60
    series = np.sin(np.arange(count) * 0.15) + 0.01 * random.standard_normal(count)
    across = "\n".join(
        " ".join(f"{x:9.4f}" for x in row) for row in series.reshape(-1, columns)
    )
    words = {"column": 1, "unit": "m/s2", "rate": 100}
    found = motion_of(tmp_path, across, "r.txt", **words).warnings
    assert "record-rows" in [one.slug for one in found]
    levels = random.normal(size=columns) * random.choice([0.0, 1.0])
    gains = random.uniform(0.5, 2.0, columns)
    beside = np.sin(np.arange(count) * 0.15)[:, None] * gains + levels
    beside += 0.01 * random.standard_normal(beside.shape)
    text = "\n".join(" ".join(f"{x:9.4f}" for x in row) for row in beside)
    found = motion_of(tmp_path, text, "r.txt", **words, gravity="keep").warnings
    assert "record-rows" not in [one.slug for one in found]


def test_points_between_thousands_are_told_from_decimal_points(tmp_path):
    t = [f"{i * 10:,}".replace(",", ".") for i in range(200)]
    text = "t [ms];a [mg]\n" + "".join(
        f"{one};{f'{x * 1e3:.2f}'.replace('.', ',')}\n" for one, x in zip(t, A, strict=True)
    )
    assert motion_of(tmp_path, text, time="t").dt == pytest.approx(0.01)
    # Numbers with three digits behind a point in every row are decimal.
    t = [f"{1 + i / 1000:.3f}" for i in range(200)]
    text = "t [s];a [m/s2]\n" + "".join(f"{one};{x:.3f}\n" for one, x in zip(t, A, strict=True))
    assert motion_of(tmp_path, text, time="t").dt == pytest.approx(0.001)
    whole = [str(round(1e4 * x)) for x in A]
    grouped = [f"{round(1e4 * x):,}".replace(",", ".") for x in A]
    for values in (whole, grouped):
        text = "a [mg]\n" + "\n".join(values)
        motion = motion_of(tmp_path, text, "r.txt", rate=100)
        assert motion.u_dd[:] == pytest.approx(np.round(1e4 * A) * 9.80665e-3, abs=1e-9)
    # A number with both marks is unambiguous, whatever the others look like.
    for mark, decimal in (("t [s],a [mg]", "."), ("t [s];a [mg]", ",")):
        numbers = [f"{1e4 * x:,.1f}" for x in A]
        if decimal == ",":
            numbers = [x.translate({44: ".", 46: ","}) for x in numbers]
        rows = [f'{i}{mark[5]}"{x}"' for i, x in enumerate(numbers)]
        text = "\n".join([mark, *rows])
        motion = motion_of(tmp_path, text, time="t")
        assert motion.u_dd[:] == pytest.approx(np.round(1e4 * A, 1) * 9.80665e-3, abs=1e-9)
        assert inspect_record(tmp_path / "r.csv").columns[0].missing == 0
    with pytest.raises(RecordError, match="has marks between thousands; remove them"):
        motion_of(tmp_path, f"{text}\n200;1 234.5", time="t")


@pytest.mark.parametrize("text", ["ts_ms,acc_g\n", "stamp,acc_g\n", "s;g\n", "s;m/s²\n"])
def test_times_and_units_are_recognised_by_name_size_and_header(tmp_path, monkeypatch, text):
    mark, (start, step) = (text[5], (1_778_000_000_000, 5)) if "," in text else (";", (0, 5e-3))
    rows = [f"{start + i * step:.13g}{mark}{x:.5f}" for i, x in enumerate(A)]
    monkeypatch.chdir(tmp_path)
    Path("r.csv").write_text(text + "\n".join(rows), encoding="utf-8")
    motion, said = judge(Path("r.csv"))
    assert motion is not None, said
    assert motion.dt == pytest.approx(5e-3)
    unit = 9.80665 if "g" in text else 1.0
    assert motion.u_dd[:] == pytest.approx(unit * A, abs=1e-4)
    assert ("ms since 1970, from 2026-05-05 16:53:20 UTC" in said) == ("," in text)


LVM = (
    "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\t{columns}\n"
    "***End_of_Header***\n\t\nChannels\t2\nSamples\t200\t200\nY_Unit_Label\tg\tg\n"
    "X_Dimension\tTime\tTime\nX0\t0.0\t0.0\nDelta_X\t0.002\t0.002\n***End_of_Header***\n"
    "X_Value\tfloor\tseat\tComment\n"
)


@pytest.mark.parametrize("columns", ["No", "One"])
def test_labview_measurement_has_its_units_and_times(tmp_path, columns):
    lines = [
        f"{i * 0.002:.3f}" * (columns == "One") + f"\t{x:.6f}\t{-x:.6f}"
        for i, x in enumerate(A)
    ]
    text = LVM.format(columns=columns) + "\n".join(lines) + "\n"
    words = {"time": "X_Value"} if columns == "One" else {}
    motion = motion_of(tmp_path, text, "r.lvm", column="floor", **words)
    assert motion.dt == pytest.approx(0.002)
    assert motion.u_dd[:] == pytest.approx(np.round(A, 6) * 9.80665)


@pytest.mark.parametrize(
    ("line", "key", "value"),
    [
        ("Sampling rate: 100 Hz", "rate", "100 Hz"),
        ("SAMPLING_INTERVAL_S: 0.005000", "step", "0.005 s"),
        ("% Acquisition rate: 1.0e+02 Hz", "rate", "100 Hz"),
        ("Sampling Freq(Hz)  100Hz", "rate", "100 Hz"),
        ("Abtastrate: 1 kHz", "rate", "1 kHz"),
        ("Sample Interval = 2 ms", "step", "2 ms"),
        ("Fs=256", "rate", "256 Hz"),
        ("Sampling rate: 51200", "rate", "51200 Hz"),
        ("Sampling rate: 51,200", "rate", None),
        ("Sample Rate: 1,000 Hz", "rate", None),
        ("Data rate: 1,024 S/s", "rate", None),
        ("Sample Interval: 2,500 us", "step", None),
        ("Sample Interval: 0.5", "step", None),
        ("Abtastrate: 51,2 kHz", "rate", "51.2 kHz"),
        ("Abtastintervall: 0,005 s", "step", "0.005 s"),
        ("Sampling rate: 1.024 kHz", "rate", "1.024 kHz"),
        ("Sampling rate: 1,024.0 Hz", "rate", "1024 Hz"),
        ("Sampling rate: 1,024,000 Hz", "rate", "1024000 Hz"),
    ],
)
def test_rate_above_the_rows_is_proposed(tmp_path, line, key, value):
    file = tmp_path / "r.txt"
    file.write_text(f"Site 4\n{line}\nUnits: cm/s^2\n" + "\n".join(f"{x:.4f}" for x in A))
    found = {one.key: one for one in inspect_record(file).proposals}
    assert found[key].value == value
    assert "row 2" in found[key].reason
    assert found["unit"].value == "cm/s^2"


@pytest.mark.parametrize("mark", [",", "."])
def test_mark_in_a_rate_that_may_stand_between_thousands_is_asked_about(tmp_path, mark):
    dice, file = np.random.default_rng(ord(mark)), tmp_path / "r.txt"
    for decimal in ",.":
        rows = "\n".join(f"{x:.4f}".replace(".", decimal) for x in A)
        number = f"{dice.integers(1, 1000)}{mark}{dice.integers(0, 1000):03d}"
        file.write_text(f"Sampling rate: {number} Hz\nacc [m/s2]\n{rows}\n")
        (rate,) = [one for one in inspect_record(file).proposals if one.key == "rate"]
        if mark == "." == decimal:
            assert float(rate.value.split()[0]) == pytest.approx(float(number))
        else:
            assert rate.value is None
            plain = number.replace(mark, ".")
            assert f": {float(plain):g} or {int(number.replace(mark, ''))}?" in rate.reason
    file.write_text(f"Sampling rate: 400\nacc [m/s2]\n{rows}\n")
    (rate,) = [one for one in inspect_record(file).proposals if one.key == "rate"]
    assert rate.reason.endswith("without a unit: taken as Hz")
    assert not rate.is_certain


@pytest.mark.parametrize(("unit", "value"), [("V", None), ("m/s2", "m/s2"), ("mm", "mm")])
def test_units_of_columns_above_the_header_count(tmp_path, unit, value):
    rows = "".join(f"{i / 100:.2f},{1 + x:.4f}\n" for i, x in enumerate(A))
    (tmp_path / "r.csv").write_text(
        f"% Logger\n% Time (s), Input 1 ({unit})\nTime,disp1\n{rows}"
    )
    found = {one.key: one for one in inspect_record(tmp_path / "r.csv").proposals}
    assert found["unit"].value == value
    assert "row 2" in found["unit"].reason
    assert ("quantity" in found) == (unit == "mm")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("r.xls", "save the sheet as CSV"), ("r.xlsx", "save the sheet as CSV"),
        ("r.ns", "ObsPy"), ("r.v2", "ObsPy"), ("r.mseed", "ObsPy"), ("r.zip", "unpack it"),
        ("r.blf", "export it"), ("r.npy", "CSV"),
    ],
)  # fmt: skip
def test_file_of_another_format_is_refused_with_a_remedy(tmp_path, name, remedy):
    (tmp_path / name).write_bytes(b"anything")
    with pytest.raises(RecordError, match=remedy):
        inspect_record(tmp_path / name)


@pytest.mark.parametrize(
    "begin", ["Origin Time       2011/03/11 14:46:00", "Corrected accelerogram 1"]
)
def test_seismic_text_is_recognised_and_refused(tmp_path, begin):
    (tmp_path / "r.txt").write_text(f"{begin}\nLat. 38\n" + "1 2 3 4 5 6 7 8\n" * 20)
    with pytest.raises(RecordError, match=r"ObsPy"):
        inspect_record(tmp_path / "r.txt")


def test_draft_of_many_columns_stays_short(place):
    t = np.arange(100) / 100
    beside = np.sin(np.arange(300)[None, :] + 7 * t[:, None])
    names = ",".join(f"c{i} [g]" for i in range(300))
    rows = "\n".join(
        f"{one:.2f}," + ",".join(f"{x:.3f}" for x in row)
        for one, row in zip(t, beside, strict=True)
    )
    Path("many.csv").write_text(f"t [s],{names}\n{rows}\n")
    file, _ = write_draft(Path("many.csv"))
    assert len(file.read_text().splitlines()) < 100


@pytest.mark.parametrize("word", ["#N/A", "OL", "#DIV/0!", "-OVL", "OVERFLOW"])
def test_cell_of_a_spreadsheet_or_an_overload_is_a_gap_and_no_comment(tmp_path, word):
    cells = [f"{x:.6f}" for x in A]
    cells[50] = word
    text = "a [m/s2]\n" + "\n".join(cells) + "\n"
    with pytest.raises(RecordError, match="row 52"):
        motion_of(tmp_path, text, rate=100)
    gaps = {"fill": "spline", "at_most": "30 ms"}
    motion = motion_of(tmp_path, text, rate=100, gaps=gaps)
    assert motion.u_dd[:] == pytest.approx(A, abs=1e-4)


def test_record_far_shorter_than_a_natural_period_is_a_warning(drysim, tmp_path):
    text = "t_us,a [m/s2]\n" + "".join(f"{i},{x:.6f}\n" for i, x in enumerate(A))
    (tmp_path / "r.csv").write_text(text)
    (tmp_path / "s.yaml").write_text(
        "drysim: 1\noscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        "friction: {law: coulomb, kinetic: 45}\n"
        "excitation: {kind: record, file: r.csv, time: t_us}\n"
    )
    warnings = prepare(package.load(tmp_path / "s.yaml")).warnings
    assert "record-short" in [warning.slug for warning in warnings]
    assert "far less than the natural period" in drysim("validate", "s.yaml").out
    free = drysim("validate", "s.yaml", "--set", "oscillator.stiffness=0")
    assert "natural period" not in free.out


# Times that repeat or fall.


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S", "epoch"])
@pytest.mark.parametrize("seed", range(6))
def test_pause_of_a_clock_of_whole_seconds_is_named(place, seed, form):
    dice = np.random.default_rng(seed)
    rate, n = int(dice.integers(20, 200)), 1000
    at, pause = int(dice.integers(300, 700)), dice.uniform(0.6, 9.0)
    t = np.arange(n) / rate + dice.uniform(0, 1)
    (first, last), record = (dice.uniform(0, 6, 2) for _ in range(2)), Path("r.csv")
    rows = {}
    for name, times in {"even": t, "pause": t + pause * (np.arange(n) >= at)}.items():
        whole = [START + timedelta(seconds=math.floor(one)) for one in times]
        cells = [
            f"{round(one.timestamp())}" if form == "epoch" else one.strftime(form)
            for one in whole
        ]
        waves = (math.sin(0.1 * k + first[0]) + math.sin(0.17 * k + last[0]) for k in range(n))
        lines = (f"{cell},{x:.4f}\n" for cell, x in zip(cells, waves, strict=True))
        record.write_text("timestamp,a [m/s2]\n" + "".join(lines))
        rows[name] = judge(record, name)
    motion, said = rows["even"]
    assert motion is not None, said
    assert "every printed time agrees" in said
    assert 1 / motion.dt == pytest.approx(rate, rel=0.01)
    motion, said = rows["pause"]
    assert motion is None
    assert "are missing: read one part, such as `rows: {from: " in said
    line = int(said.split("{from: ")[1].split("}")[0])
    assert at + 2 <= line <= at + 2 + rate
    assert "if only the printed times are inaccurate" not in said


@pytest.mark.parametrize(
    "time", [f"{x}e{sign}{'9' * 20}" for x in (0, 1) for sign in ("", "-")]
)
def test_exponent_beyond_every_number_is_a_fault_of_its_row(place, time):
    rows = [f"{0.02 * k:.2f},{k % 7}" for k in range(40)]
    rows[3] = f"{time},1"
    Path("r.csv").write_text("\n".join(["t [s],a [g]", *rows]))
    Path("s.yaml").write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\nfriction: {kinetic: 5 N}\n"
        "excitation: {kind: record, file: r.csv, column: a, time: t}\n"
    )
    with pytest.raises(DrysimError, match="row 5"):
        base_motion(package.load("s.yaml"))


@pytest.mark.parametrize("step", ["0.01", "0.005"])
def test_falling_times_are_to_be_sorted(tmp_path, step):
    dice = np.random.default_rng(len(step))
    for digits in (2, 3):
        n = int(dice.integers(50, 400))
        t = np.arange(n)[::-1] * float(step) + dice.uniform(0, 100)
        lines = (f"{one:.{digits}f},{k % 7}\n" for k, one in enumerate(t))
        (tmp_path / "r.csv").write_text("t [s],a [m/s2]\n" + "".join(lines))
        (time,) = [
            one for one in inspect_record(tmp_path / "r.csv").proposals if one.key == "time"
        ]
        assert time.value is None
        assert time.reason.endswith("sort the rows by time; then `time: t`")
        assert "rows: {" not in time.reason


def test_one_row_of_a_later_time_above_a_record_is_left_out(tmp_path):
    lines = (f"{one:.2f},{k % 7}\n" for k, one in enumerate([5.0, *np.arange(90) / 100]))
    (tmp_path / "r.csv").write_text("t [s],a [m/s2]\n" + "".join(lines))
    (time,) = [one for one in inspect_record(tmp_path / "r.csv").proposals if one.key == "time"]
    assert time.reason.endswith("`rows: {from: 3}` leaves the rows above out; then `time: t`")


@pytest.mark.parametrize("end", [" Hz;\n\n", " Hz;\n", ";\n\n", ";\n"])
@pytest.mark.parametrize("delimiter", [";", ": "])
def test_header_below_a_preamble_is_found(tmp_path, end, delimiter):
    """The preamble may have the delimiter of the rows, and numbers in its last line."""
    preamble = f"Model{delimiter}MSR 175;\nSerial{delimiter}4711;\nRate{delimiter}256{end}"
    rows = "".join(f"14.03.2026 09:26:{k:02d},125;0,{k:03d};21,3\n" for k in range(60))
    text = f"{preamble}Zeit;Boden Z [g];Temp [K]\n{rows}"
    (tmp_path / "r.csv").write_text(text)
    header = text[: text.index("Zeit")].count("\n") + 1
    inspection = inspect_record(tmp_path / "r.csv")
    layout = f"3 columns delimited by semicolons, decimal commas, header in row {header}"
    assert inspection.layout[0] == layout
    values = {proposal.key: proposal.value for proposal in inspection.proposals}
    assert (values["skip"], values["column"]) == (header - 1, "Boden Z")
    assert "rows" not in values
