"""Optimal damping and stiffness under white noise, which is known without any motion.

Of a linear mount the RMS values follow from the spectrum by quadrature. Of ideal white noise
the optimum over the damping is at ζ = 1/2, and at fixed RMS stroke over damping and stiffness
at ζ = 1/√2; the base here ends at 60 Hz, so the optima are a little higher.
"""

from __future__ import annotations

import numpy as np
import pytest

import drysim

M, STEP, LOW, HIGH = 75.0, 1e-3, 0.02, 60.0
SCENE = f"""
oscillator: {{mass: {M}, stiffness: 7500, damping: 500}}
excitation:
  kind: psd
  points: [[{LOW} Hz, 1], [{HIGH} Hz, 1]]
  rms: 1
  duration: 60 s
  seed: 1
  seeds: 40
solver: {{step: {STEP}}}
measure: {{settle: 10 s}}
"""
f = np.geomspace(LOW, HIGH, 200_001)
w = 2.0 * np.pi * f
# Samples joined by straight lines have less power at high frequency.
POWER = np.sinc(f * STEP) ** 4 / (HIGH - LOW)


def rms(b, k_x):
    """Return the RMS of x_dd [m/s²] and of x_r [m]."""
    from scipy.integrate import trapezoid

    away = (k_x - M * w**2) ** 2 + (b * w) ** 2
    transferred = (k_x**2 + (b * w) ** 2) / away, M**2 / away
    return tuple(np.sqrt(trapezoid(one * POWER, f)) for one in transferred)


def least(function, low, high):
    """Return the argument and the value of the minimum over a logarithmic range."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda x: function(np.exp(x)),
        bounds=np.log([low, high]), method="bounded", options={"xatol": 1e-9},
    )  # fmt: skip
    return np.exp(found.x), found.fun


@pytest.mark.slow
def test_best_damping_under_white_noise_lies_within_the_stated_interval():
    exact, _ = least(lambda b: rms(b, 7500.0)[0], 100.0, 5000.0)
    assert exact / (2.0 * np.sqrt(7500.0 * M)) == pytest.approx(0.5, rel=0.02)
    vary = {"oscillator.damping": {"from": 100, "to": 5000, "scale": "log"}}
    study = {"design": {"vary": vary, "minimise": "a_x"}}
    result = drysim.design(drysim.scenario(SCENE, study))
    low, high = result.optimum.ends["oscillator.damping"]
    assert result.converged
    assert low < exact < high
    assert high / low < 1.03


@pytest.mark.slow
def test_best_mount_at_fixed_stroke_lies_within_the_stated_intervals():
    from scipy.optimize import brentq

    stroke = 5e-3

    def stiffness(b):
        return brentq(lambda k_x: rms(b, k_x)[1] - stroke, 10.0, 5e5)

    b, _ = least(lambda b: rms(b, stiffness(b))[0], 200.0, 4000.0)
    exact = {"oscillator.damping": b, "oscillator.stiffness": stiffness(b)}
    assert b / (2.0 * np.sqrt(stiffness(b) * M)) == pytest.approx(np.sqrt(0.5), rel=0.03)
    vary = {
        "oscillator.damping": {"from": 200, "to": 4000, "scale": "log"},
        "oscillator.stiffness": {"from": 1000, "to": 50000, "scale": "log"},
    }
    study = {"vary": vary, "minimise": "a_x", "within": [f"x_r_rms < {stroke}"]}
    result = drysim.design(drysim.scenario(SCENE, {"design": study}))
    assert [str(one.limit) for one in result.binding] == [f"x_r_rms < {stroke}"]
    for key, (low, high) in result.optimum.ends.items():
        assert low < exact[key] < high, key
        assert high / low < 1.05
