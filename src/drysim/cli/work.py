"""Computation of ensembles and sweeps for the commands, and dry runs.

A sweep is computed by threads of this process or on a Dask cluster.
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
from drysim.study.statistics import max_seeds, stopping_rule
from drysim.wording import describe_clean_up, format_count, format_number, join_words

if TYPE_CHECKING:
    from drysim.cli.process import OutputMode
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
    mode: OutputMode,
    *,
    workers: int | None,
    resume: bool,
    strict: bool,
    plots: bool,
) -> int:
    """Compute, write and show the ensemble of a case; return the exit code."""
    from drysim import output
    from drysim.console import many

    with mode.lock(folder, resume, "seeds") as locked:
        result = solve_ensemble(case, locked.journal, workers, resume, mode.quiet)
        code = result.exit_code(strict) if result.complete else EXIT_INTERRUPTED
        fields = output.write_ensemble(
            result, locked, plots=plots, command=command, exit_code=code
        )
    show = partial(many.show_ensemble, result, folder)
    if not result.complete:
        many.show_interrupted(len(result.rows), "seed", folder)
    written = folder if result.complete else locked.partial
    return mode.report(fields, show, result.warnings, written, code)


def solve_ensemble(
    case: Case, file: Path, workers: int | None, resume: bool, quiet: bool
) -> Ensemble:
    """Compute the ensemble of a case; incomplete if interrupted."""
    from drysim.console import terminal
    from drysim.study.ensemble import make_ensemble, solve
    from drysim.study.store import Journal, work_identity

    identity = work_identity(case.scenario) | {"of": "seeds"}
    with Journal(file, identity, resume) as journal:
        done = dict(journal.done)
        with terminal.progress(max_seeds(case.scenario) - len(done), "seeds", quiet) as advance:

            def finished(number: int, row: Row) -> None:
                journal.add(number, row)
                advance()
                process.raise_if_interrupted()

            try:
                return solve(case, workers=workers, done=done, finished=finished)
            except KeyboardInterrupt:
                rows = [row for _, row in sorted(journal.done.items())]
                if not rows:
                    raise
                return make_ensemble(case, rows, complete=False)


@contextmanager
def sweep_executor(
    cluster: str | None,
    workers: int | None,
    mode: OutputMode,
    certificates: tuple[Path | None, Path | None, Path | None],
) -> Iterator[Compute]:
    """Yield the function that computes a sweep, by threads or on a cluster.

    Raises
    ------
    UsageError
        When the options contradict each other, or no cluster answers at the address.
    """
    from drysim.study.sweep import solve, solve_on_cluster

    if cluster is None:
        if any(certificates):
            raise UsageError(
                "the --tls options need a cluster", "add --cluster tls://host:8786"
            )
        yield lambda case, store, finished: solve(
            case, workers=workers, store=store, finished=finished
        )
        return
    from drysim.console import terminal
    from drysim.study.cluster import LOCAL, Certificates, connect

    if workers is not None and cluster != LOCAL:
        raise UsageError(
            "--workers cannot be combined with the address of a cluster",
            "a cluster has the workers that were started; --cluster local takes --workers",
        )
    all_certificates, warn = Certificates(*certificates), terminal.print_stderr
    with connect(cluster, workers, mode.print_status, warn, all_certificates) as client:
        yield lambda case, store, finished: solve_on_cluster(
            case, client, store, finished=finished
        )


def show_plan(case: Case, folder: Path, mode: OutputMode) -> int:
    """Show what a run would do; everything before the computation has been checked."""
    seeds = f"{many}, " if (many := describe_seeds(case)) else ""
    first, *rest = plan_sentences(case)
    words = [f"{case.scenario.name}: {seeds}{first}", *rest]
    return mode.plan(plan_fields(case, folder), words, case.warnings)


def show_grid_plan(case: Case, folder: Path, words: Sequence[str], mode: OutputMode) -> int:
    """Show what a sweep or a comparison would do; `words` names its approaches or laws."""
    from drysim.scenario.axes import count_points

    scenario = case.scenario
    cases = count_points(scenario.sweep)
    swept = [f"{axis.key}: {len(axis.values)} values" for axis in scenario.sweep]
    each = f", each {seeds}" if (seeds := describe_seeds(case)) else ""
    what = f"{format_count(cases, 'case')} by {join_words(words)}{each}"
    first = f"{scenario.name}: {what}; {', '.join(swept) or 'no sweep'}"
    fields = plan_fields(case, folder) | {
        "cases": cases,
        "sweep": swept,
        "approaches": len(words),
    }
    return mode.plan(fields, [first, *plan_sentences(case)[1:]], case.warnings)


def plan_fields(case: Case, folder: Path) -> dict[str, object]:
    """Return the plan as JSON fields."""
    return {
        "name": case.scenario.name,
        "approach": case.approach.approach,
        "step": case.step,
        "steps": case.steps,
        "seeds": max_seeds(case.scenario),
        "window": list(case.window),
        "steady": case.period is not None,
        "clean_up": describe_clean_up(case.motion, case.law),
        "folder": folder.as_posix(),
        "warnings": [warning.sentence for warning in case.warnings],
    }


def plan_sentences(case: Case) -> list[str]:
    """Return the plan as text: time steps and window, base motion, cleaning of a record."""
    begin, end = case.window
    span = f"{format_number(begin, 's')} to {format_number(end, 's')}"
    over = "one repetition of the periodic orbit" if case.period else span
    kind, steps = case.scenario.excitation.kind, describe_clean_up(case.motion, case.law)
    return [
        f"{case.steps} steps of {format_number(case.step, 's')} by {case.approach.approach}, "
        f"metrics over {over}",
        f"base: {describe_base(case)}",
        *(f"{kind}: {step}" for step in steps),
    ]


def describe_base(case: Case) -> str:
    """Describe the base motion; the RMS of a record shows whether its unit is right."""
    excitation, varied = case.scenario.excitation, [axis.key for axis in case.scenario.sweep]
    if any(key.startswith("excitation.") for key in varied):
        return wording.describe_swept_excitation(excitation, varied)
    return wording.describe_excitation(excitation, case.motion)


def describe_seeds(case: Case) -> str:
    """Describe the number of seeds; empty for a single one."""
    seeds = max_seeds(case.scenario)
    up_to = "up to " if stopping_rule(case.scenario) else ""
    return f"{up_to}{seeds} seeds" if seeds > 1 else ""
