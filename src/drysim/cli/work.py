"""How commands over many cases work: what they would do, where it is computed, how far it is.

A run of many seeds, what a dry run says, and the place where a sweep is computed: threads of
this process, or a cluster.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from drysim import wording
from drysim.cli import process
from drysim.errors import EXIT_INTERRUPTED, UsageError
from drysim.study.statistics import most, until_of
from drysim.wording import clean_up, listed, number, several

if TYPE_CHECKING:
    from drysim.cli.process import Voice
    from drysim.study.case import Case
    from drysim.study.ensemble import Ensemble
    from drysim.study.statistics import Batch, Row
    from drysim.study.store import Store
    from drysim.study.table import Table

    Compute = Callable[[Case, Store, Callable[[Batch], None]], Table]


def run_ensemble(
    case: Case,
    folder: Path,
    command: str,
    voice: Voice,
    *,
    workers: int | None,
    resume: bool,
    strict: bool,
    plots: bool,
) -> int:
    """Compute, write and show the ensemble of a case; give the exit code."""
    from drysim import output
    from drysim.console import many

    with voice.claimed(folder, resume, "seeds") as claim:
        made = solved(case, claim.journal, workers, resume, voice.quiet)
        code = made.exit_code(strict) if made.complete else EXIT_INTERRUPTED
        told = output.write_ensemble(made, claim, plots=plots, command=command, exit_code=code)
    show = partial(many.show_ensemble, made, folder)
    if not made.complete:
        many.show_interrupted(len(made.rows), "seed", folder)
    written = folder if made.complete else claim.partial
    return voice.answer(told, show, made.warnings, written, code)


def solved(case: Case, file: Path, workers: int | None, resume: bool, quiet: bool) -> Ensemble:
    """Give the ensemble of a case; incomplete when it was interrupted on the way."""
    from drysim.console import terminal
    from drysim.study.ensemble import ensemble_of, solve
    from drysim.study.store import Journal, identity

    what = identity(case.scenario) | {"of": "seeds"}
    with Journal(file, what, resume) as journal:
        done = dict(journal.done)
        with terminal.progress(most(case.scenario) - len(done), "seeds", quiet) as advance:

            def finished(number: int, row: Row) -> None:
                journal.add(number, row)
                advance()
                process.if_asked()

            try:
                return solve(case, workers=workers, done=done, finished=finished)
            except KeyboardInterrupt:
                rows = [row for _, row in sorted(journal.done.items())]
                if not rows:
                    raise
                return ensemble_of(case, rows, complete=False)


@contextmanager
def place(
    cluster: str | None,
    workers: int | None,
    voice: Voice,
    certificates: tuple[Path | None, Path | None, Path | None],
) -> Iterator[Compute]:
    """Give the function that computes a sweep where it is wanted, as long as it is there.

    Raises
    ------
    UsageError
        When the words do not go together, or no cluster answers at the address.
    """
    from drysim.study.sweep import solve, solve_far

    if cluster is None:
        if any(certificates):
            raise UsageError(
                "certificates have no meaning without a cluster", "add --cluster tls://..."
            )
        yield lambda case, store, finished: solve(
            case, workers=workers, store=store, finished=finished
        )
        return
    from drysim.console import terminal
    from drysim.study.cluster import LOCAL, Certificates, joined

    if workers is not None and cluster != LOCAL:
        raise UsageError(
            "--workers has no meaning beside the address of a cluster",
            "its workers are as many as were started; --cluster local takes --workers",
        )
    own, warn = Certificates(*certificates), terminal.remark
    with joined(cluster, workers, voice.remark, warn, own) as link:
        yield lambda case, store, finished: solve_far(case, link, store, finished=finished)


def show(case: Case, folder: Path, voice: Voice) -> int:
    """Show what a run would do; everything up to the computation was found in order."""
    seeds = f"{many}, " if (many := many_seeds(case)) else ""
    first, *rest = sentences(case)
    words = [f"{case.scenario.name}: {seeds}{first}", *rest]
    return voice.plan(plan(case, folder), words, case.cautions)


def show_grid(case: Case, folder: Path, words: Sequence[str], voice: Voice) -> int:
    """Show what a sweep or a comparison would do, by some approaches or laws."""
    from drysim.scenario.axes import size

    scenario = case.scenario
    cases = size(scenario.sweep)
    swept = [f"{axis.key}: {len(axis.values)} values" for axis in scenario.sweep]
    each = f", each {many}" if (many := many_seeds(case)) else ""
    what = f"{several(cases, 'case')} by {listed(words)}{each}"
    first = f"{scenario.name}: {what}; {', '.join(swept) or 'no sweep'}"
    fields = plan(case, folder) | {"cases": cases, "sweep": swept, "approaches": len(words)}
    return voice.plan(fields, [first, *sentences(case)[1:]], case.cautions)


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
