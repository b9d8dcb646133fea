"""What a case costs, known before it is solved: memory, computing time and output.

Memory
    Bytes per step of the response; a case that exceeds the machine is refused.

Work
    The event search takes steps of about one radian of the fastest oscillation, so the total
    phase of each oscillation bounds the computing time (`largest_oscillation`).

Output
    response.csv has one row per step.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, pi, sqrt
from typing import NamedTuple

from drysim import system
from drysim.approach.stick_slip import ExactApproach
from drysim.core.model import DynamicLaw, PiecewiseLaw, Sines
from drysim.errors import WarningMessage
from drysim.study.case import Case
from drysim.wording import format_number

# Memory.

BYTES_PER_STEP = 64
"""Memory per step where the complete response is stored (fixed steps) or noise is generated;
the measured maximum is 50, in the transforms of noise."""

BYTES_PER_STREAMED_STEP = 8
"""Memory per step where the response is computed part by part: only events are stored, 25 bytes
each and twice that while they are joined. One event in 24 steps took 2 bytes per step."""

BYTES_PER_WEIGHTED_STEP = 96
"""Additional memory per step for weighting or spectra; measured: 77."""

BYTES_PER_SEED = 6_000
"""Memory for the metrics of one seed; measured: 3,500, and 5,000 with the output."""

GIGA = 1e9


def memory_shortage(steps: int, weighted: bool = False, streamed: bool = False) -> str:
    """Return a message if a response of so many steps does not fit into memory, else ""."""
    required = response_memory(steps, weighted, streamed)
    return shortage_message(
        f"{steps:.4g} steps", required, "use a longer step or a shorter duration"
    )


def response_memory(steps: int, weighted: bool = False, streamed: bool = False) -> float:
    """Return the memory for a response of so many steps [bytes].

    A response that is weighted or transformed is never streamed.
    """
    if streamed and not weighted:
        return float(steps * BYTES_PER_STREAMED_STEP)
    return float(steps * (BYTES_PER_STEP + weighted * BYTES_PER_WEIGHTED_STEP))


def is_streamed(case: Case) -> bool:
    """Whether a long response of the case is computed part by part, never stored completely."""
    varies = isinstance(case.law, PiecewiseLaw) and case.law.varies
    return isinstance(case.approach, ExactApproach) and not varies


def shortage_message(what: str, required: float, remedy: str) -> str:
    """Return the message for a shortage of memory, or "" if `required` [bytes] is available."""
    available = system.total_memory()
    if required <= available:
        return ""
    return (
        f"{what} need {required / GIGA:.3g} GB of memory, this machine has "
        f"{available / GIGA:.3g} GB; {remedy}"
    )


def check_effort(case: Case) -> None:
    """Raise a ScenarioError for a case that takes too much memory or time."""
    measure = case.scenario.measure
    weighted = bool(measure.weights or measure.spectra)
    if shortage := memory_shortage(case.steps, weighted, is_streamed(case)):
        sentence = f"solver.step and measure.duration: {shortage}"
        raise case.scenario.error(sentence, "measure.duration")
    points = case.steps * case.approach.substeps(case.plant, case.law, case.step)
    if shortage := memory_shortage(points, weighted, is_streamed(case)):
        key = f"solver.{case.approach.approach}"
        raise case.scenario.error(f"{key} subdivides each step: {shortage}", key)
    check_work(case)


# Work: steps of the event search are at most about a radian of each oscillation.

WORK_PER_FIT = 2000
"""Number of solutions in a fit, for the choice of the engine."""

STEPS_PER_WAVE = 5
"""Cost of one sine at one grid point, in steps of sampled motion."""

SLOW_SCENE = "slow-scene"
"""Slug of the warning, which is also shown before the work begins."""

MAX_RADIANS_PER_STEP = 30.0
"""Phase per step [rad] above which a step takes 100 times longer than usual. Measured: 30 ns
for a sampled step with its metrics, 1 µs for a step under sines, 0.1 to 0.5 µs per radian."""

SECONDS_PER_RADIAN = 5e-7
"""Longest time per radian, or per decay time of a velocity in a series, compiled [s]."""

SECONDS_PER_SERIES_RADIAN = 1.5e-4
"""Longest time per radian for Taylor series with bristle states [s]."""

SECONDS_PER_BRISTLE_DECAY = 3e-5
"""Time per step of such a series, about one step per decay time of a strong damper [s]."""

MAX_RADIANS = 1e10
"""Largest phase of a case [rad]: more than an hour of work, beyond double precision."""

DAMPER = "damping time constants"
BRISTLE_DAMPER = "damping time constants of the bristles"
"""Names of dampers in messages; their work is counted in decay times instead of radians."""

RINGDOWN_RADIANS = 40.0
"""A free oscillation with damping ratio ξ decays below double precision within 40/ξ rad."""


class Oscillation(NamedTuple):
    """Phase that an oscillation or a decay runs through within the window of a case."""

    key: str
    """Scenario key that causes it."""
    name: str
    radians: float
    """Phase [rad], or number of decay times of a damper."""
    minimum: float
    """Lower bound of the work, in units of `SECONDS_PER_RADIAN`; a damped oscillation decays
    before its full phase."""
    each: float = SECONDS_PER_RADIAN
    """Longest time per radian or decay time [s]."""

    def describe(self, radians: float) -> str:
        """Describe so many radians, or decay times of a damper, in words."""
        if self.name in (DAMPER, BRISTLE_DAMPER):
            return f"{format_number(radians)} {self.name}"
        return f"{format_number(radians)} rad of the {self.name}"


def largest_oscillation(case: Case) -> Oscillation:
    """Return the oscillation with the largest phase within the window of a case."""
    return max(
        _oscillations(case),
        key=lambda oscillation: oscillation.radians,
        default=Oscillation("", "", 0.0, 0.0),
    )


def _oscillations(case: Case) -> Iterator[Oscillation]:
    """Yield excitation, normal force, and the springs and dampers if the mass may move."""
    if not isinstance(case.approach, ExactApproach):
        return  # fixed steps do not resolve oscillations
    span, fastest, law = case.window[1], inf, case.law
    if isinstance(case.motion, Sines):
        fastest = max(case.motion.f, default=0.0)
        radians = 2.0 * pi * fastest * span
        yield Oscillation("excitation", "base motion", radians, radians)
    if not (isinstance(law, DynamicLaw) or law.is_elastic) and law.variation:
        fastest = max(fastest, law.omega / (2.0 * pi))
        radians = law.omega * span
        yield Oscillation("friction.normal_variation", "normal force", radians, radians)
    m, k_x, b = case.plant
    kicks = 2.0 * (fastest * span + 1.0)
    moves = all(warning.slug != "will-not-move" for warning in case.warnings)
    if isinstance(law, DynamicLaw) and moves:
        decays = b / m * span
        yield Oscillation("oscillator.damping", DAMPER, decays, decays)
    if k_x > 0.0 and moves:
        key = f"oscillator.{case.scenario.oscillator.spring_key}"
        yield _free_oscillation(key, "oscillator", case.plant, span, kicks)
    if isinstance(law, DynamicLaw) and law.sigma_0:
        plant, name = (m, law.sigma_0, b + law.sigma_1), "oscillation on the bristles"
        rings = _free_oscillation("friction.bristle_stiffness", name, plant, span, kicks)
        yield rings._replace(each=SECONDS_PER_SERIES_RADIAN)
        decays = law.sigma_1 / m * span
        minimum = decays * SECONDS_PER_BRISTLE_DECAY / SECONDS_PER_RADIAN
        yield Oscillation(
            "friction.bristle_damping",
            BRISTLE_DAMPER,
            decays,
            minimum,
            SECONDS_PER_BRISTLE_DECAY,
        )
    if isinstance(law, PiecewiseLaw) and law.is_elastic:
        name = "oscillation on the contact"
        yield _free_oscillation(
            "friction.tangential_stiffness", name, (m, law.k_t, b), span, kicks
        )


def _free_oscillation(
    key: str, name: str, plant: tuple[float, float, float], span: float, kicks: float
) -> Oscillation:
    """Return the phase of a free oscillation that is excited `kicks` times in a span [s]."""
    m, k, b = plant
    radians, xi = sqrt(k / m) * span, 0.5 * b / sqrt(k * m)
    return Oscillation(
        key, name, radians, min(radians, kicks * RINGDOWN_RADIANS / xi) if xi else radians
    )


def check_work(case: Case) -> None:
    """Raise a ScenarioError for a case that takes more than `MAX_RADIANS`."""
    most = max(_oscillations(case), key=lambda oscillation: oscillation.minimum, default=None)
    if most is None or most.minimum <= MAX_RADIANS:
        return
    hours = format_number(most.minimum * SECONDS_PER_RADIAN / 3600.0, "h", digits=2)
    sentence = (
        f"{most.key}: {format_number(case.window[1], 's')} span "
        f"{most.describe(min(most.minimum, most.radians))}, up to {hours} of work; "
        "check the units, or use a shorter duration"
    )
    raise case.scenario.error(sentence, most.key)


def effort_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn when a step takes 100 times longer than usual."""
    most = largest_oscillation(case)
    each = most.radians / max(case.steps, 1)
    if each > MAX_RADIANS_PER_STEP:
        time = format_number(most.radians * most.each, "s", digits=2)
        whole = f"up to {time} in total"
        if case.period is not None:
            whole = f"up to {time} per period, and the orbit may take many periods"
        sentence = (
            f"one step spans {most.describe(each)}; this may take 100 times longer than usual, "
            f"{whole}"
        )
        numbers = {"radians": most.radians, "radians_a_step": each}
        yield WarningMessage(SLOW_SCENE, sentence, numbers)


