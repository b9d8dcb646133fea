"""Checks of an installation: versions, engine, and scenes with known solutions."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from math import pi

import drysim
from drysim.core.model import CoulombLaw, Plant, Sines, State
from drysim.errors import DrysimError
from drysim.system import private_folder

PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "pydantic",
    "pyyaml",
    "typer",
    "rich",
    "matplotlib",
    "pint",
)

OUTPUT_STEP = 0.01
"""Output step of these scenes [s]; the exact solution does not depend on it."""

DECAY_STOP = 22.42355635
"""Time at which m = k_x = F_fk = 1 comes to rest from x_r = 12 m, v_r = 6 m/s [s]."""

DEN_HARTOG = 1.30724229
"""Amplitude x_max k_x/P at frequency ratio 1, damping ratio 1/3, F_fk/P = 0.1 [-]."""

ANSWER_TOLERANCE = 1e-8
"""Both values above are known to their last digit, which is rounded."""


@dataclass(frozen=True)
class Finding:
    """Result of one check: its name, whether it passed, and an explanation."""

    name: str
    passed: bool
    sentence: str


def check_installation() -> list[Finding]:
    """Return the results of all checks."""
    answers = (free_decay, den_hartog, standstill)
    return [*versions(), *check_engine(), *(run_check(answer) for answer in answers)]


def versions() -> list[Finding]:
    """Return the versions of drysim, Python and all dependencies."""
    python = f"{platform.python_version()} on {platform.platform(terse=True)}"
    first = [Finding("drysim", True, drysim.__version__), Finding("python", True, python)]
    least = minimum_versions()
    extras = [name for name in least if name not in PACKAGES and installed_version(name)]
    return first + [check_package(name, least.get(name, "")) for name in (*PACKAGES, *extras)]


def minimum_versions() -> dict[str, str]:
    """Return the minimum version that drysim or its extras declare for each package.

    Empty if drysim runs from its source without being installed.
    """
    try:
        declared = requires("drysim") or []
    except PackageNotFoundError:
        return {}
    usual = (each for each in declared if not re.search(r"extra == .(dev|test)\b", each))
    matches = (re.match(r"([\w-]+)>=([\w.]+)", each) for each in usual)
    return {match[1].lower(): match[2] for match in matches if match}


def installed_version(name: str) -> str:
    """Return the version of a package; empty if it is missing."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def check_package(name: str, least: str = "") -> Finding:
    """Return the version of a package, or an error if it is missing or too old."""
    installed = installed_version(name)
    wanted = f"'{name}>={least}'" if least else name
    command = f"python -m pip install {wanted}"
    if not installed:
        return Finding(name, False, f"is missing; install it: {command}")
    if least and version_numbers(installed) < version_numbers(least):
        return Finding(name, False, f"{installed} is older than {least}; update it: {command}")
    return Finding(name, True, installed)


def version_numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of a version; `1.0` equals `1`."""
    numbers = [int(number) for number in re.findall(r"\d+", text.partition("+")[0])]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def check_engine() -> list[Finding]:
    """Return the engine in use and the state of the kernel cache.

    The scenes with known solutions are short, so `auto` solves them without compiling;
    DRYSIM_ENGINE=compiled checks the compiled engine.
    """
    from drysim.core import compile

    word = os.environ.get(compile.ENGINE_VARIABLE, compile.COMPILED)
    try:
        compile.engine()
    except ValueError as fault:
        return [Finding("engine", False, str(fault))]
    if word == compile.AUTO:
        word += f": plain up to {compile.MAX_PLAIN_STEPS} steps, compiled above"
        compile.choose_engine(0)
    cache = compile.cache_folder()
    if cache is None:
        state = "no writable folder: every process compiles again; set XDG_CACHE_HOME"
    else:
        kernels = sum(1 for _ in cache.path.glob("*.nbc"))
        state = f"{cache.path}, {kernels} kernels cached"
    return [Finding("engine", True, word), Finding("cache", cache is not None, state)]


def describe_engine_limits() -> str:
    """Return what keeps kernels from being compiled once for all, and its price; "" if nothing.

    Small jobs are solved in plain Python because they are faster by it: that is no limit.
    """
    from drysim.core import compile

    slow = "kernels run as plain Python, up to 100 times slower"
    if os.environ.get(compile.ENGINE_VARIABLE) == compile.PLAIN:
        return f"{compile.ENGINE_VARIABLE}={compile.PLAIN}: {slow}"
    if os.environ.get("NUMBA_DISABLE_JIT", "0").strip("0 "):
        return f"NUMBA_DISABLE_JIT is set: {slow}"
    if private_folder("matplotlib") is None:  # lies beside that of the kernels
        return "no writable cache folder: each command compiles its kernels anew, 10 s or more"
    return ""


def run_check(answer: Callable[[], Finding]) -> Finding:
    """Run one of the checks; a numerical failure is its result."""
    try:
        return answer()
    except DrysimError as fault:
        return Finding(answer.__name__.replace("_", " "), False, str(fault))


def free_decay() -> Finding:
    """Check the time at which a mass on a spring comes to rest."""
    from drysim.approach.stick_slip import StickSlip

    response = StickSlip().solve(
        Plant(1.0, 1.0, 0.0),
        CoulombLaw(1.0, 1.0),
        Sines((), (), ()),
        State(12.0, 6.0),
        OUTPUT_STEP,
        25.0,
    )
    stop = float(response.events.t[-1])
    passed = abs(stop - DECAY_STOP) < ANSWER_TOLERANCE and bool(response.stuck[-1])
    return Finding("free decay", passed, f"stops at {stop:.8f} s, expected {DECAY_STOP:.8f} s")


def den_hartog() -> Finding:
    """Check the amplitude of continuous sliding at resonance."""
    peak, _ = steady_metrics(CoulombLaw(0.1, 0.1))
    if peak is None:
        return Finding("Den Hartog", False, f"no amplitude, expected {DEN_HARTOG:.8f}")
    passed = abs(peak - DEN_HARTOG) < ANSWER_TOLERANCE
    return Finding("Den Hartog", passed, f"amplitude {peak:.8f}, expected {DEN_HARTOG:.8f}")


def standstill() -> Finding:
    """Check that a base force equal to the static limit does not move the mass."""
    peak, T_a = steady_metrics(CoulombLaw(1.0, 1.0))
    passed = (peak, T_a) == (0.0, 1.0)
    return Finding("standstill", passed, f"peak {peak!r}, T_a {T_a!r}, expected 0.0 and 1.0")


def steady_metrics(law: CoulombLaw) -> tuple[float | int | None, float | int | None]:
    """Return x_r_peak [m] and T_a [-] from rest at resonance, damping ratio 1/3."""
    from drysim.approach.stick_slip import StickSlip
    from drysim.metrics.table import measure
    from drysim.orbits.search import find_orbit

    approach, plant = StickSlip(), Plant(1.0, 1.0, 2 / 3)
    base = Sines((1.0,), (0.5 / pi,), (0.0,))
    orbit = find_orbit(plant, law, base, State(0.0, 0.0), 2 * pi)
    repetition = orbit.periods * 2 * pi
    response = approach.solve(plant, law, base, orbit.state, OUTPUT_STEP, repetition)
    assert response.trajectory is not None
    metrics = measure(response.trajectory, (0.0, repetition), None)
    return metrics["x_r_peak"], metrics["T_a"]
