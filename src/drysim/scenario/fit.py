"""The fit block of a scenario: a measured response, or measured curves, and the free keys.

The values of free keys may be missing from the file: `with_placeholders` fills them in so that
the scenario can be validated, and `missing_values` names them, since no other command can use
them.
"""

from collections.abc import Mapping
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    ValidationError,
    WithJsonSchema,
    model_validator,
)

from drysim.block import Block, InvalidValue
from drysim.core.model import Floats
from drysim.messages import closest_match, did_you_mean, format_value, name_hint
from drysim.quantity import Dimensionless, Frequency, Quantity, Time
from drysim.records import SI
from drysim.records.options import (
    Column,
    FullScale,
    Gaps,
    InFile,
    MissingCode,
    PositiveTime,
    RatioTable,
    Recorded,
    RemovalOption,
    Resample,
    Rows,
    Window,
)
from drysim.scenario.axes import DottedKeysSchema, NumberOrText
from drysim.scenario.keys import NumericKey, fields_by_key, get_block, numeric_keys
from drysim.scenario.laws import LAWS, other_laws_hint
from drysim.scenario.reading import Reading
from drysim.scenario.validation import spoken_name, validation_faults
from drysim.wording import join_words

FIT_KEY = "fit"
"""Key of the block."""

FREE_PATH = f"{FIT_KEY}.free"
"""Path of the block whose keys are dotted keys of the scenario."""

DELAY_KEY, OFFSET_KEY = "measured.delay", "measured.offset"
"""Free keys of the measurement instead of the scenario."""

START_KEYS = ("start.x_r", "start.v_r")
"""Keys of the start state."""

SAME_PLACEHOLDER = {
    "friction.static": "kinetic",
    "friction.kinetic": "static",
    "friction.mu_static": "mu_kinetic",
    "friction.mu_kinetic": "mu_static",
}
"""Key of friction whose value, if there is one, stands for a missing value."""

FITTED_BLOCKS = ("oscillator", "friction", "stroke", "start", "measured")
"""Blocks whose keys can be fitted: those of the oscillator itself, and of its measurement."""

BLOCKS_OF_CURVES = ("oscillator", "friction")
"""Blocks whose keys can be fitted to curves."""

CHANNELS = {"x_dd": "acceleration", "x_r": "displacement", "v_r": "velocity", "F_f": "force"}
"""Measured quantity of each channel."""

CHANNEL_UNITS = {name: SI[quantity] for name, quantity in CHANNELS.items()}
"""SI unit of each channel."""

RATIOS = ("T_a", "T_x")
"""Measured ratios of a curve: metrics of a steady motion."""

LEVELS = ("rms", "amplitude", "velocity", "displacement")
"""Keys of which one states the level of the base motion of a curve."""

LEVEL_UNITS = dict(zip(LEVELS, ("m/s²", "m/s²", "m/s", "m"), strict=True))
"""Their units."""

DEFAULT_HOLD_OUT = 0.3
"""Share of a record at its end that is not fitted, by default."""


class FreeKey(NamedTuple):
    """Start and bounds of a fitted value, in SI; None where the file gives none."""

    start: float | None = None
    low: float | None = None
    high: float | None = None


class FreeRange(Block):
    """Start and bounds of a fitted value."""

    start: NumberOrText = None
    """Value from which the fit starts; default: in closed form, from the record."""
    low: NumberOrText = Field(None, alias="from")
    """Lower bound; default: that of the key."""
    high: NumberOrText = Field(None, alias="to")
    """Upper bound; default: that of the key."""


FREE_OPTIONS = tuple(fields_by_key(FreeRange))
"""Keys of a free key in a file, in the order of `FreeKey`."""


class ChannelQuantity(Block):
    """Quantity of a channel; a base class, so that it is read before the unit."""

    quantity: Literal["acceleration", "velocity", "displacement", "force"]


