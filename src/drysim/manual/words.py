"""Glossary of drysim's keys, metrics, columns and other words, for `drysim explain`.

Keys come from the JSON schema, metrics from their table, laws, approaches and kinds of base
motion from their classes; symbols, columns, events, warnings, exit codes and options of the
commands from tables of the manual.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, NamedTuple

from drysim.approach import APPROACHES_BY_NAME
from drysim.errors import UsageError
from drysim.excitation.random import MACHINE_CLASSES
from drysim.manual import pages
from drysim.messages import closest_match, did_you_mean
from drysim.metrics.table import FIT_METRICS, METRICS
from drysim.scenario.keys import TAG_KEYS
from drysim.study.gallery import SCHEMA_FILE, folder, list_scenarios
from drysim.yaml_document import dump, read_document


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
    default : str
        Default value of a key; `required` if the key has no default.
    where : str
        Files or blocks in which it occurs.
    example : str
        A line that uses it.
    """

    word: str
    kind: str
    text: str
    unit: str = ""
    default: str = ""
    where: str = ""
    example: str = ""


KEY, METRIC, COLUMN, WARNING = "scenario key", "metric", "column", "warning"
EXIT, APPROACH, LAW, EVENT = "exit code", "approach", "friction law", "event"
EXCITATION, SYMBOL, OPTION = "kind of base motion", "symbol", "option"
CLASS = "seat-test class"
DESIGN, FIT = "word of a design study", "word of a fit"
BRANCHES, MAP = "word of branches", "word of a regime map"
COMMAND, SUMMARY = "command", "label of a summary"

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
"""Machines of the classes of ISO 7096, recalled and not checked against its text."""

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

SYMBOL_PAGE = "symbols"
"""Page of the manual with the table of symbols."""

LABELS = {
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
    "hysteresis": "Values of the first key at which sweeps up and down have different T_a, and "
    "the largest difference; of a sweep with direction: both.",
}
"""Labels of summaries that no table of the manual explains."""

SYMBOL_ROW = re.compile(r"^\| ([^`|]+) \| ([^|]*) \| ((?:[^|]|(?<=\\)\|)+) \|$", re.M)
"""A row of the table of symbols: symbols, units, meaning."""

TERMS = {
    **{metric.label: metric.name for metric in METRICS if metric.label != metric.name},
    "limit": "violations",
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
    "with every seed": "checks",
    "every seed": "checks",
    "p95": "checks",
    "profile": "profile_low",
    "held out": "fit.hold_out",
    "starts": "starts-disagree",
    "error x_dd": "fit_error",
    "residual": "x_dd_residual",
    "not white": "residuals-not-white",
    "closest_decision": "close-decision",
    "slide": "sliding without stops",
    "bounds": "at-bound",
}
"""Labels of summaries and other words, with the entry that explains them."""

OTHER_BLOCKS = ("friction.normal_record.",)
"""Blocks that repeat the keys of another block; their keys are listed last."""

EXAMPLES = {
    METRIC: "checks: [{word} < {limit} {unit}]",
    APPROACH: "drysim run FILE --approach {word}",
    WARNING: "drysim {command} FILE --strict    # a warning makes the exit code 1",
}

FIT_WARNINGS = {
    "at-bound", "bad-fit", "measurement-cut", "not-determined", "residuals-not-white",
    "start-differs", "starts-disagree",
}  # fmt: skip
"""Warnings of `drysim fit` only."""


@cache
def entries() -> tuple[Entry, ...]:
    """Return the meanings of all words; a symbol with another meaning has that one only.

    Keys have no example: `explain` reads the gallery for those that it returns.
    """
    found = tuple(_entries())
    known = {one.word for one in found}
    return found + tuple(one for one in _symbols() if one.word not in known)


