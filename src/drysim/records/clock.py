"""Times as loggers write them: units in names, epochs, days of Excel, dates and times of day.

A time column holds either numbers or clock readings. Numbers have the unit in their header
(`t [ms]`, `time_ms`); without one, values as of an epoch or of Excel's dates identify
themselves, and all others are seconds. Clock readings are times of day, with the date in the
same cell or in a column of its own; they count in seconds from the midnight before the first
row, so that records of one day share their time axis.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime
from functools import lru_cache
from math import inf, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drysim.units import is_common_unit

DAY = 86400.0
"""Seconds of a day."""

# Numbers.


UNIT_WORDS = {
    "s": ("s", "sec", "secs", "second", "seconds", "sekunde", "sekunden"),
    "ms": ("ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds"),
    "us": ("us", "µs", "μs", "usec", "usecs", "micros", "microsec", "microsecond"),
    "ns": ("ns", "nsec", "nanos", "nanosec", "nanosecond", "nanoseconds"),
    "min": ("min", "minute", "minutes", "minuten"),
    "h": ("hours", "stunden"),
}
UNIT_BY_WORD = {word: unit for unit, names in UNIT_WORDS.items() for word in names}
UNIT_BY_WORD["microseconds"] = "us"

NAMES_OF_TIME = re.compile(
    r"(?i)(t|ts|time|timestamp|datetime|date|datum|clock|epoch|elapsed|uptime|zeit\w*|uhrzeit"
    r"|temps|tiempo|tempo|abs\w*time|rel\w*time)(?![a-z]).*|(date|time|system|local|utc|gps|elapsed"
    r"|test|x)[ _]?(time|zeit)\b.*"
)
"""Names of a column of times; a word of `UNIT_WORDS` is one, too."""

EPOCHS = {"s": 1e9, "ms": 1e12, "us": 1e15, "ns": 1e18}
"""Smallest time since 1970 in each unit that is taken as one: September 2001; the greatest is
four times that, in 2096."""

EXCEL_DAYS = 25_569.0, 73_051.0
"""Days since 1900, as Excel counts them, from 1970 to 2100."""

MAX_EXCEL_STEP = 1e-4
"""Steps of Excel's days are below this: 8.64 s; as seconds they would be above 10 kHz."""


def unit_in_name(name: str) -> str:
    """Return the unit of time at the end of a column's name, as in `time_ms`; empty without."""
    *before, last = re.split(r"[\s_.,/-]+", name.strip().lower())
    if before:
        return UNIT_BY_WORD.get(last, "") if NAMES_OF_TIME.fullmatch(before[0]) else ""
    # Alone, `s` may be a displacement, `NS` a direction and `Min` a statistic.
    return "" if last in ("s", "ns", "us", "min") else UNIT_BY_WORD.get(last, "")


def is_time_name(name: str) -> bool:
    """Return whether a column is named as times are."""
    return bool(NAMES_OF_TIME.fullmatch(name.strip()) or unit_in_name(name))


def unit_of_values(t: NDArray[np.float64]) -> str:
    """Return the unit that identifies itself by its values; empty for any other numbers.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Times without a unit, NaN where one is missing.
    """
    there = t[~np.isnan(t)]
    low, high = (float(there.min()), float(there.max())) if len(there) > 1 else (0.0, inf)
    for unit, first in EPOCHS.items():
        if first <= low and high < 4 * first:
            return unit
    is_excel = EXCEL_DAYS[0] <= low and high < EXCEL_DAYS[1]
    return "d" if is_excel and abs(float(np.median(np.diff(there)))) < MAX_EXCEL_STEP else ""


# Clock readings.


CLOCK = re.compile(
    r"(?:(?P<date>[^:]*?[^:\s,])(?:T|,?\s+))?"
    r"(?P<hour>\d{1,4}):(?P<minute>\d\d):(?P<second>\d\d)"
    r"(?:[.,](?P<fraction>\d{1,12})|:(?P<milli>\d{3}))?"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>Z|UTC|[+-]\d\d(?::?\d\d)?)?",
    re.ASCII,
)
"""A time of day to the second, with or without a date."""

MINUTES = re.compile(
    r"(?P<minute>\d{1,4}):(?P<second>\d\d)[.,](?P<fraction>\d{1,12})", re.ASCII
)
"""Minutes and seconds, as Excel shows times of day below a second."""

HOUR_AND_MINUTE = re.compile(r"(?:.*\D)?\d{1,2}:\d\d", re.ASCII)
"""A time that may be hours and minutes, or minutes and seconds."""

