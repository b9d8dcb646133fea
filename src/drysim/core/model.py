"""Named tuples of a scene in SI units: plant, friction laws, base motion, state and integrals.

Kernels read these values as they are. The functions at the end serve every user of a base
motion: its values, the integrals of its squares, and block-wise access to signals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, Protocol, TypeVar, cast
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from drysim.core.compile import is_plain
from drysim.errors import WarningMessage

Floats = NDArray[np.float64]
"""Array of numbers."""

# The oscillator and its friction.


class Plant(NamedTuple):
    """Mass on a spring and a damper.

    Attributes
    ----------
    m : float
        Sprung mass [kg], above 0.
    k_x : float
        Spring stiffness [N/m], at least 0.
    b : float
        Viscous damping [N·s/m], at least 0.
    """

    m: float
    k_x: float
    b: float


def limit_force(plant: Plant, x_r: Any, u_dd: Any) -> Any:
    """Return F_L, the force that the interface must carry to keep the mass stuck [N], Eq. (9).

    Notes
    -----
    Valid at v_r = 0 only, as it has no damper term. Not to be confused with the friction force
    F_f, which is -F_L while stuck.
    """
    return plant.m * u_dd + plant.k_x * x_r


class PlainContact:
    """Constants of a contact without elasticity, separation, direction or end stops.

    `PiecewiseLaw` has fields of these names.
    """

    __slots__ = ()

    is_elastic = False
    """The contact is no spring in series with a slider."""
    may_separate = False
    """The surfaces never separate."""
    is_directed = False
    """Nothing depends on the direction of motion."""
    force_record: None = None
    """The normal force is not recorded."""
    stops: None = None
    """There are no end stops."""
    compression: None = None
    """The forces are the same in both directions."""
    damping: None = None
    """The damper is that of the plant."""


class CoulombParameters(NamedTuple):
    """Fields of a `CoulombLaw`; a NamedTuple cannot inherit from `PlainContact` itself."""

    F_fk: float
    F_fs: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0


class CoulombLaw(CoulombParameters, PlainContact):
    """Coulomb friction; both limits may follow a normal force that varies as a sine.

    The limits at time t are `F_fk` and `F_fs` times 1 + variation·sin(omega·t + phase).

    Attributes
    ----------
    F_fk : float
        Kinetic friction force [N], at least 0.
    F_fs : float
        Static limit [N], at least `F_fk`.
    variation : float
        Relative amplitude of the normal force [-], 0 to below 1; 0 means constant.
    omega : float
        Angular frequency of the variation [rad/s].
    phase : float
        Phase of the variation at t = 0 [rad].
    """

    __slots__ = ()

    can_stick = True
    """The mass can stick under this law."""

    @property
    def varies(self) -> bool:
        """Whether the normal force varies."""
        return bool(self.variation)

    @property
    def without_stops(self) -> CoulombLaw:
        """The law itself."""
        return self

    def as_piecewise(self) -> PiecewiseLaw:
        """Return the same law as a `PiecewiseLaw`, to which more may be added."""
        F_fk, F_fs, variation, omega, phase = self
        return PiecewiseLaw(F_fk, F_fs, 0.0, variation, omega, phase)


MAX_STAGES = 3
"""Largest number of linear stages of a bumper."""


class StrokeLimits(NamedTuple):
    """Limits of the relative displacement, reached where x_r >= up or x_r <= -down.

    Attributes
    ----------
    up, down : float
        Distance of the limits at positive and at negative x_r [m], above 0.
    """

    up: float
    down: float

    def side(self, x_r: Any) -> Any:
        """Return 1 where displacements [m] are at or beyond `up`, -1 for `down`, else 0."""
        return np.subtract(x_r >= self.up, x_r <= -self.down, dtype=np.int8)


NO_LIMITS = StrokeLimits(math.inf, math.inf)


class EndStops(NamedTuple):
    """End stops on both sides: bumpers, or rigid stops.

    Attributes
    ----------
    limits : StrokeLimits
        Positions of the stops.
    stages : tuple of (float, float)
        Stages of a bumper: penetration at which each begins [m], 0 for the first, and the
        stiffness that it adds [N/m]. Rigid stops have none.
    b_s : float
        Damping of a bumper [N·s/m], at least 0.
    e : float
        Coefficient of restitution of a rigid stop [-], 0 to 1.
    """

    limits: StrokeLimits
    stages: tuple[tuple[float, float], ...] = ()
    b_s: float = 0.0
    e: float = 0.0

    @property
    def rigid(self) -> bool:
        """Whether the stops are rigid."""
        return not self.stages

    def elastic_force_and_energy(self, x_r: float) -> tuple[float, float]:
        """Return force [N] and energy [J] of a bumper at rest at x_r [m]; 0 if apart."""
        depth = abs(x_r) - (self.limits.up if x_r > 0.0 else self.limits.down)
        force, energy = 0.0, 0.0
        for begin, stiffness in self.stages:
            squeezed = max(depth - begin, 0.0)
            force += stiffness * squeezed
            energy += 0.5 * stiffness * squeezed**2
        return force, energy


class PiecewiseLaw(NamedTuple):
    """Friction contact and end stops with a closed-form solution in each mode.

    The contact is rigid, and sticks and slides as under `CoulombLaw`, or elastic: a spring in
    series with a slider, which holds and yields. The limits at time t are `F_fk` and `F_fs`
    times the normal force relative to its mean: 1 + variation·sin(omega·t + phase), or
    `force_record`. Where that is negative the surfaces are separated and there is no friction.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force, or limit of an elastic contact [N]; and static limit [N].
    k_t : float
        Tangential stiffness of an elastic contact [N/m]; 0 for a rigid contact.
    variation : float
        Relative amplitude of the normal force [-], at least 0.
    omega, phase : float
        Angular frequency of the variation [rad/s] and its phase at t = 0 [rad].
    force_record : NormalForceRecord or None
        Recorded normal force, in place of a variation.
    stops : EndStops or None
    compression : tuple of float or None
        F_fk and F_fs of a rigid contact against v_r < 0 [N], where `F_fk` and `F_fs` hold for
        v_r > 0 (extension); None for equal forces.
    damping : tuple of float or None
        Damping [N·s/m] of v_r > 0 and of v_r < 0, in place of that of the plant.

    Notes
    -----
    Source: E. P. Petrov and D. J. Ewins, J. Turbomach. 125 (2003) 364, for the elastic contact.
    """

    F_fk: float
    F_fs: float
    k_t: float = 0.0
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0
    force_record: NormalForceRecord | None = None
    stops: EndStops | None = None
    compression: tuple[float, float] | None = None
    damping: tuple[float, float] | None = None

    @property
    def is_directed(self) -> bool:
        """Whether friction or damping depends on the direction of motion."""
        return self.compression is not None or self.damping is not None

    @property
    def is_elastic(self) -> bool:
        """Whether the contact is elastic: it deforms before it slides."""
        return self.k_t > 0.0

    @property
    def can_stick(self) -> bool:
        """Whether the mass can stick under this law."""
        return not self.is_elastic

    @property
    def varies(self) -> bool:
        """Whether the normal force varies."""
        return bool(self.variation) or self.force_record is not None

    @property
    def may_separate(self) -> bool:
        """Whether the normal force of a rigid contact may vanish, or is recorded."""
        return not self.is_elastic and (self.variation >= 1.0 or self.force_record is not None)

    def as_piecewise(self) -> PiecewiseLaw:
        """Return this law."""
        return self

    @property
    def without_stops(self) -> CoulombLaw | PiecewiseLaw:
        """The same contact without end stops."""
        if self.is_elastic or self.may_separate or self.is_directed:
            return self._replace(stops=None)
        return CoulombLaw(self.F_fk, self.F_fs, self.variation, self.omega, self.phase)

    def load(self, t: Any) -> Any:
        """Return the normal force relative to its mean [-] at times t [s]; 0 if separated."""
        if self.force_record is None:
            load = 1.0 + self.variation * np.sin(self.omega * t + self.phase)
        else:
            times = np.arange(len(self.force_record.relative)) * self.force_record.step
            load = np.interp(t, times, self.force_record.relative)
        return np.maximum(load, 0.0)


STRIBECK, BRISTLE, LEUVEN = 0, 1, 2
"""Kinds of dynamic law; `BRISTLE` is LuGre, with Dahl as a special case."""


class DynamicParameters(NamedTuple):
    """Fields of a `DynamicLaw`."""

    F_fk: float
    F_fs: float
    kind: int
    v_s: float = 1.0
    exponent: float = 2.0
    sigma_0: float = 0.0
    sigma_1: float = 0.0
    sigma_2: float = 0.0
    F_h: float = math.inf
    power: float = 1.0
    depth: int = 128
    tolerance: float = 1e-12


class DynamicLaw(DynamicParameters, PlainContact):
    """Friction force that depends on velocity or on the deflection z of bristles.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force [N], above 0, and static limit [N], at least that.
    kind : int
        `STRIBECK`, `BRISTLE` or `LEUVEN`.
    v_s : float
        Stribeck velocity [m/s], above 0; unused where F_fs = F_fk.
    exponent : float
        Exponent of |v/v_s| in the Stribeck curve, above 0; 2 for all kinds but `STRIBECK`.
    sigma_0, sigma_1, sigma_2 : float
        Stiffness [N/m] and damping [N·s/m] of the bristles, viscous friction [N·s/m].
    F_h : float
        Asymptote of the hysteresis force of `LEUVEN` [N], above `F_fs`.
    power : float
        Exponent of the transition from pre-sliding to sliding of `LEUVEN`, above 0.
    depth : int
        Maximum number of reversals stored by the hysteresis of `LEUVEN`.
    tolerance : float
        Relative change of the motion that one step of the solution may neglect [-].
    """

    __slots__ = ()

    variation = 0.0
    """The limits of these laws are constant."""

    @property
    def can_stick(self) -> bool:
        """Whether the mass can stick; bristles always deform."""
        return self.kind == STRIBECK


@dataclass(frozen=True, eq=False)
class NormalForceRecord:
    """Recorded normal force, linear between its samples; compared by identity.

    Attributes
    ----------
    relative : ndarray, shape (n,)
        Force relative to the one that the friction forces refer to [-]; the first sample is
        t = 0.
    step : float
        Sampling interval [s].
    mean : float or None
        Mean of the samples [N], above 0, which the friction forces refer to; None if they refer
        to the weight of the mass.
    inputs : tuple of Input
        File it was read from.
    warnings : tuple of WarningMessage
        Warnings about the record.
    clean_up : tuple of mapping
        Cleaning steps applied on request, in order.
    """

    relative: NDArray[np.float64]
    step: float
    mean: float | None
    inputs: tuple[Input, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    clean_up: tuple[Mapping[str, object], ...] = ()

    @property
    def kernel_input(self) -> Any:
        """The relative force in the form that the kernels take."""
        return self.relative_list if is_plain() else self.relative

    @cached_property
    def relative_list(self) -> list[float]:
        """The relative force as a list."""
        return cast(list[float], self.relative.tolist())

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return (len(self.relative) - 1) * self.step


AnyLaw = CoulombLaw | DynamicLaw | PiecewiseLaw
"""Any friction law, with or without end stops."""


def has_friction(law: AnyLaw) -> bool:
    """Return whether there is dry friction, in one direction at least."""
    return law.F_fs > 0.0 or (law.compression is not None and law.compression[1] > 0.0)


# State of a motion and its integrals.


class State(NamedTuple):
    """Relative displacement [m] and velocity [m/s] at one instant."""

    x_r: float
    v_r: float


class ContactState(NamedTuple):
    """State of a motion with the internal state of its contact.

    Attributes
    ----------
    x_r, v_r, z : float
        Relative displacement [m] and velocity [m/s]; deflection of the bristles [m], or for an
        elastic contact the x_r at which it carries no force [m].
    reversals : tuple of float
        Deflections at the remembered reversals [m], the oldest first.
    """

    x_r: float
    v_r: float
    z: float
    reversals: tuple[float, ...] = ()


AnyState = State | ContactState
"""Any start of a motion."""


class Points(NamedTuple):
    """Motion at given times; each array has shape (n,).

    Attributes
    ----------
    x_r, v_r : array of float
        Relative displacement [m] and velocity [m/s].
    d : array of int
        Direction of motion: -1, +1, or 0 at rest, held by friction or against a rigid stop.
    x_dd : array of float
        Absolute acceleration [m/s²]; ü at rest.
    F_f : array of float, or None
        Friction force [N]; None where it follows from the others and the law.
    F_stop : array of float, or None
        Force of an end stop [N], sign as for friction; None without end stops.
    z : array of float, or None
        x_r at which an elastic contact would carry no force, or deflection of bristles [m];
        None where it is not known.
    """

    x_r: NDArray[np.float64]
    v_r: NDArray[np.float64]
    d: NDArray[np.int8]
    x_dd: NDArray[np.float64]
    F_f: Any = None
    F_stop: Any = None
    z: Any = None

    def part(self, first: int, last: int) -> Points:
        """Return points `first` to `last` - 1."""
        return self.select(slice(first, last))

    def select(self, which: Any) -> Points:
        """Return some of the points, by a slice or an index."""
        parts: Any = (None if column is None else column[which] for column in self)
        return Points(*parts)


ATTRACTING_MODULUS = 1.0 - 1e-7
"""Modulus of a Floquet multiplier below which an orbit attracts its neighbours [-].

