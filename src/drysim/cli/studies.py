"""The commands over many cases: sweep and compare."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from drysim.cli import leave, options
from drysim.cli.voice import Voice, typed
from drysim.errors import EXIT_INTERRUPTED

HERE = "scenario.yaml"
"""What `drysim compare` takes when no scenario is named."""

FALLBACK, FALLBACK_OF_LAWS = "paper-random", "friction-laws"
"""What it takes of the gallery where that is missing; the latter has options of every law."""

if TYPE_CHECKING:
    from drysim.cli.places import Compute
    from drysim.study.case import Case
    from drysim.study.sweeps.batch import Batch
    from drysim.study.sweeps.table import Table


def sweep(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.Out = None,
    approach: options.Approach = None,
    workers: options.Workers = None,
    resume: options.Resume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
    form: options.Table = "csv",
    cluster: options.Cluster = None,
    tls_ca_file: options.TlsCa = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
) -> int:
    """Every case of the sweep block: transmissibility."""
    from drysim.cli.places import place
    from drysim.report.claim import check
    from drysim.scenario import load
    from drysim.study.case import prepare
    from drysim.study.sweeps.sweep import approaches_of

    voice = Voice(as_json, quiet)
    case = prepare(load(scenario, options.overrides(changes, approach)))
    wanted = approaches_of(case.scenario)
    folder = out or Path("out", case.scenario.name)
    check(folder)
    if form == "parquet":
        from drysim.report.parquet import require

        require()
    if dry_run:
        from drysim.cli import plans

        return plans.show_grid(case, folder, [one.word for one in wanted], voice)
    from drysim import console, report

    command = typed(context)
    with (
        place(cluster, workers, voice, (tls_ca_file, tls_cert, tls_key)) as compute,
        voice.claimed(folder, resume, "cases") as claim,
    ):
        table = swept(case, claim.cases, compute, resume, quiet)
        code = table.exit_code(strict) if table.complete else EXIT_INTERRUPTED
        told = report.write_table(
            table, claim, plots=not no_plots, command=command, exit_code=code, form=form
        )
    show = partial(console.show_table, table, folder)
    if not table.complete:
        console.show_interrupted(len(table.rows), "case", folder)
        show = show if len(table.rows) else partial(console.show_warnings, ())
    written = folder if table.complete else claim.partial
    return voice.answer(told, show, table.warnings, written, code)


def swept(case: Case, folder: Path, compute: Compute, resume: bool, quiet: bool) -> Table:
    """Give the table of a sweep; incomplete when it was interrupted on the way."""
    from drysim import console
    from drysim.study.identity import identity
    from drysim.study.sweeps.plan import Pieces
    from drysim.study.sweeps.store import Store
    from drysim.study.sweeps.sweep import approaches_of, leftover

    store = Store(folder, identity(case.scenario), resume)
    every = Pieces(approaches_of(case.scenario))
    kept = (piece for piece in (every if resume else ()) if store.holds(piece))
    done = [piece.end - piece.begin for piece in kept]
    cases = sum(every.cases) - sum(done)
    with console.progress(cases, "cases", quiet, len(every) - len(done)) as advance:
        try:
            return compute(case, store, partial(finished, advance))
        except KeyboardInterrupt:
            return leftover(case, store)


def finished(advance: Callable[[int], None], batch: Batch) -> None:
    """Tell that a block of cases is finished; an interrupt that was lost on the way ends it."""
    advance(len(batch))
    leave.if_asked()


def compare(
    context: typer.Context,
    approaches: options.Compared,
    scenario: options.ScenarioFile = None,
    changes: options.Changes = None,
    out: options.Out = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Approaches or friction laws on one base motion; a verdict."""
    from drysim.report.claim import check
    from drysim.scenario import load
    from drysim.study.case import prepare
    from drysim.study.comparisons.compare import named, scenarios_of, solve
    from drysim.study.sweeps.cases import count

    voice, names = Voice(as_json, quiet), named(approaches)
    loaded = load(scenario_or_default(scenario, names, voice), changes or [])
    case = prepare(loaded.compared_by(names[-1]), compared=True)
    wanted = scenarios_of(loaded, names)
    folder = out or Path("out", f"{loaded.name}-compare")
    check(folder)
    if dry_run:
        from drysim.cli import plans

        return plans.show_grid(case, folder, [*wanted], voice)
    from drysim import console, report

    total = count(list(wanted.values()))
    with console.progress(total, "cases", quiet) as advance:
        tell = partial(finished, advance)
        made = solve(loaded, case, names, workers=workers, finished=tell)
    code = made.table.exit_code(strict)
    command = typed(context)
    told = report.write_comparison(
        made, folder, plots=not no_plots, command=command, exit_code=code
    )
    show = partial(console.show_comparison, made, folder)
    return voice.answer(told, show, made.table.warnings, folder, code)


def scenario_or_default(file: str | None, names: Sequence[str], voice: Voice) -> str:
    """Give the scenario to compare: the one named, else ./scenario.yaml, else the gallery's."""
    if file is not None:
        return file
    if Path(HERE).exists():
        return HERE
    from drysim.scenario.laws import LAWS
    from drysim.study import gallery

    name = FALLBACK_OF_LAWS if LAWS.keys() & {*names} else FALLBACK
    voice.remark(f"no {HERE} here: comparing the gallery's {name}")
    return str(gallery.find(name).file)
