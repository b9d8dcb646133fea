"""Blocks of a scenario other than excitation and friction, and their field types.

Oscillator, stroke with end stops, start, solver and measure; the text of checks; the format
version and the name. `FromFile` keeps the document that a scenario was read from. Rules between
blocks are in `model`.
"""

import re
from collections.abc import Callable, Mapping
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    PrivateAttr,
    StrictBool,
    ValidationInfo,
    WithJsonSchema,
    create_model,
    field_validator,
    model_validator,
)

from drysim.approach import APPROACHES_BY_NAME, EXACT, Approach
from drysim.block import Block, InvalidValue, PlainOrBlock
from drysim.core.model import (
    MAX_STAGES,
    CoulombLaw,
    EndStops,
    PiecewiseLaw,
    Plant,
    State,
    StrokeLimits,
)
from drysim.direction import (
    DirectedDamping,
    by_direction,
    depends_on_direction,
    mean_of_directions,
)
from drysim.errors import Problem
from drysim.messages import format_value, name_hint
from drysim.metrics.checks import Check
from drysim.metrics.comfort import DIRECTIONS
from drysim.metrics.table import sqrt
from drysim.quantity import Damping, Length, Mass, Quantity, Stiffness, Velocity
from drysim.scenario.laws import LAWS
from drysim.yaml_document import Document, KeyPath

SEED_KEY = "excitation.seed"


class Oscillator(Block):
    """A mass on a spring and a viscous damper."""

    mass: Mass
    """Sprung mass m [kg], above 0."""
    stiffness: Stiffness | None = None
    """Spring stiffness k_x [N/m]; 0 for none."""
    natural_frequency: Annotated[float, Quantity("Hz", at_least=0)] | None = None
    """Natural frequency f_0 = √(k_x/m)/2π [Hz], instead of `stiffness`; 0 for no spring."""
    damping: DirectedDamping | None = None
    """Viscous damping b [N·s/m]; 0 for none. One value, or
    `{extension: ..., compression: ...}` for v_r > 0 and v_r < 0."""
    damping_ratio: Annotated[float, Quantity("", at_least=0)] | None = None
    """Damping ratio b/(2√(k_x m)) [-], instead of `damping`; needs a spring."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("stiffness", "natural_frequency"),
        ("damping", "damping_ratio"),
    )

    @model_validator(mode="after")
    def _ratio_needs_a_spring(self) -> Self:
        if self.damping_ratio is not None and 0 in (self.stiffness, self.natural_frequency):
            raise InvalidValue(
                f"needs a {self.spring_key} above 0; give `damping` instead", "damping_ratio"
            )
        return self

    @property
    def spring_key(self) -> str:
        """The key that states the spring: stiffness or natural_frequency."""
        return "stiffness" if self.natural_frequency is None else "natural_frequency"

    def plant(self) -> Plant:
        """Return mass, stiffness and damping as numbers; the damping is the mean of both."""
        k_x = self.stiffness
        if self.natural_frequency is not None:
            omega = 2 * pi * self.natural_frequency
            k_x = self.mass * (omega * omega)
        assert k_x is not None, "one of the two is given"
        if self.damping is not None:
            return Plant(self.mass, k_x, mean_of_directions(self.damping))
        assert self.damping_ratio is not None, "one of the two is given"
        critical = 2 * sqrt(k_x * self.mass)
        return Plant(self.mass, k_x, self.damping_ratio * critical)

    def without_direction(self) -> Self:
        """Return the oscillator with the mean damping in both directions."""
        return self.model_copy(update={"damping": mean_of_directions(self.damping)})

    @property
    def damping_pair(self) -> tuple[float, float] | None:
        """Damping of extension and compression [N·s/m], where they differ."""
        return by_direction(self.damping) if depends_on_direction(self.damping) else None


class Stage(Block):
    """Linear stage of a bumper."""

    begin: Annotated[float, Quantity("m", at_least=0)] = Field(alias="from")
    """Penetration at which the stage begins [m]; 0 for the first one."""
    stiffness: Annotated[float, Quantity("N/m", above=0)]
    """Stiffness of the bumper from there on [N/m], above 0."""


class Stops(Block):
    """End stops at both ends of the stroke: elastic bumpers or rigid stops.

    Notes
    -----
    A bumper is a spring and a damper that push and never pull. With xi the signed displacement
    beyond the limit, F_stop = stiffness xi + damping v_r as long as it has the sign of xi, else
    0; with damping, contact is lost before x_r is back at the limit. The spring may have up to
    three linear stages. A rigid stop changes v_r to -restitution v_r; a sequence of ever
    smaller rebounds ends at rest against the stop.
    """

    stiffness: Annotated[float, Quantity("N/m", above=0)] | None = None
    """Stiffness of a bumper [N/m], above 0."""
    stages: Annotated[tuple[Stage, ...], Field(min_length=1, max_length=MAX_STAGES)] | None = (
        None
    )
    """Up to three linear stages of a bumper, in place of `stiffness`."""
    damping: Damping | None = None
    """Damping of a bumper [N·s/m]; default: 0."""
    restitution: Annotated[float, Quantity("", at_least=0, at_most=1)] | None = None
    """Coefficient of restitution of a rigid stop [-], 0 to 1: speed after over speed before an
    impact. Instead of `stiffness`."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("stiffness", "stages", "restitution"),)

    @model_validator(mode="after")
    def _check_bumper(self) -> Self:
        if self.damping is not None and self.restitution is not None:
            raise InvalidValue("requires stiffness or stages", "damping")
        begins = [stage.begin for stage in self.stages or ()]
        for i, begin in enumerate(begins):
            if i == 0 and begin != 0.0:
                raise InvalidValue(
                    f"must be 0 for the first stage, not {begin:.12g}", "stages", 0, "from"
                )
            if i > 0 and begin <= begins[i - 1]:
                least = f"above that of the stage before, {begins[i - 1]:.12g} m"
                raise InvalidValue(f"must be {least}, not {begin:.12g}", "stages", i, "from")
        return self

    def with_friction(
        self, law: CoulombLaw | PiecewiseLaw, limits: StrokeLimits
    ) -> PiecewiseLaw:
        """Return the law with stops at the stroke limits and friction between them."""
        stages = () if self.stiffness is None else ((0.0, self.stiffness),)
        below = 0.0
        for stage in self.stages or ():
            stages = (*stages, (stage.begin, stage.stiffness - below))
            below = stage.stiffness
        stops = EndStops(
            StrokeLimits(*limits), stages, self.damping or 0.0, self.restitution or 0.0
        )
        return law.as_piecewise()._replace(stops=stops)


