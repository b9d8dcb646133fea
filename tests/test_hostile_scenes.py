"""Scenes that a sceptic keeps aside: stops, parting surfaces, laws at the ends of their keys.

Each ends in numbers whose energy closes, or in a sentence that names the key.
"""

from __future__ import annotations

import math

import pytest

import drysim
from drysim.errors import DrysimError

CLOSES = 1e-10

STEADY = {"measure": {"steady": True}}
NOISE = {"kind": "psd", "points": [[0.8, 1], [4, 1]], "duration": 4, "seed": 1}
SHOCK = {"kind": "shock", "pulse": "half-sine", "amplitude": 1e5, "duration": 0.01}
BLOCK = {"oscillator": {"mass": 75, "stiffness": 0, "damping": 0}}


def stops(limit: float = 0.01, **words: float) -> dict[str, object]:
    return {"stroke": {"limit": limit, "stops": words}}


def lifting(amplitude: float, frequency: float, phase: float = 0.0) -> dict[str, object]:
    varied = {"amplitude": amplitude, "frequency": frequency, "phase": phase}
    return {"friction": {"law": "coulomb", "kinetic": 30, "normal_variation": varied}}


def law(name: str, **words: float) -> dict[str, object]:
    return {"friction": {"law": name, "kinetic": 45, **words}}


def sines(*phases: float) -> dict[str, object]:
    every = [{"frequency": 1.6, "amplitude": 1.0, "phase": phase} for phase in phases]
    return {"excitation": {"kind": "sines", "components": every}}


SOLVED = {
    "sines that cancel, and no friction": sines(0.0, math.pi) | {"friction": None} | STEADY,
    "sines that nearly cancel, and no friction": sines(0.0, math.pi - 1e-12)
    | {"friction": None}
    | STEADY,
    "rigid stop that keeps no speed": stops(restitution=0) | STEADY,
    "rigid stop that keeps all of it": stops(restitution=1),
    "rigid stop next to nothing away": stops(1e-12, restitution=0.3),
    "rigid stop and no spring": stops(restitution=0.3) | BLOCK,
    "rigid stop under a shock at once": stops(restitution=0.5) | {"excitation": SHOCK},
    "rigid stop under noise": stops(restitution=0.5) | {"excitation": NOISE, "measure": {}},
    "rigid stop that the start is thrown at": stops(restitution=0.9)
    | {"start": {"x_r": 0.01, "v_r": 1.0}},
    "rigid stop and a strong swing of the limits": stops(restitution=0.3) | lifting(0.99, 3.2),
    "bumper as hard as a diamond": stops(stiffness=1e12) | STEADY,
    "bumper as soft as air": stops(stiffness=1e-12),
    "bumper of pitch": stops(stiffness=1e5, damping=1e9),
    "bumper squeezed by a metre": stops(stiffness=1e5) | {"start": {"x_r": 1.01}},
    "mass of a microgram between stops": stops(restitution=0.3)
    | {"oscillator": {"mass": 1e-9, "stiffness": 1e-7, "damping": 1e-9}}
    | {"friction": {"law": "coulomb", "kinetic": 1e-10}},
    "surfaces that just do not press": lifting(1.0, 4.0),
    "surfaces that just part, in step with the base": STEADY
    | lifting(math.nextafter(1.0, 2.0), 1.6),
    "surfaces that part as the motion begins": lifting(1.0, 3.0, -math.pi / 2),
    "surfaces that are apart half of the time": lifting(1e9, 4.0),
    "surfaces that part under a shock": lifting(1.5, 3.0) | {"excitation": SHOCK},
    "surfaces that part, and no spring": lifting(1.5, 3.0) | BLOCK,
    "contact as soft as air": law("jenkins", tangential_stiffness=1e-12),
    "contact as hard as a diamond": law("jenkins", tangential_stiffness=1e12),
    "bristles as soft as air": law("dahl", bristle_stiffness=1e-12),
    "bristles as hard as a diamond": law("dahl", bristle_stiffness=1e12),
    "curve that never falls": law("stribeck", static_ratio=1.2, stribeck_velocity=1e12),
    "bristles that never slide fast enough": law(
        "lugre", static_ratio=1.2, stribeck_velocity=1e12, bristle_stiffness=1e5,
        bristle_damping=0,
    ),
    "base of ten kilohertz": {"excitation.frequency": 1e4, "measure": {"duration": 0.1}},
    "damper of pitch": {"oscillator.damping": 1e9},
    "friction next to none": {"friction.kinetic": 1e-30},
    "friction beyond measure": {"friction.kinetic": 1e30},
    "base that hardly moves": {"excitation.rms": 1e-30, "friction.kinetic": 1e-29},
}  # fmt: skip


