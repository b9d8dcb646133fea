"""Report of a result: one page of HTML that says what was computed, how good it is, and why.

The page needs nothing but itself: no script, no style sheet, no picture from elsewhere. Its
text comes from the content of drysim.json and from the tables that the console and `drysim
explain` show, its pictures from the result. A command with `--report` has the result. `drysim
report FOLDER` solves the scenario.yaml of the folder again, because that is exact, reproducible
and independent of the format of the other files, and because a result that is found a second
time is more credible: the page says how far the numbers agree. Where this is impossible, as
without the record, the page says why it has no pictures.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence, Sized
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from unicodedata import category

from pydantic import BaseModel, ConfigDict, ValidationError

import drysim
from drysim import output, wording
from drysim.approach import EXACT
from drysim.console import branches as branches_summary
from drysim.console import design as design_summary
from drysim.console import fit as fit_summary
from drysim.console import many, summaries
from drysim.console import regimes as map_summary
from drysim.console.summaries import SummaryRow
from drysim.errors import EXIT_INTERRUPTED, DrysimError, OutputError, UsageError
from drysim.manual.words import APPROACH, DESIGN, FIT, TERMS, WARNING, entries, explain
from drysim.metrics.table import METRICS_BY_NAME
from drysim.metrics.text import format_metric_ranges, format_metrics
from drysim.output.folder import (
    AGAIN_HINT,
    MARKER,
    REPORT_FILE,
    SCENARIO_FILE,
    read_sidecar,
    translate_damage,
)
from drysim.output.sidecar import Provenance
from drysim.study import branches, compare, design, ensemble, fit, regimes, sweep
from drysim.study.branches import BranchesResult
from drysim.study.case import prepare
from drysim.study.compare import Comparison
from drysim.study.design import DesignResult
from drysim.study.ensemble import Ensemble
from drysim.study.fit import FitResult
from drysim.study.outcome import Outcome
from drysim.study.regimes import RegimeMap
from drysim.study.table import Table
from drysim.system import NotARegularFile, file_sha256
from drysim.wording import format_count, format_number
from drysim.yaml_document import dump

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

Fields = dict[str, Any]
Lines = Iterator[tuple[str, str]]
Advance = Callable[[int], None]
AnyResult = Any
"""Outcome, Ensemble, Table, Comparison, FitResult, DesignResult or RegimeMap."""

TEMPLATE = "report.html.jinja"

ROOM, ROOM_OF_MANY = 230_000, 700_000
"""Sizes [B] of all pictures of a case and of many cases or samples; above, they get coarser."""

SYMBOLS = ("m, k_x, b", "f_0, ξ", "F_fk", "F_fs", "x_r", "ü", "T_a")
"""Symbols that the page explains, those of one meaning together."""

MAX_SCENARIO, MAX_LISTED = 100_000, 300
"""Characters of the scenario and number of files or records that the page shows."""

CAPTIONS = {
    "response": "Motion: accelerations of base and mass, relative displacement, and the force "
    "of the contact over it",
    "spectra": "Spectra of base and mass, and the transmissibility between them",
    "bands": "Accelerations of base and mass in one-third-octave bands",
    "ensemble": "Share of the seeds below a value, and the mean over the number of seeds",
    "transmissibility": "Transmissibilities of the cases",
    "stroke": "Largest relative displacement of the cases, and its limit",
    "srs": "Shock response spectra: peak acceleration and stroke over the natural frequency",
    "comparison": "Motion where the first approach has its largest error, and transmissibility "
    "of all",
    "fit": "Measured and fitted motion, and the residuals between them",
    "design": "Objective of the designs over the varied keys, or front of two objectives",
    "map": "Regimes of the steady motion over two keys, and the boundaries between them",
    "branches": "All periodic motions along the key: stable ones solid, unstable ones dashed",
    "profiles": "Rise of the sum of squares over each fitted value",
}
"""What a picture shows."""

SKETCH_CAPTION = "Model"

WHY = "“Why to believe it”"
"""The part of the page on files and numbers."""

LEGENDS = {"design": DESIGN, "fit": FIT}
"""Words of a summary that the page explains, by kind of result."""


# Kinds of result.


class Kind(NamedTuple):
    """A kind of result.

    Attributes
    ----------
    what : str
    of : type
        Class of the result.
    room : int
        Size of all its pictures, above which their detail is reduced [B].
    scene : callable
        Yields label and sentence: what was solved, and how.
    rows : tuple of callable
        Each yields some of the main results.
    """

    what: str
    of: type
    room: int
    scene: Callable[[AnyResult], Lines]
    rows: tuple[Callable[[AnyResult], Iterator[SummaryRow]], ...]


KINDS = {
    "run": Kind(
        "one case",
        Outcome,
        ROOM,
        summaries.run_scene,
        (summaries.run_rows,),
    ),
    "ensemble": Kind(
        "one case under many seeds",
        Ensemble,
        ROOM,
        many.ensemble_scene,
        (many.ensemble_rows,),
    ),
    "sweep": Kind(
        "a sweep",
        Table,
        ROOM_OF_MANY,
        many.sweep_scene,
        (many.table_rows,),
    ),
    "comparison": Kind(
        "a comparison",
        Comparison,
        ROOM_OF_MANY,
        many.comparison_scene,
        (many.worst_rows,),
    ),
    "fit": Kind(
        "a fit",
        FitResult,
        ROOM_OF_MANY,
        fit_summary.fit_scene,
        (fit_summary.parameter_rows, fit_summary.quality_rows, fit_summary.law_rows),
    ),
    "design": Kind(
        "a design study",
        DesignResult,
        ROOM_OF_MANY,
        design_summary.result_scene,
        (design_summary.best_rows, design_summary.front_rows, design_summary.variant_rows),
    ),
    "map": Kind(
        "a regime map",
        RegimeMap,
        ROOM_OF_MANY,
        map_summary.result_scene,
        (map_summary.share_rows, map_summary.place_rows),
    ),
    "branches": Kind(
        "branches of periodic motions",
        BranchesResult,
        ROOM_OF_MANY,
        branches_summary.branches_scene,
        (
            branches_summary.motion_rows,
            branches_summary.branch_rows,
            branches_summary.bifurcation_rows,
        ),
    ),
}
"""The kinds of result that have a report, by name."""


def kind_of(fields: Fields) -> str:
    """Return the name of the kind of a result, by its drysim.json."""
    numerics = fields["numerics"]
    if found := next(
        (name for name in ("fit", "design", "map", "branches") if name in fields), ""
    ):
        return found
    if "ensemble" in fields:
        return "ensemble"
    if "yardstick" in numerics:
        return "comparison"
    return "sweep" if "swept" in numerics else "run"


def solve(
    kind: str, scenario: Scenario, compared: Sequence[str], advance: Advance
) -> AnyResult:
    """Solve the scenario of a result as its command did; `compared` names what it compared."""

    def count(batch: Sized) -> None:
        advance(len(batch))

    match kind:
        case "ensemble":
            return ensemble.solve(prepare(scenario), finished=count)
        case "sweep":
            return sweep.sweep(scenario, finished=count)
        case "comparison":
            return compare.compare(scenario, compared, finished=count)
        case "fit":
            return fit.fit(scenario, finished=advance)
        case "design":
            case = design.prepare_design(scenario)
            with sweep.on_workers(None) as execute:
                return design.Study(case, execute, None, advance).solve()
        case "map":
            return regimes.solve(regimes.prepare_map(scenario), advance=advance)
        case "branches":
            return branches.branches(scenario)
    return ensemble.run(scenario)


def compared_names(fields: Fields) -> list[str]:
    """Return what a comparison compared: the reference is the last, `viscous` was added."""
    numerics = fields["numerics"]
    names: list[str] = numerics.get("approaches", [])
    return names[: names.index(numerics["yardstick"]) + 1] if names else []


# The page.


class Note(NamedTuple):
    """A finding on the files or the numbers of a result, and whether it speaks for them."""

    good: bool
    label: str
    sentence: str


def report(
    result: Outcome | Ensemble | Table | Comparison | FitResult | DesignResult | RegimeMap,
) -> str:
    """Return the report of a result: one page of HTML that needs no other file.

    Parameters
    ----------
    result : Outcome, Ensemble, Table, Comparison, FitResult, DesignResult or RegimeMap
        Of `run`, `sweep`, `compare`, `fit`, `design` or `map_regimes`.

    Returns
    -------
    str
        The page, to be written as UTF-8.

    Raises
    ------
    UsageError
        When `result` is something else.
    """
    kind = next((name for name, one in KINDS.items() if isinstance(result, one.of)), None)
    if kind is None:
        sentence = f"a report needs a result, not {type(result).__name__}"
        raise UsageError(
            sentence,
            "pass what drysim.run, sweep, compare, fit, design or map_regimes returned",
        )
    judged = result.table if isinstance(result, Comparison) else result
    fields = output.KINDS[kind].to_fields(result, Provenance("", judged.exit_code(), {}))
    scenario = output.scenario_of(kind, result)
    return page(fields, dump(scenario.resolved()), scenario, result)


def page_of(plots: bool, result: AnyResult, fields: Fields, folder: Path) -> str:
    """Return the page of a result whose files are in a folder."""
    text = (folder / SCENARIO_FILE).read_text(encoding="utf-8")
    scenario = output.scenario_of(kind_of(fields), result)
    return page(fields, text, scenario, result, plots=plots)


def page(
    fields: Fields,
    scenario_text: str,
    scenario: Scenario | None,
    result: AnyResult | None,
    *,
    plots: bool = True,
    notes: Sequence[Note] = (),
    missing: str = "",
) -> str:
    """Return the page of a result.

    Parameters
    ----------
    fields : dict
        The content of drysim.json.
    scenario_text : str
        The content of scenario.yaml.
    scenario : Scenario, optional
        The same, if it can be read.
    result : optional
        Outcome, Ensemble, Table, Comparison, FitResult, DesignResult or RegimeMap:
        what the pictures show.
    plots : bool, optional
        Whether to draw pictures.
    notes : sequence of Note, optional
        What was found when the files and the numbers of the result were checked.
    missing : str, optional
        Why there are no pictures.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    name = kind_of(fields)
    kind = KINDS[name]
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=visible,
        keep_trailing_newline=True,
    )
    environment.filters["code"] = code
    found, varied = content(fields), [*summaries.swept_units(fields)]
    if result is not None:
        found["scene"] = list(kind.scene(result))
    elif "design" in fields:
        varied += fields["design"]["vary"]
    rows = [] if result is None else main_rows(kind, result)
    state, lines = judge(fields, getattr(result, "is_useless", False), notes)
    return environment.get_template(TEMPLATE).render(
        **found,
        fields=fields,
        files=[name for name in fields["files"] if name != REPORT_FILE],
        version=drysim.__version__,
        what=kind.what,
        about=scenario.about if scenario else "",
        symbols=[(words, meanings(words.partition(",")[0])) for words in SYMBOLS],
        most=MAX_LISTED,
        state=state,
        mark=MARKS[state],
        verdict=lines,
        rows=rows,
        legend=legend([row for row, _ in rows], LEGENDS.get(name, "")),
        comparison=comparison_table(result),
        notes=notes,
        sketch=sketch(getattr(result, "scenario", scenario), varied) if plots else None,
        pictures=list(pictures(name, result)) if plots and result is not None else [],
        missing=missing,
        scenario_text=scenario_text[:MAX_SCENARIO],
        is_cut=len(scenario_text) > MAX_SCENARIO,
    )


