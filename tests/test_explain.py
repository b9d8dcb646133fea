"""What `drysim explain` knows: words, their facts, and examples that are valid."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import drysim as package
from drysim import results
from drysim.errors import ScenarioError
from drysim.manual.words import (
    CLASS,
    EXCITATION,
    GROUPS,
    KEY,
    LAW,
    METRIC,
    TERMS,
    UNIT,
    WARNING,
    Entry,
    entries,
    explain,
)

BASE = {
    "oscillator": "{mass: 75, stiffness: 7500, damping: 500}",
    "excitation": "{kind: psd, points: [[0.5, 0.1], [10, 0.1]], duration: 60 s, seed: 1}",
    "friction": "{kinetic: 45}",
    "solver": "{step: 5 ms}",
    "measure": "{duration: 60 s}",
}

MISSING = re.compile("is required|requires|needs|not both|is not used|cannot be varied")
"""Errors of examples that lack what belongs to them."""


def problems(overrides: list[str], **blocks: str) -> list[tuple[str, str]]:
    """Return the keys and sentences of the errors of a scenario with some blocks."""
    text = "".join(f"{name}: {block}\n" for name, block in (BASE | blocks).items())
    try:
        package.scenario(text, overrides)
    except ScenarioError as fault:
        return [(problem.key, problem.sentence) for problem in fault.problems]
    return []


def keys() -> list[Entry]:
    """Return every key with its example, in each meaning."""
    words = dict.fromkeys(entry.word for entry in entries() if entry.kind == KEY)
    meanings = [entry for word in words for entry in explain(word)]
    return list(dict.fromkeys(entry for entry in meanings if entry.kind == KEY))


def example_of_kind(name: str) -> str:
    """Return the example of a kind of base motion, a friction law or a class."""
    kinds = (EXCITATION, LAW, CLASS)
    return next(entry.example for entry in explain(name) if entry.kind in kinds)


def test_every_key_has_a_type_and_an_example():
    assert [entry.word for entry in keys() if not entry.example or not entry.type] == []


def test_examples_of_keys_are_valid():
    wrong = []
    for entry in keys():
        block, _, kind = entry.where.partition(" with ")
        blocks = {}
        if kind:
            name = kind.partition(": ")[2].split(", ")[0]
            blocks[block] = example_of_kind(name).partition(": ")[2]
        setting = shlex.split(entry.example.removeprefix("--set "))[0]
        if "." not in entry.word:
            setting = entry.example.replace(": ", "=", 1)
        elif not entry.example.startswith("--set "):
            continue
        wrong += [
            (setting, sentence)
            for key, sentence in problems([setting], **blocks)
            if f"{key}.".startswith(f"{entry.word}.") and not MISSING.search(sentence)
        ]
    assert wrong == []


def test_examples_of_kinds_laws_and_classes_are_valid():
    for entry in entries():
        if entry.kind in (EXCITATION, LAW, CLASS):
            example = example_of_kind(entry.word)
            block, _, text = example.partition(": ")
            wrong = [
                sentence for key, sentence in problems([], **{block: text}) if block in key
            ]
            assert wrong == [], example


def test_examples_of_metrics_are_checks():
    for entry in entries():
        if entry.kind == METRIC:
            assert problems([], checks=entry.example.partition(": ")[2]) == [], entry.word
    assert explain("x_r_peak")[0].example == "checks: [x_r_peak < 25 mm]"


def test_keys_that_select_a_kind_list_its_choices():
    words = {"excitation": "road", "excitation.kind": "road", "friction": "dahl"}
    for word, choice in (words | {"friction.law": "dahl"}).items():
        (entry,) = explain(word)
        assert choice in dict(entry.choices)
        assert all(dict(entry.choices).values())
    assert explain("friction.law")[0].default == "coulomb"


def test_choices_come_from_the_models():
    forms = dict(explain("solver.smooth.form")[0].choices)
    assert [*forms] == ["arctan", "tanh", "erf", "rational"]
    assert [*dict(explain("excitation.resample.by")[0].choices)] == ["line", "spline"]
    assert [*dict(explain("sweep.direction")[0].choices)] == ["up", "down", "both"]


def test_blocks_and_kinds_list_their_keys():
    (oscillator,) = explain("oscillator")
    assert oscillator.keys[:2] == ("mass", "stiffness")
    assert explain("harmonic")[0].keys == ("frequency", "rms", "amplitude", "phase")
    assert explain("stroke.stops")[0].keys[-1] != ""


@pytest.mark.parametrize(
    ("word", "meaning"),
    [
        ("ISO 7096", "ISO 7096"), ("iso7096", "ISO 7096"), ("ISO 2631", "ISO 2631-1"),
        ("2002/44", "2002/44/EC"), ("best", "best"), ("swept", "swept"), ("p95", "quantile"),
        ("t_A", "T_a"), ("Stiffness", "oscillator.stiffness"), ("✓ holds", "holds"),
        ("branch 2", "branch"), ("moving base", "belt"), ("force", "force"),
        ("excitation.psd", "psd"), ("friction.lugre", "lugre"),
    ],
)  # fmt: skip
def test_word_is_explained_however_it_is_written(word, meaning):
    assert meaning in [entry.word for entry in explain(word)]


def test_files_of_every_kind_of_result_are_explained():
    names = {
        file.name for kind in results.all_kinds() for file in kind.files if "*" not in file.name
    }
    assert "draws.csv" in names
    assert [name for name in sorted(names) if not explain(name)] == []


def test_fixed_labels_of_summaries_are_explained():
    files = Path(results.__file__).parent.glob("*.py")
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    labels = {*re.findall(r'yield \(?\s*"([a-z]+)"|\bRow\(\s*"([^"]+)"', text)}
    labels = {scene or row for scene, row in labels} - {"…"}
    assert {"base", "window", "evaluated", "isolation", "hysteresis", "stops hit"} <= labels
    assert [label for label in sorted(labels) if not explain(label)] == []
    assert explain("seeds")[-1].word == "excitation.seeds"  # the key of that name follows


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("transmisibility", "did you mean `transmissibility`?"),
        ("Stifness", "did you mean `stiffness`?"),
        ("clipping", "did you mean `record-clipped`?"),
        ("resonance", "it is mentioned in `drysim explain measure.segment`"),
        ("xyzzy", "`drysim explain --list` shows all words"),
        ("", "`drysim explain --list` shows all words"),
    ],
)
def test_unknown_word_leads_to_the_next_step(refused, word, hint):
    assert hint in refused("explain", word)


UNNAMED_WARNINGS = {
    "files-changed": "`summarise` alone shows it, as a sentence: test_report, test_bad_input",
}
"""Warnings that no test names by their slug, and why."""


def test_slug_of_every_warning_is_written_in_a_test():
    here = Path(__file__)
    modules = [file for file in here.parent.rglob("test_*.py") if file != here]
    text = "".join(file.read_text(encoding="utf-8") for file in modules)
    slugs = {entry.word for entry in entries() if entry.kind == WARNING}
    named = {slug for slug in slugs if re.search(rf"(?<![\w-]){slug}(?![\w-])", text)}
    assert slugs - named == UNNAMED_WARNINGS.keys()


def test_units_that_nobody_means_are_no_answer(refused):
    # pint reads them as milli-years, attometres, deci-years, picoinches and years.
    for word in ("ma", "am", "da", "pin", "a"):
        assert f"nothing is known about `{word}`" in refused("explain", word)
    for word in ("um", "µm", "ft", "lbf", "mil", "millimetre", "lbf/in", "%", "daN", "dm"):
        assert explain(word)[0].kind == UNIT, word


def test_list_shows_every_word_but_keys_in_blocks_once_in_its_group(drysim):
    done = drysim("explain", "--list")
    shown = " ".join(done.out.split())
    assert all(group in done.out.splitlines() for group in GROUPS)
    kinds = [kind for group in GROUPS.values() for kind in group]
    assert {entry.kind for entry in entries()} == {*kinds}
    for word in ("excitation", "EM3", "stick-slip", "T_a", "best", "stroke-violated", "force"):
        assert re.search(rf"(?<![\w.-]){re.escape(word)}(?![\w-])", shown), word
    assert "oscillator.mass" not in shown


@pytest.mark.parametrize("entry", sorted(set(TERMS.values())))
def test_what_a_term_stands_for_is_explained(entry):
    assert explain(entry)


def test_no_word_is_refused(refused):
    assert "name a word" in refused("explain")
