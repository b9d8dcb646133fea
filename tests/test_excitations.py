"""Contract of every excitation, and tests of sines in particular."""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import get_args

import numpy as np
import pytest
from pydantic import BaseModel, ValidationError

from drysim.block import field_descriptions
from drysim.core.model import Samples, Sines
from drysim.excitation import EXCITATIONS, Excitation
from drysim.excitation.harmonic import Harmonic, Rest, Shock, SineSum
from drysim.quantity import Quantity

WORDS = {
    "rest": {},
    "harmonic": {"frequency": 1.6, "rms": 1.0},
    "sines": {"components": [{"frequency": 1, "amplitude": 2}, {"frequency": 3, "rms": 1}]},
    "sweep": {"from": 1, "to": 5, "rms": 1, "duration": 10},
    "shock": {"pulse": "half-sine", "amplitude": 30, "duration": 0.2},
    "psd": {"points": [[1, 1], [5, 1]], "duration": 10, "seed": 1},
    "standard": {"class": "EM1", "duration": 10, "seed": 1},
    "road": {"class": "B", "speed": 5, "duration": 10, "seed": 1},
    "record": {"file": "base.csv", "column": 2, "time": 1},
}


@pytest.fixture(params=EXCITATIONS, ids=lambda member: member.__name__)
def member(request, tmp_path):
    """Return an excitation of every kind."""
    (tmp_path / "base.csv").write_text("t [s],u_dd [m/s2]\n0,0\n0.1,1\n0.2,0\n")
    kind = get_args(request.param.model_fields["kind"].annotation)[0]
    words = {"kind": kind, **WORDS[kind]}
    return request.param.model_validate(words, context={"folder": tmp_path})


def test_shelf_and_type_name_the_same_members():
    assert set(EXCITATIONS) == set(get_args(Excitation))


def test_motion_is_sines_or_samples_of_frozen_keys_and_no_others(member):
    assert isinstance(member.motion(0.01), Sines | Samples)
    with pytest.raises(ValidationError, match="frozen"):
        member.kind = "other"
    with pytest.raises(ValidationError, match="Extra inputs are not permitted"):
        type(member).model_validate({**member.model_dump(exclude_none=True), "colour": "red"})


def test_every_field_is_documented_and_says_its_unit(member):
    texts = field_descriptions(type(member))
    for name, field in type(member).model_fields.items():
        assert texts[name]
        for unit in (part.unit for part in field.metadata if isinstance(part, Quantity)):
            assert f"[{unit or '-'}]" in texts[name], name


def test_excitation_says_what_it_should_not_be_confused_with(member):
    assert isinstance(member, BaseModel)
    assert "Not to be confused with" in (type(member).__doc__ or "")


@pytest.mark.parametrize(
    ("kind", "words", "motion"),
    [
        (Rest, {"kind": "rest"}, Sines((), (), ())),
        (Harmonic, {"kind": "harmonic", "frequency": 1.6, "rms": 0.5, "phase": "90 deg"},
         Sines((sqrt(2) * 0.5,), (1.6,), (pi / 2,))),
        (Harmonic, {"kind": "harmonic", "frequency": "96 rpm", "amplitude": "0.05 g"},
         Sines((0.4903325,), (1.6,), (0.0,))),
        (SineSum, {"kind": "sines", **WORDS["sines"]}, Sines((2, sqrt(2)), (1, 3), (0, 0))),
    ],
)  # fmt: skip
def test_sines_have_the_amplitude_or_rms_that_is_given_in_their_order(kind, words, motion):
    assert kind.model_validate(words).motion() == motion


@pytest.mark.parametrize("pulse", ["half-sine", "haversine", "sawtooth", "trapezoid"])
@pytest.mark.parametrize(
    ("start", "duration"), [(1e30, 0.2), (1e9, 0.2), (0.1, 1e30), (1e20, 1e20), (0.15, 0.2)]
)
def test_pulse_beyond_the_run_takes_no_memory_and_is_said_to_be_cut(pulse, start, duration):
    def shock(**keys):
        return Shock(kind="shock", pulse=pulse, amplitude=30.0, **keys).motion(0.01, 0.2)

    found = shock(start=start, duration=duration)
    assert len(found.u_dd) == 21
    assert [warning.slug for warning in found.warnings if warning.slug == "pulse-cut"]
    if start >= 1.0:
        assert not found.u_dd[:].any()
    # What a longer run begins with is the same.
    if start + duration < 1.0:
        whole = Shock(kind="shock", pulse=pulse, amplitude=30.0, start=start, duration=duration)
        assert np.array_equal(found.u_dd, whole.motion(0.01, 1.0).u_dd[:21])


def test_phase_of_any_size_leaves_an_exact_motion():
    for turns in (1.0, 1e4, 3e18):
        phase = 2.0 * pi * turns + 1.0
        wave = Harmonic(kind="harmonic", frequency=2.0, amplitude=3.0, phase=phase)
        (reduced,) = wave.motion().phase
        assert abs(reduced) <= 2.0 * pi
        assert sin(reduced) == pytest.approx(sin(phase), abs=1e-15)
        assert cos(reduced) == pytest.approx(cos(phase), abs=1e-15)
