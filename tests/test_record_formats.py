"""Records from files that other programs write: WAV, MAT and AT2."""

from __future__ import annotations

import re
import struct
import sys
import tracemalloc
import warnings
import wave
from contextlib import suppress

import numpy as np
import pytest
from pydantic import ValidationError

from drysim import system
from drysim.cli import main
from drysim.errors import RecordError, ScenarioError
from drysim.excitation.recorded import Record
from drysim.records.inspection import inspect_record
from drysim.scenario.load import load

RATE = 400


def motion_of(folder, file, **words):
    """Return the motion of a record."""
    words = {"kind": "record", "file": file, **words}
    return Record.model_validate(words, context={"folder": folder}).motion()


def refused(folder, file, **words):
    """Return the message on a record."""
    with pytest.raises(RecordError) as caught:
        motion_of(folder, file, **words)
    assert caught.value.problem.file == str(folder / file)
    return caught.value.problem.sentence


@pytest.fixture
def samples():
    """Return accelerations [m/s²] below 10 in size."""
    noise = np.random.default_rng(7).normal(size=500)
    return noise / np.abs(noise).max() * 9.5


def wav(path, rate, values):
    """Write a WAV as scipy does."""
    from scipy.io import wavfile

    wavfile.write(path, rate, values)


def mat(path, variables, **words):
    """Write a MAT as scipy does."""
    from scipy.io import savemat

    savemat(path, variables, **words)


def at2(path, values, dt, header="NPTS= {n}, DT= {dt} SEC", unit="UNITS OF G"):
    """Write an AT2 as the PEER database does."""
    rows = [values[k : k + 5] for k in range(0, len(values), 5)]
    head = f"PEER NGA\nSOMEWHERE, 1940\nACCELERATION TIME SERIES IN {unit}\n"
    body = "".join("".join(f"{v:22.14E}" for v in row) + "\n" for row in rows)
    path.write_text(head + header.format(n=len(values), dt=dt) + "\n" + body)


# one motion through every format


def written_three_ways(folder, values, dt):
    """Return the motions of accelerations [g] through CSV, AT2 and MAT."""
    rows = "".join(f"{k * dt!r},{v!r}\n" for k, v in enumerate(values))
    (folder / "r.csv").write_text("t [s],a [g]\n" + rows)
    at2(folder / "r.at2", values, dt)
    mat(folder / "r.mat", {"t": np.arange(len(values)) * dt, "a": values})
    return (
        motion_of(folder, "r.csv", time="t"),
        motion_of(folder, "r.at2"),
        motion_of(folder, "r.mat", time="t", column="a", unit="g"),
        motion_of(folder, "r.mat", step=dt, column="a", unit="g"),
    )


def same(motions):
    """Make sure that motions are one."""
    first, *others = motions
    for other in others:
        assert other.dt == first.dt
        np.testing.assert_allclose(other.u_dd, first.u_dd, rtol=1e-13, atol=1e-16)


def test_csv_at2_mat_and_wav_give_one_motion(tmp_path, samples):
    values = samples / 9.80665
    motions = written_three_ways(tmp_path, values.tolist(), 0.005)
    same(motions)
    wav(tmp_path / "r.wav", 200, np.round(values * 2**15).astype(np.int16))
    sound = motion_of(tmp_path, "r.wav", full_scale="1 g")
    assert sound.dt == 0.005
    assert np.abs(sound.u_dd - motions[0].u_dd).max() <= 9.80665 * 2**-16 * (1 + 1e-9)


# WAV