class ChannelRecord(Recorded, ChannelQuantity):
    """A channel of a measurement with everything that is needed to read it."""


class Channel(Block):
    """A channel of the measured response. A column alone may stand for the block."""

    column: Column | None = None
    """Column of the samples, by name or number from 1."""
    channel: Column | None = None
    """Channel of the samples, for formats with channels."""
    unit: str | None = None
    """Unit of the samples; required unless the file contains it."""
    full_scale: FullScale | None = None
    """Value of digital full scale with its unit, instead of `unit`, for WAV files."""
    scale: Dimensionless = 1.0
    """Factor on every sample [-]; -1 reverses the sign."""
    remove: RemovalOption = Field({}, validate_default=True)
    """What is removed from the channel, as for a record of base motion."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("column", "channel"),
        ("unit", "full_scale"),
    )


def _expand_channel(value: object) -> object:
    """Expand a column to a block."""
    return value if isinstance(value, dict | Channel) else {"column": value}


ChannelOption = Annotated[
    Channel, BeforeValidator(_expand_channel, json_schema_input_type=str | int | Channel)
]


class Measurements(InFile):
    """Channels in a file, on one time axis: what is measured for a fit and for an assessment.

    Times count as those of the base motion: both files start at the same instant unless their
    time columns say otherwise.
    """

    skip: Annotated[int, Field(strict=True, ge=0)] = 0
    """Rows to skip at the top of a text file [-]; default 0."""
    rows: Rows | None = None
    """The rows of a text file that are samples; default: all below the header."""
    time: Column | None = None
    """Column of the times: numbers, or dates and times of day."""
    time_unit: str | None = None
    """Unit of the times, such as ms, if the header has none."""
    rate: Frequency | None = None
    """Sampling rate [Hz], instead of `time`."""
    step: PositiveTime | None = None
    """Time step [s], instead of `time`."""
    x_dd: ChannelOption | None = None
    """Absolute acceleration of the mass."""
    x_r: ChannelOption | None = None
    """Displacement of the mass relative to the base, such as the stroke of a seat."""
    delay: Time = 0.0
    """Time by which the measured response lags the base motion [s]; default 0."""
    missing: MissingCode | None = None
    """Number that stands for missing samples in every channel, such as -9999; or `nothing`, if
    all numbers are samples."""
    gaps: Gaps | None = None
    """Interpolation of missing samples; by default each is an error."""
    resample: Resample | None = None
    """Resampling onto another time grid; the step must be that of the base motion or a whole
    multiple of it."""
    window: Window | None = None
    """The part to use, `{from: 10 s, to: 70 s}`; default: all that the base motion covers."""

    at_most_one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("time", "rate", "step"),)
    quantities: ClassVar[dict[str, str]] = CHANNELS
    """Measured quantity of each channel that the block may have."""
    path_of_block: ClassVar[str] = f"{FIT_KEY}.measured"
    """Path of the block in a scenario."""

    @model_validator(mode="after")
    def _check_channels(self) -> Self:
        for name in self.channels:
            self.check_channel(name)
        return self

    def check_channel(self, name: str) -> None:
        """Raise InvalidValue for a channel whose options are no record."""
        try:
            self.record(name)
        except ValidationError as fault:
            for keys, sentence in validation_faults(fault, {}):
                key = str(keys[0]) if keys else ""
                inside = key in Channel.model_fields
                message = sentence.removeprefix(f"{key} ")
                raise InvalidValue(message, *((name, key) if inside else (key,))) from None

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured channels."""
        return tuple(name for name in self.quantities if getattr(self, name) is not None)

    @property
    def records(self) -> dict[str, ChannelRecord]:
        """The channels as records, by their keys in the scenario."""
        return {f"{self.path_of_block}.{name}": self.record(name) for name in self.channels}

    def record(self, name: str) -> ChannelRecord:
        """Return a channel as a record."""
        shared = self.model_dump(
            by_alias=True, exclude_none=True, include={*Recorded.model_fields, "file"}
        )
        channel = getattr(self, name).model_dump(exclude_none=True)
        return ChannelRecord.model_validate(
            {**shared, **channel, "quantity": self.quantities[name]},
            context={"folder": self._folder, "block": f"{self.path_of_block}.{name}"},
        )


