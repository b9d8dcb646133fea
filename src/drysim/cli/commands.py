"""The commands, in the order of the help. Each returns its exit code.

A command that computes loads and prepares its scenario and describes its work as a `Job`, which
`job.carry_out` carries out. What the commands need is imported inside the functions: one
command runs, and `--help` needs none of it. Typer makes the options from the signatures, so
some parameters look unused: `Common.of` takes their values from the context.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from drysim.cli import options
from drysim.cli.job import Common, Job, Parts, Work, carry_out, carry_out_each, study_name
from drysim.cli.process import OutputMode, Plan, tolerate_closed_pipe
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_NOTHING_COMPUTED,
    EXIT_NUMERICS_FAILED,
    EXIT_OK,
    DrysimError,
    UsageError,
    WarningMessage,
)

if TYPE_CHECKING:
    from drysim.scenario.axes import Axis
    from drysim.scenario.model import Scenario
    from drysim.study.case import Case
    from drysim.study.design import DesignResult
    from drysim.study.doctor import Finding
    from drysim.study.fit import FitResult

DEFAULT_SCENARIO = "paper-low-friction"
"""Gallery scenario written by `drysim init` without a name."""

LOCAL_SCENARIO = "scenario.yaml"
"""Scenario of `drysim compare` when none is named."""

SCENARIO_PATTERN = re.compile(rb"^oscillator\s*:", re.M)
"""Key that every scenario has, in the bytes of a file."""

FALLBACK_SCENARIO, FALLBACK_FOR_LAWS = "paper-random", "friction-laws"
"""Gallery scenarios used when it is missing; the second has the options of every law."""

MAX_LISTED = 12
"""Values of a condition that the command proposed after a design lists, at most."""

SUMMARY_KEYS = (
    "kind", "summary", "metrics", "units", "ensemble", "checks", "warnings", "numerics"
)  # fmt: skip
"""Keys of drysim.json that `summarise --json` prints; only several seeds have `ensemble`."""

DOCTOR_SCENARIO = "free-decay"
"""Gallery scenario that `drysim doctor` runs."""

PNG_TRAILER = b"IEND\xaeB`\x82"
"""Last bytes of a complete PNG file."""


def init(
    name: options.Name = None,
    new: options.New = False,
    record: options.FromRecord = None,
    show: options.Show = False,
) -> int:
    """Write a scenario: of the gallery, to fill in, or for a record."""
    from drysim.console import terminal
    from drysim.study import gallery

    chosen = {"--new": new, "--from": record is not None, "--list": show}
    first, *others = [option for option, is_given in chosen.items() if is_given] or [""]
    if others:
        raise UsageError(f"{others[0]} and {first} cannot be combined", "use one of them")
    if show:
        return show_gallery(gallery.HARD_FOLDER if name == gallery.HARD_FOLDER else "")
    if record is not None:
        return draft(record, name or "")
    if new:
        return write_new_scenario(name or LOCAL_SCENARIO)
    if name is None:
        name = DEFAULT_SCENARIO
        terminal.print_stderr(
            f"no name is given: writing {name} of the gallery; `drysim init --list` shows "
            f"all {len(gallery.list_scenarios())}, `drysim init --new` writes a scenario to "
            "fill in"
        )
    written = gallery.copy(name, Path())
    with tolerate_closed_pipe(Path()):
        terminal.print_stdout("\n".join(map(str, written)))
    if loop := gallery.find(name).loop:
        terminal.print_stderr(f"friction loop: {loop}")
    terminal.print_stderr(f"next: {gallery.find(name).command_line(written[0])}")
    return EXIT_OK


def write_new_scenario(name: str) -> int:
    """Write a commented scenario to fill in."""
    from drysim.console import terminal
    from drysim.manual.skeleton import write_skeleton
    from drysim.study.gallery import new_file

    file = new_file(name)
    write_skeleton(file)
    with tolerate_closed_pipe(Path()):
        terminal.print_stdout(str(file))
    quoted = shlex.quote(str(file))
    steps = f"drysim validate {quoted}; drysim run {quoted}"
    terminal.print_stderr(f"next: change its values; {steps}")
    return EXIT_OK


def draft(record: str, name: str) -> int:
    """Write a scenario for a measured record, and show what is left to decide and to check."""
    from drysim.console import terminal
    from drysim.study.draft import write_draft

    file, inspection = write_draft(Path(record), name)
    with tolerate_closed_pipe(Path()):
        terminal.print_stdout(str(file))
    terminal.print_stderr("; ".join(inspection.layout))
    proposals = inspection.proposals
    left = {
        "give values to": [each.key for each in proposals if each.value is None],
        "check": [each.key for each in proposals if each.value and not each.is_certain],
    }
    steps = [f"{verb} {', '.join(keys)}" for verb, keys in left.items() if keys]
    check = f"drysim validate {shlex.quote(str(file))}"
    steps += ["replace the example oscillator and friction", check]
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
    scenarios: options.Files,
    changes: options.Changes = None,
    over: options.Over = None,
    out: options.Out = None,
    approach: options.Approach = None,
    workers: options.SeedWorkers = None,
    resume: options.SeedResume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Compute one case, for one or many seeds: motion, metrics."""
    if over:
        return sweep(context, scenarios, changes, over, out, approach, workers, resume, dry_run)
    from drysim.scenario.load import load
    from drysim.study.preparation import prepare
    from drysim.study.statistics import max_seeds

    common, overrides = Common.of(context), options.overrides(changes, approach)

    def job_of(file: str) -> Job:
        case = prepare(load(file, overrides), interval=True)
        if max_seeds(case.scenario) > 1:
            return seeds_job(case, workers, resume)
        check_single_seed_options(workers, resume)
        return run_job(case, common.mode)

    return carry_out_each(jobs_of(scenarios, job_of), common)


