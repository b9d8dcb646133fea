"""What is removed from a record on request: its trend, and what is outside a band."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from drysim.excitation.record.file import fault
from drysim.excitation.record.filters import Ends, high_pass, low_pass, trend
from drysim.excitation.record.reports import Report, report
from drysim.excitation.record.shape import Series
from drysim.wording import listed

if TYPE_CHECKING:
    from drysim.excitation.record.spoken import Removal


class Rest(NamedTuple):
    """What a removal leaves; `slow` is that before a high-pass, None where there is none."""

    series: Series
    slow: Series | None
    told: Report


def without(
    series: Series, wanted: Removal, unit: str, shown: str, ends: Ends = "even"
) -> Rest:
    """Give a series without its trend and what is outside a band, and the report of that.

    Parameters
    ----------
    series : Series
    wanted : Removal
        With anything to do.
    unit : str
        SI unit of the samples.
    shown : str
        The file as messages name it.
    ends : str
        How the high-pass continues the ends; see `high_pass`.

    Raises
    ------
    RecordError
        When a frequency has less than one period in the record, or is above half its rate.
    """
    rest, slow, words = series.values[:], None, []
    if wanted.trend != "nothing":
        rest = rest - trend(rest, wanted.trend)
        words.append(f"the {wanted.trend}")
    if wanted.above is not None:
        _check(wanted.above, "above", series, shown)
        rest = low_pass(rest, series.dt, wanted.above, wanted.order)
        words.append(f"what is above {wanted.above:g} Hz")
    if wanted.below is not None:
        _check(wanted.below, "below", series, shown)
        slow = series._replace(values=rest)
        rest = high_pass(rest, series.dt, wanted.below, wanted.order, ends)
        words.append(f"what is below {wanted.below:g} Hz")
    by = f" (Butterworth of order {wanted.order}, both ways)" if wanted.filters else ""
    taken = series.values[:] - rest
    mean, drift = float(taken.mean()), float(taken[-1] - taken[0])
    sentence = (
        f"{listed(words)} removed{by}: mean {mean:.4g} {unit}, from first to last sample "
        f"{drift:+.4g} {unit}"
    )
    if wanted.below is not None:
        sentence += f"; the first and the last {1 / wanted.below:.3g} s hang on its ends"
    numbers = {"mean": mean, "drift": drift}
    told = report("remove", sentence, series.values[:], rest, unit, numbers)
    return Rest(series._replace(values=rest), slow, told)


def _check(frequency: float, side: str, series: Series, shown: str) -> None:
    """Make sure that a filter has something to work on."""
    low, high = 1 / ((len(series.values) - 1) * series.dt), 1 / (2 * series.dt)
    if not low <= frequency < high:
        bounds = f"at least {low:.6g} Hz, one period in the record, and below {high:.6g} Hz"
        sentence = f"`remove.{side}` must be {bounds}, half its rate; not {frequency:.6g} Hz"
        raise fault(shown, sentence)
