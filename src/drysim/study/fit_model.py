"""What a fit compares: the measured response, and the exact motion at the same instants.

`read_measurement` reads the channels and places them on the time axis of the base motion.
`FitModel.solve` solves the scenario with other values of its free keys; `Solved` has the same
channels of that motion and their derivatives. A friction rig has no dynamics: its motion is
imposed, which is the motion of a mass so heavy that no friction force accelerates it, so that
every friction law is evaluated by the same exact solution.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product
from math import ceil, floor
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from drysim.approach.solution import Response
from drysim.approach.stick_slip import StickSlip
from drysim.core.model import AnyLaw, DynamicLaw, Floats, Input, Plant, Samples, Sines, State
from drysim.errors import SolverError, WarningMessage
from drysim.records import SI
from drysim.records.clean import CleaningReport, Series
from drysim.records.columns import record_error
from drysim.records.level import Level, is_gravity, measure_level
from drysim.records.record import find_column, read_samples, read_series
from drysim.scenario.fit import (
    DEFAULT_HOLD_OUT,
    DELAY_KEY,
    OFFSET_KEY,
    START_KEYS,
    ChannelRecord,
    Fit,
    Measurements,
)
from drysim.scenario.keys import numeric_keys
from drysim.scenario.model import Scenario, law_uses_key
from drysim.study.budget import memory_shortage, shortage_message
from drysim.study.case import Case
from drysim.study.preparation import assemble, base_motion, locating_records
from drysim.study.starting_values import (
    Kinematics,
    closed_form_starts,
    decay_start,
    relative_motion,
)
from drysim.study.statistics import max_seeds
from drysim.wording import format_count, format_number

if TYPE_CHECKING:
    from drysim.excitation.recorded import Record

RIG_MASS = 1e15
"""Mass that no friction force accelerates [kg]."""

GRID_TOLERANCE = 1e-3
"""Largest distance of a measured sample from the grid of the base motion, in steps."""

NUMBER_STEP = 1e-7
"""Step of the derivatives of the numbers of a scene by the values of its keys, relative to
these. The numbers are products, ratios and roots of few values: its error is of this size."""

SLOW = 0.1
"""Share of the largest velocity of a rig below which the sign of its friction is uncertain."""

MIN_SAMPLES = 50
"""Number of samples below which nothing is fitted."""

BYTES_PER_SAMPLE = 3000.0
"""Memory of a fit for each measured sample; measured: 2,600 with four parameters."""

STATIC_KEYS = {
    "friction.kinetic": "friction.static",
    "friction.mu_kinetic": "friction.mu_static",
}
"""Key of the static limit, which is never below kinetic friction, by that of the latter."""

FROZEN = "record-frozen"
"""Warning about a value that is repeated amid a motion."""

UNCERTAIN, OUTSIDE = 2, 3
"""Modes of a sample between two modes, and of one that a delay moves out of the motion."""


class Measurement(NamedTuple):
    """The measured response on the time axis of the base motion."""

    channels: dict[str, Floats]
    """Samples of each channel in SI, shape (n,)."""
    t: Floats
    """Times [s], from the start of the base motion."""
    first: int
    stride: int
    """Index of the first sample on the grid of the base motion, and grid steps per sample."""
    inputs: tuple[Input, ...]
    warnings: tuple[WarningMessage, ...]
    imposed: float = 0.0
    """First velocity or displacement that a rig imposes, in SI; its time is 0."""
    file_spacing: float = 0.0
    """Time step of the samples in the file, before a resampling [s]; 0 if not known."""
    clean_up: tuple[tuple[str, CleaningReport], ...] = ()
    """Name of a channel, and a step of its clean-up."""
    scales: Mapping[str, float] = {}
    """Stated factor of each channel [-]."""

    @property
    def dt(self) -> float:
        """Time step, of uneven times the mean [s]."""
        return float(self.t[-1] - self.t[0]) / (len(self.t) - 1)


class Prediction(NamedTuple):
    """Computed channels at the measured instants."""

    channels: dict[str, Floats]
    """Samples of each channel in SI, shape (n,)."""
    mode: NDArray[np.int8]
    """Direction of sliding, 0 where stuck. Acceleration and friction force jump where it
    changes."""

    @property
    def covers(self) -> NDArray[np.bool_]:
        """Whether a free delay leaves the sample within the motion."""
        inside: NDArray[np.bool_] = self.mode != OUTSIDE
        return inside


class Trial(NamedTuple):
    """Plant, friction law and start of a motion, at trial values of the free keys."""

    plant: Plant
    law: AnyLaw
    start: State


def is_valid_scene(law: AnyLaw, start: State) -> bool:
    """Return whether values that are within their bounds agree, as a scenario demands."""
    extension, compression = (law.F_fk, law.F_fs), law.compression or (law.F_fk, law.F_fs)
    if (
        extension[1] < extension[0]
        or compression[1] < compression[0]
        or (extension[0] == 0.0) != (compression[0] == 0.0)
    ):
        return False
    if law.F_fk == 0.0 and (isinstance(law, DynamicLaw) or law.is_elastic):
        return False
    if law.stops is None:
        return True
    begins, (up, down) = [begin for begin, _ in law.stops.stages], law.stops.limits
    if min(up, down) <= 0.0 or any(b <= a for a, b in pairwise(begins)):
        return False
    within = -down <= start.x_r <= up
    return not law.stops.rigid or (within and not (law.is_elastic and law.varies))


class Places(NamedTuple):
    """Places of the measured instants on the grid of a response."""

    low: Any
    """Grid point at or before each instant."""
    share: Floats | None
    """Part of the step from there; None where all instants are grid points."""
    mode: NDArray[np.int8]
    """As in `Prediction`."""
    step: float
    """Step of the grid [s]."""

    @classmethod
    def at_points(cls, response: Response, first: int, stride: int, count: int) -> Places:
        """Return the places of grid points, of which the last may be one too many."""
        last = first + stride * (count - 1)
        points: Any = slice(first, last + 1, stride)
        if last >= len(response):
            points = np.minimum(first + stride * np.arange(count), len(response) - 1)
        return cls(points, None, response.d[points], response.dt)

    @classmethod
    def between_points(cls, response: Response, place: Floats) -> Places:
        """Return places by their number of steps from the first grid point."""
        last = len(response) - 1.0
        inside = (place >= -GRID_TOLERANCE) & (place <= last + GRID_TOLERANCE)
        place = np.clip(place, 0.0, last)
        low = np.minimum(place.astype(np.int64), len(response) - 2)
        same = response.d[low] == response.d[low + 1]
        mode = np.where(same, response.d[low], UNCERTAIN)
        mode = np.where(inside, mode, OUTSIDE).astype(np.int8)
        return cls(low, place - low, mode, response.dt)

    def sample(self, values: Floats) -> Floats:
        """Return the values on the grid, along the last axis, at the instants."""
        first: Floats = values[..., self.low]
        if self.share is None:
            return first
        return first + self.share * (values[..., self.low + 1] - first)

    def rate(self, values: Floats) -> Floats:
        """Return the derivative of `sample` by a delay of the instants [1/s]."""
        rate: Floats = (values[self.low] - values[self.low + 1]) / self.step
        return rate


class Computed(Protocol):
    """What is compared with the measurement, with some values of the free keys."""

    @property
    def values(self) -> Floats:
        """Values of the free keys, shape (p,)."""

    @property
    def modes(self) -> NDArray[np.int8]:
        """Mode of each sample, as in `Prediction`."""

    def prediction(self, names: tuple[str, ...]) -> Prediction:
        """Return the computed channels."""

    def slopes(
        self, sizes: Floats, names: tuple[str, ...], integrated: bool = False
    ) -> dict[str, Floats] | None:
        """Return the derivatives of channels by the values, as of `Solved`."""


@dataclass(frozen=True, eq=False)
class Solved:
    """The motion with some values of the free keys."""

    model: FitModel
    values: Floats
    """Values of the free keys, shape (p,)."""
    scene: Trial
    response: Response
    places: Places
    """Places of the measured instants."""

    @property
    def modes(self) -> NDArray[np.int8]:
        """As in `Prediction`."""
        return self.places.mode

    @cached_property
    def with_spring(self) -> bool:
        """Whether the force of a rig contains those of spring and damper."""
        return self.model.fit.is_rig and self.model.spring_in_force

    def prediction(self, names: tuple[str, ...]) -> Prediction:
        """Return the computed channels."""
        arrays = {name: getattr(self.response, name) for name in names}
        if self.with_spring:
            _, k_x, b = self.scene.plant
            arrays["F_f"] = arrays["F_f"] + k_x * self.response.x_r + b * self.response.v_r
        places = self.places
        return Prediction({k: places.sample(v) for k, v in arrays.items()}, places.mode)

    def slopes(
        self, sizes: Floats, names: tuple[str, ...], integrated: bool = False
    ) -> dict[str, Floats] | None:
        """Return the derivatives of channels by the values, shape (p, n).

        None if they are not known in closed form.

        Parameters
        ----------
        sizes : ndarray, shape (p,)
            Sizes of the values.
        names : tuple of str
        integrated : bool
            Whether x_dd stands for its integral since the first instant.
        """
        if isinstance(self.scene.law, DynamicLaw):
            return None
        from drysim.approach.sensitivity import linearise
        from drysim.core.variational import VARIATION

        rates, springs = self.rates(sizes)
        if self.scene.law.variation == 0.0 and rates[VARIATION].any():
            return None  # an event more than the motion has
        linear, response, places = linearise(self.response, rates), self.response, self.places
        if self.with_spring:
            _, k_x, b = self.scene.plant
            linear.F_f[:] += k_x * linear.x_r + b * linear.v_r
            linear.F_f[:] += springs[:1].T * response.x_r + springs[1:].T * response.v_r
        slopes = {}
        delayed = [j for j, p in enumerate(self.model.parameters) if p.key == DELAY_KEY]
        for name in names:
            values = getattr(response, name)
            if integrated and name == "x_dd":  # x_r' + u', and u does not depend on the values
                rows = places.sample(linear.v_r)
                for j in delayed:
                    rows[j] = -places.sample(values)
                slopes[name] = rows - rows[:, :1]  # constant outside the motion
            else:
                rows = places.sample(getattr(linear, name))
                for j in delayed:
                    rows[j] = places.rate(values)
                slopes[name] = rows * (places.mode != OUTSIDE)
        return slopes

    def rates(self, sizes: Floats) -> tuple[Floats, Floats]:
        """Return the derivatives of the numbers of the scene, and of stiffness and damping.

        They are forward differences: the numbers are simple functions of the values.
        """
        from drysim.approach.sensitivity import numbers_of

        count, high = len(self.values), self.model.bounds[1]
        steps = NUMBER_STEP * sizes
        steps = np.where(self.values + steps <= high, steps, -steps)
        near = self.values[:, None] + np.append(np.diag(steps), np.zeros((count, 1)), axis=1)
        steps = np.diagonal(near) - self.values
        scene = self.model.scene(near)
        numbers = numbers_of(*self.model.moved(scene), count + 1)
        springs = np.array([np.broadcast_to(value, count + 1) for value in scene.plant[1:]])
        with np.errstate(invalid="ignore"):
            rates = (numbers[:, :-1] - numbers[:, -1:]) / steps
        rates[~np.isfinite(rates)] = 0.0  # stops and stages that there are not
        return rates, (springs[:, :-1] - springs[:, -1:]) / steps


@dataclass(frozen=True)
class FreeParameter:
    """A key that is fitted, with its unit and bounds."""

    key: str
    unit: str
    low: float
    high: float
    start: float | None
    """Start given by the file, by `start` or as the value of the key."""


@dataclass(frozen=True, eq=False)
class FitModel:
    """A scenario as a function of its free keys."""

    scenario: Scenario
    """Under the law that is fitted."""
    motion: Sines | Samples
    """Base motion; of a rig the motion that is imposed."""
    measurement: Measurement
    parameters: tuple[FreeParameter, ...]
    case: Case
    """The case at the values of the file."""

    @property
    def fit(self) -> Fit:
        """The fit block."""
        return fit_of(self.scenario)

    @property
    def compared(self) -> tuple[str, ...]:
        """Channels that are compared; the motion of a rig is imposed."""
        channels = self.measurement.channels
        return ("F_f",) if self.fit.is_rig else tuple(channels)

    @property
    def has_recorded_base(self) -> bool:
        """Whether the base motion is a record, whose sensor has noise.

        It is none for a rig and for curves.
        """
        inputs = getattr(self.motion, "inputs", ())
        return bool(inputs) and self.fit.measured is not None and not self.fit.is_rig

    @cached_property
    def fixed_start(self) -> tuple[str, ...]:
        """Keys of the start state that are not fitted; none for a rig, which imposes it."""
        fitted = {p.key for p in self.parameters}
        is_rig = self.fit.is_rig
        return () if is_rig else tuple(key for key in START_KEYS if key not in fitted)

    @property
    def extent(self) -> str:
        """The time that is measured, for the remarks on what it does not determine."""
        return f"in {format_number(float(self.measurement.t[-1]), 's')}"

    @property
    def subject(self) -> str:
        """What is measured, for the same remarks."""
        return "this record"

    @property
    def stated_start(self) -> list[str]:
        """Keys of the start state that the file states."""
        return [key for key in self.fixed_start if key not in self.scenario.unstated_start]

    def with_free_start(self, keys: Sequence[str]) -> FitModel:
        """Return the model with more keys of the start state fitted."""
        units = {"start.x_r": "m", "start.v_r": "m/s"}
        more = (FreeParameter(key, units[key], -np.inf, np.inf, None) for key in keys)
        return replace(self, parameters=(*self.parameters, *more))

    @property
    def has_offset(self) -> bool:
        """Whether each channel has an unknown offset."""
        return OFFSET_KEY in self.fit.free

    def point(self, values: Floats) -> dict[str, Any]:
        """Return values by key; the static limit is kept at or above kinetic friction."""
        each = values.tolist() if values.ndim == 1 else [*values]
        point = dict(zip((p.key for p in self.parameters), each, strict=True))
        for under, over in STATIC_KEYS.items():
            if over in point:
                kinetic = under.partition(".")[2]
                least = point.get(under, getattr(self.scenario.friction, kinetic, None))
                if isinstance(least, float):
                    point[over] = max(point[over], least)
                elif isinstance(least, np.ndarray):
                    point[over] = np.maximum(point[over], least)
        return point

    def at(self, values: Floats) -> Scenario:
        """Return the scenario with these values."""
        point = {k: v for k, v in self.point(values).items() if k != DELAY_KEY}
        return self.scenario.at(point) if point else self.scenario

    def scene(self, values: Floats) -> Trial:
        """Return the scene with these values, which are not validated.

        Values may be arrays of one length, those of several scenes.
        """
        point = {k: v for k, v in self.point(values).items() if k != DELAY_KEY}
        scenario = self.scenario.with_values(point)
        return Trial(scenario.oscillator.plant(), scenario.law(), scenario.start.state())

    def moved(self, scene: Trial) -> Trial:
        """Return the scene whose motion is computed: a rig has no dynamics."""
        if not self.fit.is_rig:
            return scene
        start = self._imposed_start(scene.start.x_r)
        return scene._replace(plant=Plant(RIG_MASS, 0.0, 0.0), start=start)

    def solve(self, values: Floats, end: float | None = None) -> Computed | None:
        """Return the motion with some values of the free keys, shape (p,).

        It has the samples up to the time `end` [s]; default: all of them. None if the scene
        cannot be solved.
        """
        scene = self.scene(values)
        if not is_valid_scene(scene.law, scene.start):
            return None
        measured, step = self.measurement, self.case.step
        t = measured.t if end is None else measured.t[measured.t <= end * (1.0 + 1e-12)]
        delay = self.point(values).get(DELAY_KEY)
        stated = delay is None
        if delay is None:
            delay = self.fit.response.delay
        end_of_motion = np.inf
        if isinstance(self.motion, Samples):
            end_of_motion = (len(self.motion.u_dd) - 1) * self.motion.dt
        length = min(float(t[-1]) + max(0.0, -delay), end_of_motion)
        plant, law, start = self.moved(scene)
        try:
            response = self.case.approach.solve(plant, law, self.motion, start, step, length)
        except SolverError:
            return None
        if delay == 0.0 and stated and not self.fit.is_rig:
            places = Places.at_points(response, measured.first, measured.stride, len(t))
        else:
            places = Places.between_points(response, (t - delay) / step)
        return Solved(self, values, scene, response, places)

    def _imposed_start(self, x_r: float) -> State:
        """Return the first state of a rig; `x_r` where its velocity is imposed."""
        first, motion = self.measurement.imposed, self.motion
        assert isinstance(motion, Samples), "the motion of a rig is a record"
        if "v_r" in self.measurement.channels:
            return State(x_r, first)
        assert motion.u is not None, "the record is one of displacement"
        # The slope of the spline, whose second derivative is linear between samples.
        u, u_dd = motion.u[:2], motion.u_dd[:2]
        slope = (u[1] - u[0]) / motion.dt
        slope -= motion.dt * (2.0 * u_dd[0] + u_dd[1]) / 6.0
        return State(first, -float(slope))

    @cached_property
    def spring_in_force(self) -> bool:
        """Whether the measured force of a rig contains those of spring and damper.

        It does if one of them is fitted. Stated ones may belong to another oscillator, on which
        the friction is to act: the measured force decides, by its scatter about sgn(v_r).
        """
        _, k_x, b = self.case.plant
        keys = {p.key.partition(".")[0] for p in self.parameters}
        if "oscillator" in keys or not (k_x or b):
            return "oscillator" in keys
        x_r, v_r = self.imposed_path, self.imposed
        force = self.measurement.channels["F_f"]
        slides = np.abs(v_r) > SLOW * np.abs(v_r).max()

        def scatter(values: Floats) -> float:
            return float(np.std((values * np.sign(v_r))[slides]))

        return scatter(force - k_x * x_r - b * v_r) < scatter(force)

    @cached_property
    def imposed_path(self) -> Floats:
        """Displacement of a rig at the measured instants [m]."""
        channels, v_r = self.measurement.channels, self.imposed
        if "x_r" in channels:
            return channels["x_r"]
        steps = 0.5 * np.diff(self.measurement.t) * (v_r[1:] + v_r[:-1])
        return self.case.start.x_r + np.concatenate(([0.0], np.cumsum(steps)))

    @cached_property
    def imposed(self) -> Floats:
        """Velocity of a rig at the measured instants [m/s]."""
        channels = self.measurement.channels
        if "v_r" in channels:
            return channels["v_r"]
        slope: Floats = np.gradient(channels["x_r"], self.measurement.t)
        return slope

    # Starts

    def starts(self) -> list[Floats]:
        """Return starting values without duplicates: those of the file, and closed forms.

        Raises
        ------
        ScenarioError
            If the file gives no start for a key that has no closed form.
        """
        starts: list[Floats] = []
        for closed_form, from_file in product(self._closed_forms(), (True, False)):
            values = np.array(
                [self._start_of(p, closed_form, from_file) for p in self.parameters]
            )
            values = np.clip(values, *self.bounds)
            if not any(np.allclose(values, other, rtol=1e-9) for other in starts):
                starts.append(values)
        return starts

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of the values."""
        low, high = zip(*((p.low, p.high) for p in self.parameters), strict=True)
        return np.array(low), np.array(high)

    def _closed_forms(self) -> list[dict[str, float]]:
        """Return starting values of mass, spring, damper and friction; at least one."""
        if self.fit.is_rig:
            return self._starts_of_rig()
        motion = self.kinematics
        m, k_x, b = self.case.plant
        free = {key for p in self.parameters for key in (p.key, p.key.rpartition(".")[0])}
        spring_keys = ["oscillator.stiffness", "oscillator.natural_frequency"]
        if self.scenario.oscillator.natural_frequency is not None:
            spring_keys.append("oscillator.mass")
        stated = {}
        for name, value, keys in (
            ("m", m, ("oscillator.mass",)),
            ("k_x", k_x, spring_keys),
            ("b", b, ("oscillator.damping", "oscillator.damping_ratio")),
            ("F_fk", self.case.law.F_fk, ("friction.kinetic", "friction.mu_kinetic")),
        ):
            if not free & {*keys}:
                stated[name] = value
        if len(stated) == 0 or not any(stated.values()):
            stated["m"] = m  # only ratios follow from motion
        starts = list(closed_form_starts(motion, stated))
        if is_decay(self.scenario) and (decay := decay_start(motion, stated)):
            starts.insert(0, decay)
        return starts

    def _starts_of_rig(self) -> list[dict[str, float]]:
        """Return starting values of spring, damper and friction, by linear least squares."""
        x_r, v_r, force = self.imposed_path, self.imposed, self.measurement.channels["F_f"]
        m, k_x, b = self.case.plant
        start = {"m": m, "k_x": k_x, "b": b}
        slides = np.abs(v_r) > SLOW * np.abs(v_r).max()
        if self.spring_in_force and slides.sum() > MIN_SAMPLES:
            terms = np.stack([x_r, v_r, np.sign(v_r)], axis=1)[slides]
            size = np.maximum(np.abs(terms).max(axis=0), 1e-300)
            values = np.linalg.lstsq(terms / size, force[slides], rcond=None)[0] / size
            fitted = {p.key for p in self.parameters}
            if fitted & {"oscillator.stiffness", "oscillator.natural_frequency"}:
                start["k_x"] = max(float(values[0]), 1e-3 * float(force.std() / x_r.std()))
            if fitted & {"oscillator.damping", "oscillator.damping_ratio"}:
                start["b"] = max(float(values[1]), 1e-3 * float(force.std() / v_r.std()))
            force = force - start["k_x"] * x_r - start["b"] * v_r
        level = float(np.median((force * np.sign(v_r))[slides])) if slides.any() else 0.0
        start["F_fk"] = max(level, 1e-3 * float(np.abs(force).max()))
        start = {name: value for name, value in start.items() if value > 0.0}
        return [start | {"static_ratio": ratio} for ratio in (1.2, 2.0)]

    @cached_property
    def kinematics(self) -> Kinematics:
        """Base and mass motion on the grid of the measurement."""
        from scipy.signal import savgol_filter

        measured = self.measurement
        u_dd = self.base()
        x_dd, x_r, v_r = (measured.channels.get(name) for name in ("x_dd", "x_r", "v_r"))
        width = min(2 * max(3, round(0.01 / measured.dt)) + 1, (len(u_dd) - 1) | 1)

        def derivative(values: Floats, order: int) -> Floats:
            degree = min(3, width - 1)
            slope: Floats = savgol_filter(values, width, degree, deriv=order, delta=measured.dt)
            return slope

        if x_r is not None and v_r is None:
            v_r = derivative(x_r, 1)
        if x_dd is None:
            assert v_r is not None, "a channel is measured"
            x_dd = u_dd + (derivative(x_r, 2) if x_r is not None else derivative(v_r, 1))
        return Kinematics(measured.dt, u_dd, x_dd, x_r, v_r)

    def base(self) -> Floats:
        """Return the base acceleration at the measured instants [m/s²]."""
        t, motion = self.measurement.t - self.fit.response.delay, self.motion
        if isinstance(motion, Samples):
            u_dd = motion.u_dd[:]
            return np.interp(t, np.arange(len(u_dd)) * motion.dt, u_dd)
        base: Floats = np.zeros(len(t))
        for amplitude, frequency, phase in zip(motion.A, motion.f, motion.phase, strict=True):
            base += amplitude * np.sin(2.0 * np.pi * frequency * t + phase)
        return base

    def _start_of(
        self, p: FreeParameter, closed_form: dict[str, float], from_file: bool
    ) -> float:
        """Return the start of a parameter from the file, or else from its closed form."""
        if from_file and p.start is not None:
            return p.start
        m, normal = (
            closed_form.get("m", 1.0),
            getattr(self.scenario.friction, "normal", None) or 1.0,
        )
        k_x, b, F_fk = (closed_form.get(name, 1.0) for name in ("k_x", "b", "F_fk"))
        ratio, key = closed_form.get("static_ratio", 1.0), p.key
        if key.startswith("friction.kinetic"):
            return F_fk
        if key.startswith("friction.static."):
            return F_fk * ratio
        if key.startswith("oscillator.damping."):
            return b
        forms = {
            "oscillator.mass": m,
            "oscillator.stiffness": k_x,
            "oscillator.natural_frequency": np.sqrt(k_x / m) / (2.0 * np.pi),
            "oscillator.damping": b,
            "oscillator.damping_ratio": b / (2.0 * np.sqrt(k_x * m)),
            "friction.static_ratio": ratio,
            "friction.static": F_fk * ratio,
            "friction.mu_kinetic": F_fk / normal,
            "friction.mu_static": F_fk * ratio / normal,
            "start.x_r": self._first_state(closed_form).x_r,
            "start.v_r": self._first_state(closed_form).v_r,
            DELAY_KEY: 0.0,
        }
        if key in forms:
            return float(forms[key])
        if p.start is not None:
            return p.start
        if np.isfinite(p.low) and np.isfinite(p.high):
            both = p.low > 0.0
            return float(np.sqrt(p.low * p.high) if both else 0.5 * (p.low + p.high))
        sentence = (
            f"{key} needs a start, as no closed form gives one: a value in the file, `start`, "
            "or `from` and `to`"
        )
        raise self.scenario.error(sentence, ("fit", "free", key))

    def _first_state(self, closed_form: Mapping[str, float]) -> State:
        """Return the first relative motion: as measured, or what balances the first force."""
        if self.fit.is_rig:
            return State(0.0, 0.0)
        motion = self.kinematics
        x_r, v_r = (float(series[0]) for series in self.relative_motion)
        if is_decay(self.scenario) and motion.x_r is None and motion.v_r is None:
            v_r = 0.0  # released, not pushed
        if motion.x_r is None and closed_form.get("k_x"):
            force = closed_form["m"] * float(motion.x_dd[0]) + closed_form["b"] * v_r
            x_r = -(force + np.copysign(closed_form["F_fk"], v_r or force)) / closed_form["k_x"]
        return State(x_r, v_r)

    @cached_property
    def relative_motion(self) -> tuple[Floats, Floats]:
        """Relative displacement and velocity, without their drift where not measured."""
        return relative_motion(self.kinematics, [], False)

    def size_of(self, key: str) -> float | None:
        """Return the typical size of a key whose value may well be 0; None for other keys."""
        if key == DELAY_KEY:
            return self.measurement.dt
        if key not in START_KEYS:
            return None
        x_r, v_r = self.relative_motion
        return float((x_r if key == "start.x_r" else v_r).std()) or None


