"""Report of a result: one page of HTML that says what was computed, how good it is, and why.

The page is a view of an output folder: its text is the summary in drysim.json, its pictures are
those of the folder. It needs nothing but itself: no script, no style sheet, no picture from
elsewhere.
"""

from __future__ import annotations

import hashlib
import re
from base64 import b64encode
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple, overload
from unicodedata import category

from pydantic import BaseModel, ConfigDict

import drysim
from drysim.approach import EXACT
from drysim.console.summary import MAX_ALIKE, check_mark
from drysim.errors import EXIT_INTERRUPTED, DrysimError, OutputError
from drysim.manual.words import APPROACH, KEY, TERMS, WARNING, entries, explain
from drysim.metrics.table import ABOUT_SAMPLES, METRICS_BY_NAME, PEAK_STROKE
from drysim.output.folder import (
    AGAIN_HINT,
    MARKER,
    REPORT_FILE,
    check_report,
    note_on_files,
    read_stored_fields,
    save_file,
    translate_damage,
)
from drysim.results import KINDS, kind_named, kind_of, stored
from drysim.results.kind import PDF, PNG, SCENARIO_FILE, SVG
from drysim.scenario.text import describe_scene, short_key
from drysim.study.outcome import AnyResult
from drysim.study.summary import BAD, Note, Row, Summary, from_fields
from drysim.wording import format_count, format_number

if TYPE_CHECKING:
    from drysim.results.kind import Kind, Picture

Fields = dict[str, Any]
Lines = Iterator[tuple[str, str]]

TEMPLATE = "report.html.jinja"

MODEL_SYMBOLS = "m, k_x, b", "f_0, ξ", "F_fk", "F_fs"
SYMBOLS = "x_r", "ü", "T_a", "T_x"
"""Symbols that the page explains, those of one meaning together."""

MAX_SCENARIO, MAX_LISTED = 100_000, 300
"""Characters of the scenario and number of files or records that the page shows."""

DAMAGED = "Do not rely on this result: its files differ from those that drysim wrote."
"""Verdict on a result whose files differ from their hashes."""

KEY_ROWS, DIGIT = 6, re.compile(r"\d")
"""Main results at the top of the page: those with numbers that a user asks for."""

NUMERICAL_ROWS = ("energy", "error")
"""Rows of the main results that are evidence for the numbers."""

MAX_RESERVATIONS = 4
"""Warnings that the verdict quotes, those of different kinds first."""

# The page.


class Shown(NamedTuple):
    """A picture of the page."""

    caption: str
    source: str
    """Its content as `data:` address, or the name of a file that no page can show."""
    is_file: bool = False


@overload
def report(result: AnyResult, file: None = None) -> str: ...
@overload
def report(result: AnyResult, file: str | Path) -> Path: ...
def report(result: AnyResult, file: str | Path | None = None) -> str | Path:
    """Return the report of a result, one page of HTML that needs no other file, or write it.

    Parameters
    ----------
    result : object
        What `run`, `sweep`, `compare`, `fit`, `design`, `branches` or `map_regimes` returned.
    file : str or Path, optional
        It is replaced only if it is a report of drysim.

    Returns
    -------
    str or Path
        The page or, if it was written, the file.

    Raises
    ------
    UsageError
        When `result` is something else.
    OutputError
        When the file is no report of drysim, or cannot be written.
    """
    from drysim.output import save

    kind_of(result)
    with TemporaryDirectory(prefix="drysim-") as folder:
        out = Path(folder, "result")
        if file is not None:
            check_report(Path(file), out)
        text = (save(result, out, report=True) / REPORT_FILE).read_text(encoding="utf-8")
    if file is None:
        return text
    save_file(Path(file), text)
    return Path(file)


