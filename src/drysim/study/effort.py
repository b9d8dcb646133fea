"""How much work a case is, told before it is done: each turn of what turns fast is followed."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, NamedTuple

from drysim.approach.stick_slip import Exact
from drysim.core.motion import Samples, Sines
from drysim.core.normal_force.normal import Pressed
from drysim.core.plant import AnyLaw, Dynamic, Law, Slider, Stopped
from drysim.errors import Caution
from drysim.wording import number

if TYPE_CHECKING:
    from drysim.approach import Approach
    from drysim.study.case import Case

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
    """The folder of the core that is compiled for this law; nothing where it is Coulomb's."""

    def of(self, motion: Sines | Samples) -> int:
        """Give it under a base motion."""
        return self.sines if isinstance(motion, Sines) else self.sampled


USUAL = Price()
PRICES = {
    Dynamic: Price(100, 30, "dynamic_laws"),
    Slider: Price(40, 6, "contacts"),
    Stopped: Price(20, 6, "stops"),
    Pressed: Price(30, 4, "normal_force"),
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
        plant = (m, law.sigma_0, b + law.sigma_1)
        name = "mass on its bristles"
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


def excess(case: Case) -> tuple[str, str] | None:
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


def cautions(case: Case) -> Iterator[Caution]:
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