def jobs_of(scenarios: Sequence[str], job_of: Callable[[str], Job]) -> list[Job]:
    """Return the job of each scenario file, or show the faults of all and raise the last."""
    from drysim.console.problems import show_error
    from drysim.console.terminal import print_stderr

    jobs, faults = [], []
    for file in scenarios:
        try:
            jobs.append(job_of(file))
        except DrysimError as fault:
            if isinstance(fault, UsageError) and len(scenarios) > 1:
                fault.message = f"{file}: {fault.message}"
            faults.append(fault)
    for earlier in faults[:-1]:
        show_error(earlier)
        print_stderr("")
    if faults:
        raise faults[-1]
    return jobs


def run_job(case: Case, mode: OutputMode) -> Job:
    """Return the job of a single case, or of one over an interval of its static ratio."""
    from drysim.cli import work
    from drysim.output.folder import resumable_parts
    from drysim.study.budget import LARGE_RESPONSE, SLOW_SCENE, response_bytes

    def before(folder: Path) -> None:
        if held := resumable_parts(folder):
            kept = f"the finished {' and '.join(held)} in {folder}.partial"
            mode.print_loss(f"this run discards {kept}; use --out to keep them")
        if case.scenario.static_interval:
            return
        for warning in case.warnings:
            if warning.slug in (SLOW_SCENE, LARGE_RESPONSE):  # useful before the computation
                mode.print_status(f"note: {warning.sentence}")

    def solve(_: Work) -> Any:
        if case.scenario.static_interval:
            from drysim.study.sweep import solve_interval

            return solve_interval(case)
        from drysim.study.run import solve

        return solve(case)

    return Job(
        name=case.scenario.name,
        scenario=case.scenario,
        kind="sweep" if case.scenario.static_interval else "run",
        plan=partial(work.run_plan, case),
        solve=solve,
        volume=0.0 if case.scenario.static_interval else response_bytes(case),
        before=before,
    )


def seeds_job(case: Case, workers: int | None, resume: bool) -> Job:
    """Return the job of a case under many seeds."""
    from drysim.cli import work
    from drysim.study import ensemble
    from drysim.study.plan import seed_ranges
    from drysim.study.statistics import max_seeds

    def solve(given: Work) -> Any:
        finished = partial(work.count_batch, given.advance)
        assert given.store is not None, "a job with parts has a store"
        try:
            return ensemble.solve(case, workers=workers, store=given.store, finished=finished)
        except KeyboardInterrupt:
            return ensemble.partial_ensemble(case, given.store)

    return Job(
        name=case.scenario.name,
        scenario=case.scenario,
        kind="ensemble",
        plan=partial(work.run_plan, case),
        solve=solve,
        total=max_seeds(case.scenario),
        items="seeds",
        parts=work.parts_of("seeds", case, seed_ranges(case), resume),
    )


def check_single_seed_options(workers: int | None, resume: bool) -> None:
    """Raise UsageError for options that need several seeds."""
    hint = "add --set excitation.seeds=20, or omit the option"
    if workers is not None:
        raise UsageError("--workers needs several seeds: a single run has one worker", hint)
    if resume:
        raise UsageError("--resume needs several seeds: a single run starts over", hint)