# Building a model


def fit_of(scenario: Scenario) -> Fit:
    """Return the fit block of a scenario that has one."""
    assert scenario.fit is not None, "only a scenario with a fit block is fitted"
    return scenario.fit


def is_decay(scenario: Scenario) -> bool:
    """Return whether a free decay is fitted, on a base at rest; a rig imposes its motion."""
    return scenario.excitation.kind == "rest" and not fit_of(scenario).is_rig


def build_model(scenario: Scenario) -> FitModel:
    """Read base motion and measurement, and return the model under the law of the file.

    Raises
    ------
    RecordError
        If a record cannot be used, or does not fit the base motion.
    ScenarioError
        If a free key has no start.
    """
    fit = fit_of(scenario)
    if is_decay(scenario) and (fit.response.delay or DELAY_KEY in fit.free):
        sentence = f"{DELAY_KEY}: nothing lags behind a base at rest; remove it"
        keys = (
            ("fit", "measured", "delay") if fit.response.delay else ("fit", "free", DELAY_KEY)
        )
        raise scenario.error(sentence, keys)
    with locating_records(scenario):
        motion = imposed_motion(fit) if fit.is_rig else base_motion(scenario)
    if isinstance(motion, Samples) and not (fit.is_rig or np.any(motion.u_dd[:])):
        sentence = (
            "the base record is 0 in every sample: no motion was recorded; for a free decay "
            "write `excitation: {kind: rest}`"
        )
        raise scenario.error(sentence, "excitation")
    with locating_records(scenario):
        check_columns(scenario, fit.response.records, has_base=not fit.is_rig)
        measurement = (
            read_rig(fit, motion)
            if fit.is_rig
            else read_measurement(scenario, fit.response, motion, fit.free)
        )
    count = len(measurement.t)
    if shortage := shortage_message(
        f"{count} measured samples", count * BYTES_PER_SAMPLE, "use a shorter `window`"
    ):
        raise scenario.error(f"fit.measured: {shortage}", "fit.measured")

    if not isinstance(scenario.solver.member(), StickSlip):
        sentence = f"a fit is by the exact motion, not by approach {scenario.solver.approach}"
        raise scenario.error(f"{sentence}; choose stick-slip", "solver.approach")
    if max_seeds(scenario) > 1:
        sentence = "excitation.seeds: a measured response belongs to one base motion"
        raise scenario.error(sentence, "excitation.seeds")
    if getattr(fit.noise, "u_dd", None) is not None and not getattr(motion, "inputs", ()):
        sentence = "fit.noise.u_dd is the noise of a record, but the base motion is none"
        raise scenario.error(sentence, "fit.noise.u_dd")
    fitted_end(scenario, measurement)  # raises if too little is left to fit
    for law in fit.laws:
        model_of_law(scenario, motion, measurement, law)  # raises what the law lacks
    return model_of_law(scenario, motion, measurement)


