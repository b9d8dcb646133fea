"""Branches of periodic orbits along a parameter, through folds, with their bifurcations.

Problem
    A periodic orbit is a fixed point of a return map: the state after a repetition as a
    function of the state before it. As a parameter varies, the fixed points form curves
    (branches). They turn back at folds and have unstable parts, which no march in time reaches.

Method
    Pseudo-arclength continuation: the predictor goes along the tangent, the corrector is
    Newton's method in the plane normal to it (Keller 1977). The maps march the motion itself
    and find all events, so a branch passes from sliding to sticking without declared sequences
    of events. Orbits that are symmetric, x_r(t + n T/2) = -x_r(t) with an odd number n of
    periods T, are fixed points of the negative half map, in which folds and symmetry breaking
    are different eigenvalues (+1 and -1).

Section
    The states are taken at one phase of the excitation, the Poincaré section. In a stick it
    would be degenerate: v_r is zero, x_r is free only as far as the slip before it decides, and
    a stop that moves across the section makes a corner in the branch. Every orbit that is not
    stuck for ever has a slip in each period. There the state determines the motion before and
    after it, and the map is smooth. The section is therefore placed in a slip, where speed and
    time to the nearest event are large, and is placed again when events come near. Multipliers,
    bifurcations and event counts do not depend on it.

Bifurcations
    Zeros of test functions along a branch, by Brent's method: the parameter component of the
    tangent (fold), det(J + I) (symmetry breaking of the half map; period doubling of others),
    and the number of stops and reversals (grazing). Where an event is born or lost the
    derivative of the map jumps: the branch has a corner, beyond which it goes on in the
    direction that the derivative there gives (border collision). With F_fs > F_fk the map
    itself jumps where the motion grazes v_r = 0 or F_fs, and a branch may end there.

References: H. B. Keller, in Applications of Bifurcation Theory (1977); Yu. A. Kuznetsov,
Elements of Applied Bifurcation Theory (2004), chapter 10; R. I. Leine and H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.core.model import Floats

FOLD, SYMMETRY_BREAKING, PERIOD_DOUBLING, GRAZING, CONTINUUM = (
    "fold",
    "symmetry breaking",
    "period doubling",
    "grazing",
    "continuum",
)
"""Kinds of bifurcation."""

RANGE, LOOP, MERGED, LIMIT = "range", "loop", "merged", "limit"
"""Ends of a branch: at the end of the range, none as it is closed, where it meets another one,
and where it could not be followed further."""


LOST, MANY_POINTS, MANY_PERIODS, MANY_BRANCHES, NOT_SWITCHED, NOT_ISOLATED = (
    "lost",
    "many points",
    "many periods",
    "many branches",
    "not switched",
    "not isolated",
)
"""Reasons of a gap: a branch could not be followed further, or has too many points; a branch
that leaves a bifurcation has too many periods, or was not found; there are too many branches;
an orbit that was reached is no fixed point of the return map to within rounding."""


class Repetition(NamedTuple):
    """Repetition whose image is compared with its start.

    Attributes
    ----------
    periods : int
        Periods of the excitation.
    half : bool
        Whether it is half of them, of an odd number, and the image has the opposite sign.
    begin : float
        Time at which it begins, the section, in periods since an upward zero crossing of the
        base acceleration.
    """

    periods: int = 1
    half: bool = False
    begin: float = 0.0

    @property
    def length(self) -> float:
        """Length in periods of the excitation."""
        return 0.5 * self.periods if self.half else float(self.periods)

    @property
    def doubled(self) -> Repetition:
        """The repetition after which the motion repeats beyond a bifurcation at -1."""
        if self.half:
            return self._replace(half=False)
        return self._replace(periods=2 * self.periods)

    @property
    def halved(self) -> Repetition | None:
        """The repetition of which this one is the double; None of the shortest."""
        if self.half:
            return None
        if self.periods % 2 == 1:
            return self._replace(half=True)
        return self._replace(periods=self.periods // 2)

    def delayed(self, time: float) -> Repetition:
        """The repetition that begins later by some time, in periods of the excitation."""
        return self._replace(begin=(self.begin + time) % self.periods)


@dataclass(frozen=True, eq=False)
class Image:
    """State after a repetition.

    Attributes
    ----------
    state : ndarray, shape (n,)
        x_r [m], v_r [m/s] and, if a law has them, further states.
    differentiate : callable
        Returns its derivative with respect to the state before, shape (n, n), and the estimated
        error of that when scaled [-].
    counts : tuple of int
        Stops, immediate reversals, and contacts with an end stop.
    events : ndarray, shape (k,)
        Times of all events since the beginning, in periods of the excitation.
    peak : float
        Largest |x_r| at an event or an end [m].
    """

    state: Floats
    differentiate: Callable[[], tuple[Floats, float]]
    counts: tuple[int, ...]
    events: Floats
    peak: float

    @cached_property
    def derivative(self) -> tuple[Floats, float]:
        """Jacobian and its error, computed on first access."""
        return self.differentiate()

    @property
    def jacobian(self) -> Floats:
        """Derivative with respect to the state before, shape (n, n)."""
        return self.derivative[0]

    @property
    def jacobian_error(self) -> float:
        """Estimated error of the Jacobian when scaled [-]."""
        return self.derivative[1]


class ReturnMap(Protocol):
    """Motion of a scene with a parameter p, which is 0 to 1 over its range."""

    def __call__(self, p: float, state: Floats, repetition: Repetition) -> Image | None:
        """Return the image of a state; None where the motion cannot be solved."""

    def states(
        self, p: float, state: Floats, repetition: Repetition, times: Floats
    ) -> Floats | None:
        """Return states at increasing times since the beginning, shape (times, n), or None.

        Times are in periods of the excitation.
        """

    def speed(self, p: float) -> float:
        """Return the scale of v_r/x_r [1/s]."""


class Point(NamedTuple):
    """Fixed point on a branch.

    Attributes
    ----------
    p : float
        Parameter, from 0 to 1 over its range.
    state : ndarray, shape (n,)
        State at the section.
    repetition : Repetition
        With the section.
    image : Image
    tangent : ndarray, shape (n + 1,)
        Scaled unit tangent of the branch; the last component is that of p.
    """

    p: float
    state: Floats
    repetition: Repetition
    image: Image
    tangent: Floats

    @property
    def coordinates(self) -> Floats:
        """State and p, shape (n + 1,)."""
        return np.append(self.state, self.p)

    @property
    def reversed(self) -> Point:
        """The point with the opposite tangent."""
        return self._replace(tangent=-self.tangent)

    def along(self, direction: Floats) -> Point:
        """The point with the tangent in the sense of a scaled direction."""
        return self.reversed if float(self.tangent @ direction) < 0.0 else self

    def is_same_state(self, other: Point) -> bool:
        """Whether another point is at the same p and has the same state."""
        return self.p == other.p and np.array_equal(self.state, other.state)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the Jacobian of the return map."""
        return np.linalg.eigvals(self.image.jacobian).astype(np.complex128)


