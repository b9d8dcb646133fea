"""Records that are no records: only the regular file that is named is read, and read once."""

from __future__ import annotations

import os
import socket

import pytest

from drysim import system
from drysim.errors import RecordError
from drysim.excitation.recorded import Record
from drysim.records.columns import RecordFile
from drysim.records.record import read_samples
from drysim.scenario.fit import MeasuredResponse

ROWS = "t [s],a [m/s2]\n0,1\n0.1,2\n0.2,4\n"


def read(folder, file="r.csv", **keys):
    """Read a record, with a column of times unless keys say otherwise."""
    words = {"kind": "record", "file": str(file), **(keys or {"time": "t"})}
    return Record.model_validate(words, context={"folder": folder}).motion()


def quoted(action, *words, **keys):
    """Return all that the message on a record quotes of it."""
    with pytest.raises(RecordError) as fault:
        action(*words, **keys)
    return fault.value.problem.sentence + fault.value.problem.source


def refusal(folder, file="r.csv"):
    """Return the message on a record."""
    with pytest.raises(RecordError) as fault:
        read(folder, file)
    return fault.value.problem.sentence


def test_record_behind_a_link_or_beside_the_folder_is_read_as_a_regular_file(tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "scenario").mkdir()
    (tmp_path / "data/r.csv").write_text(ROWS)
    (tmp_path / "scenario/r.csv").symlink_to("../data/r.csv")
    for file in ("r.csv", "../data/r.csv", tmp_path / "data/r.csv"):
        assert len(read(tmp_path / "scenario", file).u_dd) == 3


@pytest.mark.parametrize(
    ("target", "what"),
    [("/dev/zero", "a device"), ("/tmp", "a folder")],
)
def test_record_behind_a_link_is_looked_at_before_it_is_opened(tmp_path, target, what):
    (tmp_path / "r.csv").symlink_to(target)
    assert refusal(tmp_path) == f"the record is {what}; only regular files are supported"


KEY = """\
-----BEGIN OPENSSH PRIVATE KEY-----
b3BlbnNzaC1rZXktdjEAAAAABG5vbmUAAAAEbm9uZQAAAAAAAAABAAAAMwAAAAtz
c2gtZWQyNTUxOQAAACB1
-----END OPENSSH PRIVATE KEY-----
"""
PASSWD = "root:x:0:0:root:/root:/bin/bash\ndaemon:x:1:1:daemon:/usr/sbin:/bin/sh\n"


@pytest.mark.parametrize(
    ("target", "secrets"),
    [
        (KEY, ("BEGIN", "b3Blbn", "c2gtZWQ", "END")),
        (PASSWD, ("root", "daemon")),
        ("hunter2\n1\n2\n", ("hunter2",)),
        ("token [s3cret]\n1\n2\n", ("token", "s3cret")),
        ("token(s3cret)\n1\n2\n", ("token", "s3cret")),
        ("t [s]\n0\nhunter2\n", ("hunter2",)),
        ("a [s`3]\n1\n2\n", ("s`3", "`3", "s`")),
        ("my secret\n1\n2\n", ("my secret",)),
    ],
)
@pytest.mark.parametrize("suffix", [".csv", ".txt", ".at2"])
def test_message_about_a_link_quotes_no_line_of_its_target(tmp_path, target, secrets, suffix):
    (tmp_path / "target").write_text(target)
    (tmp_path / f"r{suffix}").symlink_to("target")
    ways = {"step": 1}, {"step": 1, "column": 1}, {"time": 1, "column": "x"}
    for keys in ways if suffix != ".at2" else [{"scale": 1}]:
        told = quoted(read, tmp_path, f"r{suffix}", **keys)
        assert not [secret for secret in secrets if secret in told]


def test_message_about_a_link_to_the_samples_of_a_rig_quotes_no_line_either(tmp_path):
    (tmp_path / "target").write_text(KEY)
    (tmp_path / "r.csv").symlink_to("target")
    given = {"file": "r.csv", "step": 1, "F_f": 1, "v_r": 2}
    rig = MeasuredResponse.model_validate(given, context={"folder": tmp_path})
    told = quoted(read_samples, rig.record("F_f"))
    assert not [secret for secret in ("BEGIN", "b3Blbn", "c2gtZWQ", "END") if secret in told]


@pytest.mark.parametrize(
    ("cell", "shown"), [("oops", "oops"), ("secret" * 20, ("secret" * 20)[:39] + "…")]
)
def test_message_about_a_link_names_row_and_column_and_40_characters_of_a_cell_at_most(
    tmp_path, cell, shown
):
    (tmp_path / "target").write_text(f"t [s],a [m/s2]\n0,1\n1,{cell}\n")
    (tmp_path / "r.csv").symlink_to("target")
    said = f"row 3, column 2 (`a [m/s2]`): `{shown}` is not a number"
    assert refusal(tmp_path).partition(";")[0] == said


def test_pipe_and_socket_are_no_records_and_nobody_waits(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "r.csv")
    assert refusal(tmp_path) == "the record is a pipe; only regular files are supported"
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as plug:
        plug.bind("s.csv")
        assert refusal(tmp_path, "s.csv").startswith("the record is a socket")
    monkeypatch.setattr(system, "file_size", lambda _: 100)  # between two looks
    assert refusal(tmp_path) == "the record is a pipe; only regular files are supported"


@pytest.mark.skipif(not os.path.exists("/proc/self/environ"), reason="needs /proc")
def test_file_of_the_system_that_claims_no_size_is_empty(tmp_path):
    (tmp_path / "r.csv").symlink_to("/proc/self/environ")
    assert refusal(tmp_path) == "the record is empty"


@pytest.mark.parametrize("change", [-5, 5])
def test_record_that_grows_or_shrinks_while_it_is_read_is_refused(
    tmp_path, monkeypatch, change
):
    (tmp_path / "r.csv").write_text(ROWS)
    whole = len(ROWS)
    monkeypatch.setattr(system, "file_size", lambda _: whole + change)
    assert refusal(tmp_path).startswith("the record changed while it was read")


def test_header_is_quoted_in_few_words_whatever_it_holds(tmp_path):
    cell = "secret" * 100_000
    (tmp_path / "r.csv").write_text(f"t [s],{cell},{cell}\n0,1,2\n1,2,3\n")
    assert len(refusal(tmp_path)) < 300
    (tmp_path / "r.csv").write_text(f"t,a [{cell}]\n0,1\n1,2\n")
    assert len(refusal(tmp_path)) < 300


@pytest.mark.parametrize(
    "text",
    ["root:x:0:0\ndaemon:x:1:1\n", "alpha secret\nbeta hidden\n", "a,secret\nb,hidden\n"],
)
def test_text_that_is_no_table_is_quoted_by_one_cell_alone(tmp_path, text):
    (tmp_path / "r.csv").write_text(text)
    for time in ("t", 1):
        said = quoted(read, tmp_path, time=time)
        assert "is not a number" in said
        assert not [secret for secret in ("secret", "root", "hidden") if secret in said]


@pytest.mark.parametrize("head", [b"", b"t [s],a [m/s2]\n", b"\x7fELF" * 9])
def test_sparse_file_is_refused_before_it_is_hashed(tmp_path, monkeypatch, head):
    with open(tmp_path / "r.csv", "wb") as stream:
        stream.write(head)
        stream.truncate(300_000_000)
    monkeypatch.setattr(RecordFile, "sha256", property(lambda _: pytest.fail("hashed")))
    assert refusal(tmp_path) == "the record is binary: it contains a zero byte"
