"""The table of speed and error in the manual: `make proof` measures it and writes it anew.

It runs the two benches that the page names beside it, with all other programs that are
installed. Timings vary from run to run, so its numbers are not compared with those of today;
`tests/test_readme.py` checks its shape.
"""

from __future__ import annotations

import re

import peers

from drysim.bench import scipy_ivp, speed_error
from drysim.bench.score import BenchCase
from drysim.bench.timing import BenchOptions
from drysim.manual import pages
from drysim.wording import format_number

FILE = pages()["speed"].file
PART = re.compile(r"(<!-- proof -->\n)(.*?)(?=<!-- end -->)", re.S)

TERMS = {"repeats": 9, "patience": 0.1}
OPTIONS = [word for name, value in TERMS.items() for word in (f"--{name}", str(value))]
COMMANDS = {
    "bench": ["bench", *OPTIONS, "--quiet", "--no-plots", "--out", "bench"],
    "steady": ["bench", "--steady", *OPTIONS, "--quiet", "--no-plots", "--out", "steady"],
}
"""What measures the same without the programs of `peers`."""

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

Panels = tuple[BenchCase, ...]

NONE = "–"
CELL = re.compile(r"[\d.e]+ \([\d.e]+ ns\), [\d.e-]+")


def measured() -> dict[str, Panels]:
    """Run both benches, and give the panels of each."""
    terms = BenchOptions(**TERMS, peers=(scipy_ivp, *peers.installed_peers()))
    asked = {
        "bench": speed_error.time_history_bench(
            speed_error.load_scenarios(None, [], swept=False), terms
        ),
        "steady": speed_error.steady_state_bench(
            speed_error.load_scenarios(None, [], swept=True), terms
        ),
    }
    return {name: one.run(lambda: None).cases for name, one in asked.items()}


def cell(cases: Panels, approach: str, setting: str, names: tuple[str, ...]) -> str:
    """Return time and error of an entry on some cases that weigh alike."""
    found = []
    for case in names:
        panel = next(panel for panel in cases if panel.scenario.name == case)
        alike = [one for one in panel.scores if one.approach == approach]
        alike = [one for one in alike if one.setting.startswith(setting)]
        found += [one for one in alike if one.error_x_r is not None][:1]
    if len(found) < len(names):
        return NONE
    error = max(one.error_x_r for one in found)
    ratio = sum(one.ratio for one in found) / len(found)
    time = sum(one.time for one in found) / len(found)
    per_sample = f"{format_number(ratio, digits=2)} ({format_number(time, 'ns', 2)})"
    return f"{per_sample}, {format_number(error, digits=1)}"


def table(benches: dict[str, Panels]) -> str:
    """Return the table, a row an entry that is known on any of the works."""
    lines = [("", *(heading for heading, _, _ in WORKS)), ("---",) * (1 + len(WORKS))]
    for approach, setting in ENTRIES:
        cells = [cell(benches[name], approach, setting, names) for _, name, names in WORKS]
        if set(cells) != {NONE}:
            lines.append((" ".join(filter(None, (approach, setting))), *cells))
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


if __name__ == "__main__":
    made = table(measured())
    print(made)
    text = FILE.read_text(encoding="utf-8")
    text = PART.sub(lambda part: part[1] + made, text)
    FILE.write_text(text, encoding="utf-8", newline="\n")
