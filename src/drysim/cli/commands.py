"""The commands, in the order of the help. Each returns its exit code.

A command validates its arguments, then shows the plan (`--dry-run`) or computes, writes and
shows the result; the work is done by `study`, `output` and `console`. These are imported inside
the functions: one command runs, and `--help` needs none of them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from drysim.cli import options
from drysim.cli.process import OutputMode, command_line, tolerate_closed_pipe
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_NOTHING_COMPUTED,
    EXIT_NUMERICS_FAILED,
    EXIT_OK,
    UsageError,
    WarningMessage,
)

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario
    from drysim.study.case import Case
    from drysim.study.doctor import Finding
    from drysim.study.outcome import AnyResult

DEFAULT_SCENARIO = "paper-low-friction"
"""Gallery scenario written by `drysim init` without a name."""

LOCAL_SCENARIO = "scenario.yaml"
"""Scenario of `drysim compare` when none is named."""

FALLBACK_SCENARIO, FALLBACK_FOR_LAWS = "paper-random", "friction-laws"
"""Gallery scenarios used when it is missing; the second has the options of every law."""

SUMMARY_KEYS = ("kind", "summary", "metrics", "ensemble", "checks", "numerics")
"""Keys of drysim.json that `summarise --json` prints; only several seeds have `ensemble`."""

DOCTOR_SCENARIO = "free-decay"
"""Gallery scenario that `drysim doctor` runs."""

PNG_TRAILER = b"IEND\xaeB`\x82"
"""Last bytes of a complete PNG file."""


def init(
    name: options.Name = None, record: options.FromRecord = None, show: options.Show = False
) -> int:
    """Copy a scenario of the gallery, or draft one for a record."""
    from drysim.console import terminal
    from drysim.study import gallery

    if show and record is not None:
        raise UsageError("--list and --from cannot be combined", "use one of them")
    if show:
        return show_gallery(gallery.HARD_FOLDER if name == gallery.HARD_FOLDER else "")
    if record is not None:
        return draft(record, name or "")
    name = name or DEFAULT_SCENARIO
    written = gallery.copy(name, Path())
    with tolerate_closed_pipe(Path()):
        terminal.print_stdout("\n".join(map(str, written)))
    if loop := gallery.find(name).loop:
        terminal.print_stderr(f"friction loop: {loop}")
    command = gallery.find(name).command
    terminal.print_stderr(f"next: drysim {command} {written[0]}")
    return EXIT_OK


def draft(record: str, name: str) -> int:
    """Write a scenario for a measured record, and show what is left to decide and to check."""
    from drysim.console import terminal
    from drysim.study.draft import write_draft

    file, found = write_draft(Path(record), name)
    with tolerate_closed_pipe(Path()):
        terminal.print_stdout(str(file))
    terminal.print_stderr("; ".join(found.layout))
    left = {
        "give values to": [one.key for one in found.proposals if one.value is None],
        "check": [one.key for one in found.proposals if one.value and not one.is_certain],
    }
    steps = [f"{verb} {', '.join(keys)}" for verb, keys in left.items() if keys]
    steps += ["replace the example oscillator and friction", f"drysim validate {file}"]
    terminal.print_stderr(f"next: {'; '.join(steps)}")
    return EXIT_OK


def show_gallery(part: str) -> int:
    """Print the scenarios of the gallery, or of its part, each with its description."""
    from drysim.console import terminal
    from drysim.study import gallery

    shown = gallery.list_scenarios(part)
    width = 2 + max(len(piece.name) for piece in shown)
    with tolerate_closed_pipe():
        for piece in shown:
            seen = " [loop]" if piece.loop else ""
            terminal.print_stdout(f"{piece.name:<{width}}{piece.about}{seen}")
    if any(piece.loop for piece in shown):
        terminal.print_stderr(
            f"pictures of the loops: {gallery.folder() / gallery.LOOPS_FOLDER}"
        )
    if part != gallery.HARD_FOLDER:
        terminal.print_stderr(f"the hard cases: drysim init --list {gallery.HARD_FOLDER}")
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
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Compute one case, for one or many seeds: motion, metrics."""
    from drysim.output.folder import check_writable, holds_sweep, resumable_parts
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.statistics import max_seeds

    mode = OutputMode(as_json, quiet)
    case = prepare(load(scenario, options.overrides(changes, approach)), interval=True)
    single = max_seeds(case.scenario) == 1
    if single:
        check_single_seed_options(workers, resume)
    folder = out or Path("out", case.scenario.name)
    check_writable(folder)
    if dry_run:
        from drysim.cli import work

        return work.show_plan(case, folder, mode)
    if holds_sweep(folder):
        mode.print_status(f"this run replaces the sweep in {folder}; use --out to keep it")
    if single and (held := resumable_parts(folder)):
        kept = f"the finished {' and '.join(held)} in {folder}.partial"
        mode.print_status(f"this run discards {kept}; use --out to keep them")
    how = output_options(context, no_plots, picture_format, report)
    if single and not case.scenario.static_interval:
        return run_single(case, folder, mode, strict, how)
    if case.scenario.static_interval:
        from drysim.study.sweep import solve_interval

        table = solve_interval(case)
        return write_and_show(table, folder, mode, strict, how)
    from drysim.cli import work
    from drysim.study import ensemble
    from drysim.study.plan import seed_ranges

    return work.run_parts(
        "seeds", case, seed_ranges(case), folder, mode, how,
        solve=partial(ensemble.solve, case, workers=workers),
        solve_partly=ensemble.partial_ensemble, resume=resume, strict=strict,
    )  # fmt: skip


