"""Settings of other programs in the environment, and folders that cannot be written."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from drysim.cli.process import set_environment
from drysim.plots import style
from drysim.system import private_folder

BACKENDS = ["module://matplotlib_inline.backend_inline", "module://missing", "nonsense", ""]
"""What MPLBACKEND may say; a kernel of Jupyter sets the first."""


NO_HOME = {"HOME": "/dev/null/home", "XDG_CACHE_HOME": "/dev/null/cache"}
"""The environment of a user whose home folder cannot be written."""


@pytest.fixture
def python(tmp_path):
    """Return a function that runs a program in a process of its own, in an empty folder."""

    def run(program, **environment):
        done = subprocess.run(
            [sys.executable, "-c", program],
            cwd=tmp_path, env={**os.environ, "DRYSIM_ENGINE": "plain", **environment},
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


def test_command_draws_whatever_the_settings_of_libraries_say(seat, process):
    cache = seat.parent / "tmp"
    cache.mkdir()
    (seat.parent / ".numba_config.yaml").write_text("disable_jit: 1\n")
    strange = {
        "MPLBACKEND": BACKENDS[0], "NUMBA_DISABLE_JIT": "1", "TMPDIR": str(cache),
        "MPLCONFIGDIR": "/dev/null", **NO_HOME,
    }  # fmt: skip
    assert process("run", "seat.yaml", "--quiet", **strange) == (0, "", "")
    assert (seat.parent / "out/seat/response.png").exists()
    # The list of fonts is kept where the next command finds it, and nothing else is left.
    (kept,) = cache.iterdir()
    assert [file.name.partition("-")[0] for file in kept.glob("drysim/matplotlib/*")] == [
        "fontlist"
    ]


@pytest.fixture
def environment(monkeypatch):
    """Return the environment, restored after the test."""
    for name in ("MPLBACKEND", "MPLCONFIGDIR", "NUMBA_DISABLE_JIT", "OPENBLAS_NUM_THREADS"):
        monkeypatch.setenv(name, "")
    private_folder.cache_clear()
    yield os.environ
    private_folder.cache_clear()


def test_command_leaves_the_folder_of_matplotlib_where_it_has_none(environment, monkeypatch):
    monkeypatch.setattr("drysim.cli.process.private_folder", lambda _: None)
    environment["MPLCONFIGDIR"] = "mine"
    set_environment()
    assert environment["MPLCONFIGDIR"] == "mine"
    assert environment["MPLBACKEND"] == "agg"
    assert environment["NUMBA_DISABLE_JIT"] == "0"


@pytest.mark.parametrize("backend", BACKENDS)
def test_figures_are_drawn_whatever_backend_is_named_and_the_name_stays(python, backend):
    program = (
        "import os; from drysim.plots import style\n"
        "with style.picture_style(): print(style.panel_grid(1, 1)[0])\n"
        "print(os.environ['MPLBACKEND'])"
    )
    drawn, name = python(program, MPLBACKEND=backend).splitlines()
    assert drawn.startswith("Figure(")
    assert name == backend


def test_backend_that_exists_is_in_use_after_a_figure_was_drawn(python):
    program = (
        "from drysim.plots import style; matplotlib = style.import_matplotlib()\n"
        "print(matplotlib.get_backend())"
    )
    assert python(program, MPLBACKEND="svg") == "svg\n"


def test_matplotlib_that_cannot_be_loaded_is_an_error_with_a_way_out(python, tmp_path):
    (tmp_path / "matplotlibrc").write_bytes(b"\xff\xfe\0")
    program = (
        "import drysim; from drysim.plots import style\n"
        "try: style.import_matplotlib()\n"
        "except drysim.DrysimError as fault: print(fault.message, fault.hint, sep='\\n')"
    )
    message, hint = python(program).splitlines()
    assert message.startswith("matplotlib cannot be loaded: UnicodeDecodeError: ")
    assert "matplotlibrc" in hint
    assert "--no-plots" in hint


def test_python_computes_without_any_writable_folder(python, seat):
    program = (
        "import tempfile, drysim\n"
        "def nothing(): raise FileNotFoundError(2, 'No usable temporary directory')\n"
        "tempfile._get_default_tempdir = nothing\n"
        "print(drysim.run(drysim.load('seat.yaml')))"
    )
    assert python(program, HOME="/dev/null/x", XDG_CACHE_HOME="/dev/null/x").startswith(
        "<Outcome"
    )


@pytest.mark.parametrize("ipython", [True, False])
def test_plot_loads_the_backend_of_a_notebook_that_shows_its_figures(
    monkeypatch, tmp_path, ipython
):
    (tmp_path / "shows_figures.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "module://shows_figures")
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    if ipython:
        monkeypatch.setitem(sys.modules, "IPython", object())
    style.register_with_notebook()
    assert ("shows_figures" in sys.modules) == ipython
    sys.modules.pop("shows_figures", None)
