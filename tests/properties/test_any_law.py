"""Scenes of every law and approach at any scale: numbers that close, or a sentence."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import pytest
from seat import SEAT

import drysim
from drysim.errors import DrysimError

FEW, MANY = 40, 400

RADIANS = 400.0
"""How far a scene turns at most, lest it take long."""

CLOSES = 1e-9
"""Energy that may be left over, relative, before a caution has to say so: of a contact far from
the middle of its scale, or of one that nothing moves, rounding is all there is."""

LAWS = ("coulomb", "varying", "stribeck", "jenkins", "petrov-ewins", "dahl", "lugre", "leuven")


def scene(dice: Random) -> dict[str, Any]:
    """Draw mass, frequency, damping, forces, law, base and start over many decades."""
    m, a = 10.0 ** dice.uniform(-6, 9), 10.0 ** dice.uniform(-9, 6)
    omega = dice.choice((0.0, 10.0 ** dice.uniform(-3, 4)))
    k, base = m * omega**2, 10.0 ** dice.uniform(-2, 2) * (omega or 1.0)
    xi = dice.choice((0.0, 1e-4, 0.3, 1 - 1e-8, 1.0, 1 + 1e-8, 30.0))
    steps = dice.choice((3, 50, 400))
    span = min(20.0, RADIANS / max(omega, base) / dice.choice((1, 10))) * 2 * math.pi / base
    span = min(span, RADIANS / max(omega * (1 + xi), base))
    F = m * a * dice.choice((0.01, 0.3, 2 / math.sqrt(4 + math.pi**2), 0.999, 1.0, 3.0))
    x_r = dice.choice((0.0, F / k if k else a / base**2, -a / base**2))
    return {
        "oscillator": {"mass": m, "stiffness": k, "damping": 2 * xi * m * (omega or base)},
        "friction": law(dice, F, m, max(omega, base), base),
        "start": {"x_r": x_r, "v_r": dice.choice((0.0, a / base, -1e-12 * a / base))},
        "solver": {"step": span / steps},
        **motion(dice, a, base, span, steps),
    }


def law(dice: Random, F: float, m: float, omega: float, base: float) -> dict[str, Any]:
    """Draw a law whose contact, where it is a spring, turns about as fast as the scene."""
    name, ratio = dice.choice(LAWS), dice.choice((1.0, 1 + 1e-7, 1.2, 30.0))
    stiffness, speed = m * omega**2 * 10.0 ** dice.uniform(-2, 2), F / (m * base)
    limits = {"kinetic": F, "static_ratio": ratio, "stribeck_velocity": speed}
    wave = {"amplitude": dice.choice((0.3, 0.999)), "frequency": base / 7}
    return {
        "coulomb": {"law": "coulomb", "kinetic": F, "static_ratio": ratio},
        "varying": {"law": "coulomb", "kinetic": F, "normal_variation": wave},
        "stribeck": {"law": "stribeck", **limits, "exponent": dice.choice((1, 2))},
        "jenkins": {"law": "jenkins", "kinetic": F, "tangential_stiffness": stiffness},
        "petrov-ewins": {
            "law": "petrov-ewins", "mu_kinetic": 0.3, "normal": F,
            "normal_stiffness": stiffness, "tangential_stiffness": stiffness,
            "normal_motion": {"amplitude": 2 * F / stiffness, "frequency": base / 9},
        },
        "dahl": {"law": "dahl", "kinetic": F, "bristle_stiffness": stiffness},
        "lugre": {
            "law": "lugre", **limits, "bristle_stiffness": stiffness,
            "bristle_damping": dice.choice((0.0, m * omega)),
        },
        "leuven": {
            "law": "leuven", **limits, "bristle_stiffness": stiffness, "bristle_damping": 0.0,
        },
    }[name]  # fmt: skip


def motion(
    dice: Random, a: float, base: float, span: float, steps: int
) -> dict[str, dict[str, Any]]:
    """Draw a base that is known as sines, or by samples."""
    f = base / (2 * math.pi)
    window = {"steady": False, "settle": 0, "duration": span}
    noise = {"kind": "psd", "points": [[1 / span, 1], [0.4 * steps / span, 1]]}
    sines = [{"frequency": f, "amplitude": a}, {"frequency": 2.7 * f, "amplitude": 0.3 * a}]
    return dice.choice(
        (
            {"excitation": {"kind": "harmonic", "frequency": f, "amplitude": a},
             "measure": window},
            {"excitation": {"kind": "sines", "components": sines}, "measure": window},
            {"excitation": {"kind": "rest"}, "measure": window},
            {"excitation": {**noise, "duration": span, "rms": a, "seed": 3}, "measure": None},
        )
    )  # fmt: skip


def tried(number: int, file: Path) -> str:
    """Run a drawn scene; gives what became of it."""
    try:
        outcome = drysim.run(drysim.load(file, scene(Random(number))))
    except DrysimError as fault:
        return type(fault).__name__
    known = {k: v for k, v in outcome.metrics.items() if v is not None}
    assert all(math.isfinite(value) for value in known.values()), (number, known)
    slugs = {caution.slug for caution in outcome.warnings}
    assert known["energy_residual"] < CLOSES or "energy-open" in slugs, (number, known)
    return "energy-open" if "energy-open" in slugs else "run"


@pytest.mark.parametrize("many", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_scene_of_any_law_and_scale_runs_or_is_refused_in_a_sentence(many, tmp_path):
    file = tmp_path / "seat.yaml"
    file.write_text(SEAT)
    ends = Counter(tried(number, file) for number in range(many))
    assert ends["run"] > 0.7 * many, ends
    assert ends["energy-open"] <= 0.05 * many, ends
