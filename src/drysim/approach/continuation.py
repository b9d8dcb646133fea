"""Branches of periodic orbits along a parameter, through folds, with their bifurcations.

Problem
    A periodic orbit is a fixed point of a return map: the state after a repetition as a
    function of the state before it. As a parameter varies, the fixed points form curves
    (branches). They turn back at folds and have unstable parts, which no march in time reaches.

Method
    Pseudo-arclength continuation: predict along the tangent, correct by Newton's method in the
    plane normal to it (Keller 1977). The maps march the motion itself and find all events, so a
    branch passes from sliding to sticking without declared sequences of events. Orbits that
    are symmetric under half a period and a change of sign are fixed points of the negative
    half map, in which folds and symmetry breaking are different eigenvalues (+1 and -1).

Bifurcations
    Zeros of test functions along a branch, by Brent's method: the parameter component of the
    tangent (fold), det(J + I) (symmetry breaking of the half map; period doubling of others),
    and the number of stops and reversals (grazing). With F_fs > F_fk the map jumps where the
    motion grazes v_r = 0 or F_fs, and a branch may end there.

References: H. B. Keller, in Applications of Bifurcation Theory (1977); Yu. A. Kuznetsov,
Elements of Applied Bifurcation Theory (2004), chapter 10; R. I. Leine and H. Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FOLD, SYMMETRY_BREAKING, PERIOD_DOUBLING, GRAZING, CONTINUUM = (
    "fold",
    "symmetry breaking",
    "period doubling",
    "grazing",
    "continuum",
)
"""Kinds of bifurcation."""


class Repetition(NamedTuple):
    """Repetition whose image is compared with its start.

    Attributes
    ----------
    periods : int
        Periods of the excitation.
    half : bool
        Whether it is half a period, and the image is taken with the opposite sign.
    """

    periods: int = 1
    half: bool = False

    @property
    def doubled(self) -> Repetition:
        """The repetition after which the motion repeats beyond a bifurcation at -1."""
        return Repetition() if self.half else Repetition(2 * self.periods)

    @property
    def halved(self) -> Repetition | None:
        """The repetition of which this one is the double; None of the shortest."""
        if self.half:
            return None
        if self.periods == 1:
            return Repetition(1, True)
        return Repetition(self.periods // 2) if self.periods % 2 == 0 else None


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
    peak : float
        Largest |x_r| at an event or an end [m].
    """

    state: Floats
    differentiate: Callable[[], tuple[Floats, float]]
    counts: tuple[int, ...]
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


ReturnMap = Callable[[float, Floats, Repetition], "Image | None"]
"""Image of a state at a parameter from 0 to 1; None where the motion cannot be solved."""


class Point(NamedTuple):
    """Fixed point on a branch.

    Attributes
    ----------
    p : float
        Parameter, from 0 to 1 over its range.
    state : ndarray, shape (n,)
    image : Image
    tangent : ndarray, shape (n + 1,)
        Scaled unit tangent of the branch; the last component is that of p.
    """

    p: float
    state: Floats
    image: Image
    tangent: Floats

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the Jacobian of the return map."""
        return np.linalg.eigvals(self.image.jacobian).astype(np.complex128)


class Bifurcation(NamedTuple):
    """Bifurcation on a branch: its kind, the point, and the number of the point after it."""

    kind: str
    point: Point
    follower: int


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
    """

    repetition: Repetition
    points: list[Point]
    bifurcations: list[Bifurcation] = field(default_factory=list)
    ends: tuple[str, str] = ("", "")


MAX_NEWTON_STEPS = 25
NEWTON_TOLERANCE = 1e-12
"""Scaled Newton step at which the iteration has converged."""

STAGNATION_TOLERANCE = 1e-9
"""Scaled step accepted when it no longer decreases: rounding near a bifurcation."""

DIFFERENCE = 1e-7
"""Difference of p for the derivative with respect to it; only the speed of convergence depends
on its accuracy."""

FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 2e-3, 2e-2, 1e-10
"""Arclength of steps, scaled: displacements by the peak, p by its range."""

FEW_NEWTON_STEPS = 4
"""Newton steps up to which the next step along the branch is longer."""

MAX_TURN = 0.8
"""Smallest cosine of the angle between two successive steps; steeper corners are passed with
steps below `CORNER_STEP`."""

CORNER_STEP = 1e-5

MAX_POINTS, MAX_PERIODS = 4000, 16
"""Most points of a branch, and most periods per repetition."""

SAME_ORBIT = 1e-6
"""Scaled distance below which two orbits at one parameter are the same."""

SWITCH_OFFSETS = (1e-2, 3e-3, 3e-2)
"""Scaled distances from a bifurcation at which the branch that leaves it is sought."""

LARGEST_MULTIPLIER = 1e3
"""Multiplier beyond which a branch is at its end: a break-away or a stop is about to vanish."""

TOUCHING = 1e-6
"""Size of det(J + I), relative to its neighbours, at which an eigenvalue touches -1."""

LOCATION_TOLERANCE = 1e-13
"""Tolerance of the position of a bifurcation on the chord of a step."""

CONTINUUM_WIDTH = 1e-10
"""Change of p below which the branch that leaves a bifurcation exists at one parameter only."""


def extrapolate_end(before: Point, last: Point) -> Point:
    """Return the end of a branch at which a multiplier becomes infinite.

    Its inverse goes to zero linearly with the parameter.
    """
    a, b = (1.0 / float(np.abs(point.multipliers).max()) for point in (before, last))
    share = min(b / (a - b), 1e3) if a > b else 0.0
    p = last.p + share * (last.p - before.p)
    return last._replace(p=p, state=last.state + share * (last.state - before.state))


