"""Text files of unknown layout: encoding, separator, and prefixes of serial monitors."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from martensite.logs.cells import find_kind, is_missing
from martensite.logs.open_files import Line, read_lines, split_cells
from martensite.logs.plain_rows import read_regular
from martensite.logs.raw_table import LOOKED_AT, RawTable, find_table
from martensite.logs.table_headings import SEPARATORS

NAMED = {"tab": "tabs", "semicolon": "semicolons", "comma": "commas", "pipe": "|", "whitespace": "blanks"}
"""Separator -> name in messages."""
LONGEST = 2000
"""Largest length of a line that is searched for labels."""

_SERIAL = re.compile(r"^(\d\d:\d\d:\d\d[.,:]\d+) -> ?")
_CLOCK = re.compile(r"(\d\d:\d\d:\d\d[.,:]\d+)[\t;, ]")
_LABEL = re.compile(
    r"\s*([A-Za-z_°][\w °/%.()\[\]-]*?)\s*[:=]\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([A-Za-z%°Ωµ]{0,6})\s*"
)


def read_text_table(path: Path, separator: str = "auto") -> RawTable:
    """Return the table of a text file of unknown layout.

    Raises:
        DataError: the file is missing, empty, no text, or has no table of numbers.
    """
    lines, encoding = read_lines(path)
    lines = _expand_serial(lines)
    looked = [line for _, line in lines[:: max(1, len(lines) // LOOKED_AT)]]
    chosen = _choose_separator(looked) if separator == "auto" else separator
    form, sign = ("text", f"separated by {NAMED[chosen]}", encoding), SEPARATORS[chosen]

    def find(lines: Sequence[Line]) -> RawTable:
        return find_table(path, [(n, split_cells(line, sign)) for n, line in lines], form, chosen, lines)

    return read_regular(lines, sign, find) or find(lines)


def _expand_serial(lines: Sequence[Line]) -> Sequence[Line]:
    """Return lines of a serial monitor with the clock as a cell, and labels (`temp:25.1 I:0.4`) as headings."""
    lines = _split_clock(lines)
    labels = [_find_labels(line) for _, line in lines[:: max(1, len(lines) // 50)]]
    counts = Counter(tuple((name, unit) for name, _, unit in one) for one in labels if one)
    names, count = next(iter(counts.most_common(1)), ((), 0))
    if not count or count * 2 < len(labels):
        return lines
    head = "\t".join(f"{name} [{unit}]" if unit else name for name, unit in names)
    rows = [(n, "\t".join(number for _, number, _ in _find_labels(line)) or line) for n, line in lines]
    return [(0, head), *((n, row) for n, row in rows if row.count("\t") == len(names) - 1 or len(names) == 1)]


def _split_clock(lines: Sequence[Line]) -> Sequence[Line]:
    """Return lines with the clock of a serial monitor as a cell; unchanged lines without clocks."""
    if sum(_SERIAL.match(line) is not None for _, line in lines[:LOOKED_AT]) * 2 <= len(lines[:LOOKED_AT]):
        return lines
    sign = next((s for s in "\t;," if s in _SERIAL.sub("", lines[len(lines) // 2][1])), " ")
    return [(n, _SERIAL.sub(rf"\1{sign}", line)) for n, line in lines]


def _find_labels(line: str) -> list[tuple[str, str, str]]:
    """Return the names, numbers and units of a line of labelled numbers, and its clock as `time`; else empty."""
    if len(line) > LONGEST:
        return []
    if clock := _CLOCK.match(line):
        labels = _find_labels(line[clock.end() :])
        return [("time", clock[1], ""), *labels] if labels else []
    parts = [part for part in re.split(r"[,;\t]|\s{2,}|(?<=\d)\s+(?=[A-Za-z_]\w*\s*[:=])", line) if part.strip()]
    matches = [_LABEL.fullmatch(part) for part in parts]
    return [(m[1], m[2], m[3]) for m in matches if m is not None] if all(matches) else []


def _is_value(cell: str) -> bool:
    return bool(find_kind(cell)) or is_missing(cell)


def _is_single(lines: Sequence[str]) -> bool:
    """Return whether lines have no comma, or follow a heading without one."""
    first = next((k for k, line in enumerate(lines) if find_kind(line)), 0)
    return not any("," in line for line in lines[first:]) or (first > 0 and "," not in lines[first - 1])


def _choose_separator(looked: Sequence[str]) -> str:
    """Return the separator that gives the most numeric cells in rows of equal width."""
    best, most = "whitespace", 0.0
    for name, sign in SEPARATORS.items():
        rows = [split_cells(line, sign) for line in looked if sign in line]
        widths = Counter(len(row) for row in rows if any(map(find_kind, row)))
        if not widths or (sign and set(widths) == {1}):
            continue
        width = widths.most_common(1)[0][0]
        score = sum(sum(map(_is_value, row)) / width for row in rows if len(row) == width)
        if not sign and width == 1 and not _is_single(looked):
            score *= 0.45  # `1,5` is more likely two cells than a decimal comma
        if score > most * 1.001:
            best, most = name, score
    return best
