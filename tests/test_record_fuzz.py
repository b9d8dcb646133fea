"""Damaged files of formats that packages read; `fuzz` has those that drysim reads itself."""

from __future__ import annotations

import time

import numpy as np
import pytest

from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from test_record_extras import mdf, tdms, uff
from test_record_rpc import rpc

TRIES, SECONDS = 4000, 8.0
"""What a format gets at most; slow packages get fewer tries."""

VALUES = np.random.default_rng(1).normal(size=60)
GIVEN = {"acc": VALUES, "b": VALUES}

FILES = {
    "r.uff": (lambda path: uff(path, GIVEN), {"channel": "acc"}),
    "text.uff": (lambda path: uff(path, GIVEN, binary=0), {"channel": "acc"}),
    "r.mf4": (lambda path: mdf(path, {"acc": VALUES}), {"channel": "acc"}),
    "r.tdms": (lambda path: tdms(path, GIVEN), {"channel": "acc"}),
    "r.rpc": (lambda path: rpc(path, GIVEN), {"channel": "acc"}),
}


def damaged(whole, rng):
    """Give a file with a few of the faults that disks, cables and editors make."""
    part = bytearray(whole)
    for _ in range(rng.integers(1, 4)):
        at, length = int(rng.integers(len(part) + 1)), int(rng.integers(1, 9))
        match rng.integers(5):
            case 0:
                del part[at:]
            case 1:
                part[at : at + length] = rng.bytes(length)
            case 2:
                del part[at : at + length]
            case 3:
                part[at:at] = rng.bytes(length)
            case 4:
                part[at : at + length] = [b"\0", b"\xff", b"9"][rng.integers(3)] * length
    return bytes(part)


@pytest.mark.slow
@pytest.mark.parametrize(("file", "given"), FILES.items())
def test_damaged_file_gives_a_motion_or_a_sentence(tmp_path, capfd, file, given):
    write, words = given
    write(tmp_path / file)
    whole, rng = (tmp_path / file).read_bytes(), np.random.default_rng(3)
    record = Record.model_validate(
        {"kind": "record", "file": file, **words}, context={"folder": tmp_path}
    )
    assert len(record.motion().u_dd) == len(VALUES)
    end, sentences = time.monotonic() + SECONDS, []
    for _ in range(TRIES):
        (tmp_path / file).write_bytes(damaged(whole, rng))
        try:
            assert np.isfinite(record.motion().u_dd).all()
        except RecordError as error:
            sentences.append(error.problem.sentence)
        if time.monotonic() > end:
            break
    assert sentences
    assert [text for text in sentences if not text or "\n" in text] == []
    assert capfd.readouterr() == ("", "")
