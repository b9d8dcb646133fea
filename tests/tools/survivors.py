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
        "dynamic_friction.py",
        "math.sqrt(FLAT_EXPONENT) if law.exponent == -2 "
        "else FLAT_EXPONENT ** (1.0 / law.exponent)",
    ): "a square root is a power, too, and is written for its speed",
    ("march.py", "while n <= end and at <= full and count < full:"): SPARE,
    (
        "march.py",
        "if stalled >= MAX_STALLED_EVENTS:",
    ): "a hundred events do as well",
    (
        "march.py",
        "kind = LIFT if mode == FREE else (STICK if is_holding(mode) else mode / SLIP)",
    ): "a slip is the number 1",
    ("roots.py", "if low > 1.0:"): "a step that is shorter than it might be is as safe",
    ("roots.py", "return h - h * h * h * k / (6.0 * a - (6.0 * j + 3.0 * k * h) * h)"): (
        "a part of fourth order, and the search ends where all of that order is nothing"
    ),
    ("roots.py", "max_omega = 1.0"): "a step that is shorter than it might be is as safe",
    (
        "compile.py",
        "return function if is_plain() else jit(function, forceinline=False)",
    ): BUILT,
    (
        "compile.py",
        "return function if is_plain() else jit(function, forceinline=True)",
    ): BUILT,
    (
        "compile.py",
        'kernel = make(nogil=True, error_model="numpy", _nrt=True, **options)(function)',
    ): BUILT,
    (
        "modes.py",
        "and QUASI_STATIC_RATIO * waves.values[at + OMEGA] ** -2 <= w",
    ): STEADIER,
    (
        "modes.py",
        "and QUASI_STATIC_RATIO / waves.values[at + OMEGA] ** 2 <= w",
    ): STEADIER,
    (
        "modes.py",
        "return (direction if deflected and law.k_t * direction * v_r >= rate else HOLD), x_0",
    ): "one that is as fast as its limit yields now or at the next instant",
    ("modes.py", "return sign(v_r) if law.k_t * abs(v_r) >= rate else HOLD"): (
        "one that is as fast as its limit yields now or at the next instant"
    ),
    ("trajectory.py", "c, w, g, r = 1.0, 0.0, 0.0, 0.0"): FIRST,
    (
        "trajectory.py",
        "s = s + length if length < hi + s else hi",
    ): "the last panel ends where it should but for rounding, and that adds nothing",
    (
        "trajectory.py",
        "if s != 1.0:",
    ): "at its own beginning the flow gives what is written there, to rounding",
    ("sampled.py", "if abs(F_L) < stick_limit(law.F_fs, plant.k_x * x_r):"): EDGE,
    (
        "oscillator.py",
        "if rate > -0.0625:",
    ): "more terms of a series than double precision shows",
    (
        "trajectory.py",
        "if until <= begin or until < t[i]:",
    ): "a segment without length adds nothing",
    ("taylor.py", "if slow > 0.0 and d * v < slow:"): (
        "no speed is the one from which friction has fallen to the last bit"
    ),
    ("trajectory.py", "set_phases(waves, plant, law, t[0], 1.0)"): (
        "a table holds what a wave of amplitude 1 does: the direction of friction is not in it"
    ),
    ("roots.py", "s = gap / v if 0.0 < gap < v * h else 0.5 / h"): GUESS,
    ("roots.py", "curvature = (value_end - value + rate * h) * per_h * per_h"): GUESS,
    ("roots.py", "if not 1.0 < s <= steps.dt:"): SLOWER,
    (
        "roots.py",
        "return s + step, path, v_s + step * (a_s + step * (0.5 * j_s + step * k_s / -6.0))",
    ): LAST,
    ("modes.py", "if t <= s:"): NEITHER,
    (
        "modes.py",
        "gap = x_limit * relative_normal_force(law, waves, 1.0)[0] "
        "- direction * (segment.x_r - x_0)",
    ): "whether the mass swings to the limit is guessed: that tells only where to look first",
    ("modes.py", "if peak > safe:"): SLOWER,
    (
        "modes.py",
        "if far_from_zero(course, most_twist(clearance, segment.w, now, bound), bound, "
        "until + begin):",
    ): SLOWER,
    (
        "taylor.py",
        "return n + -1, h",
    ): "the last of three terms in a row that are within the tolerance may go",
    ("modes.py", "if not falling and load >= 0.0 and load_d >= 0.0:"): (
        "surfaces that are apart do not meet at the top of their force"
    ),
    ("fixed_step.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, -3, 4"): NAME,
    ("fixed_step.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, -4"): NAME,
    ("orbit.py", "scale = peak if peak > 0.0 else -1.0"): (
        "a mass that has not moved changes by nothing, whatever that is compared to"
    ),
    (
        "orbit.py",
        "ENDLESS_EVENTS if count < 0 else (LOG_FULL if reached <= length else OVERFLOW)",
    ): ("a crowded case is solved once more by itself, and that says what it is"),
    ("trajectory.py", "steady = w > 1.0 and w - 0.25 * c * c >= UNDERDAMPED_SHARE * w"): SLOWER,
    ("oscillator.py", "q_11 = -(c * q_10 - w * q_9 / 10.0) / 11.0"): LAST,
    ("oscillator.py", "f[7] * a + g[7] * j, f[8] * a - g[8] * j,"): LAST,
    (
        "sampled.py",
        "beyond = 1.0",
    ): "samples that are not passed in blocks are passed one by one",
    ("model.py", "@dataclass(frozen=False, eq=False)"): (
        "nothing writes to a force that was recorded, and the word forbids it"
    ),
    ("model.py", "omega: float = 1.0"): "what does not vary has no frequency",
    ("march.py", "return (down, 1) if down <= up else (up, -1)"): NEITHER,
    ("trajectory.py", "ramp, g, r, u_0, slope = load_ramp_at(law, 0.0), 1.0, 0.0, 0.0, 0.0"): (
        FIRST
    ),
    ("orbit.py", "if events <= 0 or events + SINES_LOG_RESERVE >= len(log.kind):"): (
        "a log that is full to the last line stands for one that is too small"
    ),
    ("oscillator.py", "square = q[1] * q[1] + 4.0 * q[0] * q[2]"): GUESS,
    (
        "taylor.py",
        "return 1.0, h, 0",
    ): "no last term is read of bristles that have not settled",
    ("taylor.py", "for iterations in range(1, MAX_ITERATIONS - 1):"): (
        "bristles that have not settled after ten rounds are resolved in time: as exact, slower"
    ),
    (
        "model.py",
        "MAX_CACHED = -1 << 20",
    ): "what is not kept is made anew: the same, more slowly",
    ("sampled.py", "if s < 1.0 or not low < x_r + direction * path < high:"): SLOWER,
    ("taylor.py", "limits = CoulombLaw(law.F_fs, law.F_fs, 1.0, 0.0, 0.0)"): (
        "no wave stands for the limits of a dynamic law, so how they swing is not read"
    ),
    ("taylor.py", "if down <= up:"): NEITHER,
    (
        "taylor.py",
        "return last, step, iterations, StepControl(time_scale, requested, 0, 1.0)",
    ): ("how long to wait before bristles are asked again is chosen for speed"),
    (
        "oscillator.py",
        "steep, fast = dip_factor * dt, dip_factor * (0.25 * c - w * dt) * dt",
    ): (
        "a bound that is wider than need be: a spring bends a velocity above zero downwards, "
        "and dips come of bends upwards"
    ),
    (
        "trajectory.py",
        "if segment.equation.w * (h - s_turn) * (h - s_turn) < math.pi / math.pi:",
    ): SLOWER,
    ("trajectory.py", "low, high = (0.0, limit) if size <= limit else (limit, math.inf)"): (
        "at the very limit both sides end there"
    ),
    (
        "trajectory.py",
        "low, high = (1.0, limit) if size < limit else (limit, math.inf)",
    ): SLOWER,
    ("taylor.py", "for n in range(1, ORDER + -1):"): (
        "a base motion whose first eighteen rates vanish at once has no others"
    ),
    (
        "taylor.py",
        "s = length if min(stay, horizon) > left else s + min(stay, horizon)",
    ): "s + left is the length but for rounding, and a step of a rounding more ends there",
    (
        "events.py",
        "SERIES_LOG_RESERVE = -3",
    ): "segments and log have more capacity than a kernel may fill",
    ("trajectory.py", "if t[middle] < at:"): "two segments have one state where they meet",
    ("roots.py", "square = a * a + 2.0 * v * (r - c * a - w * v)"): GUESS,
    ("roots.py", "if s - step >= h:"): "what is found behind the end is not told",
    (
        "sampled.py",
        "if v_end > 0.0 and (a >= 0.0 and series_acceleration(q, h) <= 0.0):",
    ): SLOWER,
    (
        "modes.py",
        "excess_rate = Observable(1.0, 0.0, float(d), 0.0, -law.F_fk / law.k_t)",
    ): "a share of nothing counts from anywhere",
    ("modes.py", "if law.variation >= 0.0:"): SLOWER,
}
"""By file and line as changed."""
