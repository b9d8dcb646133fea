"""The command over all approaches: bench."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drysim.cli import options
from drysim.cli.voice import Voice, typed
from drysim.errors import EXIT_OK, Caution, UsageError

if TYPE_CHECKING:
    from drysim.scenario import Scenario

PATIENCE, HARD_PATIENCE = 0.2, 30.0
"""Time that one run may take [s], and that a hard case may: there it decides held or failed."""

Asked = Annotated[
    str | None,
    typer.Argument(metavar="SCENARIO", help="File (YAML); default: two of the gallery."),
]
Repeats = Annotated[
    int, typer.Option("--repeats", min=1, metavar="N", help="Runs of an entry, at most.")
]
Size = Annotated[
    int, typer.Option("--samples", min=1, metavar="N", help="Samples of the work, at most.")
]
Patience = Annotated[
    float | None,
    typer.Option(
        "--patience",
        min=1e-3,
        metavar="SECONDS",
        help=f"What one run may take, default {PATIENCE:g}: slower entries run on a shorter "
        f"stretch; with --hard {HARD_PATIENCE:g}, and what takes longer fails.",
    ),
]
Peers = Annotated[
    bool, typer.Option("--peers/--no-peers", help="Whether other programs take part.")
]
Steady = Annotated[
    bool, typer.Option("--steady", help="Time the steady states of a sweep instead.")
]
Hard = Annotated[
    bool, typer.Option("--hard", help="Put every approach through the hard cases instead.")
]


def bench(
    context: typer.Context,
    scenario: Asked = None,
    changes: options.Changes = None,
    out: options.Out = None,
    steady: Steady = False,
    hard: Hard = False,
    repeats: Repeats = 15,
    samples: Size = 24_000,
    patience: Patience = None,
    peers: Peers = True,
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
    from drysim.report.claim import check
    from drysim.study.bench import questions
    from drysim.study.bench.attempt import Terms

    terms = Terms(samples, repeats, patience or PATIENCE, peers)
    asked = questions.scenarios(scenario, changes or [], steady)
    job = questions.settling(asked, terms) if steady else questions.marching(asked, terms)
    folder = folder_of(out, scenario, asked, "steady" if steady else "bench")
    check(folder)
    if dry_run:
        return plan(job.cases, terms._asdict(), folder, job.cautions, voice)
    from drysim import console, report

    total = sum(case["entries"] for case in job.cases)
    with console.progress(total, "entries", quiet) as advance:
        made = job.run(advance)
    told = report.write_bench(
        made, folder, plots=not no_plots, command=command, exit_code=EXIT_OK
    )
    return voice.answer(told, partial(console.show_bench, made, folder), made.warnings, folder)


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
    from drysim.report.claim import check
    from drysim.study.bench import hard

    asked = hard.scenarios(scenario, changes)
    folder = folder_of(out, scenario, asked, "hard")
    check(folder)
    limit = patience or HARD_PATIENCE
    if dry_run:
        cases = [{"name": one.name, "entries": len(SHELF)} for one in asked]
        return plan(cases, {"patience": limit}, folder, (), voice)
    from drysim import console, report

    with console.progress(len(asked) * len(SHELF), "trials", voice.quiet) as advance:
        made = hard.run(asked, limit, advance)
    code = made.exit_code()
    told = report.write_hard(made, folder, command=command, exit_code=code)
    return voice.answer(told, partial(console.show_hard, made, folder), (), folder, code)


def folder_of(
    out: Path | None, scenario: str | None, asked: Sequence[Scenario], word: str
) -> Path:
    """Give the output folder: as it was asked for, or by the scenario's name."""
    if out is not None:
        return out
    return Path("out", word if scenario is None else f"{asked[0].name}-{word}")


def plan(
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
