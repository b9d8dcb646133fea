"""Friction laws of a scenario: Coulomb, elastic contacts, dynamic friction models.

A force is given directly, or by a coefficient and the normal force, which defaults to the
weight of the mass. A law is a class with its keys and an entry in `FRICTION_LAWS`; `to_law`
converts it to the forces of the core. The equations of Stribeck, Dahl, LuGre and Leuven are
evaluated in `core.dynamic_friction`.

A law solved in closed form says so by `closed_form`; it goes with end stops and with damping by
direction. A new law also needs its branch in the core, a scenario `friction-<law>` in the
gallery with a picture of its loop, and a row in the README.
"""

from collections.abc import Collection, Iterator
from contextlib import suppress
from functools import lru_cache
from itertools import chain
from math import pi
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

from pydantic import Field, model_validator

from drysim import system
from drysim.block import Block, InvalidValue, PlainOrBlock
from drysim.core.model import (
    BRISTLE,
    LEUVEN,
    STRIBECK,
    CoulombLaw,
    DynamicLaw,
    NormalForceRecord,
    PiecewiseLaw,
    principal_angle,
)
from drysim.direction import DirectedForce, by_direction, depends_on_direction
from drysim.quantity import Angle, Damping, Force, Frequency, Quantity
from drysim.records.options import Recorded
from drysim.wording import format_number

GRAVITY = 9.81
"""Gravitational acceleration of the paper [m/s²], at which 75 kg weigh 735.75 N."""

DEFAULT_TOLERANCE = 1e-12
"""Default truncation error of a step relative to the motion, close to rounding."""

Tolerance = Annotated[float, Quantity("", at_least=1e-14, below=1e-3)]

Coefficient = Annotated[float, Quantity("", at_least=0)]


class FrictionLaw(Block):
    """Base class of the friction laws."""

    law: str
    """Name of the law."""

    by_default: ClassVar[bool] = False
    """Whether a block without `law` means this one."""
    closed_form: ClassVar[bool] = False
    """Whether the law is solved in closed form."""
    symbols: ClassVar[dict[str, str]] = {}
    """Symbols of the source for keys of the law; other keys are shown by name."""

    @property
    def static_given(self) -> bool:
        """Whether the static limit is given; true for laws without one."""
        return True

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies of a periodic normal force [Hz]."""
        return ()

    def with_defaults(self, m: float) -> dict[str, Any]:
        """Return the keys and values of the block with all defaults; m is the mass [kg]."""
        return self.model_dump(exclude_none=True, by_alias=True)

    def describe(self, swept: Collection[str] = ()) -> Iterator[str]:
        """Yield the name of the law, then its own keys as `v_s 0.005 m/s`.

        Defaults and swept keys are left out.
        """
        yield f"law {self.law}"
        for key, field in type(self).model_fields.items():
            value = getattr(self, key)
            if key in NOT_LISTED or f"friction.{key}" in swept or value == field.default:
                continue
            if isinstance(value, int | float):
                symbol = self.symbols.get(key, key.replace("_", " "))
                # Where a key may be left out its quantity is within its annotation.
                inner = (
                    getattr(kind, "__metadata__", ()) for kind in get_args(field.annotation)
                )
                every = chain(field.metadata, *inner)
                unit = next((part.unit for part in every if isinstance(part, Quantity)), "")
                yield f"{symbol} {format_number(value, unit)}"


class KineticForce(FrictionLaw):
    """Kinetic friction, given as a force or by a coefficient and the normal force."""

    kinetic: Force | None = None
    """Kinetic friction force F_fk [N]."""
    mu_kinetic: Coefficient | None = None
    """Coefficient of kinetic friction [-], in place of `kinetic`."""
    normal: Force | None = None
    """Normal force [N] for the coefficients; default: 9.81 m/s² times the mass."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("kinetic", "mu_kinetic"),)
    needs: ClassVar[dict[str, str]] = {"normal": "mu_kinetic"}

    def kinetic_force(self, m: float) -> float:
        """Return F_fk [N]; the mass m [kg] gives the default normal force."""
        if self.kinetic is not None:
            return self.kinetic
        # Both may be missing while the errors of a file are being collected.
        return self.force_from_coefficient(
            0.0 if self.mu_kinetic is None else self.mu_kinetic, m
        )

    def force_from_coefficient(self, mu: float, m: float) -> float:
        """Return the friction force [N] of a coefficient."""
        return mu * (GRAVITY * m if self.normal is None else self.normal)

    def with_defaults(self, m: float) -> dict[str, Any]:
        """Return the keys and values of the block with all defaults."""
        values = super().with_defaults(m)
        if self.mu_kinetic is not None and self.normal is None:
            values["normal"] = GRAVITY * m
        return values


