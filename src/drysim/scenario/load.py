"""From a file to a Scenario, or to all its problems.

The words of the file are held against the keys of the model, its sweep block against them both;
then the model is validated, and the rules between its blocks are tried.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from drysim.errors import Problem, ScenarioError, UsageError
from drysim.metrics.checks import has_condition
from drysim.scenario.axes import SWEEP_KEY
from drysim.scenario.blocks import MAX_NAME_LENGTH, invalid_name_reason
from drysim.scenario.model import Scenario, first_conflict, key_faults, unsupported_values
from drysim.scenario.reading import (
    DEFAULT_LAW,
    LAW_KEY,
    LAWS,
    MAX_PROBLEMS,
    Reading,
    TooManyProblems,
    get_block,
    validation_faults,
)
from drysim.units import shorten
from drysim.wording import format_count
from drysim.yaml_document import Overrides, UnreadableError, read_document

KIND_KEY = ("excitation", "kind")
"""What asks for a block that is missing: some excitations need a step, some a duration."""


def load(path: str | Path, overrides: Overrides = ()) -> Scenario:
    """Give the scenario of a file.

    Parameters
    ----------
    path : str or Path
        YAML file.
    overrides : mapping or sequence of str
        Values by dotted key, `{"friction.kinetic": 30}`, or words such as
        `"friction.kinetic=30"`, whose value is read as YAML. Behind `sweep.` the rest is one
        key, `"sweep.excitation.rms=[0.5, 1]"`, or leads into one that the file sweeps already,
        `"sweep.excitation.rms.0=0.6"`.

    Returns
    -------
    Scenario
        Checked, every value in SI. A record is not read yet.

    Raises
    ------
    ScenarioError
        With every problem of the file.
    UsageError
        When this is no path, or the overrides are neither a mapping nor words.
    """
    if not isinstance(path, str | PathLike):
        text = shorten(repr(path))
        raise UsageError(f"a scenario is loaded from the path of a file, not from {text}")
    try:
        document = read_document(path, overrides, (SWEEP_KEY,))
    except UnreadableError as fault:
        raise _scenario_error(str(path), [fault.problem]) from None
    model, scenario = _choose_model(document.value), None
    reading = Reading(document, model)
    with suppress(TooManyProblems):
        scenario = _read_scenario(reading, model)
    problems = [*document.problems, *reading.problems]
    if scenario is not None and not problems:
        problems = first_conflict(scenario)
    if scenario is None or problems:
        problems.sort(key=lambda p: (p.file != document.file, p.line, p.column))
        raise _scenario_error(document.file, problems)
    return scenario


def _choose_model(words: Mapping[str, Any]) -> type[Scenario]:
    """Give the model that the words of a file are read as.

    A key that the law of the file has not got is an option of another law, or nearly so.
    """
    friction = get_block(words, "friction")
    law = friction.get(LAW_KEY, DEFAULT_LAW)
    if not isinstance(law, str) or law not in LAWS:
        return Scenario
    if friction.keys() <= LAWS[law].model_fields.keys():
        return Scenario
    from drysim.scenario.json_schema import scenario_with_law_options

    return scenario_with_law_options()


def _read_scenario(reading: Reading, model: type[Scenario]) -> Scenario | None:
    """Give the scenario of a document, None where it has problems; they are noted."""
    document, scenario = reading.document, None
    file = Path(document.file)
    words = {"name": _name_from_stem(file.stem)} | reading.read()
    checks = words.get("checks")
    if SWEEP_KEY in words or (isinstance(checks, list) and any(map(has_condition, checks))):
        from drysim.scenario.sweep import read_axes_and_checks

        words |= read_axes_and_checks(reading)
    context = {"folder": file.parent, "document": document}
    try:
        scenario = model.model_validate(words, context=context)
    except ValidationError as fault:
        for keys, sentence in validation_faults(fault, words):
            reading.fault(sentence, keys, instead=KIND_KEY)
    else:
        for keys, sentence in unsupported_values(scenario):
            reading.fault(sentence, keys, at_key=True)
    for keys, sentence in key_faults(words):
        reading.fault(sentence, keys, at_key=True, instead=KIND_KEY)
    return scenario


def _name_from_stem(stem: str) -> str:
    """Give the name of a file as the name of a scenario."""
    name = re.sub(r"[^\w .-]", "-", stem).strip(" ._-")[:MAX_NAME_LENGTH]
    return "scenario" if invalid_name_reason(name) else name


def _scenario_error(file: str, problems: list[Problem]) -> ScenarioError:
    """Give the error that holds the problems of a file, as many as anybody reads."""
    count = format_count(len(problems), "problem")
    if len(problems) > MAX_PROBLEMS:
        count = f"more than {MAX_PROBLEMS} problems; the first are these"
    shown = tuple(problems[:MAX_PROBLEMS])
    return ScenarioError(f"{file} is not a scenario yet: {count}", shown)
