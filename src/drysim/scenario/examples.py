"""Blocks that a scenario lacks, as text to copy: keys that it states, with ranges."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from drysim.errors import ScenarioError
from drysim.scenario.axes import FREQUENCY_KEY
from drysim.scenario.model import Scenario

HEADING = "for example:\n\n"
"""Lines before a block."""

FRICTION_KEY = "friction.kinetic"
"""Key whose range begins at 0."""

SWEPT_KEYS = (
    FRICTION_KEY,
    "friction.mu_kinetic",
    FREQUENCY_KEY,
    "oscillator.damping",
    "oscillator.damping_ratio",
    "oscillator.stiffness",
    "oscillator.natural_frequency",
    "oscillator.mass",
)
"""Keys that are usually swept, in order of preference."""

MAPPED_KEYS = (FREQUENCY_KEY, *(key for key in SWEPT_KEYS if key != FREQUENCY_KEY))
"""Keys of the axes of a map, in order of preference."""

DESIGNED_KEYS = (
    "oscillator.stiffness",
    "oscillator.natural_frequency",
    "oscillator.damping",
    "oscillator.damping_ratio",
    FRICTION_KEY,
    "friction.mu_kinetic",
    "oscillator.mass",
)
"""Keys that a designer usually chooses, in order of preference."""

STEPS = 10
"""Steps of a range."""

MAP_NODES = 129
"""Values of each axis of a map."""


def sweep_example(scenario: Scenario) -> str:
    """Return a sweep block, and the option that does without it."""
    (key, low, high), *_ = valid_ranges(scenario, SWEPT_KEYS, 2.0)
    step = (high - low) / STEPS
    ends = f"{low:g}", f"{high:g}", f"{step:g}"
    span = "from: {}, to: {}, step: {}".format(*ends)
    option = f"--over {key}={':'.join(ends)}"
    return f"{HEADING}sweep:\n  {key}: {{{span}}}\n\nor, without a block, {option}"


def map_example(scenario: Scenario) -> str:
    """Return a sweep block with the two axes of a map, and the option that does without it."""
    lines = range_lines(scenario, MAPPED_KEYS, f", count: {MAP_NODES}")
    block = "\n  ".join([f"{HEADING}sweep:", *lines])
    return f"{block}\n\nor, without a block, --over KEY=FROM:TO:STEP twice"


def design_example(scenario: Scenario) -> str:
    """Return a design block."""
    lines = ["vary:", *(f"  {line}" for line in range_lines(scenario, DESIGNED_KEYS))]
    if scenario.measure.weights is not None:
        lines.append("minimise: SEAT")
    else:
        lines.append(f"minimise: {'a_x' if scenario.excitation.kind == 'rest' else 'T_a'}")
    if scenario.stroke is None and not scenario.checks:
        lines.append("within: [x_r_peak < 25 mm]")
    return "\n  ".join([f"{HEADING}design:", *lines])


def range_lines(scenario: Scenario, keys: Sequence[str], more: str = "") -> list[str]:
    """Return the first two of the keys with their ranges, a factor of four to either side."""
    lines = []
    for key, low, high in valid_ranges(scenario, keys, 4.0)[:2]:
        scale = ", scale: log" if low else ""
        lines.append(f"{key}: {{from: {low:g}, to: {high:g}{more}{scale}}}")
    return lines


def valid_ranges(
    scenario: Scenario, keys: Sequence[str], factor: float
) -> list[tuple[str, float, float]]:
    """Return key and range of those keys that a scenario states and that may vary alone.

    The range reaches up to a factor above the stated value and below it; that of friction
    begins at 0. Its ends have two significant digits.
    """
    values, ranges = scenario.values_of(keys), []
    for key in keys:
        value = values.get(key, 0.0)
        low = 0.0 if key == FRICTION_KEY else float(f"{value / factor:.2g}")
        high = low + float(f"{factor * value - low:.2g}")
        with suppress(ScenarioError):
            if value > 0.0 and all(scenario.at({key: end}) for end in (low, high)):
                ranges.append((key, low, high))
    return ranges