class MeasuredResponse(Measurements):
    """Measured response of the mass, or force and motion of a friction rig.

    Times count as those of the base motion: both files start at the same instant unless their
    time columns say otherwise. A free decay begins with its first sample.
    """

    v_r: ChannelOption | None = None
    """Velocity of the mass relative to the base."""
    F_f: ChannelOption | None = None
    """Force of a rig, positive where it opposes v_r > 0, with or without those of spring and
    damper; with `v_r` or `x_r`, which then are the imposed motion."""

    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (("x_dd", "x_r", "v_r", "F_f"),)

    @model_validator(mode="after")
    def _check_rig(self) -> Self:
        if self.F_f is None:
            return self
        if self.x_dd is not None:
            raise InvalidValue(
                "stands beside F_f, but a rig imposes its motion; remove it", "x_dd"
            )
        for name in self.channels:
            if getattr(self, name).remove.any:
                rule = "is not supported for a rig, whose samples are fitted as they are"
                raise InvalidValue(rule, name, "remove")
        if (self.v_r is None) == (self.x_r is None):
            raise InvalidValue("requires the imposed motion, either v_r or x_r", "F_f")
        return self

    @property
    def is_rig(self) -> bool:
        """Whether the measurement is that of a friction rig, without dynamics."""
        return self.F_f is not None


