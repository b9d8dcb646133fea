"""Plant, friction laws, end stops, Sines, Samples, State, Totals as named tuples.

The plain values of a scene, in SI units: kernels read them as they are. At the end what every
reader of a base motion needs: its values, its squares, and any signal block by block.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.core.compile import as_engine_array
from drysim.errors import WarningMessage

# The oscillator and its friction.


class Plant(NamedTuple):
    """Mass on spring and damper.

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


class CoulombLaw(NamedTuple):
    """Coulomb's dry friction; both limits may follow a normal force that varies as a sine.

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

    F_fk: float
    F_fs: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0

    @property
    def can_stick(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True


class EndStopLaw(NamedTuple):
    """Coulomb's dry friction on a stroke that ends at a stop on either side.

    A stop is a bumper where `k_s` is above 0, and rigid where it is 0.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force [N], at least 0, and static limit [N], at least that.
    x_rM : float
        Where the stops are [m]: at |x_r| = x_rM, above 0.
    k_s, b_s : float
        Stiffness [N/m] and damping [N·s/m] of a bumper, at least 0.
    e : float
        Restitution of a rigid stop [-], 0 to 1.
    variation, omega, phase : float
        Of the normal force, as in `CoulombLaw`.
    """

    F_fk: float
    F_fs: float
    x_rM: float
    k_s: float = 0.0
    b_s: float = 0.0
    e: float = 0.0
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0

    @property
    def can_stick(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True

    @property
    def rigid(self) -> bool:
        """Whether the stops give way to nothing."""
        return self.k_s == 0.0

    @property
    def coulomb(self) -> CoulombLaw:
        """The same friction without the stops."""
        return CoulombLaw(self.F_fk, self.F_fs, self.variation, self.omega, self.phase)


class ElasticContactLaw(NamedTuple):
    """A contact that is a spring until it yields; its normal force may vary as a sine.

    The limit at time t is `F_fk` times 1 + variation·sin(omega·t + phase); where that is below
    zero the surfaces have parted and there is no force.

    Attributes
    ----------
    F_fk : float
        Limit of the contact force [N], above 0.
    k_t : float
        Tangential stiffness [N/m], above 0.
    variation : float
        Relative amplitude of the normal force [-], at least 0.
    omega, phase : float
        Angular frequency of the variation [rad/s] and its phase at t = 0 [rad].
    """

    F_fk: float
    k_t: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0

    @property
    def F_fs(self) -> float:
        """F_fk [N]: one limit serves both."""
        return self.F_fk

    @property
    def can_stick(self) -> bool:
        """False: the contact yields a little before it slides."""
        return False


STRIBECK, BRISTLE, LEUVEN = 0, 1, 2
"""Kinds of dynamic law; that of bristles serves Dahl's, too."""


class DynamicLaw(NamedTuple):
    """A friction force that depends on the speed or on a deflection z before sliding.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force [N], above 0, and static limit [N], at least that.
    kind : int
        `STRIBECK`, `BRISTLE` or `LEUVEN`.
    v_s : float
        Stribeck velocity [m/s], above 0; of no account where F_fs = F_fk.
    exponent : float
        Of |v/v_s| in the Stribeck curve, above 0; 2 for all kinds but `STRIBECK`.
    sigma_0, sigma_1, sigma_2 : float
        Stiffness [N/m] and damping [N·s/m] of the bristles, viscous friction [N·s/m].
    F_h : float
        Force that the hysteresis of `LEUVEN` would come to [N], above `F_fs`.
    power : float
        Of the approach to sliding under `LEUVEN`, above 0.
    depth : int
        How many turns the bristles of `LEUVEN` remember at most.
    tolerance : float
        Share of the motion that one step of the solution may neglect [-].
    """

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

    @property
    def variation(self) -> float:
        """Zero: the limits of these laws are constant."""
        return 0.0

    @property
    def can_stick(self) -> bool:
        """Whether a contact under this law can hold still; bristles always give a little."""
        return self.kind == STRIBECK


class NormalForceLaw(NamedTuple):
    """Coulomb's dry friction under a normal force that may vanish or be any recorded one.

    The limits at time t are `F_fk` and `F_fs` times the normal force relative to its mean:
    1 + variation·sin(omega·t + phase), or what `force_record` says. Where that is not above zero
    the surfaces have parted and there is no friction. Not to be confused with `CoulombLaw`, whose
    surfaces never part.

    Attributes
    ----------
    F_fk, F_fs : float
        Kinetic friction force and static limit under the mean normal force [N].
    variation : float
        Relative amplitude of the normal force [-], at least 0.
    omega, phase : float
        Angular frequency of the variation [rad/s] and its phase at t = 0 [rad].
    pressure : Pressure or None
        The recorded normal force, in place of a variation.
    """

    F_fk: float
    F_fs: float
    variation: float = 0.0
    omega: float = 0.0
    phase: float = 0.0
    force_record: NormalForceRecord | None = None

    @property
    def can_stick(self) -> bool:
        """Whether a contact under this law can hold still."""
        return True

    def load(self, t: Any) -> Any:
        """Return the normal force relative to its mean [-] at times t [s], 0 where parted."""
        if self.force_record is None:
            found = 1.0 + self.variation * np.sin(self.omega * t + self.phase)
        else:
            times = np.arange(len(self.force_record.relative)) * self.force_record.step
            found = np.interp(t, times, self.force_record.relative)
        return np.maximum(found, 0.0)