Two multipliers that coincide change by the root of a change of their matrix: by 3e-8 for a few
roundings. Those of a neutral orbit are 1 to within that."""


class Totals(NamedTuple):
    """Integrals over a window of time.

    Attributes
    ----------
    x2, v2, x_dd2 : float
        Integrals of x_r² [m²s], v_r² [m²/s] and of the squared absolute acceleration x_dd²
        [m²/s³].
    power : float
        Integral of ü v_r [m²/s²]: minus the work of the base per mass.
    sliding_distance : float
        Energy dissipated in the contact divided by F_fk [m]: under Coulomb friction, and
        without any, the integral of |v_r| times the relative normal force.
    stuck : float
        Time at rest, held by friction or against a rigid stop [s].
    u_dd2 : float
        Integral of ü² [m²/s³].
    u2 : float or None
        Integral of u² [m²s]; None where u is not known.
    stop_work : float
        Work done by the mass on the end stops [J].
    friction_loss, damper_work : float or None
        Energy dissipated in contact and damper [J]; None where it is F_fk times
        `sliding_distance`, and b times `v2`.
    violation : float or None
        Largest violation of the laws of friction and stops, relative to the forces, or for a
        penetration to the position of the stop [-]; None where it is not known.
    x_dd_peak : float or None
        Largest |x_dd| [m/s²], both sides of every jump included; None where it is not known.
    """

    x2: float
    v2: float
    x_dd2: float
    power: float
    sliding_distance: float
    stuck: float
    u_dd2: float
    u2: float | None
    stop_work: float = 0.0
    friction_loss: float | None = None
    damper_work: float | None = None
    violation: float | None = None
    x_dd_peak: float | None = None


# The motion of the base.

BLOCK_SIZE = 65_536
"""Numbers processed at a time: half a megabyte per array, which stays in the cache."""

MAX_CACHED = 1 << 20
"""Maximum length of a recomputable signal that is cached, 8 MB. A longer motion is solved in
parts that are recomputed on demand, which costs a tenth of writing them to disk."""

T = TypeVar("T")


def recall(size: float, compute: Callable[..., T], *arguments: Any) -> T:
    """Return `compute(*arguments)`, computed once unless it is an array of a large `size`.

    The latest few results are kept.
    """
    call = _latest if size <= MAX_CACHED else _latest.__wrapped__
    result: T = call(compute, *arguments)
    return result


@lru_cache(maxsize=8)
def _latest(compute: Callable[..., Any], *arguments: Any) -> Any:
    return compute(*arguments)


MAX_KEPT_VALUES = 16
"""Most values that are kept for the same samples: those of a few windows."""

_kept_values: dict[int, dict[Any, Any]] = {}
"""Values by the identity of samples u_dd, as long as these exist."""


def keep_values(motion: Sines | Samples) -> None:
    """Enable caching in `recall_for` for a base motion whose samples will not change."""
    u_dd = motion.u_dd if isinstance(motion, Samples) else None
    if isinstance(u_dd, np.ndarray) and id(u_dd) not in _kept_values:
        _kept_values[id(u_dd)] = {}
        finalize(u_dd, _kept_values.pop, id(u_dd), None).atexit = False


def recall_for(motion: Sines | Samples, compute: Callable[..., T], *arguments: Any) -> T:
    """Return `compute(motion, *arguments)`, computed once if values of the motion are kept."""
    if not isinstance(motion, Samples) or id(motion.u_dd) not in _kept_values:
        return compute(motion, *arguments)
    values = _kept_values[id(motion.u_dd)]
    key = compute, id(motion.u), motion.dt, motion.mean_squares, *arguments
    if key not in values and len(values) >= MAX_KEPT_VALUES:
        values.clear()
    # The value is kept with u, whose identity is part of the key.
    kept = values.get(key) or values.setdefault(key, (compute(motion, *arguments), motion.u))
    result: T = kept[0]
    return result


FOUR_NODES = (
    0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262,
)  # fmt: skip
FOUR_WEIGHTS = (
    0.17392742256872679, 0.3260725774312732, 0.3260725774312732, 0.17392742256872679,
)  # fmt: skip
"""Gauss-Legendre nodes and weights on [0, 1]: exact for the square of a cubic."""

TWELVE_NODES = (
    0.009219682876640378, 0.0479413718147626, 0.11504866290284765, 0.20634102285669126,
    0.31608425050090994, 0.43738329574426554, 0.5626167042557344, 0.6839157494990901,
    0.7936589771433087, 0.8849513370971523, 0.9520586281852375, 0.9907803171233596,
)  # fmt: skip
TWELVE_WEIGHTS = (
    0.023587668193255706, 0.05346966299765953, 0.08003916427167321, 0.10158371336153287,
    0.1167462682691773, 0.12457352290670134, 0.12457352290670134, 0.1167462682691773,
    0.10158371336153287, 0.08003916427167321, 0.05346966299765953, 0.023587668193255706,
)  # fmt: skip
"""The same for an exponential or sine over several radians."""

STEPS_PER_SUM = 8192
"""Maximum number of steps summed by one dot product, so that BLAS starts no threads."""


class Signal(Protocol):
    """Sequence of numbers that can be read by slices; arrays are signals."""

    def __len__(self) -> int:
        """Return the number of samples."""

    def __getitem__(self, part: slice, /) -> NDArray[np.float64]:
        """Return a slice as an array."""


class Input(NamedTuple):
    """File that was read: name in the scenario, SHA-256 (hex) and size [bytes]."""

    file: str
    sha256: str
    size: int


class RecordSummary(NamedTuple):
    """What is said of one of several records, without its samples.

    Attributes
    ----------
    file : str
        Its name in the scenario.
    rms : float
        RMS base acceleration [m/s²].
    duration : float
        [s].
    clean_up : tuple of mapping
        Processing steps, as in `Samples.realised`.
    """

    file: str
    rms: float
    duration: float
    clean_up: tuple[Mapping[str, object], ...] = ()


class Sines(NamedTuple):
    """Base acceleration ü(t) = Σ A sin(2π f t + phase), used analytically.

    Not to be confused with `Samples` of a sine: nothing is interpolated here.

    Attributes
    ----------
    A : tuple of float
        Amplitudes of ü [m/s²], not RMS values.
    f : tuple of float
        Frequencies [Hz], above 0.
    phase : tuple of float
        Phases at t = 0 [rad].
    """

    A: tuple[float, ...]
    f: tuple[float, ...]
    phase: tuple[float, ...]


def principal_angle(phase: Any) -> Any:
    """Return an angle beyond a turn, or those of an array, within half a turn of 0 [rad].

    Large angles lose their digits when others are added. Sine and cosine reduce them exactly.
    """
    if isinstance(phase, float):
        return phase if abs(phase) <= math.tau else math.atan2(math.sin(phase), math.cos(phase))
    reduced = np.arctan2(np.sin(phase), np.cos(phase))
    return np.where(np.abs(phase) <= math.tau, phase, reduced)


class Samples(NamedTuple):
    """Equidistant base acceleration, linear between samples; ends at its last sample.

    Attributes
    ----------
    u_dd : ndarray, shape (n,), or another signal
        Base acceleration [m/s²]; the first sample is t = 0.
    dt : float
        Sampling interval [s].
    u : ndarray, shape (n,), or another signal, or None
        Base displacement [m] at the samples where the source provides it; the cubic between two
        samples follows from `u` and `u_dd`. Only T_x needs it.
    inputs : tuple of Input
        Files the samples were read from.
    warnings : tuple of WarningMessage
        Warnings about the signal.
    realised : mapping
        For a generated signal: requested and realised values by name, in SI units.
    rest : int
        Number of samples at rest, the last ones, that `with_rest` appended.
    goes_on : bool
        Whether the source has samples after the last one, which a window leaves out.
    mean_squares : tuple of float or None
        Mean of ü² and of u² over all samples, where both are known in closed form.
    """

    u_dd: Signal
    dt: float
    u: Signal | None = None
    inputs: tuple[Input, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    realised: Mapping[str, object] = {}
    rest: int = 0
    goes_on: bool = False
    mean_squares: tuple[float, float] | None = None


def with_rest(motion: Samples, count: int) -> Samples:
    """Return a base motion that stays at rest for `count` steps after its last sample."""
    if not count:
        return motion
    u_dd = np.concatenate((motion.u_dd[:], np.zeros(count)))
    u = None
    if motion.u is not None:
        u = np.append(motion.u[:], np.full(count, motion.u[-1:]))
    return motion._replace(u_dd=u_dd, u=u, rest=count, mean_squares=None)


def without_rest(motion: Samples) -> Samples:
    """Return a base motion as its source has it, without the rest appended to it."""
    if not motion.rest:
        return motion
    last = len(motion.u_dd) - motion.rest
    u = None if motion.u is None else motion.u[:last]
    return motion._replace(u_dd=motion.u_dd[:last], u=u, rest=0)


def base_acceleration(sines: Sines, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ü of sines [m/s²] at times t [s], in the shape of `t`."""
    u_dd = np.zeros_like(t)
    for A, f, phase in zip(*sines, strict=True):
        u_dd += A * np.sin(2.0 * np.pi * ((f * t) % 1.0) + phase)
    return u_dd