def content(fields: Fields) -> Fields:
    """Return what a page shows of drysim.json, as variables of the template."""
    return {
        "checks": [
            (summaries.check_mark(passed)[0], words)
            for passed, words in summaries.sidecar_checks(fields)
        ],
        "scene": list(summaries.sidecar_scene(fields)),
        "conditions": summaries.sidecar_conditions(fields) if "design" in fields else [],
        "metrics_of": summaries.describe_metrics(fields),
        "metrics": list(metric_tables(fields)),
        "evidence": list(evidence(fields)),
        "warnings": list(warnings_by_slug(fields)),
    }


def code(text: str) -> Any:
    """Return text with what is in backticks as HTML elements of code."""
    from markupsafe import Markup, escape

    return Markup(re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(visible(text)))))


SPACE = "Zs"
"""Unicode category of spaces, also those that do not break a line."""


def visible(value: Any) -> Any:
    """Return text with its control characters, also those of direction, as escape sequences."""
    if type(value) is not str:  # markup of the page itself stays
        return value
    return "".join(
        one
        if one.isprintable() or one == "\n" or category(one) == SPACE
        else one.encode("unicode_escape").decode()
        for one in value
    )


GOOD, RESERVED, OPEN, BAD = "good", "reserved", "open", "bad"
MARKS = {GOOD: "✓", RESERVED: "!", OPEN: "·", BAD: "✗"}
"""States of a result: its checks hold, they hold but something speaks against relying on that,
it states no requirement, it fails."""


