"""Glossary of drysim's keys, metrics, columns and other words, for `drysim explain`.

Keys come from the JSON schema, metrics from their table, laws, approaches and kinds of base
motion from their classes; symbols, columns, events, warnings, exit codes and options of the
commands from tables of the manual.
"""

from __future__ import annotations

import contextlib
import json
import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from drysim.approach import APPROACHES_BY_NAME
from drysim.errors import UsageError
from drysim.excitation.random import MACHINE_CLASSES
from drysim.manual import examples, pages
from drysim.messages import closest_match, did_you_mean
from drysim.metrics.table import FIT_METRICS, METRICS
from drysim.scenario.assess import ASSESS_KEY
from drysim.scenario.keys import TAG_KEYS
from drysim.scenario.laws import DEFAULT_LAW, LAW_KEY
from drysim.study.gallery import SCHEMA_FILE, folder
from drysim.units import QUANTITY_NAMES, conversion_factor, is_usual_unit


class Entry(NamedTuple):
    """One meaning of a word.

    Attributes
    ----------
    word : str
        A dotted key, a metric, a symbol, a column, a warning, an exit code.
    kind : str
        Kind of word, one of the constants below.
    text : str
        Its meaning, in sentences.
    unit : str
        Unit of its value, empty for none.
    type : str
        Type of the value of a key, such as `number`.
    default : str
        Default value of a key; `required` if the key has no default.
    choices : tuple
        Values to choose from, each with its meaning, which may be empty.
    keys : tuple of str
        Names of the keys of a block.
    where : str
        Files or blocks in which it occurs.
    example : str
        A line that uses it.
    """

    word: str
    kind: str
    text: str
    unit: str = ""
    type: str = ""
    default: str = ""
    choices: tuple[tuple[str, str], ...] = ()
    keys: tuple[str, ...] = ()
    where: str = ""
    example: str = ""


KEY, METRIC, COLUMN, WARNING = "scenario key", "metric", "column", "warning"
EXIT, APPROACH, LAW, EVENT = "exit code", "approach", "friction law", "event"
EXCITATION, SYMBOL, OPTION = "kind of base motion", "symbol", "option"
CLASS = "seat-test class"
DESIGN, FIT = "word of a design study", "word of a fit"
BRANCHES, MAP = "word of branches", "word of a regime map"
COMMAND, SUMMARY = "command", "label of a summary"
STANDARD, QUESTION, UNIT, FILE = "standard", "question", "unit", "file of a result"

GROUPS = {
    "scenario keys": (KEY,),
    "kinds of base motion, seat-test classes": (EXCITATION, CLASS),
    "friction laws": (LAW,),
    "approaches": (APPROACH,),
    "standards": (STANDARD,),
    "questions": (QUESTION,),
    "metrics": (METRIC,),
    "symbols": (SYMBOL,),
    "summaries": (SUMMARY, DESIGN, FIT, BRANCHES, MAP),
    "files, columns and events": (FILE, COLUMN, EVENT),
    "commands and options": (COMMAND, OPTION),
    "exit codes": (EXIT,),
    "warnings": (WARNING,),
}
"""Kinds of word in the groups in which `drysim explain --list` shows them."""

MACHINES = {
    "EM1": "articulated or rigid-frame dumper above 4500 kg",
    "EM2": "scraper without suspended axle",
    "EM3": "wheel loader above 4500 kg",
    "EM4": "grader",
    "EM5": "wheel dozer, soil compactor or backhoe loader",
    "EM6": "crawler loader or crawler dozer up to 50 t",
    "EM7": "compact dumper",
    "EM8": "compact loader up to 4500 kg",
    "EM9": "skid-steer loader up to 4500 kg",
}
"""Machines of the classes of ISO 7096, not verified against its text."""

