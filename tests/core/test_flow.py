"""The flow against arbitrary precision, in every damping regime."""

from __future__ import annotations

import math
from types import SimpleNamespace

import mpmath as mp
import pytest

REGIMES = {
    "light": (0.5, 100.0),
    "paper": (500 / 75, 100.0),
    "critical": (20.0, 100.0),
    "just above critical": (20.0 * (1 + 1e-8), 100.0),
    "heavy": (1000.0, 100.0),
    "no damper": (0.0, 100.0),
    "no spring": (2.0, 0.0),
    "free block": (0.0, 0.0),
    "nearly no spring": (1e3, 1e-10),
}

LENGTHS = (1e-6, 2.5e-3, 0.1, 1.0, 30.0)


def reference(c: float, w: float, omega: float, s: float) -> list[mp.mpf]:
    """Give y, y_d, Y, YY, R, P by the exponential of a matrix in 60 digits."""
    with mp.workdps(60):
        step = mp.matrix(
            [[0, 1, 0, 0], [-mp.mpf(w), -mp.mpf(c), 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
        )
        ramp = mp.expm(step * mp.mpf(s))
        step[3, 2] = -(mp.mpf(omega) ** 2)
        wave = mp.expm(step * mp.mpf(s))
        return [ramp[0, 1], ramp[1, 1], ramp[0, 2], ramp[0, 3], wave[0, 3], wave[0, 2]]


@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("s", LENGTHS)
def test_flow_and_wave_are_right_to_rounding_in_every_regime(
    kernel: SimpleNamespace, regime: str, s: float
) -> None:
    c, w = REGIMES[regime]
    if (c + math.sqrt(w)) * s > 2e3:
        pytest.skip("the reference itself would take minutes")
    omega = math.sqrt(w) or 3.0  # at resonance where there is one
    y, y_d, Y, YY = kernel.oscillator.flow(c, w, s)
    R, P, _, sine, cosine = kernel.oscillator.wave(c, w, omega, s, y, y_d)
    want = reference(c, w, omega, s)
    turns = max(1.0, (c + math.sqrt(w) + omega) * s)
    # A value that crosses zero is measured against its swing: a tenth of that is enough.
    swing = min(s, 1 / c if c else s, s * s * s) / (10 * max(omega, 1 / s) ** 2)
    floors = (min(s, 1 / (omega + c)), 1.0, swing, swing, swing, swing * omega)
    for got, exact, floor in zip((y, y_d, Y, YY, R, P), want, floors, strict=True):
        assert abs(got - float(exact)) <= 2e-15 * turns * max(abs(float(exact)), floor)
    assert sine == pytest.approx(math.sin(omega * s) / omega, abs=1e-15 * turns / omega)
    assert cosine == pytest.approx(math.cos(omega * s), abs=1e-15 * turns)


def test_doubling_a_stretch_is_two_stretches(kernel: SimpleNamespace) -> None:
    c, w, s = 6.7, 100.0, 0.37
    y, y_d, Y, _ = kernel.oscillator.flow(c, w, s)
    y_2, y_d_2, _, _ = kernel.oscillator.flow(c, w, 2 * s)
    assert y_2 == pytest.approx(y * (1 - w * Y + y_d), rel=1e-13)
    assert y_d_2 == pytest.approx(y_d * y_d - w * y * y, rel=1e-13)


@pytest.mark.parametrize("c", [1e3, 1e5, 1e10, 1e15])
@pytest.mark.parametrize("w", [1e-10, 100.0, 1e8])
def test_flow_keeps_its_digits_however_strong_the_damper(
    kernel: SimpleNamespace, c: float, w: float
) -> None:
    # Each doubling had doubled the rounding of y: at c = 1e15 not a digit was left after 1 s.
    if 0.25 * c * c < w:
        pytest.skip("no strong damper")
    with mp.workdps(100):
        kappa = mp.sqrt(mp.mpf(c) ** 2 / 4 - mp.mpf(w))
        slow, fast = mp.mpf(c) / 2 - kappa, mp.mpf(c) / 2 + kappa
        y = (mp.exp(-slow) - mp.exp(-fast)) / (fast - slow)
        y_d = (fast * mp.exp(-fast) - slow * mp.exp(-slow)) / (fast - slow)
        Y = (1 - y_d - mp.mpf(c) * y) / mp.mpf(w)
        YY = (1 - y - mp.mpf(c) * Y) / mp.mpf(w)
        want = [float(exact) for exact in (y, y_d, Y, YY)]
    digits = 1e-14 * max(1.0, float(slow))
    assert kernel.oscillator.flow(c, w, 1.0) == pytest.approx(want, rel=digits, abs=0.0)


@pytest.mark.parametrize("turns", [1e2, 1e4, 1e6])
def test_long_slide_without_spring_and_damper_keeps_its_digits(
    kernel: SimpleNamespace, turns: float
) -> None:
    omega, s = 10.0, turns / 10.0
    found = kernel.oscillator.wave(
        0.0, 0.0, omega, s, *kernel.oscillator.flow(0.0, 0.0, s)[:2]
    )[:3]
    want = (
        (s - math.sin(turns) / omega) / omega**2,
        (1.0 - math.cos(turns)) / omega**2,
        math.sin(turns) / omega,
    )
    for value, exact, swing in zip(found, want, (s / omega**2, 1e-2, 0.1), strict=True):
        assert value == pytest.approx(exact, abs=1e-15 * swing)
