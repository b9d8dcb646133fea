"""A Python session: pictures in threads, Ctrl-C while loading, results that are pickled."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import threading

import pytest
import yaml

import drysim

SCENE = {
    "drysim": 1,
    "name": "session",
    "oscillator": {"mass": 5, "natural_frequency": 5, "damping_ratio": 0.1},
    "friction": {"kinetic": 5},
    "stroke": {"limit": 0.05},
    "excitation": {"kind": "shock", "pulse": "half-sine", "amplitude": 50, "duration": 0.01},
    "solver": {"step": 1e-3},
    "measure": {"duration": 0.3},
}


@pytest.fixture
def scenario(tmp_path):
    """Load a short shock."""
    file = tmp_path / "session.yaml"
    file.write_text(yaml.safe_dump(SCENE))
    return drysim.load(file)


def test_threads_draw_and_report_without_mixing_their_settings(scenario, monkeypatch):
    import matplotlib

    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")

    outcome, before, faults = drysim.run(scenario), dict(matplotlib.rcParams), []
    reports = []
    barrier = threading.Barrier(4)

    def work():
        barrier.wait()
        try:
            drysim.plot(outcome)
            reports.append(drysim.report(outcome))
        except Exception as fault:
            faults.append(fault)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not faults
    assert len({*map(str, reports)}) == 1
    assert dict(matplotlib.rcParams) == before


INTERRUPTED = """
    import importlib.abc, os, signal, sys

    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background

    class Interrupting(importlib.abc.MetaPathFinder):
        def find_spec(self, name, path=None, target=None):
            if name == sys.argv[1]:
                sys.meta_path.remove(self)
                os.kill(os.getpid(), signal.SIGINT)
            return None

    import drysim
    sys.meta_path.insert(0, Interrupting())
    try:
        drysim.run(drysim.load("session.yaml"))
        print("not interrupted")
    except KeyboardInterrupt:
        pass
    print(drysim.run(drysim.load("session.yaml")).metrics["x_r_peak"])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C")
@pytest.mark.parametrize(
    "module", ["numpy._core.multiarray", "numpy.matrixlib", "pydantic", "drysim.core.model"]
)
def test_an_import_that_is_interrupted_can_be_repeated(module, scenario, tmp_path):
    if module.startswith("numpy._core"):
        pytest.importorskip("numpy", minversion="2")
    program = [sys.executable, "-c", textwrap.dedent(INTERRUPTED), module]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert [float(line) for line in done.stdout.splitlines()] == [
        drysim.run(scenario).metrics["x_r_peak"]
    ]