STANDARDS = {
    "ISO 7096": (
        "Laboratory test of the seats of earth-moving machines. Its classes EM1 to EM9 are "
        "base motions of `kind: standard`; its limits, such as that of SEAT, are `checks`.",
        "excitation: {kind: standard, class: EM3, duration: 60 s, seed: 1}",
    ),
    "EN 13490": (
        "Laboratory test of the seats of industrial trucks. Its classes IT1 to IT4 are base "
        "motions of `kind: standard`.",
        "excitation: {kind: standard, class: IT2, duration: 60 s, seed: 1}",
    ),
    "ISO 5007": (
        "Laboratory test of the seats of agricultural tractors. Its classes AG1 to AG3 are "
        "base motions of `kind: standard`.",
        "excitation: {kind: standard, class: AG1, duration: 60 s, seed: 1}",
    ),
    "ISO 8608": (
        "Road profiles by their roughness. Its classes A to H are those of `kind: road`.",
        "excitation: {kind: road, class: C, speed: 36 km/h, duration: 60 s, seed: 1}",
    ),
    "ISO 2631-1": (
        "Whole-body vibration of persons: the frequency weightings of `measure.direction` and "
        "`measure.weighting`, which give a_w, SEAT, VDV, SEAT_VDV, MTVV and crest_factor.",
        "measure: {direction: vertical}",
    ),
    "Wk": (
        "Frequency weighting of ISO 2631-1 for the seat, vertical, with the factor 1: that of "
        "`direction: vertical`.",
        "measure: {direction: vertical}",
    ),
    "Wd": (
        "Frequency weighting of ISO 2631-1 for the seat, horizontal, with the factor 1.4: that "
        "of `direction: horizontal`.",
        "measure: {direction: horizontal}",
    ),
    "Wc": (
        "Frequency weighting of ISO 2631-1 for the backrest, fore and aft.",
        "measure: {weighting: Wc}",
    ),
    "2002/44/EC": (
        "Directive on the exposure of workers to vibration. The daily exposure A(8) is the "
        "metric A_8, with the duration of exposure as `measure.exposure`. For the whole body "
        "the action value is 0.5 m/s² and the limit 1.15 m/s².",
        "checks: [A_8 < 0.5 m/s2]",
    ),
}
"""Standards and directives: what of them drysim has, and a line of a scenario."""

QUESTIONS = {
    "force": (
        "A force F(t) on the mass, on a base at rest, moves it as the base acceleration "
        "ü = -F/m does: enter -F/m as the base motion. x_r and v_r are then the motion of the "
        "mass, and T_a is the force on the base over the applied one (RMS).",
        "drysim manual force",
    ),
    "belt": (
        "Friction against a belt or a slider that moves at speed V, while the spring is held "
        "at rest: seen from the belt, its contact is that of a base, and the spring is "
        "stretched by V t. That is the base acceleration ü = (k_x V t + b V)/m.",
        "drysim manual force",
    ),
}
"""What has no key of its own: how a scenario states it, and the page that shows it."""

ROW = re.compile(r"^\| `([^`]+)` \| (.*) \|$", re.M)
"""A row of a table of words in code: word, further cells."""

WORD_ROW = re.compile(r"^\| (?!-)([^`|]+) \| ((?!meaning).*) \|$", re.M)
"""A row of a table of plain words: word, meaning."""

CELL = re.compile(r"(?<!\\) ?\| ")
"""What separates the cells of a row."""

TABLES = (
    (COLUMN, "columns", ROW, "", "## Events"),
    (EVENT, "columns", ROW, "## Events", ""),
    (WARNING, "warnings", ROW, "", ""),
    (EXIT, "exit-codes", ROW, "", ""),
    (DESIGN, "design", ROW, "How to read it:\n\n", "\n\n"),
    (FIT, "fit", ROW, "How to read it:\n\n", "\n\n"),
    (BRANCHES, "branches", WORD_ROW, "## The words", "\n## "),
    (MAP, "map", WORD_ROW, "How to read it:", "How far to trust it:"),
)
"""Kinds of word that are read from tables of the manual: page, rows, text before and after."""

FILES_PAGE, FILE_ROW = "files", re.compile(r"^\| (`[^|]+) \| (.*) \|$", re.M)
"""Page of the manual with the table of files, and a row of it: names, what is in them."""

LINK = re.compile(r" ?\(\[[^]]*\]\([^)]*\)\)")
"""A link in brackets."""

SYMBOL_PAGE = "symbols"
"""Page of the manual with the table of symbols."""