def sweep(
    context: typer.Context,
    scenarios: options.Files,
    changes: options.Changes = None,
    over: options.Over = None,
    out: options.Out = None,
    approach: options.Approach = None,
    workers: options.Workers = None,
    resume: options.Resume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
    form: options.Table = "csv",
    cluster: options.Cluster = None,
    tls_ca_file: options.TlsCa = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
) -> int:
    """Compute all cases of the sweep block: transmissibility."""
    from drysim.scenario.load import load
    from drysim.study.preparation import prepare

    common, overrides = Common.of(context), options.overrides(changes, approach, over)
    certificates = tls_ca_file, tls_cert, tls_key

    def job_of(file: str) -> Job:
        case = prepare(load(file, overrides), swept=True, interval=True)
        if form == "parquet":
            from drysim.results.sweep import require_pyarrow

            require_pyarrow()
        if case.scenario.static_interval:
            if (cluster or resume) and not dry_run:
                option = "--cluster" if cluster else "--resume"
                hint = "omit the option, or give one value"
                sentence = f"{option} does not apply to an interval of static_ratio"
                raise UsageError(sentence, hint)
            return swept_interval_job(case, workers, form)
        from drysim.cli import work

        executor = partial(work.case_executor, cluster, workers, common.mode, certificates)
        return sweep_job(case, executor, resume, form)

    return carry_out_each(jobs_of(scenarios, job_of), common)


def sweep_job(case: Case, executor: Callable[[], Any], resume: bool, form: str) -> Job:
    """Return the job of a sweep."""
    from drysim.cli import work
    from drysim.study.plan import CaseRanges, approaches_of

    wanted = approaches_of(case.scenario)
    ranges = CaseRanges(wanted)

    def solve(given: Work) -> Any:
        from drysim.results.sweep import transmissibility_text
        from drysim.study.sweep import partial_table, solve

        as_text = transmissibility_text(case.scenario) if form == "csv" else None
        finished = partial(work.count_batch, given.advance)
        assert given.store is not None, "a job with parts has a store"
        try:
            return solve(
                case,
                execute=given.execute,
                store=given.store,
                finished=finished,
                as_text=as_text,
            )
        except KeyboardInterrupt:
            return partial_table(case, given.store)

    return Job(
        name=case.scenario.name,
        scenario=case.scenario,
        kind="sweep",
        plan=partial(work.grid_plan, case, [scenario.label for scenario in wanted]),
        solve=solve,
        total=sum(ranges.cases),
        executor=executor,
        parts=work.parts_of("cases", case, ranges, resume),
        form=form,
    )


def swept_interval_job(case: Case, workers: int | None, form: str) -> Job:
    """Return the job of a sweep over an interval of the static ratio."""
    from drysim.cli import work
    from drysim.scenario.axes import count_points
    from drysim.study.sweep import solve_swept_interval

    def solve(given: Work) -> Any:
        finished = partial(work.count_batch, given.advance)
        return solve_swept_interval(case, workers=workers, finished=finished)

    return Job(
        name=case.scenario.name,
        scenario=case.scenario,
        kind="sweep",
        plan=partial(work.grid_plan, case, [case.scenario.label]),
        solve=solve,
        total=count_points(case.scenario.sweep),
        form=form,
    )


