"""RPC III: files that rpc3-file wrote, and files written here by the published layout."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from drysim.scenario.load import load
from test_record_extras import motion_of, refused, series

DT = 0.005
GROUP = 2048


def rpc(path, given=None, units=("m/s^2", "g"), kind=float, samples=True):
    """Write an RPC III by rpc3-file."""
    rpc3 = pytest.importorskip("rpc3.rpc3", reason="rpc3-file is not installed")
    rpc3.progressbar = False
    found = [
        rpc3.Channel(name, unit, DT, values)
        for (name, values), unit in zip((given or series()).items(), units, strict=True)
    ]
    rpc3.write(str(path), found, datatype=kind, overwrite=True, omit_samples_param=not samples)


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


def test_channel_is_found_by_name_and_number_with_its_unit_and_step(tmp_path):
    rpc(tmp_path / "r.rpc")
    for channel in ("other", 2):
        motion = motion_of(tmp_path, "r.rpc", channel=channel)
        np.testing.assert_allclose(motion.u_dd, series()["other"] * 9.80665, rtol=1e-7)
        assert motion.dt == DT
    assert motion.inputs[0].size == (tmp_path / "r.rpc").stat().st_size


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


def test_what_is_missing_or_wrong_is_said(tmp_path):
    rpc(tmp_path / "r.rpc", units=("m/s^2", ""))
    for words, sentence in (
        ({}, "give `channel`, its name or number; there are: `acc`, `other`"),
        ({"channel": "othr"}, "there is no channel `othr`; did you mean `other`?"),
        ({"channel": 3}, "there is no channel 3"),
        ({"channel": 2}, "(`other`) has no unit; write `unit: m/s²` in the scenario"),
        ({"channel": 1, "unit": "g"}, "the file says `m/s^2`, the scenario says `unit: g`"),
    ):
        assert sentence in refused(tmp_path, "r.rpc", **words)


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
    assert said.startswith(("the record is no RPC III time history", "the record is empty"))
    assert capfd.readouterr() == ("", "")


def test_package_that_is_not_installed_is_named_with_the_way_to_install_it(
    tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "rpc3.rpc3", None)
    (tmp_path / "r.rsp").write_bytes(b"something")
    assert refused(tmp_path, "r.rsp") == (
        'a `.rsp` record needs the package rpc3-file; install it by: pip install "drysim[rpc]"'
    )


def test_keys_that_the_file_answers_itself_are_refused(tmp_path):
    from drysim.errors import ScenarioError

    for key in ("column: 1", "time: t", "rate: 5", "step: 1", "full_scale: 1 g"):
        (tmp_path / "seat.yaml").write_text(
            "oscillator: {mass: 75, stiffness: 7500, damping: 500}\n"
            f"excitation: {{kind: record, file: r.rpc, {key}}}\n"
        )
        with pytest.raises(ScenarioError):
            load(tmp_path / "seat.yaml")