LABELS = {
    "base": "Base motion, with the RMS value of its acceleration.",
    "swept": "Keys that a sweep varies, with their values.",
    "cases": "Number of cases: combinations of the swept values, for each approach.",
    "seeds": "Number of seeds of the random base motion; results are means over them.",
    "state": "How many cases or seeds are finished, of a result that is not complete.",
    "best": "The case of a sweep with the smallest SEAT, or else T_a, among those that keep "
    "all checks and the stroke limit.",
    "quantile": "Value that a given share of the seeds, or of the draws of a fit, stays below: "
    "p95 is that of 95 %, so one of 20 exceeds it. A check may ask for it.",
    "every seed": "A check with these words holds only if it holds for each single seed; "
    "without them the mean over the seeds is judged.",
    "holds": "A check that is met, with the value and where it is closest to its limit.",
    "fails": "A check that is not met, with the value and where it is farthest beyond.",
    "skipped": "A check whose metric is not known here; --strict counts it as failed.",
    "written": "Output folder.",
    "evaluated": "Number of designs solved, how many of them keep all limits, and why the "
    "search ended.",
    "scatter": "Time over which a laboratory averaged curves under random base motion, "
    "estimated from how much they scatter about those fitted.",
    "fitted": "Part of the record that is fitted; the rest is predicted.",
    "motion": "How the contact moves, of a fit to a friction rig: the measured motion is "
    "imposed.",
    "shooting": "Periodic motions found by integrating one period and correcting its start, "
    "where there is no closed form: how well they close, and the error of their multipliers.",
    "along": "Key along which periodic motions are followed.",
    "motions": "Number of periodic motions by their kind.",
    "branch": "One continuous line of periodic motions, over the values of the key.",
    "grid": "Number of motions behind a map.",
    "boundaries": "Boundaries between the regimes of a map, followed at the resolution stated.",
    "lines": "Lines of equal rate of break-aways in a map.",
    "break-aways a second": "How often the mass breaks away from sticking under random base "
    "motion: the range of rates in a share of a map.",
    "cleaned": "What was done to a record before it was used, as its scenario demands.",
    "laws": "Friction laws behind the names of a comparison.",
    "engine": "How the kernels run: compiled, or interpreted by Python.",
    "ring-down": "Free vibration after a shock or record that ends at rest: the run goes on, "
    "the base being at rest, for a free period (at most two natural periods) after it last "
    "moved. It counts in peaks, stroke, violations and contacts, not in RMS values.",
    "jumps": "Values of the static ratio at which a metric changes abruptly by more than 1 %, "
    "as where a motion ends; of a run or sweep with friction.static_ratio: {from, to}.",
    "isolation": "Frequency from which on T_a stays below 1 up to the end of the sweep, on "
    "every curve that ends below 1; of a sweep of excitation.frequency. In a regime map, the "
    "region where T_a is below 1.",
    "end stops": "Whether the mass hits its end stops.",
    "error": "Estimated error of x_r, relative to its peak; of laws that are integrated in "
    "steps.",
    "failed": "Number of cases or seeds without numbers, and why the first of them has none.",
    "lyapunov": "Largest Lyapunov exponent of a steady motion: the rate at which motions that "
    "begin side by side part; above 0 the motion is chaotic.",
    "worst": "Where each approach deviates most from the reference in T_a; of a comparison.",
    "peak |H1|": "Largest magnitude of the transmissibility H1 where the base moves, with its "
    "95 % band; of an assessment.",
    "model": "Oscillator and friction that the scenario states: their motion on the measured "
    "base stands beside what was measured; of an assessment.",
    "action value": "Hours a day after which the exposure reaches the action value of "
    "directive 2002/44/EC, A(8) of 0.5 m/s²; of an assessment.",
    "limit value": "Hours a day after which the exposure reaches the limit value of directive "
    "2002/44/EC, A(8) of 1.15 m/s²; of an assessment.",
    "runs": "Whether the runs of a test agree: how far each is from their mean, in SEAT and "
    "a_w or, without a weighting, in T_a and a_x.",
    "axis": "Axis of the seat with the highest weighted acceleration, from which A(8) follows.",
    "hysteresis": "Values of the first key at which sweeps up and down have different T_a, and "
    "the largest difference; of a sweep with direction: both.",
}
"""Labels of summaries that no table of the manual explains."""

SYMBOL_ROW = re.compile(r"^\| ([^`|]+) \| ([^|]*) \| ((?:[^|]|(?<=\\)\|)+) \|$", re.M)
"""A row of the table of symbols: symbols, units, meaning."""

