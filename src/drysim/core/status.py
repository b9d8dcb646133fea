"""Why a kernel ends early: one enumeration, whose members carry the message.

A kernel has no exceptions. It returns a `Status` where it would return a count: of the events
of a motion, or of the periods of an orbit. A count is never negative, all faults are.
"""

from __future__ import annotations

from enum import IntEnum

from drysim.errors import SolverError


class Status(IntEnum):
    """Outcome of a kernel: 0, or the reason why there is no motion or no orbit.

    Attributes
    ----------
    message : str
        What happened, as a format of the time t [s] and of other numbers.
    hint : str
        What to do about it.
    """

    message: str
    hint: str

    def __new__(cls, code: int, message: str = "", hint: str = "") -> Status:
        """Return a member with its message."""
        member = int.__new__(cls, code)
        member._value_, member.message, member.hint = code, message, hint
        return member

    OK = 0
    NO_PROGRESS = (
        -1,
        "at t = {t:.9g} s events do not advance in time",
        "check friction and stiffness for values near the limits of double precision",
    )
    CROWDED_STEP = (
        -2,
        "at t = {t:.9g} s more than {count} events fall within a step of {step:.9g} s",
        "use a shorter step, or check mass, stiffness and friction: the mass reverses many "
        "times within a step",
    )
    MANY_EVENTS = (
        -3,
        "too many events: {count} by t = {t:.9g} s",
        "use a shorter duration, or check the scene: a mass with little loss chatters at a "
        "rigid stop (reduce the restitution or use bumpers), and a normal force that varies "
        "causes events in every period (check its frequency)",
    )
    OVERFLOW = (
        -4,
        "the motion overflows by t = {t:.9g} s",
        "check the units of the base motion and of the oscillator",
    )
    NOT_SETTLED = -5, "the motion still changes after {t:.6g} s"
    NOT_UNIQUE = -6, "the orbit is neutrally stable and not unique"
    LOG_FULL = -7, "more events in a repetition of the orbit than the log of a block holds"

    def sentence(self, **numbers: float) -> str:
        """Return the message with its numbers, t [s] and those that it names besides."""
        return self.message.format(**numbers)

    def error(self, **numbers: float) -> SolverError:
        """Return the error to raise; parameters as in `sentence`."""
        return SolverError(self.sentence(**numbers), self.hint)


NO_PROGRESS, CROWDED_STEP = int(Status.NO_PROGRESS), int(Status.CROWDED_STEP)
OVERFLOW, NOT_SETTLED = int(Status.OVERFLOW), int(Status.NOT_SETTLED)
NOT_UNIQUE, LOG_FULL = int(Status.NOT_UNIQUE), int(Status.LOG_FULL)
"""Members as the integers that kernels return: numba gives an enumeration a type of its own."""