class Bifurcation(NamedTuple):
    """Bifurcation on a branch.

    Attributes
    ----------
    kind : str
    point : Point
    position : int
        Index of the point among those of the branch. An end with an infinite multiplier is
        extrapolated: the index is that of the last point. Along one direction, while it is
        followed, the index of the point before it.
    """

    kind: str
    point: Point
    position: int


class Gap(NamedTuple):
    """What is missing among the branches: why, and where.

    Attributes
    ----------
    reason : str
    p : float
    """

    reason: str
    p: float


@dataclass
class Branch:
    """Branch of periodic orbits.

    Attributes
    ----------
    repetition : Repetition
    points : list of Point
        In order along the branch.
    bifurcations : list of Bifurcation
    ends : tuple of str
        Why it ends on either side: "range", "loop", "merged", "grazing" or "limit".
    gaps : list of Gap
        Where it could not be followed further.
    """

    repetition: Repetition
    points: list[Point]
    bifurcations: list[Bifurcation] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")
    gaps: list[Gap] = field(default_factory=list)


MAX_NEWTON_STEPS = 25
"""Newton steps of one correction. Of 1,580 along eight branches none took more than six. Across
a corner the steps are halved: 25 halvings of the longest step end below
`STAGNATION_TOLERANCE`."""

NEWTON_TOLERANCE = 1e-12
"""Scaled Newton step at which the iteration has converged. It converges quadratically, so that
only rounding is left: half of 1,580 residuals were below 5e-16, all but one in a hundred below
3e-13."""

STAGNATION_TOLERANCE = 1e-9
"""Scaled step accepted when it no longer decreases. Near a bifurcation the matrix is nearly
singular and magnifies rounding, 1e-15, up to a million times."""

MAX_CORRECTION = 10.0
"""Scaled Newton step beyond which there is no fixed point nearby: ten peaks, or ten ranges."""

DIFFERENCE = 1e-7
"""Difference of p for the derivative with respect to it. Rounding leaves it eight digits; only
the speed of convergence depends on its accuracy."""

CORNER_DIFFERENCES = (1.0, -1.0, 1e-2, -1e-2, 1e-4, -1e-4)
"""Differences that are tried until one stays on this side of a corner, in units of
`DIFFERENCE`. The last ones leave four digits, enough to converge."""

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 2e-3, 2e-2, 1e-10
"""Arclength of steps, scaled: displacements by the peak, p by its range. Fifty steps at least
cross the range, so that a test function hardly changes its sign twice within one; a tenth of
that to begin with, where nothing is known of the curvature; and a hundred times
`NEWTON_TOLERANCE`, below which rounding turns the tangent."""

FEW_NEWTON_STEPS = 4
"""Newton steps up to which the next step along the branch is longer: all but 7 of 1,580
corrections took no more. A correction that takes more is at a sharp fold or at a corner."""

STEP_RATIOS = (0.3, 3.0)
"""Least and greatest length of a step after its correction, as a share of that before. Of
1,261 steps 98 % keep 0.56 to 1.001; one that keeps less or more ends on another branch."""

MIN_COSINE, MIN_CORNER_COSINE = 0.95, 0.5
"""Smallest cosine of the angle between a step and the tangents at its ends. A smooth branch
turns less: 99 % of 1,261 steps are above 0.999. With steps below `CORNER_STEP` a turn of up to
60 degrees is a corner; sharper ones are passed by `Continuation.beyond_corner`."""

CORNER_STEP = 1e-7
"""Step below which a turn is a corner and not a jump to another branch: those are farther away,
by `SAME_ORBIT` at least."""

CORNER_SIZES = (1e-8, 1e-7, 1e-6)
"""Scaled distances ahead at which the derivative beyond a corner is taken. Steps towards it
have shrunk to `SMALLEST_STEP`: the first is a hundred times that, and larger ones serve where
rounding of the events still decides."""

SMALL_SHARE = 1e-2
"""Share of the offset before a step to which it may fall. It is 0 on the branch that this one
left, and -1 on its own mirrored half. A step that ends beside the bifurcation between them is
halved until it keeps more."""

MAX_POINTS, MAX_PERIODS = 4000, 16
"""Most points of a branch: of `LARGEST_STEP`, eighty ranges. Most periods per repetition: four
period doublings, the fifth follows within a 500th (4.669⁻⁴) of the first interval."""

SECTIONS = 16
"""Phases within a period, or half of it, among which the section is chosen. Only a slip shorter
than a sixteenth may fall between all of them; the section then stays where it was."""

SECTION_LOSS = 0.25
"""Share of the quality of a section, when placed, below which it is placed again, at the cost
of two corrections: seldom, and long before an event reaches it."""

