"""Changes of the core that `mutate.py` makes and no test can notice, each with its reason."""

from __future__ import annotations

GUESS = "a first guess only: the guarded method behind it arrives all the same, or says so"
EDGE = "the bound holds F_fs with its rounding: nothing in the physics lies on its very edge"
NAME = "a number that stands for a word: any that no other word has will do"
FIRST = "a name has a number before it has its own, and nobody reads it"
ORDER = "both of two times are found, whichever is looked for first: that is chosen for speed"
SPARE = "the last lines of trail and log are held in reserve: one more is free"

EXPLAINED = {
    (
        "dynamic.py",
        "return (math.sqrt(FLAT) if law.exponent == -2 else FLAT ** (1.0 / law.exponent)) "
        "* law.v_s",
    ): "a square root is a power, too, and is written for its speed",
    ("touch.py", "if stalled >= STALL:"): "a hundred events without progress are as many",
    (
        "touch.py",
        "kind = LIFT if mode == FREE else (STICK if holds(mode) else mode / SLIP)",
    ): "a slip is the number 1",
    ("contact.py", "while n <= end and at <= full and count < full:"): SPARE,
    ("contact_replay.py", "c, w, g, r = 1.0, 0.0, 0.0, 0.0"): FIRST,
    (
        "contact_replay.py",
        "s = s + length if length < hi + s else hi",
    ): "the last panel ends where it should but for rounding, and that adds nothing",
    (
        "contact_replay.py",
        "if s != 1.0:",
    ): "at its own beginning the flow gives what is written there, to rounding",
    ("eventful.py", "if abs(F_L) < holding_force(plant, law, x_r):"): EDGE,
    ("flow.py", "if rate > -0.0625:"): "more terms of a series than double precision shows",
    (
        "integrals.py",
        "if until <= begin or until < t[i]:",
    ): "a stretch without length adds nothing",
    (
        "holding.py",
        "turns = not yields or far_from_zero(fills, fill_most, of_room, h - now.s)",
    ): (ORDER),
    ("holding.py", "if not (turns and yields):"): ORDER,
    (
        "holding.py",
        "if step < RESOLUTION * now.s:",
    ): "a step of nothing at the start ends a few lines on, where a value is zero",
    ("integrals.py", "length = min(panel_length(own[0], own[-1], waves, s), hi - s)"): (
        "the last of two is the second"
    ),
    (
        "jet.py",
        "return n + -1, h",
    ): "the last of three terms in a row that are within the tolerance may go",
    ("law.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, -3, 4"): NAME,
    ("law.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, -4"): NAME,
    ("orbit.py", "if events <= 0 or events + ROOM >= capacity:"): (
        "a log that is full to the last line stands for one that is too small"
    ),
    ("orbit.py", "scale = peak if peak > 0.0 else -1.0"): (
        "a mass that has not moved changes by nothing, whatever that is compared to"
    ),
    (
        "orbits.py",
        "answer[STATUS] = STORM if count < 0 else (CROWDED if reached <= length else OVERFLOW)",
    ): ("a crowded case is solved once more by itself, and that says what it is"),
    ("series.py", "square = q[1] * q[1] + 4.0 * q[0] * q[2]"): GUESS,
    ("steps.py", "bend * dt, bend * (0.25 * c - w * dt) * dt,"): (
        "a bound that is wider than need be: a spring bends a velocity above zero downwards, "
        "and dips come of bends upwards"
    ),
    ("turns.py", "if t[middle] < at:"): "two stretches have one state where they meet",
    ("stop.py", "square = a * a + 2.0 * v * (r - c * a - w * v)"): GUESS,
}
"""By file and line as changed."""