Travel = Annotated[float, Quantity("m", above=0)]


class LimitBySide(Block):
    """Stroke limits that differ between the sides."""

    up: Travel
    """Limit of x_r > 0 [m], above 0."""
    down: Travel
    """Limit of x_r < 0 [m], above 0."""


def _both_sides(limit: Any) -> tuple[float, float]:
    """Return the limits of x_r > 0 and x_r < 0."""
    return (limit.up, limit.down) if isinstance(limit, LimitBySide) else (limit, limit)


class Stroke(Block):
    """Permitted motion of the mass on its base."""

    limit: PlainOrBlock[Travel, LimitBySide]
    """Stroke limit x_rM [m], below which the mass must stay on either side: one value, half of
    the total travel, or `{up: ..., down: ...}` for x_r > 0 and x_r < 0. Without `stops` it is
    only checked."""
    offset: Length | None = None
    """Position of the working point x_r = 0 above the point from which `limit` counts [m]:
    positive under a load that is lighter than intended, negative under a heavier one. The
    limits are `up` - offset and `down` + offset. Default: 0."""
    stops: Stops | None = None
    """End stops at the limit, elastic bumpers (`stiffness` or `stages`) or rigid stops
    (`restitution`); without this block the mass moves beyond it. Supported for the laws
    `coulomb`, `jenkins` and `petrov-ewins`, and without friction."""

    @field_validator("offset", mode="wrap")
    @classmethod
    def _leave_room_to_move(
        cls, value: object, read: Callable[[object], float | None], info: ValidationInfo
    ) -> float | None:
        offset = read(value)
        if offset is not None and "limit" in info.data:
            up, down = _both_sides(info.data["limit"])
            if not -down < offset < up:
                bounds = f"above {-down:.12g} m and below {up:.12g} m"
                raise ValueError(
                    f"must be {bounds}, the limits of the stroke, not {format_value(value)}"
                )
        return offset

    @property
    def limits(self) -> StrokeLimits:
        """Limits as seen from the working point."""
        up, down = _both_sides(self.limit)
        offset = 0.0 if self.offset is None else self.offset
        return StrokeLimits(up - offset, down + offset)

    @property
    def has_sides(self) -> bool:
        """Whether the file tells the sides apart."""
        return isinstance(self.limit, LimitBySide) or self.offset is not None


