"""Rules about many seeds: what their interval may be of, and what may vary beside them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from drysim.metrics import BOUNDED, COMFORT, LIMITED, UNITS
from drysim.quantity import meant_or_known, shown
from drysim.scenario.shape import block_in
from drysim.source import Keys

METRIC = ("excitation", "until", "metric")
SEED = "excitation.seed"


def unmeasured(words: Mapping[str, Any]) -> Iterator[tuple[Keys, str]]:
    """Give the sentence when `until` names a metric that the scene does not know."""
    until = block_in(block_in(words, "excitation"), "until")
    name, measure = until.get("metric"), block_in(words, "measure")
    if not isinstance(name, str):
        return
    at = f"excitation.until.metric: {shown(name)} is not known"
    if name not in UNITS:
        hint = meant_or_known(name, UNITS)
        yield METRIC, f"excitation.until.metric: unknown metric {shown(name)}{hint}"
    elif name == "closure":
        yield METRIC, f"{at} for random base motion, which has no periodic orbit"
    elif name in LIMITED and "stroke" not in words:
        yield METRIC, f"{at} without a stroke limit; give stroke.limit"
    elif name in BOUNDED and "stops" not in block_in(words, "stroke"):
        yield METRIC, f"{at} without end stops; give stroke.stops"
    elif name in COMFORT and not {"direction", "weighting"} & measure.keys():
        yield METRIC, f"{at} without a weighting; give measure.direction or measure.weighting"


def beside_seeds(words: Mapping[str, Any], key: str) -> str | None:
    """Say why the seed cannot be swept where every case has many of its own."""
    given = {"seeds", "until"} & block_in(words, "excitation").keys()
    if key != SEED or not given:
        return None
    return f"{SEED} cannot be swept beside {min(given)}: every case has the same seeds then"
