"""Times of a table: from numbers, clocks, dates and stamps, past midnight and counter overflows.

Rows of a coarse clock, which stands still for several rows, are spread evenly until the next tick. Other rows that
repeat the time before are omitted. A time that runs back for no such reason is an error.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from martensite.base import units
from martensite.base.errors import DataError, UnitError
from martensite.logs.cells import DAY, Numbers
from martensite.logs.heading_guess import find_listed, part_heading
from martensite.logs.raw_table import LeftOut, RawColumn, RawTable, count_rows

WRAPS = {"a counter of 16 bits": 2.0**16, "a counter of 32 bits": 2.0**32}
PARTS = {"": 1.0, " of milliseconds": 1e3, " of microseconds": 1e6}
COARSE = 0.2
"""Fraction of repeated times above which the clock is coarse."""


@dataclass(frozen=True)
class TableTimes:
    """Times of the kept rows."""

    times: Numbers
    """[s]"""
    rows: NDArray[Any]
    """Indices of the rows."""
    start: float | None
    """Absolute time of zero [s] since the first day of the calendar; below 86 400 the time of day."""
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]


def find_start(raw: RawTable) -> tuple[Numbers | None, float | None]:
    """Return the clock of the rows [s], from dates, times of day and milliseconds; and its first value."""
    kinds = {kind: next((c for c in raw.columns if c.kind == kind), None) for kind in ("stamp", "date", "clock")}
    stamp, day, clock = kinds["stamp"], kinds["date"], kinds["clock"]
    if stamp is None and clock is None:
        return None, None
    seconds = stamp.numbers if stamp is not None else pass_midnight(clock.numbers, day is not None)
    if day is not None and stamp is None:
        seconds = seconds + day.numbers
    thousandths = next((c for c in raw.columns if is_part_of_clock(raw, c)), None)
    if thousandths is not None:
        seconds = seconds + thousandths.numbers / 1000.0
    finite = seconds[np.isfinite(seconds)]
    return seconds, float(finite[0]) if finite.size else None


def is_part_of_clock(raw: RawTable, column: RawColumn) -> bool:
    """Return whether a column has the milliseconds of an adjacent clock."""
    if column.kind != "number" or column.heading.lower() not in ("milliseconds", "ms", "millisecond"):
        return False
    clocked = any(one.kind in ("clock", "stamp") for one in raw.columns)
    return clocked and bool(np.nanmax(column.numbers) < 1000.0 and np.nanmin(column.numbers) >= 0.0)


def pass_midnight(seconds: Numbers, dated: bool) -> Numbers:
    """Return times of day continued past midnight, or past noon for a 12-hour clock."""
    if dated:
        return seconds
    filled = np.where(np.isfinite(seconds), seconds, 0.0)
    falls = np.concatenate([[0.0], np.diff(filled)])
    return seconds + DAY * np.cumsum(falls < -0.5 * DAY)


def build_times(raw: RawTable, times: Numbers, start: float | None, counted: bool) -> TableTimes:
    """Return increasing times.

    Args:
        raw: table.
        times: times of its rows [s].
        start: absolute time of the first row, if known.
        counted: whether they come from a number, whose counter may overflow.

    Raises:
        DataError: there are too few times, or they run back.
    """
    notes: list[str] = []
    rows = np.flatnonzero(np.isfinite(times))
    left = count_rows("no time", raw.numbers[~np.isfinite(times)])
    if rows.size < 2:
        raise DataError(f"`{raw.name}`: its column of time holds {rows.size} times; at least 2 are needed.")
    seconds = times[rows]
    if counted:
        seconds, word = mend_wrap(seconds)
        notes += [f"Time falls back once or more: taken for {word} that began anew, and put right."] if word else []
    steps = np.diff(seconds)
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        row = raw.numbers[int(rows[back[0] + 1])]
        raise DataError(
            f"`{raw.name}`: time runs backwards at row {row}, from {seconds[back[0]]:.9g} s to "
            f"{seconds[back[0] + 1]:.9g} s, and no counter explains it; save the parts "
            "before and after as separate files."
        )
    again = np.flatnonzero(steps == 0.0) + 1
    if again.size > COARSE * seconds.size and seconds[-1] > seconds[0]:
        seconds = spread_rows(seconds)
        notes.append("The clock stands still over several rows: they are spread evenly until it goes on.")
        again = np.flatnonzero(np.diff(seconds) <= 0.0) + 1
    left += count_rows("the time of the row before again", raw.numbers[rows[again]])
    keep = np.setdiff1d(np.arange(seconds.size), again)
    if keep.size < 2:
        raise DataError(f"`{raw.name}`: all rows have the same time, {seconds[0]:.9g} s.")
    return TableTimes(seconds[keep], rows[keep], start, left, tuple(notes))


def mend_wrap(times: Numbers) -> tuple[Numbers, str]:
    """Return the times of a counter after overflows, and its description; empty if there are none."""
    back = np.flatnonzero(np.diff(times) < 0.0)
    if not back.size:
        return times, ""
    usual = float(np.median(np.abs(np.diff(times))))
    for word, most in WRAPS.items():
        for unit, part in PARTS.items():
            whole = most / part
            steps = times[back + 1] - times[back] + whole
            if times.max() < whole * 1.0001 and np.all(steps > 0.0) and np.all(steps <= 20.0 * usual):
                turns = np.zeros(times.size)
                turns[back + 1] = whole
                return times + np.cumsum(turns), word + unit
    return times, ""


def spread_rows(times: Numbers) -> Numbers:
    """Return the times of a coarse clock, with rows of equal time spread evenly."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(times) > 0.0]))
    rows = np.arange(times.size)
    last = times[first[-1]] + (times.size - first[-1]) * (times[first[-1]] - times[first[0]]) / max(
        1, first[-1] - first[0]
    )
    return np.interp(rows, np.append(first, times.size), np.append(times[first], last))


