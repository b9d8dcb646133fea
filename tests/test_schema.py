"""The JSON schema of scenario files: derived from the models, never kept twice."""

from __future__ import annotations

import json
from pathlib import Path
from typing import get_args

import pytest

from drysim.approach import SHELF
from drysim.excitation import EXCITATIONS
from drysim.friction import FRICTIONS
from drysim.scenario import schema


@pytest.fixture(scope="module")
def words():
    return schema()


def blocks(words):
    """Give every block of a scenario by name."""
    return {"Scenario": words, **words["$defs"]}


def test_schema_names_its_dialect_and_what_is_required(words):
    assert words["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert words["required"] == ["oscillator", "excitation"]
    assert words["properties"]["drysim"]["const"] == 1


def test_no_block_takes_unknown_keys(words):
    assert all(block["additionalProperties"] is False for block in blocks(words).values())


def test_every_key_is_described_here_or_where_it_refers_to(words):
    for name, block in blocks(words).items():
        for key, field in block["properties"].items():
            target = words["$defs"].get(field.get("$ref", "").rpartition("/")[2], {})
            assert field.get("description") or target.get("description"), f"{name}.{key}"


def test_every_member_of_every_shelf_is_in_it(words):
    kinds = {get_args(member.model_fields["kind"].annotation)[0] for member in EXCITATIONS}
    assert set(words["properties"]["excitation"]["discriminator"]["mapping"]) == kinds
    assert {member.__name__ for member in FRICTIONS} <= words["$defs"].keys()
    assert words["$defs"]["Solver"]["properties"]["approach"]["enum"] == list(SHELF)


def test_alternatives_exclude_each_other(words):
    either = [{"required": ["damping"]}, {"required": ["damping_ratio"]}]
    assert words["$defs"]["Oscillator"]["allOf"] == [{"oneOf": either}]


def test_nothing_may_be_null(words):
    assert "null" not in str(words)


def test_bounds_of_numbers_are_kept(words):
    number, text = words["$defs"]["Oscillator"]["properties"]["mass"]["anyOf"]
    assert number == {"type": "number", "exclusiveMinimum": 0}
    assert text["type"] == "string"


def test_schema_can_be_asked_for_twice(words):
    assert schema() == words


def test_schema_beside_the_gallery_is_this_one(words):
    file = Path(__file__).parents[1] / "scenarios" / "scenario.schema.json"
    assert json.loads(file.read_text(encoding="utf-8")) == words, "make schema writes it anew"
