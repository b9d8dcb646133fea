"""All problems of a scenario file, found without computing: `drysim validate`."""

from __future__ import annotations

from collections.abc import Sequence

from drysim.errors import Problem, RecordError, ScenarioError, UsageError
from drysim.excitation.recorded import Record
from drysim.scenario.load import load
from drysim.scenario.model import Scenario
from drysim.study.preparation import prepare, without_fit_checks
from drysim.wording import describe_clean_up


def find_problems(file: str, overrides: Sequence[str] = ()) -> tuple[Problem, ...]:
    """Return all problems of a scenario file with `KEY=VALUE` overrides.

    Problems of severity `error` are those for which `run`, or `fit` where values are to be
    fitted, refuses to compute.
    """
    try:
        notes, warned = describe_scenario(load(file, overrides))
    except ScenarioError as fault:
        return fault.problems
    except RecordError as fault:
        return (fault.problem,)
    except UsageError as fault:
        return (Problem(str(fault), file),)
    return (
        *(Problem(words, file, severity="note") for words in notes),
        *(Problem(words, file, severity="warning") for words in dict.fromkeys(warned)),
    )


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
        found = model.measurement
        span = f"{len(found.t)} samples over {float(found.t[-1] - found.t[0]):.6g} s"
        notes.append(f"measured: {', '.join(found.channels)}, {span}")
        warned += [known.sentence for known in found.warnings]
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
    warned += [known.sentence for case in cases for known in case.warnings]
    return notes, warned
