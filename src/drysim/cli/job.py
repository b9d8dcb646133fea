"""A command that computes, as a job: `carry_out` takes it from its plan to its exit code.

Check the output folder, show the plan (`--dry-run`) or lock the folder, solve, write, show. A
job says what differs between commands; `carry_out_each` takes several.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

from drysim.cli import process
from drysim.cli.process import Done
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_INTERRUPTED,
    EXIT_OK,
    DrysimError,
    OutputError,
    UsageError,
)

if TYPE_CHECKING:
    import typer

    from drysim.cli.process import OutputMode, Plan
    from drysim.output.folder import LockedFolder
    from drysim.scenario.model import Scenario
    from drysim.study.outcome import AnyResult
    from drysim.study.store import Store


@dataclass(frozen=True)
class Common:
    """Options that commands share.

    Attributes
    ----------
    command : str
        The command line, quoted for a shell.
    mode : OutputMode
    out : Path, optional
        The output folder, of several jobs the folder that holds theirs; default: `out/` and
        the name of the job.
    dry_run, strict, plots, report : bool
    picture_format : str
    junit : Path, optional
        The file of the checks as JUnit XML.
    """

    command: str
    mode: OutputMode
    out: Path | None = None
    dry_run: bool = False
    strict: bool = False
    plots: bool = True
    report: bool = False
    picture_format: str = "png"
    junit: Path | None = None

    @classmethod
    def of(cls, context: typer.Context) -> Common:
        """Return the options of a command, by the names of its parameters."""
        given = context.params
        return cls(
            command=process.command_line(context),
            mode=process.OutputMode(given["as_json"], given["quiet"]),
            out=Path(given["out"]) if given["out"] is not None else None,
            dry_run=given["dry_run"],
            strict=given.get("strict", False),
            plots=not given["no_plots"],
            report=given.get("report", False),
            picture_format=given["picture_format"],
            junit=Path(given["junit"]) if given.get("junit") is not None else None,
        )


class Work(NamedTuple):
    """What the solution of a job needs."""

    advance: Callable[..., None]
    """Counts finished items, and repeats an interrupt that was lost."""
    execute: Any
    """What the executor of the job yields."""
    store: Store | None
    """Holds finished parts, of a job that can be resumed."""


class Parts(NamedTuple):
    """The parts of a job that can be interrupted and resumed."""

    name: str
    """Of `output.STORES`."""
    scenario: Scenario
    """Its work identity is that of the stored parts."""
    resume: bool
    finished: Callable[[Store], tuple[int, int]]
    """Returns the numbers of items and of blocks that a store holds."""
    blocks: int = 0
    """Number of all blocks; the progress shows those of one."""
    count: Callable[[Any], int] = lambda result: len(result.rows)
    """Returns the number of finished items of an interrupted result."""


def study_name(scenario_name: str, command: str) -> str:
    """Return the name of the output folder of a study: `seat-design`, also of `seat-design`."""
    suffix = f"-{command}"
    return scenario_name.removesuffix(suffix) + suffix


def nothing(*_: Any) -> None:
    """Do nothing: where a job has nothing to say."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """What a command computes.

    Attributes
    ----------
    name : str
        Default name of the output folder.
    kind : str
        Kind of the result.
    plan : callable
        Returns what a dry run shows, given the output folder.
    solve : callable
        Returns the result, given the `Work`; an interrupted one, which is not complete, of a
        job with parts.
    total : int
        Number of items that the progress counts; 0 for no progress.
    items : str
        What they are.
    volume : float
        Estimated size of its files [bytes]; 0 where they are small.
    before : callable
        Called with the output folder before the work.
    after : callable
        Called with the result and the output folder at the end, except with `--json` and
        `--quiet`.
    executor : callable
        Returns the context of the work, which yields what computes it.
    parts : Parts, optional
    form : str
        Format of the cases of a sweep.
    scenario : Scenario, optional
        Names the files that the job reads.
    """

    name: str
    kind: str
    plan: Callable[[Path], Plan]
    solve: Callable[[Work], Any]
    total: int = 0
    items: str = "cases"
    volume: float = 0.0
    before: Callable[[Path], None] = nothing
    after: Callable[[Any, Path], None] = nothing
    executor: Callable[[], AbstractContextManager[Any]] = nullcontext
    parts: Parts | None = None
    form: str = "csv"
    scenario: Scenario | None = None


def carry_out(job: Job, common: Common) -> int:
    """Carry out a job; return its exit code; errors as of `carry_out_each`."""
    return carry_out_each([job], common)


def carry_out_each(jobs: Sequence[Job], common: Common) -> int:
    """Carry out jobs one after another, each into its own folder; return the worst exit code.

    Where the numerics of one of several jobs fail, the others are carried out.

    Raises
    ------
    OutputError
        A folder was not written by drysim, or cannot be written, or the disk has no room for
        its files, or the folder of several results is a result; nothing was computed.
    UsageError
        Two jobs have the same folder.
    """
    from drysim import output

    mode, folders = common.mode, output_folders(jobs, common.out)
    for folder in folders:
        output.check_writable(folder)
    check_inputs(jobs, folders)
    # The folders of several results are in one folder, and so on one disk.
    place = folders[0] if len(folders) == 1 else folders[0].parent
    output.check_disk_space(place, sum(job.volume for job in jobs))
    if common.junit is not None:
        from drysim.output.junit import check_junit

        check_junit(common.junit, folders)
    if common.dry_run:
        for job, folder in zip(jobs, folders, strict=True):
            mode.print_discarded(folder, job.parts is not None and job.parts.resume)
        return mode.plan([job.plan(folder) for job, folder in zip(jobs, folders, strict=True)])
    worst, outcomes = EXIT_OK, []
    for job, folder in zip(jobs, folders, strict=True):
        begin = perf_counter()
        try:
            done = compute(job, folder, common)
        except DrysimError as fault:
            outcomes.append(JobOutcome(job.name, fault, perf_counter() - begin))
            worst = max(worst, fault.exit_code)
            if len(jobs) == 1:
                write_junit(outcomes, common, worst)
                raise
            show_fault(job, fault)
            continue
        outcomes.append(JobOutcome(job.name, done.fields, perf_counter() - begin))
        worst = max(worst, done.code)
        mode.report(done, job.name if len(jobs) > 1 else "")
        if len(jobs) == 1 and not (mode.as_json or mode.quiet):
            job.after(done.result, folder)
        if done.code == EXIT_INTERRUPTED:
            break
    write_junit(outcomes, common, worst)
    if len(jobs) > 1 and mode.as_json:
        contents = [done.content for done in outcomes if isinstance(done.content, dict)]
        mode.print_json({"results": contents}, worst)
    return worst


class JobOutcome(NamedTuple):
    """What came of a job."""

    name: str
    content: dict[str, Any] | DrysimError
    """The content of drysim.json, or why there is none."""
    time: float
    """Time of the computation [s]."""


def write_junit(outcomes: Sequence[JobOutcome], common: Common, code: int) -> None:
    """Write the checks of jobs as JUnit XML, if that was asked for.

    `code` is the exit code of the work, which a fault of the file turns into 1 if it is 0; an
    interrupted command writes none.
    """
    if common.junit is None or code == EXIT_INTERRUPTED:
        return
    from drysim.output.junit import fault_suite, result_suite, save_junit

    suites = [
        fault_suite(name, content, time)
        if isinstance(content, DrysimError)
        else result_suite(content, common.strict, time)
        for name, content, time in outcomes
    ]
    try:
        save_junit(common.junit, suites)
    except OutputError as fault:
        fault.exit_code = code or EXIT_CHECK_FAILED
        raise


def check_inputs(jobs: Sequence[Job], folders: Sequence[Path]) -> None:
    """Raise OutputError if a job reads a file of a folder that a result would replace."""
    from drysim.scenario.files import named_files

    places = {folder.resolve(): folder for folder in folders}
    for job in jobs:
        for _, path in named_files(job.scenario) if job.scenario is not None else ():
            for parent in path.resolve().parents:
                if parent in places:
                    sentence = (
                        f"{job.name} reads {path.name} of {places[parent]}, which a result "
                        "would replace"
                    )
                    raise OutputError(sentence, "choose another folder with --out")


def output_folders(jobs: Sequence[Job], out: Path | None) -> list[Path]:
    """Return the output folder of each job: `--out`, which of several jobs holds theirs."""
    if len(jobs) == 1:
        return [out or Path("out", jobs[0].name)]
    names = Counter(job.name for job in jobs)
    twice = [name for name, count in names.items() if count > 1]
    if twice:
        raise UsageError(
            f"several scenarios are named {twice[0]}, and each writes a folder of its name",
            "name each file once, give each its own `name`, or use one command and --out each",
        )
    from drysim.output import check_no_result

    parent = out or Path("out")
    check_no_result(parent)
    return [parent / job.name for job in jobs]


def show_fault(job: Job, fault: DrysimError) -> None:
    """Show why one of several jobs failed."""
    from drysim.console.problems import show_error

    fault.message = f"{job.name}: {fault.message}"
    show_error(fault)


def compute(job: Job, folder: Path, common: Common) -> Done:
    """Solve a job and write its folder."""
    from drysim import output
    from drysim.output.folder import LockedFolder, stored_kind

    mode = common.mode
    replaced = stored_kind(folder)
    if replaced not in ("", job.kind):
        mode.print_loss(f"the {replaced} in {folder} will be replaced; use --out to keep it")
    job.before(folder)
    with job.executor() as execute, ExitStack() as stack:
        place: Path | LockedFolder = folder
        store = None
        if job.parts is not None:
            place, store = stack.enter_context(locked_store(folder, job.parts, mode))
        try:
            with progress(job, store, mode.quiet) as advance:
                result: AnyResult = job.solve(Work(advance, execute, store))
        except KeyboardInterrupt:
            if store is not None and len(store):
                from drysim.console.terminal import print_stderr

                print_stderr("the same command with --resume continues from here")
            raise
        complete: bool = getattr(result, "complete", True)
        code = result.exit_code(common.strict) if complete else EXIT_INTERRUPTED
        if complete and not common.report and output.has_report(folder):
            mode.print_loss(
                f"the report of the earlier result in {folder} will be removed with it; "
                f"`drysim report {folder}` writes a new one"
            )
        if common.plots and complete:
            from drysim.plots.style import leave_out_documentation

            leave_out_documentation()
        fields = output.write(
            result,
            place,
            plots=common.plots,
            command=common.command,
            exit_code=code,
            picture_format=common.picture_format,
            report=common.report,
            form=job.form,
        )
    if not complete and job.parts is not None:
        from drysim.console.summary import show_interrupted

        kept, what = job.parts.count(result), job.parts.name.removesuffix("s")
        # A design study goes on after its last candidate.
        is_all = kept == job.total and what != "design"
        show_interrupted(kept, what, folder, is_all=is_all)
    written = place.partial if isinstance(place, LockedFolder) and not complete else folder
    return Done(result, fields, written, code)


@contextmanager
def locked_store(
    folder: Path, parts: Parts, mode: OutputMode
) -> Iterator[tuple[LockedFolder, Store]]:
    """Lock an output folder and yield it with the store of its finished parts."""
    from drysim.study.store import Store, is_resumable, work_identity

    identity = work_identity(parts.scenario)

    def check(partial: Path) -> None:
        if parts.resume:
            is_resumable(partial / parts.name, identity)

    with mode.lock(folder, parts.resume, parts.name, check) as locked:
        store = Store(locked.partial / parts.name, identity, parts.resume)
        if parts.resume:
            mode.print_status(describe_resumed(folder, parts, store))
        yield locked, store


def describe_resumed(folder: Path, parts: Parts, store: Store) -> str:
    """Describe the finished parts from which --resume continues."""
    from drysim.output.folder import stored_kind
    from drysim.wording import format_count

    if not len(store):
        nothing = f"no finished {parts.name} in {folder}.partial"
        finished = f"; {folder} is finished and is computed again" * bool(stored_kind(folder))
        return f"--resume: {nothing}, starting from the beginning{finished}"
    items, _ = parts.finished(store)
    what = format_count(items, parts.name.removesuffix("s")) if items else f"the {parts.name}"
    return f"--resume: continuing after {what} in {folder}.partial"


@contextmanager
def progress(job: Job, store: Store | None, quiet: bool) -> Iterator[Callable[..., None]]:
    """Yield a function that counts finished items, as `terminal.progress` does."""
    if not job.total:
        yield nothing
        return
    from drysim.console import terminal

    items, blocks = 0, 0
    if job.parts is not None and store is not None and job.parts.resume:
        items, blocks = job.parts.finished(store)
    left = max(job.parts.blocks - blocks, 0) if job.parts is not None else 0
    with terminal.progress(job.total - items, job.items, quiet, left) as advance:

        def advance_or_stop(count: int = 1) -> None:
            advance(count)
            process.raise_if_interrupted()

        yield advance_or_stop