SAME_ORBIT = 1e-6
"""Scaled distance below which two orbits at one parameter are the same: far above residuals.
Different ones come so close at a fold only, where their distance is the root of that in p:
within 1e-12 of it."""

SAME_PLACE = 1e-4
"""Distance in p, and scaled distance of states, below which two bifurcations are the same. They
are points of two branches, each located along steps that end beside the other branch; a 200th
of the longest step tells them from the next one."""

SWITCH_OFFSETS = (1e-2, 3e-3, 3e-2)
"""Scaled distances from a bifurcation at which the branch that leaves it is sought. Its p
departs by their square, 1e-4, far above rounding; the others are for branches that turn before,
or hardly depart."""

MAX_SWITCH_RATIO = 10.0
"""Largest ratio of the distance of an orbit found so to that offset: farther is another one."""

LARGEST_MULTIPLIER = 1e3
"""Multiplier beyond which a branch is at its end: a break-away or a stop is about to vanish.
Parameter and state are smooth functions of its inverse, so that a thousandth is left, which
`extrapolate_end` passes."""

RUNAWAY_SHARE = 0.1
"""Share of `LARGEST_MULTIPLIER` above which a multiplier runs away where no point follows.
Multipliers of orbits that do not end are of the order of 1."""

TOUCHING = 1e-6
"""Size of det(J + I), relative to its neighbours, at which an eigenvalue touches -1: that of a
parabola within 1e-3 of a step from its vertex, which `slope` locates far better."""

SHALLOW_SHARE = 0.1
"""Height of the vertex of det(J + I), relative to its neighbours, up to which it is looked at
more closely: the parabola through three points errs by less where these are close."""

ZERO_SHARE = 1e-3
"""Size of det(J + I) at its zero, as a share of that at the ends of the step: if it is larger,
the determinant jumps across zero."""

LOCATION_TOLERANCE = 1e-13
"""Tolerance of the position of a bifurcation on the chord of a step: as a share of p, at most
2e-15 of the range, rounding."""

CONTINUUM_WIDTH = 1e-10
"""Change of p below which the branch that leaves a bifurcation exists at one parameter only.
`SWITCH_OFFSETS` change it by 1e-5 to 1e-3 else; a correction determines it to a hundredth of
this width."""


def extrapolate_end(points: Sequence[Point]) -> Point:
    """Return the end of a branch at which a multiplier becomes infinite.

    Parameter and state are smooth functions of its inverse, which goes to zero.
    """
    last = points[-1]
    near = [point for point in points[-3:] if point.repetition == last.repetition]
    inverse = [1.0 / float(np.abs(point.multipliers).max()) for point in near]
    if len(set(inverse)) < len(near):
        return last
    p, state = 0.0, np.zeros(len(last.state))
    for i, point in enumerate(near):
        # Lagrange's polynomial at zero.
        weight = math.prod(
            other / (other - inverse[i]) for j, other in enumerate(inverse) if j != i
        )
        p, state = p + weight * point.p, state + weight * point.state
    return last._replace(p=p, state=state)


def has_large_multiplier(point: Point) -> bool:
    """Whether a multiplier runs away, as it does shortly before a break-away vanishes."""
    return float(np.abs(point.multipliers).max()) > RUNAWAY_SHARE * LARGEST_MULTIPLIER


def keeps_sense(before: Point, after: Point) -> bool:
    """Whether the tangents of two points on either side of a corner run along the branch.

    The sign of det(J - I) times the component of p does not change along a branch, unless
    another branch crosses it; without a corner both factors change at a fold.
    """
    signs = [
        math.copysign(1.0, float(point.tangent[-1]))
        * math.copysign(1.0, float(np.linalg.det(jacobian - np.eye(len(jacobian)))))
        for point, jacobian in ((before, before.image.jacobian), (after, after.image.jacobian))
    ]
    return signs[0] == signs[1]


