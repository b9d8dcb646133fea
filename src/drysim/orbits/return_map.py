"""Return map of a scene along a parameter, for the continuation of periodic orbits.

Problem
    `continuation` needs the state after a repetition and its derivative with respect to the
    state before.

Method
    Shooting: the motion is marched as by every other command (`search.march_period`). A
    law in closed form has its derivative, too, by the variational equation
    (`drysim.core.variational`); one kernel marches and differentiates Coulomb friction. The
    derivative of a dynamic law is taken by central differences with two step sizes, which are
    made smaller where they disagree; their difference estimates the error (Richardson
    extrapolation).

State
    x_r and v_r; with an elastic contact or with bristles a third component, their deflection.
    Beyond the limit of an elastic contact the deflection is clipped, and so is a displacement
    beyond a rigid stop.

An elastic contact that never yields
    It keeps its anchor for ever, so that its orbits are a continuum with a multiplier of 1. The
    one about the anchor 0, as from rest, stands for all; that multiplier is left out.

References: R. Seydel, Practical Bifurcation and Stability Analysis (2010), chapter 7.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.approach import taylor
from drysim.approach.piecewise import PiecewiseTrajectory
from drysim.approach.solution import Trajectory, keeps_anchor
from drysim.approach.taylor import TaylorTrajectory
from drysim.core.events import CONTACT, IMPACT, REVERSAL, SLIP, STICK
from drysim.core.model import (
    BRISTLE,
    AnyLaw,
    AnyState,
    ContactState,
    CoulombLaw,
    DynamicLaw,
    Floats,
    PiecewiseLaw,
    Plant,
    Sines,
    State,
    has_friction,
)
from drysim.errors import SolverError
from drysim.orbits.continuation import Image, Repetition
from drysim.orbits.coulomb import CoulombFlow, scene_row
from drysim.orbits.search import (
    CLOSURE_TOLERANCE,
    find_orbit,
    march_period,
)

FIRST_DIFFERENCE, SMALLEST_DIFFERENCE = 1e-4, 1e-7
"""Scaled differences of the state for the derivative of the return map. The first leaves an
error of its fourth power, 1e-16, after extrapolation; with the last, the error of the march,
1e-12, still leaves five digits."""

DIFFERENCE_RATIO = 0.1
"""Ratio of successive differences where two step sizes disagree: four are tried at most."""

JACOBIAN_TOLERANCE = 1e-7
"""Disagreement of two step sizes up to which a difference is not made smaller. The error after
extrapolation is a small part of it, and Newton's method gains seven digits a step with it."""

START_SIZES, START_ANGLES = (0.3, 1.0, 2.0), 4
"""Starts besides rest from which motions are sought: amplitudes, as multiples of the motion
without friction and end stops, and phases."""

LARGEST_START = 20.0
"""Largest such amplitude, as a multiple of the static deflection under m A: beside resonance
with little damping, where friction keeps every motion smaller."""


