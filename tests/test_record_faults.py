"""Bad records of every format, at the command line: exit 2, and row, column or field named."""

from __future__ import annotations

import os
import re
import wave

import numpy as np
import pytest

from drysim import system
from drysim.core.model import blocks, max_abs
from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.records import columns as reader_module
from drysim.records import text as cells_module
from drysim.records.columns import LazySamples
from test_record_formats import at2, mat, mdf, rpc, tdms, uff, wav

VALUES = np.random.default_rng(1).normal(size=400)
GIVEN = {"acc": VALUES, "b": VALUES}
SHARES = (VALUES * 99).astype(np.int16)


def text(path, unit=" [g]", mark=","):
    """Write columns of text."""
    rows = "".join(f"{k / 50}{mark}{v!r}\n" for k, v in enumerate(VALUES.tolist()))
    path.write_text(f"t [s]{mark}acc{unit}\n{rows}")


WRITERS = {
    "csv": text,
    "tsv": lambda path: text(path, mark="\t"),
    "wav": lambda path: wav(path, 50, SHARES),
    "mat": lambda path: mat(path, {**GIVEN, "t": np.arange(400) / 50}),
    "at2": lambda path: at2(path, VALUES, ".02"),
    "uff": lambda path: uff(path, GIVEN, units={"acc": "g", "b": "g"}),
    "mf4": lambda path: mdf(path, GIVEN, units={"acc": "g", "b": "g"}),
    "tdms": lambda path: tdms(path, GIVEN, units={"acc": "g", "b": "g"}),
    "rpc": lambda path: rpc(path, GIVEN, ("g", "g")),
}
WORDS = {
    "csv": "time: t",
    "tsv": "time: t",
    "wav": "full_scale: 9 g",
    "mat": "time: t, column: acc, unit: g",
    "at2": "",
    "uff": "channel: acc",
    "mf4": "channel: acc",
    "tdms": "channel: acc",
    "rpc": "channel: acc",
}


@pytest.fixture
def answer(drysim, tmp_path):
    """Return what `run` and `validate` say of a record: one answer, for they must agree."""

    def ask(kind, words=None):
        given = WORDS[kind] if words is None else words
        (tmp_path / "seat.yaml").write_text(
            "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
            f"excitation: {{kind: record, file: r.{kind}, {given}}}\n"
        )
        run = drysim("run", "seat.yaml", "--no-plots")
        checked = drysim("validate", "seat.yaml")
        assert checked.code == run.code
        if run.code:
            assert run.code == 2
            assert not (tmp_path / "out").exists()
            assert run.err.splitlines()[-1] in checked.out
        return run

    return ask


@pytest.mark.parametrize("kind", WRITERS)
def test_sound_record_of_every_format_runs(answer, tmp_path, kind):
    WRITERS[kind](tmp_path / f"r.{kind}")
    assert answer(kind).code == 0


CUT = {
    "csv": "row 401 has 1 cell, not 2",
    "tsv": "row 401, column 2 (`acc [g]`): the cell is empty",
    "wav": "bytes are missing at its end",
    "mat": "bytes are missing at its end",
    "at2": "the header says NPTS= 400, but there are 399 samples, fewer: the file is truncated",
    "uff": "universal file, or it is damaged: its last data set is not terminated",
    "mf4": "MDF file, or it is damaged",
    "tdms": "the TDMS file is truncated: its last segment is incomplete",
    "rpc": "truncated",
}


@pytest.mark.parametrize("kind", WRITERS)
def test_truncated_record_is_refused(answer, tmp_path, kind):
    file = tmp_path / f"r.{kind}"
    WRITERS[kind](file)
    whole = file.read_bytes()
    part = whole[: int(len(whole) * 0.6)]
    if kind in ("csv", "tsv", "at2"):
        at = max(whole.rfind(mark) for mark in (b",", b"\t", b" "))
        part = whole[: at + (kind == "tsv")]
    file.write_bytes(part)
    assert CUT[kind] in answer(kind).err