Ratio = Annotated[float, Quantity("", at_least=1)]


class RatioInterval(Block):
    """Interval of F_fs/F_fk, of which only bounds are known."""

    low: Ratio = Field(alias="from")
    """Lower bound [-], at least 1."""
    high: Ratio = Field(alias="to")
    """Upper bound [-], above the lower one."""

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.high <= self.low:
            raise InvalidValue(f"must be above `from`, {self.low:.12g}", "to")
        return self


StaticRatio = PlainOrBlock[Ratio, RatioInterval]
"""One ratio F_fs/F_fk [-], or an interval."""


class FrictionLimits(KineticForce):
    """Kinetic friction and a static limit for a contact at rest."""

    static: Force | None = None
    """Static limit F_fs [N], at least the kinetic force; default: equal to it."""
    static_ratio: StaticRatio | None = None
    """Static ratio F_fs/F_fk [-], at least 1, in place of `static`; default 1; or `{from, to}`
    in a run or sweep."""
    mu_static: Coefficient | None = None
    """Coefficient of static friction [-], at least that of kinetic friction."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("static", "static_ratio", "mu_static"),
    )
    needs: ClassVar[dict[str, str]] = {
        "static": "kinetic",
        "mu_static": "mu_kinetic",
        "normal": "mu_kinetic",
    }

    @model_validator(mode="after")
    def _check_static_limit(self) -> Self:
        for name, static, kinetic, unit in (
            ("static", self.static, self.kinetic, " N"),
            ("mu_static", self.mu_static, self.mu_kinetic, ""),
        ):
            if static is None or kinetic is None:
                continue
            pairs = zip(by_direction(kinetic), by_direction(static), strict=True)
            where = depends_on_direction(kinetic) or depends_on_direction(static)
            for (low, high), direction in zip(pairs, ("extension", "compression"), strict=True):
                if high < low:
                    least, given = f"{low:.12g}{unit}", f"{high:.12g}{unit}"
                    sentence = f"must be at least the kinetic {least}, not {given}"
                    sentence += f", in {direction}" if where else ""
                    sentence += "; `static_ratio` in its place follows the kinetic"
                    raise InvalidValue(sentence, name)
        return self

    @property
    def static_given(self) -> bool:
        """Whether the static limit is given."""
        return (self.static, self.static_ratio, self.mu_static) != (None, None, None)

    def static_force(self, m: float) -> float:
        """Return F_fs [N]; of an interval the smallest one."""
        if self.static is not None:
            return self.static
        if self.mu_static is not None:
            return self.force_from_coefficient(self.mu_static, m)
        ratio = self.static_ratio
        if isinstance(ratio, RatioInterval):
            ratio = ratio.low
        return self.kinetic_force(m) * (1.0 if ratio is None else ratio)

    def with_defaults(self, m: float) -> dict[str, Any]:
        """Return the keys and values of the block with all defaults."""
        values = super().with_defaults(m)
        return values if self.static_given else values | {"static_ratio": 1.0}


class PositiveForce(KineticForce):
    """Kinetic friction above zero, as laws need whose state or contact scales with it."""

    @model_validator(mode="after")
    def _check_positive(self) -> Self:
        for name in ("kinetic", "mu_kinetic", "normal"):
            if getattr(self, name) == 0.0:
                without = "leave out the block `friction` for none"
                raise InvalidValue(f"must be above 0 under law `{self.law}`; {without}", name)
        return self


# Coulomb's law: kinetic friction independent of speed, and a static limit.
#
# The normal force may vary as a sine, or be a record in the formats of base motion.


class NormalQuantity(Block):
    """The measured quantity of a record of the normal force."""

    quantity: Literal["force", "acceleration"] = "force"
    """Measured quantity: the normal force F_N, or the vertical acceleration z̈ of the base,
    upwards and without gravity, that presses the mass: F_N = m (9.81 m/s² + z̈)."""


class NormalRecord(Recorded, NormalQuantity):
    """Recorded normal force: equidistant samples of a file, linear in between.

    At zero or below the surfaces are separated and there is no friction.
    """

    @property
    def block(self) -> str:
        """Block of the scenario that has the options of the column."""
        return "friction.normal_record"

    def force_record(self) -> NormalForceRecord:
        """Read the record; it is cached while the file is unchanged.

        Raises
        ------
        RecordError
            If the record cannot be used, the mean of its forces is not positive, or its
            acceleration contains gravity.
        """
        stamp = None
        with suppress(OSError):
            stamp = system.file_signature(self.path)
        return _cached_force_record(self, stamp)


@lru_cache(maxsize=4)  # neighbouring cases of a sweep share their record
def _cached_force_record(
    record: NormalRecord, stamp: system.FileSignature | None
) -> NormalForceRecord:
    from drysim.records.record import read_normal_force

    return read_normal_force(record)


class NormalVariation(Block):
    """Sinusoidal normal force: both limits times 1 + amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("", at_least=0)]
    """Relative amplitude [-]; above 1 the surfaces separate for part of each period, without
    friction."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class Coulomb(FrictionLimits):
    """Dry friction: constant kinetic force while sliding, static limit while sticking.

    Not to be confused with viscous damping, which vanishes with the speed.

    Notes
    -----
    F_f = F_fk sgn(v_r) while sliding; while sticking F_f = -F_L, at most F_fs = μ_s F_N in
    magnitude, with F_L = m d²u/dt² + k_x x_r. Coulomb, Théorie des machines simples (1785);
    Eqs. (3), (4), (7) and (9) of the paper.
    """

    by_default: ClassVar[bool] = True
    closed_form: ClassVar[bool] = True

    # The base class serves laws without a direction, too.
    kinetic: DirectedForce | None = None  # type: ignore[assignment]
    """Kinetic friction force F_fk [N]: one value, or `{extension: ..., compression: ...}`."""
    static: DirectedForce | None = None  # type: ignore[assignment]
    """Static limit F_fs [N], at least the kinetic force; default: equal to it. One value, or
    one for each direction."""
    law: Literal["coulomb"]
    """Coulomb friction, the default of a block without `law`."""
    normal_variation: NormalVariation | None = None
    """Sinusoidal normal force; default: constant."""

    normal_record: NormalRecord | None = None
    """Recorded normal force in place of `normal`; F_fk and F_fs then refer to its mean, or to
    the weight of the mass if the record is of acceleration. Needs `mu_kinetic`."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        *FrictionLimits.at_most_one_of,
        ("normal", "normal_record"),
        ("normal_variation", "normal_record"),
    )
    needs: ClassVar[dict[str, str]] = {**FrictionLimits.needs, "normal_record": "mu_kinetic"}

    @model_validator(mode="after")
    def _check_directions(self) -> Self:
        extension, compression = by_direction(self.kinetic)
        if (extension == 0.0) != (compression == 0.0):
            raise InvalidValue("must be above 0 in both directions, or 0 in both", "kinetic")
        return self

    @property
    def is_directed(self) -> bool:
        """Whether the forces depend on the direction of motion."""
        return depends_on_direction(self.kinetic) or depends_on_direction(self.static)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies of a periodic normal force [Hz]."""
        varied = self.normal_variation
        return (varied.frequency,) if varied and varied.amplitude else ()

    def force_from_coefficient(self, mu: float, m: float) -> float:
        """Return the friction force [N] of a coefficient; a record counts by its mean."""
        mean = self.mean_normal_force
        return super().force_from_coefficient(mu, m) if mean is None else mu * mean

    @property
    def mean_normal_force(self) -> float | None:
        """Mean of a record of forces [N]; None: the friction forces refer to `normal`."""
        return None if self.normal_record is None else self.normal_record.force_record().mean

    def describe(self, swept: Collection[str] = ()) -> Iterator[str]:
        """Yield nothing: the forces describe the law."""
        return iter(())

    def in_direction(self, i: int) -> Self:
        """Return the block with the forces of extension (0) or compression (1) alone."""
        forces = {"kinetic": self.kinetic, "static": self.static}
        return self.model_copy(
            update={key: by_direction(force)[i] for key, force in forces.items()}
        )

    def with_defaults(self, m: float) -> dict[str, Any]:
        """Return the keys and values of the block with all defaults."""
        values = super().with_defaults(m)
        if self.normal_record is not None:
            values.pop("normal", None)
        return values

    def to_law(self, m: float) -> CoulombLaw | PiecewiseLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        if self.is_directed:
            extension, compression = (self.in_direction(i).to_law(m) for i in (0, 1))
            forces = compression.F_fk, compression.F_fs
            return extension.as_piecewise()._replace(compression=forces)
        alike = self.in_direction(0)
        F_fk, F_fs = alike.kinetic_force(m), alike.static_force(m)
        varied = self.normal_variation
        if self.normal_record is not None:
            record = self.normal_record.force_record()
            return PiecewiseLaw(F_fk, F_fs, force_record=record)
        if varied is None:
            return CoulombLaw(F_fk, F_fs)
        wave = varied.amplitude, 2 * pi * varied.frequency, principal_angle(varied.phase)
        # For many cases at once the amplitudes are a column, with all values below 1.
        lifts = isinstance(varied.amplitude, float) and varied.amplitude >= 1.0
        if lifts:
            return PiecewiseLaw(F_fk, F_fs, 0.0, *wave)
        return CoulombLaw(F_fk, F_fs, *wave)


# Elastic contacts, a spring in series with a slider: Jenkins, Petrov-Ewins.


class Jenkins(PositiveForce):
    """Linear spring in series with a Coulomb slider, for joints and bushings.

    Not to be confused with `dahl`, whose spring softens gradually.

    Notes
    -----
    While holding f = f_0 + k_t (x_r - x_0); it yields at |f| = F_fk and holds again when v_r
    reverses. Piecewise linear, so solved in closed form. Also known as Jenkins element or
    elastic slider. Jenkins, Brit. J. Appl. Phys. 13 (1962) 30.
    """

    closed_form: ClassVar[bool] = True

    law: Literal["jenkins"]
    """Linear spring in series with a Coulomb slider."""
    tangential_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Tangential contact stiffness k_t [N/m], above 0, while holding."""

    symbols: ClassVar[dict[str, str]] = {"tangential_stiffness": "k_t"}

    def to_law(self, m: float) -> PiecewiseLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        F_fk = self.kinetic_force(m)
        return PiecewiseLaw(F_fk, F_fk, self.tangential_stiffness)