class PeriodicSystem(NamedTuple):
    """Oscillator under periodic excitation, whose period is in seconds."""

    plant: Plant
    law: AnyLaw
    motion: Sines
    period: float

    @property
    def is_symmetric(self) -> bool:
        """Whether half a period and a change of sign leave the equation of motion as it is."""
        law = self.law
        if law.is_directed or law.force_record is not None:
            return False
        if law.stops is not None and law.stops.limits.up != law.stops.limits.down:
            return False
        sine_turns = all(round(f * self.period) % 2 == 1 for f in self.motion.f)
        if isinstance(law, DynamicLaw) or law.variation == 0.0:
            return sine_turns
        return sine_turns and round(law.omega * self.period / math.tau) % 2 == 0

    def delayed(self, periods: float) -> PeriodicSystem:
        """Return the scene in which t = 0 is later by so many periods."""
        (A, f, phase), law, period = self.motion, self.law, self.period
        phases = tuple(
            angle + self.phase_after(frequency, periods)
            for frequency, angle in zip(f, phase, strict=True)
        )
        if not isinstance(law, DynamicLaw) and law.variation:
            after = self.phase_after(law.omega / math.tau, periods)
            law = law._replace(phase=law.phase + after)
        return PeriodicSystem(self.plant, law, Sines(A, f, phases), period)

    def phase_after(self, frequency: float, periods: float) -> float:
        """Return the phase of a harmonic of the excitation after some periods [rad]."""
        return math.tau * (round(frequency * self.period) * periods % 1.0)

    @classmethod
    def from_row(cls, row: Floats) -> PeriodicSystem:
        """Return the scene of a row of `coulomb.scene_row`."""
        m, k_x, b, *columns = row.tolist()
        law, period, sines = CoulombLaw(*columns[:5]), columns[7], columns[10:]
        A, f, phase = tuple(sines[::3]), tuple(sines[1::3]), tuple(sines[2::3])
        return cls(Plant(m, k_x, b), law, Sines(A, f, phase), period)

    @property
    def has_one_motion(self) -> bool:
        """Whether two motions never move apart, so that all approach the same one.

        So it is where the force of the contact is a monotone function of the velocity, or of
        its history, and the spring is linear.
        """
        law = self.law
        if isinstance(law, DynamicLaw) or law.stops is not None:
            return False
        equal = law.compression is None or law.compression[0] == law.compression[1]
        return law.F_fs == law.F_fk and equal and not (law.is_elastic and law.variation)

    @property
    def starts(self) -> list[State]:
        """Starts from which different motions may be reached, rest first."""
        rest = State(0.0, 0.0)
        if self.has_one_motion:
            return [rest]
        (m, k_x, b), omega = self.plant, math.tau / self.period
        force = m * max(self.motion.A)
        stiffness = abs(complex(k_x - m * omega**2, b * omega))
        size = force / max(stiffness, k_x / LARGEST_START, 1e-300)
        angles = math.tau * (np.arange(START_ANGLES) + 0.5) / START_ANGLES
        around = [
            State(
                self.inside(share * size * math.cos(angle)),
                share * size * omega * math.sin(angle),
            )
            for share in START_SIZES
            for angle in angles.tolist()
        ]
        return [rest, *around]

    def inside(self, x_r: float) -> float:
        """Return a displacement [m], at a rigid stop if it is beyond it."""
        stops = self.law.stops
        if stops is None or not stops.rigid:
            return x_r
        return min(max(x_r, -stops.limits.down), stops.limits.up)

    @property
    def deflection(self) -> float:
        """Scale of the third state component [m]: deflection at the limit; 0 without one."""
        law = self.law
        if isinstance(law, DynamicLaw):
            return law.F_fk / law.sigma_0 if law.kind == BRISTLE else 0.0
        return law.F_fk / law.k_t if isinstance(law, PiecewiseLaw) and law.k_t else 0.0

    def to_state(self, y: Floats) -> AnyState:
        """Return the state of a march from its components."""
        x_r, v_r, *rest = y.tolist()
        if not rest:
            return State(x_r, v_r)
        (q,) = rest
        return ContactState(x_r, v_r, x_r - q if self.law.is_elastic else q)

    def to_components(self, state: AnyState) -> Floats:
        """Return the components of a state: x_r [m], v_r [m/s] and a deflection [m]."""
        x_r, v_r = state[:2]
        if self.deflection == 0.0:
            return np.array([x_r, v_r])
        z = state[2] if isinstance(state, ContactState) else 0.0
        return np.array([x_r, v_r, x_r - z if self.law.is_elastic else z])

    def clip(self, y: Floats) -> Floats:
        """Return the state that a march begins with: none is beyond a limit."""
        clipped = y.copy()
        clipped[0] = self.inside(float(y[0]))
        law = self.law
        if isinstance(law, PiecewiseLaw) and law.is_elastic:
            limit = self.deflection * float(law.load(0.0))
            clipped[2] = min(max(float(y[2]), -limit), limit)
        return clipped


class MarchedOrbit(NamedTuple):
    """Periodic orbit reached from a start.

    Attributes
    ----------
    state : ndarray, shape (n,)
        State at the beginning of the repetition.
    peak : float
        Largest |x_r| [m].
    periods : int
        Periods of the excitation per repetition.
    is_stuck : bool
        Whether the mass sticks all the time.
    """

    state: Floats
    peak: float
    periods: int
    is_stuck: bool