@pytest.mark.parametrize("kind", WRITERS)
def test_another_file_by_that_name_is_refused(answer, tmp_path, kind):
    (tmp_path / f"r.{kind}").write_bytes(b"PK\3\4" + np.random.default_rng(2).bytes(4000))
    said = answer(kind).err
    assert "the record is" in said
    assert re.match(rf"error: \S+\.yaml: 1 error\n\nr\.{kind}: ", said)


@pytest.mark.parametrize("kind", WRITERS)
def test_absent_and_empty_records_are_refused(answer, tmp_path, kind):
    assert f"r.{kind}: the record does not exist" in answer(kind).err
    (tmp_path / f"r.{kind}").touch()
    assert f"r.{kind}: the record is empty" in answer(kind).err


@pytest.mark.parametrize("mark", [",", ";", " "])
def test_record_that_lies_on_its_side_is_refused(answer, tmp_path, mark):
    (tmp_path / "r.csv").write_text(mark.join(["1"] * 20_000) + "\n")
    sentence = "r.csv:1: row 1 has 20000 columns, more than 16384: write one sample per row"
    assert sentence in answer("csv", "unit: g, rate: 1 Hz").err


@pytest.mark.parametrize("kind", WRITERS)
def test_record_beyond_the_memory_is_refused(answer, tmp_path, monkeypatch, kind):
    WRITERS[kind](tmp_path / f"r.{kind}")
    monkeypatch.setattr(system, "total_memory", lambda: 2000.0)
    assert "GB of memory, this machine has 2e-06 GB" in answer(kind).err


