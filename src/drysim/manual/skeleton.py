"""A commented scenario to fill in: every key of the usual blocks, with its unit and meaning.

Texts come from the models, as in `drysim explain`; example values from the gallery. What is
stated is a valid scenario. Each other key is a comment, which is a key without its `# `.
"""

from __future__ import annotations

import re
from pathlib import Path

from drysim.manual import examples
from drysim.manual.words import Block, Entry, blocks
from drysim.study.draft import commented
from drysim.study.gallery import refuse_existing, write_new

STATED = {
    "drysim": "1",
    "about": "Does a seat stay within its stroke?",
    "oscillator.mass": "75 kg",
    "oscillator.stiffness": "7500 N/m",
    "oscillator.damping": "500 N·s/m",
    "friction.law": "coulomb",
    "friction.kinetic": "45 N",
    "friction.static_ratio": "1.2",
    "stroke.limit": "25 mm",
    "excitation.kind": "harmonic",
    "excitation.frequency": "1.6 Hz",
    "excitation.rms": "1 m/s2",
    "checks": "[x_r_peak < 25 mm]",
}
"""Values of the keys that are no comments."""

KINDS = {"friction": ("law", "coulomb"), "excitation": ("kind", "harmonic")}
"""Key and value that choose the kind of a block."""

HEADER = """\
# A scenario to fill in: change what is stated, and remove the `# ` before a key to state it.
# `drysim explain KEY` says more of a key, `drysim explain excitation.kind` what there is.
"""

ONE_LINE = ("fit", "design", "sweep")
"""Blocks that are shown as a whole, as other commands or further cases need them."""

FIRST_SENTENCE = re.compile(r".*?[.](?=\s|$)")


def write_skeleton(file: Path) -> None:
    """Write the scenario to fill in.

    Raises
    ------
    OutputError
        If the file exists, or cannot be written.
    """
    refuse_existing(file)
    write_new(file, skeleton().encode())


def skeleton() -> str:
    """Return the text of the scenario."""
    by_kind = {(block.path, block.kind): block for block in blocks()}
    lines = [HEADER]
    for entry in by_kind["", ""].keys:
        tag, kind = KINDS.get(entry.word, ("", ""))
        block = by_kind.get((entry.word, f"{tag}: {kind}" if tag else ""))
        if block is None or entry.word in ONE_LINE:
            lines += key_lines(entry, "", is_stated=entry.word in STATED)
        else:
            lines += ["", *block_lines(entry, block, kind)]
        if entry.word in (*ONE_LINE, "measure", "about"):
            lines.append("")
    text = "\n".join(lines)
    return re.sub("\n\n\n+", "\n\n", text) + "\n"


def block_lines(entry: Entry, block: Block, kind: str) -> list[str]:
    """Return a block with its keys; one without a stated key is a comment altogether."""
    lines = commented(f"{entry.word}:", sentence_of(entry))
    if kind:
        tag = KINDS[entry.word][0]
        kinds = [
            each.kind.removeprefix(f"{tag}: ") for each in blocks() if each.path == block.path
        ]
        lines += commented(f"  {tag}: {kind}", f"one of {', '.join(kinds)}")
    keys = [key for key in block.keys if key.word.count(".") == 1 and "<" not in key.word]
    is_stated = any(key.word in STATED for key in keys)
    for key in keys:
        lines += key_lines(key, "  ", key.word in STATED or not is_stated, kind)
    return lines if is_stated else [f"# {line}" for line in lines]


def key_lines(entry: Entry, indentation: str, is_stated: bool, kind: str = "") -> list[str]:
    """Return the line of a key with its unit and meaning, as a comment unless it is stated."""
    mark = "" if is_stated else "# "
    line = f"{indentation}{mark}{entry.word.rpartition('.')[2]}: {value_of(entry, kind)}"
    unit = f"[{entry.unit}] " if entry.unit not in ("", "-") else ""
    return commented(line, unit + sentence_of(entry))


def value_of(entry: Entry, kind: str) -> str:
    """Return the value of a key: stated, by default, or an example."""
    by_default = "" if entry.default.startswith(("required", "false")) else entry.default
    choices = [choice for choice, _ in entry.choices] or ["true"]
    return (
        STATED.get(entry.word) or by_default or examples.value(entry.word, [kind]) or choices[0]
    )


def sentence_of(entry: Entry) -> str:
    """Return the first sentence on a key."""
    first = FIRST_SENTENCE.match(entry.text)
    return first[0] if first else entry.text
