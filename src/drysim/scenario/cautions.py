"""What a reader of a scenario should know before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, isclose, nan, pi, sqrt
from typing import TYPE_CHECKING

from drysim.core.motion import Samples, Sines
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import AnyLaw, Stopped
from drysim.core.signal import largest
from drysim.errors import Caution, RecordError
from drysim.excitation.record import Record
from drysim.metrics import SHARES
from drysim.quantity import Block
from drysim.scenario.laws import BY_NAME, LAWS, excluded
from drysim.scenario.odd_units import odd_units
from drysim.scenario.sweep.cautions import MANY, extremes, needless
from drysim.scenario.unfit import unfit
from drysim.weighting import DIRECTIONS, RECALLED

if TYPE_CHECKING:
    from drysim.checks import Check
    from drysim.scenario.model import Scenario

STEPS_A_PERIOD = 20
"""Fewer points than this draw a sine as a polygon."""

HIGHEST = 80.0
"""Last third octave of the weightings of a seat [Hz]."""

ON_GRID = 1e-9
"""Rounding that a step may have."""

ROUNDING = 1e-12
"""Difference of two limits, relative to them, that only their units make [-]."""

LOADS = ("oscillator.", "friction.", "excitation.", "start.", "stroke.")
"""Beginnings of the keys that decide whether the mass moves: swept, they differ by case."""

COMMON_RATIO = 1.3
"""Dry surfaces hold up to about this much more than they drag: F_fs/F_fk [-]."""


def cautions(
    scenario: Scenario, motion: Sines | Samples | None = None, compared: bool = False
) -> tuple[Caution, ...]:
    """Give the warnings that the words of a scenario deserve, swept values among them.

    Parameters
    ----------
    scenario : Scenario
    motion : Sines or Samples, optional
        Base motion, if it is at hand; no record is read and no signal is made for this.
    compared : bool, optional
        Whether other approaches or laws than those of the scenario solve it, too: then nothing
        is said about options of theirs.
    """
    if motion is None and scenario.excitation.periodic:
        motion = scenario.excitation.motion()
    found = [*odd_units(scenario, motion)]
    if isinstance(motion, Sines):
        found += _step(scenario, motion)
    elif isinstance(scenario.excitation, Record) and motion is not None:
        found += _record(scenario, motion)
    if motion is not None:
        if not any(axis.key.startswith(LOADS) for axis in scenario.sweep):
            found += _friction(scenario, motion)
        found += [*unfit(scenario, motion), *_weighting(scenario, motion)]
    found += [*needless(scenario), *_vain_checks(scenario), *_without_force(scenario)]
    if not compared:
        found += [*_idle_options(scenario), *_unread_records(scenario)]
    return tuple(found)


def _step(scenario: Scenario, motion: Sines) -> Iterator[Caution]:
    """Say when the output grid is too coarse to draw motion, in a sweep at its worst."""
    cases = extremes(scenario) if scenario.sweep else ()
    swept = [one for case in cases for one in _coarse(case, case.excitation.motion())]
    found = swept if scenario.sweep else [*_coarse(scenario, motion)]
    yield from sorted(found, key=lambda one: one.numbers["steps"])[:1]


def _coarse(scenario: Scenario, motion: Sines | Samples) -> Iterator[Caution]:
    """Say when the output grid is too coarse to draw the motion of a single case."""
    if not isinstance(motion, Sines):
        return
    m, k_x, _ = scenario.oscillator.plant()
    f = max(motion.f, default=sqrt(k_x / m) / (2 * pi))
    steps = 1 / (f * scenario.solver.step) if f and scenario.solver.step else inf
    if steps < STEPS_A_PERIOD:
        yield Caution(
            "coarse-step",
            f"solver.step leaves {steps:.3g} steps a period at {f:g} Hz; "
            f"{1 / (f * STEPS_A_PERIOD):.2g} s would give {STEPS_A_PERIOD}",
            {"solver.step": scenario.solver.step or 0.0, "frequency": f, "steps": steps},
        )


def _record(scenario: Scenario, motion: Samples) -> Iterator[Caution]:
    """Say when the samples of a record are too far apart to shake the oscillator."""
    m, k_x, _ = scenario.oscillator.plant()
    f_0 = sqrt(k_x / m) / (2 * pi)
    if f_0 * motion.dt * STEPS_A_PERIOD <= 1 + ON_GRID:
        return
    sentence = (
        f"the record has a sample every {motion.dt:.6g} s, {1 / (f_0 * motion.dt):.3g} in a "
        f"natural period of {1 / f_0:.3g} s: of what shakes the mass it tells little"
    )
    if getattr(scenario.excitation, "time", None) is not None:
        sentence += (
            "; times are seconds unless their header has a unit, such as `t [ms]`: where that "
            "is what is wrong, give `step` or `rate` in place of `time`"
        )
    yield Caution("coarse-record", sentence, {"step": motion.dt, "f_0": f_0})


def _weighting(scenario: Scenario, motion: Sines | Samples) -> Iterator[Caution]:
    """Say when a factor is recalled, and when the grid is too coarse to weigh the motion on."""
    direction = scenario.measure.direction
    if direction in RECALLED:
        weighting, k = DIRECTIONS[direction]
        yield Caution(
            "recalled",
            f"the factor k = {k:g} of {direction} whole-body vibration is recalled and was not "
            f"checked against the text of ISO 2631-1; `weighting: {weighting}` has k = 1",
            {"k": k},
        )
    step = motion.dt if isinstance(motion, Samples) else scenario.solver.step
    if scenario.measure.weights and step and step * HIGHEST * 2 > 1 + ON_GRID:
        yield Caution(
            "coarse-weighting",
            f"the step of {step:.6g} s tells nothing above {0.5 / step:.4g} Hz, and ISO 2631-1 "
            f"weighs up to {HIGHEST:g} Hz: a_w and what follows from it lack the rest",
            {"step": step, "highest": 0.5 / step},
        )


def _friction(scenario: Scenario, motion: Sines | Samples) -> Iterator[Caution]:
    """Say when the mass will not move, or moves only for want of a static limit.

    At rest on its base the mass stays there while |F_L| = |m ü + k_x x_r| is within F_fs. Above
    that, an F_fs that nobody gave decides as long as a common ratio F_fs/F_fk would hold where
    the surfaces are pressed together the least.
    """
    law, start = scenario.law(), scenario.start.state()
    m, k_x, _ = scenario.oscillator.plant()
    load, least = m * _peak(motion) + k_x * abs(start.x_r), _least(law)
    hold, drag = law.F_fs * least, law.F_fk * least
    if isinstance(law, Stopped):  # a start beyond the limit squeezes a bumper
        load += law.k_s * max(abs(start.x_r) - law.x_rM, 0.0)
    if start.v_r == 0 and load <= hold and law.sticks:
        yield Caution(
            "will-not-move",
            f"the mass will not move: |F_L| stays within {load:.6g} N and F_fs is {hold:.6g} N",
            {"F_L": load, "F_fs": hold},
        )
    elif hold < load <= COMMON_RATIO * drag and not scenario.static_given:
        ratio = load / drag
        yield Caution(
            "static-not-given",
            "friction.static is not given, so F_fs = F_fk; from friction.static_ratio "
            f"{ratio:.4g} up the mass would not leave rest: give it if you know it",
            {"F_L": load, "F_fk": drag, "ratio": ratio},
        )


def _least(law: AnyLaw) -> float:
    """Give the least normal force relative to its mean [-]."""
    pressure = law.pressure if isinstance(law, Pressed) else None
    return 1.0 - law.variation if pressure is None else float(pressure.relative.min())


def _peak(motion: Sines | Samples) -> float:
    """Give a bound of |ü| [m/s²] that a single sine and samples reach."""
    if isinstance(motion, Samples):
        return largest(motion.u_dd)
    return sum(motion.A)


def _vain_checks(scenario: Scenario) -> Iterator[Caution]:
    """Warn of checks that cannot fail, cannot hold, stand twice or contradict each other."""
    here = _Cases(scenario)
    sound: dict[str, list[Check]] = {}
    for at, check in enumerate(scenario.checks):
        before = sound.setdefault(check.metric, [])
        twin = next((one for one in before if _same(one, check)), None)
        foe = next(
            (one for one in before if one.contradicts(check) and here.share(one, check)), None
        )
        answer, numbers = check.foregone, {f"checks.{at}": check.limit}
        if answer is not None:
            share = check.metric in SHARES
            hint = "shares are from 0 to 1" if share else f"{check.metric} is never below 0"
            if share and check.limit > 1 and not check.unit:
                hint += f"; if it is in percent, write `{check.limit:g} %`"
            word = "fail" if answer else "hold"
            sentence = f"the check `{check}` cannot {word}: {hint}"
            yield Caution(f"check-cannot-{word}", sentence, numbers)
        elif not here.has(check):
            sentence = f"the check `{check}` cannot hold: it applies to no case of the sweep"
            yield Caution("check-cannot-hold", sentence, numbers)
        elif twin is not None:
            yield Caution("check-twice", f"the check `{check}` stands there twice", numbers)
        elif foe is not None:
            sentence = f"the checks `{foe}` and `{check}` contradict each other: one must fail"
            yield Caution("checks-contradict", sentence, numbers)
        else:
            before.append(check)


def _same(one: Check, other: Check) -> bool:
    """Whether two checks of one metric promise the same of the same cases."""
    alike = isclose(one.limit, other.limit, rel_tol=ROUNDING)
    return alike and one.op == other.op and {*one.conditions} == {*other.conditions}


class _Cases:
    """The values that keys have in the cases of a scenario, for conditions of checks."""

    def __init__(self, scenario: Scenario) -> None:
        few = (axis for axis in scenario.sweep if len(axis.values) <= MANY)
        self.values = {axis.key: list(axis.values) for axis in few}
        self.swept = {axis.key for axis in scenario.sweep}

    def has(self, check: Check) -> bool:
        """Whether a check applies to a case of the sweep, as far as each key tells."""
        return not self.swept or self.share(check)

    def share(self, *checks: Check) -> bool:
        """Whether all of some checks apply to one case, as far as each key tells."""
        conditions = [one for check in checks for one in check.conditions]
        for key in {one.key for one in conditions}:
            asked = [one for one in conditions if one.key == key]
            here = asked[0].here
            values = self.values.get(key, [nan if here is None else here])
            known = key not in self.swept or key in self.values
            if known and not any(all(one.holds({key: v}) for one in asked) for v in values):
                return False
        return True


def _without_force(scenario: Scenario) -> Iterator[Caution]:
    """Warn of keys that scale a friction force of zero."""
    friction, swept = scenario.acting, {axis.key for axis in scenario.sweep}
    force = next(
        (k for k in ("kinetic", "mu_kinetic") if getattr(friction, k, None) == 0), None
    )
    if force is None or f"friction.{force}" in swept:
        return
    ratio, varied = (
        getattr(friction, key, None) for key in ("static_ratio", "normal_variation")
    )
    idle = {"static_ratio": ratio not in (None, 1.0), "normal_variation": varied is not None}
    if scenario.outline().F_fs > 0:
        idle["normal_variation"] = False
    for key in (key for key, given in idle.items() if given):
        if not _chosen_outside(scenario, f"friction.{force}", f"friction.{key}"):
            sentence = f"friction.{key} has no effect: friction.{force} is 0"
            yield Caution("no-effect", sentence, {f"friction.{force}": 0.0})


def _idle_options(scenario: Scenario) -> Iterator[Caution]:
    """Warn of options that nothing uses where only the scenario's own approach and law act."""
    approach = scenario.solver.approach
    for name, options in scenario.solver:
        idle = isinstance(options, Block) and name not in (approach, scenario.reference)
        if idle and not _chosen_outside(scenario, "solver.approach", f"solver.{name}"):
            sentence = (
                f"solver.{name} has no effect: the approach is {approach}; options of {name} "
                "count where a comparison names it"
            )
            yield Caution("no-effect", sentence)
    words = scenario.spoken("friction")
    law = words.get(BY_NAME)
    own = words.get(law) if isinstance(law, str) else None
    if not isinstance(law, str) or not isinstance(own, Mapping):
        return
    if not _chosen_outside(scenario, f"friction.{BY_NAME}", f"friction.{law}"):
        for key in sorted(words.keys() & excluded(law, own)):
            stands = key if key in own else ", ".join(own)
            sentence = f"friction.{key} has no effect: friction.{law}.{stands} stands for it"
            yield Caution("no-effect", sentence)


def _chosen_outside(scenario: Scenario, choice: str, options: str) -> bool:
    """Whether a choice, and none of the options beside it, was made by an override.

    Such as by `--approach`: then the options in the file are those of the file's own choice.
    """
    chosen = scenario.origin["overrides"]
    return choice in chosen and not any(f"{key}.".startswith(f"{options}.") for key in chosen)


def _unread_records(scenario: Scenario) -> Iterator[Caution]:
    """Warn of a recorded normal force in options of another law that cannot be read."""
    for law in LAWS:
        record = getattr(getattr(scenario.friction, law, None), "normal_record", None)
        if record is not None:
            try:
                record.pressure()
            except RecordError as fault:
                sentence = f"friction.{law}.normal_record cannot be used: {fault.problem}"
                yield Caution("unread-record", sentence)