def free_parameters(
    scenario: Scenario, law: str = "", step: float = 0.0
) -> tuple[FreeParameter, ...]:
    """Return the free keys of a scenario, of a law those that it uses.

    `step` is that of the measured response [s], for the bounds of its delay.
    """
    free = fit_of(scenario).free
    document = scenario.model_dump(by_alias=True, exclude_none=True)
    numeric = numeric_keys(type(scenario), document)
    missing, parameters = set(scenario.missing_values), []
    for key, free_key in free.items():
        if key == OFFSET_KEY or (law and not law_uses_key(scenario, law, key)):
            continue
        if key == DELAY_KEY:
            low = -50.0 * step if free_key.low is None else free_key.low
            high = 50.0 * step if free_key.high is None else free_key.high
            parameters.append(FreeParameter(key, "s", low, high, free_key.start))
            continue
        number = numeric[key]
        assert number is not None, "free keys are numeric"
        ends = number.bounds
        low = ends[0] if free_key.low is None else max(free_key.low, ends[0])
        high = ends[1] if free_key.high is None else min(free_key.high, ends[1])
        above = STATIC_KEYS.get(key, "")
        if above and above not in free:  # at most the static limit of the file
            limit = getattr(scenario.friction, above.partition(".")[2], None)
            high = min(high, limit) if isinstance(limit, float) else high
        start = free_key.start
        if start is None and key not in missing and not key.startswith("start."):
            start = number.here(key)
        parameters.append(FreeParameter(key, number.header, low, high, start))
    if not parameters:
        sentence = f"none of its keys is one {f'of law {law}' if law else 'of the scenario'}"
        raise scenario.error(f"fit.free: {sentence}", "fit.free")
    return tuple(parameters)


