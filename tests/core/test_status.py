"""Status of a kernel: the codes cannot be counts, and every fault has a message."""

from __future__ import annotations

import math

import pytest

from drysim.approach.progress import check_progress
from drysim.core import status
from drysim.core.events import MAX_EVENTS_PER_STEP
from drysim.core.status import Status
from drysim.errors import SolverError

FAULTS = [member for member in Status if member is not Status.OK]
NUMBERS = {"t": 1.25, "step": 0.005, "count": 7}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_no_count_and_its_message_takes_the_numbers(fault):
    assert fault < 0 <= Status.OK
    sentence = fault.sentence(**NUMBERS)
    assert sentence
    assert "{" not in sentence
    error = fault.error(**NUMBERS)
    assert isinstance(error, SolverError)
    assert (error.message, error.hint) == (sentence, fault.hint)


def test_kernels_return_the_codes_of_the_members():
    named = {name: getattr(status, name) for name in dir(status) if name.isupper()}
    assert named == {name: Status[name] for name in named}
    assert all(type(code) is int for code in named.values())


@pytest.mark.parametrize(
    ("count", "state", "sentence"),
    [
        (status.NO_PROGRESS, (0.0, 0.0), "at t = 2 s events do not advance in time"),
        (
            status.CROWDED_STEP,
            (0.0, 0.0),
            f"at t = 2 s more than {MAX_EVENTS_PER_STEP} events fall within a step of 0.01 s",
        ),
        (status.NO_PROGRESS, (math.nan, 0.0), "at t = 2 s events do not advance in time"),
        (3, (math.nan, 0.0), "the motion overflows by t = 2 s"),
        (0, (0.0, math.inf), "the motion overflows by t = 2 s"),
    ],
)
def test_the_fault_of_a_march_is_raised_with_its_time(count, state, sentence):
    with pytest.raises(SolverError) as raised:
        check_progress(count, 2.0, state, 0.01)
    assert raised.value.message == sentence
    assert raised.value.hint


def test_a_count_and_a_finite_state_are_no_fault():
    check_progress(0, 2.0, (1.0, -1.0))