def judge(
    fields: Fields, is_useless: bool = False, notes: Sequence[Note] = ()
) -> tuple[str, list[str]]:
    """Return the state of a result, and the sentences that say why.

    A warning or a note that speaks against the result is a reservation, as with `--strict`.
    """
    faults, reservations = [], []
    if is_useless:
        faults.append("The fitted motion is not the measured one: its values mean nothing.")
    if not fields["complete"]:
        scene = dict(summaries.sidecar_scene(fields))
        lost = scene.get("failed") or scene.get("cases", "")
        faults.append(f"The result is incomplete: the numerics failed in some cases ({lost}).")
    checks = [passed for passed, _ in summaries.sidecar_checks(fields)]
    failed, skipped = checks.count(False), checks.count(None)
    every = format_count(len(checks), "check")
    words = (
        "The scenario has no checks, so it states no requirement: whether the numbers are "
        "good enough is for the reader to decide."
    )
    if failed:
        verb = "fails" if failed == 1 else "fail"
        words = f"{failed} of {every} {verb}: the result does not meet its requirements."
        faults.append(words)
    elif skipped:
        reservations.append(f"{skipped} of {every} could not be judged")
        words = "The others hold." if skipped < len(checks) else "No check was judged."
    elif checks:
        of_many = "Both checks hold" if len(checks) == 2 else f"All {every} hold"
        holds = "The check holds" if len(checks) == 1 else of_many
        words = f"{holds}: the result meets the requirements of its scenario."
    if fields["warnings"]:
        slugs = ", ".join(dict.fromkeys(one["slug"] for one in fields["warnings"]))
        count = format_count(len(fields["warnings"]), "warning")
        reservations.append(f"{count} ({slugs}), explained below")
    objections = [note.sentence for note in notes if not note.good]
    reservations += [f"files or numbers differ, see {WHY}"] * bool(objections)
    lines = [*faults, *([] if failed else [words])]
    if reservations and not faults:
        passed = "Passed, with reservations" if checks else "No verdict, and reservations"
        lines.insert(0, f"{passed}: {'; '.join(reservations)}.")
    elif reservations:
        lines.append(f"Besides: {'; '.join(reservations)}.")
    else:
        lines.append("No warnings.")
    state = GOOD if checks else OPEN
    state = BAD if faults else RESERVED if reservations else state
    return state, [*lines, *answers(fields), *objections]


