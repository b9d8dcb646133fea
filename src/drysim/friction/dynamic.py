"""Laws with a differential equation of their own, or a force that falls with the speed.

Stribeck falls from its static limit as sliding gathers speed; Dahl yields like a spring before
it slides; LuGre and Leuven have bristles under Stribeck's curve, Leuven's with hysteresis.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from drysim.core.model import BRISTLE, LEUVEN, STRIBECK, Dynamic
from drysim.friction.base import TOLERANCE, Limits, Rubbing, Tolerance
from drysim.units import Damping, Quantity


class Stribeck(Limits, Rubbing):
    """Lubricated or soft surfaces, which rub less the faster they slide; true stick.

    Not to be confused with `coulomb`, whose force drops at once when sliding starts.

    Notes
    -----
    F_k(v) = F_fk + (F_fs - F_fk) exp(-|v/v_s|^δ) [N] against sliding, v and v_s [m/s]; stick
    holds up to F_fs. Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083.
    """

    law: Literal["stribeck"]
    """Dry friction that falls with the speed."""
    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    exponent: Annotated[float, Quantity("", at_least=0.5, below=20)] = 2.0
    """Exponent δ [-] of the fall, from 0.5 to below 20; default 2, the Gaussian of
    Armstrong-Hélouvry. Published are 0.5 to 1 of Bo and Pavelescu for dry metals, 1 of Tustin
    and great ones of Fuller for boundary lubricants. For 1 and 2 friction is a series in the
    speed at rest, too; any other takes two to four times as many steps, as they come to a stop
    by degrees. Below 0.5, less than any of these, the fall begins so steeply that the default
    tolerance leaves more than a millionth of the motion; there `coulomb` is near."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"stribeck_velocity": "v_s", "exponent": "δ"}

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        return Dynamic(
            F_fk, F_fs, STRIBECK, v_s=self.stribeck_velocity, exponent=self.exponent,
            tolerance=self.tolerance,
        )  # fmt: skip


class Dahl(Rubbing):
    """A contact that yields smoothly before it slides, as rolling bearings do; no stick.

    Not to be confused with `jenkins`, whose spring is linear up to the limit.

    Notes
    -----
    dz/dt = v (1 - σ_0 z sgn(v)/F_fk), F_f = σ_0 z, with z [m] the deflection of the contact.
    Dahl, A solid friction model, TOR-0158(3107-18)-1, The Aerospace Corporation (1968).
    """

    law: Literal["dahl"]
    """Dry friction of Dahl's kind."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the contact before it slides."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"bristle_stiffness": "σ_0"}

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        F_fk = self.kinetic_force(m)
        return Dynamic(
            F_fk, F_fk, BRISTLE, sigma_0=self.bristle_stiffness, tolerance=self.tolerance
        )


class Bristles(Limits, Rubbing):
    """Bristles between the surfaces, whose limit falls with the speed."""

    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, within which friction falls from static to kinetic."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness σ_0 [N/m], above 0, of the bristles where they begin to bend."""
    bristle_damping: Damping
    """Damping σ_1 [N·s/m], at least 0, of the bristles."""
    viscous: Damping = 0.0
    """Viscous friction σ_2 [N·s/m] of the contact; default 0: the damper is all there is."""

    symbols: ClassVar[dict[str, str]] = {
        "stribeck_velocity": "v_s",
        "bristle_stiffness": "σ_0",
        "bristle_damping": "σ_1",
        "viscous": "σ_2",
    }

    def bent(self, m: float, kind: int, tolerance: float) -> Dynamic:
        """Give the law in forces, of one kind of bristles; the mass [kg] as in `limits`."""
        return Dynamic(
            self.kinetic_force(m), self.static_force(m), kind, v_s=self.stribeck_velocity,
            sigma_0=self.bristle_stiffness, sigma_1=self.bristle_damping,
            sigma_2=self.viscous, tolerance=tolerance,
        )  # fmt: skip


class Lugre(Bristles):
    """Surfaces whose bristles bend before they slide; Stribeck's fall, delay and creep.

    Not to be confused with `leuven`, whose bristles remember where they turned.

    Notes
    -----
    dz/dt = v - σ_0 |v| z/g(v), F_f = σ_0 z + σ_1 dz/dt + σ_2 v [N], with
    g = F_fk + (F_fs - F_fk) exp(-(v/v_s)²) and z [m] the mean deflection of the bristles.
    Canudas de Wit, Olsson, Åström and Lischinsky, IEEE TAC 40 (1995) 419.
    """

    law: Literal["lugre"]
    """Dry friction of the LuGre kind."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        return self.bent(m, BRISTLE, self.tolerance)


class Leuven(Bristles):
    """Surfaces whose bristles bend with hysteresis: a loop within a loop closes where it began.

    Not to be confused with `lugre`, whose bristles are elastic and remember one number.

    Notes
    -----
    dz/dt = v (1 - sgn(F_h/s) |F_h/s|^n), F_f = F_h + σ_1 dz/dt + σ_2 v [N], with the limit
    s = sgn(v) (F_fk + (F_fs - F_fk) exp(-(v/v_s)²)) and F_h the hysteresis force over the
    travel z [m] of the bristles: on the virgin curve F_∞ (1 - exp(-σ_0 |z|/F_∞)), from where
    they turn the same curve twice as large (Masing), and where a loop closes the curve of the
    loop around it. Swevers, Al-Bender, Ganseman and Prajogo, IEEE TAC 45 (2000) 675, leave the
    virgin curve open; this one is drysim's choice.

    Lampaert, Swevers and Al-Bender, IEEE TAC 47 (2002) 683, correct two things. (1) F_h as a
    whole stands in dz/dt, not the part since the last turn, so the force has no jump as a loop
    closes: so it is here. (2) They take F_h from a finite row of Maxwell's slip elements, which
    cannot overflow as a stack of turns does. Here the stack stays: it is what such a row comes
    to as its elements grow many. It holds 128 turns, and where one more comes, the two that
    differ least from their neighbours are forgotten, without a jump in the force. At worst, of
    128 turns evenly within one another from limit to limit, and with F_∞ = 2 F_fs, that moves
    the force by 1e-4 of F_fs later on; a row of a hundred elements errs by as much always.
    """

    law: Literal["leuven"]
    """Dry friction of the Leuven kind."""
    hysteresis_ratio: Annotated[float, Quantity("", above=1)] = 2.0
    """F_∞/F_fs [-], above 1, the force that the bristles alone would come to over the static
    limit; default 2. The greater, the narrower the loops; far above 1 they are elastic."""
    transition: Annotated[float, Quantity("", at_least=0.5, below=20)] = 1.0
    """Exponent n [-] of the transition to sliding, from 0.5 to below 20; default 1. The
    greater, the later the bristles give way. For 1, 2 and 3 the motion is a series through zero
    force, too; any other takes up to four times as many steps, as it comes there by degrees."""
    tolerance: Tolerance = TOLERANCE
    """Share of the motion [-] that one step of the solution may neglect; default 1e-12. The
    error that comes of it is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {
        **Bristles.symbols,
        "hysteresis_ratio": "F_∞/F_fs",
        "transition": "n",
    }

    def limits(self, m: float) -> Dynamic:
        """Give the law in forces; the mass [kg] is the normal force's default."""
        law = self.bent(m, LEUVEN, self.tolerance)
        return law._replace(F_h=self.hysteresis_ratio * law.F_fs, power=self.transition)
