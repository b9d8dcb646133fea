"""Arguments and options of all commands, with their help texts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from string import ascii_letters
from typing import Annotated, Literal

import typer

from drysim import __version__
from drysim.errors import EXIT_OK, UsageError
from drysim.wording import join_words

RUN_TIME_LIMIT, HARD_TIME_LIMIT = 0.2, 30.0
"""Default time limit of one run in a bench, and in a hard case, which fails beyond it [s]."""


def complete_approaches() -> list[str]:
    """Return the names of the approaches, for shell completion."""
    from drysim.approach import APPROACHES_BY_NAME

    return list(APPROACHES_BY_NAME)


def complete_compared() -> list[str]:
    """Return the names of approaches and friction laws, for shell completion."""
    from drysim.approach import APPROACHES_BY_NAME
    from drysim.scenario.laws import LAWS

    return [*APPROACHES_BY_NAME, *LAWS]


def complete_gallery() -> list[str]:
    """Return the names of the gallery scenarios, for shell completion."""
    from drysim.study.gallery import HARD_FOLDER, list_scenarios

    return [piece.name for piece in (*list_scenarios(), *list_scenarios(HARD_FOLDER))]


CHECKS = "checks="
"""Key whose values are completed by metrics."""


def complete_pages() -> list[str]:
    """Return the pages of the manual."""
    from drysim.manual import pages

    return list(pages())


def complete_words() -> list[str]:
    """Return all words that `explain` knows."""
    from drysim.manual.words import entries

    return [entry.word for entry in entries()]


def complete_overrides(incomplete: str) -> Iterator[str]:
    """Complete `--set`: keys of a scenario, and metrics behind `checks=`."""
    from drysim.manual.words import KEY, METRIC, entries

    if incomplete.startswith(CHECKS):
        head = incomplete.rstrip(f"_{ascii_letters}")
        yield from (head + entry.word for entry in entries() if entry.kind == METRIC)
    else:
        yield from dict.fromkeys(f"{entry.word}=" for entry in entries() if entry.kind == KEY)


def show_version(wanted: bool) -> None:
    """Print the version and exit."""
    if wanted:
        typer.echo(f"drysim {__version__}")
        raise typer.Exit(EXIT_OK)


Version = Annotated[
    bool,
    typer.Option("--version", callback=show_version, is_eager=True, help="Show the version."),
]
File = Annotated[str, typer.Argument(metavar="FILE", help="Scenario (YAML).")]
Files = Annotated[list[str], typer.Argument(metavar="FILE...", help="Scenarios (YAML).")]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        autocompletion=complete_overrides,
        help="Override a scenario key; may be repeated.",
    ),
]
Over = Annotated[
    list[str] | None,
    typer.Option(
        "--over",
        metavar="KEY=VALUES",
        autocompletion=complete_overrides,
        help="Sweep over a key, FROM:TO:STEP or A,B,...; may be repeated. In place of the "
        "sweep block.",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="DIR",
        help="Output folder, or of several scenarios the one above theirs; default: "
        "`out/<name>`.",
    ),
]
NamedOut = Annotated[
    Path | None,
    typer.Option(
        "--out", "-o", metavar="DIR", help="Output folder; default: `out/<name>-<command>`."
    ),
]
Approach = Annotated[
    str | None,
    typer.Option(
        "--approach",
        metavar="NAME",
        autocompletion=complete_approaches,
        help="Solution approach (solver.approach).",
    ),
]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Check everything, compute nothing.")]
Strict = Annotated[
    bool, typer.Option("--strict", help="Count warnings and skipped checks as failures.")
]
StrictWarnings = Annotated[
    bool, typer.Option("--strict", help="Count warnings as failures (exit code 1).")
]
Junit = Annotated[
    Path | None,
    typer.Option("--junit", metavar="FILE", help="Write what passes and fails as JUnit XML."),
]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Write no pictures.")]
Report = Annotated[bool, typer.Option("--report", help="Write report.html, too.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object instead of the summary.")
]
Workers = Annotated[
    int | None,
    typer.Option("--workers", min=1, metavar="N", help="Workers; default: one per processor."),
]
SeedWorkers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        min=1,
        metavar="N",
        help="Workers for several seeds; default: one per processor.",
    ),
]
SeedResume = Annotated[
    bool, typer.Option("--resume", help="Continue an interrupted run of several seeds.")
]
Resume = Annotated[bool, typer.Option("--resume", help="Continue an interrupted sweep.")]
DesignResume = Annotated[
    bool, typer.Option("--resume", help="Continue an interrupted design study.")
]
FitResume = Annotated[bool, typer.Option("--resume", help="Continue an interrupted fit.")]
Compared = Annotated[
    list[str],
    typer.Argument(
        metavar="A vs B [vs C ...] [FILE]",
        autocompletion=complete_compared,
        help="Approaches or friction laws; the last is the reference, viscous is added. Then "
        "the scenario (YAML), if it is not the only one of this folder.",
    ),
]
ScenarioOption = Annotated[
    str | None,
    typer.Option(
        "--scenario",
        "-s",
        metavar="FILE",
        help="Scenario; default: ./scenario.yaml, else the only one of this folder, else the "
        "gallery's.",
    ),
]
Quiet = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", help="Print only errors, failed checks and what is discarded."
    ),
]
Format = Annotated[
    Literal["text", "json", "github"], typer.Option("--format", help="Output format.")
]
PictureFormat = Annotated[
    Literal["png", "svg", "pdf"],
    typer.Option("--picture-format", help="File format of the pictures."),
]
Table = Annotated[
    Literal["csv", "parquet"],
    typer.Option("--format", help="File format of the cases; parquet needs pyarrow."),
]
Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="ADDRESS",
        help="Dask scheduler, tcp://HOST:PORT or tls://HOST:PORT; `local`: local processes.",
    ),
]
TlsCa = Annotated[
    Path | None,
    typer.Option("--tls-ca-file", metavar="FILE", help="CA certificate for tls:// (PEM)."),
]
TlsCert = Annotated[
    Path | None,
    typer.Option("--tls-cert", metavar="FILE", help="Own certificate for tls:// (PEM)."),
]
TlsKey = Annotated[
    Path | None,
    typer.Option("--tls-key", metavar="FILE", help="Private key of that certificate (PEM)."),
]
Name = Annotated[
    str | None,
    typer.Argument(
        metavar="NAME",
        autocompletion=complete_gallery,
        help="Gallery scenario; with --new or --from, the name of the file.",
    ),
]
FromRecord = Annotated[
    str | None,
    typer.Option("--from", metavar="RECORD", help="Draft a scenario for a measured record."),
]
New = Annotated[
    bool,
    typer.Option(
        "--new", help="Write a scenario to fill in, with the meaning of each key in comments."
    ),
]
Show = Annotated[
    bool, typer.Option("--list", help="List the gallery; with `hard`, the hard cases.")
]
OptionalFile = Annotated[
    str | None,
    typer.Argument(metavar="FILE", help="Scenario (YAML); default: two of the gallery."),
]
Repeats = Annotated[
    int, typer.Option("--repeats", min=1, metavar="N", help="Maximum number of runs per entry.")
]
Samples = Annotated[
    int,
    typer.Option("--samples", min=1, metavar="N", help="Maximum number of samples per run."),
]
Patience = Annotated[
    float | None,
    typer.Option(
        "--patience",
        min=1e-3,
        metavar="SECONDS",
        help=f"Time limit per run, default {RUN_TIME_LIMIT:g}: slower entries run on fewer "
        f"samples. With --hard, default {HARD_TIME_LIMIT:g}: slower runs fail.",
    ),
]
Peers = Annotated[
    bool, typer.Option("--peers/--no-peers", help="Include the integrators of scipy.")
]
Steady = Annotated[
    bool, typer.Option("--steady", help="Measure the steady states of a sweep instead.")
]
Hard = Annotated[
    bool, typer.Option("--hard", help="Run every approach on the hard cases instead.")
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of drysim.")]
ReportFile = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="FILE", help="The page; default: DIR/report.html."),
]
ReportNoPlots = Annotated[bool, typer.Option("--no-plots", help="No pictures.")]


EXAMPLES = {
    "init": ("init seat-on-em1", "init --new seat"),
    "run": (
        "run seat-on-em1.yaml",
        "run seat-on-em1.yaml --set friction.kinetic=30 -o out/soft --report",
    ),
    "sweep": (
        "sweep paper-random.yaml",
        "sweep seat-on-em1.yaml --over friction.kinetic=0:100:10",
    ),
    "compare": (
        "compare signum vs stick-slip",
        "compare dahl vs coulomb friction-laws.yaml --report",
    ),
    "fit": ("fit fit-seat.yaml", 'fit fit-seat.yaml --set "fit.hold_out=50 %" --report'),
    "assess": (
        "assess assess-seat.yaml --report",
        'assess assess-seat.yaml --set "measure.exposure=6 h"',
    ),
    "design": (
        "design design-seat.yaml",
        'design design-seat.yaml --set "design.within=[x_r_peak < 25 mm]"',
    ),
    "branches": (
        "branches coexisting-motions.yaml",
        "branches bumper-resonance.yaml --set oscillator.damping=100",
    ),
    "map": ("map regime-map.yaml", "map regime-map.yaml --set friction.static_ratio=1.3"),
    "validate": ("validate seat-on-em1.yaml", "validate --strict --format github *.yaml"),
    "summarise": ("summarise out/seat-on-em1", "summarise out/seat-on-em1 --json"),
    "report": ("report out/seat-on-em1", "report out/seat-on-em1 --out seat.html"),
    "bench": ("bench", "bench paper-random.yaml --no-peers"),
    "schema": ("schema > scenario.schema.json", "schema | grep -n natural_frequency"),
    "doctor": ("doctor", "doctor && drysim run seat-on-em1.yaml"),
    "manual": ("manual --list", "manual seat"),
    "explain": ("explain friction.law", 'explain "ISO 7096"'),
}
"""Two examples of each command, for the end of its help."""

PAGES = {
    "init": "gallery", "run": "first-run", "validate": "ci", "summarise": "files",
    "bench": "speed", "schema": "scenario", "doctor": "first-run", "manual": "symbols",
    "explain": "keys",
}  # fmt: skip
"""Pages of the manual on the commands that have no page of their own name."""


def help_end(command: str) -> str:
    """Return the end of the help of a command: examples, and its page of the manual."""
    lines = "".join(f"\n  drysim {example}" for example in EXAMPLES[command])
    files = " (`drysim init NAME` writes the scenarios)" if ".yaml" in lines else ""
    page = PAGES.get(command, command)
    # \b keeps the lines of a paragraph as they are.
    return f"\b\nExamples{files}:{lines}\n\nMore: drysim manual {page}"


def overrides(
    changes: list[str] | None, approach: str | None = None, over: list[str] | None = None
) -> list[str]:
    """Return the `--set` arguments, with `--approach` and `--over` as such arguments.

    Raises
    ------
    UsageError
        If an `--over` has no values, its key is named twice, or `--set` sets the sweep, too.
    """
    from drysim.scenario.axes import SWEEP_KEY
    from drysim.yaml_document import OptionOverride

    keys = [word.partition("=")[0].strip() for word in changes or []]
    if over and (swept := [key for key in keys if key.split(".")[0] == SWEEP_KEY]):
        raise UsageError(
            f"--over makes the sweep block, which --set {swept[0]} would change",
            "give all its keys by --over, or the whole block by --set",
        )
    assignments = [*sweep_overrides(over or []), *(changes or [])]
    if approach is not None:
        assignments.append(
            OptionOverride(f"solver.approach={approach}", f"--approach {approach}")
        )
    return assignments


def sweep_overrides(over: list[str]) -> Iterator[str]:
    """Yield the `--over` arguments as overrides: the first makes the sweep block."""
    from drysim.scenario.axes import FILE_KEY, SWEEP_KEY
    from drysim.units import NUMBER_PATTERN, is_known_unit
    from drysim.yaml_document import OptionOverride

    keys: list[str] = []
    for word in over:
        key, _, text = (part.strip() for part in word.partition("="))
        values = sweep_values(text)
        if not key or not values:
            hint = "write KEY=FROM:TO:STEP or KEY=A,B,..., such as `friction.kinetic=0:100:10`"
            raise UsageError(
                f"--over {word} {values_fault(text) if key else 'has no key'}", hint
            )
        if values == text and key != FILE_KEY and not text.startswith(("{", "[")):
            several = "several are FROM:TO:STEP or A,B,..."
            number = NUMBER_PATTERN.match(text)
            if number and (unit := text[number.end() :]) and not is_known_unit(unit):
                raise UsageError(f"--over {word}: `{text}` is not a number", several)
            hint = f"`--set {key}={text}` sets it; {several}"
            raise UsageError(f"--over {word} has a single value", hint)
        if key in keys:
            raise UsageError(f"--over names {key} twice", "give all its values at once")
        block = f"{SWEEP_KEY}.{key}={values}" if keys else f"{SWEEP_KEY}={{{key}: {values}}}"
        keys.append(key)
        yield OptionOverride(block, f"--over {word}")


def values_fault(text: str) -> str:
    """Return what the values of an `--over` lack, as the end of a sentence."""
    if not text:
        return "has no values"
    parts = [*text.split(":"), ""]
    if len(parts) > 4:
        return "has more than FROM:TO:STEP"
    pairs = zip(("FROM", "TO", "STEP"), parts, strict=False)
    return f"has no {join_words([name for name, part in pairs if not part.strip()])}"


def sweep_values(text: str) -> str:
    """Return the values of an `--over` as the sweep block has them; empty for no values."""
    if text.startswith(("{", "[")):
        return text
    if "," in text:
        return f"[{text}]"
    ends = text.split(":")
    if len(ends) == 1:
        return text
    low, high, step = ends if len(ends) == 3 else ("", "", "")
    return f"{{from: {low}, to: {high}, step: {step}}}" if low and high and step else ""