def page(fields: Fields, folder: Path, notes: Sequence[Note] = (), plots: bool = True) -> str:
    """Return the page of a result.

    Parameters
    ----------
    fields : dict
        The content of drysim.json.
    folder : Path
        Holds the scenario and the pictures.
    notes : sequence of Note, optional
        What was found when the files of the result were checked.
    plots : bool, optional
        Whether to show pictures.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    kind, summary = kind_named(fields["kind"]), from_fields(fields["summary"])
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
    state, verdict = judge(fields, summary, notes)
    text, varied = scenario_text(folder), varied_keys(fields)
    pictures = list(pictures_in(folder, kind, fields)) if plots else []
    rows = [(row, meaning_of_row(row, fields)) for group in summary.groups for row in group]
    parts = (summary, *summary.parts)
    tables = list(metric_tables(fields))
    # An evaluation of measurements may have none.
    has_model = fields.get("assess", {"model": True})["model"] is not None
    # A bench and the hard cases have several scenarios.
    scenarios = [case["scenario"] for case in fields.get("cases", [fields])]
    return environment.get_template(TEMPLATE).render(
        fields=fields,
        summary=summary,
        name=scenarios[0]["name"] if len(scenarios) == 1 else summary.name or kind.what,
        scenarios=scenarios,
        inputs=fields.get("inputs", []),
        excitation=fields.get("excitation", {}),
        scene=[line for part in parts for line in part.scene],
        findings=[note for part in parts for note in part.notes],
        files=[name for name in fields["files"] if name != REPORT_FILE],
        version=drysim.__version__,
        what=kind.what,
        is_sheet=kind.is_sheet,
        has_model=has_model,
        symbols=[
            (symbol, explain(symbol.partition(",")[0])[0].text)
            for symbol in (*MODEL_SYMBOLS, *SYMBOLS)
            if has_model or symbol in symbols_of_samples(fields)
        ],
        most=MAX_LISTED,
        state=state,
        mark=MARKS[state],
        verdict=verdict,
        checks=[(check_mark(passed)[0], sentence) for passed, sentence in summary.checks],
        key_rows=key_rows([row for row, _ in rows]),
        rows=rows,
        tables=[
            (title or table.title, list(zip(*table.columns, strict=True)))
            for title, part in (
                ("", summary),
                *((panel.name, panel) for panel in summary.parts),
            )
            for table in (*filter(None, [part.table]), *part.details)
            if table.columns
        ],
        legend=legend([row for row, _ in rows], kind.legend),
        notes=notes,
        sketch=sketch(folder, varied) if plots else None,
        pictures=pictures,
        metrics_about=stored.describe_metrics(fields),
        metrics=tables,
        metric_meanings=meanings_of_metrics(tables, "assess" in fields),
        evidence=list(evidence(fields)),
        warnings=list(warnings_by_slug(fields)),
        scenario_text=text[:MAX_SCENARIO],
        is_cut=len(text) > MAX_SCENARIO,
    )


def scenario_text(folder: Path) -> str:
    """Return the content of scenario.yaml; empty if there is none."""
    file = folder / SCENARIO_FILE
    with suppress(OSError):
        return file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""
    return ""


MEDIA_TYPES = {PNG: "image/png", SVG: "image/svg+xml"}
"""Media types of the pictures that a page can show."""


def pictures_in(folder: Path, kind: Kind, fields: Fields) -> Iterator[Shown]:
    """Yield the pictures of a result in its folder."""
    listed = fields["files"]
    for picture in kind.pictures:
        caption = f"{picture.caption}{picture_scope(picture, kind, fields)}"
        for form in (PNG, SVG, PDF):
            file = folder / f"{picture.name}.{form}"
            if file.name not in listed or not file.is_file():
                continue
            if form == PDF:
                yield Shown(caption, file.name, is_file=True)
                continue
            with suppress(OSError):  # the notes name a file that cannot be read
                yield Shown(caption, data_address(file, MEDIA_TYPES[form]))


def picture_scope(picture: Picture, kind: Kind, fields: Fields) -> str:
    """Return the end of a caption: which cases or seeds of the result its picture shows."""
    if "ensemble" in fields:
        if picture is not kind.pictures[0]:
            return f"; seed {fields['excitation']['seed']}"
        return f"; {format_count(fields['ensemble']['seeds'], 'seed')}"
    axes = [axis["key"] for axis in fields["numerics"].get("swept", ())]
    if not axes:
        return ""
    over = " and ".join(short_key(key, axes) for key in axes)
    approaches = ", ".join(fields["numerics"].get("approaches", ()))
    return f"; over {over}{f'; {approaches}' if approaches else ''}"


def data_address(file: Path, media_type: str) -> str:
    """Return the content of a file as a `data:` address."""
    return f"data:{media_type};base64,{b64encode(file.read_bytes()).decode()}"


def varied_keys(fields: Fields) -> set[str]:
    """Return the keys that differ between cases or designs."""
    swept = {axis["key"] for axis in fields["numerics"].get("swept", ())}
    return swept | {*fields.get("design", {}).get("vary", ())}


def sketch(folder: Path, varied: Collection[str]) -> Shown | None:
    """Return the sketch of the model; None if the scenario cannot be read or has no values."""
    from drysim.plots.sketch import draw
    from drysim.plots.style import save_picture

    try:
        scenario = drysim.load(folder / SCENARIO_FILE)
        if scenario.fit is not None or scenario.missing_blocks:
            return None
        plant, law = scenario.oscillator.plant(), scenario.law()
    except DrysimError:  # as without the record of a force
        return None
    parts = [text for _, text in describe_scene(scenario, plant, law, varied)]
    with TemporaryDirectory(prefix="drysim-") as place:
        file = Path(place, f"model.{PNG}")
        save_picture(partial(draw, scenario, varied), file)
        return Shown(f"Model: {'; '.join(parts)}", data_address(file, "image/png"))


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
        character
        if character.isprintable() or character == "\n" or category(character) == SPACE
        else character.encode("unicode_escape").decode()
        for character in value
    )


GOOD, RESERVED, OPEN, FAILED = "good", "reserved", "open", "bad"
MARKS = {GOOD: "✓", RESERVED: "!", OPEN: "·", FAILED: "✗"}
"""States of a result: its checks hold, they hold but something speaks against relying on that,
it states no requirement, it fails."""


def judge(
    fields: Fields, summary: Summary, notes: Sequence[Note] = ()
) -> tuple[str, list[str]]:
    """Return the state of a result, and the sentences that say why.

    A warning or a note that speaks against the result is a reservation, as with `--strict`.
    """
    faults, reservations = [sentence_of(fault) for fault in summary.faults], []
    if not fields["complete"]:
        lost = [f"{row.value} {row.label}".strip() for row in lost_rows(fields, summary)]
        where = f" ({', '.join(lost)})" if lost else ""
        faults.append(f"The result is incomplete: the numerics failed in some cases{where}.")
    checks = [check.passed for check in summary.checks]
    is_judged = any(passed is not None for passed in checks)
    failed, skipped = checks.count(False), checks.count(None)
    every = format_count(len(checks), "check")
    sentence = (
        "The scenario has no checks, so it states no requirement: whether the numbers are "
        "good enough is for the reader to decide."
    )
    if failed and summary.conclusion:
        verb = "fails" if failed == 1 else "fail"
        sentence = sentence_of(summary.conclusion[0])
        reservations.append(f"{failed} of {every} {verb} in some cases")
    elif failed:
        verb = "fails" if failed == 1 else "fail"
        sentence = f"{failed} of {every} {verb}: the result does not meet its requirements."
        faults.append(sentence)
    elif skipped:
        sentence = "The others hold." if skipped < len(checks) else "No check was judged."
    elif checks:
        of_many = "Both checks hold" if len(checks) == 2 else f"All {every} hold"
        holds = "The check holds" if len(checks) == 1 else of_many
        sentence = f"{holds}: the result meets the requirements of its scenario."
    if skipped:
        reservations.append(f"{skipped} of {every} could not be judged")
    if fields["warnings"]:
        reservations.append(format_count(len(fields["warnings"]), "warning"))
    objections = [note.sentence for note in notes if note.tone == BAD]
    if objections:
        faults.insert(0, DAMAGED)
    lines = [*faults, *([] if objections or sentence in faults else [sentence])]
    if reservations and not faults:
        passed = "Passed, with reservations" if is_judged else "No verdict, and reservations"
        if failed:
            passed = "An admissible case is known, with reservations"
        lines.insert(0, f"{passed}: {'; '.join(reservations)}.")
    elif reservations:
        lines.append(f"Besides: {'; '.join(reservations)}.")
    elif not objections:
        lines.append("No warnings.")
    state = GOOD if checks else OPEN
    state = FAILED if faults else RESERVED if reservations else state
    quoted = quote_warnings(fields["warnings"])
    return state, [*lines, *quoted, *summary.answer, *summary.verdict, *objections]


def quote_warnings(warnings: Sequence[Fields]) -> Iterator[str]:
    """Yield the main warnings as sentences, and how many others the page lists."""
    firsts = {warning["slug"]: warning["sentence"] for warning in reversed(warnings)}
    order = dict.fromkeys(warning["slug"] for warning in warnings)
    quoted = [firsts[slug] for slug in order][:MAX_RESERVATIONS]
    for sentence in quoted:
        yield f"Warning: {sentence}."
    if more := len(warnings) - len(quoted):
        yield f"{format_count(more, 'more warning')} below."


def key_rows(rows: Sequence[Row]) -> list[Row]:
    """Return the main results for the top of the page, in order, violations among them."""
    candidates = [
        row
        for row in rows
        if row.label and row.label not in NUMERICAL_ROWS and DIGIT.search(row.value)
    ]
    violations = [row for row in candidates if row.tone == BAD]
    kept = candidates[: max(0, KEY_ROWS - len(violations))]
    return [row for row in candidates if row in kept or row in violations][:KEY_ROWS]


def sentence_of(note: Note) -> str:
    """Return a labelled sentence as one that stands alone."""
    return f"{note.sentence[0].upper()}{note.sentence[1:]}."


def lost_rows(fields: Fields, summary: Summary) -> Iterator[Row]:
    """Yield the rows on cases or seeds without values."""
    lost = {"failed", *fields["numerics"].get("statuses", ())}
    for group in summary.groups:
        yield from (row for row in group if row.label in lost and row.tone == BAD)


def meaning_of_row(row: Row, fields: Fields) -> str:
    """Return the meaning of a metric, or what a fitted key is; empty for another row."""
    keys = [parameter["key"] for parameter in fields.get("fit", {}).get("parameters", ())]
    of_key = {short_key(key, keys): key for key in keys}
    if row.label in of_key:
        return noun_of_key(of_key[row.label])
    return meaning_of_metric(TERMS.get(row.label, row.label), "assess" in fields)


def legend(rows: Sequence[Row], kind: str) -> list[tuple[str, str]]:
    """Return the words of a kind that occur in rows of a summary, with their meanings."""
    names = {re.sub("[+-](?=[0-9])", "±", row.label) for row in rows}
    text = " ".join(f"{row.value} {row.remark}" for row in rows)
    return [
        (entry.word, entry.text)
        for entry in entries()
        if entry.kind == kind and (entry.word in names or is_term_in(text, entry.word))
    ]


def is_term_in(text: str, word: str) -> bool:
    """Return whether a word of the glossary is in a text; `at` is one as a label only."""
    return word != "at" and re.search(rf"(?<!\w){re.escape(word)}(?!\w)", text) is not None


def symbols_of_samples(fields: Fields) -> set[str]:
    """Return the symbols that stand in an evaluation of measurements without a model."""
    shown = {name for name, value in fields["metrics"].items() if value is not None}
    return {"ü"} | shown & {"T_a"} | ({"x_r"} if PEAK_STROKE in shown else set())


def meaning_of_metric(name: str, is_measured: bool = False) -> str:
    """Return the meaning of a metric, or of one of measured samples; empty for another word."""
    if is_measured and name in ABOUT_SAMPLES:
        return ABOUT_SAMPLES[name]
    return METRICS_BY_NAME[name].about if name in METRICS_BY_NAME else ""


def meanings(word: str, kind: str = "") -> str:
    """Return what `drysim explain` says about a word, or about a word of that kind."""
    texts = (entry.text for entry in explain(word) if kind in ("", entry.kind))
    return " ".join(dict.fromkeys(texts))


def noun_of_key(key: str) -> str:
    """Return the noun and symbol with which the meaning of a key begins."""
    text = next((entry.text for entry in explain(key) if entry.kind == KEY), "")
    return re.split(r"[.,;:](?:\s|$)", text)[0]


def warnings_by_slug(fields: Fields) -> Iterator[tuple[str, str, list[str], int]]:
    """Yield slug, meaning, the first sentences of the warnings and how many more there are."""
    counts = Counter(warning["slug"] for warning in fields["warnings"])
    for slug, count in counts.items():
        sentences = [
            warning["sentence"] for warning in fields["warnings"] if warning["slug"] == slug
        ]
        shown = sentences[:MAX_ALIKE]
        yield slug, meanings(slug, WARNING), shown, count - len(shown)


def metric_tables(fields: Fields) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield approach and table of metrics in SI units by rows, header first."""
    stored_metrics = fields.get("ensemble", fields)["metrics"]
    for approach, metrics in stored.metric_tables(stored_metrics):
        rows = list(zip(*stored.metric_columns(metrics), strict=True))
        if not rows:  # of a damaged result
            continue
        yield approach, [list(row) for row in rows]


