"""The engines: how one is settled, and where compiled kernels are kept."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from seat import SEAT

import drysim
from drysim.core import compile
from drysim.errors import DrysimError
from drysim.system import private_folder


@pytest.mark.parametrize(
    ("word", "engine"), [("plain", "plain"), ("compiled", "compiled"), ("auto", "compiled")]
)
def test_environment_names_the_engine(monkeypatch, word, engine):
    monkeypatch.setenv(compile.ENGINE_VARIABLE, word)
    assert compile.engine() == engine


def test_another_word_is_refused(monkeypatch):
    monkeypatch.setenv(compile.ENGINE_VARIABLE, "turbo")
    with pytest.raises(ValueError, match="plain, compiled or auto, not 'turbo'"):
        compile.engine()


@pytest.fixture
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """Return an empty cache folder, for this test alone."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    private_folder.cache_clear()
    yield tmp_path
    private_folder.cache_clear()


def test_kernels_are_kept_in_the_users_cache_under_a_name_of_their_source(own_cache):
    folder = compile.cache_folder()
    assert folder is not None
    assert folder.path == own_cache / "drysim" / f"kernels-{compile.source_key()}"
    assert folder.path.is_dir()


@pytest.fixture
def numba_settings(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the settings of numba, as a test may change them."""
    monkeypatch.delenv(compile.ENGINE_VARIABLE, raising=False)
    compile.is_always_plain.cache_clear()
    import numba

    yield numba.config
    compile.is_always_plain.cache_clear()


def test_kernels_are_plain_where_numba_is_switched_off(numba_settings, monkeypatch):
    assert (compile.engine(), compile.is_plain()) == ("compiled", False)
    monkeypatch.setattr(numba_settings, "DISABLE_JIT", 1)
    compile.is_always_plain.cache_clear()
    assert (compile.engine(), compile.is_plain()) == ("plain", True)


@pytest.mark.parametrize(
    "text",
    ["[1, 2", "- a list", "!!python/name:os.system", "\udcff"],
    ids=lambda text: text[:4],
)
def test_settings_that_numba_cannot_read_are_named_with_a_way_out(tmp_path, text):
    (tmp_path / ".numba_config.yaml").write_bytes(text.encode(errors="surrogateescape"))
    done = subprocess.run(
        [sys.executable, "-c", "from drysim.core.compile import import_numba; import_numba()"],
        cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    *_, sentence, way_out = done.stderr.splitlines()
    assert "DrysimError: the compiler (numba) cannot be loaded: " in sentence
    assert "remove .numba_config.yaml from this folder" in way_out


def test_compiler_that_cannot_be_loaded_is_told_with_a_way_out(monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    with pytest.raises(
        DrysimError, match=r"the compiler \(numba\) cannot be loaded: "
    ) as fault:
        compile.import_numba()
    assert "DRYSIM_ENGINE=plain" in fault.value.hint


class Evil:
    """Runs a program when it is unpickled."""

    def __reduce__(self) -> Any:
        return os.mkdir, ("evil",)


def test_file_of_a_kernel_is_not_unpickled_unless_it_is_whole(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    data = {"numbers": [1.0, 2.0]}
    whole = compile.seal(pickle.dumps(data))
    assert compile.unseal(whole) == data
    spoiled = bytearray(whole)
    spoiled[-1] ^= 255
    for words in (pickle.dumps(Evil()), whole[:-1], whole + b"\0", bytes(spoiled), b""):
        with pytest.raises(ValueError, match="does not match"):
            compile.unseal(words)
    assert not (tmp_path / "evil").exists()


@pytest.fixture
def settled(monkeypatch: pytest.MonkeyPatch, own_cache: Path) -> Callable[..., str]:
    """Return the engine that `auto` settles on in a process that has loaded no kernel yet."""

    def engine(steps: int, *kernels: str) -> str:
        monkeypatch.setenv(compile.ENGINE_VARIABLE, compile.AUTO)
        monkeypatch.delitem(sys.modules, "drysim.core.oscillator", raising=False)
        compile.choose_engine(steps, *kernels)
        return os.environ[compile.ENGINE_VARIABLE]

    return engine


def test_short_job_stays_plain_and_a_long_one_is_compiled(settled):
    assert settled(compile.MAX_PLAIN_STEPS) == compile.PLAIN
    assert settled(compile.MAX_PLAIN_STEPS + 1) == compile.COMPILED


def test_kernels_of_a_law_are_compiled_for_the_first_time_only_where_it_pays(settled):
    middling, much = 2 * compile.MAX_PLAIN_STEPS, 11 * compile.MAX_PLAIN_STEPS
    assert settled(middling, "taylor.march_taylor") == compile.PLAIN
    assert settled(much, "taylor.march_taylor") == compile.COMPILED
    folder = compile.cache_folder()
    assert folder is not None
    (folder.path / "taylor.march_taylor-0123.nbc").touch()
    assert settled(middling, "taylor.march_taylor") == compile.COMPILED
    assert settled(middling, "march.march_modes sampled.march") == compile.PLAIN


def test_session_compiles_when_the_jobs_of_a_law_have_much_to_do_and_from_then_on(own_cache):
    folder = compile.cache_folder()
    assert folder is not None
    (folder.path / "sampled.march-0123.nbc").touch()
    session, most = compile.Session(), compile.MAX_PLAIN_STEPS
    session.choose(most, "sampled.march")
    session.choose(compile.COLD_CACHE_FACTOR * most, "taylor.march_taylor")
    assert session.engine == compile.PLAIN
    session.choose(1, "sampled.march")
    assert session.engine == compile.COMPILED
    session.choose(1, "march.march_modes")
    assert session.engine == compile.COMPILED


def test_session_compiles_kernels_that_are_not_cached_for_ten_times_as_much(own_cache):
    session, most = compile.Session(), compile.COLD_CACHE_FACTOR * compile.MAX_PLAIN_STEPS
    session.choose(most, "taylor.march_taylor")
    assert session.engine == compile.PLAIN
    session.choose(1, "taylor.march_taylor")
    assert session.engine == compile.COMPILED


SESSION = """
import pickle
import sys
from math import isclose
import numpy as np
import drysim

scenario = drysim.load("seat.yaml")
first = pickle.loads(pickle.dumps(drysim.run(scenario)))
assert "numba" not in sys.modules and "drysim.core.sampled" in sys.modules
from drysim.core import compile
from drysim.core.oscillator import flow

assert flow.plain.__globals__["exponential_difference"].__class__.__name__ == "function"
compile.choose_engine(compile.MAX_PLAIN_STEPS + 1)
plain, calls = compile.SessionKernel.plain, []
compile.SessionKernel.plain = property(lambda one: calls.append(one) or plain.fget(one))
second = drysim.run(scenario)
assert [each.response.numerics.engine for each in (first, second)] == ["plain", "compiled"]
assert not calls, calls
for name in ("x_r", "v_r", "x_dd", "F_f"):
    assert np.array_equal(getattr(first.response, name), getattr(second.response, name)), name
assert first.metrics.keys() == second.metrics.keys()
for name, value in first.metrics.items():
    # A residual is nothing but rounding.
    assert value == second.metrics[name] or isclose(
        value, second.metrics[name], rel_tol=1e-11, abs_tol=1e-14
    ), name
old, new = (each.response.trajectory.state(1.2345) for each in (first, second))
assert calls and tuple(old) == tuple(new)
"""


def test_first_run_of_a_session_is_plain_and_a_large_job_compiled(tmp_path):
    noise = "{kind: standard, class: EM3, duration: 5 s, seed: 1}"
    harmonic = "{kind: harmonic, frequency: 1.6, rms: 1.0}"
    (tmp_path / "seat.yaml").write_text(SEAT.replace(harmonic, noise))
    environment = {key: word for key, word in os.environ.items() if key != "DRYSIM_ENGINE"}
    done = subprocess.run(
        [sys.executable, "-c", SESSION],
        cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


FEW = """\
from drysim.core import compile, fixed_step, forcing, march, oscillator, orbit

modules = fixed_step, forcing, march, oscillator, orbit
kernels = {
    id(one): one
    for module in modules
    for one in vars(module).values()
    if isinstance(one, compile.CompiledKernel)
}
assert len(kernels) > 50
assert all(one.dispatcher is None for one in kernels.values())
fixed_step.regularised_sign(1.0, 1.0, 1.0)
known = [one for one in kernels.values() if one.dispatcher is not None]
assert known == [fixed_step.regularised_sign], known
"""


def test_numba_gets_to_know_only_the_kernels_that_a_command_calls():
    environment = {**os.environ, "DRYSIM_ENGINE": "compiled"}
    done = subprocess.run(
        [sys.executable, "-c", FEW], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


ANNOUNCED = """
from drysim.core import compile, fixed_step
compile.before_compiling(lambda: print("compiling"))
fixed_step.regularised_sign(1, 1.0, 1.0)
fixed_step.regularised_sign(1.0, 1.0, 1.0)
"""


def test_compilation_is_announced_once_and_not_if_the_kernel_is_cached(tmp_path):
    environment = {
        **os.environ, "DRYSIM_ENGINE": "compiled", "XDG_CACHE_HOME": str(tmp_path)
    }  # fmt: skip
    words = [sys.executable, "-c", ANNOUNCED]
    printed = [subprocess.check_output(words, env=environment, text=True) for _ in range(2)]
    assert printed == ["compiling\n", ""]


# Compiled kernels on disk: written beside no package, shared by processes, never stale.


ARCTAN = 1
PROGRAM = (
    "from drysim.core.fixed_step import regularised_sign as share\n"
    f"print(share({ARCTAN}, 1.0, 1.0), len(share.compiled.stats.cache_hits))\n"
)
HALF = 0.5
"""2/π atan(1)."""


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Path]:
    """Return a folder of packages with a drysim that nobody can write to."""
    site = tmp_path / "site"
    shutil.copytree(
        Path(drysim.__file__).parent,
        site / "drysim",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    for path in (site, *site.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    yield site
    for path in (site, *site.rglob("*")):
        path.chmod(0o755)


def start(site: Path) -> subprocess.Popen[str]:
    """Begin a process that compiles one kernel of a drysim and calls it."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(site),
        "PYTHONDONTWRITEBYTECODE": "1",
        "XDG_CACHE_HOME": str(site.parent / "cache"),
        "DRYSIM_ENGINE": "compiled",
    }
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        env=environment,
        cwd=site.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def answer(process: subprocess.Popen[str]) -> tuple[float, bool]:
    """Return what the kernel gave, and whether it came from the disk."""
    out, err = process.communicate()
    assert process.returncode == 0, err
    value, hits = out.split()
    return float(value), hits != "0"