class Curve(RatioTable):
    """Transmissibility over frequency at one level of the base motion, as a table in a file.

    The base motion of each row is a sine of the stated level; or it is the random motion of
    `excitation`, at the stated RMS value, for all rows together.
    """

    T_a: Column | None = None
    """Column of T_a, the RMS acceleration of the mass over that of the base; a ratio, or % by
    the header. Under random base motion the transmissibility by `estimator`."""
    T_x: Column | None = None
    """Column of T_x, the RMS relative displacement over that of the base; the same."""
    rms: Annotated[float, Quantity("m/s²", above=0)] | None = None
    """RMS value of the base acceleration [m/s²], of sines the same at all frequencies."""
    amplitude: Annotated[float, Quantity("m/s²", above=0)] | None = None
    """Amplitude of the base acceleration [m/s²], √2 times `rms`."""
    velocity: Annotated[float, Quantity("m/s", above=0)] | None = None
    """Amplitude of the base velocity [m/s], the same at all frequencies."""
    displacement: Annotated[float, Quantity("m", above=0)] | None = None
    """Amplitude of the base displacement [m], the same at all frequencies."""
    estimator: Literal["H1", "H2", "Hv"] = "H1"
    """How the transmissibility under random base motion was estimated: H1, cross spectrum over
    the PSD of the base; H2, PSD of the mass over the cross spectrum; Hv, the root of the ratio
    of both PSDs."""
    duration: PositiveTime | None = None
    """Time over which the laboratory averaged the curve [s], under random base motion; default:
    estimated from the scatter of the curves."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (LEVELS,)
    any_of: ClassVar[tuple[tuple[str, ...], ...]] = (RATIOS,)

    @property
    def level(self) -> tuple[str, float]:
        """Key and value of the level, in SI."""
        key = next(key for key in LEVELS if getattr(self, key) is not None)
        return key, getattr(self, key)

    def base_rms(self, frequency: Floats) -> Floats:
        """Return the RMS value of the base acceleration at each frequency [m/s²]."""
        key, value = self.level
        if key == "rms":
            return np.full(len(frequency), value)
        power = {"amplitude": 0, "velocity": 1, "displacement": 2}[key]
        rms: Floats = value * (2.0 * np.pi * frequency) ** power / np.sqrt(2.0)
        return rms


class Noise(Block):
    """Standard deviation of the noise in each channel, where it is known."""

    x_dd: Annotated[float, Quantity("m/s²", above=0)] | None = None
    """Noise of x_dd [m/s²]."""
    x_r: Annotated[float, Quantity("m", above=0)] | None = None
    """Noise of x_r [m]."""
    v_r: Annotated[float, Quantity("m/s", above=0)] | None = None
    """Noise of v_r [m/s]."""
    F_f: Annotated[float, Quantity("N", above=0)] | None = None
    """Noise of F_f [N]."""
    u_dd: Annotated[float, Quantity("m/s²", at_least=0)] | None = None
    """Noise of the base record [m/s²]; 0 takes it as exact."""


def _validate_free(value: object) -> dict[str, FreeKey]:
    """Return the free keys; `read_free` has read their values."""
    if isinstance(value, Mapping) and value:
        return {
            key: options
            if isinstance(options, FreeKey)
            else FreeKey(*map(options.get, FREE_OPTIONS))
            for key, options in value.items()
        }
    raise ValueError("must be keys such as `friction.kinetic: {}`")


def _free_words(free: Mapping[str, FreeKey]) -> dict[str, dict[str, float]]:
    """Return the free keys as a file writes them."""
    return {
        key: {word: v for word, v in zip(FREE_OPTIONS, free_key, strict=True) if v is not None}
        for key, free_key in free.items()
    }


Free = Annotated[
    dict[str, FreeKey],
    PlainValidator(_validate_free),
    PlainSerializer(_free_words),
    DottedKeysSchema(FreeRange),
]


def _known_law(name: str) -> str:
    if name not in LAWS:
        raise ValueError(f"unknown law {format_value(name)}{name_hint(name, LAWS)}")
    return name


EXAMPLE_MEASURED = "`measured: {file: seat.csv, time: t, x_dd: seat}`"
EXAMPLE_CURVES = "`curves: [{file: lab.csv, frequency: f, T_a: T, rms: 0.5 m/s2}]`"

NOT_OF_CURVES = {
    "laws": "they are fitted under the law of the file",
    "hold_out": "all their rows are fitted",
    "noise": "their noise follows from the residuals",
}
"""Keys that a fit to curves refuses, and why."""

LawName = Annotated[str, AfterValidator(_known_law), WithJsonSchema({"enum": list(LAWS)})]


class Fit(Block):
    """What `drysim fit` fits, and to which measurement: `measured` or `curves`."""

    measured: MeasuredResponse | None = None
    """The measured response."""
    curves: Annotated[tuple[Curve, ...], Field(min_length=1)] | None = None
    """Measured curves of transmissibility, one for each level, instead of `measured`."""
    free: Free
    """Keys to fit: dotted keys of this file, each with `{}` or with `start`, `from` and `to`.
    Values need not be given elsewhere in the file."""
    laws: tuple[LawName, ...] = ()
    """Friction laws to compare, on the held-out part; default: that of the file."""
    hold_out: Annotated[float, Quantity("", at_least=0, below=1)] | None = None
    """Share of the record at its end that is not fitted but predicted; default 30 %, and
    nothing for a free decay."""
    noise: Noise | None = None
    """Standard deviation of the noise; default: estimated from the residuals."""

    @property
    def response(self) -> MeasuredResponse:
        """The measured response, of a fit to one."""
        assert self.measured is not None, "only a fit to curves has no response"
        return self.measured

    @property
    def is_rig(self) -> bool:
        """Whether the measurement is that of a friction rig, without dynamics."""
        return self.measured is not None and self.measured.is_rig

    @model_validator(mode="after")
    def _check_measurement(self) -> Self:
        if self.measured is not None and self.curves is not None:
            raise InvalidValue(
                "stands beside `measured`; a fit is to one of them: remove one", "curves"
            )
        if self.measured is None and self.curves is None:
            raise InvalidValue(
                f"needs the measurement: {EXAMPLE_MEASURED}, or {EXAMPLE_CURVES}"
            )
        if self.curves is None:
            return self
        for key in NOT_OF_CURVES:
            if key in self.model_fields_set:
                raise InvalidValue(f"has no meaning for curves; {NOT_OF_CURVES[key]}", key)
        for key in self.free:
            if key.partition(".")[0] not in BLOCKS_OF_CURVES:
                blocks = join_words(BLOCKS_OF_CURVES, "or")
                sentence = f"is not fitted to curves, only keys of {blocks} are"
                raise InvalidValue(sentence, "free", key)
        return self

    @model_validator(mode="after")
    def _check_laws(self) -> Self:
        for i, law in enumerate(self.laws):
            if law in self.laws[:i]:
                raise InvalidValue(f"is {law} again; name each law once", "laws", i)
        return self

    @model_validator(mode="after")
    def _check_noise(self) -> Self:
        for name in CHANNELS if self.measured is not None else ():
            if getattr(self.noise, name, None) and name not in self.response.channels:
                raise InvalidValue(
                    f"is not measured; remove it, or give {name} in fit.measured", "noise", name
                )
        if getattr(self.noise, "u_dd", None) is not None and self.is_rig:
            raise InvalidValue("is that of a base, which a rig has not", "noise", "u_dd")
        return self


# Reading from a file


def with_placeholders(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with a value for each free key that has none."""
    filled = dict(document)
    free = get_block(get_block(document, FIT_KEY), "free")
    for key in missing_values(document):
        block, _, name = key.partition(".")
        options = free[key] if isinstance(free[key], Mapping) else {}
        if not isinstance(document.get(block, {}), Mapping):
            continue  # reported elsewhere
        least = 0 if block == "start" else 1
        given = (options[word] for word in ("start", "to", "from") if word in options)
        value = next(given, least)
        if other := SAME_PLACEHOLDER.get(key):  # static friction is at least the kinetic one
            value = get_block(filled, "friction").get(other, value)
        filled[block] = _with_default(get_block(filled, block), name.split("."), value)
    return filled