def compare(
    context: typer.Context,
    approaches: options.Compared,
    scenario: options.ScenarioOption = None,
    changes: options.Changes = None,
    over: options.Over = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Compare approaches or friction laws on one base motion."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study.compare import parse_names, scenarios_by_name, solve
    from drysim.study.preparation import prepare
    from drysim.study.run import count_cases

    common = Common.of(context)
    arguments, file = split_compared(approaches, scenario)
    names = parse_names(arguments)
    changed = options.overrides(changes, over=over)
    loaded = load(file or default_scenario(names, common.mode), changed)
    case = prepare(loaded.variant(names[-1]), compared=True, swept=True)
    wanted = scenarios_by_name(loaded, names)

    def solve_all(given: Work) -> Any:
        finished = partial(work.count_batch, given.advance)
        return solve(loaded, case, names, workers=workers, finished=finished)

    job = Job(
        name=study_name(loaded.name, "compare"),
        scenario=loaded,
        kind="comparison",
        plan=partial(work.grid_plan, case, [*wanted]),
        solve=solve_all,
        total=count_cases(list(wanted.values())),
    )
    return carry_out(job, common)


def fit(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    resume: options.FitResume = False,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Fit friction, damping and stiffness to a measured response."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study import fit as study

    common = Common.of(context)
    loaded = load(scenario, changes or [])
    models = study.prepare_fit(loaded)
    job = Job(
        name=study_name(loaded.name, "fit"),
        scenario=loaded,
        kind="fit",
        plan=lambda folder: work.fit_plan(study.read_model(loaded), folder),
        solve=lambda given: study.solve(
            loaded, models, workers=workers, finished=given.advance, store=given.store
        ),
        total=study.count_steps(loaded),
        items="steps",
        parts=Parts("steps", loaded, resume, finished=lambda store: (0, 0)),
        after=show_command_after_fit,
    )
    return carry_out(job, common)


def show_command_after_fit(result: FitResult, folder: Path) -> None:
    """Print how to continue with the fitted values."""
    from drysim.console import terminal
    from drysim.results.fit import FITTED_FILE

    if not result.is_useless:
        command = "sweep" if result.scenario.sweep else "run"
        if result.scenario.design is not None:
            command = "design"
        file = shlex.quote(str(folder / FITTED_FILE))
        terminal.print_stderr(f"next: drysim {command} {file}")


def assess(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    out: options.NamedOut = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Evaluate motions measured on base and mass: SEAT, exposure."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study import assess as study

    common = Common.of(context)
    loaded = load(scenario, changes or [])
    study.require_assess(loaded)
    job = Job(
        name=study_name(loaded.name, "assess"),
        scenario=loaded,
        kind="assess",
        plan=lambda folder: work.assess_plan(loaded, folder),
        solve=lambda given: study.assess(loaded),
    )
    return carry_out(job, common)


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
    junit: options.Junit = None,
    quiet: options.Quiet = False,
    cluster: options.Cluster = None,
    tls_ca_file: options.TlsCa = None,
    tls_cert: options.TlsCert = None,
    tls_key: options.TlsKey = None,
) -> int:
    """Find the best values of some keys within limits."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study.design import design_of, prepare_design

    common = Common.of(context)
    case = prepare_design(load(scenario, changes or []))
    certificates = tls_ca_file, tls_cert, tls_key
    job = Job(
        name=study_name(case.scenario.name, "design"),
        scenario=case.scenario,
        kind="design",
        plan=partial(work.design_plan, case),
        solve=partial(work.solve_design, case),
        total=design_of(case.scenario).evaluations,
        items="designs",
        executor=partial(work.case_executor, cluster, workers, common.mode, certificates),
        parts=work.design_parts(case, resume),
        after=partial(show_command_after_design, case.scenario.sweep),
    )
    return carry_out(job, common)


def show_command_after_design(
    conditions: Sequence[Axis], result: DesignResult, folder: Path
) -> None:
    """Print how to continue with the best design, if there is one: under its conditions.

    Conditions that vary together, such as draws of a fit, are no grid: the design runs alone.
    """
    from drysim.console import terminal
    from drysim.results.design import BEST_FILE

    if result.complete and result.best is not None:
        command, words = "run", [str(folder / BEST_FILE)]
        if conditions and all(is_numeric(a.values) and not a.group for a in conditions):
            command = "sweep"
            for axis in conditions:
                values = ",".join(f"{value:.12g}" for value in axis.values)
                values = values if len(axis.values) > 1 else f"[{values}]"
                words += ["--over", f"{axis.key}={values}"]
        terminal.print_stderr(f"next: drysim {command} {shlex.join(words)}")


def is_numeric(values: Sequence[Any]) -> bool:
    """Whether values are numbers, and few enough for a command line."""
    return len(values) <= MAX_LISTED and not any(isinstance(value, str) for value in values)


def branches(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    over: options.Over = None,
    out: options.NamedOut = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Follow all periodic motions, stable or not, along a key."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study.branches import prepare_branches, solve

    common = Common.of(context)
    case = prepare_branches(load(scenario, options.overrides(changes, over=over)))
    job = Job(
        name=study_name(case.scenario.name, "branches"),
        scenario=case.scenario,
        kind="branches",
        plan=partial(work.grid_plan, case, [case.scenario.label]),
        solve=lambda given: solve(case),
    )
    return carry_out(job, common)


def regime_map(
    context: typer.Context,
    scenario: options.File,
    changes: options.Changes = None,
    over: options.Over = None,
    out: options.NamedOut = None,
    workers: options.Workers = None,
    dry_run: options.DryRun = False,
    strict: options.Strict = False,
    no_plots: options.NoPlots = False,
    picture_format: options.PictureFormat = "png",
    report: options.Report = False,
    junit: options.Junit = None,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Map over two keys where the mass locks, stops or slides."""
    from drysim.cli import work
    from drysim.scenario.load import load
    from drysim.study.regimes import prepare_map, require_map, solve

    common = Common.of(context)
    case = prepare_map(load(scenario, options.overrides(changes, over=over)))
    job = Job(
        name=study_name(case.scenario.name, "map"),
        scenario=case.scenario,
        kind="map",
        plan=partial(work.map_plan, case),
        solve=lambda given: solve(case, workers=workers, advance=given.advance),
        total=require_map(case.scenario)[1].nodes,
        items="points",
    )
    return carry_out(job, common)


regime_map.__name__ = "map"  # the name of the command; in Python it is a built-in function


def split_compared(arguments: list[str], option: str | None) -> tuple[list[str], str | None]:
    """Return the words of a comparison without a scenario as their last, and the scenario.

    Raises
    ------
    UsageError
        If the scenario is named twice.
    """
    from drysim.study.compare import KNOWN_NAMES
    from drysim.study.gallery import SUFFIXES

    *others, last = arguments
    is_file = Path(last).suffix in SUFFIXES or Path(last).is_file()
    if last in KNOWN_NAMES or not is_file:
        return arguments, option
    if option is not None:
        sentence = f"two scenarios are named: {last} and --scenario {option}"
        raise UsageError(sentence, "name one of them")
    return others, last


def default_scenario(names: Sequence[str], mode: OutputMode) -> str:
    """Return the scenario to compare if none is named: of this folder, or the gallery's."""
    if Path(LOCAL_SCENARIO).exists():
        return LOCAL_SCENARIO
    if len(local := local_scenarios()) == 1:
        mode.print_status(f"{local[0]} is the only scenario in this folder")
        return str(local[0])
    from drysim.scenario.laws import LAWS
    from drysim.study import gallery

    name = FALLBACK_FOR_LAWS if LAWS.keys() & {*names} else FALLBACK_SCENARIO
    reason = f"no {LOCAL_SCENARIO} in this folder"
    if local:
        reason = f"{len(local)} scenarios in this folder and none named as the last word"
    mode.print_status(f"{reason}: using {name} from the gallery")
    return str(gallery.find(name).file)


def local_scenarios() -> list[Path]:
    """Return the YAML files of this folder that look like scenarios, also faulty ones."""
    from drysim.study.gallery import SUFFIXES
    from drysim.yaml_document import UnreadableError, read_bytes

    scenarios = []
    for file in sorted(Path().iterdir()):
        if file.suffix in SUFFIXES:
            with suppress(UnreadableError):
                if SCENARIO_PATTERN.search(read_bytes(file)):
                    scenarios.append(file)
    return scenarios


def validate(
    scenarios: options.Files,
    changes: options.Changes = None,
    form: options.Format = "text",
    strict: options.StrictWarnings = False,
    junit: options.Junit = None,
    quiet: options.Quiet = False,
) -> int:
    """Check scenario files without computing."""
    from drysim.console import problems
    from drysim.study.validate import validate as find_problems

    if junit is not None:
        from drysim.output.junit import check_junit, save_junit, validation_suite

        check_junit(junit)
    problems_by_file = {file: find_problems(file, changes or []) for file in scenarios}
    failing = ("error", "warning") if strict else ("error",)
    faults = {
        file: failed
        for file, listed in problems_by_file.items()
        if (failed := [problem for problem in listed if problem.severity in failing])
    }
    if junit is not None:
        save_junit(
            junit,
            [
                validation_suite(file, listed, failing)
                for file, listed in problems_by_file.items()
            ],
        )
    with tolerate_closed_pipe():
        shown = faults if quiet and form != "json" else problems_by_file
        problems.show_problems(shown, form, strict)
    if any(problem.severity == "error" for file in faults.values() for problem in file):
        return EXIT_NOTHING_COMPUTED
    return EXIT_CHECK_FAILED if faults else EXIT_OK


def summarise(folder: options.Folder, as_json: options.Json = False) -> int:
    """Show summary, metrics and warnings of a finished result."""
    from drysim.cli.stored import show_stored, stored_warnings
    from drysim.console import terminal
    from drysim.console.summary import show_warnings
    from drysim.errors import WarningMessage
    from drysim.output.folder import note_on_files, read_stored_fields, translate_damage
    from drysim.study.summary import BAD

    fields = read_stored_fields(folder)
    with translate_damage(folder, fields):  # a damaged result is found before anything is shown
        show_stored(fields, terminal.PlainConsole(StringIO()))
        warnings = stored_warnings(fields)
        files = note_on_files(folder, fields)
    damages = [WarningMessage("files-changed", files.sentence)] if files.tone == BAD else []
    with tolerate_closed_pipe():
        if as_json:
            shown = {name: fields[name] for name in SUMMARY_KEYS if name in fields}
            typer.echo(json.dumps(shown, indent=2))
            show_warnings(damages)
        else:
            show_stored(fields, terminal.stdout())
            show_warnings([*warnings, *damages])
    return EXIT_OK


def report(
    folder: options.Folder,
    out: options.ReportFile = None,
    no_plots: options.ReportNoPlots = False,
    quiet: options.Quiet = False,
) -> int:
    """Write a report of a finished result: one page of HTML."""
    from drysim.console import terminal
    from drysim.output.folder import REPORT_FILE, add_report, check_report, save_file
    from drysim.output.report import read_result, report_folder
    from drysim.wording import sanitise

    fields, file = read_result(folder), out or folder / REPORT_FILE
    check_report(file, folder)
    if not no_plots:
        from drysim.plots.style import leave_out_documentation

        leave_out_documentation()
    page, objections = report_folder(folder, fields, plots=not no_plots)
    if file.absolute() == (folder / REPORT_FILE).absolute():
        add_report(folder, page, fields)
    else:
        save_file(file, page)
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
    common = Common.of(context)
    if steady and hard:
        raise UsageError("--steady and --hard cannot be combined", "use one of them")
    if hard:
        job = hard_cases_job(scenario, changes or [], patience)
        return carry_out(job, replace(common, plots=False))
    from drysim.bench import scipy_ivp, speed_error
    from drysim.bench.timing import BenchOptions

    terms = BenchOptions(
        samples, repeats, patience or options.RUN_TIME_LIMIT, (scipy_ivp,) if peers else ()
    )
    requested = speed_error.load_scenarios(scenario, changes or [], steady)
    measurement = (
        speed_error.steady_state_bench(requested, terms)
        if steady
        else speed_error.time_history_bench(requested, terms)
    )
    shown = terms._asdict() | {"peers": peers}
    job = Job(
        name=name_of_bench(scenario, requested, "steady" if steady else "bench"),
        kind="bench",
        plan=partial(bench_plan, measurement.cases, shown, measurement.warnings),
        solve=lambda given: measurement.run(given.advance),
        total=sum(case["entries"] for case in measurement.cases),
        items="entries",
    )
    return carry_out(job, common)


def hard_cases_job(scenario: str | None, changes: Sequence[str], patience: float | None) -> Job:
    """Return the job that runs every approach on the hard cases."""
    from drysim.approach import APPROACHES_BY_NAME
    from drysim.bench import hard_cases

    requested = hard_cases.load_scenarios(scenario, changes)
    limit = patience or options.HARD_TIME_LIMIT
    cases = [{"name": each.name, "entries": len(APPROACHES_BY_NAME)} for each in requested]
    return Job(
        name=name_of_bench(scenario, requested, "hard"),
        kind="hard",
        plan=partial(bench_plan, cases, {"patience": limit}, ()),
        solve=lambda given: hard_cases.run(requested, limit, given.advance),
        total=len(requested) * len(APPROACHES_BY_NAME),
        items="runs",
    )


def name_of_bench(scenario: str | None, requested: Sequence[Scenario], label: str) -> str:
    """Return the name of the output folder of a bench, after its scenario if it has one."""
    return label if scenario is None else study_name(requested[0].name, label)


def bench_plan(
    cases: Sequence[dict[str, Any]],
    terms: dict[str, Any],
    warnings: Sequence[WarningMessage],
    folder: Path,
) -> Plan:
    """Return what a bench would do."""
    sentences = [
        f"{case['name']}: {case['entries']} entries"
        + (f" on {case['samples']} samples" if "samples" in case else "")
        for case in cases
    ]
    return Plan({"cases": cases, **terms, "folder": folder.as_posix()}, sentences, warnings)


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
        from drysim.study.preparation import prepare
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