class Continuation:
    """Continuation of the fixed points of a return map.

    Parameters
    ----------
    return_map : callable
    speed : callable
        Returns the scale of v_r/x_r [1/s] at p.
    max_points : int, optional
        Most points of a branch.
    """

    def __init__(
        self,
        return_map: ReturnMap,
        speed: Callable[[float], float],
        max_points: int = MAX_POINTS,
    ) -> None:
        self.return_map, self.speed, self.max_points = return_map, speed, max_points

    def scale(self, p: float, peak: float, n: int) -> Floats:
        """Return the scale of each state component and of p, shape (n + 1,)."""
        size = peak or 1.0
        return np.array([size, size * self.speed(p), *[size] * (n - 2), 1.0])

    def residual(self, point: Point) -> float:
        """Return the scaled change of the state over a repetition of a fixed point."""
        scale = self.scale(point.p, point.image.peak, len(point.state))[:-1]
        return float((np.abs(point.image.state - point.state) / scale).max())

    def correct(
        self, p: float, state: Floats, normal: Floats, scale: Floats, repetition: Repetition
    ) -> tuple[Point, int] | None:
        """Return the fixed point in the plane through a guess, and the Newton steps taken.

        Parameters
        ----------
        p, state
            The guess.
        normal : ndarray, shape (n + 1,)
            Scaled normal of the plane.
        scale : ndarray, shape (n + 1,)

        Returns
        -------
        tuple of Point and int, or None
            None if Newton's method does not converge.
        """
        n = len(state)
        guess = np.append(state, p) / scale
        z, before = guess.copy(), np.inf
        for steps in range(1, MAX_NEWTON_STEPS + 1):
            at, y = float(z[n]), z[:n] * scale[:n]
            matrix = self.linearise(at, y, normal, scale, repetition)
            if matrix is None:
                return None
            image, a = matrix
            off = (image.state - y) / scale[:n]
            try:
                step = np.linalg.solve(a, -np.append(off, normal @ (z - guess)))
            except np.linalg.LinAlgError:
                return None
            size = float(np.abs(step).max())
            if not np.isfinite(size) or size > 10.0:
                return None
            # Across a corner of the map full steps may alternate between its two sides.
            z = z + (0.5 * step if size >= 0.9 * before else step)
            # A stop at the end of the repetition sets v_r to exactly zero.
            if image.state[1] == 0.0:
                z[1] = 0.0
            stagnant = size <= STAGNATION_TOLERANCE and size >= 0.5 * before
            if size <= NEWTON_TOLERANCE or stagnant:
                at, y = float(z[n]), z[:n] * scale[:n]
                matrix = self.linearise(at, y, normal, scale, repetition)
                if matrix is None:
                    return None
                image, a = matrix
                try:
                    tangent = np.linalg.solve(a, np.append(np.zeros(n), 1.0))
                except np.linalg.LinAlgError:
                    return None
                tangent /= np.linalg.norm(tangent)
                return Point(at, y, image, tangent), steps
            before = size
        return None

    def linearise(
        self, p: float, y: Floats, normal: Floats, scale: Floats, repetition: Repetition
    ) -> tuple[Image, Floats] | None:
        """Return the image of a state, and the scaled matrix of the bordered system."""
        image = self.return_map(p, y, repetition)
        h = DIFFERENCE if p < 0.5 else -DIFFERENCE
        beside = self.return_map(p + h, y, repetition)
        if image is None or beside is None:
            return None
        n = len(y)
        a = np.empty((n + 1, n + 1))
        a[:n, :n] = (image.jacobian - np.eye(n)) * scale[:n] / scale[:n, None]
        a[:n, n] = (beside.state - image.state) / (h * scale[:n])
        a[n] = normal
        return image, a

    def at_parameter(
        self, p: float, state: Floats, peak: float, repetition: Repetition
    ) -> Point | None:
        """Return the fixed point near a state at a given parameter."""
        n = len(state)
        scale = self.scale(p, peak, n)
        found = self.correct(p, state, np.eye(n + 1)[n], scale, repetition)
        return None if found is None else found[0]._replace(p=p)

    def follow(self, seed: Point, repetition: Repetition, sense: float) -> Branch:
        """Follow a branch from a point in one direction, to its end."""
        n = len(seed.state)
        seed = seed._replace(tangent=sense * seed.tangent)
        points, found = [seed], []
        ds, chord = FIRST_STEP, seed.tangent
        end = "limit"
        offset = self.offset(seed, repetition)
        while len(points) < self.max_points:
            last = points[-1]
            scale = self.scale(last.p, last.image.peak, n)
            target = np.append(last.state, last.p) / scale + ds * last.tangent
            at_end = not 0.0 <= target[n] <= 1.0
            if at_end:
                p = 0.0 if target[n] < 0.0 else 1.0
                if p == last.p:
                    end = "range"
                    break
                share = (p - last.p) / (target[n] - last.p)
                target = np.append(last.state, last.p) / scale + share * ds * last.tangent
                normal = np.eye(n + 1)[n]
            else:
                normal = last.tangent
            corrected = self.correct(
                float(target[n]), target[:n] * scale[:n], normal, scale, repetition
            )
            point = None if corrected is None else corrected[0]
            if point is not None and at_end:
                point = point._replace(p=p)
            if point is not None:
                move = (np.append(point.state - last.state, point.p - last.p)) / scale
                length = float(np.linalg.norm(move))
                cosine = float(move @ chord) / length if length > 0.0 else -1.0
                allowed = cosine >= MAX_TURN or (ds <= CORNER_STEP and cosine > 0.0)
                expected = at_end or 0.3 * ds < length < 3.0 * ds
                if not (allowed and expected and 0.0 <= point.p <= 1.0):
                    point = None
            if point is None:
                ds *= 0.5
                if ds < SMALLEST_STEP:
                    found.append(Bifurcation(GRAZING, last, len(points)))
                    end = GRAZING
                    break
                continue
            if float(point.tangent @ move) < 0.0:
                point = point._replace(tangent=-point.tangent)
            chord = move / length
            new_offset = self.offset(point, repetition)
            # At its first point, a branch that leaves another is still near it.
            if offset is not None and new_offset is not None and len(points) > 1:
                crossed = float(offset @ new_offset) < 0.0
            else:
                crossed = False
            if crossed:
                end = "merged"
                break
            offset = new_offset
            found += self.bifurcations_between(last, point, repetition, len(points))
            if len(points) > 1:
                found += self.continua_between(points[-2], last, point, repetition, len(points))
            points.append(point)
            if float(np.abs(point.multipliers).max()) > LARGEST_MULTIPLIER:
                found.append(Bifurcation(GRAZING, extrapolate_end(last, point), len(points)))
                end = GRAZING
                break
            if at_end:
                end = "range"
                break
            if len(points) > 3 and self.closes(points, ds):
                end = "loop"
                break
            if corrected is not None and corrected[1] <= FEW_NEWTON_STEPS:
                ds = min(1.5 * ds, LARGEST_STEP)
        return Branch(repetition, points, found, ("", end))

    def closes(self, points: Sequence[Point], ds: float) -> bool:
        """Whether a branch has returned to its first point."""
        first, before, last = points[0], points[-2], points[-1]
        if (before.p - first.p) * (last.p - first.p) > 0.0:
            return False
        scale = self.scale(first.p, first.image.peak, len(first.state))
        away = np.append(last.state - first.state, last.p - first.p) / scale
        same_sense = float(last.tangent @ first.tangent) > 0.0
        return same_sense and float(np.linalg.norm(away)) <= 2.0 * ds

    def offset(self, point: Point, repetition: Repetition) -> Floats | None:
        """Return the change of the state over half the repetition, scaled.

        It vanishes where the branch meets the one it bifurcated from.
        """
        if repetition.halved is None:
            return None
        image = self.return_map(point.p, point.state, repetition.halved)
        if image is None:
            return None
        scale = self.scale(point.p, point.image.peak, len(point.state))[:-1]
        return (image.state - point.state) / scale

    def bifurcations_between(
        self, first: Point, last: Point, repetition: Repetition, index: int
    ) -> Iterator[Bifurcation]:
        """Yield the bifurcations between two successive points of a branch."""
        n = len(first.state)
        breaking = SYMMETRY_BREAKING if repetition.half else PERIOD_DOUBLING

        tests: list[tuple[str, Callable[[Point], float]]] = [
            (FOLD, lambda point: float(point.tangent[n])),
            (breaking, self.plus),
            (GRAZING, lambda point: 1.0 if point.image.counts == first.image.counts else -1.0),
        ]
        for kind, test in tests:
            if test(first) * test(last) < 0.0:
                point = self.locate(first, last, repetition, test)
                if kind != breaking or abs(test(point)) < 1e-3 * max(
                    abs(test(first)), abs(test(last))
                ):
                    yield Bifurcation(kind, point, index)

    def continua_between(
        self, first: Point, middle: Point, last: Point, repetition: Repetition, index: int
    ) -> Iterator[Bifurcation]:
        """Yield the point between three at which an eigenvalue touches -1, if there is one.

        Without damping the orbits at single frequencies are one of a continuum each (Csernák,
        Stépán and Shaw 2007): the eigenvalue reaches -1 and does not cross it.
        """
        a, b, c = map(self.plus, (first, middle, last))
        if not 0.0 < b < min(a, c) or a + c == 2.0 * b:
            return
        bottom = b - 0.125 * (c - a) ** 2 / (a + c - 2.0 * b)
        if bottom > 0.1 * max(a, c):
            return

        # The derivative of the touching eigenvalue changes sign: compare with a point beside.
        def slope(point: Point) -> float:
            scale = self.scale(point.p, point.image.peak, len(point.state))
            beside = np.append(point.state, point.p) + 1e-6 * point.tangent * scale
            found = self.correct(
                float(beside[-1]), beside[:-1], point.tangent, scale, repetition
            )
            return math.nan if found is None else self.plus(found[0]) - self.plus(point)

        for one, other in ((first, middle), (middle, last)):
            if slope(one) < 0.0 < slope(other):
                point = self.locate(one, other, repetition, slope)
                if self.plus(point) <= TOUCHING * max(a, c):
                    yield Bifurcation(CONTINUUM, point, index - (other is middle))

    @staticmethod
    def plus(point: Point) -> float:
        """Return det(J + I), the test function of an eigenvalue of -1."""
        jacobian = point.image.jacobian
        return float(np.linalg.det(jacobian + np.eye(len(jacobian))))

    def locate(
        self,
        first: Point,
        last: Point,
        repetition: Repetition,
        test: Callable[[Point], float],
    ) -> Point:
        """Return the point between two points of a branch at which a test changes sign."""
        from scipy.optimize import brentq

        n = len(first.state)
        scale = self.scale(first.p, max(first.image.peak, last.image.peak), n)
        a, b = (np.append(point.state, point.p) / scale for point in (first, last))
        chord = (b - a) / np.linalg.norm(b - a)
        best = {0.0: first, 1.0: last}

        def value(share: float) -> float:
            if share not in best:
                guess = a + share * (b - a)
                found = self.correct(
                    float(guess[n]), guess[:n] * scale[:n], chord, scale, repetition
                )
                if found is None:
                    raise ArithmeticError
                point = found[0]
                if float(point.tangent @ chord) < 0.0:
                    point = point._replace(tangent=-point.tangent)
                best[share] = point
            return test(best[share])

        try:
            share = float(brentq(value, 0.0, 1.0, xtol=LOCATION_TOLERANCE, rtol=1e-15))
            value(share)
        except ArithmeticError:
            share = min(best, key=lambda one: abs(test(best[one])))
        return best[share]

    def branch_through(self, seed: Point, repetition: Repetition) -> Branch:
        """Follow a branch from a point on it in both directions."""
        ahead = self.follow(seed, repetition, 1.0)
        if ahead.ends[1] == "loop":
            return replace(ahead, ends=("loop", "loop"))
        back = self.follow(seed, repetition, -1.0)
        count = len(back.points)
        turned = [
            item._replace(follower=count - item.follower)
            for item in reversed(back.bifurcations)
        ]
        moved = [
            item._replace(follower=item.follower + count - 1) for item in ahead.bifurcations
        ]
        points = [point._replace(tangent=-point.tangent) for point in back.points[:0:-1]]
        return Branch(
            repetition, points + ahead.points, turned + moved, (back.ends[1], ahead.ends[1])
        )

    def switch(
        self, bifurcation: Point, repetition: Repetition
    ) -> tuple[Point, Repetition] | None:
        """Return a point on the branch that leaves a bifurcation at an eigenvalue of -1."""
        n = len(bifurcation.state)
        scale = self.scale(bifurcation.p, bifurcation.image.peak, n)
        jacobian = bifurcation.image.jacobian * scale[:n] / scale[:n, None]
        values, vectors = np.linalg.eig(jacobian)
        which = int(np.argmin(abs(values + 1.0)))
        direction = np.append(np.real(vectors[:, which]), 0.0)
        direction /= np.linalg.norm(direction)
        doubled = repetition.doubled
        for offset in SWITCH_OFFSETS:
            guess = np.append(bifurcation.state, bifurcation.p) / scale + offset * direction
            found = self.correct(
                bifurcation.p, guess[:n] * scale[:n], direction, scale, doubled
            )
            if found is None or not 0.0 <= found[0].p <= 1.0:
                continue
            point = found[0]
            away = np.append(point.state - bifurcation.state, 0.0) / scale
            if float(np.linalg.norm(away)) < 10.0 * offset:
                if float(point.tangent @ direction) < 0.0:
                    point = point._replace(tangent=-point.tangent)
                return point, doubled
        return None

    def images(
        self, p: float, state: Floats, repetition: Repetition, symmetric: bool
    ) -> Iterator[Floats]:
        """Yield a state and its images within a repetition, mirrored where symmetric."""
        step = Repetition(1, True) if symmetric else Repetition()
        count = repetition.periods * (2 if symmetric else 1)
        for _ in range(1 if repetition.half else count):
            yield state
            image = self.return_map(p, state, step)
            if image is None:
                return
            state = image.state

    def contains(self, branch: Branch, seed: Point, images: Sequence[Floats]) -> bool:
        """Whether an orbit, given with its images, is on a branch already."""
        scale = self.scale(seed.p, seed.image.peak, len(seed.state))[:-1]
        return any(
            float(np.abs((point.state - state) / scale).max()) < SAME_ORBIT
            for point in self.crossings(branch, seed.p)
            for state in images
        )

    def find_branches(
        self, seeds: Sequence[tuple[float, Floats, float, int]], symmetric: bool, most: int
    ) -> tuple[list[Branch], bool]:
        """Return all branches through known orbits, and those that bifurcate from them.

        Parameters
        ----------
        seeds : sequence
            Orbits: p, state, largest |x_r| [m] and periods per repetition.
        symmetric : bool
            Whether the equation of motion is symmetric under half a period and a change of
            sign.
        most : int
            Largest number of branches.

        Returns
        -------
        branches : list of Branch
        complete : bool
            False if there may be more branches than `most`.
        """
        branches: list[Branch] = []
        known: list[tuple[float, Floats]] = []
        for p, state, peak, periods in seeds:
            scale = self.scale(p, peak, len(state))[:-1]
            if any(
                p == other and float(np.abs((state - image) / scale).max()) < SAME_ORBIT
                for other, image in known
            ):
                continue
            known += [
                (p, image) for image in self.images(p, state, Repetition(periods), symmetric)
            ]
            found = self.isolate(p, state, peak, periods, symmetric)
            if found is None:
                continue
            waiting = [found]
            while waiting:
                point, repetition = waiting.pop(0)
                images = [*self.images(point.p, point.state, repetition, symmetric)]
                if any(self.contains(one, point, images) for one in branches):
                    continue
                if len(branches) >= most:
                    return branches, False
                branch = self.branch_through(point, repetition)
                branches.append(branch)
                for i, (kind, at, index) in enumerate(branch.bifurcations):
                    if kind not in (SYMMETRY_BREAKING, PERIOD_DOUBLING):
                        continue
                    if repetition.doubled.periods > MAX_PERIODS:
                        continue
                    switched = self.switch(at, repetition)
                    if switched is None:
                        continue
                    if abs(switched[0].p - at.p) <= CONTINUUM_WIDTH:
                        branch.bifurcations[i] = Bifurcation(CONTINUUM, at, index)
                    else:
                        waiting.append(switched)
        return branches, True

    def crossings(self, branch: Branch, p: float) -> Iterator[Point]:
        """Yield the points of a branch at a value of the parameter."""
        for one, other in zip(branch.points, branch.points[1:], strict=False):
            # A point at the value itself belongs to the step that begins there.
            if (one.p - p) * (other.p - p) > 0.0 or (
                other.p == p and other is not branch.points[-1]
            ):
                continue
            share = 0.0 if one.p == other.p else (p - one.p) / (other.p - one.p)
            guess = one.state + share * (other.state - one.state)
            point = self.at_parameter(p, guess, one.image.peak, branch.repetition)
            if point is not None:
                yield point

    def isolate(
        self, p: float, state: Floats, peak: float, periods: int, symmetric: bool
    ) -> tuple[Point, Repetition] | None:
        """Return an orbit as a fixed point of its shortest repetition, or None."""
        for repetition in ([Repetition(1, True)] if symmetric and periods == 1 else []) + [
            Repetition(periods)
        ]:
            point = self.at_parameter(p, state, peak, repetition)
            if point is None:
                continue
            scale = self.scale(p, peak, len(state))[:-1]
            if float(np.abs((point.state - state) / scale).max()) < SAME_ORBIT:
                return point, repetition
        return None
