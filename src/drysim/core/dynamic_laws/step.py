"""One step of a motion under a dynamic law: its series, and how far that is used."""

from __future__ import annotations

from drysim.core.compiled import inlined
from drysim.core.dynamic_laws.jet import grow
from drysim.core.dynamic_laws.memory import branch_end
from drysim.core.dynamic_laws.settled import STIFF, settle, settling_rate
from drysim.core.plant import LEUVEN, STRIBECK
from drysim.core.samples.foresight import first_zero, followed, foreseen
from drysim.core.samples.stop import NEVER

LONGEST_WAIT = 31
"""Steps at most before bristles that had not settled are asked again."""


@inlined
def begin(
    plant, law, jet, d, x_r, v_r, z, creeps, left, calm, wish, v_least, z_least, pause, wait
):
    """Set the series of a step: of settled bristles where they have, else of all that moves.

    Parameters
    ----------
    plant, law, jet, x_r, v_r, z, v_least, z_least
        As in `grow`.
    d : int
        Direction as in `Trail`.
    creeps : bool
        Whether the mass is too slow for friction to have fallen.
    left, calm, wish : float
        What is left of the interval, what is short beside the oscillator's own times, and the
        length that is wished for [s].
    pause, wait : int
        Steps before bristles are asked again whether they have settled: still, and in all.

    Returns
    -------
    last, step, rounds, pause, wait
        Last term, length for which the series holds [s], and rounds of settled bristles.
    """
    way = 1 if d >= 0 else -1
    if law.kind != STRIBECK and settling_rate(law, v_r, z) * calm > STIFF:
        if pause == 0:
            last, step, rounds = settle(
                plant, law, jet, way, x_r, v_r, z, left, v_least, z_least
            )
            if rounds > 0:
                return last, step, rounds, 0, 0
            wait = min(2 * wait + 1, LONGEST_WAIT)
            pause = wait
        else:
            pause -= 1
    poised = d == 0 or abs(d) == 2
    last, step = grow(
        plant, law, jet, way, x_r, v_r, z, poised, creeps, min(left, wish), v_least, z_least
    )
    return last, step, 0, pause, wait


@inlined
def extent(plant, law, jet, last, way, step, settled, creeps, slow, v_least):
    """Give how far a series is used [s], and what ends it there.

    Parameters
    ----------
    plant, law, jet, last, way, step
        The series up to its last term, the direction, and the length for which it holds [s].
    settled, creeps : bool
        Whether it is one of settled bristles, or of a mass too slow for friction to fall.
    slow : float
        Speed within which it creeps [m/s].
    v_least : float
        What may be neglected [m/s].

    Returns
    -------
    step, stop, end, what
        Length [s]; when v_r is zero and when a branch of the bristles ends, or infinity; and
        what ends it, as in `branch_end`.
    """
    step = foreseen(law, jet, last, way, step, slow)
    stop = first_zero(jet.v, last, way, step)
    if settled and stop != NEVER:
        step, stop = 0.5 * stop, NEVER
    end, what = NEVER, 0
    if law.kind == LEUVEN:
        end, what = branch_end(law, jet, last, way, min(stop, step))
    seen = min(stop, end, step)
    if not creeps:
        seen = followed(plant, law, jet, last, way, seen, v_least)
    if seen < min(stop, end):
        return min(seen, step), NEVER, NEVER, 0
    return step, stop, end, what