def model_of_law(
    scenario: Scenario, motion: Sines | Samples, measurement: Measurement, law: str = ""
) -> FitModel:
    """Return the model under a friction law; default: that of the file."""
    under = scenario.with_law(law) if law else scenario
    parameters = free_parameters(under, law, measurement.dt)
    model = FitModel(under, motion, measurement, parameters, assemble(under, motion))
    # A mass at rest on a base at rest would stay there.
    return model.with_free_start(scenario.unstated_start) if is_decay(scenario) else model


def fitted_end(scenario: Scenario, measurement: Measurement) -> float:
    """Return the time from which the record is held out [s]."""
    fit = fit_of(scenario)
    share = fit.hold_out
    if share is None:
        share = 0.0 if fit.is_rig or is_decay(scenario) else DEFAULT_HOLD_OUT
    t = measurement.t
    count = round((1.0 - share) * len(t))
    if count < MIN_SAMPLES:
        sentence = f"fit.hold_out leaves {count} of {len(t)} samples; a fit needs {MIN_SAMPLES}"
        raise scenario.error(sentence, "fit.hold_out")
    return float(t[count - 1])


def imposed_record(fit: Fit) -> ChannelRecord:
    """Return the channel with the imposed motion of a rig."""
    return fit.response.record("v_r" if fit.response.v_r is not None else "x_r")


