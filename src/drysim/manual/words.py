"""What each word of drysim means, as `drysim explain` shows it.

Keys come from the JSON schema, metrics from their table, laws, approaches and kinds of base
motion from their classes; symbols, columns, events, warnings and exit codes from tables of the
manual.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import cache
from typing import Any, NamedTuple

from drysim.approach import APPROACHES_BY_NAME
from drysim.manual import pages
from drysim.metrics.table import METRICS
from drysim.scenario import schema
from drysim.study.gallery import list_scenarios
from drysim.yaml_document import dump, read_document


class Entry(NamedTuple):
    """One meaning of a word.

    Attributes
    ----------
    word : str
        A dotted key, a metric, a symbol, a column, a warning, an exit code.
    kind : str
        What sort of word it is.
    text : str
        Its meaning, in sentences.
    unit : str
        Unit of its value, empty for none.
    default : str
        Value of a key that is left out; `required` where it must be given.
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
EXCITATION, SYMBOL = "kind of base motion", "symbol"

TABLES = ((COLUMN, "columns"), (EVENT, "columns"), (WARNING, "warnings"), (EXIT, "exit-codes"))
"""Pages of the manual whose tables have the words of a kind."""

SYMBOL_PAGE = "symbols"
"""Page of the manual with the table of symbols."""

ROW, CELL = re.compile(r"^\| `([^`]+)` \| (.*) \|$", re.M), re.compile(r"(?<!\\) ?\| ")

SYMBOL_ROW = re.compile(r"^\| ([^`|]+) \| ([^|]*) \| ((?:[^|]|(?<=\\)\|)+) \|$", re.M)
"""A row of the table of symbols: symbols, units, meaning."""

TERMS = {
    "peak |x_r|": "x_r_peak",
    "hourly peak": "stroke_once_an_hour",
    "stuck": "stuck_share",
    "chatter": "chatter_share",
    "limit": "violations",
    "stops hit": "contacts",
    "energy": "energy_residual",
    "crest factor": "crest_factor",
}
"""Labels of summaries that differ from the name of the metric they stand for."""

EXAMPLES = {
    METRIC: "checks: [{word} < 1 {unit}]",
    APPROACH: "drysim run FILE --approach {word}",
    WARNING: "drysim run FILE --strict    # a warning makes the exit code 1",
}


@cache
def entries() -> tuple[Entry, ...]:
    """Return the meanings of all words; a symbol with another meaning has that one only."""
    found = tuple(_entries())
    known = {one.word for one in found}
    return found + tuple(one for one in _symbols() if one.word not in known)


def _entries() -> Iterator[Entry]:
    yield from keys()
    for name, member in APPROACHES_BY_NAME.items():
        text = " ".join((member.__doc__ or "").split())
        yield Entry(name, APPROACH, text, example=EXAMPLES[APPROACH].format(word=name))
    for name, unit, about in METRICS:
        text = about[0].upper() + about[1:] + "."
        example = EXAMPLES[METRIC].format(word=name, unit=unit).replace(" -]", "]")
        yield Entry(name, METRIC, text, unit, where="drysim.json, checks", example=example)
    for kind, page in TABLES:
        yield from _listed(kind, page)


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


def _listed(kind: str, page: str) -> Iterator[Entry]:
    """Return the words of a table of the manual: rows whose first cell is a word in code."""
    text = pages()[page].text
    if kind == EVENT:
        text = text.partition("## Events")[2]
    elif kind == COLUMN:
        text = text.partition("## Events")[0]
    for word, cells in ROW.findall(text):
        facts = [cell.strip().replace("\\|", "|") for cell in CELL.split(cells)]
        if kind == COLUMN:
            unit, where, meaning = facts
            yield Entry(word, kind, meaning, unit, where=where.replace("`", ""))
        else:
            example = EXAMPLES[WARNING] if kind == WARNING else ""
            yield Entry(word, kind, facts[0], example=example)


def explain(word: str) -> list[Entry]:
    """Return what a word means: exact matches, else keys that end with it."""
    word = re.sub(r"^exit[ -](?:code )?", "", word.strip().strip("`"))
    word = re.sub(r" \[.*\]$", "", word)
    found = [one for one in entries() if one.word == word]
    if word.endswith("_half_width"):
        found += explain(word.removesuffix("_half_width")) + explain("half_width")
    elif not found:
        found = [one for one in entries() if one.word.endswith(f".{word}")]
    if not found and word in TERMS:
        found = explain(TERMS[word])
    if not found:
        found = [one for one in entries() if one.word.lower() == word.lower()]
    return found


def similar(word: str, count: int = 3) -> list[str]:
    """Return words that are spelled almost like one that is not known."""
    known = {one.word for one in entries()}
    tails = {name.rpartition(".")[2]: name for name in known}
    close = get_close_matches(word, [*known, *tails], count)
    return list(dict.fromkeys(tails.get(name, name) for name in close))


# The keys of a scenario, from its JSON schema.

CONSTANT = {"const", "default"}
"""A key with the first of these and without the other tells kinds of a block apart."""


class Block(NamedTuple):
    """A block of a scenario, or one kind of it."""

    path: str
    kind: str
    text: str
    keys: tuple[Entry, ...]


LONGEST = 60
"""Characters of an example at most."""

KINDS = {"excitation": EXCITATION, "friction": LAW}
"""What the kinds of a block are called."""


