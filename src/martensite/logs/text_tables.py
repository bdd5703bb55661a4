"""Text files of unknown layout: encoding, separator, and what serial monitors write in front of numbers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from martensite.logs.cells import find_kind, is_missing
from martensite.logs.open_files import read_lines, split_cells
from martensite.logs.raw_table import LOOKED_AT, RawTable, find_table
from martensite.logs.table_headings import SEPARATORS

NAMED = {"tab": "tabs", "semicolon": "semicolons", "comma": "commas", "pipe": "|", "whitespace": "blanks"}
"""Separator -> what it is called."""
LONGEST = 2000
"""Letters of a line in which labels are looked for."""

_SERIAL = re.compile(r"^(\d\d:\d\d:\d\d[.,:]\d+) -> ?")
_LABEL = re.compile(
    r"\s*([A-Za-z_°][\w °/%.()\[\]-]*?)\s*[:=]\s*([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([A-Za-z%°Ωµ]{0,6})\s*"
)


def read_text_table(path: Path, separator: str = "auto") -> RawTable:
    """Read a text file of unknown layout.

    Raises:
        DataError: it is missing, empty, no text, or holds no table of numbers.
    """
    lines, encoding = read_lines(path)
    lines = _expand_serial(lines)
    chosen = _choose_separator([line for _, line in lines]) if separator == "auto" else separator
    sign = SEPARATORS[chosen]
    rows = [(n, split_cells(line, sign)) for n, line in lines]
    texts = dict(lines)
    return find_table(path, rows, ("text", f"separated by {NAMED[chosen]}", encoding), chosen, texts)


def _expand_serial(lines: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Lines of a serial monitor: the clock in front as a cell, labels of numbers (`temp:25.1 I:0.4`) as headings."""
    if sum(_SERIAL.match(line) is not None for _, line in lines[:LOOKED_AT]) * 2 > len(lines[:LOOKED_AT]):
        sign = next((s for s in "\t;," if s in _SERIAL.sub("", lines[len(lines) // 2][1])), " ")
        lines = [(n, _SERIAL.sub(rf"\1{sign}", line)) for n, line in lines]
    labels = [_find_labels(line) for _, line in lines[:: max(1, len(lines) // 50)]]
    known = Counter(tuple((name, unit) for name, _, unit in one) for one in labels if one)
    if not known or known.most_common(1)[0][1] * 2 < len(labels):
        return lines
    names, width = known.most_common(1)[0][0], len(known.most_common(1)[0][0])
    head = "\t".join(f"{name} [{unit}]" if unit else name for name, unit in names)
    found = [(n, "\t".join(number for _, number, _ in _find_labels(line)) or line) for n, line in lines]
    return [(0, head), *((n, line) for n, line in found if line.count("\t") == width - 1 or width == 1)]


def _find_labels(line: str) -> list[tuple[str, str, str]]:
    """Return the names, numbers and units of a line that holds nothing else."""
    if len(line) > LONGEST:
        return []
    parts = [part for part in re.split(r"[,;\t]|\s{2,}|(?<=\d)\s+(?=[A-Za-z_]\w*\s*[:=])", line) if part.strip()]
    found = [_LABEL.fullmatch(part) for part in parts]
    return [(m[1], m[2], m[3]) for m in found if m is not None] if all(found) else []


def _is_single(lines: Sequence[str]) -> bool:
    """Return whether lines have no comma, or a heading without one stands above them."""
    first = next((k for k, line in enumerate(lines) if find_kind(line)), 0)
    return not any("," in line for line in lines[first:]) or (first > 0 and "," not in lines[first - 1])


def _choose_separator(lines: Sequence[str]) -> str:
    """Return the separator with which most cells of most lines, in rows of equal width, are values."""
    looked = lines[:: max(1, len(lines) // LOOKED_AT)]
    best, most = "whitespace", 0.0
    for name, sign in SEPARATORS.items():
        rows = [split_cells(line, sign) for line in looked if sign in line]
        widths = Counter(len(row) for row in rows if any(map(find_kind, row)))
        if not widths or (sign and set(widths) == {1}):
            continue
        width = widths.most_common(1)[0][0]
        score = sum(sum(bool(find_kind(c)) or is_missing(c) for c in row) / width for row in rows if len(row) == width)
        if not sign and width == 1 and not _is_single(looked):
            score *= 0.45  # `1,5` is rather two cells than one with a decimal comma
        if score > most * 1.001:
            best, most = name, score
    return best
