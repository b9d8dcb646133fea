"""`drysim init --from`: what is found in an unknown record, and the scenario drafted for it."""

from __future__ import annotations

import wave
from pathlib import Path

import numpy as np
import pytest
import yaml

import drysim as package
from drysim.errors import RecordError
from drysim.records.inspection import inspect_record
from drysim.study.preparation import base_motion

RATE, COUNT = 400.0, 16_000
T = np.arange(COUNT) / RATE
FLOOR = 0.5 * np.sin(2 * np.pi * 2.5 * T) + 0.2 * np.cos(2 * np.pi * 1.1 * T)
"""Vertical acceleration of a floor [m/s²], without gravity."""
SIDE = 0.3 * np.sin(2 * np.pi * 1.7 * T)
G = 9.80665


def rows(*columns, delimiter=",", digits=6):
    """Return the rows of a table."""
    lines = (
        delimiter.join(f"{value:.{digits}f}" for value in row)
        for row in zip(*columns, strict=True)
    )
    return "\n".join(lines) + "\n"


def clock(t):
    """Return a time of day, in milliseconds."""
    return f"2026-03-12 23:59:{t:06.3f}" if t < 60 else f"2026-03-13 00:00:{t - 60:06.3f}"


FILES = {
    "blanks.txt": "Logger 7\nchannels: 3\n\n"
    + rows(T, SIDE / G, SIDE / G, FLOOR / G + 1, delimiter=" "),
    "semicolons.csv": "Run 12;;;\nDate;12.3.2026;;\nZeit [s];ax [g];ay [g];az [g]\n"
    + rows(T, SIDE / G, SIDE / G, FLOOR / G + 1, delimiter=";").replace(".", ","),
    "units.csv": "Time;Acc\ns;m/s^2\n" + rows(T, FLOOR + 9.81, delimiter=";"),
    "names.csv": "t,acc floor,acc seat\n" + rows(T, FLOOR + 9.81, SIDE),
    "milliseconds.csv": "ms,az (mg)\n" + rows(T * 1e3, FLOOR / G * 1e3 + 1e3),
    "clock.csv": "Time,Accel,Status\n"
    + "".join(f"{clock(t + 30)},{a + 9.81:.6f},OK\n" for t, a in zip(T, FLOOR, strict=True)),
    "crlf.csv": "\ufefft [s],u_dd [m/s2]\r\n" + rows(T, FLOOR).replace("\n", "\r\n"),
}


def drafted(drysim, name, content):
    """Write a record, draft a scenario for it, and return its keys as they are proposed."""
    Path("draft.yaml").unlink(missing_ok=True)
    with open(name, "w", encoding="utf-8", newline="") as stream:
        stream.write(content)
    answer = drysim("init", "--from", name, "draft")
    assert (answer.code, answer.out) == (0, "draft.yaml\n")
    return {one.key: one for one in inspect_record(Path(name)).proposals}


