"""The table of speed and error in README.md: `make proof` measures it and writes it anew.

It runs the two commands that the README names beside it. Timings vary from run to run, so its
numbers are not compared with those of today; `tests/test_readme.py` checks its shape.
"""

from __future__ import annotations

import csv
import os
import re
import tempfile
from pathlib import Path

from drysim.cli import main
from drysim.wording import number

FILE = Path(__file__).parents[1] / "README.md"
PART = re.compile(r"(<!-- proof -->\n)(.*?)(?=<!-- end -->)", re.S)

TERMS = ["--repeats", "9", "--patience", "0.1"]
COMMANDS = {
    "bench": ["bench", *TERMS, "--quiet", "--no-plots", "--out", "bench"],
    "steady": ["bench", "--steady", *TERMS, "--quiet", "--no-plots", "--out", "steady"],
}
WORKS = (
    ("sine", "bench", ("paper-high-friction",)),
    ("noise", "bench", ("paper-random",)),
    ("steady states", "steady", ("paper-low-friction", "paper-high-friction")),
)
"""Columns: heading, the command behind it, and the cases that it takes together."""

ENTRIES = (
    ("stick-slip", ""),
    ("moreau", ""),
    ("switch", ""),
    ("signum", "semi-implicit"),
    ("smooth", "tanh, c 1000, rk4"),
    ("heyoka events", "1e-15"),
    ("solve_ivp events", "RK45, 0.001"),
    ("solve_ivp events", "DOP853, 1e-12"),
    ("solve_ivp tanh", "LSODA, 1e-6, tanh c 10000"),
    ("CVODE tanh", "BDF, 1e-9, tanh c 1e6"),
    ("PathSim tanh", "RKCK54, 1e-6, tanh c 1000"),
    ("MuJoCo", "implicitfast"),
)
"""Rows: approaches at the step of the samples, and peers."""

Rows = list[dict[str, str]]

NONE = "–"
CELL = re.compile(r"[\d.e]+ \([\d.e]+ ns\), [\d.e-]+")


def measured() -> dict[str, Rows]:
    """Run the commands in an empty folder, and give the rows that each has written."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for words in COMMANDS.values():
            assert main(words) == 0
        tables = {name: Path(name, "speed_error.csv").read_text() for name in COMMANDS}
    return {name: list(csv.DictReader(text.splitlines())) for name, text in tables.items()}


def cell(rows: Rows, approach: str, setting: str, cases: tuple[str, ...]) -> str:
    """Give time and error of an entry on some cases that weigh alike."""
    found = []
    for case in cases:
        alike = [row for row in rows if (row["case"], row["approach"]) == (case, approach)]
        alike = [row for row in alike if row["setting"].startswith(setting)]
        found += [row for row in alike if row["error_x_r [-]"]][:1]
    if len(found) < len(cases):
        return NONE

    def mean(column: str) -> float:
        return sum(float(row[column]) for row in found) / len(found)

    error = max(float(row["error_x_r [-]"]) for row in found)
    ratio, time = mean("time_over_lfilter [-]"), mean("time_per_sample [ns]")
    return f"{number(ratio, digits=2)} ({number(time, 'ns', 2)}), {number(error, digits=1)}"


def table(tables: dict[str, Rows]) -> str:
    """Give the table, a row an entry that is known on any of the works."""
    lines = [("", *(heading for heading, _, _ in WORKS)), ("---",) * (1 + len(WORKS))]
    for approach, setting in ENTRIES:
        cells = [cell(tables[name], approach, setting, cases) for _, name, cases in WORKS]
        if set(cells) != {NONE}:
            lines.append((" ".join(filter(None, (approach, setting))), *cells))
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    made = table(measured())
    print(made)
    text = FILE.read_text(encoding="utf-8")
    text = PART.sub(lambda part: part[1] + made, text)
    FILE.write_text(text, encoding="utf-8", newline="\n")