def keys() -> Iterator[Entry]:
    """Return every key of a scenario, the kinds of blocks included."""
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
        yield same[0]._replace(where=where, default=default, example=_in_gallery(same[0].word))


@cache
def _gallery() -> dict[str, str]:
    """Return a value for each dotted key that the gallery uses, as YAML in one line."""
    found: dict[str, str] = {}

    def collect(prefix: str, value: Any) -> None:
        if isinstance(value, dict) and prefix != "sweep":
            for key, inner in value.items():
                collect(f"{prefix}.{key}" if prefix else str(key), inner)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            collect(f"{prefix}[]", value[0])
        elif prefix and not isinstance(value, dict):
            if isinstance(value, list):
                text = f"[{', '.join(map(str, value))}]"
            else:
                text = dump({"key": value}).partition(":")[2].strip()
            found.setdefault(prefix, text)

    for scenario in list_scenarios():
        collect("", read_document(scenario.file).value)
    return found


def _in_gallery(word: str) -> str:
    """Return an example of a key, as a gallery scenario has it; empty where none has."""
    value = _gallery().get(word)
    if value is None or len(value) > LONGEST:
        return ""
    if "[]" in word or "." not in word:
        return f"{word.rpartition('.')[2]}: {value}"
    return f"--set {word}={value}" if " " not in value else f'--set "{word}={value}"'


NOTES = "Notes\n-----"
"""A heading of docstrings, which has no place within a line."""

OPTIONS = "Options of another law for comparisons; all keys are optional."
"""Text for the blocks of all other laws that the block of one law may hold."""


@cache
def blocks() -> tuple[Block, ...]:
    """Return every block of a scenario and every kind of it, with its keys."""
    return tuple(_blocks())


def _blocks() -> Iterator[Block]:
    root = schema()
    yield Block("", "", "", tuple(_rows(root, root, "", "", deep=False)))
    for key, field in root["properties"].items():
        for way, block in _inner(root, field):
            tags = [f"{name}: {given['const']}" for name, given in _constants(block)]
            kind = " ".join(tags)
            where = f"{key} with {kind}" if kind else ""
            text = " ".join(block.get("description", "").replace(NOTES, "").split())
            yield Block(key + way, kind, text, tuple(_rows(root, block, f"{key}{way}.", where)))


def _rows(root: Any, block: Any, prefix: str, where: str, deep: bool = True) -> Iterator[Entry]:
    """Return every key of a block and of the blocks in it."""
    tags, listed = [name for name, _ in _constants(block)], False
    for key, field in block["properties"].items():
        if key in tags:
            continue
        if field.get("$ref", "").endswith("Options"):  # one line stands for all laws
            if not listed:
                yield Entry(f"{prefix}<law>", KEY, OPTIONS, "", "", where)
            listed = True
            continue
        text, unit = _meaning(field)
        yield Entry(prefix + key, KEY, text, unit, _default(block, key, field), where)
        for way, inner in _inner(root, field) if deep else ():
            yield from _rows(root, inner, f"{prefix}{key}{way}.", where)


def _meaning(field: Any) -> tuple[str, str]:
    """Return what a key means, and the unit that its text names in brackets."""
    text = " ".join(field["description"].split())
    unit = "".join(re.findall(r" \[([^\], ]+)\]", re.sub("`[^`]*`", "", text))[:1])
    text = text.replace(f" [{unit}]", "", 1)
    choices = field.get("enum", ())
    if choices and not (str(choices[0]) in text and str(choices[-1]) in text):
        text += f" One of {', '.join(f'`{word}`' for word in choices)}."
    return text, unit


def _default(block: Any, key: str, field: Any) -> str:
    """Return the value of a key that is left out; `required` where it must be given."""
    if key in block.get("required", ()):
        return "required"
    value = field.get("default")
    for rule in block.get("allOf", ()):
        for words, then in (("oneOf", ""), ("anyOf", f": then {value}")):
            either = [option["required"][0] for option in rule.get(words, ())]
            if key in either and (words == "oneOf" or value is not None):
                others = " or ".join(f"`{other}`" for other in either if other != key)
                return f"required, or {others}{then}"
    if isinstance(value, bool | float):
        value = f"{value:g}" if isinstance(value, float) else str(value).lower()
    return "" if value in (None, "", []) or isinstance(value, dict) else str(value)


def _constants(block: Any) -> list[tuple[str, Any]]:
    """Return the keys by which a block states its kind."""
    properties = block["properties"].items()
    return [(key, field) for key, field in properties if {"const"} == field.keys() & CONSTANT]


def _inner(root: Any, field: Any) -> Iterator[tuple[str, Any]]:
    """Return the blocks that a field may hold, and the way there: a list, a key, or none."""
    if "$ref" in field:
        field = root["$defs"][field["$ref"].rpartition("/")[2]]
    if "properties" in field:
        yield "", field
    for part in (*field.get("oneOf", ()), *field.get("anyOf", ())):
        yield from _inner(root, part)
    for key, way in (("items", "[]"), ("additionalProperties", ".<key>")):
        if isinstance(field.get(key), dict):
            yield from ((way + deeper, block) for deeper, block in _inner(root, field[key]))
    for named in field.get("patternProperties", {}).values():
        yield from ((".<key>" + deeper, block) for deeper, block in _inner(root, named))
