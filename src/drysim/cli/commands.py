"""The nine commands, in the order of the help; each gives its exit code.

A command reads its words, says what it would do or does it, and tells what came out; how that
is done is with `study`, `output` and `console`. These are loaded within: of nine commands one
runs, and `--help` needs none of them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from drysim.cli import options, process
from drysim.cli.process import Voice, reader_may_leave, typed
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_NOTHING_COMPUTED,
    EXIT_NUMERICS_FAILED,
    EXIT_OK,
    Caution,
    OutputError,
    UsageError,
)

if TYPE_CHECKING:
    from drysim.cli.work import Compute
    from drysim.scenario.model import Scenario
    from drysim.study.case import Case
    from drysim.study.doctor import Finding
    from drysim.study.statistics import Batch
    from drysim.study.table import Table

FIRST = "paper-low-friction"
"""What `drysim init` writes when no name is given."""

HERE = "scenario.yaml"
"""What `drysim compare` takes when no scenario is named."""

FALLBACK, FALLBACK_OF_LAWS = "paper-random", "friction-laws"
"""What it takes of the gallery where that is missing; the latter has options of every law."""

TOLD = ("metrics", "ensemble", "checks", "numerics")
"""What of drysim.json is told again; only many seeds are an ensemble."""

RUN_BY_DOCTOR = "free-decay"

PNG_END = b"IEND\xaeB`\x82"
"""Last bytes of a whole PNG file."""


def init(name: options.Name = FIRST, show: options.Show = False) -> int:
    """Write a commented scenario from the gallery."""
    from drysim.console import terminal
    from drysim.study import gallery

    if show:
        return show_gallery(gallery.HARD if name == gallery.HARD else "")
    written = gallery.copy(name, Path())
    with reader_may_leave(Path()):
        terminal.say("\n".join(map(str, written)))
    if loop := gallery.find(name).loop:
        terminal.remark(f"its friction loop: {loop}")
    terminal.remark(f"now: drysim run {written[0]}")
    return EXIT_OK


def show_gallery(part: str) -> int:
    """Show the scenarios of the gallery, or of a part of it, each with what it is about."""
    from drysim.console import terminal
    from drysim.study import gallery

    shown = gallery.pieces(part)
    width = 2 + max(len(piece.name) for piece in shown)
    with reader_may_leave():
        for piece in shown:
            seen = " [loop]" if piece.loop else ""
            terminal.say(f"{piece.name:<{width}}{piece.about}{seen}")
    if any(piece.loop for piece in shown):
        terminal.remark(f"pictures of the loops: {gallery.folder() / gallery.LOOPS}")
    if part != gallery.HARD:
        terminal.remark(f"the hard cases: drysim init --list {gallery.HARD}")
    return EXIT_OK


def run(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.Out = None,
    approach: options.Approach = None,
    workers: options.SeedWorkers = None,
    resume: options.SeedResume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """One case, or one under many seeds: motion, metrics, checks."""
    from drysim.output.folder import check, holds_sweep
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.statistics import most

    voice = Voice(as_json, quiet)
    case = prepare(load(scenario, options.overrides(changes, approach)))
    alone = most(case.scenario) == 1
    if alone:
        refuse_needless(workers, resume)
    folder = out or Path("out", case.scenario.name)
    check(folder)
    if dry_run:
        from drysim.cli import work

        return work.show(case, folder, voice)
    if holds_sweep(folder):
        voice.remark(f"{folder} holds a sweep, which this run replaces; --out keeps it")
    asked = (case, folder, typed(context), voice)
    if alone:
        return run_alone(*asked, strict=strict, plots=not no_plots)
    from drysim.cli import work

    return work.run_ensemble(
        *asked, workers=workers, resume=resume, strict=strict, plots=not no_plots
    )


def refuse_needless(workers: int | None, resume: bool) -> None:
    """Make sure that nobody asks a single seed for what only many can do."""
    only = "has a meaning only with many seeds"
    hint = "ask for them by --set excitation.seeds=20, or leave it out"
    if workers is not None:
        raise UsageError(f"--workers {only}: a single run is one thread", hint)
    if resume:
        raise UsageError(f"--resume {only}: a single run begins anew", hint)


def run_alone(
    case: Case, folder: Path, command: str, voice: Voice, *, strict: bool, plots: bool
) -> int:
    """Compute, write and show the outcome of a case; give the exit code."""
    from drysim import output
    from drysim.console import summaries
    from drysim.output.folder import require_room
    from drysim.study.case import LARGE, LEAST_SHARE, SLOW, response_bytes
    from drysim.study.run import solve

    require_room(folder, LEAST_SHARE * response_bytes(case))
    for caution in case.cautions:
        if caution.slug in (SLOW, LARGE):  # of use before the work, too
            voice.remark(f"patience: {caution.sentence}")
    outcome = solve(case)
    code = outcome.exit_code(strict)
    told = output.write(outcome, folder, plots=plots, command=command, exit_code=code)
    show = partial(summaries.show_outcome, outcome, folder)
    return voice.answer(told, show, outcome.warnings, folder, code)


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
    from drysim.cli.work import place
    from drysim.output.folder import check
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.plan import approaches_of

    voice = Voice(as_json, quiet)
    case = prepare(load(scenario, options.overrides(changes, approach)))
    wanted = approaches_of(case.scenario)
    folder = out or Path("out", case.scenario.name)
    check(folder)
    if form == "parquet":
        from drysim.output.tables import require

        require()
    if dry_run:
        from drysim.cli import work

        return work.show_grid(case, folder, [one.word for one in wanted], voice)
    from drysim import output
    from drysim.console import many, summaries

    command = typed(context)
    with (
        place(cluster, workers, voice, (tls_ca_file, tls_cert, tls_key)) as compute,
        voice.claimed(folder, resume, "cases") as claim,
    ):
        table = swept(case, claim.cases, compute, resume, quiet)
        code = table.exit_code(strict) if table.complete else EXIT_INTERRUPTED
        told = output.write_table(
            table, claim, plots=not no_plots, command=command, exit_code=code, form=form
        )
    show = partial(many.show_table, table, folder)
    if not table.complete:
        many.show_interrupted(len(table.rows), "case", folder)
        show = show if len(table.rows) else partial(summaries.show_warnings, ())
    written = folder if table.complete else claim.partial
    return voice.answer(told, show, table.warnings, written, code)


def swept(case: Case, folder: Path, compute: Compute, resume: bool, quiet: bool) -> Table:
    """Give the table of a sweep; incomplete when it was interrupted on the way."""
    from drysim.console import terminal
    from drysim.study.plan import Pieces, approaches_of
    from drysim.study.store import Store, identity
    from drysim.study.sweep import leftover

    store = Store(folder, identity(case.scenario), resume)
    every = Pieces(approaches_of(case.scenario))
    kept = (piece for piece in (every if resume else ()) if store.holds(piece))
    done = [piece.end - piece.begin for piece in kept]
    cases = sum(every.cases) - sum(done)
    with terminal.progress(cases, "cases", quiet, len(every) - len(done)) as advance:
        try:
            return compute(case, store, partial(finished, advance))
        except KeyboardInterrupt:
            return leftover(case, store)


def finished(advance: Callable[[int], None], batch: Batch) -> None:
    """Tell that a block of cases is finished; an interrupt that was lost on the way ends it."""
    advance(len(batch))
    process.if_asked()


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
    from drysim.output.folder import check
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.compare import named, scenarios_of, solve
    from drysim.study.run import count

    voice, names = Voice(as_json, quiet), named(approaches)
    loaded = load(scenario_or_default(scenario, names, voice), changes or [])
    case = prepare(loaded.compared_by(names[-1]), compared=True)
    wanted = scenarios_of(loaded, names)
    folder = out or Path("out", f"{loaded.name}-compare")
    check(folder)
    if dry_run:
        from drysim.cli import work

        return work.show_grid(case, folder, [*wanted], voice)
    from drysim import output
    from drysim.console import many, terminal

    total = count(list(wanted.values()))
    with terminal.progress(total, "cases", quiet) as advance:
        tell = partial(finished, advance)
        made = solve(loaded, case, names, workers=workers, finished=tell)
    code = made.table.exit_code(strict)
    command = typed(context)
    told = output.write_comparison(
        made, folder, plots=not no_plots, command=command, exit_code=code
    )
    show = partial(many.show_comparison, made, folder)
    return voice.answer(told, show, made.table.warnings, folder, code)


def scenario_or_default(file: str | None, names: Sequence[str], voice: Voice) -> str:
    """Give the scenario to compare: the one named, else ./scenario.yaml, else the gallery's."""
    if file is not None:
        return file
    if Path(HERE).exists():
        return HERE
    from drysim.scenario.reading import LAWS
    from drysim.study import gallery

    name = FALLBACK_OF_LAWS if LAWS.keys() & {*names} else FALLBACK
    voice.remark(f"no {HERE} here: comparing the gallery's {name}")
    return str(gallery.find(name).file)