class Start(Block):
    """State at t = 0; default: at rest, spring relaxed."""

    x_r: Length = 0.0
    """Relative displacement [m]."""
    v_r: Velocity = 0.0
    """Relative velocity [m/s]."""

    def state(self) -> State:
        """Return the state as numbers."""
        return State(self.x_r, self.v_r)


def validate_approach(name: str) -> str:
    """Return the name of an existing approach.

    Raises
    ------
    ValueError
        If there is no such approach; the message names the known ones.
    """
    if name not in APPROACHES_BY_NAME:
        hint = "; it is a friction law: set friction.law"
        hint = hint if name in LAWS else name_hint(name, APPROACHES_BY_NAME)
        raise ValueError(f"unknown approach {format_value(name)}{hint}")
    return name


ApproachName = Annotated[str, AfterValidator(validate_approach)]


class SolverBase(Block):
    """How the motion is computed."""

    approach: ApproachName = EXACT
    """Name of the approach."""
    step: Annotated[float, Quantity("s", above=0)] | None = None
    """Time step of the output grid [s]; not for a record, which has its own. Required where
    base motion is sampled (noise, sine sweep, shock) and by approaches of fixed steps; default
    otherwise: a hundredth of the shortest period."""

    def member(self) -> Approach:
        """Return the approach with its options."""
        chosen: Approach = (
            getattr(self, self.approach, None) or APPROACHES_BY_NAME[self.approach]()
        )
        return chosen


def solver_with_options(approaches: dict[str, Any]) -> type[SolverBase]:
    """Return the solver model with an options block for each approach that has options."""
    options: dict[str, Any] = {
        name: (member | None, Field(None, description=f"Options of approach {name}."))
        for name, member in approaches.items()
        if len(member.model_fields) > 1
    }
    return create_model("Solver", __base__=SolverBase, __module__=__name__, **options)


if TYPE_CHECKING:
    Solver = SolverBase
else:
    Solver = solver_with_options(APPROACHES_BY_NAME)  # found here by name when unpickling


class SpectraOptions(Block):
    """Which spectra a run computes, in place of `true`."""

    bands: Literal["third-octave"]
    """RMS acceleration of base and mass in one-third-octave bands from 0.5 to 80 Hz, with the
    weighting, too, if there is one."""


def _check_spectra(value: object) -> object:
    """Return a boolean; the message on any other word names the block."""
    if not isinstance(value, bool):
        form = "true, false or `{bands: third-octave}`"
        raise ValueError(f"must be {form}, not {format_value(value)}")
    return value


class DailyExposure(Quantity):
    """Duration that is usually stated in hours, which a bare number does not mean."""

    def read(self, value_in: object) -> float:
        """Return the duration [s]; the message on a small bare number names hours."""
        if isinstance(value_in, int | float) and value_in is not True and 0 < value_in <= 24:
            least = f"must be at least {self.at_least:g} s, not {format_value(value_in)}"
            hint = f"a number is in seconds: write `{value_in:g} h` for hours"
            raise ValueError(f"{least}; {hint}")
        return super().read(value_in)