def imposed_motion(fit: Fit) -> Samples:
    """Return the base motion that gives a fixed mass the relative motion of a rig."""
    channel = imposed_record(fit)
    return as_base_motion(channel, {"scale": -channel.scale, "gravity": "keep"}).motion()


def as_base_motion(channel: ChannelRecord, options: Mapping[str, Any]) -> Record:
    """Return a measured channel as the base motion of a scenario, with some options."""
    from drysim.excitation.recorded import Record

    document = channel.model_dump(by_alias=True, exclude_none=True)
    context = {"folder": channel.path.parent, "block": channel.block}
    record = Record.model_validate({**document, "kind": "record", **options}, context=context)
    return record.model_copy(update={"file": channel.path.name})


def check_columns(
    scenario: Scenario, channels: Mapping[str, ChannelRecord], has_base: bool
) -> None:
    """Raise a ScenarioError if two channels are the same column of a file.

    One may name the column and the other one number it: only the file can tell.

    Parameters
    ----------
    scenario : Scenario
    channels : mapping
        By their keys.
    has_base : bool
        Whether the base is the excitation.
    """
    from drysim.excitation.recorded import Record

    base, keys = scenario.excitation, dict[tuple[object, ...], str]()
    bases = {"excitation": base} if has_base and isinstance(base, Record) else {}
    for key, record in {**bases, **channels}.items():
        index, column = find_column(record)
        other = keys.setdefault((record.path, repr(record.rows), index), key)
        if other != key:
            sentence = f"{key} is {column} of {record.named}, and so is {other}"
            raise scenario.error(f"{sentence}: each needs its own", key)


