"""Doctor: whether this installation gives right numbers, by versions, engine, known answers."""

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
"""Output grid of the known answers [s]; the answers do not depend on it."""

DECAY_STOP = 22.42355635
"""Time [s] at which m = k = F = 1 comes to rest from x = 12, v = 6."""

DEN_HARTOG = 1.307242
"""x_max k_x/P at frequency ratio 1, damping ratio 1/3 and F_fk/P = 0.1."""

ANSWER_TOLERANCE = 1e-6
"""Both answers are known to the digits printed above, the last one rounded."""


@dataclass(frozen=True)
class Finding:
    """One line of the doctor: what was looked at, whether it is in order, and how it is."""

    name: str
    passed: bool
    sentence: str


def check_installation() -> list[Finding]:
    """Give everything that the doctor knows about this installation."""
    answers = (free_decay, den_hartog, standstill)
    return [*versions(), *check_engine(), *(run_check(answer) for answer in answers)]


def versions() -> list[Finding]:
    """Give the versions of drysim, Python and everything that drysim stands on."""
    python = f"{platform.python_version()} on {platform.platform(terse=True)}"
    own = [Finding("drysim", True, drysim.__version__), Finding("python", True, python)]
    least = minimum_versions()
    extras = [name for name in least if name not in PACKAGES and installed_version(name)]
    return own + [check_package(name, least.get(name, "")) for name in (*PACKAGES, *extras)]


def minimum_versions() -> dict[str, str]:
    """Return the minimum version of each package that drysim or an extra of it declares.

    It is empty where drysim runs from its source without being installed.
    """
    try:
        declared = requires("drysim") or []
    except PackageNotFoundError:
        return {}
    usual = (each for each in declared if not re.search(r"extra == .(dev|test)\b", each))
    found = (re.match(r"([\w-]+)>=([\w.]+)", each) for each in usual)
    return {match[1].lower(): match[2] for match in found if match}


def installed_version(name: str) -> str:
    """Return the version of a package; empty where it is missing."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def check_package(name: str, least: str = "") -> Finding:
    """Give the version of one package, or that it is missing or older than the minimum."""
    found = installed_version(name)
    wanted = f"'{name}>={least}'" if least else name
    command = f"python -m pip install {wanted}"
    if not found:
        return Finding(name, False, f"is missing; install it: {command}")
    if least and version_numbers(found) < version_numbers(least):
        return Finding(name, False, f"{found} is older than {least}; update it: {command}")
    return Finding(name, True, found)


def version_numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of a version; `1.0` is `1`."""
    numbers = [int(number) for number in re.findall(r"\d+", text.partition("+")[0])]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)


def check_engine() -> list[Finding]:
    """Give the engine in force and the state of the folder that keeps compiled kernels.

    The known answers are short, so `auto` settles on the plain engine, as it does for any short
    job; DRYSIM_ENGINE=compiled lets the doctor look at the compiled one.
    """
    from drysim.core import compile

    word = os.environ.get(compile.ENGINE_VARIABLE, compile.AUTO)
    try:
        compile.engine()
    except ValueError as fault:
        return [Finding("engine", False, str(fault))]
    if word == compile.AUTO:
        word += f": plain up to {compile.MAX_PLAIN_STEPS} steps, compiled above"
        compile.choose_engine(0)
    cache = compile.cache_folder()
    if cache is None:
        state = "no folder can be written: every process compiles anew; set XDG_CACHE_HOME"
    else:
        kernels = sum(1 for _ in cache.rglob("*.nbi"))
        state = f"{cache}, {kernels} kernels kept"
    return [Finding("engine", True, word), Finding("cache", cache is not None, state)]


def run_check(answer: Callable[[], Finding]) -> Finding:
    """Give a known answer, also when the numerics fail on the way."""
    try:
        return answer()
    except DrysimError as fault:
        return Finding(answer.__name__.replace("_", " "), False, str(fault))


def free_decay() -> Finding:
    """Find the instant at which a block on a spring comes to rest."""
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
    return Finding("free decay", passed, f"stops at {stop:.8f} s, known {DECAY_STOP:.8f} s")


def den_hartog() -> Finding:
    """Find the amplitude of steady sliding at resonance."""
    peak, _ = steady_metrics(CoulombLaw(0.1, 0.1))
    passed = peak is not None and abs(peak - DEN_HARTOG) < ANSWER_TOLERANCE
    return Finding("Den Hartog", passed, f"amplitude {peak}, known {DEN_HARTOG}")


def standstill() -> Finding:
    """Find that a base that pulls exactly as hard as the static limit moves nothing."""
    peak, T_a = steady_metrics(CoulombLaw(1.0, 1.0))
    passed = (peak, T_a) == (0.0, 1.0)
    return Finding("standstill", passed, f"peak {peak!r}, T_a {T_a!r}, known 0.0 and 1.0")


def steady_metrics(law: CoulombLaw) -> tuple[float | int | None, float | int | None]:
    """Give x_r_peak [m] and T_a [-] of the orbit from rest at resonance, damping ratio 1/3."""
    from drysim.approach.stick_slip import StickSlip
    from drysim.metrics.table import measure

    approach, plant = StickSlip(), Plant(1.0, 1.0, 2 / 3)
    base = Sines((1.0,), (0.5 / pi,), (0.0,))
    orbit = approach.orbit(plant, law, base, State(0.0, 0.0), 2 * pi)
    repetition = orbit.periods * 2 * pi
    response = approach.solve(plant, law, base, orbit.state, OUTPUT_STEP, repetition)
    assert response.trajectory is not None
    metrics = measure(response.trajectory, (0.0, repetition), None)
    return metrics["x_r_peak"], metrics["T_a"]