TERMS = {
    **{metric.label: metric.name for metric in METRICS if metric.label != metric.name},
    "limit": "violations",
    "stroke limit": "stroke.limit",
    "T_a below 1": "isolation: T_a < 1",
    "several": "several stable motions",
    "knee": "knee of the front",
    "and": "over",
    "runs agree": "runs",
    "runs differ": "runs",
    "stops hit": "contacts",
    "energy": "energy_residual",
    "friction +10 %": "friction ±10 %",
    "friction -10 %": "friction ±10 %",
    "stiffness +10 %": "stiffness ±10 %",
    "stiffness -10 %": "stiffness ±10 %",
    "A(8)": "A_8",
    "bumper": "stroke.stops",
    "gap": "gaps",
    "check": "checks",
    "decide": "checks",
    "with every seed": "every seed",
    "p95": "quantile",
    "quantiles": "quantile",
    "ISO 2631": "ISO 2631-1",
    "EN ISO 7096": "ISO 7096",
    "2002/44": "2002/44/EC",
    "directive 2002/44/EC": "2002/44/EC",
    "transmissibility": "T_a",
    "natural frequency": "f_0",
    "coefficient of friction": "friction.mu_kinetic",
    "damper": "oscillator.damping",
    "spring": "oscillator.stiffness",
    "applied force": "force",
    "external force": "force",
    "moving base": "belt",
    "conveyor": "belt",
    "unverified": "recalled",
    "profile": "profile_low",
    "held out": "fit.hold_out",
    "starts": "starts-disagree",
    "error x_dd": "fit_error",
    "error T_a": "fit_error",
    "error T_x": "fit_error",
    "noise u_dd": "noise.u_dd",
    "residual": "x_dd_residual",
    "not white": "residuals-not-white",
    "closest_decision": "close-decision",
    "slide": "sliding without stops",
    "bounds": "at-bound",
}
"""Labels of summaries and other words, with the entry that explains them."""

LABELS_OF_CASES = (
    (re.compile(r"^\d+ (?=stops a period$)"), "2, 4, … "),
    (
        re.compile(r"^(?:[\d.]+ to|above|below) [\d.]+ break-aways? a second$"),
        "break-aways a second",
    ),
    (re.compile(r"^least \w+$"), "front"),
)
"""Labels with numbers or names in them, and the word that explains them."""

DOTTED_BLOCKS = ("sweep.", "design.over.")
"""Blocks whose keys are dotted keys themselves."""

OTHER_BLOCKS = ("friction.normal_record.",)
"""Blocks that repeat the keys of another block; their keys are listed last."""

FIT_WARNINGS = {
    "at-bound", "bad-fit", "few-draws", "not-determined", "residuals-not-white",
    "start-differs", "starts-disagree",
}  # fmt: skip
"""Warnings of `drysim fit` only."""

ASSESS_WARNINGS = {"runs-disagree"}
"""Warnings of `drysim assess` only."""

MEASUREMENT_WARNINGS = {"channels-suspect", "filters-differ", "measurement-cut"}
"""Warnings about measured channels, which `drysim validate` finds."""

WARNING_EXAMPLE = "drysim {command} FILE --strict    # a warning makes the exit code 1"


@cache
def entries() -> tuple[Entry, ...]:
    """Return the meanings of all words; a symbol with another meaning has that one only.

    Keys have no example: `explain` reads the gallery for those that it returns.
    """
    meanings = tuple(_entries())
    names = {entry.word for entry in meanings}
    return meanings + tuple(entry for entry in _symbols() if entry.word not in names)


def _entries() -> Iterator[Entry]:
    yield from keys()
    for name, member in APPROACHES_BY_NAME.items():
        text = " ".join((member.__doc__ or "").split())
        yield Entry(name, APPROACH, text, example=f"drysim run FILE --approach {name}")
    for metric in (*METRICS, *FIT_METRICS):
        name, unit, about = metric.name, metric.unit, metric.about
        text = about[0].upper() + about[1:] + "."
        example = f"checks: [{examples.check(name, unit)}]"
        yield Entry(name, METRIC, text, unit, where="drysim.json, checks", example=example)
    for kind, page, row, begin, end in TABLES:
        text = pages()[page].text
        text = text.partition(begin)[2] if begin else text
        text = text.partition(end)[0] + "\n" if end else text
        yield from _table_entries(kind, row.findall(text))
    for names, text in FILE_ROW.findall(pages()[FILES_PAGE].text.partition("\n## ")[0]):
        scope = names.rpartition("`")[2].strip()
        text = LINK.sub("", f"{scope}: {text}" if scope else text).replace("\\|", "|")
        for name in names.split("`")[1::2]:
            yield Entry(name, FILE, text[0].upper() + text[1:] + ".", where="output folder")
    for name, text in LABELS.items():
        yield Entry(name, SUMMARY, text, where="console")
    for name, (text, example) in STANDARDS.items():
        yield Entry(name, STANDARD, text, example=example)
    for name, (text, example) in QUESTIONS.items():
        yield Entry(name, QUESTION, text, example=example)
    yield from _commands_and_options()
    for name, spectrum in MACHINE_CLASSES.items():
        band = "{:g} to {:g} Hz".format(*spectrum.band)
        doubt = " (unverified)" * spectrum.recalled
        text = f"Stated RMS of the base {spectrum.rms:g} m/s²{doubt}, {band}."
        if name in MACHINES:
            text = f"Machine: {MACHINES[name]} (name unverified). {text}"
        example = f"excitation: {{kind: standard, class: {name}, duration: 60 s, seed: 1}}"
        yield Entry(name, CLASS, text, where="excitation.class", example=example)


