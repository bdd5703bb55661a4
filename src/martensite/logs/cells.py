"""Cells of laboratory tables as numbers: decimal commas, thousands, clocks, dates, overflows, units.

A clock is seconds of its day, a date seconds since the first day of the calendar, a stamp their sum. If the order of
day and month is ambiguous, the day comes first.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from martensite.logs.heading_guess import find_listed

GAPS = ("", "nan", "na", "n/a", "null")
"""Cells of a missing sample, in lower case."""
Numbers = NDArray[np.float64]
OVERFLOW = 9.9e36
"""Instruments write 9.9e37 for readings out of range."""
TINIEST = 1e-300
"""Smaller numbers count as zero, because their squares and quotients leave the range of floats."""
DAY = 86_400.0
MISSING = {
    *(*GAPS, "-", "--", "---", "none", "ol", "ovld", "over", "overload", "#n/a", "#num!", "#div/0!", "∞", "-∞"),
    *("+over", "-over", "err", "error", "open", "invalid", "no data", "inf", "-inf", "+inf", "infinity"),
}
"""Cells of a missing or out-of-range sample, in lower case."""

_NUMBER = r"[+\-−]?(?:\d+(?:[.,'’]\d{3})*(?:[.,]\d*)?|[.,]\d+)(?:[eEdD][+\-]?\d+)?"
_CLOCK = r"(\d{1,3}):([0-5]?\d)(?::([0-5]?\d)(?:[.,:](\d+))?|[.](\d+))?(?:\s*([AaPp])\.?[Mm]\.?)?"
_DATE = r"(?:\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.]\d{2,4}|\d{1,2}[- ][A-Za-z]{3,9}[- ]\d{2,4})"
_PATTERNS = {
    "date": re.compile(_DATE),
    "number": re.compile(_NUMBER),
    "clock": re.compile(_CLOCK),
    "stamp": re.compile(rf"({_DATE})[T ,;]\s*({_CLOCK})(?:\s*(?:Z|UTC|[+-]\d\d:?\d\d))?"),
    "quantity": re.compile(rf"({_NUMBER})\s*([^\d\s.,;:+\-][^\d\s;:]{{0,11}}(?: ?[A-Za-z°]{{1,7}})?)"),
}
_FIRST = frozenset("+-.0123456789")
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


@dataclass(frozen=True)
class NumberStyle:
    """Notation of the numbers of a table."""

    comma: bool = False
    """Decimal comma."""
    thousands: str = ""
    """Thousands separator."""
    unsure: bool = False
    """True if `1,234` is ambiguous."""


@dataclass(frozen=True)
class ReadCells:
    """Column of cells as numbers."""

    kind: str
    """`number`, `clock`, `date`, `stamp`, or `text` if less than half of the cells are any of these."""
    numbers: Numbers
    """NaN for missing or unreadable cells."""
    wrong: list[int]
    """Indices of cells with other content."""
    unit: str = ""
    """Unit that stands behind the numbers."""
    unsure: bool = False
    """True if day and month could not be told apart."""


def is_missing(cell: str) -> bool:
    """Return whether a cell stands for a sample that is missing."""
    return cell.strip().strip('"').lower() in MISSING


def find_kind(cell: str) -> str:
    """Which of the patterns a cell follows; empty for none."""
    text = cell.strip().strip('"').strip()
    if text[:1] in _FIRST and text[-1:].isdigit() and "_" not in text:
        try:
            float(text)
        except ValueError:
            pass
        else:
            return "number"  # most cells, at a fraction of the time
    kind = next((kind for kind, pattern in _PATTERNS.items() if pattern.fullmatch(text)), "")
    if kind != "quantity":
        return kind
    match = _PATTERNS["quantity"].fullmatch(text)
    return kind if match is not None and find_listed(match[2]) else ""


_ENGLISH = re.compile(r",.*[.,]")
"""Comma before a point or another comma."""
_GERMAN = re.compile(r"\..*,")
_POINTS = re.compile(r"\..*\.")
_LIKE_THOUSANDS = re.compile(r"[+\-−]?[1-9]\d{0,2},\d{3}")


def find_style(cells: Iterable[str]) -> NumberStyle:
    """Return the notation of the numbers in some cells."""
    numbers = [text for text in map(str.strip, cells) if _PATTERNS["number"].fullmatch(text)]
    joined = "\n".join(numbers)
    quote = re.search("['’]", joined)
    if quote:
        return NumberStyle("," in joined, quote[0])
    if "," not in joined:
        several = bool(_POINTS.search(joined))
        return NumberStyle(several, "." if several else "")
    if _ENGLISH.search(joined):
        return NumberStyle(False, ",")
    mixed = bool(_GERMAN.search(joined))
    unsure = not mixed and all(_LIKE_THOUSANDS.fullmatch(text) for text in numbers if "," in text)
    if unsure and "." in joined:
        return NumberStyle(False, ",")
    return NumberStyle(True, "." if mixed else "", unsure)


def read_cells(cells: Sequence[str], style: NumberStyle) -> ReadCells:
    """Return a column of cells as numbers; its kind is that of most cells."""
    plain = _read_plain(cells, style)
    if plain is not None:
        return ReadCells("number", plain, [])
    kinds = [find_kind(cell) for cell in cells[:: max(1, len(cells) // 500)] if not is_missing(cell)]
    kind = max(set(kinds), key=kinds.count) if kinds else "text"
    if kind == "number" and kinds.count("quantity") * 2 > len(kinds):
        kind = "quantity"
    if kind in ("", "text") or kinds.count(kind) * 2 < len(kinds):
        wrong = [k for k, cell in enumerate(cells) if not is_missing(cell)]
        return ReadCells("text", np.full(len(cells), math.nan), wrong)
    if kind in ("date", "stamp"):
        return _read_dates(cells, kind)
    numbers, wrong = parse_cells(cells, style, kind)
    unit = _find_common_unit(cells) if kind == "quantity" else ""
    return ReadCells("number" if kind == "quantity" else kind, numbers, wrong, unit)


def parse_cells(cells: Sequence[str], style: NumberStyle, kind: str) -> tuple[Numbers, list[int]]:
    """Return cells of a kind as numbers, and the indices of cells that are neither of this kind nor missing."""
    parse = {"number": _to_number, "clock": _to_clock, "quantity": _to_quantity}[kind]
    plain = _read_plain(cells, style) if kind == "number" else None
    if plain is not None:
        return plain, []
    numbers, wrong = np.full(len(cells), math.nan), list[int]()
    for k, cell in enumerate(cells):
        try:
            numbers[k] = parse(cell, style)
        except ValueError:
            if not is_missing(cell):
                wrong.append(k)
    return clear_extremes(numbers), wrong


def _read_plain(cells: Sequence[str], style: NumberStyle) -> Numbers | None:
    """Return cells read by Python's fast float parser; None if one of them has another form."""
    text = "".join(cells)
    if style.thousands or "_" in text or not text.isascii():  # Python would read 1_000, and digits of any script
        return None
    try:
        return clear_extremes(np.array([float(cell.replace(",", ".") if style.comma else cell) for cell in cells]))
    except ValueError:
        return None


