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
from drysim.metrics.checks import conditional
from drysim.scenario.axes import SWEEP
from drysim.scenario.blocks import LONGEST, unfit
from drysim.scenario.model import Scenario, broken, in_conflict, unused
from drysim.scenario.reading import (
    BY_NAME,
    DEFAULT_LAW,
    LAWS,
    MOST_PROBLEMS,
    Enough,
    Reading,
    block_in,
    sentences,
)
from drysim.units import short
from drysim.wording import several
from drysim.yaml_document import Overrides, Unreadable, read

KIND = ("excitation", "kind")
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
        given = short(repr(path))
        raise UsageError(f"a scenario is loaded from the path of a file, not from {given}")
    try:
        document = read(path, overrides, (SWEEP,))
    except Unreadable as fault:
        raise _error(str(path), [fault.problem]) from None
    model, scenario = _model_for(document.value), None
    reading = Reading(document, model)
    with suppress(Enough):
        scenario = _read(reading, model)
    problems = [*document.problems, *reading.problems]
    if scenario is not None and not problems:
        problems = in_conflict(scenario)
    if scenario is None or problems:
        problems.sort(key=lambda p: (p.file != document.file, p.line, p.column))
        raise _error(document.file, problems)
    return scenario


def _model_for(words: Mapping[str, Any]) -> type[Scenario]:
    """Give the model that the words of a file are read as.

    A key that the law of the file has not got is an option of another law, or nearly so.
    """
    friction = block_in(words, "friction")
    law = friction.get(BY_NAME, DEFAULT_LAW)
    if not isinstance(law, str) or law not in LAWS:
        return Scenario
    if friction.keys() <= LAWS[law].model_fields.keys():
        return Scenario
    from drysim.scenario.json_schema import with_options

    return with_options()


def _read(reading: Reading, model: type[Scenario]) -> Scenario | None:
    """Give the scenario of a document, None where it has problems; they are noted."""
    document, scenario = reading.document, None
    file = Path(document.file)
    words = {"name": _name(file.stem)} | reading.read()
    checks = words.get("checks")
    if SWEEP in words or (isinstance(checks, list) and any(map(conditional, checks))):
        from drysim.scenario.sweep import with_axes

        words |= with_axes(reading)
    context = {"folder": file.parent, "document": document}
    try:
        scenario = model.model_validate(words, context=context)
    except ValidationError as fault:
        for keys, sentence in sentences(fault, words):
            reading.fault(sentence, keys, instead=KIND)
    else:
        for keys, sentence in unused(scenario):
            reading.fault(sentence, keys, at_key=True)
    for keys, sentence in broken(words):
        reading.fault(sentence, keys, at_key=True, instead=KIND)
    return scenario


def _name(stem: str) -> str:
    """Give the name of a file as the name of a scenario."""
    name = re.sub(r"[^\w .-]", "-", stem).strip(" ._-")[:LONGEST]
    return "scenario" if unfit(name) else name


def _error(file: str, problems: list[Problem]) -> ScenarioError:
    """Give the error that holds the problems of a file, as many as anybody reads."""
    count = several(len(problems), "problem")
    if len(problems) > MOST_PROBLEMS:
        count = f"more than {MOST_PROBLEMS} problems; the first are these"
    told = tuple(problems[:MOST_PROBLEMS])
    return ScenarioError(f"{file} is not a scenario yet: {count}", told)
