"""From a record in a scenario to its base motion: the file is read here and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.core.motion import Input, Samples
from drysim.core.signal import Signal, blocks, moments
from drysim.errors import Caution, RecordError
from drysim.excitation.record.cautions import (
    ends_of_u,
    found,
    gravity_left,
    interpolated,
    interpolated_force,
)
from drysim.excitation.record.file import TextFile, fault, read
from drysim.excitation.record.filters import Ends, displacements
from drysim.excitation.record.formats import SUFFIXES, format_of
from drysim.excitation.record.lines import unquoted
from drysim.excitation.record.series import Cleaned, series_of
from drysim.excitation.record.shape import SPLINES, cut, span
from drysim.quantity import GREATEST, LEAST

if TYPE_CHECKING:
    from drysim.excitation.record import Record, Recorded


class Forces(NamedTuple):
    """Forces as they were recorded.

    Attributes
    ----------
    values : ndarray, shape (n,)
        The samples [N].
    dt : float
        Their distance [s].
    source : Input
        The file behind them.
    cautions : tuple of Caution
        What a reader of the numbers should know.
    clean_up : tuple of mapping
        What was done on request, step by step.
    """

    values: NDArray[np.float64]
    dt: float
    source: Input
    cautions: tuple[Caution, ...]
    clean_up: tuple[Mapping[str, object], ...]


def motion_of(record: Record, ends: Ends = "even") -> Samples:
    """Give the base acceleration of a record; see `Record.motion` and `high_pass`."""
    shown, spline = str(record.path), SPLINES[record.quantity]
    with np.errstate(all="ignore"):  # what overflows is found by `_finite`
        (series, slow, reports, seen, own), source = _read(record, ends)
        _finite(series.values, series.dt, shown)
        first, last = span(series, record.window, shown)
        motion = spline(series)
        if slow and record.remove.below and motion.u is None:
            band = record.remove.below, record.remove.order
            u, other = displacements(spline(slow), *band)
            otherwise = cut(motion._replace(u=other), first, last, len(series.values)).u
            motion = motion._replace(u=u)
        else:
            otherwise = None
        motion = cut(motion, first, last, len(series.values))
        _finite(motion.u_dd, motion.dt, shown)
        level = moments(motion.u_dd)
        for sentence in gravity_left(record, level[0]):
            raise fault(shown, sentence)
        cautions = (
            *seen,
            *found(record, motion, level),
            *interpolated(record, motion, level[1], own),
            *ends_of_u(record, motion.u, otherwise),
        )
    realised: dict[str, object] = {} if record.scale == 1.0 else {"scale": record.scale}
    if reports:
        realised["clean_up"] = [one.told() for one in reports]
    return motion._replace(inputs=(source,), cautions=cautions, realised=realised)


def force_of(record: Recorded) -> Forces:
    """Give the samples of a record of forces, their distance and where they come from."""
    shown = str(record.path)
    with np.errstate(all="ignore"):
        (series, _, reports, seen, _), source = _read(record)
        _finite(series.values, series.dt, shown, "the force")
        first, last = span(series, record.window, shown)
    values = np.array(series.values[first : last + 1])
    cautions = (*seen, *interpolated_force(record, values, series.dt))
    return Forces(values, series.dt, source, cautions, tuple(one.told() for one in reports))


def _read(record: Recorded, ends: Ends = "even") -> tuple[Cleaned, Input]:
    """The whole record; its bytes are let go before anything is made of the numbers."""
    file = read(record.path, SUFFIXES)
    source = Input(record.named, file.sha256, len(file.reader))
    member = format_of(record.file)
    assert member is not None  # `read` has made sure
    text = TextFile(file.shown, file.reader)
    try:
        columns = member.columns(replace(file, skip=record.skip))
        del file
        return series_of(record, columns, ends), source
    except RecordError as error:
        if record.path.is_symlink():
            raise unquoted(error, text) from None
        raise


def _finite(values: Signal, dt: float, shown: str, name: str = "ü") -> None:
    """Refuse numbers out of range; a NaN compares as false and is refused, too."""
    within = all(part.min() >= -GREATEST and part.max() <= GREATEST for part in blocks(values))
    if not (within and LEAST <= dt <= GREATEST):
        raise fault(shown, f"{name} is out of range: check unit, `scale` and time step")