@pytest.mark.parametrize("words", SOLVED.values(), ids=SOLVED)
def test_scene_at_the_end_of_its_keys_closes_its_energy(seat, words):
    outcome = drysim.run(drysim.load(seat, words))
    known = {name: value for name, value in outcome.metrics.items() if value is not None}
    assert all(math.isfinite(value) for value in known.values()), known
    assert known["energy_residual"] < CLOSES
    limit = words.get("stroke")
    if limit is not None and "restitution" in limit["stops"]:
        assert known["x_r_peak"] <= limit["limit"]


@pytest.mark.parametrize(("phases", "A"), [((0.3, 0.3), 2.0), ((0.0, math.pi / 2), 2**0.5)])
def test_sines_of_one_frequency_are_one_sine(seat, phases, A):
    one = {"kind": "harmonic", "frequency": 1.6, "amplitude": A, "phase": sum(phases) / 2}
    found = [
        drysim.run(drysim.load(seat, STEADY | words)).metrics
        for words in (sines(*phases), {"excitation": one})
    ]
    assert found[0]["T_a"] == pytest.approx(found[1]["T_a"], rel=1e-12)
    assert found[0]["a_u"] == pytest.approx(found[1]["a_u"], rel=1e-14)


def test_sines_of_one_frequency_are_one_sine_in_a_sweep_of_one_amplitude(seat):
    words, key = STEADY | sines(0.3, 1.1), "excitation.components.1.amplitude"
    table = drysim.sweep(drysim.load(seat, words | {"sweep": {key: [0.0, 0.5, 1.0]}}))
    for row in table:
        alone = drysim.run(drysim.load(seat, words | row.point)).metrics
        assert row.metrics["T_a"] == pytest.approx(alone["T_a"], rel=1e-12)


REFUSED = {
    "no room": (stops(0, restitution=0.3), "stroke.limit must be above 0 m, not 0"),
    "bumper that is none": (stops(stiffness=0), "stroke.stops.stiffness must be above 0 N/m"),
    "bumper that pulls": (
        stops(stiffness=1e5, damping=-1),
        "stroke.stops.damping must be at least 0 N·s/m, not -1",
    ),
    "stop that speeds up": (stops(restitution=1.1), "stops.restitution must be at most 1"),
    "stop of two kinds": (
        stops(stiffness=1, restitution=1),
        "give restitution or stiffness, not both",
    ),
    "start beyond a rigid stop": (
        stops(restitution=0.3) | {"start": {"x_r": 0.02}},
        "as rigid stops let the mass no further",
    ),
    "stops for bristles": (
        stops(restitution=0.3) | law("dahl", bristle_stiffness=1e5),
        "end stops go with Coulomb's friction only",
    ),
    "damping that drives": ({"oscillator.damping": -1}, "damping must be at least 0 N·s/m"),
    "surfaces that pull": (lifting(-1.0, 4.0), "amplitude must be at least 0, not -1"),
    "load without a period": (lifting(1.5, 0.0), "frequency must be above 0 Hz, not 0"),
    "load without a common period": (
        lifting(1.5, 1.6180339887) | STEADY,
        "needs a common period",
    ),
    "contact that holds nothing": (
        law("jenkins", tangential_stiffness=0),
        "tangential_stiffness must be above 0 N/m, not 0",
    ),
    "curve without width": (
        law("stribeck", stribeck_velocity=0),
        "stribeck_velocity must be above 0 m/s, not 0",
    ),
    "bristles of pitch": (
        law("lugre", stribeck_velocity=0.01, bristle_stiffness=1e5, bristle_damping=1e12),
        "h of work; check the units",
    ),
    "force in digits of another script": (
        {"friction.kinetic": "１５"},
        "friction.kinetic must be a number [N]",
    ),
}


@pytest.mark.parametrize(("words", "sentence"), REFUSED.values(), ids=REFUSED)
def test_scene_beyond_its_keys_is_refused_in_a_sentence(seat, words, sentence):
    with pytest.raises(DrysimError) as fault:
        drysim.run(drysim.load(seat, words))
    (problem,) = fault.value.problems
    assert sentence in problem.sentence


@pytest.mark.parametrize(
    ("near", "contacts"),
    [(1 - 1e-9, {2}), (1 - 1e-15, {0, 2}), (1.0, {0, 2}), (1 + 1e-15, {0, 2}), (1 + 1e-9, {0})],
)
def test_bumper_that_an_orbit_just_reaches_is_hardly_felt(seat, near, contacts):
    free = drysim.run(drysim.load(seat, STEADY)).metrics
    bumper = stops(near * free["x_r_peak"], stiffness=1e6, damping=10)
    met = drysim.run(drysim.load(seat, bumper | STEADY)).metrics
    assert met["contacts"] in contacts
    assert met["T_a"] == pytest.approx(free["T_a"], rel=1e-6)
