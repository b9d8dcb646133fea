"""Validate: what `run` would say about a file before it computes."""

from __future__ import annotations

from collections.abc import Sequence

from drysim.errors import Problem, RecordError, ScenarioError, UsageError
from drysim.excitation.recorded import Record
from drysim.scenario.load import load
from drysim.study.case import prepare
from drysim.wording import clean_up, excitation


def examine(file: str, overrides: Sequence[str] = ()) -> tuple[Problem, ...]:
    """Give the problems of a file, changed by `KEY=VALUE` words.

    Those of severity `error` are the ones for which `run` would compute nothing.
    """
    try:
        case = prepare(load(file, overrides))
    except ScenarioError as fault:
        return fault.problems
    except RecordError as fault:
        return (fault.problem,)
    except UsageError as fault:
        return (Problem(str(fault), file),)
    told = clean_up(case.motion, case.law)
    if isinstance(case.scenario.excitation, Record):
        told.append(f"base: {excitation(case.scenario.excitation, case.motion)}")
    notes = [Problem(words, file, severity="note") for words in told]
    warned = [Problem(known.sentence, file, severity="warning") for known in case.cautions]
    return (*notes, *warned)