class Continuation:
    """Continuation of the fixed points of a return map.

    Parameters
    ----------
    return_map : ReturnMap
    symmetric : bool
        Whether half a period and a change of sign leave the equation of motion as it is.
    limits : tuple of float, optional
        Values of p between which branches are followed. They are cut to 0 to 1 afterwards, so
        that parts which meet beyond these are found.
    max_points : int, optional
        Most points of a branch.
    """

    def __init__(
        self,
        return_map: ReturnMap,
        symmetric: bool,
        limits: tuple[float, float] = (0.0, 1.0),
        max_points: int = MAX_POINTS,
    ) -> None:
        self.return_map, self.symmetric = return_map, symmetric
        self.limits, self.max_points = limits, max_points

    def scale(self, p: float, peak: float, n: int) -> Floats:
        """Return the scale of each state component and of p, shape (n + 1,)."""
        size = peak or 1.0
        return np.array([size, size * self.return_map.speed(p), *[size] * (n - 2), 1.0])

    def scale_at(self, point: Point) -> Floats:
        """Return the scale of the coordinates at a point, shape (n + 1,)."""
        return self.scale(point.p, point.image.peak, len(point.state))

    # The section

    def best_delay(
        self, p: float, state: Floats, repetition: Repetition, image: Image
    ) -> float:
        """Return the time from a state of an orbit to its best section, in periods."""
        times = np.linspace(0.0, min(repetition.length, 1.0), SECTIONS, endpoint=False)
        states = self.return_map.states(p, state, repetition, times)
        if states is None:
            return 0.0
        clear = [time_to_event(time, repetition, image) for time in times.tolist()]
        return float(times[np.argmax(np.abs(states[:, 1]) * clear)])

    def section_quality(self, point: Point) -> float:
        """Return speed times time to the nearest event at the section of a point, scaled."""
        clear = time_to_event(0.0, point.repetition, point.image)
        return abs(float(point.state[1])) / float(self.scale_at(point)[1]) * clear

    def delayed(self, point: Point, time: float) -> Point:
        """Return the same orbit at a later section; the point as it is where that fails.

        Parameters
        ----------
        point : Point
        time : float
            In periods of the excitation.
        """
        if time == 0.0:
            return point
        scale = self.scale_at(point)
        p = point.p + DIFFERENCE * float(point.tangent[-1])
        h = DIFFERENCE if self.is_within(p) else -DIFFERENCE
        shifted = []
        for y in (point.coordinates, point.coordinates + h * point.tangent * scale):
            states = self.return_map.states(
                float(y[-1]), y[:-1], point.repetition, np.array([time])
            )
            if states is None:
                return point
            shifted.append(np.append(states[0], y[-1]))
        direction = (shifted[1] - shifted[0]) / (h * scale)
        direction /= np.linalg.norm(direction)
        repetition = point.repetition.delayed(time)
        moved = self.corrector(shifted[0] / scale, direction, scale, repetition)
        return point if moved is None else moved[0].along(direction)

    def placed(self, point: Point) -> Point:
        """Return an orbit at its best section."""
        return self.delayed(
            point, self.best_delay(point.p, point.state, point.repetition, point.image)
        )

    def at_section_of(self, point: Point, other: Point) -> Point:
        """Return an orbit at the section of another one on its branch."""
        period = other.repetition.periods
        return self.delayed(point, (other.repetition.begin - point.repetition.begin) % period)

    # Fixed points

    def residual(self, point: Point) -> float:
        """Return the scaled change of the state over a repetition of a fixed point."""
        change = np.abs(point.image.state - point.state) / self.scale_at(point)[:-1]
        return float(change.max())

    def corrector(
        self, guess: Floats, normal: Floats, scale: Floats, repetition: Repetition
    ) -> tuple[Point, int] | None:
        """Return the fixed point in the plane through a guess, and the Newton steps taken.

        Parameters
        ----------
        guess : ndarray, shape (n + 1,)
            Scaled coordinates.
        normal : ndarray, shape (n + 1,)
            Scaled normal of the plane.
        scale : ndarray, shape (n + 1,)

        Returns
        -------
        tuple of Point and int, or None
            None if Newton's method does not converge.
        """
        n, z, before = len(guess) - 1, guess, np.inf
        for steps in range(1, MAX_NEWTON_STEPS + 1):
            linear = self.linearise(z, normal, scale, repetition)
            if linear is None:
                return None
            image, a = linear
            off = (image.state - z[:n] * scale[:n]) / scale[:n]
            try:
                step = np.linalg.solve(a, -np.append(off, normal @ (z - guess)))
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if not np.isfinite(size) or size > MAX_CORRECTION:
                return None
            # Across a corner of the map full steps alternate between its two sides, and hardly
            # become shorter; elsewhere they do so quadratically.
            z = z + (0.5 * step if size >= 0.9 * before else step)
            stagnant = size <= STAGNATION_TOLERANCE and size >= 0.5 * before
            if size <= NEWTON_TOLERANCE or stagnant:
                linear = self.linearise(z, normal, scale, repetition)
                if linear is None:
                    return None
                image, a = linear
                try:
                    tangent = np.linalg.solve(a, np.eye(n + 1)[n])
                except np.linalg.LinAlgError:
                    return None
                tangent /= np.linalg.norm(tangent)
                return Point(float(z[n]), z[:n] * scale[:n], repetition, image, tangent), steps
            before = size
        return None

    def linearise(
        self, z: Floats, normal: Floats, scale: Floats, repetition: Repetition
    ) -> tuple[Image, Floats] | None:
        """Return the image of a state, and the scaled matrix of the bordered system.

        Parameters as in `corrector`, with the scaled coordinates z.
        """
        n = len(z) - 1
        p, y = float(z[n]), z[:n] * scale[:n]
        image = self.return_map(p, y, repetition)
        if image is None:
            return None
        jacobian = image.jacobian * scale[:n] / scale[:n, None]
        # Where a multiplier runs away, a small change already crosses the end of the branch.
        h = DIFFERENCE / max(1.0, float(np.abs(jacobian).max()))
        h = h if p < 0.5 else -h
        # Close to a corner, stay on its side.
        neighbour = None
        for share in CORNER_DIFFERENCES:
            change = share * h
            if not self.is_within(p + change):
                continue
            other = self.return_map(p + change, y, repetition)
            if other is not None:
                neighbour, dp = other, change
                if other.counts == image.counts:
                    break
        if neighbour is None:
            return None
        a = np.empty((n + 1, n + 1))
        a[:n, :n] = jacobian - np.eye(n)
        a[:n, n] = (neighbour.state - image.state) / (dp * scale[:n])
        a[n] = normal
        return image, a

    def at_parameter(
        self, p: float, state: Floats, peak: float, repetition: Repetition
    ) -> Point | None:
        """Return the fixed point near a state at a given parameter."""
        n = len(state)
        scale = self.scale(p, peak, n)
        guess = np.append(state, p) / scale
        corrected = self.corrector(guess, np.eye(n + 1)[n], scale, repetition)
        return None if corrected is None else corrected[0]._replace(p=p)

    def follow(self, seed: Point) -> Branch:
        """Follow a branch from a point along its tangent, to its end."""
        points, bifurcations = [seed], []
        ds, end = FIRST_STEP, ""
        quality = self.section_quality(seed)
        while not end and len(points) < self.max_points:
            last = points[-1]
            if self.is_at_end(last):
                end = RANGE
                break
            step = self.step(last, ds)
            if step is None and ds > SMALLEST_STEP:
                ds *= 0.5
                continue
            is_corner = step is None
            step = step or self.beyond_corner(last)
            if step is None:
                end = self.reason_to_end(last)
                if end == GRAZING:
                    point_at_end = (
                        extrapolate_end(points) if has_large_multiplier(last) else last
                    )
                    bifurcations.append(Bifurcation(GRAZING, point_at_end, len(points) - 1))
                break
            point, newton_steps = step
            if len(points) > 3 and self.closes(points[0], last, point, ds):
                end, point = LOOP, self.at_section_of(points[0], last)
            elif self.size_of_offset(point) < SAME_ORBIT:
                end = MERGED
            between = self.bifurcations_between(last, point, len(points) - 1, is_corner)
            # Where two branches meet, rounding decides on the sign of a vertical tangent.
            is_near = self.size_of_offset(point) < SAME_PLACE
            bifurcations += [
                bifurcation
                for bifurcation in between
                if not (is_near and bifurcation.kind == FOLD)
            ]
            if len(points) > 1:
                bifurcations += self.continua_between(points[-2], last, point, len(points) - 1)
            points.append(point)
            if float(np.abs(point.multipliers).max()) > LARGEST_MULTIPLIER:
                bifurcations.append(
                    Bifurcation(GRAZING, extrapolate_end(points), len(points) - 1)
                )
                end = GRAZING
            if newton_steps <= FEW_NEWTON_STEPS:
                ds = min(2.0 * ds, LARGEST_STEP)
            if self.section_quality(point) < SECTION_LOSS * quality:
                points[-1] = self.placed(point)
                quality = self.section_quality(points[-1])
        if end == MERGED:
            # Next to the branch that it meets, rounding decides on stability.
            while len(points) > 2 and self.size_of_offset(points[-2]) < SAME_PLACE:
                del points[-2]
            bifurcations = [
                bifurcation._replace(position=min(bifurcation.position, len(points) - 2))
                for bifurcation in bifurcations
            ]
        gaps = []
        if end in ("", LIMIT):
            gaps.append(Gap(LOST if end else MANY_POINTS, points[-1].p))
        return Branch(seed.repetition, points, bifurcations, ("", end or LIMIT), gaps)

    def reason_to_end(self, last: Point) -> str:
        """Return why no point follows on a branch: it merges, grazes, or is lost."""
        if self.size_of_offset(last) < SAME_PLACE:
            return MERGED
        if has_large_multiplier(last):
            return GRAZING
        scale = self.scale_at(last)
        for size in CORNER_SIZES:
            ahead = last.coordinates + size * last.tangent * scale
            image = self.return_map(float(ahead[-1]), ahead[:-1], last.repetition)
            if image is not None and image.counts != last.image.counts:
                return GRAZING
        return LIMIT

    def is_within(self, p: float) -> bool:
        """Whether a parameter is within the limits."""
        return self.limits[0] <= p <= self.limits[1]

    def is_at_end(self, point: Point) -> bool:
        """Whether a branch leaves the limits at a point."""
        low, high = self.limits
        return (point.p == low and point.tangent[-1] < 0.0) or (
            point.p == high and point.tangent[-1] > 0.0
        )

    def predictor(
        self, last: Point, ds: float, begin: Floats
    ) -> tuple[Floats, Floats, float | None]:
        """Return the point of the tangent at an arclength from the last point of a branch.

        Parameters
        ----------
        last : Point
        ds : float
            Arclength, scaled.
        begin : ndarray, shape (n + 1,)
            Scaled coordinates of the last point.

        Returns
        -------
        guess, normal : ndarray, shape (n + 1,)
            Scaled coordinates, and the normal of the plane for the corrector.
        limit : float or None
            p at the end of a range that the arclength crosses. The ends of the range are
            points, at which the branch is cut.
        """
        n = len(last.state)
        guess = begin + ds * last.tangent
        crossed = [
            p
            for p in (*self.limits, 0.0, 1.0)
            if min(last.p, guess[n]) < p < max(last.p, guess[n])
        ]
        if not crossed:
            return guess, last.tangent, None
        limit = min(crossed, key=lambda p: abs(p - last.p))
        guess = begin + (limit - last.p) / (guess[n] - last.p) * ds * last.tangent
        return guess, np.eye(n + 1)[n], limit

    def step(self, last: Point, ds: float) -> tuple[Point, int] | None:
        """Return the next point of a branch and its Newton steps; None if it is not found.

        Parameters
        ----------
        last : Point
        ds : float
            Arclength of the step, scaled.
        """
        scale = self.scale_at(last)
        begin = last.coordinates / scale
        guess, normal, limit = self.predictor(last, ds, begin)
        corrected = self.corrector(guess, normal, scale, last.repetition)
        if corrected is None:
            return None
        point, newton_steps = corrected
        if limit is not None:
            point = point._replace(p=limit)
        move = point.coordinates / scale - begin
        length = float(np.linalg.norm(move))
        least, most = (ratio * ds for ratio in STEP_RATIOS)
        if (limit is None and not least < length < most) or not self.is_within(point.p):
            return None
        point = point.along(move)
        cosines = [float(move @ end.tangent) for end in (last, point)]
        if min(cosines) < (MIN_COSINE if ds > CORNER_STEP else MIN_CORNER_COSINE) * length:
            return None
        # Beyond a corner the direction is known from the determinants as well.
        if point.image.counts != last.image.counts and not keeps_sense(last, point):
            return None
        if self.share_of_offset(last, point) < SMALL_SHARE:
            return None
        return point, newton_steps

    def beyond_corner(self, last: Point) -> tuple[Point, int] | None:
        """Return a point beyond the corner of a branch that is just ahead, or None.

        Where an event is born or lost the derivative of the map jumps, and the branch may turn
        by any angle. The derivative beyond the corner tells in which direction it goes on.
        """
        n, scale = len(last.state), self.scale_at(last)
        begin = last.coordinates / scale
        for size in CORNER_SIZES:
            beyond = begin + size * last.tangent
            linear = self.linearise(beyond, last.tangent, scale, last.repetition)
            if linear is None or linear[0].counts == last.image.counts:
                continue
            image, matrix = linear
            try:
                direction = np.linalg.solve(matrix, np.eye(n + 1)[n])
            except np.linalg.LinAlgError:
                continue
            direction /= np.linalg.norm(direction)
            ahead = last._replace(image=image, tangent=direction)
            if not keeps_sense(last, ahead):
                direction = -direction
            guess = begin + size * direction
            corrected = self.corrector(guess, direction, scale, last.repetition)
            if corrected is None or not self.is_within(corrected[0].p):
                continue
            point, newton_steps = corrected
            move = point.coordinates / scale - begin
            if (
                float(np.linalg.norm(move)) > STEP_RATIOS[1] * size
                or point.image.counts != image.counts
            ):
                continue
            if self.share_of_offset(last, point) < SMALL_SHARE:
                continue
            return point.along(direction), newton_steps
        return None

    def closes(self, first: Point, last: Point, point: Point, ds: float) -> bool:
        """Whether a step of a branch returns to its first point."""
        if (last.p - first.p) * (point.p - first.p) > 0.0:
            return False
        first = self.at_section_of(first, last)
        away = (point.coordinates - first.coordinates) / self.scale_at(first)
        same_sense = float(point.tangent @ first.tangent) > 0.0
        # The first point is between two that are a step apart, or a little beside it.
        return same_sense and float(np.linalg.norm(away)) <= 2.0 * ds

    def offset(self, point: Point) -> Floats | None:
        """Return the change of the state over half the repetition, scaled.

        It vanishes where the branch meets the one it bifurcated from.
        """
        halved = point.repetition.halved
        if halved is None or (halved.half and not self.symmetric):
            return None
        image = self.return_map(point.p, point.state, halved)
        if image is None:
            return None
        return (image.state - point.state) / self.scale_at(point)[:-1]

    def size_of_offset(self, point: Point) -> float:
        """Return the size of the offset, infinite where there is none."""
        offset = self.offset(point)
        return math.inf if offset is None else float(np.abs(offset).max())

    def share_of_offset(self, before: Point, point: Point) -> float:
        """Return the offset along the one before, relative to it; 1 where there is none."""
        offset_before, offset = self.offset(before), self.offset(point)
        if offset_before is None or offset is None or not offset_before.any():
            return 1.0
        return float(offset_before @ offset / (offset_before @ offset_before))

    def bifurcations_between(
        self, first: Point, last: Point, position: int, is_corner: bool
    ) -> Iterator[Bifurcation]:
        """Yield the bifurcations between two successive points of a branch.

        Parameters
        ----------
        first, last : Point
        position : int
            Index of the first one.
        is_corner : bool
            Whether the first one is at a corner, to within `SMALLEST_STEP`.
        """
        n = len(first.state)
        breaking = SYMMETRY_BREAKING if first.repetition.half else PERIOD_DOUBLING

        tests: list[tuple[str, Callable[[Point], float]]] = [
            (FOLD, lambda point: float(point.tangent[n])),
            (breaking, det_J_plus_I),
            (GRAZING, lambda point: 1.0 if point.image.counts == first.image.counts else -1.0),
        ]
        for kind, test in tests:
            if test(first) * test(last) < 0.0:
                point = first if is_corner else self.locate(first, last, test)
                if kind != breaking or abs(test(point)) < ZERO_SHARE * max(
                    abs(test(first)), abs(test(last))
                ):
                    yield Bifurcation(kind, point, position)

    def continua_between(
        self, first: Point, middle: Point, last: Point, position: int
    ) -> Iterator[Bifurcation]:
        """Yield the point between three at which an eigenvalue touches -1, if there is one.

        Without damping the orbits at single frequencies are one of a continuum each (Csernák,
        Stépán and Shaw 2007): the eigenvalue reaches -1 and does not cross it.
        """
        a, b, c = map(det_J_plus_I, (first, middle, last))
        if not 0.0 < b < min(a, c) or a + c == 2.0 * b:
            return
        bottom = b - 0.125 * (c - a) ** 2 / (a + c - 2.0 * b)
        if bottom > SHALLOW_SHARE * max(a, c):
            return

        # The derivative of the touching eigenvalue changes sign: compare with a point at 1e-6,
        # where the difference of two determinants keeps nine digits.
        def slope(point: Point) -> float:
            scale = self.scale_at(point)
            guess = point.coordinates / scale + 1e-6 * point.tangent
            corrected = self.corrector(guess, point.tangent, scale, point.repetition)
            return (
                math.nan
                if corrected is None
                else det_J_plus_I(corrected[0]) - det_J_plus_I(point)
            )

        for left, right in ((first, middle), (middle, last)):
            if slope(left) < 0.0 < slope(right):
                point = self.locate(left, right, slope)
                if det_J_plus_I(point) <= TOUCHING * max(a, c):
                    yield Bifurcation(CONTINUUM, point, position - (right is middle))

    def locate(self, first: Point, last: Point, test: Callable[[Point], float]) -> Point:
        """Return the point between two points of a branch at which a test changes sign."""
        from scipy.optimize import brentq

        first, repetition = self.at_section_of(first, last), last.repetition
        peak = max(first.image.peak, last.image.peak)
        scale = self.scale(first.p, peak, len(first.state))
        a, b = first.coordinates / scale, last.coordinates / scale
        chord = (b - a) / np.linalg.norm(b - a)
        best = {0.0: first, 1.0: last}

        def value(share: float) -> float:
            if share not in best:
                corrected = self.corrector(a + share * (b - a), chord, scale, repetition)
                if corrected is None:
                    raise ArithmeticError
                best[share] = corrected[0].along(chord)
            return test(best[share])

        try:
            share = float(brentq(value, 0.0, 1.0, xtol=LOCATION_TOLERANCE, rtol=1e-15))
            value(share)
        except ArithmeticError:
            shares = sorted(best)
            brackets = [
                (low, high)
                for low, high in itertools.pairwise(shares)
                if test(best[low]) * test(best[high]) <= 0.0
            ]
            share = min(brackets, key=lambda ends: ends[1] - ends[0])[1]
        return best[share]

    def branch_through(self, seed: Point) -> Branch:
        """Follow a branch from a point on it in both directions."""
        seed = self.placed(seed)
        ahead = self.follow(seed)
        if ahead.ends[1] == LOOP:
            return self.with_bifurcations(replace(ahead, ends=(LOOP, LOOP)))
        back = self.follow(seed.reversed)
        count = len(back.points)
        bifurcations = [
            *(
                bifurcation._replace(position=count - 2 - bifurcation.position)
                for bifurcation in back.bifurcations[::-1]
            ),
            *(
                bifurcation._replace(position=count - 1 + bifurcation.position)
                for bifurcation in ahead.bifurcations
            ),
        ]
        points = [point.reversed for point in back.points[:0:-1]] + ahead.points
        ends, gaps = (back.ends[1], ahead.ends[1]), back.gaps + ahead.gaps
        return self.with_bifurcations(Branch(seed.repetition, points, bifurcations, ends, gaps))

    def with_bifurcations(self, branch: Branch) -> Branch:
        """Return a branch with its bifurcations inserted into the points."""
        points: list[Point] = []
        bifurcations = [
            bifurcation._replace(position=0)
            for bifurcation in branch.bifurcations
            if bifurcation.position < 0
        ]
        for i, (point, after) in enumerate(
            itertools.zip_longest(branch.points, branch.points[1:])
        ):
            points.append(point)
            here = [
                bifurcation for bifurcation in branch.bifurcations if bifurcation.position == i
            ]
            if len(here) > 1:
                here.sort(key=lambda bifurcation: self.separation(point, bifurcation.point))
            for bifurcation in here:
                if after is not None and not (
                    bifurcation.point.is_same_state(point)
                    or bifurcation.point.is_same_state(after)
                ):
                    points.append(bifurcation.point)
                bifurcations.append(bifurcation._replace(position=len(points) - 1))
        return replace(branch, points=points, bifurcations=bifurcations)

    def separation(self, point: Point, other: Point) -> float:
        """Return the arclength between two close points of a branch, scaled."""
        point = self.at_section_of(point, other)
        change = (point.coordinates - other.coordinates) / self.scale_at(other)
        return float(np.linalg.norm(change))

    def switch(self, bifurcation: Point) -> Point | None:
        """Return a point on the branch that leaves a bifurcation at an eigenvalue of -1."""
        n, scale = len(bifurcation.state), self.scale_at(bifurcation)
        begin = bifurcation.coordinates / scale
        jacobian = bifurcation.image.jacobian * scale[:n] / scale[:n, None]
        values, vectors = np.linalg.eig(jacobian)
        which = int(np.argmin(abs(values + 1.0)))
        direction = np.append(np.real(vectors[:, which]), 0.0)
        direction /= np.linalg.norm(direction)
        for offset in SWITCH_OFFSETS:
            guess, repetition = begin + offset * direction, bifurcation.repetition.doubled
            corrected = self.corrector(guess, direction, scale, repetition)
            if corrected is None or not self.is_within(corrected[0].p):
                continue
            away = (corrected[0].state - bifurcation.state) / scale[:n]
            if float(np.linalg.norm(away)) < MAX_SWITCH_RATIO * offset:
                return corrected[0].along(direction)
        return None

    def images(self, p: float, state: Floats, repetition: Repetition) -> Iterator[Floats]:
        """Yield a state and its images within a repetition, mirrored where symmetric."""
        step = Repetition(1, self.symmetric, repetition.begin)
        for _ in range(round(repetition.length / step.length)):
            yield state
            image = self.return_map(p, state, step)
            if image is None:
                return
            state = image.state

    def contains(self, branch: Branch, seed: Point) -> bool:
        """Whether an orbit, or its mirror image, is on a branch."""
        return any(
            self.distance(point, seed) < SAME_ORBIT for point in self.crossings(branch, seed.p)
        )

    def meets(self, branch: Branch, bifurcation: Point) -> bool:
        """Whether a branch leaves another one at a bifurcation."""
        return any(
            end == MERGED
            and abs(point.p - bifurcation.p) < SAME_PLACE
            and self.distance(point, bifurcation) < SAME_PLACE
            for end, point in zip(
                branch.ends, (branch.points[0], branch.points[-1]), strict=True
            )
        )

    def distance(self, orbit: Point, other: Point) -> float:
        """Return the smallest scaled distance of an orbit from another or its mirror image."""
        delay = (other.repetition.begin - orbit.repetition.begin) % 1.0
        states = self.return_map.states(
            orbit.p, orbit.state, orbit.repetition, np.array([delay])
        )
        if states is None:
            return math.inf
        scale = self.scale_at(other)[:-1]
        return min(
            float(np.abs((states[0] - image) / scale).max())
            for image in self.images(other.p, other.state, other.repetition.doubled)
        )

    def find_branches(
        self, seeds: Sequence[tuple[float, Floats, float, int]], most: int
    ) -> tuple[list[Branch], list[Gap]]:
        """Return all branches through known orbits, and those that bifurcate from them.

        Parameters
        ----------
        seeds : sequence
            Orbits: p, state at the section 0, largest |x_r| [m] and periods per repetition.
        most : int
            Largest number of branches.

        Returns
        -------
        branches : list of Branch
            In the range: what is beyond it is cut.
        gaps : list of Gap
            What is missing there.
        """
        whole, gaps = self.branches_within_limits(seeds, most)
        branches = [part for branch in whole for part in cut_to_range(branch)]
        return branches, [gap for gap in gaps if is_in_range(gap.p)]

    def branches_within_limits(
        self, seeds: Sequence[tuple[float, Floats, float, int]], most: int
    ) -> tuple[list[Branch], list[Gap]]:
        """Return what `find_branches` returns, not cut to the range."""
        branches: list[Branch] = []
        gaps: list[Gap] = []
        not_isolated: list[Point] = []
        seed_images: list[tuple[float, Floats]] = []
        for p, state, peak, periods in seeds:
            scale = self.scale(p, peak, len(state))[:-1]
            if any(
                p == other and float(np.abs((state - image) / scale).max()) < SAME_ORBIT
                for other, image in seed_images
            ):
                continue
            seed_images += [(p, image) for image in self.images(p, state, Repetition(periods))]
            seed = self.isolate(p, state, peak, periods)
            if seed is None:
                image = self.return_map(p, state, Repetition(periods))
                if image is not None:
                    tangent = np.zeros(len(state) + 1)
                    not_isolated.append(Point(p, state, Repetition(periods), image, tangent))
                continue
            waiting: list[tuple[Point, Point | None]] = [(seed, None)]
            while waiting:
                point, origin = waiting.pop(0)
                if origin is not None and any(self.meets(each, origin) for each in branches):
                    continue
                if any(self.contains(each, point) for each in branches):
                    continue
                if len(branches) >= most:
                    return branches, [*gaps, Gap(MANY_BRANCHES, point.p)]
                branch = self.branch_through(point)
                branches.append(branch)
                gaps += branch.gaps
                for i, (kind, bifurcation, position) in enumerate(branch.bifurcations):
                    if kind not in (SYMMETRY_BREAKING, PERIOD_DOUBLING):
                        continue
                    if not is_in_range(bifurcation.p):
                        continue
                    if any(self.meets(each, bifurcation) for each in branches):
                        continue
                    if bifurcation.repetition.doubled.periods > MAX_PERIODS:
                        gaps.append(Gap(MANY_PERIODS, bifurcation.p))
                        continue
                    switched = self.switch(bifurcation)
                    if switched is None:
                        gaps.append(Gap(NOT_SWITCHED, bifurcation.p))
                    elif abs(switched.p - bifurcation.p) <= CONTINUUM_WIDTH:
                        branch.bifurcations[i] = Bifurcation(CONTINUUM, bifurcation, position)
                    else:
                        waiting.append((switched, bifurcation))
        gaps += [
            Gap(NOT_ISOLATED, point.p)
            for point in not_isolated
            if not any(self.contains(each, point) for each in branches)
        ]
        return branches, gaps

    def crossings(self, branch: Branch, p: float) -> Iterator[Point]:
        """Yield the points of a branch at a value of the parameter."""
        for before, after in zip(branch.points, branch.points[1:], strict=False):
            # A point at the value itself belongs to the step that begins there.
            if (before.p - p) * (after.p - p) > 0.0 or (
                after.p == p and after is not branch.points[-1]
            ):
                continue
            start = self.at_section_of(before, after)
            share = 0.0 if start.p == after.p else (p - start.p) / (after.p - start.p)
            guess = start.state + share * (after.state - start.state)
            point = self.at_parameter(p, guess, start.image.peak, after.repetition)
            if point is not None:
                yield point

    def isolate(self, p: float, state: Floats, peak: float, periods: int) -> Point | None:
        """Return an orbit as a fixed point of its shortest repetition, or None."""
        whole = Repetition(periods)
        halved = whole.halved if self.symmetric and periods % 2 == 1 else None
        for repetition in (halved, whole):
            if repetition is None:
                continue
            image = self.return_map(p, state, repetition)
            if image is None:
                continue
            delay = self.best_delay(p, state, repetition, image)
            states = self.return_map.states(p, state, repetition, np.array([delay]))
            if states is None:
                continue
            point = self.at_parameter(p, states[0], peak, repetition.delayed(delay))
            scale = self.scale(p, peak, len(state))[:-1]
            if (
                point is not None
                and float(np.abs((point.state - states[0]) / scale).max()) < SAME_ORBIT
            ):
                return point
        return None