def _entries() -> Iterator[Entry]:
    yield from keys()
    for name, member in APPROACHES_BY_NAME.items():
        text = " ".join((member.__doc__ or "").split())
        yield Entry(name, APPROACH, text, example=EXAMPLES[APPROACH].format(word=name))
    for metric in (*METRICS, *FIT_METRICS):
        name, unit, about = metric.name, metric.unit, metric.about
        text = about[0].upper() + about[1:] + "."
        limit = "1e-9" if name in ("energy_residual", "law_residual") else "1"
        example = EXAMPLES[METRIC].format(word=name, limit=limit, unit=unit)
        example = example.replace(" -]", "]")
        yield Entry(name, METRIC, text, unit, where="drysim.json, checks", example=example)
    for kind, page, row, begin, end in TABLES:
        text = pages()[page].text
        text = text.partition(begin)[2] if begin else text
        text = text.partition(end)[0] + "\n" if end else text
        yield from _table_entries(kind, row.findall(text))
    for name, text in LABELS.items():
        yield Entry(name, SUMMARY, text, where="console")
    yield from _commands_and_options()
    for name, spectrum in MACHINE_CLASSES.items():
        band = "{:g} to {:g} Hz".format(*spectrum.band)
        recalled = " (recalled)" * spectrum.recalled
        text = f"Stated RMS of the base {spectrum.rms:g} m/s²{recalled}, {band}."
        if name in MACHINES:
            text = f"Machine: {MACHINES[name]} (name recalled). {text}"
        example = f"excitation: {{kind: standard, class: {name}, …}}"
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
            example = EXAMPLES[WARNING].format(command=command) if kind == WARNING else ""
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
    word = re.sub(r" \[.*\]$", "", word)
    found = [one for one in entries() if one.word == word]
    if word.endswith("_half_width"):
        found += explain(word.removesuffix("_half_width")) + explain("half_width")
    elif not found:
        found = [one for one in entries() if one.word.endswith(f".{word}")]
        found.sort(key=lambda one: one.word.startswith(OTHER_BLOCKS))
    if not found and word in TERMS:
        found = explain(TERMS[word])
    if not found:
        found = [one for one in entries() if one.word.lower() == word.lower()]
    if not found and not word.startswith("-"):
        found = explain(f"--{word}")
    return [_with_example(one) for one in found]


def known_entries(word: str) -> list[Entry]:
    """Return the entries of a word as `explain`.

    Raises
    ------
    UsageError
        When there are none.
    """
    found = explain(word)
    if not found:
        sentence = f"nothing is known about `{word}`{did_you_mean(closest_word(word))}"
        raise UsageError(sentence, "`drysim manual --list` shows the pages of the manual")
    return found


def closest_word(word: str) -> str | None:
    """Return the known word closest to an unknown one, or None."""
    known = {one.word for one in entries()}
    tails = {name.rpartition(".")[2]: name for name in sorted(known)}
    nearest = closest_match(word, [*known, *tails])
    return nearest and tails.get(nearest, nearest)


# The keys of a scenario, from its JSON schema.


class Block(NamedTuple):
    """A block of a scenario, or one kind of it."""

    path: str
    kind: str
    text: str
    keys: tuple[Entry, ...]


MAX_EXAMPLE_LENGTH = 60
"""Maximum number of characters of an example."""

KINDS = {"excitation": EXCITATION, "friction": LAW}
"""Names for the kinds of a block."""


def keys() -> Iterator[Entry]:
    """Yield every key of a scenario, and every kind of block."""
    merged: dict[tuple[str, str], list[Entry]] = {}
    for block in blocks():
        if block.kind:
            tag, name = block.kind.split(": ")
            example = f"{block.path}: {{{tag}: {name}, …}}"
            yield Entry(name, KINDS[block.path], block.text, where=block.path, example=example)
        for key in block.keys:
            merged.setdefault((key.word, key.text), []).append(key)
    for same in merged.values():
        kinds: dict[str, list[str]] = {}
        for one in same:
            place, _, kind = one.where.partition(": ")
            kinds.setdefault(place, []).append(kind)
        where = "; ".join(
            f"{place}: {', '.join(names)}" for place, names in kinds.items() if place
        )
        defaults = list(dict.fromkeys(one.default for one in same))
        default = defaults[0] if len(defaults) == 1 else "depends on the kind"
        yield same[0]._replace(where=where, default=default)