@pytest.mark.parametrize("name", FILES)
def test_draft_for_a_common_file_reads_its_base_motion(drysim, tmp_path, name):
    drafted(drysim, name, FILES[name])
    answer = drysim("validate", "draft.yaml")
    assert answer.code == 0, answer.out
    motion = base_motion(package.load("draft.yaml"))
    inner = slice(COUNT // 4, 3 * COUNT // 4)  # away from the ends of the high-pass
    assert motion.dt == pytest.approx(1 / RATE, rel=1e-4)
    assert motion.u_dd[inner] == pytest.approx(FLOOR[inner], abs=0.02)


def test_channel_named_floor_is_chosen_before_one_with_gravity(drysim, tmp_path):
    text = "t [s],floor [m/s2],seat z [m/s2]\n" + rows(T, FLOOR, FLOOR + 9.81)
    assert drafted(drysim, "both.csv", text)["column"].value == "floor"


@pytest.mark.parametrize(
    ("text", "key", "reason"),
    [
        (rows(FLOOR + 9.81), "rate", "does not contain the times"),
        ("n,z\n" + rows(np.arange(COUNT), FLOOR / G + 1, digits=3), "rate", "sample numbers"),
        ("t [s],value\n" + rows(T, FLOOR), "unit", "does not contain it"),
        ("t [s],a [m/s2],b [m/s2]\n" + rows(T, FLOOR, SIDE), "column",
         "RMS and peak about the mean: `a` 0.3808 and 0.6996 m/s2; `b` 0.2121 and 0.3 m/s2"),
    ],
)  # fmt: skip
def test_what_the_record_does_not_show_is_left_open_and_reported(
    drysim, tmp_path, text, key, reason
):
    found = drafted(drysim, "open.csv", text)
    assert found[key].value is None
    assert reason in found[key].reason
    answer = drysim("validate", "draft.yaml")
    assert answer.code == 2
    assert f"excitation.{key} has no value" in answer.out


@pytest.mark.parametrize("row", [52, 1502])
@pytest.mark.parametrize("torn", ["0.1", "0,1,,", "ERROR,overflow", "t [s],a [m/s2]"])
def test_damaged_row_is_named_and_costs_no_other(drysim, refused, tmp_path, row, torn):
    lines = ("t [s],a [m/s2]\n" + rows(T, FLOOR)).splitlines(keepends=True)
    (tmp_path / "torn.csv").write_text("".join([*lines[: row - 1], torn + "\n", *lines[row:]]))
    said = refused("init", "--from", "torn.csv")
    assert said.count(f": row {row}") == 1
    assert "if it is no sample, delete it" in said
    mended = drafted(drysim, "mended.csv", "".join(lines[: row - 1] + lines[row:]))
    assert mended["gaps"].is_certain
    assert drysim("validate", "draft.yaml").code == 0


@pytest.mark.parametrize("torn", ["0.1", "ERROR", "0,1,2"])
@pytest.mark.parametrize("sound", [0, 2])
def test_damage_below_a_preamble_hides_no_header(tmp_path, torn, sound):
    lines = rows(T, FLOOR).splitlines()
    text = ["Logger 7", "Serial,12", "t [s],a [m/s2]", *lines[:sound], torn, *lines[sound:]]
    (tmp_path / "r.csv").write_text("\n".join(text) + "\n")
    if sound:
        with pytest.raises(RecordError, match=f"row {sound + 4}"):
            inspect_record(tmp_path / "r.csv")
        return
    keys = {each.key: each.value for each in inspect_record(tmp_path / "r.csv").proposals}
    assert (keys["skip"], keys["rows"], keys["time"]) == (2, {"from": 5}, "t")


@pytest.mark.parametrize(("first", "acc"), [("A", "0.1"), ("start", "0.1"), ("", "--")])
def test_text_in_the_first_row_hides_no_header(drysim, tmp_path, first, acc):
    header, begin, *others = ("t [s],a (g)\n" + rows(T, FLOOR)).splitlines()
    text = [header + ",gps", f"{begin.split(',')[0]},{acc},{first}", *(x + "," for x in others)]
    keys = drafted(drysim, "text.csv", "\n".join(text))
    assert not keys.keys() & {"skip", "unit"}
    assert keys["time"].value == "t"


def test_rare_unit_and_sensitivity_are_read(drysim, tmp_path):
    rare = drafted(drysim, "feet.csv", "t [s],a [ft/s2]\n" + rows(T, FLOOR / 0.3048))
    assert "unit" not in rare
    text = "% exported by DAQ\n% fs=400 Hz, unit mV, 100 mV/g\n" + rows(FLOOR / G * 100)
    keys = drafted(drysim, "volt.txt", text)
    assert [keys[key].value for key in ("rate", "unit", "scale")] == ["400 Hz", "g", 0.01]
    assert not keys["scale"].is_certain
    assert np.std(base_motion(package.load("draft.yaml")).u_dd) == pytest.approx(
        np.std(FLOOR), rel=0.01
    )


def test_integer_wav_needs_its_full_scale(drysim, tmp_path):
    with wave.open("floor.wav", "wb") as stream:
        stream.setparams((1, 2, 1000, 0, "NONE", ""))
        stream.writeframes((FLOOR * 1e4).astype("<i2").tobytes())
    answer = drysim("init", "--from", "floor.wav")
    assert "give values to full_scale" in answer.err
    assert "excitation.full_scale has no value" in drysim("validate", "floor.yaml").out
    assert drysim("validate", "floor.yaml", "--set", "excitation.full_scale=33 m/s2").code == 0


def test_uneven_times_are_resampled_at_their_mean_rate(drysim, tmp_path):
    t = T + np.random.default_rng(1).uniform(-4e-4, 4e-4, COUNT)
    found = drafted(drysim, "uneven.csv", "t [s],a [m/s2]\n" + rows(t, FLOOR))
    assert found["resample"].value == {"rate": "400 Hz", "by": "spline"}
    assert drysim("validate", "draft.yaml").code == 0


@pytest.mark.parametrize(("missing", "code"), [(6, 0), (600, 2)])
def test_short_gap_is_filled_and_long_one_left_to_the_user(drysim, tmp_path, missing, code):
    there = np.ones(COUNT, bool)
    there[5000 : 5000 + missing] = False
    found = drafted(drysim, "gap.csv", "t [s],a [m/s2]\n" + rows(T[there], FLOOR[there]))
    assert found["gaps"].is_certain == (code == 0)
    assert drysim("validate", "draft.yaml").code == code


def test_draft_reads_a_record_in_another_folder(drysim, tmp_path):
    (tmp_path / "measured").mkdir()
    (tmp_path / "measured" / "day 1.csv").write_text(FILES["names.csv"])
    assert drysim("init", "--from", "measured/day 1.csv").out == "day 1.yaml\n"
    assert drysim("validate", "day 1.yaml").code == 0


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_draft_for_floor_and_seat_has_an_assessment_as_a_comment(drysim, tmp_path, gravity):
    table = np.column_stack([T, FLOOR + gravity, 0.7 * FLOOR + gravity])
    header = "t [s],floor [m/s2],seat [m/s2]"
    np.savetxt(tmp_path / "both.csv", table, "%.6f", ",", header=header, comments="")
    assert drysim("init", "--from", "both.csv", "draft").code == 0
    text = (tmp_path / "draft.yaml").read_text()
    head, mark, tail = text.partition("# assess:\n")
    block, _, rest = tail.partition("\n\n")
    stated = (mark + block).replace("# ", "")
    (tmp_path / "draft.yaml").write_text(f"{head}{stated}\n\n{rest}")
    assert drysim("assess", "draft.yaml", "--dry-run").code == 0
    floor = "t [s],floor [m/s2],stroke [mm]\n0,0.1,2\n0.1,0.3,1\n0.2,-0.2,0\n"
    (tmp_path / "floor.csv").write_text(floor)
    assert drysim("init", "--from", "floor.csv").code == 0
    assert "assess" not in (tmp_path / "floor.yaml").read_text()


def test_draft_never_replaces_a_file_and_nothing_is_written_for_a_faulty_record(
    refused, tmp_path
):
    (tmp_path / "r.csv").write_text("no numbers\nat all\n")
    (tmp_path / "s.csv").write_text(FILES["names.csv"])
    (tmp_path / "s.yaml").write_text("mine")
    for record in ("r.csv", "s.csv", "missing.csv", "r.xyz"):
        assert refused("init", "--from", record).startswith("error: ")
    assert "s.yaml is a scenario, not a record" in refused("init", "--from", "s.yaml")
    assert "`drysim init --from s.csv` writes a scenario" in refused("init", "s.csv")


def test_damaged_text_is_inspected_or_refused(tmp_path):
    random = np.random.default_rng(2)
    sound = [text[:2000].encode() for text in FILES.values()]
    file = tmp_path / "r.csv"
    for number in range(100):
        data = bytearray(sound[number % len(sound)])
        for at in random.integers(0, len(data), 4):
            data[at : at + int(random.integers(0, 3))] = bytes(
                random.integers(9, 127, 1).tolist()
            )
        file.write_bytes(bytes(data))
        try:
            found = inspect_record(file)
        except RecordError:
            continue
        assert found.columns


@pytest.mark.parametrize(
    "text",
    [
        "time,a\n5,3\n",
        "a\n" + "1\n" * 5 + " " * 20_000,
        "t [s],a\x1b[31mred\n0,1\n0.1,2\n0.2,3\n",
        "t [s],a\u2028start: {x_r: 1 mm}\n0,1\n0.1,2\n0.2,3\n",
    ],
)
def test_odd_file_is_drafted_and_its_text_stays_in_comments(drysim, tmp_path, text):
    drafted(drysim, "odd.csv", text)
    draft = Path("draft.yaml").read_text()
    assert all(line.isprintable() for line in draft.split("\n"))
    assert "start" not in yaml.safe_load(draft)


def test_draft_for_a_link_keeps_the_name_of_the_link(drysim, tmp_path):
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "OBJ123").write_text(FILES["names.csv"])
    (tmp_path / "annex.csv").symlink_to("store/OBJ123")
    assert drysim("init", "--from", "annex.csv").code == 0
    assert drysim("validate", "annex.yaml").code == 0
    assert "store" not in Path("annex.yaml").read_text()