@pytest.mark.slow
@pytest.mark.by_hand
def test_kernels_are_kept_although_the_package_can_only_be_read(site):
    before = sorted(site.rglob("*"))
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)
    assert sorted(site.rglob("*")) == before


@pytest.mark.slow
@pytest.mark.by_hand
def test_processes_that_compile_at_once_do_not_disturb_each_other(site):
    answers = [answer(process) for process in [start(site) for _ in range(3)]]
    assert [value for value, _ in answers] == [HALF] * 3
    assert answer(start(site)) == (HALF, True)


@pytest.mark.slow
@pytest.mark.by_hand
def test_upgrade_of_the_same_size_and_time_is_compiled_anew(site):
    assert answer(start(site))[0] == HALF
    source = site / "drysim" / "core" / "fixed_step.py"
    written, text = source.stat(), source.read_text()
    changed = text.replace("2.0 / math.pi", "4.0 / math.pi")
    assert changed != text
    source.chmod(0o644)
    source.write_text(changed)
    os.utime(source, ns=(written.st_atime_ns, written.st_mtime_ns))
    assert source.stat().st_size == written.st_size
    assert answer(start(site)) == (2 * HALF, False)


@pytest.mark.slow
@pytest.mark.by_hand
@pytest.mark.parametrize("zeros", [0, 64], ids=["cut short", "ending in zeros"])
def test_kernels_that_a_power_loss_cut_short_are_compiled_anew(site, zeros):
    assert answer(start(site)) == (HALF, False)
    kept = list((site.parent / "cache").rglob("*.nbc"))
    assert kept
    for file in kept:
        whole = file.read_bytes()
        file.write_bytes(whole[: -len(whole) // 3] + bytes(zeros))
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)


@pytest.mark.slow
@pytest.mark.by_hand
def test_kernel_with_a_changed_byte_is_not_run(site):
    assert answer(start(site)) == (HALF, False)
    (kept,) = (site.parent / "cache").rglob("*.nbc")
    whole = bytearray(kept.read_bytes())
    whole[len(whole) // 2] ^= 255
    kept.write_bytes(whole)
    assert answer(start(site)) == (HALF, False)
    assert answer(start(site)) == (HALF, True)