def read_measurement(
    scenario: Scenario,
    measured: Measurements,
    motion: Sines | Samples,
    free: Collection[str] | None = None,
) -> Measurement:
    """Read the measured channels and place them on the time axis of the base motion.

    Parameters
    ----------
    scenario : Scenario
        Its excitation is the base motion.
    measured : Measurements
    motion : Sines or Samples
    free : collection of str, optional
        The keys that are fitted, of a fit.

    Raises
    ------
    RecordError
        If a channel cannot be used, its step does not fit that of the base motion, or the two
        records have no time in common.
    """
    display_path, block = str(measured.path), measured.path_of_block
    channels: dict[str, Floats] = {}
    inputs: list[Input] = []
    warnings: list[WarningMessage] = []
    clean_up: list[tuple[str, CleaningReport]] = []
    series: Series | None = None
    file_spacing = 0.0
    for name in measured.channels:
        record = measured.record(name)
        cleaned, source = read_series(record)
        read, seen = cleaned.series, cleaned.warnings
        series = series or read
        clean_up += [(name, report) for report in cleaned.reports]
        file_spacing = max(file_spacing, cleaned.file_spacing)
        channels[name] = np.asarray(read.values[:], dtype=np.float64)
        if float(np.ptp(channels[name])) == 0.0:
            level = format_number(float(channels[name][0]), SI[record.quantity])
            column = f" of column `{record.column}`" if record.column is not None else ""
            sentence = f"{name} is {level} in every sample{column}: no motion was recorded"
            raise record_error(display_path, sentence)
        keeps_mean = getattr(scenario.excitation, "gravity", "refuse") == "keep"
        if name == "x_dd" and not (keeps_mean or OFFSET_KEY in (free or ())):
            check_response_gravity(record, measure_level(channels[name]), free is not None)
        inputs.append(source)
        # The relative motion of a mass that sticks stands still.
        may_freeze = name != "x_dd"
        warnings += [warning for warning in seen if not (may_freeze and warning.slug == FROZEN)]
    assert series is not None, "a channel is measured"
    n = min(map(len, channels.values()))
    step = motion.dt if isinstance(motion, Samples) else scenario.step
    assert step is not None, "a scenario has a step unless a record defines it"
    begin = begin_of_motion(scenario, series)
    stride = series.dt / step
    if stride < 0.5 or abs(stride - round(stride)) > GRID_TOLERANCE / n * max(1.0, stride):
        steps = format_number(series.dt, "s", 9), format_number(step, "s", 9)
        # Linear interpolation of a displacement is refused.
        by = "spline" if measured.record(name).quantity == "displacement" else "line"
        remedy = (
            f"add `resample: {{step: {steps[1]}, by: {by}}}` to {block}"
            if isinstance(motion, Samples)
            else f"set solver.step to {steps[0]}"
        )
        sentence = (
            f"the measured response has a step of {steps[0]}, the base motion {steps[1]}; "
            f"{remedy}"
        )
        raise record_error(display_path, sentence)
    stride = round(stride)
    offset = (series.first - begin) / step
    first = round(offset)
    if abs(offset - first) > GRID_TOLERANCE:
        sentence = (
            f"its samples lie between those of the base motion, by "
            f"{format_number((offset - first) * step, 's')}; add `resample` to {block}"
        )
        raise record_error(display_path, sentence)
    # A response that lags answers to the base motion that much earlier.
    lag = measured.delay / step
    skip = max(0, ceil((lag - first) / stride - GRID_TOLERANCE))
    last = n
    if isinstance(motion, Samples):
        until = len(motion.u_dd) - 1 + lag - first
        last = min(n, floor(until / stride + GRID_TOLERANCE) + 1)
    first += skip * stride
    if last - skip < MIN_SAMPLES:
        count = format_number(max(last - skip, 0))
        sentence = (
            f"only {count} of {n} samples lie within the base motion; the two records need the "
            "same time axis"
        )
        if n < MIN_SAMPLES:
            count = format_count(n, "sample")
            sentence = f"it has {count}, too few: at least {MIN_SAMPLES} are needed"
        raise record_error(display_path, sentence)
    if last - skip < 0.98 * n:
        sentence = (
            f"{n - last + skip} of {n} measured samples lie outside the base motion and are "
            "not used"
        )
        numbers = {"used": last - skip, "samples": n}
        warnings.append(WarningMessage("measurement-cut", sentence, numbers))
    channels = {name: values[skip:last] for name, values in channels.items()}
    if not isinstance(motion, Samples) and memory_shortage(first + stride * (last - skip)):
        sentence = (
            f"its times begin {format_number(first * step, 's')} after time 0, at which the "
            "base motion starts: too many steps; let its times count from there"
        )
        raise record_error(display_path, sentence)
    t: Floats = np.asarray((first + stride * np.arange(last - skip)) * step, dtype=np.float64)
    unique = tuple({record.file: record for record in inputs}.values())
    once = tuple({warning.sentence: warning for warning in warnings}.values())
    return Measurement(
        channels,
        t,
        first,
        stride,
        unique,
        once,
        file_spacing=file_spacing,
        clean_up=tuple(clean_up),
        scales={name: measured.record(name).scale for name in channels},
    )