def check_single_seed_options(workers: int | None, resume: bool) -> None:
    """Raise UsageError for options that need several seeds."""
    hint = "add --set excitation.seeds=20, or omit the option"
    if workers is not None:
        raise UsageError("--workers needs several seeds: a single run has one worker", hint)
    if resume:
        raise UsageError("--resume needs several seeds: a single run starts over", hint)


def output_options(
    context: typer.Context, no_plots: bool, picture_format: str, report: bool = False
) -> dict[str, Any]:
    """Return the options that all writers of output folders take."""
    return {
        "plots": not no_plots,
        "picture_format": picture_format,
        "command": command_line(context),
        **({"report": True} if report else {}),
    }


def run_single(
    case: Case, folder: Path, mode: OutputMode, strict: bool, how: dict[str, Any]
) -> int:
    """Compute, write and show the result of a case; return the exit code."""
    from drysim.output.folder import check_disk_space
    from drysim.study.case import LARGE_RESPONSE, MIN_BYTES_SHARE, SLOW_SCENE, response_bytes
    from drysim.study.run import solve

    check_disk_space(folder, MIN_BYTES_SHARE * response_bytes(case))
    for warning in case.warnings:
        if warning.slug in (SLOW_SCENE, LARGE_RESPONSE):  # useful before the computation, too
            mode.print_status(f"note: {warning.sentence}")
    return write_and_show(solve(case), folder, mode, strict, how)


