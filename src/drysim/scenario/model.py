"""Scenario: everything that a scenario file says, checked and in SI."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationInfo, field_validator

from drysim.core.plant import AnyLaw, Law
from drysim.excitation.generated import Generated
from drysim.friction.terms import terms
from drysim.scenario import laws, under_law
from drysim.scenario.blocks import Oscillator, Solver, Start, Stops, Stroke
from drysim.scenario.fields import (
    ApproachName,
    Checks,
    Excitation,
    Friction,
    SolverBlock,
    Sweep,
)
from drysim.scenario.from_file import FromFile
from drysim.scenario.heading import FORMAT, FolderName, Format
from drysim.scenario.measure import Measure, frequencies, in_seconds, steady_by_default
from drysim.scenario.others import left_out, solved_by
from drysim.scenario.resolved import spelled_out
from drysim.scenario.sweep.points import case_at


class Scenario(FromFile):
    """A vibration isolator, how its base moves, and what is asked about it."""

    drysim: Format = FORMAT
    """Version of the file format."""
    name: FolderName = "scenario"
    """Name of the scenario and of its output folder; default: the name of the file."""
    about: str = ""
    """What it is about, in a sentence."""
    oscillator: Oscillator
    """Mass, spring and damper."""
    friction: Friction | None = None
    """Dry friction between mass and base; without this block there is none."""
    stroke: Stroke | None = None
    """How far the mass may move on its base."""
    start: Start = Field({}, validate_default=True)
    """The state at t = 0; default: at rest."""
    excitation: Excitation
    """How the base moves."""
    solver: SolverBlock = Field({}, validate_default=True)
    """How the motion is computed."""
    measure: Measure = Field({}, validate_default=True)
    """The window of the metrics."""
    sweep: Sweep = ()
    """What to vary: dotted keys of this file, each with a list of values, or with from, to and
    step or count. Every combination is a case; the first key varies fastest."""
    reference: ApproachName | None = None
    """Name of an approach that computes the sweep, too, as the curve to compare with."""
    checks: Checks = ()
    """Promises about metrics, such as `x_r_peak < 25 mm`; one that fails makes exit code 1."""

    @field_validator("solver")
    @classmethod
    def _step_suits(cls, solver: Solver, info: ValidationInfo) -> Solver:
        excitation = info.data.get("excitation")
        if solver.step is not None and isinstance(excitation, Generated):
            excitation.check_step(solver.step)
        return solver

    @field_validator("measure", mode="before")
    @classmethod
    def _measure_in_seconds(cls, given: object, info: ValidationInfo) -> object:
        if isinstance(given, Measure):
            given = given.model_dump(exclude_unset=True)
        if not isinstance(given, Mapping):
            return given
        excitation, friction = info.data.get("excitation"), info.data.get("friction")
        known = excitation is not None and "friction" in info.data
        steady = steady_by_default(excitation, friction)
        return in_seconds(given, frequencies(excitation, friction) if known else None, steady)

    def law(self) -> AnyLaw:
        """Give the friction as forces; none without a friction block; and the end stops.

        Raises
        ------
        RecordError
            When the normal force was recorded, and its record cannot be used.
        """
        friction = self.acting
        law = friction.limits(self.oscillator.mass) if friction else Law(0.0, 0.0)
        # Other laws beside stops are a fault, which is told once all is read.
        if self.stops is None or self.stroke is None or not isinstance(law, Law):
            return law
        return self.stops.between(law, self.stroke.limit)

    def outline(self) -> AnyLaw:
        """Give the friction as forces without reading a record: its force is the default."""
        friction = self.acting
        if friction is None or getattr(friction, "normal_record", None) is None:
            return self.law()
        bare = friction.model_copy(update={"normal_record": None})
        return bare.limits(self.oscillator.mass)

    @property
    def acting(self) -> Friction | None:
        """The friction that acts: of the file's law, or of the one that a comparison names."""
        if self.friction is None or not self.named_law:
            return self.friction
        return laws.acting(self.friction, self.named_law)

    @property
    def terms(self) -> tuple[str, ...]:
        """The name of a law other than Coulomb's, and its own keys that all cases share."""
        swept = {axis.key for axis in self.sweep}
        return tuple(terms(self.acting, swept)) if self.acting else ()

    @property
    def ratios(self) -> dict[str, float]:
        """What is given as a ratio, of damping and of friction forces, by its key."""
        given = {
            "damping_ratio": self.oscillator.damping_ratio,
            "static_ratio": getattr(self.acting, "static_ratio", None),
        }
        return {key: value for key, value in given.items() if value is not None}

    @property
    def word(self) -> str:
        """What a table calls the scenario by: its approach, or the law of a comparison."""
        return self.named_law or self.solver.approach

    @property
    def stops(self) -> Stops | None:
        """The end stops, if they are modelled."""
        return None if self.stroke is None else self.stroke.stops

    @property
    def static_given(self) -> bool:
        """Whether the static limit is known; without friction there is none to know."""
        return self.acting is None or self.acting.static_given

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Every frequency of the scene [Hz], if its base moves periodically."""
        return frequencies(self.excitation, self.acting)

    def at(self, point: Mapping[str, float]) -> Scenario:
        """Give the case at a point of the sweep: a scenario without one.

        Parameters
        ----------
        point : mapping
            Values in SI by dotted key; every other key keeps its value.

        Raises
        ------
        ScenarioError
            When the values do not go together; the sentence names the point.
        """
        return case_at(self, point)

    def with_approach(self, name: str) -> Scenario:
        """Give the same scene solved by another approach, without what it cannot use.

        What that is, `losses` says. Keys that the approach has no use for are not swept.
        """
        return solved_by(self, name)

    def with_law(self, name: str) -> Scenario:
        """Give the same scene under another friction law, solved exactly.

        Its keys are those of a block of its name in the friction block, and else those that it
        shares with the file's law. What it leaves out, `losses` says.

        Raises
        ------
        ScenarioError
            When a key is missing, or the keys do not go together.
        """
        return under_law.acted_by(self, name)

    def compared_by(self, word: str) -> Scenario:
        """Give the same scene by a word of a comparison, an approach or a law."""
        return self.with_law(word) if word in laws.LAWS else self.with_approach(word)

    def losses(self, word: str) -> tuple[str, ...]:
        """Give a sentence for everything in the scene that an approach or a law leaves out."""
        whose = under_law.left_out if word in laws.LAWS else left_out
        return tuple(whose(self, word))

    def resolved(self, relative_to: Path | None = None) -> dict[str, Any]:
        """Give plain words, defaults and all, in SI: a scenario that runs as this one did.

        Parameters
        ----------
        relative_to : Path, optional
            Folder that the words will be written to; default: the folder of this scenario.
        """
        return spelled_out(self, relative_to)
