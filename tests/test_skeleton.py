"""The scenario that `drysim init --new` writes: valid, and so is each key in its comments."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from drysim.cli import commands
from drysim.errors import ScenarioError
from drysim.manual.skeleton import ONE_LINE, skeleton
from drysim.manual.words import blocks
from drysim.scenario.load import scenario
from drysim.study import gallery

COMMENTED_KEY = re.compile(r"^ *# \w+: [^ ].*$", re.M)
EXCLUDED = re.compile("already; give|require|is not used with")
"""Messages on keys that need others, or exclude those that are stated."""


def test_new_scenario_is_valid_and_runs(drysim, tmp_path):
    answer = drysim("init", "--new")
    assert (answer.code, answer.out) == (0, "scenario.yaml\n")
    assert "drysim run scenario.yaml" in answer.err
    assert drysim("validate", "--strict", "scenario.yaml").out == "ok: scenario.yaml\n"
    assert drysim("run", "scenario.yaml", "--no-plots").code == 0
    assert drysim("init", "--new", "mine.yaml").out == "mine.yaml\n"
    again = drysim("init", "mine", "--new")
    assert again.code == 2
    assert "mine.yaml already exists" in again.err


@pytest.mark.parametrize("way", ["--new", "--from=r.csv"])
def test_new_scenario_keeps_either_suffix_and_is_quoted_in_what_is_next(drysim, place, way):
    (place / "r.csv").write_text("t [s],u_dd [m/s2]\n0,0.1\n0.1,-0.2\n0.2,0.1\n")
    assert drysim("init", way, "foo.yml").out == "foo.yml\n"
    answer = drysim("init", way, "sub folder/a b")
    assert answer.out == "sub folder/a b.yaml\n"
    assert "drysim validate 'sub folder/a b.yaml'" in answer.err
    assert sorted(path.name for path in place.iterdir()) == ["foo.yml", "r.csv", "sub folder"]


@pytest.mark.parametrize("way", ["--new", "--from=r.csv"])
@pytest.mark.parametrize("name", [".", "..", "bar/", "bar/..", ".yaml", ".yml", "bar/.yaml"])
def test_new_scenario_needs_a_name(drysim, place, name, way):
    answer = drysim("init", way, name)
    assert (answer.code, answer.out) == (2, "")
    assert f"`{name}` is not the name of a file" in answer.err
    assert not list(place.iterdir())


def test_new_scenario_has_every_key_of_its_blocks():
    text = skeleton()
    assert all(len(line) <= 100 for line in text.splitlines())
    kinds = ("", "law: coulomb", "kind: harmonic")
    shown = [block for block in blocks() if block.kind in kinds and block.path not in ONE_LINE]
    keys = {key.word for block in shown for key in block.keys}
    missing = [
        key
        for key in keys
        if key.count(".") < 2
        and "<" not in key
        and key.partition(".")[0] not in ONE_LINE
        and not re.search(rf"^[# ]*{key.rpartition('.')[2]}:", text, re.M)
    ]
    assert missing == []


def other_faults(text: str) -> list[str]:
    """Return the faults of a scenario but for those of keys that exclude or need others."""
    try:
        scenario(text)
    except ScenarioError as fault:
        sentences = [problem.sentence for problem in fault.problems]
        return [sentence for sentence in sentences if not EXCLUDED.search(sentence)]
    return []


@pytest.mark.parametrize("block", ["start", "solver", "measure"])
def test_a_block_in_comments_is_valid_without_its_marks(block):
    pattern = rf"((?:^# +{block}:.*\n)(?:^#.*\n)+)"
    head, lines, rest = re.split(pattern, skeleton(), flags=re.M)
    opened = re.sub("^# ", "", lines, flags=re.M)
    assert f"\n{opened}".count("\n  ") > 1
    assert other_faults(head + opened + rest) == []


@pytest.mark.parametrize("line", COMMENTED_KEY.findall(skeleton()))
def test_a_key_in_a_comment_is_valid_without_its_mark(line):
    assert other_faults(skeleton().replace(line, line.replace("# ", "", 1))) == []


def test_init_without_a_name_says_what_it_writes(drysim):
    answer = drysim("init")
    assert answer.code == 0
    assert answer.out == f"{commands.DEFAULT_SCENARIO}.yaml\n"
    assert f"writing {commands.DEFAULT_SCENARIO} of the gallery" in answer.err
    assert f"shows all {len(gallery.list_scenarios())}" in " ".join(answer.err.split())


@pytest.mark.parametrize("words", [("--list", "--new"), ("--list", "--from", "r.csv")])
def test_options_of_init_exclude_each_other(drysim, words):
    answer = drysim("init", *words)
    assert answer.code == 2
    options = " and ".join(words[:2])
    assert f"{options} cannot be combined" in answer.err
    assert not [*Path().iterdir()]