def missing_values(document: Mapping[str, Any]) -> list[str]:
    """Return the free keys without a value in a document."""
    free = get_block(get_block(document, FIT_KEY), "free")
    fitted = [str(key) for key in free if str(key).partition(".")[0] in FITTED_BLOCKS]
    return [
        key
        for key in fitted
        if "." in key and not key.startswith("measured.") and not _has(document, key)
    ]


def unstated_start(document: Mapping[str, Any]) -> list[str]:
    """Return the keys of the start state that a document neither gives nor fits.

    A fit finds out whether the record begins at rest, as other commands would take it.
    """
    free = get_block(get_block(document, FIT_KEY), "free")
    return [key for key in START_KEYS if key not in free and not _has(document, key)]


def _has(document: Any, key: str) -> bool:
    """Return whether a document has a value at a dotted key."""
    for name in key.split("."):
        if isinstance(document, list) and name.isdecimal() and int(name) < len(document):
            document = document[int(name)]
        elif isinstance(document, Mapping) and name in document:
            document = document[name]
        else:
            return False
    return document is not None


def _with_default(block: Any, steps: list[str], value: object) -> Any:
    """Return a copy of a block with a value at a path."""
    if not isinstance(block, Mapping):
        return block
    first, *rest = steps
    inner = _with_default(block.get(first) or {}, rest, value) if rest else value
    return {**block, first: inner}


def without_value(block: Any, steps: list[str]) -> Any:
    """Return a copy of a block without the value at a path, and without emptied blocks."""
    first, *rest = steps
    if not isinstance(block, Mapping) or first not in block:
        return block
    kept = {**block, first: without_value(block[first], rest) if rest else {}}
    return kept if kept[first] else {key: v for key, v in kept.items() if key != first}


