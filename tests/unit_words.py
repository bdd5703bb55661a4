"""Independent parser of the units above the columns of a text file. It imports nothing from `martensite.logs`.

It claims a unit only if it finds one of its table in a heading (`Load (N)`, `T/K`, `t_ms`, `x in mm`) or in a row of
units. Values that the package reads must be the numbers of the file times the factor of the claimed unit.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

G = 9.80665
UNITS: dict[str, tuple[str, float, float]] = {
    **{
        "s": ("s", 1.0, 0.0),
        "sec": ("s", 1.0, 0.0),
        "Sec": ("s", 1.0, 0.0),
        "second": ("s", 1.0, 0.0),
        "ms": ("s", 1e-3, 0.0),
    },
    **{"us": ("s", 1e-6, 0.0), "µs": ("s", 1e-6, 0.0), "min": ("s", 60.0, 0.0), "h": ("s", 3600.0, 0.0)},
    **dict.fromkeys(("°C", "degC", "deg_C", "Deg C", "deg C", "C"), ("K", 1.0, 273.15)),
    **dict.fromkeys(("°F", "degF", "F"), ("K", 5.0 / 9.0, 273.15 - 160.0 / 9.0)),
    **{"K": ("K", 1.0, 0.0), "N": ("N", 1.0, 0.0), "mN": ("N", 1e-3, 0.0), "kN": ("N", 1e3, 0.0)},
    **{"g": ("N", 1e-3 * G, 0.0), "kg": ("N", G, 0.0), "lbf": ("N", 0.45359237 * G, 0.0)},
    **{"Pa": ("Pa", 1.0, 0.0), "kPa": ("Pa", 1e3, 0.0), "MPa": ("Pa", 1e6, 0.0), "GPa": ("Pa", 1e9, 0.0)},
    **{"psi": ("Pa", 6894.757293168, 0.0), "ksi": ("Pa", 6894757.293168, 0.0), "bar": ("Pa", 1e5, 0.0)},
    **{"m": ("m", 1.0, 0.0), "cm": ("m", 1e-2, 0.0), "mm": ("m", 1e-3, 0.0), "um": ("m", 1e-6, 0.0)},
    **{"µm": ("m", 1e-6, 0.0), "in": ("m", 0.0254, 0.0), "mil": ("m", 2.54e-5, 0.0)},
    **{"%": ("1", 1e-2, 0.0), "microstrain": ("1", 1e-6, 0.0), "V": ("V", 1.0, 0.0), "mV": ("V", 1e-3, 0.0)},
    **{"A": ("A", 1.0, 0.0), "mA": ("A", 1e-3, 0.0), "uA": ("A", 1e-6, 0.0), "ADC": ("A", 1.0, 0.0)},
    **{"W": ("W", 1.0, 0.0), "mW": ("W", 1e-3, 0.0), "W/g": ("W/kg", 1e3, 0.0), "ohm": ("ohm", 1.0, 0.0)},
    **{
        "Volt": ("V", 1.0, 0.0),
        "Volts": ("V", 1.0, 0.0),
        "Ampere": ("A", 1.0, 0.0),
        "deg": ("rad", np.pi / 180.0, 0.0),
        "rad": ("rad", 1.0, 0.0),
    },
}
"""Unit -> SI unit, factor, offset."""
IMPLIED = {"X_Value": UNITS["s"], "millis": UNITS["ms"]}
"""Heading that implies its unit."""
NUMBER = r"[+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
LABELLED = re.compile(rf"([A-Za-z_]\w*)\s*[:=]\s*({NUMBER})")
SIGNS = ("\t", ";", ",", "|", None)
LINES_ABOVE = 8
SHORTEST = 5


@dataclass(frozen=True)
class Words:
    """Column with its claimed units, and its numbers with a decimal point, a decimal comma and thousands."""

    claims: frozenset[tuple[str, float, float]]
    notations: tuple[Any, ...]

    def allows(self, si: str, values: Iterable[float]) -> bool:
        """Return whether values equal the numbers of the file in a claimed unit."""
        own = np.asarray([x for x in values if np.isfinite(x)])
        return any(unit == si and self._holds(own, factor, offset) for unit, factor, offset in self.claims)

    def _holds(self, own: Any, factor: float, offset: float) -> bool:
        possible = np.sort(np.concatenate([[0.0, 1.0], *self.notations])) * factor + offset
        at = np.clip(np.searchsorted(possible, own), 1, len(possible) - 1)
        apart = np.minimum(np.abs(possible[at] - own), np.abs(possible[at - 1] - own))
        return float(np.mean(apart <= 1e-6 * np.abs(own) + 1e-9 * factor)) > 0.95

    def allows_times(self, times: Sequence[float]) -> bool:
        """Return whether the usual step of times equals the step of the file in a claimed unit."""
        step, own = find_step(np.asarray(times)), [find_step(x) for x in self.notations]
        seconds = [factor for unit, factor, _ in self.claims if unit == "s"]
        return any(0.4 < step / (x * factor) < 2.5 for x in own if x > 0.0 for factor in seconds)


def find_step(times: Any) -> float:
    """Return a short step of times; 0 without a rise. Usual steps are longer if rows were left out."""
    steps = np.diff(times[np.isfinite(times)])
    return float(np.quantile(steps[steps > 0.0], 0.1)) if np.any(steps > 0.0) else 0.0


def read_words(raw: bytes) -> dict[int, Words]:
    """Return the claims of a text file by column number from 1; empty without a table."""
    lines = [line for line in re.split(r"\r\n|\r|\n", decode(raw)) if line.strip()]
    pairs = [one for line in lines if (one := LABELLED.findall(line))]
    if 2 * len(pairs) > len(lines) and len(pairs[0]) > 1:
        heads = Counter(tuple(name for name, _ in one) for one in pairs).most_common(1)[0][0]
        rows = [[text for _, text in one] for one in pairs if tuple(name for name, _ in one) == heads]
        return _gather([list(heads)], rows)
    signals = dict(re.findall(r"^Sig(\d+)\s+(.+?)\s*$", "\n".join(lines), re.MULTILINE))
    sign = max(SIGNS, key=lambda one: _count_numbers(_split(lines, one)))
    split = _split(lines, sign)
    widths = Counter(len(row) for row in split if is_data(row))
    if not widths:
        return {}
    width = widths.most_common(1)[0][0]
    rows = [k for k, row in enumerate(split) if len(row) == width and is_data(row)]
    first = next((k for k, after in zip(rows, rows[2:], strict=False) if after - k <= 2), None)
    if first is None or len(rows) < SHORTEST:
        return {}
    heads = [line for line in lines[max(0, first - LINES_ABOVE) : first] if not re.match(r"Sig\d", line)]
    above = [_split_head(line, sign, width) for line in heads]
    above += [[signals.get(str(k + 1), "") for k in range(width)]] if signals else []
    above = [row for row in above if row and not any(map(is_number, row))]
    return _gather(above, [split[k] for k in rows])


def decode(raw: bytes) -> str:
    """Return the text of a file in UTF-16 if it has many zero bytes, otherwise in UTF-8 or cp1252."""
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return raw.decode("utf-16", "replace")
    if 3 * raw.count(0) > len(raw):
        return raw.decode("utf-16-le", "replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


def is_number(cell: str) -> bool:
    """Return whether a cell is a number, with or without a unit."""
    return re.fullmatch(rf"\s*{NUMBER}\s*[A-Za-z°%]*\s*", cell) is not None


def is_data(row: Sequence[str]) -> bool:
    """Return whether most filled cells are numbers."""
    filled = [cell for cell in row if cell.strip()]
    return bool(filled) and 2 * sum(map(is_number, filled)) > len(filled)


def find_units(cell: str, alone: bool) -> set[tuple[str, float, float]]:
    """Return the units in a heading; `alone` if the whole cell can be a unit."""
    text = re.sub(r"^[#%]\s*(?=\w)", "", cell.strip())
    found = re.findall(r"[\[(]\s*([^\])]+?)\s*[\])]", text)
    found += re.findall(r"(?:/|\sin\s|_)\s*([A-Za-zµ°%]+)(?:_(?:median|mean|max|min))?$", text)
    found += re.findall(r"_\d+([A-Za-z]+)(?:_|$)", text)
    found += re.findall(r"\S\s+([A-Za-zµ°%]+)$", text) if re.fullmatch(r"(?!Channel|Deg)\S+ \S+", text) else []
    found += [text.strip("()[]")] if alone else []
    return {UNITS[one] for one in found if one in UNITS} | ({IMPLIED[text]} if text in IMPLIED else set())


def parse_numbers(cells: Sequence[str]) -> tuple[Any, ...]:
    """Return the readable numbers of cells in each notation: decimal point, decimal comma, thousands."""
    texts = [re.sub(r"[^\d.,eE+-].*$", "", cell.strip().strip('"').strip()) for cell in cells]
    notations = (("", ""), (",", "."), (",", ""), (".", ""))
    found: list[Any] = []
    for old, new in notations:
        values = list[float]()
        for text in texts:
            try:
                values.append(float(text.replace(old, new) if old else text))
            except ValueError:
                continue
        found.append(np.asarray(values))
    return tuple(found)


def _split(lines: Sequence[str], sign: str | None) -> list[list[str]]:
    if sign == ",":
        rows = [next(csv.reader([line.replace("\0", "")])) for line in lines]
        return [[cell.strip('"') for cell in (row[0].split(",") if len(row) == 1 else row)] for row in rows]
    return [[cell.strip('"') for cell in line.split(sign)] for line in lines]


def _count_numbers(rows: Sequence[Sequence[str]]) -> float:
    """Return the score of the most frequent row width; cells with numbers raise the score of a row."""
    scores: Counter[int] = Counter()
    for row in rows:
        if is_data(row):
            numbers = sum(map(is_number, row))
            scores[len(row)] += int(100 * numbers * numbers / len([c for c in row if c.strip()]))
    return max(scores.values(), default=0)


def _split_head(line: str, sign: str | None, width: int) -> list[str]:
    """Return the cells of a line above the table; empty if it does not have `width` cells."""
    text = re.sub(r"^[#%]\s*(?=\w)", "", line)
    splits = [_split([text], one)[0] for one in (sign, ",", ";", "\t")]
    for row in [*splits, re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", text)]:
        while len(row) > width and row[-1].strip() in ("", "Comment"):
            row.pop()
        if len(row) == width:
            return row
    return []


def _gather(above: Sequence[Sequence[str]], rows: Sequence[Sequence[str]]) -> dict[int, Words]:
    words: dict[int, Words] = {}
    filled = [[c.strip().strip("()[]") for c in row if c.strip()] for row in above]
    unit_rows = [2 * sum(c in UNITS for c in row) >= len(row) and len(above) > 1 for row in filled]
    first = -2 if unit_rows and unit_rows[-1] else -1  # a row of units, and the headings above it; else the headings
    above, unit_rows = above[first:], unit_rows[first:]
    for place in range(len(rows[0])):
        claims: set[tuple[str, float, float]] = set()
        for row, alone in zip(above, unit_rows, strict=True):
            claims |= find_units(row[place], alone)
        cells = [row[place] for row in rows]
        behind = Counter(re.sub(rf"^\s*{NUMBER}\s*", "", cell).strip() for cell in cells).most_common(1)[0][0]
        claims |= {UNITS[behind]} if behind in UNITS else set()
        words[place + 1] = Words(frozenset(claims), parse_numbers(cells))
    return words
