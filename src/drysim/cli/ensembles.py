"""A run of many seeds: what `drysim run` does where the scenario asks for them."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from drysim.cli import leave
from drysim.errors import EXIT_INTERRUPTED, UsageError

if TYPE_CHECKING:
    from drysim.cli.voice import Voice
    from drysim.study.case import Case
    from drysim.study.ensembles.ensemble import Ensemble

ONLY = "has a meaning only with many seeds"
HINT = "ask for them by --set excitation.seeds=20, or leave it out"


def refuse_needless(workers: int | None, resume: bool) -> None:
    """Make sure that nobody asks a single seed for what only many can do."""
    if workers is not None:
        raise UsageError(f"--workers {ONLY}: a single run is one thread", HINT)
    if resume:
        raise UsageError(f"--resume {ONLY}: a single run begins anew", HINT)


def run(
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
    from drysim import console, report

    with voice.claimed(folder, resume, "seeds") as claim:
        made = solved(case, claim.journal, workers, resume, voice.quiet)
        code = made.exit_code(strict) if made.complete else EXIT_INTERRUPTED
        told = report.write_ensemble(made, claim, plots=plots, command=command, exit_code=code)
    show = partial(console.show_ensemble, made, folder)
    if not made.complete:
        console.show_interrupted(len(made.rows), "seed", folder)
    written = folder if made.complete else claim.partial
    return voice.answer(told, show, made.warnings, written, code)


def solved(case: Case, file: Path, workers: int | None, resume: bool, quiet: bool) -> Ensemble:
    """Give the ensemble of a case; incomplete when it was interrupted on the way."""
    from drysim import console
    from drysim.study.ensembles.ensemble import ensemble_of, solve
    from drysim.study.ensembles.journal import Journal
    from drysim.study.ensembles.seeds import most
    from drysim.study.identity import identity
    from drysim.study.sweeps.table import Row

    what = identity(case.scenario) | {"of": "seeds"}
    with Journal(file, what, resume) as journal:
        done = dict(journal.done)
        with console.progress(most(case.scenario) - len(done), "seeds", quiet) as advance:

            def finished(number: int, row: Row) -> None:
                journal.add(number, row)
                advance()
                leave.if_asked()

            try:
                return solve(case, workers=workers, done=done, finished=finished)
            except KeyboardInterrupt:
                rows = [row for _, row in sorted(journal.done.items())]
                if not rows:
                    raise
                return ensemble_of(case, rows, complete=False)