def answers(fields: Fields) -> Iterator[str]:
    """Yield what a result found, as sentences."""
    if "design" in fields:
        words = summaries.sidecar_design(fields["design"])
        yield f"Best design: {words}." if fields["design"]["best"] else f"{words}."
    elif "map" in fields:
        yield from summaries.sidecar_map(fields["map"])
    elif "branches" in fields:
        yield summaries.sidecar_branches(fields["branches"])
    else:
        yield from main_numbers(fields)
    yield from fields.get("verdict", ())
    if "best" in fields:
        for name, words in summaries.sidecar_best(fields):
            yield f"{name}: {words}"


def main_numbers(fields: Fields) -> Iterator[str]:
    """Yield the main numbers of a case, a sweep or a fit as sentences."""
    metrics = fields["metrics"]
    for name in ("fit_error", "fit_error_held_out"):
        if isinstance(error := metrics.get(name), int | float):
            about = meaning_of_metric(name)
            yield f"{name} {wording.format_percent(error)}: {about}."
    if isinstance(T_a := metrics.get("T_a"), int | float):
        effect = "above 1: its mount amplifies" if T_a > 1 else "below 1: its mount isolates"
        if T_a == 1:
            effect = "1: its mount neither amplifies nor isolates"
        yield f"{format_metrics(metrics)}. T_a of the mass is {effect}."
    elif isinstance(metrics.get("x_r_peak"), int | float):
        yield f"{format_metrics(metrics)}."
    elif kind_of(fields) == "sweep":
        ends = {
            name: (found["least"]["value"], found["greatest"]["value"])
            for name, found in metrics.items()
        }
        yield f"Over all cases: {format_metric_ranges(ends)}."