def _symbols() -> Iterator[Entry]:
    """Return the symbols of the manual."""
    for symbols, units, text in SYMBOL_ROW.findall(pages()[SYMBOL_PAGE].text):
        names, units = symbols.split(", "), units.split(", ")
        for i, name in enumerate(names):
            unit = units[i] if len(units) == len(names) else units[0]
            if name not in ("symbol", "---"):
                yield Entry(
                    name, SYMBOL, text[0].upper() + text[1:].replace("\\|", "|") + ".", unit
                )


def _table_entries(kind: str, rows: Sequence[tuple[str, str]]) -> Iterator[Entry]:
    """Return the words of a table of the manual, each with the further cells of its row."""
    for word, cells in rows:
        fields = [cell.strip().replace("\\|", "|") for cell in CELL.split(cells)]
        if kind == COLUMN:
            unit, where, meaning = fields
            yield Entry(word, kind, meaning, unit, where=where.replace("`", ""))
        else:
            command = "fit" if word in FIT_WARNINGS else "run"
            command = "assess" if word in ASSESS_WARNINGS else command
            command = "validate" if word in MEASUREMENT_WARNINGS else command
            example = WARNING_EXAMPLE.format(command=command) if kind == WARNING else ""
            yield Entry(word, kind, fields[0], example=example)


def _commands_and_options() -> Iterator[Entry]:
    """Yield the commands, and their options; those with the same meaning once."""
    commands: dict[tuple[str, str], list[str]] = {}
    for section in pages()["commands"].text.split("\n## `")[1:]:
        title, text = section.split("\n\n")[:2]
        usage = title.split("`")[0]
        yield Entry(usage.split()[1], COMMAND, text, example=usage)
        for names, meaning in ROW.findall(section):
            if names.startswith("--"):
                option = names.split(", ")[0].split(" ")[0]
                command = " ".join(section.split()[:2]).strip("`")
                commands.setdefault((option, meaning), []).append(command)
    for (option, meaning), where in commands.items():
        yield Entry(option, OPTION, meaning, where=", ".join(where))


def explain(word: str) -> list[Entry]:
    """Return the entries of a word: exact matches, else keys that end with it."""
    word = re.sub(r"^exit[ -](?:code )?", "", word.strip().strip("`"))
    word = re.sub(r"^[✓✗·] | \[.*\]$|(?<=^branch) \d+$", "", word)
    for label, general in LABELS_OF_CASES:
        word = label.sub(general, word)
    matches = [entry for entry in entries() if entry.word == word]
    tails = [entry for entry in _dotted_entries() if entry.word.endswith(f".{word}")]
    if word.endswith("_half_width"):
        matches += explain(word.removesuffix("_half_width")) + explain("half_width")
    elif not matches:
        matches = sorted(tails, key=lambda entry: entry.word.startswith(OTHER_BLOCKS))
    elif all(entry.kind in (SUMMARY, COLUMN) for entry in matches):
        matches += [entry for entry in tails if entry.word.count(".") == 1]
    if not matches and word in TERMS:
        matches = explain(TERMS[word])
    if not matches:
        block, _, name = word.partition(".")
        matches = [e for e in entries() if (e.word, e.kind) == (name, KINDS.get(block))]
    if not matches:
        matches = _units(word)
    if not matches and (spelled := _spellings().get(_bare(word), word)) != word:
        matches = explain(spelled)
    if not matches and not word.startswith("-"):
        matches = explain(f"--{word}")
    return [_with_example(entry) for entry in matches]