def validate(
    scenarios: options.Files,
    changes: options.Changes = None,
    form: options.Format = "text",
    strict: options.StrictWarnings = False,
    quiet: options.Quiet = False,
) -> int:
    """Check files, compute nothing."""
    from drysim.console import problems
    from drysim.study.case import examine

    found = {file: examine(file, changes or []) for file in scenarios}
    failing = ("error", "warning") if strict else ("error",)
    faults = {
        file: failed
        for file, problems in found.items()
        if (failed := [problem for problem in problems if problem.severity in failing])
    }
    with reader_may_leave():
        problems.show_problems(faults if quiet and form != "json" else found, form)
    if any(problem.severity == "error" for file in faults.values() for problem in file):
        return EXIT_NOTHING_COMPUTED
    return EXIT_CHECK_FAILED if faults else EXIT_OK


def summarise(folder: options.Folder, as_json: options.Json = False) -> int:
    """Extremes, quantiles and checks of a result on the disk."""
    from drysim.console import summaries

    told = read(folder)
    with reader_may_leave():
        if as_json:
            words = {name: told[name] for name in TOLD if name in told}
            typer.echo(json.dumps(words, indent=2))
        else:
            summaries.show_retold(told)
    return EXIT_OK


def read(folder: Path) -> dict[str, Any]:
    """Give the drysim.json of a result.

    Raises
    ------
    OutputError
        When the folder holds none.
    """
    from drysim.output.folder import MARKER

    file = folder / MARKER
    hint = "name the folder that a run, a sweep or a comparison has written"
    try:
        told = json.loads(file.read_text(encoding="utf-8"))
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise OutputError(f"cannot read {file}: {reason}", hint) from fault
    except ValueError:
        told = None
    needed = {"scenario", "metrics", "checks", "numerics", "command", "complete"}
    if not isinstance(told, dict) or not needed <= told.keys():
        raise OutputError(f"{file} holds no finished result", hint)
    return told