def meanings_of_metrics(
    tables: Sequence[tuple[str, list[list[str]]]], is_measured: bool
) -> list[tuple[str, str]]:
    """Return the metrics of all tables, with their meanings."""
    names = dict.fromkeys(row[0] for _, table in tables for row in table[1:])
    return [
        (name, meaning) for name in names if (meaning := meaning_of_metric(name, is_measured))
    ]


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
        yield "solution", f"{why}."
    residual = numerics.get("energy_residual", metrics.get("energy_residual"))
    if residual is not None:
        sentence = (
            f"{format_number(residual, digits=2)}: {meaning_of_metric('energy_residual')}. "
        )
        yield (
            "energy residual",
            sentence
            + "Work of the base, dissipation and stored energy are integrated separately, "
            "so that a motion that turns or slides against its law would show here; rounding "
            "alone leaves about 1e-15.",
        )
    residual = numerics.get("law_residual", metrics.get("law_residual"))
    if residual is not None:
        sentence = f"{format_number(residual, digits=2)}: {meaning_of_metric('law_residual')}."
        yield "law residual", sentence
    # Of several seeds only the motion of the shown one is kept.
    seed = f" with seed {fields['excitation']['seed']}" if "ensemble" in fields else ""
    if numerics.get("events") is not None:
        how = "located within the steps, so that there is no time-step error"
        if approach != EXACT:
            how = "found at the end of the steps, which limits the accuracy"
        yield (
            "events",
            f"{format_count(numerics['events'], 'event')}{seed} (stops, break-aways, "
            f"reversals) over {format_count(numerics['steps'], 'step')} of the output grid, "
            f"{how}.",
        )
    if (margin := numerics.get("closest_decision")) is not None:
        yield (
            "closest decision",
            f"{format_number(margin, digits=2)}{seed}: smallest relative margin between the "
            "contact force and the static limit where stick or slip was decided; below 1e-6 a "
            "small change of the input could change the answer, and a warning says so.",
        )
    if (closure := numerics.get("closure")) is not None:
        about = meaning_of_metric("closure")
        yield "closure", f"{format_number(closure, digits=2)}: {about}."
    if (distance := numerics.get("distance")) is not None:
        about = "estimated distance of the motion to its periodic orbit, scaled as the closure"
        yield "distance to the orbit", f"{format_number(distance, digits=2)}: {about}."
    if (error := numerics.get("error")) is not None:
        what = "estimated error of x_r, relative to its peak"
        yield "error", f"{format_number(error, digits=2)}{seed}: {what}."
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


