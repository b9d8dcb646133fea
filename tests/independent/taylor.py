"""The oscillator with dry friction in 50 digits, written without a look at the core.

No closed form takes part: every stretch of motion is summed as its Taylor series, which the
equation of motion yields by recursion, and events are zeros of these polynomials. Slow, and
meant to be.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import mpmath as mp
from drawn import Scene
from polynomial import DIGITS, Polynomial, first_zero, leaves, slope, square_integral, value

TERMS = 42
"""A stretch is one radian of the fastest rate, so what is left out is below 1/42! = 7e-52."""


class Solution(NamedTuple):
    """Mode at the start, events (time, kind, x_r), the state at the end, and integrals.

    Modes are 0 stuck and ±1 sliding; kinds of events 0 stick, ±1 slip, ±2 reversal. The
    integrals are of x_r², v_r², x_dd² and ü², and the time stuck.
    """

    start: int
    events: list[tuple[Any, int, Any]]
    x_r: Any
    v_r: Any
    d: int
    integrals: dict[str, Any]


class March:
    """One run through a scene. A stretch of length h is a polynomial in s/h, from 0 to 1."""

    def __init__(self, scene: Scene) -> None:
        self.m, self.k, self.b, self.F_fk, self.F_fs, self.x, self.v = map(mp.mpf, scene[:7])
        self.c, self.w = self.b / self.m, self.k / self.m
        self.sines = [
            (mp.mpf(A), 2 * mp.pi * mp.mpf(f), mp.mpf(phase)) for A, f, phase in scene.sines
        ]
        swing, f, phase = map(mp.mpf, scene.variation)
        self.loads = [(swing, 2 * mp.pi * f, phase)] if swing else []
        self.u_dd, self.dt = [mp.mpf(each) for each in scene.u_dd], mp.mpf(scene.dt)
        self.end = mp.mpf(scene.end)
        fastest = max(
            [self.c + mp.sqrt(self.w), *(omega for _, omega, _ in self.sines + self.loads)]
        )
        self.longest = 1 / fastest if fastest else self.end
        self.t = mp.mpf(0)
        self.events: list[tuple[Any, int, Any]] = []
        self.sums = dict.fromkeys(("x2", "v2", "x_dd2", "u_dd2", "stuck"), mp.mpf(0))

    def base(self, n: int, h: Any) -> Polynomial:
        """Return ü from now on, in the sample interval n."""
        p = [mp.mpf(0)] * TERMS
        if self.u_dd:
            rise = (self.u_dd[n + 1] - self.u_dd[n]) / self.dt
            p[0], p[1] = self.u_dd[n] + rise * (self.t - n * self.dt), rise * h
        return self.with_waves(p, self.sines, h)

    def load(self, h: Any) -> Polynomial:
        """Return the normal force from now on, relative to its mean."""
        return self.with_waves([mp.mpf(1)] + [mp.mpf(0)] * (TERMS - 1), self.loads, h)

    def with_waves(self, p: Polynomial, waves: list[Any], h: Any) -> Polynomial:
        """Add sines to a polynomial."""
        for A, omega, phase in waves:
            sine, cosine = mp.sin(omega * self.t + phase), mp.cos(omega * self.t + phase)
            factor = A
            for i in range(TERMS):
                p[i] += factor * (sine, cosine, -sine, -cosine)[i % 4]
                factor *= omega * h / (i + 1)
        return p

    def motion(self, u: Polynomial, f: Polynomial, h: Any) -> Polynomial:
        """Return x_r of sliding against a friction force per mass f, from the current state."""
        x, c, w = [self.x, self.v * h], self.c * h, self.w * h * h
        for n in range(TERMS - 2):
            force = h * h * (u[n] + f[n])
            x.append(-(force + c * (n + 1) * x[n + 1] + w * x[n]) / ((n + 1) * (n + 2)))
        return x

    def mode_at_rest(self, u: Any, load: Any) -> int:
        """Return the direction in which the limit force drives the mass, 0 where it holds."""
        F_L = self.m * u + self.k * self.x
        return 0 if abs(F_L) <= self.F_fs * load else (-1 if F_L > 0 else 1)

    def stretches(self) -> Iterator[tuple[Any, int]]:
        """Return the ends of the sample intervals, with their numbers."""
        if not self.u_dd:
            yield self.end, 0
        for n in range(len(self.u_dd) - 1):
            yield min((n + 1) * self.dt, self.end), n

    def run(self, most: int) -> Solution:
        """March to the end, or until there are as many events as asked for."""
        d = (1 if self.v > 0 else -1) if self.v else 0
        d = d or self.mode_at_rest(self.base(0, 1)[0], self.load(1)[0])
        start = d
        for until, n in self.stretches():
            while self.t < until and len(self.events) < most:
                h = min(self.longest, until - self.t)
                u = self.base(n, h)
                d, share, kind = self.stick(u, h) if d == 0 else self.slip(u, d, h)
                self.sums["u_dd2"] += h * square_integral(u, share)
                self.t = until if share == 1 and h == until - self.t else self.t + share * h
                if kind is not None:
                    self.events.append((self.t, kind, self.x))
        return Solution(start, self.events, self.x, self.v, d, self.sums)

    def stick(self, u: Polynomial, h: Any) -> tuple[int, Any, int | None]:
        """Stay stuck to the end or to break-away; gives mode, share of h, and any event."""
        share, d = mp.mpf(1), 0
        for side in (1, -1):
            gap = [
                self.F_fs * hold - side * self.m * each
                for hold, each in zip(self.load(h), u, strict=True)
            ]
            gap[0] -= side * self.k * self.x
            found = leaves(gap)
            if found is not None and found < share:
                share, d = found, -side
        self.sums["x2"] += self.x**2 * share * h
        self.sums["x_dd2"] += h * square_integral(u, share)
        self.sums["stuck"] += share * h
        return d, share, d or None

    def slip(self, u: Polynomial, d: int, h: Any) -> tuple[int, Any, int | None]:
        """Slide to the end or to the stop; gives mode, share of h, and any event."""
        load = self.load(h)
        f = [d * self.F_fk / self.m * each for each in load]
        x = self.motion(u, f, h)
        v = [each / h for each in slope(x)]
        found = first_zero([d * each for each in v])
        share = mp.mpf(1) if found is None else found
        x_dd = [-self.w * x[n] - self.c * v[n] - f[n] for n in range(TERMS - 1)]
        for name, p in (("x2", x), ("v2", v), ("x_dd2", x_dd)):
            self.sums[name] += h * square_integral(p, share)
        self.x, self.v = value(x, share), value(v, share)
        if found is None:
            return d, share, None
        self.v = mp.mpf(0)
        mode = self.mode_at_rest(value(u, share), value(load, share))
        return mode, share, 2 * mode


def solve(scene: Scene, most: int = 10_000) -> Solution:
    """Return the solution of a scene from t = 0 to its end, or to so many events."""
    with mp.workdps(DIGITS):
        return March(scene).run(most)