def acceleration_at(motion: Sines | Samples, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ü of any base motion [m/s²] at times t [s] within it, in the shape of `t`."""
    if isinstance(motion, Sines):
        return base_acceleration(motion, t)
    n = np.minimum((t / motion.dt).astype(np.intp), len(motion.u_dd) - 2)
    u_dd = motion.u_dd[:]
    q = t / motion.dt - n
    interpolated: NDArray[np.float64] = (1.0 - q) * u_dd[n] + q * u_dd[n + 1]
    return interpolated


def interpolate_displacement(
    motion: Samples, n: NDArray[np.intp], q: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return u [m] at the fraction q of the steps n: the cubic whose second derivative is ü."""
    assert motion.u is not None, "u must be known"
    p = 1.0 - q
    u_dd, u = motion.u_dd[:], motion.u[:]
    curvature = (p**3 - p) * u_dd[n] + (q**3 - q) * u_dd[n + 1]
    between: NDArray[np.float64] = p * u[n] + q * u[n + 1] + motion.dt**2 / 6.0 * curvature
    return between


def integrate_base_squares(
    motion: Samples, begin: float, end: float
) -> tuple[float, float | None]:
    """Return the integrals of ü² and, where u is known, of u² over a window of samples."""
    dt, samples = motion.dt, len(motion.u_dd)
    if motion.mean_squares is not None and begin == 0.0 and end == (samples - 1) * dt:
        u_dd2, u2 = motion.mean_squares
        return u_dd2 * end, None if motion.u is None else u2 * end
    first, last = int(begin / dt), min(math.ceil(end / dt), samples - 1)
    # Whole steps lo to hi - 1 are integrated by closed forms, the one or two steps cut by the
    # window by quadrature.
    lo = first + (first * dt < begin)
    hi = max(last - (last * dt > end), lo)
    u_dd2, u2 = 0.0, 0.0
    for n in sorted({first, last - 1}):
        if lo <= n < hi:
            continue
        part = partial_step_squares(motion, n, begin, end)
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    for start in range(lo, hi, STEPS_PER_SUM):
        part = whole_step_squares(motion, start, min(start + STEPS_PER_SUM, hi))
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    return u_dd2, None if motion.u is None else u2


def partial_step_squares(
    motion: Samples, n: int, begin: float, end: float
) -> tuple[float, float]:
    """Return the integrals of ü² and u² over the part of step n within a window."""
    dt, u_dd2, u2 = motion.dt, 0.0, 0.0
    lo = max(begin / dt - n, 0.0)
    width = min(end / dt - n, 1.0) - lo
    a_0, a_1 = motion.u_dd[n : n + 2].tolist()
    for node, weight in zip(FOUR_NODES, FOUR_WEIGHTS, strict=True):
        q = lo + width * node
        u_dd2 += weight * dt * width * ((1.0 - q) * a_0 + q * a_1) ** 2
        if motion.u is not None:
            u = interpolate_displacement(motion, np.array([n]), np.array([q]))
            u2 += weight * dt * width * float(u[0]) ** 2
    return u_dd2, u2


def whole_step_squares(motion: Samples, first: int, last: int) -> tuple[float, float]:
    """Return the integrals of ü² and u² over the steps between two samples."""
    u_dd, dt = motion.u_dd[first : last + 1], motion.dt
    a_0, a_1 = u_dd[:-1], u_dd[1:]
    same, neighbour = np.dot(a_0, a_0), np.dot(a_0, a_1)
    ends = float(u_dd[-1]) ** 2 - float(u_dd[0]) ** 2
    u_dd2 = dt / 3.0 * (2.0 * same + ends + neighbour)
    if motion.u is None:
        return float(u_dd2), 0.0
    u = motion.u[first : last + 1]
    x_0, x_1 = u[:-1], u[1:]
    scale = dt * dt / 6.0
    # Closed-form integrals of the squared cubics over a step, scaled to unit length.
    squares = (np.dot(x_0, x_0) + np.dot(x_0, x_1) + np.dot(x_1, x_1)) / 3.0
    mixed = (np.dot(x_0, a_0) + np.dot(x_1, a_1)) * 4.0 / 15.0
    mixed += (np.dot(x_0, a_1) + np.dot(x_1, a_0)) * 7.0 / 30.0
    curvature = (2.0 * same + ends) * 8.0 / 105.0 + neighbour * 31.0 / 210.0
    return float(u_dd2), float(dt * (squares - scale * mixed + scale * scale * curvature))


def blocks(signal: Signal, size: int = BLOCK_SIZE) -> Iterator[NDArray[np.float64]]:
    """Return an iterator over a signal, block by block."""
    return (signal[start : start + size] for start in range(0, len(signal), size))


def mean_and_std(signal: Signal) -> tuple[float, float]:
    """Return the mean of a signal and its RMS about that mean."""
    mean = sum(float(part.sum()) for part in blocks(signal)) / len(signal)
    squares = sum(float(np.square(part - mean).sum()) for part in blocks(signal))
    return mean, math.sqrt(squares / len(signal))


def max_abs(signal: Signal) -> float:
    """Return the greatest absolute value of a signal."""
    return max((float(np.abs(part).max()) for part in blocks(signal)), default=0.0)
