"""Case: a scenario as numbers, ready to be solved; nothing is computed here.

`prepare` reads the record and refuses what cannot be solved, as far as only the whole case
shows it: a window beyond the end of the motion, spectra that cannot be had, a response that
does not fit into the memory of this machine, more work than anybody waits for. It tells
beforehand what takes long (each turn of what turns fast is followed) and how much a run writes
(its response has a row for every step). `assemble` does the same where the base motion is
known, as for the cases of a sweep and the seeds of an ensemble. At the end stand the hashes by
which two results are seen to stand on the same files and base motions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, pi, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drysim import system
from drysim.approach import Approach
from drysim.approach.stick_slip import Exact
from drysim.core.compile import engine
from drysim.core.model import (
    AnyLaw,
    Dynamic,
    Law,
    Plant,
    Pressed,
    Samples,
    Signal,
    Sines,
    Slider,
    State,
    Stopped,
    blocks,
)
from drysim.errors import Caution, Problem, RecordError, ScenarioError, UsageError
from drysim.excitation.base import Generated
from drysim.excitation.random import Drawn
from drysim.excitation.recorded import Record
from drysim.scenario.load import load
from drysim.scenario.model import Scenario, period
from drysim.scenario.warnings import cautions
from drysim.study import statistics
from drysim.units import Block, short
from drysim.wording import clean_up, excitation, number

WAVE_WORK = 5
"""What a wave adds to a grid point, in steps of sampled motion."""


@dataclass(frozen=True, eq=False)
class Case:
    """Everything that an approach needs, and the scenario that it came from.

    Attributes
    ----------
    scenario : Scenario
    approach
        A member of the shelf, with its options.
    plant, law, motion, start
        The scene.
    step : float
        Distance of the output grid [s].
    window : tuple of float
        Begin and end of the metrics [s]; one period when an orbit is wanted.
    period : float or None
        Period of the excitation [s] when an orbit is wanted.
    cautions : tuple of Caution
        What is to be said before anything is computed.
    """

    scenario: Scenario
    approach: Approach
    plant: Plant
    law: AnyLaw
    motion: Sines | Samples
    start: State
    step: float
    window: tuple[float, float]
    period: float | None
    cautions: tuple[Caution, ...]

    @property
    def steps(self) -> int:
        """Number of steps of the output grid."""
        return round(self.window[1] / self.step)

    @property
    def work(self) -> int:
        """Number of steps of sampled motion that are as much work as this case."""
        waves = len(self.motion.f) if isinstance(self.motion, Sines) else 0
        radians = turns(self).radians
        a_step = max(1 + WAVE_WORK * waves, self.price.of(self.motion))
        return max(self.steps * a_step, round(WAVE_WORK * radians))

    @property
    def price(self) -> Price:
        """What a step costs."""
        return price(self.approach, self.law)

    @property
    def limit(self) -> float | None:
        """Stroke limit x_rM [m], if there is one."""
        stroke = self.scenario.stroke
        return None if stroke is None else stroke.limit

    @property
    def goes_on(self) -> bool:
        """Whether the base may be taken to go on moving as in the window: noise and records."""
        return isinstance(self.scenario.excitation, Drawn | Record)


def require(scenario: Scenario) -> None:
    """Refuse what is no scenario."""
    if not isinstance(scenario, Scenario):
        given = short(repr(scenario))
        raise UsageError(
            f"what is solved is a scenario, as `drysim.load` gives it, not {given}"
        )


def prepare(scenario: Scenario, compared: bool = False) -> Case:
    """Give the case of a scenario: read its record, check that it can be solved.

    Parameters
    ----------
    scenario : Scenario
    compared : bool, optional
        Whether other approaches or laws solve it, too, which use their options.

    Returns
    -------
    Case

    Raises
    ------
    RecordError
        When the record of the excitation, or of the normal force, cannot be used.
    ScenarioError
        When the window of the metrics lies beyond the end of the motion, the spectra cannot be
        had, or the case needs more memory than the machine has.
    UsageError
        When it is no scenario, or the environment names an engine that there is not.
    """
    require(scenario)
    try:
        engine()
    except ValueError as fault:
        raise UsageError(str(fault)) from fault
    seeds = statistics.most(scenario)
    if shortage := _lacking(f"{seeds:.4g} seeds", float(seeds) * BYTES_PER_SEED, "take fewer"):
        raise misfit(scenario, f"excitation.seeds: {shortage}", "excitation.seeds")
    motion = base_motion(scenario)
    law = scenario.law()
    force = law.pressure.cautions if isinstance(law, Pressed) and law.pressure else ()
    known = (*cautions(scenario, motion, compared), *getattr(motion, "cautions", ()), *force)
    case = assemble(scenario, motion, known)
    if refused := refusal(case):
        raise misfit(scenario, *refused)
    return case


def assemble(
    scenario: Scenario, motion: Sines | Samples, remarks: tuple[Caution, ...] = ()
) -> Case:
    """Give the case of a scenario whose base motion is known; errors as in `prepare`."""
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    assert step is not None, "a scenario has a step unless its record owns one"
    repeats = period(scenario) if scenario.measure.steady else None
    case = Case(
        scenario,
        scenario.solver.member(),
        scenario.oscillator.plant(),
        scenario.law(),
        motion,
        scenario.start.state(),
        step,
        window(scenario, motion) if repeats is None else (0.0, repeats),
        repeats,
        remarks,
    )
    weighed = bool(scenario.measure.weights or scenario.measure.spectra)
    if sentence := too_short(case):
        raise misfit(scenario, sentence, "friction.normal_record")
    if shortage := shortage_of(case.steps, weighed, by_parts(case)):
        sentence = f"solver.step and measure.duration: {shortage}"
        raise misfit(scenario, sentence, "measure.duration")
    points = case.steps * case.approach.pieces(case.plant, case.law, step)
    if shortage := shortage_of(points, weighed, by_parts(case)):
        key = f"solver.{case.approach.approach}"
        raise misfit(scenario, f"{key} divides every step: {shortage}", key)
    if excess := excess_of(case):
        raise misfit(scenario, *excess)
    return replace(case, cautions=(*remarks, *effort_cautions(case), *volume_cautions(case)))


def misfit(scenario: Scenario, sentence: str, key: str) -> ScenarioError:
    """Give the error for a key that only the whole case shows to be wrong."""
    problem = scenario.problem(sentence, key)
    name = scenario.origin["file"] or scenario.name
    return ScenarioError(f"{name} is not a scenario yet: 1 problem", (problem,))


ROUNDING = 1e-9
"""Share by which a length may miss a bound that it was meant to meet."""


def base_motion(scenario: Scenario) -> Sines | Samples:
    """Give the motion of the base; a signal that would not fit into memory is not made.

    Raises
    ------
    ScenarioError, RecordError
        When it would not fit, or the record cannot be used.
    """
    excitation, step, measure = scenario.excitation, scenario.solver.step, scenario.measure
    end = None if measure.duration is None else measure.settle + measure.duration
    span, block = end, "measure"
    if excitation.own_end:
        span, block = getattr(excitation, "duration", None), "excitation"
    steps = span / step if step and span and isinstance(excitation, Generated) else 0
    if shortage := shortage_of(round(steps)):
        sentence = f"solver.step and {block}.duration: {shortage}"
        raise misfit(scenario, sentence, f"{block}.duration")
    return excitation.motion(step, end)


def window(scenario: Scenario, motion: Sines | Samples) -> tuple[float, float]:
    """Give begin and end of the metrics [s]; a ScenarioError when a record ends before."""
    settle, duration = scenario.measure.settle, scenario.measure.duration
    if not isinstance(motion, Samples):
        assert duration is not None, "a scenario has a duration unless its record ends it"
        return settle, settle + duration
    last = (len(motion.u_dd) - 1) * motion.dt
    end = last if duration is None else settle + duration
    if settle >= last or end > last * (1.0 + ROUNDING):
        key = "measure.settle" if settle >= last else "measure.duration"
        sentence = (
            f"{key} asks for motion beyond the end of the excitation at {number(last, 's')}"
        )
        raise misfit(scenario, sentence, key)
    return settle, min(end, last)


def too_short(case: Case) -> str:
    """Say when a recorded normal force ends before the run; nothing where it does not."""
    pressure = case.law.pressure if isinstance(case.law, Pressed) else None
    if pressure is None or case.window[1] <= pressure.end * (1.0 + ROUNDING):
        return ""
    ends = f"ends at {number(pressure.end, 's')}"
    return (
        f"friction.normal_record {ends}, before the run, which ends at "
        f"{number(case.window[1], 's')}; give a longer record or a shorter measure.duration"
    )


def refusal(case: Case) -> tuple[str, str] | None:
    """Give the sentence and the key when the spectra that are asked for cannot be had."""
    from drysim.metrics.spectra import FEWEST_STEPS

    if not case.scenario.measure.spectra:
        return None
    if not isinstance(case.motion, Samples):
        kind = case.scenario.excitation.kind
        sentence = f"has no use for {kind}: spectra need random base motion or a record"
        return f"measure.spectra {sentence}", "measure.spectra"
    segment, length = segment_of(case), case.window[1] - case.window[0]
    least = FEWEST_STEPS * case.step
    if segment < least * (1 - ROUNDING):
        key = "segment" if case.scenario.measure.segment else "spectra"
        sentence = (
            f"measure.{key} needs segments of {number(least, 's')} at least, {FEWEST_STEPS} "
            f"steps; here they have {number(segment, 's')}"
        )
        return sentence, f"measure.{key}"
    if segment > length * (1 + ROUNDING):
        sentence = f"is longer than the window of {number(length, 's')}"
        return f"measure.segment {sentence}", "measure.segment"
    return None


LINES = 3
"""Noise bandwidths of the window within the width of a resonance that is resolved."""


def segment_of(case: Case) -> float:
    """Return the length of a segment [s]: the one asked for, or the default.

    The default is no longer than it takes to resolve the resonance: what a long window has
    beyond that goes into the number of averages.
    """
    from drysim.metrics.spectra import FEWEST_STEPS, PERIODS, SEGMENTS, SHORTEST, WIDTH

    if case.scenario.measure.segment:
        return case.scenario.measure.segment
    begin, end = case.window
    m, k_x, _ = case.plant
    enough = max(SHORTEST, FEWEST_STEPS * case.step)
    if k_x:
        enough = max(enough, PERIODS * 2 * pi * sqrt(m / k_x))
    if width := _width(case):
        enough = max(enough, LINES * WIDTH / width)
    return min(enough, (end - begin) / SEGMENTS)


def _width(case: Case) -> float:
    """Return the width of the resonance [Hz]; 0 where friction or nothing limits it."""
    m, k_x, b = case.plant
    return b / (2 * pi * m) if k_x and not case.law.F_fs else 0.0


# Whether a response fits into the memory of this machine.

BYTES_PER_STEP = 64
"""Memory of one step where a response is held whole, as by fixed steps, or a signal is made:
some 50 were seen, in the transforms of noise."""

BYTES_BY_PARTS = 8
"""Memory of one step where a response is made part by part: its events alone are held, 25 bytes
each, twice that while they are put together; 2 were seen at an event in 24 steps."""

BYTES_WEIGHED = 96
"""Memory of a step on top of it where it is weighted or its spectra are taken; 77 were seen."""

BYTES_PER_SEED = 6_000
"""Memory of the metrics of a seed; 3,500 were seen, with what writes them 5,000."""

GIGA = 1e9


def shortage_of(steps: int, weighed: bool = False, by_parts: bool = False) -> str:
    """Say what a response of so many steps lacks, or nothing when it fits."""
    wanted = bytes_of(steps, weighed, by_parts)
    return _lacking(f"{steps:.4g} steps", wanted, "take a longer step or a shorter duration")


def bytes_of(steps: int, weighed: bool = False, by_parts: bool = False) -> float:
    """Give the memory that a response of so many steps takes [bytes].

    One that is weighted, or whose spectra are taken, is held whole.
    """
    if by_parts and not weighed:
        return float(steps * BYTES_BY_PARTS)
    return float(steps * (BYTES_PER_STEP + weighed * BYTES_WEIGHED))


def by_parts(case: Case) -> bool:
    """Tell whether a long response of a case is never held whole."""
    return isinstance(case.approach, Exact) and isinstance(case.law, Law | Dynamic)


def _lacking(what: str, wanted: float, way: str) -> str:
    """Say what memory lacks for something [bytes], and what to do; nothing when it fits."""
    owned = system.memory()
    if wanted <= owned:
        return ""
    return (
        f"{what} need {wanted / GIGA:.3g} GB of memory, this machine has "
        f"{owned / GIGA:.3g} GB; {way}"
    )


# How much work a case is: each turn of what turns fast is followed.

SLOW = "slow-scene"
"""Slug of the caution, which is told before the work, too."""

A_STEP = 30.0
"""Radians that a step of an easy scene is worth a hundred times over: a sampled step takes some
30 ns with its metrics, one under sines 1 µs, and a radian was seen to take 0.1 to 0.5 µs."""

RADIAN = 5e-7
"""Time that a radian takes at most, or a decay of the speed in a series, compiled [s]."""

SERIES = 1.5e-4
"""The same where the motion is a Taylor series, with the memory of bristles [s]."""

BRISTLE_DECAY = 3e-5
"""Time of a step of such a series, about one for each decay of a strong damper [s]."""

MOST = 1e10
"""Radians of more than an hour: nobody means that, and the numbers would not bear it."""

DAMPER, BRISTLES = "damper", "damper of the bristles"

RINGING = 40.0
"""What rings with damping ratio ξ is below double precision after 40/ξ radians."""


class Price(NamedTuple):
    """What a plain step of a law costs, in steps of sampled motion under Coulomb's law (2 µs).

    Seen: 120 to 240 µs for laws by series, 80 µs for a load that varies, 40 µs between stops.
    """

    sampled: int = 1
    sines: int = 1
    kernels: str = ""
    """The kernels that are compiled for this law alone, as in `settle`."""

    def of(self, motion: Sines | Samples) -> int:
        """Give the steps under a base motion."""
        return self.sines if isinstance(motion, Sines) else self.sampled


USUAL = Price()
PRICES = {
    Dynamic: Price(100, 30, "taylor.trace"),
    Slider: Price(40, 6, "march.touch sampled.march_joint"),
    Stopped: Price(20, 6, "march.bound"),
    Pressed: Price(30, 4, "march.press"),
}


def price(approach: Approach, law: AnyLaw) -> Price:
    """Give what a step of an approach to a law costs; fixed steps cost the same for all."""
    return PRICES.get(type(law), USUAL) if isinstance(approach, Exact) else USUAL


class Turns(NamedTuple):
    """What turns within a case: its key, its name, and how far in all [rad].

    What a damper stills turns less than its frequency says: `least` is what is certain, in
    radians of `RADIAN`. `each` is the time that one may take [s].
    """

    key: str
    name: str
    radians: float
    least: float
    each: float = RADIAN

    def said(self, radians: float) -> str:
        """Say that it turns so far; what a damper does has no angle."""
        if self.name in (DAMPER, BRISTLES):
            return f"the {self.name} stills the mass {number(radians)} times"
        return f"the {self.name} turns by {number(radians)} radians"


def turns(case: Case) -> Turns:
    """Give what turns the most within the window of a case."""
    return max(_turns(case), key=lambda one: one.radians, default=Turns("", "", 0.0, 0.0))


def _turns(case: Case) -> Iterator[Turns]:
    """Give the waves of a case, and its spring where the mass may move."""
    if not isinstance(case.approach, Exact):
        return  # it steps over every turn
    span, fastest, law = case.window[1], inf, case.law
    if isinstance(case.motion, Sines):
        fastest = max(case.motion.f, default=0.0)
        radians = 2.0 * pi * fastest * span
        yield Turns("excitation", "base", radians, radians)
    if isinstance(law, Law | Stopped | Pressed) and law.variation:
        fastest = max(fastest, law.omega / (2.0 * pi))
        radians = law.omega * span
        yield Turns("friction.normal_variation", "normal force", radians, radians)
    m, k_x, b = case.plant
    kicks = 2.0 * (fastest * span + 1.0)
    moves = all(one.slug != "will-not-move" for one in case.cautions)
    if isinstance(law, Dynamic) and moves:
        decays = b / m * span
        yield Turns("oscillator.damping", DAMPER, decays, decays)
    if k_x > 0.0 and moves:
        yield _ringing("oscillator.stiffness", "oscillator", case.plant, span, kicks)
    if isinstance(law, Dynamic) and law.sigma_0:
        plant, name = (m, law.sigma_0, b + law.sigma_1), "mass on its bristles"
        rings = _ringing("friction.bristle_stiffness", name, plant, span, kicks)
        yield rings._replace(each=SERIES)
        decays = law.sigma_1 / m * span
        least = decays * BRISTLE_DECAY / RADIAN
        yield Turns("friction.bristle_damping", BRISTLES, decays, least, BRISTLE_DECAY)
    if isinstance(law, Slider):
        name = "mass on its contact"
        yield _ringing("friction.tangential_stiffness", name, (m, law.k_t, b), span, kicks)


def _ringing(
    key: str, name: str, plant: tuple[float, float, float], span: float, kicks: float
) -> Turns:
    """Give how far a spring turns that is kicked so many times within a span [s]."""
    m, k, b = plant
    radians, xi = sqrt(k / m) * span, 0.5 * b / sqrt(k * m)
    return Turns(key, name, radians, min(radians, kicks * RINGING / xi) if xi else radians)


def excess_of(case: Case) -> tuple[str, str] | None:
    """Give the sentence and the key for a case that would take longer than anybody waits."""
    most = max(_turns(case), key=lambda one: one.least, default=None)
    if most is None or most.least <= MOST:
        return None
    hours = number(most.least * RADIAN / 3600.0, "h", digits=2)
    sentence = (
        f"{most.key}: {most.said(min(most.least, most.radians))} in "
        f"{number(case.window[1], 's')}, and each is followed: up to {hours} of work; "
        "check the units, or take a shorter duration"
    )
    return sentence, most.key


def effort_cautions(case: Case) -> Iterator[Caution]:
    """Say when a step takes a hundred times as long as one of an easy scene."""
    most = turns(case)
    each = most.radians / max(case.steps, 1)
    if each > A_STEP:
        time = number(most.radians * most.each, "s", digits=2)
        whole = f"all of them up to {time}"
        if case.period is not None:
            whole = f"a period up to {time}, and many may lead to the orbit"
        sentence = (
            f"{most.said(each)} within a step of "
            f"{number(case.step, 's')}, and each is followed: a step may take 100 times as "
            f"long as usual, {whole}"
        )
        numbers = {"radians": most.radians, "radians_a_step": each}
        yield Caution(SLOW, sentence, numbers)


# How much a run writes.

LARGE = "large-response"
"""The slug of the caution."""

ROW = 100
"""Bytes of a row of response.csv as a rule."""

LEAST_SHARE = 0.4
"""Share of them that is certain: a row is as short where the mass holds still."""

MUCH = 1e9
"""Bytes from which on somebody should know."""


def response_bytes(case: Case) -> float:
    """Give about how much response.csv will hold [bytes]."""
    return float(ROW * (case.steps + 1))


def volume_cautions(case: Case) -> Iterator[Caution]:
    """Say when the response that a run writes is large; a sweep writes none."""
    volume = response_bytes(case)
    if volume > MUCH and not case.scenario.sweep:
        sentence = (
            f"a run writes response.csv with {case.steps + 1:.3g} rows, some "
            f"{volume / GIGA:.3g} GB; a step longer than {number(case.step, 's')} or a shorter "
            "duration makes it smaller"
        )
        yield Caution(LARGE, sentence, {"rows": case.steps + 1, "bytes": volume})


# Hashes of files and base motions.


def named_files(block: Block, keys: tuple[str, ...] = ()) -> Iterator[tuple[Any, Path]]:
    """Give the files that a scenario names, with the way to the block that names each."""
    path = getattr(block, "path", None)
    if isinstance(path, Path):
        yield keys, path
    for name in type(block).model_fields:
        if isinstance(inner := getattr(block, name), Block):
            yield from named_files(inner, (*keys, name))


def hashes_of(scenario: Block) -> dict[str, str]:
    """Give the SHA-256 (hex) of the bytes of every file that a scenario names, by its key."""
    found = {}
    for keys, path in named_files(scenario):
        with system.opened(path) as stream:
            found[".".join(keys)] = hashlib.file_digest(stream, "sha256").hexdigest()
    return found


def sha256_of(signal: Signal) -> str:
    """Give the SHA-256 (hex) of a signal as little-endian doubles."""
    digest = hashlib.sha256()
    for part in blocks(signal):
        digest.update(np.ascontiguousarray(part, dtype="<f8").data)
    return digest.hexdigest()


def sha256_together(hashes: Iterable[str]) -> str:
    """Give the SHA-256 (hex) of hashes, one a line, in order."""
    return hashlib.sha256("\n".join(hashes).encode()).hexdigest()


# Validate: what `run` would say about a file before it computes.


def examine(file: str, overrides: Sequence[str] = ()) -> tuple[Problem, ...]:
    """Give the problems of a file, changed by `KEY=VALUE` words.

    Those of severity `error` are the ones for which `run` would compute nothing.
    """
    try:
        case = prepare(load(file, overrides))
    except ScenarioError as fault:
        return fault.problems
    except RecordError as fault:
        return (fault.problem,)
    except UsageError as fault:
        return (Problem(str(fault), file),)
    told = clean_up(case.motion, case.law)
    if isinstance(case.scenario.excitation, Record):
        told.append(f"base: {excitation(case.scenario.excitation, case.motion)}")
    notes = [Problem(words, file, severity="note") for words in told]
    warned = [Problem(known.sentence, file, severity="warning") for known in case.cautions]
    return (*notes, *warned)
