"""Bad records of every format, at the command line: exit 2, and row, column or field named."""

from __future__ import annotations

import numpy as np
import pytest

from drysim import system
from test_record_extras import mdf, tdms, uff
from test_record_formats import at2, mat, wav
from test_record_rpc import rpc

VALUES = np.random.default_rng(1).normal(size=400)
GIVEN = {"acc": VALUES, "b": VALUES}
SHARES = (VALUES * 99).astype(np.int16)
NO_UNITS = {"acc": "", "b": ""}


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
    """Give what `run` and `validate` say of a record: one answer, for they must agree."""

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
    "at2": "the header says NPTS= 400, but there are 399 samples, less: it is cut short",
    "uff": "universal file, or damaged: its last data set does not end",
    "mf4": "MDF, or damaged",
    "tdms": "the TDMS file is cut short: its last segment is not whole",
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
    assert said.startswith(f"error: r.{kind} cannot be used\n\nr.{kind}: ")


@pytest.mark.parametrize("kind", WRITERS)
def test_empty_record_is_refused(answer, tmp_path, kind):
    (tmp_path / f"r.{kind}").touch()
    assert f"r.{kind}: the record is empty" in answer(kind).err


@pytest.mark.parametrize("mark", [",", ";", " "])
def test_record_that_lies_on_its_side_is_refused(answer, tmp_path, mark):
    (tmp_path / "r.csv").write_text(mark.join(["1"] * 20_000) + "\n")
    sentence = "r.csv:1: row 1 has 20000 columns, more than 16384: write one sample a row"
    assert sentence in answer("csv", "unit: g, rate: 1 Hz").err


@pytest.mark.parametrize("kind", WRITERS)
def test_record_beyond_the_memory_is_refused(answer, tmp_path, monkeypatch, kind):
    WRITERS[kind](tmp_path / f"r.{kind}")
    monkeypatch.setattr(system, "memory", lambda: 2000.0)
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


def test_whole_numbers_of_a_wav_ask_for_their_full_scale(answer, tmp_path):
    WRITERS["wav"](tmp_path / "r.wav")
    assert "give `full_scale: 50 m/s²`, say" in answer("wav", "").err


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
    assert "nothing says how the samples are spaced: give `time` (a " in said


def test_wav_of_two_channels_asks_which(answer, tmp_path):
    wav(tmp_path / "r.wav", 50, np.stack([SHARES, SHARES], axis=1))
    assert "give `channel`, its number; there are: 2" in answer("wav").err