@dataclass(frozen=True, eq=False)
class NormalForceRecord:
    """A recorded normal force, linear between its samples; equal to itself alone.

    Attributes
    ----------
    relative : ndarray, shape (n,)
        The force relative to its mean [-]; the first sample is t = 0.
    step : float
        Distance of the samples [s].
    mean : float
        Mean of the samples [N], above 0.
    inputs : tuple of Input
        The file behind it.
    cautions : tuple of Caution
        What a reader of the numbers should know about it.
    clean_up : tuple of mapping
        What was done to it on request, step by step.
    """

    relative: NDArray[np.float64]
    step: float
    mean: float
    inputs: tuple[Input, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    clean_up: tuple[Mapping[str, object], ...] = ()

    @cached_property
    def kernel_input(self) -> Any:
        """The force as the kernels want it."""
        return as_engine_array(self.relative)

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return (len(self.relative) - 1) * self.step


AnyLaw = CoulombLaw | DynamicLaw | ElasticContactLaw | EndStopLaw | NormalForceLaw
"""What a scene may rub with, and run against."""


# The state of a motion, and what it adds up to.


class State(NamedTuple):
    """Relative displacement [m] and velocity [m/s] at one instant."""

    x_r: float
    v_r: float


class ContactState(NamedTuple):
    """A state with what a contact remembers.

    Attributes
    ----------
    x_r, v_r, z : float
        Relative displacement [m] and velocity [m/s], deflection of the bristles [m]; of a
        spring contact the x_r at which it carries no force [m].
    turned : tuple of float
        Deflections at which it turned and to which it returns [m], the oldest first.
    """

    x_r: float
    v_r: float
    z: float
    reversals: tuple[float, ...] = ()


AnyState = State | ContactState
"""Where a motion may start."""


class Totals(NamedTuple):
    """Integrals over a window of time.

    Attributes
    ----------
    x2, v2, x_dd2 : float
        Integrals of x_r² [m²s], v_r² [m²/s] and x_dd² [m²/s³].
    power : float
        Integral of ü v_r [m²/s²]: minus the work of the base per mass.
    rub : float
        Integral of |v_r| times the relative normal force [m].
    stuck : float
        Time without relative motion [s]; 0 under laws that never stick.
    u_dd2 : float
        Integral of ü² [m²/s³].
    u2 : float or None
        Integral of u² [m²s]; None where u is not known.
    hits : float
        Work that the mass did on end stops [J].
    """

    x2: float
    v2: float
    x_dd2: float
    power: float
    sliding_distance: float
    stuck: float
    u_dd2: float
    u2: float | None
    hits: float = 0.0


# The motion of the base.

BLOCK_SIZE = 65_536
"""Numbers worked on at a time: a few megabytes, which stay near the processor."""

MAX_KEPT = 1 << 20
"""Numbers up to which what can be had again is kept: some megabytes. A longer motion is solved
by parts, each made anew whenever it is asked for: that costs a tenth of writing it down."""

HALF_GAUSS_RULE = (
    (0.0694318442029737, 0.1739274225687269),
    (0.3300094782075719, 0.3260725774312731),
)
"""Half of four Gauss-Legendre nodes and weights on 0..1: exact for the square of a cubic."""

STEPS_PER_SUM = 8192
"""Steps whose squares are summed at once: so few that no linear algebra starts threads."""


class Signal(Protocol):
    """Numbers of which any part can be had as an array; arrays are signals."""

    def __len__(self) -> int:
        """Return how many there are."""

    def __getitem__(self, part: slice, /) -> NDArray[np.float64]:
        """Return a part of them."""


class Input(NamedTuple):
    """A file that was read: name in the scenario, SHA-256 (hex) and size [bytes]."""

    file: str
    sha256: str
    size: int


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


class Samples(NamedTuple):
    """Equidistant base acceleration, linear between samples; ends at its last sample.

    Attributes
    ----------
    u_dd : ndarray, shape (n,), or another signal
        Base acceleration [m/s²]; the first sample is t = 0.
    dt : float
        Distance of the samples [s].
    u : ndarray, shape (n,), or None
        Base displacement [m] at the samples where the source knows it; the cubic between two
        samples follows from `u` and `u_dd`. Only T_x needs it.
    inputs : tuple of Input
        The files behind the samples.
    cautions : tuple of Caution
        What a reader of the numbers should know about them.
    realised : mapping
        Of a generated signal: what was asked for and what came out, by name and in SI.
    """

    u_dd: Signal
    dt: float
    u: NDArray[np.float64] | None = None
    inputs: tuple[Input, ...] = ()
    warnings: tuple[WarningMessage, ...] = ()
    realised: Mapping[str, object] = {}


def base_acceleration(sines: Sines, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ü of sines at any times [m/s²], shape of `t` [s]."""
    u_dd = np.zeros_like(t)
    for A, f, phase in zip(*sines, strict=True):
        u_dd += A * np.sin(2.0 * np.pi * ((f * t) % 1.0) + phase)
    return u_dd


def acceleration_at(motion: Sines | Samples, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ü of any base motion at times [s] within it, shape of `t` [m/s²]."""
    if isinstance(motion, Sines):
        return base_acceleration(motion, t)
    n = np.minimum((t / motion.dt).astype(np.intp), len(motion.u_dd) - 2)
    u_dd = motion.u_dd[:]
    q = t / motion.dt - n
    between: NDArray[np.float64] = (1.0 - q) * u_dd[n] + q * u_dd[n + 1]
    return between


def interpolate_displacement(
    motion: Samples, n: NDArray[np.intp], q: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return u [m] at the share q of the steps n: the cubic whose second derivative is ü."""
    assert motion.u is not None, "asked for where u is known only"
    p = 1.0 - q
    u_dd = motion.u_dd[:]
    bend = (p**3 - p) * u_dd[n] + (q**3 - q) * u_dd[n + 1]
    u: NDArray[np.float64] = p * motion.u[n] + q * motion.u[n + 1] + motion.dt**2 / 6.0 * bend
    return u


def integrate_base_squares(
    motion: Samples, begin: float, end: float
) -> tuple[float, float | None]:
    """Return the integrals of ü² and, where u is known, of u² over a window of samples."""
    dt = motion.dt
    first, last = int(begin / dt), min(math.ceil(end / dt), len(motion.u_dd) - 1)
    # Steps that the window cuts are integrated by a rule, the whole ones by their forms.
    lo = first + (first * dt < begin)
    hi = max(last - (last * dt > end), lo)
    u_dd2, u2 = 0.0, 0.0
    for n in sorted({first, last - 1}):
        if lo <= n < hi:
            continue
        part = partial_step_squares(motion, n, begin, end)
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    for at in range(lo, hi, STEPS_PER_SUM):
        part = whole_step_squares(motion, at, min(at + STEPS_PER_SUM, hi))
        u_dd2, u2 = u_dd2 + part[0], u2 + part[1]
    return u_dd2, None if motion.u is None else u2


def partial_step_squares(
    motion: Samples, n: int, begin: float, end: float
) -> tuple[float, float]:
    """Return the integrals of ü² and u² over what of step n lies in a window."""
    dt, u_dd2, u2 = motion.dt, 0.0, 0.0
    lo = max(begin / dt - n, 0.0)
    width = min(end / dt - n, 1.0) - lo
    a_0, a_1 = motion.u_dd[n : n + 2].tolist()
    for node, weight in HALF_GAUSS_RULE:
        for place in (node, 1.0 - node):
            q = lo + width * place
            u_dd2 += weight * dt * width * ((1.0 - q) * a_0 + q * a_1) ** 2
            if motion.u is not None:
                u = interpolate_displacement(motion, np.array([n]), np.array([q]))
                u2 += weight * dt * width * float(u[0]) ** 2
    return u_dd2, u2


def whole_step_squares(motion: Samples, first: int, last: int) -> tuple[float, float]:
    """Return the integrals of ü² and u² over the steps from one sample to another."""
    u_dd, dt = motion.u_dd[first : last + 1], motion.dt
    a_0, a_1 = u_dd[:-1], u_dd[1:]
    own, next_to = np.dot(a_0, a_0), np.dot(a_0, a_1)
    ends = float(u_dd[-1]) ** 2 - float(u_dd[0]) ** 2
    u_dd2 = dt / 3.0 * (2.0 * own + ends + next_to)
    if motion.u is None:
        return float(u_dd2), 0.0
    path = motion.u[first : last + 1]
    x_0, x_1 = path[:-1], path[1:]
    bend = dt * dt / 6.0
    # Integrals of the cubics whose second derivative is ü, of a step of length 1.
    squares = (np.dot(x_0, x_0) + np.dot(x_0, x_1) + np.dot(x_1, x_1)) / 3.0
    bent = (np.dot(x_0, a_0) + np.dot(x_1, a_1)) * 4.0 / 15.0
    bent += (np.dot(x_0, a_1) + np.dot(x_1, a_0)) * 7.0 / 30.0
    bends = (2.0 * own + ends) * 8.0 / 105.0 + next_to * 31.0 / 210.0
    return float(u_dd2), float(dt * (squares - bend * bent + bend * bend * bends))


def blocks(signal: Signal, size: int = BLOCK_SIZE) -> Iterator[NDArray[np.float64]]:
    """Return a signal block by block."""
    return (signal[at : at + size] for at in range(0, len(signal), size))


def mean_and_std(signal: Signal) -> tuple[float, float]:
    """Return the mean of a signal and its RMS about that mean."""
    mean = sum(float(part.sum()) for part in blocks(signal)) / len(signal)
    squares = sum(float(np.square(part - mean).sum()) for part in blocks(signal))
    return mean, math.sqrt(squares / len(signal))


def max_abs(signal: Signal) -> float:
    """Return the greatest magnitude in a signal."""
    return max((float(np.abs(part).max()) for part in blocks(signal)), default=0.0)