def main_rows(kind: Kind, result: AnyResult) -> list[tuple[SummaryRow, str]]:
    """Return the rows of the summary, each with the meaning of its metric or key."""
    keys = [one.key for one in getattr(result, "parameters", ())]
    of_key = {wording.short_key(key, keys): meanings(key) for key in keys}
    return [
        (row, of_key.get(row.name, "") or meaning_of_metric(TERMS.get(row.name, row.name)))
        for rows in kind.rows
        for row in rows(result)
    ]


def legend(rows: Sequence[SummaryRow], kind: str) -> list[tuple[str, str]]:
    """Return the words of a kind that occur in rows of a summary, with their meanings."""
    names = {re.sub("[+-](?=[0-9])", "±", row.name) for row in rows}
    text = " ".join(f"{row.value} {row.remark}" for row in rows)
    return [
        (one.word, one.text)
        for one in entries()
        if one.kind == kind and (one.word in names or one.word in text)
    ]


def meaning_of_metric(name: str) -> str:
    """Return the meaning of a metric; empty for another word."""
    return METRICS_BY_NAME[name].about if name in METRICS_BY_NAME else ""


def meanings(word: str, kind: str = "") -> str:
    """Return what `drysim explain` says about a word, or about a word of that kind."""
    texts = (one.text for one in explain(word) if kind in ("", one.kind))
    return " ".join(dict.fromkeys(texts))


def comparison_table(result: AnyResult | None) -> list[tuple[str, ...]]:
    """Return the table of approaches of a comparison by rows, header first."""
    if result is None or not hasattr(result, "yardstick"):
        return []
    return list(zip(*many.comparison_columns(result), strict=True))


def warnings_by_slug(fields: Fields) -> Iterator[tuple[str, str, list[str], int]]:
    """Yield slug, meaning, the first sentences of the warnings and how many more there are."""
    counts = Counter(one["slug"] for one in fields["warnings"])
    for slug, count in counts.items():
        sentences = [one["sentence"] for one in fields["warnings"] if one["slug"] == slug]
        shown = sentences[: summaries.MAX_ALIKE]
        yield slug, meanings(slug, WARNING), shown, count - len(shown)


