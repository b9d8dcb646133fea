"""A commented scenario for a measured record: what its file shows, and what it leaves open."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from textwrap import indent, wrap

from drysim.errors import UsageError
from drysim.records.inspection import ColumnSummary, Inspection, Proposal, inspect_record
from drysim.study.gallery import SUFFIX, SUFFIXES, new_file, refuse_existing, write_new
from drysim.system import relative_path
from drysim.units import conversion_factor
from drysim.wording import format_number, sanitise
from drysim.yaml_document import dump

WIDTH, COMMENT_COLUMN = 96, 31
"""Columns of the text, and the column where the comment on a short line begins."""

HEADER = ("column", "name", "unit", "mean", "RMS about it", "smallest", "largest", "missing")
"""Header of the table of columns."""

MAX_ROWS = 40
"""Columns in the table of columns."""

SEAT = """\
# decide: the values of your seat, cab or mount. These are an example: a seat with its driver.
oscillator:
  mass: 75 kg
  stiffness: 7500 N/m
  damping: 500 N·s/m
friction:
  law: coulomb
  kinetic: 45 N
  static_ratio: 1.2             # break-away force over kinetic friction
stroke: {limit: 60 mm}          # to either side
"""

QUESTIONS = """\
# Which friction is best within the stroke? `drysim sweep` answers; widen the range if none is.
sweep:
  friction.kinetic: {from: 0, to: 100, step: 10}
"""

VERTICAL = """\
# check: vertical or horizontal; weights the vibration by ISO 2631-1 for SEAT and a_w
measure: {direction: vertical}
"""


def write_draft(record: Path, name: str = "") -> tuple[Path, Inspection]:
    """Write a scenario that reads a record into the current folder.

    Parameters
    ----------
    record : Path
    name : str, optional
        Name of the scenario, as of `gallery.new_file`; default: that of the record.

    Returns
    -------
    file : Path
        The scenario, which may lack what the record does not show.
    inspection : Inspection

    Raises
    ------
    RecordError
        If the record cannot be read.
    OutputError
        If the scenario exists, or cannot be written.
    UsageError
        If the name cannot be that of a scenario.
    """
    if not (name or record.stem).isprintable():
        raise UsageError("the name of the record cannot be that of a scenario", "add a NAME")
    if record.suffix in SUFFIXES:
        raise UsageError(
            f"{record} is a scenario, not a record", f"`drysim run {record}` runs it"
        )
    file = new_file(name) if name else Path(record.stem + SUFFIX)
    refuse_existing(file)
    inspection = inspect_record(record)
    write_new(file, _draft(file, record, inspection).encode())
    return file, inspection


def _draft(file: Path, record: Path, inspection: Inspection) -> str:
    """Return the text of the scenario."""
    # As in the scenario, a link keeps its name, whose suffix is that of its format.
    target = os.path.join(os.path.realpath(record.parent), record.name)
    path = relative_path(target, os.path.realpath(file.parent))
    record_name = sanitise(record.name)
    about = f"Is the seat good enough on the floor motion of {record_name}?"
    block = [
        *_comment(f"Found in {record_name}: {inspection.layout[0]}."),
        *(line for more in inspection.layout[1:] for line in _comment(more)),
        *(f"# {row}" for row in _table(inspection.columns)),
        "excitation:",
        "  kind: record",
        indent(dump({"file": path}), "  ").rstrip(),
        *(line for proposal in inspection.proposals for line in _lines_of(proposal)),
    ]
    legend = "# Lines marked `check` are guesses from the record; `decide` is left to you."
    head = dump({"drysim": 1, "about": about})  # the name is that of the file
    measured = _assess_lines(path, inspection)
    return "\n".join([head + legend, "", SEAT, *block, "", VERTICAL, *measured, QUESTIONS])


SHARED_KEYS = (
    "skip", "rows", "time", "time_unit", "rate", "step", "missing", "gaps", "resample",
)  # fmt: skip
"""Keys of a record that all channels of its file share."""


def _assess_lines(path: str, inspection: Inspection) -> list[str]:
    """Return an assess block, as a comment, for a file with the motion of base and mass.

    Empty unless there are two accelerations, of which the first is the proposed base.
    """
    proposed = {each.key: each.value for each in inspection.proposals}
    names = [column.name for column in inspection.columns if _is_acceleration(column.unit)]
    if len(names) != 2 or not all(names) or names[0] != proposed.get("column"):
        return []
    base, mass = names
    shared = {key: proposed[key] for key in SHARED_KEYS if proposed.get(key) is not None}
    remove = proposed.get("remove")  # offset and drift, of both
    channels = {
        key: name if remove is None else {"column": name, "remove": remove}
        for key, name in (("u_dd", base), ("x_dd", mass))
    }
    measured = {"file": path, **shared, **channels}
    text = (
        f"If `{base}` is the floor and `{mass}` the mass on it, remove each `# ` below: `drysim"
    )
    block = indent(dump({"measured": measured}), "  ").rstrip().splitlines()
    lines = _comment(f"{text} assess` then evaluates what was measured.")
    return [*lines, *(f"# {line}" for line in ("assess:", *block)), ""]


def _is_acceleration(unit: str) -> bool:
    """Whether a unit of a column is one of acceleration."""
    with suppress(ValueError):
        return bool(unit) and conversion_factor(unit, "m/s²") > 0.0
    return False


def _lines_of(proposal: Proposal) -> list[str]:
    """Return the line of a proposed key with its reason, beside or above it."""
    value = proposal.value
    if isinstance(value, dict):
        items = ", ".join(dump({key: inner}).strip() for key, inner in value.items())
        line = f"  {proposal.key}: {{{items}}}"
    elif value is None:
        line = f"  {proposal.key}:"
    else:
        line = indent(dump({proposal.key: value}), "  ").rstrip()
    is_guess = value is not None and not proposal.is_certain
    label = "decide: " if value is None else "check: " if is_guess else ""
    return commented(line, label + sanitise(proposal.reason))


def commented(line: str, text: str) -> list[str]:
    """Return a line with a comment beside it, or above it if that is too long."""
    beside = f"{line:<{COMMENT_COLUMN}}  # {text}"
    if len(beside) <= WIDTH:
        return [beside]
    indentation = " " * (len(line) - len(line.lstrip()))
    return [*(indentation + above for above in _comment(text)), line]


def _comment(text: str) -> list[str]:
    """Return text as lines of a comment."""
    return [f"# {line}" for line in wrap(sanitise(text), WIDTH - 6, break_on_hyphens=False)]


def _table(columns: tuple[ColumnSummary, ...]) -> Iterator[str]:
    """Yield the rows of a table with the statistics of the columns."""
    rows: list[tuple[str, ...]] = [HEADER]
    for column in columns[:MAX_ROWS]:
        numbers = (column.level.mean, column.level.spread, column.smallest, column.largest)
        texts = (
            str(column.column + 1),
            sanitise(column.name) or "-",
            sanitise(column.unit) or "-",
        )
        rows.append((*texts, *map(format_number, numbers), str(column.missing)))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(
            f"{word:<{width}}" for word, width in zip(row, widths, strict=True)
        ).rstrip()
    if len(columns) > MAX_ROWS:
        yield f"and {len(columns) - MAX_ROWS} more columns"
