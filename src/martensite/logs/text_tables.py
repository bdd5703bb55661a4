"""Text files of unknown layout: encoding, separator, and what serial monitors write in front of numbers."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from martensite.base.errors import DataError
from martensite.base.files import MOST_LOG, read_unpacked
from martensite.logs.cells import find_kind, is_missing
from martensite.logs.raw_table import LOOKED_AT, RawTable, find_table
from martensite.logs.sheets import describe_unreadable
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
    with describe_unreadable(path):
        raw = read_unpacked(path, MOST_LOG)
    text, encoding = _decode(raw, path)
    lines = [(n, line) for n, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines:
        raise DataError(f"`{path.name}` is empty: it holds no rows.")
    lines = _expand_serial(lines)
    chosen = _choose_separator([line for _, line in lines]) if separator == "auto" else separator
    sign = SEPARATORS[chosen]
    rows = [(n, _split_line(line, sign)) for n, line in lines]
    texts = dict(lines)
    return find_table(path, rows, ("text", f"separated by {NAMED[chosen]}", encoding), chosen, texts)


def _decode(raw: bytes, path: Path) -> tuple[str, str]:
    """Return the text and its encoding, empty for UTF-8."""
    wide = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}.get(raw[:2], "")
    if not wide and len(raw) > 3 and raw[:200].count(0) * 3 > len(raw[:200]):
        wide = "utf-16-le" if raw[1] == 0 else "utf-16-be"
    if wide:
        return raw.decode(wide, "replace").lstrip("\ufeff"), "UTF-16"
    odd = sum(byte < 9 or 13 < byte < 27 for byte in raw[:4096])
    if odd * 50 > len(raw[:4096]):
        raise DataError(f"`{path.name}` is not a text file, nor of another kind that is known by its ending.")
    try:
        return raw.decode("utf-8-sig").replace("\0", " "), ""
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace").replace("\0", " "), "cp1252"


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


def _split_line(line: str, sign: str) -> list[str]:
    if not sign:
        return line.split()
    if line.count('"') % 2:
        return [line]  # an open quote
    if '"' not in line:
        return line.split(sign)
    try:
        return next(csv.reader([line], delimiter=sign, skipinitialspace=True))
    except (csv.Error, StopIteration):
        return line.split(sign)


def _is_single(lines: Sequence[str]) -> bool:
    """Return whether lines have no comma, or a heading without one stands above them."""
    first = next((k for k, line in enumerate(lines) if find_kind(line)), 0)
    return not any("," in line for line in lines[first:]) or (first > 0 and "," not in lines[first - 1])


def _choose_separator(lines: Sequence[str]) -> str:
    """Return the separator with which most cells of most lines, in rows of equal width, are values."""
    looked = lines[:: max(1, len(lines) // LOOKED_AT)]
    best, most = "whitespace", 0.0
    for name, sign in SEPARATORS.items():
        rows = [_split_line(line, sign) for line in looked if sign in line]
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
