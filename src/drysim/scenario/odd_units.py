"""Values of a scenario, swept ones among them, that look like values in other units."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt
from typing import TYPE_CHECKING

from drysim.core.motion import Samples, Sines
from drysim.core.signal import largest
from drysim.errors import Caution
from drysim.metrics import UNITS
from drysim.scenario.sweep.cautions import extremes

if TYPE_CHECKING:
    from drysim.scenario.model import Scenario

FAR = 1.0
"""An isolator does not travel a metre [m]; 25 typed for 25 mm does."""

MEGA = 1e5
"""Nobody writes so many millimetres [m]: `Mm` stood for `mm`."""

HARD = 100.0
"""Ten times gravity [m/s²] over a metre is in millimetres."""

SLOW = 0.1
"""Below this natural frequency [Hz] masses are in grams or springs in N/mm, not on springs."""

DAMPED = 5.0
"""Above this damping ratio [-] somebody meant percent."""

RATIOS = ("SEAT", "SEAT_VDV", "stroke_used")
"""Metrics [-] that people give in percent."""

TENFOLD = 10.0
"""From this limit on of such a metric [-] somebody meant percent."""

WHOLE = 1.0
"""An interval as wide as its mean [-] tells nothing of it; somebody meant percent."""

REMOTE = 1000.0
"""No mass travels a thousand times as far as its base moves and its spring would give [-]."""


def odd_units(scenario: Scenario, motion: Sines | Samples | None) -> Iterator[Caution]:
    """Say which values look like values in other units, each key once.

    Parameters
    ----------
    scenario : Scenario
        Of a sweep the cases at both ends of every swept key are looked at.
    motion : Sines or Samples or None
        Base motion, if it is at hand.

    Yields
    ------
    Caution
    """
    found: dict[tuple[str, ...], Caution] = {}
    for case in extremes(scenario) if scenario.sweep else (scenario,):
        own = motion if case.excitation is scenario.excitation else None
        if case is not scenario and case.excitation.periodic:  # each case moves as it says
            own = case.excitation.motion()
        waves = _sines(own) if isinstance(own, Sines) else ()
        lengths = (*_lengths(case), *_remote(case, own))
        for caution in (*lengths, *_oscillator(case), *_ratios(case), *waves):
            found.setdefault((caution.slug, *caution.numbers), caution)
    yield from found.values()


def _lengths(scenario: Scenario) -> Iterator[Caution]:
    """Say which lengths look like millimetres."""
    m, k_x, _ = scenario.oscillator.plant()
    start = abs(scenario.start.x_r)
    limit = scenario.stroke.limit if scenario.stroke else 0.0
    pulled = start if k_x * start / m >= HARD else 0.0
    bare = [
        (f"the limit of the check `{check}`", f"checks.{at}", check.limit)
        for at, check in enumerate(scenario.checks)
        if not check.unit and UNITS[check.metric] == "m"
    ]
    keys = (("stroke.limit", limit), ("start.x_r", pulled))
    for what, key, value in (*((key, key, value) for key, value in keys), *bare):
        if value >= FAR:
            typed = value / 1e6 if value >= MEGA else value
            sentence = f"{what} is {value:g} m; if it is in millimetres, write `{typed:g} mm`"
            yield Caution("looks-like-millimetres", sentence, {key: value})


def _remote(scenario: Scenario, motion: Sines | Samples | None) -> Iterator[Caution]:
    """Warn of checks whose limit has a unit, and is a length far beyond all that moves."""
    m, k_x, _ = scenario.oscillator.plant()
    if motion is None or k_x == 0.0:
        return
    softness, start = m / k_x, scenario.start.state()
    if isinstance(motion, Samples):
        base = largest(motion.u_dd) * softness
    else:
        base = sum(
            A * max(softness, 1 / (2 * pi * f) ** 2) for A, f, _ in zip(*motion, strict=True)
        )
    reach = base + abs(start.x_r) + abs(start.v_r) * sqrt(softness)
    for at, check in enumerate(scenario.checks):
        far = check.limit >= FAR and check.limit >= REMOTE * reach
        if far and check.unit and UNITS[check.metric] == "m":
            sentence = (
                f"the limit of the check `{check}` is {check.limit:g} m, over {REMOTE:g} times "
                f"the {reach:.2g} m by which base and start move the mass: is its unit right?"
            )
            yield Caution("implausible-length", sentence, {f"checks.{at}": check.limit})


def _ratios(scenario: Scenario) -> Iterator[Caution]:
    """Warn of ratios that look like percent."""
    bare = [
        (f"the limit of the check `{check}`", f"checks.{at}", check.limit)
        for at, check in enumerate(scenario.checks)
        if not check.unit and check.metric in RATIOS and check.limit >= TENFOLD
    ]
    until = getattr(scenario.excitation, "until", None)
    if until is not None and until.half_width >= WHOLE:
        key = "excitation.until.half_width"
        bare.append((key, key, until.half_width))
    for what, key, value in bare:
        sentence = f"{what} is {value:g}; if it is in percent, write `{value:g} %`"
        yield Caution("looks-like-percent", sentence, {key: value})


def _oscillator(scenario: Scenario) -> Iterator[Caution]:
    """Say when the oscillator looks like one in other units."""
    m, k_x, _ = scenario.oscillator.plant()
    f_0 = sqrt(k_x / m) / (2 * pi)
    if 0 < f_0 < SLOW:
        yield Caution(
            "looks-like-grams",
            f"the natural frequency is {f_0:.3g} Hz: is oscillator.mass in grams (`{m:g} g`) "
            f"or oscillator.stiffness in N/mm (`{k_x:g} N/mm`)?",
            {"oscillator.mass": m, "oscillator.stiffness": k_x, "f_0": f_0},
        )
    ratio = scenario.oscillator.damping_ratio or 0.0
    if ratio >= DAMPED:
        sentence = (
            f"oscillator.damping_ratio is {ratio:g}; if it is in percent, write `{ratio:g} %`"
        )
        yield Caution("looks-like-percent", sentence, {"oscillator.damping_ratio": ratio})


def _sines(motion: Sines) -> Iterator[Caution]:
    """Say which sines look like sines in other units."""
    for A, f, phase in zip(*motion, strict=True):
        u = A / (2 * pi * f) ** 2
        if u >= FAR and A >= HARD:
            yield Caution(
                "looks-like-millimetres",
                f"at {f:g} Hz the base swings by {u:.3g} m; if the excitation is in mm/s², "
                "write `mm/s2` behind its number",
                {"frequency": f, "amplitude": A, "u": u},
            )
        if abs(phase) > 2 * pi:
            sentence = (
                f"a phase of {phase:g} rad is above a turn; in degrees it is `{phase:g} deg`"
            )
            yield Caution("looks-like-degrees", sentence, {"phase": phase})
