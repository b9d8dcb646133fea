"""What a dry run says: what would be done, and where it would be written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.study.ensembles.seeds import most, until_of
from drysim.wording import clean_up, listed, number, several

if TYPE_CHECKING:
    from drysim.cli.voice import Voice
    from drysim.study.case import Case


def show(case: Case, folder: Path, voice: Voice) -> int:
    """Show what a run would do; everything up to the computation was found in order."""
    seeds = f"{many}, " if (many := many_seeds(case)) else ""
    first, *rest = sentences(case)
    words = [f"{case.scenario.name}: {seeds}{first}", *rest]
    return voice.plan(plan(case, folder), words, case.cautions)


def show_grid(case: Case, folder: Path, words: Sequence[str], voice: Voice) -> int:
    """Show what a sweep or a comparison would do, by some approaches or laws."""
    from drysim.scenario.sweep.axis import size

    scenario = case.scenario
    cases = size(scenario.sweep)
    swept = [f"{axis.key}: {len(axis.values)} values" for axis in scenario.sweep]
    each = f", each {many}" if (many := many_seeds(case)) else ""
    what = f"{several(cases, 'case')} by {listed(words)}{each}"
    first = f"{scenario.name}: {what}; {', '.join(swept) or 'no sweep'}"
    fields = plan(case, folder) | {"cases": cases, "sweep": swept, "approaches": len(words)}
    return voice.plan(fields, [first, *sentences(case)[1:]], case.cautions)


def sentences(case: Case) -> list[str]:
    """Give the plan for people: the march, and what is done to a record before it."""
    begin, end = case.window
    span = f"{number(begin, 's')} to {number(end, 's')}"
    over = "one repetition of the periodic orbit" if case.period else span
    kind, steps = case.scenario.excitation.kind, clean_up(case.motion, case.law)
    return [
        f"{case.steps} steps of {number(case.step, 's')} by {case.approach.approach}, metrics "
        f"over {over}",
        f"base: {base(case)}",
        *(f"{kind}: {step}" for step in steps),
    ]


def base(case: Case) -> str:
    """Give the base motion; the RMS of a record tells whether its unit is right."""
    excitation, varied = case.scenario.excitation, [axis.key for axis in case.scenario.sweep]
    if any(key.startswith("excitation.") for key in varied):
        return wording.excitations(excitation, varied)
    return wording.excitation(excitation, case.motion)


def many_seeds(case: Case) -> str:
    """Give how many seeds there are to be, where there are many."""
    seeds = most(case.scenario)
    up_to = "up to " if until_of(case.scenario) else ""
    return f"{up_to}{seeds} seeds" if seeds > 1 else ""


def plan(case: Case, folder: Path) -> dict[str, object]:
    """Give the plan for scripts."""
    return {
        "name": case.scenario.name,
        "approach": case.approach.approach,
        "step": case.step,
        "steps": case.steps,
        "seeds": most(case.scenario),
        "window": list(case.window),
        "steady": case.period is not None,
        "clean_up": clean_up(case.motion, case.law),
        "folder": folder.as_posix(),
        "warnings": [caution.sentence for caution in case.cautions],
    }
