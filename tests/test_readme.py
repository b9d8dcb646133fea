"""README.md: nothing in it goes stale, and what it names is there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import proof
import pytest
import readme
from readme import CONSOLE, MADE, PART, PYTHON, README, made

import drysim
from drysim import errors
from drysim.cli import main

ROOT = Path(__file__).parents[1]
BLOCKS = CONSOLE.findall(README)
PROGRAMS = [(program, told) for _, program, told in PYTHON.findall(README)]

ROUNDING = (
    (r"\d+\.\d+\.\d+", "version"),
    (r"(?<=  energy {6})0 +", "tiny "),
    (r"\d+(?:\.\d+)?e-\d+ *", "tiny "),
    (r"\d+\.\d+", lambda number: f"{float(number[0]):.9g}"),
)
"""What may differ between machines: versions, residuals (0 with luck), and digits behind the
ninth."""


def rounded(text):
    """Give lines without what may differ between machines."""
    for pattern, instead in ROUNDING:
        text = re.sub(pattern, instead, text)
    return text.splitlines()


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    """Follow the README in a process of its own, which starts as a user's does."""
    folder = tmp_path_factory.mktemp("readme")
    command = [sys.executable, readme.__file__, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return SimpleNamespace(folder=folder, **json.loads(done.stdout))


@pytest.mark.parametrize("name", MADE)
def test_table_is_that_of_today(name):
    parts = {name: part for _, name, part in PART.findall(README)}
    assert parts[name] == made(name), "`make readme` writes it anew"


@pytest.mark.parametrize("at", range(len(BLOCKS)), ids=[b.splitlines()[0] for b in BLOCKS])
def test_console_block_is_what_the_commands_print_today(walk, at):
    assert rounded(BLOCKS[at]) == rounded(walk.screens[at])


def test_table_of_speed_and_error_has_the_shape_of_a_measured_one():
    _, _, *lines = proof.PART.search(README)[2].splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines]
    known = [" ".join(filter(None, entry)) for entry in proof.ENTRIES]
    assert [name for name, *_ in rows] == known
    cells = [cell for _, *cells in rows for cell in cells]
    assert len(cells) == len(known) * len(proof.WORKS)
    assert [
        cell for cell in cells if cell != proof.NONE and not proof.CELL.fullmatch(cell)
    ] == []
    assert all(float(cell.rpartition(", ")[2]) < 1e-9 for cell in rows[0][1:])


def test_commands_behind_the_table_of_speed_and_error_are_named_and_known():
    for words in proof.COMMANDS.values():
        kept = [word for word in words if word not in ("--quiet", "--no-plots")]
        assert f"`drysim {' '.join(kept[: kept.index('--out')])}`" in README
        assert main([*words, "--dry-run"]) == 0


def test_python_example_prints_what_stands_below_it(walk):
    assert PROGRAMS
    for (_, told), heard in zip(PROGRAMS, walk.printed, strict=True):
        assert rounded(told) == rounded(heard)


def test_every_file_written_and_every_column_in_it_is_named(walk):
    written = [file for file in walk.folder.glob("out/*/*") if file.is_file()]
    names = {file.name for file in written}
    for file in written:
        if file.suffix == ".csv":
            names |= set(file.read_text().splitlines()[0].split(","))
    assert "t [s]" in names
    swept = {name for name in names if re.match(r"\w+\.\w+ \[", name)}
    assert [name for name in sorted(names - swept) if f"`{name}`" not in README] == []


def test_links_lead_somewhere():
    heads = re.findall(r"^#+ (.*)$", README, re.M)
    anchors = {"#" + re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
    links = re.findall(r"\]\((?!https?:)([^)]*)\)", README)
    assert links
    assert [to for to in links if to not in anchors and not (ROOT / to).is_file()] == []


def test_every_public_name_exit_code_and_scenario_is_named():
    codes = {str(value) for name, value in vars(errors).items() if name.startswith("EXIT_")}
    gallery = {file.stem for file in (ROOT / "scenarios").glob("*.yaml")}
    for words in (codes, gallery, {f"drysim.{name}" for name in drysim.__all__}):
        assert words
        assert [word for word in sorted(words) if f"`{word}`" not in README] == []


def test_every_make_target_named_is_there():
    named = set(re.findall(r"\bmake (?:\w+=\S+ )?([a-z]+)\b", README))
    there = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M))
    assert "demo" in named
    assert named <= there