STEP = re.compile(r"ts|dt|(?:sample|sampling)[ _]?(?:time|interval|period)|step[ _]?time", re.IGNORECASE)
"""Headings of a column that repeats the sample time."""


def count_blocks(times: Numbers) -> int:
    """Return the number of blocks in which a time restarts at its first value; 1 if it does not."""
    finite = times[np.isfinite(times)]
    restarts = finite[1:][np.diff(finite) < 0.0]
    return 1 + int(restarts.size) if restarts.size and bool(np.all(restarts == finite[0])) else 1


def find_step(columns: Iterable[tuple[str, str, Numbers]]) -> float | None:
    """Return the sample time [s] that a column repeats; columns are (heading, unit, numbers)."""
    for heading, unit, numbers in columns:
        words, spelling = part_heading(heading)
        if STEP.fullmatch(words.strip()) and numbers.size and np.all(numbers == numbers[0]) and numbers[0] > 0.0:
            try:
                listed = find_listed(unit or spelling)
                return float(numbers[0]) * units.find_conversion("s" if listed in ("", "1") else listed, "s")[0]
            except UnitError:
                continue
    return None


_INTERVAL = re.compile(
    r"(?:sampl\w*|record\w*|scan)[ _-]*(?:interval|period|time)|.*increment|delta[ _]?x|dt", re.IGNORECASE
)
_RATE = re.compile(r"(?:sampl\w*|scan|acquisition)[ _-]*(?:rate|freq\w*)", re.IGNORECASE)
_AMOUNT = re.compile(r"([\d.,]+(?:[eE][+-]?\d+)?)\s*(.*)")


def find_interval(texts: Mapping[str, str]) -> float | None:
    """Return the sample time [s] named above a table; None if there is none."""
    for word, text in texts.items():
        plain = re.sub(r"\s*[\[(].*", "", word)
        for pattern, wanted in ((_INTERVAL, "s"), (_RATE, "Hz")):
            amount = _AMOUNT.fullmatch(text.strip())
            if not pattern.fullmatch(plain) or amount is None:
                continue
            inner = re.search(r"[\[(]\s*(.*?)\s*[\])]", word)
            spelling = amount[2] or (inner[1] if inner else wanted)
            try:
                size = (
                    float(amount[1].replace(",", "."))
                    * units.find_conversion(find_listed(spelling) or spelling, wanted)[0]
                )
            except (ValueError, UnitError):
                continue
            if 0.0 < size < math.inf:
                return size if wanted == "s" else 1.0 / size
    return None