def clear_extremes(numbers: Numbers) -> Numbers:
    """Return numbers with NaN for overflows and zero for tiny values."""
    return np.where(np.abs(numbers) < TINIEST, 0.0, np.where(np.abs(numbers) < OVERFLOW, numbers, math.nan))


def _to_number(cell: str, style: NumberStyle) -> float:
    text = cell.strip().strip('"').replace("−", "-")
    text = text.replace(style.thousands, "") if style.thousands else text
    text = text.replace(",", ".") if style.comma else text
    if "_" in text or not text.isascii():
        raise ValueError
    return float(re.sub("[dD]", "e", text))


def _to_quantity(cell: str, style: NumberStyle) -> float:
    match = _PATTERNS["quantity"].fullmatch(cell.strip().strip('"'))
    return _to_number(cell if match is None else match[1], style)


def _find_common_unit(cells: Sequence[str]) -> str:
    matches = [_PATTERNS["quantity"].fullmatch(cell.strip().strip('"')) for cell in cells[:200]]
    units = [one[2].strip() for one in matches if one is not None]
    return max(set(units), key=units.count) if units else ""


def _to_clock(cell: str, style: NumberStyle) -> float:
    match = _PATTERNS["clock"].fullmatch(cell.strip().strip('"'))
    if match is None:
        raise ValueError
    return _count_seconds(*match.groups())