def check_response_gravity(record: ChannelRecord, level: Level, is_fitted: bool) -> None:
    """Raise RecordError if a measured acceleration at rest looks like gravity.

    The message names a remedy that only a fit has if it `is_fitted`.
    """
    if is_gravity(level.rest) or is_gravity(level.rest / (record.scale or 1.0)):
        where, trend = ("at rest", "rest") if level.is_at_rest else ("the mean of", "mean")
        sentence = (
            f"{where} x_dd is {level.rest:.4g} m/s², which looks like gravity: remove it with "
            f"{record.remove.yaml_with(trend=trend)} in {record.block}"
            + f", or fit it with `{OFFSET_KEY}: {{}}` in fit.free"
            * is_fitted
        )
        raise record_error(str(record.path), sentence)


def read_rig(fit: Fit, motion: Sines | Samples) -> Measurement:
    """Read the samples of a friction rig as they stand, at even times or not.

    Only the imposed motion needs an even grid; forces are compared where they were measured.
    """
    channels, times = {}, []
    for name in fit.response.channels:
        t, values = read_samples(fit.response.record(name))
        times.append(t)
        channels[name] = values
    if not all(np.array_equal(t, times[0]) for t in times):
        sentence = "a row of a rig needs all its samples: delete the rows with a missing one"
        raise record_error(str(fit.response.path), sentence)
    if len(times[0]) < MIN_SAMPLES:
        reason = f"has {len(times[0])} samples, fewer than the {MIN_SAMPLES} that a fit needs"
        raise record_error(str(fit.response.path), reason)
    inputs, warnings = getattr(motion, "inputs", ()), getattr(motion, "warnings", ())
    series = read_series(imposed_record(fit))[0].series
    t = times[0] - series.first
    return Measurement(channels, t, 0, 1, inputs, warnings, float(series.values[:][0]))


def begin_of_motion(scenario: Scenario, measured: Series) -> float:
    """Return the time at which the computed motion begins, on the axis of its file [s].

    It is the first used sample of the base record. A base at rest has no times of its own, and
    a decay begins with its first measured sample. The times of all other motions begin at 0.
    """
    from drysim.excitation.recorded import Record

    if isinstance(scenario.excitation, Record):
        return read_series(scenario.excitation)[0].series.first
    if scenario.excitation.kind != "rest":
        return 0.0
    force_record = getattr(scenario.friction, "normal_record", None)
    return read_series(force_record)[0].series.first if force_record else measured.first
