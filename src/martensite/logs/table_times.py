"""Times of a table: from numbers, clocks, dates and stamps, past midnight and past the wrap of a counter.

A clock that stands still for several rows is too coarse for them: they are spread evenly until it goes on. Rows that
repeat the time before are left out otherwise. A time that runs back without such a reason is an error.
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
"""Share of rows that repeat the time before, from which on the clock is coarse."""


@dataclass(frozen=True)
class TableTimes:
    """Times of the rows that are kept."""

    times: Numbers
    """[s]"""
    kept: NDArray[Any]
    """Indices of the rows."""
    start: float | None
    """Absolute time of zero, in seconds since the first day of the calendar; of the day alone where below 86 400."""
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]


def find_start(raw: RawTable) -> tuple[Numbers | None, float | None]:
    """Clock of the rows, in seconds, from dates, times of day and milliseconds beside them; and its first."""
    kinds = {kind: next((c for c in raw.columns if c.kind == kind), None) for kind in ("stamp", "date", "clock")}
    stamp, day, clock = kinds["stamp"], kinds["date"], kinds["clock"]
    if stamp is None and clock is None:
        return None, None
    seconds = stamp.numbers if stamp is not None else pass_midnight(clock.numbers, day is not None)  # pyright: ignore
    if day is not None and stamp is None:
        seconds = seconds + day.numbers
    thousandths = next((c for c in raw.columns if is_part_of_clock(raw, c)), None)
    if thousandths is not None:
        seconds = seconds + thousandths.numbers / 1000.0
    known = seconds[np.isfinite(seconds)]
    return seconds, float(known[0]) if known.size else None


def is_part_of_clock(raw: RawTable, column: RawColumn) -> bool:
    """Return whether a column holds the milliseconds of the clock beside it."""
    if column.kind != "number" or column.heading.lower() not in ("milliseconds", "ms", "millisecond"):
        return False
    clocked = any(one.kind in ("clock", "stamp") for one in raw.columns)
    return clocked and bool(np.nanmax(column.numbers) < 1000.0 and np.nanmin(column.numbers) >= 0.0)


def pass_midnight(seconds: Numbers, dated: bool) -> Numbers:
    """Return the times of day that go on behind midnight, and, of a clock of twelve hours, behind noon."""
    if dated:
        return seconds
    filled = np.where(np.isfinite(seconds), seconds, 0.0)
    falls = np.concatenate([[0.0], np.diff(filled)])
    return seconds + DAY * np.cumsum(falls < -0.5 * DAY)


def build_times(raw: RawTable, times: Numbers, start: float | None, counted: bool) -> TableTimes:
    """Return the times that increase from row to row.

    Args:
        raw: the table.
        times: of its rows [s].
        start: absolute time of the first row, if it is known.
        counted: whether they come from a number, whose counter may wrap.

    Raises:
        DataError: there are too few, or they run back.
    """
    notes: list[str] = []
    known = np.flatnonzero(np.isfinite(times))
    left = count_rows("no time", [raw.numbers[k] for k in np.flatnonzero(~np.isfinite(times))])
    if known.size < 2:
        raise DataError(f"`{raw.name}`: its column of time holds {known.size} times; at least 2 are needed.")
    found = times[known]
    if counted:
        found, word = mend_wrap(found)
        notes += [f"Time falls back once or more: taken for {word} that began anew, and put right."] if word else []
    steps = np.diff(found)
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        row = raw.numbers[int(known[back[0] + 1])]
        raise DataError(
            f"`{raw.name}`: time runs backwards at row {row}, from {found[back[0]]:.9g} s to {found[back[0] + 1]:.9g} "
            "s, and no counter explains it; save the parts before and after as separate files."
        )
    again = np.flatnonzero(steps == 0.0) + 1
    if again.size > COARSE * found.size and found[-1] > found[0]:
        found = spread_rows(found)
        notes.append("The clock stands still over several rows: they are spread evenly until it goes on.")
        again = np.flatnonzero(np.diff(found) <= 0.0) + 1
    left += count_rows("the time of the row before again", [raw.numbers[int(known[k])] for k in again])
    keep = np.setdiff1d(np.arange(found.size), again)
    if keep.size < 2:
        raise DataError(f"`{raw.name}`: all rows have the same time, {found[0]:.9g} s.")
    return TableTimes(found[keep], known[keep], start, left, tuple(notes))


def mend_wrap(times: Numbers) -> tuple[Numbers, str]:
    """Return the times of a counter that began anew at its highest number, and in words which it is."""
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
    """Return the times of a coarse clock, with rows of one time spread evenly until the next."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(times) > 0.0]))
    rows = np.arange(times.size)
    last = times[first[-1]] + (times.size - first[-1]) * (times[first[-1]] - times[first[0]]) / max(
        1, first[-1] - first[0]
    )
    return np.interp(rows, np.append(first, times.size), np.append(times[first], last))


STEP = re.compile(r"ts|dt|(?:sample|sampling)[ _]?(?:time|interval|period)|step[ _]?time", re.IGNORECASE)
"""Headings of a column that repeats the time between rows."""


def count_blocks(times: Numbers) -> int:
    """Return in how many blocks a time begins again at its first value; 1 if it does not."""
    known = times[np.isfinite(times)]
    begun = known[1:][np.diff(known) < 0.0]
    return 1 + int(begun.size) if begun.size and bool(np.all(begun == known[0])) else 1


def find_step(columns: Iterable[tuple[str, str, Numbers]]) -> float | None:
    """Return the time between rows [s] that a column repeats; columns are (heading, unit, numbers)."""
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


def find_interval(said: Mapping[str, str]) -> float | None:
    """Return the time between samples [s] that the lines above a table name; None if they do not."""
    for word, text in said.items():
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