class Measure(Block):
    """Time window of the metrics."""

    steady: StrictBool = False
    """Whether the metrics cover exactly one period of the steady state reached from the start;
    default: true for harmonic excitation without settle and duration."""
    settle: Annotated[float, Quantity("s", at_least=0)] = 0.0
    """Time before the window [s], or `20 periods`."""
    duration: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of the window [s], or `20 periods`; default: to the end of the record. After a
    base motion that ends at rest the run goes on, with the base at rest, until the ring-down
    has passed its peaks; these count, RMS values keep to the window."""
    coexisting: StrictBool | None = None
    """Whether a run of a steady state searches for other stable motions; default: true where
    they may exist, with Coulomb friction and F_fs above F_fk."""
    direction: Literal["vertical", "horizontal"] | None = None
    """Direction of vibration for a seated person; selects the weighting of ISO 2631-1 and its
    factor: vertical Wk with k = 1, horizontal Wd with k = 1.4 (directive 2002/44/EC, annex
    B.1). Adds a_w, SEAT, VDV, SEAT_VDV, MTVV and crest_factor."""
    weighting: Literal["Wk", "Wd", "Wc"] | None = None
    """Frequency weighting of ISO 2631-1, with k = 1; with `direction` it must be the weighting
    of that direction."""
    exposure: Annotated[float, DailyExposure("s", at_least=60, at_most=86400)] | None = None
    """Duration of exposure a day [s], such as `4 h`, at least 60 s; adds the daily exposures
    A_8 and VDV_day, which need a weighting."""
    spectra: PlainOrBlock[Annotated[bool, BeforeValidator(_check_spectra)], SpectraOptions] = (
        False
    )
    """Whether a run computes the spectra of base and mass and the transmissibility H1; for
    random base motion and records. `{bands: third-octave}` adds RMS values in bands."""
    segment: Annotated[float, Quantity("s", above=0)] | None = None
    """Length of a segment for the spectra [s], which a run then computes, as an assessment
    always does; the frequency resolution is 1/segment. Default:
    8 natural periods, at least 5 s (longer without friction if the resonance is narrower than
    the resolution), at most an eighth of the window."""

    @model_validator(mode="before")
    @classmethod
    def _ask_for_spectra(cls, block: Any) -> Any:
        """Compute the spectra whose segment is stated."""
        if isinstance(block, dict) and block.get("segment") is not None:
            return {"spectra": True, **block}
        return block

    @model_validator(mode="after")
    def _agree(self) -> Self:
        expected = DIRECTIONS[self.direction][0] if self.direction else self.weighting
        if self.weighting != expected and self.weighting:
            raise InvalidValue(
                f"must be {expected} with `direction: {self.direction}`, not {self.weighting}; "
                "remove one of them",
                "weighting",
            )
        if self.exposure is not None and self.weights is None:
            raise InvalidValue("requires `direction` or `weighting`", "exposure")
        if self.segment is not None and not self.spectra:
            raise InvalidValue(
                "is that of spectra, which `spectra: false` turns off", "segment"
            )
        return self

    @property
    def bands(self) -> bool:
        """Whether RMS values in one-third-octave bands are computed."""
        return isinstance(self.spectra, SpectraOptions)

    @property
    def weights(self) -> tuple[str, float] | None:
        """Frequency weighting and multiplying factor k [-]; None if there is no weighting."""
        if self.direction:
            return DIRECTIONS[self.direction]
        return (self.weighting, 1.0) if self.weighting else None

    def without_weights(self) -> Self:
        """Return the block without weighting, for studies that need no weighted metrics."""
        return self.model_copy(update={"direction": None, "weighting": None, "exposure": None})


MAX_CHECKS = 1000
"""Maximum number of checks; more are a mistake or an attack."""


def _parse_check(value: object) -> Check:
    if not isinstance(value, str | Check):
        raise ValueError(
            f"write `metric < value`, such as `T_a < 1.5`, not {format_value(value)}"
        )
    return value if isinstance(value, Check) else Check.parse(value)


def _limit_checks(value: object) -> object:
    """Reject a list that is too long before parsing it."""
    if isinstance(value, list | tuple) and len(value) > MAX_CHECKS:
        raise ValueError(f"must have at most {MAX_CHECKS} entries, not {len(value)}")
    return value


CheckText = Annotated[
    Check,
    PlainValidator(_parse_check),
    PlainSerializer(str),
    WithJsonSchema({"type": "string", "pattern": "^.*[<>=].*$", "examples": ["T_a < 1.5"]}),
]
Checks = Annotated[
    tuple[CheckText, ...], BeforeValidator(_limit_checks), Field(max_length=MAX_CHECKS)
]


# Format version and name

FORMAT_VERSION = 1
"""Version of the file format."""

MAX_NAME_LENGTH = 100
"""Maximum length of a name, so that it is a valid folder name everywhere."""

NAME_PATTERN = re.compile(r"[^\W_]([\w .-]*[\w-])?")
"""Pattern of valid names."""

WINDOWS_DEVICE = re.compile(r"(?i)(con|prn|aux|nul|com[1-9]|lpt[1-9])(\..*)?")
"""Names reserved for devices on Windows, with any extension."""


def _validate_version(version: object) -> object:
    if version is True or version != FORMAT_VERSION:
        rule = f"must be {FORMAT_VERSION}, the format version that this release reads"
        raise ValueError(f"{rule}, not {format_value(version)}")
    return FORMAT_VERSION


def invalid_name_reason(name: str) -> str:
    """Return why a name is not valid for a folder; empty if it is."""
    if len(name) > MAX_NAME_LENGTH:
        return f"must have at most {MAX_NAME_LENGTH} characters, not {len(name)}"
    if name.endswith(".partial"):
        end = "must not end in `.partial`, which marks unfinished output"
        return f"{end}, as {format_value(name)} does"
    if WINDOWS_DEVICE.fullmatch(name):
        return f"must not be a reserved device name of Windows, not {format_value(name)}"
    if not NAME_PATTERN.fullmatch(name):
        return (
            "must be letters, digits, spaces, `.`, `_` and `-`, a letter or digit first and "
            f"no space or `.` last, not {format_value(name)}"
        )
    return ""


def _validate_folder_name(name: str) -> str:
    if reason := invalid_name_reason(name):
        raise ValueError(f"{reason}; the output folder is named after it")
    return name


Format = Annotated[int, BeforeValidator(_validate_version)]
"""Supported version of the file format."""

FolderName = Annotated[str, AfterValidator(_validate_folder_name)]
"""Name that is valid for the output folder."""


class FromFile(Block):
    """Model read from a file, with the position of each value in the file."""

    _document: Document | None = PrivateAttr(default=None)
    _block_cache: dict[Any, Block] = PrivateAttr(default_factory=dict)
    _compared_law: str = PrivateAttr(default="")

    def model_post_init(self, context: Any, /) -> None:
        """Keep the document passed in the validation context."""
        if isinstance(context, Mapping):
            self._document = context.get("document")

    @property
    def document(self) -> Document | None:
        """The file that the model was read from."""
        return self._document

    @property
    def folder(self) -> Path:
        """Folder that paths of records are relative to."""
        return Path(self._document.file).parent if self._document else Path()

    @property
    def origin(self) -> dict[str, Any]:
        """File name, SHA-256 and overrides as plain values."""
        document = self._document
        if document is None:
            return {"file": "", "sha256": "", "overrides": {}}
        file = Path(document.file).name
        return {"file": file, "sha256": document.sha256, "overrides": dict(document.overrides)}

    def problem(self, sentence: str, key: str | KeyPath) -> Problem:
        """Return the located problem of a key, for faults found only during a run."""
        keys = tuple(key.split(".")) if isinstance(key, str) else key
        name = ".".join(map(str, keys))
        if self._document is None:
            return Problem(sentence, key=name)
        return self._document.locate(keys).problem(sentence, name)

    def file_block(self, name: str) -> dict[str, Any]:
        """Return a block as in the file, with overrides."""
        return dict((self._document.value if self._document else {}).get(name) or {})

    @property
    def compared_law(self) -> str:
        """Friction law used in a comparison instead of that of the file; empty for none."""
        return self._compared_law

    @property
    def block_cache(self) -> dict[Any, Block]:
        """Cache of modified blocks, by the swept values in them."""
        return self._block_cache

    def copy_with(self, fields: Mapping[str, Any], law: str = "") -> Self:
        """Return a copy with some fields replaced by valid values, without validation.

        `law` is the friction law used in a comparison instead of that of the file.
        """
        copy = self.model_copy(update=fields)
        copy._block_cache = {}
        copy._compared_law = law or self._compared_law
        return copy
