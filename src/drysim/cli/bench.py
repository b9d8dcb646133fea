"""The command over all approaches: bench."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drysim.cli import options
from drysim.cli.streams import reader_may_leave
from drysim.cli.studies import app as app
from drysim.errors import EXIT_OK

if TYPE_CHECKING:
    from drysim.study.bench.attempt import Terms
    from drysim.study.bench.work import Work

Asked = Annotated[
    str | None,
    typer.Argument(metavar="[SCENARIO]", help="File (YAML); default: two of the gallery."),
]
Repeats = Annotated[
    int, typer.Option("--repeats", min=1, metavar="N", help="Runs of an entry, at most.")
]
Size = Annotated[
    int, typer.Option("--samples", min=1, metavar="N", help="Samples of the work, at most.")
]
Patience = Annotated[
    float,
    typer.Option(
        "--patience",
        min=1e-3,
        metavar="SECONDS",
        help="What one run may take; slower entries run on a shorter stretch.",
    ),
]
Peers = Annotated[
    bool, typer.Option("--peers/--no-peers", help="Whether other programs take part.")
]


@app.command()
def bench(
    context: typer.Context,
    scenario: Asked = None,
    changes: options.Changes = None,
    out: options.Out = None,
    repeats: Repeats = 15,
    samples: Size = 24_000,
    patience: Patience = 0.2,
    peers: Peers = True,
    dry_run: options.DryRun = False,
    no_plots: options.NoPlots = False,
    as_json: options.Json = False,
    quiet: options.Quiet = False,
) -> int:
    """Speed against error: all approaches, and programs that people know."""
    from drysim.report.claim import check
    from drysim.study.bench.attempt import Terms
    from drysim.study.bench.default import NAME, scenarios
    from drysim.study.bench.speed_error import bench as measure
    from drysim.study.bench.speed_error import entries
    from drysim.study.bench.work import work_of

    asked = scenarios(scenario, changes or [])
    works = [work_of(one, samples) for one in asked]
    name = NAME if scenario is None else f"{asked[0].name}-{NAME}"
    folder = Path("out", name) if out is None else out
    check(folder)
    terms = Terms(samples, repeats, patience, peers)
    if dry_run:
        return plan(works, terms, folder, as_json, quiet)
    from drysim import console, report

    total = sum(len(entries(work, terms)) for work in works)
    with console.progress(total, "entries", quiet) as advance:
        made = measure(works, terms, advance)
    command = shlex.join(["drysim", *context.obj])
    told = report.write_bench(
        made, folder, plots=not no_plots, command=command, exit_code=EXIT_OK
    )
    with reader_may_leave(folder):
        if as_json:
            typer.echo(report.text(told), nl=False)
        elif not quiet:
            console.show_bench(made, folder)
        if as_json and not quiet:
            console.show_warnings(made.warnings)
    return EXIT_OK


def plan(works: Sequence[Work], terms: Terms, folder: Path, as_json: bool, quiet: bool) -> int:
    """Show what a bench would do."""
    from drysim import console
    from drysim.study.bench.peers import absent
    from drysim.study.bench.speed_error import entries

    counts = {work.scenario.name: len(entries(work, terms)) for work in works}
    fields = {
        "dry_run": True,
        "cases": [
            {"name": work.scenario.name, "samples": work.samples, "step": work.step,
             "entries": counts[work.scenario.name]}
            for work in works
        ],
        **terms._asdict(),
        "absent": absent(),
        "folder": folder.as_posix(),
    }  # fmt: skip
    with reader_may_leave():
        if as_json:
            typer.echo(json.dumps(fields, indent=2))
        elif not quiet:
            for work in works:
                name = work.scenario.name
                console.say(f"{name}: {counts[name]} entries on {work.samples} samples")
            console.say(f"would be written to {folder}")
            console.say("dry run: nothing was computed, nothing was written")
        if not quiet:
            for work in works:
                console.show_warnings(work.cautions)
    return EXIT_OK