DATE_FORMATS = (
    "%Y-%m-%d", "%Y/%m/%d", "%Y.%m.%d", "%Y%m%d", "%d.%m.%Y", "%d/%m/%Y", "%m/%d/%Y",
    "%d-%m-%Y", "%m-%d-%Y", "%d.%m.%y", "%d/%m/%y", "%m/%d/%y", "%y/%m/%d", "%d-%m-%y",
    "%y-%m-%d", "%d-%b-%Y", "%d %b %Y", "%d-%B-%Y", "%d %B %Y", "%b %d %Y", "%b %d, %Y",
    "%B %d, %Y", "%d-%b-%y", "%a %b %d %Y", "%d. %B %Y", "%Y-%j",
)  # fmt: skip
"""Forms of a date, for `datetime.strptime`."""

MAX_DATE_LENGTH = 40
"""Characters of a date; longer text is none."""


class Clock(NamedTuple):
    """How the clock readings of a column are written, and the day from which they count."""

    date_format: str = ""
    """Form of the dates; empty without dates."""
    first_day: int = 0
    """Proleptic ordinal of the first row's date."""

    def seconds(self, text: str) -> float:
        """Return the seconds from midnight of the first day; NaN for anything else."""
        reading = CLOCK.fullmatch(text)
        if reading is None:
            return _seconds_of_minutes(text) if not self.date_format else nan
        date, hour, minute, second, fraction, milli, half, zone = reading.groups()
        h, m, s = int(hour), int(minute), int(second)
        if half:
            if not 1 <= h <= 12:
                return nan
            h = h % 12 + (12 if half[0] in "Pp" else 0)
        if m > 59 or s > 60 or (h > 23 and date):
            return nan
        days = self.days(date or "") if date or self.date_format else 0.0
        seconds = 3600 * h + 60 * m + s + float(f"0.{fraction or milli or 0}")
        return DAY * days + seconds - (_zone_offset(zone) if zone else 0.0)

    def days(self, date: str) -> float:
        """Return the days of a date from the first one; NaN for anything else."""
        ordinal = date_ordinal(date, self.date_format) if self.date_format else None
        return nan if ordinal is None else float(ordinal - self.first_day)


def _seconds_of_minutes(text: str) -> float:
    reading = MINUTES.fullmatch(text)
    if reading is None or int(reading["second"]) > 59:
        return nan
    return (
        60 * int(reading["minute"]) + int(reading["second"]) + float(f"0.{reading['fraction']}")
    )


def _zone_offset(zone: str) -> float:
    """Return the offset of a time zone from UTC [s]."""
    if zone in ("Z", "UTC"):
        return 0.0
    digits = zone[1:].replace(":", "").ljust(4, "0")
    offset = 3600.0 * int(digits[:2]) + 60.0 * int(digits[2:])
    return -offset if zone[0] == "-" else offset


@lru_cache(maxsize=256)
def date_ordinal(text: str, form: str) -> int | None:
    """Return the proleptic ordinal of a date; None if it does not have the form."""
    try:
        return datetime.strptime(text, form).toordinal()
    except ValueError:
        return None


def find_clock(first: str, last: str) -> Clock | None:
    """Return how clock readings are written, from those of the first and the last row.

    Returns None if the first one is none.
    """
    begin, end = CLOCK.fullmatch(first), CLOCK.fullmatch(last)
    if begin is None:
        return Clock() if MINUTES.fullmatch(first) else None
    if begin["date"] is None:
        return Clock()
    return find_dates(begin["date"], (end["date"] if end else None) or begin["date"])


def find_dates(first: str, last: str) -> Clock | None:
    """Return the form of dates from those of the first and the last row; None if there is none.

    Where days and months can be exchanged, the record spans the shorter time: a record that
    passes midnight on 1 May ends on 2 May, not on 5 January.
    """
    spans: list[tuple[int, int, str, int]] = []
    for number, form in enumerate(DATE_FORMATS if len(first) <= MAX_DATE_LENGTH else ()):
        begin, end = date_ordinal(first, form), date_ordinal(last, form)
        if begin is not None and end is not None:
            spans.append((abs(end - begin), number, form, begin))
    if not spans:
        return None
    _, _, form, day = min(spans)
    return Clock(form, day)


def across_midnight(t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times of day that rise across midnight, a fall by more than half a day."""
    return t + DAY * np.concatenate(([0.0], np.cumsum(np.diff(t) < -DAY / 2)))


def clock_resolution(texts: Sequence[str]) -> float:
    """Return the unit of the last digit of clock readings [s]."""
    matches = [CLOCK.fullmatch(text) or MINUTES.fullmatch(text) for text in texts]
    groups = [match.groupdict() for match in matches if match]
    digits = [len(group["fraction"] or group.get("milli") or "") for group in groups]
    return float(10.0 ** -max(digits, default=0))


def is_unit(unit: str) -> bool:
    """Return whether a unit is one of time."""
    return is_common_unit(unit, "s") or unit.strip().lower() in UNIT_BY_WORD