def _count_seconds(
    first: str, second: str, third: str | None, part: str | None, short: str | None, half: str | None
) -> float:
    """Return the seconds of the day of 17:27:33.5 or 5:27 PM, or elapsed seconds of 27:33.5."""
    if third is None and short is not None:
        return 60.0 * int(first) + int(second) + float(f"0.{short}")
    hours = int(first)
    if half is not None:
        hours = hours % 12 + (12 if half in "pP" else 0)
    return 3600.0 * hours + 60.0 * int(second) + int(third or 0) + float(f"0.{part or 0}")


def _read_dates(cells: Sequence[str], kind: str) -> ReadCells:
    matched = [_PATTERNS[kind].fullmatch(cell.strip().strip('"')) for cell in cells]
    texts = [None if one is None else one[1] if kind == "stamp" else one[0] for one in matched]
    days, unsure = _count_days([text for text in texts if text is not None])
    numbers, wrong, rest = np.full(len(cells), math.nan), list[int](), iter(days)
    for k, one in enumerate(matched):
        if one is not None:
            numbers[k] = next(rest) * DAY + (_count_seconds(*one.groups()[2:8]) if kind == "stamp" else 0.0)
        elif not is_missing(cells[k]):
            wrong.append(k)
    return ReadCells(kind, numbers, wrong, "", unsure)


def _count_days(texts: Sequence[str]) -> tuple[list[float], bool]:
    """Return days of the calendar, NaN for other texts, and whether the order of day and month is ambiguous."""
    parts = {text: tuple(re.split(r"[-/. ]", text)) for text in dict.fromkeys(texts)}
    month_first, unsure = _find_order([part for part in parts.values() if len(part[0]) < 3 and part[1].isdigit()])
    days = {text: _find_day(part, month_first) for text, part in parts.items()}
    return [days[text] for text in texts], unsure


def _find_order(written: Sequence[tuple[str, ...]]) -> tuple[bool, bool]:
    """Return true for a month before its day, and true if the order is ambiguous."""
    over = [any(int(part[k]) > 12 for part in written) for k in (0, 1)]
    month_first = over[1] and not over[0]
    unsure = bool(written) and not any(over) and any(part[0] != part[1] for part in written)
    if unsure and len(written) > 1:  # successive days are not months apart
        spans = [np.ptp([_find_day(part, first) for part in written]) for first in (False, True)]
        month_first, unsure = bool(spans[1] < spans[0]), bool(spans[0] == spans[1])
    return month_first, unsure


def _find_day(parts: tuple[str, ...], month_first: bool) -> float:
    if len(parts[0]) == 4:
        year, month, day = parts
    else:
        day, month, year = (parts[1], parts[0], parts[2]) if month_first else parts
    number = (
        month if month.isdigit() else str(_MONTHS.index(month[:3].lower()) + 1 if month[:3].lower() in _MONTHS else 0)
    )
    try:
        return float(date(int(year) + (2000 if int(year) < 100 else 0), int(number), int(day)).toordinal())
    except ValueError:
        return math.nan