class ShootingReturnMap:
    """Return map of a scene that is marched, for `continuation`.

    Parameters
    ----------
    scene : callable
        Returns the scene at p, from 0 to 1, or None where there is none.
    """

    def __init__(self, scene: Callable[[float], PeriodicSystem | None]) -> None:
        # A correction asks for few values of p again and again: at a point and beside it.
        self.scene, self.coulomb_flow = lru_cache(maxsize=8)(scene), CoulombFlow()

    def speed(self, p: float) -> float:
        """Return the scale of v_r/x_r [1/s]."""
        scene = self.scene(p)
        return 1.0 if scene is None else math.tau / scene.period

    def scene_from(self, p: float, repetition: Repetition) -> PeriodicSystem | None:
        """Return the scene whose t = 0 is the beginning of a repetition.

        Dynamic laws have the smallest tolerance: differences need more digits than a run.
        """
        scene = self.scene(p)
        if scene is None:
            return None
        law = scene.law
        if isinstance(law, DynamicLaw):
            law = law._replace(tolerance=min(law.tolerance, CLOSURE_TOLERANCE))
        return scene._replace(law=law).delayed(repetition.begin)

    def __call__(self, p: float, state: Floats, repetition: Repetition) -> Image | None:
        """Return the image of a state; None where the motion cannot be solved."""
        scene = self.scene_from(p, repetition)
        if scene is None:
            return None
        if isinstance(scene.law, CoulombLaw):
            return self.coulomb_image(scene, scene.law, state, repetition)
        try:
            end, trajectory = self.march(scene, state, repetition)
        except SolverError:
            return None
        peak = float(np.abs(path_of(trajectory)).max())
        counts = event_counts(scene.law, trajectory)
        events = trajectory.events.t[1:] / scene.period
        if not isinstance(scene.law, DynamicLaw):
            jacobian = closed_form_jacobian(trajectory, repetition)
            grazes = not np.isfinite(jacobian).all()
            return None if grazes else Image(end, lambda: (jacobian, 0.0), counts, events, peak)
        derive = partial(self.differentiate, scene, state, repetition, peak)
        return Image(end, derive, counts, events, peak)

    def coulomb_image(
        self, scene: PeriodicSystem, law: CoulombLaw, state: Floats, repetition: Repetition
    ) -> Image | None:
        """Return the image of a state under Coulomb friction; None as for the map."""
        plant, _, motion, period = scene
        row = scene_row(plant, law, motion, State(0.0, 0.0), period)
        flow = self.coulomb_flow(row, repetition.length * period, state)
        if flow is None:
            return None
        (x, v, a, b, c, e, stops, reversals, peak, _), events = flow
        sign = -1.0 if repetition.half else 1.0
        jacobian, counts = sign * np.array([[a, b], [c, e]]), (int(stops), int(reversals), 0)
        end = sign * np.array([x, v])
        return Image(end, lambda: (jacobian, 0.0), counts, events / period, peak)

    def states(
        self, p: float, state: Floats, repetition: Repetition, times: Floats
    ) -> Floats | None:
        """Return states at increasing times since the beginning, shape (times, n), or None."""
        scene = self.scene_from(p, repetition)
        if scene is None:
            return None
        try:
            trajectory = self.march_for(scene, state, max(float(times[-1]), 1.0))
        except SolverError:
            return None
        along = [trajectory.state(time * scene.period) for time in times.tolist()]
        components = np.array([scene.to_components(state) for state in along])
        if scene.law.is_elastic and not yields(trajectory):
            components[:, 2] = components[:, 0]
        return components if np.isfinite(components).all() else None

    def march(
        self, scene: PeriodicSystem, y: Floats, repetition: Repetition
    ) -> tuple[Floats, PiecewiseTrajectory | TaylorTrajectory]:
        """Return the state after a repetition, and the motion up to it; `scene` begins with it.

        Raises
        ------
        SolverError
            If events do not advance in time, or the motion is not finite.
        """
        trajectory = self.march_for(scene, y, repetition.length)
        end = scene.to_components(trajectory.state(trajectory.end))
        if not np.isfinite(end).all():
            raise SolverError("the motion is not finite", "")
        if scene.law.is_elastic and not yields(trajectory):
            end[2] = end[0]
        return (-end if repetition.half else end), trajectory

    def march_for(
        self, scene: PeriodicSystem, y: Floats, time: float
    ) -> PiecewiseTrajectory | TaylorTrajectory:
        """Return the motion from a state for a time in periods."""
        plant, law, motion, period = scene
        return march_period(plant, law, motion, scene.to_state(scene.clip(y)), time * period)

    def scale(self, scene: PeriodicSystem, peak: float) -> Floats:
        """Return the scale of each state component, shape (n,)."""
        omega = math.tau / scene.period
        size = peak or max(scene.motion.A) / omega**2
        sizes = [size, size * omega]
        return np.array(sizes + [scene.deflection] * (scene.deflection > 0.0))

    def differentiate(
        self, scene: PeriodicSystem, y: Floats, repetition: Repetition, peak: float
    ) -> tuple[Floats, float]:
        """Return the Jacobian of the return map of a dynamic law, and its estimated error.

        The error is that of the scaled Jacobian, relative to its largest element if that is
        above 1 [-].
        """
        scale = self.scale(scene, peak)
        n = len(y)
        jacobian, worst = np.empty((n, n)), 0.0
        for j in range(n):
            jacobian[:, j], error = self.column(scene, y, repetition, j, scale)
            worst = max(worst, error)
        largest = float(np.abs(jacobian * scale / scale[:, None]).max())
        return jacobian, worst / max(1.0, largest)

    def column(
        self, scene: PeriodicSystem, y: Floats, repetition: Repetition, j: int, scale: Floats
    ) -> tuple[Floats, float]:
        """Return a column of the Jacobian, and its estimated error when scaled [-].

        Two central differences, the second with half the step, are extrapolated; the step is
        made smaller where they disagree.
        """

        def slope(step: float) -> Floats:
            sides = []
            for sign in (1.0, -1.0):
                beside = y.copy()
                beside[j] += sign * step * scale[j]
                beside = scene.clip(beside)
                sides.append((beside[j], self.march(scene, beside, repetition)[0]))
            (high, above), (low, below) = sides
            if high == low:
                return np.zeros(len(y))
            return np.asarray((above - below) / (high - low))

        best, least = np.full(len(y), np.nan), math.inf
        step = FIRST_DIFFERENCE
        while step >= SMALLEST_DIFFERENCE * (1.0 - 1e-9) and least > JACOBIAN_TOLERANCE:
            try:
                coarse, fine = slope(step), slope(0.5 * step)
            except SolverError:
                step *= DIFFERENCE_RATIO
                continue
            change = (fine - coarse) / 3.0
            error = float(np.abs(change * scale[j] / scale).max())
            if error < least:
                best, least = fine + change, error
            step *= DIFFERENCE_RATIO
        return best, least

    def march_error(self, p: float, y: Floats, image: Image, repetition: Repetition) -> float:
        """Return the scaled error of the march over a repetition.

        It is rounding in closed form. A march by series estimates it by a second one with a
        larger tolerance, as `taylor.solve` does.
        """
        scene = self.scene_from(p, repetition)
        assert scene is not None, "an orbit has a scene"
        if not isinstance(scene.law, DynamicLaw):
            return 0.0
        coarse = scene._replace(law=taylor.coarsened_law(scene.law))
        off = np.abs(self.march(coarse, y, repetition)[0] - image.state)
        return float((off / self.scale(scene, image.peak)).max())

    def orbit(self, p: float, start: State) -> MarchedOrbit | None:
        """Return the periodic orbit that a start leads to; None if it does not settle."""
        scene = self.scene(p)
        if scene is None:
            return None
        plant, law, motion, period = scene
        try:
            orbit = find_orbit(plant, law, motion, start, period)
            if not (orbit.settled and orbit.unique):
                return None
            y = scene.to_components(orbit.state)
            whole = Repetition(orbit.periods)
            _, trajectory = self.march(scene, y, whole)
            if law.is_elastic and not yields(trajectory):
                # The same motion about the anchor 0.
                k_t = scene.law.F_fk / scene.deflection
                y[0] -= k_t * (y[0] - y[2]) / (plant.k_x + k_t)
                y[2] = y[0]
                _, trajectory = self.march(scene, y, whole)
        except SolverError:
            return None
        path = path_of(trajectory)
        is_stuck = law.can_stick and float(np.ptp(path)) == 0.0
        return MarchedOrbit(y, float(np.abs(path).max()), orbit.periods, is_stuck)

    def sticks(self, p: float) -> bool:
        """Whether a mass at rest sticks for ever."""
        scene = self.scene(p)
        if scene is None or not scene.law.can_stick:
            return False
        rest = np.zeros(2)
        return not path_of(self.march(scene, rest, Repetition())[1]).any()


