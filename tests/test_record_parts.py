"""A long record is read by parts: a WAV as often as it is needed, a text once."""

from __future__ import annotations

import os
import wave

import numpy as np
import pytest

from drysim.core.model import blocks, largest
from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.records import columns as channels_module
from drysim.records import file as reader_module
from drysim.records import text as cells_module
from drysim.records.columns import Stored

N = 5000
SAMPLES = np.random.Generator(np.random.PCG64(5)).integers(-30_000, 30_000, (N, 2))


@pytest.fixture
def small(monkeypatch):
    """Make every record long: parts of a few bytes."""
    monkeypatch.setattr(channels_module, "KEPT", 0)
    monkeypatch.setattr(reader_module, "WINDOW", 512)
    monkeypatch.setattr(cells_module, "BLOCK", 300)


def wav(folder, width=2):
    """Write a WAV of two channels."""
    with wave.open(str(folder / "r.wav"), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(width)
        file.setframerate(400)
        kind = {1: np.uint8, 2: "<i2", 4: "<i4"}[width]
        file.writeframes((SAMPLES >> 8 if width == 1 else SAMPLES).astype(kind).tobytes())


def record(folder, **words):
    """Give a record in a folder."""
    return Record.model_validate({"kind": "record", **words}, context={"folder": folder})


@pytest.mark.parametrize("width", [1, 2, 4])
def test_long_wav_stays_in_its_file(tmp_path, small, monkeypatch, width):
    wav(tmp_path, width)
    words = {"file": "r.wav", "full_scale": "50 m/s2", "channel": 2, "scale": -2}
    parted = record(tmp_path, **words).motion()
    monkeypatch.undo()
    whole = record(tmp_path, **words).motion()
    assert isinstance(parted.u_dd, Stored)
    assert isinstance(whole.u_dd, np.ndarray)
    assert parted[1:] == whole[1:]
    assert np.array_equal(np.concatenate(list(blocks(parted.u_dd, 77))), whole.u_dd)
    assert largest(parted.u_dd) == np.abs(whole.u_dd).max()


def test_window_of_a_long_wav_stays_in_its_file(tmp_path, small):
    wav(tmp_path)
    words = {"file": "r.wav", "full_scale": "1 m/s2", "channel": 1}
    motion = record(tmp_path, **words, window={"from": 1, "to": 2}).motion()
    assert isinstance(motion.u_dd, Stored)
    assert len(motion.u_dd) == 401
    assert np.array_equal(motion.u_dd[:], SAMPLES[400:801, 0] / 2.0**15)
    assert np.array_equal(motion.u_dd[10:40][::3], motion.u_dd[10:40:3])


def test_long_wav_is_loaded_where_something_is_removed(tmp_path, small):
    wav(tmp_path)
    motion = record(
        tmp_path, file="r.wav", full_scale="1 m/s2", channel=1, remove="mean"
    ).motion()
    assert abs(np.mean(motion.u_dd)) < 1e-15


@pytest.mark.parametrize("how", ["written", "cut", "gone"])
def test_wav_that_changes_while_it_is_needed_is_refused(tmp_path, small, how):
    wav(tmp_path)
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
    rows = [
        "# a remark",
        "n,u_dd [m/s2]",
        *(f"{n},{x!r}" for n, x in enumerate(values.tolist())),
    ]
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
    with pytest.raises(RecordError, match="holds a zero byte"):
        record(tmp_path, file="r.csv", rate=400).motion()