def write_and_show(
    result: AnyResult, folder: Path, mode: OutputMode, strict: bool, how: dict[str, Any]
) -> int:
    """Write and show a result; return the exit code.

    `how` are the options of `output.write`.
    """
    from drysim import output

    code = result.exit_code(strict)
    fields = output.write(result, folder, exit_code=code, **how)
    return mode.report(fields, result, folder, code)


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
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
    form: options.Table = "csv",
    cluster: options.Cluster = None,
    tls_ca_file: options.TlsCa = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
) -> int:
    """Compute all cases of the sweep block: transmissibility."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.scenario.axes import count_points
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.plan import CaseRanges, approaches_of

    mode = OutputMode(as_json, quiet)
    changed = options.overrides(changes, approach)
    case = prepare(load(scenario, changed), swept=True, interval=True)
    wanted = approaches_of(case.scenario)
    folder = out or Path("out", case.scenario.name)
    check_writable(folder)
    if form == "parquet":
        from drysim.results.sweep import require_pyarrow

        require_pyarrow()
    if dry_run:
        return work.show_grid_plan(case, folder, [one.label for one in wanted], mode)
    from drysim.results.sweep import transmissibility_text
    from drysim.study.sweep import partial_table, solve, solve_swept_interval

    how = output_options(context, no_plots, picture_format, report) | {"form": form}
    if case.scenario.static_interval:
        if cluster or resume:
            option = "--cluster" if cluster else "--resume"
            hint = "omit the option, or give one value"
            raise UsageError(f"{option} does not apply to an interval of static_ratio", hint)
        with work.progress(count_points(case.scenario.sweep), "cases", quiet) as advance:
            on_batch = partial(work.count_batch, advance)
            table = solve_swept_interval(case, workers=workers, finished=on_batch)
        return write_and_show(table, folder, mode, strict, how)
    certificates = tls_ca_file, tls_cert, tls_key
    with work.case_executor(cluster, workers, mode, certificates) as execute:
        as_text = transmissibility_text(case.scenario) if form == "csv" else None
        return work.run_parts(
            "cases", case, CaseRanges(wanted), folder, mode, how,
            solve=partial(solve, case, execute=execute, as_text=as_text),
            solve_partly=partial_table, resume=resume, strict=strict,
        )  # fmt: skip


def compare(
    context: typer.Context,
    approaches: options.Compared,
    scenario: options.ScenarioOption = None,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Compare approaches or friction laws on one base motion."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.scenario.load import load
    from drysim.study.case import prepare
    from drysim.study.compare import parse_names, scenarios_by_name, solve
    from drysim.study.run import count_cases

    mode, names = OutputMode(as_json, quiet), parse_names(approaches)
    loaded = load(scenario_or_default(scenario, names, mode), changes or [])
    case = prepare(loaded.variant(names[-1]), compared=True, swept=True)
    wanted = scenarios_by_name(loaded, names)
    folder = out or Path("out", f"{loaded.name}-compare")
    check_writable(folder)
    if dry_run:
        return work.show_grid_plan(case, folder, [*wanted], mode)
    total = count_cases(list(wanted.values()))
    with work.progress(total, "cases", quiet) as advance:
        on_batch = partial(work.count_batch, advance)
        result = solve(loaded, case, names, workers=workers, finished=on_batch)
    how = output_options(context, no_plots, picture_format, report)
    return write_and_show(result, folder, mode, strict, how)


def fit(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Fit friction, damping and stiffness to a measured response."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.results.fit import FITTED_FILE
    from drysim.scenario.load import load
    from drysim.study.fit import count_starts, require_fit
    from drysim.study.fit import fit as solve
    from drysim.study.fit_model import build_model

    mode = OutputMode(as_json, quiet)
    loaded = load(scenario, changes or [])
    require_fit(loaded)
    folder = out or Path("out", f"{loaded.name}-fit")
    check_writable(folder)
    if dry_run:
        return work.show_fit_plan(build_model(loaded), folder, mode)
    from drysim.console import terminal

    with work.progress(count_starts(loaded), "starts", quiet) as advance:
        result = solve(loaded, workers=workers, finished=advance)
    how = output_options(context, no_plots, picture_format, report)
    code = write_and_show(result, folder, mode, strict, how)
    if not (as_json or quiet or result.is_useless):
        command = "sweep" if result.scenario.sweep else "run"
        terminal.print_stderr(f"next: drysim {command} {folder / FITTED_FILE}")
    return code


def design(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    resume: options.DesignResume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    as_json: options.Json = False,
    report: options.Report = False,
    quiet: options.Quiet = False,
    cluster: options.Cluster = None,
    tls_ca_file: options.TlsCa = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
) -> int:
    """Find the best values of some keys within limits."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.scenario.load import load
    from drysim.study.design import prepare_design

    mode = OutputMode(as_json, quiet)
    case = prepare_design(load(scenario, changes or []))
    folder = out or Path("out", f"{case.scenario.name}-design")
    check_writable(folder)
    if dry_run:
        return work.show_design_plan(case, folder, mode)
    how = output_options(context, no_plots, picture_format, report)
    certificates = tls_ca_file, tls_cert, tls_key
    with work.case_executor(cluster, workers, mode, certificates) as execute:
        return work.run_design(case, execute, folder, mode, how, resume, strict)