def bench(
    context: typer.Context,
    scenario: options.Asked = None,
    changes: options.Changes = None,
    out: options.Out = None,
    steady: options.Steady = False,
    hard: options.Hard = False,
    repeats: options.Repeats = 15,
    samples: options.Size = 24_000,
    patience: options.Patience = None,
    peers: options.Peers = True,
    dry_run: options.DryRun = False,
    no_plots: options.NoPlots = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Speed against error, beside programs that people know."""
    voice, command = Voice(as_json, quiet), typed(context)
    if steady and hard:
        raise UsageError("--steady and --hard ask for two benches", "ask for one at a time")
    if hard:
        return held(scenario, changes or [], out, patience, dry_run, voice, command)
    from drysim.bench import scipy_ivp, speed_error
    from drysim.bench.timing import Terms
    from drysim.output.folder import check

    terms = Terms(samples, repeats, patience or options.PATIENCE, (scipy_ivp,) if peers else ())
    asked = speed_error.scenarios(scenario, changes or [], steady)
    job = speed_error.settling(asked, terms) if steady else speed_error.marching(asked, terms)
    folder = folder_of(out, scenario, asked, "steady" if steady else "bench")
    check(folder)
    if dry_run:
        return plan_bench(
            job.cases, terms._asdict() | {"peers": peers}, folder, job.cautions, voice
        )
    from drysim import output
    from drysim.console import findings, terminal

    total = sum(case["entries"] for case in job.cases)
    with terminal.progress(total, "entries", quiet) as advance:
        made = job.run(advance)
    told = output.write_bench(
        made, folder, plots=not no_plots, command=command, exit_code=EXIT_OK
    )
    return voice.answer(told, partial(findings.show_bench, made, folder), made.warnings, folder)


def held(
    scenario: str | None,
    changes: Sequence[str],
    out: Path | None,
    patience: float | None,
    dry_run: bool,
    voice: Voice,
    command: str,
) -> int:
    """Put every approach through the hard cases."""
    from drysim.approach import SHELF
    from drysim.bench import hard_cases
    from drysim.output.folder import check

    asked = hard_cases.scenarios(scenario, changes)
    folder = folder_of(out, scenario, asked, "hard")
    check(folder)
    limit = patience or options.HARD_PATIENCE
    if dry_run:
        cases = [{"name": one.name, "entries": len(SHELF)} for one in asked]
        return plan_bench(cases, {"patience": limit}, folder, (), voice)
    from drysim import output
    from drysim.console import findings, terminal

    with terminal.progress(len(asked) * len(SHELF), "trials", voice.quiet) as advance:
        made = hard_cases.run(asked, limit, advance)
    code = made.exit_code()
    told = output.write_hard(made, folder, command=command, exit_code=code)
    return voice.answer(told, partial(findings.show_hard, made, folder), (), folder, code)


def folder_of(
    out: Path | None, scenario: str | None, asked: Sequence[Scenario], word: str
) -> Path:
    """Give the output folder: as it was asked for, or by the scenario's name."""
    if out is not None:
        return out
    return Path("out", word if scenario is None else f"{asked[0].name}-{word}")


def plan_bench(
    cases: Sequence[dict[str, Any]],
    terms: dict[str, Any],
    folder: Path,
    cautions: Sequence[Caution],
    voice: Voice,
) -> int:
    """Show what a bench would do."""
    sentences = [
        f"{case['name']}: {case['entries']} entries"
        + (f" on {case['samples']} samples" if "samples" in case else "")
        for case in cases
    ]
    fields = {"cases": cases, **terms, "folder": folder.as_posix()}
    return voice.plan(fields, sentences, cautions)


def schema() -> int:
    """JSON schema of scenario files, for editors."""
    from drysim.scenario import schema as describe

    with reader_may_leave():
        typer.echo(json.dumps(describe(), indent=2))
    return EXIT_OK


def doctor() -> int:
    """Versions, known answers, a run with its picture; two seconds."""
    from drysim.console import terminal
    from drysim.study.doctor import examine_installation

    findings = [*examine_installation(), end_to_end()]
    with reader_may_leave():
        for finding in findings:
            mark = "ok" if finding.sound else "FAULT"
            terminal.say(f"{mark:<6}{finding.name:<12}{finding.sentence}")
    return EXIT_OK if all(finding.sound for finding in findings) else EXIT_NUMERICS_FAILED


def end_to_end() -> Finding:
    """Run a scenario of the gallery from its file to its picture, in a temporary folder."""
    from tempfile import TemporaryDirectory

    from drysim.study.doctor import Finding

    try:
        from drysim import output
        from drysim.scenario.load import load
        from drysim.study import gallery
        from drysim.study.case import prepare
        from drysim.study.run import solve

        outcome = solve(prepare(load(gallery.find(RUN_BY_DOCTOR).file)))
        with TemporaryDirectory() as folder:
            out = Path(folder, RUN_BY_DOCTOR)
            output.write(outcome, out, plots=True, command="drysim doctor", exit_code=EXIT_OK)
            whole = Path(out, "response.png").read_bytes().endswith(PNG_END)
    except Exception as fault:  # whatever a broken installation raises
        return Finding("run", False, f"{type(fault).__name__}: {fault}")
    sound = whole and outcome.exit_code() == EXIT_OK
    return Finding("run", sound, f"{RUN_BY_DOCTOR} and its picture")