class NormalMotion(Block):
    """Normal approach of the surfaces: amplitude·sin(2πft + phase)."""

    amplitude: Annotated[float, Quantity("m", at_least=0)]
    """Amplitude [m] of the approach."""
    frequency: Frequency
    """Frequency [Hz]."""
    phase: Angle = 0.0
    """Phase at t = 0 [rad]."""


class PetrovEwins(FrictionLaw):
    """Contact with tangential and normal stiffness, whose surfaces may separate.

    Not to be confused with `jenkins`, whose normal load is constant.

    Notes
    -----
    F_N = normal + k_n y(t); while holding f = f_0 + k_t (x_r - x_0), it yields at |f| = mu F_N,
    and there is no force while F_N <= 0. Piecewise linear, so solved in closed form. Petrov and
    Ewins, J. Turbomach. 125 (2003) 364.
    """

    closed_form: ClassVar[bool] = True

    law: Literal["petrov-ewins"]
    """Spring and slider under a varying normal load."""
    mu_kinetic: Annotated[float, Quantity("", above=0)]
    """Coefficient of friction [-], above 0."""
    normal: Annotated[float, Quantity("N", above=0)]
    """Mean normal load [N], above 0."""
    tangential_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Tangential contact stiffness k_t [N/m], above 0."""
    normal_stiffness: Annotated[float, Quantity("N/m", above=0)] | None = None
    """Normal contact stiffness k_n [N/m], above 0; without it the load is constant."""
    normal_motion: NormalMotion | None = None
    """Normal approach of the surfaces; needs a normal stiffness."""

    symbols: ClassVar[dict[str, str]] = {
        "tangential_stiffness": "k_t",
        "normal_stiffness": "k_n",
    }
    needs: ClassVar[dict[str, str]] = {
        "normal_stiffness": "normal_motion",
        "normal_motion": "normal_stiffness",
    }

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequency of a varying normal load [Hz]."""
        moved = self.normal_motion
        return (moved.frequency,) if moved and moved.amplitude else ()

    def to_law(self, m: float) -> PiecewiseLaw:
        """Return the law in forces; independent of the mass m [kg]."""
        F_fk = self.mu_kinetic * self.normal
        moved = self.normal_motion
        if moved is None or self.normal_stiffness is None:
            return PiecewiseLaw(F_fk, F_fk, self.tangential_stiffness)
        variation = self.normal_stiffness * moved.amplitude / self.normal
        wave = variation, 2 * pi * moved.frequency, principal_angle(moved.phase)
        return PiecewiseLaw(F_fk, F_fk, self.tangential_stiffness, *wave)