def metric_tables(fields: Fields) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield approach and table of metrics in SI units by rows, with their meanings."""
    found = fields.get("ensemble", fields)["metrics"]
    for approach, metrics in summaries.metric_tables(found):
        rows = list(zip(*summaries.metric_columns(metrics), strict=True))
        if not rows:  # of a damaged result
            continue
        header = [*rows[0], "meaning"]
        yield approach, [header, *([*row, meaning_of_metric(row[0])] for row in rows[1:])]


def evidence(fields: Fields) -> Lines:
    """Yield label and sentence: why to believe the numbers."""
    numerics, metrics = fields["numerics"], fields["metrics"]
    if approach := numerics.get("approach") or numerics.get("yardstick") or "":
        yield "approach", f"{approach}. {meanings(approach, APPROACH)}"
    if "method" in numerics:
        yield "method", numerics["method"]
    if "starts" in numerics:
        agree, total = (numerics["starts"][name] for name in ("agree", "total"))
        yield "starts", f"{agree} of {total} starting points led to this solution."
    if why := numerics.get("why"):
        yield "core", f"{numerics['core']}: {why}."
    residual = numerics.get("energy_residual", metrics.get("energy_residual"))
    if residual is not None:
        words = f"{format_number(residual, digits=2)}: {meaning_of_metric('energy_residual')}. "
        yield (
            "energy residual",
            words
            + "Work of the base, dissipation and stored energy are integrated separately, "
            "so that a motion that turns or slides against its law would show here; rounding "
            "alone leaves about 1e-15.",
        )
    residual = numerics.get("law_residual", metrics.get("law_residual"))
    if residual is not None:
        words = f"{format_number(residual, digits=2)}: {meaning_of_metric('law_residual')}."
        yield "law residual", words
    if numerics.get("events") is not None:
        how = "located within the steps, so that there is no time-step error"
        if approach != EXACT:
            how = "found at the end of the steps, which limits the accuracy"
        yield (
            "events",
            f"{format_count(numerics['events'], 'event')} (stops, break-aways, reversals) over "
            f"{format_count(numerics['steps'], 'step')} of the output grid, {how}.",
        )
    if (margin := numerics.get("closest_decision")) is not None:
        yield (
            "closest decision",
            f"{format_number(margin, digits=2)}: smallest relative margin between the contact "
            "force and the static limit where stick or slip was decided; below 1e-6 a small "
            "change of the input could change the answer, and a warning says so.",
        )
    if (closure := numerics.get("closure")) is not None:
        about = meaning_of_metric("closure")
        yield "closure", f"{format_number(closure, digits=2)}: {about}."
    if (distance := numerics.get("distance")) is not None:
        about = "estimated distance of the motion to its periodic orbit, scaled as the closure"
        yield "distance to the orbit", f"{format_number(distance, digits=2)}: {about}."
    if (error := numerics.get("error")) is not None:
        what = "estimated error of x_r, relative to its peak"
        yield "error", f"{format_number(error, digits=2)}: {what}."
    if statuses := numerics.get("statuses"):
        cases = ", ".join(f"{count} {status}" for status, count in statuses.items())
        yield "cases", f"{cases}."
    if engine := numerics.get("engine"):
        other = {"plain": "compiled", "compiled": "plain"}.get(engine, "other")
        yield (
            "engine",
            f"{engine}. The same source runs as plain Python and compiled; the tests of drysim "
            f"require that the {other} engine gives the same numbers.",
        )


# Pictures.


def pictures(kind: str, result: AnyResult) -> Iterator[tuple[str, Any]]:
    """Yield caption and SVG element of every picture of a result."""
    from markupsafe import Markup

    from drysim.plots.svg import inline_svg

    whole = room = KINDS[kind].room
    for name, draw in output.pictures_of(kind, result):
        found = inline_svg(draw, f"{name}-", CAPTIONS[name], min(room, whole // 2))
        if found is not None:
            room -= len(found.encode())
            yield CAPTIONS[name], Markup(found)


def sketch(scenario: Scenario | None, varied: Collection[str]) -> Any:
    """Return the sketch of the model as an SVG element, None for a scenario without values."""
    if scenario is None or scenario.fit is not None:
        return None
    from markupsafe import Markup

    from drysim.plots.sketch import draw
    from drysim.plots.svg import inline_svg

    plant, law = scenario.oscillator.plant(), scenario.law()
    description = "; ".join(
        words for _, words in wording.describe_scene(scenario, plant, law, varied)
    )
    figure = partial(draw, scenario, varied)
    title = f"{SKETCH_CAPTION}: {description}"
    return Markup(inline_svg(figure, "model-", title, ROOM))


# A result on the disk.


class _Origin(BaseModel):
    name: str
    file: str
    sha256: str | None = None
    overrides: dict[str, Any] = {}


class _Input(BaseModel):
    file: str
    sha256: str
    size: int


class _Check(BaseModel):
    check: str
    passed: bool | None
    value: float | None


class _Warning(BaseModel):
    slug: str
    sentence: str


class Stored(BaseModel):
    """What a report needs of drysim.json, with its types."""

    model_config = ConfigDict(strict=True)

    version: str
    command: str
    created: str
    complete: bool
    exit_code: int
    scenario: _Origin
    inputs: list[_Input]
    excitation: dict[str, Any]
    numerics: dict[str, Any]
    software: dict[str, str]
    metrics: dict[str, float | int | dict[str, Any] | None]
    checks: list[_Check]
    warnings: list[_Warning]
    files: dict[str, str]


def read_result(folder: Path) -> Fields:
    """Read the drysim.json of a finished result that has a report.

    Raises
    ------
    OutputError
        When the folder has none, it is damaged, or the result is not finished.
    """
    fields, file = read_sidecar(folder), folder / MARKER
    if fields.get("exit_code") == EXIT_INTERRUPTED:
        raise OutputError(f"{folder} is not finished", "finish it with --resume")
    with translate_damage(folder):
        try:
            Stored.model_validate(fields)
        except ValidationError as fault:
            first = fault.errors()[0]
            place = ".".join(map(str, first["loc"]))
            sentence = f"{file} is damaged: {place}: {first['msg'].lower()}"
            raise OutputError(sentence, AGAIN_HINT) from fault
        # All that a report takes of the file is taken here once, so that no value of a wrong
        # type or size is found later, where it could not be told from a fault of the program.
        content(fields), judge(fields), [*numbers(fields["metrics"])], compared_names(fields)
    return fields


def count_parts(fields: Fields) -> int:
    """Return the number of cases, seeds or starts that are solved again for a report."""
    numerics = fields["numerics"]
    count = numerics.get("starts", {}).get("total") or numerics.get("cases", 1)
    count = numerics.get("evaluations", count)
    return count if isinstance(count, int) else 1


def report_folder(
    folder: Path,
    fields: Fields,
    *,
    plots: bool = True,
    advance: Advance = lambda count: None,
) -> tuple[str, list[str]]:
    """Return the report of a result on the disk, and what is wrong with its files or numbers.

    Parameters
    ----------
    folder : Path
    fields : dict
        Of `read_result`.
    plots : bool, optional
        Whether to solve the scenario again and to draw pictures.
    advance : callable, optional
        Called with the number of cases, seeds or starts that are done.

    Raises
    ------
    OutputError
        When scenario.yaml is not the one that drysim wrote.
    """
    file = folder / SCENARIO_FILE
    if file.exists() and not file.is_file():
        raise OutputError(f"cannot read {file}: it is not a plain file", AGAIN_HINT)
    try:
        original = file.read_bytes()
    except OSError as fault:
        reason = (fault.strerror or str(fault)).lower()
        raise OutputError(f"cannot read {file}: {reason}", AGAIN_HINT) from fault
    if hashlib.sha256(original).hexdigest() != fields["files"].get(SCENARIO_FILE):
        raise OutputError(f"{file} was edited since drysim wrote it", AGAIN_HINT)
    notes = [note_on_files(folder, fields)]
    scenario, result, missing = None, None, ""
    kind = kind_of(fields)
    try:
        scenario = drysim.load(file)
        if plots:
            result = solve(kind, scenario, compared_names(fields), advance)
    except DrysimError as fault:
        reason = str(fault).splitlines()[-1]
        missing = f"There are no pictures: the scenario cannot be solved again. {reason}"
    if result is not None:
        provenance = Provenance(fields["command"], fields["exit_code"], fields["files"])
        again = output.KINDS[kind].to_fields(result, provenance)
        if changed := changed_inputs(fields, again):
            result = None
            missing = f"There are no pictures: {changed} was changed since."
        else:
            notes.append(note_on_numbers(fields, again))
    text = original.decode(errors="replace")
    written = page(fields, text, scenario, result, plots=plots, notes=notes, missing=missing)
    objections = [note.sentence for note in notes if not note.good]
    return written, [*objections, *filter(None, [missing])]


def note_on_files(folder: Path, fields: Fields) -> Note:
    """Return whether all files of a result have the hashes in its drysim.json."""
    files = {name: sha for name, sha in fields["files"].items() if name != REPORT_FILE}
    found = {name: sha256_of(folder / name) for name in files}
    lost = [name for name, sha in found.items() if not sha]
    changed = [name for name, sha in found.items() if sha and sha != files[name]]
    states = {"Changed since drysim wrote them": changed, "Missing or unreadable": lost}
    if parts := [f"{state}: {', '.join(names)}." for state, names in states.items() if names]:
        return Note(False, "files", " ".join(parts))
    return Note(
        True,
        "files",
        f"All {format_count(len(files), 'file')} of the result are as drysim wrote them.",
    )


def sha256_of(file: Path) -> str:
    """Return the SHA-256 of a file, empty if it cannot be read."""
    with suppress(NotARegularFile, OSError):
        return file_sha256(file)
    return ""


def changed_inputs(fields: Fields, again: Fields) -> str:
    """Return the records that are not those of the result, empty if all are."""
    known = {one["sha256"] for one in fields["inputs"]}
    return ", ".join(one["file"] for one in again["inputs"] if one["sha256"] not in known)


ROUNDING_METRICS = {"energy_residual", "law_residual", "closure"}
"""Metrics that are nothing but rounding, and differ on another processor."""

REPRODUCED_WITHIN = 1e-6
"""Relative difference up to which a number counts as reproduced [-]."""


def note_on_numbers(fields: Fields, again: Fields) -> Note:
    """Return whether solving the scenario again gave the numbers in drysim.json."""
    stored, found = (dict(numbers(one["metrics"])) for one in (fields, again))
    if lost := stored.keys() - found.keys():
        names = sorted(" ".join(path) for path in lost)
        sentence = f"Solved again, the scenario has no value of {', '.join(names[:3])}."
        return Note(False, "solved again", sentence)
    largest: dict[str, float] = {}
    for path, value in stored.items():
        unit = unit_of(path)
        largest[unit] = max(largest.get(unit, 0.0), abs(value))
    worst, where = 0.0, ""
    for path, value in stored.items():
        unit = unit_of(path)
        scale = max(abs(value), abs(found[path])) if unit == "-" else largest[unit]
        off = abs(value - found[path]) / scale if scale else abs(found[path])
        if off > worst:
            worst, where = off, " ".join(path)
    many_numbers = format_count(len(stored), "number")
    if worst > REPRODUCED_WITHIN:
        return Note(
            False,
            "solved again",
            f"Solved again by drysim {drysim.__version__}, the scenario gives other numbers: "
            f"{where} differs by {format_number(100 * worst, '%', 2)}.",
        )
    agree = f"to {format_number(worst, digits=2)}" if worst else "to the last digit"
    return Note(
        True,
        "solved again",
        f"For this report drysim {drysim.__version__} solved the scenario again: "
        f"{many_numbers} agree {agree}.",
    )


Names = tuple[str, ...]
"""Path of a number among the metrics."""


def numbers(values: Mapping[str, Any], path: Names = ()) -> Iterator[tuple[Names, float]]:
    """Yield path and value of every number among metrics, without those that are rounding."""
    for name, value in values.items():
        if name in ROUNDING_METRICS or name == "where":
            continue
        if isinstance(value, Mapping):
            yield from numbers(value, (*path, name))
        elif isinstance(value, int | float):
            yield (*path, name), float(value)


def unit_of(path: Names) -> str:
    """Return the unit of a metric, by its path among the metrics."""
    known = [METRICS_BY_NAME[name].unit for name in path if name in METRICS_BY_NAME]
    return known[0] if known else "-"
