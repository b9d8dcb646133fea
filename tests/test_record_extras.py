"""Records from loggers, each file written by the package that drysim reads it with."""

from __future__ import annotations

import re
import sys
import warnings

import numpy as np
import pytest

from drysim.errors import RecordError
from drysim.excitation.recorded import Record

DT = 0.005
UNITS = {"acc": "m/s^2", "other": "g"}


def motion_of(folder, file, **words):
    """Give the motion of a record."""
    words = {"kind": "record", "file": file, **words}
    return Record.model_validate(words, context={"folder": folder}).motion()


def refused(folder, file, **words):
    """Give the sentence that a record earns."""
    with pytest.raises(RecordError) as caught:
        motion_of(folder, file, **words)
    return caught.value.problem.sentence


def series():
    """Give two series by name."""
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


def mdf(path, given=None, t=None, units=UNITS):
    """Write an MDF4 by asammdf, every channel in a group of its own."""
    asammdf = pytest.importorskip("asammdf", reason="asammdf is not installed")
    with asammdf.MDF(version="4.10") as whole:
        for name, values in (given or series()).items():
            times = 1 + DT * np.arange(len(values)) if t is None else t
            unit = units.get(name, "")
            whole.append([asammdf.Signal(values, times, name=name, unit=unit)])
        whole.save(path, overwrite=True)


def tdms(path, given=None, units=UNITS, waveform=True):
    """Write a TDMS by npTDMS."""
    nptdms = pytest.importorskip("nptdms", reason="npTDMS is not installed")
    told = {"wf_increment": DT, "wf_start_offset": 1.0} if waveform else {}
    with nptdms.TdmsWriter(str(path)) as whole:
        for name, values in (given or series()).items():
            unit = {"unit_string": units[name]} if name in units else {}
            whole.write_segment([nptdms.ChannelObject("log", name, values, told | unit)])


WRITERS = {"r.uff": uff, "r.mf4": mdf, "r.tdms": tdms}


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_channel_is_found_by_name_and_number_with_its_unit_and_step(tmp_path, file, write):
    write(tmp_path / file)
    for channel in ("other", 2):
        motion = motion_of(tmp_path, file, channel=channel)
        np.testing.assert_allclose(motion.u_dd, series()["other"] * 9.80665, rtol=1e-14)
        assert motion.dt == DT
    assert np.array_equal(motion_of(tmp_path, file, channel=1).u_dd, series()["acc"])
    assert motion.inputs[0].size == (tmp_path / file).stat().st_size


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_window_counts_on_the_times_of_the_file(tmp_path, file, write):
    write(tmp_path / file)
    part = motion_of(tmp_path, file, channel=1, window={"from": 1.5, "to": 2})
    assert np.array_equal(part.u_dd, series()["acc"][100:201])


@pytest.mark.parametrize(("file", "write"), WRITERS.items())
def test_what_is_missing_or_wrong_is_said(tmp_path, file, write):
    write(tmp_path / file, series() | {"mute": np.ones(3), "gap": np.array([1.0, np.nan, 2])})
    for words, sentence in (
        ({}, "give `channel`, its name or number; there are: "),
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


def test_universal_file_that_is_cut_short_is_refused(tmp_path):
    uff(tmp_path / "r.uff", {"acc": np.ones(50)}, num_pts=60, binary=0)
    text = (tmp_path / "r.uff").read_text()
    (tmp_path / "r.uff").write_text(text.replace("        50", "        60"))
    said = refused(tmp_path, "r.uff")
    assert said == "data set 1 is cut short or damaged: it has 50 samples, not 60"


def test_spectra_in_a_universal_file_are_no_records(tmp_path):
    uff(tmp_path / "r.uff", func_type=2)
    assert "is no universal file with a time history in a data set 58" in refused(
        tmp_path, "r.uff"
    )


def test_times_that_jitter_are_refused_unless_the_scenario_says_a_rate(tmp_path):
    t = DT * np.arange(300)
    t[100] += DT / 4
    mdf(tmp_path / "r.mf4", t=t)
    said = refused(tmp_path, "r.mf4", channel="acc")
    assert said.startswith("sample 101, channel 3 (`time of acc`): the time steps are uneven")
    assert "`resample` puts the record onto an even grid; or give `rate` or `step`" in said
    assert motion_of(tmp_path, "r.mf4", channel="acc", step=DT).dt == DT


def test_tdms_without_a_waveform_takes_a_time_channel_or_a_rate(tmp_path):
    given = series() | {"t": 1 + DT * np.arange(300)}
    tdms(tmp_path / "r.tdms", given, UNITS | {"t": "s"}, waveform=False)
    assert motion_of(tmp_path, "r.tdms", channel="acc", time="t").dt == DT
    assert motion_of(tmp_path, "r.tdms", channel="log/acc", rate=100).dt == 0.01
    said = refused(tmp_path, "r.tdms", channel="acc")
    assert "`time: t` is what is missing, as the file has `log/t`" in said


def test_step_that_a_file_knows_is_not_said_again(tmp_path):
    tdms(tmp_path / "r.tdms")
    said = refused(tmp_path, "r.tdms", channel=1, rate=5)
    assert said == "channel 1 (`log/acc`) knows the step of its samples, 0.005 s; remove `rate`"


MISSING = {"r.uff": ("pyuff", "uff"), "r.mf4": ("asammdf", "mdf"), "r.tdms": ("nptdms", "tdms")}


@pytest.mark.parametrize(("file", "names"), MISSING.items())
def test_package_that_is_not_installed_is_named_with_the_way_to_install_it(
    tmp_path, monkeypatch, file, names
):
    monkeypatch.setitem(sys.modules, names[0], None)
    (tmp_path / file).write_bytes(b"something")
    suffix = file.removeprefix("r")
    assert refused(tmp_path, file, channel=1) == (
        f"a `{suffix}` record needs the package {names[0]}; "
        f'install it by: pip install "drysim[{names[1]}]"'
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
