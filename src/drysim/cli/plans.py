"""What a dry run says: what would be done, and where it would be written."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from drysim.cli.streams import reader_may_leave
from drysim.errors import EXIT_OK
from drysim.study.ensembles.seeds import most
from drysim.wording import clean_up, listed, number, several

if TYPE_CHECKING:
    from drysim.study.case import Case


def show(case: Case, folder: Path, as_json: bool, quiet: bool) -> int:
    """Show what a run would do; everything up to the computation was found in order."""
    from drysim import console

    with reader_may_leave():
        if as_json:
            typer.echo(json.dumps(plan(case, folder), indent=2))
        elif not quiet:
            console.say("\n".join(sentences(case, folder)))
        if not quiet:
            console.show_warnings(case.cautions)
    return EXIT_OK


def sentences(case: Case, folder: Path) -> list[str]:
    """Give the plan for people."""
    begin, end = case.window
    span = f"{number(begin, 's')} to {number(end, 's')}"
    many = f"{seeds}, " if (seeds := many_seeds(case)) else ""
    over = "one repetition of the periodic orbit" if case.period else span
    return [
        f"{case.scenario.name}: {many}{case.steps} steps of {number(case.step, 's')} by "
        f"{case.approach.approach}, metrics over {over}",
        *(
            f"{case.scenario.excitation.kind}: {step}"
            for step in clean_up(case.motion, case.law)
        ),
        f"would be written to {folder}",
        "dry run: nothing was computed, nothing was written",
    ]


def many_seeds(case: Case) -> str:
    """Give how many seeds there are to be, where there are many."""
    seeds = most(case.scenario)
    up_to = "up to " if getattr(case.scenario.excitation, "until", None) else ""
    return f"{up_to}{seeds} seeds" if seeds > 1 else ""


def plan(case: Case, folder: Path) -> dict[str, object]:
    """Give the plan for scripts."""
    return {
        "dry_run": True,
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


def show_grid(
    case: Case, folder: Path, words: Sequence[str], as_json: bool, quiet: bool
) -> int:
    """Show what a sweep or a comparison would do, by some approaches or laws."""
    from drysim import console
    from drysim.scenario.sweep.axis import size

    scenario = case.scenario
    cases = size(scenario.axes)
    swept = [f"{axis.key}: {len(axis.values)} values" for axis in scenario.axes]
    fields = plan(case, folder) | {"cases": cases, "sweep": swept, "approaches": len(words)}
    with reader_may_leave():
        if as_json:
            typer.echo(json.dumps(fields, indent=2))
        elif not quiet:
            each = f", each {seeds}" if (seeds := many_seeds(case)) else ""
            what = f"{several(cases, 'case')} by {listed(words)}{each}"
            console.say(f"{scenario.name}: {what}; {', '.join(swept) or 'no sweep'}")
            console.say("\n".join(sentences(case, folder)[1:]))
        if not quiet:
            console.show_warnings(case.cautions)
    return EXIT_OK
