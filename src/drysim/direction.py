"""Values that may differ between extension (v_r > 0) and compression (v_r < 0).

Friction force and damping are one number, or a block with one for each direction of motion.
"""

from typing import Any

from drysim.block import Block, PlainOrBlock
from drysim.quantity import Damping, Force


class ByDirection(Block):
    """Values [unit] that differ between extension (v_r > 0) and compression (v_r < 0)."""

    extension: Any
    compression: Any


class ForceByDirection(ByDirection):
    """Friction force that depends on the direction of motion."""

    extension: Force
    """Force [N] against v_r > 0."""
    compression: Force
    """Force [N] against v_r < 0."""


class DampingByDirection(ByDirection):
    """Damping that depends on the direction of motion, as of a shock absorber."""

    extension: Damping
    """Damping [N·s/m] of v_r > 0."""
    compression: Damping
    """Damping [N·s/m] of v_r < 0."""


DirectedForce = PlainOrBlock[Force, ForceByDirection]
"""One force [N], or one per direction of motion."""

DirectedDamping = PlainOrBlock[Damping, DampingByDirection]
"""One damping [N·s/m], or one per direction of motion."""


def depends_on_direction(value: Any) -> bool:
    """Return whether a value differs between the directions; columns of many cases may."""
    if not isinstance(value, ByDirection):
        return False
    extension, compression = by_direction(value)
    return not (
        isinstance(extension, float)
        and isinstance(compression, float)
        and extension == compression
    )


def by_direction(value: Any) -> tuple[Any, Any]:
    """Return a value for extension and for compression."""
    if isinstance(value, ByDirection):
        return value.extension, value.compression
    return value, value


def mean_of_directions(value: Any) -> Any:
    """Return the mean of a value that may depend on the direction of motion."""
    if isinstance(value, ByDirection):
        return 0.5 * (value.extension + value.compression)
    return value
