"""The assess block of a scenario: measured records of base and mass that are evaluated.

An evaluation needs no model: `with_missing_blocks` fills in the oscillator and, as the base may
be a channel of the measurement, the excitation, so that the scenario can be validated.
`missing_blocks` names them, since no other command can use them.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from drysim.block import Block, InvalidValue
from drysim.quantity import Quantity
from drysim.scenario.fit import ChannelOption, ChannelRecord, Measurements
from drysim.scenario.keys import get_block

ASSESS_KEY = "assess"
"""Key of the block."""

DEFAULT_AGREEMENT = 0.05
"""Share of their mean within which runs agree, as three runs of a test of ISO 10326-1 must."""

MAX_RUNS = 100
"""Largest number of further files."""

AXES = {"x": "horizontal", "y": "horizontal", "z": "vertical"}
"""Direction of each axis of a seated person."""

PLACEHOLDERS = {
    "oscillator": {"mass": 1, "stiffness": 0, "damping": 0},
    "excitation": {"kind": "record", "file": "base"},
}
"""Blocks that a scenario for `drysim assess` may leave out."""


class MeasuredRuns(Measurements):
    """Measured accelerations of base and mass, and the stroke, of one run or of several."""

    more_files: Annotated[
        tuple[Annotated[str, Field(min_length=1)], ...], Field(max_length=MAX_RUNS)
    ] = ()
    """Files of further runs of the same test, which are read with the same keys."""
    x_dd: ChannelOption
    """Absolute acceleration of the mass."""
    u_dd: ChannelOption | None = None
    """Acceleration of the base; default: the record of `excitation`."""

    quantities: ClassVar[dict[str, str]] = {
        "u_dd": "acceleration", "x_dd": "acceleration", "x_r": "displacement",
    }  # fmt: skip
    path_of_block: ClassVar[str] = f"{ASSESS_KEY}.measured"

    @model_validator(mode="after")
    def _check_files(self) -> Self:
        paths = [Path(file) for file in self.files]
        for i, file in enumerate(self.more_files):
            if paths[i + 1] in paths[: i + 1]:
                rule = f"names {file} again; each run has its own file"
                raise InvalidValue(rule, "more_files", i)
        return self

    @property
    def files(self) -> tuple[str, ...]:
        """Files of all runs."""
        return (self.file, *self.more_files)

    def of_file(self, file: str) -> Self:
        """Return the measurement of one run."""
        return self.model_copy(update={"file": file, "more_files": ()})


class AxisChannels(Block):
    """Channels of one more axis, in the same files."""

    u_dd: ChannelOption | None = None
    """Acceleration of the base along this axis; without it only the mass is evaluated."""
    x_dd: ChannelOption
    """Acceleration of the mass along this axis."""


class OtherAxes(Block):
    """Channels of the axes of a seat besides that of `measured`."""

    x: AxisChannels | None = None
    """Fore and aft: weighted by Wd, k = 1.4."""
    y: AxisChannels | None = None
    """Lateral: weighted by Wd, k = 1.4."""
    z: AxisChannels | None = None
    """Vertical: weighted by Wk, k = 1."""

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("x", "y", "z"),)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(name for name in AXES if getattr(self, name) is not None)


class Assess(Block):
    """What `drysim assess` evaluates."""

    measured: MeasuredRuns
    """The measured channels."""
    axes: OtherAxes | None = None
    """Channels of other axes of the seat, `x`, `y` or `z`, in the same files; the axis of
    `measured` is z if `measure.direction` is vertical, else x. `A_8`
    and `VDV_day` are each the largest of all axes."""
    agree_within: Annotated[float, Quantity("", above=0, below=1)] = DEFAULT_AGREEMENT
    """Share of their mean within which the runs must agree [-]; default 5 %."""

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        for name in self.axis_names:
            of_axis = self.along(name)
            for channel in of_axis.channels:
                try:
                    of_axis.check_channel(channel)
                except InvalidValue as fault:
                    raise InvalidValue(str(fault), "axes", name, *fault.path) from None
        return self

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the axes besides that of `measured`."""
        return self.axes.names if self.axes else ()

    @property
    def channels(self) -> dict[str, ChannelRecord]:
        """The channels of the first run along all axes, by their keys in the scenario."""
        channels = self.measured.records
        for axis in self.axis_names:
            of_axis = self.along(axis)
            channels |= {
                f"{ASSESS_KEY}.axes.{axis}.{name}": of_axis.record(name)
                for name in of_axis.channels
            }
        return channels

    def along(self, axis: str) -> MeasuredRuns:
        """Return the measurement along another axis."""
        channels = getattr(self.axes, axis)
        return self.measured.model_copy(
            update={"u_dd": channels.u_dd, "x_dd": channels.x_dd, "x_r": None}
        )


def missing_blocks(document: Mapping[str, Any]) -> list[str]:
    """Return the blocks that a document leaves out, as it is to be assessed only."""
    if not get_block(document, ASSESS_KEY):
        return []
    return [name for name in PLACEHOLDERS if name not in document]


def with_missing_blocks(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with a placeholder for each block that may be left out."""
    return {**document, **{name: PLACEHOLDERS[name] for name in missing_blocks(document)}}