def is_in_range(p: float) -> bool:
    """Whether a parameter is in the range from 0 to 1."""
    return 0.0 <= p <= 1.0


def cut_to_range(branch: Branch) -> Iterator[Branch]:
    """Yield the parts of a branch in the range; the ends of the range are points of it."""
    points, bifurcations = branch.points, branch.bifurcations
    inside = [is_in_range(point.p) for point in points]
    if all(inside):
        yield branch
        return
    if branch.ends[0] == LOOP:
        # Begin outside; the last point is the first one again.
        shift, count = inside.index(False), len(points) - 1
        points = points[shift:-1] + points[: shift + 1]
        inside = inside[shift:-1] + inside[: shift + 1]
        bifurcations = [
            bifurcation._replace(position=(bifurcation.position - shift) % count)
            for bifurcation in bifurcations
        ]
    last = len(points) - 1
    for is_inside, group in itertools.groupby(range(len(points)), key=inside.__getitem__):
        run = [*group]
        begin, end = run[0], run[-1]
        if not is_inside or begin == end:
            continue
        yield replace(
            branch,
            points=points[begin : end + 1],
            bifurcations=[
                bifurcation._replace(position=bifurcation.position - begin)
                for bifurcation in bifurcations
                if begin <= bifurcation.position <= end and is_in_range(bifurcation.point.p)
            ],
            ends=(
                branch.ends[0] if begin == 0 else RANGE,
                branch.ends[1] if end == last else RANGE,
            ),
        )


def time_to_event(time: float, repetition: Repetition, image: Image) -> float:
    """Return the time from an instant of an orbit to its nearest event, in periods."""
    half = 0.5 * repetition.length
    apart = np.abs((image.events - time + half) % repetition.length - half)
    return float(apart.min(initial=half))


def det_J_plus_I(point: Point) -> float:
    """Return det(J + I), the test function of an eigenvalue of -1."""
    jacobian = point.image.jacobian
    return float(np.linalg.det(jacobian + np.eye(len(jacobian))))