@cache
def _gallery() -> dict[tuple[str, str], str]:
    """Return an example value for each dotted key in the gallery, as YAML on one line.

    The second key is the kind of the block, such as `road`; empty for a block without kinds.
    """
    found: dict[tuple[str, str], str] = {}

    def collect(prefix: str, value: Any, kind: str = "") -> None:
        if isinstance(value, dict) and prefix != "sweep":
            kind = next((str(value[tag]) for tag in TAG_KEYS if tag in value), kind)
            for key, inner in value.items():
                collect(f"{prefix}.{key}" if prefix else str(key), inner, kind)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            collect(f"{prefix}[]", value[0], kind)
        elif prefix and not isinstance(value, dict):
            if isinstance(value, list):
                text = f"[{', '.join(map(str, value))}]"
            else:
                text = dump({"key": value}).partition(":")[2].strip()
            found.setdefault((prefix, kind), text)

    for scenario in list_scenarios():
        collect("", read_document(scenario.file).value)
    return found


def _with_example(entry: Entry) -> Entry:
    """Return an entry, that of a key with an example from the gallery if it has one."""
    if entry.kind != KEY:
        return entry
    word, examples = entry.word, _gallery()
    places = [place.partition(": ") for place in entry.where.split("; ")]
    kinds = [kind for *_, names in places for kind in names.split(", ")]
    value = next((examples[word, kind] for kind in kinds if (word, kind) in examples), None)
    if value is None or len(value) > MAX_EXAMPLE_LENGTH:
        return entry
    if "[]" in word or "." not in word:
        return entry._replace(example=f"{word.rpartition('.')[2]}: {value}")
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
    yield Block("", "", "", tuple(_block_entries(root, root, "", "", deep=False)))
    for key, field in root["properties"].items():
        for suffix, block in _inner_blocks(root, field):
            tags = [
                f"{name}: {discriminator['const']}"
                for name, discriminator in _discriminators(block)
            ]
            kind = " ".join(tags)
            where = f"{key} with {kind}" if kind else ""
            text = " ".join(block.get("description", "").replace(NOTES_HEADING, "").split())
            yield Block(
                key + suffix,
                kind,
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
                yield Entry(f"{prefix}<law>", KEY, LAW_OPTIONS_TEXT, "", "", where)
            listed = True
            continue
        text, unit = _meaning(field)
        yield Entry(prefix + key, KEY, text, unit, _default(block, key, field), where)
        for suffix, inner in _inner_blocks(root, field) if deep else ():
            yield from _block_entries(root, inner, f"{prefix}{key}{suffix}.", where)


def _meaning(field: Any) -> tuple[str, str]:
    """Return the description of a key, and the unit in brackets in its description."""
    text = " ".join(field["description"].split())
    unit = "".join(re.findall(r" \[([^\], ]+)\]", re.sub("`[^`]*`", "", text))[:1])
    text = text.replace(f" [{unit}]", "", 1)
    choices = field.get("enum", ())
    if choices and not (str(choices[0]) in text and str(choices[-1]) in text):
        text += f" One of {', '.join(f'`{word}`' for word in choices)}."
    return text, unit


def _default(block: Any, key: str, field: Any) -> str:
    """Return the default value of a key; `required` if the key has no default."""
    if key in block.get("required", ()):
        return "required"
    value = field.get("default")
    for rule in block.get("allOf", ()):
        for words, then in (("oneOf", ""), ("anyOf", f": then {value}")):
            alternatives = [option["required"][0] for option in rule.get(words, ())]
            if key in alternatives and (words == "oneOf" or value is not None):
                others = " or ".join(f"`{other}`" for other in alternatives if other != key)
                return f"required, or {others}{then}"
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
