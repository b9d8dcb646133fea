"""Warnings about a fit, and the fault of the record that most likely explains a bad one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from drysim.core.model import Floats, Samples
from drysim.errors import WarningMessage
from drysim.records.warnings import STANDARD_GRAVITY
from drysim.scenario.fit import DELAY_KEY, FreeKey
from drysim.study import fit_curves
from drysim.study.fit_curves import CURVES, CurveFit
from drysim.study.fit_law import (
    EXACT,
    START_WRONG,
    USELESS,
    LawFit,
    Parameter,
    gain_of_start,
    is_near,
)
from drysim.study.fit_least_squares import MIN_PART, STEPS, LeastSquares, is_noise, rms
from drysim.study.fit_model import MIN_SAMPLES, FitModel, FreeParameter, is_decay
from drysim.study.fit_spectrum_curves import SpectrumFit
from drysim.study.starting_values import STILL_NOISE, noise_level
from drysim.wording import format_number, format_quantity, join_words

WHITE = 4.0
"""Autocorrelation of the residuals, times the root of their number, from which they are not
white."""

FAULT_MARGIN = 2.0
"""Ratio of the residuals to the noise from which faults of the record are looked for."""

BAD_FIT = 0.3
"""Relative error that is worth a warning even if no such fault explains it."""

QUICK_SHARE = 0.3
"""Share of the record on which faults of it are tried."""

WRONG_UNITS = {
    "x_dd": {
        STANDARD_GRAVITY: "9.81 times too small, as if in g",
        1.0 / STANDARD_GRAVITY: "9.81 times too large",
    },
    "x_r": {
        0.1: "10 times too large",
        10.0: "10 times too small",
        1e-3: "1000 times too large",
        1e3: "1000 times too small",
    },
}
"""Factors that correct channels whose unit is wrong, and what they say of their values."""

SIGN_FAULT = "the sign of {name} seems to be wrong: {remedy}"
SWAP_FAULT = "base and mass seem to be swapped: exchange the columns"
LAG_FAULT = "the measured response seems to lag by {lag}: {remedy} `measured.delay`"
UNIT_FAULT = "the values of {name} seem to be {size}: their unit is not the one stated"
"""Usual faults of a record, in words."""

CLIPPED = "record-clipped"
"""Warning about samples at the end of the range of a sensor."""

UNKNOWN_FAULT = "check columns, units, signs and time axes, or try another law"

UNKNOWN_FAULT_OF_CURVES = "check levels, columns and units of the curves"

MUCH_BETTER, OBVIOUS = 0.5, 0.1
"""Ratios of errors from which a fault of the record explains a bad fit: if no other explains it
better, and in any case."""


def fit_warnings(
    law_fit: LawFit, parameters: Sequence[Parameter], of_records: Sequence[WarningMessage]
) -> Iterator[WarningMessage]:
    """Yield the warnings about a fit; of one that describes next to nothing only the cause."""
    error = law_fit.error
    if cause := cause_of_bad_fit(law_fit, of_records):
        sentence = f"the fitted motion differs from the measured one by {100 * error:.3g} %"
        yield WarningMessage("bad-fit", f"{sentence}; {cause}", {"fit_error": error})
        if error > USELESS:
            return
    notes: dict[str, list[str]] = {}
    for j, (p, free) in enumerate(zip(parameters, law_fit.model.parameters, strict=True)):
        given = law_fit.model.fit.free.get(p.key, FreeKey())
        scale = float(law_fit.first.scale[j])
        if p.note:
            notes.setdefault(p.note, []).append(p.key)
        elif is_near(p.value, given.low, scale) or is_near(p.value, given.high, scale):
            end = format_quantity(p.value, free.unit)
            sentence = f"{p.key} ends at its bound of {end} in fit.free"
            yield WarningMessage("at-bound", sentence)
        elif p.bound == free.low == 0.0:
            sentence = f"{p.key} ends at 0, its least value: this record shows none of it"
            yield WarningMessage("at-bound", sentence)
        elif p.bound is not None:
            end = format_quantity(p.bound, free.unit)
            which = "least" if p.bound == free.low else "largest"
            yield WarningMessage("at-bound", f"{p.key} ends at {end}, its {which} value")
    for note, keys in notes.items():
        about = "" if len(keys) > 1 and join_words(keys) in note else f"{join_words(keys)}: "
        yield WarningMessage("not-determined", f"{about}{note}")
    stated = law_fit.model.stated_start
    if gain_of_start(law_fit.solution, stated) > START_WRONG:
        sentence = f"{describe_wrong_start(stated)}; the intervals may miss the true values"
        yield WarningMessage("start-differs", sentence)
    agree, total = law_fit.starts
    if agree < 2 <= total:
        many = f"only {agree} of {total} starts led" if agree else f"none of {total} starts led"
        sentence = (
            f"{many} to this solution: it may not be the best; give `start` values or bounds"
        )
        yield WarningMessage("starts-disagree", sentence, {"agree": agree, "starts": total})
    elif isinstance(law_fit, SpectrumFit) and not law_fit.is_settled:
        sentence = (
            "the fit ended before its values had settled: there may be better ones; give "
            "`start` values or bounds"
        )
        yield WarningMessage("starts-disagree", sentence, {"agree": agree, "starts": total})
    elif isinstance(law_fit, CurveFit) and (others := other_solution(law_fit, parameters)):
        sentence = (
            f"other values explain these curves as well, by the noise: {others}; the intervals "
            "are those about the best ones and may miss the true values: add curves of T_x or "
            "of another level, or give bounds"
        )
        yield WarningMessage("starts-disagree", sentence, {"agree": agree, "starts": total})
    for name in law_fit.model.compared:
        rho, expected = lag_correlation(law_fit, name), expected_correlation(law_fit, name)
        if error > EXACT and abs(white_score(law_fit, name)) > WHITE:
            left = rho - expected
            factor = format_number(np.sqrt((1.0 + left) / (1.0 - left)), digits=2)
            cause = "scatter" if isinstance(law_fit, SpectrumFit) else "noise of the base"
            beside = f", {expected:.2f} by the {cause}" if expected else ""
            sentence = (
                f"the residuals of {name} are not white (correlation of neighbours "
                f"{rho:.2f}{beside}): the intervals are too "
                + (f"narrow, by a factor of at least {factor}" if left > 0.0 else "wide")
            )
            yield WarningMessage("residuals-not-white", sentence, {"correlation": rho})


def other_solution(law_fit: CurveFit, parameters: Sequence[Parameter]) -> str:
    """Return the values of a fit as good as the solution but outside an interval of it.

    A profile begins at the solution, and cannot reach another one that is apart.
    """
    for end in law_fit.equal_ends:
        values = law_fit.model.point(end * law_fit.first.scale)
        if any(
            (p.profile_low is not None and values[p.key] < p.profile_low)
            or (p.profile_high is not None and values[p.key] > p.profile_high)
            for p in parameters
        ):
            return ", ".join(
                f"{p.key} {format_quantity(values[p.key], p.unit)}" for p in parameters
            )
    return ""


def cause_of_bad_fit(law_fit: LawFit, of_records: Sequence[WarningMessage]) -> str:
    """Return why the fitted motion may differ from the measured one; empty if it does not."""
    is_bad = law_fit.error > BAD_FIT
    if isinstance(law_fit, CurveFit):
        cause = cause_of_bad_curves(law_fit)
        if cause or not is_bad:
            return cause
        return UNKNOWN_FAULT_OF_CURVES + fit_curves.untried(law_fit)
    if is_noise(law_fit.solution, FAULT_MARGIN):
        return ""
    clipped = any(warning.slug == CLIPPED for warning in of_records)
    unknown = "clipped samples are not those of the motion" if clipped else UNKNOWN_FAULT
    return likely_fault(law_fit) or (unknown if clipped or is_bad else "")


def cause_of_bad_curves(law_fit: CurveFit) -> str:
    """Return the fault of curves that explains their residuals; empty if none does."""
    if isinstance(law_fit, SpectrumFit):
        return law_fit.wrong_level
    is_white = abs(white_score(law_fit, CURVES)) <= WHITE
    return "" if is_white or law_fit.error < EXACT else fit_curves.likely_fault(law_fit)


def white_score(law_fit: LawFit, name: str) -> float:
    """Return the correlation of neighbouring residuals in its standard deviations.

    What the noise of the base explains does not count.
    """
    count = int(law_fit.solution.mask.sum())
    left = lag_correlation(law_fit, name) - expected_correlation(law_fit, name)
    return left * float(np.sqrt(count))


def expected_correlation(law_fit: LawFit, name: str) -> float:
    """Return the correlation of neighbouring residuals by scatter or noise of the base."""
    if isinstance(law_fit, SpectrumFit):
        return law_fit.neighbour_correlation
    noise = law_fit.base_noise
    if noise is None or noise.level == 0.0:
        return 0.0
    return noise.lag_correlation(law_fit.model.compared.index(name))


def lag_correlation(law_fit: LawFit, name: str) -> float:
    """Return the correlation of neighbouring residuals of a channel."""
    difference, mask = (
        law_fit.first.differences(law_fit.first.solve(law_fit.solution.x))[name],
        law_fit.solution.mask,
    )
    values = difference - difference[mask].mean()
    both = mask[1:] & mask[:-1]
    size = float(np.mean(values[mask] ** 2))
    if size == 0.0 or not both.any():
        return 0.0
    return min(float(np.mean((values[1:] * values[:-1])[both])) / size, 0.999)


def likely_fault(law_fit: LawFit) -> str:
    """Return the most likely fault of a record that is not fitted well; empty if none."""
    model = law_fit.model
    if model.fit.is_rig:
        return ""
    if is_decay(model.scenario) and (still := samples_at_rest(model)):
        measured = model.measurement
        rest = {name: values[still:] for name, values in measured.channels.items()}
        released = replace(
            model, measurement=measured._replace(channels=rest, t=measured.t[:-still])
        )
        if refitted(law_fit, released)[0] < MUCH_BETTER * law_fit.error:
            time = format_number(still * measured.dt, "s", 3)
            return (
                f"the mass seems to be held for the first {time}: let `window` begin where it "
                "is released"
            )
    uncorrected, best, cause = refitted(law_fit, model)[0], np.inf, ""
    for fault, other in possible_faults(model):
        error, values = refitted(law_fit, other, OBVIOUS * uncorrected)
        if error < best:
            best, cause = error, fault.format(lag=format_number(values[-1], "s", 3))
        if best < OBVIOUS * uncorrected:
            break
    return cause if best < MUCH_BETTER * min(uncorrected, 1.0) else ""


def sign_fault(name: str, scale: float) -> str:
    """Return the fault of a channel of the wrong sign, with its stated factor [-]."""
    remedy = "remove `scale: -1`" if scale == -1.0 else f"`scale: {format_number(-scale)}`"
    return SIGN_FAULT.format(name=name, remedy=remedy)


def samples_at_rest(model: FitModel) -> int:
    """Return the number of samples before the first channel moves beyond its noise."""
    values = model.measurement.channels[model.compared[0]]
    count = len(values) - MIN_SAMPLES
    level = STILL_NOISE * max(noise_level(values[:MIN_SAMPLES]), 1e-6 * float(np.ptp(values)))
    moves = np.abs(values - np.median(values[:MIN_SAMPLES])) > level
    still = int(np.argmax(moves))
    return still if MIN_SAMPLES <= still <= count else 0


def possible_faults(model: FitModel) -> Iterator[tuple[str, FitModel]]:
    """Yield usual faults of a record in words, each with the model in which it is corrected."""
    measured, motion = model.measurement, model.motion

    def multiplied(name: str, factor: float) -> FitModel:
        channels = measured.channels | {name: factor * measured.channels[name]}
        return replace(model, measurement=measured._replace(channels=channels))

    for name in model.compared:
        scale = model.fit.response.record(name).scale
        yield sign_fault(name, scale), multiplied(name, -1.0)
    whole = isinstance(motion, Samples) and len(measured.t) == len(motion.u_dd)
    if "x_dd" in measured.channels and isinstance(motion, Samples) and whole:
        swapped = measured._replace(channels=measured.channels | {"x_dd": motion.u_dd[:]})
        exchanged = motion._replace(u_dd=measured.channels["x_dd"], u=None)
        yield SWAP_FAULT, replace(model, measurement=swapped, motion=exchanged)
    if stated := model.stated_start:
        yield describe_wrong_start(stated), model.with_free_start(stated)
    # Nothing lags behind a base at rest.
    if DELAY_KEY not in [p.key for p in model.parameters] and not is_decay(model.scenario):
        far = 20.0 * measured.dt
        delay = FreeParameter(DELAY_KEY, "s", -far, far, 0.0)
        stated_delay = model.fit.response.delay
        instead = f", not by the stated {format_number(stated_delay, 's')}" * bool(stated_delay)
        fault = LAG_FAULT.format(lag=f"{{lag}}{instead}", remedy="free")
        yield fault, replace(model, parameters=(*model.parameters, delay))
    for name in model.compared:
        for factor, fault in WRONG_UNITS.get(name, {}).items():
            fault = UNIT_FAULT.format(name=name, size=fault)
            yield fault, multiplied(name, factor)


def describe_wrong_start(stated: Sequence[str]) -> str:
    """Return that a record begins in another state than stated, and the remedy."""
    keys = "these keys" if len(stated) > 1 else "this key"
    return (
        f"the record does not begin with the stated {join_words(stated)}: without {keys} in "
        "the file the start is fitted"
    )


def refitted(law_fit: LawFit, model: FitModel, enough: float = 0.0) -> tuple[float, Floats]:
    """Return relative error and values of a quick fit of another model.

    Up to three starts are followed, until an error is small enough.
    """
    t = model.measurement.t
    end = min(
        law_fit.first.end, max(QUICK_SHARE * float(t[-1]), float(t[min(MIN_PART, len(t)) - 1]))
    )
    best, values = np.inf, np.zeros(len(model.parameters))
    for start in model.starts()[:3]:
        squares = LeastSquares.starting_from(model, end, start)
        scale = squares.scale
        x = squares.refine(squares.coarse(start / scale), STEPS[:3])
        error = rms(squares.residuals(squares.solve(x), squares.all_samples))
        if error < best:
            best, values = error, x * scale
        if best < enough:
            break
    return best, values