# Dynamic friction models: rate-dependent friction, or a differential equation for a state.
#
# Stribeck: friction decreases from the static limit with speed. Dahl: a softening spring
# before sliding. LuGre and Leuven: bristles below the Stribeck curve, Leuven's with hysteresis.


class Stribeck(FrictionLimits, PositiveForce):
    """Friction that decreases with speed, for lubricated or soft surfaces; true stick.

    Not to be confused with `coulomb`, whose force drops at once when sliding starts.

    Notes
    -----
    F_k(v) = F_fk + (F_fs - F_fk) exp(-|v/v_s|^δ) [N] against sliding, v and v_s [m/s]; sticks
    up to F_fs. Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994) 1083.
    """

    law: Literal["stribeck"]
    """Friction that decreases with speed."""
    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, over which friction falls from static to kinetic."""
    exponent: Annotated[float, Quantity("", at_least=0.5, below=20)] = 2.0
    """Exponent δ [-] of the Stribeck curve, from 0.5 to below 20; default 2, the Gaussian of
    Armstrong-Hélouvry. Published values: 0.5 to 1 for dry metals (Bo and Pavelescu), 1
    (Tustin), large values for boundary lubrication (Fuller). For 1 and 2 the Taylor series
    converge at rest; other values need two to four times as many steps near each stop. Below
    0.5 the initial slope is so steep that the default tolerance leaves an error above 1e-6 of
    the motion; there `coulomb` is close."""
    tolerance: Tolerance = DEFAULT_TOLERANCE
    """Truncation error of a step relative to the motion [-]; default 1e-12. The resulting error
    is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"stribeck_velocity": "v_s", "exponent": "δ"}

    def to_law(self, m: float) -> DynamicLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        F_fk, F_fs = self.kinetic_force(m), self.static_force(m)
        return DynamicLaw(
            F_fk, F_fs, STRIBECK, v_s=self.stribeck_velocity, exponent=self.exponent,
            tolerance=self.tolerance,
        )  # fmt: skip