def case_cost(case: Case) -> int:
    """Return the cost of a case, in steps of sampled motion; with a fit block that of the fit.

    A fit may follow a run in the same process, whose engine is chosen once.
    """
    waves = len(case.motion.f) if isinstance(case.motion, Sines) else 0
    radians = largest_oscillation(case).radians
    a_step = max(1 + STEPS_PER_WAVE * waves, case.step_cost.steps)
    once = max(case.steps * a_step, round(STEPS_PER_WAVE * radians))
    return once if case.scenario.fit is None else WORK_PER_FIT * once


# Output.

LARGE_RESPONSE = "large-response"
"""Slug of the warning, which is also shown before the work begins."""

BYTES_PER_ROW = 100
"""Typical bytes per row of response.csv; 40 while the mass is at rest."""

LARGE_RESPONSE_BYTES = 1e9
"""Size of response.csv from which the warning is shown [bytes]."""


def response_bytes(case: Case) -> float:
    """Return the estimated size of response.csv [bytes]."""
    return float(BYTES_PER_ROW * (case.steps + 1))


def volume_warnings(case: Case) -> Iterator[WarningMessage]:
    """Warn when the response of a run is large; a sweep writes none."""
    volume = response_bytes(case)
    if volume > LARGE_RESPONSE_BYTES and not case.scenario.sweep:
        sentence = (
            f"response.csv will have {case.steps + 1:.3g} rows, about {volume / GIGA:.3g} GB; "
            f"use a step longer than {format_number(case.step, 's')} or a shorter duration"
        )
        yield WarningMessage(
            LARGE_RESPONSE, sentence, {"rows": case.steps + 1, "bytes": volume}
        )
