"""The commands about one scenario, and about none: run, validate, init, schema, doctor."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from drysim.cli import options
from drysim.cli.streams import reader_may_leave
from drysim.cli.voice import Voice, typed
from drysim.errors import (
    EXIT_CHECK_FAILED,
    EXIT_NOTHING_COMPUTED,
    EXIT_NUMERICS_FAILED,
    EXIT_OK,
)

if TYPE_CHECKING:
    from drysim.study.case import Case
    from drysim.study.doctor import Finding

RUN_BY_DOCTOR = "free-decay"

PNG_END = b"IEND\xaeB`\x82"
"""Last bytes of a whole PNG file."""

FIRST = "paper-low-friction"
"""What `drysim init` writes when no name is given."""


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
    from drysim.cli import ensembles
    from drysim.report.claim import check
    from drysim.report.folder import holds_sweep
    from drysim.scenario import load
    from drysim.study.case import prepare
    from drysim.study.ensembles.seeds import most

    voice = Voice(as_json, quiet)
    case = prepare(load(scenario, options.overrides(changes, approach)))
    if most(case.scenario) == 1:
        ensembles.refuse_needless(workers, resume)
    folder = out or Path("out", case.scenario.name)
    check(folder)
    if dry_run:
        from drysim.cli import plans

        return plans.show(case, folder, voice)
    if holds_sweep(folder):
        voice.remark(f"{folder} holds a sweep, which this run replaces; --out keeps it")
    asked = (case, folder, typed(context), voice)
    if most(case.scenario) > 1:
        return ensembles.run(
            *asked, workers=workers, resume=resume, strict=strict, plots=not no_plots
        )
    return run_alone(*asked, strict=strict, plots=not no_plots)


def run_alone(
    case: Case, folder: Path, command: str, voice: Voice, *, strict: bool, plots: bool
) -> int:
    """Compute, write and show the outcome of a case; give the exit code."""
    from drysim import console, report
    from drysim.report.claim import require_room
    from drysim.study import volume
    from drysim.study.effort import SLOW
    from drysim.study.run import solve

    require_room(folder, volume.LEAST_SHARE * volume.bytes_of(case))
    for caution in case.cautions:
        if caution.slug in (SLOW, volume.LARGE):  # of use before the work, too
            voice.remark(f"patience: {caution.sentence}")
    outcome = solve(case)
    code = outcome.exit_code(strict)
    told = report.write(outcome, folder, plots=plots, command=command, exit_code=code)
    show = partial(console.show_outcome, outcome, folder)
    return voice.answer(told, show, outcome.warnings, folder, code)


def validate(
    scenarios: options.Files,
    changes: options.Changes = None,
    form: options.Format = "text",
    strict: options.StrictWarnings = False,
    quiet: options.Quiet = False,
) -> int:
    """Check files, compute nothing."""
    from drysim import console
    from drysim.study.validate import examine

    found = {file: examine(file, changes or []) for file in scenarios}
    failing = ("error", "warning") if strict else ("error",)
    faults = {
        file: failed
        for file, problems in found.items()
        if (failed := [problem for problem in problems if problem.severity in failing])
    }
    with reader_may_leave():
        console.show_problems(faults if quiet and form != "json" else found, form)
    if any(problem.severity == "error" for file in faults.values() for problem in file):
        return EXIT_NOTHING_COMPUTED
    return EXIT_CHECK_FAILED if faults else EXIT_OK


def schema() -> int:
    """JSON schema of scenario files, for editors."""
    from drysim.scenario import schema as describe

    with reader_may_leave():
        typer.echo(json.dumps(describe(), indent=2))
    return EXIT_OK


def init(name: options.Name = FIRST, show: options.Show = False) -> int:
    """Write a commented scenario from the gallery."""
    from drysim import console
    from drysim.study import gallery

    if show:
        return show_gallery(gallery.HARD if name == gallery.HARD else "")
    written = gallery.copy(name, Path())
    with reader_may_leave(Path()):
        console.say("\n".join(map(str, written)))
    if loop := gallery.find(name).loop:
        console.remark(f"its friction loop: {loop}")
    console.remark(f"now: drysim run {written[0]}")
    return EXIT_OK


def show_gallery(part: str) -> int:
    """Show the scenarios of the gallery, or of a part of it, each with what it is about."""
    from drysim import console
    from drysim.study import gallery

    shown = gallery.pieces(part)
    width = 2 + max(len(piece.name) for piece in shown)
    with reader_may_leave():
        for piece in shown:
            seen = " [loop]" if piece.loop else ""
            console.say(f"{piece.name:<{width}}{piece.about}{seen}")
    if any(piece.loop for piece in shown):
        console.remark(f"pictures of the loops: {gallery.folder() / gallery.LOOPS}")
    if part != gallery.HARD:
        console.remark(f"the hard cases: drysim init --list {gallery.HARD}")
    return EXIT_OK


def doctor() -> int:
    """Versions, known answers, a run with its picture; two seconds."""
    from drysim import console
    from drysim.study.doctor import examine

    findings = [*examine(), end_to_end()]
    with reader_may_leave():
        for finding in findings:
            mark = "ok" if finding.sound else "FAULT"
            console.say(f"{mark:<6}{finding.name:<12}{finding.sentence}")
    return EXIT_OK if all(finding.sound for finding in findings) else EXIT_NUMERICS_FAILED


def end_to_end() -> Finding:
    """Run a scenario of the gallery from its file to its picture, in a temporary folder."""
    from tempfile import TemporaryDirectory

    from drysim.study.doctor import Finding

    try:
        from drysim import report
        from drysim.scenario import load
        from drysim.study import gallery
        from drysim.study.case import prepare
        from drysim.study.run import solve

        outcome = solve(prepare(load(gallery.find(RUN_BY_DOCTOR).file)))
        with TemporaryDirectory() as folder:
            out = Path(folder, RUN_BY_DOCTOR)
            report.write(outcome, out, plots=True, command="drysim doctor", exit_code=EXIT_OK)
            whole = Path(out, "response.png").read_bytes().endswith(PNG_END)
    except Exception as fault:  # whatever a broken installation raises
        return Finding("run", False, f"{type(fault).__name__}: {fault}")
    sound = whole and outcome.exit_code() == EXIT_OK
    return Finding("run", sound, f"{RUN_BY_DOCTOR} and its picture")