def closed_form_jacobian(trajectory: Trajectory, repetition: Repetition) -> Floats:
    """Return the derivative of the components at the end by those at the start."""
    jacobian = trajectory.monodromy()
    if len(jacobian) == 3:
        if keeps_anchor(jacobian):
            jacobian[2] = 0.0
        # From the anchor of an elastic contact to its deflection, and back.
        deflection = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, -1.0]])
        jacobian = deflection @ jacobian @ deflection
    return -jacobian if repetition.half else jacobian


def path_of(trajectory: Trajectory) -> Floats:
    """Return x_r at the turning points and at the ends of a motion [m]."""
    return np.append(trajectory.path.x_r, trajectory.state(trajectory.end).x_r)


def event_kinds(trajectory: Trajectory) -> NDArray[np.int8]:
    """Return the kinds of the events after the start, without their directions."""
    return np.abs(trajectory.events.kind[1:])


def yields(trajectory: Trajectory) -> bool:
    """Whether an elastic contact yields within a motion, or throughout it."""
    starts_yielding = abs(int(trajectory.events.kind[0])) == SLIP
    return starts_yielding or bool(np.isin(event_kinds(trajectory), (STICK, SLIP)).any())


def event_counts(law: AnyLaw, trajectory: Trajectory) -> tuple[int, ...]:
    """Return stops, reversals and contacts with an end stop.

    Only what changes the equation of motion counts: not the turning points of bristles, nor
    those without friction.
    """
    kinds = event_kinds(trajectory)
    stops = reversals = 0
    if has_friction(law) and not (isinstance(law, DynamicLaw) and not law.can_stick):
        stops = int((kinds == STICK).sum())
        reversals = 0 if law.is_elastic else int((kinds == REVERSAL).sum())
    return stops, reversals, int(np.isin(kinds, (CONTACT, IMPACT)).sum())
