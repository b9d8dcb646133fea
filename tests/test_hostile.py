"""Scenarios that mean harm: each is refused in a sentence, at once, and quoted in few words."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hang import no_hang
from seat import SEAT

import drysim
from drysim import output
from drysim.errors import DrysimError, OutputError, ScenarioError
from drysim.scenario.load import load

MEGABYTE = 900_000
"""Characters: what a scenario may just hold."""

WORDS = 500
"""Characters of the longest sentence: none of them retells the file."""

HARMONIC = "kind: harmonic, frequency: 1.6, rms: 1.0"

BLANKS, LETTERS = " " * MEGABYTE, "k" * MEGABYTE

FILES = {
    "blanks behind a comparison": SEAT + f'checks: ["T_a <{BLANKS}"]\n',
    "blanks in a condition": SEAT + f'checks: ["T_a < 1 at a >{BLANKS}"]\n',
    "blanks in a unit": SEAT + f'stroke: {{limit: "25 m{BLANKS}x"}}\n',
    "periods without end": SEAT.replace(HARMONIC, "kind: rest").replace(
        "duration: 2", f"duration: {'9' * MEGABYTE} periods"
    ),
    "unit without end": SEAT + f'stroke: {{limit: "25 {LETTERS}"}}\n',
    "sign without end": SEAT + f'checks: ["T_a {"<" * MEGABYTE}"]\n',
    "metric without end": SEAT + f'checks: ["{LETTERS} < 1"]\n',
    "condition without end": SEAT + f'checks: ["T_a < 1 at {LETTERS} > 1"]\n',
    "many unknown keys": SEAT + "".join(f"kinetically_abc{i}: 1\n" for i in range(25_000)),
    "many duplicate keys": SEAT + "a: 1\n" * 25_000,
    "many tags": SEAT + "x: [" + "!!str 1, " * 45_000 + "]\n",
    "many checks that are none": SEAT + "checks: [" + "T_b < 1, " * 45_000 + "]\n",
    "many values": SEAT + "x: [" + "1, " * 300_000 + "]\n",
    "many keys in a sweep": SEAT
    + "sweep: {" + "".join(f"a.b{i}: [1, 2]," for i in range(12_000)) + "}\n",
    "key without end": SEAT + f"? '{LETTERS}'\n: 1\n",
    "key without space": SEAT + f"{LETTERS}:b\n",
    "alias without end": SEAT + f"x: *{LETTERS}\n",
    "name without end": SEAT.replace("seat", LETTERS),
    "approach without end": SEAT.replace("stick-slip", LETTERS),
    "kind without end": SEAT.replace("harmonic", LETTERS),
    "word in place of a number": SEAT.replace("75,", f"{LETTERS},"),
    "unit of a record without end": SEAT.replace(
        HARMONIC, f"kind: record, file: a.csv, unit: {LETTERS}"
    ),
    "remove without end": SEAT.replace(
        HARMONIC, f"kind: record, file: a.csv, remove: {LETTERS}"
    ),
    "deep lists": "[" * MEGABYTE,
    "deep blocks": "".join(" " * i + "a:\n" for i in range(1300)),
    "open quote": '"' + LETTERS,
    "directive without end": f"%YAML {'1' * MEGABYTE}\n--- a\n",
}  # fmt: skip


def problems(path, overrides=()):
    """Return the problems of a file that must have some."""
    with pytest.raises(ScenarioError) as fault:
        load(path, overrides)
    return fault.value.problems


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_file_that_means_harm_is_refused_at_once_in_few_words(tmp_path, text):
    file = tmp_path / "seat.yaml"
    file.write_text(text)
    with no_hang():
        found = problems(file)
    assert 0 < len(found) <= 100
    assert max(len(problem.sentence) for problem in found) < WORDS
    assert max(len(problem.key) for problem in found) < WORDS


def test_hundred_problems_are_enough(scenario):
    with pytest.raises(ScenarioError, match="more than 100 errors; the first 100 are shown"):
        scenario(SEAT + "".join(f"key{i}: 1\n" for i in range(200)))


def test_number_of_endless_digits_is_the_double_next_to_it(scenario):
    text = SEAT + f"stroke: {{limit: '25.{'0' * 5000} mm'}}\n"
    assert scenario(text).stroke.limit == 0.025


@pytest.mark.parametrize(
    ("value", "sentence"),
    [(10**5000, "a whole number of"), (10**400, "1000000000"), (math.nan, "nan")],
    ids=["beyond printing", "beyond doubles", "not a number"],
)
def test_number_beyond_doubles_is_named_in_few_words(seat, value, sentence):
    (problem,) = problems(seat, {"oscillator.mass": value})
    told = f"oscillator.mass must be a finite number [kg], not {sentence}"
    assert problem.sentence.startswith(told)
    assert len(problem.sentence) < WORDS


@pytest.mark.parametrize(
    "text", ["1_000", "1:30", "2024-01-01", "0x10", "0o17", "1e400", ".inf"]
)
def test_word_that_other_readers_take_for_a_number_is_none(tmp_path, text):
    (tmp_path / "seat.yaml").write_text(SEAT.replace("mass: 75", f"mass: {text}"))
    (problem,) = problems(tmp_path / "seat.yaml")
    assert problem.key == "oscillator.mass"
    assert problem.sentence.startswith(("oscillator.mass ", "oscillator.mass: "))


def test_huge_numbers_of_overrides_are_laid_over(seat):
    words = [f"oscillator.mass={1 + i}" for i in range(5000)]
    assert load(seat, words).oscillator.mass == 5000.0
    found = problems(seat, [f"a{i}.b=1" for i in range(5000)])
    assert len(found) == 100


def test_file_of_a_gigabyte_is_refused_unread(tmp_path):
    with (tmp_path / "seat.yaml").open("wb") as file:
        file.write(b"about: ")
        file.truncate(10**9)
    with no_hang():
        assert "larger than 1 MB" in problems(tmp_path / "seat.yaml")[0].sentence


@pytest.mark.parametrize("end", ["\r\n", "\r"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_line_ends_and_marks_of_other_systems_are_understood(tmp_path, end, mark):
    file = tmp_path / "seat.yaml"
    file.write_bytes(mark + SEAT.replace("\n", end).encode())
    assert load(file).oscillator.mass == 75.0
    file.write_bytes(mark + SEAT.replace("mass", "mas").replace("\n", end).encode())
    assert [problem.line for problem in problems(file)] == [3]


def test_name_that_no_disk_holds_is_refused_in_a_sentence(tmp_path):
    assert "name too long" in problems(tmp_path / ("x" * 300 + ".yaml"))[0].sentence


# Scenes that a sceptic keeps aside: stops, parting surfaces, laws at the ends of their keys.
#
# Each ends in numbers whose energy closes, or in a sentence that names the key.


CLOSES = 1e-10

STEADY = {"measure": {"steady": True}}
NOISE = {"kind": "psd", "points": [[0.8, 1], [4, 1]], "duration": 4, "seed": 1}
SHOCK = {"kind": "shock", "pulse": "half-sine", "amplitude": 1e5, "duration": 0.01}
BLOCK = {"oscillator": {"mass": 75, "stiffness": 0, "damping": 0}}


def stops(limit: float = 0.01, **words: float) -> dict[str, object]:
    return {"stroke": {"limit": limit, "stops": words}}


def lifting(amplitude: float, frequency: float, phase: float = 0.0) -> dict[str, object]:
    varied = {"amplitude": amplitude, "frequency": frequency, "phase": phase}
    return {"friction": {"law": "coulomb", "kinetic": 30, "normal_variation": varied}}


def law(name: str, **words: float) -> dict[str, object]:
    return {"friction": {"law": name, "kinetic": 45, **words}}


def sines(*phases: float) -> dict[str, object]:
    every = [{"frequency": 1.6, "amplitude": 1.0, "phase": phase} for phase in phases]
    return {"excitation": {"kind": "sines", "components": every}}


SOLVED = {
    "sines that cancel, and no friction": sines(0.0, math.pi) | {"friction": None} | STEADY,
    "sines that nearly cancel, and no friction": sines(0.0, math.pi - 1e-12)
    | {"friction": None}
    | STEADY,
    "rigid stop that keeps no speed": stops(restitution=0) | STEADY,
    "rigid stop that keeps all of it": stops(restitution=1),
    "rigid stop next to nothing away": stops(1e-12, restitution=0.3),
    "rigid stop and no spring": stops(restitution=0.3) | BLOCK,
    "rigid stop under a shock at once": stops(restitution=0.5) | {"excitation": SHOCK},
    "rigid stop under noise": stops(restitution=0.5) | {"excitation": NOISE, "measure": {}},
    "rigid stop that the start is thrown at": stops(restitution=0.9)
    | {"start": {"x_r": 0.01, "v_r": 1.0}},
    "rigid stop and a strong swing of the limits": stops(restitution=0.3) | lifting(0.99, 3.2),
    "bumper as hard as a diamond": stops(stiffness=1e12) | STEADY,
    "bumper as soft as air": stops(stiffness=1e-12),
    "bumper of pitch": stops(stiffness=1e5, damping=1e9),
    "bumper squeezed by a metre": stops(stiffness=1e5) | {"start": {"x_r": 1.01}},
    "mass of a microgram between stops": stops(restitution=0.3)
    | {"oscillator": {"mass": 1e-9, "stiffness": 1e-7, "damping": 1e-9}}
    | {"friction": {"law": "coulomb", "kinetic": 1e-10}},
    "surfaces that just do not press": lifting(1.0, 4.0),
    "surfaces that just part, in step with the base": STEADY
    | lifting(math.nextafter(1.0, 2.0), 1.6),
    "surfaces that part as the motion begins": lifting(1.0, 3.0, -math.pi / 2),
    "surfaces that are apart half of the time": lifting(1e9, 4.0),
    "surfaces that part under a shock": lifting(1.5, 3.0) | {"excitation": SHOCK},
    "surfaces that part, and no spring": lifting(1.5, 3.0) | BLOCK,
    "contact as soft as air": law("jenkins", tangential_stiffness=1e-12),
    "contact as hard as a diamond": law("jenkins", tangential_stiffness=1e12),
    "bristles as soft as air": law("dahl", bristle_stiffness=1e-12),
    "bristles as hard as a diamond": law("dahl", bristle_stiffness=1e12),
    "curve that never falls": law("stribeck", static_ratio=1.2, stribeck_velocity=1e12),
    "bristles that never slide fast enough": law(
        "lugre", static_ratio=1.2, stribeck_velocity=1e12, bristle_stiffness=1e5,
        bristle_damping=0,
    ),
    "base of ten kilohertz": {"excitation.frequency": 1e4, "measure": {"duration": 0.1}},
    "damper of pitch": {"oscillator.damping": 1e9},
    "friction next to none": {"friction.kinetic": 1e-30},
    "friction beyond measure": {"friction.kinetic": 1e30},
    "base that hardly moves": {"excitation.rms": 1e-30, "friction.kinetic": 1e-29},
}  # fmt: skip


@pytest.mark.parametrize("words", SOLVED.values(), ids=SOLVED)
def test_scene_at_the_end_of_its_keys_closes_its_energy(seat, words):
    outcome = drysim.run(drysim.load(seat, words))
    known = {name: value for name, value in outcome.metrics.items() if value is not None}
    assert all(math.isfinite(value) for value in known.values()), known
    assert known["energy_residual"] < CLOSES
    limit = words.get("stroke")
    if limit is not None and "restitution" in limit["stops"]:
        assert known["x_r_peak"] <= limit["limit"]


@pytest.mark.parametrize(("phases", "A"), [((0.3, 0.3), 2.0), ((0.0, math.pi / 2), 2**0.5)])
def test_sines_of_one_frequency_are_one_sine(seat, phases, A):
    one = {"kind": "harmonic", "frequency": 1.6, "amplitude": A, "phase": sum(phases) / 2}
    found = [
        drysim.run(drysim.load(seat, STEADY | words)).metrics
        for words in (sines(*phases), {"excitation": one})
    ]
    assert found[0]["T_a"] == pytest.approx(found[1]["T_a"], rel=1e-12)
    assert found[0]["a_u"] == pytest.approx(found[1]["a_u"], rel=1e-14)


def test_sines_of_one_frequency_are_one_sine_in_a_sweep_of_one_amplitude(seat):
    words, key = STEADY | sines(0.3, 1.1), "excitation.components.1.amplitude"
    table = drysim.sweep(drysim.load(seat, words | {"sweep": {key: [0.0, 0.5, 1.0]}}))
    for row in table:
        alone = drysim.run(drysim.load(seat, words | row.point)).metrics
        assert row.metrics["T_a"] == pytest.approx(alone["T_a"], rel=1e-12)


REFUSED = {
    "no room": (stops(0, restitution=0.3), "stroke.limit must be above 0 m, not 0"),
    "bumper that is none": (stops(stiffness=0), "stroke.stops.stiffness must be above 0 N/m"),
    "bumper that pulls": (stops(stiffness=1e5, damping=-1),
        "damping must be at least 0 N·s/m, not -1"),
    "stop that speeds up": (stops(restitution=1.1), "stops.restitution must be at most 1"),
    "stop of two kinds": (stops(stiffness=1, restitution=1),
        "give restitution or stiffness, not both"),
    "start beyond a rigid stop": (stops(restitution=0.3) | {"start": {"x_r": 0.02}},
        "with rigid stops, not 0.02"),
    "stops for bristles": (
        stops(restitution=0.3) | law("dahl", bristle_stiffness=1e5),
        "end stops support the laws coulomb, jenkins",
    ),
    "damping that drives": ({"oscillator.damping": -1}, "damping must be at least 0 N·s/m"),
    "surfaces that pull": (lifting(-1.0, 4.0), "amplitude must be at least 0, not -1"),
    "load without a period": (lifting(1.5, 0.0), "frequency must be above 0 Hz, not 0"),
    "load without a common period": (lifting(1.5, 1.6180339887) | STEADY,
        "needs a common period"),
    "contact that holds nothing": (
        law("jenkins", tangential_stiffness=0),
        "tangential_stiffness must be above 0 N/m, not 0",
    ),
    "curve without width": (
        law("stribeck", stribeck_velocity=0),
        "stribeck_velocity must be above 0 m/s, not 0",
    ),
    "bristles of pitch": (
        law("lugre", stribeck_velocity=0.01, bristle_stiffness=1e5, bristle_damping=1e12),
        "h of work; check the units",
    ),
    "force in digits of another script": ({"friction.kinetic": "１５"},
        "friction.kinetic must be a number [N]"),
}  # fmt: skip


@pytest.mark.parametrize(("words", "sentence"), REFUSED.values(), ids=REFUSED)
def test_scene_beyond_its_keys_is_refused_in_a_sentence(seat, words, sentence):
    with pytest.raises(DrysimError) as fault:
        drysim.run(drysim.load(seat, words))
    (problem,) = fault.value.problems
    assert sentence in problem.sentence


@pytest.mark.parametrize("key", ["start\u2028\u2028", "start" + "1e999" * 500])
def test_proposed_key_is_short_and_on_one_line(seat, key):
    with pytest.raises(DrysimError) as fault:
        drysim.load(seat, {f"{key}.x_r": 1, "start": None})
    message = str(fault.value)
    assert "did you mean `start" in message
    assert max(map(len, message.splitlines())) < 400
    assert all(message.splitlines())


ANY = {0, 1, 2}
"""Contacts of an orbit whose peaks on either side rounding decides."""


@pytest.mark.parametrize(
    ("near", "contacts"),
    [(1 - 1e-9, {2}), (1 - 1e-15, ANY), (1.0, ANY), (1 + 1e-15, ANY), (1 + 1e-9, {0})],
)
def test_bumper_that_an_orbit_just_reaches_is_hardly_felt(seat, near, contacts):
    free = drysim.run(drysim.load(seat, STEADY)).metrics
    bumper = stops(near * free["x_r_peak"], stiffness=1e6, damping=10)
    met = drysim.run(drysim.load(seat, bumper | STEADY)).metrics
    assert met["contacts"] in contacts
    assert met["T_a"] == pytest.approx(free["T_a"], rel=1e-6)


# A scenario from a stranger: it runs nothing, and touches its record and its folder alone.


PROGRAM = """\
import json, os, re, sys
from fuzz.watch import OURS, PROGRAMS, CHANGES
LIMITS = re.compile(r"/proc/\\d+/cgroup|/sys/fs/cgroup/.*(memory|cpu)\\.[a-z_]+")
touched = set()
def note(event, words):
    if event in PROGRAMS and words[0] is not None:
        touched.add(f"{event} {words[0]}")
    if event == "open" and isinstance(words[0], str | bytes) or event in CHANGES:
        path = os.path.realpath(os.fsdecode(words[0]))
        if LIMITS.fullmatch(path) and event == "open":
            return  # how much the container may use
        if not path.startswith(OURS) and not path.startswith(sys.base_prefix):
            touched.add(os.path.relpath(path))