def _dotted_entries() -> list[Entry]:
    """Return the entries of which the part behind the last point is a word, too."""
    return [entry for entry in entries() if entry.kind != FILE]


def _units(word: str) -> list[Entry]:
    """Return the meanings of a unit, one for each quantity that it measures."""
    if not is_usual_unit(word):
        return []
    meanings = []
    for unit, quantity in QUANTITY_NAMES.items():
        with contextlib.suppress(ValueError):
            factor = conversion_factor(word, unit)
            text = f"Unit of {quantity}: 1 {word} = {factor:.9g} {unit}".rstrip() + "."
            meanings.append(Entry(word, UNIT, text, where="values of a scenario, records"))
    return meanings


@cache
def _spellings() -> dict[str, str]:
    """Return every word, and every end of a dotted key, by its bare spelling."""
    entry_words = [entry.word for entry in entries()]
    tails = [entry.word.rpartition(".")[2] for entry in _dotted_entries()]
    return {_bare(word): word for word in (*tails, *TERMS, *entry_words)}


def _bare(word: str) -> str:
    """Return a word in small letters, without what separates its parts."""
    return re.sub(r"[\s_-]", "", word).lower()


def known_entries(word: str) -> list[Entry]:
    """Return the entries of a word as `explain`.

    Raises
    ------
    UsageError
        When there are none; says where the word is mentioned.
    """
    matches = explain(word)
    if not matches:
        sentence = f"nothing is known about `{word}`{did_you_mean(closest_word(word))}"
        hint = "" if sentence.endswith("?") else _mentions(word)
        raise UsageError(sentence, hint or "`drysim explain --list` shows all words")
    return matches


MAX_MENTIONS = 6
"""Words, and pages, that are named where an unknown word is mentioned."""


def _mentions(word: str) -> str:
    """Return the words and pages whose text has an unknown word, as a sentence; else empty."""
    pattern = re.compile(rf"\b{re.escape(word)}\b", re.I)
    names = dict.fromkeys(entry.word for entry in entries() if pattern.search(entry.text))
    titles = [name for name, page in pages().items() if pattern.search(page.text)]
    places = [f"`drysim explain {shlex.quote(name)}`" for name in [*names][:MAX_MENTIONS]]
    places += [
        f"`drysim manual {name}`" for name in titles[: max(1, MAX_MENTIONS - len(names))]
    ]
    return f"it is mentioned in {', '.join(places)}" if places and word.strip() else ""


STEM_LENGTH = 5
"""Letters that `clipped` and `clipping` have in common."""


def closest_word(word: str) -> str | None:
    """Return the known word closest to an unknown one, or None."""
    names = {entry.word for entry in entries()}
    tails = {entry.word.rpartition(".")[2] for entry in _dotted_entries()}
    warnings = [entry.word for entry in entries() if entry.kind == WARNING]
    stem = word.lower()[:STEM_LENGTH] if len(word) > STEM_LENGTH else word.lower()
    of_stem = (name for name in warnings if f"-{stem}" in name)  # such as `record-clipped`
    return next(of_stem, None) or closest_match(word, [*names, *tails, *TERMS])


# The keys of a scenario, from its JSON schema.


class Block(NamedTuple):
    """A block of a scenario, or one kind of it."""

    path: str
    kind: str
    title: str
    """Description of the key that selects the kind; empty for a block without kinds."""
    text: str
    keys: tuple[Entry, ...]


KINDS = {"excitation": EXCITATION, "friction": LAW}
"""Names for the kinds of a block."""


def keys() -> Iterator[Entry]:
    """Yield every key of a scenario, and every kind of block."""
    merged: dict[tuple[str, str], list[Entry]] = {}
    choices: dict[str, tuple[tuple[str, str], ...]] = {}
    for block in blocks():
        for key in block.keys:
            merged.setdefault((key.word, key.text), []).append(key)
        if block.kind:
            tag, name = block.kind.split(": ")
            path = f"{block.path}.{tag}"
            inner = [key.word.removeprefix(f"{block.path}.") for key in block.keys]
            direct = tuple(key for key in inner if not set(".[<") & set(key))
            text, example = block.text, f"{block.path}: {{{tag}: {name}, …}}"
            yield Entry(name, KINDS[block.path], text, keys=direct, where=path, example=example)
            choices[path] = (*choices.get(path, ()), (name, block.title))
    for word in choices:
        path, _, tag = word.partition(".")
        text = f"Selects the {KINDS[path]}, and with it the other keys of the block."
        default = DEFAULT_LAW if tag == LAW_KEY else "required"
        merged[word, text] = [Entry(word, KEY, text, "", "word", default)]
    paths = {word.partition(".")[0]: kinds for word, kinds in choices.items()} | choices
    for alike in merged.values():
        entry = _merged(alike)
        if entry.word in paths:
            yield entry._replace(choices=paths[entry.word])
        else:
            yield entry._replace(keys=_inner_keys(merged, entry.word))


