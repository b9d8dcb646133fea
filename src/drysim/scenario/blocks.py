"""The blocks of a scenario: oscillator, start, stroke, stops, solver."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    PrivateAttr,
    create_model,
    field_validator,
    model_validator,
)

from drysim.approach import EXACT, SHELF, Approach
from drysim.core.model import Law, Plant, State, Stopped
from drysim.errors import Problem
from drysim.metrics import BOUNDED, COMFORT, LIMITED, UNITS, root
from drysim.scenario.reading import LAWS, block_in
from drysim.units import (
    Block,
    Damping,
    Length,
    Mass,
    Misfit,
    Quantity,
    Stiffness,
    Velocity,
    meant_or_known,
    shown,
)
from drysim.yaml_document import Document, Keys

# The blocks of a scenario that stand on no shelf.


class Oscillator(Block):
    """A mass on a spring and a viscous damper."""

    mass: Mass
    """Sprung mass m [kg], above 0."""
    stiffness: Stiffness
    """Spring stiffness k_x [N/m]; 0 for none."""
    damping: Damping | None = None
    """Viscous damping b [N·s/m]; 0 for none."""
    damping_ratio: Annotated[float, Quantity("", at_least=0)] | None = None
    """Damping ratio b/(2√(k_x m)) [-], in place of `damping`; needs a stiffness above 0."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("damping", "damping_ratio"),)

    @model_validator(mode="after")
    def _ratio_needs_a_spring(self) -> Self:
        if self.damping_ratio is not None and self.stiffness == 0:
            raise Misfit("needs a stiffness above 0; give `damping` instead", "damping_ratio")
        return self

    def plant(self) -> Plant:
        """Give mass, stiffness and damping as numbers."""
        if self.damping is not None:
            return Plant(self.mass, self.stiffness, self.damping)
        assert self.damping_ratio is not None, "one of both is given"
        critical = 2 * root(self.stiffness * self.mass)
        return Plant(self.mass, self.stiffness, self.damping_ratio * critical)


class Stops(Block):
    """End stops at both ends of the stroke: bumpers that give way, or rigid ones.

    Notes
    -----
    A bumper is a spring and a damper that push and never pull: with xi how far x_r is beyond
    the limit, F_stop = stiffness xi + damping v_r while both xi and that force point outwards,
    else 0. Contact is lost where the force falls to zero, which with damping is before x_r is
    back at the limit. A rigid stop turns v_r into -restitution v_r; rebounds too low to be seen
    in x_r end in rest against it.
    """

    stiffness: Annotated[float, Quantity("N/m", above=0)] | None = None
    """Stiffness of a bumper [N/m], above 0."""
    damping: Damping | None = None
    """Damping of a bumper [N·s/m]; default 0."""
    restitution: Annotated[float, Quantity("", at_least=0, at_most=1)] | None = None
    """Speed after an impact on a rigid stop over that before [-], 0 to 1, in place of
    `stiffness`."""

    one_of: ClassVar[tuple[tuple[str, ...], ...]] = (("stiffness", "restitution"),)
    needs: ClassVar[dict[str, str]] = {"damping": "stiffness"}

    def between(self, law: Law, limit: float) -> Stopped:
        """Give these stops, `limit` m from the middle, with the friction between them."""
        F_fk, F_fs, *varied = law
        k_s, b_s, e = self.stiffness or 0.0, self.damping or 0.0, self.restitution or 0.0
        return Stopped(F_fk, F_fs, limit, k_s, b_s, e, *varied)


class Stroke(Block):
    """How far the mass may move on its base."""

    limit: Annotated[float, Quantity("m", above=0)]
    """Stroke limit x_rM [m]: |x_r| must stay below it. Checked, and modelled beside `stops`."""
    stops: Stops | None = None
    """What the mass meets at the limit; without this block it moves on beyond it. Goes with law
    `coulomb` under a normal force that stays above zero and is no record, and without
    friction."""


class Start(Block):
    """The state at t = 0; default: at rest, the spring relaxed."""

    x_r: Length = 0.0
    """Relative displacement [m]."""
    v_r: Velocity = 0.0
    """Relative velocity [m/s]."""

    def state(self) -> State:
        """Give the state as numbers."""
        return State(self.x_r, self.v_r)


class Solver(Block):
    """How the motion is computed."""

    approach: str = EXACT
    """Name of the approach."""
    step: Annotated[float, Quantity("s", above=0)] | None = None
    """Distance of the output grid [s]; a record owns its step."""

    @field_validator("approach")
    @classmethod
    def _on_the_shelf(cls, name: str) -> str:
        return on_the_shelf(name)

    def member(self) -> Approach:
        """Give the approach with its options."""
        chosen: Approach = getattr(self, self.approach, None) or SHELF[self.approach]()
        return chosen


def on_the_shelf(name: str) -> str:
    """Give the name of an approach that there is; a ValueError says which there are."""
    if name not in SHELF:
        hint = "; it is a friction law: friction.law takes it"
        hint = hint if name in LAWS else meant_or_known(name, SHELF)
        raise ValueError(f"unknown approach {shown(name)}{hint}")
    return name