@pytest.mark.parametrize("bits", [8, 16, 24, 32])
def test_wav_of_whole_numbers_is_true_to_its_quantisation(tmp_path, samples, bits):
    levels = 2 ** (bits - 1)
    whole = np.round(samples / 10 * levels).astype(np.int64)
    raw = (whole + 128 * (bits == 8)).astype("<i8").view(np.uint8).reshape(-1, 8)
    with wave.open(str(tmp_path / "r.wav"), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(bits // 8)
        file.setframerate(RATE)
        file.writeframes(raw[:, : bits // 8].tobytes())
    motion = motion_of(tmp_path, "r.wav", full_scale="10 m/s2")
    assert motion.dt == 1 / RATE
    assert np.abs(motion.u_dd - samples).max() <= 10 / levels / 2 * (1 + 1e-9)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_wav_of_floating_point_takes_a_unit(tmp_path, samples, kind):
    wav(tmp_path / "r.wav", RATE, samples.astype(kind))
    motion = motion_of(tmp_path, "r.wav", unit="g", scale=2)
    expected = samples.astype(kind).astype(float) * (9.80665 * 2)
    np.testing.assert_array_equal(motion.u_dd, expected)


def test_wav_of_two_channels_asks_for_one(tmp_path, samples):
    both = np.stack([samples, -samples], axis=1).astype(np.float32)
    wav(tmp_path / "r.wav", RATE, both)
    assert refused(tmp_path, "r.wav", unit="g") == (
        "set `channel`, its number; there are: 2, without names"
    )
    second = motion_of(tmp_path, "r.wav", unit="m/s2", channel=2)
    np.testing.assert_array_equal(second.u_dd, both[:, 1])
    assert "there is no channel 3" in refused(tmp_path, "r.wav", unit="g", channel=3)
    assert "no channel `left`" in refused(tmp_path, "r.wav", unit="g", channel="left")


def test_wav_with_an_extensible_form_and_other_chunks_is_read(tmp_path):
    form = b"\xfe\xff\1\0\x90\1\0\0\x20\3\0\0\2\0\x10\0\x16\0\x10\0\0\0\0\0\1\0" + bytes(14)
    chunks = b"fmt " + len(form).to_bytes(4, "little") + form
    chunks += b"LIST\3\0\0\0abc\0data\4\0\0\0\0\x40\0\xc0"
    head = b"RIFF" + (len(chunks) + 4).to_bytes(4, "little") + b"WAVE"
    (tmp_path / "r.wav").write_bytes(head + chunks)
    assert motion_of(tmp_path, "r.wav", full_scale="2 m/s²").u_dd.tolist() == [1, -1]


def test_full_scale_and_unit_go_with_their_kinds_of_samples(tmp_path, samples):
    wav(tmp_path / "whole.wav", RATE, (samples * 1000).astype(np.int16))
    wav(tmp_path / "float.wav", RATE, samples)
    assert refused(tmp_path, "whole.wav") == (
        "the samples are integers, fractions of a full scale without a unit; "
        "set `full_scale`, e.g. `full_scale: 50 m/s²`, in the scenario's `excitation` block"
    )
    assert "instead of `unit`" in refused(tmp_path, "whole.wav", unit="g")
    assert refused(tmp_path, "float.wav") == (
        "channel 1 has no unit; write `unit: m/s²` in the scenario's `excitation` block"
    )
    assert "set `unit` instead of `full_scale`" in refused(
        tmp_path, "float.wav", full_scale="2 g"
    )


def test_clipped_samples_are_said(tmp_path, samples):
    clipped = np.clip(np.repeat(samples, 6), -5, 5)
    wav(tmp_path / "r.wav", RATE, clipped)
    found = motion_of(tmp_path, "r.wav", unit="m/s2").warnings
    assert [c.slug for c in found if c.slug == "record-clipped"] == ["record-clipped"] * 2
    expected = {"limit": -5, "sample": np.argmin(clipped) + 1, "samples": (clipped == -5).sum()}
    assert found[0].numbers == expected
    wav(tmp_path / "r.wav", RATE, np.maximum(samples, 0))
    found = motion_of(tmp_path, "r.wav", unit="m/s2", remove="mean").warnings
    assert [c.slug for c in found] == ["record-interpolated"]  # white noise


def test_scenario_with_a_wav_runs_again_as_it_was_resolved(tmp_path, samples):
    wav(tmp_path / "r.wav", RATE, (samples * 1000).astype(np.int16))
    (tmp_path / "seat.yaml").write_text(
        "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
        "excitation: {kind: record, file: r.wav, channel: 1, full_scale: 50 m/s2}\n"
    )
    words = load(tmp_path / "seat.yaml").resolved()["excitation"]
    assert (words["channel"], words["full_scale"]) == (1, "50 m/s2")
    again = motion_of(tmp_path, **{key: words[key] for key in words if key != "kind"})
    assert again.u_dd[0] == (samples[0] * 1000).astype(np.int16) / 2**15 * 50


WAVS = {
    "other": (lambda raw: b"RIFX" + raw[4:], "the WAV is RIFX; only RIFF is supported"),
    "none": (lambda raw: b"ID3 " + raw[4:], "the record is not a WAV file"),
    "cut": (lambda raw: raw[:-7], "truncated or damaged: 7 bytes are missing at its end"),
    "head": (lambda raw: raw[:20], "truncated or damaged: 16 bytes are missing at its end"),
    "stub": (lambda raw: raw[:12], "truncated or damaged: it has no samples"),
    "code": (lambda raw: raw[:20] + b"\x55" + raw[21:], "samples of 16 bits in format 85"),
    "rate": (lambda raw: raw[:24] + bytes(4) + raw[28:], "it has 1 channels at 0 Hz"),
    "sizes": (lambda raw: raw[:32] + b"\3" + raw[33:], "its sample sizes are inconsistent"),
    "silent": (lambda raw: raw[:40] + bytes(4), "the WAV contains no samples"),
    "odd": (lambda raw: raw[:40] + b"\5\0\0\0" + raw[44:], "its last sample is incomplete"),
}


@pytest.mark.parametrize("name", WAVS)
def test_fault_of_a_wav_earns_its_sentence(tmp_path, samples, name):
    wav(tmp_path / "r.wav", RATE, (samples * 1000).astype(np.int16))
    change, sentence = WAVS[name]
    (tmp_path / "r.wav").write_bytes(change((tmp_path / "r.wav").read_bytes()))
    assert sentence in refused(tmp_path, "r.wav", full_scale="1 g")


@pytest.mark.parametrize("sample", [np.inf, -np.inf])
@pytest.mark.parametrize("gaps", [None, {"fill": "line", "at_most": 1}])
def test_infinite_sample_of_a_wav_is_called_so_and_not_a_gap(tmp_path, samples, sample, gaps):
    samples[6] = sample
    wav(tmp_path / "r.wav", RATE, samples)
    words = {"gaps": gaps} if gaps else {}
    assert refused(tmp_path, "r.wav", unit="m/s2", **words) == (
        "sample 7, channel 1: an infinite sample cannot be interpolated; "
        "export the record again"
    )


# MAT


@pytest.mark.parametrize("version", ["4", "5"])
@pytest.mark.parametrize("across", [True, False])
def test_mat_of_rows_and_columns_in_any_version_is_read(tmp_path, samples, version, across):
    values = samples[None, :] if across else samples[:, None]
    mat(tmp_path / "r.mat", {"acc": values, "fs": 400.0}, format=version)
    motion = motion_of(tmp_path, "r.mat", rate=400, unit="m/s2")
    np.testing.assert_array_equal(motion.u_dd, samples)
    assert motion.dt == 1 / 400


def test_compressed_mat_of_whole_numbers_is_read(tmp_path):
    mat(tmp_path / "r.mat", {"acc": np.array([1, 2, 4], np.int16)}, do_compression=True)
    assert motion_of(tmp_path, "r.mat", step=1, unit="g", scale=1 / 9.80665).u_dd[2] == 4


MATS = {
    "which": ({}, "set `column`, its name or number; there are: `t`, `acc`, `late`"),
    "near": ({"column": "ac"}, "there is no variable `ac`; did you mean `acc`?"),
    "unit": ({"column": "acc"}, "variable 2 (`acc`) has no unit; write `unit: m/s²` in"),
    "lengths": ({"column": "late", "time": "t", "unit": "g"}, "(`late`) has 3 samples, variab"),
    "spacing": ({"column": "acc", "unit": "g"}, "`time: t` fits, as the file"),
    "gap": (
        {"column": "late", "unit": "g", "step": 1},
        "sample 2, variable 3 (`late`): not a number: the",
    ),
    "uneven": ({"column": "acc", "unit": "g", "time": "acc"}, "time decreases"),
}


@pytest.mark.parametrize("name", MATS)
def test_fault_of_a_mat_earns_its_sentence(tmp_path, name):
    words, sentence = MATS[name]
    vectors = {"t": np.arange(4.0), "acc": [1.0, 2, 4, 3], "late": [1, np.nan, 2]}
    others = {"fs": 1.0, "note": "seat", "both": np.eye(3), "cell": {"a": np.arange(3.0)}}
    mat(tmp_path / "r.mat", vectors | others)
    if "spacing" not in name:
        words = {"step": 1} | words if "time" not in words else words
    assert sentence in refused(tmp_path, "r.mat", **words)


def test_mat_that_is_none_or_too_new_is_refused(tmp_path):
    (tmp_path / "r.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n")
    assert "is of version 7.3, which is not supported; save it with `save -v7`" in refused(
        tmp_path, "r.mat", step=1
    )
    (tmp_path / "r.mat").write_bytes(b"1,2,3\n" * 200)
    assert "the record is not a MAT file, or it is damaged" in refused(
        tmp_path, "r.mat", step=1
    )
    mat(tmp_path / "r.mat", {"fs": 1.0})
    said = refused(tmp_path, "r.mat", step=1)
    assert said.startswith("the MAT file contains no vector of real numbers")


@pytest.mark.parametrize(
    ("content", "remedy"),
    [
        ({"data": np.eye(3)}, "`data` is a matrix, 3x3; save its columns one by one"),
        ({"s": {"a": np.arange(3.0)}}, "save the fields of a structure or table one by one"),
        ({"a\n" * 15: np.eye(3)}, "`" + "a?" * 15 + "` is a matrix, 3x3"),
    ],
)
def test_mat_without_a_vector_says_how_to_save_one(tmp_path, content, remedy):
    mat(tmp_path / "r.mat", content)
    assert remedy in refused(tmp_path, "r.mat", step=1)


def test_mat_that_is_damaged_is_refused_and_never_read_beyond_its_end(tmp_path):
    for packed in (False, True):
        mat(tmp_path / "r.mat", {"acc": np.arange(500.0)}, do_compression=packed)
        whole = (tmp_path / "r.mat").read_bytes()
        for change in (whole[:-9], whole[:140], whole[:126] + b"??" + whole[128:]):
            (tmp_path / "r.mat").write_bytes(change)
            said = refused(tmp_path, "r.mat", step=1, unit="g")
            assert said.startswith("the record is not a MAT file, or it is damaged: ")
    (tmp_path / "r.mat").write_bytes(whole[:200] + b"\0\0\0\0" + whole[204:])
    assert "cannot be decompressed" in refused(tmp_path, "r.mat", step=1, unit="g")
    mat(tmp_path / "r.mat", {"acc": np.arange(500.0), "more": np.arange(500.0)})
    whole = bytearray((tmp_path / "r.mat").read_bytes())
    whole[132:136] = (4000).to_bytes(4, "little")  # into the next variable
    (tmp_path / "r.mat").write_bytes(whole)
    said = refused(tmp_path, "r.mat", step=1, unit="g", column="acc")
    assert said.startswith("the record is not a MAT file, or it is damaged: ")


def test_packed_mat_takes_the_memory_of_its_numbers_once(tmp_path):
    # 400 MB of them, packed to little, had taken 813 MB.
    values = np.zeros(2_000_000)
    values[::1000] = 1.0
    mat(tmp_path / "r.mat", {"acc": values}, do_compression=True)
    tracemalloc.start()
    motion = motion_of(tmp_path, "r.mat", step=1, unit="m/s2")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    np.testing.assert_array_equal(motion.u_dd[:], values)
    assert most < 1.5 * values.nbytes


@pytest.mark.parametrize("kind", ["f8", "f4", "i2", "u1"])
@pytest.mark.parametrize("packed", [False, True])
def test_mat_that_is_longer_than_what_is_read_at_a_time_holds_every_number(
    tmp_path, packed, kind
):
    # 1,500,000 numbers of one byte, too: they need not end where a part of the bytes does.
    values = (np.arange(1_500_000) % 251).astype(kind)
    mat(tmp_path / "r.mat", {"odd": 1.0, "acc": values}, do_compression=packed)
    motion = motion_of(tmp_path, "r.mat", step=1, unit="m/s2")
    np.testing.assert_array_equal(motion.u_dd[:], values)


def test_mat_of_a_thousand_times_its_size_is_refused_before_it_is_unpacked(tmp_path):
    mat(tmp_path / "r.mat", {"acc": np.zeros(12_000_000)}, do_compression=True)
    tracemalloc.start()
    said = refused(tmp_path, "r.mat", step=1, unit="m/s2")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert said.startswith("it states 96 MB of samples in ")
    assert most < 20e6


def test_mat_that_unpacks_beyond_the_memory_is_refused(tmp_path, monkeypatch):
    mat(tmp_path / "r.mat", {"acc": np.zeros(10_000)}, do_compression=True)
    monkeypatch.setattr(system, "total_memory", lambda: 20_000.0)
    sentence = "the record needs 0.00024 GB of memory, this machine has 2e-05 GB"
    assert refused(tmp_path, "r.mat", step=1, unit="g") == sentence


def test_big_endian_mat_of_version_4_is_read(tmp_path):
    head = np.array([1000, 3, 1, 0, 4], ">i4").tobytes()
    content = head + b"acc\0" + np.array([1.0, 2, 4], ">f8").tobytes()
    (tmp_path / "r.mat").write_bytes(content)
    assert motion_of(tmp_path, "r.mat", step=1, unit="m/s2").u_dd.tolist() == [1, 2, 4]


# AT2


HEADERS = ("NPTS=  {n}, DT=   {dt} SEC,", "NPTS={n},DT={dt}", "  {n}  {dt}   NPTS, DT")


@pytest.mark.parametrize("header", HEADERS)
def test_at2_tells_number_step_and_unit_in_its_header(tmp_path, samples, header):
    at2(tmp_path / "r.at2", samples, ".0050", header)
    motion = motion_of(tmp_path, "r.at2")
    np.testing.assert_allclose(motion.u_dd, samples * 9.80665, rtol=1e-13)
    assert motion.dt == 0.005


def test_unit_of_an_at2_may_come_from_the_scenario(tmp_path, samples):
    at2(tmp_path / "r.at2", samples, ".01", unit="CAPITALS")
    assert "series 1 has no unit" in refused(tmp_path, "r.at2")
    np.testing.assert_allclose(motion_of(tmp_path, "r.at2", unit="m/s2").u_dd, samples)
    at2(tmp_path / "r.at2", samples, ".01", unit="UNITS OF CM/S/S")
    np.testing.assert_allclose(motion_of(tmp_path, "r.at2").u_dd, samples / 100)
    assert "the file says `cm/s/s`" in refused(tmp_path, "r.at2", unit="g")


def test_header_of_an_at2_may_be_in_any_encoding(tmp_path, samples):
    at2(tmp_path / "r.at2", samples, ".0050", "NPTS= {n}, DT= {dt} SEC, ÉTÉ")
    text = (tmp_path / "r.at2").read_text()
    (tmp_path / "r.at2").write_bytes(text.replace("SOME", "SÃO").encode("latin-1"))
    assert len(motion_of(tmp_path, "r.at2").u_dd) == len(samples)


AT2S = {
    "cut": (lambda text: text[:-30], "the header says NPTS= 500, but there are 499 sa"),
    "head only": (lambda text: "\n".join(text.splitlines()[:4]) + "\n \n",
        "the header says NPTS= 500, but there are 0 samples, fewer: the file is truncated"),
    "long": (lambda text: text + "1 2\n", "there are 502 samples, more"),
    "word": (lambda text: text + "oops 1\n", "row 105: `oops` is not a number"),
    "nan": (lambda text: text[:-45] + " nan 1\n",
        "sample 499, series 1: not a number: the record has a gap"),
    "header": (lambda text: text[:70],
        "the record is not an AT2 file: none of its first 10 lines"),
    "step": (lambda text: text.replace(".0050", "-1e-"),
        "DT must be a number above 0, not `NPTS= 500, DT"),
    "binary": (lambda text: text + "\0", "the record is binary"),
    "claim": (lambda text: text.replace("500", "1" + 18 * "0", 1),
        "the header says NPTS= 1000000000000000000, but there are 500 samples, fewer"),
    "power": (lambda text: text.replace("500", "1e18", 1),
        "NPTS must be a whole number above 0"),
    "half": (lambda text: text.replace("500", "500.5", 1),
        "above 0, not `NPTS= 500.5, DT= .0050`"),
    "none": (lambda text: text.replace("500", "-500", 1),
        "above 0, not `NPTS= -500, DT= .0050`"),
}  # fmt: skip


@pytest.mark.parametrize("name", AT2S)
def test_fault_of_an_at2_earns_its_sentence(tmp_path, samples, name):
    at2(tmp_path / "r.at2", samples, ".0050")
    change, sentence = AT2S[name]
    (tmp_path / "r.at2").write_text(change((tmp_path / "r.at2").read_text()))
    assert sentence in refused(tmp_path, "r.at2")


# keys that a format does not use


IDLE = {
    "r.wav": {"column": 1, "time": "t", "rate": 5, "step": 1},
    "r.mat": {"channel": 1, "full_scale": "1 g"},
    "r.AT2": {"column": 1, "channel": 1, "time": 1, "rate": 1, "step": 1, "full_scale": "1 g"},
    "r.csv": {"channel": 1, "full_scale": "1 g"},
    "r.rpc": {"column": 1, "time": "t", "rate": 5, "step": 1, "full_scale": "1 g"},
}


@pytest.mark.parametrize(("file", "words"), IDLE.items())
def test_key_that_a_format_does_not_use_is_refused_at_its_place(tmp_path, file, words):
    for key, value in words.items():
        scene = tmp_path / "seat.yaml"
        scene.write_text(
            "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
            f"excitation:\n  kind: record\n  file: {file}\n  {key}: {value}\n"
        )
        with pytest.raises(ScenarioError) as caught:
            load(scene)
        (problem,) = caught.value.problems
        assert (problem.line, problem.column) == (5, 5 + len(key))
        assert problem.sentence.startswith(f"excitation.{key}: a")
        assert re.search("remove|instead of", problem.sentence)


@pytest.mark.parametrize("given", [50, "50", "-5 g", "5 kg", "g", "0 m/s2", True])
def test_full_scale_is_a_quantity_above_zero_with_its_unit(tmp_path, given):
    with pytest.raises(ValidationError):
        motion_of(tmp_path, "r.wav", full_scale=given)


# Records from loggers, each file written by the package that drysim reads it with.


DT = 0.005
UNITS = {"acc": "m/s^2", "other": "g"}


def series():
    """Return two series by name."""
    noise = np.random.default_rng(11).normal(size=(2, 300))
    return {"acc": noise[0], "other": noise[1]}


def uff(path, given=None, binary=1, t=None, units=UNITS, **words):
    """Write a UFF58 by pyuff."""
    pyuff = pytest.importorskip("pyuff", reason="pyuff is not installed")
    path.unlink(missing_ok=True)
    for node, (name, values) in enumerate((given or series()).items()):
        head = {
            "binary": binary,
            "func_type": 1,
            "id1": name,
            "rsp_node": node,
            "rsp_dir": -3,
            "ord_data_type": 4,
            "num_pts": len(values),
            "abscissa_spacing": int(t is None),
            "abscissa_min": 1.0,
            "abscissa_inc": DT,
            "abscissa_spec_data_type": 17,
            "abscissa_axis_units_lab": "s",
            "ordinate_spec_data_type": 12,
            "ordinate_axis_units_lab": units.get(name, "NONE"),
        }
        x = 1 + DT * np.arange(len(values)) if t is None else t
        whole = pyuff.prepare_58(**head | words, data=values, x=x, return_full_dict=True)
        for key in [key for key, value in whole.items() if value is None]:
            whole[key] = "" if re.search(r"lab$|^id\d|ent_name", key) else 0
        with warnings.catch_warnings():  # pyuff leaves the file open that it has written
            warnings.simplefilter("ignore", ResourceWarning)
            pyuff.UFF(str(path)).write_sets(whole, "add")


def mdf(path, given=None, t=None, samples=None, times=None, version="4.10", **words):
    """Write an MDF by asammdf, every channel in a group of its own, with conversions if any.

    `words` are `units`, and those of `MDF.save`.
    """
    units = words.pop("units", UNITS)
    asammdf = pytest.importorskip("asammdf", reason="asammdf is not installed")
    with asammdf.MDF(version=version) as whole:
        for name, values in (given or series()).items():
            clock = 1 + DT * np.arange(len(values)) if t is None else t
            unit = units.get(name, "")
            whole.append([asammdf.Signal(values, clock, name=name, unit=unit)])
            master, channel = whole.groups[-1].channels
            master.conversion, channel.conversion = times, samples
        whole.save(path, overwrite=True, **words)


def conversion(kind, **words):
    """Return a conversion of an MDF by its type."""
    blocks = pytest.importorskip("asammdf.blocks.v4_blocks", reason="asammdf is not installed")
    return blocks.ChannelConversion(conversion_type=kind, **words)


def conversions():
    """Return conversions of an MDF by name, and what they make of x."""
    pairs = {"raw_0": -1.0, "raw_1": 0.5, "raw_2": 4.0}
    pairs |= {"phys_0": 2.0, "phys_1": -3.0, "phys_2": 7.0}
    ranges = {"lower_0": -9.0, "upper_0": 0.0, "lower_1": 0.1, "upper_1": 9.0}
    linear = conversion(1, a=2.0, b=-1.0)
    text = {"text_0": b"none", "text_1": linear, "default_addr": conversion(1, a=4.0, b=0.0)}
    rational = {f"P{k}": float(k) for k in range(1, 7)}
    keys, values = np.array([-1.0, 0.5, 4.0]), np.array([2.0, -3.0, 7.0])

    def nearest(x):
        return values[np.abs(x[:, None] - keys).argmin(axis=1)]

    def ranged(x):
        return np.where(x <= 0, 5.0, np.where(x >= 0.1, 6.0, -8.0))

    return {
        "linear": (linear, lambda x: 2 * x - 1),
        "rational": (
            conversion(2, **rational),
            lambda x: (x**2 + 2 * x + 3) / (4 * x**2 + 5 * x + 6),
        ),
        "interpolated": (
            conversion(4, val_param_nr=6, **pairs), lambda x: np.interp(x, keys, values),
        ),
        "table": (conversion(5, val_param_nr=6, **pairs), nearest),
        "ranges": (
            conversion(6, val_param_nr=7, default=-8.0, phys_0=5.0, phys_1=6.0, **ranges),
            ranged,
        ),
        "values or text": (
            conversion(7, ref_param_nr=3, val_0=1e6, val_1=1e7, **text), lambda x: 4 * x,
        ),
        "ranges or text": (
            conversion(8, ref_param_nr=3, **(ranges | {"lower_0": 1e6, "upper_0": 1e7} | text)),
            lambda x: np.where(x >= 0.1, 2 * x - 1, 4 * x),
        ),
    }  # fmt: skip


def tdms(path, given=None, units=UNITS, waveform=True):
    """Write a TDMS by npTDMS."""
    nptdms = pytest.importorskip("nptdms", reason="npTDMS is not installed")
    told = {"wf_increment": DT, "wf_start_offset": 1.0} if waveform else {}
    with nptdms.TdmsWriter(str(path)) as whole:
        for name, values in (given or series()).items():
            unit = {"unit_string": units[name]} if name in units else {}
            whole.write_segment([nptdms.ChannelObject("log", name, values, told | unit)])


def rpc(path, given=None, units=("m/s^2", "g"), kind=float, samples=True):
    """Write an RPC III by rpc3-file."""
    rpc3 = pytest.importorskip("rpc3.rpc3", reason="rpc3-file is not installed")
    rpc3.progressbar = False
    found = [
        rpc3.Channel(name, unit, DT, values)
        for (name, values), unit in zip((given or series()).items(), units, strict=True)
    ]
    rpc3.write(str(path), found, datatype=kind, overwrite=True, omit_samples_param=not samples)


WRITERS = {"r.uff": uff, "r.mf4": mdf, "r.tdms": tdms}


@pytest.mark.parametrize(("file", "write"), [*WRITERS.items(), ("r.rpc", rpc)])
def test_channel_is_found_by_name_and_number_with_its_unit_and_step(tmp_path, file, write):
    write(tmp_path / file)
    rounding = 1e-7 if write is rpc else 1e-14  # numbers of 4 bytes
    for channel in ("other", 2):
        motion = motion_of(tmp_path, file, channel=channel)
        np.testing.assert_allclose(motion.u_dd, series()["other"] * 9.80665, rtol=rounding)
        assert motion.dt == DT
    first = motion_of(tmp_path, file, channel=1).u_dd
    np.testing.assert_allclose(first, series()["acc"], rtol=rounding)
    assert motion.inputs[0].size == (tmp_path / file).stat().st_size


def test_draft_counts_in_the_unit_of_the_times_of_a_universal_file(tmp_path):
    t = 1e3 * DT * np.arange(300.0)
    uff(tmp_path / "r.uff", t=t, abscissa_axis_units_lab="ms")
    layout = inspect_record(tmp_path / "r.uff").layout
    assert f"300 samples at {1 / DT:g} Hz, {300 * DT:.4g} s" in layout


@pytest.mark.parametrize("write", [uff, mdf])
def test_draft_resamples_uneven_times_of_a_file(tmp_path, write):
    file = "r.uff" if write is uff else "r.mf4"
    t = DT * (np.arange(300) + 0.2 * np.random.default_rng(3).uniform(-1, 1, 300))
    write(tmp_path / file, {"acc": series()["acc"]}, t=t)
    words = {one.key: one.value for one in inspect_record(tmp_path / file).proposals}
    assert words["resample"] == {"rate": "200 Hz", "by": "spline"}
    assert motion_of(tmp_path, file, unit="m/s2", resample=words["resample"]).dt == DT


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_window_counts_on_the_times_of_the_file(tmp_path, file, write):
    write(tmp_path / file)
    part = motion_of(tmp_path, file, channel=1, window={"from": 1.5, "to": 2})
    assert np.array_equal(part.u_dd, series()["acc"][100:201])


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_what_is_missing_or_wrong_is_said(tmp_path, file, write):
    write(tmp_path / file, series() | {"mute": np.ones(3), "gap": np.array([1.0, np.nan, 2])})
    for words, sentence in (
        ({}, "set `channel`, its name or number; there are: "),
        ({"channel": "othr"}, "there is no channel `othr`; did you mean `other`? there are: "),
        ({"channel": 99}, "there is no channel 99"),
        ({"channel": "mute"}, "`) has no unit; write `unit: m/s²` in the scenario"),
        (
            {"channel": 2, "unit": "m/s2"},
            "`): the file says `g`, the scenario says `unit: m/s2`",
        ),
    ):
        assert sentence in refused(tmp_path, file, **words)
    if file != "r.uff":  # pyuff writes numbers in their place
        assert "sample 2, channel 4" in refused(tmp_path, file, channel="gap", unit="g")
        write(tmp_path / file, {"one": np.ones(1)})
        assert "the record has one sample only" in refused(tmp_path, file, unit="g")


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_unit_that_is_none_may_be_put_right(tmp_path, file, write):
    write(tmp_path / file, units={"acc": "gee"})
    assert "unknown unit `gee`" in refused(tmp_path, file, channel="acc")
    right = motion_of(tmp_path, file, channel="acc", unit="g").u_dd
    np.testing.assert_allclose(right, series()["acc"] * 9.80665, rtol=1e-14)


@pytest.mark.parametrize("unit", ["Pa", "V", "Volts", "°C", "degC", "N", "mm", "rpm", "kg"])
@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_channel_of_another_quantity_is_no_acceleration_whatever_the_scenario_says(
    tmp_path, file, write, unit
):
    write(tmp_path / file, units={"acc": unit})
    if write is uff:
        unit.encode("ascii", "ignore").decode() == unit or pytest.skip("text of UFF is ASCII")
    said = refused(tmp_path, file, channel="acc", unit="g")
    assert f"`{unit}`" in said


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_damaged_file_is_refused(tmp_path, file, write):
    write(tmp_path / file)
    whole = (tmp_path / file).read_bytes()
    for part in (b"\0" * 300, b"1,2,3\n" * 50, whole[:40], whole[10:]):
        (tmp_path / file).write_bytes(part)
        said = refused(tmp_path, file, channel="acc")
        assert re.match("the record is no|the TDMS file has no", said)
        assert "BytesIO" not in said


def test_universal_file_of_text_is_read_to_its_digits(tmp_path):
    uff(tmp_path / "r.unv", binary=0)
    motion = motion_of(tmp_path, "r.unv", channel="acc")
    np.testing.assert_allclose(motion.u_dd, series()["acc"], rtol=1e-11)
    uff(tmp_path / "r.unv", {"": np.ones(4)}, units={"": "g"})
    motion = motion_of(tmp_path, "r.unv", channel="0-Z", gravity="keep")
    assert motion.u_dd[0] == 9.80665


def test_universal_file_may_have_times_of_its_own(tmp_path):
    t = 2 + DT * np.arange(300)
    uff(tmp_path / "r.uff", t=t)
    assert motion_of(tmp_path, "r.uff", channel="acc").dt == DT
    uff(tmp_path / "r.uff", t=np.where(t > 2.5, t + 1, t))
    assert "200 samples are missing before this row" in refused(
        tmp_path, "r.uff", channel="acc"
    )
    assert motion_of(tmp_path, "r.uff", channel="acc", rate=100).dt == 0.01


def test_universal_file_that_is_cut_short_or_holds_spectra_is_refused(tmp_path):
    uff(tmp_path / "r.uff", {"acc": np.ones(50)}, num_pts=60, binary=0)
    text = (tmp_path / "r.uff").read_text()
    (tmp_path / "r.uff").write_text(text.replace("        50", "        60"))
    said = refused(tmp_path, "r.uff")
    assert said == "data set 1 is truncated or damaged: it has 50 samples, not 60"
    uff(tmp_path / "r.uff", func_type=2)
    sentence = "is not a universal file with a time history in a data set 58"
    assert sentence in refused(tmp_path, "r.uff")


def test_times_that_jitter_are_refused_unless_the_scenario_says_a_rate(tmp_path):
    t = DT * np.arange(300)
    t[100] += DT / 4
    mdf(tmp_path / "r.mf4", t=t)
    said = refused(tmp_path, "r.mf4", channel="acc")
    assert said.startswith("sample 101, channel 3 (`time of acc`): the time steps are uneven")
    remedy = "`resample: {rate: 200 Hz, by: spline}` makes them even"
    assert f"{remedy}; if only the printed times are inaccurate" in said
    assert motion_of(tmp_path, "r.mf4", channel="acc", step=DT).dt == DT


def test_tdms_without_a_waveform_takes_a_time_channel_or_a_rate(tmp_path):
    given = series() | {"t": 1 + DT * np.arange(300)}
    tdms(tmp_path / "r.tdms", given, UNITS | {"t": "s"}, waveform=False)
    assert motion_of(tmp_path, "r.tdms", channel="acc", time="t").dt == DT
    assert motion_of(tmp_path, "r.tdms", channel="log/acc", rate=100).dt == 0.01
    said = refused(tmp_path, "r.tdms", channel="acc")
    assert "`time: t` fits, as the file has `log/t`" in said


def test_step_that_a_file_knows_is_not_said_again(tmp_path):
    tdms(tmp_path / "r.tdms")
    said = refused(tmp_path, "r.tdms", channel=1, rate=5)
    assert said == "channel 1 (`log/acc`) has a time step of its own, 0.005 s; remove `rate`"


@pytest.mark.parametrize(
    ("suffix", "module", "package", "extra"),
    [
        (".uff", "pyuff", "pyuff", "uff"),
        (".mf4", "asammdf", "asammdf", "mdf"),
        (".tdms", "nptdms", "nptdms", "tdms"),
        (".rsp", "rpc3.rpc3", "rpc3-file", "rpc"),
    ],
)
def test_package_that_is_not_installed_is_named_with_the_way_to_install_it(
    tmp_path, monkeypatch, suffix, module, package, extra
):
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / f"r{suffix}").write_bytes(b"something")
    assert refused(tmp_path, f"r{suffix}", channel=1) == (
        f"a `{suffix}` record needs the package {package}; "
        f'install it with: pip install "drysim[{extra}]"'
    )


def test_mdf_whose_sizes_no_machine_holds_is_refused_at_once(tmp_path):
    mdf(tmp_path / "r.mf4", {"acc": np.ones(300)})
    whole = (tmp_path / "r.mf4").read_bytes()
    sizes = (300).to_bytes(8, "little"), (16).to_bytes(4, "little") + bytes(4)
    at = whole.index(b"##CG")
    cycles = whole.index(sizes[0], at)
    row = whole.index(sizes[1], cycles + 8)
    for place, sentence in ((cycles + 5, "GB of memory"), (row + 3, "one row of ")):
        (tmp_path / "r.mf4").write_bytes(whole[:place] + b"\x7f" + whole[place + 1 :])
        assert sentence in refused(tmp_path, "r.mf4")


KINDS = "linear", "rational", "interpolated", "table", "ranges"


@pytest.mark.parametrize("name", [*KINDS, "values or text", "ranges or text"])
def test_conversion_of_an_mdf_gives_the_values_of_its_definition(tmp_path, name):
    given, expected = conversions()[name]
    x = np.random.default_rng(len(name)).normal(size=300)
    mdf(tmp_path / "r.mf4", {"acc": x}, samples=given)
    motion = motion_of(tmp_path, "r.mf4", gravity="keep")
    np.testing.assert_allclose(motion.u_dd, expected(x), rtol=1e-14, atol=1e-14)
    counts = np.arange(300) % 13 - 6
    mdf(tmp_path / "r.mf4", {"acc": counts.astype("<i2")}, samples=given)
    motion = motion_of(tmp_path, "r.mf4", gravity="keep")
    np.testing.assert_allclose(motion.u_dd, expected(counts * 1.0), rtol=1e-14, atol=1e-14)


def test_times_of_an_mdf_are_converted_as_its_samples_are(tmp_path):
    counts = np.arange(300.0)
    mdf(tmp_path / "r.mf4", t=counts, times=conversion(1, a=DT, b=7.0))
    motion = motion_of(tmp_path, "r.mf4", channel="acc", window={"from": 7.5, "to": 8})
    assert motion.dt == DT
    assert np.array_equal(motion.u_dd, series()["acc"][100:201])


def test_sample_of_an_mdf_that_stands_for_text_is_missing(tmp_path):
    x = np.arange(300.0)
    same = conversion(1, a=1.0, b=0.0)
    given = conversion(7, ref_param_nr=2, val_0=7.0, text_0=b"no signal", default_addr=same)
    mdf(tmp_path / "r.mf4", {"acc": x}, samples=given)
    assert "sample 8, channel 1 (`acc`): not a number" in refused(tmp_path, "r.mf4")
    given = conversion(7, ref_param_nr=2, val_0=7.0, text_0=b"on", default_addr=b"off")
    mdf(tmp_path / "r.mf4", {"acc": x}, samples=given)
    assert "`acc` is converted to text" in refused(tmp_path, "r.mf4")


def nested(inner):
    """Return conversions that contain another one."""
    text = {"text_0": b"none", "text_1": b"some"}
    twice = conversion(7, ref_param_nr=3, val_0=1e6, val_1=1e7, default_addr=inner, **text)
    return {
        "plain": inner,
        "default": twice,
        "default of a default": conversion(
            8, ref_param_nr=2, lower_0=1e6, upper_0=1e7, text_0=b"none", default_addr=twice
        ),
        "entry": conversion(
            7, ref_param_nr=3, val_0=1e6, val_1=1e7, text_0=inner, text_1=b"",
            default_addr=conversion(1, a=1.0, b=0.0),
        ),
    }  # fmt: skip


SEAT_ON_AN_MDF = """\
oscillator: {mass: 75 kg, stiffness: 3 kN/m, damping: 100 N*s/m}
friction: {kinetic: 20 N}
excitation: {kind: record, file: r.mf4}
"""


@pytest.mark.parametrize("where", ["samples", "times"])
@pytest.mark.parametrize("name", ["plain", "default", "default of a default", "entry"])
def test_formula_of_an_mdf_runs_in_no_command(tmp_path, monkeypatch, capsys, name, where):
    blocks = pytest.importorskip("asammdf.blocks.v4_blocks", reason="asammdf is not installed")
    run_by = tmp_path / "run"
    file = f"__import__('pathlib').Path('{run_by}')"
    formula = f"[X for file in [{file}] if file.write_text('1')][0]"
    # The most that numexpr and sympy could do for it; here they do it without any obstacle.
    for evaluates in ("evaluate", "lambdify"):
        monkeypatch.setattr(
            blocks, evaluates, lambda *words, **_: eval(formula, {"X": 1.0}), raising=False
        )
    given = nested(conversion(3, formula=formula))[name]
    mdf(tmp_path / "r.mf4", {"acc": series()["acc"]}, **{where: given})
    (tmp_path / "s.yaml").write_text(SEAT_ON_AN_MDF)
    monkeypatch.chdir(tmp_path)
    for words in (
        ["validate", "s.yaml"],
        ["run", "s.yaml"],
        ["run", "s.yaml", "--dry-run"],
        ["run", "s.yaml", "--set", "sweep.friction.kinetic=[10, 20]", "--workers", "2"],
        ["init", "--from", "r.mf4"],
    ):
        assert main(words) == 2
        said = "".join(capsys.readouterr())
        assert "is not evaluated: a file could run a program with it" in said
    assert not run_by.exists()
    # Broken on purpose: by asammdf itself the formula runs.
    asammdf = pytest.importorskip("asammdf")
    if name in ("plain", "default"):
        with asammdf.MDF(tmp_path / "r.mf4") as whole, suppress(AttributeError):
            whole.get("acc")
        assert run_by.exists()


def test_attachments_and_bus_messages_of_an_mdf_are_not_decoded(tmp_path, monkeypatch):
    mdf_v4 = pytest.importorskip("asammdf.blocks.mdf_v4", reason="asammdf is not installed")
    mdf(tmp_path / "r.mf4")
    calls = []
    monkeypatch.setattr(mdf_v4.MDF4, "_process_bus_logging", lambda self: calls.append(self))
    motion_of(tmp_path, "r.mf4", channel="acc")
    assert not calls


def test_mdf_of_another_version_or_without_samples_is_refused_with_a_sentence(tmp_path):
    mdf(tmp_path / "r.mdf", version="3.30")
    said = refused(tmp_path, "r.mdf", channel="acc")
    assert said.startswith("the MDF file is of version 3.30; only version 4 is supported")
    mdf(tmp_path / "r.mf4", {"none": np.array([]), "acc": series()["acc"]})
    assert "(`time of none`) has no samples" in refused(tmp_path, "r.mf4", channel=1, unit="g")
    inspected = inspect_record(tmp_path / "r.mf4")
    assert [one.name for one in inspected.columns] == ["acc"]
    assert "channel 1 (`none`) is left out: has no samples" in inspected.layout


def first_link(whole, kind, start=0):
    """Return the offsets of a block of an MDF, and of its first link."""
    at = whole.index(b"##" + kind, start)
    return at, at + 24


@pytest.mark.parametrize("kind", [b"FH", b"DG", b"CG", b"CN"])
def test_mdf_whose_blocks_form_a_loop_is_refused_at_once(tmp_path, kind):
    mdf(tmp_path / "r.mf4")
    whole = bytearray((tmp_path / "r.mf4").read_bytes())
    at, link = first_link(whole, kind)
    whole[link : link + 8] = at.to_bytes(8, "little")
    (tmp_path / "r.mf4").write_bytes(whole)
    assert "its blocks form a loop" in refused(tmp_path, "r.mf4", channel="acc")
    inside = (at + 8).to_bytes(8, "little")  # the last bytes of a block may lead to the first
    whole[link : link + 8] = inside
    (tmp_path / "r.mf4").write_bytes(whole)
    assert "leads to no block of its type" in refused(tmp_path, "r.mf4", channel="acc")


@pytest.mark.parametrize("count", [1, 2, 90, 5000])
@pytest.mark.parametrize("closed", [True, False])
def test_mdf_of_conversions_nested_without_end_or_too_deeply_is_refused(
    tmp_path, count, closed
):
    mdf(tmp_path / "r.mf4", samples=conversion(1, a=1.0, b=0.0))
    whole = bytearray((tmp_path / "r.mf4").read_bytes())
    while len(whole) % 8:
        whole += b"\0"
    size, start = 24 + 8 * 6 + 24 + 16, len(whole)
    for k in range(count):
        inner = start + size * (k + 1) if k + 1 < count else start if closed else 0
        # A table of values or texts with one entry, and its default, which is the next block.
        whole += struct.pack("<4s4xQQ6Q", b"##CC", size, 6, 0, 0, 0, 0, 0, inner)
        whole += struct.pack("<BBHHH4d", 7, 0, 0, 2, 1, 0.0, 0.0, 1e6, 0.0)
    at = whole.index(b"##CN")
    for _ in range(whole.count(b"##CN")):
        whole[at + 24 + 8 * 4 : at + 24 + 8 * 5] = start.to_bytes(8, "little")
        at = whole.find(b"##CN", at + 4)
    (tmp_path / "r.mf4").write_bytes(whole)
    said = refused(tmp_path, "r.mf4", channel="acc")
    if count > 100:
        assert "its conversions are nested too deeply" in said
    elif closed:
        assert "its conversions refer to one another without end" in said


def test_mdf_whose_times_or_samples_lie_outside_its_rows_is_refused(tmp_path):
    mdf(tmp_path / "r.mf4", {"acc": series()["acc"]})
    whole = (tmp_path / "r.mf4").read_bytes()
    for name in (b"time", b"acc"):
        text = whole.index(name + b"\0", whole.index(b"##TX"))
        link = (text - 24).to_bytes(8, "little")  # a channel begins with links, then its place
        at = whole.index(link, whole.index(b"##CN")) + 8 * 6 + 4
        for place in (10_000, 1 << 31):
            wrong = whole[:at] + place.to_bytes(4, "little") + whole[at + 4 :]
            (tmp_path / "r.mf4").write_bytes(wrong)
            assert "lies outside its rows" in refused(tmp_path, "r.mf4")


def test_mdf_that_unpacks_beyond_what_it_states_is_refused(tmp_path):
    mdf(tmp_path / "r.mf4", {"acc": np.zeros(100_000)}, compression=1)
    assert len(motion_of(tmp_path, "r.mf4", unit="m/s2").u_dd) == 100_000
    whole = bytearray((tmp_path / "r.mf4").read_bytes())
    size = whole.index(b"##DZ") + 32
    for stated, sentence in (
        (1000, "a compressed block is larger than it states"),
        (10**9, "made to exhaust the memory"),
    ):
        whole[size : size + 8] = stated.to_bytes(8, "little")
        (tmp_path / "r.mf4").write_bytes(whole)
        assert sentence in refused(tmp_path, "r.mf4", channel="acc")


# RPC III: files that rpc3-file wrote, and files written here by the published layout.


GROUP = 2048


def laid_out(path, values, scales, frame=256, group=512, kind="<i2", **changed):
    """Write an RPC III by its layout: keys and values of 32 and 96 bytes, then group by group.

    `values` are counts or floats, shape (channels, frames x frame); each group holds some
    frames of one channel after the other.
    """
    count, n = values.shape
    words = {
        "FORMAT": "BINARY_IEEE_LITTLE_END",
        "NUM_HEADER_BLOCKS": 0,
        "NUM_PARAMS": 0,
        "FILE_TYPE": "TIME_HISTORY",
        "TIME_TYPE": "RESPONSE",
        "DATA_TYPE": "SHORT_INTEGER" if kind == "<i2" else "FLOATING_POINT",
        "DELTA_T": "4.882812E-03",
        "CHANNELS": count,
        "PTS_PER_FRAME": frame,
        "PTS_PER_GROUP": group,
        "FRAMES": n // frame,
        "INT_FULL_SCALE": 32752,
    }
    for number, scale in enumerate(scales, 1):
        words |= {
            f"DESC.CHAN_{number}": f'"axle {number}"',
            f"UNITS.CHAN_{number}": "g",
            f"SCALE.CHAN_{number}": repr(scale),
            f"LOWER_LIMIT.CHAN_{number}": "-1.0",
            f"UPPER_LIMIT.CHAN_{number}": "1.0",
        }
    words |= changed
    blocks = -(-len(words) // 4)
    words |= {"NUM_HEADER_BLOCKS": blocks, "NUM_PARAMS": len(words)}
    head = b"".join(
        key.encode().ljust(32, b"\0") + str(value).encode().ljust(96, b"\0")
        for key, value in words.items()
    )
    whole = np.zeros((count, -(-n // group) * group))
    whole[:, :n] = values
    body = whole.reshape(count, -1, group).swapaxes(0, 1).astype(kind).tobytes()
    path.write_bytes(head.ljust(512 * blocks, b"\0") + body)


def test_whole_numbers_are_true_to_their_quantisation(tmp_path):
    rpc(tmp_path / "r.rsp", kind=int)
    level = np.abs(series()["acc"]).max() / 32752
    found = motion_of(tmp_path, "r.rsp", channel="acc").u_dd
    assert np.abs(found - series()["acc"]).max() <= level / 2 * 1.01


@pytest.mark.parametrize("kind", ["<i2", "<f4"])
@pytest.mark.parametrize("suffix", [".rpc", ".rsp", ".tim", ".drv"])
def test_groups_of_several_frames_are_put_together_again(tmp_path, kind, suffix):
    pytest.importorskip("rpc3", reason="rpc3-file is not installed")
    counts = np.random.default_rng(3).integers(-32752, 32752, (3, 5 * 256)).astype(float)
    scales = (1e-3, 2.5e-4, 1.0) if kind == "<i2" else (1.0, 1.0, 1.0)
    laid_out(tmp_path / f"r{suffix}", counts, scales, kind=kind)
    for number, scale in enumerate(scales, 1):
        motion = motion_of(tmp_path, f"r{suffix}", channel=f"axle {number}")
        np.testing.assert_allclose(motion.u_dd, counts[number - 1] * scale * 9.80665, rtol=1e-6)
        assert motion.dt == 4.882812e-3


def test_file_without_a_number_of_samples_ends_with_its_last_frame(tmp_path):
    rpc(tmp_path / "r.rpc", samples=False)
    found = motion_of(tmp_path, "r.rpc", channel="acc").u_dd
    assert len(found) == GROUP
    np.testing.assert_allclose(found[:300], series()["acc"], rtol=1e-6)


BROKEN = {
    "empty": lambda whole: b"",
    "cut in the head": lambda whole: whole[:700],
    "cut in the samples": lambda whole: whole[:-9],
    "another file": lambda whole: b"1,2,3\n" * 500,
    "big end": lambda whole: whole.replace(b"LITTLE", b"BIG\0\0\0"),
    "no step": lambda whole: whole.replace(b"4.882812E-03", b"0.0".ljust(12, b"\0")),
    "huge": lambda whole: whole.replace(
        b"FRAMES".ljust(32, b"\0") + b"4".ljust(16, b"\0"),
        b"FRAMES".ljust(32, b"\0") + b"4" * 12 + bytes(4),
    ),
    "no unit key": lambda whole: whole.replace(b"UNITS.CHAN_1", b"UNIFS.CHAN_1"),
    "spectrum": lambda whole: whole.replace(b"TIME_HISTORY", b"SPECTRAL\0\0\0\0"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_file_earns_a_sentence(tmp_path, capfd, name):
    pytest.importorskip("rpc3", reason="rpc3-file is not installed")
    laid_out(tmp_path / "r.rpc", np.ones((1, 4 * 256)), [0.5])
    assert motion_of(tmp_path, "r.rpc").u_dd[0] == 0.5 * 9.80665
    whole = (tmp_path / "r.rpc").read_bytes()
    changed = BROKEN[name](whole)
    assert changed != whole
    (tmp_path / "r.rpc").write_bytes(changed)
    said = refused(tmp_path, "r.rpc")
    assert said.startswith(("the record is not an RPC III time history", "the record is empty"))
    assert capfd.readouterr() == ("", "")