def read_free(reading: Reading) -> dict[str, dict[str, float]]:
    """Return the free keys of a document with their values in SI; note their faults."""
    path = (FIT_KEY, "free")
    free = get_block(get_block(reading.values, FIT_KEY), "free")
    numeric = numeric_keys(reading.model, reading.values)
    fit_keys = {
        **numeric,
        DELAY_KEY: NumericKey(Quantity("s"), float, None, {}, False),
        OFFSET_KEY: None,
    }
    # What an unknown key may be; nobody fits how a file is read.
    fitted = [
        key
        for key, numeric_key in numeric.items()
        if numeric_key and key.partition(".")[0] in FITTED_BLOCKS and "normal_record" not in key
    ]
    fitted += [DELAY_KEY, OFFSET_KEY]
    # The options of all other laws would be too many to list.
    listed = ", ".join(key for key in fitted if key.split(".")[1] not in LAWS)
    options_by_key = {}
    for key, options in free.items():
        sentence = ""
        if key not in fit_keys:
            hint = (
                other_laws_hint(str(key).removeprefix("friction."))
                or did_you_mean(closest_match(str(key), fitted))
                or f"; use one of {listed}"
            )
            sentence = f"{format_value(key)} is no key of this scenario{hint}"
        elif fit_keys[key] is None and key != OFFSET_KEY:
            sentence = f"{format_value(key)} is no numeric key"
        elif key.partition(".")[0] not in FITTED_BLOCKS:
            sentence = f"{key} cannot be fitted, only keys of {join_words(FITTED_BLOCKS, 'or')}"
        if sentence:
            reading.fault(sentence, (*path, key), at_key=True)
        elif isinstance(options, Mapping):
            options_by_key[key] = _read_options(reading, fit_keys[key], options, (*path, key))
        else:
            form = f"a block of {', '.join(FREE_OPTIONS)}, or {{}}"
            reading.report_value(f"must be {form}, not {format_value(options)}", (*path, key))
    if free and not options_by_key:
        reading.reported.add(path)  # an empty block would be reported again
    # Of a placeholder nothing else is said.
    missing = {key: tuple(key.split(".")) for key in missing_values(reading.document.value)}
    faulty = {
        key
        for key in missing
        if any(reported[:3] == (*path, key) for reported in reading.reported)
    }
    reading.problems[:] = [problem for problem in reading.problems if problem.key not in faulty]
    reading.reported |= {missing[key] for key in faulty}
    return options_by_key


def _read_options(
    reading: Reading, numeric_key: Any, options: Mapping[str, Any], path: tuple[str, ...]
) -> dict[str, float]:
    """Return start and bounds of a free key in SI; note their faults."""
    values: dict[str, float] = {}
    for word, value in options.items():
        if word not in FREE_OPTIONS or numeric_key is None:
            use = f"use {', '.join(FREE_OPTIONS)}" if numeric_key is not None else "write {}"
            sentence = f"unknown key {format_value(word)} in {spoken_name(path)}; {use}"
            reading.fault(sentence, (*path, word), at_key=True)
            continue
        with reading.reporting((*path, word)):
            values[word] = numeric_key.read(value)
    low, high = values.get("from", -inf), values.get("to", inf)
    least, most = numeric_key.quantity.ends if numeric_key is not None else (-inf, inf)
    if not low < high:
        reading.report_value(f"must be above `from`, {low:.12g}", (*path, "to"))
    elif not low < most:
        reading.report_value(f"must be below {most:.12g}, the largest value", (*path, "from"))
    elif not least < high:
        reading.report_value(f"must be above {least:.12g}, the smallest value", (*path, "to"))
    elif not low <= values.get("start", low) <= high:
        reading.report_value("must lie between `from` and `to`", (*path, "start"))
    return values