def _merged(alike: Sequence[Entry]) -> Entry:
    """Return the entry of a key with the same meaning in several kinds of its block."""
    kinds: dict[str, list[str]] = {}
    for entry in alike:
        place, _, kind = entry.where.partition(": ")
        kinds.setdefault(place, []).append(kind)
    where = "; ".join(f"{place}: {', '.join(names)}" for place, names in kinds.items() if place)
    defaults = list(dict.fromkeys(entry.default for entry in alike))
    default = defaults[0] if len(defaults) == 1 else "depends on the kind"
    return alike[0]._replace(where=where, default=default)


def _inner_keys(merged: Iterable[tuple[str, str]], path: str) -> tuple[str, ...]:
    """Return the names of the keys of the block, or of the entries of the list, at a path."""
    begins = re.compile(rf"{re.escape(path)}(?:\[\])?\.([^.\[]+)$")
    return tuple(dict.fromkeys(inside[1] for key, _ in merged if (inside := begins.match(key))))


def _with_example(entry: Entry) -> Entry:
    """Return an entry with an example value if it is that of a key or a kind of block."""
    if entry.kind in KINDS.values():
        path = entry.where.partition(".")[0]
        value = examples.of_kind(path, entry.word)
        return entry._replace(example=f"{path}: {value}") if value else entry
    if entry.kind != KEY:
        return entry
    places = [place.partition(": ") for place in entry.where.split("; ")]
    kinds = [kind for *_, names in places for kind in names.split(", ")]
    if any(meaning for _, meaning in entry.choices):
        path = entry.word.partition(".")[0]
        return entry._replace(example=f"{path}: {examples.value(path, [''])}")
    choices = [name for name, _ in entry.choices if name != entry.default]
    if entry.type == "true or false":
        choices = ["false" if entry.default == "true" else "true"]
    value = examples.value(entry.word, kinds) or (choices or [""])[0]
    word = entry.word
    if not value:
        return entry
    dotted = word.startswith(DOTTED_BLOCKS) and word.count(".") > 1  # --set cannot reach these
    if set("[<") & set(word) or "." not in word or dotted:
        name = "excitation.file" if word.endswith(".excitation.file") else word.split(".")[-1]
        name = name.replace("<law>", "stribeck")
        return entry._replace(example=f"{name}: {value}")
    setting = f"{word}={value}" if " " not in value else f'"{word}={value}"'
    return entry._replace(example=f"--set {setting}")


NOTES_HEADING = "Notes\n-----"
"""Section heading in docstrings; removed because descriptions are joined to one line."""

LAW_OPTIONS_TEXT = "Options of another law for comparisons; all keys are optional."
"""Description of the optional blocks with the options of other laws."""


@cache
def blocks() -> tuple[Block, ...]:
    """Return every block of a scenario and every kind of it, with its keys."""
    return tuple(_blocks())


def _blocks() -> Iterator[Block]:
    # As `make schema` has written it: generating it would take half a second.
    root = json.loads((folder() / SCHEMA_FILE).read_text(encoding="utf-8"))
    yield Block("", "", "", "", tuple(_block_entries(root, root, "", "", deep=False)))
    for key, field in root["properties"].items():
        for suffix, block in _inner_blocks(root, field):
            tags = _discriminators(block)
            kind = " ".join(f"{name}: {discriminator['const']}" for name, discriminator in tags)
            title = "".join(discriminator["description"] for _, discriminator in tags)
            where = f"{key} with {kind}" if kind else ""
            text = " ".join(block.get("description", "").replace(NOTES_HEADING, "").split())
            yield Block(
                key + suffix,
                kind,
                title,
                text,
                tuple(_block_entries(root, block, f"{key}{suffix}.", where)),
            )