UNITLESS = {
    "csv": (lambda path: text(path, unit=""), "time: t", "column 2 (`acc`) has no unit"),
    "tsv": (lambda path: text(path, "", "\t"), "time: t", "column 2 (`acc`) has no unit"),
    "wav": (lambda path: wav(path, 50, VALUES), "", "channel 1 has no unit"),
    "mat": (WRITERS["mat"], "column: acc, rate: 50", "variable 1 (`acc`) has no unit"),
    "at2": (lambda path: at2(path, VALUES, ".02", unit="X"), "", "series 1 has no unit"),
    "uff": (lambda path: uff(path, GIVEN, units={}), "channel: acc", "1 (`acc`) has no unit"),
    "mf4": (lambda path: mdf(path, GIVEN, units={}), "channel: acc", "1 (`acc`) has no unit"),
    "tdms": (
        lambda path: tdms(path, GIVEN, units={}),
        "channel: acc",
        "1 (`log/acc`) has no unit",
    ),
    "rpc": (lambda path: rpc(path, GIVEN, ("", "")), "channel: acc", "1 (`acc`) has no unit"),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_missing_unit_is_asked_for(answer, tmp_path, kind):
    write, words, sentence = UNITLESS[kind]
    write(tmp_path / f"r.{kind}")
    said = answer(kind, words).err
    assert sentence in said
    assert "write `unit: m/s²` in the scenario" in said


RATELESS = {
    "csv": (WRITERS["csv"], "column: acc"),
    "tsv": (WRITERS["tsv"], "column: acc"),
    "mat": (WRITERS["mat"], "column: acc, unit: g"),
    "tdms": (lambda path: tdms(path, GIVEN, waveform=False), "channel: acc, unit: m/s2"),
}


@pytest.mark.parametrize("kind", RATELESS)
def test_missing_rate_is_asked_for(answer, tmp_path, kind):
    write, words = RATELESS[kind]
    write(tmp_path / f"r.{kind}")
    said = answer(kind, words).err
    assert "the time step is unknown: set `time` (a " in said


# A long record is read by parts: a WAV as often as it is needed, a text once.


N = 5000
SAMPLES = np.random.Generator(np.random.PCG64(5)).integers(-30_000, 30_000, (N, 2))


@pytest.fixture
def small(monkeypatch):
    """Make every record long: parts of a few bytes."""
    monkeypatch.setattr(reader_module, "MAX_CACHED", 0)
    monkeypatch.setattr(reader_module, "READ_SIZE", 512)
    monkeypatch.setattr(cells_module, "PARSE_SIZE", 300)


def part_wav(folder, width=2):
    """Write a WAV of two channels."""
    with wave.open(str(folder / "r.wav"), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(width)
        file.setframerate(400)
        kind = {1: np.uint8, 2: "<i2", 4: "<i4"}[width]
        file.writeframes((SAMPLES >> 8 if width == 1 else SAMPLES).astype(kind).tobytes())


def record(folder, **words):
    """Return a record in a folder."""
    return Record.model_validate({"kind": "record", **words}, context={"folder": folder})


@pytest.mark.parametrize("width", [1, 2, 4])
def test_long_wav_stays_in_its_file(tmp_path, small, monkeypatch, width):
    part_wav(tmp_path, width)
    words = {"file": "r.wav", "full_scale": "50 m/s2", "channel": 2, "scale": -2}
    parted = record(tmp_path, **words).motion()
    monkeypatch.undo()
    whole = record(tmp_path, **words).motion()
    assert isinstance(parted.u_dd, LazySamples)
    assert isinstance(whole.u_dd, np.ndarray)
    assert parted[1:] == whole[1:]
    assert np.array_equal(np.concatenate(list(blocks(parted.u_dd, 77))), whole.u_dd)
    assert max_abs(parted.u_dd) == np.abs(whole.u_dd).max()


def test_window_of_a_long_wav_stays_in_its_file(tmp_path, small):
    part_wav(tmp_path)
    words = {"file": "r.wav", "full_scale": "1 m/s2", "channel": 1}
    motion = record(tmp_path, **words, window={"from": 1, "to": 2}).motion()
    assert isinstance(motion.u_dd, LazySamples)
    assert len(motion.u_dd) == 401
    assert np.array_equal(motion.u_dd[:], SAMPLES[400:801, 0] / 2.0**15)
    assert np.array_equal(motion.u_dd[10:40][::3], motion.u_dd[10:40:3])


def test_long_wav_is_loaded_where_something_is_removed(tmp_path, small):
    part_wav(tmp_path)
    motion = record(
        tmp_path, file="r.wav", full_scale="1 m/s2", channel=1, remove="mean"
    ).motion()
    assert abs(np.mean(motion.u_dd)) < 1e-15


@pytest.mark.parametrize("how", ["written", "cut", "gone"])
def test_wav_that_changes_while_it_is_needed_is_refused(tmp_path, small, how):
    part_wav(tmp_path)
    motion = record(tmp_path, file="r.wav", full_scale="1 m/s2", channel=1).motion()
    path = tmp_path / "r.wav"
    if how == "gone":
        path.unlink()
    elif how == "cut":
        os.truncate(path, 2000)
    else:
        path.write_bytes(path.read_bytes()[:-2] + b"xx")
        os.utime(path, ns=(1, 1))
    with pytest.raises(RecordError, match="the record changed while it was read"):
        motion.u_dd[4000:4100]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("tail", ["", "\n\n\n"])
def test_long_text_is_read_by_parts_whatever_ends_its_lines(tmp_path, small, end, mark, tail):
    values = SAMPLES[:, 0] / 7.0
    rows = ["# a remark", "n,u_dd [m/s2]"]
    rows += [f"{n},{x!r}" for n, x in enumerate(values.tolist())]
    rows.insert(700, "# another")
    text = mark + end.join(rows) + tail.replace("\n", end)
    (tmp_path / "r.csv").write_bytes(text.encode())
    motion = record(tmp_path, file="r.csv", column="u_dd", rate=400).motion()
    assert np.array_equal(motion.u_dd, values)


def test_fault_far_into_a_long_text_is_named_with_its_row(tmp_path, small):
    rows = [f"{x}" for x in SAMPLES[:, 0].tolist()]
    rows[4321] = "x"
    (tmp_path / "r.csv").write_bytes("\r\n".join(["u_dd [m/s2]", *rows]).encode())
    with pytest.raises(RecordError, match=r"row 4323, column 1 .*`x` is not a number"):
        record(tmp_path, file="r.csv", rate=400).motion()


def test_zero_byte_far_into_a_text_is_found(tmp_path, small):
    (tmp_path / "r.csv").write_bytes(b"u_dd [m/s2]\n" + b"1\n" * 4000 + b"\0\n")
    with pytest.raises(RecordError, match="contains a zero byte"):
        record(tmp_path, file="r.csv", rate=400).motion()