def with_options(shelf: dict[str, Any]) -> type[Solver]:
    """Give the solver block in which every approach that has options has a block of its own."""
    options: dict[str, Any] = {
        name: (member | None, Field(None, description=f"Options of {name}."))
        for name, member in shelf.items()
        if len(member.model_fields) > 1
    }
    # Pickling finds a class by module and name: that of the block above is taken here.
    home = "drysim.scenario.model"
    return create_model("Solver", __base__=Solver, __module__=home, **options)


# What a scenario knows of the file that it was read from, and of its own words.


class FromFile(Block):
    """Blocks that were read from a file and can tell where each of their words stands."""

    _document: Document | None = PrivateAttr(default=None)
    _words: dict[str, dict[str, Any]] = PrivateAttr(default_factory=dict)
    _kept: dict[Any, Block] = PrivateAttr(default_factory=dict)
    _named_law: str = PrivateAttr(default="")

    def model_post_init(self, context: Any, /) -> None:
        """Keep the document, which the context of the validation names."""
        if isinstance(context, Mapping):
            self._document = context.get("document")

    @property
    def folder(self) -> Path:
        """The folder that the paths of records are relative to."""
        return Path(self._document.file).parent if self._document else Path()

    @property
    def origin(self) -> dict[str, Any]:
        """Name of the file, its SHA-256 and the overrides, as plain values."""
        read = self._document
        if read is None:
            return {"file": "", "sha256": "", "overrides": {}}
        file = Path(read.file).name
        return {"file": file, "sha256": read.sha256, "overrides": dict(read.overrides)}

    def problem(self, sentence: str, key: str | Keys) -> Problem:
        """Give the located problem of a key, for faults that only a run can find."""
        keys = tuple(key.split(".")) if isinstance(key, str) else key
        name = ".".join(map(str, keys))
        if self._document is None:
            return Problem(sentence, key=name)
        return self._document.locate(keys).problem(sentence, name)

    def spoken(self, name: str) -> dict[str, Any]:
        """Give the words of a block as the file says them, overrides included."""
        return dict((self._document.value if self._document else {}).get(name) or {})

    def words_of(self, name: str) -> dict[str, Any]:
        """Give the words of a block as it is now; empty where there is none."""
        if name not in self._words:
            block = getattr(self, name, None)
            if not isinstance(block, Block):
                return {}
            self._words[name] = block.model_dump(by_alias=True, exclude_none=True)
        return self._words[name]

    @property
    def named_law(self) -> str:
        """The friction law that a comparison names in place of the file's; empty for none."""
        return self._named_law

    @property
    def kept(self) -> dict[Any, Block]:
        """Blocks that were made from these and will be wanted again."""
        return self._kept

    def copied(self, changed: Mapping[str, Any], law: str = "") -> Self:
        """Give a copy with other values in some fields, which must be valid ones.

        `law` is the friction law that a comparison names in place of the file's.
        """
        copy = self.model_copy(update=changed)
        copy._words, copy._kept = {}, {}
        copy._named_law = law or self._named_law
        return copy


# What a scenario file says about itself: the version of its format, and its name.


FORMAT = 1
"""Version of the file format."""

LONGEST = 100
"""Characters of a name, so that a folder can have it everywhere."""

NAME = re.compile(r"[^\W_]([\w .-]*[\w-])?")
"""What a name is written with."""

DEVICE = re.compile(r"(?i)(con|prn|aux|nul|com[1-9]|lpt[1-9])(\..*)?")
"""What no folder of Windows can be called, whatever stands behind the point."""


def _known(version: object) -> object:
    if version is True or version != FORMAT:
        reads = f"must be {FORMAT}, the file format that this drysim reads"
        raise ValueError(f"{reads}, not {shown(version)}")
    return FORMAT


def unfit(name: str) -> str:
    """Say why a name is none for a folder; nothing when it is."""
    if len(name) > LONGEST:
        return f"must have at most {LONGEST} characters, not {len(name)}"
    if name.endswith(".partial"):
        return f"must not end as a folder of unfinished work does, like {shown(name)}"
    if DEVICE.fullmatch(name):
        return f"must not be what Windows calls a device by, like {shown(name)}"
    if not NAME.fullmatch(name):
        return (
            "must be letters, digits, spaces, `.`, `_` and `-`, a letter or digit first and "
            f"no space or `.` last, not {shown(name)}"
        )
    return ""


def _of_a_folder(name: str) -> str:
    if reason := unfit(name):
        raise ValueError(f"{reason}; the output folder is named after it")
    return name


Format = Annotated[int, BeforeValidator(_known)]
"""A version of the file format that this drysim reads."""

FolderName = Annotated[str, AfterValidator(_of_a_folder)]
"""A name that the output folder can have."""


# Rules about many seeds: what their interval may be of, and what may vary beside them.


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