def _block_entries(
    root: Any, block: Any, prefix: str, where: str, deep: bool = True
) -> Iterator[Entry]:
    """Yield every key of a block and of the blocks in it."""
    tags, listed = [name for name, _ in _discriminators(block)], False
    for key, field in block["properties"].items():
        if key in tags:
            continue
        if field.get("$ref", "").endswith("Options"):  # one line stands for all laws
            if not listed:
                yield Entry(f"{prefix}<law>", KEY, LAW_OPTIONS_TEXT, type="block", where=where)
            listed = True
            continue
        text, unit = _meaning(field)
        yield Entry(
            prefix + key,
            KEY,
            text,
            unit,
            " or ".join(dict.fromkeys(_types(root, field))),
            _default(block, key, field),
            tuple((choice, "") for choice in _choices(field)),
            where=where,
        )
        for suffix, inner in _inner_blocks(root, field) if deep else ():
            yield from _block_entries(root, inner, f"{prefix}{key}{suffix}.", where)


def _meaning(field: Any) -> tuple[str, str]:
    """Return the description of a key, and the unit in brackets in its description."""
    text = " ".join(field["description"].split())
    unit = "".join(re.findall(r" \[([^\], ]+)\]", re.sub("`[^`]*`", "", text))[:1])
    return text.replace(f" [{unit}]", "", 1), unit


MAX_CHOICES = 20
"""Largest number of choices that are listed; more are the names of all metrics."""


def _choices(field: Any) -> Sequence[str]:
    """Return the words to choose from, of a key or of the entries of its list."""
    parts = (field, field.get("items", {}), *field.get("anyOf", ()), *field.get("oneOf", ()))
    choices = [
        str(word)
        for part in parts
        for word in (part.get("enum") or [part.get("const")])
        if word
    ]
    return choices if 1 < len(choices) <= MAX_CHOICES else ()


TYPES = {
    "boolean": "true or false", "integer": "whole number", "number": "number",
    "string": "text", "array": "list", "object": "block",
}  # fmt: skip
"""Types of the JSON schema as they are shown."""


def _types(root: Any, field: Any) -> Iterator[str]:
    """Yield the types of value of a key; a number may always be written as text with a unit."""
    if "$ref" in field:
        field = root["$defs"][field["$ref"].rpartition("/")[2]]
    parts = (*field.get("anyOf", ()), *field.get("oneOf", ()))
    for part in parts:
        yield from _types(root, part)
    if "enum" in field or "const" in field:
        yield "word"
    elif not parts and "pattern" not in field:
        types = field.get("type", "object")
        for name in [types] if isinstance(types, str) else types:
            if types == name or name != "string":
                yield TYPES[name]


def _default(block: Any, key: str, field: Any) -> str:
    """Return the default value of a key; `required` if the key has no default."""
    if key in block.get("required", ()):
        return "required"
    value = field.get("default")
    for rule in block.get("allOf", ()):
        for quantifier, then in (("oneOf", ""), ("anyOf", f": then {value}")):
            alternatives = [option["required"][0] for option in rule.get(quantifier, ())]
            needed = quantifier == "oneOf" or value is not None or ASSESS_KEY in alternatives
            if key in alternatives and needed and key != ASSESS_KEY:
                others = " or ".join(f"`{other}`" for other in alternatives if other != key)
                return f"required, or {others}{then if value is not None else ''}"
    if isinstance(value, bool | float):
        value = f"{value:g}" if isinstance(value, float) else str(value).lower()
    return "" if value in (None, "", []) or isinstance(value, dict) else str(value)


def _discriminators(block: Any) -> list[tuple[str, Any]]:
    """Return the keys whose value names the kind of block, with their schema."""
    fields = block["properties"]
    return [(key, fields[key]) for key in TAG_KEYS if "const" in fields.get(key, ())]


def _inner_blocks(root: Any, field: Any) -> Iterator[tuple[str, Any]]:
    """Yield the blocks in a field and the suffix of their path: `[]`, `.<key>` or none."""
    if "$ref" in field:
        field = root["$defs"][field["$ref"].rpartition("/")[2]]
    if "properties" in field:
        yield "", field
    for part in (*field.get("oneOf", ()), *field.get("anyOf", ())):
        yield from _inner_blocks(root, part)
    for key, suffix in (("items", "[]"), ("additionalProperties", ".<key>")):
        if isinstance(field.get(key), dict):
            yield from (
                (suffix + deeper, block) for deeper, block in _inner_blocks(root, field[key])
            )
    for named in field.get("patternProperties", {}).values():
        yield from ((".<key>" + deeper, block) for deeper, block in _inner_blocks(root, named))
