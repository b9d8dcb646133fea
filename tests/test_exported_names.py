"""The public names, and how little importing drysim brings with it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import drysim

HEAVY = ("jinja2", "matplotlib", "numba", "pint", "scipy")

NAMES = [
    "AssessResult",
    "BranchesResult",
    "Comparison",
    "DesignResult",
    "DrysimError",
    "Ensemble",
    "FitResult",
    "Outcome",
    "OutputError",
    "RecordError",
    "RegimeMap",
    "Scenario",
    "ScenarioError",
    "SolverError",
    "Table",
    "UsageError",
    "__version__",
    "assess",
    "branches",
    "compare",
    "design",
    "explain",
    "fit",
    "load",
    "map_regimes",
    "plot",
    "report",
    "run",
    "scenario",
    "simulate",
    "sweep",
    "validate",
]


def test_public_names_are_these_and_no_others():
    assert drysim.__all__ == NAMES


def output_of(program, folder=None, **environment):
    """Return what a program prints in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, env=os.environ | environment,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_is_there_and_in_dir(name):
    assert getattr(drysim, name) is not None
    assert name in dir(drysim)


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'sweeep'"):
        _ = drysim.sweeep


def test_every_public_fault_is_a_drysim_error():
    faults = [getattr(drysim, name) for name in NAMES if name.endswith("Error")]
    assert len(faults) == 6
    assert all(issubclass(fault, drysim.DrysimError) for fault in faults)


@pytest.mark.parametrize(
    "words",
    ["", "--help", "--version", "schema", "init --list", "validate seat.yaml",
     "run seat.yaml --dry-run"],
)  # fmt: skip
def test_light_commands_import_nothing_heavy(words, seat):
    none = HEAVY + ("numpy",) * words.startswith("--")
    program = (
        "import sys, drysim.cli\n"
        f"code = drysim.cli.main({words.split()!r})\n"
        f"print('heavy:', [name for name in {none!r} if name in sys.modules], code)\n"
    )
    last = output_of(program, seat.parent).splitlines()[-1]
    assert last == f"heavy: [] {0 if words else 2}"


LATER = (
    "drysim.study.other_motions",
    "drysim.study.cluster",
    "drysim.results.bench",
    "drysim.results.hard",
)
"""Modules that are imported once the engine is chosen, with Dask, or for `bench` alone."""


@pytest.mark.parametrize(
    "part", ["cli", "output", "results", "console", "plots", "study", "metrics"]
)
def test_modules_of_a_command_load_no_kernel_before_its_engine_is_chosen(part):
    program = (
        f"import importlib, pkgutil, sys, drysim.{part} as part\n"
        "found = pkgutil.iter_modules(part.__path__, part.__name__ + '.')\n"
        "names = [one.name for one in found]\n"
        f"for name in set(names) - {set(LATER)!r}:\n"
        "    importlib.import_module(name)\n"
        "print(len(names) > 1, 'numba' in sys.modules, 'drysim.core.events' in sys.modules)"
    )
    assert output_of(program, DRYSIM_ENGINE="auto") == "True False False\n"


def test_importing_drysim_imports_none_of_its_parts():
    program = "import sys, drysim; print([m for m in sys.modules if m.startswith('drysim.')])"
    assert output_of(program).strip() == "[]"


def test_commands_on_a_pipe_load_neither_rich_nor_other_heavy_packages(seat, process):
    for words in (["validate", "seat.yaml"], ["run", "seat.yaml", "--no-plots"]):
        answer = process(*words, PYTHONPROFILEIMPORTTIME="1")
        assert answer.code == 0
        loaded = imported_modules(answer.err)
        assert {"drysim.scenario", "pydantic.main"} <= loaded
        assert loaded & {"rich", "drysim.records.formats", *HEAVY} == set()


def imported_modules(lines):
    """Return the names of modules that Python reports with PYTHONPROFILEIMPORTTIME."""
    return {line.rpartition("|")[2].strip() for line in lines.splitlines()}


def test_picture_of_a_run_loads_neither_pyplot_nor_other_results(seat, process):
    loaded = imported_modules(process("run", "seat.yaml", PYTHONPROFILEIMPORTTIME="1").err)
    assert {"matplotlib.figure", "drysim.plots.style"} <= loaded
    studies = ("assess", "branches", "design", "fit", "regimes")
    others = {f"drysim.study.{name}" for name in studies}
    assert loaded & {"matplotlib.pyplot", *others} == set()


@pytest.mark.parametrize(
    ("work", "documented"),
    [
        ("import drysim.cli; drysim.cli.main(['run', 'seat.yaml', '--quiet'])", False),
        ("import drysim; drysim.plot(drysim.run(drysim.load('seat.yaml')))", True),
        ("import drysim; drysim.report(drysim.run(drysim.load('seat.yaml')))", True),
    ],
    ids=["command", "session", "report of a session"],
)
def test_only_a_session_has_the_docstrings_of_matplotlib(work, documented, seat):
    shown = "from matplotlib.lines import Line2D; print('alpha:' in (Line2D.set.__doc__ or ''))"
    assert output_of(f"{work}; {shown}", seat.parent) == f"{documented}\n"
