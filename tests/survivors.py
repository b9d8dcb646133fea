"""Changes of the core that `mutate.py` makes and no test can notice, each with its reason."""

from __future__ import annotations

GUESS = "a first guess only: the guarded method behind it arrives all the same, or says so"
EDGE = "the bound holds F_fs with its rounding: nothing in the physics lies on its very edge"
NAME = "a number that stands for a word: any that no other word has will do"
FIRST = "a name has a number before it has its own, and nobody reads it"
BUILT = "how a kernel is built changes its speed alone, which no test takes"
LAST = "the last terms of a series are there to fall below rounding"
SLOWER = "what is not told here is found by the general way, which takes longer"
STEADIER = "a response is found from rest or from the steady one, both exactly"
NEITHER = "both times are alike where neither comes: a force exceeds one limit at a time"
SPARE = "the last lines of trail and log are held in reserve: one more is free"

EXPLAINED = {
    (
        "dynamic.py",
        "return (math.sqrt(FLAT) if law.exponent == -2 else FLAT ** (1.0 / law.exponent)) "
        "* law.v_s",
    ): "a square root is a power, too, and is written for its speed",
    ("touch.py", "while n <= end and at <= full and count < full:"): SPARE,
    ("touch.py", "if stalled >= STALL:"): "a hundred events without progress are as many",
    (
        "touch.py",
        "kind = LIFT if mode == FREE else (STICK if holds(mode) else mode / SLIP)",
    ): "a slip is the number 1",
    ("cease.py", "if low > 1.0:"): "a step that is shorter than it might be is as safe",
    ("cease.py", "return h - h * h * h * k / (6.0 * a - (6.0 * j + 3.0 * k * h) * h)"): (
        "a part of fourth order, and the search ends where all of that order is nothing"
    ),
    ("cease.py", "fastest = 1.0"): "a step that is shorter than it might be is as safe",
    (
        "compiled.py",
        'return jit(plain, "fused", forceinline=False, fastmath={"contract"})',
    ): BUILT,
    (
        "compiled.py",
        "return function if is_plain() else jit(function, forceinline=False)",
    ): BUILT,
    (
        "compiled.py",
        "return function if is_plain() else jit(function, forceinline=True)",
    ): BUILT,
    (
        "compiled.py",
        'kernel = make(nogil=True, error_model="numpy", _nrt=True, **options)(function)',
    ): BUILT,
    (
        "contact.py",
        "if waves.values[at + STEADY] > 0.0 and SLOW * waves.values[at + OMEGA] ** -2 <= w:",
    ): STEADIER,
    (
        "contact.py",
        "if waves.values[at + STEADY] > 0.0 and SLOW / waves.values[at + OMEGA] ** 2 <= w:",
    ): STEADIER,
    (
        "contact.py",
        "return (way if bent and law.k_t * way * v_r >= rate else HOLD), x_0",
    ): "one that is as fast as its limit yields now or at the next instant",
    ("contact.py", "return sign(v_r) if law.k_t * abs(v_r) >= rate else HOLD"): (
        "one that is as fast as its limit yields now or at the next instant"
    ),
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
    ("foresight.py", "if slow > 0.0 and d * v < slow:"): (
        "no speed is the one from which friction has fallen to the last bit"
    ),
    ("grid.py", "anchor(waves, plant, law, t[0], 1.0)"): (
        "a table holds what a wave of amplitude 1 does: the direction of friction is not in it"
    ),
    ("hit.py", "s = gap / v if 0.0 < gap < v * h else 0.5 / h"): GUESS,
    ("hit.py", "bend = (value_end - value + rate * h) * per_h * per_h"): GUESS,
    ("hit.py", "if not 1.0 < s <= steps.dt:"): SLOWER,
    (
        "hit.py",
        "return s + step, way, v_s + step * (a_s + step * (0.5 * j_s + step * k_s / -6.0))",
    ): LAST,
    ("holding.py", "if t <= s:"): NEITHER,
    (
        "holding.py",
        "gap = reach * normal_force(law, waves, 1.0)[0] - way * (stretch.x_r - x_0)",
    ): "whether the mass swings to the limit is guessed: that tells only where to look first",
    ("holding.py", "if peak > clear:"): SLOWER,
    (
        "holding.py",
        "if far_from_zero(course, most_twist(room, stretch.w, now, bound), bound, "
        "until + begin):",
    ): SLOWER,
    ("integrals.py", "length = min(panel_length(own[0], own[-1], waves, s), hi - s)"): (
        "the last of two is the second"
    ),
    (
        "jet.py",
        "return n + -1, h",
    ): "the last of three terms in a row that are within the tolerance may go",
    ("load.py", "if not falling and load >= 0.0 and load_d >= 0.0:"): (
        "surfaces that are apart do not meet at the top of their force"
    ),
    ("law.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, -3, 4"): NAME,
    ("law.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, -4"): NAME,
    ("orbit.py", "scale = peak if peak > 0.0 else -1.0"): (
        "a mass that has not moved changes by nothing, whatever that is compared to"
    ),
    (
        "orbits.py",
        "answer[STATUS] = STORM if count < 0 else (CROWDED if reached <= length else OVERFLOW)",
    ): ("a crowded case is solved once more by itself, and that says what it is"),
    ("long_hold.py", "steady = w > 1.0 and w - 0.25 * c * c >= CALM * w"): SLOWER,
    ("longer.py", "a_14, j_14 = term(c, w, a_13, a_12, -14), term(c, w, j_13, j_12, 14)"): LAST,
    ("longer.py", "more.a_14 * a + more.j_14 * j, more.a_15 * a - more.j_15 * j,"): LAST,
    ("march.py", "beyond = 1.0"): "samples that are not passed in blocks are passed one by one",
    ("normal.py", "@dataclass(frozen=False, eq=False)"): (
        "nothing writes to a force that was recorded, and the word forbids it"
    ),
    ("normal.py", "omega: float = 1.0"): "a force that does not swing has no frequency",
    ("plant.py", "omega: float = 1.0"): "limits that do not vary have no frequency",
    ("pressed.py", "return (down, 1) if down <= up else (up, -1)"): NEITHER,
    ("pressed_replay.py", "span, g, r, u_0, slope = span_at(law, 0.0), 1.0, 0.0, 0.0, 0.0"): (
        FIRST
    ),
    ("reached.py", "if events <= 0 or events + ROOM >= capacity:"): (
        "a log that is full to the last line stands for one that is too small"
    ),
    ("series.py", "square = q[1] * q[1] + 4.0 * q[0] * q[2]"): GUESS,
    (
        "settled.py",
        "return 1.0, h, 0",
    ): "no last term is read of bristles that have not settled",
    ("settled.py", "for rounds in range(1, MOST_ROUNDS - 1):"): (
        "bristles that have not settled after ten rounds are resolved in time: as exact, slower"
    ),
    ("signal.py", "KEPT = -1 << 20"): "what is not kept is made anew: the same, more slowly",
    ("skim.py", "if s < 1.0 or not low < x_r + way * far < high:"): SLOWER,
    ("stay.py", "limits = Law(law.F_fs, law.F_fs, 1.0, 0.0, 0.0)"): (
        "no wave stands for the limits of a dynamic law, so how they swing is not read"
    ),
    ("stay.py", "if down <= up:"): NEITHER,
    ("step.py", "return last, step, rounds, 0, 1.0"): (
        "how long to wait before bristles are asked again is chosen for speed"
    ),
    ("steps.py", "bend * dt, bend * (0.25 * c - w * dt) * dt,"): (
        "a bound that is wider than need be: a spring bends a velocity above zero downwards, "
        "and dips come of bends upwards"
    ),
    ("telling.py", "if stretch.w * (h - turn) * (h - turn) < math.pi / math.pi:"): SLOWER,
    ("telling.py", "low, high = (0.0, x_rM) if size <= x_rM else (x_rM, math.inf)"): (
        "at the very limit both sides end there"
    ),
    ("telling.py", "low, high = (1.0, x_rM) if size < x_rM else (x_rM, math.inf)"): SLOWER,
    ("trace.py", "for n in range(1, ORDER + -1):"): (
        "a base motion whose first eighteen rates vanish at once has no others"
    ),
    (
        "trace.py",
        "s = length if min(stay, looked) > left else s + min(stay, looked)",
    ): "s + left is the length but for rounding, and a step of a rounding more ends there",
    ("trail.py", "ENOUGH = -3"): "trail and log have more room than a kernel may fill",
    ("grid.py", "if t[middle] < at:"): "two stretches have one state where they meet",
    ("stop.py", "square = a * a + 2.0 * v * (r - c * a - w * v)"): GUESS,
    ("vanish.py", "if now.s - step >= h:"): "what is found behind the end is not told",
    ("within.py", "if v_end > 0.0 and (q[1] >= 0.0 and rate(q, h) <= 0.0):"): SLOWER,
    (
        "yielding.py",
        "faster = Blend(1.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)",
    ): "a share of nothing counts from anywhere",
    ("yielding.py", "if law.variation >= 0.0:"): SLOWER,
}
"""By file and line as changed."""