def branches(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.Out = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Follow all periodic motions, stable or not, along a key."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.scenario.load import load
    from drysim.study.branches import prepare_branches, solve

    mode = OutputMode(as_json, quiet)
    case = prepare_branches(load(scenario, changes or []))
    folder = out or Path("out", f"{case.scenario.name}-branches")
    check_writable(folder)
    if dry_run:
        return work.show_grid_plan(case, folder, [case.scenario.label], mode)
    how = output_options(context, no_plots, picture_format, report)
    return write_and_show(solve(case), folder, mode, strict, how)


def regime_map(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.Out = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Map over two keys where the mass locks, stops or slides."""
    from drysim.cli import work
    from drysim.output.folder import check_writable
    from drysim.scenario.load import load
    from drysim.study.regimes import prepare_map, require_map, solve

    mode = OutputMode(as_json, quiet)
    case = prepare_map(load(scenario, changes or []))
    folder = out or Path("out", f"{case.scenario.name}-map")
    check_writable(folder)
    if dry_run:
        return work.show_map_plan(case, folder, mode)
    with work.progress(require_map(case.scenario)[1].nodes, "points", quiet) as advance:
        result = solve(case, workers=workers, advance=advance)
    how = output_options(context, no_plots, picture_format, report)
    return write_and_show(result, folder, mode, strict, how)


regime_map.__name__ = "map"  # the name of the command; in Python it is a built-in function


def scenario_or_default(file: str | None, names: Sequence[str], mode: OutputMode) -> str:
    """Return the scenario to compare: the given file, ./scenario.yaml, or the gallery's."""
    if file is not None:
        return file
    if Path(LOCAL_SCENARIO).exists():
        return LOCAL_SCENARIO
    from drysim.scenario.reading import LAWS
    from drysim.study import gallery

    name = FALLBACK_FOR_LAWS if LAWS.keys() & {*names} else FALLBACK_SCENARIO
    mode.print_status(f"no {LOCAL_SCENARIO} in this folder: using {name} from the gallery")
    return str(gallery.find(name).file)


def validate(
    scenarios: options.Files,
    changes: options.Changes = None,
    form: options.Format = "text",
    strict: options.StrictWarnings = False,
    quiet: options.Quiet = False,
) -> int:
    """Check scenario files without computing."""
    from drysim.console import problems
    from drysim.study.validate import find_problems

    found = {file: find_problems(file, changes or []) for file in scenarios}
    failing = ("error", "warning") if strict else ("error",)
    faults = {
        file: failed
        for file, problems in found.items()
        if (failed := [problem for problem in problems if problem.severity in failing])
    }
    with tolerate_closed_pipe():
        problems.show_problems(faults if quiet and form != "json" else found, form)
    if any(problem.severity == "error" for file in faults.values() for problem in file):
        return EXIT_NOTHING_COMPUTED
    return EXIT_CHECK_FAILED if faults else EXIT_OK


def summarise(folder: options.Folder, as_json: options.Json = False) -> int:
    """Show metrics, quantiles and checks of a finished result."""
    from drysim.cli.stored import show_stored
    from drysim.console import terminal
    from drysim.output.folder import read_sidecar, translate_damage

    fields = read_sidecar(folder)
    with translate_damage(folder):  # a damaged result is found before anything is shown
        show_stored(fields, terminal.PlainConsole(StringIO()))
    with tolerate_closed_pipe():
        if as_json:
            shown = {name: fields[name] for name in SUMMARY_KEYS if name in fields}
            typer.echo(json.dumps(shown, indent=2))
        else:
            show_stored(fields, terminal.stdout())
    return EXIT_OK


def report(
    folder: options.Folder,
    out: options.ReportFile = None,
    no_plots: options.ReportNoPlots = False,
    quiet: options.Quiet = False,
) -> int:
    """Write a report of a finished result: one page of HTML."""
    from drysim.console import terminal
    from drysim.output.folder import REPORT_FILE, add_report, check_report, save_report
    from drysim.output.report import read_result, report_folder
    from drysim.wording import sanitise

    fields, file = read_result(folder), out or folder / REPORT_FILE
    check_report(file, folder)
    page, objections = report_folder(folder, fields, plots=not no_plots)
    if file.absolute() == (folder / REPORT_FILE).absolute():
        add_report(folder, page, fields)
    else:
        save_report(file, page)
    for sentence in objections:
        terminal.print_stderr(f"warning: {sanitise(f'{folder}: {sentence}')}")
    if not quiet:
        with tolerate_closed_pipe():
            terminal.print_stdout(str(file))
    return EXIT_OK


def bench(
    context: typer.Context,
    scenario: options.OptionalFile = None,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    steady: options.Steady = False,
    hard: options.Hard = False,
    repeats: options.Repeats = 15,
    samples: options.Samples = 24_000,
    patience: options.Patience = None,
    peers: options.Peers = True,
    dry_run: options.DryRun = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Measure speed and error of the approaches and of scipy."""
    mode, command = OutputMode(as_json, quiet), command_line(context)
    if steady and hard:
        raise UsageError("--steady and --hard cannot be combined", "use one of them")
    if hard:
        return bench_hard_cases(scenario, changes or [], out, patience, dry_run, mode, command)
    from drysim.bench import scipy_ivp, speed_error
    from drysim.bench.timing import BenchOptions
    from drysim.output.folder import check_writable

    terms = BenchOptions(
        samples, repeats, patience or options.RUN_TIME_LIMIT, (scipy_ivp,) if peers else ()
    )
    requested = speed_error.load_scenarios(scenario, changes or [], steady)
    job = (
        speed_error.steady_state_bench(requested, terms)
        if steady
        else speed_error.time_history_bench(requested, terms)
    )
    folder = output_folder(out, scenario, requested, "steady" if steady else "bench")
    check_writable(folder)
    if dry_run:
        return show_bench_plan(
            job.cases, terms._asdict() | {"peers": peers}, folder, job.warnings, mode
        )
    from drysim.console import terminal

    total = sum(case["entries"] for case in job.cases)
    with terminal.progress(total, "entries", quiet) as advance:
        result = job.run(advance)
    how = output_options(context, no_plots, picture_format)
    return write_and_show(result, folder, mode, False, how)


def bench_hard_cases(
    scenario: str | None,
    changes: Sequence[str],
    out: Path | None,
    patience: float | None,
    dry_run: bool,
    mode: OutputMode,
    command: str,
) -> int:
    """Run every approach on the hard cases."""
    from drysim.approach import APPROACHES_BY_NAME
    from drysim.bench import hard_cases
    from drysim.output.folder import check_writable

    requested = hard_cases.load_scenarios(scenario, changes)
    folder = output_folder(out, scenario, requested, "hard")
    check_writable(folder)
    limit = patience or options.HARD_TIME_LIMIT
    if dry_run:
        cases = [{"name": one.name, "entries": len(APPROACHES_BY_NAME)} for one in requested]
        return show_bench_plan(cases, {"patience": limit}, folder, (), mode)
    from drysim.console import terminal

    with terminal.progress(
        len(requested) * len(APPROACHES_BY_NAME), "runs", mode.quiet
    ) as advance:
        result = hard_cases.run(requested, limit, advance)
    return write_and_show(result, folder, mode, False, {"plots": False, "command": command})


def output_folder(
    out: Path | None, scenario: str | None, requested: Sequence[Scenario], label: str
) -> Path:
    """Return the output folder: `--out`, else named after the scenario."""
    if out is not None:
        return out
    return Path("out", label if scenario is None else f"{requested[0].name}-{label}")


def show_bench_plan(
    cases: Sequence[dict[str, Any]],
    terms: dict[str, Any],
    folder: Path,
    warnings: Sequence[WarningMessage],
    mode: OutputMode,
) -> int:
    """Show what a bench would do."""
    sentences = [
        f"{case['name']}: {case['entries']} entries"
        + (f" on {case['samples']} samples" if "samples" in case else "")
        for case in cases
    ]
    fields = {"cases": cases, **terms, "folder": folder.as_posix()}
    return mode.plan(fields, sentences, warnings)


def schema() -> int:
    """Print the JSON schema of scenario files, for editors."""
    from drysim.scenario import schema as describe

    with tolerate_closed_pipe():
        typer.echo(json.dumps(describe(), indent=2))
    return EXIT_OK


def doctor() -> int:
    """Check the installation: versions, known results, a run."""
    from drysim.console import terminal
    from drysim.study.doctor import check_installation

    findings = [*check_installation(), check_run()]
    with tolerate_closed_pipe():
        for finding in findings:
            mark = "ok" if finding.passed else "FAIL"
            terminal.print_stdout(f"{mark:<6}{finding.name:<13}{finding.sentence}")
    return EXIT_OK if all(finding.passed for finding in findings) else EXIT_NUMERICS_FAILED


def check_run() -> Finding:
    """Run a gallery scenario from its file to its picture, in a temporary folder."""
    from tempfile import TemporaryDirectory

    from drysim.study.doctor import Finding

    try:
        from drysim import output
        from drysim.scenario.load import load
        from drysim.study import gallery
        from drysim.study.case import prepare
        from drysim.study.run import solve

        outcome = solve(prepare(load(gallery.find(DOCTOR_SCENARIO).file)))
        with TemporaryDirectory() as folder:
            out = Path(folder, DOCTOR_SCENARIO)
            output.write(outcome, out, plots=True, command="drysim doctor", exit_code=EXIT_OK)
            whole = Path(out, "response.png").read_bytes().endswith(PNG_TRAILER)
    except Exception as fault:  # a broken installation may raise anything
        return Finding("run", False, f"{type(fault).__name__}: {fault}")
    passed = whole and outcome.exit_code() == EXIT_OK
    return Finding("run", passed, f"{DOCTOR_SCENARIO} and its picture")
