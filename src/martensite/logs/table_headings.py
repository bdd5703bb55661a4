"""Headings, units and labels above a table of numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from martensite.logs.cells import find_kind, is_missing
from martensite.logs.heading_guess import find_listed

SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", "pipe": "|", "whitespace": ""}
COMMENT = "#%!;/"
"""Comment signs, which may precede headings."""
ABOVE = 6
"""Lines above the numbers that are searched for headings and units."""
LONGEST = 20_000
"""Largest length of a line that may have another separator than the table."""
Row = tuple[int, list[str]]
"""Row number in the file, and cells."""
Above = dict[int | str, str]
"""Column index -> unit; label -> number among units (a Rigol's `Increment`)."""

_HEADING = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")
_SIGNAL = re.compile(r"^Sig(\d+)\s+(.+)$")


def split_heading(line: str) -> list[str]:
    """Return headings separated by blanks, each with its unit in brackets."""
    return _HEADING.findall(line)


def find_headings(
    above: Sequence[Row], texts: Mapping[int, str], width: int, sign: str | None
) -> tuple[list[str], Above, set[int]]:
    """Return the headings, units, and their row numbers, from the lines above the numbers."""
    signals = _list_signals(above, width)
    if signals:
        return signals, {}, {number for number, _ in above}
    units: dict[int, str] = {}
    values: dict[int, str] = {}
    alone: list[str] = []
    used: set[int] = set()
    for number, cells in reversed(above[-ABOVE:]):
        row = _fit_width(cells, texts.get(number, ""), width, sign)
        if row is None:
            continue
        plain, numbers = _split_row(row)
        if not used and _is_unit_row(plain):
            units, values, used = dict(plain), numbers, {number}
            alone = [] if all(find_listed(cell) for _, cell in plain) else row
        elif plain and len(plain) >= 2 * len(numbers):
            labelled: Above = {row[place].strip().lower(): text for place, text in values.items()}
            return row, {**units, **labelled}, used | {number}
    if alone:  # a row with words and no row above it holds headings: `time,V`
        return alone, {}, used
    return [""] * width, {**units}, used


def _list_signals(above: Sequence[Row], width: int) -> list[str]:
    """Return the names of numbered signals, a line each, with empty names for spoilt lines; empty without signals."""
    signals = {int(m[1]): m[2] for _, row in above if (m := _SIGNAL.match(" ".join(row)))}
    return [signals.get(k + 1, "") for k in range(width)] if 0 < max(signals, default=0) <= width else []


def _split_row(row: Sequence[str]) -> tuple[list[tuple[int, str]], dict[int, str]]:
    """Return the words of a row without brackets, and its numbers, by place."""
    filled = [(place, cell.strip()) for place, cell in enumerate(row) if cell.strip()]
    numbers = {place: cell for place, cell in filled if is_numeric(cell)}
    return [(place, cell.strip("()[] ")) for place, cell in filled if place not in numbers], numbers


def _is_unit_row(cells: Sequence[tuple[int, str]]) -> bool:
    """Return whether at least half of the cells are units, and none a further name."""
    listed = [cell for _, cell in cells if find_listed(cell) or cell in ("Sequence", "-")]
    return bool(listed) and len(listed) * 2 >= len(cells) and not _names_more(cells)


def is_numeric(cell: str) -> bool:
    """Return whether a cell is a number, a missing sample, or a spoilt number such as `10q.5`."""
    text = cell.strip().strip('"')
    spoilt = text.lstrip("+-")[:1].isdigit() and 2 * sum(map(str.isdigit, text)) >= len(text)
    return spoilt or is_missing(cell) or bool(find_kind(cell))


def names_columns(row: Sequence[str], width: int) -> bool:
    """Return whether a row of a table names columns or their units, or one signal of a calorimeter."""
    return bool(_SIGNAL.match(" ".join(row))) or (len(row) == width and not any(map(is_numeric, row)))


def _names_more(cells: Sequence[tuple[int, str]]) -> bool:
    """Return whether a row of symbols, `t;T;F`, has names rather than units."""
    return all(len(cell) == 1 for _, cell in cells) and "t" in [cell for _, cell in cells]


def _fit_width(cells: Sequence[str], line: str, width: int, sign: str | None) -> list[str] | None:
    """Return a line above the table as `width` cells, with any separator; None if impossible."""
    text = line.strip().lstrip(COMMENT + '"').strip()
    splits = [list(cells)]
    if 0 < len(line) < LONGEST:
        splits += [text.split(sign) if sign else [], split_heading(text), re.split(r"\s{2,}|\t", text)]
        splits += [text.split(other) for other in ",;\t|"] + [text.split()]
    for row in splits:
        while len(row) > width and row[-1].strip().lower() in ("", "comment"):
            row = row[:-1]
        if len(row) == width:
            first = row[0].strip()
            return [first.lstrip(COMMENT + " ") or first, *row[1:]]  # a lone % is a unit
    short = next((row for row in splits if len(row) == width - 1 > 1), None)
    return None if short is None else ["", *short]  # row names, or a date before its time, have no heading


def collect_said(rows: Sequence[Row]) -> dict[str, str]:
    """Return label -> value of the lines above the table."""
    labels: dict[str, str] = {}
    for _, row in rows:
        cells = [part.strip() for cell in row for part in re.split(r":\s", cell, maxsplit=1) if part.strip()]
        if len(cells) > 1 and not find_kind(cells[0]):
            labels.setdefault(cells[0].strip("#% :=").lower(), cells[1])
    return labels