def test_times_of_day_with_a_date_may_span_days(drysim, tmp_path):
    days = [(minute // 1440 + 1, minute // 60 % 24, minute % 60) for minute in range(1800)]
    rows_of_days = "".join(f"2024-01-{d:02d} {h:02d}:{m:02d}:00,{m % 7}\n" for d, h, m in days)
    found = drafted(drysim, "days.csv", "Time,a [m/s2]\n" + rows_of_days)
    assert found["time"].value == "Time"
    assert found["remove"].value == "mean"
    assert base_motion(package.load("draft.yaml")).dt == 60.0


def test_times_with_gaps_are_still_times(drysim, tmp_path):
    there = np.ones(COUNT, bool)
    there[3000:3007] = there[9000:9900] = False
    text = "time_s,floor_g\n" + rows(T[there], FLOOR[there] / G)
    found = drafted(drysim, "gaps.csv", text)
    assert found["time"].value == "time_s"
    assert not found["gaps"].is_certain
    nameless = drafted(drysim, "nameless.csv", text.partition("\n")[2])
    assert nameless["time"].value == 1
    # Frequencies and sample numbers rise, too: a name that is none of times decides nothing.
    named = drafted(drysim, "named.csv", text.replace("time_s", "first"))
    assert named["rate"].value is None
    assert "set `time: first`" in named["rate"].reason


@pytest.mark.parametrize("header", ["t [s],a [m/s2]", "Zeit,Beschleunigung"])
def test_missing_cell_hides_no_column_of_times_and_is_named(drysim, tmp_path, header):
    text = header + "\n" + rows(T, FLOOR + 9.81).replace("\n0.125000,", "\n,")
    found = drafted(drysim, "hole.csv", text)
    assert "time" not in found
    assert found["rate"].value == "400 Hz"
    assert "row 52, column 1" in found["rate"].reason
    assert "the time is missing" in found["rate"].reason
    assert found["column"].value == header.partition(",")[2].split()[0]
    assert drysim("validate", "draft.yaml").code == 0


def test_channels_of_a_wav_are_told_apart_by_figures(drysim, tmp_path):
    noise = 1e-3 * np.random.default_rng(1).standard_normal(COUNT)
    with wave.open("two.wav", "wb") as stream:
        stream.setparams((2, 2, 400, 0, "NONE", ""))
        stream.writeframes((np.stack([FLOOR, noise], 1) * 3e4).astype("<i2").tobytes())
    assert drysim("init", "--from", "two.wav").code == 0
    proposals = inspect_record(Path("two.wav")).proposals
    (reason,) = (one.reason for one in proposals if one.key == "channel")
    assert "`1` 0.34" in reason
    assert "`2` 0.000" in reason
    assert "alike" not in reason


@pytest.mark.parametrize(
    ("mean", "unit", "scale"), [(1, "m/s2", 9.80665), (9.81, "g", 0.101972)]
)
def test_unit_that_is_wrong_by_gravity_is_said(drysim, tmp_path, mean, unit, scale):
    (tmp_path / "u.csv").write_text(f"t [s],a [{unit}]\n" + rows(T, FLOOR / 10 + mean))
    answer = drysim("init", "--from", "u.csv")
    assert f"if the unit is wrong, `scale: {scale}` corrects it" in answer.err
    assert "if the unit is wrong" in " ".join((tmp_path / "u.yaml").read_text().split("# "))
    assert "as of gravity in" in drysim("validate", "u.yaml").out


def test_pause_beside_the_grid_is_drafted_with_keys_that_read_it(drysim, tmp_path):
    t = T.copy()
    t[9000:] += 0.0333
    found = drafted(drysim, "pause.csv", "t [s],a [m/s2]\n" + rows(t, FLOOR))
    assert "start anew" in found["resample"].reason
    assert drysim("validate", "draft.yaml").code == 0
