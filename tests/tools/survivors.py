"""Changes of the core that `mutate.py` makes and no test can notice, each with its reason."""

from __future__ import annotations

GUESS = "a first guess only: the guarded method behind it arrives all the same, or says so"
NAME = "a number that stands for a word: any that no other word has will do"
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
    ("march.py", "while n < until and at <= full and count < full:"): SPARE,
    ("march.py", "if stalled >= MAX_STALLED_EVENTS:"): "a hundred events do as well",
    ("roots.py", "if low > 1.0:"): "a step that is shorter than it might be is as safe",
    (
        "roots.py",
        "return h - h * h * h * third / (6.0 * rate - (6.0 * curvature + 3.0 * third * h) * h)",
    ): "a part of fourth order, and the search ends where all of that order is nothing",
    ("roots.py", "max_omega = 1.0"): "a step that is shorter than it might be is as safe",
    ("compile.py", "return kernel_of(function, forceinline=False)"): BUILT,
    ("compile.py", "return kernel_of(function, forceinline=True)"): BUILT,
    ("modes.py", "and QUASI_STATIC_RATIO * waves.values[at + OMEGA] ** -2 <= w"): STEADIER,
    ("modes.py", "and QUASI_STATIC_RATIO / waves.values[at + OMEGA] ** 2 <= w"): STEADIER,
    ("modes.py", "return sign(v_r) if law.k_t * abs(v_r) >= rate else HOLD"): (
        "one that is as fast as its limit yields now or at the next instant"
    ),
    (
        "trajectory.py",
        "s = s + length if length < hi + s else hi",
    ): "the last panel ends where it should but for rounding, and that adds nothing",
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
    ("modes.py", "if t <= s:"): NEITHER,
    (
        "taylor.py",
        "return n + -1, h",
    ): "the last of three terms in a row that are within the tolerance may go",
    ("fixed_step.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, -3, 4"): NAME,
    ("fixed_step.py", "SIGN, ARCTAN, TANH, ERF, RATIONAL = 0, 1, 2, 3, -4"): NAME,
    ("orbit.py", "scale = peak if peak > 0.0 else -1.0"): (
        "a mass that has not moved changes by nothing, whatever that is compared to"
    ),
    ("orbit.py", "count if count < 0 else (LOG_FULL if reached <= length else OVERFLOW)"): (
        "a crowded case is solved once more by itself, and that says what it is"
    ),
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
    ("orbit.py", "if events <= 0 or events + SINES_LOG_RESERVE >= len(log.kind):"): (
        "a log that is full to the last line stands for one that is too small"
    ),
    ("oscillator.py", "square = q[1] * q[1] + 4.0 * q[0] * q[2]"): GUESS,
    ("taylor.py", "return 1.0, h, 0"): "no last term is read of bristles that have not settled",
    ("taylor.py", "for iterations in range(1, MAX_ITERATIONS - 1):"): (
        "bristles that have not settled after ten rounds are resolved in time: as exact, slower"
    ),
    (
        "model.py",
        "MAX_CACHED = -1 << 20",
    ): "what is not kept is made anew: the same, more slowly",
    ("taylor.py", "limits = CoulombLaw(law.F_fs, law.F_fs, 1.0, 0.0, 0.0)"): (
        "no wave stands for the limits of a dynamic law, so how they swing is not read"
    ),
    (
        "taylor.py",
        "return last, step, iterations, StepControl(time_scale, requested, 0, 1, stalled)",
    ): ("how long to wait before bristles are asked again is chosen for speed"),
    ("oscillator.py", "steep, fast = dip_factor * dt, dip_factor * (0.25 * c - w * dt) * dt"): (
        "a bound that is wider than need be: a spring bends a velocity above zero downwards, "
        "and dips come of bends upwards"
    ),
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
    (
        "sampled.py",
        "if v_end > 0.0 and (a >= 0.0 and series_acceleration(q, h) <= 0.0):",
    ): SLOWER,
}
"""By file and line as changed."""
