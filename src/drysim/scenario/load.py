"""Load a scenario from a file, a mapping or text, or report all its errors.

1. The document is read, and its keys are compared with those of the models.
2. The sweep block is read; its values follow the rules of the swept keys.
3. The model is validated.
4. Rules between blocks are checked.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from os import PathLike
from pathlib import Path
from shlex import quote
from typing import Any

from pydantic import ValidationError

from drysim.errors import Problem, ScenarioError, UsageError
from drysim.messages import shorten
from drysim.metrics.checks import has_condition
from drysim.scenario.assess import with_missing_blocks
from drysim.scenario.axes import SWEEP_KEY
from drysim.scenario.blocks import MAX_NAME_LENGTH, invalid_name_reason
from drysim.scenario.design import DESIGN_KEY, OVER_PATH, VARY_PATH
from drysim.scenario.fit import FIT_KEY, FREE_PATH, read_free, with_placeholders
from drysim.scenario.keys import fields_by_key, get_block
from drysim.scenario.laws import DEFAULT_LAW, LAW_KEY, LAWS
from drysim.scenario.model import Scenario, first_conflict, unsupported_values
from drysim.scenario.reading import MAX_PROBLEMS, Reading, TooManyProblems
from drysim.scenario.rules import key_faults
from drysim.scenario.validation import validation_faults
from drysim.wording import format_count
from drysim.yaml_document import (
    Document,
    Overrides,
    UnreadableError,
    document_of,
    read_document,
)

KIND_KEY = ("excitation", "kind")
"""Key shown in place of a missing block that the kind of excitation requires."""

DOTTED_BLOCKS = (SWEEP_KEY, FREE_PATH, VARY_PATH, OVER_PATH)
"""Blocks whose keys contain dots."""

NO_FILE = "<scenario>"
"""Name of a scenario without a file in messages."""


def load(path: str | PathLike[str], overrides: Overrides = ()) -> Scenario:
    """Load a scenario from a YAML file.

    Parameters
    ----------
    path : str or Path
        YAML file.
    overrides : mapping or sequence of str
        Values by dotted key, `{"friction.kinetic": 30}`, or strings such as
        `"friction.kinetic=30"`, whose value is read as YAML. After `sweep.` the rest is a
        single key, `"sweep.excitation.rms=[0.5, 1]"`, or the path to a value of a swept key,
        `"sweep.excitation.rms.0=0.6"`.

    Returns
    -------
    Scenario
        Validated, with all values in SI. Records are not read yet.

    Raises
    ------
    ScenarioError
        With every error of the file.
    UsageError
        If `path` is not a path, or the overrides are neither a mapping nor strings.
    """
    if not isinstance(path, str | PathLike):
        text = shorten(repr(path))
        raise UsageError(f"the scenario must be given as the path of a file, not as {text}")
    try:
        document = read_document(path, overrides, DOTTED_BLOCKS)
    except UnreadableError as fault:
        raise _scenario_error(str(path), [_with_record_hint(fault.problem)]) from None
    return validated(document)


def scenario(source: Mapping[str, object] | str, overrides: Overrides = ()) -> Scenario:
    """Make a scenario from a mapping, or from YAML text.

    Parameters
    ----------
    source : mapping or str
        The keys of a scenario file as nested mappings, or the text of such a file. Paths of
        records are relative to the working directory.
    overrides : mapping or sequence of str
        As in `load`.

    Returns
    -------
    Scenario
        As `load` returns it.

    Raises
    ------
    ScenarioError
        With every error, at its place in the text; that of a mapping is its YAML.
    UsageError
        If `source` is neither a mapping nor text, or is the name of a file.
    """
    if not isinstance(source, Mapping | str):
        text = shorten(repr(source))
        raise UsageError(
            f"the scenario must be given as a mapping or as YAML text, not as {text}",
            "drysim.load reads a file",
        )
    if isinstance(source, str) and Path(source).suffix in (".yaml", ".yml"):
        raise UsageError(f"{shorten(source)} is the name of a file", "drysim.load reads a file")
    try:
        document = document_of(source, NO_FILE, overrides, DOTTED_BLOCKS)
    except UnreadableError as fault:
        raise _scenario_error(NO_FILE, [fault.problem]) from None
    return validated(document)


def validated(document: Document) -> Scenario:
    """Return the scenario of a document, or raise `ScenarioError` with all its errors."""
    filled = with_missing_blocks(with_placeholders(document.value))
    model, scenario = _choose_model(filled), None
    reading = Reading(document, model)
    with suppress(TooManyProblems):
        scenario = _read_scenario(reading, model, filled)
    problems = [*document.problems, *reading.problems]
    if scenario is not None and not problems:
        problems = first_conflict(scenario)
    if scenario is None or problems:
        problems.sort(key=lambda p: (p.file != document.file, p.line, p.column))
        if not document.value.keys() & fields_by_key(model).keys():
            problems[0] = _with_record_hint(problems[0])
        raise _scenario_error(document.file, problems)
    return scenario


def _with_record_hint(problem: Problem) -> Problem:
    """Return a problem with how to make a scenario, if the file may be a record."""
    from drysim.records.formats import format_of

    file = Path(problem.file)
    if format_of(file) is None or not file.is_file():
        return problem
    mark = "" if problem.sentence.endswith("?") else ";"
    hint = f"`drysim init --from {quote(problem.file)}` writes a scenario for a record"
    return replace(problem, sentence=f"{problem.sentence}{mark} {hint}")


def _choose_model(document: Mapping[str, Any]) -> type[Scenario]:
    """Return the model for a file.

    A key unknown to the law of the file may be the options block of another law.
    """
    friction = get_block(document, "friction")
    law = friction.get(LAW_KEY, DEFAULT_LAW)
    if not isinstance(law, str) or law not in LAWS:
        return Scenario
    if friction.keys() <= LAWS[law].model_fields.keys():
        return Scenario
    from drysim.scenario.json_schema import scenario_with_law_options

    return scenario_with_law_options()


def _read_scenario(
    reading: Reading, model: type[Scenario], filled: Mapping[str, Any]
) -> Scenario | None:
    """Return the scenario of a document, completed where fit or assessment need no values.

    None after noting its errors.
    """
    document, scenario = reading.document, None
    file = Path(document.file)
    values = {"name": _name_from_stem(file.stem)} | reading.read(filled)
    if isinstance(values.get(FIT_KEY), dict):
        values[FIT_KEY] = values[FIT_KEY] | {"free": read_free(reading)}
    checks = values.get("checks")
    if SWEEP_KEY in values or (isinstance(checks, list) and any(map(has_condition, checks))):
        from drysim.scenario.sweep import read_axes_and_checks

        values |= read_axes_and_checks(reading)
    if isinstance(values.get(DESIGN_KEY), dict):
        from drysim.scenario.sweep import read_design

        values[DESIGN_KEY] = values[DESIGN_KEY] | read_design(reading)
    context = {"folder": file.parent, "document": document}
    try:
        scenario = model.model_validate(values, context=context)
    except ValidationError as fault:
        for keys, sentence in validation_faults(fault, values):
            hint = "" if sentence.endswith("?") else reading.other_key_hint(keys)
            reading.fault(sentence + hint, keys, instead=KIND_KEY)
    else:
        for keys, sentence in unsupported_values(scenario):
            reading.fault(sentence, keys, at_key=True)
    proposal = None
    if scenario is not None and not (reading.problems or document.problems):
        proposal = scenario.proposed_step
    for keys, sentence in key_faults(values, proposal):
        reading.fault(sentence, keys, at_key=True, instead=KIND_KEY)
    return scenario


def _name_from_stem(stem: str) -> str:
    """Return a valid scenario name from the stem of a file name."""
    name = re.sub(r"[^\w .-]", "-", stem).strip(" ._-")[:MAX_NAME_LENGTH]
    return "scenario" if invalid_name_reason(name) else name


def _scenario_error(file: str, problems: list[Problem]) -> ScenarioError:
    """Return the exception for the errors of a file."""
    count = format_count(len(problems), "error")
    if len(problems) > MAX_PROBLEMS:
        count = f"more than {MAX_PROBLEMS} errors; the first {MAX_PROBLEMS} are shown"
    shown = tuple(problems[:MAX_PROBLEMS])
    return ScenarioError(f"{file}: {count}", shown)