# A result on the disk.


class _Origin(BaseModel):
    name: str
    file: str
    sha256: str | None = None
    overrides: dict[str, Any] = {}


class _Case(BaseModel):
    scenario: _Origin


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

    kind: str
    version: str
    command: str
    created: str
    complete: bool
    exit_code: int
    scenario: _Origin | None = None
    inputs: list[_Input] = []
    excitation: dict[str, Any] = {}
    cases: list[_Case] = []
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
    fields, file = read_stored_fields(folder), folder / MARKER
    if fields.get("exit_code") == EXIT_INTERRUPTED:
        raise OutputError(f"{folder} is not finished", "finish it with --resume")
    with translate_damage(folder, fields):
        Stored.model_validate(fields)
        if fields["kind"] not in KINDS:
            sentence = f"{file} is damaged: there is no kind of result {fields['kind']}"
            raise OutputError(sentence, AGAIN_HINT)
        # All that a report takes of the file is taken here once, so that no value of a wrong
        # type or size is found later, where it could not be told from a fault of the program.
        page(fields, folder, plots=False)
    return fields


def report_folder(folder: Path, fields: Fields, *, plots: bool = True) -> tuple[str, list[str]]:
    """Return the report of a result on the disk, and what is wrong with its files.

    Parameters
    ----------
    folder : Path
    fields : dict
        Of `read_result`.
    plots : bool, optional
        Whether to show pictures.

    Raises
    ------
    OutputError
        When scenario.yaml is not the one that drysim wrote.
    """
    file = folder / SCENARIO_FILE
    if SCENARIO_FILE in fields["files"]:
        if file.exists() and not file.is_file():
            raise OutputError(f"cannot read {file}: it is not a plain file", AGAIN_HINT)
        try:
            original = file.read_bytes()
        except OSError as fault:
            reason = (fault.strerror or str(fault)).lower()
            raise OutputError(f"cannot read {file}: {reason}", AGAIN_HINT) from fault
        if hashlib.sha256(original).hexdigest() != fields["files"][SCENARIO_FILE]:
            raise OutputError(f"{file} was edited since drysim wrote it", AGAIN_HINT)
    note = note_on_files(folder, fields)
    objections = [note.sentence] if note.tone == BAD else []
    return page(fields, folder, [note], plots), objections