class Dahl(PositiveForce):
    """Contact that yields gradually before it slides, as in rolling bearings; no stick.

    Not to be confused with `jenkins`, whose spring is linear up to the limit.

    Notes
    -----
    dz/dt = v (1 - σ_0 z sgn(v)/F_fk), F_f = σ_0 z, with z [m] the deflection of the contact.
    Dahl, A solid friction model, TOR-0158(3107-18)-1, The Aerospace Corporation (1968).
    """

    law: Literal["dahl"]
    """Dahl friction."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Contact stiffness σ_0 [N/m], above 0, before sliding."""
    tolerance: Tolerance = DEFAULT_TOLERANCE
    """Truncation error of a step relative to the motion [-]; default 1e-12. The resulting error
    is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {"bristle_stiffness": "σ_0"}

    def to_law(self, m: float) -> DynamicLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        F_fk = self.kinetic_force(m)
        return DynamicLaw(
            F_fk, F_fk, BRISTLE, sigma_0=self.bristle_stiffness, tolerance=self.tolerance
        )


class BristleLaw(FrictionLimits, PositiveForce):
    """Bristles between the surfaces, with a friction limit that decreases with speed."""

    stribeck_velocity: Annotated[float, Quantity("m/s", above=0)]
    """Speed v_s [m/s], above 0, over which friction falls from static to kinetic."""
    bristle_stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Initial stiffness σ_0 [N/m], above 0, of the bristles."""
    bristle_damping: Damping
    """Damping σ_1 [N·s/m], at least 0, of the bristles."""
    viscous: Damping = 0.0
    """Viscous friction σ_2 [N·s/m] of the contact, in addition to the damper; default 0."""

    symbols: ClassVar[dict[str, str]] = {
        "stribeck_velocity": "v_s",
        "bristle_stiffness": "σ_0",
        "bristle_damping": "σ_1",
        "viscous": "σ_2",
    }

    def to_bristle_law(self, m: float, kind: int, tolerance: float) -> DynamicLaw:
        """Return the law in forces for a kind of bristles; mass m [kg] as in `to_law`."""
        return DynamicLaw(
            self.kinetic_force(m), self.static_force(m), kind, v_s=self.stribeck_velocity,
            sigma_0=self.bristle_stiffness, sigma_1=self.bristle_damping,
            sigma_2=self.viscous, tolerance=tolerance,
        )  # fmt: skip


