"""All problems of a scenario, found without computing: `drysim validate`."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike

from drysim.errors import Problem, RecordError, ScenarioError, UsageError
from drysim.excitation.recorded import Record
from drysim.scenario.load import NO_FILE, load
from drysim.scenario.load import scenario as make_scenario
from drysim.scenario.model import Scenario
from drysim.scenario.text import describe_clean_up
from drysim.study.preparation import prepare, without_fit_checks
from drysim.yaml_document import Overrides


def validate(
    source: str | PathLike[str] | Mapping[str, object] | Scenario, overrides: Overrides = ()
) -> tuple[Problem, ...]:
    """Return all problems of a scenario, without computing.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        A scenario file, the keys of one as nested mappings, or a scenario that was loaded.
    overrides : mapping or sequence of str
        As in `load`; none for a scenario that was loaded.

    Returns
    -------
    tuple of Problem
        Each with its `.sentence`, its place (`.file`, `.line`, `.column`) and its `.severity`:
        an `error`, for which `run`, or `fit` where values are to be fitted, refuses to compute,
        a `warning` or a `note`. Without errors the scenario runs.

    Raises
    ------
    UsageError
        If `source` or the overrides have another type.
    """
    file = NO_FILE if isinstance(source, Mapping | Scenario) else str(source)
    try:
        scenario = _load(source, overrides)
    except ScenarioError as fault:
        return fault.problems
    try:
        notes, warned = describe_scenario(scenario)
    except ScenarioError as fault:
        return fault.problems
    except RecordError as fault:
        return (fault.problem,)
    except UsageError as fault:
        return (Problem(str(fault), file),)
    return (
        *(Problem(note, file, severity="note") for note in notes),
        *(Problem(sentence, file, severity="warning") for sentence in dict.fromkeys(warned)),
    )


def _load(
    source: str | PathLike[str] | Mapping[str, object] | Scenario, overrides: Overrides
) -> Scenario:
    """Return a scenario, whatever it is given as."""
    if isinstance(source, Scenario):
        if overrides:
            raise UsageError("a scenario that was loaded takes no overrides")
        return source
    if isinstance(source, Mapping):
        return make_scenario(source, overrides)
    return load(source, overrides)


def describe_scenario(scenario: Scenario) -> tuple[list[str], list[str]]:
    """Return what is read and cleaned up, and the warnings about a scenario.

    Raises
    ------
    RecordError, ScenarioError, UsageError
        When the scenario cannot be computed.
    """
    notes, warned = [], []
    if scenario.fit is not None:
        from drysim.study.fit_model import build_model

        model = build_model(scenario)
        model.starts()
        measured = model.measurement
        span = f"{len(measured.t)} samples over {float(measured.t[-1] - measured.t[0]):.6g} s"
        notes.append(f"measured: {', '.join(measured.channels)}, {span}")
        warned += [warning.sentence for warning in measured.warnings]
        scenario = without_fit_checks(scenario)
    cases = []
    if scenario.design is not None:
        from drysim.study.design import prepare_design

        cases.append(prepare_design(scenario))
    if not scenario.missing_values:
        cases.append(prepare(scenario, swept=bool(scenario.sweep), interval=True))
    for case in cases[:1]:  # the conditions of a design have all records
        notes += describe_clean_up(case.motion, case.law, case.records)
        if isinstance(base := case.scenario.excitation, Record):
            varied = [axis.key for axis in case.scenario.sweep]
            notes.append(f"base: {base.describe_cases(case.motion, varied, case.records)}")
    warned += [warning.sentence for case in cases for warning in case.warnings]
    return notes, warned
