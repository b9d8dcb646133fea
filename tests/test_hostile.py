"""Scenarios that mean harm: each is refused in a sentence, at once, and quoted in few words."""

from __future__ import annotations

import time

import pytest

from drysim.errors import ScenarioError
from drysim.scenario.load import load
from seat import SEAT

MEGABYTE = 900_000
"""Characters: what a scenario may just hold."""

SECONDS = 2.0
"""Processor time that a file of a megabyte may take; most take some hundredths."""

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
    """Give the problems of a file that must have some."""
    with pytest.raises(ScenarioError) as fault:
        load(path, overrides)
    return fault.value.problems


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_file_that_means_harm_is_refused_at_once_in_few_words(tmp_path, text):
    file = tmp_path / "seat.yaml"
    file.write_text(text)
    began = time.process_time()
    found = problems(file)
    assert time.process_time() - began < SECONDS
    assert 0 < len(found) <= 100
    assert max(len(problem.sentence) for problem in found) < WORDS
    assert max(len(problem.key) for problem in found) < WORDS


def test_hundred_problems_are_enough(tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT + "".join(f"key{i}: 1\n" for i in range(200)))
    with pytest.raises(ScenarioError, match="more than 100 problems; the first are these"):
        load(tmp_path / "seat.yaml")


def test_number_of_endless_digits_is_the_double_next_to_it(tmp_path):
    digits = SEAT + f"stroke: {{limit: '25.{'0' * 5000} mm'}}\n"
    (tmp_path / "seat.yaml").write_text(digits)
    assert load(tmp_path / "seat.yaml").stroke.limit == 0.025


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        (10**5000, "oscillator.mass must be a finite number [kg], not a whole number of"),
        (10**400, "oscillator.mass must be a finite number [kg], not 1000000000"),
        (float("nan"), "oscillator.mass must be a finite number [kg], not nan"),
    ],
    ids=["beyond printing", "beyond doubles", "not a number"],
)
def test_number_beyond_doubles_is_named_in_few_words(tmp_path, value, sentence):
    (tmp_path / "seat.yaml").write_text(SEAT)
    (problem,) = problems(tmp_path / "seat.yaml", {"oscillator.mass": value})
    assert problem.sentence.startswith(sentence)
    assert len(problem.sentence) < WORDS


@pytest.mark.parametrize(
    "text", ["1_000", "1:30", "2024-01-01", "0x10", "0o17", "1e400", ".inf"]
)
def test_word_that_other_readers_take_for_a_number_is_none(tmp_path, text):
    (tmp_path / "seat.yaml").write_text(SEAT.replace("mass: 75", f"mass: {text}"))
    (problem,) = problems(tmp_path / "seat.yaml")
    assert problem.key == "oscillator.mass"
    assert problem.sentence.startswith(("oscillator.mass ", "oscillator.mass: "))


def test_huge_numbers_of_overrides_are_laid_over(tmp_path):
    (tmp_path / "seat.yaml").write_text(SEAT)
    words = [f"oscillator.mass={1 + i}" for i in range(5000)]
    assert load(tmp_path / "seat.yaml", words).oscillator.mass == 5000.0
    found = problems(tmp_path / "seat.yaml", [f"a{i}.b=1" for i in range(5000)])
    assert len(found) == 100


def test_file_of_a_gigabyte_is_refused_unread(tmp_path):
    with (tmp_path / "seat.yaml").open("wb") as file:
        file.write(b"about: ")
        file.truncate(10**9)
    began = time.process_time()
    assert "larger than 1 MB" in problems(tmp_path / "seat.yaml")[0].sentence
    assert time.process_time() - began < SECONDS


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