class Lugre(BristleLaw):
    """Elastic bristles with Stribeck friction: presliding, friction lag and creep.

    Not to be confused with `leuven`, whose bristles have hysteresis with nonlocal memory.

    Notes
    -----
    dz/dt = v - σ_0 |v| z/g(v), F_f = σ_0 z + σ_1 dz/dt + σ_2 v [N], with g = F_fk + (F_fs -
    F_fk) exp(-(v/v_s)²) and z [m] the mean deflection of the bristles. Canudas de Wit, Olsson,
    Åström and Lischinsky, IEEE TAC 40 (1995) 419.
    """

    law: Literal["lugre"]
    """LuGre friction."""
    tolerance: Tolerance = DEFAULT_TOLERANCE
    """Truncation error of a step relative to the motion [-]; default 1e-12. The resulting error
    is stated with the result."""

    def to_law(self, m: float) -> DynamicLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        return self.to_bristle_law(m, BRISTLE, self.tolerance)


class Leuven(BristleLaw):
    """Bristles with hysteresis and nonlocal memory: an inner loop closes where it began.

    Not to be confused with `lugre`, whose bristles are elastic and have one state.

    Notes
    -----
    dz/dt = v (1 - sgn(F_h/s) |F_h/s|^n), F_f = F_h + σ_1 dz/dt + σ_2 v [N], with the limit s =
    sgn(v) (F_fk + (F_fs - F_fk) exp(-(v/v_s)²)) and F_h the hysteresis force as a function of
    the bristle deflection z [m]: on the virgin curve F_∞ (1 - exp(-σ_0 |z|/F_∞)); after a
    reversal the same curve scaled by two (Masing); and where a loop closes, the curve of the
    enclosing loop. Swevers, Al-Bender, Ganseman and Prajogo, IEEE TAC 45 (2000) 675, leave the
    virgin curve open; this one is a choice of drysim.

    Lampaert, Swevers and Al-Bender, IEEE TAC 47 (2002) 683, make two corrections. (1) The whole
    F_h stands in dz/dt, not the part since the last reversal, so that the force is continuous
    when a loop closes; this is adopted. (2) They replace the stack of reversals by a finite
    number of Maxwell slip elements, which cannot overflow. Here the stack is kept, which is the
    limit of many elements. It holds 128 reversals; when it is full, the two that differ least
    from their neighbours are dropped, and the force stays continuous. In the worst case, 128
    evenly nested reversals from limit to limit with F_∞ = 2 F_fs, this changes the force later
    by 1e-4 of F_fs; a hundred Maxwell elements have an error of this size throughout.
    """

    law: Literal["leuven"]
    """Leuven friction."""
    hysteresis_ratio: Annotated[float, Quantity("", above=1)] = 2.0
    """Hysteresis ratio F_∞/F_fs [-], above 1: asymptotic force of the bristles over the static
    limit; default 2. The larger it is, the narrower the hysteresis loops; the limit is
    elastic."""
    transition: Annotated[float, Quantity("", at_least=0.5, below=20)] = 1.0
    """Exponent n [-] of the transition to sliding, from 0.5 to below 20; default 1. The larger
    it is, the later the bristles yield. For 1, 2 and 3 the Taylor series converge at zero
    force; other values need up to four times as many steps there."""
    tolerance: Tolerance = DEFAULT_TOLERANCE
    """Truncation error of a step relative to the motion [-]; default 1e-12. The resulting error
    is stated with the result."""

    symbols: ClassVar[dict[str, str]] = {
        **BristleLaw.symbols,
        "hysteresis_ratio": "F_∞/F_fs",
        "transition": "n",
    }

    def to_law(self, m: float) -> DynamicLaw:
        """Return the law in forces; the mass m [kg] gives the default normal force."""
        law = self.to_bristle_law(m, LEUVEN, self.tolerance)
        return law._replace(F_h=self.hysteresis_ratio * law.F_fs, power=self.transition)


# All laws.

FRICTION_LAWS = (Coulomb, Stribeck, Jenkins, PetrovEwins, Dahl, Lugre, Leuven)

Friction = Coulomb | Stribeck | Jenkins | PetrovEwins | Dahl | Lugre | Leuven


NOT_LISTED = frozenset({*Coulomb.model_fields, "tolerance"})
"""Keys described as forces, and the tolerance, which is not part of the law."""