from drysim.cli import main
sys.addaudithook(note)
code = main(sys.argv[1:])
sys.stdout = sys.__stdout__
print("\\n" + json.dumps([code, sorted(touched)]))
"""

RECORDED = """\
name: seat
oscillator: {mass: 75, stiffness: 7500, damping: 500}
friction: {law: coulomb, kinetic: 15}
excitation: {kind: record, file: FILE, column: u_dd, time: t}
"""
ROWS = "t [s],u_dd [m/s2]\n0.00,0.1\n0.01,0.2\n0.02,0.3\n0.03,0.1\n"


def touched(folder, *words):
    """Run drysim in a process; give its exit code and what it opened, changed or ran."""
    environment = os.environ | {"DRYSIM_ENGINE": "plain"}
    path = [str(Path(__file__).parent), environment.get("PYTHONPATH", "")]
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words],
        cwd=folder,
        env=environment | {"PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
    )
    code, paths = json.loads(done.stdout.splitlines()[-1])
    return code, set(paths)


def test_run_touches_scenario_record_and_folder_alone(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "data").mkdir()
    (tmp_path / "data/base.csv").write_text(ROWS)
    (tmp_path / "in/seat.yaml").write_text(RECORDED.replace("FILE", "../data/base.csv"))
    code, paths = touched(tmp_path / "in", "run", "seat.yaml", "--no-plots", "-q")
    assert code == 0
    outside = {path for path in paths if not path.startswith("out/seat")}
    assert outside == {"seat.yaml", "../data/base.csv", "out"}


EVIL = {
    "tag that runs a program": SEAT + "about: !!python/object/apply:os.system [touch owned]\n",
    "tag of an object": SEAT + "start: !!python/object/new:os.system [touch owned]\n",
    "folder above": SEAT.replace("name: seat", "name: ../../owned"),
    "absolute folder": SEAT.replace("name: seat", "name: /tmp/owned"),
    "folder of a home": SEAT.replace("name: seat", "name: ~root"),
    "hidden folder": SEAT.replace("name: seat", "name: .ssh"),
    "folder with a line end": SEAT.replace("name: seat", 'name: "a\\nb"'),
    "folder with an escape": SEAT.replace("name: seat", 'name: "a\\e[31m"'),
    "password file": RECORDED.replace("FILE", "/etc/passwd"),
    "device": RECORDED.replace("FILE", "/dev/zero"),
    "process": RECORDED.replace("FILE", "/proc/self/environ"),
    "address": RECORDED.replace("FILE", "http://127.0.0.1:9/x.csv"),
    "pipe of a shell": RECORDED.replace("FILE", "'|touch owned'"),
    "formula": SEAT + "checks: ['__import__(\"os\").system(\"touch owned\") < 1']\n",
    "formula as a unit": SEAT + "stroke: {limit: '1 __import__(\"os\").abort()'}\n",
    "power as a unit": SEAT + "stroke: {limit: '1 m^9^9^9^9'}\n",
    "options of numpy": SEAT.replace(HARMONIC, "kind: record, file: a.npy, allow_pickle: true"),
}  # fmt: skip


@pytest.mark.parametrize("text", EVIL.values(), ids=EVIL)
def test_scenario_that_means_harm_is_refused_and_nothing_happens(refused, tmp_path, text):
    (tmp_path / "seat.yaml").write_text(text)
    assert "root:" not in refused("run", "seat.yaml")


@pytest.mark.slow
@pytest.mark.parametrize("text", EVIL.values(), ids=EVIL)
def test_scenario_that_means_harm_touches_nothing_but_itself(tmp_path, text):
    (tmp_path / "seat.yaml").write_text(text)
    code, paths = touched(tmp_path, "run", "seat.yaml")
    assert code == 2
    assert paths <= {"seat.yaml"}


def test_column_that_drives_the_terminal_is_shown_and_not_obeyed(drysim, tmp_path):
    (tmp_path / "seat.yaml").write_text(RECORDED.replace("FILE", '"a\\e]0;owned\\a.csv"'))
    for file, rows in {
        "a\x1b]0;owned\x07.csv": ROWS.replace("u_dd", "\x1b[2Ju_dd\u202e"),
        "b.csv": ROWS,
    }.items():
        (tmp_path / file).write_text(rows)
    said = drysim("run", "seat.yaml").err
    assert "there is no column" in said
    assert all(sign.isprintable() for sign in said.replace("\n", ""))


def test_unit_and_key_that_drive_the_terminal_are_shown_and_not_obeyed(drysim, tmp_path):
    unit = SEAT + 'stroke: {limit: "25 m\\e[31m\\u009b2J"}\n"k\\e[2J\\u202e": 1\n'
    (tmp_path / "seat.yaml").write_text(unit)
    for words in (["run"], ["validate"], ["validate", "--format", "json"]):
        answer = drysim(*words, "seat.yaml")
        assert answer.code == 2
        assert all(sign.isprintable() for sign in (answer.out + answer.err).replace("\n", ""))


# Folders that somebody else has prepared


@pytest.mark.parametrize(
    "marker",
    ['{"format": 1, "files": 5}', '{"format": 1, "files": [["x"]]}',
     '{"format": 1, "files": null}', "[" * 10_000, "5", '{"format": "1"}',
     '{"format": ' + "1" * 5000 + "}", ""],
    ids=["number", "lists", "nothing", "deep", "no block", "text", "endless", "torn"],
)  # fmt: skip
def test_folder_with_a_strange_marker_is_refused_in_a_sentence(tmp_path, monkeypatch, marker):
    monkeypatch.chdir(tmp_path)
    Path("out").mkdir()
    Path("out/drysim.json").write_text(marker)
    Path("out/mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"drysim did not write|not written by drysim"):
        output.check_writable(Path("out"))
    assert Path("out/mine.txt").read_text() == "mine"


def test_links_in_a_prepared_folder_lead_nowhere(drysim, seat):
    (seat.parent / "mine.txt").write_text("mine")
    (seat.parent / "mine").mkdir()
    (seat.parent / "mine/thesis.txt").write_text("years of work")
    for folder in ("out/seat", "out/seat.partial"):
        (seat.parent / folder).mkdir(parents=True)
        named = dict.fromkeys(("response.csv", "cases.jsonl", "sub", "cases.new"), "")
        marker = json.dumps({"format": 1, "files": named})
        (seat.parent / folder / "drysim.json").write_text(marker)
        for name in ("response.csv", "cases.jsonl", "cases.new"):
            (seat.parent / folder / name).symlink_to(seat.parent / "mine.txt")
        (seat.parent / folder / "sub").symlink_to(seat.parent / "mine")
    assert drysim("run", seat, "--no-plots").code == 0
    assert (seat.parent / "mine.txt").read_text() == "mine"
    assert (seat.parent / "mine/thesis.txt").read_text() == "years of work"
    assert not (seat.parent / "out/seat/response.csv").is_symlink()


@pytest.mark.parametrize(("target", "code"), [("/dev/zero", 0), ("mine.txt", 2), ("mine", 2)])
def test_finished_cases_that_are_links_are_never_taken_as_such(drysim, seat, target, code):
    (seat.parent / "mine.txt").write_text("mine")
    (seat.parent / "mine").mkdir()
    partial = seat.parent / "out/seat.partial"
    partial.mkdir(parents=True)
    (partial / "drysim.json").write_text('{"format": 1}')
    if target == "mine":
        (partial / "cases").symlink_to(seat.parent / target)
    else:
        (partial / "cases").mkdir()
        (partial / "cases/sweep.json").symlink_to(seat.parent / target)
    words = ("--resume", "--no-plots", "--set", "sweep={excitation.frequency: [1, 2]}")
    assert drysim("sweep", seat, *words).code == code
    assert (seat.parent / "mine.txt").read_text() == "mine"
    assert list((seat.parent / "mine").iterdir()) == []
