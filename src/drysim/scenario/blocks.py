"""The blocks of a scenario that stand on no shelf."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, create_model, field_validator, model_validator

from drysim.approach import EXACT, SHELF, Approach
from drysim.core.plant import Law, Plant, Stopped
from drysim.core.state import State
from drysim.quantity import (
    Block,
    Damping,
    Length,
    Mass,
    Misfit,
    Quantity,
    Stiffness,
    Velocity,
    meant_or_known,
    shown,
)
from drysim.quantity.arithmetic import root
from drysim.scenario.laws import LAWS


class Oscillator(Block):
    """A mass on a spring and a viscous damper."""

    mass: Mass
    """Sprung mass m [kg], above 0."""
    stiffness: Stiffness
    """Spring stiffness k_x [N/m]; 0 for none."""
    damping: Damping | None = None
    """Viscous damping b [N·s/m]; 0 for none."""
    damping_ratio: Annotated[float, Quantity("", at_least=0)] | None = None
    """Damping ratio b/(2√(k_x m)) [-], in place of `damping`; needs a stiffness above 0."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("damping", "damping_ratio"),)

    @model_validator(mode="after")
    def _ratio_needs_a_spring(self) -> Self:
        if self.damping_ratio is not None and self.stiffness == 0:
            raise Misfit("needs a stiffness above 0; give `damping` instead", "damping_ratio")
        return self

    def plant(self) -> Plant:
        """Give mass, stiffness and damping as numbers."""
        if self.damping is not None:
            return Plant(self.mass, self.stiffness, self.damping)
        assert self.damping_ratio is not None, "one of both is given"
        critical = 2 * root(self.stiffness * self.mass)
        return Plant(self.mass, self.stiffness, self.damping_ratio * critical)


class Stops(Block):
    """End stops at both ends of the stroke: bumpers that give way, or rigid ones.

    Notes
    -----
    A bumper is a spring and a damper that push and never pull: with xi how far x_r is beyond
    the limit, F_stop = stiffness xi + damping v_r while both xi and that force point outwards,
    else 0. Contact is lost where the force falls to zero, which with damping is before x_r is
    back at the limit. A rigid stop turns v_r into -restitution v_r; rebounds too low to be seen
    in x_r end in rest against it.
    """

    stiffness: Annotated[float, Quantity("N/m", above=0)] | None = None
    """Stiffness of a bumper [N/m], above 0."""
    damping: Damping | None = None
    """Damping of a bumper [N·s/m]; default 0."""
    restitution: Annotated[float, Quantity("", at_least=0, at_most=1)] | None = None
    """Speed after an impact on a rigid stop over that before [-], 0 to 1, in place of
    `stiffness`."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("stiffness", "restitution"),)
    needs: ClassVar[dict[str, str]] = {"damping": "stiffness"}

    def between(self, law: Law, limit: float) -> Stopped:
        """Give these stops, `limit` m from the middle, with the friction between them."""
        F_fk, F_fs, *varied = law
        k_s, b_s, e = self.stiffness or 0.0, self.damping or 0.0, self.restitution or 0.0
        return Stopped(F_fk, F_fs, limit, k_s, b_s, e, *varied)


class Stroke(Block):
    """How far the mass may move on its base."""

    limit: Annotated[float, Quantity("m", above=0)]
    """Stroke limit x_rM [m]: |x_r| must stay below it. Checked, and modelled beside `stops`."""
    stops: Stops | None = None
    """What the mass meets at the limit; without this block it moves on beyond it. Goes with law
    `coulomb` under a normal force that stays above zero and is no record, and without
    friction."""


class Start(Block):
    """The state at t = 0; default: at rest, the spring relaxed."""

    x_r: Length = 0.0
    """Relative displacement [m]."""
    v_r: Velocity = 0.0
    """Relative velocity [m/s]."""

    def state(self) -> State:
        """Give the state as numbers."""
        return State(self.x_r, self.v_r)


class Solver(Block):
    """How the motion is computed."""

    approach: str = EXACT
    """Name of the approach."""
    step: Annotated[float, Quantity("s", above=0)] | None = None
    """Distance of the output grid [s]; a record owns its step."""

    @field_validator("approach")
    @classmethod
    def _on_the_shelf(cls, name: str) -> str:
        return on_the_shelf(name)

    def member(self) -> Approach:
        """Give the approach with its options."""
        chosen: Approach = getattr(self, self.approach, None) or SHELF[self.approach]()
        return chosen


def on_the_shelf(name: str) -> str:
    """Give the name of an approach that there is; a ValueError says which there are."""
    if name not in SHELF:
        hint = "; it is a friction law: friction.law takes it"
        hint = hint if name in LAWS else meant_or_known(name, SHELF)
        raise ValueError(f"unknown approach {shown(name)}{hint}")
    return name


def with_options(shelf: dict[str, Any]) -> type[Solver]:
    """Give the solver block in which every approach that has options has a block of its own."""
    options: dict[str, Any] = {
        name: (member | None, Field(None, description=f"Options of {name}."))
        for name, member in shelf.items()
        if len(member.model_fields) > 1
    }
    # Pickling finds a class by module and name: that of the block above is taken here.
    home = "drysim.scenario.fields"
    return create_model("Solver", __base__=Solver, __module__=home, **options)
